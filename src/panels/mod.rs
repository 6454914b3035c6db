//! Panels: each draws one aspect of the session and asks for changes by commands and edits.

mod aircraft;
mod annotations;
mod filter;
mod guarded;
mod manoeuvres;
mod marking;
mod model;
mod overlaid;
mod recording;
mod report;
mod results;
mod shortcuts;
mod signals;
mod trace_menu;
mod working;

use std::path::Path;
use std::sync::Arc;

use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::consistency::ChannelConsistency;
use doublet_engine::report::Reference;
use doublet_engine::report::document::Block;
use doublet_engine::run::{DetailRequest, Slot, Snapshot, WindowDetails, WindowResults};
use doublet_engine::session::{Edit, Manoeuvre, Session, WindowRole};
use doublet_engine::stage::LoadedFlight;
use doublet_engine::study::Study;
use eframe::egui::{self, Color32, RichText, ScrollArea, Ui};

use crate::command::{CommandInfo, FileCommand, FileField, RunCommand, UiCommand};
use crate::notation;
pub use crate::pane::Pane;
use crate::theme::{self, Palette};
use crate::ui_state::{Selection, UiState};
use crate::widgets::chart::Chart;
use crate::widgets::document_view::document_view;
use crate::widgets::figure::FigureRequest;
use crate::widgets::quantity_edit::QuantityEdited;
use crate::widgets::time_plot::{PlotCache, SpanMark, StackResponse, TimePlot, time_stack_with};
use crate::widgets::time_view::{TimeRange, TimeView};
use crate::widgets::{EditPhase, named_id};
pub use guarded::GuardedPanel;
pub use marking::{OfFlight, Spot, draw_marked, ghosts, menu as mark_menu, new_window, overlap_text, overlapping};
pub use model::experiments::count_experiments;
pub use overlaid::names as overlaid_names;
pub use results::summary::{headline, judge_shown};
use working::Working;

/// A change of the session a panel asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum EditRequest {
    /// Opens a step that gathers the edits of one gesture.
    Begin(String),
    /// Applies an edit.
    Apply(Edit),
    /// Closes the open step.
    Commit,
    /// Abandons the open step.
    Abort,
}

/// What a panel may look at and what it may ask for.
pub struct PanelContext<'a> {
    pub session: &'a Session,
    /// Folder its relative paths start from.
    pub folder: &'a Path,
    /// Everything computed from it.
    pub snapshot: &'a Snapshot,
    /// Zoom, selection, layout.
    pub state: &'a mut UiState,
    /// Time under the pointer in whichever plot it is, for the next frame.
    pub hovered_s: &'a mut Option<f64>,
    pub table: &'a [CommandInfo],
    /// Commands to carry out before the next frame.
    pub commands: &'a mut Vec<UiCommand>,
    /// Changes of the session to make before the next frame.
    pub edits: &'a mut Vec<EditRequest>,
    /// Derivatives from elsewhere, marked beside the estimates.
    pub references: &'a [Reference],
    /// What the panels on screen look at more closely.
    pub wanted: &'a mut DetailRequest,
    /// Figures to take away.
    pub figures: &'a mut Vec<FigureRequest>,
}

/// What a session without an aircraft gives.
const NO_AIRCRAFT: &str = "No aircraft is chosen: only flight paths are computed.";

/// Which part of time a stack shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    Flight,
    /// That of the chosen window.
    Window,
}

impl<'a> PanelContext<'a> {
    /// Asks for one edit.
    pub fn edit(&mut self, edit: Edit) {
        self.edits.push(EditRequest::Apply(edit));
    }

    /// Asks for what a numeric field reports: a drag is one step of undo.
    pub fn edit_quantity(&mut self, edited: Option<QuantityEdited>, edit: impl FnOnce(f64) -> Edit) {
        let Some(QuantityEdited { phase, value }) = edited else { return };
        self.edit_phase(phase, edit(value));
    }

    /// Asks for one phase of a gesture.
    pub fn edit_phase(&mut self, phase: EditPhase, edit: Edit) {
        match phase {
            EditPhase::Begin => self.edits.push(EditRequest::Begin(edit.label())),
            EditPhase::Change => self.edits.push(EditRequest::Apply(edit)),
            EditPhase::Commit => self.edits.extend([EditRequest::Apply(edit), EditRequest::Commit]),
            EditPhase::Cancel => self.edits.push(EditRequest::Abort),
        }
    }

    /// Draws a chart `height` points high.
    pub fn chart(&mut self, ui: &mut Ui, chart: &Chart, height: f32) {
        self.figures.extend(chart.show(ui, height));
    }

    /// Draws parts of a document.
    pub fn document(&mut self, ui: &mut Ui, blocks: &[Block]) {
        self.figures.extend(document_view(ui, blocks));
    }

    /// Unit a dimension is shown in, and its factor from SI.
    pub fn unit(&self, dimension: Dimension) -> (&'static str, f64) {
        self.state.units.for_dimension(dimension)
    }

    /// What the user looks at.
    pub fn selection(&self) -> &Selection {
        &self.state.selection
    }

    /// The chosen window.
    pub fn window(&self) -> Option<&'a Manoeuvre> {
        self.session.window(self.state.selection.window.as_deref()?)
    }

    /// Results of the chosen window.
    pub fn results(&self) -> Option<&'a WindowResults> {
        self.snapshot.windows.get(self.state.selection.window.as_deref()?)
    }

    /// The closer look at the chosen window, once it is there.
    pub fn details(&self) -> Option<&'a WindowDetails> {
        let details = self.snapshot.details.latest()?.window.as_ref()?;
        (self.state.selection.window.as_ref() == Some(&details.name)).then_some(details)
    }

    /// The part of time of a view.
    pub fn view(&mut self, view: View) -> &mut TimeView {
        match view {
            View::Flight => &mut self.state.time,
            View::Window => &mut self.state.window_time,
        }
    }

    /// Draws a stack of plots and takes part in the linked cursor.
    pub fn stack(
        &mut self,
        ui: &mut Ui,
        id: &str,
        view: View,
        cache: &mut PlotCache,
        plots: &[TimePlot<'_>],
        spans: &[SpanMark],
    ) -> StackResponse {
        let (session, table) = (self.session, self.table);
        let mut chosen = None;
        let mut time = std::mem::take(self.view(view));
        let markers_s = time.markers_s;
        let spots = &*self;
        let (range, mut analysis) = (time.range(), None);
        let mut menu = |ui: &mut Ui, time_s: f64, row: usize| {
            let window = marking::at(spots, view, time_s);
            let candidate = marking::candidate_at(spots, view, time_s);
            let spot = marking::Spot { session, table, window, candidate, time_s: Some(time_s), markers_s };
            chosen = marking::menu(ui, &spot).map(|command| (spot, command)).or(chosen);
            analysis = trace_menu::show(spots, ui, (plots, row), range).or(analysis.take());
            ui.separator();
        };
        let mut response = time_stack_with(ui, named_id(ui.ctx(), id), &mut time, cache, plots, spans, &mut menu);
        *self.view(view) = time;
        self.state.analysis = analysis.or(self.state.analysis.take());
        if let Some((spot, command)) = chosen {
            self.follow_menu(&spot, command);
        }
        if let Some(time_s) = response.hovered_s {
            *self.hovered_s = Some(time_s);
        }
        marking::show(self, ui, view, &response);
        annotations::show(self, ui, view, &response);
        if let Some(mut request) = response.figure.take() {
            request.figure = marking::add(self, view, request.figure);
            annotations::add(self, view, &mut request.figure);
            request.figure.name = format!("{}_{}", id.replace(' ', "_"), request.figure.name);
            self.figures.push(request);
        }
        response
    }

    /// Chooses a window and the flight it lies in.
    pub fn choose(&mut self, name: &str) {
        choose(self.state, self.session, name);
    }
}

/// Chooses the window `name` alone, and the flight it lies in; it is brought on screen there.
pub fn choose(state: &mut UiState, session: &Session, name: &str) {
    let Some(window) = session.window(name) else { return };
    if state.selection.flight.as_deref() == Some(window.flight.as_str()) {
        state.time.reveal(window.window);
    }
    state.selection.window = Some(window.name.clone());
    state.selection.others.clear();
    state.selection.flight = Some(window.flight.clone());
    state.window_time.set_full(TimeRange::new(window.window.start_s, window.window.end_s));
}

/// Selects the window `name` as a click with `modifiers` does everywhere: alone; with Ctrl beside those selected, or no more; with
/// Shift all from the chosen one to it.
pub fn select(state: &mut UiState, session: &Session, name: &str, modifiers: egui::Modifiers) {
    let windows = windows_by_time(session);
    let order: Vec<&str> = windows.iter().map(|window| window.name.as_str()).collect();
    select_among(state, session, &order, name, modifiers);
}

/// Manoeuvres as they were flown: flights in the order of the session, manoeuvres of each by their start.
pub fn windows_by_time(session: &Session) -> Vec<&Manoeuvre> {
    let flight = |window: &Manoeuvre| session.flights.iter().position(|flight| flight.name == window.flight);
    let mut windows: Vec<&Manoeuvre> = session.windows.iter().collect();
    windows.sort_by(|a, b| flight(a).cmp(&flight(b)).then(a.window.start_s.total_cmp(&b.window.start_s)));
    windows
}

/// The same where the windows are shown in another order, or only some of them.
fn select_among(state: &mut UiState, session: &Session, order: &[&str], name: &str, modifiers: egui::Modifiers) {
    let place = |name: &str| order.iter().position(|other| *other == name);
    let chosen = state.selection.window.clone();
    let from = chosen.as_deref().and_then(place);
    let (Some(from), Some(to)) = (from, place(name)) else { return choose(state, session, name) };
    if modifiers.shift {
        let names = order[from.min(to)..=from.max(to)].iter().map(|name| (*name).to_owned());
        state.selection.others = names.filter(|name| Some(name) != chosen.as_ref()).collect();
    } else if modifiers.command && from != to {
        let others = &mut state.selection.others;
        if !others.remove(name) {
            others.insert(name.to_owned());
        }
    } else if modifiers.command {
        // The chosen one is taken out: the first of the others is chosen in its place.
        let mut others = std::mem::take(&mut state.selection.others);
        if let Some(next) = others.pop_first() {
            choose(state, session, &next);
            state.selection.others = others;
        }
    } else {
        choose(state, session, name);
    }
}

pub trait Panel {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui);
}

/// Colour of a window's role.
fn role_color(palette: &Palette, role: WindowRole) -> Color32 {
    match role {
        WindowRole::Identification => palette.identification,
        WindowRole::Validation => palette.validation,
        WindowRole::Ignored => palette.ignored,
    }
}

/// The chosen flight as last read; fills the panel with what is the matter where there is none.
fn chosen_flight<'a>(ctx: &mut PanelContext<'a>, ui: &mut Ui) -> Option<&'a LoadedFlight> {
    let Some(slot) = ctx.selection().flight.as_deref().and_then(|name| ctx.snapshot.flights.get(name)) else {
        empty(ui, "The session has no flight.");
        return None;
    };
    trouble(ui, slot.error());
    let loaded = slot.latest();
    if loaded.is_none() && slot.error().is_some() && ui.button("Find it…").clicked() {
        ctx.commands.push(UiCommand::File(FileCommand::FindRecording));
    }
    if loaded.is_none() {
        awaiting(ctx, ui, "the recording", "The recording could not be read.");
    }
    loaded.map(AsRef::as_ref)
}

/// Fills a panel that has nothing to show yet: what is awaited and how far the run is, or why there is nothing.
fn awaiting(ctx: &PanelContext<'_>, ui: &mut Ui, what: &str, otherwise: &str) {
    let snapshot = ctx.snapshot;
    if !snapshot.busy && snapshot.generation > 0 {
        return empty(ui, otherwise);
    }
    waiting(ctx, ui, what);
}

/// Says in the middle of an empty panel how far the run is that brings `what`.
fn waiting(ctx: &PanelContext<'_>, ui: &mut Ui, what: &str) {
    let snapshot = ctx.snapshot;
    ui.vertical_centered(|ui| {
        ui.add_space((0.5 * ui.available_height() - 30.0).max(0.0));
        ui.weak(format!("Waiting for {what}"));
        ui.add(egui::ProgressBar::new(snapshot.progress).desired_width(220.0).desired_height(8.0));
        let read = snapshot.flights.values().filter(|slot| slot.latest().is_some()).count();
        let doing = match snapshot.windows.values().filter(|results| results.path.ready().is_some()).count() {
            0 if read < snapshot.flights.len() => "reading recordings and fitting their clocks".to_owned(),
            done => format!("{done} of {} manoeuvres reconstructed", snapshot.windows.len()),
        };
        ui.label(RichText::new(doing).size(11.0).weak());
    });
}

/// Why there is no estimate: no manoeuvre identifies, none has a flight path, or there is no aircraft.
fn lacks_estimate(ctx: &PanelContext<'_>) -> String {
    let mut used = ctx.session.windows.iter().filter(|window| window.role == WindowRole::Identification).peekable();
    if used.peek().is_none() {
        return "No identification manoeuvre.".to_owned();
    }
    let paths: Vec<_> = used.filter_map(|window| ctx.snapshot.windows.get(&window.name)).collect();
    let has_path = paths.iter().any(|results| results.path.latest().is_some());
    match paths.iter().find_map(|results| results.path.error()) {
        Some(error) if !has_path => format!("No manoeuvre has a flight path: {error}."),
        _ if ctx.session.aircraft.is_none() => NO_AIRCRAFT.to_owned(),
        _ => "No estimate yet.".to_owned(),
    }
}

/// Says in the middle of an empty panel why it is empty.
fn empty(ui: &mut Ui, text: &str) {
    ui.vertical_centered(|ui| {
        ui.add_space((0.5 * ui.available_height() - 10.0).max(0.0));
        ui.weak(text);
    });
}

/// Says in the middle of an empty panel what will be here, with the button that brings it; whether that was pressed.
fn offer(ui: &mut Ui, text: &str, button: &str) -> bool {
    ui.vertical_centered(|ui| {
        ui.add_space((0.5 * ui.available_height() - 30.0).max(0.0));
        ui.weak(text);
        ui.add_space(4.0);
        ui.button(button).clicked()
    })
    .inner
}

/// Draws what follows greyed if it is out of date.
fn dim_if(ui: &mut Ui, is_stale: bool) {
    if is_stale {
        ui.multiply_opacity(0.45);
    }
}

/// Says above outdated contents why they are out of date.
fn trouble(ui: &mut Ui, error: Option<&str>) {
    if let Some(error) = error {
        let color = theme::palette(ui).error;
        ui.add(egui::Label::new(RichText::new(format!("⚠ {error}")).color(color)).wrap());
    }
}

/// A button that computes `study`, and how far it is.
fn study_button<T>(ctx: &mut PanelContext<'_>, ui: &mut Ui, (study, slot): (Study, &Slot<T>), name: &str, hint: &str) {
    let running = matches!(slot, Slot::Running { .. });
    if ui.add_enabled(!running, egui::Button::new(name)).on_hover_text(hint).clicked() {
        ctx.commands.push(UiCommand::Run(RunCommand::Study(study)));
    }
    if let Slot::Running { progress, .. } = slot {
        ui.add(egui::ProgressBar::new(*progress).desired_width(140.0).desired_height(8.0));
    }
}

/// What was found of the identified model, laid out once and drawn as a document; the progress where it is still computed.
fn answer<T>(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    slot: &Slot<T>,
    kept: &mut KeptBlocks<T>,
    what: &str,
    blocks: impl FnOnce(&T) -> Vec<Block>,
) {
    trouble(ui, slot.error());
    let Some(found) = slot.latest() else {
        let is_coming = matches!(slot, Slot::Running { .. }) || ctx.snapshot.pooled.ready().is_some();
        if slot.error().is_none() && is_coming {
            ui.horizontal(|ui| computing(ui, slot));
        } else if slot.error().is_none() {
            empty(ui, &format!("{what} needs an identified model."));
        }
        return;
    };
    ui.horizontal(|ui| {
        if matches!(slot, Slot::Running { .. }) {
            computing(ui, slot);
        }
    });
    dim_if(ui, matches!(slot, Slot::Running { .. } | Slot::Cancelled { .. } | Slot::Failed { .. }));
    if kept.as_ref().is_none_or(|(of, _)| !Arc::ptr_eq(of, found)) {
        *kept = Some((Arc::clone(found), blocks(found)));
    }
    let Some((_, blocks)) = kept else { return };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| ctx.document(ui, blocks));
}

/// Says that an answer is being computed, and how far it is.
fn computing<T>(ui: &mut Ui, slot: &Slot<T>) {
    ui.spinner();
    ui.weak("computing");
    if let Slot::Running { progress, .. } = slot {
        ui.add(egui::ProgressBar::new(*progress).desired_width(140.0).desired_height(8.0));
    }
}

/// Blocks of a document and what they were made from.
type KeptBlocks<T> = Option<(Arc<T>, Vec<Block>)>;

/// Controls of which each is moved or not.
fn surfaces(ui: &mut Ui, chosen: &mut Vec<usize>, names: &[&str]) {
    for (surface, name) in names.iter().copied().enumerate() {
        let mut is_on = chosen.contains(&surface);
        if ui.toggle_value(&mut is_on, name).changed() {
            chosen.retain(|other| *other != surface);
            chosen.extend(is_on.then_some(surface));
            chosen.sort_unstable();
        }
    }
}

/// A field with a hint and a name for those who cannot see it.
fn text_field(ui: &mut Ui, name: &str, text: &mut String, hint: &str, width: f32) {
    let response = ui.add(egui::TextEdit::singleline(text).hint_text(hint).desired_width(width));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, name));
}

/// A button beside the field of a file or folder that asks for it by a dialog, and takes what was chosen there.
fn browse(ctx: &mut PanelContext<'_>, ui: &mut Ui, field: FileField, text: &mut String) {
    let button = ui.button("Browse…");
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(format!("browse {}", field.name())));
    if button.clicked() {
        ctx.commands.push(UiCommand::File(FileCommand::Browse(field)));
    }
    if let Some((_, path)) = ctx.state.picked.take_if(|(picked, _)| *picked == field) {
        *text = path.display().to_string();
    }
}

/// A line of small weak text above a block of rows.
fn caption(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(11.5).strong());
}

/// A row of buttons of which one is chosen; `true` when another one is.
fn choices<T: Copy + PartialEq>(ui: &mut Ui, chosen: &mut T, all: &[(T, &str)]) -> bool {
    let before = *chosen;
    let row = |ui: &mut Ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        // A name that does not fit goes to the next row as a whole.
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        for &(value, name) in all {
            ui.selectable_value(chosen, value, notation::typeset(name, 13.0));
        }
    };
    if ui.layout().is_vertical() {
        ui.horizontal_wrapped(row);
    } else {
        ui.horizontal(row);
    }
    *chosen != before
}

/// Goes to the next row of a wrapping layout where a name with its choices does not fit the rest of this one.
fn break_before(ui: &mut Ui, names: &[&str]) {
    let beside = 2.0 * ui.spacing().button_padding.x + ui.spacing().item_spacing.x;
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = |name: &&str| {
        let galley = ui.painter().layout_no_wrap((*name).to_owned(), font.clone(), Color32::WHITE);
        galley.size().x + beside
    };
    let width: f32 = names.iter().map(width).sum();
    if width > ui.available_size_before_wrap().x {
        ui.end_row();
    }
}

/// Colour of what the innovations say about one measurement.
fn consistency_color(ui: &Ui, channel: &ChannelConsistency) -> Color32 {
    let palette = theme::palette(ui);
    if channel.is_consistent() { palette.good } else { palette.warning }
}

/// Whether a parameter is the constant of one window in an estimate over several.
fn is_window_constant(name: &str) -> bool {
    name.contains('[')
}
