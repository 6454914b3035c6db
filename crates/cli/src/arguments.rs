//! Arguments of every command.

use crate::aircraft::{AircraftArguments, PlainArguments};
use crate::compare::CompareArguments;
use crate::compatibility::CompatibilityArguments;
use crate::equations::EquationArguments;
use crate::fix::FixArguments;
use crate::fmu::FmuArguments;
use crate::prior::PriorArguments;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use doublet_core::replay::MotionAxis;
use doublet_dynamics::design::DesignKind;
use doublet_engine::report::document::SectionKind;
use doublet_engine::report::{HistoryFormat, TableFormat};
use doublet_engine::session::Surface;
use doublet_engine::stage::PercentRule;
use doublet_engine::study::LagKind;
use doublet_report::ReportFormat;

use crate::dynamics::{LinearArguments, ModesArguments, QualitiesArguments};
use crate::manual::HelpArguments;
use crate::map::MapArguments;
use crate::propagate::PropagateArguments;
use crate::propose::ProposeArguments;
use crate::regress::RegressArguments;
use crate::response::{LoesArguments, ResponseArguments};
use crate::shell::{CompletionArguments, ManArguments};
use crate::structure::StructureArguments;
use crate::tune::TuneArguments;
use crate::variants::VariantArguments;

/// Aircraft system identification from flight test.
///
/// Without a command the workbench opens, on SESSION or on the session that comes with the program.
#[derive(Debug, Parser)]
#[command(name = "doublet", version = crate::version::version(), about, args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub struct Arguments {
    /// Session to open in the workbench: a file, or `builtin:` and the name of one that comes with the program.
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
    /// Guess a channel map for recordings, or list and print those that come with the program.
    Map(MapArguments),
    /// Make a session for one or more recordings.
    New(NewArguments),
    /// List, print or make aircraft files.
    Aircraft(AircraftArguments),
    /// Check a session or an aircraft file and print what it says.
    Check(CheckArguments),
    /// Compute everything a session asks for and write tables and time histories.
    Run(RunArguments),
    /// Compute everything a session asks for and write a report on it.
    Report(ReportArguments),
    /// Print how each derivative changes with centre of gravity, inertia, deflections, air angles and fuel.
    Sensitivity(StudyArguments),
    /// Compare manoeuvres: each left out in turn, kinds of input, derivatives over the flight condition.
    Manoeuvres(StudyArguments),
    /// Estimate every window again in the frequency domain and by output error.
    Checks(CheckStudyArguments),
    /// Find lag and delay of every control by the fit.
    Lags(LagArguments),
    /// Watch a flight while it is flown, or a recording flown again: filter, derivatives with error bars, correlation and limits.
    Live(crate::live::LiveArguments),
    /// Estimate constant errors of the sensors over all windows: bias, scale factor, misalignment.
    Compatibility(CompatibilityArguments),
    /// Search for the terms the data ask for, stepwise or by orthogonal functions, and print every step.
    Structure(StructureArguments),
    /// Fit a column of any table by terms of others, with plain and corrected errors; no session is needed.
    Regress(RegressArguments),
    /// Fit equations of motion, as you write them, to columns of any table by equation error and output error.
    Equations(EquationArguments),
    /// Print the frequency response between signals of a session or columns of a table, with coherence and error bars.
    Response(ResponseArguments),
    /// Fit a low-order equivalent system to a frequency response: gain, zeros, poles, delay, bandwidth and phase delay.
    Loes(LoesArguments),
    /// Print the derivatives by weighted, generalised, constrained and total least squares beside the ordinary ones.
    Variants(VariantArguments),
    /// Carry fresh noise of the recording through both steps, many times.
    MonteCarlo(MonteCarloArguments),
    /// Compare the experiments of a session: verdict, NIS, fits, prediction and derivatives of each.
    Compare(CompareArguments),
    /// List the fixes of a session's findings with the verdict before and after each, or apply some.
    Fix(FixArguments),
    /// Propose manoeuvre windows, steady windows or noise from the recordings of a session.
    Propose(ProposeArguments),
    /// Fly validation manoeuvres again with the identified model and print which tests of a simulator's qualification pass.
    Match(MatchArguments),
    /// Judge the objective tests of a qualification test guide on a session and write the guide.
    Qtg(crate::qtg::QtgArguments),
    /// Write the identified aircraft as a Functional Mock-up Unit (FMI 3.0) that begins in a trim.
    Fmu(FmuArguments),
    /// Set an earlier estimate beside that of the flight: both combined, and whether they contradict each other.
    Prior(PriorArguments),
    /// Print the linear model about a trim, or write it as MAT, JSON or CSV.
    Linear(LinearArguments),
    /// Print the natural modes about a trim with their intervals, or a root locus.
    Modes(ModesArguments),
    /// Print the levels of the flying qualities about a trim, with reasons and probabilities.
    Qualities(QualitiesArguments),
    /// Design the inputs of the next flight within limits: signals, excursions and the standard errors they will give.
    Design(crate::design::DesignArguments),
    /// Lay out a campaign: envelope, test points in their order with fuel and centre of gravity, a card each, matched with what was flown.
    Campaign(crate::campaign::CampaignArguments),
    /// Say whether what was flown is enough: errors after every window against goals, and the next best manoeuvre.
    Enough(crate::design::EnoughArguments),
    /// Print a function of the derivatives with its interval.
    Propagate(PropagateArguments),
    /// Write the identified model for JSBSim or as DAVE-ML, with the points it is checked at.
    Export(ExportArguments),
    /// Show what differs between two sessions or two runs: settings, and derivatives with the significance of their difference.
    Diff(DiffArguments),
    /// Run many sessions, or one with settings swept, over all cores; what was interrupted is taken up again.
    Batch(BatchArguments),
    /// Fly a scenario many times over and print how often the intervals of the derivatives hold the truth.
    Coverage(CoverageArguments),
    /// Fly flights of known truth, sound and faulty, and print how the verdict's levels fit them.
    Calibrate(CalibrateArguments),
    /// Write the estimates of the shipped flight beside its truth into a document.
    Fidelity(FidelityArguments),
    /// Print the JSON Schema of a file that doublet reads, for editors that complete and check TOML.
    Schema(crate::schema::SchemaArguments),
    /// Fly a simulated flight and write its recordings and its truth.
    Simulate(SimulateArguments),
    /// Print power, thrust and their sensitivities of an aircraft's engines at one condition.
    Engine(EngineArguments),
    /// Print noise settings, or a sensor's delay, that make the measurements of a session most likely.
    Tune(TuneArguments),
    /// Print the derivatives of a Digital DATCOM listing beside identified ones, or write its input deck.
    Datcom(DatcomArguments),
    /// Print a page of the manual or the help of a command, or search the manual.
    Help(HelpArguments),
    /// Print the completions of commands and options for a shell.
    Completions(CompletionArguments),
    /// Write man pages, one per command.
    Man(ManArguments),
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// File, or folder of one file per channel.
    pub recording: PathBuf,
    /// Channel map (file, or the name of one that comes with the program) to show what each channel would be used for.
    #[arg(long)]
    pub map: Option<String>,
    /// Print one JSON document.
    #[arg(long)]
    pub json: bool,
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
    /// Take the channel map that `doublet map` guesses; the session holds it and it is printed row by row.
    #[arg(long, conflicts_with = "map")]
    pub guess: bool,
    /// A channel for a role in the place of the one guessed, with its calibration: SI value = scale x (value + offset) of its unit.
    /// May be given several times.
    #[arg(long, value_name = crate::role_option::FORM, requires = "guess")]
    pub role: Vec<String>,
    /// The channel that is the time of its source, with its unit, where none is recognised. May be given several times.
    #[arg(long, value_name = crate::time_option::FORM, requires = "guess")]
    pub time: Vec<String>,
    /// Aircraft (file or name); without it the one the channel map names. Without any only flight paths are computed.
    #[arg(long)]
    pub aircraft: Option<String>,
    /// An aircraft described by its numbers, which is written beside the session.
    #[command(flatten)]
    pub plain: PlainArguments,
    /// Put all recordings into one flight, on one time line.
    #[arg(long)]
    pub merge: bool,
    /// Terms of the coefficients to start from.
    #[arg(long, value_enum, default_value_t = StructureName::Thesis)]
    pub structure: StructureName,
}

/// A model structure to start from.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StructureName {
    /// Thesis Eq. 3.21-3.22: constant, flow angle, rates and deflections.
    Thesis,
    /// Thesis Eq. B.1-B.2: also the rates of the flow angles.
    Alternative,
    /// Also alpha squared in CX, CZ and Cm.
    Quadratic,
    /// Also the total-pressure rise through the propellers in CX, CZ and Cm.
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
    /// Folder for the results: it appears complete or not at all.
    #[arg(long)]
    pub out: PathBuf,
    /// Studies to compute as well.
    #[arg(long, value_name = "STUDY,...", value_delimiter = ',')]
    pub with: Vec<StudyName>,
    /// Forms of the tables.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "csv", value_parser = table_format())]
    pub tables: Vec<String>,
    /// Forms of the time histories.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "hdf5", value_parser = history_format())]
    pub histories: Vec<String>,
    /// Put every recorded channel into the time histories too.
    #[arg(long)]
    pub recordings: bool,
    /// Exit with 3 where the verdict is caution as well, not only where it is bad.
    #[arg(long)]
    pub strict: bool,
    /// Print every window, every table and every finding.
    #[arg(long)]
    pub verbose: bool,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the report, which has the name of the session file.
    #[arg(long, default_value = ".")]
    pub out: PathBuf,
    /// Forms.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "html,pdf", value_parser = report_format())]
    pub format: Vec<String>,
    /// Sections; all of them unless given.
    #[arg(long, value_name = "SECTION,SECTION", value_delimiter = ',', value_parser = section())]
    pub sections: Vec<String>,
}

/// A study `run` can compute as well.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StudyName {
    /// Derivatives against what they were computed with.
    Sensitivity,
    /// Manoeuvre against manoeuvre.
    Manoeuvres,
    /// Every window again in the frequency domain and by output error.
    Checks,
    /// Lag and delay of every control.
    Lags,
    /// Frequency responses of the rates to the controls.
    Responses,
    /// Derivatives under fresh noise of the recording, 200 realisations.
    MonteCarlo,
    /// Linear model, modes and flying qualities about the median condition of the windows.
    Dynamics,
}

/// Arguments of a study.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for all results, those of the study among them.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Arguments of `checks`.
#[derive(Debug, Args)]
pub struct CheckStudyArguments {
    /// What every study takes.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Motion that output error follows, the other as reconstructed: longitudinal, lateral or both; without it that which each
    /// window's surface moves.
    #[arg(long, value_name = "AXIS", value_parser = axis)]
    pub axis: Option<MotionAxis>,
}

fn axis(text: &str) -> Result<MotionAxis, String> {
    let found = MotionAxis::ALL.into_iter().find(|axis| axis.name() == text);
    found.ok_or_else(|| format!("'{text}' is no motion: use longitudinal, lateral or both"))
}

/// Arguments of `lags`.
#[derive(Debug, Args)]
pub struct LagArguments {
    /// What every study takes.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Takes what was found into the session, which is saved: a control and what of it, for example elevator=delay or rudder=lag.
    #[arg(long, value_name = "CONTROL=KIND", value_parser = crate::lags::taken)]
    pub take: Vec<(Surface, LagKind)>,
}

/// Arguments of `match`.
#[derive(Debug, Args)]
pub struct MatchArguments {
    /// Session file.
    pub session: PathBuf,
    /// Tolerance file; without it those of 14 CFR Part 60.
    #[arg(long, value_name = "FILE")]
    pub tolerances: Option<PathBuf>,
    /// What percentages are of: of the largest value in the record (range), as the regulation has it, or of each sample.
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
    /// Folder for the files; files of an earlier export are replaced, others never are.
    #[arg(long)]
    pub out: PathBuf,
}

/// Arguments of `monte-carlo`.
#[derive(Debug, Args)]
pub struct MonteCarloArguments {
    /// What every study takes.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Number of realisations.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    pub realisations: u32,
    /// Seed of the noise: the same seed gives the same numbers.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// Session, which is run, or folder of results.
    pub first: PathBuf,
    /// Another one.
    pub second: PathBuf,
    /// Compare settings only: nothing is run.
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
    /// Table to write, .parquet or .csv; what is finished is kept in NAME.runs beside it.
    #[arg(long)]
    pub out: PathBuf,
    /// Compute the I-th of N parts and write no table: for the jobs of a scheduler, which share the folder of finished runs.
    #[arg(long, value_name = "I/N", value_parser = part)]
    pub task: Option<(usize, usize)>,
}

/// Arguments of `coverage`.
#[derive(Debug, Args)]
pub struct CoverageArguments {
    /// Session whose settings identify the flights; without it those of the session that comes with the program.
    pub session: Option<PathBuf>,
    /// Scenario to fly: one that comes with the program, or a file (.toml) as `doublet design --out` writes it.
    #[arg(long, default_value = crate::coverage::SCENARIO)]
    pub scenario: String,
    /// Standard deviation of the gusts, m/s, in the place of the scenario's.
    #[arg(long, value_name = "M_S", value_parser = not_negative)]
    pub gusts: Option<f64>,
    /// Number of flights.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
    /// Seed of the first flight; each following one has the next.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print instead how the flights are judged: nothing is wrong with them.
    #[arg(long)]
    pub verdict: bool,
    /// Print instead how often the intervals of the natural modes hold those of the truth at the same trim.
    #[arg(long, conflicts_with = "verdict")]
    pub modes: bool,
    /// Identify flights of the scenario, design an input of this kind from them, fly that many times and print predicted errors and
    /// excursions beside the scatter.
    #[arg(long, value_name = "KIND", conflicts_with_all = ["verdict", "modes"], value_parser = crate::design::kind)]
    pub design: Option<DesignKind>,
    /// Flights of the scenario that the design starts from.
    #[arg(long, requires = "design", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub known: u32,
    /// Surfaces of that design.
    #[arg(long, value_name = "SURFACE,...", value_delimiter = ',', requires = "design", default_value = "aileron,elevator,rudder", value_parser = PossibleValuesParser::new(doublet_dynamics::design::SURFACE_NAMES))]
    pub surfaces: Vec<String>,
    /// Time of its windows together, s.
    #[arg(long, value_name = "S", requires = "design", default_value_t = 120.0)]
    pub time: f64,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Session whose settings identify the flights [default: the shipped one, with gusts by their likelihood as in new sessions].
    pub session: Option<PathBuf>,
    /// Scenario to fly.
    #[arg(long, default_value = crate::coverage::SCENARIO)]
    pub scenario: String,
    /// Flights of each case.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub realisations: u64,
    /// Seed of the first flight; each following one has the next.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print one JSON document.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `fidelity`.
#[derive(Debug, Args)]
pub struct FidelityArguments {
    /// Document whose tables are written anew: everything behind its marker line.
    #[arg(long)]
    pub out: PathBuf,
    /// Number of flights of the coverage study.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub realisations: u64,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// Scenario to fly: one that comes with the program, or a file (.toml) as `doublet design --out` writes it.
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
    /// Differences over this part of each input's value, per cent; without it over the resolution the input is read to.
    #[arg(long, value_name = "PERCENT")]
    pub step_percent: Option<f64>,
    /// Let the temperature at sea level change the static pressure, as the published sensitivities do.
    #[arg(long)]
    pub thesis_density: bool,
}

/// Arguments of `datcom`.
#[derive(Debug, Args)]
pub struct DatcomArguments {
    /// Output listing of Digital DATCOM.
    #[arg(required_unless_present = "deck", conflicts_with = "deck")]
    pub listing: Option<PathBuf>,
    /// Aircraft (file or name) whose normalisation of rates the derivatives are to have; without it q c/V, p b/2V and r b/2V.
    #[arg(long, conflicts_with = "deck")]
    pub aircraft: Option<String>,
    /// Results of a run to stand beside: its results.json.
    #[arg(long, value_name = "RESULTS.JSON", conflicts_with = "deck")]
    pub results: Option<PathBuf>,
    /// Angles of attack, deg: those of the tables (without them that of level flight), or of the deck (-2 to 13).
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
    let wrong = || format!("'{text}' is no part: write it as I/N with I from 1 to N, for example 3/8");
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
