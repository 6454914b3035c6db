//! A picture of plots that leaves the window: as drawing, as pixels, as numbers.

use std::fmt::Write;

use doublet_core::series::{Series, Window};
use eframe::egui::Color32;

/// A curve of a figure.
#[derive(Clone, Debug, Default)]
pub struct FigureCurve {
    /// Name in the legend and at the head of its column, with its unit where it has one.
    pub name: String,
    /// Colour.
    pub color: Color32,
    /// Drawn dashed.
    pub dashed: bool,
    /// Unbroken lines, in the units of the axes.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Single points.
    pub dots: Vec<[f64; 2]>,
    /// Filled stretches between a lower and an upper edge: `[x, low, high]`.
    pub bands: Vec<Vec<[f64; 3]>>,
    /// Filled from zero: `[left, right, height]`.
    pub bars: Vec<[f64; 3]>,
    /// The numbers behind it.
    pub data: FigureData,
}

/// The numbers behind a curve.
#[derive(Clone, Debug)]
pub enum FigureData {
    /// Samples in SI and the factor to the unit of the axis; all samples inside the range of the figure are written.
    Samples(Series, f64),
    /// Points as drawn.
    Points(Vec<[f64; 2]>),
}

impl Default for FigureData {
    fn default() -> Self {
        Self::Points(Vec::new())
    }
}

/// One plot of a figure.
#[derive(Clone, Debug, Default)]
pub struct FigurePlot {
    /// Label of the upright axis, with its unit.
    pub label: String,
    /// Height in points.
    pub height: f64,
    /// Ends of the upright axis.
    pub range: (f64, f64),
    /// Level lines.
    pub levels: Vec<f64>,
    /// Coloured stretches of the level axis.
    pub spans: Vec<(f64, f64, Color32)>,
    /// Curves, first drawn first.
    pub curves: Vec<FigureCurve>,
    /// Words at places of the level axis instead of numbers.
    pub places: Vec<(f64, String)>,
}

/// A matrix as coloured cells.
#[derive(Clone, Debug, Default)]
pub struct FigureMatrix {
    /// Names of rows and columns.
    pub labels: Vec<String>,
    /// Values by rows.
    pub values: Vec<f64>,
    /// Colours by rows.
    pub colors: Vec<Color32>,
}

/// Plots under one another over one axis, or a matrix.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// Name proposed for its file.
    pub name: String,
    /// Width in points.
    pub width: f64,
    /// Label of the level axis, with its unit.
    pub label: String,
    /// Ends of the level axis.
    pub range: (f64, f64),
    /// Plots from top to bottom.
    pub plots: Vec<FigurePlot>,
    /// A matrix in place of plots.
    pub matrix: Option<FigureMatrix>,
}

/// What a figure is wanted as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureForm {
    /// Pixels.
    Png,
    /// A drawing.
    Svg,
    /// Numbers in a file.
    Csv,
    /// Numbers in the clipboard.
    Copy,
}

impl FigureForm {
    /// Every form with its line in a menu.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Png, "Save as PNG…"),
        (Self::Svg, "Save as SVG…"),
        (Self::Csv, "Save data as CSV…"),
        (Self::Copy, "Copy data"),
    ];

    /// Ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Svg => "svg",
            Self::Csv | Self::Copy => "csv",
        }
    }
}

/// A figure and what to do with it.
#[derive(Clone, Debug)]
pub struct FigureRequest {
    /// The figure.
    pub figure: Figure,
    /// What it is wanted as.
    pub form: FigureForm,
}

impl Figure {
    /// The figure with the plot `row` alone.
    #[must_use]
    pub fn only(mut self, row: usize) -> Self {
        self.plots = self.plots.into_iter().skip(row).take(1).collect();
        self
    }

    /// The numbers behind the figure: one column for the level axis, one per curve, every row one place on it. Samples of
    /// different clocks keep their own rows.
    pub fn csv(&self) -> String {
        if let Some(matrix) = &self.matrix {
            return matrix.csv();
        }
        let curves: Vec<&FigureCurve> = self.plots.iter().flat_map(|plot| &plot.curves).collect();
        let columns: Vec<Vec<[f64; 2]>> = curves.iter().map(|curve| curve.data.rows(self.range)).collect();
        let mut text = quoted(&self.label);
        for curve in &curves {
            text.push(',');
            text.push_str(&quoted(&curve.name));
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
}

/// Rows of curves that do not run along the axis: one curve after the other.
fn one_by_one(columns: &[Vec<[f64; 2]>]) -> String {
    let mut text = String::new();
    for (column, rows) in columns.iter().enumerate() {
        for [x, y] in rows {
            let _ = writeln!(text, "{x}{}{y}{}", ",".repeat(column + 1), ",".repeat(columns.len() - column - 1));
        }
    }
    text
}

/// A cell of a table: in quotes where it has to be.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

impl FigureData {
    /// Every number inside `range` of the level axis, in the units of the axes.
    fn rows(&self, range: (f64, f64)) -> Vec<[f64; 2]> {
        match self {
            Self::Points(points) => points.clone(),
            Self::Samples(series, scale) => {
                let inside = Window { start_s: range.0, end_s: range.1 }.indices(&series.time_s);
                inside.map(|at| [series.time_s[at], scale * series.values[at]]).collect()
            }
        }
    }
}

impl FigureMatrix {
    fn csv(&self) -> String {
        let size = self.labels.len();
        let mut text = String::new();
        for label in &self.labels {
            text.push(',');
            text.push_str(&quoted(label));
        }
        text.push('\n');
        for (row, label) in self.labels.iter().enumerate() {
            text.push_str(&quoted(label));
            for value in &self.values[row * size..(row + 1) * size] {
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(step_s: f64, count: usize) -> FigureCurve {
        let time_s = (0..count).map(|k| k as f64 * step_s).collect();
        let values = (0..count).map(|k| if k == 2 { f64::NAN } else { k as f64 }).collect();
        let data = FigureData::Samples(Series { time_s, values }, 10.0);
        FigureCurve { name: format!("every {step_s} s, all"), data, ..Default::default() }
    }

    #[test]
    fn numbers_of_curves_with_different_clocks_share_the_rows_they_have_in_common() {
        let plot = FigurePlot { curves: vec![samples(1.0, 5), samples(1.5, 3)], ..Default::default() };
        let label = "time [s]".to_owned();
        let figure = Figure { label, range: (0.5, 3.5), plots: vec![plot], ..Default::default() };
        let expected = "time [s],\"every 1 s, all\",\"every 1.5 s, all\"\n1,10,\n1.5,,10\n2,,\n3,30,\n";
        assert_eq!(figure.csv(), expected);
    }

    #[test]
    fn a_matrix_keeps_its_names_on_both_sides() {
        let matrix = FigureMatrix {
            labels: vec!["a".to_owned(), "b".to_owned()],
            values: vec![1.0, -0.5, -0.5, 1.0],
            colors: vec![Color32::BLACK; 4],
        };
        let figure = Figure { matrix: Some(matrix), ..Default::default() };
        assert_eq!(figure.csv(), ",a,b\na,1,-0.5\nb,-0.5,1\n");
    }
}
