//! Section on the sensitivity of the derivatives (thesis Tables 7.2 to 7.12).

use super::{Block, Contents, Parts};
use crate::notation::{self, significant};
use crate::report::studies::{SensitivityRow, StudyResults, TornadoRow, TotalErrorRow};
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::study::STEP_FRACTION;

/// Change of the estimate, per cent, that rounding alone can cause.
const ROUNDING_PERCENT: f64 = 1e-9;

/// Partial derivatives of the estimates, one table per group of quantities, and what moves each estimate most.
pub fn sensitivity(contents: &Contents<'_>) -> Parts {
    let study = &contents.results.studies;
    if study.sensitivity.is_empty() {
        return Parts::default();
    }
    let percent = significant(100.0 * STEP_FRACTION, 2);
    let mut blocks = vec![Block::Paragraph(format!(
        "Change of each pooled derivative per unit of an input quantity, by central difference over one step. The step is {percent} % of the quantity, for the centre of gravity {percent} % of the chord; the appendix has both. It is not the accuracy of the quantity, which the files do not state: scale the change with the accuracy you know."
    ))];
    let mut appendix = vec![Block::Table(quantities(&study.sensitivity)), Block::Table(widest_table(study))];
    for (group, partials) in sensitivity_tables(study) {
        let (table, unmoved) = moved(partials);
        appendix.extend((!table.rows.is_empty()).then_some(Block::Table(table)));
        if !unmoved.is_empty() {
            let names: Vec<String> = unmoved.iter().map(|name| notation::derivative(name)).collect();
            appendix.push(Block::Paragraph(format!("Not changed by {group}: {}.", names.join(", "))));
        }
    }
    let totals = total_errors(study);
    blocks.extend((!totals.rows.is_empty()).then_some(Block::Table(totals)));
    Parts { body: blocks, appendix }
}

/// Partial derivatives of the estimates, a table for each group of quantities.
pub fn sensitivity_tables(study: &StudyResults) -> Vec<(&'static str, Table)> {
    let groups = distinct(study.sensitivity.iter().map(|row| row.table));
    let rows = |group: &str| study.sensitivity.iter().filter(|row| row.table == group).collect::<Vec<_>>();
    groups.into_iter().map(|group| (group, partials(group, &rows(group)))).collect()
}

/// The widest bar of each derivative.
pub fn widest_table(study: &StudyResults) -> Table {
    let names = distinct(study.tornado.iter().map(|bar| bar.derivative.as_str()));
    let bars = names.into_iter().filter_map(|name| study.tornado.iter().find(|bar| bar.derivative == name));
    TableOf::new("widest", "Dominant uncertainty of each derivative: change over one step down and up.", bars)
        .symbol("derivative", "Derivative", |bar| &bar.derivative)
        .text("quantity", "Quantity", |bar| notation::sensitivity_quantity(&bar.quantity))
        .number("low_percent", "Step down", "%", 3, |bar| bar.low_percent)
        .number("high_percent", "Step up", "%", 3, |bar| bar.high_percent)
        .number("in_standard_errors", "In corrected std errors", "", 3, |bar| bar.in_standard_errors)
        .done()
}

fn total_errors(study: &StudyResults) -> Table {
    let caption = "Error of each derivative by noise (corrected standard error), by an assumed error of one step in every quantity, \
                   and by both; the dominant quantity and the change over one step of it, down and up.";
    let rows = study.total_errors.iter().filter(|row| !row.derivative.ends_with("_0"));
    let rows = rows.map(|row| (row, study.tornado.iter().find(|bar| bar.derivative == row.derivative)));
    // What only rounding moved was not moved.
    let is_moved = |bar: &&TornadoRow| bar.low_percent.abs().max(bar.high_percent.abs()) > ROUNDING_PERCENT;
    let rows = rows.map(|(row, bar)| (row, bar.filter(is_moved)));
    let rows: Vec<(&TotalErrorRow, Option<&TornadoRow>)> = rows.collect();
    TableOf::new("total_errors", caption, rows)
        .symbol("derivative", "Derivative", |(row, _)| &row.derivative)
        .number("estimate", "Estimate", "", 4, |(row, _)| row.estimate)
        .number("standard_error", "Std error", "", 2, |(row, _)| row.standard_error)
        .number("by_quantities", "One step in each", "", 2, |(row, _)| {
            if row.by_quantities < 1e-2 * ROUNDING_PERCENT * row.estimate.abs() { 0.0 } else { row.by_quantities }
        })
        .number("total", "Noise and steps", "", 2, |(row, _)| row.total)
        .optional("quantity", "Dominant", |(_, bar)| bar.map(|bar| notation::sensitivity_quantity(&bar.quantity)))
        .maybe("low_percent", "Step down", "%", 3, |(_, bar)| bar.map(|bar| bar.low_percent))
        .maybe("high_percent", "Step up", "%", 3, |(_, bar)| bar.map(|bar| bar.high_percent))
        .done()
}

/// The rows in which something is not zero, and the derivatives of the others.
fn moved(mut table: Table) -> (Table, Vec<String>) {
    let mut unmoved = Vec::new();
    table.rows.retain(|row| {
        let moved = row.iter().any(|cell| matches!(cell, Cell::Number(value) if *value != 0.0));
        if let (false, Some(Cell::Symbol(name))) = (moved, row.first()) {
            unmoved.push(name.clone());
        }
        moved
    });
    (table, unmoved)
}

/// Each value once, in the order of first appearance.
fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

fn quantities(rows: &[SensitivityRow]) -> Table {
    let names = distinct(rows.iter().map(|row| row.quantity.as_str()));
    let first = names.into_iter().filter_map(|name| rows.iter().find(|row| row.quantity == name));
    let caption = "Quantities varied, and the step of each. Scales are per cent of the recorded value; the centre of gravity is aft of \
                   the leading edge of the mean chord, right of and above the datum, in per cent of the chord.";
    TableOf::new("quantities", caption, first)
        .text("quantity", "Quantity", |row| notation::sensitivity_quantity(&row.quantity))
        .text("unit", "Unit", |row| row.unit)
        .number("value", "Value", "", 4, |row| row.value)
        .number("step", "Step", "", 3, |row| row.step)
        .done()
}

fn partials(group: &str, rows: &[&SensitivityRow]) -> Table {
    let quantities = distinct(rows.iter().map(|row| row.quantity.as_str()));
    let mut columns = vec![Column::new("derivative", "Derivative")];
    columns.extend(quantities.iter().map(|&name| {
        let unit = rows.iter().find(|row| row.quantity == name).map_or("", |row| row.unit);
        let unit = if unit == "-" { "" } else { unit };
        Column::number(name, &format!("per {}", notation::sensitivity_quantity(name)), unit, 3)
    }));
    let table_rows = distinct(rows.iter().map(|row| row.derivative.as_str())).into_iter().map(|derivative| {
        let cell = |quantity: &&str| {
            let row = rows.iter().find(|row| row.quantity == *quantity && row.derivative == derivative);
            // What only rounding moved was not moved.
            Cell::maybe(row.map(|row| if row.relative_percent.abs() < ROUNDING_PERCENT { 0.0 } else { row.partial }))
        };
        std::iter::once(Cell::Symbol(derivative.to_owned())).chain(quantities.iter().map(cell)).collect()
    });
    Table {
        name: format!("sensitivity_{}", group.replace(' ', "_")),
        caption: format!("Sensitivity of the derivatives: {group}."),
        columns,
        rows: table_rows.collect(),
    }
}
