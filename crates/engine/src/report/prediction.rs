//! Rows of predictions: each with the constant the identification gave, and with the window's own.

use doublet_core::estimate::FitQuality;
use serde::Serialize;

/// Prediction of one coefficient over one window, with the constant the identification gave and with the window's own.
#[derive(Clone, Debug, Serialize)]
pub struct PredictionRow {
    /// Manoeuvre.
    pub window: String,
    /// Use of the manoeuvre.
    pub role: &'static str,
    pub coefficient: &'static str,
    /// Agreement with the observation.
    #[serde(flatten)]
    pub agreement: PredictionAgreement,
}

/// How a prediction agrees with the observation: coefficients of determination, and root mean squares of the residual over the
/// largest magnitude of the observation, per cent.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PredictionAgreement {
    /// With derivatives and constant of the identification; separate constants of manoeuvres are averaged.
    pub r_squared_identified_constants: f64,
    /// Likewise.
    pub rms_relative_percent_identified_constants: f64,
    /// With the derivatives of the identification and a constant fitted to the predicted manoeuvre.
    pub r_squared_own_constant: f64,
    /// Likewise.
    pub rms_relative_percent_own_constant: f64,
}

impl PredictionAgreement {
    /// The two agreements, first with the constant of the identification.
    pub fn compare(identified: &FitQuality, own_constant: &FitQuality) -> Self {
        Self {
            r_squared_identified_constants: identified.r_squared,
            rms_relative_percent_identified_constants: identified.rms_relative_percent,
            r_squared_own_constant: own_constant.r_squared,
            rms_relative_percent_own_constant: own_constant.rms_relative_percent,
        }
    }
}

/// Prediction of one coefficient over the validation windows.
#[derive(Clone, Debug, Serialize)]
pub struct ValidationRow {
    pub coefficient: &'static str,
    /// Validation manoeuvres.
    pub windows: usize,
    /// Means of the numbers of [`PredictionRow`].
    #[serde(flatten)]
    pub agreement: PredictionAgreement,
}
