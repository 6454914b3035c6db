//! The saved form of the errors of sensors.

use std::collections::BTreeMap;

use doublet_core::estimate::SensorError;
use doublet_core::quantity::InstrumentError;
use doublet_core::reconstruct::Measurement;
use serde::{Deserialize, Serialize};

use super::super::{ErrorValues, InstrumentAccuracy, Preparation, SensorErrorMethod, SensorErrors};
use super::{SessionError, is_default, unknown};

/// Errors of sensors: those known, which the samples are freed of, and those asked for.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SensorErrorTable {
    #[serde(skip_serializing_if = "is_default")]
    method: SensorErrorMethod,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    free: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    per_manoeuvre: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outputs: Vec<Measurement>,
    #[serde(skip_serializing_if = "is_default")]
    wind: bool,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    random_walk: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    known: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    accuracy: BTreeMap<String, f64>,
}

impl SensorErrorTable {
    pub(super) fn is_empty(&self) -> bool {
        let Self { free, per_manoeuvre, known, outputs, accuracy, .. } = self;
        free.is_empty() && per_manoeuvre.is_empty() && known.is_empty() && outputs.is_empty() && accuracy.is_empty()
    }
}

/// The saved form.
pub(super) fn sensor_error_table(errors: &SensorErrors, preparation: &Preparation) -> SensorErrorTable {
    let names = |errors: &[SensorError]| errors.iter().map(ToString::to_string).collect();
    let values = |values: &ErrorValues| values.0.iter().map(|(error, value)| (error.to_string(), *value)).collect();
    SensorErrorTable {
        method: errors.method,
        free: names(&errors.free),
        per_manoeuvre: names(&errors.per_window),
        outputs: errors.outputs.clone(),
        wind: errors.wind,
        random_walk: values(&errors.random_walk),
        known: values(&preparation.known_errors),
        accuracy: preparation.accuracy.0.iter().map(|(error, value)| (error.name().to_owned(), *value)).collect(),
    }
}

/// The errors asked for of a saved form; into `preparation` those known, and how well others are.
pub(super) fn sensor_errors_from(
    table: &SensorErrorTable,
    preparation: &mut Preparation,
) -> Result<SensorErrors, SessionError> {
    let list =
        |key: &str, names: &[String]| names.iter().map(|name| find_error(key, name)).collect::<Result<Vec<_>, _>>();
    let values = |key: &str, table: &BTreeMap<String, f64>| -> Result<ErrorValues, SessionError> {
        let one = |(name, value): (&String, &f64)| Ok((find_error(key, name)?, *value));
        Ok(ErrorValues(table.iter().map(one).collect::<Result<_, SessionError>>()?))
    };
    let errors = SensorErrors {
        method: table.method,
        free: list("free", &table.free)?,
        per_window: list("per_manoeuvre", &table.per_manoeuvre)?,
        random_walk: values("random_walk", &table.random_walk)?,
        outputs: table.outputs.clone(),
        wind: table.wind,
    };
    preparation.known_errors = values("known", &table.known)?;
    let accuracy = table.accuracy.iter().map(|(name, deviation)| Ok((find_instrument_error(name)?, *deviation)));
    preparation.accuracy = InstrumentAccuracy(accuracy.collect::<Result<_, SessionError>>()?);
    Ok(errors)
}

fn find_instrument_error(name: &str) -> Result<InstrumentError, SessionError> {
    InstrumentError::from_name(name).ok_or_else(|| {
        unknown("sensor_errors.accuracy", "error", name, &InstrumentError::ALL.map(InstrumentError::name))
    })
}

fn find_error(key: &str, name: &str) -> Result<SensorError, SessionError> {
    SensorError::from_name(name).ok_or_else(|| {
        let known: Vec<String> = SensorError::all().map(|error| error.to_string()).collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        unknown(&format!("sensor_errors.{key}"), "error", name, &known)
    })
}
