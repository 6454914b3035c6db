//! Findings about the session as a whole: channels that contradict each other, what could not be computed.

use super::judge::{Evidence, not_computed};
use super::{Finding, Level};

/// What speaks against the session besides its windows, fits and studies.
pub(super) fn findings(evidence: Evidence<'_>) -> Vec<Finding> {
    let snapshot = evidence.snapshot;
    let physics = snapshot.physics.iter().filter_map(|(name, slot)| Some((name, slot.ready()?)));
    let mut found: Vec<Finding> = physics.flat_map(|(name, physics)| physics.findings(name)).collect();
    let mut note = |level: Level, place: String, error: Option<&str>| {
        found.extend(error.map(|error| not_computed(level, place, error)));
    };
    note(Level::Bad, "aircraft".to_owned(), snapshot.aircraft.error());
    for (name, slot) in &snapshot.flights {
        note(Level::Bad, format!("flight '{name}'"), slot.error());
    }
    for (name, slot) in &snapshot.engines {
        note(Level::Caution, format!("engines of flight '{name}'"), slot.error());
    }
    note(Level::Bad, "pooled estimate".to_owned(), snapshot.pooled.error());
    note(Level::Caution, "proof of match".to_owned(), snapshot.proof.error());
    found
}
