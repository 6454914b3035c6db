//! Motion and measurements of one window with the errors of its sensors.

use super::{Sensor, SensorError};
use crate::reconstruct::{Constants, INPUTS, Inputs, MEASUREMENTS, MeasurementModel, Motion, Trig, integrate_motion};

#[derive(Clone, Copy)]
pub(super) struct Errors {
    bias: [f64; INPUTS + MEASUREMENTS],
    scale: [f64; INPUTS + MEASUREMENTS],
    turn: [f64; 3],
}

impl Errors {
    pub(super) fn none() -> Self {
        Self { bias: [0.0; INPUTS + MEASUREMENTS], scale: [0.0; INPUTS + MEASUREMENTS], turn: [0.0; 3] }
    }

    pub(super) fn value_mut(&mut self, error: SensorError) -> &mut f64 {
        let place = |sensor| match sensor {
            Sensor::Input(input) => input as usize,
            Sensor::Measurement(measurement) => INPUTS + measurement as usize,
        };
        match error {
            SensorError::Bias(sensor) => &mut self.bias[place(sensor)],
            SensorError::Scale(sensor) => &mut self.scale[place(sensor)],
            SensorError::Misalignment(axis) => &mut self.turn[axis % 3],
        }
    }

    /// Specific force and rate in body axes of what the inertial unit shows: `s + e x s` with `s = (shown - bias) / (1 + scale)`.
    pub(super) fn inertial(&self, shown: &[[f64; 3]; 2]) -> [[f64; 3]; 2] {
        [0, 1].map(|group| self.correct(group, &shown[group]))
    }

    fn correct(&self, group: usize, shown: &[f64; 3]) -> [f64; 3] {
        let [ex, ey, ez] = self.turn;
        let at = |axis: usize| {
            let k = 3 * group + axis;
            (shown[axis] - self.bias[k]) / (1.0 + self.scale[k])
        };
        let [x, y, z] = [at(0), at(1), at(2)];
        [x + ey * z - ez * y, y + ez * x - ex * z, z + ex * y - ey * x]
    }

    /// What sensor `m` shows of the value `truth`.
    pub(super) fn shown(&self, m: usize, truth: f64) -> f64 {
        (1.0 + self.scale[INPUTS + m]) * truth + self.bias[INPUTS + m]
    }

    /// The true value of what measurement `m` shows.
    pub(super) fn truth(&self, m: usize, shown: f64) -> f64 {
        (shown - self.bias[INPUTS + m]) / (1.0 + self.scale[INPUTS + m])
    }
}

/// Motion at the end of a step of length `dt`, s, by the classical Runge-Kutta scheme of the flight path reconstruction.
pub(super) fn moved(
    motion: &Motion<f64>,
    (inputs, dt): (&Inputs<f64>, f64),
    errors: &Errors,
    wind: &[f64; 3],
    gravity: f64,
) -> Motion<f64> {
    let inputs = Inputs { start: errors.inertial(&inputs.start), end: errors.inertial(&inputs.end) };
    let constants = Constants { bias_acc: [0.0; 3], bias_gyr: [0.0; 3], wind: *wind, gravity };
    integrate_motion(motion, &Trig::new(&motion.att), &constants, &inputs, dt)
}

/// What the sensors show of a motion, in the order of the measurements.
pub(super) fn observed(motion: &Motion<f64>, errors: &Errors, wind: &[f64; 3]) -> [f64; MEASUREMENTS] {
    let model = MeasurementModel::new(&motion.vel, &Trig::new(&motion.att), wind);
    let truth = [motion.pos, model.ground, motion.att, model.air].concat();
    std::array::from_fn(|m| errors.shown(m, truth[m]))
}
