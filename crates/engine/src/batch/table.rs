//! The table of a batch: a row per run and derivative, or per run that failed.

use std::path::Path;

use super::parquet::parquet;
use super::store::{Estimate, Finished};
use super::{BatchJob, Store};
use crate::keep::{check_apart, replace};
use crate::session::check_output;

/// A column; what does not exist is `None`.
pub(super) enum Column {
    Text(Vec<Option<String>>),
    Number(Vec<Option<f64>>),
    Count(Vec<Option<i64>>),
}

/// Checks that the table of `jobs`, read from `sessions`, can be written to `out`.
///
/// # Errors
/// One line for another ending than .parquet and .csv, and for a file that a job reads.
pub fn check_table(jobs: &[BatchJob], sessions: &Path, out: &Path) -> Result<(), String> {
    if !matches!(ending(out), Some("csv" | "parquet")) {
        return Err(format!("{}: give the table the ending .parquet or .csv", out.display()));
    }
    check_apart(out, [sessions.to_path_buf()])?;
    let read = jobs.iter().filter_map(|job| Some((job.session.as_ref().ok()?, &job.folder)));
    read.into_iter().try_for_each(|(session, folder)| check_output(session, folder, out))
}

fn ending(out: &Path) -> Option<&str> {
    out.extension()?.to_str()
}

/// Writes the table of `jobs` in one step, as Parquet or CSV after the ending of `out`.
pub fn write(jobs: &[BatchJob], store: &Store, out: &Path) -> Result<usize, String> {
    let unfinished = |job: &BatchJob| format!("{} is not finished: run the batch again without --task", job.name);
    let rows: Vec<(&BatchJob, Finished)> = jobs
        .iter()
        .map(|job| Ok((job, store.get(job).ok_or_else(|| unfinished(job))?)))
        .collect::<Result<_, String>>()?;
    let columns = columns(&rows);
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", out.display());
    let bytes = match ending(out) {
        Some("csv") => csv(&columns).map_err(|error| failed(&error))?,
        Some("parquet") => parquet(&columns).map_err(|error| failed(&error))?,
        _ => return Err(failed(&"give the table the ending .parquet or .csv")),
    };
    replace(out, &bytes).map_err(|error| failed(&error))?;
    Ok(columns.first().map_or(0, |(_, column)| column.len()))
}

/// Columns by name: where a row comes from, the settings swept, what was found.
fn columns(runs: &[(&BatchJob, Finished)]) -> Vec<(String, Column)> {
    let mut rows: Vec<(&BatchJob, Option<&Estimate>, Option<&str>)> = Vec::new();
    for (job, finished) in runs {
        rows.extend(finished.estimates.iter().map(|estimate| (*job, Some(estimate), None)));
        if let Some(error) = &finished.error {
            rows.push((job, None, Some(error)));
        }
    }
    let mut settings: Vec<&str> = Vec::new();
    for (name, _) in runs.iter().flat_map(|(job, _)| &job.settings) {
        if !settings.contains(&name.as_str()) {
            settings.push(name);
        }
    }
    let text = |get: &dyn Fn(&Estimate) -> &String| {
        Column::Text(rows.iter().map(|(_, row, _)| row.map(|row| get(row).clone())).collect())
    };
    let number = |get: &dyn Fn(&Estimate) -> Option<f64>| {
        Column::Number(rows.iter().map(|(_, row, _)| row.and_then(get)).collect())
    };
    let mut columns =
        vec![("session".to_owned(), Column::Text(rows.iter().map(|row| Some(row.0.name.clone())).collect()))];
    for setting in settings {
        let value =
            |job: &BatchJob| job.settings.iter().find(|(name, _)| name == setting).map(|(_, value)| value.clone());
        columns.push((setting.to_owned(), setting_column(rows.iter().map(|(job, ..)| value(job)).collect())));
    }
    let counts = rows.iter().map(|(_, row, _)| row.and_then(|row| i64::try_from(row.samples).ok())).collect();
    columns.extend([
        ("coefficient".to_owned(), text(&|row| &row.coefficient)),
        ("derivative".to_owned(), text(&|row| &row.derivative)),
        ("estimate".to_owned(), number(&|row| row.estimate)),
        ("standard_error".to_owned(), number(&|row| row.standard_error)),
        ("corrected_standard_error".to_owned(), number(&|row| row.corrected_standard_error)),
        ("r_squared".to_owned(), number(&|row| row.r_squared)),
        ("samples".to_owned(), Column::Count(counts)),
        ("error".to_owned(), Column::Text(rows.iter().map(|row| row.2.map(str::to_owned)).collect())),
    ]);
    columns
}

/// Numbers where every value is one.
fn setting_column(values: Vec<Option<String>>) -> Column {
    let number = |value: &Option<String>| value.as_ref().map(|text| text.parse::<f64>().ok());
    let numbers: Vec<Option<Option<f64>>> = values.iter().map(number).collect();
    if numbers.iter().all(|number| *number != Some(None)) {
        Column::Number(numbers.into_iter().map(Option::flatten).collect())
    } else {
        Column::Text(values)
    }
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Text(values) => values.len(),
            Self::Number(values) => values.len(),
            Self::Count(values) => values.len(),
        }
    }

    /// The shortest text that reads back to the same value; empty for what does not exist.
    fn cell(&self, row: usize) -> String {
        match self {
            Self::Text(values) => values[row].clone().unwrap_or_default(),
            Self::Number(values) => values[row].map_or(String::new(), |value| value.to_string()),
            Self::Count(values) => values[row].map_or(String::new(), |value| value.to_string()),
        }
    }
}

fn csv(columns: &[(String, Column)]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|(name, _)| name))?;
    for row in 0..columns.first().map_or(0, |(_, column)| column.len()) {
        writer.write_record(columns.iter().map(|(_, column)| column.cell(row)))?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}
