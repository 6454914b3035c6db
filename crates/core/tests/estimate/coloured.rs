//! Error bars when residuals are coloured.

use doublet_core::estimate::{Coloured, PooledWindow, Taper, coloured_covariance, least_squares, pooled};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Samples of one realisation.
const SAMPLES: usize = 1000;
/// Realisations; the scatter over them is known within 1/sqrt(2 * 4000) = 1.1 per cent.
const REALISATIONS: u64 = 4000;
/// Correlation of successive residuals.
const RHO: f64 = 0.9;

/// A slow doublet train and a constant, so that residuals and regressors share their frequencies.
fn regressors() -> DMatrix<f64> {
    DMatrix::from_fn(SAMPLES, 2, |row, column| {
        if column == 0 { 1.0 } else { (row as f64 * 0.02).sin() + 0.5 * (row as f64 * 0.05).cos() }
    })
}

/// First-order autoregressive noise of unit variance.
fn autoregressive(seed: u64, rho: f64) -> Vec<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut value = draw();
    (0..SAMPLES)
        .map(|_| {
            value = rho * value + (1.0 - rho * rho).sqrt() * draw();
            value
        })
        .collect()
}

/// Mean conventional, mean corrected (root mean square over realisations) and observed standard error of the slope.
fn errors_of_slope(rho: f64, settings: &Coloured) -> (f64, f64, f64) {
    let x = regressors();
    let names = ["0", "slope"].map(str::to_owned);
    let (mut conventional, mut corrected, mut scatter) = (0.0, 0.0, 0.0);
    for seed in 0..REALISATIONS {
        let z: Vec<f64> = autoregressive(seed, rho).iter().zip(x.column(1).iter()).map(|(v, x)| v + 2.0 * x).collect();
        let fit = least_squares(&names, &x, &z).unwrap();
        conventional += fit.covariance[(1, 1)];
        corrected += coloured_covariance(&fit, &x, settings).unwrap()[(1, 1)];
        scatter += (fit.estimates[1] - 2.0).powi(2);
    }
    let mean = |sum: f64| (sum / REALISATIONS as f64).sqrt();
    (mean(conventional), mean(corrected), mean(scatter))
}

#[test]
fn coloured_covariance_recovers_the_scatter_of_autoregressive_residuals() {
    let settings = Coloured { max_lag: Some(100), taper: Taper::Parzen };
    let (conventional, corrected, scatter) = errors_of_slope(RHO, &settings);
    println!("conventional {conventional:.4}, corrected {corrected:.4}, scatter {scatter:.4}");
    // For a first-order process of slow regressors the error is optimistic by about sqrt((1 + rho) / (1 - rho)) = 4.4; the
    // literature names 3 to 5.
    assert!((3.0..5.0).contains(&(scatter / conventional)), "optimism {}", scatter / conventional);
    // Within three times the uncertainty of the scatter; the taper takes a little.
    assert!((0.94..1.035).contains(&(corrected / scatter)), "corrected over scatter {}", corrected / scatter);
}

#[test]
fn coloured_covariance_of_white_residuals_stays_conventional() {
    let settings = Coloured { max_lag: Some(50), taper: Taper::Parzen };
    let (conventional, corrected, scatter) = errors_of_slope(0.0, &settings);
    println!("conventional {conventional:.5}, corrected {corrected:.5}, scatter {scatter:.5}");
    assert!((corrected / conventional - 1.0).abs() < 0.02, "{corrected} {conventional}");
    assert!((conventional / scatter - 1.0).abs() < 0.035, "{conventional} {scatter}");
}

#[test]
fn pooled_coloured_covariance_of_one_window_is_that_of_the_plain_fit() {
    let x = regressors();
    let names = ["0", "slope"].map(str::to_owned);
    let z = autoregressive(3, RHO);
    let settings = Coloured { max_lag: None, taper: Taper::Parzen };
    let plain = least_squares(&names, &x, &z).unwrap();
    let expected = coloured_covariance(&plain, &x, &settings).unwrap();
    let windows = [PooledWindow { label: "a".to_owned(), x, z }];
    let together = pooled(&names, &[false, false], &windows).unwrap();
    let found = together.coloured_covariance(&windows, &settings).unwrap();
    assert!((found - &expected).amax() < 1e-12 * expected.amax());
}
