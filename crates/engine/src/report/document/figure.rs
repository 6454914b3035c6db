//! Figures as data, for reports and for what leaves the window alike.

use std::borrow::Cow;
use std::sync::Arc;

use doublet_core::series::{Band, Decimated, Pyramid, Series, TimeRange, decimate, decimate_band};
use serde::{Deserialize, Serialize};

use super::super::table::rounded;

/// Columns of samples of which a figure keeps only the extremes, on screen and thinned.
pub const DRAWN_COLUMNS: usize = 500;
/// Significant digits of a thinned figure: across, where an instant late in a flight has to be told from the next, and upright.
const DIGITS: [usize; 2] = [10, 6];

/// A figure: panels row by row under one legend.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Panel {
    /// Lines, bands and points over two axes.
    Plot(Plot),
    /// Numbers from -1 to 1 as coloured squares.
    Matrix(Matrix),
}

/// Marks over two axes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Plot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn, in this order.
    pub marks: Vec<Mark>,
}

/// What an axis shows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
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
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Matrix {
    pub title: String,
    /// Name of each row and column.
    pub names: Vec<String>,
    /// Values row by row.
    pub values: Vec<Vec<f64>>,
    /// Absolute value at which the colour is full.
    pub full_scale: f64,
}

/// A colour on white: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

    /// Of what is left out.
    pub const EXCLUDED: Self = Self([0x70, 0x70, 0x70]);

    /// The colour at a place of the palette, which begins again behind its end.
    pub fn by_index(index: usize) -> Self {
        Self::PALETTE[index % Self::PALETTE.len()]
    }
}

/// How samples and points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LineStyle {
    /// Joined.
    Solid,
    /// Joined by a dashed line.
    Dashed,
    /// Each by itself.
    Dots,
}

/// Something drawn. A label that is empty is not in the legend.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Mark {
    /// Samples; a line through them breaks at gaps and where a value is not finite.
    Line {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        colour: Colour,
        /// Joined or not.
        style: LineStyle,
        /// Samples.
        #[serde(with = "samples")]
        series: Series,
        /// Factor from the samples to the axis.
        scale: f64,
    },
    /// A band about zero or another line: `centre ± half_width`.
    Band {
        /// What it is, for the legend.
        label: Cow<'static, str>,
        colour: Colour,
        #[serde(with = "samples")]
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
        colour: Colour,
        value: f64,
        /// Ends of the band.
        band: [f64; 2],
    },
    /// A part of the horizontal axis.
    Span {
        /// What it is, for the legend.
        label: Cow<'static, str>,
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
    Mark::Points { label: label.into(), colour: Colour::by_index(colour), style, points }
}

/// Points in the first colour, each with half the length of its bar.
pub fn points_with_bars(label: &'static str, points: impl IntoIterator<Item = [f64; 3]>) -> Mark {
    let (label, colour, points) = (label.into(), Colour::by_index(0), points.into_iter().collect());
    Mark::Points { label, colour, style: LineStyle::Dots, points }
}

/// A line in a colour of the palette.
pub fn line(label: &'static str, colour: usize, series: &Series, scale: f64) -> Mark {
    let (label, colour) = (label.into(), Colour::by_index(colour));
    Mark::Line { label, colour, style: LineStyle::Solid, series: series.clone(), scale }
}

impl Figure {
    /// A figure of so many panels beside each other, each so high (mm).
    pub fn new(
        name: impl Into<String>,
        caption: impl Into<String>,
        (columns, panel_height_mm): (usize, f64),
        panels: Vec<Panel>,
    ) -> Self {
        Self { name: name.into(), caption: caption.into(), columns, panel_height_mm, panels }
    }

    /// The figure with excluded parts of time behind what its plots show.
    #[must_use]
    pub fn with_excluded(mut self, parts: &[TimeRange]) -> Self {
        let excluded = |TimeRange { start_s, end_s }: &TimeRange| Mark::Span {
            label: "excluded".into(),
            colour: Colour::EXCLUDED,
            ends: [*start_s, *end_s],
        };
        for panel in &mut self.panels {
            if let Panel::Plot(plot) = panel {
                plot.marks.splice(..0, parts.iter().map(excluded));
            }
        }
        self
    }

    /// The figure with no more samples than can be told apart on paper, each to as many digits.
    #[must_use]
    pub fn thinned(&self) -> Self {
        Self { panels: self.panels.iter().map(Self::thin).collect(), ..self.clone() }
    }

    fn thin(panel: &Panel) -> Panel {
        match panel {
            Panel::Plot(plot) => {
                let [start, end] = plot.x.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
                let marks = plot.marks.iter().map(|mark| mark.thinned((start, end))).collect();
                Panel::Plot(Plot { marks, ..plot.clone() })
            }
            Panel::Matrix(matrix) => Panel::Matrix(matrix.clone()),
        }
    }
}

impl Mark {
    /// What is seen of it over this part of the horizontal axis.
    fn thinned(&self, (start, end): (f64, f64)) -> Self {
        let within = |time_s: &[f64]| {
            let ends = time_s.first().zip(time_s.last());
            ends.map_or((start, end), |(first, last)| (start.max(*first), end.min(*last)))
        };
        let [across, up] = DIGITS;
        match self {
            Self::Line { label, colour, style, series, scale } => {
                let (time, values) = (&series.time_s, &series.values);
                let mut drawn = Decimated::<[f64; 2]>::default();
                decimate(&Pyramid::new(time, values), time, values, *scale, within(time), DRAWN_COLUMNS, &mut drawn);
                let mut points = Vec::with_capacity(drawn.points.len() + drawn.segments.len());
                for part in drawn.lines() {
                    // Nothing joins one unbroken part to the next.
                    points.extend((!points.is_empty()).then_some([f64::NAN; 3]));
                    points.extend(part.iter().map(|&[x, y]| [rounded(x, across), rounded(y, up), f64::NAN]));
                }
                Self::Points { label: label.clone(), colour: *colour, style: *style, points }
            }
            Self::Band { label, colour, centre, half_width, scale } => {
                let mut band = Band::default();
                let samples: (&[f64], &[f64], &[f64]) = (&centre.time_s, &centre.values, half_width);
                decimate_band(samples, *scale, 1.0, within(&centre.time_s), DRAWN_COLUMNS, &mut band);
                let edges = || band.low.iter().zip(&band.high);
                let centre = Series {
                    time_s: band.time_s.iter().map(|time| rounded(*time, across)).collect(),
                    values: edges().map(|(low, high)| rounded(0.5 * (low + high), up)).collect(),
                };
                let half_width = edges().map(|(low, high)| rounded(0.5 * (high - low), up)).collect();
                Self::Band { label: label.clone(), colour: *colour, centre, half_width, scale: 1.0 }
            }
            Self::Points { label, colour, style, points } => {
                let short = |&[x, y, bar]: &[f64; 3]| [rounded(x, across), rounded(y, up), rounded(bar, up)];
                let points = points.iter().map(short).collect();
                Self::Points { label: label.clone(), colour: *colour, style: *style, points }
            }
            other => other.clone(),
        }
    }
}

/// Samples in files: the times, then the values.
mod samples {
    use doublet_core::series::Series;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(series: &Series, serializer: S) -> Result<S::Ok, S::Error> {
        [&series.time_s, &series.values].serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Series, D::Error> {
        let [time_s, values] = <[std::sync::Arc<[f64]>; 2]>::deserialize(deserializer)?;
        if time_s.len() == values.len() {
            Ok(Series { time_s, values })
        } else {
            Err(Error::custom("samples without times"))
        }
    }
}

impl Axis {
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
