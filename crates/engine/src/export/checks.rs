//! Points a file is checked at: conditions inside the range identified, and what the model gives there.

use std::fmt::Write;

use doublet_core::model::Variable;

use super::{CHECK_TOLERANCE, IdentifiedCoefficient, IdentifiedModel, MARK};

/// How many points beside the middle of all ranges.
const POINTS: usize = 40;
/// Primes of the Halton sequence, one per variable.
const PRIMES: [u32; Variable::ALL.len()] =
    [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83];

/// One point: values of the variables, the inputs a simulator has there, and the coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckPoint {
    /// Name, unit and value of each input, in the order of [`inputs`].
    pub inputs: Vec<(Input, f64)>,
    /// The modelled coefficients, in the order of the model.
    pub outputs: Vec<f64>,
    /// Rounding allowed for each.
    pub tolerances: Vec<f64>,
}

/// A quantity a simulator gives: a variable of the model before it is made dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Variable it stands for.
    pub variable: Variable,
    /// Name in files.
    pub name: &'static str,
    /// Name as flight simulators have it (the style of ANSI/AIAA S-119).
    pub signal: &'static str,
    /// Unit as DAVE-ML abbreviates it.
    pub unit: &'static str,
    pub description: &'static str,
}

/// Inputs the model needs, the airspeed always among them.
pub fn inputs(model: &IdentifiedModel) -> Vec<Input> {
    let used = model.variables();
    let needed = |variable: Variable| variable == Variable::Airspeed || used.contains(&variable);
    Variable::ALL.iter().copied().filter(|&variable| needed(variable)).map(input).collect()
}

fn input(variable: Variable) -> Input {
    let (name, signal, unit, description) = match variable {
        Variable::Alpha => ("alpha", "angleOfAttack", "rad", "angle of attack, atan2(w, u)"),
        Variable::AlphaDot => ("alpha_dot", "angleOfAttackRate", "rad_s", "rate of the angle of attack"),
        Variable::Beta => ("beta", "angleOfSideslip", "rad", "angle of sideslip, atan2(v, sqrt(u^2 + w^2))"),
        Variable::BetaDot => ("beta_dot", "angleOfSideslipRate", "rad_s", "rate of the angle of sideslip"),
        Variable::RollRate => ("p", "bodyAngularRate_Roll", "rad_s", "roll rate, body axes"),
        Variable::PitchRate | Variable::HalfPitchRate => {
            ("q", "bodyAngularRate_Pitch", "rad_s", "pitch rate, body axes")
        }
        Variable::YawRate => ("r", "bodyAngularRate_Yaw", "rad_s", "yaw rate, body axes"),
        Variable::Aileron => ("delta_a", "aileronDeflection", "rad", "aileron, positive right aileron down"),
        Variable::Elevator => ("delta_e", "elevatorDeflection", "rad", "elevator, positive trailing edge down"),
        Variable::Rudder => ("delta_r", "rudderDeflection", "rad", "rudder, positive trailing edge left"),
        Variable::PropellerPressure => (
            "dpt_q",
            "propellerPressureRiseRatio",
            "nd",
            "total-pressure rise through the propellers over dynamic pressure",
        ),
        Variable::ThrustCoefficient => ("Tc", "thrustCoefficient", "nd", "thrust over dynamic pressure and area"),
        Variable::Airspeed => ("V", "trueAirspeed", "m_s", "true airspeed"),
        Variable::Altitude => ("h", "altitude", "m", "altitude"),
        Variable::Mach => ("mach", "mach", "nd", "Mach number"),
        Variable::Flap => ("flap", "flapDeflection", "rad", "flap deflection"),
        Variable::ElevatorTrim => ("delta_te", "elevatorTrimTabDeflection", "rad", "elevator trim tab deflection"),
        Variable::Stabiliser => ("stabiliser", "stabilizerDeflection", "rad", "incidence of the stabiliser"),
        Variable::Other1 => ("other_1", "other1", "nd", "the channel recorded as other_1"),
        Variable::Other2 => ("other_2", "other2", "nd", "the channel recorded as other_2"),
        Variable::Other3 => ("other_3", "other3", "nd", "the channel recorded as other_3"),
        Variable::Other4 => ("other_4", "other4", "nd", "the channel recorded as other_4"),
    };
    Input { variable, name, signal, unit, description }
}

/// How a rate is made dimensionless: rate times `length_m` over the airspeed, written as rate times `symbol` over n airspeeds.
pub struct Normalisation {
    pub length_m: f64,
    /// The reference length it is a part of: `b`, that of `Cl` and `Cn`, or `c`.
    pub symbol: &'static str,
    /// How often it goes into that length.
    pub divisor: f64,
}

/// Normalisation of a variable that is a rate made dimensionless; `None` for all others.
pub fn normalisation(model: &IdentifiedModel, variable: Variable) -> Option<Normalisation> {
    let reference = &model.reference;
    let (length_m, symbol, divisor) = match variable {
        Variable::RollRate | Variable::YawRate | Variable::BetaDot => {
            (reference.lateral_rate_length_m, "b", reference.lateral_rate_divisor())
        }
        Variable::PitchRate | Variable::AlphaDot => {
            (reference.pitch_rate_length_m, "c", reference.pitch_rate_divisor())
        }
        Variable::HalfPitchRate => (reference.chord_m / 2.0, "c", 2.0),
        _ => return None,
    };
    Some(Normalisation { length_m, symbol, divisor })
}

/// How a variable reads with the model's normalisation, for example `q c/V`.
pub(crate) fn normalised_name(model: &IdentifiedModel, variable: Variable) -> Option<String> {
    let Normalisation { symbol, divisor, .. } = normalisation(model, variable)?;
    let rate = input(variable).name;
    Some(if divisor == 1.0 { format!("{rate} {symbol}/V") } else { format!("{rate} {symbol}/({divisor} V)") })
}

/// The middle of all ranges, then points spread evenly over them (Halton).
pub fn points(model: &IdentifiedModel) -> Vec<CheckPoint> {
    (0..=POINTS).map(|index| point(model, |axis| if index == 0 { 0.5 } else { halton(index, PRIMES[axis]) })).collect()
}

/// The point at a fraction of each variable's range.
pub fn point(model: &IdentifiedModel, fraction: impl Fn(usize) -> f64) -> CheckPoint {
    let mut values = [0.0; Variable::ALL.len()];
    for (&variable, &(low, high)) in &model.ranges {
        let index = variable as usize;
        values[index] = low + (high - low) * fraction(index);
    }
    let airspeed = values[Variable::Airspeed as usize];
    // What a simulator has is the rate: the variable is formed from it as the files form it.
    let inputs: Vec<_> = inputs(model)
        .into_iter()
        .map(|input| {
            let value = &mut values[input.variable as usize];
            let Some(normalisation) = normalisation(model, input.variable) else { return (input, *value) };
            let factor = normalisation.length_m / airspeed;
            let rate = *value / factor;
            *value = rate * factor;
            (input, rate)
        })
        .collect();
    let sums = model.derivatives().sums(&values);
    let outputs = model.coefficients.iter().map(|c| sums[c.coefficient as usize]).collect();
    let size = |c: &IdentifiedCoefficient| -> f64 {
        c.parameters.iter().map(|p| (p.value * p.term.value(|variable| values[variable as usize])).abs()).sum()
    };
    let tolerances = model.coefficients.iter().map(|c| CHECK_TOLERANCE * size(c).max(1.0)).collect();
    CheckPoint { inputs, outputs, tolerances }
}

/// Element `index` of the van der Corput sequence to a base.
fn halton(index: usize, base: u32) -> f64 {
    let base = base as usize;
    let (mut rest, mut result, mut scale) = (index, 0.0, 1.0);
    while rest > 0 {
        scale /= base as f64;
        result += (rest % base) as f64 * scale;
        rest /= base;
    }
    result
}

/// The points as CSV: inputs in SI, coefficients.
pub fn table(model: &IdentifiedModel) -> String {
    let mut text = format!("# {MARK}: check points of {}\n", model.aircraft);
    let inputs: Vec<_> = inputs(model).iter().map(|input| format!("{}_{}", input.name, input.unit)).collect();
    let outputs: Vec<_> = model.coefficients.iter().map(|c| c.coefficient.name().to_owned()).collect();
    text.push_str(&[inputs, outputs].concat().join(","));
    text.push('\n');
    for point in points(model) {
        let numbers = point.inputs.iter().map(|(_, value)| value).chain(&point.outputs);
        let row: Vec<_> = numbers.map(|value| format!("{value:e}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", row.join(","));
    }
    text
}
