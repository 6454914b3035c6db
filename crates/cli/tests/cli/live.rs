//! `doublet live` on a recording: a line of JSON an update, what it takes, and the session it leaves.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

use crate::common;
use crate::common::flight;
use common::doublet;
use serde_json::Value;

#[test]
fn a_file_is_watched_line_by_line_and_leaves_a_session() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 3000, |_, _| {});
    let arguments = ["live", "--file", "flight.csv", "--session", "session.toml", "--speed", "max", "--json"];
    let with = ["--wait", "0.1", "--limit", "p=:0.05", "--limit", "n_z=0:3", "--goal", "50", "--record", "kept"];
    let output = doublet(folder.path(), &[&arguments[..], &with].concat());
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}");
    let lines: Vec<Value> =
        String::from_utf8(output.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    // Thirty seconds in steps of half a second, less the first second and the latency.
    assert!((50..=60).contains(&lines.len()), "{} lines", lines.len());
    let times: Vec<f64> = lines.iter().map(|line| line["time_s"].as_f64().unwrap()).collect();
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]) && (times.last().unwrap() - 29.99).abs() < 1e-9);
    let last = lines.last().unwrap();
    assert_eq!((&last["counts"]["samples"], &last["counts"]["lost"]), (&Value::from(2999), &Value::from(0)));
    let names: Vec<&str> =
        last["derivatives"].as_array().unwrap().iter().map(|derivative| derivative["name"].as_str().unwrap()).collect();
    let asked =
        ["CX_alpha", "CY_beta", "CZ_alpha", "Cl_p", "Cl_delta_a", "Cm_alpha", "Cm_delta_e", "Cn_beta", "Cn_delta_r"];
    assert_eq!(names, asked);
    assert!(last["derivatives"][0]["standard_error"].as_f64().unwrap() > 0.0);
    let limits: Vec<&str> =
        last["limits"].as_array().unwrap().iter().map(|limit| limit["level"].as_str().unwrap()).collect();
    assert_eq!(limits, ["bad", "good"]);
    assert!(last["correlation"]["correlation"].as_f64().unwrap().abs() <= 1.0);
    let checked = doublet(folder.path(), &["check", "kept/session.toml", "--json"]);
    let document: Value = serde_json::from_slice(&checked.stdout).unwrap();
    assert!(document["findings"].is_array(), "{document}");
    assert!(std::fs::read_to_string(folder.path().join("kept/flight.csv")).unwrap().lines().count() == 3001);
    let again = doublet(folder.path(), &[&arguments[..], &with].concat());
    assert!(!again.status.success() && String::from_utf8_lossy(&again.stderr).contains("exists"));
}

#[test]
fn speed_paces_a_recording_by_its_own_time() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 1000, |_, _| {});
    let start = std::time::Instant::now();
    let arguments =
        ["live", "--file", "flight.csv", "--session", "session.toml", "--speed", "10", "--wait", "0.1", "--json"];
    let output = doublet(folder.path(), &arguments);
    assert!(output.status.success());
    // Ten seconds at ten times real time.
    assert!(start.elapsed().as_secs_f64() > 0.95, "{:?}", start.elapsed());
}

/// Two seconds of a flight flown again at its own speed, then Ctrl-C.
#[cfg(unix)]
#[test]
fn interrupted_recording_ends_as_a_session() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 3000, |_, _| {});
    let arguments = ["live", "--session", "session.toml", "--speed", "1", "--json", "--record", "kept"];
    let mut running = Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
        .args(arguments)
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(running.stdout.take().unwrap()).lines();
    let first: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
    let killed = Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let last = lines.map_while(Result::ok).last();
    let output = running.wait_with_output().unwrap();
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && printed.contains("session: "), "{printed}");
    // It ended long before the thirty seconds of the flight, and what came opens.
    let last = last.map_or(first, |line| serde_json::from_str(&line).unwrap());
    assert!(last["time_s"].as_f64().unwrap() < 25.0, "{last}");
    let checked = doublet(folder.path(), &["check", "kept/session.toml", "--json"]);
    let document: Value = serde_json::from_slice(&checked.stdout).unwrap();
    assert!(document["findings"].is_array(), "{document}");
}

/// Updates of the doubled flight that may have findings: one for each kind of fault, and the first.
const MOST_WITH_FINDINGS: u64 = 6;

/// Rows of the flight out of order, doubled and with stray stamps, and then its clock begins anew.
#[test]
fn doubled_exchanged_and_stray_rows_are_counted_and_a_session_is_written() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 2000, |_, _| {});
    let text = std::fs::read_to_string(folder.path().join("flight.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let second: Vec<String> = lines[1..].to_vec();
    lines.insert(500, lines[500].clone());
    lines.swap(300, 301);
    lines.insert(700, format!("1e9,{}", lines[700].split_once(',').unwrap().1));
    lines.extend(second);
    std::fs::write(folder.path().join("flight.csv"), lines.join("\n") + "\n").unwrap();
    let (last, printed) = watched(folder.path(), &["--file", "flight.csv", "--wait", "0.1", "--record", "kept"]);
    let count = |name: &str| last["counts"][name].as_u64().unwrap();
    assert_eq!((count("doubled"), count("stray"), count("late"), count("restarts")), (1, 1, 0, 1), "{last}");
    assert_eq!((count("reordered"), count("clock_restarts")), (1, 1), "{last}");
    // Twenty seconds, a pause of one second, twenty seconds again.
    assert!((last["time_s"].as_f64().unwrap() - 40.98).abs() < 1e-6, "{last}");
    assert!(last["findings"].to_string().contains("clock restarts in the stream: 1"), "{last}");
    // A finding is in the update in which something changed, not in those after it.
    let [updates, with_findings] = ["updates", "updates_with_findings"].map(|name| last[name].as_u64().unwrap());
    println!("{with_findings} of {updates} updates have findings");
    assert!(updates > 70 && (1..=MOST_WITH_FINDINGS).contains(&with_findings), "{with_findings} of {updates} updates");
    assert!(printed.contains("session: "), "{printed}");
    let rows = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap().lines().count();
    assert_eq!((rows("kept/flight.csv"), rows("kept/restart_1/flight.csv")), (2001, 2001));
    let session = std::fs::read_to_string(folder.path().join("kept/session.toml")).unwrap();
    assert!(session.contains("name = \"live\"") && session.contains("name = \"live 2\""), "{session}");
    let checked = doublet(folder.path(), &["check", "kept/session.toml", "--json"]);
    let document = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(!document.contains("repeats the stamp"), "{document}");
}

/// Watches with the settings of the flight to the end: the last update with the findings of all, and what was said beside.
fn watched(folder: &std::path::Path, with: &[&str]) -> (Value, String) {
    let output = doublet(folder, &[&["live", "--session", "session.toml", "--json"], with].concat());
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{printed}");
    (last_with_findings(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned)), printed)
}

/// The last update with the findings of all, the number of updates and of those with findings.
fn last_with_findings(lines: impl Iterator<Item = String>) -> Value {
    let (mut last, mut findings, mut updates, mut with_findings) = (Value::Null, Vec::new(), 0_u64, 0_u64);
    for line in lines {
        last = serde_json::from_str(&line).unwrap();
        let own = last["findings"].as_array().unwrap();
        (updates, with_findings) = (updates + 1, with_findings + u64::from(!own.is_empty()));
        findings.extend(own.iter().cloned());
    }
    last["findings"] = findings.into();
    last["updates"] = Value::from(updates);
    last["updates_with_findings"] = Value::from(with_findings);
    last
}

/// A file that may not grow beyond 32 kB stands for a full disk.
#[cfg(unix)]
#[test]
fn full_disk_ends_the_recording_and_not_the_watching() {
    use std::process::Command;
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 1000, |_, _| {});
    let program = env!("CARGO_BIN_EXE_doublet-cli");
    let live = format!(
        "trap '' XFSZ; ulimit -f 64; '{program}' live --file flight.csv --session session.toml --json --wait 0.1 \
         --record kept | cat"
    );
    let output = Command::new("sh").args(["-c", &live]).current_dir(folder.path()).output().unwrap();
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    let last = String::from_utf8_lossy(&output.stdout).lines().last().map(str::to_owned).unwrap();
    let last: Value = serde_json::from_str(&last).unwrap();
    assert!((last["time_s"].as_f64().unwrap() - 9.99).abs() < 1e-6, "{last}");
    assert!(last["alarms"].to_string().contains("recording stopped, estimation continues"), "{last}");
    assert!(printed.contains("error: recording stopped") && printed.contains("session: "), "{printed}");
    let kept = std::fs::read_to_string(folder.path().join("kept/flight.csv")).unwrap();
    assert!(kept.ends_with('\n') && kept.lines().all(|line| line.split(',').count() == 17));
}

/// The file is removed while it is followed; then another takes its place.
#[cfg(unix)]
#[test]
fn removed_file_ends_after_the_wait_and_a_replaced_one_is_followed() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    for is_replaced in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        flight::write(folder.path(), 2000, |_, _| {});
        let path = folder.path().join("flight.csv");
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        std::fs::write(&path, lines[..1001].join("\n") + "\n").unwrap();
        let start = std::time::Instant::now();
        let mut running = Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
            .args(["live", "--file", "flight.csv", "--session", "session.toml", "--json", "--wait", "2"])
            .args(["--record", "kept"])
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut updates = BufReader::new(running.stdout.take().unwrap()).lines();
        updates.next().unwrap().unwrap();
        std::fs::remove_file(&path).unwrap();
        if is_replaced {
            std::fs::write(&path, [&lines[..1], &lines[1001..]].concat().join("\n") + "\n").unwrap();
        }
        let last = last_with_findings(updates.map_while(Result::ok));
        let output = running.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(start.elapsed().as_secs_f64() < 30.0, "{:?}", start.elapsed());
        let expected_s = if is_replaced { 19.99 } else { 9.99 };
        assert!((last["time_s"].as_f64().unwrap() - expected_s).abs() < 1e-6, "{is_replaced}: {last}");
        assert_eq!(last["findings"].to_string().contains("it was restarted 1 times"), is_replaced, "{last}");
        assert!(folder.path().join("kept/session.toml").exists());
    }
}

#[test]
fn packets_of_other_addresses_are_left_out() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    for (others, is_heard) in [(&["--from", "127.0.0.3"][..], false), (&["--from", "127.0.0.1"], true)] {
        let folder = tempfile::tempdir().unwrap();
        let mut running = Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
            .args(["live", "--udp", "127.0.0.1:0", "--from", "127.0.0.2", "--for", "2", "--record", "kept"])
            .args(others)
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut printed = BufReader::new(running.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("listening at ") {
            line.clear();
            assert!(printed.read_line(&mut line).unwrap() > 0);
        }
        let address = line.trim().rsplit(' ').next().unwrap().to_owned();
        let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
        for k in 0..100 {
            socket.send_to(format!("{{\"time\": {}, \"p\": 0}}", 0.1 * f64::from(k)).as_bytes(), &address).unwrap();
        }
        running.wait().unwrap();
        let mut rest = String::new();
        printed.read_to_string(&mut rest).unwrap();
        assert_eq!(rest.contains("nothing was recorded"), !is_heard, "{others:?}: {rest}");
    }
}

/// A full device is an error in one line; a reader that has left is not.
#[cfg(target_os = "linux")]
#[test]
fn output_that_is_not_taken_ends_with_exit_code_1() {
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 500, |_, _| {});
    let live = ["live", "--file", "flight.csv", "--session", "session.toml", "--wait", "0.1", "--record", "kept"];
    for arguments in [&["inspect", "flight.csv", "--json"][..], &["inspect", "flight.csv"], &live] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let run = |output: Stdio| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
            command.args(arguments).current_dir(folder.path()).stdout(output).stderr(Stdio::piped());
            command.spawn().unwrap()
        };
        let output = run(full.into()).wait_with_output().unwrap();
        let printed = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {printed}");
        let errors: Vec<&str> = printed.lines().filter(|line| line.starts_with("error")).collect();
        assert!(errors.len() == 1 && errors[0].contains("the output is incomplete"), "{printed}");
        if arguments[0] == "inspect" {
            let mut closed = run(Stdio::piped());
            drop(closed.stdout.take());
            let output = closed.wait_with_output().unwrap();
            assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        }
    }
    assert!(folder.path().join("kept/session.toml").exists());
}
