//! What was computed, when and why, and what went wrong.

use eframe::egui::{self, Label, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use super::{Panel, PanelContext};
use crate::{notation, theme};

/// The panel.
pub struct Log;

impl Panel for Log {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let palette = theme::palette(ui);
        let recordings = snapshot.flights.values().filter_map(|slot| slot.latest());
        let paths = snapshot.windows.values().filter_map(|results| results.path.latest());
        let aero = snapshot.windows.values().filter_map(|results| results.aero.latest());
        let findings: Vec<&String> = recordings
            .flat_map(|loaded| &loaded.recording.warnings)
            .chain(paths.flat_map(|path| &path.warnings))
            .chain(aero.flat_map(|aero| &aero.warnings))
            .collect();
        if !findings.is_empty() {
            egui::CollapsingHeader::new(format!("{} findings in the data", findings.len())).show(ui, |ui| {
                egui::ScrollArea::vertical().max_height(140.0).show(ui, |ui| {
                    for finding in findings {
                        ui.add(Label::new(RichText::new(finding).size(11.5).color(palette.warning)).wrap());
                    }
                });
            });
        }
        TableBuilder::new(ui)
            .id_salt("log")
            .striped(true)
            .auto_shrink(false)
            .stick_to_bottom(true)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::exact(40.0))
            .column(Column::initial(170.0).resizable(true).clip(true))
            .column(Column::remainder().clip(true))
            .column(Column::exact(72.0))
            .header(20.0, |mut header| {
                for title in ["Run", "After", "Result", "Time"] {
                    header.col(|ui| {
                        ui.weak(title);
                    });
                }
            })
            .body(|body| {
                body.rows(20.0, snapshot.log.len(), |mut row| {
                    let line = &snapshot.log[row.index()];
                    let failure = line.duration.is_zero();
                    row.col(|ui| {
                        ui.weak(line.generation.to_string());
                    });
                    row.col(|ui| {
                        ui.add(Label::new(&line.cause).truncate());
                    });
                    row.col(|ui| {
                        let mut text = RichText::new(&line.text);
                        if failure {
                            text = text.color(palette.error);
                        }
                        ui.add(Label::new(text).truncate()).on_hover_text(&line.text);
                    });
                    row.col(|ui| {
                        if !failure {
                            ui.weak(notation::duration(line.duration));
                        }
                    });
                });
            });
    }
}
