//! Roles of a made flight: a turn with changing bank, pitch, airspeed and flow angles.

use super::{Found, Series, search};
use crate::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2};
use crate::quantity::Role;

/// Time, bank, pitch, wrapped heading, three rates, airspeed, angle of attack, sideslip, height, static and dynamic pressure, in SI.
fn flight() -> Vec<Vec<f64>> {
    const STEP_S: f64 = 0.02;
    let (mut psi, mut height) = (0.4_f64, 1500.0);
    let mut columns = vec![Vec::new(); 13];
    for k in 0..3000_u32 {
        let t = STEP_S * f64::from(k);
        let (phi, theta) = (0.6 + 0.2 * (0.9 * t).sin(), 0.1 + 0.1 * (0.6 * t + 1.0).sin());
        let (alpha, beta) = (0.08 + 0.04 * (0.8 * t).sin(), 0.03 * (1.1 * t + 0.5).sin());
        let speed = 60.0 + 5.0 * (0.2 * t).sin();
        let (roll, pitch) = (0.18 * (0.9 * t).cos(), 0.06 * (0.6 * t + 1.0).cos());
        let yaw = STANDARD_GRAVITY_M_S2 * phi.tan() / speed;
        let ((sp, cp), (st, ct)) = (phi.sin_cos(), theta.sin_cos());
        let ((sa, ca), (sb, cb)) = (alpha.sin_cos(), beta.sin_cos());
        let climb = speed * (ca * cb * st - (sb * sp + sa * cb * cp) * ct);
        let (p, q, r) = (roll - yaw * st, pitch * cp + yaw * sp * ct, yaw * cp * ct - pitch * sp);
        let pressure = Atmosphere::STANDARD.pressure_pa(height).unwrap();
        let dynamic = 0.5 * Atmosphere::STANDARD.density_kg_m3(height).unwrap() * speed * speed;
        let row = [t, phi, theta, psi.sin().atan2(psi.cos()), p, q, r, speed, alpha, beta, height, pressure, dynamic];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        (psi, height) = (psi + STEP_S * yaw, height + STEP_S * climb);
    }
    columns
}

/// What is found of some columns, each in a unit with how many of it make one of SI.
fn find(columns: &[Vec<f64>], scales: &[(usize, f64)]) -> Vec<Found> {
    let values: Vec<Vec<f64>> =
        scales.iter().map(|(column, scale)| columns[*column].iter().map(|value| scale * value).collect()).collect();
    let series: Vec<Series<'_>> = values.iter().map(|values| Series { time_s: &columns[0], values }).collect();
    search(&series)
}

const KNOTS: f64 = 1.943_844;
const FEET: f64 = 3.280_84;
const DEGREES: f64 = 57.295_779_513;
const MOTION: [(usize, f64); 6] = [(5, 1.0), (3, 1.0), (1, 1.0), (6, 1.0), (2, 1.0), (4, 1.0)];

#[track_caller]
fn is_found(found: &[Found], role: Role, column: usize, unit: &str) {
    let found = found.iter().find(|found| found.role == role);
    let seen = found.map(|found| (found.column, found.unit, found.turned));
    assert_eq!(seen, Some((column, Some(unit), false)), "{}", role.name());
}

#[test]
fn airspeed_is_found_by_the_dynamic_pressure_and_alpha_by_the_climb() {
    let scales = [&MOTION[..], &[(11, 0.01), (7, KNOTS), (12, 1.0), (8, DEGREES), (10, FEET)]].concat();
    let found = find(&flight(), &scales);
    is_found(&found, Role::PitchAngle, 4, "rad");
    is_found(&found, Role::StaticPressure, 6, "hPa");
    is_found(&found, Role::Altitude, 10, "ft");
    is_found(&found, Role::TrueAirspeed, 7, "kt");
    is_found(&found, Role::AngleOfAttack, 9, "deg");
}

#[test]
fn height_airspeed_and_flow_angles_are_found_together_by_the_climb_angle() {
    let scales = [&MOTION[..], &[(9, DEGREES), (7, FEET), (8, DEGREES), (10, FEET)]].concat();
    let found = find(&flight(), &scales);
    is_found(&found, Role::Altitude, 9, "ft");
    is_found(&found, Role::TrueAirspeed, 7, "ft/s");
    is_found(&found, Role::AngleOfAttack, 8, "deg");
    is_found(&found, Role::Sideslip, 6, "deg");
}
