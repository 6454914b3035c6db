//! Samples in the order of time, whatever the order they come in.

use std::collections::{BTreeMap, VecDeque};

use doublet_core::load::stream::RoleSample;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::{Channel, Recording, Series};

/// Roles whose whole record is needed: what was burnt counts from the start.
const WHOLE: [Role; 2] = [Role::FuelMass, Role::FuelFlow];
/// Shortest interval of samples of these, s.
const WHOLE_INTERVAL_S: f64 = 1.0;
/// Slowest role that is waited for, s between its samples; slower ones are held.
const WAITED_FOR_S: f64 = 0.5;

/// Samples by role, in the order of time.
#[derive(Debug, Default)]
pub struct OrderedSamples {
    tracks: BTreeMap<Role, VecDeque<(f64, f64)>>,
    /// Delays of measurements: their samples show what was true so much earlier, s.
    delays_s: BTreeMap<Role, f64>,
    /// Rows that came too late: samples of one time, one after the other, are one row.
    pub late: u64,
    last_late_s: Option<f64>,
}

impl OrderedSamples {
    /// With the delay of each measurement.
    pub fn new(delays_s: &[f64]) -> Self {
        let delays = Measurement::ALL.into_iter().zip(delays_s).filter(|(_, delay)| **delay != 0.0);
        Self { delays_s: delays.map(|(measurement, delay)| (measurement.role(), *delay)).collect(), ..Self::default() }
    }

    /// Puts a sample in its place. One at or before `passed_s` is too late; one that has no value is none.
    pub fn insert(&mut self, sample: RoleSample, passed_s: f64) {
        let RoleSample { role, time_s, value } = sample;
        if !(time_s.is_finite() && value.is_finite()) {
            return;
        }
        let stamp_s = time_s;
        let time_s = time_s - self.delays_s.get(&role).copied().unwrap_or(0.0);
        if time_s <= passed_s {
            self.late += u64::from(self.last_late_s.replace(stamp_s) != Some(stamp_s));
            return;
        }
        let track = self.tracks.entry(role).or_default();
        if WHOLE.contains(&role) && track.back().is_some_and(|(last_s, _)| time_s < last_s + WHOLE_INTERVAL_S) {
            return;
        }
        let behind = track.iter().rev().take_while(|(other_s, _)| *other_s > time_s).count();
        let at = track.len() - behind;
        match at.checked_sub(1).and_then(|before| track.get_mut(before)) {
            Some(before) if before.0 == time_s => before.1 = value,
            _ => track.insert(at, (time_s, value)),
        }
    }

    /// Forgets what was before `time_s`, but for the last sample of a role before it.
    pub(crate) fn forget_before(&mut self, time_s: f64) {
        for (_, track) in self.tracks.iter_mut().filter(|(role, _)| !WHOLE.contains(role)) {
            while track.get(1).is_some_and(|(next_s, _)| *next_s < time_s) {
                track.pop_front();
            }
        }
    }

    /// Times of the samples that drive the filter: of the first rate there is.
    pub(crate) fn base_times(&self) -> Vec<f64> {
        let rates = [Input::RollRate, Input::PitchRate, Input::YawRate];
        let base = rates.iter().find_map(|rate| self.tracks.get(&rate.role()));
        base.into_iter().flatten().map(|(time_s, _)| *time_s).collect()
    }

    /// The last of them before a time, s.
    pub(crate) fn base_before_s(&self, time_s: f64) -> Option<f64> {
        self.base_times().into_iter().rfind(|other_s| *other_s < time_s)
    }

    /// How many of them lie between two times, both exclusive.
    pub(crate) fn base_samples_between(&self, start_s: f64, end_s: f64) -> u64 {
        self.base_times().iter().filter(|time_s| **time_s > start_s && **time_s < end_s).count() as u64
    }

    /// Inertial channels of which nothing came.
    pub(crate) fn missing_inputs(&self) -> Vec<&'static str> {
        Input::ALL.into_iter().filter(|input| !self.tracks.contains_key(&input.role())).map(Input::name).collect()
    }

    /// Time up to which every role that keeps coming is there: the earliest of the last samples of those whose interval is short.
    pub(crate) fn complete_until_s(&self) -> f64 {
        let last = self.tracks.values().filter_map(|track| {
            let ((first_s, _), (last_s, _)) = (track.front()?, track.back()?);
            let interval_s = (last_s - first_s) / (track.len().max(2) - 1) as f64;
            (track.len() > 1 && interval_s <= WAITED_FOR_S).then_some(*last_s)
        });
        last.fold(f64::INFINITY, f64::min)
    }

    /// Values of every role at its latest sample up to `time_s`.
    pub fn latest(&self, time_s: f64) -> BTreeMap<Role, f64> {
        let latest = |track: &VecDeque<(f64, f64)>| {
            track.iter().rev().find(|(at_s, _)| *at_s <= time_s).map(|(_, value)| *value)
        };
        self.tracks.iter().filter_map(|(role, track)| Some((*role, latest(track)?))).collect()
    }

    /// What came, as a recording; a role that ends before `end_s` holds its last value up to there where that is no older than
    /// `stale_s`, and is left out where it is.
    pub fn recording(&self, end_s: f64, stale_s: f64) -> Recording {
        let mut recording = Recording::default();
        for (role, track) in &self.tracks {
            let Some(&(last_s, last)) = track.back() else { continue };
            let interval_s = track.front().map_or(0.0, |(first_s, _)| (last_s - first_s) / track.len() as f64);
            if end_s - last_s > stale_s.max(3.0 * interval_s) {
                continue;
            }
            let (mut time_s, mut values): (Vec<f64>, Vec<f64>) = track.iter().copied().unzip();
            let (is_held, is_input) = (last_s < end_s, Input::ALL.iter().any(|input| input.role() == *role));
            let is_measured = Measurement::ALL.iter().any(|measurement| measurement.role() == *role);
            if is_held && !is_measured && !is_input {
                // Held at its own interval, so that no line of the record pauses.
                let steps = if interval_s > 0.0 { ((end_s - last_s) / interval_s).ceil().clamp(1.0, 1e4) } else { 1.0 };
                let step_s = (end_s - last_s) / steps;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 10000")]
                for k in 1..=steps as usize {
                    time_s.push(last_s + step_s * k as f64);
                    values.push(last);
                }
            }
            recording.roles.insert(*role, recording.channels.len());
            let series = Series { time_s: time_s.into(), values: values.into() };
            let (source, name, unit) =
                ("live".to_owned(), role.name().to_owned(), role.dimension().si_symbol().to_owned());
            recording.channels.push(Channel { source, name, unit, series });
        }
        recording
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_s: f64, value: f64) -> RoleSample {
        RoleSample { role: Role::RollRate, time_s, value }
    }

    #[test]
    fn samples_come_into_the_order_of_time_and_late_ones_are_counted() {
        let mut ordered = OrderedSamples::default();
        for time_s in [0.0, 0.2, 0.1, 0.4, 0.3, 0.1] {
            ordered.insert(sample(time_s, time_s), -1.0);
        }
        ordered.insert(sample(0.05, 9.0), 0.1);
        // Another channel of the same row.
        ordered.insert(RoleSample { role: Role::PitchRate, ..sample(0.05, 9.0) }, 0.1);
        ordered.insert(sample(0.5, f64::NAN), 0.1);
        assert_eq!(ordered.base_times(), [0.0, 0.1, 0.2, 0.3, 0.4]);
        assert_eq!(ordered.late, 1);
        ordered.forget_before(0.25);
        assert_eq!(ordered.base_times(), [0.2, 0.3, 0.4]);
    }
}
