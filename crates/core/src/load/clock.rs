//! Time vectors: which channel is one, what rate it has, where it has gaps, and what is wrong with it.

use std::fmt;

use crate::load::restart::follow_restarts;
use crate::quantity::Unit;
use crate::series::ClockRestart;
use crate::statistics::median;

/// An interval counts as one in which samples are missing when it is longer than this many median intervals: what a recorder lost. What is
/// bridged is decided by [`crate::series::gap_threshold_s`].
const GAP_INTERVALS: f64 = 1.5;
/// One sample in so many, at most, may repeat the stamp before it and be left out: rows written twice.
const REPEATED_SHARE: usize = 5;
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

/// Stamps that are coarser than the samples: UTC in whole seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseStamps {
    /// Rate of the samples, Hz.
    pub rate_hz: f64,
    /// Every stamp stands for the same number of samples within one, and they are evenly spaced: nothing is missing.
    pub is_even: bool,
    /// Index of the first sample of the second stamp, and that stamp, s.
    first_change: (usize, f64),
}

impl CoarseStamps {
    /// What the times `time_s`, of which none goes back and `stamps` differ by `interval_s`, show.
    fn measure(time_s: &[f64], stamps: usize, interval_s: f64) -> Self {
        let changes: Vec<usize> = (1..time_s.len()).filter(|&k| time_s[k] != time_s[k - 1]).collect();
        let (first, last) = (changes.first().copied().unwrap_or(0), changes.last().copied().unwrap_or(0));
        let span_s = time_s[last] - time_s[first];
        let rate_hz = if span_s > 0.0 {
            (last - first) as f64 / span_s
        } else {
            time_s.len() as f64 / (stamps as f64 * interval_s)
        };
        // Either end is known to a sample.
        let is_whole = rate_hz >= 1.0 && (rate_hz - rate_hz.round()).abs() * span_s <= 1.0;
        let rate_hz = if is_whole { rate_hz.round() } else { rate_hz };
        let counts = || changes.windows(2).map(|pair| pair[1] - pair[0]);
        let (least, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
        let is_regular = |pair: &[usize]| (time_s[pair[1]] - time_s[pair[0]] - interval_s).abs() < 0.01 * interval_s;
        let is_even = changes.len() > LEAST_CHANGES
            && most - least <= 2
            && first.max(time_s.len() - last) <= most
            && changes.windows(2).all(is_regular);
        Self { rate_hz, is_even, first_change: (first, time_s[first]) }
    }

    /// Time of the first sample where samples are evenly spaced at a rate, s.
    pub fn start_s(&self, rate_hz: f64) -> f64 {
        let (index, time_s) = self.first_change;
        time_s - index as f64 / rate_hz
    }
}

/// Changes of stamps that a recording has at least to be called even.
const LEAST_CHANGES: usize = 3;

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
    /// Restarts of its recorder, behind which the stamps were taken to follow.
    pub restarts: Vec<ClockRestart>,
    /// How many such samples there are.
    pub fault_count: usize,
    /// How many of them repeat the stamp of the one before.
    pub repeated: usize,
    /// Whether file, name or map state the unit; otherwise it is the one that makes a recording of flight.
    pub is_unit_stated: bool,
    /// What is to be asked about it, with the fix, in one line; `None` where nothing is.
    pub question: Option<String>,
    /// Whether its stamps make a recording of flight in more than one unit, so that nothing but an answer tells which.
    pub is_unit_ambiguous: bool,
    /// What the stamps show where they are coarser than the samples.
    pub coarse: Option<CoarseStamps>,
    /// Index of the channel in its source; `None` for a computed clock.
    pub(crate) index: Option<usize>,
}

impl Clock {
    /// What the stamps `time_s` of `channel`, recorded in `unit`, show.
    pub(crate) fn examine(channel: &str, index: usize, unit: Unit, time_s: &[f64]) -> Self {
        let (followed, restarts) = follow_restarts(time_s).unzip();
        let (time_s, restarts) = (followed.as_deref().unwrap_or(time_s), restarts.unwrap_or_default());
        let mut intervals = Vec::with_capacity(time_s.len());
        let mut faults = Vec::new();
        let (mut fault_count, mut repeated) = (0, 0);
        let mut latest = f64::NEG_INFINITY;
        let mut earliest = f64::INFINITY;
        let mut kept = Vec::with_capacity(time_s.len());
        for (sample, &time) in time_s.iter().enumerate() {
            earliest = earliest.min(time);
            match fault_at(sample, time, latest) {
                Some(fault) => {
                    fault_count += 1;
                    repeated += usize::from(matches!(fault, TimeFault::Repeated { .. }));
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
        let coarse = (repeated == fault_count && 2 * fault_count > time_s.len() && kept.len() > 1)
            .then(|| CoarseStamps::measure(time_s, kept.len(), median));
        let question = coarse.map(|coarse| ask_about(channel, coarse, kept.len(), time_s.len()));
        Self {
            channel: channel.to_owned(),
            unit,
            samples: time_s.len(),
            rate_hz,
            start_s: earliest,
            end_s: latest,
            gaps,
            faults,
            restarts,
            fault_count,
            repeated,
            is_unit_stated: true,
            question,
            is_unit_ambiguous: false,
            coarse,
            index: Some(index),
        }
    }

    /// Whether nothing is wrong but that some samples, few enough to be left out, have the stamp of the one before.
    pub(crate) fn repeats_some(&self) -> bool {
        self.repeated == self.fault_count && REPEATED_SHARE * self.repeated <= self.samples
    }

    /// Median interval, s; zero with fewer than two stamps.
    pub(crate) fn interval_s(&self) -> f64 {
        if self.rate_hz > 0.0 { 1.0 / self.rate_hz } else { 0.0 }
    }
}

/// What to do with stamps that are coarser than the samples: `stamps` different ones of `samples`.
fn ask_about(channel: &str, coarse: CoarseStamps, stamps: usize, samples: usize) -> String {
    let each = samples as f64 / stamps as f64;
    let (rate_hz, start_s) = (coarse.rate_hz, (coarse.start_s(coarse.rate_hz) * 1e6).round() / 1e6);
    format!(
        "'{channel}' repeats each stamp {each:.0} times: it is coarser than the samples; state start time {start_s} s and sample \
         rate {rate_hz} Hz in the channel map (repair 'drop' would keep {stamps} of {samples} samples)"
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What the stamps of samples at a rate show, rounded down to a step.
    fn stamps(rate_hz: f64, step_s: f64, lost: std::ops::Range<usize>) -> Option<CoarseStamps> {
        let stamp = |k: usize| ((k as f64 / rate_hz + 0.31) / step_s + 1e-9).floor() * step_s;
        let time_s: Vec<f64> = (0..3000).filter(|k| !lost.contains(k)).map(stamp).collect();
        Clock::examine("UTC", 0, Unit::parse("s").unwrap(), &time_s).coarse
    }

    #[test]
    fn coarse_stamps_have_the_rate_and_start_of_their_samples() {
        for (rate_hz, step_s) in [(50.0, 1.0), (64.0, 1.0), (25.0, 0.1), (64.0, 0.1)] {
            let coarse = stamps(rate_hz, step_s, 0..0).unwrap();
            assert_eq!((coarse.rate_hz, coarse.is_even), (rate_hz, true), "{rate_hz} Hz, {step_s} s");
            let start_s = coarse.start_s(rate_hz);
            assert!((start_s - 0.31).abs() <= 1.01 / rate_hz, "{rate_hz} Hz, {step_s} s: {start_s} s");
        }
        assert_eq!(stamps(50.0, 1.0, 700..900).map(|coarse| coarse.is_even), Some(false));
        assert_eq!(stamps(50.0, 0.02, 0..0), None);
    }
}
