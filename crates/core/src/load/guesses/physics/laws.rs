//! Specific forces by the laws of aerodynamics: over the square of the airspeed the normal force is linear in the angle of attack, the side force
//! in the sideslip, and the axial force follows the angle of attack (Etkin and Reid, Dynamics of Flight, section 2.2).

use super::air::{FORCES, average_by, can_be_flow, side_drive, taken};
use super::air_data::average;
use super::assignment::Assignment;
use super::fit::{Fit, fit, line};
use super::kinematics::{ANGLES, Taken};
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;

const G: f64 = STANDARD_GRAVITY_M_S2;
/// Mean normal specific force of flight, g.
const LEVEL_G: std::ops::Range<f64> = 0.75..1.5;
/// Change of the normal force over its mean with the angle of attack, per rad: one over the angle above that of no lift.
const LIFT: std::ops::Range<f64> = 2.0..30.0;
/// Change of the side force over the weight with the sideslip, and of the axial force with the angle of attack, per rad.
const SIDE: std::ops::Range<f64> = 0.15..8.0;
const AXIAL: std::ops::Range<f64> = 0.1..8.0;
/// Largest mean of the side force and of the axial force, g.
const MEAN_SIDE: f64 = 0.2;
const MEAN_AXIAL: f64 = 0.4;
/// Largest difference of the mean axial force from that of attitude and acceleration, g.
const AXIAL_LEVEL: f64 = 0.06;
/// Least squared correlations: of the normal force with a known angle of attack, with one found by it, of the side force, of the axial force.
const NORMAL_R2: f64 = 0.8;
const PAIR_R2: f64 = 0.9;
const SIDE_R2: f64 = 0.8;
const SIDE_R2_ALONE: f64 = 0.5;
const SIDE_PAIR_R2: f64 = 0.85;
const AXIAL_R2: f64 = 0.85;
/// Least squared correlation of a normal force with weight and pitch rate.
const TURNING_R2: f64 = 0.15;
/// Least squared correlation of the change of a flow angle with what makes it, and the largest ratio of its slope, either way.
const CHANGE_R2: f64 = 0.3;
const CHANGE_RATIO: f64 = 1.6;
const CHANGE_R2_KNOWN: f64 = 0.1;

/// Part of the mean airspeed that flight has at least.
const FLYING: f64 = 0.6;
/// Least squared correlation of a specific force beside the normal force of its vector, and the largest, g.
const BESIDE_R2: f64 = 0.25;
const LARGEST_G: f64 = 3.0;

/// Finds the specific forces and flow angles that are still open.
pub fn complete(whole: &mut Assignment<'_>) {
    let Some(speed) = whole.airspeed.clone() else { return };
    // What stands or taxis has no coefficients.
    let least = (FLYING * average(&speed)).max(4.0);
    let square: Vec<f64> = speed.iter().map(|speed| if *speed > least { speed * speed } else { f64::NAN }).collect();
    find_normal(whole, &speed, &square);
    find_side(whole, &speed, &square);
    find_behind(whole, &speed);
    find_axial(whole, &square);
    find_beside(whole, &speed, &square);
}

/// The normal force behind a side force of its vector, where the angle of attack hardly changes.
fn find_behind(whole: &mut Assignment<'_>, speed: &[f64]) {
    let Some(side) = whole.found.iter().find(|found| found.role == Role::SpecificForceY) else { return };
    let (third, unit) = (side.column + 1, side.unit);
    if has(whole, Role::SpecificForceZ) || !whole.free().contains(&third) {
        return;
    }
    let Some(normal) = can_be_normal(whole, third).filter(|normal| Some(normal.unit) == unit) else { return };
    let turning = whole.each(|k| -speed[k] * whole.q[k] - G * whole.theta[k].cos() * whole.phi[k].cos());
    let found = line(&whole.mean_of(normal), &turning).filter(|(slope, _)| *slope > 0.0);
    if let Some((_, r2)) = found.filter(|(_, r2)| *r2 > TURNING_R2) {
        whole.take(Role::SpecificForceZ, Taken { r2, ..normal }, "column after the side force, 1 g on average");
    }
}

/// Axial and side force beside a normal force that is the third of a vector, where noise hides much of what makes them.
fn find_beside(whole: &mut Assignment<'_>, speed: &[f64], square: &[f64]) {
    let Some(normal) = whole.found.iter().find(|found| found.role == Role::SpecificForceZ) else { return };
    let (third, turned) = (normal.column, normal.turned);
    let Some((unit, scale)) = shared_unit(whole).filter(|_| third >= 2) else { return };
    let free = whole.free();
    let accelerating = whole.acceleration.clone().unwrap_or_else(|| whole.each(|_| 0.0));
    let along = whole.each(|k| accelerating[k] + G * whole.theta[k].sin());
    let sideways = whole.each(|k| -side_drive(whole, k));
    let beta = whole.beta.as_ref().map(|[beta, _]| times(beta, square));
    let alpha = whole.alpha.as_ref().map(|[alpha, _]| times(alpha, square));
    let is_level = |whole: &Assignment<'_>, i: usize, most: f64| {
        let column = whole.column(i);
        (average(&column.mean) / scale / G).abs() < most && column.largest / scale < LARGEST_G * G
    };
    let follows = |whole: &Assignment<'_>, i: usize, with: &[f64], sign: f64| {
        let found = line(&whole.column(i).mean, with)?;
        (found.1 > BESIDE_R2).then_some(Taken { column: i, unit, factor: sign * found.0.signum() / scale, r2: found.1 })
    };
    let best = |all: [Option<Taken>; 2]| all.into_iter().flatten().max_by(|a, b| a.r2.total_cmp(&b.r2));
    let axial = third - 2;
    if !has(whole, Role::SpecificForceX) && free.contains(&axial) && is_level(whole, axial, MEAN_AXIAL) {
        let by_lift = alpha.as_deref().and_then(|alpha| follows(whole, axial, alpha, 1.0));
        let found = best([follows(whole, axial, &along, 1.0), by_lift]);
        if let Some(found) = found.filter(|found| found.factor > 0.0) {
            whole.take(
                Role::SpecificForceX,
                found,
                "column beside the normal force, consistent with acceleration and attitude",
            );
        }
    }
    let side = third - 1;
    if !has(whole, Role::SpecificForceY) && free.contains(&side) && is_level(whole, side, MEAN_SIDE) {
        let by_slip = beta.as_deref().and_then(|beta| follows(whole, side, beta, -1.0));
        let by_turn = follows(whole, side, &sideways, 1.0).filter(|_| average(speed) > 4.0);
        // Axes of one vector are turned about x together.
        let found = best([by_slip, by_turn]).filter(|found| (found.factor < 0.0) == turned);
        if let Some(found) = found {
            whole.take(
                Role::SpecificForceY,
                found,
                "column beside the normal force, consistent with sideslip and turn",
            );
        }
    }
}

/// Products of two series.
fn times(values: &[f64], with: &[f64]) -> Vec<f64> {
    values.iter().zip(with).map(|(a, b)| a * b).collect()
}

fn has(whole: &Assignment<'_>, role: Role) -> bool {
    whole.found.iter().any(|found| found.role == role)
}

/// A channel over the square of the airspeed.
fn over(values: &[f64], square: &[f64]) -> Vec<f64> {
    values.iter().zip(square).map(|(value, square)| value / square).collect()
}

/// A channel that can be the normal force: its unit, and its sign by which it points up.
pub fn can_be_normal(whole: &Assignment<'_>, i: usize) -> Option<Taken> {
    let level = average(&whole.column(i).mean);
    let (unit, scale) = FORCES.into_iter().find(|(_, scale)| LEVEL_G.contains(&(level.abs() / (scale * G))))?;
    Some(Taken { column: i, unit, factor: -level.signum() / scale, r2: 0.0 })
}

/// Normal force with the angle of attack.
fn find_normal(whole: &mut Assignment<'_>, speed: &[f64], square: &[f64]) {
    if has(whole, Role::SpecificForceZ) {
        if whole.alpha.is_none() {
            find_alpha(whole, speed, square);
        }
        return;
    }
    let free = whole.free();
    let middle = average(square);
    let mut best: Option<(Taken, Option<Taken>)> = None;
    for &i in &free {
        let Some(force) = can_be_normal(whole, i) else { continue };
        let coefficient = over(&whole.mean_of(force), square);
        let lift = |slope: f64| -slope * middle / G;
        if let Some([alpha, _]) = whole.alpha.as_ref() {
            let Some((slope, r2)) = line(&coefficient, alpha) else { continue };
            if r2 > NORMAL_R2 && LIFT.contains(&lift(slope)) && best.is_none_or(|(best, _)| best.r2 < r2) {
                best = Some((Taken { r2, ..force }, None));
            }
            continue;
        }
        let drive = whole.each(|k| {
            let gravity = G * whole.theta[k].cos() * whole.phi[k].cos();
            whole.q[k] + (force.factor * whole.column(i).mean[k] + gravity) / speed[k].max(4.0)
        });
        // Much of the normal force is the weight and the turn of the flight path, whatever the angle of attack.
        let turning = whole.each(|k| -speed[k] * whole.q[k] - G * whole.theta[k].cos() * whole.phi[k].cos());
        let turns = line(&whole.mean_of(force), &turning).is_some_and(|(slope, r2)| slope > 0.0 && r2 > TURNING_R2);
        for &j in free.iter().filter(|j| turns && **j != i && can_be_flow(whole, **j)) {
            let column = whole.column(j);
            let Some((slope, r2)) = line(&coefficient, &column.mean).filter(|(_, r2)| *r2 > PAIR_R2) else { continue };
            if best.is_some_and(|(best, _)| best.r2 >= r2) {
                continue;
            }
            let Some((change, agreeing)) = line(&column.slope, &drive).filter(|(_, r2)| *r2 > CHANGE_R2) else {
                continue;
            };
            let Some(angle) = taken(j, change / agreeing.sqrt(), &ANGLES, CHANGE_RATIO, r2) else { continue };
            let is_lift = LIFT.contains(&lift(slope / angle.factor));
            if is_lift && angle.factor.abs() * column.largest < 1.3 {
                best = Some((Taken { r2, ..force }, Some(angle)));
            }
        }
    }
    let Some((force, alpha)) = best else { return };
    if let Some(alpha) = alpha {
        whole.alpha = Some([whole.mean_of(alpha), whole.slope_of(alpha)]);
        whole.take(Role::AngleOfAttack, alpha, "the normal force divided by airspeed squared");
    }
    whole.take(Role::SpecificForceZ, force, "divided by airspeed squared, linear in angle of attack");
}

/// The angle of attack of a normal force that is known.
fn find_alpha(whole: &mut Assignment<'_>, speed: &[f64], square: &[f64]) {
    let Some(found) = whole.found.iter().find(|found| found.role == Role::SpecificForceZ) else { return };
    let Some((_, scale)) = FORCES.into_iter().find(|(unit, _)| Some(*unit) == found.unit) else { return };
    let sign = if found.turned { -1.0 } else { 1.0 };
    let (column, offset) = (found.column, found.offset);
    let force = whole.each(|k| sign * (whole.column(column).mean[k] + offset) / scale);
    let coefficient = over(&force, square);
    let middle = average(square);
    let drive =
        whole.each(|k| whole.q[k] + (force[k] + G * whole.theta[k].cos() * whole.phi[k].cos()) / speed[k].max(4.0));
    let fits = |whole: &Assignment<'_>, j: usize| {
        let angle = whole.column(j);
        let (slope, r2) = line(&coefficient, &angle.mean).filter(|(_, r2)| *r2 > NORMAL_R2)?;
        let (change, _) = line(&angle.slope, &drive).filter(|(_, r2)| *r2 > CHANGE_R2_KNOWN)?;
        let lift = slope.abs() * middle / G;
        let (unit, size) = ANGLES.into_iter().find(|(_, size)| LIFT.contains(&(lift * size)))?;
        let is_angle = can_be_flow(whole, j) && angle.largest / size < 1.3 && slope * change < 0.0;
        is_angle.then_some(Taken { column: j, unit, factor: -slope.signum() / size, r2 })
    };
    if let Some(alpha) = whole.take_nearest(Role::AngleOfAttack, "the normal force divided by airspeed squared", fits) {
        whole.alpha = Some([whole.mean_of(alpha), whole.slope_of(alpha)]);
    }
}

/// Unit of the normal force, which the other specific forces share.
fn shared_unit(whole: &Assignment<'_>) -> Option<(&'static str, f64)> {
    let found = whole.found.iter().find(|found| found.role == Role::SpecificForceZ)?;
    FORCES.into_iter().find(|(unit, _)| Some(*unit) == found.unit)
}

/// Side force with the sideslip.
fn find_side(whole: &mut Assignment<'_>, speed: &[f64], square: &[f64]) {
    let drive = whole.each(|k| side_drive(whole, k) / speed[k].max(4.0));
    if whole.beta.is_none() {
        let fits = |whole: &Assignment<'_>, i: usize| {
            let column = whole.column(i);
            let (slope, r2) = line(&column.slope, &drive).filter(|(_, r2)| *r2 > SIDE_R2_PLAIN)?;
            let found = taken(i, slope / r2.sqrt(), &ANGLES, PLAIN_RATIO, r2)?;
            let size = average_by(&whole.mean_of(found), |angle| angle.powi(2)).sqrt();
            let is_angle = can_be_flow(whole, i) && found.factor.abs() * column.largest < 1.3 && size > LEAST_SIDESLIP;
            is_angle.then_some(found)
        };
        if let Some(beta) =
            whole.take_nearest(Role::Sideslip, "its rate of change follows from yaw rate and bank", fits)
        {
            whole.beta = Some([whole.mean_of(beta), whole.slope_of(beta)]);
        }
    }
    if has(whole, Role::SpecificForceY) {
        return;
    }
    if whole.beta.is_none() {
        find_side_pair(whole, &drive, speed, square);
    }
    let Some([beta, _]) = whole.beta.clone() else { return };
    let rates = [&whole.p, &whole.r].map(|rate| rate.iter().zip(speed).map(|(rate, speed)| rate / speed).collect());
    let [roll, yaw]: [Vec<f64>; 2] = rates;
    let fits = |whole: &Assignment<'_>, i: usize| {
        let side = side_force(whole, i, &beta, square)?;
        let coefficient = over(&whole.column(i).mean, square);
        let found = fit(&coefficient, &[&beta, &roll, &yaw])?;
        (side.r2 > SIDE_R2_ALONE && found.r2 > SIDE_R2).then_some(Taken { r2: found.r2, ..side })
    };
    whole.take_nearest(Role::SpecificForceY, "divided by airspeed squared, linear in sideslip", fits);
}

/// Unit of a side force: that of the normal force, or of the channel behind it that can be one.
fn side_unit(whole: &Assignment<'_>, i: usize) -> Option<(&'static str, f64)> {
    let behind = || {
        let normal = (i + 1 < whole.windows.columns.len()).then(|| can_be_normal(whole, i + 1)).flatten()?;
        FORCES.into_iter().find(|(unit, _)| *unit == normal.unit)
    };
    shared_unit(whole).or_else(behind)
}

/// A channel that opposes a sideslip as a side force does.
fn side_force(whole: &Assignment<'_>, i: usize, beta: &[f64], square: &[f64]) -> Option<Taken> {
    let column = whole.column(i);
    let (unit, scale) = side_unit(whole, i)?;
    let (slope, r2) = line(&over(&column.mean, square), beta)?;
    let size = slope.abs() * average(square) / (scale * G);
    let is_side = average(&column.mean).abs() < MEAN_SIDE * G * scale && SIDE.contains(&size) && slope < 0.0;
    is_side.then_some(Taken { column: i, unit, factor: -slope.signum() / scale, r2 })
}

/// Side force and sideslip together.
fn find_side_pair(whole: &mut Assignment<'_>, drive: &[f64], speed: &[f64], square: &[f64]) {
    let free = whole.free();
    let mut best: Option<(Taken, Taken)> = None;
    for &j in free.iter().filter(|j| can_be_flow(whole, **j)) {
        let column = whole.column(j);
        for &i in free.iter().filter(|i| **i != j) {
            let Some((_, scale)) = side_unit(whole, i) else { continue };
            let alike = line(&over(&whole.column(i).mean, square), &column.mean);
            if alike.is_none_or(|(_, r2)| r2 < SIDE_PAIR_R2 || best.is_some_and(|(side, _)| side.r2 >= r2)) {
                continue;
            }
            let change = whole.each(|k| drive[k] + whole.column(i).mean[k] / scale / speed[k].max(4.0));
            let Some((slope, r2)) = line(&column.slope, &change).filter(|(_, r2)| *r2 > CHANGE_R2) else { continue };
            let Some(angle) = taken(j, slope / r2.sqrt(), &ANGLES, CHANGE_RATIO, r2) else { continue };
            let is_angle = angle.factor.abs() * column.largest < 1.3;
            let side = side_force(whole, i, &whole.mean_of(angle), square).filter(|_| is_angle);
            if let Some(side) = side {
                best = Some((side, Taken { r2: side.r2, ..angle }));
            }
        }
    }
    let Some((side, angle)) = best else { return };
    whole.beta = Some([whole.mean_of(angle), whole.slope_of(angle)]);
    whole.take(Role::Sideslip, angle, "the side force divided by airspeed squared");
    whole.take(Role::SpecificForceY, side, "divided by airspeed squared, linear in sideslip");
}

/// Least squared correlation of the change of a sideslip with the yaw rate and the bank alone, the largest ratio of its slope, and the least
/// sideslip, rad.
const SIDE_R2_PLAIN: f64 = 0.9;
const PLAIN_RATIO: f64 = 1.15;
const LEAST_SIDESLIP: f64 = 5e-4;

/// Axial force by the angle of attack.
fn find_axial(whole: &mut Assignment<'_>, square: &[f64]) {
    let (Some([alpha, _]), Some((unit, scale))) = (whole.alpha.clone(), shared_unit(whole)) else { return };
    if has(whole, Role::SpecificForceX) {
        return;
    }
    let middle = average(square);
    let mean = average(&alpha);
    let expected =
        average(&whole.each(|k| G * whole.theta[k].sin())) + whole.acceleration.as_deref().map_or(0.0, average);
    let curve: Vec<f64> = alpha.iter().map(|alpha| (alpha - mean).powi(2)).collect();
    let fits = |whole: &Assignment<'_>, i: usize| {
        let column = whole.column(i);
        let Fit { coefficients: [slope, ..], r2 } = fit(&over(&column.mean, square), &[&alpha, &curve])?;
        let size = slope * middle / (scale * G);
        let is_axial = average(&column.mean).abs() < MEAN_AXIAL * G * scale && AXIAL.contains(&size);
        let apart = average(&column.mean) / scale - expected;
        (is_axial && r2 > AXIAL_R2 && apart.abs() < AXIAL_LEVEL * G).then_some(Taken {
            column: i,
            unit,
            factor: 1.0 / scale,
            r2,
        })
    };
    whole.take_nearest(Role::SpecificForceX, "divided by airspeed squared, a curve over angle of attack", fits);
}
