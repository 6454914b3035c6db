//! Real-time monitoring of a flight: traces, estimates with error bars over time, lamps, limits.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::sync::Arc;

use doublet_core::quantity::Role;
use doublet_engine::live::{Feed, Limit, LimitReading, LineFormat, LiveDerivative, LiveUpdate, Opening};
use doublet_engine::run::{LiveOrder, LiveThread, LiveView};
use doublet_engine::verdict::Level;
use eframe::egui::{self, CollapsingHeader, Label, RichText, ScrollArea, Ui, WidgetText};

use crate::command::FileField;
use crate::panels::{Panel, PanelContext, browse, empty, text_field, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::level_mark::level_mark;
use crate::{notation, theme};

/// Time without anything new after which a file has ended, s.
const WAIT_S: u64 = 10;
/// Height of a chart, points.
const CHART_HEIGHT: f32 = 190.0;
/// Width from which two charts stand beside each other, points.
const BESIDE: f32 = 1000.0;

/// Where a flight comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum From {
    /// The session's first flight, flown again.
    #[default]
    Session,
    File,
    /// Lines by UDP.
    Lines,
    /// MAVLink by UDP.
    Mavlink,
}

pub struct Live {
    from: From,
    place: String,
    senders: String,
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
            senders: String::new(),
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
        ui.add_enabled_ui(!runs, |ui| self.source(ctx, ui));
        ui.horizontal(|ui| {
            if runs {
                if ui.button("Stop").on_hover_text("Stop; the recorded data become a session").clicked()
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
            return empty(ui, "Press Watch to follow a flight in real time, or to replay one.");
        };
        trouble(ui, view.error.as_deref());
        if let Some(session) = &view.session {
            ui.label(format!("Recorded: {}", session.display()));
        }
        let Some(latest) = &view.latest else { return empty(ui, "Waiting for the first second of samples.") };
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            lamps(ctx, ui, latest);
            findings(ui, &view);
            self.charts(ctx, ui, &view);
            self.table(ui, latest);
        });
    }
}

impl Live {
    /// Where the flight comes from.
    fn source(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let all = [
                (From::Session, "Session", "Replay the first flight of the session"),
                (From::File, "File", "A recording, a growing text file, or a telemetry log"),
                (From::Lines, "UDP lines", "JSON or CSV at an address such as 127.0.0.1:9000"),
                (From::Mavlink, "MAVLink", "Packets at an address such as 127.0.0.1:14550"),
            ];
            for (from, name, hint) in all {
                ui.selectable_value(&mut self.from, from, name).on_hover_text(hint);
            }
            if self.from != From::Session {
                let (name, hint) = match self.from {
                    From::File => ("File", "flight.csv"),
                    _ => ("Address", "127.0.0.1:9000"),
                };
                named_field(ui, (name, "Live source"), &mut self.place, hint, 220.0);
                if self.from == From::File {
                    browse(ctx, ui, FileField::LiveSource, &mut self.place);
                }
                if self.is_by_udp() {
                    named_field(ui, ("Senders", "Live senders"), &mut self.senders, "any, or 192.168.1.10, ...", 150.0);
                }
                named_field(ui, ("Channel map", "Live channel map"), &mut self.map, "best fitting", 140.0);
            }
            if matches!(self.from, From::Session | From::File) {
                ui.add(egui::DragValue::new(&mut self.speed).range(0.1..=1000.0).prefix("speed × ").speed(0.1))
                    .on_hover_text("Times real time");
            }
            let hint = "alpha < 14 deg, 0.2 < n_z < 3.5";
            named_field(ui, ("Limits", "Live limits"), &mut self.limits, hint, 220.0);
            named_field(ui, ("Campaign", "Live campaign"), &mut self.campaign, "file with its limits", 140.0);
            browse(ctx, ui, FileField::LiveCampaign, &mut self.campaign);
            named_field(ui, ("Record into", "Live record"), &mut self.record, "new folder", 140.0);
            browse(ctx, ui, FileField::LiveRecord, &mut self.record);
        });
    }

    /// Whether packets come by UDP.
    fn is_by_udp(&self) -> bool {
        matches!(self.from, From::Lines | From::Mavlink)
    }

    /// The addresses whose packets are accepted; none for all.
    fn read_senders(&self) -> Result<Vec<IpAddr>, String> {
        if !self.is_by_udp() {
            return Ok(Vec::new());
        }
        let texts = self.senders.split([',', ' ']).filter(|text| !text.is_empty());
        let one = |text: &str| {
            text.parse().map_err(|_| format!("'{text}' is not an IP address: write one such as 192.168.1.10"))
        };
        texts.map(one).collect()
    }

    fn start(&mut self, ctx: &PanelContext<'_>, ui: &Ui) {
        let from = match self.read_senders() {
            Ok(from) => from,
            Err(line) => return self.error = Some(line),
        };
        let limits = match Limit::parse_list(&self.limits) {
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
        // Packets may come again at any time.
        let wait = (!self.is_by_udp()).then(|| std::time::Duration::from_secs(WAIT_S));
        let in_memory = Some((ctx.session.clone(), ctx.folder.to_owned()));
        let (map, campaign) = (text(&self.map), text(&self.campaign));
        let opening = Opening { feed, in_memory, map, campaign, from, wait, ..Opening::default() };
        let order = LiveOrder { opening, speed: Some(self.speed), limits, record: text(&self.record).map(Into::into) };
        let repaint = ui.ctx().clone();
        match LiveThread::start(order, move || repaint.request_repaint()) {
            Ok(thread) => (self.thread, self.error) = (Some(thread), None),
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// A quantity of the motion and a derivative over time, beside each other where there is room.
    fn charts(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, view: &Arc<LiveView>) {
        if ui.available_width() < BESIDE {
            self.motion(ctx, ui, view);
            return self.estimate(ctx, ui, view);
        }
        ui.columns(2, |columns| {
            self.motion(ctx, &mut columns[0], view);
            self.estimate(ctx, &mut columns[1], view);
        });
    }

    fn motion(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, view: &Arc<LiveView>) {
        let palette = theme::palette(ui);
        ui.horizontal(|ui| {
            let names: BTreeSet<&str> = view.traces.keys().map(String::as_str).collect();
            choose(ui, "Live quantity", &mut self.trace, &names, |name| symbol(name).into());
        });
        let (unit, scale) = unit(ctx, &self.trace);
        let mut points = view.traces.get(&self.trace).cloned().unwrap_or_default();
        points.iter_mut().for_each(|[_, value]| *value *= scale);
        let label = if unit.is_empty() { symbol(&self.trace) } else { format!("{} [{unit}]", symbol(&self.trace)) };
        let mut chart = Chart::new("live trace", "time [s]", label);
        chart.legend = false;
        chart.curves.push(ChartCurve::new(self.trace.clone(), palette.series[0], ChartStyle::Line, points));
        ctx.chart(ui, &chart, CHART_HEIGHT);
    }

    fn estimate(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, view: &Arc<LiveView>) {
        let palette = theme::palette(ui);
        let names: BTreeSet<&str> = view.estimates.keys().map(String::as_str).collect();
        if !names.contains(self.derivative.as_str()) {
            self.derivative = names.first().map_or_else(String::new, |name| (*name).to_owned());
        }
        let Some(trace) = view.estimates.get(&self.derivative) else { return };
        ui.horizontal(|ui| {
            choose(ui, "Live derivative", &mut self.derivative, &names, |name| notation::typeset(name, 13.0).into());
            ui.weak("with twice its standard error");
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
        if ui.link(notation::typeset(&derivative.name, 13.0)).clicked() {
            self.derivative.clone_from(&derivative.name);
        }
        ui.label(number(derivative.estimate));
        ui.weak(format!("± {}", number(derivative.standard_error)));
        ui.weak(derivative.relative_error_percent.map_or_else(String::new, |percent| format!("{percent:.0} %")));
    }
}

/// A field behind its name; both go to the next row where they do not fit this one.
fn named_field(ui: &mut Ui, (shown, name): (&str, &str), text: &mut String, hint: &str, width: f32) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let named = ui.painter().layout_no_wrap(shown.to_owned(), font, ui.visuals().text_color()).size().x;
    if named + width + 3.0 * ui.spacing().item_spacing.x > ui.available_size_before_wrap().x {
        ui.end_row();
    }
    // As high as the field, so that its name stands at its height at the beginning of a row too.
    let size = egui::vec2(named, ui.spacing().interact_size.y);
    ui.add_sized(size, Label::new(RichText::new(shown).weak()).extend());
    text_field(ui, name, text, hint, width);
}

/// Time, counts, correlation, limits, findings.
fn lamps(ctx: &PanelContext<'_>, ui: &mut Ui, latest: &LiveUpdate) {
    ui.label(format!(
        "{:.1} s, {:.2} s behind; {}{}",
        latest.time_s,
        latest.lag_s,
        latest.counts,
        if latest.is_airborne { "" } else { "; not in flight: no estimates" }
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
            let pair = [first, second].map(|name| notation::term(name)).join(" and ");
            let text = format!("{pair} in {}: {}", lamp.coefficient, notation::fixed(lamp.correlation, 2));
            ui.label(notation::typeset(&format!("correlation of {text}"), 13.0));
        }
        for limit in &latest.limits {
            level_mark(ui, Some(limit.level));
            ui.add(Label::new(within(ctx, limit)).extend()).on_hover_text("Range since the last update (limits)");
        }
    });
    for alarm in &latest.alarms {
        ui.horizontal_wrapped(|ui| {
            level_mark(ui, Some(Level::Bad));
            ui.strong(alarm);
        });
    }
}

/// Findings so far with their times, the latest first.
fn findings(ui: &mut Ui, view: &LiveView) {
    let count = view.findings.len();
    if count > 0 {
        CollapsingHeader::new(notation::plural(count, "note")).id_salt("live notes").show(ui, |ui| {
            for (time_s, finding) in view.findings.iter().rev() {
                let text = format!("{time_s:.1} s: {finding}");
                ui.add(Label::new(notation::typeset_in(&text, 12.0, ui.visuals().weak_text_color())).wrap());
            }
        });
    }
}

/// What was flown of a quantity and its limits, in the unit of the display.
fn within(ctx: &PanelContext<'_>, limit: &LimitReading) -> String {
    let (unit, scale) = unit(ctx, &limit.quantity);
    let [least, greatest] = limit.range.map(|value| notation::number(scale * value));
    let bound = |bound: Option<f64>| bound.map_or_else(|| "–".to_owned(), |value| notation::number(scale * value));
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let (low, high) = (bound(limit.low), bound(limit.high));
    format!("{} {least} to {greatest}{unit} ({low} to {high})", symbol(&limit.quantity))
}

/// How a quantity is written: the symbol of its role, its name otherwise.
fn symbol(quantity: &str) -> String {
    Role::from_name(quantity).map_or_else(|| quantity.to_owned(), |role| notation::role(role).to_owned())
}

/// Unit a quantity is shown in, and its factor from SI.
fn unit(ctx: &PanelContext<'_>, quantity: &str) -> (&'static str, f64) {
    Role::from_name(quantity).map_or(("", 1.0), |role| ctx.state.units.of_role(role))
}

/// A list of names of which one is chosen.
fn choose(ui: &mut Ui, id: &str, chosen: &mut String, names: &BTreeSet<&str>, shown: impl Fn(&str) -> WidgetText) {
    egui::ComboBox::from_id_salt(id).selected_text(shown(chosen)).show_ui(ui, |ui| {
        for name in names {
            ui.selectable_value(chosen, (*name).to_owned(), shown(name));
        }
    });
}
