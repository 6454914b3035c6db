//! One undo for everything: a stack of whole sessions, shared by reference.

use std::sync::Arc;

use crate::session::{Edit, EditError, Experiment, Session};

/// How many steps are kept.
pub const MAX_STEPS: usize = 200;

/// One remembered state and the name of the step that led away from it.
#[derive(Clone, Debug)]
struct Step {
    label: String,
    session: Arc<Session>,
}

/// The session with its past and future.
///
/// A drag is one step: [`History::begin`] it, apply edits freely, [`History::commit`] it. An edit that changes nothing is no step.
/// Kept experiments are results: keeping one is no step either, and it stays through every undo and redo.
#[derive(Clone, Debug)]
pub struct History {
    present: Arc<Session>,
    past: Vec<Step>,
    future: Vec<Step>,
    open: Option<Step>,
    saved: Option<Arc<Session>>,
}

impl History {
    /// A history that starts at `session`, which counts as saved.
    pub fn new(session: Session) -> Self {
        let present = Arc::new(session);
        Self { saved: Some(Arc::clone(&present)), present, past: Vec::new(), future: Vec::new(), open: None }
    }

    /// A history that starts at `session`, which no file has.
    pub(crate) fn new_unsaved(session: Arc<Session>) -> Self {
        Self { present: session, past: Vec::new(), future: Vec::new(), open: None, saved: None }
    }

    /// The session as it is now.
    pub fn present(&self) -> &Arc<Session> {
        &self.present
    }

    /// Whether the session differs from the one last saved.
    pub fn is_modified(&self) -> bool {
        self.saved.as_ref().is_none_or(|saved| !Arc::ptr_eq(saved, &self.present) && **saved != *self.present)
    }

    /// The session its file has.
    pub fn saved(&self) -> Option<&Arc<Session>> {
        self.saved.as_ref()
    }

    /// Notes that the present session is now the one in the file.
    pub fn mark_saved(&mut self) {
        self.saved = Some(Arc::clone(&self.present));
    }

    /// Writes past, present and future anew by `change`: for what is no step, such as the folder that paths start from.
    pub(crate) fn replace_all(&mut self, change: impl Fn(&Session) -> Session) {
        let replace = |session: &mut Arc<Session>| *session = Arc::new(change(session));
        let steps = self.past.iter_mut().chain(&mut self.future).chain(&mut self.open);
        steps.for_each(|step| replace(&mut step.session));
        replace(&mut self.present);
        self.saved.iter_mut().for_each(replace);
    }

    /// Applies an edit. Within [`History::begin`] and [`History::commit`] it joins the open step.
    ///
    /// # Errors
    /// Those of [`Edit::apply`]; the session is then unchanged.
    pub fn apply(&mut self, edit: &Edit) -> Result<(), EditError> {
        let next = edit.apply(&self.present)?;
        if next == *self.present {
            return Ok(());
        }
        if edit.keeps_experiments() {
            self.keep_in_all_steps(&next.experiments[self.present.experiments.len()..]);
        } else if self.open.is_none() {
            self.push(Step { label: edit.label(), session: Arc::clone(&self.present) });
        }
        self.present = Arc::new(next);
        Ok(())
    }

    /// Adds kept experiments to every session that undo and redo lead to.
    fn keep_in_all_steps(&mut self, kept: &[Experiment]) {
        let steps = self.past.iter_mut().chain(&mut self.future).chain(&mut self.open);
        steps.for_each(|step| step.session = Arc::new(step.session.with_experiments(kept)));
    }

    /// One step to another session.
    pub fn step(&mut self, label: &str, session: Arc<Session>) {
        self.commit();
        let before = std::mem::replace(&mut self.present, session);
        self.push(Step { label: label.to_owned(), session: before });
    }

    /// Opens a step that gathers the edits of one gesture under `label`.
    pub fn begin(&mut self, label: &str) {
        if self.open.is_none() {
            self.open = Some(Step { label: label.to_owned(), session: Arc::clone(&self.present) });
        }
    }

    /// Whether a step is open.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Closes the open step; one that changed nothing leaves no trace.
    pub fn commit(&mut self) {
        if let Some(step) = self.open.take()
            && *step.session != *self.present
        {
            self.push(step);
        }
    }

    /// Abandons the open step and returns to the session before it.
    pub fn abort(&mut self) {
        if let Some(step) = self.open.take() {
            self.present = step.session;
        }
    }

    /// Name of the step that undo would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.past.last().map(|step| step.label.as_str())
    }

    /// Name of the step that redo would bring again.
    pub fn redo_label(&self) -> Option<&str> {
        self.future.last().map(|step| step.label.as_str())
    }

    /// Names of all steps there are, the oldest first, and how many of them are done: the others were taken back.
    pub fn steps(&self) -> (Vec<&str>, usize) {
        let past = self.past.iter().map(|step| step.label.as_str());
        let future = self.future.iter().rev().map(|step| step.label.as_str());
        (past.chain(future).collect(), self.past.len())
    }

    /// Takes steps back, or brings them again, until `done` of them are; `false` where that changes nothing.
    pub fn go_to(&mut self, done: usize) -> bool {
        self.commit();
        let before = self.past.len();
        while self.past.len() > done && self.undo() {}
        while self.past.len() < done && self.redo() {}
        self.past.len() != before
    }

    /// Takes the last step back; `false` when there is none.
    pub fn undo(&mut self) -> bool {
        self.commit();
        let Some(step) = self.past.pop() else { return false };
        let undone = std::mem::replace(&mut self.present, step.session);
        self.future.push(Step { label: step.label, session: undone });
        true
    }

    /// Brings the last undone step again; `false` when there is none.
    pub fn redo(&mut self) -> bool {
        self.commit();
        let Some(step) = self.future.pop() else { return false };
        let before = std::mem::replace(&mut self.present, step.session);
        self.past.push(Step { label: step.label, session: before });
        true
    }

    fn push(&mut self, step: Step) {
        if self.past.len() == MAX_STEPS {
            self.past.remove(0);
        }
        self.past.push(step);
        self.future.clear();
    }
}
