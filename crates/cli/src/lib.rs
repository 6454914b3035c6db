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

use aircraft::AircraftArguments;
use arguments::ReportArguments;
use batch::BatchArguments;
use check::CheckArguments;
use clap::{ArgAction, ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use compare::CompareArguments;
use compatibility::CompatibilityArguments;
use coverage::{CalibrateArguments, CoverageArguments};
use datcom::DatcomArguments;
use diff::DiffArguments;
use doublet_engine::graph::guarded;
use doublet_engine::study::{MonteCarloRequest, Study};
use dynamics::{LinearArguments, ModesArguments, QualitiesArguments};
use engine::EngineArguments;
use equations::EquationArguments;
use export::ExportArguments;
use fidelity::FidelityArguments;
use fix::FixArguments;
use fmu::FmuArguments;
use inspect::InspectArguments;
use lags::LagArguments;
use manual::HelpArguments;
use map::MapArguments;
use match_command::MatchArguments;
use new::NewArguments;
use outcome::Outcome;
use prior::PriorArguments;
use propagate::PropagateArguments;
use propose::ProposeArguments;
use regress::RegressArguments;
use response::{LoesArguments, ResponseArguments};
use run::RunArguments;
use shell::{CompletionArguments, ManArguments};
use simulate::SimulateArguments;
use structure::StructureArguments;
use study::{CheckStudyArguments, MonteCarloArguments, StudyArguments};
use tune::TuneArguments;
use variants::VariantArguments;

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

/// Commands without a window.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List sources, channels, units, rates and gaps of a recording.
    Inspect(InspectArguments),
    /// Guess a channel map for recordings, or list and print shipped maps.
    Map(MapArguments),
    /// Make a session for one or more recordings.
    New(NewArguments),
    /// List, print or make aircraft files.
    Aircraft(AircraftArguments),
    /// Check a session or an aircraft file and print the findings.
    Check(CheckArguments),
    /// Run a session and write tables and time histories.
    Run(RunArguments),
    /// Run a session and write a report.
    Report(ReportArguments),
    /// Print sensitivities of the derivatives to loading, deflections, air angles and fuel.
    Sensitivity(StudyArguments),
    /// Compare manoeuvres: leave one out, input kinds, flight conditions.
    Manoeuvres(StudyArguments),
    /// Estimate each manoeuvre again in the frequency domain and by output error.
    Checks(CheckStudyArguments),
    /// Find lag and delay of each control from the fit.
    Lags(LagArguments),
    /// Follow a flight in real time: path, derivatives, correlation and limits.
    Live(crate::live::LiveArguments),
    /// Estimate constant sensor errors over all manoeuvres: bias, scale factor, misalignment.
    Compatibility(CompatibilityArguments),
    /// Search for model terms, stepwise or by orthogonal functions.
    Structure(StructureArguments),
    /// Fit one column of a table by others, without a session.
    Regress(RegressArguments),
    /// Fit your equations of motion to a table.
    Equations(EquationArguments),
    /// Print frequency responses with coherence and error bars.
    Response(ResponseArguments),
    /// Fit a low-order equivalent system to a frequency response.
    Loes(LoesArguments),
    /// Print weighted, generalised, constrained and total least-squares estimates beside ordinary ones.
    Variants(VariantArguments),
    /// Repeat reconstruction and fit many times with fresh measurement noise.
    MonteCarlo(MonteCarloArguments),
    /// Compare the experiments of a session: verdict, NIS, fits and derivatives.
    Compare(CompareArguments),
    /// List the fixes of a session with their effect, or apply some.
    Fix(FixArguments),
    /// Propose manoeuvres, steady parts or noise from the recordings of a session.
    Propose(ProposeArguments),
    /// Simulate validation manoeuvres with the model and print which tolerances pass.
    Match(MatchArguments),
    /// Evaluate a qualification test guide on a session and write it.
    Qtg(crate::qtg::QtgArguments),
    /// Write the identified aircraft as a Functional Mock-up Unit (FMI 3.0).
    Fmu(FmuArguments),
    /// Combine an earlier estimate with that of the flight, and compare both.
    Prior(PriorArguments),
    /// Print or write the linear model about a trim.
    Linear(LinearArguments),
    /// Print natural modes with intervals, or a root locus.
    Modes(ModesArguments),
    /// Print flying-qualities levels with reasons and probabilities.
    Qualities(QualitiesArguments),
    /// Design the inputs of the next flight within limits.
    Design(crate::design::DesignArguments),
    /// Plan a campaign: envelope, test points in order, flight-test cards.
    Campaign(crate::campaign::CampaignArguments),
    /// Find empty mass and centre of gravity from a weighing.
    Weigh(crate::weigh::WeighArguments),
    /// Find moments of inertia from an aircraft swung as a pendulum.
    Swing(crate::swing::SwingArguments),
    /// Compare the pull of the engines at rest with their models.
    StaticThrust(crate::static_thrust::StaticThrustArguments),
    /// Compare flown designs with predicted errors and the true values.
    Debrief(crate::debrief::DebriefArguments),
    /// Compare the errors so far with goals, and propose the next manoeuvre.
    Enough(crate::design::EnoughArguments),
    /// Print a function of the derivatives with its interval.
    Propagate(PropagateArguments),
    /// Write the identified model for JSBSim or as DAVE-ML, with check points.
    Export(ExportArguments),
    /// Compare two sessions or two runs: settings and derivatives.
    Diff(DiffArguments),
    /// Run many sessions or swept settings on all cores; continues when interrupted.
    Batch(BatchArguments),
    /// Simulate a scenario many times and print the coverage of the intervals.
    Coverage(CoverageArguments),
    /// Simulate fault-free and faulty flights and print how the verdict rates them.
    Calibrate(CalibrateArguments),
    /// Write estimates and true values of the shipped flight into a document.
    Fidelity(FidelityArguments),
    /// Print the JSON Schema of a doublet file, for editors.
    Schema(crate::schema::SchemaArguments),
    /// Simulate a flight and write its recordings and its truth.
    Simulate(SimulateArguments),
    /// Print power, thrust and their sensitivities at one condition.
    Engine(EngineArguments),
    /// Estimate noise settings, or a sensor delay, by maximum likelihood.
    Tune(TuneArguments),
    /// Compare Digital DATCOM derivatives with identified ones, or write an input deck.
    Datcom(DatcomArguments),
    /// Print a page of the manual or the help of a command.
    Help(HelpArguments),
    /// Print shell completions.
    Completions(CompletionArguments),
    /// Write man pages, one per command.
    Man(ManArguments),
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

fn outcome(command: Command) -> Result<Outcome, String> {
    let done = match command {
        Command::Check(arguments) => return check::check(&arguments),
        Command::Map(arguments) => return map::map(&arguments),
        Command::New(arguments) => return new::new(&arguments),
        Command::Run(arguments) => return run::run(&arguments),
        Command::Report(arguments) => return report::report(&arguments),
        Command::Qtg(arguments) => return qtg::qtg(&arguments),
        Command::Equations(arguments) => return equations::equations(&arguments),
        Command::Loes(arguments) => return response::loes(&arguments),
        Command::Aircraft(arguments) => aircraft::aircraft(&arguments),
        Command::Inspect(arguments) => inspect::inspect(&arguments),
        Command::Sensitivity(arguments) => study::study(Study::Sensitivity, &arguments),
        Command::Manoeuvres(arguments) => study::study(Study::Manoeuvres, &arguments),
        Command::Checks(arguments) => study::study(Study::Checks(arguments.request()), &arguments.study),
        Command::Compatibility(arguments) => compatibility::compatibility(&arguments),
        Command::Structure(arguments) => structure::structure(&arguments),
        Command::Variants(arguments) => variants::variants(&arguments),
        Command::Lags(arguments) => lags::lags(&arguments),
        Command::Live(arguments) => live::live(&arguments),
        Command::Regress(arguments) => regress::regress(&arguments),
        Command::Response(arguments) => response::response(&arguments),
        Command::MonteCarlo(arguments) => {
            let request = MonteCarloRequest { realisations: arguments.realisations as usize, seed: arguments.seed };
            study::study(Study::MonteCarlo(request), &arguments.study)
        }
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Fix(arguments) => fix::fix(&arguments),
        Command::Propose(arguments) => propose::propose(&arguments),
        Command::Match(arguments) => match_command::match_command(&arguments),
        Command::Fmu(arguments) => fmu::fmu(&arguments),
        Command::Prior(arguments) => prior::prior(&arguments),
        Command::Linear(arguments) => dynamics::linear(&arguments),
        Command::Modes(arguments) => dynamics::modes(&arguments),
        Command::Qualities(arguments) => dynamics::qualities(&arguments),
        Command::Campaign(arguments) => campaign::campaign(&arguments),
        Command::Design(arguments) => design::design(&arguments),
        Command::Weigh(arguments) => weigh::weigh(&arguments),
        Command::Swing(arguments) => swing::swing(&arguments),
        Command::StaticThrust(arguments) => static_thrust::static_thrust(&arguments),
        Command::Debrief(arguments) => debrief::debrief(&arguments),
        Command::Enough(arguments) => design::enough(&arguments),
        Command::Propagate(arguments) => propagate::propagate(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Diff(arguments) => diff::diff(&arguments),
        Command::Batch(arguments) => batch::batch(&arguments),
        Command::Coverage(arguments) => coverage::coverage(&arguments),
        Command::Calibrate(arguments) => coverage::calibrate(&arguments),
        Command::Fidelity(arguments) => fidelity::fidelity(&arguments),
        Command::Schema(arguments) => schema::schema(&arguments),
        Command::Simulate(arguments) => simulate::simulate(&arguments),
        Command::Engine(arguments) => engine::engine(&arguments),
        Command::Datcom(arguments) => datcom::datcom(&arguments),
        Command::Tune(arguments) => tune::tune(&arguments),
        Command::Help(arguments) => manual::help(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::man(&arguments),
    };
    done.map(|()| Outcome::Done)
}
