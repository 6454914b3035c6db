//! Every derivative of a coefficient as a small plot: an interval per experiment.

use doublet_engine::compare::{DerivativeOutcome, ExperimentRow, Interval};
use doublet_engine::notation::significant;
use eframe::egui::{self, Color32, Rect, Sense, Stroke, Ui, pos2, vec2};

use crate::notation;
use crate::theme;

/// Size of a plot without its lines, and height of a line.
const WIDTH: f32 = 196.0;
const HEAD: f32 = 20.0;
const FOOT: f32 = 14.0;
const LINE: f32 = 9.0;
/// Room between a plot and its edges.
const MARGIN: f32 = 6.0;
/// Longest half interval that widens the scale, in median half intervals: one poor experiment does not hide the others.
const LONGEST: f64 = 4.0;
/// Opacity of rows that are not chosen while others are.
const FAINT: f32 = 0.3;

/// A row and how it is drawn.
pub struct Shown<'a> {
    /// Row.
    pub row: &'a ExperimentRow,
    /// Colour.
    pub color: Color32,
    /// Whether others are chosen.
    pub is_faint: bool,
}

/// Draws a plot for every derivative of a coefficient.
pub fn show(ui: &mut Ui, rows: &[Shown<'_>], coefficient: &str) {
    let mut names: Vec<&str> = Vec::new();
    for derivative in rows.iter().flat_map(|shown| derivatives(shown.row, coefficient)) {
        if !names.contains(&derivative.name.as_str()) {
            names.push(&derivative.name);
        }
    }
    ui.horizontal_wrapped(|ui| names.iter().for_each(|name| plot(ui, rows, coefficient, name)));
}

fn derivatives<'a>(row: &'a ExperimentRow, coefficient: &str) -> &'a [DerivativeOutcome] {
    row.outcome.coefficient(coefficient).map(|found| found.derivatives.as_slice()).unwrap_or_default()
}

fn interval(row: &ExperimentRow, coefficient: &str, name: &str) -> Option<Interval> {
    let found = derivatives(row, coefficient).iter().find(|derivative| derivative.name == name)?;
    Some(found.interval).filter(|interval| interval.estimate.is_finite())
}

/// Lower and upper end of the scale.
fn scale(intervals: &[Interval]) -> Option<[f64; 2]> {
    let half = |interval: &Interval| interval.high - interval.estimate;
    let mut halves: Vec<f64> = intervals.iter().map(half).filter(|half| half.is_finite()).collect();
    halves.sort_by(f64::total_cmp);
    let most = LONGEST * halves.get(halves.len() / 2).copied().unwrap_or(0.0);
    let reach = |interval: &Interval| Some(half(interval)).filter(|half| half.is_finite()).map_or(0.0, |h| h.min(most));
    let low = intervals.iter().map(|one| one.estimate - reach(one)).reduce(f64::min)?;
    let high = intervals.iter().map(|one| one.estimate + reach(one)).reduce(f64::max)?;
    let margin = if high > low { 0.0 } else { 0.5 * low.abs().max(f64::MIN_POSITIVE) };
    Some([low - margin, high + margin])
}

fn plot(ui: &mut Ui, rows: &[Shown<'_>], coefficient: &str, name: &str) {
    let height = HEAD + LINE * rows.len() as f32 + FOOT;
    let (rect, response) = ui.allocate_exact_size(vec2(WIDTH, height), Sense::hover());
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    let frame = rect.shrink2(vec2(1.0, 1.0));
    painter.rect(frame, 3.0, palette.plot_background, Stroke::new(1.0, palette.grid), egui::StrokeKind::Inside);
    let intervals: Vec<Option<Interval>> = rows.iter().map(|shown| interval(shown.row, coefficient, name)).collect();
    let known: Vec<Interval> = intervals.iter().flatten().copied().collect();
    let title = ui.painter().layout_job(notation::derivative_job(ui, name));
    painter.galley(frame.left_top() + vec2(MARGIN, 3.0), title, ui.visuals().text_color());
    let label = format!("intervals of {name}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
    let Some([low, high]) = scale(&known) else { return };
    let span = frame.left() + MARGIN..=frame.right() - MARGIN;
    let across = |value: f64| {
        let part = ((value - low) / (high - low)).clamp(0.0, 1.0) as f32;
        span.start() + part * (span.end() - span.start())
    };
    let top = frame.top() + HEAD;
    if low < 0.0 && high > 0.0 {
        let foot = top + LINE * rows.len() as f32;
        painter.vline(across(0.0), top..=foot, Stroke::new(1.0, ui.visuals().weak_text_color()));
    }
    for (index, (shown, interval)) in rows.iter().zip(&intervals).enumerate() {
        let Some(interval) = interval else { continue };
        let y = top + LINE * (index as f32 + 0.5);
        let color = if shown.is_faint { shown.color.gamma_multiply(FAINT) } else { shown.color };
        if interval.low.is_finite() && interval.high.is_finite() {
            painter.hline(across(interval.low)..=across(interval.high), y, Stroke::new(1.5, color));
        }
        painter.circle_filled(pos2(across(interval.estimate), y), 2.6, color);
    }
    ends(ui, frame, [low, high]);
    hover(&response, rows, &intervals, top);
}

/// The ends of the scale below a plot.
fn ends(ui: &Ui, frame: Rect, [low, high]: [f64; 2]) {
    let font = egui::FontId::proportional(9.5);
    let color = ui.visuals().weak_text_color();
    let foot = frame.bottom() - 2.0;
    let places = [
        (pos2(frame.left() + MARGIN, foot), egui::Align2::LEFT_BOTTOM, low),
        (pos2(frame.right() - MARGIN, foot), egui::Align2::RIGHT_BOTTOM, high),
    ];
    for (at, align, value) in places {
        ui.painter().text(at, align, significant(value, 3), font.clone(), color);
    }
}

/// The experiment under the pointer with its value.
fn hover(response: &egui::Response, rows: &[Shown<'_>], intervals: &[Option<Interval>], top: f32) {
    let Some(at) = response.hover_pos() else { return };
    let under = |index: &usize| (top + LINE * *index as f32..top + LINE * (*index as f32 + 1.0)).contains(&at.y);
    let Some(index) = (0..rows.len()).find(under) else { return };
    let value = intervals[index].map_or("not in its structure".to_owned(), |interval| {
        let half = interval.high - interval.estimate;
        format!("{} ± {} (95 %)", significant(interval.estimate, 4), significant(half, 2))
    });
    response.clone().on_hover_text(format!("{}: {value}", rows[index].row.name));
}
