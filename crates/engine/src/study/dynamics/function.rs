//! Functions of the derivatives by expression.

use doublet_core::prep::{Expression, Operand};
use doublet_dynamics::propagate::{Propagated, propagate};
use nalgebra::DVector;

use super::DynamicsStudy;
use crate::graph::{StageError, StageResult};

/// A function of the derivatives, and what they are called.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Value and intervals.
    pub result: Propagated,
    /// Names of the derivatives, by the indices of the result.
    pub names: Vec<String>,
}

/// Quantities of the condition that an expression may name beside the derivatives, SI.
pub fn named_values(study: &DynamicsStudy) -> Vec<(&'static str, f64)> {
    let (reference, condition) = (&study.model.model.reference, &study.condition);
    let (speed, density, inertia) = (condition.airspeed_m_s, condition.density_kg_m3, &condition.mass.inertia);
    vec![
        ("S", reference.area_m2),
        ("b", reference.span_m),
        ("c", reference.chord_m),
        ("V", speed),
        ("rho", density),
        ("qbar", 0.5 * density * speed * speed),
        ("mass", condition.mass.mass_kg),
        ("Ixx", inertia.xx),
        ("Iyy", inertia.yy),
        ("Izz", inertia.zz),
        ("Ixz", inertia.xz),
    ]
}

/// Value of an expression of derivatives and of [`named_values`], with its interval by slopes and by `samples` draws.
pub fn propagate_expression(study: &DynamicsStudy, expression: &str, samples: usize, seed: u64) -> StageResult<Named> {
    let model = &study.model;
    let constants = named_values(study);
    let names: Vec<&str> =
        model.names.iter().map(String::as_str).chain(constants.iter().map(|(name, _)| *name)).collect();
    let parsed = Expression::parse_names(expression, "derivative", &names)
        .map_err(|error| StageError::Failed(error.to_string()))?;
    let places: Vec<usize> = parsed
        .operands()
        .iter()
        .filter_map(|(operand, _)| match operand {
            Operand::Channel(name) => names.iter().position(|known| known == name),
            Operand::Role(_) => None,
        })
        .collect();
    let count = model.names.len();
    let value = |values: &DVector<f64>| {
        let operand = |index: usize| {
            let place = places[index];
            if place < count { values[place] } else { constants[place - count].1 }
        };
        parsed.value(operand, &mut Vec::new())
    };
    let result = propagate(&model.values(), &model.covariance, &model.samples(samples, seed), value);
    if !result.value.is_finite() {
        let line =
            format!("'{expression}' has no value at the estimates: a division by zero or a root of less than zero");
        return Err(line.into());
    }
    Ok(Named { result, names: model.names.clone() })
}
