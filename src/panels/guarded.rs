//! A panel whose panic stays in its own place.

use eframe::egui::Ui;

use super::{Pane, Panel, PanelContext};
use crate::widgets::guarded::draw_guarded;

/// A panel, or the error of its panic until it is tried again.
pub struct GuardedPanel {
    pane: Pane,
    panel: Box<dyn Panel>,
    fault: Option<String>,
}

impl GuardedPanel {
    pub fn new(pane: Pane) -> Self {
        Self { pane, panel: pane.build(), fault: None }
    }

    /// Draws it; whether it has panicked now.
    pub fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) -> bool {
        let panel = &mut self.panel;
        let has_failed = draw_guarded(self.pane.title(), &mut self.fault, ui, |ui| panel.show(ctx, ui));
        if has_failed {
            // What the panic left half done goes with it.
            self.panel = self.pane.build();
        }
        has_failed
    }
}
