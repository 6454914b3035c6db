//! One parameter that enters nonlinearly, such as the lag of an actuator.

use super::{EstimateError, Fit};

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

/// Values tried before the best is refined, so that a second valley is not missed.
const COARSE: usize = 21;
/// Fraction of the range at which the refinement stops.
const RESOLUTION: f64 = 1e-6;
/// Fraction of the range over which the curvature is taken.
const CURVATURE: f64 = 1e-3;
/// Ratio of the golden section, `(sqrt(5) - 1) / 2`.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

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

/// Value of the smallest cost in `lower..=upper`, and the costs of the coarse scan.
pub(super) fn minimise<E: From<EstimateError>>(
    lower: f64,
    upper: f64,
    cost: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, Vec<(f64, f64)>), E> {
    if !(lower < upper && lower.is_finite() && upper.is_finite()) {
        let allowed = "a finite lower end below the upper one";
        return Err(EstimateError::Setting { setting: "range of the search".to_owned(), value: lower, allowed }.into());
    }
    let range = upper - lower;
    let step = range / (COARSE - 1) as f64;
    let mut scan = Vec::with_capacity(COARSE);
    for index in 0..COARSE {
        let value = lower + step * index as f64;
        scan.push((value, cost(value)?));
    }
    let best =
        scan.iter().copied().fold((lower, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
    let (mut left, mut right) = ((best.0 - step).max(lower), (best.0 + step).min(upper));
    let (mut low, mut high) = (right - GOLDEN * (right - left), left + GOLDEN * (right - left));
    let (mut cost_low, mut cost_high) = (cost(low)?, cost(high)?);
    while right - left > RESOLUTION * range {
        if cost_low <= cost_high {
            (right, high, cost_high) = (high, low, cost_low);
            low = right - GOLDEN * (right - left);
            cost_low = cost(low)?;
        } else {
            (left, low, cost_low) = (low, high, cost_high);
            high = left + GOLDEN * (right - left);
            cost_high = cost(high)?;
        }
    }
    // An end of the range is not approached by bisection: take it where it is better.
    let mut value = 0.5 * (left + right);
    for end in [lower, upper] {
        if cost(end)? < cost(value)? {
            value = end;
        }
    }
    Ok((value, scan))
}

/// Residual sum of squares.
fn square(fit: &Fit) -> f64 {
    fit.residuals.iter().map(|v| v * v).sum()
}
