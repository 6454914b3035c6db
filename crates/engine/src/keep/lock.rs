//! One owner for every file: a lock file beside it that the system lets go of when its holder dies.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

/// How often a lock file that vanishes under our hands is made again.
const TRIES: usize = 20;

/// The program that holds a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// Its process.
    pub pid: u32,
    /// The machine it runs on.
    pub host: String,
    /// Since when, nanoseconds after 1970-01-01 UTC.
    since_ns: u64,
}

impl Owner {
    fn this_program() -> Self {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        Self { pid: std::process::id(), host, since_ns: since.as_nanos().try_into().unwrap_or(u64::MAX) }
    }

    /// When it took hold of the file.
    pub fn since(&self) -> SystemTime {
        SystemTime::UNIX_EPOCH + Duration::from_nanos(self.since_ns)
    }

    /// Whether it may still run: on this machine its process exists; of another machine nothing is known.
    fn may_live(&self) -> bool {
        let processes = Path::new("/proc");
        self.host != gethostname::gethostname().to_string_lossy()
            || !processes.is_dir()
            || processes.join(self.pid.to_string()).exists()
    }
}

impl std::fmt::Display for Owner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {} on {}", self.pid, self.host)
    }
}

/// A file that is ours until this is dropped, or this program dies.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    _file: File,
}

/// What came of asking for a file.
#[derive(Debug)]
pub enum LockResult {
    /// It is ours.
    Acquired(Lock),
    /// Another program has it; `None` where it cannot be said which.
    Held(Option<Owner>),
}

impl Lock {
    /// Asks for `target`, by a lock on the file `.NAME.lock` beside it. A file that a dead program left is taken over: the system
    /// lets go of a lock when its holder ends, however it ends. Where the system knows no locks, the process named in the file
    /// decides.
    pub fn try_lock(target: &Path) -> io::Result<LockResult> {
        let path = lock_path(target);
        for _ in 0..TRIES {
            let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(LockResult::Held(read_owner(&mut file))),
                Err(TryLockError::Error(_)) => {
                    if let Some(owner) = read_owner(&mut file).filter(Owner::may_live) {
                        return Ok(LockResult::Held(Some(owner)));
                    }
                }
            }
            let owner = Owner::this_program();
            let text = toml::to_string(&owner).map_err(io::Error::other)?;
            file.set_len(0)?;
            file.rewind()?;
            file.write_all(text.as_bytes())?;
            // The holder before may have removed the file between our opening and our locking it: then ours is nobody's. Windows
            // removes no open file, and lets nobody read a locked one.
            if cfg!(windows) || std::fs::read_to_string(&path).is_ok_and(|present| present == text) {
                return Ok(LockResult::Acquired(Self { path, _file: file }));
            }
        }
        Err(io::Error::other(format!("{} comes and goes", path.display())))
    }

    /// Takes hold of what a dead program left; `None` where its owner may live or no lock can be written.
    pub(super) fn try_lock_abandoned(target: &Path) -> Option<Self> {
        match Self::try_lock(target) {
            Ok(LockResult::Acquired(lock)) => Some(lock),
            Ok(LockResult::Held(_)) | Err(_) => None,
        }
    }

    /// Takes hold of a session file to write it; `None` where no lock can be written, which writing says better.
    pub fn lock_for_writing(target: &Path) -> Result<Option<Self>, String> {
        match Self::try_lock(target) {
            Ok(LockResult::Acquired(lock)) => Ok(Some(lock)),
            Ok(LockResult::Held(owner)) => {
                Err(format!("{} is open in {}", target.display(), describe_owner(owner.as_ref())))
            }
            Err(_) => Ok(None),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while still held; one that stays behind is taken over by the next who asks.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A program in words.
pub(crate) fn describe_owner(owner: Option<&Owner>) -> String {
    owner.map_or("another program".to_owned(), |owner| format!("another doublet, {owner}"))
}

pub(super) fn lock_path(target: &Path) -> PathBuf {
    let target = target.canonicalize().unwrap_or_else(|_| target.to_path_buf());
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    target.with_file_name(format!(".{name}.lock"))
}

fn read_owner(file: &mut File) -> Option<Owner> {
    let mut text = String::new();
    file.rewind().and_then(|()| file.read_to_string(&mut text)).ok()?;
    toml::from_str(&text).ok()
}
