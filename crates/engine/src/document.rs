//! The session being worked on: its history, its file, the folder its paths start from, and what keeps it from being lost.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::builtin;
use crate::keep::{Claim, Draft, Lock, Orphan, Slot, named, remove_leftovers};
use crate::run::Autosaver;
use crate::session::{self, Session, rebased};
use crate::undo::History;

/// The session that opens by default.
const SHIPPED: &str = "demo";

/// A session with its past and its place on disk.
pub struct Document {
    /// The session now and before.
    pub history: History,
    /// Its file; `None` for what comes with the program, until it is saved.
    pub path: Option<PathBuf>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    keeping: Option<Keeping>,
}

/// What keeps a document from being lost.
struct Keeping {
    autosaver: Autosaver,
    kept: Option<Arc<Session>>,
    lock: Option<Lock>,
    held_by: Option<String>,
}

impl Document {
    fn new(history: History, path: Option<PathBuf>, folder: PathBuf) -> Self {
        Self { history, path, folder, keeping: None }
    }

    /// Opens a session file.
    ///
    /// # Errors
    /// One line: the file, what is wrong with it, and where the version before it is.
    pub fn open(path: &Path) -> Result<Self, String> {
        let opened = session::open(path).map_err(|error| in_one_line(path, &error.to_string()))?;
        Ok(Self::new(History::new(opened.session), Some(opened.path), opened.folder))
    }

    /// The session that comes with the program.
    ///
    /// # Errors
    /// One line, should it not be readable.
    pub fn shipped() -> Result<Self, String> {
        let text = builtin::session(SHIPPED).ok_or("no session comes with this program")?;
        let session = session::parse(text).map_err(|error| error.to_string())?;
        Ok(Self::new(History::new(session), None, std::env::current_dir().unwrap_or_default()))
    }

    /// A session just made, which no file has yet. Its relative paths start from the present folder.
    pub fn begun(session: Session) -> Self {
        Self::new(History::unsaved(Arc::new(session)), None, std::env::current_dir().unwrap_or_default())
    }

    /// Unsaved work of a program that ended: one undo away from what its file holds, or without a file where that cannot be
    /// read.
    pub fn recovered(draft: &Draft) -> Self {
        let base = draft.of.as_deref().and_then(|of| session::open(of).ok());
        let session = Arc::clone(&draft.session);
        match base {
            Some(opened) => {
                let mut history = History::new(opened.session);
                history.step("recover unsaved work", session);
                Self::new(history, Some(opened.path), opened.folder)
            }
            None => Self::new(History::unsaved(session), None, draft.folder.clone()),
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
    /// When the folder cannot be written or the operating system refuses a thread: unsaved work is then not kept.
    pub fn keep_in(&mut self, autosaves: &Path) -> io::Result<()> {
        self.keeping = None;
        let (mut lock, mut held_by) = (None, None);
        if let Some(path) = &self.path {
            match Lock::claim(path) {
                Ok(Claim::Ours(claimed)) => {
                    remove_leftovers(path);
                    lock = Some(claimed);
                }
                Ok(Claim::Theirs(owner)) => held_by = Some(named(owner.as_ref())),
                // Where no lock can be written no session can be saved either.
                Err(_) => {}
            }
        }
        let slot = Slot::new(autosaves, self.path.as_deref())?;
        let kept = self.history.saved().cloned();
        let autosaver = Autosaver::start(slot)?;
        self.keeping = Some(Keeping { autosaver, kept, lock, held_by });
        Ok(())
    }

    /// Hands unsaved work to the background writer where it is new; made to be called after every edit, or once a frame.
    pub fn autosave(&mut self) {
        let present = self.history.present();
        let is_new = |keeping: &&mut Keeping| !keeping.kept.as_ref().is_some_and(|kept| Arc::ptr_eq(kept, present));
        let Some(keeping) = self.keeping.as_mut().filter(is_new) else { return };
        keeping.kept = Some(Arc::clone(present));
        if self.history.is_modified() {
            let (of, folder) = (self.path.as_deref().map(absolute), absolute(&self.folder));
            keeping.autosaver.keep(Draft { of, folder, session: Arc::clone(present) });
        } else {
            keeping.autosaver.clear();
        }
    }

    /// Like [`Document::autosave`], and waits until it lasts.
    ///
    /// # Errors
    /// One line when it could not be written.
    pub fn autosave_now(&mut self) -> Result<(), String> {
        self.autosave();
        self.keeping.as_ref().map_or(Ok(()), |keeping| keeping.autosaver.settle())
    }

    /// Gives up unsaved work.
    pub fn give_up(&mut self) {
        if let Some(keeping) = &self.keeping {
            keeping.autosaver.clear();
        }
    }

    /// Takes over unsaved work that was recovered into this document: kept here before it is forgotten there.
    ///
    /// # Errors
    /// One line when it cannot be kept here, or not be forgotten there; it is then found again next time.
    pub fn adopt(&mut self, orphan: Orphan) -> Result<(), String> {
        self.autosave_now()?;
        match &self.keeping {
            Some(_) => orphan.discard().map_err(|error| error.to_string()),
            None => Ok(()),
        }
    }

    /// Why unsaved work is not kept at the moment.
    pub fn autosave_error(&self) -> Option<String> {
        self.keeping.as_ref()?.autosaver.error()
    }

    /// The program that has the session's file open, where that is another.
    pub fn held_by(&self) -> Option<&str> {
        self.keeping.as_ref()?.held_by.as_deref()
    }

    /// Saves to `path`, which becomes the session's file. Relative paths of recordings, aircraft and channel maps keep
    /// meaning the same files. Unsaved work is kept aside until the file is written in full.
    ///
    /// # Errors
    /// One line when the file cannot be written, or another program has it open.
    pub fn save(&mut self, path: &Path) -> Result<(), String> {
        let claimed = self.claim_other(path)?;
        // The file is written whether or not this lasts.
        let _ = self.autosave_now();
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let (old, new) = (absolute(&self.folder), absolute(&folder));
        let failed = |error: session::SessionError| in_one_line(path, &error.to_string());
        if old == new {
            session::save(self.session(), path).map_err(failed)?;
        } else {
            session::save(&rebased(self.session(), &old, &new), path).map_err(failed)?;
            self.history.replace_all(|session| rebased(session, &old, &new));
        }
        self.history.mark_saved();
        self.path = Some(path.to_path_buf());
        self.folder = folder;
        let present = Arc::clone(self.history.present());
        if let Some(keeping) = &mut self.keeping {
            keeping.kept = Some(present);
            keeping.autosaver.clear();
            if let Some(lock) = claimed {
                keeping.lock = Some(lock);
                keeping.held_by = None;
            }
        }
        Ok(())
    }

    /// Takes hold of `path` where it is not ours yet.
    fn claim_other(&self, path: &Path) -> Result<Option<Lock>, String> {
        let Some(keeping) = &self.keeping else { return Ok(None) };
        let is_ours = self.path.as_deref().is_some_and(|own| absolute(own) == absolute(path));
        if is_ours && keeping.lock.is_some() {
            return Ok(None);
        }
        Lock::hold(path).map_err(|line| format!("{line}: choose another name"))
    }
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
