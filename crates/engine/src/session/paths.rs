//! Paths written in a session that lead out of its folder.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::{MapRef, Session};
use crate::builtin;
use crate::keep::check_apart;

/// Whether a path is not below the session's folder: a session from elsewhere could point at any file of this machine. What comes with
/// the program is below it.
pub fn leads_out(path: &str) -> bool {
    if path.starts_with(builtin::PREFIX) {
        return false;
    }
    let mut depth = 0_i64;
    Path::new(path).components().any(|part| {
        match part {
            Component::Normal(_) => depth += 1,
            Component::ParentDir => depth -= 1,
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => return true,
        }
        depth < 0
    })
}

/// Every path a session names.
pub fn paths(session: &Session) -> impl Iterator<Item = &str> {
    let of_flights = session.flights.iter().flat_map(|flight| {
        let recordings = flight.recordings.iter();
        let files = recordings.flat_map(|entry| [Some(entry.path.as_str()), entry.channel_map.file()]);
        files.flatten().chain(flight.instruments.iter().map(|setting| setting.file.as_str()))
    });
    session.aircraft.as_deref().into_iter().chain(of_flights)
}

/// Checks that a file to be written is none of those the session names; its relative paths start from `folder`.
///
/// # Errors
/// One line that names it.
pub fn check_output(session: &Session, folder: &Path, written: &Path) -> Result<(), String> {
    check_apart(written, paths(session).map(|path| folder.join(path)))
}

/// Every path a session names, to be changed.
pub(super) fn paths_mut(session: &mut Session) -> impl Iterator<Item = &mut String> {
    let of_flights = session.flights.iter_mut().flat_map(|flight| {
        let recordings = flight.recordings.iter_mut();
        let files = recordings.flat_map(|entry| match &mut entry.channel_map {
            MapRef::File(map) => [Some(&mut entry.path), Some(map)],
            MapRef::Own(_) => [Some(&mut entry.path), None],
        });
        files.flatten().chain(flight.instruments.iter_mut().map(|setting| &mut setting.file))
    });
    session.aircraft.iter_mut().chain(of_flights)
}

/// The session with paths to what lies in `folder` written as they are from there, whatever way round they went.
pub fn relative_to(session: &Session, folder: &Path) -> Session {
    let mut session = session.clone();
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(full) = here.canonicalize() else { return session };
    for path in paths_mut(&mut session).filter(|path| leads_out(path)) {
        let target = here.join(path.as_str()).canonicalize();
        let inside = target.ok().and_then(|target| Some(target.strip_prefix(&full).ok()?.to_path_buf()));
        if let Some(inside) = inside.filter(|inside| !inside.as_os_str().is_empty()) {
            *path = inside.to_string_lossy().into_owned();
        }
    }
    session
}

/// What to say of a session that reads files outside its folder: one line, however many they are. `None` for one that does not.
pub fn path_warning(session: &Session) -> Option<String> {
    let outside: BTreeSet<&str> = paths(session).filter(|path| leads_out(path)).collect();
    let first = outside.first()?;
    let what = match outside.len() {
        1 => format!("{first} is"),
        count => match shared_folder(&outside) {
            Some(folder) => format!("{count} files under {} are", folder.display()),
            None => format!("{count} files, {first} the first, are"),
        },
    };
    Some(format!("{what} outside the session's folder: check that this is intended"))
}

/// The folder all paths are in, unless that is but a step upwards or the root.
fn shared_folder(paths: &BTreeSet<&str>) -> Option<PathBuf> {
    let mut folders = paths.iter().map(|path| Path::new(path).parent().unwrap_or(Path::new("")));
    let mut shared = folders.next()?.to_path_buf();
    for folder in folders {
        shared = shared.components().zip(folder.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
    }
    let says_something = shared.components().any(|part| matches!(part, Component::Normal(_)));
    says_something.then_some(shared)
}
