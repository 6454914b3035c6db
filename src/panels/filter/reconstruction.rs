//! The flight path of the selected manoeuvre: states with standard deviation, measured and reconstructed signals, biases and wind.

use doublet_core::reconstruct::{Measurement, State};
use doublet_core::series::Series;
use doublet_engine::stage::WindowPath;
use eframe::egui::Ui;

use crate::notation::{self, Units};
use crate::panels::overlaid::Overlaid;
use crate::panels::signals::bias_table;
use crate::panels::{Panel, PanelContext, View, awaiting, choices, trouble};
use crate::theme;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace, TraceStyle};

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

#[derive(Default)]
pub struct Reconstruction {
    aspect: Aspect,
    compare: bool,
    cache: PlotCache,
}

impl Panel for Reconstruction {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let by_states = !self.aspect.states().is_empty();
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut self.aspect, &Aspect::ALL);
            if by_states {
                ui.checkbox(&mut self.compare, "compare filters")
                    .on_hover_text("This manoeuvre by extended and iterated extended Kalman filter, and smoothed");
            }
        });
        if self.aspect == Aspect::Table {
            return bias_table::show(ctx, ui);
        }
        let Some(results) = ctx.results() else {
            return awaiting(ctx, ui, "the manoeuvres", "Select a manoeuvre that is in use.");
        };
        trouble(ui, results.path.error());
        let stale = results.path.is_stale();
        let Some(path) = results.path.latest().cloned() else {
            return awaiting(ctx, ui, "the path of this manoeuvre", "This manoeuvre has no flight path.");
        };
        if self.compare && by_states {
            return self.comparison(ctx, ui, &path);
        }
        let others = others(ctx, ui);
        let plots = match self.aspect {
            Aspect::Measured => measured((&path, &others), ui, stale, ctx.state.units),
            aspect => states((&path, &others), aspect.states(), ui, stale, ctx.state.units),
        };
        ctx.stack(ui, "reconstruction", View::Window, &mut self.cache, &plots, &[]);
    }
}

impl Reconstruction {
    /// States by the plain and the iterated filter and smoothed, with truth.
    fn comparison(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, path: &WindowPath) {
        ctx.wanted.filters = true;
        let [plain, iterated] = match ctx.details().and_then(|details| details.filters.as_ref()) {
            Some(Ok(both)) => both,
            Some(Err(error)) => return trouble(ui, Some(&error.to_string())),
            None => return awaiting(ctx, ui, "both filters", "Both filters are running."),
        };
        let colors = theme::palette(ui).series;
        let plots = self.aspect.states().iter().map(|&state| {
            let (unit, scale) = ctx.unit(state.dimension());
            let index = state as usize;
            let mut traces = vec![
                Trace { scale, ..Trace::new("EKF", &plain.series().states[index], colors[0]) },
                Trace { scale, ..Trace::new("IEKF", &iterated.series().states[index], colors[3]) },
            ];
            if let Some(smoothed) = &iterated.series().smoothed {
                traces.push(Trace { scale, ..Trace::new("smoothed", &smoothed.states[index], colors[2]) });
            }
            if let Some(truth) = known(&path.series().truth[index]) {
                traces.push(Trace { scale, style: TraceStyle::Dashed, ..Trace::new("truth", truth, colors[1]) });
            }
            TimePlot::new(notation::state(state), unit, traces)
        });
        let plots: Vec<TimePlot<'_>> = plots.collect();
        ctx.stack(ui, "comparison", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// A truth with anything to draw in the window: what is only named by the recording has no place in a legend.
fn known(truth: &Option<Series>) -> Option<&Series> {
    truth.as_ref().filter(|truth| truth.values.iter().any(|value| value.is_finite()))
}

/// The paths of the chosen manoeuvre by the overlaid experiments.
fn others<'a>(ctx: &PanelContext<'a>, ui: &Ui) -> Vec<(Overlaid<'a>, &'a WindowPath)> {
    let window = ctx.selection().window.clone().unwrap_or_default();
    let path = |other: Overlaid<'a>| {
        let path = other.window(&window)?.path.latest()?;
        Some((other, &**path))
    };
    Overlaid::all(ctx, ui).into_iter().filter_map(path).collect()
}

/// A path with those laid over it.
type Paths<'p, 'a> = (&'a WindowPath, &'p [(Overlaid<'a>, &'a WindowPath)]);

/// Measured under reconstructed.
fn measured<'a>((path, others): Paths<'_, 'a>, ui: &Ui, stale: bool, units: Units) -> Vec<TimePlot<'a>> {
    let palette = theme::palette(ui);
    let present = MEASURED.into_iter().filter(|measurement| !path.missing.contains(measurement));
    let plots = present.map(|measurement| {
        let (unit, scale) = units.for_dimension(measurement.dimension());
        let index = measurement as usize;
        let measured = Trace {
            scale,
            stale,
            style: TraceStyle::Dots,
            ..Trace::new("measured", &path.series().measured[index], palette.series[1])
        };
        let reconstructed = Trace {
            scale,
            stale,
            ..Trace::new("reconstructed", &path.series().reconstructed[index], palette.series[0])
        };
        let outliers = Trace {
            scale,
            stale,
            style: TraceStyle::Crosses,
            ..Trace::new("outlier", &path.series().outliers[index], palette.error)
        };
        let found = Some(outliers).filter(|outliers| !outliers.series.time_s.is_empty());
        let overlaid = others.iter().map(|(other, path)| other.trace(&path.series().reconstructed[index], scale));
        let traces = [measured, reconstructed].into_iter().chain(overlaid).chain(found).collect();
        TimePlot::new(notation::measurement(measurement), unit, traces)
    });
    plots.collect()
}

/// Filtered and smoothed states with truth.
fn states<'a>(
    (path, others): Paths<'_, 'a>,
    states: &[State],
    ui: &Ui,
    stale: bool,
    units: Units,
) -> Vec<TimePlot<'a>> {
    let palette = theme::palette(ui);
    let plots = states.iter().map(|&state| {
        let (unit, scale) = units.for_dimension(state.dimension());
        let index = state as usize;
        let series = path.series();
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
        traces.extend(others.iter().map(|(other, path)| {
            let series = path.series();
            let best = series.smoothed.as_ref().map_or(&series.states, |smoothed| &smoothed.states);
            other.trace(&best[index], scale)
        }));
        if let Some(truth) = known(&series.truth[index]) {
            let style = TraceStyle::Dashed;
            traces.push(Trace { scale, style, ..Trace::new("truth", truth, palette.series[1]) });
        }
        TimePlot::new(notation::state(state), unit, traces)
    });
    plots.collect()
}
