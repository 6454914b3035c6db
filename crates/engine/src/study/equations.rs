//! Equations of motion fitted to the columns of a table: states, inputs and outputs as chosen, no aircraft, no other channel.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::estimate::{
    EquationFault, EquationFit, EquationModel, EquationRecord, EquationSettings, EquationText, FilterErrorFit,
    equation_error_of, filter_error_of, output_error_of,
};
use doublet_core::load::inspect;
use doublet_core::schema::{Refused, schema_of};
use doublet_core::series::{TimeRange, gap_threshold_s};
use doublet_core::toml_error;
use serde::Deserialize;
use thiserror::Error;

use super::systems::{is_driven_by_noise, judge_equations};
use super::table::{Columns, OnOneClock, TableError};
use crate::builtin;
use crate::session::Verdict;

/// Value of the `format` key of a file of equations.
const FORMAT: &str = "doublet equations";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    #[serde(default)]
    inputs: Vec<String>,
    #[serde(default, rename = "state")]
    states: Vec<StateTable>,
    #[serde(default, rename = "output")]
    outputs: Vec<OutputTable>,
    #[serde(default)]
    parameters: BTreeMap<String, f64>,
    #[serde(default)]
    constants: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StateTable {
    name: String,
    rate: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputTable {
    name: String,
    shows: String,
}

/// What is fitted to what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EquationRequest {
    /// Equations of motion.
    pub equations: EquationText,
    /// Column, or expression of columns, of an input or output; the column of its own name without an entry.
    pub columns: BTreeMap<String, String>,
    /// Column of time, s, or an expression of columns.
    pub time: Option<String>,
    /// Interval of the rows, s, where there is no column of time.
    pub step_s: Option<f64>,
    /// Parts of time to use; all rows without one.
    pub windows: Vec<TimeRange>,
    /// Half width of the differentiation, s; without it that of [`EquationSettings`].
    pub half_width_s: Option<f64>,
    /// Length of pieces with initial states of their own, s.
    pub piece_s: Option<f64>,
}

/// Parameters by three methods.
#[derive(Debug)]
pub struct EquationStudy {
    /// By equation error, or one line why not.
    pub equation_error: Result<EquationFit, EquationFault>,
    /// By output error, which starts there where it can.
    pub output_error: Result<EquationFit, EquationFault>,
    /// By filter error, which starts there too: with noise that drives the states, such as gusts.
    pub filter_error: Result<FilterErrorFit, EquationFault>,
    /// The records that were fitted.
    pub records: Vec<EquationRecord>,
    /// Whether the parameters may be believed: the methods, what they explain, and whether they agree.
    pub verdict: Verdict,
}

impl EquationStudy {
    /// Whether noise drives the states, so that the parameters of filter error are the ones to take.
    pub fn is_driven_by_noise(&self) -> bool {
        is_driven_by_noise(&self.output_error, &self.filter_error)
    }
}

/// Why equations could not be fitted to a table.
#[derive(Debug, Error)]
pub enum EquationError {
    #[error("{reason}")]
    File { reason: String },
    #[error(transparent)]
    Table(#[from] TableError),
    /// Equations or records.
    #[error(transparent)]
    Equations(#[from] EquationFault),
    #[error("the table has no time: name its column by --time, or the interval of its rows by --dt")]
    NoTime,
    #[error("time does not increase at {time_s} s (row {row}): choose rows by --window, or another column by --time")]
    Time { time_s: f64, row: usize },
    #[error("between {start_s} s and {end_s} s the table has {rows} rows: choose another manoeuvre")]
    Window { start_s: f64, end_s: f64, rows: usize },
}

/// Equations that come with the program, by name: their text.
pub fn shipped_equations(name: &str) -> Option<&'static str> {
    builtin::text("equations", &name.replace('-', "_"))
}

/// Names of the equations that come with the program.
pub fn names_of_equations() -> Vec<&'static str> {
    builtin::names("equations")
}

/// JSON Schema of files of equations.
pub fn equation_schema() -> Result<serde_json::Value, Refused> {
    schema_of::<File>(FORMAT)
}

/// Understands the text of a file of equations; `constants` stand in the place of its own.
pub fn equation_text(text: &str, constants: &BTreeMap<String, f64>) -> Result<EquationText, EquationError> {
    let fault = |reason: String| EquationError::File { reason };
    let read: File = toml::from_str(text).map_err(|error| fault(toml_error::one_line(text, &error)))?;
    if read.format != FORMAT {
        return Err(fault(format!("its format is '{}', expected '{FORMAT}'", read.format)));
    }
    let mut known = read.constants;
    for (name, value) in constants {
        if known.insert(name.clone(), *value).is_none() {
            return Err(fault(format!("it has no constant '{name}'")));
        }
    }
    Ok(EquationText {
        states: read.states.into_iter().map(|state| (state.name, state.rate)).collect(),
        outputs: read.outputs.into_iter().map(|output| (output.name, output.shows)).collect(),
        inputs: read.inputs,
        parameters: read.parameters.into_iter().collect(),
        constants: known.into_iter().collect(),
    })
}

/// Fits equations of motion to the columns of a table, by equation error, output error
/// ([`doublet_core::estimate::output_error_of`]) and filter error ([`doublet_core::estimate::filter_error_of`]). Any recording is a table; only the columns the equations name are looked at, and where they
/// have clocks of their own, those with fewer values are taken on straight lines at the stamps of the one with most.
pub fn fit_equations(path: &Path, request: &EquationRequest) -> Result<EquationStudy, EquationError> {
    fit_equation_model(path, &EquationModel::new(&request.equations)?, request)
}

/// As [`fit_equations`] with equations that are understood; those of the request do not count.
pub fn fit_equation_model(
    path: &Path,
    model: &EquationModel,
    request: &EquationRequest,
) -> Result<EquationStudy, EquationError> {
    let probe = inspect(path).map_err(TableError::from)?;
    let columns = Columns::from_probe(&probe);
    let named = model.inputs().iter().chain(model.outputs());
    let terms: Vec<&str> = named.map(|name| request.columns.get(name).unwrap_or(name).as_str()).collect();
    let (time_s, mut inputs) = match (&request.time, request.step_s) {
        (Some(time), _) => rows_of(&columns, &terms, columns.evaluate(time)?)?,
        (None, Some(step_s)) => {
            let rows = columns.evaluate(terms[terms.len() - 1])?.len();
            rows_of(&columns, &terms, (0..rows).map(|row| step_s * row as f64).collect())?
        }
        (None, None) => by_time(&columns, &terms)?,
    };
    let outputs = inputs.split_off(model.inputs().len());
    let records = records(&time_s, (&inputs, &outputs), &request.windows)?;
    let usual = EquationSettings::default();
    let half_width_s = request.half_width_s.unwrap_or(usual.half_width_s);
    let settings = EquationSettings { half_width_s, piece_s: request.piece_s, ..usual };
    let equation_error = equation_error_of(model, &records, &settings);
    let start = equation_error.as_ref().ok().map(|found| found.fit.estimates.as_slice());
    let output_error = output_error_of(model, &records, &settings, start);
    let filter_error = filter_error_of(model, &records, &settings, start);
    match (equation_error, output_error, filter_error) {
        (Err(error), Err(_), Err(_)) => Err(error.into()),
        (equation_error, output_error, filter_error) => {
            let verdict = judge_equations(&equation_error, &output_error, &filter_error);
            Ok(EquationStudy { equation_error, output_error, filter_error, records, verdict })
        }
    }
}

/// The terms beside a time of as many rows.
fn rows_of(columns: &Columns<'_>, terms: &[&str], time_s: Vec<f64>) -> Result<OnOneClock, TableError> {
    let values = terms.iter().map(|term| columns.evaluate(term)).collect::<Result<Vec<_>, _>>()?;
    if let Some((name, values)) = terms.iter().zip(&values).find(|(_, values)| values.len() != time_s.len()) {
        let (name, output) = ((*name).to_owned(), "time".to_owned());
        return Err(TableError::Length { name, output, found: values.len(), expected: time_s.len() });
    }
    Ok((time_s, values))
}

/// The terms as rows beside a column of time, or, where there is none of their length or values are missing, on one of their own clocks.
fn by_time(columns: &Columns<'_>, terms: &[&str]) -> Result<OnOneClock, EquationError> {
    let time_s = TIME_NAMES.iter().find_map(|name| columns.evaluate(name).ok());
    let found = time_s.map(|time_s| rows_of(columns, terms, time_s));
    match found {
        Some(Ok(found)) if found.1.iter().flatten().all(|value| value.is_finite()) => Ok(found),
        // A name that is no column is said first.
        found => match (columns.on_one_clock(terms)?, found) {
            (Some(found), _) => Ok(found),
            (None, Some(found)) => Ok(found?),
            (None, None) => Err(EquationError::NoTime),
        },
    }
}

/// Names of a column of time, s.
const TIME_NAMES: [&str; 6] = ["time_s", "t_s", "time", "t", "Time", "T"];

/// The rows of each window, cut where time pauses.
fn records(
    time_s: &[f64],
    (inputs, outputs): (&[Vec<f64>], &[Vec<f64>]),
    windows: &[TimeRange],
) -> Result<Vec<EquationRecord>, EquationError> {
    let whole = TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY };
    let windows = if windows.is_empty() { std::slice::from_ref(&whole) } else { windows };
    let mut records = Vec::new();
    for window in windows {
        let inside = |&row: &usize| time_s[row] >= window.start_s && time_s[row] <= window.end_s;
        let rows: Vec<usize> = (0..time_s.len()).filter(inside).collect();
        let own: Vec<f64> = rows.iter().map(|&row| time_s[row]).collect();
        if let Some(at) = own.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(EquationError::Time { time_s: own[at], row: rows[at] });
        }
        let longest = gap_threshold_s(&own);
        let found = doublet_core::prep::stretches(&own, longest);
        if found.is_empty() {
            let TimeRange { start_s, end_s } = *window;
            return Err(EquationError::Window { start_s, end_s, rows: own.len() });
        }
        for range in found {
            let picked =
                |column: &Vec<f64>| -> Vec<f64> { rows[range.clone()].iter().map(|&row| column[row]).collect() };
            records.push(EquationRecord {
                label: format!("{}", records.len() + 1),
                time_s: own[range.clone()].to_vec(),
                inputs: inputs.iter().map(picked).collect(),
                outputs: outputs.iter().map(picked).collect(),
            });
        }
    }
    Ok(records)
}
