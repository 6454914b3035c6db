//! Levels of flying qualities over airspeed and altitude.

use std::collections::BTreeMap;

use super::{Axis, Block, Figure, LineStyle, Panel, Plot, points};
use crate::report::table::{Cell, Column, Table, TableOf};
use crate::report::{LevelMapRow, QualitiesRow};

/// Levels with their colours: green, ochre, orange, red.
const LEVELS: [(&str, usize); 4] = [("Level 1", 2), ("Level 2", 4), ("Level 3", 1), ("worse than Level 3", 5)];
/// Criteria there is room for beside the worst of all.
const PANELS: usize = 5;

/// A table of the conditions that were flown, and the map where there are several.
pub fn level_map(row: &QualitiesRow) -> Vec<Block> {
    if row.map.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![Block::Table(conditions(row))];
    if row.map.len() > 1 {
        blocks.push(Block::Figure(level_map_figure(row)));
    }
    blocks
}

fn conditions(row: &QualitiesRow) -> Table {
    let worst = |point: &LevelMapRow| {
        let below = point.criteria.iter().filter(|(_, level)| **level != "Level 1");
        below.map(|(criterion, level)| format!("{criterion} {level}")).collect::<Vec<_>>().join("; ")
    };
    let caption = "Levels of the model trimmed in level flight at each condition that was flown.";
    TableOf::new("level_map", caption, &row.map)
        .number("airspeed_m_s", "Airspeed", "m/s", 3, |point| point.airspeed_m_s)
        .number("altitude_m", "Altitude", "m", 4, |point| point.altitude_m)
        .number("mass_kg", "Mass", "kg", 5, |point| point.mass_kg)
        .count("manoeuvres", "Manoeuvres", |point| point.windows.len())
        .text("level", "Level", |point| point.level.unwrap_or("not judged"))
        .column(Column::new("worst", "Not Level 1"), |point| Cell::text(worst(point)))
        .done()
}

/// Levels over airspeed and altitude: the worst of all, and the criteria, those that change with the condition first.
fn level_map_figure(row: &QualitiesRow) -> Figure {
    let mut criteria: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for point in &row.map {
        for (criterion, level) in &point.criteria {
            criteria.entry(criterion).or_default().push(level);
        }
    }
    let changes = |levels: &[&str]| levels.iter().any(|level| Some(level) != levels.first());
    let mut names: Vec<(&str, bool)> = criteria.iter().map(|(name, levels)| (*name, changes(levels))).collect();
    names.sort_by_key(|(_, changes)| !changes);
    let mut panels = vec![panel("all criteria", row, |point| point.level)];
    for (name, _) in names.into_iter().take(PANELS) {
        panels.push(panel(name, row, |point| point.criteria.get(name).copied()));
    }
    Figure::new(
        "level_map",
        "Levels over airspeed and altitude at the conditions that were flown; the first panel is the worst of all criteria that count.",
        (3, 30.0),
        panels,
    )
}

fn panel<'a>(name: &str, row: &'a QualitiesRow, level: impl Fn(&'a LevelMapRow) -> Option<&'a str>) -> Panel {
    let marks = LEVELS.into_iter().filter_map(|(own, colour)| {
        let here: Vec<[f64; 2]> = row
            .map
            .iter()
            .filter(|point| level(point) == Some(own))
            .map(|point| [point.airspeed_m_s, point.altitude_m])
            .collect();
        (!here.is_empty()).then(|| points(own, colour, LineStyle::Dots, here))
    });
    let y = Axis::new(format!("{name}: altitude"), "m");
    Panel::Plot(Plot { x: Axis::new("V", "m/s"), y, marks: marks.collect() })
}
