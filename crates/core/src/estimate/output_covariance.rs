//! Covariance of estimates from several outputs at once whose residuals are coloured and hang together.

use std::borrow::Cow;

use nalgebra::{Complex, DMatrix};

use super::covariance::{
    Block, Spectra, Taper, Transforms, Unit, left_of_noise, longest_lag, sandwich, with_transforms,
};
use super::transform_length::transform_length;
use super::{EstimateError, PooledFit, PooledWindow};

/// One output in one window: sensitivities, samples by parameters, the parameter of each column, and the residuals. Of output error both
/// are in deviations of the noise.
pub(super) struct OutputWindow<'a> {
    pub(super) sensitivities: &'a DMatrix<f64>,
    pub(super) columns: &'a [usize],
    pub(super) residuals: &'a [f64],
}

/// The windows of one output in the order all outputs have them; `None` where it has no part in one.
pub(super) type Output<'a> = Vec<Option<OutputWindow<'a>>>;

/// Covariance of the parameters of several pooled fits, one coefficient each, within and across them, in their order: the sandwich of
/// [`super::coloured_covariance`] with the cross-correlation of the residuals in the windows that two fits share. Forces and moments
/// that a model lacks, a gust's for example, enter several coefficients at once, and so do the errors of their regressors; a
/// function of derivatives of several coefficients, as a natural mode is, needs what they have in common.
///
/// Its blocks on the diagonal are [`PooledFit::coloured_covariance`] but for the longest lag, which all fits have in common here.
pub fn joint_coloured_covariance(fits: &[(&PooledFit, &[PooledWindow])]) -> Result<DMatrix<f64>, EstimateError> {
    let mut labels: Vec<&str> = Vec::new();
    for window in fits.iter().flat_map(|(_, windows)| *windows) {
        if !labels.contains(&window.label.as_str()) {
            labels.push(&window.label);
        }
    }
    let size = fits.iter().map(|(fit, _)| fit.prior_information.len()).sum();
    let mut unit = DMatrix::zeros(size, size);
    let mut prior_information = Vec::with_capacity(size);
    let mut columns: Vec<Vec<Vec<usize>>> = Vec::with_capacity(fits.len());
    for (PooledFit { fit, parameters, prior_information: own, .. }, _) in fits {
        let start = prior_information.len();
        unit.view_mut((start, start), fit.unit_covariance.shape()).copy_from(&fit.unit_covariance);
        prior_information.extend(own.iter().map(|information| fit.residual_std.powi(2) * information));
        columns.push(parameters.iter().map(|of| of.iter().map(|column| start + column).collect()).collect());
    }
    let mut outputs: Vec<Output<'_>> = Vec::with_capacity(fits.len());
    for ((fit, windows), columns) in fits.iter().zip(&columns) {
        let window = |place: usize| OutputWindow {
            sensitivities: &windows[place].x,
            columns: &columns[place],
            residuals: &fit.fit.residuals[fit.samples[place].clone()],
        };
        let place = |label: &&str| windows.iter().position(|window| window.label == *label);
        outputs.push(labels.iter().map(|label| place(label).map(window)).collect());
    }
    let unit = Unit { covariance: &unit, prior_information: &prior_information, variance: 1.0 };
    covariance_of_outputs(&unit, &outputs)
}

/// Covariance `D M D` with `D` the inverse information and `M = sum_{a,b} sum_{i,j} S_a(i)' R_ab(j - i) S_b(j)` over outputs
/// `a, b` and samples `i, j` (Morelli and Klein, J. Guidance 20(1), 1997, with the cross-correlation of the outputs' residuals
/// `R_ab(k) = (1/N) sum_i v_a(i) v_b(i + k)`: a gust moves every output of an axis at once).
///
/// As [`super::coloured_covariance`] has it for one output, lags are tapered by [`Taper::Parzen`], which leaves the matrix of the
/// spectra `S_ab(f)` without negative eigenvalues, and each output's own spectrum is divided by one less the part that the fit
/// took, cross-spectra by the root of both. Products are taken inside each window only, `N` counts the samples of the windows that
/// both outputs have.
///
/// # Errors
/// A window of no sample, and a fit that leaves nothing of the noise.
pub(super) fn covariance_of_outputs(unit: &Unit<'_>, outputs: &[Output<'_>]) -> Result<DMatrix<f64>, EstimateError> {
    with_transforms(|transforms| Joint::new(unit.covariance, outputs, transforms)?.middle(transforms))
        .and_then(|middle| sandwich(unit, 0.5 * (&middle + middle.transpose())))
}

/// Spectra of all outputs, and what their fits took of the noise.
struct Joint<'a> {
    size: usize,
    max_lag: usize,
    /// Samples of each window.
    lengths: Vec<usize>,
    /// Of each output in each window.
    spectra: Vec<Vec<Option<Spectra<'a>>>>,
    /// `w_k H(k)` of each output.
    leverages: Vec<Vec<f64>>,
    /// `w_k R_ab(k)` for the lags `-K..=K` of each output `a` with itself and those after it.
    correlations: Vec<Vec<Vec<f64>>>,
}

impl<'a> Joint<'a> {
    fn new(
        covariance: &DMatrix<f64>,
        outputs: &[Output<'a>],
        transforms: &mut Transforms,
    ) -> Result<Self, EstimateError> {
        let count = outputs.iter().map(Vec::len).max().unwrap_or(0);
        let samples = |window: usize| {
            outputs.iter().find_map(|output| output.get(window)?.as_ref()).map_or(0, |of| of.residuals.len())
        };
        let lengths: Vec<usize> = (0..count).map(samples).collect();
        let shortest = lengths.iter().copied().min().unwrap_or(0);
        if shortest == 0 {
            return Err(EstimateError::NoParameters);
        }
        for window in outputs.iter().flat_map(|output| output.iter().zip(&lengths)) {
            let (Some(OutputWindow { sensitivities, residuals, .. }), &expected) = window else { continue };
            if sensitivities.nrows() != expected || residuals.len() != expected {
                let found = residuals.len();
                return Err(EstimateError::Size { quantity: "samples of a manoeuvre", expected, found });
            }
        }
        let max_lag = longest_lag(shortest, lengths.iter().sum());
        let spectra: Vec<Vec<_>> = outputs
            .iter()
            .map(|output| {
                let mut spectra = |window: &OutputWindow<'a>| {
                    let OutputWindow { sensitivities: x, columns, .. } = *window;
                    transforms.spectra(&Block { x: Cow::Borrowed(x), columns, residuals: Vec::new() }, max_lag)
                };
                output.iter().map(|window| window.as_ref().map(&mut spectra)).collect()
            })
            .collect();
        let weights: Vec<f64> = Taper::Parzen.weights(max_lag).collect();
        let mut leverages = Vec::with_capacity(outputs.len());
        for (output, spectra) in outputs.iter().zip(&spectra) {
            let sums = transforms.leverage(covariance, spectra.iter().flatten(), max_lag)?;
            let all = common_samples(output, output) as f64;
            leverages.push(sums.iter().zip(&weights).map(|(sum, weight)| weight * sum / all).collect());
        }
        let correlations = cross_correlations(transforms, outputs, &weights);
        Ok(Self { size: covariance.nrows(), max_lag, lengths, spectra, leverages, correlations })
    }

    /// `M`, not yet made symmetric.
    fn middle(&self, transforms: &mut Transforms) -> Result<DMatrix<f64>, EstimateError> {
        let mut middle = DMatrix::zeros(self.size, self.size);
        for (window, samples) in self.lengths.iter().enumerate() {
            let length = transform_length(samples + self.max_lag);
            let left = self.leverages.iter().map(|leverage| transforms.left(length, leverage));
            let left = left.collect::<Result<Vec<_>, _>>()?;
            for (a, row) in self.correlations.iter().enumerate() {
                for (offset, lags) in row.iter().enumerate() {
                    let b = a + offset;
                    let (Some(first), Some(second)) = (&self.spectra[a][window], &self.spectra[b][window]) else {
                        continue;
                    };
                    let mut noise = transforms.cross_spectrum(length, lags);
                    let scale = left[a].iter().zip(&left[b]).map(|(a, b)| (a * b).sqrt() * length as f64);
                    noise.iter_mut().zip(scale).for_each(|(value, scale)| *value /= scale);
                    let twice = if a == b { 1.0 } else { 2.0 };
                    add_cross_products((first, second), &noise, twice, &mut middle);
                }
            }
        }
        Ok(middle)
    }
}

/// Samples of the windows that both outputs have.
fn common_samples(a: &Output<'_>, b: &Output<'_>) -> usize {
    a.iter().zip(b).filter_map(|(a, b)| Some(a.as_ref()?.residuals.len().min(b.as_ref()?.residuals.len()))).sum()
}

/// `w_k R_ab(k)` for the lags `-K..=K` of each output `a` with itself and those after it.
fn cross_correlations(transforms: &mut Transforms, outputs: &[Output<'_>], weights: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let max_lag = weights.len() - 1;
    let mut spectrum = |window: &OutputWindow<'_>| {
        let length = transform_length(window.residuals.len() + max_lag);
        transforms.spectrum(length, window.residuals.iter().copied())
    };
    let records: Vec<Vec<Option<Vec<Complex<f64>>>>> =
        outputs.iter().map(|output| output.iter().map(|window| window.as_ref().map(&mut spectrum)).collect()).collect();
    let mut between = |a: usize, b: usize| {
        let mut lags = vec![0.0; 2 * max_lag + 1];
        for (first, second) in records[a].iter().zip(&records[b]) {
            let (Some(first), Some(second)) = (first, second) else { continue };
            let products = first.iter().zip(second).map(|(a, b)| a.conj() * b);
            transforms.add_lags(products, &mut lags);
        }
        let common = common_samples(&outputs[a], &outputs[b]).max(1) as f64;
        let both_sides = weights.iter().skip(1).rev().chain(weights);
        lags.iter_mut().zip(both_sides).for_each(|(lag, weight)| *lag *= weight / common);
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
    for (place, &column) in b.columns.iter().enumerate() {
        for (f, product) in weighted.iter_mut().enumerate() {
            let both_sides = if f == 0 || 2 * f == a.length { 1.0 } else { 2.0 };
            *product = noise[f].conj() * value(&b.parts, f, place) * (both_sides * twice);
        }
        for (place, &row) in a.columns.iter().enumerate() {
            let sum: f64 = weighted.iter().enumerate().map(|(f, w)| (value(&a.parts, f, place).conj() * w).re).sum();
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
