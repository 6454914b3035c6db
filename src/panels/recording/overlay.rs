//! Several windows over each other, aligned at their onset: any channels as measured, coefficients with the model.

use std::any::Any;
use std::sync::Arc;

use doublet_core::model::Coefficient;
use doublet_core::quantity::Role;
use doublet_core::series::Series;
use doublet_engine::session::{Manoeuvre, Surface};
use eframe::egui::{ScrollArea, Ui};

use crate::panels::manoeuvres::proposals::roles;
use crate::panels::marking::{self, OfFlight, Spot};
use crate::panels::{PanelContext, empty};
use crate::widgets::hatch::hatch;
use crate::widgets::named_id;
use crate::widgets::time_plot::{Marked, PlotCache, StackResponse, TimePlot, Trace, TraceStyle, time_stack_with};
use crate::widgets::time_view::{TimeRange, TimeView};
use crate::{notation, theme};

/// Windows drawn at most: more are not told apart.
const MOST: usize = 8;

/// What a lane shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Signal {
    Channel(Role),
    Coefficient(Coefficient),
}

/// What the curves were made from: a change of any makes them anew.
struct Made {
    windows: Vec<(Manoeuvre, f64)>,
    signals: Vec<Signal>,
    /// Recordings, coefficients and estimates. They are held, so that nothing new can lie where one of them was.
    sources: Vec<Arc<dyn Any + Send + Sync>>,
}

impl Made {
    fn collect(ctx: &PanelContext<'_>, windows: &[&Manoeuvre], signals: &[Signal]) -> Self {
        let mut sources: Vec<Arc<dyn Any + Send + Sync>> = Vec::new();
        for window in windows {
            let loaded = ctx.snapshot.flights.get(&window.flight).and_then(|slot| slot.latest());
            sources.extend(loaded.map(|loaded| Arc::clone(loaded) as _));
            let aero = ctx.snapshot.windows.get(&window.name).and_then(|results| results.aero.latest());
            sources.extend(aero.map(|aero| Arc::clone(aero) as _));
        }
        sources.extend(ctx.snapshot.pooled.latest().map(|pooled| Arc::clone(pooled) as _));
        let windows = windows.iter().map(|window| ((*window).clone(), onset(ctx, window))).collect();
        Self { windows, signals: signals.to_vec(), sources }
    }

    fn is(&self, other: &Self) -> bool {
        let same = |(one, other): (&Arc<dyn Any + Send + Sync>, &Arc<dyn Any + Send + Sync>)| {
            std::ptr::addr_eq(Arc::as_ptr(one), Arc::as_ptr(other))
        };
        (&self.windows, &self.signals) == (&other.windows, &other.signals)
            && self.sources.len() == other.sources.len()
            && self.sources.iter().zip(&other.sources).all(same)
    }
}

/// The curves of a lane, window by window: measured, model.
type Lane = Vec<[Series; 2]>;

/// Lanes, and what is drawn in them.
#[derive(Default)]
pub struct Overlay {
    chosen: Option<Vec<Signal>>,
    made: Option<Made>,
    lanes: Vec<Lane>,
    names: Vec<String>,
    cache: PlotCache,
    view: TimeView,
}

impl Overlay {
    /// Draws the selected windows, or all of `shown` where one alone is selected.
    pub fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, shown: &[&Manoeuvre]) {
        let selection = ctx.selection().clone();
        let selected: Vec<&Manoeuvre> = selection.windows(ctx.session).collect();
        let compared = if selected.len() > 1 { selected.as_slice() } else { shown };
        let drawn = &compared[..compared.len().min(MOST)];
        let Some(first) = drawn.first() else { return empty(ui, "Manoeuvre not found.") };
        let signals = self.chosen.clone().unwrap_or_else(|| usual(first.surface));
        ui.horizontal_wrapped(|ui| {
            self.choose(ctx, ui, first, &signals);
            let more =
                if compared.len() > MOST { format!(", the first {MOST} of {}", compared.len()) } else { String::new() };
            ui.weak(format!("{} manoeuvres from onset{more}; dashed: model", drawn.len()));
            let excluded = drawn.iter().filter(|window| !window.excluded.is_empty());
            let names: Vec<&str> = excluded.map(|window| window.name.as_str()).collect();
            if !names.is_empty() {
                ui.weak(format!("Hatched: excluded in {}", names.join(", ")));
            }
        });
        self.make(ctx, drawn, &signals);
        let units = ctx.state.units;
        let labels: Vec<String> = signals.iter().map(|signal| label(*signal)).collect();
        let colors = theme::palette(ui).series;
        let mut plots = Vec::new();
        for ((signal, label), lane) in signals.iter().zip(&labels).zip(&self.lanes) {
            let (unit, scale) = match signal {
                Signal::Channel(role) => units.of_role(*role),
                Signal::Coefficient(_) => ("", 1.0),
            };
            let mut traces = Vec::with_capacity(2 * lane.len());
            for (at, [measured, model]) in lane.iter().enumerate() {
                let color = colors[at % colors.len()];
                traces.push(Trace { scale, ..Trace::new(&self.names[2 * at], measured, color) });
                let dashed = Trace::new(&self.names[2 * at + 1], model, color);
                traces.push(Trace { scale, style: TraceStyle::Dashed, ..dashed });
            }
            plots.push(TimePlot::new(label, unit, traces));
        }
        // What is marked is marked of the chosen manoeuvre, whose time this is then.
        let chosen = ctx.window().filter(|chosen| drawn.iter().any(|window| window.name == chosen.name));
        let target = chosen.unwrap_or(first);
        let onset_s = onset(ctx, target);
        let (session, table) = (ctx.session, ctx.table);
        let before_s = self.view.markers_s;
        let markers_s = before_s.map(|marker_s| marker_s.map(|time_s| time_s + onset_s));
        let mut asked = None;
        let mut menu = |ui: &mut Ui, time_s: f64, _row: usize| {
            let time_s = Some(time_s + onset_s);
            let spot =
                Spot { session, table, window: session.window(&target.name), candidate: None, time_s, markers_s };
            asked = marking::menu(ui, &spot).map(|command| (spot, command)).or(asked);
            ui.separator();
        };
        let id = named_id(ui.ctx(), "overlay");
        let response = time_stack_with(ui, id, &mut self.view, &mut self.cache, &plots, &[], &mut menu);
        if let Some((spot, command)) = asked {
            ctx.follow_menu(&spot, command);
            ctx.state.time.markers_s = markers_s;
        }
        self.hatch_excluded(ctx, ui, drawn, &response);
        self.mark(ctx, ui, (target, onset_s), &response);
        if chosen.is_some() {
            // Keys act where the pointer is in the time of the chosen one.
            if let Some(time_s) = response.hovered_s {
                *ctx.hovered_s = Some(time_s + onset_s);
            }
            if self.view.markers_s != before_s {
                ctx.state.time.markers_s = self.view.markers_s.map(|marker_s| marker_s.map(|time_s| time_s + onset_s));
            }
        }
        self.view.cursor_s = response.hovered_s;
        self.view.annotate_s = None;
        ctx.figures.extend(response.figure);
    }

    /// Draws a drag that marks, and carries it out on a manoeuvre with this onset where it ends.
    fn mark(
        &self,
        ctx: &mut PanelContext<'_>,
        ui: &Ui,
        (target, onset_s): (&Manoeuvre, f64),
        response: &StackResponse,
    ) {
        let Some(drag) = response.marked else { return };
        let part = TimeRange::new(drag.part.start_s + onset_s, drag.part.end_s + onset_s);
        let marked = Marked { from_s: drag.from_s + onset_s, part, ..drag };
        let of = OfFlight { session: ctx.session, snapshot: ctx.snapshot, flight: &target.flight };
        let window = Some(target).filter(|target| target.window.contains(marked.from_s));
        let frames = marking::frames_on_screen(ui, &response.frames, response);
        let words = of.meaning(ui, window, marked);
        marking::draw_marked(ui, (&frames, self.view.range()), drag.part, &words, marking::BELOW_LEGEND);
        if let Some(edit) = of.carry_out(ctx.state, window, marked) {
            ctx.edit(edit);
        }
    }

    /// Hatches the excluded parts of the manoeuvres drawn.
    fn hatch_excluded(&self, ctx: &PanelContext<'_>, ui: &Ui, drawn: &[&Manoeuvre], response: &StackResponse) {
        let frames = marking::frames_on_screen(ui, &response.frames, response);
        for window in drawn.iter().filter(|window| !window.excluded.is_empty()) {
            let onset_s = onset(ctx, window);
            for part in &window.excluded {
                let part = TimeRange::new(part.start_s - onset_s, part.end_s - onset_s);
                frames.iter().for_each(|frame| hatch(ui, marking::over(*frame, self.view.range(), part)));
            }
        }
    }

    /// The menu of lanes.
    fn choose(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, first: &Manoeuvre, signals: &[Signal]) {
        let loaded = ctx.snapshot.flights.get(&first.flight).and_then(|slot| slot.latest());
        let channels = Role::ALL.iter().filter(|role| loaded.is_some_and(|of| of.recording.role(**role).is_some()));
        let modelled = ctx.session.structure.models.iter().map(|(coefficient, _)| Signal::Coefficient(*coefficient));
        let all: Vec<Signal> = modelled.chain(channels.map(|role| Signal::Channel(*role))).collect();
        ui.menu_button("Signals", |ui| {
            ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
                for signal in all {
                    let mut on = signals.contains(&signal);
                    if ui.checkbox(&mut on, label(signal)).changed() {
                        let mut next = signals.to_vec();
                        next.retain(|other| *other != signal);
                        next.extend(on.then_some(signal));
                        self.chosen = (!next.is_empty()).then_some(next);
                    }
                }
            });
        });
    }

    /// Cuts the curves and moves their onsets to zero, where anything they are made from has changed.
    fn make(&mut self, ctx: &PanelContext<'_>, windows: &[&Manoeuvre], signals: &[Signal]) {
        let made = Made::collect(ctx, windows, signals);
        if self.made.as_ref().is_some_and(|before| before.is(&made)) {
            return;
        }
        let names = windows.iter().map(|window| &window.name);
        self.names = names.flat_map(|name| [name.clone(), format!("{name}, model")]).collect();
        self.lanes =
            signals.iter().map(|signal| windows.iter().map(|window| aligned(ctx, window, *signal)).collect()).collect();
        let ends = windows.iter().map(|window| {
            let onset_s = onset(ctx, window);
            (window.window.start_s - onset_s, window.window.end_s - onset_s)
        });
        let (start_s, end_s) =
            ends.fold((0.0, 1.0), |(low, high): (f64, f64), ends| (low.min(ends.0), high.max(ends.1)));
        self.view.set_full(TimeRange::new(start_s, end_s));
        self.made = Some(made);
    }
}

/// Lanes to begin with: the control, the rate it moves, the moment.
fn usual(surface: Option<Surface>) -> Vec<Signal> {
    let [control, rate] = roles(surface).map(Signal::Channel);
    let moment = match surface {
        Some(Surface::Aileron) => Coefficient::Cl,
        Some(Surface::Rudder) => Coefficient::Cn,
        _ => Coefficient::Cm,
    };
    vec![control, rate, Signal::Coefficient(moment)]
}

fn label(signal: Signal) -> String {
    match signal {
        Signal::Channel(role) => notation::role(role).to_string(),
        Signal::Coefficient(coefficient) => coefficient.name().to_owned(),
    }
}

/// Where the input of a window begins: as found in the recording, else where the window does.
pub fn onset(ctx: &PanelContext<'_>, window: &Manoeuvre) -> f64 {
    let found = ctx.snapshot.proposals.get(&window.flight).and_then(|slot| slot.latest());
    let inside = found.into_iter().flat_map(|found| &found.windows).filter(|proposal| {
        (window.window.start_s..window.window.end_s).contains(&proposal.onset_s)
            && window.surface.is_none_or(|surface| proposal.manoeuvre.surface == Some(surface))
    });
    inside.map(|proposal| proposal.onset_s).reduce(f64::min).unwrap_or(window.window.start_s)
}

/// A series over a manoeuvre with the onset at zero; empty without one.
fn cut(series: Option<&Series>, manoeuvre: &Manoeuvre, onset_s: f64) -> Series {
    let Some(series) = series else { return Series { time_s: [].into(), values: [].into() } };
    let inside = manoeuvre.window.indices(&series.time_s);
    let time_s = series.time_s[inside.clone()].iter().map(|time| time - onset_s).collect();
    Series { time_s, values: series.values[inside].into() }
}

/// A signal of a window as measured and by the model, the onset at zero; empty where there is none.
fn aligned(ctx: &PanelContext<'_>, window: &Manoeuvre, signal: Signal) -> [Series; 2] {
    let onset_s = onset(ctx, window);
    let cut = |series: Option<&Series>| cut(series, window, onset_s);
    match signal {
        Signal::Channel(role) => {
            let loaded = ctx.snapshot.flights.get(&window.flight).and_then(|slot| slot.latest());
            [cut(loaded.and_then(|of| of.recording.role(role)).map(|channel| &channel.series)), cut(None)]
        }
        Signal::Coefficient(coefficient) => {
            let aero = ctx.snapshot.windows.get(&window.name).and_then(|results| results.aero.latest());
            let pooled = ctx.snapshot.pooled.latest();
            let predicted = pooled.into_iter().flat_map(|pooled| &pooled.predictions);
            let of_this = |prediction: &&doublet_engine::stage::Prediction| {
                prediction.window == window.name && prediction.coefficient == coefficient
            };
            let model = predicted.filter(of_this).map(|prediction| &prediction.own_constant).next();
            [cut(aero.map(|aero| &aero.series[coefficient as usize])), cut(model)]
        }
    }
}
