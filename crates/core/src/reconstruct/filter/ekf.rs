//! The extended Kalman filter as the textbook has it (Jazwinski 1970, section 8.3): the definition of correct for the packed form,
//! the form that has sensor errors among its states, and the last to lose positive definiteness.
//!
//! x is n, P is n x n, z is m = 12, H is m x n; f and h, with their Jacobians Phi and H, are those of `model`.

use std::rc::Rc;

use nalgebra::SMatrix;

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::filter::terms::{Process, expected, measurement_noise, process, residual, robust_noise};
use crate::reconstruct::model::augmented::{AugmentedMatrix, AugmentedState, MeasurementVector};
use crate::reconstruct::model::layout::{ATT, STATES, VEL, WIND};

/// State and covariance, and where to linearise.
#[derive(Clone)]
pub struct Ekf {
    pub x: AugmentedState,
    /// Covariance P.
    pub p: AugmentedMatrix,
    /// Path to linearise about, one state per event, the start first; without it the estimate itself.
    pub about: Option<Rc<[AugmentedState]>>,
    /// Events passed.
    pub event: usize,
}

impl Ekf {
    /// Prediction over one step.
    pub fn predict(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Process {
        let c = self.linearisation_point();
        let process = process(&c, step, parameters);
        let Process { image, phi, noise } = &process;
        self.x = image + phi * (self.x - c); //             x- = f(c) + Phi (x - c)
        self.p = phi * self.p * phi.transpose() + noise; // P- = Phi P Phi' + N
        self.event += 1;
        process
    }

    /// Update with what was measured at the end of the step; iterated, the linearisation point c moves to the updated state until
    /// it stays there.
    pub fn update(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Update<f64> {
        let predicted = self.x;
        let noise = measurement_noise(step, parameters);
        let mut r = SMatrix::from_diagonal(&noise);
        let mut added: Option<MeasurementVector> = None;
        let mut c = self.linearisation_point();
        let mut first: Option<Update<f64>> = None;
        loop {
            let (z_expected, h) = expected(&c, step); //                            h(c), H
            let innovation = residual(step, &z_expected) - h * (predicted - c); //  nu = z - h(c) - H (x- - c)
            let cross = self.p * h.transpose(); //                                  P- H'
            let mut s = h * cross + r; //                                           S = H P- H' + R
            let added = added.get_or_insert_with(|| {
                let added = robust_noise(&innovation, &s, parameters.robust_limit);
                s += SMatrix::from_diagonal(&added);
                r += SMatrix::from_diagonal(&added);
                added
            });
            let Some(factor) = s.cholesky() else { return Update::failed(&parameters.noise.measurement) };
            let k = factor.solve(&cross.transpose()).transpose(); //                K = P- H' S^-1
            let next = predicted + k * innovation; //                               x+ = x- + K nu
            let update = first.get_or_insert_with(|| Update::new(&innovation, &s, &factor, &noise, added));
            let is_last = update.iterations as usize >= parameters.max_iterations;
            if is_last || self.about.is_some() || !self.has_moved(&c, &next, parameters.tolerance_squared) {
                let a = AugmentedMatrix::identity() - k * h; //                     P+ = A P- A' + K R K', A = I - K H
                let joseph = a * self.p * a.transpose() + k * r * k.transpose();
                self.p = (joseph + joseph.transpose()) * 0.5;
                self.x = next;
                return *update;
            }
            update.iterations += 1.0;
            c = next;
        }
    }

    /// The state f and h are linearised at.
    fn linearisation_point(&self) -> AugmentedState {
        self.about.as_ref().map_or(self.x, |path| path[self.event])
    }

    /// Whether velocity, attitude or wind, on which H depends, moved by more than the tolerance in predicted deviations.
    fn has_moved(&self, from: &AugmentedState, to: &AugmentedState, tolerance_squared: f64) -> bool {
        (0..STATES).filter(|k| [VEL, ATT, WIND].contains(&(k / 3))).any(|k| {
            let change = to[k] - from[k];
            change * change > tolerance_squared * self.p[(k, k)]
        })
    }
}
