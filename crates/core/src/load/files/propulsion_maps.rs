//! Engine charts, propeller maps and the propulsion section of an aircraft file.
//!
//! Charts and maps are TOML in the units their manufacturers print (rpm, inHg, ft, hp); everything behind this file is
//! SI. Each file starts with its `format` and `version`; unknown keys are refused with their line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::airframe::EngineStation;
use crate::propulsion::{
    Engine, EngineChart, EngineChartData, EngineModel, Powerplant, PropellerMap, PropellerMapData, PropellerMapTable,
    Rotation, TableError,
};
use crate::toml_error;

const CHART_FORMAT: &str = "doublet engine chart";
const MAP_FORMAT: &str = "doublet propeller map";
/// Version of both formats this program writes and reads.
const VERSION: i64 = 1;

/// Angular speed of one revolution per minute, rad/s.
const RAD_S_PER_RPM: f64 = std::f64::consts::TAU / 60.0;
/// Pressure of one inch of mercury at 0 degC, Pa (NIST SP 811).
const PA_PER_IN_HG: f64 = 3386.389;
/// Length of one foot, m.
const M_PER_FT: f64 = 0.3048;
/// Power of one horsepower of 550 ft lbf/s, W (NIST SP 811).
const W_PER_HP: f64 = 745.699_871_582_270_2;
/// Height of one flight level, m.
const M_PER_FLIGHT_LEVEL: f64 = 30.48;

/// A chart, map or propulsion section that cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum MapError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// The text is not the TOML this format asks for.
    #[error("{}, line {line}: {message}", path.display())]
    Syntax { path: PathBuf, line: usize, message: String },
    #[error("{}: format is '{found}', expected '{expected}'", path.display())]
    Format { path: PathBuf, found: String, expected: &'static str },
    #[error("{}: version {found} of the format, this program reads version {VERSION}", path.display())]
    Version { path: PathBuf, found: i64 },
    /// The tables do not fit together.
    #[error("{}: {source}", path.display())]
    Table { path: PathBuf, source: TableError },
    #[error("propulsion.engine '{name}': rotor_inertia_kg_m2 is {value}, allowed is a finite number, 0 or more")]
    RotorInertia { name: String, value: f64 },
    #[error("propulsion.engine '{name}' {reason}: the aircraft has the engines {}", known.join(", "))]
    Name { name: String, reason: &'static str, known: Vec<String> },
    #[error(
        "propulsion.engine '{name}': '{file}' is not a file name: put charts and maps into the folder of the aircraft file"
    )]
    Place { name: String, file: String },
    #[error("propulsion.engine '{name}' has no {missing}: give both chart and propeller, or neither")]
    Incomplete { name: String, missing: &'static str },
}

/// First keys of every file, read before the rest.
#[derive(Deserialize)]
struct Header {
    format: String,
    version: i64,
}

/// An engine chart as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChartFile {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    engine: String,
    origin: String,
    speed_rpm: Vec<f64>,
    sea_level: SeaLevelChart,
    full_throttle: FullThrottleChart,
}

/// Sea-level chart: one row of powers per speed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "keys carry unit symbols")]
struct SeaLevelChart {
    manifold_pressure_inHg: Vec<f64>,
    power_hp: Vec<Vec<f64>>,
}

/// Full-throttle lines: one row per speed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "keys carry unit symbols")]
struct FullThrottleChart {
    altitude_ft: Vec<f64>,
    manifold_pressure_inHg: Vec<Vec<f64>>,
    power_hp: Vec<Vec<f64>>,
}

/// A propeller map as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MapFile {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    propeller: String,
    origin: String,
    diameter_m: f64,
    effective_area_m2: f64,
    flight_level: Vec<f64>,
    speed_rpm: Vec<f64>,
    advance_ratio: Vec<f64>,
    power_coefficient: Vec<f64>,
    map: Vec<MapTable>,
}

/// One map: rows are power coefficients, columns advance ratios.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MapTable {
    flight_level: f64,
    speed_rpm: f64,
    efficiency: Vec<Vec<f64>>,
    thrust_coefficient: Vec<Vec<f64>>,
}

/// Section `[propulsion]` of an aircraft file: what drives the engines whose stations the file gives.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropulsionSection {
    /// Entries by name of the engine, in any order; an engine without one has no chart and no rotor.
    #[serde(default)]
    pub engine: Vec<EngineSection>,
}

/// One `[[propulsion.engine]]` of an aircraft file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EngineSection {
    /// Name of the engine station this belongs to.
    pub name: String,
    /// Engine chart, a file name in the propulsion folder; absent for an engine whose thrust is recorded.
    pub chart: Option<String>,
    /// Propeller map, a file name in the propulsion folder.
    pub propeller: Option<String>,
    /// Sense of rotation seen from behind, looking forward.
    #[serde(default)]
    pub rotation: Rotation,
    /// Moment of inertia of everything turning with the crankshaft about its axis, kg m².
    #[serde(default)]
    pub rotor_inertia_kg_m2: f64,
}

/// The `[propulsion]` section of the text of an aircraft file, empty where it has none; `path` serves messages only.
///
/// # Errors
/// [`MapError`] naming `path` and, for syntax, the line.
pub fn parse_propulsion_section(text: &str, path: &Path) -> Result<PropulsionSection, MapError> {
    #[derive(Deserialize)]
    struct AircraftFile {
        #[serde(default)]
        propulsion: PropulsionSection,
    }
    let file: AircraftFile = toml::from_str(text).map_err(|error| syntax(text, path, &error))?;
    Ok(file.propulsion)
}

/// An engine chart from its text; `path` serves messages only.
///
/// # Errors
/// [`MapError`] naming `path` and, for syntax, the line.
pub fn parse_engine_chart(text: &str, path: &Path) -> Result<EngineChart, MapError> {
    let file: ChartFile = parse(text, path, CHART_FORMAT)?;
    let data = EngineChartData {
        name: file.engine,
        origin: file.origin,
        speed_rad_s: scaled(&file.speed_rpm, RAD_S_PER_RPM),
        manifold_pressure_pa: scaled(&file.sea_level.manifold_pressure_inHg, PA_PER_IN_HG),
        sea_level_power_w: scaled_rows(&file.sea_level.power_hp, W_PER_HP),
        altitude_m: scaled(&file.full_throttle.altitude_ft, M_PER_FT),
        full_throttle_pressure_pa: scaled_rows(&file.full_throttle.manifold_pressure_inHg, PA_PER_IN_HG),
        full_throttle_power_w: scaled_rows(&file.full_throttle.power_hp, W_PER_HP),
    };
    EngineChart::new(data).map_err(|source| MapError::Table { path: path.to_owned(), source })
}

/// A propeller map from its text; `path` serves messages only.
///
/// # Errors
/// [`MapError`] naming `path` and, for syntax, the line.
pub fn parse_propeller_map(text: &str, path: &Path) -> Result<PropellerMap, MapError> {
    let file: MapFile = parse(text, path, MAP_FORMAT)?;
    let data = PropellerMapData {
        name: file.propeller,
        origin: file.origin,
        diameter_m: file.diameter_m,
        effective_area_m2: file.effective_area_m2,
        flight_level_m: scaled(&file.flight_level, M_PER_FLIGHT_LEVEL),
        speed_rad_s: scaled(&file.speed_rpm, RAD_S_PER_RPM),
        advance_ratio: file.advance_ratio,
        power_coefficient: file.power_coefficient,
        tables: file.map.into_iter().map(read_table).collect(),
    };
    PropellerMap::new(data).map_err(|source| MapError::Table { path: path.to_owned(), source })
}

fn read_table(map: MapTable) -> PropellerMapTable {
    PropellerMapTable {
        flight_level_m: map.flight_level * M_PER_FLIGHT_LEVEL,
        speed_rad_s: map.speed_rpm * RAD_S_PER_RPM,
        efficiency: map.efficiency,
        thrust_coefficient: map.thrust_coefficient,
    }
}

impl PropulsionSection {
    /// The powerplant of an aircraft with these engine stations, one engine per station in their order; charts and
    /// maps lie in `folder` and are read by `read`, each file once.
    ///
    /// # Errors
    /// [`MapError`] for an entry without a station, an inertia outside its range, an engine with only one of chart and
    /// propeller, or a bad file.
    pub fn powerplant(
        &self,
        stations: &[EngineStation],
        folder: &Path,
        read: impl Fn(&Path) -> std::io::Result<String>,
    ) -> Result<Powerplant, MapError> {
        self.check(stations)?;
        let text = |path: &Path| read(path).map_err(|source| MapError::Read { path: path.to_owned(), source });
        let mut charts: BTreeMap<&str, Arc<EngineChart>> = BTreeMap::new();
        let mut propellers: BTreeMap<&str, Arc<PropellerMap>> = BTreeMap::new();
        let mut engines = Vec::with_capacity(stations.len());
        for station in stations {
            let mut engine = Engine {
                station: station.clone(),
                rotation: Rotation::Clockwise,
                rotor_inertia_kg_m2: 0.0,
                model: None,
            };
            if let Some(entry) = self.engine.iter().find(|entry| entry.name == station.name) {
                engine.rotor_inertia_kg_m2 = entry.rotor_inertia_kg_m2;
                engine.rotation = entry.rotation;
                if let (Some(chart), Some(propeller)) = (&entry.chart, &entry.propeller) {
                    let (chart_file, propeller_file) = (folder.join(chart), folder.join(propeller));
                    let read_chart = || parse_engine_chart(&text(&chart_file)?, &chart_file);
                    let read_propeller = || parse_propeller_map(&text(&propeller_file)?, &propeller_file);
                    engine.model = Some(EngineModel {
                        chart: once(&mut charts, chart, read_chart)?,
                        propeller: once(&mut propellers, propeller, read_propeller)?,
                    });
                }
            }
            engines.push(engine);
        }
        Ok(Powerplant { engines })
    }

    /// Checks names and numbers of the entries.
    fn check(&self, stations: &[EngineStation]) -> Result<(), MapError> {
        for (index, entry) in self.engine.iter().enumerate() {
            let name = || entry.name.clone();
            let refuse = |reason| {
                let known = stations.iter().map(|station| station.name.clone()).collect();
                Err(MapError::Name { name: name(), reason, known })
            };
            let files = [&entry.chart, &entry.propeller].into_iter().flatten();
            if let Some(file) = files.into_iter().find(|file| Path::new(file).file_name() != Some(file.as_ref())) {
                return Err(MapError::Place { name: name(), file: file.clone() });
            }
            if !stations.iter().any(|station| station.name == entry.name) {
                return refuse("has no station");
            }
            if self.engine[..index].iter().any(|earlier| earlier.name == entry.name) {
                return refuse("is given twice");
            }
            let value = entry.rotor_inertia_kg_m2;
            if !(value.is_finite() && value >= 0.0) {
                return Err(MapError::RotorInertia { name: name(), value });
            }
            match (&entry.chart, &entry.propeller) {
                (Some(_), None) => return Err(MapError::Incomplete { name: name(), missing: "propeller" }),
                (None, Some(_)) => return Err(MapError::Incomplete { name: name(), missing: "chart" }),
                _ => {}
            }
        }
        Ok(())
    }
}

/// The value of `key`, made by `read` the first time.
fn once<'a, T>(
    known: &mut BTreeMap<&'a str, Arc<T>>,
    key: &'a str,
    read: impl FnOnce() -> Result<T, MapError>,
) -> Result<Arc<T>, MapError> {
    if let Some(value) = known.get(key) {
        return Ok(Arc::clone(value));
    }
    let value = Arc::new(read()?);
    known.insert(key, Arc::clone(&value));
    Ok(value)
}

/// Checks format and version, then reads the rest.
fn parse<T: DeserializeOwned>(text: &str, path: &Path, expected: &'static str) -> Result<T, MapError> {
    let refuse = |error| syntax(text, path, &error);
    let header: Header = toml::from_str(text).map_err(refuse)?;
    if header.format != expected {
        return Err(MapError::Format { path: path.to_owned(), found: header.format, expected });
    }
    if header.version != VERSION {
        return Err(MapError::Version { path: path.to_owned(), found: header.version });
    }
    toml::from_str(text).map_err(refuse)
}

/// A TOML error in one line.
fn syntax(text: &str, path: &Path, error: &toml::de::Error) -> MapError {
    MapError::Syntax {
        path: path.to_owned(),
        line: toml_error::line(text, error).unwrap_or(1),
        message: toml_error::message(error),
    }
}

/// `values` times `factor`.
fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| value * factor).collect()
}

/// `rows` times `factor`.
fn scaled_rows(rows: &[Vec<f64>], factor: f64) -> Vec<Vec<f64>> {
    rows.iter().map(|row| scaled(row, factor)).collect()
}
