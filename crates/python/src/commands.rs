//! The commands of the command line: their table, and one of them in a process of its own.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Every command with its arguments: JSON.
#[pyfunction]
pub fn command_table() -> String {
    doublet_cli::command_table().to_string()
}

/// Runs the command that `arguments` name, without the program's name, as the program does: it prints, and gives its exit code. For a
/// process that does nothing else.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let arguments = std::iter::once(OsString::from("doublet")).chain(arguments).collect();
    py.detach(|| doublet_cli::run_command(arguments))
}
