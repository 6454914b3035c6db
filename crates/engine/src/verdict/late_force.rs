//! A side force that follows all its regressors late: accelerometers that are filtered, or on a late clock.
//!
//! The normal force does not show it: with a late one angle of attack and pitch rate explain it as well, by other derivatives.

use doublet_core::model::{Coefficient, Term, regressors};
use doublet_core::statistics::median_step;
use nalgebra::{DMatrix, DVector};

use super::fit::{moving_terms, used_windows};
use super::judge::Evidence;
use crate::session::Surface;
use crate::stage::WindowAero;

/// Range of delays looked at, s.
const RANGE_S: f64 = 0.12;
/// Longest interval of the samples between which a delay is still found, s.
const SLOWEST_S: f64 = 0.025;
/// Part of the residual's sum of squares that the delay leaves at most.
const LEFT: f64 = 0.95;

/// Delay of the side force behind its regressors, s, where it explains part of the residual. A rudder that is recorded early does as much:
/// then none.
pub(super) fn find_late_side_force(evidence: Evidence<'_>) -> Option<f64> {
    if evidence.delays.iter().any(|delay| delay.surface == Surface::Rudder) {
        return None;
    }
    let fits = &evidence.snapshot.pooled.ready()?.fits;
    let fit = fits.iter().find(|fit| fit.coefficient == Coefficient::CY)?;
    let terms = moving_terms(evidence.session, fit);
    let used = used_windows(evidence.session, evidence.snapshot, fit);
    let windows: Vec<&WindowAero> = used.iter().map(|used| used.aero).collect();
    let (delay_s, left) = estimate_delay(Coefficient::CY, &terms, &windows)?;
    (left < LEFT).then_some(delay_s)
}

/// Delay of a coefficient behind all its regressors, s, and the part of the residual's sum of squares that it leaves: fits
/// `C(t + d) = x(t)' b + c` over the windows for delays `d` of whole samples, with a constant `c` for each window, and takes the tip of the
/// parabola through the least sum of squares and its neighbours. None where samples are slow, windows short or regressors dependent.
fn estimate_delay(coefficient: Coefficient, terms: &[Term], windows: &[&WindowAero]) -> Option<(f64, f64)> {
    let step_s = windows.iter().filter_map(|aero| median_step(&aero.coefficients.time_s)).reduce(f64::max)?;
    if !(step_s > 0.0 && step_s <= SLOWEST_S) {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some samples")]
    let most = (RANGE_S / step_s).round() as usize;
    let mut normal = DMatrix::zeros(terms.len(), terms.len());
    let mut rows = Vec::with_capacity(windows.len());
    for aero in windows {
        let columns: DMatrix<f64> = regressors(terms, &aero.variables).ok()?;
        let count = columns.nrows().checked_sub(2 * most).filter(|count| *count > terms.len() + 1)?;
        let mut columns = columns.rows(most, count).into_owned();
        for mut column in columns.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        normal += columns.tr_mul(&columns);
        rows.push((columns, aero.coefficients.get(coefficient)));
    }
    let normal = normal.cholesky()?;
    let squares_at = |shift: usize| {
        let (mut projected, mut squares) = (DVector::zeros(terms.len()), 0.0);
        for (columns, values) in &rows {
            let late = DVector::from_column_slice(&values[shift..shift + columns.nrows()]);
            projected += columns.tr_mul(&late);
            squares += late.norm_squared() - late.sum() * late.mean();
        }
        squares - projected.dot(&normal.solve(&projected))
    };
    let squares: Vec<f64> = (0..=2 * most).map(squares_at).collect();
    let best = (0..squares.len()).min_by(|a, b| squares[*a].total_cmp(&squares[*b]))?;
    let (before, after) = (squares.get(best.checked_sub(1)?)?, squares.get(best + 1)?);
    let bend = before - 2.0 * squares[best] + after;
    let tip = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some(((best as f64 - most as f64 + tip) * step_s, squares[best] / squares[most].max(f64::MIN_POSITIVE)))
}
