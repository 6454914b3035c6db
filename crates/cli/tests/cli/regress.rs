//! `doublet regress` on tables, and `doublet inspect --json`.

use std::path::Path;

use serde_json::Value;

use crate::common::at_root::{document, error_line};
use crate::shared;

/// A table of `y = 3 + 2 a - 0.5 a b` with residuals 1 -1 -1 1, as their textbook has them, in every four rows, and an empty row.
fn table(folder: &Path) -> String {
    let mut text = "time [s],a_deg,b,s,y\n".to_owned();
    for row in 0..400 {
        let (a, b) = (f64::from(row % 7), f64::from(row % 11) - 5.0);
        let residual = [1.0, -1.0, -1.0, 1.0][row as usize % 4];
        let y = 3.0 + 2.0 * a - 0.5 * a * b + 0.01 * residual;
        let y = if row == 100 { String::new() } else { y.to_string() };
        text += &format!("{},{a},{b},0.01,{y}\n", 0.01 * f64::from(row));
    }
    let path = folder.join("table.csv");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn table_is_fitted_by_columns_and_expressions_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = table(folder.path());
    let rows = folder.path().join("rows.csv");
    let arguments = ["regress", &path, "--y", "y", "--terms", "1, a, a*b", "--dt", "0.01", "--json"];
    let found = document(&[&arguments[..], &["--out", rows.to_str().unwrap()]].concat());
    assert_eq!((found["samples"].as_u64(), found["rows"].as_u64()), (Some(399), Some(400)));
    let names: Vec<&str> =
        found["derivatives"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["y_0", "y_a", "y_a*b"]);
    for (row, truth) in found["derivatives"].as_array().unwrap().iter().zip([3.0, 2.0, -0.5]) {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!((number("estimate") - truth).abs() < 3.0 * number("standard_error"), "{row}");
        assert!(number("standard_error") < 2e-3 && number("corrected_standard_error") > 0.0, "{row}");
    }
    let rows = std::fs::read_to_string(rows).unwrap();
    assert_eq!((rows.lines().count(), rows.lines().next()), (400, Some("time_s,measured,fitted,residual")));
    let stepwise =
        document(&["regress", &path, "--y", "y", "--terms", "1,a,b,a*b,s*b", "--method", "stepwise", "--json"]);
    let terms: Vec<&str> =
        stepwise["derivatives"].as_array().unwrap().iter().map(|row| row["term"].as_str().unwrap()).collect();
    assert_eq!(terms, ["1", "a", "a*b"]);
    let weighted = document(&["regress", &path, "--y", "y", "--terms", "1,a,a*b", "--deviations", "s", "--json"]);
    let estimate = |document: &Value| document["derivatives"][1]["estimate"].as_f64().unwrap();
    assert!((estimate(&weighted) - estimate(&found)).abs() < 1e-9, "equal weights are no weights");
}

#[test]
fn what_a_table_does_not_have_is_named_with_what_is_near() {
    let folder = tempfile::tempdir().unwrap();
    let path = table(folder.path());
    let refusal = |terms: &str| error_line(&["regress", &path, "--y", "y", "--terms", terms]);
    let missing = refusal("1,alpha");
    assert!(missing.contains("no column is called 'alpha'") && missing.contains("a_deg"), "{missing}");
    assert!(refusal("1,a,a").contains("appears twice"));
    assert!(refusal("1,,a").contains("term 2 is empty"));
    assert!(refusal("1,a*(b").contains("term 'a*(b'"));
    assert!(refusal("1,a,2*a").contains("depends on"));
}

#[test]
fn attas_table_gives_every_printed_digit() {
    let Some(path) = shared::shared("data/attas/regression_table.csv") else { return };
    let path = path.to_str().unwrap();
    // R. V. Jategaonkar, supplement: estimates as printed there.
    for (y, terms, printed) in [
        ("CL", "1,alpha_rad", &["0.234957", "5.22568"][..]),
        ("Cm", "1, alpha, qn, de", &["0.0803194", "-0.87762", "-5.81993", "-0.98406"]),
        ("Cn", "1,beta_rad,pn,rn,dr_rad", &["0.0028078", "0.254494", "-0.0444249", "-0.134247", "-0.143862"]),
    ] {
        let found = document(&["regress", path, "--y", y, "--terms", terms, "--json"]);
        for (row, printed) in found["derivatives"].as_array().unwrap().iter().zip(printed) {
            let (estimate, expected): (f64, f64) = (row["estimate"].as_f64().unwrap(), printed.parse().unwrap());
            assert_eq!(format!("{estimate:.5e}"), format!("{expected:.5e}"), "{y} {row}");
        }
    }
    let first = document(&["regress", path, "--y", "CL", "--terms", "1,alpha", "--json"]);
    assert_eq!(first["derivatives"][1]["name"], "CL_alpha");
}

#[test]
fn inspection_as_a_document_has_channels_and_what_is_to_be_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let rows: String = (0..500)
        .map(|k| format!("{},{},{}\n", 1000 + 20 * k, 0.01 * f64::from(k % 50), f64::from(k % 9) - 4.0))
        .collect();
    std::fs::write(&path, format!("time,theta,q_dps\n{rows}")).unwrap();
    let found = document(&["inspect", path.to_str().unwrap(), "--json"]);
    let source = &found["sources"][0];
    assert_eq!((source["name"].as_str(), source["samples"].as_u64()), (Some("log"), Some(500)));
    assert!((source["rate_hz"].as_f64().unwrap() - 50.0).abs() < 1e-9 && source["start_s"] == 1.0, "{source}");
    let q = &source["channels"][2];
    assert_eq!((q["unit"].as_str(), q["role"].as_str()), (Some("deg/s"), Some("q")));
    let numbers = ["minimum", "maximum", "first", "last"].map(|key| q[key].as_f64().unwrap());
    assert_eq!(numbers, [-4.0, 4.0, -4.0, 0.0]);
    let asked: Vec<&str> = found["questions"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    assert!(asked.iter().any(|line| line.contains("read in milliseconds")), "{asked:?}");
    assert!(asked.iter().any(|line| line.contains("'theta', guessed as theta, states no unit")), "{asked:?}");
}
