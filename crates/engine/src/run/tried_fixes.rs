//! Fixes of findings, each tried on the session as it is: the verdict there would be.

use super::experiments::outcome;
use super::named_slots::NamedSlots;
use crate::compare::ExperimentOutcome;
use crate::graph::{Context, StageError, StageResult};
use crate::session::{Fix, Session};

/// What each fix gives.
pub type TriedFixes = NamedSlots<ExperimentOutcome, Fix>;

/// Computes the session with each of `fixes` applied alone, one after another; `show` hears of every change.
///
/// # Errors
/// That it was stopped. A fix that cannot be applied or computed says why.
pub fn try_fixes(
    session: &Session,
    fixes: &[Fix],
    tried: &mut TriedFixes,
    context: &Context<'_>,
    show: &(dyn Fn(&TriedFixes) + Sync),
) -> StageResult<()> {
    tried.fill(fixes.iter().cloned(), show, |index, progress| {
        let fixed = fixes[index].apply(session).map_err(|error| StageError::from(error.to_string()))?;
        outcome(&fixed, None, context, progress).map(Into::into)
    })
}
