//! The filter with a dense covariance in Joseph form: slow, and the last to lose positive definiteness. It takes over a
//! window on which the packed form failed.

use nalgebra::{SMatrix, SVector};

use super::blocks::Vec3;
use super::covariance::{ATT, GROUPS, POS, VEL, WIND};
use super::dense::Dense;
use super::kernel::{AIR, ATTITUDE, Estimate, GROUND, POSITION, Step, Telling, Tuning, difference_of, predict_state};
use super::kinematics::{Observation, Trig};
use super::layout::{INPUTS, MEASUREMENTS, STATES};

type Sensitivity = SMatrix<f64, MEASUREMENTS, STATES>;

/// State and dense covariance.
pub struct DenseEstimate {
    /// State.
    pub x: [Vec3<f64>; GROUPS],
    /// Covariance.
    pub p: Dense,
}

impl DenseEstimate {
    /// The same estimate, dense.
    pub fn new(packed: &Estimate<f64>) -> Self {
        Self { x: packed.x, p: packed.p.dense() }
    }

    /// Variances group by group.
    pub fn variances(&self) -> [Vec3<f64>; GROUPS] {
        let mut variances = self.x;
        for k in 0..STATES {
            variances[k / 3][k % 3] = self.p[(k, k)];
        }
        variances
    }

    /// One step: `P <- Phi P Phi' + Gamma Q Gamma'`, then
    /// `P <- (I - K H) P (I - K H)' + K R K'` (Joseph, in Bucy & Joseph 1968).
    pub fn step(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> Telling<f64> {
        let (phi, trig) = predict_state(&mut self.x, step, tuning);
        let transition = phi.dense();
        let mut noise = SVector::<f64, INPUTS>::zeros();
        for i in 0..INPUTS {
            noise[i] = tuning.process[i / 3][i % 3] * step.noise_scale;
        }
        let mut gamma = transition.fixed_columns::<INPUTS>(9).into_owned();
        gamma.fixed_rows_mut::<INPUTS>(9).fill(0.0);
        self.p =
            transition * self.p * transition.transpose() + gamma * SMatrix::from_diagonal(&noise) * gamma.transpose();
        for k in 0..STATES {
            self.p[(k, k)] += tuning.random_walk[k / 3][k % 3] * step.dt;
        }
        self.update(step, &trig, tuning)
    }

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
