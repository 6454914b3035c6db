//! That no derivative is good whose air density is assumed: all are inversely proportional to it.

use super::Finding;
use super::judge::Evidence;
use crate::session::Place;
use crate::stage::CoefficientFit;

/// The finding for the derivative `name` of a fit in whose windows the density is assumed.
pub(super) fn finding(
    evidence: Evidence<'_>,
    name: &str,
    window: Option<&str>,
    fit: &CoefficientFit,
) -> Option<Finding> {
    let mut formed = fit.windows.iter().filter_map(|(window, _)| evidence.snapshot.windows.get(window)?.aero.ready());
    let found = formed.find_map(|aero| aero.air_density.finding())?;
    Some(Finding { place: Place::derivative(name, window), ..found })
}
