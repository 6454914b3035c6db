//! Check of an aircraft's data.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use thiserror::Error;

use super::aircraft::Aircraft;
use super::inertia::{InertiaModel, OwnInertia};
use super::loading::{Loading, LoadingIssue};
use super::tensor::{InertiaError, PUBLISHED_SLACK};
use crate::quantity::in_words;

/// Something impossible in the data of an aircraft.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum AircraftError {
    /// A number is outside its range.
    #[error("{field} is {}, allowed is {allowed}", in_words(*.value))]
    OutOfRange { field: String, value: f64, allowed: String },
    #[error("{field} is '{name}', allowed is a name that is not empty and not used twice")]
    Name { field: String, name: String },
    /// No body can have this inertia.
    #[error("{field} is impossible: {reason}")]
    Inertia { field: String, reason: InertiaError },
    /// Something needed is missing.
    #[error("{field} is missing: {needed}")]
    Missing { field: String, needed: &'static str },
    /// The standard loading is impossible.
    #[error("loading: {0}")]
    Loading(LoadingIssue),
}

impl AircraftError {
    /// Key of what is wrong, as in the aircraft file.
    pub fn field(&self) -> &str {
        match self {
            Self::OutOfRange { field, .. }
            | Self::Name { field, .. }
            | Self::Inertia { field, .. }
            | Self::Missing { field, .. } => field,
            Self::Loading(_) => "loading",
        }
    }
}

/// Largest distance from the datum, and smallest and largest length accepted, m.
const LARGEST_LENGTH_M: f64 = 1_000.0;
const SMALLEST_LENGTH_M: f64 = 1.0e-3;
/// Smallest and largest mass accepted, kg: a part of a gram, and above every aircraft.
const SMALLEST_MASS_KG: f64 = 1.0e-3;
const LARGEST_MASS_KG: f64 = 2.0e6;
/// Smallest and largest reference area accepted, m².
const SMALLEST_AREA_M2: f64 = 1.0e-4;
const LARGEST_AREA_M2: f64 = 1.0e5;

/// Collects the errors of one aircraft.
#[derive(Default)]
struct Findings(Vec<AircraftError>);

impl Findings {
    /// Notes `value` unless it is `ok`; a comparison with a value that is not a number must come out false.
    fn require(&mut self, ok: bool, field: impl Into<String>, value: f64, allowed: impl Into<String>) {
        if !ok {
            self.0.push(AircraftError::OutOfRange { field: field.into(), value, allowed: allowed.into() });
        }
    }

    /// The length of something, m.
    fn length(&mut self, field: impl Into<String>, value: f64) {
        let ok = (SMALLEST_LENGTH_M..=LARGEST_LENGTH_M).contains(&value);
        self.require(ok, field, value, format!("{SMALLEST_LENGTH_M} to {LARGEST_LENGTH_M} m"));
    }

    /// The mass of something, kg.
    fn mass(&mut self, field: impl Into<String>, value: f64) {
        let ok = (SMALLEST_MASS_KG..=LARGEST_MASS_KG).contains(&value);
        self.require(ok, field, value, format!("{SMALLEST_MASS_KG} to {LARGEST_MASS_KG} kg"));
    }

    /// A coordinate, m.
    fn coordinate(&mut self, field: impl Into<String>, value: f64) {
        let ok = value.abs() <= LARGEST_LENGTH_M;
        self.require(ok, field, value, format!("-{LARGEST_LENGTH_M} to {LARGEST_LENGTH_M} m"));
    }

    /// A point, m from the datum.
    fn point(&mut self, field: &str, point: [f64; 3]) {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(point) {
            self.coordinate(format!("{field}.{axis}"), value);
        }
    }

    /// Names that must not be empty or repeat.
    fn names<'a>(&mut self, field: &str, names: impl Iterator<Item = &'a str>) {
        let mut seen = BTreeSet::new();
        for name in names {
            if name.trim().is_empty() || !seen.insert(name) {
                self.0.push(AircraftError::Name { field: format!("{field}.name"), name: name.to_owned() });
            }
        }
    }

    /// The shape of a part.
    fn shape(&mut self, field: &str, shape: &OwnInertia) {
        match *shape {
            OwnInertia::Point => {}
            OwnInertia::Given { tensor, at_mass_kg } => {
                self.mass(format!("{field}.at_mass_kg"), at_mass_kg);
                if let Err(reason) = tensor.check_part(PUBLISHED_SLACK) {
                    self.0.push(AircraftError::Inertia { field: field.to_owned(), reason });
                }
            }
            OwnInertia::Rod { length_m, .. } => self.length(format!("{field}.length_m"), length_m),
            OwnInertia::Cuboid { length_m, width_m, height_m } => {
                self.length(format!("{field}.length_m"), length_m);
                self.length(format!("{field}.width_m"), width_m);
                self.length(format!("{field}.height_m"), height_m);
            }
            OwnInertia::Propeller { radius_m } => self.length(format!("{field}.radius_m"), radius_m),
        }
    }
}

impl Aircraft {
    /// Checks everything the aircraft states, so that what follows from it is finite and possible.
    ///
    /// # Errors
    /// Every finding, each with field, value and allowed range.
    pub fn check(&self) -> Result<(), Vec<AircraftError>> {
        let mut findings = Findings::default();
        findings.names("aircraft", std::iter::once(self.name.as_str()));
        self.check_geometry(&mut findings);
        self.check_masses(&mut findings);
        self.check_envelope(&mut findings);
        self.check_stations(&mut findings);
        self.check_statistics(&mut findings);
        self.check_inertia(&mut findings);
        if findings.0.is_empty() { Ok(()) } else { Err(findings.0) }
    }

    fn check_geometry(&self, findings: &mut Findings) {
        let reference = &self.reference;
        let area = reference.area_m2;
        findings.require(
            (SMALLEST_AREA_M2..=LARGEST_AREA_M2).contains(&area),
            "reference.area_m2",
            area,
            format!("{SMALLEST_AREA_M2} to {LARGEST_AREA_M2} m2"),
        );
        findings.length("reference.span_m", reference.span_m);
        findings.length("reference.chord_m", reference.chord_m);
        findings.length("reference.lateral_moment_length_m", reference.lateral_moment_length_m);
        findings.length("reference.lateral_rate_length_m", reference.lateral_rate_length_m);
        findings.length("reference.pitch_rate_length_m", reference.pitch_rate_length_m);
        if let Some(chord) = &self.stated_mean_chord {
            findings.length("mean_chord.chord_m", chord.chord_m);
            findings.coordinate("mean_chord.leading_edge_x_m", chord.leading_edge_x_m);
            findings.coordinate("mean_chord.y_m", chord.y_m);
        }
        findings.names("wing_panel", self.wing_panels.iter().map(|panel| panel.name.as_str()));
        for panel in &self.wing_panels {
            let field = |name: &str| format!("wing_panel.{}.{name}", panel.name);
            findings.length(field("semispan_m"), panel.semispan_m);
            findings.length(field("root_chord_m"), panel.root_chord_m);
            let taper = panel.taper;
            findings.require((0.0..=10.0).contains(&taper), field("taper"), taper, "0 to 10");
            findings.coordinate(field("root_y_m"), panel.root_y_m);
            findings.coordinate(field("root_leading_edge_x_m"), panel.root_leading_edge_x_m);
            findings.coordinate(field("tip_leading_edge_x_m"), panel.tip_leading_edge_x_m);
        }
    }

    fn check_masses(&self, findings: &mut Findings) {
        findings.mass("mass.mass_kg", self.empty.mass_kg);
        findings.point("mass.cg_datum_m", self.empty.cg_from_datum_m);
        findings.names("fixed_item", self.fixed_items.iter().map(|item| item.name.as_str()));
        for item in &self.fixed_items {
            findings.mass(format!("fixed_item.{}.mass_kg", item.name), item.mass_kg);
            findings.point(&format!("fixed_item.{}.cg_datum_m", item.name), item.cg_from_datum_m);
        }
        findings.names("tank", self.tanks.iter().map(|tank| tank.name.as_str()));
        for tank in &self.tanks {
            let field = format!("tank.{}", tank.name);
            findings.mass(format!("{field}.capacity_kg"), tank.capacity_kg);
            let unusable = tank.unusable_kg;
            let range = format!("0 to its capacity of {} kg", tank.capacity_kg);
            let ok = (0.0..=tank.capacity_kg).contains(&unusable);
            findings.require(ok, format!("{field}.unusable_kg"), unusable, range);
            findings.point(&format!("{field}.cg_datum_m"), tank.cg_from_datum_m);
            findings.shape(&format!("{field}.inertia"), &tank.inertia);
        }
        for (kind, stations) in [("seat", &self.seats), ("luggage", &self.luggage)] {
            findings.names(kind, stations.iter().map(|station| station.name.as_str()));
            for station in stations {
                let field = format!("{kind}.{}", station.name);
                if let Some(capacity) = station.capacity_kg {
                    findings.mass(format!("{field}.capacity_kg"), capacity);
                }
                findings.point(&format!("{field}.cg_datum_m"), station.cg_from_datum_m);
                findings.shape(&format!("{field}.inertia"), &station.inertia);
            }
        }
        self.check_limits(findings);
        for (field, value, range, words) in self.flight_envelope.numbers() {
            if let Some(value) = value {
                findings.require(range.contains(&value), field, value, words);
            }
        }
        if let Some(stall) = self.stall {
            findings.mass("stall.mass_kg", stall.mass_kg);
            let (speed, ok) = (stall.calibrated_airspeed_m_s, 1.0..=150.0);
            findings.require(ok.contains(&speed), "stall.airspeed_m_s", speed, "1 to 150 m/s");
        }
    }

    fn check_limits(&self, findings: &mut Findings) {
        let fixed_kg = self.empty.mass_kg + self.fixed_items.iter().map(|item| item.mass_kg).sum::<f64>();
        let limits = [("max_takeoff_kg", self.limits.max_takeoff_kg), ("max_landing_kg", self.limits.max_landing_kg)];
        for (name, limit) in limits {
            if let Some(limit) = limit {
                let ok = limit >= fixed_kg && limit <= LARGEST_MASS_KG;
                findings.require(
                    ok,
                    format!("mass.{name}"),
                    limit,
                    format!("at least the empty mass of {fixed_kg} kg"),
                );
            }
        }
        if let (Some(takeoff), Some(landing)) = (self.limits.max_takeoff_kg, self.limits.max_landing_kg) {
            let range = format!("at most the maximum take-off mass of {takeoff} kg");
            findings.require(landing <= takeoff, "mass.max_landing_kg", landing, range);
        }
    }

    fn check_envelope(&self, findings: &mut Findings) {
        let Some(envelope) = &self.envelope else { return };
        let rows = &envelope.rows;
        findings.require(rows.len() >= 2, "envelope", rows.len() as f64, "two rows or more");
        for (index, row) in rows.iter().enumerate() {
            let field = |name: &str| format!("envelope[{index}].{name}");
            findings.mass(field("mass_kg"), row.mass_kg);
            findings.coordinate(field("forward_x_m"), row.forward_x_m);
            findings.coordinate(field("aft_x_m"), row.aft_x_m);
            let range = format!("behind forward_x_m = {}", row.forward_x_m);
            findings.require(row.aft_x_m > row.forward_x_m, field("aft_x_m"), row.aft_x_m, range);
            if let Some(before) = index.checked_sub(1).map(|before| rows[before]) {
                let range = format!("above {} kg, the row before", before.mass_kg);
                findings.require(row.mass_kg > before.mass_kg, field("mass_kg"), row.mass_kg, range);
            }
        }
    }

    fn check_stations(&self, findings: &mut Findings) {
        let points = [
            ("sensors.accelerometer_datum_m", self.sensors.accelerometer_from_datum_m),
            ("sensors.alpha_vane_datum_m", self.sensors.alpha_vane_from_datum_m),
            ("sensors.beta_vane_datum_m", self.sensors.beta_vane_from_datum_m),
            ("sensors.antenna_datum_m", self.sensors.antenna_from_datum_m),
            ("moment_reference.position_datum_m", self.moment_reference_from_datum_m),
        ];
        for (field, point) in points {
            if let Some(point) = point {
                findings.point(field, point);
            }
        }
        findings.names("engine", self.engines.iter().map(|engine| engine.name.as_str()));
        for engine in &self.engines {
            findings.point(&format!("engine.{}.position_datum_m", engine.name), engine.position_from_datum_m);
            let ok = engine.incidence_rad.abs() <= FRAC_PI_2;
            let field = format!("engine.{}.incidence", engine.name);
            findings.require(ok, field, engine.incidence_rad, "-pi/2 to pi/2 rad");
        }
        if let Some(wheels) = &self.wheels {
            findings.coordinate("wheels.nose_x_m", wheels.nose_x_m);
            findings.coordinate("wheels.main_x_m", wheels.main_x_m);
            findings.length("wheels.main_y_m", wheels.main_y_m);
            let range = format!("behind nose_x_m = {}", wheels.nose_x_m);
            findings.require(wheels.main_x_m > wheels.nose_x_m, "wheels.main_x_m", wheels.main_x_m, range);
        }
    }

    fn check_statistics(&self, findings: &mut Findings) {
        findings.names("component_fraction", self.component_fractions.iter().map(|part| part.name.as_str()));
        for part in &self.component_fractions {
            let field = |name: &str| format!("component_fraction.{}.{name}", part.name);
            findings.mass(field("attributed_kg"), part.attributed_kg);
            let values = [("mean", part.mean), ("deviation", part.deviation)];
            let methods = part.methods.iter().map(|(name, value)| (name.as_str(), *value));
            for (name, value) in values.into_iter().chain(methods) {
                findings.require((0.0..=1.0).contains(&value), field(name), value, "0 to 1");
            }
        }
        if let Some(radii) = &self.gyration_radii {
            findings.length("gyration_radii.length_m", radii.length_m);
            for (name, value) in [("x", radii.x), ("y", radii.y), ("z", radii.z)] {
                let ok = (1e-3..=1.0).contains(&value);
                findings.require(ok, format!("gyration_radii.{name}"), value, "0.001 to 1");
            }
        }
    }

    fn check_inertia(&self, findings: &mut Findings) {
        match &self.inertia {
            InertiaModel::Constant(tensor) => {
                if let Err(reason) = tensor.check() {
                    findings.0.push(AircraftError::Inertia { field: "inertia".to_owned(), reason });
                }
            }
            InertiaModel::Groups { groups, .. } => {
                if groups.is_empty() {
                    let needed = "the moments of inertia, or component groups, of the empty aircraft";
                    findings.0.push(AircraftError::Missing { field: "inertia".to_owned(), needed });
                }
                findings.names("inertia.group", groups.iter().map(|group| group.name.as_str()));
                for group in groups {
                    let field = format!("inertia.group.{}", group.name);
                    findings.mass(format!("{field}.mass_kg"), group.mass_kg);
                    findings.point(&format!("{field}.centroid_datum_m"), group.centroid_from_datum_m);
                    findings.shape(&format!("{field}.inertia"), &group.inertia);
                }
            }
        }
        // What follows from sound parts only is worth a message of its own.
        if !findings.0.is_empty() {
            return;
        }
        for (field, loading) in [("inertia", &Loading::default()), ("loading", &self.standard_loading)] {
            let properties = loading.mass_properties(self);
            if let Err(reason) = properties.inertia.check() {
                findings.0.push(AircraftError::Inertia { field: field.to_owned(), reason });
            }
            findings.0.extend(
                loading
                    .issues(self, &properties)
                    .into_iter()
                    .filter(LoadingIssue::is_impossible)
                    .map(AircraftError::Loading),
            );
        }
    }
}
