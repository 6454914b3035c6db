//! Covariance of estimates from several outputs at once whose residuals are coloured and hang together.

use std::ops::Range;

use nalgebra::{Complex, DMatrix};

use super::EstimateError;
use super::covariance::{
    Block, Spectra, Taper, Transforms, Unit, left_of_noise, longest_lag, sandwich, transform_length,
};

/// One output as the covariance sees it: residuals and sensitivities of all samples in deviations of the noise, samples by
/// parameters.
pub(super) struct Output {
    pub(super) residuals: Vec<f64>,
    pub(super) sensitivities: DMatrix<f64>,
}

/// Covariance `D M D` with `D` the inverse information and `M = sum_{a,b} sum_{i,j} S_a(i)' R_ab(j - i) S_b(j)` over outputs
/// `a, b` and samples `i, j` (Morelli and Klein, J. Guidance 20(1), 1997, with the cross-correlation of the outputs' residuals
/// `R_ab(k) = (1/N) sum_i v_a(i) v_b(i + k)`: a gust moves every output of an axis at once).
///
/// As [`super::coloured_covariance`] has it for one output, lags are tapered by [`Taper::Parzen`], which leaves the matrix of the
/// spectra `S_ab(f)` without negative eigenvalues, and each output's own spectrum is divided by one less the part that the fit
/// took, cross-spectra by the root of both. Products are taken inside each of `windows` only.
///
/// # Errors
/// A window of no sample, and a fit that leaves nothing of the noise.
pub(super) fn covariance_of_outputs(
    covariance: &DMatrix<f64>,
    outputs: &[Output],
    windows: &[Range<usize>],
) -> Result<DMatrix<f64>, EstimateError> {
    let shortest = windows.iter().map(Range::len).min().unwrap_or(0);
    let all: usize = windows.iter().map(Range::len).sum();
    if shortest == 0 {
        return Err(EstimateError::NoParameters);
    }
    let max_lag = longest_lag(shortest, all);
    let columns: Vec<usize> = (0..covariance.nrows()).collect();
    let mut transforms = Transforms::default();
    let parts: Vec<Vec<DMatrix<f64>>> = outputs
        .iter()
        .map(|output| windows.iter().map(|w| output.sensitivities.rows(w.start, w.len()).into_owned()).collect())
        .collect();
    let spectra: Vec<Vec<Spectra<'_>>> = parts
        .iter()
        .map(|parts| {
            let blocks = parts.iter().map(|x| Block { x, columns: &columns, residuals: Vec::new() });
            blocks.map(|block| transforms.spectra(&block, max_lag)).collect()
        })
        .collect();
    let weights: Vec<f64> = Taper::Parzen.weights(max_lag).collect();
    let correlations = cross_correlations(&mut transforms, outputs, windows, &weights);
    let mut leverages = Vec::with_capacity(outputs.len());
    for spectra in &spectra {
        let sums = transforms.leverage(covariance, spectra, max_lag)?;
        leverages.push(sums.iter().zip(&weights).map(|(sum, weight)| weight * sum / all as f64).collect::<Vec<_>>());
    }
    let mut middle = DMatrix::zeros(covariance.nrows(), covariance.ncols());
    for (window, range) in windows.iter().enumerate() {
        let length = transform_length(range.len() + max_lag);
        let left = leverages.iter().map(|leverage| transforms.left(length, leverage)).collect::<Result<Vec<_>, _>>()?;
        for (a, row) in correlations.iter().enumerate() {
            for (offset, lags) in row.iter().enumerate() {
                let b = a + offset;
                let mut noise = transforms.cross_spectrum(length, lags);
                let scale = left[a].iter().zip(&left[b]).map(|(a, b)| (a * b).sqrt() * length as f64);
                noise.iter_mut().zip(scale).for_each(|(value, scale)| *value /= scale);
                let twice = if a == b { 1.0 } else { 2.0 };
                add_cross_products((&spectra[a][window], &spectra[b][window]), &noise, twice, &mut middle);
            }
        }
    }
    let middle = 0.5 * (&middle + middle.transpose());
    sandwich(&Unit::without_priors(covariance), middle)
}

/// `w_k R_ab(k)` for the lags `-K..=K` of each output `a` with itself and those after it.
fn cross_correlations(
    transforms: &mut Transforms,
    outputs: &[Output],
    windows: &[Range<usize>],
    weights: &[f64],
) -> Vec<Vec<Vec<f64>>> {
    let max_lag = weights.len() - 1;
    let all: usize = windows.iter().map(Range::len).sum();
    let records: Vec<Vec<Vec<Complex<f64>>>> = outputs
        .iter()
        .map(|output| {
            let of_window = |w: &Range<usize>| {
                transforms.spectrum(transform_length(w.len() + max_lag), output.residuals[w.clone()].iter().copied())
            };
            windows.iter().map(of_window).collect()
        })
        .collect();
    let mut between = |a: usize, b: usize| {
        let mut lags = vec![0.0; 2 * max_lag + 1];
        for (first, second) in records[a].iter().zip(&records[b]) {
            let products = first.iter().zip(second).map(|(a, b)| a.conj() * b);
            transforms.add_lags(products, &mut lags);
        }
        let both_sides = weights.iter().skip(1).rev().chain(weights);
        lags.iter_mut().zip(both_sides).for_each(|(lag, weight)| *lag *= weight / all as f64);
        lags
    };
    (0..outputs.len()).map(|a| (a..outputs.len()).map(|b| between(a, b)).collect()).collect()
}

/// Adds `twice Re sum_f conj(X_a(f)) conj(S_ab(f)) X_b(f)'` of one window to `middle`, all frequencies counted.
fn add_cross_products(
    (a, b): (&Spectra<'_>, &Spectra<'_>),
    noise: &[Complex<f64>],
    twice: f64,
    middle: &mut DMatrix<f64>,
) {
    let half = a.length / 2;
    let value =
        |parts: &DMatrix<f64>, f: usize, column: usize| Complex::new(parts[(f, column)], parts[(half + 1 + f, column)]);
    let mut weighted = vec![Complex::new(0.0, 0.0); half + 1];
    for &column in b.columns {
        for (f, product) in weighted.iter_mut().enumerate() {
            let both_sides = if f == 0 || 2 * f == a.length { 1.0 } else { 2.0 };
            *product = noise[f].conj() * value(&b.parts, f, column) * (both_sides * twice);
        }
        for &row in a.columns {
            let sum: f64 = weighted.iter().enumerate().map(|(f, w)| (value(&a.parts, f, row).conj() * w).re).sum();
            middle[(row, column)] += sum;
        }
    }
}

impl Transforms {
    /// Spectrum of one real record, padded to `length`.
    fn spectrum(&mut self, length: usize, values: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
        self.load(length, values, std::iter::empty());
        self.transform();
        self.buffer().to_vec()
    }

    /// Adds what a spectrum is the transform of to `lags`, which begin at the most negative.
    fn add_lags(&mut self, spectrum: impl Iterator<Item = Complex<f64>>, lags: &mut [f64]) {
        // The inverse transform is the conjugate of the transform of the conjugate over the length.
        let values: Vec<Complex<f64>> = spectrum.map(|value| value.conj()).collect();
        let (length, max_lag) = (values.len(), lags.len() / 2);
        self.load(length, values.iter().map(|value| value.re), values.iter().map(|value| value.im));
        self.transform();
        for (place, lag) in lags.iter_mut().enumerate() {
            *lag += self.buffer()[(place + length - max_lag) % length].re / length as f64;
        }
    }

    /// `sum_k R(k) exp(-i 2 pi f k / length)` of lags that begin at the most negative, up to half the length.
    fn cross_spectrum(&mut self, length: usize, lags: &[f64]) -> Vec<Complex<f64>> {
        let max_lag = lags.len() / 2;
        let mut record = vec![0.0; length];
        for (place, lag) in lags.iter().enumerate() {
            record[(place + length - max_lag) % length] += lag;
        }
        let mut all = self.spectrum(length, record.into_iter());
        all.truncate(length / 2 + 1);
        all
    }

    /// One less the part of the noise that the fit took, by frequency up to half of `length`.
    fn left(&mut self, length: usize, leverage: &[f64]) -> Result<Vec<f64>, EstimateError> {
        let both_sides: Vec<f64> = leverage.iter().skip(1).rev().chain(leverage).copied().collect();
        let taken = self.cross_spectrum(length, &both_sides);
        taken.into_iter().map(|taken| left_of_noise(taken.re)).collect()
    }
}
