//! Section on the independent checks: every window again in the frequency domain and by output error.

use super::{Block, Contents, Parts, paragraph};
use crate::report::studies::CheckRow;
use crate::report::table::{Table, TableOf};
use crate::study::{ESTIMATORS, Estimator};

/// Derivatives by every method, how well the flights of output error follow, and what was found about them.
pub fn checks(contents: &Contents<'_>) -> Parts {
    let studies = &contents.results.studies;
    if studies.checks.is_empty() {
        return Parts::default();
    }
    let (outputs, estimates): (Vec<_>, Vec<_>) =
        studies.checks.iter().partition(|row| row.largest_deviation.is_finite());
    let is_used = |estimator: &&Estimator| studies.checks.iter().any(|row| row.method == estimator.name);
    let methods: Vec<&str> = ESTIMATORS.iter().filter(is_used).map(|estimator| estimator.about).collect();
    let mut blocks = vec![paragraph(&format!("Each manoeuvre by other estimators. {}", methods.join(" ")))];
    let lines =
        studies.check_findings.iter().map(|found| format!("{}: {}: {}", found.level.name(), found.place, found.text));
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() {
        blocks.push(paragraph("No finding: the output-error simulations follow their recordings."));
    } else {
        blocks.push(Block::List(lines));
    }
    let mut appendix = vec![Block::Table(derivatives(&estimates))];
    if !outputs.is_empty() {
        appendix.push(Block::Table(followed(&outputs)));
    }
    Parts { body: blocks, appendix }
}

fn derivatives(rows: &[&CheckRow]) -> Table {
    let finite = |value: f64| value.is_finite().then_some(value);
    // Initial states and biases belong to one window and have no twin.
    let of_model = rows.iter().filter(|row| !row.derivative.ends_with(']') && row.error.is_none());
    let caption = "Derivatives of each manoeuvre by other methods, beside time-domain equation error.";
    TableOf::new("checks", caption, of_model)
        .text("window", "Manoeuvre", |row| &row.window)
        .text("method", "Method", |row| row.method)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .maybe("estimate", "Estimate", "", 4, |row| finite(row.estimate))
        .maybe("standard_error", "Std error", "", 2, |row| finite(row.standard_error))
        .maybe("equation_error", "Equation error", "", 4, |row| finite(row.equation_error))
        .maybe("equation_standard_error", "Std error", "", 2, |row| finite(row.equation_standard_error))
        .done()
}

fn followed(rows: &[&CheckRow]) -> Table {
    let caption = "Fit of output error to the recorded outputs; differences in SI units.";
    TableOf::new("followed", caption, rows)
        .text("window", "Manoeuvre", |row| &row.window)
        .text("axis", "Motion", |row| row.axis)
        .text("output", "Output", |row| &row.derivative)
        .number("r_squared", "R²", "", 3, |row| row.r_squared)
        .number("largest_deviation", "Largest deviation", "", 3, |row| row.largest_deviation)
        .done()
}
