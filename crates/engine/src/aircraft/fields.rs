//! The numbers of an aircraft that can be edited, each with the key of the aircraft file it goes to.

use doublet_core::airframe::{Aircraft, InertiaModel, InertiaTensor, OwnInertia};
use doublet_core::quantity::Dimension;

use crate::session::{AircraftChanges, ChangedValue, ENVELOPE};

/// Part of an aircraft file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Section {
    /// Reference geometry, mean chord, wing.
    #[default]
    Geometry,
    /// Mass and centre of gravity of the empty aircraft, fixed items, limits of mass.
    Mass,
    /// Inertia of the empty aircraft, whole or by groups.
    Inertia,
    /// Tanks, seats, luggage bays.
    Stations,
    /// Places of sensors and engines, the point that moments are about, wheels.
    Places,
    /// Limits of flight and of the centre of gravity.
    Limits,
}

/// Unit of a field of an aircraft file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldUnit {
    /// The SI unit of a dimension, shown in the unit of the user's choice.
    Of(Dimension),
    /// m².
    Area,
    /// kg m².
    Inertia,
    /// Degrees, in the file too.
    Degrees,
}

/// What stands at a place of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PlaceKind {
    /// The centre of gravity of the empty aircraft.
    Empty,
    /// A fixed item.
    Fixed,
    /// The centroid of a group of components.
    Group,
    Tank,
    Seat,
    /// A luggage bay.
    Luggage,
    Engine,
    Sensor,
    /// The point that moment coefficients are about.
    Reference,
}

/// A number or a triple of an aircraft file.
#[derive(Clone, Debug, PartialEq)]
pub struct AircraftField {
    /// Its key, as in [`AircraftChanges`].
    pub key: String,
    /// Part of the file.
    pub section: Section,
    /// What has it: `tank main right`; empty for what a section has once.
    pub owner: String,
    pub name: &'static str,
    pub unit: FieldUnit,
    /// Its value; `None` for what is not stated.
    pub value: Option<ChangedValue>,
    /// What it is set to first where it is not stated.
    pub proposal: ChangedValue,
    /// What stands there, where it is a place in datum axes.
    pub place: Option<PlaceKind>,
    /// Whether the session changes it.
    pub changed: bool,
}

impl PlaceKind {
    doublet_core::variant_texts! {
        /// Its name in the file's words.
        pub name:
            Empty "empty", Fixed "fixed item", Group "inertia group", Tank "tank", Seat "seat", Luggage "luggage",
            Engine "engine", Sensor "sensor", Reference "moment reference",
    }

    /// Key of the list of the file that holds its entries, where they can be made and left out.
    pub fn list(self) -> Option<&'static str> {
        match self {
            Self::Tank => Some("tank"),
            Self::Seat => Some("seat"),
            Self::Luggage => Some("luggage"),
            Self::Fixed => Some("fixed_item"),
            _ => None,
        }
    }
}

impl AircraftField {
    /// The key of what has it, to leave it out; `None` where that cannot be.
    pub fn owner_key(&self) -> Option<&str> {
        self.place?.list()?;
        self.key.rsplit_once('.').map(|(owner, _)| owner)
    }

    /// What it is, with what has it.
    pub fn title(&self) -> String {
        if self.owner.is_empty() { self.name.to_owned() } else { format!("{} {}", self.owner, self.name) }
    }
}

/// Every number of an aircraft, with what the session changes in the place of what was read last: a value that cannot be is shown too.
pub fn fields(aircraft: &Aircraft, changes: &AircraftChanges) -> Vec<AircraftField> {
    let mut list = List { fields: Vec::new(), changes, middle: aircraft.empty.cg_from_datum_m };
    list.geometry(aircraft);
    list.masses(aircraft);
    list.inertia(aircraft);
    list.stations(aircraft);
    list.places(aircraft);
    list.limits(aircraft);
    list.fields
}

/// A unit and a part, to say once for several fields.
const LENGTH: FieldUnit = FieldUnit::Of(Dimension::Length);
const MASS: FieldUnit = FieldUnit::Of(Dimension::Mass);
const SPEED: FieldUnit = FieldUnit::Of(Dimension::Speed);
const NUMBER: FieldUnit = FieldUnit::Of(Dimension::Dimensionless);

/// Fields gathered so far.
struct List<'a> {
    fields: Vec<AircraftField>,
    changes: &'a AircraftChanges,
    middle: [f64; 3],
}

impl List<'_> {
    fn add(&mut self, field: AircraftField) {
        let change = self.changes.get(&field.key).cloned();
        let changed = change.is_some();
        let value = change.filter(|value| *value != ChangedValue::Removed).or(field.value);
        self.fields.push(AircraftField { value, changed, ..field });
    }

    /// A number; one that is not stated begins with `first`.
    fn number(
        &mut self,
        section: Section,
        (key, owner, name): (&str, &str, &'static str),
        unit: FieldUnit,
        (value, first): (Option<f64>, f64),
    ) {
        let (value, proposal) = (value.map(ChangedValue::Number), ChangedValue::Number(first));
        let (key, owner) = (key.to_owned(), owner.to_owned());
        self.add(AircraftField { key, section, owner, name, unit, value, proposal, place: None, changed: false });
    }

    /// A place; one that is not stated begins at the empty centre of gravity.
    fn add_position(
        &mut self,
        section: Section,
        (key, owner, name): (&str, &str, &'static str),
        kind: PlaceKind,
        value: Option<[f64; 3]>,
    ) {
        let (value, proposal) = (value.map(ChangedValue::Triple), ChangedValue::Triple(self.middle));
        let (key, owner, place) = (key.to_owned(), owner.to_owned(), Some(kind));
        self.add(AircraftField { key, section, owner, name, unit: LENGTH, value, proposal, place, changed: false });
    }

    /// Moments of inertia about the three axes.
    fn moments(&mut self, section: Section, (key, owner): (&str, &str), tensor: &InertiaTensor) {
        let value = ChangedValue::Triple([tensor.xx, tensor.yy, tensor.zz]);
        self.add(AircraftField {
            key: key.to_owned(),
            section,
            owner: owner.to_owned(),
            name: "moments",
            unit: FieldUnit::Inertia,
            value: Some(value.clone()),
            proposal: value,
            place: None,
            changed: false,
        });
    }

    /// What makes the inertia of a part.
    fn shape(&mut self, section: Section, (key, owner): (&str, &str), shape: &OwnInertia) {
        let mut length = |form: &str, name: &'static str, key_name: &str, value: f64| {
            let key = format!("{key}.inertia.{form}.{key_name}");
            self.number(section, (&key, owner, name), LENGTH, (Some(value), value));
        };
        match shape {
            OwnInertia::Point => {}
            OwnInertia::Rod { length_m, .. } => length("rod", "length of the rod", "length_m", *length_m),
            OwnInertia::Propeller { radius_m } => length("propeller", "radius of the propeller", "radius_m", *radius_m),
            OwnInertia::Cuboid { length_m, width_m, height_m } => {
                length("cuboid", "extent along x", "length_m", *length_m);
                length("cuboid", "extent along y", "width_m", *width_m);
                length("cuboid", "extent along z", "height_m", *height_m);
            }
            OwnInertia::Given { tensor, .. } => {
                self.moments(section, (&format!("{key}.inertia.given.moments_kg_m2"), owner), tensor);
            }
        }
    }

    fn geometry(&mut self, aircraft: &Aircraft) {
        let part = Section::Geometry;
        let reference = &aircraft.reference;
        self.number(
            part,
            ("reference.area_m2", "", "reference area S"),
            FieldUnit::Area,
            (Some(reference.area_m2), 1.0),
        );
        for (key, name, value) in [
            ("reference.span_m", "span b", reference.span_m),
            ("reference.chord_m", "chord c", reference.chord_m),
            ("reference.lateral_moment_length_m", "length in Cl and Cn", reference.lateral_moment_length_m),
            ("reference.lateral_rate_length_m", "length for p and r", reference.lateral_rate_length_m),
            ("reference.pitch_rate_length_m", "length for q", reference.pitch_rate_length_m),
        ] {
            self.number(part, (key, "", name), LENGTH, (Some(value), value));
        }
        if let Some(chord) = &aircraft.stated_mean_chord {
            for (key, name, value) in [
                ("mean_chord.leading_edge_x_m", "leading edge x", chord.leading_edge_x_m),
                ("mean_chord.y_m", "place y", chord.y_m),
                ("mean_chord.chord_m", "length", chord.chord_m),
            ] {
                self.number(part, (key, "mean chord", name), LENGTH, (Some(value), value));
            }
        }
        for panel in &aircraft.wing_panels {
            let owner = format!("wing panel {}", panel.name);
            for (key, name, unit, value) in [
                ("root_y_m", "root y", LENGTH, panel.root_y_m),
                ("semispan_m", "semispan", LENGTH, panel.semispan_m),
                ("root_chord_m", "root chord", LENGTH, panel.root_chord_m),
                ("taper", "taper", NUMBER, panel.taper),
                ("root_leading_edge_x_m", "root leading edge x", LENGTH, panel.root_leading_edge_x_m),
                ("tip_leading_edge_x_m", "tip leading edge x", LENGTH, panel.tip_leading_edge_x_m),
            ] {
                let key = format!("wing_panel.{}.{key}", panel.name);
                self.number(part, (&key, &owner, name), unit, (Some(value), value));
            }
        }
    }

    fn masses(&mut self, aircraft: &Aircraft) {
        let part = Section::Mass;
        let empty = &aircraft.empty;
        self.number(part, ("mass.mass_kg", "empty", "mass"), MASS, (Some(empty.mass_kg), 1.0));
        self.add_position(part, ("mass.cg_datum_m", "empty", "CG"), PlaceKind::Empty, Some(empty.cg_from_datum_m));
        let limits = &aircraft.limits;
        let most = (limits.max_takeoff_kg, 1.5 * empty.mass_kg);
        self.number(part, ("mass.max_takeoff_kg", "", "maximum take-off mass"), MASS, most);
        self.number(
            part,
            ("mass.max_landing_kg", "", "maximum landing mass"),
            MASS,
            (limits.max_landing_kg, most.0.unwrap_or(most.1)),
        );
        for item in &aircraft.fixed_items {
            let (key, owner) = (format!("fixed_item.{}", item.name), format!("fixed item {}", item.name));
            self.number(part, (&format!("{key}.mass_kg"), &owner, "mass"), MASS, (Some(item.mass_kg), item.mass_kg));
            let place = (format!("{key}.cg_datum_m"), Some(item.cg_from_datum_m));
            self.add_position(part, (&place.0, &owner, "CG"), PlaceKind::Fixed, place.1);
        }
    }

    fn inertia(&mut self, aircraft: &Aircraft) {
        let part = Section::Inertia;
        let products = match &aircraft.inertia {
            InertiaModel::Constant(tensor) => {
                self.moments(part, ("inertia.moments_kg_m2", "empty"), tensor);
                tensor
            }
            InertiaModel::Groups { own_products, .. } => own_products,
        };
        for (key, name, value) in [
            ("inertia.products_kg_m2.xz", "product xz", products.xz),
            ("inertia.products_kg_m2.xy", "product xy", products.xy),
            ("inertia.products_kg_m2.yz", "product yz", products.yz),
        ] {
            self.number(part, (key, "empty", name), FieldUnit::Inertia, (Some(value), value));
        }
        let InertiaModel::Groups { groups, .. } = &aircraft.inertia else { return };
        for group in groups {
            let (key, owner) = (format!("inertia.group.{}", group.name), format!("group {}", group.name));
            self.number(part, (&format!("{key}.mass_kg"), &owner, "mass"), MASS, (Some(group.mass_kg), group.mass_kg));
            let place = format!("{key}.centroid_datum_m");
            self.add_position(part, (&place, &owner, "centroid"), PlaceKind::Group, Some(group.centroid_from_datum_m));
            self.shape(part, (&key, &owner), &group.inertia);
        }
    }

    fn stations(&mut self, aircraft: &Aircraft) {
        let part = Section::Stations;
        for tank in &aircraft.tanks {
            let (key, owner) = (format!("tank.{}", tank.name), format!("tank {}", tank.name));
            let capacity = (Some(tank.capacity_kg), tank.capacity_kg);
            self.number(part, (&format!("{key}.capacity_kg"), &owner, "capacity"), MASS, capacity);
            self.number(part, (&format!("{key}.unusable_kg"), &owner, "unusable"), MASS, (Some(tank.unusable_kg), 0.0));
            let place = format!("{key}.cg_datum_m");
            self.add_position(part, (&place, &owner, "CG"), PlaceKind::Tank, Some(tank.cg_from_datum_m));
            self.shape(part, (&key, &owner), &tank.inertia);
        }
        let lists = [("seat", PlaceKind::Seat, &aircraft.seats), ("luggage", PlaceKind::Luggage, &aircraft.luggage)];
        for (list, kind, stations) in lists {
            for station in stations {
                let (key, owner) = (format!("{list}.{}", station.name), format!("{list} {}", station.name));
                let place = format!("{key}.cg_datum_m");
                self.add_position(part, (&place, &owner, "CG"), kind, Some(station.cg_from_datum_m));
                let capacity = (station.capacity_kg, 100.0);
                self.number(part, (&format!("{key}.capacity_kg"), &owner, "capacity"), MASS, capacity);
                self.shape(part, (&key, &owner), &station.inertia);
            }
        }
    }

    fn places(&mut self, aircraft: &Aircraft) {
        let part = Section::Places;
        let sensors = &aircraft.sensors;
        for (key, name, value) in [
            ("sensors.accelerometer_datum_m", "accelerometer", sensors.accelerometer_from_datum_m),
            ("sensors.alpha_vane_datum_m", "alpha vane", sensors.alpha_vane_from_datum_m),
            ("sensors.beta_vane_datum_m", "beta vane", sensors.beta_vane_from_datum_m),
            ("sensors.antenna_datum_m", "antenna", sensors.antenna_from_datum_m),
        ] {
            self.add_position(part, (key, name, "place"), PlaceKind::Sensor, value);
        }
        let reference = ("moment_reference.position_datum_m", "moment reference", "place");
        self.add_position(part, reference, PlaceKind::Reference, aircraft.moment_reference_from_datum_m);
        for engine in &aircraft.engines {
            let (key, owner) = (format!("engine.{}", engine.name), format!("engine {}", engine.name));
            let place = format!("{key}.position_datum_m");
            self.add_position(part, (&place, &owner, "place"), PlaceKind::Engine, Some(engine.position_from_datum_m));
            let incidence = (Some(engine.incidence_rad.to_degrees()), 0.0);
            let key = format!("{key}.incidence_deg");
            self.number(part, (&key, &owner, "incidence"), FieldUnit::Degrees, incidence);
        }
        if let Some(wheels) = &aircraft.wheels {
            for (key, name, value) in [
                ("wheels.nose_x_m", "nose x", wheels.nose_x_m),
                ("wheels.main_x_m", "main x", wheels.main_x_m),
                ("wheels.main_y_m", "main y", wheels.main_y_m),
            ] {
                self.number(part, (key, "wheels", name), LENGTH, (Some(value), value));
            }
        }
    }

    fn limits(&mut self, aircraft: &Aircraft) {
        let part = Section::Limits;
        let rows: Option<Vec<[f64; 3]>> = aircraft
            .envelope
            .as_ref()
            .map(|envelope| envelope.rows.iter().map(|row| [row.mass_kg, row.forward_x_m, row.aft_x_m]).collect());
        let [x, ..] = self.middle;
        self.add(AircraftField {
            key: ENVELOPE.to_owned(),
            section: part,
            owner: String::new(),
            name: "envelope of the CG",
            unit: MASS,
            value: rows.map(ChangedValue::Rows),
            proposal: ChangedValue::Rows(vec![
                [aircraft.empty.mass_kg, x - 0.1, x + 0.1],
                [1.5 * aircraft.empty.mass_kg, x - 0.1, x + 0.1],
            ]),
            place: None,
            changed: false,
        });
        let own = &aircraft.flight_envelope;
        for (key, name, unit, value, first) in [
            ("flight_envelope.stall_m_s", "stall", SPEED, own.stall_m_s, 30.0),
            ("flight_envelope.stall_mass_kg", "mass of the stall", MASS, own.stall_mass_kg, aircraft.empty.mass_kg),
            ("flight_envelope.manoeuvring_m_s", "manoeuvring VA", SPEED, own.manoeuvring_m_s, 60.0),
            ("flight_envelope.max_level_m_s", "level flight VH", SPEED, own.max_level_m_s, 80.0),
            ("flight_envelope.flaps_extended_m_s", "flaps extended VFE", SPEED, own.flaps_extended_m_s, 50.0),
            ("flight_envelope.never_exceed_m_s", "never exceed VNE", SPEED, own.never_exceed_m_s, 100.0),
            ("flight_envelope.load_factor_low", "least load factor", NUMBER, own.load_factor_low, -1.5),
            ("flight_envelope.load_factor_high", "greatest load factor", NUMBER, own.load_factor_high, 3.8),
            ("flight_envelope.ceiling_m", "ceiling", LENGTH, own.ceiling_m, 4000.0),
        ] {
            self.number(part, (key, "", name), unit, (value, first));
        }
    }
}
