//! A picture of plots that leaves the window: as drawing, as pixels, as numbers.

use std::fmt::Write;
use std::sync::Arc;

use doublet_core::series::TimeRange;
use doublet_engine::report::document::{Colour, Figure, Mark, Matrix, Panel};
use doublet_report::svg::svg;
use eframe::egui::{Color32, ColorImage};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use crate::theme;

/// Pixels per 96th of an inch: 170 mm then are 1,929 pixels wide.
const PIXELS: f32 = 3.0;

/// What a figure is wanted as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureForm {
    /// Pixels.
    Png,
    /// A drawing.
    Svg,
    /// Numbers in a file.
    Csv,
    /// Pixels in the clipboard.
    CopyPicture,
    /// Numbers in the clipboard.
    Copy,
    Report,
}

impl FigureForm {
    /// Every form with its line in a menu.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Report, "Add to the report"),
        (Self::Png, "Save as PNG…"),
        (Self::Svg, "Save as SVG…"),
        (Self::Csv, "Save data as CSV…"),
        (Self::CopyPicture, "Copy picture"),
        (Self::Copy, "Copy data"),
    ];

    /// Whether it goes into the clipboard.
    pub fn is_copy(self) -> bool {
        matches!(self, Self::Copy | Self::CopyPicture)
    }

    /// Ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png | Self::CopyPicture => "png",
            Self::Svg | Self::Report => "svg",
            Self::Csv | Self::Copy => "csv",
        }
    }
}

/// A figure and what to do with it.
#[derive(Clone, Debug)]
pub struct FigureRequest {
    pub figure: Figure,
    /// What it is wanted as.
    pub form: FigureForm,
}

/// A colour of the window as it is printed on white.
pub fn printed(color: Color32) -> Colour {
    let [red, green, blue, _] = theme::printed(color).to_array();
    Colour([red, green, blue])
}

/// The figure as PNG on white.
pub fn png(figure: &Figure) -> Result<Vec<u8>, String> {
    pixels(figure)?.encode_png().map_err(|error| format!("the figure: {error}"))
}

/// The same for the clipboard.
pub fn picture(figure: &Figure) -> Result<ColorImage, String> {
    let pixels = pixels(figure)?;
    let size = [pixels.width(), pixels.height()].map(|side| side as usize);
    // On white nothing is transparent.
    Ok(ColorImage::from_rgba_unmultiplied(size, pixels.data()))
}

fn pixels(figure: &Figure) -> Result<Pixmap, String> {
    drawn(&svg(figure, "p"), |_| PIXELS)
}

/// A drawing on white, `width` pixels wide.
pub fn page_picture(svg: &str, width: u32) -> Result<ColorImage, String> {
    let pixels = drawn(svg, |own| width as f32 / own.max(1.0))?;
    let size = [pixels.width(), pixels.height()].map(|side| side as usize);
    Ok(ColorImage::from_rgba_unmultiplied(size, pixels.data()))
}

/// A drawing on white, magnified as its own width asks for.
fn drawn(svg: &str, scale: impl Fn(f32) -> f32) -> Result<Pixmap, String> {
    let mut fonts = Database::new();
    fonts.load_font_data(theme::font().to_vec());
    let options = Options { fontdb: Arc::new(fonts), font_family: "DejaVu Sans".to_owned(), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| format!("the figure: {error}"))?;
    let scale = scale(tree.size().width());
    let size = tree.size().to_int_size().scale_by(scale).ok_or("the figure has no size")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the figure is too large for a picture")?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels)
}

/// The numbers behind a figure: one column for the level axis, one per curve, every row one place on it. Samples of different
/// clocks keep their own rows.
pub fn csv(figure: &Figure) -> String {
    let mut plots = Vec::new();
    for panel in &figure.panels {
        match panel {
            Panel::Plot(plot) => plots.push(plot),
            Panel::Matrix(matrix) => return matrix_csv(matrix),
        }
    }
    let marks = plots.iter().flat_map(|plot| plot.marks.iter().filter_map(|mark| rows(mark, plot.x.range)));
    let (names, columns): (Vec<&str>, Vec<Vec<[f64; 2]>>) = marks.unzip();
    let mut text = quoted(&plots.first().map_or_else(String::new, |plot| plot.x.title()));
    for name in names {
        text.push(',');
        text.push_str(&quoted(name));
    }
    text.push('\n');
    let ordered = columns.iter().all(|rows| rows.is_sorted_by(|a, b| a[0] <= b[0]));
    if !ordered {
        return text + &one_by_one(&columns);
    }
    let mut at = vec![0; columns.len()];
    loop {
        let heads = columns.iter().zip(&at).filter_map(|(rows, &at)| rows.get(at)).map(|row| row[0]);
        let Some(x) = heads.reduce(f64::min) else { break };
        let _ = write!(text, "{x}");
        for (rows, at) in columns.iter().zip(&mut at) {
            text.push(',');
            if let Some(row) = rows.get(*at).filter(|row| row[0] == x) {
                if row[1].is_finite() {
                    let _ = write!(text, "{}", row[1]);
                }
                *at += 1;
            }
        }
        text.push('\n');
    }
    text
}

/// Name and numbers of a curve inside `range` of the level axis, in the units of the axes; none of what only surrounds curves.
fn rows(mark: &Mark, range: Option<[f64; 2]>) -> Option<(&str, Vec<[f64; 2]>)> {
    match mark {
        Mark::Line { label, series, scale, .. } => {
            let [start_s, end_s] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let inside = TimeRange { start_s, end_s }.indices(&series.time_s);
            Some((label, inside.map(|at| [series.time_s[at], scale * series.values[at]]).collect()))
        }
        Mark::Points { label, points, .. } => Some((label, points.iter().map(|&[x, y, _]| [x, y]).collect())),
        Mark::Bars { label, bars, .. } => Some((label, bars.clone())),
        Mark::Band { .. } | Mark::Level { .. } | Mark::Span { .. } => None,
    }
}

/// Rows of curves that do not run along the axis: one curve after the other.
fn one_by_one(columns: &[Vec<[f64; 2]>]) -> String {
    let mut text = String::new();
    for (column, rows) in columns.iter().enumerate() {
        for [x, y] in rows.iter().filter(|row| row.iter().all(|value| value.is_finite())) {
            let _ = writeln!(text, "{x}{}{y}{}", ",".repeat(column + 1), ",".repeat(columns.len() - column - 1));
        }
    }
    text
}

/// A cell of a table: in quotes where it has to be.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

fn matrix_csv(matrix: &Matrix) -> String {
    let names = matrix.names.iter().map(|name| quoted(name));
    let mut text = names.clone().fold(String::new(), |head, name| head + "," + &name) + "\n";
    for (name, values) in names.zip(&matrix.values) {
        text += &name;
        for value in values {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use doublet_core::series::Series;
    use doublet_engine::report::document::{Axis, LineStyle, Plot};

    use super::*;

    fn samples(step_s: f64, count: usize) -> Mark {
        let time_s = (0..count).map(|k| k as f64 * step_s).collect();
        let values = (0..count).map(|k| if k == 2 { f64::NAN } else { k as f64 }).collect();
        let label = format!("every {step_s} s, all").into();
        let colour = printed(theme::DARK.series[1]);
        Mark::Line { label, colour, style: LineStyle::Solid, series: Series { time_s, values }, scale: 10.0 }
    }

    fn figure(panel: Panel) -> Figure {
        Figure::new("f", "f", (1, 50.0), vec![panel])
    }

    fn plot(range: [f64; 2], marks: Vec<Mark>) -> Figure {
        let x = Axis { range: Some(range), ..Axis::time() };
        let y = Axis { range: Some([-1.0, 1.0]), ..Axis::new("q", "deg/s") };
        figure(Panel::Plot(Plot { x, y, marks }))
    }

    #[test]
    fn numbers_of_curves_with_different_clocks_share_the_rows_they_have_in_common() {
        let expected = "time [s],\"every 1 s, all\",\"every 1.5 s, all\"\n1,10,\n1.5,,10\n2,,\n3,30,\n";
        assert_eq!(csv(&plot([0.5, 3.5], vec![samples(1.0, 5), samples(1.5, 3)])), expected);
    }

    #[test]
    fn a_matrix_keeps_its_names_on_both_sides() {
        let (names, values) = (vec!["a".to_owned(), "b".to_owned()], vec![vec![1.0, -0.5], vec![-0.5, 1.0]]);
        let matrix = Matrix { title: "m".into(), names, values, full_scale: 1.0 };
        assert_eq!(csv(&figure(Panel::Matrix(matrix))), ",a,b\na,1,-0.5\nb,-0.5,1\n");
    }

    #[test]
    fn a_dark_colour_is_printed_for_white_in_drawing_and_picture_alike() {
        let label = "q & r".into();
        let colour = printed(theme::DARK.series[1]);
        // A bar over the whole plot.
        let bars = Mark::Bars { label, colour, width: 10.0, bars: vec![[5.0, 1.0], [5.0, -1.0]] };
        let figure = plot([0.0, 10.0], vec![bars]);
        let drawing = svg(&figure, "p");
        assert!(drawing.contains("q &amp; r") && drawing.contains("#d55e00") && !drawing.contains("#ffa64d"));
        let picture = Pixmap::decode_png(&png(&figure).expect("it can be drawn")).expect("it is a picture");
        assert_eq!(picture.width(), 1929);
        let pixel = picture.pixel(964, picture.height() / 2 + 7).expect("it lies inside");
        // 0.6 of the colour on white.
        let blended = [0xd5, 0x5e, 0x00].map(|part: i32| 255 - (3 * (255 - part)) / 5);
        let found = [pixel.red(), pixel.green(), pixel.blue()].map(i32::from);
        assert!(found.iter().zip(blended).all(|(a, b)| (a - b).abs() <= 2), "{found:?}, not {blended:?}");
    }
}
