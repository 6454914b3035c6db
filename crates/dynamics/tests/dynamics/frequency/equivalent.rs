//! Low-order equivalent systems fitted over many seeds, against truth, Cramer-Rao bound and coverage.

use std::f64::consts::TAU;

use doublet_dynamics::frequency::{
    BodeCurve, Delay, EquivalentSystem, FitSettings, Form, FrequencyError, FrequencyRecord, Mismatch, OutputErrorBand,
    Section, SpectralSettings, TransferFunction, fit_records, fit_response, logarithmic_grid, responses,
    state_space_response,
};
use nalgebra::Complex;

use super::signals::{moments, normal, second_order_response, seeded, sweep};

/// K, 1/T_theta2, zeta, omega, tau of the identified pitch response of the Tu-144 report, section 5.1, taken as the truth.
const TRUTH: [f64; 5] = [1.972, 2.048, 0.607, 2.922, 0.120];
/// Cramer-Rao bound for the record below and noise of 10 % of the output, computed independently.
const BOUND: [f64; 5] = [0.02451, 0.03911, 0.00615, 0.01373, 0.00195];
const NAMES: [&str; 5] = ["K", "inv_Ttheta2", "zeta", "omega", "tau"];
const RUNS: u64 = 200;
const STEP_S: f64 = 1.0 / 32.0;

fn model([gain, z, zeta, omega, delay_s]: [f64; 5]) -> TransferFunction {
    let denominator = vec![Section::Second { c1: 2.0 * zeta * omega, c0: omega * omega }];
    TransferFunction { gain, numerator: vec![Section::First(z)], denominator, delay_s }
}

/// The sweep and the exact response to it.
fn record() -> FrequencyRecord {
    let input: Vec<f64> = (0..3840).map(|k| sweep(STEP_S * f64::from(k))).collect();
    let output = second_order_response(&input, STEP_S, TRUTH);
    FrequencyRecord { step_s: STEP_S, inputs: vec![input], output }
}

fn with_noise(record: &FrequencyRecord, part: f64, seed: u64) -> FrequencyRecord {
    let mut rng = seeded(seed);
    let rms = (record.output.iter().map(|value| value * value).sum::<f64>() / record.output.len() as f64).sqrt();
    let output = record.output.iter().map(|value| value + part * rms * normal(&mut rng)).collect();
    FrequencyRecord { output, ..record.clone() }
}

const FORM: FitSettings = FitSettings { form: Form::ShortPeriod, delay: Delay::Free };

/// Means, scatter, mean standard error and share of intervals that hold the truth.
struct Study {
    mean: [f64; 5],
    scatter: [f64; 5],
    error: [f64; 5],
    coverage: [f64; 5],
}

fn study(fit: impl Fn(&FrequencyRecord) -> EquivalentSystem) -> Study {
    let record = record();
    let fits: Vec<EquivalentSystem> = (0..RUNS).map(|seed| fit(&with_noise(&record, 0.1, seed))).collect();
    let of = |i: usize| fits.iter().map(move |fit| fit.parameter(NAMES[i]).unwrap());
    let moments_of = |i: usize| moments(&of(i).map(|parameter| parameter.value).collect::<Vec<_>>());
    let covered = |i: usize| of(i).filter(|parameter| (parameter.low..=parameter.high).contains(&TRUTH[i])).count();
    let study = Study {
        mean: [0, 1, 2, 3, 4].map(|i| moments_of(i).0),
        scatter: [0, 1, 2, 3, 4].map(|i| moments_of(i).1),
        error: [0, 1, 2, 3, 4].map(|i| of(i).map(|parameter| parameter.standard_error).sum::<f64>() / RUNS as f64),
        coverage: [0, 1, 2, 3, 4].map(|i| covered(i) as f64 / RUNS as f64),
    };
    for i in 0..5 {
        let over = [study.scatter[i], study.error[i]].map(|value| value / BOUND[i]);
        println!(
            "{}: mean {:.5} ({}) scatter/bound {:.3} error/bound {:.3} coverage {:.3}",
            NAMES[i], study.mean[i], TRUTH[i], over[0], over[1], study.coverage[i]
        );
    }
    study
}

#[test]
fn output_error_reaches_the_bound_without_bias_and_its_intervals_hold_the_truth() {
    let band = OutputErrorBand { low_rad_s: 0.1, high_rad_s: TAU, step_rad_s: Some(0.01) };
    let study = study(|record| fit_records(std::slice::from_ref(record), &band, &FORM).unwrap());
    for i in 0..5 {
        let allowed = 3.0 * study.scatter[i] / (RUNS as f64).sqrt() + 0.004 * TRUTH[i];
        assert!((study.mean[i] - TRUTH[i]).abs() < allowed, "{}: {}", NAMES[i], study.mean[i]);
        assert!((0.9..1.2).contains(&(study.scatter[i] / BOUND[i])), "{}: {}", NAMES[i], study.scatter[i]);
        assert!((0.8..1.25).contains(&(study.error[i] / study.scatter[i])), "{}: {}", NAMES[i], study.error[i]);
        assert!((0.90..0.99).contains(&study.coverage[i]), "{}: {}", NAMES[i], study.coverage[i]);
    }
    let mean = study.coverage.iter().sum::<f64>() / 5.0;
    assert!((0.93..=0.97).contains(&mean), "{mean}");
}

#[test]
fn records_that_begin_in_motion_are_fitted_at_their_harmonics() {
    // 25 s out of the middle of the sweep: the motion goes on at both ends.
    let whole = record();
    let cut = |record: &FrequencyRecord, from: usize| FrequencyRecord {
        step_s: STEP_S,
        inputs: vec![record.inputs[0][from..from + 800].to_vec()],
        output: record.output[from..from + 800].iter().map(|value| value + 0.3).collect(),
    };
    let band = OutputErrorBand { low_rad_s: 0.2, high_rad_s: TAU, step_rad_s: None };
    let clean: Vec<FrequencyRecord> = [1500, 2600].map(|from| cut(&whole, from)).into();
    let fit = fit_records(&clean, &band, &FORM).unwrap();
    for (name, truth) in NAMES.iter().zip(TRUTH) {
        let found = fit.parameter(name).unwrap().value;
        assert!((found / truth - 1.0).abs() < 0.02, "{name}: {found}");
    }
    // Without the polynomials of the ends the same records give something else.
    let wrong = fit_records(&clean, &OutputErrorBand { step_rad_s: Some(0.25), ..band }, &FORM).unwrap();
    assert!((wrong.parameter("inv_Ttheta2").unwrap().value / TRUTH[1] - 1.0).abs() > 0.1, "{:?}", wrong.parameters);
    let fits: Vec<EquivalentSystem> = (0..100)
        .map(|seed| {
            let noisy = with_noise(&whole, 0.05, seed);
            let records: Vec<FrequencyRecord> = [1500, 2600].map(|from| cut(&noisy, from)).into();
            fit_records(&records, &band, &FORM).unwrap()
        })
        .collect();
    for (name, truth) in NAMES.iter().zip(TRUTH) {
        let held = fits.iter().map(|fit| fit.parameter(name).unwrap()).filter(|p| (p.low..=p.high).contains(&truth));
        let held = held.count();
        println!("{name}: {held} of 100");
        assert!((86..=100).contains(&held), "{name}: {held} of 100");
    }
}

#[test]
fn coherence_weighted_fit_of_a_composite_response_has_honest_errors() {
    let settings = SpectralSettings {
        omega_rad_s: logarithmic_grid(0.32, TAU, 40),
        windows_s: vec![40.0, 25.0, 15.0],
        overlap: 0.75,
        for_fit: true,
    };
    let study = study(|record| {
        let response = responses(std::slice::from_ref(record), &settings).unwrap().remove(0);
        fit_response(&response, &FORM).unwrap()
    });
    for i in 0..5 {
        let allowed = if i == 4 { 0.003 } else { 0.02 * TRUTH[i] };
        assert!((study.mean[i] - TRUTH[i]).abs() < allowed, "{}: {}", NAMES[i], study.mean[i]);
        assert!((0.9..2.0).contains(&(study.scatter[i] / BOUND[i])), "{}: {}", NAMES[i], study.scatter[i]);
        assert!((0.8..1.25).contains(&(study.error[i] / study.scatter[i])), "{}: {}", NAMES[i], study.error[i]);
        assert!((0.90..0.99).contains(&study.coverage[i]), "{}: {}", NAMES[i], study.coverage[i]);
    }
    let mean = study.coverage.iter().sum::<f64>() / 5.0;
    assert!((0.93..=0.97).contains(&mean), "{mean}");
}

#[test]
fn windows_short_against_the_system_are_seen_through() {
    // Of hardly any noise: what is left is the windows' own. Hann windows of 10 s smooth over a third of the mode's frequency.
    let noisy = with_noise(&record(), 0.001, 1);
    let fit = |window_s: f64, sees_windows: bool| {
        let settings = SpectralSettings {
            omega_rad_s: logarithmic_grid(1.3, TAU, 30),
            windows_s: vec![window_s],
            overlap: 0.8,
            for_fit: true,
        };
        let mut response = responses(std::slice::from_ref(&noisy), &settings).unwrap().remove(0);
        if !sees_windows {
            response.points.iter_mut().for_each(|point| point.window_moments = [Complex::new(0.0, 0.0); 2]);
        }
        let fit = fit_response(&response, &FORM).unwrap();
        let relative = NAMES.iter().zip(TRUTH).map(|(name, truth)| fit.parameter(name).unwrap().value / truth - 1.0);
        relative.fold(0.0, |largest: f64, error| largest.max(error.abs()))
    };
    for window_s in [15.0, 20.0, 30.0] {
        let found = fit(window_s, true);
        assert!(found < 0.012, "{window_s} s: {found}");
    }
    let (seen, unseen) = (fit(10.0, true), fit(10.0, false));
    println!("10 s windows: {seen:.4}, not seen through {unseen:.4}");
    assert!(seen < 0.6 * unseen && unseen > 0.05, "{seen} {unseen}");
}

#[test]
fn bandwidth_and_phase_delay_of_the_attitude_are_the_computed_ones() {
    let curve = BodeCurve::of_model(&model(TRUTH), &logarithmic_grid(0.01, 100.0, 4000)).integrated();
    let found = curve.bandwidth().unwrap();
    approx::assert_relative_eq!(found.omega_180_rad_s, 4.4030, max_relative = 5e-5);
    approx::assert_relative_eq!(found.phase_limited_rad_s.unwrap(), 2.5939, max_relative = 5e-5);
    approx::assert_relative_eq!(found.gain_limited_rad_s.unwrap(), 2.9613, max_relative = 5e-5);
    approx::assert_relative_eq!(found.bandwidth_rad_s().unwrap(), 2.5939, max_relative = 5e-5);
    approx::assert_relative_eq!(found.phase_delay_s.unwrap(), 0.09768, max_relative = 1e-4);
    // Exact responses of the same system, dB and deg.
    for (omega, gain, phase) in
        [(0.1, -6.4895, -0.274), (2.0, -3.4749, -26.825), (4.0, -5.1491, -82.354), (TAU, -9.3256, -115.486)]
    {
        let at = model(TRUTH).at(omega);
        assert!((20.0 * at.norm().log10() - gain).abs() < 1e-4 && (at.arg().to_degrees() - phase).abs() < 1e-3);
    }
    // K/s with a delay: crossover at K, margin 90 deg - K tau, -180 deg at pi / (2 tau).
    let integrator =
        TransferFunction { gain: 3.0, numerator: vec![], denominator: vec![Section::First(0.0)], delay_s: 0.2 };
    let margins = BodeCurve::of_model(&integrator, &logarithmic_grid(0.01, 100.0, 4000)).margins();
    let ((omega_180, gain), (crossover, phase)) = (margins.gain.unwrap(), margins.phase.unwrap());
    approx::assert_relative_eq!(omega_180, 2.5 * std::f64::consts::PI, max_relative = 1e-5);
    approx::assert_relative_eq!(gain, 20.0 * (omega_180 / 3.0).log10(), max_relative = 1e-5);
    approx::assert_relative_eq!(crossover, 3.0, max_relative = 1e-5);
    approx::assert_relative_eq!(phase, std::f64::consts::FRAC_PI_2 - 0.6, max_relative = 1e-5);
}

#[test]
fn response_of_a_linear_model_is_that_of_its_transfer_function() {
    // Short period in states alpha and q: q / eta = (Md s + Md La - Ma Ld) / (s^2 + (La - Mq) s - Ma - Mq La) with Zq = 0.
    let (la, ma, mq, ld, md) = (1.9, -6.5, -1.6, 0.1, -9.0);
    let model = doublet_dynamics::linear::StateSpace::of_states(
        "short period",
        &["alpha", "q"],
        &[("delta_e", "rad")],
        nalgebra::DMatrix::from_row_slice(2, 2, &[-la, 1.0, ma, mq]),
        nalgebra::DMatrix::from_row_slice(2, 1, &[-ld, md]),
    );
    let exact = TransferFunction {
        gain: md,
        numerator: vec![Section::First(la - ma * ld / md)],
        denominator: vec![Section::Second { c1: la - mq, c0: -ma - mq * la }],
        delay_s: 0.0,
    };
    let omega = logarithmic_grid(0.1, 30.0, 9);
    let found = state_space_response(&model, "delta_e", "q", &omega).unwrap();
    for (omega, found) in omega.iter().zip(found) {
        assert!((found / exact.at(*omega) - 1.0).norm() < 1e-12, "{omega}: {found} {}", exact.at(*omega));
    }
    assert_eq!(state_space_response(&model, "delta_r", "q", &omega), None);
}

#[test]
fn what_follows_from_a_fit_carries_its_error() {
    let noisy = with_noise(&record(), 0.1, 5);
    let band = OutputErrorBand { low_rad_s: 0.1, high_rad_s: TAU, step_rad_s: Some(0.01) };
    let fit = fit_records(&[noisy], &band, &FORM).unwrap();
    let [omega, z] = ["omega", "inv_Ttheta2"].map(|name| fit.parameter(name).unwrap());
    let product = |model: &TransferFunction| match (&model.numerator[..], &model.denominator[..]) {
        ([Section::First(z)], [Section::Second { c0, .. }]) => Some(c0.sqrt() / z),
        _ => None,
    };
    let found = fit.propagate("omega_Ttheta2", product).unwrap();
    let value = omega.value / z.value;
    let parts = [omega.standard_error / omega.value, z.standard_error / z.value];
    let variance = parts[0] * parts[0] + parts[1] * parts[1] - 2.0 * fit.correlation[(1, 3)] * parts[0] * parts[1];
    approx::assert_relative_eq!(found.value, value, max_relative = 1e-12);
    approx::assert_relative_eq!(found.standard_error, value * variance.sqrt(), max_relative = 1e-3);
    // Correlations of the bound, computed independently.
    for (i, j, expected) in [(0, 1, -0.854), (0, 2, 0.945), (1, 3, 0.761), (0, 4, 0.879), (3, 4, -0.099)] {
        assert!((fit.correlation[(i, j)] - expected).abs() < 0.1, "{i} {j}: {}", fit.correlation[(i, j)]);
    }
}

/// Points of an exact response with small errors.
fn exact_response(model: &TransferFunction, omega: &[f64]) -> doublet_dynamics::frequency::FrequencyResponse {
    let point = |&omega_rad_s: &f64| doublet_dynamics::frequency::ResponsePoint {
        omega_rad_s,
        response: model.at(omega_rad_s),
        coherence: 0.99,
        ordinary_coherence: 0.99,
        multiple_coherence: 0.99,
        averages: 20.0,
        window_moments: [Complex::new(0.0, 0.0); 2],
        relative_sd: 0.01,
        noise_sd: 0.01,
    };
    let points = omega.iter().map(point).collect();
    doublet_dynamics::frequency::FrequencyResponse {
        input: 0,
        points,
        error_correlation: None,
        overlap_constants: vec![],
    }
}

/// The interval begins at the bound. The delays drawn are the positive half of a normal distribution: 95 % lie below the upper end, and their
/// mean is `sqrt(2 / pi)` standard errors.
fn delay_at_its_bound_has_a_one_sided_interval(fit: &EquivalentSystem) {
    const DRAWS: usize = 4000;
    let delay = fit.parameter("tau").unwrap();
    assert!(delay.value == 0.0 && delay.low == 0.0 && delay.standard_error > 0.0, "{delay:?}");
    let drawn: Vec<f64> = fit.samples(DRAWS, 3).iter().map(|model| model.delay_s).collect();
    assert!(drawn.iter().all(|delay_s| *delay_s >= 0.0));
    let below = drawn.iter().filter(|delay_s| **delay_s <= delay.high).count() as f64 / DRAWS as f64;
    assert!((0.94..0.965).contains(&below), "{below}");
    let mean = drawn.iter().sum::<f64>() / DRAWS as f64 / delay.standard_error;
    assert!((mean - std::f64::consts::FRAC_2_PI.sqrt()).abs() < 0.03, "{mean}");
}

#[test]
fn every_form_is_found_from_its_own_response() {
    let grid = logarithmic_grid(0.1, 20.0, 60);
    let roll =
        TransferFunction { gain: -8.0, numerator: vec![], denominator: vec![Section::First(3.1)], delay_s: 0.09 };
    let fit =
        fit_response(&exact_response(&roll, &grid), &FitSettings { form: Form::Roll, delay: Delay::Free }).unwrap();
    for (name, value) in [("K", -8.0), ("inv_TR", 3.1), ("tau", 0.09)] {
        approx::assert_relative_eq!(fit.parameter(name).unwrap().value, value, max_relative = 1e-6);
    }
    let high = TransferFunction {
        gain: 12.4,
        numerator: vec![Section::First(8.1 / 12.4)],
        denominator: vec![Section::Second { c1: 5.16, c0: 18.49 }, Section::First(0.98)],
        delay_s: 0.0,
    };
    let form = FitSettings { form: Form::parse("1/3").unwrap(), delay: Delay::Free };
    let fit = fit_response(&exact_response(&high, &grid), &form).unwrap();
    assert!(Mismatch::compare(&fit.model, &exact_response(&high, &grid)).unwrap().cost < 1e-6, "{:?}", fit.model);
    assert!(fit.parameter("tau").unwrap().value < 1e-4);
    // A second-order model of it is lower: what it lacks becomes delay, and is told.
    let lower = fit_response(&exact_response(&high, &grid), &FORM).unwrap();
    let mismatch = Mismatch::compare(&lower.model, &exact_response(&high, &grid)).unwrap();
    assert!(mismatch.cost > 1e-3 && lower.error_ratio.unwrap() > 0.0, "{mismatch:?}");
    // A true delay below zero stops at zero.
    let early = TransferFunction { delay_s: -0.05, ..roll.clone() };
    let fit =
        fit_response(&exact_response(&early, &grid), &FitSettings { form: Form::Roll, delay: Delay::Free }).unwrap();
    assert!(fit.is_delay_at_zero && fit.model.delay_s == 0.0 && fit.error_ratio.unwrap() > 2.0);
    delay_at_its_bound_has_a_one_sided_interval(&fit);
    // A delay that is known is kept.
    let fixed = FitSettings { form: Form::Roll, delay: Delay::Fixed(0.09) };
    let fit = fit_response(&exact_response(&roll, &grid), &fixed).unwrap();
    assert!(!fit.is_delay_at_zero && fit.parameter("tau").unwrap().standard_error == 0.0);
    approx::assert_relative_eq!(fit.parameter("K").unwrap().value, -8.0, max_relative = 1e-9);
    let few = fit_response(&exact_response(&roll, &grid[..2]), &FORM).unwrap_err();
    assert_eq!(few, FrequencyError::TooFewPoints { points: 2, parameters: 5 });
    for wrong in ["2/1", "1/9", "pitch", "/"] {
        assert!(Form::parse(wrong).is_err(), "{wrong}");
    }
    let poles: Vec<Complex<f64>> = high.poles();
    assert!((poles[2].re + 0.98).abs() < 1e-12 && (poles[0].norm() - 4.3).abs() < 1e-12);
}
