//! Figures as data.

use std::sync::Arc;

use doublet_core::series::Series;

/// A figure: panels row by row under one legend.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name, unique in a document; that of its file where it is written alone.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// Panels beside each other.
    pub columns: usize,
    /// Height of the plotting area of a panel, mm.
    pub panel_height_mm: f64,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
}

/// One set of axes.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Lines, bands and points over two axes.
    Plot(Plot),
    /// Numbers from -1 to 1 as coloured squares.
    Matrix(Matrix),
}

/// Marks over two axes.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn, in this order.
    pub marks: Vec<Mark>,
}

/// What an axis shows.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Quantity.
    pub label: String,
    /// Unit; empty for a pure number.
    pub unit: String,
}

/// Correlations or the like.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Title.
    pub title: String,
    /// Name of each row and column.
    pub names: Vec<String>,
    /// Values row by row, -1 to 1.
    pub values: Vec<Vec<f64>>,
}

/// Something drawn. Colours are places in the palette.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A line through samples; it breaks where a value is not finite.
    Line {
        /// What it is, for the legend.
        label: &'static str,
        /// Colour.
        colour: usize,
        /// Dashed.
        dashed: bool,
        /// Samples.
        series: Series,
        /// Factor from the samples to the axis.
        scale: f64,
    },
    /// A band about zero or another line: `centre ± half_width`.
    Band {
        /// What it is, for the legend.
        label: &'static str,
        /// Colour.
        colour: usize,
        /// Centre.
        centre: Series,
        /// Half width at each sample.
        half_width: Arc<[f64]>,
        /// Factor from the samples to the axis.
        scale: f64,
    },
    /// Points with error bars.
    Points {
        /// What they are, for the legend.
        label: &'static str,
        /// Colour.
        colour: usize,
        /// `x`, `y` and half the length of the bar of each.
        points: Vec<[f64; 3]>,
    },
    /// A horizontal line with a band.
    Level {
        /// What it is, for the legend.
        label: &'static str,
        /// Colour.
        colour: usize,
        /// Value.
        value: f64,
        /// Ends of the band.
        band: [f64; 2],
    },
    /// A stretch of the horizontal axis.
    Span {
        /// What it is, for the legend.
        label: &'static str,
        /// Colour.
        colour: usize,
        /// First and last value.
        ends: [f64; 2],
    },
}

/// A line.
pub fn line(label: &'static str, colour: usize, series: &Series, scale: f64) -> Mark {
    Mark::Line { label, colour, dashed: false, series: series.clone(), scale }
}

/// A dashed line.
pub fn dashed(label: &'static str, colour: usize, series: &Series, scale: f64) -> Mark {
    Mark::Line { label, colour, dashed: true, series: series.clone(), scale }
}

impl Axis {
    /// An axis of `label` in `unit`.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into() }
    }

    /// Time in seconds.
    pub fn time() -> Self {
        Self::new("time", "s")
    }

    /// Label with unit.
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} [{}]", self.label, self.unit) }
    }
}
