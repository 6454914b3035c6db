//! How well a structure of the aerodynamic model fits, what it costs, how well it predicts.

use doublet_core::estimate::Fit;
use doublet_core::estimate::diagnostics::predicted_squared_error;
use doublet_core::model::Coefficient;

use super::fit::PooledFits;
use super::prediction::Prediction;
use crate::graph::StageResult;
use crate::session::WindowRole;

/// One coefficient by one structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StructureScore {
    /// Parameters estimated, constants of windows among them.
    pub parameters: usize,
    /// Samples of the fit.
    pub samples: usize,
    /// R² of the fit.
    pub r_squared: f64,
    /// Predicted squared error, see [`predicted_squared_error`].
    pub predicted_squared_error: f64,
    /// Akaike's criterion `N ln(v'v / N) + 2 p`.
    pub akaike: f64,
    /// Schwarz's criterion `N ln(v'v / N) + p ln N`.
    pub bayes: f64,
    /// `1 - sum (z - y)^2 / sum (z - mean z)^2` over the validation windows, each with a constant of its own and its own mean; none
    /// without such a window.
    pub validation_r_squared: Option<f64>,
}

impl StructureScore {
    /// Scores of all fits in their order, or why one has no estimate.
    pub fn all(pooled: &PooledFits) -> impl Iterator<Item = StageResult<Self>> {
        let one = |coefficient: Coefficient, fit: &Fit| {
            let predictions = pooled.predictions.iter().filter(|prediction| prediction.coefficient == coefficient);
            Self::new(fit, predictions.filter(|prediction| prediction.role == WindowRole::Validation))
        };
        let fits = pooled.fits.iter();
        fits.map(move |fit| fit.fit.as_ref().map(|found| one(fit.coefficient, found)).map_err(Clone::clone))
    }

    fn new<'a>(fit: &Fit, validation: impl Iterator<Item = &'a Prediction>) -> Self {
        let (samples, parameters) = (fit.samples() as f64, fit.parameters() as f64);
        let residual = fit.residuals.iter().map(|v| v * v).sum::<f64>() / samples;
        let fitted = samples * residual.ln();
        let mut sums = [0.0; 2];
        for prediction in validation {
            let quality = &prediction.quality_own_constant;
            let squares = prediction.own_constant.values.len() as f64 * quality.rms.powi(2);
            let total = squares / (1.0 - quality.r_squared);
            if total.is_finite() {
                sums[0] += squares;
                sums[1] += total;
            }
        }
        Self {
            parameters: fit.parameters(),
            samples: fit.samples(),
            r_squared: fit.quality.r_squared,
            predicted_squared_error: predicted_squared_error(fit, None),
            akaike: fitted + 2.0 * parameters,
            bayes: fitted + parameters * samples.ln(),
            validation_r_squared: (sums[1] > 0.0).then(|| 1.0 - sums[0] / sums[1]),
        }
    }
}
