//! One channel plotted over another for the selected manoeuvre, or between the markers.

use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series, TimeRange, gap_threshold_s, value_at};
use eframe::egui::{ComboBox, Ui};

use crate::panels::recording::flight::{key, resolve};
use crate::panels::{Panel, PanelContext, chosen_flight, empty, role_color};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::{notation, theme};

/// Points drawn at most.
const MOST: usize = 4000;
/// Pairs shown first: the first of which the recording has both.
const USUAL: [[Role; 2]; 3] =
    [[Role::AngleOfAttack, Role::SpecificForceZ], [Role::Elevator, Role::PitchRate], [Role::RollRate, Role::YawRate]];

/// The panel: the channels along and up, by the names plots remember them by.
#[derive(Default)]
pub struct CrossPlot {
    chosen: Option<[String; 2]>,
}

impl Panel for CrossPlot {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(loaded) = chosen_flight(ctx, ui) else { return };
        let recording = &loaded.recording;
        let Some(mut chosen) = self.chosen.clone().or_else(|| usual(recording)) else {
            return empty(ui, "The recording needs two channels with roles.");
        };
        ui.horizontal_wrapped(|ui| {
            for (name, key) in ["x axis", "y axis"].into_iter().zip(&mut chosen) {
                ui.label(name);
                channel_choice(ui, recording, name, key);
            }
        });
        let window = part_shown(ctx);
        let units = ctx.state.units;
        let [Some(x), Some(y)] = chosen.each_ref().map(|key| resolve(recording, key, units)) else {
            self.chosen = None;
            return;
        };
        self.chosen = Some(chosen.clone());
        let label = |(_, label, unit, _): &(_, &str, &str, f64)| match *unit {
            "" => (*label).to_owned(),
            unit => format!("{label} [{unit}]"),
        };
        let palette = theme::palette(ui);
        let (color, named) = match ctx.window() {
            Some(chosen) if chosen.window == window => (role_color(palette, chosen.role), chosen.name.clone()),
            _ => (palette.series[0], "between the markers".to_owned()),
        };
        let excluded = excluded_in(ctx, window);
        let is_excluded = |time_s: f64| excluded.iter().any(|part| part.contains(time_s));
        let pairs = pairs(&x.0.series, &y.0.series, window, [x.3, y.3]);
        // One that is left out of a curve breaks its line.
        let of = |left_out: bool| -> Vec<[f64; 2]> {
            let keep = |(time_s, pair): &(f64, [f64; 2])| {
                if is_excluded(*time_s) == left_out { *pair } else { [f64::NAN; 2] }
            };
            pairs.iter().map(keep).collect()
        };
        let points = of(false);
        let mut chart = Chart::new("cross plot", label(&x), label(&y));
        let faint = color.gamma_multiply(0.45);
        chart.curves.push(ChartCurve::new("", faint, ChartStyle::Line, points.clone()));
        chart.curves.push(ChartCurve::new(named, color, ChartStyle::Dots(1.6), points));
        if pairs.iter().any(|(time_s, _)| is_excluded(*time_s)) {
            let pale = palette.ignored.gamma_multiply(0.5);
            chart.curves.push(ChartCurve::new("excluded", pale, ChartStyle::Dots(1.6), of(true)));
        }
        if let Some(time_s) = ctx.state.window_time.cursor_s {
            let at = [(&x.0.series, x.3), (&y.0.series, y.3)].map(|(series, scale)| {
                value_at(&series.time_s, &series.values, f64::INFINITY, time_s).map(|value| scale * value)
            });
            if let [Some(x), Some(y)] = at {
                chart.curves.push(ChartCurve::new("cursor", palette.series[1], ChartStyle::Dots(5.0), vec![[x, y]]));
            }
        }
        let height = ui.available_height();
        ctx.chart(ui, &chart, height);
    }
}

/// The first usual pair the recording has, else its first two roles.
fn usual(recording: &Recording) -> Option<[String; 2]> {
    let has = |pair: &&[Role; 2]| pair.iter().all(|role| recording.role(*role).is_some());
    let names = |[x, y]: [Role; 2]| [x.name().to_owned(), y.name().to_owned()];
    if let Some(pair) = USUAL.iter().find(has) {
        return Some(names(*pair));
    }
    let mut roles = recording.roles.keys().copied();
    Some(names([roles.next()?, roles.next()?]))
}

fn channel_choice(ui: &mut Ui, recording: &Recording, name: &str, chosen: &mut String) {
    let shown = |key: &str| Role::from_name(key).map_or(key.to_owned(), |role| notation::role(role).to_owned());
    let combo = ComboBox::from_id_salt(("cross plot", name)).selected_text(shown(chosen)).width(150.0).truncate();
    let combo = combo.show_ui(ui, |ui| {
        for index in 0..recording.channels.len() {
            let key = key(recording, index);
            let text = shown(&key);
            ui.selectable_value(chosen, key, text);
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("cross plot {name}")));
}

/// Between the markers where both are set, else the chosen window, else what is on screen.
fn part_shown(ctx: &PanelContext<'_>) -> TimeRange {
    let between = |markers: [Option<f64>; 2]| match markers {
        [Some(a), Some(b)] if a != b => Some(TimeRange { start_s: a.min(b), end_s: a.max(b) }),
        _ => None,
    };
    let marked = between(ctx.state.window_time.markers_s).or(between(ctx.state.time.markers_s));
    marked.or(ctx.window().map(|window| window.window)).unwrap_or_else(|| ctx.state.time.range())
}

/// What is excluded of the chosen manoeuvre where `part` is that manoeuvre, else of all manoeuvres of the flight.
fn excluded_in(ctx: &PanelContext<'_>, part: TimeRange) -> Vec<TimeRange> {
    match ctx.window() {
        Some(chosen) if chosen.window == part => chosen.excluded.clone(),
        _ => {
            let flight = ctx.selection().flight.as_ref();
            let of_flight = ctx.session.windows.iter().filter(|window| Some(&window.flight) == flight);
            of_flight.flat_map(|window| window.excluded.iter().copied()).collect()
        }
    }
}

/// Both channels at the samples of the first inside `window` with their times, every so many of them that [`MOST`] remain.
fn pairs(x: &Series, y: &Series, window: TimeRange, [x_scale, y_scale]: [f64; 2]) -> Vec<(f64, [f64; 2])> {
    let inside = window.indices(&x.time_s);
    let other = window.indices(&y.time_s);
    // One more on either side, so that the ends have neighbours.
    let other = other.start.saturating_sub(1)..(other.end + 1).min(y.time_s.len());
    let (time, values) = (&y.time_s[other.clone()], &y.values[other]);
    let gap_s = gap_threshold_s(time);
    let step = inside.len().div_ceil(MOST).max(1);
    let point = |at: usize| {
        let up = value_at(time, values, gap_s, x.time_s[at]).unwrap_or(f64::NAN);
        (x.time_s[at], [x_scale * x.values[at], y_scale * up])
    };
    inside.step_by(step).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_lie_inside_the_window_at_the_samples_of_the_first_channel() {
        let series = |step: f64, slope: f64| {
            let time: Vec<f64> = (0..100).map(|k| k as f64 * step).collect();
            let values: Vec<f64> = time.iter().map(|t| slope * t).collect();
            Series { time_s: time.into(), values: values.into() }
        };
        let (x, y) = (series(0.1, 2.0), series(0.25, -3.0));
        let found = pairs(&x, &y, TimeRange { start_s: 1.0, end_s: 2.05 }, [10.0, 1.0]);
        assert_eq!(found.len(), 11);
        for ((at_s, [along, up]), k) in found.iter().zip(10..) {
            let time_s = f64::from(k) * 0.1;
            assert!((at_s - time_s).abs() < 1e-12);
            assert!((along - 20.0 * time_s).abs() < 1e-9 && (up + 3.0 * time_s).abs() < 1e-9, "{along} {up}");
        }
    }
}
