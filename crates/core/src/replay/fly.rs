//! Integration of the motion.

use nalgebra::Vector3;

use super::forces::{Forces, Instant, Loads};
use super::sample::Sample;
use super::{Replay, ReplayError, Start};
use crate::model::Derivatives;
use crate::motion::{Airflow, State, runge_kutta_from};

/// Airspeed below which the flight counts as ended, m/s.
const SLOWEST_M_S: f64 = 5.0;
/// Rate above which it does, rad/s.
const FASTEST_RATE_RAD_S: f64 = 20.0;
/// Simulated motion at the times of the window.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Response {
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
    pub angular_acceleration_rad_s2: [Vec<f64>; 3],
    /// Coefficients `CX CY CZ Cl Cm Cn` of the model, in the axes and about the reference it was identified in.
    pub coefficients: [Vec<f64>; 6],
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

pub(super) struct Flight<'a> {
    replay: &'a Replay,
    /// Forces and moments of the model.
    pub forces: Forces<'a>,
    down_at_start_m: f64,
}

impl<'a> Flight<'a> {
    pub fn new(replay: &'a Replay, model: &'a Derivatives, down_at_start_m: f64) -> Self {
        let forces = Forces::new(model, replay.reference, replay.axes, replay.gravity_m_s2);
        Self { replay, forces, down_at_start_m }
    }

    /// Altitude of a position, m.
    pub fn altitude_m(&self, down_m: f64) -> f64 {
        let climbed_m = self.down_at_start_m - down_m;
        self.replay.altitude_at_start_m + climbed_m
    }

    /// Acceleration in local Earth axes, m/s², and angular acceleration, rad/s².
    pub(super) fn accelerations(&self, state: &State, sample: &Sample) -> (Vector3<f64>, Vector3<f64>) {
        let (_, acceleration) = self.free(state, sample);
        (acceleration.ned_m_s2, acceleration.angular_rad_s2)
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
        let loads = self.forces.loads(&instant, sample, [None; 3]);
        let mut ned_m_s2 = body_from_ned.tr_mul(&loads.specific_force_m_s2);
        ned_m_s2.z += self.replay.gravity_m_s2;
        let rotors = sample.rotor_momentum_n_m_s;
        let angular_rad_s2 = sample.inertia.angular_acceleration(loads.moment_n_m, state.rates_rad_s, rotors);
        (loads, Acceleration { ned_m_s2, angular_rad_s2 })
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
