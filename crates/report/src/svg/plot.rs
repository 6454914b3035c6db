//! One set of axes with its marks.

use doublet_core::series::{Band, Decimated, Pyramid, Series, decimate, decimate_band};
use doublet_core::statistics;
use doublet_engine::report::document::{Colour, LineStyle, Mark, Panel, Plot};

use super::axis::{TITLE_UNDER, Ticks, UNDER, ticks};
use super::strokes::{Shape, Strokes, draw_shape};
use super::{Area, CHARACTER, Svg, TEXT, ink};

/// Room above and below the data, as a part of their extent.
const ROOM: f64 = 0.06;
/// Points of height a tick label needs.
const TICK_HEIGHT: f64 = 11.0;
/// Points of width a tick label needs.
const TICK_WIDTH: f64 = 24.0;
/// Width of a column of which only the extremes are drawn, points.
const COLUMN: f64 = 1.0;

/// Extent of both axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Ends of the horizontal axis.
    pub x: [f64; 2],
    /// Ends of the vertical axis.
    pub y: [f64; 2],
}

/// Smallest and largest of some values.
#[derive(Clone, Copy)]
struct Extent([f64; 2]);

impl Extent {
    const NONE: Self = Self([f64::INFINITY, f64::NEG_INFINITY]);

    fn take(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values.into_iter().filter(|value| value.is_finite()) {
            self.0 = [self.0[0].min(value), self.0[1].max(value)];
        }
    }

    /// The extent with room on both sides; something sensible where there is none.
    fn with_room(self, room: f64) -> [f64; 2] {
        let [low, high] = self.0;
        if low > high {
            return [0.0, 1.0];
        }
        let room = match (high > low, high == 0.0) {
            (true, _) => room * (high - low),
            (false, true) => 1.0,
            (false, false) => 0.1 * high.abs(),
        };
        [low - room, high + room]
    }
}

/// Extent of a panel. Bands and error bars far beyond what they belong to are cut rather than let them flatten it.
pub fn range(panel: &Panel) -> Range {
    let Panel::Plot(plot) = panel else { return Range { x: [0.0, 1.0], y: [0.0, 1.0] } };
    let (mut x, mut y) = (Extent::NONE, Extent::NONE);
    let settled_s = plot.marks.iter().map(settled_s).fold(f64::NEG_INFINITY, f64::max);
    for mark in &plot.marks {
        match mark {
            Mark::Line { series, scale, .. } => {
                x.take(ends(&series.time_s));
                let first = series.time_s.partition_point(|&time| time < settled_s);
                y.take(series.values[first..].iter().map(|value| value * scale));
            }
            Mark::Band { centre, half_width, scale, .. } => {
                let usual = 1.2 * median(half_width.iter().copied());
                y.take(centre.values.iter().flat_map(|value| [scale * (value - usual), scale * (value + usual)]));
            }
            Mark::Points { points, .. } => {
                let usual = 3.0 * median(points.iter().map(|point| point[2]));
                for &[at, value, bar] in points {
                    x.take([at - 0.5, at + 0.5]);
                    let bar = if bar.is_finite() { bar.min(usual) } else { 0.0 };
                    y.take([value - bar, value + bar]);
                }
            }
            Mark::Bars { width, bars, .. } => {
                x.take(bars.iter().flat_map(|[at, _]| [at - 0.5 * width, at + 0.5 * width]));
                y.take(bars.iter().map(|bar| bar[1]).chain([0.0]));
            }
            Mark::Level { value, band, .. } => y.take([*value, band[0], band[1]]),
            Mark::Span { .. } => {}
        }
    }
    if x.0[0] > x.0[1] {
        let spans =
            plot.marks.iter().filter_map(|mark| if let Mark::Span { ends, .. } = mark { Some(*ends) } else { None });
        spans.for_each(|span| x.take(span));
    }
    let stated = |range: Option<[f64; 2]>, found: [f64; 2]| range.filter(|[low, high]| low < high).unwrap_or(found);
    Range { x: stated(plot.x.range, x.with_room(0.0)), y: stated(plot.y.range, y.with_room(ROOM)) }
}

/// Time from which a band is no wider than a few times its usual width: what a filter shows before it has settled would flatten the
/// rest.
fn settled_s(mark: &Mark) -> f64 {
    /// Width, over the usual one, that counts as settled.
    const SETTLED: f64 = 3.0;
    let Mark::Band { centre, half_width, .. } = mark else { return f64::NEG_INFINITY };
    let usual = SETTLED * median(half_width.iter().copied());
    let widths = centre.time_s.iter().zip(half_width.iter());
    let wide = widths.take_while(|(_, width)| width.is_nan() || **width > usual);
    wide.last().map_or(f64::NEG_INFINITY, |(time, _)| *time + f64::EPSILON * time.abs())
}

fn ends(values: &[f64]) -> impl IntoIterator<Item = f64> {
    values.first().into_iter().chain(values.last()).copied()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    statistics::median(&mut values.filter(|value| value.is_finite()).collect::<Vec<_>>()).unwrap_or(0.0)
}

fn y_ticks(range: &Range, height: f64) -> Ticks {
    ticks(range.y, (height / TICK_HEIGHT) as usize)
}

/// Room the labels of the vertical axis need.
pub fn label_width(plot: &Plot, range: &Range, height: f64) -> f64 {
    let longest = y_labels(plot, &y_ticks(range, height)).iter().map(|(_, label)| label.chars().count()).max();
    longest.unwrap_or(0) as f64 * CHARACTER + 4.0
}

/// Labels of the vertical axis: its words where it has any, numbers otherwise.
fn y_labels(plot: &Plot, ticks: &Ticks) -> Vec<(f64, String)> {
    match plot.y.places.is_empty() {
        true => ticks.values.iter().map(|&value| (value, ticks.label(value))).collect(),
        false => plot.y.places.clone(),
    }
}

/// From values to the page.
struct Frame<'a> {
    area: Area,
    range: &'a Range,
    strokes: &'a Strokes,
}

impl Frame<'_> {
    fn x(&self, value: f64) -> f64 {
        let [low, high] = self.range.x;
        self.area.x + (value - low) / (high - low) * self.area.width
    }

    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.range.y;
        // What lies far outside is cut, so it may as well lie a page away: SVG has no larger numbers to spare.
        let part = ((value - low) / (high - low)).clamp(-20.0, 20.0);
        self.area.y + (1.0 - part) * self.area.height
    }

    fn columns(&self) -> usize {
        (self.area.width / COLUMN) as usize
    }
}

/// Draws the panel; `is_last` when its horizontal axis is to be named.
pub fn draw(svg: &mut Svg<'_>, plot: &Plot, (range, strokes): (&Range, &Strokes), area: Area, is_last: bool) {
    let frame = Frame { area, range, strokes };
    let bottom = area.y + area.height;
    let vertical = y_ticks(range, area.height);
    let most = (area.width / TICK_WIDTH) as usize;
    // Points lie at whole numbers.
    let is_counted = plot.x.range.is_none() && plot.marks.iter().any(|mark| matches!(mark, Mark::Points { .. }));
    let most = if is_counted { most.min((range.x[1] - range.x[0]) as usize) } else { most };
    let horizontal = ticks(range.x, most);
    let grid = "stroke=\"#dfe5ec\" stroke-width=\"0.5\"";
    for (value, label) in y_labels(plot, &vertical) {
        let y = frame.y(value);
        svg.rule((area.x, y), (area.x + area.width, y), grid);
        svg.text(area.x - 3.0, y + 0.36 * TEXT, "end", &label);
    }
    let numbers = || horizontal.values.iter().map(|&value| (value, horizontal.label(value))).collect();
    let places = if plot.x.places.is_empty() { numbers() } else { plot.x.places.clone() };
    for (value, label) in places {
        let x = frame.x(value);
        svg.rule((x, area.y), (x, bottom), grid);
        // A label at the very end would run into the next panel.
        let half = 0.5 * label.chars().count() as f64 * CHARACTER;
        let x = x.min(area.x + area.width + 4.0 - half);
        svg.text(x, bottom + UNDER - 1.5, "middle", &label);
    }
    svg.clips += 1;
    let clip = format!("{}{}", svg.prefix, svg.clips);
    svg.put(format_args!(
        "<clipPath id=\"{clip}\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath><g clip-path=\"url(#{clip})\">",
        area.x, area.y, area.width, area.height
    ));
    for mark in &plot.marks {
        draw_mark(svg, mark, &frame);
    }
    svg.out.push_str("</g>");
    svg.put(format_args!(
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#8a94a0\" stroke-width=\"0.6\"/>",
        area.x, area.y, area.width, area.height
    ));
    svg.text(
        area.x,
        area.y - 3.5,
        "start",
        &format!("{}{}", plot.y.title(), if plot.y.places.is_empty() { vertical.factor() } else { String::new() }),
    );
    if is_last {
        let factor = if plot.x.places.is_empty() { horizontal.factor() } else { String::new() };
        let title = format!("{}{factor}", plot.x.title());
        svg.text(area.x + area.width / 2.0, bottom + UNDER + TITLE_UNDER - 2.0, "middle", &title);
    }
}

/// Draws a path of `lines`, each a list of points on the page.
fn draw_lines(svg: &mut Svg<'_>, path: &str, ink: &str, dash: &str) {
    svg.put(format_args!(
        "<path d=\"{path}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"0.8\" stroke-linejoin=\"round\"{dash}/>"
    ));
}

fn draw_dot(svg: &mut Svg<'_>, place: (f64, f64), ink: &str, shape: Shape) {
    svg.out.push_str(&draw_shape(place, ink, shape));
}

fn draw_series(
    svg: &mut Svg<'_>,
    series: &Series,
    scale: f64,
    (colour, style): (Colour, LineStyle),
    frame: &Frame<'_>,
) {
    let ink = &ink(colour);
    let (time_s, values, [from, to]) = (&series.time_s, &series.values, frame.range.x);
    let mut drawn = Decimated::<[f64; 2]>::default();
    decimate(&Pyramid::new(time_s, values), time_s, values, scale, (from, to), frame.columns(), &mut drawn);
    if style == LineStyle::Dots {
        let shape = frame.strokes.shape(colour);
        drawn.points.iter().for_each(|&[x, y]| draw_dot(svg, (frame.x(x), frame.y(y)), ink, shape));
        return;
    }
    let mut path = String::new();
    for line in drawn.lines() {
        add_line(&mut path, line.iter().map(|&[x, y]| (frame.x(x), frame.y(y))));
    }
    draw_lines(svg, &path, ink, &frame.strokes.dashes(style, colour));
}

fn draw_band(svg: &mut Svg<'_>, centre: &Series, half_width: &[f64], scale: f64, ink: &str, frame: &Frame<'_>) {
    let mut band = Band::default();
    let [from, to] = frame.range.x;
    // Half the columns: an edge of a band is smooth.
    decimate_band((&centre.time_s, &centre.values, half_width), scale, 1.0, (from, to), frame.columns() / 2, &mut band);
    let mut path = String::new();
    for segment in &band.segments {
        let edge = |at: usize, edge: &[f64]| (frame.x(band.time_s[at]), frame.y(edge[at]));
        let upper = segment.clone().map(|at| edge(at, &band.high));
        let lower = segment.clone().rev().map(|at| edge(at, &band.low));
        add_line(&mut path, upper.chain(lower));
        path.push('Z');
    }
    svg.put(format_args!("<path d=\"{path}\" fill=\"{ink}\" fill-opacity=\"0.25\"/>"));
}

fn draw_points(svg: &mut Svg<'_>, points: &[[f64; 3]], (colour, style): (Colour, LineStyle), frame: &Frame<'_>) {
    let ink = &ink(colour);
    for &[at, value, bar] in points.iter().filter(|point| point.iter().all(|value| value.is_finite())) {
        let x = frame.x(at);
        let style = format!("stroke=\"{ink}\" stroke-width=\"0.7\"");
        svg.rule((x, frame.y(value - bar)), (x, frame.y(value + bar)), &style);
    }
    let is_drawn = |[x, y, _]: &[f64; 3]| x.is_finite() && y.is_finite();
    if style == LineStyle::Dots {
        let shape = frame.strokes.shape(colour);
        points
            .iter()
            .filter(|point| is_drawn(point))
            .for_each(|&[x, y, _]| draw_dot(svg, (frame.x(x), frame.y(y)), ink, shape));
        return;
    }
    let mut path = String::new();
    for line in points.split(|point| !is_drawn(point)) {
        add_line(&mut path, line.iter().map(|&[x, y, _]| (frame.x(x), frame.y(y))));
    }
    draw_lines(svg, &path, ink, &frame.strokes.dashes(style, colour));
}

fn draw_mark(svg: &mut Svg<'_>, mark: &Mark, frame: &Frame<'_>) {
    match mark {
        Mark::Line { colour, style, series, scale, .. } => draw_series(svg, series, *scale, (*colour, *style), frame),
        Mark::Band { colour, centre, half_width, scale, .. } => {
            draw_band(svg, centre, half_width, *scale, &ink(*colour), frame);
        }
        Mark::Points { colour, style, points, .. } => draw_points(svg, points, (*colour, *style), frame),
        Mark::Bars { colour, width, bars, .. } => {
            for &[at, height] in bars {
                let (left, right) = (frame.x(at - 0.5 * width), frame.x(at + 0.5 * width));
                let (zero, end) = (frame.y(0.0), frame.y(height));
                svg.put(format_args!(
                    "<rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\" fill-opacity=\"0.6\"/>",
                    zero.min(end),
                    (right - left).max(0.5),
                    (zero - end).abs(),
                    ink(*colour)
                ));
            }
        }
        Mark::Level { colour, value, band, .. } => {
            let (ink, area) = (ink(*colour), frame.area);
            let (top, bottom) = (frame.y(band[1]), frame.y(band[0]));
            svg.put(format_args!(
                "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{ink}\" fill-opacity=\"0.25\"/>",
                area.x,
                area.width,
                (bottom - top).max(0.0)
            ));
            let y = frame.y(*value);
            svg.rule((area.x, y), (area.x + area.width, y), &format!("stroke=\"{ink}\" stroke-width=\"0.8\""));
        }
        Mark::Span { colour, ends, .. } => {
            let (from, to) = (frame.x(ends[0]), frame.x(ends[1]));
            svg.put(format_args!(
                "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\" fill-opacity=\"{}\"/>",
                frame.area.y,
                (to - from).max(0.5),
                frame.area.height,
                ink(*colour),
                frame.strokes.opacity(*colour)
            ));
        }
    }
}

/// One stroke of a path.
fn add_line(path: &mut String, points: impl Iterator<Item = (f64, f64)>) {
    use std::fmt::Write;
    for (index, (x, y)) in points.enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { "M" } else { "L" });
    }
}
