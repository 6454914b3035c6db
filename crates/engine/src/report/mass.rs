//! Rows of mass properties as flown.

use doublet_core::airframe::{LoadedState, Loading};
use serde::Serialize;

use super::results::Results;
use super::table::{Cell, Column, Table};
use crate::run::Snapshot;
use crate::session::{Manoeuvre, Session};
use crate::stage::{self, FlownMass, FlownState};

/// Mass properties in datum axes (x aft, y right, z up) and inertia about the centre of gravity in body axes.
#[derive(Clone, Debug, Serialize)]
pub struct MassRow {
    /// Instant they are of, s; none where they are those of the loading alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of gravity from the datum, m.
    pub cg_from_datum_m: [f64; 3],
    /// Centre of gravity as a part of the mean aerodynamic chord.
    pub mean_chord_fraction: Option<f64>,
    /// Distance of the centre of gravity to the nearer limit of the envelope, m; negative outside.
    pub envelope_margin_m: Option<f64>,
    /// Moment of inertia about x, kg m².
    pub ixx_kg_m2: f64,
    /// Moment of inertia about y, kg m².
    pub iyy_kg_m2: f64,
    /// Moment of inertia about z, kg m².
    pub izz_kg_m2: f64,
    /// Product of inertia, integral of x z dm, kg m².
    pub ixz_kg_m2: f64,
    /// Product of inertia, integral of x y dm, kg m²; zero where left and right are loaded alike.
    pub ixy_kg_m2: f64,
    /// Product of inertia, integral of y z dm, kg m²; zero likewise.
    pub iyz_kg_m2: f64,
    /// What is on board besides the empty aircraft.
    pub items: Vec<ItemRow>,
}

/// Mass properties over a flight.
#[derive(Clone, Debug, Serialize)]
pub struct FlownMassRow {
    /// Where the fuel comes from, in words.
    pub fuel: String,
    /// Time of the first record, s.
    pub start_s: f64,
    /// Mass properties then.
    pub start: MassRow,
    /// Time of the last record, s.
    pub end_s: f64,
    /// Mass properties then.
    pub end: MassRow,
}

/// Something on board.
#[derive(Clone, Debug, Serialize)]
pub struct ItemRow {
    /// Kind: fuel, seat, luggage or item.
    pub kind: &'static str,
    /// Place.
    pub place: String,
    /// Mass, kg.
    pub mass_kg: f64,
}

/// Mass properties at the start of the first flight that has them; those of the loading alone where none has, once the aircraft is
/// read.
pub fn mass_properties(session: &Session, snapshot: &Snapshot) -> Option<MassRow> {
    let flown = session.flights.iter().find_map(|flight| snapshot.flown.get(&flight.name)?.ready());
    if let Some(flown) = flown {
        return Some(flown_row(&flown.start));
    }
    let (aircraft, loaded) = (&snapshot.aircraft.ready()?.aircraft, snapshot.loaded.ready()?);
    Some(mass_row(loaded, &stage::loading_on_board(aircraft, session.loading.as_ref())))
}

/// Mass properties over one flight.
pub fn flown_masses(flown: &FlownMass) -> FlownMassRow {
    FlownMassRow {
        fuel: flown.fuel.words().to_owned(),
        start_s: flown.start.time_s,
        start: flown_row(&flown.start),
        end_s: flown.end.time_s,
        end: flown_row(&flown.end),
    }
}

/// Mass properties in the middle of a window.
pub fn window_mass(window: &Manoeuvre, snapshot: &Snapshot) -> Option<MassRow> {
    let flown = snapshot.flown.get(&window.flight)?.ready()?;
    flown.windows.iter().find(|(name, _)| *name == window.name).map(|(_, state)| flown_row(state))
}

fn flown_row(flown: &FlownState) -> MassRow {
    MassRow { time_s: Some(flown.time_s), ..mass_row(&flown.state, &flown.loading) }
}

fn mass_row(loaded: &LoadedState, loading: &Loading) -> MassRow {
    let properties = &loaded.properties;
    MassRow {
        time_s: None,
        mass_kg: properties.mass_kg,
        cg_from_datum_m: properties.cg_from_datum_m,
        mean_chord_fraction: loaded.mean_chord_fraction,
        envelope_margin_m: loaded.envelope.map(|margin| margin.nearest_m()),
        ixx_kg_m2: properties.inertia.xx,
        iyy_kg_m2: properties.inertia.yy,
        izz_kg_m2: properties.inertia.zz,
        ixz_kg_m2: properties.inertia.xz,
        ixy_kg_m2: properties.inertia.xy,
        iyz_kg_m2: properties.inertia.yz,
        items: items(loading),
    }
}

fn items(loading: &Loading) -> Vec<ItemRow> {
    let places = [("fuel", &loading.fuel_kg), ("seat", &loading.seats_kg), ("luggage", &loading.luggage_kg)];
    let of_places = places.into_iter().flat_map(|(kind, masses)| {
        masses.iter().map(move |(place, &mass_kg)| ItemRow { kind, place: place.clone(), mass_kg })
    });
    let added = loading.added_items.iter().map(|item| ItemRow {
        kind: "item",
        place: item.name.clone(),
        mass_kg: item.mass_kg,
    });
    of_places.chain(added).collect()
}

/// Mass properties at the start and the end of every flight and in the middle of its windows; of the loading where no flight tells.
pub fn table(results: &Results) -> Table {
    let row = |flight: &str, at: &str, mass: &MassRow| {
        let [x, y, z] = mass.cg_from_datum_m;
        let numbers = [
            mass.mass_kg,
            x,
            y,
            z,
            mass.ixx_kg_m2,
            mass.iyy_kg_m2,
            mass.izz_kg_m2,
            mass.ixz_kg_m2,
            mass.ixy_kg_m2,
            mass.iyz_kg_m2,
        ];
        let named = [Cell::text(flight), Cell::text(at), Cell::maybe(mass.time_s)];
        let placed = [Cell::maybe(mass.mean_chord_fraction), Cell::maybe(mass.envelope_margin_m)];
        named.into_iter().chain(numbers.map(Cell::Number)).chain(placed).collect::<Vec<_>>()
    };
    let mut rows = Vec::new();
    for flight in &results.flights {
        let Some(flown) = &flight.mass_properties else { continue };
        rows.push(row(&flight.name, "start", &flown.start));
        for window in results.windows.iter().filter(|window| window.flight == flight.name) {
            let Some(mass) = &window.mass_properties else { continue };
            rows.push(row(&flight.name, &window.name, mass));
        }
        rows.push(row(&flight.name, "end", &flown.end));
    }
    if rows.is_empty() {
        rows.extend(results.mass_properties.iter().map(|mass| row("", "loading", mass)));
    }
    let inertia = |key, heading| Column::number(key, heading, "kg m²", 5);
    let columns = vec![
        Column::new("flight", "Flight"),
        Column::new("at", "At"),
        Column::number("time_s", "Time", "s", 6),
        Column::number("mass_kg", "Mass", "kg", 5),
        Column::number("cg_x_m", "x CG", "m", 4),
        Column::number("cg_y_m", "y CG", "m", 3),
        Column::number("cg_z_m", "z CG", "m", 4),
        inertia("ixx_kg_m2", "Ixx"),
        inertia("iyy_kg_m2", "Iyy"),
        inertia("izz_kg_m2", "Izz"),
        Column::number("ixz_kg_m2", "Ixz", "kg m²", 4),
        Column::number("ixy_kg_m2", "Ixy", "kg m²", 3),
        Column::number("iyz_kg_m2", "Iyz", "kg m²", 3),
        Column::number("mean_chord_fraction", "On the chord", "", 4),
        Column::number("envelope_margin_m", "Margin", "m", 3),
    ];
    let caption = "Mass, centre of gravity from the datum (aft, right, up) and inertia about it.";
    super::tables::table("mass_properties", caption, columns, rows)
}
