//! The doublet workbench, and its command line.

use std::process::ExitCode;

use doublet_cli::Invocation;

fn main() -> ExitCode {
    let outcome = match doublet_cli::invoke() {
        Invocation::Done(code) => return code,
        Invocation::Window(session) => doublet::app::run(session.as_deref()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{line}");
            ExitCode::FAILURE
        }
    }
}
