//! A flight while it is flown: traces, estimates with error bars over time, lamps, limits.

use std::collections::BTreeSet;
use std::sync::Arc;

use doublet_engine::live::{Feed, LineFormat, LiveDerivative, LiveUpdate, Opening};
use doublet_engine::run::{LiveOrder, LiveThread, LiveView};
use doublet_engine::verdict::Level;
use eframe::egui::{self, ScrollArea, Ui};

use super::{Panel, PanelContext, empty, text_field, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::level_mark::level_mark;

/// Time without anything new after which a stream or a file has ended, s.
const WAIT_S: u64 = 10;
/// Height of a chart, points.
const CHART_HEIGHT: f32 = 190.0;

/// Where a flight comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum From {
    /// The session's first flight, flown again.
    #[default]
    Session,
    /// A file.
    File,
    /// Lines by UDP.
    Lines,
    /// MAVLink by UDP.
    Mavlink,
}

/// The panel.
pub struct Live {
    from: From,
    place: String,
    map: String,
    speed: f64,
    limits: String,
    campaign: String,
    record: String,
    thread: Option<LiveThread>,
    trace: String,
    derivative: String,
    error: Option<String>,
}

impl Default for Live {
    fn default() -> Self {
        Self {
            from: From::default(),
            place: String::new(),
            map: String::new(),
            speed: 1.0,
            limits: String::new(),
            campaign: String::new(),
            record: String::new(),
            thread: None,
            trace: "airspeed".to_owned(),
            derivative: String::new(),
            error: None,
        }
    }
}

impl Panel for Live {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let view = self.thread.as_ref().map(LiveThread::view);
        let runs = view.as_ref().is_some_and(|view| !view.is_finished);
        ui.add_enabled_ui(!runs, |ui| self.source(ui));
        ui.horizontal(|ui| {
            if runs {
                if ui.button("Stop").on_hover_text("Ends it; what was recorded becomes a session").clicked()
                    && let Some(thread) = &self.thread
                {
                    thread.stop();
                }
            } else if ui.button("Watch").clicked() {
                self.start(ctx, ui);
            }
            if let Some(view) = &view {
                ui.weak(view.notes.join("; "));
            }
        });
        trouble(ui, self.error.as_deref());
        let Some(view) = view else {
            return empty(ui, "A flight is watched while it is flown, or flown again, when asked for.");
        };
        trouble(ui, view.error.as_deref());
        if let Some(session) = &view.session {
            ui.label(format!("Recorded: {}", session.display()));
        }
        let Some(latest) = &view.latest else { return empty(ui, "Waiting for the first second of samples.") };
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            lamps(ui, latest);
            self.charts(ctx, ui, &view);
            self.table(ui, latest);
        });
    }
}

impl Live {
    /// Where the flight comes from.
    fn source(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let all = [
                (From::Session, "Session", "The first flight of the session, flown again"),
                (From::File, "File", "A recording, a growing text file, or a telemetry log"),
                (From::Lines, "UDP lines", "JSON or CSV at an address such as 0.0.0.0:9000"),
                (From::Mavlink, "MAVLink", "Packets at an address such as 0.0.0.0:14550"),
            ];
            for (from, name, hint) in all {
                ui.selectable_value(&mut self.from, from, name).on_hover_text(hint);
            }
            if self.from != From::Session {
                let hint = if self.from == From::File { "file" } else { "address:port" };
                text_field(ui, "Live source", &mut self.place, hint, 220.0);
                text_field(ui, "Live channel map", &mut self.map, "channel map (best fitting)", 170.0);
            }
            if matches!(self.from, From::Session | From::File) {
                ui.add(egui::DragValue::new(&mut self.speed).range(0.1..=1000.0).prefix("× ").speed(0.1))
                    .on_hover_text("Times real time");
            }
            text_field(ui, "Live limits", &mut self.limits, "limits: alpha=:14deg n_z=0.2:3.5", 220.0);
            text_field(ui, "Live campaign", &mut self.campaign, "campaign: its limits", 140.0);
            text_field(ui, "Live record", &mut self.record, "new folder to record into", 170.0);
        });
    }

    fn start(&mut self, ctx: &PanelContext<'_>, ui: &Ui) {
        let limits = self.limits.split_whitespace().map(str::parse).collect::<Result<Vec<_>, _>>();
        let limits = match limits {
            Ok(limits) => limits,
            Err(line) => return self.error = Some(line),
        };
        let place = self.place.trim().to_owned();
        let feed = match self.from {
            From::Session => None,
            From::File => Some(Feed::File(place)),
            From::Lines => Some(Feed::Lines(place, LineFormat::Any)),
            From::Mavlink => Some(Feed::Mavlink(place)),
        };
        let text = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let wait = Some(std::time::Duration::from_secs(WAIT_S));
        let in_memory = Some((ctx.session.clone(), ctx.folder.to_owned()));
        let (map, campaign) = (text(&self.map), text(&self.campaign));
        let opening = Opening { feed, in_memory, map, campaign, wait, ..Opening::default() };
        let order = LiveOrder { opening, speed: Some(self.speed), limits, record: text(&self.record).map(Into::into) };
        let repaint = ui.ctx().clone();
        match LiveThread::start(order, move || repaint.request_repaint()) {
            Ok(thread) => (self.thread, self.error) = (Some(thread), None),
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// A quantity of the motion and a derivative over time.
    fn charts(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, view: &Arc<LiveView>) {
        let palette = theme::palette(ui);
        ui.horizontal(|ui| {
            let names: BTreeSet<&str> = view.traces.keys().map(String::as_str).collect();
            choose(ui, "Live quantity", &mut self.trace, &names, |name| name.to_owned());
        });
        let points = view.traces.get(&self.trace).cloned().unwrap_or_default();
        let mut chart = Chart::new("live trace", "time [s]", self.trace.clone());
        chart.legend = false;
        chart.curves.push(ChartCurve::new(self.trace.clone(), palette.series[0], ChartStyle::Line, points));
        ctx.chart(ui, &chart, CHART_HEIGHT);
        let names: BTreeSet<&str> = view.estimates.keys().map(String::as_str).collect();
        if !names.contains(self.derivative.as_str()) {
            self.derivative = names.first().map_or_else(String::new, |name| (*name).to_owned());
        }
        let Some(trace) = view.estimates.get(&self.derivative) else { return };
        ui.horizontal(|ui| {
            choose(ui, "Live derivative", &mut self.derivative, &names, notation::derivative);
            ui.weak("with twice its standard error, since that is within eight times the latest");
        });
        let mut chart = Chart::new("live estimate", "time [s]", notation::derivative(&self.derivative));
        chart.legend = false;
        let (points, spread) = trace.settled();
        let (name, color) = (self.derivative.clone(), palette.series[1]);
        let mut curve = ChartCurve::new(name, color, ChartStyle::Dots(2.0), points.to_vec());
        curve.spread = spread.to_vec();
        chart.curves.push(curve);
        ctx.chart(ui, &chart, CHART_HEIGHT);
    }

    /// Derivatives as they are now, each with its lamp; a click draws it.
    fn table(&mut self, ui: &mut Ui, latest: &LiveUpdate) {
        egui::Grid::new("live derivatives").num_columns(10).striped(true).show(ui, |ui| {
            for pair in latest.derivatives.chunks(2) {
                for derivative in pair {
                    self.row(ui, derivative);
                }
                ui.end_row();
            }
        });
    }

    fn row(&mut self, ui: &mut Ui, derivative: &LiveDerivative) {
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), notation::number);
        let hint = format!("goal {} %", notation::number(derivative.goal_percent));
        level_mark(ui, Some(derivative.level)).on_hover_text(hint);
        if ui.link(notation::derivative(&derivative.name)).clicked() {
            self.derivative.clone_from(&derivative.name);
        }
        ui.label(number(derivative.estimate));
        ui.weak(format!("± {}", number(derivative.standard_error)));
        ui.weak(derivative.relative_error_percent.map_or_else(String::new, |percent| format!("{percent:.0} %")));
    }
}

/// Time, counts, correlation, limits, findings.
fn lamps(ui: &mut Ui, latest: &LiveUpdate) {
    let counts = latest.counts;
    ui.label(format!(
        "{:.1} s, {:.2} s behind; {} samples, {} lost, {} late, {} restarts{}",
        latest.time_s,
        latest.lag_s,
        counts.samples,
        counts.lost,
        counts.late,
        counts.restarts,
        if latest.is_airborne { "" } else { "; not in flight: nothing is estimated" }
    ));
    ui.horizontal_wrapped(|ui| {
        let known = latest.derivatives.iter().filter(|derivative| derivative.level == Level::Good).count();
        if !latest.derivatives.is_empty() {
            level_mark(ui, Some(if latest.is_enough { Level::Good } else { Level::Caution }));
            ui.label(format!("enough: {known} of {}", latest.derivatives.len()));
        }
        if let Some(lamp) = &latest.correlation {
            level_mark(ui, Some(lamp.level));
            let [first, second] = &lamp.regressors;
            ui.label(format!("correlation of {first} and {second} in {}: {:.2}", lamp.coefficient, lamp.correlation));
        }
        for limit in &latest.limits {
            level_mark(ui, Some(limit.level));
            ui.label(format!(
                "{} {} to {}",
                limit.quantity,
                notation::number(limit.range[0]),
                notation::number(limit.range[1])
            ));
        }
    });
    for finding in &latest.findings {
        ui.weak(finding);
    }
}

/// A list of names of which one is chosen.
fn choose(ui: &mut Ui, id: &str, chosen: &mut String, names: &BTreeSet<&str>, shown: impl Fn(&str) -> String) {
    egui::ComboBox::from_id_salt(id).selected_text(shown(chosen)).show_ui(ui, |ui| {
        for name in names {
            ui.selectable_value(chosen, (*name).to_owned(), shown(name));
        }
    });
}
