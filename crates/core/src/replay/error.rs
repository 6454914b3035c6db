//! Errors of the replay.

use thiserror::Error;

use crate::model::ModelError;

/// Why a window cannot be flown.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReplayError {
    /// The data of the window.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Too few samples.
    #[error("the manoeuvre has {samples} samples: two at least are needed to fly")]
    TooShort {
        /// Samples there are.
        samples: usize,
    },
    /// The wind has another length than the time vector.
    #[error("the wind has {found} samples, time has {expected}")]
    WindLength {
        /// Samples of the time vector.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// The recorded motion has another length than the time vector.
    #[error("the recorded motion has {found} samples, time has {expected}")]
    MotionLength {
        /// Samples of the time vector.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// The inertia tensor cannot be solved with.
    #[error(
        "the inertia tensor at {time_s:.3} s is not positive definite: check its products against Ixx, Iyy and Izz"
    )]
    Inertia {
        /// Time of the sample, s.
        time_s: f64,
    },
    /// Coefficients without derivatives.
    #[error("the model has no derivatives of {}: {needed}", missing.join(", "))]
    NoCoefficient {
        /// Names of the coefficients.
        missing: Vec<&'static str>,
        /// What the flight needs, in words.
        needed: &'static str,
    },
    /// A term needs a variable the window does not have.
    #[error("term '{term}' needs {variable}, which this manoeuvre does not have")]
    MissingVariable {
        /// The term.
        term: String,
        /// Name of the variable.
        variable: &'static str,
    },
    /// The model has no steady flight there.
    #[error("the model has no trim at {airspeed_m_s:.1} m/s: an acceleration of {residual:.2e} m/s² or rad/s² is left")]
    NoTrim {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Largest acceleration left, m/s² or rad/s².
        residual: f64,
    },
    /// The motion left what can be simulated.
    #[error("the simulated flight ends at {time_s:.2} s: {what}")]
    Ended {
        /// Time, s.
        time_s: f64,
        /// What happened.
        what: &'static str,
    },
}
