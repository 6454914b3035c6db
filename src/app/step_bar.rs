//! The steps of the analysis in a thin bar: each a layout of the panels, with a mark of how far it is.

use std::sync::Arc;

use doublet_engine::run::Snapshot;
use doublet_engine::session::{Place, Session, WindowRole};
use doublet_engine::verdict::{Finding, Level};
use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use super::Workbench;
use crate::command::{UiCommand, ViewCommand};
use crate::layouts::LayoutKey;
use crate::panels::Pane;
use crate::step::Step;
use crate::theme;
use crate::widgets::level_mark;

const HEIGHT: f32 = 24.0;
/// Size of its text.
const TEXT: f32 = 12.0;
/// Room of the mark before a name, about a name, and of the arrow between two.
const MARK: f32 = 15.0;
const ROOM: f32 = 6.0;
const ARROW: f32 = 9.0;
/// Findings told in the hint of a step.
const TOLD: usize = 3;

/// How far a step is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Something is still to be done, or nothing is known yet.
    Open,
    /// Nothing speaks against it.
    Done,
    /// Something was found that wants a look.
    Look(Level),
}

impl Mark {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Done => "done",
            Self::Look(Level::Bad) => "bad",
            Self::Look(_) => "look here",
        }
    }
}

/// The step at which a finding is fixed.
fn step_of(finding: &Finding) -> Option<Step> {
    if finding.code == "failed" && matches!(finding.place, Place::Manoeuvre { .. }) {
        return Some(Step::Manoeuvres);
    }
    finding.panel.and_then(Pane::from_title).and_then(Step::of_pane)
}

/// What was found at `step`, the worst first: of the session, and of its fits where `step` is not the results.
fn findings(step: Step, snapshot: &Snapshot) -> impl Iterator<Item = &Finding> {
    let verdicts = snapshot.verdicts.latest();
    let of_session = verdicts.map_or(&[][..], |verdicts| &verdicts.session.reasons);
    let of_fits = verdicts.into_iter().flat_map(|verdicts| &verdicts.pooled).flat_map(|fit| &fit.verdict.reasons);
    let is_of_step = move |finding: &&Finding| step_of(finding) == Some(step);
    let of_fits = of_fits.filter(move |finding| step != Step::Results && !of_session.contains(finding));
    let of_session = of_session.iter().filter(move |finding| step == Step::Results || is_of_step(finding));
    of_session.chain(of_fits.filter(is_of_step))
}

/// How far `step` is. `written`: the session a report was written of last.
pub fn mark(step: Step, session: &Arc<Session>, snapshot: &Snapshot, written: Option<&Arc<Session>>) -> Mark {
    if session.flights.is_empty() {
        return Mark::Open;
    }
    if let Some(worst) = findings(step, snapshot).map(|finding| finding.level).max() {
        return Mark::Look(worst);
    }
    let read = !session.flights.is_empty() && snapshot.flights.values().all(|slot| slot.ready().is_some());
    let mut active = session.active_windows();
    let settled = |role: WindowRole, confirmed: bool| role == WindowRole::Ignored || confirmed;
    let is_done = match step {
        Step::Recording | Step::Signals => read,
        Step::Channels => read && snapshot.physics.values().all(|slot| slot.ready().is_some()),
        Step::Aircraft => session.aircraft.is_some() && snapshot.aircraft.ready().is_some(),
        Step::Manoeuvres => {
            let mut windows = session.windows.iter();
            !session.windows.is_empty() && windows.all(|window| settled(window.role, window.flags.confirmed))
        }
        Step::Filter => {
            let path = |name: &str| snapshot.windows.get(name).is_some_and(|results| results.path.ready().is_some());
            session.active_windows().next().is_some() && active.all(|window| path(&window.name))
        }
        Step::Model => snapshot.pooled.ready().is_some_and(|pooled| !pooled.fits.is_empty()),
        Step::Results => snapshot.verdicts.ready().is_some() && session.active_windows().next().is_some(),
        Step::Report => written.is_some_and(|written| Arc::ptr_eq(written, session)),
    };
    if is_done { Mark::Done } else { Mark::Open }
}

/// Width of the bar, points.
pub(super) fn width(ui: &Ui) -> f32 {
    let text = |step: &Step| {
        let galley = ui.painter().layout_no_wrap(step.title().to_owned(), FontId::proportional(TEXT), Color32::WHITE);
        galley.size().x + MARK + 2.0 * ROOM + ARROW
    };
    Step::ALL.iter().map(text).sum::<f32>() + 60.0
}

/// Draws the bar.
pub(super) fn show(app: &mut Workbench, ui: &mut Ui) {
    let session = Arc::clone(app.document.history.present());
    let snapshot = Arc::clone(app.snapshot());
    let on_start = app.is_on_start_page();
    let mut wanted = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.spacing_mut().button_padding.x = ROOM;
        if ui.add(egui::Button::selectable(on_start, egui::RichText::new("Start").size(TEXT))).clicked() {
            wanted = Some(ViewCommand::StartPage);
        }
        for step in Step::ALL {
            let (arrow, _) = ui.allocate_exact_size(vec2(ARROW, HEIGHT), Sense::hover());
            let (center, weak) = (arrow.center(), ui.visuals().weak_text_color());
            let tip = [
                pos2(center.x - 1.5, center.y - 3.0),
                pos2(center.x + 1.5, center.y),
                pos2(center.x - 1.5, center.y + 3.0),
            ];
            ui.painter().line(tip.to_vec(), Stroke::new(1.0, weak));
            let mark = mark(step, &session, &snapshot, app.written.as_ref());
            let chosen = !on_start && app.state.shown.key == LayoutKey::Step(step);
            if entry(ui, step, mark, chosen, &snapshot) {
                wanted = Some(ViewCommand::Step(step));
            }
        }
    });
    app.commands.extend(wanted.map(UiCommand::View));
}

/// One step; whether it was clicked.
fn entry(ui: &mut Ui, step: Step, mark: Mark, chosen: bool, snapshot: &Snapshot) -> bool {
    let font = FontId::proportional(TEXT);
    let ink = if chosen { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    let galley = ui.painter().layout_no_wrap(step.title().to_owned(), font, ink);
    let size = vec2(galley.size().x + MARK + 2.0 * ROOM, HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let ground = match (chosen, response.hovered()) {
        (true, _) => Some(ui.visuals().selection.bg_fill),
        (false, true) => Some(ui.visuals().widgets.hovered.weak_bg_fill),
        (false, false) => None,
    };
    if let Some(color) = ground {
        ui.painter().rect_filled(rect.shrink2(vec2(0.0, 1.0)), CornerRadius::same(4), color);
    }
    if response.has_focus() {
        let edge = Stroke::new(1.5, theme::palette(ui).accent);
        let rect = rect.shrink2(vec2(0.0, 1.0));
        ui.painter().rect_stroke(rect, CornerRadius::same(4), edge, StrokeKind::Inside);
    }
    draw_mark(ui, pos2(rect.left() + ROOM + 4.0, rect.center().y), mark);
    let at = Align2::LEFT_CENTER.anchor_size(pos2(rect.left() + ROOM + MARK - 2.0, rect.center().y), galley.size());
    ui.painter().galley(at.min, galley, ink);
    let name = format!("step {}: {}", step.title(), mark.name());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let response = response.on_hover_ui(|ui| {
        ui.set_max_width(420.0);
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(MARK, HEIGHT), Sense::hover());
            draw_mark(ui, rect.center(), mark);
            ui.strong(format!("{}: {}", step.title(), mark.name()));
        });
        ui.weak(step.done_when());
        for finding in findings(step, snapshot).take(TOLD) {
            ui.add(egui::Label::new(format!("{}: {}", finding.place, finding.text)).wrap());
        }
        let more = findings(step, snapshot).count().saturating_sub(TOLD);
        if more > 0 {
            ui.weak(format!("and {more} more: see Summary"));
        }
    });
    response.clicked()
}

/// A tick, a ring, or the shape of a level.
fn draw_mark(ui: &Ui, center: egui::Pos2, mark: Mark) {
    let palette = theme::palette(ui);
    match mark {
        Mark::Open => {
            ui.painter().circle_stroke(center, 4.0, Stroke::new(1.4, ui.visuals().text_color()));
        }
        Mark::Done => {
            let rect = Rect::from_center_size(center, vec2(9.0, 7.0));
            let tick = vec![rect.left_center(), pos2(rect.left() + 3.2, rect.bottom()), rect.right_top()];
            ui.painter().line(tick, Stroke::new(1.8, palette.good));
        }
        Mark::Look(level) => level_mark::paint(ui.painter(), center, 5.0, Some(level), palette.of_level(level)),
    }
}
