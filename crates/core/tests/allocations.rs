//! The reconstruction allocates per window, never per sample; a recording that does not fit is refused before it fills the memory.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

#[path = "common/bombs.rs"]
mod bombs;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use doublet_core::load::{BUDGET_VARIABLE, inspect};
use doublet_core::reconstruct::{FilterData, FilterSettings, InputSeries, MeasurementSeries, Method, reconstruct};

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes of this thread now, and the most there were.
    static BYTES: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}

fn note(bytes: isize) {
    // A thread that ends frees what it had after its own variables are gone.
    let _ = BYTES.try_with(|cell| {
        let (now, most) = cell.get();
        cell.set((now + bytes, most.max(now + bytes)));
    });
}

/// The system's allocator, counting the allocations of each thread.
struct Counting;

#[allow(unsafe_code)]
// SAFETY: every call is passed on unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        note(layout.size().cast_signed());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note(-layout.size().cast_signed());
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // Old and new are both there while it is moved.
        note(size.cast_signed());
        note(-layout.size().cast_signed());
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Level flight, every measurement at every sample.
#[cfg(test)]
fn flight(samples: u32) -> FilterData {
    let time_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * 0.01).collect();
    let column = |value: f64| vec![value; time_s.len()];
    let columns = [0.0, 0.0, -9.806_65, 0.0, 0.0, 0.0].map(column);
    let mut measurements = [0.0, 0.0, -900.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 80.0, 0.0, 0.0]
        .map(|value| MeasurementSeries { time_s: time_s.clone().into(), values: column(value).into() });
    measurements[0].values = time_s.iter().map(|t| 80.0 * t).collect();
    FilterData { inputs: InputSeries { time_s: time_s.into(), columns: columns.map(Arc::from) }, measurements }
}

#[cfg(test)]
fn allocations(samples: u32, settings: &FilterSettings) -> usize {
    let data = flight(samples);
    let settings = settings.check().unwrap();
    let before = COUNT.with(Cell::get);
    let result = reconstruct(&data, &settings, &mut |_| ControlFlow::Continue(()));
    let count = COUNT.with(Cell::get) - before;
    assert_eq!(result.unwrap().states[0].len(), samples as usize);
    count
}

#[test]
fn a_window_four_times_as_long_takes_no_more_allocations() {
    let methods = [Method::Ekf, Method::USUAL_IEKF, Method::Ukf { spread: Method::USUAL_SPREAD }];
    for method in methods {
        for smooth in [false, true] {
            let settings = FilterSettings { method, smooth, ..FilterSettings::default() };
            let (short, long) = (allocations(500, &settings), allocations(2_000, &settings));
            println!("{method:?}, smoothed {smooth}: {short} allocations");
            assert_eq!(short, long, "{method:?}, smoothed {smooth}");
            assert!(short > 50);
        }
    }
}

/// What a recording may take in the tests below, and what reading one may take beside the file itself: the columns as they grow.
const BUDGET: usize = 20_000_000;
const MOST_BESIDE_THE_FILE: isize = 3 * BUDGET.cast_signed();
/// The same where the size is stated before anything is unpacked.
const MOST_WHERE_STATED: isize = 3_000_000;
/// Set for the process that reads: the file.
const CHILD: &str = "DOUBLET_TEST_RECORDING";

#[test]
#[ignore = "run by the tests that set its budget"]
fn child_that_reads_within_a_budget() {
    if let Some(path) = std::env::var_os(CHILD) {
        let (before, _) = BYTES.get();
        BYTES.set((before, before));
        let message = inspect(Path::new(&path)).map_or_else(|error| error.to_string(), |_| "read".to_owned());
        println!("SAID {} {message}", BYTES.get().1 - before);
    }
}

/// Most bytes that reading a file took, and what was said of it.
fn read_within_budget(path: &Path) -> (isize, String) {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "child_that_reads_within_a_budget", "--ignored", "--nocapture"]);
    let budget_mb = (BUDGET / 1_000_000).to_string();
    let output = child.env(BUDGET_VARIABLE, budget_mb).env(CHILD, path).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find_map(|line| line.split_once("SAID "));
    let (bytes, message) = line.and_then(|(_, rest)| rest.split_once(' ')).unwrap_or_else(|| panic!("{text}"));
    (bytes.parse().unwrap(), message.to_owned())
}

#[test]
fn small_files_that_take_much_are_refused_within_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents) in bombs::bombs() {
        let path = folder.path().join(name);
        let size = contents.len().cast_signed();
        std::fs::write(&path, contents).unwrap();
        let (bytes, message) = read_within_budget(&path);
        println!("{name}: file {:.2} MB, {:.2} MB to refuse it", size as f64 / 1e6, bytes as f64 / 1e6);
        let is_refused = if name == "shared.mf4" { "several links lead to" } else { "too large when unpacked" };
        assert!(message.contains(is_refused) && message.contains(name), "{name}: {message}");
        let is_stated = ["segment.tdms", "chunks.mcap", "blocks.mf4", "shared.mf4", "pages.parquet"].contains(&name);
        let most = if is_stated { MOST_WHERE_STATED } else { MOST_BESIDE_THE_FILE };
        assert!(bytes < size + most, "{name}: {bytes} bytes for a file of {size}");
    }
}

#[test]
fn a_file_larger_than_the_budget_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for (name, head) in bombs::HEADS {
        let path = folder.path().join(name);
        std::fs::write(&path, head).unwrap();
        std::fs::File::options().write(true).open(&path).unwrap().set_len(100_000_000).unwrap();
        let (bytes, message) = read_within_budget(&path);
        assert!(message.contains("the file itself has 100 MB") && message.contains(name), "{name}: {message}");
        assert!(bytes < 100_000, "{name}: {bytes} bytes");
    }
}
