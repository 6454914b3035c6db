//! The session being worked on: its history, its file, the folder its paths start from, and what keeps it from being lost.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::autosave::{AbandonedAutosave, Autosave, AutosaveFile};
use crate::keep::{Lock, LockResult, describe_owner, hash_bytes, remove_leftovers};
use crate::run::Autosaver;
use crate::session::{self, Session, rebased};
use crate::undo::History;
use crate::{builtin, compare};

/// Time between two attempts to keep unsaved work where that could not be.
const RETRY: Duration = Duration::from_secs(2);

/// A session with its past and its place on disk.
pub struct Document {
    /// The session now and before.
    pub history: History,
    /// Its file; `None` for what comes with the program, until it is saved.
    pub path: Option<PathBuf>,
    /// Its name among those that come with the program, where it is one.
    pub shipped: Option<&'static str>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    keeping: Option<Keeping>,
    on_disk: OnDisk,
}

/// What is known of the session's file.
#[derive(Debug, Default)]
struct OnDisk {
    /// SHA-256 of its content when it was read or written here last.
    sha256: Option<String>,
    /// Whether that content is of somebody else's hand.
    is_theirs: bool,
    /// Whether `*.bak` holds a version that somebody else wrote, which no save may push out.
    backup_is_theirs: bool,
}

/// A session's file that somebody else has changed since it was read or written here.
#[derive(Clone, Debug)]
pub struct Changed {
    /// What differs, a line each: setting, here, there.
    pub differences: Vec<String>,
    /// SHA-256 of the file's content.
    sha256: String,
    /// What the file holds now; `None` where that is no session.
    theirs: Option<session::Opened>,
}

impl Changed {
    /// SHA-256 of the file's content: which version it is.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Whether the file's version can be taken.
    pub fn can_be_taken(&self) -> bool {
        self.theirs.is_some()
    }
}

/// What keeps a document from being lost.
struct Keeping {
    folder: PathBuf,
    /// The writer, or why there is none and when that was tried.
    autosaver: Result<Autosaver, (String, Instant)>,
    kept: Option<Arc<Session>>,
    lock: Option<Lock>,
    held_by: Option<String>,
}

impl Document {
    /// The flight that is shown where none is named.
    pub const SHIPPED: &'static str = "demo";

    fn new(history: History, path: Option<PathBuf>, folder: PathBuf) -> Self {
        Self { history, path, shipped: None, folder, keeping: None, on_disk: OnDisk::default() }
    }

    /// Opens a session file, or `builtin:` and the name of a session that comes with the program.
    pub fn open(path: &Path) -> Result<Self, String> {
        let shipped = session::shipped(path);
        if let Some(name) = builtin::sessions().into_iter().find(|name| shipped == Some(*name)) {
            return Self::open_shipped(name);
        }
        let opened = session::open(path).map_err(|error| in_one_line(path, &error.to_string()))?;
        Ok(Self::from_disk(History::new(opened.session), opened.path, opened.folder, opened.sha256))
    }

    fn from_disk(history: History, path: PathBuf, folder: PathBuf, sha256: String) -> Self {
        let on_disk = OnDisk { sha256: Some(sha256), ..OnDisk::default() };
        Self { on_disk, ..Self::new(history, Some(path), folder) }
    }

    /// The session that comes with the program.
    pub fn open_demo() -> Result<Self, String> {
        Self::open_shipped(Self::SHIPPED)
    }

    /// A session that comes with the program, by its name.
    pub fn open_shipped(name: &'static str) -> Result<Self, String> {
        let text = builtin::session(name).ok_or_else(|| format!("no session '{name}' comes with this program"))?;
        let session = session::parse(text).map_err(|error| error.to_string())?;
        let document = Self::new(History::new(session), None, std::env::current_dir().unwrap_or_default());
        Ok(Self { shipped: Some(name), ..document })
    }

    /// A session just made, which no file has yet. Its relative paths start from the present folder.
    pub fn start(session: Session) -> Self {
        Self::new(History::new_unsaved(Arc::new(session)), None, std::env::current_dir().unwrap_or_default())
    }

    /// Unsaved work of a program that ended: one undo away from what its file holds, or without a file where that cannot be
    /// read.
    pub fn recover(autosave: &Autosave) -> Self {
        let base = autosave.of.as_deref().and_then(|of| session::open(of).ok());
        let session = Arc::clone(&autosave.session);
        match base {
            Some(opened) => {
                let mut history = History::new(opened.session);
                history.step("recover unsaved work", session);
                Self::from_disk(history, opened.path, opened.folder, opened.sha256)
            }
            None => Self::new(History::new_unsaved(session), None, autosave.folder.clone()),
        }
    }

    /// The session as it is now.
    pub fn session(&self) -> &Session {
        self.history.present()
    }

    /// Takes hold of the session's file and keeps unsaved work in the folder `autosaves` from now on. A file that another program
    /// has open can be looked at and changed, and saved under another name.
    ///
    /// # Errors
    /// When the folder cannot be written or the operating system refuses a thread: unsaved work is then not kept, which
    /// [`Document::autosave_error`] says until it is.
    pub fn keep_in(&mut self, autosaves: &Path) -> io::Result<()> {
        self.keeping = None;
        let (mut lock, mut held_by) = (None, None);
        if let Some(path) = &self.path {
            match Lock::try_lock(path) {
                Ok(LockResult::Acquired(acquired)) => {
                    remove_leftovers(path);
                    lock = Some(acquired);
                }
                Ok(LockResult::Held(owner)) => held_by = Some(describe_owner(owner.as_ref())),
                // Where no lock can be written no session can be saved either.
                Err(_) => {}
            }
        }
        let started = start(autosaves, self.path.as_deref());
        let (outcome, autosaver) = match started {
            Ok(autosaver) => (Ok(()), Ok(autosaver)),
            Err(error) => {
                let line = format!("{}: {error}", autosaves.display());
                (Err(error), Err((line, Instant::now())))
            }
        };
        let (folder, kept) = (autosaves.to_path_buf(), self.history.saved().cloned());
        self.keeping = Some(Keeping { folder, autosaver, kept, lock, held_by });
        outcome
    }

    /// Hands unsaved work to the background writer where it is new; made to be called after every edit, or once a frame.
    pub fn autosave(&mut self) {
        let present = self.history.present();
        let is_new = |keeping: &&mut Keeping| !keeping.kept.as_ref().is_some_and(|kept| Arc::ptr_eq(kept, present));
        let Some(keeping) = self.keeping.as_mut().filter(is_new) else { return };
        keeping.try_again(self.path.as_deref());
        let Ok(autosaver) = &keeping.autosaver else { return };
        keeping.kept = Some(Arc::clone(present));
        if self.history.is_modified() {
            let (of, folder) = (self.path.as_deref().map(absolute), absolute(&self.folder));
            autosaver.keep(Autosave { of, folder, session: Arc::clone(present) });
        } else {
            autosaver.clear();
        }
    }

    /// Like [`Document::autosave`], and waits until it lasts.
    pub fn autosave_now(&mut self) -> Result<(), String> {
        self.autosave();
        match self.keeping.as_ref().map(|keeping| &keeping.autosaver) {
            Some(Ok(autosaver)) => autosaver.settle().map_err(String::from),
            Some(Err((line, _))) => Err(line.clone()),
            None => Ok(()),
        }
    }

    /// Gives up unsaved work.
    pub fn give_up(&mut self) {
        if let Some(Ok(autosaver)) = self.keeping.as_ref().map(|keeping| &keeping.autosaver) {
            autosaver.clear();
        }
    }

    /// Takes over unsaved work that was recovered into this document: kept here before it is forgotten there.
    ///
    /// # Errors
    /// One line when it cannot be kept here, or not be forgotten there; it is then found again next time.
    pub fn adopt(&mut self, abandoned: AbandonedAutosave) -> Result<(), String> {
        self.autosave_now()?;
        match &self.keeping {
            Some(_) => abandoned.discard().map_err(|error| error.to_string()),
            None => Ok(()),
        }
    }

    /// Why unsaved work is not kept at the moment.
    pub fn autosave_error(&self) -> Option<String> {
        match &self.keeping.as_ref()?.autosaver {
            Ok(autosaver) => autosaver.error(),
            Err((line, _)) => Some(line.clone()),
        }
    }

    /// The program that has the session's file open, where that is another.
    pub fn held_by(&self) -> Option<&str> {
        self.keeping.as_ref()?.held_by.as_deref()
    }

    /// What somebody else changed in the session's file since it was read or written here; `None` where its content is the same, or
    /// it is gone.
    pub fn changed_on_disk(&self) -> Option<Changed> {
        let path = self.path.as_deref()?;
        let bytes = doublet_core::load::read_bytes(path).ok()?;
        let sha256 = hash_bytes(&bytes);
        if self.on_disk.sha256.as_ref().is_none_or(|known| *known == sha256) {
            return None;
        }
        let (differences, theirs) = match session::open(path) {
            Err(error) => (vec![format!("it cannot be read now: {error}")], None),
            Ok(opened) => {
                let found = compare::settings(self.session(), &opened.session);
                let mut lines: Vec<_> =
                    found.unwrap_or_default().iter().map(compare::SettingDifference::line).collect();
                if lines.is_empty() {
                    lines.push("all settings are equal; only comments or order differ".to_owned());
                }
                (lines, Some(opened))
            }
        };
        Some(Changed { differences, sha256, theirs })
    }

    /// Takes the version that the file has, as a step that can be undone.
    pub fn take_theirs(&mut self, changed: Changed) {
        let Some(theirs) = changed.theirs else { return };
        self.history.step("load the version on disk", Arc::new(theirs.session));
        self.history.mark_saved();
        self.on_disk = OnDisk { sha256: Some(theirs.sha256), is_theirs: true, backup_is_theirs: false };
    }

    /// Saves to `path`, which becomes the session's file. Relative paths of recordings, aircraft and channel maps keep
    /// meaning the same files. Unsaved work is kept aside until the file is written in full. What somebody else wrote into another
    /// file that is replaced stays in its `*.bak`, however often this is saved.
    pub fn save(&mut self, path: &Path) -> Result<(), String> {
        let is_own = self.path.as_deref().is_some_and(|own| absolute(own) == absolute(path));
        if is_own && let Some(changed) = self.changed_on_disk() {
            let count = changed.differences.len();
            return Err(format!(
                "{} was changed on disk since it was opened ({count} differences): save under another name, or load that version",
                path.display()
            ));
        }
        let acquired = self.lock_other(path)?;
        // A file chosen by its name may be anybody's.
        let replaces_other = !is_own && path.exists();
        let keeps_theirs = is_own && self.on_disk.backup_is_theirs;
        let save = if keeps_theirs { session::save_without_backup } else { session::save };
        // The file is written whether or not this lasts.
        let _ = self.autosave_now();
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let (old, new) = (absolute(&self.folder), absolute(&folder));
        let failed = |error: session::SessionError| in_one_line(path, &error.to_string());
        if old == new {
            save(self.session(), path).map_err(failed)?;
        } else {
            save(&rebased(self.session(), &old, &new), path).map_err(failed)?;
            self.history.replace_all(|session| rebased(session, &old, &new));
        }
        self.history.mark_saved();
        self.path = Some(path.to_path_buf());
        self.folder = folder;
        let written = session::print(self.session()).ok().map(|text| hash_bytes(text.as_bytes()));
        let backup_is_theirs = keeps_theirs || replaces_other || self.on_disk.is_theirs;
        self.on_disk = OnDisk { sha256: written, is_theirs: false, backup_is_theirs };
        let present = Arc::clone(self.history.present());
        if let Some(keeping) = &mut self.keeping {
            keeping.kept = Some(present);
            if let Ok(autosaver) = &keeping.autosaver {
                autosaver.clear();
            }
            if let Some(lock) = acquired {
                keeping.lock = Some(lock);
                keeping.held_by = None;
            }
        }
        Ok(())
    }

    /// Takes hold of `path` where it is not ours yet.
    fn lock_other(&self, path: &Path) -> Result<Option<Lock>, String> {
        let Some(keeping) = &self.keeping else { return Ok(None) };
        let is_ours = self.path.as_deref().is_some_and(|own| absolute(own) == absolute(path));
        if is_ours && keeping.lock.is_some() {
            return Ok(None);
        }
        Lock::lock_for_writing(path).map_err(|line| format!("{line}: choose another name"))
    }
}

impl Keeping {
    /// Starts the writer where it could not be started and some time has passed.
    fn try_again(&mut self, path: Option<&Path>) {
        if self.autosaver.as_ref().is_err_and(|(_, tried)| tried.elapsed() >= RETRY) {
            self.autosaver = start(&self.folder, path)
                .map_err(|error| (format!("{}: {error}", self.folder.display()), Instant::now()));
        }
    }
}

fn start(autosaves: &Path, path: Option<&Path>) -> io::Result<Autosaver> {
    Autosaver::start(AutosaveFile::new(autosaves, path)?)
}

/// `message` with its file named once, without line breaks, and the version before it where there is one.
fn in_one_line(path: &Path, message: &str) -> String {
    let place = path.display().to_string();
    let message = message.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let message = if message.contains(&place) { message } else { format!("{place}: {message}") };
    let mut previous = path.as_os_str().to_owned();
    previous.push(".bak");
    let previous = PathBuf::from(previous);
    if session::open(&previous).is_ok() {
        format!("{message}; the version before it is {}", previous.display())
    } else {
        message
    }
}

/// `path` from the root; as it is where the system cannot say.
fn absolute(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_path_buf())
}
