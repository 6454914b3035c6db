//! Which results can be trusted: the verdict, its level for every manoeuvre and coefficient, and the findings with their fixes.

use doublet_core::model::Coefficient;
use doublet_engine::verdict::{Finding, Level, Verdicts};
use eframe::egui::{
    self, CollapsingHeader, CornerRadius, Label, Panel as Bar, RichText, Role, ScrollArea, Sense, TextStyle, Ui,
    WidgetInfo, vec2,
};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::notation;
use crate::panels::results::applied_fix::AppliedFix;
use crate::panels::results::finding_rows::{self, FindingKind};
use crate::panels::{Panel, PanelContext, awaiting};
use crate::widgets::level_mark::{self, level_mark};

/// Height of a row.
const ROW: f32 = 21.0;
/// Width of a cell, and the room between two.
const CELL: f32 = 40.0;
const GAP: f32 = 2.0;
/// Width in which the names of windows are read, and the room right of the grid.
const NAMES: f32 = 150.0;
const RIGHT_ROOM: f32 = 24.0;
/// Least width of the reasons.
const LEAST_REASONS: f32 = 260.0;
/// From this width on the reasons stand beside the grid, below it else.
const WIDE: f32 = 720.0;
/// Height of the reasons where there are none: a heading and the least list.
const NO_REASONS: f32 = 108.0;
/// A panel up to this height has the grid alone where there are no reasons.
const LOW: f32 = 300.0;
/// Reasons said at once; the rest is asked for.
const WORST: usize = 3;

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

/// The panel.
#[derive(Default)]
pub struct Summary {
    chosen: Place,
    applied: Option<AppliedFix>,
}

impl Panel for Summary {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(verdicts) = ctx.snapshot.verdicts.latest().cloned() else {
            return awaiting(ctx, ui, "the verdict", "No verdict yet: compute again (F5).");
        };
        if self.chosen.judged(&verdicts).is_none() {
            self.chosen = Place::default();
        }
        ui.horizontal(|ui| {
            level_mark(ui, Some(verdicts.session.level));
            let text = notation::typeset_in(&verdicts.headline(), 14.0, ui.visuals().strong_text_color());
            ui.add(Label::new(text).wrap());
        });
        self.applied.take_if(|applied| !applied.is_current(ctx.session) && ctx.edits.is_empty());
        if let Some(applied) = &self.applied {
            applied.show(ctx, ui);
        }
        ui.add_space(2.0);
        if ctx.snapshot.verdicts.is_stale() {
            ui.multiply_opacity(0.6);
        }
        let room = ui.available_size();
        if room.x >= WIDE {
            // Every coefficient keeps its column and every window a name that can be read.
            let fits = ctx.session.structure.models.len();
            let most = (room.x - NAMES - (fits + 1) as f32 * (CELL + GAP) - RIGHT_ROOM).max(LEAST_REASONS);
            let bar = Bar::right("reasons beside").default_size(most.min(0.5 * room.x));
            let bar = bar.size_range(LEAST_REASONS..=most);
            bar.show(ui, |ui| self.reasons(ctx, ui, &verdicts));
        } else if self.chosen.judged(&verdicts).is_none_or(|(_, reasons)| reasons.is_empty()) {
            // In a low panel the grid needs the room.
            if room.y > LOW {
                let bar = Bar::bottom("no reasons below").default_size(NO_REASONS).size_range(NO_REASONS..=NO_REASONS);
                bar.show(ui, |ui| self.reasons(ctx, ui, &verdicts));
            }
        } else {
            let bar = Bar::bottom("reasons below").default_size(0.4 * room.y).size_range(64.0..=0.7 * room.y);
            bar.show(ui, |ui| self.reasons(ctx, ui, &verdicts));
        }
        let ground = egui::Frame::new().inner_margin(egui::Margin { right: 6, ..Default::default() });
        egui::CentralPanel::default().frame(ground).show(ui, |ui| self.grid(ctx, ui, &verdicts));
    }
}

impl Summary {
    /// Windows down, coefficients across; all windows together first.
    fn grid(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Verdicts) {
        let fits: Vec<Coefficient> = ctx.session.structure.models.iter().map(|(coefficient, _)| *coefficient).collect();
        let windows: Vec<Option<&str>> = std::iter::once(None)
            .chain(ctx.session.windows.iter().map(|window| Some(window.name.as_str())))
            .filter(|window| window.is_none_or(|name| verdicts.windows.contains_key(name)))
            .collect();
        ui.spacing_mut().item_spacing.x = GAP;
        TableBuilder::new(ui)
            .id_salt("verdicts")
            .striped(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::remainder().at_least(110.0).clip(true))
            .columns(Column::exact(CELL), fits.len() + 1)
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
        row.set_selected(window.is_some() && ctx.selection().window.as_deref() == window);
        row.col(|ui| {
            let text = window.map_or_else(|| RichText::new("All manoeuvres").strong(), RichText::new);
            let name = ui.add(Label::new(text).truncate().sense(Sense::click()));
            if name.clicked() {
                self.choose(ctx, Place::new(window, None));
            }
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
            ui.strong(format!("{}: {word}", place.title()));
            reasons.iter().take(WORST).for_each(|reason| drop(ui.label(&reason.text)));
        });
        if response.clicked() {
            self.choose(ctx, place);
        }
    }

    /// Shows the reasons of `place`; those of the session where it was shown.
    fn choose(&mut self, ctx: &mut PanelContext<'_>, place: Place) {
        if let Some(window) = &place.window {
            ctx.choose(window);
        }
        self.chosen = if place == self.chosen { Place::default() } else { place };
    }

    /// Why the chosen cell is what it is.
    fn reasons(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, verdicts: &Verdicts) {
        let Some((level, reasons)) = self.chosen.judged(verdicts) else { return };
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            level_mark(ui, Some(level));
            let title = format!("{}: {}", self.chosen.title(), level.name());
            ui.label(notation::typeset_in(&title, 13.0, ui.visuals().strong_text_color()));
            if self.chosen != Place::default() && ui.small_button("Session").clicked() {
                self.chosen = Place::default();
            }
        });
        ScrollArea::vertical().id_salt("reasons").auto_shrink(false).show(ui, |ui| {
            let kinds = FindingKind::group(&reasons);
            if kinds.is_empty() {
                ui.weak("No findings.");
            }
            let (worst, more) = kinds.split_at(WORST.min(kinds.len()));
            let title = self.chosen.title();
            let mut show_all = |ui: &mut Ui, kinds: &[FindingKind<'_>]| {
                for kind in kinds {
                    if finding_rows::show(ctx, ui, kind) {
                        self.applied = kind.fix.as_ref().and_then(|fix| AppliedFix::apply(ctx, fix));
                    }
                }
            };
            show_all(ui, worst);
            if !more.is_empty() {
                CollapsingHeader::new(format!("{} more", more.len())).id_salt(title).show(ui, |ui| show_all(ui, more));
            }
        });
    }
}
