//! Equations of motion from their text.

use super::EquationFault;
use crate::prep::{Expression, Operand};

/// Equations of motion as text. An expression names states, inputs and parameters, and has the operators and functions of
/// [`Expression`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EquationText {
    /// States and their derivatives by time: `("q", "M_alpha*alpha + M_q*q + M_delta_e*delta_e")`.
    pub states: Vec<(String, String)>,
    /// Outputs and what they show: `("q", "q")`.
    pub outputs: Vec<(String, String)>,
    /// Recorded columns.
    pub inputs: Vec<String>,
    /// Free parameters and where the search starts.
    pub parameters: Vec<(String, f64)>,
    /// Numbers that are known.
    pub constants: Vec<(String, f64)>,
}

/// Equations of motion `x' = f(x, u, theta)`, `y = h(x, u, theta)`.
#[derive(Clone, Debug)]
pub struct EquationModel {
    pub(super) states: Vec<String>,
    pub(super) outputs: Vec<String>,
    pub(super) inputs: Vec<String>,
    pub(super) parameters: Vec<(String, f64)>,
    constants: Vec<f64>,
    rates: Vec<Side>,
    shown: Vec<Side>,
    /// State that each output is, where it is one alone.
    pub(super) output_of_state: Vec<Option<usize>>,
}

/// A right-hand side, with the place of each of its operands among states, inputs, parameters and constants.
#[derive(Clone, Debug)]
struct Side {
    expression: Expression,
    places: Vec<usize>,
}

impl EquationModel {
    /// Understands equations.
    ///
    /// # Errors
    /// [`EquationFault`]: no state or output, a name that is two things, an expression that is not understood.
    pub fn new(text: &EquationText) -> Result<Self, EquationFault> {
        for (what, is_empty) in [("state", text.states.is_empty()), ("output", text.outputs.is_empty())] {
            if is_empty {
                return Err(EquationFault::Without { what });
            }
        }
        let firsts = |pairs: &[(String, String)]| pairs.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let values = |pairs: &[(String, f64)]| pairs.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let kinds = [
            ("a state", firsts(&text.states)),
            ("an input", text.inputs.clone()),
            ("a parameter", values(&text.parameters)),
            ("a constant", values(&text.constants)),
        ];
        let all: Vec<(&'static str, &str)> =
            kinds.iter().flat_map(|(kind, names)| names.iter().map(|name| (*kind, name.as_str()))).collect();
        for (index, (second, name)) in all.iter().enumerate() {
            if let Some((first, _)) = all[..index].iter().find(|(_, other)| other == name) {
                return Err(EquationFault::Twice { name: (*name).to_owned(), first, second });
            }
        }
        let names: Vec<&str> = all.iter().map(|(_, name)| *name).collect();
        let side = |kind: &str, (name, text): &(String, String)| -> Result<Side, EquationFault> {
            let fault = |error| EquationFault::Expression { place: format!("{kind} '{name}'"), error };
            let expression = Expression::parse_names(text, "state, input or parameter", &names).map_err(fault)?;
            let place = |(operand, _): &(Operand, usize)| {
                let name = match operand {
                    Operand::Channel(name) => name.as_str(),
                    Operand::Role(role) => role.name(),
                };
                names.iter().position(|other| *other == name).unwrap_or(usize::MAX)
            };
            Ok(Side { places: expression.operands().iter().map(place).collect(), expression })
        };
        let shown = text.outputs.iter().map(|output| side("output", output)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            rates: text.states.iter().map(|state| side("state", state)).collect::<Result<_, _>>()?,
            output_of_state: firsts(&text.states)
                .iter()
                .map(|state| text.outputs.iter().position(|(_, expression)| expression.trim() == state))
                .collect(),
            shown,
            states: firsts(&text.states),
            outputs: firsts(&text.outputs),
            inputs: text.inputs.clone(),
            parameters: text.parameters.clone(),
            constants: text.constants.iter().map(|(_, value)| *value).collect(),
        })
    }

    /// Names of the outputs.
    pub fn outputs(&self) -> &[String] {
        &self.outputs
    }

    /// Names of the inputs.
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// Names of the states.
    pub fn states(&self) -> &[String] {
        &self.states
    }

    fn value(&self, side: &Side, (x, u, theta): (&[f64], &[f64], &[f64]), stack: &mut Vec<f64>) -> f64 {
        let (states, inputs, parameters) = (x.len(), x.len() + u.len(), x.len() + u.len() + theta.len());
        let value_at = |place: usize| match place {
            place if place < states => x[place],
            place if place < inputs => u[place - states],
            place if place < parameters => theta[place - inputs],
            place => self.constants.get(place - parameters).copied().unwrap_or(f64::NAN),
        };
        side.expression.value(|operand| side.places.get(operand).map_or(f64::NAN, |&place| value_at(place)), stack)
    }

    /// Derivatives of the states by time.
    pub(super) fn rates(&self, point: (&[f64], &[f64], &[f64]), stack: &mut Vec<f64>, rates: &mut [f64]) {
        for (rate, side) in rates.iter_mut().zip(&self.rates) {
            *rate = self.value(side, point, stack);
        }
    }

    /// Outputs.
    pub(super) fn shown(&self, point: (&[f64], &[f64], &[f64]), stack: &mut Vec<f64>, shown: &mut [f64]) {
        for (value, side) in shown.iter_mut().zip(&self.shown) {
            *value = self.value(side, point, stack);
        }
    }
}
