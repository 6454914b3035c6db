//! What can go wrong in a reconstruction.

use thiserror::Error;

/// Why a reconstruction has no result. Every variant says where in the recording.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReconstructError {
    /// A path as measured needs what is not measured.
    #[error(
        "{measurement} is not recorded in this manoeuvre, and the path as measured needs it: map its channel, or use the filter"
    )]
    NotMeasured {
        /// Measurement.
        measurement: &'static str,
    },
    /// Fewer than two inertial samples.
    #[error("{samples} inertial samples: a reconstruction needs at least 2; widen the manoeuvre")]
    TooFewSamples {
        /// Number found.
        samples: usize,
    },
    /// Columns of unequal length.
    #[error("{channel} has {values} values at {times} times; every channel needs one value per time")]
    UnequalLengths {
        /// Input or measurement.
        channel: &'static str,
        /// Number of values.
        values: usize,
        /// Number of times.
        times: usize,
    },
    /// Times that do not increase, or are not finite.
    #[error(
        "time of {channel} does not increase at {time_s} s (sample {sample}); sort the recording or drop the repeated samples"
    )]
    UnorderedTime {
        /// Input or measurement.
        channel: &'static str,
        /// Time found, s.
        time_s: f64,
        /// Index of the sample.
        sample: usize,
    },
    /// An inertial sample that is not a number: the filter is driven by these and cannot skip one.
    #[error(
        "{input} is {value} at {time_s} s; the filter needs every inertial sample, so choose a manoeuvre without this gap"
    )]
    InputNotFinite {
        /// Input.
        input: &'static str,
        /// Time, s.
        time_s: f64,
        /// Value found.
        value: f64,
    },
    /// Euler angles are singular at +-90 deg of pitch.
    #[error(
        "pitch angle is {theta_deg:.2} deg at {time_s} s; Euler angles are singular at 90 deg, end the manoeuvre before"
    )]
    NearVertical {
        /// Time, s.
        time_s: f64,
        /// Pitch angle, deg.
        theta_deg: f64,
    },
    /// An estimate that left every physical range.
    #[error(
        "{state} is {value} at {time_s} s: the filter diverged; check units and signs of the channels, the initial state and the noise settings"
    )]
    Diverged {
        /// State.
        state: &'static str,
        /// Time, s.
        time_s: f64,
        /// Value found, SI.
        value: f64,
    },
    /// A variance that is not positive, also in the Joseph form.
    #[error(
        "variance of {state} is {variance} at {time_s} s: the covariance lost positive definiteness; choose initial standard deviations and measurement noise of closer size"
    )]
    NotPositiveDefinite {
        /// State.
        state: &'static str,
        /// Time, s.
        time_s: f64,
        /// Variance found, SI.
        variance: f64,
    },
    /// An innovation covariance without inverse, also in the Joseph form.
    #[error("innovation covariance is singular at {time_s} s; raise the measurement noise")]
    SingularInnovation {
        /// Time, s.
        time_s: f64,
    },
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
