//! Files replaced in one step: written beside, synced, renamed.

use std::ffi::OsString;
use std::fs::{OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::sweep::{PART, sweep};

/// What the previous version of a file has added to its name.
const PREVIOUS: &str = ".bak";

/// Writes `bytes` to `path`. Whoever reads it, also after a kill or a power cut at any instant, finds all of the old content or
/// all of the new. Links are followed; permissions stay. A device or a pipe is written to, never replaced by a file.
///
/// # Errors
/// When the folder cannot be written; the file is then untouched.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if is_device_or_pipe(path) {
        return OpenOptions::new().write(true).open(path)?.write_all(bytes);
    }
    let path = target(path);
    let folder = folder_of(&path);
    let prefix = part_prefix(&path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(PART);
    readable_by_others(&mut builder);
    let mut file = begin(&builder, folder)?;
    file.write_all(bytes)?;
    if let Ok(present) = path.metadata() {
        file.as_file().set_permissions(present.permissions())?;
    }
    file.as_file().sync_all()?;
    file.persist(&path).map_err(|error| error.error)?;
    sync_folder(folder)
}

/// A new file that is locked while it is written, so that nobody takes it for what a dead writer left.
fn begin(builder: &tempfile::Builder<'_, '_>, folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    loop {
        let file = builder.tempfile_in(folder)?;
        match file.as_file().try_lock() {
            Ok(()) if file.path().exists() => return Ok(file),
            // It was swept away between its making and its locking.
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
}

/// Like [`replace`]; what the file held before is then in `*.bak`, which is replaced in one step too. Leftovers of writers that died
/// in its folder are removed.
pub fn replace_keeping_previous(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if is_device_or_pipe(path) {
        return replace(path, bytes);
    }
    match std::fs::read(path) {
        Ok(previous) => replace(&previous_of(path), &previous)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    remove_leftovers(path);
    replace(path, bytes)
}

/// Checks that a file to be written is none of those `read`, which it would replace.
///
/// # Errors
/// One line that names it.
pub fn check_apart(written: &Path, read: impl IntoIterator<Item = PathBuf>) -> Result<(), String> {
    let Ok(place) = written.canonicalize() else { return Ok(()) };
    match read.into_iter().any(|path| path.canonicalize().is_ok_and(|path| path == place)) {
        true => Err(format!("{} is read by this command: choose another name", written.display())),
        false => Ok(()),
    }
}

/// Removes what writers that were killed have left beside `path`.
pub fn remove_leftovers(path: &Path) {
    sweep(folder_of(&target(path)));
}

/// Where the previous version of `path` is kept.
fn previous_of(path: &Path) -> PathBuf {
    let mut previous = path.as_os_str().to_owned();
    previous.push(PREVIOUS);
    PathBuf::from(previous)
}

/// The file itself where `path` is a link to it, also to one that does not exist yet.
fn target(path: &Path) -> PathBuf {
    /// As many links as systems follow.
    const MOST_LINKS: usize = 40;
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(link) = place.read_link() else { break };
        place = folder_of(&place).join(link);
    }
    place.canonicalize().unwrap_or(place)
}

/// Such as `/dev/null`, `/dev/stdout` or a named pipe.
fn is_device_or_pipe(path: &Path) -> bool {
    path.metadata().is_ok_and(|present| !present.is_file() && !present.is_dir())
}

/// The folder a file lies in.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn part_prefix(path: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(path.file_name().unwrap_or_default());
    prefix.push(".");
    prefix
}

/// A new file gets the permissions of any other new file, not those of a private temporary one.
#[cfg(unix)]
fn readable_by_others(builder: &mut tempfile::Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn readable_by_others(_: &mut tempfile::Builder<'_, '_>) {}

/// Makes the name of a new file or folder last.
pub(crate) fn sync_folder_of(path: &Path) -> io::Result<()> {
    sync_folder(folder_of(path))
}

/// Makes the names in a folder and in all folders below it last, the innermost first.
pub(super) fn sync_folders(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sync_folders(&entry.path())?;
        }
    }
    sync_folder(folder)
}

/// Makes a rename last. Systems that cannot open a folder sync it on their own.
#[cfg(unix)]
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    std::fs::File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
pub(super) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
