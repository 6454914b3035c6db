//! The aerodynamic truth: a set of derivatives and the coefficients it gives.

use serde::Deserialize;

use super::SimulateError;
use crate::model::{Coefficient, Derivatives, Term, Variable, VariableValues};

/// Variables that steady and moving flight give without solving for accelerations.
const USABLE: [Variable; 13] = [
    Variable::Alpha,
    Variable::Beta,
    Variable::RollRate,
    Variable::PitchRate,
    Variable::HalfPitchRate,
    Variable::YawRate,
    Variable::Aileron,
    Variable::Elevator,
    Variable::Rudder,
    Variable::ThrustCoefficient,
    Variable::Airspeed,
    Variable::Altitude,
    Variable::Mach,
];

/// One derivative of the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative {
    /// Name in tables, for example `Cm_alpha`.
    pub name: String,
    /// Coefficient it belongs to.
    pub coefficient: Coefficient,
    /// Term it multiplies.
    pub term: Term,
    /// Value per unit of the term.
    pub value: f64,
    /// Value the thesis prints, where it prints one.
    pub printed: Option<f64>,
    /// Why the value differs from the printed one; empty where it does not.
    pub reason: String,
}

/// Aerodynamic truth: body-axes coefficients as sums of derivative times term, without the thrust.
#[derive(Clone, Debug, PartialEq)]
pub struct AeroModel {
    derivatives: Vec<Derivative>,
    compiled: Derivatives,
}

/// A derivative as written in a truth file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivativeEntry {
    /// Coefficient, underscore, term.
    name: String,
    value: f64,
    /// Value of the thesis.
    printed: Option<f64>,
    /// Reason of a change.
    #[serde(default)]
    reason: String,
}

impl AeroModel {
    /// Reads the derivatives of a truth file.
    ///
    /// # Errors
    /// [`SimulateError::BadDerivative`] and [`SimulateError::RepeatedDerivative`] with the name.
    pub fn new(entries: Vec<DerivativeEntry>) -> Result<Self, SimulateError> {
        let mut derivatives: Vec<Derivative> = Vec::with_capacity(entries.len());
        for entry in entries {
            let (coefficient, term) = parse_name(&entry.name)?;
            let name = term.derivative_name(coefficient);
            if derivatives.iter().any(|derivative| derivative.name == name) {
                return Err(SimulateError::RepeatedDerivative { name });
            }
            let DerivativeEntry { value, printed, reason, .. } = entry;
            derivatives.push(Derivative { name, coefficient, term, value, printed, reason });
        }
        let compiled = derivatives.iter().map(|d: &Derivative| (d.coefficient, d.term.clone(), d.value)).collect();
        Ok(Self { derivatives, compiled })
    }

    /// The same truth with one derivative changed, or added.
    ///
    /// # Errors
    /// [`SimulateError::BadDerivative`] when `name` names no derivative.
    pub fn with_derivative(&self, name: &str, value: f64) -> Result<Self, SimulateError> {
        let (coefficient, term) = parse_name(name)?;
        let changed = term.derivative_name(coefficient);
        let kept = self.derivatives.iter().filter(|derivative| derivative.name != changed);
        let mut entries: Vec<_> = kept
            .map(|derivative| DerivativeEntry {
                // As written in a truth file: a derivative's own name runs variable and power together.
                name: format!("{}_{}", derivative.coefficient.name(), derivative.term),
                value: derivative.value,
                printed: derivative.printed,
                reason: derivative.reason.clone(),
            })
            .collect();
        entries.push(DerivativeEntry {
            name: name.to_owned(),
            value,
            printed: None,
            reason: "set by the user".to_owned(),
        });
        Self::new(entries)
    }

    /// A truth without any aerodynamic force.
    pub fn none() -> Self {
        Self { derivatives: Vec::new(), compiled: Derivatives::default() }
    }

    /// Its derivatives, in the order of the file.
    pub fn derivatives(&self) -> &[Derivative] {
        &self.derivatives
    }

    /// Value of the derivative called `name`.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.derivatives.iter().find(|derivative| derivative.name == name).map(|derivative| derivative.value)
    }

    /// Coefficients `CX CY CZ Cl Cm Cn` about the centre of gravity from the variables.
    pub fn coefficients(&self, variables: &VariableValues) -> [f64; 6] {
        self.compiled.body_coefficients(variables)
    }
}

/// Coefficient and term of a derivative name such as `Cm_alpha`, `CX_alpha^2` or `CX_0`.
fn parse_name(name: &str) -> Result<(Coefficient, Term), SimulateError> {
    let bad = |reason: String| SimulateError::BadDerivative { name: name.to_owned(), reason };
    let (coefficient, term) = name.split_once('_').ok_or_else(|| bad("it has no underscore".into()))?;
    let coefficient = Coefficient::from_name(coefficient)
        .filter(|coefficient| Coefficient::ALL[..6].contains(coefficient))
        .ok_or_else(|| bad(format!("'{coefficient}' is not a coefficient of body axes")))?;
    let term = match term {
        "0" => Term::constant(),
        text => Term::parse(text).map_err(|error| bad(error.to_string()))?,
    };
    for &(variable, power) in term.factors() {
        if !USABLE.contains(&variable) || power < 0 {
            return Err(bad(format!("the simulator has no {}^{power}", variable.name())));
        }
    }
    Ok((coefficient, term))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str, value: f64) -> DerivativeEntry {
        DerivativeEntry { name: name.into(), value, printed: None, reason: String::new() }
    }

    #[test]
    fn coefficients_are_sums_of_derivative_times_term() {
        let model = AeroModel::new(vec![entry("CX_0", 0.1), entry("CX_alpha^2", 3.0), entry("Cm_alpha*delta_e", 2.0)]);
        let model = model.unwrap();
        let mut variables = [0.0; Variable::ALL.len()];
        variables[Variable::Alpha as usize] = 0.2;
        variables[Variable::Elevator as usize] = -0.5;
        let [cx, _, _, _, cm, _] = model.coefficients(&variables);
        assert!((cx - (0.1 + 3.0 * 0.04)).abs() < f64::EPSILON && (cm + 0.2).abs() < f64::EPSILON);
        assert_eq!(model.value("CX_alpha2"), Some(3.0));
    }

    #[test]
    fn model_rejects_bad_names() {
        for (name, part) in
            [("Cm_alfa", "alfa"), ("Cmalpha", "no underscore"), ("CL_alpha", "'CL'"), ("Cm_alpha_dot", "alpha_dot")]
        {
            let message = AeroModel::new(vec![entry(name, 1.0)]).unwrap_err().to_string();
            assert!(message.contains(name) && message.contains(part), "{message}");
        }
        let repeated = AeroModel::new(vec![entry("Cm_q", 1.0), entry("Cm_qc/V", 2.0)]).unwrap_err();
        assert_eq!(repeated, SimulateError::RepeatedDerivative { name: "Cm_q".into() });
    }
}
