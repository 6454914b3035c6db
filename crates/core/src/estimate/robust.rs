//! M-estimates with Huber's weights, by pseudo-values.

use super::pooled::{PooledFit, PooledRegression};
use super::{EstimateError, Fit};
use crate::statistics::{MEDIAN_OF_NORMAL, median};

/// Residual, in standard deviations, from which on it weighs less: 95 % efficiency under normal residuals (Huber 1964).
pub const HUBER_LIMIT: f64 = 1.345;
/// Rounds after which the scale of the residuals stays: the rest is then the minimum of a convex function.
const SCALE_ROUNDS: usize = 10;
/// Rounds at most, and the change of the parameters, in standard errors, that ends them.
const ROUNDS: usize = 100;
const TOLERANCE: f64 = 1e-5;

impl PooledRegression {
    /// The same regression with pseudo-values in place of the measurement: least squares of them is the M-estimate, and its
    /// covariance that of the M-estimate (Huber 1981, section 7.6).
    ///
    /// With the residual `v = z - X theta`, its scale `s = median |v| / 0.6745`, `psi(v) = max(-k s, min(k s, v))`, k = [`HUBER_LIMIT`], and
    /// the part m of the samples with `|v| < k s`, the pseudo-value is `X theta + psi(v) / m`. theta solves `X' psi = 0`, found by
    /// fitting again and again.
    ///
    /// # Errors
    /// As for [`PooledRegression::fit`], and an iteration that does not settle.
    pub fn with_pseudo_values(&self) -> Result<Self, EstimateError> {
        let mut found = self.fit()?;
        let mut scale = 0.0;
        let mut pseudo = self.clone();
        for round in 0..ROUNDS {
            let residuals = self.residuals(&found, &pseudo);
            if round < SCALE_ROUNDS {
                let mut sizes: Vec<f64> = residuals.iter().flatten().map(|v| v.abs()).collect();
                scale = median(&mut sizes).unwrap_or(0.0) / MEDIAN_OF_NORMAL;
            }
            let limit = HUBER_LIMIT * scale;
            let inside = residuals.iter().flatten().filter(|v| v.abs() < limit).count();
            if inside == 0 {
                return Ok(self.clone()); // residuals of rounding only
            }
            let part = inside as f64 / found.fit.samples() as f64;
            for ((pseudo, measured), residuals) in pseudo.windows.iter_mut().zip(&self.windows).zip(&residuals) {
                let values = measured.z.iter().zip(residuals).map(|(z, v)| z - v + v.clamp(-limit, limit) / part);
                pseudo.z = values.collect();
            }
            let next = pseudo.fit()?;
            let moved = largest_move(&found.fit, &next.fit);
            found = next;
            if moved <= TOLERANCE && round >= SCALE_ROUNDS {
                return Ok(pseudo);
            }
        }
        Err(EstimateError::NotConverged { method: "the fit with Huber's weights", iterations: ROUNDS })
    }

    /// Residuals of each window's measurement, where `found` was fitted to the values of `fitted`.
    fn residuals(&self, found: &PooledFit, fitted: &Self) -> Vec<Vec<f64>> {
        let windows = self.windows.iter().zip(&fitted.windows).zip(&found.samples);
        let residuals = windows.map(|((measured, fitted), samples)| {
            let of_fitted = &found.fit.residuals[samples.clone()];
            measured.z.iter().zip(&fitted.z).zip(of_fitted).map(|((z, given), v)| z - given + v).collect()
        });
        residuals.collect()
    }
}

/// Largest change of a parameter, in its standard errors.
pub(super) fn largest_move(from: &Fit, to: &Fit) -> f64 {
    let moves = from.estimates.iter().zip(&to.estimates).zip(&to.standard_errors);
    moves.map(|((a, b), error)| if a == b { 0.0 } else { (a - b).abs() / error }).fold(0.0, f64::max)
}
