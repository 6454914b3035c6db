//! Output error on a short period whose answer is known.

use doublet_core::estimate::{EstimateError, OutputErrorSettings, OutputParameter, output_error};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Step, s, and samples.
const STEP_S: f64 = 0.02;
const SAMPLES: usize = 1000;
/// Truth: Z_alpha, M_alpha, M_q, M_delta.
const TRUTH: [f64; 4] = [-0.8, -4.5, -1.6, -6.0];
/// Standard deviations of alpha and q measurements.
const NOISE: [f64; 2] = [0.004, 0.01];

/// Elevator: a 3-2-1-1.
fn elevator(t: f64) -> f64 {
    match t {
        t if (1.0..2.5).contains(&t) => 0.05,
        t if (2.5..3.5).contains(&t) => -0.05,
        t if (3.5..4.0).contains(&t) => 0.05,
        t if (4.0..4.5).contains(&t) => -0.05,
        _ => 0.0,
    }
}

/// Short period `alpha' = Z_a alpha + q`, `q' = M_a alpha + M_q q + M_d delta` by fourth-order Runge-Kutta; the last two
/// parameters are the bias of alpha and the initial q.
fn simulate(parameters: &[f64]) -> Result<DMatrix<f64>, EstimateError> {
    let [z_alpha, m_alpha, m_q, m_delta, bias, q_start]: [f64; 6] = parameters.try_into().unwrap();
    let rate = |[alpha, q]: [f64; 2], t: f64| [z_alpha * alpha + q, m_alpha * alpha + m_q * q + m_delta * elevator(t)];
    let mut state = [0.0, q_start];
    let mut outputs = DMatrix::zeros(SAMPLES, 2);
    for k in 0..SAMPLES {
        outputs[(k, 0)] = state[0] + bias;
        outputs[(k, 1)] = state[1];
        let t = STEP_S * k as f64;
        let along = |slope: [f64; 2], h: f64| [state[0] + h * slope[0], state[1] + h * slope[1]];
        let k1 = rate(state, t);
        let k2 = rate(along(k1, 0.5 * STEP_S), t + 0.5 * STEP_S);
        let k3 = rate(along(k2, 0.5 * STEP_S), t + 0.5 * STEP_S);
        let k4 = rate(along(k3, STEP_S), t + STEP_S);
        for axis in 0..2 {
            state[axis] += STEP_S / 6.0 * (k1[axis] + 2.0 * k2[axis] + 2.0 * k3[axis] + k4[axis]);
        }
    }
    Ok(outputs)
}

/// Parameters with a start that is off by a third.
fn parameters() -> Vec<OutputParameter> {
    let free = (-100.0, 100.0);
    let parameter = |name: &str, start, scale| OutputParameter { name: name.to_owned(), start, scale, bounds: free };
    vec![
        parameter("Z_alpha", -0.5, 0.1),
        parameter("M_alpha", -3.0, 0.1),
        parameter("M_q", -1.0, 0.1),
        parameter("M_delta", -4.0, 0.1),
        parameter("bias", 0.0, 0.01),
        parameter("q_start", 0.0, 0.01),
    ]
}

/// Noisy measurement.
fn measured(seed: u64) -> DMatrix<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let truth: Vec<f64> = TRUTH.into_iter().chain([0.01, 0.02]).collect();
    let mut z = simulate(&truth).unwrap();
    for (entry, value) in z.iter_mut().enumerate() {
        let draw: f64 = StandardNormal.sample(&mut rng);
        *value += NOISE[entry / SAMPLES] * draw;
    }
    z
}

#[test]
fn output_error_recovers_truth_within_its_error_bars() {
    /// Largest error in standard errors over 10 realisations of 6 parameters: 3.9 is exceeded once in 170 such sets.
    const BAND: f64 = 3.9;
    let truth: Vec<f64> = TRUTH.into_iter().chain([0.01, 0.02]).collect();
    let mut squares = 0.0;
    for seed in 0..10 {
        let fit = output_error(&parameters(), &measured(seed), &OutputErrorSettings::default(), simulate).unwrap();
        for index in 0..6 {
            let error = (fit.estimates[index] - truth[index]) / fit.standard_errors[index];
            assert!(error.abs() < BAND, "{} is off by {error:.1} standard errors", fit.names[index]);
            squares += error * error;
        }
        for (found, truth) in fit.noise.iter().zip(NOISE) {
            approx::assert_relative_eq!(*found, truth, max_relative = 0.1);
        }
        assert!(fit.cost.windows(2).all(|pair| pair[1] < pair[0]));
        // The noise alone leaves an R2 of 0.93; the information matrix at the truth gives 0.8 per cent of M_alpha.
        assert!(fit.standard_errors[1] < 0.01 * TRUTH[1].abs() && fit.quality[1].r_squared > 0.9);
    }
    // Sixty squared normalised errors: their mean lies within 1 +- 0.55 (three standard deviations).
    assert!((squares / 60.0 - 1.0).abs() < 0.55, "{}", squares / 60.0);
}

#[test]
fn output_error_skips_gaps_and_holds_bounds() {
    let mut z = measured(3);
    z.view_mut((200, 0), (150, 1)).fill(f64::NAN);
    let mut bounded = parameters();
    bounded[2].bounds = (-1.2, 0.0);
    let fit = output_error(&bounded, &z, &OutputErrorSettings::default(), simulate).unwrap();
    assert!(fit.at_bound[2] && !fit.at_bound[0]);
    assert_eq!((fit.estimates[2], fit.standard_errors[2]), (-1.2, 0.0));
}

#[test]
fn parameter_without_influence_is_named() {
    let mut more = parameters();
    more.push(OutputParameter { name: "unused".to_owned(), start: 1.0, scale: 1.0, bounds: (-9.0, 9.0) });
    let result = output_error(&more, &measured(4), &OutputErrorSettings::default(), |values| simulate(&values[..6]));
    let message = result.unwrap_err().to_string();
    assert!(message.contains("'unused' is zero throughout"), "{message}");
}
