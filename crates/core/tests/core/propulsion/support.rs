//! Shipped maps, published points and units of the tests.

use std::path::PathBuf;

use doublet_core::load::aircraft;
use doublet_core::load::propulsion_maps::parse_propulsion_section;
use doublet_core::load::read_text;
use doublet_core::propulsion::{DensityRule, EngineModel, EnginePoint, Powerplant};

/// Horsepower, W.
pub const HP: f64 = 745.699_871_582_270_2;
/// Inch of mercury, Pa.
pub const IN_HG: f64 = 3386.389;
/// Revolution per minute, rad/s.
pub const RPM: f64 = std::f64::consts::TAU / 60.0;

/// Folder of the shipped charts and maps.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/propulsion")
}

/// Both engines of the shipped C337F.
pub fn c337f() -> Powerplant {
    let path = folder().join("../aircraft/c337f.toml");
    let stations = aircraft::read(&path).unwrap().engines;
    let section = parse_propulsion_section(&read_text(&path).unwrap(), &path).unwrap();
    section.powerplant(&stations, &folder(), read_text).unwrap()
}

/// Chart and propeller map of the front engine.
pub fn model() -> EngineModel {
    c337f().engines.swap_remove(0).model.unwrap()
}

/// A point in the units of the published tables.
pub fn point(rpm: f64, in_hg: f64, sea_level_k: f64, altitude_m: f64, airspeed_m_s: f64) -> EnginePoint {
    EnginePoint {
        speed_rad_s: rpm * RPM,
        manifold_pressure_pa: in_hg * IN_HG,
        sea_level_temperature_k: sea_level_k,
        pressure_altitude_m: altitude_m,
        airspeed_m_s,
    }
}

/// The density of the published results.
pub const THESIS: DensityRule = DensityRule::ThesisSeaLevelTemperature;

/// A reference file of the shared folder as TOML, or `None` where it is absent.
pub fn reference(name: &str) -> Option<toml::Table> {
    let path = crate::shared::shared(&format!("reference/{name}"))?;
    Some(std::fs::read_to_string(path).unwrap().parse().unwrap())
}

/// The numbers of a TOML array.
pub fn numbers(value: &toml::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// A TOML number.
pub fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).unwrap()
}
