//! An earlier estimate, this flight alone and both combined for each derivative, with a test of their consistency.

use doublet_engine::prior::{PriorRequest, PriorStudy};
use eframe::egui::{ComboBox, DragValue, Ui};

use crate::command::{FileCommand, UiCommand};
use crate::panels::{KeptBlocks, Panel, PanelContext, answer, empty};

pub struct Prior {
    chosen: String,
    percent: f64,
    kept: KeptBlocks<PriorStudy>,
}

impl Default for Prior {
    fn default() -> Self {
        Self { chosen: String::new(), percent: 20.0, kept: None }
    }
}

impl Panel for Prior {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let chosen = ctx.references.iter().find(|reference| reference.name == self.chosen);
        let chosen = chosen.or(ctx.references.last());
        ui.horizontal_wrapped(|ui| {
            if let Some(reference) = chosen {
                let combo = ComboBox::from_id_salt("earlier estimate").selected_text(&reference.name);
                let combo = combo.show_ui(ui, |ui| {
                    for other in ctx.references {
                        ui.selectable_value(&mut self.chosen, other.name.clone(), &other.name);
                    }
                });
                ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("earlier estimate"));
            }
            let hint = "Results of another session, a table of derivatives, or a DATCOM listing";
            if ui.button("Add an estimate…").on_hover_text(hint).clicked() {
                ctx.commands.push(UiCommand::File(FileCommand::AddReference));
            }
            let percent = DragValue::new(&mut self.percent).range(1.0..=200.0).prefix("known to ").suffix(" %");
            ui.add(percent).on_hover_text("Default relative standard deviation of the derivatives");
        });
        let Some(reference) = chosen else {
            return empty(ui, "Add an earlier estimate to compare and combine it with the flight.");
        };
        ctx.wanted.inquiry.prior = Some(PriorRequest::of_reference(reference, 0.01 * self.percent));
        let snapshot = ctx.snapshot;
        answer(ctx, ui, &snapshot.inquiries.prior, &mut self.kept, "Prior and flight", PriorStudy::blocks);
    }
}
