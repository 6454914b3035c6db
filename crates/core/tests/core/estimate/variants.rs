//! Weights, residual models, constraints, noisy regressors and nonlinear lags.

use doublet_core::estimate::{
    Coloured, Constraint, EstimateError, Origin, PooledRegression, PooledWindow, constrained_least_squares,
    errors_in_variables, generalised_least_squares, least_squares, stacked, summarise, total_least_squares,
    weighted_coloured_covariance, weighted_least_squares,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Seeded standard normal numbers.
fn normal(seed: u64, count: usize) -> Vec<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| StandardNormal.sample(&mut rng)).collect()
}

/// Names of a constant and two slopes.
fn names() -> Vec<String> {
    ["0", "a", "b"].map(str::to_owned).to_vec()
}

/// Constant and two waves.
fn regressors(samples: usize) -> DMatrix<f64> {
    DMatrix::from_fn(samples, 3, |row, column| match column {
        0 => 1.0,
        1 => (row as f64 * 0.05).sin(),
        _ => (row as f64 * 0.021 + 1.0).cos() + 0.5 * (row as f64 * 0.05).sin(),
    })
}

/// Measurement with parameters 1, 2, -3 and the given noise.
fn measurement(x: &DMatrix<f64>, noise: &[f64]) -> Vec<f64> {
    x.row_iter().zip(noise).map(|(row, noise)| row[0] + 2.0 * row[1] - 3.0 * row[2] + noise).collect()
}

#[test]
fn weight_of_three_equals_three_copies_of_the_sample() {
    let x = regressors(60);
    let z = measurement(&x, &normal(1, 60));
    let weights: Vec<f64> = (0..60).map(|k| if k % 4 == 0 { 3.0 } else { 1.0 }).collect();
    let rows: Vec<usize> = (0..60).flat_map(|k| vec![k; weights[k] as usize]).collect();
    let copied: Vec<f64> = rows.iter().map(|&k| z[k]).collect();
    let weighted = weighted_least_squares(&names(), &x, &z, &weights).unwrap();
    let repeated = least_squares(&names(), &x.select_rows(&rows), &copied).unwrap();
    for (a, b) in weighted.estimates.iter().zip(&repeated.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-12);
    }
    assert_eq!(weighted.residuals.len(), 60);
    assert!(weighted_least_squares(&names(), &x, &z, &[0.0; 60]).is_err());
}

#[test]
fn generalised_fit_recovers_the_autoregression_and_its_own_scatter() {
    /// Correlation of successive residuals, and how far its estimate may be: three standard errors of 2,000 samples.
    const RHO: f64 = 0.95;
    const RHO_BAND: f64 = 0.025;
    let x = regressors(2000);
    let windows = [0..1200, 1200..2000];
    let (mut ordinary, mut generalised, mut stated) = (0.0, 0.0, 0.0);
    for seed in 0..60 {
        let draws = normal(seed, 2000);
        let mut noise = vec![0.0; 2000];
        for window in &windows {
            noise[window.start] = draws[window.start];
            for k in window.start + 1..window.end {
                noise[k] = RHO * noise[k - 1] + (1.0 - RHO * RHO).sqrt() * draws[k];
            }
        }
        let z = measurement(&x, &noise);
        let fit = generalised_least_squares(&names(), &x, &z, &windows, 1).unwrap();
        assert!((fit.autoregression[0] - RHO).abs() < RHO_BAND, "{}", fit.autoregression[0]);
        ordinary += (least_squares(&names(), &x, &z).unwrap().estimates[1] - 2.0).powi(2);
        generalised += (fit.fit.estimates[1] - 2.0).powi(2);
        stated += fit.fit.covariance[(1, 1)];
    }
    assert!(generalised < ordinary, "{generalised} {ordinary}");
    // The scatter of 60 realisations is known within 1 / sqrt(120) = 9 per cent; three of these.
    assert!(((stated / generalised).sqrt() - 1.0).abs() < 0.27, "{}", (stated / generalised).sqrt());
}

/// Windows with constants of their own: whitened and fitted together they are the generalised fit of all rows, its covariance included.
#[test]
fn whitened_windows_are_the_generalised_fit() {
    let (x, windows) = (regressors(900), [0..500, 500..900]);
    let mut noise = normal(7, 900);
    for k in 1..900 {
        noise[k] += 0.9 * noise[k - 1];
    }
    let z = measurement(&x, &noise);
    let window = |rows: &std::ops::Range<usize>| PooledWindow {
        label: rows.start.to_string(),
        x: x.rows(rows.start, rows.len()).into_owned(),
        z: z[rows.clone()].to_vec(),
    };
    let regression = PooledRegression {
        names: names(),
        per_window: vec![true, false, false],
        constraints: Vec::new(),
        windows: windows.iter().map(window).collect(),
    };
    let all = stacked(&regression.names, &regression.per_window, &regression.windows).unwrap();
    let expected = generalised_least_squares(&all.names, &all.x, &all.z, &windows, 2).unwrap();
    let covariance = expected.coloured_covariance(&all.x, &windows, &Coloured::default()).unwrap();
    let whitened = regression.whitened(2).unwrap();
    let found = whitened.fit().unwrap();
    assert_eq!(found.fit.names, expected.fit.names);
    assert_eq!(found.fit.residuals.len(), 900 - 2 * windows.len());
    for (a, b) in found.fit.estimates.iter().zip(&expected.fit.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-9);
    }
    let corrected = found.coloured_covariance(&whitened.windows, &Coloured::default()).unwrap();
    approx::assert_relative_eq!(corrected, covariance, max_relative = 1e-6, epsilon = 1e-12);
    let fitted = found.fitted(&regression.windows);
    for ((z, y), residual) in z.iter().zip(&fitted).zip(expected.fit.residuals.iter()) {
        approx::assert_abs_diff_eq!(z - y, residual, epsilon = 1e-8);
    }
    for order in [0, 400] {
        assert!(matches!(regression.whitened(order), Err(EstimateError::Setting { .. })), "{order}");
    }
    let held = PooledRegression {
        constraints: vec![Constraint::Free, Constraint::Fixed(2.0), Constraint::Free],
        ..regression
    };
    assert_eq!(held.whitened(2).unwrap().fit().unwrap().fit.parameter("a").unwrap().0, 2.0);
}

/// An exact fit has residuals of rounding, which no autoregression describes: it is that of least squares.
#[test]
fn an_exact_fit_needs_no_autoregression() {
    let (x, windows) = (regressors(300), [0..180, 180..300]);
    let z = measurement(&x, &[0.0; 300]);
    let found = generalised_least_squares(&names(), &x, &z, &windows, 2).unwrap();
    let covariance = found.coloured_covariance(&x, &windows, &Coloured::default()).unwrap();
    let window = |rows: &std::ops::Range<usize>| PooledWindow {
        label: rows.start.to_string(),
        x: x.rows(rows.start, rows.len()).into_owned(),
        z: z[rows.clone()].to_vec(),
    };
    let windows = windows.iter().map(window).collect();
    let regression = PooledRegression { names: names(), per_window: vec![false; 3], constraints: Vec::new(), windows };
    let whitened = regression.whitened(2).unwrap().fit().unwrap();
    assert_eq!(found.autoregression, [0.0, 0.0]);
    for estimates in [&found.fit.estimates, &whitened.fit.estimates] {
        for (found, known) in estimates.iter().zip([1.0, 2.0, -3.0]) {
            approx::assert_relative_eq!(found, &known, max_relative = 1e-12);
        }
    }
    assert!(covariance.diagonal().iter().all(|variance| variance.abs() < 1e-24), "{covariance}");
}

#[test]
fn corrected_errors_of_every_form_are_the_scatter_of_its_estimates() {
    /// Ratio of stated to found deviation over 200 fits: five standard errors of a deviation, and what few lags leave out.
    const RATIO: std::ops::Range<f64> = 0.7..1.3;
    const FITS: usize = 200;
    let x = regressors(1500);
    let windows = [0..900, 900..1500];
    let weights: Vec<f64> = (0..1500).map(|k| if k < 900 { 4.0 } else { 1.0 }).collect();
    let settings = Coloured::default();
    // Of each form: squared errors of the second parameter, and squared errors stated conventionally and corrected.
    let mut sums = [[0.0; 3]; 2];
    for seed in 0..FITS {
        let mut noise = normal(seed as u64, 1500);
        for k in 1..1500 {
            noise[k] += 0.9 * noise[k - 1];
        }
        noise.iter_mut().zip(&weights).for_each(|(value, weight)| *value /= weight.sqrt());
        let z = measurement(&x, &noise);
        let weighted = weighted_least_squares(&names(), &x, &z, &weights).unwrap();
        let covariance = weighted_coloured_covariance(&weighted, &x, &weights, &windows, &settings).unwrap();
        let whitened = generalised_least_squares(&names(), &x, &z, &windows, 1).unwrap();
        let other = whitened.coloured_covariance(&x, &windows, &settings).unwrap();
        for (sums, (fit, covariance)) in sums.iter_mut().zip([(&weighted, covariance), (&whitened.fit, other)]) {
            sums[0] += (fit.estimates[1] - 2.0).powi(2);
            sums[1] += fit.standard_errors[1].powi(2);
            sums[2] += covariance[(1, 1)];
        }
    }
    for (form, [found, conventional, corrected]) in ["weighted", "generalised"].into_iter().zip(sums) {
        let ratio = |stated: f64| (stated / found).sqrt();
        println!("{form}: conventional {:.2}, corrected {:.2} of the scatter", ratio(conventional), ratio(corrected));
        assert!(RATIO.contains(&ratio(corrected)), "{form}: {}", ratio(corrected));
    }
    assert!(sums[0][1] < 0.2 * sums[0][0], "the conventional error of the weighted fit is too small");
}

#[test]
fn fixed_parameter_equals_a_fit_of_the_rest() {
    let x = regressors(80);
    let z = measurement(&x, &normal(3, 80));
    let constraints = [Constraint::Free, Constraint::Fixed(2.5), Constraint::Free];
    let found = constrained_least_squares(&names(), &x, &z, &constraints).unwrap();
    let rest: Vec<f64> = z.iter().zip(x.column(1).iter()).map(|(z, a)| z - 2.5 * a).collect();
    let expected = least_squares(&["0".to_owned(), "b".to_owned()], &x.select_columns(&[0, 2]), &rest).unwrap();
    for (index, other) in [(0, 0), (2, 1)] {
        approx::assert_relative_eq!(found.estimates[index], expected.estimates[other], max_relative = 1e-11);
        approx::assert_relative_eq!(
            found.standard_errors[index],
            expected.standard_errors[other],
            max_relative = 1e-11
        );
    }
    assert_eq!((found.estimates[1], found.standard_errors[1]), (2.5, 0.0));
}

#[test]
fn bounds_hold_what_leaves_them_and_nothing_else() {
    let x = regressors(80);
    let z = measurement(&x, &normal(4, 80));
    let free = least_squares(&names(), &x, &z).unwrap();
    let wide = Constraint::Bounds { lower: -100.0, upper: 100.0 };
    let inside = constrained_least_squares(&names(), &x, &z, &[wide; 3]).unwrap();
    assert_eq!(inside.origins, [Origin::Data; 3]);
    for (a, b) in inside.estimates.iter().zip(&free.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-11);
    }
    let tight = [Constraint::Free, Constraint::Bounds { lower: 2.4, upper: 5.0 }, wide];
    let held = constrained_least_squares(&names(), &x, &z, &tight).unwrap();
    assert_eq!(held.origins, [Origin::Data, Origin::Bound, Origin::Data]);
    let fixed = [Constraint::Free, Constraint::Fixed(2.4), Constraint::Free];
    let expected = constrained_least_squares(&names(), &x, &z, &fixed).unwrap();
    for (a, b) in held.estimates.iter().zip(&expected.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-11);
    }
    let open = Constraint::Bounds { lower: 2.4, upper: f64::INFINITY };
    let one_sided = constrained_least_squares(&names(), &x, &z, &[Constraint::Free, open, wide]).unwrap();
    assert_eq!((one_sided.estimates, one_sided.origins), (held.estimates, held.origins));
    let reversed = [Constraint::Bounds { lower: 1.0, upper: -1.0 }, wide, wide];
    let error = constrained_least_squares(&names(), &x, &z, &reversed).unwrap_err();
    assert_eq!(error.to_string(), "constraint of 0 is 1, allowed is a lower bound below the upper one");
}

#[test]
fn prior_draws_between_data_and_expectation() {
    let x = regressors(80);
    let z = measurement(&x, &normal(5, 80));
    let free = least_squares(&names(), &x, &z).unwrap();
    let with = |deviation| {
        let constraints = [Constraint::Free, Constraint::Prior { mean: 4.0, deviation }, Constraint::Free];
        constrained_least_squares(&names(), &x, &z, &constraints).unwrap()
    };
    approx::assert_relative_eq!(with(1e6).estimates[1], free.estimates[1], max_relative = 1e-8);
    approx::assert_relative_eq!(with(1e-6).estimates[1], 4.0, max_relative = 1e-8);
    // Equal trust: precision-weighted mean of the free estimate and the expectation, up to the change of s^2.
    let equal = with(free.standard_errors[1]);
    approx::assert_relative_eq!(equal.estimates[1], 0.5 * (free.estimates[1] + 4.0), max_relative = 0.05);
    assert!(equal.standard_errors[1] < 0.85 * free.standard_errors[1]);
}

#[test]
fn noise_of_a_regressor_is_corrected() {
    /// Standard deviation of the noise of the second regressor; of its own variation it has 0.71.
    const NOISE: f64 = 0.3;
    /// Three standard errors of the corrected slope at 20,000 samples.
    const BAND: f64 = 0.03;
    let exact = regressors(20_000);
    let z = measurement(&exact, &normal(6, 20_000).iter().map(|draw| NOISE * draw).collect::<Vec<_>>());
    let mut x = exact.clone();
    for (value, draw) in x.column_mut(1).iter_mut().zip(normal(7, 20_000)) {
        *value += NOISE * draw;
    }
    let ordinary = least_squares(&names(), &x, &z).unwrap();
    assert!(ordinary.estimates[1] < 2.0 - 5.0 * BAND, "{}", ordinary.estimates[1]);
    let mut covariance = DMatrix::zeros(3, 3);
    covariance[(1, 1)] = NOISE * NOISE;
    let corrected = errors_in_variables(&names(), &x, &z, &covariance).unwrap();
    let total = total_least_squares(&names(), &x, &z, &[0.0, NOISE, 0.0], NOISE).unwrap();
    for fit in [&corrected, &total] {
        for (estimate, truth) in fit.estimates.iter().zip([1.0, 2.0, -3.0]) {
            assert!((estimate - truth).abs() < BAND, "{estimate} {truth}");
        }
    }
    covariance[(1, 1)] = 10.0;
    assert!(matches!(errors_in_variables(&names(), &x, &z, &covariance), Err(EstimateError::Setting { .. })));
}

#[test]
fn total_least_squares_without_noise_of_regressors_is_ordinary() {
    let x = regressors(80);
    let z = measurement(&x, &normal(8, 80));
    let ordinary = least_squares(&names(), &x, &z).unwrap();
    let total = total_least_squares(&names(), &x, &z, &[0.0; 3], 1.0).unwrap();
    for (a, b) in total.estimates.iter().zip(&ordinary.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-10);
    }
}

#[test]
fn summary_gives_mean_range_and_scatter_over_fits() {
    let x = regressors(50);
    let fit = |seed| least_squares(&names(), &x, &measurement(&x, &normal(seed, 50))).unwrap();
    let (first, second) = (fit(10), fit(11));
    let summary = summarise(&[&first, &second]);
    assert_eq!(summary.len(), 3);
    let (a, b) = (first.estimates[2], second.estimates[2]);
    approx::assert_relative_eq!(summary[2].estimate[0], 0.5 * (a + b), max_relative = 1e-14);
    assert_eq!(summary[2].estimate[1..], [a.min(b), a.max(b)]);
    approx::assert_relative_eq!(summary[2].scatter, (a - b).abs() / 2.0_f64.sqrt(), max_relative = 1e-12);
    approx::assert_relative_eq!(summary[2].variance[2], first.covariance[(2, 2)].max(second.covariance[(2, 2)]));
}
