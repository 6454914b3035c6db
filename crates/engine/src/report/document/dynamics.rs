//! Section on how the aircraft flies: trim, state matrices, modes with their intervals, levels of flying qualities.

use doublet_core::model::ThrustTreatment;
use doublet_core::statistics::NORMAL_95;
use doublet_dynamics::modes::ModeEstimate;

use super::level_map::level_map;
use super::mass::cg_range;
use super::{Axis, Block, Contents, Figure, LineStyle, Panel, Parts, Plot, paragraph, points};
use crate::notation::significant;
use crate::report::{
    AnticipationChart, DynamicsRow, anticipation_chart, criterion_table, level_table, matrix_tables, shown_mode_table,
};
use crate::study::DynamicsStudy;

/// Points of an ellipse.
const OUTLINE: usize = 73;
/// Height of a figure, mm, and of a panel of the eigenvalues.
const HEIGHT_MM: f64 = 50.0;
const ROOTS_HEIGHT_MM: f64 = 36.0;

/// Linear model, modes and levels.
pub fn dynamics(contents: &Contents<'_>) -> Parts {
    let slot = contents.snapshot.dynamics();
    let (Some(row), Some(study)) = (contents.results.dynamics.as_ref(), slot.ready()) else {
        let failed = slot.error().map(|error| format!("Linear model and modes were not computed: {error}."));
        return failed.map(Block::Paragraph).into_iter().collect::<Vec<_>>().into();
    };
    let mut blocks = vec![
        paragraph(
            "The identified model linearised in steady flight, by default at the median of the conditions of the identification manoeuvres (mean before each input). Intervals follow from the corrected standard errors, by linearisation and by sampling.",
        ),
        Block::Facts(trim(contents, row)),
    ];
    blocks.push(Block::Table(shown_mode_table(&row.modes)));
    blocks.push(Block::Figure(roots(study)));
    blocks.push(Block::Table(level_table(&row.qualities)));
    blocks.extend(anticipation(study).map(Block::Figure));
    let qualities = &row.qualities;
    blocks.push(Block::Paragraph(format!(
        "{} ({}), {}: {}, {}. State matrices, paragraphs, and what the other criteria need are in the appendix.",
        qualities.standard,
        qualities.note,
        qualities.airplane_from,
        qualities.level.unwrap_or("not judged"),
        qualities.extent(),
    )));
    if !row.notes.is_empty() {
        blocks.push(Block::List(row.notes.clone()));
    }
    let parts = [("longitudinal", "Longitudinal motion"), ("lateral", "Lateral motion")];
    let systems = parts.iter().filter_map(|(key, name)| Some(matrix_tables(key, name, row.systems.get(*key)?)));
    let mut appendix: Vec<Block> = systems.map(|[matrices, _]| Block::Table(matrices)).collect();
    appendix.push(Block::Table(criterion_table(&row.qualities)));
    appendix.extend(level_map(&row.qualities));
    Parts { body: blocks, appendix }
}

fn trim(contents: &Contents<'_>, row: &DynamicsRow) -> Vec<(String, String)> {
    let trim = &row.trim;
    let centre = match (cg_range(contents), trim.cg_from_datum_m) {
        (None, [0.0, 0.0, 0.0]) => "not stated".to_owned(),
        (_, [x, ..]) => format!("{x:.4} m"),
    };
    let thrust = match contents.session.preparation.thrust {
        ThrustTreatment::Included => "part of the coefficients".to_owned(),
        _ => format!("{:.0} N", trim.thrust_n),
    };
    let degrees = |value: f64| format!("{} deg", significant(value.to_degrees(), 3));
    let fact = |name: &str, value: String| (name.to_owned(), value);
    vec![
        fact("True airspeed", format!("{:.2} m/s", trim.airspeed_m_s)),
        fact("Altitude", format!("{:.0} m", trim.altitude_m)),
        fact("Flight path", degrees(trim.gamma_rad)),
        fact("Load factor", format!("{:.3}", trim.load_factor)),
        fact("Mass", format!("{:.1} kg", trim.mass_kg)),
        fact("Centre of gravity, x", centre),
        fact("Angle of attack", degrees(trim.alpha_rad)),
        fact("Elevator", degrees(trim.delta_e_rad)),
        fact("Thrust", thrust),
    ]
}

/// Eigenvalues in the upper half plane, the slow ones again at their own scale, then each oscillation close up with its 95 % ellipse, which is
/// too small to be seen among the others.
fn roots(study: &DynamicsStudy) -> Figure {
    let oscillations = study.modes.modes.iter().enumerate().filter(|(_, estimate)| estimate.mode.oscillates());
    let close_up = oscillations.map(|(index, estimate)| draw_close_up(index, estimate));
    Figure::new(
        "roots",
        "Eigenvalues with 95 % intervals of aperiodic modes: fast modes, slow modes, then each oscillation close up with its 95 % confidence ellipse.",
        (3, ROOTS_HEIGHT_MM),
        [plot_roots(study, false), plot_roots(study, true)].into_iter().chain(close_up).collect(),
    )
}

fn draw_close_up(index: usize, estimate: &ModeEstimate) -> Panel {
    let place = [estimate.mode.real_1_s, estimate.mode.imaginary_rad_s];
    let ellipse = estimate.ellipse(OUTLINE);
    let axis = |label: &str, unit: &str, at: usize| {
        let half = ellipse.iter().map(|point| (point[at] - place[at]).abs()).fold(0.0, f64::max);
        let ticks = [-half, 0.0, half].map(|shift| (place[at] + shift, significant(place[at] + shift, 4)));
        let range = (half > 0.0).then_some([place[at] - MARGIN * half, place[at] + MARGIN * half]);
        let places = if range.is_some() { ticks.into() } else { Vec::new() };
        Axis { range, places, ..Axis::new(label, unit) }
    };
    let (x, y) = (axis("real part", "1/s", 0), axis("imaginary part", "rad/s", 1));
    let marks = vec![
        points(estimate.mode.name, index, LineStyle::Dots, vec![place]),
        points("", index, LineStyle::Solid, ellipse.clone()),
    ];
    Panel::Plot(Plot { x, y, marks })
}

/// Half width of a close-up over that of its ellipse.
const MARGIN: f64 = 1.3;

fn plot_roots(study: &DynamicsStudy, slow: bool) -> Panel {
    let mut marks = Vec::new();
    for (index, estimate) in study.modes.modes.iter().enumerate() {
        let mode = &estimate.mode;
        if slow != (mode.frequency_rad_s() < SLOW_RAD_S) {
            continue;
        }
        let place = [mode.real_1_s, mode.imaginary_rad_s];
        marks.push(points(mode.name, index, LineStyle::Dots, vec![place]));
        if !mode.oscillates() {
            let half = NORMAL_95 * estimate.covariance[0].max(0.0).sqrt();
            let ends = vec![[place[0] - half, 0.0], [place[0] + half, 0.0]];
            marks.push(points("", index, LineStyle::Solid, ends));
        }
    }
    Panel::Plot(Plot { x: Axis::new("real part", "1/s"), y: Axis::new("imaginary part", "rad/s"), marks })
}

/// Frequency below which a mode is drawn among the slow ones.
const SLOW_RAD_S: f64 = 0.6;

/// Control anticipation over short-period damping with the boundaries of the levels, the estimate and its samples.
fn anticipation(study: &DynamicsStudy) -> Option<Figure> {
    let AnticipationChart { ranges, places, levels, estimate, samples } = anticipation_chart(study)?;
    let mut marks = vec![points("samples", 7, LineStyle::Dots, samples)];
    marks.extend(levels.into_iter().map(|(level, corners)| {
        let style = if level == 3 { LineStyle::Dashed } else { LineStyle::Solid };
        points(format!("Level {level}"), usize::from(level) + 1, style, corners)
    }));
    marks.push(points("estimate", 1, LineStyle::Dots, vec![estimate]));
    let [across, up] = places;
    let axis = |label: &str, unit: &str, range: [f64; 2], places: Vec<(f64, String)>| Axis {
        range: Some(range),
        places,
        ..Axis::new(label, unit)
    };
    Some(Figure::new(
        "control_anticipation",
        "Control anticipation parameter over short-period damping, logarithmic, with the boundaries of Levels 1 to 3.",
        (1, HEIGHT_MM),
        vec![Panel::Plot(Plot {
            x: axis("short-period damping", "", ranges[0], across),
            y: axis("CAP", "rad/s²/g", ranges[1], up),
            marks,
        })],
    ))
}
