//! Time vectors: which channel is one, what rate it has, where it has gaps, and what is wrong with it.

use std::fmt;

use crate::quantity::Unit;
use crate::statistics::median;

/// An interval counts as one in which samples are missing when it is longer than this many median intervals: what a recorder lost. What is
/// bridged is decided by [`crate::series::gap_threshold_s`].
const GAP_INTERVALS: f64 = 1.5;
/// Most faults of one time vector that are listed one by one.
const LISTED_FAULTS: usize = 5;

/// A stretch without samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Last sample before it, s.
    pub start_s: f64,
    /// First sample after it, s.
    pub end_s: f64,
}

/// A sample at which a time vector fails to increase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeFault {
    /// Time goes back.
    Backwards {
        /// Index of the sample, from 0.
        index: usize,
        /// Latest time before it, s.
        before_s: f64,
        /// Its own time, s.
        time_s: f64,
    },
    /// The sample has the stamp of the one before.
    Repeated {
        /// Index of the sample, from 0.
        index: usize,
        /// Its time, s.
        time_s: f64,
    },
    /// The stamp is NaN or infinite.
    NotFinite {
        /// Index of the sample, from 0.
        index: usize,
    },
}

impl fmt::Display for TimeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Backwards { index, before_s, time_s } => {
                write!(f, "goes back from {before_s} s to {time_s} s at index {index}")
            }
            Self::Repeated { index, time_s } => write!(f, "repeats the stamp {time_s} s at index {index}"),
            Self::NotFinite { index } => write!(f, "is not finite at index {index}"),
        }
    }
}

/// A time vector and what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Channel it is in, or `start_time + sample_rate`.
    pub channel: String,
    /// Unit of that channel, `s` for a computed one.
    pub unit: Unit,
    /// Number of stamps.
    pub samples: usize,
    /// One over the median interval, Hz; zero with fewer than two samples.
    pub rate_hz: f64,
    /// Earliest stamp, s.
    pub start_s: f64,
    /// Latest stamp, s.
    pub end_s: f64,
    /// Intervals longer than one and a half median intervals.
    pub gaps: Vec<Gap>,
    /// The first samples at which time does not increase.
    pub faults: Vec<TimeFault>,
    /// How many such samples there are.
    pub fault_count: usize,
    /// Whether file, name or map state the unit; otherwise it is the one that makes a recording of flight.
    pub is_unit_stated: bool,
    /// What is to be asked about it, with the fix, in one line; `None` where nothing is.
    pub question: Option<String>,
    /// Whether its stamps make a recording of flight in more than one unit, so that nothing but an answer tells which.
    pub is_unit_ambiguous: bool,
    /// Index of the channel in its source; `None` for a computed clock.
    pub(crate) index: Option<usize>,
}

impl Clock {
    /// What the stamps `time_s` of `channel`, recorded in `unit`, show.
    pub(crate) fn examine(channel: &str, index: usize, unit: Unit, time_s: &[f64]) -> Self {
        let mut intervals = Vec::with_capacity(time_s.len());
        let mut faults = Vec::new();
        let mut fault_count = 0;
        let mut latest = f64::NEG_INFINITY;
        let mut earliest = f64::INFINITY;
        let mut kept = Vec::with_capacity(time_s.len());
        for (sample, &time) in time_s.iter().enumerate() {
            earliest = earliest.min(time);
            match fault_at(sample, time, latest) {
                Some(fault) => {
                    fault_count += 1;
                    if faults.len() < LISTED_FAULTS {
                        faults.push(fault);
                    }
                }
                None => {
                    if latest.is_finite() {
                        intervals.push(time - latest);
                    }
                    kept.push(time);
                    latest = time;
                }
            }
        }
        let median = median(&mut intervals).unwrap_or(0.0);
        let gaps = kept
            .windows(2)
            .filter(|pair| pair[1] - pair[0] > GAP_INTERVALS * median)
            .map(|pair| Gap { start_s: pair[0], end_s: pair[1] })
            .collect();
        let rate_hz = if median > 0.0 { 1.0 / median } else { 0.0 };
        let repeated = faults.iter().all(|fault| matches!(fault, TimeFault::Repeated { .. }));
        let question = (repeated && 2 * fault_count > time_s.len())
            .then(|| coarse(channel, earliest, rate_hz, kept.len(), time_s.len()));
        Self {
            channel: channel.to_owned(),
            unit,
            samples: time_s.len(),
            rate_hz,
            start_s: earliest,
            end_s: latest,
            gaps,
            faults,
            fault_count,
            is_unit_stated: true,
            question,
            is_unit_ambiguous: false,
            index: Some(index),
        }
    }

    /// Median interval, s; zero with fewer than two stamps.
    pub(crate) fn interval_s(&self) -> f64 {
        if self.rate_hz > 0.0 { 1.0 / self.rate_hz } else { 0.0 }
    }
}

/// What to do with stamps that are coarser than the samples: `stamps` different ones of `samples`, at `rate_hz`.
fn coarse(channel: &str, start_s: f64, rate_hz: f64, stamps: usize, samples: usize) -> String {
    let each = samples as f64 / stamps as f64;
    let rate_hz = (rate_hz * each).round();
    format!(
        "'{channel}' repeats each stamp {each:.0} times: it is coarser than the samples; give start_time = \
         {start_s} and sample_rate = {rate_hz} in the map's [[time]] (repair = \"drop\" would keep {stamps} of {samples} samples)"
    )
}

/// What is wrong with stamp `time` after `latest`, if anything.
pub(crate) fn fault_at(index: usize, time_s: f64, latest_s: f64) -> Option<TimeFault> {
    if !time_s.is_finite() {
        Some(TimeFault::NotFinite { index })
    } else if time_s == latest_s {
        Some(TimeFault::Repeated { index, time_s })
    } else if time_s < latest_s {
        Some(TimeFault::Backwards { index, before_s: latest_s, time_s })
    } else {
        None
    }
}
