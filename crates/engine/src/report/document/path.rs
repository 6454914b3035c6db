//! Sections on the flight path reconstruction.

use std::sync::Arc;

use doublet_core::model::{Axes, Gyroscopic, ThrustTreatment};
use doublet_core::reconstruct::{AirState, InputHold, Measurement, Method, State};
use doublet_core::series::Series;

use super::figure::{line, points_with_bars};
use super::{Axis, Block, Colour, Contents, Figure, Mark, Panel, Parts, Plot, cover, numbers_of, table_or};
use crate::notation::{self, significant};
use crate::report::table::{Cell, Column, Table};
use crate::report::{error_table, tables};
use crate::session::PathSource;
use crate::stage::WindowPath;

/// Settings of the filter, and whether the innovations are as large as they say.
pub fn filter(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let fact = |(name, text): (&str, String)| (name.to_owned(), text);
    let mut facts: Vec<(String, String)> = method(contents).into_iter().map(fact).collect();
    let method = Block::Facts(facts.clone());
    facts.extend(corrections(contents).into_iter().map(fact));
    let consistency = tables::windows(results)
        .select(&["window", "mean_nis", "expected_nis", "nis_band_correlated_low", "nis_band_correlated_high"]);
    let body = vec![method, Block::Paragraph(format!("Innovations: {}.", cover::consistency(&results.windows)))];
    let appendix = vec![
        Block::Facts(facts),
        table_or(
            tables::noise(results).select(&["flight", "entry", "unit", "used", "proposed", "origin", "samples", "whiteness", "reason"]),
            "Noise was not estimated for any flight.",
        ),
        Block::Table(consistency.captioned(
            "Mean normalised innovation squared (NIS) of each manoeuvre, its expectation, and the 95 % band for the effective number of independent samples.",
        )),
    ];
    Parts { body, appendix }
}

/// How the path was reconstructed, and how the coefficients were formed from it.
fn method<'a>(contents: &Contents<'_>) -> Vec<(&'a str, String)> {
    let session = contents.session;
    let settings = &session.filter;
    let method = match settings.method {
        Method::Iekf { max_iterations, tolerance } => {
            format!("iterated extended Kalman filter, up to {max_iterations} iterations, tolerance {tolerance}")
        }
        Method::Ekf => "extended Kalman filter".to_owned(),
        Method::Ukf { spread } => {
            format!("unscented Kalman filter, sigma points {} standard deviations out", significant(spread, 4))
        }
    };
    let hold = match settings.hold {
        InputHold::FirstOrder => "first-order hold",
        InputHold::ZeroOrder => "zero-order hold",
    };
    let preparation = &session.preparation;
    let path = match preparation.path {
        PathSource::Filtered => "filtered states, biases at their final estimates",
        PathSource::Smoothed if settings.smoother_passes > 1 => {
            &format!("smoothed states, up to {} passes", settings.smoother_passes)
        }
        PathSource::Smoothed => "smoothed states",
        PathSource::Measured => "as measured, without a filter",
    };
    vec![
        ("Filter", method),
        ("Inertial inputs", hold.to_owned()),
        ("Source of the coefficients", path.to_owned()),
        ("Angular acceleration", contents.results.differentiation.clone()),
    ]
}

/// What was corrected in the signals and the coefficients.
fn corrections<'a>(contents: &Contents<'_>) -> Vec<(&'a str, String)> {
    let (settings, preparation) = (&contents.session.filter, &contents.session.preparation);
    let listed = |found: Vec<String>| if found.is_empty() { "none".to_owned() } else { found.join(", ") };
    let delays = Measurement::ALL.into_iter().zip(settings.measurement_delay_s).filter(|(_, delay)| *delay != 0.0);
    let delays = delays.map(|(measurement, delay)| format!("{} {delay} s", notation::measurement(measurement)));
    let errors = AirState::ALL.into_iter().zip(settings.air_data_deviation).filter(|(_, deviation)| *deviation > 0.0);
    let errors = errors.map(|(state, _)| state.name().replace('_', " "));
    let yes_no = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let thrust = match preparation.thrust {
        ThrustTreatment::Included => "no",
        ThrustTreatment::ForceRemoved => "its force, not its moment",
        ThrustTreatment::Removed => "yes",
    };
    let rotors = match preparation.gyroscopic {
        Gyroscopic::Signed => "each with its direction of rotation, where the speeds are known",
        Gyroscopic::Summed => "all in the same direction of rotation (thesis Eq. 3.24), where the speeds are known",
        Gyroscopic::Ignored => "left out",
    };
    let axes = match preparation.axes {
        Axes::Body => "body",
        Axes::Stability => "stability",
    };
    vec![
        ("Accelerations moved to the centre of gravity", yes_no(preparation.correct_accelerometer)),
        ("Flow angles corrected for the position of the vanes", yes_no(preparation.correct_vanes)),
        ("GPS corrected for the position of its antenna", yes_no(preparation.correct_antenna)),
        ("Delays of measurements", listed(delays.collect())),
        ("Air-data errors estimated", listed(errors.collect())),
        ("Thrust removed from the coefficients", thrust.to_owned()),
        ("Gyroscopic moment of the propellers", rotors.to_owned()),
        ("Axes of moments and rates", axes.to_owned()),
        ("Actuator lag", preparation.control_lags.summary()),
        ("Omitted at the start of a manoeuvre", format!("{} s", preparation.settle_s)),
    ]
}

/// Wind and biases over the manoeuvres (thesis Tables 6.1 and 6.2).
pub(crate) fn wind_and_bias(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    let spread = tables::wind_and_bias(results);
    let mut blocks: Vec<Block> = (!spread.rows.is_empty()).then_some(Block::Table(spread)).into_iter().collect();
    blocks.extend(results.sensor_errors.as_ref().map(|found| Block::Table(error_table(found))));
    let mut panels = Vec::new();
    for spread in &results.wind_and_bias {
        let state = State::ALL.into_iter().find(|state| state.name() == spread.quantity);
        let (unit, scale) = state.map_or((spread.unit, 1.0), |state| notation::unit(state.dimension()));
        let points = results.windows.iter().zip(numbers_of(&results.windows)).filter_map(|(window, number)| {
            let row = window.states.iter().find(|row| row.state == spread.quantity)?;
            Some([number, scale * row.last_second_mean, 2.0 * scale * row.deviation])
        });
        let band =
            [spread.mean - spread.standard_deviation, spread.mean + spread.standard_deviation].map(|end| scale * end);
        let mut marks = Vec::new();
        if spread.windows > 1 {
            marks.push(Mark::Level {
                label: "mean ± standard deviation".into(),
                colour: Colour::by_index(7),
                value: scale * spread.mean,
                band,
            });
        }
        marks.push(points_with_bars("manoeuvre ± 2σ of the filter", points));
        let label = spread.quantity.replace('_', " ");
        panels.push(Panel::Plot(Plot { x: Axis::new("manoeuvre", ""), y: Axis::new(label, unit), marks }));
    }
    // One manoeuvre has its values in the table.
    if results.wind_and_bias.iter().any(|spread| spread.windows > 1) {
        blocks.push(Block::Figure(Figure::new(
            "wind and bias",
            "Wind and biases by number of the manoeuvre.",
            (3, 26.0),
            panels,
        )));
    }
    blocks
}

/// Innovations of every measurement.
pub fn innovations(contents: &Contents<'_>) -> Parts {
    let results = contents.results;
    let summary = tables::innovation_summary(results);
    if summary.rows.is_empty() {
        return Parts::default();
    }
    let mut blocks = Vec::new();
    let ratios = ratios(contents);
    if !ratios.rows.is_empty() {
        blocks.push(Block::Table(ratios));
    }
    let used = contents.session.active_windows();
    for window in used {
        let Some(path) = contents.snapshot.windows.get(&window.name).and_then(|results| results.path.ready()) else {
            continue;
        };
        let panels: Vec<Panel> = Measurement::ALL.into_iter().filter_map(|m| innovation(m, path)).collect();
        if !panels.is_empty() {
            let figure = Figure::new(
                format!("innovations {}", window.name),
                format!("Innovations of manoeuvre {} in their predicted ±2σ band.", window.name),
                (4, 14.0),
                panels,
            );
            blocks.push(Block::Figure(figure.with_excluded(&window.excluded)));
        }
    }
    Parts { body: vec![Block::Table(summary)], appendix: blocks }
}

fn innovation(measurement: Measurement, path: &WindowPath) -> Option<Panel> {
    let index = measurement as usize;
    let innovations = &path.series().innovations[index];
    if !innovations.values.iter().any(|value| value.is_finite()) {
        return None;
    }
    // Other measurements are due between the samples of this one.
    let due = |values: &[f64]| -> Arc<[f64]> {
        values.iter().zip(&*innovations.values).filter(|(_, due)| due.is_finite()).map(|(value, _)| *value).collect()
    };
    let shown = |values: &[f64]| Series { time_s: due(&innovations.time_s), values: due(values) };
    let (unit, scale) = notation::unit(measurement.dimension());
    let band = Mark::Band {
        label: "predicted ±2σ".into(),
        colour: Colour::by_index(1),
        centre: shown(&path.series().innovation_zero.values),
        half_width: due(&path.series().innovation_deviations[index]).iter().map(|deviation| 2.0 * deviation).collect(),
        scale,
    };
    let marks = vec![band, line("innovation", 0, &shown(&innovations.values), scale)];
    let label = notation::measurement(measurement);
    Some(Panel::Plot(Plot { x: Axis::time(), y: Axis::new(label, unit), marks }))
}

/// One row per window, one column per measurement.
fn ratios(contents: &Contents<'_>) -> Table {
    let results = contents.results;
    let measurements: Vec<&str> = results.innovation_summary.iter().map(|row| row.measurement).collect();
    let mut columns = vec![Column::new("window", "Manoeuvre")];
    columns.extend(measurements.iter().map(|&name| {
        let symbol = Measurement::from_name(name).map_or(name, notation::measurement);
        Column::number(name, symbol, "", 3)
    }));
    let rows = results.windows.iter().map(|window| {
        let ratio = |name: &&str| {
            let row = window.innovations.iter().find(|row| row.measurement == *name);
            Cell::maybe(row.map(|row| row.ratio))
        };
        std::iter::once(Cell::text(&window.name)).chain(measurements.iter().map(ratio)).collect()
    });
    Table {
        name: "innovation_ratios".to_owned(),
        caption: format!(
            "Root mean square of the innovations of each manoeuvre in predicted standard deviations: {} if the noise is as stated.",
            significant(1.0, 1)
        ),
        columns,
        rows: rows.collect(),
    }
}
