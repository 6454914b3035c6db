//! How the curves of time plots are drawn.

use egui_plot::{FilledArea, Line, LineStyle, MarkerShape, PlotPoint, PlotPoints, Points};

use super::chart::LegendMark;
use super::plot_cache::Drawn;
use super::time_plot::Trace;

/// Samples further apart than this on screen are marked with dots.
pub(super) const DOT_SPACING: f32 = 7.0;
/// Radius of a dot; those of measurements under a fit are smaller and paler, so that the line of a fit is seen on them.
const DOT_RADIUS: f32 = 1.9;
const MEASURED_RADIUS: f32 = 1.3;
const MEASURED_PART: f32 = 0.6;
/// Width of a line, and of one over dots.
const LINE: [f32; 2] = [1.4, 2.0];
/// A reference that swings through more than this many times its range is drawn solid: dashes would fill the plot.
const MOST_SWINGS: f64 = 60.0;

/// How a trace is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceStyle {
    /// Unbroken line.
    Line,
    /// Dashed line, for references and truth.
    Dashed,
    /// One dot per sample, for measurements under a fit.
    Dots,
    /// One cross per sample, for what was left out.
    Crosses,
}

impl TraceStyle {
    /// Whether each sample is drawn by itself, without a line.
    pub(super) fn is_points(self) -> bool {
        matches!(self, Self::Dots | Self::Crosses)
    }

    pub(super) fn legend(self) -> LegendMark {
        match self {
            Self::Line => LegendMark::Line,
            Self::Dashed => LegendMark::Dashed,
            Self::Dots | Self::Crosses => LegendMark::Dots,
        }
    }
}

/// Draws band, lines and dots of one trace; a line over dots is wider.
pub(super) fn draw_trace<'a>(
    chart: &mut egui_plot::PlotUi<'a>,
    trace: &Trace<'_>,
    drawn: &'a Drawn,
    (points_per_s, is_over_dots): (f64, bool),
) {
    let color = if trace.stale { trace.color.gamma_multiply(0.35) } else { trace.color };
    for segment in &drawn.band.segments {
        let (time, low, high) = (&drawn.band.time_s, &drawn.band.low, &drawn.band.high);
        let at = segment.clone();
        let area = FilledArea::new("", &time[at.clone()], &low[at.clone()], &high[at]);
        chart.add(area.fill_color(color.gamma_multiply(0.20)).allow_hover(false));
    }
    for segment in &drawn.line.segments {
        let points: &'a [PlotPoint] = &drawn.line.points[segment.clone()];
        let spacing = points.last().zip(points.first()).map_or(0.0, |(last, first)| (last.x - first.x) * points_per_s);
        let sparse = spacing >= f64::from(DOT_SPACING) * points.len() as f64;
        if trace.style == TraceStyle::Crosses {
            let crosses = Points::new("", PlotPoints::Borrowed(points)).color(color).radius(5.0);
            chart.points(crosses.shape(MarkerShape::Cross).allow_hover(false));
        } else if trace.style.is_points() || points.len() == 1 || sparse {
            let (color, radius) = match trace.style {
                TraceStyle::Dots => (color.gamma_multiply(MEASURED_PART), MEASURED_RADIUS),
                _ => (color, DOT_RADIUS),
            };
            let dots = Points::new("", PlotPoints::Borrowed(points)).color(color).radius(radius);
            chart.points(dots.allow_hover(false));
        }
        if !trace.style.is_points() && points.len() > 1 {
            let line = Line::new("", PlotPoints::Borrowed(points))
                .color(color)
                .width(LINE[usize::from(is_over_dots)])
                .allow_hover(false);
            let swings = drawn.line.extent.map_or(0.0, |(low, high)| drawn.line.travel / (high - low).max(1e-300));
            let dashed = trace.style == TraceStyle::Dashed && swings < MOST_SWINGS;
            chart.line(if dashed { line.style(LineStyle::dashed_dense()) } else { line.allow_band(false) });
        }
    }
}
