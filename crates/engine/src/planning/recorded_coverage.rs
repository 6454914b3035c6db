//! Coverage of the intervals through recorders: files on clocks of their own, read and identified as a session is.

use std::path::Path;

use doublet_core::simulate::{self, Scenario};

use crate::graph::{Cache, Context, StageError, StageResult};
use crate::run::{Scope, Snapshot, run};
use crate::session::{DelaySource, GustSource, Session};
use crate::study::{Coverage, Estimate, estimates, flown_loading, summarise, windows};

/// File of the truth, which a recorder does not have.
const TRUTH_FILE: &str = "truth.h5";

/// [`crate::study::coverage`] with every flight written by its recorders (rates, clocks, resolution, fuel probes, control sensors) and run as
/// a session: channel maps, clocks and instruments are those of `session`'s first flight, and the corrected errors contain those of the path.
/// Gusts and delays are estimated.
///
/// # Errors
/// As [`crate::study::coverage`]; files that cannot be written or read.
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
    let session = recorded_session(session, scenario, folder.path())?;
    let scope =
        Scope { session: &session, folder: folder.path(), first: None, studies: &[], cause: "coverage", generation: 1 };
    let snapshot = run(&scope, &Snapshot::default(), &Cache::new(0), context.control(), &|_| ());
    context.checkpoint()?;
    if let Some((place, error)) = snapshot.failures().into_iter().next() {
        return Err(format!("{place}: {error}").into());
    }
    let pooled = snapshot.pooled.ready().ok_or(StageError::NotApplicable)?;
    estimates((**pooled).clone(), |fit| &fit.corrected_errors)
}

/// The session over the recordings in `folder`, with the windows and the loading of the scenario.
fn recorded_session(session: &Session, scenario: &Scenario, folder: &Path) -> StageResult<Session> {
    let mut flight = session.flights.first().ok_or("the session has no flight whose recorders could be used")?.clone();
    for recording in &mut flight.recordings {
        let file = recording.path.rsplit('/').next().unwrap_or_default();
        recording.path = folder.join(file).to_string_lossy().into_owned();
        recording.sha256 = None;
    }
    flight.recordings.retain(|recording| Path::new(&recording.path).file_name().is_some_and(|name| name != TRUTH_FILE));
    let mut windows = windows(scenario);
    windows.iter_mut().for_each(|window| window.flight.clone_from(&flight.name));
    Ok(Session {
        loading: Some(flown_loading(scenario)),
        flights: vec![flight],
        windows,
        steady: Vec::new(),
        gusts: GustSource::Estimated,
        delays: DelaySource::Estimated,
        experiments: Vec::new(),
        ..session.clone()
    })
}
