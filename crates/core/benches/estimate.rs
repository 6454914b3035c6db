//! Least squares, error bars and coefficients at the size of a flight of 23 manoeuvres of 2,500 samples.

use std::hint::black_box;

use doublet_core::estimate::{
    Coloured, Fit, FlightFreedom, FlightOutput, FlightWindow, OutputErrorSettings, PooledFit, PooledWindow, Taper,
    Transforms, coloured_covariance, coloured_covariances, flight_output_error, least_squares, pooled,
};
use doublet_core::replay::{Motion, MotionAxis};
use nalgebra::DMatrix;

#[path = "../tests/common/flight.rs"]
mod flight;

fn main() {
    divan::main();
}

/// Manoeuvres and samples of each.
const WINDOWS: usize = 23;
const SAMPLES: usize = 2500;
/// Terms of a lateral coefficient.
const TERMS: usize = 6;
/// Largest lag of the coloured covariance.
const LAGS: usize = 250;

/// Names of the terms.
fn names() -> Vec<String> {
    (0..TERMS).map(|term| format!("t{term}")).collect()
}

/// A constant and five waves, and a measurement no model fits exactly, per manoeuvre.
fn windows() -> Vec<PooledWindow> {
    let window = |index: usize| {
        let x = DMatrix::from_fn(SAMPLES, TERMS, |row, column| {
            let t = row as f64 * 0.01;
            if column == 0 { 1.0 } else { (t * (0.7 + 0.9 * column as f64) + index as f64).sin() }
        });
        let z = (0..SAMPLES).map(|row| x.row(row).sum() + ((row * 7919) % 1009) as f64 * 1e-4).collect();
        PooledWindow { label: format!("w{index}"), x, z }
    };
    (0..WINDOWS).map(window).collect()
}

/// Fits of every manoeuvre alone.
fn fits(windows: &[PooledWindow]) -> Vec<Fit> {
    let names = names();
    windows.iter().filter_map(|window| least_squares(&names, &window.x, &window.z).ok()).collect()
}

/// Pooled fit with a constant per manoeuvre.
fn together(windows: &[PooledWindow]) -> Option<PooledFit> {
    let own: Vec<bool> = (0..TERMS).map(|term| term == 0).collect();
    pooled(&names(), &own, windows).ok()
}

#[divan::bench]
fn least_squares_23x2500_samples_6_terms(bencher: divan::Bencher) {
    let windows = windows();
    bencher.bench(|| fits(black_box(&windows)));
}

#[divan::bench]
fn pooled_57500_samples_28_parameters(bencher: divan::Bencher) {
    let windows = windows();
    bencher.bench(|| together(black_box(&windows)));
}

#[divan::bench]
fn coloured_covariance_69_fits_250_lags(bencher: divan::Bencher) {
    let windows = windows();
    let fits = fits(&windows);
    let settings = Coloured { max_lag: Some(LAGS), taper: Taper::Parzen };
    let mut transforms = Transforms::default();
    bencher.bench_local(|| {
        let of_window = |(fit, window): (&Fit, &PooledWindow)| {
            // The three coefficients of an axis have the same regressors.
            coloured_covariances(&[fit, fit, fit], &window.x, black_box(&settings), &mut transforms)
                .map_or(0, |all| all.len())
        };
        fits.iter().zip(&windows).map(of_window).sum::<usize>()
    });
}

/// The same, every fit by itself.
#[divan::bench]
fn coloured_covariance_69_single_fits_250_lags(bencher: divan::Bencher) {
    let windows = windows();
    let fits = fits(&windows);
    let settings = Coloured { max_lag: Some(LAGS), taper: Taper::Parzen };
    bencher.bench(|| {
        (0..3)
            .flat_map(|_| fits.iter().zip(&windows))
            .map(|(fit, window)| coloured_covariance(fit, &window.x, black_box(&settings)))
            .filter(Result::is_ok)
            .count()
    });
}

/// Derivatives of a lateral axis and what goes with them: 14 derivatives, 4 initial states, 2 biases.
#[divan::bench(sample_count = 5)]
fn output_error_2500_samples_20_parameters(bencher: divan::Bencher) {
    let Some((replay, start)) = flight::replay(SAMPLES) else { return };
    let axis = MotionAxis::Lateral;
    let Ok(flown) = replay.fly(&flight::truth(), &start) else { return };
    let entries: Vec<usize> = (12..flight::TRUTH.len()).collect();
    let mut model = flight::truth();
    entries.iter().for_each(|&entry| model.set(entry, 1.1 * flight::TRUTH[entry].2));
    let noisy = |values: &[f64], deviation: f64| -> Vec<f64> {
        values
            .iter()
            .enumerate()
            .map(|(k, value)| value + deviation * (((k * 7919) % 1009) as f64 / 504.5 - 1.0))
            .collect()
    };
    let measured = vec![
        noisy(&flown.beta_rad, 1e-3),
        noisy(&flown.rates_rad_s[0], 1e-3),
        noisy(&flown.rates_rad_s[2], 1e-3),
        noisy(&flown.euler_rad[0], 1e-3),
        noisy(&flown.specific_force_m_s2[1], 0.05),
    ];
    let motion = Motion::from(&flown);
    let window = FlightWindow {
        label: "w".to_owned(),
        replay: &replay,
        start,
        motion: &motion,
        model,
        measured,
        accelerometer_from_cg_m: None,
    };
    let biases = vec![FlightOutput::SpecificForceY, FlightOutput::Beta];
    let freedom = FlightFreedom { shared: entries, own: Vec::new(), biases };
    let windows = [window];
    bencher.bench(|| {
        let found = flight_output_error(axis, black_box(&windows), &freedom, &OutputErrorSettings::default(), &|| true);
        found.map_or(0, |found| found.fit.names.len())
    });
}
