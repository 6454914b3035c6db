//! Errors of the aerodynamic model.

use thiserror::Error;

use crate::prep::PrepError;

/// What can be wrong with a term, a structure or the data of a window.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ModelError {
    /// A term names a variable that does not exist.
    #[error("term '{term}': unknown variable at '{rest}'; known are {}", known.join(", "))]
    UnknownVariable {
        /// Term as given.
        term: String,
        /// The part that could not be read.
        rest: String,
        /// Names that would have been understood.
        known: Vec<&'static str>,
    },
    /// A power is not an integer.
    #[error("term '{term}': '{power}' is not an integer power")]
    BadPower {
        /// Term as given.
        term: String,
        /// Power as given.
        power: String,
    },
    /// A coefficient has the same term twice.
    #[error("{coefficient} has the term '{term}' twice: remove one")]
    RepeatedTerm {
        /// Name of the coefficient.
        coefficient: &'static str,
        /// The term.
        term: String,
    },
    /// A column has another length than the time vector.
    #[error("column {column} has {found} samples, time has {expected}")]
    ColumnLength {
        /// Name of the column.
        column: String,
        /// Samples of the time vector.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// A value that must be positive and finite is not.
    #[error("{quantity} is {value} at {time_s:.3} s: it must be positive and finite")]
    NotPositive {
        /// Name of the quantity.
        quantity: &'static str,
        /// Time of the sample, s.
        time_s: f64,
        /// Value found, SI.
        value: f64,
    },
    /// A sample is not a number.
    #[error("{column} is not finite at {time_s:.3} s: choose another manoeuvre or fill the gap")]
    NotFinite {
        /// Name of the column.
        column: String,
        /// Time of the sample, s.
        time_s: f64,
    },
    /// A term needs a variable the data do not offer.
    #[error("term '{term}' needs {variable}, which this manoeuvre does not have")]
    MissingVariable {
        /// The term.
        term: String,
        /// Name of the variable.
        variable: &'static str,
    },
    /// Thrust or propeller rotation is to be accounted for, but no engine is given.
    #[error("{setting} needs at least one engine, the data have none")]
    NoEngine {
        /// Setting that asks for it.
        setting: &'static str,
    },
    /// A signal could not be differentiated or filtered.
    #[error("{column}: {source}")]
    Signal {
        /// Name of the column.
        column: String,
        /// What went wrong.
        source: PrepError,
    },
}
