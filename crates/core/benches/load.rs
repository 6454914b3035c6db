//! How fast recordings come in: `cargo bench -p doublet-core --bench load`.
//!
//! The HDF5 file is written, and read for comparison, by the C library through python3 with h5py; without them that bench is
//! left out. The PH-LAB folder is read where the shared recordings are present.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a bench that cannot be prepared stops and says why")]

#[path = "../tests/common/shared.rs"]
mod shared;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use divan::Bencher;
use divan::counter::BytesCount;
use doublet_core::load::{ChannelMap, inspect, plan, probe, read};

/// Folder of the files made here, removed at the end.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().unwrap());

fn main() {
    divan::main();
    std::fs::remove_dir_all(FOLDER.path()).unwrap();
}

/// Noisy values: what a recorder writes does not compress to nothing.
fn value(column: usize, row: usize) -> f64 {
    let hash = (row as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(column as u64) >> 40;
    (row as f64 * 1e-3 + column as f64).sin() + hash as f64 * 1e-9
}

fn bench_inspect(bencher: Bencher, path: &Path) {
    let bytes = std::fs::metadata(path).unwrap().len();
    bencher.counter(BytesCount::new(bytes)).bench(|| inspect(path).unwrap());
}

#[divan::bench(sample_count = 10)]
fn csv_100000x20(bencher: Bencher) {
    let path = FOLDER.path().join("table.csv");
    let mut text = String::from("time");
    (1..20).for_each(|column| write!(text, ",c{column}").unwrap());
    for row in 0..100_000 {
        write!(text, "\n{:.2}", row as f64 * 0.01).unwrap();
        (1..20).for_each(|column| write!(text, ",{:.6}", value(column, row)).unwrap());
    }
    std::fs::write(&path, text).unwrap();
    bench_inspect(bencher, &path);
}

/// A MAT v5 file of one matrix of 20 columns.
fn mat(rows: usize, compressed: bool) -> PathBuf {
    let path = FOLDER.path().join(format!("matrix_{compressed}.mat"));
    let mut body = Vec::new();
    for word in [6_u32, 8, 6, 0, 5, 8, rows as u32, 20, 1, 8] {
        body.extend(word.to_le_bytes());
    }
    body.extend(b"recorded");
    body.extend(9_u32.to_le_bytes());
    body.extend((rows as u32 * 20 * 8).to_le_bytes());
    for column in 0..20 {
        (0..rows).for_each(|row| body.extend(value(column, row).to_le_bytes()));
    }
    let mut element = 14_u32.to_le_bytes().to_vec();
    element.extend((body.len() as u32).to_le_bytes());
    element.extend(body);
    let mut file = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    file.extend(b"\x00\x01IM");
    if compressed {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&element).unwrap();
        let packed = encoder.finish().unwrap();
        file.extend(15_u32.to_le_bytes());
        file.extend((packed.len() as u32).to_le_bytes());
        file.extend(packed);
    } else {
        file.extend(element);
    }
    std::fs::write(&path, file).unwrap();
    path
}

#[divan::bench(sample_count = 10)]
fn mat_v5_plain_250000x20(bencher: Bencher) {
    bench_inspect(bencher, &mat(250_000, false));
}

#[divan::bench(sample_count = 10)]
fn mat_v5_compressed_250000x20(bencher: Bencher) {
    bench_inspect(bencher, &mat(250_000, true));
}

/// 80 minutes at 10 Hz in 48 CSV files, through its channel map to a recording.
#[divan::bench(sample_count = 10)]
fn phlab_48files_48321samples(bencher: Bencher) {
    let Some(path) = shared::shared("data/phlab_citation") else { return };
    let (_, text) = ChannelMap::shipped().iter().find(|(name, _)| *name == "phlab_citation").unwrap();
    let map = ChannelMap::parse(text).unwrap();
    bencher.bench(|| read(&plan(&probe(&path).unwrap(), &map)).unwrap());
}

/// 200 MB of doubles in chunks, shuffled and compressed; the time of the C library is printed.
#[divan::bench(sample_count = 5)]
fn hdf5_gzip_25x1000000(bencher: Bencher) {
    let path = FOLDER.path().join("large.h5");
    let script = "import sys, time, h5py, numpy as np\n\
        name, n = sys.argv[1], 1000000\n\
        t = np.arange(n) * 0.01\n\
        with h5py.File(name, 'w') as f:\n\
        \x20   f['time'] = t\n\
        \x20   for i in range(24):\n\
        \x20       f.create_dataset(f'c{i}', data=np.round(np.sin(t / (i + 1)), 4), chunks=(16384,), compression='gzip', shuffle=True)\n\
        best = 1e9\n\
        for _ in range(3):\n\
        \x20   s = time.perf_counter()\n\
        \x20   with h5py.File(name) as f:\n\
        \x20       total = sum(f[k][()].sum() for k in f)\n\
        \x20   best = min(best, time.perf_counter() - s)\n\
        print(f'C library through h5py: {best:.3f} s')\n";
    match Command::new("python3").args(["-c", script]).arg(&path).output() {
        Ok(output) if output.status.success() => {
            println!("{}", String::from_utf8_lossy(&output.stdout).trim());
            bencher.counter(BytesCount::new(200_000_000_u64)).bench(|| inspect(&path).unwrap());
        }
        _ => println!("skipped: python3 with h5py is not here"),
    }
}
