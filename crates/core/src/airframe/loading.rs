//! What is on board, and the mass properties that follow.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::MassProperties;
use super::aircraft::{Aircraft, FixedItem, FuelBookkeeping};
use super::envelope::EnvelopeSide;
use super::frames::body_from_datum;
use super::inertia::OwnInertia;
use super::tensor::InertiaTensor;

/// What is on board. Masses in kg by the name of their place; what is not named is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Loading {
    /// Fuel of each tank.
    pub fuel_kg: BTreeMap<String, f64>,
    /// Occupant of each seat.
    pub seats_kg: BTreeMap<String, f64>,
    /// Load of each luggage bay.
    pub luggage_kg: BTreeMap<String, f64>,
    /// Anything else, as point masses.
    #[serde(rename = "item", skip_serializing_if = "Vec::is_empty")]
    pub added_items: Vec<FixedItem>,
}

crate::hash_fields!(Loading { added_items; fuel_kg, seats_kg, luggage_kg });

/// Something wrong with a loading, bound to the field it shows beside.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum LoadingIssue {
    /// A mass is negative or not a number; it counts as zero.
    #[error("{field} is {mass_kg} kg, allowed is 0 or more; it counts as 0")]
    NotAMass { field: String, mass_kg: f64 },
    /// A tank, seat or bay holds more than it can.
    #[error("{field} is {mass_kg} kg, allowed is at most {capacity_kg} kg")]
    OverCapacity { field: String, mass_kg: f64, capacity_kg: f64 },
    #[error("{field} has a mass but the aircraft has no such place; it does not count")]
    UnknownPlace { field: String },
    #[error("the position of {field} is not a number; the item does not count")]
    NotAPosition { field: String },
    #[error("mass is {mass_kg:.1} kg, the maximum take-off mass is {limit_kg:.1} kg: {:.1} kg too much", mass_kg - limit_kg)]
    OverTakeoffMass { mass_kg: f64, limit_kg: f64 },
    #[error("mass is {mass_kg:.1} kg, the maximum landing mass is {limit_kg:.1} kg: {:.1} kg to burn before landing", mass_kg - limit_kg)]
    OverLandingMass { mass_kg: f64, limit_kg: f64 },
    #[error("centre of gravity is {x_m:.3} m aft of the datum, {:.1} cm beyond the {side} limit of {limit_m:.3} m", (x_m - limit_m).abs() * 100.0)]
    OutsideEnvelope { side: EnvelopeSide, x_m: f64, limit_m: f64 },
}

impl LoadingIssue {
    /// Whether no aircraft could be loaded so, rather than none should fly so.
    pub fn is_impossible(&self) -> bool {
        !matches!(self, Self::OverTakeoffMass { .. } | Self::OverLandingMass { .. } | Self::OutsideEnvelope { .. })
    }

    /// Dotted name of the field the message belongs beside: `fuel_kg.<tank>`, `seats_kg.<seat>`, `luggage_kg.<bay>`,
    /// `added_items.<name>`, `mass` or `cg`.
    pub fn field(&self) -> &str {
        match self {
            Self::NotAMass { field, .. }
            | Self::OverCapacity { field, .. }
            | Self::UnknownPlace { field }
            | Self::NotAPosition { field } => field,
            Self::OverTakeoffMass { .. } | Self::OverLandingMass { .. } => "mass",
            Self::OutsideEnvelope { .. } => "cg",
        }
    }
}

/// A mass that can be one: negative and not finite ones count as zero.
fn counted(mass_kg: f64) -> f64 {
    if mass_kg.is_finite() { mass_kg.max(0.0) } else { 0.0 }
}

impl Loading {
    /// Calls `visit` with mass (kg), position (m from the datum) and shape of everything that adds to the empty aircraft.
    fn visit_masses(&self, aircraft: &Aircraft, mut visit: impl FnMut(f64, [f64; 3], &OwnInertia)) {
        let mass_of = |masses: &BTreeMap<String, f64>, name: &str| masses.get(name).copied().map_or(0.0, counted);
        for item in &aircraft.fixed_items {
            visit(item.mass_kg, item.cg_from_datum_m, &OwnInertia::Point);
        }
        for tank in &aircraft.tanks {
            let fuel_kg = mass_of(&self.fuel_kg, &tank.name);
            let added_kg = match aircraft.fuel_bookkeeping {
                FuelBookkeeping::AddAll => fuel_kg,
                FuelBookkeeping::AddUsable => (fuel_kg - tank.unusable_kg).max(0.0),
            };
            visit(added_kg, tank.cg_from_datum_m, &tank.inertia);
        }
        for (stations, masses) in [(&aircraft.seats, &self.seats_kg), (&aircraft.luggage, &self.luggage_kg)] {
            for station in stations {
                visit(mass_of(masses, &station.name), station.cg_from_datum_m, &station.inertia);
            }
        }
        for item in &self.added_items {
            if item.cg_from_datum_m.iter().all(|x| x.is_finite()) {
                visit(counted(item.mass_kg), item.cg_from_datum_m, &OwnInertia::Point);
            }
        }
    }

    /// Mass, centre of gravity and inertia of `aircraft` with this on board; [`Self::issues`] tells what is wrong with it.
    ///
    /// `m = sum m_i`, `r_cg = sum m_i r_i / m` (thesis Eq. 5.3); each part's inertia about its own centroid moved to the
    /// centre of gravity (Eq. 5.8-5.9). The empty aircraft's component groups are moved to the centre of gravity of the mass
    /// model, as the thesis does, also where their own centroid differs from the weighed one. Takes about a microsecond and does not
    /// allocate.
    pub fn mass_properties(&self, aircraft: &Aircraft) -> MassProperties {
        let empty = &aircraft.empty;
        let mut mass_kg = empty.mass_kg;
        let mut moment = empty.cg_from_datum_m.map(|x| x * empty.mass_kg);
        self.visit_masses(aircraft, |m, position, _| {
            mass_kg += m;
            for (sum, x) in moment.iter_mut().zip(position) {
                *sum += m * x;
            }
        });
        let cg_from_datum_m = moment.map(|sum| sum / mass_kg);
        MassProperties { mass_kg, cg_from_datum_m, inertia: self.inertia_about(aircraft, cg_from_datum_m) }
    }

    /// What is wrong with this on board of `aircraft`, whose mass properties it makes `loaded`; each bound to its field.
    pub fn issues(&self, aircraft: &Aircraft, loaded: &MassProperties) -> Vec<LoadingIssue> {
        let mut issues = self.place_issues(aircraft);
        limit_issues(aircraft, loaded.mass_kg, loaded.cg_from_datum_m[0], &mut issues);
        issues
    }

    /// Inertia of `aircraft` with this on board about any point (m, datum axes), body axes: that of the centre of gravity if it
    /// lay there, with every part staying where it is.
    pub(crate) fn inertia_about(&self, aircraft: &Aircraft, point_from_datum_m: [f64; 3]) -> InertiaTensor {
        let mut inertia = aircraft.inertia.about(&aircraft.empty, point_from_datum_m);
        self.visit_masses(aircraft, |m, position, shape| {
            inertia += shape.tensor(m) + InertiaTensor::point_mass(m, body_from_datum(position, point_from_datum_m));
        });
        inertia
    }

    /// Masses that cannot be, exceed what their place holds, or name a place the aircraft has not.
    fn place_issues(&self, aircraft: &Aircraft) -> Vec<LoadingIssue> {
        let mut issues = Vec::new();
        for (name, &mass_kg) in &self.fuel_kg {
            let tank = aircraft.tanks.iter().find(|tank| tank.name == *name);
            Self::examine_mass(&mut issues, "fuel_kg", name, mass_kg, tank.map(|tank| Some(tank.capacity_kg)));
        }
        for (kind, stations, masses) in
            [("seats_kg", &aircraft.seats, &self.seats_kg), ("luggage_kg", &aircraft.luggage, &self.luggage_kg)]
        {
            for (name, &mass_kg) in masses {
                let station = stations.iter().find(|station| station.name == *name);
                Self::examine_mass(&mut issues, kind, name, mass_kg, station.map(|station| station.capacity_kg));
            }
        }
        for item in &self.added_items {
            Self::examine_mass(&mut issues, "added_items", &item.name, item.mass_kg, Some(None));
        }
        let misplaced = self.added_items.iter().filter(|item| !item.cg_from_datum_m.iter().all(|x| x.is_finite()));
        issues.extend(misplaced.map(|item| LoadingIssue::NotAPosition { field: format!("added_items.{}", item.name) }));
        issues
    }

    /// `capacity_kg` is none of a place that the aircraft has not, and holds none where anything may be loaded.
    fn examine_mass(
        issues: &mut Vec<LoadingIssue>,
        kind: &str,
        name: &str,
        mass_kg: f64,
        capacity_kg: Option<Option<f64>>,
    ) {
        let field = || format!("{kind}.{name}");
        if !(mass_kg.is_finite() && mass_kg >= 0.0) {
            issues.push(LoadingIssue::NotAMass { field: field(), mass_kg });
        }
        match capacity_kg {
            None => issues.push(LoadingIssue::UnknownPlace { field: field() }),
            Some(Some(capacity_kg)) if mass_kg > capacity_kg => {
                issues.push(LoadingIssue::OverCapacity { field: field(), mass_kg, capacity_kg });
            }
            Some(_) => {}
        }
    }
}

/// Adds what `aircraft` allows neither in mass nor in centre of gravity.
fn limit_issues(aircraft: &Aircraft, mass_kg: f64, x_m: f64, issues: &mut Vec<LoadingIssue>) {
    let limits = &aircraft.limits;
    if let Some(limit_kg) = limits.max_takeoff_kg.filter(|&limit| mass_kg > limit) {
        issues.push(LoadingIssue::OverTakeoffMass { mass_kg, limit_kg });
    }
    if let Some(limit_kg) = limits.max_landing_kg.filter(|&limit| mass_kg > limit) {
        issues.push(LoadingIssue::OverLandingMass { mass_kg, limit_kg });
    }
    let margin = aircraft.envelope.as_ref().and_then(|envelope| envelope.margin(mass_kg, x_m));
    if let Some(margin) = margin.filter(|margin| margin.nearest_m() < 0.0) {
        let limit_m = match margin.side {
            EnvelopeSide::Forward => x_m - margin.forward_m,
            EnvelopeSide::Aft => x_m + margin.aft_m,
        };
        issues.push(LoadingIssue::OutsideEnvelope { side: margin.side, x_m, limit_m });
    }
}
