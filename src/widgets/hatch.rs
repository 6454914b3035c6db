//! The hatch over what is left out.

use eframe::egui::{Rect, Shape, Stroke, Ui, pos2};

use crate::theme;

/// Distance between the lines of a hatch, points.
const DISTANCE: f32 = 7.0;

/// Pales and hatches what of `rect` is on screen.
pub fn hatch(ui: &Ui, rect: Rect) {
    if !rect.is_positive() {
        return;
    }
    let ground = theme::palette(ui).plot_background;
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    painter.rect_filled(rect, 0.0, ground.gamma_multiply(0.55));
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.45));
    // On the same lines in every part, so that a drag does not move them.
    let from = ((rect.left() - rect.height()) / DISTANCE).floor() as i32;
    let to = (rect.right() / DISTANCE).ceil() as i32;
    painter.extend((from..=to).map(|line| {
        let x = line as f32 * DISTANCE;
        Shape::line_segment([pos2(x, rect.bottom()), pos2(x + rect.height(), rect.top())], stroke)
    }));
    for x in [rect.left(), rect.right()] {
        painter.vline(x, rect.y_range(), stroke);
    }
}
