//! Paths written in a session that lead out of its folder.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::Session;
use crate::builtin;

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

/// What to say of a session that reads files outside its folder: one line, however many they are. `None` for one that does not.
pub fn path_warning(session: &Session) -> Option<String> {
    let of_flights = session.flights.iter().flat_map(|flight| {
        let recordings = flight.recordings.iter();
        let files = recordings.flat_map(|entry| [Some(entry.path.as_str()), entry.channel_map.file()]);
        files.flatten().chain(flight.instruments.iter().map(|setting| setting.file.as_str()))
    });
    let all = std::iter::once(session.aircraft.as_str()).chain(of_flights);
    let outside: BTreeSet<&str> = all.filter(|path| leads_out(path)).collect();
    let first = outside.first()?;
    let what = match outside.len() {
        1 => format!("{first} lies"),
        count => match shared_folder(&outside) {
            Some(folder) => format!("{count} files under {} lie", folder.display()),
            None => format!("{count} files, {first} the first, lie"),
        },
    };
    Some(format!("{what} outside the session's folder: see that this is meant"))
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
