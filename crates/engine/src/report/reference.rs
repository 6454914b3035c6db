//! Derivatives from elsewhere, to mark beside estimates: results of another session, a table, a Digital DATCOM listing.

use std::path::Path;

use doublet_core::load::datcom::{DatcomListing, PredictionOptions};
use serde_json::Value;

/// Derivatives from one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Name: that of the file.
    pub name: String,
    /// Derivative, value, and standard error where it is stated.
    pub values: Vec<(String, f64, Option<f64>)>,
}

impl Reference {
    /// Value and standard error of a derivative.
    pub fn get(&self, derivative: &str) -> Option<(f64, Option<f64>)> {
        self.values.iter().find(|(name, ..)| name == derivative).map(|(_, value, error)| (*value, *error))
    }
}

/// Reads `results.json` of another session, a table with the columns `derivative`, `estimate` and perhaps `standard_error`, or a
/// Digital DATCOM listing, whose derivatives are taken in body axes at level flight with rates as `q c/V`, `p b/2V`, `r b/2V`.
pub fn reference(path: &Path) -> Result<Reference, String> {
    let place = path.display();
    let bytes = doublet_core::load::read_bytes(path).map_err(|error| format!("{place}: {error}"))?;
    let text = String::from_utf8_lossy(&bytes);
    let found = if text.trim_start().starts_with('{') {
        read_results(&text)
    } else if text.lines().next().is_some_and(|line| line.to_lowercase().contains("derivative")) {
        read_table(&text)
    } else {
        read_listing(path)
    };
    let values = found.map_err(|error| format!("{place}: {error}"))?;
    if values.is_empty() {
        return Err(format!("{place}: it holds no derivatives"));
    }
    let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let folder = path.parent().and_then(Path::file_name).map(|folder| folder.to_string_lossy().into_owned());
    // Every folder of results holds files of the same names.
    let name = folder.filter(|_| matches!(name.as_str(), "results" | "derivatives")).unwrap_or(name);
    Ok(Reference { name, values })
}

type Values = Vec<(String, f64, Option<f64>)>;

fn read_results(text: &str) -> Result<Values, String> {
    let results: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if results["format"] != super::results::FORMAT {
        return Err("not a results file: give the results.json of a `doublet run`".to_owned());
    }
    let fits = results["pooled"].as_array().map(Vec::as_slice).unwrap_or_default();
    let rows = fits.iter().flat_map(|fit| fit["derivatives"].as_array().map(Vec::as_slice).unwrap_or_default());
    let value = |row: &Value| {
        let error = row.get("corrected_standard_error").or(row.get("standard_error")).and_then(Value::as_f64);
        Some((row["name"].as_str()?.to_owned(), row["estimate"].as_f64()?, error))
    };
    let values: Values = rows.filter_map(value).collect();
    if values.is_empty() {
        return Err("it has no pooled derivatives: mark manoeuvres for identification and run again".to_owned());
    }
    Ok(values)
}

fn read_table(text: &str) -> Result<Values, String> {
    let cells = |line: &str| line.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect::<Vec<_>>();
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let head = cells(lines.next().unwrap_or_default());
    let column = |names: &[&str]| head.iter().position(|cell| names.contains(&cell.to_lowercase().as_str()));
    let Some((name, value)) = column(&["derivative", "name"]).zip(column(&["estimate", "value", "mean"])) else {
        return Err("its first line has to name the columns derivative and estimate".to_owned());
    };
    let error = column(&["corrected_error", "corrected_standard_error", "standard_error"]);
    let mut values: Values = Vec::new();
    for line in lines {
        let cells = cells(line);
        let number = |at: usize| cells.get(at).and_then(|cell| cell.parse::<f64>().ok());
        let Some((name, value)) = cells.get(name).zip(number(value)) else { continue };
        // The pooled derivatives come before those of single windows.
        if !values.iter().any(|(other, ..)| other == name) {
            values.push((name.clone(), value, error.and_then(number)));
        }
    }
    Ok(values)
}

fn read_listing(path: &Path) -> Result<Values, String> {
    let listing = DatcomListing::read(path).map_err(|error| error.to_string())?;
    let alpha_rad = listing.level_flight_alpha_rad().ok_or("angle of attack in level flight unknown")?;
    let found = listing.derivatives(alpha_rad, &PredictionOptions::default()).map_err(|error| error.to_string())?;
    Ok(found.into_iter().map(|derivative| (derivative.name.to_owned(), derivative.value, None)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Result<Reference, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        reference(&path)
    }

    #[test]
    fn results_and_tables_give_value_and_error() {
        let json = r#"{"format": "doublet results", "version": 1, "pooled": [{"coefficient": "Cm", "derivatives": [
            {"name": "Cm_q", "estimate": -20.5, "standard_error": 0.1, "corrected_standard_error": 0.4}]}]}"#;
        assert_eq!(read("other.json", json).unwrap().get("Cm_q"), Some((-20.5, Some(0.4))));
        let table = "window,derivative,estimate,standard_error\npooled,Cm_q,-19,0.2\nw1,Cm_q,-3,\n";
        let found = read("book.csv", table).unwrap();
        assert_eq!((found.name.as_str(), found.get("Cm_q")), ("book", Some((-19.0, Some(0.2)))));
        assert_eq!(found.get("Cm_alpha"), None);
    }

    #[test]
    fn a_file_without_derivatives_says_so_in_one_line() {
        for (name, text) in
            [("a.json", "{\"format\": \"x\"}"), ("b.csv", "derivative,unit\nCm_q,1\n"), ("c.txt", "nothing"), ("d", "")]
        {
            let error = read(name, text).unwrap_err();
            assert!(error.contains(name) && error.lines().count() == 1, "{error}");
        }
    }
}
