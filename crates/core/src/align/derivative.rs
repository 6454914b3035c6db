//! Band-passed derivatives on a grid, with the stretches where nothing is known.

use std::sync::Arc;

use multiversion::multiversion;

use super::{AlignError, ClockModel};
use crate::series::Series;

/// Reach of the filter to either side, in its smoothing times: beyond it its weight is 3e-4 of its greatest.
const REACH: f64 = 4.0;

/// Most steps of a grid: a day at the default step. A stray stamp must not decide how much memory is taken.
const MOST_STEPS: usize = 4_000_000;

/// Samples that are filtered together.
const BLOCK: usize = 1024;

/// A derivative sampled at whole multiples of the step, `time = index * step`.
pub(super) struct Derivative {
    /// Index of the first sample.
    pub first: i64,
    /// Values per second; zero where not known.
    pub values: Vec<f64>,
    /// Whether the filter saw samples without a gap.
    pub known: Vec<bool>,
}

/// How the derivative is taken.
#[derive(Clone, Copy)]
pub(super) struct Band {
    /// Step of the grid, s.
    pub step_s: f64,
    /// Standard deviation of the Gaussian, s.
    pub smoothing_s: f64,
    /// Longest interval that is interpolated, s.
    pub max_gap_s: f64,
}

impl Band {
    /// Samples the filter reaches to either side.
    pub fn reach(&self) -> usize {
        (REACH * self.smoothing_s / self.step_s).ceil() as usize
    }
}

/// Samples of a series that can be used: finite ones. Refuses stamps that do not increase.
pub(super) fn usable(channel: &str, series: &Series) -> Result<Series, AlignError> {
    let refuse = |reason: String| AlignError::Signal { channel: channel.to_owned(), reason };
    if series.time_s.len() != series.values.len() {
        return Err(refuse(format!("{} stamps, {} values", series.time_s.len(), series.values.len())));
    }
    let backwards =
        series.time_s.windows(2).find(|pair| pair[1].partial_cmp(&pair[0]) != Some(std::cmp::Ordering::Greater));
    if let Some(pair) = backwards {
        return Err(refuse(format!("time does not increase after {} s", pair[0])));
    }
    Ok(series.finite())
}

/// Usable samples of a channel on its own clock.
pub(super) struct Samples<'a> {
    /// Name in messages.
    channel: &'a str,
    time_s: Arc<[f64]>,
    values: Arc<[f64]>,
}

impl<'a> Samples<'a> {
    /// The finite samples of a series; refuses what [`usable`] does.
    pub(super) fn new(channel: &'a str, series: &Series) -> Result<Self, AlignError> {
        let Series { time_s, values } = usable(channel, series)?;
        Ok(Self { channel, time_s, values })
    }
}

/// Derivative of samples against the reference clock, smoothed by a Gaussian: frequency response
/// `i w exp(-w^2 s^2 / 2)`, a band pass about `1 / (2 pi s)` Hz without phase.
///
/// Samples are joined by straight lines up to the longest gap; where the filter would reach into a longer one, nothing is
/// known.
pub(super) fn derivative(samples: &Samples<'_>, clock: &ClockModel, band: &Band) -> Result<Derivative, AlignError> {
    let Samples { channel, time_s, .. } = samples;
    let still = || AlignError::Still { channel: (*channel).to_owned(), needed_s: 2.0 * REACH * band.smoothing_s };
    let (Some(start), Some(end)) = (time_s.first(), time_s.last()) else { return Err(still()) };
    let (start, end) = (clock.reference_s(*start), clock.reference_s(*end));
    let first = (start / band.step_s).ceil() as i64;
    let count = ((end / band.step_s).floor() as i64 - first + 1).max(0) as usize;
    let reach = band.reach();
    if count <= 2 * reach {
        return Err(still());
    }
    if count > MOST_STEPS {
        let reason = format!("it spans {} s, more than {MOST_STEPS} steps of {} s", end - start, band.step_s);
        return Err(AlignError::Signal { channel: (*channel).to_owned(), reason });
    }
    let (line, inside) = on_grid(samples, clock, first, count, band);
    let weights: Vec<f64> = (1..=reach)
        .map(|j| {
            let u = j as f64 * band.step_s / band.smoothing_s;
            u * (-0.5 * u * u).exp()
        })
        .collect();
    // Scaled so that a line of slope one gives one.
    let scale = 1.0 / (2.0 * weights.iter().enumerate().map(|(j, w)| w * (j + 1) as f64 * band.step_s).sum::<f64>());
    let mut missing = 0usize;
    let mut gaps_before = Vec::with_capacity(count + 1);
    gaps_before.push(0);
    for &inside in &inside {
        missing += usize::from(!inside);
        gaps_before.push(missing);
    }
    let mut result = Derivative { first, values: vec![0.0; count], known: vec![false; count] };
    for k in reach..count - reach {
        result.known[k] = gaps_before[k + reach + 1] == gaps_before[k - reach];
    }
    for (index, block) in result.values[reach..count - reach].chunks_mut(BLOCK).enumerate() {
        add_differences(block, &line, reach + index * BLOCK, &weights);
    }
    for (value, known) in result.values.iter_mut().zip(&result.known) {
        *value = if *known { scale * *value } else { 0.0 };
    }
    let energy: f64 = result.values.iter().map(|v| v * v).sum();
    if energy > 0.0 && energy.is_finite() { Ok(result) } else { Err(still()) }
}

/// Adds `sum_j w_j (line[k + j] - line[k - j])` to the values of a block that begins at `first`: weight by weight, so that the block
/// stays in the nearest cache; as wide as the processor is, and the same to the bit on every processor.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_differences(block: &mut [f64], line: &[f64], first: usize, weights: &[f64]) {
    for (j, weight) in (1..).zip(weights) {
        let pairs = line[first + j..].iter().zip(&line[first - j..]);
        for (value, (after, before)) in block.iter_mut().zip(pairs) {
            *value += weight * (after - before);
        }
    }
}

/// Straight lines between samples at the points of the grid, and whether a point lies in no gap.
fn on_grid(samples: &Samples<'_>, clock: &ClockModel, first: i64, count: usize, band: &Band) -> (Vec<f64>, Vec<bool>) {
    let Samples { time_s, values, .. } = samples;
    let mut line = Vec::with_capacity(count);
    let mut inside = Vec::with_capacity(count);
    let mut right = 1;
    let (mut before_s, mut after_s) = (clock.reference_s(time_s[0]), clock.reference_s(time_s[1]));
    for k in 0..count {
        let t = (first + k as i64) as f64 * band.step_s;
        while right + 1 < time_s.len() && after_s < t {
            right += 1;
            (before_s, after_s) = (after_s, clock.reference_s(time_s[right]));
        }
        let step = after_s - before_s;
        let fraction = (t - before_s) / step;
        line.push(values[right - 1] + fraction * (values[right] - values[right - 1]));
        inside.push(step <= band.max_gap_s);
    }
    (line, inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: Band = Band { step_s: 0.02, smoothing_s: 0.25, max_gap_s: 0.5 };

    #[test]
    fn derivative_has_the_stated_frequency_response_and_knows_its_gaps() {
        /// Relative error of the Gaussian cut at four standard deviations: the tail of its second moment is 1.1e-3 of it, that
        /// of the sine transform 4e-4.
        const CUT: f64 = 2e-3;
        let omega = 4.0;
        let time: Vec<f64> = (0..4000).map(|k| 0.01 * f64::from(k)).filter(|t| !(15.0..17.0).contains(t)).collect();
        let values: Vec<f64> = time.iter().map(|t| (omega * t).sin()).collect();
        let series = Series { time_s: time.into(), values: values.into() };
        let found = derivative(&Samples::new("sine", &series).unwrap(), &ClockModel::REFERENCE, &BAND).unwrap();
        let gain = omega * (-0.5 * (omega * BAND.smoothing_s).powi(2)).exp();
        for (k, (value, known)) in found.values.iter().zip(&found.known).enumerate() {
            let t = (found.first + k as i64) as f64 * BAND.step_s;
            assert_eq!(*known, (0.99..=13.99).contains(&t) || (18.01..=38.99).contains(&t), "{t} s");
            if *known {
                approx::assert_relative_eq!(*value, gain * (omega * t).cos(), epsilon = CUT * gain);
            }
        }
    }
}
