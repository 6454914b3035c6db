//! The tables of the results as CSV, one file each, SI units in the header.

use std::path::Path;

use super::ReportError;
use super::results::{AgreementRow, EngineRow, FitRow, Results};

/// Writes `derivatives.csv`, `fits.csv`, `states.csv`, `innovations.csv`, `predictions.csv` and `engines.csv`.
pub fn write(results: &Results, folder: &Path) -> Result<(), ReportError> {
    let fits = || {
        let pooled = results.pooled.iter().map(|fit| ("pooled", fit));
        let single =
            results.windows.iter().flat_map(|window| window.fits.iter().map(|fit| (window.name.as_str(), fit)));
        pooled.chain(single)
    };
    table(
        &folder.join("derivatives.csv"),
        &[
            "window",
            "coefficient",
            "derivative",
            "estimate",
            "standard_error",
            "corrected_standard_error",
            "relative_error_percent",
            "t",
        ],
        fits().flat_map(|(window, fit)| derivative_rows(window, fit)),
    )?;
    table(
        &folder.join("fits.csv"),
        &[
            "window",
            "coefficient",
            "samples",
            "r_squared",
            "rms_relative_percent",
            "residual_deviation",
            "condition_number",
            "error",
        ],
        fits().map(|(window, fit)| {
            vec![
                window.to_owned(),
                fit.coefficient.to_owned(),
                fit.samples.to_string(),
                number(fit.r_squared),
                number(fit.rms_relative_percent),
                number(fit.residual_deviation),
                number(fit.condition_number),
                fit.error.clone().unwrap_or_default(),
            ]
        }),
    )?;
    let windows = &results.windows;
    table(
        &folder.join("states.csv"),
        &["window", "state", "unit", "estimate", "deviation", "truth", "mean_squared_normalised_error"],
        windows.iter().flat_map(|window| {
            window.states.iter().map(|row| {
                vec![
                    window.name.clone(),
                    row.state.to_owned(),
                    row.unit.to_owned(),
                    number(row.estimate),
                    number(row.deviation),
                    row.truth.map(number).unwrap_or_default(),
                    row.mean_squared_normalised_error.map(number).unwrap_or_default(),
                ]
            })
        }),
    )?;
    table(
        &folder.join("innovations.csv"),
        &["window", "measurement", "samples", "mean_over_deviation", "rms_over_deviation", "white", "advice"],
        windows.iter().flat_map(|window| {
            window.innovations.iter().map(|row| {
                vec![
                    window.name.clone(),
                    row.measurement.to_owned(),
                    row.samples.to_string(),
                    number(row.mean),
                    number(row.ratio),
                    row.is_white.to_string(),
                    row.advice.clone(),
                ]
            })
        }),
    )?;
    table(
        &folder.join("predictions.csv"),
        &["window", "role", "coefficient", "r_squared", "rms_relative_percent"],
        results.predictions.iter().map(|row| {
            vec![
                row.window.clone(),
                row.role.to_owned(),
                row.coefficient.to_owned(),
                number(row.r_squared),
                number(row.rms_relative_percent),
            ]
        }),
    )?;
    table(
        &folder.join("engines.csv"),
        &["flight", "engine", "quantity", "start_s", "end_s", "samples", "mean_modelled_w", "mean_monitor_w", "value"],
        results.engines.iter().flat_map(engine_rows),
    )
}

/// R2, root mean square and correlations over the whole flight, then R2 and root mean square of each phase.
fn engine_rows(engine: &EngineRow) -> Vec<Vec<String>> {
    let Some(monitor) = &engine.monitor else {
        let mut row = vec![String::new(); 9];
        row[0].clone_from(&engine.flight);
        row[1].clone_from(&engine.engine);
        row[2].push_str("modelled_only");
        row[5] = engine.samples.to_string();
        row[6] = number(engine.mean_power_w);
        return vec![row];
    };
    let row = |quantity: String, [start_s, end_s]: [f64; 2], agreement: &AgreementRow, value: f64| {
        vec![
            engine.flight.clone(),
            engine.engine.clone(),
            quantity,
            number(start_s),
            number(end_s),
            agreement.samples.to_string(),
            number(agreement.mean_modelled_w),
            number(agreement.mean_monitor_w),
            number(value),
        ]
    };
    let flight = [f64::NAN; 2];
    let mut rows = vec![
        row("r_squared".to_owned(), flight, &monitor.whole, monitor.whole.r_squared),
        row("rms_w".to_owned(), flight, &monitor.whole, monitor.whole.rms_w),
    ];
    for correlation in &monitor.correlations {
        let name = format!("correlation_{}", correlation.variable);
        rows.push(row(name, flight, &monitor.whole, correlation.coefficient));
    }
    for phase in &monitor.phases {
        let span = [phase.start_s, phase.end_s];
        rows.push(row(format!("{}_r_squared", phase.phase), span, &phase.agreement, phase.agreement.r_squared));
        rows.push(row(format!("{}_rms_w", phase.phase), span, &phase.agreement, phase.agreement.rms_w));
    }
    rows
}

fn derivative_rows(window: &str, fit: &FitRow) -> Vec<Vec<String>> {
    let rows = fit.derivatives.iter().map(|row| {
        vec![
            window.to_owned(),
            fit.coefficient.to_owned(),
            row.name.clone(),
            number(row.estimate),
            number(row.standard_error),
            number(row.corrected_standard_error),
            number(row.relative_error_percent),
            number(row.t),
        ]
    });
    rows.collect()
}

/// The shortest text that reads back to the same number; empty for one that does not exist.
pub(super) fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

pub(super) fn table(path: &Path, header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Result<(), ReportError> {
    let failed = |error: csv::Error| ReportError::File { path: path.display().to_string(), source: error.into() };
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    writer.write_record(header).map_err(failed)?;
    for row in rows {
        writer.write_record(row).map_err(failed)?;
    }
    writer.flush().map_err(|source| ReportError::File { path: path.display().to_string(), source })
}
