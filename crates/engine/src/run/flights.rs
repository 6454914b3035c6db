//! What is read of a session's flights and what follows from each of them alone: engines, windows proposed, noise.

use std::sync::Arc;

use rayon::prelude::*;

use super::board::Board;
use super::control::Cancelled;
use super::files::keyed_flight;
use super::pipeline::Scope;
use super::snapshot::Slot;
use crate::graph::{Cache, Key, KeyBuilder};
use crate::session;
use crate::stage::{self, FlightEngines, LoadedAircraft, LoadedFlight, NoiseFlight};

/// A flight of the session, its content where it could be read, and its key.
pub(super) struct KeyedFlight<'a> {
    pub(super) name: &'a str,
    pub(super) loaded: Option<Arc<LoadedFlight>>,
    pub(super) key: Key,
}

pub(super) fn load_flights<'a>(
    scope: &Scope<'a>,
    cache: &Cache,
    board: &Board<'_>,
) -> Result<Vec<KeyedFlight<'a>>, Cancelled> {
    let one = |flight: &'a session::Flight| {
        let (result, key) = keyed_flight(scope.folder, flight, cache);
        let loaded = result.as_ref().ok().cloned();
        board.step(|snapshot| {
            if let Some(slot) = snapshot.flights.get_mut(&flight.name) {
                slot.finish(result);
            }
        })?;
        Ok(KeyedFlight { name: &flight.name, loaded, key })
    };
    scope.session.flights.par_iter().map(one).collect()
}

/// Engines over each flight. They hang on the recording and the aircraft's file alone, and nothing hangs on them: they come last.
pub(super) fn model_engines(
    flights: &[KeyedFlight<'_>],
    (aircraft, file_key): (&LoadedAircraft, Key),
    cache: &Cache,
    board: &Board<'_>,
) -> Result<(), Cancelled> {
    let one = |flight: &KeyedFlight<'_>| {
        let key = KeyBuilder::new("engines", 1).key(flight.key).key(file_key).finish();
        let model = |flight: &Arc<LoadedFlight>| match cache.get::<FlightEngines>(key) {
            Some(engines) => Some(Ok(engines)),
            None => stage::flight_engines(&flight.recording, &aircraft.powerplant)
                .map(|engines| engines.map(|engines| cache.insert(key, engines)))
                .transpose(),
        };
        let result = flight.loaded.as_ref().and_then(model);
        board.step(|snapshot| {
            let slot = snapshot.engines.entry(flight.name.to_owned()).or_default();
            match result {
                Some(result) => slot.finish(result),
                None => *slot = Slot::NotRequested,
            }
        })
    };
    flights.par_iter().try_for_each(one)
}

/// Windows each flight proposes, and its noise. Nothing hangs on them, so they come last.
pub(super) fn propose<'f>(
    scope: &Scope<'_>,
    flights: &'f [KeyedFlight<'f>],
    cache: &Cache,
    board: &Board<'_>,
) -> Result<(), Cancelled> {
    let one = |flight: &'f KeyedFlight<'f>| -> Result<Option<_>, Cancelled> {
        let name = flight.name;
        let Some(loaded) = &flight.loaded else {
            board.step(|snapshot| {
                snapshot.proposals.insert(name.to_owned(), Slot::NotRequested);
                snapshot.noise.insert(name.to_owned(), Slot::NotRequested);
            })?;
            return Ok(None);
        };
        let key = KeyBuilder::new("proposals", 2).key(flight.key).text(name).finish();
        let proposals = cache.get(key).unwrap_or_else(|| cache.insert(key, stage::proposals(name, loaded)));
        board.step(|snapshot| {
            snapshot.proposals.entry(name.to_owned()).or_default().finish(Ok(Arc::clone(&proposals)));
        })?;
        Ok(Some((name, key, Arc::clone(loaded), proposals)))
    };
    let known: Vec<_> = flights.par_iter().map(one).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    let steady = &scope.session.steady;
    let key =
        known.iter().fold(KeyBuilder::new("noise", 2).parameters(steady), |key, (_, own, ..)| key.key(*own)).finish();
    let own_key = |name: &str| KeyBuilder::new("noise of a flight", 1).key(key).text(name).finish();
    let cached = || known.iter().map(|(name, ..)| cache.get(own_key(name))).collect::<Option<Vec<_>>>();
    let noise = cached().unwrap_or_else(|| {
        let flights = known.iter().map(|(name, _, loaded, proposals)| NoiseFlight { name, loaded, proposals });
        let found = stage::noise(&flights.collect::<Vec<_>>(), steady);
        known.iter().zip(found).map(|((name, ..), noise)| cache.insert(own_key(name), noise)).collect()
    });
    board.update(|snapshot| {
        for ((name, ..), noise) in known.iter().zip(noise) {
            snapshot.noise.entry((*name).to_owned()).or_default().finish(Ok(noise));
        }
    })
}
