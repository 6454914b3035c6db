//! The results as tables.

pub use super::mass::table as mass_properties;
use super::prediction::PredictionAgreement;
use super::results::{AgreementRow, EngineRow, FitRow, Results};
use super::table::{Cell, Column, Table};
use crate::verdict::Verdict;

/// Every table of the results that leaves the program as a file, in the order of `docs/results.md`.
pub fn all(results: &Results) -> Vec<Table> {
    let mut tables = vec![
        derivatives(results),
        derivative_summary(results),
        fits(results),
        residual_summary(results),
        states(results),
        wind_and_bias(results),
        innovations(results),
        innovation_summary(results),
        predictions(results),
        validation(results),
        engines(results),
        windows(results),
        mass_properties(results),
        channels(results),
        clocks(results),
        recordings(results),
        noise(results),
        signals(results),
    ];
    tables.extend(super::proof::tables(&results.proof_of_match));
    tables.extend(super::studies::tables(&results.studies));
    tables
}

/// A table of `name`.
pub(super) fn table(
    name: &str,
    caption: &str,
    columns: Vec<Column>,
    rows: impl IntoIterator<Item = Vec<Cell>>,
) -> Table {
    Table { name: name.to_owned(), caption: caption.to_owned(), columns, rows: rows.into_iter().collect() }
}

fn text(key: &str, heading: &str) -> Column {
    Column::new(key, heading)
}

fn number(key: &str, heading: &str, unit: &'static str) -> Column {
    Column::number(key, heading, unit, 4)
}

fn optional(text: Option<&str>) -> Cell {
    text.map_or(Cell::Empty, Cell::text)
}

fn level(verdict: Option<&Verdict>) -> Cell {
    optional(verdict.map(|verdict| verdict.level.name()))
}

/// Pooled fits, then those of each window.
fn all_fits(results: &Results) -> impl Iterator<Item = (&str, &FitRow)> {
    let pooled = results.pooled.iter().map(|fit| ("pooled", fit));
    let single = results.windows.iter().flat_map(|window| window.fits.iter().map(|fit| (window.name.as_str(), fit)));
    pooled.chain(single)
}

/// Every derivative of every fit.
pub fn derivatives(results: &Results) -> Table {
    let any_held = all_fits(results).flat_map(|(_, fit)| &fit.derivatives).any(|row| row.held.is_some());
    let rows = all_fits(results).flat_map(|(window, fit)| {
        fit.derivatives.iter().map(move |row| {
            let mut cells = vec![
                Cell::text(window),
                Cell::Symbol(fit.coefficient.to_owned()),
                Cell::Symbol(row.name.clone()),
                Cell::Number(row.estimate),
                Cell::Number(row.standard_error),
                Cell::Number(row.corrected_standard_error),
                Cell::Number(row.relative_error_percent),
                Cell::Number(row.t),
                level(row.verdict.as_ref()),
            ];
            cells.extend(any_held.then(|| optional(row.held)));
            cells
        })
    });
    let mut columns = vec![
        text("window", "Window"),
        text("coefficient", "Coefficient"),
        text("derivative", "Derivative"),
        Column::number("estimate", "Estimate", "", 5),
        number("standard_error", "Standard error", ""),
        number("corrected_standard_error", "Corrected", ""),
        Column::number("relative_error_percent", "Relative", "%", 3),
        number("t", "t", ""),
        text("verdict", "Verdict"),
    ];
    columns.extend(any_held.then(|| text("held", "Held")));
    table("derivatives", "Aerodynamic and control derivatives, per radian.", columns, rows)
}

/// Each derivative pooled and over the identification windows.
pub fn derivative_summary(results: &Results) -> Table {
    let rows = results.derivative_summary.iter().map(|row| {
        vec![
            Cell::Symbol(row.coefficient.to_owned()),
            Cell::Symbol(row.name.clone()),
            Cell::maybe(row.pooled),
            Cell::maybe(row.standard_error),
            Cell::maybe(row.corrected_standard_error),
            Cell::Number(row.scatter),
            Cell::Count(row.windows),
            Cell::Number(row.mean),
            Cell::Number(row.minimum),
            Cell::Number(row.maximum),
            Cell::Number(row.mean_variance),
            Cell::Number(row.minimum_variance),
            Cell::Number(row.maximum_variance),
        ]
    });
    let columns = vec![
        text("coefficient", "Coefficient"),
        text("derivative", "Derivative"),
        number("pooled", "Pooled", ""),
        Column::number("standard_error", "Std error", "", 2),
        Column::number("corrected_standard_error", "Corrected", "", 2),
        Column::number("scatter", "Scatter", "", 2),
        text("windows", "Windows"),
        number("mean", "Mean", ""),
        number("minimum", "Min", ""),
        number("maximum", "Max", ""),
        Column::number("mean_variance", "Mean var", "", 3),
        Column::number("minimum_variance", "Min var", "", 3),
        Column::number("maximum_variance", "Max var", "", 3),
    ];
    table("derivative_summary", "Derivatives from all identification windows and from each alone.", columns, rows)
}

/// Quality of every fit.
pub fn fits(results: &Results) -> Table {
    let rows = all_fits(results).map(|(window, fit)| {
        vec![
            Cell::text(window),
            Cell::Symbol(fit.coefficient.to_owned()),
            Cell::Count(fit.samples),
            Cell::Number(fit.r_squared),
            Cell::Number(fit.rms_relative_percent),
            Cell::Number(fit.residual_deviation),
            Cell::Number(fit.condition_number),
            level(fit.verdict.as_ref()),
            optional(fit.error.as_deref()),
        ]
    });
    let columns = vec![
        text("window", "Window"),
        text("coefficient", "Coefficient"),
        text("samples", "Samples"),
        number("r_squared", "R²", ""),
        Column::number("rms_relative_percent", "RMS rel", "%", 3),
        Column::number("residual_deviation", "Residual std", "", 3),
        Column::number("condition_number", "Condition", "", 3),
        text("verdict", "Verdict"),
        text("error", "Remark"),
    ];
    table("fits", "Quality of the fits.", columns, rows)
}

/// Residuals over the identification windows (thesis Table 6.3).
pub fn residual_summary(results: &Results) -> Table {
    let rows = results.residual_summary.iter().map(|row| {
        vec![
            Cell::Symbol(row.coefficient.to_owned()),
            Cell::Count(row.windows),
            Cell::Number(row.mean_percent),
            Cell::Number(row.minimum_percent),
            Cell::Number(row.maximum_percent),
        ]
    });
    let columns = vec![
        text("coefficient", "Coefficient"),
        text("windows", "Windows"),
        Column::number("mean_percent", "Mean RMS rel", "%", 3),
        Column::number("minimum_percent", "Min", "%", 3),
        Column::number("maximum_percent", "Max", "%", 3),
    ];
    let caption =
        "Root mean square of the residual over the largest magnitude of the observation, fits of single windows.";
    table("residual_summary", caption, columns, rows)
}

/// Final states of every window.
pub fn states(results: &Results) -> Table {
    let rows = results.windows.iter().flat_map(|window| {
        window.states.iter().map(|row| {
            vec![
                Cell::text(&window.name),
                Cell::text(row.state),
                Cell::text(row.unit),
                Cell::Number(row.estimate),
                Cell::Number(row.deviation),
                Cell::Number(row.last_second_mean),
                Cell::maybe(row.truth),
                Cell::maybe(row.mean_squared_normalised_error),
            ]
        })
    });
    let columns = vec![
        text("window", "Window"),
        text("state", "State"),
        text("unit", "Unit"),
        number("estimate", "Estimate", ""),
        Column::number("deviation", "Std deviation", "", 3),
        number("last_second_mean", "Mean of last second", ""),
        number("truth", "Truth", ""),
        Column::number("mean_squared_normalised_error", "Normalised error²", "", 3),
    ];
    table("states", "States at the end of every window.", columns, rows)
}

/// Wind and biases over the windows (thesis Tables 6.1 and 6.2).
pub fn wind_and_bias(results: &Results) -> Table {
    let rows = results.wind_and_bias.iter().map(|row| {
        vec![
            Cell::text(row.quantity),
            Cell::text(row.unit),
            Cell::Count(row.windows),
            Cell::Number(row.mean),
            Cell::Number(row.standard_deviation),
            Cell::Number(row.minimum),
            Cell::Number(row.maximum),
        ]
    });
    let columns = vec![
        text("quantity", "Quantity"),
        text("unit", "Unit"),
        text("windows", "Windows"),
        Column::number("mean", "Mean", "", 3),
        Column::number("standard_deviation", "Std deviation", "", 3),
        Column::number("minimum", "Min", "", 3),
        Column::number("maximum", "Max", "", 3),
    ];
    let caption = "Wind and biases: mean of the last second of each window, over the windows.";
    table("wind_and_bias", caption, columns, rows)
}

/// Innovations of every measurement in every window.
pub fn innovations(results: &Results) -> Table {
    let rows = results.windows.iter().flat_map(|window| {
        window.innovations.iter().map(|row| {
            vec![
                Cell::text(&window.name),
                Cell::text(row.measurement),
                Cell::Count(row.samples),
                Cell::Number(row.mean),
                Cell::Number(row.ratio),
                Cell::Flag(row.is_white),
                Cell::text(&row.advice),
            ]
        })
    });
    let columns = vec![
        text("window", "Window"),
        text("measurement", "Measurement"),
        text("samples", "Samples"),
        Column::number("mean_over_deviation", "Mean/σ", "", 3),
        Column::number("rms_over_deviation", "RMS/σ", "", 3),
        text("white", "White"),
        text("advice", "Advice"),
    ];
    table("innovations", "Innovations in predicted standard deviations.", columns, rows)
}

/// Innovations of each measurement over the windows.
pub fn innovation_summary(results: &Results) -> Table {
    let rows = results.innovation_summary.iter().map(|row| {
        vec![
            Cell::text(row.measurement),
            Cell::Count(row.windows),
            Cell::Number(row.mean_ratio),
            Cell::Number(row.minimum_ratio),
            Cell::Number(row.maximum_ratio),
            Cell::Count(row.white_windows),
        ]
    });
    let columns = vec![
        text("measurement", "Measurement"),
        text("windows", "Windows"),
        Column::number("mean_ratio", "Mean RMS/σ", "", 3),
        Column::number("minimum_ratio", "Min", "", 3),
        Column::number("maximum_ratio", "Max", "", 3),
        text("white_windows", "White in"),
    ];
    let caption = "Innovations of each measurement in predicted standard deviations: 1 when the noise is as stated.";
    table("innovation_summary", caption, columns, rows)
}

/// Prediction of every window by the pooled derivatives.
pub fn predictions(results: &Results) -> Table {
    let rows = results.predictions.iter().map(|row| {
        vec![Cell::text(&row.window), Cell::text(row.role), Cell::Symbol(row.coefficient.to_owned())]
            .into_iter()
            .chain(agreement(&row.agreement))
            .collect()
    });
    let mut columns = vec![text("window", "Window"), text("role", "Use"), text("coefficient", "Coefficient")];
    columns.extend(agreement_columns());
    table("predictions", &format!("Prediction of each window. {CONSTANTS}"), columns, rows)
}

/// What the two agreements of a prediction are.
pub(super) const CONSTANTS: &str = "Identified: with derivatives and constants of the identification, constants that each window has to                                     itself by their mean; own: with the constant fitted to the window predicted.";

/// Columns of the agreement of predictions.
fn agreement_columns() -> [Column; 4] {
    [
        Column::number("r_squared_identified_constants", "R² identified", "", 4),
        Column::number("rms_relative_percent_identified_constants", "RMS rel identified", "%", 3),
        Column::number("r_squared_own_constant", "R² own", "", 4),
        Column::number("rms_relative_percent_own_constant", "RMS rel own", "%", 3),
    ]
}

/// Cells of [`agreement_columns`].
fn agreement(of: &PredictionAgreement) -> [Cell; 4] {
    [
        of.r_squared_identified_constants,
        of.rms_relative_percent_identified_constants,
        of.r_squared_own_constant,
        of.rms_relative_percent_own_constant,
    ]
    .map(Cell::Number)
}

/// Prediction of the validation windows (thesis Table 7.1).
pub fn validation(results: &Results) -> Table {
    let rows = results.validation.iter().map(|row| {
        vec![Cell::Symbol(row.coefficient.to_owned()), Cell::Count(row.windows)]
            .into_iter()
            .chain(agreement(&row.agreement))
            .collect()
    });
    let mut columns = vec![text("coefficient", "Coefficient"), text("windows", "Windows")];
    columns.extend(agreement_columns());
    table("validation", &format!("Predictions averaged over the validation windows. {CONSTANTS}"), columns, rows)
}

/// The windows, with their notes and with why they failed where there are any.
pub fn windows(results: &Results) -> Table {
    let noted = results.windows.iter().any(|row| !row.note.is_empty());
    let failed = results.windows.iter().any(|row| row.error.is_some());
    let rows = results.windows.iter().map(|row| {
        let mut cells = vec![
            Cell::text(&row.name),
            Cell::text(&row.flight),
            Cell::Number(row.start_s),
            Cell::Number(row.end_s),
            Cell::text(row.role),
            optional(row.surface),
            Cell::text(&row.kind),
            Cell::Count(row.samples),
            Cell::Number(row.mean_nis),
            Cell::Number(row.expected_nis),
            Cell::Number(row.nis_band_correlated[0]),
            Cell::Number(row.nis_band_correlated[1]),
        ];
        cells.extend(noted.then(|| Cell::text(&row.note)));
        cells.extend(failed.then(|| Cell::text(row.error.as_deref().unwrap_or_default())));
        cells
    });
    let mut columns = vec![
        text("window", "Window"),
        text("flight", "Flight"),
        Column::number("start_s", "Start", "s", 6),
        Column::number("end_s", "End", "s", 6),
        text("role", "Use"),
        text("surface", "Surface"),
        text("kind", "Input"),
        text("samples", "Samples"),
        number("mean_nis", "Mean NIS", ""),
        number("expected_nis", "Expected", ""),
        number("nis_band_correlated_low", "95 % from", ""),
        number("nis_band_correlated_high", "to", ""),
    ];
    columns.extend(noted.then(|| text("note", "Note")));
    columns.extend(failed.then(|| text("error", "Why it failed")));
    table("windows", "Manoeuvre windows.", columns, rows)
}

/// Channels that play roles.
pub fn channels(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| {
        flight.channels.iter().map(|row| {
            vec![
                Cell::text(&flight.name),
                Cell::text(row.role),
                Cell::text(&row.source),
                Cell::text(&row.name),
                Cell::text(&row.unit),
                Cell::Count(row.samples),
                Cell::Number(row.rate_hz),
            ]
        })
    });
    let columns = vec![
        text("flight", "Flight"),
        text("role", "Role"),
        text("source", "Recorder"),
        text("channel", "Channel"),
        text("unit", "Unit"),
        text("samples", "Samples"),
        Column::number("rate_hz", "Rate", "Hz", 3),
    ];
    table("channels", "Channels by what they mean to the analysis.", columns, rows)
}

/// Clocks of the recorders.
pub fn clocks(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| {
        flight.clocks.iter().map(|row| {
            vec![
                Cell::text(&flight.name),
                Cell::text(&row.source),
                Cell::Number(row.offset_s),
                Cell::maybe(row.standard_error_s),
                Cell::Number(row.drift),
                Cell::maybe(row.drift_standard_error),
            ]
        })
    });
    let columns = vec![
        text("flight", "Flight"),
        text("source", "Recorder"),
        Column::number("offset_s", "Offset", "s", 7),
        Column::number("standard_error_s", "Std error", "s", 2),
        Column::number("drift", "Drift", "s/s", 4),
        Column::number("drift_standard_error", "Std error", "s/s", 2),
    ];
    table("clocks", "Clocks, t = offset + (1 + drift) t of the recorder.", columns, rows)
}

/// Recordings and their hashes.
pub fn recordings(results: &Results) -> Table {
    let rows = results
        .recordings
        .iter()
        .map(|row| vec![Cell::text(&row.flight), Cell::text(&row.path), Cell::text(&row.sha256)]);
    let columns = vec![text("flight", "Flight"), text("path", "Recording"), text("sha256", "SHA-256")];
    table("recordings", "Recordings and their content.", columns, rows)
}

/// Noise the filter was given, beside what the recordings propose.
pub fn noise(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| {
        flight.noise.iter().map(|row| {
            vec![
                Cell::text(&flight.name),
                Cell::text(row.entry),
                Cell::text(row.unit),
                Cell::Number(row.used),
                Cell::maybe(row.proposed),
                Cell::text(&row.origin),
                Cell::maybe(row.deviation),
                row.samples.map_or(Cell::Empty, Cell::Count),
                Cell::maybe(row.whiteness),
                optional(row.reason.as_deref()),
            ]
        })
    });
    let columns = vec![
        text("flight", "Flight"),
        text("entry", "Entry"),
        text("unit", "Unit"),
        Column::number("used", "Used", "", 3),
        Column::number("proposed", "Proposed", "", 3),
        text("origin", "Origin of the proposal"),
        Column::number("deviation", "Steady", "", 3),
        text("samples", "Samples"),
        Column::number("whiteness", "Whiteness", "", 2),
        text("reason", "Reason"),
    ];
    table("noise", "Standard deviations of process and measurement noise, used and proposed.", columns, rows)
}

/// Signals that were smoothed or resampled.
pub fn signals(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| {
        flight.signals.iter().map(|row| {
            vec![
                Cell::text(&flight.name),
                Cell::text(row.role),
                Cell::text(&row.recorded),
                Cell::text(row.steps.join("; ")),
                Cell::Count(row.samples_recorded),
                Cell::Count(row.samples),
                Cell::Count(row.stretches),
            ]
        })
    });
    let columns = vec![
        text("flight", "Flight"),
        text("role", "Role"),
        text("recorded", "Recorded in"),
        text("steps", "Treatment"),
        text("samples_recorded", "Recorded samples"),
        text("samples", "Samples used"),
        text("stretches", "Stretches"),
    ];
    table("signals", "Signals that were smoothed or resampled.", columns, rows)
}

/// Modelled engine power against that of the monitors.
pub fn engines(results: &Results) -> Table {
    let columns = vec![
        text("flight", "Flight"),
        text("engine", "Engine"),
        text("phase", "Phase"),
        text("quantity", "Quantity"),
        Column::number("start_s", "Start", "s", 5),
        Column::number("end_s", "End", "s", 5),
        text("samples", "Samples"),
        number("mean_modelled_w", "Mean modelled", "W"),
        number("mean_monitor_w", "Mean monitor", "W"),
        number("value", "Value", ""),
        text("unit", "Unit"),
    ];
    let caption =
        "Power of each engine, modelled and by its monitor; r² is the square of their correlation coefficient.";
    table("engines", caption, columns, results.engines.iter().flat_map(engine_rows))
}

/// Squared correlation, root mean square and correlations over the whole flight, then the first two of each phase.
fn engine_rows(engine: &EngineRow) -> Vec<Vec<Cell>> {
    let named = [Cell::text(&engine.flight), Cell::text(&engine.engine)];
    let Some(monitor) = &engine.monitor else {
        let mut row = vec![Cell::Empty; 11];
        row[..2].clone_from_slice(&named);
        row[2] = Cell::text("whole flight");
        row[3] = Cell::text("modelled only");
        row[6] = Cell::Count(engine.samples);
        row[7] = Cell::Number(engine.mean_power_w);
        return vec![row];
    };
    let row = |phase: &str, [start_s, end_s]: [f64; 2], agreement: &AgreementRow, (quantity, value, unit)| {
        let mut row = named.to_vec();
        row.extend([
            Cell::text(phase),
            Cell::Text(quantity),
            Cell::Number(start_s),
            Cell::Number(end_s),
            Cell::Count(agreement.samples),
            Cell::Number(agreement.mean_modelled_w),
            Cell::Number(agreement.mean_monitor_w),
            Cell::Number(value),
            Cell::text(unit),
        ]);
        row
    };
    let both = |phase: &str, span: [f64; 2], agreement: &AgreementRow| {
        let square = ("r²".to_owned(), agreement.r_squared, "");
        let rms = ("RMS of the difference".to_owned(), agreement.rms_w, "W");
        [row(phase, span, agreement, square), row(phase, span, agreement, rms)]
    };
    let (whole, flight) = ("whole flight", [f64::NAN; 2]);
    let mut rows = Vec::from(both(whole, flight, &monitor.whole));
    for correlation in &monitor.correlations {
        let name = format!("correlation of the difference with {}", correlation.variable.replace('_', " "));
        rows.push(row(whole, flight, &monitor.whole, (name, correlation.coefficient, "")));
    }
    for phase in &monitor.phases {
        rows.extend(both(&phase.phase, [phase.start_s, phase.end_s], &phase.agreement));
    }
    rows
}
