//! How steady a window is before its input.

use doublet_core::quantity::Role;
use doublet_core::statistics::median;
use serde::Serialize;

use super::aero::WindowAero;

/// Controls that begin a manoeuvre.
const CONTROLS: [Role; 3] = [Role::Aileron, Role::Elevator, Role::Rudder];
/// Time at the start of a window over which a control is taken to rest, s.
const REST_S: f64 = 0.5;
/// Least deflection from rest that is an input, rad, and the part of the largest of all controls that another must reach.
const LEAST_INPUT_RAD: f64 = 0.01;
const OTHER_PART: f64 = 0.3;
/// Part of a control's largest deflection at which it has begun to move, and the time before that it began, s.
const BEGUN: f64 = 0.2;
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
    /// Climb, m/s; none without an altitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub climb_m_s: Option<f64>,
}

/// Steadiness of a window before its input, by straight lines; none where it begins with the input or has none.
pub fn steadiness(aero: &WindowAero) -> Option<Steadiness> {
    let data = &aero.data;
    let controls: Vec<&[f64]> =
        CONTROLS.iter().filter_map(|role| data.controls.get(role).map(|column| &**column)).collect();
    let time_s = &*data.time_s;
    let input = begin_of_input(time_s, &controls)?;
    let length_s = time_s[input] - time_s[0];
    if length_s < SHORTEST_S {
        return None;
    }
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

/// The first sample of the input: where the first of the controls that move leaves its rest.
fn begin_of_input(time_s: &[f64], controls: &[&[f64]]) -> Option<usize> {
    let resting = time_s.partition_point(|time| time - time_s[0] < REST_S);
    let from_rest = controls.iter().filter_map(|control| {
        let rest = median(&mut control[..resting].to_vec())?;
        let deflections: Vec<f64> = control.iter().map(|value| (value - rest).abs()).collect();
        let largest = deflections.iter().copied().fold(0.0, f64::max);
        Some((deflections, largest))
    });
    let from_rest: Vec<(Vec<f64>, f64)> = from_rest.collect();
    let largest = from_rest.iter().map(|(_, largest)| *largest).fold(0.0, f64::max);
    let least = LEAST_INPUT_RAD.max(OTHER_PART * largest);
    let moved = from_rest.iter().filter(|(_, largest)| *largest >= least);
    let begun =
        moved.filter_map(|(deflections, largest)| deflections.iter().position(|value| *value > BEGUN * largest));
    let begun_s = time_s[begun.min()?];
    Some(time_s.partition_point(|time| *time < begun_s - BEFORE_S))
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
    use super::*;

    #[test]
    fn input_begins_where_a_control_leaves_its_rest_and_the_slope_is_that_of_the_line() {
        let time_s: Vec<f64> = (0..500).map(|k| 0.02 * f64::from(k)).collect();
        let elevator: Vec<f64> = time_s.iter().map(|t| if (3.0..4.0).contains(t) { 0.05 } else { -0.02 }).collect();
        // It follows the motion and is no input of its own.
        let rudder: Vec<f64> = time_s.iter().map(|t| 0.004 * t.sin()).collect();
        let input = begin_of_input(&time_s, &[&elevator, &rudder]).unwrap();
        assert!((time_s[input] - 2.9).abs() < 0.03, "{}", time_s[input]);
        assert_eq!(begin_of_input(&time_s, &[&rudder]), None);
        let airspeed: Vec<f64> = time_s.iter().map(|t| 60.0 - 0.3 * t).collect();
        assert!((slope(&time_s[..input], &airspeed[..input]) + 0.3).abs() < 1e-9);
    }
}
