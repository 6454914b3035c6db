//! Stated numbers that derivatives follow one to one, and that no flight shows wrong: mass and inertia.

use doublet_core::airframe::MassProperties;
use doublet_core::model::Coefficient;
use serde::Serialize;

use crate::notation::significant;
use crate::snapshot::Snapshot;
use crate::stage::{CoefficientFit, FuelRecord};

/// A number that the derivatives of a coefficient are proportional to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatedQuantity {
    /// Quantity: `mass`, `Ixx`, `Iyy`, `Izz`.
    pub quantity: &'static str,
    /// Its mean over the middles of the manoeuvres of the fit.
    pub value: f64,
    pub unit: &'static str,
    /// Source: `aircraft file`, or `aircraft file and recorded fuel`.
    pub source: &'static str,
    /// Change of every derivative, per cent, for one per cent more of it.
    pub percent_per_percent: f64,
}

impl std::fmt::Display for StatedQuantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} {}", self.quantity, significant(self.value, 4), self.unit)
    }
}

/// Mass properties of the manoeuvres of a fit: the mean over their middles; none before its coefficients are formed.
pub(super) fn mean_mass(snapshot: &Snapshot, fit: &CoefficientFit) -> Option<MassProperties> {
    let aero = fit.windows.iter().filter_map(|(window, _)| snapshot.windows.get(window)?.aero.ready());
    let flown = aero.map(|aero| &aero.data).filter(|data| !data.time_s.is_empty());
    let all: Vec<MassProperties> = flown.map(|data| *data.mass.at(data.time_s.len() / 2)).collect();
    let sum = all.iter().copied().reduce(|sum, mass| sum.plus(&mass))?;
    Some(sum.scaled((all.len() as f64).recip()))
}

/// The number that the derivatives of a fit follow one to one; none before its coefficients are formed.
pub fn stated_quantity(snapshot: &Snapshot, fit: &CoefficientFit) -> Option<StatedQuantity> {
    let mass = mean_mass(snapshot, fit)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inertia_of_a_small_aircraft_keeps_its_digits() {
        let of = |value| StatedQuantity {
            quantity: "Ixx",
            value,
            unit: "kg m2",
            source: "aircraft file",
            percent_per_percent: 1.0,
        };
        assert_eq!([of(0.31246).to_string(), of(2170.4).to_string()], ["Ixx 0.3125 kg m2", "Ixx 2170 kg m2"]);
    }
}
