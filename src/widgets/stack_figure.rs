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
    Figure {
        name: "all".to_owned(),
        width: frames.first().map_or(600.0, |frame| f64::from(frame.width())) + 96.0,
        label: "time [s]".to_owned(),
        range: (range.start_s, range.end_s),
        plots: plots.iter().zip(frames).enumerate().map(one).collect(),
        matrix: None,
    }
}

/// A label as part of a file's name: Greek letters by their names, anything else that is no letter or digit as an underscore.
pub(super) fn file_word(label: &str) -> String {
    let mut word = String::new();
    for letter in label.chars() {
        match letter {
            'α' => word.push_str("alpha"),
            'β' => word.push_str("beta"),
            'δ' => word.push_str("delta_"),
            'θ' => word.push_str("theta"),
            'φ' => word.push_str("phi"),
            'ψ' => word.push_str("psi"),
            'ρ' => word.push_str("rho"),
            letter if letter.is_ascii_alphanumeric() => word.push(letter),
            '\u{307}' | '\u{308}' => word.push_str("_dot"),
            _ if word.ends_with('_') || word.is_empty() => {}
            _ => word.push('_'),
        }
    }
    word.trim_end_matches('_').to_owned()
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

#[cfg(test)]
mod tests {
    use super::file_word;

    #[test]
    fn labels_become_words_of_file_names() {
        for (label, word) in
            [("α", "alpha"), ("δe", "delta_e"), ("bias ax", "bias_ax"), ("V", "V"), ("α θ φ", "alpha_theta_phi")]
        {
            assert_eq!(file_word(label), word);
        }
    }
}
