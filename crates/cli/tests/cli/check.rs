//! `doublet check`, and what a run does of which a part fails, as a user sees them.

use std::path::Path;

use serde_json::Value;

use crate::common::at_root::json_file;
use crate::common::{doublet, root};
use crate::shared::shared;

/// The one JSON document of `check --json`, with its exit code.
fn checked(folder: &Path, file: &str) -> (Value, Option<i32>) {
    let output = doublet(folder, &["check", file, "--json"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert!(value["findings"].is_array() && value["physics"].is_array(), "{text}");
    (value, output.status.code())
}

/// A copy of the shipped session with changes, in a folder of its own.
fn demo_with(changes: &[(&str, &str)]) -> tempfile::TempDir {
    let mut text = std::fs::read_to_string(root().join("sessions/demo.toml")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    folder
}

fn bad(checked: &Value) -> Vec<String> {
    let findings = checked["findings"].as_array().unwrap().iter().filter(|finding| finding["level"] == "bad");
    findings
        .map(|finding| format!("{}: {}", finding["where"].as_str().unwrap(), finding["text"].as_str().unwrap()))
        .collect()
}

#[test]
fn shipped_session_has_no_bad_finding_and_the_count_is_the_last_line() {
    let (found, code) = checked(&root(), "sessions/demo.toml");
    assert_eq!((bad(&found), code), (Vec::new(), Some(0)));
    let printed = String::from_utf8(doublet(&root(), &["check", "sessions/demo.toml"]).stdout).unwrap();
    let count = found["findings"].as_array().unwrap().len();
    assert!(printed.lines().last().unwrap().starts_with(&format!("{count} findings")), "{printed}");
    assert!(!printed.contains("nothing is wrong"));
}

#[test]
fn run_of_the_shipped_flight_fits_one_screen_and_its_results_say_everything() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = doublet(&root(), &["run", "sessions/demo.toml", "--out", out.to_str().unwrap()]);
    let printed = String::from_utf8(output.stdout).unwrap();
    let widest = printed.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(printed.lines().count() <= 25 && widest <= 160, "{widest}: {printed}");
    assert!(printed.contains("caution: CX_alpha, CX_q (pooled)"), "{printed}");
    let results = json_file(&out.join("results.json"));
    // What marks CX is with its derivatives.
    assert_eq!(results["verdict"]["level"], "good");
    let derivatives = results["pooled"][0]["derivatives"].as_array().unwrap();
    let reasons = derivatives.iter().flat_map(|row| row["verdict"]["reasons"].as_array().unwrap());
    let open: Vec<&Value> = reasons.filter(|reason| reason["code"] == "determined").collect();
    assert_eq!(open.len(), 2, "{open:?}");
    assert!(open.iter().all(|reason| reason["text"].as_str().unwrap().contains("(limit 50 %)")), "{open:?}");
}

#[test]
fn files_that_cannot_be_used_are_a_bad_finding_as_json_too() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("empty.toml"), "").unwrap();
    std::fs::write(folder.path().join("binary.toml"), [0xff_u8, 0xfe, 0, 1]).unwrap();
    std::fs::write(folder.path().join("broken.toml"), "format = \"doublet session\"\nversion = 1\nnonsense = 1\n")
        .unwrap();
    for file in ["empty.toml", "binary.toml", "broken.toml", "missing.toml"] {
        let (found, code) = checked(folder.path(), file);
        assert_eq!((bad(&found).len(), code), (1, Some(3)), "{found}");
        assert!(bad(&found)[0].starts_with(file), "{found}");
    }
}

#[test]
fn check_finds_what_a_run_would_refuse() {
    let first = ("start_s = 1056.75\nend_s = 1069.70", "start_s = 9056.75\nend_s = 9069.70");
    for (from, to, words) in [
        (first.0, first.1, ["manoeuvre '01 aileron doublet'", "0 inertial samples"]),
        (first.0, "start_s = 1056.75\nend_s = 1056.80", ["manoeuvre '01 aileron doublet'", "inertial samples"]),
        (first.0, "start_s = 1056.75\nend_s = 1056.75", ["manoeuvre '01 aileron doublet'", "is not after start"]),
        (first.0, "start_s = 2950.0\nend_s = 3360.0", ["manoeuvre '01 aileron doublet'", "has a gap of"]),
        ("name = \"01 aileron doublet\"", "name = \"\"", ["manoeuvre ''", "the name is empty"]),
        (
            "differentiation_half_width_s = 0.",
            "differentiation_half_width_s = 1e9 # 0.",
            ["manoeuvre", "the local polynomial needs"],
        ),
        ("builtin:flights/demo/bus.h5", "gone.h5", ["flight", "gone.h5"]),
        ("builtin:c337f\"", "builtin:c338\"", ["aircraft", "c338"]),
    ] {
        let folder = demo_with(&[(from, to)]);
        let (found, code) = checked(folder.path(), "s.toml");
        let bad = bad(&found);
        assert_eq!(code, Some(3), "{to}: {found}");
        assert!(
            bad.iter().any(|line| words.iter().all(|word| line.contains(word))),
            "{words:?} is not said by {bad:?}"
        );
    }
}

#[test]
fn window_that_is_partly_outside_its_recording_is_named() {
    let folder = demo_with(&[("start_s = 1056.75", "start_s = -500.0")]);
    let text = std::fs::read_to_string(folder.path().join("s.toml")).unwrap();
    let only = text.replace("end_s = 1069.70", "end_s = 20.0");
    std::fs::write(folder.path().join("s.toml"), only).unwrap();
    let (found, _) = checked(folder.path(), "s.toml");
    let says = |finding: &Value| finding["text"].as_str().unwrap().contains("inertial samples only from");
    let finding =
        found["findings"].as_array().unwrap().iter().find(|finding| says(finding)).unwrap_or_else(|| panic!("{found}"));
    assert_eq!((&finding["level"], &finding["where"]), (&"caution".into(), &"manoeuvre '01 aileron doublet'".into()));
}

#[test]
fn window_that_fails_costs_the_run_nothing_else() {
    let folder = demo_with(&[("start_s = 1056.75\nend_s = 1069.70", "start_s = 9056.75\nend_s = 9069.70")]);
    let output = doublet(folder.path(), &["run", "s.toml", "--out", "out"]);
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    let results = json_file(&folder.path().join("out/results.json"));
    let windows = results["windows"].as_array().unwrap();
    assert!(windows[0]["error"].as_str().unwrap().contains("0 inertial samples") && windows[0]["samples"] == 0);
    assert!(windows[1..].iter().all(|window| window["error"].is_null() && window["samples"].as_u64() > Some(10)));
    assert_eq!(results["pooled"].as_array().unwrap().len(), 6);
    let rows = std::fs::read_to_string(folder.path().join("out/windows.csv")).unwrap();
    assert!(rows.lines().nth(1).unwrap().contains("0 inertial samples"), "{rows}");
    let report =
        doublet(folder.path(), &["report", "s.toml", "--format", "html", "--sections", "windows", "--out", "r"]);
    assert_eq!(report.status.code(), Some(3), "{}", String::from_utf8_lossy(&report.stderr));
    assert!(folder.path().join("r/s.html").is_file());
}

#[test]
fn session_without_an_aircraft_gives_the_flight_path_and_says_so() {
    let text = std::fs::read_to_string(root().join("sessions/demo.toml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("aircraft = ")).unwrap().to_owned();
    let folder = demo_with(&[(&line, "")]);
    let output = doublet(folder.path(), &["run", "s.toml", "--out", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let results = json_file(&folder.path().join("out/results.json"));
    assert!(
        results["warnings"][0].as_str().unwrap().contains("no aircraft: only flight paths"),
        "{}",
        results["warnings"]
    );
    assert_eq!(results["pooled"].as_array().unwrap().len(), 0);
    let windows = results["windows"].as_array().unwrap();
    assert!(windows.iter().all(|window| window["error"].is_null() && window["mean_nis"].as_f64() > Some(1.0)));
    let export = doublet(folder.path(), &["export", "s.toml", "--out", "model"]);
    let printed = String::from_utf8_lossy(&export.stderr).into_owned();
    assert!(
        export.status.code() == Some(1) && printed.lines().count() == 1 && printed.contains("no aircraft"),
        "{printed}"
    );
    let (found, code) = checked(folder.path(), "s.toml");
    assert_eq!((bad(&found), code), (Vec::new(), Some(0)));
}

/// Level flight with an elevator doublet every 40 s, in SI, 50 Hz; `channels` names the columns.
fn recording(path: &Path) {
    let mut text =
        "time,ax_m_s2,ay_m_s2,az_m_s2,p_rad_s,q_rad_s,r_rad_s,phi_rad,theta_rad,tas_m_s,alpha_rad,delta_e_rad\n"
            .to_owned();
    let (mut alpha, mut q) = (0.0, 0.0);
    for k in 0..6000_u32 {
        let time = f64::from(k) * 0.02;
        let delta_e = match time % 40.0 {
            t if (20.0..21.0).contains(&t) => 0.04,
            t if (21.0..22.0).contains(&t) => -0.04,
            _ => 0.0,
        };
        q += 0.02 * (-4.0 * alpha - 2.0 * q - 6.0 * delta_e);
        alpha += 0.02 * (q - 1.2 * alpha);
        let noise = (f64::from(k) * 12.9898).sin() * 43758.5453;
        let noise = 1e-4 * (noise - noise.floor() - 0.5);
        text += &format!(
            "{time:.2},{:.6},{:.6},{:.6},{noise:.6},{:.6},{noise:.6},0.0,{:.6},60.0,{:.6},{delta_e:.6}\n",
            0.5 + noise,
            noise,
            -9.8 - 60.0 * alpha,
            q + noise,
            0.05 + alpha,
            0.05 + alpha
        );
    }
    std::fs::write(path, text).unwrap();
}

const MAP: &str = "format = \"doublet channel map\"\nversion = 1\nname = \"mine\"\n[[time]]\nchannel = \"time\"\nunit = \"s\"\n[roles]\n\
    ax = { channel = \"ax_m_s2\", unit = \"m/s^2\" }\nay = { channel = \"ay_m_s2\", unit = \"m/s^2\" }\naz = { channel = \"az_m_s2\", unit = \"m/s^2\" }\n\
    p = { channel = \"p_rad_s\", unit = \"rad/s\" }\nq = { channel = \"q_rad_s\", unit = \"rad/s\" }\nr = { channel = \"r_rad_s\", unit = \"rad/s\" }\n\
    phi = { channel = \"phi_rad\", unit = \"rad\" }\ntheta = { channel = \"theta_rad\", unit = \"rad\" }\nairspeed = { channel = \"tas_m_s\", unit = \"m/s\" }\n\
    alpha = { channel = \"alpha_rad\", unit = \"rad\" }\ndelta_e = { channel = \"delta_e_rad\", unit = \"rad\" }\n";

#[test]
fn new_takes_windows_from_the_controls_and_names_what_lies_beside_it_from_there() {
    let folder = tempfile::tempdir().unwrap();
    let sub = folder.path().join("sub");
    std::fs::create_dir(&sub).unwrap();
    recording(&sub.join("rec.csv"));
    std::fs::write(sub.join("map.toml"), MAP).unwrap();
    let made = doublet(folder.path(), &["new", "sub/rec.csv", "--map", "sub/map.toml", "-o", "sub/s.toml"]);
    let printed = String::from_utf8_lossy(&made.stdout).into_owned();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(printed.contains("manoeuvres found: 3") && printed.contains("no aircraft: only flight paths"), "{printed}");
    let text = std::fs::read_to_string(sub.join("s.toml")).unwrap();
    assert!(text.contains("path = \"rec.csv\"") && text.contains("channel_map = \"map.toml\""), "{text}");
    assert!(text.matches("surface = \"elevator\"").count() >= 2 && !text.contains("\naircraft"), "{text}");
    let (found, _) = checked(folder.path(), "sub/s.toml");
    assert!(!found.to_string().contains("outside"), "{found}");
    // An absolute path into the folder of the session is not outside it either.
    let absolute = text.replace("path = \"rec.csv\"", &format!("path = \"{}\"", sub.join("rec.csv").display()));
    std::fs::write(sub.join("absolute.toml"), absolute).unwrap();
    let (found, _) = checked(folder.path(), "sub/absolute.toml");
    assert!(!found.to_string().contains("outside"), "{found}");
}

#[test]
fn new_describes_an_aircraft_by_its_numbers_and_refuses_one_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    recording(&folder.path().join("rec.csv"));
    std::fs::write(folder.path().join("map.toml"), MAP).unwrap();
    let with = |output: &str, inertia: &str| {
        let numbers = ["--area", "16", "--span", "11", "--chord", "1.5", "--mass", "1100", "--inertia", inertia];
        let order = ["new", "rec.csv", "--map", "map.toml", "-o", output];
        doublet(folder.path(), &[&order[..], &numbers].concat())
    };
    let refused = with("bad.toml", "1300,1800,9000");
    assert_eq!(refused.status.code(), Some(1), "no body has this inertia");
    assert!(!folder.path().join("bad.toml").exists() && !folder.path().join("bad_aircraft.toml").exists());
    let made = with("s.toml", "1300,1800,2700,60");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let text = std::fs::read_to_string(folder.path().join("s.toml")).unwrap();
    assert!(text.contains("aircraft = \"s_aircraft.toml\""), "{text}");
    let short = doublet(folder.path(), &["new", "rec.csv", "--map", "map.toml", "-o", "t.toml", "--area", "16"]);
    assert!(!short.status.success(), "span, chord, mass and inertia are missing");
}

/// Makes a session of recordings and runs it; returns how the run ended and its results.
fn made_and_run(recordings: &[&str]) -> (Option<i32>, Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let made = doublet(folder.path(), &[&["new"], recordings, &["-o", "s.toml"]].concat());
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let run = doublet(folder.path(), &["run", "s.toml", "--out", "out"]);
    let printed = String::from_utf8_lossy(&run.stderr).into_owned();
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap_or_else(|_| panic!("{printed}"));
    (run.status.code(), serde_json::from_str(&text).unwrap(), printed)
}

#[test]
fn one_manoeuvre_of_one_surface_runs_to_the_end_by_defaults() {
    for file in ["dr3211_1.mat", "da3211_1.mat"] {
        let Some(path) = shared(&format!("data/citation_simulated/{file}")) else { return };
        let (code, results, printed) = made_and_run(&[path.to_str().unwrap()]);
        assert!(matches!(code, Some(0 | 3)), "{file}: {printed}");
        assert_eq!(results["aircraft"], "Cessna Citation 550, simulated", "{}", results["aircraft"]);
        let window = &results["windows"][0];
        assert!(window["samples"].as_u64() > Some(100) && window["error"].is_null(), "{file}: {window}");
        let fits = window["fits"].as_array().unwrap();
        assert!(fits.len() == 3 && fits.iter().all(|fit| fit["error"].is_null()), "{file}: {fits:?}");
        let pooled = results["pooled"].as_array().unwrap();
        // The longitudinal coefficients are in the model, but nothing here tells about them.
        let (found, without): (Vec<_>, Vec<_>) = pooled.iter().partition(|fit| fit["error"].is_null());
        assert!(found.len() == 3 && without.len() == 3, "{file}: {pooled:?}");
        assert!(
            without.iter().all(|fit| fit["error"] == "no manoeuvre is used for this coefficient"),
            "{file}: {without:?}"
        );
        let rests = if file.starts_with("da") { "CY_delta_r" } else { "CY_delta_a" };
        let side = pooled.iter().find(|fit| fit["coefficient"] == "CY").unwrap();
        assert_eq!(side["dropped"][0]["name"], rests, "{file}: {side}");
    }
}

#[test]
fn recording_without_controls_gives_the_flight_path_and_the_errors_of_its_fits() {
    let Some(path) = shared("data/citation_simulated/da3211_1_noisy_with_truth.mat") else { return };
    let (code, results, printed) = made_and_run(&[path.to_str().unwrap()]);
    assert_eq!(code, Some(3), "{printed}");
    let window = &results["windows"][0];
    let nis = window["mean_nis"].as_f64().unwrap();
    assert!((10.0..14.0).contains(&nis), "mean NIS {nis}");
    let fits = results["pooled"].as_array().unwrap();
    assert!(fits.len() == 6 && fits.iter().all(|fit| fit["error"].is_string()), "{fits:?}");
}
