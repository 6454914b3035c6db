//! The simulated Cessna Citation recording with its truth and its published filter result.

use doublet_core::reconstruct::{FilterData, FilterSettings, InputSeries, MeasurementSeries};

use crate::shared::shared;

pub struct Citation {
    pub data: FilterData,
    /// True states, column by column.
    pub truth: [Vec<f64>; 18],
}

/// Gravity the published filter used, m/s^2.
pub const REFERENCE_GRAVITY: f64 = 9.803;
/// Gravity of the simulator, m/s^2.
pub const TRUE_GRAVITY: f64 = 9.803_57;

/// The recording, or `None` where the shared folder is absent.
pub fn load() -> Option<Citation> {
    let path = shared("data/citation_simulated/da3211_1_noisy_with_truth.mat")?;
    let mut probe = doublet_core::load::probe(&path).unwrap();
    probe.complete().unwrap();
    let channel = |name: String| -> Vec<f64> {
        let found = probe.sources.iter().flat_map(|source| &source.channels).find(|channel| channel.name == name);
        found.unwrap_or_else(|| panic!("no channel {name}")).values().to_vec()
    };
    let time_s = channel("t".into());
    let columns = std::array::from_fn(|i| channel(format!("u_IMU[{i}]")).into());
    let measured =
        |m: usize| MeasurementSeries { time_s: time_s.clone().into(), values: channel(format!("z_m[{m}]")).into() };
    Some(Citation {
        data: FilterData {
            inputs: InputSeries { time_s: time_s.clone().into(), columns },
            measurements: std::array::from_fn(measured),
        },
        truth: std::array::from_fn(|i| channel(format!("x_true[{i}]"))),
    })
}

/// Settings of the published filter apart from hold, linearisation, method and gravity.
pub fn settings() -> FilterSettings {
    let deg = std::f64::consts::PI / 180.0;
    let mut initial_deviation = [0.0; 18];
    for (k, deviation) in initial_deviation.iter_mut().enumerate() {
        *deviation = [10.0, 5.0, 2.0 * deg, 0.1, 0.05 * deg, 20.0][k / 3];
    }
    FilterSettings {
        gravity_m_s2: REFERENCE_GRAVITY,
        process_noise: [0.02, 0.02, 0.03, 0.005 * deg, 0.005 * deg, 0.002 * deg],
        measurement_noise: [
            1.0,
            1.0,
            1.0,
            0.01,
            0.01,
            0.01,
            0.04 * deg,
            0.04 * deg,
            0.04 * deg,
            0.2,
            0.1 * deg,
            0.25 * deg,
        ],
        initial_deviation,
        ..FilterSettings::default()
    }
}
