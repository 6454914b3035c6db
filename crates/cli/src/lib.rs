//! Command line of doublet: everything the workbench does, without a screen.

mod aircraft;
mod arguments;
mod batch;
mod campaign;
mod check;
mod compare;
mod compatibility;
mod coverage;
mod datcom;
mod debrief;
mod design;
mod diff;
mod dynamics;
mod engine;
mod equations;
mod export;
mod fidelity;
mod fix;
mod fmu;
pub mod glossary;
mod inspect;
mod lags;
mod live;
pub mod manual;
mod map;
mod match_command;
mod new;
mod outcome;
mod output_path;
mod pages;
mod prior;
mod progress;
mod propagate;
mod propose;
mod qtg;
pub mod questions;
mod regress;
mod report;
mod response;
mod role_option;
mod run;
mod schema;
mod search;
mod shell;
mod simulate;
mod static_thrust;
mod structure;
mod study;
mod suggest;
mod summary;
mod swing;
mod table;
mod text;
mod thesis;
mod time_option;
mod tune;
mod variants;
mod version;
mod weigh;

pub use equations::equation_document;
pub use table::command_table;
pub use version::version;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{ArgAction, ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use doublet_engine::graph::guarded;
use outcome::Outcome;

/// Aircraft system identification from flight test; without a command, the workbench.
#[derive(Debug, Parser)]
#[command(name = "doublet", version = crate::version::version(), about, args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub struct Arguments {
    /// Session to open: a file, or builtin:NAME.
    pub session: Option<PathBuf>,
    /// Command to run without a window.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands without a window, a row each: its help, its arguments and what runs it.
macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($arguments:ty) => $run:path;)*) => {
        /// Commands without a window.
        #[derive(Debug, Subcommand)]
        pub enum Command { $($(#[$help])* $name($arguments),)* }

        fn outcome(command: Command) -> Result<Outcome, String> {
            match command { $(Command::$name(arguments) => $run(&arguments).map(Outcome::from),)* }
        }
    };
}

commands! {
    /// List sources, channels, units, rates and gaps of a recording.
    Inspect(inspect::InspectArguments) => inspect::inspect;
    /// Guess a channel map for recordings, or list and print shipped maps.
    Map(map::MapArguments) => map::map;
    /// Make a session for one or more recordings.
    New(new::NewArguments) => new::new;
    /// List, print or make aircraft files.
    Aircraft(aircraft::AircraftArguments) => aircraft::aircraft;
    /// Check a session or an aircraft file and print the findings.
    Check(check::CheckArguments) => check::check;
    /// Run a session and write tables and time histories.
    Run(run::RunArguments) => run::run;
    /// Run a session and write a report.
    Report(arguments::ReportArguments) => report::report;
    /// Print sensitivities of the derivatives to loading, deflections, air angles and fuel.
    Sensitivity(study::StudyArguments) => study::sensitivity;
    /// Compare manoeuvres: leave one out, input kinds, flight conditions.
    Manoeuvres(study::StudyArguments) => study::manoeuvres;
    /// Estimate each manoeuvre again in the frequency domain and by output error.
    Checks(study::CheckStudyArguments) => study::checks;
    /// Find lag and delay of each control from the fit.
    Lags(lags::LagArguments) => lags::lags;
    /// Follow a flight in real time: path, derivatives, correlation and limits.
    Live(live::LiveArguments) => live::live;
    /// Estimate constant sensor errors over all manoeuvres: bias, scale factor, misalignment.
    Compatibility(compatibility::CompatibilityArguments) => compatibility::compatibility;
    /// Search for model terms, stepwise or by orthogonal functions.
    Structure(structure::StructureArguments) => structure::structure;
    /// Fit one column of a table by others, without a session.
    Regress(regress::RegressArguments) => regress::regress;
    /// Fit your equations of motion to a table.
    Equations(equations::EquationArguments) => equations::equations;
    /// Print frequency responses with coherence and error bars.
    Response(response::ResponseArguments) => response::response;
    /// Fit a low-order equivalent system to a frequency response.
    Loes(response::LoesArguments) => response::loes;
    /// Print weighted, generalised, constrained and total least-squares estimates beside ordinary ones.
    Variants(variants::VariantArguments) => variants::variants;
    /// Repeat reconstruction and fit many times with fresh measurement noise.
    MonteCarlo(study::MonteCarloArguments) => study::monte_carlo;
    /// Compare the experiments of a session: verdict, NIS, fits and derivatives.
    Compare(compare::CompareArguments) => compare::compare;
    /// List the fixes of a session with their effect, or apply some.
    Fix(fix::FixArguments) => fix::fix;
    /// Propose manoeuvres, steady parts or noise from the recordings of a session.
    Propose(propose::ProposeArguments) => propose::propose;
    /// Simulate validation manoeuvres with the model and print which tolerances pass.
    Match(match_command::MatchArguments) => match_command::match_command;
    /// Evaluate a qualification test guide on a session and write it.
    Qtg(qtg::QtgArguments) => qtg::qtg;
    /// Write the identified aircraft as a Functional Mock-up Unit (FMI 3.0).
    Fmu(fmu::FmuArguments) => fmu::fmu;
    /// Combine an earlier estimate with that of the flight, and compare both.
    Prior(prior::PriorArguments) => prior::prior;
    /// Print or write the linear model about a trim.
    Linear(dynamics::LinearArguments) => dynamics::linear;
    /// Print natural modes with intervals, or a root locus.
    Modes(dynamics::ModesArguments) => dynamics::modes;
    /// Print flying-qualities levels with reasons and probabilities.
    Qualities(dynamics::QualitiesArguments) => dynamics::qualities;
    /// Design the inputs of the next flight within limits.
    Design(design::DesignArguments) => design::design;
    /// Plan a campaign: envelope, test points in order, flight-test cards.
    Campaign(campaign::CampaignArguments) => campaign::campaign;
    /// Find empty mass and centre of gravity from a weighing.
    Weigh(weigh::WeighArguments) => weigh::weigh;
    /// Find moments of inertia from an aircraft swung as a pendulum.
    Swing(swing::SwingArguments) => swing::swing;
    /// Compare the pull of the engines at rest with their models.
    StaticThrust(static_thrust::StaticThrustArguments) => static_thrust::static_thrust;
    /// Compare flown designs with predicted errors and the true values.
    Debrief(debrief::DebriefArguments) => debrief::debrief;
    /// Compare the errors so far with goals, and propose the next manoeuvre.
    Enough(design::EnoughArguments) => design::enough;
    /// Print a function of the derivatives with its interval.
    Propagate(propagate::PropagateArguments) => propagate::propagate;
    /// Write the identified model for JSBSim or as DAVE-ML, with check points.
    Export(export::ExportArguments) => export::export;
    /// Compare two sessions or two runs: settings and derivatives.
    Diff(diff::DiffArguments) => diff::diff;
    /// Run many sessions or swept settings on all cores; continues when interrupted.
    Batch(batch::BatchArguments) => batch::batch;
    /// Simulate a scenario many times and print the coverage of the intervals.
    Coverage(coverage::CoverageArguments) => coverage::coverage;
    /// Simulate fault-free and faulty flights and print how the verdict rates them.
    Calibrate(coverage::CalibrateArguments) => coverage::calibrate;
    /// Write estimates and true values of the shipped flight into a document.
    Fidelity(fidelity::FidelityArguments) => fidelity::fidelity;
    /// Print the JSON Schema of a doublet file, for editors.
    Schema(schema::SchemaArguments) => schema::schema;
    /// Simulate a flight and write its recordings and its truth.
    Simulate(simulate::SimulateArguments) => simulate::simulate;
    /// Print power, thrust and their sensitivities at one condition.
    Engine(engine::EngineArguments) => engine::engine;
    /// Estimate noise settings, or a sensor delay, by maximum likelihood.
    Tune(tune::TuneArguments) => tune::tune;
    /// Compare Digital DATCOM derivatives with identified ones, or write an input deck.
    Datcom(datcom::DatcomArguments) => datcom::datcom;
    /// Print a page of the manual or the help of a command.
    Help(manual::HelpArguments) => manual::help;
    /// Print shell completions.
    Completions(shell::CompletionArguments) => shell::completions;
    /// Write man pages, one per command.
    Man(shell::ManArguments) => shell::man;
}

/// What the arguments ask for.
#[derive(Debug)]
pub enum Invocation {
    /// Open the workbench on this session, or on its start page.
    Window(Option<PathBuf>),
    /// A command ran; this is its exit code.
    Done(ExitCode),
}

/// The error of a session that looks like a mistyped command.
fn suggest_command(session: &Path) -> Option<String> {
    let command_line = command_line();
    suggest::mistyped(session, command_line.get_subcommands().map(clap::Command::get_name))
}

/// Reads the program's arguments and runs the command they name, if any.
pub fn invoke() -> Invocation {
    let matches = command_line().get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let as_json = asks_for_json(&matches);
    match arguments.command {
        None => match arguments.session.as_deref().and_then(suggest_command) {
            Some(error) => Invocation::Done(fail(error)),
            None => Invocation::Window(arguments.session),
        },
        Some(command) => Invocation::Done(ExitCode::from(execute(command, as_json))),
    }
}

/// Runs the command that `arguments` name, the program's name first, and gives its exit code: 0, 1 for an error, 2 for wrong arguments, 3
/// where something is bad. There is no window: without a command it is an error.
pub fn run_command(arguments: Vec<OsString>) -> u8 {
    let parsed = command_line().try_get_matches_from(arguments);
    let parsed = parsed.and_then(|matches| Ok((Arguments::from_arg_matches(&matches)?, asks_for_json(&matches))));
    match parsed {
        Ok((Arguments { command: Some(command), .. }, as_json)) => execute(command, as_json),
        Ok((Arguments { session, .. }, _)) => {
            failed(session.as_deref().and_then(suggest_command).unwrap_or_else(without_window))
        }
        Err(error) => {
            // A closed pipe: there is no one left to read the error.
            let _ = error.print();
            u8::try_from(error.exit_code()).unwrap_or(1)
        }
    }
}

/// The error of a program that has no window.
fn without_window() -> String {
    "this program has no window: use `run SESSION --out DIR`, or the doublet binary".to_owned()
}

/// Every command with its arguments. Each takes `--json`: those with a document of their own print it, of the others what they say
/// and their tables become one.
pub fn command_line() -> clap::Command {
    with_json(Arguments::command())
}

/// Commands of which `--json` asks nothing: what they print is for a shell.
const WITHOUT_JSON: [&str; 1] = ["completions"];

fn with_json(command: clap::Command) -> clap::Command {
    let names: Vec<String> = command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    names.into_iter().fold(command, |command, name| {
        command.mut_subcommand(&name, |sub| {
            if sub.has_subcommands() {
                return with_json(sub);
            }
            if WITHOUT_JSON.contains(&name.as_str()) || sub.get_arguments().any(|argument| argument.get_id() == "json")
            {
                return sub;
            }
            let help = "Print one JSON document instead of text";
            sub.arg(clap::Arg::new("json").long("json").action(ArgAction::SetTrue).help(help))
        })
    })
}

/// Whether the command that was called, or the one below it, got `--json`.
fn asks_for_json(matches: &ArgMatches) -> bool {
    let own = matches.try_get_one::<bool>("json").ok().flatten().copied().unwrap_or(false);
    own || matches.subcommand().is_some_and(|(_, below)| asks_for_json(below))
}

/// Entry of the binary that has no window.
pub fn main_without_window() -> ExitCode {
    match invoke() {
        Invocation::Done(code) => code,
        Invocation::Window(_) => fail(without_window()),
    }
}

/// Prints one line of error and gives the exit code that goes with it.
pub fn fail(message: impl std::fmt::Display) -> ExitCode {
    ExitCode::from(failed(message))
}

fn failed(message: impl std::fmt::Display) -> u8 {
    text::error_line(&format!("error: {message}"));
    1
}

fn execute(command: Command, as_json: bool) -> u8 {
    if as_json {
        text::collect();
    }
    let outcome = guarded("doublet", || outcome(command));
    let finished = text::finish();
    doublet_engine::builtin::remove_own_folder();
    match outcome.and_then(|outcome| finished.map(|()| outcome)) {
        Ok(outcome) => outcome.code(),
        Err(message) => failed(message),
    }
}
