//! Errors of the replay.

use thiserror::Error;

use crate::model::ModelError;

/// Why a window cannot be flown.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ReplayError {
    /// The data of the window.
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error("the manoeuvre has {samples} samples: two at least are needed to fly")]
    TooShort { samples: usize },
    #[error("the wind has {found} samples, time has {expected}")]
    WindLength { expected: usize, found: usize },
    #[error("the recorded motion has {found} samples, time has {expected}")]
    MotionLength { expected: usize, found: usize },
    #[error(
        "the inertia tensor at {time_s:.3} s is not positive definite: check its products against Ixx, Iyy and Izz"
    )]
    Inertia { time_s: f64 },
    #[error("the model has no derivatives of {}: {needed}", missing.join(", "))]
    NoCoefficient { missing: Vec<&'static str>, needed: &'static str },
    #[error("term '{term}' needs {variable}, which this manoeuvre does not have")]
    MissingVariable { term: String, variable: &'static str },
    #[error("the model has no trim at {airspeed_m_s:.1} m/s: an acceleration of {residual:.2e} m/s² or rad/s² is left")]
    NoTrim { airspeed_m_s: f64, residual: f64 },
    #[error("the simulated flight ends at {time_s:.2} s: {what}")]
    Ended { time_s: f64, what: &'static str },
}
