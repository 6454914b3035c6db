//! What the pointer and the arrow keys do in a stack of time plots.

use doublet_engine::report::document::{Figure, Mark, Panel};
use eframe::egui::{self, Key, PointerButton, Rect, Stroke, Ui};

use super::figure::FigureForm;
use super::stack_figure::file_word;
use super::time_plot::{StackResponse, time_at};
use super::time_view::{TimeRange, TimeView};
use crate::theme;

/// Magnification per point of wheel travel.
const WHEEL_GAIN: f64 = 0.004;
/// A right drag shorter than this zooms nowhere.
const LEAST_BOX: f32 = 4.0;

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

/// Lets the pointer over one plot move the view; the time under the pointer.
pub(super) fn interact(
    ui: &Ui,
    response: &egui::Response,
    frame: Rect,
    view: &mut TimeView,
    out: &mut StackResponse,
) -> Option<f64> {
    let range = view.range();
    let s_per_point = range.length_s() / f64::from(frame.width());
    let (now_s, modifiers) = ui.input(|i| (i.time, i.modifiers));
    if response.dragged_by(PointerButton::Primary) {
        ui.set_cursor_icon(egui::CursorIcon::Grabbing);
        let by = f64::from(response.drag_delta().x);
        if by != 0.0 {
            view.pan(-by * s_per_point, now_s);
        }
    }
    if let Some(stretch) = box_stretch(ui, response, frame, view.range()) {
        view.zoom_to(stretch);
    }
    let pointer = response.hover_pos().filter(|at| frame.contains(*at))?;
    let here_s = time_at(frame, range, pointer.x);
    let (wheel, pinch) = ui.input_mut(|i| (std::mem::take(&mut i.smooth_scroll_delta), i.zoom_delta()));
    let along = if modifiers.shift { wheel.x + wheel.y } else { wheel.x };
    if along != 0.0 {
        view.pan(-f64::from(along) * s_per_point, now_s);
    } else if wheel.y != 0.0 {
        view.zoom((WHEEL_GAIN * f64::from(wheel.y)).exp(), here_s, now_s);
    }
    if pinch != 1.0 {
        view.zoom(f64::from(pinch), here_s, now_s);
    }
    if response.double_clicked() {
        view.home();
    } else if response.clicked() {
        match (modifiers.shift, modifiers.command) {
            (true, _) => view.markers_s[0] = Some(here_s),
            (_, true) => view.markers_s[1] = Some(here_s),
            _ => out.clicked_s = Some(here_s),
        }
    }
    Some(here_s)
}

/// Draws the box of a drag with the secondary button over `frame`, which shows `range`; the stretch it covered, once it ends.
pub(super) fn box_stretch(ui: &Ui, response: &egui::Response, frame: Rect, range: TimeRange) -> Option<TimeRange> {
    let dragged = response.dragged_by(PointerButton::Secondary);
    let stopped = response.drag_stopped_by(PointerButton::Secondary);
    if !dragged && !stopped {
        return None;
    }
    let id = response.id.with("box");
    let at = response.interact_pointer_pos()?;
    let pressed = ui.input(|i| i.pointer.press_origin()).unwrap_or(at);
    let origin = ui.data_mut(|data| *data.get_temp_mut_or_insert_with(id, || pressed));
    let rect = Rect::from_x_y_ranges(origin.x.min(at.x)..=origin.x.max(at.x), frame.y_range()).intersect(frame);
    if stopped {
        ui.data_mut(|data| data.remove::<egui::Pos2>(id));
        let edge = |x: f32| time_at(frame, range, x);
        return (rect.width() > LEAST_BOX).then(|| TimeRange::new(edge(rect.left()), edge(rect.right())));
    }
    let accent = theme::palette(ui).accent;
    ui.painter().rect_filled(rect, 0.0, accent.gamma_multiply(0.2));
    ui.painter().rect_stroke(rect, 0.0, Stroke::new(1.0, accent), egui::StrokeKind::Inside);
    None
}

/// Moves marker A with the arrow keys (with Shift: B) to the next or previous sample of `time_s`.
pub fn step_markers(ui: &Ui, view: &mut TimeView, time_s: &[f64]) {
    let (left, right, shift) =
        ui.input(|i| (i.key_pressed(Key::ArrowLeft), i.key_pressed(Key::ArrowRight), i.modifiers.shift));
    if left == right {
        return;
    }
    if let Some(marker) = &mut view.markers_s[usize::from(shift)] {
        let next = if right {
            time_s.get(time_s.partition_point(|t| t <= marker))
        } else {
            time_s.partition_point(|t| t < marker).checked_sub(1).map(|at| &time_s[at])
        };
        *marker = next.copied().unwrap_or(*marker);
    }
}

/// The menu of a plot: figures and numbers to take away, markers, zoom. `count`: plots of its stack.
pub(super) fn plot_menu(response: &egui::Response, frame: Rect, view: &mut TimeView, count: usize) -> Option<Wanted> {
    let mut wanted = None;
    let id = response.id.with("menu at");
    if response.secondary_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let here_s = time_at(frame, view.range(), at.x);
        response.ctx.data_mut(|data| data.insert_temp(id, here_s));
    }
    response.context_menu(|ui| {
        let here_s: f64 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let all = |ui: &mut Ui, of: FigureOf, wanted: &mut Option<Wanted>| {
            for (form, name) in FigureForm::ALL {
                if ui.button(name).clicked() {
                    *wanted = Some((of, form));
                    ui.close();
                }
            }
        };
        if count > 1 {
            ui.menu_button("This plot", |ui| all(ui, FigureOf::Plot, &mut wanted));
            ui.menu_button(format!("All {count} plots"), |ui| all(ui, FigureOf::Stack, &mut wanted));
        } else {
            all(ui, FigureOf::Stack, &mut wanted);
        }
        ui.separator();
        for (at, name) in ["Set marker A here", "Set marker B here"].into_iter().enumerate() {
            if ui.button(name).clicked() {
                view.markers_s[at] = Some(here_s);
                ui.close();
            }
        }
        if ui.add_enabled(view.markers_s != [None; 2], egui::Button::new("Clear markers")).clicked() {
            view.markers_s = [None; 2];
            ui.close();
        }
        ui.separator();
        if ui.button("Show all").clicked() {
            view.home();
            ui.close();
        }
        if ui.button("Zoom back").clicked() {
            view.go_back();
            ui.close();
        }
        if ui.button("Zoom forward").clicked() {
            view.go_forward();
            ui.close();
        }
    });
    wanted
}
