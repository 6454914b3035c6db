//! Data compatibility: constant errors of sensors on a simulated flight, beside a maximum-likelihood solution written here.

use std::sync::Arc;

use doublet_core::estimate::{
    ErrorTerm, EstimateError, Freedom, NoiseModel, OutputErrorSettings, SensorError, SensorErrorFault, SensorErrorFit,
    SensorErrorSettings, SensorErrorWindow, sensor_errors,
};
use doublet_core::reconstruct::{
    FilterData, INPUTS, InputSeries, MEASUREMENTS, Measurement, MeasurementSeries, STATES,
};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::flight::{GRAVITY_M_S2, STEP_S, replay, truth};

/// Samples of the flight: 30 s, with a 3-2-1-1 of each control in the first nine.
const SAMPLES: usize = 1500;
/// Errors of the sensors, SI.
const ERRORS: [(&str, f64); 7] = [
    ("scale_theta", 0.05),
    ("scale_alpha", 0.08),
    ("scale_beta", -0.10),
    ("scale_airspeed", 0.03),
    ("bias_az", 0.15),
    ("bias_p", 0.002),
    ("bias_q", -0.001),
];
/// Measurements compared, with the deviations of their noise.
const OUTPUTS: [(Measurement, f64); 6] = [
    (Measurement::BankAngle, 2e-3),
    (Measurement::PitchAngle, 2e-3),
    (Measurement::HeadingAngle, 2e-3),
    (Measurement::Airspeed, 0.3),
    (Measurement::AngleOfAttack, 3e-3),
    (Measurement::Sideslip, 3e-3),
];
/// Deviations of accelerometers and gyros where they have noise.
const INERTIAL: [f64; INPUTS] = [0.03, 0.03, 0.03, 3e-4, 3e-4, 3e-4];

/// The flight without errors: inertial samples, and the six measurements in the order of [`OUTPUTS`].
fn flown() -> ([Vec<f64>; INPUTS], [Vec<f64>; 6]) {
    let (replay, start) = replay(SAMPLES).unwrap();
    let flight = replay.fly(&truth(), &start).unwrap();
    let [ax, ay, az] = flight.specific_force_m_s2.clone();
    let [p, q, r] = flight.rates_rad_s.clone();
    let [phi, theta, psi] = flight.euler_rad.clone();
    ([ax, ay, az, p, q, r], [phi, theta, psi, flight.airspeed_m_s, flight.alpha_rad, flight.beta_rad])
}

/// Error `name` of the truth.
fn true_error(name: &str) -> f64 {
    ERRORS.iter().find(|(other, _)| *other == name).map_or(0.0, |(_, value)| *value)
}

/// The windows as sensors with [`ERRORS`] and noise show the flight; inertial samples without noise where `inertial` is zero.
fn recorded(seed: u64, inertial: f64, windows: &[std::ops::Range<usize>]) -> Vec<FilterData> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |deviation: f64| deviation * Distribution::<f64>::sample(&StandardNormal, &mut rng);
    let (mut inputs, mut shown) = flown();
    let names = ["ax", "ay", "az", "p", "q", "r"];
    for ((column, name), deviation) in inputs.iter_mut().zip(names).zip(INERTIAL) {
        let bias = true_error(&format!("bias_{name}"));
        column.iter_mut().for_each(|value| *value += bias + draw(inertial * deviation));
    }
    for (column, (measurement, deviation)) in shown.iter_mut().zip(OUTPUTS) {
        let scale = 1.0 + true_error(&format!("scale_{}", measurement.name()));
        column.iter_mut().for_each(|value| *value = scale * *value + draw(deviation));
    }
    let window = |range: &std::ops::Range<usize>| {
        let time_s: Arc<[f64]> = range.clone().map(|k| STEP_S * k as f64).collect();
        let mut measurements: [MeasurementSeries; MEASUREMENTS] = Default::default();
        for (column, (measurement, _)) in shown.iter().zip(OUTPUTS) {
            let values = column[range.clone()].into();
            measurements[measurement as usize] = MeasurementSeries { time_s: Arc::clone(&time_s), values };
        }
        let columns = inputs.each_ref().map(|column| column[range.clone()].into());
        FilterData { inputs: InputSeries { time_s, columns }, measurements }
    };
    windows.iter().map(window).collect()
}

fn term(name: &str) -> ErrorTerm {
    let error = SensorError::from_name(name).unwrap();
    ErrorTerm { error, freedom: Freedom::Common, value: 0.0, random_walk: 0.0 }
}

fn settings(noise: NoiseModel) -> SensorErrorSettings {
    SensorErrorSettings {
        errors: ERRORS.iter().map(|(name, _)| term(name)).collect(),
        outputs: OUTPUTS.iter().map(|(output, _)| *output).collect(),
        wind: false,
        gravity_m_s2: GRAVITY_M_S2,
        noise,
        search: OutputErrorSettings { tolerance: 1e-6, relative_step: 1e-3, ..OutputErrorSettings::default() },
    }
}

fn stated() -> NoiseModel {
    let mut measurement = [1.0; MEASUREMENTS];
    for (output, deviation) in OUTPUTS {
        measurement[output as usize] = deviation;
    }
    NoiseModel::Stated { process: INERTIAL, measurement, path: [0.0; STATES] }
}

fn estimate(data: &[FilterData], settings: &SensorErrorSettings) -> Result<SensorErrorFit, SensorErrorFault> {
    let windows: Vec<_> =
        data.iter().enumerate().map(|(k, data)| SensorErrorWindow { label: format!("w{k}"), data }).collect();
    sensor_errors(&windows, settings, &|| true)
}

#[expect(clippy::single_range_in_vec_init, reason = "the samples of the only manoeuvre")]
const WHOLE: [std::ops::Range<usize>; 1] = [0..SAMPLES];
const HALVES: [std::ops::Range<usize>; 2] = [0..SAMPLES / 2, SAMPLES / 2..SAMPLES];

/// Seeds: 200 by `DOUBLET_SEEDS=200`, a few without.
fn seeds(few: u64) -> u64 {
    std::env::var("DOUBLET_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(few)
}

/// Shares of the estimates within 1.96 and within 3 standard errors, and the mean squared normalised error.
fn coverage(noise: NoiseModel, inertial: f64, windows: &[std::ops::Range<usize>], seeds: u64) -> [f64; 3] {
    let (mut within, mut near, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..seeds {
        let fit = estimate(&recorded(seed, inertial, windows), &settings(noise)).unwrap();
        for (found, (name, value)) in fit.errors.iter().zip(ERRORS) {
            assert_eq!(found.error.to_string(), name);
            let off = ((found.value - value) / found.standard_error).abs();
            count += 1.0;
            within += f64::from(u8::from(off < 1.96));
            near += f64::from(u8::from(off < 3.0));
            squares += off * off;
        }
    }
    [within / count, near / count, squares / count]
}

#[test]
fn scale_factors_and_biases_of_a_flight_are_found_within_their_errors() {
    let fit = estimate(&recorded(7, 0.0, &WHOLE), &settings(NoiseModel::Residuals)).unwrap();
    for (found, (name, value)) in fit.errors.iter().zip(ERRORS) {
        let off = (found.value - value) / found.standard_error;
        println!("{name}: {value} found {} +- {} ({off:.2})", found.value, found.standard_error);
        assert!(off.abs() < 2.0, "{name}: {} +- {}", found.value, found.standard_error);
        assert!(found.standard_error < 0.2 * value.abs(), "{name}: {}", found.standard_error);
        assert!((0.8..1.25).contains(&(found.corrected_error / found.standard_error)), "white residuals: {name}");
    }
    for (residual, (measurement, deviation)) in fit.outputs.iter().zip(OUTPUTS) {
        assert_eq!((residual.measurement, residual.samples), (measurement, SAMPLES - 1));
        assert!((residual.rms / deviation - 1.0).abs() < 0.06, "{residual:?}");
    }
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let seeds = seeds(24);
    let cases = [("output error", NoiseModel::Residuals, 0.0), ("filter error", stated(), 1.0)];
    for (name, noise, inertial) in cases {
        let [within, near, squares] = coverage(noise, inertial, &HALVES, seeds);
        println!("{name}, {seeds} seeds: {:.1} % within 1.96, mean square {squares:.3}", 100.0 * within);
        // Of 200 seeds 1400 estimates: 95 % +- 0.6 %; of 24 seeds +- 1.7 %.
        let allowed = if seeds >= 200 { 0.93..0.97 } else { 0.90..1.0 };
        assert!(allowed.contains(&within) && near > 0.98, "{name}: {within}, {near}");
    }
}

/// Maximum likelihood written plainly: fixed-step integration of the kinematics, finite differences, Gauss-Newton on the residuals in
/// their own deviations. Gives estimates and standard errors of `[errors in the order of ERRORS, then per window u v w phi theta psi]`.
#[expect(clippy::too_many_lines, reason = "an independent computation that is read from top to bottom")]
fn plain_maximum_likelihood(data: &[FilterData]) -> (Vec<f64>, Vec<f64>) {
    let rate = |x: [f64; 6], f: [f64; 6]| {
        let [u, v, w, phi, theta, _] = x;
        let [ax, ay, az, p, q, r] = f;
        let turn = q * phi.sin() + r * phi.cos();
        [
            ax - GRAVITY_M_S2 * theta.sin() - q * w + r * v,
            ay + GRAVITY_M_S2 * theta.cos() * phi.sin() - r * u + p * w,
            az + GRAVITY_M_S2 * theta.cos() * phi.cos() - p * v + q * u,
            p + turn * theta.tan(),
            q * phi.cos() - r * phi.sin(),
            turn / theta.cos(),
        ]
    };
    let outputs = |window: &FilterData, theta: &[f64], start: &[f64]| -> DVector<f64> {
        let [k_theta, k_alpha, k_beta, k_v, b_az, b_p, b_q]: [f64; 7] = theta.try_into().unwrap();
        let columns = &window.inputs.columns;
        let at = |k: usize| {
            let mut f: [f64; 6] = std::array::from_fn(|i| columns[i][k]);
            f[2] -= b_az;
            f[3] -= b_p;
            f[4] -= b_q;
            f
        };
        let mut x: [f64; 6] = start.try_into().unwrap();
        let mut shown = Vec::new();
        for k in 1..window.inputs.time_s.len() {
            let (before, after) = (at(k - 1), at(k));
            let middle = std::array::from_fn(|i| 0.5 * (before[i] + after[i]));
            let along = |slope: [f64; 6], h: f64| std::array::from_fn(|i| x[i] + h * slope[i]);
            let k1 = rate(x, before);
            let k2 = rate(along(k1, 0.5 * STEP_S), middle);
            let k3 = rate(along(k2, 0.5 * STEP_S), middle);
            let k4 = rate(along(k3, STEP_S), after);
            x = std::array::from_fn(|i| x[i] + STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            let [u, v, w, phi, pitch, psi] = x;
            let speed = (u * u + v * v + w * w).sqrt();
            shown.extend([phi, (1.0 + k_theta) * pitch, psi, (1.0 + k_v) * speed]);
            shown.extend([(1.0 + k_alpha) * w.atan2(u), (1.0 + k_beta) * (v / speed).asin()]);
        }
        DVector::from_vec(shown)
    };
    let measured = DVector::from_iterator(
        data.iter().map(|window| 6 * (window.inputs.time_s.len() - 1)).sum(),
        data.iter().flat_map(|window| {
            let shown = |k: usize| OUTPUTS.map(|(output, _)| window.measurements[output as usize].values[k]);
            (1..window.inputs.time_s.len()).flat_map(shown)
        }),
    );
    let mut theta = vec![0.0; ERRORS.len()];
    for window in data {
        let first = OUTPUTS.map(|(output, _)| window.measurements[output as usize].values[0]);
        let [phi, pitch, psi, speed, alpha, beta] = first;
        let ahead = speed * beta.cos();
        theta.extend([ahead * alpha.cos(), speed * beta.sin(), ahead * alpha.sin(), phi, pitch, psi]);
    }
    let simulate = |theta: &[f64]| {
        let (errors, starts) = theta.split_at(ERRORS.len());
        let all = data
            .iter()
            .zip(starts.chunks(6))
            .flat_map(|(window, start)| outputs(window, errors, start).iter().copied().collect::<Vec<_>>());
        DVector::from_iterator(measured.len(), all)
    };
    let mut errors = Vec::new();
    for _ in 0..12 {
        let y = simulate(&theta);
        let residual = &measured - &y;
        let samples = measured.len() as f64 / 6.0;
        let mut noise = [0.0; 6];
        residual.iter().enumerate().for_each(|(k, v)| noise[k % 6] += v * v / samples);
        let columns: Vec<DVector<f64>> = (0..theta.len())
            .map(|p| {
                let (mut above, mut below) = (theta.clone(), theta.clone());
                above[p] += 1e-5;
                below[p] -= 1e-5;
                (simulate(&above) - simulate(&below)) / 2e-5
            })
            .collect();
        let mut s = DMatrix::from_columns(&columns);
        s.row_iter_mut().enumerate().for_each(|(k, mut row)| row /= noise[k % 6].sqrt());
        let weighted = DVector::from_fn(residual.len(), |k, _| residual[k] / noise[k % 6].sqrt());
        let inverse = s.tr_mul(&s).try_inverse().unwrap();
        let step = &inverse * s.tr_mul(&weighted);
        theta.iter_mut().zip(step.iter()).for_each(|(value, step)| *value += step);
        errors = inverse.diagonal().iter().map(|variance| variance.sqrt()).collect();
    }
    (theta, errors)
}

#[test]
fn independent_maximum_likelihood_gives_the_same() {
    let data = recorded(3, 0.0, &HALVES);
    let fit = estimate(&data, &settings(NoiseModel::Residuals)).unwrap();
    let (theta, errors) = plain_maximum_likelihood(&data);
    for (k, found) in fit.errors.iter().enumerate() {
        let apart = (found.value - theta[k]) / errors[k];
        let ratio = found.standard_error / errors[k];
        println!(
            "{}: {} and {}, {apart:.1e} errors apart; errors' ratio {ratio:.5}",
            found.error, found.value, theta[k]
        );
        assert!(apart.abs() < 1e-3 && (ratio - 1.0).abs() < 1e-3, "{}: {apart}, {ratio}", found.error);
    }
}

#[test]
fn noise_of_the_inertial_unit_is_in_the_errors_of_filter_error_only() {
    let (mut output, mut filter) = (0.0, 0.0);
    for seed in 0..6 {
        let data = recorded(seed, 4.0, &HALVES);
        let NoiseModel::Stated { process, measurement, path } = stated() else { return };
        let noise = NoiseModel::Stated { process: process.map(|deviation| 4.0 * deviation), measurement, path };
        for (noise, squares) in [(NoiseModel::Residuals, &mut output), (noise, &mut filter)] {
            let fit = estimate(&data, &settings(noise)).unwrap();
            let off = fit
                .errors
                .iter()
                .zip(ERRORS)
                .map(|(found, (_, value))| ((found.value - value) / found.standard_error).powi(2));
            *squares += off.sum::<f64>() / (6.0 * ERRORS.len() as f64);
        }
    }
    println!("mean squared normalised error: output error {output:.2}, filter error {filter:.2}");
    assert!(output > 2.0 && (0.5..1.7).contains(&filter), "{output}, {filter}");
}

#[test]
fn constant_common_to_windows_is_told_better_than_by_each() {
    let fit = estimate(&recorded(1, 0.0, &HALVES), &settings(NoiseModel::Residuals)).unwrap();
    for found in &fit.errors {
        let alone: Vec<f64> = found.windows.iter().map(|window| window.standard_error).collect();
        assert_eq!(alone.len(), 2, "{}", found.error);
        let together = alone.iter().map(|error| error.powi(-2)).sum::<f64>().sqrt().recip();
        assert!(found.standard_error <= 1.000_001 * together, "{}: {alone:?}, {}", found.error, found.standard_error);
    }
    // The rudder and ailerons rest in the second half: sideslip tells its scale less well there.
    let beta = fit.errors.iter().find(|found| found.error.to_string() == "scale_beta").unwrap();
    assert!(beta.windows[1].standard_error > 3.0 * beta.windows[0].standard_error, "{:?}", beta.windows);
    // Each window by itself gives what the other form of the same problem gives.
    let mut own = settings(NoiseModel::Residuals);
    own.errors.iter_mut().for_each(|term| term.freedom = Freedom::PerWindow);
    let fit = estimate(&recorded(1, 0.0, &HALVES), &own).unwrap();
    assert_eq!(fit.errors.len(), 2 * ERRORS.len());
    assert_eq!(fit.errors[0].window.as_deref(), Some("w0"));
}

#[test]
fn what_the_samples_cannot_tell_is_named() {
    // Without a flow angle nothing tells a scale of one.
    let mut blind = settings(NoiseModel::Residuals);
    blind.outputs.retain(|output| *output != Measurement::AngleOfAttack);
    let error = estimate(&recorded(1, 0.0, &WHOLE), &blind).unwrap_err();
    assert!(error.to_string().contains("scale_alpha is free, but alpha is not a measured output"), "{error}");
    // The start of the heading and a bias of the heading are one number.
    let mut twice = settings(NoiseModel::Residuals);
    twice.errors.push(term("bias_psi"));
    let error = estimate(&recorded(1, 0.0, &WHOLE), &twice).unwrap_err();
    assert!(matches!(&error, SensorErrorFault::Estimate(EstimateError::RankDeficient { .. })), "{error}");
    assert!(error.to_string().contains("bias_psi") && error.to_string().contains("psi start[w0]"), "{error}");
    let mut walking = settings(NoiseModel::Residuals);
    walking.errors[5].random_walk = 1e-4;
    let error = estimate(&recorded(1, 0.0, &WHOLE), &walking).unwrap_err();
    assert!(error.to_string().contains("bias_p has a random walk"), "{error}");
}

#[test]
fn bias_that_walks_is_followed() {
    let walk = 4e-4;
    let mut data = recorded(5, 1.0, &WHOLE);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(50);
    let mut drift = 0.0;
    for value in Arc::make_mut(&mut data[0].inputs.columns[3]) {
        let draw: f64 = StandardNormal.sample(&mut rng);
        drift += walk * STEP_S.sqrt() * draw;
        *value += drift;
    }
    let constant = estimate(&data, &settings(stated())).unwrap();
    let mut walking = settings(stated());
    walking.errors[5].random_walk = walk;
    let walking = estimate(&data, &walking).unwrap();
    let normalised = |fit: &SensorErrorFit| fit.outputs[0].normalised;
    println!(
        "bank angle's innovations: {:.3} with a constant, {:.3} with a walk",
        normalised(&constant),
        normalised(&walking)
    );
    assert!(normalised(&constant) > 1.1 && (normalised(&walking) - 1.0).abs() < 0.06);
    let bias = &walking.errors[5];
    assert!((bias.value - 0.002).abs() < 3.0 * bias.standard_error, "{bias:?}");
}
