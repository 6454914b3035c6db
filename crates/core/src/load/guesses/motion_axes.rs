//! Axes of a sensor whose specific force is positive upwards: forward, left and up, or the reaction to gravity along all three.

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::guesses::motion::{MOST_PAIRS, ask, fit_line, ground_speed, is_free, lag_of, set_sign, turn};
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{ManualChannel, ManualChannelMap};
use crate::load::names::tokens::tokens;
use crate::quantity::Role;

/// Lags over which the specific force along x is compared with what speed and pitch make of it, s.
const LAGS_S: [f64; 3] = [1.0, 2.0, 4.0];
/// Time over which speeds are averaged, s.
const SMOOTHED_S: f64 = 0.3;
/// Correlations, either way, from which that comparison says the sign, and from which it is not asked for.
const SAYS_SIGN: f64 = 0.6;
const IS_SURE: f64 = 0.8;
/// What the means say where the correlation says nothing: a sign that is asked for. The motion makes a mean of this size at least, m/s², and
/// the force is this alike.
const BY_MEAN: f64 = 0.7;
const LEAST_MEAN_M_S2: f64 = 0.3;
const ALIKE: f64 = 0.5;
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

/// A specific force against what the motion makes of it, `change of speed + other`, m/s²: their correlation; where that says nothing and the
/// mean of the motion is large, [`BY_MEAN`] with the sign of the ratio of the means, if they are alike.
fn compare_force(force: &Trace, speed: &[f64], other: &[f64]) -> Option<f64> {
    let time_s = &force.time_s;
    let count = time_s.len();
    let speed = smoothed(speed, lag_of(time_s, SMOOTHED_S).unwrap_or(0) / 2);
    let over = |lag_s: f64| {
        let lag = lag_of(time_s, lag_s)?;
        let mean = |values: &[f64], k: usize| {
            let inside = &values[k..=k + lag];
            (inside.iter().sum::<f64>() - 0.5 * (inside[0] + inside[lag])) / lag as f64
        };
        let pair = |k: usize| {
            let change = (speed[k + lag] - speed[k]) / (time_s[k + lag] - time_s[k]);
            (change + mean(other, k), mean(&force.values, k))
        };
        let pairs: Vec<(f64, f64)> = (0..count - lag).step_by((count / MOST_PAIRS).max(1)).map(pair).collect();
        fit_line(&pairs).map(|(_, correlation)| correlation)
    };
    let best = LAGS_S.into_iter().filter_map(over).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count.max(1) as f64;
    let (of_motion, of_force) = (mean(other), mean(&force.values));
    let is_alike = (of_force.abs() / of_motion.abs() - 1.0).abs() < ALIKE;
    let says_mean = best.abs() <= SAYS_SIGN && of_motion.abs() > LEAST_MEAN_M_S2 && is_alike;
    Some(if says_mean { BY_MEAN * (of_force / of_motion).signum() } else { best })
}

/// Means of values over `half` samples to either side: noise of a speed over a lag is as large as its change.
fn smoothed(values: &[f64], half: usize) -> Vec<f64> {
    let mean = |k: usize| {
        let near = &values[k.saturating_sub(half)..(k + half + 1).min(values.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// Agreement of the specific force along x with the change of speed and the part of gravity, `u' + q w + g sin(theta)`.
fn compare_forward(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let pitch = Trace::for_role(map, Role::PitchAngle, probes)?;
    let at = |role: Role| Trace::for_role(map, role, probes).and_then(|trace| trace.at(&pitch.time_s));
    let force = at(Role::SpecificForceX)?;
    let speed = airspeed(map, probes, &pitch.time_s)?;
    let (flow, rate) = (at(Role::AngleOfAttack), at(Role::PitchRate));
    let count = pitch.time_s.len();
    let forward: Vec<f64> = (0..count).map(|k| speed.values[k] * value(&flow, k).cos()).collect();
    let other = |k: usize| {
        let down = speed.values[k] * value(&flow, k).sin();
        value(&rate, k) * down + STANDARD_GRAVITY_M_S2 * pitch.values[k].sin()
    };
    compare_force(&force, &forward, &(0..count).map(other).collect::<Vec<_>>())
}

/// Agreement of the specific force to the right with the change of sideslip, the turn and the part of gravity, `v' + r u - g sin(phi)`.
fn compare_side(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let bank = Trace::for_role(map, Role::BankAngle, probes)?;
    let at = |role: Role| Trace::for_role(map, role, probes).and_then(|trace| trace.at(&bank.time_s));
    let (force, rate) = (at(Role::SpecificForceY)?, at(Role::YawRate)?);
    let speed = airspeed(map, probes, &bank.time_s)?;
    let (slip, roll, flow) = (at(Role::Sideslip)?, at(Role::RollRate), at(Role::AngleOfAttack));
    let count = bank.time_s.len();
    let side: Vec<f64> = (0..count).map(|k| speed.values[k] * slip.values[k].sin()).collect();
    let other = |k: usize| {
        let (forward, down) = (speed.values[k], speed.values[k] * value(&flow, k).sin());
        rate.values[k] * forward - value(&roll, k) * down - STANDARD_GRAVITY_M_S2 * bank.values[k].sin()
    };
    compare_force(&force, &side, &(0..count).map(other).collect::<Vec<_>>())
}

/// Airspeed, or speed over ground where there is none, m/s.
fn airspeed(map: &ManualChannelMap, probes: &[Probe], time_s: &[f64]) -> Option<Trace> {
    let at = |role: Role| Trace::for_role(map, role, probes).and_then(|trace| trace.at(time_s));
    let of_air = Role::AIRSPEEDS.into_iter().find_map(at);
    of_air.or_else(|| ground_speed(map, probes, false)?.at(time_s))
}

/// Value of a trace at a sample; zero without one.
fn value(trace: &Option<Trace>, k: usize) -> f64 {
    trace.as_ref().map_or(0.0, |trace| trace.values[k])
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

/// Turns the specific forces along x and to the right with the one along z, unless the motion says that they are not turned. What the motion
/// does not say is asked for; a force to the right that it leaves open goes with the one along x.
fn turn_reaction(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::SpecificForceX, Role::SpecificForceY];
    let says = |compared: Option<f64>| compared.filter(|agreement| agreement.abs() > SAYS_SIGN);
    let forward = says(compare_forward(map, probes));
    let side = says(compare_side(map, probes));
    for (role, agreement) in roles.into_iter().zip([forward, side.or(forward)]) {
        if agreement.is_none_or(|agreement| agreement < 0.0) {
            turn(map, role);
        }
    }
    let is_sure = |agreement: Option<f64>| agreement.is_some_and(|agreement| agreement.abs() > IS_SURE);
    // All three turned is one of two usual axes: the force to the right need not be asked for.
    let is_reaction = forward.is_some_and(|agreement| agreement < -IS_SURE);
    let is_open = [!is_sure(forward), !is_sure(side) && !is_reaction];
    let open: Vec<Role> =
        roles.into_iter().zip(is_open).filter_map(|(role, is_open)| is_open.then_some(role)).collect();
    if !open.is_empty() {
        ask(map, &open);
    }
}
