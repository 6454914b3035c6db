//! One window: its samples step by step, the measurements along its path, the gains of its filter.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::kinematics::{Errors, moved, observed};
use super::{EstimateError, Sensor, SensorError};
use crate::reconstruct::{
    FilterData, INPUTS, Inputs, MEASUREMENTS, Measurement, MeasurementModel, Motion, STATES, State, StepInputs, Trig,
    merged_steps, predict_state, velocity_by_wind,
};

/// Components of the motion: position, velocity, attitude.
const MOTION: usize = 9;
/// Index of the first velocity in it.
const VELOCITY: usize = 3;
/// Components of the path a filter corrects: motion and wind.
const PATH: usize = MOTION + 3;

/// Samples of a window, one row per step: of the inertial samples and of measurements between them.
pub(super) struct Samples {
    steps: Vec<StepInputs<f64>>,
    outputs: Vec<Measurement>,
    /// Measured values, steps by outputs, angles without jumps; not a number where nothing was measured.
    pub(super) measured: DMatrix<f64>,
}

/// Where a path begins, and what holds along it.
#[derive(Clone)]
pub(super) struct Values {
    pub(super) motion: Motion<f64>,
    pub(super) wind: [f64; 3],
    pub(super) errors: Errors,
    pub(super) gravity: f64,
}

/// Noise of filter error.
pub(super) struct Noise<'a> {
    pub(super) process: &'a [f64; INPUTS],
    pub(super) measurement: &'a [f64; MEASUREMENTS],
    /// Random walks of the path, gusts for example, SI per square root of a second.
    pub(super) path: &'a [f64; STATES],
    /// Errors with a random walk, SI per square root of a second.
    pub(super) walks: &'a [(SensorError, f64)],
}

/// What a filter does with the measurements of one step.
pub(super) struct Gain {
    /// Places of the outputs measured.
    present: Vec<usize>,
    /// Path and walking errors by innovation.
    gain: DMatrix<f64>,
    /// Lower triangle L of the innovation covariance, `S = L L'`.
    root: DMatrix<f64>,
}

/// What a path shows.
pub(super) struct Shown {
    /// Outputs, steps by outputs.
    pub(super) outputs: DMatrix<f64>,
    /// Innovations in their deviations, `L^-1 (z - y)`, steps by outputs; empty without gains.
    pub(super) normalised: DMatrix<f64>,
}

impl Samples {
    pub(super) fn new(data: &FilterData, outputs: &[Measurement]) -> Self {
        let steps = merged_steps(data);
        let measured = DMatrix::from_fn(steps.len(), outputs.len(), |row, column| {
            let m = outputs[column] as usize;
            let (value, present) = (steps[row].measured[m / 3][m % 3], steps[row].present[m / 3][m % 3]);
            if present > 0.0 { value } else { f64::NAN }
        });
        let mut samples = Self { steps, outputs: outputs.to_vec(), measured };
        for (column, output) in outputs.iter().enumerate() {
            if matches!(output, Measurement::BankAngle | Measurement::HeadingAngle) {
                without_jumps(samples.measured.column_mut(column).iter_mut());
            }
        }
        samples
    }

    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether any of these is measured.
    pub(super) fn has(&self, any: &[Measurement]) -> bool {
        let mut columns = self.outputs.iter().zip(self.measured.column_iter());
        columns.any(|(output, column)| any.contains(output) && column.iter().any(|value| value.is_finite()))
    }

    /// The path from `values`, corrected by `gains` where there are any.
    pub(super) fn follow(&self, values: &Values, gains: Option<(&[Gain], &Noise<'_>)>) -> Shown {
        let mut now = values.clone();
        let mut outputs = DMatrix::zeros(self.steps.len(), self.outputs.len());
        let rows = gains.map_or(0, |_| self.steps.len());
        let mut normalised = DMatrix::from_element(rows, self.outputs.len(), f64::NAN);
        for (row, step) in self.steps.iter().enumerate() {
            now.motion = moved(&now.motion, (&step.inputs, step.dt), &now.errors, &now.wind, now.gravity);
            let shown = observed(&now.motion, &now.errors, &now.wind);
            for (column, output) in self.outputs.iter().enumerate() {
                outputs[(row, column)] = shown[*output as usize];
            }
            let Some((gain, noise)) = gains.and_then(|(gains, noise)| Some((gains.get(row)?, noise))) else { continue };
            if gain.present.is_empty() {
                continue;
            }
            let innovation = self.innovation(row, &gain.present, &outputs);
            if let Some(white) = gain.root.solve_lower_triangular(&innovation) {
                gain.present.iter().zip(white.iter()).for_each(|(&column, value)| normalised[(row, column)] = *value);
            }
            now.correct(&(&gain.gain * innovation), noise.walks);
        }
        Shown { outputs, normalised }
    }

    fn innovation(&self, row: usize, present: &[usize], outputs: &DMatrix<f64>) -> DVector<f64> {
        let values = present.iter().map(|&column| self.measured[(row, column)] - outputs[(row, column)]);
        DVector::from_iterator(present.len(), values)
    }

    /// Gains of the extended Kalman filter that starts in `values` without deviation.
    ///
    /// # Errors
    /// An innovation covariance that is not positive definite.
    pub(super) fn gains(&self, values: &Values, noise: &Noise<'_>) -> Result<Vec<Gain>, EstimateError> {
        let size = PATH + noise.walks.len();
        let mut now = values.clone();
        let mut covariance = DMatrix::zeros(size, size);
        let mut gains = Vec::with_capacity(self.steps.len());
        let mut outputs = DMatrix::zeros(self.steps.len(), self.outputs.len());
        for (row, step) in self.steps.iter().enumerate() {
            predict(&mut now, &mut covariance, step, noise);
            let is_present = |column: &usize| self.measured[(row, *column)].is_finite();
            let present: Vec<usize> = (0..self.outputs.len()).filter(is_present).collect();
            let (shown, h) = self.linear(&now, &present, noise.walks);
            for (column, output) in self.outputs.iter().enumerate() {
                outputs[(row, column)] = shown[*output as usize];
            }
            let variances =
                DVector::from_iterator(present.len(), present.iter().map(|&column| self.variance(column, noise)));
            let cross = &covariance * h.transpose();
            let factor = (&h * &cross + DMatrix::from_diagonal(&variances)).cholesky();
            let factor = factor.ok_or(EstimateError::NotConverged { method: "the filter", iterations: row })?;
            let gain = factor.solve(&cross.transpose()).transpose();
            let left = DMatrix::identity(size, size) - &gain * &h;
            covariance =
                &left * covariance * left.transpose() + &gain * DMatrix::from_diagonal(&variances) * gain.transpose();
            now.correct(&(&gain * self.innovation(row, &present, &outputs)), noise.walks);
            gains.push(Gain { present, gain, root: factor.l() });
        }
        Ok(gains)
    }

    fn variance(&self, column: usize, noise: &Noise<'_>) -> f64 {
        noise.measurement[self.outputs[column] as usize].powi(2)
    }

    /// What the sensors show, and its derivative by path and walking errors for the outputs present.
    fn linear(
        &self,
        now: &Values,
        present: &[usize],
        walks: &[(SensorError, f64)],
    ) -> ([f64; MEASUREMENTS], DMatrix<f64>) {
        let shown = observed(&now.motion, &now.errors, &now.wind);
        let model = MeasurementModel::new(&now.motion.vel, &Trig::new(&now.motion.att), &now.wind).dense();
        let h = DMatrix::from_fn(present.len(), PATH + walks.len(), |row, column| {
            let output = self.outputs[present[row]];
            let m = output as usize;
            let Some((error, _)) = column.checked_sub(PATH).and_then(|walk| walks.get(walk)) else {
                return (now.errors.shown(m, 1.0) - now.errors.shown(m, 0.0)) * model[(m, state(column))];
            };
            match error {
                SensorError::Bias(Sensor::Measurement(own)) if *own == output => 1.0,
                SensorError::Scale(Sensor::Measurement(own)) if *own == output => now.errors.truth(m, shown[m]),
                _ => 0.0,
            }
        });
        (shown, h)
    }
}

impl Values {
    /// Adds to path and walking errors.
    fn correct(&mut self, change: &DVector<f64>, walks: &[(SensorError, f64)]) {
        let Motion { pos, vel, att } = &mut self.motion;
        let path = pos.iter_mut().chain(vel).chain(att).chain(&mut self.wind);
        path.zip(change.iter()).for_each(|(value, change)| *value += change);
        for ((error, _), change) in walks.iter().zip(change.iter().skip(PATH)) {
            *self.errors.value_mut(*error) += change;
        }
    }
}

/// Index of a component of the path among the states of the flight path reconstruction.
fn state(column: usize) -> usize {
    if column < MOTION { column } else { State::WindNorth as usize + column - MOTION }
}

/// One prediction: `P- = Phi P Phi' + Gamma Q Gamma'`, with the random walks of errors.
fn predict(now: &mut Values, covariance: &mut DMatrix<f64>, step: &StepInputs<f64>, noise: &Noise<'_>) {
    /// Change of an error by which the motion is differentiated.
    const STEP: f64 = 1e-4;
    let before = now.motion;
    let after = |errors: &Errors| moved(&before, (&step.inputs, step.dt), errors, &now.wind, now.gravity);
    let inputs = Inputs { start: now.errors.inertial(&step.inputs.start), end: now.errors.inertial(&step.inputs.end) };
    let mut groups = [before.pos, before.vel, before.att, [0.0; 3], [0.0; 3], now.wind];
    let (transition, _) = predict_state(&mut groups, &inputs, step.dt, now.gravity, false);
    let whole = transition.dense();
    let size = covariance.nrows();
    let mut phi = DMatrix::identity(size, size);
    for column in 0..PATH {
        phi.view_mut((0, column), (MOTION, 1)).copy_from(&whole.view((0, state(column)), (MOTION, 1)));
    }
    for (walk, (error, _)) in noise.walks.iter().enumerate() {
        let side = |sign: f64| {
            let mut errors = now.errors;
            *errors.value_mut(*error) += sign * STEP;
            let Motion { pos, vel, att } = after(&errors);
            DVector::from_vec([pos, vel, att].concat())
        };
        let column = (side(1.0) - side(-1.0)) / (2.0 * STEP);
        phi.view_mut((0, PATH + walk), (MOTION, 1)).copy_from(&column);
    }
    let mut next = &phi * &*covariance * phi.transpose();
    let gamma = whole.view((0, MOTION), (MOTION, INPUTS));
    let variances: [f64; INPUTS] = noise.process.map(|deviation| step.noise_scale * deviation * deviation);
    let scaled = gamma * nalgebra::SMatrix::<f64, INPUTS, INPUTS>::from_diagonal(&variances.into());
    let mut moving = next.view_mut((0, 0), (MOTION, MOTION));
    moving += scaled * gamma.transpose();
    let of_path = (0..PATH).map(|column| noise.path[state(column)]);
    let walks = of_path.chain(noise.walks.iter().map(|(_, deviation)| *deviation));
    for (place, deviation) in walks.enumerate() {
        next[(place, place)] += deviation * deviation * step.dt;
    }
    now.motion = after(&now.errors);
    add_wind_change(&mut next, now, noise, step.dt);
    *covariance = next;
}

/// Adds what the random walk of the wind does to the velocity relative to the air, `-C' dW`, which leaves that over ground.
fn add_wind_change(covariance: &mut DMatrix<f64>, now: &Values, noise: &Noise<'_>, dt: f64) {
    let by_wind = velocity_by_wind(&now.motion.att);
    let wind = Vector3::from_fn(|axis, _| noise.path[state(MOTION + axis)].powi(2) * dt);
    let cross = by_wind * Matrix3::from_diagonal(&wind);
    let mut to_wind = covariance.view_mut((VELOCITY, MOTION), (3, 3));
    to_wind += cross;
    let mut from_wind = covariance.view_mut((MOTION, VELOCITY), (3, 3));
    from_wind += cross.transpose();
    let mut own = covariance.view_mut((VELOCITY, VELOCITY), (3, 3));
    own += cross * by_wind.transpose();
}

/// Takes jumps of whole turns out of the finite values.
fn without_jumps<'a>(values: impl Iterator<Item = &'a mut f64>) {
    let mut last: Option<f64> = None;
    for value in values.filter(|value| value.is_finite()) {
        if let Some(last) = last {
            *value -= TAU * ((*value - last) / TAU).round();
        }
        last = Some(*value);
    }
}
