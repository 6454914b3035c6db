//! What the aircraft weighed: the stated empty mass, and the mass as flown with what it rests on.

use doublet_core::quantity::Role;
use doublet_core::statistics::extent;

use super::{Block, Contents, Parts, paragraph};
use crate::notation::significant;
use crate::report::table::TableOf;
use crate::report::{FlownMassRow, WindowRow, tables};

/// Columns of the mass properties that a page has room for, the flight only of several: times are beside the manoeuvres, products of inertia
/// about the plane of symmetry in the results.
const COLUMNS: [&str; 12] = [
    "flight", "at", "mass_kg", "cg_x_m", "cg_y_m", "cg_z_m", "ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2", "ixz_kg_m2",
    "mean_chord_fraction", "envelope_margin_m",
];

/// Empty mass and centre of gravity with what they come from: the aircraft file, or a weighing that was saved in the session. An aircraft
/// that carries nothing else states the mass that it flew with.
pub(super) fn empty_aircraft(contents: &Contents<'_>) -> Option<[Block; 2]> {
    /// What a weighing sets.
    const KEYS: [&str; 2] = ["mass.mass_kg", "mass.cg_datum_m"];
    let empty = &contents.snapshot.aircraft.ready()?.aircraft.empty;
    let changes = &contents.session.aircraft_changes;
    let source = match KEYS.map(|key| changes.get(key).is_some()) {
        [true, true] => "mass and centre of gravity set in the session (weighing)",
        [true, false] => "mass set in the session",
        [false, true] => "centre of gravity set in the session",
        [false, false] => "aircraft file",
    };
    let [x, y, z] = empty.cg_from_datum_m.map(|value| significant(value, 5));
    let is_stated = empty.cg_from_datum_m != [0.0; 3];
    let place = if is_stated { format!("x {x} m, y {y} m, z {z} m from the datum") } else { "not stated".to_owned() };
    let [heading, mass, centre] = match carries_load(contents) {
        true => ["Empty aircraft", "Empty mass", "Centre of gravity, empty"],
        false => ["Aircraft as flown", "Stated mass, constant", "Centre of gravity"],
    };
    let facts =
        [(mass, format!("{} kg", significant(empty.mass_kg, 6))), (centre, place), ("Source", source.to_owned())];
    let facts = facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
    Some([Block::Heading(heading.to_owned()), Block::Facts(facts)])
}

/// Whether the aircraft file has room for anything besides the empty aircraft.
fn carries_load(contents: &Contents<'_>) -> bool {
    let Some(loaded) = contents.snapshot.aircraft.ready() else { return false };
    let aircraft = &loaded.aircraft;
    !(aircraft.tanks.is_empty() && aircraft.seats.is_empty() && aircraft.luggage.is_empty())
}

/// Mass and centre of gravity in the manoeuvres with what they rest on; in the appendix the mass properties over each flight.
pub(super) fn flown(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let Some(mass) = &results.mass_properties else {
        return vec![paragraph("The mass properties are not known.")].into();
    };
    let known = [
        ("Mass in the manoeuvres", mass_range(contents)),
        ("Centre of gravity", cg_range(contents)),
        ("Fuel", carries_load(contents).then(|| fuel(contents)).flatten()),
        ("Occupants and luggage", occupants(contents)),
        ("Uncertainty of the mass", Some(uncertainty(contents))),
    ];
    let known = known.into_iter().filter_map(|(name, text)| Some((name.to_owned(), text?)));
    let mut body = vec![Block::Heading("Mass properties as flown".to_owned()), Block::Facts(known.collect())];
    if !mass.items.is_empty() {
        let caption = "On board besides the empty aircraft, at the start of the first flight.";
        let loading = TableOf::new("loading", caption, &mass.items)
            .text("kind", "Kind", |item| item.kind)
            .text("place", "Place", |item| &item.place)
            .number("mass_kg", "Mass", "kg", 4, |item| item.mass_kg);
        body.push(Block::Table(loading.done()));
    }
    let note = "At the start and the end of each flight and in the middle of each manoeuvre.";
    let columns = if results.flights.len() > 1 { &COLUMNS[..] } else { &COLUMNS[1..] };
    Parts { body, appendix: vec![paragraph(note), Block::Table(tables::mass_properties(results).select(columns))] }
}

/// Mass in the manoeuvres; none where it is not known.
pub(super) fn mass_range(contents: &Contents<'_>) -> Option<String> {
    range(contents, ("kg", 5), &|row| Some(row.mass_properties.as_ref()?.properties.mass_kg))
}

/// Centre of gravity in the manoeuvres on the mean chord; none where it is not known.
pub(super) fn cg_range(contents: &Contents<'_>) -> Option<String> {
    range(contents, ("% of the mean chord", 3), &|row| Some(100.0 * row.mass_properties.as_ref()?.mean_chord_fraction?))
}

fn range(
    contents: &Contents<'_>,
    (unit, digits): (&str, usize),
    value: &dyn Fn(&WindowRow) -> Option<f64>,
) -> Option<String> {
    let values: Vec<f64> = contents.results.windows.iter().filter_map(value).collect();
    let [low, high] = extent(&values)?.map(|end| significant(end, digits));
    Some(if low == high { format!("{low} {unit}") } else { format!("{low} to {high} {unit}") })
}

/// How the fuel of each flight is known and from what, once where all flights agree.
fn fuel(contents: &Contents<'_>) -> Option<String> {
    of_flights(contents, &|mass| format!("{} ({})", mass.fuel_basis, mass.fuel))
}

/// Whether the fuel was measured, stated or assumed; none for an aircraft without a load.
pub(super) fn fuel_basis(contents: &Contents<'_>) -> Option<String> {
    of_flights(contents, &|mass| mass.fuel_basis.to_owned()).filter(|_| carries_load(contents))
}

fn of_flights(contents: &Contents<'_>, words: &dyn Fn(&FlownMassRow) -> String) -> Option<String> {
    let flights = contents.results.flights.iter().filter_map(|flight| flight.mass_properties.as_ref());
    let mut known: Vec<String> = flights.map(words).collect();
    known.dedup();
    (!known.is_empty()).then(|| known.join("; "))
}

/// Whether what else was on board is stated; none for an aircraft without seats and luggage bays.
fn occupants(contents: &Contents<'_>) -> Option<String> {
    let aircraft = &contents.snapshot.aircraft.ready()?.aircraft;
    if aircraft.seats.is_empty() && aircraft.luggage.is_empty() {
        return None;
    }
    let is_stated = |name: &str| contents.session.loading_in(name).is_some();
    let all = contents.session.flights.iter().all(|flight| is_stated(&flight.name));
    Some(if all { "stated in the session" } else { "assumed: standard loading of the aircraft file" }.to_owned())
}

/// What is known of the error of the mass: the accuracy of a recorded fuel mass where the instruments file states it.
fn uncertainty(contents: &Contents<'_>) -> String {
    let channels = contents.results.flights.iter().flat_map(|flight| &flight.channels);
    let fuel_kg = channels.filter(|row| row.role == Role::FuelMass.name()).find_map(|row| row.accuracy);
    let rest = "forces scale with the mass, moments with the inertia";
    match fuel_kg {
        Some(fuel_kg) => {
            format!("fuel ± {} kg (instruments file); the rest not stated; {rest}", significant(fuel_kg, 2))
        }
        None => format!("not stated; {rest}"),
    }
}
