//! Parts of a document on screen: words, facts, tables, figures, as a report has them.

use doublet_engine::report::document::Block;
use doublet_engine::report::{Cell, Table};
use eframe::egui::{self, Grid, Label, RichText, ScrollArea, TextStyle, Ui};
use egui_extras::{Column, TableBuilder};

use super::figure::FigureRequest;
use super::figure_view::figure_view;
use super::term::column_title_called;
use crate::theme;

/// Rows of a table shown before one has to scroll in it.
const ROWS: usize = 12;
/// Height of a row of one line.
const ROW: f32 = 18.0;
/// Characters of a cell that stays on one line.
const SHORT: usize = 36;
/// Width of a column with longer ones.
const WIDE: f32 = 270.0;

/// Draws one block below the other; a figure that was asked for in its menu.
pub fn document_view(ui: &mut Ui, blocks: &[Block]) -> Option<FigureRequest> {
    let mut wanted = None;
    for (index, block) in blocks.iter().enumerate() {
        ui.push_id(index, |ui| wanted = draw(block, ui).or(wanted.take()));
        ui.add_space(8.0);
    }
    wanted
}

fn draw(block: &Block, ui: &mut Ui) -> Option<FigureRequest> {
    match block {
        Block::Figure(figure) => return figure_view(ui, figure),
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
        Block::Lines(count) => (0..*count).for_each(|_| drop(ui.separator())),
    }
    None
}

/// Columns of a table on screen.
struct Columns {
    /// Whether a column has words that may break over lines.
    wide: Vec<bool>,
    /// Height of each row.
    heights: Vec<f32>,
}

impl Columns {
    fn of(table: &Table, texts: &[Vec<String>], ui: &Ui) -> Self {
        let is_wide = |column: usize| texts.iter().any(|row| row[column].chars().count() > SHORT);
        let wide: Vec<bool> = (0..table.columns.len()).map(is_wide).collect();
        let font = TextStyle::Body.resolve(ui.style());
        let height = |row: &Vec<String>| {
            let lines = row.iter().zip(&wide).filter(|(_, wide)| **wide).map(|(text, _)| {
                let galley = ui.painter().layout(text.clone(), font.clone(), ui.visuals().text_color(), WIDE);
                galley.size().y + 2.0
            });
            lines.fold(ROW, f32::max)
        };
        let heights = texts.iter().map(height).collect();
        Self { wide, heights }
    }
}

fn draw_table(table: &Table, ui: &mut Ui) {
    ui.add(Label::new(RichText::new(&table.caption).size(11.5).weak()).wrap());
    let cells = |row: &Vec<Cell>| row.iter().zip(&table.columns).map(|(cell, of)| cell.readable(of.digits)).collect();
    let texts: Vec<Vec<String>> = table.rows.iter().map(cells).collect();
    let columns = Columns::of(table, &texts, ui);
    let figures = theme::figures(ui);
    let shown: f32 = columns.heights.iter().take(ROWS).map(|height| height + 4.0).sum();
    ScrollArea::horizontal().show(ui, |ui| {
        let mut builder =
            TableBuilder::new(ui).striped(true).vscroll(table.rows.len() > ROWS).max_scroll_height(shown + ROW + 4.0);
        for &wide in &columns.wide {
            builder = builder.column(match wide {
                true => Column::initial(WIDE).at_least(0.5 * WIDE).clip(true),
                false => Column::auto().at_least(44.0).clip(false),
            });
        }
        let header = |mut header: egui_extras::TableRow<'_, '_>| {
            for column in &table.columns {
                header.col(|ui| drop(column_title_called(ui, &column.title(), &column.heading)));
            }
        };
        builder.header(ROW, header).body(|body| {
            body.heterogeneous_rows(columns.heights.iter().copied(), |mut row| {
                let index = row.index();
                for ((text, cell), wide) in texts[index].iter().zip(&table.rows[index]).zip(&columns.wide) {
                    row.col(|ui| {
                        let text = RichText::new(text);
                        // Numbers and names stay on one line, words have as many as they need.
                        let text = if cell.is_quantity() { text.font(figures.clone()) } else { text };
                        ui.add(if *wide { Label::new(text).wrap() } else { Label::new(text).extend() });
                    });
                }
            });
        });
    });
}
