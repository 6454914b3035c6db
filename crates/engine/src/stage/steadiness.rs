//! How steady a window is before its input.

use serde::Serialize;

use super::aero::WindowAero;
use super::movement::{Movement, movements};

/// Least deflection that is an input, rad, and the part of the largest of all surfaces that another must reach.
const LEAST_INPUT_RAD: f64 = 0.01;
const OTHER_PART: f64 = 0.3;
/// Time before the departure of a deflection at which its input is taken to begin, s.
const BEFORE_S: f64 = 0.1;
/// Shortest time that tells a slope, s.
const SHORTEST_S: f64 = 0.5;

/// What a window shows before its input: all zero but the length in steady straight flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Steadiness {
    /// Time before the input, s.
    pub length_s: f64,
    /// Slope of the true airspeed, m/s².
    pub airspeed_slope_m_s2: f64,
    /// Slope of the velocity along the z body axis, m/s².
    pub w_slope_m_s2: f64,
    /// Climb, m/s; absent without an altitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub climb_m_s: Option<f64>,
}

/// Steadiness of a window before its input, by straight lines; none where it begins with the input or has none.
pub fn measure_steadiness(aero: &WindowAero) -> Option<Steadiness> {
    let data = &aero.data;
    let time_s = &*data.time_s;
    let (length_s, input) = part_before_input(aero)?;
    let sideways = data.alpha_rad.iter().zip(&*data.beta_rad);
    let w_m_s: Vec<f64> = data
        .airspeed_m_s
        .iter()
        .zip(sideways)
        .map(|(airspeed, (alpha, beta))| airspeed * beta.cos() * alpha.sin())
        .collect();
    let slope_of = |values: &[f64]| slope(&time_s[..input], &values[..input]);
    Some(Steadiness {
        length_s,
        airspeed_slope_m_s2: slope_of(&data.airspeed_m_s),
        w_slope_m_s2: slope_of(&w_m_s),
        climb_m_s: data.altitude_m.as_ref().map(|altitude_m| slope_of(altitude_m)),
    })
}

/// Length, s, and number of samples of a window before its input; none where it begins with the input or has none.
pub(super) fn part_before_input(aero: &WindowAero) -> Option<(f64, usize)> {
    let time_s = &*aero.data.time_s;
    let length_s = time_before_input(&movements(aero).collect::<Vec<_>>())?;
    (length_s >= SHORTEST_S).then(|| (length_s, time_s.partition_point(|time| time - time_s[0] < length_s)))
}

/// Time from the start to the input, s: where the first of the surfaces that move leaves its rest.
fn time_before_input(movements: &[Movement]) -> Option<f64> {
    let largest_rad = movements.iter().map(|moved| moved.largest_rad.abs()).fold(0.0, f64::max);
    let least_rad = LEAST_INPUT_RAD.max(OTHER_PART * largest_rad);
    let inputs = movements.iter().filter(|moved| moved.largest_rad.abs() >= least_rad);
    inputs.map(|moved| moved.before_s).min_by(f64::total_cmp).map(|before_s| before_s - BEFORE_S)
}

/// Slope of the straight line through values over time.
fn slope(time_s: &[f64], values: &[f64]) -> f64 {
    let count = time_s.len() as f64;
    let (time, value) = (time_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let sums = time_s
        .iter()
        .zip(values)
        .fold((0.0, 0.0), |(with, square), (t, v)| (with + (t - time) * (v - value), square + (t - time).powi(2)));
    sums.0 / sums.1
}

#[cfg(test)]
mod tests {
    use super::super::movement::deflection_movement;
    use super::*;
    use crate::session::Surface;

    #[test]
    fn input_begins_where_a_control_leaves_its_rest_and_the_slope_is_that_of_the_line() {
        let time_s: Vec<f64> = (0..500).map(|k| 0.02 * f64::from(k)).collect();
        let elevator: Vec<f64> = time_s.iter().map(|t| if (3.0..4.0).contains(t) { 0.05 } else { -0.02 }).collect();
        // It follows the motion and is no input of its own.
        let rudder: Vec<f64> = time_s.iter().map(|t| 0.004 * t.sin()).collect();
        let elevator = deflection_movement(Surface::Elevator, &time_s, &elevator).unwrap();
        let rudder = deflection_movement(Surface::Rudder, &time_s, &rudder).unwrap();
        let before_s = time_before_input(&[elevator, rudder]).unwrap();
        assert!((before_s - 2.9).abs() < 0.03, "{before_s}");
        assert_eq!(time_before_input(&[rudder]), None);
        let airspeed: Vec<f64> = time_s.iter().map(|t| 60.0 - 0.3 * t).collect();
        assert!((slope(&time_s, &airspeed) + 0.3).abs() < 1e-9);
    }
}
