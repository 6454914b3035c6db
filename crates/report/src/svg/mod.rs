//! Figures as SVG, one unit a point: the only plot writer, for HTML, PDF and what leaves the window alike.

pub mod axis;
mod plot;
mod strokes;

use std::fmt::Write;

use doublet_engine::notation::{is_direction_mark, significant};
use doublet_engine::report::document::{Colour, Figure, LineStyle, Mark, Matrix, Panel};

pub use plot::{Range, range};
use strokes::{Shape, Strokes, draw_shape};

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

/// A colour as SVG writes it.
fn ink(Colour([red, green, blue]): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Characters with a meaning in SVG and HTML as entities; those no XML may hold and those that change the direction of the text behind
/// them are left out.
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
            hidden if hidden.is_control() || is_direction_mark(hidden) => {}
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
    let strokes = Strokes::of_figure(figure);
    let legend = legend_rows(legend(figure, &strokes));
    let top = legend.len() as f64 * LEGEND;
    let body = figure.panel_height_mm * MM;
    let under = axis::UNDER;
    let last_under = figure.panels.iter().map(|panel| match panel {
        Panel::Plot(_) => axis::TITLE_UNDER,
        Panel::Matrix(matrix) if columns == 1 => longest(&matrix.names) * CAPITAL,
        Panel::Matrix(_) => 0.0,
    });
    let last_under = last_under.fold(0.0, f64::max);
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
            Panel::Plot(axes) => plot::label_width(axes, range, body),
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
            Panel::Plot(plot) => plot::draw(&mut svg, plot, (range, &strokes), area, is_last),
            Panel::Matrix(matrix) => draw_matrix(&mut svg, matrix, area, columns == 1),
        }
    }
    svg.out.push_str("</svg>");
    svg.out
}

fn longest(names: &[String]) -> f64 {
    names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64
}

/// What a legend shows of a mark.
enum Sample {
    /// With the attribute of its dashes.
    Line(String),
    /// With its opacity.
    Area(&'static str),
    Point(Shape),
}

/// Label, colour and sample of a mark.
type LegendEntry<'a> = (&'a str, Colour, Sample);

/// Every label once, in the order it is drawn first.
fn legend<'a>(figure: &'a Figure, strokes: &Strokes) -> Vec<LegendEntry<'a>> {
    let mut entries: Vec<LegendEntry<'_>> = Vec::new();
    for panel in &figure.panels {
        let Panel::Plot(plot) = panel else { continue };
        for mark in &plot.marks {
            let entry = match mark {
                Mark::Line { label, colour, style, .. } | Mark::Points { label, colour, style, .. } => {
                    let sample = match style {
                        LineStyle::Dots => Sample::Point(strokes.shape(*colour)),
                        LineStyle::Solid | LineStyle::Dashed => Sample::Line(strokes.dashes(*style, *colour)),
                    };
                    (label.as_ref(), *colour, sample)
                }
                Mark::Band { label, colour, .. }
                | Mark::Bars { label, colour, .. }
                | Mark::Level { label, colour, .. } => (label.as_ref(), *colour, Sample::Area("0.25")),
                Mark::Span { label, colour, .. } => (label.as_ref(), *colour, Sample::Area(strokes.opacity(*colour))),
            };
            if !entry.0.is_empty() && !entries.iter().any(|(label, ..)| *label == entry.0) {
                entries.push(entry);
            }
        }
    }
    entries
}

/// Room an entry of a legend takes.
fn entry_width(label: &str) -> f64 {
    21.0 + label.chars().count() as f64 * CHARACTER + 14.0
}

/// The entries line by line, none wider than the figure unless it is alone.
fn legend_rows(entries: Vec<LegendEntry<'_>>) -> Vec<Vec<LegendEntry<'_>>> {
    let mut rows: Vec<Vec<LegendEntry<'_>>> = Vec::new();
    let mut right = f64::INFINITY;
    for entry in entries {
        right += entry_width(entry.0);
        match rows.last_mut() {
            Some(row) if right <= WIDTH => row.push(entry),
            _ => {
                right = entry_width(entry.0);
                rows.push(vec![entry]);
            }
        }
    }
    rows
}

fn draw_legend(svg: &mut Svg<'_>, rows: &[Vec<LegendEntry<'_>>]) {
    for (row, entries) in rows.iter().enumerate() {
        let mut x = 2.0;
        let y = (row as f64 + 0.5) * LEGEND;
        for (label, colour, sample) in entries {
            let ink = ink(*colour);
            match sample {
                Sample::Line(dash) => {
                    svg.rule((x, y), (x + 18.0, y), &format!("stroke=\"{ink}\" stroke-width=\"1.2\"{dash}"));
                }
                Sample::Area(opacity) => svg.put(format_args!(
                    "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"14\" height=\"6\" fill=\"{ink}\" fill-opacity=\"{opacity}\"/>",
                    y - 3.0
                )),
                Sample::Point(shape) => svg.out.push_str(&draw_shape((x + 7.0, y), &ink, *shape)),
            }
            svg.text(x + 21.0, y + 0.36 * TEXT, "start", label);
            x += entry_width(label);
        }
    }
}

/// Squares coloured by sign and size, with their numbers; the names also under the columns where there is room.
fn draw_matrix(svg: &mut Svg<'_>, matrix: &Matrix, area: Area, names_under: bool) {
    let count = matrix.names.len().max(1);
    let size = (area.width.min(area.height)) / count as f64;
    svg.text(area.x, area.y - 4.0, "start", &matrix.title);
    let small = (0.34 * size).min(TEXT - 1.0);
    for (column, name) in matrix.names.iter().enumerate().filter(|_| names_under) {
        let (x, y) = (area.x + (column as f64 + 0.5) * size + 0.36 * TEXT, area.y + count as f64 * size + 3.0);
        let name = escape(name);
        svg.put(format_args!(
            "<text transform=\"translate({x:.1},{y:.1}) rotate(-90)\" text-anchor=\"end\">{name}</text>"
        ));
    }
    for (row, values) in matrix.values.iter().enumerate() {
        let y = area.y + row as f64 * size;
        svg.text(area.x - 3.0, y + size / 2.0 + 0.36 * TEXT, "end", &matrix.names[row]);
        for (column, &value) in values.iter().enumerate() {
            let x = area.x + column as f64 * size;
            let (ink, strength) = if value.is_finite() {
                (if value < 0.0 { "#2166ac" } else { "#b2442c" }, (value / matrix.full_scale).abs().min(1.0))
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
