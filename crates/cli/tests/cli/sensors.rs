//! `doublet compatibility` and `doublet equations` as a user runs them.

use std::path::Path;

use doublet_core::estimate::SensorError;
use doublet_engine::session;
use serde_json::Value;

use crate::common::at_root::{document, doublet, printed};
use crate::common::root;

/// What a command that fails says.
fn refused(arguments: &[&str]) -> String {
    let output = doublet(arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn errors_of_the_gyros_of_the_shipped_flight_are_found_taken_and_gone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let opened = session::open(&root().join("sessions/demo.toml")).unwrap();
    let mut kept = session::rebased(&opened.session, &opened.folder, folder.path());
    // Six manoeuvres at one test point are enough.
    let names: Vec<String> = kept.windows.iter().take(6).map(|window| window.name.clone()).collect();
    kept.windows.truncate(6);
    session::save(&kept, &path).unwrap();
    let path = path.to_str().unwrap();
    let command =
        ["compatibility", path, "--free", "bias_p,bias_q,bias_r", "--wind", "--method", "filter-error", "--json"];
    let found = document(&command);
    let truth = doublet_core::simulate::Truth::biases();
    let value = |found: &Value, name: &str| -> [f64; 2] {
        let row = found["errors"].as_array().unwrap().iter().find(|row| row["error"] == name).unwrap();
        assert_eq!(row["windows"].as_array().unwrap().len(), names.len());
        ["estimate", "standard_error"].map(|key| row[key].as_f64().unwrap())
    };
    for name in ["bias_p", "bias_q", "bias_r"] {
        let (_, bias, _) = truth.iter().find(|(other, ..)| *other == name).unwrap();
        let [estimate, error] = value(&found, name);
        assert!((estimate - bias).abs() < 3.0 * error.max(2e-5), "{name}: {estimate} +- {error}, truth {bias}");
    }
    printed(&[&command[..], &["--take"]].concat());
    let taken = session::open(Path::new(path)).unwrap().session;
    let known = taken.preparation.known_errors.0.get(&SensorError::from_name("bias_q").unwrap()).copied().unwrap();
    assert_eq!(known, value(&found, "bias_q")[0]);
    // What is known cannot be asked for again; the same samples without it have none left.
    let again = refused(&command);
    assert!(again.contains("listed as known and as free"), "{again}");
    let command = ["compatibility", path, "--free", "scale_q", "--wind", "--method", "filter-error", "--json"];
    let left = document(&command);
    let [estimate, error] = value(&left, "scale_q");
    assert!(estimate.abs() < 4.0 * error.max(1e-3), "{estimate} +- {error}");
}

#[test]
fn compatibility_says_what_it_needs() {
    let demo = "sessions/demo.toml";
    assert!(refused(&["compatibility", demo]).contains("name some by --free"));
    let unknown = doublet(&["compatibility", demo, "--free", "bias_alfa"]);
    let text = String::from_utf8(unknown.stderr).unwrap();
    assert!(text.contains("error 'bias_alfa' not found") && text.contains("bias_alpha"), "{text}");
}

/// An unstable short period, x' = A x + B u, with the elevator a table of its own makes; in degrees, as a user has it.
fn table(folder: &Path) -> String {
    let (z_a, m_a, m_q, m_d) = (-0.9_f64, 2.0, -1.1, -6.0);
    let mut text = String::from("time_s,ALPHA,Q,DE\n");
    let (mut alpha, mut q) = (0.0_f64, 0.0_f64);
    let step = 0.01;
    for k in 0..900 {
        let t = step * f64::from(k);
        let stick = 0.02 * (2.0 * t).sin() * (0.5 * t).cos();
        let elevator = 0.8 * alpha + 0.5 * q + stick;
        // Noise that any reader makes alike: no two rows have the same.
        let noise = |scale: f64| scale * (f64::from(k * k % 997) / 997.0 - 0.5);
        let degrees = |value: f64| value.to_degrees();
        text += &format!("{t},{},{},{}\n", degrees(alpha + noise(4e-4)), degrees(q + noise(-8e-4)), degrees(elevator));
        // The elevator is linear between rows: rows are so close that Euler's scheme over ten parts of one is exact enough.
        let next =
            |alpha: f64, q: f64| 0.8 * alpha + 0.5 * q + 0.02 * (2.0 * (t + step)).sin() * (0.5 * (t + step)).cos();
        let (start, mut a, mut r) = (elevator, alpha, q);
        for part in 0..50 {
            let d = start + (next(a, r) - start) * f64::from(part) / 50.0;
            (a, r) = (a + step / 50.0 * (z_a * a + r), r + step / 50.0 * (m_a * a + m_q * r + m_d * d));
        }
        (alpha, q) = (a, r);
    }
    let path = folder.join("run.csv");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn equations_of_an_unstable_aircraft_are_fitted_to_a_table_of_degrees() {
    let folder = tempfile::tempdir().unwrap();
    let path = table(folder.path());
    let columns = ["alpha=ALPHA*pi/180", "q=Q*pi/180", "delta_e=DE*pi/180"];
    let mut command = vec!["equations", &path, "--equations", "short-period", "--piece", "3", "--json"];
    columns.iter().for_each(|column| command.extend(["--column", column]));
    let found = document(&command);
    for (name, truth) in [("Z_alpha", -0.9), ("M_alpha", 2.0), ("M_q", -1.1), ("M_delta_e", -6.0)] {
        let rows = found["output_error"]["parameters"].as_array().unwrap();
        let at = rows.iter().position(|row| row["name"] == name).unwrap();
        let [estimate, error] = ["estimate", "corrected_standard_error"].map(|key| rows[at][key].as_f64().unwrap());
        let covariance = &found["output_error"]["covariance"];
        let root = covariance[at][at].as_f64().unwrap().sqrt();
        assert!((root / error - 1.0).abs() < 1e-12, "{name}: {root} {error}");
        assert_eq!(covariance[at][0], covariance[0][at], "{name}");
        // The table integrates its elevator a little otherwise than straight lines between rows do.
        assert!((estimate - truth).abs() < 3.0 * error + 0.02 * truth.abs(), "{name}: {estimate} +- {error}");
        assert!(error < 0.2 * truth.abs(), "{name}: {error}");
    }
    assert_eq!(found["output_error"]["initial"].as_array().unwrap().len(), 6);
    let error = refused(&["equations", &path, "--equations", "short-period"]);
    assert!(error.contains("no column is called 'delta_e'"), "{error}");
    let error = refused(&["equations", &path, "--equations", "none-such"]);
    assert!(error.contains("name a file, or one of") && error.contains("short_period"), "{error}");
}

/// A recorder that writes some columns at every tenth row leaves the others blank: they are taken on straight lines in between.
#[test]
fn equations_are_fitted_to_columns_of_different_rates() {
    let folder = tempfile::tempdir().unwrap();
    // alpha' = -alpha + delta_e of a slow sine, alpha known in closed form once the start has died away; time in milliseconds.
    let mut text = "time_ms,alpha,delta_e\n".to_owned();
    for k in 0..6000 {
        let t = 0.01 * f64::from(k);
        let alpha = if k % 5 == 0 { format!("{}", 0.5 * (t.sin() - t.cos())) } else { String::new() };
        text += &format!("{},{alpha},{}\n", 10 * k, t.sin());
    }
    let path = folder.path().join("rates.csv");
    std::fs::write(&path, text).unwrap();
    let equations = folder.path().join("one.toml");
    let one = "format = \"doublet equations\"\ninputs = [\"delta_e\"]\n[[state]]\nname = \"alpha\"\nrate = \"L*alpha + M*delta_e\"\n[[output]]\nname = \"alpha\"\nshows = \"alpha\"\n[parameters]\nL = -0.5\nM = 0.5\n";
    std::fs::write(&equations, one).unwrap();
    let command = ["equations", path.to_str().unwrap(), "--equations", equations.to_str().unwrap(), "--json"];
    let found = document(&command);
    for method in ["equation_error", "output_error"] {
        for row in found[method]["parameters"].as_array().unwrap() {
            let truth = if row["name"] == "L" { -1.0 } else { 1.0 };
            let estimate = row["estimate"].as_f64().unwrap();
            assert!((estimate - truth).abs() < 2e-3, "{method}, {}: {estimate}", row["name"]);
        }
    }
}

/// x' = -2 x + 3 u + w with w white: output error drifts away from the motion, filter error finds parameters and the intensity of w.
#[test]
fn equations_in_gusts_are_fitted_by_filter_error() {
    let folder = tempfile::tempdir().unwrap();
    // Normal noise by a generator any reader can write again (Park and Miller), two at a time.
    let mut state = 12_345_u64;
    let mut uniform = move || {
        state = state * 16_807 % 2_147_483_647;
        state as f64 / 2_147_483_647.0
    };
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let (step, fine, intensity) = (0.02, 20, 0.5_f64);
    let mut text = "time_s,x,u\n".to_owned();
    let mut x = 0.0_f64;
    for k in 0..2000 {
        let u = |k: i32| if (k / 60) % 2 == 0 { 0.5 } else { -0.5 };
        text += &format!("{},{},{}\n", step * f64::from(k), x + 0.01 * normal(), u(k));
        for part in 0..fine {
            let h = step / f64::from(fine);
            let now = u(k) + (f64::from(part) + 0.5) / f64::from(fine) * (u(k + 1) - u(k));
            x += h * (-2.0 * x + 3.0 * now) + intensity * h.sqrt() * normal();
        }
    }
    let path = folder.path().join("gusts.csv");
    std::fs::write(&path, text).unwrap();
    let equations = folder.path().join("one.toml");
    let one = "format = \"doublet equations\"\ninputs = [\"u\"]\n[[state]]\nname = \"x\"\nrate = \"L*x + M*u\"\n[[output]]\nname = \"x\"\nshows = \"x\"\n[parameters]\nL = -0.5\nM = 0.5\n";
    std::fs::write(&equations, one).unwrap();
    let command = ["equations", path.to_str().unwrap(), "--equations", equations.to_str().unwrap(), "--json"];
    let found = document(&command);
    // Noise of the measured state biases equation error, which the verdict names.
    assert_eq!(
        (&found["is_driven_by_noise"], &found["verdict"]["level"]),
        (&true.into(), &"caution".into()),
        "{found}"
    );
    for (row, truth) in found["filter_error"]["parameters"].as_array().unwrap().iter().zip([-2.0, 3.0]) {
        let [estimate, error] = ["estimate", "corrected_standard_error"].map(|key| row[key].as_f64().unwrap());
        assert!((estimate - truth).abs() < 2.5 * error && error < 0.15 * f64::abs(truth), "{row}");
    }
    let noise = &found["filter_error"]["process_noise"][0];
    let [found_intensity, error] = ["intensity", "log_error"].map(|key| noise[key].as_f64().unwrap());
    assert!((found_intensity / intensity).ln().abs() < 3.0 * error && error < 0.3, "{noise}");
    assert_eq!(found["filter_error"]["initial"].as_array().unwrap().len(), 1);
}
