//! Heights, velocities and places over the Earth by airspeed and attitude, and what goes with height.

use super::air::{SPEEDS, taken};
use super::air_data::{self, average};
use super::assignment::Assignment;
use super::fit::{fit, line};
use super::kinematics::Taken;
use super::tracks;
use crate::quantity::Role;

/// Units with how many of them make one of SI.
pub const LENGTHS: [(&str, f64); 2] = [("m", 1.0), ("ft", 3.280_84)];
pub const CLIMBS: [(&str, f64); 5] =
    [("m/s", 1.0), ("kt", 1.943_844), ("ft/s", 3.280_84), ("km/h", 3.6), ("ft/min", 196.850_4)];
const ACCELERATIONS: [(&str, f64); 2] = [("rad/s^2", 1.0), ("deg/s^2", 57.295_779_513_082_32)];
/// Mean radius of the Earth, m.
pub const EARTH_M: f64 = 6.371e6;
const RATIO: f64 = 1.15;
/// Heights that are flown at, m.
const HEIGHTS_M: std::ops::Range<f64> = 0.0..25_000.0;
const HEIGHT_R2: f64 = 0.8;
/// How far below the best squared correlation that of another height may be.
const HEIGHT_SPREAD: f64 = 0.02;
const CLIMB_R2: f64 = 0.8;
const GROUND_R2: f64 = 0.9;
const RATE_R2: f64 = 0.8;
/// Least part of the square of a velocity that the airspeed along the heading explains where there is no wind.
const NO_WIND_R2: f64 = 0.999_9;
/// Least part of the square of the airspeed along an axis that is told so.
const LEAST_ALONG: f64 = 0.05;
const RATE_RATIO: f64 = 1.1;
/// Largest part of the other axis in a velocity over the Earth.
const CROSS: f64 = 0.2;
/// Least spread of the heading, rad, at which axes are told apart.
const LEAST_TURN: f64 = 0.35;

pub fn complete(whole: &mut Assignment<'_>) {
    find_height(whole);
    find_climb(whole);
    find_ground(whole);
    find_accelerations(whole);
    air_data::complete_known(whole);
}

/// Climb by airspeed, attitude and flow angles, m/s: `V (cos(alpha) cos(beta) sin(theta) - (sin(beta) sin(phi) + sin(alpha) cos(beta) cos(phi))
/// cos(theta))` (Stevens and Lewis, section 3.6).
pub fn climb_at(whole: &Assignment<'_>, speed: &[f64]) -> Vec<f64> {
    let angle_at = |angle: &Option<[Vec<f64>; 2]>, k: usize| angle.as_ref().map_or(0.0, |[angle, _]| angle[k]);
    whole.each(|k| {
        let ((sa, ca), (sb, cb)) = (angle_at(&whole.alpha, k).sin_cos(), angle_at(&whole.beta, k).sin_cos());
        let ((sp, cp), (st, ct)) = (whole.phi[k].sin_cos(), whole.theta[k].sin_cos());
        speed[k] * (ca * cb * st - (sb * sp + sa * cb * cp) * ct)
    })
}

fn climb(whole: &Assignment<'_>) -> Option<Vec<f64>> {
    whole.airspeed.as_ref().map(|speed| climb_at(whole, speed))
}

/// A channel whose change is a climb.
pub fn is_height(whole: &Assignment<'_>, i: usize, climb: &[f64]) -> Option<Taken> {
    let level = whole.each(|k| whole.phi[k].cos());
    let column = whole.column(i);
    let found =
        if whole.alpha.is_some() { fit(&column.slope, &[climb]) } else { fit(&column.slope, &[climb, &level]) }?;
    let ratio = if whole.alpha.is_some() { 1.06 } else { 1.2 };
    let found = taken(i, found.coefficients[0], &LENGTHS, ratio, found.r2)?;
    let inside = column.range.iter().all(|height| HEIGHTS_M.contains(&(found.factor * height).abs()));
    inside.then_some(found)
}

fn find_height(whole: &mut Assignment<'_>) {
    if whole.height.is_some() {
        return;
    }
    let Some(climb) = climb(whole) else { return };
    let fits = |whole: &Assignment<'_>, i: usize| is_height(whole, i, &climb).filter(|found| found.r2 > HEIGHT_R2);
    let mut all: Vec<Taken> = whole.free().into_iter().filter_map(|i| fits(whole, i)).collect();
    all.sort_by(|a, b| b.r2.total_cmp(&a.r2));
    let best = all.first().map_or(1.0, |taken| taken.r2);
    all.retain(|taken| taken.r2 > best - HEIGHT_SPREAD);
    let up = all.iter().find(|taken| taken.factor > 0.0).copied();
    let down = all.iter().find(|taken| taken.factor < 0.0).copied();
    if let Some(height) = up.or(down) {
        whole.height = Some([whole.mean_of(height), whole.slope_of(height)]);
    }
    if let Some(up) = up {
        whole.take(Role::Altitude, up, "its rate of change is the climb rate");
    }
    if let Some(down) = down {
        whole.take(
            Role::PositionDown,
            Taken { factor: -down.factor, ..down },
            "its rate of change is the descent rate",
        );
    }
}

fn find_climb(whole: &mut Assignment<'_>) {
    if whole.climb.is_some() {
        return;
    }
    let change = match (&whole.height, climb(whole)) {
        (Some([_, change]), _) => change.clone(),
        (None, Some(climb)) => climb,
        _ => return,
    };
    let fits = |whole: &Assignment<'_>, i: usize| {
        let (slope, r2) = line(&whole.column(i).mean, &change)?;
        let found = taken(i, slope, &CLIMBS, RATIO, r2)?;
        (r2 > CLIMB_R2).then_some(Taken { factor: -found.factor, ..found })
    };
    if let Some(descent) = whole.take_nearest(Role::VelocityDown, "the rate of change of altitude", fits) {
        whole.climb = Some(whole.mean_of(descent).into_iter().map(|down| -down).collect());
    }
}

/// Velocities and places north and east.
fn find_ground(whole: &mut Assignment<'_>) {
    let (Some(psi), Some(speed)) = (whole.psi.clone(), whole.airspeed.clone()) else { return };
    let beta = |whole: &Assignment<'_>, k: usize| whole.beta.as_ref().map_or(0.0, |[beta, _]| beta[k]);
    let track = whole.each(|k| psi[k] + beta(whole, k) * whole.phi[k].cos());
    let flat = whole.each(|k| speed[k] * whole.theta[k].cos());
    let axes = [whole.each(|k| flat[k] * track[k].cos()), whole.each(|k| flat[k] * track[k].sin())];
    let finite = || psi.iter().filter(|angle| angle.is_finite());
    let range = finite().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
    // Places that were found make all others.
    if whole.ground.is_some() {
        return;
    }
    if range[1] - range[0] < LEAST_TURN {
        // On a constant heading only what is the airspeed along it, without wind, is told from the airspeed.
        let level = average(&speed);
        let climb = whole.climb.clone().unwrap_or_else(|| climb_at(whole, &speed));
        let flat = whole.each(|k| (speed[k] * speed[k] - climb[k] * climb[k]).max(0.0).sqrt());
        let axes = [whole.each(|k| flat[k] * track[k].cos()), whole.each(|k| flat[k] * track[k].sin())];
        let roles = [(Role::VelocityNorth, Role::PositionNorth), (Role::VelocityEast, Role::PositionEast)];
        for ((velocity, position), axis) in roles.into_iter().zip(axes) {
            let is_long = average(&axis.iter().map(|v| v * v).collect::<Vec<_>>()) > LEAST_ALONG * level * level;
            let is_record = |values: &[f64], units: &[(&'static str, f64)], i: usize| {
                let found = tracks::is_record(values, &axis, level, units, i);
                found.filter(|found| is_long && found.r2 > NO_WIND_R2)
            };
            let relation = "airspeed along the heading";
            whole.take_nearest(velocity, relation, |whole, i| is_record(&whole.column(i).mean, &SPEEDS, i));
            whole.take_nearest(position, relation, |whole, i| is_record(&whole.column(i).slope, &LENGTHS, i));
        }
        return;
    }
    let fits = |y: &[f64], axis: usize| {
        let found = fit(y, &[&axes[axis], &axes[1 - axis]])?;
        let [own, other, ..] = found.coefficients;
        (found.r2 > GROUND_R2 && other.abs() < CROSS * own.abs()).then_some((own, found.r2))
    };
    let velocities = [Role::VelocityNorth, Role::VelocityEast];
    let positions = [Role::PositionNorth, Role::PositionEast];
    let mut found = [None; 2];
    for axis in 0..2 {
        let speed = |whole: &Assignment<'_>, i: usize| {
            let (own, r2) = fits(&whole.column(i).mean, axis)?;
            taken(i, own, &SPEEDS, 1.25, r2)
        };
        found[axis] = whole.take_nearest(velocities[axis], "airspeed along the heading plus wind", speed);
    }
    if let [Some(north), Some(east)] = found {
        whole.ground = Some([whole.mean_of(north), whole.mean_of(east)]);
    }
    let mut latitude = None;
    for axis in 0..2 {
        let place = |whole: &Assignment<'_>, i: usize| {
            let (own, r2) = fits(&whole.column(i).slope, axis)?;
            taken(i, own, &LENGTHS, 1.25, r2)
        };
        whole.take_nearest(positions[axis], "its rate of change is airspeed along the heading plus wind", place);
        let wide = if axis == 0 {
            1.0
        } else {
            let Some(found) = latitude else { continue };
            let mean: Vec<f64> = whole.mean_of(found);
            let finite: Vec<f64> = mean.into_iter().filter(|value| value.is_finite()).collect();
            (finite.iter().sum::<f64>() / finite.len() as f64).cos()
        };
        let units = [("rad", 1.0 / EARTH_M / wide), ("deg", 1f64.to_degrees() / EARTH_M / wide)];
        let angle = |whole: &Assignment<'_>, i: usize| {
            let (own, r2) = fits(&whole.column(i).slope, axis)?;
            let found = taken(i, own, &units, 1.25, r2)?;
            let factor = if found.unit == "deg" { 1f64.to_radians() } else { 1.0 };
            Some(Taken { factor: found.factor.signum() * factor, ..found })
        };
        let role = if axis == 0 { Role::Latitude } else { Role::Longitude };
        let found = whole.take_nearest(role, "its rate of change is airspeed along the heading plus wind", angle);
        if axis == 0 {
            latitude = found;
        }
    }
}

fn find_accelerations(whole: &mut Assignment<'_>) {
    let pairs = [
        (Role::RollRate, Role::RollAcceleration),
        (Role::PitchRate, Role::PitchAcceleration),
        (Role::YawRate, Role::YawAcceleration),
    ];
    for (rate, acceleration) in pairs {
        let Some(rate) = whole.found.iter().find(|found| found.role == rate) else { continue };
        let scale =
            if rate.unit == Some("deg/s") { 1f64.to_radians() } else { 1.0 } * if rate.turned { -1.0 } else { 1.0 };
        let change: Vec<f64> = whole.column(rate.column).slope.iter().map(|slope| scale * slope).collect();
        let fits = |whole: &Assignment<'_>, i: usize| {
            let (slope, r2) = line(&whole.column(i).mean, &change)?;
            taken(i, slope / r2.sqrt(), &ACCELERATIONS, RATE_RATIO, r2).filter(|found| found.r2 > RATE_R2)
        };
        whole.take_best(acceleration, "the derivative of the angular rate", fits);
    }
}
