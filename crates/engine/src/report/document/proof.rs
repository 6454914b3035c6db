//! Section on the proof of match.

use super::figure::line;
use super::{Axis, Block, Colour, Contents, Figure, Mark, Panel, Parts, Plot, table_or};
use crate::notation;
use crate::report::proof::shown_tables;
use crate::stage::{ReplaySeries, WindowReplay};

/// Validation manoeuvres simulated by the pooled model, with tolerances.
pub fn proof_of_match(contents: &Contents<'_>) -> Parts {
    let found = &contents.results.proof_of_match;
    if found.windows.is_empty() {
        return Parts::default();
    }
    let mut blocks = vec![Block::Paragraph(format!(
        "Validation manoeuvres simulated by the pooled model in six degrees of freedom, from the recorded controls, thrust, wind and loading, and judged by {}. A test passes if, for each requirement, the whole simulation is within one band.",
        found.tolerances
    ))];
    let unflown =
        found.windows.iter().filter_map(|window| Some(format!("{}: {}", window.window, window.error.as_ref()?)));
    let unflown: Vec<String> = unflown.collect();
    if !unflown.is_empty() {
        blocks.push(Block::List(unflown));
    }
    let [tests, bands, theil] = shown_tables(found);
    blocks.push(table_or(tests, "No test of these tolerances applies to a manoeuvre."));
    let mut appendix: Vec<Block> = (!bands.rows.is_empty()).then_some(Block::Table(bands)).into_iter().collect();
    appendix.push(Block::Table(theil));
    let replays = contents.snapshot.proof.ready().into_iter().flat_map(|proof| &proof.windows);
    let excluded = |window: &str| contents.session.window(window).map_or(&[][..], |window| &window.excluded);
    let mut figures = replays
        .filter_map(|(window, replay)| Some(figure(window, replay.as_ref().ok()?)?.with_excluded(excluded(window))))
        .map(Block::Figure);
    blocks.extend(figures.next());
    appendix.extend(figures);
    Parts { body: blocks, appendix }
}

/// Measured with its band, simulated on top: the signals that have a band, or all where none has.
fn figure(window: &str, replay: &WindowReplay) -> Option<Figure> {
    let any = replay.series.iter().any(|series| series.half_band.is_some());
    let panels: Vec<Panel> =
        replay.series.iter().filter(|series| series.half_band.is_some() || !any).map(panel).collect();
    (!panels.is_empty()).then_some(Figure::new(
        format!("match {window}"),
        format!("Manoeuvre {window}: measured with the widest tolerance band, and simulated."),
        (2, 22.0),
        panels,
    ))
}

fn panel(series: &ReplaySeries) -> Panel {
    replay_panel(series, notation::unit(series.signal.dimension()))
}

/// Measured with its band and simulated on top, in a unit with its factor from SI.
pub(crate) fn replay_panel(series: &ReplaySeries, (unit, scale): (&'static str, f64)) -> Panel {
    let mut marks = Vec::new();
    marks.extend(series.half_band.as_ref().map(|half| Mark::Band {
        label: "tolerance".into(),
        colour: Colour::by_index(1),
        centre: series.measured.clone(),
        half_width: half.iter().map(|half| 2.0 * half).collect(),
        scale,
    }));
    marks.push(line("measured", 1, &series.measured, scale));
    marks.push(line("simulated", 0, &series.simulated, scale));
    let label = series.signal.name().replace('_', " ");
    Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, unit), marks })
}
