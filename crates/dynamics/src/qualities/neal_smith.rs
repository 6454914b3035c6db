//! The criterion of Neal and Smith: a pilot closes the loop of pitch attitude at the bandwidth of the task.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Complex;
use serde::Deserialize;

use crate::frequency::BodeCurve;

/// A pilot's task in the loop of pitch attitude.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PilotTask {
    /// Frequency at which the closed loop lags by 90 deg, rad/s.
    pub bandwidth_rad_s: f64,
    /// Delay of the pilot, s.
    pub delay_s: f64,
    /// Least gain of the closed loop below the bandwidth, dB.
    pub droop_db: f64,
}

/// What the pilot of a [`PilotTask`] has to do, and what comes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NealSmith {
    /// Phase of the pilot's lead (positive) or lag at the bandwidth, rad.
    pub compensation_rad: f64,
    /// Gain of the pilot at low frequency, stick over attitude in the reciprocal of the curve's unit.
    pub gain: f64,
    /// Greatest gain of the closed loop above its droop, dB.
    pub resonance_db: f64,
}

/// Halvings of the range of the compensation, which leave less than 1e-6 rad.
const BISECTIONS: usize = 22;
/// Step before lead or lag becomes infinite, rad.
const ROOM_RAD: f64 = 1e-3;

/// Lead or lag and gain of the pilot `Y = K exp(-tau s) (T s + 1)`, or `K exp(-tau s) / (T s + 1)`, by which the loop `theta/theta_c = Y G /
/// (1 + Y G)` lags by 90 deg at the bandwidth and droops to no less than the task's limit below it, and the resonance that follows.
///
/// A closed loop `-j m` asks for `|Y G| = cos(psi + pi)` with the phase `psi = -pi + atan(1/m)` of the open loop: each compensation has one
/// gain. The droop falls as lead grows; bisection finds where it is the task's. `attitude` is `G = theta / stick` (gain in dB, phase in rad,
/// positive stick raises the nose). None where the curve does not reach the bandwidth or its resonance, or no compensation below 90 deg
/// does. (T. P. Neal, R. E. Smith, AFFDL-TR-70-74, 1970. Their pilot may use less compensation than the droop asks for where the resonance is
/// small; ours always meets the droop.)
pub fn neal_smith(attitude: &BodeCurve, task: &PilotTask) -> Option<NealSmith> {
    let open = OpenLoop::new(attitude, task)?;
    let target = task.droop_db;
    let most_rad = (10f64.powf(-target / 20.0)).atan() - PI;
    let low = (-FRAC_PI_2 + ROOM_RAD).max(ROOM_RAD - PI - open.phase_rad);
    let high = (FRAC_PI_2 - ROOM_RAD).min(most_rad - open.phase_rad);
    let droop = |compensation: f64| open.close(compensation).map(|closed| closed.droop_db - target);
    // The end of the range has the droop at the bandwidth itself, where rounding may leave it a trifle above.
    if low >= high || droop(low)? < 0.0 || droop(high)? > 1e-6 {
        return None;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if droop(middle)? > 0.0 { low = middle } else { high = middle }
    }
    let compensation_rad = 0.5 * (low + high);
    let closed = open.close(compensation_rad)?;
    let is_inside = closed.resonance_place + 1 < open.points.len();
    is_inside.then_some(NealSmith { compensation_rad, gain: closed.gain, resonance_db: closed.resonance_db })
}

/// The open loop without compensation and gain.
struct OpenLoop {
    /// Frequencies over the bandwidth, with the response and the pilot's delay.
    points: Vec<(f64, Complex<f64>)>,
    /// Number of the point at the bandwidth.
    place: usize,
    gain: f64,
    phase_rad: f64,
}

/// A closed loop.
struct Closed {
    gain: f64,
    droop_db: f64,
    resonance_db: f64,
    resonance_place: usize,
}

impl OpenLoop {
    fn new(attitude: &BodeCurve, task: &PilotTask) -> Option<Self> {
        let bandwidth_rad_s = task.bandwidth_rad_s;
        let lagged = |omega: f64, phase: f64| phase - omega * task.delay_s;
        let (gain_db, phase) = attitude.at(bandwidth_rad_s)?;
        let (gain, phase_rad) = (10f64.powf(gain_db / 20.0), lagged(bandwidth_rad_s, phase));
        let place = attitude.omega_rad_s.partition_point(|&omega| omega < bandwidth_rad_s);
        let of_curve = (0..attitude.omega_rad_s.len()).map(|index| {
            let (omega, gain_db) = (attitude.omega_rad_s[index], attitude.gain_db[index]);
            let phase = lagged(omega, attitude.phase_rad[index]);
            (omega / bandwidth_rad_s, Complex::from_polar(10f64.powf(gain_db / 20.0), phase))
        });
        let mut points: Vec<_> = of_curve.collect();
        points.insert(place, (1.0, Complex::from_polar(gain, phase_rad)));
        (place > 0).then_some(Self { points, place, gain, phase_rad })
    }

    /// The loop with the pilot of this compensation, rad; none where the loop does not lag by 90 deg with it.
    fn close(&self, compensation_rad: f64) -> Option<Closed> {
        let slope = compensation_rad.abs().tan();
        let filter = |share: f64| {
            let lead = Complex::new(1.0, slope * share);
            if compensation_rad >= 0.0 { lead } else { lead.inv() }
        };
        let above = self.phase_rad + compensation_rad + PI;
        if !(above > 0.0 && above < FRAC_PI_2) {
            return None;
        }
        let gain = above.cos() / (self.gain * filter(1.0).norm());
        let decibel = |&(share, response): &(f64, Complex<f64>)| {
            let open = response * filter(share) * gain;
            20.0 * (open / (open + 1.0)).norm().log10()
        };
        let least = self.points[..=self.place].iter().map(decibel).enumerate();
        let (bottom, droop_db) = least.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let beyond = self.points.iter().map(decibel).enumerate().skip(bottom);
        let (resonance_place, resonance_db) = beyond.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Closed { gain, droop_db, resonance_db, resonance_place })
    }
}
