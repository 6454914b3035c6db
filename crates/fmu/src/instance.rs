//! An instance: states, inputs, and every variable by its value reference.

use doublet_dynamics::linear::{INPUT_NAMES, OUTPUT_NAMES, STATE_NAMES, Simulation, state_unit};

/// States of the motion and inputs.
const STATES: usize = STATE_NAMES.len();
const INPUTS: usize = INPUT_NAMES.len();
/// Value references: each kind of variable begins at its own.
const INPUT_AT: u32 = 1;
const STATE_AT: u32 = 100;
const RATE_AT: u32 = 200;
const OUTPUT_AT: u32 = 300;
const DERIVATIVE_AT: u32 = 1000;
/// Longest step of the integration in co-simulation, s.
const STEP_S: f64 = 0.005;
/// What the token of every unit begins with; the name of the aircraft follows.
pub const TOKEN_PREFIX: &str = "doublet-flight-model-1:";

/// What a variable is.
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
    /// A derivative of the model, fixed during the flight.
    Derivative,
}

/// A variable: value reference, name, unit, kind and value at the start.
pub type Variable = (u32, String, &'static str, VariableKind, f64);

/// Every variable of a simulation but time, whose value reference is 0.
pub fn variables(simulation: &Simulation, names: &[String]) -> Vec<Variable> {
    let mut all = Vec::new();
    for (index, (name, unit)) in INPUT_NAMES.iter().enumerate() {
        all.push((INPUT_AT + index as u32, (*name).to_owned(), *unit, VariableKind::Input, simulation.input[index]));
    }
    for (index, name) in STATE_NAMES.iter().enumerate() {
        all.push((
            STATE_AT + index as u32,
            (*name).to_owned(),
            state_unit(name),
            VariableKind::State,
            simulation.state[index],
        ));
    }
    for (index, name) in STATE_NAMES.iter().enumerate() {
        let kind = VariableKind::Rate(STATE_AT + index as u32);
        all.push((RATE_AT + index as u32, format!("der({name})"), "", kind, 0.0));
    }
    for (index, (name, unit)) in OUTPUT_NAMES.iter().enumerate() {
        all.push((OUTPUT_AT + index as u32, (*name).to_owned(), *unit, VariableKind::Output, 0.0));
    }
    for (index, (name, entry)) in names.iter().zip(simulation.model.derivatives.entries()).enumerate() {
        all.push((DERIVATIVE_AT + index as u32, name.clone(), "", VariableKind::Derivative, entry.value));
    }
    all
}

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
    ///
    /// # Errors
    /// One line: what of the file is not understood.
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
            } else if let Some(index) = index(OUTPUT_AT, OUTPUT_NAMES.len()) {
                moving()?.1[index]
            } else {
                let entries = self.simulation.model.derivatives.entries();
                entries[index(DERIVATIVE_AT, entries.len())?].value
            };
        }
        Some(())
    }

    /// Sets an input, a state or a derivative; `None` of a variable that cannot be set.
    pub fn set(&mut self, reference: u32, value: f64) -> Option<()> {
        let index = |first: u32, count: usize| {
            (reference.checked_sub(first)? < count as u32).then(|| (reference - first) as usize)
        };
        let derivatives = self.simulation.model.derivatives.entries().len();
        if let Some(index) = index(INPUT_AT, INPUTS) {
            self.input[index] = value;
        } else if let Some(index) = index(STATE_AT, STATES) {
            self.state[index] = value;
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
