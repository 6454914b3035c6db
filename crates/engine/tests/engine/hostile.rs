//! Hostile input: the seeds and findings of the fuzz targets, paths that leave the session's folder, files that never end.

#[path = "../../../../fuzz/src/lib.rs"]
mod targets;

use std::path::Path;
use std::time::{Duration, Instant};

use doublet_engine::graph::Context;
use doublet_engine::session::{self, Flight, MapRef, RecordingRef, leads_out, path_warning};
use doublet_engine::stage;

use crate::compute;

/// Every seed is a file of some kilobytes; one that takes longer found something.
const PATIENCE: Duration = Duration::from_secs(5);

/// Longest time of a target; one that runs an analysis takes longer than a parser.
fn patience(name: &str) -> Duration {
    if ["whole_path", "recording_chain"].contains(&name) { 10 * PATIENCE } else { PATIENCE }
}

#[test]
fn every_parser_returns_from_every_seed_and_finding() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    for name in targets::targets() {
        let mut count = 0;
        for entry in std::fs::read_dir(folder.join(name)).unwrap() {
            let path = entry.unwrap().path();
            let data = std::fs::read(&path).unwrap();
            let begun = Instant::now();
            targets::call(name, &data);
            assert!(begun.elapsed() < patience(name), "{} took {:?}", path.display(), begun.elapsed());
            count += 1;
        }
        assert!(count > 0, "{name} has no seed");
    }
}

#[test]
fn paths_that_leave_the_folder_of_the_session_are_named() {
    for path in ["flight.h5", "data/flight.h5", "data/../flight.h5", "./flight.h5", "builtin:../../x"] {
        assert!(!leads_out(path), "{path}");
    }
    for path in ["../flight.h5", "data/../../flight.h5", "..", "data/../../data/x"] {
        assert!(leads_out(path), "{path}");
    }
    assert!(leads_out("/etc/passwd"));
}

#[test]
fn a_session_that_reads_outside_its_folder_says_so_once() {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    assert_eq!(path_warning(&session), None);
    session.aircraft = Some("../plane.toml".to_owned());
    assert_eq!(
        path_warning(&session).unwrap(),
        "../plane.toml is outside the session's folder: check that this is intended"
    );
    // Many files in one place, over two flights, some of them twice: one line.
    session.aircraft = Some("builtin:c337f".to_owned());
    for (index, recording) in session.flights[0].recordings.iter_mut().enumerate() {
        recording.path = format!("../../data/day{}/{index}.csv", index % 2);
    }
    session.flights.push(session.flights[0].clone());
    let files = session.flights[0].recordings.len();
    let warning = path_warning(&session).unwrap();
    assert_eq!(
        warning,
        format!("{files} files under ../../data are outside the session's folder: check that this is intended")
    );
    // Nothing in common but the way up: the first is named.
    session.aircraft = Some("../plane.toml".to_owned());
    session.flights[1].recordings[0].channel_map = MapRef::File("/etc/passwd".to_owned());
    let warning = path_warning(&session).unwrap();
    assert!(warning.starts_with(&format!("{} files, ../../data/day0/0.csv the first, are", files + 2)), "{warning}");
}

/// A control character made an export an error without a name; a mark of direction turned the rest of a title round.
#[test]
fn titles_and_names_that_no_document_can_hold_are_refused_and_never_made() {
    let demo = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    for (letter, code) in [
        ('\u{7}', "U+0007"),
        ('\u{202e}', "U+202E"),
        ('\u{2066}', "U+2066"),
        ('\u{200f}', "U+200F"),
        ('\u{61c}', "U+061C"),
    ] {
        let mut titled = demo.clone();
        titled.title = format!("Bell {letter} end");
        let found = session::check(&titled);
        let finding = found.iter().find(|finding| session::stops_run(finding)).unwrap().to_string();
        assert!(finding.contains("title") && finding.contains(code), "{finding}");
        let name = doublet_engine::begin::name_of(Path::new(&format!("day/fl{letter}ight.csv")));
        assert_eq!(name, "flight");
    }
}

fn flight_of(path: &str, map: &str) -> Flight {
    let recording = RecordingRef { path: path.to_owned(), sha256: None, channel_map: map.into(), only: None };
    Flight::new("one".to_owned(), vec![recording])
}

#[test]
fn a_recording_outside_the_folder_is_read_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("sessions");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("log.csv"), "t,q\n0,1\n1,2\n2,3\n").unwrap();
    let map = "format = \"doublet channel map\"\nversion = 1\nname = \"x\"\n[[time]]\nsource = \"*\"\nchannel = \"t\"\nunit = \"s\"\n[roles]\nq = { channel = \"q\", unit = \"deg/s\" }\n";
    std::fs::write(inner.join("map.toml"), map).unwrap();
    let read = stage::read_flight(&Context::new(&inner), &flight_of("../log.csv", "map.toml").recordings).unwrap();
    assert!(read.recording.warnings.is_empty(), "{:?}", read.recording.warnings);
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    session.flights = vec![flight_of("../log.csv", "map.toml")];
    session.windows.clear();
    let log = compute(&session, &inner).log;
    let warnings: Vec<_> = log.iter().filter(|line| line.text.contains("outside the session's folder")).collect();
    assert_eq!(warnings.len(), 1, "{log:?}");
    assert!(warnings[0].text.contains("../log.csv") && !warnings[0].text.contains("map.toml"), "{}", warnings[0].text);
}

#[cfg(unix)]
#[test]
fn files_without_an_end_and_commands_are_not_read() {
    let begun = Instant::now();
    let refused = |path: &str, map: &str| {
        stage::read_flight(&Context::new(Path::new("/")), &flight_of(path, map).recordings).unwrap_err().to_string()
    };
    assert!(refused("/dev/zero", "builtin:demo_flight").contains("neither a file nor a folder"));
    assert!(refused("builtin:flights/demo/pod.csv", "/dev/zero").contains("neither a file nor a folder"));
    let session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    assert!(stage::load_aircraft(&Context::new(Path::new("/")), "/dev/zero").is_err());
    let marker = std::env::temp_dir().join(format!("doublet-command-{}", std::process::id()));
    for command in ["$(touch M)", "`touch M`", "|touch M", "; touch M", "builtin:$(touch M)"] {
        let command = command.replace('M', marker.to_str().unwrap());
        refused(&command, "builtin:demo_flight");
        let mut hostile = session.clone();
        hostile.title.clone_from(&command);
        hostile.aircraft = Some(command.clone());
        assert_eq!(session::parse(&session::print(&hostile).unwrap()).unwrap(), hostile);
        assert!(stage::load_aircraft(&Context::new(Path::new("/")), &command).is_err());
    }
    assert!(!marker.exists(), "a path was run");
    assert!(begun.elapsed() < PATIENCE);
}

/// Runs of the test below: enough to meet every setting; the script of the soak asks for more.
const CHANGED_SESSIONS: u64 = 60;

#[test]
fn sessions_with_settings_changed_at_random_run_to_results() {
    use rand::{RngExt, SeedableRng};
    let runs = std::env::var("DOUBLET_SOAK_RUNS").ok().and_then(|text| text.parse().ok()).unwrap_or(CHANGED_SESSIONS);
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(17);
    for run in 0..runs {
        let data: Vec<u8> = (0..48).map(|_| random.random()).collect();
        let begun = Instant::now();
        targets::call("whole_path", &data);
        assert!(begun.elapsed() < 10 * PATIENCE, "run {run} took {:?}: {data:?}", begun.elapsed());
    }
}

/// Runs of each target below, from seeds changed at random; `DOUBLET_SOAK_RUNS` asks for more, `DOUBLET_SOAK_TARGET` for one target alone.
const CHANGED_SEEDS: u64 = 40;
/// Longest input.
const LONGEST: usize = 20_000;
/// Bytes that parsers stumble over.
const ODD: [u8; 12] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b'"', b',', b'=', b'[', b'-', b'9'];

/// A seed with one to eight changes: bits and bytes, pieces taken out, doubled, put in from another seed, numbers made large, a cut end.
fn change_seed(seeds: &[Vec<u8>], random: &mut rand_chacha::ChaCha8Rng) -> Vec<u8> {
    use rand::RngExt;
    let mut data = seeds[random.random_range(0..seeds.len())].clone();
    for _ in 0..random.random_range(1..=8) {
        let length = data.len().max(1);
        let at = random.random_range(0..length).min(data.len());
        let end = (at + random.random_range(1..=64)).min(data.len());
        match random.random_range(0..9) {
            0 if at < data.len() => data[at] ^= 1 << random.random_range(0..8),
            1 if at < data.len() => data[at] = ODD[random.random_range(0..ODD.len())],
            2 if at < data.len() => data[at] = random.random(),
            3 => data.insert(at, ODD[random.random_range(0..ODD.len())]),
            4 => drop(data.drain(at..end)),
            5 => {
                let piece = data[at..end].to_vec();
                data.splice(at..at, piece);
            }
            6 => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let from = random.random_range(0..other.len().max(1)).min(other.len());
                let piece = other[from..(from + 64).min(other.len())].to_vec();
                data.splice(at..at, piece);
            }
            7 => {
                let number: u64 = 1 << random.random_range(0..64);
                let bytes = number.to_le_bytes();
                let (count, end) = (bytes.len().min(end - at), end.min(at + 8));
                data[at..end].copy_from_slice(&bytes[..count]);
            }
            _ if random.random_range(0..8) == 0 => data.truncate(at),
            _ => {}
        }
    }
    data.truncate(LONGEST);
    data
}

#[test]
fn every_parser_returns_from_seeds_changed_at_random() {
    use rand::SeedableRng;
    let runs = std::env::var("DOUBLET_SOAK_RUNS").ok().and_then(|text| text.parse().ok()).unwrap_or(CHANGED_SEEDS);
    let seed = std::env::var("DOUBLET_SOAK_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(12);
    let asked = std::env::var("DOUBLET_SOAK_TARGET").ok();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    // The whole path has a test of its own.
    let wanted = |name: &str| asked.as_deref().map_or(name != "whole_path", |asked| asked == name);
    for name in targets::targets().into_iter().filter(|name| wanted(name)) {
        let mut paths: Vec<_> =
            std::fs::read_dir(folder.join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        let seeds: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let begun = Instant::now();
        for run in 0..runs {
            let data = change_seed(&seeds, &mut random);
            let begun = Instant::now();
            let returned = std::panic::catch_unwind(|| targets::call(name, &data)).is_ok();
            assert!(returned && begun.elapsed() < patience(name), "{name}, run {run}, {:?}: {data:?}", begun.elapsed());
        }
        println!("{name}: {runs} runs in {:.0} s", begun.elapsed().as_secs_f64());
        if name == "recording_chain" {
            println!("ended: {}", targets::recording_chain::counts());
        }
    }
}
