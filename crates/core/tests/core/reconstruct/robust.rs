//! Huber's weight of innovations: what it does to one measurement, and against noise with many large values.

use std::sync::Arc;

use doublet_core::reconstruct::{FilterData, FilterSettings, Measurement, Method, Reconstruction, STATES};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::against_truth::normalised_errors;
use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::reference::run;

const METHODS: [Method; 3] = [Method::Ekf, Method::USUAL_IEKF, Method::Ukf { spread: Method::USUAL_SPREAD }];

fn settings(method: Method, robust_limit: f64) -> FilterSettings {
    FilterSettings { method, gravity_m_s2: TRUE_GRAVITY, outlier_limit: 0.0, robust_limit, ..citation::settings() }
}

/// Two seconds of which the start is measured, and north at their end, `offset` metres further.
fn one_measurement(citation: &FilterData, offset: f64) -> FilterData {
    const SAMPLE: usize = 100;
    let mut data = window(citation, 0, SAMPLE + 1);
    for (m, series) in data.measurements.iter_mut().enumerate() {
        for (k, value) in Arc::make_mut(&mut series.values).iter_mut().enumerate().skip(1) {
            *value = if m == Measurement::PositionNorth as usize && k == SAMPLE { *value + offset } else { f64::NAN };
        }
    }
    data
}

#[test]
fn a_large_innovation_corrects_as_one_at_the_limit() {
    let Some(citation) = citation::load() else { return };
    const LIMIT: f64 = 2.0;
    for method in METHODS {
        let plain = run(&one_measurement(&citation.data, 0.0), &settings(method, 0.0));
        let north = Measurement::PositionNorth as usize;
        let row = plain.innovations[north].iter().rposition(|innovation| innovation.is_finite()).unwrap();
        let (innovation, deviation) = (plain.innovations[north][row], plain.innovation_deviations[north].at(row));
        let with = |deviations: f64, limit: f64| {
            run(&one_measurement(&citation.data, deviations * deviation - innovation), &settings(method, limit))
        };
        let [at_limit, robust, plain] = [with(LIMIT, 0.0), with(10.0 * LIMIT, LIMIT), with(10.0 * LIMIT, 0.0)];
        let last = plain.time_s.len() - 1;
        let mut moved: f64 = 0.0;
        for state in 0..STATES {
            let sigma = at_limit.deviations[state].at(last);
            let difference = |run: &Reconstruction| (run.states[state][last] - at_limit.states[state][last]) / sigma;
            let error = difference(&robust);
            assert!(error.abs() < 1e-6, "{method:?} state {state}: {error}");
            moved = moved.max(difference(&plain).abs());
        }
        assert!(moved > 5.0, "{method:?}: {moved}");
        approx::assert_relative_eq!(robust.innovation_deviations[north].at(row), deviation, max_relative = 1e-9);
    }
}

/// Every seventh measurement with noise of this many deviations.
const CONTAMINATION: f64 = 6.0;

fn contaminated(data: &FilterData, settings: &FilterSettings, seed: u64) -> FilterData {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut data = data.clone();
    for (series, sigma) in data.measurements.iter_mut().zip(settings.measurement_noise) {
        for value in Arc::make_mut(&mut series.values) {
            let normal: f64 = StandardNormal.sample(&mut random);
            if random.random_bool(0.15) {
                *value += CONTAMINATION * sigma * normal;
            }
        }
    }
    data
}

#[test]
fn errors_under_contaminated_noise_are_smaller_with_the_weights() {
    let Some(citation) = citation::load() else { return };
    for (seed, method) in METHODS.into_iter().enumerate() {
        let plain = settings(method, 0.0);
        let data = contaminated(&citation.data, &plain, seed as u64);
        let states = |settings: &FilterSettings| run(&data, settings).states;
        let (plain, robust) = (states(&plain), states(&settings(method, 1.345)));
        // Velocity and attitude from ten seconds on, against the truth.
        let rms = |states: &[Vec<f64>], k: usize| {
            let square: f64 = states[k].iter().zip(&citation.truth[k]).skip(1_000).map(|(x, y)| (x - y).powi(2)).sum();
            square.sqrt()
        };
        for k in [3, 4, 5, 6, 7] {
            let ratio = rms(&robust, k) / rms(&plain, k);
            println!("{method:?} state {k}: {ratio:.2}");
            assert!(ratio < 0.9, "{method:?} state {k}: {ratio}");
        }
    }
    // Under normal noise it costs little.
    let result = run(&citation.data, &settings(Method::USUAL_IEKF, 1.345));
    let errors = normalised_errors(&result, &citation.truth, 1.0);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(errors.iter().all(|error| *error < 4.0) && mean < 1.5, "{errors:.2?}");
}
