//! Recordings changed at random and taken through the whole program: map, new, check, run, report, export.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use doublet_core::load::FORMATS;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::flight::oscillation;

/// Longest time of one command: a busy computer takes some seconds for what takes a tenth.
const PATIENCE: Duration = Duration::from_secs(120);
/// Columns of the recording, as its header has them.
const HEADER: [&str; 17] = [
    "time [s]", "ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]", "p [deg/s]", "q [deg/s]", "r [deg/s]", "phi [deg]",
    "theta [deg]", "psi [deg]", "airspeed [m/s]", "altitude [m]", "alpha [deg]", "beta [deg]", "delta_e [deg]",
    "delta_a [deg]", "delta_r [deg]",
];
/// Names and units that a header may have in the place of its own.
const NAMES: [&str; 16] = [
    "", "time", "GPS time", "lat [deg]", "lon [deg]", "vn [m/s]", "ve [m/s]", "vd [m/s]", "ias [kt]", "baro [hPa]",
    "oat [degC]", "q [rad/s]", "q", "x [m]", "rpm", "\u{feff}\"",
];
/// Units that a header may have in the place of its own.
const UNITS: [&str; 8] = [" [rad]", " [g]", " [ft]", " [kt]", " [hPa]", "", " [V]", " [%]"];
/// Cells that are no usual numbers.
const CELLS: [&str; 9] = ["", "nan", "inf", "1e308", "-1e308", "1e-320", "0", "x", "12:34:56.7"];

/// How the program is taken from recording to export.
pub struct Chain {
    /// How many recordings.
    pub runs: u64,
    /// Seed of the first.
    pub seed: u64,
}

/// How far the recordings came.
#[derive(Debug, Default)]
pub struct Reached {
    /// Recordings with a session.
    pub sessions: usize,
    /// Recordings with results.
    pub results: usize,
    /// What must not happen, each with the seed of its recording.
    pub faults: Vec<String>,
}

impl Chain {
    /// As the environment says, otherwise so many recordings from the first seed on.
    pub fn of_environment(runs: u64) -> Self {
        let number = |name: &str, usual| std::env::var(name).map_or(usual, |text| text.parse().unwrap());
        Self { runs: number("DOUBLET_CHAIN_RUNS", runs), seed: number("DOUBLET_CHAIN_SEED", 1) }
    }

    /// Takes the recordings through the program, on all cores.
    pub fn run(&self) -> Reached {
        let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
        let part = |first: u64| {
            let mut reached = Reached::default();
            (self.seed + first..self.seed + self.runs)
                .step_by(threads as usize)
                .for_each(|seed| one(seed, &mut reached));
            reached
        };
        let parts = std::thread::scope(|scope| {
            let parts: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
            parts.into_iter().map(|part| part.join().unwrap()).collect::<Vec<_>>()
        });
        parts.into_iter().fold(Reached::default(), |mut all, mut part| {
            all.sessions += part.sessions;
            all.results += part.results;
            all.faults.append(&mut part.faults);
            all
        })
    }
}

/// One recording on its way through the program; the first command that refuses it ends the way.
fn one(seed: u64, reached: &mut Reached) {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let folder = tempfile::tempdir().unwrap();
    let name = write_recording(random, folder.path());
    let form = ["csv", "hdf5", "mat", "parquet"][random.random_range(0..4)];
    let path = ["smoothed", "smoothed", "filtered", "measured"][random.random_range(0..4)];
    let mut command = |arguments: &[&str]| {
        let (code, printed) = doublet(folder.path(), arguments);
        let is_fault =
            !matches!(code, Some(0 | 1 | 3)) || printed.contains("internal error") || printed.contains("panicked");
        if is_fault {
            let printed: Vec<&str> =
                printed.lines().filter(|line| line.contains("error") || line.contains("panicked")).collect();
            reached
                .faults
                .push(format!("seed {seed}: {arguments:?} with path {path}: {code:?}: {}", printed.join("; ")));
        }
        !is_fault && code != Some(1)
    };
    command(&["map", &name]);
    command(&["new", "--guess", "--aircraft", "attas_vfw614", &name, "-o", "a.toml"]);
    let session = folder.path().join("a.toml");
    // It is refused, or asks for what it cannot know.
    let Ok(text) = std::fs::read_to_string(&session) else { return };
    std::fs::write(&session, text.replace("path = \"smoothed\"", &format!("path = \"{path}\""))).unwrap();
    let is_checked = command(&["check", "a.toml"]);
    let is_run = command(&["run", "a.toml", "--out", "results", "--histories", form]);
    if is_run {
        command(&["report", "a.toml", "--out", "report", "--format", "html"]);
        command(&["export", "a.toml", "--out", "models"]);
    }
    reached.sessions += usize::from(is_checked);
    reached.results += usize::from(is_run);
}

/// Runs the program in a folder: its exit code, none after a signal or where it takes too long, and what it said.
fn doublet(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let place = folder.join("said");
    let printed = File::create(&place).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
        .args(arguments)
        .current_dir(folder)
        .stdout(printed.try_clone().unwrap())
        .stderr(printed)
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let code = child.wait().unwrap().code();
    (code, String::from_utf8_lossy(&std::fs::read(place).unwrap()).into_owned())
}

/// A changed recording in a folder, and its name: usually the text of a flight, sometimes a seed of the parsers.
fn write_recording(random: &mut ChaCha8Rng, folder: &Path) -> String {
    let seeds = seeds();
    let (name, mut bytes) = if random.random_bool(0.2) {
        let seed = &seeds[random.random_range(0..seeds.len())];
        (seed.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(seed).unwrap())
    } else {
        ("flight.csv".to_owned(), changed_table(random).into_bytes())
    };
    if name != "flight.csv" || random.random_bool(0.2) {
        change_bytes(random, &mut bytes);
    }
    std::fs::write(folder.join(&name), bytes).unwrap();
    name
}

/// Seeds of the parsers of recordings.
pub fn seeds() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    let folders: BTreeSet<&str> = FORMATS.iter().map(|format| format.fuzz_target).collect();
    let files = |folder: &&str| std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> = folders.iter().flat_map(files).collect();
    found.sort();
    found
}

/// The text of a flight of 20 s at 20 Hz with one to four changes.
pub fn changed_table(random: &mut ChaCha8Rng) -> String {
    let mut header: Vec<String> = HEADER.iter().map(|name| (*name).to_owned()).collect();
    let row = |index: u32| oscillation(f64::from(index) / 20.0).map(|value| format!("{value:.5}")).to_vec();
    let mut rows: Vec<Vec<String>> = (0..400).map(row).collect();
    change_table(random, &mut header, &mut rows);
    let separator = [",", ",", ",", ";", "\t"][random.random_range(0..5)];
    let mut text = header.join(separator) + "\n";
    rows.iter().for_each(|row| writeln!(text, "{}", row.join(separator)).unwrap());
    text
}

/// One to four changes of a table.
pub fn change_table(random: &mut ChaCha8Rng, header: &mut Vec<String>, rows: &mut Vec<Vec<String>>) {
    for _ in 0..random.random_range(1..=4) {
        match random.random_range(0..4) {
            0 => change_header(random, header),
            1 => change_columns(random, header, rows),
            2 => change_rows(random, rows),
            _ => change_cells(random, header.len(), rows),
        }
    }
}

fn change_header(random: &mut ChaCha8Rng, header: &mut [String]) {
    let at = random.random_range(0..header.len());
    match random.random_range(0..3) {
        0 => header[at] = NAMES[random.random_range(0..NAMES.len())].to_owned(),
        1 => {
            let name = header[at].split(" [").next().unwrap().to_owned();
            header[at] = name + UNITS[random.random_range(0..UNITS.len())];
        }
        _ => header[at] = header[random.random_range(0..header.len())].clone(),
    }
}

/// Leaves out, exchanges, holds, scales or turns columns.
fn change_columns(random: &mut ChaCha8Rng, header: &mut Vec<String>, rows: &mut [Vec<String>]) {
    if header.len() < 3 {
        return;
    }
    let (at, other) = (random.random_range(0..header.len()), random.random_range(0..header.len()));
    let each = |rows: &mut [Vec<String>], change: &dyn Fn(f64) -> f64| {
        for cell in rows.iter_mut().filter_map(|row| row.get_mut(at)) {
            *cell = format!("{}", change(cell.parse().unwrap_or(0.0)));
        }
    };
    match random.random_range(0..6) {
        0 => {
            // Often many at once: what a recording lacks is as much a change as what it has too much.
            for _ in 0..random.random_range(1..header.len() - 1) {
                let at = random.random_range(0..header.len());
                header.remove(at);
                rows.iter_mut().filter(|row| row.len() > at).for_each(|row| _ = row.remove(at));
            }
        }
        1 => rows.iter_mut().filter(|row| row.len() > at.max(other)).for_each(|row| row.swap(at, other)),
        2 => {
            let held = [0.0, 1.0, -9.81, f64::NAN][random.random_range(0..4)];
            each(rows, &|_| held);
        }
        3 => {
            let factor = [-1.0, 1e3, 1e-3, 57.3, 1e150][random.random_range(0..5)];
            each(rows, &|value| factor * value);
        }
        4 => each(rows, &|value| value.round()),
        _ => each(rows, &|value| value + 1e6),
    }
}

/// Leaves out, doubles, exchanges or turns rows.
fn change_rows(random: &mut ChaCha8Rng, rows: &mut Vec<Vec<String>>) {
    if rows.is_empty() {
        return;
    }
    let at = random.random_range(0..rows.len());
    match random.random_range(0..5) {
        0 => rows.truncate(at),
        1 => drop(rows.drain(at..(at + random.random_range(1..100)).min(rows.len()))),
        2 => rows.insert(at, rows[at].clone()),
        3 => rows.reverse(),
        _ => {
            let length = random.random_range(0..=rows[at].len());
            rows[at].truncate(length);
        }
    }
}

/// Puts cells that are no usual numbers into some rows of a column, or into one row.
fn change_cells(random: &mut ChaCha8Rng, columns: usize, rows: &mut [Vec<String>]) {
    let (column, cell) = (random.random_range(0..columns.max(1)), CELLS[random.random_range(0..CELLS.len())]);
    let share = [0.003, 0.1, 1.0][random.random_range(0..3)];
    for row in rows.iter_mut().filter(|row| row.len() > column) {
        if random.random_bool(share) {
            cell.clone_into(&mut row[column]);
        }
    }
}

/// Turns bits, cuts, doubles and replaces pieces.
pub fn change_bytes(random: &mut ChaCha8Rng, bytes: &mut Vec<u8>) {
    for _ in 0..random.random_range(1..=4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..4) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.random(),
            2 => bytes.truncate(at),
            _ => {
                let piece = bytes[at..(at + random.random_range(1..64)).min(bytes.len())].to_vec();
                let to = random.random_range(0..bytes.len());
                bytes.splice(to..to, piece);
            }
        }
    }
}
