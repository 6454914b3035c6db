//! The menu of a plot's curves: spectrum, spectrogram and derivative of what is on screen, scatter over another curve.

use doublet_core::series::Series;
use doublet_engine::trace::TraceView;
use eframe::egui::{ScrollArea, Ui};

use crate::notation;
use crate::panels::PanelContext;
use crate::ui_state::TraceRequest;
use crate::widgets::time_plot::{TimePlot, Trace};
use crate::widgets::time_view::TimeRange;

/// A curve by its names, to be drawn over.
struct Other {
    name: String,
    unit: String,
    scale: f64,
    series: Series,
}

/// Draws the entries for the curves of a plot; what is asked for of the part `range`.
pub fn show(
    ctx: &PanelContext<'_>,
    ui: &mut Ui,
    (plots, row): (&[TimePlot<'_>], usize),
    range: TimeRange,
) -> Option<TraceRequest> {
    let plot = plots.get(row)?;
    let curves: Vec<&Trace<'_>> = plot.traces.iter().filter(|trace| trace.series.time_s.len() > 1).collect();
    let mut asked = None;
    let request = |trace: &Trace<'_>, view, over: Option<Other>| TraceRequest {
        name: name(plot, trace),
        unit: plot.unit.to_owned(),
        scale: trace.scale,
        series: trace.series.clone(),
        range,
        view,
        over: over.map(|other| (other.name, other.unit, other.scale)),
    };
    ui.menu_button("Analyse", |ui| {
        let several = curves.len() > 1;
        for trace in &curves {
            let mut entries = |ui: &mut Ui| {
                for (text, view) in [
                    ("Spectrum of the visible span", TraceView::Spectrum),
                    ("Spectrogram", TraceView::Spectrogram),
                    ("Derivative", TraceView::Derivative),
                ] {
                    if ui.button(text).clicked() {
                        asked = Some(request(trace, view, None));
                        ui.close();
                    }
                }
                ui.menu_button("Scatter against", |ui| {
                    ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
                        for other in others(ctx, plots, trace) {
                            if ui.button(notation::typeset(&other.name, 13.0)).clicked() {
                                let view = TraceView::Scatter(other.series.clone());
                                asked = Some(request(trace, view, Some(other)));
                                ui.close();
                            }
                        }
                    });
                });
            };
            if several {
                ui.menu_button(notation::typeset(trace.name, 13.0), entries);
            } else {
                entries(ui);
            }
        }
    });
    asked
}

/// Name of a curve: that of its plot, and its own where that says more.
fn name(plot: &TimePlot<'_>, trace: &Trace<'_>) -> String {
    match (plot.label, trace.name) {
        ("", name) => name.to_owned(),
        (label, name) if label == name || plot.traces.len() == 1 && label.starts_with(name) => label.to_owned(),
        (label, name) => format!("{label}, {name}"),
    }
}

/// The other curves of the stack, then the channels of the chosen flight that have a role.
fn others(ctx: &PanelContext<'_>, plots: &[TimePlot<'_>], own: &Trace<'_>) -> Vec<Other> {
    let beside = plots.iter().flat_map(|plot| plot.traces.iter().map(move |trace| (plot, trace)));
    let beside = beside.filter(|(_, trace)| !std::sync::Arc::ptr_eq(&trace.series.values, &own.series.values));
    let mut all: Vec<Other> = beside
        .map(|(plot, trace)| Other {
            name: name(plot, trace),
            unit: plot.unit.to_owned(),
            scale: trace.scale,
            series: trace.series.clone(),
        })
        .collect();
    let flight = ctx.selection().flight.as_deref().and_then(|name| ctx.snapshot.flights.get(name)?.latest());
    for (role, index) in flight.iter().flat_map(|loaded| &loaded.recording.roles) {
        let Some(channel) = flight.and_then(|loaded| loaded.recording.channels.get(*index)) else { continue };
        let (unit, scale) = ctx.state.units.of_role(*role);
        let name = format!("{} (recorded)", notation::role(*role));
        all.push(Other { name, unit: unit.to_owned(), scale, series: channel.series.clone() });
    }
    all
}
