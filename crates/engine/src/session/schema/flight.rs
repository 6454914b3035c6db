//! Saved form of flights, their recordings and clocks.

use std::collections::BTreeMap;

use doublet_core::airframe::Loading;
use doublet_core::quantity::Role;
use serde::{Deserialize, Serialize};

use super::expression::{ExpressionTable, expression_from, expression_table};
use super::signals::{SignalsTable, signals_from, signals_table};
use super::{SessionError, unknown};
use crate::session::{ClockPairSetting, ClockSetting, Flight, InstrumentSetting, LevelFlight, MapRef, RecordingRef};

/// A flight.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlightTable {
    name: String,
    #[serde(default, rename = "recording")]
    recordings: Vec<RecordingTable>,
    #[serde(default, rename = "clock", skip_serializing_if = "Vec::is_empty")]
    clocks: Vec<ClockTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    instruments: Option<InstrumentTable>,
    #[serde(default, skip_serializing_if = "SignalsTable::is_empty")]
    signals: SignalsTable,
    #[serde(default, rename = "expression", skip_serializing_if = "Vec::is_empty")]
    expressions: Vec<ExpressionTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    loading: Option<Loading>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct InstrumentTable {
    file: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    control_sensors: Option<String>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    thesis_controls: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pod: Option<String>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pod_calibration: String,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    fuel: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    level_flight: Option<LevelFlightTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LevelFlightTable {
    mass_kg: f64,
    airspeed_m_s: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    altitude_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    density_kg_m3: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClockTable {
    source: String,
    #[serde(default)]
    offset_s: f64,
    #[serde(default)]
    drift: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    shift_s: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    fit: Vec<ClockPairTable>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands it so")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClockPairTable {
    reference: String,
    other: String,
    #[serde(default)]
    inverted: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordingTable {
    path: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
    channel_map: MapTable,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    only: Option<Vec<String>>,
}

/// A channel map by its path, or in full.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum MapTable {
    File(String),
    Own(toml::Table),
}

/// The flight a table states.
///
/// # Errors
/// [`SessionError::Name`] for a role or a choice that does not exist.
pub(crate) fn flight_from(table: FlightTable) -> Result<Flight, SessionError> {
    Ok(Flight {
        name: table.name,
        recordings: table.recordings.into_iter().map(recording_from).collect::<Result<_, _>>()?,
        clocks: table.clocks.into_iter().map(clock_from).collect(),
        instruments: table.instruments.map(|table| InstrumentSetting {
            file: table.file,
            control_sensors: table.control_sensors,
            thesis_controls: table.thesis_controls,
            pod: table.pod,
            pod_calibration: table.pod_calibration,
            level_flight: table.level_flight.map(|table| LevelFlight {
                mass_kg: table.mass_kg,
                airspeed_m_s: table.airspeed_m_s,
                altitude_m: table.altitude_m,
                density_kg_m3: table.density_kg_m3,
            }),
            fuel: table.fuel,
        }),
        signals: signals_from(table.signals)?,
        expressions: table.expressions.into_iter().map(expression_from).collect::<Result<_, _>>()?,
        loading: table.loading,
    })
}

/// The roles of these names.
///
/// # Errors
/// [`SessionError::Name`] for a role that does not exist.
pub(crate) fn roles_from(place: &str, names: &[String]) -> Result<Vec<Role>, SessionError> {
    let role = |name: &String| {
        let known = || Role::ALL.iter().map(|role| role.name()).collect::<Vec<_>>();
        Role::from_name(name).ok_or_else(|| unknown(place, "role", name, &known()))
    };
    names.iter().map(role).collect()
}

/// Names of roles.
pub(crate) fn role_names(roles: &[Role]) -> Vec<String> {
    roles.iter().map(|role| role.name().to_owned()).collect()
}

fn recording_from(table: RecordingTable) -> Result<RecordingRef, SessionError> {
    let only =
        table.only.as_ref().map(|names| roles_from(&format!("recording '{}'", table.path), names)).transpose()?;
    let channel_map = match table.channel_map {
        MapTable::File(path) => MapRef::File(path),
        MapTable::Own(map) => MapRef::Own(map.to_string().into()),
    };
    Ok(RecordingRef { only, path: table.path, sha256: table.sha256, channel_map })
}

/// The table of a flight.
pub(crate) fn flight_table(flight: &Flight) -> FlightTable {
    FlightTable {
        name: flight.name.clone(),
        recordings: flight
            .recordings
            .iter()
            .map(|entry| RecordingTable {
                path: entry.path.clone(),
                sha256: entry.sha256.clone(),
                channel_map: map_table(&entry.channel_map),
                only: entry.only.as_deref().map(role_names),
            })
            .collect(),
        clocks: flight.clocks.iter().map(clock_table).collect(),
        instruments: flight.instruments.clone().map(|setting| InstrumentTable {
            file: setting.file,
            control_sensors: setting.control_sensors,
            thesis_controls: setting.thesis_controls,
            pod: setting.pod,
            pod_calibration: setting.pod_calibration,
            fuel: setting.fuel,
            level_flight: setting.level_flight.map(|flight| LevelFlightTable {
                mass_kg: flight.mass_kg,
                airspeed_m_s: flight.airspeed_m_s,
                altitude_m: flight.altitude_m,
                density_kg_m3: flight.density_kg_m3,
            }),
        }),
        signals: signals_table(&flight.signals),
        expressions: flight.expressions.iter().map(expression_table).collect(),
        loading: flight.loading.clone(),
    }
}

/// A map the session holds was parsed before; what is no TOML is written as a path, so that its error names it.
fn map_table(map: &MapRef) -> MapTable {
    match map {
        MapRef::File(path) => MapTable::File(path.clone()),
        MapRef::Own(text) => text.parse().map_or_else(|_| MapTable::File(text.to_string()), MapTable::Own),
    }
}

fn clock_from(table: ClockTable) -> ClockSetting {
    let pair = |pair: ClockPairTable| ClockPairSetting {
        reference: pair.reference,
        other: pair.other,
        inverted: pair.inverted,
    };
    ClockSetting {
        source: table.source,
        offset_s: table.offset_s,
        drift: table.drift,
        shift_s: table.shift_s,
        fit: table.fit.into_iter().map(pair).collect(),
    }
}

fn clock_table(clock: &ClockSetting) -> ClockTable {
    let pair = |pair: &ClockPairSetting| ClockPairTable {
        reference: pair.reference.clone(),
        other: pair.other.clone(),
        inverted: pair.inverted,
    };
    ClockTable {
        source: clock.source.clone(),
        offset_s: clock.offset_s,
        drift: clock.drift,
        shift_s: clock.shift_s,
        fit: clock.fit.iter().map(pair).collect(),
    }
}
