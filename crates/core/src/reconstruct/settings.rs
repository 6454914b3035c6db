//! Settings of the reconstruction and their check.

use std::hash::{Hash, Hasher};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::hash_fields;
use crate::quantity::{HashBits, in_words};
use crate::reconstruct::model::layout::{
    AIR_STATES, AirState, INPUTS, Input, MEASUREMENTS, Measurement, STATES, State,
};

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
    /// Unscented Kalman filter: no Jacobians, means and covariances from sigma points.
    Ukf {
        /// Distance of the sigma points, in standard deviations; the square root of three matches the fourth moment of a
        /// normal distribution.
        spread: f64,
    },
}

impl Hash for Method {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Self::Ekf => {}
            Self::Iekf { max_iterations, tolerance } => {
                max_iterations.hash(state);
                tolerance.hash_bits(state);
            }
            Self::Ukf { spread } => spread.hash_bits(state),
        }
    }
}

impl Method {
    /// Iterated filter as it usually is.
    pub const USUAL_IEKF: Self = Self::Iekf { max_iterations: 10, tolerance: 1e-3 };
    /// Usual distance of sigma points, standard deviations.
    pub const USUAL_SPREAD: f64 = 1.732_050_807_568_877_2;
}

/// What the inertial measurement does between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputHold {
    /// Linear between samples: right for sampled continuous signals, the default.
    FirstOrder,
    /// Constant at the earlier sample: what most published filters do.
    ZeroOrder,
}

/// Where the transition matrix is linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Linearisation {
    /// At the state before the step, the derivative of the integration itself.
    Prior,
    /// At the predicted state, as some published filters do.
    Predicted,
}

/// Unchecked settings of the reconstruction; [`FilterSettings::check`] makes them valid.
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
    /// Standard deviation of each state before the first measurement; zero says it is known; a bias or
    /// wind then stays at its initial value unless it has a random walk. SI.
    pub initial_deviation: [f64; STATES],
    /// Initial state; an entry that is `None` is taken from the first measurements (zero for biases and wind). SI.
    pub initial_state: [Option<f64>; STATES],
    /// Standard deviation of a random walk on each state, SI per square root of a second; zero for none.
    pub random_walk: [f64; STATES],
    /// Standard deviation of each air-data state before the first measurement; zero leaves it out. With any of them the
    /// filter takes its dense form, which is slower. Dimensionless or rad.
    pub air_data_deviation: [f64; AIR_STATES],
    /// Delay of each measurement: a sample stamped t shows the value at t less the delay, s.
    pub measurement_delay_s: [f64; MEASUREMENTS],
    /// Whether to smooth the filtered path backwards (Rauch-Tung-Striebel; unscented with the unscented filter).
    pub smooth: bool,
    /// Passes of the smoother at most: each after the first filters and smooths again, linearised about the smoothed path, until
    /// that moves by less than [`SMOOTHER_TOLERANCE`]. 1 for none.
    pub smoother_passes: usize,
    /// Innovation, in its deviations or, where these are larger, in those its measurement typically has, beyond which a spike of up to
    /// three samples is left out; zero for none.
    pub outlier_limit: f64,
    /// Innovation, in its predicted deviations, beyond which the update weighs a measurement less (Huber 1964): its correction is
    /// that of an innovation at the limit. Zero for none.
    pub robust_limit: f64,
}

hash_fields!(FilterSettings {
    method, hold, linearisation, smooth, smoother_passes;
    gravity_m_s2, process_noise, measurement_noise, initial_deviation, initial_state, random_walk, air_data_deviation, measurement_delay_s,
    outlier_limit, robust_limit
});

/// Usual limit of outliers, deviations: beyond what noise, gusts and sensors that lag reach.
pub const USUAL_OUTLIER_LIMIT: f64 = 8.0;

/// Movement of a smoothed path, in its standard deviations, below which the iterated smoother has converged.
pub const SMOOTHER_TOLERANCE: f64 = 1e-3;

impl Default for FilterSettings {
    /// Iterated filter with first-order hold, noise of good flight-test instruments: accelerometers 0.02 m/s², gyros
    /// 0.005 deg/s, position 1 m, ground velocity 0.05 m/s, attitude 0.05 deg, airspeed 0.2 m/s, flow angles 0.1 deg.
    fn default() -> Self {
        let [attitude, flow, gyro] = [0.05_f64, 0.1, 0.005].map(f64::to_radians);
        let [attitude_0, bias_gyro_0] = [2.0_f64, 0.05].map(f64::to_radians);
        let mut initial_deviation = [0.0; STATES];
        let groups = [10.0, 5.0, attitude_0, 0.1, bias_gyro_0, 20.0];
        for (deviation, group) in initial_deviation.chunks_exact_mut(3).zip(groups) {
            deviation.fill(group);
        }
        Self {
            method: Method::USUAL_IEKF,
            hold: InputHold::FirstOrder,
            linearisation: Linearisation::Prior,
            gravity_m_s2: STANDARD_GRAVITY_M_S2,
            process_noise: [0.02, 0.02, 0.02, gyro, gyro, gyro],
            measurement_noise: [1.0, 1.0, 1.0, 0.05, 0.05, 0.05, attitude, attitude, attitude, 0.2, flow, flow],
            initial_deviation,
            initial_state: [None; STATES],
            random_walk: [0.0; STATES],
            air_data_deviation: [0.0; AIR_STATES],
            measurement_delay_s: [0.0; MEASUREMENTS],
            smooth: false,
            smoother_passes: 1,
            outlier_limit: USUAL_OUTLIER_LIMIT,
            robust_limit: 0.0,
        }
    }
}

/// Standard gravity, m/s² (ISO 80000-3).
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Settings that passed [`FilterSettings::check`].
#[derive(Clone, Debug, PartialEq)]
pub struct ValidSettings(FilterSettings);

impl std::ops::Deref for ValidSettings {
    type Target = FilterSettings;

    fn deref(&self) -> &FilterSettings {
        &self.0
    }
}

impl ValidSettings {
    /// The same without smoothing.
    pub(crate) fn filter_alone(&self) -> Self {
        Self(FilterSettings { smooth: false, smoother_passes: 1, ..self.0.clone() })
    }
}

impl FilterSettings {
    /// The settings that likelihoods are computed with: an extended filter without air-data states, smoothed once or not at all, with
    /// every sample at its full weight.
    #[must_use]
    pub fn simplified(&self, smooth: bool) -> Self {
        let method = if let Method::Ukf { .. } = self.method { Method::USUAL_IEKF } else { self.method };
        let air_data_deviation = [0.0; AIR_STATES];
        Self {
            method,
            smooth,
            smoother_passes: 1,
            air_data_deviation,
            outlier_limit: 0.0,
            robust_limit: 0.0,
            ..self.clone()
        }
    }

    /// The settings as valid ones, or every field outside its range.
    pub fn check(&self) -> Result<ValidSettings, Vec<SettingError>> {
        let mut errors = Vec::new();
        let mut require = |ok: bool, field: String, value: f64, allowed: &'static str| {
            if !ok {
                errors.push(SettingError { field, value, allowed });
            }
        };
        if let Method::Iekf { max_iterations, tolerance } = self.method {
            let count = max_iterations as f64;
            require((1..=100).contains(&max_iterations), "method.max_iterations".into(), count, "1 to 100");
            require((1e-12..=1.0).contains(&tolerance), "method.tolerance".into(), tolerance, "1e-12 to 1");
        }
        if let Method::Ukf { spread } = self.method {
            require((1e-3..=5.0).contains(&spread), "method.spread".into(), spread, "1e-3 to 5");
        }
        let passes = self.smoother_passes;
        require((1..=100).contains(&passes), "smoother_passes".into(), passes as f64, "1 to 100");
        let limit = self.outlier_limit;
        require(limit == 0.0 || (3.0..=1e6).contains(&limit), "outlier_limit".into(), limit, "0, or 3 to 1e6");
        let limit = self.robust_limit;
        require(limit == 0.0 || (1.0..=1e6).contains(&limit), "robust_limit".into(), limit, "0, or 1 to 1e6");
        let g = self.gravity_m_s2;
        require((9.7..=9.9).contains(&g), "gravity_m_s2".into(), g, "9.7 to 9.9 m/s²");
        for input in Input::ALL {
            let value = self.process_noise[input as usize];
            require((0.0..1e3).contains(&value), format!("process_noise.{}", input.name()), value, NOT_NEGATIVE);
        }
        for measurement in Measurement::ALL {
            let value = self.measurement_noise[measurement as usize];
            let field = format!("measurement_noise.{}", measurement.name());
            require((1e-9..1e6).contains(&value), field, value, "1e-9 to 1e6");
            let value = self.measurement_delay_s[measurement as usize];
            let field = format!("measurement_delay_s.{}", measurement.name());
            require((-10.0..=10.0).contains(&value), field, value, "-10 to 10 s");
        }
        for state in AirState::ALL {
            let value = self.air_data_deviation[state as usize];
            require((0.0..=1.0).contains(&value), format!("air_data_deviation.{}", state.name()), value, "0 to 1");
        }
        for state in State::ALL {
            let (k, name) = (state as usize, state.name());
            let value = self.initial_deviation[k];
            require((0.0..1e6).contains(&value), format!("initial_deviation.{name}"), value, "0 to 1e6");
            let value = self.random_walk[k];
            require((0.0..1e3).contains(&value), format!("random_walk.{name}"), value, NOT_NEGATIVE);
            let value = self.initial_state[k].unwrap_or(0.0);
            require(value.abs() < 1e8, format!("initial_state.{name}"), value, "finite, below 1e8 in magnitude");
        }
        if errors.is_empty() { Ok(ValidSettings(self.clone())) } else { Err(errors) }
    }
}

const NOT_NEGATIVE: &str = "0 to 1e3";

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{field} is {}, allowed is {allowed}", in_words(*.value))]
pub struct SettingError {
    /// Dotted name of the field, for example `measurement_noise.alpha`.
    pub field: String,
    /// Value found.
    pub value: f64,
    /// Range in words.
    pub allowed: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_settings_are_valid() {
        assert!(FilterSettings::default().check().is_ok());
    }

    #[test]
    fn check_names_every_field_outside_its_range() {
        let mut settings = FilterSettings { gravity_m_s2: f64::NAN, ..FilterSettings::default() };
        settings.measurement_noise[Measurement::AngleOfAttack as usize] = 0.0;
        let fields: Vec<String> = settings.check().unwrap_err().into_iter().map(|error| error.field).collect();
        assert_eq!(fields, ["gravity_m_s2", "measurement_noise.alpha"]);
    }
}
