//! Results of chosen experiments, drawn over those of the session.

use super::experiments::{Trial, with_trial};
use crate::graph::{Context, Stage, StageResult};
use crate::session::Session;
use crate::snapshot::{OverlaidResults, Overlays, Snapshot};

/// Most experiments that are overlaid: more curves cannot be told apart.
pub const MOST_OVERLAID: usize = 2;

impl Stage for OverlaidResults {
    type Params<'a> = &'a Trial<'a>;
    type Inputs<'a> = ();
    type Output = Self;
    const NAME: &'static str = "overlaid experiment";

    fn run(trial: &Trial<'_>, (): (), context: &Context<'_>) -> StageResult<Self> {
        let Snapshot { windows, pooled, .. } = trial.snapshot(context)?;
        Ok(Self { windows, pooled })
    }
}

/// Computes the overlaid experiments `names` of a session one after another; `show` hears of every change.
///
/// # Errors
/// That it was stopped. An experiment that cannot be computed says why.
pub(super) fn overlay_experiments(
    session: &Session,
    names: &[String],
    overlays: &mut Overlays,
    context: &Context<'_>,
    show: &(dyn Fn(&Overlays) + Sync),
) -> StageResult<()> {
    let found: Vec<_> = names.iter().filter_map(|name| session.experiment(name)).take(MOST_OVERLAID).collect();
    overlays.fill(found.iter().map(|one| one.name.clone()), show, |index, progress| {
        with_trial(session, Some(found[index]), |trial| context.get_watched::<OverlaidResults>(trial, (), progress))
    })
}
