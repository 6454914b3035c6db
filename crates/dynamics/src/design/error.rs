//! What can go wrong in a design.

use doublet_core::estimate::EstimateError;
use doublet_core::model::ModelError;
use thiserror::Error;

use crate::linear::LinearError;

/// Why there is no design.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DesignError {
    /// No trim, or a condition that is none.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// A variable that the model needs and the flight does not give.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Regressors that depend on each other.
    #[error("{coefficient}: {source}")]
    Estimate {
        /// Coefficient.
        coefficient: &'static str,
        /// What is wrong with its regression.
        source: EstimateError,
    },
    /// Less time than the shortest form of the input takes.
    #[error(
        "{kind} on {surfaces} takes at least {needed_s:.1} s, {given_s} s are given: give more time or fewer surfaces"
    )]
    TooShort {
        /// Kind of input.
        kind: &'static str,
        /// Surfaces it moves.
        surfaces: String,
        /// Least time, s.
        needed_s: f64,
        /// Time given, s.
        given_s: f64,
    },
    /// The aircraft does not stay within the limits however small the input.
    #[error(
        "the limit of {quantity} leaves no room about the trim, where it is {trim:.4} of {low:.4} to {high:.4}: widen it or change the trim"
    )]
    NoRoom {
        /// Quantity.
        quantity: &'static str,
        /// Value at the trim.
        trim: f64,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// The simulated flight left what a flight can be.
    #[error("the simulated flight ends after {time_s:.2} s: reduce the amplitude or the time")]
    Departed {
        /// When, s.
        time_s: f64,
    },
    /// Nobody wants it any more.
    #[error("stopped")]
    Stopped,
    /// Nothing to design.
    #[error("no surface is named: use aileron, elevator, rudder or throttle")]
    NoSurface,
    /// The throttle of a model whose thrust is not known.
    #[error(
        "the throttle needs thrust: give the aircraft engines with charts and remove the thrust from the coefficients"
    )]
    NoThrust,
}
