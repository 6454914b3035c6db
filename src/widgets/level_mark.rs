//! How far something may be believed, as a shape and a colour: a dot, a triangle, a square.

use doublet_engine::verdict::Level;
use eframe::egui::{Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::theme;

/// Half the size of a mark in a line of text.
const RADIUS: f32 = 5.0;

/// Draws the mark of a level about `center`; a ring where nothing is judged yet. It reads without its colour.
pub fn paint(painter: &Painter, center: Pos2, radius: f32, level: Option<Level>, color: Color32) {
    match level {
        None => {
            painter.circle_stroke(center, radius - 0.5, Stroke::new(1.2, color));
        }
        Some(Level::Good) => {
            painter.circle_filled(center, radius, color);
        }
        Some(Level::Caution) => {
            let (x, y, half) = (center.x, center.y, 1.15 * radius);
            let corners = vec![pos2(x, y - half), pos2(x + half, y + 0.8 * half), pos2(x - half, y + 0.8 * half)];
            painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
        }
        Some(Level::Bad) => {
            painter.rect_filled(Rect::from_center_size(center, vec2(2.0, 2.0) * 0.92 * radius), 1.0, color);
        }
    }
}

/// Colour of a level's mark; weak where nothing is judged yet.
pub fn color(ui: &Ui, level: Option<Level>) -> Color32 {
    level.map_or(ui.visuals().weak_text_color(), |level| theme::palette(ui).of_level(level))
}

/// The mark of a level in a line of text.
pub fn level_mark(ui: &mut Ui, level: Option<Level>) -> Response {
    let size = vec2(2.0 * RADIUS + 4.0, ui.text_style_height(&eframe::egui::TextStyle::Body));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    paint(ui.painter(), rect.center(), RADIUS, level, color(ui, level));
    response
}
