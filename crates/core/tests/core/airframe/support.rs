//! Aircraft files of the product and reference tables beside the project.

use std::path::{Path, PathBuf};

use doublet_core::airframe::Aircraft;
use doublet_core::load::aircraft;

/// Path of a shipped aircraft file.
pub fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/aircraft").join(name)
}

/// A shipped aircraft.
pub fn shipped(name: &str) -> Aircraft {
    aircraft::read(&asset(name)).unwrap()
}

/// A reference table file, or `None` with a printed reason where it is absent.
pub fn reference(name: &str) -> Option<Table> {
    let path = crate::shared::shared(&format!("reference/{name}"))?;
    Some(Table(toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()))
}

/// Reference values by dotted path.
pub struct Table(toml::Value);

impl Table {
    fn value(&self, path: &str) -> &toml::Value {
        path.split('.')
            .fold(&self.0, |value, key| value.get(key).unwrap_or_else(|| panic!("no {path} in the reference")))
    }

    /// The number at `path`.
    pub fn number(&self, path: &str) -> f64 {
        number(self.value(path))
    }

    /// The list of numbers at `path`.
    pub fn list(&self, path: &str) -> Vec<f64> {
        self.value(path).as_array().unwrap().iter().map(number).collect()
    }

    /// The point at `path`.
    pub fn point(&self, path: &str) -> [f64; 3] {
        self.list(path).try_into().unwrap()
    }

    /// The rows of numbers at `path`.
    pub fn rows(&self, path: &str) -> Vec<Vec<f64>> {
        let rows = self.value(path).as_array().unwrap();
        rows.iter().map(|row| row.as_array().unwrap().iter().map(number).collect()).collect()
    }

    /// Names and numbers of the rows `{ name, v }` at `path`.
    pub fn named_rows(&self, path: &str) -> Vec<(String, Vec<f64>)> {
        let row = |row: &toml::Value| {
            let values = row["v"].as_array().unwrap().iter().map(number).collect();
            (row["name"].as_str().unwrap().to_owned(), values)
        };
        self.value(path).as_array().unwrap().iter().map(row).collect()
    }
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64)).unwrap()
}

/// Asserts that `found` lies within `tolerance` of `expected`.
#[track_caller]
pub fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} is not {expected} within {tolerance}");
}
