//! Input design for the next flight from the identified model: kinds side by side, the stick picture, predicted errors and excursions.

use std::path::PathBuf;

use doublet_engine::keep::Put;
use doublet_engine::planning::{Criterion, DesignKind, DesignSheet, SURFACE_NAMES, SheetRequest, design_sheet};
use doublet_engine::report::document::Block;
use doublet_engine::run::{Control, Job};
use doublet_report::{DocumentSet, ReportFormat};
use eframe::egui::{Button, ComboBox, DragValue, ScrollArea, Ui};

use crate::command::FileField;
use crate::panels::{Panel, PanelContext, Working, browse, empty, surfaces, text_field};
use crate::widgets::term::explained;

#[derive(Default)]
pub struct Design {
    request: SheetRequest,
    folder: String,
    designing: Working<DesignSheet>,
    writing: Working<Put>,
    blocks: Vec<Block>,
}

impl Panel for Design {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.add_enabled_ui(!self.designing.is_busy(), |ui| ui.horizontal_wrapped(|ui| self.choices(ui)));
        ui.horizontal_wrapped(|ui| {
            let possible = !self.request.surfaces.is_empty() && !self.designing.is_busy();
            if ui.add_enabled(possible, Button::new("Design the input")).clicked() {
                self.start(ctx, ui);
            }
            self.write(ctx, ui);
        });
        if self.designing.show(ui) {
            self.blocks = self.designing.done().map(DesignSheet::blocks).unwrap_or_default();
        }
        self.writing.show(ui);
        if self.blocks.is_empty() {
            return empty(ui, "Design an input from the identified model to see signals and predicted errors.");
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| ctx.document(ui, &self.blocks));
    }
}

impl Design {
    fn choices(&mut self, ui: &mut Ui) {
        let request = &mut self.request;
        surfaces(ui, &mut request.surfaces, &SURFACE_NAMES);
        ComboBox::from_id_salt("kind of input").selected_text(request.kind.name()).show_ui(ui, |ui| {
            for kind in DesignKind::ALL {
                ui.selectable_value(&mut request.kind, kind, kind.name());
            }
        });
        ui.add(DragValue::new(&mut request.time_s).range(6.0..=1800.0).prefix("time ").suffix(" s"))
            .on_hover_text("Total time of the manoeuvres");
        let combo = ComboBox::from_id_salt("criterion").selected_text(ranking(request.criterion)).width(210.0);
        let combo = combo.show_ui(ui, |ui| {
            for criterion in Criterion::ALL {
                ui.selectable_value(&mut request.criterion, criterion, ranking(criterion));
            }
        });
        explained(combo.response, request.criterion.name());
        let rounds = DragValue::new(&mut request.rounds).range(0..=10).prefix("search rounds ");
        ui.add(rounds).on_hover_text("Search rounds over times, levels and spectra; 0 for published shapes");
        ui.checkbox(&mut request.compare, "compare kinds")
            .on_hover_text("Compare all kinds within the same limits and time");
    }

    fn start(&mut self, ctx: &PanelContext<'_>, ui: &Ui) {
        let (session, snapshot, folder) = (ctx.session.clone(), ctx.snapshot.clone(), ctx.folder.to_owned());
        let request = self.request.clone();
        let work = move |control: &Control, _: &(dyn Fn(f32) + Sync)| {
            design_sheet(&session, &snapshot, &folder, &request, control)
        };
        let repaint = ui.ctx().clone();
        self.designing.take(Job::start("doublet-design", move || repaint.request_repaint(), work));
    }

    /// The folder for card and files, and the button that writes them.
    fn write(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(sheet) = self.designing.done() else { return };
        text_field(ui, "folder of the card", &mut self.folder, "folder: card, scenario, autopilot", 220.0);
        browse(ctx, ui, FileField::Card, &mut self.folder);
        let possible = !self.folder.trim().is_empty() && !self.writing.is_busy();
        let button = ui.add_enabled(possible, Button::new("Write card and files"));
        let hint = "The ArduPilot script assumes a surface travel of ±20°";
        if !button.on_hover_text(hint).clicked() {
            return;
        }
        let place: PathBuf = ctx.folder.join(self.folder.trim());
        let (card, files) = (sheet.card.clone(), sheet.files());
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            let (beside, formats) = (files?, written_forms());
            let set = DocumentSet { folder: &place, name: "design", formats: &formats, beside: &beside };
            set.write(&card, "designed input", control, progress)
        };
        let repaint = ui.ctx().clone();
        self.writing.take(Job::start("doublet-card", move || repaint.request_repaint(), work));
    }
}

/// What a criterion ranks inputs by; the smallest is best.
fn ranking(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::A => "sum of squared relative errors (a)",
        Criterion::D => "least volume of the errors (d)",
        Criterion::MaxRelative => "largest relative error",
    }
}

/// Forms this build can write.
pub fn written_forms() -> Vec<ReportFormat> {
    ReportFormat::ALL.into_iter().filter(|format| format.is_in_this_build()).collect()
}
