//! Changes of the aircraft of a session.

use super::{EditError, Session};
use crate::session::ChangedValue;

/// Lists of places and the masses that a loading has in them.
const LOADED: [&str; 3] = ["tank", "seat", "luggage"];

/// A change of the aircraft.
#[derive(Clone, Debug, PartialEq)]
pub enum AircraftEdit {
    /// Another aircraft, as its file says.
    Use(String),
    /// Values by key, in the place of the file's.
    Set {
        /// What is changed, in words.
        what: String,
        /// Keys as in [`crate::aircraft::AircraftChanges`].
        values: Vec<(String, ChangedValue)>,
    },
    /// Back to the file in a key and all below it.
    Restore(String),
    /// Back to the file in everything.
    RestoreAll,
}

impl AircraftEdit {
    pub fn set(what: impl Into<String>, key: &str, value: ChangedValue) -> Self {
        Self::Set { what: what.into(), values: vec![(key.to_owned(), value)] }
    }

    pub(super) fn label(&self) -> String {
        match self {
            Self::Use(name) => format!("use aircraft {name}"),
            Self::Set { what, .. } => format!("change {what}"),
            Self::Restore(key) => format!("take {key} from the aircraft file"),
            Self::RestoreAll => "take the aircraft from its file".to_owned(),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        match self {
            Self::Use(name) => {
                session.aircraft = Some(name.clone());
                session.aircraft_changes = Default::default();
            }
            Self::Set { values, .. } => {
                for (key, value) in values {
                    session.aircraft_changes.set(key, value.clone());
                    if *value == ChangedValue::Removed {
                        unload(session, key);
                    }
                }
                if let Some((key, value)) = session.aircraft_changes.unusable() {
                    let (field, allowed) = (key.to_owned(), "it must be a finite number");
                    return Err(EditError::Value { field, value, allowed });
                }
            }
            Self::Restore(key) => session.aircraft_changes.restore(key),
            Self::RestoreAll => session.aircraft_changes = Default::default(),
        }
        Ok(())
    }
}

/// Takes what is on board out of a place that is left out, in every loading.
fn unload(session: &mut Session, key: &str) {
    let Some((list, name)) = key.split_once('.') else { return };
    let Some(at) = LOADED.iter().position(|own| *own == list) else { return };
    let of_flights = session.flights.iter_mut().filter_map(|flight| flight.loading.as_mut());
    for loading in session.loading.iter_mut().chain(of_flights) {
        let masses = [&mut loading.fuel_kg, &mut loading.seats_kg, &mut loading.luggage_kg];
        masses.into_iter().nth(at).map(|masses| masses.remove(name));
    }
}
