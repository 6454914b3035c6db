//! Test of whiteness on autocorrelations.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Probability below which a sequence does not count as white: one white sequence in twenty is refused.
pub const WHITE_LEVEL: f64 = 0.05;
/// Samples each lag of the test needs, so that its statistic has the distribution it is compared with.
const SAMPLES_PER_LAG: usize = 40;

/// Lags a test of whiteness takes of a sequence, up to `most`: one for every ten samples.
pub(crate) fn whiteness_lags(samples: usize, most: usize) -> usize {
    (samples / SAMPLES_PER_LAG).clamp(1, most.max(1))
}

/// Probability that white noise shows larger autocorrelations (Ljung and Box, Biometrika 65, 1978):
/// `Q = n (n + 2) sum r_k^2 / pairs_k` is chi-squared with one degree of freedom for each lag, `r_k` the product of samples `k`
/// apart summed over `pairs_k` pairs, over the sum of squares of all `n`. One sequence has `n - k` pairs, several fewer.
/// `lags` has `r_k` and the pairs of lag 1, 2, ...; not a number without any.
pub(crate) fn whiteness_probability(samples: usize, lags: impl IntoIterator<Item = (f64, usize)>) -> f64 {
    let n = samples as f64;
    let add = |(sum, count): (f64, usize), (r, pairs): (f64, usize)| (sum + r * r / pairs.max(1) as f64, count + 1);
    let (sum, count) = lags.into_iter().fold((0.0, 0), add);
    ChiSquared::new(count as f64).map_or(f64::NAN, |chi| chi.sf(n * (n + 2.0) * sum))
}

/// [`whiteness_probability`] of one sequence whose autocorrelation from lag 1 on is given, over up to `most` lags.
pub(crate) fn white_noise_probability(autocorrelation: &[f64], samples: usize, most: usize) -> f64 {
    let lags = autocorrelation.iter().take(whiteness_lags(samples, most)).enumerate();
    whiteness_probability(samples, lags.map(|(index, r)| (*r, samples.saturating_sub(index + 1))))
}
