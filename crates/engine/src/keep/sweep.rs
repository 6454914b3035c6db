//! What writers that were killed left behind, removed by the next that writes there.
//!
//! A writer holds a lock on what it writes, which the system lets go of when it ends, however it ends. Where the system knows no
//! locks nothing is removed.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use super::folder::links;
use super::lock::{Lock, lock_path};
use super::manifest::{MANIFEST, Manifest, name_of};

/// Start of the names of staging folders.
pub(super) const STAGING: &str = ".doublet-";
/// End of the names of files being written.
pub(super) const PART: &str = ".doublet-part";
/// Characters of a name that are chosen at random.
const RANDOM: usize = 6;

/// Removes staging folders and files that a dead writer left in `folder`. What cannot be removed does no harm.
pub fn sweep(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let path = entry.path();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        // A writer locks its folder: one without a lock is somebody else's.
        if is_folder && is_staging(name) && lock_path(&path).exists() {
            _ = Lock::try_lock_abandoned(&path).map(|_lock| remove_staging(&path));
        } else if is_file && name.starts_with('.') && name.ends_with(PART) {
            _ = remove_part(&path);
        } else if let Some(staging) = name.strip_prefix('.').and_then(|name| name.strip_suffix(".lock"))
            && is_file
            && is_staging(staging)
            && !folder.join(staging).exists()
        {
            // Its folder is gone: the file is removed with the lock.
            _ = Lock::try_lock(&folder.join(staging));
        }
    }
}

fn is_staging(name: &str) -> bool {
    name.strip_prefix(STAGING)
        .is_some_and(|random| random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// Removes a file that nobody is writing.
fn remove_part(path: &Path) -> io::Result<()> {
    let file: File = OpenOptions::new().read(true).write(true).open(path)?;
    file.try_lock()?;
    std::fs::remove_file(path)
}

/// Removes a staging folder. One that was complete may have changed places with its target and hold the user's files: their second
/// names go, a file that has no other name stays.
pub(super) fn remove_staging(place: &Path) -> io::Result<()> {
    if !place.join(MANIFEST).exists() {
        return std::fs::remove_dir_all(place);
    }
    let files = Manifest::read(place);
    remove_known(place, Path::new(""), &files)?;
    let only_manifest = std::fs::read_dir(place)?.count() == 1;
    if only_manifest { std::fs::remove_dir_all(place) } else { Ok(()) }
}

fn remove_known(place: &Path, inner: &Path, files: &Manifest) -> io::Result<()> {
    for entry in std::fs::read_dir(place.join(inner))? {
        let entry = entry?;
        let (path, inner) = (entry.path(), inner.join(entry.file_name()));
        if entry.file_type()?.is_dir() {
            remove_known(place, &inner, files)?;
            // One that is not empty stays.
            _ = std::fs::remove_dir(path);
        } else if links(&path) > 1 || files.files.get(&name_of(&inner)?).is_some_and(|entry| entry.is_of(&path)) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}
