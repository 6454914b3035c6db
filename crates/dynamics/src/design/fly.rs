//! Flight of the identified model through a designed input.

use doublet_core::simulate::Dryden;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::DesignError;
use super::signal::{CONTROLS, Input};
use crate::linear::flight::{Equations, INPUTS, InputVector, STATES, StateVector};
use crate::linear::{Condition, FlightModel, Trim, trim};

/// Speed beneath which, and rate above which, the flight counts as ended: m/s, rad/s.
const SLOWEST_M_S: f64 = 5.0;
const FASTEST_RAD_S: f64 = 10.0;

/// An aircraft in the trim from which every manoeuvre begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// Model.
    pub model: FlightModel,
    /// Trim.
    pub trim: Trim,
}

/// How a window begins: where the aircraft was trimmed, and how far from steady flight it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// True airspeed of the trim less that of the condition, m/s.
    pub airspeed_m_s: f64,
    /// Altitude less that of the condition, m.
    pub altitude_m: f64,
    /// Angle of the flight path less that of the trim, rad.
    pub path_rad: f64,
    /// Deviations of the states from that trim.
    pub state: [f64; STATES],
    /// Deviations of the deflections held from those of that trim, rad.
    pub controls_rad: [f64; 3],
    /// Sum of the thrusts less that of that trim, N; none where it is not known.
    pub thrust_n: Option<f64>,
}

/// What a flight meets that nobody designed.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Its start, of which the trim is the plant's.
    pub start: Start,
    /// Standard deviation of the gusts, m/s.
    pub gust_m_s: f64,
    /// Seed of the gusts.
    pub seed: u64,
}

/// A flight through an input, at even intervals.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct FlownInput {
    pub time_s: Vec<f64>,
    /// States `u v w p q r phi theta psi north east h`.
    pub states: Vec<[f64; STATES]>,
    /// Airspeed (m/s), angle of attack and of sideslip (rad), gusts included.
    pub air: Vec<[f64; 3]>,
    /// Specific force in body axes, m/s².
    pub specific_force_m_s2: Vec<[f64; 3]>,
    /// Deflections of aileron, elevator and rudder, rad, and sum of the thrusts, N.
    pub inputs: Vec<[f64; INPUTS]>,
    /// Air density, kg/m³.
    pub density_kg_m3: Vec<f64>,
    pub speed_of_sound_m_s: Vec<f64>,
}

impl Plant {
    /// The model in steady flight at a condition.
    ///
    /// # Errors
    /// [`DesignError::Linear`] without a trim.
    pub fn new(model: FlightModel, condition: &Condition) -> Result<Self, DesignError> {
        let trim = trim(&model, condition)?;
        Ok(Self { model, trim })
    }

    /// The same trimmed where a window begins; `steady` where the power is set for its path, which then lasts.
    ///
    /// # Errors
    /// [`DesignError::Linear`] without a trim.
    pub fn at(&self, start: &Start, steady: bool) -> Result<Self, DesignError> {
        let about = &self.trim.condition;
        let mut condition = about.at_altitude(about.altitude_m + start.altitude_m);
        condition.airspeed_m_s += start.airspeed_m_s;
        if steady {
            condition.gamma_rad = condition.gamma_rad.map(|gamma| gamma + start.path_rad);
        }
        Self::new(self.model.clone(), &condition)
    }
}

/// Flies `input`, which adds to the deflections and the thrust of the trim, for `duration_s`, a sample every `step_s`: equations of motion of a rigid body
/// over a flat Earth, classical Runge-Kutta steps from sample to sample that end at every node of the input between two samples, so that
/// none steps over a change of it. Gusts of the Dryden form are held from sample to sample; power stays that of the trim but for the input.
///
/// # Errors
/// [`DesignError::Departed`] where the flight leaves what a flight can be.
pub fn fly(
    plant: &Plant,
    input: &Input,
    (duration_s, step_s): (f64, f64),
    disturbance: Option<&Disturbance>,
) -> Result<FlownInput, DesignError> {
    let equations = Equations::new(&plant.model, &plant.trim.condition)?;
    let trimmed = plant.trim.input();
    let mut state = plant.trim.state();
    let mut gusts = disturbance.map(|own| (Dryden::new(own.gust_m_s), ChaCha8Rng::seed_from_u64(own.seed)));
    if let Some(own) = disturbance {
        state += StateVector::from(own.start.state);
    }
    let mut held = trimmed;
    for (surface, value) in disturbance.iter().flat_map(|own| own.start.controls_rad.iter().enumerate()) {
        held[surface] += value;
    }
    held[3] += disturbance.and_then(|own| own.start.thrust_n).unwrap_or(0.0);
    let total = |deflections: [f64; CONTROLS]| {
        let mut sum = held;
        deflections.iter().enumerate().for_each(|(surface, value)| sum[surface] += value);
        sum
    };
    let samples = (duration_s / step_s).round().max(1.0) as usize;
    let mut flown = FlownInput::default();
    let mut airspeed_m_s = plant.trim.condition.airspeed_m_s;
    for sample in 0..=samples {
        let time_s = step_s * sample as f64;
        let gust = match &mut gusts {
            Some((gusts, random)) => Vector3::from(gusts.step(airspeed_m_s, step_s, random)),
            None => Vector3::zeros(),
        };
        airspeed_m_s = flown.record(&equations, time_s, &state, (&total(input.at(time_s)), &gust));
        let rate = Vector3::new(state[3], state[4], state[5]).norm();
        if airspeed_m_s.is_nan() || airspeed_m_s < SLOWEST_M_S || rate > FASTEST_RAD_S {
            return Err(DesignError::Departed { time_s });
        }
        if sample == samples {
            break;
        }
        let end_s = step_s * (sample + 1) as f64;
        let mut start_s = time_s;
        let first = input.times_s().partition_point(|&node| node <= time_s);
        let nodes = input.times_s().iter().skip(first).copied().take_while(|&node| node < end_s);
        for stop_s in nodes.chain(std::iter::once(end_s)) {
            if stop_s > start_s {
                let inputs = (total(input.at(start_s)), total(input.before(stop_s)));
                state = step(&equations, &state, inputs, stop_s - start_s, &gust);
                start_s = stop_s;
            }
        }
    }
    Ok(flown)
}

/// One Runge-Kutta step while the inputs move in straight lines.
fn step(
    equations: &Equations<'_>,
    x: &StateVector,
    (start, end): (InputVector, InputVector),
    h: f64,
    gust: &Vector3<f64>,
) -> StateVector {
    let half_way = (start + end) * 0.5;
    let rate = |x: &StateVector, input: &InputVector| equations.rates_in_gust(x, input, gust).0;
    let k1 = rate(x, &start);
    let k2 = rate(&(x + k1 * (h / 2.0)), &half_way);
    let k3 = rate(&(x + k2 * (h / 2.0)), &half_way);
    let k4 = rate(&(x + k3 * h), &end);
    x + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0)
}

impl FlownInput {
    /// Adds a sample; its airspeed, m/s.
    fn record(
        &mut self,
        equations: &Equations<'_>,
        time_s: f64,
        state: &StateVector,
        (input, gust): (&InputVector, &Vector3<f64>),
    ) -> f64 {
        let flow = Vector3::new(state[0], state[1], state[2]) - gust;
        let airspeed_m_s = flow.norm();
        let (_, force) = equations.rates_in_gust(state, input, gust);
        let sample = equations.sample(airspeed_m_s, state[11], input);
        self.time_s.push(time_s);
        self.states.push((*state).into());
        self.air.push([airspeed_m_s, flow.z.atan2(flow.x), flow.y.atan2(flow.x.hypot(flow.z))]);
        self.specific_force_m_s2.push(force.into());
        self.inputs.push([input[0], input[1], input[2], sample.thrust_n]);
        self.density_kg_m3.push(sample.density_kg_m3);
        self.speed_of_sound_m_s.push(sample.speed_of_sound_m_s);
        airspeed_m_s
    }
}
