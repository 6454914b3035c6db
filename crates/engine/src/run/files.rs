//! Flights by the identity of the files a session names.

use std::path::Path;
use std::sync::Arc;

use crate::graph::{Cache, Key, KeyBuilder};
use crate::session;
use crate::stage::{self, LoadedFlight};

/// A flight with all that the session makes of it, and its key.
pub fn keyed_flight(
    folder: &Path,
    flight: &session::Flight,
    cache: &Cache,
) -> (Result<Arc<LoadedFlight>, String>, Key) {
    let files_key = files_key(folder, flight);
    let instruments = flight.instruments.as_ref().map(|used| stage::text(folder, &used.file, "aircraft"));
    let settings = (&flight.clocks, &flight.instruments, instruments, &flight.signals);
    let key = KeyBuilder::new("aligned", 3).key(files_key).parameters(&settings).finish();
    let aligned = load_flight(folder, flight, files_key, key, cache);
    with_expressions(aligned, &flight.expressions, key, cache)
}

/// A flight as read, then on its time line: moving a clock reads nothing again.
fn load_flight(
    folder: &Path,
    flight: &session::Flight,
    files_key: Key,
    key: Key,
    cache: &Cache,
) -> Result<Arc<LoadedFlight>, String> {
    cache.get_or_try(key, || {
        let read = cache.get_or_try(files_key, || stage::flight(folder, flight))?;
        stage::prepared(folder, &read, flight)
    })
}

/// A flight with its channels by expression, and its key: changing one fits no clock again.
fn with_expressions(
    aligned: Result<Arc<LoadedFlight>, String>,
    expressions: &[session::ExpressionSetting],
    key: Key,
    cache: &Cache,
) -> (Result<Arc<LoadedFlight>, String>, Key) {
    if expressions.is_empty() {
        return (aligned, key);
    }
    let key = KeyBuilder::new("expressions", 1).key(key).parameters(&expressions).finish();
    let result = aligned.and_then(|aligned| cache.get_or_try(key, || stage::expressed(&aligned, expressions)));
    (result, key)
}

/// Identity of a flight's files.
fn files_key(folder: &Path, flight: &session::Flight) -> Key {
    let mut key = KeyBuilder::new("files", 1).parameters(&flight.recordings);
    for entry in &flight.recordings {
        for path in std::iter::once(entry.path.as_str()).chain(entry.channel_map.file()) {
            let Ok(place) = stage::locate(folder, path) else { continue };
            for file in stage::files(&place) {
                key = key.file(&file);
            }
        }
    }
    key.finish()
}
