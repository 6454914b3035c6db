//! The command line from recording to results, as a user runs it.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::common::at_root::{doublet, json_file};
use crate::common::root;
use crate::shared::shared;

/// Whether the shared recordings are beside the project.
fn has_shared(relative: &str) -> bool {
    shared(&format!("data/{relative}")).is_some()
}

/// Runs a shipped session and reads its results.
fn results(session: &str) -> (Value, tempfile::TempDir) {
    results_with(session, &[])
}

/// The same with more arguments.
fn results_with(session: &str, arguments: &[&str]) -> (Value, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let session = format!("sessions/{session}.toml");
    let output = doublet(&[&["run", &session, "--out", out.to_str().unwrap()], arguments].concat());
    let text = std::fs::read_to_string(out.join("results.json"));
    let text = text.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    let results: Value = serde_json::from_str(&text).unwrap();
    let code = if results["verdict"]["level"] == "bad" { 3 } else { 0 };
    assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
    (results, folder)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Estimate of a derivative in a list of fits.
fn derivative(fits: &Value, name: &str) -> f64 {
    let rows = fits.as_array().unwrap().iter().flat_map(|fit| fit["derivatives"].as_array().unwrap());
    rows.into_iter().find(|row| row["name"] == name).map_or(f64::NAN, |row| number(&row["estimate"]))
}

#[test]
fn citation_is_consistent_with_its_truth() {
    if !has_shared("citation_simulated") {
        return;
    }
    let (results, _folder) = results("reference/citation_aileron");
    let window = &results["windows"][0];
    let nis = number(&window["mean_nis"]);
    assert!((11.7..12.2).contains(&nis), "mean NIS {nis}");
    let errors: Vec<f64> =
        window["states"].as_array().unwrap().iter().map(|s| number(&s["mean_squared_normalised_error"])).collect();
    assert_eq!(errors.len(), 18);
    assert!(errors.iter().all(|error| *error < 4.0), "{errors:?}");
    let mean = errors.iter().sum::<f64>() / 18.0;
    assert!((0.3..1.5).contains(&mean), "mean {mean}");
}

#[test]
fn citation_zero_order_hold_matches_published_filter() {
    /// Of the reference's standard deviation: the production filter linearises once where the reference does twice.
    const SIGMAS: f64 = 0.01;
    if !has_shared("citation_simulated") {
        return;
    }
    let reference = root().join("../shared/data/citation_simulated/reference_ekf_zero_order_hold.json");
    let reference = json_file(&reference);
    let (results, _folder) = results("reference/citation_aileron_zero_order_hold");
    let states = results["windows"][0]["states"].as_array().unwrap();
    for (index, state) in states.iter().enumerate() {
        let (expected, sigma) = (number(&reference["final_estimate"][index]), number(&reference["final_sigma"][index]));
        let found = number(&state["estimate"]);
        assert!((found - expected).abs() < SIGMAS * sigma, "{}: {found} against {expected}", state["state"]);
    }
}

#[test]
fn attas_gives_the_published_derivatives() {
    /// Relative: the published chain smooths and differentiates in its own way.
    const SMOOTHING_DIFFERS: f64 = 0.03;
    if !has_shared("attas") {
        return;
    }
    let (results, _folder) = results("reference/attas");
    // One window is certain of what the pooled estimate hides.
    let reasons = results["verdict"]["reasons"].as_array().unwrap();
    let scatter = row(&results["verdict"]["reasons"], &[("code", "scatter"), ("where", "Cm_q (pooled)")]);
    assert_eq!(scatter["level"], "bad", "{reasons:?}");
    assert!(scatter["text"].as_str().unwrap().contains("'elevator 3-2-1-1' gives -12.4"), "{scatter}");
    assert_eq!(reasons.iter().filter(|reason| reason["level"] == "bad").count(), 1, "{reasons:?}");
    for (name, published) in [
        ("CL_alpha", 5.22568),
        ("Cm_alpha", -0.877620),
        ("CY_beta", -1.00403),
        ("Cl_p", -0.759763),
        ("Cn_beta", 0.254494),
    ] {
        let found = derivative(&results["pooled"], name);
        println!("{name}: {found:.6}, published {published}, {:+.2} %", 100.0 * (found / published - 1.0));
        assert!((found / published - 1.0).abs() < SMOOTHING_DIFFERS, "{name}: {found} against {published}");
    }
    let missing = &results["windows"][0]["missing_measurements"];
    assert!(missing.as_array().unwrap().iter().any(|m| m == "v_north"), "{missing}");
}

#[test]
fn attas_as_measured_gives_the_published_derivatives_without_a_filter() {
    /// Relative: the published chain takes its own biases off, smooths the flow and differentiates the rates in its own way.
    const TREATMENT_DIFFERS: f64 = 0.02;
    if !has_shared("attas") {
        return;
    }
    let (results, _folder) = results("reference/attas_measured");
    assert!(row(&results["verdict"]["reasons"], &[("code", "as-measured")])["text"].is_string());
    for (name, published) in [
        ("CL_alpha", 5.22568),
        ("Cm_alpha", -0.877620),
        ("Cm_q", -5.81993),
        ("Cm_delta_e", -0.984060),
        ("CY_beta", -1.00403),
        ("Cl_beta", -0.102680),
        ("Cl_p", -0.759763),
        ("Cl_delta_a", -0.192475),
        ("Cn_beta", 0.254494),
        ("Cn_r", -0.134247),
        ("Cn_delta_r", -0.143862),
    ] {
        let found = derivative(&results["pooled"], name);
        println!("{name}: {found:.6}, published {published}, {:+.2} %", 100.0 * (found / published - 1.0));
        assert!((found / published - 1.0).abs() < TREATMENT_DIFFERS, "{name}: {found} against {published}");
    }
    // The recorded angular acceleration is larger than the slope of the recorded rates: control power is too.
    let by_rates = derivative(&results["pooled"], "Cl_delta_a");
    let (output, folder) = run_changed("reference/attas_measured", |text| {
        text.replace("differentiation_half_width_s = 0.1", "angular_acceleration = \"recorded\"")
    });
    assert!(output.status.code().is_some_and(|code| code != 1), "{:?}", error_lines(&output));
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    let recorded: Value = serde_json::from_str(&text).unwrap();
    let ratio = derivative(&recorded["pooled"], "Cl_delta_a") / by_rates;
    assert!((1.02..1.04).contains(&ratio), "{ratio}");
}

#[test]
fn phlab_goes_through_both_steps_with_the_measurements_it_has() {
    if !has_shared("phlab_citation") {
        return;
    }
    let (results, _folder) = results("reference/phlab_short_period");
    // Its only manoeuvre is a caution.
    assert_eq!(results["verdict"]["level"], "caution");
    let missing = results["windows"][0]["missing_measurements"].as_array().unwrap().clone();
    for name in ["beta", "psi", "v_north", "v_east", "v_down"] {
        assert!(missing.iter().any(|m| m == name), "{name} is not in {missing:?}");
    }
    let (lift, stability) = (derivative(&results["pooled"], "CZ_alpha"), derivative(&results["pooled"], "Cm_alpha"));
    assert!((-8.0..-2.0).contains(&lift), "CZ_alpha {lift}");
    assert!((-2.0..0.0).contains(&stability), "Cm_alpha {stability}");
}

#[test]
fn demo_runs_anywhere_and_its_error_bars_hold_the_truth() {
    /// Share of the derivatives that must lie within two corrected standard errors: that of a normal error.
    const SHARE: f64 = 0.95;
    /// Coefficient of determination on manoeuvres the estimate did not see.
    const VALIDATION: f64 = 0.95;
    let truth = std::fs::read_to_string(root().join("assets/flights/demo/truth.toml")).unwrap();
    let truth: toml::Table = truth.parse().unwrap();
    let truth_of = |name: &str| truth["derivatives"].get(name).and_then(toml::Value::as_float);
    let (results, folder) = results_with("demo", &["--with", "sensitivity,manoeuvres,checks,lags"]);
    studies_agree_with_the_pooled_fit(&results, folder.path());
    let proof = results["proof_of_match"]["windows"].as_array().unwrap();
    let tests: Vec<&Value> = proof.iter().flat_map(|window| window["tests"].as_array().unwrap()).collect();
    assert!(tests.len() == 6 && tests.iter().all(|test| test["passed"] == true), "{tests:?}");
    let rows = std::fs::read_to_string(folder.path().join("out/match.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 4 + 2 * 3, "one band per lateral test, three per longitudinal one");
    output_error_is_near_the_truth(&results["studies"], &|name| truth_of(name).unwrap());
    let (mut held, mut count) = (0, 0);
    for row in results["pooled"].as_array().unwrap().iter().flat_map(|fit| fit["derivatives"].as_array().unwrap()) {
        let name = row["name"].as_str().unwrap();
        // Constants are one per window and have no truth of their own.
        let Some(truth) = truth_of(name) else { continue };
        let off = (number(&row["estimate"]) - truth) / number(&row["corrected_standard_error"]);
        println!("{name}: {:.5}, truth {truth}, {off:+.2} corrected errors", number(&row["estimate"]));
        held += usize::from(off.abs() < 2.0);
        count += 1;
    }
    assert_eq!(count, 25);
    assert!(held as f64 >= SHARE * count as f64, "{held} of {count} within two corrected errors");
    let mut seen = std::collections::BTreeSet::new();
    for row in results["predictions"].as_array().unwrap().iter().filter(|row| row["role"] == "validation") {
        let r_squared = number(&row["r_squared_own_constant"]);
        assert!(r_squared > VALIDATION, "{row}");
        seen.insert(row["coefficient"].as_str().unwrap().to_owned());
    }
    assert_eq!(seen.len(), 6, "{seen:?}");
}

/// Row of a study whose text fields are these.
fn row<'v>(rows: &'v Value, fields: &[(&str, &str)]) -> &'v Value {
    let rows = rows.as_array().unwrap();
    let found = rows.iter().find(|row| fields.iter().all(|(key, value)| row[key] == *value));
    found.unwrap_or_else(|| panic!("no row {fields:?}"))
}

/// Output error of the single windows against the truth, and the lags against the sample they should be within.
fn output_error_is_near_the_truth(studies: &Value, truth_of: &impl Fn(&str) -> f64) {
    /// Relative: mean over the windows that move the surface most; each is known to a few per cent.
    const MEAN_OF_WINDOWS: f64 = 0.05;
    /// Relative: some 24 frequencies of a window for up to five derivatives; their errors are several times larger.
    const FEW_FREQUENCIES: f64 = 0.3;
    /// One sample of the inertial data, s: clocks are fitted to a few milliseconds.
    const SAMPLE_S: f64 = 0.02;
    let checks = studies["checks"].as_array().unwrap();
    for (name, surface) in [
        ("Cm_alpha", "elevator"),
        ("Cm_q", "elevator"),
        ("Cm_delta_e", "elevator"),
        ("Cl_p", "aileron"),
        ("Cl_delta_a", "aileron"),
        ("Cn_beta", "rudder"),
        ("Cn_delta_r", "rudder"),
    ] {
        let of_method = |method: &str| -> Vec<f64> {
            let rows = checks.iter().filter(|row| {
                row["method"] == method
                    && row["derivative"] == name
                    && row["window"].as_str().unwrap().contains(surface)
            });
            rows.map(|row| number(&row["estimate"])).collect()
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (flown, frequency) = (of_method("output error"), of_method("frequency domain"));
        assert!(flown.len() >= 5 && frequency.len() == flown.len(), "{name}: {} manoeuvres", flown.len());
        let off = mean(&flown) / truth_of(name) - 1.0;
        println!("{name} by output error over {} manoeuvres: {:+.1} %", flown.len(), 100.0 * off);
        assert!(off.abs() < MEAN_OF_WINDOWS, "{name} by output error is {off:+.3} off the truth");
        assert!((mean(&frequency) / truth_of(name) - 1.0).abs() < FEW_FREQUENCIES, "{name} in the frequency domain");
    }
    for control in ["delta_a", "delta_e", "delta_r"] {
        let found = row(&studies["lags"], &[("control", control), ("kind", "delay"), ("coefficient", "")]);
        assert!(number(&found["value_s"]).abs() < SAMPLE_S, "{found}");
        assert!(number(&found["standard_error_s"]) < 0.01, "{found}");
    }
}

/// What the studies say about the shipped flight against what must hold whatever its noise.
fn studies_agree_with_the_pooled_fit(results: &Value, folder: &Path) {
    let studies = &results["studies"];
    let partial = |quantity: &str, name: &str| {
        let row = row(&studies["sensitivity"], &[("quantity", quantity), ("derivative", name)]);
        (number(&row["partial"]), number(&row["value"]))
    };
    // A scale of 1.05 divides the derivative by it: (1/1.05 - 1/0.95) / 10 per cent of the estimate.
    let slope = (1.0 / 1.05 - 1.0 / 0.95) / 10.0;
    for (quantity, name) in [("delta_e", "Cm_delta_e"), ("delta_a", "Cl_delta_a"), ("beta", "CY_beta")] {
        let (found, estimate) = (partial(quantity, name).0, derivative(&results["pooled"], name));
        assert!((found / (slope * estimate) - 1.0).abs() < 1e-6, "{name} over {quantity}: {found}");
    }
    // Values are those of the identification windows as flown, not of full tanks.
    let windows = results["windows"].as_array().unwrap();
    let flown = windows.iter().filter(|window| window["role"] == "identification");
    let flown: Vec<f64> = flown.map(|window| number(&window["mass_properties"]["ixx_kg_m2"])).collect();
    let mean = flown.iter().sum::<f64>() / flown.len() as f64;
    let ixx = row(&studies["sensitivity"], &[("quantity", "Ixx"), ("derivative", "Cl_p")]);
    assert!((number(&ixx["value"]) / mean - 1.0).abs() < 1e-4, "{ixx}, mean over the manoeuvres {mean}");
    // Derivatives of a moment follow the moment of inertia of its axis; products of inertia and thrust leave a little.
    for (quantity, name) in [("Ixx", "Cl_p"), ("Iyy", "Cm_q"), ("Izz", "Cn_delta_r")] {
        let (found, inertia) = partial(quantity, name);
        let relative = found * inertia / derivative(&results["pooled"], name);
        assert!((relative - 1.0).abs() < 0.1, "{name} over {quantity}: {relative}");
    }
    for bars in studies["tornado"].as_array().unwrap().windows(2) {
        let width = |bar: &Value| (number(&bar["high_percent"]) - number(&bar["low_percent"])).abs();
        assert!(bars[0]["derivative"] != bars[1]["derivative"] || width(&bars[0]) >= width(&bars[1]));
    }
    // Every identification window was left out of each coefficient it tells about, and predicted by the others.
    let left_out = studies["leave_one_out"].as_array().unwrap();
    let of_cz: Vec<&Value> = left_out.iter().filter(|row| row["derivative"] == "CZ_alpha").collect();
    let used = row(&results["pooled"], &[("coefficient", "CZ")])["windows"].as_array().unwrap();
    assert_eq!(of_cz.len(), used.len());
    assert!(of_cz.iter().all(|row| number(&row["r_squared_own_constant"]) > 0.9), "{of_cz:?}");
    // The heave force of an elevator doublet is that of the angle of attack.
    let share = |name: &str| {
        number(&row(&studies["contributions"], &[("window", "03 elevator doublet"), ("derivative", name)])["share"])
    };
    assert!((0.7..1.3).contains(&share("CZ_alpha")) && share("CZ_delta_e") < 0.3, "{}", share("CZ_alpha"));
    let kinds = row(&studies["input_kinds"], &[("derivative", "CZ_alpha")]);
    assert_eq!((&kinds["first_kind"], &kinds["second_kind"]), (&"doublet".into(), &"3-2-1-1".into()));
    // All manoeuvres were flown at one speed: no slope over it stands out, and its error says so.
    let slope = row(&studies["conditions"], &[("derivative", "CZ_alpha"), ("variables", "V h"), ("parameter", "V")]);
    assert!(number(&slope["estimate"]).abs() < 4.0 * number(&slope["standard_error"]), "{slope}");
    let header =
        |file: &str| std::fs::read_to_string(folder.join("out").join(file)).unwrap().lines().next().unwrap().to_owned();
    assert!(header("sensitivity.csv").starts_with("table,quantity,unit,value,step,derivative"));
    assert!(header("conditions.csv").ends_with("manoeuvres,error"));
}

/// Runs a changed copy of a shipped session; returns how it ended and the folder it was run in.
fn run_changed(session: &str, change: impl Fn(String) -> String) -> (Output, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(root().join(format!("sessions/{session}.toml"))).unwrap();
    let shared = root().join("../shared").canonicalize().unwrap_or_default();
    let text = change(text.replace("../../../shared", shared.to_str().unwrap()));
    let path = folder.path().join("session.toml");
    std::fs::write(&path, text).unwrap();
    let out = folder.path().join("out");
    (doublet(&["run", path.to_str().unwrap(), "--out", out.to_str().unwrap()]), folder)
}

fn error_lines(output: &Output) -> Vec<String> {
    String::from_utf8_lossy(&output.stderr).lines().map(str::to_owned).collect()
}

/// Runs a changed copy of a shipped session of which nothing can be computed; returns the error lines.
fn failing(session: &str, change: impl Fn(String) -> String) -> Vec<String> {
    let (output, folder) = run_changed(session, change);
    assert_eq!(output.status.code(), Some(1));
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 1, "nothing but the session is left");
    error_lines(&output)
}

/// Runs a changed copy of a shipped session of which a part cannot be computed; returns the results and the error lines.
fn partly(session: &str, change: impl Fn(String) -> String) -> (Value, Vec<String>) {
    let (output, folder) = run_changed(session, change);
    assert_eq!(output.status.code(), Some(3), "{:?}", error_lines(&output));
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    (serde_json::from_str(&text).unwrap(), error_lines(&output))
}

fn assert_says(lines: &[String], words: &[&str]) {
    println!("{}", lines.join("\n"));
    assert!(lines.iter().all(|line| line.starts_with("error: ")), "{lines:?}");
    assert!(lines.iter().any(|line| words.iter().all(|word| line.contains(word))), "none of {lines:?} says {words:?}");
}

#[test]
fn bad_sessions_end_in_one_clear_line_each() {
    let gone = failing("demo", |text| text.replace("builtin:flights/demo/bus.h5", "gone.h5"));
    assert_says(&gone, &["gone.h5", "not found"]);
    let map = failing("demo", |text| text.replace("builtin:demo_flight", "builtin:demo_flihgt"));
    assert_says(&map, &["demo_flihgt", "demo_flight"]);
    let term = failing("demo", |text| text.replacen("\"qc/V\"", "\"qc/W\"", 1));
    assert_says(&term, &["model.CX", "qc/W"]);
    let noise = failing("demo", |text| text.replacen("alpha = 4.5e-4", "alpha = -3e-3", 1));
    assert_says(&noise, &["measurement_noise.alpha", "-0.003"]);
    let key = failing("demo", |text| text.replacen("gravity_m_s2", "gravity", 1));
    assert_says(&key, &["gravity", "line"]);
    assert_eq!(key.len(), 1);
}

#[test]
fn recordings_that_do_not_fit_end_in_one_clear_line_each() {
    if !has_shared("attas") || !has_shared("citation_simulated") {
        return;
    }
    let (few, lines) = partly("reference/attas", |text| text.replacen("end_s = 25.0", "end_s = 0.2", 1));
    assert_says(&lines, &["manoeuvre 'elevator 3-2-1-1'", "samples"]);
    assert!(few["windows"][0]["error"].as_str().unwrap().contains("samples") && few["windows"][1]["error"].is_null());
    assert!(derivative(&few["pooled"], "Cl_p") < 0.0);
    // A thrust that is constant moves nothing; times the roll rate it does what the roll rate does.
    let add = |term: &'static str| {
        move |text: String| text.replace("\"delta_a\"]\nCl", &format!("\"delta_a\", \"{term}\"]\nCl"))
    };
    let (resting, folder) = run_changed("reference/citation_aileron", add("Tc"));
    assert_eq!(resting.status.code(), Some(0), "{:?}", error_lines(&resting));
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    let resting: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(row(&resting["pooled"], &[("coefficient", "CY")])["dropped"][0]["name"], "CY_Tc");
    let (dependent, lines) = partly("reference/citation_aileron", add("pb/2V*Tc"));
    assert_says(&lines, &["CY", "Tc", "depends on"]);
    assert!(row(&dependent["pooled"], &[("coefficient", "CY")])["error"].as_str().unwrap().contains("Tc"));
    assert!(derivative(&dependent["pooled"], "Cl_p") < 0.0 && number(&dependent["windows"][0]["mean_nis"]) > 10.0);
}

#[test]
fn channel_maps_that_do_not_fit_end_in_one_clear_line_each() {
    let folder = tempfile::tempdir().unwrap();
    let csv: String = std::iter::once("t,q\n".to_owned())
        .chain((0..50).map(|k| format!("{},{}\n", f64::from(k) * 0.1, f64::from(k).sin())))
        .collect();
    std::fs::write(folder.path().join("r.csv"), csv).unwrap();
    let header = "format = \"doublet channel map\"\nversion = 1\nname = \"m\"\n";
    let run = |map: &str| {
        std::fs::write(folder.path().join("m.toml"), format!("{header}{map}")).unwrap();
        let session = "format = \"doublet session\"\nversion = 1\naircraft = \"builtin:c337f\"\n[[flight]]\nname = \"f\"\n\
             [[flight.recording]]\npath = \"r.csv\"\nchannel_map = \"m.toml\"\n";
        let path = folder.path().join("s.toml");
        std::fs::write(&path, session).unwrap();
        let out = folder.path().join("out");
        let output = doublet(&["run", path.to_str().unwrap(), "--out", out.to_str().unwrap()]);
        assert!(!output.status.success() && !out.exists());
        String::from_utf8_lossy(&output.stderr).lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let unknown =
        run("[[time]]\nchannel = \"t\"\nunit = \"s\"\n[roles]\nq = { channel = \"pitch\", unit = \"deg/s\" }\n");
    assert_says(&unknown, &["pitch", "r.csv"]);
    let unit = run("[[time]]\nchannel = \"t\"\nunit = \"s\"\n[roles]\nq = { channel = \"q\", unit = \"dgr/s\" }\n");
    assert_says(&unit, &["dgr/s", "deg/s"]);
    let dimension = run("[[time]]\nchannel = \"t\"\nunit = \"s\"\n[roles]\nq = { channel = \"q\", unit = \"kt\" }\n");
    assert_says(&dimension, &["kt", "rad/s"]);
}

#[test]
fn new_finds_the_channel_map_and_check_passes_its_session() {
    if !has_shared("attas") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("s.toml");
    let session = session.to_str().unwrap();
    let made = doublet(&["new", "../shared/data/attas/fAttasElv1.mat", "-o", session]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let text = std::fs::read_to_string(session).unwrap();
    assert!(text.contains("builtin:attas\"") && text.contains("aircraft = \"builtin:attas_vfw614\""), "{text}");
    let checked = doublet(&["check", session]);
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    let again = doublet(&["new", "../shared/data/attas/fAttasElv1.mat", "-o", session]);
    assert!(!again.status.success(), "a session is never overwritten");
}

#[test]
fn check_says_that_an_empty_file_is_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.toml");
    std::fs::write(&path, "").unwrap();
    let output = doublet(&["check", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.starts_with("bad: ") && text.ends_with("1 finding: 1 bad\n"), "{text}");
    assert!(["empty.toml", "the file is empty"].iter().all(|word| text.contains(word)), "{text}");
}

#[test]
fn check_prints_an_aircraft_and_refuses_an_impossible_one() {
    let output = doublet(&["check", "assets/aircraft/c337f.toml"]);
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for word in ["mass", "MAC", "Ixx", "principal", "envelope"] {
        assert!(text.to_lowercase().contains(&word.to_lowercase()), "{word} is not in\n{text}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let good = std::fs::read_to_string(root().join("assets/aircraft/attas_vfw614.toml")).unwrap();
    std::fs::write(&path, good.replace("mass_kg = 17631.0", "mass_kg = -1.0")).unwrap();
    let output = doublet(&["check", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(printed.contains("-1") && printed.contains("mass"), "{printed}");
}

#[test]
fn simulate_says_what_it_cannot_fly() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("flight");
    let out = out.to_str().unwrap();
    let refuse = |arguments: &[&str], words: &[&str]| {
        let output = doublet(&[&["simulate", "test-point", "--out", out], arguments].concat());
        assert!(!output.status.success());
        let lines: Vec<_> = String::from_utf8_lossy(&output.stderr).lines().map(str::to_owned).collect();
        assert_says(&lines, words);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    };
    refuse(&["--derivative", "Cq_alpha=1"], &["Cq_alpha", "Cm_alpha"]);
    refuse(&["--airspeed-kt", "50"], &["no trim", "angle of attack"]);
    refuse(&["--airspeed-kt", "200"], &["no trim", "short"]);
    refuse(&["--amplitude", "6"], &["aileron", "deg past"]);
    let listed = doublet(&["simulate", "--list"]);
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    assert!(["demo", "c337f", "3-2-1-1", "multisine"].iter().all(|word| text.contains(word)), "{text}");
}

#[test]
fn a_session_that_comes_with_the_program_is_inspected_by_its_name() {
    let printed = crate::common::at_root::printed(&["inspect", "builtin:demo"]);
    for file in ["bus.h5: ", "truth.h5: ", "pod.csv: ", "sensor_yoke.csv: ", "sensor_panel.csv: "] {
        assert_eq!(printed.matches(file).count(), 1, "{file} in {printed}");
    }
    let all = crate::common::at_root::document(&["inspect", "builtin:demo", "--json"]);
    assert_eq!(all["recordings"].as_array().unwrap().len(), 8, "{all}");
    let one = crate::common::at_root::document(&["inspect", "builtin:flights/demo/pod.csv", "--json"]);
    assert_eq!(all["recordings"][2]["sources"], one["sources"]);
    let line = crate::common::at_root::error_line(&["inspect", "builtin:nonsense"]);
    assert!(line.contains("builtin:nonsense: shipped recording not found: use builtin:demo"), "{line}");
}
