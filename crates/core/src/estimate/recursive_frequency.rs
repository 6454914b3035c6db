//! Equation error in the frequency domain as samples come: the recursive Fourier transform.

use nalgebra::{Complex, DMatrix};

use super::frequency::{Detrend, FrequencySettings, grid, integral_of_sum, regress};
use super::{EstimateError, Fit};

/// Finite Fourier transforms of several columns over a grid of frequencies, a sample at a time, with exponential forgetting.
///
/// `X_i(w) = lambda X_{i-1}(w) + x_i e^(-j w i h)` (Morelli, "Real-time parameter estimation in the frequency domain", J. Guidance
/// 23(5), 2000), and the same of the constant 1 and of the ramp i, so that mean or ends are taken off the transforms, not off samples
/// that are gone. Without forgetting, `lambda = 1`, the transforms are those of [`super::finite_fourier_transform`] over all samples so
/// far, and the fit is that of [`super::frequency_equation_error`].
#[derive(Clone, Debug)]
pub struct RecursiveFourier {
    settings: FrequencySettings,
    step_s: f64,
    /// Forgetting factor of one step.
    factor: f64,
    omega_rad_s: Vec<f64>,
    columns: Vec<Column>,
    /// Transform of the constant 1.
    one: Column,
    /// Transform of the index of the sample.
    ramp: Column,
    /// Index of the next sample.
    next: u64,
    /// Index of the first and of the last sample there was.
    span: Option<(u64, u64)>,
    /// Weight of the first sample by now.
    first_weight: f64,
    /// Sums of the weights, of their squares and of their fourth powers.
    weights: [f64; 3],
}

/// Sums of one column.
#[derive(Clone, Debug)]
struct Column {
    sums: Vec<Complex<f64>>,
    /// Weighted sum of the values.
    total: f64,
    first: f64,
    last: f64,
}

impl Column {
    fn new(frequencies: usize) -> Self {
        Self { sums: vec![Complex::new(0.0, 0.0); frequencies], total: 0.0, first: 0.0, last: 0.0 }
    }

    fn push(&mut self, value: f64, turns: &[Complex<f64>], factor: f64, is_first: bool) {
        for (sum, turn) in self.sums.iter_mut().zip(turns) {
            *sum = *sum * factor + turn * value;
        }
        self.total = self.total * factor + value;
        self.last = value;
        if is_first {
            self.first = value;
        }
    }

    fn fade(&mut self, factor: f64) {
        self.sums.iter_mut().for_each(|sum| *sum *= factor);
        self.total *= factor;
    }
}

impl RecursiveFourier {
    /// Transforms of `columns` columns of samples `step_s` apart, before the first; `forgetting_s` is the time after which a sample
    /// counts 1/e, none where all count alike.
    ///
    /// # Errors
    /// A grid that is empty or reaches beyond half the sampling frequency; a forgetting time that is not positive; forgetting where the
    /// line through both ends is to be taken off, as the first end fades.
    pub fn new(
        columns: usize,
        step_s: f64,
        settings: &FrequencySettings,
        forgetting_s: Option<f64>,
    ) -> Result<Self, EstimateError> {
        let omega_rad_s = grid(settings, std::iter::once(step_s))?;
        let refuse = |value, allowed| EstimateError::Setting { setting: "forgetting_s".to_owned(), value, allowed };
        let factor = match forgetting_s {
            None => 1.0,
            Some(time_s) if time_s.is_nan() || time_s <= step_s => return Err(refuse(time_s, "longer than a step")),
            Some(time_s) if settings.detrend == Detrend::Ends => {
                return Err(refuse(time_s, "none while the line through both ends is taken off: take the mean off"));
            }
            Some(time_s) => (-step_s / time_s).exp(),
        };
        let column = Column::new(omega_rad_s.len());
        Ok(Self {
            settings: *settings,
            step_s,
            factor,
            columns: vec![column.clone(); columns],
            one: column.clone(),
            ramp: column,
            omega_rad_s,
            next: 0,
            span: None,
            first_weight: 1.0,
            weights: [0.0; 3],
        })
    }

    /// Takes in one sample of every column. One with a value that is not finite is left out.
    pub fn push(&mut self, values: &[f64]) {
        if values.len() != self.columns.len() || values.iter().any(|value| !value.is_finite()) {
            return self.skip(1);
        }
        let index = self.next as f64;
        let turns: Vec<Complex<f64>> =
            self.omega_rad_s.iter().map(|omega| Complex::from_polar(1.0, -omega * self.step_s * index)).collect();
        let is_first = self.span.is_none();
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(*value, &turns, self.factor, is_first);
        }
        self.one.push(1.0, &turns, self.factor, is_first);
        self.ramp.push(index, &turns, self.factor, is_first);
        self.first_weight = if is_first { 1.0 } else { self.first_weight * self.factor };
        self.fade_weights(self.factor);
        self.weights.iter_mut().for_each(|sum| *sum += 1.0);
        self.span = Some((self.span.map_or(self.next, |(first, _)| first), self.next));
        self.next += 1;
    }

    /// Lets time go on over samples that are missing: the regression holds over what is left.
    pub fn skip(&mut self, samples: u64) {
        self.next += samples;
        #[expect(clippy::cast_possible_truncation, reason = "a factor this small is zero long before")]
        let factor = self.factor.powi(samples.min(i32::MAX as u64) as i32);
        let kept = self.columns.iter_mut().chain([&mut self.one, &mut self.ramp]);
        kept.for_each(|column| column.fade(factor));
        self.first_weight *= factor;
        self.fade_weights(factor);
    }

    fn fade_weights(&mut self, factor: f64) {
        for (sum, power) in self.weights.iter_mut().zip([1, 2, 4]) {
            *sum *= factor.powi(power);
        }
    }

    /// Time that the samples stand for in the error bars, s: their number where all count alike, `(sum w^2)^2 / sum w^4` where they fade,
    /// since the fit weighs each by the square of its weight.
    pub(crate) fn effective_length_s(&self) -> f64 {
        let [_, square, fourth] = self.weights;
        if fourth > 0.0 { square * square / fourth * self.step_s } else { 0.0 }
    }

    /// What the covariance of the fit is to be multiplied by to be that of the estimates. A grid finer than the inverse of the effective
    /// length `T` repeats what it says, `1 / (step T)` times where that is above one; and the variance of the residual is that of both
    /// parts of a frequency together, each of which is a row: a half.
    pub fn covariance_factor(&self) -> f64 {
        0.5 * (1.0 / (self.settings.step_hz * self.effective_length_s())).max(1.0)
    }

    /// Correlation of columns over the grid, `Re(X_i* X_j) / (|X_i| |X_j|)`; zero of a column that does not move.
    pub fn correlation(&self, columns: &[usize]) -> DMatrix<f64> {
        let parts: Vec<Vec<f64>> = columns.iter().map(|column| self.transform(*column)).collect();
        let product = |i: usize, j: usize| parts[i].iter().zip(&parts[j]).map(|(a, b)| a * b).sum::<f64>();
        let norms: Vec<f64> = (0..parts.len()).map(|k| product(k, k).sqrt()).collect();
        DMatrix::from_fn(parts.len(), parts.len(), |i, j| match norms[i] * norms[j] {
            _ if i == j => 1.0,
            norm if norm > 0.0 => product(i, j) / norm,
            _ => 0.0,
        })
    }

    /// Finite Fourier transform of a column without its trend, real above imaginary parts.
    fn transform(&self, column: usize) -> Vec<f64> {
        let Some(((first, last), column)) = self.span.zip(self.columns.get(column)) else { return Vec::new() };
        // The trend: level + slope * (index - index of the first).
        let (level, slope) = match self.settings.detrend {
            Detrend::Mean => (column.total / self.weights[0], 0.0),
            Detrend::Ends => (column.first, (column.last - column.first) / (last - first).max(1) as f64),
        };
        let level_at_zero = level - slope * first as f64;
        let rest = |value: f64, index: u64| value - level_at_zero - slope * index as f64;
        let ends = (rest(column.first, first) * self.first_weight, rest(column.last, last));
        let mut parts = vec![0.0; 2 * self.omega_rad_s.len()];
        for (k, &omega) in self.omega_rad_s.iter().enumerate() {
            let sum = column.sums[k] - self.one.sums[k] * level_at_zero - self.ramp.sums[k] * slope;
            let at = |value: f64, index: u64| Complex::from_polar(value, -omega * self.step_s * index as f64);
            let transform = integral_of_sum(sum, (at(ends.0, first), at(ends.1, last)), self.step_s, omega);
            parts[k] = transform.re;
            parts[self.omega_rad_s.len() + k] = transform.im;
        }
        parts
    }

    /// Equation error with the samples so far: column `z` by the columns `x`, whose parameters are called `names`. The covariance is as
    /// for [`super::frequency_equation_error`], to be multiplied by [`Self::covariance_factor`].
    pub fn fit(&self, names: &[String], z: usize, x: &[usize]) -> Result<Fit, EstimateError> {
        self.fit_of(&|column| self.transform(column), names, z, x)
    }

    /// The fits of several measurements, each its names, its column and those of its regressors; every column is transformed once.
    pub fn fits(&self, models: &[(&[String], usize, &[usize])]) -> Vec<Result<Fit, EstimateError>> {
        let transforms: Vec<Vec<f64>> = (0..self.columns.len()).map(|column| self.transform(column)).collect();
        let transform = |column: usize| transforms.get(column).cloned().unwrap_or_default();
        models.iter().map(|(names, z, x)| self.fit_of(&transform, names, *z, x)).collect()
    }

    fn fit_of(
        &self,
        transform: &dyn Fn(usize) -> Vec<f64>,
        names: &[String],
        z: usize,
        x: &[usize],
    ) -> Result<Fit, EstimateError> {
        if self.span.is_none() {
            return Err(EstimateError::TooFewSamples { samples: 0, parameters: names.len() });
        }
        let columns: Vec<_> = x.iter().map(|column| nalgebra::DVector::from_vec(transform(*column))).collect();
        let z = transform(z);
        if columns.is_empty() || columns.iter().any(|column| column.len() != z.len()) {
            return Err(EstimateError::NoParameters);
        }
        regress(names, &DMatrix::from_columns(&columns), &z, self.omega_rad_s.len())
    }
}
