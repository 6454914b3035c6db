//! Engines over the whole flight: modelled power compared with the engine monitor, thrust, the flight on the engine chart and on the
//! propeller map, and the effect of each engine input.

use std::sync::Arc;

use doublet_core::quantity::Dimension;
use doublet_engine::stage::{EngineOverFlight, FlightEngines};
use eframe::egui::{self, RichText, Ui};

use crate::panels::aircraft::propeller::{self, Partials};
use crate::panels::{Panel, PanelContext, View, choices, empty, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace, TraceStyle};
use crate::{notation, theme};

/// Points of a flight that a chart shows at most.
const MOST_POINTS: usize = 1500;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Time,
    Powers,
    Chart,
    Propeller,
    Partials,
}

#[derive(Default)]
pub struct Propulsion {
    aspect: Aspect,
    partials: Partials,
    cache: PlotCache,
}

impl Panel for Propulsion {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = ctx.selection().flight.as_deref().and_then(|flight| ctx.snapshot.engines.get(flight));
        let Some(slot) = slot else { return empty(ui, "No flight yet.") };
        trouble(ui, slot.error());
        let stale = slot.is_stale();
        let latest: Option<Arc<FlightEngines>> = slot.latest().cloned();
        let Some(flight) = latest.filter(|flight| !flight.engines.is_empty()) else {
            let text = if stale {
                "Computing engines…"
            } else {
                "No engine has recorded speed and manifold pressure and a model in the aircraft file."
            };
            return empty(ui, text);
        };
        let all = [
            (Aspect::Time, "Over time"),
            (Aspect::Powers, "Power by power"),
            (Aspect::Chart, "Engine chart"),
            (Aspect::Propeller, "Propeller map"),
            (Aspect::Partials, "Partial derivatives"),
        ];
        choices(ui, &mut self.aspect, &all);
        if matches!(self.aspect, Aspect::Time | Aspect::Powers | Aspect::Chart) {
            flight.engines.iter().for_each(|engine| agreement(ctx, engine, ui));
        }
        match self.aspect {
            Aspect::Time => {}
            Aspect::Powers => return charts(ctx, ui, &flight, powers),
            Aspect::Chart => return charts(ctx, ui, &flight, engine_chart),
            Aspect::Propeller => return propeller::maps(ctx, ui, &flight),
            Aspect::Partials => return self.partials.show(ctx, ui, &flight),
        }
        let colors = theme::palette(ui).series;
        let (power_unit, power_scale) = ctx.unit(Dimension::Power);
        let (force_unit, force_scale) = ctx.unit(Dimension::Force);
        let labels: Vec<_> =
            flight.engines.iter().map(|e| [format!("P {}", e.name), format!("T {}", e.name)]).collect();
        let mut plots = Vec::new();
        for (engine, [power, thrust]) in flight.engines.iter().zip(&labels) {
            let modelled = Trace { scale: power_scale, stale, ..Trace::new("modelled", &engine.power_w, colors[0]) };
            let monitor = engine.monitor_power_w.as_ref().map(|monitor| Trace {
                scale: power_scale,
                stale,
                style: TraceStyle::Dashed,
                ..Trace::new("monitor", monitor, colors[1])
            });
            plots.push(TimePlot::new(power, power_unit, [modelled].into_iter().chain(monitor).collect()));
            let thrust_n = Trace { scale: force_scale, stale, ..Trace::new("thrust", &engine.thrust_n, colors[2]) };
            plots.push(TimePlot::new(thrust, force_unit, vec![thrust_n]));
        }
        ctx.stack(ui, "propulsion", View::Flight, &mut self.cache, &plots, &[]);
    }
}

/// A chart of each engine beside the other.
fn charts(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    flight: &FlightEngines,
    chart: fn(&PanelContext<'_>, &Ui, &EngineOverFlight) -> Option<Chart>,
) {
    let height = ui.available_height();
    ui.columns(flight.engines.len().max(1), |columns| {
        for (ui, engine) in columns.iter_mut().zip(&flight.engines) {
            match chart(ctx, ui, engine) {
                Some(chart) => ctx.chart(ui, &chart, height),
                None => empty(ui, "Monitor power not recorded."),
            }
        }
    });
}

/// Pairs of two columns of the flight, every so many of them.
pub(crate) fn pairs(across: (&[f64], f64), up: (&[f64], f64)) -> Vec<[f64; 2]> {
    let step = across.0.len().div_ceil(MOST_POINTS).max(1);
    let all = across.0.iter().zip(up.0).step_by(step).map(|(x, y)| [across.1 * x, up.1 * y]);
    all.filter(|pair| pair.iter().all(|value| value.is_finite())).collect()
}

/// Modelled power against that of the monitor, with the line of one to one (thesis Fig. 6.15 and 6.16).
fn powers(ctx: &PanelContext<'_>, ui: &Ui, engine: &EngineOverFlight) -> Option<Chart> {
    let palette = theme::palette(ui);
    let (unit, scale) = ctx.unit(Dimension::Power);
    let monitor = engine.monitor_power_w.as_ref()?;
    let points = pairs((&monitor.values, scale), (&engine.power_w.values, scale));
    let most = points.iter().flatten().copied().fold(0.0, f64::max);
    let name = format!("powers of {}", engine.name);
    let mut chart = Chart::new(&name, format!("by the monitor [{unit}]"), format!("modelled [{unit}]"));
    chart.aspect = Some(1.0);
    chart.curves.push(ChartCurve::new("one to one", palette.ignored, ChartStyle::Dashed, vec![[0.0; 2], [most; 2]]));
    chart.curves.push(ChartCurve::new(&engine.name, palette.series[0], ChartStyle::Dots(1.6), points));
    Some(chart)
}

/// Power against manifold pressure: the lines of the chart at sea level, one for each speed, and where the flight was.
fn engine_chart(ctx: &PanelContext<'_>, ui: &Ui, engine: &EngineOverFlight) -> Option<Chart> {
    let palette = theme::palette(ui);
    let (unit, scale) = ctx.unit(Dimension::Power);
    let (pressure, per_pa) = ctx.unit(Dimension::Pressure);
    let aircraft = ctx.snapshot.aircraft.latest()?;
    let of_name = aircraft.powerplant.engines.iter().find(|other| other.station.name == engine.name)?;
    let data = of_name.model.as_ref()?.chart.data();
    let name = format!("engine chart of {}", engine.name);
    let mut chart = Chart::new(&name, format!("manifold pressure [{pressure}]"), format!("power [{unit}]"));
    for (at, (speed, powers)) in data.speed_rad_s.iter().zip(&data.sea_level_power_w).enumerate() {
        let line = pairs((&data.manifold_pressure_pa, per_pa), (powers, scale));
        let rpm = notation::fixed(speed * 60.0 / std::f64::consts::TAU, 0);
        let color = palette.series[at % palette.series.len()];
        chart.curves.push(ChartCurve::new(format!("{rpm} rpm"), color, ChartStyle::Line, line));
    }
    let flown = pairs((&engine.manifold_pressure_pa.values, per_pa), (&engine.power_w.values, scale));
    chart.curves.push(ChartCurve::new("flight", ui.visuals().text_color(), ChartStyle::Dots(1.6), flown));
    Some(chart)
}

/// One line per engine: the two powers over the whole flight.
fn agreement(ctx: &PanelContext<'_>, engine: &EngineOverFlight, ui: &mut Ui) {
    let (unit, scale) = ctx.unit(Dimension::Power);
    ui.horizontal_wrapped(|ui| {
        ui.strong(&engine.name);
        let Some(agreement) = &engine.agreement else {
            ui.weak("its monitor's power is not recorded");
            return;
        };
        let whole = &agreement.whole;
        let kw = |power_w: f64| notation::fixed(scale * power_w, 1);
        let text = format!(
            "r² {}   RMS difference {} {unit}   modelled mean {} {unit} (engine monitor {} {unit})",
            notation::fixed(whole.r_squared, 4),
            kw(whole.rms_w),
            kw(whole.mean_modelled_w),
            kw(whole.mean_monitor_w),
        );
        ui.add(egui::Label::new(RichText::new(text)).wrap())
            .on_hover_text(format!(
                "Over {} samples where both powers are known. r² is the squared correlation (thesis Table 6.12), which ignores scale and offset; the RMS difference includes them.",
                whole.samples
            ));
    });
}
