//! The program run at the root of the project, where the shipped sessions lie.

#![allow(clippy::expect_used, reason = "helpers of tests are not marked as tests")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the program.
pub fn doublet(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_doublet-cli")).args(arguments).current_dir(root).output().expect("it starts")
}

/// What it printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// What it prints as JSON.
pub fn document(arguments: &[&str]) -> Value {
    let output = doublet(arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

/// The one line in which it refuses.
pub fn error_line(arguments: &[&str]) -> String {
    let output = doublet(arguments);
    assert_eq!(output.status.code(), Some(1));
    let line = text(&output.stderr);
    assert_eq!(line.lines().count(), 1, "{line}");
    line
}
