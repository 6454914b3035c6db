//! The propeller's map with the flight on it, and what each input of an engine does to its power, thrust and total-pressure rise.

use doublet_core::propulsion::{EngineOutput, EnginePoint, EngineSensitivities, PointInput, Steps};
use doublet_core::quantity::{Dimension, Role};
use doublet_engine::stage::{EngineOverFlight, FlightEngines, PropellerCurves, engine_partials};
use eframe::egui::{ComboBox, DragValue, Grid, Label, RichText, ScrollArea, Ui};

use crate::panels::aircraft::propulsion::pairs;
use crate::panels::{PanelContext, empty, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::term::{column_title, column_title_called};
use crate::{notation, theme};

/// Height of the numbers below the bars.
const TABLE: f32 = 216.0;
/// Least height of the bars; below it the panel scrolls.
const LEAST_CHART: f32 = 150.0;
/// Change of an input that the bars are drawn for, as a part of it.
const PART: f64 = 0.01;

/// Efficiency and thrust coefficient over the advance ratio, a line for each power coefficient, with the flight on them (thesis
/// Fig. 6.17); engines of one propeller share its charts.
pub fn maps(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &FlightEngines) {
    let mut shared: Vec<(&PropellerCurves, Vec<&EngineOverFlight>)> = Vec::new();
    for engine in &flight.engines {
        match shared.iter_mut().find(|(curves, _)| curves.name == engine.curves.name) {
            Some((_, engines)) => engines.push(engine),
            None => shared.push((&engine.curves, vec![engine])),
        }
    }
    let height = ui.available_height() / shared.len().max(1) as f32;
    for (curves, engines) in shared {
        ui.allocate_ui(eframe::egui::vec2(ui.available_width(), height), |ui| {
            let (rpm, per_rad_s) = ctx.state.units.of_role(Role::EngineSpeed1);
            let (length, per_m) = ctx.unit(Dimension::Length);
            let text = format!(
                "{}: {} {rpm}, {} {length}, the medians of the flight above 40 kt. {}",
                curves.name,
                notation::fixed(per_rad_s * curves.speed_rad_s, 0),
                notation::fixed(per_m * curves.altitude_m, 0),
                curves.origin,
            );
            ui.add(Label::new(RichText::new(text).size(11.5).weak()).wrap());
            let charts = [false, true].map(|is_thrust| map(ui, curves, &engines, is_thrust));
            charts[0].show_legend(ui);
            let height = ui.available_height();
            ui.columns(2, |columns| {
                columns.iter_mut().zip(&charts).for_each(|(ui, chart)| ctx.chart(ui, chart, height));
            });
        });
    }
}

fn map(ui: &Ui, curves: &PropellerCurves, engines: &[&EngineOverFlight], is_thrust: bool) -> Chart {
    let palette = theme::palette(ui);
    let (name, up) =
        if is_thrust { ("thrust coefficient", "thrust coefficient CT") } else { ("efficiency", "efficiency ηp") };
    let mut chart = Chart::new(&format!("{name} of {}", curves.name), "advance ratio J", up);
    chart.legend = false;
    let inks = [ui.visuals().text_color(), palette.ignored];
    for (engine, ink) in engines.iter().zip(inks.into_iter().cycle()) {
        let values = if is_thrust { &engine.thrust_coefficient } else { &engine.efficiency };
        let flown = pairs((&engine.advance_ratio.values, 1.0), (&values.values, 1.0));
        chart.curves.push(ChartCurve::new(engine.name.clone(), ink, ChartStyle::Dots(1.4), flown));
    }
    for (at, line) in curves.lines.iter().enumerate() {
        let color = palette.series[at % palette.series.len()];
        let points = if is_thrust { &line.thrust } else { &line.efficiency };
        let name = format!("CP {}", notation::number(line.power_coefficient));
        chart.curves.push(ChartCurve::new(name, color, ChartStyle::Line, points.clone()));
    }
    chart
}

/// Partial derivatives of an engine at a condition: that of the flight until another is chosen (thesis Tables 7.13-7.14).
#[derive(Default)]
pub struct Partials {
    engine: usize,
    point: Option<EnginePoint>,
}

/// An input with the unit it is shown in: its short name, the name it has for those who cannot see, the unit, the factor from SI.
type Shown = (&'static str, &'static str, &'static str, f64);

/// Inputs in the order of [`PointInput::ALL`].
fn inputs(ctx: &PanelContext<'_>) -> [Shown; 5] {
    let (rpm, per_rad_s) = ctx.state.units.of_role(Role::EngineSpeed1);
    let (pressure, per_pa) = ctx.unit(Dimension::Pressure);
    let (length, per_m) = ctx.unit(Dimension::Length);
    let (speed, per_m_s) = ctx.unit(Dimension::Speed);
    [
        ("N", "engine speed", rpm, per_rad_s),
        ("pz", "manifold pressure", pressure, per_pa),
        ("T at sea level", "temperature at sea level", "K", 1.0),
        ("h", "pressure altitude", length, per_m),
        ("V", "true airspeed", speed, per_m_s),
    ]
}

/// Values of a point in the order of [`PointInput::ALL`].
fn values(point: &mut EnginePoint) -> [&mut f64; 5] {
    [
        &mut point.speed_rad_s,
        &mut point.manifold_pressure_pa,
        &mut point.sea_level_temperature_k,
        &mut point.pressure_altitude_m,
        &mut point.airspeed_m_s,
    ]
}

impl Partials {
    /// Draws the condition to choose, the bars and the numbers.
    pub fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &FlightEngines) {
        let Some(engine) = flight.engines.get(self.engine.min(flight.engines.len().saturating_sub(1))) else { return };
        let mut point = self.point.unwrap_or(engine.typical);
        ui.horizontal_wrapped(|ui| {
            ComboBox::from_id_salt("engine").selected_text(&engine.name).show_ui(ui, |ui| {
                for (at, engine) in flight.engines.iter().enumerate() {
                    ui.selectable_value(&mut self.engine, at, &engine.name);
                }
            });
            for (value, (short, name, unit, scale)) in values(&mut point).into_iter().zip(inputs(ctx)) {
                let mut shown = *value * scale;
                let speed = 0.002 * shown.abs().max(1.0);
                let field = DragValue::new(&mut shown).speed(speed).max_decimals(1);
                let field = ui.add(field.prefix(format!("{short} ")).suffix(format!(" {unit}"))).on_hover_text(name);
                ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("partials at {name}")));
                if field.changed() {
                    *value = shown / scale;
                }
            }
            let flown = ui.add_enabled(self.point.is_some(), eframe::egui::Button::new("As flown"));
            if flown.on_hover_text("The medians of the flight above 40 kt").clicked() {
                point = engine.typical;
            }
        });
        self.point = (point != engine.typical).then_some(point);
        let aircraft = ctx.snapshot.aircraft.latest();
        let engines = aircraft.into_iter().flat_map(|aircraft| &aircraft.powerplant.engines);
        let model = engines.filter(|other| other.station.name == engine.name).find_map(|other| other.model.as_ref());
        let Some(model) = model else { return empty(ui, "This engine has no model.") };
        match engine_partials(model, &point) {
            Ok(found) => {
                let chart = bars(ctx, ui, &engine.name, &mut point, &found);
                let height = (ui.available_height() - TABLE).max(LEAST_CHART);
                ScrollArea::both().auto_shrink(false).show(ui, |ui| {
                    ctx.chart(ui, &chart, height);
                    numbers(ctx, ui, &found);
                });
            }
            Err(error) => trouble(ui, Some(&error.to_string())),
        }
    }
}

/// Outputs in the order of [`EngineOutput::ALL`]: name, unit, factor from SI.
fn outputs(ctx: &PanelContext<'_>) -> [(&'static str, &'static str, f64); 3] {
    let (power, per_w) = ctx.unit(Dimension::Power);
    let (force, per_n) = ctx.unit(Dimension::Force);
    [("power", power, per_w), ("thrust", force, per_n), ("total-pressure rise", "", 1.0)]
}

fn nominal(found: &EngineSensitivities) -> [f64; 3] {
    [found.nominal.power_w, found.nominal.thrust_n, found.nominal.total_pressure_rise]
}

/// Change of every output over one per cent more of every input.
fn bars(ctx: &PanelContext<'_>, ui: &Ui, engine: &str, point: &mut EnginePoint, found: &EngineSensitivities) -> Chart {
    let palette = theme::palette(ui);
    let across = format!("input, increased by {} %", notation::number(100.0 * PART));
    let mut chart = Chart::new(&format!("partial derivatives of {engine}"), across, "change [%]");
    let inputs = inputs(ctx);
    let at = values(point).map(|value| *value);
    for ((output, (name, ..)), nominal) in EngineOutput::ALL.into_iter().zip(outputs(ctx)).zip(nominal(found)) {
        let place = output as usize;
        let bar = |input: PointInput| {
            let change = found.partial(output, input) * PART * at[input as usize] / nominal;
            [input as usize as f64 + 0.26 * (place as f64 - 1.0), 100.0 * change]
        };
        let bars = PointInput::ALL.map(bar).to_vec();
        chart.curves.push(ChartCurve::new(name, palette.series[place], ChartStyle::Bars(0.24), bars));
    }
    chart.places = inputs.iter().enumerate().map(|(at, (name, ..))| (at as f64, (*name).to_owned())).collect();
    chart
}

/// The numbers of the thesis' tables, an input a row: so they fit beside other panels.
fn numbers(ctx: &PanelContext<'_>, ui: &mut Ui, found: &EngineSensitivities) {
    let figures = theme::figures(ui);
    let number = |ui: &mut Ui, value: f64| drop(ui.label(RichText::new(notation::number(value)).font(figures.clone())));
    let uncertainty = found.reading_uncertainty(&Steps::READING_RESOLUTION);
    let rows = outputs(ctx).into_iter().zip(EngineOutput::ALL).zip(nominal(found));
    let rows: Vec<_> = rows.map(|(((name, unit, scale), output), value)| (name, unit, scale, output, value)).collect();
    Grid::new("partials").striped(true).spacing([16.0, 4.0]).show(ui, |ui| {
        column_title(ui, "partial derivative");
        for (name, unit, ..) in &rows {
            ui.label(if unit.is_empty() { (*name).to_owned() } else { format!("{name} [{unit}]") });
        }
        ui.end_row();
        column_title(ui, "at the condition");
        rows.iter().for_each(|(_, _, scale, _, value)| number(ui, scale * value));
        ui.end_row();
        for (input, (short, _, unit, per_si)) in PointInput::ALL.into_iter().zip(inputs(ctx)) {
            column_title_called(ui, &format!("per {unit} of {short}"), "partial derivative");
            rows.iter().for_each(|(_, _, scale, output, _)| number(ui, scale * found.partial(*output, input) / per_si));
            ui.end_row();
        }
        column_title(ui, "one reading off");
        rows.iter().for_each(|(_, _, scale, output, _)| number(ui, scale * uncertainty[*output as usize]));
        ui.end_row();
    });
}
