//! The saved form of how derivatives are estimated.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::super::{Estimation, PooledConstants, PredictionParameters, ResidualWeights};
use super::constraint::{ConstraintTable, constraint_from, constraint_table};
use super::{SessionError, choose, is_default, name_of};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct EstimationTable {
    by_surface: bool,
    constants: PooledConstants,
    #[serde(skip_serializing_if = "is_default")]
    predict_with: PredictionParameters,
    #[serde(skip_serializing_if = "is_equal")]
    weights: String,
    #[serde(skip_serializing_if = "is_usual_order")]
    autoregression_order: usize,
    #[serde(rename = "constraint", skip_serializing_if = "Vec::is_empty")]
    constraints: Vec<ConstraintTable>,
}

fn is_equal(weights: &str) -> bool {
    weights == WEIGHTS[0].0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form serde asks for")]
fn is_usual_order(order: &usize) -> bool {
    *order == ResidualWeights::USUAL_ORDER
}

impl Default for EstimationTable {
    fn default() -> Self {
        estimation_table(&Estimation::default())
    }
}

/// Names of the weights, in one place for both directions.
const WEIGHTS: [(&str, ResidualWeights); 3] = [
    ("equal", ResidualWeights::Equal),
    ("huber", ResidualWeights::Huber),
    ("autoregression", ResidualWeights::Autoregression(ResidualWeights::USUAL_ORDER)),
];
/// Orders of the autoregression.
const ORDERS: RangeInclusive<usize> = 1..=50;

/// How derivatives are estimated, of a saved form.
pub(super) fn estimation_from(table: EstimationTable) -> Result<Estimation, SessionError> {
    let order = table.autoregression_order;
    if !ORDERS.contains(&order) {
        let reason = format!("{order} is not an order: use {} to {}", ORDERS.start(), ORDERS.end());
        return Err(SessionError::Term { place: "estimation.autoregression_order".to_owned(), reason });
    }
    let weights = match choose(&WEIGHTS, "estimation.weights", &table.weights)? {
        ResidualWeights::Autoregression(_) => ResidualWeights::Autoregression(order),
        other => other,
    };
    Ok(Estimation {
        by_surface: table.by_surface,
        constants: table.constants,
        predict_with: table.predict_with,
        weights,
        constraints: table.constraints.into_iter().map(constraint_from).collect::<Result<_, _>>()?,
    })
}

/// The saved form.
pub(super) fn estimation_table(estimation: &Estimation) -> EstimationTable {
    let (weights, autoregression_order) = match estimation.weights {
        ResidualWeights::Autoregression(order) => {
            (ResidualWeights::Autoregression(ResidualWeights::USUAL_ORDER), order)
        }
        other => (other, ResidualWeights::USUAL_ORDER),
    };
    EstimationTable {
        by_surface: estimation.by_surface,
        constants: estimation.constants,
        predict_with: estimation.predict_with,
        weights: name_of(&WEIGHTS, weights),
        autoregression_order,
        constraints: estimation.constraints.iter().map(constraint_table).collect(),
    }
}
