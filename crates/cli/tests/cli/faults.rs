//! File operations and large allocations that fail, each in turn, and a loss of power after each operation: what the user had stays whole,
//! and what went wrong is said in one line. `tests/soak/faults.c` and `allocations.c` let them fail. `DOUBLET_FAULTS=all` takes every operation,
//! otherwise one of each kind.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use doublet_engine::session;

use crate::common::disk::{Disk, Files, MODELS};
use crate::common::{doublet, flight, root};

/// Error numbers of Linux: input/output error, no space left.
const EIO: i32 = 5;
const ENOSPC: i32 = 28;
/// What may be returned: success, one line, findings.
const CODES: [i32; 3] = [0, 1, 3];
/// Samples of the flight at 100 Hz.
const SAMPLES: u32 = 100;

/// The program that lets operations fail; none where there is no compiler or tracing is forbidden.
static TRACER: LazyLock<Option<(tempfile::TempDir, PathBuf)>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("faults");
    let compiled =
        Command::new("cc").args(["-O1", "-o"]).arg(&program).arg(root().join("tests/soak/faults.c")).output().ok()?;
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let log = folder.path().join("log");
    let tried = Command::new(&program).arg(folder.path()).arg(&log).args(["none", "0", "0", "true"]).status().ok()?;
    (tried.code() == Some(0)).then_some((folder, program))
});

/// The library that lets allocations fail; none where there is no compiler.
static ALLOCATIONS: LazyLock<Option<(tempfile::TempDir, PathBuf)>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("allocations.so");
    let source = root().join("tests/soak/allocations.c");
    let compiled =
        Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).output().ok()?;
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    Some((folder, library))
});

/// A command and what it writes: a file or a folder.
struct Case {
    name: &'static str,
    arguments: &'static [&'static str],
    target: &'static str,
}

const CASES: [Case; 5] = [
    Case { name: "save", arguments: &["propose", "windows", "save.toml", "--apply"], target: "save.toml" },
    Case { name: "run", arguments: &["run", "new.toml", "--out", "results"], target: "results" },
    Case {
        name: "report",
        arguments: &["report", "new.toml", "--out", "report", "--format", "html"],
        target: "report",
    },
    Case { name: "export", arguments: &["export", "new.toml", "--out", "models"], target: "models" },
    LIVE,
];

impl Case {
    /// Whether it replaces results.
    fn has_results(&self) -> bool {
        ["run", "report", "export"].contains(&self.name)
    }

    /// The folder it begins in.
    fn template(&self) -> &'static Path {
        if self.has_results() { RESULTS.path() } else { FLIGHT.path() }
    }
}

/// A recording in a new folder.
const LIVE: Case = Case {
    name: "live",
    arguments: &[
        "live", "--file", "flight.csv", "--map", "map.toml", "--aircraft", "attas_vfw614", "--wait", "0.2", "--record",
        "day", "--json",
    ],
    target: "day",
};

static FLIGHT: LazyLock<tempfile::TempDir> = LazyLock::new(|| flight_of(SAMPLES));

/// A folder with a flight and two sessions of it.
fn flight_of(samples: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    flight::write(place, samples, |_, _| {});
    let text = std::fs::read_to_string(place.join("session.toml")).unwrap();
    std::fs::write(place.join("new.toml"), text.replace("\"long\"", "\"new\"").replace("ax = 0.02", "ax = 0.05"))
        .unwrap();
    std::fs::write(place.join("save.toml"), text.replace("flight.csv", "doublet.csv")).unwrap();
    std::fs::write(place.join("doublet.csv"), one_manoeuvre()).unwrap();
    std::fs::rename(place.join("session.toml"), place.join("old.toml")).unwrap();
    folder
}

/// Thirty seconds at 20 Hz with one manoeuvre, which `propose` finds.
fn one_manoeuvre() -> String {
    let rest = flight::oscillation(0.0);
    let row = |index: u32| {
        let t = f64::from(index) / 20.0;
        let part = if (15.0..19.0).contains(&t) { 2.0 } else { 0.0 };
        let moved = flight::oscillation(t);
        let value = |column: usize| rest[column] + part * (moved[column] - rest[column]) + 0.01 * (37.0 * t).sin();
        let cells: Vec<String> = (1..rest.len()).map(|column| format!("{:.5}", value(column))).collect();
        format!("{t},{}\n", cells.join(","))
    };
    flight::NAMES.join(",") + "\n" + &(0..600).map(row).collect::<String>()
}

/// The same with what the older session gave, beside files of the user.
static RESULTS: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = copied(FLIGHT.path());
    add_old_results(folder.path(), CASES.iter().filter(|case| case.has_results()));
    folder
});

/// What the older session gives of some cases, with a file of the user in each folder.
fn add_old_results<'a>(place: &Path, cases: impl Iterator<Item = &'a Case>) {
    for case in cases {
        let old: Vec<&str> =
            case.arguments.iter().map(|one| if *one == "new.toml" { "old.toml" } else { one }).collect();
        let output = doublet(place, &old);
        assert!(output.status.success() || output.status.code() == Some(3), "{}", said(&output));
        std::fs::write(place.join(case.target).join("notes.txt"), "of the user").unwrap();
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// All files below a folder, but for locks and what a failed writer leaves for the next one to remove.
fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(place) = pending.pop() {
        let Ok(entries) = std::fs::read_dir(&place) else { continue };
        for entry in entries.map(Result::unwrap) {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if name.starts_with('.') {
                continue;
            }
            if path.is_dir() {
                pending.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// A copy of a folder.
fn copied(template: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (path, bytes) in files(template) {
        let place = folder.path().join(path);
        std::fs::create_dir_all(place.parent().unwrap()).unwrap();
        std::fs::write(place, bytes).unwrap();
    }
    folder
}

/// Runs a case in a copy of the template, where the `which`-th operation of a kind, or all from it on, fail: the folder, the output and
/// the lines of the log.
fn traced(case: &Case, (kind, which, error): (&str, &str, i32)) -> (tempfile::TempDir, Output, Vec<Vec<String>>) {
    let (_, program) = TRACER.as_ref().unwrap();
    let folder = copied(case.template());
    let place = folder.path().canonicalize().unwrap();
    let logs = tempfile::tempdir().unwrap();
    let log = logs.path().join("log");
    let output = Command::new(program)
        .arg(&place)
        .arg(&log)
        .args([kind, which, &error.to_string(), env!("CARGO_BIN_EXE_doublet-cli")])
        .args(case.arguments)
        .current_dir(&place)
        .output()
        .unwrap();
    let mut lines: Vec<Vec<String>> = std::fs::read_to_string(&log)
        .unwrap()
        .lines()
        .map(|line| line.split('\t').map(|part| part.replace(&format!("{}/", place.display()), "")).collect())
        .collect();
    // The content of a file when it was synced stands in the place of the number of its copy.
    for line in lines.iter_mut().filter(|line| line[0] == "sync" && line[2] != "-1") {
        let bytes = std::fs::read(logs.path().join("log.d").join(&line[2])).unwrap_or_default();
        line[2] = String::from_utf8_lossy(&bytes).into_owned();
    }
    (folder, output, lines)
}

/// Files of a case: the target alone, or all below it.
fn of_target(case: &Case, folder: &Path) -> Files {
    let target = folder.join(case.target);
    if target.is_file() {
        return Files::from([(PathBuf::new(), std::fs::read(target).unwrap())]);
    }
    files(&target)
}

/// Whether a recording that was stopped is whole as far as it goes.
fn is_whole_recording(day: &Path) -> Result<(), String> {
    let place = day.join("session.toml");
    if place.exists() {
        let opened = session::open(&place).map_err(|error| error.to_string())?;
        let paths = opened.session.flights.iter().flat_map(|flight| &flight.recordings);
        let absent = paths.map(|one| opened.folder.join(&one.path)).find(|path| !path.exists());
        absent.map_or(Ok(()), |path| Err(format!("{} is absent", path.display())))?;
    }
    Ok(())
}

/// What is wrong after an operation has failed.
fn fault(case: &Case, (old, new): (&Files, &Files), (folder, output): (&Path, &Output)) -> Result<(), String> {
    let text = said(output);
    let code =
        output.status.code().filter(|code| CODES.contains(code)).ok_or_else(|| format!("{}: {text}", output.status))?;
    if text.contains("internal error") || text.contains("panicked") {
        return Err(text);
    }
    let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error")).collect();
    if code == 1 && (errors.len() != 1 || !errors[0].contains(case.target)) {
        return Err(format!("the file is not named in one line: {text}"));
    }
    if case.name == "live" {
        return is_whole_recording(&folder.join(case.target));
    }
    let found = of_target(case, folder);
    if found != *new && (code != 1 || found != *old) {
        let differing = |other: &Files| {
            let paths = found.keys().chain(other.keys());
            paths.filter(|path| found.get(*path) != other.get(*path)).cloned().collect::<Vec<_>>()
        };
        return Err(format!("code {code}, not the old ({:?}), not the new ({:?})", differing(old), differing(new)));
    }
    Ok(())
}

/// Numbers of the operations that fail: all, or the one in the middle.
fn chosen(count: usize) -> Vec<usize> {
    let are_all = std::env::var("DOUBLET_FAULTS").is_ok_and(|which| which == "all");
    if are_all { (1..=count).collect() } else { (count > 0).then_some(count.div_ceil(2)).into_iter().collect() }
}

#[test]
fn an_operation_that_fails_leaves_the_old_session_or_the_new_and_one_line() {
    let_operations_fail(|case| !case.has_results());
}

#[test]
fn an_operation_that_fails_leaves_the_old_results_or_the_new_and_one_line() {
    let_operations_fail(Case::has_results);
}

fn let_operations_fail(is_wanted: impl Fn(&Case) -> bool) {
    if TRACER.is_none() {
        println!("skipped: no C compiler, or no process may be traced here");
        return;
    }
    let mut faults = Vec::new();
    for case in CASES.iter().filter(|case| is_wanted(case)) {
        let old = of_target(case, case.template());
        let (folder, output, log) = traced(case, ("none", "0", 0));
        assert!(output.status.code().is_some_and(|code| CODES.contains(&code)), "{}", said(&output));
        let new = of_target(case, folder.path());
        assert!(old != new, "{}: {}", case.name, said(&output));
        let counts =
            log.iter().filter(|line| line[0] == "count").map(|line| (line[1].as_str(), line[2].parse().unwrap()));
        for (kind, count) in counts.filter(|(kind, _)| *kind != "remove") {
            let numbers = chosen(count);
            for number in &numbers {
                for (which, error) in [(format!("{number}"), EIO), (format!("{number}+"), ENOSPC)] {
                    let (folder, output, _) = traced(case, (kind, &which, error));
                    if let Err(line) = fault(case, (&old, &new), (folder.path(), &output)) {
                        faults.push(format!("{}, {kind} {which}: {line}", case.name));
                    }
                }
            }
            println!(
                "{}: {} of {count} operations '{kind}' failed, alone and with all after it",
                case.name,
                numbers.len()
            );
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// From how many bytes on an allocation is large: a short flight has few of 1 MB.
const LARGE_BYTES: usize = 32_768;
/// The same of a longer flight.
const LARGE_BYTES_LONG: usize = 1 << 20;
/// Samples of the longer flight at 100 Hz.
const SAMPLES_LONG: u32 = 10_000;

/// Runs a case in a copy of the template, where the `which`-th allocation of so many bytes and more fails, none for 0: the folder, the
/// output and the number of these allocations where the program came to its end.
fn starved(case: &Case, (template, bytes): (&Path, usize), which: usize) -> (tempfile::TempDir, Output, Option<usize>) {
    let (_, library) = ALLOCATIONS.as_ref().unwrap();
    let folder = copied(template);
    let counted = tempfile::NamedTempFile::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
        .args(case.arguments)
        .env("LD_PRELOAD", library)
        .env("DOUBLET_FAIL_ALLOCATION", which.to_string())
        .env("DOUBLET_LARGE_ALLOCATION", bytes.to_string())
        .env("DOUBLET_ALLOCATIONS", counted.path())
        .current_dir(folder.path())
        .output()
        .unwrap();
    let count = std::fs::read_to_string(counted.path()).unwrap().trim().parse().ok();
    (folder, output, count)
}

/// Rust ends a program whose allocation fails: with one line and the signal SIGABRT. No file of the user is damaged.
#[test]
fn a_large_allocation_that_fails_leaves_the_old_session_or_the_new() {
    CASES
        .iter()
        .filter(|case| !case.has_results())
        .for_each(|case| let_allocations_fail(case, case.template(), LARGE_BYTES));
}

#[test]
fn a_large_allocation_that_fails_leaves_the_old_results_or_the_new() {
    CASES
        .iter()
        .filter(|case| case.has_results())
        .for_each(|case| let_allocations_fail(case, case.template(), LARGE_BYTES));
}

/// Each large allocation of `run` over a hundred seconds of flight.
#[test]
fn an_allocation_of_1_mb_that_fails_leaves_the_old_results_or_the_new() {
    let folder = flight_of(SAMPLES_LONG);
    let case = CASES.iter().find(|case| case.name == "run").unwrap();
    add_old_results(folder.path(), std::iter::once(case));
    let_allocations_fail(case, folder.path(), LARGE_BYTES_LONG);
}

fn let_allocations_fail(case: &Case, template: &Path, bytes: usize) {
    use std::os::unix::process::ExitStatusExt;
    const SIGABRT: i32 = 6;
    if ALLOCATIONS.is_none() {
        println!("skipped: no C compiler");
        return;
    }
    let starved = |which| starved(case, (template, bytes), which);
    let old = of_target(case, template);
    let (folder, output, count) = starved(0);
    let (new, count) = (of_target(case, folder.path()), count.unwrap_or_else(|| panic!("{}", said(&output))));
    assert!(count > 0 || !case.has_results(), "{}: nothing was let fail", case.name);
    let numbers = chosen(count);
    let (mut faults, mut ended) = (Vec::new(), 0);
    for number in &numbers {
        let (folder, output, _) = starved(*number);
        let text = said(&output);
        let is_ended = output.status.signal() == Some(SIGABRT);
        ended += usize::from(is_ended);
        let found = of_target(case, folder.path());
        let is_whole = if case.name == "live" {
            is_whole_recording(&folder.path().join(case.target))
        } else {
            (found == old || found == new).then_some(()).ok_or_else(|| "neither the old nor the new".to_owned())
        };
        let is_said = is_ended && text.contains("memory allocation of")
            || output.status.code().is_some_and(|code| CODES.contains(&code));
        if let (Err(line), _) | (Ok(()), Some(line)) = (is_whole, (!is_said).then_some(text)) {
            faults.push(format!("{}, allocation {number}: {}: {line}", case.name, output.status));
        }
    }
    println!(
        "{}: {} of {count} allocations of {bytes} bytes and more failed, {ended} ended the program",
        case.name,
        numbers.len()
    );
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn a_loss_of_power_at_any_operation_leaves_the_old_session_or_the_new_one() {
    if TRACER.is_none() {
        println!("skipped: no C compiler, or no process may be traced here");
        return;
    }
    let (folder, output, log) = traced(&CASES[0], ("none", "0", 0));
    assert!(output.status.success(), "{}", said(&output));
    let new = std::fs::read_to_string(folder.path().join("save.toml")).unwrap();
    let before = files(FLIGHT.path());
    let old = String::from_utf8(before[Path::new("save.toml")].clone()).unwrap();
    let mut disk = Disk::of(&before, &folder.path().canonicalize().unwrap());
    let mut states = 0;
    for line in log.iter().filter(|line| line[0] != "count") {
        disk.take(line);
        for model in MODELS {
            let found = disk.content(model, "save.toml");
            assert!(found == Some(&old) || found == Some(&new), "model {model:?} after {:?}: {found:?}", &line[..2]);
            states += 1;
        }
    }
    for model in MODELS {
        assert_eq!(disk.content(model, "save.toml"), Some(new.as_str()), "saved and lost");
        assert_eq!(disk.content(model, "save.toml.bak"), Some(old.as_str()));
    }
    println!("save: {states} states");
}

/// The set in a folder with the file of the user beside it is that of one run, whole, whenever the power goes.
#[test]
fn a_loss_of_power_at_any_operation_leaves_the_old_results_or_the_new() {
    if TRACER.is_none() {
        println!("skipped: no C compiler, or no process may be traced here");
        return;
    }
    for case in CASES.iter().filter(|case| case.has_results()) {
        let (folder, output, log) = traced(case, ("none", "0", 0));
        assert!(output.status.code().is_some_and(|code| CODES.contains(&code)), "{}", said(&output));
        let as_text = |files: Files| -> BTreeMap<PathBuf, String> {
            files.into_iter().map(|(path, bytes)| (path, String::from_utf8_lossy(&bytes).into_owned())).collect()
        };
        let [old, new] = [case.template(), folder.path()].map(|place| as_text(of_target(case, place)));
        assert_ne!(old, new, "{}", case.name);
        let mut disk = Disk::of(&files(case.template()), &folder.path().canonicalize().unwrap());
        let (mut states, mut faults) = (0, Vec::new());
        let set_of = |disk: &Disk, model| -> BTreeMap<PathBuf, String> {
            let all = disk.files(model).into_iter();
            all.filter_map(|(path, content)| {
                Some((path.strip_prefix(case.target).ok()?.to_owned(), content.to_owned()))
            })
            .collect()
        };
        for line in log.iter().filter(|line| line[0] != "count") {
            disk.take(line);
            for model in MODELS {
                let found = set_of(&disk, model);
                if found != old && found != new {
                    let is_of = |set: &BTreeMap<PathBuf, String>| {
                        found.iter().filter(|(path, text)| set.get(*path) == Some(*text)).count()
                    };
                    let counts = (is_of(&old), is_of(&new), old.len(), new.len());
                    faults.push(format!(
                        "model {model:?} after {:?}: files of old, of new, old, new: {counts:?}",
                        &line[..2]
                    ));
                }
                states += 1;
            }
        }
        assert!(faults.is_empty(), "{}: {} of {states}:\n{}", case.name, faults.len(), faults.join("\n"));
        for model in MODELS {
            assert!(set_of(&disk, model) == new, "{}: written and lost, model {model:?}", case.name);
        }
        println!("{}: {states} states", case.name);
    }
}

/// The last time in a recording, s.
fn last_time_s(rows: &str) -> f64 {
    rows.lines().last().and_then(|line| line.split(',').next()?.parse().ok()).unwrap_or(f64::NAN)
}

/// The session is written ten seconds after the first row and again at the end; each time the rows it needs are on the disk.
#[test]
fn a_loss_of_power_while_recording_leaves_a_session_with_its_rows() {
    if TRACER.is_none() {
        println!("skipped: no C compiler, or no process may be traced here");
        return;
    }
    let waits = LIVE.arguments.iter().map(|one| if *one == "0.2" { "60" } else { one });
    let arguments: &'static [&'static str] = waits.chain(["--for", "12"]).collect::<Vec<_>>().leak();
    let (folder, output, log) = traced(&Case { arguments, ..LIVE }, ("none", "0", 0));
    assert!(output.status.success(), "{}", said(&output));
    let mut disk = Disk::of(&files(FLIGHT.path()), &folder.path().canonicalize().unwrap());
    let (mut states, mut sessions) = (0, 0);
    for line in log.iter().filter(|line| line[0] != "count") {
        disk.take(line);
        for model in MODELS {
            states += 1;
            let Some(text) = disk.content(model, "day/session.toml") else { continue };
            let session =
                session::parse(text).unwrap_or_else(|error| panic!("model {model:?}, {:?}: {error}", &line[..2]));
            let end_s = session.windows.iter().map(|one| one.window.end_s).fold(f64::NEG_INFINITY, f64::max);
            let last_s = last_time_s(disk.content(model, "day/flight.csv").unwrap_or_default());
            // A manoeuvre may end between two rows.
            assert!(
                last_s >= end_s - 0.011,
                "model {model:?} after {:?}: rows to {last_s} s, session to {end_s} s",
                &line[..2]
            );
        }
        sessions += usize::from(line[0] == "rename" && line[2].ends_with("session.toml"));
    }
    assert!(sessions >= 2, "{sessions}");
    assert!(MODELS.iter().all(|model| disk.content(*model, "day/session.toml").is_some()), "recorded and lost");
    println!("live: {states} states, {sessions} sessions");
}
