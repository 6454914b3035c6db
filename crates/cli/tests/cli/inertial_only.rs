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

/// What a command says of a recording that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Said {
    /// The sentence, once, whatever the number of manoeuvres.
    Once,
    /// Nothing of it: it uses controls, settings or text alone, or asks for something else first.
    Nothing,
}

use Said::{Nothing, Once};

/// Every command that takes a session, its exit code and what it says.
const COMMANDS: [(&str, i32, Said); 41] = [
    ("check a.toml", 3, Once),
    ("run a.toml --out results", 1, Once),
    ("report a.toml --out report --format html", 1, Once),
    ("sensitivity a.toml", 1, Once),
    ("manoeuvres a.toml", 1, Once),
    ("checks a.toml", 1, Once),
    ("lags a.toml", 1, Once),
    ("live --session a.toml --wait 0.1", 0, Once),
    ("compatibility a.toml --free bias_q", 1, Once),
    ("structure a.toml", 1, Once),
    ("response a.toml --input delta_e --output q", 1, Once),
    ("loes a.toml --input delta_e --output q --form short-period", 1, Once),
    ("variants a.toml", 1, Once),
    ("monte-carlo a.toml --realisations 2", 1, Once),
    ("compare a.toml --with filters", 1, Once),
    ("fix a.toml", 1, Once),
    ("fix a.toml --apply 1", 1, Once),
    ("propose manoeuvres a.toml", 0, Nothing),
    ("propose steady a.toml", 0, Nothing),
    ("propose onsets a.toml", 0, Nothing),
    ("propose noise a.toml", 0, Nothing),
    ("match a.toml", 1, Once),
    ("qtg a.toml --tests builtin:qtg/demo --out guide --format html", 1, Once),
    ("fmu a.toml --out model.fmu", 1, Once),
    ("prior a.toml --prior prior.csv", 1, Once),
    ("linear a.toml", 1, Once),
    ("modes a.toml", 1, Once),
    ("qualities a.toml", 1, Once),
    ("design a.toml", 1, Once),
    ("enough a.toml", 1, Once),
    ("propagate a.toml -Cm_alpha", 1, Once),
    ("export a.toml --out models", 1, Once),
    ("diff a.toml a.toml", 1, Once),
    ("diff a.toml a.toml --settings", 0, Nothing),
    ("batch a.toml --out table.csv", 1, Once),
    ("coverage a.toml --realisations 2", 1, Nothing),
    ("calibrate a.toml --realisations 2", 1, Nothing),
    ("campaign builtin:c337f --session a.toml --out cards --format html", 1, Once),
    ("tune a.toml", 1, Once),
    ("tune a.toml --delay alpha", 1, Once),
    ("debrief . --session a.toml", 1, Nothing),
];

/// Takes a recording through `new` and every command with a session; each says once what is missing and none ends by a panic.
fn refused_by_every_command(recording: &Path) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("prior.csv"), "name,mean,std error\nCm_alpha,-1,0.2\n").unwrap();
    let printed_by = |arguments: &[&str]| {
        let output = doublet(folder.path(), arguments);
        let printed = String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned();
        assert!(!printed.contains("internal error") && !printed.contains("panicked"), "{arguments:?}: {printed}");
        (output.status.code(), printed)
    };
    let (code, printed) = printed_by(&["new", "--guess", recording.to_str().unwrap(), "-o", "a.toml"]);
    assert_eq!(code, Some(0), "{printed}");
    assert!(printed.lines().any(|line| line.contains(NO_PATH_MEASUREMENT)), "{printed}");
    let mut faults = Vec::new();
    for (command, expected, said) in COMMANDS {
        let (code, printed) = printed_by(&command.split(' ').collect::<Vec<_>>());
        let count = printed.matches(NO_PATH_MEASUREMENT).count();
        if code != Some(expected) || count != usize::from(said == Once) {
            faults.push(format!("{command}: exit code {code:?}, said {count} times: {printed}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for left in ["results", "report", "models", "guide", "model.fmu"] {
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
