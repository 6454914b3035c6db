//! Error bars when residuals are coloured.

use doublet_core::estimate::{
    Coloured, PooledWindow, Taper, coloured_covariance, joint_coloured_covariance, least_squares, pooled,
};
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

#[test]
fn joint_coloured_covariance_of_one_fit_is_its_own() {
    let names = ["0", "slope"].map(str::to_owned);
    let windows = ["a", "b"].map(|label| {
        let seed = u64::from(label.as_bytes()[0]);
        PooledWindow { label: label.to_owned(), x: regressors(), z: autoregressive(seed, RHO) }
    });
    let fit = pooled(&names, &[true, false], &windows).unwrap();
    let expected = fit.coloured_covariance(&windows, &Coloured::default()).unwrap();
    let found = joint_coloured_covariance(&[(&fit, &windows)]).unwrap();
    assert!((found - &expected).amax() < 1e-10 * expected.amax());
}

#[test]
fn joint_coloured_covariance_recovers_the_scatter_of_two_fits_with_noise_in_common() {
    const FLIGHTS: u64 = 1500;
    /// Part of the deviation that the second fit's noise has from the first's, twenty samples later.
    const COMMON: f64 = 0.8;
    const LATER: usize = 20;
    let x = regressors();
    let names = ["0", "slope"].map(str::to_owned);
    let (mut stated, mut observed) = (DMatrix::<f64>::zeros(2, 2), DMatrix::<f64>::zeros(2, 2));
    for seed in 0..FLIGHTS {
        let (first, own) = (autoregressive(2 * seed, RHO), autoregressive(2 * seed + 1, RHO));
        let second = (0..SAMPLES).map(|k| {
            let before = if k < LATER { 0.0 } else { first[k - LATER] };
            COMMON * before + (1.0 - COMMON * COMMON).sqrt() * own[k]
        });
        // The second fit has a window of its own beside that in common.
        let window = |label: &str, z: Vec<f64>| PooledWindow { label: label.to_owned(), x: x.clone(), z };
        let one = [window("common", first.clone())];
        let other = [window("own", autoregressive(seed + 1_000_000, RHO)), window("common", second.collect())];
        let fits = [pooled(&names, &[true, false], &one).unwrap(), pooled(&names, &[true, false], &other).unwrap()];
        // Shared parameters come first: the slopes are parameters 0 and, after two of the first fit, 2.
        let joint = joint_coloured_covariance(&[(&fits[0], &one), (&fits[1], &other)]).unwrap();
        let slopes = fits.map(|fit| fit.fit.estimates[0]);
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            stated[(i, j)] += joint[(2 * i, 2 * j)] / FLIGHTS as f64;
            observed[(i, j)] += slopes[i] * slopes[j] / FLIGHTS as f64;
        }
    }
    let correlation = |of: &DMatrix<f64>| of[(0, 1)] / (of[(0, 0)] * of[(1, 1)]).sqrt();
    println!("correlation of the slopes: stated {:.3}, observed {:.3}", correlation(&stated), correlation(&observed));
    for i in 0..2 {
        let ratio = (stated[(i, i)] / observed[(i, i)]).sqrt();
        assert!((0.93..1.06).contains(&ratio), "error {i}: {ratio}");
    }
    // A correlation of 0.4 over 1,500 flights is known within 0.022.
    assert!(correlation(&observed) > 0.25);
    assert!((correlation(&stated) - correlation(&observed)).abs() < 0.06);
}
