//! Files of the shared folder beside the project, which tests read where it is present.

use std::path::{Path, PathBuf};

/// Path of `relative` in the shared folder beside the project, or `None` with a printed reason where it is absent; under
/// continuous integration it must be there.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(relative);
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none_or(|ci| ci != "true"), "{} is not here", path.display());
    println!("skipped: {} is not here", path.display());
    None
}
