//! Derivatives with their uncertainty: of all identification manoeuvres, of the selected one, or of each manoeuvre.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::estimate::Fit;
use doublet_engine::stage::{CoefficientFit, describe_origin, errors, significance};
use doublet_engine::verdict::{CONDITION_LIMIT, Level, Verdict, dependences};
use eframe::egui::{self, FontId, Galley, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::panels::results::{by_window, intervals, over_windows};
use crate::panels::{Panel, PanelContext, awaiting, dim_if, is_window_constant, lacks_estimate, trouble};
use crate::ui_state::Scope;
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::figures_grid;
use crate::widgets::level_mark;
use crate::widgets::term::column_title;
use crate::{notation, theme};

/// Height of a row.
const ROW: f32 = 20.0;
/// Letters of the line of a coefficient; room right of it, and its least width.
const HEADING: FontId = FontId::proportional(11.5);
const RIGHT_ROOM: f32 = 24.0;
const LEAST_WIDTH: f32 = 200.0;
/// Width of the column of names, and of those of figures with the room between them.
const NAMES: std::ops::RangeInclusive<f32> = 64.0..=150.0;
const FIGURES: f32 = 470.0;
const TITLES: [&str; 7] = ["", "Estimate", "Std. error", "Corrected", "Scatter/√n", "Relative", "t"];
pub struct Derivatives;

impl Panel for Derivatives {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let window = ctx.selection().window.clone();
        let of_window = ctx.results();
        let copied = ui.horizontal_wrapped(|ui| {
            let selection = &mut ctx.state.selection;
            let name = format!("{} alone", window.as_deref().unwrap_or("chosen manoeuvre"));
            for (scope, name) in [
                (Scope::All, "All manoeuvres"),
                (Scope::Chosen, &name),
                (Scope::Each, "Each manoeuvre"),
                (Scope::Over, "Over manoeuvres"),
                (Scope::Intervals, "Intervals"),
            ] {
                ui.selectable_value(&mut selection.scope, scope, name);
            }
            if selection.scope == Scope::All {
                ui.checkbox(&mut selection.constants, "constants").on_hover_text("Constant of every manoeuvre");
            }
            let scope = selection.scope;
            let is_copied = scope != Scope::Intervals
                && ui.button("Copy as CSV").on_hover_text("Copy the table to the clipboard").clicked();
            if matches!(scope, Scope::All | Scope::Chosen) {
                let unit = RichText::new("per rad, rates non-dimensional").size(11.0).weak();
                let unit = egui::Label::new(unit).wrap_mode(egui::TextWrapMode::Extend);
                ui.add(unit).on_hover_text("Rates are non-dimensional with the reference geometry");
            }
            is_copied
        });
        let (error, fits, stale) = match ctx.selection().scope {
            Scope::Each => return by_window::show(ctx, ui, copied.inner),
            Scope::Over => return over_windows::show(ctx, ui, copied.inner),
            Scope::Intervals => return intervals::show(ctx, ui),
            Scope::Chosen => {
                let slot = of_window.map(|results| &results.fits);
                let fits = slot.and_then(|slot| slot.latest()).map(|fits| fits.fits.as_slice());
                (slot.and_then(|slot| slot.error()), fits, slot.is_some_and(|slot| slot.is_stale()))
            }
            Scope::All => {
                let slot = &snapshot.pooled;
                (slot.error(), slot.latest().map(|pooled| pooled.fits.as_slice()), slot.is_stale())
            }
        };
        trouble(ui, error);
        let Some(fits) = fits.filter(|fits| !fits.is_empty()) else {
            return awaiting(ctx, ui, "the derivatives", &lacks_estimate(ctx));
        };
        if copied.inner {
            ui.ctx().copy_text(csv(fits));
        }
        dim_if(ui, stale);
        table(ctx, ui, fits);
    }
}

/// One table with a line per coefficient and a row per derivative.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui, fits: &[CoefficientFit]) {
    let (color, width) = (theme::palette(ui).error, (ui.available_width() - RIGHT_ROOM).max(LEAST_WIDTH));
    let layout_error = |fit: &CoefficientFit| {
        let text = format!("{}    ⚠ {}", fit.coefficient.name(), fit.fit.as_ref().err()?);
        let mut job = notation::typeset_in(&text, HEADING.size, color);
        job.wrap.max_width = width;
        Some((fit.coefficient, ui.painter().layout_job(job)))
    };
    let galleys: BTreeMap<_, _> = fits.iter().filter_map(layout_error).collect();
    let name_width = (ui.available_width() - FIGURES).clamp(*NAMES.start(), *NAMES.end());
    ScrollArea::horizontal().show(ui, |ui| {
        figures_grid(ui, "derivatives")
            .sense(egui::Sense::click())
            .column(Column::exact(name_width))
            .columns(Column::exact(70.0), 4)
            .column(Column::exact(58.0))
            .column(Column::exact(66.0))
            // What is left over stands right of the numbers, which stay beside their names.
            .column(Column::remainder().at_least(0.0))
            .header(20.0, |mut header| {
                for title in TITLES {
                    header.col(|ui| {
                        ui.add_space(4.0);
                        column_title(ui, title);
                    });
                }
                header.col(|_| {});
            })
            .body(|mut body| {
                for fit in fits {
                    let error_galley = galleys.get(&fit.coefficient).cloned();
                    let height = error_galley.as_ref().map_or(ROW + 4.0, |error_galley| error_galley.size().y + 8.0);
                    body.row(height, |row| heading(row, fit, error_galley.as_ref()));
                    let Ok(estimate) = &fit.fit else { continue };
                    for at in 0..estimate.parameters() {
                        if !ctx.selection().constants && is_window_constant(&estimate.names[at]) {
                            continue;
                        }
                        body.row(ROW, |row| derivative(ctx, row, estimate, &fit.corrected_errors, at));
                    }
                }
            });
    });
}

/// The coefficient with its quality, or why it has no estimate, across all columns.
fn heading(mut row: egui_extras::TableRow<'_, '_>, fit: &CoefficientFit, error_galley: Option<&Arc<Galley>>) {
    let mut line = egui::Rect::NOTHING;
    let mut visible = egui::Rect::NOTHING;
    for column in 0..=TITLES.len() {
        row.col(|ui| {
            line |= ui.max_rect();
            visible |= ui.clip_rect();
            // Drawn from the last cell, over the stripes of those before it.
            if column == TITLES.len() {
                ui.set_clip_rect(visible);
                quality(ui, line, fit, error_galley);
            }
        });
    }
}

/// How well the coefficient is fitted, or why it is not as it was laid out, in `line`.
fn quality(ui: &mut Ui, line: egui::Rect, fit: &CoefficientFit, error_galley: Option<&Arc<Galley>>) {
    let palette = theme::palette(ui);
    let name = fit.coefficient.name();
    let dropped: Vec<&str> = fit.dropped.iter().map(|term| term.derivative.as_str()).collect();
    let without = if dropped.is_empty() { String::new() } else { format!("   dropped {}", dropped.join(", ")) };
    let (text, color) = match &fit.fit {
        Ok(estimate) => (
            format!(
                "{name}   R² {}   residual {}   condition {} (limit {CONDITION_LIMIT}){without}",
                notation::fixed(estimate.quality.r_squared, 4),
                notation::number(estimate.residual_std),
                notation::number(estimate.condition_number)
            ),
            ui.visuals().strong_text_color(),
        ),
        Err(error) => (format!("{name}    ⚠ {error}"), palette.error),
    };
    let at = egui::pos2(line.left() + 2.0, line.center().y + 2.0);
    match error_galley {
        Some(error_galley) => {
            ui.painter().galley(line.left_top() + egui::vec2(2.0, 4.0), Arc::clone(error_galley), color)
        }
        None => {
            let galley = ui.painter().layout_job(notation::typeset_in(&text, HEADING.size, color));
            let place = egui::Align2::LEFT_CENTER.anchor_size(at, galley.size());
            ui.painter().galley(place.min, galley, color);
        }
    }
    let response = ui.interact(line, ui.scope_id().with("quality"), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
    match &fit.fit {
        Err(error) => {
            response.on_hover_text(error.to_string());
        }
        Ok(_) if !fit.dropped.is_empty() => {
            let reasons = fit.dropped.iter().map(|term| format!("{}: {}", term.derivative, term.reason));
            response.on_hover_text(reasons.collect::<Vec<_>>().join("\n"));
        }
        Ok(_) => {}
    }
}

/// The verdict on a derivative of the estimates shown.
fn judged<'a>(ctx: &PanelContext<'a>, name: &str) -> Option<&'a Verdict> {
    let verdicts = ctx.snapshot.verdicts.latest()?;
    let fits = match ctx.selection().scope {
        Scope::Chosen => &verdicts.windows.get(ctx.selection().window.as_deref()?)?.fits,
        _ => &verdicts.pooled,
    };
    let mut derivatives = fits.iter().flat_map(|fit| &fit.derivatives);
    derivatives.find(|derivative| derivative.name == name).map(|derivative| &derivative.verdict)
}

/// What a pooled derivative depends on that no flight shows wrong, a line each.
fn describe_dependences(ctx: &PanelContext<'_>, name: &str) -> String {
    let pooled = ctx.snapshot.pooled.latest();
    let has_it = |fit: &&CoefficientFit| fit.fit.as_ref().is_ok_and(|found| found.names.iter().any(|own| own == name));
    let Some(fit) = pooled.and_then(|pooled| pooled.fits.iter().find(has_it)) else { return name.to_owned() };
    let all = dependences(ctx.session, ctx.snapshot, fit, name);
    std::iter::once(name.to_owned()).chain(all.iter().map(ToString::to_string)).collect::<Vec<_>>().join("\n")
}

fn derivative(
    ctx: &mut PanelContext<'_>,
    mut row: egui_extras::TableRow<'_, '_>,
    fit: &Fit,
    corrected: &[f64],
    at: usize,
) {
    let name = &fit.names[at];
    row.set_selected(ctx.selection().derivative.as_deref() == Some(name.as_str()));
    row.col(|ui| {
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            let judged = judged(ctx, name);
            let (mark, place) = ui.allocate_exact_size(egui::vec2(14.0, 14.0), egui::Sense::hover());
            // Only what has something against it is marked.
            if let Some(verdict) = judged.filter(|verdict| verdict.level != Level::Good) {
                let color = level_mark::color(ui, Some(verdict.level));
                level_mark::paint(ui.painter(), mark.center(), 4.0, Some(verdict.level), color);
                let reasons: Vec<String> = verdict.reasons.iter().map(|reason| reason.text.to_string()).collect();
                let label = format!("{name}: {}", verdict.level.name());
                place.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &label));
                place.on_hover_text(notation::typeset(&reasons.join("\n"), 13.0));
            }
            let job = notation::derivative_job(ui, name);
            let label = ui.add(egui::Label::new(job).selectable(false));
            if label.hovered() {
                label.on_hover_text(notation::typeset(&describe_dependences(ctx, name), 13.0));
            }
        });
    });
    let (relative, t) = significance(fit, corrected, at);
    let kinds = ctx.snapshot.details.latest().and_then(|details| details.kinds.first());
    let over = kinds.and_then(|all| all.parameters.iter().find(|parameter| parameter.name == *name));
    let scatter = over.map_or(f64::NAN, |over| over.scatter / (over.fits as f64).sqrt());
    let (conventional, coloured) = errors(fit, corrected, at);
    let cells = [
        notation::number(fit.estimates[at]),
        describe_origin(fit.origins[at])
            .filter(|_| conventional.is_nan())
            .map_or_else(|| notation::number(conventional), str::to_owned),
        notation::number(coloured),
        notation::number(scatter),
        if relative.is_nan() {
            "–".to_owned()
        } else if relative < 1e4 {
            format!("{} %", notation::fixed(relative, if relative < 100.0 { 1 } else { 0 }))
        } else {
            "> 10⁴ %".to_owned()
        },
        notation::fixed(t, if t.abs() < 1e4 { 1 } else { 0 }),
    ];
    for (column, text) in cells.into_iter().enumerate() {
        row.col(|ui| {
            ui.add_space(4.0);
            let figures = theme::figures(ui);
            let mut text = RichText::new(text).font(figures);
            if column == 0 {
                text = text.strong();
            }
            if column == 4 && relative > 50.0 {
                text = text.color(theme::palette(ui).warning);
            }
            ui.add(egui::Label::new(text).selectable(false));
        });
    }
    row.col(|_| {});
    if row.response().clicked() {
        let chosen = &mut ctx.state.selection.derivative;
        *chosen = if chosen.as_deref() == Some(name.as_str()) { None } else { Some(name.clone()) };
    }
}

/// The table as text for other programs.
pub fn csv(fits: &[CoefficientFit]) -> String {
    let mut rows = Vec::new();
    for coefficient in fits {
        let Ok(fit) = &coefficient.fit else { continue };
        for (at, name) in fit.names.iter().enumerate() {
            let (estimate, (error, corrected)) = (fit.estimates[at], errors(fit, &coefficient.corrected_errors, at));
            let (relative, t) = significance(fit, &coefficient.corrected_errors, at);
            rows.push((name, [estimate, error, corrected, relative, t]));
        }
    }
    csv_text(&["derivative", "estimate", "standard_error", "corrected_error", "relative_percent", "t"], rows)
}
