//! An instance: states, inputs, and every variable by its value reference.

use doublet_dynamics::linear::Simulation;

use crate::variables::{
    DERIVATIVE_AT, INPUT_AT, INPUTS, OUTPUT_AT, OUTPUTS, RATE_AT, STATE_AT, STATES, THRUST_AT, THRUST_PARAMETERS,
};

/// Longest step of the integration in co-simulation, s.
const STEP_S: f64 = 0.005;
/// What the token of every unit begins with; the name of the aircraft follows.
pub const TOKEN_PREFIX: &str = "doublet-flight-model-1:";

/// A running unit.
#[derive(Clone, Debug)]
pub struct Instance {
    start: Simulation,
    simulation: Simulation,
    time_s: f64,
    state: [f64; STATES],
    input: [f64; INPUTS],
}

impl Instance {
    /// The unit whose `resources/model.json` reads `text`.
    pub fn new(text: &str) -> Result<Self, String> {
        let simulation = Simulation::from_json(text)?;
        let (state, input) = (simulation.state, simulation.input);
        Ok(Self { start: simulation.clone(), simulation, time_s: 0.0, state, input })
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        *self = Self {
            simulation: self.start.clone(),
            time_s: 0.0,
            state: self.start.state,
            input: self.start.input,
            start: self.start.clone(),
        };
    }

    /// Time, s.
    pub fn set_time(&mut self, time_s: f64) {
        self.time_s = time_s;
    }

    /// Continuous states.
    pub fn state(&self) -> &[f64; STATES] {
        &self.state
    }

    /// Continuous states, to set.
    pub fn state_mut(&mut self) -> &mut [f64; STATES] {
        &mut self.state
    }

    /// Rates of the states; `None` where the condition is none.
    pub fn rates(&self) -> Option<[f64; STATES]> {
        Some(self.simulation.rates(&self.state, &self.input).ok()?.0)
    }

    /// Values of variables, the motion evaluated at most once; `None` where a value reference is of no variable, or the condition is
    /// none.
    pub fn get(&self, references: &[u32], values: &mut [f64]) -> Option<()> {
        let mut motion = None;
        for (&reference, value) in references.iter().zip(values) {
            let index = |first: u32, count: usize| {
                (reference.checked_sub(first)? < count as u32).then(|| (reference - first) as usize)
            };
            let mut moving = || {
                if motion.is_none() {
                    motion = self.simulation.rates(&self.state, &self.input).ok();
                }
                motion
            };
            *value = if reference == 0 {
                self.time_s
            } else if let Some(index) = index(INPUT_AT, INPUTS) {
                self.input[index]
            } else if let Some(index) = index(STATE_AT, STATES) {
                self.state[index]
            } else if let Some(index) = index(RATE_AT, STATES) {
                moving()?.0[index]
            } else if let Some(index) = index(OUTPUT_AT, OUTPUTS) {
                moving()?.1[index]
            } else if let Some(index) = index(THRUST_AT, THRUST_PARAMETERS) {
                let condition = &self.simulation.condition;
                [condition.thrust_slope_n_s_m, condition.airspeed_m_s][index]
            } else {
                let entries = self.simulation.model.derivatives.entries();
                entries[index(DERIVATIVE_AT, entries.len())?].value
            };
        }
        Some(())
    }

    /// Sets an input, a state or a parameter; `None` of a variable that cannot be set.
    pub fn set(&mut self, reference: u32, value: f64) -> Option<()> {
        let index = |first: u32, count: usize| {
            (reference.checked_sub(first)? < count as u32).then(|| (reference - first) as usize)
        };
        let derivatives = self.simulation.model.derivatives.entries().len();
        if let Some(index) = index(INPUT_AT, INPUTS) {
            self.input[index] = value;
        } else if let Some(index) = index(STATE_AT, STATES) {
            self.state[index] = value;
        } else if let Some(index) = index(THRUST_AT, THRUST_PARAMETERS) {
            let condition = &mut self.simulation.condition;
            *[&mut condition.thrust_slope_n_s_m, &mut condition.airspeed_m_s][index] = value;
        } else {
            self.simulation.model.derivatives.set(index(DERIVATIVE_AT, derivatives)?, value);
        }
        Some(())
    }

    /// Flies on with constant inputs; `None` where the motion cannot be followed.
    pub fn step(&mut self, time_s: f64, duration_s: f64) -> Option<()> {
        let state = self.simulation.advance(&self.state, &self.input, duration_s, STEP_S).ok()?;
        if state.iter().any(|value| !value.is_finite()) {
            return None;
        }
        self.state = state;
        self.time_s = time_s + duration_s;
        Some(())
    }
}
