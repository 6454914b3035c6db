//! Studies from the command line: computed for a session, printed as tables, written beside the results where asked.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use doublet_core::replay::MotionAxis;
use doublet_engine::report::document::{sensitivity_tables, widest_table};
use doublet_engine::report::tables::manoeuvre_map;
use doublet_engine::report::{
    self, Outputs, check_table, condition_table, followed_table, kind_table, lag_table, left_out_table,
    monte_carlo_table,
};
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::Session;
use doublet_engine::study::{CheckRequest, Estimator, MonteCarloRequest, Study};

use crate::output_path::output_path;
use crate::run::computed;
use crate::text;

#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for all results, including the study.
    #[arg(long, value_parser = output_path())]
    pub out: Option<PathBuf>,
}

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

#[derive(Debug, Args)]
pub struct CheckStudyArguments {
    /// Options of every study.
    #[command(flatten)]
    pub study: StudyArguments,
    /// Motion for output error: longitudinal, lateral or both [default: by surface].
    #[arg(long, value_name = "AXIS", value_parser = axis)]
    pub axis: Option<MotionAxis>,
    /// Additional estimators.
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',', value_parser = estimator())]
    pub with: Vec<&'static Estimator>,
}

/// An estimator that runs where it is asked for.
fn estimator() -> impl TypedValueParser<Value = &'static Estimator> {
    let keys = Estimator::on_request().map(|estimator| PossibleValue::new(estimator.key).help(estimator.about));
    PossibleValuesParser::new(keys).try_map(|key| Estimator::from_key(&key).ok_or("not an estimator"))
}

fn axis(text: &str) -> Result<MotionAxis, String> {
    let found = MotionAxis::from_name(text);
    found.ok_or_else(|| format!("'{text}' is not a motion: use longitudinal, lateral or both"))
}

/// Columns of the manoeuvre map that fit on a terminal.
const MAP_COLUMNS: [&str; 11] = [
    "name", "use", "level", "start_s", "duration_s", "airspeed_m_s", "altitude_m", "alpha_rad", "deflection_rad",
    "nis_ratio", "worst_r_squared",
];

pub fn sensitivity(arguments: &StudyArguments) -> Result<(), String> {
    study(Study::Sensitivity, arguments)
}

pub fn manoeuvres(arguments: &StudyArguments) -> Result<(), String> {
    study(Study::Manoeuvres, arguments)
}

pub fn checks(arguments: &CheckStudyArguments) -> Result<(), String> {
    let request = CheckRequest { axis: arguments.axis, estimators: arguments.with.iter().copied().collect() };
    study(Study::Checks(request), &arguments.study)
}

pub fn monte_carlo(arguments: &MonteCarloArguments) -> Result<(), String> {
    let request = MonteCarloRequest { realisations: arguments.realisations as usize, seed: arguments.seed };
    study(Study::MonteCarlo(request), &arguments.study)
}

/// Computes one study of a session and prints it.
fn study(study: Study, arguments: &StudyArguments) -> Result<(), String> {
    if let Some(out) = &arguments.out {
        report::check_target(out).map_err(|error| error.to_string())?;
    }
    let (session, snapshot) = computed(&arguments.session, &[study])?;
    shown(study, &session, &snapshot, arguments)
}

/// Prints a study that was computed and writes all results where asked.
pub fn shown(study: Study, session: &Session, snapshot: &Snapshot, arguments: &StudyArguments) -> Result<(), String> {
    let results = report::build(session, snapshot);
    if text::is_json() {
        let mut all =
            serde_json::json!({ "version": report::VERSION, "studies": results.studies, "dynamics": results.dynamics });
        if study == Study::Manoeuvres {
            all["manoeuvre_map"] = serde_json::json!(results.manoeuvre_map);
        }
        text::json(&all)?;
    }
    match study {
        Study::Sensitivity => print_sensitivity(&results.studies),
        Study::Manoeuvres => {
            text::show(&manoeuvre_map(&results).select(&MAP_COLUMNS));
            text::line("");
            print_manoeuvres(&results.studies);
        }
        Study::Checks(_) => print_checks(&results.studies),
        Study::Lags => text::show(&lag_table(&results.studies.lags)),
        Study::Responses | Study::Experiments => {}
        Study::MonteCarlo(_) => print_monte_carlo(&results),
        Study::Dynamics(_) => results.dynamics.iter().for_each(crate::dynamics::print_modes),
    }
    if let Some(out) = &arguments.out {
        let put = report::write(session, snapshot, out, &Outputs::default(), &Control::default(), &|_| {})
            .map_err(|error| error.to_string())?;
        put.notes().for_each(|note| text::line(&note));
        text::line(&format!("results in {}", put.folder.display()));
    }
    Ok(())
}

/// Change of each derivative per unit of each quantity, as thesis Tables 7.2-7.12, then the widest bars.
fn print_sensitivity(results: &report::StudyResults) {
    for (group, table) in sensitivity_tables(results) {
        text::line(&format!("{group}: change of the derivative per unit"));
        text::show(&table);
        text::line("");
    }
    text::line("dominant uncertainty of each derivative: change over one step");
    text::show(&widest_table(results));
}

fn print_manoeuvres(results: &report::StudyResults) {
    let parts = [
        ("each manoeuvre left out and predicted by the others", left_out_table(&results.leave_one_out)),
        ("kinds of input: mean ± scatter (manoeuvres)", kind_table(&results.input_kinds)),
        ("derivatives over the flight condition", condition_table(&results.conditions)),
    ];
    for (about, table) in parts {
        text::line(about);
        text::show(&table);
        text::line("");
    }
}

fn print_monte_carlo(results: &report::Results) {
    let rows = &results.studies.monte_carlo;
    if let Some(row) = rows.first() {
        text::line(&format!("{} realisations of the filter's noise settings", row.realisations));
    }
    text::show(&monte_carlo_table(rows, &results.pooled));
}

fn print_checks(results: &report::StudyResults) {
    let (outputs, estimates): (Vec<_>, Vec<_>) =
        results.checks.iter().partition(|row| row.largest_deviation.is_finite());
    text::show(&check_table(estimates));
    if !outputs.is_empty() {
        text::line("");
        text::line("outputs simulated by output error");
        text::show(&followed_table(outputs));
    }
    for finding in &results.check_findings {
        text::line(&format!("{}: {}: {}", finding.level.name(), finding.place, finding.text));
    }
}
