//! `doublet batch` and `doublet diff` as a user, or a scheduler, runs them.

use std::path::Path;
use std::process::Command;

use crate::common::at_root::{document, printed};

/// A session of one window of the shipped flight, and a sweep of three runs beside it.
fn campaign(folder: &Path) {
    let session = r#"format = "doublet session"
version = 2
title = "one elevator window"
aircraft = "builtin:c337f"
[model]
Cm = ["1", "alpha", "qc/V", "delta_e"]
"#;
    let shipped: toml::Table = toml::from_str(include_str!("../../../../sessions/demo.toml")).unwrap();
    let windows = shipped["manoeuvre"].as_array().unwrap();
    let window = windows.iter().find(|window| window.get("surface").is_some_and(|s| s.as_str() == Some("elevator")));
    let mut all: toml::Table = toml::from_str(session).unwrap();
    all.insert("flight".into(), shipped["flight"].clone());
    all.insert("manoeuvre".into(), toml::Value::Array(vec![window.unwrap().clone()]));
    std::fs::create_dir_all(folder.join("base")).unwrap();
    std::fs::write(folder.join("base/flight.toml"), toml::to_string(&all).unwrap()).unwrap();
    let sweep = "format = \"doublet sweep\"\nversion = 1\nsession = \"base/flight.toml\"\n\
        [[vary]]\nsetting = \"filter.measurement_noise.alpha\"\nvalues = [0.001, 0.002, 0.004]\n";
    std::fs::write(folder.join("noise.toml"), sweep).unwrap();
}

#[test]
fn batch_as_tasks_of_gnu_parallel() {
    if Command::new("parallel").arg("--version").output().is_err() {
        println!("skipped: GNU Parallel is not here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path());
    let tasks = || {
        let mut command = Command::new("parallel");
        command.args(["--joblog", "jobs.log", "--resume", env!("CARGO_BIN_EXE_doublet-cli"), "batch", "."]);
        command.args(["--out", "table.csv", "--task", "{}/3", ":::", "1", "2", "3"]).current_dir(folder.path());
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(tasks().matches("1 of 3 runs: 1 computed").count(), 3);
    assert_eq!(tasks(), "", "every task has ended well");
    let out = folder.path().join("table.csv");
    let table = printed(&["batch", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(table.contains("3 of 3 runs: 0 computed, 3 finished before, 0 failed"), "{table}");
    let table = std::fs::read_to_string(out).unwrap();
    assert_eq!(table.lines().filter(|line| line.contains("Cm_q")).count(), 3, "{table}");
}

#[test]
fn diff_of_a_session_and_its_sweep_names_the_setting_and_judges_the_derivatives() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path());
    let first = folder.path().join("base/flight.toml");
    let second = folder.path().join("base/other.toml");
    let mut other: toml::Table = toml::from_str(&std::fs::read_to_string(&first).unwrap()).unwrap();
    other["manoeuvre"].as_array_mut().unwrap()[0]["start_s"] =
        toml::Value::Float(other["manoeuvre"].as_array().unwrap()[0]["start_s"].as_float().unwrap() + 2.0);
    let noise = toml::from_str::<toml::Table>("measurement_noise = { alpha = 0.02 }").unwrap();
    other.insert("filter".into(), noise.into());
    std::fs::write(&second, toml::to_string(&other).unwrap()).unwrap();
    let [first, second] = [&first, &second].map(|path| path.to_str().unwrap());
    let outs = ["one", "two"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    let [one, two] = [&outs[0], &outs[1]];
    printed(&["run", first, "--out", one]);
    printed(&["run", second, "--out", two]);
    let table = printed(&["diff", one, two]);
    assert!(table.contains("filter.measurement_noise.alpha") && table.contains("rad"), "{table}");
    assert!(table.contains("'.start_s") && table.contains("Cm_q") && table.contains("independent"), "{table}");
    let json = document(&["diff", one, two, "--json"]);
    assert_eq!(json["settings"].as_array().unwrap().len(), 2, "{json}");
    let row = json["derivatives"].as_array().unwrap().iter().find(|row| row["name"] == "Cm_q").unwrap();
    let number = |side: &str, key: &str| row[side][key].as_f64().unwrap();
    let z = (number("second", "estimate") - number("first", "estimate"))
        / number("first", "standard_error").hypot(number("second", "standard_error"));
    assert!((row["z"].as_f64().unwrap() - z).abs() < 1e-12 * z.abs(), "{row}");
    assert!(z != 0.0 && (0.0..=1.0).contains(&row["p"].as_f64().unwrap()));
    let csv = printed(&["diff", one, two, "--csv"]);
    assert_eq!(csv.lines().next().unwrap().split(',').count(), 11);
    assert_eq!(printed(&["diff", first, first, "--settings"]).trim(), "no setting differs");
    // A session is run; its results kept on disk are the same.
    let same = document(&["diff", first, one, "--json"]);
    assert_eq!(same["settings"].as_array().unwrap().len(), 0);
    assert!(same["derivatives"].as_array().unwrap().iter().all(|row| row["z"] == 0.0), "{same}");
}

#[test]
fn a_batch_that_can_only_fail_says_so_before_it_starts_or_at_its_end() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path());
    let run = |name: &str, out: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
        let output = command.args(["batch", name, "--out", out]).current_dir(folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let sweep = std::fs::read_to_string(folder.path().join("noise.toml")).unwrap();
    let unknown = sweep.replace("filter.measurement_noise.alpha", "filter.nope");
    std::fs::write(folder.path().join("unknown.toml"), unknown).unwrap();
    let (code, printed) = run("unknown.toml", "unknown.csv");
    assert!(
        code == Some(1) && printed.contains("filter.nope") && printed.contains("unknown.toml"),
        "{code:?} {printed}"
    );
    assert!(!folder.path().join("unknown.csv").exists(), "before the first run");
    // Every run of a session whose recording is gone fails.
    let session = std::fs::read_to_string(folder.path().join("base/flight.toml")).unwrap();
    let lost = session.replace("builtin:flights", "builtin:lost");
    assert_ne!(lost, session);
    std::fs::write(folder.path().join("lost.toml"), lost).unwrap();
    let (code, printed) = run("lost.toml", "lost.csv");
    assert!(code == Some(1) && printed.contains("every run failed"), "{code:?} {printed}");
    assert!(folder.path().join("lost.csv").exists(), "the table says why");
}
