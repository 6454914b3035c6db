//! Section on frequency responses and low-order equivalent systems.

use super::bode::{BodeModel, bode_figure};
use super::{Block, Contents, Figure, Parts, paragraph, table_or};
use crate::notation;
use crate::report::responses::{SystemRow, mode_comparison_table};
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::report::{QualitiesRow, ResponseLevelsRow, response_level_table};
use crate::session::{Finding, Level};
use crate::study::{EquivalentStudy, ModeComparison, SurfaceResponse};

/// A Bode plot for each control with its equivalent system, and the modes by all ways; in the appendix the parameters of the systems.
pub fn responses(contents: &Contents<'_>) -> Parts {
    let Some(found) = contents.snapshot.studies.responses.ready() else {
        return Parts::default();
    };
    let mut blocks = vec![paragraph(
        "Responses of the rates to the controls over all single-control manoeuvres: composites of several spectral window lengths, with 95 % bars of the random error. The low-order equivalent systems are fitted to the transforms of the records \
         by output error; intervals hold 95 %. A mismatch cost (Tischler and Remple, chapter 11) above 50 is a caution, above 100 bad. Points of low coherence are omitted. The identified model is linearised at the median condition of the manoeuvres.",
    )];
    let side_by_side = |figure: Figure| Block::Figure(Figure { columns: 3, panel_height_mm: 38.0, ..figure });
    blocks.extend(found.surfaces.iter().filter_map(surface_figure).map(side_by_side));
    let is_answer = |row: &&SystemRow| row.error.is_none() && row.verdict != Level::Bad.name();
    let accepted = parameters(contents.results.studies.equivalent_systems.iter().filter(is_answer));
    let listed: Vec<String> = found.surfaces.iter().flat_map(reservations).collect();
    if !listed.is_empty() {
        blocks.push(Block::List(listed));
    }
    blocks.extend(levels(&contents.results.studies.equivalent_levels));
    let compared = mode_comparison_table(&contents.results.studies.mode_comparison);
    blocks.extend((!compared.rows.is_empty()).then_some(Block::Table(compared)));
    Parts { body: blocks, appendix: vec![table_or(accepted, "No equivalent system fits its response.")] }
}

/// Levels by the equivalent system of every response, then the standard that judged.
fn levels(rows: &[ResponseLevelsRow]) -> Vec<Block> {
    let mut blocks: Vec<Block> = rows.iter().filter_map(response_level_table).map(Block::Table).collect();
    if let Some(ResponseLevelsRow { qualities, .. }) = rows.first().filter(|_| !blocks.is_empty()) {
        let QualitiesRow { standard, note, airplane_from, .. } = qualities;
        blocks.push(Block::Paragraph(format!("Levels by {standard} ({note}), {airplane_from}.")));
    }
    blocks
}

/// Why the equivalent system of a control is missing, rejected or doubtful.
fn reservations(surface: &SurfaceResponse) -> Vec<String> {
    let control = surface.surface.name();
    let system = match &surface.system {
        Ok(system) => system,
        Err(error) => return vec![format!("{control}: no equivalent system: {error}")],
    };
    let of_level = |reason: &&Finding| reason.level == system.verdict.level && reason.level > Level::Good;
    let is_rejected = system.is_rejected();
    let word = if is_rejected { format!("rejected, form {}: ", system.fit.form) } else { String::new() };
    system.verdict.reasons.iter().filter(of_level).map(|reason| format!("{control}: {word}{}", line(reason))).collect()
}

/// What was found and what to do, without the place.
fn line(found: &Finding) -> String {
    format!("{} {}", found.text, found.fix_text)
}

/// Modes on which responses, free responses and the identified model contradict each other, a line each.
pub(super) fn contradictions(contents: &Contents<'_>) -> Vec<String> {
    let study = contents.snapshot.studies.responses.ready();
    let compared = study.iter().flat_map(|study| study.compared_modes());
    compared.filter_map(ModeComparison::finding).map(|found| found.to_string()).collect()
}

/// Bode plot of one control's response with its equivalent system.
pub fn surface_figure(surface: &SurfaceResponse) -> Option<Figure> {
    let study = surface.response.as_ref().ok()?;
    let model = |system: &EquivalentStudy| {
        let label = if system.is_rejected() { "rejected system" } else { "equivalent system" };
        Some(BodeModel::pair(label, &system.fit.model, study.responses.get(system.input)?))
    };
    let mut models: Vec<BodeModel> = surface.system.as_ref().ok().and_then(model).into_iter().flatten().collect();
    if let Some(response) = study.responses.first().filter(|_| !surface.model.is_empty()) {
        models.push(BodeModel::of_values("identified model", &surface.model, response));
    }
    bode_figure(study, 0, &models)
}

fn parameters<'r>(rows: impl Iterator<Item = &'r SystemRow>) -> Table {
    TableOf::new(
        "equivalent_systems",
        "Accepted low-order equivalent systems; the gain in SI units and rad. A mismatch cost above 100 is rejected.",
        rows,
    )
    .text("response", "Response", |row| notation::role_symbol(&row.output))
    .text("input", "to", |row| notation::role_symbol(&row.input))
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
