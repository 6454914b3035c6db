//! A recording of rates, forces and deflections without any measurement of the path, through every command that reads it.

use std::fmt::Write;
use std::path::Path;

use doublet_engine::stage::NO_PATH_MEASUREMENT;

use crate::common::doublet;
use crate::common::flight::{NAMES, oscillation};
use crate::shared::shared;

/// Columns that are recorded: time, forces, rates and deflections.
const RECORDED: [&str; 10] = ["t", "ax", "ay", "az", "p", "q", "r", "delta_e", "delta_a", "delta_r"];

/// Twenty seconds at 50 Hz.
fn write_recording(path: &Path) {
    let unit = |name: &str| match name {
        "t" => "time [s]".to_owned(),
        "ax" | "ay" | "az" => format!("{name} [m/s^2]"),
        _ => format!("{name} [deg/s]").replace("delta_e [deg/s]", "delta_e [deg]"),
    };
    let header: Vec<String> = RECORDED
        .iter()
        .map(|name| if name.starts_with("delta") { format!("{name} [deg]") } else { unit(name) })
        .collect();
    let mut text = header.join(",") + "\n";
    for index in 0..1000 {
        let row = oscillation(f64::from(index) / 50.0);
        let cells: Vec<String> = RECORDED
            .iter()
            .map(|name| format!("{:.5}", row[NAMES.iter().position(|other| other == name).unwrap()]))
            .collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Takes a recording from `new` to `export`; every command says in one line what is missing and none ends by a panic.
fn refused_by_every_command(recording: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording.to_str().unwrap();
    let commands: [(&[&str], i32); 6] = [
        (&["new", "--guess", recording, "-o", "a.toml"], 0),
        (&["check", "a.toml"], 3),
        (&["run", "a.toml", "--out", "results"], 1),
        (&["report", "a.toml", "--out", "report"], 1),
        (&["export", "a.toml", "--out", "models"], 1),
        (&["sensitivity", "a.toml"], 1),
    ];
    for (arguments, expected) in commands {
        let output = doublet(folder.path(), arguments);
        let printed = String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned();
        assert_eq!(output.status.code(), Some(expected), "{arguments:?}: {printed}");
        assert!(printed.lines().any(|line| line.contains(NO_PATH_MEASUREMENT)), "{arguments:?}: {printed}");
        assert!(!printed.contains("internal error") && !printed.contains("panicked"), "{arguments:?}: {printed}");
    }
    for left in ["report", "models"] {
        assert!(!folder.path().join(left).exists(), "{left}");
    }
}

#[test]
fn rates_and_forces_alone_are_refused_in_one_line_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("inertial.csv");
    write_recording(&recording);
    refused_by_every_command(&recording);
}

/// The recording that ended 20 of 36 commands by a panic.
#[test]
fn the_interleaved_recording_is_refused_in_one_line_by_every_command() {
    if let Some(recording) = shared("data/formats/tdms/interleaved.tdms") {
        refused_by_every_command(&recording);
    }
}
