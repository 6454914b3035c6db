//! Treatment of signals before use: smoothing, resampling, time shifts, steady parts.

use doublet_core::prep::{Interpolation, Resampling};
use doublet_core::quantity::Role;
use doublet_core::series::TimeRange;
use doublet_engine::session::{
    EXPRESSION_SOURCE, Edit, NoiseEdit, SignalEdit, SignalPreset, SignalRule, SignalSetting, SteadyWindow,
};
use doublet_engine::stage::{FlightProposals, LoadedFlight, SignalSpectrum, UsedClock};
use eframe::egui::{self, CollapsingHeader, ComboBox, Grid, RichText, ScrollArea, Ui};

use crate::panels::{Panel, PanelContext, View, caption, empty};
use crate::widgets::EditPhase;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::quantity_edit::QuantityEdit;
use crate::widgets::spectrum_chart::{spectrum_chart, spectrum_curve};
use crate::widgets::term::column_title;
use crate::widgets::time_plot::{PlotCache, SpanMark, TimePlot, Trace, TraceStyle};
use crate::{notation, theme};

/// Height of the plots of spectrum and clock, points.
const PLOT_HEIGHT: f32 = 150.0;
/// Height of the plot of the signal, points.
const SIGNAL_HEIGHT: f32 = 190.0;
/// Samples of the moving average and of the polynomial, and its degree, that a tick switches on: those of the thesis.
const AVERAGE: usize = 4;
const POLYNOMIAL: (usize, usize) = (2, 11);
/// Rate new samples have at first, Hz.
const RATE_HZ: f64 = 100.0;
/// Most time a source is shifted by per point it is dragged, s.
const FINE_S: f64 = 5e-4;
/// Longest gap that is bridged when one is stated first, s.
const GAP_S: f64 = 0.5;

#[derive(Default)]
pub struct Preprocess {
    cache: PlotCache,
    role: Option<Role>,
    clock: usize,
    /// Shift before a drag of the trace, and how far it has been dragged, s.
    dragged: Option<(f64, f64)>,
}

impl Panel for Preprocess {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let name = ctx.selection().flight.clone().unwrap_or_default();
        let loaded = ctx.snapshot.flights.get(&name).and_then(|slot| slot.latest());
        let (Some(loaded), Some(flight)) = (loaded, ctx.session.flight(&name)) else {
            return empty(ui, "No recording has been read.");
        };
        let proposals = ctx.snapshot.proposals.get(&name).and_then(|slot| slot.latest());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            presets(ctx, ui, &name, &flight.signals);
            self.signal(ctx, ui, &name, loaded, proposals.map(|found| &found.spectra[..]).unwrap_or_default());
            ui.add_space(6.0);
            CollapsingHeader::new("Clocks").default_open(true).show(ui, |ui| self.clocks(ctx, ui, &name, loaded));
            CollapsingHeader::new("Steady parts").default_open(true).show(ui, |ui| {
                steady(ctx, ui, &name, proposals.map(AsRef::as_ref));
            });
        });
    }
}

/// Sets what is done to a flight's signals.
fn set(ctx: &mut PanelContext<'_>, flight: &str, setting: SignalSetting) {
    ctx.edit(Edit::Signal(SignalEdit::Setting { flight: flight.to_owned(), setting }));
}

fn presets(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, now: &SignalSetting) {
    ui.horizontal(|ui| {
        ui.weak("All signals");
        for preset in SignalPreset::ALL {
            let button = egui::Button::selectable(now.preset() == Some(preset), preset.name());
            let hint = match preset {
                SignalPreset::AsRecorded => "Every signal as sampled",
                SignalPreset::Thesis => {
                    "Inertial samples by moving average of 4, polynomial of degree 2 over 11 and quadratic spline to 100 Hz; \
                     flow angles by quadratic spline, others linearly to 100 Hz"
                }
            };
            if ui.add(button).on_hover_text(hint).clicked() && now.preset() != Some(preset) {
                set(ctx, flight, now.with_preset(preset));
            }
        }
        ui.separator();
        ui.weak("Gaps bridged");
        let mut stated = now.max_gap_s.is_some();
        let tick = ui.checkbox(&mut stated, "up to").on_hover_text(
            "No interpolation over longer gaps. Default: a few sample intervals",
        );
        ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label("limit gaps"));
        if stated != now.max_gap_s.is_some() {
            set(ctx, flight, SignalSetting { max_gap_s: stated.then_some(GAP_S), ..now.clone() });
        }
        if let Some(gap) = now.max_gap_s {
            let edited = QuantityEdit::new("longest gap", gap).unit("s", 1.0).logarithmic().show(ui);
            ctx.edit_quantity(edited, |gap| {
                let setting = SignalSetting { max_gap_s: Some(gap), ..now.clone() };
                Edit::Signal(SignalEdit::Setting { flight: flight.to_owned(), setting })
            });
        }
    });
}

impl Preprocess {
    /// One signal: what is done to it, before and after, its spectra.
    fn signal(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        flight: &str,
        loaded: &LoadedFlight,
        spectra: &[SignalSpectrum],
    ) {
        let recording = &loaded.recording;
        let roles: Vec<Role> = spectra.iter().map(|spectrum| spectrum.role).collect();
        let Some(role) = self.role.filter(|role| roles.contains(role)).or(roles.first().copied()) else {
            ui.weak("Waiting for the recording.");
            return;
        };
        self.role = Some(role);
        let setting = ctx.session.flight(flight).map(|flight| flight.signals.clone()).unwrap_or_default();
        ui.horizontal(|ui| {
            let combo = ComboBox::from_id_salt("signal").selected_text(notation::role(role)).width(70.0);
            let combo = combo.show_ui(ui, |ui| {
                for &other in &roles {
                    let text = format!("{}  {}", notation::role(other), other.description());
                    ui.selectable_value(&mut self.role, Some(other), text);
                }
            });
            ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("signal"));
            rule(ctx, ui, flight, role, &setting);
        });
        let Some(used) = recording.role(role) else { return };
        let palette = theme::palette(ui);
        let treated = loaded.treated.iter().find(|signal| signal.role == role);
        let (unit, scale) = ctx.state.units.of_role(role);
        let mut traces = Vec::new();
        if let Some(signal) = treated {
            let recorded = &recording.channels[signal.recorded].series;
            let style = TraceStyle::Dots;
            traces.push(Trace { scale, style, ..Trace::new("recorded", recorded, palette.ignored) });
        }
        let name = if treated.is_some() { "used" } else { "recorded" };
        traces.push(Trace { scale, ..Trace::new(name, &used.series, palette.series[0]) });
        let steady = ctx.session.steady.iter().filter(|steady| steady.flight == flight);
        let marks: Vec<SpanMark> = steady
            .map(|steady| SpanMark {
                part: TimeRange::new(steady.window.start_s, steady.window.end_s),
                color: palette.good,
                selected: false,
            })
            .collect();
        let plots = [TimePlot::new(notation::role(role), unit, traces)];
        ui.allocate_ui(egui::vec2(ui.available_width(), SIGNAL_HEIGHT), |ui| {
            ctx.stack(ui, "preprocess", View::Flight, &mut self.cache, &plots, &marks);
        });
        if let Some(signal) = treated {
            ui.weak(format!("{}: {} samples, {} used", signal.steps.join(", "), signal.samples[0], signal.samples[1]));
        }
        if let Some(found) = spectra.iter().find(|spectrum| spectrum.role == role) {
            spectrum_plot(ctx, ui, found, unit, scale);
        }
    }

    /// Clocks of the recorders: what was fitted, and the shift by hand.
    fn clocks(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, loaded: &LoadedFlight) {
        Grid::new("clocks").num_columns(5).spacing([12.0, 3.0]).show(ui, |ui| {
            for title in ["Source", "Offset [s]", "Drift [ppm]", "± [ms]", "Shift by hand [ms]"] {
                ui.weak(title);
            }
            ui.end_row();
            for source in sources(loaded) {
                let clock = loaded.clocks.iter().find(|clock| clock.source == source);
                let offset = clock.map_or(0.0, |clock| clock.model.offset_s);
                ui.scope(|ui| {
                    ui.set_max_width(150.0);
                    ui.add(egui::Label::new(&source).truncate());
                });
                ui.label(notation::fixed(offset, 4));
                ui.label(notation::fixed(1e6 * clock.map_or(0.0, |clock| clock.model.drift), 1));
                let error = clock.and_then(|clock| clock.estimate.as_ref()).map(|estimate| estimate.best_known.1);
                ui.label(error.map_or_else(|| "–".to_owned(), |error| notation::fixed(1e3 * error, 1)));
                let name = format!("shift {source}");
                let edited =
                    QuantityEdit::new(&name, shift_of(ctx, flight, &source)).unit("ms", 1e3).per_point(0.5).show(ui);
                ctx.edit_quantity(edited, |shift_s| shift(flight, &source, shift_s));
                ui.end_row();
            }
        });
        let sources = sources(loaded);
        let Some(source) = sources.get(self.clock.min(sources.len().saturating_sub(1))) else { return };
        ui.horizontal_wrapped(|ui| {
            ui.weak("Lag of");
            for (index, source) in sources.iter().enumerate() {
                ui.selectable_value(&mut self.clock, index, source);
            }
        });
        if let Some(clock) = loaded.clocks.iter().find(|clock| clock.source == *source) {
            lag_plot(ctx, ui, clock);
        }
        self.drag(ctx, ui, flight, source);
    }

    /// A strip that shifts a source as it is dragged, by as much time as the pointer passes in the plot of the signal, but finely:
    /// clocks differ by milliseconds.
    fn drag(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, source: &str) {
        let by_hand = notation::fixed(1e3 * shift_of(ctx, flight, source), 1);
        let text = format!("⬌  drag to shift {source} in time: {by_hand} ms");
        let strip = ui.add(
            egui::Button::new(RichText::new(text).size(12.0))
                .min_size(egui::vec2(ui.available_width(), 22.0))
                .sense(egui::Sense::drag()),
        );
        ui.ctx().accesskit_node_builder(strip.id, |node| node.set_label(format!("drag {source}")));
        let per_point =
            (ctx.view(View::Flight).range().length_s() / f64::from(strip.rect.width().max(1.0))).min(FINE_S);
        if strip.drag_started() {
            let before = shift_of(ctx, flight, source);
            self.dragged = Some((before, 0.0));
            ctx.edit_phase(EditPhase::Begin, shift(flight, source, before));
        }
        let Some((before, by)) = &mut self.dragged else { return };
        let moved = f64::from(strip.drag_delta().x);
        *by += moved * per_point;
        let now = *before + *by;
        if strip.dragged() && moved != 0.0 {
            ctx.edit_phase(EditPhase::Change, shift(flight, source, now));
        }
        if strip.drag_stopped() {
            self.dragged = None;
            ctx.edit_phase(EditPhase::Commit, shift(flight, source, now));
        }
    }
}

fn shift(flight: &str, source: &str, shift_s: f64) -> Edit {
    Edit::Signal(SignalEdit::Shift { flight: flight.to_owned(), source: source.to_owned(), shift_s })
}

/// The shift by hand the session has for a source.
fn shift_of(ctx: &PanelContext<'_>, flight: &str, source: &str) -> f64 {
    let clocks = ctx.session.flight(flight).map(|flight| &flight.clocks[..]).unwrap_or_default();
    clocks.iter().find(|clock| clock.source == source).map_or(0.0, |clock| clock.shift_s)
}

/// Sources that play a role or have a clock, by the names their clocks have.
fn sources(loaded: &LoadedFlight) -> Vec<String> {
    let mut names: Vec<String> = loaded.clocks.iter().map(|clock| clock.source.clone()).collect();
    let treated: Vec<usize> = loaded.treated.iter().map(|signal| signal.recorded).collect();
    let roles = loaded.recording.roles.values().filter(|_| treated.is_empty());
    for &index in roles.chain(&treated) {
        let source = &loaded.recording.channels[index].source;
        if source == EXPRESSION_SOURCE {
            continue;
        }
        let known = names.iter().any(|name| match name.strip_suffix('*') {
            Some(beginning) => source.starts_with(beginning),
            None => name == source,
        });
        if !known {
            names.push(source.clone());
        }
    }
    names
}

/// Name of a way to new samples.
fn resampling_name(interpolation: Option<Interpolation>) -> &'static str {
    match interpolation {
        None => "own samples",
        Some(Interpolation::Linear) => "straight lines to",
        Some(Interpolation::QuadraticSpline) => "quadratic spline to",
    }
}

/// Smoothing and resampling of one role.
fn rule(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, role: Role, setting: &SignalSetting) {
    let now = setting.rule(role).cloned().unwrap_or_default();
    let mut next = SignalRule { roles: Vec::new(), ..now.clone() };
    let mut average = next.moving_average.is_some();
    if ui.checkbox(&mut average, "moving average").changed() {
        next.moving_average = average.then_some(AVERAGE);
    }
    let mut fields = Vec::new();
    let mut field = |ui: &mut Ui, name: &str, value: egui::DragValue<'_>| {
        let response = ui.add(value);
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        fields.push(response);
    };
    if let Some(width) = &mut next.moving_average {
        field(ui, "width of the average", egui::DragValue::new(width).range(1..=200).suffix(" samples"));
    }
    let mut polynomial = next.polynomial.is_some();
    if ui.checkbox(&mut polynomial, "polynomial").on_hover_text("Savitzky-Golay").changed() {
        next.polynomial = polynomial.then_some(POLYNOMIAL);
    }
    if let Some((degree, width)) = &mut next.polynomial {
        field(ui, "degree of the polynomial", egui::DragValue::new(degree).range(0..=6).prefix("degree "));
        let mut half = *width / 2;
        let least = *degree / 2 + 1;
        let shown = egui::DragValue::new(&mut half).range(least..=100);
        field(ui, "width of the polynomial", shown.custom_formatter(|half, _| format!("{} samples", 2.0 * half + 1.0)));
        *width = 2 * half.max(least) + 1;
    }
    let mut interpolation = next.resampling.map(|resampling| resampling.interpolation);
    let combo = ComboBox::from_id_salt("resampling").selected_text(resampling_name(interpolation)).width(130.0);
    let combo = combo.show_ui(ui, |ui| {
        for choice in [None, Some(Interpolation::Linear), Some(Interpolation::QuadraticSpline)] {
            ui.selectable_value(&mut interpolation, choice, resampling_name(choice));
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("resampling"));
    let mut rate_hz = next.resampling.map_or(RATE_HZ, |resampling| resampling.rate_hz);
    if interpolation.is_some() {
        field(ui, "rate", egui::DragValue::new(&mut rate_hz).range(1.0..=1000.0).suffix(" Hz"));
    }
    next.resampling = interpolation.map(|interpolation| Resampling { rate_hz, interpolation });
    let edit = |rule: &SignalRule| {
        Edit::Signal(SignalEdit::Setting { flight: flight.to_owned(), setting: setting.with(role, rule) })
    };
    // The edits of a drag are one step of undo.
    if fields.iter().any(egui::Response::drag_started) {
        ctx.edit_phase(EditPhase::Begin, edit(&next));
    }
    let changed =
        (next.moving_average, next.polynomial, next.resampling) != (now.moving_average, now.polynomial, now.resampling);
    if fields.iter().any(egui::Response::drag_stopped) {
        ctx.edit_phase(EditPhase::Commit, edit(&next));
    } else if changed {
        ctx.edit(edit(&next));
    }
}

/// Spectra before and after, both axes logarithmic.
fn spectrum_plot(ctx: &mut PanelContext<'_>, ui: &mut Ui, found: &SignalSpectrum, unit: &str, scale: f64) {
    let palette = theme::palette(ui);
    let mut chart = spectrum_chart("spectrum", &found.recorded.frequency_hz, unit);
    let color = if found.treated.is_some() { palette.ignored } else { palette.series[0] };
    chart.curves.push(spectrum_curve("recorded", &found.recorded, scale, color));
    let used = found.treated.as_ref().map(|treated| spectrum_curve("used", treated, scale, palette.series[0]));
    chart.curves.extend(used);
    ctx.chart(ui, &chart, PLOT_HEIGHT);
}

/// What every chunk of the shared channels says about a clock, against its own time.
fn lag_plot(ctx: &mut PanelContext<'_>, ui: &mut Ui, clock: &UsedClock) {
    let Some(estimate) = &clock.estimate else { return };
    let palette = theme::palette(ui);
    let mut chart = Chart::new("lag", format!("own time of {} [s]", clock.source), "lag [ms]");
    for (used, name, color) in [(false, "left out", palette.ignored), (true, "agrees", palette.series[0])] {
        let chunks = estimate.chunks.iter().filter(|chunk| chunk.used == used);
        let points = chunks.map(|chunk| [chunk.own_s, 1e3 * chunk.residual_s]).collect();
        chart.curves.push(ChartCurve::new(name, color, ChartStyle::Dots(3.5), points));
    }
    chart.levels.push((1e3 * clock.shift_s, palette.accent));
    ctx.chart(ui, &chart, PLOT_HEIGHT);
}

/// Steady parts: those of the session, those found, one from the screen.
fn steady(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, proposals: Option<&FlightProposals>) {
    let session = ctx.session;
    let own: Vec<SteadyWindow> = session.steady.iter().filter(|steady| steady.flight == flight).cloned().collect();
    let set = |ctx: &mut PanelContext<'_>, windows: Vec<SteadyWindow>| {
        ctx.edit(Edit::Noise(NoiseEdit::Steady { flight: flight.to_owned(), windows }));
    };
    let found = proposals.map(|proposals| &proposals.steady[..]).unwrap_or_default();
    ui.horizontal(|ui| {
        if ui.button("Mark what is on screen").on_hover_text("Or the time between markers A and B").clicked() {
            let view = ctx.view(View::Flight);
            let part = match view.markers_s {
                [Some(a), Some(b)] => TimeRange::new(a, b),
                _ => view.range(),
            };
            let window = part;
            let added = SteadyWindow { flight: flight.to_owned(), window, roles: Vec::new() };
            set(ctx, own.iter().cloned().chain([added]).collect());
        }
        let hint = "Marks all steady parts found";
        if !found.is_empty()
            && own.is_empty()
            && ui.button(format!("Mark the {} found", found.len())).on_hover_text(hint).clicked()
        {
            set(ctx, found.to_vec());
        }
        if !own.is_empty() && ui.button("Remove all").clicked() {
            set(ctx, Vec::new());
        }
        let (used, how) = if own.is_empty() { (found, "found") } else { (&own[..], "marked") };
        let about = "Noise is estimated over steady parts: inertial sensors and air data in flight, attitude and navigation on the ground if available";
        ui.weak(steady_windows(used, how)).on_hover_text(about);
    });
    for (index, steady) in own.iter().enumerate() {
        ui.horizontal(|ui| {
            let TimeRange { start_s, end_s } = steady.window;
            let text = format!("{} s to {} s", notation::fixed(start_s, 2), notation::fixed(end_s, 2));
            if ui.link(text).on_hover_text("Show it").clicked() {
                ctx.view(View::Flight).zoom_to(TimeRange::new(start_s - 10.0, end_s + 10.0));
            }
            let roles: Vec<_> = steady.roles.iter().map(|role| notation::role(*role)).collect();
            ui.weak(if roles.is_empty() { "all signals".to_owned() } else { roles.join(" ") });
            let remove = ui.small_button("✕").on_hover_text("Remove");
            ui.ctx().accesskit_node_builder(remove.id, |node| node.set_label(format!("remove steady {}", index + 1)));
            if remove.clicked() {
                let left = own.iter().enumerate().filter(|(other, _)| *other != index);
                set(ctx, left.map(|(_, steady)| steady.clone()).collect());
            }
        });
    }
    statistics(ctx, ui, flight);
}

/// Titles of the columns of statistics, and what each is.
const STATISTICS: [&str; 6] = ["", "σ", "σ of differences", "samples", "next sample", "whiteness"];

/// How many steady parts there are and what they speak for.
fn steady_windows(windows: &[SteadyWindow], how: &str) -> String {
    let all = windows.iter().filter(|steady| steady.roles.is_empty()).count();
    let flying = windows.iter().filter(|steady| steady.roles.contains(&Role::RollRate)).count();
    let parked = windows.len() - all - flying;
    let parts = [(all, "for all signals"), (flying, "in flight"), (parked, "on the ground")];
    let parts: Vec<_> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, place)| format!("{count} {place}")).collect();
    if parts.is_empty() { format!("none {how}") } else { format!("{how}: {}", parts.join(", ")) }
}

/// What the steady parts say about every entry of the noise.
fn statistics(ctx: &PanelContext<'_>, ui: &mut Ui, flight: &str) {
    let Some(noise) = ctx.snapshot.noise.get(flight).and_then(|slot| slot.latest()) else { return };
    caption(ui, "Noise over the steady parts");
    Grid::new("noise statistics").num_columns(6).spacing([14.0, 2.0]).show(ui, |ui| {
        for title in STATISTICS {
            column_title(ui, title);
        }
        ui.end_row();
        for row in &noise.rows {
            let Some(found) = &row.statistics else { continue };
            let role = row.channel.role();
            let (unit, scale) = ctx.state.units.of_role(role);
            ui.label(notation::role(role)).on_hover_text(row.origin());
            ui.label(format!("{} {unit}", notation::number(scale * found.std)));
            ui.label(notation::number(scale * found.difference_std));
            ui.label(found.samples.to_string());
            ui.label(notation::fixed(found.lag_one, 2));
            let white = RichText::new(notation::fixed(found.whiteness, 3));
            let hint = "p-value of the whiteness test: small if motion or a filter remains";
            ui.label(white).on_hover_text(hint);
            ui.end_row();
        }
    });
}
