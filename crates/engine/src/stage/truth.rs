//! The filtered path against the truth, where the recording carries it.

use std::collections::BTreeMap;

use doublet_core::reconstruct::{Reconstruction, STATES, State};
use doublet_core::series::Series;

/// Error of one state against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthError {
    /// Truth at the last sample.
    pub last: f64,
    /// Mean of the squared error over the variance, after the first second.
    pub mean_squared_normalised_error: f64,
}

/// The truth is compared from this long after the start on, s.
const SETTLE_S: f64 = 1.0;

/// Error of every state whose truth is known, at the samples of the reconstruction.
pub(crate) fn truth_errors(
    truth: &[Option<Series>; STATES],
    reconstruction: &Reconstruction,
) -> BTreeMap<State, TruthError> {
    let known = State::ALL.into_iter().filter_map(|state| Some((state, truth[state as usize].as_ref()?)));
    known.filter_map(|(state, truth)| Some((state, truth_error(state, truth, reconstruction)?))).collect()
}

fn truth_error(state: State, truth: &Series, reconstruction: &Reconstruction) -> Option<TruthError> {
    let index = state as usize;
    let start = reconstruction.time_s.first()? + SETTLE_S;
    let (mut sum, mut count, mut last) = (0.0, 0.0, f64::NAN);
    let mut place = truth.time_s.partition_point(|&t| t < reconstruction.time_s[0] - 1e-9);
    for (sample, &time) in reconstruction.time_s.iter().enumerate() {
        // Truth on another clock is not compared: interpolating it would add an error of its own.
        place += truth.time_s[place..].iter().take_while(|&&t| t < time - 1e-9).count();
        if truth.time_s.get(place).is_none_or(|&t| (t - time).abs() > 1e-6) {
            continue;
        }
        last = truth.values[place];
        if time >= start {
            let error = reconstruction.states[index][sample] - last;
            let error = if is_angle(state) { wrap(error) } else { error };
            sum += (error / reconstruction.deviations[index].at(sample)).powi(2);
            count += 1.0;
        }
    }
    (count > 0.0).then_some(TruthError { last, mean_squared_normalised_error: sum / count })
}

fn is_angle(state: State) -> bool {
    matches!(state, State::BankAngle | State::PitchAngle | State::HeadingAngle)
}

fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
