//! Damaged files: every prefix and thousands of changed bytes give a value or one line, never a panic.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use doublet_core::load::inspect;
use rand::{Rng, RngExt, SeedableRng};

use super::{fixture, flight_log, recorders, written};

/// Changed copies per format, in the time of a test run.
const MUTANTS: usize = 3000;
/// Longest that one damaged file of a few kilobytes may take; a claimed size that is believed takes longer or aborts.
const PATIENCE: Duration = Duration::from_secs(2);

const TEXT: &str = "Recorder;7\ntime;alpha;q\ns;deg;deg/s\n0,0;1,5;2\n0,1;;3\n0,2;1,7;4\n0,3;1,7;4\n0,4;1,7;\"5\"\n";

fn files() -> Vec<(&'static str, Vec<u8>)> {
    let names = ["v5_compressed.mat", "v5_plain.mat", "v5_big_endian.mat", "v73.mat", "layouts.h5"];
    let mut files: Vec<_> = names.into_iter().map(|name| (name, std::fs::read(fixture(name)).unwrap())).collect();
    files.push(("log.csv", TEXT.as_bytes().to_vec()));
    files.push(("columns.asc", b"t q r\n0 1 2\n1 2 3\n2 3 4\n3 4 5\n".to_vec()));
    files.push(("flight.ulg", flight_log::log()));
    files.push(("ardupilot.bin", recorders::dataflash()));
    files.push(("labview.tdms", recorders::tdms()));
    files.push(("bus.mf4", recorders::mdf4()));
    files.push(("topics.mcap", recorders::mcap()));
    files.push(("table.parquet", recorders::parquet()));
    files
}

/// Opens `path`; an error must be one line that names the file.
fn open(path: &Path, what: &str) {
    let start = Instant::now();
    if let Err(error) = inspect(path) {
        let line = error.to_string();
        assert!(!line.contains('\n') && line.contains(path.file_name().unwrap().to_str().unwrap()), "{what}: {line:?}");
    }
    assert!(start.elapsed() < PATIENCE, "{what} took {:?}", start.elapsed());
}

#[test]
fn truncated_files_give_a_line_or_what_is_complete() {
    for (name, contents) in files() {
        let step = (contents.len() / 200).max(1);
        for length in (0..contents.len()).step_by(step) {
            let (_folder, path) = written(name, &contents[..length]);
            open(&path, &format!("{name} cut to {length}"));
        }
    }
}

#[test]
fn mutated_files_never_panic() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    for (name, contents) in files() {
        let (_folder, path) = written(name, &contents);
        let start = Instant::now();
        for mutant in 0..MUTANTS {
            let mut changed = contents.clone();
            for _ in 0..random.random_range(1..6) {
                let at = random.random_range(0..changed.len());
                changed[at] = match random.random_range(0..4) {
                    0 => 0,
                    1 => 0xff,
                    2 => changed[at] ^ (1 << random.random_range(0..8)),
                    _ => random.next_u32() as u8,
                };
            }
            // Written over, not anew: replacing a file makes some file systems wait for the disk.
            std::fs::OpenOptions::new().write(true).open(&path).unwrap().write_all(&changed).unwrap();
            open(&path, &format!("mutant {mutant} of {name}"));
        }
        println!("{MUTANTS} mutants of {name} in {:?}", start.elapsed());
    }
}
