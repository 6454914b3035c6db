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
pub enum EstimateError {
    /// Fewer samples than parameters and one.
    #[error("{samples} samples are too few for {parameters} parameters: at least {} are needed", parameters + 1)]
    TooFewSamples {
        /// Samples.
        samples: usize,
        /// Parameters.
        parameters: usize,
    },
    /// There is nothing to estimate.
    #[error("no parameter to estimate: the model has no terms, or all are fixed")]
    NoParameters,
    /// Regressors, measurements or names differ in number.
    #[error("{quantity}: {found} given, {expected} expected")]
    Size {
        /// What is counted.
        quantity: &'static str,
        /// Number expected.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// A regressor or the measurement is not a number.
    #[error("'{name}' is not finite at sample {sample}")]
    NotFinite {
        /// Name of the column.
        name: String,
        /// Index of the sample in the window.
        sample: usize,
    },
    /// Regressors are linearly dependent, so that the data cannot tell their parameters apart.
    #[error(
        "the regressors have rank {rank} of {parameters}: {}; remove terms or add manoeuvres that excite them",
        dependent.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    RankDeficient {
        /// Rank of the regressor matrix.
        rank: usize,
        /// Number of parameters.
        parameters: usize,
        /// Regressors that depend on others.
        dependent: Vec<Dependence>,
    },
    /// An iteration did not come to an end.
    #[error("{method} did not settle in {iterations} iterations")]
    NotConverged {
        /// The iteration in words.
        method: &'static str,
        /// Iterations spent.
        iterations: usize,
    },
    /// A setting is outside its range.
    #[error("{setting} is {value}, allowed is {allowed}")]
    Setting {
        /// Name of the setting.
        setting: String,
        /// Value found.
        value: f64,
        /// Range in words.
        allowed: &'static str,
    },
}
