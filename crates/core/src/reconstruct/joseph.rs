//! The filter with a dense covariance in Joseph form: slow, and the last to lose positive definiteness. It takes over a
//! window on which the packed form failed.

use nalgebra::{SMatrix, SVector};

use super::blocks::Vec3;
use super::covariance::{ATT, GROUPS, POS, VEL, WIND};
use super::dense::Dense;
use super::form::Form;
use super::kernel::{AIR, ATTITUDE, Estimate, GROUND, POSITION, Step, Telling, Tuning, difference_of, predict_state};
use super::kinematics::{Observation, Trig};
use super::layout::{INPUTS, MEASUREMENTS, STATES};
use super::march::{RECORD, read_step, tell, tell_smoothed};
use super::schedule::DRIVE;

type Sensitivity = SMatrix<f64, MEASUREMENTS, STATES>;

/// State and dense covariance.
#[derive(Clone)]
pub struct DenseEstimate {
    /// State.
    pub x: [Vec3<f64>; GROUPS],
    /// Covariance.
    pub p: Dense,
}

/// What the backward pass needs of one step.
pub struct DenseKept {
    before: DenseEstimate,
    transition: Dense,
    noise: Dense,
    predicted: DenseEstimate,
}

impl Form for DenseEstimate {
    type Number = f64;
    type Kept = DenseKept;

    fn new(packed: &Estimate<f64>) -> Self {
        Self { x: packed.x, p: packed.p.dense() }
    }

    fn run(&mut self, tuning: &Tuning<f64>, steps: usize, drive: &[f64], record: &mut [f64]) {
        for (drive, record) in drive.chunks_exact(DRIVE).zip(record.chunks_exact_mut(RECORD)).take(steps) {
            let step = read_step::<f64>(drive);
            let (trig, _, _) = self.predict(&step, tuning);
            let telling = self.update(&step, &trig, tuning);
            tell(&self.x, &self.variances(), &step, &telling, record);
        }
    }

    fn smooth(
        &mut self,
        start: &Self,
        tuning: &Tuning<f64>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<DenseKept>,
        record: &mut [f64],
    ) {
        kept.clear();
        let mut filtered = start.clone();
        for drive in drive.chunks_exact(DRIVE).take(steps) {
            let step = read_step::<f64>(drive);
            let before = filtered.clone();
            let (trig, transition, noise) = filtered.predict(&step, tuning);
            kept.push(DenseKept { before, transition, noise, predicted: filtered.clone() });
            filtered.update(&step, &trig, tuning);
        }
        for (kept, record) in kept.iter().zip(record.chunks_exact_mut(RECORD)).rev() {
            self.smooth_step(kept);
            tell_smoothed(&self.x, &self.variances(), record);
        }
    }

    fn covariance(&self, _lane: usize) -> Dense {
        self.p
    }
}

impl DenseEstimate {
    /// Variances group by group.
    fn variances(&self) -> [Vec3<f64>; GROUPS] {
        let mut variances = self.x;
        for k in 0..STATES {
            variances[k / 3][k % 3] = self.p[(k, k)];
        }
        variances
    }

    /// `P <- Phi P Phi' + N` with `N = Gamma Q Gamma'` and the random walks; returns Phi and N.
    fn predict(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> (Trig<f64>, Dense, Dense) {
        let (phi, trig) = predict_state(&mut self.x, step, tuning);
        let transition = phi.dense();
        let mut variances = SVector::<f64, INPUTS>::zeros();
        for i in 0..INPUTS {
            variances[i] = tuning.process[i / 3][i % 3] * step.noise_scale;
        }
        let mut gamma = transition.fixed_columns::<INPUTS>(9).into_owned();
        gamma.fixed_rows_mut::<INPUTS>(9).fill(0.0);
        let mut noise = gamma * SMatrix::from_diagonal(&variances) * gamma.transpose();
        for k in 0..STATES {
            noise[(k, k)] += tuning.random_walk[k / 3][k % 3] * step.dt;
        }
        self.p = transition * self.p * transition.transpose() + noise;
        (trig, transition, noise)
    }

    /// One step backwards, with `W = N (P-)^-1` and the gain `G = Phi^-1 (I - W)`:
    /// `x + G (xs - x-)` and `Phi^-1 ((I - W) (Ps + N) (I - W)' + W (P- - N) W') Phi'^-1`, a sum of covariances only, as
    /// Joseph's form of the update is.
    fn smooth_step(&mut self, kept: &DenseKept) {
        let scale = SVector::<f64, STATES>::from_fn(|k, _| {
            let variance = kept.predicted.p[(k, k)];
            if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
        });
        let scale = Dense::from_diagonal(&scale);
        // Correlations: of order one, whatever the units. Directions lost to rounding take no part.
        let mut eigen = (scale * kept.predicted.p * scale).symmetric_eigen();
        let least = STATES as f64 * f64::EPSILON * eigen.eigenvalues.max();
        eigen.eigenvalues.apply(|value| *value = if *value > least { value.recip() } else { 0.0 });
        let noise_part = kept.noise * scale * eigen.recompose() * scale;
        let kept_part = Dense::identity() - noise_part;
        let mut ahead = SVector::<f64, STATES>::zeros();
        for k in 0..STATES {
            ahead[k] = self.x[k / 3][k % 3] - kept.predicted.x[k / 3][k % 3];
        }
        let without_noise = kept.transition * kept.before.p * kept.transition.transpose();
        let covariance = kept_part * (self.p + kept.noise) * kept_part.transpose()
            + noise_part * without_noise * noise_part.transpose();
        let back = kept.transition.lu();
        let nowhere = (Dense::from_element(f64::NAN), SVector::<f64, STATES>::from_element(f64::NAN));
        let half = back.solve(&covariance).unwrap_or(nowhere.0);
        let covariance = back.solve(&half.transpose()).unwrap_or(nowhere.0);
        let moved = back.solve(&(kept_part * ahead)).unwrap_or(nowhere.1);
        for k in 0..STATES {
            self.x[k / 3][k % 3] = kept.before.x[k / 3][k % 3] + moved[k];
        }
        self.p = (covariance + covariance.transpose()) * 0.5;
    }

    /// `P <- (I - K H) P (I - K H)' + K R K'` (Joseph, in Bucy & Joseph 1968).
    fn update(&mut self, step: &Step<f64>, trig: &Trig<f64>, tuning: &Tuning<f64>) -> Telling<f64> {
        let predicted = self.x;
        let mut point = predicted;
        let mut telling = Telling {
            innovation: [[0.0; 3]; 4],
            variance: tuning.measurement,
            nis: 0.0,
            pivot: f64::INFINITY,
            iterations: 1.0,
        };
        let mut noise = SVector::<f64, MEASUREMENTS>::repeat(1.0);
        for m in (0..MEASUREMENTS).filter(|&m| step.present[m / 3][m % 3] > 0.0) {
            noise[m] = tuning.measurement[m / 3][m % 3];
        }
        loop {
            let model = Observation::new(&point[VEL], &trig.turned(&predicted[ATT], &point[ATT]), &point[WIND]);
            let h = sensitivity(&model, step);
            let residual = residual(&model, &point, step);
            let cross = self.p * h.transpose();
            let s = h * cross + SMatrix::from_diagonal(&noise);
            let Some(factor) = s.cholesky() else {
                telling.pivot = -1.0;
                return telling;
            };
            if telling.iterations == 1.0 {
                telling.nis = residual.dot(&factor.solve(&residual));
                for m in 0..MEASUREMENTS {
                    telling.innovation[m / 3][m % 3] = residual[m];
                    telling.variance[m / 3][m % 3] = s[(m, m)];
                }
            }
            let gain = factor.solve(&cross.transpose()).transpose();
            let mut ahead = SVector::<f64, STATES>::zeros();
            for k in 0..STATES {
                ahead[k] = predicted[k / 3][k % 3] - point[k / 3][k % 3];
            }
            let correction = gain * (residual - h * ahead);
            let mut moved = false;
            for k in 0..STATES {
                let next = predicted[k / 3][k % 3] + correction[k];
                let change = next - point[k / 3][k % 3];
                let iterated = [VEL, ATT, WIND].contains(&(k / 3));
                moved |= iterated && change * change > tuning.tolerance_squared * self.p[(k, k)];
                point[k / 3][k % 3] = next;
            }
            if telling.iterations as usize >= tuning.max_iterations || !moved {
                let kept = Dense::identity() - gain * h;
                let updated =
                    kept * self.p * kept.transpose() + gain * SMatrix::from_diagonal(&noise) * gain.transpose();
                self.p = (updated + updated.transpose()) * 0.5;
                self.x = point;
                return telling;
            }
            telling.iterations += 1.0;
        }
    }
}

/// Measurement matrix, zero in the rows of what is absent.
fn sensitivity(model: &Observation<f64>, step: &Step<f64>) -> Sensitivity {
    let mut h = model.dense();
    for m in 0..MEASUREMENTS {
        let present = step.present[m / 3][m % 3];
        h.row_mut(m).scale_mut(present);
    }
    h
}

/// Measured less expected, zero for what is absent.
fn residual(model: &Observation<f64>, point: &[Vec3<f64>; GROUPS], step: &Step<f64>) -> SVector<f64, MEASUREMENTS> {
    let mut expected = step.z;
    (expected[POSITION], expected[ATTITUDE]) = (point[POS], point[ATT]);
    (expected[GROUND], expected[AIR]) = (model.ground, model.air);
    let mut residual = SVector::zeros();
    for m in 0..MEASUREMENTS {
        let (triple, i) = (m / 3, m % 3);
        residual[m] = difference_of(triple, i, step.z[triple][i], expected[triple][i]) * step.present[triple][i];
    }
    residual
}
