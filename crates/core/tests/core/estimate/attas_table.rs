//! The regression table of the ATTAS recordings against the derivatives published for it.
//!
//! Source: R. V. Jategaonkar, "Flight Vehicle System Identification", 2nd edition (AIAA, doi 10.2514/4.102790), supplement;
//! numbers as printed there.

use doublet_core::estimate::{Fit, least_squares};
use nalgebra::DMatrix;

use crate::shared::shared;

/// A column of the table by its heading.
fn column(header: &[String], rows: &[Vec<f64>], name: &str) -> Vec<f64> {
    let index = header.iter().position(|other| other == name).unwrap();
    rows.iter().map(|row| row[index]).collect()
}

/// Fit of `output` by a constant and the columns `inputs`.
fn fit(header: &[String], rows: &[Vec<f64>], output: &str, inputs: &[&str]) -> Fit {
    let mut x = DMatrix::from_element(rows.len(), inputs.len() + 1, 1.0);
    let mut names = vec!["1".to_owned()];
    for (index, input) in inputs.iter().enumerate() {
        x.column_mut(index + 1).copy_from_slice(&column(header, rows, input));
        names.push((*input).to_owned());
    }
    least_squares(&names, &x, &column(header, rows, output)).unwrap()
}

/// Asserts that `found`, printed with as many digits as `printed`, is `printed`.
fn assert_prints(what: &str, found: f64, printed: &str) {
    let expected: f64 = printed.parse().unwrap();
    let mantissa = printed.split('e').next().unwrap().trim_start_matches('-').trim_start_matches(['0', '.']);
    let digits = mantissa.chars().filter(char::is_ascii_digit).count();
    assert_eq!(
        format!("{found:.*e}", digits - 1),
        format!("{expected:.*e}", digits - 1),
        "{what}: found {found}, published {printed}"
    );
}

#[test]
fn least_squares_matches_published_attas_table_to_every_printed_digit() {
    let Some(path) = shared("data/attas/regression_table.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 2128);

    type Published = (&'static str, &'static [&'static str], &'static [&'static str], &'static str);
    let published: [Published; 6] = [
        ("CL", &["alpha_rad"], &["0.234957", "5.22568"], "0.994499"),
        ("CD", &["alpha_rad"], &["0.0398479", "0.260400"], "0.737079"),
        ("Cm", &["alpha_rad", "qn", "de_rad"], &["0.0803194", "-0.877620", "-5.81993", "-0.984060"], "0.719461"),
        ("CY", &["beta_rad"], &["-0.00491145", "-1.00403"], "0.973641"),
        (
            "Cl",
            &["beta_rad", "pn", "rn", "da_rad"],
            &["1.83918e-4", "-0.102680", "-0.759763", "0.237672", "-0.192475"],
            "0.986842",
        ),
        (
            "Cn",
            &["beta_rad", "pn", "rn", "dr_rad"],
            &["0.00280780", "0.254494", "-0.0444249", "-0.134247", "-0.143862"],
            "0.968499",
        ),
    ];
    for (output, inputs, estimates, r_squared) in published {
        let fit = fit(&header, &rows, output, inputs);
        for ((name, found), printed) in fit.names.iter().zip(&fit.estimates).zip(estimates) {
            assert_prints(&format!("{output} {name}"), *found, printed);
        }
        assert_prints(&format!("R2 of {output}"), fit.quality.r_squared, r_squared);
    }
    let pitch = fit(&header, &rows, "Cm", &["alpha_rad", "qn", "de_rad"]);
    for (found, printed) in pitch.standard_errors.iter().zip(["1.0714e-3", "1.2869e-2", "4.0910e-1", "2.3415e-2"]) {
        assert_prints("standard error of Cm", *found, printed);
    }
}
