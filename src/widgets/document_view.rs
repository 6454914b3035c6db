//! Parts of a document on screen: words, facts, tables, figures, as a report has them.

use doublet_engine::report::Table;
use doublet_engine::report::document::Block;
use eframe::egui::{self, Grid, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::figure_view::figure_view;
use crate::theme;

/// Rows of a table shown before one has to scroll in it.
const ROWS: usize = 12;
/// Height of a row.
const ROW: f32 = 18.0;

/// Draws one block below the other.
pub fn document_view(ui: &mut Ui, blocks: &[Block]) {
    for (index, block) in blocks.iter().enumerate() {
        ui.push_id(index, |ui| draw(block, ui));
        ui.add_space(8.0);
    }
}

fn draw(block: &Block, ui: &mut Ui) {
    match block {
        Block::Heading(text) => drop(ui.label(RichText::new(text).size(11.5).strong())),
        Block::Paragraph(text) => {
            ui.add(egui::Label::new(text).wrap());
        }
        Block::Facts(facts) => {
            Grid::new("facts").num_columns(2).spacing([12.0, 3.0]).show(ui, |ui| {
                for (name, text) in facts {
                    ui.weak(name);
                    ui.add(egui::Label::new(text).wrap());
                    ui.end_row();
                }
            });
        }
        Block::List(lines) => lines.iter().for_each(|line| {
            ui.add(egui::Label::new(format!("• {line}")).wrap());
        }),
        Block::Outcome(level, text) => {
            ui.label(RichText::new(text).strong().color(theme::palette(ui).of_level(*level)));
        }
        Block::Table(table) => draw_table(table, ui),
        Block::Figure(figure) => figure_view(ui, figure),
        Block::Lines(count) => (0..*count).for_each(|_| drop(ui.separator())),
    }
}

fn draw_table(table: &Table, ui: &mut Ui) {
    ui.label(RichText::new(&table.caption).size(11.5).weak());
    let figures = theme::figures(ui);
    #[expect(clippy::cast_precision_loss, reason = "a dozen rows")]
    let height = (table.rows.len().min(ROWS) + 1) as f32 * (ROW + 4.0);
    ScrollArea::horizontal().show(ui, |ui| {
        TableBuilder::new(ui)
            .striped(true)
            .vscroll(table.rows.len() > ROWS)
            .max_scroll_height(height)
            .columns(Column::auto().at_least(44.0).clip(false), table.columns.len())
            .header(ROW, |mut header| {
                for column in &table.columns {
                    header.col(|ui| {
                        ui.weak(column.title());
                    });
                }
            })
            .body(|body| {
                body.rows(ROW, table.rows.len(), |mut row| {
                    let cells = &table.rows[row.index()];
                    for (cell, column) in cells.iter().zip(&table.columns) {
                        row.col(|ui| {
                            ui.label(RichText::new(cell.readable(column.digits)).font(figures.clone()));
                        });
                    }
                });
            });
    });
}
