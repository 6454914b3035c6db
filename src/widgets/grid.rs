//! Striped tables that keep the size of their place.

use eframe::egui::{Align, AsIdSalt, Layout, Ui};
use egui_extras::TableBuilder;

/// A table of texts: cells from the left.
pub fn texts_grid(ui: &mut Ui, id: impl AsIdSalt) -> TableBuilder<'_> {
    striped(ui, id, Layout::left_to_right(Align::Center))
}

/// A table of numbers: cells from the right.
pub fn figures_grid(ui: &mut Ui, id: impl AsIdSalt) -> TableBuilder<'_> {
    striped(ui, id, Layout::right_to_left(Align::Center))
}

fn striped(ui: &mut Ui, id: impl AsIdSalt, cells: Layout) -> TableBuilder<'_> {
    TableBuilder::new(ui).id_salt(id).striped(true).auto_shrink(false).cell_layout(cells)
}
