//! Variables of a unit: value reference, name, unit and description of each.

use doublet_core::model::{Derivative, RECORDED, Term, ThrustTreatment, Variable as Factor};
use doublet_dynamics::linear::{INPUT_NAMES, OUTPUT_NAMES, STATE_NAMES, Simulation, state_unit};

/// States of the motion, inputs, outputs beside the states and parameters of the thrust.
pub(crate) const STATES: usize = STATE_NAMES.len();
pub(crate) const INPUTS: usize = INPUT_NAMES.len();
pub(crate) const OUTPUTS: usize = OUTPUT_NAMES.len();
pub(crate) const THRUST_PARAMETERS: usize = 2;
/// Value references: each kind of variable begins at its own.
pub(crate) const INPUT_AT: u32 = 1;
pub(crate) const STATE_AT: u32 = 100;
pub(crate) const RATE_AT: u32 = 200;
pub(crate) const OUTPUT_AT: u32 = 300;
pub(crate) const THRUST_AT: u32 = 400;
pub(crate) const DERIVATIVE_AT: u32 = 1000;

/// Names and descriptions of the inputs, in the order of [`INPUT_NAMES`]; that of the thrust follows from the model.
const INPUT_TEXTS: [(&str, &str); INPUTS] = [
    ("delta_a", "Aileron deflection, positive right aileron down"),
    ("delta_e", "Elevator deflection, positive trailing edge down"),
    ("delta_r", "Rudder deflection, positive trailing edge left"),
    ("thrust_reference", "Sum of the thrusts at thrust_reference_airspeed; the thrust acting is the output thrust"),
];
/// Descriptions of the states, in the order of [`STATE_NAMES`].
const STATE_TEXTS: [&str; STATES] = [
    "Velocity along body x (forward)",
    "Velocity along body y (right)",
    "Velocity along body z (down)",
    "Roll rate, body axes",
    "Pitch rate, body axes",
    "Yaw rate, body axes",
    "Bank angle",
    "Pitch angle",
    "Heading",
    "Distance flown north",
    "Distance flown east",
    "Altitude, positive up",
];
/// Descriptions of the outputs, in the order of [`OUTPUT_NAMES`].
const OUTPUT_TEXTS: [&str; OUTPUTS] = [
    "True airspeed",
    "Angle of attack",
    "Angle of sideslip",
    "Specific force along body x at the centre of gravity",
    "Specific force along body y at the centre of gravity",
    "Specific force along body z at the centre of gravity",
    "Thrust acting: thrust_reference + thrust_slope * (airspeed - thrust_reference_airspeed)",
];

/// Kind of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    /// Set by the simulator.
    Input,
    /// A continuous state.
    State,
    /// The rate of the state with this value reference.
    Rate(u32),
    /// Follows from states and inputs.
    Output,
    /// A derivative or another number of the model, fixed during the flight.
    Parameter,
}

/// A variable of the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Value reference.
    pub reference: u32,
    /// Name.
    pub name: String,
    /// Unit; none where the unit of a recorded channel is not known.
    pub unit: Option<Unit>,
    /// One line.
    pub description: String,
    /// Kind.
    pub kind: VariableKind,
    /// Value at the start, in its unit.
    pub start: f64,
}

/// A unit as powers of the base units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Unit {
    /// Power of kg.
    pub kg: i32,
    /// Power of m.
    pub m: i32,
    /// Power of s.
    pub s: i32,
    /// Power of rad.
    pub rad: i32,
}

impl Unit {
    /// Unit of time.
    pub const SECOND: Self = Self { kg: 0, m: 0, s: 1, rad: 0 };

    /// The unit called `name` in the tables of states, inputs and outputs; dimensionless if it is not there.
    fn known(name: &str) -> Self {
        let (kg, m, s, rad) = match name {
            "m" => (0, 1, 0, 0),
            "m/s" => (0, 1, -1, 0),
            "m/s2" => (0, 1, -2, 0),
            "rad" => (0, 0, 0, 1),
            "rad/s" => (0, 0, -1, 1),
            "N" => (1, 1, -2, 0),
            _ => (0, 0, 0, 0),
        };
        Self { kg, m, s, rad }
    }

    fn per_second(self) -> Self {
        Self { s: self.s - 1, ..self }
    }

    /// Unit of a derivative by `term`; none if a factor is a channel whose unit is not known.
    fn of_derivative(term: &Term) -> Option<Self> {
        let mut unit = Self::default();
        for &(factor, power) in term.factors() {
            match factor {
                Factor::Other1 | Factor::Other2 | Factor::Other3 | Factor::Other4 => return None,
                Factor::PropellerPressure | Factor::ThrustCoefficient | Factor::Mach => {}
                Factor::Airspeed => (unit.m, unit.s) = (unit.m - power, unit.s + power),
                Factor::Altitude => unit.m -= power,
                _ => unit.rad -= power,
            }
        }
        Some(unit)
    }

    /// Name, for example `m/s2`; `1` of a number without dimension.
    pub fn name(self) -> String {
        match self {
            Self { kg: 1, m: 1, s: -2, rad: 0 } => return "N".to_owned(),
            Self { kg: 1, m: 0, s: -1, rad: 0 } => return "N.s/m".to_owned(),
            _ => {}
        }
        let powers = [("kg", self.kg), ("m", self.m), ("rad", self.rad), ("s", self.s)];
        let side = |sign: i32| {
            let factors = powers.iter().filter(|(_, power)| power * sign > 0).map(|(name, power)| match power.abs() {
                1 => (*name).to_owned(),
                power => format!("{name}{power}"),
            });
            factors.collect::<Vec<_>>()
        };
        let (above, below) = (side(1), side(-1));
        let above = if above.is_empty() { "1".to_owned() } else { above.join(".") };
        match below.len() {
            0 => above,
            1 => format!("{above}/{}", below.concat()),
            _ => format!("{above}/({})", below.join(".")),
        }
    }
}

/// Every variable of a simulation but time, whose value reference is 0.
pub fn variables(simulation: &Simulation, names: &[String]) -> Vec<Variable> {
    let mut all = Vec::new();
    let mut push = |reference: u32, name: &str, unit: Option<Unit>, description: String, kind, start| {
        all.push(Variable { reference, name: name.to_owned(), unit, description, kind, start });
    };
    for (index, ((name, text), (_, unit))) in INPUT_TEXTS.iter().zip(INPUT_NAMES).enumerate() {
        let mut text = (*text).to_owned();
        if index == INPUTS - 1 {
            text += thrust_effect(simulation);
        }
        let unit = Some(Unit::known(unit));
        push(INPUT_AT + index as u32, name, unit, text, VariableKind::Input, simulation.input[index]);
    }
    for (index, (name, text)) in STATE_NAMES.iter().zip(STATE_TEXTS).enumerate() {
        let (at, unit) = (index as u32, Unit::known(state_unit(name)));
        push(STATE_AT + at, name, Some(unit), text.to_owned(), VariableKind::State, simulation.state[index]);
    }
    for (index, (name, text)) in STATE_NAMES.iter().zip(STATE_TEXTS).enumerate() {
        let (at, unit) = (index as u32, Unit::known(state_unit(name)).per_second());
        let kind = VariableKind::Rate(STATE_AT + at);
        push(RATE_AT + at, &format!("der({name})"), Some(unit), format!("Rate of {name}: {text}"), kind, 0.0);
    }
    for (index, ((name, unit), text)) in OUTPUT_NAMES.iter().zip(OUTPUT_TEXTS).enumerate() {
        let unit = Some(Unit::known(unit));
        push(OUTPUT_AT + index as u32, name, unit, text.to_owned(), VariableKind::Output, 0.0);
    }
    for (index, (name, unit, text, value)) in thrust_parameters(simulation).into_iter().enumerate() {
        push(THRUST_AT + index as u32, name, Some(unit), text.to_owned(), VariableKind::Parameter, value);
    }
    for (index, (name, entry)) in names.iter().zip(simulation.model.derivatives.entries()).enumerate() {
        let (unit, text) = (Unit::of_derivative(&entry.term), derivative_text(entry));
        push(DERIVATIVE_AT + index as u32, name, unit, text, VariableKind::Parameter, entry.value);
    }
    all
}

/// What the thrust does in this model.
fn thrust_effect(simulation: &Simulation) -> &'static str {
    let model = &simulation.model;
    match model.thrust {
        _ if !model.has_thrust() => ". No effect: the coefficients contain the thrust",
        ThrustTreatment::Included => ". Acts through the thrust coefficient Tc of the model",
        ThrustTreatment::ForceRemoved => ". Acts as a force; the coefficients contain its moment",
        ThrustTreatment::Removed => ". Acts as a force and a moment",
    }
}

/// Parameters of the thrust: name, unit, description, value.
fn thrust_parameters(simulation: &Simulation) -> [(&'static str, Unit, &'static str, f64); THRUST_PARAMETERS] {
    let condition = &simulation.condition;
    let slope = Unit { kg: 1, m: 0, s: -1, rad: 0 };
    [
        (
            "thrust_slope",
            slope,
            "Change of thrust with airspeed at constant power setting. 0: thrust_reference is the thrust acting, for an external propeller model",
            condition.thrust_slope_n_s_m,
        ),
        (
            "thrust_reference_airspeed",
            Unit::known("m/s"),
            "True airspeed at which the thrust acting equals thrust_reference",
            condition.airspeed_m_s,
        ),
    ]
}

/// Description of a derivative.
fn derivative_text(entry: &Derivative) -> String {
    let coefficient = entry.coefficient.name();
    if entry.term.is_constant() {
        return format!("Constant of {coefficient}");
    }
    let factors = entry.term.factors();
    let texts: Vec<_> =
        factors.iter().map(|(factor, _)| format!("{}: {}", factor.name(), factor.description())).collect();
    let held = factors.iter().any(|(factor, _)| RECORDED.iter().any(|(recorded, _)| recorded == factor));
    let held = if held { "; held at its value of the start" } else { "" };
    format!("Derivative of {coefficient} with respect to {} ({}){held}", entry.term, texts.join("; "))
}
