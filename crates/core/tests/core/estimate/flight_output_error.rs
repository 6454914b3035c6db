//! Output error with the equations of motion on flights whose every derivative is known.

use doublet_core::estimate::{
    FlightFitError, FlightFreedom, FlightOutput, FlightOutputFit, FlightWindow, OutputErrorSettings,
    disturbance_covariance, flight_output_error,
};
use doublet_core::model::{Coefficient, Derivatives};
use doublet_core::replay::{Motion, MotionAxis, Replay, Response, Start};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::flight::{TRUTH, replay, truth};

/// Samples of a window: 12 s.
const SAMPLES: usize = 600;
/// Deviations of airspeed, flow angles, rates, attitude and specific force of good instruments after smoothing.
const NOISE: [f64; 5] = [0.05, 5e-4, 4e-4, 3e-4, 0.02];

fn noise_of(output: FlightOutput) -> f64 {
    match output {
        FlightOutput::Airspeed => NOISE[0],
        FlightOutput::Alpha | FlightOutput::Beta => NOISE[1],
        FlightOutput::RollRate | FlightOutput::PitchRate | FlightOutput::YawRate => NOISE[2],
        FlightOutput::BankAngle | FlightOutput::PitchAngle => NOISE[3],
        _ => NOISE[4],
    }
}

/// Recorded outputs of a flight of the truth, with noise and biases of the specific forces.
pub(super) fn recorded(axis: MotionAxis, flown: &Response, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let columns = axis.outputs().iter().map(|&output| {
        let (values, bias): (&[f64], f64) = match output {
            FlightOutput::Airspeed => (&flown.airspeed_m_s, 0.0),
            FlightOutput::Alpha => (&flown.alpha_rad, 0.0),
            FlightOutput::Beta => (&flown.beta_rad, 0.0),
            FlightOutput::RollRate => (&flown.rates_rad_s[0], 0.0),
            FlightOutput::PitchRate => (&flown.rates_rad_s[1], 0.0),
            FlightOutput::YawRate => (&flown.rates_rad_s[2], 0.0),
            FlightOutput::BankAngle => (&flown.euler_rad[0], 0.0),
            FlightOutput::PitchAngle => (&flown.euler_rad[1], 0.0),
            FlightOutput::SpecificForceX => (&flown.specific_force_m_s2[0], BIAS),
            FlightOutput::SpecificForceY => (&flown.specific_force_m_s2[1], BIAS),
            FlightOutput::SpecificForceZ => (&flown.specific_force_m_s2[2], BIAS),
        };
        values
            .iter()
            .map(|value| {
                let draw: f64 = StandardNormal.sample(&mut rng);
                value + bias + noise_of(output) * draw
            })
            .collect()
    });
    columns.collect()
}

/// A window of a flight recorded at the centre of gravity.
pub(super) fn flight_window<'a>(
    replay: &'a Replay,
    start: Start,
    motion: &'a Motion,
    model: Derivatives,
    measured: Vec<Vec<f64>>,
) -> FlightWindow<'a> {
    FlightWindow { label: "w".to_owned(), replay, start, motion, model, measured, accelerometer_from_cg_m: None }
}

/// Bias of every specific force, m/s².
const BIAS: f64 = 0.1;

/// Entries of the truth that belong to an axis.
pub(super) fn entries(axis: MotionAxis) -> Vec<usize> {
    (0..TRUTH.len()).filter(|&index| axis.has(TRUTH[index].0)).collect()
}

/// Derivatives of the axis a tenth off, the others three times what they are: they must not matter.
fn off(axis: MotionAxis) -> Derivatives {
    let mut model = truth();
    let own = entries(axis);
    for (index, (.., value)) in TRUTH.iter().enumerate() {
        model.set(index, if own.contains(&index) { 1.1 * value } else { 3.0 * value });
    }
    model
}

fn follow(axis: MotionAxis, seed: u64) -> Result<FlightOutputFit, FlightFitError> {
    let (replay, start) = replay(SAMPLES).unwrap();
    let flown = replay.fly(&truth(), &start).unwrap();
    let mut begin: Start = start;
    match axis {
        MotionAxis::Longitudinal | MotionAxis::Both => begin.euler_rad[1] += 0.004,
        MotionAxis::Lateral => begin.air_velocity_body_m_s[1] += 0.2,
    }
    let motion = Motion::from(&flown);
    let window = flight_window(&replay, begin, &motion, off(axis), recorded(axis, &flown, seed));
    let freedom = FlightFreedom { shared: entries(axis), own: Vec::new(), biases: axis.biased() };
    flight_output_error(axis, &[window], &freedom, &OutputErrorSettings::default(), &|| true)
}

#[test]
fn output_error_of_a_flight_recovers_every_derivative_within_its_errors() {
    for axis in MotionAxis::ALL {
        let found = follow(axis, 11).unwrap();
        let (fit, entries) = (&found.fit, entries(axis));
        let mut squares = 0.0;
        for (place, error) in found.corrected_errors.iter().enumerate() {
            assert_eq!(found.corrected_covariance[(place, place)].sqrt(), *error, "{}", fit.names[place]);
        }
        for (place, &entry) in entries.iter().enumerate() {
            let (coefficient, term, truth) = TRUTH[entry];
            let normalised = (fit.estimates[place] - truth) / fit.standard_errors[place];
            println!(
                "{} of {term}: {:.5} +- {:.5}, truth {truth}",
                coefficient.name(),
                fit.estimates[place],
                fit.standard_errors[place]
            );
            // Of some thirty estimates one lies beyond four standard errors once in 500 runs.
            assert!(normalised.abs() < 4.0, "{}: {normalised:.1} standard errors off", fit.names[place]);
            squares += normalised * normalised;
            // White noise: the correction for colour leaves the errors, but for the lags' own scatter.
            let ratio = found.corrected_errors[place] / fit.standard_errors[place];
            assert!((0.6..1.5).contains(&ratio), "{}: corrected over conventional {ratio}", fit.names[place]);
        }
        let mean = squares / entries.len() as f64;
        assert!((0.2..2.2).contains(&mean), "mean squared normalised error {mean}");
        for (index, &output) in axis.outputs().iter().enumerate() {
            approx::assert_relative_eq!(fit.noise[index], noise_of(output), max_relative = 0.15);
        }
        for (name, value) in fit.names.iter().zip(&fit.estimates).filter(|(name, _)| name.contains("bias")) {
            assert!((value - BIAS).abs() < 0.02, "{name} {value}");
        }
    }
}

/// Estimates of a flight that coloured disturbances of its coefficients moved, and their variances: of the noise and with the
/// disturbances, which are known.
fn follow_disturbed(seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    const AXIS: MotionAxis = MotionAxis::Lateral;
    /// Deviation, and share of a disturbance that is left a sample later: half a second at 50 Hz.
    const SIZE: f64 = 4e-4;
    const LEFT: f64 = 0.96;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1000 + seed);
    let (quiet, start) = replay(SAMPLES).unwrap();
    let mut disturbed = quiet.clone();
    let unexplained = [Coefficient::CY, Coefficient::Cl, Coefficient::Cn].map(|coefficient| {
        let mut last = 0.0;
        let values: Vec<f64> = (0..SAMPLES)
            .map(|_| {
                let draw: f64 = StandardNormal.sample(&mut rng);
                last = LEFT * last + SIZE * (1.0 - LEFT * LEFT).sqrt() * draw;
                last
            })
            .collect();
        disturbed.disturb(coefficient, values.iter().copied());
        (coefficient, values)
    });
    let flown = disturbed.fly(&truth(), &start).unwrap();
    let motion = Motion::from(&flown);
    let windows = [flight_window(&quiet, start, &motion, truth(), recorded(AXIS, &flown, seed))];
    let freedom = FlightFreedom { shared: entries(AXIS), own: Vec::new(), biases: AXIS.biased() };
    let found = flight_output_error(AXIS, &windows, &freedom, &OutputErrorSettings::default(), &|| true).unwrap();
    let disturbed =
        disturbance_covariance(AXIS, (&windows, &freedom), &found, &[unexplained.into()], &|| true).unwrap();
    assert_eq!(disturbed, disturbed.transpose());
    let least = disturbed.symmetric_eigenvalues().min();
    assert!(least > -1e-9 * disturbed.diagonal().max(), "smallest eigenvalue {least:e}");
    let variances = disturbed.diagonal().iter().copied().collect();
    (found.fit.estimates, found.corrected_errors, variances)
}

#[test]
fn scatter_of_disturbed_flights_is_that_of_the_variance_stated() {
    let own: Vec<f64> = entries(MotionAxis::Lateral).iter().map(|&entry| TRUTH[entry].2).collect();
    let (mut alone, mut with) = (0.0, 0.0);
    const FLIGHTS: u64 = 16;
    for seed in 0..FLIGHTS {
        let (estimates, errors, variances) = follow_disturbed(seed);
        for (place, truth) in own.iter().enumerate() {
            let square = (estimates[place] - truth).powi(2);
            alone += square / errors[place].powi(2);
            with += square / (errors[place].powi(2) + variances[place]);
        }
    }
    let count = FLIGHTS as f64 * own.len() as f64;
    let [alone, with] = [alone, with].map(|sum| (sum / count).sqrt());
    println!("normalised errors: {alone:.2} by the residuals alone, {with:.2} with the disturbances");
    // Some two hundred estimates, a dozen of each flight hanging together; what residuals show is counted twice.
    assert!(alone > 1.3 && (0.65..1.2).contains(&with), "{alone} {with}");
}

#[test]
fn windows_share_derivatives_and_keep_their_own_starts() {
    let axis = MotionAxis::Lateral;
    let (replay, start) = replay(SAMPLES).unwrap();
    let flown = replay.fly(&truth(), &start).unwrap();
    let motion = Motion::from(&flown);
    let window = |label: &str, seed: u64| FlightWindow {
        label: label.to_owned(),
        ..flight_window(&replay, start, &motion, off(axis), recorded(axis, &flown, seed))
    };
    let freedom = FlightFreedom { shared: entries(axis), own: Vec::new(), biases: vec![FlightOutput::SpecificForceY] };
    let settings = OutputErrorSettings::default();
    let two = flight_output_error(axis, &[window("a", 1), window("b", 2)], &freedom, &settings, &|| true).unwrap();
    let one = flight_output_error(axis, &[window("a", 1)], &freedom, &settings, &|| true).unwrap();
    assert_eq!(two.samples, [0..SAMPLES, SAMPLES..2 * SAMPLES]);
    assert_eq!(two.fit.names.len(), entries(axis).len() + 2 * 5);
    assert!(two.fit.names.contains(&"v start[b]".to_owned()));
    let place = entries(axis).iter().position(|&entry| TRUTH[entry].1 == "pb/2V" && TRUTH[entry].0 == Coefficient::Cl);
    let place = place.unwrap();
    // Twice the data: errors fall by the square root of two, but for the noise estimates' own scatter of 3 %.
    let ratio = one.fit.standard_errors[place] / two.fit.standard_errors[place];
    approx::assert_relative_eq!(ratio, 2.0_f64.sqrt(), max_relative = 0.1);
}

#[test]
fn flight_that_is_stopped_or_does_not_fit_says_so() {
    let (replay, start) = replay(SAMPLES).unwrap();
    let flown = replay.fly(&truth(), &start).unwrap();
    let motion = Motion::from(&flown);
    let window = flight_window(&replay, start, &motion, truth(), recorded(MotionAxis::Lateral, &flown, 1));
    let freedom = FlightFreedom { shared: entries(MotionAxis::Lateral), ..FlightFreedom::default() };
    let settings = OutputErrorSettings::default();
    let windows = [window];
    let stopped = flight_output_error(MotionAxis::Lateral, &windows, &freedom, &settings, &|| false);
    assert_eq!(stopped.unwrap_err(), FlightFitError::Stopped);
    let other = flight_output_error(MotionAxis::Longitudinal, &windows, &freedom, &settings, &|| true);
    assert!(matches!(other.unwrap_err(), FlightFitError::Estimate(_)));
}
