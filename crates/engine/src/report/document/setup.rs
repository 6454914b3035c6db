//! Sections on what was analysed and with what.

use doublet_core::quantity::{Dimension, Role};
use doublet_core::series::TimeRange;

use super::cover;
use super::figure::line;
use super::{Axis, Block, Colour, Contents, Figure, LineStyle, Mark, Panel, Plot, paragraph, table_or};
use crate::notation::{self, significant};
use crate::report::table::{Cell, Column, Table};
use crate::report::tables;
use crate::report::{ExpressionRow, applied_delays};
use crate::session::WindowRole;

/// The session and the units of the report.
pub fn overview(contents: &Contents<'_>) -> Vec<Block> {
    let (session, results) = (contents.session, contents.results);
    let facts = [
        ("Session", session.title.clone()),
        ("Flights", session.flights.iter().map(|flight| flight.name.as_str()).collect::<Vec<_>>().join(", ")),
        ("Gravity", format!("{} m/s², {}", significant(results.gravity_m_s2, 6), results.gravity_origin)),
    ];
    let delays = applied_delays(&results.sensor_delays).map(|words| ("Delays applied", words));
    let gusts = results.gusts.as_ref().map(|gusts| ("Gusts", gusts.words()));
    let mut blocks = vec![
        Block::Facts(
            facts.into_iter().chain(delays).chain(gusts).map(|(name, text)| (name.to_owned(), text)).collect(),
        ),
        paragraph(
            "Angles are in degrees and angular rates in degrees per second, in tables as in figures; all else, including the stored channels, is in SI units. Derivatives are per radian and per unit of the dimensionless rate. Body axes are x forward, y right, z down.",
        ),
    ];
    blocks.extend(cover::recordings(contents, false));
    blocks
}

/// Reference geometry, what is on board, mass properties.
pub fn aircraft(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    let mut blocks = Vec::new();
    let length = |value: f64| format!("{} m", significant(value, 5));
    let place = |[x, y, z]: [f64; 3]| [x, y, z].map(|value| significant(value, 4)).join(", ") + " m";
    if let Some(reference) = &results.reference {
        let moment = reference.moment_reference_from_datum_m.map_or_else(|| "the centre of gravity".to_owned(), place);
        let reference = &reference.geometry;
        blocks.push(Block::Heading("Reference geometry".to_owned()));
        blocks.push(Block::Facts(vec![
            ("Wing area".to_owned(), format!("{} m²", significant(reference.area_m2, 5))),
            ("Span".to_owned(), length(reference.span_m)),
            ("Mean aerodynamic chord".to_owned(), length(reference.chord_m)),
            ("Length of Cl and Cn".to_owned(), length(reference.lateral_moment_length_m)),
            ("Length of roll and yaw rate".to_owned(), length(reference.lateral_rate_length_m)),
            ("Length of pitch rate".to_owned(), length(reference.pitch_rate_length_m)),
            ("Moments are about".to_owned(), moment),
        ]));
    }
    let Some(mass) = &results.mass_properties else {
        blocks.push(paragraph("The mass properties are not known."));
        return blocks;
    };
    let fuel = results.flights.iter().find_map(|flight| Some(flight.mass_properties.as_ref()?.fuel.clone()));
    blocks.push(Block::Heading("Mass properties as flown".to_owned()));
    blocks.extend(fuel.map(|fuel| {
        paragraph(&format!("At the start and the end of each flight and in the middle of each manoeuvre: {fuel}."))
    }));
    blocks.push(Block::Table(tables::mass_properties(results)));
    if !mass.items.is_empty() {
        let rows = mass
            .items
            .iter()
            .map(|item| vec![Cell::text(item.kind), Cell::text(&item.place), Cell::Number(item.mass_kg)]);
        blocks.push(Block::Table(Table {
            name: "loading".to_owned(),
            caption: "On board besides the empty aircraft, at the start of the first flight.".to_owned(),
            columns: vec![
                Column::new("kind", "Kind"),
                Column::new("place", "Place"),
                Column::number("mass_kg", "Mass", "kg", 4),
            ],
            rows: rows.collect(),
        }));
    }
    blocks
}

/// Channels by role, clocks.
pub fn channels(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    let mut blocks = vec![
        table_or(tables::channels(results), "No channel has a role."),
        table_or(tables::signals(results), "Every signal was used as recorded."),
        table_or(tables::clocks(results), "All recorders run on the flight's time line as recorded."),
    ];
    // What the numbers of a computed channel are rests on the instruments, so the report names where that is said.
    for flight in &contents.session.flights {
        if let Some(instruments) = &flight.instruments {
            blocks.push(Block::Paragraph(format!(
                "Raw sensors of flight {} are calibrated by {}.",
                flight.name, instruments.file
            )));
        }
    }
    for flight in &results.flights {
        for made in &flight.expressions {
            let ExpressionRow { name, unit, expression, .. } = made;
            let role = made.role.map_or_else(String::new, |role| format!(" plays {role} and"));
            blocks.push(paragraph(&format!(
                "The channel '{name}' of flight {}{role} is {expression}, in {unit}.",
                flight.name
            )));
        }
    }
    blocks
}

/// The windows on each flight.
pub fn windows(contents: &Contents<'_>) -> Vec<Block> {
    let table = tables::windows(contents.results).select(&[
        "window",
        "flight",
        "start_s",
        "end_s",
        "role",
        "surface",
        "kind",
        "samples",
        "excluded_s",
        "note",
    ]);
    let mut blocks = vec![table_or(table, "No manoeuvre is in use.")];
    for flight in &contents.session.flights {
        let Some(loaded) = contents.snapshot.flights.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        let spans: Vec<Mark> = contents
            .session
            .windows
            .iter()
            .filter(|window| window.flight == flight.name)
            .filter_map(|window| {
                let (label, colour) = match window.role {
                    WindowRole::Identification => ("identification", 0),
                    WindowRole::Validation => ("validation", 1),
                    WindowRole::Ignored => return None,
                };
                Some(Mark::Span {
                    label: label.into(),
                    colour: Colour::of(colour),
                    ends: [window.window.start_s, window.window.end_s],
                })
            })
            .collect();
        let panel = |role: Role| {
            let (unit, scale) = notation::role_unit(role);
            let channel = loaded.recording.role(role)?;
            let mut marks = spans.clone();
            marks.push(line("recorded", 7, &channel.series, scale));
            Some(Panel::Plot(Plot { x: Axis::time(), y: Axis::new(notation::role(role), unit), marks }))
        };
        let panels: Vec<Panel> = [Role::Altitude, Role::TrueAirspeed].into_iter().filter_map(panel).collect();
        if !panels.is_empty() {
            let figure = Figure {
                name: format!("flight {}", flight.name),
                caption: format!("Flight {} with its manoeuvres.", flight.name),
                columns: 1,
                panel_height_mm: 32.0,
                panels,
            };
            let of_flight = contents.session.active_windows().filter(|window| window.flight == flight.name);
            let excluded: Vec<TimeRange> = of_flight.flat_map(|window| window.excluded.iter().copied()).collect();
            blocks.push(Block::Figure(figure.with_excluded(&excluded)));
        }
    }
    blocks
}

/// Modelled power of each engine against that of its monitor (thesis 6.3).
pub fn engines(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    if results.engines.is_empty() {
        return vec![paragraph(
            "No engine has recorded speed and manifold pressure, and a chart and propeller map in the aircraft file.",
        )];
    }
    let mut blocks = Vec::new();
    let (power_unit, power) = notation::unit(Dimension::Power);
    for flight in &contents.session.flights {
        let Some(found) = contents.snapshot.engines.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        let panels = found.engines.iter().map(|engine| {
            let mut marks = vec![line("modelled", 0, &engine.power_w, power)];
            marks.extend(engine.monitor_power_w.iter().map(|monitor| Mark::Line {
                label: "monitor".into(),
                colour: Colour::of(1),
                style: LineStyle::Dashed,
                series: monitor.clone(),
                scale: power,
            }));
            Panel::Plot(Plot { x: Axis::time(), y: Axis::new(format!("P {}", engine.name), power_unit), marks })
        });
        blocks.push(Block::Figure(Figure {
            name: format!("engines {}", flight.name),
            caption: format!("Power of the engines over flight {}.", flight.name),
            columns: 1,
            panel_height_mm: 32.0,
            panels: panels.collect(),
        }));
    }
    blocks.push(Block::Table(tables::engines(results)));
    blocks
}
