//! A second session beside the first: read only, with the same zoom, the same manoeuvre and one cursor over both.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_engine::graph::Cache;
use doublet_engine::run::{CACHE_BYTES, DetailRequest, Engine, Request, Snapshot};
use doublet_engine::session::{Manoeuvre, Session};
use eframe::egui::{self, ComboBox, Label, RichText, Ui};

use super::{Document, Workbench};
use crate::panels::{self, GuardedPanel, Pane, PanelContext};
use crate::ui_state::UiState;
use crate::widgets::second_side;
use crate::widgets::time_view::{TimeRange, TimeView};

/// Panels that show it.
const PANES: [Pane; 6] =
    [Pane::Flight, Pane::Reconstruction, Pane::Innovations, Pane::Fits, Pane::Derivatives, Pane::Summary];
/// Least width of either side, points.
const LEAST: f32 = 380.0;
/// Part of the shorter of two manoeuvres that lies in both where they are of one recording.
const SAME: f64 = 0.5;

/// The session beside the first.
pub(super) struct Second {
    session: Arc<Session>,
    folder: PathBuf,
    title: String,
    engine: Engine,
    snapshot: Arc<Snapshot>,
    state: UiState,
    panels: BTreeMap<Pane, GuardedPanel>,
    pane: Pane,
    hovered_s: Option<f64>,
    /// The manoeuvre of the first session when its own was chosen last, and what both showed then.
    followed: Option<String>,
    shown: [[TimeRange; 2]; 2],
}

impl Second {
    fn open(path: &Path, ctx: &egui::Context) -> Result<Self, String> {
        let document = Document::open(path)?;
        let wake = ctx.clone();
        let engine = Engine::start(Arc::new(Cache::new(CACHE_BYTES)), move || wake.request_repaint());
        let engine = engine.map_err(|error| error.to_string())?;
        let session = Arc::clone(document.history.present());
        let mut state = UiState::default();
        if let Some(first) = session.windows.first() {
            panels::choose(&mut state, &session, &first.name);
        }
        state.selection.flight = session.flights.first().map(|flight| flight.name.clone());
        engine.request(Request {
            first: state.selection.window.clone(),
            session: Arc::clone(&session),
            folder: document.folder.clone(),
            studies: Vec::new(),
            cause: "open beside".to_owned(),
            fresh: true,
        });
        let file = document.path.as_deref().and_then(Path::file_name).and_then(|name| name.to_str());
        let title = file.map_or_else(|| session.title.clone(), |file| format!("{file}: {}", session.title));
        Ok(Self {
            folder: document.folder.clone(),
            title,
            engine,
            snapshot: Arc::default(),
            panels: PANES.iter().map(|&pane| (pane, GuardedPanel::new(pane))).collect(),
            pane: Pane::Fits,
            hovered_s: None,
            followed: None,
            shown: [views(&state); 2],
            state,
            session,
        })
    }

    fn window(&self) -> Option<&Manoeuvre> {
        self.session.window(self.state.selection.window.as_deref()?)
    }

    /// The title, the manoeuvre, the panels to choose from; whether it is to be closed.
    fn head(&mut self, ui: &mut Ui) -> bool {
        let mut closed = false;
        ui.horizontal(|ui| {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                closed = ui.small_button("✖").on_hover_text("Close the second session").clicked();
                if self.engine.is_busy() {
                    ui.spinner();
                }
                let title = Label::new(RichText::new(&self.title).strong()).truncate();
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(title).on_hover_text(format!("{}, read only", self.title));
                });
            });
        });
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for pane in PANES {
                let name = RichText::new(pane.short_title());
                let entry = ui.selectable_label(self.pane == pane, name);
                ui.ctx().accesskit_node_builder(entry.id, |node| {
                    node.set_label(format!("second session: {}", pane.title()));
                });
                if entry.clicked() {
                    self.pane = pane;
                }
            }
            ui.separator();
            let chosen = self.state.selection.window.clone().unwrap_or_default();
            let mut wanted = None;
            let combo = ComboBox::from_id_salt("manoeuvre of the second session").selected_text(&chosen).width(170.0);
            let combo = combo.show_ui(ui, |ui| {
                for window in &self.session.windows {
                    if ui.selectable_label(window.name == chosen, &window.name).clicked() {
                        wanted = Some(window.name.clone());
                    }
                }
            });
            ui.ctx().accesskit_node_builder(combo.response.id, |node| {
                node.set_label("manoeuvre of the second session");
            });
            if let Some(name) = wanted {
                panels::choose(&mut self.state, &self.session, &name);
            }
        });
        closed
    }
}

/// What the plots of a session show of its flight and of its manoeuvre.
fn views(state: &UiState) -> [TimeRange; 2] {
    [state.time.range(), state.window_time.range()]
}

/// What is to be added to a time of the first session for that of the second, s: nothing where their manoeuvres lie in one recording.
fn offset_s(first: Option<&Manoeuvre>, second: Option<&Manoeuvre>) -> f64 {
    let (Some(first), Some(second)) = (first, second) else { return 0.0 };
    let (a, b) = (first.window, second.window);
    let both = a.end_s.min(b.end_s) - a.start_s.max(b.start_s);
    if both > SAME * a.length_s().min(b.length_s()) { 0.0 } else { b.start_s - a.start_s }
}

/// Shows in `view` what the other session shows.
fn follow(view: &mut TimeView, range: TimeRange, by_s: f64) {
    view.drag_to(TimeRange { start_s: range.start_s + by_s, end_s: range.end_s + by_s });
}

impl Workbench {
    /// Opens a session beside the first, in the place of the one that is there.
    pub fn open_beside(&mut self, path: &Path, ctx: &egui::Context) {
        match Second::open(path, ctx) {
            Ok(second) => self.second = Some(second),
            Err(line) => self.complain(line),
        }
    }

    /// Closes the second session.
    pub fn close_beside(&mut self) {
        self.second = None;
    }

    /// What was computed of the second session, where there is one, and the time its cursor stands at.
    pub fn beside(&self) -> Option<(&Arc<Snapshot>, Option<f64>)> {
        self.second.as_ref().map(|second| (&second.snapshot, second.state.window_time.cursor_s))
    }

    /// Whether the second session is still being computed.
    pub fn is_busy_beside(&self) -> bool {
        self.second.as_ref().is_some_and(|second| second.engine.is_busy() || second.engine.has_details_due())
    }

    /// Before drawing: takes results in, and links manoeuvre, zoom and cursor; `hovered_s`: the time under the pointer in the first
    /// session. The time there of the one cursor.
    pub(super) fn link_second(&mut self, hovered_s: Option<f64>) -> Option<f64> {
        let session = Arc::clone(self.document.history.present());
        let Some(second) = &mut self.second else { return hovered_s };
        let [own, other] = [views(&self.state), views(&second.state)];
        // Whichever was moved since the last frame leads.
        let leads = [0, 1].map(|at| own[at] == second.shown[0][at] && other[at] != second.shown[1][at]);
        second.snapshot = second.engine.snapshot();
        let chosen = self.state.selection.window.clone();
        if second.followed != chosen {
            second.followed.clone_from(&chosen);
            if let Some(name) = chosen.as_deref().filter(|name| second.session.window(name).is_some()) {
                panels::choose(&mut second.state, &second.session, name);
            }
        }
        if let Some(window) = second.window().map(|window| window.window) {
            second.state.window_time.set_full(TimeRange::new(window.start_s, window.end_s));
        }
        if let Some(full) = super::logic::flight_extent(&second.state, &second.snapshot) {
            second.state.time.set_full(full);
        }
        let by_s = offset_s(chosen.as_deref().and_then(|name| session.window(name)), second.window());
        let (state, beside) = (&mut self.state, &mut second.state);
        let pairs = [(&mut state.time, &mut beside.time), (&mut state.window_time, &mut beside.window_time)];
        for ((view, twin), twin_leads) in pairs.into_iter().zip(leads) {
            if twin_leads { follow(view, twin.range(), -by_s) } else { follow(twin, view.range(), by_s) }
        }
        second.shown = [views(&self.state), views(&second.state)];
        let there_s = second.hovered_s.take();
        let cursor_s = hovered_s.or(there_s.map(|time_s| time_s - by_s));
        let beside_s = there_s.or(hovered_s.map(|time_s| time_s + by_s));
        second.state.time.cursor_s = beside_s;
        second.state.window_time.cursor_s = beside_s;
        cursor_s
    }

    /// Draws the second session in the right half.
    pub(super) fn show_second(&mut self, ui: &mut Ui) {
        let Some(second) = &mut self.second else { return };
        let room = ui.available_width();
        let mut closed = false;
        let (mut commands, mut edits) = (Vec::new(), Vec::new());
        let mut has_failed = false;
        egui::Panel::right("second session")
            .resizable(true)
            .default_size((0.5 * room).max(LEAST))
            .size_range(LEAST..=(room - LEAST).max(LEAST))
            .show(ui, |ui| {
                second_side(ui.ctx(), true);
                closed = second.head(ui);
                ui.separator();
                second.state.units = self.state.units;
                let mut wanted =
                    DetailRequest { window: second.state.selection.window.clone(), ..DetailRequest::default() };
                let mut context = PanelContext {
                    session: &second.session,
                    folder: &second.folder,
                    snapshot: &second.snapshot,
                    state: &mut second.state,
                    hovered_s: &mut second.hovered_s,
                    table: &self.table,
                    commands: &mut commands,
                    edits: &mut edits,
                    references: &[],
                    wanted: &mut wanted,
                    figures: &mut self.figures,
                };
                if let Some(panel) = second.panels.get_mut(&second.pane) {
                    has_failed = panel.show(&mut context, ui);
                }
                second.engine.request_details(&wanted);
                second_side(ui.ctx(), false);
            });
        if closed {
            self.second = None;
        } else if !edits.is_empty() {
            self.set_message("The second session is read only: open it as the first to change it.");
        }
        if has_failed {
            self.keep_work_after_failed_panel();
        }
    }
}
