//! Unsaved work, kept aside until it is saved or given up.
//!
//! Every open session has one file of its own in the folder of autosaves. Each holds a whole session, not a list of edits: a session
//! is a few kilobytes of text, so writing all of it costs no more than appending to a list would, and what is recovered depends on
//! nothing else, neither on the file it came from nor on the edits replaying to the same end.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::keep::{Lock, LockResult, remove_leftovers, replace};
use crate::session::{self, Session};

const FORMAT: &str = "doublet autosave";
const VERSION: u32 = 1;

/// Most open sessions of one name.
const SLOTS: usize = 1000;

/// The saved form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    session_file: Option<PathBuf>,
    folder: PathBuf,
    session: String,
}

/// Work to keep: a session and where it belongs.
#[derive(Clone, Debug, PartialEq)]
pub struct Autosave {
    /// Its file; `None` where it was never saved.
    pub of: Option<PathBuf>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    pub session: Arc<Session>,
}

/// A file for unsaved work that is ours alone.
#[derive(Debug)]
pub struct AutosaveFile {
    path: PathBuf,
    _lock: Lock,
}

/// Where unsaved work is kept: `$XDG_STATE_HOME/doublet/autosave`, by default below `~/.local/state`.
pub fn state_folder() -> PathBuf {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".local/state"));
    let base = std::env::var_os("XDG_STATE_HOME").or_else(|| std::env::var_os("LOCALAPPDATA")).map(PathBuf::from);
    base.or_else(home).unwrap_or_else(std::env::temp_dir).join("doublet").join("autosave")
}

impl AutosaveFile {
    /// A slot in `folder`, which is made where it is missing, named after the session file `of`.
    pub fn new(folder: &Path, of: Option<&Path>) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let stem = of.and_then(Path::file_stem).map_or("unnamed".into(), |stem| stem.to_string_lossy());
        for number in 1..SLOTS {
            let path = folder.join(format!("{stem}-{number}.toml"));
            if path.exists() {
                continue;
            }
            if let LockResult::Acquired(lock) = Lock::try_lock(&path)? {
                // It may have been written and abandoned since we looked.
                if !path.exists() {
                    return Ok(Self { path, _lock: lock });
                }
            }
        }
        Err(io::Error::other(format!("{} is full: recover or discard what is there", folder.display())))
    }

    /// Keeps a autosave; it lasts once this returns.
    ///
    /// # Errors
    /// When it cannot be written; what was kept before is then untouched.
    pub fn write(&self, autosave: &Autosave) -> io::Result<()> {
        let file = File {
            format: FORMAT.to_owned(),
            version: VERSION,
            session_file: autosave.of.clone(),
            folder: autosave.folder.clone(),
            session: session::print(&autosave.session).map_err(io::Error::other)?,
        };
        replace(&self.path, toml::to_string_pretty(&file).map_err(io::Error::other)?.as_bytes())
    }

    /// Forgets what is kept.
    pub fn clear(&self) -> io::Result<()> {
        match std::fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

/// Unsaved work of a program that ended without saving it.
#[derive(Debug)]
pub struct AbandonedAutosave {
    /// The work.
    pub autosave: Autosave,
    /// When it was kept.
    pub kept: SystemTime,
    slot: AutosaveFile,
}

impl AbandonedAutosave {
    /// Forgets it for good.
    pub fn discard(self) -> io::Result<()> {
        self.slot.clear()
    }
}

/// Unsaved work in `folder` that no running program owns, newest first, and one line for every file that cannot be read. Work
/// that its session file holds too was saved after all and is removed.
pub fn abandoned_autosaves(folder: &Path) -> (Vec<AbandonedAutosave>, Vec<String>) {
    let (mut found, mut unreadable) = (Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        if hidden || path.extension().is_none_or(|ending| ending != "toml") {
            continue;
        }
        let Ok(LockResult::Acquired(lock)) = Lock::try_lock(&path) else { continue };
        let slot = AutosaveFile { path, _lock: lock };
        remove_leftovers(&slot.path);
        match read(&slot.path) {
            Ok(None) => {}
            Ok(Some((autosave, kept))) => {
                let saved = autosave.of.as_deref().and_then(|of| session::open(of).ok());
                if saved.is_some_and(|saved| saved.session == *autosave.session) {
                    // One that stays behind is found again next time.
                    let _ = slot.clear();
                } else {
                    found.push(AbandonedAutosave { autosave, kept, slot });
                }
            }
            Err(line) => unreadable.push(format!("{}: {line}", slot.path.display())),
        }
    }
    found.sort_by_key(|abandoned| std::cmp::Reverse(abandoned.kept));
    (found, unreadable)
}

/// What a file keeps and since when; `None` once it is gone.
fn read(path: &Path) -> Result<Option<(Autosave, SystemTime)>, String> {
    let text = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        text => text.map_err(|error| error.to_string())?,
    };
    let kept = path.metadata().and_then(|about| about.modified()).map_err(|error| error.to_string())?;
    let file: File = toml::from_str(&text).map_err(|error| error.message().to_owned())?;
    if file.format != FORMAT || file.version > VERSION {
        return Err(format!("{} version {} is not understood: update doublet", file.format, file.version));
    }
    let session = Arc::new(session::parse(&file.session).map_err(|error| error.to_string())?);
    Ok(Some((Autosave { of: file.session_file, folder: file.folder, session }, kept)))
}
