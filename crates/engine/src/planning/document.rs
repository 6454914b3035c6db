//! A design as a card: stick picture, excursions with their limits, errors to expect.

use doublet_core::series::Series;
use doublet_dynamics::design::{Designed, SURFACE_NAMES};

use super::rows::DesignRow;
use crate::date;
use crate::report::document::{Axis, Block, Document, Figure, Panel, Plot, Section, line};
use crate::report::{Cell, Column, Table, significant};
use crate::session::Session;

/// Lays the card of a design out.
pub fn design_document(session: &Session, row: &DesignRow, designed: &Designed) -> Document {
    let section = |name: &str, title: &str, blocks: Vec<Block>| Section {
        name: name.to_owned(),
        title: title.to_owned(),
        is_numbered: false,
        on_new_page: false,
        blocks,
    };
    Document {
        title: format!("Test card: {} on {}", row.kind, row.surfaces.join(", ")),
        subtitle: session.title.clone(),
        app: format!("doublet {}", env!("CARGO_PKG_VERSION")),
        date: date::today(),
        notice: "Deflections are about the trim, signs as in the conventions of doublet: aileron right down, elevator down, rudder left."
            .to_owned(),
        cover: vec![facts(row)],
        signatures: Vec::new(),
        sections: vec![
            section("input", "Input", input(row, designed)),
            section("excursions", "Excursions to expect", vec![Block::Table(excursions(row))]),
            section("errors", "Errors to expect", vec![Block::Table(predicted(row))]),
            section("notes", "Notes of the crew", vec![Block::Paragraph("\u{a0}\n".repeat(6))]),
        ],
    }
}

fn degrees(rad: f64) -> String {
    format!("{} deg", significant(rad.to_degrees(), 3))
}

fn facts(row: &DesignRow) -> Block {
    let trim = &row.trim;
    let fact = |name: &str, text: String| (name.to_owned(), text);
    Block::Facts(vec![
        fact("True airspeed", format!("{} m/s", significant(trim["airspeed_m_s"], 4))),
        fact("Altitude", format!("{} m", significant(trim["altitude_m"], 4))),
        fact("Mass", format!("{} kg", significant(trim["mass_kg"], 4))),
        fact("Configuration", "trimmed, level, power as set for the trim".to_owned()),
        fact("Windows", format!("{} of {} s in all", row.manoeuvres.len(), significant(row.time_s, 4))),
        fact("Knock it off", "at any limit below, or when the motion is not that of the picture".to_owned()),
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
        let panel = |&surface: &usize| {
            let nodes = [(0.0, [0.0; 3])].into_iter().chain(manoeuvre.input.nodes());
            let nodes: Vec<(f64, [f64; 3])> = nodes.chain([(manoeuvre.duration_s, [0.0; 3])]).collect();
            let time_s: Vec<f64> = nodes.iter().map(|node| node.0).collect();
            let values: Vec<f64> = nodes.iter().map(|node| node.1[surface]).collect();
            let series = Series { time_s: time_s.into(), values: values.into() };
            Panel::Plot(Plot {
                x: Axis::time(),
                y: Axis::new(SURFACE_NAMES[surface], "deg"),
                marks: vec![line("", surface, &series, 180.0 / std::f64::consts::PI)],
            })
        };
        blocks.push(Block::Figure(Figure {
            name: format!("input-{}", index + 1),
            caption: format!("Window {}: {}.", index + 1, manoeuvre.name),
            columns: 1,
            panel_height_mm: 24.0,
            panels: manoeuvre.surfaces.iter().map(panel).collect(),
        }));
    }
    let order = row.manoeuvres.iter().map(|own| {
        let peaks: Vec<String> =
            own.peak_rad.iter().map(|(name, peak)| format!("{name} to {}", degrees(*peak))).collect();
        format!("{}: {}, {}, {} s", own.number, own.name, peaks.join(", "), significant(own.duration_s, 3))
    });
    blocks.push(Block::List(order.collect()));
    blocks
}

fn excursions(row: &DesignRow) -> Table {
    Table {
        name: "excursions".to_owned(),
        caption: "Three standard deviations beyond the mean extremes over gusts, starts and draws of the derivatives."
            .to_owned(),
        columns: vec![
            Column::new("name", "quantity"),
            Column::new("unit", "unit"),
            Column::number("low", "least", "", 4),
            Column::number("high", "greatest", "", 4),
            Column::number("limit_low", "limit, least", "", 4),
            Column::number("limit_high", "limit, greatest", "", 4),
            Column::number("margin", "margin", "", 3),
        ],
        rows: row
            .excursions
            .iter()
            .map(|own| {
                vec![
                    Cell::text(own.name),
                    Cell::text(own.unit),
                    Cell::Number(own.low),
                    Cell::Number(own.high),
                    Cell::maybe(own.limit_low),
                    Cell::maybe(own.limit_high),
                    Cell::maybe(own.margin),
                ]
            })
            .collect(),
    }
}

fn predicted(row: &DesignRow) -> Table {
    Table {
        name: "predicted".to_owned(),
        caption: "Standard errors this input will give by itself; the error now beside them.".to_owned(),
        columns: vec![
            Column::new("name", "derivative"),
            Column::number("estimate", "estimate", "", 4),
            Column::number("corrected", "error to expect", "", 2),
            Column::number("relative_error_percent", "relative", "%", 2),
            Column::number("present", "error now", "", 2),
        ],
        rows: row
            .predicted
            .iter()
            .map(|own| {
                vec![
                    Cell::text(own.name.clone()),
                    Cell::Number(own.estimate),
                    Cell::maybe(own.corrected),
                    Cell::maybe(own.relative_error_percent),
                    Cell::Number(own.present),
                ]
            })
            .collect(),
    }
}
