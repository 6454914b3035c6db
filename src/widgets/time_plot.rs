//! Stacked time plots with one time axis, one cursor and one left margin.

use std::collections::HashMap;
use std::sync::Arc;

use doublet_core::series::Series;
use eframe::egui::{self, Align2, Color32, CornerRadius, Id, Key, PointerButton, Rect, Stroke, Ui, pos2, vec2};
use egui_plot::{FilledArea, Line, LineStyle, Plot, PlotPoint, PlotPoints, Points};

use super::decimate::{Band, Decimated, Pyramid, decimate, decimate_band, value_at};
use super::ticks::{inner_ticks, tick, ticks};
use super::time_view::{Stretch, TimeView};
use crate::theme;

/// Width of the value axis of every plot of a stack, so that their time axes line up.
pub const VALUE_AXIS_WIDTH: f32 = 64.0;
/// Room left of the value axis for the upright label, which is centred on the edge.
const LABEL_ROOM: f32 = 8.0;
/// Room right of the frames for the half of the last time label that lies beyond them.
const RIGHT_ROOM: f32 = 14.0;
/// Height of the time axis below the last plot.
pub const TIME_AXIS_HEIGHT: f32 = 34.0;
/// Least height of one plot; a stack that needs more scrolls.
const LEAST_HEIGHT: f32 = 70.0;
/// Room above and below the data, as a fraction of their extent.
const MARGIN: f64 = 0.08;
/// Part of a band's points that does not count for the value range.
const BAND_LEFT_OUT: f64 = 0.15;
/// Magnification per point of wheel travel.
const WHEEL_GAIN: f64 = 0.004;
/// Samples further apart than this on screen are marked with dots.
const DOT_SPACING: f32 = 7.0;
/// Least distance between ticks of the time axis and of a value axis.
const TICK_SPACING: [f32; 2] = [84.0, 18.0];
/// A reference that swings through more than this many times its range is drawn solid: dashes would fill the plot.
const MOST_SWINGS: f64 = 60.0;
/// A right drag shorter than this zooms nowhere.
const LEAST_BOX: f32 = 4.0;

/// How a trace is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceStyle {
    /// Unbroken line.
    Line,
    /// Dashed line, for references and truth.
    Dashed,
    /// One dot per sample, for measurements under a fit.
    Dots,
}

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
}

impl<'a> TimePlot<'a> {
    /// A plot that fits its values to what is visible.
    pub fn new(label: &'a str, unit: &'a str, traces: Vec<Trace<'a>>) -> Self {
        Self { label, unit, traces, value_range: None, fit_bands: false, levels: Vec::new() }
    }
}

/// A coloured stretch of time behind the traces.
#[derive(Clone, Copy, Debug)]
pub struct SpanMark {
    /// Where.
    pub stretch: Stretch,
    /// Colour, drawn faintly.
    pub color: Color32,
    /// Drawn a little stronger, with edges.
    pub selected: bool,
}

/// What the pointer did in a stack this frame.
#[derive(Clone, Debug, Default)]
pub struct StackResponse {
    /// Time of a plain click, s.
    pub clicked_s: Option<f64>,
    /// Time under the pointer, s.
    pub hovered_s: Option<f64>,
    /// Index of the plot under the pointer.
    pub hovered_plot: Option<usize>,
    /// Where the data area of every plot is on screen, from the left end of the range to its right end.
    pub frames: Vec<Rect>,
}

/// What was drawn for one trace, and for what.
struct Drawn {
    series: Series,
    sigma: Option<Arc<[f64]>>,
    pyramid: Pyramid,
    key: Option<(Stretch, usize, f64)>,
    line: Decimated,
    band: Band,
    band_extent: Option<(f64, f64)>,
    frame: u64,
}

/// Decimated traces kept from frame to frame: nothing is computed again while range, width and samples stay.
#[derive(Default)]
pub struct PlotCache {
    drawn: HashMap<(Id, usize, usize), Drawn>,
    refreshed: usize,
}

impl PlotCache {
    /// How many traces have been decimated since the cache was made.
    pub fn refreshed(&self) -> usize {
        self.refreshed
    }

    /// Brings the trace up to date for `range` and `columns`.
    fn prepare(&mut self, at: (Id, usize, usize), trace: &Trace<'_>, range: Stretch, columns: usize, frame: u64) {
        let Trace { series, sigma, scale, .. } = *trace;
        let fresh = || Drawn {
            series: series.clone(),
            sigma: sigma.cloned(),
            pyramid: Pyramid::new(&series.time_s, &series.values),
            key: None,
            line: Decimated::default(),
            band: Band::default(),
            band_extent: None,
            frame,
        };
        let drawn = self.drawn.entry(at).or_insert_with(fresh);
        if !same(&drawn.series, series) {
            *drawn = fresh();
        }
        if drawn.sigma.as_ref().map(Arc::as_ptr) != sigma.map(Arc::as_ptr) {
            drawn.sigma = sigma.cloned();
            drawn.key = None;
        }
        drawn.frame = frame;
        let key = Some((range, columns, scale));
        if drawn.key == key {
            return;
        }
        drawn.key = key;
        self.refreshed += 1;
        let count = series.time_s.len().min(series.values.len());
        let (time, values) = (&series.time_s[..count], &series.values[..count]);
        let range_s = (range.start_s, range.end_s);
        decimate(&drawn.pyramid, time, values, scale, range_s, columns, &mut drawn.line);
        if let Some(sigma) = sigma.filter(|sigma| sigma.len() == count) {
            decimate_band((time, values, sigma), scale, 2.0, range_s, columns / 2, &mut drawn.band);
            drawn.band_extent = usual_extent(&drawn.band);
        }
    }
}

/// Edges of a band without its widest parts, such as the uncertainty a filter starts from: they may leave the plot.
fn usual_extent(band: &Band) -> Option<(f64, f64)> {
    let edge = |values: &[f64], part: f64| {
        let mut values = values.to_vec();
        let at = (part * values.len().checked_sub(1)? as f64).round() as usize;
        Some(*values.select_nth_unstable_by(at, f64::total_cmp).1)
    };
    edge(&band.low, BAND_LEFT_OUT).zip(edge(&band.high, 1.0 - BAND_LEFT_OUT))
}

/// Whether both hold the very same samples.
fn same(a: &Series, b: &Series) -> bool {
    Arc::ptr_eq(&a.time_s, &b.time_s) && Arc::ptr_eq(&a.values, &b.values)
}

/// Value range that shows `extents` with some room, never empty.
pub fn value_bounds(extents: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (low, high) = extents.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e.0), high.max(e.1)));
    if low > high {
        return (-1.0, 1.0);
    }
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-3);
    let room = (MARGIN * (high - low)).max(least);
    (low - room, high + room)
}

/// `value` with about five significant digits, without a needless exponent.
pub fn readable(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (4 - size.log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.decimals$}")
}

/// Shows `plots` under one another over the range of `view` and lets the pointer move it: wheel zooms about the
/// pointer, Shift and wheel or a drag pans, a right drag zooms to a box of time, a double click shows everything,
/// Shift and click sets marker A, Ctrl and click marker B, the arrow keys step the markers by a sample.
pub fn time_stack(
    ui: &mut Ui,
    id: Id,
    view: &mut TimeView,
    cache: &mut PlotCache,
    plots: &[TimePlot<'_>],
    spans: &[SpanMark],
) -> StackResponse {
    let mut out = StackResponse::default();
    if plots.is_empty() {
        return out;
    }
    let room = ui.available_size();
    let each = ((room.y - TIME_AXIS_HEIGHT) / plots.len() as f32).max(LEAST_HEIGHT).floor();
    let columns = ((room.x - VALUE_AXIS_WIDTH - LABEL_ROOM - RIGHT_ROOM).max(16.0) * ui.pixels_per_point()) as usize;
    let frame = ui.ctx().cumulative_frame_nr();
    for (row, plot) in plots.iter().enumerate() {
        for (column, trace) in plot.traces.iter().enumerate() {
            cache.prepare((id, row, column), trace, view.range(), columns, frame);
        }
    }
    let (drawn, range) = (&cache.drawn, view.range());
    let mut hovered_s = None;
    let margin = egui::Margin { left: LABEL_ROOM as i8, right: RIGHT_ROOM as i8, ..Default::default() };
    let mut show = |ui: &mut Ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for (row, plot) in plots.iter().enumerate() {
            let last = row + 1 == plots.len();
            let height = if last { each + TIME_AXIS_HEIGHT } else { each };
            let look = |column: usize| drawn.get(&(id, row, column));
            let shown = draw_plot(ui, id.with(row), (height, last), plot, &look, range, spans);
            let frame = *shown.transform.frame();
            out.frames.push(frame);
            draw_cursors(ui, (frame, range), view, plot, &look);
            if let Some(time_s) = interact(ui, &shown.response, frame, view, &mut out) {
                hovered_s = Some(time_s);
                out.hovered_plot = Some(row);
            }
        }
    };
    egui::ScrollArea::vertical()
        .id_salt(id.with("scroll"))
        .auto_shrink(false)
        .show(ui, |ui| egui::Frame::new().inner_margin(margin).show(ui, &mut show));
    if hovered_s.is_some() {
        view.cursor_s = hovered_s;
    }
    out.hovered_s = hovered_s;
    cache.drawn.retain(|(owner, ..), drawn| *owner != id || drawn.frame == frame);
    out
}

/// Draws one plot of the stack, without cursors.
fn draw_plot<'a>(
    ui: &mut Ui,
    id: Id,
    (height, last): (f32, bool),
    plot: &'a TimePlot<'a>,
    look: &dyn Fn(usize) -> Option<&'a Drawn>,
    range: Stretch,
    spans: &'a [SpanMark],
) -> egui_plot::PlotResponse<()> {
    let palette = theme::palette(ui);
    let drawn: Vec<(&Trace<'a>, &'a Drawn)> =
        plot.traces.iter().enumerate().filter_map(|(column, trace)| Some((trace, look(column)?))).collect();
    let extents = drawn.iter().flat_map(|(_, drawn)| {
        let band = drawn.band_extent.map(|(low, high)| {
            let room = if plot.fit_bands { 0.5 * (high - low) } else { 0.0 };
            (low - room, high + room)
        });
        drawn.line.extent.filter(|_| !plot.fit_bands).into_iter().chain(band)
    });
    let (low, high) = plot.value_range.unwrap_or_else(|| value_bounds(extents));
    let label = match (plot.label, plot.unit) {
        (label, "") => label.to_owned(),
        ("", unit) => format!("[{unit}]"),
        (label, unit) => format!("{label} [{unit}]"),
    };
    let points_per_s = f64::from(ui.available_width() - VALUE_AXIS_WIDTH) / range.length_s();
    let text = ui.visuals().weak_text_color();
    let mut chart = Plot::new(id)
        .height(height)
        .show_axes([last, true])
        .custom_y_axes(vec![
            egui_plot::AxisHints::new_y()
                .label(egui::RichText::new(label).size(11.5))
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
    if last {
        chart = chart.custom_x_axes(vec![
            egui_plot::AxisHints::new_x()
                .label(egui::RichText::new("time [s]").size(11.5))
                .min_thickness(TIME_AXIS_HEIGHT)
                .label_spacing(LABELS)
                .tick_label_color(text)
                .formatter(|mark, _| tick(mark.value, mark.step_size)),
        ]);
    }
    chart.show(ui, |chart| {
        chart.set_plot_bounds_x(range.start_s..=range.end_s);
        chart.set_plot_bounds_y(low..=high);
        for span in spans {
            let strength = if span.selected { 0.14 } else { 0.09 };
            let edges = if span.selected { 0.8 } else { 0.3 };
            chart.span(
                egui_plot::Span::new("", span.stretch.start_s..=span.stretch.end_s)
                    .fill(span.color.gamma_multiply(strength))
                    .border(Stroke::new(1.0, span.color.gamma_multiply(edges))),
            );
        }
        for &level in &plot.levels {
            let line = egui_plot::HLine::new("", level).color(palette.ignored);
            chart.hline(line.style(LineStyle::dashed_dense()).width(1.0).allow_hover(false));
        }
        for (trace, drawn) in drawn {
            draw_trace(chart, trace, drawn, points_per_s);
        }
    })
}

/// Draws band, lines and dots of one trace.
fn draw_trace<'a>(chart: &mut egui_plot::PlotUi<'a>, trace: &Trace<'_>, drawn: &'a Drawn, points_per_s: f64) {
    let color = if trace.stale { trace.color.gamma_multiply(0.35) } else { trace.color };
    for segment in &drawn.band.segments {
        let (time, low, high) = (&drawn.band.time_s, &drawn.band.low, &drawn.band.high);
        let at = segment.clone();
        let area = FilledArea::new("", &time[at.clone()], &low[at.clone()], &high[at]);
        chart.add(area.fill_color(color.gamma_multiply(0.20)).allow_hover(false));
    }
    for segment in &drawn.line.segments {
        let points: &'a [PlotPoint] = &drawn.line.points[segment.clone()];
        let spacing = points.last().zip(points.first()).map_or(0.0, |(last, first)| (last.x - first.x) * points_per_s);
        let sparse = spacing >= f64::from(DOT_SPACING) * points.len() as f64;
        if trace.style == TraceStyle::Dots || points.len() == 1 || sparse {
            let radius = if sparse { 1.8 } else { 1.2 };
            let dots = Points::new("", PlotPoints::Borrowed(points)).color(color).radius(radius);
            chart.points(dots.allow_hover(false));
        }
        if trace.style != TraceStyle::Dots && points.len() > 1 {
            let line = Line::new("", PlotPoints::Borrowed(points)).color(color).width(1.4).allow_hover(false);
            let swings = drawn.line.extent.map_or(0.0, |(low, high)| drawn.line.travel / (high - low).max(1e-300));
            let dashed = trace.style == TraceStyle::Dashed && swings < MOST_SWINGS;
            chart.line(if dashed { line.style(LineStyle::dashed_dense()) } else { line.allow_band(false) });
        }
    }
}

/// Distance between ticks from which their labels are drawn, and drawn fully: all of ours are.
const LABELS: egui::Rangef = egui::Rangef { min: 8.0, max: 12.0 };

/// Screen position of `time_s` in a frame that shows `range`.
pub fn x_at(frame: Rect, range: Stretch, time_s: f64) -> f32 {
    frame.left() + (f64::from(frame.width()) * (time_s - range.start_s) / range.length_s()) as f32
}

/// Time at the screen position `x` of a frame that shows `range`, s.
pub fn time_at(frame: Rect, range: Stretch, x: f32) -> f64 {
    range.start_s + range.length_s() * f64::from((x - frame.left()) / frame.width())
}

/// Cursor, markers and the legend with values under the cursor (or at marker A, with the difference to B).
fn draw_cursors<'a>(
    ui: &Ui,
    (frame, range): (Rect, Stretch),
    view: &TimeView,
    plot: &TimePlot<'_>,
    look: &dyn Fn(usize) -> Option<&'a Drawn>,
) {
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
    let font = egui::FontId::proportional(11.0);
    let mut left = frame.left() + 6.0;
    let top = frame.top() + 4.0;
    for (column, trace) in plot.traces.iter().enumerate() {
        let value = |time_s: Option<f64>| {
            let gap_s = look(column)?.pyramid.gap_s();
            value_at(&trace.series.time_s, &trace.series.values, gap_s, time_s?).map(|v| v * trace.scale)
        };
        let [a, b] = view.markers_s.map(value);
        let text = match (value(view.cursor_s), a.zip(b)) {
            (Some(value), _) => format!("{}  {}", trace.name, readable(value)),
            (None, Some((a, b))) => format!("{}  Δ {}", trace.name, readable(b - a)),
            (None, None) => trace.name.to_owned(),
        };
        let galley = painter.layout_no_wrap(text, font.clone(), ui.visuals().text_color());
        let size = galley.size() + vec2(22.0, 4.0);
        let ground = Rect::from_min_size(pos2(left, top), size);
        painter.rect_filled(ground, CornerRadius::same(3), palette.plot_background.gamma_multiply(0.8));
        let y = ground.center().y;
        painter.hline(left + 4.0..=left + 15.0, y, Stroke::new(2.0, trace.color));
        painter.galley(pos2(left + 19.0, top + 2.0), galley, ui.visuals().text_color());
        left += size.x + 6.0;
    }
}

/// Lets the pointer over one plot move the view; the time under the pointer.
fn interact(
    ui: &Ui,
    response: &egui::Response,
    frame: Rect,
    view: &mut TimeView,
    out: &mut StackResponse,
) -> Option<f64> {
    let range = view.range();
    let s_per_point = range.length_s() / f64::from(frame.width());
    let (now_s, modifiers) = ui.input(|i| (i.time, i.modifiers));
    if response.dragged_by(PointerButton::Primary) {
        ui.set_cursor_icon(egui::CursorIcon::Grabbing);
        let by = f64::from(response.drag_delta().x);
        if by != 0.0 {
            view.pan(-by * s_per_point, now_s);
        }
    }
    box_zoom(ui, response, frame, view);
    let pointer = response.hover_pos().filter(|at| frame.contains(*at))?;
    let here_s = time_at(frame, range, pointer.x);
    let (wheel, pinch) = ui.input_mut(|i| (std::mem::take(&mut i.smooth_scroll_delta), i.zoom_delta()));
    let along = if modifiers.shift { wheel.x + wheel.y } else { wheel.x };
    if along != 0.0 {
        view.pan(-f64::from(along) * s_per_point, now_s);
    } else if wheel.y != 0.0 {
        view.zoom((WHEEL_GAIN * f64::from(wheel.y)).exp(), here_s, now_s);
    }
    if pinch != 1.0 {
        view.zoom(f64::from(pinch), here_s, now_s);
    }
    if response.double_clicked() {
        view.home();
    } else if response.clicked() {
        match (modifiers.shift, modifiers.command) {
            (true, _) => view.markers_s[0] = Some(here_s),
            (_, true) => view.markers_s[1] = Some(here_s),
            _ => out.clicked_s = Some(here_s),
        }
    }
    Some(here_s)
}

/// A drag with the secondary button zooms to the stretch it covers.
fn box_zoom(ui: &Ui, response: &egui::Response, frame: Rect, view: &mut TimeView) {
    let dragged = response.dragged_by(PointerButton::Secondary);
    let stopped = response.drag_stopped_by(PointerButton::Secondary);
    if !dragged && !stopped {
        return;
    }
    let id = response.id.with("box");
    let Some(at) = response.interact_pointer_pos() else { return };
    let pressed = ui.input(|i| i.pointer.press_origin()).unwrap_or(at);
    let origin = ui.data_mut(|data| *data.get_temp_mut_or_insert_with(id, || pressed));
    let rect = Rect::from_x_y_ranges(origin.x.min(at.x)..=origin.x.max(at.x), frame.y_range()).intersect(frame);
    if stopped {
        ui.data_mut(|data| data.remove::<egui::Pos2>(id));
        if rect.width() > LEAST_BOX {
            let edge = |x: f32| time_at(frame, view.range(), x);
            view.zoom_to(Stretch::new(edge(rect.left()), edge(rect.right())));
        }
        return;
    }
    let accent = theme::palette(ui).accent;
    ui.painter().rect_filled(rect, 0.0, accent.gamma_multiply(0.2));
    ui.painter().rect_stroke(rect, 0.0, Stroke::new(1.0, accent), egui::StrokeKind::Inside);
}

/// Moves marker A with the arrow keys (with Shift: B) to the next or previous sample of `time_s`.
pub fn step_markers(ui: &Ui, view: &mut TimeView, time_s: &[f64]) {
    let (left, right, shift) =
        ui.input(|i| (i.key_pressed(Key::ArrowLeft), i.key_pressed(Key::ArrowRight), i.modifiers.shift));
    if left == right {
        return;
    }
    if let Some(marker) = &mut view.markers_s[usize::from(shift)] {
        let next = if right {
            time_s.get(time_s.partition_point(|t| t <= marker))
        } else {
            time_s.partition_point(|t| t < marker).checked_sub(1).map(|at| &time_s[at])
        };
        *marker = next.copied().unwrap_or(*marker);
    }
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
    fn numbers_read_with_five_digits() {
        assert_eq!(readable(0.0), "0");
        assert_eq!(readable(12.345678), "12.346");
        assert_eq!(readable(-0.001234567), "-0.0012346");
        assert_eq!(readable(1.5e-7), "1.500e-7");
        assert_eq!(readable(123_456.0), "123456");
    }

    #[test]
    fn screen_and_time_are_inverse_to_each_other() {
        let frame = Rect::from_min_size(pos2(70.0, 0.0), vec2(500.0, 100.0));
        let range = Stretch::new(100.0, 200.0);
        assert_eq!(x_at(frame, range, 150.0), 320.0);
        assert!((time_at(frame, range, 320.0) - 150.0).abs() < 1e-9);
    }
}
