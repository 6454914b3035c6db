//! A channel of a guess as numbers in SI with their stamps.

use std::f64::consts::TAU;

use crate::load::contents::Probe;
use crate::load::guesses::slopes::stamps_of;
use crate::load::maps::by_hand::{ManualChannel, ManualChannelMap};
use crate::quantity::Role;

/// Samples of a recording of which all are compared, and the interval to which longer ones are thinned, s: a fraction of the spans over
/// which they are compared.
const MOST_SAMPLES: usize = 200_000;
const INTERVAL_S: f64 = 0.02;

/// Every how many samples are enough.
fn thinning(time_s: &[f64]) -> usize {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else { return 1 };
    if time_s.len() <= MOST_SAMPLES {
        return 1;
    }
    let interval_s = (last - first) / (time_s.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited; not a number is zero")]
    let step = (INTERVAL_S / interval_s).round() as usize;
    step.clamp(1, time_s.len() / MOST_SAMPLES + 1)
}

/// Values of a row in SI with their stamps; those of a long and fast recording thinned.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    /// Stamps, s.
    pub(crate) time_s: Vec<f64>,
    pub(crate) values: Vec<f64>,
}

impl Trace {
    pub(crate) fn read(row: &ManualChannel, probes: &[Probe]) -> Option<Self> {
        let channel = row.from.find(probes)?;
        let unit = row.unit?;
        let time_s = stamps_of(&row.from, probes)?;
        let sign = if row.turned { -1.0 } else { 1.0 };
        let read = |raw: &f64| sign * row.scale * unit.to_si(raw + row.offset);
        let count = channel.values().len();
        if count != time_s.len() || count <= 2 {
            return None;
        }
        // What a slow recorder wrote into a fast table, whose other cells are empty.
        let finite = channel.values().iter().filter(|value| value.is_finite()).count();
        if finite > 2 && 2 * finite <= count {
            let both = time_s.into_iter().zip(channel.values()).filter(|(_, value)| value.is_finite());
            let (time_s, values) = both.map(|(time, value)| (time, read(value))).unzip();
            return Some(Self { time_s, values });
        }
        let step = thinning(&time_s);
        let values = channel.values().iter().step_by(step).map(read).collect();
        let time_s = if step == 1 { time_s } else { time_s.into_iter().step_by(step).collect() };
        Some(Self { time_s, values })
    }

    /// The row of a role.
    pub(crate) fn for_role(map: &ManualChannelMap, role: Role, probes: &[Probe]) -> Option<Self> {
        Self::read(map.row(role)?, probes)
    }

    /// Linearly between its samples at other stamps; nothing of fewer than two samples, and where they do not overlap by half.
    pub(crate) fn at(self, time_s: &[f64]) -> Option<Self> {
        if self.time_s == time_s {
            return Some(self);
        }
        if self.time_s.len() < 2 {
            return None;
        }
        let mut next = 1;
        let mut values = Vec::with_capacity(time_s.len());
        for &time in time_s {
            while next + 1 < self.time_s.len() && self.time_s[next] < time {
                next += 1;
            }
            let (before, after) = (self.time_s[next - 1], self.time_s[next]);
            let part = (time - before) / (after - before);
            let is_inside = (0.0..=1.0).contains(&part);
            let value = self.values[next - 1] + part * (self.values[next] - self.values[next - 1]);
            values.push(if is_inside { value } else { f64::NAN });
        }
        let finite = values.iter().filter(|value| value.is_finite()).count();
        (2 * finite > time_s.len()).then(|| Self { time_s: time_s.to_vec(), values })
    }

    /// An angle without its jumps of a turn.
    pub(crate) fn unwrapped(mut self) -> Self {
        let mut last: Option<f64> = None;
        for value in &mut self.values {
            if let Some(last) = last.filter(|_| value.is_finite()) {
                *value -= TAU * ((*value - last) / TAU).round();
            }
            last = Some(*value).filter(|value| value.is_finite()).or(last);
        }
        self
    }

    pub(crate) fn map(mut self, change: impl Fn(f64) -> f64) -> Self {
        self.values.iter_mut().for_each(|value| *value = change(*value));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_and_fast_recording_is_thinned_to_fifty_hertz_and_no_other() {
        let stamps = |count: usize, rate_hz: f64| (0..count).map(|k| k as f64 / rate_hz).collect::<Vec<_>>();
        assert_eq!(thinning(&stamps(3_600_000, 1000.0)), 19);
        assert_eq!(thinning(&stamps(3_600_000, 100.0)), 2);
        assert_eq!(thinning(&stamps(200_000, 1000.0)), 1);
        assert_eq!(thinning(&stamps(3_600_000, 10.0)), 1);
        assert_eq!(thinning(&[f64::NAN; 300_000]), 1);
        assert_eq!(thinning(&[]), 1);
    }
}
