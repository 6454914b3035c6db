//! Errors to expect of a fit whose samples are still to be flown: its regressors, and the noise that an earlier fit left.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use nalgebra::DMatrix;

use super::between_windows::expected_between_windows;
use super::covariance::{Block, Coloured, Spectra, Unit, add_products, sandwich, with_transforms};
use super::pooled::layout;
use super::triangle::Triangle;
use super::{Constraint, EstimateError, PooledFit, PooledRegression, PooledWindow};

/// Noise of the observations of a fit as its residuals show it: the autocorrelation of the residuals, what the fit took of it, and
/// the variance. Lags are samples: it holds for fits with the same interval between samples.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualNoise {
    /// Weighted autocorrelation of the residual over the lags.
    correlation: Vec<f64>,
    /// Weighted part of white noise that the fit took, over the lags.
    leverage: Vec<f64>,
    /// Variance of the residual, `s^2`.
    variance: f64,
}

/// What a fit of planned windows will say of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedErrors {
    /// Names of the parameters, those all windows share first.
    pub names: Vec<String>,
    /// Standard errors for white residuals, `s sqrt(diag (X'X)^-1)`.
    pub standard_errors: Vec<f64>,
    /// Standard errors for residuals of the noise's colour.
    pub corrected_errors: Vec<f64>,
    /// Mean square of the scatter between the windows over the variance, for white residuals; one where the scatter is not used.
    pub scatter_shares: Vec<f64>,
    /// Covariance for residuals of the noise's colour.
    pub covariance: DMatrix<f64>,
}

impl PooledFit {
    /// The noise that this fit of `windows` left in its residuals, with the lags and the taper of `settings`.
    pub fn residual_noise(
        &self,
        windows: &[PooledWindow],
        settings: &Coloured,
    ) -> Result<ResidualNoise, EstimateError> {
        let residuals: Vec<&[f64]> = self.samples.iter().map(|range| &self.fit.residuals[range.clone()]).collect();
        if windows.len() != residuals.len() {
            let (expected, found) = (residuals.len(), windows.len());
            return Err(EstimateError::Size { quantity: "windows", expected, found });
        }
        let shortest = residuals.iter().map(|residuals| residuals.len()).min().unwrap_or(0);
        let all: usize = residuals.iter().map(|residuals| residuals.len()).sum();
        let max_lag = settings.lag_for(shortest, all)?;
        with_transforms(|transforms| {
            let records = residuals.iter().map(|residuals| (*residuals, &[][..]));
            let [mut correlation, _] = transforms.autocorrelations(records, max_lag);
            let spectra: Vec<Spectra<'_>> = windows
                .iter()
                .zip(&self.parameters)
                .map(|(window, columns)| {
                    transforms.spectra(&Block { x: Cow::Borrowed(&window.x), columns, residuals: Vec::new() }, max_lag)
                })
                .collect();
            let mut leverage = transforms.leverage(&self.fit.unit_covariance, &spectra, max_lag)?;
            leverage.iter_mut().for_each(|sum| *sum /= all as f64);
            for values in [&mut correlation, &mut leverage] {
                values.iter_mut().zip(settings.taper.weights(max_lag)).for_each(|(value, weight)| *value *= weight);
            }
            Ok(ResidualNoise { correlation, leverage, variance: self.fit.residual_std.powi(2) })
        })
    }
}

impl ResidualNoise {
    /// Variance of the residual.
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Errors to expect of `regression` in this noise: `D = (X'X)^-1` and `D M D` as [`super::coloured_covariance`] forms them, with the
    /// spectrum of this noise in the place of that of residuals which do not exist yet. What is measured in its windows does not
    /// matter. Expectations stated beforehand count, bounds do not; fixed terms have no place in it.
    ///
    /// # Errors
    /// Regressors that depend on each other; sizes that differ.
    pub fn expected(&self, regression: &PooledRegression) -> Result<ExpectedErrors, EstimateError> {
        let (names, parameters) = layout(&regression.names, &regression.per_window, &regression.windows)?;
        let triangles: Vec<Triangle> =
            regression.windows.iter().map(|window| Triangle::reduce(&window.x, &vec![0.0; window.x.nrows()])).collect();
        let stacked = Triangle::stack(triangles.iter().zip(parameters.iter().map(Vec::as_slice)), names.len());
        let mut information = vec![0.0; names.len()];
        for columns in &parameters {
            for (&column, constraint) in columns.iter().zip(&regression.constraints) {
                if let Constraint::Prior { deviation, .. } = constraint {
                    information[column] = self.variance / (deviation * deviation);
                }
            }
        }
        let rows: Vec<(f64, usize, f64)> = information
            .iter()
            .enumerate()
            .filter(|(_, information)| **information > 0.0)
            .map(|(column, information)| (information.sqrt(), column, 0.0))
            .collect();
        let triangle = if rows.is_empty() { stacked } else { stacked.with_rows(&rows) };
        let unit_covariance = triangle.solve(&names)?.unit_covariance;
        let max_lag = self.correlation.len().saturating_sub(1);
        let covariance = with_transforms(|transforms| {
            let mut middle = DMatrix::zeros(names.len(), names.len());
            let mut noises: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
            for (window, columns) in regression.windows.iter().zip(&parameters) {
                let spectra =
                    transforms.spectra(&Block { x: Cow::Borrowed(&window.x), columns, residuals: Vec::new() }, max_lag);
                let noise = match noises.entry(spectra.length) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(open) => {
                        open.insert(transforms.noise(spectra.length, &self.correlation, &self.leverage)?)
                    }
                };
                add_products(&spectra, noise, &mut middle);
            }
            let unit = Unit { covariance: &unit_covariance, prior_information: &information, variance: self.variance };
            sandwich(&unit, middle)
        })?;
        let scatter_shares = expected_between_windows(&regression.windows, &parameters, &information)?;
        Ok(ExpectedErrors {
            scatter_shares,
            standard_errors: unit_covariance.diagonal().iter().map(|d| (self.variance * d).sqrt()).collect(),
            corrected_errors: covariance.diagonal().iter().map(|variance| variance.sqrt()).collect(),
            names,
            covariance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A regression of two windows by a slow and a fast sine, each with its constant; the noise is correlated in time.
    fn regression(samples: usize) -> PooledRegression {
        PooledRegression {
            names: ["c_0", "c_a", "c_b"].map(str::to_owned).to_vec(),
            per_window: vec![true, false, false],
            constraints: vec![Constraint::Free; 3],
            windows: vec![window(samples, 0), window(samples, 40)],
        }
    }

    fn window(samples: usize, shift: usize) -> PooledWindow {
        let x = DMatrix::from_fn(samples, 3, |row, column| match column {
            0 => 1.0,
            1 => (0.05 * (row + shift) as f64).sin(),
            _ => (0.4 * (row + 2 * shift) as f64).sin(),
        });
        let mut state = 0.0;
        let mut seed = 17 + shift as u64;
        let z = (0..samples).map(|row| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state = 0.8 * state + (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            2.0 * x[(row, 1)] - x[(row, 2)] + state
        });
        PooledWindow { label: shift.to_string(), z: z.collect(), x: x.clone() }
    }

    #[test]
    fn errors_expected_of_the_same_windows_are_those_of_the_fit() {
        let regression = regression(400);
        let fit = regression.fit().unwrap();
        let settings = Coloured::default();
        let noise = fit.residual_noise(&regression.windows, &settings).unwrap();
        let expected = noise.expected(&regression).unwrap();
        let found = fit.coloured_covariance(&regression.windows, &settings).unwrap();
        assert_eq!(expected.names, fit.fit.names);
        // The same sums in another order: rounding.
        assert!((&expected.covariance - &found).amax() < 1e-12 * found.amax());
        for (expected, found) in expected.standard_errors.iter().zip(&fit.fit.standard_errors) {
            approx::assert_relative_eq!(expected, found, max_relative = 1e-10);
        }
    }

    #[test]
    fn twice_the_windows_halve_the_variance_and_an_expectation_bounds_it() {
        let mut twice = regression(400);
        let fit = twice.fit().unwrap();
        let noise = fit.residual_noise(&twice.windows, &Coloured::default()).unwrap();
        let once = noise.expected(&twice).unwrap();
        let again = twice.windows.clone();
        twice
            .windows
            .extend(again.into_iter().map(|window| PooledWindow { label: format!("{}b", window.label), ..window }));
        let both = noise.expected(&twice).unwrap();
        for (once, both) in once.corrected_errors.iter().zip(&both.corrected_errors).take(2) {
            approx::assert_relative_eq!(both * both, 0.5 * once * once, max_relative = 1e-9);
        }
        twice.constraints[1] = Constraint::Prior { mean: 2.0, deviation: 1e-3 * once.corrected_errors[0] };
        let held = noise.expected(&twice).unwrap();
        approx::assert_relative_eq!(held.standard_errors[0], 1e-3 * once.corrected_errors[0], max_relative = 1e-3);
    }
}
