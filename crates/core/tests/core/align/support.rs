//! A flight's quantities as smooth functions of time, sampled by any clock.

use doublet_core::align::ClockModel;
use doublet_core::series::Series;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Bursts of oscillation at irregular times: manoeuvres of a flight.
pub struct Motion {
    bursts: Vec<[f64; 4]>,
}

impl Motion {
    /// Bursts over `duration_s` from a seed.
    pub fn new(duration_s: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut time = 20.0;
        let mut bursts = Vec::new();
        while time < duration_s - 20.0 {
            let amplitude = 0.05 + 0.1 * rng.random::<f64>();
            bursts.push([time, amplitude, 1.0 + 2.0 * rng.random::<f64>(), 0.2 + 0.4 * rng.random::<f64>()]);
            time += 20.0 + 40.0 * rng.random::<f64>();
        }
        Self { bursts }
    }

    /// Value at a time: each burst begins at rest and dies out.
    pub fn at(&self, time_s: f64) -> f64 {
        let burst = |[start, amplitude, omega, damping]: &[f64; 4]| {
            let t = time_s - start;
            if t <= 0.0 { 0.0 } else { amplitude * t * t * (-damping * t).exp() * (omega * t).sin() }
        };
        self.bursts.iter().map(burst).sum::<f64>() + 0.02 * (0.01 * time_s).sin()
    }

    /// What a recorder of this clock and rate writes from reference time 0 to `duration_s`, with white noise and a
    /// resolution.
    pub fn record(&self, clock: ClockModel, rate_hz: f64, duration_s: f64, errors: [f64; 2], seed: u64) -> Series {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [noise, resolution] = errors;
        let first = (clock.own_s(0.0) * rate_hz).ceil() as i64;
        let last = (clock.own_s(duration_s) * rate_hz).floor() as i64;
        let (time, values): (Vec<f64>, Vec<f64>) = (first..=last)
            .map(|k| {
                let own = k as f64 / rate_hz;
                let value = self.at(clock.reference_s(own)) + noise * rng.sample::<f64, _>(StandardNormal);
                (own, if resolution > 0.0 { (value / resolution).round() * resolution } else { value })
            })
            .unzip();
        Series { time_s: time.into(), values: values.into() }
    }
}
