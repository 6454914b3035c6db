//! Equations of motion from their text, or from a function.

use std::fmt::Debug;
use std::sync::Arc;

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

/// Points of states, inputs and parameters, as columns of one value for each point.
#[derive(Clone, Copy, Debug)]
pub struct EquationPoints<'a> {
    /// Number of points.
    pub count: usize,
    /// A column for each state.
    pub states: &'a [&'a [f64]],
    /// A column for each input.
    pub inputs: &'a [&'a [f64]],
    /// A column for each parameter; a column of one value holds for all points.
    pub parameters: &'a [&'a [f64]],
}

/// Right-hand sides that are computed by a function instead of expressions, at many points at once. Where it has no value it gives one that is not
/// finite: the search then tries another step.
pub trait EquationFunction: Debug + Send + Sync {
    /// Derivatives of the states by time: a column for each state.
    fn rates(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>>;

    /// Outputs that are not states: a column for each.
    fn shown(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>>;
}

/// Names of equations of motion whose right-hand sides are a function. An output with the name of a state is this state.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct EquationNames {
    pub states: Vec<String>,
    pub outputs: Vec<String>,
    /// Recorded columns.
    pub inputs: Vec<String>,
    /// Free parameters and where the search starts.
    pub parameters: Vec<(String, f64)>,
}

/// Equations of motion `x' = f(x, u, theta)`, `y = h(x, u, theta)`.
#[derive(Clone, Debug)]
pub struct EquationModel {
    pub(super) states: Vec<String>,
    pub(super) outputs: Vec<String>,
    pub(super) inputs: Vec<String>,
    pub(super) parameters: Vec<(String, f64)>,
    pub(super) sides: Sides,
    /// Output that each state is, where one is the state alone.
    pub(super) output_of_state: Vec<Option<usize>>,
}

/// Right-hand sides.
#[derive(Clone, Debug)]
pub(super) enum Sides {
    Expressions(Expressions),
    Function(Arc<dyn EquationFunction>),
}

/// Right-hand sides as expressions.
#[derive(Clone, Debug)]
pub(super) struct Expressions {
    constants: Vec<f64>,
    rates: Vec<Side>,
    shown: Vec<Side>,
}

/// A right-hand side, with the place of each of its operands among states, inputs, parameters and constants.
#[derive(Clone, Debug)]
struct Side {
    expression: Expression,
    places: Vec<usize>,
}

/// Refuses equations without states or outputs, and a name that is two things; all names in order.
fn check_names<'a>(
    (states, outputs): (&'a [&'a str], usize),
    others: [(&'static str, Vec<&'a str>); 3],
) -> Result<Vec<&'a str>, EquationFault> {
    for (what, count) in [("state", states.len()), ("output", outputs)] {
        if count == 0 {
            return Err(EquationFault::Without { what });
        }
    }
    let mut all: Vec<(&'static str, &str)> = states.iter().map(|name| ("a state", *name)).collect();
    for (kind, names) in others {
        all.extend(names.into_iter().map(|name| (kind, name)));
    }
    for (index, (second, name)) in all.iter().enumerate() {
        if let Some((first, _)) = all[..index].iter().find(|(_, other)| other == name) {
            return Err(EquationFault::Twice { name: (*name).to_owned(), first, second });
        }
    }
    Ok(all.into_iter().map(|(_, name)| name).collect())
}

impl EquationModel {
    /// Understands equations.
    ///
    /// # Errors
    /// [`EquationFault`]: no state or output, a name that is two things, an expression that is not understood.
    pub fn new(text: &EquationText) -> Result<Self, EquationFault> {
        let states: Vec<&str> = text.states.iter().map(|(name, _)| name.as_str()).collect();
        let of_values = |pairs: &'_ [(String, f64)]| pairs.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let (parameters, constants) = (of_values(&text.parameters), of_values(&text.constants));
        let kinds = [
            ("an input", text.inputs.iter().map(String::as_str).collect()),
            ("a parameter", parameters.iter().map(String::as_str).collect()),
            ("a constant", constants.iter().map(String::as_str).collect()),
        ];
        let names = check_names((&states, text.outputs.len()), kinds)?;
        let shown = text
            .outputs
            .iter()
            .map(|output| Self::parse_side("output", output, &names))
            .collect::<Result<Vec<_>, _>>()?;
        let sides = Expressions {
            rates: text
                .states
                .iter()
                .map(|state| Self::parse_side("state", state, &names))
                .collect::<Result<_, _>>()?,
            constants: text.constants.iter().map(|(_, value)| *value).collect(),
            shown,
        };
        Ok(Self {
            output_of_state: states
                .iter()
                .map(|state| text.outputs.iter().position(|(_, expression)| expression.trim() == *state))
                .collect(),
            sides: Sides::Expressions(sides),
            states: states.into_iter().map(str::to_owned).collect(),
            outputs: text.outputs.iter().map(|(name, _)| name.clone()).collect(),
            inputs: text.inputs.clone(),
            parameters: text.parameters.clone(),
        })
    }

    fn parse_side(kind: &str, (name, text): &(String, String), names: &[&str]) -> Result<Side, EquationFault> {
        let fault = |error| EquationFault::Expression { place: format!("{kind} '{name}'"), error };
        let expression = Expression::parse_names(text, "state, input or parameter", names).map_err(fault)?;
        let place = |(operand, _): &(Operand, usize)| {
            let name = match operand {
                Operand::Channel(name) => name.as_str(),
                Operand::Role(role) => role.name(),
            };
            names.iter().position(|other| *other == name).unwrap_or(usize::MAX)
        };
        Ok(Side { places: expression.operands().iter().map(place).collect(), expression })
    }

    /// Equations whose right-hand sides are a function.
    ///
    /// # Errors
    /// [`EquationFault`]: no state or output, a name that is two things.
    pub fn with_function(names: EquationNames, function: Arc<dyn EquationFunction>) -> Result<Self, EquationFault> {
        let EquationNames { states, outputs, inputs, parameters } = names;
        let of_states: Vec<&str> = states.iter().map(String::as_str).collect();
        let kinds = [
            ("an input", inputs.iter().map(String::as_str).collect()),
            ("a parameter", parameters.iter().map(|(name, _)| name.as_str()).collect()),
            ("a constant", Vec::new()),
        ];
        check_names((&of_states, outputs.len()), kinds)?;
        let output_of_state = states.iter().map(|state| outputs.iter().position(|output| output == state)).collect();
        Ok(Self { states, outputs, inputs, parameters, sides: Sides::Function(function), output_of_state })
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

    /// Derivatives of the states by time at many points, a column for each state.
    pub(super) fn rates(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        match &self.sides {
            Sides::Expressions(sides) => sides.at_points(&sides.rates, points),
            Sides::Function(function) => whole(function.rates(points), self.states.len(), points.count),
        }
    }

    /// Outputs at many points, a column for each.
    pub(super) fn shown(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        let function = match &self.sides {
            Sides::Expressions(sides) => return sides.at_points(&sides.shown, points),
            Sides::Function(function) => function,
        };
        let state_of = |output: usize| self.output_of_state.iter().position(|found| *found == Some(output));
        let states: Vec<Option<usize>> = (0..self.outputs.len()).map(state_of).collect();
        let others = states.iter().filter(|state| state.is_none()).count();
        let others = if others == 0 { Vec::new() } else { whole(function.shown(points), others, points.count) };
        let mut others = others.into_iter();
        let column = |state: Option<usize>| match state {
            Some(state) => points.states[state].to_vec(),
            None => others.next().unwrap_or_default(),
        };
        states.into_iter().map(column).collect()
    }
}

/// Columns as many and as long as they should be; what is missing is not a number.
fn whole(mut columns: Vec<Vec<f64>>, count: usize, points: usize) -> Vec<Vec<f64>> {
    columns.resize(count, Vec::new());
    columns.iter_mut().for_each(|column| column.resize(points, f64::NAN));
    columns
}

impl Expressions {
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

    /// Values of `sides`, point by point.
    fn at_points(&self, sides: &[Side], points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        let mut columns = vec![Vec::with_capacity(points.count); sides.len()];
        let (mut x, mut u, mut theta, mut stack) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for point in 0..points.count {
            for (values, from) in [(&mut x, points.states), (&mut u, points.inputs), (&mut theta, points.parameters)] {
                values.clear();
                values.extend(from.iter().map(|column| column[if column.len() == 1 { 0 } else { point }]));
            }
            for (column, side) in columns.iter_mut().zip(sides) {
                column.push(self.value(side, (&x, &u, &theta), &mut stack));
            }
        }
        columns
    }
}
