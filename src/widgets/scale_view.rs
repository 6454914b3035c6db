//! A view of things to scale, in which what has a handle is dragged.

use doublet_engine::report::document::{Axis, Figure, LineStyle, Mark, Panel, Plot};
use doublet_report::svg::axis::{ROUND, multiples, step_of};
use eframe::egui::{
    self, Align2, Color32, CursorIcon, FontId, Id, Key, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2,
};

use super::EditPhase;
use super::chart::figure_menu;
use super::figure::{FigureRequest, printed};
use super::quantity_edit::to_decimals;
use super::stack_figure::WIDTH_MM;
use super::ticks::tick;
use crate::theme;

/// Part of the room left free around everything.
const MARGIN: f64 = 0.07;
/// Room for the numbers of the axes, points.
const AXIS: [f32; 2] = [34.0, 30.0];
/// Size of what is taken hold of around a handle, points.
const GRIP: f32 = 15.0;
/// Least distance of grid lines, points.
const GRID: f64 = 58.0;
/// Decimals of a dragged place, m.
const DECIMALS: usize = 2;

/// How a handle is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    Disc,
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle on its base.
    Triangle,
    /// A ring with an upright cross.
    Ring,
    /// A disc in quarters, as a centre of gravity is marked.
    Quartered,
}

/// A thing at a place.
#[derive(Clone, Debug)]
pub struct Handle {
    /// Its name, for tests, screen readers and the pointer.
    pub name: String,
    /// Place, m.
    pub at: [f64; 2],
    pub symbol: Symbol,
    /// Its colour.
    pub color: Color32,
    /// Whether it can be dragged.
    pub movable: bool,
}

/// A closed outline, filled faintly.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Corners, m.
    pub corners: Vec<[f64; 2]>,
    /// Its colour.
    pub color: Color32,
}

#[derive(Clone, Debug)]
pub struct ScaleView<'a> {
    /// Name, for tests and screen readers; also its identity.
    pub name: &'a str,
    /// Names of the level and of the upright axis, with units.
    pub labels: [String; 2],
    /// Factor from m to what the axes show.
    pub scale: f64,
    /// What is drawn below.
    pub outlines: &'a [Outline],
    /// What is drawn above, the last on top.
    pub handles: &'a [Handle],
    /// The handle that is marked with its name.
    pub selected: Option<usize>,
}

/// What the user did to a handle this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touched {
    /// It was clicked.
    Chosen(usize),
    /// It is dragged to this place, m; where it was before for `Begin` and `Cancel`.
    Dragged(usize, EditPhase, [f64; 2]),
}

/// A drag under way: which handle, where it was, how far the pointer is from it, and the extent, which stands meanwhile.
#[derive(Clone, Copy)]
struct Held {
    index: usize,
    origin: [f64; 2],
    now: [f64; 2],
    grip: egui::Vec2,
    extent: [[f64; 2]; 2],
}

/// From metres to points.
#[derive(Clone, Copy)]
struct Frame {
    rect: Rect,
    middle: [f64; 2],
    points_per_m: f64,
}

impl Frame {
    /// The frame in which `extent` has room on both axes at one scale.
    fn new(rect: Rect, [low, high]: [[f64; 2]; 2]) -> Self {
        let size = [0, 1].map(|axis| (high[axis] - low[axis]).max(0.5) * (1.0 + 2.0 * MARGIN));
        let points_per_m = (f64::from(rect.width()) / size[0]).min(f64::from(rect.height()) / size[1]);
        Self { rect, middle: [0, 1].map(|axis| 0.5 * (low[axis] + high[axis])), points_per_m }
    }

    #[expect(clippy::cast_possible_truncation, reason = "points of a screen")]
    fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        let center = self.rect.center();
        let across = ((x - self.middle[0]) * self.points_per_m) as f32;
        let up = ((y - self.middle[1]) * self.points_per_m) as f32;
        pos2(center.x + across, center.y - up)
    }

    fn metres_at(&self, at: Pos2) -> [f64; 2] {
        let off = at - self.rect.center();
        [self.middle[0] + f64::from(off.x) / self.points_per_m, self.middle[1] - f64::from(off.y) / self.points_per_m]
    }
}

impl ScaleView<'_> {
    /// Draws it in `size` points; what was done to a handle, and the figure where it was asked for in the menu.
    pub fn show(&self, ui: &mut Ui, size: egui::Vec2) -> (Option<Touched>, Option<FigureRequest>) {
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, self.name));
        let inner = Rect::from_min_max(rect.min + vec2(AXIS[0], 4.0), rect.max - vec2(6.0, AXIS[1]));
        if !inner.is_positive() {
            return (None, None);
        }
        let id = Id::unique(("scale view", self.name));
        let held = ui.data(|data| data.get_temp::<Held>(id));
        let frame = Frame::new(inner, held.map_or_else(|| self.extent(), |held| held.extent));
        let painter = ui.painter_at(rect);
        painter.rect_filled(inner, 2.0, theme::palette(ui).plot_background);
        self.draw_grid(ui, &painter, &frame);
        let clipped = ui.painter_at(inner);
        self.outlines.iter().for_each(|outline| draw_outline(&clipped, outline, &frame));
        let mut touched = None;
        for (index, handle) in self.handles.iter().enumerate() {
            touched = self.handle(ui, &clipped, (index, handle), (id, held), &frame).or(touched);
        }
        (touched, figure_menu(&response).map(|form| FigureRequest { figure: self.figure(&frame), form }))
    }

    /// The same on paper, both axes at one scale.
    fn figure(&self, frame: &Frame) -> Figure {
        let scaled = |[x, y]: [f64; 2]| [self.scale * x, self.scale * y];
        let [low, high] =
            [frame.rect.left_bottom(), frame.rect.right_top()].map(|corner| scaled(frame.metres_at(corner)));
        let axis =
            |axis: usize| Axis { range: Some([low[axis], high[axis]]), ..Axis::new(self.labels[axis].as_str(), "") };
        let mark = |name: &str, color, style, points: &mut dyn Iterator<Item = [f64; 2]>| Mark::Points {
            label: name.to_owned().into(),
            colour: printed(color),
            style,
            points: points.map(|at| [scaled(at)[0], scaled(at)[1], f64::NAN]).collect(),
        };
        let outline = |outline: &Outline| {
            let closed = outline.corners.iter().chain(outline.corners.first()).copied();
            mark("", outline.color, LineStyle::Solid, &mut closed.into_iter())
        };
        let handle =
            |handle: &Handle| mark(&handle.name, handle.color, LineStyle::Dots, &mut std::iter::once(handle.at));
        let marks = self.outlines.iter().map(outline).chain(self.handles.iter().map(handle)).collect();
        Figure::new(
            format!("aircraft_{}", self.name.replace(' ', "_")),
            format!("the aircraft {}", self.name),
            (1, WIDTH_MM * f64::from(frame.rect.height() / frame.rect.width().max(1.0))),
            vec![Panel::Plot(Plot { x: axis(0), y: axis(1), marks })],
        )
    }

    /// Lowest and highest coordinates of everything.
    fn extent(&self) -> [[f64; 2]; 2] {
        let corners = self.outlines.iter().flat_map(|outline| outline.corners.iter().copied());
        let all = corners.chain(self.handles.iter().map(|handle| handle.at));
        let all = all.filter(|at| at.iter().all(|value| value.is_finite()));
        let ends = all.fold(None, |ends: Option<[[f64; 2]; 2]>, at| {
            let [low, high] = ends.unwrap_or([at, at]);
            Some([[0, 1].map(|axis| low[axis].min(at[axis])), [0, 1].map(|axis| high[axis].max(at[axis]))])
        });
        ends.unwrap_or([[-1.0; 2], [1.0; 2]])
    }

    /// Lines at round lengths with their numbers, the same step on both axes.
    fn draw_grid(&self, ui: &Ui, painter: &Painter, frame: &Frame) {
        let palette = theme::palette(ui);
        let (font, text) = (FontId::proportional(10.5), ui.visuals().weak_text_color());
        let step = step_of(&ROUND, GRID / frame.points_per_m * self.scale);
        let inner = frame.rect;
        for axis in [0, 1] {
            let ends = [frame.metres_at(inner.left_bottom())[axis], frame.metres_at(inner.right_top())[axis]];
            for mark in multiples(ends.map(|end| self.scale * end), step) {
                let mut at = frame.middle;
                at[axis] = mark / self.scale;
                let at = frame.at(at);
                let stroke = Stroke::new(1.0, palette.grid);
                let label = tick(mark, step);
                if axis == 0 {
                    painter.vline(at.x, inner.y_range(), stroke);
                    painter.text(pos2(at.x, inner.bottom() + 2.0), Align2::CENTER_TOP, label, font.clone(), text);
                } else {
                    painter.hline(inner.x_range(), at.y, stroke);
                    painter.text(pos2(inner.left() - 4.0, at.y), Align2::RIGHT_CENTER, label, font.clone(), text);
                }
            }
        }
        let foot = pos2(inner.center().x, inner.bottom() + 15.0);
        painter.text(foot, Align2::CENTER_TOP, &self.labels[0], font.clone(), text);
        let head = inner.left_top() + vec2(5.0, 3.0);
        painter.text(head, Align2::LEFT_TOP, &self.labels[1], font, text);
    }

    /// One handle: its symbol, its name where it is pointed at or chosen, and what is done to it.
    fn handle(
        &self,
        ui: &mut Ui,
        painter: &Painter,
        (index, handle): (usize, &Handle),
        (id, held): (Id, Option<Held>),
        frame: &Frame,
    ) -> Option<Touched> {
        let at = frame.at(handle.at);
        let sense = if handle.movable { Sense::click_and_drag() } else { Sense::click() };
        let grip = ui.interact(Rect::from_center_size(at, vec2(GRIP, GRIP)), id.with(&handle.name), sense);
        let name = format!("{} {}", handle.name, self.name);
        grip.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        let of_this = held.filter(|held| held.index == index);
        let is_marked = self.selected == Some(index) || grip.hovered() || of_this.is_some();
        draw_symbol(painter, handle, at, ui.visuals().text_color(), is_marked);
        if is_marked {
            let [x, y] = handle.at.map(|value| tick(self.scale * value, 0.01));
            let text = if grip.hovered() || of_this.is_some() {
                format!("{}  {x}, {y}", handle.name)
            } else {
                handle.name.clone()
            };
            draw_name(ui, painter, at, text);
        }
        if handle.movable && (grip.hovered() || of_this.is_some()) {
            ui.ctx().set_cursor_icon(if of_this.is_some() { CursorIcon::Grabbing } else { CursorIcon::Grab });
        }
        self.follow(ui, &grip, (index, handle), (id, of_this), frame)
            .or_else(|| grip.clicked().then_some(Touched::Chosen(index)))
    }

    /// Turns what the pointer does into phases of an edit.
    fn follow(
        &self,
        ui: &Ui,
        grip: &egui::Response,
        (index, handle): (usize, &Handle),
        (id, held): (Id, Option<Held>),
        frame: &Frame,
    ) -> Option<Touched> {
        let report = |phase, at| Some(Touched::Dragged(index, phase, at));
        if grip.drag_started() {
            let pressed = ui.input(|input| input.pointer.press_origin()).unwrap_or(frame.at(handle.at));
            let held = Held {
                index,
                origin: handle.at,
                now: handle.at,
                grip: frame.at(handle.at) - pressed,
                extent: self.extent(),
            };
            ui.data_mut(|data| data.insert_temp(id, held));
            return report(EditPhase::Begin, handle.at);
        }
        let held = held?;
        let forget = || ui.data_mut(|data| data.remove::<Held>(id));
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            forget();
            ui.ctx().stop_dragging();
            return report(EditPhase::Cancel, held.origin);
        }
        if grip.drag_stopped() || !grip.dragged() {
            forget();
            return report(EditPhase::Commit, held.now);
        }
        let pointer = grip.interact_pointer_pos()?;
        let now = frame.metres_at(pointer + held.grip).map(|value| to_decimals(value, DECIMALS));
        if now == held.now {
            return None;
        }
        ui.data_mut(|data| data.insert_temp(id, Held { now, ..held }));
        report(EditPhase::Change, now)
    }
}

fn draw_outline(painter: &Painter, outline: &Outline, frame: &Frame) {
    let corners: Vec<Pos2> = outline.corners.iter().map(|&at| frame.at(at)).collect();
    // Wings are not convex as a whole: the line is drawn around, the filling left to what is.
    painter.add(Shape::closed_line(corners, Stroke::new(1.3, outline.color)));
}

fn draw_symbol(painter: &Painter, handle: &Handle, at: Pos2, ink: Color32, is_marked: bool) {
    let size = if is_marked { 6.0 } else { 4.5 };
    let color = handle.color;
    let polygon = |corners: &[[f32; 2]]| {
        let corners = corners.iter().map(|[x, y]| at + size * vec2(*x, *y)).collect();
        Shape::convex_polygon(corners, color, Stroke::NONE)
    };
    match handle.symbol {
        Symbol::Disc => drop(painter.circle_filled(at, size, color)),
        Symbol::Square => drop(painter.add(polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]))),
        Symbol::Diamond => drop(painter.add(polygon(&[[0.0, -1.2], [1.2, 0.0], [0.0, 1.2], [-1.2, 0.0]]))),
        Symbol::Triangle => drop(painter.add(polygon(&[[0.0, -1.2], [1.1, 0.9], [-1.1, 0.9]]))),
        Symbol::Ring => {
            painter.circle_stroke(at, size, Stroke::new(1.6, color));
            painter.hline(at.x - 1.6 * size..=at.x + 1.6 * size, at.y, Stroke::new(1.2, color));
            painter.vline(at.x, at.y - 1.6 * size..=at.y + 1.6 * size, Stroke::new(1.2, color));
        }
        Symbol::Quartered => {
            let radius = size + 2.0;
            painter.circle(at, radius, Color32::WHITE, Stroke::new(1.4, color));
            for quarter in [0.0, 180.0_f32] {
                let corner = |step: u8| {
                    let angle = (quarter + 15.0 * f32::from(step)).to_radians();
                    at + radius * vec2(angle.cos(), -angle.sin())
                };
                let corners = std::iter::once(at).chain((0..=6).map(corner)).collect();
                painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
            }
        }
    }
    if is_marked && handle.symbol != Symbol::Quartered {
        painter.circle_stroke(at, size + 3.5, Stroke::new(1.2, ink));
    }
}

/// The name beside a handle, inside the view.
fn draw_name(ui: &Ui, painter: &Painter, at: Pos2, text: String) {
    let galley = painter.layout_no_wrap(text, FontId::proportional(11.0), ui.visuals().strong_text_color());
    let room = painter.clip_rect();
    let size = galley.size();
    let left = if at.x + 12.0 + size.x < room.right() { at.x + 12.0 } else { at.x - 12.0 - size.x };
    let top = (at.y - 18.0).clamp(room.top() + 2.0, (room.bottom() - size.y - 2.0).max(room.top() + 2.0));
    let min = pos2(left.max(room.left() + 2.0), top);
    let ground = ui.visuals().panel_fill.gamma_multiply(0.88);
    painter.rect_filled(Rect::from_min_size(min, size).expand(2.0), 2.0, ground);
    painter.galley(min, galley, ui.visuals().text_color());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_one_scale_and_places_come_back() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 200.0));
        let frame = Frame::new(rect, [[0.0, -6.0], [9.0, 6.0]]);
        let (a, b) = (frame.at([1.0, 0.0]), frame.at([2.0, 1.0]));
        assert!(((b.x - a.x) - (a.y - b.y)).abs() < 1e-3);
        let back = frame.metres_at(frame.at([3.5, -1.25]));
        assert!((back[0] - 3.5).abs() < 1e-4 && (back[1] + 1.25).abs() < 1e-4, "{back:?}");
        assert!(rect.contains(frame.at([0.0, -6.0])) && rect.contains(frame.at([9.0, 6.0])));
    }
}
