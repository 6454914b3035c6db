//! One parameter that enters nonlinearly, such as the lag of an actuator.

use super::EstimateError;
use crate::optimise;

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
