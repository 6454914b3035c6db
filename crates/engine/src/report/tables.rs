//! The results as tables.

pub use super::manoeuvre_map::table as manoeuvre_map;
pub use super::mass::table as mass_properties;
use doublet_core::series::TimeRange;

use super::prediction::PredictionAgreement;
use super::results::{AgreementRow, EngineRow, FitRow, Results};
use super::table::{Cell, Column, Table, TableOf};
use crate::session::Verdict;
use crate::verdict::CONDITION_LIMIT;

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
        manoeuvre_map(results),
        mass_properties(results),
        channels(results),
        clocks(results),
        recordings(results),
        files(results),
        noise(results),
        signals(results),
    ];
    tables.extend(super::proof::tables(&results.proof_of_match));
    tables.extend(results.sensor_errors.as_ref().map(super::sensor_errors::error_table));
    tables.extend(super::studies::tables(&results.studies));
    tables
}

fn level(verdict: &Verdict) -> &str {
    verdict.level.name()
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
    let rows = all_fits(results).flat_map(|(window, fit)| fit.derivatives.iter().map(move |row| (window, fit, row)));
    TableOf::new("derivatives", "Aerodynamic and control derivatives, per radian.", rows)
        .text("window", "Manoeuvre", |(window, ..)| window)
        .symbol("coefficient", "Coefficient", |(_, fit, _)| fit.coefficient)
        .symbol("derivative", "Derivative", |(.., row)| &row.name)
        .number("estimate", "Estimate", "", 5, |(.., row)| row.estimate)
        .number("standard_error", "Standard error", "", 4, |(.., row)| row.standard_error)
        .number("corrected_standard_error", "Corrected", "", 4, |(.., row)| row.corrected_standard_error)
        .number("relative_error_percent", "Relative", "%", 3, |(.., row)| row.relative_error_percent)
        .number("t", "t", "", 4, |(.., row)| row.t)
        .optional("verdict", "Verdict", |(.., row)| row.verdict.as_ref().map(level))
        .when(any_held, |table| table.optional("held", "Held", |(.., row)| row.held))
        .done()
}

/// Each derivative pooled and over the identification windows.
pub fn derivative_summary(results: &Results) -> Table {
    let rows = results.derivative_summary.iter();
    TableOf::new("derivative_summary", "Derivatives from all identification manoeuvres and from each alone.", rows)
        .symbol("coefficient", "Coefficient", |row| row.coefficient)
        .symbol("derivative", "Derivative", |row| &row.name)
        .maybe("pooled", "Pooled", "", 4, |row| row.pooled)
        .maybe("standard_error", "Std error", "", 2, |row| row.standard_error)
        .maybe("corrected_standard_error", "Corrected", "", 2, |row| row.corrected_standard_error)
        .number("scatter", "Scatter", "", 2, |row| row.scatter)
        .count("windows", "Manoeuvres", |row| row.windows)
        .number("mean", "Mean", "", 4, |row| row.mean)
        .number("minimum", "Min", "", 4, |row| row.minimum)
        .number("maximum", "Max", "", 4, |row| row.maximum)
        .number("mean_variance", "Mean var", "", 3, |row| row.mean_variance)
        .number("minimum_variance", "Min var", "", 3, |row| row.minimum_variance)
        .number("maximum_variance", "Max var", "", 3, |row| row.maximum_variance)
        .done()
}

/// Quality of every fit.
pub fn fits(results: &Results) -> Table {
    let rows = all_fits(results);
    TableOf::new("fits", "Quality of the fits.", rows)
        .text("window", "Manoeuvre", |(window, _)| window)
        .symbol("coefficient", "Coefficient", |(_, fit)| fit.coefficient)
        .count("samples", "Samples", |(_, fit)| fit.samples)
        .number("r_squared", "R²", "", 4, |(_, fit)| fit.r_squared)
        .number("rms_relative_percent", "RMS rel", "%", 3, |(_, fit)| fit.rms_relative_percent)
        .number("residual_deviation", "Residual std", "", 3, |(_, fit)| fit.residual_deviation)
        .number("condition_number", &format!("Condition (limit {CONDITION_LIMIT})"), "", 3, |(_, fit)| {
            fit.condition_number
        })
        .optional("verdict", "Verdict", |(_, fit)| fit.verdict.as_ref().map(level))
        .optional("error", "Remark", |(_, fit)| fit.error.as_deref())
        .done()
}

/// Residuals over the identification windows (thesis Table 6.3).
pub(crate) fn residual_summary(results: &Results) -> Table {
    let caption =
        "Root mean square of the residual over the largest magnitude of the observation, fits of single manoeuvres.";
    let rows = results.residual_summary.iter();
    TableOf::new("residual_summary", caption, rows)
        .symbol("coefficient", "Coefficient", |row| row.coefficient)
        .count("windows", "Manoeuvres", |row| row.windows)
        .number("mean_percent", "Mean RMS rel", "%", 3, |row| row.mean_percent)
        .number("minimum_percent", "Min", "%", 3, |row| row.minimum_percent)
        .number("maximum_percent", "Max", "%", 3, |row| row.maximum_percent)
        .done()
}

/// Final states of every window.
pub fn states(results: &Results) -> Table {
    let rows = results.windows.iter().flat_map(|window| window.states.iter().map(move |row| (window, row)));
    TableOf::new("states", "States at the end of each manoeuvre.", rows)
        .text("window", "Manoeuvre", |(window, _)| &window.name)
        .text("state", "State", |(_, row)| row.state)
        .text("unit", "Unit", |(_, row)| row.unit)
        .number("estimate", "Estimate", "", 4, |(_, row)| row.estimate)
        .number("deviation", "Std deviation", "", 3, |(_, row)| row.deviation)
        .number("last_second_mean", "Mean of last second", "", 4, |(_, row)| row.last_second_mean)
        .maybe("truth", "Truth", "", 4, |(_, row)| row.truth)
        .maybe("mean_squared_normalised_error", "Normalised error²", "", 3, |(_, row)| {
            row.mean_squared_normalised_error
        })
        .done()
}

/// Wind and biases over the manoeuvres (thesis Tables 6.1 and 6.2).
pub(crate) fn wind_and_bias(results: &Results) -> Table {
    let caption = "Wind and biases: mean of the last second of each manoeuvre, over all manoeuvres.";
    let rows = results.wind_and_bias.iter();
    TableOf::new("wind_and_bias", caption, rows)
        .text("quantity", "Quantity", |row| row.quantity)
        .text("unit", "Unit", |row| row.unit)
        .count("windows", "Manoeuvres", |row| row.windows)
        .number("mean", "Mean", "", 3, |row| row.mean)
        .number("standard_deviation", "Std deviation", "", 3, |row| row.standard_deviation)
        .number("minimum", "Min", "", 3, |row| row.minimum)
        .number("maximum", "Max", "", 3, |row| row.maximum)
        .done()
}

/// Innovations of every measurement in every window.
pub fn innovations(results: &Results) -> Table {
    let rows = results.windows.iter().flat_map(|window| window.innovations.iter().map(move |row| (window, row)));
    TableOf::new("innovations", "Innovations in predicted standard deviations.", rows)
        .text("window", "Manoeuvre", |(window, _)| &window.name)
        .text("measurement", "Measurement", |(_, row)| row.measurement)
        .count("samples", "Samples", |(_, row)| row.samples)
        .number("mean_over_deviation", "Mean/σ", "", 3, |(_, row)| row.mean)
        .number("rms_over_deviation", "RMS/σ", "", 3, |(_, row)| row.ratio)
        .column(Column::new("white", "White"), |(_, row)| Cell::Flag(row.is_white))
        .text("advice", "Advice", |(_, row)| &row.advice)
        .done()
}

/// Innovations of each measurement over the manoeuvres.
pub(crate) fn innovation_summary(results: &Results) -> Table {
    let caption = "Innovations of each measurement in predicted standard deviations: 1 when the noise is as stated.";
    let rows = results.innovation_summary.iter();
    TableOf::new("innovation_summary", caption, rows)
        .text("measurement", "Measurement", |row| row.measurement)
        .count("windows", "Manoeuvres", |row| row.windows)
        .number("mean_ratio", "Mean RMS/σ", "", 3, |row| row.mean_ratio)
        .number("minimum_ratio", "Min", "", 3, |row| row.minimum_ratio)
        .number("maximum_ratio", "Max", "", 3, |row| row.maximum_ratio)
        .count("white_windows", "White innovations in", |row| row.white_windows)
        .done()
}

/// Prediction of every manoeuvre by the pooled derivatives.
pub fn predictions(results: &Results) -> Table {
    let caption = format!("Prediction of each manoeuvre. {CONSTANTS}");
    let table = TableOf::new("predictions", caption, &results.predictions)
        .text("window", "Manoeuvre", |row| &row.window)
        .text("role", "Use", |row| row.role)
        .symbol("coefficient", "Coefficient", |row| row.coefficient);
    agreement(table, |row| &row.agreement)
}

/// What the two agreements of a prediction are.
pub(super) const CONSTANTS: &str = "Identified: with the identified derivatives and constants (mean of constants per manoeuvre). Own: with the \
                                     constant fitted to the predicted manoeuvre.";

fn agreement<R>(table: TableOf<R>, of: impl Fn(&R) -> &PredictionAgreement) -> Table {
    table
        .number("r_squared_identified_constants", "R² identified", "", 4, |row| of(row).r_squared_identified_constants)
        .number("rms_relative_percent_identified_constants", "RMS rel identified", "%", 3, |row| {
            of(row).rms_relative_percent_identified_constants
        })
        .number("r_squared_own_constant", "R² own", "", 4, |row| of(row).r_squared_own_constant)
        .number("rms_relative_percent_own_constant", "RMS rel own", "%", 3, |row| {
            of(row).rms_relative_percent_own_constant
        })
        .done()
}

/// Prediction of the validation manoeuvres (thesis Table 7.1).
pub fn validation(results: &Results) -> Table {
    let caption = format!("Predictions averaged over the validation manoeuvres. {CONSTANTS}");
    let table = TableOf::new("validation", caption, &results.validation)
        .symbol("coefficient", "Coefficient", |row| row.coefficient)
        .count("windows", "Manoeuvres", |row| row.windows);
    agreement(table, |row| &row.agreement)
}

/// The windows, with their notes and with why they failed where there are any.
pub fn windows(results: &Results) -> Table {
    let noted = results.windows.iter().any(|row| !row.note.is_empty());
    let failed = results.windows.iter().any(|row| row.error.is_some());
    let excluded = results.windows.iter().any(|row| !row.excluded.is_empty());
    let steady = results.windows.iter().any(|row| row.before_input.is_some());
    TableOf::new("windows", "Manoeuvres, with steadiness before the input.", &results.windows)
        .text("window", "Manoeuvre", |row| &row.name)
        .text("flight", "Flight", |row| &row.flight)
        .number("start_s", "Start", "s", 6, |row| row.start_s)
        .number("end_s", "End", "s", 6, |row| row.end_s)
        .text("role", "Use", |row| row.role)
        .optional("surface", "Surface", |row| row.surface)
        .text("kind", "Input", |row| &row.kind)
        .count("samples", "Samples", |row| row.samples)
        .when(excluded, |table| {
            table.number("excluded_s", "Excluded", "s", 3, |row| row.excluded.iter().map(TimeRange::length_s).sum())
        })
        .when(steady, |table| {
            table
                .maybe("before_input_s", "Before input", "s", 3, |row| Some(row.before_input?.length_s))
                .maybe("airspeed_slope_m_s2", "dV/dt", "m/s²", 2, |row| Some(row.before_input?.airspeed_slope_m_s2))
                .maybe("w_slope_m_s2", "dw/dt", "m/s²", 2, |row| Some(row.before_input?.w_slope_m_s2))
                .maybe("climb_m_s", "Climb", "m/s", 2, |row| row.before_input?.climb_m_s)
        })
        .number("mean_nis", "Mean NIS", "", 4, |row| row.mean_nis)
        .number("expected_nis", "Expected", "", 4, |row| row.expected_nis)
        .number("nis_band_correlated_low", "95 % from", "", 4, |row| row.nis_band_correlated[0])
        .number("nis_band_correlated_high", "to", "", 4, |row| row.nis_band_correlated[1])
        .when(noted, |table| table.text("note", "Note", |row| &row.note))
        .when(failed, |table| table.text("error", "Why it failed", |row| row.error.as_deref().unwrap_or_default()))
        .done()
}

/// Channels that play roles.
pub fn channels(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| flight.channels.iter().map(move |row| (flight, row)));
    TableOf::new("channels", "Channels and their roles.", rows)
        .text("flight", "Flight", |(flight, _)| &flight.name)
        .text("role", "Role", |(_, row)| row.role)
        .text("source", "Recorder", |(_, row)| &row.source)
        .text("channel", "Channel", |(_, row)| &row.name)
        .text("unit", "Unit", |(_, row)| &row.unit)
        .count("samples", "Samples", |(_, row)| row.samples)
        .number("rate_hz", "Rate", "Hz", 3, |(_, row)| row.rate_hz)
        .done()
}

/// Clocks of the recorders.
pub fn clocks(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| flight.clocks.iter().map(move |row| (flight, row)));
    TableOf::new("clocks", "Clocks, t = offset + (1 + drift) t of the recorder.", rows)
        .text("flight", "Flight", |(flight, _)| &flight.name)
        .text("source", "Recorder", |(_, row)| &row.source)
        .number("offset_s", "Offset", "s", 7, |(_, row)| row.offset_s)
        .maybe("standard_error_s", "Std error", "s", 2, |(_, row)| row.standard_error_s)
        .number("drift", "Drift", "s/s", 4, |(_, row)| row.drift)
        .maybe("drift_standard_error", "Std error", "s/s", 2, |(_, row)| row.drift_standard_error)
        .done()
}

/// Recordings and their hashes.
pub fn recordings(results: &Results) -> Table {
    TableOf::new("recordings", "Recordings and their content.", &results.recordings)
        .text("flight", "Flight", |row| &row.flight)
        .text("path", "Recording", |row| &row.path)
        .text("sha256", "SHA-256", |row| &row.sha256)
        .done()
}

/// Aircraft and instruments files and their hashes.
pub fn files(results: &Results) -> Table {
    TableOf::new("files", "Aircraft and instruments files and their content.", &results.files)
        .text("kind", "Kind", |row| row.kind)
        .text("flight", "Flight", |row| &row.flight)
        .text("path", "File", |row| &row.path)
        .text("sha256", "SHA-256", |row| &row.sha256)
        .done()
}

/// Noise the filter was given, beside what the recordings propose.
pub fn noise(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| flight.noise.iter().map(move |row| (flight, row)));
    TableOf::new("noise", "Standard deviations of process and measurement noise, used and proposed.", rows)
        .text("flight", "Flight", |(flight, _)| &flight.name)
        .text("entry", "Entry", |(_, row)| row.entry)
        .text("unit", "Unit", |(_, row)| row.unit)
        .number("used", "Used", "", 3, |(_, row)| row.used)
        .maybe("proposed", "Proposed", "", 3, |(_, row)| row.proposed)
        .text("origin", "Origin of the proposal", |(_, row)| &row.origin)
        .maybe("deviation", "Steady", "", 3, |(_, row)| row.deviation)
        .column(Column::new("samples", "Samples"), |(_, row)| row.samples.map_or(Cell::Empty, Cell::Count))
        .maybe("whiteness", "Whiteness", "", 2, |(_, row)| row.whiteness)
        .optional("reason", "Reason", |(_, row)| row.reason.as_deref())
        .done()
}

/// Signals that were smoothed or resampled.
pub fn signals(results: &Results) -> Table {
    let rows = results.flights.iter().flat_map(|flight| flight.signals.iter().map(move |row| (flight, row)));
    TableOf::new("signals", "Signals that were smoothed or resampled.", rows)
        .text("flight", "Flight", |(flight, _)| &flight.name)
        .text("role", "Role", |(_, row)| row.role)
        .text("recorded", "Recorded in", |(_, row)| &row.recorded)
        .column(Column::new("steps", "Treatment"), |(_, row)| Cell::text(row.steps.join("; ")))
        .count("samples_recorded", "Recorded samples", |(_, row)| row.samples_recorded)
        .count("samples", "Samples used", |(_, row)| row.samples)
        .count("stretches", "Stretches", |(_, row)| row.stretches)
        .done()
}

/// Modelled engine power against that of the monitors.
pub fn engines(results: &Results) -> Table {
    let columns = vec![
        Column::new("flight", "Flight"),
        Column::new("engine", "Engine"),
        Column::new("phase", "Phase"),
        Column::new("quantity", "Quantity"),
        Column::number("start_s", "Start", "s", 5),
        Column::number("end_s", "End", "s", 5),
        Column::new("samples", "Samples"),
        Column::number("mean_modelled_w", "Mean modelled", "W", 4),
        Column::number("mean_monitor_w", "Mean monitor", "W", 4),
        Column::number("value", "Value", "", 4),
        Column::new("unit", "Unit"),
    ];
    let caption = "Power of each engine, modelled and from its monitor; r² is the square of their correlation.";
    let rows = results.engines.iter().flat_map(engine_rows).collect();
    Table { name: "engines".to_owned(), caption: caption.to_owned(), columns, rows }
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
    let both = |phase: &str, span: [f64; 2], agreement: &AgreementRow| {
        let square = ("r²".to_owned(), agreement.r_squared, "");
        let rms = ("RMS of the difference".to_owned(), agreement.rms_w, "W");
        [square, rms].map(|figure| agreement_row(&named, (phase, span), agreement, figure))
    };
    let (whole, flight) = ("whole flight", [f64::NAN; 2]);
    let mut rows = Vec::from(both(whole, flight, &monitor.whole));
    for correlation in &monitor.correlations {
        let name = format!("correlation of the difference with {}", correlation.variable.replace('_', " "));
        rows.push(agreement_row(&named, (whole, flight), &monitor.whole, (name, correlation.coefficient, "")));
    }
    for phase in &monitor.phases {
        rows.extend(both(&phase.phase, [phase.start_s, phase.end_s], &phase.agreement));
    }
    rows
}

fn agreement_row(
    named: &[Cell],
    (phase, [start_s, end_s]): (&str, [f64; 2]),
    agreement: &AgreementRow,
    (quantity, value, unit): (String, f64, &str),
) -> Vec<Cell> {
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
}
