//! Loops, rolls and turns recorded without an airspeed: nothing contradicts, and a mistake is still named.

use std::collections::BTreeMap;

use doublet_core::compatibility::check;
use doublet_core::quantity::Role::{self, *};
use nalgebra::{Rotation3, Vector3};

use super::{GRAVITY_M_S2, RATE_HZ, WIND_M_S, mistakes, recording, sample_path, scaled};

/// Airspeed, m/s.
const SPEED_M_S: f64 = 30.0;
/// Time to start and end a rotation, s.
const BLEND_S: f64 = 0.5;
/// Body rates, rad/s, and time, s: level, loop, roll to the right, half loop and half roll back, roll into a turn and out.
const FIGURE: [([f64; 3], f64); 12] = [
    ([0.0, 0.0, 0.0], 4.0),
    ([0.0, 0.8, 0.0], std::f64::consts::TAU / 0.8),
    ([0.0, 0.0, 0.0], 4.0),
    ([2.0, 0.0, 0.0], std::f64::consts::TAU / 2.0),
    ([0.0, 0.0, 0.0], 4.0),
    ([0.0, 0.8, 0.0], std::f64::consts::PI / 0.8),
    ([2.0, 0.0, 0.0], std::f64::consts::PI / 2.0),
    ([0.0, 0.0, 0.0], 4.0),
    ([0.6, 0.0, 0.0], 1.0),
    ([0.0, 0.1, 0.15], 8.0),
    ([-0.6, 0.0, 0.0], 1.0),
    ([0.0, 0.0, 0.0], 3.0),
];
/// Repetitions of the figure.
const FIGURES: usize = 3;

/// Body rates at a time: each part blends in and out over [`BLEND_S`] and turns by the angle it would at once.
fn rates(t: f64) -> Vector3<f64> {
    let mut start = 0.0;
    let mut rate = Vector3::zeros();
    for (body, length) in std::iter::repeat_n(FIGURE, FIGURES).flatten() {
        let ramp = |t: f64| (t / BLEND_S).clamp(0.0, 1.0);
        rate += Vector3::from(body) * (ramp(t - start) - ramp(t - start - length));
        start += length;
    }
    rate
}

/// Channels of a recorder without air data.
fn columns() -> BTreeMap<Role, Vec<f64>> {
    let mut columns: BTreeMap<Role, Vec<f64>> = BTreeMap::new();
    let length_s = FIGURES as f64 * FIGURE.iter().map(|(_, length)| length).sum::<f64>();
    let (fine, per_sample) = (1.0 / (20.0 * RATE_HZ), 20);
    let mut turned = Rotation3::identity();
    let mut position = Vector3::new(0.0, 0.0, -300.0);
    for step in 0..(length_s / fine) as usize {
        let rate = rates(step as f64 * fine);
        let air = Vector3::new(SPEED_M_S, 0.0, 0.03 * SPEED_M_S);
        let ground = turned * air + Vector3::from(WIND_M_S);
        if step % per_sample == 0 {
            let force = rate.cross(&air) - turned.inverse() * Vector3::new(0.0, 0.0, GRAVITY_M_S2);
            let (phi, theta, psi) = turned.euler_angles();
            for (role, value) in sample_path(rate, force, [phi, theta, psi], ground, position) {
                columns.entry(role).or_default().push(value);
            }
        }
        position += fine * ground;
        turned *= Rotation3::from_scaled_axis(rates((step as f64 + 0.5) * fine) * fine);
    }
    columns
}

#[test]
fn loops_and_rolls_without_an_airspeed_contradict_nothing() {
    let columns = columns();
    let bank = &columns[&BankAngle];
    assert!(bank.iter().any(|phi| *phi > 3.1) && bank.iter().any(|phi| *phi < -3.1), "inverted flight");
    assert_eq!(mistakes(&check(&recording(&columns, 1.0))), Vec::<String>::new());
}

#[test]
fn a_mistake_in_aerobatics_is_named() {
    for (role, factor, expected) in [
        (PitchRate, -1.0, "q: sign reversed"),
        (BankAngle, 180.0 / std::f64::consts::PI, "phi: degrees, not radians"),
        (VelocityDown, -1.0, "v_down: sign reversed"),
    ] {
        let mut columns = columns();
        scaled(&mut columns, role, factor);
        assert_eq!(mistakes(&check(&recording(&columns, 1.0))), [expected]);
    }
}
