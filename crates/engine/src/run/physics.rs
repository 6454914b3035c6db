//! Channels of each flight against each other. Only the verdict hangs on it.

use std::sync::Arc;

use rayon::prelude::*;

use super::board::Board;
use super::control::Cancelled;
use super::flights::KeyedFlight;
use super::snapshot::Slot;
use crate::graph::{Cache, KeyBuilder};
use crate::session::{Flight, Session};
use crate::stage::{self, LoadedFlight};

/// Compares the channels of every flight that was read.
pub fn compare(
    session: &Session,
    flights: &[KeyedFlight<'_>],
    cache: &Cache,
    board: &Board<'_>,
) -> Result<(), Cancelled> {
    let one = |flight: &KeyedFlight<'_>| {
        let key = KeyBuilder::new("physics", 1).key(flight.key).finish();
        let compare = |(about, loaded): (&Flight, &Arc<LoadedFlight>)| {
            cache.get(key).unwrap_or_else(|| cache.insert(key, stage::physics(about, loaded)))
        };
        let physics = session.flight(flight.name).zip(flight.loaded.as_ref()).map(compare);
        board.step(|snapshot| {
            let slot = snapshot.physics.entry(flight.name.to_owned()).or_default();
            match physics {
                Some(physics) => slot.finish(Ok(physics)),
                None => *slot = Slot::NotRequested,
            }
        })
    };
    flights.par_iter().try_for_each(one)
}
