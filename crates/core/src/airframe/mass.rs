//! Mass, centre of gravity and inertia.

use serde::Serialize;

use super::tensor::InertiaTensor;

/// Mass, centre of gravity and inertia of an aircraft, or a change of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of gravity in datum axes (x aft, y right, z up), m.
    pub cg_from_datum_m: [f64; 3],
    /// Inertia about the centre of gravity in body axes.
    #[serde(flatten)]
    pub inertia: InertiaTensor,
}

impl MassProperties {
    /// Sum of two, entry by entry: a nominal value and a change. Not the properties of two bodies joined.
    #[must_use]
    pub fn plus(&self, change: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + change.mass_kg,
            cg_from_datum_m: std::array::from_fn(|axis| self.cg_from_datum_m[axis] + change.cg_from_datum_m[axis]),
            inertia: self.inertia + change.inertia,
        }
    }

    /// Every entry times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            mass_kg: factor * self.mass_kg,
            cg_from_datum_m: self.cg_from_datum_m.map(|position_m| factor * position_m),
            inertia: self.inertia.scaled(factor),
        }
    }

    /// What there is here beyond `other`, entry by entry: the change that leads from `other` to this.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        self.plus(&other.scaled(-1.0))
    }
}
