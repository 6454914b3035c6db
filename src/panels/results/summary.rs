//! Which results can be trusted: the verdict, its level for every manoeuvre and coefficient, and the findings with their fixes.

use std::sync::Arc;

use doublet_core::model::Coefficient;
use doublet_engine::session::Session;
use doublet_engine::verdict::{Finding, Level, Verdicts};
use eframe::egui::{
    self, CollapsingHeader, CornerRadius, Label, Panel as Bar, RichText, Role, ScrollArea, Sense, TextStyle, Ui,
    WidgetInfo, vec2,
};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::command::{UiCommand, ViewCommand};
use crate::notation;
use crate::panels::manoeuvres::manoeuvre_list::menu;
use crate::panels::results::applied_fix::HeldFindings;
use crate::panels::results::finding_rows::{self, FindingKind};
use crate::panels::{Pane, Panel, PanelContext, awaiting, windows_by_time};
use crate::widgets::level_mark::{self, level_mark};

/// Height of a row.
const ROW: f32 = 21.0;
/// Width of a cell, usual and least, and the room between two.
const CELL: f32 = 40.0;
const LEAST_CELL: f32 = 28.0;
const GAP: f32 = 2.0;
/// Width in which the names of windows are read, usual and least, and the room right of the grid.
const NAMES: f32 = 150.0;
const LEAST_NAMES: f32 = 110.0;
const RIGHT_ROOM: f32 = 24.0;
/// Least width of the reasons.
const LEAST_REASONS: f32 = 260.0;
/// From this width on the reasons stand beside the grid, below it else.
const WIDE: f32 = 720.0;
/// Height of the reasons where there are none: a heading and the least list.
const NO_REASONS: f32 = 108.0;
/// A panel up to this height has the grid alone where there are no reasons, and the reasons beside a closer grid where both fit.
const LOW: f32 = 300.0;
/// Reasons said at once; the rest is asked for.
const WORST: usize = 3;

/// Worst coefficients whose findings are shown where the session has none.
const WORST_FITS: usize = 3;

/// Why nothing is estimated, and what to do; none where some manoeuvre is in use.
fn nothing_estimated(session: &Session) -> Option<&'static str> {
    if session.windows.is_empty() {
        return Some("Nothing is estimated: mark a manoeuvre (drag with Ctrl in a plot of the flight).");
    }
    let is_ignored = session.active_windows().next().is_none();
    is_ignored.then_some("Nothing is estimated: all manoeuvres are ignored. Use one for identification.")
}

/// The verdict in one line; without a manoeuvre in use, what to do.
pub fn headline(session: &Session, verdicts: &Verdicts) -> String {
    nothing_estimated(session).map_or_else(|| verdicts.headline(), str::to_owned)
}

/// The level of a session as it is shown: none where nothing is estimated and nothing is bad.
pub fn judge_shown(session: &Session, verdicts: &Verdicts) -> Option<Level> {
    let level = verdicts.session.level;
    (level == Level::Bad || nothing_estimated(session).is_none()).then_some(level)
}

/// What a cell of the grid is about.
#[derive(Clone, Debug, Default, PartialEq)]
struct Place {
    /// One window; all together without one.
    window: Option<String>,
    /// One fit; without one the flight path of the window, or the whole session.
    fit: Option<Coefficient>,
}

impl Place {
    fn new(window: Option<&str>, fit: Option<Coefficient>) -> Self {
        Self { window: window.map(str::to_owned), fit }
    }

    /// What it is called.
    fn title(&self) -> String {
        let fit_name = self.fit.map_or("Flight path", Coefficient::name);
        match (&self.window, self.fit) {
            (None, None) => "Session".to_owned(),
            (None, Some(_)) => format!("{fit_name}, all manoeuvres"),
            (Some(window), _) => format!("{fit_name}, {window}"),
        }
    }

    /// Its level and its reasons, the worst first; none where it was not computed.
    fn judged<'a>(&self, verdicts: &'a Verdicts) -> Option<(Level, Vec<&'a Finding>)> {
        let verdict = match (&self.window, self.fit) {
            (None, None) => &verdicts.session,
            (Some(window), None) => &verdicts.windows.get(window)?.verdict,
            (window, Some(coefficient)) => {
                let fit = verdicts.fit(window.as_deref(), coefficient)?;
                let mut reasons: Vec<&Finding> = fit.verdict.reasons.iter().collect();
                // What leaves the fit as it is and still speaks against a derivative.
                let own = fit.derivatives.iter().flat_map(|derivative| &derivative.verdict.reasons);
                own.for_each(|reason| {
                    if !reasons.contains(&reason) {
                        reasons.push(reason);
                    }
                });
                return Some((fit.verdict.level, reasons));
            }
        };
        Some((verdict.level, verdict.reasons.iter().collect()))
    }
}

#[derive(Default)]
pub struct Summary {
    chosen: Place,
    held: HeldFindings,
}

impl Panel for Summary {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(verdicts) = ctx.snapshot.verdicts.latest().cloned() else {
            return awaiting(ctx, ui, "the verdict", "No verdict yet: compute again (F5).");
        };
        self.held.follow(ctx);
        let listed = self.held.listed(&verdicts);
        if self.chosen.judged(&listed).is_none() {
            self.chosen = Place::default();
        }
        ui.horizontal(|ui| {
            level_mark(ui, judge_shown(ctx.session, &verdicts));
            let text = headline(ctx.session, &verdicts);
            let text = notation::typeset_in(&text, 14.0, ui.visuals().strong_text_color());
            ui.add(Label::new(text).wrap());
        });
        if nothing_estimated(ctx.session).is_some() {
            return self.first_step(ctx, ui, &listed);
        }
        ui.add_space(2.0);
        if ctx.snapshot.verdicts.is_stale() {
            ui.multiply_opacity(0.6);
        }
        let room = ui.available_size();
        let columns = ctx.session.structure.models.len() + 1;
        let cell = if room.x >= WIDE || room.y > LOW { CELL } else { LEAST_CELL };
        let names = if cell < CELL { LEAST_NAMES } else { NAMES };
        // Every coefficient keeps its column and every window a name that can be read.
        let most = room.x - names - columns as f32 * (cell + GAP) - RIGHT_ROOM;
        if room.x >= WIDE || (room.y <= LOW && most >= LEAST_REASONS) {
            let most = most.max(LEAST_REASONS);
            let bar = Bar::right("reasons beside").default_size(most.min(0.5 * room.x));
            let bar = bar.size_range(LEAST_REASONS..=most);
            bar.show(ui, |ui| self.reasons(ctx, ui, &listed));
        } else if !self.has_findings(&listed) {
            // In a low panel the grid needs the room.
            if room.y > LOW {
                let bar = Bar::bottom("no reasons below").default_size(NO_REASONS).size_range(NO_REASONS..=NO_REASONS);
                bar.show(ui, |ui| self.reasons(ctx, ui, &listed));
            }
        } else {
            let bar = Bar::bottom("reasons below").default_size(0.4 * room.y).size_range(64.0..=0.7 * room.y);
            bar.show(ui, |ui| self.reasons(ctx, ui, &listed));
        }
        let ground = egui::Frame::new().inner_margin(egui::Margin { right: 6, ..Default::default() });
        egui::CentralPanel::default().frame(ground).show(ui, |ui| self.grid(ctx, ui, &verdicts, cell));
    }
}

impl Summary {
    /// What there is to do before anything can be estimated, and what is known of the session so far.
    fn first_step(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Arc<Verdicts>) {
        ui.horizontal_wrapped(|ui| {
            for (text, pane) in [("Show the flight", Pane::Flight), ("Show the manoeuvres found", Pane::Manoeuvres)] {
                if ui.button(text).clicked() {
                    ctx.commands.push(UiCommand::View(ViewCommand::Show(pane)));
                }
            }
        });
        let kinds = FindingKind::group(&verdicts.session.reasons.iter().collect::<Vec<_>>());
        let list = ScrollArea::vertical().id_salt("reasons").auto_shrink(false).show(ui, |ui| {
            self.findings(ctx, ui, verdicts, (&Place::default().title(), &kinds));
        });
        self.held.release_left(ui, list.inner_rect);
    }

    /// Whether there are findings to show.
    fn has_findings(&self, verdicts: &Verdicts) -> bool {
        let has_own = self.chosen.judged(verdicts).is_some_and(|(_, reasons)| !reasons.is_empty());
        has_own || self.chosen == Place::default() && !worst_fits(verdicts).is_empty()
    }

    /// Windows down, coefficients across; all windows together first.
    fn grid(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Verdicts, cell: f32) {
        let fits: Vec<Coefficient> = ctx.session.structure.models.iter().map(|(coefficient, _)| *coefficient).collect();
        let windows: Vec<Option<&str>> = std::iter::once(None)
            .chain(windows_by_time(ctx.session).iter().map(|window| Some(window.name.as_str())))
            .filter(|window| window.is_none_or(|name| verdicts.windows.contains_key(name)))
            .collect();
        ui.spacing_mut().item_spacing.x = GAP;
        TableBuilder::new(ui)
            .id_salt("verdicts")
            .striped(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::remainder().at_least(LEAST_NAMES).clip(true))
            .columns(Column::exact(cell), fits.len() + 1)
            .header(20.0, |mut header| {
                header.col(|_| {});
                header.col(|ui| {
                    ui.weak("path").on_hover_text("Flight path: samples, filter, loading");
                });
                for coefficient in &fits {
                    header.col(|ui| {
                        ui.centered_and_justified(|ui| {
                            ui.label(notation::derivative_job(ui, &format!("{}_", coefficient.name())));
                        });
                    });
                }
            })
            .body(|body| {
                body.rows(ROW, windows.len(), |mut row| {
                    let window = windows[row.index()];
                    self.row(ctx, &mut row, verdicts, window, &fits);
                });
            });
    }

    fn row(
        &mut self,
        ctx: &mut PanelContext<'_>,
        row: &mut TableRow<'_, '_>,
        verdicts: &Verdicts,
        window: Option<&str>,
        fits: &[Coefficient],
    ) {
        row.set_selected(window.is_some_and(|name| ctx.selection().is_selected(name)));
        row.col(|ui| {
            let text = window.map_or_else(|| RichText::new("All manoeuvres").strong(), RichText::new);
            let name = ui.add(Label::new(text).truncate().sense(Sense::click()));
            if name.clicked() {
                self.choose(ctx, Place::new(window, None));
            }
            manoeuvre_menu(ctx, &name, window);
        });
        for fit in [None].into_iter().chain(fits.iter().copied().map(Some)) {
            row.col(|ui| {
                if fit.is_some() || window.is_some() {
                    self.cell(ctx, ui, verdicts, Place::new(window, fit));
                }
            });
        }
    }

    /// The mark of one verdict; a click shows its reasons.
    fn cell(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Verdicts, place: Place) {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW - 2.0), Sense::click());
        let visuals = ui.visuals();
        let ground = match (place == self.chosen, response.hovered()) {
            (true, _) => Some(visuals.selection.bg_fill),
            (false, true) => Some(visuals.widgets.hovered.weak_bg_fill),
            (false, false) => None,
        };
        if let Some(color) = ground {
            ui.painter().rect_filled(rect, CornerRadius::same(3), color);
        }
        let judged = place.judged(verdicts);
        let word = judged.as_ref().map_or("not computed", |(level, _)| level.name());
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("{}: {word}", place.title())));
        let Some((level, reasons)) = judged else {
            let font = TextStyle::Small.resolve(ui.style());
            ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, "–", font, visuals.weak_text_color());
            return;
        };
        level_mark::paint(ui.painter(), rect.center(), 5.0, Some(level), level_mark::color(ui, Some(level)));
        let response = response.on_hover_ui(|ui| {
            let title = format!("{}: {word}", place.title());
            ui.label(notation::typeset_in(&title, 13.0, ui.visuals().strong_text_color()));
            reasons.iter().take(WORST).for_each(|reason| drop(ui.label(reason.text.to_string())));
        });
        manoeuvre_menu(ctx, &response, place.window.as_deref());
        if response.clicked() {
            self.choose(ctx, place);
        }
    }

    /// Shows the reasons of `place`; those of the session where it was shown.
    fn choose(&mut self, ctx: &mut PanelContext<'_>, place: Place) {
        if let Some(window) = &place.window {
            ctx.choose(window);
        }
        self.held.release();
        self.chosen = if place == self.chosen { Place::default() } else { place };
    }

    /// Why the chosen cell is what it is.
    fn reasons(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Arc<Verdicts>) {
        let Some((level, reasons)) = self.chosen.judged(verdicts) else { return };
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            level_mark(ui, Some(level));
            let then = if self.held.is_holding() { ", before the fix" } else { "" };
            let title = format!("{}: {}{then}", self.chosen.title(), level.name());
            ui.label(notation::typeset_in(&title, 13.0, ui.visuals().strong_text_color()));
            if self.chosen != Place::default() && ui.small_button("Session").clicked() {
                self.held.release();
                self.chosen = Place::default();
            }
        });
        let list = ScrollArea::vertical().id_salt("reasons").auto_shrink(false).show(ui, |ui| {
            let kinds = FindingKind::group(&reasons);
            if !kinds.is_empty() {
                return self.findings(ctx, ui, verdicts, (&self.chosen.title(), &kinds));
            }
            let worst = if self.chosen == Place::default() { worst_fits(verdicts) } else { Vec::new() };
            if worst.is_empty() {
                ui.weak("No findings.");
            }
            for coefficient in worst {
                let place = Place::new(None, Some(coefficient));
                let Some((level, reasons)) = place.judged(verdicts) else { continue };
                let title = place.title();
                ui.add_space(4.0);
                ui.horizontal(|ui| {
                    level_mark(ui, Some(level));
                    let line = format!("{title}: {}", level.name());
                    if ui.link(notation::typeset_in(&line, 13.0, ui.visuals().strong_text_color())).clicked() {
                        self.chosen = place;
                    }
                });
                self.findings(ctx, ui, verdicts, (&title, &FindingKind::group(&reasons)));
            }
        });
        self.held.release_left(ui, list.inner_rect);
    }

    /// Findings of a place, the worst first; the rest is asked for.
    fn findings(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        verdicts: &Arc<Verdicts>,
        (title, kinds): (&str, &[FindingKind<'_>]),
    ) {
        let (worst, more) = kinds.split_at(WORST.min(kinds.len()));
        let mut show_all = |ui: &mut Ui, kinds: &[FindingKind<'_>]| {
            for kind in kinds {
                let wanted = finding_rows::show(ctx, ui, kind, &self.held);
                if let Some(wanted) = kind.fix.as_ref().zip(wanted) {
                    self.held.apply(ctx, verdicts, wanted);
                }
            }
        };
        show_all(ui, worst);
        if !more.is_empty() {
            CollapsingHeader::new(format!("{} more", more.len())).id_salt(title).show(ui, |ui| show_all(ui, more));
        }
    }
}

/// The menu of the manoeuvre of a row.
fn manoeuvre_menu(ctx: &mut PanelContext<'_>, response: &egui::Response, window: Option<&str>) {
    let session = ctx.session;
    if let Some(window) = window.and_then(|name| session.window(name)) {
        response.context_menu(|ui| menu(ctx, ui, window));
    }
}

/// The coefficients of the worst level below good, from all manoeuvres, that have findings.
fn worst_fits(verdicts: &Verdicts) -> Vec<Coefficient> {
    let level = verdicts.pooled.iter().map(|fit| fit.verdict.level).max().unwrap_or_default();
    let worst = verdicts.pooled.iter().filter(|fit| fit.verdict.level == level && level > Level::Good);
    let found = worst.map(|fit| fit.coefficient).filter(|&fit| {
        let judged = Place::new(None, Some(fit)).judged(verdicts);
        judged.is_some_and(|(_, reasons)| !reasons.is_empty())
    });
    found.take(WORST_FITS).collect()
}
