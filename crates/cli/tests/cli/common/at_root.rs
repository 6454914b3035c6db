//! The program run at the root of the project, where the shipped sessions lie.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

/// Runs the program.
pub fn doublet(arguments: &[&str]) -> Output {
    super::doublet(&super::root(), arguments)
}

/// What it printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Standard output of a command that succeeds.
pub fn printed(arguments: &[&str]) -> String {
    let output = doublet(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    String::from_utf8(output.stdout).expect("it is UTF-8")
}

/// What it prints as JSON.
pub fn document(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(arguments)).expect("it is JSON")
}

/// The content of a JSON file.
pub fn json_file(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("the file is there")).expect("it is JSON")
}

/// The one line in which it refuses.
pub fn error_line(arguments: &[&str]) -> String {
    let output = doublet(arguments);
    assert_eq!(output.status.code(), Some(1));
    let line = text(&output.stderr);
    assert_eq!(line.lines().count(), 1, "{line}");
    line
}
