//! Studies from the command line: computed for a session, printed as tables, written beside the results where asked.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use doublet_core::replay::MotionAxis;
use doublet_engine::report::{
    self, Outputs, check_table, condition_table, followed_table, kind_table, lag_table, left_out_table,
    monte_carlo_table,
};
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::Session;
use doublet_engine::study::{CheckRequest, Estimator, Study};
use doublet_engine::verdict::Level;

use crate::run::computed;
use crate::text;

/// Arguments of a study.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for all results, including the study.
    #[arg(long)]
    pub out: Option<PathBuf>,
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

/// Arguments of `checks`.
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

impl CheckStudyArguments {
    /// What is checked.
    pub fn request(&self) -> CheckRequest {
        CheckRequest { axis: self.axis, estimators: self.with.iter().copied().collect() }
    }
}

/// An estimator that runs where it is asked for.
fn estimator() -> impl TypedValueParser<Value = &'static Estimator> {
    let keys = Estimator::on_request().map(|estimator| PossibleValue::new(estimator.key).help(estimator.about));
    PossibleValuesParser::new(keys).try_map(|key| Estimator::from_key(&key).ok_or("not an estimator"))
}

fn axis(text: &str) -> Result<MotionAxis, String> {
    let found = MotionAxis::ALL.into_iter().find(|axis| axis.name() == text);
    found.ok_or_else(|| format!("'{text}' is not a motion: use longitudinal, lateral or both"))
}

/// Computes one study of a session and prints it.
///
/// # Errors
/// One line per thing that is wrong.
pub fn study(study: Study, arguments: &StudyArguments) -> Result<(), String> {
    if let Some(out) = &arguments.out {
        report::check_target(out).map_err(|error| error.to_string())?;
    }
    let (session, snapshot) = computed(&arguments.session, &[study])?;
    shown(study, &session, &snapshot, arguments)
}

/// Prints a study that was computed and writes all results where asked.
///
/// # Errors
/// One line: why the results cannot be written.
pub fn shown(study: Study, session: &Session, snapshot: &Snapshot, arguments: &StudyArguments) -> Result<(), String> {
    let results = report::build(session, snapshot);
    if text::is_json() {
        let mut all =
            serde_json::json!({ "version": report::VERSION, "studies": results.studies, "dynamics": results.dynamics });
        if study == Study::Manoeuvres {
            all["manoeuvre_map"] = serde_json::json!(results.manoeuvre_map);
        }
        text::document(&serde_json::to_string_pretty(&all).map_err(|error| error.to_string())?);
    }
    match study {
        Study::Sensitivity => sensitivity(&results.studies),
        Study::Manoeuvres => {
            manoeuvre_map(&results.manoeuvre_map);
            manoeuvres(&results.studies);
        }
        Study::Checks(_) => checks(&results.studies),
        Study::Lags => text::show(&lag_table(&results.studies.lags)),
        Study::Responses | Study::Experiments => {}
        Study::MonteCarlo(_) => monte_carlo(&results),
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

/// Values of `key` in the order of their first appearance.
fn distinct<'r, R>(rows: &'r [R], key: impl Fn(&'r R) -> &'r str) -> Vec<&'r str> {
    let mut found: Vec<&str> = Vec::new();
    for row in rows {
        if !found.contains(&key(row)) {
            found.push(key(row));
        }
    }
    found
}

/// One table per coefficient and group of quantities, as thesis Tables 7.2-7.12, then the widest bars.
fn sensitivity(results: &report::StudyResults) {
    let rows = &results.sensitivity;
    let coefficient = |derivative: &str| derivative.split('_').next().unwrap_or_default().to_owned();
    let derivatives = distinct(rows, |row| &row.derivative);
    let mut coefficients: Vec<String> = derivatives.iter().map(|name| coefficient(name)).collect();
    coefficients.dedup();
    for group in distinct(rows, |row| row.table) {
        let of_group: Vec<_> = rows.iter().filter(|row| row.table == group).collect();
        let mut quantities: Vec<(&str, &str, f64, f64)> = Vec::new();
        for row in &of_group {
            if !quantities.iter().any(|(name, ..)| *name == row.quantity) {
                quantities.push((&row.quantity, row.unit, row.value, row.step));
            }
        }
        text::line(&format!("{group}: change of the derivative per unit"));
        for (name, unit, value, step) in &quantities {
            text::line(&format!("  {name} {} +- {} {unit}", text::number(*value, 5), text::number(*step, 3)));
        }
        let heads: Vec<String> = quantities.iter().map(|(name, unit, ..)| format!("{name} [{unit}]")).collect();
        let header: Vec<&str> = std::iter::once("derivative").chain(heads.iter().map(String::as_str)).collect();
        for coefficient_name in &coefficients {
            let of_coefficient = derivatives.iter().filter(|name| coefficient(name) == *coefficient_name);
            let cells = of_coefficient.map(|derivative| {
                let cell = |quantity: &str| {
                    let row = of_group.iter().find(|row| row.quantity == quantity && row.derivative == *derivative);
                    row.map_or_else(|| "-".to_owned(), |row| text::number(beyond_rounding(row), 3))
                };
                let name = std::iter::once((*derivative).to_owned());
                name.chain(quantities.iter().map(|(quantity, ..)| cell(quantity))).collect()
            });
            text::table(&header, &cells.collect::<Vec<_>>());
            text::line("");
        }
    }
    text::line(
        "dominant uncertainty of each derivative: change over one step, per cent and in corrected standard errors",
    );
    let widest = derivatives.iter().filter_map(|name| results.tornado.iter().find(|bar| bar.derivative == **name));
    let cells = widest.map(|bar| {
        vec![
            bar.derivative.clone(),
            bar.quantity.clone(),
            text::number(bar.low_percent, 3),
            text::number(bar.high_percent, 3),
            text::number(bar.in_standard_errors, 3),
        ]
    });
    text::table(&["derivative", "quantity", "lower %", "higher %", "errors"], &cells.collect::<Vec<_>>());
}

/// The partial derivative, zero where only rounding moved the estimate.
fn beyond_rounding(row: &report::SensitivityRow) -> f64 {
    /// Change of the estimate, per cent, that rounding alone can cause.
    const ROUNDING_PERCENT: f64 = 1e-9;
    if row.relative_percent.abs() < ROUNDING_PERCENT { 0.0 } else { row.partial }
}

/// Manoeuvres and candidates with their flight condition, input and consistency.
fn manoeuvre_map(rows: &[report::MapRow]) {
    let degrees = |angle_rad: Option<f64>| angle_rad.map(f64::to_degrees);
    let cells = rows.iter().map(|row| {
        let numbers = [
            (Some(row.start_s), 6),
            (Some(row.duration_s), 3),
            (row.airspeed_m_s, 3),
            (row.altitude_m, 4),
            (degrees(row.alpha_rad), 3),
            (degrees(row.deflection_rad), 3),
            (row.nis_ratio, 3),
            (row.worst_r_squared(), 3),
            (row.information, 3),
        ];
        let numbers = numbers
            .into_iter()
            .map(|(value, digits)| value.map_or_else(|| "-".to_owned(), |value| text::number(value, digits)));
        let words = [row.name.as_str(), row.role, row.level.map_or("-", Level::name)].map(str::to_owned);
        words.into_iter().chain(numbers).collect()
    });
    let header = [
        "manoeuvre",
        "use",
        "verdict",
        "start, s",
        "duration, s",
        "airspeed, m/s",
        "altitude, m",
        "alpha, deg",
        "deflection, deg",
        "NIS ratio",
        "worst R2",
        "estimate / error",
    ];
    text::table(&header, &cells.collect::<Vec<_>>());
    text::line("");
}

fn manoeuvres(results: &report::StudyResults) {
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

fn monte_carlo(results: &report::Results) {
    let rows = &results.studies.monte_carlo;
    if let Some(row) = rows.first() {
        text::line(&format!("{} realisations of the noise the filter states", row.realisations));
    }
    text::show(&monte_carlo_table(rows, &results.pooled));
}

fn checks(results: &report::StudyResults) {
    let (outputs, estimates): (Vec<_>, Vec<_>) =
        results.checks.iter().partition(|row| row.largest_deviation.is_finite());
    text::show(&check_table(estimates));
    if !outputs.is_empty() {
        text::line("");
        text::line("outputs followed by output error");
        text::show(&followed_table(outputs));
    }
    for finding in &results.check_findings {
        text::line(&format!("{}: {}: {}", finding.level.name(), finding.place, finding.text));
    }
}
