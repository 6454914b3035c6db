//! Section on the experiments of the session: what each configuration gives, beside the session as it is.

use super::{Block, Contents, Parts, paragraph};
use crate::report::table::{Table, TableOf};
use crate::snapshot::{DerivativeOutcome, ExperimentRow, SettingDifference};

/// Verdict and fit of every experiment with the settings that differ; their derivatives in the appendix.
pub fn experiments(contents: &Contents<'_>) -> Parts {
    let rows = &contents.results.studies.experiments;
    if rows.len() < 2 {
        return Parts::default();
    }
    let body = vec![
        paragraph(
            "Each experiment is a whole configuration of filter, noise, model and manoeuvres. The session has the configuration of the first row.",
        ),
        Block::Table(overview(rows)),
        Block::Table(settings(rows)),
    ];
    Parts { body, appendix: vec![Block::Table(derivatives(rows))] }
}

fn overview(rows: &[ExperimentRow]) -> Table {
    let caption = "Experiments: verdict of the session, levels of the pooled derivatives, consistency and prediction.";
    TableOf::new("experiments", caption, rows)
        .text("experiment", "Experiment", |row| &row.name)
        .text("verdict", "Verdict", |row| row.outcome.verdict.level.name())
        .count("good", "Good", |row| row.outcome.verdict.good)
        .count("caution", "Caution", |row| row.outcome.verdict.caution)
        .count("bad", "Bad", |row| row.outcome.verdict.bad)
        .maybe("nis", "NIS", "", 3, |row| row.outcome.nis)
        .maybe("delta_akaike", "ΔAIC", "", 4, |row| row.delta_akaike)
        .maybe("validation_error", "Validation error", "", 3, |row| row.outcome.validation_error)
        .done()
}

fn settings(rows: &[ExperimentRow]) -> Table {
    let differing = rows.iter().flat_map(|row| row.differences.iter().map(move |setting| (row, setting)));
    let value = |value: &Option<String>, setting: &SettingDifference| match value {
        Some(value) => format!("{value} {}", setting.unit).trim_end().to_owned(),
        None => "not set".to_owned(),
    };
    let differing: Vec<_> = differing
        .map(|(row, setting)| (row, setting, [&setting.first, &setting.second].map(|one| value(one, setting))))
        .collect();
    let caption = "Settings of the experiments that differ from the session.";
    TableOf::new("experiment_settings", caption, &differing)
        .text("experiment", "Experiment", |(row, ..)| &row.name)
        .text("setting", "Setting", |(_, setting, _)| &setting.setting)
        .text("session", "Session", |(_, _, [session, _])| session)
        .text("value", "Value", |(_, _, [_, own])| own)
        .done()
}

fn derivatives(rows: &[ExperimentRow]) -> Table {
    let mut all: Vec<(&ExperimentRow, &DerivativeOutcome)> = rows.iter().flat_map(with_derivatives).collect();
    let mut names: Vec<&str> = Vec::new();
    for (_, derivative) in &all {
        if !names.contains(&derivative.name.as_str()) {
            names.push(&derivative.name);
        }
    }
    all.sort_by_key(|(_, derivative)| names.iter().position(|name| *name == derivative.name));
    let caption = "Derivatives of each experiment with 95 % intervals from corrected standard errors.";
    TableOf::new("experiment_derivatives", caption, all)
        .symbol("derivative", "Derivative", |(_, derivative)| &derivative.name)
        .text("experiment", "Experiment", |(row, _)| &row.name)
        .number("estimate", "Estimate", "", 4, |(_, derivative)| derivative.interval.estimate)
        .number("low", "Low", "", 4, |(_, derivative)| derivative.interval.low)
        .number("high", "High", "", 4, |(_, derivative)| derivative.interval.high)
        .done()
}

fn with_derivatives(row: &ExperimentRow) -> impl Iterator<Item = (&ExperimentRow, &DerivativeOutcome)> {
    row.outcome.coefficients.iter().flat_map(|one| &one.derivatives).map(move |derivative| (row, derivative))
}
