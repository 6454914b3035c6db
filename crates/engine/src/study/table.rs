//! Regression of one column of a table by terms of others, without flight, aircraft or filter.

use std::path::Path;

use doublet_core::estimate::diagnostics::{predicted_squared_error, press};
use doublet_core::estimate::{
    Coloured, EstimateError, Fit, OrthogonalSettings, StepwiseSettings, coloured_covariance, least_squares, orthogonal,
    stepwise, weighted_coloured_covariance, weighted_least_squares,
};
use doublet_core::load::{ChannelInfo, LoadError, Probe, Source, inspect, stem_and_unit};
use doublet_core::model::{Coefficient, Term};
use doublet_core::prep::{Expression, ExpressionError, Interpolation, Operand, PrepError, did_you_mean, resample};
use nalgebra::DMatrix;
use thiserror::Error;

/// How terms are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TermChoice {
    /// All that were named.
    #[default]
    All,
    /// One at a time by partial correlation and partial F.
    Stepwise,
    /// By orthogonal functions up to the least predicted squared error.
    Orthogonal,
}

/// What is fitted by what. Columns are taken as they stand in the file; no unit is converted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableRegression {
    /// Column that is fitted, or an expression of columns.
    pub output: String,
    /// Terms: `1` is the constant; others are columns, or expressions of them such as `alpha^2` or `q*2.1/(2*V)`.
    pub terms: Vec<String>,
    /// Column of standard deviations of the samples; all are the same without it.
    pub deviations: Option<String>,
    /// How terms are chosen. The constant always stays.
    pub choice: TermChoice,
}

#[derive(Clone, Debug)]
pub struct TableFit {
    /// The fit; parameters are named as derivatives, `Cm_alpha`, and the constant `Cm_0`.
    pub fit: Fit,
    /// Terms of the parameters as they were named.
    pub terms: Vec<String>,
    /// Standard errors corrected for the correlation of the residuals from row to row.
    pub corrected_standard_errors: Vec<f64>,
    /// Terms that were not chosen.
    pub dropped: Vec<String>,
    /// Rows used, from 0; rows without a value in any column used are left out.
    pub rows: Vec<usize>,
    pub rows_in_table: usize,
    /// Measured values of the rows used.
    pub measured: Vec<f64>,
    /// Predicted residual sum of squares.
    pub press: f64,
    pub predicted_squared_error: f64,
}

/// Why a table could not be fitted.
#[derive(Debug, Error)]
pub enum TableError {
    /// The file is not understood.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// No column is called so.
    #[error("no column is called '{name}': {hint}")]
    NoColumn { name: String, hint: String },
    #[error("several columns are called '{name}': {candidates}; write one of them in full")]
    Ambiguous { name: String, candidates: String },
    /// A term is no column and no expression of columns.
    #[error("term '{term}': {error}")]
    Term { term: String, error: ExpressionError },
    #[error("'{name}' has {found} rows, '{output}' {expected}: they are not of one table")]
    Length { name: String, found: usize, output: String, expected: usize },
    #[error("'{name}' on the clock of the others: {error}")]
    Clock { name: String, error: PrepError },
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] EstimateError),
}

/// Fits a column of the table `path` by terms of others, by least squares with the errors of
/// [`doublet_core::estimate::coloured_covariance`]. Any recording is a table: its channels are the columns.
pub fn regress_table(path: &Path, regression: &TableRegression) -> Result<TableFit, TableError> {
    let probe = inspect(path)?;
    let columns = Columns::from_probe(&probe);
    let output = columns.evaluate(&regression.output)?;
    let all: Vec<Vec<f64>> = regression
        .terms
        .iter()
        .map(|term| if term == "1" { Ok(vec![1.0; output.len()]) } else { columns.evaluate(term) })
        .collect::<Result<_, _>>()?;
    let deviations = regression.deviations.as_ref().map(|name| columns.evaluate(name)).transpose()?;
    let named = regression.terms.iter().zip(&all).chain(regression.deviations.iter().zip(&deviations));
    for (name, values) in named {
        if values.len() != output.len() {
            let (name, output_name) = (name.clone(), regression.output.clone());
            let (found, expected) = (values.len(), output.len());
            return Err(TableError::Length { name, found, output: output_name, expected });
        }
    }
    let used = || all.iter().chain(&deviations).chain([&output]);
    let rows: Vec<usize> = (0..output.len()).filter(|&row| used().all(|values| values[row].is_finite())).collect();
    let picked = |values: &Vec<f64>| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
    let x = DMatrix::from_fn(rows.len(), all.len(), |row, term| all[term][rows[row]]);
    let (measured, deviations) = (picked(&output), deviations.as_ref().map(picked));
    let names: Vec<String> = regression.terms.iter().map(|term| parameter(&regression.output, term)).collect();
    let selected = choose(regression, &names, &x, &measured)?;
    let x = x.select_columns(&selected);
    let names: Vec<String> = selected.iter().map(|&index| names[index].clone()).collect();
    let (fit, covariance) = fit(&names, &x, &measured, deviations)?;
    let (press, predicted_squared_error) = (press(&fit, &x), predicted_squared_error(&fit, None));
    let is_left = |index: &usize| !selected.contains(index);
    Ok(TableFit {
        corrected_standard_errors: covariance.diagonal().iter().map(|variance| variance.sqrt()).collect(),
        fit,
        terms: selected.iter().map(|&index| regression.terms[index].clone()).collect(),
        dropped: (0..all.len()).filter(is_left).map(|index| regression.terms[index].clone()).collect(),
        rows_in_table: output.len(),
        rows,
        measured,
        press,
        predicted_squared_error,
    })
}

/// Name of a parameter: as the model would call the derivative, or of output and term.
fn parameter(output: &str, term: &str) -> String {
    let known = Coefficient::from_name(output).zip(Term::parse(term).ok());
    match known {
        Some((coefficient, term)) => term.derivative_name(coefficient),
        None if term == "1" => format!("{output}_0"),
        None => format!("{output}_{term}"),
    }
}

/// Indices of the terms that stay.
fn choose(
    regression: &TableRegression,
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
) -> Result<Vec<usize>, EstimateError> {
    let forced: Vec<usize> = (0..names.len()).filter(|&index| regression.terms[index] == "1").collect();
    Ok(match regression.choice {
        TermChoice::All => (0..names.len()).collect(),
        TermChoice::Stepwise => stepwise(names, x, z, &forced, &StepwiseSettings::default())?.selected,
        TermChoice::Orthogonal => orthogonal(names, x, z, &forced, &OrthogonalSettings::default())?.selected,
    })
}

/// The fit, and its covariance for residuals that are correlated from row to row.
fn fit(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    deviations: Option<Vec<f64>>,
) -> Result<(Fit, DMatrix<f64>), EstimateError> {
    let settings = Coloured::default();
    let Some(deviations) = deviations else {
        let fit = least_squares(names, x, z)?;
        let covariance = coloured_covariance(&fit, x, &settings)?;
        return Ok((fit, covariance));
    };
    let weights: Vec<f64> = deviations.iter().map(|deviation| deviation.powi(-2)).collect();
    let fit = weighted_least_squares(names, x, z, &weights)?;
    let whole = 0..z.len();
    let covariance = weighted_coloured_covariance(&fit, x, &weights, std::slice::from_ref(&whole), &settings)?;
    Ok((fit, covariance))
}

/// The columns of a table by their names.
pub(super) struct Columns<'p> {
    columns: Vec<(String, &'p ChannelInfo)>,
    sources: &'p [Source],
}

/// Columns on one clock: its stamps, s, and the values of each term there.
pub(super) type OnOneClock = (Vec<f64>, Vec<Vec<f64>>);

impl<'p> Columns<'p> {
    pub(super) fn from_probe(probe: &'p Probe) -> Self {
        let several = probe.sources.len() > 1;
        let named =
            |source: &str, channel: &str| if several { format!("{source}/{channel}") } else { channel.to_owned() };
        let named_channels = |source: &'p doublet_core::load::Source| {
            source.channels.iter().map(move |channel| (named(&source.name, &channel.name), channel))
        };
        Self { columns: probe.sources.iter().flat_map(named_channels).collect(), sources: &probe.sources }
    }

    /// The column called `name`, in full, without its source, or without the unit at the end of its name.
    fn find(&self, name: &str) -> Result<&'p ChannelInfo, TableError> {
        let full = |(other, _): &&(String, &ChannelInfo)| other == name;
        let plain = |(_, channel): &&(String, &ChannelInfo)| channel.name == name;
        let stem = |(_, channel): &&(String, &ChannelInfo)| stem_and_unit(&channel.name).0 == name;
        let found = [
            self.columns.iter().filter(full).collect::<Vec<_>>(),
            self.columns.iter().filter(plain).collect(),
            self.columns.iter().filter(stem).collect(),
        ];
        match found.iter().find(|found| !found.is_empty()).map(Vec::as_slice) {
            Some([(_, channel)]) => Ok(channel),
            Some(several) => {
                let names: Vec<&str> = several.iter().map(|(name, _)| name.as_str()).collect();
                Err(TableError::Ambiguous { name: name.to_owned(), candidates: names.join(", ") })
            }
            None => {
                let known = self.columns.iter().map(|(name, _)| name.as_str());
                let all: Vec<&str> = known.clone().take(LISTED).collect();
                let hint = did_you_mean(name, known, &format!("there are {}", all.join(", ")));
                Err(TableError::NoColumn { name: name.to_owned(), hint })
            }
        }
    }

    /// Values of a term: a column by its name, whatever signs that has, or else an expression of columns.
    pub(super) fn evaluate(&self, term: &str) -> Result<Vec<f64>, TableError> {
        let (expression, operands) = self.parse(term)?;
        let rows = operands[0].samples;
        if let Some(other) = operands.iter().find(|other| other.samples != rows) {
            let (name, output) = (other.name.clone(), operands[0].name.clone());
            return Err(TableError::Length { name, found: other.samples, output, expected: rows });
        }
        let columns: Vec<&[f64]> = operands.iter().map(|operand| operand.values()).collect();
        Ok(values(expression.as_ref(), &columns))
    }

    /// An expression and the columns it names; a column alone is no expression.
    fn parse(&self, term: &str) -> Result<(Option<Expression>, Vec<&'p ChannelInfo>), TableError> {
        match self.find(term) {
            Ok(channel) => return Ok((None, vec![channel])),
            Err(error) if !term.contains(OPERATORS) => return Err(error),
            Err(_) => {}
        }
        let error = |error| TableError::Term { term: term.to_owned(), error };
        let expression = Expression::parse(&self.with_quotes(term)).map_err(error)?;
        let operands = expression.operands().iter().map(|(operand, _)| match operand {
            Operand::Role(role) => self.find(role.name()),
            Operand::Channel(name) => self.find(name),
        });
        let operands = operands.collect::<Result<_, _>>()?;
        Ok((Some(expression), operands))
    }

    /// Values of terms whose columns have clocks of their own or blanks: on the stamps of the column with most values, on straight lines
    /// between the values of the others, where all have values on both sides. None where a column has no clock.
    pub(super) fn on_one_clock(&self, terms: &[&str]) -> Result<Option<OnOneClock>, TableError> {
        let parsed = terms.iter().map(|term| self.parse(term)).collect::<Result<Vec<_>, _>>()?;
        let series = |channel: &&'p ChannelInfo| Some((channel.name.as_str(), self.series(channel)?));
        let of_term =
            |(_, operands): &(_, Vec<&'p ChannelInfo>)| operands.iter().map(series).collect::<Option<Vec<_>>>();
        let Some(series) = parsed.iter().map(of_term).collect::<Option<Vec<_>>>() else { return Ok(None) };
        let all = || series.iter().flatten().map(|(_, own)| own);
        let start_s = all().filter_map(|(time_s, _)| time_s.first()).fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let end_s = all().filter_map(|(time_s, _)| time_s.last()).fold(f64::INFINITY, |a, b| a.min(*b));
        let Some((longest, _)) = all().max_by_key(|(time_s, _)| time_s.len()) else { return Ok(None) };
        let stamps: Vec<f64> = longest.iter().copied().filter(|time_s| (start_s..=end_s).contains(time_s)).collect();
        let at_stamps = |(name, (time_s, own)): &(&str, (Vec<f64>, Vec<f64>))| {
            let error = |error| TableError::Clock { name: (*name).to_owned(), error };
            resample(time_s, own, &stamps, Interpolation::Linear).map_err(error)
        };
        let mut found = Vec::new();
        for ((expression, _), series) in parsed.iter().zip(&series) {
            let columns = series.iter().map(at_stamps).collect::<Result<Vec<_>, _>>()?;
            found.push(values(expression.as_ref(), &columns.iter().map(Vec::as_slice).collect::<Vec<_>>()));
        }
        Ok(Some((stamps, found)))
    }

    /// Stamps, s, and values of a column where it has values; none without a clock.
    fn series(&self, channel: &ChannelInfo) -> Option<(Vec<f64>, Vec<f64>)> {
        let is_it = |other: &ChannelInfo| std::ptr::eq(other, channel);
        let source = self.sources.iter().find(|source| source.channels.iter().any(is_it))?;
        let clock = source.clocks.get(channel.clock?)?;
        let stamps = source.channels.iter().find(|other| other.is_time && other.name == clock.channel);
        let time_s = |row: usize| match stamps {
            Some(stamps) => clock.unit.to_si(stamps.values()[row]),
            None => clock.start_s + row as f64 / clock.rate_hz,
        };
        let rows = channel.samples.min(stamps.map_or(clock.samples, |stamps| stamps.samples));
        let all = channel.values()[..rows].iter().enumerate();
        Some(all.filter(|(_, value)| value.is_finite()).map(|(row, value)| (time_s(row), *value)).unzip())
    }

    /// The text of an expression with quotes about the columns it names.
    fn with_quotes(&self, text: &str) -> String {
        let mut quoted = String::new();
        let mut rest = text;
        while let Some(letter) = rest.chars().next() {
            let end = rest.find(|letter: char| !(letter.is_alphanumeric() || "_.[]".contains(letter)));
            let (word, after) = rest.split_at(end.unwrap_or(rest.len()));
            if let Some(quote) = [('"', '"'), ('{', '}')].iter().find(|(open, _)| *open == letter) {
                // What is quoted already stays as it is.
                let end = rest[1..].find(quote.1).map_or(rest.len(), |end| end + 2);
                quoted.push_str(&rest[..end]);
                rest = &rest[end..];
            } else if word.is_empty() {
                quoted.push(letter);
                rest = &rest[letter.len_utf8()..];
            } else {
                let is_column = letter.is_alphabetic() && self.find(word).is_ok();
                quoted.push_str(&if is_column { format!("\"{word}\"") } else { word.to_owned() });
                rest = after;
            }
        }
        quoted
    }
}

/// Values of an expression, or of the column that stands alone, row by row.
fn values(expression: Option<&Expression>, columns: &[&[f64]]) -> Vec<f64> {
    let Some(expression) = expression else { return columns[0].to_vec() };
    let mut stack = Vec::new();
    (0..columns[0].len()).map(|row| expression.value(|index| columns[index][row], &mut stack)).collect()
}

/// Signs of an expression.
const OPERATORS: [char; 7] = ['+', '-', '*', '/', '^', '(', '"'];
/// Columns listed where none is called so.
const LISTED: usize = 20;
