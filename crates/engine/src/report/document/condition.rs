//! Section on the derivatives over the flight condition.

use doublet_core::model::{Coefficient, Term};
use doublet_core::statistics::NORMAL_95;

use super::figure::points_with_bars;
use super::{Axis, Block, Contents, Figure, LineStyle, Panel, Parts, Plot, paragraph, points};
use crate::notation;
use crate::report::studies::ConditionRow;
use crate::report::table::{Table, TableOf};
use crate::study::ConditionRegression;

/// Variables of the regression that is shown.
const VARIABLES: &str = "V h";
const AXES: [(&str, &str); 2] = [("V", "m/s"), ("h", "m")];
/// What the panels show.
const LINES: &str = "manoeuvres with 95 % interval, and the regression at the mean of the other variable.";
/// Figures there is room for.
const PANELS: usize = 9;
/// Slope over its standard error from which on a derivative depends on the condition: some twenty derivatives over two variables are tested, and
/// at 2 one or two of them would seem to.
const SIGNIFICANT: f64 = 3.0;
/// Span of the mean airspeeds, over their mean, below which slopes over airspeed are not shown.
const LEAST_AIRSPEED_SPAN: f64 = 0.05;
/// Span of the mean altitudes, m, below which slopes over altitude are not shown: the air density changes by 1 % in it.
const LEAST_ALTITUDE_SPAN_M: f64 = 100.0;

/// The derivatives that depend on airspeed or altitude, as far as these were varied; in the appendix slopes and figures of every derivative.
pub fn condition(contents: &Contents<'_>) -> Parts {
    if contents.results.windows.len() < 2 {
        return Parts::default();
    }
    let table = slopes(&contents.results.studies.conditions);
    let study = contents.snapshot.studies.manoeuvres.ready();
    let all = study.iter().flat_map(|study| &study.conditions);
    let all: Vec<&ConditionRegression> = all.filter(|found| found.variables.join(" ") == VARIABLES).collect();
    let spans: Vec<[f64; 2]> = (0..AXES.len()).filter_map(|index| flown(&all, index)).collect();
    let [airspeed, altitude] = spans[..] else { return Parts::default() };
    let is_varied = [
        airspeed[1] - airspeed[0] >= LEAST_AIRSPEED_SPAN * 0.5 * (airspeed[0] + airspeed[1]),
        altitude[1] - altitude[0] >= LEAST_ALTITUDE_SPAN_M,
    ];
    let [[slowest, fastest], [lowest, highest]] = [airspeed, altitude];
    let mut body = vec![Block::Paragraph(format!(
        "The manoeuvres were flown at {slowest:.1} to {fastest:.1} m/s true airspeed and {lowest:.0} to {highest:.0} m altitude."
    ))];
    if is_varied == [false, false] {
        body.push(paragraph(
            "These ranges are too narrow to show how the derivatives depend on airspeed and altitude.",
        ));
        return Parts { body, appendix: Vec::new() };
    }
    let depends = |found: &ConditionRegression| {
        let indices = (0..AXES.len()).filter(|index| is_varied[*index] && depends_on(found, *index));
        indices.map(|index| panel(found, index)).collect::<Vec<_>>()
    };
    let panels: Vec<Panel> = all.iter().flat_map(|found| depends(found)).take(PANELS).collect();
    if panels.is_empty() {
        body.push(paragraph("No derivative depends significantly on them."));
    } else {
        body.push(Block::Figure(Figure::new(
            "condition",
            format!("Derivatives that depend on airspeed or altitude: {LINES}"),
            (3, 26.0),
            panels,
        )));
    }
    let mut appendix = vec![
        paragraph(
            "Weighted regression of the single-manoeuvre estimates on true airspeed V and altitude h of their conditions. Scatter above 1 means that the manoeuvres differ by more than their errors and the slopes explain.",
        ),
        Block::Table(table),
    ];
    appendix.extend(each(contents, &all, is_varied));
    Parts { body, appendix }
}

/// Smallest and largest mean of a variable of the condition over the manoeuvres; none where no derivative has several.
fn flown(all: &[&ConditionRegression], index: usize) -> Option<[f64; 2]> {
    let at = all.iter().flat_map(|found| &found.points).filter_map(|(_, point)| point.condition.get(index).copied());
    at.fold(None, |ends: Option<[f64; 2]>, at| Some(ends.map_or([at; 2], |[low, high]| [low.min(at), high.max(at)])))
}

/// A figure per coefficient with each of its derivatives over the variables that were varied.
fn each(contents: &Contents<'_>, all: &[&ConditionRegression], is_varied: [bool; 2]) -> Vec<Block> {
    contents.session.structure.models.iter().filter_map(|model| draw_coefficient(model, all, is_varied)).collect()
}

fn draw_coefficient(
    (coefficient, terms): &(Coefficient, Vec<Term>),
    all: &[&ConditionRegression],
    is_varied: [bool; 2],
) -> Option<Block> {
    let names: Vec<String> = terms.iter().map(|term| term.derivative_name(*coefficient)).collect();
    let own = all.iter().filter(|found| names.contains(&found.derivative));
    let varied = || (0..AXES.len()).filter(|index| is_varied[*index]);
    let panels: Vec<Panel> = own.flat_map(|found| varied().map(|index| panel(found, index))).collect();
    let name = coefficient.name();
    (!panels.is_empty()).then(|| {
        Block::Figure(Figure::new(
            format!("condition {name}"),
            format!("Derivatives of {name} over the flight condition: {LINES}"),
            (4, 22.0),
            panels,
        ))
    })
}

/// One row per derivative.
fn slopes(rows: &[ConditionRow]) -> Table {
    let companion_row = |row: &ConditionRow, parameter: &str| {
        let same = |other: &&ConditionRow| other.derivative == row.derivative && other.variables == row.variables;
        rows.iter().filter(same).find(|other| other.parameter == parameter)
    };
    let value = |row: &ConditionRow, parameter: &str, error: bool| {
        let found = companion_row(row, parameter)?;
        Some(if error { found.standard_error } else { found.estimate })
    };
    let shown = rows.iter().filter(|row| row.variables == VARIABLES && row.parameter == "value" && row.error.is_none());
    TableOf::new("condition", "Derivatives at the mean condition and their slopes over airspeed and altitude.", shown)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .number("estimate", "Estimate", "", 4, |row| row.estimate)
        .number("standard_error", "Std error", "", 2, |row| row.standard_error)
        .maybe("slope_v", "per V", "s/m", 3, |row| value(row, "V", false))
        .maybe("slope_v_error", "Std error", "s/m", 2, |row| value(row, "V", true))
        .maybe("slope_h", "per h", "1/m", 3, |row| value(row, "h", false))
        .maybe("slope_h_error", "Std error", "1/m", 2, |row| value(row, "h", true))
        .number("scatter_ratio", "Scatter", "", 2, |row| row.scatter_ratio)
        .count("manoeuvres", "Manoeuvres", |row| row.manoeuvres)
        .done()
}

fn depends_on(found: &ConditionRegression, index: usize) -> bool {
    let Ok(result) = &found.result else { return false };
    let slope = result.fit.estimates.get(index + 1).zip(result.fit.standard_errors.get(index + 1));
    slope.is_some_and(|(slope, error)| slope.abs() > SIGNIFICANT * error * result.scatter_ratio.max(1.0))
}

/// A derivative over one variable of the condition, with the line of the regression.
fn panel(found: &ConditionRegression, index: usize) -> Panel {
    let manoeuvres = found.points.iter().filter_map(|(_, point)| {
        let at = *point.condition.get(index)?;
        Some([at, point.estimate, NORMAL_95 * point.standard_error])
    });
    let mut marks = vec![points_with_bars("one manoeuvre, 95 %", manoeuvres)];
    marks.extend(found.line(index).map(|ends| points("regression", 1, LineStyle::Solid, ends.to_vec())));
    let label = notation::derivative(&found.derivative);
    let (name, unit) = AXES.get(index).copied().unwrap_or_default();
    Panel::Plot(Plot { x: Axis::new(name, unit), y: Axis::new(label, ""), marks })
}
