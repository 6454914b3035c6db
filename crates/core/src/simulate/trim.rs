//! Steady level flight.

use nalgebra::{SMatrix, SVector, Vector3};

use super::SimulateError;
use super::vehicle::{Body, Controls, Environment, Surface, Thrust, Vehicle};
use crate::atmos::Atmosphere;
use crate::motion::State;
use crate::propulsion::{Ambient, EngineInput};

/// Newton steps before giving up.
const MAX_STEPS: usize = 40;
/// Residual accelerations at which the trim is accepted, m/s² and rad/s².
const TOLERANCE: f64 = 1e-11;
/// Names and units of the residuals.
const EQUATIONS: [(&str, &str); 6] = [
    ("the forward acceleration", "m/s^2"),
    ("the sideward acceleration", "m/s^2"),
    ("the vertical acceleration", "m/s^2"),
    ("the roll acceleration", "rad/s^2"),
    ("the pitch acceleration", "rad/s^2"),
    ("the yaw acceleration", "rad/s^2"),
];

/// A condition to trim at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct TrimCondition {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    pub heading_rad: f64,
    /// Engine speed of both engines, rad/s.
    pub engine_speed_rad_s: f64,
    pub wind_ned_m_s: Vector3<f64>,
}

/// Steady, straight, level flight without sideslip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim {
    /// State at position zero, altitude as wanted.
    pub state: State,
    /// Air, engines and controls.
    pub environment: Environment,
    /// Engine inputs that give the thrust.
    pub engines: [EngineInput; 2],
    /// Angle of attack, rad.
    pub alpha_rad: f64,
    /// Newton steps taken.
    pub iterations: usize,
}

/// Trims: the angle of attack, bank, thrust and three deflections at which no acceleration is left, by Newton's method with
/// a central-difference Jacobian; pitch follows from level flight. Both engines run alike.
///
/// # Errors
/// [`SimulateError::TrimNotFound`], [`SimulateError::TrimPastAlpha`], [`SimulateError::TrimPastThrust`] and
/// [`SimulateError::PastStop`], each with how much is missing; [`SimulateError::Model`] outside the atmosphere.
pub fn trim(
    vehicle: &Vehicle,
    body: &Body,
    atmosphere: &Atmosphere,
    condition: &TrimCondition,
) -> Result<Trim, SimulateError> {
    let mut environment = Environment::still(vehicle, atmosphere, condition.altitude_m)?;
    environment.wind_ned_m_s = condition.wind_ned_m_s;
    environment.ground_m = f64::NEG_INFINITY;
    let speeds = [condition.engine_speed_rad_s; 2];
    environment.rotor_momentum_n_m_s =
        vehicle.powerplant.rotor_momentum_body(&speeds, crate::propulsion::RotorSum::Signed);
    let (unknowns, iterations) = solve(vehicle, body, condition, &environment)?;
    let (state, mut environment) = apply(&unknowns, condition, &environment);
    let alpha_rad = unknowns[0];
    let (low, high) = vehicle.alpha_range_rad;
    if !(low..=high).contains(&alpha_rad) {
        return Err(SimulateError::TrimPastAlpha {
            airspeed_m_s: condition.airspeed_m_s,
            altitude_m: condition.altitude_m,
            needed_deg: alpha_rad.to_degrees(),
            low_deg: low.to_degrees(),
            high_deg: high.to_degrees(),
        });
    }
    let what = format!("trim at {:.1} m/s and {:.0} m", condition.airspeed_m_s, condition.altitude_m);
    for surface in Surface::ALL {
        vehicle.stops.check(surface, environment.controls.get(surface), &what)?;
    }
    let ambient = ambient(atmosphere, condition, environment.density_kg_m3)?;
    let needed_n = environment.thrust[0].force_n;
    let input = throttle_for(vehicle, condition, &ambient, needed_n)?;
    // The small difference between thrust found and thrust set is kept out of the trim: slopes only come from the maps.
    environment.thrust = [0, 1].map(|engine| Thrust { force_n: needed_n, ..vehicle.thrust(engine, input, &ambient) });
    Ok(Trim { state, environment, engines: [input; 2], alpha_rad, iterations })
}

/// Newton iteration on `alpha, phi, thrust / 1000 N, delta_a, delta_e, delta_r`.
fn solve(
    vehicle: &Vehicle,
    body: &Body,
    condition: &TrimCondition,
    environment: &Environment,
) -> Result<(SVector<f64, 6>, usize), SimulateError> {
    /// Step of the differences, rad or kN.
    const DIFFERENCE: f64 = 1e-5;
    let residual = |unknowns: &SVector<f64, 6>| {
        let (state, environment) = apply(unknowns, condition, environment);
        let loads = vehicle.loads(body, &state, &environment);
        let (a, w) = (loads.acceleration_ned_m_s2, loads.angular_acceleration_rad_s2);
        SVector::<f64, 6>::new(a.x, a.y, a.z, w.x, w.y, w.z)
    };
    let mut unknowns = SVector::<f64, 6>::new(0.05, 0.0, 1.0, 0.0, 0.0, 0.0);
    let mut value = residual(&unknowns);
    for iteration in 0..MAX_STEPS {
        if value.amax() < TOLERANCE {
            return Ok((unknowns, iteration));
        }
        let mut jacobian = SMatrix::<f64, 6, 6>::zeros();
        for column in 0..6 {
            let mut step = SVector::<f64, 6>::zeros();
            step[column] = DIFFERENCE;
            let slope = (residual(&(unknowns + step)) - residual(&(unknowns - step))) / (2.0 * DIFFERENCE);
            jacobian.set_column(column, &slope);
        }
        let Some(step) = jacobian.lu().solve(&value) else { break };
        unknowns -= step * (0.5 / step.amax()).min(1.0);
        value = residual(&unknowns);
    }
    let worst = value.iamax();
    Err(SimulateError::TrimNotFound {
        airspeed_m_s: condition.airspeed_m_s,
        altitude_m: condition.altitude_m,
        worst: EQUATIONS[worst].0,
        residual: value[worst],
        unit: EQUATIONS[worst].1,
        iterations: MAX_STEPS,
    })
}

/// State and environment of the unknowns, level flight without sideslip.
fn apply(unknowns: &SVector<f64, 6>, condition: &TrimCondition, environment: &Environment) -> (State, Environment) {
    let [alpha, phi, thrust, aileron, elevator, rudder] = unknowns.as_ref();
    let (sin_alpha, cos_alpha) = libm::sincos(*alpha);
    // Level: cos(alpha) sin(theta) = sin(alpha) cos(phi) cos(theta).
    let theta = libm::atan2(sin_alpha * libm::cos(*phi), cos_alpha);
    let mut state = State::new(
        Vector3::new(0.0, 0.0, -condition.altitude_m),
        Vector3::zeros(),
        [*phi, theta, condition.heading_rad],
    );
    let air_body = Vector3::new(cos_alpha, 0.0, sin_alpha) * condition.airspeed_m_s;
    state.velocity_ned_m_s = state.body_from_ned().tr_mul(&air_body) + condition.wind_ned_m_s;
    let thrust = Thrust { force_n: thrust * 1000.0, at_airspeed_m_s: condition.airspeed_m_s, ..Thrust::default() };
    let controls = Controls { aileron: *aileron, elevator: *elevator, rudder: *rudder };
    (state, Environment { controls, thrust: [thrust; 2], ..*environment })
}

/// Air at the condition as the engines see it.
fn ambient(atmosphere: &Atmosphere, condition: &TrimCondition, density_kg_m3: f64) -> Result<Ambient, SimulateError> {
    let refuse =
        |error: crate::atmos::AtmosphereError| SimulateError::Model { what: "atmosphere", reason: error.to_string() };
    let pressure = atmosphere.pressure_pa(condition.altitude_m).map_err(refuse)?;
    Ok(Ambient {
        airspeed_m_s: condition.airspeed_m_s,
        pressure_altitude_m: Atmosphere::STANDARD.altitude_m(pressure).map_err(refuse)?,
        air_temperature_k: atmosphere.temperature_k(condition.altitude_m).map_err(refuse)?,
        density_kg_m3,
    })
}

/// Manifold pressure at full throttle, Pa: static pressure less the loss in the induction, which grows with the square of
/// the speed and with density; 1.92 inHg at 2,800 rpm at sea level leaves the 28.0 inHg of thesis Table 6.10.
pub(crate) fn full_throttle_pa(static_pressure_pa: f64, speed_rad_s: f64, density_kg_m3: f64) -> f64 {
    const LOSS_PA: f64 = 1.92 * 3386.389;
    const AT_SPEED_RAD_S: f64 = 2800.0 * std::f64::consts::TAU / 60.0;
    const AT_DENSITY_KG_M3: f64 = 1.225;
    let ratio = speed_rad_s / AT_SPEED_RAD_S;
    static_pressure_pa - LOSS_PA * ratio * ratio * density_kg_m3 / AT_DENSITY_KG_M3
}

/// Manifold pressure at which an engine gives the thrust, by bisection.
fn throttle_for(
    vehicle: &Vehicle,
    condition: &TrimCondition,
    ambient: &Ambient,
    needed_n: f64,
) -> Result<EngineInput, SimulateError> {
    let static_pressure_pa = ambient.density_kg_m3 * crate::atmos::GAS_CONSTANT_AIR_J_KG_K * ambient.air_temperature_k;
    let speed_rad_s = condition.engine_speed_rad_s;
    let input = |manifold_pressure_pa| EngineInput { speed_rad_s, manifold_pressure_pa };
    let full = full_throttle_pa(static_pressure_pa, speed_rad_s, ambient.density_kg_m3);
    let available_n = vehicle.thrust(0, input(full), ambient).force_n;
    if needed_n > available_n {
        return Err(SimulateError::TrimPastThrust {
            airspeed_m_s: condition.airspeed_m_s,
            altitude_m: condition.altitude_m,
            needed_n,
            rpm: speed_rad_s * 60.0 / std::f64::consts::TAU,
            available_n,
            missing_n: needed_n - available_n,
        });
    }
    let (mut low, mut high) = (0.1 * full, full);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if vehicle.thrust(0, input(middle), ambient).force_n < needed_n { low = middle } else { high = middle }
    }
    Ok(input(high))
}
