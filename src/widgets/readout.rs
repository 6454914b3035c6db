//! What lies between the markers A and B: values at both, their difference and slope, statistics.

use doublet_core::series::{Statistics, value_at};
use eframe::egui::{self, Id, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::plot_cache::PlotCache;
use super::term::column_title;
use super::time_plot::{TimePlot, readable};
use super::time_view::{TimeRange, TimeView};
use crate::theme;

/// Height of a row, and of the lines above the rows.
const ROW: f32 = 18.0;
const HEAD: f32 = 52.0;
/// Part of the room the table may take.
const LARGEST_PART: f32 = 0.4;
/// Titles of the columns.
const TITLES: [&str; 9] = ["", "A", "B", "B − A", "per s", "min", "max", "mean", "rms"];

/// Both markers, where both are set apart from each other.
fn between(view: &TimeView) -> Option<(f64, f64)> {
    let [Some(a), Some(b)] = view.markers_s else { return None };
    (a != b).then_some((a, b))
}

/// Height the table needs under `plots` in a room of `room` points; zero without both markers.
pub(super) fn height(view: &TimeView, plots: &[TimePlot<'_>], room: f32) -> f32 {
    if between(view).is_none() {
        return 0.0;
    }
    let rows = plots.iter().map(|plot| plot.traces.len()).sum::<usize>();
    (HEAD + ROW * rows as f32).min(LARGEST_PART * room)
}

/// A row: name with unit, then values in the order of [`TITLES`].
struct Row {
    name: String,
    values: [f64; 8],
}

/// Draws the table.
pub(super) fn show(ui: &mut Ui, id: Id, view: &mut TimeView, cache: &mut PlotCache, plots: &[TimePlot<'_>]) {
    let Some((a, b)) = between(view) else { return };
    let rows = rows(id, (a, b), cache, plots);
    ui.horizontal(|ui| {
        let [first, second] = theme::palette(ui).markers;
        ui.label(RichText::new(format!("A {a:.3} s")).color(first));
        ui.label(RichText::new(format!("B {b:.3} s")).color(second));
        ui.label(format!("B − A {:.3} s", b - a));
        if ui.small_button("Copy").on_hover_text("Copy this table as CSV").clicked() {
            ui.ctx().copy_text(csv((a, b), &rows));
        }
        if ui.small_button("✖").on_hover_text("Clear markers (Escape)").clicked() {
            view.markers_s = [None; 2];
        }
    });
    let figures = theme::figures(ui);
    ScrollArea::horizontal().id_salt(id.with("readout")).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        TableBuilder::new(ui)
            .id_salt(id.with("between"))
            .striped(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::right_to_left(egui::Align::Center))
            .column(Column::initial(150.0).clip(true))
            .columns(Column::exact(78.0), TITLES.len() - 1)
            .header(ROW, |mut header| {
                for title in TITLES {
                    header.col(|ui| {
                        column_title(ui, title);
                    });
                }
            })
            .body(|body| {
                body.rows(ROW, rows.len(), |mut line| {
                    let row = &rows[line.index()];
                    line.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| ui.label(&row.name));
                    });
                    for value in row.values {
                        line.col(|ui| {
                            let text =
                                if value.is_finite() { readable(value).replace('-', "\u{2212}") } else { "–".into() };
                            ui.label(RichText::new(text).font(figures.clone()).size(11.0));
                        });
                    }
                });
            });
    });
}

/// One row per trace.
fn rows(id: Id, (a, b): (f64, f64), cache: &mut PlotCache, plots: &[TimePlot<'_>]) -> Vec<Row> {
    let mut rows = Vec::new();
    for (row, plot) in plots.iter().enumerate() {
        for (column, trace) in plot.traces.iter().enumerate() {
            let Some(drawn) = cache.drawn.get_mut(&(id, row, column)) else { continue };
            let series = trace.series;
            let gap_s = drawn.pyramid.gap_s();
            let at = |time_s| value_at(&series.time_s, &series.values, gap_s, time_s).unwrap_or(f64::NAN);
            let (first, second) = (at(a), at(b));
            let found = drawn.statistics(TimeRange::new(a, b));
            let of = |value: fn(&Statistics) -> f64| found.as_ref().map_or(f64::NAN, value);
            let values = [
                first,
                second,
                second - first,
                (second - first) / (b - a),
                of(|found| found.min),
                of(|found| found.max),
                of(|found| found.mean),
                of(|found| found.rms),
            ];
            let unit = if plot.unit.is_empty() { String::new() } else { format!(" [{}]", plot.unit) };
            let label = if plot.label.is_empty() || plot.label == trace.name { "" } else { plot.label };
            let name = format!("{label} {}{unit}", trace.name).trim_start().to_owned();
            rows.push(Row { name, values: values.map(|value| trace.scale * value) });
        }
    }
    rows
}

/// The table as text for other programs.
fn csv((a, b): (f64, f64), rows: &[Row]) -> String {
    let mut text = format!("signal,at {a} s,at {b} s,difference,per s,min,max,mean,rms\n");
    for row in rows {
        let values: Vec<String> = row.values.iter().map(f64::to_string).collect();
        text.push_str(&format!("\"{}\",{}\n", row.name, values.join(",")));
    }
    text
}
