//! What can go wrong in a reconstruction.

use thiserror::Error;

/// Why a reconstruction has no result. Every variant says where in the recording.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ReconstructError {
    #[error(
        "{measurement} is not recorded in this manoeuvre, and the path as measured needs it: map its channel, or use the filter"
    )]
    NotMeasured { measurement: &'static str },
    #[error("{samples} inertial samples: a reconstruction needs at least 2; widen the manoeuvre")]
    TooFewSamples { samples: usize },
    #[error("{channel} has {values} values at {times} times; every channel needs one value per time")]
    UnequalLengths { channel: &'static str, values: usize, times: usize },
    #[error(
        "time of {channel} does not increase at {time_s} s (sample {sample}); sort the recording or drop the repeated samples"
    )]
    UnorderedTime { channel: &'static str, time_s: f64, sample: usize },
    #[error(
        "{input} is {value} at {time_s} s; the filter needs every inertial sample, so choose a manoeuvre without this gap"
    )]
    InputNotFinite { input: &'static str, time_s: f64, value: f64 },
    #[error(
        "pitch angle is {theta_deg:.2} deg at {time_s} s; Euler angles are singular at 90 deg, end the manoeuvre before"
    )]
    NearVertical { time_s: f64, theta_deg: f64 },
    #[error(
        "{state} is {value} at {time_s} s: the filter diverged; check units and signs of the channels, the initial state and the noise settings"
    )]
    Diverged { state: &'static str, time_s: f64, value: f64 },
    #[error(
        "variance of {state} is {variance} at {time_s} s: the covariance lost positive definiteness; choose initial standard deviations and measurement noise of closer size"
    )]
    NotPositiveDefinite { state: &'static str, time_s: f64, variance: f64 },
    #[error("innovation covariance is singular at {time_s} s; raise the measurement noise")]
    SingularInnovation { time_s: f64 },
    #[error("the reconstruction has no result; report it with the session and its recordings")]
    NoResult,
    /// Stopped on request.
    #[error("reconstruction cancelled")]
    Cancelled,
}

impl ReconstructError {
    /// Whether rounding may be to blame, so that a more robust form of the filter is worth trying.
    pub(super) fn is_numerical(&self) -> bool {
        matches!(self, Self::Diverged { .. } | Self::NotPositiveDefinite { .. } | Self::SingularInnovation { .. })
    }
}
