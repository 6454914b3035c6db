//! Simulated motion with known errors of the rates.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{ANGLES, RATES, RateErrors, estimate_rate_errors};
use crate::compatibility::motion::Motion;
use crate::quantity::Role;
use crate::series::{Channel, Recording, Series};

const LENGTH_S: f64 = 160.0;
const RATE_HZ: f64 = 50.0;

/// Bank, pitch and heading, rad.
fn attitude(t: f64) -> [f64; 3] {
    let wave = |size: f64, period_s: f64, phase: f64| size * (std::f64::consts::TAU * t / period_s + phase).sin();
    [
        wave(0.5, 9.0, 0.0) + wave(0.1, 2.3, 1.0),
        0.05 + wave(0.12, 7.0, 0.5) + wave(0.03, 1.9, 0.0),
        1.0 + 0.05 * t + wave(0.3, 13.0, 0.3) + wave(0.04, 2.9, 2.0),
    ]
}

fn rates(t: f64) -> Vector3<f64> {
    let h = 1e-4;
    let at = |t: f64| {
        let [phi, theta, psi] = attitude(t);
        Rotation3::from_euler_angles(phi, theta, psi)
    };
    (at(t - h).inverse() * at(t + h)).scaled_axis() / (2.0 * h)
}

/// Even noise of one standard deviation, the same in every run.
fn noise(seed: usize) -> f64 {
    let part = (((seed + 1) as f64 * 12.9898).sin() * 43_758.545_3).fract().abs();
    (part - 0.5) * 12.0_f64.sqrt()
}

/// Rates changed by `shown`, and an attitude late by `late_s` at `attitude_hz`; without any motion if `still`.
fn recording(shown: impl Fn(Vector3<f64>) -> Vector3<f64>, late_s: f64, attitude_hz: f64, still: bool) -> Recording {
    let mut recording = Recording::default();
    let mut add = |role: Role, time_s: Vec<f64>, values: Vec<f64>| {
        let series = Series { time_s: time_s.into(), values: values.into() };
        recording.roles.insert(role, recording.channels.len());
        let (source, name, unit) = ("simulated".to_owned(), role.name().to_owned(), String::new());
        recording.channels.push(Channel { source, name, unit, series });
    };
    let times = |rate_hz: f64| -> Vec<f64> {
        (0_u32..).map(|k| f64::from(k) / rate_hz).take_while(|time_s| *time_s < LENGTH_S).collect()
    };
    for axis in 0..3 {
        let time_s = times(RATE_HZ);
        let value = |(k, t): (usize, &f64)| {
            let rate = if still { Vector3::zeros() } else { shown(rates(*t)) };
            rate[axis] + 0.002 * noise(3 * k + axis)
        };
        let values = time_s.iter().enumerate().map(value).collect();
        add(RATES[axis], time_s, values);
        let time_s = times(attitude_hz);
        let value = |(k, t): (usize, &f64)| {
            let angle = if still { 0.1 } else { attitude(t - late_s)[axis] };
            let angle = angle + 0.002 * noise(100_000 + 3 * k + axis);
            if axis == 2 { angle.rem_euclid(std::f64::consts::TAU) } else { angle }
        };
        let values = time_s.iter().enumerate().map(value).collect();
        add(ANGLES[axis], time_s, values);
    }
    recording
}

fn found(recording: &Recording) -> Option<RateErrors> {
    estimate_rate_errors(recording, &Motion::new(recording, 1.0)?)
}

/// Mounting angles in degrees and scale factors lie within `errors` standard errors, and these are small.
fn assert_found(found: Option<RateErrors>, mounting_deg: [f64; 3], scale: [f64; 3]) {
    let Some(found) = found else { panic!("nothing found") };
    for axis in 0..3 {
        let (angle, error) = (found.mounting_rad[axis], found.mounting_errors_rad[axis]);
        let off = (angle - mounting_deg[axis].to_radians()).abs();
        assert!(off < (4.0 * error).max(0.002) && error < 0.006, "mounting {axis}: {found:?}");
        let (factor, error) = (found.scale[axis], found.scale_errors[axis]);
        let off = (factor - scale[axis]).abs();
        assert!(off < (4.0 * error).max(0.004) && error < 0.006, "scale {axis}: {found:?}");
    }
}

#[test]
fn mounting_and_scale_are_recovered_within_their_errors() {
    let e = Vector3::new(3.0_f64.to_radians(), 4.0_f64.to_radians(), -2.0_f64.to_radians());
    let Some(turn) = (Matrix3::identity() + e.cross_matrix()).try_inverse() else { panic!("singular") };
    let turned = |rate: Vector3<f64>| turn * rate;
    assert_found(found(&recording(turned, 0.0, 50.0, false)), [3.0, 4.0, -2.0], [0.0; 3]);
    assert_found(found(&recording(turned, 0.1, 5.0, false)), [3.0, 4.0, -2.0], [0.0; 3]);
    let scaled = |rate: Vector3<f64>| rate.component_mul(&Vector3::new(1.05, 1.0, 0.93));
    assert_found(found(&recording(scaled, 0.0, 20.0, false)), [0.0; 3], [0.05, 0.0, -0.07]);
}

#[test]
fn consistent_rates_show_nothing_also_with_a_late_attitude() {
    for late_s in [0.0, -0.08, 0.16] {
        let found = found(&recording(|rate| rate, late_s, 50.0, false));
        assert_found(found, [0.0; 3], [0.0; 3]);
        assert!(found.is_some_and(|found| found.delay_s.iter().all(|delay_s| (delay_s - late_s).abs() < 0.01)));
    }
    assert_eq!(found(&recording(|rate| rate, 0.5, 50.0, false)), None, "a filter may look the same");
}

#[test]
fn quiet_empty_short_and_broken_recordings_show_nothing_significant() {
    if let Some(found) = found(&recording(|rate| rate, 0.0, 50.0, true)) {
        let pairs = found.mounting_rad.iter().zip(&found.mounting_errors_rad);
        assert!(
            pairs.chain(found.scale.iter().zip(&found.scale_errors)).all(|(value, error)| value.abs() < 5.0 * error)
        );
    }
    assert_eq!(found(&Recording::default()), None);
    for kept in [0, 1, 2, 300] {
        for broken in [false, true] {
            let mut short = recording(|rate| rate, 0.0, 50.0, false);
            let motion = Motion::new(&short, 1.0);
            for channel in &mut short.channels {
                let value = |value: &f64| if broken { f64::NAN } else { *value };
                channel.series.time_s = channel.series.time_s[..kept].into();
                channel.series.values = channel.series.values[..kept].iter().map(value).collect();
            }
            assert_eq!(motion.and_then(|motion| estimate_rate_errors(&short, &motion)), None);
        }
    }
}
