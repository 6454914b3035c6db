//! `linear`, `modes`, `qualities` and `propagate` as a user runs them on the shipped flight.

use serde_json::Value;

use crate::common::at_root::{document, doublet, json_file, text};

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
}

fn mode<'a>(document: &'a Value, name: &str) -> &'a Value {
    document["modes"].as_array().unwrap().iter().find(|mode| mode["name"] == name).unwrap()
}

/// Modes of the truth's linearisation at 46.3 m/s and 1219.2 m, as the flight's truth file states them with the loading of its start.
const TRUTH: [(&str, f64, f64); 2] = [("short period", 2.555_016, 0.418_169), ("Dutch roll", 1.416_954, 0.141_81)];

#[test]
fn modes_of_the_shipped_flight_are_the_truths_within_their_intervals() {
    let found = document(&["modes", "sessions/demo.toml", "--airspeed", "46.3", "--altitude", "1219.2", "--json"]);
    assert!((number(&found, "/trim/airspeed_m_s") - 46.3).abs() < 1e-12);
    for (name, frequency, damping) in TRUTH {
        let mode = mode(&found, name);
        for (key, truth) in [("frequency_rad_s", frequency), ("damping", damping)] {
            let value = mode[key].as_f64().unwrap();
            let error = number(mode, &format!("/intervals/{key}/delta/standard_error"));
            let sampled = number(mode, &format!("/intervals/{key}/sampled/standard_error"));
            // Fuel has been burnt since, so the loading is not quite that of the truth file; three and a half per cent of scatter each.
            assert!(
                (value - truth).abs() < 3.5 * error + 0.02 * truth,
                "{name} {key}: {value} +- {error}, truth {truth}"
            );
            assert!((sampled / error - 1.0).abs() < 0.15, "{name} {key}: {sampled} {error}");
        }
    }
    let spiral = mode(&found, "spiral");
    assert!(spiral["period_s"].is_null() && spiral["time_to_half_s"].is_null() != spiral["time_to_double_s"].is_null());
    let sum: f64 = spiral["participation"].as_object().unwrap().values().filter_map(Value::as_f64).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    let locus =
        document(&["modes", "sessions/demo.toml", "--samples", "2", "--locus", "Cm_alpha=-1.2:-0.6:3", "--json"]);
    let points = locus["points"].as_array().unwrap();
    let frequency = |point: &Value| mode(point, "short period")["frequency_rad_s"].as_f64().unwrap();
    assert!(
        points.len() == 3
            && frequency(&points[0]) > frequency(&points[1])
            && frequency(&points[1]) > frequency(&points[2])
    );
}

#[test]
fn linear_models_are_the_same_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (as_json, as_csv, as_mat) = (path("model.json"), path("model.csv"), path("model.mat"));
    for out in [&as_json, &as_csv, &as_mat] {
        let run = doublet(&["linear", "sessions/demo.toml", "--samples", "2", "--out", out]);
        assert!(run.status.success(), "{}", text(&run.stderr));
        let shown = text(&run.stdout);
        for tool in ["python: ", "julia: ", "matlab: "] {
            assert!(shown.contains(tool), "{shown}");
        }
    }
    let document = json_file(as_json.as_ref());
    let systems = document["systems"].as_object().unwrap();
    for name in ["full", "motion", "longitudinal", "longitudinal_air", "lateral", "lateral_air", "short_period", "roll"]
    {
        assert!(systems.contains_key(name), "{name}");
    }
    let longitudinal = &systems["longitudinal"];
    assert_eq!(longitudinal["states"], serde_json::json!(["u", "w", "q", "theta"]));
    assert_eq!(longitudinal["covariance"].as_array().unwrap().len(), 24);
    // Every digit survives: a line of the CSV reads back as the same number.
    let mut compared = 0;
    let table = std::fs::read_to_string(&as_csv).unwrap();
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [system, matrix, i, j, .., value, _] = cells[..] else { panic!("{line}") };
        let [i, j] = [i, j].map(|text| text.parse::<usize>().unwrap() - 1);
        assert_eq!(systems[system][matrix][i][j].as_f64(), value.parse().ok(), "{line}");
        compared += 1;
    }
    assert!(compared > 700, "{compared}");
    // MAT of level 5, little-endian, one compressed variable per model.
    let bytes = std::fs::read(&as_mat).unwrap();
    assert_eq!(&bytes[..19], b"MATLAB 5.0 MAT-file");
    assert_eq!(&bytes[124..128], &[0, 1, b'I', b'M']);
    let (mut at, mut variables) = (128, 0);
    while at < bytes.len() {
        let word = |from: usize| u32::from_le_bytes(bytes[from..from + 4].try_into().unwrap());
        assert_eq!(word(at), 15);
        at += 8 + word(at + 4) as usize;
        variables += 1;
    }
    assert_eq!((at, variables), (bytes.len(), systems.len()));
    let refused = doublet(&["linear", "sessions/demo.toml", "--samples", "2", "--out", &path("model.xlsx")]);
    assert!(!refused.status.success() && text(&refused.stderr).contains(".mat, .json or .csv"));
}

#[test]
fn trim_follows_what_is_asked_for() {
    let of = |arguments: &[&str]| {
        let all = [&["linear", "sessions/demo.toml", "--samples", "2", "--json"], arguments].concat();
        document(&all)
    };
    let level = of(&[]);
    let turn = of(&["--load-factor", "1.4"]);
    assert!((number(&turn, "/trim/load_factor") - 1.4).abs() < 1e-9);
    assert!(
        number(&turn, "/trim/phi_rad") > 0.6 && number(&turn, "/trim/alpha_rad") > number(&level, "/trim/alpha_rad")
    );
    let climb = of(&["--gamma", "3"]);
    assert!(number(&climb, "/trim/thrust_n") > number(&level, "/trim/thrust_n"));
    // Fuel in the wings: a lighter aircraft with less inertia about x rolls faster for the same aileron.
    let (full, empty) = (of(&["--fuel", "250"]), of(&["--fuel", "20"]));
    assert!((number(&full, "/trim/mass_kg") - number(&empty, "/trim/mass_kg") - 230.0).abs() < 1e-6);
    let roll = |document: &Value| number(document, "/systems/roll/B/0/0").abs();
    assert!(roll(&empty) > roll(&full), "{} {}", roll(&empty), roll(&full));
    let aft = of(&["--cg", &(number(&level, "/trim/cg_from_datum_m/0") + 0.1).to_string()]);
    let stiffness = |document: &Value| number(document, "/systems/short_period/A/1/0");
    assert!(stiffness(&aft) > stiffness(&level), "an aft centre of gravity is less stable");
    let window = doublet(&["linear", "sessions/demo.toml", "--window", "no such manoeuvre"]);
    let error = text(&window.stderr);
    assert!(!window.status.success() && error.contains("manoeuvre 'no such manoeuvre' is not in use"), "{error}");
    let slow = doublet(&["linear", "sessions/demo.toml", "--load-factor", "0.5"]);
    assert!(text(&slow.stderr).contains("a turn at a load factor of 0.5 does not exist"), "{}", text(&slow.stderr));
}

#[test]
fn levels_have_reasons_and_probabilities() {
    let arguments = ["qualities", "sessions/demo.toml", "--class", "I", "--category", "B", "--json"];
    let found = document(&arguments);
    let criteria = found.pointer("/qualities/criteria").and_then(Value::as_array).unwrap();
    let of = |name: &str| criteria.iter().find(|row| row["criterion"] == name).unwrap();
    // Short period 2.56 rad/s with damping 0.42: Level 1 of 0.30 in category B.
    assert_eq!(of("short-period damping")["level"], "Level 1");
    let shares: Vec<f64> =
        of("short-period damping")["probabilities"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(shares[0] > 0.9 && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{shares:?}");
    assert_eq!(of("coupled roll-spiral")["level"], "not judged");
    let text = text(&doublet(&arguments[..6]).stdout);
    assert!(text.contains("worst: ") && text.contains('%') && text.contains("n/α"), "{text}");
}

#[test]
fn functions_of_derivatives_have_intervals() {
    let found = document(&["propagate", "sessions/demo.toml", "-Cm_alpha/CZ_alpha", "--json"]);
    let (value, delta) = (number(&found, "/value"), number(&found, "/delta/standard_error"));
    let sampled = number(&found, "/sampled/standard_error");
    assert!(value < 0.0 && delta > 0.0 && (sampled / delta - 1.0).abs() < 0.1, "{found}");
    // The estimates of different coefficients share the errors of the path: the ratio's error is neither that of independent ones nor
    // beyond what any correlation allows.
    let one = document(&["propagate", "sessions/demo.toml", "Cm_alpha", "--json"]);
    let other = document(&["propagate", "sessions/demo.toml", "CZ_alpha", "--json"]);
    let relative = |row: &Value| (number(row, "/delta/standard_error") / number(row, "/value")).abs();
    let (first, second, ratio) = (relative(&one), relative(&other), delta / value.abs());
    assert!(ratio < 0.9 * first.hypot(second) && ratio > (first - second).abs(), "{ratio} {first} {second}");
    // Airspeed at which 20 deg of rudder, aileron against its roll, just hold 1800 N of one engine 2 m off the plane of symmetry.
    let control = "sqrt(2*1800*2/(-rho*S*b*0.35*(Cn_delta_r-Cn_delta_a*Cl_delta_r/Cl_delta_a)))";
    let found = document(&["propagate", "sessions/demo.toml", control, "--json"]);
    let (speed, delta) = (number(&found, "/value"), number(&found, "/delta/standard_error"));
    let truth_effect = 0.078 + 0.010 * 0.003 / 0.172;
    let truth = (2.0 * 1800.0 * 2.0 / (number(&found, "/condition/rho") * 18.7 * 11.68 * 0.35 * truth_effect)).sqrt();
    assert!((speed - truth).abs() < 4.0 * delta && delta < 0.01 * speed, "{truth}: {found}");
    assert!((number(&found, "/sampled/standard_error") / delta - 1.0).abs() < 0.1, "{found}");
    let unknown = doublet(&["propagate", "sessions/demo.toml", "2*Cm_alfa"]);
    let error = text(&unknown.stderr);
    assert!(
        !unknown.status.success() && error.contains("no derivative is called 'Cm_alfa': did you mean Cm_alpha"),
        "{error}"
    );
}

#[test]
fn pitch_and_roll_criteria_are_judged_with_intervals_or_say_what_they_need() {
    let base = ["qualities", "sessions/demo.toml", "--class", "I", "--category", "A", "--samples", "200", "--json"];
    let found = document(&base);
    let row = |found: &Value, name: &str| {
        let criteria = found.pointer("/qualities/criteria").and_then(Value::as_array).unwrap();
        criteria.iter().find(|row| row["criterion"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    // Neither delay nor deflection is known: bandwidth and roll performance say so, dropback needs neither.
    for (name, part) in [
        ("bandwidth and phase delay", "delay from stick"),
        ("pilot in the loop (Neal-Smith)", "delay from stick"),
        ("roll performance", "aileron deflection"),
        ("stick force per load factor", "stick force"),
    ] {
        let row = row(&found, name);
        assert!(row["level"] == "not judged" && row["needed"].as_str().unwrap().contains(part), "{row}");
        assert!(!row["source"].as_str().unwrap().is_empty() && row["standard"].as_str().unwrap().contains("(19"));
    }
    let dropback = row(&found, "dropback and overshoot");
    assert!(dropback["guidance"] == true && dropback["counts"] == false && dropback["needed"].is_null());
    let known = document(&[&base[..], &["--stick-delay", "0.05", "--aileron", "14.5"]].concat());
    for (name, keys) in [
        ("bandwidth and phase delay", &["bandwidth", "phase_delay"][..]),
        ("pilot in the loop (Neal-Smith)", &["pilot_compensation_deg", "closed_loop_resonance_db"]),
        ("pilot-induced oscillation, phase rate", &["average_phase_rate_deg_hz", "phase_rate_deg_hz"]),
        ("roll performance", &["time_to_bank_60"]),
        ("dropback and overshoot", &["dropback", "pitch_rate_overshoot"]),
    ] {
        let row = row(&known, name);
        for key in keys {
            let value = row["values"][key].as_f64().unwrap_or_else(|| panic!("{row}"));
            let [low, high] = ["low", "high"].map(|end| row["intervals"][key][end].as_f64().unwrap());
            // A value may lie at the edge of its samples, not far outside.
            let room = high - low;
            assert!(low - room < value && value < high + room, "{key}: {value} in {low} to {high}");
        }
        let shares: f64 = row["probabilities"].as_array().unwrap().iter().filter_map(Value::as_f64).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{row}");
    }
    // Only roll performance has limits that count: the others do not move the overall level.
    assert_eq!(row(&known, "roll performance")["counts"], true);
    assert_eq!(row(&known, "bandwidth and phase delay")["counts"], false);
    let rate = number(&row(&known, "pilot-induced oscillation, phase rate"), "/values/average_phase_rate_deg_hz");
    let delay = number(&row(&known, "bandwidth and phase delay"), "/values/phase_delay");
    assert!((rate / delay - 720.0).abs() < 1e-6);
    // In category B the pilot of the audit lags by 36 deg, outside the figure of Neal and Smith: not judged, and why.
    let cruise =
        ["qualities", "sessions/demo.toml", "--stick-delay", "0.05", "--aileron", "15", "--samples", "50", "--json"];
    let loop_closed = row(&document(&cruise), "pilot in the loop (Neal-Smith)");
    let compensation = number(&loop_closed, "/values/pilot_compensation_deg");
    assert!((compensation + 36.0).abs() < 2.0, "{compensation}");
    assert_eq!(loop_closed["level"], "not judged");
    let needed = loop_closed["needed"].as_str().unwrap();
    assert!(needed.contains("-30 to 90 deg") && needed.contains(&format!("{compensation:.1}")), "{needed}");
    // The other standard judges the same modes by its own paragraphs, and what both have once.
    let other = document(&[&base[..], &["--limits", "mil_std_1797a"]].concat());
    assert_eq!(other.pointer("/qualities/standard"), Some(&Value::from("MIL-STD-1797A")));
    for name in ["control anticipation", "short-period damping", "Dutch roll", "roll mode", "spiral"] {
        let [one, two] = [&found, &other].map(|document| row(document, name));
        assert_eq!(one["values"], two["values"], "{name}");
        assert!(two["counts"] == true && two["level"] != "not judged", "{two}");
        assert!(two["standard"].as_str().unwrap().starts_with("MIL-STD-1797A") && two["source"] != one["source"]);
    }
    let lines = text(&doublet(&base[..6]).stdout);
    assert!(lines.contains("judged and counted") && lines.contains("not judged"), "{lines}");
}
