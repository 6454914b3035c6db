//! A panel whose panic stays in its own place.

use eframe::egui::Ui;

use super::{
    Pane, Panel, PanelContext, aircraft, filter, manoeuvres, model, recording, report, results, shortcuts, signals,
};
use crate::pane::each_panel;
use crate::widgets::guarded::draw_guarded;

/// A panel, or the error of its panic until it is tried again.
pub struct GuardedPanel {
    pane: Pane,
    panel: Box<dyn Panel>,
    fault: Option<String>,
}

macro_rules! build {
    ($($pane:ident: $title:literal $(tab $tab:literal)?, page $page:literal, $make:expr;)*) => {
        fn build(pane: Pane) -> Box<dyn Panel> {
            match pane { $(Pane::$pane => Box::new($make),)* }
        }
    };
}

each_panel!(build);

impl GuardedPanel {
    pub fn new(pane: Pane) -> Self {
        Self { pane, panel: build(pane), fault: None }
    }

    /// Draws it; whether it has panicked now.
    pub fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) -> bool {
        let panel = &mut self.panel;
        let has_failed = draw_guarded(self.pane.title(), &mut self.fault, ui, |ui| panel.show(ctx, ui));
        if has_failed {
            // What the panic left half done goes with it.
            self.panel = build(self.pane);
        }
        has_failed
    }
}
