//! Levels of flying qualities by a low-order equivalent system, as rows.

use doublet_dynamics::qualities::{Airplane, Limits, QualityLevel};
use serde::Serialize;

use super::dynamics::{QualitiesRow, probabilities, quality_row};
use super::dynamics_tables::level_table;
use super::table::Table;
use crate::notation;
use crate::session::Surface;
use crate::study::{EquivalentLevels, EquivalentStudy, FlightResponses};

/// Levels by the equivalent system of one response.
#[derive(Clone, Debug, Serialize)]
pub struct ResponseLevelsRow {
    pub input: String,
    pub output: String,
    /// Levels of the criteria that the system has values for.
    pub qualities: QualitiesRow,
}

/// Levels of the criteria that an equivalent system of an output has values for, each with its probability: the share of 2000 models drawn
/// from the covariance of the fit. None of them where the poles of a form have no names. A system whose verdict is bad has no level: its
/// criteria are not judged, and the reason is stated.
pub fn equivalent_levels(found: &EquivalentStudy, output: &str, limits: &Limits, airplane: &Airplane) -> QualitiesRow {
    let from = format!("class {} and category {} as stated", airplane.class, airplane.category);
    equivalent_levels_row(&EquivalentLevels::judge(found, output, limits, (airplane, &from)))
}

/// Levels by an equivalent system as rows.
fn equivalent_levels_row(found: &EquivalentLevels) -> QualitiesRow {
    let EquivalentLevels { judgement, shares, sampled, airplane, .. } = found;
    let mut row = QualitiesRow {
        standard: found.standard.clone(),
        date: found.date.clone(),
        class: airplane.class,
        category: airplane.category,
        airplane_from: found.airplane_from.clone(),
        level: judgement.level.map(QualityLevel::name),
        probabilities: probabilities(shares, "all"),
        criteria: judgement.qualities.iter().map(|quality| quality_row(quality, shares, sampled, None)).collect(),
        stick_delay_s: None,
        aileron_rad: None,
        note: found.note.clone(),
        map: Vec::new(),
    };
    if let Some(reason) = &found.withdrawn {
        withdraw(&mut row, reason);
    }
    row
}

/// Takes the levels back that rest on a system whose verdict is bad.
fn withdraw(row: &mut QualitiesRow, reason: &str) {
    (row.level, row.probabilities) = (None, None);
    for criterion in &mut row.criteria {
        criterion.level = "not judged";
        criterion.probabilities = None;
        criterion.reasons.clear();
        criterion.needed = Some(format!("an equivalent system that fits; the verdict on this one is bad: {reason}"));
    }
}

/// Levels of every response of a session, by the standard that judges by default; none of a response whose system has no named mode.
pub(super) fn response_levels(found: &FlightResponses) -> Vec<ResponseLevelsRow> {
    let levels = found.surfaces.iter().filter_map(|surface| Some((surface, &surface.levels.first()?.1)));
    let rows = levels.map(|(surface, levels)| response_levels_row(surface.surface, levels));
    rows.filter(|row| !row.qualities.criteria.is_empty()).collect()
}

/// Levels by the equivalent system of the response of a rate to its control.
pub fn response_levels_row(surface: Surface, levels: &EquivalentLevels) -> ResponseLevelsRow {
    let [input, output] = [surface.role(), surface.rate()].map(|role| role.name().to_owned());
    ResponseLevelsRow { input, output, qualities: equivalent_levels_row(levels) }
}

/// Levels of the criteria of a response that are judged; none where none of them is.
pub fn response_level_table(row: &ResponseLevelsRow) -> Option<Table> {
    let [output, input] = [&row.output, &row.input].map(|name| notation::role_symbol(name));
    let caption = format!(
        "Levels by the equivalent system of {output} to {input} with 95 % intervals and probabilities; levels in brackets do not count."
    );
    let table = Table { name: format!("equivalent_levels_{}", row.input), caption, ..level_table(&row.qualities) };
    (!table.rows.is_empty()).then_some(table)
}
