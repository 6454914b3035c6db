//! Correlation against lag, and its peak between samples.

use std::ops::Range;

use multiversion::multiversion;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::derivative::{Band, Derivative};

/// Correlation of two whole signals at every lag, divided by the root of their energies: `sum_i a_i b_(i+k) / sqrt(Ea Eb)`.
pub(super) struct WholeCorrelation {
    /// Lag of the first entry, in steps of the grid: `b` shows at `i + lag` what `a` shows at `i`.
    pub first_lag: i64,
    /// Correlation by lag.
    pub values: Vec<f64>,
}

/// Correlates two derivatives by the fast Fourier transform.
pub(super) fn whole_correlation(a: &Derivative, b: &Derivative) -> WholeCorrelation {
    let length = (a.values.len() + b.values.len()).next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let spectrum = |values: &[f64]| {
        let mut buffer = vec![Complex::default(); length];
        buffer.iter_mut().zip(values).for_each(|(slot, &value)| slot.re = value);
        forward.process(&mut buffer);
        buffer
    };
    let (mut product, other) = (spectrum(&a.values), spectrum(&b.values));
    product.iter_mut().zip(&other).for_each(|(x, y)| *x = x.conj() * y);
    backward.process(&mut product);
    let energy = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let scale = 1.0 / (length as f64 * (energy(&a.values) * energy(&b.values)).sqrt());
    let before = a.values.len() - 1;
    let lags = before + b.values.len();
    let values = (0..lags).map(|k| product[(k + length - before) % length].re * scale).collect();
    WholeCorrelation { first_lag: b.first - a.first - before as i64, values }
}

/// Lag of one stretch and how sure it is.
pub(super) struct Peak {
    /// How much later `b` shows what `a` shows, s.
    pub lag_s: f64,
    /// Standard deviation of the lag from the residual and its correlation in time, s.
    pub lag_sd_s: f64,
    /// Correlation coefficient at the whole step nearest the peak.
    pub correlation: f64,
    /// Time at which the lag was seen, weighted by what it was told from, s.
    pub centre_s: f64,
}

/// Least share of a stretch that both signals must know.
const LEAST_KNOWN: f64 = 0.02;

/// Two derivatives on one grid, to be correlated stretch by stretch.
pub(super) struct Pair<'a> {
    a: &'a Derivative,
    b: &'a Derivative,
    sums: [RunningSums<'a>; 2],
    band: Band,
}

impl<'a> Pair<'a> {
    pub(super) fn new(a: &'a Derivative, b: &'a Derivative, band: Band) -> Self {
        Self { a, b, sums: [RunningSums::new(a), RunningSums::new(b)], band }
    }

    /// Best lag within `max_lag` steps either way over grid indices of `a`; `None` where too little is known, nothing moves, or
    /// the best lag is at the end of the range.
    pub(super) fn peak(&self, range: Range<i64>, max_lag: i64) -> Option<Peak> {
        let (reach, step_s) = (self.band.reach(), self.band.step_s);
        let stretch = Stretch { a: self.a, b: self.b, range };
        let correlations: Vec<f64> =
            (-max_lag..=max_lag).map(|lag| stretch.correlation(lag, reach, &self.sums)).collect();
        let best = (0..correlations.len()).max_by(|&i, &j| correlations[i].total_cmp(&correlations[j]))?;
        let (left, middle, right) =
            (*correlations.get(best.checked_sub(1)?)?, correlations[best], *correlations.get(best + 1)?);
        let curvature = left - 2.0 * middle + right;
        if middle <= 0.0 || curvature >= 0.0 {
            return None;
        }
        let lag = best as i64 - max_lag;
        let between = 0.5 * (left - right) / curvature;
        let (lag_sd_s, centre_s) = stretch.uncertainty(lag, reach, step_s)?;
        Some(Peak { lag_s: (lag as f64 + between) * step_s, lag_sd_s, correlation: middle, centre_s })
    }
}

/// Two signals over grid indices of the first.
struct Stretch<'a> {
    a: &'a Derivative,
    b: &'a Derivative,
    range: Range<i64>,
}

impl Stretch<'_> {
    /// Offsets into the values of both signals where both may have one at a lag: first of `a`, first of `b`, count.
    fn overlap(&self, lag: i64) -> (usize, usize, usize) {
        let end = |signal: &Derivative| signal.first + signal.values.len() as i64;
        let from = self.range.start.max(self.a.first).max(self.b.first - lag);
        let to = self.range.end.min(end(self.a)).min(end(self.b) - lag);
        let count = (to - from).max(0) as usize;
        if count == 0 {
            return (0, 0, 0);
        }
        ((from - self.a.first) as usize, (from + lag - self.b.first) as usize, count)
    }

    /// Correlation coefficient at a lag over what both know; -1 where that is too little.
    ///
    /// Values that are not known are zero, so that the products need no look at what is known; the other sums are differences of
    /// running ones over the stretches that both know.
    fn correlation(&self, lag: i64, reach: usize, [of_a, of_b]: &[RunningSums<'_>; 2]) -> f64 {
        let (from_a, from_b, count) = self.overlap(lag);
        let (a, b) = (from_a..from_a + count, from_b..from_b + count);
        let xy = dot(&self.a.values[a.clone()], &self.b.values[b.clone()]);
        let (mut n, mut sums) = (0.0, [0.0; 4]);
        let (mut runs_a, mut runs_b) = (of_a.runs_in(&a), of_b.runs_in(&b));
        let (mut run_a, mut run_b) = (runs_a.next(), runs_b.next());
        while let (Some(in_a), Some(in_b)) = (run_a.clone(), run_b.clone()) {
            let (from, to) = (in_a.start.max(in_b.start), in_a.end.min(in_b.end));
            if from < to {
                n += (to - from) as f64;
                let [x, xx] = of_a.between(from_a + from, from_a + to);
                let [y, yy] = of_b.between(from_b + from, from_b + to);
                sums.iter_mut().zip([x, y, xx, yy]).for_each(|(sum, term)| *sum += term);
            }
            if in_a.end <= in_b.end { run_a = runs_a.next() } else { run_b = runs_b.next() }
        }
        let needed = (LEAST_KNOWN * (self.range.end - self.range.start) as f64).max(2.0 * reach as f64);
        let [x, y, xx, yy] = sums;
        let variance = (xx - x * x / n) * (yy - y * y / n);
        if n < needed || variance.is_nan() || variance <= 0.0 { -1.0 } else { (xy - x * y / n) / variance.sqrt() }
    }

    /// Standard deviation of the lag and the time it was told at.
    ///
    /// For `b = g a + e` the lag's error is `sum(g a' e) / sum((g a')^2)`; its variance sums the products `g a' e` over all
    /// pairs of samples within the filter's reach, weighted linearly to zero (Newey and West, Econometrica 55, 1987), so
    /// that neither the grid nor coloured noise makes it too small.
    fn uncertainty(&self, lag: i64, reach: usize, step_s: f64) -> Option<(f64, f64)> {
        let (from_a, from_b, count) = self.overlap(lag);
        let known = |i: usize| self.a.known[from_a + i] && self.b.known[from_b + i];
        let (mut aa, mut ab) = (0.0, 0.0);
        for i in (0..count).filter(|&i| known(i)) {
            aa += self.a.values[from_a + i].powi(2);
            ab += self.a.values[from_a + i] * self.b.values[from_b + i];
        }
        let gain = ab / aa;
        let (mut score, mut information, mut moment) = (vec![0.0; count], 0.0, 0.0);
        for i in 1..count.saturating_sub(1) {
            if known(i - 1) && known(i) && known(i + 1) {
                let slope = gain * (self.a.values[from_a + i + 1] - self.a.values[from_a + i - 1]) / (2.0 * step_s);
                score[i] = slope * (self.b.values[from_b + i] - gain * self.a.values[from_a + i]);
                information += slope * slope;
                moment += slope * slope * (self.a.first + (from_a + i) as i64) as f64 * step_s;
            }
        }
        let reach = 2 * reach;
        let mut variance: f64 = score.iter().map(|s| s * s).sum();
        for apart in 1..=reach.min(count.saturating_sub(1)) {
            let weight = 1.0 - apart as f64 / (reach + 1) as f64;
            let products = dot(&score[..count - apart], &score[apart..]);
            variance += 2.0 * weight * products;
        }
        (information > 0.0).then(|| (variance.max(0.0).sqrt() / information, moment / information))
    }
}

/// Sums of a derivative from its start, and the stretches in which it is known.
struct RunningSums<'a> {
    values: &'a [f64],
    /// Sum and sum of squares of the values before every [`BLOCK`]th.
    sums: Vec<[f64; 2]>,
    runs: Vec<Range<usize>>,
}

/// Values between two sums that are kept: those between are added again, which costs less than their memory.
const BLOCK: usize = 32;

impl<'a> RunningSums<'a> {
    fn new(signal: &'a Derivative) -> Self {
        let mut sums = Vec::with_capacity(signal.values.len().div_ceil(BLOCK) + 1);
        let mut so_far = [0.0; 2];
        let mut runs: Vec<Range<usize>> = Vec::new();
        for (k, (&value, &known)) in signal.values.iter().zip(&signal.known).enumerate() {
            if k.is_multiple_of(BLOCK) {
                sums.push(so_far);
            }
            so_far = added(so_far, value);
            match runs.last_mut() {
                Some(run) if known && run.end == k => run.end = k + 1,
                _ if known => runs.push(k..k + 1),
                _ => {}
            }
        }
        // For an end at a multiple of the block.
        sums.push(so_far);
        Self { values: &signal.values, sums, runs }
    }

    /// Sum and sum of squares of the values before `end`.
    fn before(&self, end: usize) -> [f64; 2] {
        let block = end / BLOCK;
        self.values[block * BLOCK..end].iter().fold(self.sums[block], |sums, &value| added(sums, value))
    }

    /// Sum and sum of squares of the values `from..to`.
    fn between(&self, from: usize, to: usize) -> [f64; 2] {
        let (start, end) = (self.before(from), self.before(to));
        std::array::from_fn(|power| end[power] - start[power])
    }

    /// Known stretches inside a range, counted from its start.
    fn runs_in(&self, range: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let (start, end) = (range.start, range.end);
        let first = self.runs.partition_point(|run| run.end <= start);
        let inside = self.runs[first..].iter().take_while(move |run| run.start < end);
        inside.map(move |run| run.start.max(start) - start..run.end.min(end) - start)
    }
}

/// Sum and sum of squares with one value more.
fn added([sum, squares]: [f64; 2], value: f64) -> [f64; 2] {
    [sum + value, squares + value * value]
}

/// Sum of products in eight lanes, as wide as the processor is; the same to the bit on every processor.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (a_blocks, a_rest) = a.as_chunks::<LANES>();
    let (b_blocks, b_rest) = b.as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for (x, y) in a_blocks.iter().zip(b_blocks) {
        for lane in 0..LANES {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    lanes.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise with stretches that are not known.
    fn torn(first: i64, count: u64, seed: u64, gap: Range<u64>) -> Derivative {
        let known: Vec<bool> = (0..count).map(|k| !gap.contains(&k) && k % 97 != seed).collect();
        let noise = |k: u64| ((k + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / 16_777_216.0 - 0.3;
        let values = (0..count).zip(&known).map(|(k, &known)| if known { noise(k) } else { 0.0 }).collect();
        Derivative { first, values, known }
    }

    #[test]
    fn correlation_matches_its_definition_over_what_both_know() {
        /// Rounding of running sums over a thousand values of order one.
        const ROUNDING: f64 = 1e-12;
        let (a, b) = (torn(100, 900, 5, 200..320), torn(60, 1000, 11, 700..701));
        let stretch = Stretch { a: &a, b: &b, range: 150..950 };
        let sums = [RunningSums::new(&a), RunningSums::new(&b)];
        for lag in -150..=150 {
            let at = |signal: &Derivative, index: i64| {
                let place =
                    usize::try_from(index - signal.first).ok().filter(|&k| *signal.known.get(k).unwrap_or(&false));
                place.map(|k| signal.values[k])
            };
            let pairs: Vec<_> = (150..950).filter_map(|i| Some((at(&a, i)?, at(&b, i + lag)?))).collect();
            let n = pairs.len() as f64;
            let mean = |part: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(part).sum::<f64>() / n;
            let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
            let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
            let expected = covariance / (mean(&|p| (p.0 - x).powi(2)) * mean(&|p| (p.1 - y).powi(2))).sqrt();
            approx::assert_relative_eq!(stretch.correlation(lag, 20, &sums), expected, epsilon = ROUNDING);
        }
        assert_eq!(stretch.correlation(2000, 20, &sums), -1.0);
    }
}
