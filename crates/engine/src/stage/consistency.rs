//! Whether the filter's own uncertainty fits what happened: innovations against their predicted deviation, truth where known.

use std::collections::BTreeMap;

use doublet_core::reconstruct::{MEASUREMENTS, Measurement, Reconstruction, State};
use doublet_core::series::{Recording, Series};

/// Consistency of one measurement's innovations.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Updates.
    pub samples: usize,
    /// Mean innovation, SI.
    pub mean: f64,
    /// Root mean square of the innovation, SI.
    pub rms: f64,
    /// Root mean square of innovation over predicted deviation: one when consistent, above when the filter is over-confident.
    pub ratio: f64,
    /// One sentence on what to change.
    pub advice: String,
}

/// Consistency of a reconstruction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Consistency {
    /// Mean normalised innovation squared.
    pub mean_nis: f64,
    /// Its expectation: the mean number of measurements of an update.
    pub expected_nis: f64,
    /// One per measurement; `None` where it was never measured.
    pub channels: [Option<Channel>; MEASUREMENTS],
}

/// Error of one state against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthError {
    /// Truth at the last sample.
    pub last: f64,
    /// Mean of the squared error over the variance, after the first second.
    pub mean_squared_normalised_error: f64,
}

/// Ratios within this factor of one count as consistent: the deviation is then known to a fifth.
const CONSISTENT: f64 = 1.2;
/// The truth is compared from this long after the start on, s.
const SETTLE_S: f64 = 1.0;

/// Innovations against their predicted deviations.
pub fn consistency(reconstruction: &Reconstruction) -> Consistency {
    let measured: Vec<_> =
        reconstruction.nis.iter().zip(&reconstruction.nis_degrees).filter(|(nis, _)| nis.is_finite()).collect();
    let count = measured.len() as f64;
    Consistency {
        mean_nis: measured.iter().map(|(nis, _)| **nis).sum::<f64>() / count,
        expected_nis: measured.iter().map(|(_, degrees)| f64::from(**degrees)).sum::<f64>() / count,
        channels: Measurement::ALL.map(|measurement| channel(reconstruction, measurement)),
    }
}

fn channel(reconstruction: &Reconstruction, measurement: Measurement) -> Option<Channel> {
    let index = measurement as usize;
    let pairs: Vec<_> = reconstruction.innovations[index]
        .iter()
        .zip(&reconstruction.innovation_deviations[index])
        .filter(|(innovation, _)| innovation.is_finite())
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let count = pairs.len() as f64;
    let ratio = (pairs.iter().map(|(v, s)| (*v / *s).powi(2)).sum::<f64>() / count).sqrt();
    let name = measurement.name();
    let advice = if ratio > CONSISTENT {
        format!("over-confident: raise the noise of {name} about {ratio:.1} times, or that of the inertial channels")
    } else if ratio < 1.0 / CONSISTENT {
        format!("under-confident: lower the noise of {name} to about {ratio:.2} of it")
    } else {
        "consistent".to_owned()
    };
    Some(Channel {
        samples: pairs.len(),
        mean: pairs.iter().map(|(v, _)| **v).sum::<f64>() / count,
        rms: (pairs.iter().map(|(v, _)| v.powi(2)).sum::<f64>() / count).sqrt(),
        ratio,
        advice,
    })
}

/// Error of every state whose truth the recording carries, at the samples of the reconstruction.
pub fn truth_errors(recording: &Recording, reconstruction: &Reconstruction) -> BTreeMap<State, TruthError> {
    let known = State::ALL.into_iter().filter_map(|state| Some((state, recording.truth.get(state.name())?)));
    known.filter_map(|(state, truth)| Some((state, truth_error(state, truth, reconstruction)?))).collect()
}

fn truth_error(state: State, truth: &Series, reconstruction: &Reconstruction) -> Option<TruthError> {
    let index = state as usize;
    let start = reconstruction.time_s.first()? + SETTLE_S;
    let (mut sum, mut count, mut last) = (0.0, 0.0, f64::NAN);
    for (sample, &time) in reconstruction.time_s.iter().enumerate() {
        // Truth on another clock is not compared: interpolating it would add an error of its own.
        let place = truth.time_s.partition_point(|&t| t < time - 1e-9);
        if truth.time_s.get(place).is_none_or(|&t| (t - time).abs() > 1e-6) {
            continue;
        }
        last = truth.values[place];
        if time >= start {
            let error = reconstruction.states[index][sample] - last;
            let error = if is_angle(state) { wrap(error) } else { error };
            sum += (error / reconstruction.deviations[index][sample]).powi(2);
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
