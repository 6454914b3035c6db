//! Equations of motion as they are written: an unstable short period, three degrees of freedom with gravity, gusts, what is refused.

use std::sync::Arc;

use doublet_core::estimate::{
    EquationFault, EquationFit, EquationFunction, EquationModel, EquationNames, EquationPoints, EquationRecord,
    EquationSettings, EquationText, equation_error_of, filter_error_of, output_error_of,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const STEP_S: f64 = 0.02;

/// Derivatives of an unstable short period: its roots are 0.69315, which doubles in a second, and -2.69.
const UNSTABLE: [(&str, f64); 5] =
    [("Z_alpha", -0.9), ("Z_delta_e", -0.1), ("M_alpha", 2.856_747), ("M_q", -1.1), ("M_delta_e", -6.0)];

fn pairs(rows: &[(&str, &str)]) -> Vec<(String, String)> {
    rows.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

/// The short period with a free constant in each equation.
fn short_period() -> EquationModel {
    let starts = UNSTABLE.iter().map(|(name, _)| ((*name).to_owned(), 0.0));
    EquationModel::new(&EquationText {
        states: pairs(&[
            ("alpha", "Z_0 + Z_alpha*alpha + q + Z_delta_e*delta_e"),
            ("q", "M_0 + M_alpha*alpha + M_q*q + M_delta_e*delta_e"),
        ]),
        outputs: pairs(&[("alpha", "alpha"), ("q", "q")]),
        inputs: vec!["delta_e".to_owned()],
        parameters: starts.chain([("Z_0".to_owned(), 0.0), ("M_0".to_owned(), 0.0)]).collect(),
        constants: Vec::new(),
    })
    .unwrap()
}

fn normal(rng: &mut rand_chacha::ChaCha8Rng) -> f64 {
    Distribution::<f64>::sample(&StandardNormal, rng)
}

/// `seconds` of the unstable aircraft under a pilot who holds it by alpha and rate and moves the stick as he likes; noise on alpha and
/// q.
fn unstable(seed: u64, seconds: usize, noise: [f64; 2]) -> EquationRecord {
    let [z_a, z_d, m_a, m_q, m_d] = UNSTABLE.map(|(_, value)| value);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let samples = seconds * 50;
    let mut x = [0.0_f64, 0.0];
    let (mut alpha, mut q, mut elevator, mut time_s) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut held = 0.0;
    for k in 0..samples {
        let t = STEP_S * k as f64;
        // Stick: a 3-2-1-1 every six seconds; the actuator follows in 50 ms, so that the deflection is smooth from sample to sample.
        let phase = t % 6.0;
        let stick = match phase {
            p if (0.5..1.4).contains(&p) || (2.0..2.3).contains(&p) => 0.02,
            p if (1.4..2.0).contains(&p) || (2.3..2.6).contains(&p) => -0.02,
            _ => 0.0,
        };
        let wanted = 0.9 * x[0] + 0.6 * x[1] + stick;
        let before = held;
        held += (1.0 - (-STEP_S / 0.05_f64).exp()) * (wanted - held);
        time_s.push(t);
        alpha.push(x[0] + noise[0] * normal(&mut rng));
        q.push(x[1] + noise[1] * normal(&mut rng));
        elevator.push(before);
        let rate = |x: [f64; 2], d: f64| [z_a * x[0] + x[1] + z_d * d, m_a * x[0] + m_q * x[1] + m_d * d];
        let along = |slope: [f64; 2], h: f64| [x[0] + h * slope[0], x[1] + h * slope[1]];
        let middle = 0.5 * (before + held);
        let k1 = rate(x, before);
        let k2 = rate(along(k1, 0.5 * STEP_S), middle);
        let k3 = rate(along(k2, 0.5 * STEP_S), middle);
        let k4 = rate(along(k3, STEP_S), held);
        x = [0, 1].map(|i| x[i] + STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    EquationRecord { label: "w".to_owned(), time_s, inputs: vec![elevator], outputs: vec![alpha, q] }
}

/// Distances from the truth in corrected errors.
fn distances(found: &EquationFit) -> Vec<f64> {
    let off = |(k, (name, value)): (usize, &(&str, f64))| {
        assert_eq!(found.fit.names[k], *name);
        (found.fit.estimates[k] - value) / found.corrected_errors[k]
    };
    UNSTABLE.iter().enumerate().map(off).collect()
}

#[test]
fn unstable_short_period_is_found_by_equation_error_and_output_error() {
    let truth = UNSTABLE.map(|(_, value)| value);
    let half = 0.5 * (truth[0] + truth[3]);
    let root = half + (half * half - truth[0] * truth[3] + truth[2]).sqrt();
    assert!((std::f64::consts::LN_2 / root - 1.0).abs() < 1e-4, "time to double {}", std::f64::consts::LN_2 / root);
    let record = unstable(4, 18, [1e-3, 2e-3]);
    let model = short_period();
    let settings = EquationSettings { piece_s: Some(3.0), ..EquationSettings::default() };
    let equation = equation_error_of(&model, std::slice::from_ref(&record), &settings).unwrap();
    let output =
        output_error_of(&model, std::slice::from_ref(&record), &settings, Some(&equation.fit.estimates)).unwrap();
    for (method, found) in [("equation error", &equation), ("output error", &output)] {
        for (k, off) in distances(found).into_iter().enumerate() {
            let (name, value) = UNSTABLE[k];
            println!(
                "{method} {name}: {value} found {:.4} +- {:.4} ({off:.2})",
                found.fit.estimates[k], found.corrected_errors[k]
            );
            assert!(off.abs() < 2.0, "{method}: {name} {off}");
            assert!(found.corrected_errors[k] < 0.15 * value.abs().max(0.5), "{method}: {name}");
        }
    }
    // Six pieces with two initial states each, and residuals that are the noise.
    assert_eq!(output.fit.names.len(), 7 + 12);
    for (noise, truth) in output.fit.noise.iter().zip([1e-3, 2e-3]) {
        assert!((noise / truth - 1.0).abs() < 0.06, "{noise}");
    }
    assert!(output.corrected_errors[2] < equation.corrected_errors[2] * 1.5);
}

#[test]
fn intervals_of_the_unstable_aircraft_hold_the_truth() {
    let model = short_period();
    let settings = EquationSettings { piece_s: Some(3.0), ..EquationSettings::default() };
    let (mut within, mut count) = ([0.0; 2], 0.0);
    for seed in 100..120 {
        let record = unstable(seed, 18, [1e-3, 2e-3]);
        let equation = equation_error_of(&model, std::slice::from_ref(&record), &settings).unwrap();
        let output =
            output_error_of(&model, std::slice::from_ref(&record), &settings, Some(&equation.fit.estimates)).unwrap();
        for (share, found) in within.iter_mut().zip([&equation, &output]) {
            *share += distances(found).iter().filter(|off| off.abs() < 2.0).count() as f64;
        }
        count += UNSTABLE.len() as f64;
    }
    let [equation, output] = within.map(|within| within / count);
    println!("within two corrected errors: equation error {equation:.3}, output error {output:.3} of {count}");
    assert!(output > 0.90 && equation > 0.85, "{equation}, {output}");
}

#[test]
fn one_piece_of_a_stable_motion_is_the_classical_output_error() {
    let text = EquationText {
        states: pairs(&[("x", "a*x + b*u")]),
        outputs: pairs(&[("x", "x"), ("twice", "2*x + bias")]),
        inputs: vec!["u".to_owned()],
        parameters: vec![("a".to_owned(), -0.3), ("b".to_owned(), 0.5), ("bias".to_owned(), 0.0)],
        constants: Vec::new(),
    };
    let time_s: Vec<f64> = (0..400).map(|k| 0.05 * f64::from(k)).collect();
    let u: Vec<f64> = time_s.iter().map(|t| (0.7 * t).sin()).collect();
    // The exact answer of x' = -0.8 x + 1.5 sin(0.7 t), x(0) = 1.
    let (p, w) = (0.8_f64, 0.7_f64);
    let particular = |t: f64| 1.5 / (p * p + w * w) * (p * (w * t).sin() - w * (w * t).cos());
    let x: Vec<f64> = time_s.iter().map(|&t| particular(t) + (1.0 - particular(0.0)) * (-p * t).exp()).collect();
    let twice = x.iter().map(|x| 2.0 * x + 0.25).collect();
    let record = EquationRecord { label: "w".to_owned(), time_s, inputs: vec![u], outputs: vec![x, twice] };
    let model = EquationModel::new(&text).unwrap();
    let found = output_error_of(&model, &[record], &EquationSettings::default(), None).unwrap();
    // The input between samples is a straight line, the true one is not: 0.05 s of it is 1.5e-4 of its amplitude off.
    for (value, truth) in found.fit.estimates.iter().zip([-0.8, 1.5, 0.25, 1.0]) {
        assert!((value - truth).abs() < 1e-3, "{:?}", found.fit.estimates);
    }
}

#[test]
fn three_degrees_with_gravity_need_no_lateral_channel() {
    // V' and theta in: weight, drag and lift over mass as polynomials; the truth flies the same equations in this test.
    let text = EquationText {
        states: pairs(&[
            ("V", "-g*sin(theta - alpha) - D_0 - D_alpha*alpha"),
            ("alpha", "q + (g*cos(theta - alpha) - L_0 - L_alpha*alpha)/V"),
            ("q", "M_0 + M_alpha*alpha + M_q*q + M_delta_e*delta_e"),
            ("theta", "q"),
        ]),
        outputs: pairs(&[
            ("V", "V"),
            ("alpha", "alpha"),
            ("q", "q"),
            ("theta", "theta"),
            ("az", "-(L_0 + L_alpha*alpha)"),
        ]),
        inputs: vec!["delta_e".to_owned()],
        parameters: ["D_0", "D_alpha", "L_0", "L_alpha", "M_0", "M_alpha", "M_q", "M_delta_e"]
            .map(|name| (name.to_owned(), 0.0))
            .to_vec(),
        constants: vec![("g".to_owned(), 9.80665)],
    };
    let truth = [0.2, 3.0, 2.0, 90.0, 0.3, -5.0, -2.0, -7.0];
    let model = EquationModel::new(&text).unwrap();
    let samples = 1000;
    let time_s: Vec<f64> = (0..samples).map(|k| STEP_S * f64::from(k)).collect();
    let elevator: Vec<f64> = time_s.iter().map(|t| -0.019 + 0.02 * (1.7 * t).sin() * (0.31 * t).cos()).collect();
    let rate = |x: [f64; 4], d: f64| {
        let [v, a, q, th] = x;
        let [d0, da, l0, la, m0, ma, mq, md] = truth;
        let g = 9.80665;
        [
            -g * (th - a).sin() - d0 - da * a,
            q + (g * (th - a).cos() - l0 - la * a) / v,
            m0 + ma * a + mq * q + md * d,
            q,
        ]
    };
    let mut x = [50.0, 0.0867, 0.0, 0.0867];
    let mut columns = vec![Vec::new(); 5];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(9);
    for k in 0..samples as usize {
        let shown = [x[0], x[1], x[2], x[3], -(truth[2] + truth[3] * x[1])];
        for ((column, value), noise) in columns.iter_mut().zip(shown).zip([0.05, 5e-4, 1e-3, 5e-4, 0.05]) {
            column.push(value + noise * normal(&mut rng));
        }
        let (now, next) = (elevator[k], elevator[(k + 1).min(samples as usize - 1)]);
        let along = |slope: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * slope[i]);
        let k1 = rate(x, now);
        let k2 = rate(along(k1, 0.5 * STEP_S), 0.5 * (now + next));
        let k3 = rate(along(k2, 0.5 * STEP_S), 0.5 * (now + next));
        let k4 = rate(along(k3, STEP_S), next);
        x = std::array::from_fn(|i| x[i] + STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let record = EquationRecord { label: "w".to_owned(), time_s, inputs: vec![elevator], outputs: columns };
    let settings = EquationSettings::default();
    let equation = equation_error_of(&model, std::slice::from_ref(&record), &settings).unwrap();
    let output = output_error_of(&model, &[record], &settings, Some(&equation.fit.estimates)).unwrap();
    for (k, truth) in truth.into_iter().enumerate() {
        let (value, error) = (output.fit.estimates[k], output.corrected_errors[k]);
        println!("{}: {truth} found {value:.5} +- {error:.5}", output.fit.names[k]);
        assert!(((value - truth) / error).abs() < 3.0, "{}: {value} +- {error}", output.fit.names[k]);
    }
}

#[test]
fn equations_that_are_wrong_say_what() {
    let fault = |change: &dyn Fn(&mut EquationText)| {
        let mut text = EquationText {
            states: pairs(&[("q", "M_q*q + M_delta_e*delta_e")]),
            outputs: pairs(&[("q", "q")]),
            inputs: vec!["delta_e".to_owned()],
            parameters: vec![("M_q".to_owned(), -1.0), ("M_delta_e".to_owned(), -5.0)],
            constants: Vec::new(),
        };
        change(&mut text);
        EquationModel::new(&text).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(fault(&|text| text.states.clear()), "the equations have no state: state at least one");
    let message = fault(&|text| text.states[0].1 = "M_q*qq".to_owned());
    assert!(message.starts_with("state 'q': at character 5: no state, input or parameter is called 'qq'"), "{message}");
    let message = fault(&|text| text.inputs.push("q".to_owned()));
    assert_eq!(message, "'q' is both a state and an input: give one of them another name");
    let model = EquationModel::new(&EquationText {
        states: pairs(&[("q", "M_q*q")]),
        outputs: pairs(&[("rate", "2*q")]),
        parameters: vec![("M_q".to_owned(), -1.0)],
        ..EquationText::default()
    })
    .unwrap();
    let time_s: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
    let outputs = vec![time_s.iter().map(|t| 2.0 * (-t).exp()).collect()];
    let record = EquationRecord { label: "w".to_owned(), time_s, inputs: Vec::new(), outputs };
    let error = equation_error_of(&model, &[record], &EquationSettings::default()).unwrap_err();
    assert!(matches!(error, EquationFault::NotMeasured { .. }), "{error}");
}

/// Derivatives of a Dutch roll and roll mode at 60 m/s: roots -0.42 +- 2.0i, -5.1 and 0.0.
const LATERAL: [(&str, f64); 10] = [
    ("Y_beta", -0.25),
    ("Y_delta_r", 0.05),
    ("L_beta", -12.0),
    ("L_p", -5.0),
    ("L_r", 1.2),
    ("L_delta_a", -22.0),
    ("N_beta", 4.0),
    ("N_p", -0.3),
    ("N_r", -0.7),
    ("N_delta_r", -3.0),
];
/// Speed, m/s, and gravity over it, 1/s.
const SPEED: f64 = 60.0;
const GRAVITY_PART: f64 = 9.81 / SPEED;

/// Gust of the test, m/s rms, and the time its length takes, s (MIL-F-8785C: 530 m).
const GUST_M_S: f64 = 1.5;
const GUST_TIME_S: f64 = 530.0 / SPEED;

fn lateral() -> EquationModel {
    EquationModel::new(&EquationText {
        states: pairs(&[
            ("beta", "Y_0 + Y_beta*beta - r + g*sin(phi) + Y_delta_r*delta_r"),
            ("p", "L_0 + L_beta*beta + L_p*p + L_r*r + L_delta_a*delta_a"),
            ("r", "N_0 + N_beta*beta + N_p*p + N_r*r + N_delta_r*delta_r"),
            ("phi", "p"),
        ]),
        outputs: pairs(&[("beta", "beta"), ("p", "p"), ("r", "r"), ("phi", "phi")]),
        inputs: vec!["delta_a".to_owned(), "delta_r".to_owned()],
        parameters: LATERAL
            .iter()
            .map(|(name, _)| ((*name).to_owned(), 0.0))
            .chain(["Y_0", "L_0", "N_0"].map(|name| (name.to_owned(), 0.0)))
            .collect(),
        constants: vec![("g".to_owned(), GRAVITY_PART)],
    })
    .unwrap()
}

/// Standard deviations of the measurement noise of beta, p, r and phi.
const LATERAL_NOISE: [f64; 4] = [2e-3, 2e-3, 1e-3, 2e-3];

/// Half a minute of rudder doublets and aileron steps in a lateral Dryden gust (forming filter
/// `sqrt(3) tau s + 1 over (tau s + 1)^2`) of `gust_m_s` rms; beta against the air. Integrated in steps of a millisecond.
fn gusty(seed: u64, gust_m_s: f64) -> EquationRecord {
    const FINE: usize = 20;
    let [y_b, y_d, l_b, l_p, l_r, l_d, n_b, n_p, n_r, n_d] = LATERAL.map(|(_, value)| value);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let tau = GUST_TIME_S;
    let h = STEP_S / FINE as f64;
    // Standard deviation of samples of white noise whose filtered variance is that of the gust.
    let intensity = gust_m_s / SPEED * (tau / h).sqrt();
    let mut filter = [0.0_f64; 2];
    let gust = |filter: [f64; 2]| filter[0] + 3.0_f64.sqrt() * tau * filter[1];
    let mut x = [0.0_f64; 4];
    let (mut time_s, mut inputs, mut outputs) = (Vec::new(), vec![Vec::new(); 2], vec![Vec::new(); 4]);
    // By whole samples: a step lies at one sample, whatever is rounded.
    let input = |k: usize| {
        let doublet = |from: usize, half: usize, size: f64| match (k % 500).checked_sub(from) {
            Some(k) if k < half => size,
            Some(k) if k < 2 * half => -size,
            _ => 0.0,
        };
        [doublet(250, 30, 0.05), doublet(25, 40, 0.06)]
    };
    // From some minutes of gusts on.
    for _ in 0..100_000 {
        let white = intensity * normal(&mut rng);
        let rate = [filter[1], (white - filter[0] - 2.0 * tau * filter[1]) / (tau * tau)];
        filter = [0, 1].map(|i| filter[i] + h * rate[i]);
    }
    for k in 0..1500 {
        time_s.push(STEP_S * k as f64);
        inputs.iter_mut().zip(input(k)).for_each(|(column, value)| column.push(value));
        let air = [x[0] + gust(filter), x[1], x[2], x[3]];
        for (column, (value, noise)) in outputs.iter_mut().zip(air.iter().zip(LATERAL_NOISE)) {
            column.push(value + noise * normal(&mut rng));
        }
        let [from, to] = [input(k), input(k + 1)];
        for fine in 0..FINE {
            let part = (fine as f64 + 0.5) / FINE as f64;
            let [d_a, d_r] = [0, 1].map(|i| from[i] + part * (to[i] - from[i]));
            let white = intensity * normal(&mut rng);
            let slope = |x: [f64; 4]| {
                let beta = x[0] + gust(filter);
                [
                    y_b * beta - x[2] + GRAVITY_PART * x[3].sin() + y_d * d_r,
                    l_b * beta + l_p * x[1] + l_r * x[2] + l_d * d_a,
                    n_b * beta + n_p * x[1] + n_r * x[2] + n_d * d_r,
                    x[1],
                ]
            };
            let first = slope(x);
            let second = slope([0, 1, 2, 3].map(|i| x[i] + 0.5 * h * first[i]));
            x = [0, 1, 2, 3].map(|i| x[i] + h * second[i]);
            let rate = [filter[1], (white - filter[0] - 2.0 * tau * filter[1]) / (tau * tau)];
            filter = [0, 1].map(|i| filter[i] + h * rate[i]);
        }
    }
    EquationRecord { label: "w".to_owned(), time_s, inputs, outputs }
}

/// Distances from the truth of the lateral derivatives, in corrected errors.
fn lateral_distances(found: &EquationFit) -> Vec<f64> {
    let off = |(k, (_, value)): (usize, &(&str, f64))| (found.fit.estimates[k] - value) / found.corrected_errors[k];
    LATERAL.iter().enumerate().map(off).collect()
}

#[test]
fn filter_error_finds_the_lateral_derivatives_in_gusts_that_output_error_misses() {
    let model = lateral();
    let settings = EquationSettings::default();
    let (mut held, mut missed, mut squares, mut count) = ([0.0; 2], 0, [0.0; 2], 0.0);
    for seed in 0..6 {
        let record = gusty(seed, GUST_M_S);
        let records = std::slice::from_ref(&record);
        let start = equation_error_of(&model, records, &settings).unwrap();
        let output = output_error_of(&model, records, &settings, Some(&start.fit.estimates)).unwrap();
        let filter = filter_error_of(&model, records, &settings, Some(&start.fit.estimates)).unwrap();
        for (method, fit) in [&output, &filter.estimate].into_iter().enumerate() {
            let off = lateral_distances(fit);
            held[method] += off.iter().filter(|off| off.abs() < 2.0).count() as f64;
            // The moments: in a gust the side force hardly moves beta.
            squares[method] +=
                (2..LATERAL.len()).map(|k| ((fit.fit.estimates[k] - LATERAL[k].1) / LATERAL[k].1).powi(2)).sum::<f64>();
        }
        // By the errors of white residuals, which is what output error assumes.
        let off = |k: usize| (output.fit.estimates[k] - LATERAL[k].1) / output.fit.standard_errors[k];
        missed += (0..LATERAL.len()).filter(|k| off(*k).abs() > 2.0).count();
        count += LATERAL.len() as f64;
        // The gust alone drives beta: high above its corner its slope is white of this intensity.
        let expected = GUST_M_S / SPEED * (3.0 / GUST_TIME_S).sqrt();
        for (state, noise) in filter.process_noise.iter().enumerate() {
            let off = (noise.intensity / expected).ln() / noise.log_error;
            assert!(if state == 0 { off.abs() < 3.0 } else { noise.is_none || off < -3.0 }, "{noise:?}");
        }
    }
    let [of_output, of_filter] = held.map(|held| held / count);
    let relative = squares.map(|squares| (squares / (0.8 * count)).sqrt());
    println!(
        "output error misses {missed}; within two corrected errors: output error {of_output:.3}, filter error {of_filter:.3}; rms relative error of the moment derivatives {relative:?}"
    );
    assert!(missed > 30, "output error misses {missed} of {count} by more than two of its errors");
    assert!(of_filter > 0.9, "{of_filter}");
    assert!(relative[1] < 0.1 * relative[0], "{relative:?}");
}

#[test]
fn filter_error_without_process_noise_is_output_error() {
    let record = gusty(3, 0.0);
    let records = std::slice::from_ref(&record);
    let (model, settings) = (lateral(), EquationSettings::default());
    let start = equation_error_of(&model, records, &settings).unwrap().fit.estimates;
    let output = output_error_of(&model, records, &settings, Some(&start)).unwrap();
    let filter = filter_error_of(&model, records, &settings, Some(&start)).unwrap();
    assert!(filter.process_noise.iter().all(|noise| noise.is_none), "{:?}", filter.process_noise);
    for (k, (name, value)) in LATERAL.iter().enumerate() {
        let apart = filter.estimate.fit.estimates[k] - output.fit.estimates[k];
        assert!(apart.abs() < output.corrected_errors[k], "{name} {value}: {apart}");
    }
    for (found, truth) in filter.measurement_noise.iter().zip(LATERAL_NOISE) {
        assert!((found / truth - 1.0).abs() < 0.06, "{found} {truth}");
    }
}

/// The equations of [`short_period`] as a function, in the order of the operations of its expressions.
#[derive(Debug)]
struct ShortPeriod;

impl EquationFunction for ShortPeriod {
    fn rates(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        let of = |column: &[f64], point: usize| column[if column.len() == 1 { 0 } else { point }];
        let rate = |point: usize| {
            let [alpha, q, d] = [points.states[0], points.states[1], points.inputs[0]].map(|column| of(column, point));
            let p: Vec<f64> = points.parameters.iter().map(|column| of(column, point)).collect();
            [p[5] + p[0] * alpha + q + p[1] * d, p[6] + p[2] * alpha + p[3] * q + p[4] * d]
        };
        (0..2).map(|state| (0..points.count).map(|point| rate(point)[state]).collect()).collect()
    }

    fn shown(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        vec![vec![f64::NAN; points.count]]
    }
}

#[test]
fn function_gives_what_its_expressions_give_to_the_last_bit() {
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let free = names(&["Z_alpha", "Z_delta_e", "M_alpha", "M_q", "M_delta_e", "Z_0", "M_0"]);
    let of_function = EquationModel::with_function(
        EquationNames {
            states: names(&["alpha", "q"]),
            outputs: names(&["alpha", "q"]),
            inputs: names(&["delta_e"]),
            parameters: free.into_iter().map(|name| (name, 0.0)).collect(),
        },
        Arc::new(ShortPeriod),
    )
    .unwrap();
    let model = short_period();
    // Records and pieces of several lengths, and a sample that was not measured.
    let mut records = vec![unstable(4, 18, [1e-3, 2e-3]), unstable(5, 7, [1e-3, 2e-3])];
    records[1].outputs[0][40] = f64::NAN;
    let settings = EquationSettings { piece_s: Some(3.0), ..EquationSettings::default() };
    let expected = output_error_of(&model, &records, &settings, None).unwrap();
    let found = output_error_of(&of_function, &records, &settings, None).unwrap();
    assert_eq!(found.fit.estimates, expected.fit.estimates);
    assert_eq!(found.corrected_errors, expected.corrected_errors);
    let expected = equation_error_of(&model, &records[..1], &settings).unwrap().fit;
    let found = equation_error_of(&of_function, &records[..1], &settings).unwrap().fit;
    assert_eq!(found.estimates, expected.estimates);
    let start = Some(expected.estimates.as_slice());
    let expected = filter_error_of(&model, &records, &settings, start).unwrap();
    let found = filter_error_of(&of_function, &records, &settings, start).unwrap();
    assert_eq!(found.estimate.fit.estimates, expected.estimate.fit.estimates);
}

#[test]
fn names_of_a_function_are_checked() {
    let names = EquationNames { states: vec!["q".to_owned()], ..EquationNames::default() };
    let fault = EquationModel::with_function(names.clone(), Arc::new(ShortPeriod)).unwrap_err();
    assert_eq!(fault, EquationFault::Without { what: "output" });
    let names = EquationNames { outputs: vec!["q".to_owned()], inputs: vec!["q".to_owned()], ..names };
    let fault = EquationModel::with_function(names, Arc::new(ShortPeriod)).unwrap_err();
    assert_eq!(fault.to_string(), "'q' is both a state and an input: give one of them another name");
}
