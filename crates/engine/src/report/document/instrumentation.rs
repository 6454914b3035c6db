//! Section on the sensors: what was recorded by what, how fast, over which range, with which error.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;

use super::{Block, Contents, Parts, paragraph, table_or};
use crate::notation::significant;
use crate::report::table::{Table, TableOf};
use crate::report::{ChannelRow, ExpressionRow, FlightRow, tables};
use crate::session::NoiseChannel;

/// Sensors with their errors and places; in the appendix what was done to the signals and the clocks.
pub fn channels(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let table = sensors(contents);
    if table.rows.is_empty() {
        return Parts::default();
    }
    let mut body = vec![
        paragraph(
            "Range is the smallest and largest value of the recording. Accuracy is the standard deviation that the instruments file states, noise that the filter used. Bias is the mean over the manoeuvres. Delay and its standard error are estimated from the manoeuvres.",
        ),
        Block::Table(table),
    ];
    let sources = sources(contents);
    body.extend((!sources.is_empty()).then_some(Block::List(sources)));
    body.extend(places(contents));
    // Computed channels rest on the instruments, so the report names their file.
    for flight in &contents.session.flights {
        if let Some(instruments) = &flight.instruments {
            body.push(Block::Paragraph(format!(
                "Raw sensors of flight {} are calibrated by {}.",
                flight.name, instruments.file
            )));
        }
    }
    let mut appendix = vec![
        table_or(tables::signals(results), "Every signal was used as recorded."),
        table_or(tables::clocks(results), "All recorders run on the flight's time line as recorded."),
    ];
    for flight in &results.flights {
        for made in &flight.expressions {
            let ExpressionRow { name, unit, expression, .. } = made;
            let role = made.role.map_or_else(String::new, |role| format!(" plays {role} and"));
            appendix.push(paragraph(&format!(
                "The channel '{name}' of flight {}{role} is {expression}, in {unit}.",
                flight.name
            )));
        }
    }
    Parts { body, appendix }
}

/// One row per channel that plays a role.
fn sensors(contents: &Contents<'_>) -> Table {
    let results = contents.results;
    let several = results.flights.len() > 1;
    let biases: BTreeMap<&str, f64> =
        results.wind_and_bias.iter().filter_map(|row| Some((row.quantity.strip_prefix("bias_")?, row.mean))).collect();
    let rows = results.flights.iter().flat_map(|flight| flight.channels.iter().map(move |row| (flight, row)));
    let has_accuracy = results.flights.iter().flat_map(|flight| &flight.channels).any(|row| row.accuracy.is_some());
    let delay = |row: &ChannelRow| {
        let plays = |name: &&str| Measurement::from_name(name).is_some_and(|found| found.role().name() == row.role);
        results.sensor_delays.iter().find(|delay| delay.measurements.iter().any(plays))
    };
    TableOf::new("sensors", "Instrumentation: recorded channels with their errors.", rows)
        .when(several, |table| table.text("flight", "Flight", |(flight, _)| &flight.name))
        .text("role", "Role", |(_, row)| row.role)
        .text("source", "Recorder", |(_, row)| &row.source)
        .text("channel", "Channel", |(_, row)| &row.name)
        .number("rate_hz", "Rate", "Hz", 3, |(_, row)| row.rate_hz)
        .text("unit", "Unit", |(_, row)| unit(row).0)
        .maybe("minimum", "Min", "", 3, |(_, row)| Some(unit(row).1 * row.minimum?))
        .maybe("maximum", "Max", "", 3, |(_, row)| Some(unit(row).1 * row.maximum?))
        .when(has_accuracy, |table| {
            table.maybe("accuracy", "Accuracy", "", 2, |(_, row)| Some(unit(row).1 * row.accuracy?))
        })
        .maybe("noise", "Noise", "", 2, |(flight, row)| Some(unit(row).1 * noise(flight, row.role)?))
        .maybe("bias", "Bias", "", 2, |(_, row)| Some(unit(row).1 * biases.get(row.role)?))
        .maybe("delay_s", "Delay", "s", 2, |(_, row)| Some(delay(row)?.delay_s))
        .maybe("delay_error_s", "Std error", "s", 2, |(_, row)| Some(delay(row)?.standard_error_s))
        .done()
}

/// Sources of the stated accuracies, one line each, with the roles they are of.
fn sources(contents: &Contents<'_>) -> Vec<String> {
    let mut found: Vec<(&str, Vec<&str>)> = Vec::new();
    for row in contents.results.flights.iter().flat_map(|flight| &flight.channels) {
        let Some(source) = row.accuracy_source.as_deref().map(|source| source.trim_end_matches('.')) else { continue };
        match found.iter_mut().find(|(known, _)| *known == source) {
            Some((_, roles)) if roles.contains(&row.role) => {}
            Some((_, roles)) => roles.push(row.role),
            None => found.push((source, vec![row.role])),
        }
    }
    found.iter().map(|(source, roles)| format!("Accuracy of {}: {source}.", roles.join(", "))).collect()
}

/// Unit of a row and its factor from SI: an engine speed is in rev/min.
fn unit(row: &ChannelRow) -> (&str, f64) {
    let is_engine_speed = ENGINE_SPEEDS.iter().any(|role| role.name() == row.role);
    if is_engine_speed { ("rev/min", 60.0 / TAU) } else { (&row.unit, 1.0) }
}

const ENGINE_SPEEDS: [Role; 2] = [Role::EngineSpeed1, Role::EngineSpeed2];

/// Standard deviation the filter used for a role.
fn noise(flight: &FlightRow, role: &str) -> Option<f64> {
    let plays = |entry: &str| NoiseChannel::from_name(entry).is_some_and(|channel| channel.role().name() == role);
    flight.noise.iter().find(|row| plays(row.entry)).map(|row| row.used)
}

/// Places of the sensors from the datum.
fn places(contents: &Contents<'_>) -> Option<Block> {
    let sensors = &contents.snapshot.aircraft.ready()?.aircraft.sensors;
    let stated = [
        ("Accelerometers", sensors.accelerometer_from_datum_m),
        ("Angle-of-attack vane", sensors.alpha_vane_from_datum_m),
        ("Sideslip vane", sensors.beta_vane_from_datum_m),
        ("Satellite antenna", sensors.antenna_from_datum_m),
    ];
    let words = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [x, y, z].map(|value| significant(value, 4));
        format!("x {x} m, y {y} m, z {z} m from the datum")
    };
    let known = stated.into_iter().filter_map(|(name, place)| Some((name.to_owned(), words(place?))));
    let known: Vec<(String, String)> = known.collect();
    (!known.is_empty()).then_some(Block::Facts(known))
}
