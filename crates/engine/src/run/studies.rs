//! Studies of a run: each on request, kept while what it follows from stays the same.

use super::experiments::experiment_rows;
use super::pipeline::Run;
use crate::graph::{Cancelled, Stage, StageError};
use crate::snapshot::{ExperimentRows, Slot, Studies};
use crate::study::{
    CheckRequest, CheckStudy, DynamicsStudy, FlightResponses, LagStudy, ManoeuvreStudy, MonteCarloStudy,
    SensitivityStudy, Study, StudyInput,
};

/// Computes the studies that were asked for; of the others shows those still known.
pub(super) fn run(run: &Run<'_>, input: &StudyInput<'_>) -> Result<(), Cancelled> {
    let wanted = run.scope.studies;
    let plain = |study: Study| (wanted.contains(&study), Some(()));
    one::<SensitivityStudy>(run, input, plain(Study::Sensitivity), |studies| &mut studies.sensitivity)?;
    one::<ManoeuvreStudy>(run, input, plain(Study::Manoeuvres), |studies| &mut studies.manoeuvres)?;
    one::<LagStudy>(run, input, plain(Study::Lags), |studies| &mut studies.lags)?;
    one::<FlightResponses>(run, input, plain(Study::Responses), |studies| &mut studies.responses)?;
    let checks =
        wanted.iter().filter_map(|study| if let Study::Checks(request) = study { Some(*request) } else { None });
    let checks = as_last(run, checks.reduce(CheckRequest::and), |studies| Some(studies.checks.latest()?.request));
    one::<CheckStudy>(run, input, checks, |studies| &mut studies.checks)?;
    let noise =
        wanted.iter().find_map(|study| if let Study::MonteCarlo(request) = study { Some(*request) } else { None });
    let noise = as_last(run, noise, |studies| Some(studies.monte_carlo.latest()?.request));
    one::<MonteCarloStudy>(run, input, noise, |studies| &mut studies.monte_carlo)?;
    let trim = wanted.iter().find_map(|study| if let Study::Dynamics(request) = study { Some(*request) } else { None });
    let trim = as_last(run, trim, |studies| Some(studies.dynamics.latest()?.request));
    one::<DynamicsStudy>(run, input, trim, |studies| &mut studies.dynamics)?;
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

/// Whether a study is wanted, and the request it is computed with: that of this run, else that of its last output.
fn as_last<T>(run: &Run<'_>, wanted: Option<T>, last: fn(&Studies) -> Option<T>) -> (bool, Option<T>) {
    (wanted.is_some(), wanted.or_else(|| run.builder.read(|snapshot| last(&snapshot.studies))))
}

fn one<S: for<'i> Stage<Inputs<'i> = &'i StudyInput<'i>>>(
    run: &Run<'_>,
    input: &StudyInput<'_>,
    (is_wanted, params): (bool, Option<S::Params<'_>>),
    slot: fn(&mut Studies) -> &mut Slot<S::Output>,
) -> Result<(), Cancelled> {
    let Some(params) = params else { return Ok(()) };
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
