//! Controls by the angular acceleration that each starts beyond what motion and flow explain.

use super::air_data::average;
use super::assignment::Assignment;
use super::fit::{fit, line};
use super::kinematics::{Taken, log_likelihood};
use super::laws::can_be_normal;
use crate::quantity::Role;

/// Least gain of a control over the fit without it, as the logarithm of the likelihood, and over the next control that moves otherwise.
const LEAST_GAIN: f64 = 8.0;
const LEAST_LEAD: f64 = 6.0;
/// Least squared correlation of the angular acceleration with all that makes it, and the part of its variance that a control adds at least.
const LEAST_R2: f64 = 0.6;
const LEAST_PITCH_R2: f64 = 0.45;
const LEAST_PART: f64 = 0.08;
/// Squared correlation of two records of one control, of a left and a right one, or of a control and its command.
const SAME_R2: f64 = 0.8;
/// Largest deflection as recorded.
const LARGEST: f64 = 120.0;

/// Part of the mean airspeed that flight has at least.
const FLYING: f64 = 0.6;

/// Products of two series.
fn times(values: &[f64], with: &[f64]) -> Vec<f64> {
    values.iter().zip(with).map(|(a, b)| a * b).collect()
}

/// Finds elevator, aileron and rudder.
pub fn complete(whole: &mut Assignment<'_>) {
    let rate = |whole: &Assignment<'_>, role: Role| {
        let found = whole.found.iter().find(|found| found.role == role)?;
        let scale = if found.unit == Some("deg/s") { 1f64.to_radians() } else { 1.0 };
        let scale = if found.turned { -scale } else { scale };
        Some(whole.column(found.column).slope.iter().map(|slope| scale * slope).collect::<Vec<f64>>())
    };
    let speed = whole.airspeed.clone().unwrap_or_else(|| whole.each(|_| 1.0));
    let least = FLYING * average(&speed);
    let speed: Vec<f64> = speed.into_iter().map(|speed| if speed > least { speed } else { f64::NAN }).collect();
    let square = times(&speed, &speed);
    let (vp, vq, vr) = (times(&whole.p, &speed), times(&whole.q, &speed), times(&whole.r, &speed));
    let flow = |angle: &Option<[Vec<f64>; 2]>| angle.as_ref().map(|[angle, _]| times(angle, &square));
    let (alpha, beta) = (flow(&whole.alpha), flow(&whole.beta));
    let force = |whole: &Assignment<'_>, role: Role| {
        let found = whole.found.iter().find(|found| found.role == role)?;
        Some(whole.column(found.column).mean.clone())
    };
    // The force that a flow angle makes stands in its place.
    let lift = alpha.or_else(|| force(whole, Role::SpecificForceZ));
    let side = beta.or_else(|| force(whole, Role::SpecificForceY));
    if let (Some(wanted), Some(lift)) = (rate(whole, Role::PitchRate), lift) {
        let yaw = rate(whole, Role::YawRate);
        let is_of_pitch = |control: &[f64], explained: &[&[f64]]| {
            let pitch = effect(&wanted, explained, control).map_or(0.0, f64::abs);
            let yaw = yaw.as_ref().and_then(|yaw| effect(yaw, &[&vp, &vr], control)).map_or(0.0, f64::abs);
            pitch > yaw
        };
        // Where gusts hide much of the pitch acceleration, a known sideslip keeps lateral controls apart.
        let least = if side.is_some() { LEAST_PITCH_R2 } else { LEAST_R2 };
        let explained: [&[f64]; 3] = [&vq, &square, &lift];
        let of_pitch = Wanted {
            acceleration: &wanted,
            explained: &explained,
            square: &square,
            least_r2: least,
            can_be: &is_of_pitch,
        };
        find_control(whole, Role::Elevator, &of_pitch);
    }
    let accelerations = (rate(whole, Role::RollRate), rate(whole, Role::YawRate));
    let (Some(side), (Some(roll), Some(yaw))) = (side, accelerations) else { return };
    let mut lateral: Vec<&[f64]> = vec![&vp, &vr, &side];
    let is_of_roll = |control: &[f64], explained: &[&[f64]]| {
        let [roll, yaw] = [&roll, &yaw].map(|wanted| effect(wanted, explained, control).map_or(0.0, f64::abs));
        roll > ROLL_OVER_YAW * yaw
    };
    let of_roll =
        Wanted { acceleration: &roll, explained: &lateral, square: &square, least_r2: LEAST_R2, can_be: &is_of_roll };
    let aileron = find_control(whole, Role::Aileron, &of_roll);
    let aileron = aileron.map(|taken| times(&whole.column(taken.column).mean, &square));
    lateral.extend(aileron.as_deref());
    let is_of_yaw = |control: &[f64], explained: &[&[f64]]| !is_of_roll(control, explained);
    let of_yaw =
        Wanted { acceleration: &yaw, explained: &lateral, square: &square, least_r2: LEAST_R2, can_be: &is_of_yaw };
    find_control(whole, Role::Rudder, &of_yaw);
}

/// Change of an angular acceleration with a control, with what else explains it.
fn effect(wanted: &[f64], explained: &[&[f64]], control: &[f64]) -> Option<f64> {
    let mut regressors = explained.to_vec();
    regressors.push(control);
    fit(wanted, &regressors).map(|found| found.coefficients[explained.len()])
}

/// Whether values, with what else explains an angular acceleration, can be a control.
type CanBe<'c> = dyn Fn(&[f64], &[&[f64]]) -> bool + 'c;

/// An angular acceleration, what else explains it, and what a control of it must be.
struct Wanted<'c> {
    acceleration: &'c [f64],
    explained: &'c [&'c [f64]],
    /// Squares of the airspeed.
    square: &'c [f64],
    least_r2: f64,
    can_be: &'c CanBe<'c>,
}

/// The control that explains most of an angular acceleration beyond the rest; a positive deflection makes a negative one (docs/conventions.md).
fn find_control(whole: &mut Assignment<'_>, role: Role, by: &Wanted<'_>) -> Option<Taken> {
    let Wanted { acceleration: wanted, explained, square, least_r2, can_be } = *by;
    let independent = whole.windows.independent;
    let without = fit(wanted, explained).map_or(0.0, |fit| fit.r2);
    let mut all: Vec<(Taken, f64)> = Vec::new();
    for i in whole.free() {
        let column = whole.column(i);
        // What stands before a normal force of 1 g is the side force of that accelerometer.
        let is_side = i + 1 < whole.windows.columns.len() && can_be_normal(whole, i + 1).is_some();
        if column.turn.is_some() || column.largest > LARGEST || is_side {
            continue;
        }
        // An angular acceleration in any unit is no control.
        if line(&column.mean, wanted).is_some_and(|(_, r2)| r2 > LARGEST_R2) {
            continue;
        }
        let control = times(&column.mean, square);
        // A flow angle or a force that motion and flow explain is no control.
        if fit(&control, explained).is_some_and(|own| own.r2 > EXPLAINED_R2) || !can_be(&control, explained) {
            continue;
        }
        let mut regressors = explained.to_vec();
        regressors.push(&control);
        let Some(found) = fit(wanted, &regressors) else { continue };
        let effect = found.coefficients[explained.len()];
        let gain = log_likelihood(found.r2, independent) - log_likelihood(without, independent);
        all.push((Taken { column: i, unit: "", factor: -effect.signum(), r2: found.r2 }, gain));
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (best, gain) = *all.first()?;
    let is_other = |other: &Taken| {
        line(&whole.column(other.column).mean, &whole.column(best.column).mean).is_none_or(|(_, r2)| r2 < SAME_R2)
    };
    let next = all.iter().skip(1).find(|(other, _)| is_other(other));
    let lead = gain - next.map_or(0.0, |(_, gain)| *gain);
    let is_clear = gain > LEAST_GAIN && lead > LEAST_LEAD && best.r2 - without > LEAST_PART;
    if !is_clear || best.r2 < least_r2 {
        return None;
    }
    whole.take(role, best, "leads the angular acceleration");
    Some(best)
}

/// Ratio of the roll acceleration to the yaw acceleration that an aileron makes, at least, and a rudder at most.
const ROLL_OVER_YAW: f64 = 2.5;
/// Squared correlation with motion and flow from which a channel is one of them.
const EXPLAINED_R2: f64 = 0.95;
/// Squared correlation with an angular acceleration from which a channel is one itself.
const LARGEST_R2: f64 = 0.97;
