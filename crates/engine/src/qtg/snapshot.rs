//! Steady flight: the model's own trim beside the recorded one.

use std::ops::Range;

use doublet_core::estimate::Fit;
use doublet_core::model::{
    Coefficient, Derivatives, Engine, Structure, Term, ThrustTreatment, Variable, VariableValues,
};
use doublet_core::validate::{Histories, Signal};
use nalgebra::{Matrix2, Vector2};

use crate::graph::StageResult;
use crate::session::Surface;
use crate::stage::{PooledFits, Quantity, WindowAero, constant_name, deflection};

/// Numbers of one trim.
pub type Values = Vec<(Quantity, f64)>;

/// A trim as flown and as the model has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Means of the flight, SI.
    pub flight: Values,
    /// The model's, SI.
    pub model: Values,
}

impl Snapshot {
    /// What changed since another trim.
    pub fn since(&self, trim: &Self) -> Self {
        Self { flight: Self::changes(&self.flight, &trim.flight), model: Self::changes(&self.model, &trim.model) }
    }

    fn changes(now: &Values, before: &Values) -> Values {
        let change = |(quantity, value): &(Quantity, f64)| {
            let (_, before) = before.iter().find(|(known, _)| known == quantity)?;
            Some((*quantity, value - before))
        };
        now.iter().filter_map(change).collect()
    }
}

/// Derivatives of the pooled estimate; constants that every window has for itself are the mean of the identification's, so that the
/// model predicts a trim instead of following it.
pub fn model(pooled: &PooledFits, structure: &Structure) -> StageResult<Derivatives> {
    let mut entries = Vec::new();
    for (coefficient, terms) in &structure.models {
        let name = coefficient.name();
        let fit = pooled.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let fit = fit.ok_or_else(|| format!("{name} has no estimate"))?;
        let estimate = fit.fit.as_ref().map_err(|error| format!("{name} has no estimate: {error}"))?;
        let windows: Vec<&str> = fit.windows.iter().map(|(window, _)| window.as_str()).collect();
        for term in terms {
            let value = value_of(estimate, *coefficient, term, &windows)?;
            entries.push((*coefficient, term.clone(), value));
        }
    }
    Ok(entries.into_iter().collect())
}

fn value_of(estimate: &Fit, coefficient: Coefficient, term: &Term, windows: &[&str]) -> StageResult<f64> {
    let name = term.derivative_name(coefficient);
    if let Some((value, _)) = estimate.parameter(&name) {
        return Ok(value);
    }
    let own = windows.iter().filter_map(|window| Some(estimate.parameter(&constant_name(&name, window))?.0));
    let own: Vec<f64> = own.collect();
    if own.is_empty() {
        return Err(format!("{name} has no estimate").into());
    }
    Ok(own.iter().sum::<f64>() / own.len() as f64)
}

/// The trim between two times of the recording.
///
/// The model is asked for the angle of attack and the elevator that give the recorded mean `CZ` and `Cm`, and for the sideslip and the
/// aileron that give the recorded mean `Cl` and `Cn`, at the recorded airspeed, rates, rudder and power. Its pitch angle differs from
/// the recorded one as its angle of attack does, at the same flight-path angle; its bank holds the side force:
/// `m g cos(theta) sin(phi) + q S CY` is that of the flight. What its `CX` leaves of the recorded force along body x is more or less
/// thrust, or at the recorded thrust more or less rate of climb.
pub fn snapshot(
    model: &Derivatives,
    aero: &WindowAero,
    measured: &Histories,
    [from_s, to_s]: [f64; 2],
    gravity_m_s2: f64,
) -> StageResult<Snapshot> {
    let inside =
        |time_s: &[f64]| time_s.partition_point(|&time| time < from_s)..time_s.partition_point(|&time| time <= to_s);
    let mean = |values: &[f64], range: &std::ops::Range<usize>| {
        let values = values.get(range.clone()).unwrap_or_default();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let rows = inside(&aero.coefficients.time_s);
    let samples = inside(&aero.data.time_s);
    if rows.is_empty() || samples.is_empty() {
        return Err(format!("no sample from {from_s:.1} to {to_s:.1} s").into());
    }
    let mut flown: VariableValues = [0.0; Variable::ALL.len()];
    for variable in aero.variables.known() {
        flown[variable as usize] = mean(aero.variables.get(variable).unwrap_or_default(), &rows);
    }
    let observed = |coefficient: Coefficient| mean(aero.coefficients.get(coefficient), &rows);
    let targets = [Coefficient::CZ, Coefficient::Cm].map(|c| (c as usize, observed(c)));
    let mut trimmed = solve(model, flown, [Variable::Alpha, Variable::Elevator], targets)?;
    let targets = [Coefficient::Cl, Coefficient::Cn].map(|c| (c as usize, observed(c)));
    trimmed = solve(model, trimmed, [Variable::Beta, Variable::Aileron], targets)?;
    let signal = |signal: Signal| mean(measured.get(signal), &samples);
    let (theta, phi) = (signal(Signal::PitchAngle), signal(Signal::BankAngle));
    let density = mean(&aero.data.density_kg_m3, &samples);
    let pressure = 0.5 * density * signal(Signal::Airspeed).powi(2);
    let mass = aero.data.mass.at(samples.start).mass_kg;
    let side = model.body_coefficients(&trimmed)[Coefficient::CY as usize] - observed(Coefficient::CY);
    let side = pressure * aero.settings.reference.area_m2 * side / (mass * gravity_m_s2 * theta.cos());
    let changed = |variable: Variable| trimmed[variable as usize] - flown[variable as usize];
    let mut result = Snapshot { flight: Vec::new(), model: Vec::new() };
    let mut add = |quantity: Quantity, flight: f64, model: f64| {
        result.flight.push((quantity, flight));
        result.model.push((quantity, model));
    };
    add(Quantity::Signal(Signal::PitchAngle), theta, theta + changed(Variable::Alpha));
    let alpha = signal(Signal::AngleOfAttack);
    add(Quantity::Signal(Signal::AngleOfAttack), alpha, alpha + changed(Variable::Alpha));
    let beta = signal(Signal::Sideslip);
    add(Quantity::Signal(Signal::Sideslip), beta, beta + changed(Variable::Beta));
    // The model is trimmed at the airspeed of the flight.
    add(Quantity::Signal(Signal::Airspeed), signal(Signal::Airspeed), signal(Signal::Airspeed));
    add(Quantity::Signal(Signal::BankAngle), phi, (phi.sin() - side).clamp(-1.0, 1.0).asin());
    let performance = Performance { found: &trimmed, flown: &observed, pressure, mass_kg: mass, gravity_m_s2 };
    performance.add(model, aero, &samples, alpha, measured, &mut add);
    for (surface, variable) in [(Surface::Elevator, Variable::Elevator), (Surface::Aileron, Variable::Aileron)] {
        if let Some(values) = deflection(surface, aero) {
            let flight = mean(values, &samples);
            add(Quantity::Surface(surface), flight, flight + changed(variable));
        }
    }
    Ok(result)
}

/// Force left along body x by the trimmed model, as thrust and as rate of climb.
struct Performance<'a> {
    found: &'a VariableValues,
    flown: &'a dyn Fn(Coefficient) -> f64,
    pressure: f64,
    mass_kg: f64,
    gravity_m_s2: f64,
}

impl Performance<'_> {
    /// The thrust the model needs for the recorded acceleration, and its rate of climb at the recorded thrust, beside the recorded ones.
    fn add(
        &self,
        model: &Derivatives,
        aero: &WindowAero,
        samples: &Range<usize>,
        alpha_rad: f64,
        measured: &Histories,
        add: &mut impl FnMut(Quantity, f64, f64),
    ) {
        let area_m2 = aero.settings.reference.area_m2;
        let more = model.body_coefficients(self.found)[Coefficient::CX as usize] - (self.flown)(Coefficient::CX);
        let excess_n = self.pressure * area_m2 * more;
        let sum = |value: &dyn Fn(&Engine) -> f64| aero.data.engines.iter().map(value).sum::<f64>();
        let mean = |engine: &Engine| {
            let values = engine.thrust_n.get(samples.clone()).unwrap_or_default();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        };
        let thrust_n = sum(&mean);
        let forward_n = sum(&|engine| mean(engine) * engine.direction_body[0]);
        if aero.settings.thrust != ThrustTreatment::Included && thrust_n > 0.0 && forward_n > 0.0 {
            add(Quantity::NetThrust, thrust_n, thrust_n - excess_n * thrust_n / forward_n);
        }
        let (time_s, altitude_m) = (&measured.time_s, measured.get(Signal::Altitude));
        let airspeed_m_s = samples.clone().filter_map(|k| aero.data.airspeed_m_s.get(k)).sum::<f64>();
        let airspeed_m_s = airspeed_m_s / samples.len().max(1) as f64;
        if let Some(climb_m_s) = slope(time_s, altitude_m, samples.clone()) {
            let weight_n = self.mass_kg * self.gravity_m_s2;
            let more_m_s = airspeed_m_s * excess_n * alpha_rad.cos() / weight_n;
            add(Quantity::ClimbRate, climb_m_s, climb_m_s + more_m_s);
        }
    }
}

/// Slope of the straight line through samples.
fn slope(time_s: &[f64], values: &[f64], samples: Range<usize>) -> Option<f64> {
    let (time_s, values) = (time_s.get(samples.clone())?, values.get(samples)?);
    let count = time_s.len() as f64;
    let (time, value) = (time_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let pairs = time_s.iter().zip(values);
    let with: f64 = pairs.map(|(t, v)| (t - time) * (v - value)).sum();
    let square: f64 = time_s.iter().map(|t| (t - time).powi(2)).sum();
    Some(with / square).filter(|slope| slope.is_finite())
}

/// The values with two of them changed so that two coefficients reach their targets, by Newton's method.
fn solve(
    model: &Derivatives,
    mut values: VariableValues,
    unknown: [Variable; 2],
    targets: [(usize, f64); 2],
) -> StageResult<VariableValues> {
    const STEP: f64 = 1e-5;
    const CLOSE: f64 = 1e-10;
    const MOST: usize = 30;
    let at = |values: &VariableValues| {
        let found = model.body_coefficients(values);
        Vector2::from(targets.map(|(index, target)| found[index] - target))
    };
    for _ in 0..MOST {
        let column = |variable: Variable| {
            let moved = |step: f64| {
                let mut values = values;
                values[variable as usize] += step;
                at(&values)
            };
            (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
        };
        let slopes = Matrix2::from_columns(&unknown.map(column));
        let Some(inverse) = slopes.try_inverse() else { break };
        let step = inverse * at(&values);
        unknown.iter().zip(step.iter()).for_each(|(variable, step)| values[*variable as usize] -= step);
        if step.amax() < CLOSE {
            return Ok(values);
        }
    }
    let [first, second] = unknown.map(Variable::name);
    Err(format!("no {first} and {second} trim the model").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trim_of_a_model_with_a_square_is_that_of_hand_calculation() {
        let term = |text: &str| Term::parse(text).unwrap();
        let model: Derivatives = [
            (Coefficient::CZ, term("1"), -0.5),
            (Coefficient::CZ, term("alpha"), -4.0),
            (Coefficient::CZ, term("alpha^2"), -2.0),
            (Coefficient::Cm, term("alpha"), -0.8),
            (Coefficient::Cm, term("delta_e"), -0.5),
        ]
        .into_iter()
        .collect();
        // alpha = 0.1: CZ = -0.5 - 0.4 - 0.02; Cm = 0.02 needs delta_e = -(0.02 + 0.08) / 0.5.
        let targets = [(2, -0.92), (4, 0.02)];
        let found = solve(&model, [0.0; Variable::ALL.len()], [Variable::Alpha, Variable::Elevator], targets).unwrap();
        assert!((found[Variable::Alpha as usize] - 0.1).abs() < 1e-10);
        assert!((found[Variable::Elevator as usize] + 0.2).abs() < 1e-10);
        let error = solve(&model, found, [Variable::Beta, Variable::Aileron], [(3, 0.1), (5, 0.0)]).unwrap_err();
        assert_eq!(error.to_string(), "no beta and delta_a trim the model");
    }
}
