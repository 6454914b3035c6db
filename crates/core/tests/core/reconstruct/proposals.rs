//! Noise settings and delays that the measurements themselves tell.

use std::ops::ControlFlow;
use std::sync::Arc;

use doublet_core::reconstruct::tuning::delay::{comparable, refine_delay};
use doublet_core::reconstruct::tuning::noise::{
    NoiseMethod, NoiseProposal, NoiseProposalSettings, likelihood, propose_noise,
};
use doublet_core::reconstruct::{FilterData, FilterSettings, Input, Measurement, reconstruct, without_outliers};

use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::dense::{Discretisation, P, X, h, h_jacobian};
use super::reference::{dense, run, steps};

fn settings() -> FilterSettings {
    FilterSettings { gravity_m_s2: TRUE_GRAVITY, ..citation::settings() }
}

/// Settings with noises far from those of the recording: some too large, some too small.
fn mistaken() -> FilterSettings {
    let mut settings = settings();
    for (k, noise) in settings.process_noise.iter_mut().enumerate() {
        *noise *= if k % 2 == 0 { 5.0 } else { 0.3 };
    }
    for (k, noise) in settings.measurement_noise.iter_mut().enumerate() {
        *noise *= if k % 3 == 0 { 0.3 } else { 3.0 };
    }
    settings
}

fn propose(data: &FilterData, settings: &FilterSettings, method: NoiseMethod, max_iterations: usize) -> NoiseProposal {
    let search = NoiseProposalSettings { method, max_iterations, ..NoiseProposalSettings::default() };
    let (data, outliers) = without_outliers(data, &run(data, settings), settings);
    propose_noise(
        settings,
        &search,
        outliers,
        &mut |settings| likelihood(&[&data], settings, &mut |_| ControlFlow::Continue(())),
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap()
}

/// Ratio of a proposed deviation to the true one, at most, for the inputs: 60 s tell their noise to a tenth or two.
const PROCESS_FACTOR: f64 = 1.5;
/// The same for the measurements: 6,000 samples tell most to one in a hundred.
const MEASUREMENT_FACTOR: f64 = 1.1;
/// Standard error of a logarithm above which a noise is as good as not told.
const UNTOLD: f64 = 0.5;
/// Limit of an error in its standard errors, over eighteen of them.
const ERRORS: f64 = 4.0;

#[test]
fn quasi_newton_recovers_the_noises_of_the_recording() {
    let Some(citation) = citation::load() else { return };
    let truth = settings();
    let found = propose(&citation.data, &mistaken(), NoiseMethod::QuasiNewton, 60);
    println!("{:.1?}, outliers {:?}", found.log_likelihood, found.outliers);
    assert!(found.converged && found.log_likelihood.windows(2).all(|pair| pair[1] > pair[0] - 1e-6));
    let process = found.process.iter().zip(&truth.process_noise).map(|pair| (pair, PROCESS_FACTOR));
    let measurement = found.measurement.iter().zip(&truth.measurement_noise).map(|pair| (pair, MEASUREMENT_FACTOR));
    let names = Input::ALL.map(Input::name).into_iter().chain(Measurement::ALL.map(Measurement::name));
    for (name, ((proposed, expected), factor)) in names.zip(process.chain(measurement)) {
        let proposed = proposed.unwrap();
        let ratio = proposed.proposed / expected;
        let error = proposed.log_standard_error;
        println!("{name}: {:.3} -> {ratio:.3} times the truth, error {error:?}", proposed.present / expected);
        // in 60 s the gyros' noise moves the attitude by a thousandth of what its measurement scatters
        if ["p", "q", "r"].contains(&name) {
            assert!(error.is_none_or(|error| error > UNTOLD && ratio.ln().abs() < ERRORS * error), "{name} {ratio}");
            continue;
        }
        let error = error.unwrap();
        assert!((1.0 / factor..factor).contains(&ratio), "{name} {ratio}");
        assert!(!proposed.at_bound && ratio.ln().abs() < ERRORS * error, "{name} {ratio} {error}");
    }
}

#[test]
fn expectation_maximisation_never_falls_and_goes_the_same_way() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, 1_500);
    let truth = settings();
    let found = propose(&data, &mistaken(), NoiseMethod::ExpectationMaximisation, 40);
    assert!(found.log_likelihood.len() > 10);
    // not exactly monotonic: the path it is linearised about moves with the settings
    assert!(found.log_likelihood.windows(2).all(|pair| pair[1] > pair[0] - 0.5), "{:.1?}", found.log_likelihood);
    for measurement in Measurement::ALL {
        let proposed = found.measurement[measurement as usize].unwrap();
        let ratio = proposed.proposed / truth.measurement_noise[measurement as usize];
        println!("{}: {ratio:.3}", measurement.name());
        assert!((0.85..1.18).contains(&ratio), "{} {ratio}", measurement.name());
    }
    for (proposed, truth) in found.process.iter().flatten().zip(&truth.process_noise) {
        assert!((proposed.proposed / truth).ln().abs() < (proposed.present / truth).ln().abs() + 0.01);
    }
}

#[test]
fn good_samples_are_not_taken_for_outliers() {
    let Some(citation) = citation::load() else { return };
    let (data, outliers) = without_outliers(&citation.data, &run(&citation.data, &settings()), &settings());
    println!("{outliers:?}");
    // Twelve measurements, each of which loses a sample once in twenty recordings: more than three once in four hundred. At 3.29
    // deviations it were 72 of 72,000, and the deviations 0.6 % too small.
    assert!(outliers.iter().sum::<usize>() <= 3, "{outliers:?}");
    let lost = data.measurements.iter().flat_map(|series| series.values.iter()).filter(|value| value.is_nan()).count();
    assert_eq!(lost, outliers.iter().sum::<usize>());
}

#[test]
fn outliers_are_left_out() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 1_000);
    for k in [200, 400, 650, 990] {
        Arc::make_mut(&mut data.measurements[Measurement::Airspeed as usize].values)[k] += 5.0;
    }
    let settings = FilterSettings { outlier_limit: 0.0, ..settings() };
    let (clean, outliers) = without_outliers(&data, &run(&data, &settings), &settings);
    assert!((4..10).contains(&outliers[Measurement::Airspeed as usize]), "{outliers:?}");
    assert!(outliers.iter().all(|count| *count < 10), "{outliers:?}");
    assert!([200, 400, 650, 990].iter().all(|&k| clean.measurements[9].values[k].is_nan()));
}

/// Agreement of the expected squares with those from whole matrices, relative: these solve with a covariance of condition 1e10.
const EXPECTED_SQUARES: f64 = 1e-4;

/// Shumway & Stoffer (1982): with the lag-one covariance `C = Ps+ G'`, the mean of
/// `(xs+ - f(xs)) (..)' + Ps+ - C Phi' - Phi C' + Phi Ps Phi'`, of which the process noise is what it says of velocity and
/// attitude; and of `(z - h(xs))^2 + H Ps H'`.
#[test]
fn expected_squares_match_the_textbook_form_with_the_lag_one_covariance() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, 400);
    // a start so good that the path is linear to the tolerance
    let mut settings = settings();
    for k in 0..18 {
        settings.initial_deviation[k] *= 1e-3;
        settings.initial_state[k] = Some(citation.truth[k][0]);
    }
    let seen = likelihood(&[&data], &FilterSettings { smooth: true, ..settings.clone() }.check().unwrap(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
    .moments;
    let filter = dense(&settings, Discretisation::ThirdOrder);
    let mut x = X::from_fn(|i, _| settings.initial_state[i].unwrap());
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let mut kept = Vec::new();
    let steps = steps(&data, settings.hold);
    for step in &steps {
        let before = (x, p);
        let told = filter.step(&mut x, &mut p, step);
        kept.push((before, told.phi, told.predicted));
    }
    let mut process = [0.0; 6];
    let mut measurement = [0.0; 12];
    for ((before, phi, (predicted, prior)), step) in kept.into_iter().zip(&steps).rev() {
        let expected = h(&std::array::from_fn(|i| x[i]));
        let jacobian = h_jacobian(&x);
        for m in 0..12 {
            let variance = (jacobian.row(m) * p * jacobian.row(m).transpose())[0];
            let error = step.z[m] - expected[m];
            let turns = if (6..9).contains(&m) { (error / std::f64::consts::TAU).round() } else { 0.0 };
            measurement[m] += (error - std::f64::consts::TAU * turns).powi(2) + variance;
        }
        let gain = prior.cholesky().unwrap().solve(&(phi * before.1)).transpose();
        let (ahead, ahead_p) = (x, p);
        x = before.0 + gain * (x - predicted);
        p = before.1 + gain * (p - prior) * gain.transpose();
        let lag_one = ahead_p * gain.transpose();
        let defect = ahead - (predicted + phi * (x - before.0));
        let square = defect * defect.transpose() + ahead_p - lag_one * phi.transpose() - phi * lag_one.transpose()
            + phi * p * phi.transpose();
        // what the noise does to velocity and attitude, undone
        let gamma = phi.fixed_view::<6, 6>(3, 9).into_owned();
        let half = gamma.lu().solve(&square.fixed_view::<6, 6>(3, 3).into_owned()).unwrap();
        let noise = gamma.lu().solve(&half.transpose()).unwrap();
        (0..6).for_each(|i| process[i] += noise[(i, i)]);
    }
    for i in 0..6 {
        println!("{} {}", seen.process[i], process[i]);
        assert!((seen.process[i] / process[i] - 1.0).abs() < EXPECTED_SQUARES, "input {i}");
    }
    for m in 0..12 {
        assert!((seen.measurement[m] / measurement[m] - 1.0).abs() < EXPECTED_SQUARES, "measurement {m}");
    }
    assert_eq!((seen.steps, seen.samples), (399, [399; 12]));
}

/// Delay put into the recording, s: not a multiple of its sampling interval.
const DELAY_S: f64 = 0.0837;

#[test]
fn an_injected_delay_is_refined_to_its_standard_error() {
    let Some(citation) = citation::load() else { return };
    for measurements in [vec![Measurement::BankAngle], vec![Measurement::VelocityNorth, Measurement::VelocityEast]] {
        let mut data = citation.data.clone();
        for measurement in &measurements {
            let times = Arc::make_mut(&mut data.measurements[*measurement as usize].time_s);
            times.iter_mut().for_each(|time| *time += DELAY_S);
        }
        let settings = settings();
        let data = comparable(&data, &measurements, &settings, 0.25);
        let found = refine_delay(&settings, &measurements, 0.25, &mut |settings| {
            Ok(reconstruct(&data, settings, &mut |_| ControlFlow::Continue(()))?.log_likelihood)
        })
        .unwrap();
        let error = found.delay_s - DELAY_S;
        println!("{measurements:?}: {error:.1e} s off, standard error {:.1e} s", found.standard_error_s);
        assert!(error.abs() < 3.0 * found.standard_error_s && found.standard_error_s < 0.005);
        assert_eq!(found.present_s, 0.0);
        let refused = refine_delay(&settings, &measurements, 0.03, &mut |settings| {
            Ok(reconstruct(&data, settings, &mut |_| ControlFlow::Continue(()))?.log_likelihood)
        });
        assert!(refused.unwrap_err().to_string().contains("wider range"));
    }
}

/// What a split step changes, in standard deviations.
const SHIFTED_SIGMA: f64 = 0.02;

#[test]
fn a_delay_that_is_set_is_taken_out() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, 1_000);
    let mut late = data.clone();
    let mut settings = settings();
    for m in [Measurement::AngleOfAttack, Measurement::PositionNorth].map(|m| m as usize) {
        Arc::make_mut(&mut late.measurements[m].time_s).iter_mut().for_each(|time| *time += 0.05);
        settings.measurement_delay_s[m] = 0.05;
    }
    let expected = run(&data, &FilterSettings { measurement_delay_s: [0.0; 12], ..settings.clone() });
    let (found, ignored) =
        (run(&late, &settings), run(&late, &FilterSettings { measurement_delay_s: [0.0; 12], ..settings.clone() }));
    let off = |other: &doublet_core::reconstruct::Reconstruction| {
        (0..18)
            .map(|k| ((other.states[k][999] - expected.states[k][999]) / expected.deviations[k].at(999)).abs())
            .fold(0.0, f64::max)
    };
    println!("{:.1e} {:.1e}", off(&found), off(&ignored));
    assert!(off(&found) < SHIFTED_SIGMA && off(&ignored) > 1.0);
}
