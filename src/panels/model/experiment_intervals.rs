//! A derivative of all experiments on one axis: an interval in the row of each, with the session as it is as a line.

use doublet_core::model::{Coefficient, Term};
use doublet_engine::compare::{DerivativeOutcome, ExperimentRow, Interval, PRESENT};
use doublet_engine::notation::significant;
use doublet_engine::session::Session;
use eframe::egui::{self, Color32, Sense, Stroke, Ui, pos2};

use crate::widgets::speak_value;
use crate::{notation, theme};

/// Room between an interval and the edges of its cell.
const MARGIN: f32 = 5.0;
/// Longest half interval that widens the scale, in median half intervals: one poor experiment does not hide the others.
const LONGEST: f64 = 4.0;

/// A derivative with the scale of all its intervals.
pub struct Axis<'a> {
    /// Name of the derivative.
    pub name: &'a str,
    coefficient: &'a str,
    unit: String,
    scale: [f64; 2],
    /// Estimate of the session as it is.
    present: Option<f64>,
}

impl<'a> Axis<'a> {
    /// An axis for every derivative of a coefficient that some row has, in the order in which they come.
    pub fn all(session: &Session, rows: &[&'a ExperimentRow], coefficient: &'a str) -> Vec<Self> {
        let mut names: Vec<&str> = Vec::new();
        for derivative in rows.iter().copied().flat_map(|row| derivatives(row, coefficient)) {
            if !names.contains(&derivative.name.as_str()) {
                names.push(&derivative.name);
            }
        }
        let present = rows.iter().find(|row| row.name == PRESENT);
        let axis = |name: &'a str| {
            let known: Vec<Interval> = rows.iter().filter_map(|row| interval(row, coefficient, name)).collect();
            let present = present.and_then(|row| interval(row, coefficient, name)).map(|one| one.estimate);
            Some(Self { name, coefficient, unit: unit(session, coefficient, name), scale: scale(&known)?, present })
        };
        names.into_iter().filter_map(axis).collect()
    }

    /// Both ends of the scale, with the unit.
    pub fn describe(&self) -> String {
        let [low, high] = self.scale.map(|end| significant(end, 3));
        format!("{}: axis from {low} to {high}{}", self.name, self.unit)
    }

    /// Draws the interval of a row into a cell.
    pub fn show(&self, ui: &mut Ui, row: Option<&ExperimentRow>, (name, color): (&str, Color32)) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
        let label = format!("{} of {name}", self.name);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
        let Some(interval) = row.and_then(|row| interval(row, self.coefficient, self.name)) else {
            speak_value(&response, "not in its structure".to_owned());
            response.on_hover_text(format!("{label}: not in its structure"));
            return;
        };
        let [low, high] = self.scale;
        let across = |value: f64| {
            let part = ((value - low) / (high - low)).clamp(0.0, 1.0) as f32;
            egui::lerp(rect.left() + MARGIN..=rect.right() - MARGIN, part)
        };
        let painter = ui.painter_at(rect);
        if low < 0.0 && high > 0.0 {
            painter.vline(across(0.0), rect.y_range(), Stroke::new(1.0, theme::palette(ui).grid));
        }
        if let Some(present) = self.present {
            painter.vline(across(present), rect.y_range(), Stroke::new(1.0, ui.visuals().weak_text_color()));
        }
        let y = rect.center().y;
        if interval.low.is_finite() && interval.high.is_finite() {
            painter.hline(across(interval.low)..=across(interval.high), y, Stroke::new(1.5, color));
        }
        painter.circle_filled(pos2(across(interval.estimate), y), 2.8, color);
        let half = interval.high - interval.estimate;
        let value = format!("{} ± {}{} (95 %)", significant(interval.estimate, 4), significant(half, 2), self.unit);
        let ends = format!("{} to {}", significant(interval.low, 4), significant(interval.high, 4));
        speak_value(&response, format!("{value}, {ends}"));
        response.on_hover_text(format!("{label}: {value}, {ends}"));
    }
}

fn derivatives<'a>(row: &'a ExperimentRow, coefficient: &str) -> &'a [DerivativeOutcome] {
    row.outcome.coefficient(coefficient).map(|found| found.derivatives.as_slice()).unwrap_or_default()
}

/// The interval of a derivative in a row.
pub fn interval(row: &ExperimentRow, coefficient: &str, name: &str) -> Option<Interval> {
    let found = derivatives(row, coefficient).iter().find(|derivative| derivative.name == name)?;
    Some(found.interval).filter(|interval| interval.estimate.is_finite())
}

/// The unit of a derivative, behind a space, by the term of the session or of an experiment.
fn unit(session: &Session, coefficient: &str, name: &str) -> String {
    let Some(coefficient) = Coefficient::from_name(coefficient) else {
        return String::new();
    };
    let kept = session.experiments.iter().map(|experiment| &experiment.configuration.structure);
    let terms = [&session.structure].into_iter().chain(kept).filter_map(|structure| structure.terms(coefficient));
    let is_its = |term: &&Term| term.derivative_name(coefficient) == name;
    let unit = terms.flatten().find(is_its).map(notation::derivative_unit).unwrap_or_default();
    if unit.is_empty() { unit } else { format!(" {unit}") }
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
