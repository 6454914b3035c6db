//! A panic in a frame, outside the panels: unsaved work is written at once, and the window shows the error until it is tried again.

use doublet_engine::graph::guarded;
use eframe::egui::{self, Ui};

use super::{Workbench, draw, logic};
use crate::panels::EditRequest;
use crate::widgets::guarded::draw_guarded;
use crate::widgets::second_side;

/// What errors of a frame name.
const NAME: &str = "window";

impl Workbench {
    /// What comes before drawing. After a panic nothing is done until the window is drawn again, so that it can be closed.
    pub(super) fn step(&mut self, ctx: &egui::Context) {
        if self.fault.is_some() {
            return;
        }
        let done = guarded(NAME, || {
            logic::run(self, ctx);
            Ok::<(), String>(())
        });
        if let Err(error) = done {
            self.fault = Some(error);
            self.leave_frame(ctx);
        }
    }

    /// Draws the window, or what went wrong with it.
    pub(super) fn draw(&mut self, ui: &mut Ui) {
        let mut fault = self.fault.take();
        let has_failed = draw_guarded(NAME, &mut fault, ui, |ui| draw::draw(self, ui));
        self.fault = fault;
        if has_failed {
            self.leave_frame(ui.ctx());
        }
    }

    /// Gives up what a frame that panicked had begun, and keeps unsaved work.
    fn leave_frame(&mut self, ctx: &egui::Context) {
        second_side(ctx, false);
        self.commands.clear();
        self.edits.clear();
        if let Err(line) = self.keep_work_after_panic()
            && let Some(fault) = &mut self.fault
        {
            fault.push_str(&format!("; autosave failed: {line}"));
        }
        ctx.request_repaint();
    }

    /// Keeps unsaved work after the panic of a panel.
    pub(super) fn keep_work_after_failed_panel(&mut self) {
        if let Err(line) = self.keep_work_after_panic() {
            self.complain(format!("Autosave failed ({line}): save now"));
        }
    }

    /// Gives up a drag that a panic has cut off, and writes unsaved work at once.
    fn keep_work_after_panic(&mut self) -> Result<(), String> {
        self.edits.push(EditRequest::Abort);
        guarded("autosave", || self.document.autosave_now())
    }
}
