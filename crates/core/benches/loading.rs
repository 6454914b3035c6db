//! Time from a loading to mass, centre of gravity, inertia and envelope: what a slider waits for.

use std::path::Path;

use divan::Bencher;
use doublet_core::airframe::{Aircraft, FuelSplit, LoadedState, MassHistory};
use doublet_core::load::aircraft;

fn main() {
    divan::main();
}

#[expect(clippy::unwrap_used, reason = "a shipped aircraft file that does not read must stop the bench")]
fn c337f() -> Aircraft {
    aircraft::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/aircraft/c337f.toml")).unwrap()
}

#[divan::bench]
fn mass_properties_c337f_4tanks_4seats_17groups(bencher: Bencher) {
    let aircraft = c337f();
    bencher.bench_local(|| divan::black_box(&aircraft.standard_loading).mass_properties(&aircraft));
}

#[divan::bench]
fn loaded_state_with_envelope_and_principal_axes_c337f(bencher: Bencher) {
    let aircraft = c337f();
    bencher.bench_local(|| LoadedState::new("slider", &aircraft, divan::black_box(&aircraft.standard_loading)));
}

#[divan::bench]
fn mass_history_c337f_10000samples(bencher: Bencher) {
    let aircraft = c337f();
    let time_s: Vec<f64> = (0..10_000).map(f64::from).collect();
    let fuel_kg: Vec<f64> = time_s.iter().map(|t| 373.2 - 0.01 * t).collect();
    bencher.bench_local(|| {
        MassHistory::from_total_fuel(&aircraft, &aircraft.standard_loading, &time_s, &fuel_kg, &FuelSplit::Proportional)
    });
}
