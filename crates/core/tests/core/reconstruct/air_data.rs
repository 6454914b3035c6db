//! Errors of the air data as states, and the likelihood of the measurements.

use std::sync::Arc;

use doublet_core::reconstruct::{AirState, FilterData, FilterSettings, State};

use super::against_truth::normalised_errors;
use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::dense::{Discretisation, P, X};
use super::reference::{dense, run, steps};

/// Offsets of alpha and beta, rad, upwash factor, scale of airspeed, sidewash factor put into the recording.
const ERRORS: [f64; 5] = [0.02, -0.015, 0.12, 0.03, 0.10];

fn with_errors(data: &FilterData) -> FilterData {
    let mut data = data.clone();
    let [alpha, beta, upwash, scale, sidewash] = ERRORS;
    let mut change = |m: usize, by: &dyn Fn(f64) -> f64| {
        Arc::make_mut(&mut data.measurements[m].values).iter_mut().for_each(|value| *value = by(*value));
    };
    change(9, &|value| value * (1.0 + scale));
    change(10, &|value| value * (1.0 + upwash) + alpha);
    change(11, &|value| value * (1.0 + sidewash) + beta);
    data
}

/// Limit on an estimate's error, in its standard deviations.
const WITHIN_SIGMA: f64 = 3.0;

#[test]
fn errors_of_the_air_data_are_recovered_by_the_iterated_smoother_with_their_deviations() {
    let Some(citation) = citation::load() else { return };
    let mut settings = FilterSettings { gravity_m_s2: TRUE_GRAVITY, smooth: true, ..citation::settings() };
    settings.air_data_deviation = [0.05, 0.05, 0.3, 0.1, 0.3];
    settings.smoother_passes = 10;
    let data = with_errors(&citation.data);
    let mut result = run(&data, &settings);
    let smoothed = result.smoothed.take().unwrap();
    let air_data = smoothed.air_data.unwrap();
    for state in AirState::ALL {
        let k = state as usize;
        let (found, deviation) = (air_data.states[k][0], air_data.deviations[k][0]);
        println!("{}: {found:.4} +- {deviation:.4}, truth {}", state.name(), ERRORS[k]);
        assert!((found - ERRORS[k]).abs() < WITHIN_SIGMA * deviation, "{}", state.name());
        // the window tells it: far better than before, and far from zero
        assert!(deviation < 0.2 * settings.air_data_deviation[k] && ERRORS[k].abs() > WITHIN_SIGMA * deviation);
        assert_eq!(air_data.states[k].len(), 6001);
        assert!(air_data.states[k].iter().all(|value| (value - found).abs() < 1e-6 * deviation), "{}", state.name());
    }
    (result.states, result.deviations) = (smoothed.states, smoothed.deviations);
    let errors = normalised_errors(&result, &citation.truth, 1.0);
    println!("{errors:.2?}");
    assert!(errors.iter().all(|error| *error < 6.0));

    // one pass says that it may not be enough; left out, the errors end up in wind and velocity
    settings.smoother_passes = 1;
    let once = run(&window(&data, 0, 200), &settings);
    assert!(once.warnings.iter().any(|warning| warning.to_string().contains("air-data states")), "{:?}", once.warnings);
    assert_eq!(once.air_data.unwrap().states[0].len(), 200);
    settings.air_data_deviation = [0.0; 5];
    result = run(&data, &settings);
    assert!(result.air_data.is_none());
    assert!(normalised_errors(&result, &citation.truth, 1.0)[State::WindNorth as usize] > 100.0);
}

/// Rounding of a sum over a thousand steps, relative.
const LIKELIHOOD: f64 = 1e-9;

#[test]
fn log_likelihood_matches_the_dense_filter() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 1_000);
    for (m, series) in data.measurements.iter_mut().enumerate() {
        for (k, value) in Arc::make_mut(&mut series.values).iter_mut().enumerate().skip(1) {
            if (k * (m + 3)) % 7 == 0 || (m < 3 && k % 10 != 0) {
                *value = f64::NAN;
            }
        }
    }
    let settings = citation::settings();
    let result = run(&data, &settings);
    let filter = dense(&settings, Discretisation::ThirdOrder);
    let mut x = X::from_fn(|i, _| result.states[i][0]);
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let mut expected = 0.0;
    for step in steps(&data, settings.hold) {
        let told = filter.step(&mut x, &mut p, &step);
        let present: Vec<usize> = (0..12).filter(|&m| step.present[m]).collect();
        let s = nalgebra::DMatrix::from_fn(present.len(), present.len(), |i, j| {
            told.innovation_covariance[(present[i], present[j])]
        });
        let log_determinant = 2.0 * s.cholesky().unwrap().l().diagonal().map(f64::ln).sum();
        let normal = present.len() as f64 * std::f64::consts::TAU.ln();
        expected -= 0.5 * (log_determinant + told.nis + normal);
    }
    assert!((result.log_likelihood / expected - 1.0).abs() < LIKELIHOOD, "{} {expected}", result.log_likelihood);
}
