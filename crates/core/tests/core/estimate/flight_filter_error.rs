//! Filter error on lateral flights in gusts that the model does not know.

use doublet_core::estimate::{
    FlightFitError, FlightFreedom, OutputErrorSettings, flight_filter_error, flight_output_error,
};
use doublet_core::replay::{Motion, MotionAxis, Replay};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::flight_output_error::{entries, flight_window, recorded};
use crate::flight::{GRAVITY_M_S2, STEP_S, TRUTH, replay, truth, window};

const AXIS: MotionAxis = MotionAxis::Lateral;
/// Samples of a window: 12 s.
const SAMPLES: usize = 600;

/// Wind from north and east, m/s, that is left to a part by every sample: 120 m at 46 m/s, deviation `size`.
fn gusts(size: f64, seed: u64) -> [Vec<f64>; 3] {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(500 + seed);
    let left = (-STEP_S * 46.0 / 120.0).exp();
    let mut column = || {
        let mut last = 0.0;
        (0..SAMPLES)
            .map(|_| {
                let draw: f64 = StandardNormal.sample(&mut rng);
                last = left * last + size * (1.0 - left * left).sqrt() * draw;
                last
            })
            .collect::<Vec<f64>>()
    };
    [column(), column(), vec![0.0; SAMPLES]]
}

/// Errors of the derivatives in standard errors, by output error and by filter error.
fn fly_in_gusts(size: f64, seed: u64) -> [Vec<f64>; 2] {
    let (data, settings, start) = window(SAMPLES);
    let gusty = Replay::new(&data, &settings, &gusts(size, seed), GRAVITY_M_S2).unwrap();
    let (still, _) = replay(SAMPLES).unwrap();
    let flown = gusty.fly(&truth(), &start).unwrap();
    let motion = Motion::from(&flown);
    let windows = [flight_window(&still, start, &motion, truth(), recorded(AXIS, &flown, seed))];
    let freedom = FlightFreedom { shared: entries(AXIS), own: Vec::new(), biases: AXIS.biased() };
    let search = OutputErrorSettings::default();
    let output = flight_output_error(AXIS, &windows, &freedom, &search, &|| true).unwrap();
    let least = [0.0; 5];
    let begin = (&*output.fit.estimates, &least[..]);
    let filter = flight_filter_error(AXIS, (&windows, &freedom), begin, &search, &|| true).unwrap();
    [&output, &filter.estimate].map(|found| {
        let errors = entries(AXIS)
            .into_iter()
            .enumerate()
            .map(|(place, entry)| (found.fit.estimates[place] - TRUTH[entry].2) / found.corrected_errors[place]);
        errors.collect()
    })
}

#[test]
fn derivatives_in_gusts_are_those_of_the_truth_where_output_error_misses() {
    const FLIGHTS: u64 = 3;
    let mut all = [Vec::new(), Vec::new()];
    for seed in 0..FLIGHTS {
        let found = fly_in_gusts(1.0, seed);
        all.iter_mut().zip(found).for_each(|(all, found)| all.extend(found));
    }
    let [output, filter] = all.map(|errors| {
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        (squares / errors.len() as f64).sqrt()
    });
    println!("errors in standard errors, rms of {FLIGHTS} flights: output error {output:.2}, filter error {filter:.2}");
    assert!(output > 2.0 && filter < 1.5, "{output} {filter}");
}

#[test]
fn both_axes_at_once_are_refused() {
    let (still, start) = replay(SAMPLES).unwrap();
    let flown = still.fly(&truth(), &start).unwrap();
    let motion = Motion::from(&flown);
    let windows = [flight_window(&still, start, &motion, truth(), recorded(MotionAxis::Both, &flown, 1))];
    let freedom = FlightFreedom { shared: entries(MotionAxis::Both), ..FlightFreedom::default() };
    let search = OutputErrorSettings::default();
    let refused = flight_filter_error(MotionAxis::Both, (&windows, &freedom), (&[], &[]), &search, &|| true);
    assert_eq!(refused.unwrap_err(), FlightFitError::OneAxis);
}
