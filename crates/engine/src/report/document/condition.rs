//! Section on the derivatives over the flight condition.

use doublet_core::statistics::NORMAL_95;

use super::{Axis, Block, Colour, Contents, Figure, LineStyle, Mark, Panel, Plot, paragraph, points};
use crate::notation;
use crate::report::studies::ConditionRow;
use crate::report::table::{Table, TableOf};
use crate::study::ConditionRegression;

/// Variables of the regression that is shown.
const VARIABLES: &str = "V h";
/// Figures there is room for.
const PANELS: usize = 9;
/// Slope over its standard error from which on a derivative depends on the condition.
const SIGNIFICANT: f64 = 2.0;

/// Slopes over airspeed and altitude, and the derivatives that depend on airspeed.
pub fn condition(contents: &Contents<'_>) -> Vec<Block> {
    let table = slopes(&contents.results.studies.conditions);
    if table.rows.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        paragraph(
            "Weighted regression of the single-manoeuvre estimates on mean true airspeed V and altitude h. Scatter above 1 means that the manoeuvres differ by more than their errors and the slopes explain.",
        ),
        Block::Table(table),
    ];
    let study = contents.snapshot.studies.manoeuvres.ready();
    let depends = study.iter().flat_map(|study| &study.conditions).filter(|found| depends_on_airspeed(found));
    let panels: Vec<Panel> = depends.take(PANELS).map(panel).collect();
    if panels.is_empty() {
        blocks.push(paragraph("No derivative depends significantly on airspeed."));
    } else {
        blocks.push(Block::Figure(Figure {
            name: "condition".to_owned(),
            caption: "Derivatives that depend on airspeed: manoeuvres with 95 % interval, and the regression at mean altitude."
                .to_owned(),
            columns: 3,
            panel_height_mm: 30.0,
            panels,
        }));
    }
    blocks
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

fn depends_on_airspeed(found: &ConditionRegression) -> bool {
    let Ok(result) = &found.result else { return false };
    let slope = result.fit.estimates.get(1).zip(result.fit.standard_errors.get(1));
    found.variables.join(" ") == VARIABLES
        && slope.is_some_and(|(slope, error)| slope.abs() > SIGNIFICANT * error * result.scatter_ratio.max(1.0))
}

fn panel(found: &ConditionRegression) -> Panel {
    let manoeuvres = found.points.iter().filter_map(|(_, point)| {
        let airspeed_m_s = *point.condition.first()?;
        Some([airspeed_m_s, point.estimate, NORMAL_95 * point.standard_error])
    });
    let mut marks = vec![Mark::Points {
        label: "one manoeuvre, 95 %".into(),
        colour: Colour::by_index(0),
        style: LineStyle::Dots,
        points: manoeuvres.collect(),
    }];
    marks.extend(found.line(0).map(|ends| points("regression", 1, LineStyle::Solid, ends.to_vec())));
    let label = notation::derivative(&found.derivative);
    Panel::Plot(Plot { x: Axis::new("V", "m/s"), y: Axis::new(label, ""), marks })
}
