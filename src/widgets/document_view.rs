//! Parts of a document on screen: words, facts, tables, figures, as a report has them.

use doublet_engine::report::document::Block;
use doublet_engine::report::{Cell, Table};
use eframe::egui::{self, Align, FontId, Grid, Label, Layout, RichText, ScrollArea, TextStyle, Ui, WidgetText};
use egui_extras::{Column, TableBuilder};

use super::figure::FigureRequest;
use super::figure_view::figure_view;
use super::term::column_title_called;
use crate::{notation, theme};

/// Rows of a table shown before one has to scroll in it.
const ROWS: usize = 30;
/// Height of a row of one line.
const ROW: f32 = 18.0;
/// Characters of a cell that stays on one line.
const SHORT: usize = 36;
/// Width of a column with longer ones.
const WIDE: f32 = 270.0;
/// Room right of figures.
const FIGURE_ROOM: f32 = 6.0;
/// Least width of a column.
const LEAST: f32 = 44.0;

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
            ui.add(egui::Label::new(notation::typeset(text, 13.0)).wrap());
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
            ui.add(egui::Label::new(notation::typeset(&format!("• {line}"), 13.0)).wrap());
        }),
        Block::Outcome(level, text) => {
            ui.label(notation::typeset_in(text, 13.0, theme::palette(ui).of_level(*level)));
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
    /// Width of each column whose cells stay on one line.
    widths: Vec<f32>,
    /// Whether a column has quantities alone, which are set to the right.
    figures: Vec<bool>,
    heights: Vec<f32>,
}

/// Draws a cell, to the right where it is of a column of quantities.
fn aligned(ui: &mut Ui, is_figure: bool, draw: impl FnOnce(&mut Ui)) {
    let layout = if is_figure { Layout::right_to_left(Align::Center) } else { Layout::left_to_right(Align::Center) };
    ui.with_layout(layout, |ui| {
        if is_figure {
            ui.add_space(FIGURE_ROOM);
        }
        draw(ui);
    });
}

impl Columns {
    fn measure(table: &Table, texts: &[Vec<String>], ui: &Ui) -> Self {
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
        let is_figure = |column: usize| {
            let mut cells = table.rows.iter().map(|row| &row[column]).filter(|cell| !matches!(cell, Cell::Empty));
            let first = cells.next().is_some_and(Cell::is_quantity);
            first && cells.all(Cell::is_quantity)
        };
        let figures: Vec<bool> = (0..table.columns.len()).map(is_figure).collect();
        let font_of = |figure: bool| if figure { theme::figures(ui) } else { font.clone() };
        let width = |column: usize| {
            let ink = ui.visuals().text_color();
            let laid = |text: String, font: FontId| ui.painter().layout_no_wrap(text, font, ink).size().x;
            let longest = texts.iter().map(|row| &row[column]).max_by_key(|text| text.chars().count());
            let cells = longest.map_or(0.0, |text| laid(text.clone(), font_of(figures[column])));
            // Another cell of fewer letters may be a little wider.
            (1.08 * cells).max(laid(table.columns[column].title(), FontId::proportional(11.0))).max(LEAST)
                + 6.0
                + if figures[column] { FIGURE_ROOM } else { 0.0 }
        };
        let widths = (0..table.columns.len()).map(width).collect();
        Self { wide, widths, figures, heights }
    }
}

/// Draws a table below its caption.
pub fn draw_table(table: &Table, ui: &mut Ui) {
    ui.add(Label::new(RichText::new(&table.caption).size(11.5).weak()).wrap());
    let cells = |row: &Vec<Cell>| row.iter().zip(&table.columns).map(|(cell, of)| cell.readable(of.digits)).collect();
    let texts: Vec<Vec<String>> = table.rows.iter().map(cells).collect();
    let columns = Columns::measure(table, &texts, ui);
    let figures = theme::figures(ui);
    let shown: f32 = columns.heights.iter().take(ROWS).map(|height| height + 4.0).sum();
    ScrollArea::horizontal().show(ui, |ui| {
        let mut builder =
            TableBuilder::new(ui).striped(true).vscroll(table.rows.len() > ROWS).max_scroll_height(shown + ROW + 4.0);
        for (&wide, &width) in columns.wide.iter().zip(&columns.widths) {
            builder = builder.column(match wide {
                true => Column::initial(WIDE).at_least(0.5 * WIDE).clip(true),
                false => Column::exact(width),
            });
        }
        let header = |mut header: egui_extras::TableRow<'_, '_>| {
            for (at, column) in table.columns.iter().enumerate() {
                header.col(|ui| {
                    let titled = |ui: &mut Ui| drop(column_title_called(ui, &column.title(), &column.heading));
                    aligned(ui, columns.figures[at], titled);
                });
            }
        };
        builder.header(ROW, header).body(|body| {
            body.heterogeneous_rows(columns.heights.iter().copied(), |mut row| {
                let index = row.index();
                for (at, text) in texts[index].iter().enumerate() {
                    let text: WidgetText = match table.rows[index][at] {
                        ref cell if cell.is_quantity() => RichText::new(text).font(figures.clone()).into(),
                        Cell::Symbol(_) => notation::typeset(text, 13.0).into(),
                        _ => RichText::new(text).into(),
                    };
                    row.col(|ui| {
                        aligned(ui, columns.figures[at], |ui| {
                            // Numbers and names stay on one line, words have as many as they need.
                            ui.add(if columns.wide[at] { Label::new(text).wrap() } else { Label::new(text).extend() });
                        });
                    });
                }
            });
        });
    });
}
