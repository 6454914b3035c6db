//! Controls by the angular acceleration that each starts beyond what motion and flow explain.

use super::assignment::Assignment;
use super::fit::fit;
use super::kinematics::{Taken, log_likelihood};
use crate::quantity::Role;

/// Least gain of a control over the fit without it, as the logarithm of the likelihood, and over the next control.
const LEAST_GAIN: f64 = 8.0;
const LEAST_LEAD: f64 = 10.0;
/// Least squared correlation of the angular acceleration with all that makes it.
const LEAST_R2: f64 = 0.6;

pub fn complete(whole: &mut Assignment<'_>) {
    let Some(speed) = whole.airspeed.clone() else { return };
    let rate = |role: Role| {
        whole
            .found
            .iter()
            .find(|found| found.role == role)
            .map(|found| (found.column, found.unit == Some("deg/s"), found.turned))
    };
    let change = |whole: &Assignment<'_>, (column, is_deg, turned): (usize, bool, bool)| -> Vec<f64> {
        let scale = if is_deg { 1f64.to_radians() } else { 1.0 } * if turned { -1.0 } else { 1.0 };
        whole.column(column).slope.iter().map(|slope| scale * slope).collect()
    };
    let has = |role: Role| whole.found.iter().any(|found| found.role == role);
    let is_lateral = has(Role::Sideslip) && has(Role::SpecificForceY);
    let is_longitudinal = has(Role::AngleOfAttack) && has(Role::SpecificForceZ);
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate].map(rate);
    let square: Vec<f64> = speed.iter().map(|speed| speed * speed).collect();
    let scaled = |values: &[f64], with: &[f64]| -> Vec<f64> { values.iter().zip(with).map(|(a, b)| a * b).collect() };
    let (vp, vq, vr) = (scaled(&whole.p, &speed), scaled(&whole.q, &speed), scaled(&whole.r, &speed));
    let alpha = whole.alpha.as_ref().map(|[alpha, _]| scaled(alpha, &square));
    let beta = whole.beta.as_ref().map(|[beta, _]| scaled(beta, &square));
    if let Some(rate) = rates[1].filter(|_| is_longitudinal) {
        let mut explained: Vec<&[f64]> = vec![&vq, &square];
        explained.extend(alpha.as_deref());
        let wanted = change(whole, rate);
        find(whole, Role::Elevator, &wanted, &explained, &square);
    }
    let mut lateral: Vec<&[f64]> = vec![&vp, &vr];
    lateral.extend(beta.as_deref());
    let aileron = rates[0].filter(|_| is_lateral).and_then(|rate| {
        let wanted = change(whole, rate);
        find(whole, Role::Aileron, &wanted, &lateral, &square)
    });
    let aileron = aileron.map(|taken| scaled(&whole.column(taken.column).mean, &square));
    lateral.extend(aileron.as_deref());
    if let Some(rate) = rates[2].filter(|_| is_lateral) {
        let wanted = change(whole, rate);
        find(whole, Role::Rudder, &wanted, &lateral, &square);
    }
}

/// The control that explains most of an angular acceleration beyond the rest; a positive deflection makes a negative one (docs/conventions.md).
fn find(whole: &mut Assignment<'_>, role: Role, wanted: &[f64], explained: &[&[f64]], square: &[f64]) -> Option<Taken> {
    let independent = whole.windows.independent;
    let without = fit(wanted, explained).map_or(0.0, |fit| fit.r2);
    let mut all: Vec<(Taken, f64)> = Vec::new();
    for i in whole.free() {
        let column = whole.column(i);
        if column.turn.is_some() || column.largest > 120.0 {
            continue;
        }
        let control: Vec<f64> = column.mean.iter().zip(square).map(|(a, b)| a * b).collect();
        let mut regressors = explained.to_vec();
        regressors.push(&control);
        let Some(found) = fit(wanted, &regressors) else { continue };
        let effect = found.coefficients[explained.len()];
        let gain = log_likelihood(found.r2, independent) - log_likelihood(without, independent);
        all.push((Taken { column: i, unit: "", factor: -effect.signum(), r2: found.r2 }, gain));
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (best, gain) = *all.first()?;
    let lead = gain - all.get(1).map_or(0.0, |(_, gain)| *gain);
    if gain < LEAST_GAIN || lead < LEAST_LEAD || best.r2 < LEAST_R2 {
        return None;
    }
    whole.take(role, best, "starts the angular acceleration");
    Some(best)
}
