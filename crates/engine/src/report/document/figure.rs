//! Figures as data, for reports and for what leaves the window alike.

use std::borrow::Cow;
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
    /// Its ends; what is drawn decides where none are given.
    pub range: Option<[f64; 2]>,
    /// Words at values, in place of numbers.
    pub places: Vec<(f64, String)>,
}

/// Correlations or the like.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Title.
    pub title: String,
    /// Name of each row and column.
    pub names: Vec<String>,
    /// Values row by row.
    pub values: Vec<Vec<f64>>,
    /// Absolute value at which the colour is full.
    pub full_scale: f64,
}

/// A colour on white: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// Colours that stay apart for the common colour-vision deficiencies.
    pub const PALETTE: [Self; 8] = [
        Self([0x00, 0x68, 0xb4]),
        Self([0xd5, 0x5e, 0x00]),
        Self([0x00, 0x87, 0x6c]),
        Self([0xb5, 0x47, 0x8f]),
        Self([0xa8, 0x7b, 0x00]),
        Self([0x8c, 0x2d, 0x19]),
        Self([0x5a, 0x4f, 0xcf]),
        Self([0x56, 0x60, 0x6b]),
    ];

    /// The colour at a place of the palette, which begins again behind its end.
    pub fn of(index: usize) -> Self {
        Self::PALETTE[index % Self::PALETTE.len()]
    }
}

/// How samples and points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineStyle {
    /// Joined.
    Solid,
    /// Joined by a dashed line.
    Dashed,
    /// Each by itself.
    Dots,
}

/// Something drawn. A label that is empty is not in the legend.
#[derive(Clone, Debug)]
pub enum Mark {
    /// Samples; a line through them breaks at gaps and where a value is not finite.
    Line {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// Joined or not.
        style: LineStyle,
        /// Samples.
        series: Series,
        /// Factor from the samples to the axis.
        scale: f64,
    },
    /// A band about zero or another line: `centre ± half_width`.
    Band {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// Centre.
        centre: Series,
        /// Half width at each sample.
        half_width: Arc<[f64]>,
        /// Factor from the samples to the axis.
        scale: f64,
    },
    /// Points in any order, with error bars; a line through them breaks where one is not finite.
    Points {
        /// What they are, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// Joined or not.
        style: LineStyle,
        /// `x`, `y` and half the length of the bar of each, not finite for none.
        points: Vec<[f64; 3]>,
    },
    /// Bars from zero.
    Bars {
        /// What they are, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// Width on the horizontal axis.
        width: f64,
        /// Middle and height of each.
        bars: Vec<[f64; 2]>,
    },
    /// A horizontal line with a band.
    Level {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// Value.
        value: f64,
        /// Ends of the band.
        band: [f64; 2],
    },
    /// A stretch of the horizontal axis.
    Span {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        /// Colour.
        colour: Colour,
        /// First and last value.
        ends: [f64; 2],
    },
}

/// Points without error bars in a colour of the palette, joined or not.
pub fn points(
    label: impl Into<Cow<'static, str>>,
    colour: usize,
    style: LineStyle,
    points: impl IntoIterator<Item = [f64; 2]>,
) -> Mark {
    let points = points.into_iter().map(|[x, y]| [x, y, f64::NAN]).collect();
    Mark::Points { label: label.into(), colour: Colour::of(colour), style, points }
}

/// A line in a colour of the palette.
pub fn line(label: &'static str, colour: usize, series: &Series, scale: f64) -> Mark {
    let (label, colour) = (label.into(), Colour::of(colour));
    Mark::Line { label, colour, style: LineStyle::Solid, series: series.clone(), scale }
}

impl Axis {
    /// An axis of `label` in `unit`.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), ..Self::default() }
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
