//! Terms are found where the truth has them, and each step says why.

use doublet_core::estimate::{OrthogonalSettings, StepAction, StepwiseSettings, least_squares, orthogonal, stepwise};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Names of the candidates.
const CANDIDATES: [&str; 8] = ["1", "a", "q", "d", "a^2", "a*q", "a*d", "a^3"];
/// True parameters: constant, a, q, d, a^2; none of the others.
const TRUTH: [f64; 8] = [0.1, -0.9, -0.6, -1.1, 1.5, 0.0, 0.0, 0.0];

/// Candidates over a run of decaying waves, and a measurement with the given noise.
fn example(noise: f64, seed: u64) -> (Vec<String>, DMatrix<f64>, Vec<f64>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let x = DMatrix::from_fn(1500, 8, |row, column| {
        let t = row as f64 * 0.01;
        let a = 0.3 * (1.7 * t).sin() + 0.1 * (0.6 * t).cos();
        let q = 0.4 * (2.9 * t + 0.4).cos();
        let d = if (t * 0.8).sin() > 0.3 { 0.2 } else { -0.1 };
        [1.0, a, q, d, a * a, a * q, a * d, a * a * a][column]
    });
    let z = (0..1500)
        .map(|row| {
            let exact: f64 = x.row(row).iter().zip(TRUTH).map(|(x, truth)| x * truth).sum();
            let draw: f64 = StandardNormal.sample(&mut rng);
            exact + noise * draw
        })
        .collect();
    (CANDIDATES.map(str::to_owned).to_vec(), x, z)
}

#[test]
fn stepwise_search_recovers_truth_terms_and_logs_each_step() {
    let (names, x, z) = example(0.02, 1);
    let settings = StepwiseSettings { min_gain: 0.0, ..StepwiseSettings::default() };
    let found = stepwise(&names, &x, &z, &[0], &settings).unwrap();
    assert_eq!(found.selected, [0, 1, 2, 3, 4]);
    for (estimate, (truth, error)) in found.fit.estimates.iter().zip(TRUTH.iter().zip(&found.fit.standard_errors)) {
        assert!((estimate - truth).abs() < 4.0 * error, "{estimate} {truth} {error}");
    }
    let last = found.log.last().unwrap();
    assert_eq!(last.action, StepAction::RefusedByF);
    assert!(last.partial_f <= 20.0);
    let added: Vec<_> = found.log.iter().filter(|step| step.action == StepAction::Added).collect();
    assert_eq!(added.len(), 4);
    assert!(added.windows(2).all(|pair| pair[1].r_squared > pair[0].r_squared && pair[1].press < pair[0].press));
    // The partial F of the last addition is that of the term in the model that has it.
    let index = found.fit.names.iter().position(|name| *name == added[3].name).unwrap();
    approx::assert_relative_eq!(added[3].partial_f, found.fit.t_values[index].powi(2), max_relative = 1e-8);
}

#[test]
fn stepwise_search_stops_where_a_term_hardly_adds() {
    let (names, x, z) = example(0.001, 2);
    let found = stepwise(&names, &x, &z, &[0], &StepwiseSettings { min_gain: 0.05, ..StepwiseSettings::default() });
    let found = found.unwrap();
    assert_eq!(found.log.last().unwrap().action, StepAction::RefusedByGain);
    assert!(found.selected.len() < 5);
}

#[test]
fn stepwise_search_passes_over_dependent_candidates() {
    let (mut names, x, z) = example(0.02, 3);
    names.push("twice a".to_owned());
    let twice = x.column(1) * 2.0;
    let x = x.insert_column(8, 0.0);
    let mut x = x;
    x.set_column(8, &twice);
    let found = stepwise(&names, &x, &z, &[0, 1], &StepwiseSettings { min_gain: 0.0, ..StepwiseSettings::default() });
    assert_eq!(found.unwrap().selected, [0, 1, 2, 3, 4]);
    assert!(stepwise(&names, &x, &z, &[0, 1, 8], &StepwiseSettings::default()).is_err());
}

#[test]
fn orthogonal_search_recovers_truth_terms_at_the_least_predicted_error() {
    let (names, x, z) = example(0.05, 4);
    let settings = OrthogonalSettings { noise_variance_max: Some(25.0 * 0.05 * 0.05), min_contribution: 0.005 };
    let found = orthogonal(&names, &x, &z, &[0], &settings).unwrap();
    assert_eq!(found.selected, [0, 1, 2, 3, 4]);
    let plain = least_squares(&found.fit.names, &x.columns(0, 5).into_owned(), &z).unwrap();
    for (a, b) in found.fit.estimates.iter().zip(&plain.estimates) {
        approx::assert_relative_eq!(a, b, max_relative = 1e-12);
    }
    // Gains are independent of one another: with the residual they make up the whole, beyond the constant.
    let kept: f64 = found.log.iter().filter(|record| record.kept).map(|record| record.gain).sum();
    approx::assert_relative_eq!(kept, found.fit.quality.r_squared, max_relative = 1e-9);
    assert!(!found.log.last().unwrap().kept);
}
