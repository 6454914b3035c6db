//! Session files: opened with their folder, saved so that a crash never leaves half a file.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::Session;
use super::paths::{paths_mut, relative_to};
use super::schema::{SessionError, parse, print};
use crate::builtin;
use crate::keep::{hash_bytes, hash_file, hex, replace, replace_keeping_previous};

/// A session and where its relative paths start.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    pub session: Session,
    /// Its file.
    pub path: PathBuf,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    /// SHA-256 of the file as it was read, in hexadecimal.
    pub sha256: String,
}

fn file_error(path: &Path) -> impl FnOnce(std::io::Error) -> SessionError {
    let path = path.display().to_string();
    move |source| SessionError::File { path, source }
}

/// Opens a session file, or `builtin:` and the name of a session that comes with the program, whose relative paths start from the
/// present folder. What lies in the folder of a file is named from there, however the file names it.
pub fn open(path: &Path) -> Result<Opened, SessionError> {
    if let Some(name) = shipped(path) {
        let unknown = || {
            std::io::Error::other(format!("shipped session not found: use one of {}", builtin::sessions().join(", ")))
        };
        let text = builtin::session(name).ok_or_else(unknown).map_err(file_error(path))?;
        let sha256 = hash_bytes(text.as_bytes());
        return Ok(Opened { session: parse(text)?, path: path.to_path_buf(), folder: PathBuf::new(), sha256 });
    }
    let text = text_of(path).map_err(file_error(path))?;
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let sha256 = hash_bytes(text.as_bytes());
    Ok(Opened { session: relative_to(&parse(&text)?, &folder), path: path.to_path_buf(), folder, sha256 })
}

/// Name of the session that comes with the program, where `path` names one.
pub fn shipped(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(builtin::PREFIX)
}

/// The text of a session file; an empty file and one that is no text are said to be what they are.
fn text_of(path: &Path) -> std::io::Result<String> {
    let refuse = |text: &str| Err(std::io::Error::new(std::io::ErrorKind::InvalidData, text.to_owned()));
    let bytes = doublet_core::load::read_bytes(path)?;
    if bytes.is_empty() {
        return refuse("the file is empty (0 bytes): open another file, or its .bak beside it");
    }
    String::from_utf8(bytes)
        .or_else(|_| refuse("this is a binary file, not a session: make a new session from the recording"))
}

/// Like [`save`], and what `*.bak` holds stays.
pub fn save_without_backup(session: &Session, path: &Path) -> Result<(), SessionError> {
    refuse_shipped(path)?;
    replace(path, print(session)?.as_bytes()).map_err(file_error(path))
}

/// Saves a session in one step: a reader finds the old file or the new one, whenever the program ends. The previous file is kept
/// as `*.bak`.
///
/// # Errors
/// [`SessionError::File`] when the folder cannot be written; the previous file is then untouched.
pub fn save(session: &Session, path: &Path) -> Result<(), SessionError> {
    refuse_shipped(path)?;
    let text = print(session)?;
    replace_keeping_previous(path, text.as_bytes()).map_err(file_error(path))
}

/// What comes with the program is not written over.
fn refuse_shipped(path: &Path) -> Result<(), SessionError> {
    let text = "shipped sessions cannot be changed: save to a file";
    shipped(path).map_or(Ok(()), |_| Err(file_error(path)(std::io::Error::other(text))))
}

/// The session with every relative path, which starts from `old`, written so that it means the same file from `new`.
///
/// Both folders are absolute. Paths between folders with a common beginning stay relative; built-ins stay, absolute paths too unless
/// they lie in `new`.
pub fn rebased(session: &Session, old: &Path, new: &Path) -> Session {
    let mut session = session.clone();
    paths_mut(&mut session).for_each(|path| rebase(path, old, new));
    relative_to(&session, new)
}

fn rebase(path: &mut String, old: &Path, new: &Path) {
    if path.starts_with(builtin::PREFIX) || Path::new(path.as_str()).is_absolute() {
        return;
    }
    let joined = old.join(path.as_str());
    let mut target: Vec<_> = Vec::new();
    for part in joined.components() {
        match part {
            std::path::Component::ParentDir if target.len() > 1 => drop(target.pop()),
            std::path::Component::CurDir => {}
            other => target.push(other),
        }
    }
    let from: Vec<_> = new.components().collect();
    let common = target.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let mut relative = PathBuf::new();
    relative.extend(std::iter::repeat_n("..", from.len() - common));
    relative.extend(&target[common..]);
    *path = relative.to_string_lossy().into_owned();
}

/// SHA-256 of a file, or of the names and contents of the files of a folder in order of their names, in hexadecimal.
pub fn content_hash(path: &Path) -> Result<String, SessionError> {
    let mut hasher = Sha256::new();
    if path.is_dir() {
        let mut files: Vec<_> = std::fs::read_dir(path)
            .and_then(|entries| entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>())
            .map_err(file_error(path))?;
        files.retain(|file| file.is_file());
        files.sort();
        for file in &files {
            hasher.update(file.file_name().unwrap_or_default().as_encoded_bytes());
            hash_file(file, &mut hasher).map_err(file_error(file))?;
        }
    } else {
        hash_file(path, &mut hasher).map_err(file_error(path))?;
    }
    Ok(hex(&hasher.finalize()))
}
