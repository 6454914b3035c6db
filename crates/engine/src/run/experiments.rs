//! The experiments of a session, each run as the session would be with its configuration.

use std::hash::{Hash, Hasher};

use super::pipeline::{Scope, run};
use crate::graph::{Cache, Context, Stage, StageError, StageResult};
use crate::session::{self, Experiment, Session};
use crate::snapshot::{ExperimentOutcome, ExperimentRow, ExperimentRows, PRESENT, Snapshot};
use crate::study::EXPERIMENT;

/// A session to run, known by its saved form.
pub struct Trial<'a> {
    session: &'a Session,
    text: String,
}

impl Hash for Trial<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.text.hash(state);
    }
}

impl Trial<'_> {
    /// Runs it.
    pub(super) fn snapshot(&self, context: &Context<'_>) -> StageResult<Snapshot> {
        let (session, folder) = (self.session, context.folder());
        let scope = Scope { session, folder, first: None, studies: &[], cause: "experiment", generation: 1 };
        let unkept = Cache::new(0);
        let cache = context.cache().unwrap_or(&unkept);
        let show = |snapshot: Snapshot| context.advance(snapshot.progress);
        let snapshot = run(&scope, &Snapshot::default(), cache, context.control(), &show);
        context.checkpoint()?;
        context.declare(&snapshot.files);
        if snapshot.windows.values().all(|window| window.path.ready().is_none()) {
            let first = snapshot.failures().into_iter().next();
            let line = first.map_or("no manoeuvre is in use".to_owned(), |(place, error)| format!("{place}: {error}"));
            return Err(StageError::Failed(line));
        }
        Ok(snapshot)
    }
}

/// The session with the configuration of an experiment and nothing beside it that no result follows from.
fn trial(session: &Session, experiment: Option<&Experiment>) -> Session {
    let with = experiment.map_or_else(|| session.clone(), |one| one.configuration.applied_to(session));
    Session {
        experiments: Vec::new(),
        annotations: Vec::new(),
        refused: Vec::new(),
        report_purpose: String::new(),
        report_asked: Vec::new(),
        report_notes: String::new(),
        report_figures: Vec::new(),
        ..with
    }
}

impl Stage for ExperimentOutcome {
    type Params<'a> = &'a Trial<'a>;
    type Inputs<'a> = ();
    type Output = Self;
    const NAME: &'static str = EXPERIMENT;

    fn run(trial: &Trial<'_>, (): (), context: &Context<'_>) -> StageResult<Self> {
        Ok(ExperimentOutcome::new(trial.session, &trial.snapshot(context)?))
    }
}

/// Hands the session with the configuration of an experiment (without one as it is) to a stage.
///
/// # Errors
/// Should the session have no saved form; those of `then`.
pub(super) fn with_trial<T>(
    session: &Session,
    experiment: Option<&Experiment>,
    then: impl FnOnce(&Trial<'_>) -> StageResult<T>,
) -> StageResult<T> {
    let session = trial(session, experiment);
    let text = session::print(&session).map_err(|error| error.to_string())?;
    then(&Trial { session: &session, text })
}

/// What the session gives with the configuration of an experiment; without one as it is.
pub(super) fn outcome(
    session: &Session,
    experiment: Option<&Experiment>,
    context: &Context<'_>,
    progress: &(dyn Fn(f32) + Sync),
) -> StageResult<ExperimentOutcome> {
    let found = with_trial(session, experiment, |trial| context.get_watched::<ExperimentOutcome>(trial, (), progress))?;
    Ok(ExperimentOutcome::clone(&found))
}

/// Computes the rows of a session one after another, that of the session as it is first; `show` hears of every change.
///
/// # Errors
/// That it was stopped. A row that cannot be computed says why.
pub fn experiment_rows(
    session: &Session,
    rows: &mut ExperimentRows,
    context: &Context<'_>,
    show: &(dyn Fn(&ExperimentRows) + Sync),
) -> StageResult<()> {
    let experiments: Vec<_> = std::iter::once(None).chain(session.experiments.iter().map(Some)).collect();
    let mut present = None;
    let name = |experiment: &Option<&Experiment>| experiment.map_or(PRESENT, |one| &one.name).to_owned();
    rows.fill(experiments.iter().map(name), show, |index, progress| {
        let outcome = outcome(session, experiments[index], context, progress)?;
        let row = match experiments[index] {
            None => {
                present = Some(outcome.clone());
                ExperimentRow::present(outcome)
            }
            Some(experiment) => {
                let row = ExperimentRow::new(experiment, outcome, session, present.as_ref());
                row.map_err(|error| StageError::from(error.to_string()))?
            }
        };
        Ok(row.into())
    })
}
