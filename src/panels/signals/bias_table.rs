//! Wind and sensor biases at the end of every window, and over all windows (thesis Tables 6.1 and 6.2).

use doublet_engine::stage::{BIAS_STATES, BiasTable};
use eframe::egui::{self, RichText, Ui};
use egui_extras::Column;

use crate::panels::{PanelContext, awaiting, dim_if};
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::texts_grid;
use crate::{notation, theme};

/// Names of the lines below the windows.
const SUMMARY: [&str; 4] = ["mean", "σ", "min", "max"];
/// Decimals of a wind and of a bias.
const DIGITS: i32 = 4;

/// Draws the table.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let Some(details) = ctx.snapshot.details.latest() else {
        return awaiting(ctx, ui, "the paths of all manoeuvres", "No manoeuvre has a flight path.");
    };
    let table = &details.biases;
    ui.horizontal(|ui| {
        ui.weak("Mean over the last second of every manoeuvre");
        if ui.button("Copy as CSV").clicked() {
            ui.ctx().copy_text(csv(table));
        }
    });
    dim_if(ui, ctx.snapshot.details.is_stale());
    let figures = theme::figures(ui);
    let units = BIAS_STATES.map(|state| ctx.unit(state.dimension()));
    let summary = SUMMARY.iter().zip(&table.summary).map(|(name, values)| (*name, values, true));
    let windows = table.rows.iter().map(|(name, values)| (name.as_str(), values, false));
    let rows: Vec<(&str, &[f64; 9], bool)> = windows.chain(summary).collect();
    egui::ScrollArea::horizontal().show(ui, |ui| {
        texts_grid(ui, "biases")
            .column(Column::initial(130.0).clip(true).resizable(true))
            .columns(Column::exact(82.0), BIAS_STATES.len())
            .header(34.0, |mut header| {
                header.col(|ui| {
                    ui.weak("Manoeuvre");
                });
                for (state, (unit, _)) in BIAS_STATES.into_iter().zip(units) {
                    header.col(|ui| {
                        ui.vertical(|ui| {
                            ui.spacing_mut().item_spacing.y = 0.0;
                            ui.label(notation::state(state));
                            ui.label(RichText::new(unit).size(10.5).weak());
                        });
                    });
                }
            })
            .body(|body| {
                body.rows(20.0, rows.len(), |mut row| {
                    let (name, values, strong) = rows[row.index()];
                    row.col(|ui| {
                        let text = RichText::new(name);
                        ui.label(if strong { text.strong() } else { text });
                    });
                    for (value, (_, scale)) in values.iter().zip(units) {
                        row.col(|ui| {
                            let shown = crate::notation::rounded(scale * value, DIGITS);
                            let text = RichText::new(notation::number(shown)).font(figures.clone()).size(11.0);
                            ui.label(if strong { text.strong() } else { text });
                        });
                    }
                });
            });
    });
}

/// The table in SI as text for other programs.
fn csv(table: &BiasTable) -> String {
    let titles = BIAS_STATES.map(|state| format!("{} [{}]", state.name(), state.dimension().si_symbol()));
    let titles: Vec<&str> = std::iter::once("manoeuvre").chain(titles.iter().map(String::as_str)).collect();
    let rows = table.rows.iter().map(|(name, values)| (name.as_str(), values));
    csv_text(&titles, rows.chain(SUMMARY.into_iter().zip(&table.summary)))
}
