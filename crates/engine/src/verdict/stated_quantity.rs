//! Stated numbers that derivatives follow one to one, and that no flight shows wrong: mass and inertia.

use doublet_core::model::Coefficient;
use serde::Serialize;

use crate::snapshot::Snapshot;
use crate::stage::{CoefficientFit, FuelRecord};

/// A number that the derivatives of a coefficient are proportional to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatedQuantity {
    /// Quantity: `mass`, `Ixx`, `Iyy`, `Izz`.
    pub quantity: &'static str,
    /// Its value in the first manoeuvre of the fit.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// Source: `aircraft file`, or `aircraft file and recorded fuel`.
    pub source: &'static str,
    /// Change of every derivative, per cent, for one per cent more of it.
    pub percent_per_percent: f64,
}

impl std::fmt::Display for StatedQuantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:.0} {}", self.quantity, self.value, self.unit)
    }
}

/// The number that the derivatives of a fit follow one to one; none before its coefficients are formed.
pub fn stated_quantity(snapshot: &Snapshot, fit: &CoefficientFit) -> Option<StatedQuantity> {
    let (window, _) = fit.windows.first()?;
    let aero = snapshot.windows.get(window)?.aero.ready()?;
    let mass = aero.data.mass.first()?;
    let (quantity, value, unit) = match fit.coefficient {
        Coefficient::Cl => ("Ixx", mass.inertia.xx, "kg m2"),
        Coefficient::Cm => ("Iyy", mass.inertia.yy, "kg m2"),
        Coefficient::Cn => ("Izz", mass.inertia.zz, "kg m2"),
        _ => ("mass", mass.mass_kg, "kg"),
    };
    let is_recorded =
        snapshot.flown.values().filter_map(|slot| slot.ready()).any(|flown| flown.fuel.record != FuelRecord::None);
    let source = if is_recorded { "aircraft file and recorded fuel" } else { "aircraft file" };
    Some(StatedQuantity { quantity, value, unit, source, percent_per_percent: 1.0 })
}
