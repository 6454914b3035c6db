//! The dense filter against the published result, the production filter against both.

use std::ops::ControlFlow;

use doublet_core::reconstruct::{
    FilterData, FilterSettings, InputHold, Linearisation, Method, Reconstruction, State, reconstruct,
};

use super::against_truth::normalised_errors;
use super::citation::{self, TRUE_GRAVITY};
use super::dense::{self, Dense, Discretisation, P, Step, X, Z};
use crate::shared::shared;

/// Relative agreement of two independent implementations of the same filter in double precision.
const SAME_FILTER: f64 = 1e-6;
/// Agreement with the published final state, in its standard deviations.
const PUBLISHED_SIGMA: f64 = 0.01;
/// Agreement of the production filter with the dense one on equal settings, in standard deviations.
pub const EQUAL_SETTINGS_SIGMA: f64 = 1e-6;

pub fn run(data: &FilterData, settings: &FilterSettings) -> Reconstruction {
    reconstruct(data, &settings.check().unwrap(), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Steps of a recording whose measurements were all taken at the inertial samples.
pub fn steps(data: &FilterData, hold: InputHold) -> Vec<Step> {
    let t = &data.inputs.time_s;
    let at = |k: usize| std::array::from_fn(|i| data.inputs.columns[i][k]);
    (1..t.len())
        .map(|k| {
            let z = Z::from_fn(|m, _| data.measurements[m].values.get(k).copied().unwrap_or(f64::NAN));
            Step {
                dt: t[k] - t[k - 1],
                noise_scale: 1.0,
                start: at(k - 1),
                end: if hold == InputHold::FirstOrder { at(k) } else { at(k - 1) },
                present: std::array::from_fn(|m| z[m].is_finite()),
                z,
            }
        })
        .collect()
}

pub fn dense(settings: &FilterSettings, discretisation: Discretisation) -> Dense {
    let (max_iterations, tolerance) = match settings.method {
        Method::Ekf | Method::Ukf { .. } => (1, 1.0),
        Method::Iekf { max_iterations, tolerance } => (max_iterations, tolerance),
    };
    Dense {
        gravity: settings.gravity_m_s2,
        q: nalgebra::SVector::from(settings.process_noise.map(|s| s * s)),
        r: Z::from(settings.measurement_noise.map(|s| s * s)),
        random_walk: X::from(settings.random_walk.map(|s| s * s)),
        discretisation,
        at_predicted: settings.linearisation == Linearisation::Predicted,
        max_iterations,
        tolerance,
    }
}

/// Largest difference of the production filter from the dense one over all times and states, in standard deviations.
pub fn largest_difference(data: &FilterData, settings: &FilterSettings) -> f64 {
    largest_difference_of(&run(data, settings), &steps(data, settings.hold), settings)
}

/// The same for steps written out, one row of innovations each.
pub fn largest_difference_of(result: &Reconstruction, steps: &[Step], settings: &FilterSettings) -> f64 {
    let filter = dense(settings, Discretisation::ThirdOrder);
    let mut x = X::from_fn(|i, _| result.states[i][0]);
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let mut largest: f64 = 0.0;
    for (k, step) in steps.iter().enumerate() {
        let told = filter.step(&mut x, &mut p, step);
        if let Some(row) = result.time_s.iter().position(|time| *time == result.update_time_s[k + 1]) {
            for i in 0..18 {
                let sigma = p[(i, i)].sqrt();
                largest = largest.max((x[i] - result.states[i][row]).abs() / sigma);
                largest = largest.max((sigma - result.deviations[i].at(row)).abs() / sigma);
            }
        }
        for m in (0..12).filter(|&m| step.present[m]) {
            let sigma = told.innovation_covariance[(m, m)].sqrt();
            largest = largest.max((told.innovation[m] - result.innovations[m][k + 1]).abs() / sigma);
            largest = largest.max((sigma - result.innovation_deviations[m].at(k + 1)).abs() / sigma);
        }
        if step.present.contains(&true) {
            largest = largest.max((told.nis - result.nis[k + 1]).abs() / 12.0);
        }
    }
    for i in 0..18 {
        for j in 0..18 {
            let scale = (p[(i, i)] * p[(j, j)]).sqrt();
            largest = largest.max((p[(i, j)] - result.final_covariance[(i, j)]).abs() / scale);
        }
    }
    largest
}

fn published(settings: FilterSettings) -> FilterSettings {
    FilterSettings {
        method: Method::Ekf,
        hold: InputHold::ZeroOrder,
        linearisation: Linearisation::Predicted,
        ..settings
    }
}

struct Published {
    final_state: Vec<f64>,
    final_sigma: Vec<f64>,
    rows: Vec<usize>,
    states: Vec<Vec<f64>>,
    sigmas: Vec<Vec<f64>>,
    mean_nis: f64,
}

fn published_result() -> Option<Published> {
    let path = shared("data/citation_simulated/reference_ekf_zero_order_hold.json")?;
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let list = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let table = |value: &serde_json::Value| value.as_array().unwrap().iter().map(list).collect();
    Some(Published {
        final_state: list(&json["final_estimate"]),
        final_sigma: list(&json["final_sigma"]),
        rows: list(&json["sample_index"]).into_iter().map(|row| row as usize - 1).collect(),
        states: table(&json["sample_x"]),
        sigmas: table(&json["sample_sigma"]),
        mean_nis: json["mean_NIS"].as_f64().unwrap(),
    })
}

#[test]
fn dense_filter_matches_the_published_zero_order_hold_filter() {
    let (Some(citation), Some(published_result)) = (citation::load(), published_result()) else { return };
    let settings = published(citation::settings());
    let filter = dense(&settings, Discretisation::Exponential);
    let start = run(&citation.data, &settings);
    let mut x = X::from_fn(|i, _| start.states[i][0]);
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let mut nis = Vec::new();
    let steps = steps(&citation.data, settings.hold);
    for (k, step) in steps.iter().enumerate() {
        nis.push(filter.step(&mut x, &mut p, step).nis);
        if let Some(row) = published_result.rows.iter().position(|&row| row == k + 1) {
            for i in 0..18 {
                let (expected, sigma) = (published_result.states[row][i], published_result.sigmas[row][i]);
                // relative to the state, or to its deviation where the state passes through zero
                assert!((x[i] - expected).abs() < SAME_FILTER * expected.abs().max(sigma), "row {k} state {i}");
                assert!((p[(i, i)].sqrt() - sigma).abs() < SAME_FILTER * sigma, "row {k} deviation {i}");
            }
        }
    }
    for i in 0..18 {
        let expected = published_result.final_state[i];
        assert!((x[i] - expected).abs() < SAME_FILTER * expected.abs(), "{} {}", x[i], expected);
    }
    // the published mean leaves the first second out
    let nis = nis[99..].iter().sum::<f64>() / (nis.len() - 99) as f64;
    assert!((nis - published_result.mean_nis).abs() < SAME_FILTER * nis);
}

#[test]
fn zero_order_hold_matches_the_published_filter() {
    let (Some(citation), Some(published_result)) = (citation::load(), published_result()) else { return };
    for linearisation in [Linearisation::Predicted, Linearisation::Prior] {
        let settings = FilterSettings { linearisation, ..published(citation::settings()) };
        let result = run(&citation.data, &settings);
        for state in State::ALL {
            let i = state as usize;
            let off = (result.states[i][6000] - published_result.final_state[i]) / published_result.final_sigma[i];
            assert!(off.abs() < PUBLISHED_SIGMA, "{} {off}", state.name());
        }
    }
}

#[test]
fn agrees_with_the_dense_filter_on_equal_settings() {
    let Some(citation) = citation::load() else { return };
    let iekf = Method::Iekf { max_iterations: 10, tolerance: 1e-3 };
    for method in [Method::Ekf, iekf] {
        for hold in [InputHold::FirstOrder, InputHold::ZeroOrder] {
            for linearisation in [Linearisation::Prior, Linearisation::Predicted] {
                let settings = FilterSettings { method, hold, linearisation, ..citation::settings() };
                let difference = largest_difference(&citation.data, &settings);
                println!("{method:?} {hold:?} {linearisation:?}: {difference:.1e} sigma");
                assert!(difference < EQUAL_SETTINGS_SIGMA, "{difference}");
            }
        }
    }
}

#[test]
fn first_order_hold_is_consistent_nees_and_nis() {
    let Some(citation) = citation::load() else { return };
    for method in [Method::Ekf, FilterSettings::default().method] {
        let settings = FilterSettings { method, gravity_m_s2: TRUE_GRAVITY, ..citation::settings() };
        let result = run(&citation.data, &settings);
        let nis = result.nis[1..].iter().sum::<f64>() / 6000.0;
        assert!((11.7..12.2).contains(&nis), "{nis}");
        let errors = normalised_errors(&result, &citation.truth, 1.0);
        let mean = errors.iter().sum::<f64>() / 18.0;
        println!("NIS {nis:.3}, errors {errors:.2?}, mean {mean:.3}");
        assert!(errors.iter().all(|error| *error < 4.0) && (0.3..1.5).contains(&mean));
    }
}

/// Agreement of an analytic Jacobian with dual numbers, relative to its largest entry.
const JACOBIAN: f64 = 1e-12;

#[test]
fn dense_jacobians_match_dual_numbers() {
    let x = X::from_column_slice(&[
        10.0, -20.0, -900.0, 78.0, -3.0, 6.0, 0.4, -0.2, 2.1, 0.02, -0.01, 0.03, 1e-3, -2e-3, 3e-3, 6.0, -2.0, 1.0,
    ]);
    let input = [0.3, -0.2, -9.6, 0.15, 0.07, -0.05];
    let (_, exact) = num_dual::jacobian(
        |x| nalgebra::SVector::<_, 18>::from(dense::f(&std::array::from_fn(|i| x[i]), &input, TRUE_GRAVITY)),
        &x,
    );
    assert!((exact - dense::f_jacobian(&x, &input, TRUE_GRAVITY)).amax() < JACOBIAN * exact.amax());
    let (_, exact) =
        num_dual::jacobian(|x| nalgebra::SVector::<_, 12>::from(dense::h(&std::array::from_fn(|i| x[i]))), &x);
    assert!((exact - dense::h_jacobian(&x)).amax() < JACOBIAN * exact.amax());
}
