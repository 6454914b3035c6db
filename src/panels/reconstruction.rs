//! The flight path of the chosen window: states with their deviation, measured beside reconstructed, biases and wind.

use doublet_core::reconstruct::{Measurement, State};
use doublet_engine::stage::WindowPath;
use eframe::egui::{self, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use super::{Panel, PanelContext, View, choices, empty, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace, TraceStyle};

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Measured,
    Attitude,
    Velocity,
    Position,
    Biases,
    Wind,
    Table,
}

impl Aspect {
    const ALL: [(Self, &'static str); 7] = [
        (Self::Measured, "Measured"),
        (Self::Attitude, "Attitude"),
        (Self::Velocity, "Velocity"),
        (Self::Position, "Position"),
        (Self::Biases, "Biases"),
        (Self::Wind, "Wind"),
        (Self::Table, "Table"),
    ];

    fn states(self) -> &'static [State] {
        match self {
            Self::Measured | Self::Table => &[],
            Self::Position => &State::ALL[..3],
            Self::Velocity => &State::ALL[3..6],
            Self::Attitude => &State::ALL[6..9],
            Self::Biases => &State::ALL[9..15],
            Self::Wind => &State::ALL[15..],
        }
    }
}

/// Measurements in the order they are looked at.
const MEASURED: [Measurement; 12] = [
    Measurement::Airspeed,
    Measurement::AngleOfAttack,
    Measurement::Sideslip,
    Measurement::BankAngle,
    Measurement::PitchAngle,
    Measurement::HeadingAngle,
    Measurement::VelocityNorth,
    Measurement::VelocityEast,
    Measurement::VelocityDown,
    Measurement::PositionNorth,
    Measurement::PositionEast,
    Measurement::PositionDown,
];

/// The panel.
#[derive(Default)]
pub struct Reconstruction {
    aspect: Aspect,
    cache: PlotCache,
}

impl Panel for Reconstruction {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        choices(ui, &mut self.aspect, &Aspect::ALL);
        if self.aspect == Aspect::Table {
            return table(ctx, ui);
        }
        let Some(results) = ctx.results() else { return empty(ui, "Choose a window that is in use.") };
        trouble(ui, results.path.error());
        let stale = results.path.is_stale();
        let Some(path) = results.path.latest().cloned() else { return };
        let plots = match self.aspect {
            Aspect::Measured => measured(&path, ui, stale),
            aspect => states(&path, aspect.states(), ui, stale),
        };
        ctx.stack(ui, "reconstruction", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// Measured under reconstructed.
fn measured<'a>(path: &'a WindowPath, ui: &Ui, stale: bool) -> Vec<TimePlot<'a>> {
    let palette = theme::palette(ui);
    let present = MEASURED.into_iter().filter(|measurement| !path.missing.contains(measurement));
    let plots = present.map(|measurement| {
        let (unit, scale) = notation::unit(measurement.dimension());
        let index = measurement as usize;
        let measured = Trace {
            scale,
            stale,
            style: TraceStyle::Dots,
            ..Trace::new("measured", &path.series.measured[index], palette.series[1])
        };
        let reconstructed =
            Trace { scale, stale, ..Trace::new("reconstructed", &path.series.reconstructed[index], palette.series[0]) };
        TimePlot::new(notation::measurement(measurement), unit, vec![measured, reconstructed])
    });
    plots.collect()
}

/// Filtered and smoothed states with truth.
fn states<'a>(path: &'a WindowPath, states: &[State], ui: &Ui, stale: bool) -> Vec<TimePlot<'a>> {
    let palette = theme::palette(ui);
    let plots = states.iter().map(|&state| {
        let (unit, scale) = notation::unit(state.dimension());
        let index = state as usize;
        let series = &path.series;
        let mut traces = vec![Trace {
            scale,
            stale,
            sigma: Some(&series.deviations[index]),
            ..Trace::new("filtered ± 2σ", &series.states[index], palette.series[0])
        }];
        if let Some(smoothed) = &series.smoothed {
            let sigma = Some(&smoothed.deviations[index]);
            traces.push(Trace {
                scale,
                stale,
                sigma,
                ..Trace::new("smoothed ± 2σ", &smoothed.states[index], palette.series[2])
            });
        }
        if let Some(truth) = &series.truth[index] {
            let style = TraceStyle::Dashed;
            traces.push(Trace { scale, style, ..Trace::new("truth", truth, palette.series[1]) });
        }
        TimePlot::new(notation::state(state), unit, traces)
    });
    plots.collect()
}

/// Final biases and wind of every window.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let states = &State::ALL[9..];
    let figures = theme::figures(ui);
    egui::ScrollArea::horizontal().show(ui, |ui| {
        TableBuilder::new(ui)
            .id_salt("biases")
            .striped(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::initial(120.0).clip(true).resizable(true))
            .columns(Column::exact(104.0), states.len())
            .header(34.0, |mut header| {
                header.col(|ui| {
                    ui.weak("Window");
                });
                for state in states {
                    header.col(|ui| {
                        let (unit, _) = notation::unit(state.dimension());
                        ui.vertical(|ui| {
                            ui.spacing_mut().item_spacing.y = 0.0;
                            ui.label(notation::state(*state));
                            ui.label(RichText::new(unit).size(10.5).weak());
                        });
                    });
                }
            })
            .body(|mut body| {
                for window in &ctx.session.windows {
                    let path = ctx.snapshot.windows.get(&window.name).and_then(|results| results.path.latest());
                    let Some(path) = path else { continue };
                    body.row(22.0, |mut row| {
                        row.col(|ui| {
                            ui.label(&window.name);
                        });
                        for state in states {
                            let (_, scale) = notation::unit(state.dimension());
                            let last = |column: &[f64]| column.last().map_or(f64::NAN, |value| scale * value);
                            let index = *state as usize;
                            let value = last(&path.series.states[index].values);
                            let deviation = last(&path.series.deviations[index]);
                            row.col(|ui| {
                                let text = format!("{} ± {}", notation::fixed(value, 3), notation::fixed(deviation, 3));
                                ui.label(RichText::new(text).font(figures.clone()).size(11.0));
                            });
                        }
                    });
                }
            });
    });
}
