//! Tests of residuals.

use crate::estimate::autocorrelation;

/// Lags a whiteness test looks at unless told otherwise.
pub(super) const DEFAULT_LAGS: usize = 25;
/// Two-sided 95 % quantile of the standard normal distribution.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Autocorrelation of a residual against what white noise would show.
#[derive(Clone, Debug, PartialEq)]
pub struct Whiteness {
    /// Autocorrelation over its value at lag zero, for lags `0..=max_lag`.
    pub autocorrelation: Vec<f64>,
    /// Half width of the 95 % band of white noise, `1.96 / sqrt(N)`.
    pub band: f64,
    /// Share of the lags from 1 on inside the band; 0.95 or more is what white noise shows.
    pub share_inside: f64,
}

/// Normalised autocorrelation of a residual up to `max_lag` samples, with its mean removed, and the 95 % band.
pub fn whiteness(residuals: &[f64], max_lag: usize) -> Whiteness {
    let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let centred: Vec<f64> = residuals.iter().map(|v| v - mean).collect();
    let correlation = autocorrelation(&centred, max_lag);
    let autocorrelation: Vec<f64> = correlation.iter().map(|value| value / correlation[0]).collect();
    let band = NORMAL_95 / (residuals.len() as f64).sqrt();
    let inside = autocorrelation[1..].iter().filter(|value| value.abs() <= band).count();
    Whiteness { share_inside: inside as f64 / max_lag.max(1) as f64, autocorrelation, band }
}

/// Normalised cross-correlation of a residual with an input of the same length at lags `-max_lag..=max_lag`: entry `k` is
/// `sum_i v_i u_{i + k - max_lag} / sqrt(sum v^2 sum u^2)`, means removed. An input that still explains the residual shows up
/// outside the band of [`whiteness`].
pub fn cross_correlation(residuals: &[f64], input: &[f64], max_lag: usize) -> Vec<f64> {
    let centred = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let (v, u) = (centred(residuals), centred(input));
    let scale = (v.iter().map(|v| v * v).sum::<f64>() * u.iter().map(|u| u * u).sum::<f64>()).sqrt();
    let product = |early: &[f64], late: &[f64], lag: usize| -> f64 {
        early.iter().zip(late.iter().skip(lag)).map(|(early, late)| early * late).sum()
    };
    let before = (1..=max_lag).rev().map(|lag| product(&u, &v, lag) / scale);
    before.chain((0..=max_lag).map(|lag| product(&v, &u, lag) / scale)).collect()
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
        // 100 lags at 95 %: fewer than 88 inside has a probability below 1 in 500.
        assert!(white.share_inside >= 0.88, "{}", white.share_inside);
        let summed: Vec<f64> = noise.windows(10).map(|window| window.iter().sum()).collect();
        let coloured = whiteness(&summed, 25);
        approx::assert_relative_eq!(coloured.autocorrelation[5], 0.5, epsilon = 0.06);
        assert!(coloured.share_inside < 0.8);
    }

    #[test]
    fn cross_correlation_finds_the_lag_of_an_input() {
        let input: Vec<f64> = (0..300).map(|k| (f64::from(k * k) * 0.01).sin()).collect();
        let mut late = vec![0.0; 4];
        late.extend_from_slice(&input[..296]);
        let correlation = cross_correlation(&late, &input, 10);
        let peak = (0..21).max_by(|&a, &b| correlation[a].total_cmp(&correlation[b])).unwrap();
        assert_eq!(peak, 10 - 4);
    }
}
