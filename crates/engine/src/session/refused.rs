//! Candidates that were refused: manoeuvres found in a recording that the session does not want.

use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

use super::{EditError, Manoeuvre, Session};

/// Most that either end of a candidate may move before it is another one: filters and resampling of the channels move it a little, s.
const SAME_S: f64 = 0.5;

/// A candidate that was refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefusedCandidate {
    /// Flight it lies in.
    pub flight: String,
    /// What it was called.
    pub name: String,
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
}

/// A change of the refused candidates.
#[derive(Clone, Debug, PartialEq)]
pub enum CandidateEdit {
    Refuse(Vec<Manoeuvre>),
    /// Offers the refused candidates of a flight again; those of all flights without one.
    Offer(Option<String>),
}

impl RefusedCandidate {
    fn new(candidate: &Manoeuvre) -> Self {
        let TimeRange { start_s, end_s } = candidate.window;
        Self { flight: candidate.flight.clone(), name: candidate.name.clone(), start_s, end_s }
    }

    fn is(&self, candidate: &Manoeuvre) -> bool {
        let TimeRange { start_s, end_s } = candidate.window;
        (self.start_s - start_s).abs() < SAME_S
            && (self.end_s - end_s).abs() < SAME_S
            && self.flight == candidate.flight
    }
}

impl Session {
    /// Whether a candidate was refused.
    pub fn has_refused(&self, candidate: &Manoeuvre) -> bool {
        self.refused.iter().any(|refused| refused.is(candidate))
    }
}

impl CandidateEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Refuse(candidates) => match candidates.as_slice() {
                [one] => format!("refuse candidate {}", one.name),
                several => format!("refuse {} candidates", several.len()),
            },
            Self::Offer(_) => "offer refused candidates again".to_owned(),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        match self {
            Self::Refuse(candidates) => {
                for candidate in candidates {
                    if session.flight(&candidate.flight).is_none() {
                        return Err(EditError::NoFlight(candidate.flight.clone()));
                    }
                    if !session.has_refused(candidate) {
                        session.refused.push(RefusedCandidate::new(candidate));
                    }
                }
                session.refused.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
            }
            Self::Offer(flight) => {
                session.refused.retain(|refused| flight.as_ref().is_some_and(|flight| *flight != refused.flight));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::session::{self, Edit};

    fn candidate(start_s: f64) -> Manoeuvre {
        Manoeuvre::new("doublet".to_owned(), "FT1".to_owned(), TimeRange::new(start_s, start_s + 8.0))
    }

    #[test]
    fn refused_candidates_are_saved_known_again_and_offered_again() {
        let text = builtin::session("demo").unwrap();
        let session = session::parse(text).unwrap();
        assert!(session.refused.is_empty() && !session.has_refused(&candidate(10.0)));
        let refuse = Edit::Candidate(CandidateEdit::Refuse(vec![candidate(30.0), candidate(10.0)]));
        let refused = refuse.apply(&session).unwrap();
        assert_eq!(refused.refused.iter().map(|one| one.start_s).collect::<Vec<_>>(), [10.0, 30.0]);
        assert_eq!(session::parse(&session::print(&refused).unwrap()).unwrap(), refused);
        // Another filter of the channels moves its ends a little; another manoeuvre lies elsewhere.
        assert!(refused.has_refused(&candidate(10.2)) && !refused.has_refused(&candidate(12.0)));
        assert!(!refused.has_refused(&Manoeuvre { flight: "FT2".to_owned(), ..candidate(10.0) }));
        assert_eq!(refuse.apply(&refused).unwrap(), refused, "nothing is refused twice");
        let other = Edit::Candidate(CandidateEdit::Offer(Some("FT2".to_owned()))).apply(&refused).unwrap();
        assert_eq!(other, refused);
        assert_eq!(Edit::Candidate(CandidateEdit::Offer(None)).apply(&refused).unwrap(), session);
        let labels = [vec![candidate(1.0)], vec![candidate(1.0), candidate(9.0)]];
        let labels = labels.map(|candidates| Edit::Candidate(CandidateEdit::Refuse(candidates)).label());
        assert_eq!(labels, ["refuse candidate doublet", "refuse 2 candidates"]);
    }
}
