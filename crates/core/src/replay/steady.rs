//! Replay from a trim of the model in place of the recorded start.

use std::ops::Range;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::fly::Flight;
use super::sample::Sample;
use super::{Replay, ReplayError, Start};
use crate::model::Derivatives;
use crate::motion::State;

/// Newton steps before giving up.
const MAX_STEPS: usize = 40;
/// Residual accelerations at which a trim is accepted, m/s² and rad/s².
const TOLERANCE: f64 = 1e-8;
/// Step of the differences.
const DIFFERENCE: f64 = 1e-6;
/// Longest step of an unknown.
const LONGEST: f64 = 0.3;
/// Part of the weight below which a recorded thrust cannot be scaled: the flight path follows from it instead.
const LEAST_THRUST: f64 = 0.005;

/// Steady flight of a recording before its input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyCondition {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Angle of the path through the air, rad.
    pub path_rad: f64,
    /// Turn rate, rad/s.
    pub turn_rate_rad_s: f64,
    /// Angle of attack and sideslip as recorded, where the search begins, rad.
    pub flow_rad: [f64; 2],
    /// Bank as recorded, where the search begins, rad.
    pub bank_rad: f64,
}

/// Trim of a model in a steady flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTrim {
    /// Angle of attack, rad.
    pub alpha_rad: f64,
    /// Sideslip, rad.
    pub beta_rad: f64,
    /// Bank and pitch angle, rad.
    pub attitude_rad: [f64; 2],
    /// Angle of the path through the air, rad.
    pub path_rad: f64,
    /// Aileron, elevator, rudder, rad; the rudder is the recorded one.
    pub controls_rad: [f64; 3],
    /// Their recorded means, rad.
    pub recorded_controls_rad: [f64; 3],
    /// Sum of the thrusts, N.
    pub thrust_n: f64,
    /// Its recorded mean, N.
    pub recorded_thrust_n: f64,
}

impl Replay {
    /// The replay that starts from the trim of `model` in the steady flight of the samples `steady`, and its start. Deflections and
    /// thrust are those of the trim plus the recorded changes from their means there; the wind is the mean wind there.
    ///
    /// The trim has no acceleration at the recorded airspeed, path, turn rate and rudder: angle of attack, sideslip, bank, aileron,
    /// elevator and thrust follow. Without thrust to change, the path follows.
    ///
    /// # Errors
    /// Those of [`Replay::check`], [`ReplayError::NoTrim`], and [`ReplayError::TooShort`] without a steady sample.
    pub fn from_trim(
        &self,
        model: &Derivatives,
        steady: Range<usize>,
        condition: &SteadyCondition,
        recorded: &Start,
    ) -> Result<(Self, Start, SteadyTrim), ReplayError> {
        self.check(model)?;
        let samples = self.samples.get(steady).filter(|samples| !samples.is_empty());
        let samples = samples.ok_or(ReplayError::TooShort { samples: 0 })?;
        let mean = mean_sample(samples);
        let flight = Flight::new(self, model, recorded.position_ned_m[2]);
        let weight_n = mean.mass_kg * self.gravity_m_s2;
        let powered = mean.thrust_force_n.norm() > LEAST_THRUST * weight_n;
        let search = Search { flight: &flight, mean: &mean, condition, recorded, powered };
        let point = search.solve()?;
        let shift = point.sample;
        let [aileron, elevator, rudder] = std::array::from_fn(|i| shift.controls_rad[i] - mean.controls_rad[i]);
        let mut replay = self.clone();
        for sample in &mut replay.samples {
            sample.controls_rad[0] += aileron;
            sample.controls_rad[1] += elevator;
            sample.controls_rad[2] += rudder;
            sample.thrust_n += shift.thrust_n - mean.thrust_n;
            sample.thrust_force_n += shift.thrust_force_n - mean.thrust_force_n;
            sample.thrust_moment_n_m += shift.thrust_moment_n_m - mean.thrust_moment_n_m;
            sample.wind_ned_m_s = mean.wind_ned_m_s;
        }
        let start = point.start;
        let trim = SteadyTrim {
            alpha_rad: point.alpha_rad,
            beta_rad: point.beta_rad,
            attitude_rad: [start.euler_rad[0], start.euler_rad[1]],
            path_rad: point.path_rad,
            controls_rad: shift.controls_rad,
            recorded_controls_rad: mean.controls_rad,
            thrust_n: shift.thrust_n,
            recorded_thrust_n: mean.thrust_n,
        };
        Ok((replay, start, trim))
    }
}

/// What acts on the mean over samples.
fn mean_sample(samples: &[Sample]) -> Sample {
    let count = samples.len() as f64;
    let number = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>() / count;
    let vector = |value: &dyn Fn(&Sample) -> Vector3<f64>| samples.iter().map(value).sum::<Vector3<f64>>() / count;
    Sample {
        controls_rad: std::array::from_fn(|i| number(&|sample| sample.controls_rad[i])),
        recorded: std::array::from_fn(|i| number(&|sample| sample.recorded[i])),
        density_kg_m3: number(&|sample| sample.density_kg_m3),
        wind_ned_m_s: vector(&|sample| sample.wind_ned_m_s),
        thrust_n: number(&|sample| sample.thrust_n),
        thrust_force_n: vector(&|sample| sample.thrust_force_n),
        thrust_moment_n_m: vector(&|sample| sample.thrust_moment_n_m),
        pressure_rise_pa: number(&|sample| sample.pressure_rise_pa),
        ..samples[samples.len() / 2]
    }
}

/// A trim being solved.
struct Search<'a> {
    flight: &'a Flight<'a>,
    mean: &'a Sample,
    condition: &'a SteadyCondition,
    recorded: &'a Start,
    powered: bool,
}

/// What the unknowns stand for.
struct Point {
    alpha_rad: f64,
    beta_rad: f64,
    path_rad: f64,
    sample: Sample,
    start: Start,
}

impl Search<'_> {
    /// State and sample of the unknowns: angle of attack, sideslip, bank, aileron, elevator, and thrust over its mean or the path.
    fn point(&self, values: &Vector6<f64>) -> Point {
        let [alpha, beta, phi, aileron, elevator, last] = <[f64; 6]>::from(*values);
        let path = if self.powered { self.condition.path_rad } else { last };
        let scale = if self.powered { last } else { 1.0 };
        let velocity =
            self.condition.airspeed_m_s * Vector3::new(alpha.cos() * beta.cos(), beta.sin(), alpha.sin() * beta.cos());
        // sin(path) = a sin(theta) - b cos(theta) (Stevens and Lewis 2003, section 3.6).
        let a = alpha.cos() * beta.cos();
        let b = phi.sin() * beta.sin() + phi.cos() * alpha.sin() * beta.cos();
        let climb = path.sin();
        let root = (a * a - climb * climb + b * b).max(0.0).sqrt();
        let theta = (a * b + climb * root).atan2(a * a - climb * climb);
        let turn = self.condition.turn_rate_rad_s;
        let rates = [-theta.sin(), phi.sin() * theta.cos(), phi.cos() * theta.cos()].map(|part| turn * part);
        let mut sample = *self.mean;
        sample.controls_rad[0] = aileron;
        sample.controls_rad[1] = elevator;
        sample.thrust_n *= scale;
        sample.thrust_force_n *= scale;
        sample.thrust_moment_n_m *= scale;
        let start = Start {
            air_velocity_body_m_s: velocity.into(),
            euler_rad: [phi, theta, self.recorded.euler_rad[2]],
            rates_rad_s: rates,
            ..*self.recorded
        };
        Point { alpha_rad: alpha, beta_rad: beta, path_rad: path, sample, start }
    }

    /// Accelerations along and about the body axes.
    fn residual(&self, values: &Vector6<f64>) -> Vector6<f64> {
        let point = self.point(values);
        let start = &point.start;
        let mut state = State::new(Vector3::from(start.position_ned_m), Vector3::zeros(), start.euler_rad);
        let body_from_ned = state.body_from_ned();
        let velocity = Vector3::from(start.air_velocity_body_m_s);
        state.velocity_ned_m_s = body_from_ned.tr_mul(&velocity) + point.sample.wind_ned_m_s;
        state.rates_rad_s = Vector3::from(start.rates_rad_s);
        let (ned_m_s2, angular) = self.flight.accelerations(&state, &point.sample);
        let linear = body_from_ned * ned_m_s2 - state.rates_rad_s.cross(&velocity);
        Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    }

    fn solve(&self) -> Result<Point, ReplayError> {
        let [alpha, beta] = self.condition.flow_rad;
        let [aileron, elevator, _] = self.mean.controls_rad;
        let last = if self.powered { 1.0 } else { self.condition.path_rad };
        let mut values = Vector6::new(alpha, beta, self.condition.bank_rad, aileron, elevator, last);
        let mut left = self.residual(&values);
        for _ in 0..MAX_STEPS {
            if left.amax() < TOLERANCE {
                return Ok(self.point(&values));
            }
            let mut slopes = Matrix6::zeros();
            for column in 0..6 {
                let moved = |step: f64| {
                    let mut moved = values;
                    moved[column] += step;
                    self.residual(&moved)
                };
                slopes.set_column(column, &((moved(DIFFERENCE) - moved(-DIFFERENCE)) / (2.0 * DIFFERENCE)));
            }
            let Some(step) = slopes.lu().solve(&left).filter(|step| step.iter().all(|part| part.is_finite())) else {
                break;
            };
            values -= step * (LONGEST / step.amax()).min(1.0);
            left = self.residual(&values);
        }
        Err(ReplayError::NoTrim { airspeed_m_s: self.condition.airspeed_m_s, residual: left.amax() })
    }
}
