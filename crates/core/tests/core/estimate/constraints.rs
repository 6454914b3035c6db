//! What is known of a derivative beforehand, over several windows.

use doublet_core::estimate::{
    Coloured, Constraint, EstimateError, Origin, PooledFit, PooledRegression, PooledWindow, Taper, stacked,
};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Derivatives of the truth; the constant of each window differs.
const TRUTH: [f64; 2] = [2.0, -3.0];
/// Standard deviation of the noise.
const NOISE: f64 = 0.4;

/// Two windows of correlated regressors with a constant of their own, first-order noise of correlation `rho`.
fn regression(seed: u64, rho: f64, constraints: &[Constraint]) -> PooledRegression {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
    let window = |(index, samples): (usize, usize)| {
        let x = DMatrix::from_fn(samples, 3, |row, column| match column {
            0 => 1.0,
            1 => (row as f64 * 0.05 + index as f64).sin(),
            _ => (row as f64 * 0.05 + index as f64).sin() + 0.4 * (row as f64 * 0.11).cos(),
        });
        let mut noise = draw();
        let z = x.row_iter().map(|row| {
            noise = rho * noise + (1.0 - rho * rho).sqrt() * draw();
            index as f64 + TRUTH[0] * row[1] + TRUTH[1] * row[2] + NOISE * noise
        });
        PooledWindow { label: format!("w{index}"), z: z.collect(), x }
    };
    PooledRegression {
        names: ["c", "a", "b"].map(str::to_owned).to_vec(),
        per_window: vec![true, false, false],
        constraints: constraints.to_vec(),
        windows: [260, 190].into_iter().enumerate().map(window).collect(),
    }
}

fn corrected(regression: &PooledRegression, fit: &PooledFit) -> Vec<f64> {
    let settings = Coloured { max_lag: None, taper: Taper::Parzen };
    let covariance = fit.coloured_covariance(&regression.windows, &settings).unwrap();
    covariance.diagonal().iter().map(|variance| variance.sqrt()).collect()
}

/// Estimates, conventional and corrected errors agree relative to the errors, and to `tolerance`.
fn assert_same(found: &PooledRegression, expected: &PooledRegression, tolerance: f64) {
    let (a, b) = (found.fit().unwrap(), expected.fit().unwrap());
    let errors = corrected(expected, &b);
    let pairs = corrected(found, &a).into_iter().zip(&errors);
    let scale = errors.iter().copied().fold(0.0, f64::max);
    for (index, (own, other)) in pairs.enumerate() {
        let parameter = &a.fit.names[index];
        assert!((a.fit.estimates[index] - b.fit.estimates[index]).abs() < tolerance * scale, "{parameter}");
        assert!((a.fit.standard_errors[index] - b.fit.standard_errors[index]).abs() < tolerance * scale, "{parameter}");
        assert!((own - other).abs() < tolerance * scale, "{parameter}: {own} {other}");
    }
    approx::assert_relative_eq!(a.fit.residual_std, b.fit.residual_std, max_relative = tolerance);
}

#[test]
fn prior_equals_the_normal_equations_with_its_information() {
    let (mean, deviation) = (1.7, 0.02);
    let known = [Constraint::Free, Constraint::Prior { mean, deviation }, Constraint::Free];
    let regression = regression(3, 0.0, &known);
    let fit = regression.fit().unwrap();
    let all = stacked(&regression.names, &regression.per_window, &regression.windows).unwrap();
    // Parameters: a, b, c[w0], c[w1].
    let (s2, z) = (fit.fit.residual_std.powi(2), DVector::from_vec(all.z));
    let mut information = all.x.tr_mul(&all.x) / s2;
    let mut right = all.x.tr_mul(&z) / s2;
    information[(0, 0)] += deviation.powi(-2);
    right[0] += mean * deviation.powi(-2);
    let covariance = information.clone().try_inverse().unwrap();
    let estimates = &covariance * right;
    for index in 0..4 {
        approx::assert_relative_eq!(fit.fit.estimates[index], estimates[index], max_relative = 1e-9);
        approx::assert_relative_eq!(
            fit.fit.standard_errors[index],
            covariance[(index, index)].sqrt(),
            max_relative = 1e-9
        );
    }
    // The prior says `deviation^-2` of what is known of `a` given the rest: that share of a degree of freedom is not spent.
    let residual = &z - &all.x * estimates;
    let freedom = z.len() as f64 - 4.0 + covariance[(0, 0)] * deviation.powi(-2);
    approx::assert_relative_eq!(s2, residual.norm_squared() / freedom, max_relative = 1e-9);
    assert_eq!(fit.fit.origins, [Origin::DataAndPrior, Origin::Data, Origin::Data, Origin::Data]);
}

#[test]
fn prior_goes_from_the_fixed_answer_to_the_free_one() {
    let with = |known| regression(4, 0.8, &[Constraint::Free, known, Constraint::Free]);
    let prior = |deviation| with(Constraint::Prior { mean: 1.9, deviation });
    assert_same(&prior(1e-9), &with(Constraint::Fixed(1.9)), 1e-6);
    assert_same(&prior(1e6), &regression(4, 0.8, &[]), 1e-6);
    assert_same(&with(Constraint::Free), &regression(4, 0.8, &[]), 1e-15);
}

#[test]
fn value_fixed_at_the_truth_makes_the_others_surer() {
    let (free, fixed) = (regression(5, 0.8, &[]), [Constraint::Free, Constraint::Fixed(TRUTH[0]), Constraint::Free]);
    let held = regression(5, 0.8, &fixed);
    let (a, b) = (free.fit().unwrap(), held.fit().unwrap());
    assert_eq!((b.fit.estimates[0], b.fit.standard_errors[0]), (TRUTH[0], 0.0));
    assert_eq!(b.fit.origins[0], Origin::Fixed);
    let (plain, surer) = (corrected(&free, &a), corrected(&held, &b));
    assert_eq!(surer[0], 0.0);
    // The regressors of `a` and `b` are correlated at 0.93: the error of `b` falls to a few tenths of what it was.
    assert!(
        b.fit.standard_errors[1] < 0.6 * a.fit.standard_errors[1] && surer[1] < 0.6 * plain[1],
        "{surer:?} {plain:?}"
    );
    assert!((b.fit.estimates[1] - TRUTH[1]).abs() < 3.0 * surer[1]);
}

#[test]
fn bound_counts_only_where_the_samples_leave_it() {
    let with = |known| regression(6, 0.0, &[Constraint::Free, known, Constraint::Free]);
    let bounds = |lower, upper| with(Constraint::Bounds { lower, upper });
    assert_same(&bounds(1.0, 3.0), &regression(6, 0.0, &[]), 1e-9);
    assert_same(&bounds(f64::NEG_INFINITY, 1.5), &with(Constraint::Fixed(1.5)), 1e-9);
    assert_eq!(bounds(f64::NEG_INFINITY, 1.5).fit().unwrap().fit.origins[0], Origin::Bound);
    let error = bounds(2.0, 1.0).fit().unwrap_err();
    assert_eq!(error.to_string(), "constraint of a is 2, allowed is a lower bound below the upper one");
    let mut short = with(Constraint::Free);
    short.constraints = vec![Constraint::Fixed(1.0)];
    assert_eq!(short.fit(), Err(EstimateError::Size { quantity: "constraints", expected: 3, found: 1 }));
}

#[test]
fn corrected_error_with_a_prior_matches_the_scatter_of_coloured_realisations() {
    /// Standard deviation of the expectation: about the error the samples alone leave.
    const DEVIATION: f64 = 0.2;
    const REALISATIONS: u64 = 4000;
    let (mut scatter, mut stated) = ([0.0; 2], [0.0; 2]);
    for seed in 0..REALISATIONS {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed + 10_000);
        let draw: f64 = StandardNormal.sample(&mut rng);
        let known = Constraint::Prior { mean: TRUTH[0] + DEVIATION * draw, deviation: DEVIATION };
        let regression = regression(seed, 0.8, &[Constraint::Free, known, Constraint::Free]);
        let fit = regression.fit().unwrap();
        for (index, error) in corrected(&regression, &fit).into_iter().take(2).enumerate() {
            scatter[index] += (fit.fit.estimates[index] - TRUTH[index]).powi(2);
            stated[index] += error * error;
        }
    }
    for (scatter, stated) in scatter.into_iter().zip(stated) {
        // The scatter of 4000 is known within 1.1 per cent.
        let ratio: f64 = (stated / scatter).sqrt();
        assert!((0.96..1.04).contains(&ratio), "{ratio}");
    }
}
