//! The comparison of an earlier estimate with the flight, laid out.

use super::Block;
use crate::notation::significant;
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
    /// The study laid out: what contradicts, and a row per derivative.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = self.coefficients.iter().map(conflict).collect();
        blocks.push(Block::Table(self.table()));
        blocks
    }

    /// A row per derivative.
    pub fn table(&self) -> Table {
        let shown = |own: ValueRow| format!("{} ± {}", significant(own.value, 4), significant(own.standard_error, 2));
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

fn conflict(row: &ConflictRow) -> Block {
    Block::Outcome(if row.is_contradiction() { Level::Bad } else { Level::Good }, row.to_string())
}
