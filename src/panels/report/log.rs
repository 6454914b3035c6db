//! Log of the computations: time, cause, result and errors.

use eframe::egui::{self, Label, RichText, TextStyle, Ui};
use egui_extras::Column;

use crate::panels::{Panel, PanelContext};
use crate::widgets::grid::texts_grid;
use crate::widgets::term::column_titles;
use crate::{notation, theme};

/// Least and greatest width of the column with what asked for a run, and its part of the panel.
const CAUSE: [f32; 2] = [170.0, 360.0];
const CAUSE_PART: f32 = 0.25;
/// Width of the columns of run and time, with the spaces between all.
const COLUMNS: f32 = 40.0 + 72.0 + 40.0;

pub struct Log;

impl Panel for Log {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let palette = theme::palette(ui);
        let recordings = snapshot.flights.values().filter_map(|slot| slot.latest());
        let paths = snapshot.windows.values().filter_map(|results| results.path.latest());
        let aero = snapshot.windows.values().filter_map(|results| results.aero.latest());
        let findings: Vec<String> = recordings
            .flat_map(|loaded| &loaded.recording.warnings)
            .chain(paths.flat_map(|path| &path.assessment().warnings))
            .chain(aero.flat_map(|aero| &aero.warnings))
            .map(ToString::to_string)
            .collect();
        if !findings.is_empty() {
            egui::CollapsingHeader::new(format!("{} warnings in the data", findings.len())).show(ui, |ui| {
                egui::ScrollArea::vertical().max_height(140.0).show(ui, |ui| {
                    for finding in findings {
                        ui.add(Label::new(RichText::new(finding).size(11.5).color(palette.warning)).wrap());
                    }
                });
            });
        }
        let figures = theme::figures(ui);
        let cause = (CAUSE_PART * ui.available_width()).clamp(CAUSE[0], CAUSE[1]);
        let width = (ui.available_width() - COLUMNS - cause).max(120.0);
        let wrapped = |ui: &Ui, text: &str, width: f32, color| {
            ui.painter().layout(text.to_owned(), TextStyle::Body.resolve(ui.style()), color, width)
        };
        let lines: Vec<_> = snapshot
            .log
            .iter()
            .map(|line| {
                let color = if line.failed { palette.error } else { ui.visuals().text_color() };
                [
                    wrapped(ui, &line.cause, cause - 8.0, ui.visuals().text_color()),
                    wrapped(ui, &line.text, width, color),
                ]
            })
            .collect();
        let heights = lines.iter().map(|cells| cells.iter().map(|cell| cell.size().y).fold(0.0, f32::max) + 5.0);
        texts_grid(ui, "log")
            .stick_to_bottom(true)
            .column(Column::exact(40.0))
            .column(Column::exact(cause).clip(true))
            .column(Column::remainder().clip(true))
            .column(Column::exact(72.0))
            .header(20.0, |header| column_titles(header, ["Run", "Cause", "Result", "Time"]))
            .body(|body| {
                body.heterogeneous_rows(heights, |mut row| {
                    let at = row.index();
                    let line = &snapshot.log[at];
                    row.col(|ui| {
                        ui.weak(line.generation.to_string());
                    });
                    for cell in &lines[at] {
                        row.col(|ui| {
                            ui.label(std::sync::Arc::clone(cell));
                        });
                    }
                    row.col(|ui| {
                        if !line.duration.is_zero() {
                            ui.label(RichText::new(notation::duration(line.duration)).font(figures.clone()).weak());
                        }
                    });
                });
            });
    }
}
