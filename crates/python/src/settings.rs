//! Settings of the filter and of the preparation as Python gives them: tables of a session file, read as the file is.

use doublet_core::reconstruct::{AirState, Input, Measurement, State};
use doublet_engine::session::{self, FORMAT, Place, Preparation, Session, VERSION};
use doublet_engine::verdict::Finding;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::refuse;

/// Tables of a session that paths and coefficients have settings of.
const TABLES: [&str; 3] = ["filter.", "preparation.", "sensor_errors."];

/// A session of tables such as `{"filter": {"method": "ekf"}}`, everything else as it is by default.
pub fn session_with(tables: &str) -> PyResult<Session> {
    let mut all: toml::Table = serde_json::from_str(tables).map_err(refuse)?;
    all.insert("format".to_owned(), FORMAT.into());
    all.insert("version".to_owned(), i64::from(VERSION).into());
    let session = session::from_table(all).map_err(refuse)?;
    let is_setting = |finding: &&Finding| {
        TABLES.iter().any(|table| matches!(&finding.place, Place::Named(key) if key.starts_with(table)))
    };
    let lines: Vec<String> = session::check(&session).iter().filter(is_setting).map(ToString::to_string).collect();
    if lines.is_empty() { Ok(session) } else { Err(refuse(lines.join("\n"))) }
}

/// The preparation of a table of a session file.
pub fn preparation_with(table: &str) -> PyResult<Preparation> {
    Ok(session_with(&format!("{{\"preparation\": {table}}}"))?.preparation)
}

/// Names of the inputs, measurements, states and errors of the air data that settings of the filter are by.
#[pyfunction]
pub fn filter_names(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("input", Input::ALL.map(Input::name))?;
    all.set_item("measurement", Measurement::ALL.map(Measurement::name))?;
    all.set_item("state", State::ALL.map(State::name))?;
    all.set_item("error of the air data", AirState::ALL.map(AirState::name))?;
    Ok(all)
}

/// The JSON Schema of a session file.
#[pyfunction]
pub fn session_schema() -> PyResult<String> {
    Ok(session::json_schema().map_err(refuse)?.to_string())
}
