//! A stack of time plots as a figure.

use eframe::egui::{Id, Rect};

use super::decimate::{Band, Decimated};
use super::figure::{Figure, FigureCurve, FigureData, FigurePlot};
use super::plot_cache::{Drawn, PlotCache};
use super::time_plot::{SpanMark, TimePlot, Trace, TraceStyle, value_range};
use super::time_view::Stretch;

/// What the stack `id` shows.
pub(super) fn stack_figure(
    id: Id,
    (cache, plots, spans): (&PlotCache, &[TimePlot<'_>], &[SpanMark]),
    range: Stretch,
    frames: &[Rect],
) -> Figure {
    let one = |(row, (plot, frame)): (usize, (&TimePlot<'_>, &Rect))| {
        let drawn = |column: usize| cache.drawn.get(&(id, row, column));
        let present = (0..plot.traces.len()).filter_map(drawn);
        let curves =
            plot.traces.iter().enumerate().filter_map(|(column, trace)| Some(curve(plot, trace, drawn(column)?)));
        FigurePlot {
            label: plot.axis_label(),
            height: f64::from(frame.height()),
            range: value_range(plot, present),
            levels: plot.levels.clone(),
            spans: spans.iter().map(|span| (span.stretch.start_s, span.stretch.end_s, span.color)).collect(),
            curves: curves.collect(),
            places: Vec::new(),
        }
    };
    let labels: Vec<&str> = plots.iter().map(|plot| plot.label).filter(|label| label.is_ascii()).collect();
    Figure {
        name: labels.first().map_or_else(|| "plots".to_owned(), |label| label.replace(' ', "_")),
        width: frames.first().map_or(600.0, |frame| f64::from(frame.width())) + 96.0,
        label: "time [s]".to_owned(),
        range: (range.start_s, range.end_s),
        plots: plots.iter().zip(frames).enumerate().map(one).collect(),
        matrix: None,
    }
}

/// A trace as it is drawn, with all its samples.
fn curve(plot: &TimePlot<'_>, trace: &Trace<'_>, drawn: &Drawn) -> FigureCurve {
    let lines = lines(&drawn.line);
    let (lines, dots) = match trace.style {
        TraceStyle::Dots => (Vec::new(), lines.into_iter().flatten().collect()),
        TraceStyle::Line | TraceStyle::Dashed => (lines, Vec::new()),
    };
    let unit = if plot.unit.is_empty() { String::new() } else { format!(" [{}]", plot.unit) };
    FigureCurve {
        name: format!("{}{unit}", trace.name),
        color: trace.color,
        dashed: trace.style == TraceStyle::Dashed,
        lines,
        dots,
        bands: bands(&drawn.band),
        bars: Vec::new(),
        data: FigureData::Samples(trace.series.clone(), trace.scale),
    }
}

fn lines(line: &Decimated) -> Vec<Vec<[f64; 2]>> {
    let points = |segment: &std::ops::Range<usize>| line.points[segment.clone()].iter().map(|p| [p.x, p.y]).collect();
    line.segments.iter().map(points).collect()
}

fn bands(band: &Band) -> Vec<Vec<[f64; 3]>> {
    let edges = |segment: &std::ops::Range<usize>| {
        segment.clone().map(|at| [band.time_s[at], band.low[at], band.high[at]]).collect()
    };
    band.segments.iter().map(edges).collect()
}
