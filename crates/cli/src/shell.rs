//! What a shell and a reader of manual pages want to know of the commands: completions and man pages, made from the arguments.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use crate::output_path::output_path;
use crate::{command_line, text};

/// Name the pages and completions are for.
const PROGRAM: &str = "doublet";

#[derive(Debug, Args)]
pub struct CompletionArguments {
    /// Shell.
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for the pages, one per command: doublet.1, doublet-run.1 and so on.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
}

/// Prints the completions for a shell.
pub fn completions(arguments: &CompletionArguments) -> Result<(), String> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command_line(), PROGRAM, &mut script);
    text::write_out(&script);
    Ok(())
}

/// Writes the man pages.
pub fn man(arguments: &ManArguments) -> Result<(), String> {
    let refused = |error: std::io::Error| format!("{}: {error}", arguments.out.display());
    std::fs::create_dir_all(&arguments.out).map_err(refused)?;
    clap_mangen::generate_to(command_line(), &arguments.out).map_err(refused)?;
    text::line(&format!("man pages in {}", arguments.out.display()));
    Ok(())
}
