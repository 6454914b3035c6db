//! The model flown from its own trim, with the constants of the identification.

use std::ops::Range;

use doublet_core::model::Derivatives;
use doublet_core::quantity::Dimension;
use doublet_core::replay::{SteadyCondition, SteadyTrim};
use nalgebra::{Rotation3, Vector3};

use super::units::shown;
use crate::graph::StageResult;
use crate::notation::significant;
use crate::session::Surface;
use crate::stage::{WindowAero, WindowFlight};

/// Difference of pitch, angle of attack and elevator, rad, and of thrust, per cent, from which the trim of the model differs from the flight: the
/// tolerances of the longitudinal trim (14 CFR Part 60, Table A2A, 2.c.5).
const APART_RAD: f64 = std::f64::consts::PI / 180.0;
const APART_PERCENT: f64 = 5.0;

/// Shortest steady flight before the input that gives a trim, s.
pub(super) const LEAST_STEADY_S: f64 = 0.5;

/// A window made ready to be flown from the trim of the model.
pub(super) struct TrimmedFlight {
    /// The window; its motion is the recorded one.
    pub flight: WindowFlight,
    /// Trim, the recorded condition and the steady flight it is from.
    pub start: TrimmedStart,
}

/// A trim of the model beside the steady flight it stands for.
#[derive(Clone, Debug)]
pub(super) struct TrimmedStart {
    trim: SteadyTrim,
    condition: SteadyCondition,
    pitch_rad: f64,
    span_s: [f64; 2],
}

/// Trims the model in the steady flight between two times of the recording.
pub(super) fn trimmed(
    model: &Derivatives,
    flight: WindowFlight,
    aero: &WindowAero,
    span_s: [f64; 2],
) -> StageResult<TrimmedFlight> {
    let time_s = &*aero.data.time_s;
    let [from_s, to_s] = span_s;
    let steady = time_s.partition_point(|&time| time < from_s)..time_s.partition_point(|&time| time <= to_s);
    let (condition, pitch_rad) = condition(&flight, aero, steady.clone());
    let (replay, start, trim) = flight.replay.from_trim(model, steady, &condition, &flight.start)?;
    let start = (WindowFlight { replay, start, ..flight }, TrimmedStart { trim, condition, pitch_rad, span_s });
    Ok(TrimmedFlight { flight: start.0, start: start.1 })
}

/// Mean condition of the recorded motion, and its mean pitch angle.
fn condition(flight: &WindowFlight, aero: &WindowAero, steady: Range<usize>) -> (SteadyCondition, f64) {
    let (motion, data) = (&flight.motion, &aero.data);
    let count = steady.len().max(1) as f64;
    let mean = |value: &dyn Fn(usize) -> f64| steady.clone().map(value).sum::<f64>() / count;
    let [phi, theta, psi] = &motion.euler_rad;
    let climb = |k: usize| {
        let velocity = Vector3::from(motion.air_velocity_body_m_s.each_ref().map(|column| column[k]));
        let ned = Rotation3::from_euler_angles(phi[k], theta[k], psi[k]) * velocity;
        (-ned.z / velocity.norm()).clamp(-1.0, 1.0).asin()
    };
    let [_, q, r] = &data.rates_rad_s;
    let turn = |k: usize| (q[k] * phi[k].sin() + r[k] * phi[k].cos()) / theta[k].cos();
    let condition = SteadyCondition {
        airspeed_m_s: mean(&|k| data.airspeed_m_s[k]),
        path_rad: mean(&climb),
        turn_rate_rad_s: mean(&turn),
        flow_rad: [mean(&|k| data.alpha_rad[k]), mean(&|k| data.beta_rad[k])],
        bank_rad: mean(&|k| phi[k]),
    };
    (condition, mean(&|k| theta[k]))
}

impl TrimmedStart {
    /// Thrust of the trim less that of the flight, per cent; none where the trim does not hold the path, or without thrust.
    fn thrust_difference_percent(&self) -> Option<f64> {
        let Self { trim, condition, .. } = self;
        let is_held = trim.path_rad == condition.path_rad && trim.recorded_thrust_n != 0.0;
        is_held.then(|| 100.0 * (trim.thrust_n / trim.recorded_thrust_n - 1.0))
    }

    /// How far the trim of the model is from the flight, beyond what the rule allows a trim; none where it is near.
    pub fn difference(&self) -> Option<String> {
        let Self { trim, condition, pitch_rad, .. } = self;
        let angles = [
            ("pitch", trim.attitude_rad[1] - pitch_rad),
            ("angle of attack", trim.alpha_rad - condition.flow_rad[0]),
            ("elevator", trim.controls_rad[1] - trim.recorded_controls_rad[1]),
        ];
        let apart = angles.into_iter().filter(|(_, less)| less.abs() > APART_RAD);
        let angle = |value: f64| shown(value, Dimension::Angle);
        let angles: Vec<String> = apart.map(|(name, less)| format!("{name} {}", angle(less))).collect();
        let angles = (!angles.is_empty()).then(|| format!("{} (limit {})", angles.join(", "), angle(APART_RAD)));
        let thrust = self.thrust_difference_percent().filter(|percent| percent.abs() > APART_PERCENT);
        let thrust = thrust.map(|percent| format!("thrust {} % (limit {APART_PERCENT} %)", significant(percent, 2)));
        let all: Vec<String> = angles.into_iter().chain(thrust).collect();
        (!all.is_empty()).then(|| format!("trim off by {}", all.join(", ")))
    }

    /// What the page says of the start.
    pub fn facts(&self) -> Vec<(String, String)> {
        let Self { trim, condition, pitch_rad, span_s: [from_s, to_s] } = self;
        let angle = |value: f64| shown(value, Dimension::Angle);
        let flown = format!(
            "mean of the flight from {from_s:.2} to {to_s:.2} s: airspeed {}, flight path {}, turn rate {}",
            shown(condition.airspeed_m_s, Dimension::Speed),
            angle(condition.path_rad),
            shown(condition.turn_rate_rad_s, Dimension::AngularRate),
        );
        let surfaces = [(Surface::Aileron, 0), (Surface::Elevator, 1)].map(|(surface, index)| {
            let less = trim.controls_rad[index] - trim.recorded_controls_rad[index];
            format!("{} {}", surface.name(), angle(less))
        });
        let [bank, pitch] = trim.attitude_rad;
        let mut differences = vec![
            format!("pitch {}", angle(pitch - pitch_rad)),
            format!("angle of attack {}", angle(trim.alpha_rad - condition.flow_rad[0])),
            format!("sideslip {}", angle(trim.beta_rad - condition.flow_rad[1])),
            format!("bank {}", angle(bank - condition.bank_rad)),
        ];
        differences.extend(surfaces);
        differences.push(match self.thrust_difference_percent() {
            Some(percent) => format!("thrust {} %", significant(percent, 2)),
            None => format!("flight path {}", angle(trim.path_rad - condition.path_rad)),
        });
        vec![("Trimmed at".to_owned(), flown), ("Trim of the model less the flight".to_owned(), differences.join(", "))]
    }
}
