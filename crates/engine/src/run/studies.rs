//! Studies of a run: each on request, kept while what it follows from stays the same.

use super::experiments::{ExperimentRows, experiment_rows};
use super::pipeline::Run;
use super::snapshot::{Slot, Studies};
use crate::graph::{Cancelled, Stage, StageError};
use crate::study::{
    CheckStudy, DynamicsStudy, FlightResponses, LagStudy, ManoeuvreStudy, MonteCarloStudy, SensitivityStudy, Study,
    StudyInput,
};

/// Computes the studies that were asked for; of the others shows those still known.
pub(super) fn run(run: &Run<'_>, input: &StudyInput<'_>) -> Result<(), Cancelled> {
    let wanted = run.scope.studies;
    one::<ManoeuvreStudy>(run, input, wanted.contains(&Study::Manoeuvres), (), |studies| &mut studies.manoeuvres)?;
    one::<SensitivityStudy>(run, input, wanted.contains(&Study::Sensitivity), (), |studies| &mut studies.sensitivity)?;
    let checks = wanted.iter().filter_map(|study| match study {
        Study::Checks(request) => Some(*request),
        _ => None,
    });
    let checks = checks.max_by_key(|request| request.filter_error);
    let shown = || run.builder.read(|snapshot| Some(snapshot.studies.checks.latest()?.request));
    if let Some(known) = checks.or_else(shown) {
        one::<CheckStudy>(run, input, checks.is_some(), known, |studies| &mut studies.checks)?;
    }
    one::<LagStudy>(run, input, wanted.contains(&Study::Lags), (), |studies| &mut studies.lags)?;
    one::<FlightResponses>(run, input, wanted.contains(&Study::Responses), (), |studies| &mut studies.responses)?;
    let noise = wanted.iter().find_map(|study| match study {
        Study::MonteCarlo { realisations, seed } => Some((*realisations, *seed)),
        _ => None,
    });
    let shown = || -> Option<(usize, u64)> {
        let known = |study: &MonteCarloStudy| (study.realisations, study.seed);
        run.builder.read(|snapshot| Some(known(snapshot.studies.monte_carlo.latest()?)))
    };
    if let Some(known) = noise.or_else(shown) {
        one::<MonteCarloStudy>(run, input, noise.is_some(), known, |studies| &mut studies.monte_carlo)?;
    }
    let trim = wanted.iter().find_map(|study| match study {
        Study::Dynamics(request) => Some(*request),
        _ => None,
    });
    let shown = || run.builder.read(|snapshot| Some(snapshot.studies.dynamics.latest()?.request));
    if let Some(known) = trim.or_else(shown) {
        one::<DynamicsStudy>(run, input, trim.is_some(), known, |studies| &mut studies.dynamics)?;
    }
    if wanted.contains(&Study::Experiments) {
        let mut rows = run.builder.read(|snapshot| snapshot.studies.experiments.clone());
        // A run that was stopped shows no more rows; the experiments find out by themselves.
        let show = |rows: &ExperimentRows| {
            let _ = run.builder.update(|snapshot| snapshot.studies.experiments.clone_from(rows));
        };
        experiment_rows(run.scope.session, &mut rows, run.context, &show).map_err(|_| Cancelled)?;
    }
    Ok(())
}

fn one<S: for<'i> Stage<Inputs<'i> = &'i StudyInput<'i>>>(
    run: &Run<'_>,
    input: &StudyInput<'_>,
    is_wanted: bool,
    params: S::Params<'_>,
    slot: fn(&mut Studies) -> &mut Slot<S::Output>,
) -> Result<(), Cancelled> {
    let result = if is_wanted {
        // A run that was stopped shows no more progress; the study finds out by itself.
        let progress = |part| {
            let _ = run.builder.update(|snapshot| slot(&mut snapshot.studies).advance(part));
        };
        run.context.get_watched::<S>(params, input, &progress)
    } else {
        match run.context.find::<S>(&params, &input) {
            Ok(known) => Ok(known),
            Err(_) => return Ok(()),
        }
    };
    if matches!(result, Err(StageError::Cancelled)) {
        return Err(Cancelled);
    }
    run.builder.step(|snapshot| slot(&mut snapshot.studies).finish(result))
}
