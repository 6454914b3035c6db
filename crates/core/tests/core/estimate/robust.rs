//! Huber's weights: against iteratively reweighted least squares, against truth under contaminated and under normal noise.

use doublet_core::estimate::{HUBER_LIMIT, PooledRegression, PooledWindow, weighted_least_squares};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const TRUTH: [f64; 3] = [0.3, -1.2, 0.05];
const SEEDS: u64 = 200;

/// Two windows of three regressors, the first a constant per window; a part of the samples has ten times the noise.
fn regression(seed: u64, contaminated: f64) -> PooledRegression {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut window = |label: &str, start: f64| {
        let x = DMatrix::from_fn(200, 3, |row, column| {
            let time = start + row as f64 * 0.05;
            [1.0, (1.3 * time).sin(), (3.1 * time + 0.4).cos()][column]
        });
        let z = x.row_iter().map(|row| {
            let normal: f64 = StandardNormal.sample(&mut random);
            let size = if random.random_bool(contaminated) { 0.5 } else { 0.05 };
            row.iter().zip(TRUTH).map(|(x, parameter)| x * parameter).sum::<f64>() + size * normal
        });
        let z = z.collect();
        PooledWindow { label: label.to_owned(), x, z }
    };
    let windows = vec![window("a", 0.0), window("b", 17.0)];
    PooledRegression {
        names: ["C0", "C_a", "C_b"].map(String::from).to_vec(),
        per_window: vec![true, false, false],
        constraints: Vec::new(),
        windows,
    }
}

#[test]
fn pseudo_values_give_what_reweighting_gives() {
    let regression = regression(3, 0.1);
    let found = regression.with_pseudo_values().unwrap().fit().unwrap();
    let all = doublet_core::estimate::stacked(&regression.names, &regression.per_window, &regression.windows).unwrap();
    // The scale of the M-estimate's own residuals, and from there weights until nothing moves.
    let residuals = |estimates: &[f64]| -> Vec<f64> {
        let fitted = &all.x * nalgebra::DVector::from_column_slice(estimates);
        all.z.iter().zip(fitted.iter()).map(|(z, y)| z - y).collect()
    };
    let mut sizes: Vec<f64> = residuals(&found.fit.estimates).iter().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = HUBER_LIMIT * 0.5 * (sizes[199] + sizes[200]) / 0.6745;
    let mut estimates = vec![0.0; all.names.len()];
    for _ in 0..200 {
        let weights: Vec<f64> = residuals(&estimates).iter().map(|v| (limit / v.abs()).min(1.0)).collect();
        estimates = weighted_least_squares(&all.names, &all.x, &all.z, &weights).unwrap().estimates;
    }
    for ((found, expected), error) in found.fit.estimates.iter().zip(&estimates).zip(&found.fit.standard_errors) {
        assert!((found - expected).abs() < 0.01 * error, "{found} {expected}, error {error}");
    }
}

#[test]
fn errors_under_contaminated_noise_are_half_those_of_equal_weights() {
    let mut squares = [0.0; 2];
    for seed in 0..SEEDS {
        let regression = regression(seed, 0.1);
        let fits = [regression.fit(), regression.with_pseudo_values().and_then(|pseudo| pseudo.fit())];
        for (square, fit) in squares.iter_mut().zip(fits) {
            *square += (fit.unwrap().fit.parameter("C_a").unwrap().0 - TRUTH[1]).powi(2);
        }
    }
    let ratio = (squares[1] / squares[0]).sqrt();
    println!("error {ratio:.2} of that of equal weights");
    assert!(ratio < 0.5, "{ratio}");
}

#[test]
fn intervals_under_normal_noise_hold_the_truth_and_are_hardly_longer() {
    let (mut inside, mut ratio) = (0, 0.0);
    for seed in 0..SEEDS {
        let regression = regression(seed, 0.0);
        let equal = regression.fit().unwrap().fit;
        let huber = regression.with_pseudo_values().unwrap().fit().unwrap().fit;
        for (name, truth) in [("C_a", TRUTH[1]), ("C_b", TRUTH[2])] {
            let (estimate, error) = huber.parameter(name).unwrap();
            inside += usize::from((estimate - truth).abs() < 1.96 * error);
            ratio += error / equal.parameter(name).unwrap().1;
        }
    }
    let (part, ratio) = (inside as f64 / (2 * SEEDS) as f64, ratio / (2 * SEEDS) as f64);
    println!("{:.1} % inside, errors {ratio:.3} of those of equal weights", 100.0 * part);
    assert!((0.92..0.98).contains(&part), "{part}");
    // 95 % efficiency: the errors grow by 1 / sqrt(0.95).
    assert!((1.0..1.06).contains(&ratio), "{ratio}");
}

#[test]
fn an_exact_fit_stays_exact() {
    let mut exact = regression(1, 0.0);
    for window in &mut exact.windows {
        window.z = window.x.column(1).iter().map(|x| 2.0 * x).collect();
    }
    let found = exact.with_pseudo_values().unwrap().fit().unwrap();
    approx::assert_relative_eq!(found.fit.parameter("C_a").unwrap().0, 2.0, max_relative = 1e-12);
}
