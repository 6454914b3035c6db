//! The experiments of a session, each run as the session would be with its configuration.

use std::hash::{Hash, Hasher};

use super::pipeline::{Scope, run};
use super::snapshot::{AnySlot, Slot, SlotGroup, Snapshot};
use crate::compare::{ExperimentOutcome, ExperimentRow, PRESENT};
use crate::graph::{Cache, Context, Stage, StageError, StageResult};
use crate::session::{self, Experiment, Session};

/// Rows of the experiments, the session as it is first, by name.
pub type ExperimentRows = NamedSlots<ExperimentRow>;

/// Outputs by name, in an order of their own.
#[derive(Clone, Debug)]
pub struct NamedSlots<T>(pub Vec<(String, Slot<T>)>);

impl<T> Default for NamedSlots<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> NamedSlots<T> {
    /// The output called `name`.
    pub fn row(&self, name: &str) -> Option<&Slot<T>> {
        self.0.iter().find(|(other, _)| other == name).map(|(_, slot)| slot)
    }

    /// Makes room for outputs of these names, all to be computed.
    pub(super) fn begin<'n>(&mut self, names: impl Iterator<Item = &'n str>) {
        let known = std::mem::take(&mut self.0);
        let mut known: Vec<_> = known.into_iter().map(Some).collect();
        let row = |name: &str| {
            let found = known.iter_mut().find(|one| one.as_ref().is_some_and(|(other, _)| other == name));
            let mut slot = found.and_then(Option::take).map(|(_, slot)| slot).unwrap_or_default();
            slot.begin();
            (name.to_owned(), slot)
        };
        self.0 = names.map(row).collect();
    }
}

impl<T> SlotGroup for NamedSlots<T> {
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.0.iter_mut().for_each(|(_, slot)| visit(what, slot));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot)) {
        self.0.iter().for_each(|(name, slot)| visit(format!("{what} '{name}'"), slot));
    }
}

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
    ///
    /// # Errors
    /// One line: why no manoeuvre has a flight path, or that it was stopped.
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
        second_structure: None,
        kept_structures: Vec::new(),
        annotations: Vec::new(),
        report_notes: String::new(),
        report_figures: Vec::new(),
        ..with
    }
}

impl Stage for ExperimentOutcome {
    type Params<'a> = &'a Trial<'a>;
    type Inputs<'a> = ();
    type Output = Self;
    const NAME: &'static str = "experiment";

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
///
/// # Errors
/// One line: why nothing can be computed, or that it was stopped.
fn outcome(
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
    rows.begin(std::iter::once(PRESENT).chain(session.experiments.iter().map(|one| one.name.as_str())));
    show(rows);
    let mut present = None;
    let experiments = std::iter::once(None).chain(session.experiments.iter().map(Some));
    for (index, experiment) in experiments.enumerate() {
        let shown: &ExperimentRows = rows;
        let progress = |part: f32| {
            let mut now = shown.clone();
            now.0[index].1.advance(part);
            show(&now);
        };
        let row = outcome(session, experiment, context, &progress).and_then(|outcome| match experiment {
            None => {
                present = Some(outcome.clone());
                Ok(ExperimentRow::present(outcome))
            }
            Some(experiment) => ExperimentRow::new(experiment, outcome, session, present.as_ref())
                .map_err(|error| error.to_string().into()),
        });
        if row == Err(StageError::Cancelled) {
            rows.each_mut("", &mut |_, slot| slot.end(&StageError::Cancelled));
            show(rows);
            return Err(StageError::Cancelled);
        }
        rows.0[index].1.finish(row.map(Into::into));
        show(rows);
    }
    Ok(())
}
