//! Samples held by a recorder that is faster than the sensor, and what only looks like it.

use doublet_core::prep::held_samples;
use doublet_core::series::Series;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// 60 s at 50 Hz.
fn series(value: impl FnMut(f64) -> f64) -> Series {
    let time: Vec<f64> = (0..3000).map(|k| 0.02 * f64::from(k)).collect();
    Series { values: time.iter().copied().map(value).collect(), time_s: time.into() }
}

fn motion(t: f64) -> f64 {
    0.1 * (1.3 * t).sin() + 0.03 * (4.1 * t).cos()
}

/// A sensor of `rate_hz` whose last value the recorder repeats; its clock is not the recorder's.
fn held(rate_hz: f64) -> Series {
    series(|t| motion(((t - 0.013) * rate_hz + 1e-9).floor() / rate_hz + 0.013))
}

#[test]
fn held_values_are_found_at_every_ratio_of_rates_and_kept_once() {
    for rate_hz in [25.0, 20.0, 16.7, 10.0, 4.0, 1.0] {
        let recorded = held(rate_hz);
        let found = held_samples(&recorded).unwrap_or_else(|| panic!("{rate_hz} Hz"));
        assert!((found.rate_hz() / rate_hz - 1.0).abs() < 0.01, "{rate_hz}: {}", found.rate_hz());
        assert!((found.period * rate_hz / 50.0 - 1.0).abs() < 0.01, "{rate_hz}: {}", found.period);
        // A kept sample is at most one interval of the recorder younger than its value.
        for (time, value) in found.own.time_s.iter().zip(&*found.own.values).skip(1) {
            let slope = 0.13 + 0.123;
            assert!((value - motion(*time)).abs() <= slope * 0.0201, "{rate_hz} at {time}");
        }
    }
}

#[test]
fn a_value_the_sensor_gives_twice_counts_twice() {
    // Still for 20 s in the middle.
    let still = |t: f64| if (20.0..40.0).contains(&t) { 0.05 } else { motion(t) };
    let found = held_samples(&series(|t| still((t * 5.0 + 1e-9).floor() / 5.0))).unwrap();
    assert_eq!(found.own.time_s.len(), 300);
    let largest = found.own.time_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(largest < 0.21, "{largest}");
}

#[test]
fn coarse_scales_constants_and_steps_are_no_held_samples() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = |sigma: f64| sigma * rng.sample::<f64, _>(StandardNormal);
    let foot = |height: f64| (height / 0.3048).round() * 0.3048;
    // Pressure altitude in feet: climbing evenly, level with noise, in a slow phugoid.
    assert_eq!(held_samples(&series(|t| foot(1000.0 + 2.0 * t))), None);
    assert_eq!(held_samples(&series(|_| foot(1000.0 + noise(0.2)))), None);
    assert_eq!(held_samples(&series(|t| foot(1000.0 + 30.0 * (0.15 * t).sin()))), None);
    // Steady flight on a fine scale, a constant, a staircase of a control, a signal of its own rate.
    assert_eq!(held_samples(&series(|_| (noise(1e-3) / 5e-4).round() * 5e-4)), None);
    assert_eq!(held_samples(&series(|_| 3.0)), None);
    assert_eq!(held_samples(&series(|t| f64::from(u8::from((t / 3.0).fract() < 0.5)))), None);
    assert_eq!(held_samples(&series(motion)), None);
}
