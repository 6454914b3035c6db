//! `doublet response` and `doublet loes` on tables and on the shipped session.

use std::f64::consts::TAU;
use std::path::Path;

use serde_json::Value;

use crate::common::at_root::{document, doublet, error_line};

/// K, 1/T_theta2, zeta, omega, tau.
const TRUTH: [f64; 5] = [1.972, 2.048, 0.607, 2.922, 0.125];

/// A table of a logarithmic sweep from 0.1 to 2 pi rad/s in 110 s and the pitch rate that follows it, sampled at 32 Hz, the delay four
/// samples, with a little noise; a pause of 1.5 s in the middle of its time where `has_pause`.
fn table(folder: &Path, has_pause: bool) -> String {
    const STEP_S: f64 = 1.0 / 32.0;
    let rate = (TAU / 0.1f64).ln() / 110.0;
    let sweep = |t: f64| {
        if !(0.0..=110.0).contains(&t) {
            return 0.0;
        }
        (0.1 * ((rate * t).exp() - 1.0) / rate).sin() * ((110.0 - t) / 2.0).min(1.0)
    };
    let [gain, zero, zeta, omega, delay_s] = TRUTH;
    let slope = |[x, v]: [f64; 2], t: f64| [v, sweep(t - delay_s) - 2.0 * zeta * omega * v - omega * omega * x];
    let moved = |[x, v]: [f64; 2], [dx, dv]: [f64; 2], h: f64| [x + h * dx, v + h * dv];
    let (mut state, mut noise) = ([0.0, 0.0], 1u64);
    let mut text = "time [s],eta,q\n".to_owned();
    for k in 0..3840 {
        let time = STEP_S * f64::from(k);
        let mut white = 0.0;
        for _ in 0..12 {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            white += (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        }
        let rate = gain * (state[1] + zero * state[0]) + 0.036 * white;
        let shift = if has_pause && k >= 1900 { 1.5 } else { 0.0 };
        text += &format!("{},{},{rate}\n", time + shift, sweep(time));
        for part in 0..8 {
            let (t, h) = (time + STEP_S * f64::from(part) / 8.0, STEP_S / 8.0);
            let a = slope(state, t);
            let b = slope(moved(state, a, 0.5 * h), t + 0.5 * h);
            let c = slope(moved(state, b, 0.5 * h), t + 0.5 * h);
            let d = slope(moved(state, c, h), t + h);
            state = moved(state, [0, 1].map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0), h);
        }
    }
    let path = folder.join(if has_pause { "pause.csv" } else { "sweep.csv" });
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn exact_gain_db(omega: f64) -> f64 {
    let [gain, zero, zeta, w, _] = TRUTH;
    let over = gain * (omega * omega + zero * zero).sqrt();
    let under = ((w * w - omega * omega).powi(2) + (2.0 * zeta * w * omega).powi(2)).sqrt();
    20.0 * (over / under).log10()
}

#[test]
fn response_of_a_table_is_that_of_the_system_it_came_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = table(folder.path(), false);
    let (csv, svg) = (folder.path().join("response.csv"), folder.path().join("bode.svg"));
    let files = ["--out", csv.to_str().unwrap(), "--figure", svg.to_str().unwrap()];
    let asked = ["response", &path, "--input", "eta", "--output", "q", "--band", "0.5..6", "--points", "30", "--json"];
    let found = document(&[&asked[..], &files].concat());
    let rows = found["response"].as_array().unwrap();
    assert_eq!(rows.len(), 30);
    let mut squares = 0.0;
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let omega = number("frequency_rad_s");
        let apart = number("gain_db") - exact_gain_db(omega);
        // Besides noise the windows smooth the response a little.
        assert!(apart.abs() < 4.0 * number("gain_sd_db") + 0.15, "{row}: {apart}");
        assert!(number("coherence") > 0.9 && number("phase_sd_deg") < 5.0 && number("phase_deg") < 10.0, "{row}");
        squares += apart * apart / 30.0;
    }
    assert!(squares.sqrt() < 0.3, "{squares}");
    let text = std::fs::read_to_string(csv).unwrap();
    assert_eq!(text.lines().count(), 31);
    assert!(text.starts_with("input,output,frequency_rad_s,gain_db,phase_deg,coherence"));
    let drawing = std::fs::read_to_string(svg).unwrap();
    assert!(drawing.starts_with("<svg") && drawing.contains("coherence") && drawing.contains("rad/s"));
    // Expressions of columns are signals.
    let doubled = document(&[
        "response", &path, "--input", "eta", "--output", "-2*q", "--band", "0.5..6", "--points", "30", "--json",
    ]);
    let gain = |document: &Value| document["response"][10]["gain_db"].as_f64().unwrap();
    assert!((gain(&doubled) - gain(&found) - 20.0 * 2f64.log10()).abs() < 1e-9);
}

#[test]
fn equivalent_system_of_a_table_holds_the_truth_and_what_judges_it() {
    let folder = tempfile::tempdir().unwrap();
    for has_pause in [false, true] {
        let path = table(folder.path(), has_pause);
        let found = document(&["loes", &path, "--input", "eta", "--output", "q", "--form", "short-period", "--json"]);
        assert_eq!(found["records"].as_array().unwrap().len(), if has_pause { 2 } else { 1 });
        let methods = [found["method"].as_str(), found["other"]["method"].as_str()];
        assert_eq!(methods, [Some("output-error"), Some("coherence")]);
        for (list, rows) in [("output-error", &found["parameters"]), ("coherence", &found["other"]["parameters"])] {
            let names = ["K", "inv_Ttheta2", "zeta", "omega", "tau"];
            for (row, (name, truth)) in rows.as_array().unwrap().iter().zip(names.iter().zip(TRUTH)) {
                assert_eq!(row["name"].as_str(), Some(*name));
                let number = |key: &str| row[key].as_f64().unwrap();
                let apart = (number("value") - truth) / number("standard_error");
                assert!(apart.abs() < 3.5, "{list} of {path}: {row}");
                assert!(number("low") < number("value") && number("value") < number("high"), "{row}");
            }
        }
        let derived = |name: &str| {
            let rows = found["derived"].as_array().unwrap();
            rows.iter().find(|row| row["name"] == name).unwrap()["value"].as_f64().unwrap()
        };
        assert!((derived("omega_Ttheta2") - TRUTH[3] / TRUTH[1]).abs() < 0.1);
        assert!(
            (derived("bandwidth") - 2.57).abs() < 0.15 && (derived("phase_delay") - 0.100).abs() < 0.01,
            "{}",
            found["derived"]
        );
        assert!(found["cost"].as_f64().unwrap() < 20.0);
    }
}

#[test]
fn study_of_a_session_says_what_its_command_says() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    let done = doublet(&["run", "sessions/demo.toml", "--with", "responses", "--out", out.to_str().unwrap()]);
    assert!(done.status.success() || done.status.code() == Some(3), "{}", String::from_utf8_lossy(&done.stderr));
    let results: Value = serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    let studies = &results["studies"];
    let systems = studies["equivalent_systems"].as_array().unwrap();
    // The delay of the pitch response is judged, at the value of the system.
    let levels = studies["equivalent_levels"].as_array().unwrap();
    let pitch = levels.iter().find(|row| row["input"] == "delta_e").unwrap();
    let criteria = pitch["qualities"]["criteria"].as_array().unwrap();
    let delay = criteria.iter().find(|row| row["criterion"] == "equivalent delay").unwrap();
    let fitted = systems.iter().find(|row| row["input"] == "delta_e" && row["name"] == "tau").unwrap();
    assert_eq!(delay["values"]["equivalent_delay"], fitted["value"]);
    assert_eq!((&delay["level"], &delay["counts"]), (&Value::from("Level 1"), &Value::from(true)));
    let figure = ["loes", "sessions/demo.toml", "--figure"];
    let pdf = folder.path().join("bode.pdf");
    let more = ["--input", "delta_e", "--output", "q", "--form", "short-period", "--json"];
    let command = document(&[&figure[..], &[pdf.to_str().unwrap()], &more].concat());
    assert!(std::fs::read(pdf).unwrap().starts_with(b"%PDF"));
    for row in command["parameters"].as_array().unwrap() {
        let same = systems.iter().find(|other| other["input"] == "delta_e" && other["name"] == row["name"]).unwrap();
        assert_eq!((&same["value"], &same["standard_error"]), (&row["value"], &row["standard_error"]));
    }
    // The truth's short period where most of the windows lie, of its own file: 2.555 rad/s, damping 0.418.
    let truth =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/flights/demo/truth.toml"))
            .unwrap();
    let truth: toml::Table = truth.parse().unwrap();
    let modes = truth["mode"].as_array().unwrap();
    let short_period = modes.iter().find(|mode| mode["name"].as_str() == Some("short period")).unwrap();
    for (name, key, allowed) in [("omega", "frequency_rad_s", 0.05), ("zeta", "damping", 0.02)] {
        let found = systems.iter().find(|row| row["input"] == "delta_e" && row["name"] == name).unwrap();
        let apart = found["value"].as_f64().unwrap() - short_period[key].as_float().unwrap();
        assert!(apart.abs() < allowed, "{found}: {apart}");
    }
    let points = studies["response"].as_array().unwrap();
    let of = |input: &str| points.iter().filter(|row| row["input"] == input).count();
    assert_eq!([of("delta_e"), of("delta_a"), of("delta_r")], [50; 3]);
    let csv = std::fs::read_to_string(out.join("tables").join("responses.csv"));
    assert!(csv.or_else(|_| std::fs::read_to_string(out.join("responses.csv"))).unwrap().lines().count() == 151);
    // Both inputs of the lateral motion at once, each with the other held.
    let both = document(&["response", "builtin:demo", "--input", "delta_a,delta_r", "--output", "p", "--json"]);
    let rows = both["response"].as_array().unwrap();
    assert_eq!(rows.len(), 100);
    for row in rows.iter().filter(|row| row["input"] == "delta_a" && row["frequency_rad_s"].as_f64().unwrap() > 4.0) {
        assert!(row["coherence"].as_f64().unwrap() > 0.8 && row["gain_db"].is_number(), "{row}");
    }
}

#[test]
fn what_cannot_be_answered_is_said_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = table(folder.path(), false);
    let refusal = |more: &[&str]| error_line(&[&["response", &path, "--input", "eta", "--output", "q"], more].concat());
    assert!(error_line(&["response", &path, "--input", "nu", "--output", "q"]).contains("no column is called 'nu'"));
    assert!(error_line(&["response", &path, "--input", "q", "--output", "q"]).contains("is given twice"));
    assert!(refusal(&["--band", "0.01..0.02", "--window-length", "30"]).contains("two cycles"));
    assert!(refusal(&["--band", "1..200"]).contains("half the sampling frequency"));
    assert!(refusal(&["--window-length", "900"]).contains("the longest record lasts 120"));
    assert!(refusal(&["--manoeuvres", "1"]).contains("not for a table"));
    assert!(refusal(&["--figure", "bode.gif"]).contains(".svg or .pdf"));
    let untimed = folder.path().join("untimed.csv");
    std::fs::write(&untimed, "a,b\n".to_owned() + &"1.0,2.0\n0.5,1.5\n".repeat(300)).unwrap();
    let untimed = untimed.to_str().unwrap();
    assert!(error_line(&["response", untimed, "--input", "a", "--output", "b"]).contains("--dt"));
    let few =
        ["loes", &path, "--input", "eta", "--output", "q", "--form", "2/3", "--method", "coherence", "--points", "3"];
    assert!(error_line(&few).contains("with enough coherence, 7 parameters"));
    let session = "sessions/demo.toml";
    let refusal = |input: &str| error_line(&["response", session, "--input", input, "--output", "q"]);
    assert!(refusal("delta_x").contains("no signal is called 'delta_x'"));
}
