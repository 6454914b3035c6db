//! Fixes of findings, each tried on the session as it is: the verdict there would be.

use super::experiments::outcome;
use crate::graph::{Context, StageError, StageResult};
use crate::session::{Fix, Session};
use crate::snapshot::TriedFixes;

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
