//! Settings of the reconstruction and their check.

use thiserror::Error;

use super::layout::{INPUTS, MEASUREMENTS, STATES};

/// How the measurement update treats its nonlinearity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Extended Kalman filter: one linearisation, at the predicted state.
    Ekf,
    /// Iterated extended Kalman filter: relinearised at the updated state until the change, in standard deviations of
    /// the predicted state, falls below `tolerance` or `max_iterations` are spent.
    Iekf {
        /// Limit on iterations, at least 1.
        max_iterations: usize,
        /// Largest change of any state, in its standard deviations, at which the iteration stops.
        tolerance: f64,
    },
}

/// What the inertial measurement does between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputHold {
    /// Linear between samples: right for sampled continuous signals, the default.
    FirstOrder,
    /// Constant at the earlier sample: what most published filters do.
    ZeroOrder,
}

/// Where the transition matrix is linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linearisation {
    /// At the state before the step, the derivative of the integration itself.
    Prior,
    /// At the predicted state, as some published filters do.
    Predicted,
}

/// Unchecked settings of the reconstruction.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterSettings {
    /// Filter.
    pub method: Method,
    /// Input between samples.
    pub hold: InputHold,
    /// Linearisation point of the transition.
    pub linearisation: Linearisation,
    /// Gravitational acceleration, m/s².
    pub gravity_m_s2: f64,
    /// Standard deviation of the noise of each input sample (square root of the diagonal of Q); SI.
    pub process_noise: [f64; INPUTS],
    /// Standard deviation of each measurement (square root of the diagonal of R); SI.
    pub measurement_noise: [f64; MEASUREMENTS],
    /// Standard deviation of each state before the first measurement; zero freezes the state at its initial value. SI.
    pub initial_deviation: [f64; STATES],
    /// Initial state; an entry that is `None` is taken from the first measurements (zero for biases and wind). SI.
    pub initial_state: [Option<f64>; STATES],
    /// Standard deviation of a random walk on each state, SI per square root of a second; zero for none.
    pub random_walk: [f64; STATES],
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{field} is {value}, allowed is {allowed}")]
pub struct SettingError {
    /// Dotted name of the field, for example `measurement_noise.alpha`.
    pub field: String,
    /// Value found.
    pub value: f64,
    /// Range in words.
    pub allowed: &'static str,
}
