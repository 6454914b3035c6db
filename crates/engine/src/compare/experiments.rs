//! Experiments side by side: what each configuration of a session gives.

use doublet_core::reconstruct::Measurement;
use doublet_core::statistics::median;
use serde::Serialize;

use super::{Interval, SettingDifference, settings};
use crate::graph::Footprint;
use crate::run::Snapshot;
use crate::session::{Configuration, Experiment, Session, SessionError, WindowRole};
use crate::stage::{CoefficientFit, PooledFits, ScoredStructure, StructureScore};
use crate::verdict::{FitVerdict, Level, VerdictCounts};

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
    /// Measurement.
    pub measurement: &'static str,
    /// Median over the manoeuvres; 1 is ideal.
    pub nis: f64,
}

/// What a configuration gives for one coefficient.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoefficientOutcome {
    /// Coefficient.
    pub coefficient: &'static str,
    /// Level of its fit.
    pub level: Option<Level>,
    /// Fit; none where there is no estimate.
    pub fit: Option<FitOutcome>,
    /// Derivatives with their intervals, without constants of single manoeuvres.
    pub derivatives: Vec<DerivativeOutcome>,
}

/// How well a coefficient is fitted and predicted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitOutcome {
    /// Parameters estimated.
    pub parameters: usize,
    /// Samples.
    pub samples: usize,
    /// R² of the fit.
    pub r_squared: f64,
    /// Honest R²: of the validation manoeuvres. None without them.
    pub honest_r_squared: Option<f64>,
    /// RMS of the prediction error over the validation manoeuvres, in units of the coefficient. None without them.
    pub validation_rms: Option<f64>,
    /// Akaike's criterion.
    pub akaike: f64,
    /// Akaike's criterion less that of the session as it is; none where the samples fitted are others.
    pub delta_akaike: Option<f64>,
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
    /// Name; [`PRESENT`] for the session as it is.
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

impl Footprint for ExperimentOutcome {
    fn bytes(&self) -> usize {
        self.coefficients.iter().map(|one| 128 + 160 * one.derivatives.len()).sum::<usize>() + 1024
    }
}

impl ExperimentOutcome {
    /// What the results of a session give.
    pub fn new(session: &Session, snapshot: &Snapshot) -> Self {
        let verdicts = snapshot.verdicts.ready();
        let paths = session.active_windows().filter_map(|window| snapshot.windows.get(&window.name)?.path.ready());
        let consistency: Vec<_> = paths.filter_map(|path| path.assessment().consistency.as_ref()).collect();
        let of_measurement = |measurement: Measurement| {
            let channels = consistency.iter().flat_map(|found| &found.channels);
            let own = channels.filter(|channel| channel.measurement == measurement);
            let nis = finite_median(own.map(|channel| channel.deviation_ratio.powi(2)))?;
            Some(MeasurementNis { measurement: measurement.name(), nis })
        };
        let count = |role| session.windows.iter().filter(|window| window.role == role).count();
        let coefficients = snapshot.pooled.ready().map_or_else(Vec::new, |pooled| {
            coefficients(pooled, verdicts.map(|verdicts| verdicts.pooled.as_slice()).unwrap_or_default())
        });
        let honest = coefficients.iter().filter_map(|one| one.fit.as_ref()?.honest_r_squared);
        let unexplained: Vec<f64> = honest.map(|honest| 1.0 - honest).collect();
        let mean = unexplained.iter().sum::<f64>() / unexplained.len() as f64;
        Self {
            verdict: verdicts.map(|verdicts| VerdictCounts::count(verdicts)).unwrap_or_default(),
            identification: count(WindowRole::Identification),
            validation: count(WindowRole::Validation),
            nis: finite_median(consistency.iter().map(|found| found.nis_ratio)),
            nis_by_measurement: Measurement::ALL.into_iter().filter_map(of_measurement).collect(),
            validation_error: (!unexplained.is_empty()).then(|| mean.max(0.0).sqrt()),
            coefficients,
            failures: snapshot.failures().into_iter().map(|(place, error)| format!("{place}: {error}")).collect(),
        }
    }

    /// The coefficient called `name`.
    pub fn coefficient(&self, name: &str) -> Option<&CoefficientOutcome> {
        self.coefficients.iter().find(|one| one.coefficient == name)
    }
}

fn finite_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(&mut values.filter(|value| value.is_finite()).collect::<Vec<_>>())
}

fn coefficients(pooled: &PooledFits, verdicts: &[FitVerdict]) -> Vec<CoefficientOutcome> {
    let scores = ScoredStructure::new(String::new(), pooled).scores;
    let one = |(fit, (_, score)): (&CoefficientFit, (_, _))| {
        let verdict = verdicts.iter().find(|verdict| verdict.coefficient == fit.coefficient);
        CoefficientOutcome {
            coefficient: fit.coefficient.name(),
            level: verdict.map(|verdict| verdict.verdict.level),
            fit: Result::ok(score).map(|score: StructureScore| FitOutcome {
                parameters: score.parameters,
                samples: score.samples,
                r_squared: score.r_squared,
                honest_r_squared: score.validation_r_squared,
                validation_rms: validation_rms(pooled, fit),
                akaike: score.akaike,
                delta_akaike: None,
            }),
            derivatives: derivatives(fit, verdict),
        }
    };
    pooled.fits.iter().zip(scores).map(one).collect()
}

fn validation_rms(pooled: &PooledFits, fit: &CoefficientFit) -> Option<f64> {
    let predictions = pooled
        .predictions
        .iter()
        .filter(|prediction| prediction.coefficient == fit.coefficient && prediction.role == WindowRole::Validation);
    let [squares, samples] = predictions.fold([0.0; 2], |[squares, samples], prediction| {
        let count = prediction.own_constant.values.len() as f64;
        [squares + count * prediction.quality_own_constant.rms.powi(2), samples + count]
    });
    (samples > 0.0).then(|| (squares / samples).sqrt())
}

fn derivatives(fit: &CoefficientFit, verdict: Option<&FitVerdict>) -> Vec<DerivativeOutcome> {
    let Ok(found) = &fit.fit else { return Vec::new() };
    let level = |name: &str| {
        let own = verdict?.derivatives.iter().find(|derivative| derivative.name == name)?;
        Some(own.verdict.level.max(verdict?.verdict.level))
    };
    let all = found.names.iter().zip(&found.estimates).zip(&fit.corrected_errors);
    let shared = all.filter(|((name, _), _)| !name.ends_with(']'));
    let one = |((name, estimate), error): ((&String, &f64), &f64)| DerivativeOutcome {
        name: name.clone(),
        level: level(name),
        interval: Interval::new(*estimate, *error),
    };
    shared.map(one).collect()
}

impl ExperimentRow {
    /// The row of the session as it is.
    pub fn present(outcome: ExperimentOutcome) -> Self {
        let mut row = Self {
            name: PRESENT.to_owned(),
            is_current: true,
            differences: Vec::new(),
            delta_akaike: None,
            outcome: outcome.clone(),
        };
        row.compare(&outcome);
        row
    }

    /// The row of an experiment beside the session as it is, which gives `present`.
    ///
    /// # Errors
    /// As [`experiment_differences`].
    pub fn new(
        experiment: &Experiment,
        outcome: ExperimentOutcome,
        session: &Session,
        present: Option<&ExperimentOutcome>,
    ) -> Result<Self, SessionError> {
        let own = Configuration::from_session(session);
        let mut row = Self {
            name: experiment.name.clone(),
            is_current: *experiment.configuration == own,
            differences: experiment_differences(session, &own, &experiment.configuration)?,
            delta_akaike: None,
            outcome,
        };
        if let Some(present) = present.filter(|_| experiment.configuration.has_data_of(&own)) {
            row.compare(present);
        }
        Ok(row)
    }

    /// Forms the differences of Akaike's criterion to `present`, whose fits have the same samples.
    fn compare(&mut self, present: &ExperimentOutcome) {
        for coefficient in &mut self.outcome.coefficients {
            let other = present.coefficient(coefficient.coefficient).and_then(|other| other.fit.as_ref());
            if let Some((fit, other)) = coefficient.fit.as_mut().zip(other)
                && fit.samples == other.samples
            {
                fit.delta_akaike = Some(fit.akaike - other.akaike);
            }
        }
        let own = &self.outcome.coefficients;
        let deltas: Option<Vec<f64>> = own.iter().map(|one| one.fit.as_ref()?.delta_akaike).collect();
        let deltas = deltas.filter(|deltas| !deltas.is_empty() && own.len() == present.coefficients.len());
        self.delta_akaike = deltas.map(|deltas| deltas.iter().sum());
    }
}

/// Settings that differ between two configurations of a session.
///
/// # Errors
/// Should a setting have no saved form.
pub fn experiment_differences(
    session: &Session,
    first: &Configuration,
    second: &Configuration,
) -> Result<Vec<SettingDifference>, SessionError> {
    let plain = session.without_experiments();
    settings(&first.applied_to(&plain), &second.applied_to(&plain))
}
