//! What lies between the markers A and B: values at both, their difference and slope, statistics.

use doublet_core::series::{Series, Statistics, value_at};
use doublet_engine::notation::significant;
use eframe::egui::{self, Id, Response, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::csv_text::csv_text;
use super::plot_cache::{Drawn, PlotCache};
use super::term::column_title;
use super::time_plot::{TimePlot, Trace};
use super::time_view::{TimeRange, TimeView};
use super::trace_style::DOT_SPACING;
use crate::theme;

/// Height of a row, and of the lines above the rows.
const ROW: f32 = 18.0;
const HEAD: f32 = 52.0;
/// Part of the room the table may take.
const LARGEST_PART: f32 = 0.4;
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
                            ui.label(RichText::new(readable(value)).font(figures.clone()).size(11.0));
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
            let statistic = |value: fn(&Statistics) -> f64| found.as_ref().map_or(f64::NAN, value);
            let values = [
                first,
                second,
                second - first,
                (second - first) / (b - a),
                statistic(|found| found.min),
                statistic(|found| found.max),
                statistic(|found| found.mean),
                statistic(|found| found.rms),
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
    let times = [a, b].map(|time_s| format!("at {time_s} s"));
    let titles = ["signal", &times[0], &times[1], "difference", "per s", "min", "max", "mean", "rms"];
    csv_text(&titles, rows.iter().map(|row| (&row.name, row.values)))
}

/// Says to a screen reader what a plot shows, in which unit, and its values at the cursor or else at marker A.
pub(super) fn describe<'a>(
    response: &Response,
    plot: &TimePlot<'_>,
    view: &TimeView,
    look: &dyn Fn(usize) -> Option<&'a Drawn>,
) {
    response.ctx.accesskit_node_builder(response.id, |node| {
        let names: Vec<&str> = plot.traces.iter().map(|trace| trace.name).collect();
        let label = if plot.label.is_empty() { names.join(", ") } else { plot.label.to_owned() };
        let unit = if plot.unit.is_empty() { String::new() } else { format!(" {}", plot.unit) };
        node.set_role(egui::accesskit::Role::Image);
        node.set_label(if unit.is_empty() { format!("plot: {label}") } else { format!("plot: {label} in{unit}") });
        let Some(time_s) = view.cursor_s.or(view.markers_s[0]) else { return };
        let read = |(column, trace): (usize, &Trace<'_>)| {
            let value = value_of(trace, look(column)?.pyramid.gap_s(), time_s, 1.0)?;
            Some(format!("{} {}{unit}", trace.name, with_band(trace, value, Some(time_s))))
        };
        let values: Vec<String> = plot.traces.iter().enumerate().filter_map(read).collect();
        node.set_value(format!("at {time_s:.2} s: {}", values.join(", ")));
    });
}

/// `value` as it is read beside a curve: four significant digits.
pub fn readable(value: f64) -> String {
    significant(value, 4)
}

/// Value of a trace at a time in the unit of its plot: that of the nearest sample where single samples are seen apart, otherwise by the
/// line between them, also of dots, so that curves of one clock are read at one instant.
pub(super) fn value_of(trace: &Trace<'_>, gap_s: f64, time_s: f64, points_per_s: f64) -> Option<f64> {
    let Series { time_s: times, values, .. } = trace.series;
    let after = times.partition_point(|&time| time < time_s);
    let finite = |at: &usize| values[*at].is_finite();
    let near = |at: &usize| (times[*at] - time_s).abs() <= gap_s;
    // Samples of other channels at the same clock have no value here: the next that has one counts.
    let before = (0..after).rev().take_while(near).find(finite);
    let next = (after..times.len()).take_while(near).find(finite);
    let distance = |at: &usize| (times[*at] - time_s).abs();
    let nearest = before.into_iter().chain(next).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let spacing = before.zip(next).map_or(0.0, |(before, next)| times[next] - times[before]);
    let is_alone = before.zip(next).is_none();
    let is_dot = spacing * points_per_s >= f64::from(DOT_SPACING) || trace.style.is_points() && is_alone;
    let between = || value_at(times, values, gap_s, time_s);
    let value = match (trace.sigma, nearest) {
        (None, Some(at)) if is_dot => Some(values[at]),
        (None, Some(at)) if before.zip(next).is_some() => between().or(Some(values[at])),
        _ => between(),
    };
    value.map(|value| value * trace.scale)
}

/// A value with twice the deviation of its trace; that alone of a band about zero.
pub(super) fn with_band(trace: &Trace<'_>, value: f64, time_s: Option<f64>) -> String {
    let band = trace.sigma.zip(time_s).and_then(|(sigma, time_s)| {
        let at = trace.series.time_s.partition_point(|&time| time < time_s);
        sigma.get(at.min(sigma.len().checked_sub(1)?)).map(|sigma| 2.0 * sigma * trace.scale)
    });
    match band {
        Some(half) if value == 0.0 => format!("± {}", readable(half)),
        Some(half) => format!("{} ± {}", readable(value), readable(half)),
        None => readable(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::widgets::time_plot::TraceStyle;

    #[test]
    fn a_dot_is_read_at_its_sample_and_a_band_by_its_width() {
        let series = Series { time_s: [0.0, 0.1, 0.2].into(), values: [1.0, -3.0, 5.0].into() };
        let line = Trace { scale: 2.0, ..Trace::new("line", &series, eframe::egui::Color32::WHITE) };
        let dots = Trace { style: TraceStyle::Dots, ..line };
        let dense = 1.0;
        assert_eq!(value_of(&dots, 0.25, 0.12, 1000.0), Some(-6.0), "the sample at 0.1 s");
        let between = value_of(&line, 0.25, 0.12, dense).unwrap();
        assert!((between - 2.0 * (-3.0 + 0.2 * 8.0)).abs() < 1e-12, "{between}");
        assert_eq!(value_of(&dots, 0.25, 0.12, dense), Some(between), "dots that run together are a line");
        assert_eq!(value_of(&dots, 0.25, 0.3, dense), Some(10.0), "the last one");
        assert_eq!(value_of(&line, 0.25, 0.12, 1000.0), Some(-6.0), "samples a hundred points apart are dots");
        assert_eq!(value_of(&line, 0.25, 0.3, dense), None);
        let sparse = Series { values: [1.0, f64::NAN, 5.0].into(), ..series.clone() };
        assert_eq!(value_of(&Trace { series: &sparse, ..dots }, 0.25, 0.12, dense), Some(10.0), "the nearest there is");
        let zero = Series { values: [0.0; 3].into(), ..series.clone() };
        let sigma = [0.01, 0.02, 0.03].into();
        let band = Trace { sigma: Some(&sigma), series: &zero, ..line };
        assert_eq!(with_band(&band, 0.0, Some(0.1)), "± 0.08000");
        assert_eq!(with_band(&Trace { sigma: Some(&sigma), ..line }, -6.0, Some(0.1)), "\u{2212}6.000 ± 0.08000");
    }

    #[test]
    fn numbers_read_with_four_digits_and_a_true_minus() {
        assert_eq!(readable(0.0), "0");
        assert_eq!(readable(12.345678), "12.35");
        assert_eq!(readable(1219.34), "1219");
        assert_eq!(readable(-0.001234567), "\u{2212}0.001235");
        assert_eq!(readable(-1.5e-7), "\u{2212}1.500e\u{2212}7");
        assert_eq!(readable(123_456.0), "123456");
    }
}
