//! Stacked time plots with one time axis, one cursor and one left margin.

use std::sync::Arc;

use doublet_core::series::Series;
use eframe::egui::{self, Align2, Color32, CornerRadius, Id, Rect, Stroke, Ui, pos2, vec2};
use egui_plot::{LineStyle, Plot};

use super::chart::{LEGEND_HEIGHT, LegendMark, legend_entry, legend_mark};
use super::figure::FigureRequest;
use super::plot_cache::Drawn;
pub use super::plot_cache::PlotCache;
use super::pointer::{Area, Values, interact, plot_menu, time_axis, value_axis};
pub use super::pointer::{MarkKind, Marked, StackMenu, StackResponse, mark, step_markers};
use super::readout::{self, readable, value_of, with_band};
use super::stack_figure::stack_figure;
use super::ticks::{draw_time_axis, inner_ticks, tick, ticks};
use super::time_view::{TimeRange, TimeView};
pub use super::trace_style::TraceStyle;
use super::trace_style::draw_trace;
use crate::{notation, theme};

/// Width of the value axis of every plot of a stack, so that their time axes line up.
pub const VALUE_AXIS_WIDTH: f32 = 86.0;
/// Room left of the value axis for the upright label, which is centred on the edge.
const LABEL_ROOM: f32 = 8.0;
/// Room right of the frames for the half of the last time label that lies beyond them.
const RIGHT_ROOM: f32 = 18.0;
/// Height of the time axis below the last plot.
pub const TIME_AXIS_HEIGHT: f32 = 34.0;
/// Least height of one plot; a stack that needs more scrolls, its time axis stays.
const LEAST_HEIGHT: f32 = 82.0;
/// Room above and below the data, as a fraction of their extent.
const MARGIN: f64 = 0.08;
/// Height of the legend inside a plot with the room about it.
const LEGEND_ROOM: f32 = 19.0;
/// Least distance between ticks of the time axis and of a value axis.
const TICK_SPACING: [f32; 2] = [84.0, 18.0];

/// One curve of a plot.
#[derive(Clone, Copy, Debug)]
pub struct Trace<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Samples in SI.
    pub series: &'a Series,
    /// Standard deviation of each sample in SI, drawn as a band of plus and minus twice its size.
    pub sigma: Option<&'a Arc<[f64]>>,
    /// Factor from SI to the unit of the plot.
    pub scale: f64,
    /// Colour.
    pub color: Color32,
    /// How it is drawn.
    pub style: TraceStyle,
    /// Out of date: drawn pale until replaced.
    pub stale: bool,
}

impl<'a> Trace<'a> {
    /// A plain line in SI units.
    pub fn new(name: &'a str, series: &'a Series, color: Color32) -> Self {
        Self { name, series, sigma: None, scale: 1.0, color, style: TraceStyle::Line, stale: false }
    }

    /// Its mark in a legend: a band is a box.
    fn legend(&self) -> LegendMark {
        if self.sigma.is_some() { LegendMark::Box } else { self.style.legend() }
    }
}

/// One plot of a stack.
#[derive(Clone, Debug)]
pub struct TimePlot<'a> {
    /// Label of the value axis without its unit.
    pub label: &'a str,
    /// Unit of the value axis.
    pub unit: &'a str,
    /// Curves, first drawn first.
    pub traces: Vec<Trace<'a>>,
    /// Fixed value range in the plot's unit; `None` fits what is visible.
    pub value_range: Option<(f64, f64)>,
    /// Fits the value range to the bands alone, with room for twice their height: single far samples may leave the plot.
    pub fit_bands: bool,
    /// Horizontal lines to compare with, in the plot's unit, for example a chi-square bound.
    pub levels: Vec<f64>,
    /// Height over that of the other plots of its stack.
    pub height: f32,
}

/// Value range of a plot for what is drawn of its traces.
pub(super) fn value_range<'a>(plot: &TimePlot<'_>, drawn: impl Iterator<Item = &'a Drawn>) -> (f64, f64) {
    let extents = drawn.flat_map(|drawn| {
        let band = drawn.band_extent.map(|(low, high)| {
            let room = if plot.fit_bands { 0.5 * (high - low) } else { 0.0 };
            (low - room, high + room)
        });
        drawn.line.extent.filter(|_| !plot.fit_bands).into_iter().chain(band)
    });
    plot.value_range.unwrap_or_else(|| value_bounds(extents))
}

impl<'a> TimePlot<'a> {
    /// Label of the value axis with its unit.
    pub(super) fn axis_label(&self) -> String {
        match (self.label, self.unit) {
            (label, "") => label.to_owned(),
            ("", unit) => format!("[{unit}]"),
            (label, unit) => format!("{label} [{unit}]"),
        }
    }

    /// A plot that fits its values to what is visible.
    pub fn new(label: &'a str, unit: &'a str, traces: Vec<Trace<'a>>) -> Self {
        Self { label, unit, traces, value_range: None, fit_bands: false, levels: Vec::new(), height: 1.0 }
    }

    /// Height over that of the other plots of its stack.
    #[must_use]
    pub fn high(self, height: f32) -> Self {
        Self { height, ..self }
    }
}

/// A coloured part of time behind the traces.
#[derive(Clone, Copy, Debug)]
pub struct SpanMark {
    pub part: TimeRange,
    /// Colour, drawn faintly.
    pub color: Color32,
    /// Drawn a little stronger, with edges.
    pub selected: bool,
}

/// Value range that shows `extents` with some room, never empty.
pub fn value_bounds(extents: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (low, high) = extents.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e.0), high.max(e.1)));
    if low > high {
        return (-1.0, 1.0);
    }
    // Labels of a signal that hardly moves stay short enough for the axis.
    let least = match low.abs().max(high.abs()) {
        0.0 => 1.0,
        size if low == high => 1e-2 * size,
        size => 1e-6 * size,
    };
    let room = (MARGIN * (high - low)).max(least);
    (low - room, high + room)
}

/// Shows `plots` under one another over the range of `view` and lets the pointer move it: the wheel zooms time about the pointer, with
/// Shift the values; a drag pans, with Ctrl or Alt it marks, a right drag zooms to a box, a drag on an axis zooms that axis, a double
/// click shows everything; A and B, or Shift and Ctrl with a click, set the markers, the arrow keys step them by a sample. A click on a name of the legend hides it, a
/// double click hides the others. A right click opens a menu with figures and numbers to take away, Ctrl+C takes a picture. With both
/// markers set a table below says what lies between them.
pub fn time_stack(
    ui: &mut Ui,
    id: Id,
    view: &mut TimeView,
    cache: &mut PlotCache,
    plots: &[TimePlot<'_>],
    spans: &[SpanMark],
) -> StackResponse {
    time_stack_with(ui, id, view, cache, plots, spans, &mut |_, _, _| {})
}

/// [`time_stack`] with more in the menu of its plots.
pub fn time_stack_with(
    ui: &mut Ui,
    id: Id,
    view: &mut TimeView,
    cache: &mut PlotCache,
    plots: &[TimePlot<'_>],
    spans: &[SpanMark],
    menu: StackMenu<'_>,
) -> StackResponse {
    let mut out = StackResponse::default();
    if plots.is_empty() {
        return out;
    }
    cache.follow(id, view.homes());
    let shared = shared_names(plots);
    let mut named = shared.and_then(|plot| shared_legend(ui, id, plot, cache));
    let room = ui.available_size();
    let readout = readout::height(view, plots, room.y);
    let shown = (room.y - TIME_AXIS_HEIGHT - readout).max(LEAST_HEIGHT);
    let each = height_of_one(plots, shown);
    let columns = ((room.x - VALUE_AXIS_WIDTH - LABEL_ROOM - RIGHT_ROOM).max(16.0) * ui.pixels_per_point()) as usize;
    let frame = ui.ctx().cumulative_frame_nr();
    for (row, plot) in plots.iter().enumerate() {
        for (column, trace) in plot.traces.iter().enumerate() {
            cache.prepare((id, row, column), trace, view.range(), columns, frame);
        }
    }
    let (drawn, range) = (&cache.drawn, view.range());
    let (mut hovered_s, mut wanted) = (None, None);
    let mut changed: Option<(usize, Values)> = None;
    let margin = egui::Margin { left: LABEL_ROOM as i8, right: RIGHT_ROOM as i8, ..Default::default() };
    let mut show = |ui: &mut Ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for (row, plot) in plots.iter().enumerate() {
            let hidden: Vec<bool> = plot.traces.iter().map(|trace| cache.is_hidden(id, trace.name)).collect();
            let look = |column: usize| drawn.get(&(id, row, column)).filter(|_| !hidden[column]);
            let is_shared = shared.is_some() && plot.traces.len() > 1;
            let names = if is_shared { Legend::Values } else { Legend::measure(plot) };
            let values = cache.chosen_values(id, row, plot);
            // Rounded down together: the first ones end where the room does.
            let height = (each * plot.height).floor();
            let shown = draw_plot(ui, (id.with(row), height, names), plot, (&look, values), range, spans);
            let frame = *shown.transform.frame();
            let bounds = shown.transform.bounds();
            let area = Area { frame, values: (bounds.min()[1], bounds.max()[1]) };
            readout::describe(&shown.response, plot, view, &look);
            out.frames.push(frame);
            out.values.push(area.values);
            if !ui.is_rect_visible(frame) {
                continue;
            }
            out.zoomed = values.is_some();
            let (here_s, moved) = interact(ui, &shown.response, area, view, &mut out);
            if here_s.is_some() {
                hovered_s = here_s;
                out.hovered_plot = Some(row);
            }
            let axis = value_axis(ui, id.with((row, "value axis")), VALUE_AXIS_WIDTH, area);
            changed = moved.or(axis).map(|values| (row, values)).or(changed);
            let entry = draw_cursors(ui, (frame, range), view, (plot, names), (&look, id.with((row, "legend"))));
            named = entry.or(named.take());
            let mut more = |ui: &mut Ui, time_s: f64| menu(ui, time_s, row);
            if let Some((of, form)) = plot_menu(&shown.response, frame, view, (plots.len(), &mut more)) {
                wanted = Some((row, of, form));
            }
        }
    };
    let spacing = std::mem::take(&mut ui.spacing_mut().item_spacing.y);
    let scroll = egui::ScrollArea::vertical()
        .id_salt(id.with("scroll"))
        .auto_shrink([false, true])
        .max_height(shown)
        .show(ui, |ui| egui::Frame::new().inner_margin(margin).show(ui, &mut show));
    out.visible = Some(scroll.inner_rect);
    foot(ui, id, view, out.frames.first(), range);
    ui.spacing_mut().item_spacing.y = spacing;
    if readout > 0.0 {
        readout::show(ui, id, view, cache, plots);
    }
    if hovered_s.is_some() {
        view.cursor_s = hovered_s;
    }
    out.hovered_s = hovered_s;
    if let Some((row, of, form)) = wanted {
        let figure = stack_figure(id, (&*cache, plots, spans), range, &out.frames);
        out.figure = Some(FigureRequest { figure: of.part(figure, row), form });
    }
    cache.drawn.retain(|(owner, ..), drawn| *owner != id || drawn.frame == frame);
    keep_looks(cache, id, plots, changed, named);
    out
}

/// Height of a plot of height one in a stack that is given `shown` points. What does not fit scrolls; no plot is shown in part at first.
fn height_of_one(plots: &[TimePlot<'_>], shown: f32) -> f32 {
    let parts: f32 = plots.iter().map(|plot| plot.height).sum();
    let whole = |parts: &f32| parts * LEAST_HEIGHT <= shown;
    let first = plots.iter().scan(0.0, |sum, plot| Some(std::mem::replace(sum, *sum + plot.height) + plot.height));
    let fitting = if whole(&parts) { parts } else { first.take_while(whole).last().unwrap_or(plots[0].height) };
    shown / fitting
}

/// The names all plots have in common in a line above them; the one that was clicked, and whether twice.
fn shared_legend(ui: &mut Ui, id: Id, plot: &TimePlot<'_>, cache: &PlotCache) -> Option<(String, bool)> {
    let mut named = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(10.0, 0.0);
        ui.spacing_mut().interact_size.y = LEGEND_HEIGHT;
        ui.add_space(VALUE_AXIS_WIDTH + LABEL_ROOM);
        for trace in &plot.traces {
            let look = (trace.color, cache.is_hidden(id, trace.name));
            let entry = legend_entry(ui, trace.name, look, trace.legend());
            named = clicked(&entry, trace.name).or(named.take());
        }
    });
    named
}

/// The time axis below a stack, with the time under the cursor.
fn foot(ui: &mut Ui, id: Id, view: &mut TimeView, first: Option<&Rect>, range: TimeRange) {
    let (axis, _) = ui.allocate_exact_size(vec2(ui.available_width(), TIME_AXIS_HEIGHT), egui::Sense::hover());
    let Some(first) = first else { return };
    let axis = Rect::from_x_y_ranges(first.x_range(), axis.y_range());
    draw_time_axis(ui, axis, range, TICK_SPACING[0]);
    time_axis(ui, id.with("time axis"), axis, view);
    if let Some(time_s) = view.cursor_s.filter(|time_s| range.contains(*time_s)) {
        draw_cursor_time(ui, axis, range, time_s);
    }
}

/// Keeps what was done to the values of a plot, given by its row, and to a name of the legend.
fn keep_looks(
    cache: &mut PlotCache,
    id: Id,
    plots: &[TimePlot<'_>],
    changed: Option<(usize, Values)>,
    named: Option<(String, bool)>,
) {
    match changed {
        Some((row, Values::Range(low, high))) if high - low > f64::EPSILON * low.abs().max(high.abs()) => {
            cache.choose_values(id, row, &plots[row], (low, high));
        }
        Some((_, Values::Fit)) => cache.fit_values(id),
        _ => {}
    }
    let Some((name, solo)) = named else { return };
    let beside = plots.iter().find(|plot| plot.traces.len() > 1 && plot.traces.iter().any(|trace| trace.name == name));
    match beside.filter(|_| solo) {
        Some(plot) => cache.solo(id, &name, plot.traces.iter().map(|trace| trace.name)),
        None => cache.toggle(id, &name),
    }
}

/// The name of a legend entry that was clicked, and whether twice.
fn clicked(entry: &egui::Response, name: &str) -> Option<(String, bool)> {
    (entry.clicked() || entry.double_clicked()).then(|| (name.to_owned(), entry.double_clicked()))
}

/// What is drawn of each curve of a plot.
type Look<'l, 'a> = &'l dyn Fn(usize) -> Option<&'a Drawn>;

/// Draws one plot of the stack, without cursors.
fn draw_plot<'a>(
    ui: &mut Ui,
    (id, height, legend): (Id, f32, Legend),
    plot: &'a TimePlot<'a>,
    (look, values): (Look<'_, 'a>, Option<(f64, f64)>),
    range: TimeRange,
    spans: &'a [SpanMark],
) -> egui_plot::PlotResponse<()> {
    let palette = theme::palette(ui);
    let mut drawn: Vec<(&Trace<'a>, &'a Drawn)> =
        plot.traces.iter().enumerate().filter_map(|(column, trace)| Some((trace, look(column)?))).collect();
    // A line over the dots it is fitted to.
    drawn.sort_by_key(|(trace, _)| trace.style != TraceStyle::Dots);
    let has_dots = drawn.iter().any(|(trace, _)| trace.style == TraceStyle::Dots);
    let (low, high) = value_range(plot, drawn.iter().map(|(_, drawn)| *drawn));
    // Names and data do not cover each other where there is height for both.
    let head = if legend == Legend::Names && height >= 2.6 * LEGEND_ROOM { LEGEND_ROOM } else { 0.0 };
    let (low, high) = values.unwrap_or((low, low + (high - low) * f64::from(height / (height - head))));
    let label = plot.axis_label();
    let points_per_s = f64::from(ui.available_width() - VALUE_AXIS_WIDTH) / range.length_s();
    let text = ui.visuals().weak_text_color();
    let chart = Plot::new(id)
        .height(height)
        .show_axes([false, true])
        .custom_y_axes(vec![
            egui_plot::AxisHints::new_y()
                .label(notation::typeset(&label, 10.5))
                .min_thickness(VALUE_AXIS_WIDTH)
                .label_spacing(LABELS)
                .tick_label_color(text)
                .formatter(|mark, _| tick(mark.value, mark.step_size)),
        ])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .show_x(false)
        .show_y(false)
        .grid_color(palette.grid)
        .grid_spacing(egui::Rangef::new(8.0, 16.0))
        .x_grid_spacer(|input| ticks(input, TICK_SPACING[0]))
        .y_grid_spacer(|input| inner_ticks(input, TICK_SPACING[1]))
        .label_formatter(|_| None);
    chart.show(ui, |chart| {
        chart.set_plot_bounds_x(range.start_s..=range.end_s);
        chart.set_plot_bounds_y(low..=high);
        for span in spans {
            let strength = if span.selected { 0.14 } else { 0.09 };
            let edges = if span.selected { 0.8 } else { 0.3 };
            chart.span(
                egui_plot::Span::new("", span.part.start_s..=span.part.end_s)
                    .fill(span.color.gamma_multiply(strength))
                    .border(Stroke::new(1.0, span.color.gamma_multiply(edges))),
            );
        }
        for &level in &plot.levels {
            let line = egui_plot::HLine::new("", level).color(palette.ignored);
            chart.hline(line.style(LineStyle::dashed_dense()).width(1.0).allow_hover(false));
        }
        for (trace, drawn) in drawn {
            draw_trace(chart, trace, drawn, (points_per_s, has_dots));
        }
    })
}

/// Distance between ticks from which their labels are drawn, and drawn fully: all of ours are.
const LABELS: egui::Rangef = egui::Rangef { min: 8.0, max: 12.0 };

/// Screen position of `time_s` in a frame that shows `range`.
pub fn x_at(frame: Rect, range: TimeRange, time_s: f64) -> f32 {
    frame.left() + (f64::from(frame.width()) * (time_s - range.start_s) / range.length_s()) as f32
}

/// Time at the screen position `x` of a frame that shows `range`, s.
pub fn time_at(frame: Rect, range: TimeRange, x: f32) -> f64 {
    range.start_s + range.length_s() * f64::from((x - frame.left()) / frame.width())
}

/// What the legend inside a plot says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Legend {
    /// Names, and values under the cursor.
    Names,
    /// Values under the cursor only: the names stand elsewhere.
    Values,
}

impl Legend {
    /// A single trace is named by the axis where that says the same.
    fn measure(plot: &TimePlot<'_>) -> Self {
        match plot.traces.as_slice() {
            [trace] if trace.name == plot.label || plot.label.starts_with(&format!("{} ", trace.name)) => Self::Values,
            _ => Self::Names,
        }
    }
}

/// The first plot of several traces where all such plots have the same ones, so that one line above them names those of all.
fn shared_names<'p, 'a>(plots: &'p [TimePlot<'a>]) -> Option<&'p TimePlot<'a>> {
    let mut several = plots.iter().filter(|plot| plot.traces.len() > 1);
    let first = several.next()?;
    let same = |plot: &&TimePlot<'_>| {
        let pairs = plot.traces.iter().zip(&first.traces);
        plot.traces.len() == first.traces.len()
            && pairs.into_iter().all(|(a, b)| a.name == b.name && a.color == b.color)
    };
    let rest = several.clone().count();
    (rest > 0 && several.filter(same).count() == rest).then_some(first)
}

fn draw_cursor_time(ui: &Ui, axis: Rect, range: TimeRange, time_s: f64) {
    let palette = theme::palette(ui);
    let ink = ui.visuals().strong_text_color();
    let text = format!("{time_s:.2} s");
    let galley = ui.painter().layout_no_wrap(text, egui::FontId::proportional(11.0), ink);
    let half = 0.5 * galley.size().x + 4.0;
    let middle = x_at(axis, range, time_s).clamp(axis.left() + half, (axis.right() - half).max(axis.left() + half));
    let ground = Rect::from_center_size(pos2(middle, axis.top() + 10.0), galley.size() + vec2(8.0, 2.0));
    ui.painter().rect_filled(ground, CornerRadius::same(3), palette.grid);
    ui.painter().galley(ground.min + vec2(4.0, 1.0), galley, ink);
}

/// Cursor, markers and the legend with values under the cursor (or at marker A, with the difference to B); the name in it that was
/// clicked, and whether twice.
fn draw_cursors<'a>(
    ui: &Ui,
    (frame, range): (Rect, TimeRange),
    view: &TimeView,
    (plot, legend): (&TimePlot<'_>, Legend),
    (look, id): (&dyn Fn(usize) -> Option<&'a Drawn>, Id),
) -> Option<(String, bool)> {
    let palette = theme::palette(ui);
    let painter = ui.painter().with_clip_rect(frame);
    let upright = |time_s: f64, stroke: Stroke| {
        let x = x_at(frame, range, time_s);
        painter.vline(x, frame.y_range(), stroke);
        x
    };
    if let Some(time_s) = view.cursor_s {
        upright(time_s, Stroke::new(1.0, palette.cursor.gamma_multiply(0.55)));
    }
    let small = egui::TextStyle::Small.resolve(ui.style());
    for ((name, color), marker) in ["A", "B"].into_iter().zip(palette.markers).zip(view.markers_s) {
        if let Some(time_s) = marker {
            let x = upright(time_s, Stroke::new(1.2, color));
            painter.text(pos2(x + 3.0, frame.bottom() - 2.0), Align2::LEFT_BOTTOM, name, small.clone(), color);
        }
    }
    let [first_left, mut top] = [frame.left() + 6.0, frame.top() + 4.0];
    let mut left = first_left;
    let mut named = None;
    for (column, trace) in plot.traces.iter().enumerate() {
        let points_per_s = f64::from(frame.width()) / range.length_s();
        let value = |time_s: Option<f64>| value_of(trace, look(column)?.pyramid.gap_s(), time_s?, points_per_s);
        let [a, b] = view.markers_s.map(value);
        let name = if legend == Legend::Names { trace.name } else { "" };
        let unit = if plot.unit.is_empty() { String::new() } else { format!(" {}", plot.unit) };
        let gap = if name.is_empty() { "" } else { "  " };
        let text = match (value(view.cursor_s), a.zip(b)) {
            (Some(value), _) => format!("{name}{gap}{}{unit}", with_band(trace, value, view.cursor_s)),
            (None, Some((a, b))) => format!("{name}{gap}Δ {}{unit}", readable(b - a)),
            (None, None) if name.is_empty() => continue,
            (None, None) => name.to_owned(),
        };
        let is_hidden = look(column).is_none();
        let ink = if is_hidden { ui.visuals().weak_text_color() } else { ui.visuals().text_color() };
        let color = if is_hidden { trace.color.gamma_multiply(0.3) } else { trace.color };
        let galley = painter.layout_job(notation::typeset(&text, 11.0));
        // The value of the only curve of a plot needs no line to tell it from others.
        let line = if name.is_empty() && plot.traces.len() == 1 { 0.0 } else { 15.0 };
        let size = galley.size() + vec2(7.0 + line, 4.0);
        // What the plot is too narrow for goes below.
        if left > first_left && left + size.x > frame.right() {
            (left, top) = (first_left, top + size.y + 1.0);
        }
        let ground = Rect::from_min_size(pos2(left, top), size);
        painter.rect_filled(ground, CornerRadius::same(3), palette.plot_background.gamma_multiply(0.8));
        let y = ground.center().y;
        if line > 0.0 {
            legend_mark(&painter, (left + 4.0, y), color, trace.legend());
        }
        painter.galley(pos2(left + 4.0 + line, top + 2.0), galley, ink);
        left += size.x + 6.0;
        if !name.is_empty() {
            let entry = ui.interact(ground.intersect(frame), id.with(column), egui::Sense::click());
            entry.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("legend {name}")));
            let entry = entry.on_hover_cursor(egui::CursorIcon::PointingHand);
            named = clicked(&entry, name).or(named.take());
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_bounds_are_never_empty_and_hold_everything() {
        assert_eq!(value_bounds(std::iter::empty()), (-1.0, 1.0));
        let (low, high) = value_bounds([(3.0, 3.0)].into_iter());
        assert!(low < 3.0 && high > 3.0);
        let (low, high) = value_bounds([(0.0, 1.0), (-2.0, 0.5)].into_iter());
        assert!(low < -2.0 && high > 1.0 && low > -2.5 && high < 1.5);
    }

    #[test]
    fn what_is_seen_of_a_long_stack_ends_with_a_whole_plot() {
        let plot = |height| TimePlot::new("", "", Vec::new()).high(height);
        let fits: Vec<TimePlot<'_>> = (0..3).flat_map(|_| [plot(1.0), plot(0.6)]).collect();
        for shown in [285.0, 300.0, 420.0, 1000.0] {
            let each = height_of_one(&fits, shown);
            assert!(each >= LEAST_HEIGHT, "{each} in {shown}");
            let ends = fits.iter().scan(0.0, |end, plot| {
                *end += each * plot.height;
                Some(*end)
            });
            assert!(ends.clone().any(|end| (end - shown).abs() < 1e-3), "{:?} in {shown}", ends.collect::<Vec<_>>());
        }
    }

    #[test]
    fn screen_and_time_are_inverse_to_each_other() {
        let frame = Rect::from_min_size(pos2(70.0, 0.0), vec2(500.0, 100.0));
        let range = TimeRange::new(100.0, 200.0);
        assert_eq!(x_at(frame, range, 150.0), 320.0);
        assert!((time_at(frame, range, 320.0) - 150.0).abs() < 1e-9);
    }
}
