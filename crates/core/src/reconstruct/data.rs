//! What a reconstruction starts from and what it gives. Columns and times are shared where they are the same: those of a window with
//! the recording, of a path with its samples.

use std::sync::Arc;

use crate::message::Message;
use crate::reconstruct::deviations::Deviations;
use crate::reconstruct::model::layout::{AIR_STATES, INPUTS, MEASUREMENTS, STATES};

/// Inertial samples that drive the filter. All columns have the length of `time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSeries {
    /// Time, s, strictly increasing.
    pub time_s: Arc<[f64]>,
    /// One column per [`Input`](crate::reconstruct::model::layout::Input), SI.
    pub columns: [Arc<[f64]>; INPUTS],
}

/// Samples of one measurement at its own times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasurementSeries {
    /// Time, s, strictly increasing.
    pub time_s: Arc<[f64]>,
    /// Value, SI; a value that is not finite is skipped.
    pub values: Arc<[f64]>,
}

/// What one window offers to the filter.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterData {
    /// Inertial samples.
    pub inputs: InputSeries,
    /// One series per [`Measurement`](crate::reconstruct::model::layout::Measurement); an empty one is a measurement the recording does not have.
    pub measurements: [MeasurementSeries; MEASUREMENTS],
}

/// Result of a reconstruction. State columns have the length of `time_s`, those of innovations that of `update_time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// Time of the inertial samples, s.
    pub time_s: Arc<[f64]>,
    /// Filtered estimate of each state, SI.
    pub states: [Vec<f64>; STATES],
    /// Standard deviation of each state, SI.
    pub deviations: [Deviations; STATES],
    /// Times of the inertial samples and of the measurements between them, s: equal to `time_s` where every measurement
    /// was taken at an inertial sample.
    pub update_time_s: Arc<[f64]>,
    /// Innovation of each measurement at each time; NaN where there was none, empty where the window has no sample of it. SI.
    pub innovations: [Vec<f64>; MEASUREMENTS],
    /// Predicted standard deviation of each innovation, the square root of the diagonal of `H P H' + R`; NaN where there was none,
    /// empty where the window has no sample of it. SI.
    pub innovation_deviations: [Deviations; MEASUREMENTS],
    /// Normalised innovation squared of each time; NaN where nothing was measured.
    pub nis: Vec<f64>,
    /// Number of measurements at each time: the degrees of freedom of `nis`.
    pub nis_degrees: Vec<u8>,
    /// Logarithm of the likelihood of the measurements, `-1/2 sum (ln |S| + nu' S^-1 nu + m ln 2 pi)`.
    pub log_likelihood: f64,
    /// Air-data states, where the settings ask for any.
    pub air_data: Option<AirData>,
    /// Covariance of the final state, SI.
    pub final_covariance: nalgebra::SMatrix<f64, STATES, STATES>,
    /// Smoothed path, where the settings ask for it.
    pub smoothed: Option<Smoothed>,
    /// Largest number of iterations any update took.
    pub max_iterations_used: usize,
    /// Samples of each measurement that were left out, in order (`outlier_limit` of the settings).
    pub outliers: [Vec<Outlier>; MEASUREMENTS],
    /// Findings, one line each.
    pub warnings: Vec<Message>,
}

/// A sample that was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Time as recorded, s.
    pub time_s: f64,
    /// Value, SI.
    pub value: f64,
}

/// Path smoothed by the whole window; every column has the length of the inertial time.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// Smoothed estimate of each state, SI.
    pub states: [Vec<f64>; STATES],
    /// Its standard deviation, SI.
    pub deviations: [Deviations; STATES],
    /// Air-data states, where the settings ask for any.
    pub air_data: Option<AirData>,
    /// What the iterated smoother minimises, after each of its passes; empty where it did not run. Sum of squares of the
    /// initial error, the process noise and the measurement noise, each over its variance; not a number where an input is
    /// said to be free of noise.
    pub costs: Vec<f64>,
}

/// Estimates of the air-data states; those the settings leave out stay at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct AirData {
    /// Estimate, one column per [`AirState`](crate::reconstruct::model::layout::AirState).
    pub states: [Vec<f64>; AIR_STATES],
    /// Its standard deviation.
    pub deviations: [Vec<f64>; AIR_STATES],
}
