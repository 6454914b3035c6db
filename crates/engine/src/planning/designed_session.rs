//! The session of a designed flight: the recorders of the flight it was designed from, the windows and the loading of the design.

use doublet_core::airframe::{Aircraft, Loading};
use doublet_core::simulate::Scenario;

use crate::graph::StageResult;
use crate::session::{DelaySource, Flight, GustSource, Session};
use crate::study::windows;

/// File of the truth, which a recorder does not have.
const TRUTH_FILE: &str = "truth.h5";
/// Folder beside the session of a design in which the recordings of its flight are looked for.
pub const FLIGHT_FOLDER: &str = "flight";

/// The loading of a session with the fuel at which the aircraft has a mass (kg): parts of the tanks as stated, or as in the standard loading,
/// each up to its capacity.
pub fn loading_of_mass(aircraft: &Aircraft, loading: Option<&Loading>, mass_kg: f64) -> StageResult<Loading> {
    /// Halvings: a thousand kilograms to a microgram.
    const HALVINGS: usize = 60;
    let standard = &aircraft.standard_loading;
    let mut loading = loading.unwrap_or(standard).clone();
    if loading.fuel_kg.values().sum::<f64>() <= 0.0 {
        loading.fuel_kg.clone_from(&standard.fuel_kg);
    }
    let stated = loading.fuel_kg.clone();
    let capacity =
        |name: &String| aircraft.tanks.iter().find(|tank| tank.name == *name).map_or(0.0, |tank| tank.capacity_kg);
    let full = stated.iter().map(|(name, part)| if *part > 0.0 { capacity(name) / part } else { 0.0 });
    let mut ends = (0.0, full.fold(0.0, f64::max));
    let mut at = |scale: f64| {
        for (name, fuel_kg) in &mut loading.fuel_kg {
            *fuel_kg = (scale * stated[name]).min(capacity(name));
        }
        (loading.mass_properties(aircraft).mass_kg, loading.clone())
    };
    let (empty_kg, full_kg) = (at(ends.0).0, at(ends.1).0);
    // The mass of a trim is a sum in another order.
    let rounding_kg = 1e-9 * mass_kg;
    if !(empty_kg - rounding_kg..=full_kg + rounding_kg).contains(&mass_kg) {
        return Err(
            format!("no fuel gives {mass_kg:.1} kg: {empty_kg:.1} kg without fuel, {full_kg:.1} kg full").into()
        );
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (ends.0 + ends.1);
        if at(middle).0 < mass_kg { ends.0 = middle } else { ends.1 = middle }
    }
    Ok(at(ends.1).1)
}

/// The session over recordings of a scenario in `folder`, on the clocks and with the instruments of the first flight of `session`. Gusts and
/// delays are estimated; the fuel is that of the recorders where `session` takes it from them.
pub fn designed_session(session: &Session, scenario: &Scenario, folder: &str) -> StageResult<Session> {
    let mut flight = session.flights.first().ok_or("the session has no flight whose recorders could be used")?.clone();
    move_recordings(&mut flight, folder);
    flight.recordings.iter_mut().for_each(|recording| recording.sha256 = None);
    flight.recordings.retain(|recording| !recording.path.ends_with(&format!("/{TRUTH_FILE}")));
    let mut windows = windows(scenario);
    windows.iter_mut().for_each(|window| window.flight.clone_from(&flight.name));
    let states_fuel = session.loading.as_ref().is_some_and(|loading| !loading.fuel_kg.is_empty());
    let mut loading = scenario.loading.clone();
    if !states_fuel {
        loading.fuel_kg.clear();
    }
    Ok(Session {
        loading: Some(loading),
        flights: vec![flight],
        windows,
        steady: Vec::new(),
        gusts: GustSource::Estimated,
        delays: DelaySource::Estimated,
        experiments: Vec::new(),
        ..session.clone()
    })
}

/// The session of a design over the recordings in another folder.
#[must_use]
pub fn with_recordings_in(session: &Session, folder: &str) -> Session {
    let mut session = session.clone();
    session.flights.iter_mut().for_each(|flight| move_recordings(flight, folder));
    session
}

fn move_recordings(flight: &mut Flight, folder: &str) {
    for recording in &mut flight.recordings {
        let file = recording.path.rsplit(['/', '\\']).next().unwrap_or_default();
        recording.path = format!("{folder}/{file}");
    }
}
