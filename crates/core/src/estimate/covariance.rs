//! Covariance of least-squares estimates whose residuals are coloured.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Complex, DMatrix, DVector};
use rustfft::{Fft, FftPlanner};

use super::transform_length::transform_length;
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

/// What error bars are stated with.
impl Default for Coloured {
    fn default() -> Self {
        Self { max_lag: None, taper: Taper::Parzen }
    }
}

impl Coloured {
    /// Largest lag for `all` samples, of windows of which the shortest has `shortest`.
    pub(super) fn lag_for(&self, shortest: usize, all: usize) -> Result<usize, EstimateError> {
        let max_lag = self.max_lag.unwrap_or_else(|| longest_lag(shortest, all));
        let (value, allowed) = (max_lag as f64, "less than the samples of the shortest window");
        let refused = || EstimateError::Setting { setting: "max_lag".to_owned(), value, allowed };
        if max_lag < shortest { Ok(max_lag) } else { Err(refused()) }
    }
}

/// Weight of the autocorrelation at lag `k` of `K`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taper {
    /// One, as published (Morelli and Klein, J. Guidance 20(1), 1997): a variance can come out negative.
    None,
    /// With `x = k / (K + 1)`: `1 - 6 x^2 (1 - x)` up to a half, `2 (1 - x)^3` beyond. No variance can come out negative, and short
    /// lags keep their weight (Parzen, Technometrics 3(2), 1961).
    Parzen,
}

impl Taper {
    /// Weights of the lags `0..=max_lag`.
    pub(super) fn weights(self, max_lag: usize) -> impl Iterator<Item = f64> {
        (0..=max_lag).map(move |lag| {
            let x = lag as f64 / (max_lag + 1) as f64;
            match self {
                Self::None => 1.0,
                Self::Parzen if x <= 0.5 => 1.0 - 6.0 * x * x * (1.0 - x),
                Self::Parzen => 2.0 * (1.0 - x).powi(3),
            }
        })
    }
}

/// A window as the covariance sees it: regressors, the parameter of each, the residuals of each fit.
pub(super) struct Block<'a> {
    pub(super) x: Cow<'a, DMatrix<f64>>,
    pub(super) columns: &'a [usize],
    pub(super) residuals: Vec<&'a [f64]>,
}

/// Spectra of the regressors of one window; those of real columns are mirrored, half of them says all.
pub(super) struct Spectra<'a> {
    pub(super) columns: &'a [usize],
    pub(super) length: usize,
    /// Real parts of all frequencies above the imaginary ones.
    pub(super) parts: DMatrix<f64>,
}

/// Part of the noise at some frequency below which the residual says nothing of it.
const LEAST_LEFT: f64 = 1e-3;

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

/// Covariance `D M D` with `D = (X'X)^-1` and `M = sum_{i,j} S(|i - j|) x_i x_j'`, where `S(k) = w_k R(k)` and
/// `R(k) = (1/N) sum_i v_i v_{i+k}` is the autocorrelation of the residual (Morelli and Klein 1997; Klein and Morelli,
/// "Aircraft System Identification", 5.2).
///
/// The residual has lost what the fit took of the noise, and the fit takes most where its regressors have their power: with
/// `H(k) = (1/N) sum_i (X D X')_{i, i+k}`, white noise of variance `s^2` leaves `E R(k) = s^2 (delta_k - H(k))`. With a taper, the
/// spectrum of `w_k R(k)` is therefore divided by one less that of `w_k H(k)`: exact in the mean for white noise, whose covariance is
/// then the conventional one with its `N - p`, and right for noise whose spectrum changes little over the width of the taper's. The
/// published form, without a taper, makes no such allowance.
///
/// `x` are the regressors of `fit`, samples by parameters. The sums are formed in the frequency domain: with the spectrum
/// `S(f)`, `M = (1/L) sum_f S(f) Re(conj(X(f)) X(f)')` over a length `L` that leaves `K` lags no room to wrap around.
///
/// # Errors
/// Sizes that differ, a lag beyond the shortest window, and a variance that comes out negative (use a taper or fewer
/// lags).
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
    let residuals = fits.iter().map(|fit| &*fit.residuals).collect();
    let units: Vec<Unit<'_>> = fits.iter().map(|fit| Unit::without_priors(&fit.unit_covariance)).collect();
    let block = Block { x: Cow::Borrowed(x), columns: &columns, residuals };
    coloured_covariances_of(&units, vec![block], settings, transforms)
}

/// [`coloured_covariance`] of a fit of transformed rows whose products are taken inside each of `windows` only.
pub(super) fn coloured_covariance_within(
    fit: &Fit,
    (x, residuals): (&DMatrix<f64>, &[f64]),
    windows: &[Range<usize>],
    settings: &Coloured,
) -> Result<DMatrix<f64>, EstimateError> {
    let columns: Vec<usize> = (0..x.ncols()).collect();
    let parts: Vec<DMatrix<f64>> =
        windows.iter().map(|window| x.rows(window.start, window.len()).into_owned()).collect();
    let blocks = parts.into_iter().zip(windows);
    let block = |(x, window): (_, &Range<usize>)| Block {
        x: Cow::Owned(x),
        columns: &columns,
        residuals: vec![&residuals[window.clone()]],
    };
    let blocks = blocks.map(block).collect();
    let unit = Unit::without_priors(&fit.unit_covariance);
    with_transforms(|transforms| coloured_covariances_of(&[unit], blocks, settings, transforms)).and_then(only)
}

/// The only one of a list made from one.
pub(super) fn only(mut list: Vec<DMatrix<f64>>) -> Result<DMatrix<f64>, EstimateError> {
    list.pop().ok_or(EstimateError::NoParameters)
}

/// Covariances over windows: products of residuals and of regressors are taken inside each window only. Regressors that are given away
/// are let go of once they are transformed.
pub(super) fn coloured_covariances_of(
    units: &[Unit<'_>],
    blocks: Vec<Block<'_>>,
    settings: &Coloured,
    transforms: &mut Transforms,
) -> Result<Vec<DMatrix<f64>>, EstimateError> {
    for Block { x, columns, residuals } in &blocks {
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
    let max_lag = settings.lag_for(shortest, all)?;
    let mut correlations = Vec::with_capacity(units.len());
    for pair in (0..units.len()).step_by(2) {
        let records = |fit: usize| blocks.iter().map(move |block| block.residuals.get(fit).copied().unwrap_or(&[]));
        let found = transforms.autocorrelations(records(pair).zip(records(pair + 1)), max_lag);
        correlations.extend(found.into_iter().take(units.len() - pair));
    }
    let windows: Vec<Spectra<'_>> = blocks.into_iter().map(|block| transforms.spectra(&block, max_lag)).collect();
    let mut leverages: Vec<Vec<f64>> = Vec::with_capacity(units.len());
    for (index, unit) in units.iter().enumerate() {
        let known = index.checked_sub(1).filter(|before| units[*before].covariance == unit.covariance);
        leverages.push(match known {
            _ if settings.taper == Taper::None => vec![0.0; max_lag + 1],
            Some(before) => leverages[before].clone(),
            None => transforms.leverage(unit.covariance, &windows, max_lag)?,
        });
    }
    leverages.iter_mut().flatten().for_each(|sum| *sum /= all as f64);
    for values in correlations.iter_mut().chain(&mut leverages) {
        values.iter_mut().zip(settings.taper.weights(max_lag)).for_each(|(value, weight)| *value *= weight);
    }
    let fits = units.iter().zip(correlations.iter().zip(&leverages));
    fits.map(|(unit, (correlation, leverage))| {
        let mut middle = DMatrix::zeros(unit.covariance.nrows(), unit.covariance.ncols());
        let mut noises: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for window in &windows {
            let noise = match noises.entry(window.length) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(open) => open.insert(transforms.noise(window.length, correlation, leverage)?),
            };
            add_products(window, noise, &mut middle);
        }
        sandwich(unit, middle)
    })
    .collect()
}

/// `D M D`, symmetric, without negative variances.
///
/// A prior is one more row of weight `s / deviation` whose error has the variance `s^2`, so that `D = (X'X + W)^-1` with
/// `W = diag(s^2 / deviation^2)`, and `M` grows by `s^2 W`. What white noise leaves of the residual stays `s^2 (1 - X D X')`.
pub(super) fn sandwich(
    &Unit { covariance: unit_covariance, prior_information, variance }: &Unit<'_>,
    mut middle: DMatrix<f64>,
) -> Result<DMatrix<f64>, EstimateError> {
    for (index, information) in prior_information.iter().enumerate() {
        middle[(index, index)] += variance * information;
    }
    let covariance = unit_covariance * middle * unit_covariance;
    match covariance.diagonal().iter().position(|&variance| variance < 0.0) {
        Some(index) => Err(EstimateError::Setting {
            setting: format!("coloured variance of parameter {index}"),
            value: covariance[(index, index)],
            allowed: "not negative: use a taper or fewer lags",
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
    OWN.with_borrow_mut(|transforms| {
        let result = work(transforms);
        transforms.forget_long();
        result
    })
}

/// Fourier transforms with what they need set up once: kept from fit to fit, they cost half.
#[derive(Default)]
pub struct Transforms {
    /// By length. Each is planned by itself: one planner would build a plan from those it made before, so that the last bits of a
    /// result would depend on what the thread computed earlier.
    plans: BTreeMap<usize, Arc<dyn Fft<f64>>>,
    buffer: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Transforms {
    /// Gives back what transforms of long windows took: to set them up again costs little beside them.
    fn forget_long(&mut self) {
        /// Longest transform that stays set up, 2 MB with its buffers.
        const LONGEST: usize = 1 << 16;
        if self.buffer.capacity().max(self.scratch.capacity()) > LONGEST {
            self.plans.retain(|&length, _| length <= LONGEST);
            (self.buffer, self.scratch) = (Vec::new(), Vec::new());
        }
    }

    /// Fills the buffer of `length` with zeros but for two real records, one in each part.
    pub(super) fn load(
        &mut self,
        length: usize,
        real: impl Iterator<Item = f64>,
        imaginary: impl Iterator<Item = f64>,
    ) {
        self.buffer.clear();
        self.buffer.resize(length, Complex::new(0.0, 0.0));
        self.buffer.iter_mut().zip(real).for_each(|(value, real)| value.re = real);
        self.buffer.iter_mut().zip(imaginary).for_each(|(value, imaginary)| value.im = imaginary);
    }

    /// What was loaded or transformed last.
    pub(super) fn buffer(&self) -> &[Complex<f64>] {
        &self.buffer
    }

    /// Transforms the buffer in place.
    pub(super) fn transform(&mut self) {
        let length = self.buffer.len();
        let forward = self.plans.entry(length).or_insert_with(|| FftPlanner::new().plan_fft_forward(length));
        self.scratch.resize(forward.get_inplace_scratch_len(), Complex::new(0.0, 0.0));
        forward.process_with_scratch(&mut self.buffer, &mut self.scratch);
    }

    /// Spectra at `f` of the two real records that went into the transformed buffer.
    fn pair(&self, f: usize) -> (Complex<f64>, Complex<f64>) {
        let (here, mirrored) = (self.buffer[f], self.buffer[(self.buffer.len() - f) % self.buffer.len()].conj());
        ((here + mirrored) * 0.5, (here - mirrored) * Complex::new(0.0, -0.5))
    }

    /// Autocorrelations of two fits over several windows, a pair of records each.
    pub(super) fn autocorrelations<'a>(
        &mut self,
        records: impl Iterator<Item = (&'a [f64], &'a [f64])>,
        max_lag: usize,
    ) -> [Vec<f64>; 2] {
        let mut powers = Powers::new();
        let mut samples = 0;
        for (first, second) in records {
            samples += first.len();
            let length = transform_length(first.len() + max_lag);
            self.load(length, first.iter().copied(), second.iter().copied());
            self.transform();
            for (f, power) in power_of(&mut powers, length).iter_mut().enumerate() {
                let (a, b) = self.pair(f);
                *power += Complex::new(a.norm_sqr(), b.norm_sqr());
            }
        }
        let mut sums = self.lags(&powers, max_lag);
        sums.iter_mut().flatten().for_each(|sum| *sum /= samples as f64);
        sums
    }

    /// Sums over all lengths of what two power spectra are the transforms of, for the lags `0..=max_lag`.
    fn lags(&mut self, powers: &Powers, max_lag: usize) -> [Vec<f64>; 2] {
        let mut sums = [vec![0.0; max_lag + 1], vec![0.0; max_lag + 1]];
        for (&length, power) in powers {
            let mirrored = (length / 2 + 1..length).map(|f| power[length - f]);
            self.buffer.clear();
            self.buffer.extend(power.iter().copied().chain(mirrored));
            // A power spectrum is real and even: its inverse transform is its forward transform over the length.
            self.transform();
            for (lag, value) in self.buffer.iter().take(max_lag + 1).enumerate() {
                sums[0][lag] += value.re / length as f64;
                sums[1][lag] += value.im / length as f64;
            }
        }
        sums
    }

    /// Spectra of the regressors of a window, with room for `max_lag`.
    pub(super) fn spectra<'a>(&mut self, block: &Block<'a>, max_lag: usize) -> Spectra<'a> {
        let Block { x, columns, .. } = block;
        let length = transform_length(x.nrows() + max_lag);
        let half = length / 2;
        let mut parts = DMatrix::zeros(2 * (half + 1), x.ncols());
        // Two real columns go through one complex transform.
        for first in (0..x.ncols()).step_by(2) {
            let second = x.columns(first + 1, usize::from(first + 1 < x.ncols()));
            self.load(length, x.column(first).iter().copied(), second.iter().copied());
            self.transform();
            for f in 0..=half {
                let (a, b) = self.pair(f);
                parts[(f, first)] = a.re;
                parts[(half + 1 + f, first)] = a.im;
                if second.ncols() > 0 {
                    parts[(f, first + 1)] = b.re;
                    parts[(half + 1 + f, first + 1)] = b.im;
                }
            }
        }
        Spectra { columns, length, parts }
    }

    /// `sum_i (X D X')_{i, i+k}` over all windows for the lags `k = 0..=max_lag`: with `D = L L'` of the parameters of a window that
    /// have an error, the autocorrelations of the columns of `X L`.
    pub(super) fn leverage<'a>(
        &mut self,
        covariance: &DMatrix<f64>,
        windows: impl IntoIterator<Item = &'a Spectra<'a>>,
        max_lag: usize,
    ) -> Result<Vec<f64>, EstimateError> {
        // Nothing is transformed until all powers are there.
        self.forget_long();
        let mut powers = Powers::new();
        for &Spectra { columns, length, ref parts } in windows {
            let free: Vec<usize> = (0..columns.len()).filter(|&i| covariance[(columns[i], columns[i])] > 0.0).collect();
            let own = DMatrix::from_fn(free.len(), free.len(), |i, j| covariance[(columns[free[i]], columns[free[j]])]);
            let factor = own.cholesky().ok_or_else(|| EstimateError::Setting {
                setting: "covariance of the fit".to_owned(),
                value: 0.0,
                allowed: "positive definite: leave out terms that depend on others",
            })?;
            let power = power_of(&mut powers, length);
            let mut mixed = DVector::zeros(parts.nrows());
            for (j, weights) in factor.l().column_iter().enumerate() {
                mixed.fill(0.0);
                for (&column, &weight) in free.iter().zip(weights.iter()).skip(j) {
                    mixed.axpy(weight, &parts.column(column), 1.0);
                }
                let (real, imaginary) = mixed.as_slice().split_at(power.len());
                power.iter_mut().zip(real.iter().zip(imaginary)).for_each(|(sum, (a, b))| sum.re += a * a + b * b);
            }
        }
        let [sums, _] = self.lags(&powers, max_lag);
        Ok(sums)
    }

    /// The noise's spectrum `S(f) / L` at the frequencies of `length`, twice for those that stand for two.
    pub(super) fn noise(
        &mut self,
        length: usize,
        correlation: &[f64],
        leverage: &[f64],
    ) -> Result<Vec<f64>, EstimateError> {
        let half = length / 2;
        let variance = correlation.first().copied().unwrap_or(0.0);
        let scale = if variance > 0.0 { variance } else { 1.0 };
        // Real and even records have real spectra: those of two go side by side, of one order of magnitude, as each is rounded by both.
        self.load(length, correlation.iter().map(|value| value / scale), leverage.iter().copied());
        for lag in 1..correlation.len() {
            self.buffer[length - lag] = self.buffer[lag];
        }
        self.transform();
        let mut weights = Vec::with_capacity(half + 1);
        for (f, value) in self.buffer.iter().take(half + 1).enumerate() {
            let left = left_of_noise(value.im)?;
            let both_sides = if f == 0 || 2 * f == length { 1.0 } else { 2.0 };
            weights.push(value.re * variance / left * both_sides / length as f64);
        }
        Ok(weights)
    }
}

/// Longest lag of the correlations unless one is stated: half the shortest window, a fifth of all samples at most.
pub(super) fn longest_lag(shortest: usize, all: usize) -> usize {
    (shortest / 2).min(all / 5)
}

/// Part of the noise at one frequency that the fit left in the residual, of the part it took.
pub(super) fn left_of_noise(taken: f64) -> Result<f64, EstimateError> {
    let left = 1.0 - taken;
    if left < LEAST_LEFT {
        return Err(EstimateError::Setting {
            setting: "part of the noise that the fit leaves in the residual".to_owned(),
            value: (1e3 * left).round() / 1e3,
            allowed: "above a thousandth: fewer parameters or longer windows are needed",
        });
    }
    Ok(left)
}

/// Power spectra of two records at a time, summed over the windows of each transform length.
type Powers = BTreeMap<usize, Vec<Complex<f64>>>;

/// That of `length`.
fn power_of(powers: &mut Powers, length: usize) -> &mut Vec<Complex<f64>> {
    powers.entry(length).or_insert_with(|| vec![Complex::new(0.0, 0.0); length / 2 + 1])
}

/// Adds `sum_f noise(f) Re(conj(X(f)) X(f)')` of one window to `middle`.
pub(super) fn add_products(
    &Spectra { columns, ref parts, .. }: &Spectra<'_>,
    noise: &[f64],
    middle: &mut DMatrix<f64>,
) {
    let mut weighted = DVector::zeros(parts.nrows());
    for (i, &row) in columns.iter().enumerate() {
        let entries = parts.column(i);
        let products = weighted.iter_mut().zip(entries.iter().zip(noise.iter().chain(noise)));
        products.for_each(|(value, (entry, noise))| *value = entry * noise);
        for (j, &column) in columns.iter().enumerate().take(i + 1) {
            let product = weighted.dot(&parts.column(j));
            middle[(row, column)] += product;
            if i != j {
                middle[(column, row)] += product;
            }
        }
    }
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
        let settings = Coloured { max_lag: Some(7), taper: Taper::Parzen };
        let columns = [0, 1];
        // Three fits of the same regressors: residuals go in pairs, and one is left over.
        let others: [Vec<f64>; 2] = [0.4, 1.7].map(|f| (0..90).map(|k| (f64::from(k) * f).cos()).collect());
        let all = [&others[0], &others[1], &residuals];
        let block = |x, range: std::ops::Range<usize>| Block {
            x: Cow::Borrowed(x),
            columns: &columns,
            residuals: all.iter().map(|residuals| &residuals[range.clone()]).collect(),
        };
        let blocks = vec![block(&first, 0..50), block(&second, 50..90)];
        let mut transforms = Transforms::default();
        let found =
            coloured_covariances_of(&[Unit::without_priors(&unit); 3], blocks, &settings, &mut transforms).unwrap();

        let ranges = [0..50, 50..90];
        let weight = |lag: usize| {
            let x = lag as f64 / 8.0;
            if lag <= 4 { 1.0 - 6.0 * x * x + 6.0 * x * x * x } else { 2.0 * (1.0 - x).powi(3) }
        };
        let hat = &x * &unit * x.transpose();
        for (found, residuals) in found.iter().zip(all) {
            let lagged = |product: &dyn Fn(usize, usize) -> f64| -> [f64; 8] {
                std::array::from_fn(|lag| {
                    let pairs = ranges.iter().flat_map(|range| (range.start..range.end - lag).map(|i| (i, i + lag)));
                    weight(lag) / 90.0 * pairs.map(|(i, j)| product(i, j)).sum::<f64>()
                })
            };
            let correlation = lagged(&|i, j| residuals[i] * residuals[j]);
            let leverage = lagged(&|i, j| hat[(i, j)]);
            let mut middle = DMatrix::zeros(2, 2);
            for range in &ranges {
                let length = transform_length(range.len() + 7);
                let angle = |f: usize, lag: usize| (std::f64::consts::TAU * (f * lag) as f64 / length as f64).cos();
                let spectrum =
                    |values: &[f64; 8], f| values[0] + 2.0 * (1..8).map(|lag| values[lag] * angle(f, lag)).sum::<f64>();
                let ratio: Vec<f64> =
                    (0..length).map(|f| spectrum(&correlation, f) / (1.0 - spectrum(&leverage, f))).collect();
                for (i, j) in range.clone().flat_map(|i| range.clone().map(move |j| (i, j))) {
                    let noise: f64 =
                        (0..length).map(|f| ratio[f] * angle(f, i.abs_diff(j))).sum::<f64>() / length as f64;
                    middle += x.row(i).transpose() * x.row(j) * noise;
                }
            }
            let expected = &unit * middle * &unit;
            assert!((found - &expected).amax() < ROUNDING * expected.amax());
        }
    }

    #[test]
    fn covariance_is_that_of_any_unit_of_the_measurement() {
        let names = ["a", "b", "c"].map(str::to_owned);
        let x = DMatrix::from_fn(100, 3, |row, column| (0.37 * row as f64 * column as f64).cos());
        let of = |z: &[f64]| {
            let fit = super::super::least_squares(&names, &x, z).unwrap();
            coloured_covariance(&fit, &x, &Coloured::default()).unwrap()
        };
        let z: Vec<f64> = (0..100).map(|k| (1.3 * f64::from(k)).sin() + 0.1 * f64::from(k % 7)).collect();
        let expected = of(&z);
        for unit in [1e-12, 1e-6, 1e9] {
            let found = of(&z.iter().map(|value| unit * value).collect::<Vec<_>>()) / (unit * unit);
            assert!((&found - &expected).amax() < ROUNDING * expected.amax(), "{unit}: {found} {expected}");
        }
        // What is fitted without a residual has no error.
        let exact: Vec<f64> = x.column(1).iter().copied().collect();
        assert!(of(&exact).amax() < 1e-28 && of(&[0.0; 100]).amax() == 0.0);
    }

    #[test]
    fn lag_beyond_the_window_is_rejected() {
        let x = DMatrix::from_element(10, 1, 1.0);
        let fit = super::super::least_squares(&["a".to_owned()], &x, &[1.0; 10]).unwrap();
        let settings = Coloured { max_lag: Some(10), taper: Taper::None };
        assert!(matches!(coloured_covariance(&fit, &x, &settings), Err(EstimateError::Setting { .. })));
    }
}
