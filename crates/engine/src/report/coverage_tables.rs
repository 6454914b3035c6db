//! Tables of what simulated flights show: coverage of the intervals, and levels against the truth.

use super::table::{Cell, Column, Table, TableOf};
use crate::study::{Coverage, ModeCoverage};
use crate::verdict::CaseCounts;

/// Share of the 95 % intervals of each derivative that contain the truth.
pub fn coverage_table(found: &Coverage) -> Table {
    TableOf::new("coverage", "Fraction of the 95 % intervals that contain the truth.", &found.derivatives)
        .symbol("derivative", "derivative", |row| &row.name)
        .number("truth", "truth", "", 4, |row| row.truth)
        .number("mean", "mean", "", 4, |row| row.mean)
        .number("scatter", "scatter", "", 3, |row| row.scatter)
        .number("bias_over_scatter", "bias/scatter", "", 2, |row| row.bias)
        .number("standard_error", "std error", "", 3, |row| row.standard_error)
        .number("corrected_error", "corrected", "", 3, |row| row.corrected_error)
        .number("conventional_percent", "conventional", "%", 3, |row| 100.0 * row.conventional)
        .number("corrected_percent", "corrected", "%", 3, |row| 100.0 * row.corrected)
        .done()
}

/// Share of the 95 % intervals of each figure of a mode that contain the truth.
pub fn mode_coverage_table(found: &ModeCoverage) -> Table {
    TableOf::new("mode_coverage", "Fraction of the 95 % intervals that contain the truth.", &found.figures)
        .text("mode", "mode", |row| row.mode)
        .column(Column::new("figure", "figure"), |row| Cell::text(format!("{:?}", row.figure).to_lowercase()))
        .number("truth", "truth", "", 4, |row| row.truth)
        .number("scatter", "scatter", "", 3, |row| row.scatter)
        .number("bias_over_scatter", "bias/scatter", "", 2, |row| row.bias)
        .number("standard_error", "std error", "", 3, |row| row.standard_error)
        .number("delta_percent", "by slopes", "%", 3, |row| 100.0 * row.delta)
        .number("sampled_percent", "by samples", "%", 3, |row| 100.0 * row.sampled)
        .count("flights", "flights", |row| row.flights)
        .done()
}

/// Levels of simulated flights, case by case, against what is true of them.
pub fn case_table(cases: &[CaseCounts]) -> Table {
    let counts = |counts: [usize; 3]| Cell::text(counts.map(|count| count.to_string()).join(" / "));
    let pair =
        |row: &CaseCounts, level: usize| Cell::text(format!("{} right {} wrong", row.right[level], row.wrong[level]));
    TableOf::new("cases", "Levels of simulated flights against the truth.", cases)
        .text("case", "case", |row| row.name)
        .column(Column::new("sessions", "good / caution / bad"), |row| counts(row.sessions))
        .column(Column::new("good", "good"), |row| pair(row, 0))
        .count("wrong_that_matter", "wrong that matter", |row| row.wrong_that_matter)
        .column(Column::new("caution", "caution"), |row| pair(row, 1))
        .column(Column::new("bad", "bad"), |row| pair(row, 2))
        .column(Column::new("faults", "named / noticed / silent"), |row| counts(row.faults))
        .done()
}
