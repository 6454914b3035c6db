//! Time bases, signals, recordings and windows; gaps, and few points that draw like many.

mod decimate;
mod gap;

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::message::Message;
use crate::quantity::Role;

pub use decimate::{Band, Decimated, Pyramid, decimate, decimate_band};
pub use gap::{gap_threshold_s, value_at};

/// Samples beyond which a window is long: what can be formed again is not kept then, and large work goes one after the other.
pub const LONG_WINDOW: usize = 1 << 16;

/// Samples of one quantity against its own time. Both slices have one length; time increases strictly.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Time of each sample, s.
    pub time_s: Arc<[f64]>,
    /// Value of each sample; not finite where the recorder gave nothing.
    pub values: Arc<[f64]>,
}

/// What a signal does between two instants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Finite samples inside.
    pub samples: usize,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean of the samples, `sum x / N`.
    pub mean: f64,
    /// Root mean square, `sqrt(sum x^2 / N)`.
    pub rms: f64,
    /// Standard deviation about the mean, `sqrt(sum (x - mean)^2 / N)`.
    pub deviation: f64,
}

impl Series {
    /// The samples inside `range`, both ends included; shared where they are all.
    #[must_use]
    pub fn within(&self, range: TimeRange) -> Self {
        let inside = range.indices(&self.time_s);
        if inside == (0..self.values.len()) {
            return self.clone();
        }
        Self { time_s: self.time_s[inside.clone()].into(), values: self.values[inside].into() }
    }

    /// The finite samples; shared where they are all.
    #[must_use]
    pub fn finite(&self) -> Self {
        if self.values.iter().all(|value| value.is_finite()) {
            return self.clone();
        }
        let pairs = self.time_s.iter().zip(self.values.iter()).filter(|(_, value)| value.is_finite());
        let (time_s, values): (Vec<f64>, Vec<f64>) = pairs.unzip();
        Self { time_s: time_s.into(), values: values.into() }
    }

    /// Statistics of the finite samples inside `range`, both ends included; `None` where there are none.
    pub fn statistics(&self, range: TimeRange) -> Option<Statistics> {
        let inside = range.indices(&self.time_s);
        let values = || self.values[inside.clone()].iter().copied().filter(|value| value.is_finite());
        let samples = values().count();
        if samples == 0 {
            return None;
        }
        let count = samples as f64;
        let mean = values().sum::<f64>() / count;
        Some(Statistics {
            samples,
            min: values().fold(f64::INFINITY, f64::min),
            max: values().fold(f64::NEG_INFINITY, f64::max),
            mean,
            rms: (values().map(|value| value * value).sum::<f64>() / count).sqrt(),
            deviation: (values().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt(),
        })
    }
}

/// Source of the channels that were worked out of others.
pub const DERIVED: &str = "derived";

/// One recorded channel, in SI when its unit is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Recorder or file group it came from.
    pub source: String,
    /// Name as recorded.
    pub name: String,
    /// Symbol of the unit `series` is in: SI for a mapped channel, as recorded (or empty) otherwise.
    pub unit: String,
    /// Samples.
    pub series: Series,
}

impl Channel {
    /// `source/name`.
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.source, self.name)
    }
}

/// A clock that went back because its recorder restarted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockRestart {
    /// Last time before, s.
    pub before_s: f64,
    /// First stamp of the clock after it, s.
    pub stamp_s: f64,
    /// Time that the sample with this stamp was given, s.
    pub time_s: f64,
}

/// Everything read from the files of one flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// All channels, mapped ones first.
    pub channels: Vec<Channel>,
    /// Index into `channels` of each role the channel map assigned.
    pub roles: BTreeMap<Role, usize>,
    /// True histories of named states (`reconstruct::layout::State::name`), where a simulated recording carries them; SI.
    pub truth: BTreeMap<String, Series>,
    /// UTC at time zero of a source's clock, s since 1970-01-01, for each source that gives it.
    pub utc_start_s: BTreeMap<String, f64>,
    /// Restarts of a recorder within its file, by source: its clock went back, and what follows was moved behind.
    pub restarts: BTreeMap<String, Vec<ClockRestart>>,
    /// Longest interval between samples that interpolation bridges, s; `None` for a few of a channel's own intervals.
    pub max_gap_s: Option<f64>,
    /// Findings about data quality, one line each; they appear in the report.
    pub warnings: Vec<Message>,
}

impl Recording {
    /// The channel that plays `role`, if the recording has one.
    pub fn role(&self, role: Role) -> Option<&Channel> {
        self.roles.get(&role).map(|&index| &self.channels[index])
    }
}

/// A closed interval of time, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeRange {
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
}

crate::hash_fields!(TimeRange { ; start_s, end_s });

impl TimeRange {
    /// From one instant to another, in whichever order they come.
    pub fn new(one_s: f64, other_s: f64) -> Self {
        Self { start_s: one_s.min(other_s), end_s: one_s.max(other_s) }
    }

    /// Length, s.
    pub fn length_s(&self) -> f64 {
        self.end_s - self.start_s
    }

    /// Whether `time_s` lies inside.
    pub fn contains(&self, time_s: f64) -> bool {
        (self.start_s..=self.end_s).contains(&time_s)
    }

    /// Indices `first..end` of the samples of an increasing time vector that lie inside.
    pub fn indices(&self, time_s: &[f64]) -> std::ops::Range<usize> {
        let first = time_s.partition_point(|&t| t < self.start_s);
        let end = time_s.partition_point(|&t| t <= self.end_s);
        first..end.max(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_a_stretch_leave_out_what_is_not_finite() {
        let series =
            Series { time_s: (0..6).map(f64::from).collect(), values: [9.0, 1.0, f64::NAN, -2.0, 4.0, 9.0].into() };
        let found = series.statistics(TimeRange { start_s: 1.0, end_s: 4.0 }).expect("three samples lie inside");
        assert_eq!((found.samples, found.min, found.max, found.mean), (3, -2.0, 4.0, 1.0));
        approx::assert_relative_eq!(found.rms, 7.0_f64.sqrt());
        approx::assert_relative_eq!(found.deviation, 6.0_f64.sqrt());
        assert_eq!(series.statistics(TimeRange { start_s: 1.5, end_s: 2.5 }), None);
    }

    #[test]
    fn window_takes_both_its_ends() {
        let time = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(TimeRange { start_s: 1.0, end_s: 2.0 }.indices(&time), 1..3);
        assert_eq!(TimeRange { start_s: 5.0, end_s: 2.0 }.indices(&time), 4..4);
    }
}
