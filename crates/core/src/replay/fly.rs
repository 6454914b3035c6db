//! Integration of the motion.

use nalgebra::Vector3;

use super::sample::Sample;
use super::{Replay, ReplayError, Start};
use crate::model::{Axes, Derivatives, RateNormalisation, Variable, VariableValues};
use crate::motion::{Airflow, State, runge_kutta_from};

/// Airspeed below which the flight counts as ended, m/s.
const SLOWEST_M_S: f64 = 5.0;
/// Rate above which it does, rad/s.
const FASTEST_RATE_RAD_S: f64 = 20.0;
/// Change of the rates of the flow angles, without dimension, at which their equation counts as solved.
const RATE_TOLERANCE: f64 = 1e-13;
/// Passes over that equation; a pass shrinks the error by the virtual mass over the mass, a per cent or so.
const MAX_PASSES: usize = 12;

/// Simulated motion at the times of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Position in local Earth axes, m.
    pub position_ned_m: [Vec<f64>; 3],
    /// Velocity relative to the air in body axes, m/s.
    pub air_velocity_body_m_s: [Vec<f64>; 3],
    /// Bank, pitch and heading angle, rad; heading without jumps.
    pub euler_rad: [Vec<f64>; 3],
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: [Vec<f64>; 3],
    /// True airspeed, m/s.
    pub airspeed_m_s: Vec<f64>,
    /// Angle of attack, rad.
    pub alpha_rad: Vec<f64>,
    /// Sideslip, rad.
    pub beta_rad: Vec<f64>,
    /// Specific force at the centre of gravity in body axes, m/s².
    pub specific_force_m_s2: [Vec<f64>; 3],
    /// Angular acceleration, rad/s².
    pub angular_acceleration_rad_s2: [Vec<f64>; 3],
    /// Coefficients `CX CY CZ Cl Cm Cn` of the model, in the axes and about the reference it was identified in.
    pub coefficients: [Vec<f64>; 6],
}

/// What acts in one state.
struct Loads {
    air: Airflow,
    coefficients: [f64; 6],
    specific_force_m_s2: Vector3<f64>,
    acceleration_ned_m_s2: Vector3<f64>,
    angular_acceleration_rad_s2: Vector3<f64>,
}

impl Replay {
    /// Flies `model` from `start` over the whole window with the recorded controls.
    ///
    /// `m dV/dt = q S (CX, CY, CZ) + T + m g`, `I dw/dt = q S (b Cl, c Cm, b Cn) + d x F + M_T - w x (I w + h)` (thesis Eq.
    /// A.6-A.14) with `d` the moment reference from the centre of gravity and `F` the force of the coefficients; fourth-order
    /// Runge-Kutta from sample to sample, inputs linear between them. Rates of the flow angles in the model, which hang on the
    /// acceleration they cause, are solved for at every evaluation (a changing wind's own rate is left out of them).
    ///
    /// # Errors
    /// Those of [`Replay::check`], and [`ReplayError::Ended`] when the motion diverges.
    pub fn fly(&self, model: &Derivatives, start: &Start) -> Result<Response, ReplayError> {
        self.check(model)?;
        let mut response = Response::with_capacity(self.time_s.len());
        let mut state = self.state(start);
        let down_at_start_m = state.position_ned_m.z;
        let unsteady = model.term_of(Variable::AlphaDot).is_some() || model.term_of(Variable::BetaDot).is_some();
        let flight = Flight { replay: self, model, down_at_start_m, unsteady };
        for (k, sample) in self.samples.iter().enumerate() {
            let loads = flight.loads(&state, sample);
            ended(&state, &loads.air)
                .map_or(Ok(()), |what| Err(ReplayError::Ended { time_s: self.time_s[k], what }))?;
            response.push(self.time_s[k], &state, &loads);
            let Some(next) = self.samples.get(k + 1) else { break };
            let step_s = self.time_s[k + 1] - self.time_s[k];
            let first = state.rate(loads.acceleration_ned_m_s2, loads.angular_acceleration_rad_s2);
            let middle = sample.towards(next, 0.5);
            state = runge_kutta_from(&state, &first, step_s, |fraction, state| {
                let loads = flight.loads(state, if fraction < 0.75 { &middle } else { next });
                state.rate(loads.acceleration_ned_m_s2, loads.angular_acceleration_rad_s2)
            });
        }
        Ok(response)
    }
}

/// Why the motion cannot be followed further, if it cannot.
fn ended(state: &State, air: &Airflow) -> Option<&'static str> {
    let rate = state.rates_rad_s.amax();
    if !(air.airspeed_m_s.is_finite() && rate.is_finite()) {
        Some("the motion diverges")
    } else if air.airspeed_m_s < SLOWEST_M_S {
        Some("the airspeed falls to zero")
    } else if rate > FASTEST_RATE_RAD_S {
        Some("the rates grow without bound")
    } else {
        None
    }
}

/// One flight of one model.
struct Flight<'a> {
    replay: &'a Replay,
    model: &'a Derivatives,
    down_at_start_m: f64,
    unsteady: bool,
}

impl Flight<'_> {
    fn loads(&self, state: &State, sample: &Sample) -> Loads {
        let body_from_ned = state.body_from_ned();
        let velocity = body_from_ned * (state.velocity_ned_m_s - sample.wind_ned_m_s);
        let air = Airflow::new(velocity, sample.density_kg_m3);
        let mut values = self.variables(state, &air, sample);
        let gravity_body = body_from_ned.column(2) * self.replay.gravity_m_s2;
        let mut coefficients = self.model.body_coefficients(&values);
        if self.unsteady {
            for _ in 0..MAX_PASSES {
                let force = self.specific_force(&coefficients, &air, sample);
                let acceleration = force + gravity_body - state.rates_rad_s.cross(&velocity);
                let before = [values[Variable::AlphaDot as usize], values[Variable::BetaDot as usize]];
                self.set_flow_rates(&mut values, &air, &acceleration);
                let change = (values[Variable::AlphaDot as usize] - before[0])
                    .abs()
                    .max((values[Variable::BetaDot as usize] - before[1]).abs());
                coefficients = self.model.body_coefficients(&values);
                if change < RATE_TOLERANCE {
                    break;
                }
            }
        }
        let specific_force_m_s2 = self.specific_force(&coefficients, &air, sample);
        let moment = self.moment(&coefficients, &air, sample);
        let mut acceleration_ned_m_s2 = body_from_ned.tr_mul(&specific_force_m_s2);
        acceleration_ned_m_s2.z += self.replay.gravity_m_s2;
        Loads {
            air,
            coefficients,
            specific_force_m_s2,
            acceleration_ned_m_s2,
            angular_acceleration_rad_s2: sample.inertia.angular_acceleration(
                moment,
                state.rates_rad_s,
                sample.rotor_momentum_n_m_s,
            ),
        }
    }

    /// Force of the coefficients, N.
    fn aerodynamic_force(&self, [cx, cy, cz, ..]: &[f64; 6], air: &Airflow) -> Vector3<f64> {
        Vector3::new(*cx, *cy, *cz) * (air.dynamic_pressure_pa * self.replay.reference.area_m2)
    }

    fn specific_force(&self, coefficients: &[f64; 6], air: &Airflow, sample: &Sample) -> Vector3<f64> {
        (self.aerodynamic_force(coefficients, air) + sample.thrust_force_n) / sample.mass_kg
    }

    /// Moment about the centre of gravity in body axes, N m.
    fn moment(&self, coefficients: &[f64; 6], air: &Airflow, sample: &Sample) -> Vector3<f64> {
        let reference = &self.replay.reference;
        let [.., cl, cm, cn] = *coefficients;
        let scale = air.dynamic_pressure_pa * reference.area_m2;
        let (l, m, n) = (scale * reference.span_m * cl, scale * reference.chord_m * cm, scale * reference.span_m * cn);
        let about_reference = match self.replay.axes {
            Axes::Body => Vector3::new(l, m, n),
            Axes::Stability => {
                let (sin, cos) = libm::sincos(air.alpha_rad);
                Vector3::new(l * cos - n * sin, m, l * sin + n * cos)
            }
        };
        let transfer = sample.reference_arm_m.cross(&self.aerodynamic_force(coefficients, air));
        about_reference + transfer + sample.thrust_moment_n_m
    }

    /// All variables but the rates of the flow angles, which stay zero.
    fn variables(&self, state: &State, air: &Airflow, sample: &Sample) -> VariableValues {
        let reference = &self.replay.reference;
        let airspeed = air.airspeed_m_s;
        let [mut p, q, mut r] = <[f64; 3]>::from(state.rates_rad_s);
        if self.replay.axes == Axes::Stability {
            let (sin, cos) = libm::sincos(air.alpha_rad);
            (p, r) = (p * cos + r * sin, r * cos - p * sin);
        }
        let lateral = reference.lateral_rates.factor(reference.span_m, airspeed);
        let mut values = [0.0; Variable::ALL.len()];
        let mut set = |variable: Variable, value: f64| values[variable as usize] = value;
        set(Variable::Alpha, air.alpha_rad);
        set(Variable::Beta, air.beta_rad);
        set(Variable::RollRate, p * lateral);
        set(Variable::PitchRate, q * reference.pitch_rate.factor(reference.chord_m, airspeed));
        set(Variable::HalfPitchRate, q * RateNormalisation::LengthOver2V.factor(reference.chord_m, airspeed));
        set(Variable::YawRate, r * lateral);
        let [aileron, elevator, rudder] = sample.controls_rad;
        set(Variable::Aileron, aileron);
        set(Variable::Elevator, elevator);
        set(Variable::Rudder, rudder);
        set(Variable::PropellerPressure, sample.pressure_rise_pa / air.dynamic_pressure_pa);
        set(Variable::ThrustCoefficient, sample.thrust_n / (air.dynamic_pressure_pa * reference.area_m2));
        set(Variable::Airspeed, airspeed);
        let climbed_m = self.down_at_start_m - state.position_ned_m.z;
        set(Variable::Altitude, self.replay.altitude_at_start_m + climbed_m);
        set(Variable::Mach, airspeed / sample.speed_of_sound_m_s);
        values
    }

    /// Rates of the flow angles from the acceleration relative to the air in body axes:
    /// `alpha' = (u w' - w u') / (u^2 + w^2)`, `beta' = (v' V - v V') / (V sqrt(u^2 + w^2))`.
    fn set_flow_rates(&self, values: &mut VariableValues, air: &Airflow, acceleration: &Vector3<f64>) {
        let reference = &self.replay.reference;
        let (velocity, airspeed) = (air.velocity_body_m_s, air.airspeed_m_s);
        let in_plane = velocity.x * velocity.x + velocity.z * velocity.z;
        let alpha_rate = (velocity.x * acceleration.z - velocity.z * acceleration.x) / in_plane;
        let airspeed_rate = velocity.dot(acceleration) / airspeed;
        let beta_rate = (acceleration.y * airspeed - velocity.y * airspeed_rate) / (airspeed * in_plane.sqrt());
        values[Variable::AlphaDot as usize] = alpha_rate * reference.alpha_dot.factor(reference.chord_m, airspeed);
        values[Variable::BetaDot as usize] = beta_rate * reference.beta_dot.factor(reference.span_m, airspeed);
    }
}

impl Response {
    fn with_capacity(samples: usize) -> Self {
        let column = || Vec::with_capacity(samples);
        let three = || std::array::from_fn(|_| column());
        Self {
            time_s: column(),
            position_ned_m: three(),
            air_velocity_body_m_s: three(),
            euler_rad: three(),
            rates_rad_s: three(),
            airspeed_m_s: column(),
            alpha_rad: column(),
            beta_rad: column(),
            specific_force_m_s2: three(),
            angular_acceleration_rad_s2: three(),
            coefficients: std::array::from_fn(|_| column()),
        }
    }

    fn push(&mut self, time_s: f64, state: &State, loads: &Loads) {
        fn append<const N: usize>(columns: &mut [Vec<f64>; N], values: [f64; N]) {
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        let mut euler = state.euler_rad();
        if let Some(before) = self.euler_rad[2].last() {
            euler[2] += ((before - euler[2]) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        }
        self.time_s.push(time_s);
        append(&mut self.position_ned_m, state.position_ned_m.into());
        append(&mut self.air_velocity_body_m_s, loads.air.velocity_body_m_s.into());
        append(&mut self.euler_rad, euler);
        append(&mut self.rates_rad_s, state.rates_rad_s.into());
        self.airspeed_m_s.push(loads.air.airspeed_m_s);
        self.alpha_rad.push(loads.air.alpha_rad);
        self.beta_rad.push(loads.air.beta_rad);
        append(&mut self.specific_force_m_s2, loads.specific_force_m_s2.into());
        append(&mut self.angular_acceleration_rad_s2, loads.angular_acceleration_rad_s2.into());
        append(&mut self.coefficients, loads.coefficients);
    }
}
