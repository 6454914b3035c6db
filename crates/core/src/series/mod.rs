//! Time bases, signals, recordings and windows.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::quantity::Role;

/// Samples of one quantity against its own time. Both slices have one length; time increases strictly.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Time of each sample, s.
    pub time_s: Arc<[f64]>,
    /// Value of each sample; not finite where the recorder gave nothing.
    pub values: Arc<[f64]>,
}

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
    /// Longest interval between samples that interpolation bridges, s; `None` for a few of a channel's own intervals.
    pub max_gap_s: Option<f64>,
    /// Findings about data quality, one line each; they appear in the report.
    pub warnings: Vec<String>,
}

impl Recording {
    /// The channel that plays `role`, if the recording has one.
    pub fn role(&self, role: Role) -> Option<&Channel> {
        self.roles.get(&role).map(|&index| &self.channels[index])
    }
}

/// A closed interval of time, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
}

impl Window {
    /// Indices `first..end` of the samples of an increasing time vector that lie inside the window.
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
    fn window_takes_both_its_ends() {
        let time = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(Window { start_s: 1.0, end_s: 2.0 }.indices(&time), 1..3);
        assert_eq!(Window { start_s: 5.0, end_s: 2.0 }.indices(&time), 4..4);
    }
}
