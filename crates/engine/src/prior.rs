//! An earlier estimate, the flight, and both combined, with the test of whether they contradict each other.

use std::fmt::{Display, Formatter};

use doublet_core::estimate::{Known, combine};
use doublet_core::hash_fields;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::graph::{Context, Footprint, Stage, StageResult};
use crate::notation::significant;
use crate::study::{IdentifiedCoefficient, StudyInput, identified};

/// Probability below which a difference counts as a contradiction.
const CONTRADICTION: f64 = 0.01;

/// What was known before the flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PriorRequest {
    /// Where it comes from.
    pub name: String,
    /// Derivatives with their means and standard deviations; those without a finite deviation above zero count for nothing.
    pub known: Vec<PriorValue>,
}

/// A derivative known before the flight.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorValue {
    /// Derivative.
    pub name: String,
    pub mean: f64,
    pub deviation: f64,
}

hash_fields!(PriorValue { name; mean, deviation });
hash_fields!(PriorRequest { name, known; });

impl PriorRequest {
    fn find(&self, name: &str) -> Option<Known> {
        let found = self.known.iter().find(|value| value.name == name)?;
        found.is_usable().then_some(Known { mean: found.mean, deviation: found.deviation })
    }
}

impl PriorValue {
    /// Whether it says anything: a finite mean with a finite deviation above zero.
    pub fn is_usable(&self) -> bool {
        self.mean.is_finite() && self.deviation.is_finite() && self.deviation > 0.0
    }
}

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ValueRow {
    pub value: f64,
    pub standard_error: f64,
}

impl PriorRow {
    /// Whether prior and flight contradict each other.
    pub fn is_contradiction(&self) -> bool {
        self.probability.is_some_and(|probability| probability < CONTRADICTION)
    }
}

impl From<Known> for ValueRow {
    fn from(known: Known) -> Self {
        Self { value: known.mean, standard_error: known.deviation }
    }
}

/// A derivative before the flight, by the flight, and by both.
#[derive(Clone, Debug, Serialize)]
pub struct PriorRow {
    pub name: String,
    pub prior: Option<ValueRow>,
    pub flight: ValueRow,
    pub combined: ValueRow,
    pub deviations: Option<f64>,
    pub probability: Option<f64>,
}

/// Whether prior and flight contradict each other in one coefficient.
#[derive(Clone, Debug, Serialize)]
pub struct ConflictRow {
    pub coefficient: &'static str,
    pub distance: f64,
    pub degrees_of_freedom: usize,
    pub probability: f64,
}

/// Prior, flight and both for every derivative of the coefficients of which something was known.
#[derive(Clone, Debug, Serialize)]
pub struct PriorStudy {
    pub derivatives: Vec<PriorRow>,
    pub coefficients: Vec<ConflictRow>,
}

impl Footprint for PriorStudy {
    fn bytes(&self) -> usize {
        256 * self.derivatives.len()
    }
}

impl Stage for PriorStudy {
    type Params<'a> = &'a PriorRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "prior and flight";

    fn run(request: &PriorRequest, input: &StudyInput<'_>, _: &Context<'_>) -> StageResult<Self> {
        let mut study = Self { derivatives: Vec::new(), coefficients: Vec::new() };
        let reference = &input.aircraft.loaded.aircraft.reference;
        for fit in &input.pooled.fits {
            let terms = input.settings.structure.terms(fit.coefficient).unwrap_or_default();
            let coefficient = identified(fit, terms, reference)?;
            study.add(&coefficient, request)?;
        }
        if study.derivatives.is_empty() {
            return Err(format!(
                "{}: it has no derivative of the session's model with a standard deviation above zero",
                request.name
            )
            .into());
        }
        Ok(study)
    }
}

impl PriorStudy {
    /// Adds a coefficient where something of it was known.
    fn add(&mut self, coefficient: &IdentifiedCoefficient, request: &PriorRequest) -> StageResult<()> {
        let rows = &coefficient.parameters;
        let priors: Vec<Option<Known>> = rows.iter().map(|row| request.find(&row.name)).collect();
        if priors.iter().all(Option::is_none) {
            return Ok(());
        }
        let flight: Vec<f64> = rows.iter().map(|row| row.value).collect();
        let found = combine(&flight, &covariance(coefficient), &priors);
        let found = found.ok_or_else(|| format!("{}: its errors are zero", coefficient.coefficient.name()))?;
        self.coefficients.push(ConflictRow {
            coefficient: coefficient.coefficient.name(),
            distance: found.distance.0,
            degrees_of_freedom: found.distance.1,
            probability: found.probability,
        });
        for (index, row) in rows.iter().enumerate() {
            self.derivatives.push(PriorRow {
                name: row.name.clone(),
                prior: priors[index].map(ValueRow::from),
                flight: ValueRow { value: row.value, standard_error: row.standard_error },
                combined: ValueRow {
                    value: found.values[index],
                    standard_error: found.covariance[(index, index)].max(0.0).sqrt(),
                },
                deviations: found.conflicts[index],
                probability: found.probabilities[index],
            });
        }
        Ok(())
    }
}

impl ConflictRow {
    /// Whether prior and flight contradict each other.
    pub fn is_contradiction(&self) -> bool {
        self.probability < CONTRADICTION
    }
}

impl Display for ConflictRow {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let word = if self.is_contradiction() { "prior and flight disagree" } else { "agree" };
        write!(
            f,
            "{}: {word}; squared distance {} for {} degrees of freedom, exceeded by chance in {} % of cases",
            self.coefficient,
            significant(self.distance, 3),
            self.degrees_of_freedom,
            significant(100.0 * self.probability, 2)
        )
    }
}

/// Covariance of the derivatives of a coefficient, from the corrected errors.
fn covariance(coefficient: &IdentifiedCoefficient) -> DMatrix<f64> {
    let errors = coefficient.parameters.iter().map(|row| row.standard_error);
    let errors = DMatrix::from_diagonal(&DVector::from_iterator(coefficient.parameters.len(), errors));
    &errors * &coefficient.correlation * &errors
}
