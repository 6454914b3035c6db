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
    Add(Annotation),
    /// Puts another in the place of one.
    Change {
        /// As it is.
        from: Annotation,
        /// As it shall be.
        to: Annotation,
    },
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::session::{self, Edit};

    #[test]
    fn annotations_are_one_line_on_a_flight_in_the_order_of_time_and_can_be_changed_and_removed() {
        let mut session = session::parse(builtin::session("demo").unwrap()).unwrap();
        session.annotations.push(Annotation { flight: "FT1".to_owned(), time_s: 12.5, text: "gust".to_owned() });
        let one = |time_s: f64, text: &str| Annotation { flight: "FT1".to_owned(), time_s, text: text.to_owned() };
        let edit = |session: &Session, edit: AnnotationEdit| Edit::Annotation(edit).apply(session);
        let added = edit(&session, AnnotationEdit::Add(one(3.0, "early"))).unwrap();
        let times: Vec<f64> = added.annotations.iter().map(|one| one.time_s).collect();
        assert_eq!(times, [3.0, 12.5]);
        let to = one(20.0, "late");
        let moved = edit(&added, AnnotationEdit::Change { from: one(3.0, "early"), to: to.clone() }).unwrap();
        assert_eq!(moved.annotations[1], to);
        let removed = edit(&moved, AnnotationEdit::Remove(to)).unwrap();
        assert_eq!(removed.annotations, session.annotations);
        for refused in [one(f64::NAN, "when?"), one(1.0, "  "), one(1.0, "two\nlines")] {
            assert!(edit(&session, AnnotationEdit::Add(refused)).is_err());
        }
        let elsewhere = Annotation { flight: "none".to_owned(), ..one(1.0, "where?") };
        assert_eq!(edit(&session, AnnotationEdit::Add(elsewhere)).unwrap_err(), EditError::NoFlight("none".to_owned()));
    }
}
