//! Quantities that carry an uncertainty, and what changes with them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::airframe::{Aircraft, InertiaTensor, Loading, MassProperties};
use crate::model::AeroData;
use crate::quantity::Role;

/// A quantity the derivatives are computed with.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Centre of gravity along datum x (aft).
    CgX,
    /// Centre of gravity along datum y (right).
    CgY,
    /// Centre of gravity along datum z (up).
    CgZ,
    /// Moment of inertia about body x.
    Ixx,
    /// Moment of inertia about body y.
    Iyy,
    /// Moment of inertia about body z.
    Izz,
    /// Product of inertia, integral of x z dm.
    Ixz,
    /// Scale of the elevator deflection.
    ElevatorScale,
    /// Scale of the aileron deflection.
    AileronScale,
    /// Scale of the rudder deflection.
    RudderScale,
    /// Scale of the angle of attack.
    AlphaScale,
    /// Scale of the angle of sideslip.
    BetaScale,
    /// Fuel in the tanks of one name, left and right together.
    Fuel(String),
}

/// Quantities one table shows together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum QuantityGroup {
    /// Centre of gravity and inertia (thesis Tables 7.2-7.4).
    CentreOfGravityAndInertia,
    /// Deflections (Table 7.5).
    Deflections,
    /// Air angles (Table 7.6).
    AirAngles,
    /// Fuel mass (Tables 7.7-7.12).
    Fuel,
}

/// A quantity with its value and the half width of its central difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Quantity.
    pub quantity: Quantity,
    /// Value, in the unit of the quantity; 100 for a scale in per cent. A centre of gravity counts from the leading edge of the
    /// mean chord along x, from the datum along y and z.
    pub nominal: f64,
    /// Half width of the central difference, in the unit of the quantity.
    pub half_width: f64,
}

impl QuantityGroup {
    crate::variant_texts! {
        /// Heading in tables.
        pub name:
            CentreOfGravityAndInertia "centre of gravity and inertia", Deflections "control deflections",
            AirAngles "air angles", Fuel "fuel mass",
    }
}

impl Quantity {
    /// Name in tables and files.
    pub fn name(&self) -> String {
        match self {
            Self::CgX => "x_cg".to_owned(),
            Self::CgY => "y_cg".to_owned(),
            Self::CgZ => "z_cg".to_owned(),
            Self::Ixx => "Ixx".to_owned(),
            Self::Iyy => "Iyy".to_owned(),
            Self::Izz => "Izz".to_owned(),
            Self::Ixz => "Ixz".to_owned(),
            Self::ElevatorScale => "delta_e".to_owned(),
            Self::AileronScale => "delta_a".to_owned(),
            Self::RudderScale => "delta_r".to_owned(),
            Self::AlphaScale => "alpha".to_owned(),
            Self::BetaScale => "beta".to_owned(),
            Self::Fuel(tanks) => format!("fuel {tanks}"),
        }
    }

    /// Unit of its value, its step and of what derivatives change per: per cent of the reference chord for the centre of gravity
    /// and per cent of the recorded value for a scale, as in the thesis.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::CgX | Self::CgY | Self::CgZ => "% MAC",
            Self::Ixx | Self::Iyy | Self::Izz | Self::Ixz => "kg m2",
            Self::Fuel(_) => "kg",
            _ => "%",
        }
    }

    /// Table it belongs to.
    pub fn group(&self) -> QuantityGroup {
        match self {
            Self::ElevatorScale | Self::AileronScale | Self::RudderScale => QuantityGroup::Deflections,
            Self::AlphaScale | Self::BetaScale => QuantityGroup::AirAngles,
            Self::Fuel(_) => QuantityGroup::Fuel,
            _ => QuantityGroup::CentreOfGravityAndInertia,
        }
    }

    /// What a change of `change` (unit of [`Quantity::unit`]) adds to mass, centre of gravity and inertia; `None` for a scale.
    ///
    /// A centre of gravity that lies elsewhere moves the point the inertia is about while every part stays in its place, as in
    /// the thesis; fuel changes mass, centre of gravity and inertia together.
    pub fn mass_change(&self, aircraft: &Aircraft, loading: &Loading, change: f64) -> Option<MassProperties> {
        let nothing = MassProperties::default();
        let of_tensor = |inertia| MassProperties { inertia, ..nothing };
        let shift_cg = |axis: usize| Self::shift_cg(aircraft, loading, change, axis);
        Some(match self {
            Self::CgX => shift_cg(0),
            Self::CgY => shift_cg(1),
            Self::CgZ => shift_cg(2),
            Self::Ixx => of_tensor(InertiaTensor { xx: change, ..nothing.inertia }),
            Self::Iyy => of_tensor(InertiaTensor { yy: change, ..nothing.inertia }),
            Self::Izz => of_tensor(InertiaTensor { zz: change, ..nothing.inertia }),
            Self::Ixz => of_tensor(InertiaTensor { xz: change, ..nothing.inertia }),
            Self::Fuel(tanks) => {
                let mut changed = loading.clone();
                let total = fuel_of(loading, tanks);
                for (name, fuel) in &mut changed.fuel_kg {
                    if tank_group(name) == *tanks {
                        *fuel *= 1.0 + change / total;
                    }
                }
                changed.mass_properties(aircraft).minus(&loading.mass_properties(aircraft))
            }
            _ => return None,
        })
    }

    fn shift_cg(aircraft: &Aircraft, loading: &Loading, change: f64, axis: usize) -> MassProperties {
        let properties = loading.mass_properties(aircraft);
        let mut shift = [0.0; 3];
        shift[axis] = change / 100.0 * aircraft.reference.chord_m;
        let point = std::array::from_fn(|axis| properties.cg_from_datum_m[axis] + shift[axis]);
        let (there, here) = (loading.inertia_about(aircraft, point), properties.inertia);
        MassProperties { inertia: there + here.scaled(-1.0), cg_from_datum_m: shift, ..MassProperties::default() }
    }

    /// `data` with the recorded signal scaled by `1 + change / 100`; unchanged for a quantity that is not a scale.
    #[must_use]
    pub fn scaled(&self, data: &AeroData, change: f64) -> AeroData {
        let mut data = data.clone();
        let factor = 1.0 + change / 100.0;
        let column = match self {
            Self::ElevatorScale => data.controls.get_mut(&Role::Elevator),
            Self::AileronScale => data.controls.get_mut(&Role::Aileron),
            Self::RudderScale => data.controls.get_mut(&Role::Rudder),
            Self::AlphaScale => Some(&mut data.alpha_rad),
            Self::BetaScale => Some(&mut data.beta_rad),
            _ => None,
        };
        if let Some(column) = column {
            Arc::make_mut(column).iter_mut().for_each(|value| *value *= factor);
        }
        data
    }
}

/// All quantities of an aircraft with `loading` on board, each with its value and a step of `fraction` of it; of the centre of
/// gravity that fraction of the reference chord. Tanks without fuel have no step.
pub fn quantities(aircraft: &Aircraft, loading: &Loading, fraction: f64) -> Vec<Step> {
    let properties = loading.mass_properties(aircraft);
    let leading_edge_x_m = aircraft.mean_chord().map_or(0.0, |chord| chord.leading_edge_x_m);
    let [x, y, z] = properties.cg_from_datum_m;
    let [x, y, z] = [x - leading_edge_x_m, y, z].map(|metres| 100.0 * metres / aircraft.reference.chord_m);
    let inertia = properties.inertia;
    let percent = 100.0 * fraction;
    let step = |quantity, nominal, half_width| Step { quantity, nominal, half_width };
    let relative = |quantity, nominal: f64| step(quantity, nominal, fraction * nominal.abs());
    let mut steps = vec![
        step(Quantity::CgX, x, percent),
        step(Quantity::CgY, y, percent),
        step(Quantity::CgZ, z, percent),
        relative(Quantity::Ixx, inertia.xx),
        relative(Quantity::Iyy, inertia.yy),
        relative(Quantity::Izz, inertia.zz),
        relative(Quantity::Ixz, inertia.xz),
        relative(Quantity::ElevatorScale, 100.0),
        relative(Quantity::AileronScale, 100.0),
        relative(Quantity::RudderScale, 100.0),
        relative(Quantity::AlphaScale, 100.0),
        relative(Quantity::BetaScale, 100.0),
    ];
    let groups: BTreeMap<String, ()> = aircraft.tanks.iter().map(|tank| (tank_group(&tank.name), ())).collect();
    steps.extend(groups.into_keys().map(|tanks| {
        let fuel = fuel_of(loading, &tanks);
        relative(Quantity::Fuel(tanks), fuel)
    }));
    steps.retain(|step| step.half_width > 0.0);
    steps
}

/// Fuel in the tanks of one group, kg.
fn fuel_of(loading: &Loading, tanks: &str) -> f64 {
    loading.fuel_kg.iter().filter(|(name, _)| tank_group(name) == tanks).map(|(_, fuel)| fuel).sum()
}

/// Name of a tank without its side: fuel of a left and a right tank is uncertain together.
fn tank_group(name: &str) -> String {
    let kept: Vec<&str> = name.split_whitespace().filter(|word| !matches!(*word, "left" | "right")).collect();
    if kept.is_empty() { name.to_owned() } else { kept.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tanks_of_both_sides_are_one_group() {
        assert_eq!(tank_group("main left"), "main");
        assert_eq!(tank_group("auxiliary right"), "auxiliary");
        assert_eq!(tank_group("left"), "left");
    }
}
