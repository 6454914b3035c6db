//! Estimates that go on as samples come, against those of all samples at once.

use doublet_core::estimate::{
    Coloured, Detrend, EstimateError, Fit, FrequencySettings, FrequencyWindow, RecursiveFourier, RecursiveLeastSquares,
    Taper, coloured_covariance, frequency_equation_error, least_squares,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Step, s.
const STEP_S: f64 = 0.02;
/// Agreement of the recursion with all samples at once, relative.
const EQUAL: f64 = 1e-9;

fn names() -> Vec<String> {
    ["a", "b"].map(str::to_owned).to_vec()
}

/// Rows `[z, a, b]` of a record with parameters `of(row)`, an offset of 5, a drift and white noise.
fn rows(seed: u64, samples: usize, noise: f64, drift: f64, of: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 3]> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let phase = seed as f64;
    let row = |row: usize| {
        let t = STEP_S * row as f64;
        let a = 0.3 + (2.3 * t + phase).sin();
        let b = (4.1 * t).cos() + 0.4 * (1.1 * t).sin();
        let draw: f64 = StandardNormal.sample(&mut rng);
        let [first, second] = of(row);
        [first * a + second * b + 5.0 + drift * t + noise * draw, a, b]
    };
    (0..samples).map(row).collect()
}

fn columns(rows: &[[f64; 3]]) -> (DMatrix<f64>, Vec<f64>) {
    let x = DMatrix::from_fn(rows.len(), 2, |row, column| rows[row][column + 1]);
    (x, rows.iter().map(|row| row[0]).collect())
}

fn recursive_fit(rows: &[[f64; 3]], settings: &FrequencySettings, forgetting_s: Option<f64>) -> (Fit, f64) {
    let mut transforms = RecursiveFourier::new(3, STEP_S, settings, forgetting_s).unwrap();
    rows.iter().for_each(|row| transforms.push(row));
    (transforms.fit(&names(), 0, &[1, 2]).unwrap(), transforms.covariance_factor())
}

#[test]
fn recursive_fourier_regression_matches_the_batch_at_the_last_sample() {
    for detrend in [Detrend::Mean, Detrend::Ends] {
        let settings = FrequencySettings { detrend, ..FrequencySettings::default() };
        for samples in [400, 1500, 20_000] {
            let rows = rows(7, samples, 0.2, 0.3, |_| [2.0, -3.0]);
            let (x, z) = columns(&rows);
            let window = FrequencyWindow { step_s: STEP_S, x, z };
            let batch = frequency_equation_error(&names(), &[window], &settings).unwrap();
            let (found, _) = recursive_fit(&rows, &settings, None);
            for k in 0..2 {
                approx::assert_relative_eq!(found.estimates[k], batch.estimates[k], max_relative = EQUAL);
                approx::assert_relative_eq!(found.standard_errors[k], batch.standard_errors[k], max_relative = EQUAL);
            }
        }
    }
}

#[test]
fn recursive_least_squares_matches_the_batch_at_the_last_sample() {
    const LAGS: usize = 25;
    let rows = rows(3, 3000, 0.2, 0.0, |_| [2.0, -3.0]);
    let names = ["0", "a", "b"].map(str::to_owned);
    let mut recursion = RecursiveLeastSquares::new(&names, None, LAGS, Taper::None).unwrap();
    rows.iter().for_each(|row| recursion.push(&[1.0, row[1], row[2]], row[0]));
    let found = recursion.estimate().unwrap();
    let (x, z) = columns(&rows);
    let x = x.insert_column(0, 1.0);
    let batch = least_squares(&names, &x, &z).unwrap();
    let coloured = coloured_covariance(&batch, &x, &Coloured { max_lag: Some(LAGS), taper: Taper::None }).unwrap();
    for k in 0..3 {
        approx::assert_relative_eq!(found.estimates[k], batch.estimates[k], max_relative = EQUAL);
        approx::assert_relative_eq!(found.standard_errors[k], batch.standard_errors[k], max_relative = EQUAL);
        let corrected = coloured[(k, k)].sqrt();
        approx::assert_relative_eq!(found.corrected_standard_errors[k], corrected, max_relative = EQUAL);
    }
    approx::assert_relative_eq!(found.residual_std, batch.residual_std, max_relative = EQUAL);
}

#[test]
fn error_bars_of_the_recursion_match_the_scatter_of_repeats() {
    /// Repeats; their scatter is known within 1 / sqrt(2 * 400) = 3.5 per cent.
    const REPEATS: u64 = 400;
    // Eight seconds: the grid of 0.02 Hz says everything more than six times over.
    let settings = FrequencySettings { detrend: Detrend::Mean, ..FrequencySettings::default() };
    for forgetting_s in [None, Some(4.0)] {
        let (mut square, mut variance) = ([0.0; 2], [0.0; 2]);
        for seed in 0..REPEATS {
            let mut rows = rows(1, 400, 0.0, 0.0, |_| [2.0, -3.0]);
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            rows.iter_mut().for_each(|row| {
                let draw: f64 = StandardNormal.sample(&mut rng);
                row[0] += 0.5 * draw;
            });
            let (fit, factor) = recursive_fit(&rows, &settings, forgetting_s);
            for k in 0..2 {
                square[k] += (fit.estimates[k] - [2.0, -3.0][k]).powi(2);
                variance[k] += fit.covariance[(k, k)] * factor;
            }
        }
        for k in 0..2 {
            let ratio = (variance[k] / square[k]).sqrt();
            println!("forgetting {forgetting_s:?}, parameter {k}: stated over observed {ratio:.3}");
            assert!((0.85..1.2).contains(&ratio), "{forgetting_s:?} {k}: {ratio}");
        }
    }
}

#[test]
fn forgetting_follows_a_parameter_that_changes() {
    let rows = rows(5, 6000, 0.1, 0.0, |row| if row < 3000 { [2.0, -3.0] } else { [4.0, -1.0] });
    let settings = FrequencySettings { detrend: Detrend::Mean, ..FrequencySettings::default() };
    // Sixty seconds after the change, six forgetting times: e^-6 of what was.
    let (faded, _) = recursive_fit(&rows, &settings, Some(10.0));
    let (all, _) = recursive_fit(&rows, &settings, None);
    assert!(
        (faded.estimates[0] - 4.0).abs() < 0.05 && (faded.estimates[1] + 1.0).abs() < 0.05,
        "{:?}",
        faded.estimates
    );
    assert!((all.estimates[0] - 4.0).abs() > 0.5, "{:?}", all.estimates);
    let mut recursion = RecursiveLeastSquares::new(&names(), Some(500.0), 0, Taper::None).unwrap();
    rows.iter().for_each(|row| recursion.push(&[row[1], row[2]], row[0] - 5.0));
    let found = recursion.estimate().unwrap();
    assert!((found.estimates[0] - 4.0).abs() < 0.05 && (found.estimates[1] + 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn missing_samples_leave_the_regression_exact() {
    let rows = rows(9, 1500, 0.0, 0.0, |_| [2.0, -3.0]);
    let settings = FrequencySettings { detrend: Detrend::Mean, ..FrequencySettings::default() };
    let mut transforms = RecursiveFourier::new(3, STEP_S, &settings, Some(30.0)).unwrap();
    for (k, row) in rows.iter().enumerate() {
        match k {
            500..600 => transforms.skip(1),
            _ if k % 13 == 0 => transforms.push(&[f64::NAN, row[1], row[2]]),
            _ => transforms.push(row),
        }
    }
    let fit = transforms.fit(&names(), 0, &[1, 2]).unwrap();
    // What is summed twice at the ends of a gap is the integral's quadrature, the same for both sides.
    approx::assert_relative_eq!(fit.estimates[0], 2.0, max_relative = 1e-10);
    approx::assert_relative_eq!(fit.estimates[1], -3.0, max_relative = 1e-10);
}

#[test]
fn recursion_refuses_what_it_cannot_do() {
    let ends = FrequencySettings::default();
    assert!(matches!(RecursiveFourier::new(3, STEP_S, &ends, Some(10.0)), Err(EstimateError::Setting { .. })));
    assert!(matches!(RecursiveFourier::new(3, 1.0, &ends, None), Err(EstimateError::Setting { .. })));
    let empty = RecursiveFourier::new(3, STEP_S, &ends, None).unwrap();
    assert!(matches!(empty.fit(&names(), 0, &[1, 2]), Err(EstimateError::TooFewSamples { .. })));
    let mut recursion = RecursiveLeastSquares::new(&names(), None, 5, Taper::Parzen).unwrap();
    for _ in 0..10 {
        recursion.push(&[1.0, 2.0], 1.0);
    }
    assert!(matches!(recursion.estimate(), Err(EstimateError::RankDeficient { .. })));
    assert!(RecursiveLeastSquares::new(&names(), Some(0.5), 5, Taper::Parzen).is_err());
}
