//! The experiments of a session, each run as the session would be with its configuration.

use std::hash::{Hash, Hasher};

use super::pipeline::{Scope, run};
use super::snapshot::{AnySlot, Slot, SlotGroup, Snapshot};
use crate::compare::{ExperimentOutcome, ExperimentRow, PRESENT};
use crate::graph::{Cache, Context, Stage, StageError, StageResult};
use crate::session::{self, Experiment, Session};

/// Rows of the experiments, the session as it is first, by name.
#[derive(Clone, Debug, Default)]
pub struct ExperimentRows(pub Vec<(String, Slot<ExperimentRow>)>);

impl ExperimentRows {
    /// The row called `name`.
    pub fn row(&self, name: &str) -> Option<&Slot<ExperimentRow>> {
        self.0.iter().find(|(other, _)| other == name).map(|(_, slot)| slot)
    }

    /// Makes room for the rows of a session, all to be computed.
    fn begin(&mut self, session: &Session) {
        let known = std::mem::take(&mut self.0);
        let names = std::iter::once(PRESENT).chain(session.experiments.iter().map(|one| one.name.as_str()));
        let row = |name: &str| {
            let slot = known.iter().find(|(other, _)| other == name).map(|(_, slot)| slot.clone());
            let mut slot = slot.unwrap_or_default();
            slot.begin();
            (name.to_owned(), slot)
        };
        self.0 = names.map(row).collect();
    }
}

impl SlotGroup for ExperimentRows {
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
        let folder = context.folder();
        let scope =
            Scope { session: trial.session, folder, first: None, studies: &[], cause: "experiment", generation: 1 };
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
        Ok(ExperimentOutcome::new(trial.session, &snapshot))
    }
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
    let session = trial(session, experiment);
    let text = session::print(&session).map_err(|error| error.to_string())?;
    let found = context.get_watched::<ExperimentOutcome>(&Trial { session: &session, text }, (), progress)?;
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
    rows.begin(session);
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
