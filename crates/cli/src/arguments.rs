//! Arguments of every command.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Aircraft system identification from flight test.
///
/// Without a command the workbench opens, on SESSION or on the session that comes with the program.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    /// Session to open in the workbench.
    pub session: Option<PathBuf>,
    /// What to do without a window.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// Commands that need no window.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List sources, channels, units, rates and gaps of a recording.
    Inspect(InspectArguments),
    /// Make a session for one or more recordings.
    New(NewArguments),
    /// Check a session or an aircraft file and print what it says.
    Check(CheckArguments),
    /// Compute everything a session asks for and write tables and time histories.
    Run(RunArguments),
    /// Fly a simulated flight and write its recordings and its truth.
    Simulate(SimulateArguments),
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// File, or folder of one file per channel.
    pub recording: PathBuf,
    /// Channel map (file, or the name of one that comes with the program) to show what each channel would be used for.
    #[arg(long)]
    pub map: Option<String>,
}

/// Arguments of `new`.
#[derive(Debug, Args)]
pub struct NewArguments {
    /// Recordings: each becomes a flight of its own, unless --merge is given.
    #[arg(required = true)]
    pub recordings: Vec<PathBuf>,
    /// Session file to write.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Channel map (file or name); without it the shipped map that fits best is taken.
    #[arg(long)]
    pub map: Option<String>,
    /// Aircraft (file or name).
    #[arg(long, default_value = "c337f")]
    pub aircraft: String,
    /// Put all recordings into one flight, on one time line.
    #[arg(long)]
    pub merge: bool,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Session or aircraft file.
    pub file: PathBuf,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the results: it appears complete or not at all.
    #[arg(long)]
    pub out: PathBuf,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// Scenario to fly.
    pub scenario: Option<String>,
    /// Folder for the recordings: it appears complete or not at all.
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Seed of noise, gusts and hand-flown imperfections: the same seed gives the same bytes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Change a derivative of the truth, for example Cm_alpha=-0.9; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = derivative)]
    pub derivative: Vec<(String, f64)>,
    /// Scale the amplitude of every manoeuvre.
    #[arg(long, default_value_t = 1.0)]
    pub amplitude: f64,
    /// True airspeed of a scenario that starts in trim, kt.
    #[arg(long, value_name = "KT")]
    pub airspeed_kt: Option<f64>,
    /// Altitude of a scenario that starts in trim, ft.
    #[arg(long, value_name = "FT")]
    pub altitude_ft: Option<f64>,
    /// List scenarios, aircraft and inputs.
    #[arg(long)]
    pub list: bool,
}

/// Reads `NAME=VALUE`.
fn derivative(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write it as NAME=VALUE, for example Cm_alpha=-0.9")?;
    let value: f64 = value.trim().parse().map_err(|_| format!("'{value}' is not a number"))?;
    Ok((name.trim().to_owned(), value))
}
