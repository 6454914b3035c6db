//! Signal preparation: smoothing, differentiation, integration, resampling, lags, sensor positions; control surfaces, air
//! data and fuel from raw sensors; channels by expression; noise statistics; manoeuvres.

mod air_data;
mod airborne;
mod coherence;
mod control_activity;
mod control_sensors;
mod control_surfaces;
mod differentiate;
mod expression;
mod fuel;
mod held;
mod integrate;
mod lag;
mod local_polynomial;
mod manoeuvres;
mod matched;
mod navigation;
mod noise_statistics;
mod path_gusts;
mod position;
mod pulses;
mod rate_smoother;
mod resample;
mod signal_band;
mod smooth;
mod spectrum;
mod steady;
mod treatment;
mod white_noise;
mod whiteness;

use thiserror::Error;

pub use air_data::{
    PodDefinition, PodHistory, level_flight_angle_of_attack, pod_angle_of_attack, pod_calibration, pod_history,
    pod_working_range, sideslip,
};
pub use airborne::{Airborne, airborne};
pub use coherence::{Coherence, Spectrogram, coherence, spectrogram};
pub(crate) use control_sensors::unwrapped;
pub use control_sensors::{
    SensorAttitude, SensorReference, attitude_turn, integrated_turn, integrated_turn_noise, sensor_rates,
};
pub use control_surfaces::{
    ColumnFormula, DeflectionSettings, aileron_deflection, column_travel, deflection_noise, elevator_deflection,
    rudder_deflection, rudder_history,
};
pub use differentiate::{Differentiation, differentiate};
pub use expression::{
    Expression, ExpressionError, LONGEST as LONGEST_EXPRESSION, Operand, between_samples, did_you_mean,
};
pub use fuel::{BlindZone, FuelHistory, FuelReading, FuelSettings, fuel_from_flow, fuel_history, fuel_reading};
pub use held::{HeldSamples, held_samples};
pub use integrate::{cumulative_trapezoid, stretches};
pub use lag::{delay, first_order_lag};
pub use manoeuvres::{
    Manoeuvre, ManoeuvreSearch, ManoeuvreSettings, ManoeuvreShape, PassedOver, Pulse, find_manoeuvres,
};
pub use matched::MatchedSmoothing;
pub use navigation::{position_from_velocity, satellite_fix_at_cg};
pub(crate) use noise_statistics::finest_step;
pub use noise_statistics::{NoiseChoice, NoiseOrigin, NoiseStatistics, NoiseSums, noise_proposal, noise_statistics};
pub use path_gusts::gusts_along_path;
pub use position::{FlowVane, acceleration_at_cg, accelerometer_at, flow_angles_at_cg, flow_angles_at_vanes};
pub use rate_smoother::{SmoothedRate, smoothed_rate};
pub use resample::{Interpolation, resample};
pub use signal_band::signal_band_hz;
pub use smooth::{Smoothing, smooth};
pub use spectrum::{Spectrum, spectrum};
pub use steady::{SteadySearch, SteadySettings, SteadySignal, SteadyStretch, find_steady, intersect};
pub use treatment::{Resampling, Treated, Treatment, treat};
pub use white_noise::white_noise_deviation;
pub use whiteness::WHITE_LEVEL;
pub(crate) use whiteness::{white_noise_probability, whiteness_lags, whiteness_probability};

/// What can be wrong with a signal or the way it is to be treated.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum PrepError {
    #[error("time has {time} samples, the values have {values}")]
    Length { time: usize, values: usize },
    #[error("{found} samples are too few: {method} needs {needed}")]
    TooFewSamples { method: &'static str, needed: usize, found: usize },
    #[error(
        "the step changes from {step_s:.6} s to {found_s:.6} s at {time_s:.3} s: resample first, or use a local polynomial"
    )]
    UnevenStep { step_s: f64, found_s: f64, time_s: f64 },
    #[error("time does not increase after {time_s:.3} s")]
    TimeNotIncreasing { time_s: f64 },
    #[error("a polynomial of degree {degree} needs more than {degree} samples, the window has {width}")]
    Degree { degree: usize, width: usize },
    /// A setting is outside its range.
    #[error("{setting} is {value}, allowed is {allowed}")]
    Setting { setting: &'static str, value: f64, allowed: &'static str },
    #[error("{time_s:.3} s lies outside the recorded {start_s:.3} to {end_s:.3} s")]
    OutsideRange { time_s: f64, start_s: f64, end_s: f64 },
}

/// Checks that time and values have one length, at least `needed` samples, and that time increases.
fn check(time_s: &[f64], values: &[f64], method: &'static str, needed: usize) -> Result<(), PrepError> {
    if time_s.len() != values.len() {
        return Err(PrepError::Length { time: time_s.len(), values: values.len() });
    }
    if values.len() < needed {
        return Err(PrepError::TooFewSamples { method, needed, found: values.len() });
    }
    match time_s.windows(2).find(|pair| !matches!(pair[0].partial_cmp(&pair[1]), Some(std::cmp::Ordering::Less))) {
        Some(pair) => Err(PrepError::TimeNotIncreasing { time_s: pair[0] }),
        None => Ok(()),
    }
}

/// Largest departure of a step from the mean step, as a fraction of it, that still counts as even: beyond it the
/// error of a formula for even steps exceeds one per cent.
const STEP_TOLERANCE: f64 = 0.01;

/// Mean step of an increasing time vector whose steps are all the same.
fn even_step(time_s: &[f64]) -> Result<f64, PrepError> {
    step_within(time_s, STEP_TOLERANCE)
}

/// Whether the steps of an increasing time vector are all the same, as formulas for even steps need them.
pub fn has_even_steps(time_s: &[f64]) -> bool {
    time_s.len() > 1 && even_step(time_s).is_ok()
}

/// Mean step of an increasing time vector whose steps depart from it by no more than a fraction of it.
fn step_within(time_s: &[f64], tolerance: f64) -> Result<f64, PrepError> {
    let step_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    match time_s.windows(2).find(|pair| (pair[1] - pair[0] - step_s).abs() > tolerance * step_s) {
        Some(pair) => Err(PrepError::UnevenStep { step_s, found_s: pair[1] - pair[0], time_s: pair[0] }),
        None => Ok(step_s),
    }
}
