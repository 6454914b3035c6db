//! Covariance of least-squares estimates whose residuals are coloured.

use nalgebra::{Complex, DMatrix};
use rustfft::FftPlanner;

use super::{EstimateError, Fit};

/// How the autocorrelation of the residual enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coloured {
    /// Largest lag in samples; `None` for a fifth of the samples of the shortest window.
    pub max_lag: Option<usize>,
    /// Weight of the lags.
    pub taper: Taper,
}

/// Weight of the autocorrelation at lag `k` of `K`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taper {
    /// One, as published (Morelli and Klein, J. Aircraft 34(2), 1997): a variance can come out negative.
    None,
    /// `1 - k / (K + 1)`: no variance can come out negative.
    Triangular,
}

/// A window as the covariance sees it: regressors, the parameter of each, residuals.
type Block<'a> = (&'a DMatrix<f64>, &'a [usize], &'a [f64]);

/// Covariance `D M D` with `D = (X'X)^-1` and
/// `M = R(0) sum x_i x_i' + sum_{k=1..K} w_k R(k) sum_i (x_i x_{i+k}' + x_{i+k} x_i')`, where
/// `R(k) = (1/N) sum_i v_i v_{i+k}` is the autocorrelation of the residual (Morelli and Klein 1997; Klein and Morelli,
/// "Aircraft System Identification", 5.2).
///
/// `x` are the regressors of `fit`, samples by parameters. The sums are formed in the frequency domain: with the spectrum
/// `S` of `w_k R(k)`, `M = (1/L) sum_f S(f) Re(conj(X(f)) X(f)')` over a length `L` that leaves no room to wrap around.
///
/// # Errors
/// Sizes that differ, a lag beyond the shortest window, and a variance that comes out negative (use the triangular taper or
/// fewer lags).
pub fn coloured_covariance(fit: &Fit, x: &DMatrix<f64>, settings: &Coloured) -> Result<DMatrix<f64>, EstimateError> {
    let columns: Vec<usize> = (0..fit.parameters()).collect();
    coloured_covariance_of(&fit.unit_covariance, &[(x, &columns, &fit.residuals)], settings)
}

/// Covariance over windows: products of residuals and of regressors are taken inside each window only.
pub(super) fn coloured_covariance_of(
    unit_covariance: &DMatrix<f64>,
    blocks: &[Block<'_>],
    settings: &Coloured,
) -> Result<DMatrix<f64>, EstimateError> {
    for (x, columns, residuals) in blocks {
        if x.nrows() != residuals.len() || x.ncols() != columns.len() {
            return Err(EstimateError::Size { quantity: "regressors", expected: residuals.len(), found: x.nrows() });
        }
    }
    let shortest = blocks.iter().map(|(_, _, residuals)| residuals.len()).min().unwrap_or(0);
    let max_lag = settings.max_lag.unwrap_or(shortest / 5);
    if max_lag >= shortest {
        return Err(EstimateError::Setting {
            setting: "max_lag".to_owned(),
            value: max_lag as f64,
            allowed: "less than the samples of the shortest window",
        });
    }
    let mut planner = FftPlanner::new();
    let mut correlation = autocorrelation_of(blocks.iter().map(|(_, _, residuals)| *residuals), max_lag, &mut planner);
    if settings.taper == Taper::Triangular {
        for (lag, value) in correlation.iter_mut().enumerate() {
            *value *= 1.0 - lag as f64 / (max_lag + 1) as f64;
        }
    }
    let mut middle = DMatrix::zeros(unit_covariance.nrows(), unit_covariance.ncols());
    for (x, columns, _) in blocks {
        let part = weighted_products(x, &correlation, &mut planner);
        for (i, &row) in columns.iter().enumerate() {
            for (j, &column) in columns.iter().enumerate() {
                middle[(row, column)] += part[(i, j)];
            }
        }
    }
    let covariance = unit_covariance * middle * unit_covariance;
    match covariance.diagonal().iter().position(|&variance| variance < 0.0) {
        Some(index) => Err(EstimateError::Setting {
            setting: format!("coloured variance of parameter {index}"),
            value: covariance[(index, index)],
            allowed: "not negative: use the triangular taper or fewer lags",
        }),
        None => Ok(0.5 * (&covariance + covariance.transpose())),
    }
}

/// Autocorrelation `R(k) = (1/N) sum_i v_i v_{i+k}` for `k = 0..=max_lag` of one uninterrupted record of `N` samples.
pub fn autocorrelation(values: &[f64], max_lag: usize) -> Vec<f64> {
    autocorrelation_of(std::iter::once(values), max_lag, &mut FftPlanner::new())
}

/// Autocorrelation over several records, products inside each only.
pub(super) fn autocorrelation_of_windows<'a>(records: impl Iterator<Item = &'a [f64]>, max_lag: usize) -> Vec<f64> {
    autocorrelation_of(records, max_lag, &mut FftPlanner::new())
}

/// Autocorrelation over several records; products are taken inside each record only, `N` counts all samples.
fn autocorrelation_of<'a>(
    records: impl Iterator<Item = &'a [f64]>,
    max_lag: usize,
    planner: &mut FftPlanner<f64>,
) -> Vec<f64> {
    let mut sums = vec![0.0; max_lag + 1];
    let mut samples = 0;
    for record in records {
        samples += record.len();
        let length = transform_length(record.len() + max_lag);
        let mut spectrum = padded(record.iter().copied(), length);
        let forward = planner.plan_fft_forward(length);
        forward.process(&mut spectrum);
        for value in &mut spectrum {
            *value = Complex::new(value.norm_sqr(), 0.0);
        }
        // A power spectrum is real and even: its inverse transform is its forward transform over the length.
        forward.process(&mut spectrum);
        for (sum, value) in sums.iter_mut().zip(&spectrum) {
            *sum += value.re / length as f64;
        }
    }
    sums.iter().map(|sum| sum / samples as f64).collect()
}

/// `sum_{i,j} R(|i - j|) x_i x_j'` over one window, `R` zero beyond its last lag.
fn weighted_products(x: &DMatrix<f64>, correlation: &[f64], planner: &mut FftPlanner<f64>) -> DMatrix<f64> {
    let length = transform_length(x.nrows() + correlation.len() - 1);
    let forward = planner.plan_fft_forward(length);
    let mut weight = padded(correlation.iter().copied(), length);
    for lag in 1..correlation.len() {
        weight[length - lag] += correlation[lag];
    }
    forward.process(&mut weight);
    // Two real columns go through one complex transform; of real columns half the spectrum says all.
    let half = length / 2;
    let mut spectra: Vec<Vec<Complex<f64>>> = Vec::with_capacity(x.ncols() + 1);
    for first in (0..x.ncols()).step_by(2) {
        let mut pair = padded(x.column(first).iter().copied(), length);
        if first + 1 < x.ncols() {
            for (value, second) in pair.iter_mut().zip(x.column(first + 1).iter()) {
                value.im = *second;
            }
        }
        forward.process(&mut pair);
        let mirrored = |f: usize| pair[(length - f) % length].conj();
        spectra.push((0..=half).map(|f| (pair[f] + mirrored(f)) * 0.5).collect());
        spectra.push((0..=half).map(|f| (pair[f] - mirrored(f)) * Complex::new(0.0, -0.5)).collect());
    }
    for (f, value) in weight.iter_mut().enumerate().take(half + 1) {
        let both_sides = if f == 0 || 2 * f == length { 1.0 } else { 2.0 };
        value.re *= both_sides / length as f64;
    }
    let mut products = DMatrix::zeros(x.ncols(), x.ncols());
    for i in 0..x.ncols() {
        for j in 0..=i {
            let pairs = spectra[i].iter().zip(&spectra[j]).zip(&weight);
            products[(i, j)] = pairs.map(|((a, b), w)| w.re * (a.re * b.re + a.im * b.im)).sum();
            products[(j, i)] = products[(i, j)];
        }
    }
    products
}

/// Values as complex numbers, followed by zeros.
fn padded(values: impl Iterator<Item = f64>, length: usize) -> Vec<Complex<f64>> {
    let mut padded: Vec<Complex<f64>> = values.map(|value| Complex::new(value, 0.0)).collect();
    padded.resize(length, Complex::new(0.0, 0.0));
    padded
}

/// Smallest length not below `samples` whose only prime factors are 2 and 3.
fn transform_length(samples: usize) -> usize {
    let mut best = samples.next_power_of_two();
    let mut threes = 3;
    while threes < best {
        let length = threes * samples.div_ceil(threes).next_power_of_two();
        best = best.min(length);
        threes *= 3;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a transform of a few hundred values of order one.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn autocorrelation_matches_its_definition() {
        let values: Vec<f64> = (0..57).map(|k| (f64::from(k) * 0.7).sin() + 0.1 * f64::from(k % 5)).collect();
        for (lag, found) in autocorrelation(&values, 20).into_iter().enumerate() {
            let expected: f64 = values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / 57.0;
            approx::assert_relative_eq!(found, expected, epsilon = ROUNDING);
        }
    }

    #[test]
    fn covariance_matches_the_double_sum_and_never_crosses_a_window() {
        let x = DMatrix::from_fn(90, 2, |row, column| if column == 0 { 1.0 } else { (row as f64 * 0.3).cos() });
        let residuals: Vec<f64> = (0..90).map(|k| (f64::from(k) * 0.9).sin() + 0.2).collect();
        let (first, second) = (x.rows(0, 50).into_owned(), x.rows(50, 40).into_owned());
        let unit = (x.transpose() * &x).try_inverse().unwrap();
        let settings = Coloured { max_lag: Some(7), taper: Taper::Triangular };
        let columns = [0, 1];
        let blocks: [Block<'_>; 2] = [(&first, &columns, &residuals[..50]), (&second, &columns, &residuals[50..])];
        let found = coloured_covariance_of(&unit, &blocks, &settings).unwrap();

        let same_window = |i: usize, j: usize| (i < 50) == (j < 50);
        let pairs =
            || (0..90).flat_map(|i: usize| (0..90).map(move |j: usize| (i, j))).filter(|&(i, j)| same_window(i, j));
        let mut correlation = [0.0; 8];
        for (i, j) in pairs().filter(|&(i, j)| j >= i && j - i <= 7) {
            correlation[j - i] += residuals[i] * residuals[j] / 90.0;
        }
        let mut middle = DMatrix::zeros(2, 2);
        for (i, j) in pairs().filter(|&(i, j)| i.abs_diff(j) <= 7) {
            let lag = i.abs_diff(j);
            middle += x.row(i).transpose() * x.row(j) * (correlation[lag] * (1.0 - lag as f64 / 8.0));
        }
        let expected = &unit * middle * &unit;
        assert!((found - &expected).amax() < ROUNDING * expected.amax());
    }

    #[test]
    fn lag_beyond_the_window_is_rejected() {
        let x = DMatrix::from_element(10, 1, 1.0);
        let fit = super::super::least_squares(&["a".to_owned()], &x, &[1.0; 10]).unwrap();
        let settings = Coloured { max_lag: Some(10), taper: Taper::None };
        assert!(matches!(coloured_covariance(&fit, &x, &settings), Err(EstimateError::Setting { .. })));
    }

    #[test]
    fn transform_length_is_smooth_and_long_enough() {
        assert_eq!(transform_length(2750), 4 * 729);
        assert_eq!(transform_length(1000), 1024);
        assert_eq!(transform_length(1), 1);
    }
}
