//! Spans of time on a lane above the plots: click selects, the body moves, the edges resize, snapped to moments that mean something and
//! else to samples.

use eframe::egui::{
    self, Align2, Color32, CornerRadius, CursorIcon, Id, Key, PointerButton, Rect, Role, Sense, Stroke, StrokeKind, Ui,
    WidgetInfo, pos2,
};

use super::EditPhase;
use super::hatch::hatch;
use super::pointer::box_part;
use super::snap::{SNAP_REACH, SnapPoint, to_point};
use super::time_plot::{time_at, x_at};
use super::time_view::TimeRange;
use crate::theme;

/// Height of the lane the spans lie in.
pub const LANE_HEIGHT: f32 = 24.0;
/// Height of the strip on a span that shares time with another.
const OVERLAP_HEIGHT: f32 = 3.0;
/// Half the width in which an edge can be caught.
const EDGE_REACH: f32 = 5.0;
/// A span narrower than this can be selected but neither moved nor resized: a drag would do more than it seems.
const LEAST_WIDTH: f32 = 12.0;

/// A span as the lane shows it.
#[derive(Clone, Copy, Debug)]
pub struct SpanItem<'a> {
    /// Identity that survives edits.
    pub id: u64,
    /// Where it is.
    pub part: TimeRange,
    /// Text in the lane.
    pub label: &'a str,
    /// What hovering says about it; may be empty.
    pub note: &'a str,
    /// Parts of it that are left out, hatched.
    pub excluded: &'a [TimeRange],
    /// Colour of its role.
    pub color: Color32,
    /// Can be selected but not moved.
    pub still: bool,
    /// Locked by the user: marked, and its menu frees it.
    pub locked: bool,
    /// Drawn strongly; its edges can be caught in the plots too.
    pub selected: bool,
    /// It shares time with another span.
    pub overlaps: bool,
}

/// What the user did to the spans this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpanEvent {
    /// A span was clicked.
    Selected(u64),
    /// A span is being moved or resized; `part` is where it is now (where it was, for `Begin` and `Cancel`).
    Dragged {
        id: u64,
        /// Where the drag stands.
        phase: EditPhase,
        /// Where the span is.
        part: TimeRange,
    },
    /// A new span was drawn in the empty lane.
    Drawn(TimeRange),
    /// This part was covered with the secondary button: to be zoomed to, as everywhere in the plots.
    Zoomed(TimeRange),
}

/// The part of a span that is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Grip {
    /// All of it.
    Body,
    Start,
    End,
}

/// Where the spans are edited.
#[derive(Clone, Copy, Debug)]
pub struct Lane<'a> {
    /// Where the lane is on screen.
    pub rect: Rect,
    /// A frame of the stack: its left and right ends are those of `range`.
    pub frame: Rect,
    /// Down to here the edges of the selected span can be caught.
    pub reach_bottom: f32,
    /// The part on screen.
    pub range: TimeRange,
    /// Times of the samples, increasing, s; empty snaps to nothing.
    pub samples_s: &'a [f64],
    /// Moments the edges are drawn to, unless Alt is held.
    pub points: &'a [SnapPoint],
}

/// What is held.
#[derive(Clone, Copy)]
struct Held {
    origin: TimeRange,
    pressed_s: f64,
    now: TimeRange,
}

/// The sample nearest to `time_s`; `time_s` itself when there are no samples.
pub fn snapped(samples_s: &[f64], time_s: f64) -> f64 {
    let after = samples_s.partition_point(|&t| t < time_s);
    match (after.checked_sub(1).map(|at| samples_s[at]), samples_s.get(after).copied()) {
        (Some(before), Some(after)) => {
            if time_s - before < after - time_s {
                before
            } else {
                after
            }
        }
        (Some(only), None) | (None, Some(only)) => only,
        (None, None) => time_s,
    }
}

/// Where a span that was at `origin` is after `grip` moved by `by_s`: on samples, never empty, and with its count of
/// samples kept when the whole span moves.
pub fn dragged(origin: TimeRange, grip: Grip, by_s: f64, samples_s: &[f64]) -> TimeRange {
    let index = |time_s: f64| samples_s.partition_point(|&t| t < time_s);
    let TimeRange { start_s, end_s } = origin;
    match grip {
        Grip::Body if samples_s.is_empty() => TimeRange { start_s: start_s + by_s, end_s: end_s + by_s },
        Grip::Body => {
            let (first, last) = (index(snapped(samples_s, start_s)), index(snapped(samples_s, end_s)));
            let moved = index(snapped(samples_s, start_s + by_s)).min(samples_s.len() - 1 - (last - first));
            TimeRange { start_s: samples_s[moved], end_s: samples_s[moved + last - first] }
        }
        Grip::Start => {
            let latest = samples_s[..index(end_s)].last().copied().unwrap_or(end_s);
            TimeRange { start_s: snapped(samples_s, start_s + by_s).min(latest), end_s }
        }
        Grip::End => {
            let earliest = samples_s.get(samples_s.partition_point(|&t| t <= start_s)).copied().unwrap_or(start_s);
            TimeRange { start_s, end_s: snapped(samples_s, end_s + by_s).max(earliest) }
        }
    }
}

/// Draws the lane and reports what the user did. Escape gives a drag up.
pub fn span_lane(ui: &mut Ui, id: Id, lane: &Lane<'_>, spans: &[SpanItem<'_>]) -> Option<SpanEvent> {
    let visuals = ui.visuals();
    let clip = Rect::from_x_y_ranges(lane.frame.x_range(), lane.rect.y_range());
    ui.painter().rect_filled(clip, CornerRadius::same(3), visuals.faint_bg_color);
    let mut event = draw_new(ui, id.with("empty"), lane, clip);
    for span in spans {
        let shown = Rect::from_x_y_ranges(
            x_at(lane.frame, lane.range, span.part.start_s)..=x_at(lane.frame, lane.range, span.part.end_s),
            clip.y_range().shrink(2.0),
        );
        if shown.right() < clip.left() - EDGE_REACH || shown.left() > clip.right() + EDGE_REACH {
            continue;
        }
        draw_span(ui, (clip, shown), lane, span);
        event = catch(ui, id, lane, clip, shown, span).or(event);
    }
    event
}

/// Fill, outline and text of one span.
fn draw_span(ui: &Ui, (clip, shown): (Rect, Rect), lane: &Lane<'_>, span: &SpanItem<'_>) {
    let painter = ui.painter().with_clip_rect(clip);
    let (fill, line) = if span.selected { (0.75, 1.0) } else { (0.40, 0.7) };
    let corner = CornerRadius::same(3);
    painter.rect_filled(shown, corner, span.color.gamma_multiply(fill));
    for part in span.excluded {
        let x = [part.start_s, part.end_s].map(|time_s| x_at(lane.frame, lane.range, time_s));
        hatch(ui, Rect::from_x_y_ranges(x[0]..=x[1], shown.y_range()).intersect(clip));
    }
    painter.rect_stroke(shown, corner, Stroke::new(1.0, span.color.gamma_multiply(line)), StrokeKind::Inside);
    if span.overlaps {
        let strip = Rect::from_x_y_ranges(shown.x_range(), shown.top()..=shown.top() + OVERLAP_HEIGHT);
        painter.rect_filled(strip, CornerRadius::ZERO, theme::palette(ui).error);
    }
    let text = ui.visuals().strong_text_color();
    let visible = shown.intersect(clip);
    let label = format!("{}{}", if span.locked { "🔒 " } else { "" }, span.label);
    let galley = painter.layout_no_wrap(label, egui::FontId::proportional(11.0), text);
    if galley.size().x + 8.0 < visible.width() {
        let at = Align2::CENTER_CENTER.anchor_size(visible.center(), galley.size());
        painter.galley(at.min, galley, text);
    }
}

/// Body and edges of one span under the pointer.
fn catch(ui: &mut Ui, id: Id, lane: &Lane<'_>, clip: Rect, shown: Rect, span: &SpanItem<'_>) -> Option<SpanEvent> {
    let grab = |x: f32, inner: f32, outer: f32| {
        let bottom = if span.selected { lane.reach_bottom } else { clip.bottom() };
        Rect::from_x_y_ranges(x - inner..=x + outer, clip.top()..=bottom)
    };
    let inside = EDGE_REACH.min(shown.width() / 3.0);
    let parts = [
        (Grip::Body, shown.intersect(clip), ""),
        (Grip::Start, grab(shown.left(), EDGE_REACH, inside), " start"),
        (Grip::End, grab(shown.right(), inside, EDGE_REACH), " end"),
    ];
    let grip_id = |grip: Grip| id.with((span.id, grip));
    let is_held = |grip| ui.data(|data| data.get_temp::<Held>(grip_id(grip)).is_some());
    let held = [Grip::Body, Grip::Start, Grip::End].into_iter().any(is_held);
    // A drag under way goes on however narrow it makes the span.
    let still = span.still || span.locked || (shown.width() < LEAST_WIDTH && !held);
    let mut event = None;
    for (grip, rect, suffix) in parts {
        let on_screen = rect.center().x >= clip.left() - 1.0 && rect.center().x <= clip.right() + 1.0;
        if !on_screen || (still && grip != Grip::Body) || !rect.is_positive() {
            continue;
        }
        // A drag of a locked span is taken and comes to nothing: below it a new span would be drawn.
        let rect = if span.locked && !span.still { rect.expand2(egui::vec2(EDGE_REACH, 0.0)) } else { rect };
        let sense = if span.still { Sense::click() } else { Sense::click_and_drag() };
        let key = grip_id(grip);
        let response = ui.interact(rect, key, sense).on_hover_cursor(match grip {
            Grip::Body if still => CursorIcon::PointingHand,
            Grip::Body => CursorIcon::Grab,
            Grip::Start | Grip::End => CursorIcon::ResizeHorizontal,
        });
        let name = format!("{}{suffix}", span.label);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
        let response = if span.note.is_empty() { response } else { response.on_hover_text(span.note) };
        if response.clicked() {
            event = Some(SpanEvent::Selected(span.id));
        }
        event = zoom(ui, &response, lane).or(event);
        if !still {
            event = drag(ui, &response, key, lane, grip, span).or(event);
        }
    }
    event
}

/// A drag with the secondary button zooms, here as in the plots.
fn zoom(ui: &Ui, response: &egui::Response, lane: &Lane<'_>) -> Option<SpanEvent> {
    let area = Rect::from_x_y_ranges(lane.frame.x_range(), lane.rect.top()..=lane.reach_bottom);
    box_part(ui, response, area, lane.range).map(SpanEvent::Zoomed)
}

/// What the body of a span in the lane `id` is called by: its menu is that of the panel.
pub fn body_id(id: Id, span: u64) -> Id {
    id.with((span, Grip::Body))
}

/// One drag from press to release.
fn drag(
    ui: &mut Ui,
    response: &egui::Response,
    key: Id,
    lane: &Lane<'_>,
    grip: Grip,
    span: &SpanItem<'_>,
) -> Option<SpanEvent> {
    let report = |phase, part| Some(SpanEvent::Dragged { id: span.id, phase, part });
    let pointer = response.interact_pointer_pos();
    if response.drag_started_by(PointerButton::Primary) {
        let pressed = ui.input(|i| i.pointer.press_origin()).or(pointer)?;
        let pressed_s = time_at(lane.frame, lane.range, pressed.x);
        let held = Held { origin: span.part, pressed_s, now: span.part };
        ui.data_mut(|data| data.insert_temp(key, held));
        return report(EditPhase::Begin, span.part);
    }
    let held = ui.data_mut(|data| data.get_temp::<Held>(key))?;
    let forget = || ui.data_mut(|data| data.remove::<Held>(key));
    if ui.input(|i| i.key_pressed(Key::Escape)) {
        forget();
        ui.ctx().stop_dragging();
        return report(EditPhase::Cancel, held.origin);
    }
    if response.drag_stopped() || !response.dragged() {
        forget();
        return report(EditPhase::Commit, held.now);
    }
    ui.set_cursor_icon(if grip == Grip::Body { CursorIcon::Grabbing } else { CursorIcon::ResizeHorizontal });
    let by_s = time_at(lane.frame, lane.range, pointer?.x) - held.pressed_s;
    let now = match near_point(ui, lane, grip, (held.origin, by_s)) {
        Some((now, point)) => {
            draw_point(ui, lane, point);
            now
        }
        None => dragged(held.origin, grip, by_s, lane.samples_s),
    };
    let (edge_s, length) = (if grip == Grip::End { now.end_s } else { now.start_s }, now.length_s());
    let x = x_at(lane.frame, lane.range, edge_s);
    draw_words(ui, lane, x, (format!("{edge_s:.2} s, {length:.2} s long"), 40.0));
    if now == held.now {
        return None;
    }
    ui.data_mut(|data| data.insert_temp(key, Held { now, ..held }));
    report(EditPhase::Change, now)
}

/// Where the moment the drag is drawn to puts the span, unless Alt is held.
fn near_point(
    ui: &Ui,
    lane: &Lane<'_>,
    grip: Grip,
    (origin, by_s): (TimeRange, f64),
) -> Option<(TimeRange, SnapPoint)> {
    if ui.input(|i| i.modifiers.alt) {
        return None;
    }
    let [first, .., last] = *lane.samples_s else { return None };
    let reach_s = f64::from(SNAP_REACH / lane.frame.width()) * lane.range.length_s();
    to_point(origin, grip, by_s, lane.points, (reach_s, TimeRange { start_s: first, end_s: last }))
}

/// A thin line at the moment a drag is drawn to, with its word at the top of the plots.
fn draw_point(ui: &mut Ui, lane: &Lane<'_>, point: SnapPoint) {
    let x = x_at(lane.frame, lane.range, point.time_s);
    let ink = ui.visuals().strong_text_color();
    ui.painter().vline(x, lane.rect.top()..=lane.reach_bottom, Stroke::new(1.0, ink));
    draw_words(ui, lane, x, (point.word.to_owned(), 22.0));
}

/// Words beside the line at `x`, on the side that has room, so far below the head of the plots.
fn draw_words(ui: &mut Ui, lane: &Lane<'_>, x: f32, (words, below): (String, f32)) {
    let ink = ui.visuals().strong_text_color();
    let galley = ui.painter().layout_no_wrap(words, egui::FontId::proportional(11.0), ink);
    let size = galley.size() + egui::vec2(6.0, 2.0);
    let left = if x + size.x + 2.0 < lane.frame.right() { x + 2.0 } else { x - size.x - 2.0 };
    let ground = Rect::from_min_size(pos2(left, lane.frame.top() + below), size);
    ui.painter().rect_filled(ground, CornerRadius::same(3), ui.visuals().extreme_bg_color);
    let mut over = ui.new_child(egui::UiBuilder::new().max_rect(ground.shrink2(egui::vec2(3.0, 1.0))));
    over.add(egui::Label::new(galley).selectable(false));
}

/// A drag in the empty lane draws a new span.
fn draw_new(ui: &Ui, id: Id, lane: &Lane<'_>, clip: Rect) -> Option<SpanEvent> {
    let response = ui.interact(clip, id, Sense::drag()).on_hover_cursor(CursorIcon::Crosshair);
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Draw a new manoeuvre"));
    if let Some(event) = zoom(ui, &response, lane) {
        return Some(event);
    }
    if response.drag_started_by(PointerButton::Primary) {
        let from = ui.input(|i| i.pointer.press_origin())?;
        ui.data_mut(|data| data.insert_temp(id, from.x));
    }
    let from = ui.data_mut(|data| data.get_temp::<f32>(id))?;
    let to = response.interact_pointer_pos().map_or(from, |at| at.x.clamp(clip.left(), clip.right()));
    if ui.input(|i| i.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.remove::<f32>(id));
        ui.ctx().stop_dragging();
        return None;
    }
    if response.drag_stopped() {
        ui.data_mut(|data| data.remove::<f32>(id));
        let edge = |x: f32| snapped(lane.samples_s, time_at(lane.frame, lane.range, x));
        let drawn = TimeRange::new(edge(from), edge(to));
        return (drawn.length_s() > 0.0 && (to - from).abs() > EDGE_REACH).then_some(SpanEvent::Drawn(drawn));
    }
    let rect = Rect::from_two_pos(pos2(from, clip.top() + 2.0), pos2(to, clip.bottom() - 2.0));
    ui.painter().rect_filled(rect, CornerRadius::same(3), ui.visuals().selection.bg_fill);
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Vec<f64> {
        (0..=1000).map(|k| f64::from(k) * 0.1).collect()
    }

    #[test]
    fn snapping_takes_the_nearest_sample_and_stays_inside() {
        let samples = samples();
        assert_eq!(snapped(&samples, 5.04), samples[50]);
        assert_eq!(snapped(&samples, 5.06), samples[51]);
        assert_eq!(snapped(&samples, -3.0), 0.0);
        assert_eq!(snapped(&samples, 1e9), samples[1000]);
        assert_eq!(snapped(&[], 1.23), 1.23);
    }

    #[test]
    fn edges_move_to_samples_and_never_cross() {
        let samples = samples();
        let origin = TimeRange { start_s: samples[100], end_s: samples[200] };
        assert_eq!(dragged(origin, Grip::Start, 1.234, &samples), TimeRange { start_s: samples[112], ..origin });
        assert_eq!(dragged(origin, Grip::Start, 500.0, &samples), TimeRange { start_s: samples[199], ..origin });
        assert_eq!(dragged(origin, Grip::End, -500.0, &samples), TimeRange { end_s: samples[101], ..origin });
        assert_eq!(dragged(origin, Grip::End, 500.0, &samples), TimeRange { end_s: samples[1000], ..origin });
    }

    #[test]
    fn moving_keeps_the_number_of_samples_up_to_the_ends() {
        let samples = samples();
        let origin = TimeRange { start_s: samples[100], end_s: samples[200] };
        for (by_s, first) in [(0.26, 103), (-0.26, 97), (1e6, 900), (-1e6, 0)] {
            let moved = dragged(origin, Grip::Body, by_s, &samples);
            assert_eq!(moved, TimeRange { start_s: samples[first], end_s: samples[first + 100] }, "by {by_s} s");
        }
        assert_eq!(dragged(origin, Grip::Body, 0.123, &[]).start_s, samples[100] + 0.123);
    }
}
