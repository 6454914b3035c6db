//! Errors of the sensors as rows, and as the tables `sensor_errors` and `sensor_error_outputs`.

use doublet_core::estimate::{EstimatedError, SensorErrorFit};
use serde::Serialize;

use super::studies::where_finite;
use super::table::{Table, TableOf};

/// Constant errors of the sensors.
#[derive(Clone, Debug, Serialize)]
pub struct SensorErrorsRow {
    /// One entry per error.
    pub errors: Vec<SensorErrorRow>,
    /// Initial states and winds of the manoeuvres.
    pub initial: Vec<InitialRow>,
    /// Measurements compared.
    pub outputs: Vec<SensorOutputRow>,
}

/// One error.
#[derive(Clone, Debug, Serialize)]
pub struct SensorErrorRow {
    /// Error, `scale_alpha`.
    pub error: String,
    /// Manoeuvre, if each has its own value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<String>,
    pub unit: &'static str,
    pub estimate: f64,
    /// Standard error for white residuals.
    pub standard_error: f64,
    /// Standard error corrected for correlated residuals.
    pub corrected_standard_error: f64,
    /// Estimate with the highest correlation of errors.
    pub partner: String,
    #[serde(serialize_with = "where_finite")]
    pub correlation: f64,
    /// Result of each manoeuvre alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<SensorWindowRow>,
}

/// What a window alone says of an error.
#[derive(Clone, Debug, Serialize)]
pub struct SensorWindowRow {
    /// Manoeuvre.
    pub window: String,
    /// Whether it determines the error.
    pub told: bool,
    /// Standard error from it alone; null if not determined.
    #[serde(serialize_with = "where_finite")]
    pub standard_error: f64,
    /// Estimate with the highest correlation of errors there.
    pub partner: String,
    #[serde(serialize_with = "where_finite")]
    pub correlation: f64,
}

/// An initial state or a component of the wind.
#[derive(Clone, Debug, Serialize)]
pub struct InitialRow {
    /// Name with its manoeuvre.
    pub name: String,
    /// Estimate, SI.
    pub estimate: f64,
    pub standard_error: f64,
}

/// What a measurement is left with.
#[derive(Clone, Debug, Serialize)]
pub struct SensorOutputRow {
    pub measurement: &'static str,
    pub samples: usize,
    /// Root mean square of the residual, of filter error the innovation, SI.
    pub rms: f64,
    /// The same over its expected standard deviation; null for output error.
    #[serde(serialize_with = "where_finite")]
    pub normalised: f64,
    /// Coefficient of determination.
    pub r_squared: f64,
}

/// Rows of an estimation.
pub fn rows(fit: &SensorErrorFit) -> SensorErrorsRow {
    let initial = |(name, estimate, standard_error): &(String, f64, f64)| InitialRow {
        name: name.clone(),
        estimate: *estimate,
        standard_error: *standard_error,
    };
    let outputs = fit.outputs.iter().map(|output| SensorOutputRow {
        measurement: output.measurement.name(),
        samples: output.samples,
        rms: output.rms,
        normalised: output.normalised,
        r_squared: output.r_squared,
    });
    SensorErrorsRow {
        errors: fit.errors.iter().map(describe_error).collect(),
        initial: fit.initial.iter().map(initial).collect(),
        outputs: outputs.collect(),
    }
}

fn describe_error(found: &EstimatedError) -> SensorErrorRow {
    let paired = |partner: &Option<(String, f64)>| partner.clone().unwrap_or((String::new(), f64::NAN));
    let (partner, correlation) = paired(&found.partner);
    let windows = found.windows.iter().map(|share| {
        let (partner, correlation) = paired(&share.partner);
        let (window, told) = (share.window.clone(), share.standard_error.is_finite());
        SensorWindowRow { window, told, standard_error: share.standard_error, partner, correlation }
    });
    SensorErrorRow {
        error: found.error.to_string(),
        window: found.window.clone(),
        unit: found.error.unit(),
        estimate: found.value,
        standard_error: found.standard_error,
        corrected_standard_error: found.corrected_error,
        partner,
        correlation,
        windows: windows.collect(),
    }
}

/// One row of the table: an error over all windows, or what one window says of it.
type Line<'a> = (&'a SensorErrorRow, &'a str, [f64; 3], &'a str, f64);

/// The errors, a row each, and below it what each window alone says.
pub fn error_table(found: &SensorErrorsRow) -> Table {
    const CAPTION: &str = "Constant sensor errors by maximum likelihood over all manoeuvres, and the standard error of each manoeuvre alone; the partner is the estimate with the highest correlation.";
    let lines = found.errors.iter().flat_map(|row| {
        let numbers = [row.estimate, row.standard_error, row.corrected_standard_error];
        let whole: Line<'_> = (row, row.window.as_deref().unwrap_or("all"), numbers, &row.partner, row.correlation);
        let shares = row.windows.iter().map(move |share| -> Line<'_> {
            let numbers = [f64::NAN, share.standard_error, f64::NAN];
            (row, &share.window, numbers, &share.partner, share.correlation)
        });
        std::iter::once(whole).chain(shares).collect::<Vec<_>>()
    });
    TableOf::new("sensor_errors", CAPTION, lines)
        .text("error", "Error", |(row, ..)| &row.error)
        .text("window", "Manoeuvre", |(_, window, ..)| window)
        .text("unit", "Unit", |(row, ..)| row.unit)
        .number("estimate", "Estimate", "", 5, |(_, _, numbers, ..)| numbers[0])
        .number("standard_error", "Standard error", "", 3, |(_, _, numbers, ..)| numbers[1])
        .number("corrected_standard_error", "Corrected", "", 3, |(_, _, numbers, ..)| numbers[2])
        .text("partner", "Partner", |(.., partner, _)| partner)
        .number("correlation", "Correlation", "", 2, |(.., correlation)| *correlation)
        .done()
}

/// What every measurement is left with.
pub fn output_table(found: &SensorErrorsRow) -> Table {
    TableOf::new("sensor_outputs", "Residuals of the measurements over the estimated sensor errors.", &found.outputs)
        .text("measurement", "Measurement", |row| row.measurement)
        .count("samples", "Samples", |row| row.samples)
        .number("rms", "Residual", "", 3, |row| row.rms)
        .maybe("normalised", "Over expected", "", 3, |row| Some(row.normalised).filter(|share| share.is_finite()))
        .number("r_squared", "R²", "", 5, |row| row.r_squared)
        .done()
}
