//! Errors of the estimation.

use std::fmt;

use thiserror::Error;

/// A regressor that the regressors before it already determine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependence {
    /// Name of the regressor.
    pub name: String,
    /// Names of those it is a sum of; empty when it is zero throughout.
    pub on: Vec<String>,
}

impl fmt::Display for Dependence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.on.is_empty() {
            write!(f, "'{}' is zero throughout", self.name)
        } else {
            write!(f, "'{}' depends on '{}'", self.name, self.on.join("', '"))
        }
    }
}

/// What can be wrong with an estimation.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum EstimateError {
    #[error("{samples} samples are too few for {parameters} parameters: at least {} are needed", parameters + 1)]
    TooFewSamples { samples: usize, parameters: usize },
    #[error("no parameter to estimate: the model has no terms, or all are fixed")]
    NoParameters,
    /// Regressors, measurements or names differ in number.
    #[error("{quantity}: {found} given, {expected} expected")]
    Size { quantity: &'static str, expected: usize, found: usize },
    /// A regressor or the measurement is not a number.
    #[error("'{name}' is not finite at sample {sample}")]
    NotFinite { name: String, sample: usize },
    #[error(
        "the regressors have rank {rank} of {parameters}: {}; remove terms or add manoeuvres that excite them",
        dependent.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    RankDeficient { rank: usize, parameters: usize, dependent: Vec<Dependence> },
    #[error("{method} did not settle in {iterations} iterations")]
    NotConverged { method: &'static str, iterations: usize },
    /// A setting is outside its range.
    #[error("{setting} is {value}, allowed is {allowed}")]
    Setting { setting: String, value: f64, allowed: &'static str },
}
