//! From one changed noise entry to new derivatives of every window of the shipped flight: the time a drag of a slider takes.
//!
//! Prints the median of several changes, nothing read or aligned again.

use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use doublet_core::reconstruct::Input;
use doublet_engine::builtin;
use doublet_engine::graph::Cache;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{Edit, NoiseChannel, parse};

/// Changes timed.
const CHANGES: usize = 15;

fn main() {
    let Some(mut session) = builtin::session("demo").and_then(|text| parse(text).ok()) else { return };
    let cache = Cache::new(1 << 30);
    let latest = Mutex::new(Snapshot::default());
    let mut times = Vec::new();
    for change in 0..=CHANGES {
        let noise = 4e-4 * (1.0 + 0.01 * change as f64);
        let Ok(edited) = Edit::noise(NoiseChannel::Input(Input::RollRate), noise).apply(&session) else { return };
        session = edited;
        let scope = Scope {
            session: &session,
            folder: Path::new("."),
            first: None,
            studies: &[],
            cause: "bench",
            generation: change as u64,
        };
        let previous = latest.lock().map(|snapshot| snapshot.clone()).unwrap_or_default();
        let start = Instant::now();
        let snapshot = run(&scope, &previous, &cache, &Control::default(), &|_| ());
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if let Some((place, error)) = snapshot.failures().first() {
            report(&format!("{place}: {error}"));
            return;
        }
        if let Ok(mut latest) = latest.lock() {
            *latest = snapshot;
        }
    }
    let first = times.remove(0);
    times.sort_by(f64::total_cmp);
    report(&format!("demo_flight_from_files            {first:8.1} ms"));
    report(&format!(
        "noise_entry_22windows_671samples  {:8.1} ms median, {:.1} to {:.1} ms",
        times[times.len() / 2],
        times[0],
        times[times.len() - 1]
    ));
}

#[expect(clippy::print_stdout, reason = "a bench prints its result")]
fn report(line: &str) {
    println!("{line}");
}
