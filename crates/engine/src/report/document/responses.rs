//! Section on frequency responses and low-order equivalent systems.

use super::bode::{BodeModel, bode_figure};
use super::{Block, Contents, Figure, paragraph};
use crate::notation;
use crate::report::responses::SystemRow;
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::session::Level;
use crate::study::SurfaceResponse;

/// A Bode plot for each control with its equivalent system, and the parameters of all.
pub fn responses(contents: &Contents<'_>) -> Vec<Block> {
    let Some(found) = contents.snapshot.studies.responses.ready() else {
        return Vec::new();
    };
    let mut blocks = vec![paragraph(
        "Responses of the rates to the controls over all single-control manoeuvres: composites of several spectral window lengths, with 95 % bars of the random error. The low-order equivalent systems are fitted to the transforms of the records \
         by output error; intervals hold 95 %. A mismatch cost (Tischler and Remple, chapter 11) above 50 is a caution, above 100 bad. Points of low coherence are omitted. The identified model is linearised at the median condition of the manoeuvres.",
    )];
    let side_by_side = |figure: Figure| Block::Figure(Figure { columns: 3, panel_height_mm: 38.0, ..figure });
    blocks.extend(found.surfaces.iter().filter_map(surface_figure).map(side_by_side));
    let systems = &contents.results.studies.equivalent_systems;
    blocks.push(Block::Table(parameters(systems.iter().filter(|row| row.error.is_none()))));
    let failed = systems.iter().filter_map(|row| Some(format!("{}: {}", row.input, row.error.as_ref()?)));
    let judged = found.surfaces.iter().filter_map(|surface| Some((surface, surface.system.as_ref().ok()?)));
    let doubted = judged.flat_map(|(surface, system)| {
        let reasons = system.verdict.reasons.iter().filter(|reason| reason.level > Level::Good);
        reasons.map(|reason| format!("{}: {}", surface.surface.role().name(), reason.text))
    });
    let listed: Vec<String> = failed.chain(doubted).collect();
    if !listed.is_empty() {
        blocks.push(Block::List(listed));
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
        .number("cost", "Mismatch cost", "", 2, |row| row.cost)
        .text("verdict", "Verdict", |row| row.verdict)
        .done()
}
