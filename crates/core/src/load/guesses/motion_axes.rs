//! Axes of a sensor whose specific force is positive upwards: forward, left and up, or the reaction to gravity along all three.

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::guesses::motion::{MOST_PAIRS, ask, fit_line, is_free, lag_of, set_sign, turn};
use crate::load::guesses::motion_units::ground_speed;
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{ManualChannel, ManualChannelMap};
use crate::load::names::tokens::tokens;
use crate::quantity::Role;

/// Lags over which the specific force along x is compared with what speed and pitch make of it, s.
const LAGS_S: [f64; 3] = [1.0, 2.0, 4.0];
/// Correlations, either way, from which that comparison says the sign, and from which it is not asked for.
const SAYS_SIGN: f64 = 0.6;
const IS_SURE: f64 = 0.8;
/// Words of the names of accelerometers and gyroscopes.
const FORCES: [&str; 8] = ["acc", "accel", "accelerometer", "acceleration", "linear", "imu", "accelx", "a"];
const GYROS: [&str; 8] = ["gyro", "gyr", "gyroscope", "g", "angular", "velocity", "omega", "w"];
const AXES: [char; 3] = ['x', 'y', 'z'];

/// Words of a name without its axis, where it has one: `acc` of `acc_y`, `accY` and `Y_Acc`.
fn without_axis(row: &ManualChannel) -> Option<Vec<String>> {
    let mut all = tokens(&row.from.channel);
    if all.len() > 1 && all.first().is_some_and(|first| first.len() == 1 && first.ends_with(AXES)) {
        all.remove(0);
        return Some(all);
    }
    let last = all.pop().filter(|last| last.ends_with(AXES))?;
    let stem = last.trim_end_matches(AXES);
    all.extend((!stem.is_empty()).then(|| stem.to_owned()));
    Some(all)
}

/// Whether a channel is named as one axis of a sensor of the words `sensors`: `acc_y`, `gyrZ`, `Y_Accel`.
fn is_axis_of(row: &ManualChannel, sensors: &[&str]) -> bool {
    without_axis(row).is_some_and(|all| all.iter().any(|token| sensors.contains(&token.trim_end_matches(AXES))))
}

/// Whether the three specific forces are one sensor's: of one source and unit, with names that differ by the axis alone.
fn is_triad(map: &ManualChannelMap) -> bool {
    let forces = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ].map(|role| map.row(role));
    let [Some(x), Some(y), Some(z)] = forces else { return false };
    let is_like = |other: &ManualChannel| {
        other.from.source == z.from.source
            && other.unit == z.unit
            && is_free(other)
            && without_axis(other).is_some()
            && without_axis(other) == without_axis(z)
    };
    is_like(x) && is_like(y)
}

/// Correlation of the specific force along x with the change of speed and the part of gravity, `u' + q w + g sin(theta)`.
fn compare_forward(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let pitch = Trace::for_role(map, Role::PitchAngle, probes)?;
    let at = |role: Role| Trace::for_role(map, role, probes).and_then(|trace| trace.at(&pitch.time_s));
    let force = at(Role::SpecificForceX)?;
    let of_air = [Role::TrueAirspeed, Role::CalibratedAirspeed].into_iter().find_map(at);
    let speed = of_air.or_else(|| ground_speed(map, probes, false)?.at(&pitch.time_s))?;
    let (flow, rate) = (at(Role::AngleOfAttack), at(Role::PitchRate));
    let value = |trace: &Option<Trace>, k: usize| trace.as_ref().map_or(0.0, |trace| trace.values[k]);
    let count = pitch.time_s.len();
    let forward: Vec<f64> = (0..count).map(|k| speed.values[k] * value(&flow, k).cos()).collect();
    let other = |k: usize| {
        let down = speed.values[k] * value(&flow, k).sin();
        value(&rate, k) * down + STANDARD_GRAVITY_M_S2 * pitch.values[k].sin()
    };
    let other: Vec<f64> = (0..count).map(other).collect();
    let over = |lag_s: f64| {
        let lag = lag_of(&pitch.time_s, lag_s)?;
        let mean = |values: &[f64], k: usize| {
            let inside = &values[k..=k + lag];
            (inside.iter().sum::<f64>() - 0.5 * (inside[0] + inside[lag])) / lag as f64
        };
        let pair = |k: usize| {
            let change = (forward[k + lag] - forward[k]) / (pitch.time_s[k + lag] - pitch.time_s[k]);
            (change + mean(&other, k), mean(&force.values, k))
        };
        let pairs: Vec<(f64, f64)> = (0..count - lag).step_by((count / MOST_PAIRS).max(1)).map(pair).collect();
        fit_line(&pairs).map(|(_, correlation)| correlation)
    };
    LAGS_S.into_iter().filter_map(over).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// A specific force that is positive upwards. Where the rates beside it are turned by the attitude, the axes are forward, left and up; where
/// they are not, and the three forces are one sensor's, it gives the reaction to gravity: all three are turned. `rates` are the signs that the
/// attitude says of the rates, `is_known` whether its own are known. What neither rates nor motion decide is asked for.
pub(crate) fn turn_left_up(map: &mut ManualChannelMap, probes: &[Probe], rates: [f64; 3], is_known: [bool; 3]) {
    let forces = [Role::SpecificForceY, Role::SpecificForceZ];
    let [Some(side), Some(down)] = forces.map(|role| map.row(role).cloned()) else { return };
    if !down.turned || !is_free(&down) || ![&side, &down].into_iter().all(|row| is_axis_of(row, &FORCES)) {
        return;
    }
    let roles = [Role::PitchRate, Role::YawRate];
    let gyros = roles.map(|role| map.row(role).cloned());
    let is_gyro = gyros.iter().all(|row| row.as_ref().is_some_and(|row| is_free(row) && is_axis_of(row, &GYROS)));
    let (pitch, yaw) = (rates[1], rates[2]);
    let is_left = match is_gyro {
        true => pitch < 0.0 && yaw <= 0.0 || yaw < 0.0 && pitch <= 0.0,
        false => pitch < 0.0 && yaw < 0.0 && is_triad(map),
    };
    let is_turned = gyros.iter().flatten().any(|row| row.turned);
    if is_left {
        for (role, sign) in roles.into_iter().zip([pitch, yaw]) {
            if sign == 0.0 {
                turn(map, role);
            }
        }
        set_sign(map, Role::SpecificForceY, true);
        if !is_gyro && is_known[1..] == [false; 2] {
            ask(map, &[Role::SpecificForceY]);
        }
    } else if pitch > 0.0 && yaw > 0.0 && !is_turned && is_known[1..] != [false; 2] && is_triad(map) {
        turn_reaction(map, probes);
    } else if !is_gyro {
        ask(map, &[Role::SpecificForceX, Role::SpecificForceY]);
    } else if pitch == 0.0 && yaw == 0.0 {
        for role in [Role::SpecificForceY, Role::PitchRate, Role::YawRate] {
            set_sign(map, role, true);
        }
        // ROS defines its axes: forward, left, up (REP 103).
        if !down.from.channel.contains("linear_acceleration") {
            ask(map, &[Role::SpecificForceY, Role::PitchRate, Role::YawRate]);
        }
    } else {
        let pairs = [[Role::PitchRate, Role::PitchAngle], [Role::YawRate, Role::HeadingAngle]];
        for (pair, is_known) in pairs.iter().zip(&is_known[1..]) {
            if !is_known {
                ask(map, pair);
            }
        }
        if is_known[1..] == [false; 2] {
            ask(map, &[Role::SpecificForceY]);
        }
    }
}

/// Turns the specific forces along x and to the right with the one along z, unless the motion says that the one along x is not turned.
fn turn_reaction(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::SpecificForceX, Role::SpecificForceY];
    let forward = compare_forward(map, probes).filter(|correlation| correlation.abs() > SAYS_SIGN);
    if forward.is_none_or(|correlation| correlation < 0.0) {
        roles.into_iter().for_each(|role| turn(map, role));
    }
    match forward {
        Some(correlation) if correlation < -IS_SURE => {}
        Some(correlation) if correlation > IS_SURE => ask(map, &roles[1..]),
        _ => ask(map, &roles),
    }
}
