//! Root loci: modes while one derivative or one quantity of the condition changes.

use super::{Mode, modes};
use crate::linear::{Condition, LinearError, Method, UncertainModel, linearise};

/// What changes along a root locus.
#[derive(Clone, Debug, PartialEq)]
pub enum LocusParameter {
    /// A derivative, by name.
    Derivative(String),
    /// Centre of gravity along the datum's x axis, m aft; inertia stays.
    CentreOfGravity,
    /// Mass, kg; inertia stays.
    Mass,
    /// True airspeed, m/s.
    Airspeed,
    /// Altitude, m; density and speed of sound change as those of the standard atmosphere.
    Altitude,
}

impl LocusParameter {
    /// The parameter called `name`: `cg`, `mass`, `airspeed`, `altitude` or a derivative.
    pub fn parse(name: &str) -> Self {
        match name {
            "cg" => Self::CentreOfGravity,
            "mass" => Self::Mass,
            "airspeed" => Self::Airspeed,
            "altitude" => Self::Altitude,
            _ => Self::Derivative(name.to_owned()),
        }
    }

    /// Unit of its values.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Derivative(_) => "-",
            Self::CentreOfGravity | Self::Altitude => "m",
            Self::Mass => "kg",
            Self::Airspeed => "m/s",
        }
    }
}

/// Modes at one value.
#[derive(Clone, Debug, PartialEq)]
pub struct LocusPoint {
    /// Value of the parameter.
    pub value: f64,
    /// Modes there, fastest first, or why there is no trim.
    pub modes: Result<Vec<Mode>, LinearError>,
}

/// Modes at each value of a parameter, trimmed there.
///
/// # Errors
/// [`LinearError::NoDerivative`] for a derivative the model does not have.
pub fn locus(
    model: &UncertainModel,
    condition: &Condition,
    parameter: &LocusParameter,
    values: &[f64],
) -> Result<Vec<LocusPoint>, LinearError> {
    let derivative = match parameter {
        LocusParameter::Derivative(name) => {
            let index = model.names.iter().position(|known| known == name);
            Some(index.ok_or_else(|| LinearError::NoDerivative { name: name.clone() })?)
        }
        _ => None,
    };
    Ok(values.iter().map(|value| find_modes_at(model, *condition, (parameter, derivative), *value)).collect())
}

/// Modes at one value, trimmed there.
fn find_modes_at(
    model: &UncertainModel,
    mut condition: Condition,
    (parameter, derivative): (&LocusParameter, Option<usize>),
    value: f64,
) -> LocusPoint {
    let mut changed = model.model.clone();
    match parameter {
        LocusParameter::Derivative(_) => {
            derivative.into_iter().for_each(|index| changed.derivatives.set(index, value));
        }
        LocusParameter::CentreOfGravity => condition.mass.cg_from_datum_m[0] = value,
        LocusParameter::Mass => condition.mass.mass_kg = value,
        LocusParameter::Airspeed => condition.airspeed_m_s = value,
        LocusParameter::Altitude => condition = condition.at_altitude(value),
    }
    let found = linearise(&changed, &condition, Method::Analytic);
    LocusPoint { value, modes: found.map(|linearised| modes(&linearised.motion())) }
}
