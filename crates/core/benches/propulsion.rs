//! Engine model over a whole flight.

use std::hint::black_box;
use std::path::PathBuf;

use doublet_core::load::aircraft;
use doublet_core::load::propulsion_maps::parse_propulsion_section;
use doublet_core::load::read_text;
use doublet_core::propulsion::{EngineColumns, Powerplant};

fn main() {
    divan::main();
}

/// 90 minutes at 2 Hz.
const SAMPLES: usize = 10_800;

/// The two engines of the shipped C337F; none where its files cannot be read, which the benchmark refuses.
fn powerplant() -> Powerplant {
    let assets = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let file = assets.join("aircraft/c337f.toml");
    let stations = aircraft::read(&file).map(|aircraft| aircraft.engines).unwrap_or_default();
    let section = parse_propulsion_section(&read_text(&file).unwrap_or_default(), &file).unwrap_or_default();
    section.powerplant(&stations, &assets.join("propulsion"), read_text).unwrap_or_default()
}

/// `middle` with a slow swing of `amplitude` over the flight.
fn column(middle: f64, amplitude: f64) -> Vec<f64> {
    (0..SAMPLES).map(|k| middle + amplitude * (0.01 * k as f64).sin()).collect()
}

#[divan::bench]
fn both_engines_10800samples(bencher: divan::Bencher) {
    let powerplant = powerplant();
    assert_eq!(powerplant.engines.iter().filter(|engine| engine.model.is_some()).count(), 2);
    let columns = [
        column(246.0, 60.0),
        column(65_000.0, 25_000.0),
        column(50.0, 35.0),
        column(800.0, 900.0),
        column(285.0, 8.0),
        column(1.1, 0.1),
    ];
    let [speed, pressure, airspeed, altitude, temperature, density] = &columns;
    bencher.bench(|| {
        for engine in &powerplant.engines {
            let columns = EngineColumns {
                speed_rad_s: speed,
                manifold_pressure_pa: pressure,
                airspeed_m_s: airspeed,
                pressure_altitude_m: altitude,
                air_temperature_k: temperature,
                density_kg_m3: density,
            };
            black_box(engine.model.as_ref().map(|model| model.history(&columns)));
        }
    });
}
