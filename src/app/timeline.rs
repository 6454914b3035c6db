//! The whole flight as a thin strip above everything: altitude and airspeed, the windows in the colour of their verdict, and the
//! part on screen as a brush that can be moved, widened and drawn anew.

use std::sync::Arc;

use doublet_core::quantity::Role as ChannelRole;
use doublet_core::series::{Decimated, Pyramid, Recording, Series, TimeRange, decimate};
use doublet_engine::run::Snapshot;
use doublet_engine::session::{Manoeuvre, WindowRole};
use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Color32, CornerRadius, CursorIcon, FontId, Id, PointerButton, Pos2, Rect, Response, Role, Sense, Stroke,
    StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use super::Workbench;
use crate::command::{FileCommand, UiCommand};
use crate::panels::{self, OfFlight, Pane, Spot};
use crate::theme::{self, Palette};
use crate::widgets::hatch::hatch;
use crate::widgets::level_mark;
use crate::widgets::time_plot::{mark, time_at, x_at};

const HEIGHT: f32 = 58.0;
/// Its height in a window lower than this, where the plots need the room.
const LOW: f32 = 38.0;
const LOW_WINDOW: f32 = 780.0;
/// Height of the lane of windows at its foot, and of a window in it.
const LANE: f32 = 19.0;
const BLOCK: f32 = 11.0;
/// Room above the words of a drag that marks.
const ABOVE_WORDS: f32 = 2.0;
/// Least width a window is drawn and caught with.
const LEAST_WIDTH: f32 = 3.0;
/// Half the width in which an edge of the brush can be caught.
const REACH: f32 = 5.0;
/// Magnification per point of wheel travel.
const WHEEL_GAIN: f64 = 0.004;
/// The first role of each line that the recording has is drawn, and whether it is turned over.
const CURVES: [&[(ChannelRole, bool)]; 2] = [
    &[(ChannelRole::Altitude, false), (ChannelRole::GpsAltitude, false), (ChannelRole::PositionDown, true)],
    &[
        (ChannelRole::TrueAirspeed, false),
        (ChannelRole::CalibratedAirspeed, false),
        (ChannelRole::EquivalentAirspeed, false),
    ],
];

/// A curve as drawn, from 0 to 1 over its own range.
struct Curve {
    series: Series,
    columns: usize,
    line: Decimated<Point>,
}

impl Curve {
    /// Whether it was thinned from this series for so many columns.
    fn is_of(&self, series: &Series, columns: usize) -> bool {
        self.columns == columns
            && Arc::ptr_eq(&self.series.time_s, &series.time_s)
            && Arc::ptr_eq(&self.series.values, &series.values)
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point(pub(super) f64, pub(super) f64);

impl From<[f64; 2]> for Point {
    fn from([time_s, value]: [f64; 2]) -> Self {
        Self(time_s, value)
    }
}

/// What was drawn last.
#[derive(Default)]
pub(super) struct Timeline {
    curves: [Option<Curve>; 2],
}

/// What of the brush is held.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Start,
    End,
    /// All of it, caught this far after its start, s.
    Body(f64),
    /// A new one from here, s.
    New(f64),
}

/// The altitude of a recording, thinned out for a picture of `columns`.
pub(super) fn altitude(recording: &Recording, columns: usize) -> Option<Decimated<Point>> {
    let (series, turned) = series_of(recording, CURVES[0])?;
    Some(thinned(series, turned, columns))
}

fn series_of<'a>(recording: &'a Recording, roles: &[(ChannelRole, bool)]) -> Option<(&'a Series, bool)> {
    roles.iter().find_map(|(role, turned)| Some((&recording.role(*role)?.series, *turned)))
}

fn thinned(series: &Series, turned: bool, columns: usize) -> Decimated<Point> {
    let mut line = Decimated::default();
    let count = series.time_s.len().min(series.values.len());
    let (time_s, values) = (&series.time_s[..count], &series.values[..count]);
    if let (Some(first), Some(last)) = (time_s.first(), time_s.last()) {
        let pyramid = Pyramid::new(time_s, values);
        let scale = if turned { -1.0 } else { 1.0 };
        decimate(&pyramid, time_s, values, scale, (*first, *last), columns.max(2), &mut line);
    }
    line
}

impl Timeline {
    /// Brings the curves up to date.
    fn prepare(&mut self, recording: &Recording, columns: usize) {
        for (curve, roles) in self.curves.iter_mut().zip(CURVES) {
            let Some((series, turned)) = series_of(recording, roles) else {
                *curve = None;
                continue;
            };
            if !curve.as_ref().is_some_and(|curve| curve.is_of(series, columns)) {
                *curve = Some(Curve { series: series.clone(), columns, line: thinned(series, turned, columns) });
            }
        }
    }
}

/// Says that there is no flight yet, or that it cannot be read, with the way to where it is.
fn unread(app: &mut Workbench, ui: &mut Ui, frame: Rect, failed: bool) {
    let font = FontId::proportional(11.0);
    if !failed {
        let weak = ui.visuals().weak_text_color();
        ui.painter().text(frame.center(), egui::Align2::CENTER_CENTER, "The flight is being read", font, weak);
        return;
    }
    let color = theme::palette(ui).error;
    let text = "The recording of this flight could not be read";
    let drawn = ui.painter().text(frame.center(), egui::Align2::CENTER_CENTER, text, font, color);
    let place = Rect::from_min_size(pos2(drawn.right() + 12.0, frame.center().y - 10.0), vec2(84.0, 20.0));
    if ui.put(place, egui::Button::new("Find it…").small()).clicked() {
        app.commands.push(UiCommand::File(FileCommand::FindRecording));
    }
}

/// Height of the strip.
pub(super) fn height(ctx: &egui::Context) -> f32 {
    if ctx.content_rect().height() < LOW_WINDOW { LOW } else { HEIGHT }
}

/// Draws the strip and carries out what is done to it.
pub(super) fn show(app: &mut Workbench, ui: &mut Ui) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height(ui.ctx())), Sense::hover());
    let frame = rect.shrink2(vec2(6.0, 2.0));
    let palette = theme::palette(ui);
    ui.painter().rect_filled(frame, CornerRadius::same(3), palette.plot_background);
    let snapshot = Arc::clone(app.snapshot());
    let flight = app.state.selection.flight.clone().unwrap_or_default();
    let loaded = snapshot.flights.get(&flight).and_then(|slot| slot.latest());
    let Some(loaded) = loaded else {
        let failed = snapshot.flights.get(&flight).is_some_and(|slot| slot.error().is_some());
        return unread(app, ui, frame, failed);
    };
    let full = app.state.time.full();
    let lane = Rect::from_min_max(pos2(frame.left(), frame.bottom() - LANE), frame.max);
    let upper = Rect::from_min_max(frame.min, pos2(frame.right(), lane.top()));
    let columns = (frame.width() * ui.pixels_per_point()) as usize;
    app.timeline.prepare(&loaded.recording, columns);
    let colors = [palette.series[0], palette.series[7]];
    for (curve, color) in app.timeline.curves.iter().zip(colors) {
        let Some(curve) = curve else { continue };
        draw_curve(ui, upper.shrink2(vec2(0.0, 3.0)), full, &curve.line, color);
    }
    brush(app, ui, frame, full);
    candidates(app, ui, lane, full);
    let session = Arc::clone(app.document.history.present());
    for window in session.windows.iter().filter(|window| window.flight == flight) {
        block(app, ui, (lane, full), window, &snapshot);
    }
    if let Some(time_s) = app.state.time.cursor_s.filter(|time_s| full.contains(*time_s)) {
        ui.painter().vline(
            x_at(frame, full, time_s),
            frame.y_range(),
            Stroke::new(1.0, palette.cursor.gamma_multiply(0.6)),
        );
    }
}

fn draw_curve(ui: &Ui, rect: Rect, full: TimeRange, line: &Decimated<Point>, color: Color32) {
    let Some((low, high)) = line.extent else { return };
    let size = (high - low).max(1e-9);
    for segment in line.lines() {
        let at = |point: &Point| {
            let y = rect.bottom() - rect.height() * ((point.1 - low) / size) as f32;
            pos2(x_at(rect, full, point.0), y)
        };
        let points: Vec<Pos2> = segment.iter().map(at).collect();
        ui.painter().line(points, Stroke::new(1.0, color.gamma_multiply(0.8)));
    }
}

/// The part on screen: drawn, moved, widened, drawn anew; the wheel zooms it.
fn brush(app: &mut Workbench, ui: &mut Ui, frame: Rect, full: TimeRange) {
    let accent = theme::palette(ui).accent;
    let range = app.state.time.range();
    let shown =
        Rect::from_x_y_ranges(x_at(frame, full, range.start_s)..=x_at(frame, full, range.end_s), frame.y_range());
    let id = Id::unique("timeline brush");
    let response = ui.interact(frame, id, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "timeline of the whole flight"));
    let pointer = response.interact_pointer_pos().or(response.hover_pos());
    let grip = |x: f32| {
        if (x - shown.left()).abs() <= REACH {
            Held::Start
        } else if (x - shown.right()).abs() <= REACH {
            Held::End
        } else if shown.x_range().contains(x) && shown.width() < frame.width() - 1.0 {
            Held::Body(time_at(frame, full, x) - range.start_s)
        } else {
            Held::New(time_at(frame, full, x))
        }
    };
    if let Some(at) = response.hover_pos() {
        ui.set_cursor_icon(match grip(at.x) {
            Held::Start | Held::End => CursorIcon::ResizeHorizontal,
            Held::Body(_) => CursorIcon::Grab,
            Held::New(_) => CursorIcon::Crosshair,
        });
        app.hovered_s = Some(time_at(frame, full, at.x));
        let wheel = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta));
        let now_s = ui.input(|input| input.time);
        if wheel.y != 0.0 {
            app.state.time.zoom((WHEEL_GAIN * f64::from(wheel.y)).exp(), time_at(frame, full, at.x), now_s);
        }
    }
    if marking(app, ui, &response, frame, full) {
        ui.data_mut(|data| data.remove::<Held>(id));
    } else if response.drag_started_by(PointerButton::Primary)
        && let Some(at) = ui.input(|input| input.pointer.press_origin()).or(pointer)
    {
        ui.data_mut(|data| data.insert_temp(id, grip(at.x)));
        app.state.time.zoom_to(range);
    }
    if let Some(held) = ui.data(|data| data.get_temp::<Held>(id)) {
        if response.dragged_by(PointerButton::Primary)
            && let Some(at) = pointer
        {
            let here_s = time_at(frame, full, at.x.clamp(frame.left(), frame.right()));
            app.state.time.drag_to(match held {
                Held::Start => TimeRange::new(here_s, range.end_s),
                Held::End => TimeRange::new(range.start_s, here_s),
                Held::Body(after_s) => {
                    let latest = full.end_s - range.length_s();
                    let start_s = (here_s - after_s).min(latest).max(full.start_s);
                    TimeRange::new(start_s, start_s + range.length_s())
                }
                Held::New(from_s) => TimeRange::new(from_s, here_s),
            });
        } else {
            ui.data_mut(|data| data.remove::<Held>(id));
        }
    } else if response.double_clicked() {
        app.state.time.home();
    }
    menu(app, &response, None, (frame, full));
    ui.painter().rect_filled(shown, 0.0, accent.gamma_multiply(0.13));
    for x in [shown.left(), shown.right()] {
        ui.painter().vline(x, frame.y_range(), Stroke::new(1.5, accent));
    }
}

/// A drag with Ctrl makes a manoeuvre, with Alt it excludes a part of one, as in the plots; whether there is one.
fn marking(app: &mut Workbench, ui: &Ui, response: &Response, frame: Rect, full: TimeRange) -> bool {
    let Some(marked) = mark(ui, response, frame, full) else { return false };
    let (session, snapshot) = (Arc::clone(app.document.history.present()), Arc::clone(app.snapshot()));
    let flight = app.state.selection.flight.clone().unwrap_or_default();
    let of = OfFlight { session: &session, snapshot: &snapshot, flight: &flight };
    let here = |window: &&Manoeuvre| window.flight == flight && window.window.contains(marked.from_s);
    let chosen = app.state.selection.window.as_deref().and_then(|name| session.window(name));
    let window = chosen.filter(here).or_else(|| session.windows.iter().find(here));
    panels::draw_marked(ui, (&[frame], full), marked.part, &of.meaning(ui, window, marked), ABOVE_WORDS);
    if let Some(edit) = of.carry_out(&mut app.state, window, marked) {
        app.apply(&edit);
    }
    true
}

/// The candidates of the flight as ghosts among its manoeuvres.
fn candidates(app: &Workbench, ui: &Ui, lane: Rect, full: TimeRange) {
    let flight = app.state.selection.flight.as_deref().unwrap_or_default();
    let of = OfFlight { session: app.document.session(), snapshot: app.snapshot(), flight };
    let range = app.state.time.range();
    let on_screen = |one: &&Manoeuvre| one.window.start_s < range.end_s && one.window.end_s > range.start_s;
    let open = of.open_candidates(full);
    let asked = app.state.candidate_of(open.iter().copied().filter(on_screen));
    let blocks = Rect::from_x_y_ranges(lane.x_range(), lane.bottom() - BLOCK - 1.0..=lane.bottom() - 1.0);
    let is_lit =
        |one: &Manoeuvre| asked.is_some_and(|asked| std::ptr::eq(asked, one)) || app.state.selection.has_candidate(one);
    panels::ghosts(ui, (&[blocks], full), &open, &is_lit);
}

/// Level of a window, none where it is ignored or not judged yet.
fn level(snapshot: &Snapshot, window: &Manoeuvre) -> Option<Level> {
    let judged = snapshot.verdicts.latest()?.windows.get(&window.name)?;
    (window.role != WindowRole::Ignored).then_some(judged.verdict.level)
}

/// One window in its verdict's colour: a click chooses it, Ctrl and Shift add others, a double click shows it.
fn block(app: &mut Workbench, ui: &mut Ui, (lane, full): (Rect, TimeRange), window: &Manoeuvre, snapshot: &Snapshot) {
    let palette = theme::palette(ui);
    let (left, right) = (x_at(lane, full, window.window.start_s), x_at(lane, full, window.window.end_s));
    let (middle, half) = (0.5 * (left + right), 0.5 * (right - left).max(LEAST_WIDTH));
    let rect = Rect::from_x_y_ranges(middle - half..=middle + half, lane.bottom() - BLOCK - 1.0..=lane.bottom() - 1.0);
    if !rect.is_finite() || rect.right() < lane.left() || rect.left() > lane.right() {
        return;
    }
    let level = level(snapshot, window);
    let color = level.map_or(palette.ignored, |level| palette.of_level(level));
    let chosen = app.state.selection.is_selected(&window.name);
    draw_block(ui, rect, (level, color), chosen, palette);
    for part in &window.excluded {
        let x = [part.start_s, part.end_s].map(|time_s| x_at(lane, full, time_s));
        hatch(ui, Rect::from_x_y_ranges(x[0]..=x[1], rect.y_range()).intersect(rect));
    }
    let response = ui.interact(rect.expand2(vec2(1.0, 2.0)), Id::unique(("timeline", &window.name)), Sense::click());
    let response = response.on_hover_cursor(CursorIcon::PointingHand);
    let word = match level {
        Some(level) => level.name(),
        None if window.role == WindowRole::Ignored => "ignored",
        None => "not judged yet",
    };
    let name = format!("timeline {}: {word}", window.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let response = response.on_hover_text(format!("{}\n{}, {word}", window.name, window.role.name()));
    menu(app, &response, Some(window), (lane, full));
    if response.clicked() {
        let modifiers = ui.input(|input| input.modifiers);
        let session = Arc::clone(app.document.history.present());
        panels::select(&mut app.state, &session, &window.name, modifiers);
    }
    if response.double_clicked() {
        let room = 0.25 * window.window.length_s();
        app.state.time.zoom_to(TimeRange::new(window.window.start_s - room, window.window.end_s + room));
        app.state.show_pane(Pane::Flight);
    }
}

/// The menu of a manoeuvre of the strip, or of where there is none.
fn menu(app: &mut Workbench, response: &Response, window: Option<&Manoeuvre>, (frame, full): (Rect, TimeRange)) {
    let id = response.id.with("menu at");
    if response.secondary_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        response.ctx.data_mut(|data| data.insert_temp(id, time_at(frame, full, at.x)));
    }
    let session = Arc::clone(app.document.history.present());
    let markers_s = app.state.time.markers_s;
    let time_s = response.ctx.data(|data| data.get_temp(id));
    let snapshot = Arc::clone(app.snapshot());
    let flight = app.state.selection.flight.as_deref().unwrap_or_default();
    let of = OfFlight { session: &session, snapshot: &snapshot, flight };
    let candidate = time_s.filter(|_| window.is_none()).and_then(|time_s| of.candidate_at(time_s));
    let spot = Spot { session: &session, table: &app.table, window, candidate, time_s, markers_s };
    let mut chosen = None;
    response.context_menu(|ui| chosen = panels::mark_menu(ui, &spot));
    let Some(command) = chosen else {
        return;
    };
    if let Some(candidate) = candidate {
        app.state.candidate_s = Some(candidate.window.start_s);
    }
    if let Some(window) = window.filter(|window| !app.state.selection.is_selected(&window.name)) {
        panels::choose(&mut app.state, &session, &window.name);
    }
    app.state.at_s = time_s;
    app.commands.push(command);
}

fn draw_block(ui: &Ui, rect: Rect, (level, color): (Option<Level>, Color32), chosen: bool, palette: &Palette) {
    let fill = if chosen { color } else { color.gamma_multiply(0.75) };
    ui.painter().rect_filled(rect, CornerRadius::same(1), fill);
    if chosen {
        ui.painter().rect_stroke(rect.expand(1.0), 1.0, Stroke::new(1.5, palette.cursor), StrokeKind::Outside);
    }
    // What is not good has its shape above it: it reads without its colour.
    if matches!(level, Some(Level::Caution | Level::Bad)) {
        level_mark::paint(ui.painter(), pos2(rect.center().x, rect.top() - 4.0), 2.6, level, color);
    }
}
