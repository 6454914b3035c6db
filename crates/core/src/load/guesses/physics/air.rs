//! Airspeed, flow angles and specific forces by the equations of motion of a rigid body over a flat Earth (Stevens and Lewis, Aircraft Control
//! and Simulation, section 2.5): `V_dot = ax - g sin(theta)` and `alpha_dot = q + (az + g cos(theta) cos(phi)) / V - p beta` to the first order
//! of the flow angles, `beta_dot = p alpha - r + (ay + g cos(theta) sin(phi)) / V`.

use super::air_data::average;
use super::assignment::Assignment;
use super::earth;
use super::fit::{fit, line, snap};
use super::kinematics::{ANGLES, Taken, log_likelihood};
use super::windows::Column;
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::quantity::Role;

/// What an airspeed is found by.
const RELATION: &str = "forces, climb and turn of this speed";
const G: f64 = STANDARD_GRAVITY_M_S2;
/// Units with how many of them make one of SI.
pub const SPEEDS: [(&str, f64); 4] = [("m/s", 1.0), ("kt", 1.943_844), ("ft/s", 3.280_84), ("km/h", 3.6)];
pub const FORCES: [(&str, f64); 3] = [("m/s^2", 1.0), ("g", 1.0 / G), ("ft/s^2", 3.280_84)];
/// Largest ratio of a coefficient to that of its unit, either way: of forces and speeds, of flow angles.
const FLOW_RATIO: f64 = 1.25;
/// Least squared correlations.
const FLOW_R2: f64 = 0.7;
const FLOW_R2_ALONE: f64 = 0.9;
const LIFT_R2: f64 = 0.3;
const FORCE_R2: f64 = 0.6;
const FORCE_R2_ALONE: f64 = 0.85;
const SIDE_R2: f64 = 0.5;
/// Least squared correlation of a specific force with the flow angle that makes it.
const OPPOSING_R2: f64 = 0.3;
/// Largest flow angle and least sideslip, rad, and least airspeed, m/s.
const LEAST_FLOW: f64 = 5e-4;
const LARGEST_FLOW: f64 = 1.3;
const LEAST_SPEED: f64 = 4.0;
const LARGEST_SPEED: f64 = 700.0;
/// Largest ratio of an airspeed to the one that the turning of the flight path shows, either way.
const SPEED_RATIO: f64 = 1.2;

/// Mean of a function of the finite values.
pub fn average_by(values: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    average(&values.iter().map(|value| of(*value)).collect::<Vec<f64>>())
}

fn factor_of(units: &[(&str, f64)], name: &str) -> f64 {
    units.iter().find(|(unit, _)| *unit == name).map_or(1.0, |(_, scale)| *scale)
}

/// A channel of a unit by the coefficient that it has.
pub fn taken(column: usize, coefficient: f64, units: &[(&'static str, f64)], ratio: f64, r2: f64) -> Option<Taken> {
    let unit = snap(coefficient, units, ratio)?;
    Some(Taken { column, unit, factor: coefficient.signum() / factor_of(units, unit), r2 })
}

/// Airspeed and angle of attack, with what they need of each other.
pub fn complete(whole: &mut Assignment<'_>, speed: Option<Taken>) {
    if let Some(speed) = speed {
        take_speed(whole, speed, RELATION);
    }
    let before = whole.clone();
    let about = find_lift(whole);
    if whole.airspeed.is_none() {
        find_speed(whole, about);
    }
    if whole.airspeed.is_none() && about.is_some() {
        // Nothing flies at the speed of that pair.
        *whole = before;
        find_speed(whole, None);
    }
    if let Some([north, east]) = whole.ground.clone().filter(|_| whole.airspeed.is_none()) {
        let over_ground = whole.each(|k| north[k].hypot(east[k]));
        find_speed(whole, Some(average(&over_ground)));
    }
    if whole.alpha.is_none() {
        find_alpha(whole);
    }
}

/// Largest range of a flow angle as recorded.
const LARGEST_ANGLE: f64 = 60.0;

/// Whether a column can be a flow angle.
pub fn can_be_flow(whole: &Assignment<'_>, i: usize) -> bool {
    whole.column(i).largest < LARGEST_ANGLE && whole.column(i).turn.is_none()
}

/// The specific force along z with the angle of attack, and the mean airspeed, m/s, that the turning of the flight path then shows:
/// `az + g cos(theta) cos(phi) = V (alpha_dot - q)`.
fn find_lift(whole: &mut Assignment<'_>) -> Option<f64> {
    let gravity = whole.each(|k| G * whole.theta[k].cos() * whole.phi[k].cos());
    let q = whole.q.clone();
    let free = whole.free();
    let mut best: Option<(Taken, f64, Option<Taken>, f64)> = None;
    for &i in &free {
        let column = whole.column(i);
        let level = average(&column.mean);
        let near = |scale: f64| (0.75..1.35).contains(&(level.abs() / (scale * G)));
        for (unit, scale) in FORCES.into_iter().filter(|(_, scale)| near(*scale)) {
            let force = Taken { column: i, unit, factor: -level.signum() / scale, r2: 0.0 };
            let turning = whole.each(|k| force.factor * column.mean[k] + gravity[k]);
            let Some(alone) = line(&turning, &q).filter(|(slope, _)| *slope < 0.0) else { continue };
            let mut consider = |r2: f64, speed: f64, alpha: Option<Taken>| {
                if (LEAST_SPEED..LARGEST_SPEED).contains(&speed) && r2 > 0.5 && best.is_none_or(|best| r2 > best.1) {
                    best = Some((force, r2, alpha, speed));
                }
            };
            consider(alone.1, -alone.0, None);
            for &j in free.iter().filter(|j| **j != i && can_be_flow(whole, **j)) {
                let Some(found) = fit(&turning, &[&q, &whole.column(j).slope]) else { continue };
                let [speed, change, ..] = found.coefficients;
                // What adds little is not the angle of attack.
                if speed >= 0.0 || found.r2 < alone.1 + 0.3 * (1.0 - alone.1) {
                    continue;
                }
                let angle = taken(j, speed / change, &ANGLES, FLOW_RATIO, found.r2);
                let angle = angle.filter(|angle| angle.factor.abs() * whole.column(j).largest < LARGEST_FLOW);
                // More angle of attack is more lift.
                let lifts =
                    line(&column.mean, &whole.column(j).mean).filter(|(_, r2)| *r2 > LIFT_R2).map(|(slope, _)| slope);
                let angle = angle.map(|angle| Taken { factor: -angle.factor, ..angle });
                let angle = angle.filter(|angle| lifts.is_some_and(|slope| slope * force.factor * angle.factor < 0.0));
                if let Some(angle) = angle {
                    consider(found.r2, -speed, Some(angle));
                }
            }
        }
    }
    let (_, r2, alpha, speed) = best?;
    if let Some(alpha) = alpha.filter(|_| r2 > FLOW_R2) {
        whole.alpha = Some([whole.mean_of(alpha), whole.slope_of(alpha)]);
        whole.take(Role::AngleOfAttack, alpha, "the pitch rate minus its rate of change turns the flight path");
    }
    Some(speed)
}

/// Gives the airspeed its channel.
pub fn take_speed(whole: &mut Assignment<'_>, speed: Taken, relation: &str) {
    whole.speed = Some(speed);
    whole.airspeed = Some(whole.mean_of(speed));
    whole.acceleration = Some(whole.slope_of(speed));
    whole.take(Role::TrueAirspeed, speed, relation);
}

/// Whether a channel is not negative in flight, but for its noise.
pub fn is_positive(column: &Column) -> bool {
    let mut all: Vec<f64> = column.mean.iter().copied().filter(|value| value.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 6).is_some_and(|least| *least > -0.02 * column.largest)
}

/// Channels that can be an airspeed.
pub fn can_be_speed(whole: &Assignment<'_>, i: usize) -> bool {
    let column = whole.column(i);
    is_positive(column) && column.largest > LEAST_SPEED && column.turn.is_none()
}

/// Specific forces along x, y, z that an airspeed, its change, the flow angles, attitude and rates make:
/// `ax = u_dot + q w - r v + g sin(theta)`, `ay = v_dot + r u - p w - g cos(theta) sin(phi)`, `az = w_dot + p v - q u - g cos(theta) cos(phi)`
/// with `u, v, w = V (cos(alpha) cos(beta), sin(beta), sin(alpha) cos(beta))` (Stevens and Lewis, section 2.5).
fn forces(whole: &Assignment<'_>, speed: &[f64], change: &[f64]) -> [Vec<f64>; 3] {
    let mut made: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(speed.len()));
    let flow = |angle: &Option<[Vec<f64>; 2]>, k: usize| {
        angle.as_ref().map_or((0.0, 0.0), |[mean, slope]| (mean[k], slope[k]))
    };
    for k in 0..speed.len() {
        let ((alpha, turning), (beta, slipping)) = (flow(&whole.alpha, k), flow(&whole.beta, k));
        let ((sa, ca), (sb, cb)) = (alpha.sin_cos(), beta.sin_cos());
        let ((sp, cp), (st, ct)) = (whole.phi[k].sin_cos(), whole.theta[k].sin_cos());
        let (p, q, r, v) = (whole.p[k], whole.q[k], whole.r[k], speed[k]);
        let (u, side, w) = (v * ca * cb, v * sb, v * sa * cb);
        let along = change[k] * cb - v * sb * slipping;
        made[0].push(along * ca - v * cb * sa * turning + q * w - r * side + G * st);
        made[1].push(change[k] * sb + v * cb * slipping + r * u - p * w - G * ct * sp);
        made[2].push(along * sa + v * cb * ca * turning + p * side - q * u - G * ct * cp);
    }
    made
}

/// The channel that records a specific force, whose mean it shares but for `free`.
fn force(whole: &Assignment<'_>, i: usize, wanted: &[f64], ratio: f64, free: f64) -> Option<Taken> {
    let column = whole.column(i);
    let (slope, r2) = line(&column.mean, wanted)?;
    let found = taken(i, slope, &FORCES, ratio, r2)?;
    let offset = found.factor * average(&column.mean) - average(wanted);
    (offset.abs() < free).then_some(found)
}

/// The specific force along x, `ax = u_dot + steady`, where the change of the airspeed may be drowned by its noise in part.
fn find_forward(whole: &Assignment<'_>, i: usize, steady: &[f64], change: &[f64]) -> Option<Taken> {
    let column = whole.column(i);
    let found = fit(&column.mean, &[steady, change])?;
    let [own, speeding, ..] = found.coefficients;
    let force = taken(i, own, &FORCES, 1.15, found.r2)?;
    let offset = force.factor * average(&column.mean) - average(steady) - average(change);
    (own > 0.0 && (0.4..1.3).contains(&(speeding / own)) && offset.abs() < 0.1 * G).then_some(force)
}

/// The airspeed with which most of what it must agree with does: the specific forces, the climb, the turn.
fn find_speed(whole: &mut Assignment<'_>, about: Option<f64>) {
    let independent = whole.windows.independent;
    let free = whole.free();
    let mut all: Vec<(Taken, f64)> = Vec::new();
    for &i in free.iter().filter(|i| can_be_speed(whole, **i)) {
        for (unit, scale) in SPEEDS {
            let column = whole.column(i);
            let candidate = Taken { column: i, unit, factor: 1.0 / scale, r2: 0.0 };
            let (speed, change) = (whole.mean_of(candidate), whole.slope_of(candidate));
            let middle = average(&speed);
            let is_about = about.is_none_or(|about| (middle / about).ln().abs() < SPEED_RATIO.ln());
            if !is_about
                || !(LEAST_SPEED..LARGEST_SPEED).contains(&middle)
                || column.range[1] / scale > 1.2 * LARGEST_SPEED
            {
                continue;
            }
            let [along, _, lift] = forces(whole, &speed, &change);
            let climb = earth::climb_at(whole, &speed);
            let best = |fits: &dyn Fn(usize) -> Option<f64>| -> f64 {
                let all = free.iter().filter(|j| **j != i).filter_map(|&j| fits(j));
                all.fold(0.0, f64::max)
            };
            let vertical = best(&|j| force(whole, j, &lift, 1.12, 0.15 * G).map(|taken| taken.r2));
            let steady: Vec<f64> = along.iter().zip(&change).map(|(along, change)| along - change).collect();
            let forward = best(&|j| find_forward(whole, j, &steady, &change).map(|taken| taken.r2));
            let height = best(&|j| earth::is_height(whole, j, &climb).map(|taken| taken.r2));
            let energy =
                line(&change, &climb.iter().zip(&speed).map(|(climb, speed)| -G * climb / speed).collect::<Vec<_>>())
                    .filter(|(slope, _)| (0.5..1.5).contains(slope))
                    .map_or(0.0, |(_, r2)| r2);
            let turn = line(
                &whole.each(|k| whole.r[k] * speed[k]),
                &whole.each(|k| G * whole.phi[k].sin() * whole.theta[k].cos()),
            );
            let turn = turn.filter(|(slope, _)| (0.9..1.1).contains(slope));
            let apart = turn.map_or(0.0, |(slope, _)| -0.5 * (slope.ln() / 0.03).powi(2));
            let turn = turn.map_or(0.0, |(_, r2)| r2);
            let score: f64 = [vertical, forward, height, energy, turn]
                .iter()
                .filter(|r2| **r2 > 0.3)
                .map(|r2| log_likelihood(*r2, independent))
                .sum();
            let agree = [vertical, forward.max(energy), height, turn].iter().filter(|r2| **r2 > 0.5).count();
            // What is nearly constant fits any relation that its change has no part in.
            let spread = (column.range[1] - column.range[0]) / column.largest;
            let is_dynamic = forward.max(energy) > 0.6 || (spread > 0.3 && height > 0.9 && turn > 0.8);
            let is_scaled =
                about.is_some() || vertical.max(turn) > 0.8 || (height > 0.85 && energy > 0.8 && turn > 0.3);
            if is_dynamic && is_scaled && agree >= 2 {
                all.push((Taken { r2: vertical.max(height).max(turn), ..candidate }, score + apart));
            }
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let Some(&(_, score)) = all.first() else { return };
    // What is an airspeed but for the flow angles, or calibrated, is less than it.
    let level = |taken: &Taken| taken.factor * average(&whole.column(taken.column).mean);
    let is_like = |taken: &Taken| {
        let first = whole.column(all[0].0.column);
        line(&whole.column(taken.column).mean, &first.mean).is_some_and(|(_, r2)| r2 > 0.9)
    };
    let tied = || {
        all.iter().filter(|(taken, other)| {
            *other > score - 5.0 || (*other > 0.5 * score && taken.unit == all[0].0.unit && is_like(taken))
        })
    };
    let Some(&(best, _)) = tied().max_by(|a, b| level(&a.0).total_cmp(&level(&b.0))) else { return };
    let is_near = |taken: &Taken| taken.unit == best.unit && (level(taken) / level(&best)).ln().abs() < 0.4;
    if tied().all(|(taken, _)| is_near(taken)) {
        take_speed(whole, best, RELATION);
        whole.score += score;
    }
}

/// The angle of attack by the pitch rate and the lift that it makes itself.
fn find_alpha(whole: &mut Assignment<'_>) {
    let airspeed = whole.airspeed.clone();
    let drive = whole.each(|k| {
        let speed = airspeed.as_ref().map_or(f64::INFINITY, |speed| speed[k].max(LEAST_SPEED));
        whole.q[k] + G * whole.theta[k].cos() * whole.phi[k].cos() / speed
    });
    let least = if airspeed.is_some() { FLOW_R2 } else { FLOW_R2_ALONE };
    let fits = |whole: &Assignment<'_>, i: usize| {
        let column = whole.column(i);
        if !can_be_flow(whole, i) {
            return None;
        }
        let found = fit(&column.slope, &[&drive, &column.mean])?;
        let [coefficient, own, ..] = found.coefficients;
        let found = taken(i, coefficient, &ANGLES, FLOW_RATIO, found.r2)?;
        (found.r2 > least && own < 0.0 && found.factor.abs() * column.largest < LARGEST_FLOW).then_some(found)
    };
    if let Some(alpha) =
        whole.take_best(Role::AngleOfAttack, "its rate of change is the pitch rate minus the lift", fits)
    {
        whole.alpha = Some([whole.mean_of(alpha), whole.slope_of(alpha)]);
    }
}

/// The sideslip with the specific force along y, or alone: `beta_dot = p alpha - r + (ay + g cos(theta) sin(phi)) / V`.
pub fn find_side(whole: &mut Assignment<'_>) {
    let Some(airspeed) = whole.airspeed.clone().filter(|_| whole.beta.is_none()) else { return };
    let side = whole.found.iter().find(|found| found.role == Role::SpecificForceY).map(|side| {
        let scale = factor_of(&FORCES, side.unit.unwrap_or_default()) * if side.turned { -1.0 } else { 1.0 };
        whole.column(side.column).mean.iter().map(|value| value / scale).collect::<Vec<f64>>()
    });
    let known = |k: usize| side.as_ref().map_or(0.0, |side| side[k]);
    let drive = whole.each(|k| (side_drive(whole, k) + known(k)) / airspeed[k].max(LEAST_SPEED));
    let free = whole.free();
    let mut best: Option<(Taken, Option<Taken>)> = None;
    // A side force opposes the sideslip that makes it.
    let opposes = |j: usize, angle: &Column, turn: f64| {
        let with = line(&whole.column(j).mean, &angle.mean);
        with.is_some_and(|(slope, r2)| r2 > OPPOSING_R2 && slope * turn < 0.0)
    };
    for &i in free.iter().filter(|i| can_be_flow(whole, **i)) {
        let column = whole.column(i);
        let alone =
            if side.is_some() { fit(&column.slope, &[&drive]) } else { fit(&column.slope, &[&drive, &column.mean]) };
        let alone = alone.filter(|found| found.coefficients[1] <= 0.0);
        let mut consider = |coefficient: f64, r2: f64, side: Option<Taken>| {
            let angle = taken(i, coefficient, &ANGLES, FLOW_RATIO, r2);
            let angle = angle.filter(|angle| {
                let size = average_by(&column.mean, |value| (value * angle.factor).powi(2)).sqrt();
                angle.factor.abs() * column.largest < LARGEST_FLOW && size > LEAST_FLOW
            });
            if let Some(angle) = angle.filter(|_| best.is_none_or(|(best, _)| r2 > best.r2)) {
                best =
                    Some((angle, side.map(|side| Taken { r2, factor: side.factor * angle.factor.signum(), ..side })));
            }
        };
        if let Some(found) = alone {
            consider(found.coefficients[0], found.r2, None);
        }
        let Some((_, plain)) = line(&column.slope, &drive).filter(|(_, r2)| *r2 > 0.1) else { continue };
        let plain = plain.max(alone.map_or(0.0, |alone| alone.r2));
        for &j in free.iter().filter(|j| side.is_none() && **j != i) {
            let force: Vec<f64> =
                whole.column(j).mean.iter().zip(&airspeed).map(|(a, v)| a / v.max(LEAST_SPEED)).collect();
            let Some(found) = fit(&column.slope, &[&drive, &force]) else { continue };
            let [turn, side, ..] = found.coefficients;
            let side = taken(j, turn / side, &FORCES, FLOW_RATIO, found.r2);
            let adds = found.r2 > plain + 0.3 * (1.0 - plain);
            if let Some(side) = side
                .filter(|_| adds)
                .filter(|_| opposes(j, column, turn))
                .filter(|side| (side.factor * average(&whole.column(j).mean)).abs() < 0.3 * G && side.factor > 0.0)
            {
                consider(turn, found.r2, Some(side));
            }
        }
    }
    if let Some((angle, side)) = best.filter(|(angle, _)| angle.r2 > FLOW_R2) {
        if let Some(side) = side {
            whole.take(Role::SpecificForceY, side, "the rate of change of sideslip, with yaw rate and bank");
        }
        whole.beta = Some([whole.mean_of(angle), whole.slope_of(angle)]);
        whole.take(Role::Sideslip, angle, "its rate of change follows from yaw rate, bank and side force");
    }
}

/// `V (p alpha - r) + g cos(theta) sin(phi)`: the change of the velocity along y without a side force.
pub fn side_drive(whole: &Assignment<'_>, k: usize) -> f64 {
    let speed = whole.airspeed.as_ref().map_or(f64::NAN, |speed| speed[k]);
    let alpha = whole.alpha.as_ref().map_or(0.0, |[alpha, _]| alpha[k]);
    speed * (whole.p[k] * alpha - whole.r[k]) + G * whole.theta[k].cos() * whole.phi[k].sin()
}

/// The specific forces of the body.
pub fn complete_forces(whole: &mut Assignment<'_>) {
    let (Some(speed), Some(change)) = (whole.airspeed.clone(), whole.acceleration.clone()) else { return };
    let [along, side, lift] = forces(whole, &speed, &change);
    let normal = average(&lift);
    let fits = |whole: &Assignment<'_>, i: usize| {
        let found = force(whole, i, &lift, 1.3, 1.2 * G).filter(|found| found.r2 > FORCE_R2)?;
        let offset = (found.factor * average(&whole.column(i).mean) - normal).abs();
        let follows = whole.alpha.as_ref().and_then(|[alpha, _]| line(&whole.column(i).mean, alpha));
        if follows.is_some_and(|(slope, r2)| r2 < OPPOSING_R2 || slope * found.factor > 0.0) {
            return None;
        }
        (offset < 0.2 * G || (offset - G).abs() < 0.12 * G).then_some(found)
    };
    let vertical = whole.take_best(Role::SpecificForceZ, "gravity and centripetal acceleration", fits);
    if let Some(vertical) = vertical {
        let offset = vertical.factor * average(&whole.column(vertical.column).mean) - normal;
        if offset.abs() > 0.5 * G
            && let Some(found) = whole.found.last_mut()
        {
            found.offset = -(offset / G).round() * G / vertical.factor;
        }
    }
    let is_of_vector = |found: &Taken| vertical.is_none_or(|vertical| vertical.unit == found.unit);
    let steady: Vec<f64> = along.iter().zip(&change).map(|(along, change)| along - change).collect();
    let least = if vertical.is_some() { FORCE_R2 } else { FORCE_R2_ALONE };
    let fits = |whole: &Assignment<'_>, i: usize| {
        find_forward(whole, i, &steady, &change).filter(is_of_vector).filter(|found| found.r2 > least)
    };
    whole.take_best(Role::SpecificForceX, "gravity and the rate of change of airspeed", fits);
    let fits = |whole: &Assignment<'_>, i: usize| {
        let follows = whole.beta.as_ref().and_then(|[beta, _]| line(&whole.column(i).mean, beta));
        if follows.is_some_and(|(_, r2)| r2 < OPPOSING_R2) {
            return None;
        }
        force(whole, i, &side, 1.4, 0.15 * G).filter(is_of_vector).filter(|found| found.r2 > SIDE_R2)
    };
    if whole.found.iter().any(|found| found.role == Role::SpecificForceY) {
        return;
    }
    whole.take_best(Role::SpecificForceY, "the side force of the flight path", fits);
}
