//! A stack of time plots as a figure.

use doublet_engine::report::document::{Axis, Colour, Figure, LineStyle, Mark, Panel, Plot};
use eframe::egui::{Id, Rect};

use super::figure::printed;
use super::plot_cache::PlotCache;
use super::time_plot::{SpanMark, TimePlot, Trace, TraceStyle, value_range};
use super::time_view::TimeRange;

/// Width of figures, mm.
pub(super) const WIDTH_MM: f64 = 170.0;

/// What the stack `id` shows.
pub(super) fn stack_figure(
    id: Id,
    (cache, plots, spans): (&PlotCache, &[TimePlot<'_>], &[SpanMark]),
    range: TimeRange,
    frames: &[Rect],
) -> Figure {
    let x = Axis { range: Some([range.start_s, range.end_s]), ..Axis::time() };
    let one = |(row, plot): (usize, &TimePlot<'_>)| {
        let shown = |column: &usize| !cache.is_hidden(id, plot.traces[*column].name);
        let columns = (0..plot.traces.len()).filter(shown);
        let drawn = columns.clone().filter_map(|column| cache.drawn.get(&(id, row, column)));
        let chosen = cache.chosen_values(id, row, plot);
        let (low, high) = chosen.unwrap_or_else(|| value_range(plot, drawn));
        let y = Axis { range: Some([low, high]), ..Axis::new(plot.axis_label(), "") };
        let around = spans.iter().map(span_mark).chain(plot.levels.iter().map(level_mark));
        let marks = around.chain(columns.flat_map(|column| marks(plot, &plot.traces[column]))).collect();
        Panel::Plot(Plot { x: x.clone(), y, marks })
    };
    let shape = |frame: &Rect| f64::from(frame.height() / frame.width().max(1.0));
    Figure::new(
        "all",
        "time histories",
        (1, WIDTH_MM * frames.iter().map(shape).sum::<f64>() / frames.len().max(1) as f64),
        plots.iter().take(frames.len()).enumerate().map(one).collect(),
    )
}

/// A span on paper.
fn span_mark(span: &SpanMark) -> Mark {
    let TimeRange { start_s, end_s } = span.part;
    Mark::Span { label: "".into(), colour: printed(span.color), ends: [start_s, end_s] }
}

/// A level on paper.
fn level_mark(&value: &f64) -> Mark {
    Mark::Level { label: "".into(), colour: Colour([0x80, 0x88, 0x90]), value, band: [value; 2] }
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

/// A trace with its band.
fn marks(plot: &TimePlot<'_>, trace: &Trace<'_>) -> impl Iterator<Item = Mark> {
    let unit = if plot.unit.is_empty() { String::new() } else { format!(" [{}]", plot.unit) };
    let (series, scale, colour) = (trace.series, trace.scale, printed(trace.color));
    let band = trace.sigma.map(|sigma| Mark::Band {
        label: "".into(),
        colour,
        centre: series.clone(),
        half_width: sigma.iter().map(|sigma| 2.0 * sigma).collect(),
        scale,
    });
    let style = match trace.style {
        TraceStyle::Dots | TraceStyle::Crosses => LineStyle::Dots,
        TraceStyle::Line => LineStyle::Solid,
        TraceStyle::Dashed => LineStyle::Dashed,
    };
    let line =
        Mark::Line { label: format!("{}{unit}", trace.name).into(), colour, style, series: series.clone(), scale };
    band.into_iter().chain([line])
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
