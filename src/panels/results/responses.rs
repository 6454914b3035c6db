//! Frequency responses of the rates to the controls with low-order equivalent systems, on request.

use doublet_engine::report::document::surface_figure;
use doublet_engine::report::{response_level_table, response_levels_row};
use doublet_engine::run::Slot;
use doublet_engine::session::Surface;
use doublet_engine::study::dynamics::Standard;
use doublet_engine::study::{EquivalentStudy, ModeComparison, Study, SurfaceResponse};
use eframe::egui::{self, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use crate::command::{RunCommand, UiCommand};
use crate::panels::results::dynamics::{choose_standard, whole_table};
use crate::panels::{Panel, PanelContext, choices, dim_if, empty, offer, study_button, trouble};
use crate::widgets::figure_view::figure_view;
use crate::widgets::term::column_titles;
use crate::{notation, theme};

pub struct Responses {
    surface: Surface,
    /// Standard of the levels.
    standard: Standard,
}

impl Default for Responses {
    fn default() -> Self {
        Self { surface: Surface::Elevator, standard: Standard::default() }
    }
}

impl Panel for Responses {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = &ctx.snapshot.studies.responses;
        ui.horizontal_wrapped(|ui| {
            let hint = "Spectra of all single-control manoeuvres, with low-order equivalent systems";
            study_button(ctx, ui, (Study::Responses, slot), "Compute frequency responses", hint);
            let all = Surface::ALL.map(|surface| (surface, surface.name()));
            choices(ui, &mut self.surface, &all);
            choose_standard(ui, &mut self.standard);
        });
        trouble(ui, slot.error());
        let Some(study) = slot.latest() else {
            let text = "Frequency responses of the rates to each control, with low-order equivalent systems.";
            if !matches!(slot, Slot::Running { .. }) && offer(ui, text, "Compute them") {
                ctx.commands.push(UiCommand::Run(RunCommand::Study(Study::Responses)));
            }
            return;
        };
        dim_if(ui, slot.is_stale());
        let Some(found) = study.surfaces.iter().find(|found| found.surface == self.surface) else {
            return empty(ui, "No manoeuvre moves this control alone.");
        };
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| response(ui, found, self.standard));
    }
}

/// Bode plot, then the equivalent system with its levels.
fn response(ui: &mut Ui, found: &SurfaceResponse, standard: Standard) {
    match surface_figure(found) {
        Some(figure) => {
            ui.weak(
                "Dots: measured, with 95 % bars. Lines: the equivalent system, dashed as seen through spectral windows of this length, and the identified model. Frequencies in rad/s.",
            );
            figure_view(ui, &figure);
        }
        None => trouble(ui, found.response.as_ref().err().map(ToString::to_string).as_deref()),
    }
    match &found.system {
        Ok(system) => {
            judgement(ui, system);
            parameters(ui, system);
            levels(ui, found, standard);
        }
        Err(error) => trouble(ui, Some(&error.to_string())),
    }
    found.modes.iter().for_each(|compared| compared_mode(ui, compared));
}

/// Levels of the criteria that the equivalent system has values for.
fn levels(ui: &mut Ui, found: &SurfaceResponse, standard: Standard) {
    let Some((_, levels)) = found.levels.iter().find(|(judging, _)| *judging == standard) else { return };
    let row = response_levels_row(found.surface, levels);
    ui.add_space(6.0);
    match response_level_table(&row) {
        Some(table) => {
            let text = format!("{}, {}", row.qualities.standard, row.qualities.airplane_from);
            ui.add(egui::Label::new(text).wrap());
            ScrollArea::horizontal().id_salt("levels").show(ui, |ui| whole_table(ui, &table));
        }
        None => drop(ui.weak("No level: the equivalent system is rejected or its poles have no names.")),
    }
}

/// Why the system is rejected or doubtful.
fn judgement(ui: &mut Ui, system: &EquivalentStudy) {
    if system.is_rejected() {
        trouble(ui, Some("Rejected: do not use these parameters."));
    }
    for reason in &system.verdict.reasons {
        ui.add(egui::Label::new(format!("{} {}", reason.text, reason.fix_text)).wrap());
    }
}

/// A quantity of a mode by the ways that give it, as a contradiction where two intervals do not overlap.
fn compared_mode(ui: &mut Ui, compared: &ModeComparison) {
    if let Some(found) = compared.finding() {
        return trouble(ui, Some(&format!("{} {}", found.text, found.fix_text)));
    }
    let ways = compared.ways().map(|(name, found)| {
        let [value, low, high] = [found.value, found.low, found.high].map(notation::number);
        format!("{name} {value} ({low} to {high})")
    });
    let (mode, quantity) = (compared.mode, compared.quantity);
    let unit = if quantity.unit().is_empty() { String::new() } else { format!(" {}", quantity.unit()) };
    ui.weak(format!("{mode} {}: {}{unit}", quantity.name(), ways.collect::<Vec<_>>().join(", ")));
}

/// Parameters and what follows from them, with 95 % intervals.
fn parameters(ui: &mut Ui, system: &EquivalentStudy) {
    let figures = theme::figures(ui);
    ui.weak(format!("{} form by {}, 95 % intervals", system.fit.form, system.method.name()));
    let rows: Vec<_> = system.fit.parameters.iter().chain(&system.derived).collect();
    TableBuilder::new(ui)
        .id_salt("equivalent system")
        .striped(true)
        .vscroll(false)
        .cell_layout(egui::Layout::right_to_left(egui::Align::Center))
        .column(Column::exact(96.0))
        .column(Column::exact(48.0))
        .columns(Column::exact(72.0), 4)
        .header(20.0, |header| column_titles(header, ["", "unit", "value", "std error", "low", "high"]))
        .body(|body| {
            body.rows(18.0, rows.len(), |mut row| {
                let parameter = rows[row.index()];
                let (symbol, unit) = doublet_engine::notation::system_parameter(&parameter.name);
                row.col(|ui| drop(ui.label(symbol)));
                row.col(|ui| drop(ui.weak(unit)));
                for value in [parameter.value, parameter.standard_error, parameter.low, parameter.high] {
                    row.col(|ui| {
                        ui.label(egui::RichText::new(notation::number(value)).font(figures.clone()));
                    });
                }
            });
        });
}
