//! Coverage of the intervals through recorders: files on clocks of their own, read and identified as a session is.

use doublet_core::simulate::{self, Scenario};

use crate::graph::{Cache, Context, StageError, StageResult};
use crate::planning::designed_session;
use crate::run::{Scope, run};
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::study::{Coverage, Estimate, estimates, flown_loading, summarise, windows};

/// [`crate::study::coverage`] with every flight written by its recorders (rates, clocks, resolution, fuel probes, control sensors) and run as
/// a session: channel maps, clocks and instruments are those of `session`'s first flight, and the corrected errors contain those of the path.
/// Gusts and delays are estimated.
pub fn recorded_coverage(
    session: &Session,
    scenario: &Scenario,
    (realisations, first_seed): (usize, u64),
    context: &Context<'_>,
) -> StageResult<Coverage> {
    let context = context.parts(realisations);
    // One after the other: a run takes all cores.
    let one = |index: usize| -> StageResult<Vec<Estimate>> {
        context.checkpoint()?;
        let seed = first_seed + index as u64;
        let found = identify_recorded(session, scenario, seed, &context);
        let found = found.map_err(|error| error.at(format!("seed {seed}")))?;
        context.step();
        Ok(found)
    };
    let found = (0..realisations).map(one).collect::<StageResult<Vec<_>>>()?;
    Ok(summarise(scenario, windows(scenario).len(), &found))
}

/// Flies once, writes the recordings into a folder that goes, and runs the session over them.
fn identify_recorded(
    session: &Session,
    scenario: &Scenario,
    seed: u64,
    context: &Context<'_>,
) -> StageResult<Vec<Estimate>> {
    let flight = simulate::run(scenario, seed, &mut |_| !context.control().is_cancelled());
    context.checkpoint()?;
    let folder = tempfile::tempdir().map_err(|error| format!("a folder for the recordings: {error}"))?;
    flight?.write(folder.path())?;
    let recorded = Session { loading: Some(flown_loading(scenario)), ..session.clone() };
    let session = designed_session(&recorded, scenario, &folder.path().to_string_lossy())?;
    let scope =
        Scope { session: &session, folder: folder.path(), first: None, studies: &[], cause: "coverage", generation: 1 };
    let snapshot = run(&scope, &Snapshot::default(), &Cache::new(0), context.control(), &|_| ());
    context.checkpoint()?;
    if let Some((place, error)) = snapshot.failures().into_iter().next() {
        return Err(format!("{place}: {error}").into());
    }
    let pooled = snapshot.pooled.ready().ok_or(StageError::NotApplicable)?;
    estimates(pooled, |fit| &fit.corrected_errors)
}
