//! A design as a card: stick picture, excursions with their limits, errors to expect.

use doublet_core::series::Series;
use doublet_dynamics::design::{CONTROLS, Designed, PlannedManoeuvre, SURFACE_NAMES, THROTTLE};

use super::card::{M_PER_FT, height, speed};
use super::rows::{ComparedKind, DesignRow, ExcursionRow};
use super::safety::M_S_PER_KT;
use crate::notation::significant;
use crate::report::document::{
    Axis, Block, Document, Figure, LineStyle, Mark, Panel, Plot, Section, Style, UnitSystem, line, points,
};
use crate::report::{Cell, Column, Table, TableOf};
use crate::session::{Level, Session};
use crate::snapshot::{DerivativeRow, Enough, NextRow};
use crate::{date, notation};

/// Lays the card of a design out in a style.
pub fn design_document(session: &Session, row: &DesignRow, designed: &Designed, style: &Style) -> Document {
    let section = |name, title, blocks| Section::plain(name, title, false, blocks);
    let units = style.units;
    let mut document = Document {
        title: format!("Test card: {} on {}", row.kind, row.surfaces.join(", ")),
        subtitle: session.title.clone(),
        date: date::today(),
        notice: "Deflections are from trim; positive: right aileron down, elevator trailing edge down, rudder trailing edge left."
            .to_owned(),
        cover: notes(row, units).into_iter().chain([facts(row, units)]).collect(),
        sections: vec![
            section("input", "Input", input(row, designed)),
            section("excursions", "Expected excursions", vec![Block::Table(excursions(row, units).select(&EXCURSIONS))]),
            section("errors", "Expected standard errors", vec![Block::Table(predicted(row).select(&PREDICTED))]),
            section("notes", "Crew notes", vec![Block::Lines(6)]),
        ],
        ..Document::default()
    };
    style.apply(&mut document);
    document
}

/// What is wrong with the design: bad, in one line, what is expected beyond its limit.
fn notes(row: &DesignRow, units: UnitSystem) -> Vec<Block> {
    let warnings: Vec<String> = row.excursions.iter().filter_map(ExcursionRow::warning).collect();
    let beyond: Vec<String> = row.excursions.iter().filter_map(|own| beyond_limit(own, units)).collect();
    let banner = (!beyond.is_empty()).then(|| {
        let limits = if beyond.len() == 1 { "its limit" } else { "their limits" };
        Block::Outcome(Level::Bad, format!("do not fly unchanged: expected beyond {limits}: {}", beyond.join(", ")))
    });
    let others = row.notes.iter().filter(|note| !warnings.contains(note));
    banner.into_iter().chain(others.map(|note| Block::Outcome(Level::Caution, note.clone()))).collect()
}

/// A quantity that is expected beyond its limit, by how much and which limit.
fn beyond_limit(own: &ExcursionRow, units: UnitSystem) -> Option<String> {
    let beyond = -own.margin.filter(|_| own.is_beyond_limit())?;
    let by = match own.name {
        "V" => speed(units, beyond, 2),
        "h" => height(units, beyond, 2),
        _ => {
            let (unit, factor) = notation::shown(own.unit).unwrap_or((own.unit, 1.0));
            format!("{} {unit}", significant(factor * beyond, 2)).trim_end().to_owned()
        }
    };
    let source = own.limit_source.as_deref().unwrap_or("limit");
    Some(format!("{} by {by} ({source})", own.title()))
}

fn degrees(rad: f64) -> String {
    format!("{} deg", significant(rad.to_degrees(), 3))
}

fn facts(row: &DesignRow, units: UnitSystem) -> Block {
    let trim = &row.trim;
    let fact = |name: &str, text: String| (name.to_owned(), text);
    Block::Facts(vec![
        fact("True airspeed", speed(units, trim["airspeed_m_s"], 4)),
        fact("Altitude", height(units, trim["altitude_m"], 4)),
        fact("Mass", format!("{} kg", significant(trim["mass_kg"], 4))),
        fact("Configuration", "trimmed, level, power as set for the trim".to_owned()),
        fact("Manoeuvres", format!("{} of {} s in all", row.manoeuvres.len(), significant(row.time_s, 4))),
        fact("Knock it off", "at any limit below, or if the motion differs from the figure".to_owned()),
    ])
}

/// Stick picture of each distinct window, and what the hand does.
fn input(row: &DesignRow, designed: &Designed) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut shown: Vec<usize> = Vec::new();
    for (index, manoeuvre) in designed.manoeuvres.iter().enumerate() {
        if shown.iter().any(|&other| designed.manoeuvres[other].input == manoeuvre.input) {
            continue;
        }
        shown.push(index);
        blocks.push(Block::Figure(Figure::new(
            format!("input-{}", index + 1),
            format!("Manoeuvre {}: {}.", index + 1, manoeuvre.name),
            (1, 24.0),
            manoeuvre.surfaces.iter().map(|&surface| draw_stick(manoeuvre, surface)).collect(),
        )));
    }
    let order = row.manoeuvres.iter().map(|own| {
        let thrust = own.peak_thrust_n.map(|peak| format!("thrust by {} N", significant(peak, 3)));
        let surfaces = own.peak_rad.iter().map(|(name, peak)| format!("{name} to {}", degrees(*peak)));
        let peaks: Vec<String> = surfaces.chain(thrust).collect();
        format!("{}: {}, {}, {} s", own.number, own.name, peaks.join(", "), significant(own.duration_s, 3))
    });
    blocks.push(Block::List(order.collect()));
    blocks
}

fn draw_stick(manoeuvre: &PlannedManoeuvre, surface: usize) -> Panel {
    let nodes = [(0.0, [0.0; CONTROLS])].into_iter().chain(manoeuvre.input.nodes());
    let nodes: Vec<(f64, [f64; CONTROLS])> = nodes.chain([(manoeuvre.duration_s, [0.0; CONTROLS])]).collect();
    let time_s: Vec<f64> = nodes.iter().map(|node| node.0).collect();
    let values: Vec<f64> = nodes.iter().map(|node| node.1[surface]).collect();
    let series = Series { time_s: time_s.into(), values: values.into() };
    let (name, unit, factor) = match surface {
        THROTTLE => ("change of thrust", "N", 1.0),
        _ => (SURFACE_NAMES[surface], "deg", 180.0 / std::f64::consts::PI),
    };
    Panel::Plot(Plot { x: Axis::time(), y: Axis::new(name, unit), marks: vec![line("", surface, &series, factor)] })
}

/// Columns of the excursions that are on a card.
const EXCURSIONS: [&str; 7] = ["name", "unit", "low", "high", "limit_low", "limit_high", "margin"];
/// Columns of the predicted errors that are on a card.
const PREDICTED: [&str; 6] = ["name", "estimate", "corrected", "promised", "relative_error_percent", "present"];

/// Errors and excursions to expect of a design; kinds of input side by side where they were compared.
pub fn design_tables(row: &DesignRow) -> Vec<Table> {
    let compared = (!row.comparison.is_empty()).then(|| comparison_table(row));
    [predicted(row), excursions(row, UnitSystem::Si)].into_iter().chain(compared).collect()
}

/// Excursions in the units people read, angles in degrees.
fn excursions(row: &DesignRow, units: UnitSystem) -> Table {
    let caption = "Mean extremes ± 3 standard deviations, over random gusts, initial states and derivatives.";
    let shown = |own: &&ExcursionRow| match (units, own.name) {
        (UnitSystem::Aviation, "V") => ("kt", 1.0 / M_S_PER_KT),
        (UnitSystem::Aviation, "h") => ("ft", 1.0 / M_PER_FT),
        _ => notation::shown(own.unit).unwrap_or((own.unit, 1.0)),
    };
    let factor = |own: &&ExcursionRow| shown(own).1;
    TableOf::new("excursions", caption, &row.excursions)
        .text("name", "quantity", |own| own.title())
        .text("unit", "unit", |own| shown(own).0)
        .number("nominal_low", "nominal least", "", 4, |own| factor(own) * own.nominal_low)
        .number("nominal_high", "greatest", "", 4, |own| factor(own) * own.nominal_high)
        .number("low", "least", "", 4, |own| factor(own) * own.low)
        .number("high", "greatest", "", 4, |own| factor(own) * own.high)
        .maybe("limit_low", "least limit", "", 4, |own| Some(factor(own) * own.limit_low?))
        .maybe("limit_high", "greatest limit", "", 4, |own| Some(factor(own) * own.limit_high?))
        .optional("limit_source", "limit from", |own| own.limit_source.as_deref())
        .maybe("margin", "margin", "", 3, |own| Some(factor(own) * own.margin?))
        .optional("beyond", "within", |own| own.margin.map(|_| if own.is_beyond_limit() { "no" } else { "yes" }))
        .done()
}

fn predicted(row: &DesignRow) -> Table {
    let caption = "Predicted standard errors of this input alone, without and with path and sensor errors, beside the present errors.";
    TableOf::new("predicted", caption, &row.predicted)
        .symbol("name", "derivative", |own| &own.name)
        .number("estimate", "estimate", "", 4, |own| own.estimate)
        .maybe("standard_error", "std error", "", 2, |own| own.standard_error)
        .maybe("corrected", "error from noise", "", 2, |own| own.corrected)
        .maybe("promised", "error to expect", "", 2, |own| own.promised)
        .maybe("relative_error_percent", "relative", "%", 2, |own| own.relative_error_percent)
        .maybe("corrected_high", "95 % of draws below", "", 2, |own| own.corrected_high)
        .number("present", "error now", "", 2, |own| own.present)
        .done()
}

/// Kinds of input side by side: cost by each criterion, and the derivative with the greatest relative error.
pub(super) fn comparison_table(design: &DesignRow) -> Table {
    let cost = |name: &'static str| move |own: &&ComparedKind| own.costs.get(name).copied();
    let caption = format!(
        "Kinds of input within the same limits and time, the one with the smallest cost {} first. The card below is of the {}. Cost d: \
         logarithm of the volume of the errors; a: sum of the squares of the relative errors.",
        design.criterion, design.kind
    );
    let mut kinds: Vec<&ComparedKind> = design.comparison.iter().collect();
    let chosen = |own: &ComparedKind| own.costs.get(design.criterion).copied().unwrap_or(f64::INFINITY);
    kinds.sort_by(|a, b| chosen(a).total_cmp(&chosen(b)));
    TableOf::new("comparison", &caption, kinds)
        .text("kind", "kind", |own| own.kind)
        .maybe("d", "cost d", "", 4, cost("d"))
        .maybe("a", "cost a", "", 4, cost("a"))
        .maybe("worst_relative_error_percent", "worst relative", "%", 3, |own| own.worst_relative_error_percent)
        .column(Column::new("worst", "least certain"), |own| own.worst.as_deref().map_or(Cell::Empty, symbol))
        .optional("error", "", |own| own.error.as_deref())
        .done()
}

/// Whether what was flown is enough: what to fly next, errors over goals against the time flown, each derivative against its goal, and
/// every manoeuvre.
pub fn enough_blocks(found: &Enough) -> Vec<Block> {
    let (level, word) = if found.enough { (Level::Good, "Enough") } else { (Level::Caution, "Not enough") };
    let mut blocks = vec![Block::Outcome(level, format!("{word}: {} of {} goals are met", found.met, found.of))];
    blocks.extend(next_table(found).map(Block::Table));
    blocks.push(Block::Figure(errors_over_goals(found)));
    blocks.extend([Block::Table(goals_table(found)), Block::Table(windows_table(found))]);
    blocks
}

/// Each derivative against its goal, goals met after each manoeuvre, and what to fly next where goals are not met.
pub fn enough_tables(found: &Enough) -> Vec<Table> {
    [goals_table(found), windows_table(found)].into_iter().chain(next_table(found)).collect()
}

/// The manoeuvres to fly next, best first; none where the goals are met.
fn next_table(found: &Enough) -> Option<Table> {
    let caption = "Next manoeuvre, best first: errors of all manoeuvres flown plus this one.";
    let peaks = |own: &&NextRow| {
        let peaks: Vec<String> = own.signal_peak_rad.iter().map(|rad| significant(rad.to_degrees(), 3)).collect();
        Cell::text(peaks.join(", "))
    };
    let kind = |own: &&NextRow| Cell::text(format!("{} on {}", own.kind, own.surfaces.join(", ")));
    let table = TableOf::new("next", caption, &found.next)
        .column(Column::new("kind", "next manoeuvre"), kind)
        .number("duration_s", "time", "s", 3, |own| own.duration_s)
        .column(Column::new("peak", "peak [deg]"), peaks)
        .column(Column::new("met", "goals met"), |own| goals_met(own.met, found))
        .column(Column::new("worst", "worst"), |own| own.worst.as_deref().map_or(Cell::Empty, symbol))
        .maybe("worst_over_goal", "error over goal", "", 3, |own| own.worst_over_goal)
        .done();
    (!found.next.is_empty()).then_some(table)
}

/// Each derivative against its goal.
fn goals_table(found: &Enough) -> Table {
    let caption = "Standard error of all manoeuvres together against the goal of each derivative.";
    TableOf::new("goals", caption, &found.derivatives)
        .symbol("name", "derivative", |own| &own.name)
        .number("estimate", "estimate", "", 4, |own| own.estimate)
        .maybe("corrected", "corrected error", "", 2, |own| own.corrected)
        .number("goal", "goal", "", 2, |own| own.goal)
        .text("met_after", "met after", |own| own.met_after.as_deref().unwrap_or("not met"))
        .done()
}

/// Goals met after each manoeuvre.
fn windows_table(found: &Enough) -> Table {
    TableOf::new("windows", "Combined errors up to each manoeuvre.", &found.windows)
        .text("window", "after manoeuvre", |own| &own.window)
        .number("time_s", "time flown", "s", 4, |own| own.time_s)
        .column(Column::new("met", "goals met"), |own| goals_met(own.met, found))
        .column(Column::new("worst", "worst"), |own| own.worst.as_deref().map_or(Cell::Empty, symbol))
        .maybe("worst_over_goal", "error over goal", "", 3, |own| own.worst_over_goal)
        .done()
}

fn goals_met(met: usize, found: &Enough) -> Cell {
    Cell::text(format!("{met} of {}", found.of))
}

fn symbol(name: &str) -> Cell {
    Cell::Symbol(name.to_owned())
}

/// Errors over their goals against the time flown, of the derivatives that are furthest from their goals at the end.
fn errors_over_goals(found: &Enough) -> Figure {
    const LINES: usize = 6;
    let ratio = |error: Option<f64>, goal: f64| error.map_or(f64::NAN, |error| error / goal);
    let last = |row: &DerivativeRow| row.corrected.map_or(f64::INFINITY, |error| error / row.goal);
    let mut order: Vec<usize> = (0..found.derivatives.len()).collect();
    order.sort_by(|&a, &b| last(&found.derivatives[b]).total_cmp(&last(&found.derivatives[a])));
    let mut marks: Vec<Mark> = order
        .into_iter()
        .take(LINES)
        .enumerate()
        .map(|(colour, at)| {
            let row = &found.derivatives[at];
            let over = found.windows.iter().map(|window| {
                let error = window.corrected.get(at).copied().flatten();
                [window.time_s, ratio(error, row.goal).log10()]
            });
            points(notation::derivative(&row.name), colour, LineStyle::Solid, over)
        })
        .collect();
    let end_s = found.windows.last().map_or(0.0, |window| window.time_s);
    marks.push(points("goal", LINES, LineStyle::Dashed, [[0.0, 0.0], [end_s, 0.0]]));
    Figure::new(
        "errors-over-goals",
        "Corrected errors over their goals, as powers of ten, of the derivatives furthest from theirs.",
        (1, 45.0),
        vec![Panel::Plot(Plot { x: Axis::new("time flown", "s"), y: Axis::new("lg (error / goal)", ""), marks })],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excursion(margin: Option<f64>) -> ExcursionRow {
        ExcursionRow {
            name: "alpha",
            unit: "rad",
            trim: 0.1,
            nominal_low: 0.05,
            nominal_high: 0.15,
            low: 0.04,
            high: 0.17,
            limit_low: None,
            limit_high: margin.map(|margin| 0.17 + margin),
            limit_source: margin.map(|_| "as flown".to_owned()),
            margin,
        }
    }

    #[test]
    fn a_card_beyond_its_limit_says_so_above_everything_else() {
        let row = |excursion: ExcursionRow| DesignRow {
            kind: "doublet",
            surfaces: vec!["elevator"],
            criterion: "a",
            notes: excursion.warning().into_iter().collect(),
            excursions: vec![excursion],
            ..DesignRow::default()
        };
        let beyond = row(excursion(Some(-0.02)));
        let found = notes(&beyond, UnitSystem::Si);
        let [Block::Outcome(Level::Bad, text)] = found.as_slice() else { panic!("one banner: {found:?}") };
        assert_eq!(text, "do not fly unchanged: expected beyond its limit: α by 1.1 deg (as flown)");
        assert_eq!(excursions(&beyond, UnitSystem::Si).rows[0].last(), Some(&Cell::text("no")));
        for margin in [None, Some(0.0), Some(0.03)] {
            let within = row(excursion(margin));
            assert_eq!(notes(&within, UnitSystem::Si).len(), 0, "{margin:?}");
        }
    }

    #[test]
    fn several_limits_are_one_banner_in_the_units_asked_for() {
        let fast = ExcursionRow { name: "V", unit: "m/s", ..excursion(Some(-1.0)) };
        let row = DesignRow { excursions: vec![excursion(Some(-0.02)), fast], ..DesignRow::default() };
        for (units, speed) in [(UnitSystem::Si, "1.0 m/s (1.9 kt)"), (UnitSystem::Aviation, "1.9 kt")] {
            let found = notes(&row, units);
            let [Block::Outcome(Level::Bad, text)] = found.as_slice() else { panic!("one banner: {found:?}") };
            let expected = format!("α by 1.1 deg (as flown), V by {speed} (as flown)");
            assert_eq!(*text, format!("do not fly unchanged: expected beyond their limits: {expected}"));
        }
        let table = excursions(&row, UnitSystem::Aviation);
        assert_eq!(table.rows[1][1], Cell::text("kt"));
    }
}
