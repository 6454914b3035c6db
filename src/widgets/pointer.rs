//! What the pointer and the arrow keys do in a stack of time plots.

use doublet_engine::report::document::{Figure, Mark, Panel};
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, PointerButton, Rect, Stroke, Ui};

use super::figure::{FigureForm, FigureRequest};
use super::stack_figure::file_word;
use super::time_plot::time_at;
use super::time_view::{TimeRange, TimeView};
use crate::theme;

/// Magnification per point of wheel travel.
const WHEEL_GAIN: f64 = 0.004;
/// Magnification per point of a drag on an axis.
const AXIS_GAIN: f64 = 0.01;
/// A right drag shorter than this zooms nowhere; one less high than the second leaves the values as they are, one less wide the time.
const LEAST_BOX: f32 = 4.0;
const FLAT: f32 = 14.0;

/// A figure asked for in a menu: what of, and as what.
pub(super) type Wanted = (FigureOf, FigureForm);

/// What a figure is asked for of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FigureOf {
    /// All plots of the stack.
    Stack,
    /// The plot the menu belongs to.
    Plot,
}

impl FigureOf {
    /// The part of the figure of a stack that is meant by the menu of its plot `row`.
    pub(super) fn part(self, figure: Figure, row: usize) -> Figure {
        match self {
            Self::Stack => figure,
            Self::Plot => {
                let panels: Vec<Panel> = figure.panels.into_iter().skip(row).take(1).collect();
                let name = panels.first().map_or_else(String::new, |panel| file_word(&quantity(panel)));
                Figure { name, panels, ..figure }
            }
        }
    }
}

/// What a plot shows: its label without the unit, or its curves where it has no label.
fn quantity(panel: &Panel) -> String {
    let bare = |text: &str| text.split('[').next().unwrap_or_default().trim().to_owned();
    let Panel::Plot(plot) = panel else { return String::new() };
    let label = bare(&plot.y.label);
    if !label.is_empty() {
        return label;
    }
    let name = |mark: &Mark| if let Mark::Line { label, .. } = mark { Some(bare(label)) } else { None };
    plot.marks.iter().filter_map(name).collect::<Vec<_>>().join(" ")
}

/// What the pointer did to the values of one plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Values {
    /// They show this part from now on.
    Range(f64, f64),
    /// Those of the whole stack are fitted to what is visible.
    Fit,
}

/// A plot under the pointer: where it is, and the values at its foot and its head.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) frame: Rect,
    pub(super) values: (f64, f64),
}

impl Area {
    /// Value at the screen position `y`.
    fn value_at(&self, y: f32) -> f64 {
        let (low, high) = self.values;
        low + (high - low) * f64::from((self.frame.bottom() - y) / self.frame.height())
    }

    /// Values magnified by `factor` about the screen position `y`.
    fn zoomed(&self, factor: f64, y: f32) -> Values {
        let (about, (low, high)) = (self.value_at(y), self.values);
        Values::Range(about + (low - about) / factor, about + (high - about) / factor)
    }
}

/// What the pointer did in a stack this frame.
#[derive(Clone, Debug, Default)]
pub struct StackResponse {
    /// Time of a plain click, s.
    pub clicked_s: Option<f64>,
    /// Time under the pointer, s.
    pub hovered_s: Option<f64>,
    /// Index of the plot under the pointer.
    pub hovered_plot: Option<usize>,
    /// What of the plots is on screen: a stack that is higher scrolls.
    pub visible: Option<Rect>,
    /// Where the data area of every plot is on screen, from the left end of the range to its right end.
    pub frames: Vec<Rect>,
    /// Values at the foot and at the head of every data area, in the unit of its plot.
    pub values: Vec<(f64, f64)>,
    /// A figure asked for in the menu of a plot.
    pub figure: Option<FigureRequest>,
    /// What a drag with Ctrl or Alt marks.
    pub marked: Option<Marked>,
    /// Whether the values of the plot at hand are chosen by hand.
    pub(super) zoomed: bool,
}

/// More entries of the menu of a plot, opened at a time, s.
pub type PlotMenu<'m> = &'m mut dyn FnMut(&mut Ui, f64);

/// The same of a stack: with the row of the plot.
pub type StackMenu<'m> = &'m mut dyn FnMut(&mut Ui, f64, usize);

/// What a drag marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// A manoeuvre: with Ctrl.
    Manoeuvre,
    /// A part that is left out: with Alt.
    Excluded,
    /// A part that is taken in again: with Alt and Shift.
    Included,
}

/// A drag that marks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marked {
    pub kind: MarkKind,
    /// Where it began, s.
    pub from_s: f64,
    /// What it covers.
    pub part: TimeRange,
    /// Whether it has ended.
    pub is_done: bool,
}

/// A drag of the primary button with Ctrl or Alt marks a part of time; Escape gives it up.
pub fn mark(ui: &Ui, response: &egui::Response, frame: Rect, range: TimeRange) -> Option<Marked> {
    let id = response.id.with("mark");
    if response.drag_started_by(PointerButton::Primary) {
        let modifiers = ui.input(|input| input.modifiers);
        let kind = match (modifiers.command, modifiers.alt, modifiers.shift) {
            (true, false, _) => MarkKind::Manoeuvre,
            (false, true, false) => MarkKind::Excluded,
            (false, true, true) => MarkKind::Included,
            _ => return None,
        };
        let pressed = ui.input(|input| input.pointer.press_origin()).or(response.interact_pointer_pos())?;
        ui.data_mut(|data| data.insert_temp(id, (kind, time_at(frame, range, pressed.x))));
    }
    let (kind, from_s): (MarkKind, f64) = ui.data(|data| data.get_temp(id))?;
    let is_done = response.drag_stopped();
    let at = response.interact_pointer_pos();
    // Escape ends a drag before it comes here; a drag that ends without a release was given up.
    let (escape, released) = ui.input(|input| (input.key_pressed(Key::Escape), input.pointer.any_released()));
    let given_up = escape || (is_done && !released);
    if is_done || given_up || at.is_none() {
        ui.data_mut(|data| data.remove::<(MarkKind, f64)>(id));
    }
    if given_up {
        ui.ctx().stop_dragging();
        return None;
    }
    ui.set_cursor_icon(egui::CursorIcon::Crosshair);
    let to_s = time_at(frame, range, at?.x.clamp(frame.left(), frame.right()));
    Some(Marked { kind, from_s, part: TimeRange::new(from_s, to_s), is_done })
}

/// Lets the pointer over one plot move the view; the time under the pointer, and what becomes of the values.
pub(super) fn interact(
    ui: &Ui,
    response: &egui::Response,
    area: Area,
    view: &mut TimeView,
    out: &mut StackResponse,
) -> (Option<f64>, Option<Values>) {
    let (frame, range) = (area.frame, view.range());
    let s_per_point = range.length_s() / f64::from(frame.width());
    let (now_s, modifiers) = ui.input(|i| (i.time, i.modifiers));
    let mut values = None;
    let marked = mark(ui, response, frame, range);
    if marked.is_some() {
        out.marked = marked;
    } else if response.dragged_by(PointerButton::Primary) || response.dragged_by(PointerButton::Middle) {
        ui.set_cursor_icon(egui::CursorIcon::Grabbing);
        let by = response.drag_delta();
        if by.x != 0.0 {
            view.pan(-f64::from(by.x) * s_per_point, now_s);
        }
        if by.y != 0.0 && out.zoomed {
            let (low, high) = area.values;
            let up = (high - low) * f64::from(by.y / frame.height());
            values = Some(Values::Range(low + up, high + up));
        }
    }
    if let Some(zoomed) = box_zoom(ui, response, frame) {
        let edge = |x: f32| time_at(frame, range, x);
        if zoomed.width() < frame.width() {
            view.zoom_to(TimeRange::new(edge(zoomed.left()), edge(zoomed.right())));
        }
        if zoomed.height() < frame.height() {
            values = Some(Values::Range(area.value_at(zoomed.bottom()), area.value_at(zoomed.top())));
        }
    }
    let Some(pointer) = response.hover_pos().filter(|at| frame.contains(*at)) else { return (None, values) };
    let here_s = time_at(frame, range, pointer.x);
    let (wheel, pinch) = ui.input_mut(|i| (std::mem::take(&mut i.smooth_scroll_delta), i.zoom_delta()));
    if modifiers.shift && wheel.x + wheel.y != 0.0 {
        values = Some(area.zoomed((WHEEL_GAIN * f64::from(wheel.x + wheel.y)).exp(), pointer.y));
    } else if wheel.x != 0.0 {
        view.pan(-f64::from(wheel.x) * s_per_point, now_s);
    } else if wheel.y != 0.0 {
        view.zoom((WHEEL_GAIN * f64::from(wheel.y)).exp(), here_s, now_s);
    }
    if pinch != 1.0 {
        view.zoom(f64::from(pinch), here_s, now_s);
    }
    set_markers(ui, view, here_s);
    if response.double_clicked() {
        view.home();
        values = Some(Values::Fit);
    } else if response.clicked() {
        match (modifiers.shift, modifiers.command) {
            (true, _) => view.markers_s[0] = Some(here_s),
            (_, true) => view.markers_s[1] = Some(here_s),
            _ => out.clicked_s = Some(here_s),
        }
    }
    (Some(here_s), values)
}

/// The keys A and B set the markers under the pointer.
fn set_markers(ui: &Ui, view: &mut TimeView, here_s: f64) {
    if ui.ctx().egui_wants_keyboard_input() {
        return;
    }
    let pressed = ui.input(|i| [Key::A, Key::B].map(|key| i.modifiers.is_none() && i.key_pressed(key)));
    for (marker, _) in view.markers_s.iter_mut().zip(pressed).filter(|(_, pressed)| *pressed) {
        *marker = Some(here_s);
    }
}

/// A drag on the value axis left of a plot zooms its values, a double click fits them.
pub(super) fn value_axis(ui: &Ui, id: egui::Id, width: f32, area: Area) -> Option<Values> {
    let frame = area.frame;
    let axis = Rect::from_x_y_ranges(frame.left() - width..=frame.left() - 1.0, frame.y_range());
    let response = ui.interact(axis, id, egui::Sense::click_and_drag());
    let response = response.on_hover_cursor(egui::CursorIcon::ResizeVertical);
    let by = response.drag_delta().y;
    if response.double_clicked() {
        Some(Values::Fit)
    } else if response.dragged() && by != 0.0 {
        Some(area.zoomed((AXIS_GAIN * f64::from(by)).exp(), frame.center().y))
    } else {
        None
    }
}

/// A drag on the time axis zooms time about its middle, a double click shows everything.
pub(super) fn time_axis(ui: &Ui, id: egui::Id, axis: Rect, view: &mut TimeView) {
    let response = ui.interact(axis, id, egui::Sense::click_and_drag());
    let response = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
    let by = response.drag_delta().x;
    if response.double_clicked() {
        view.home();
    } else if response.dragged() && by != 0.0 {
        let range = view.range();
        let middle_s = 0.5 * (range.start_s + range.end_s);
        view.zoom((AXIS_GAIN * f64::from(by)).exp(), middle_s, ui.input(|i| i.time));
    }
}

/// Draws the box of a drag with the secondary button over `frame`; what it covered, once it ends. A drag that is nearly level covers
/// the whole height, one that is nearly upright the whole width.
fn box_zoom(ui: &Ui, response: &egui::Response, frame: Rect) -> Option<Rect> {
    let dragged = response.dragged_by(PointerButton::Secondary);
    let stopped = response.drag_stopped_by(PointerButton::Secondary);
    if !dragged && !stopped {
        return None;
    }
    let id = response.id.with("box");
    let at = response.interact_pointer_pos()?;
    let pressed = ui.input(|i| i.pointer.press_origin()).unwrap_or(at);
    let origin = ui.data_mut(|data| *data.get_temp_mut_or_insert_with(id, || pressed));
    let covered = Rect::from_two_pos(origin, at);
    let width = if covered.width() < FLAT && covered.height() >= FLAT { frame.x_range() } else { covered.x_range() };
    let height = if covered.height() < FLAT { frame.y_range() } else { covered.y_range() };
    let rect = Rect::from_x_y_ranges(width, height).intersect(frame);
    if stopped {
        ui.data_mut(|data| data.remove::<egui::Pos2>(id));
        return (covered.width().max(covered.height()) > LEAST_BOX).then_some(rect);
    }
    let accent = theme::palette(ui).accent;
    ui.painter().rect_filled(rect, 0.0, accent.gamma_multiply(0.2));
    ui.painter().rect_stroke(rect, 0.0, Stroke::new(1.0, accent), egui::StrokeKind::Inside);
    None
}

/// The same where there is only time: the part a drag covered, once it ends.
pub(super) fn box_part(ui: &Ui, response: &egui::Response, frame: Rect, range: TimeRange) -> Option<TimeRange> {
    let zoomed = box_zoom(ui, response, frame).filter(|zoomed| zoomed.width() < frame.width())?;
    Some(TimeRange::new(time_at(frame, range, zoomed.left()), time_at(frame, range, zoomed.right())))
}

/// Part of what is on screen that a marker moves by with Ctrl and an arrow key.
const LEAP: f64 = 0.01;

/// Moves marker A with the arrow keys (with Shift: B) to the next or previous sample of `time_s`, with Ctrl by a hundredth of what is on
/// screen. Without the pointer in a plot the keys A and B set the markers in its middle.
pub fn step_markers(ui: &Ui, view: &mut TimeView, time_s: &[f64]) {
    let range = view.range();
    if view.cursor_s.is_none() {
        set_markers(ui, view, 0.5 * (range.start_s + range.end_s));
    }
    let (left, right, modifiers) =
        ui.input(|i| (i.key_pressed(Key::ArrowLeft), i.key_pressed(Key::ArrowRight), i.modifiers));
    if left == right || modifiers.alt {
        return;
    }
    if let Some(marker) = &mut view.markers_s[usize::from(modifiers.shift)] {
        let leap_s = if modifiers.command { LEAP * range.length_s() } else { 0.0 };
        let next = if right {
            time_s.get(time_s.partition_point(|t| *t <= *marker + leap_s)).or(time_s.last())
        } else {
            time_s.partition_point(|t| *t < *marker - leap_s).checked_sub(1).map_or(time_s.first(), |at| time_s.get(at))
        };
        *marker = next.copied().unwrap_or(*marker);
    }
}

/// The forms in which a figure is taken away.
fn figure_forms(ui: &mut Ui, of: FigureOf, wanted: &mut Option<Wanted>) {
    for (form, name) in FigureForm::ALL {
        if ui.button(name).clicked() {
            *wanted = Some((of, form));
            ui.close();
        }
    }
}

/// The menu of a plot: figures and numbers to take away, markers, zoom, and `more`. `count`: plots of its stack.
pub(super) fn plot_menu(
    response: &egui::Response,
    frame: Rect,
    view: &mut TimeView,
    (count, more): (usize, PlotMenu<'_>),
) -> Option<Wanted> {
    let mut wanted = None;
    // Ctrl+C takes a picture of what is under the pointer, with Shift its numbers.
    if response.hovered() && response.ctx.input(|i| i.events.contains(&egui::Event::Copy)) {
        let numbers = response.ctx.input(|i| i.modifiers.shift);
        wanted = Some((FigureOf::Plot, if numbers { FigureForm::Copy } else { FigureForm::CopyPicture }));
    }
    let id = response.id.with("menu at");
    if response.secondary_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let here_s = time_at(frame, view.range(), at.x);
        response.ctx.data_mut(|data| data.insert_temp(id, here_s));
    }
    response.context_menu(|ui| {
        let here_s: f64 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        more(ui, here_s);
        if count > 1 {
            ui.menu_button("This plot", |ui| figure_forms(ui, FigureOf::Plot, &mut wanted));
            ui.menu_button(format!("All {count} plots"), |ui| figure_forms(ui, FigureOf::Stack, &mut wanted));
        } else {
            figure_forms(ui, FigureOf::Stack, &mut wanted);
        }
        ui.separator();
        let with_keys = |ui: &Ui, name: &'static str, modifiers, key| {
            egui::Button::new(name).shortcut_text(ui.ctx().format_shortcut(&KeyboardShortcut::new(modifiers, key)))
        };
        for (at, (name, key)) in [("Set marker A here", Key::A), ("Set marker B here", Key::B)].into_iter().enumerate()
        {
            if ui.add(with_keys(ui, name, Modifiers::NONE, key)).clicked() {
                view.markers_s[at] = Some(here_s);
                ui.close();
            }
        }
        let clear = with_keys(ui, "Clear markers", Modifiers::NONE, Key::Escape);
        if ui.add_enabled(view.markers_s != [None; 2], clear).clicked() {
            view.markers_s = [None; 2];
            ui.close();
        }
        if ui.add(with_keys(ui, "Annotate here…", Modifiers::NONE, Key::T)).clicked() {
            view.annotate_s = Some(here_s);
            ui.close();
        }
        ui.separator();
        if ui.add(with_keys(ui, "Show all", Modifiers::NONE, Key::Home)).clicked() {
            view.home();
            ui.close();
        }
        if ui.add(with_keys(ui, "Zoom back", Modifiers::NONE, Key::Backspace)).clicked() {
            view.go_back();
            ui.close();
        }
        if ui.add(with_keys(ui, "Zoom forward", Modifiers::ALT, Key::ArrowRight)).clicked() {
            view.go_forward();
            ui.close();
        }
    });
    wanted
}
