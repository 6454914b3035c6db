//! Flight path reconstruction: kinematics, extended and iterated extended Kalman filter, consistency.

mod layout;
mod settings;

pub use layout::{INPUTS, Input, MEASUREMENTS, Measurement, STATES, State};
pub use settings::{FilterSettings, InputHold, Linearisation, Method, SettingError};

/// Inertial samples that drive the filter. All columns have the length of `time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSeries {
    /// Time, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// One column per [`Input`], SI.
    pub columns: [Vec<f64>; INPUTS],
}

/// Samples of one measurement at its own times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasurementSeries {
    /// Time, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// Value, SI; a value that is not finite is skipped.
    pub values: Vec<f64>,
}

/// What one window offers to the filter.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterData {
    /// Inertial samples.
    pub inputs: InputSeries,
    /// One series per [`Measurement`]; an empty one is a measurement the recording does not have.
    pub measurements: [MeasurementSeries; MEASUREMENTS],
}

/// Result of a reconstruction; every column has the length of `time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// Time of the inertial samples, s.
    pub time_s: Vec<f64>,
    /// Filtered estimate of each state, SI.
    pub states: [Vec<f64>; STATES],
    /// Standard deviation of each state, SI.
    pub deviations: [Vec<f64>; STATES],
    /// Innovation of each measurement at each time; NaN where there was none. SI.
    pub innovations: [Vec<f64>; MEASUREMENTS],
    /// Predicted standard deviation of each innovation, the square root of the diagonal of `H P H' + R`. SI.
    pub innovation_deviations: [Vec<f64>; MEASUREMENTS],
    /// Normalised innovation squared of each time; NaN where nothing was measured.
    pub nis: Vec<f64>,
    /// Number of measurements at each time: the degrees of freedom of `nis`.
    pub nis_degrees: Vec<u8>,
    /// Covariance of the final state, SI.
    pub final_covariance: nalgebra::SMatrix<f64, STATES, STATES>,
    /// Largest number of iterations any update took.
    pub max_iterations_used: usize,
    /// Findings, one line each.
    pub warnings: Vec<String>,
}
