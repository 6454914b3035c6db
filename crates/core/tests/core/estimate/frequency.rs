//! Equation error in the frequency domain.

use doublet_core::estimate::{
    Detrend, EstimateError, FrequencySettings, FrequencyWindow, frequency_equation_error, least_squares,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Step, s.
const STEP_S: f64 = 0.02;

/// A window of two waves inside the band, the measurement with parameters 2 and -3, white noise and a drift.
fn window(seed: u64, noise: f64, drift: f64) -> FrequencyWindow {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let phase = seed as f64;
    let x = DMatrix::from_fn(1500, 2, |row, column| {
        let t = STEP_S * row as f64;
        let envelope = (std::f64::consts::PI * t / 30.0).sin();
        envelope * if column == 0 { (2.3 * t + phase).sin() } else { (4.1 * t).cos() + 0.4 * (1.1 * t).sin() }
    });
    let z = (0..1500)
        .map(|row| {
            let draw: f64 = StandardNormal.sample(&mut rng);
            2.0 * x[(row, 0)] - 3.0 * x[(row, 1)] + noise * draw + drift * STEP_S * row as f64 + 5.0
        })
        .collect();
    FrequencyWindow { step_s: STEP_S, x, z }
}

/// Names of the parameters.
fn names() -> Vec<String> {
    ["a", "b"].map(str::to_owned).to_vec()
}

#[test]
fn frequency_domain_recovers_truth_under_a_drift_that_ruins_the_time_domain() {
    /// Four standard errors as stated by the fit.
    const BAND: f64 = 4.0;
    let windows = [window(1, 0.2, 0.5), window(2, 0.2, -0.3)];
    let fit = frequency_equation_error(&names(), &windows, &FrequencySettings::default()).unwrap();
    for (estimate, (truth, error)) in fit.estimates.iter().zip([2.0, -3.0].iter().zip(&fit.standard_errors)) {
        assert!((estimate - truth).abs() < BAND * error && *error < 0.02, "{estimate} {truth} {error}");
    }
    assert!(fit.quality.r_squared > 0.99);
    let plain = least_squares(&names(), &windows[0].x, &windows[0].z).unwrap();
    assert!((plain.estimates[0] - 2.0).abs() > 0.05 || (plain.estimates[1] + 3.0).abs() > 0.05);
}

#[test]
fn frequency_domain_without_noise_is_exact_for_either_detrending() {
    for detrend in [Detrend::Mean, Detrend::Ends] {
        let settings = FrequencySettings { detrend, ..FrequencySettings::default() };
        let fit = frequency_equation_error(&names(), &[window(3, 0.0, 0.0)], &settings).unwrap();
        approx::assert_relative_eq!(fit.estimates[0], 2.0, max_relative = 1e-10);
        approx::assert_relative_eq!(fit.estimates[1], -3.0, max_relative = 1e-10);
    }
}

#[test]
fn constant_regressor_and_bad_grid_are_rejected() {
    let mut constant = window(4, 0.1, 0.0);
    constant.x.column_mut(1).fill(1.0);
    let error = frequency_equation_error(&names(), &[constant], &FrequencySettings::default()).unwrap_err();
    assert!(error.to_string().contains("'b' is zero throughout"), "{error}");
    let beyond = FrequencySettings { highest_hz: 30.0, ..FrequencySettings::default() };
    assert!(matches!(
        frequency_equation_error(&names(), &[window(5, 0.1, 0.0)], &beyond),
        Err(EstimateError::Setting { .. })
    ));
}
