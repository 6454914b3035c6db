//! An aircraft in its attitude, seen from anywhere, with arrows of velocity: outlines projected in parallel and drawn from far to near.

use doublet_engine::report::document::{Axis, Figure, LineStyle, Mark, Panel, Plot};
use eframe::egui::{
    self, Align2, Color32, FontId, Id, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2,
};

use super::chart::figure_menu;
use super::figure::{FigureRequest, printed};
use super::stack_figure::WIDTH_MM;
use crate::theme;

/// Radians per point of a drag.
const PER_POINT: f64 = 0.008;
/// Parts of the width and of the height that the radius of the compass has: in between a banked wing still fits.
const RADIUS: [f64; 2] = [0.45, 0.62];
/// Points of the compass ring.
const RING: usize = 96;
/// Length of the head of an arrow, points.
const HEAD: f32 = 8.0;

/// Where the view is taken from: azimuth of the line of sight from the aircraft's heading and its inclination below the horizon, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Azimuth of the line of sight from the heading that is followed, rad.
    pub azimuth_rad: f64,
    /// How far it looks down, rad.
    pub down_rad: f64,
}

impl Default for Camera {
    /// From behind, to the right and above.
    fn default() -> Self {
        Self { azimuth_rad: -0.6, down_rad: 0.42 }
    }
}

/// An outline in local Earth axes (north, east, down) about the aircraft, m.
#[derive(Clone, Debug)]
pub struct Face {
    pub corners: Vec<[f64; 3]>,
    /// Colour of the line.
    pub line: Color32,
    /// Colour of what it encloses.
    pub fill: Color32,
}

/// An arrow in local Earth axes, m.
#[derive(Clone, Debug)]
pub struct Arrow {
    pub name: &'static str,
    pub ends: [[f64; 3]; 2],
    /// Its colour.
    pub color: Color32,
}

#[derive(Clone, Debug)]
pub struct AttitudeView<'a> {
    /// Name, for tests and screen readers; also its identity.
    pub name: &'a str,
    /// Radius of the compass, m.
    pub radius_m: f64,
    /// Heading that the line of sight follows, rad.
    pub heading_rad: f64,
    /// Outlines.
    pub faces: &'a [Face],
    /// Arrows, drawn on top.
    pub arrows: &'a [Arrow],
}

/// From local Earth axes to points.
struct Projection {
    center: Pos2,
    points_per_m: f64,
    azimuth: (f64, f64),
    down: (f64, f64),
}

impl Projection {
    fn new(rect: Rect, view: &AttitudeView<'_>, camera: Camera) -> Self {
        Self {
            center: rect.center(),
            points_per_m: (RADIUS[0] * f64::from(rect.width())).min(RADIUS[1] * f64::from(rect.height()))
                / view.radius_m.max(1e-3),
            azimuth: (view.heading_rad + camera.azimuth_rad).sin_cos(),
            down: camera.down_rad.sin_cos(),
        }
    }

    /// Place on screen, and how far away along the line of sight.
    #[expect(clippy::cast_possible_truncation, reason = "points of a screen")]
    fn at(&self, [north, east, down]: [f64; 3]) -> (Pos2, f64) {
        let (sin, cos) = self.azimuth;
        let (sin_down, cos_down) = self.down;
        let (right, ahead) = (east * cos - north * sin, north * cos + east * sin);
        let up = ahead * sin_down - down * cos_down;
        let point = self.center + self.points_per_m as f32 * vec2(right as f32, -up as f32);
        (point, ahead * cos_down + down * sin_down)
    }

    fn point(&self, at: [f64; 3]) -> Pos2 {
        self.at(at).0
    }
}

impl AttitudeView<'_> {
    /// Draws it in `size` points; a drag turns the view, a double click puts it back.
    /// The figure where it was asked for in the menu.
    pub fn show(&self, ui: &mut Ui, size: Vec2, camera: &mut Camera) -> Option<FigureRequest> {
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let response = ui.interact(rect, Id::unique(("attitude view", self.name)), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, self.name));
        if response.dragged() {
            let moved = response.drag_delta();
            camera.azimuth_rad -= PER_POINT * f64::from(moved.x);
            camera.down_rad = (camera.down_rad + PER_POINT * f64::from(moved.y)).clamp(-1.5, 1.5);
        }
        if response.double_clicked() {
            *camera = Camera::default();
        }
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, theme::palette(ui).plot_background);
        let projection = Projection::new(rect, self, *camera);
        self.draw_compass(ui, &painter, &projection);
        self.draw_faces(&painter, &projection);
        for arrow in self.arrows {
            draw_arrow(&painter, arrow.ends.map(|end| projection.point(end)), arrow.color);
        }
        figure_menu(&response).map(|form| FigureRequest { figure: self.figure(&projection, rect), form })
    }

    /// The same on paper: outlines and arrows as lines, in metres across and up as they are seen.
    fn figure(&self, projection: &Projection, rect: Rect) -> Figure {
        let flat = |&at: &[f64; 3]| {
            let off = (projection.point(at) - projection.center) / projection.points_per_m as f32;
            [f64::from(off.x), -f64::from(off.y), f64::NAN]
        };
        let mark = |name: &str, color, corners: &mut dyn Iterator<Item = &[f64; 3]>| Mark::Points {
            label: name.to_owned().into(),
            colour: printed(color),
            style: LineStyle::Solid,
            points: corners.map(flat).collect(),
        };
        let face = |face: &Face| mark("", face.line, &mut face.corners.iter().chain(face.corners.first()));
        let arrow = |arrow: &Arrow| mark(arrow.name, arrow.color, &mut arrow.ends.iter());
        let half = 0.5 * rect.size() / projection.points_per_m as f32;
        let axis =
            |name: &str, half: f32| Axis { range: Some([-f64::from(half), f64::from(half)]), ..Axis::new(name, "m") };
        let (x, y) = (axis("across", half.x), axis("up", half.y));
        let marks = self.faces.iter().map(face).chain(self.arrows.iter().map(arrow)).collect();
        Figure::new(
            format!("replay_{}", self.name),
            format!("attitude, {}", self.name),
            (1, WIDTH_MM * f64::from(rect.height() / rect.width().max(1.0))),
            vec![Panel::Plot(Plot { x, y, marks })],
        )
    }

    /// A level ring through the aircraft with the points of the compass.
    fn draw_compass(&self, ui: &Ui, painter: &Painter, projection: &Projection) {
        let palette = theme::palette(ui);
        let at = |angle: f64, part: f64| {
            let (sin, cos) = angle.sin_cos();
            projection.point([part * self.radius_m * cos, part * self.radius_m * sin, 0.0])
        };
        let turn = |step: usize, of: usize| std::f64::consts::TAU * step as f64 / of as f64;
        let ring = (0..RING).map(|step| at(turn(step, RING), 1.0)).collect();
        painter.add(Shape::closed_line(ring, Stroke::new(1.2, palette.grid)));
        for step in 0..36 {
            let inner = if step % 9 == 0 {
                0.9
            } else if step % 3 == 0 {
                0.94
            } else {
                0.97
            };
            let ends = [at(turn(step, 36), inner), at(turn(step, 36), 1.0)];
            painter.line_segment(ends, Stroke::new(1.0, palette.grid));
        }
        painter.line_segment([at(0.0, -0.9), at(0.0, 0.9)], Stroke::new(0.7, palette.grid));
        let east = std::f64::consts::FRAC_PI_2;
        painter.line_segment([at(east, -0.9), at(east, 0.9)], Stroke::new(0.7, palette.grid));
        for (quarter, name) in ["N", "E", "S", "W"].into_iter().enumerate() {
            let ink = if quarter == 0 { palette.error } else { ui.visuals().weak_text_color() };
            painter.text(at(turn(quarter, 4), 1.06), Align2::CENTER_CENTER, name, FontId::proportional(11.5), ink);
        }
    }

    fn draw_faces(&self, painter: &Painter, projection: &Projection) {
        let mut faces: Vec<(f64, Vec<Pos2>, &Face)> = self
            .faces
            .iter()
            .map(|face| {
                let (points, depths): (Vec<Pos2>, Vec<f64>) =
                    face.corners.iter().map(|&corner| projection.at(corner)).unzip();
                (depths.iter().sum::<f64>() / depths.len().max(1) as f64, points, face)
            })
            .collect();
        faces.sort_by(|one, other| other.0.total_cmp(&one.0));
        for (_, points, face) in faces {
            if face.fill != Color32::TRANSPARENT {
                painter.add(Shape::convex_polygon(points.clone(), face.fill, Stroke::NONE));
            }
            painter.add(Shape::closed_line(points, Stroke::new(1.2, face.line)));
        }
    }
}

fn draw_arrow(painter: &Painter, [from, to]: [Pos2; 2], color: Color32) {
    let along = to - from;
    painter.line_segment([from, to], Stroke::new(2.0, color));
    if along.length() < 2.0 {
        return;
    }
    let head = HEAD.min(0.5 * along.length()) * along.normalized();
    let across = 0.45 * vec2(-head.y, head.x);
    let back = to - head;
    let corners = vec![to, pos2(back.x + across.x, back.y + across.y), pos2(back.x - across.x, back.y - across.y)];
    painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ahead_is_far_what_is_right_is_right_and_what_is_down_is_low() {
        let view = AttitudeView { name: "", radius_m: 10.0, heading_rad: 1.0, faces: &[], arrows: &[] };
        let rect = Rect::from_min_size(Pos2::ZERO, vec2(400.0, 400.0));
        let projection = Projection::new(rect, &view, Camera { azimuth_rad: 0.0, down_rad: 0.3 });
        let (ahead, right) = ([1f64.cos(), 1f64.sin(), 0.0], [-(1f64.sin()), 1f64.cos(), 0.0]);
        let center = projection.point([0.0; 3]);
        let (point, depth) = projection.at(ahead);
        assert!(depth > 0.9 && point.y < center.y && (point.x - center.x).abs() < 1e-3);
        let (point, depth) = projection.at(right);
        assert!(point.x > center.x + 10.0 && depth.abs() < 1e-12 && (point.y - center.y).abs() < 1e-3);
        assert!(projection.point([0.0, 0.0, 1.0]).y > center.y + 10.0);
    }
}
