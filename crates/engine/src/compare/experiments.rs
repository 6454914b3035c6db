//! Experiments side by side: what each configuration of a session gives.

use doublet_core::reconstruct::Measurement;
use doublet_core::statistics::median;

use super::settings;
use crate::session::{Configuration, Experiment, Session, SessionError, WindowRole};
use crate::snapshot::{
    CoefficientOutcome, DerivativeOutcome, ExperimentOutcome, ExperimentRow, FitOutcome, FitVerdict, Interval,
    MeasurementNis, PRESENT, SettingDifference, Snapshot, VerdictCounts,
};
use crate::stage::{CoefficientFit, PooledFits, StructureScore};

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
    let scored = pooled.fits.iter().zip(StructureScore::all(pooled));
    scored.map(|(fit, score)| describe_coefficient(pooled, fit, score.ok(), verdicts)).collect()
}

fn describe_coefficient(
    pooled: &PooledFits,
    fit: &CoefficientFit,
    score: Option<StructureScore>,
    verdicts: &[FitVerdict],
) -> CoefficientOutcome {
    let verdict = verdicts.iter().find(|verdict| verdict.coefficient == fit.coefficient);
    CoefficientOutcome {
        coefficient: fit.coefficient.name(),
        level: verdict.map(|verdict| verdict.verdict.level),
        fit: score.map(|score| FitOutcome {
            parameters: score.parameters,
            samples: score.samples,
            r_squared: score.r_squared,
            honest_r_squared: score.validation_r_squared,
            validation_rms: validation_rms(pooled, fit),
            predicted_squared_error: score.predicted_squared_error,
            akaike: score.akaike,
            delta_akaike: None,
            bayes: score.bayes,
            delta_bayes: None,
        }),
        derivatives: derivatives(fit, verdict),
    }
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

    /// Forms the differences of the information criteria to `present`, whose fits have the same samples.
    fn compare(&mut self, present: &ExperimentOutcome) {
        for coefficient in &mut self.outcome.coefficients {
            let other = present.coefficient(coefficient.coefficient).and_then(|other| other.fit.as_ref());
            if let Some((fit, other)) = coefficient.fit.as_mut().zip(other)
                && fit.samples == other.samples
            {
                fit.delta_akaike = Some(fit.akaike - other.akaike);
                fit.delta_bayes = Some(fit.bayes - other.bayes);
            }
        }
        let own = &self.outcome.coefficients;
        let deltas: Option<Vec<f64>> = own.iter().map(|one| one.fit.as_ref()?.delta_akaike).collect();
        let deltas = deltas.filter(|deltas| !deltas.is_empty() && own.len() == present.coefficients.len());
        self.delta_akaike = deltas.map(|deltas| deltas.iter().sum());
    }
}

/// Settings that differ between two configurations of a session.
pub fn experiment_differences(
    session: &Session,
    first: &Configuration,
    second: &Configuration,
) -> Result<Vec<SettingDifference>, SessionError> {
    let plain = session.without_experiments();
    settings(&first.applied_to(&plain), &second.applied_to(&plain))
}
