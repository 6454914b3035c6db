//! The unscented filter against truth, and against the extended one in the limits where the two are the same.

use std::sync::Arc;

use doublet_core::reconstruct::{Deviations, FilterData, FilterSettings, Method, Reconstruction, State};

use super::against_truth::normalised_errors;
use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::reference::run;

const UKF: Method = Method::Ukf { spread: Method::USUAL_SPREAD };

fn settings(method: Method) -> FilterSettings {
    FilterSettings { method, gravity_m_s2: TRUE_GRAVITY, ..citation::settings() }
}

#[test]
fn unscented_filter_is_consistent_nees_and_nis() {
    let Some(citation) = citation::load() else { return };
    let result = run(&citation.data, &settings(UKF));
    let nis = result.nis[1..].iter().sum::<f64>() / 6000.0;
    assert!((11.7..12.2).contains(&nis), "{nis}");
    let errors = normalised_errors(&result, &citation.truth, 1.0);
    let mean = errors.iter().sum::<f64>() / 18.0;
    println!("NIS {nis:.3}, errors {errors:.2?}, mean {mean:.3}");
    assert!(errors.iter().all(|error| *error < 4.0) && (0.3..1.5).contains(&mean));
}

/// Largest difference of states and deviations, in standard deviations.
fn difference(a: &Reconstruction, b: &Reconstruction) -> f64 {
    let mut largest: f64 = 0.0;
    for k in 0..18 {
        for i in 0..a.time_s.len() {
            let sigma = b.deviations[k].at(i);
            largest = largest.max((a.states[k][i] - b.states[k][i]).abs() / sigma);
            largest = largest.max((a.deviations[k].at(i) - sigma).abs() / sigma);
        }
    }
    largest
}

/// The unscented mean keeps terms of second order whatever the spread: small where the start is well known. The Jacobian of a
/// step is a series to third order in the extended filter and that of the integration here.
const SMALL_SPREAD_SIGMA: f64 = 0.01;
/// How much better known the start is than in the published settings.
const WELL_KNOWN: f64 = 0.01;

/// `settings` with a start close to the truth.
fn well_started(mut settings: FilterSettings, truth: &[Vec<f64>; 18]) -> FilterSettings {
    for k in 0..18 {
        settings.initial_deviation[k] *= WELL_KNOWN;
        settings.initial_state[k] = Some(truth[k][0] + 0.5 * settings.initial_deviation[k]);
    }
    settings
}

#[test]
fn close_sigma_points_give_the_extended_filter() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 1_000);
    for (k, value) in Arc::make_mut(&mut data.measurements[3].values).iter_mut().enumerate() {
        *value = if k % 4 == 0 { *value } else { f64::NAN };
    }
    let mut close = well_started(settings(Method::Ukf { spread: 1e-2 }), &citation.truth);
    close.initial_deviation[State::BiasQ as usize] = 0.0;
    close.random_walk[State::WindEast as usize] = 0.05;
    let extended = FilterSettings { method: Method::Ekf, ..close.clone() };
    let found = difference_but_known(&run(&data, &close), &run(&data, &extended), State::BiasQ);
    println!("{found:.1e} sigma");
    assert!(found < SMALL_SPREAD_SIGMA, "{found}");
}

fn difference_but_known(a: &Reconstruction, b: &Reconstruction, known: State) -> f64 {
    assert!(a.deviations[known as usize].iter().all(|deviation| deviation == 0.0));
    let (mut a, mut b) = (a.clone(), b.clone());
    for result in [&mut a, &mut b] {
        result.deviations[known as usize] = Deviations::constant(1.0, result.time_s.len());
    }
    difference(&a, &b)
}

/// What nonlinearity leaves after a well-known start, in standard deviations.
const SETTLED_SIGMA: f64 = 0.02;

#[test]
fn unscented_filter_and_smoother_agree_with_the_iterated_ones_after_a_good_start() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, 2_000);
    let smoothing = |method| FilterSettings { smooth: true, ..well_started(settings(method), &citation.truth) };
    let unscented = run(&data, &smoothing(UKF));
    let iterated = run(&data, &smoothing(Method::USUAL_IEKF));
    let filtered = difference(&unscented, &iterated);
    let swap = |result: &Reconstruction| {
        let smoothed = result.smoothed.clone().unwrap();
        Reconstruction { states: smoothed.states, deviations: smoothed.deviations, ..result.clone() }
    };
    let smoothed = difference(&swap(&unscented), &swap(&iterated));
    println!("filtered {filtered:.1e}, smoothed {smoothed:.1e} sigma");
    assert!(filtered < SETTLED_SIGMA && smoothed < SETTLED_SIGMA);
    let smoothed = unscented.smoothed.unwrap();
    for k in State::BiasAx as usize..=State::WindDown as usize {
        let last = smoothed.states[k][1_999];
        assert!(
            smoothed.states[k].iter().all(|value| (value - last).abs() < 1e-9 * smoothed.deviations[k].at(0)),
            "{k}"
        );
    }
}

#[test]
fn extreme_settings_give_numbers_or_a_named_error() {
    let Some(citation) = citation::load() else { return };
    let data: FilterData = window(&citation.data, 0, 300);
    for spread in [1e-3, 5.0] {
        let mut settings = FilterSettings { smooth: true, ..settings(Method::Ukf { spread }) };
        settings.measurement_noise.iter_mut().for_each(|noise| *noise *= 1e-3);
        settings.initial_deviation.iter_mut().for_each(|deviation| *deviation *= 3.0);
        let valid = settings.check().unwrap();
        match doublet_core::reconstruct::reconstruct(&data, &valid, &mut |_| std::ops::ControlFlow::Continue(())) {
            Ok(result) => {
                let smoothed = result.smoothed.as_ref().unwrap();
                for (states, deviations) in
                    [(&result.states, &result.deviations), (&smoothed.states, &smoothed.deviations)]
                {
                    assert!(states.iter().flatten().all(|value| value.is_finite()));
                    assert!(deviations.iter().flatten().all(f64::is_finite));
                }
            }
            Err(error) => println!("{spread}: {error}"),
        }
    }
}
