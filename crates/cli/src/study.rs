//! Studies from the command line: computed for a session, printed as tables, written beside the results where asked.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use doublet_core::replay::MotionAxis;
use doublet_engine::report::{self, Outputs};
use doublet_engine::run::{Control, Snapshot};
use doublet_engine::session::Session;
use doublet_engine::study::{CheckRequest, Estimator, Study};
use doublet_engine::verdict::Level;

use crate::arguments::StudyArguments;
use crate::lags;
use crate::run::computed;
use crate::text;

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
        Study::Lags => lags::print(&results.studies),
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
    text::line("each manoeuvre left out and predicted by the others");
    let mut last = ("", "");
    let mut cells: Vec<Vec<String>> = Vec::new();
    for row in &results.leave_one_out {
        let here = (row.coefficient, row.window.as_str());
        if here != last {
            last = here;
            let of_window =
                results.leave_one_out.iter().filter(|other| (other.coefficient, other.window.as_str()) == here);
            let largest = of_window.max_by(|a, b| a.shift_in_errors.abs().total_cmp(&b.shift_in_errors.abs()));
            let shift = largest.map_or_else(String::new, |row| {
                format!("{} by {}", row.derivative, text::number(row.shift_in_errors, 2))
            });
            let [identified, own] =
                [row.r_squared_identified_constants, row.r_squared_own_constant].map(|value| text::number(value, 3));
            cells.push(vec![row.coefficient.to_owned(), row.window.clone(), identified, own, shift]);
        }
    }
    text::table(&["", "manoeuvre", "R2, others' constants", "R2, own constant", "largest shift, std errors"], &cells);
    text::line("");
    text::line("kinds of input: mean and scatter over the manoeuvres");
    let cells = results.input_kinds.iter().map(|row| {
        let side = |count: usize, mean, scatter| {
            format!("{} +- {} ({count})", text::number(mean, 4), text::number(scatter, 2))
        };
        vec![
            row.derivative.clone(),
            format!("{}: {}", row.first_kind, side(row.first_count, row.first_mean, row.first_scatter)),
            format!("{}: {}", row.second_kind, side(row.second_count, row.second_mean, row.second_scatter)),
            text::number(row.difference_in_errors, 2),
        ]
    });
    text::table(&["derivative", "first", "second", "difference, std errors"], &cells.collect::<Vec<_>>());
    text::line("");
    text::line("derivatives over the flight condition");
    let cells = results.conditions.iter().map(|row| {
        vec![
            format!("{} over {}", row.derivative, row.variables),
            row.parameter.clone(),
            text::number(row.estimate, 4),
            text::number(row.standard_error, 2),
            text::number(row.scatter_ratio, 2),
            row.error.clone().unwrap_or_default(),
        ]
    });
    text::table(&["derivative", "parameter", "estimate", "std error", "scatter", ""], &cells.collect::<Vec<_>>());
}

fn monte_carlo(results: &report::Results) {
    let rows = &results.studies.monte_carlo;
    if let Some(row) = rows.first() {
        text::line(&format!("{} realisations of the noise the filter states", row.realisations));
    }
    let corrected = |name: &str| {
        let derivatives = results.pooled.iter().flat_map(|fit| &fit.derivatives);
        derivatives.into_iter().find(|row| row.name == name).map_or(f64::NAN, |row| row.corrected_standard_error)
    };
    let cells = rows.iter().map(|row| {
        vec![
            row.derivative.clone(),
            text::number(row.estimate, 5),
            text::number(corrected(&row.derivative), 2),
            text::number(row.noise_error, 2),
            text::number(row.shift, 2),
            text::number(row.extrapolated, 5),
        ]
    });
    let header = ["derivative", "estimate", "corrected error", "noise error", "shift by noise", "without shift"];
    text::table(&header, &cells.collect::<Vec<_>>());
}

fn checks(results: &report::StudyResults) {
    let is_output = |row: &&report::CheckRow| row.largest_deviation.is_finite();
    let cells = results.checks.iter().filter(|row| !is_output(row)).map(|row| {
        let pair = |value: f64, error: f64| {
            if value.is_finite() {
                format!("{} +- {}", text::number(value, 4), text::number(error, 2))
            } else {
                String::new()
            }
        };
        vec![
            row.window.clone(),
            method(row),
            row.derivative.clone(),
            pair(row.estimate, row.standard_error),
            pair(row.equation_error, row.equation_standard_error),
            row.error.clone().unwrap_or_default(),
        ]
    });
    text::table(&["manoeuvre", "method", "", "estimate", "equation error", ""], &cells.collect::<Vec<_>>());
    let outputs: Vec<_> = results.checks.iter().filter(is_output).collect();
    if !outputs.is_empty() {
        text::line("");
        text::line("outputs followed by output error");
        let cells = outputs.into_iter().map(|row| {
            let numbers = [text::number(row.r_squared, 3), text::number(row.largest_deviation, 3)];
            [row.window.clone(), method(row), row.derivative.clone()].into_iter().chain(numbers).collect()
        });
        text::table(&["manoeuvre", "method", "", "R2", "largest deviation"], &cells.collect::<Vec<_>>());
    }
    for finding in &results.check_findings {
        text::line(&format!("{}: {}: {}", finding.level.name(), finding.place, finding.text));
    }
}

/// Method of a check, with the axis that output error followed.
fn method(row: &report::CheckRow) -> String {
    if row.axis.is_empty() { row.method.to_owned() } else { format!("{}, {}", row.method, row.axis) }
}
