//! The report: which sections it has, what they hold, and the button that writes it.

use doublet_engine::report;
use doublet_engine::report::document::{Document, SectionKind, build, chosen};
use doublet_engine::session::Edit;
use doublet_report::ReportFormat;
use eframe::egui::{self, RichText, ScrollArea, TextEdit, Ui};

use super::{Panel, PanelContext, caption};
use crate::command::{FileCommand, UiCommand};
use crate::ui_state::ReportChoice;
use crate::widgets::document_view::document_view;

/// Width of the list of sections: that of its longest title.
const SECTIONS_WIDTH: f32 = 308.0;

/// The panel.
#[derive(Default)]
pub struct Report {
    shown: Option<Shown>,
    /// The notes while they are typed.
    notes: Option<String>,
}

/// The section on screen and what it was made from.
struct Shown {
    generation: u64,
    steps: usize,
    kind: SectionKind,
    document: Document,
}

impl Panel for Report {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let mut choice = ctx.state.report.clone();
        egui::Panel::left("report sections").resizable(false).exact_size(SECTIONS_WIDTH).show(ui, |ui| {
            if writing(&mut choice, ui) {
                ctx.commands.push(UiCommand::File(FileCommand::Report));
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                sections(&mut choice, ui);
                ui.separator();
                self.notes(ctx, ui);
                figures(&mut choice, ui);
            });
        });
        self.keep(ctx, choice.shown);
        ctx.state.report = choice;
        let Some(shown) = &self.shown else { return };
        egui::CentralPanel::default().frame(egui::Frame::NONE.inner_margin(8)).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let chosen = chosen(ctx.session, &ctx.state.report.figures);
                let chosen = chosen.filter(|_| shown.kind == SectionKind::Overview);
                for section in chosen.iter().chain(&shown.document.sections) {
                    ui.heading(section.title.as_str());
                    ui.push_id(&section.name, |ui| document_view(ui, &section.blocks));
                }
            });
        });
    }
}

impl Report {
    /// What the author has to say; it is one step of undo once the field is left.
    fn notes(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        caption(ui, "Notes");
        let mut notes = self.notes.clone().unwrap_or_else(|| ctx.session.report_notes.clone());
        let field = TextEdit::multiline(&mut notes).hint_text("What the reader has to know").desired_rows(3);
        let field = ui.add(field.desired_width(f32::INFINITY));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("notes of the report"));
        if field.lost_focus() {
            self.notes = None;
            if notes != ctx.session.report_notes {
                ctx.edit(Edit::ReportNotes(notes));
            }
        } else {
            self.notes = field.has_focus().then_some(notes);
        }
    }

    /// Makes the contents anew when the results or the section have changed.
    fn keep(&mut self, ctx: &PanelContext<'_>, kind: SectionKind) {
        let (generation, steps) = (ctx.snapshot.generation, ctx.snapshot.log.len());
        let current = |shown: &Shown| shown.generation == generation && shown.steps == steps && shown.kind == kind;
        // While results are coming in the last ones stay: they change several times a second.
        if self.shown.as_ref().is_some_and(|shown| current(shown) || (ctx.snapshot.busy && shown.kind == kind)) {
            return;
        }
        let results = report::build(ctx.session, ctx.snapshot);
        let document = build(ctx.session, ctx.snapshot, &results, &[kind]);
        self.shown = Some(Shown { generation, steps, kind, document });
    }
}

/// The figures that were added, each with its caption.
fn figures(choice: &mut ReportChoice, ui: &mut Ui) {
    caption(ui, "Chosen figures");
    if choice.figures.is_empty() {
        ui.add(egui::Label::new(RichText::new("A right click on any plot adds it to the report.").weak()).wrap());
    }
    let mut removed = None;
    for (at, figure) in choice.figures.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            if ui.small_button("✖").on_hover_text("Leave it out").clicked() {
                removed = Some(at);
            }
            let field = ui.add(TextEdit::singleline(&mut figure.caption).desired_width(f32::INFINITY));
            let label = format!("caption of figure {}", at + 1);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(label.as_str()));
        });
    }
    removed.map(|at| choice.figures.remove(at));
}

/// Forms to tick; whether the report is to be written.
fn writing(choice: &mut ReportChoice, ui: &mut Ui) -> bool {
    ui.horizontal(|ui| {
        for format in ReportFormat::ALL {
            let mut wanted = choice.formats.contains(&format);
            if ui.checkbox(&mut wanted, format.name().to_uppercase()).changed() {
                choice.formats.retain(|other| *other != format);
                choice.formats.extend(wanted.then_some(format));
            }
        }
        let possible = !choice.formats.is_empty() && choice.left_out.len() < SectionKind::ALL.len();
        ui.add_enabled(possible, egui::Button::new("Write report…")).clicked()
    })
    .inner
}

/// Sections to tick, and the one that is shown.
fn sections(choice: &mut ReportChoice, ui: &mut Ui) {
    for kind in SectionKind::ALL {
        ui.horizontal(|ui| {
            let mut wanted = !choice.left_out.contains(&kind);
            let tick = ui.checkbox(&mut wanted, "");
            ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(format!("report {}", kind.name())));
            if tick.changed() {
                if wanted {
                    choice.left_out.remove(&kind)
                } else {
                    choice.left_out.insert(kind)
                };
            }
            ui.selectable_value(&mut choice.shown, kind, kind.title());
        });
    }
}
