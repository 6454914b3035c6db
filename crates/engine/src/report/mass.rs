//! Rows of mass properties as flown.

use doublet_core::airframe::{LoadedState, Loading, MassProperties};
use serde::Serialize;

use super::results::Results;
use super::table::{Table, TableOf};
use crate::session::{Manoeuvre, Session};
use crate::snapshot::Snapshot;
use crate::stage::{self, FlownMass, FlownState};

/// Mass properties in datum axes (x aft, y right, z up) and inertia about the centre of gravity in body axes.
#[derive(Clone, Debug, Serialize)]
pub struct MassRow {
    /// Time, s; absent if they follow from the loading alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Mass, centre of gravity and inertia.
    #[serde(flatten)]
    pub properties: MassProperties,
    /// Centre of gravity as a part of the mean aerodynamic chord.
    pub mean_chord_fraction: Option<f64>,
    /// Distance of the centre of gravity to the nearer limit of the envelope, m; negative outside.
    pub envelope_margin_m: Option<f64>,
    /// Masses on board in addition to the empty aircraft.
    pub items: Vec<ItemRow>,
}

/// Mass properties over a flight.
#[derive(Clone, Debug, Serialize)]
pub struct FlownMassRow {
    /// Source of the fuel data, in words.
    pub fuel: String,
    /// Whether the fuel was measured, stated or assumed, in words.
    pub fuel_basis: &'static str,
    /// Time of the first record, s.
    pub start_s: f64,
    /// Mass properties at that time.
    pub start: MassRow,
    /// Time of the last record, s.
    pub end_s: f64,
    /// Mass properties at that time.
    pub end: MassRow,
}

/// Something on board.
#[derive(Clone, Debug, Serialize)]
pub struct ItemRow {
    /// Kind: fuel, seat, luggage or item.
    pub kind: &'static str,
    pub place: String,
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
pub(crate) fn flown_masses(flown: &FlownMass) -> FlownMassRow {
    FlownMassRow {
        fuel: flown.fuel.description().to_owned(),
        fuel_basis: flown.fuel.basis(),
        start_s: flown.start.time_s,
        start: flown_row(&flown.start),
        end_s: flown.end.time_s,
        end: flown_row(&flown.end),
    }
}

/// Mass properties in the middle of a window.
pub(crate) fn window_mass(window: &Manoeuvre, snapshot: &Snapshot) -> Option<MassRow> {
    let flown = snapshot.flown.get(&window.flight)?.ready()?;
    flown.windows.iter().find(|(name, _)| *name == window.name).map(|(_, state)| flown_row(state))
}

fn flown_row(flown: &FlownState) -> MassRow {
    MassRow { time_s: Some(flown.time_s), ..mass_row(&flown.state, &flown.loading) }
}

fn mass_row(loaded: &LoadedState, loading: &Loading) -> MassRow {
    MassRow {
        time_s: None,
        properties: loaded.properties,
        mean_chord_fraction: loaded.mean_chord_fraction,
        envelope_margin_m: loaded.envelope.map(|margin| margin.nearest_m()),
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

/// A coordinate of the centre of gravity; none where the aircraft states no station at all.
fn station(mass: &MassRow, axis: usize) -> Option<f64> {
    let place = mass.properties.cg_from_datum_m;
    (place != [0.0; 3]).then_some(place[axis])
}

/// Mass properties at the start and the end of every flight and in the middle of its windows; of the loading where no flight tells.
pub fn table(results: &Results) -> Table {
    let mut rows = Vec::new();
    for flight in &results.flights {
        let Some(flown) = &flight.mass_properties else { continue };
        rows.push((flight.name.as_str(), "start", &flown.start));
        for window in results.windows.iter().filter(|window| window.flight == flight.name) {
            let Some(mass) = &window.mass_properties else { continue };
            rows.push((&flight.name, &window.name, mass));
        }
        rows.push((&flight.name, "end", &flown.end));
    }
    if rows.is_empty() {
        rows.extend(results.mass_properties.iter().map(|mass| ("", "loading", mass)));
    }
    let caption = "Mass, centre of gravity from the datum (aft, right, up) and inertia about it.";
    TableOf::new("mass_properties", caption, rows)
        .text("flight", "Flight", |(flight, ..)| flight)
        .text("at", "At", |(_, at, _)| at)
        .maybe("time_s", "Time", "s", 6, |(.., mass)| mass.time_s)
        .number("mass_kg", "Mass", "kg", 5, |(.., mass)| mass.properties.mass_kg)
        .maybe("cg_x_m", "x CG", "m", 4, |(.., mass)| station(mass, 0))
        .maybe("cg_y_m", "y CG", "m", 3, |(.., mass)| station(mass, 1))
        .maybe("cg_z_m", "z CG", "m", 4, |(.., mass)| station(mass, 2))
        .number("ixx_kg_m2", "Ixx", "kg m²", 5, |(.., mass)| mass.properties.inertia.xx)
        .number("iyy_kg_m2", "Iyy", "kg m²", 5, |(.., mass)| mass.properties.inertia.yy)
        .number("izz_kg_m2", "Izz", "kg m²", 5, |(.., mass)| mass.properties.inertia.zz)
        .number("ixz_kg_m2", "Ixz", "kg m²", 4, |(.., mass)| mass.properties.inertia.xz)
        .number("ixy_kg_m2", "Ixy", "kg m²", 3, |(.., mass)| mass.properties.inertia.xy)
        .number("iyz_kg_m2", "Iyz", "kg m²", 3, |(.., mass)| mass.properties.inertia.yz)
        .maybe("mean_chord_fraction", "On the chord", "", 4, |(.., mass)| mass.mean_chord_fraction)
        .maybe("envelope_margin_m", "Margin", "m", 3, |(.., mass)| mass.envelope_margin_m)
        .done()
}
