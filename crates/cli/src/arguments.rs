//! Arguments of every command.

use crate::aircraft::{AircraftArguments, PlainArguments};
use crate::compare::CompareArguments;
use crate::compatibility::CompatibilityArguments;
use crate::equations::EquationArguments;
use crate::fix::FixArguments;
use crate::fmu::FmuArguments;
use crate::prior::PriorArguments;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use doublet_dynamics::design::DesignKind;
use doublet_engine::report::document::SectionKind;
use doublet_engine::report::{HistoryFormat, TableFormat};
use doublet_engine::session::Surface;
use doublet_engine::stage::PercentRule;
use doublet_engine::study::{LagKind, Study};
use doublet_report::ReportFormat;

use crate::dynamics::{JudgedArguments, LinearArguments, ModesArguments, QualitiesArguments};
use crate::manual::HelpArguments;
use crate::map::MapArguments;
use crate::propagate::PropagateArguments;
use crate::propose::ProposeArguments;
use crate::regress::RegressArguments;
use crate::response::{LoesArguments, ResponseArguments};
use crate::shell::{CompletionArguments, ManArguments};
use crate::structure::StructureArguments;
use crate::study::CheckStudyArguments;
use crate::tune::TuneArguments;
use crate::variants::VariantArguments;

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
    /// Propose manoeuvres, steady windows or noise from the recordings of a session.
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
    /// Compare flights of a design with its promise and the truth.
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
    /// Find the noise settings, or a sensor delay, of maximum likelihood.
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

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// File, or folder of one file per channel.
    pub recording: PathBuf,
    /// Channel map (file or name of a shipped one) to apply.
    #[arg(long)]
    pub map: Option<String>,
    /// Print one JSON document.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `new`.
#[derive(Debug, Args)]
pub struct NewArguments {
    /// Recordings: one flight each, unless --merge is given.
    #[arg(required = true)]
    pub recordings: Vec<PathBuf>,
    /// Session file to write.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Channel map (file or name) [default: the best-fitting shipped map].
    #[arg(long)]
    pub map: Option<String>,
    /// Use the guessed channel map; the session stores it.
    #[arg(long, conflicts_with = "map")]
    pub guess: bool,
    /// Override a role's channel: SI value = scale x (value + offset). Repeatable.
    #[arg(long, value_name = crate::role_option::FORM, requires = "guess")]
    pub role: Vec<String>,
    /// Time channel of a source and its unit. Repeatable.
    #[arg(long, value_name = crate::time_option::FORM, requires = "guess")]
    pub time: Vec<String>,
    /// Aircraft (file or name) [default: the one the channel map names].
    #[arg(long)]
    pub aircraft: Option<String>,
    /// Aircraft described by numbers; its file is written beside the session.
    #[command(flatten)]
    pub plain: PlainArguments,
    /// Merge all recordings into one flight on one time line.
    #[arg(long)]
    pub merge: bool,
    /// Initial terms of the coefficients.
    #[arg(long, value_enum, default_value_t = StructureName::Thesis)]
    pub structure: StructureName,
}

/// Initial model structure.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StructureName {
    /// Thesis Eq. 3.21-3.22: constant, flow angle, rates and deflections.
    Thesis,
    /// Thesis Eq. B.1-B.2: adds the rates of the flow angles.
    Alternative,
    /// Adds alpha squared in CX, CZ and Cm.
    Quadratic,
    /// Adds the propeller total-pressure rise in CX, CZ and Cm.
    WithPower,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Session or aircraft file.
    pub file: PathBuf,
    /// Print JSON: findings and relations between channels.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the results; appears only when complete.
    #[arg(long)]
    pub out: PathBuf,
    /// Additional studies to compute.
    #[arg(long, value_name = "STUDY,...", value_delimiter = ',', value_parser = study())]
    pub with: Vec<Study>,
    /// Formats of the tables.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "csv", value_parser = table_format())]
    pub tables: Vec<String>,
    /// Formats of the time histories.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "hdf5", value_parser = history_format())]
    pub histories: Vec<String>,
    /// Include every recorded channel in the time histories.
    #[arg(long)]
    pub recordings: bool,
    /// Exit with code 3 also if the verdict is caution.
    #[arg(long)]
    pub strict: bool,
    /// Print all manoeuvres, tables and findings.
    #[arg(long)]
    pub verbose: bool,
}

/// Forms of a report that this build writes.
pub const REPORTS: &str = if cfg!(feature = "pdf") { "html,pdf" } else { "html" };

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the report, named after the session file.
    #[arg(long, default_value = ".")]
    pub out: PathBuf,
    /// Formats.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = REPORTS, value_parser = report_format())]
    pub format: Vec<String>,
    /// Sections [default: all].
    #[arg(long, value_name = "SECTION,SECTION", value_delimiter = ',', value_parser = section())]
    pub sections: Vec<String>,
    /// Leave out the appendices.
    #[arg(long)]
    pub no_appendix: bool,
    /// Earlier estimate to compare with, as for `prior`.
    #[arg(long, value_name = "FILE")]
    pub prior: Option<PathBuf>,
    /// Class, category and controls, as for `qualities`.
    #[command(flatten)]
    pub judged: JudgedArguments,
}

/// Arguments of a study.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for all results, including the study.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Arguments of `lags`.
#[derive(Debug, Args)]
pub struct LagArguments {
    /// Options of every study.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Save the result to the session: CONTROL=delay or CONTROL=lag.
    #[arg(long, value_name = "CONTROL=KIND", value_parser = crate::lags::taken)]
    pub take: Vec<(Surface, LagKind)>,
}

/// Arguments of `match`.
#[derive(Debug, Args)]
pub struct MatchArguments {
    /// Session file.
    pub session: PathBuf,
    /// Tolerance file [default: 14 CFR Part 60].
    #[arg(long, value_name = "FILE")]
    pub tolerances: Option<PathBuf>,
    /// Percentages refer to the largest value (range) or to each sample.
    #[arg(long, value_name = "OF", default_value = "range", value_parser = percent_rules())]
    pub percent: String,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Session file.
    pub session: PathBuf,
    /// Formats: jsbsim, daveml.
    #[arg(long, value_delimiter = ',', default_value = "jsbsim,daveml")]
    pub format: Vec<String>,
    /// Folder for the files; only files of an earlier export are replaced.
    #[arg(long)]
    pub out: PathBuf,
}

/// Arguments of `monte-carlo`.
#[derive(Debug, Args)]
pub struct MonteCarloArguments {
    /// Options of every study.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Number of realisations.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    pub realisations: u32,
    /// Seed of the noise; equal seeds give equal numbers.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// Session (will be run) or folder of results.
    pub first: PathBuf,
    /// Session or folder to compare with.
    pub second: PathBuf,
    /// Compare settings only, without a run.
    #[arg(long)]
    pub settings: bool,
    /// Print JSON.
    #[arg(long, conflicts_with = "csv")]
    pub json: bool,
    /// Print CSV.
    #[arg(long)]
    pub csv: bool,
}

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct BatchArguments {
    /// Folder of sessions and sweeps, or one of them.
    pub sessions: PathBuf,
    /// Table to write, .parquet or .csv; finished runs are kept in NAME.runs.
    #[arg(long)]
    pub out: PathBuf,
    /// Compute part I of N without a table, for scheduler jobs.
    #[arg(long, value_name = "I/N", value_parser = part)]
    pub task: Option<(usize, usize)>,
}

/// Arguments of `coverage`.
#[derive(Debug, Args)]
pub struct CoverageArguments {
    /// Session whose settings identify the flights [default: the shipped one].
    pub session: Option<PathBuf>,
    /// Scenario to simulate: a shipped name, or a file of `doublet design`.
    #[arg(long, default_value = crate::coverage::SCENARIO)]
    pub scenario: String,
    /// Override the standard deviation of the gusts, m/s.
    #[arg(long, value_name = "M_S", value_parser = not_negative)]
    pub gusts: Option<f64>,
    /// Number of flights.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
    /// Seed of the first flight; each next flight adds one.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Simulate the recorders and their clocks too.
    #[arg(long, conflicts_with_all = ["verdict", "modes", "design"])]
    pub recorded: bool,
    /// Print the false-alarm rate on fault-free flights instead.
    #[arg(long)]
    pub verdict: bool,
    /// Print the coverage of the mode intervals instead.
    #[arg(long, conflicts_with = "verdict")]
    pub modes: bool,
    /// Design and simulate an input of this kind; compare predictions with results.
    #[arg(long, value_name = "KIND", conflicts_with_all = ["verdict", "modes"], value_parser = crate::design::kind)]
    pub design: Option<DesignKind>,
    /// Number of flights analysed before the design.
    #[arg(long, requires = "design", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub known: u32,
    /// Surfaces of that design.
    #[arg(long, value_name = "SURFACE,...", value_delimiter = ',', requires = "design", default_value = "aileron,elevator,rudder", value_parser = PossibleValuesParser::new(doublet_dynamics::design::SURFACE_NAMES))]
    pub surfaces: Vec<String>,
    /// Total time of the designed manoeuvres, s.
    #[arg(long, value_name = "S", requires = "design", default_value_t = 120.0)]
    pub time: f64,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Session for the settings [default: shipped one, gusts by likelihood].
    pub session: Option<PathBuf>,
    /// Scenario to simulate.
    #[arg(long, default_value = crate::coverage::SCENARIO)]
    pub scenario: String,
    /// Flights of each case.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub realisations: u64,
    /// Seed of the first flight; each next flight adds one.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print one JSON document.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `fidelity`.
#[derive(Debug, Args)]
pub struct FidelityArguments {
    /// Document whose tables are rewritten below its marker line.
    #[arg(long)]
    pub out: PathBuf,
    /// Flights of the coverage study.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// Scenario to simulate: a shipped name, or a file of `doublet design`.
    pub scenario: Option<String>,
    /// Folder for the recordings; appears only when complete.
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Seed of noise, gusts and pilot imperfections; equal seeds give equal bytes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Change a true derivative, for example Cm_alpha=-0.9. Repeatable.
    #[arg(long, value_name = "NAME=VALUE", value_parser = derivative)]
    pub derivative: Vec<(String, f64)>,
    /// Factor on the amplitude of every manoeuvre.
    #[arg(long, default_value_t = 1.0)]
    pub amplitude: f64,
    /// True airspeed of a trimmed scenario, kt.
    #[arg(long, value_name = "KT")]
    pub airspeed_kt: Option<f64>,
    /// Altitude of a trimmed scenario, ft.
    #[arg(long, value_name = "FT")]
    pub altitude_ft: Option<f64>,
    /// List scenarios, aircraft and inputs.
    #[arg(long)]
    pub list: bool,
}

/// Arguments of `engine`.
#[derive(Debug, Args)]
pub struct EngineArguments {
    /// Aircraft (file or name).
    pub aircraft: String,
    /// Speed of the crankshaft, rev/min.
    #[arg(long, allow_negative_numbers = true)]
    pub rpm: f64,
    /// Absolute manifold pressure, inHg.
    #[arg(long, value_name = "INHG", allow_negative_numbers = true)]
    pub manifold_inhg: f64,
    /// Pressure altitude, ft.
    #[arg(long, value_name = "FT", allow_negative_numbers = true)]
    pub altitude_ft: f64,
    /// Static air temperature at that altitude, degC.
    #[arg(long, value_name = "DEGC", allow_negative_numbers = true)]
    pub oat_c: f64,
    /// True airspeed, kt.
    #[arg(long, value_name = "KT", allow_negative_numbers = true)]
    pub airspeed_kt: f64,
    /// Step of the differences, per cent of each input [default: its resolution].
    #[arg(long, value_name = "PERCENT")]
    pub step_percent: Option<f64>,
    /// Let sea-level temperature change static pressure, as in the thesis.
    #[arg(long)]
    pub thesis_density: bool,
}

/// Arguments of `datcom`.
#[derive(Debug, Args)]
pub struct DatcomArguments {
    /// Output listing of Digital DATCOM.
    #[arg(required_unless_present = "deck", conflicts_with = "deck")]
    pub listing: Option<PathBuf>,
    /// Aircraft for the rate normalisation [default: q c/V, p b/2V, r b/2V].
    #[arg(long, conflicts_with = "deck")]
    pub aircraft: Option<String>,
    /// Results to compare with: results.json of a run.
    #[arg(long, value_name = "RESULTS.JSON", conflicts_with = "deck")]
    pub results: Option<PathBuf>,
    /// Angles of attack, deg [default: level flight; deck: -2 to 13].
    #[arg(long, value_name = "DEG,DEG", value_delimiter = ',', allow_negative_numbers = true)]
    pub alpha_deg: Vec<f64>,
    /// Aircraft (file or name) to write an input deck for.
    #[arg(long, value_name = "AIRCRAFT", requires = "output")]
    pub deck: Option<String>,
    /// Deck file to write.
    #[arg(short, long, requires = "deck")]
    pub output: Option<PathBuf>,
    /// Mach number of the deck.
    #[arg(long, default_value_t = 0.137)]
    pub mach: f64,
    /// Altitude of the deck, m.
    #[arg(long, value_name = "M", default_value_t = 1130.0, allow_negative_numbers = true)]
    pub altitude_m: f64,
}

/// Reads `I/N`.
fn part(text: &str) -> Result<(usize, usize), String> {
    let wrong = || format!("'{text}' is not a part: write it as I/N with I from 1 to N, for example 3/8");
    let (part, parts) = text.split_once('/').ok_or_else(wrong)?;
    let (part, parts) = part.parse().ok().zip(parts.parse().ok()).ok_or_else(wrong)?;
    if (1..=parts).contains(&part) { Ok((part, parts)) } else { Err(wrong()) }
}

/// Names of table formats.
fn table_format() -> PossibleValuesParser {
    TableFormat::ALL.map(TableFormat::name).into()
}

/// Names of formats of time histories.
fn history_format() -> PossibleValuesParser {
    HistoryFormat::ALL.map(HistoryFormat::name).into()
}

/// A study by its name.
fn study() -> impl TypedValueParser<Value = Study> {
    let keys = Study::keys().map(|(key, about)| PossibleValue::new(key).help(about));
    PossibleValuesParser::new(keys).try_map(|key| Study::from_key(&key).ok_or("not a study"))
}

/// A number from zero up.
fn not_negative(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| "give a number from zero up".to_owned())
}

/// Names of the rules for percentages.
pub fn percent_rules() -> PossibleValuesParser {
    PercentRule::ALL.map(PercentRule::name).into()
}

/// Names of report formats.
pub fn report_format() -> PossibleValuesParser {
    ReportFormat::ALL.map(ReportFormat::name).into()
}

/// Names of report sections.
fn section() -> PossibleValuesParser {
    SectionKind::ALL.map(SectionKind::name).into()
}

/// Reads `NAME=VALUE`.
fn derivative(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write it as NAME=VALUE, for example Cm_alpha=-0.9")?;
    let value: f64 = value.trim().parse().map_err(|_| format!("'{value}' is not a number"))?;
    Ok((name.trim().to_owned(), value))
}
