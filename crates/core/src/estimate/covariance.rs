//! Covariance of least-squares estimates whose residuals are coloured.

use std::cell::RefCell;

use nalgebra::{Complex, DMatrix, DVector};
use rustfft::FftPlanner;

use super::{EstimateError, Fit};

/// How the autocorrelation of the residual enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coloured {
    /// Largest lag in samples; `None` for a fifth of all samples, but no more than half of the shortest window: many windows bear
    /// longer lags than one, whose own autocorrelation scatters too much there.
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

/// A window as the covariance sees it: regressors, the parameter of each, the residuals of each fit.
pub(super) struct Block<'a> {
    pub(super) x: &'a DMatrix<f64>,
    pub(super) columns: &'a [usize],
    pub(super) residuals: Vec<&'a [f64]>,
}

/// A fit as the covariance sees it.
#[derive(Clone, Copy)]
pub(super) struct Unit<'a> {
    /// `D`.
    pub(super) covariance: &'a DMatrix<f64>,
    /// Information of the prior of each parameter in it, `s^2 / deviation^2`; empty where there is none.
    pub(super) prior_information: &'a [f64],
    /// `s^2`, used with priors only.
    pub(super) variance: f64,
}

impl<'a> Unit<'a> {
    /// A fit without priors.
    pub(super) fn without_priors(covariance: &'a DMatrix<f64>) -> Self {
        Self { covariance, prior_information: &[], variance: 0.0 }
    }
}

/// Covariance `c D M D` with `D = (X'X)^-1` and
/// `M = R(0) sum x_i x_i' + sum_{k=1..K} w_k R(k) sum_i (x_i x_{i+k}' + x_{i+k} x_i')`, where
/// `R(k) = (1/N) sum_i v_i v_{i+k}` is the autocorrelation of the residual (Morelli and Klein 1997; Klein and Morelli,
/// "Aircraft System Identification", 5.2).
///
/// The residual has lost what the fit took: `E[v'v] = tr(S) - tr(D X'S X)` for noise of covariance `S`, so that residuals understate
/// the noise by `1 / c = 1 - tr(D M) / v'v`. For white residuals `tr(D M) / v'v = p / N`, and the covariance is the conventional one
/// with its `N - p`; coloured ones lose more. The published form has `c = 1`.
///
/// `x` are the regressors of `fit`, samples by parameters. The sums are formed in the frequency domain: with the spectrum
/// `S` of `w_k R(k)`, `M = (1/L) sum_f S(f) Re(conj(X(f)) X(f)')` over a length `L` that leaves no room to wrap around.
///
/// # Errors
/// Sizes that differ, a lag beyond the shortest window, and a variance that comes out negative (use the triangular taper or
/// fewer lags).
pub fn coloured_covariance(fit: &Fit, x: &DMatrix<f64>, settings: &Coloured) -> Result<DMatrix<f64>, EstimateError> {
    with_transforms(|transforms| coloured_covariances(&[fit], x, settings, transforms)).and_then(only)
}

/// [`coloured_covariance`] of several fits with the same regressors, as the coefficients of one axis have: the regressors are
/// transformed once, residuals two at a time. One covariance per fit, in their order.
///
/// # Errors
/// As for [`coloured_covariance`], of the first fit that has one.
pub fn coloured_covariances(
    fits: &[&Fit],
    x: &DMatrix<f64>,
    settings: &Coloured,
    transforms: &mut Transforms,
) -> Result<Vec<DMatrix<f64>>, EstimateError> {
    let columns: Vec<usize> = (0..x.ncols()).collect();
    let residuals = fits.iter().map(|fit| fit.residuals.as_slice()).collect();
    let units: Vec<Unit<'_>> = fits.iter().map(|fit| Unit::without_priors(&fit.unit_covariance)).collect();
    coloured_covariances_of(&units, &[Block { x, columns: &columns, residuals }], settings, transforms)
}

/// The only one of a list made from one.
pub(super) fn only(mut list: Vec<DMatrix<f64>>) -> Result<DMatrix<f64>, EstimateError> {
    list.pop().ok_or(EstimateError::NoParameters)
}

/// Covariances over windows: products of residuals and of regressors are taken inside each window only.
pub(super) fn coloured_covariances_of(
    units: &[Unit<'_>],
    blocks: &[Block<'_>],
    settings: &Coloured,
    transforms: &mut Transforms,
) -> Result<Vec<DMatrix<f64>>, EstimateError> {
    for Block { x, columns, residuals } in blocks {
        for residuals in residuals {
            if x.nrows() != residuals.len() || x.ncols() != columns.len() {
                return Err(EstimateError::Size {
                    quantity: "regressors",
                    expected: residuals.len(),
                    found: x.nrows(),
                });
            }
        }
    }
    let shortest = blocks.iter().map(|block| block.x.nrows()).min().unwrap_or(0);
    let all: usize = blocks.iter().map(|block| block.x.nrows()).sum();
    let max_lag = settings.max_lag.unwrap_or((shortest / 2).min(all / 5));
    if max_lag >= shortest {
        return Err(EstimateError::Setting {
            setting: "max_lag".to_owned(),
            value: max_lag as f64,
            allowed: "less than the samples of the shortest window",
        });
    }
    let mut correlations = Vec::with_capacity(units.len());
    for pair in (0..units.len()).step_by(2) {
        let records = |fit: usize| blocks.iter().map(move |block| block.residuals.get(fit).copied().unwrap_or(&[]));
        let found = transforms.autocorrelations(records(pair).zip(records(pair + 1)), max_lag);
        correlations.extend(found.into_iter().take(units.len() - pair));
    }
    if settings.taper == Taper::Triangular {
        for (lag, value) in correlations.iter_mut().flat_map(|correlation| correlation.iter_mut().enumerate()) {
            *value *= 1.0 - lag as f64 / (max_lag + 1) as f64;
        }
    }
    let mut middles: Vec<DMatrix<f64>> =
        units.iter().map(|unit| DMatrix::zeros(unit.covariance.nrows(), unit.covariance.ncols())).collect();
    for Block { x, columns, .. } in blocks {
        let parts = transforms.weighted_products(x, &correlations);
        for (middle, part) in middles.iter_mut().zip(parts) {
            for (i, &row) in columns.iter().enumerate() {
                for (j, &column) in columns.iter().enumerate() {
                    middle[(row, column)] += part[(i, j)];
                }
            }
        }
    }
    let square = |fit: usize| blocks.iter().flat_map(|block| block.residuals[fit]).map(|v| v * v).sum();
    let fits = units.iter().zip(middles).enumerate();
    fits.map(|(fit, (unit, middle))| sandwich(unit, middle, square(fit))).collect()
}

/// `c D M D` for residuals of a given sum of squares, symmetric, without negative variances.
///
/// A prior is one more row of weight `w = s / deviation` whose error has the variance `s^2`, so that `D = (X'X + W)^-1` with
/// `W = diag(w^2)` and `M` grows by `s^2 W`. The residual has then lost `tr(D M) - s^2 tr(D W) + tr(W D (M + s^2 W) D)` of the
/// expected `tr(S)`, which for white residuals is `s^2 (p - tr(D W))`.
fn sandwich(
    &Unit { covariance: unit_covariance, prior_information, variance }: &Unit<'_>,
    mut middle: DMatrix<f64>,
    residual_square: f64,
) -> Result<DMatrix<f64>, EstimateError> {
    let mut lost = unit_covariance.component_mul(&middle).sum();
    if prior_information.iter().any(|information| *information > 0.0) {
        let told: f64 = unit_covariance.diagonal().iter().zip(prior_information).map(|(d, w)| d * w).sum();
        for (index, information) in prior_information.iter().enumerate() {
            middle[(index, index)] += variance * information;
        }
        let spread = unit_covariance * &middle * unit_covariance;
        let pulled: f64 = spread.diagonal().iter().zip(prior_information).map(|(d, w)| d * w).sum();
        lost += pulled - variance * told;
    }
    let middle = &middle;
    let understated = if residual_square > 0.0 { 1.0 - lost / residual_square } else { 1.0 };
    if understated <= 0.0 {
        return Err(EstimateError::Setting {
            setting: "residual left by the coloured covariance".to_owned(),
            value: understated,
            allowed: "above zero: fewer parameters or longer windows are needed",
        });
    }
    let covariance = unit_covariance * middle * unit_covariance / understated;
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
    autocorrelation_of_windows(std::iter::once(values), max_lag)
}

/// Autocorrelation over several records; products are taken inside each record only, `N` counts all samples.
pub(super) fn autocorrelation_of_windows<'a>(records: impl Iterator<Item = &'a [f64]>, max_lag: usize) -> Vec<f64> {
    let [first, _] =
        with_transforms(|transforms| transforms.autocorrelations(records.map(|record| (record, &[][..])), max_lag));
    first
}

/// Runs `work` with the transforms of this thread.
pub(super) fn with_transforms<R>(work: impl FnOnce(&mut Transforms) -> R) -> R {
    thread_local! {
        static OWN: RefCell<Transforms> = RefCell::default();
    }
    OWN.with_borrow_mut(work)
}

/// Fourier transforms with what they need set up once: kept from fit to fit, they cost half.
pub struct Transforms {
    planner: FftPlanner<f64>,
    buffer: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Default for Transforms {
    fn default() -> Self {
        Self { planner: FftPlanner::new(), buffer: Vec::new(), scratch: Vec::new() }
    }
}

impl Transforms {
    /// Fills the buffer of `length` with zeros but for two real records, one in each part.
    fn load(&mut self, length: usize, real: impl Iterator<Item = f64>, imaginary: impl Iterator<Item = f64>) {
        self.buffer.clear();
        self.buffer.resize(length, Complex::new(0.0, 0.0));
        self.buffer.iter_mut().zip(real).for_each(|(value, real)| value.re = real);
        self.buffer.iter_mut().zip(imaginary).for_each(|(value, imaginary)| value.im = imaginary);
    }

    /// Transforms the buffer in place.
    fn transform(&mut self) {
        let forward = self.planner.plan_fft_forward(self.buffer.len());
        self.scratch.resize(forward.get_inplace_scratch_len(), Complex::new(0.0, 0.0));
        forward.process_with_scratch(&mut self.buffer, &mut self.scratch);
    }

    /// Spectra at `f` of the two real records that went into the transformed buffer.
    fn pair(&self, f: usize) -> (Complex<f64>, Complex<f64>) {
        let (here, mirrored) = (self.buffer[f], self.buffer[(self.buffer.len() - f) % self.buffer.len()].conj());
        ((here + mirrored) * 0.5, (here - mirrored) * Complex::new(0.0, -0.5))
    }

    /// Autocorrelations of two fits over several windows, a pair of records each.
    fn autocorrelations<'a>(
        &mut self,
        records: impl Iterator<Item = (&'a [f64], &'a [f64])>,
        max_lag: usize,
    ) -> [Vec<f64>; 2] {
        let mut sums = [vec![0.0; max_lag + 1], vec![0.0; max_lag + 1]];
        let mut samples = 0;
        for (first, second) in records {
            samples += first.len();
            let length = transform_length(first.len() + max_lag);
            self.load(length, first.iter().copied(), second.iter().copied());
            self.transform();
            let half = length / 2;
            let powers: Vec<Complex<f64>> =
                (0..=half).map(|f| self.pair(f)).map(|(a, b)| Complex::new(a.norm_sqr(), b.norm_sqr())).collect();
            self.buffer[..=half].copy_from_slice(&powers);
            for f in half + 1..length {
                self.buffer[f] = powers[length - f];
            }
            // A power spectrum is real and even: its inverse transform is its forward transform over the length.
            self.transform();
            for (lag, value) in self.buffer.iter().take(max_lag + 1).enumerate() {
                sums[0][lag] += value.re / length as f64;
                sums[1][lag] += value.im / length as f64;
            }
        }
        sums.iter_mut().flatten().for_each(|sum| *sum /= samples as f64);
        sums
    }

    /// `sum_{i,j} R(|i - j|) x_i x_j'` over one window for each correlation `R`, zero beyond its last lag; all have one length.
    fn weighted_products(&mut self, x: &DMatrix<f64>, correlations: &[Vec<f64>]) -> Vec<DMatrix<f64>> {
        let lags = correlations.first().map_or(1, Vec::len);
        let length = transform_length(x.nrows() + lags - 1);
        let half = length / 2;
        // Two real columns go through one complex transform; of real columns half the spectrum says all. Real parts stand above
        // the imaginary ones.
        let mut spectra = DMatrix::zeros(2 * (half + 1), x.ncols() + x.ncols() % 2);
        for first in (0..x.ncols()).step_by(2) {
            let second = x.columns(first + 1, usize::from(first + 1 < x.ncols()));
            self.load(length, x.column(first).iter().copied(), second.iter().copied());
            self.transform();
            for f in 0..=half {
                let (a, b) = self.pair(f);
                spectra[(f, first)] = a.re;
                spectra[(half + 1 + f, first)] = a.im;
                spectra[(f, first + 1)] = b.re;
                spectra[(half + 1 + f, first + 1)] = b.im;
            }
        }
        let mut products = Vec::with_capacity(correlations.len());
        for pair in correlations.chunks(2) {
            let (first, second) = (pair[0].as_slice(), pair.get(1).map_or(&[][..], Vec::as_slice));
            self.load(length, first.iter().copied(), second.iter().copied());
            for lag in 1..lags {
                self.buffer[length - lag] = self.buffer[lag];
            }
            // Real and even records have real spectra: those of two stand side by side.
            self.transform();
            let weights = self.buffer.iter().take(half + 1).enumerate().map(|(f, value)| {
                let both_sides = if f == 0 || 2 * f == length { 1.0 } else { 2.0 };
                value * (both_sides / length as f64)
            });
            let weights: Vec<Complex<f64>> = weights.collect();
            products.push(weighted(&spectra, x.ncols(), weights.iter().map(|weight| weight.re)));
            if pair.len() > 1 {
                products.push(weighted(&spectra, x.ncols(), weights.iter().map(|weight| weight.im)));
            }
        }
        products
    }
}

/// `sum_f w(f) Re(conj(X_i(f)) X_j(f))` of all pairs of the first `count` spectra, real parts above imaginary ones.
fn weighted(spectra: &DMatrix<f64>, count: usize, weights: impl Iterator<Item = f64> + Clone) -> DMatrix<f64> {
    let mut products = DMatrix::zeros(count, count);
    let mut weighted = DVector::zeros(spectra.nrows());
    for i in 0..count {
        let entries = spectra.column(i);
        let both_parts = weights.clone().chain(weights.clone());
        weighted
            .iter_mut()
            .zip(entries.iter().zip(both_parts))
            .for_each(|(value, (entry, weight))| *value = entry * weight);
        for j in 0..=i {
            products[(i, j)] = weighted.dot(&spectra.column(j));
            products[(j, i)] = products[(i, j)];
        }
    }
    products
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
        // Three fits of the same regressors: residuals go in pairs, and one is left over.
        let others: [Vec<f64>; 2] = [0.4, 1.7].map(|f| (0..90).map(|k| (f64::from(k) * f).cos()).collect());
        let all = [&others[0], &others[1], &residuals];
        let block = |x, range: std::ops::Range<usize>| Block {
            x,
            columns: &columns,
            residuals: all.iter().map(|residuals| &residuals[range.clone()]).collect(),
        };
        let blocks = [block(&first, 0..50), block(&second, 50..90)];
        let mut transforms = Transforms::default();
        let found =
            coloured_covariances_of(&[Unit::without_priors(&unit); 3], &blocks, &settings, &mut transforms).unwrap();

        let same_window = |i: usize, j: usize| (i < 50) == (j < 50);
        let pairs =
            || (0..90).flat_map(|i: usize| (0..90).map(move |j: usize| (i, j))).filter(|&(i, j)| same_window(i, j));
        for (found, residuals) in found.iter().zip(all) {
            let mut correlation = [0.0; 8];
            for (i, j) in pairs().filter(|&(i, j)| j >= i && j - i <= 7) {
                correlation[j - i] += residuals[i] * residuals[j] / 90.0;
            }
            let mut middle = DMatrix::zeros(2, 2);
            for (i, j) in pairs().filter(|&(i, j)| i.abs_diff(j) <= 7) {
                let lag = i.abs_diff(j);
                middle += x.row(i).transpose() * x.row(j) * (correlation[lag] * (1.0 - lag as f64 / 8.0));
            }
            let square: f64 = residuals.iter().map(|v| v * v).sum();
            let expected = &unit * &middle * &unit / (1.0 - (&unit * &middle).trace() / square);
            assert!((found - &expected).amax() < ROUNDING * expected.amax());
        }
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
