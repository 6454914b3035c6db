//! Sensors of the controls, pulleys, pod and fuel probes: calibrations of the instruments file, and fits to ground readings with
//! residuals.

use std::collections::BTreeMap;

use doublet_engine::calibrate::{self, CalibrationFit, Curve, SensorCalibration, SensorKind};
use eframe::egui::{self, Align, Label, Layout, RichText, ScrollArea, TextEdit, Ui, vec2};

use crate::command::{FileCommand, UiCommand, ViewCommand};
use crate::panels::{Pane, Panel, PanelContext, caption, empty, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::{notation, theme};

/// Instruments that are offered where a flight names none.
const EXAMPLE: &str = "builtin:c337f_instruments";
/// Width of the readings, points.
const READINGS: f32 = 176.0;
/// Part of the height that the curve has above its residuals.
const CURVE: f32 = 0.62;

/// An instruments file as read, by its name.
type Read = (String, Result<(String, Vec<SensorCalibration>), String>);

/// Readings as typed, and the degree of the polynomial chosen.
#[derive(Clone, Debug, Default)]
struct Typed {
    text: String,
    degree: Option<usize>,
}

#[derive(Default)]
pub struct Sensors {
    read: Option<Read>,
    chosen: usize,
    typed: BTreeMap<SensorKind, Typed>,
}

impl Panel for Sensors {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let flight = ctx.selection().flight.as_deref().and_then(|name| ctx.session.flight(name));
        let Some(flight) = flight else { return empty(ui, "The session has no flight.") };
        let file = flight.instruments.as_ref().map(|setting| setting.file.as_str()).filter(|file| !file.is_empty());
        let named = file.unwrap_or(EXAMPLE).to_owned();
        if self.read.as_ref().is_none_or(|(name, _)| *name != named) {
            let text = calibrate::read(ctx.folder, &named);
            let read = text.and_then(|text| calibrate::calibrations(&text).map(|all| (text, all)));
            self.read = Some((named.clone(), read));
        }
        let (text, all) = match &self.read {
            Some((_, Ok(read))) => read.clone(),
            Some((_, Err(line))) => return trouble(ui, Some(line)),
            None => return,
        };
        self.header(ctx, ui, (&named, file.is_some()), &text);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
            for (at, calibration) in all.iter().enumerate() {
                ui.selectable_value(&mut self.chosen, at, calibration.kind.title());
            }
        });
        let Some(calibration) = all.get(self.chosen.min(all.len().saturating_sub(1))) else {
            return empty(ui, "The instruments file has no calibration.");
        };
        let size = ui.available_size();
        ui.horizontal_top(|ui| {
            let down = Layout::top_down(Align::LEFT);
            let readings = ui.allocate_ui_with_layout(vec2(READINGS, size.y), down, |ui| {
                ui.set_width(READINGS);
                self.readings(ui, calibration)
            });
            let fit = readings.inner;
            ui.add_space(6.0);
            ui.vertical(|ui| {
                charts(ctx, ui, calibration, fit.as_ref().and_then(|fit| fit.as_ref().ok()), size.y - 8.0)
            });
        });
    }
}

impl Sensors {
    /// Which file it is, and what can be done with what was fitted.
    fn header(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, (named, is_used): (&str, bool), text: &str) {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(named).strong());
            if !is_used {
                ui.weak("example: the flight has no instruments file");
            }
            let changed = self.with_fits(text);
            let hint = "Save all calibrations to an instruments file and use it for this flight";
            let save = ui.add_enabled(matches!(changed, Some(Ok(_))), egui::Button::new("Save instruments as…"));
            if save.on_hover_text(hint).on_disabled_hover_text("No calibration yet: type or paste readings").clicked() {
                ctx.state.instruments = changed.clone().and_then(Result::ok);
                ctx.commands.push(UiCommand::File(FileCommand::SaveInstruments));
            }
            if ui.button("Clocks").on_hover_text("Clocks and their residuals are fitted in Preprocess").clicked() {
                ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Preprocess)));
            }
            if let Some(Err(line)) = changed {
                trouble(ui, Some(&line));
            }
        });
    }

    /// The instruments file with everything that was fitted; `None` where nothing was.
    fn with_fits(&self, text: &str) -> Option<Result<String, String>> {
        let mut now: Option<Result<String, String>> = None;
        for kind in self.typed.keys() {
            let Some(Ok(fit)) = self.fit(kind) else { continue };
            let before = match now {
                Some(Ok(before)) => before,
                Some(Err(line)) => return Some(Err(line)),
                None => text.to_owned(),
            };
            now = Some(calibrate::with_calibration(&before, kind, &fit));
        }
        now
    }

    /// What the readings of a sensor give; `None` without any.
    fn fit(&self, kind: &SensorKind) -> Option<Result<CalibrationFit, String>> {
        let typed = self.typed.get(kind)?;
        let usual = kind.degrees().map_or(1, |[_, usual, _]| usual);
        match calibrate::points(&typed.text) {
            Ok(points) if points.is_empty() => None,
            Ok(points) => Some(calibrate::fit(kind, typed.degree.unwrap_or(usual), &points)),
            Err(line) => Some(Err(line)),
        }
    }

    /// Readings as they are typed or pasted, and what they give.
    fn readings(&mut self, ui: &mut Ui, calibration: &SensorCalibration) -> Option<Result<CalibrationFit, String>> {
        let kind = &calibration.kind;
        let [across, up] = kind.labels();
        let typed = self.typed.entry(kind.clone()).or_default();
        caption(ui, "Readings on the ground");
        ui.add(Label::new(RichText::new(format!("{across}, {up}: a pair on each line")).size(11.0).weak()).wrap());
        let height = (0.42 * ui.available_height()).max(80.0);
        ScrollArea::vertical().id_salt("readings").max_height(height).show(ui, |ui| {
            let field = TextEdit::multiline(&mut typed.text).desired_rows(8).desired_width(READINGS - 14.0);
            let field = ui.add(field.font(theme::figures(ui)).hint_text("type or paste"));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("readings of the sensor"));
        });
        if let Some([least, usual, most]) = kind.degrees() {
            let mut degree = typed.degree.unwrap_or(usual);
            ui.horizontal(|ui| {
                ui.label("degree");
                ui.add(egui::DragValue::new(&mut degree).range(least..=most).speed(0.05));
            });
            typed.degree = Some(degree);
        }
        let fit = self.fit(kind);
        match &fit {
            Some(Ok(fit)) => fitted(ui, kind, fit),
            Some(Err(line)) => {
                let color = theme::palette(ui).error;
                ui.add(Label::new(RichText::new(line).color(color)).wrap());
            }
            None => {
                ui.add(Label::new(RichText::new("Curve of the file. Readings give a new fit.").weak()).wrap());
            }
        }
        in_file(ui, calibration);
        fit
    }
}

/// A line of a name and a value.
fn line(ui: &mut Ui, text: String) {
    ui.add(Label::new(RichText::new(text).font(theme::figures(ui)).size(11.0)).wrap());
}

/// Numbers of a curve, each with its standard error.
fn fitted(ui: &mut Ui, kind: &SensorKind, fit: &CalibrationFit) {
    caption(ui, "Fitted");
    if let Some((radius, error)) = fit.drum_radius_mm(kind) {
        line(ui, format!("radius {} ± {} mm", notation::fixed(radius, 3), notation::fixed(error, 3)));
    } else if let Curve::Polynomial(all) | Curve::Exponential(all) = &fit.curve {
        for (power, value) in all.iter().enumerate() {
            let error = fit.errors.get(power).map_or(String::new(), |error| format!(" ± {}", notation::number(*error)));
            line(ui, format!("a{power} {}{error}", notation::number(*value)));
        }
    }
    let left_out = fit.used.iter().filter(|used| !**used).count();
    line(ui, format!("R² {}", notation::fixed(fit.r_squared, 5)));
    line(ui, format!("residual {} rms", notation::number(fit.deviation)));
    if let SensorKind::Pedal(_) | SensorKind::Pod(_) = kind {
        let [low, high] = fit.range.map(notation::number);
        line(ui, format!("monotonic from {low} to {high}"));
    }
    if left_out > 0 {
        line(ui, format!("{left_out} left out: reading not increasing"));
    }
}

/// What the instruments file has.
fn in_file(ui: &mut Ui, calibration: &SensorCalibration) {
    caption(ui, "In the file");
    match calibration.drum_radius_mm() {
        Some(radius) => line(ui, format!("radius {} mm", notation::fixed(radius, 3))),
        None => line(ui, calibration.curve.summary()),
    }
    if let Some([low, high]) = calibration.range {
        line(ui, format!("used {} to {}", notation::number(low), notation::number(high)));
    }
}

/// Readings with both curves, and the residuals below.
fn charts(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    calibration: &SensorCalibration,
    fit: Option<&CalibrationFit>,
    height: f32,
) {
    let palette = theme::palette(ui);
    let kind = &calibration.kind;
    let [across, up] = kind.labels();
    let range = shown(calibration, fit);
    let mut chart = Chart::new("calibration", across, up);
    let file = calibration.curve.points(range);
    chart.curves.push(ChartCurve::new("file", palette.ignored, ChartStyle::Dashed, file));
    if let Some(fit) = fit {
        chart.curves.push(ChartCurve::new("fitted", palette.series[0], ChartStyle::Line, fit.curve.points(range)));
        let points_where_used = |counts: bool| {
            fit.points.iter().zip(&fit.used).filter(|(_, used)| **used == counts).map(|(at, _)| *at).collect::<Vec<_>>()
        };
        chart.curves.push(ChartCurve::new("read", palette.series[1], ChartStyle::Dots(3.0), points_where_used(true)));
        if fit.used.contains(&false) {
            chart.curves.push(ChartCurve::new(
                "left out",
                palette.error,
                ChartStyle::Dots(3.5),
                points_where_used(false),
            ));
        }
    }
    let share = if fit.is_some() { CURVE } else { 1.0 };
    ctx.chart(ui, &chart, share * height);
    let Some(fit) = fit else { return };
    let label = if matches!(kind, SensorKind::Probe(_)) { "shown minus actual [lb]" } else { "reading minus curve" };
    let mut chart = Chart::new("calibration residuals", across, label);
    chart.legend = false;
    chart.levels.push((0.0, palette.ignored));
    let residuals = fit.points.iter().zip(&fit.residuals).map(|([x, _], residual)| [*x, *residual]).collect();
    chart.curves.push(ChartCurve::new("residual", palette.series[1], ChartStyle::Dots(3.0), residuals));
    ctx.chart(ui, &chart, (1.0 - CURVE) * height);
}

/// Readings between which the curves are drawn.
fn shown(calibration: &SensorCalibration, fit: Option<&CalibrationFit>) -> [f64; 2] {
    let usual = match &calibration.kind {
        SensorKind::Drum => [0.0, 1800.0],
        SensorKind::Aileron => [-90.0, 90.0],
        SensorKind::Elevator => [-12.0, 12.0],
        _ => [0.0, 100.0],
    };
    let of_fit = fit.and_then(|fit| Some([fit.points.first()?[0], fit.points.last()?[0]]));
    let [low, high] = of_fit.or(calibration.range).unwrap_or(usual);
    if low < high { [low, high] } else { usual }
}
