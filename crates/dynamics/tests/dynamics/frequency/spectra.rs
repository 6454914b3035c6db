//! Responses, coherences and random errors over many seeds, against exact ones.

use std::f64::consts::{PI, TAU};

use doublet_dynamics::frequency::{
    BodeCurve, FrequencyError, FrequencyRecord, FrequencyResponse, SpectralSettings, responses,
};
use doublet_dynamics::qualities::{Measure, Measures, PilotTask};
use nalgebra::Complex;

use super::signals::{Circular, moments, normal, seeded, sum, sweep};

const RUNS: u64 = 400;

fn settings(hz: &[f64], windows_s: &[f64], overlap: f64) -> SpectralSettings {
    SpectralSettings {
        omega_rad_s: hz.iter().map(|hz| TAU * hz).collect(),
        windows_s: windows_s.to_vec(),
        overlap,
        for_fit: false,
    }
}

/// `1.5 16 e^(-0.15 s) / (s^2 + 2.8 s + 16)`.
fn second_order(s: Complex<f64>) -> Complex<f64> {
    (s * -0.15).exp() * 24.0 / (s * s + s * 2.8 + 16.0)
}

const HZ: [f64; 9] = [0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0];

fn second_order_runs(overlap: f64) -> Vec<FrequencyResponse> {
    let circular = Circular::REFERENCE;
    let run = |seed: u64| {
        let mut rng = seeded(seed);
        let input = circular.noise(1.0, &mut rng);
        let output = sum(&[&circular.through(&input, second_order), &circular.noise(0.3, &mut rng)]);
        let record = FrequencyRecord {
            step_s: 1.0 / circular.rate_hz,
            inputs: vec![circular.samples_of(&input)],
            output: circular.samples_of(&output),
        };
        responses(&[record], &settings(&HZ, &[30.0], overlap)).unwrap().remove(0)
    };
    (0..RUNS).map(run).collect()
}

/// Mean relative error of gain, mean error of phase (rad), scatter of both over the error bar, mean coherence and error bar.
fn compare(runs: &[&FrequencyResponse], m: usize, exact: Complex<f64>) -> ([f64; 4], f64, f64) {
    let relative: Vec<Complex<f64>> = runs.iter().map(|run| (run.points[m].response / exact).ln()).collect();
    let bars: Vec<f64> = runs.iter().map(|run| run.points[m].relative_sd).filter(|sd| sd.is_finite()).collect();
    let coherence: Vec<f64> = runs.iter().map(|run| run.points[m].coherence).collect();
    let gains: Vec<f64> = runs.iter().map(|run| run.points[m].response.norm() / exact.norm() - 1.0).collect();
    let (gain, _) = moments(&gains);
    let (_, gain_sd) = moments(&relative.iter().map(|value| value.re).collect::<Vec<_>>());
    let (phase, phase_sd) = moments(&relative.iter().map(|value| value.im).collect::<Vec<_>>());
    let bar = moments(&bars).0;
    ([gain, phase, gain_sd / bar, phase_sd / bar], moments(&coherence).0, bar)
}

#[test]
fn gain_phase_and_coherence_of_a_second_order_system_scatter_as_their_error_bars_say() {
    // Hann windows of 30 s in 600 s: 20 side by side, 39 with half overlap, whose transforms correlate by 1/6.
    for (overlap, averages, constant) in [(0.0, 20.0, 1.0), (0.5, 39.0 / (1.0 + 2.0 / 36.0 * 38.0 / 39.0), 0.735)] {
        let runs = second_order_runs(overlap);
        let all: Vec<&FrequencyResponse> = runs.iter().collect();
        approx::assert_relative_eq!(runs[0].overlap_constants[0], constant, max_relative = 2e-3);
        for (m, hz) in HZ.iter().enumerate() {
            let exact = second_order(Complex::new(0.0, TAU * hz));
            let truth = exact.norm_sqr() / (exact.norm_sqr() + 0.3);
            let ([gain, phase, gain_ratio, phase_ratio], coherence, bar) = compare(&all, m, exact);
            let formula = ((1.0 - truth) / (2.0 * averages * truth)).sqrt();
            println!(
                "{overlap} {hz} Hz: gain {gain:.4} phase {phase:.4} ratios {gain_ratio:.3} {phase_ratio:.3} coherence {coherence:.4} {truth:.4} bar {bar:.4} {formula:.4}"
            );
            if *hz <= 1.0 {
                assert!(gain.abs() < 0.015 && phase.abs() < 1f64.to_radians(), "{hz} Hz: {gain} {phase}");
                assert!((coherence - truth).abs() < 0.02, "{hz} Hz: {coherence} {truth}");
                for ratio in [gain_ratio, phase_ratio] {
                    assert!((0.85..1.2).contains(&ratio), "overlap {overlap}, {hz} Hz: {ratio}");
                }
                // Windows of 30 s lose a little coherence at the resonance, which the bars take for noise.
                approx::assert_relative_eq!(bar, formula, max_relative = 0.15);
            }
            let shown = all.iter().filter(|run| run.points[m].is_value()).count();
            if *hz >= 3.0 {
                assert!(coherence < 0.1 && shown < RUNS as usize / 20, "{hz} Hz: {coherence}, {shown} shown");
            } else if *hz <= 1.0 {
                assert_eq!(shown, RUNS as usize);
            }
        }
    }
}

/// Systems and coupling of two inputs: `y = H1 x1 + H2 x2 + n`, `x1 = u1`, `x2 = G u1 + u2`.
fn first(s: Complex<f64>) -> Complex<f64> {
    (s * -0.1).exp() * 5.0 / (s + 2.0)
}

fn second(s: Complex<f64>) -> Complex<f64> {
    (s * -0.05).exp() * (s + 0.5) * -3.0 / (s * s + s * 0.9 + 2.25)
}

fn coupling(s: Complex<f64>) -> Complex<f64> {
    Complex::new(0.8, 0.0) / (s * 0.5 + 1.0)
}

#[test]
fn responses_to_two_correlated_inputs_are_each_their_own() {
    let hz = [0.1, 0.2, 0.5, 0.8];
    let circular = Circular::REFERENCE;
    let (mut both, mut alone) = (Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let mut rng = seeded(seed);
        let u1 = circular.noise(1.0, &mut rng);
        let u2 = circular.noise(0.5, &mut rng);
        let noise = circular.noise(0.5, &mut rng);
        let x2 = sum(&[&circular.through(&u1, coupling), &u2]);
        let y = sum(&[&circular.through(&u1, first), &circular.through(&x2, second), &noise]);
        let inputs = vec![circular.samples_of(&u1), circular.samples_of(&x2)];
        let record = FrequencyRecord { step_s: 1.0 / circular.rate_hz, inputs, output: circular.samples_of(&y) };
        let settings = settings(&hz, &[30.0], 0.5);
        both.push(responses(std::slice::from_ref(&record), &settings).unwrap());
        let single = [0, 1].map(|input| {
            let record = FrequencyRecord { inputs: vec![record.inputs[input].clone()], ..record.clone() };
            responses(&[record], &settings).unwrap().remove(0)
        });
        alone.push(single);
    }
    for (m, hz) in hz.iter().enumerate() {
        let s = Complex::new(0.0, TAU * hz);
        let (h, g) = ([first(s), second(s)], coupling(s));
        let s22 = g.norm_sqr() + 0.5;
        let between = g.norm_sqr() / s22;
        let wrong = [h[0] + h[1] * g, h[1] + h[0] * g.conj() / s22];
        let output = (h[0] + h[1] * g).norm_sqr() + 0.5 * h[1].norm_sqr() + 0.5;
        let free = [h[0].norm_sqr() * (1.0 - between), 0.5 * h[1].norm_sqr()];
        for input in 0..2 {
            let runs: Vec<&FrequencyResponse> = both.iter().map(|run| &run[input]).collect();
            let ([gain, phase, gain_ratio, phase_ratio], coherence, _) = compare(&runs, m, h[input]);
            let multiple = moments(&runs.iter().map(|run| run.points[m].multiple_coherence).collect::<Vec<_>>()).0;
            let single: Vec<&FrequencyResponse> = alone.iter().map(|run| &run[input]).collect();
            let mean = single.iter().map(|run| run.points[m].response).sum::<Complex<f64>>() / single.len() as f64;
            println!(
                "{hz} Hz input {input}: gain {gain:.4} phase {phase:.4} ratios {gain_ratio:.3} {phase_ratio:.3} partial {coherence:.4} {:.4} \
                 multiple {multiple:.4} {:.4}; alone {mean:.4} {:.4}",
                free[input] / (free[input] + 0.5),
                1.0 - 0.5 / output,
                wrong[input]
            );
            if *hz == 0.2 {
                // The window is short against the resonance here; what one input alone shows is still far from the truth.
                let apart = 20.0 * (mean.norm() / h[0].norm()).log10();
                assert!(input == 1 || (apart < -10.0 && (mean / h[0]).arg().abs() > 1.2), "{apart}");
                continue;
            }
            assert!(gain.abs() < 0.02 && phase.abs() < 2f64.to_radians(), "{hz} Hz, {input}: {gain} {phase}");
            // The window loses coherence beside the resonance at 0.24 Hz.
            let lost = if *hz < 0.3 { 0.06 } else { 0.025 };
            assert!((coherence - free[input] / (free[input] + 0.5)).abs() < lost, "{hz} Hz, {input}: {coherence}");
            assert!((multiple - (1.0 - 0.5 / output)).abs() < lost, "{hz} Hz: {multiple}");
            for ratio in [gain_ratio, phase_ratio] {
                assert!((0.85..1.25).contains(&ratio), "{hz} Hz, {input}: {ratio}");
            }
            assert!((mean / wrong[input] - 1.0).norm() < 0.03, "{hz} Hz, {input}: {mean} {}", wrong[input]);
        }
    }
}

#[test]
fn windows_of_several_lengths_and_several_records_together_beat_each_alone() {
    // A lightly damped mode at 2 rad/s asks for long windows, noise at 8 rad/s for many.
    let system = |s: Complex<f64>| (s * s + s * 0.2 + 4.0).inv() * 4.0;
    let circular = Circular::REFERENCE;
    let omega = [2.0 / TAU, 8.0 / TAU];
    let error = |windows: &[f64]| {
        let mut squares = [0.0; 2];
        let mut expected = [0.0; 2];
        for seed in 0..60 {
            let mut rng = seeded(seed);
            let input = circular.noise(1.0, &mut rng);
            let output = sum(&[&circular.through(&input, system), &circular.noise(0.01, &mut rng)]);
            let whole = [circular.samples_of(&input), circular.samples_of(&output)];
            // Three manoeuvres of 200 s.
            let records: Vec<FrequencyRecord> = (0..3)
                .map(|k| FrequencyRecord {
                    step_s: 0.05,
                    inputs: vec![whole[0][4000 * k..4000 * (k + 1)].to_vec()],
                    output: whole[1][4000 * k..4000 * (k + 1)].to_vec(),
                })
                .collect();
            let found = responses(&records, &settings(&omega, windows, 0.5)).unwrap().remove(0);
            for (m, point) in found.points.iter().enumerate() {
                let exact = system(Complex::new(0.0, point.omega_rad_s));
                squares[m] += 0.5 * (point.response / exact - 1.0).norm_sqr() / 60.0;
                expected[m] += point.relative_sd.powi(2) / 60.0;
            }
        }
        (squares.map(f64::sqrt), expected.map(f64::sqrt))
    };
    let (long, short) = (error(&[80.0]).0, error(&[8.0]).0);
    let (composite, bars) = error(&[80.0, 40.0, 20.0, 8.0]);
    println!("long {long:?} short {short:?} composite {composite:?} bars {bars:?}");
    assert!(composite[0] < 0.5 * short[0] && composite[0] < 1.3 * long[0]);
    assert!(composite[1] < 0.8 * long[1] && composite[1] < 1.5 * short[1]);
    // The bars are random error: that a window smooths the resonance is not in them.
    for (m, most) in [(0, 2.2), (1, 1.6)] {
        assert!((0.7..most).contains(&(composite[m] / bars[m])), "{composite:?} {bars:?}");
    }
}

#[test]
fn unrelated_signals_and_a_single_window_have_no_value() {
    let mut rng = seeded(3);
    let mut noise = |count: usize| (0..count).map(|_| normal(&mut rng)).collect::<Vec<f64>>();
    let record = FrequencyRecord { step_s: 0.05, inputs: vec![noise(4000)], output: noise(4000) };
    let found = responses(std::slice::from_ref(&record), &settings(&HZ, &[20.0], 0.5)).unwrap().remove(0);
    assert!(found.points.iter().all(|point| !point.is_value() && point.coherence < 0.5), "{:?}", found.points);
    // One window explains any output.
    let single = responses(std::slice::from_ref(&record), &settings(&HZ, &[200.0], 0.5)).unwrap().remove(0);
    assert!(single.points.iter().all(|point| !point.is_value()));
    // The same input twice cannot be told apart.
    let twice = FrequencyRecord { inputs: vec![record.inputs[0].clone(); 2], ..record.clone() };
    let found = responses(&[twice], &settings(&HZ, &[20.0], 0.5)).unwrap();
    assert!(found.iter().flat_map(|response| &response.points).all(|point| !point.is_value()));
    let refused = responses(std::slice::from_ref(&record), &settings(&[0.01], &[20.0], 0.5)).unwrap_err();
    assert!(matches!(refused, FrequencyError::BandBelowWindows { .. }), "{refused}");
    let refused = responses(std::slice::from_ref(&record), &settings(&[11.0], &[20.0], 0.5)).unwrap_err();
    assert!(refused.to_string().contains("half the sampling frequency"), "{refused}");
    let refused = responses(&[record], &settings(&HZ, &[300.0], 0.5)).unwrap_err();
    assert!(matches!(refused, FrequencyError::WindowTooLong { .. }), "{refused}");
    assert_eq!(responses(&[], &settings(&HZ, &[20.0], 0.5)), Err(FrequencyError::NoRecord));
}

/// Curve of the points of a response that are values, less a phase, whole turns such that the first point lies nearest to zero.
fn curve_of(response: &FrequencyResponse, less_rad: f64) -> BodeCurve {
    let phases = response.phases_rad();
    let kept: Vec<_> = response.points.iter().zip(phases).filter(|(point, _)| point.is_value()).collect();
    let turn = TAU * ((kept[0].1 - less_rad) / TAU).round() + less_rad;
    BodeCurve {
        omega_rad_s: kept.iter().map(|(point, _)| point.omega_rad_s).collect(),
        gain_db: kept.iter().map(|(point, _)| point.gain_db()).collect(),
        phase_rad: kept.iter().map(|(_, phase)| phase - turn).collect(),
    }
}

#[test]
fn phase_of_a_swept_delay_runs_on_without_jumps() {
    // A delay of exactly 20 samples and minus one turn the phase by 3.8 rad and half a turn at 6 rad/s.
    let step_s = 1.0 / 32.0;
    let input: Vec<f64> = (0..3840).map(|k| sweep(step_s * f64::from(k))).collect();
    let mut output = vec![0.0; 20];
    output.extend(input.iter().take(3820).map(|value| -2.0 * value));
    let mut settings = settings(&[], &[30.0], 0.5);
    settings.omega_rad_s = (0..40).map(|k| 0.5 + 0.14 * f64::from(k)).collect();
    let record = FrequencyRecord { step_s, inputs: vec![input], output };
    let found = responses(&[record], &settings).unwrap().remove(0);
    let curve = curve_of(&found, PI);
    assert_eq!(curve.omega_rad_s.len(), 40);
    for ((omega, gain), phase) in curve.omega_rad_s.iter().zip(&curve.gain_db).zip(&curve.phase_rad) {
        assert!(
            (phase + 0.625 * omega).abs() < 0.1 && (gain - 20.0 * 2f64.log10()).abs() < 0.5,
            "{omega}: {gain} {phase}"
        );
    }
}

#[test]
fn pitch_measures_of_a_measured_response_match_those_of_the_system() {
    // The system of the equivalent fits, 600 s of random stick, output noise 5 % of the input's density.
    let system =
        |s: Complex<f64>| (s * -0.12).exp() * 1.972 * (s + 2.048) / (s * s + s * (2.0 * 0.607 * 2.922) + 2.922 * 2.922);
    let circular = Circular::REFERENCE;
    let mut rng = seeded(7);
    let input = circular.noise(1.0, &mut rng);
    let output = sum(&[&circular.through(&input, system), &circular.noise(0.0025, &mut rng)]);
    let record = FrequencyRecord {
        step_s: 1.0 / circular.rate_hz,
        inputs: vec![circular.samples_of(&input)],
        output: circular.samples_of(&output),
    };
    let hz: Vec<f64> = (0..60).map(|k| 0.04 * (80.0_f64).powf(f64::from(k) / 59.0)).collect();
    let measured = responses(&[record], &settings(&hz, &[30.0], 0.5)).unwrap().remove(0);
    let attitude = curve_of(&measured, 0.0).integrated();
    let mut measures = Measures::default();
    measures.add_pitch_attitude(&attitude, Some(&PilotTask { bandwidth_rad_s: 2.5, delay_s: 0.3, droop_db: -3.0 }));
    // Exact values as in the tests of the model. Tolerances: 2 % of the bandwidth, 5 ms and 5 % of the phase rate; as much in the loop.
    for (measure, exact, tolerance) in [
        (Measure::Bandwidth, 2.5939, 0.06),
        (Measure::PhaseDelay, 0.09768, 0.005),
        (Measure::AveragePhaseRate, 70.33, 3.6),
        (Measure::PilotCompensation, 42.465, 3.0),
        (Measure::ClosedLoopResonance, 0.735, 0.4),
    ] {
        let found = measures.get(measure).unwrap();
        println!("{}: {found} ({exact})", measure.text());
        assert!((found - exact).abs() < tolerance, "{}: {found} instead of {exact}", measure.text());
    }
}
