//! The two structures of the session beside each other: which derivatives they give, how well they fit.

use doublet_engine::stage::{CoefficientFit, PooledFits};
use eframe::egui::{self, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::notation;
use crate::panels::results::intervals::estimate;
use crate::panels::{PanelContext, awaiting, dim_if, empty, is_window_constant};
use crate::theme;
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::figures_grid;
use crate::widgets::term::column_titles;

const TITLES: [&str; 6] = ["", "A", "±", "B", "±", "B − A"];
/// Opacity of a difference of nothing.
const SAME: f32 = 0.35;

/// A row of the table: a coefficient, or a derivative with estimate and error by both structures.
struct Row {
    name: String,
    is_coefficient: bool,
    /// Both are the same.
    is_same: bool,
    cells: [String; 5],
    /// Estimate and error of both, and the difference.
    values: [Option<f64>; 5],
}

/// Draws the table; copies it first where that was asked for.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, copy: bool) {
    if ctx.session.second_structure.is_none() {
        return empty(ui, "Keep a second structure in the Model panel to see both here.");
    }
    let (Some(first), Some(second)) = (ctx.snapshot.pooled.latest(), ctx.snapshot.second.latest()) else {
        return awaiting(ctx, ui, "both estimates", "No estimate yet.");
    };
    let rows = rows(first, second);
    if copy {
        let titles = ["derivative", "a", "a_corrected_error", "b", "b_corrected_error", "difference"];
        let derivatives = rows.iter().filter(|row| !row.is_coefficient).map(|row| (&row.name, row.values));
        ui.ctx().copy_text(csv_text(&titles, derivatives));
    }
    dim_if(ui, ctx.snapshot.second.is_stale());
    ScrollArea::horizontal().show(ui, |ui| {
        figures_grid(ui, "structures")
            .column(Column::remainder().at_least(90.0).clip(true))
            .columns(Column::exact(78.0), TITLES.len() - 1)
            .header(20.0, |header| column_titles(header, TITLES))
            .body(|body| {
                body.rows(20.0, rows.len(), |mut line| {
                    let row = &rows[line.index()];
                    line.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            if row.is_coefficient {
                                ui.strong(&row.name);
                            } else {
                                ui.add_space(14.0);
                                ui.label(notation::derivative_job(ui, &row.name));
                            }
                        });
                    });
                    for (column, text) in row.cells.iter().enumerate() {
                        line.col(|ui| {
                            let mut text = RichText::new(text).font(theme::figures(ui)).size(11.5);
                            if row.is_coefficient {
                                text = text.weak();
                            }
                            // What does not differ steps back behind what does.
                            let is_same = column + 1 == row.cells.len() && row.is_same;
                            ui.scope(|ui| {
                                ui.multiply_opacity(if is_same { SAME } else { 1.0 });
                                ui.label(text);
                            });
                        });
                    }
                });
            });
    });
}

fn rows(first: &PooledFits, second: &PooledFits) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut coefficients: Vec<_> = first.fits.iter().chain(&second.fits).map(|fit| fit.coefficient).collect();
    coefficients.sort_unstable();
    coefficients.dedup();
    for coefficient in coefficients {
        let find_fit = |fits: &PooledFits| fits.fits.iter().find(|fit| fit.coefficient == coefficient).cloned();
        let both = [find_fit(first), find_fit(second)];
        rows.push(heading(coefficient.name(), &both));
        let mut names: Vec<String> = Vec::new();
        for fit in both.iter().flatten().filter_map(|fit| fit.fit.as_ref().ok()) {
            for name in fit.names.iter().filter(|name| !is_window_constant(name)) {
                if !names.contains(name) {
                    names.push(name.clone());
                }
            }
        }
        rows.extend(names.into_iter().map(|name| derivative(name, &both)));
    }
    rows
}

/// How well both fit the coefficient.
fn heading(name: &str, both: &[Option<CoefficientFit>; 2]) -> Row {
    let quality =
        |fit: &Option<CoefficientFit>| fit.as_ref().and_then(|fit| Some(fit.fit.as_ref().ok()?.quality.r_squared));
    let [a, b] = [quality(&both[0]), quality(&both[1])];
    let text = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("R² {}", notation::fixed(value, 4)));
    let change = a.zip(b).map_or(String::new(), |(a, b)| notation::fixed(b - a, 4));
    Row {
        name: name.to_owned(),
        is_coefficient: true,
        is_same: a == b,
        cells: [text(a), String::new(), text(b), String::new(), change],
        values: [None; 5],
    }
}

fn derivative(name: String, both: &[Option<CoefficientFit>; 2]) -> Row {
    let [a, b] = both.each_ref().map(|fit| estimate(fit.as_slice(), &name));
    let number = |value: Option<f64>| value.map_or(String::new(), notation::number);
    let difference = a.zip(b).map(|(a, b)| b.0 - a.0);
    let values = [a.map(|a| a.0), a.map(|a| a.1), b.map(|b| b.0), b.map(|b| b.1), difference];
    Row { is_same: difference == Some(0.0), cells: values.map(number), values, name, is_coefficient: false }
}
