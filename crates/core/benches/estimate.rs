//! Least squares, error bars and coefficients at the size of a flight of 23 manoeuvres of 2,500 samples.

use std::hint::black_box;

use doublet_core::estimate::{
    Coloured, Fit, PooledFit, PooledWindow, Taper, coloured_covariance, least_squares, pooled,
};
use nalgebra::DMatrix;

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
    let settings = Coloured { max_lag: Some(LAGS), taper: Taper::Triangular };
    bencher.bench(|| {
        (0..3)
            .flat_map(|_| fits.iter().zip(&windows))
            .map(|(fit, window)| coloured_covariance(fit, &window.x, black_box(&settings)))
            .filter(Result::is_ok)
            .count()
    });
}
