//! Errors of sensors as constants common to windows: data compatibility by maximum likelihood.

mod fit;
mod kinematics;
mod window;

use std::fmt;

use thiserror::Error;

pub use fit::{EstimatedError, OutputResidual, SensorErrorFit, WindowShare, sensor_errors};

use super::{EstimateError, OutputErrorSettings};
use crate::reconstruct::{FilterData, INPUTS, Input, MEASUREMENTS, Measurement, ReconstructError, STATES};

/// A sensor: of the inertial unit, or one whose samples are compared with the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sensor {
    /// Accelerometer or gyro.
    Input(Input),
    /// Any other.
    Measurement(Measurement),
}

impl Sensor {
    /// Name, `ax` or `alpha`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Input(input) => input.name(),
            Self::Measurement(measurement) => measurement.name(),
        }
    }

    fn si_symbol(self) -> &'static str {
        match self {
            Self::Input(input) => input.dimension().si_symbol(),
            Self::Measurement(measurement) => measurement.dimension().si_symbol(),
        }
    }
}

/// An error of a sensor: what it shows is `(1 + scale) true + bias`; the axes of the inertial unit are turned against those of the body
/// by three small angles `e` (misalignment), so that `true = sensed + e x sensed` (Klein and Morelli 2006, chapter 10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SensorError {
    /// Bias, in the unit of the sensor.
    Bias(Sensor),
    /// Scale factor less one.
    Scale(Sensor),
    /// Misalignment of the inertial unit about body axis x, y or z, rad.
    Misalignment(usize),
}

/// Names of the misalignments, axis by axis.
const MISALIGNMENTS: [&str; 3] = ["misalignment_x", "misalignment_y", "misalignment_z"];

impl SensorError {
    /// Every error there is.
    pub fn all() -> impl Iterator<Item = Self> {
        let inputs = Input::ALL.into_iter().map(Sensor::Input);
        let sensors = inputs.chain(Measurement::ALL.into_iter().map(Sensor::Measurement));
        let of_sensors = sensors.flat_map(|sensor| [Self::Bias(sensor), Self::Scale(sensor)]);
        of_sensors.chain((0..MISALIGNMENTS.len()).map(Self::Misalignment))
    }

    /// The one called `name`: `bias_ax`, `scale_alpha`, `misalignment_x`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|error| error.to_string() == name)
    }

    /// Unit of its value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Bias(sensor) => sensor.si_symbol(),
            Self::Scale(_) => "-",
            Self::Misalignment(_) => "rad",
        }
    }

    /// Smallest value that matters.
    fn scale(self) -> f64 {
        use crate::quantity::Dimension;
        let dimension = match self {
            Self::Bias(Sensor::Input(input)) => input.dimension(),
            Self::Bias(Sensor::Measurement(measurement)) => measurement.dimension(),
            Self::Scale(_) | Self::Misalignment(_) => return 1e-2,
        };
        match dimension {
            Dimension::Length => 1.0,
            Dimension::Speed => 0.1,
            Dimension::Acceleration => 0.05,
            _ => 1e-3,
        }
    }
}

impl fmt::Display for SensorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bias(sensor) => write!(f, "bias_{}", sensor.name()),
            Self::Scale(sensor) => write!(f, "scale_{}", sensor.name()),
            Self::Misalignment(axis) => f.write_str(MISALIGNMENTS[*axis % MISALIGNMENTS.len()]),
        }
    }
}

/// What is said of one error. Errors of which nothing is said are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorTerm {
    /// Error.
    pub error: SensorError,
    /// How it enters.
    pub freedom: Freedom,
    /// Its value where it is fixed, else where the search starts, SI.
    pub value: f64,
    /// Standard deviation of a random walk on it, SI per square root of a second; zero for none. Needs stated noise; the value
    /// estimated is then that at the start of each window.
    pub random_walk: f64,
}

/// How an error enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Its value is known.
    Fixed,
    /// One value for all windows.
    Common,
    /// A value for each window.
    PerWindow,
}

/// What the samples scatter by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of it in a problem")]
pub enum NoiseModel {
    /// The measurements alone, by as much as their residuals say: output error. The path is integrated from the inertial samples as if
    /// they had no noise.
    Residuals,
    /// Inertial samples and measurements by stated standard deviations, SI: filter error. The path is that of an extended Kalman
    /// filter, so that inertial noise and random walks count, and the errors of the estimates hold with them.
    Stated {
        /// Of each inertial sample.
        process: [f64; INPUTS],
        /// Of each measurement.
        measurement: [f64; MEASUREMENTS],
        /// Random walks of motion and wind, gusts for example, by state of the reconstruction, SI per square root of a second; those of
        /// its biases do not count, as errors have their own.
        path: [f64; STATES],
    },
}

/// A problem of data compatibility.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorErrorSettings {
    /// Errors that are free or known.
    pub errors: Vec<ErrorTerm>,
    /// Measurements the path is compared with; those a window does not have are left out there.
    pub outputs: Vec<Measurement>,
    /// Whether each window has a wind of its own, estimated from ground velocity or position; otherwise the air is at rest.
    pub wind: bool,
    /// Gravitational acceleration, m/s².
    pub gravity_m_s2: f64,
    /// Noise.
    pub noise: NoiseModel,
    /// When the iteration ends.
    pub search: OutputErrorSettings,
}

/// A window of a problem.
#[derive(Clone, Debug)]
pub struct SensorErrorWindow<'a> {
    /// Name.
    pub label: String,
    /// Inertial samples and measurements.
    pub data: &'a FilterData,
}

/// Why sensor errors were not found.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum SensorErrorFault {
    /// Samples of a window that cannot be integrated.
    #[error("manoeuvre '{window}': {error}")]
    Window { window: String, error: ReconstructError },
    #[error(
        "none of the outputs {outputs} is measured in any manoeuvre: choose others, or name their channels in the channel map"
    )]
    NoOutput { outputs: String },
    #[error("{error} is free, but {sensor} is not a measured output: add it to the outputs, or fix the error")]
    NotCompared { error: SensorError, sensor: &'static str },
    #[error("{error} has a random walk, which output error cannot follow: use the method filter_error")]
    RandomWalk { error: SensorError },
    /// The estimation.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}
