//! Errors of the aerodynamic model.

use thiserror::Error;

use crate::prep::PrepError;

/// What can be wrong with a term, a structure or the data of a window.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ModelError {
    #[error("term '{term}': unknown variable at '{rest}'; known are {}", known.join(", "))]
    UnknownVariable { term: String, rest: String, known: Vec<&'static str> },
    #[error("term '{term}': '{power}' is not an integer power")]
    BadPower { term: String, power: String },
    #[error("{coefficient} has the term '{term}' twice: remove one")]
    RepeatedTerm { coefficient: &'static str, term: String },
    #[error("column {column} has {found} samples, time has {expected}")]
    ColumnLength { column: String, expected: usize, found: usize },
    #[error("{quantity} is {value} at {time_s:.3} s: it must be positive and finite")]
    NotPositive { quantity: &'static str, time_s: f64, value: f64 },
    #[error("{column} is not finite at {time_s:.3} s: choose another manoeuvre or fill the gap")]
    NotFinite { column: String, time_s: f64 },
    #[error("term '{term}' needs {variable}, which this manoeuvre does not have")]
    MissingVariable { term: String, variable: &'static str },
    #[error("{setting} needs at least one engine, the data have none")]
    NoEngine { setting: &'static str },
    /// A signal could not be differentiated or filtered.
    #[error("{column}: {source}")]
    Signal { column: String, source: PrepError },
}
