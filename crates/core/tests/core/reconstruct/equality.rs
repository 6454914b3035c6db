//! The packed form against the specification, `filter::ekf` and `smoother::rts`, over random windows, masks and settings.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

use doublet_core::reconstruct::{
    AIR_STATES, FilterData, FilterSettings, InputHold, InputSeries, Linearisation, MEASUREMENTS, MeasurementSeries,
    Method, Reconstruction, STATES, State, ValidSettings, Width, lanes, reconstruct_with,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Settings, each for its own windows.
const SETTINGS: u64 = 12;
/// Windows of each: more than four, so that the widest vectors are used, and fewer than eight, so that lanes stay empty.
const WINDOWS: usize = 5;
/// Deviation of a sensor error that changes nothing: with it a run takes the specification.
const NEGLIGIBLE: f64 = 1e-30;
/// Agreement of two forms of the same recursion, in standard deviations; the backward one solves with a covariance of condition 1e10.
const FORMS_SIGMA: f64 = 1e-5;
/// Part of its largest deviation below which a state counts as known: its variance is then lost in the rounding of others.
const KNOWN: f64 = 1e-3;
/// Agreement of the logarithm of the likelihood, relative.
const LIKELIHOOD: f64 = 1e-8;

/// Two to five seconds of a weaving flight; every measurement at a rate of its own, with gaps, or absent; some of them between the
/// inertial samples.
pub fn weaving_flight(random: &mut ChaCha8Rng) -> FilterData {
    let samples = random.random_range(100..250);
    let time_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * 0.02).collect();
    let mut wave = |level: f64, size: f64, times: &[f64]| -> Vec<f64> {
        let (rate, phase) = (random.random_range(0.5..3.0), random.random_range(0.0..TAU));
        times.iter().map(|t| level + size * (rate * t + phase).sin()).collect()
    };
    let inputs = [(0.7, 0.2), (0.0, 0.3), (-9.8, 0.5), (0.0, 0.1), (0.0, 0.05), (0.0, 0.03)];
    let columns = inputs.map(|(level, size)| wave(level, size, &time_s));
    let outputs: [(f64, f64); MEASUREMENTS] = [
        (0.0, 1.0),
        (0.0, 1.0),
        (-900.0, 0.5),
        (80.0, 0.1),
        (0.0, 0.2),
        (0.0, 0.1),
        (0.0, 0.03),
        (0.075, 0.03),
        (0.0, 0.015),
        (80.2, 0.1),
        (0.075, 0.01),
        (0.0, 0.01),
    ];
    let mut measurements = outputs.map(|(level, size)| MeasurementSeries {
        values: wave(level, size, &time_s).into(),
        time_s: time_s.clone().into(),
    });
    Arc::make_mut(&mut measurements[0].values)
        .iter_mut()
        .zip(&time_s)
        .for_each(|(value, time_s)| *value += 80.0 * time_s);
    let is_synchronous = random.random_bool(0.3);
    for series in &mut measurements {
        if random.random_bool(0.2) {
            *series = MeasurementSeries::default();
            continue;
        }
        for value in Arc::make_mut(&mut series.values) {
            if random.random_bool(0.1) {
                *value = f64::NAN;
            }
        }
        if !is_synchronous {
            let every = random.random_range(1..8);
            let shift_s = if random.random_bool(0.5) { random.random_range(0.0..0.02) } else { 0.0 };
            series.time_s = series.time_s.iter().step_by(every).map(|time| time + shift_s).collect();
            series.values = series.values.iter().copied().step_by(every).collect();
        }
    }
    FilterData { inputs: InputSeries { time_s: time_s.into(), columns: columns.map(Arc::from) }, measurements }
}

/// One to three linearisations, either hold and linearisation of the transition; noise within a factor of three; random walks, known states and delays.
fn settings(random: &mut ChaCha8Rng) -> FilterSettings {
    let mut settings = FilterSettings { smooth: true, ..FilterSettings::default() };
    // A number of iterations that rounding cannot change: `reference` tests where the iteration stops.
    settings.method = Method::Iekf { max_iterations: random.random_range(1..4), tolerance: 1e-12 };
    if random.random_bool(0.5) {
        settings.hold = InputHold::ZeroOrder;
    }
    if random.random_bool(0.5) {
        settings.linearisation = Linearisation::Predicted;
    }
    let noises = settings.process_noise.iter_mut().chain(&mut settings.measurement_noise);
    noises.for_each(|noise| *noise *= random.random_range(-1.0_f64..1.0).exp());
    for k in 9..STATES {
        if random.random_bool(0.3) {
            // Wind walks move the velocity relative to the air: 0.4 m/s per square root of a second are strong gusts.
            let part = if k < State::WindNorth as usize { 0.3 } else { 0.02 };
            settings.random_walk[k] = part * settings.initial_deviation[k];
        }
        if random.random_bool(0.2) {
            settings.initial_deviation[k] = 0.0;
        }
    }
    for delay in &mut settings.measurement_delay_s {
        if random.random_bool(0.1) {
            *delay = 0.05;
        }
    }
    settings
}

/// Largest difference of two runs over filtered and smoothed states, in standard deviations.
fn largest_difference(run: &Reconstruction, other: &Reconstruction) -> f64 {
    let [smoothed, other_smoothed] = [run, other].map(|run| run.smoothed.as_ref().unwrap());
    let mut largest: f64 = 0.0;
    for k in 0..STATES {
        for (states, deviations, others, other_deviations) in [
            (&run.states[k], &run.deviations[k], &other.states[k], &other.deviations[k]),
            (&smoothed.states[k], &smoothed.deviations[k], &other_smoothed.states[k], &other_smoothed.deviations[k]),
        ] {
            assert_eq!(states.len(), others.len());
            let least = KNOWN * deviations.iter().fold(1e-9, f64::max);
            for i in 0..states.len() {
                let scale = deviations.at(i).max(least);
                largest = largest.max((states[i] - others[i]).abs() / scale);
                largest = largest.max((deviations.at(i) - other_deviations.at(i)).abs() / scale);
            }
        }
    }
    for m in 0..MEASUREMENTS {
        let innovations = run.innovations[m].iter().zip(&other.innovations[m]).zip(&run.innovation_deviations[m]);
        for ((innovation, other), deviation) in innovations.filter(|((a, b), _)| !(a.is_nan() && b.is_nan())) {
            largest = largest.max((innovation - other).abs() / deviation);
        }
    }
    largest
}

#[test]
fn the_packed_form_equals_the_specification_over_random_windows_masks_and_settings() {
    let mut largest: f64 = 0.0;
    for seed in 0..SETTINGS {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut settings = settings(&mut random);
        settings.robust_limit = if seed % 2 == 1 { 1.5 } else { 0.0 };
        let flights: Vec<FilterData> = (0..WINDOWS).map(|_| weaving_flight(&mut random)).collect();
        let flights: Vec<&FilterData> = flights.iter().collect();
        let run = |width: Width, settings: &ValidSettings| -> Vec<Reconstruction> {
            let found = reconstruct_with(width, &flights, settings, &mut |_| ControlFlow::Continue(()));
            found.into_iter().map(Result::unwrap).collect()
        };
        let dense = FilterSettings { air_data_deviation: [NEGLIGIBLE; AIR_STATES], ..settings.clone() };
        let specified = run(Width::Two, &dense.check().unwrap());
        assert!(specified.iter().all(|run| run.air_data.is_some()));
        let widths = [Width::Two, Width::Four, Width::Eight].into_iter().filter(|width| width.lanes() <= lanes());
        let valid = settings.check().unwrap();
        let packed: Vec<Vec<Reconstruction>> = widths.map(|width| run(width, &valid)).collect();
        for packed in &packed {
            for (specified, packed) in specified.iter().zip(packed) {
                assert!(
                    packed.warnings.iter().all(|warning| !warning.to_string().contains("Joseph")),
                    "{:?}",
                    packed.warnings
                );
                let difference = largest_difference(specified, packed);
                println!("{seed}: {difference:.1e}");
                assert!(difference < FORMS_SIGMA, "{seed}: {difference}");
                let likelihood = (specified.log_likelihood - packed.log_likelihood) / specified.log_likelihood;
                assert!(likelihood.abs() < LIKELIHOOD, "{seed}: {likelihood}");
                assert_eq!(specified.nis_degrees, packed.nis_degrees);
                largest = largest.max(difference);
            }
        }
        if let [_, four, eight] = packed.as_slice() {
            for (four, eight) in four.iter().zip(eight) {
                assert_eq!(four.states, eight.states, "{seed}: AVX2 and AVX-512 differ");
                assert_eq!(four.smoothed, eight.smoothed, "{seed}: AVX2 and AVX-512 differ");
            }
        }
    }
    println!("largest difference {largest:.1e} standard deviations");
}
