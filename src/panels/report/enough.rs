//! Sufficiency of the data: standard errors compared with the goal of each derivative after every manoeuvre, and the best manoeuvre to
//! fly next.

use doublet_engine::planning::{self, EnoughRequest, SURFACE_NAMES, THROTTLE, enough_blocks};
use eframe::egui::{DragValue, Response, Ui};

use crate::panels::{KeptBlocks, Panel, PanelContext, answer, surfaces};

#[derive(Default)]
pub struct Enough {
    typed: EnoughRequest,
    asked: EnoughRequest,
    kept: KeptBlocks<planning::Enough>,
}

impl Panel for Enough {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let still = ui.horizontal_wrapped(|ui| {
            let percent = DragValue::new(&mut self.typed.relative_percent).range(0.1..=100.0).speed(0.1);
            let percent = ui.add(percent.prefix("goal ").suffix(" %"));
            let percent = percent.on_hover_text("Target relative standard error of every derivative");
            surfaces(ui, &mut self.typed.surfaces, &SURFACE_NAMES[..THROTTLE]);
            let time = DragValue::new(&mut self.typed.time_s).range(6.0..=120.0).prefix("next manoeuvre ").suffix(" s");
            let time = ui.add(time).on_hover_text("Length of the next manoeuvre");
            [percent, time].iter().all(is_at_rest)
        });
        if still.inner {
            self.asked.clone_from(&self.typed);
        }
        ctx.wanted.inquiry.enough = Some(self.asked.clone());
        let snapshot = ctx.snapshot;
        answer(ctx, ui, &snapshot.inquiries.enough, &mut self.kept, "Check against the goals", enough_blocks);
    }
}

/// Whether nobody drags or types in a field.
fn is_at_rest(response: &Response) -> bool {
    !response.dragged() && !response.has_focus()
}
