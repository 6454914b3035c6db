//! Figures as SVG, and as pixels made from it.

use std::fmt::Write;
use std::sync::Arc;

use eframe::egui::Color32;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use super::figure::{Figure, FigureCurve, FigureMatrix, FigurePlot};
use super::ticks::{round_step, tick};
use crate::theme;

/// Room left of the frames for value labels, right of them, above and below them.
const MARGINS: [f64; 4] = [78.0, 18.0, 10.0, 46.0];
/// Space between two plots.
const GAP: f64 = 8.0;
/// Least height of one plot.
const LEAST_HEIGHT: f64 = 90.0;
/// Least distance between the ticks of the level and of an upright axis.
const SPACING: [f64; 2] = [80.0, 26.0];
/// Pixels per point of a picture.
const PIXELS: f32 = 2.0;
/// Size of a cell of a matrix.
const CELL: f64 = 46.0;

/// Where the frame of a plot is and what it shows.
struct View {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: (f64, f64),
    y: (f64, f64),
}

impl View {
    fn x(&self, value: f64) -> f64 {
        self.left + self.width * (value - self.x.0) / (self.x.1 - self.x.0)
    }

    fn y(&self, value: f64) -> f64 {
        self.top + self.height * (self.y.1 - value) / (self.y.1 - self.y.0)
    }

    /// `x,y` on the page.
    fn at(&self, [x, y]: [f64; 2]) -> String {
        format!("{:.2},{:.2}", self.x(x), self.y(y))
    }
}

/// The figure as SVG on white ground.
pub fn svg(figure: &Figure) -> String {
    match &figure.matrix {
        Some(matrix) => matrix_svg(matrix),
        None => plots_svg(figure),
    }
}

/// The figure as PNG, two pixels to the point.
///
/// # Errors
/// One line when it cannot be drawn, for example because it is too large.
pub fn png(figure: &Figure) -> Result<Vec<u8>, String> {
    let mut fonts = Database::new();
    fonts.load_font_data(theme::FONT.to_vec());
    let options = Options { fontdb: Arc::new(fonts), font_family: "DejaVu Sans".to_owned(), ..Options::default() };
    let tree = Tree::from_str(&svg(figure), &options).map_err(|error| format!("the figure: {error}"))?;
    let size = tree.size().to_int_size().scale_by(PIXELS).ok_or("the figure has no size")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the figure is too large for a picture")?;
    resvg::render(&tree, Transform::from_scale(PIXELS, PIXELS), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| format!("the figure: {error}"))
}

/// Head of a page.
fn page(width: f64, height: f64) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"DejaVu Sans\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A colour of the window as it is printed on white.
fn hex(color: Color32) -> String {
    let [red, green, blue, _] = theme::printed(color).to_array();
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Round values between the ends of an axis `length` points long, and their step.
fn marks((low, high): (f64, f64), length: f64, spacing: f64) -> (Vec<f64>, f64) {
    let step = round_step((high - low) * spacing / length.max(1.0));
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    let count = (last - first).clamp(-1.0, 1000.0) as i64 + 1;
    ((0..count).map(|k| (first + k as f64) * step).collect(), step)
}

fn plots_svg(figure: &Figure) -> String {
    let [left, right, above, below] = MARGINS;
    let heights: Vec<f64> = figure.plots.iter().map(|plot| plot.height.max(LEAST_HEIGHT)).collect();
    let height = above + heights.iter().map(|height| height + GAP).sum::<f64>() + below;
    let mut out = page(figure.width, height);
    let mut top = above;
    for (row, (plot, &height)) in figure.plots.iter().zip(&heights).enumerate() {
        let width = figure.width - left - right;
        let view = View { left, top, width, height, x: figure.range, y: plot.range };
        plot_svg(&mut out, plot, &view, row, row + 1 == figure.plots.len());
        top += height + GAP;
    }
    let middle = left + 0.5 * (figure.width - left - right);
    let _ = writeln!(
        out,
        "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n</svg>",
        height - 8.0,
        escaped(&figure.label)
    );
    out
}

/// Frame, grid, labels and curves of one plot.
fn plot_svg(out: &mut String, plot: &FigurePlot, view: &View, row: usize, last: bool) {
    let View { left, top, width, height, .. } = *view;
    let _ = writeln!(
        out,
        "<clipPath id=\"frame{row}\"><rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/></clipPath>"
    );
    let _ = writeln!(out, "<g clip-path=\"url(#frame{row})\">");
    for &(start, end, color) in &plot.spans {
        let (x0, x1) = (view.x(start), view.x(end));
        let (x0, x1) = (x0.max(left), x1.min(left + width));
        if x1 > x0 {
            let color = hex(color);
            let _ = writeln!(
                out,
                "<rect x=\"{x0:.2}\" y=\"{top:.1}\" width=\"{:.2}\" height=\"{height:.1}\" fill=\"{color}\" fill-opacity=\"0.1\"/>",
                x1 - x0
            );
        }
    }
    out.push_str("</g>\n");
    axes_svg(out, plot, view, last);
    let _ = writeln!(out, "<g clip-path=\"url(#frame{row})\">");
    for &level in &plot.levels {
        let y = view.y(level);
        let _ = writeln!(
            out,
            "<path d=\"M{left:.1},{y:.2}h{width:.1}\" stroke=\"#808890\" stroke-dasharray=\"4 3\" fill=\"none\"/>"
        );
    }
    plot.curves.iter().for_each(|curve| curve_svg(out, curve, view));
    out.push_str("</g>\n");
    let mut x = left + 8.0;
    for curve in plot.curves.iter().filter(|curve| !curve.name.is_empty()) {
        let name = escaped(&curve.name);
        let (y, color) = (top + 13.0, hex(curve.color));
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1},{:.1}h14\" stroke=\"{color}\" stroke-width=\"2\"/><text x=\"{:.1}\" y=\"{y:.1}\">{name}</text>",
            y - 4.0,
            x + 18.0
        );
        x += 32.0 + 6.6 * curve.name.chars().count() as f64;
    }
}

/// Grid, ticks, their labels, and the frame.
fn axes_svg(out: &mut String, plot: &FigurePlot, view: &View, last: bool) {
    let View { left, top, width, height, .. } = *view;
    let grid = "stroke=\"#dfe5ec\" fill=\"none\"";
    let (values, step) = marks(view.y, height, SPACING[1]);
    for value in values {
        let (y, text) = (view.y(value), tick(value, step));
        let _ = writeln!(
            out,
            "<path d=\"M{left:.1},{y:.2}h{width:.1}\" {grid}/><text x=\"{:.1}\" y=\"{:.2}\" text-anchor=\"end\">{text}</text>",
            left - 5.0,
            y + 4.0
        );
    }
    let (values, step) = marks(view.x, width, SPACING[0]);
    let numbers = values.into_iter().map(|value| (value, tick(value, step)));
    let places: Vec<(f64, String)> = if plot.places.is_empty() { numbers.collect() } else { plot.places.clone() };
    for (value, text) in places {
        let x = view.x(value);
        let _ = writeln!(out, "<path d=\"M{x:.2},{top:.1}v{height:.1}\" {grid}/>");
        if last {
            let y = top + height + 15.0;
            let text = escaped(&text);
            let _ = writeln!(out, "<text x=\"{x:.2}\" y=\"{y:.1}\" text-anchor=\"middle\">{text}</text>");
        }
    }
    let (x, y, label) = (16.0, top + 0.5 * height, escaped(&plot.label));
    let _ = writeln!(
        out,
        "<text transform=\"translate({x},{y:.1}) rotate(-90)\" text-anchor=\"middle\">{label}</text>\n<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"#56606b\"/>"
    );
}

fn curve_svg(out: &mut String, curve: &FigureCurve, view: &View) {
    let color = hex(curve.color);
    for band in &curve.bands {
        let upper = band.iter().map(|&[x, _, high]| view.at([x, high]));
        let lower = band.iter().rev().map(|&[x, low, _]| view.at([x, low]));
        let points: Vec<String> = upper.chain(lower).collect();
        let _ = writeln!(out, "<polygon points=\"{}\" fill=\"{color}\" fill-opacity=\"0.2\"/>", points.join(" "));
    }
    for &[left, right, height] in &curve.bars {
        let (x0, x1) = (view.x(left), view.x(right));
        let (y0, y1) = (view.y(0.0), view.y(height));
        let (top, tall) = (y0.min(y1), (y0 - y1).abs());
        let _ = writeln!(
            out,
            "<rect x=\"{x0:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{tall:.2}\" fill=\"{color}\" fill-opacity=\"0.6\"/>",
            (x1 - x0).max(0.5)
        );
    }
    let dashes = if curve.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
    for line in &curve.lines {
        let points: Vec<String> = line.iter().map(|&point| view.at(point)).collect();
        let points = points.join(" ");
        let _ = writeln!(
            out,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.4\"{dashes}/>"
        );
    }
    for &[x, y] in &curve.dots {
        let _ = writeln!(out, "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"1.8\" fill=\"{color}\"/>", view.x(x), view.y(y));
    }
}

fn matrix_svg(matrix: &FigureMatrix) -> String {
    let size = matrix.labels.len();
    let extent = CELL * size as f64;
    let side = 24.0 + 6.6 * matrix.labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64;
    let mut out = page(side + extent + 20.0, side + extent + 20.0);
    for (at, label) in matrix.labels.iter().enumerate() {
        let (middle, label) = (side + (at as f64 + 0.5) * CELL, escaped(label));
        let _ = writeln!(
            out,
            "<text x=\"{0:.1}\" y=\"{1:.1}\" text-anchor=\"end\">{label}</text>\n<text transform=\"translate({1:.1},{0:.1}) rotate(-90)\">{label}</text>",
            side - 6.0,
            middle + 4.0
        );
    }
    for (at, value) in matrix.values.iter().enumerate() {
        let (row, column) = (at / size, at % size);
        let (x, y) = (side + column as f64 * CELL, side + row as f64 * CELL);
        let color = matrix.colors.get(at).copied().unwrap_or(Color32::WHITE);
        let [red, green, blue, _] = color.to_array();
        let dark = 0.3 * f64::from(red) + 0.59 * f64::from(green) + 0.11 * f64::from(blue) < 140.0;
        let ink = if dark { "#ffffff" } else { "#000000" };
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"#{red:02x}{green:02x}{blue:02x}\" stroke=\"#ffffff\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{ink}\">{value:.2}</text>",
            x + 0.5 * CELL,
            y + 0.5 * CELL + 4.0
        );
    }
    out.push_str("</svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure() -> Figure {
        let curve = FigureCurve {
            name: "q & r".to_owned(),
            color: theme::DARK.series[1],
            lines: vec![vec![[0.0, -1.0], [10.0, 1.0]]],
            dots: vec![[5.0, 0.0]],
            ..Default::default()
        };
        let plot = FigurePlot {
            label: "q [deg/s]".to_owned(),
            height: 200.0,
            range: (-1.0, 1.0),
            curves: vec![curve],
            ..Default::default()
        };
        Figure {
            name: "f".to_owned(),
            width: 496.0,
            label: "time [s]".to_owned(),
            range: (0.0, 10.0),
            plots: vec![plot],
            matrix: None,
        }
    }

    #[test]
    fn points_lie_where_their_values_are_and_dark_colours_are_printed_for_white() {
        let text = svg(&figure());
        // The frame is 400 by 200 points at (78, 10).
        assert!(text.contains("<polyline points=\"78.00,210.00 478.00,10.00\""), "{text}");
        assert!(text.contains("cx=\"278.00\" cy=\"110.00\""));
        assert!(text.contains("q &amp; r") && text.contains("#d55e00") && !text.contains("#ffa64d"));
    }

    #[test]
    fn the_picture_has_two_pixels_to_the_point_and_holds_the_curve() {
        let bytes = png(&figure()).expect("it can be drawn");
        let picture = Pixmap::decode_png(&bytes).expect("it is a picture");
        assert_eq!((picture.width(), picture.height()), (2 * 496, 2 * 264));
        // The dot at (278, 110) points.
        let pixel = picture.pixel(556, 220).expect("it lies inside");
        assert_eq!((pixel.red(), pixel.green(), pixel.blue()), (0xd5, 0x5e, 0x00));
    }
}
