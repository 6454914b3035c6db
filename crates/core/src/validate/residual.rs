//! Tests of residuals.

use crate::estimate::autocorrelation;
use crate::prep::{WHITE_LEVEL, white_noise_probability};
use crate::statistics::NORMAL_95;

/// Lags a whiteness test looks at unless told otherwise.
pub(super) const DEFAULT_LAGS: usize = 25;
/// Autocorrelation of a residual against what white noise would show.
#[derive(Clone, Debug, PartialEq)]
pub struct Whiteness {
    /// Autocorrelation over its value at lag zero, for lags `0..=max_lag`.
    pub autocorrelation: Vec<f64>,
    /// Half width of the 95 % band of white noise, `1.96 / sqrt(N)`.
    pub band: f64,
    /// Probability that a white residual is as correlated (Ljung and Box).
    pub probability: f64,
}

impl Whiteness {
    /// Whether the residual counts as white: one that is white does in 95 % of cases.
    pub fn is_white(&self) -> bool {
        self.probability >= WHITE_LEVEL
    }
}

/// Normalised autocorrelation of a residual up to `max_lag` samples, with its mean removed, and the 95 % band.
pub fn whiteness(residuals: &[f64], max_lag: usize) -> Whiteness {
    let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let centred: Vec<f64> = residuals.iter().map(|v| v - mean).collect();
    let correlation = autocorrelation(&centred, max_lag);
    let autocorrelation: Vec<f64> = correlation.iter().map(|value| value / correlation[0]).collect();
    let band = NORMAL_95 / (residuals.len() as f64).sqrt();
    let probability = white_noise_probability(&autocorrelation[1..], residuals.len(), max_lag);
    Whiteness { autocorrelation, band, probability }
}

/// How often residuals of each size occur.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Left end of the first bin.
    pub left: f64,
    /// Width of a bin.
    pub width: f64,
    /// Residuals in each bin.
    pub counts: Vec<usize>,
    /// Count a normal distribution of the same mean and standard deviation has in each bin, by its density at the middle.
    pub normal: Vec<f64>,
}

/// Histogram of values in `bins` equal bins from the smallest to the largest; the last bin holds its right end.
pub fn histogram(values: &[f64], bins: usize) -> Histogram {
    let count = values.len() as f64;
    let left = values.iter().copied().fold(f64::INFINITY, f64::min);
    let right = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = if right > left { (right - left) / bins as f64 } else { 1.0 };
    let mut counts = vec![0; bins];
    for value in values {
        counts[(((value - left) / width) as usize).min(bins - 1)] += 1;
    }
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    let density = |x: f64| (-0.5 * (x - mean).powi(2) / variance).exp() / (std::f64::consts::TAU * variance).sqrt();
    let normal = (0..bins).map(|bin| count * width * density(left + (bin as f64 + 0.5) * width)).collect();
    Histogram { left, width, counts, normal }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn white_noise_stays_inside_the_band_and_a_moving_sum_does_not() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let noise: Vec<f64> = (0..4000).map(|_| rng.random::<f64>() - 0.5).collect();
        let white = whiteness(&noise, 100);
        approx::assert_relative_eq!(white.band, 1.96 / 4000.0_f64.sqrt(), max_relative = 1e-4);
        let inside = white.autocorrelation[1..].iter().filter(|value| value.abs() <= white.band).count();
        // 100 lags at 95 %: fewer than 88 inside has a probability below 1 in 500.
        assert!(inside >= 88 && white.is_white(), "{inside} inside, {}", white.probability);
        let summed: Vec<f64> = noise.windows(10).map(|window| window.iter().sum()).collect();
        let coloured = whiteness(&summed, 25);
        approx::assert_relative_eq!(coloured.autocorrelation[5], 0.5, epsilon = 0.06);
        assert!(coloured.probability < 1e-6);
    }

    #[test]
    fn histogram_counts_every_value_and_a_normal_sample_follows_its_normal_curve() {
        let found = histogram(&[0.0, 0.1, 0.9, 1.0, 2.0], 2);
        assert_eq!((found.left, found.width, found.counts), (0.0, 1.0, vec![3, 2]));
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let normal: Vec<f64> = (0..20_000).map(|_| (0..12).map(|_| rng.random::<f64>() - 0.5).sum()).collect();
        let found = histogram(&normal, 21);
        assert_eq!(found.counts.iter().sum::<usize>(), 20_000);
        for (count, expected) in found.counts.iter().zip(&found.normal).filter(|(_, expected)| **expected > 400.0) {
            // Five standard deviations of a count.
            assert!((*count as f64 - expected).abs() < 5.0 * expected.sqrt(), "{count} and {expected}");
        }
    }
}
