//! Samples a recorder repeats because the sensor is slower than it.

use super::Interpolation;
use crate::series::Series;

/// Least number of values a judgement rests on.
const LEAST_RUNS: usize = 20;
/// Shortest hold, samples.
const LEAST_PERIOD: f64 = 1.8;
/// Runs this far from the period, relative to it, are regular.
const BAND: f64 = 0.4;
/// Share of the runs that are regular at least, and share of shorter ones at most: noise on a coarse scale has many short ones.
const REGULAR: f64 = 0.75;
const SHORT: f64 = 0.03;
/// Share of steps of exactly the finest size at most: a coarse scale has no others.
const ONE_STEP: f64 = 0.5;

/// A channel that holds each value of its sensor over several samples.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldSamples {
    /// Mean length of a hold, samples.
    pub period: f64,
    /// Finite samples.
    pub samples: usize,
    /// The first sample of every hold, which is the sensor's own.
    pub own: Series,
}

impl HeldSamples {
    /// Rate of the sensor, Hz; zero with fewer than two samples.
    pub fn rate_hz(&self) -> f64 {
        match (self.own.time_s.first(), self.own.time_s.last()) {
            (Some(first), Some(last)) if last > first => (self.own.time_s.len() - 1) as f64 / (last - first),
            _ => 0.0,
        }
    }

    /// The sensor's own samples joined by straight lines at those of `time_s` that lie between the first and the last.
    pub fn joined(&self, time_s: &[f64]) -> Series {
        let (Some(&first), Some(&last)) = (self.own.time_s.first(), self.own.time_s.last()) else {
            return self.own.clone();
        };
        let inside: Vec<f64> = time_s.iter().copied().filter(|time| (first..=last).contains(time)).collect();
        match super::resample(&self.own.time_s, &self.own.values, &inside, Interpolation::Linear) {
            Ok(values) => Series { time_s: inside.into(), values: values.into() },
            Err(_) => self.own.clone(),
        }
    }
}

/// The sensor's own samples of a channel that holds them; `None` for one that does not.
///
/// Values that last equally long say that the sensor is slower than the recorder: at least three quarters of the runs of equal values have
/// a length within 0.4 of their mean length (runs of two and a half times the median apart), hardly any is shorter, and the mean is
/// 1.8 samples or more. A signal on a coarse scale is something else: its runs have every length, or its steps are all of one
/// size; so is a constant. Where a run lasts several periods the sensor gave the same value again, once a period.
pub fn held_samples(series: &Series) -> Option<HeldSamples> {
    let Series { time_s: time, values } = series.finite();
    let changes: Vec<usize> = (1..values.len()).filter(|&k| values[k] != values[k - 1]).collect();
    let period = period(&changes)?;
    let steps: Vec<f64> = changes.iter().map(|&k| (values[k] - values[k - 1]).abs()).collect();
    let finest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let of_finest = steps.iter().filter(|step| (*step / finest - 1.0).abs() < 1e-4).count();
    if of_finest as f64 >= ONE_STEP * steps.len() as f64 {
        return None;
    }
    let kept = own(&changes, period, values.len());
    let own =
        Series { time_s: kept.iter().map(|&k| time[k]).collect(), values: kept.iter().map(|&k| values[k]).collect() };
    Some(HeldSamples { period, samples: values.len(), own })
}

/// Mean length of regular runs, in samples; `None` where they are not.
fn period(changes: &[usize]) -> Option<f64> {
    let lengths: Vec<f64> = changes.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    if lengths.len() < LEAST_RUNS {
        return None;
    }
    let median = crate::statistics::median(&mut lengths.clone())?;
    let usual = || lengths.iter().filter(|length| **length <= 2.5 * median);
    let period = usual().sum::<f64>() / usual().count() as f64;
    let share = |holds: &dyn Fn(f64) -> bool| {
        lengths.iter().filter(|length| holds(**length)).count() as f64 / lengths.len() as f64
    };
    let regular = share(&|length| (length / period - 1.0).abs() <= BAND);
    let short = share(&|length| length < (1.0 - BAND) * period);
    (period >= LEAST_PERIOD && regular >= REGULAR && short <= SHORT).then_some(period)
}

/// Samples at which the sensor gave a value: each change, and once a period while the value stays.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few periods, positive")]
fn own(changes: &[usize], period: f64, samples: usize) -> Vec<usize> {
    let (Some(&first), Some(&last)) = (changes.first(), changes.last()) else { return Vec::new() };
    // Before the first change the clock of the sensor is followed backwards.
    let before = (1..).map(|k| (k as f64 * period).round() as usize).take_while(|back| *back <= first);
    let mut kept: Vec<usize> = before.map(|back| first - back).collect();
    kept.reverse();
    let ends = changes.windows(2).map(|pair| (pair[0], pair[1])).chain([(last, samples)]);
    for (start, end) in ends {
        let enough = (end - start) as f64 - (1.0 - BAND) * period;
        let again =
            (1..).map(|k| k as f64 * period).take_while(|at| *at <= enough).map(|at| start + at.round() as usize);
        kept.push(start);
        kept.extend(again);
    }
    kept
}
