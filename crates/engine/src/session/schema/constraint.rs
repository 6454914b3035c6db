//! The saved form of what is known of derivatives.

use doublet_core::estimate::Constraint;
use doublet_core::model::{Coefficient, Term};
use serde::{Deserialize, Serialize};

use super::super::TermConstraint;
use super::{SessionError, unknown};

/// One constraint: `fixed`, `lower` and `upper` or one of them, or `mean` and `deviation`.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConstraintTable {
    coefficient: String,
    term: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fixed: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lower: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    upper: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mean: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    deviation: Option<f64>,
}

/// The saved form of a constraint.
pub(super) fn constraint_table(constraint: &TermConstraint) -> ConstraintTable {
    let (coefficient, term) = (constraint.coefficient.name().to_owned(), constraint.term.to_string());
    let bare = ConstraintTable { coefficient, term, ..ConstraintTable::default() };
    match constraint.known {
        Constraint::Free => bare,
        Constraint::Fixed(value) => ConstraintTable { fixed: Some(value), ..bare },
        Constraint::Bounds { lower, upper } => {
            let stated = |bound: f64| (!bound.is_infinite()).then_some(bound);
            ConstraintTable { lower: stated(lower), upper: stated(upper), ..bare }
        }
        Constraint::Prior { mean, deviation } => {
            ConstraintTable { mean: Some(mean), deviation: Some(deviation), ..bare }
        }
    }
}

/// The constraint of a saved form.
pub(super) fn constraint_from(table: ConstraintTable) -> Result<TermConstraint, SessionError> {
    let ConstraintTable { coefficient, term, fixed, lower, upper, mean, deviation } = table;
    let place = format!("estimation.constraint of {coefficient} '{term}'");
    let names = Coefficient::ALL.map(Coefficient::name);
    let found = Coefficient::from_name(&coefficient);
    let found = found.ok_or_else(|| unknown("estimation.constraint", "coefficient", &coefficient, &names))?;
    let term =
        Term::parse(&term).map_err(|error| SessionError::Term { place: place.clone(), reason: error.to_string() })?;
    let known = match (fixed, (lower, upper), (mean, deviation)) {
        (Some(value), (None, None), (None, None)) => Constraint::Fixed(value),
        (None, (None, None), (Some(mean), Some(deviation))) => Constraint::Prior { mean, deviation },
        (None, (Some(_), _) | (_, Some(_)), (None, None)) => {
            Constraint::Bounds { lower: lower.unwrap_or(f64::NEG_INFINITY), upper: upper.unwrap_or(f64::INFINITY) }
        }
        _ => {
            let reason = "state either `fixed`, or `lower` and `upper` (or one), or `mean` and `deviation`".to_owned();
            return Err(SessionError::Term { place, reason });
        }
    };
    Ok(TermConstraint { coefficient: found, term, known })
}
