//! Speed of the reconstruction over a flight of 23 manoeuvres, beside a plain dense filter on the same data.

// a bench may stop with a message, and its table belongs on the standard output
#![allow(clippy::expect_used, clippy::print_stdout)]

#[path = "../tests/core/reconstruct/dense.rs"]
#[allow(dead_code)]
mod dense;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use dense::{Dense, Discretisation, P, Step, X, Z};
use doublet_core::reconstruct::{
    FilterData, FilterSettings, InputHold, InputSeries, MeasurementSeries, Method, ReconstructError, Reconstruction,
    Width, lanes, reconstruct_with,
};
use rand::{RngExt, SeedableRng};

const MANOEUVRES: usize = 23;
const SAMPLES: usize = 2_501;

/// A manoeuvre of smooth made-up motion: inputs, and measurements from integrating them, with noise.
fn manoeuvre(seed: u64, samples: usize, settings: &FilterSettings) -> FilterData {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sigma: f64| sigma * (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0 * sigma;
    let dt = 0.01;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * dt).collect();
    let clean = |t: f64| {
        let turn = |period: f64, phase: f64| (t * std::f64::consts::TAU / period + phase).sin();
        let phase = seed as f64;
        [
            0.3 * turn(7.0, phase),
            0.2 * turn(5.0, phase),
            -9.8 + turn(3.0, phase),
            0.1 * turn(2.0, phase),
            0.05 * turn(3.0, 0.0),
            0.03 * turn(4.0, phase),
        ]
    };
    let filter = dense_filter(settings);
    let mut x = X::zeros();
    (x[3], x[5], x[8]) = (80.0, 6.0, 0.3);
    let mut columns: [Vec<f64>; 6] = Default::default();
    let mut values: [Vec<f64>; 12] = Default::default();
    for (k, &t) in time_s.iter().enumerate() {
        if k > 0 {
            let step =
                Step { dt, noise_scale: 1.0, start: clean(t - dt), end: clean(t), z: Z::zeros(), present: [false; 12] };
            x = filter.integrate(&x, &step);
        }
        for (i, value) in clean(t).into_iter().enumerate() {
            columns[i].push(value + noise(settings.process_noise[i]));
        }
        let mut state = [0.0; 18];
        state.copy_from_slice(x.as_slice());
        for (m, value) in dense::h(&state).into_iter().enumerate() {
            values[m].push(value + noise(settings.measurement_noise[m]));
        }
    }
    let time_s: Arc<[f64]> = time_s.into();
    FilterData {
        inputs: InputSeries { time_s: Arc::clone(&time_s), columns: columns.map(Arc::from) },
        measurements: values.map(|values| MeasurementSeries { time_s: Arc::clone(&time_s), values: values.into() }),
    }
}

fn dense_filter(settings: &FilterSettings) -> Dense {
    let (max_iterations, tolerance) = match settings.method {
        Method::Ekf | Method::Ukf { .. } => (1, 1.0),
        Method::Iekf { max_iterations, tolerance } => (max_iterations, tolerance),
    };
    Dense {
        gravity: settings.gravity_m_s2,
        q: nalgebra::SVector::from(settings.process_noise.map(|s| s * s)),
        r: Z::from(settings.measurement_noise.map(|s| s * s)),
        random_walk: X::zeros(),
        discretisation: Discretisation::ThirdOrder,
        at_predicted: false,
        max_iterations,
        tolerance,
    }
}

/// The dense filter over one manoeuvre, its estimates and deviations kept as the production filter keeps them.
fn run_dense(filter: &Dense, data: &FilterData, settings: &FilterSettings) -> Vec<[f64; 36]> {
    let mut x = X::zeros();
    (x[3], x[5], x[8]) = (80.0, 6.0, 0.3);
    let mut p = P::from_diagonal(&X::from(settings.initial_deviation.map(|s| s * s)));
    let time_s = &data.inputs.time_s;
    let mut kept = Vec::with_capacity(time_s.len());
    for k in 1..time_s.len() {
        let at = |k: usize| std::array::from_fn(|i| data.inputs.columns[i][k]);
        let step = Step {
            dt: time_s[k] - time_s[k - 1],
            noise_scale: 1.0,
            start: at(k - 1),
            end: at(if settings.hold == InputHold::FirstOrder { k } else { k - 1 }),
            z: Z::from_fn(|m, _| data.measurements[m].values[k]),
            present: [true; 12],
        };
        filter.step(&mut x, &mut p, &step);
        let mut row = [0.0; 36];
        for i in 0..18 {
            row[i] = x[i];
            row[18 + i] = p[(i, i)].sqrt();
        }
        kept.push(row);
    }
    kept
}

fn settings(method: Method) -> FilterSettings {
    FilterSettings { method, ..FilterSettings::default() }
}

fn flight(samples: usize) -> Vec<FilterData> {
    (0..MANOEUVRES).map(|k| manoeuvre(k as u64, samples, &settings(Method::Ekf))).collect()
}

fn iekf() -> Method {
    FilterSettings::default().method
}

/// Widest vector to use: `DOUBLET_BENCH_LANES=2`, `4` (AVX2) or `8` (AVX-512, the default), where the machine has it.
fn width() -> Width {
    match std::env::var("DOUBLET_BENCH_LANES").as_deref() {
        Ok("2") => Width::Two,
        Ok("4") => Width::Four,
        _ => Width::Eight,
    }
}

fn paths(
    width: Width,
    flight: &[FilterData],
    settings: &FilterSettings,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let valid = settings.check().expect("settings of the bench are valid");
    let windows: Vec<&FilterData> = flight.iter().collect();
    reconstruct_with(width, &windows, &valid, &mut |_| ControlFlow::Continue(()))
}

fn run_production(flight: &[FilterData], settings: &FilterSettings) -> usize {
    run_width(width(), flight, settings)
}

fn run_width(width: Width, flight: &[FilterData], settings: &FilterSettings) -> usize {
    let results = paths(width, flight, settings);
    results.iter().map(|result| result.as_ref().map_or(0, |result| result.time_s.len())).sum()
}

/// Time of the quickest of `runs` runs, s: what else the machine does only adds.
fn quickest(runs: usize, mut run: impl FnMut()) -> f64 {
    let timed = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..runs).map(timed).fold(f64::INFINITY, f64::min)
}

/// Ratios within one run, which is what the times of a shared machine are good for.
fn compare() {
    let flight_data = flight(SAMPLES);
    let steps = (MANOEUVRES * (SAMPLES - 1)) as f64;
    let per_step = |time: f64| time / steps * 1e6;
    let widest = width().lanes().min(lanes());
    let widths: Vec<Width> =
        [Width::Eight, Width::Four, Width::Two].into_iter().filter(|width| width.lanes() <= widest).collect();
    println!("{MANOEUVRES} manoeuvres of {} steps; times faster than the dense filter", SAMPLES - 1);
    // From its largest results on, the allocator keeps memory for the next: every row finds it so.
    divan::black_box(run_width(width(), &flight_data, &FilterSettings { smooth: true, ..settings(iekf()) }));
    for (name, method) in [("ekf", Method::Ekf), ("iekf", iekf())] {
        let settings = settings(method);
        let smoothing = FilterSettings { smooth: true, ..settings.clone() };
        let filter = dense_filter(&settings);
        let plain = quickest(3, || {
            for data in &flight_data {
                divan::black_box(run_dense(&filter, data, &settings));
            }
        });
        println!("{name}: dense {:.2} us/step", per_step(plain));
        for &width in &widths {
            let side_by_side = quickest(9, || {
                divan::black_box(run_width(width, &flight_data, &settings));
            });
            let one_by_one = quickest(5, || {
                for data in &flight_data {
                    divan::black_box(run_width(width, std::slice::from_ref(data), &settings));
                }
            });
            let smoothed = quickest(5, || {
                divan::black_box(run_width(width, &flight_data, &smoothing));
            });
            println!(
                "{name}, {} lanes: side by side {:.3} us/step, {:.1} times; one by one {:.3} us/step, {:.1} times; and smoother {:.3} us/step, {:.1} times",
                width.lanes(),
                per_step(side_by_side),
                plain / side_by_side,
                per_step(one_by_one),
                plain / one_by_one,
                per_step(smoothed),
                plain / smoothed
            );
        }
    }
    linearity();
}

/// Time per sample of a tenth of a manoeuvre, of a manoeuvre and of 10 and 100 times its samples, as ratios, eight side by side:
/// they are timed in turn, so that what else the machine does falls on all of them. Results are kept, as a user of them does: memory
/// that is used again costs less than memory that is new, and only short windows would get it.
fn linearity() {
    let settings = settings(iekf());
    let flights = [251, 2_501, 25_001, 250_001]
        .map(|samples| (0..8).map(|seed| manoeuvre(seed, samples, &settings)).collect::<Vec<FilterData>>());
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..5 {
        for ((flight, times), runs) in flights.iter().zip(&mut times).zip([1000, 100, 10, 1]) {
            let start = Instant::now();
            let kept: Vec<_> = (0..runs).map(|_| paths(width(), flight, &settings)).collect();
            times.push(start.elapsed().as_secs_f64());
            divan::black_box(kept);
        }
    }
    let [tenth, one, ten, hundred] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    println!(
        "time per sample: 1 at 2,500 steps, {:.3} at 25,000, {:.3} at 250,000; {:.3} at 250",
        ten / one,
        hundred / one,
        tenth / one
    );
}

fn main() {
    // a bench asked for by name runs alone
    if !std::env::args().any(|argument| argument.contains("samples")) {
        compare();
    }
    divan::main();
}

#[divan::bench(sample_count = 9)]
fn ekf_18states_57500samples(bencher: divan::Bencher) {
    let flight = flight(SAMPLES);
    bencher.bench(|| run_production(&flight, &settings(Method::Ekf)));
}

#[divan::bench(sample_count = 9)]
fn iekf_18states_57500samples(bencher: divan::Bencher) {
    let flight = flight(SAMPLES);
    bencher.bench(|| run_production(&flight, &settings(iekf())));
}

#[divan::bench(sample_count = 9)]
fn iekf_and_smoother_18states_57500samples(bencher: divan::Bencher) {
    let flight = flight(SAMPLES);
    let settings = FilterSettings { smooth: true, ..settings(iekf()) };
    bencher.bench(|| run_production(&flight, &settings));
}

#[divan::bench(sample_count = 3)]
fn iekf_dense_18states_57500samples(bencher: divan::Bencher) {
    let flight = flight(SAMPLES);
    let settings = settings(iekf());
    let filter = dense_filter(&settings);
    bencher.bench(|| flight.iter().map(|data| run_dense(&filter, data, &settings).len()).sum::<usize>());
}
