//! Section on the independent checks: every window again in the frequency domain and by output error.

use super::{Block, Contents, Parts, paragraph};
use crate::report::study_tables::{check_table, followed_table};
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
    // Initial states and biases belong to one window and have no twin.
    let of_model = estimates.into_iter().filter(|row| !row.derivative.ends_with(']') && row.error.is_none());
    let columns =
        ["window", "method", "derivative", "estimate", "standard_error", "equation_error", "equation_standard_error"];
    let mut appendix = vec![Block::Table(check_table(of_model).select(&columns))];
    if !outputs.is_empty() {
        appendix.push(Block::Table(followed_table(outputs)));
    }
    Parts { body: blocks, appendix }
}
