//! How far something may be believed, as a shape and a colour: a dot, a triangle, a square.

use doublet_engine::verdict::Level;
use eframe::egui::{Color32, Painter, Pos2, Rect, Response, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

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

/// What the mark of a channel means: how it fits the other channels.
pub fn channel_words(level: Option<Level>) -> &'static str {
    match level {
        Some(Level::Good) => "consistent with the other channels",
        Some(Level::Caution) => "doubtful against the other channels",
        Some(Level::Bad) => "contradicts the other channels",
        None => "no other channel for comparison",
    }
}

/// The marks of channels with what they mean, in one line.
pub fn channel_legend(ui: &mut Ui) {
    let levels = [Some(Level::Good), Some(Level::Caution), Some(Level::Bad), None];
    let words = ["consistent", "doubtful", "contradicts others", "no comparison"];
    legend(ui, levels.into_iter().zip(words));
}

/// Marks with words, in one line.
pub fn legend<'t>(ui: &mut Ui, marks: impl Iterator<Item = (Option<Level>, &'t str)>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (level, words) in marks {
            level_mark(ui, level);
            ui.label(RichText::new(words).size(11.0).weak());
            ui.add_space(10.0);
        }
    });
}
