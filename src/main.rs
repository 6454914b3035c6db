//! The doublet workbench.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match doublet::app::run(std::env::args_os().nth(1).map(PathBuf::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{line}");
            ExitCode::FAILURE
        }
    }
}
