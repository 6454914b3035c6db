//! One parameter that enters nonlinearly, such as the lag of an actuator.

use super::{EstimateError, Fit};
use crate::optimise;

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarSearch {
    /// Value with the smallest residual sum of squares.
    pub value: f64,
    /// Standard error from the curvature there, `sqrt(2 s^2 / J'')` with `J = v'v`; infinite at an end of the range.
    pub standard_error: f64,
    /// The fit there.
    pub fit: Fit,
}

/// Fraction of the range over which the curvature is taken.
const CURVATURE: f64 = 1e-3;
/// Minimises the residual sum of squares of `fit_at(value)` over `lower..=upper`: all other parameters are linear and solved
/// for inside (variable projection). The range is scanned coarsely, then refined by golden section about the best value.
///
/// # Errors
/// A range out of order, and the first error of a fit.
pub fn search_scalar<E: From<EstimateError>>(
    lower: f64,
    upper: f64,
    mut fit_at: impl FnMut(f64) -> Result<Fit, E>,
) -> Result<ScalarSearch, E> {
    let range = upper - lower;
    let mut cost = |value: f64| fit_at(value).map(|fit| square(&fit));
    let value = minimise(lower, upper, &mut cost)?.0;
    let reach = CURVATURE * range;
    let inside = value - reach > lower && value + reach < upper;
    let here = cost(value)?;
    let curvature =
        if inside { (cost(value + reach)? - 2.0 * here + cost(value - reach)?) / (reach * reach) } else { 0.0 };
    let fit = fit_at(value)?;
    let standard_error =
        if curvature > 0.0 { (2.0 * fit.residual_std.powi(2) / curvature).sqrt() } else { f64::INFINITY };
    Ok(ScalarSearch { value, standard_error, fit })
}

/// [`optimise::minimise`] over a range that is one.
pub(super) fn minimise<E: From<EstimateError>>(
    lower: f64,
    upper: f64,
    cost: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, Vec<(f64, f64)>), E> {
    if !(lower < upper && lower.is_finite() && upper.is_finite()) {
        let allowed = "a finite lower end below the upper one";
        return Err(EstimateError::Setting { setting: "range of the search".to_owned(), value: lower, allowed }.into());
    }
    optimise::minimise(lower, upper, cost)
}

/// Residual sum of squares.
fn square(fit: &Fit) -> f64 {
    fit.residuals.iter().map(|v| v * v).sum()
}
