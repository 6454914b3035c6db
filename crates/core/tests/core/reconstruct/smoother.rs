//! The smoother against the textbook recursion with whole matrices, and against truth.

use std::sync::Arc;

use doublet_core::reconstruct::{FilterData, FilterSettings, State};

use super::against_truth::normalised_errors;
use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::dense::{Discretisation, P, X};
use super::reference::{dense, run, steps};

/// Agreement with the recursion with whole matrices, in standard deviations: it solves with the predicted covariance,
/// whose condition number is about 1e10.
const DENSE_SIGMA: f64 = 1e-5;

/// Rauch, Tung & Striebel (1965): `G = P+ Phi' (P-)^-1`.
fn dense_smoother(data: &FilterData, settings: &FilterSettings, start: X) -> Vec<(X, P)> {
    let filter = dense(settings, Discretisation::ThirdOrder);
    let mut x = start;
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let mut kept = Vec::new();
    for step in steps(data, settings.hold) {
        let before = (x, p);
        let told = filter.step(&mut x, &mut p, &step);
        kept.push((before, told.phi, told.predicted));
    }
    let mut smoothed = vec![(x, p)];
    let (mut xs, mut ps) = (x, p);
    for ((x, p), phi, (predicted, prior)) in kept.into_iter().rev() {
        let gain = prior.try_inverse().map_or_else(P::zeros, |inverse| p * phi.transpose() * inverse);
        (xs, ps) = (x + gain * (xs - predicted), p + gain * (ps - prior) * gain.transpose());
        smoothed.push((xs, ps));
    }
    smoothed.reverse();
    smoothed
}

fn settings() -> FilterSettings {
    FilterSettings { gravity_m_s2: TRUE_GRAVITY, smooth: true, ..citation::settings() }
}

#[test]
fn matches_the_recursion_with_whole_matrices() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 800);
    for (k, value) in Arc::make_mut(&mut data.measurements[1].values).iter_mut().enumerate() {
        *value = if k % 5 == 0 { *value } else { f64::NAN };
    }
    let mut walking = settings();
    walking.random_walk[State::WindEast as usize] = 0.05;
    walking.random_walk[State::BiasR as usize] = 1e-6;
    for settings in [settings(), walking] {
        let result = run(&data, &settings);
        let found = result.smoothed.unwrap();
        let expected = dense_smoother(&data, &settings, X::from_fn(|i, _| result.states[i][0]));
        let mut largest: f64 = 0.0;
        for (k, (x, p)) in expected.iter().enumerate() {
            for i in 0..18 {
                let sigma = p[(i, i)].sqrt();
                largest = largest.max((found.states[i][k] - x[i]).abs() / sigma);
                largest = largest.max((found.deviations[i].at(k) - sigma).abs() / sigma);
            }
        }
        println!("{largest:.1e} sigma");
        assert!(largest < DENSE_SIGMA, "{largest}");
    }
}

/// Rounding over 6,000 steps backwards, in standard deviations.
const CONSTANT_SIGMA: f64 = 1e-6;
/// Part of the samples that must agree within three standard deviations of the difference (McReynolds).
const AGREEING: f64 = 0.99;

#[test]
fn smoothed_path_is_consistent_with_truth_and_filter_and_biases_are_constant() {
    let Some(citation) = citation::load() else { return };
    let mut result = run(&citation.data, &settings());
    let smoothed = result.smoothed.take().unwrap();
    for k in State::BiasAx as usize..=State::WindDown as usize {
        let last = smoothed.states[k][6000];
        let spread = smoothed.states[k].iter().map(|value| (value - last).abs()).fold(0.0, f64::max);
        assert!(spread < CONSTANT_SIGMA * smoothed.deviations[k].at(6000), "{k} {spread}");
    }
    let (mut agreeing, mut compared) = (0, 0);
    for k in 0..9 {
        for i in 0..=6000 {
            let variance = result.deviations[k].at(i).powi(2) - smoothed.deviations[k].at(i).powi(2);
            let difference = result.states[k][i] - smoothed.states[k][i];
            agreeing += usize::from(difference.powi(2) <= 9.0 * variance.max(1e-18));
            compared += 1;
        }
    }
    let agreeing = f64::from(agreeing as u32) / f64::from(compared as u32);
    assert!(agreeing > AGREEING, "{agreeing}");

    let filtered = normalised_errors(&result, &citation.truth, 1.0);
    (result.states, result.deviations) = (smoothed.states, smoothed.deviations);
    let errors = normalised_errors(&result, &citation.truth, 1.0);
    println!("filtered {filtered:.2?}\nsmoothed {errors:.2?}, {agreeing}");
    assert!(errors.iter().all(|error| *error < 6.0));
    assert!(errors.iter().sum::<f64>() / 18.0 < 2.0);
}
