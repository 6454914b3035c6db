//! What can go wrong in a design.

use doublet_core::estimate::EstimateError;
use doublet_core::model::ModelError;
use thiserror::Error;

use crate::linear::LinearError;

/// Why there is no design.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum DesignError {
    /// No trim, or a condition that is none.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// A variable that the model needs and the flight does not give.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Regressors that depend on each other.
    #[error("{coefficient}: {source}")]
    Estimate { coefficient: &'static str, source: EstimateError },
    #[error(
        "{kind} on {surfaces} takes at least {needed_s:.1} s, {given_s} s are given: give more time or fewer surfaces"
    )]
    TooShort { kind: &'static str, surfaces: String, needed_s: f64, given_s: f64 },
    #[error(
        "the limit of {quantity} leaves no room about the trim, where it is {trim:.4} of {low:.4} to {high:.4}: widen it or change the trim"
    )]
    NoRoom { quantity: &'static str, trim: f64, low: f64, high: f64 },
    #[error("the simulated flight ends after {time_s:.2} s: reduce the amplitude or the time")]
    Departed { time_s: f64 },
    /// Nobody wants it any more.
    #[error("stopped")]
    Stopped,
    #[error("no surface is named: use aileron, elevator, rudder or throttle")]
    NoSurface,
    #[error(
        "the throttle needs thrust: give the aircraft engines with charts and remove the thrust from the coefficients"
    )]
    NoThrust,
}
