//! Instrumental variables against ordinary least squares, on flights whose gusts no vane shows.

use doublet_core::estimate::{Coloured, EstimateError, coloured_covariance, instrumental_variables, least_squares};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const STEP_S: f64 = 0.02;
const WINDOWS: usize = 6;
const SAMPLES: usize = 500;
/// Pitch acceleration by alpha, 1/s2, by pitch rate, 1/s, and by elevator, 1/s2.
const TRUTH: [f64; 3] = [-8.0, -2.0, -12.0];
const GUST_TIME_S: f64 = 1.5;

/// Windows of 10 s with an elevator doublet each, in gusts of `gust_rad` rms of the angle of attack: pitch acceleration, the angle of
/// attack of the path, pitch rate, elevator, and a constant.
fn flight(seed: u64, gust_rad: f64) -> (DMatrix<f64>, Vec<f64>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
    let (mut x, mut z) = (DMatrix::zeros(WINDOWS * SAMPLES, 4), Vec::new());
    let mut gust = gust_rad * white();
    let kept = (-STEP_S / GUST_TIME_S).exp();
    for window in 0..WINDOWS {
        let (mut alpha, mut q) = (0.0, 0.0);
        let half_s = 0.4 + 0.15 * window as f64;
        for sample in 0..SAMPLES {
            let since = sample as f64 * STEP_S - 1.0;
            let elevator = match since {
                t if (0.0..half_s).contains(&t) => 0.04,
                t if (half_s..2.0 * half_s).contains(&t) => -0.04,
                _ => 0.0,
            };
            let acceleration = TRUTH[0] * (alpha + gust) + TRUTH[1] * q + TRUTH[2] * elevator;
            let row = [1.0, alpha, q, elevator];
            for (column, value) in row.into_iter().enumerate() {
                x[(window * SAMPLES + sample, column)] = value;
            }
            z.push(acceleration + 0.002 * white());
            alpha += STEP_S * (q - 1.5 * (alpha + gust) - 0.1 * elevator);
            q += STEP_S * acceleration;
            gust = kept * gust + gust_rad * (1.0 - kept * kept).sqrt() * white();
        }
    }
    (x, z)
}

fn names() -> Vec<String> {
    ["0", "alpha", "q", "delta_e"].map(str::to_owned).to_vec()
}

const IS_INPUT: [bool; 4] = [true, false, false, true];

fn rows() -> Vec<std::ops::Range<usize>> {
    (0..WINDOWS).map(|window| window * SAMPLES..(window + 1) * SAMPLES).collect()
}

#[test]
fn gusts_that_bias_least_squares_leave_the_estimates_by_instruments_right() {
    let (mut least, mut held, mut within, mut count) = ([0.0; 3], 0, 0, 0);
    let mut mean = [0.0; 3];
    for seed in 0..40 {
        let (x, z) = flight(seed, 0.01);
        let ordinary = least_squares(&names(), &x, &z).unwrap();
        let errors = coloured_covariance(&ordinary, &x, &Coloured::default()).unwrap();
        let found = instrumental_variables((&names(), &x, &z), &IS_INPUT, &rows(), STEP_S).unwrap();
        let covariance = found.coloured_covariance(&rows(), &Coloured::default()).unwrap();
        for (k, truth) in TRUTH.into_iter().enumerate() {
            least[k] += ordinary.estimates[k + 1] / truth / 40.0;
            mean[k] += found.fit.estimates[k + 1] / truth / 40.0;
            let off = |value: f64, variance: f64| (value - truth).abs() / variance.sqrt();
            held += usize::from(off(ordinary.estimates[k + 1], errors[(k + 1, k + 1)]) < 2.0);
            within += usize::from(off(found.fit.estimates[k + 1], covariance[(k + 1, k + 1)]) < 2.0);
            count += 1;
        }
    }
    println!(
        "least squares {least:?}, instruments {mean:?} of the truth; within two errors {held} and {within} of {count}"
    );
    assert!(least[0] < 0.8, "{least:?}");
    for (k, mean) in mean.into_iter().enumerate() {
        assert!((mean - 1.0).abs() < 0.1, "{k}: {mean}");
    }
    assert!(within * 10 > count * 9, "{within} of {count}");
    assert!(held < within, "{held}");
}

#[test]
fn flight_without_gusts_and_noise_is_exact() {
    let (x, mut z) = flight(1, 0.0);
    for (sample, z) in z.iter_mut().enumerate() {
        *z = TRUTH[0] * x[(sample, 1)] + TRUTH[1] * x[(sample, 2)] + TRUTH[2] * x[(sample, 3)];
    }
    let found = instrumental_variables((&names(), &x, &z), &IS_INPUT, &rows(), STEP_S).unwrap();
    for (estimate, truth) in found.fit.estimates[1..].iter().zip(TRUTH) {
        approx::assert_relative_eq!(*estimate, truth, max_relative = 1e-9);
    }
}

#[test]
fn controls_at_rest_are_no_instruments() {
    let (mut x, z) = flight(2, 0.01);
    x.column_mut(3).fill(0.0);
    let x = x.columns(0, 3).into_owned();
    let found = instrumental_variables((&names()[..3], &x, &z), &IS_INPUT[..3], &rows(), STEP_S);
    assert!(matches!(found, Err(EstimateError::Setting { value: 0.0, .. })), "{found:?}");
    let found = instrumental_variables((&names()[..3], &x, &z), &IS_INPUT, &rows(), STEP_S);
    assert!(matches!(found, Err(EstimateError::Size { .. })), "{found:?}");
}
