//! Derivatives of single windows over all of them, and by kind of input (thesis Tables 6.4 to 6.9, Fig. 6.12).

use doublet_core::estimate::ParameterSummary;
use doublet_engine::stage::KindSummary;
use eframe::egui::{self, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::panels::{PanelContext, awaiting, dim_if, lacks_estimate};
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::figures_grid;
use crate::widgets::term::{column_title, column_title_called};
use crate::{notation, theme};

/// Titles of the columns over all windows.
const TITLES: [&str; 6] = ["Manoeuvres", "Mean", "Scatter", "Std. error", "Min", "Max"];

/// Draws the table; copies it first where that was asked for.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, copy: bool) {
    let Some(details) = ctx.snapshot.details.latest() else {
        return awaiting(ctx, ui, "the derivatives of every manoeuvre", &lacks_estimate(ctx));
    };
    let Some((all, kinds)) = details.kinds.split_first() else {
        return crate::panels::empty(ui, "No identification manoeuvre.");
    };
    if copy {
        ui.ctx().copy_text(csv(&details.kinds));
    }
    dim_if(ui, ctx.snapshot.details.is_stale());
    ScrollArea::horizontal().show(ui, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        figures_grid(ui, "over manoeuvres")
            .sense(egui::Sense::click())
            .column(Column::exact(54.0))
            .columns(Column::exact(60.0), TITLES.len())
            .columns(Column::exact(148.0), kinds.len())
            .header(20.0, |mut header| {
                header.col(|_| {});
                for title in TITLES {
                    header.col(|ui| {
                        column_title(ui, title);
                    });
                }
                for kind in kinds {
                    header.col(|ui| {
                        column_title_called(ui, &kind.kind, "Scatter");
                    });
                }
            })
            .body(|body| {
                body.rows(20.0, all.parameters.len(), |mut row| {
                    let parameter = &all.parameters[row.index()];
                    row.set_selected(ctx.selection().derivative.as_ref() == Some(&parameter.name));
                    row.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            ui.add(egui::Label::new(notation::derivative_job(ui, &parameter.name)).selectable(false));
                        });
                    });
                    let of_kinds = kinds.iter().map(|kind| {
                        let found = kind.parameters.iter().find(|other| other.name == parameter.name);
                        found.map_or(String::new(), |found| {
                            format!(
                                "{} ± {}",
                                notation::within(found.estimate[0], found.scatter),
                                notation::within(found.scatter, found.scatter)
                            )
                        })
                    });
                    for text in cells(parameter).into_iter().chain(of_kinds) {
                        row.col(|ui| cell(ui, text));
                    }
                    if row.response().clicked() {
                        ctx.state.selection.derivative = Some(parameter.name.clone());
                    }
                });
            });
    });
}

fn cell(ui: &mut Ui, text: String) {
    ui.add(egui::Label::new(RichText::new(text).font(theme::figures(ui)).size(11.0)).selectable(false));
}

fn cells(parameter: &ParameterSummary) -> [String; 6] {
    let [mean, min, max] = parameter.estimate.map(|value| notation::within(value, parameter.scatter));
    let [scatter, error] =
        [parameter.scatter, parameter.variance[0].sqrt()].map(|spread| notation::within(spread, spread));
    [parameter.fits.to_string(), mean, scatter, error, min, max]
}

/// The table as text for other programs.
fn csv(kinds: &[KindSummary]) -> String {
    let mut rows = Vec::new();
    for kind in kinds {
        let name = if kind.kind.is_empty() { "all" } else { kind.kind.as_str() };
        for parameter in &kind.parameters {
            let ParameterSummary { name: derivative, fits, estimate, variance, scatter } = parameter;
            rows.push((name, derivative, fits, estimate, scatter, variance[0]));
        }
    }
    csv_text(&["kind", "derivative", "manoeuvres", "mean", "min", "max", "scatter", "mean_variance"], rows)
}
