//! Findings about what was on board: outside the envelope, impossible, changed by hand, or only assumed.

use doublet_core::airframe::{Aircraft, MassProperties};
use doublet_core::message;
use doublet_core::message::{Message, quoted};

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Edit, Fix, LoadingEdit, Manoeuvre, Place, Session};
use crate::stage::{FlownMass, FuelRecord, FuelSource, WindowAero};

/// Largest change of a recorded fuel over the mass that may stay out of the mass.
const UNUSED_FUEL: f64 = 0.02;

/// What speaks against the mass properties of a window.
pub(super) fn loading_findings(
    place: &Place,
    evidence: Evidence<'_>,
    manoeuvre: &Manoeuvre,
    aero: &WindowAero,
) -> Vec<Finding> {
    let flown = evidence.snapshot.flown.get(&manoeuvre.flight).and_then(|slot| slot.ready());
    let shifted = flown.and_then(|flown| shifted(place, (evidence.session, &manoeuvre.flight), &flown.fuel));
    let possible = impossible(place, aero).or_else(|| envelope(place, evidence, aero));
    let unused = flown.and_then(|flown| find_unused_fuel(place, aero, &flown.fuel));
    possible.into_iter().chain(shifted).chain(unused).collect()
}

/// Whether fuel is recorded whose change matters, and the aircraft file gives it no place.
fn find_unused_fuel(place: &Place, aero: &WindowAero, fuel: &FuelSource) -> Option<Finding> {
    let range_kg = fuel.unused_range_kg?;
    let part = range_kg / aero.data.mass.first()?.mass_kg;
    if part.is_nan() || part <= UNUSED_FUEL {
        return None;
    }
    let text = message!(
        "The recorded fuel changes by {:.0} kg, {:.1} % of the mass (limit {:.0} %), and is not used.",
        range_kg,
        100.0 * part,
        100.0 * UNUSED_FUEL
    );
    let finding = Finding::new(Level::Caution, "loading", place, text).with_figure(part, UNUSED_FUEL);
    let fix_text = "State the tanks and their fuel in the aircraft file.";
    Some(finding.with_fix_text(fix_text).with_setting("Loading", "aircraft"))
}

/// Whether the loading flown lies in the envelope, where the aircraft has one.
fn envelope(place: &Place, evidence: Evidence<'_>, aero: &WindowAero) -> Option<Finding> {
    let aircraft = evidence.snapshot.aircraft.ready()?;
    let MassProperties { mass_kg, cg_from_datum_m: [x_m, ..], .. } = *aero.data.mass.first()?;
    let margin = aircraft.aircraft.envelope.as_ref()?.margin(mass_kg, x_m)?;
    if margin.inside() {
        return None;
    }
    let (text, figure) = if margin.nearest_m() < 0.0 {
        let beyond_m = -margin.nearest_m();
        (
            message!(
                "The centre of gravity is {:.3} m beyond the {} limit of the envelope.",
                beyond_m,
                margin.side.to_string()
            ),
            beyond_m,
        )
    } else {
        (message!("The mass of {:.0} kg is outside the envelope.", mass_kg), mass_kg)
    };
    let finding = Finding::new(Level::Caution, "loading", place, text).with_figure(figure, 0.0);
    Some(finding.with_fix_text("Check the loading: seats, luggage, fuel.").with_setting("Loading", "loading"))
}

/// Whether mass and inertia are those of no body.
fn impossible(place: &Place, aero: &WindowAero) -> Option<Finding> {
    let MassProperties { mass_kg, inertia, .. } = *aero.data.mass.first()?;
    let text = if mass_kg.is_nan() || mass_kg <= 0.0 {
        message!("The mass is {:.1} kg; it must be above zero.", mass_kg)
    } else {
        message!("Impossible inertia: {}.", inertia.check().err()?.to_string())
    };
    let finding = Finding::new(Level::Bad, "loading", place, text);
    Some(finding.with_fix_text("Check the aircraft file and the loading.").with_setting("Loading", "aircraft"))
}

/// Whether the session changes the fuel that was recorded.
fn shifted(place: &Place, (session, flight): (&Session, &str), fuel: &FuelSource) -> Option<Finding> {
    let (_, most_kg) = fuel.shifts_kg.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let one = |(tank, shift_kg): &(Option<String>, f64)| match tank {
        Some(tank) => message!("{} by {:+.1} kg", quoted(tank), *shift_kg),
        None => message!("all by {:+.1} kg", *shift_kg),
    };
    let all = Message::join(fuel.shifts_kg.iter().map(one), ", ");
    let text = message!("The session shifts the recorded fuel: {}.", all);
    let finding = Finding::new(Level::Caution, "loading", place, text).with_figure(*most_kg, 0.0);
    let fix_text = "Use the recorded fuel, unless the load was measured otherwise.";
    let finding = finding.with_fix_text(fix_text).with_setting("Loading", "loading.fuel_kg");
    Some(finding.with_fix(recorded_fuel(session, flight)))
}

/// Uses the recorded fuel of a flight: its loading states none.
fn recorded_fuel(session: &Session, flight: &str) -> Option<Fix> {
    let mut loading = session.loading_in(flight)?.clone();
    loading.fuel_kg.clear();
    let edit = match session.flight(flight)?.loading {
        Some(_) => LoadingEdit::OfFlight { flight: flight.to_owned(), loading: Some(loading) },
        None => LoadingEdit::All(loading),
    };
    Some(Fix::new("use the recorded fuel", Edit::Loading(edit)))
}

/// Flights whose mass, or a part of it, nobody stated and nothing recorded.
pub(super) fn assumed(evidence: Evidence<'_>) -> Vec<Finding> {
    let Some(loaded) = evidence.snapshot.aircraft.ready() else { return Vec::new() };
    let flown = evidence.session.flights.iter().filter_map(|flight| {
        let flown = evidence.snapshot.flown.get(&flight.name)?.ready()?;
        assumed_in(&flight.name, evidence.session, &loaded.aircraft, flown)
    });
    flown.collect()
}

fn assumed_in(flight: &str, session: &Session, aircraft: &Aircraft, flown: &FlownMass) -> Option<Finding> {
    let standard = &aircraft.standard_loading;
    let sum = |masses: &std::collections::BTreeMap<String, f64>| masses.values().sum::<f64>();
    let on_board_kg = sum(&standard.seats_kg) + sum(&standard.luggage_kg);
    let fuel_kg = sum(&flown.start.loading.fuel_kg);
    let full_kg: f64 = aircraft.tanks.iter().map(|tank| tank.capacity_kg).sum();
    // Sums in another order differ by their rounding.
    let full = if fuel_kg >= full_kg * (1.0 - 1e-9) { ", all tanks full" } else { "" };
    let mut parts = Vec::new();
    if session.loading_in(flight).is_none() && on_board_kg > 0.0 {
        parts.push(message!("standard seats and luggage of {:.0} kg (loading not stated)", on_board_kg));
    }
    match (flown.fuel.record, flown.fuel.is_stated) {
        _ if fuel_kg <= 0.0 => {}
        (FuelRecord::None, false) => {
            parts.push(message!("standard fuel of {:.0} kg{}, constant (fuel not recorded)", fuel_kg, full));
        }
        (FuelRecord::None, true) => {
            parts.push(message!("fuel of {:.0} kg, constant (burn not recorded)", fuel_kg));
        }
        (FuelRecord::Flow, false) => {
            parts.push(message!("standard fuel of {:.0} kg{} at the start (only flow recorded)", fuel_kg, full));
        }
        (FuelRecord::Flow, true) | (FuelRecord::Tanks | FuelRecord::Total, _) => {}
    }
    if parts.is_empty() {
        return None;
    }
    let mass_kg = flown.start.state.properties.mass_kg;
    let text = message!("The initial mass of {:.0} kg is assumed: {}.", mass_kg, Message::join(parts, "; "));
    let finding = Finding::new(Level::Caution, "loading", Place::flight(flight), text);
    let fix_text = "State occupants, luggage and initial fuel, or map a fuel channel.";
    Some(finding.with_fix_text(fix_text).with_setting("Loading", "loading"))
}

#[cfg(test)]
mod tests {
    use doublet_core::airframe::Loading;

    use super::*;
    use crate::begin::empty_session;
    use crate::session::Flight;

    #[test]
    fn recorded_fuel_replaces_the_stated_fuel_and_leaves_seats_and_luggage() {
        let mut session = empty_session("", None);
        session.flights = vec![Flight::new("f".to_owned(), Vec::new())];
        assert_eq!(recorded_fuel(&session, "f"), None, "no loading is stated");
        let stated = Loading {
            fuel_kg: [("main".to_owned(), 50.0)].into(),
            seats_kg: [("pilot".to_owned(), 80.0)].into(),
            ..Loading::default()
        };
        let recorded = Loading { fuel_kg: Default::default(), ..stated.clone() };
        session.loading = Some(stated.clone());
        let fixed = recorded_fuel(&session, "f").unwrap().apply(&session).unwrap();
        assert_eq!(fixed.loading, Some(recorded.clone()));
        session.flights[0].loading = Some(stated.clone());
        let fixed = recorded_fuel(&session, "f").unwrap().apply(&session).unwrap();
        assert_eq!((fixed.flights[0].loading.as_ref(), fixed.loading.as_ref()), (Some(&recorded), Some(&stated)));
    }
}
