//! Figures as SVG, one unit a point: the only plot writer, for HTML, PDF and tests alike.

mod axis;
mod decimate;
mod plot;

use std::fmt::Write;

use doublet_engine::report::document::{Figure, Mark, Matrix, Panel};
use doublet_engine::report::significant;

pub use decimate::decimate;
pub use plot::{Range, range};

/// Colours that stay apart for the common colour-vision deficiencies.
pub const PALETTE: [&str; 8] = ["#0068b4", "#d55e00", "#00876c", "#b5478f", "#a87b00", "#8c2d19", "#5a4fcf", "#56606b"];
/// Width of every figure: 170 mm.
pub const WIDTH: f64 = 170.0 * MM;
/// Points in a millimetre.
const MM: f64 = 72.0 / 25.4;
/// Size of text.
const TEXT: f64 = 7.0;
/// Width of a typical character at that size.
const CHARACTER: f64 = 0.58 * TEXT;
/// The same of names that begin with capitals.
const CAPITAL: f64 = 0.68 * TEXT;
/// Space between panels.
const GAP: f64 = 9.0;
/// Height of the line above a panel that names its vertical axis.
const TITLE: f64 = 11.0;
/// Height of the legend.
const LEGEND: f64 = 13.0;

/// Text being written.
struct Svg<'a> {
    out: String,
    /// Identifiers begin with this.
    prefix: &'a str,
    clips: usize,
}

/// A rectangle on the page, y downwards.
#[derive(Clone, Copy, Debug)]
struct Area {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// The colour at a place of the palette.
fn colour(index: usize) -> &'static str {
    PALETTE[index % PALETTE.len()]
}

/// Characters with a meaning in SVG and HTML as entities; those no XML may hold are left out.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            control if control.is_control() => {}
            other => escaped.push(other),
        }
    }
    escaped
}

impl Svg<'_> {
    /// Adds formatted text.
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.out.write_fmt(text);
    }

    /// A line of text; `anchor` is `start`, `middle` or `end`.
    fn text(&mut self, x: f64, y: f64, anchor: &str, text: &str) {
        let text = escape(text);
        self.put(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>"));
    }

    /// A straight line.
    fn rule(&mut self, from: (f64, f64), to: (f64, f64), style: &str) {
        let ((x1, y1), (x2, y2)) = (from, to);
        self.put(format_args!("<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" {style}/>"));
    }
}

/// The figure as a whole SVG document; `prefix` keeps its identifiers apart from those of other figures on one page.
pub fn svg(figure: &Figure, prefix: &str) -> String {
    let columns = figure.columns.max(1).min(figure.panels.len().max(1));
    let rows = figure.panels.len().div_ceil(columns);
    let legend = legend(figure);
    let top = if legend.is_empty() { 0.0 } else { LEGEND };
    let body = figure.panel_height_mm * MM;
    let under = axis::UNDER;
    let last_under =
        if figure.panels.iter().any(|panel| matches!(panel, Panel::Plot(_))) { axis::TITLE_UNDER } else { 0.0 };
    let row_height = TITLE + body + under + GAP / 2.0;
    let height = top + rows as f64 * row_height + last_under;
    let mut svg = Svg { out: String::new(), prefix, clips: 0 };
    svg.put(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH:.1} {height:.1}\" width=\"{WIDTH:.1}pt\" \
         height=\"{height:.1}pt\" font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\" font-size=\"{TEXT}\" \
         fill=\"#1d2530\" role=\"img\"><title>{}</title>",
        escape(&figure.caption)
    ));
    draw_legend(&mut svg, &legend);
    let ranges: Vec<_> = figure.panels.iter().map(plot::range).collect();
    let left = figure
        .panels
        .iter()
        .zip(&ranges)
        .map(|(panel, range)| match panel {
            Panel::Plot(_) => plot::label_width(range, body),
            Panel::Matrix(matrix) => longest(&matrix.names) * CAPITAL + 4.0,
        })
        .fold(0.0, f64::max);
    let width = (WIDTH - GAP * (columns - 1) as f64) / columns as f64;
    for (index, (panel, range)) in figure.panels.iter().zip(&ranges).enumerate() {
        let (row, column) = (index / columns, index % columns);
        let area = Area {
            x: column as f64 * (width + GAP) + left,
            y: top + row as f64 * row_height + TITLE,
            width: width - left - 4.0,
            height: body,
        };
        let is_last = index + columns >= figure.panels.len();
        match panel {
            Panel::Plot(plot) => plot::draw(&mut svg, plot, range, area, is_last),
            Panel::Matrix(matrix) => draw_matrix(&mut svg, matrix, area),
        }
    }
    svg.out.push_str("</svg>");
    svg.out
}

fn longest(names: &[String]) -> f64 {
    names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64
}

/// What a legend shows of a mark.
#[derive(Clone, Copy, PartialEq)]
enum Sample {
    Line { dashed: bool },
    Area,
    Point,
}

/// Every label once, in the order it is drawn first.
fn legend(figure: &Figure) -> Vec<(&'static str, usize, Sample)> {
    let mut entries: Vec<(&'static str, usize, Sample)> = Vec::new();
    for panel in &figure.panels {
        let Panel::Plot(plot) = panel else { continue };
        for mark in &plot.marks {
            let entry = match *mark {
                Mark::Line { label, colour, dashed, .. } => (label, colour, Sample::Line { dashed }),
                Mark::Band { label, colour, .. }
                | Mark::Level { label, colour, .. }
                | Mark::Span { label, colour, .. } => (label, colour, Sample::Area),
                Mark::Points { label, colour, .. } => (label, colour, Sample::Point),
            };
            if !entries.iter().any(|(label, ..)| *label == entry.0) {
                entries.push(entry);
            }
        }
    }
    entries
}

fn draw_legend(svg: &mut Svg<'_>, entries: &[(&'static str, usize, Sample)]) {
    let mut x = 2.0;
    let y = LEGEND / 2.0;
    for &(label, index, sample) in entries {
        let ink = colour(index);
        match sample {
            Sample::Line { dashed } => {
                let dash = if dashed { " stroke-dasharray=\"4 2.5\"" } else { "" };
                svg.rule((x, y), (x + 14.0, y), &format!("stroke=\"{ink}\" stroke-width=\"1.2\"{dash}"));
            }
            Sample::Area => svg.put(format_args!(
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"14\" height=\"6\" fill=\"{ink}\" fill-opacity=\"0.25\"/>",
                y - 3.0
            )),
            Sample::Point => {
                svg.put(format_args!("<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"1.7\" fill=\"{ink}\"/>", x + 7.0));
            }
        }
        svg.text(x + 18.0, y + 0.36 * TEXT, "start", label);
        x += 18.0 + label.chars().count() as f64 * CHARACTER + 14.0;
    }
}

/// Squares coloured from -1 to 1, with their numbers.
fn draw_matrix(svg: &mut Svg<'_>, matrix: &Matrix, area: Area) {
    let count = matrix.names.len().max(1);
    let size = (area.width.min(area.height)) / count as f64;
    svg.text(area.x, area.y - 4.0, "start", &matrix.title);
    let small = (0.34 * size).min(TEXT - 1.0);
    for (row, values) in matrix.values.iter().enumerate() {
        let y = area.y + row as f64 * size;
        svg.text(area.x - 3.0, y + size / 2.0 + 0.36 * TEXT, "end", &matrix.names[row]);
        for (column, &value) in values.iter().enumerate() {
            let x = area.x + column as f64 * size;
            let (ink, strength) = if value.is_finite() {
                (if value < 0.0 { "#2166ac" } else { "#b2442c" }, value.abs())
            } else {
                ("#808080", 0.0)
            };
            svg.put(format_args!(
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{size:.1}\" height=\"{size:.1}\" fill=\"{ink}\" \
                 fill-opacity=\"{strength:.2}\" stroke=\"#dfe5ec\" stroke-width=\"0.4\"/>"
            ));
            let text = if value.is_finite() { format!("{value:.2}") } else { significant(value, 2) };
            let fill = if strength > 0.6 { "#ffffff" } else { "#1d2530" };
            svg.put(format_args!(
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"{small:.1}\" fill=\"{fill}\">{}</text>",
                x + size / 2.0,
                y + size / 2.0 + 0.36 * small,
                text.replace('-', "\u{2212}")
            ));
        }
    }
}
