//! Before drawing: results are taken in, keys become commands, commands and edits are carried out, a run is asked for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_engine::run::Snapshot;
use doublet_engine::session::{Edit, Manoeuvre, Session, WindowEdit};
use doublet_engine::study::Study;
use eframe::egui::{self, KeyboardShortcut, Modifiers, ViewportCommand};

use super::dispatch::dispatch;
use super::{Document, Pending, Workbench};
use crate::command::{UiCommand, ViewCommand};
use crate::panels::{self, EditRequest};
use crate::ui_state::UiState;
use crate::widgets::time_view::TimeRange;

/// What Escape asks for.
const CLEAR_MARKERS: UiCommand = UiCommand::View(ViewCommand::ClearMarkers);
/// Choices of manoeuvres that an undo can go back to.
const CHOICES: usize = 32;

/// One step.
pub fn run(app: &mut Workbench, ctx: &egui::Context) {
    app.snapshot = app.engine.snapshot();
    if app.snapshot.generation >= app.awaited && !app.snapshot.busy {
        app.studies.clear();
    }
    let hovered_s = app.hovered_s.take();
    let hovered_s = app.link_second(hovered_s);
    app.state.time.cursor_s = hovered_s;
    app.state.window_time.cursor_s = hovered_s;
    app.take_export();
    app.take_opening(ctx);
    app.take_beginning();
    app.follow_verdict();
    take_files(app, ctx);
    app.notice_change(ctx);
    take_shortcuts(app, ctx);
    for command in std::mem::take(&mut app.commands) {
        dispatch(app, command, ctx);
    }
    for request in std::mem::take(&mut app.edits) {
        edit(app, request);
    }
    app.keep_work();
    keep_selection(app);
    keep_computing(app, ctx);
    let title = title(&app.document);
    if title != app.title {
        ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
        app.title = title;
    }
}

/// Title of the window: file, a dot while there is something to save, and whether another program has the file.
fn title(document: &Document) -> String {
    let name = document.path.as_deref().and_then(Path::file_name).and_then(|name| name.to_str());
    let mark = if document.history.is_modified() { "• " } else { "" };
    let held = if document.held_by().is_some() { " (open elsewhere)" } else { "" };
    match name.unwrap_or(document.session().title.as_str()) {
        "" => "doublet".to_owned(),
        name => format!("{mark}{name}{held} – doublet"),
    }
}

/// Files dropped on the window, files chosen in a dialog, and the wish to close the window.
fn take_files(app: &mut Workbench, ctx: &egui::Context) {
    let dropped = ctx.input_mut(|input| std::mem::take(&mut input.raw.dropped_files));
    let dropped: Vec<_> = dropped.iter().map(|file| file.path().to_path_buf()).collect();
    let is_session = |path: &&PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if let Some(session) = dropped.iter().find(is_session) {
        app.leave(Pending::Open(session.clone()), ctx);
    } else if !dropped.is_empty() {
        // Several recordings are those of one flight by several recorders.
        app.leave(Pending::Begin(dropped), ctx);
    }
    if ctx.input(|input| input.viewport().close_requested()) && !app.leaving && app.document.history.is_modified() {
        ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        app.guarded = Some(Pending::Quit);
    }
}

/// Turns pressed keys into commands, those with most modifiers first. While a field has the keyboard, or the palette is
/// open, keys without Ctrl or Alt belong to it.
fn take_shortcuts(app: &mut Workbench, ctx: &egui::Context) {
    // Escape closes an open menu before it clears anything.
    let menu = egui::Popup::is_any_open(ctx);
    // Escape takes the keyboard from a field before this is called, and still belongs to the field.
    let typing = app.typing || ctx.egui_wants_keyboard_input();
    // During the tour Escape ends it; the manual over it closes first.
    let ends_tour = app.tour.is_some() && app.help.topic().is_none();
    let busy = typing || app.palette.is_open() || ctx.dragged_id().is_some() || menu;
    let mut pressed: Vec<UiCommand> = Vec::new();
    if app.is_asking() {
        return;
    }
    ctx.input_mut(|input| {
        // egui ignores an extra Shift or Alt, so that keys with both come first.
        for (shift, alt) in [(true, true), (true, false), (false, true), (false, false)] {
            for row in app.table.iter().filter(|row| !(ends_tour && row.command == CLEAR_MARKERS)) {
                let own = |keys: &KeyboardShortcut| (keys.modifiers.shift, keys.modifiers.alt) == (shift, alt);
                let keys = row.shortcut.filter(own);
                let keys = keys.filter(|keys| !busy || keys.modifiers != Modifiers::NONE);
                if keys.is_some_and(|keys| input.consume_shortcut(&keys)) {
                    pressed.push(row.command);
                }
            }
        }
    });
    app.commands.extend(pressed);
}

/// Carries out one request of a panel.
fn edit(app: &mut Workbench, request: EditRequest) {
    let history = &mut app.document.history;
    match request {
        EditRequest::Begin(label) => {
            if !history.is_open() {
                app.cause.clone_from(&label);
            }
            history.begin(&label);
        }
        EditRequest::Commit => history.commit(),
        EditRequest::Abort => {
            history.abort();
            "undo the drag".clone_into(&mut app.cause);
        }
        EditRequest::Apply(edit) => {
            let label = edit.label();
            match history.apply(&edit) {
                Ok(()) => {
                    // An open step is called the same here as in the list of edits.
                    if !history.is_open() {
                        app.cause = label;
                    }
                    app.forget_error();
                    announce_overlap(app, &edit);
                }
                Err(error) => app.complain(error.to_string()),
            }
        }
    }
}

/// Says which manoeuvres share time with one that was added or moved; takes that back once none does.
fn announce_overlap(app: &mut Workbench, edit: &Edit) {
    let Edit::Window(WindowEdit::Add(Manoeuvre { name, .. }) | WindowEdit::Place { name, .. }) = edit else { return };
    let session = app.document.session();
    let Some(window) = session.window(name) else { return };
    let shared = panels::overlapping(session, &window.flight, window.window, name);
    match panels::overlap_text(&shared) {
        Some(shared) => {
            let text = format!("{name} {shared}: samples they share count twice");
            app.set_message(text);
            app.message.iter_mut().for_each(|message| message.is_overlap = true);
        }
        None => drop(app.message.take_if(|message| message.is_overlap)),
    }
}

/// Keeps a window and a flight chosen that the session has, and the parts of time on what they are.
fn keep_selection(app: &mut Workbench) {
    let session = Arc::clone(app.document.history.present());
    let state = &mut app.state;
    let chosen = state.selection.window.as_deref().and_then(|name| session.window(name));
    match chosen {
        Some(window) => {
            state.window_time.set_full(TimeRange::new(window.window.start_s, window.window.end_s));
            if app.chosen_before.last() != Some(&window.name) {
                app.chosen_before.push(window.name.clone());
                let excess = app.chosen_before.len().saturating_sub(CHOICES);
                app.chosen_before.drain(..excess);
            }
        }
        None => {
            // An undo goes back to the former choice, a removal to the neighbour.
            let exists = |name: &&String| session.window(name).is_some();
            let former = app.chosen_before.iter().rev().find(exists).filter(|_| app.undone).cloned();
            match former.or_else(|| nearest(&session, state).map(|window| window.name.clone())) {
                Some(name) => panels::choose(state, &session, &name),
                None => state.selection.window = None,
            }
        }
    }
    app.undone = false;
    state.selection.others.retain(|name| session.window(name).is_some());
    let flight = state.selection.flight.as_deref().and_then(|name| session.flight(name));
    state.selection.flight = flight.or(session.flights.first()).map(|flight| flight.name.clone());
    if let Some(full) = flight_extent(state, &app.snapshot) {
        state.time.set_full(full);
    }
}

/// The window nearest to where the chosen one was, in its flight where that has any.
fn nearest<'a>(session: &'a Session, state: &UiState) -> Option<&'a Manoeuvre> {
    let was = state.window_time.full();
    let middle_s = 0.5 * (was.start_s + was.end_s);
    let elsewhere = |window: &Manoeuvre| state.selection.flight.as_ref().is_some_and(|flight| *flight != window.flight);
    session.windows.iter().min_by(|a, b| {
        let distance = |window: &Manoeuvre| (elsewhere(window), (window.middle_s() - middle_s).abs());
        let ((far_a, a), (far_b, b)) = (distance(a), distance(b));
        far_a.cmp(&far_b).then(a.total_cmp(&b))
    })
}

/// First and last instant of the mapped channels of the chosen flight.
pub(super) fn flight_extent(state: &UiState, snapshot: &Snapshot) -> Option<TimeRange> {
    let recording = &snapshot.flights.get(state.selection.flight.as_deref()?)?.latest()?.recording;
    let ends = recording.roles.values().filter_map(|&index| {
        let time_s = &recording.channels[index].series.time_s;
        Some((*time_s.first()?, *time_s.last()?))
    });
    let (start_s, end_s) = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    Some(TimeRange { start_s, end_s })
}

/// Asks for a run when the session has changed. While something is dragged a run under way goes on until the derivatives of all
/// manoeuvres are on screen, so that results keep coming; the errors of the path, the proof of match and the verdict follow at the end.
fn keep_computing(app: &mut Workbench, ctx: &egui::Context) {
    let current = app.document.history.present();
    if app.requested.as_ref().is_some_and(|requested| Arc::ptr_eq(requested, current)) {
        return;
    }
    let is_pooled = app.snapshot.generation == app.awaited && app.snapshot.pooled.ready().is_some();
    if app.document.history.is_open() && app.engine.is_busy() && !is_pooled {
        ctx.request_repaint_after(std::time::Duration::from_millis(10));
        return;
    }
    app.compute();
}

impl Workbench {
    /// Applies one edit, or says why it cannot be.
    pub fn apply(&mut self, wanted: &doublet_engine::session::Edit) {
        edit(self, EditRequest::Apply(wanted.clone()));
    }

    /// Applies several edits in one step of undo.
    pub fn apply_together(&mut self, label: &str, edits: impl Iterator<Item = doublet_engine::session::Edit>) {
        edit(self, EditRequest::Begin(label.to_owned()));
        edits.for_each(|one| edit(self, EditRequest::Apply(one)));
        edit(self, EditRequest::Commit);
    }

    /// Takes the last step back.
    pub fn undo(&mut self) {
        if let Some(label) = self.document.history.undo_label().map(str::to_owned)
            && self.document.history.undo()
        {
            self.cause = format!("undo {label}");
            self.undone = true;
            self.forget_error();
        }
    }

    /// Brings the last undone step again.
    pub fn redo(&mut self) {
        if let Some(label) = self.document.history.redo_label().map(str::to_owned)
            && self.document.history.redo()
        {
            self.cause = format!("redo {label}");
            self.undone = true;
            self.forget_error();
        }
    }

    /// Computes what is out of date, for example after a cancelled run or a changed file.
    pub fn compute_again(&mut self) {
        "compute again".clone_into(&mut self.cause);
        self.compute();
    }

    /// Computes `study` beside what is out of date.
    pub fn study(&mut self, study: Study) {
        study.name().clone_into(&mut self.cause);
        self.studies.retain(|other| other.name() != study.name());
        self.studies.push(study);
        self.compute();
    }

    /// Stops the run under way.
    pub fn cancel(&mut self) {
        self.engine.cancel();
        self.studies.clear();
        self.awaited = self.snapshot.generation;
    }
}
