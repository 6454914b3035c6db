//! Curves of a contradiction: a channel and what the others say it is, before and after its fix.

use std::ops::Range;

use super::motion::Motion;

/// Most points of a curve: a small figure shows no more.
const MOST_POINTS: usize = 400;

/// A channel over what the others say it is, over the segment of the flight that tells most.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Time on the recording's clock, s.
    pub time_s: Vec<f64>,
    /// The channel, or the side of the relation it stands on, SI. Where the relation leaves an offset free, without its mean.
    pub channel: Vec<f64>,
    /// What the others say it is.
    pub others: Vec<f64>,
}

/// The same before and after a fix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// As read.
    pub before: Trace,
    /// With the fix.
    pub after: Trace,
}

impl Trace {
    /// A trace of `(time, channel, others)`, thinned, of the points at which all three are numbers.
    pub(super) fn new(points: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        let finite = points.filter(|(time, one, other)| time.is_finite() && one.is_finite() && other.is_finite());
        let all: Vec<_> = finite.collect();
        let every = all.len().div_ceil(MOST_POINTS).max(1);
        let mut trace = Self::default();
        for (time, one, other) in all.into_iter().step_by(every) {
            trace.time_s.push(time);
            trace.channel.push(one);
            trace.others.push(other);
        }
        trace
    }

    /// The same with the mean of each curve taken off.
    pub(super) fn without_means(mut self) -> Self {
        for curve in [&mut self.channel, &mut self.others] {
            let mean = curve.iter().sum::<f64>() / curve.len().max(1) as f64;
            curve.iter_mut().for_each(|value| *value -= mean);
        }
        self
    }
}

/// The segment in which `spread` is largest; `None` without segments.
pub(super) fn most_telling(motion: &Motion, spread: impl Fn(&Range<usize>) -> f64) -> Option<Range<usize>> {
    let ranked = motion.segments.iter().map(|segment| (spread(segment), segment));
    ranked.filter(|(size, _)| size.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, segment)| segment.clone())
}
