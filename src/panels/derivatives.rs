//! Derivatives with their uncertainty: of all identification windows, of the chosen one, or window by window.

use doublet_core::estimate::Fit;
use doublet_engine::stage::CoefficientFit;
use eframe::egui::{self, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::by_window;
use super::{Panel, PanelContext, empty, is_window_constant, trouble};
use crate::notation;
use crate::theme;
use crate::ui_state::Scope;

/// Height of a row.
const ROW: f32 = 20.0;
/// Titles of the columns.
const TITLES: [&str; 6] = ["", "Estimate", "Std. error", "Corrected", "Relative", "t"];

/// The panel.
pub struct Derivatives;

impl Panel for Derivatives {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let window = ctx.selection().window.clone();
        let of_window = ctx.results();
        let copied = ui.horizontal(|ui| {
            let selection = &mut ctx.state.selection;
            let name = format!("{} alone", window.as_deref().unwrap_or("chosen window"));
            for (scope, name) in
                [(Scope::All, "All windows"), (Scope::Chosen, &name), (Scope::Each, "Window by window")]
            {
                ui.selectable_value(&mut selection.scope, scope, name);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let copied = ui.button("Copy as CSV").on_hover_text("Copy the table to the clipboard").clicked();
                if selection.scope == Scope::All {
                    ui.checkbox(&mut selection.constants, "constants").on_hover_text("The constant of every window");
                }
                copied
            })
            .inner
        });
        let (error, fits, stale) = match ctx.selection().scope {
            Scope::Each => return by_window::show(ctx, ui, copied.inner),
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
            return empty(ui, if snapshot.busy { "Computing…" } else { "No window is used for identification." });
        };
        if copied.inner {
            ui.ctx().copy_text(csv(fits));
        }
        if stale {
            ui.multiply_opacity(0.45);
        }
        table(ctx, ui, fits);
    }
}

/// One table with a line per coefficient and a row per derivative.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui, fits: &[CoefficientFit]) {
    ScrollArea::horizontal().show(ui, |ui| {
        TableBuilder::new(ui)
            .id_salt("derivatives")
            .striped(true)
            .auto_shrink(false)
            .sense(egui::Sense::click())
            .cell_layout(egui::Layout::right_to_left(egui::Align::Center))
            .column(Column::remainder().at_least(190.0).clip(true))
            .columns(Column::exact(86.0), 3)
            .columns(Column::exact(74.0), 2)
            .header(20.0, |mut header| {
                for title in TITLES {
                    header.col(|ui| {
                        ui.add_space(4.0);
                        ui.weak(title);
                    });
                }
            })
            .body(|mut body| {
                for fit in fits {
                    body.row(ROW + 4.0, |mut row| {
                        row.col(|ui| heading(ui, fit));
                        for _ in 1..TITLES.len() {
                            row.col(|_| {});
                        }
                    });
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

/// The coefficient with its quality, or why it has no estimate. It may reach over the columns beside it.
fn heading(ui: &mut Ui, fit: &CoefficientFit) {
    let palette = theme::palette(ui);
    let clip = ui.clip_rect();
    ui.set_clip_rect(egui::Rect::from_min_max(clip.min, egui::pos2(clip.max.x + 420.0, clip.max.y)));
    let at = egui::pos2(ui.max_rect().left() + 2.0, ui.max_rect().center().y + 2.0);
    let name = fit.coefficient.name();
    let (text, color) = match &fit.fit {
        Ok(estimate) => (
            format!(
                "{name}   R² {}  residual {}",
                notation::fixed(estimate.quality.r_squared, 4),
                notation::number(estimate.residual_std)
            ),
            ui.visuals().strong_text_color(),
        ),
        Err(error) => (format!("{name}    ⚠ {error}"), palette.error),
    };
    ui.painter().text(at, egui::Align2::LEFT_CENTER, &text, egui::FontId::proportional(11.5), color);
    let response = ui.allocate_rect(ui.max_rect(), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
    if let Err(error) = &fit.fit {
        response.on_hover_text(error);
    }
}

/// One derivative.
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
            ui.add_space(14.0);
            let job = notation::derivative_job(ui, name);
            ui.add(egui::Label::new(job).selectable(false));
        });
    });
    let relative = fit.relative_errors_percent[at];
    let cells = [
        notation::number(fit.estimates[at]),
        notation::number(fit.standard_errors[at]),
        corrected.get(at).map_or_else(|| "–".to_owned(), |error| notation::number(*error)),
        if relative < 1e4 { format!("{} %", notation::fixed(relative, 1)) } else { "> 10⁴ %".to_owned() },
        notation::fixed(fit.t_values[at], 1),
    ];
    for (column, text) in cells.into_iter().enumerate() {
        row.col(|ui| {
            ui.add_space(4.0);
            let figures = theme::figures(ui);
            let mut text = RichText::new(text).font(figures);
            if column == 0 {
                text = text.strong();
            }
            if column == 3 && relative > 50.0 {
                text = text.color(theme::palette(ui).warning);
            }
            ui.add(egui::Label::new(text).selectable(false));
        });
    }
    if row.response().clicked() {
        let chosen = &mut ctx.state.selection.derivative;
        *chosen = if chosen.as_deref() == Some(name.as_str()) { None } else { Some(name.clone()) };
    }
}

/// The table as text for other programs.
pub fn csv(fits: &[CoefficientFit]) -> String {
    let mut text = "derivative,estimate,standard_error,corrected_error,relative_percent,t\n".to_owned();
    for coefficient in fits {
        let Ok(fit) = &coefficient.fit else { continue };
        for (at, name) in fit.names.iter().enumerate() {
            let corrected = coefficient.corrected_errors.get(at).map(f64::to_string).unwrap_or_default();
            let (estimate, error) = (fit.estimates[at], fit.standard_errors[at]);
            let (relative, t) = (fit.relative_errors_percent[at], fit.t_values[at]);
            text.push_str(&format!("{name},{estimate},{error},{corrected},{relative},{t}\n"));
        }
    }
    text
}
