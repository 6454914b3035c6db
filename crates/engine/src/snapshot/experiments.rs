//! What the experiments of a session give.

use std::collections::BTreeMap;

use doublet_core::statistics::NORMAL_95;
use serde::Serialize;

use super::verdicts::VerdictCounts;
use super::{NamedSlots, Slot, WindowResults};
use crate::graph::Footprint;
use crate::session::{Fix, Level};
use crate::stage::PooledFits;

/// What the row of the present configuration is called.
pub const PRESENT: &str = "Session as it is";

/// What a configuration gives.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExperimentOutcome {
    /// Level of the session, and how many derivatives are good, a caution, bad.
    pub verdict: VerdictCounts,
    /// Manoeuvres that identify.
    pub identification: usize,
    /// Manoeuvres that validate.
    pub validation: usize,
    /// Mean NIS of the flight path over its expectation, median of the manoeuvres; 1 is ideal. None without a filter.
    pub nis: Option<f64>,
    /// The same of each measurement: the square of found over predicted deviation of its innovations.
    pub nis_by_measurement: Vec<MeasurementNis>,
    /// Validation error: root mean square over the coefficients of `sqrt(1 - R²)` of the validation manoeuvres; 0 is exact, 1 no better
    /// than the mean. None without validation manoeuvres.
    pub validation_error: Option<f64>,
    /// One for every coefficient of the structure.
    pub coefficients: Vec<CoefficientOutcome>,
    /// What could not be computed, a line each.
    pub failures: Vec<String>,
}

/// NIS of one measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasurementNis {
    pub measurement: &'static str,
    /// Median over the manoeuvres; 1 is ideal.
    pub nis: f64,
}

/// What a configuration gives for one coefficient.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoefficientOutcome {
    pub coefficient: &'static str,
    /// Level of its fit.
    pub level: Option<Level>,
    /// Fit, if there is an estimate.
    pub fit: Option<FitOutcome>,
    /// Derivatives with their intervals, without constants of single manoeuvres.
    pub derivatives: Vec<DerivativeOutcome>,
}

/// How well a coefficient is fitted and predicted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitOutcome {
    /// Parameters estimated.
    pub parameters: usize,
    pub samples: usize,
    /// R² of the fit.
    pub r_squared: f64,
    /// Honest R²: of the validation manoeuvres. None without them.
    pub honest_r_squared: Option<f64>,
    /// RMS of the prediction error over the validation manoeuvres, in units of the coefficient. None without them.
    pub validation_rms: Option<f64>,
    /// Predicted squared error: mean squared residual with a charge for each parameter, in units of the coefficient squared.
    pub predicted_squared_error: f64,
    /// Akaike's criterion.
    pub akaike: f64,
    /// Akaike's criterion less that of the session as it is; none where the samples fitted are others.
    pub delta_akaike: Option<f64>,
    /// Schwarz's (Bayesian) criterion.
    pub bayes: f64,
    /// Schwarz's criterion less that of the session as it is; none where the samples fitted are others.
    pub delta_bayes: Option<f64>,
}

/// A derivative with its interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DerivativeOutcome {
    /// Name, for example `Cm_q`.
    pub name: String,
    /// Level; none where nothing was judged.
    pub level: Option<Level>,
    /// Estimate with its corrected standard error.
    #[serde(flatten)]
    pub interval: Interval,
}

/// An experiment beside the session as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExperimentRow {
    /// Name; `Session as it is` for the present configuration.
    pub name: String,
    /// Whether its configuration is that of the session.
    pub is_current: bool,
    /// Settings that differ: first of the session, second of the experiment.
    pub differences: Vec<SettingDifference>,
    /// Sum of the coefficients' differences of Akaike's criterion to the session as it is; below zero is better. None where the
    /// samples fitted or the coefficients are others.
    pub delta_akaike: Option<f64>,
    /// What it gives.
    #[serde(flatten)]
    pub outcome: ExperimentOutcome,
}

/// A setting two sessions do not share.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SettingDifference {
    /// Its name: keys of the session file, list entries by their own names.
    pub setting: String,
    /// SI unit; empty for what has none.
    pub unit: String,
    /// Value in the first session; `None` where it has none.
    pub first: Option<String>,
    /// Value in the second session; `None` where it has none.
    pub second: Option<String>,
}

impl SettingDifference {
    /// Setting, first and second value in one line.
    pub fn line(&self) -> String {
        let [first, second] = [&self.first, &self.second].map(|value| self.written(value.as_deref()));
        format!("{}: {first} here, {second} on disk", self.setting)
    }

    /// One of the values with its unit.
    pub fn written(&self, value: Option<&str>) -> String {
        match value {
            Some(value) if self.unit.is_empty() => value.to_owned(),
            Some(value) => format!("{value} {}", self.unit),
            None => "not set".to_owned(),
        }
    }
}

/// An estimate with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    pub estimate: f64,
    /// Standard error, corrected for correlated residuals.
    pub standard_error: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end of the 95 % interval.
    pub high: f64,
}

impl Interval {
    /// The 95 % interval of an estimate.
    pub fn new(estimate: f64, standard_error: f64) -> Self {
        let half = NORMAL_95 * standard_error;
        Self { estimate, standard_error, low: estimate - half, high: estimate + half }
    }
}

impl Footprint for ExperimentOutcome {
    fn bytes(&self) -> usize {
        self.coefficients.iter().map(|one| 128 + 160 * one.derivatives.len()).sum::<usize>() + 1024
    }
}

/// Rows of the experiments, the session as it is first, by name.
pub type ExperimentRows = NamedSlots<ExperimentRow>;

/// What each fix gives.
pub type TriedFixes = NamedSlots<ExperimentOutcome, Fix>;

/// The overlaid experiments by name.
pub type Overlays = NamedSlots<OverlaidResults>;

/// What an experiment gives, manoeuvre by manoeuvre.
#[derive(Clone, Debug)]
pub struct OverlaidResults {
    /// Flight path, coefficients and fits by manoeuvre.
    pub windows: BTreeMap<String, WindowResults>,
    /// Derivatives from all identification manoeuvres.
    pub pooled: Slot<PooledFits>,
}

impl Footprint for OverlaidResults {
    /// Without the results themselves: the cache counts those of their own stages.
    fn bytes(&self) -> usize {
        1024 * (1 + self.windows.len())
    }
}
