//! Derivatives of every window by itself beside those of all windows: one row per derivative, one column per window.

use doublet_engine::session::Manoeuvre;
use doublet_engine::stage::CoefficientFit;
use eframe::egui::{self, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::panels::manoeuvres::manoeuvre_list::menu;
use crate::panels::{PanelContext, awaiting, dim_if, is_window_constant, lacks_estimate, role_color, select};
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::figures_grid;
use crate::{notation, theme};

/// Estimate and standard error of `derivative` among `fits`.
fn parameter(fits: &[CoefficientFit], derivative: &str) -> Option<(f64, f64)> {
    fits.iter().find_map(|fit| fit.fit.as_ref().ok()?.parameter(derivative))
}

fn fits<'a>(ctx: &PanelContext<'a>, window: &Manoeuvre) -> &'a [CoefficientFit] {
    let results = ctx.snapshot.windows.get(&window.name).and_then(|results| results.fits.latest());
    results.map_or(&[], |fits| &fits.fits)
}

/// Draws the table; copies it first where that was asked for.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, copy: bool) {
    let Some(pooled) = ctx.snapshot.pooled.latest() else {
        return awaiting(ctx, ui, "the derivatives", &lacks_estimate(ctx));
    };
    let windows: Vec<&Manoeuvre> = ctx.session.active_windows().collect();
    let models = &ctx.session.structure.models;
    let names: Vec<String> = models
        .iter()
        .flat_map(|(coefficient, terms)| terms.iter().map(|term| term.derivative_name(*coefficient)))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).filter(|name| !is_window_constant(name)).collect();
    if copy {
        ui.ctx().copy_text(csv(ctx, &names, &windows));
    }
    dim_if(ui, ctx.snapshot.pooled.is_stale());
    ScrollArea::horizontal().show(ui, |ui| {
        figures_grid(ui, "by manoeuvre")
            .column(Column::exact(74.0))
            .columns(Column::exact(84.0).clip(true), windows.len() + 1)
            .header(22.0, |mut header| {
                header.col(|_| {});
                header.col(|ui| {
                    ui.strong("all");
                });
                for window in &windows {
                    header.col(|ui| heading(ctx, ui, window));
                }
            })
            .body(|body| {
                body.rows(20.0, names.len(), |mut row| {
                    let name = names[row.index()];
                    row.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            ui.label(notation::derivative_job(ui, name));
                        });
                    });
                    row.col(|ui| cell(ui, parameter(&pooled.fits, name), true));
                    for window in &windows {
                        row.col(|ui| cell(ui, parameter(fits(ctx, window), name), false));
                    }
                });
            });
    });
}

/// Name of a window in the colour of its use; a click chooses it.
fn heading(ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
    let mut text = RichText::new(&window.name).size(11.0).color(role_color(theme::palette(ui), window.role));
    if ctx.selection().is_selected(&window.name) {
        text = text.strong().background_color(ui.visuals().selection.bg_fill);
    }
    let label = ui.add(egui::Label::new(text).truncate().sense(egui::Sense::click()));
    label.context_menu(|ui| menu(ctx, ui, window));
    if label.on_hover_text(&window.name).clicked() {
        let modifiers = ui.input(|input| input.modifiers);
        select(ctx.state, ctx.session, &window.name, modifiers);
    }
}

/// One estimate; its standard error under the pointer.
fn cell(ui: &mut Ui, parameter: Option<(f64, f64)>, strong: bool) {
    let Some((estimate, error)) = parameter else { return };
    let mut text = RichText::new(notation::number(estimate)).font(theme::figures(ui));
    if strong {
        text = text.strong();
    }
    ui.label(text).on_hover_text(format!("± {}", notation::number(error)));
}

/// The table as text for other programs.
fn csv(ctx: &PanelContext<'_>, names: &[&str], windows: &[&Manoeuvre]) -> String {
    let mut rows = Vec::new();
    for name in names {
        for window in windows {
            let found = parameter(fits(ctx, window), name);
            rows.extend(found.map(|found| (name, &window.name, window.role.name(), found)));
        }
    }
    csv_text(&["derivative", "manoeuvre", "role", "estimate", "standard_error"], rows)
}
