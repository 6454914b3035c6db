//! Paths written in a session that lead out of its folder.

use std::path::{Component, Path};

use crate::builtin;

/// What to say of a path that is not below the session's folder: a session from elsewhere could point at any file of this machine.
/// `None` for one that is, and for what comes with the program.
pub fn path_warning(path: &str) -> Option<String> {
    if path.starts_with(builtin::PREFIX) {
        return None;
    }
    let mut depth = 0_i64;
    for part in Path::new(path).components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::ParentDir => depth -= 1,
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => {
                return Some(format!("{path} is a place on this machine, not in the session's folder"));
            }
        }
        if depth < 0 {
            return Some(format!("{path} leads out of the session's folder"));
        }
    }
    None
}
