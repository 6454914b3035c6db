//! Files that are none: pipes, devices and what fills the memory, given to every command that reads a file.

#![cfg(unix)]
use crate::common::chain;
use crate::common::flight;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Every refusal takes milliseconds; reading a pipe that nobody writes takes for ever.
const PATIENCE: Duration = Duration::from_secs(20);

/// Runs the program and gives its exit code and what it said; ends it when it takes too long.
fn doublet(arguments: &[&str], environment: &[(&str, &str)]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
    command.args(arguments).envs(environment.iter().copied()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (output.status.code(), printed)
}

/// `DOUBLET_CHAIN_RUNS` says how many recordings, `DOUBLET_CHAIN_SEED` the seed of the first.
#[test]
fn changed_recordings_go_through_the_whole_program_without_a_panic() {
    let chain = chain::Chain::of_environment(6);
    let reached = chain.run();
    println!(
        "{} recordings, {} sessions checked, {} results, {} faults",
        chain.runs,
        reached.sessions,
        reached.results,
        reached.faults.len()
    );
    assert!(reached.faults.is_empty(), "{}", reached.faults.join("\n"));
}

/// A path as measured has no innovations, and its tables had rows of two lengths.
#[test]
fn a_measured_path_has_histories_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 400, |_, _| {});
    let session = folder.path().join("session.toml");
    let text = std::fs::read_to_string(&session).unwrap();
    std::fs::write(&session, text.replace("[preparation]\n", "[preparation]\npath = \"measured\"\n")).unwrap();
    let out = folder.path().join("results");
    let forms = ["run", session.to_str().unwrap(), "--out", out.to_str().unwrap(), "--histories", "csv,parquet,mat"];
    let (code, printed) = doublet(&forms, &[]);
    assert!(matches!(code, Some(0 | 3)), "{code:?} {printed}");
}

fn sparse(folder: &Path) -> PathBuf {
    let path = folder.join("large.toml");
    std::fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
    path
}

#[test]
fn pipes_devices_and_large_files_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let out = folder.path().join("out");
    let (out, table) = (out.to_str().unwrap(), folder.path().join("table.csv"));
    let session = folder.path().join("new.toml");
    let session = session.to_str().unwrap();
    let large = sparse(folder.path());
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/flights/demo/pod.csv");
    for (file, reason) in [(pipe.to_str().unwrap(), "pipe"), ("/dev/zero", "device"), (large.to_str().unwrap(), "MB")] {
        let commands: [&[&str]; 10] = [
            &["check", file],
            &["run", file, "--out", out],
            &["report", file, "--out", out],
            &["export", file, "--out", out],
            &["batch", file, "--out", table.to_str().unwrap()],
            &["sensitivity", file],
            &["diff", file, file],
            &["datcom", file],
            &["new", recording, "--output", session, "--map", file],
            &["inspect", recording, "--map", file],
        ];
        for arguments in commands {
            let begun = Instant::now();
            let (code, printed) = doublet(arguments, &[]);
            assert!(begun.elapsed() < PATIENCE, "{arguments:?} hangs");
            assert!(
                code.is_some_and(|code| code != 0) && printed.contains(reason),
                "{arguments:?}: {code:?} {printed}"
            );
        }
    }
    assert!(!Path::new(out).exists());
}

/// It waited for ever, whatever `--for` said.
#[test]
fn a_pipe_is_no_telemetry_log() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (code, printed) = doublet(&["live", "--mavlink", pipe.to_str().unwrap(), "--for", "1"], &[]);
    assert!(code == Some(1) && printed.contains("pipe"), "{code:?} {printed}");
}

#[test]
fn a_built_in_aircraft_needs_no_folder_of_the_user() {
    let folder = tempfile::tempdir().unwrap();
    let blocked = folder.path().join("no_folder");
    std::fs::write(&blocked, "").unwrap();
    let blocked = blocked.to_str().unwrap();
    let temporary = folder.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let at =
        ["--rpm", "2400", "--manifold-inhg", "24", "--altitude-ft", "5000", "--oat-c", "5", "--airspeed-kt", "130"];
    let aircraft = [&["engine", "c337f"][..], &at].concat();
    let found: Vec<_> = [("XDG_CACHE_HOME", blocked), ("HOME", blocked)]
        .iter()
        .map(|(name, value)| {
            let mut environment = vec![("TMPDIR", temporary.to_str().unwrap()), (*name, *value)];
            if *name == "HOME" {
                environment.push(("XDG_CACHE_HOME", value));
            }
            doublet(&aircraft, &environment)
        })
        .collect();
    for (code, printed) in &found {
        assert!(*code == Some(0) && printed.contains("thrust"), "{code:?} {printed}");
    }
    let left = std::fs::read_dir(&temporary).unwrap().filter(|entry| entry.as_ref().unwrap().path().is_dir()).count();
    assert_eq!(left, 0, "no folder stays behind");
}

/// Bytes of every file in a folder, and where its links lead.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match (std::fs::read_link(&entry), entry.is_dir()) {
            (Ok(to), _) => found.push((entry, to.into_os_string().into_encoded_bytes())),
            (_, true) => found.extend(contents(&entry)),
            (_, false) => found.push((entry.clone(), std::fs::read(&entry).unwrap())),
        }
    }
    found.sort();
    found
}

/// Commands that write a file or a folder.
const WRITERS: [&[&str]; 11] = [
    &["regress", "flight.csv", "--y", "az", "--terms", "alpha", "--out"],
    &["response", "flight.csv", "--input", "delta_e", "--output", "q", "--out"],
    &["response", "session.toml", "--input", "delta_e", "--output", "q", "--out"],
    &["linear", "session.toml", "--out"],
    &["fmu", "session.toml", "--out"],
    &["fix", "session.toml", "--apply", "1", "--output"],
    &["compare", "session.toml", "--with", "noise", "--output"],
    &["batch", "session.toml", "--out"],
    &["new", "flight.csv", "--map", "map.toml", "--output"],
    &["map", "flight.csv", "--write"],
    &["run", "session.toml", "--out"],
];

#[test]
fn what_a_command_reads_is_never_what_it_writes() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 400, |_, _| {});
    std::os::unix::fs::symlink("flight.csv", folder.path().join("link.csv")).unwrap();
    std::fs::create_dir(folder.path().join("kept")).unwrap();
    std::fs::write(folder.path().join("kept/notes.txt"), "mine").unwrap();
    std::os::unix::fs::symlink("kept", folder.path().join("folder")).unwrap();
    let before = contents(folder.path());
    let written_by = |writer: &[&str], target: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
        let output = command.args(writer).arg(target).current_dir(folder.path()).stdin(Stdio::null()).output().unwrap();
        let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
        (output.status.code(), text)
    };
    for writer in WRITERS {
        for target in ["flight.csv", "./flight.csv", "link.csv", "map.toml", "folder", ".", "-", "map.toml/x"] {
            // A table of rows may replace a file that the command knows nothing of.
            if writer[1] == "flight.csv" && target == "map.toml" && ["regress", "response"].contains(&writer[0]) {
                continue;
            }
            let (code, printed) = written_by(writer, target);
            assert!(matches!(code, Some(1 | 2)), "{writer:?} {target}: {code:?} {printed}");
            assert!(!printed.contains("panicked") && printed.contains(target), "{writer:?} {target}: {printed}");
            assert!(before == contents(folder.path()), "{writer:?} {target}: {printed}");
        }
    }
    let (_, printed) = written_by(WRITERS[0], "flight.csv");
    assert_eq!(printed.trim(), "error: flight.csv is read by this command: choose another name");
    let (_, printed) = written_by(WRITERS[7], "table.txt");
    assert_eq!(printed.trim(), "error: table.txt: give the table the ending .parquet or .csv");
    assert!(before == contents(folder.path()), "nothing is computed for a table that cannot be written");
}

#[test]
fn a_link_to_a_file_that_does_not_exist_yet_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 400, |_, _| {});
    let (link, place) = (folder.path().join("link.csv"), folder.path().join("rows.csv"));
    std::os::unix::fs::symlink("rows.csv", &link).unwrap();
    let table = folder.path().join("flight.csv");
    let regress =
        ["regress", table.to_str().unwrap(), "--y", "az", "--terms", "alpha", "--out", link.to_str().unwrap()];
    for _ in 0..2 {
        let (code, printed) = doublet(&regress, &[]);
        assert_eq!(code, Some(0), "{printed}");
        assert_eq!(std::fs::read_link(&link).unwrap(), Path::new("rows.csv"));
        assert!(std::fs::read_to_string(&place).unwrap().starts_with("row,measured,fitted,residual\n"));
    }
}
