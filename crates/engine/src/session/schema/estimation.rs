//! The saved form of how derivatives are estimated.

use serde::{Deserialize, Serialize};

use super::super::{Estimation, PooledConstants, PredictionParameters, ResidualWeights};
use super::constraint::{ConstraintTable, constraint_from, constraint_table};
use super::{SessionError, choose, name_of};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct EstimationTable {
    by_surface: bool,
    constants: String,
    #[serde(skip_serializing_if = "is_pooled")]
    predict_with: String,
    #[serde(skip_serializing_if = "is_equal")]
    weights: String,
    #[serde(rename = "constraint", skip_serializing_if = "Vec::is_empty")]
    constraints: Vec<ConstraintTable>,
}

fn is_pooled(predict_with: &str) -> bool {
    predict_with == PREDICTIONS[0].0
}

fn is_equal(weights: &str) -> bool {
    weights == WEIGHTS[0].0
}

impl Default for EstimationTable {
    fn default() -> Self {
        estimation_table(&Estimation::default())
    }
}

/// Names of the choices, in one place for both directions.
const CONSTANTS: [(&str, PooledConstants); 2] =
    [("per_window", PooledConstants::PerWindow), ("common", PooledConstants::Common)];
const PREDICTIONS: [(&str, PredictionParameters); 2] =
    [("pooled", PredictionParameters::Pooled), ("window_means", PredictionParameters::WindowMeans)];
const WEIGHTS: [(&str, ResidualWeights); 2] = [("equal", ResidualWeights::Equal), ("huber", ResidualWeights::Huber)];

/// How derivatives are estimated, of a saved form.
pub(super) fn estimation_from(table: EstimationTable) -> Result<Estimation, SessionError> {
    Ok(Estimation {
        by_surface: table.by_surface,
        constants: choose(&CONSTANTS, "estimation.constants", &table.constants)?,
        predict_with: choose(&PREDICTIONS, "estimation.predict_with", &table.predict_with)?,
        weights: choose(&WEIGHTS, "estimation.weights", &table.weights)?,
        constraints: table.constraints.into_iter().map(constraint_from).collect::<Result<_, _>>()?,
    })
}

/// The saved form.
pub(super) fn estimation_table(estimation: &Estimation) -> EstimationTable {
    EstimationTable {
        by_surface: estimation.by_surface,
        constants: name_of(&CONSTANTS, estimation.constants),
        predict_with: name_of(&PREDICTIONS, estimation.predict_with),
        weights: name_of(&WEIGHTS, estimation.weights),
        constraints: estimation.constraints.iter().map(constraint_table).collect(),
    }
}
