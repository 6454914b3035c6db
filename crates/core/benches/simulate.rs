//! How long a whole flight takes to fly, to record and to encode.

use doublet_core::simulate::{run, scenario};

fn main() {
    divan::main();
}

/// The 90-minute flight: 540,000 steps, all channels, truth at 100 Hz, all files.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn flight_540000_steps_with_all_files(bencher: divan::Bencher<'_, '_>) {
    let Ok(scenario) = scenario::build("ft1") else { return };
    bencher.bench_local(|| run(&scenario, 1, &mut |_| true).and_then(|flight| flight.files()));
}

/// The same without the files.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn flight_540000_steps(bencher: divan::Bencher<'_, '_>) {
    let Ok(scenario) = scenario::build("ft1") else { return };
    bencher.bench_local(|| run(&scenario, 1, &mut |_| true));
}
