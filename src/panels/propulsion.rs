//! Engines over the whole flight: modelled power beside that of the engine monitor, thrust, and how the two powers agree.

use std::sync::Arc;

use doublet_core::quantity::Dimension;
use doublet_engine::stage::{EngineOverFlight, FlightEngines};
use eframe::egui::{self, RichText, Ui};

use super::{Panel, PanelContext, View, empty, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace, TraceStyle};

/// The panel.
#[derive(Default)]
pub struct Propulsion {
    cache: PlotCache,
}

impl Panel for Propulsion {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = ctx.selection().flight.as_deref().and_then(|flight| ctx.snapshot.engines.get(flight));
        let Some(slot) = slot else { return empty(ui, "There is no flight yet.") };
        trouble(ui, slot.error());
        let stale = slot.is_stale();
        let latest: Option<Arc<FlightEngines>> = slot.latest().cloned();
        let Some(flight) = latest.filter(|flight| !flight.engines.is_empty()) else {
            let text = if stale {
                "The engines are being computed."
            } else {
                "No engine of this flight has its speed and manifold pressure recorded and a model in the aircraft file."
            };
            return empty(ui, text);
        };
        for engine in &flight.engines {
            agreement(ctx, engine, ui);
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
            "r² {}   RMS of the difference {} {unit}   mean {} {unit} modelled, {} {unit} by the engine monitor",
            notation::fixed(whole.r_squared, 4),
            kw(whole.rms_w),
            kw(whole.mean_modelled_w),
            kw(whole.mean_monitor_w),
        );
        ui.add(egui::Label::new(RichText::new(text)).wrap())
            .on_hover_text(format!(
                "Over {} samples where both powers are known. r² is the square of their correlation coefficient (thesis Table 6.12): it \
                 does not see a scale or an offset, the RMS of the difference does.",
                whole.samples
            ));
    });
}
