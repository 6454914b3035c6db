//! Words at instants of a flight, drawn in every plot over its time.

use serde::{Deserialize, Serialize};

use super::Session;
use super::edit::EditError;

/// Longest text, characters.
const LONGEST: usize = 200;

/// Words at an instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Annotation {
    /// Flight it belongs to.
    pub flight: String,
    /// Instant on the flight's time line, s.
    pub time_s: f64,
    /// The words.
    pub text: String,
}

/// A change of the annotations.
#[derive(Clone, Debug, PartialEq)]
pub enum AnnotationEdit {
    /// Adds one.
    Add(Annotation),
    /// Puts another in the place of one.
    Change {
        /// As it is.
        from: Annotation,
        /// As it shall be.
        to: Annotation,
    },
    /// Removes one.
    Remove(Annotation),
}

impl AnnotationEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Add(_) => "annotate".to_owned(),
            Self::Change { .. } => "change annotation".to_owned(),
            Self::Remove(_) => "remove annotation".to_owned(),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        if let Self::Add(new) | Self::Change { to: new, .. } = self {
            check(new, session)?;
        }
        let all = &mut session.annotations;
        match self {
            Self::Add(new) => all.push(new.clone()),
            Self::Change { from, to } => {
                all.iter_mut().filter(|one| *one == from).take(1).for_each(|one| one.clone_from(to))
            }
            Self::Remove(gone) => {
                if let Some(at) = all.iter().position(|one| one == gone) {
                    all.remove(at);
                }
            }
        }
        session.annotations.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Ok(())
    }
}

fn check(new: &Annotation, session: &Session) -> Result<(), EditError> {
    if !new.time_s.is_finite() {
        let field = "time of the annotation".to_owned();
        return Err(EditError::Value { field, value: new.time_s, allowed: "it must be a number of seconds" });
    }
    if new.text.trim().is_empty() || new.text.chars().count() > LONGEST || new.text.contains('\n') {
        return Err(EditError::Name(format!("an annotation has one line of 1 to {LONGEST} characters")));
    }
    match session.flight(&new.flight) {
        Some(_) => Ok(()),
        None => Err(EditError::NoFlight(new.flight.clone())),
    }
}
