//! The ground track, manoeuvres in their colours, the cursor at the position of the aircraft.

use doublet_core::quantity::{Dimension, Role};
use doublet_core::series::{Recording, Series, TimeRange, gap_threshold_s, value_at};
use eframe::egui::Ui;

use crate::panels::{Panel, PanelContext, chosen_flight, empty, role_color};
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};

/// Points of the whole track, and of one window, that are drawn at most.
const TRACK_POINTS: usize = 4000;
const WINDOW_POINTS: usize = 200;
/// Cosine of the latitude a track is drawn with at least: near a pole it would become a line.
const LEAST_COSINE: f64 = 0.05;

/// Distance from the origin from which kilometres are shown, m.
const FAR_M: f64 = 10_000.0;

pub struct GroundTrack;

/// East and north positions with their unit and its factor from SI.
struct Track<'a> {
    east: &'a Series,
    north: &'a Series,
    unit: &'a str,
    scale: f64,
    is_angles: bool,
}

impl Panel for GroundTrack {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(loaded) = chosen_flight(ctx, ui) else { return };
        if let Some(track) = track(ctx, &loaded.recording) {
            return draw(ctx, ui, &track);
        }
        ctx.wanted.track.clone_from(&ctx.state.selection.flight);
        let from_velocity = ctx.snapshot.details.latest().and_then(|details| details.track.as_ref());
        match from_velocity {
            Some([north, east]) => {
                let (unit, scale) = length_unit(ctx, [north, east]);
                ui.weak("From the ground velocity: the recording has no position.");
                draw(ctx, ui, &Track { east, north, unit, scale, is_angles: false });
            }
            None => empty(ui, "The recording has neither position nor ground velocity on one clock."),
        }
    }
}

/// Local positions, else geodetic ones.
fn track<'a>(ctx: &PanelContext<'_>, recording: &'a Recording) -> Option<Track<'a>> {
    let pair = |north, east| Some((&recording.role(north)?.series, &recording.role(east)?.series));
    if let Some((north, east)) = pair(Role::PositionNorth, Role::PositionEast) {
        let (unit, scale) = length_unit(ctx, [north, east]);
        return Some(Track { east, north, unit, scale, is_angles: false });
    }
    let (north, east) = pair(Role::Latitude, Role::Longitude)?;
    let (unit, scale) = ctx.unit(Dimension::Angle);
    Some(Track { east, north, unit, scale, is_angles: true })
}

/// Unit of the axes: kilometres where metres are shown and the track is longer than some.
fn length_unit(ctx: &PanelContext<'_>, ways: [&Series; 2]) -> (&'static str, f64) {
    let far = |series: &Series| series.values.iter().any(|value| value.abs() > FAR_M);
    match ctx.unit(Dimension::Length) {
        ("m", scale) if ways.into_iter().any(far) => ("km", 1e-3 * scale),
        other => other,
    }
}

impl Track<'_> {
    /// East and north at the samples of `window`, every so many of them that `most` remain; a gap where one is not `kept`.
    fn points(&self, window: TimeRange, most: usize, kept: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
        let inside = window.indices(&self.north.time_s);
        let step = inside.len().div_ceil(most).max(1);
        let gap_s = self.gap_s();
        let times = inside.step_by(step).map(|at| self.north.time_s[at]);
        times.map(|time_s| self.at(time_s, gap_s).filter(|_| kept(time_s)).unwrap_or([f64::NAN; 2])).collect()
    }

    /// Degrees of longitude as long as one of latitude where the aircraft flew; one for local positions.
    fn aspect(&self) -> f64 {
        let finite = || self.north.values.iter().filter(|latitude| self.is_angles && latitude.is_finite());
        let mean_rad = finite().sum::<f64>() / finite().count().max(1) as f64;
        1.0 / mean_rad.cos().max(LEAST_COSINE)
    }

    fn gap_s(&self) -> f64 {
        gap_threshold_s(&self.north.time_s).max(gap_threshold_s(&self.east.time_s))
    }

    /// East and north at one instant.
    fn at(&self, time_s: f64, gap_s: f64) -> Option<[f64; 2]> {
        let value = |series: &Series| value_at(&series.time_s, &series.values, gap_s, time_s);
        Some([self.scale * value(self.east)?, self.scale * value(self.north)?])
    }
}

fn draw(ctx: &mut PanelContext<'_>, ui: &mut Ui, track: &Track<'_>) {
    let palette = theme::palette(ui);
    let labels = if track.is_angles { ["longitude", "latitude"] } else { ["east", "north"] };
    let [across, up] = labels.map(|label| format!("{label} [{}]", track.unit));
    let aspect = Some(track.aspect());
    let mut chart = Chart { aspect, legend: false, ..Chart::new("ground track", across, up) };
    let all = TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY };
    let mut add = |name: &str, color, style, points| chart.curves.push(ChartCurve::new(name, color, style, points));
    add("track", palette.ignored.gamma_multiply(0.7), ChartStyle::Line, track.points(all, TRACK_POINTS, |_| true));
    let range = ctx.state.time.range();
    if range != ctx.state.time.full() {
        let shown = range;
        add("on screen", palette.cursor, ChartStyle::Line, track.points(shown, TRACK_POINTS, |_| true));
    }
    let flight = ctx.selection().flight.clone();
    for window in ctx.session.windows.iter().filter(|window| Some(&window.flight) == flight.as_ref()) {
        let color = role_color(palette, window.role);
        let is_excluded = |time_s: f64| window.excluded_at(time_s).is_some();
        let kept = track.points(window.window, WINDOW_POINTS, |time_s| !is_excluded(time_s));
        add(&window.name, color, ChartStyle::Line, kept);
        if !window.excluded.is_empty() {
            let left_out = track.points(window.window, WINDOW_POINTS, is_excluded);
            add(&format!("{}, excluded", window.name), color.gamma_multiply(0.5), ChartStyle::Dashed, left_out);
        }
        if ctx.selection().is_selected(&window.name) {
            let ends = track.points(window.window, WINDOW_POINTS, |_| true);
            add("", color, ChartStyle::Dots(3.5), ends.first().into_iter().chain(ends.last()).copied().collect());
        }
    }
    if let Some(here) = ctx.state.time.cursor_s.and_then(|time_s| track.at(time_s, track.gap_s())) {
        add("cursor", palette.series[1], ChartStyle::Dots(5.0), vec![here]);
    }
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}
