//! A panic while a part of the window is drawn: the part shows its error, the rest of the window goes on.

use doublet_engine::graph::guarded;
use eframe::egui::{Frame, Label, Margin, RichText, Ui};

use crate::theme;

/// Draws the part of the window called `name`. After a panic in `draw` the error stands in `fault` and in the place of the part, from the next
/// frame until **Try again** is clicked. Whether `draw` has panicked now.
pub fn draw_guarded(name: &str, fault: &mut Option<String>, ui: &mut Ui, draw: impl FnOnce(&mut Ui)) -> bool {
    if let Some(error) = fault {
        if draw_fault(error, ui) {
            *fault = None;
            ui.ctx().request_repaint();
        }
        return false;
    }
    let drawn = guarded(name, || {
        draw(ui);
        Ok::<(), String>(())
    });
    *fault = drawn.err();
    if fault.is_some() {
        ui.ctx().request_repaint();
    }
    fault.is_some()
}

/// Draws what went wrong; whether the part is to be drawn again.
fn draw_fault(error: &str, ui: &mut Ui) -> bool {
    let color = theme::palette(ui).error;
    let framed = Frame::new().inner_margin(Margin::same(8)).show(ui, |ui| {
        ui.add(Label::new(RichText::new(format!("⚠ {error}")).color(color)).wrap());
        ui.button("Try again").clicked()
    });
    framed.inner
}
