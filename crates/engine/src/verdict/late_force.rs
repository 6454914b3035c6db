//! Forces that follow all their regressors late: accelerometers that are filtered, or on a late clock.
//!
//! The side force shows it by a search. The normal force does not: angle of attack and pitch rate explain a late one as well, since
//! `CZ_alpha alpha(t - d)` is about `CZ_alpha alpha - CZ_alpha d q`. Where that turns the sign of `CZ_q`, its value gives the delay: the
//! tail of a conventional aeroplane that pitches up moves down and adds lift.

use doublet_core::model::{Coefficient, Term, Variable, regressors};
use doublet_core::statistics::median_step;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::delay::is_one;
use super::fit::{Used, moving_terms, used_windows};
use super::judge::Evidence;
use crate::session::Surface;
use crate::stage::CoefficientFit;

/// Range of delays looked at, s.
const RANGE_S: f64 = 0.12;
/// Longest interval of the samples between which a delay is still found, s.
const SLOWEST_S: f64 = 0.025;
/// Part of the residual's sum of squares that the delay leaves at most.
const LEFT: f64 = 0.95;
/// Standard errors of the derivative by the pitch rate beyond which it has the wrong sign.
const SIGNIFICANT: f64 = 3.0;
/// Standard errors of the derivative by the angle of attack beyond which it is clear.
const CLEAR: f64 = 10.0;

/// A force behind its regressors.
#[derive(Clone, Copy, Debug)]
pub(super) struct LateForce {
    /// What follows what.
    pub(super) text: &'static str,
    /// By how much, s.
    pub(super) delay_s: f64,
}

/// The side force or the normal force, whichever follows its regressors later; none where neither does.
pub(super) fn find_late_force(evidence: Evidence<'_>) -> Option<LateForce> {
    let side = find_late_side_force(evidence)
        .map(|delay_s| LateForce { text: "Side force lags sideslip, rates and rudder", delay_s });
    let normal = find_late_normal_force(evidence)
        .map(|delay_s| LateForce { text: "Normal force lags angle of attack", delay_s });
    side.into_iter().chain(normal).max_by(|one, other| one.delay_s.total_cmp(&other.delay_s))
}

/// Delay of the normal force or the lift behind the angle of attack, s, where the derivative by the pitch rate has the wrong sign:
/// `d = -C_q k / C_alpha`, where the regressor of the pitch rate is `k q`.
fn find_late_normal_force(evidence: Evidence<'_>) -> Option<f64> {
    let fits = &evidence.snapshot.pooled.ready()?.fits;
    let fit = fits.iter().find(|fit| matches!(fit.coefficient, Coefficient::CZ | Coefficient::CL))?;
    let terms = moving_terms(evidence.session, fit);
    let find = |variable: Variable| terms.iter().find(|term| is_one(term, variable));
    let pitching = find(Variable::PitchRate).or_else(|| find(Variable::HalfPitchRate))?;
    let (of_alpha, alpha_error) = read_estimate(fit, find(Variable::Alpha)?)?;
    let (of_pitching, error) = read_estimate(fit, pitching)?;
    let used = used_windows(evidence.session, evidence.snapshot, fit);
    let seconds = -fit_regressor_to_rate(pitching, &used)? / of_alpha;
    let (delay_s, error_s) = (of_pitching * seconds, error * seconds.abs());
    // Where the angle of attack is hardly excited, both derivatives are those of what else moves.
    let is_excited = of_alpha.abs() > CLEAR * alpha_error;
    (is_excited && delay_s > SIGNIFICANT * error_s && delay_s <= RANGE_S).then_some(delay_s)
}

/// Estimate and corrected standard error of a term of a fit.
fn read_estimate(fit: &CoefficientFit, term: &Term) -> Option<(f64, f64)> {
    let estimate = fit.fit.as_ref().ok()?;
    let name = term.derivative_name(fit.coefficient);
    let index = estimate.names.iter().position(|other| *other == name)?;
    Some((estimate.estimates[index], *fit.corrected_errors.get(index)?))
}

/// Slope of the regressor of the pitch rate on that rate, s.
fn fit_regressor_to_rate(term: &Term, used: &[Used<'_>]) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for Used { aero, .. } in used {
        let column: DMatrix<f64> = regressors(std::slice::from_ref(term), &aero.variables).ok()?;
        for (value, rate) in column.iter().zip(&aero.data.rates_rad_s[1]) {
            product += value * rate;
            square += rate * rate;
        }
    }
    (square > 0.0).then(|| product / square)
}

/// Delay of the side force behind its regressors, s, where it explains part of the residual. A rudder that is recorded early does as much:
/// then none.
fn find_late_side_force(evidence: Evidence<'_>) -> Option<f64> {
    if evidence.delays.iter().any(|delay| delay.surface == Surface::Rudder) {
        return None;
    }
    let fits = &evidence.snapshot.pooled.ready()?.fits;
    let fit = fits.iter().find(|fit| fit.coefficient == Coefficient::CY)?;
    let terms = moving_terms(evidence.session, fit);
    let used = used_windows(evidence.session, evidence.snapshot, fit);
    let step_s = used.iter().filter_map(|used| median_step(&used.aero.coefficients.time_s)).reduce(f64::max)?;
    let windows = used.iter().map(|used| {
        let columns: DMatrix<f64> = regressors(&terms, &used.aero.variables).ok()?;
        Some((columns, used.aero.coefficients.get(Coefficient::CY)))
    });
    let windows: Vec<(DMatrix<f64>, &[f64])> = windows.collect::<Option<_>>()?;
    let (delay_s, left) = estimate_delay(&windows, step_s)?;
    (left < LEFT).then_some(delay_s)
}

/// Delay of a coefficient `C` behind all its regressors `x`, s, and the part of the residual's sum of squares that it leaves: fits
/// `C(t + d) = x(t)' b + c` over the windows for delays `d` of whole samples `step_s` apart, with a constant `c` for each window, and takes
/// the tip of the parabola through the least sum of squares and its neighbours. None where samples are slow, windows short or regressors
/// dependent.
fn estimate_delay(windows: &[(DMatrix<f64>, &[f64])], step_s: f64) -> Option<(f64, f64)> {
    let terms = windows.first()?.0.ncols();
    if !(step_s > 0.0 && step_s <= SLOWEST_S) {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some samples")]
    let most = (RANGE_S / step_s).round() as usize;
    let mut normal = DMatrix::zeros(terms, terms);
    let mut rows = Vec::with_capacity(windows.len());
    for (columns, values) in windows {
        let count = columns.nrows().checked_sub(2 * most).filter(|count| *count > terms + 1)?;
        let mut columns = columns.rows(most, count).into_owned();
        for mut column in columns.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        normal += columns.tr_mul(&columns);
        rows.push((columns, *values));
    }
    let normal = normal.cholesky()?;
    let squares: Vec<f64> = (0..=2 * most).map(|shift| sum_squares(&rows, &normal, shift)).collect();
    let best = (0..squares.len()).min_by(|a, b| squares[*a].total_cmp(&squares[*b]))?;
    let (before, after) = (squares.get(best.checked_sub(1)?)?, squares.get(best + 1)?);
    let bend = before - 2.0 * squares[best] + after;
    let tip = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some(((best as f64 - most as f64 + tip) * step_s, squares[best] / squares[most].max(f64::MIN_POSITIVE)))
}

/// What the regressors leave of the coefficients `shift` samples on.
fn sum_squares(rows: &[(DMatrix<f64>, &[f64])], normal: &Cholesky<f64, Dyn>, shift: usize) -> f64 {
    let (mut projected, mut squares) = (DVector::zeros(rows[0].0.ncols()), 0.0);
    for (columns, values) in rows {
        let late = DVector::from_column_slice(&values[shift..shift + columns.nrows()]);
        projected += columns.tr_mul(&late);
        squares += late.norm_squared() - late.sum() * late.mean();
    }
    squares - projected.dot(&normal.solve(&projected))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_that_follows_its_regressors_late_shows_its_delay() {
        let step_s = 0.02;
        let regressor = |t: f64| [(1.9 * t).sin(), (0.31 * t * t).cos(), (4.1 * t).sin().powi(3)];
        let coefficient = |late_s: f64| -> Vec<f64> {
            let noise = |k: i32| 1e-3 * (37.3 * f64::from(k * k)).sin();
            let value = |k: i32| {
                let [a, b, c] = regressor(step_s * f64::from(k) - late_s);
                0.5 - 0.3 * a + 0.1 * b + 0.2 * c + noise(k)
            };
            (0..400).map(value).collect()
        };
        let columns = DMatrix::from_fn(400, 3, |row, column| regressor(step_s * row as f64)[column]);
        for (late_s, least_left, most_left) in [(0.0, 0.99, 1.0), (0.043, 0.0, 0.1), (-0.03, 0.0, 0.15)] {
            let values = coefficient(late_s);
            let (delay_s, left) = estimate_delay(&[(columns.clone(), &values)], step_s).unwrap();
            assert!((delay_s - late_s).abs() < 0.002, "{late_s}: {delay_s}");
            assert!((least_left..=most_left).contains(&left), "{late_s}: {left}");
        }
        assert!(estimate_delay(&[(columns, &coefficient(0.0))], 0.1).is_none());
    }
}
