//! Section on the independent checks: every window again in the frequency domain and by output error.

use super::{Block, Contents, paragraph};
use crate::report::studies::CheckRow;
use crate::report::table::{Cell, Column, Table};

/// Derivatives by every method, how well the flights of output error follow, and what was found about them.
pub fn checks(contents: &Contents<'_>) -> Vec<Block> {
    let studies = &contents.results.studies;
    if studies.checks.is_empty() {
        return vec![paragraph("The windows were not checked by other methods.")];
    }
    let (outputs, estimates): (Vec<_>, Vec<_>) =
        studies.checks.iter().partition(|row| row.largest_deviation.is_finite());
    let mut blocks = vec![
        paragraph(
            "Each window again by equation error in the frequency domain and by output error: the estimated derivatives fly the \
             recorded controls, the motion of the other axis as reconstructed.",
        ),
        Block::Table(derivatives(&estimates)),
    ];
    if !outputs.is_empty() {
        blocks.push(Block::Table(followed(&outputs)));
    }
    let lines =
        studies.check_findings.iter().map(|found| format!("{}: {}: {}", found.level.name(), found.place, found.text));
    let lines: Vec<String> = lines.collect();
    if !lines.is_empty() {
        blocks.push(Block::List(lines));
    }
    blocks
}

fn derivatives(rows: &[&CheckRow]) -> Table {
    let finite = |value: f64| Cell::maybe(value.is_finite().then_some(value));
    let row = |row: &&CheckRow| {
        vec![
            Cell::text(&row.window),
            Cell::text(row.method),
            Cell::Symbol(row.derivative.clone()),
            finite(row.estimate),
            finite(row.standard_error),
            finite(row.equation_error),
            finite(row.equation_standard_error),
        ]
    };
    // Initial states and biases belong to one window and have no twin.
    let of_model = rows.iter().filter(|row| !row.derivative.ends_with(']') && row.error.is_none());
    Table {
        name: "checks".to_owned(),
        caption: "Derivatives of each window by other methods beside equation error in the time domain.".to_owned(),
        columns: vec![
            Column::new("window", "Window"),
            Column::new("method", "Method"),
            Column::new("derivative", "Derivative"),
            Column::number("estimate", "Estimate", "", 4),
            Column::number("standard_error", "Std error", "", 2),
            Column::number("equation_error", "Equation error", "", 4),
            Column::number("equation_standard_error", "Std error", "", 2),
        ],
        rows: of_model.map(row).collect(),
    }
}

fn followed(rows: &[&CheckRow]) -> Table {
    let row = |row: &&CheckRow| {
        vec![
            Cell::text(&row.window),
            Cell::text(row.axis),
            Cell::text(&row.derivative),
            Cell::Number(row.r_squared),
            Cell::Number(row.largest_deviation),
        ]
    };
    Table {
        name: "followed".to_owned(),
        caption: "How the flight of output error follows the recorded outputs; deviations in SI units.".to_owned(),
        columns: vec![
            Column::new("window", "Window"),
            Column::new("axis", "Motion"),
            Column::new("output", "Output"),
            Column::number("r_squared", "R²", "", 3),
            Column::number("largest_deviation", "Largest deviation", "", 3),
        ],
        rows: rows.iter().map(row).collect(),
    }
}
