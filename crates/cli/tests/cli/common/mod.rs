//! What tests of the command line share.

pub mod at_root;
pub mod chain;
pub mod disk;
pub mod flight;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Root of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Runs the program in a folder.
pub fn doublet(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_doublet-cli")).args(arguments).current_dir(folder).output().expect("it starts")
}
