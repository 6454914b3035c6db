//! The velocity through the air by that over the ground: climb by height, airspeed and wind by the circle that ground velocities make, flow
//! angles and specific forces by the velocity in axes of the body (Stevens and Lewis, Aircraft Control and Simulation, section 1.5).

use super::air::{self, FORCES, SPEEDS, average_by, taken};
use super::air_data::average;
use super::assignment::Assignment;
use super::earth::{CLIMBS, LENGTHS};
use super::fit::{fit, line};
use super::kinematics::{ANGLES, Taken};
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;

/// Heights that are flown at, m.
const HEIGHTS_M: std::ops::Range<f64> = -500.0..25_000.0;
/// Least squared correlation of a climb with the change of a height, and largest ratio of its slope to that of its units, either way.
const PAIR_R2: f64 = 0.98;
const PAIR_RATIO: f64 = 1.02;
/// Slopes of a climb on speed times sin(theta).
const PAIR_LEVEL: f64 = 0.05;
const CLIMB_R2: f64 = 0.4;
const CLIMB_SLOPE: std::ops::Range<f64> = 0.6..1.6;
/// Squared correlation with the heading from which a velocity is horizontal, unless the climb explains it better.
const HORIZONTAL_R2: f64 = 0.9;
/// Least squared correlation of the circle, and the largest ratio of its scale to that of a unit, either way.
const CIRCLE_R2: f64 = 0.97;
const CIRCLE_RATIO: f64 = 1.04;
/// Largest wind as a part of the airspeed, and least deviation of the heading, rad.
const WIND: f64 = 0.7;
const TURN: f64 = 0.35;
/// Least squared correlation of a flow angle, largest ratio of its slope, largest difference of levels, rad, and largest angle, rad.
const FLOW_R2: f64 = 0.8;
const FLOW_RATIO: f64 = 1.25;
const LEVEL: f64 = 0.07;
const LARGEST_FLOW: f64 = 1.3;
/// The same where noise and gusts hide much of a flow angle, with its closer level and largest value, rad.
const NEAR_R2: f64 = 0.35;
const NEAR_RATIO: f64 = 1.6;
const NEAR_LEVEL: f64 = 0.01;
const NEAR_LARGEST: f64 = 0.5;
/// Least squared correlation of a specific force, largest ratio of its slope, either way, and largest difference of levels, m/s^2.
const FORCE_R2: f64 = 0.85;
const FORCE_RATIO: f64 = 1.15;
const FORCE_LEVEL: f64 = 0.6;

/// Finds climb, airspeed and flow angles.
pub fn complete(whole: &mut Assignment<'_>) {
    find_vertical(whole);
    find_circle(whole);
    find_vertical(whole);
    find_flow(whole);
}

/// Speed, m/s: of flight, or over the ground in its place.
fn speed_of(whole: &Assignment<'_>) -> Option<Vec<f64>> {
    let over_ground = || whole.ground.as_ref().map(|[north, east]| whole.each(|k| north[k].hypot(east[k])));
    whole.airspeed.clone().or_else(over_ground)
}

/// Climb, m/s: as it is recorded, or the change of height.
fn climb_of(whole: &Assignment<'_>) -> Option<Vec<f64>> {
    whole.climb.clone().or_else(|| whole.height.as_ref().map(|[_, change]| change.clone()))
}

/// The pair of a height and a climb that is its change, in units with which it is that of the speed and the pitch angle.
fn find_vertical(whole: &mut Assignment<'_>) {
    if whole.height.is_some() || whole.climb.is_some() {
        return;
    }
    let Some(speed) = speed_of(whole) else { return };
    let expected = whole.each(|k| speed[k] * whole.theta[k].sin());
    let heading = whole.psi.as_ref().map(|psi| [whole.each(|k| psi[k].cos()), whole.each(|k| psi[k].sin())]);
    let middle = average(&speed);
    let level = whole.each(|k| whole.phi[k].cos());
    let free = whole.free();
    let mut best: Option<(Taken, Taken)> = None;
    for &j in &free {
        let climb = &whole.column(j).mean;
        let with_heading = heading.as_ref().and_then(|[cos, sin]| fit(climb, &[cos, sin])).map_or(0.0, |fit| fit.r2);
        let least = if with_heading > HORIZONTAL_R2 { with_heading } else { CLIMB_R2 };
        for &i in free.iter().filter(|i| **i != j) {
            let column = whole.column(i);
            let Some((slope, r2)) = line(&column.slope, climb).filter(|(_, r2)| *r2 > PAIR_R2) else { continue };
            for (unit, size) in LENGTHS {
                let inside = column.range.iter().all(|height| HEIGHTS_M.contains(&(height / size)));
                let units = CLIMBS.map(|(name, scale)| (name, size / scale));
                let Some(found) = taken(j, slope, &units, PAIR_RATIO, r2).filter(|_| inside) else { continue };
                let Some((_, scale)) = CLIMBS.into_iter().find(|(name, _)| *name == found.unit) else { continue };
                let change: Vec<f64> = column.slope.iter().map(|slope| slope / size).collect();
                let Some(agreeing) = fit(&change, &[&expected, &level]) else { continue };
                let own = agreeing.coefficients[0];
                let is_slow = average_by(&change, f64::abs) < 0.5 * middle;
                let apart = average(&column.slope) - slope * average(climb);
                let is_level = apart.abs() < PAIR_LEVEL * average_by(&column.slope, |slope| slope * slope).sqrt();
                let is_better = best.is_none_or(|(height, pair)| {
                    height.r2 < agreeing.r2 || (height.column == i && height.unit == unit && pair.r2 < r2)
                });
                if CLIMB_SLOPE.contains(&own.abs()) && is_slow && is_level && agreeing.r2 > least && is_better {
                    // Heights are up, velocities down.
                    let height = Taken { column: i, unit, factor: own.signum() / size, r2: agreeing.r2 };
                    let sign = -own.signum() * slope.signum();
                    best = Some((height, Taken { column: j, factor: sign / scale, ..found }));
                }
            }
        }
    }
    let Some((height, descent)) = best else { return };
    whole.height = Some([whole.mean_of(height), whole.slope_of(height)]);
    whole.climb = Some(whole.mean_of(descent).into_iter().map(|down| -down).collect());
    if height.factor > 0.0 {
        whole.take(Role::Altitude, height, "its rate of change is the recorded climb rate");
    } else {
        whole.take(
            Role::PositionDown,
            Taken { factor: -height.factor, ..height },
            "its rate of change is the descent rate",
        );
    }
    whole.take(Role::VelocityDown, descent, "the rate of change of altitude");
}

/// Deviation of the heading, rad.
fn turning(whole: &Assignment<'_>) -> f64 {
    let Some(psi) = whole.psi.as_ref() else { return 0.0 };
    let (sin, cos) = (average_by(psi, f64::sin), average_by(psi, f64::cos));
    (-2.0 * sin.hypot(cos).max(1e-9).ln()).max(0.0).sqrt()
}

/// Airspeed and wind: `|v_ground|^2 = V^2 + 2 v_ground wind - |wind|^2`, the circle that ground velocities make about the wind.
fn find_circle(whole: &mut Assignment<'_>) {
    let Some([north, east]) = whole.ground.clone() else { return };
    let climb = climb_of(whole).unwrap_or_else(|| whole.each(|_| 0.0));
    let square = whole.each(|k| north[k].powi(2) + east[k].powi(2) + climb[k].powi(2));
    let of_wind = |of: [f64; 2]| [0.5 * of[0], 0.5 * of[1]];
    if let Some(speed) = whole.airspeed.clone() {
        let rest = whole.each(|k| square[k] - speed[k] * speed[k]);
        let found = fit(&rest, &[&north, &east]).filter(|_| turning(whole) > TURN);
        let wind = found.map(|found| of_wind([found.coefficients[0], found.coefficients[1]]));
        whole.wind = wind.filter(|wind| wind[0].hypot(wind[1]) < WIND * average(&speed));
        return;
    }
    if turning(whole) < TURN {
        return;
    }
    let mut best: Option<(Taken, [f64; 2])> = None;
    for i in whole.free().into_iter().filter(|i| air::can_be_speed(whole, *i)) {
        let own: Vec<f64> = whole.column(i).mean.iter().map(|speed| speed * speed).collect();
        let Some(found) = fit(&square, &[&own, &north, &east]).filter(|found| found.r2 > CIRCLE_R2) else { continue };
        let [size, along, across, ..] = found.coefficients;
        let wind = of_wind([along, across]);
        let speed = taken(i, size.max(0.0).sqrt().recip(), &SPEEDS, CIRCLE_RATIO, found.r2);
        let speed = speed.filter(|speed| {
            let middle = speed.factor * average(&whole.column(i).mean);
            wind[0].hypot(wind[1]) < WIND * middle
        });
        if let Some(speed) = speed.filter(|_| best.is_none_or(|(best, _)| best.r2 < found.r2)) {
            best = Some((speed, wind));
        }
    }
    if let Some((speed, wind)) = best {
        air::take_speed(whole, speed, "the circle of ground velocities about the wind");
        whole.wind = Some(wind);
    }
}

/// Angle of attack without sideslip by climb, airspeed and attitude: `sin(gamma) = cos(alpha) sin(theta) - sin(alpha) cos(phi) cos(theta)`, rad.
fn alpha_by_climb(whole: &Assignment<'_>) -> Option<Vec<f64>> {
    let (speed, climb) = (whole.airspeed.as_ref()?, climb_of(whole)?);
    Some(whole.each(|k| {
        let (along, across) = (whole.theta[k].sin(), whole.phi[k].cos() * whole.theta[k].cos());
        let part = climb[k] / speed[k] / along.hypot(across);
        part.clamp(-1.0, 1.0).acos() - across.atan2(along)
    }))
}

/// Flow angles of the velocity over the ground less the wind, rad.
fn flow_angles(whole: &Assignment<'_>) -> Option<[Vec<f64>; 2]> {
    let ([north, east], climb) = (whole.ground.as_ref()?, climb_of(whole)?);
    let (psi, wind) = (whole.psi.as_ref()?, whole.wind?);
    let mut angles = [Vec::with_capacity(psi.len()), Vec::with_capacity(psi.len())];
    for k in 0..psi.len() {
        let [u, v, w] = to_body(whole, psi[k], k, [north[k] - wind[0], east[k] - wind[1], -climb[k]]);
        angles[0].push(w.atan2(u));
        angles[1].push((v / (u * u + v * v + w * w).sqrt()).asin());
    }
    Some(angles)
}

/// A vector north, east, down in axes of the body.
fn to_body(whole: &Assignment<'_>, psi: f64, k: usize, [north, east, down]: [f64; 3]) -> [f64; 3] {
    let ((sp, cp), (st, ct)) = (whole.phi[k].sin_cos(), whole.theta[k].sin_cos());
    let (ss, cs) = psi.sin_cos();
    let (ahead, aside) = (north * cs + east * ss, east * cs - north * ss);
    let (forward, below) = (ahead * ct - down * st, ahead * st + down * ct);
    [forward, aside * cp + below * sp, below * cp - aside * sp]
}

/// A channel that records a flow angle.
fn record(whole: &Assignment<'_>, i: usize, wanted: &[f64]) -> Option<Taken> {
    let column = whole.column(i);
    let (slope, r2) = line(&column.mean, wanted)?;
    let found = taken(i, slope / r2.sqrt(), &ANGLES, NEAR_RATIO, r2).filter(|_| slope > 0.0)?;
    let apart = found.factor * average(&column.mean) - average(wanted);
    let is_angle = found.factor * column.largest < LARGEST_FLOW && column.turn.is_none();
    let is_scaled = taken(i, slope / r2.sqrt(), &ANGLES, FLOW_RATIO, r2).is_some();
    let is_near = r2 > NEAR_R2 && apart.abs() < NEAR_LEVEL && found.factor * column.largest < NEAR_LARGEST;
    let is_clear = r2 > FLOW_R2 && apart.abs() < LEVEL && is_scaled;
    ((is_clear || is_near) && is_angle).then_some(found)
}

/// Angle of attack and sideslip.
fn find_flow(whole: &mut Assignment<'_>) {
    let Some([alpha, beta]) = flow_angles(whole) else {
        if let Some(alpha) = alpha_by_climb(whole).filter(|_| whole.alpha.is_none()) {
            let fits = |whole: &Assignment<'_>, i: usize| record(whole, i, &alpha);
            let relation = "the pitch angle minus the climb angle";
            if let Some(found) = whole.take_nearest(Role::AngleOfAttack, relation, fits) {
                whole.alpha = Some([whole.mean_of(found), whole.slope_of(found)]);
            }
        }
        return;
    };
    let relation = "the airspeed components in body axes";
    if whole.alpha.is_none()
        && let Some(found) = whole.take_nearest(Role::AngleOfAttack, relation, |whole, i| record(whole, i, &alpha))
    {
        whole.alpha = Some([whole.mean_of(found), whole.slope_of(found)]);
    }
    if whole.beta.is_none()
        && let Some(found) = whole.take_nearest(Role::Sideslip, relation, |whole, i| record(whole, i, &beta))
    {
        whole.beta = Some([whole.mean_of(found), whole.slope_of(found)]);
    }
}

/// Specific forces by the change of the velocity over the ground: `f = C (v_dot - g)`.
pub fn complete_forces(whole: &mut Assignment<'_>) {
    let change = |role: Role| {
        let found = whole.found.iter().find(|found| found.role == role)?;
        let (_, scale) = CLIMBS.into_iter().find(|(name, _)| Some(*name) == found.unit)?;
        let factor = if found.turned { -1.0 } else { 1.0 } / scale;
        Some(whole.column(found.column).slope.iter().map(|slope| factor * slope).collect::<Vec<f64>>())
    };
    let all = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown].map(change);
    let ([Some(north), Some(east), Some(down)], Some(psi)) = (all, whole.psi.clone()) else { return };
    let made: Vec<[f64; 3]> = (0..psi.len())
        .map(|k| to_body(whole, psi[k], k, [north[k], east[k], down[k] - STANDARD_GRAVITY_M_S2]))
        .collect();
    let roles = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    for (axis, role) in roles.into_iter().enumerate() {
        if whole.found.iter().any(|found| found.role == role) {
            continue;
        }
        let wanted: Vec<f64> = made.iter().map(|force| force[axis]).collect();
        let fits = |whole: &Assignment<'_>, i: usize| {
            let column = whole.column(i);
            let (slope, r2) = line(&column.mean, &wanted)?;
            let found = taken(i, slope / r2.sqrt(), &FORCES, FORCE_RATIO, r2)?;
            let apart = found.factor * average(&column.mean) - average(&wanted);
            (r2 > FORCE_R2 && apart.abs() < FORCE_LEVEL).then_some(found)
        };
        whole.take_nearest(role, "the rate of change of velocity minus gravity", fits);
    }
}
