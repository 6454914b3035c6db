//! What is known of derivatives before the fit.

use doublet_core::estimate::Constraint;
use doublet_core::model::{Coefficient, Term};

use super::check::contradiction;
use super::edit::EditError;
use super::{Estimation, Session};
use crate::session::Finding;

/// What is known of one derivative before the fit.
#[derive(Clone, Debug, PartialEq, Hash)]
pub struct TermConstraint {
    pub coefficient: Coefficient,
    pub term: Term,
    /// Value, range, or expectation with its standard deviation.
    pub known: Constraint,
}

impl TermConstraint {
    /// What is known, in words: `fixed at -12`.
    pub fn summary(&self) -> String {
        match self.known {
            Constraint::Free => "free".to_owned(),
            Constraint::Fixed(value) => format!("fixed at {value}"),
            Constraint::Bounds { lower, upper } if lower == f64::NEG_INFINITY => format!("at most {upper}"),
            Constraint::Bounds { lower, upper } if upper == f64::INFINITY => format!("at least {lower}"),
            Constraint::Bounds { lower, upper } => format!("between {lower} and {upper}"),
            Constraint::Prior { mean, deviation } => format!("expected at {mean} ± {deviation}"),
        }
    }

    pub fn derivative(&self) -> String {
        self.term.derivative_name(self.coefficient)
    }
}

impl Estimation {
    /// What is known of the derivative of `coefficient` with respect to `term`.
    pub fn known(&self, coefficient: Coefficient, term: &Term) -> Constraint {
        let found = self.constraints.iter().find(|known| known.coefficient == coefficient && known.term == *term);
        found.map_or(Constraint::Free, |known| known.known)
    }

    /// States what is known of a derivative; [`Constraint::Free`] forgets it.
    pub(super) fn constrain(&mut self, constraint: TermConstraint) -> Result<(), EditError> {
        if let Some((value, allowed)) = fault(constraint.known) {
            return Err(EditError::Value {
                field: format!("constraint of {}", constraint.derivative()),
                value,
                allowed,
            });
        }
        let place = |other: &TermConstraint| (other.coefficient, other.term.clone());
        let own = place(&constraint);
        self.constraints.retain(|other| place(other) != own);
        if constraint.known != Constraint::Free {
            let at = self.constraints.partition_point(|other| place(other) < own);
            self.constraints.insert(at, constraint);
        }
        Ok(())
    }
}

impl Session {
    fn has_term(&self, coefficient: Coefficient, term: &Term) -> bool {
        self.structure.terms(coefficient).is_some_and(|terms| terms.contains(term))
    }

    /// Forgets what is known of terms that the structure has no longer.
    pub(super) fn forget_lost_terms(&mut self) {
        let mut constraints = std::mem::take(&mut self.estimation.constraints);
        constraints.retain(|known| self.has_term(known.coefficient, &known.term));
        self.estimation.constraints = constraints;
    }
}

/// What is wrong with the numbers of a constraint.
fn fault(known: Constraint) -> Option<(f64, &'static str)> {
    match known {
        Constraint::Bounds { lower: f64::NEG_INFINITY, upper: f64::INFINITY } => {
            Some((f64::INFINITY, "at least one finite bound"))
        }
        _ => known.fault(),
    }
}

/// What is wrong with the constraints of a session.
pub(super) fn findings(session: &Session) -> Vec<Finding> {
    let constraints = session.estimation.constraints.iter().enumerate();
    constraints.filter_map(|(index, known)| judge_constraint(session, index, known)).collect()
}

fn judge_constraint(session: &Session, index: usize, known: &TermConstraint) -> Option<Finding> {
    let name = known.derivative();
    let again = |other: &&TermConstraint| other.coefficient == known.coefficient && other.term == known.term;
    let (text, fix_text) = if let Some((value, allowed)) = fault(known.known) {
        (format!("{value} is not allowed, expected {allowed}"), "change it")
    } else if !session.has_term(known.coefficient, &known.term) {
        let text = format!("{} has no term '{}'", known.coefficient.name(), known.term);
        (text, "add the term or remove the constraint")
    } else if session.estimation.constraints[..index].iter().any(|other| again(&other)) {
        ("stated twice".to_owned(), "remove one")
    } else {
        return None;
    };
    Some(contradiction(format!("estimation.constraint of {name}"), text, fix_text).with_setting("Model", ""))
}
