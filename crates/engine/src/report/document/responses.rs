//! Section on frequency responses and low-order equivalent systems.

use super::bode::{BodeModel, bode_figure};
use super::{Block, Contents, Figure, paragraph};
use crate::notation;
use crate::report::responses::SystemRow;
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::study::SurfaceResponse;

/// A Bode plot for each control with its equivalent system, and the parameters of all.
pub fn responses(contents: &Contents<'_>) -> Vec<Block> {
    let Some(found) = contents.snapshot.studies.responses.ready() else {
        return Vec::new();
    };
    let mut blocks = vec![paragraph(
        "Responses of the rates to the controls over all single-control manoeuvres: composites of several spectral window lengths, with 95 % bars of the random error. The low-order equivalent systems are fitted to the transforms of the records \
         by output error; intervals hold 95 %. Points of low coherence are omitted. The identified model is linearised at the median condition of the manoeuvres.",
    )];
    blocks.extend(found.surfaces.iter().filter_map(surface_figure).map(Block::Figure));
    let systems = &contents.results.studies.equivalent_systems;
    blocks.push(Block::Table(parameters(systems.iter().filter(|row| row.error.is_none()))));
    let failed = systems.iter().filter_map(|row| Some(format!("{}: {}", row.input, row.error.as_ref()?)));
    let failed: Vec<String> = failed.collect();
    if !failed.is_empty() {
        blocks.push(Block::List(failed));
    }
    blocks
}

/// Bode plot of one control's response with its equivalent system.
pub fn surface_figure(surface: &SurfaceResponse) -> Option<Figure> {
    let study = surface.response.as_ref().ok()?;
    let model = |system: &crate::study::EquivalentStudy| {
        Some(BodeModel::pair("equivalent system", &system.fit.model, study.responses.get(system.input)?))
    };
    let mut models: Vec<BodeModel> = surface.system.as_ref().ok().and_then(model).into_iter().flatten().collect();
    if let Some(response) = study.responses.first().filter(|_| !surface.model.is_empty()) {
        models.push(BodeModel::of_values("identified model", &surface.model, response));
    }
    bode_figure(study, 0, &models)
}

fn parameters<'r>(rows: impl Iterator<Item = &'r SystemRow>) -> Table {
    TableOf::new("equivalent_systems", "Low-order equivalent systems; the gain in SI units and rad.", rows)
        .text("response", "Response", |row| row.output.as_str())
        .text("input", "to", |row| row.input.as_str())
        .text("form", "Form", |row| row.form.as_str())
        .column(Column::new("name", "Parameter"), |row| Cell::text(notation::system_parameter(&row.name).0))
        .text("unit", "Unit", |row| notation::system_parameter(&row.name).1)
        .number("value", "Value", "", 4, |row| row.value)
        .number("standard_error", "Std error", "", 2, |row| row.standard_error)
        .number("low", "Low", "", 4, |row| row.low)
        .number("high", "High", "", 4, |row| row.high)
        .done()
}
