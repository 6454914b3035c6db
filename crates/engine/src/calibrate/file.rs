//! Calibrations in an instruments file.

use doublet_core::toml_error;
use std::path::Path;

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table};

use super::{CalibrationFit, Curve, SensorCalibration, SensorKind, check};
use crate::graph::Context;
use crate::keep;

/// The text of an instruments file that a session names, relative to `folder`, or of one that comes with the program.
pub fn read(folder: &Path, file: &str) -> Result<String, String> {
    Context::new(folder).text(file, "aircraft").map_err(String::from)
}

/// Every calibration that the text of an instruments file has.
pub fn calibrations(text: &str) -> Result<Vec<SensorCalibration>, String> {
    check(text)?;
    let file: toml::Table = toml::from_str(text).map_err(|error| toml_error::one_line(text, &error))?;
    let find_table = |table: &str| file.get(table).and_then(toml::Value::as_table);
    let mut all = Vec::new();
    let mut add = |kind, curve, range| all.push(SensorCalibration { kind, curve, range });
    if let Some(control) = find_table("control") {
        let radius = number(control.get("drum_radius_mm"));
        add(SensorKind::Drum, Curve::Polynomial(vec![0.0, radius.to_radians()]), None);
        for (name, kind, slope) in [
            ("aileron", SensorKind::Aileron, "slope_deg_per_deg"),
            ("elevator", SensorKind::Elevator, "slope_deg_per_cm"),
        ] {
            let Some(line) = control.get(name).and_then(toml::Value::as_table) else { continue };
            add(kind, Curve::Polynomial(vec![number(line.get("intercept_deg")), number(line.get(slope))]), None);
        }
        for pedal in entries(control.get("pedal")) {
            let range = <[f64; 2]>::try_from(numbers(pedal.get("range_m"))).ok();
            let curve = Curve::Polynomial(numbers(pedal.get("deflection_deg_per_m")));
            add(SensorKind::Pedal(word(pedal.get("sensor"))), curve, range);
        }
    }
    for pod in find_table("air_data").into_iter().flat_map(|air_data| entries(air_data.get("pod"))) {
        add(
            SensorKind::Pod(word(pod.get("flight"))),
            Curve::Exponential(numbers(pod.get("exponent"))),
            Some([0.0, 100.0]),
        );
    }
    for probe in entries(file.get("fuel_probe")) {
        let columns = numbers(probe.get("actual_lb")).into_iter().zip(numbers(probe.get("displayed_lb")));
        let curve = Curve::Table(columns.map(|(actual, shown)| [actual, shown]).collect());
        add(SensorKind::Probe(word(probe.get("tank"))), curve, None);
    }
    Ok(all)
}

fn number(value: Option<&toml::Value>) -> f64 {
    value
        .and_then(|value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64)))
        .unwrap_or(f64::NAN)
}

fn numbers(value: Option<&toml::Value>) -> Vec<f64> {
    value.and_then(toml::Value::as_array).into_iter().flatten().map(|value| number(Some(value))).collect()
}

fn word(value: Option<&toml::Value>) -> String {
    value.and_then(toml::Value::as_str).unwrap_or_default().to_owned()
}

fn entries(value: Option<&toml::Value>) -> impl Iterator<Item = &toml::Table> {
    value.and_then(toml::Value::as_array).into_iter().flatten().filter_map(toml::Value::as_table)
}

/// The text of an instruments file with a calibration as fitted, its readings in a comment above; comments and order stay.
pub fn with_calibration(text: &str, kind: &SensorKind, fit: &CalibrationFit) -> Result<String, String> {
    check(text)?;
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| error.to_string().replace('\n', " "))?;
    let unusable = || "the instruments file has no place for this calibration".to_owned();
    put(&mut document, kind, fit).ok_or_else(unusable)?;
    let text = document.to_string();
    check(&text)?;
    Ok(text)
}

/// Sets the numbers of a calibration; `None` where the file has no such table.
fn put(document: &mut DocumentMut, kind: &SensorKind, fit: &CalibrationFit) -> Option<()> {
    let coefficients = match &fit.curve {
        Curve::Polynomial(all) | Curve::Exponential(all) => all.as_slice(),
        Curve::Table(_) => &[],
    };
    let line = || <[f64; 2]>::try_from(coefficients).ok();
    let about = fit_comment(fit);
    match kind {
        SensorKind::Drum => {
            let (radius, _) = fit.drum_radius_mm(kind)?;
            set(document.get_mut("control")?.as_table_mut()?, "drum_radius_mm", toml_edit::value(radius), &about);
        }
        SensorKind::Aileron | SensorKind::Elevator => {
            let (name, key) = match kind {
                SensorKind::Aileron => ("aileron", "slope_deg_per_deg"),
                _ => ("elevator", "slope_deg_per_cm"),
            };
            let [intercept, slope] = line()?;
            let table = document.get_mut("control")?.get_mut(name)?.as_table_mut()?;
            set(table, key, toml_edit::value(slope), &about);
            set(table, "intercept_deg", toml_edit::value(intercept), "");
        }
        SensorKind::Pedal(sensor) => {
            let mut six = coefficients.to_vec();
            six.resize(6, 0.0);
            let table = entry(document.get_mut("control")?.as_table_mut()?, "pedal", "sensor", sensor)?;
            set(table, "deflection_deg_per_m", list(&six), &about);
            set(table, "range_m", list(&fit.range), "");
        }
        SensorKind::Pod(flight) => {
            let table = entry(document.get_mut("air_data")?.as_table_mut()?, "pod", "flight", flight)?;
            set(table, "exponent", list(coefficients), &about);
        }
        SensorKind::Probe(tank) => {
            let Curve::Table(points) = &fit.curve else { return None };
            let column = |axis: usize| list(&points.iter().map(|point| point[axis]).collect::<Vec<_>>());
            let table = entry(document.as_table_mut(), "fuel_probe", "tank", tank)?;
            set(table, "actual_lb", column(0), &about);
            set(table, "displayed_lb", column(1), "");
        }
    }
    Some(())
}

/// What a comment says of a fit: how good it is, and the readings.
fn fit_comment(fit: &CalibrationFit) -> String {
    let readings: Vec<String> = fit.points.iter().map(|[x, y]| format!("{x} {y}")).collect();
    format!(
        "# fitted to {} readings, R2 {:.5}, residuals {:.3} rms: {}\n",
        fit.points.len(),
        fit.r_squared,
        fit.deviation,
        readings.join("; ")
    )
}

fn list(values: &[f64]) -> Item {
    toml_edit::value(values.iter().copied().collect::<Array>())
}

/// The entry of a list whose `key` is `name`; made where there is none.
fn entry<'a>(table: &'a mut Table, of: &str, key: &str, name: &str) -> Option<&'a mut Table> {
    let entries = table.entry(of).or_insert(Item::ArrayOfTables(ArrayOfTables::new())).as_array_of_tables_mut()?;
    let found = entries.iter().position(|entry| entry.get(key).and_then(Item::as_str) == Some(name));
    let at = found.unwrap_or_else(|| {
        let mut made = Table::new();
        made.insert(key, toml_edit::value(name));
        entries.push(made);
        entries.len() - 1
    });
    entries.get_mut(at)
}

/// Sets a key, with a comment above it in the place of what stood there.
fn set(table: &mut Table, key: &str, value: Item, about: &str) {
    table.insert(key, value);
    if let Some(mut own) = table.key_mut(key).filter(|_| !about.is_empty()) {
        own.leaf_decor_mut().set_prefix(about);
    }
}

/// Writes the text of an instruments file to `path`.
pub fn save(text: &str, path: &Path) -> Result<(), String> {
    check(text)?;
    keep::replace(path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
}
