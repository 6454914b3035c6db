//! Headless `doublet`: every command of the workbench's binary, without a GUI crate in its tree.

use std::process::ExitCode;

fn main() -> ExitCode {
    doublet_cli::main_without_window()
}
