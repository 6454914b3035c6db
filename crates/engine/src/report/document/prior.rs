//! The comparison of an earlier estimate with the flight, laid out.

use super::Block;
use crate::notation::format_by_error;
use crate::prior::{ConflictRow, PriorRequest, PriorStudy, PriorValue, ValueRow};
use crate::report::reference::Reference;
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::session::Level;

impl PriorRequest {
    /// An earlier estimate whose derivatives without a standard error are known to this part of their size.
    pub fn of_reference(reference: &Reference, relative: f64) -> Self {
        let value = |(name, mean, error): &(String, f64, Option<f64>)| PriorValue {
            name: name.clone(),
            mean: *mean,
            deviation: error.unwrap_or(relative * mean.abs()),
        };
        Self { name: reference.name.clone(), known: reference.values.iter().map(value).collect() }
    }
}

impl PriorStudy {
    /// The study laid out: what contradicts, a row per coefficient and a row per derivative.
    pub fn blocks(&self) -> Vec<Block> {
        let apart: Vec<&str> =
            self.coefficients.iter().filter(|row| row.is_contradiction()).map(|row| row.coefficient).collect();
        let outcome = match apart.as_slice() {
            [] => Block::Outcome(Level::Good, "Prior and flight agree".to_owned()),
            names => Block::Outcome(Level::Bad, format!("Prior and flight disagree on {}", names.join(", "))),
        };
        vec![outcome, Block::Table(coefficient_table(&self.coefficients)), Block::Table(self.table())]
    }

    /// A row per derivative.
    pub fn table(&self) -> Table {
        let shown = |own: ValueRow| {
            format_by_error(own.value, own.standard_error)
                + " ± "
                + &format_by_error(own.standard_error, own.standard_error)
        };
        let caption = "Each with its standard deviation; flight less prior in standard deviations of their difference.";
        TableOf::new("prior", caption, &self.derivatives)
            .symbol("name", "derivative", |row| &row.name)
            .column(Column::new("prior", "prior"), |row| row.prior.map_or(Cell::Empty, |own| Cell::text(shown(own))))
            .column(Column::new("flight", "flight"), |row| Cell::text(shown(row.flight)))
            .column(Column::new("combined", "combined"), |row| Cell::text(shown(row.combined)))
            .maybe("deviations", "flight less prior", "σ", 2, |row| row.deviations)
            .optional("conflict", "", |row| row.is_contradiction().then_some("contradicts"))
            .done()
    }
}

fn coefficient_table(rows: &[ConflictRow]) -> Table {
    let caption = "All derivatives of a coefficient together: squared distance of prior and flight over the errors of both, and how often chance exceeds it.";
    TableOf::new("prior_coefficients", caption, rows)
        .symbol("coefficient", "coefficient", |row| row.coefficient)
        .number("distance", "squared distance", "", 3, |row| row.distance)
        .count("degrees_of_freedom", "degrees of freedom", |row| row.degrees_of_freedom)
        .number("probability_percent", "by chance", "%", 2, |row| 100.0 * row.probability)
        .text("result", "result", |row| if row.is_contradiction() { "disagree" } else { "agree" })
        .done()
}
