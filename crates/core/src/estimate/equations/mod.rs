//! Equations of motion as they are written: states, inputs and outputs as chosen, parameters by equation error, output error and filter error.

mod filter_error;
mod fit;
mod model;
mod shooting;
mod together;

use thiserror::Error;

pub use filter_error::{FilterErrorFit, filter_error_of};
pub use fit::{EquationFit, EquationSettings, equation_error_of, output_error_of};
pub use model::{EquationFunction, EquationModel, EquationNames, EquationPoints, EquationText};

use super::EstimateError;
use crate::prep::{ExpressionError, PrepError};

/// One stretch of a recording, on one clock.
#[derive(Clone, Debug, PartialEq)]
pub struct EquationRecord {
    /// Name, which its initial states carry.
    pub label: String,
    /// Time, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// One column per input of the model; linear between samples.
    pub inputs: Vec<Vec<f64>>,
    /// One column per output of the model; not finite where nothing was measured.
    pub outputs: Vec<Vec<f64>>,
}

/// What can be wrong with equations of motion.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum EquationFault {
    /// A right-hand side that is not understood.
    #[error("{place}: {error}")]
    Expression { place: String, error: ExpressionError },
    #[error("'{name}' is both {first} and {second}: give one of them another name")]
    Twice { name: String, first: &'static str, second: &'static str },
    #[error("the equations have no {what}: state at least one")]
    Without { what: &'static str },
    #[error(
        "equation error needs every state measured, and no output is '{state}' alone: add it to the outputs, or give every parameter a start and use output error only"
    )]
    NotMeasured { state: String },
    /// A record that does not fit the model.
    #[error("record '{record}': {found} {what}, {expected} expected")]
    Columns { record: String, what: &'static str, found: usize, expected: usize },
    #[error("record '{record}': input '{input}' is not finite at {time_s:.3} s: end the manoeuvre before it")]
    Input { record: String, input: String, time_s: f64 },
    /// Slopes of the record.
    #[error("record '{record}': {error}")]
    Slopes { record: String, error: PrepError },
    /// The estimation.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
}
