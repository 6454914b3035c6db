//! Integration of the motion.

use nalgebra::{Matrix3, Vector3};

use super::sample::Sample;
use super::{Replay, ReplayError, Start};
use crate::model::{Axes, Derivatives, Variable, VariableValues};
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

/// Motion at one instant, as far as forces and moments hang on it.
pub(super) struct Instant {
    /// Velocity relative to the air in body axes, m/s.
    pub velocity_body_m_s: Vector3<f64>,
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: Vector3<f64>,
    /// Rotation from local Earth to body axes.
    pub body_from_ned: Matrix3<f64>,
    /// Altitude, m.
    pub altitude_m: f64,
}

/// What acts at one instant.
pub(super) struct Loads {
    pub air: Airflow,
    pub coefficients: [f64; 6],
    pub specific_force_m_s2: Vector3<f64>,
    /// About the centre of gravity in body axes, N m.
    pub moment_n_m: Vector3<f64>,
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
        let flight = Flight::new(self, model, state.position_ned_m.z);
        for (k, sample) in self.samples.iter().enumerate() {
            let (loads, acceleration) = flight.free(&state, sample);
            self.go_on(k, &loads.air, &state.rates_rad_s)?;
            let (position, euler, rates) = (&state.position_ned_m, state.euler_rad(), &state.rates_rad_s);
            response.push(self.time_s[k], position, euler, rates, &loads, acceleration.angular_rad_s2);
            let Some(next) = self.samples.get(k + 1) else { break };
            let step_s = self.time_s[k + 1] - self.time_s[k];
            let first = state.rate(acceleration.ned_m_s2, acceleration.angular_rad_s2);
            let middle = sample.towards(next, 0.5);
            state = runge_kutta_from(&state, &first, step_s, |fraction, state| {
                let (_, acceleration) = flight.free(state, if fraction < 0.75 { &middle } else { next });
                state.rate(acceleration.ned_m_s2, acceleration.angular_rad_s2)
            });
        }
        Ok(response)
    }

    /// Refuses a motion at sample `k` that cannot be followed further.
    pub(super) fn go_on(&self, k: usize, air: &Airflow, rates_rad_s: &Vector3<f64>) -> Result<(), ReplayError> {
        ended(air, rates_rad_s).map_or(Ok(()), |what| Err(ReplayError::Ended { time_s: self.time_s[k], what }))
    }
}

/// Why the motion cannot be followed further, if it cannot.
fn ended(air: &Airflow, rates_rad_s: &Vector3<f64>) -> Option<&'static str> {
    let rate = rates_rad_s.amax();
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

/// Accelerations of a flight whose every state is free.
struct Acceleration {
    ned_m_s2: Vector3<f64>,
    angular_rad_s2: Vector3<f64>,
}

/// One flight of one model.
pub(super) struct Flight<'a> {
    replay: &'a Replay,
    model: &'a Derivatives,
    down_at_start_m: f64,
    unsteady: bool,
}

impl<'a> Flight<'a> {
    pub fn new(replay: &'a Replay, model: &'a Derivatives, down_at_start_m: f64) -> Self {
        let unsteady = model.term_of(Variable::AlphaDot).is_some() || model.term_of(Variable::BetaDot).is_some();
        Self { replay, model, down_at_start_m, unsteady }
    }

    /// Altitude of a position, m.
    pub fn altitude_m(&self, down_m: f64) -> f64 {
        let climbed_m = self.down_at_start_m - down_m;
        self.replay.altitude_at_start_m + climbed_m
    }

    /// Loads and accelerations with six degrees of freedom.
    fn free(&self, state: &State, sample: &Sample) -> (Loads, Acceleration) {
        let body_from_ned = state.body_from_ned();
        let instant = Instant {
            velocity_body_m_s: body_from_ned * (state.velocity_ned_m_s - sample.wind_ned_m_s),
            rates_rad_s: state.rates_rad_s,
            body_from_ned,
            altitude_m: self.altitude_m(state.position_ned_m.z),
        };
        let loads = self.loads(&instant, sample, [None; 3]);
        let mut ned_m_s2 = body_from_ned.tr_mul(&loads.specific_force_m_s2);
        ned_m_s2.z += self.replay.gravity_m_s2;
        let rotors = sample.rotor_momentum_n_m_s;
        let angular_rad_s2 = sample.inertia.angular_acceleration(loads.moment_n_m, state.rates_rad_s, rotors);
        (loads, Acceleration { ned_m_s2, angular_rad_s2 })
    }

    /// Forces and moments of the model; `recorded_m_s2` has the specific force along the axes the model is not asked about.
    pub fn loads(&self, instant: &Instant, sample: &Sample, recorded_m_s2: [Option<f64>; 3]) -> Loads {
        let velocity = instant.velocity_body_m_s;
        let air = Airflow::new(velocity, sample.density_kg_m3);
        let mut values = self.variables(instant, &air, sample);
        let mut coefficients = self.coefficients(&values, sample);
        if self.unsteady {
            let gravity_body = instant.body_from_ned.column(2) * self.replay.gravity_m_s2;
            for _ in 0..MAX_PASSES {
                let aerodynamic = self.aerodynamic_force(&coefficients, &air, sample, recorded_m_s2);
                let force = (aerodynamic + sample.thrust_force_n) / sample.mass_kg;
                let acceleration = force + gravity_body - instant.rates_rad_s.cross(&velocity);
                let before = [values[Variable::AlphaDot as usize], values[Variable::BetaDot as usize]];
                self.set_flow_rates(&mut values, &air, &acceleration);
                let change = (values[Variable::AlphaDot as usize] - before[0])
                    .abs()
                    .max((values[Variable::BetaDot as usize] - before[1]).abs());
                coefficients = self.coefficients(&values, sample);
                if change < RATE_TOLERANCE {
                    break;
                }
            }
        }
        let aerodynamic_n = self.aerodynamic_force(&coefficients, &air, sample, recorded_m_s2);
        Loads {
            air,
            coefficients,
            specific_force_m_s2: (aerodynamic_n + sample.thrust_force_n) / sample.mass_kg,
            moment_n_m: self.moment(&coefficients, &aerodynamic_n, &air, sample),
        }
    }

    /// Coefficients of the model and what disturbs them.
    fn coefficients(&self, values: &VariableValues, sample: &Sample) -> [f64; 6] {
        let modelled = self.model.body_coefficients(values);
        std::array::from_fn(|i| modelled[i] + sample.disturbance[i])
    }

    /// Force of the coefficients, or what the recorded specific force leaves for it, N.
    fn aerodynamic_force(
        &self,
        [cx, cy, cz, ..]: &[f64; 6],
        air: &Airflow,
        sample: &Sample,
        recorded_m_s2: [Option<f64>; 3],
    ) -> Vector3<f64> {
        let mut force = Vector3::new(*cx, *cy, *cz) * (air.dynamic_pressure_pa * self.replay.reference.area_m2);
        for (axis, recorded) in recorded_m_s2.into_iter().enumerate() {
            if let Some(specific) = recorded {
                force[axis] = specific * sample.mass_kg - sample.thrust_force_n[axis];
            }
        }
        force
    }

    /// Moment about the centre of gravity in body axes, N m.
    fn moment(
        &self,
        coefficients: &[f64; 6],
        aerodynamic_n: &Vector3<f64>,
        air: &Airflow,
        sample: &Sample,
    ) -> Vector3<f64> {
        let reference = &self.replay.reference;
        let [.., cl, cm, cn] = *coefficients;
        let scale = air.dynamic_pressure_pa * reference.area_m2;
        let lateral = scale * reference.lateral_moment_length_m;
        let (l, m, n) = (lateral * cl, scale * reference.chord_m * cm, lateral * cn);
        let about_reference = match self.replay.axes {
            Axes::Body => Vector3::new(l, m, n),
            Axes::Stability => {
                let (sin, cos) = libm::sincos(air.alpha_rad);
                Vector3::new(l * cos - n * sin, m, l * sin + n * cos)
            }
        };
        let transfer = sample.reference_arm_m.cross(aerodynamic_n);
        about_reference + transfer + sample.thrust_moment_n_m
    }

    /// All variables but the rates of the flow angles, which stay zero.
    fn variables(&self, instant: &Instant, air: &Airflow, sample: &Sample) -> VariableValues {
        let reference = &self.replay.reference;
        let airspeed = air.airspeed_m_s;
        let [mut p, q, mut r] = <[f64; 3]>::from(instant.rates_rad_s);
        if self.replay.axes == Axes::Stability {
            let (sin, cos) = libm::sincos(air.alpha_rad);
            (p, r) = (p * cos + r * sin, r * cos - p * sin);
        }
        let lateral = reference.lateral_rate_length_m / airspeed;
        let mut values = [0.0; Variable::ALL.len()];
        let mut set = |variable: Variable, value: f64| values[variable as usize] = value;
        set(Variable::Alpha, air.alpha_rad);
        set(Variable::Beta, air.beta_rad);
        set(Variable::RollRate, p * lateral);
        set(Variable::PitchRate, q * (reference.pitch_rate_length_m / airspeed));
        set(Variable::HalfPitchRate, q * (reference.chord_m / 2.0 / airspeed));
        set(Variable::YawRate, r * lateral);
        let [aileron, elevator, rudder] = sample.controls_rad;
        set(Variable::Aileron, aileron);
        set(Variable::Elevator, elevator);
        set(Variable::Rudder, rudder);
        set(Variable::PropellerPressure, sample.pressure_rise_pa / air.dynamic_pressure_pa);
        set(Variable::ThrustCoefficient, sample.thrust_n / (air.dynamic_pressure_pa * reference.area_m2));
        set(Variable::Airspeed, airspeed);
        set(Variable::Altitude, instant.altitude_m);
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
        values[Variable::AlphaDot as usize] = alpha_rate * (reference.pitch_rate_length_m / airspeed);
        values[Variable::BetaDot as usize] = beta_rate * (reference.lateral_rate_length_m / airspeed);
    }
}

impl Response {
    pub(super) fn with_capacity(samples: usize) -> Self {
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

    /// Appends one instant; the heading goes on without a jump.
    pub(super) fn push(
        &mut self,
        time_s: f64,
        position_ned_m: &Vector3<f64>,
        [phi, theta, mut psi]: [f64; 3],
        rates_rad_s: &Vector3<f64>,
        loads: &Loads,
        angular_acceleration_rad_s2: Vector3<f64>,
    ) {
        fn append<const N: usize>(columns: &mut [Vec<f64>; N], values: [f64; N]) {
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        if let Some(before) = self.euler_rad[2].last() {
            psi += ((before - psi) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        }
        self.time_s.push(time_s);
        append(&mut self.position_ned_m, (*position_ned_m).into());
        append(&mut self.air_velocity_body_m_s, loads.air.velocity_body_m_s.into());
        append(&mut self.euler_rad, [phi, theta, psi]);
        append(&mut self.rates_rad_s, (*rates_rad_s).into());
        self.airspeed_m_s.push(loads.air.airspeed_m_s);
        self.alpha_rad.push(loads.air.alpha_rad);
        self.beta_rad.push(loads.air.beta_rad);
        append(&mut self.specific_force_m_s2, loads.specific_force_m_s2.into());
        append(&mut self.angular_acceleration_rad_s2, angular_acceleration_rad_s2.into());
        append(&mut self.coefficients, loads.coefficients);
    }
}
