//! The terms of the filter's equations over the augmented state: what one step and the parameters make of them.

use std::ops::AddAssign;

use nalgebra::{Cholesky, Const, SMatrix, SVector};

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::model::augmented::{
    AugmentedMatrix, AugmentedState, MeasurementMatrix, MeasurementVector, advance, augmented, groups, observe,
};
use crate::reconstruct::model::kinematics::{Trig, ned_from_body};
use crate::reconstruct::model::layout::{ACC, ATT, INPUTS, MEASUREMENTS, STATES, TRIPLES, VEL, WIND};
use crate::reconstruct::model::measurement;
use crate::reconstruct::model::transition::Transition;

/// The process over one step, linearised at a point c.
pub struct Process {
    /// `f(c)`, n.
    pub image: AugmentedState,
    /// Transition `Phi`, n x n.
    pub phi: AugmentedMatrix,
    /// Covariance of the process noise, `N = Gamma Q Gamma' + G W G' dt` with the random walks W and G of [`walk_covariance`], n x n.
    pub noise: AugmentedMatrix,
}

/// The process over `step`, linearised at `point`. Noise enters where the biases of its sensors do: `Gamma` is their columns of
/// `Phi` in the rows of the states that move.
pub fn process(point: &AugmentedState, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Process {
    let (image, transition) = image(point, step, parameters);
    let phi = augmented(&transition.dense());
    let variances = SVector::<f64, INPUTS>::from_fn(|i, _| parameters.noise.process[i / 3][i % 3] * step.noise_scale);
    let mut gamma = phi.fixed_columns::<INPUTS>(3 * ACC).into_owned();
    gamma.fixed_rows_mut::<INPUTS>(3 * ACC).fill(0.0);
    let mut noise = gamma * SMatrix::from_diagonal(&variances) * gamma.transpose();
    noise += walk_covariance(&image, step, parameters);
    Process { image, phi, noise }
}

/// The state `f(point)` after a step, and the transition.
pub fn image(
    point: &AugmentedState,
    step: &StepInputs<f64>,
    parameters: &FilterParameters<f64>,
) -> (AugmentedState, Transition<f64>) {
    advance(point, &step.inputs, step.dt, parameters.gravity, parameters.at_prediction)
}

/// Variance rate W of the random walk of each state; sensor errors have none.
pub fn random_walk(parameters: &FilterParameters<f64>) -> AugmentedState {
    let walks = &parameters.noise.random_walk;
    AugmentedState::from_fn(|k, _| if k < STATES { walks[k / 3][k % 3] } else { 0.0 })
}

/// Covariance `G W G' dt` of the random walks over a step that ends at the state `at`. A walk moves its own state; that of the wind also
/// moves the velocity relative to the air, by [`velocity_by_wind`], so that the velocity over ground stays.
pub fn walk_covariance(
    at: &AugmentedState,
    step: &StepInputs<f64>,
    parameters: &FilterParameters<f64>,
) -> AugmentedMatrix {
    let walks = random_walk(parameters) * step.dt;
    let mut covariance = AugmentedMatrix::from_diagonal(&walks);
    let wind = SMatrix::<f64, 3, 3>::from_diagonal(&walks.fixed_rows::<3>(3 * WIND).into_owned());
    let by_wind = velocity_by_wind(&groups(at)[ATT]);
    let cross = by_wind * wind;
    covariance.fixed_view_mut::<3, 3>(3 * VEL, 3 * WIND).copy_from(&cross);
    covariance.fixed_view_mut::<3, 3>(3 * WIND, 3 * VEL).copy_from(&cross.transpose());
    let own = cross * by_wind.transpose();
    covariance.fixed_view_mut::<3, 3>(3 * VEL, 3 * VEL).add_assign(&own);
    covariance
}

/// Change of the velocity relative to the air, body axes, by a change of the wind, NED: `-C'`, as `V_ground = C V_air + W`.
/// At bank, pitch and heading `attitude`.
pub fn velocity_by_wind(attitude: &[f64; 3]) -> SMatrix<f64, 3, 3> {
    let c = ned_from_body(&Trig::new(attitude));
    SMatrix::from_fn(|i, j| -c[j][i])
}

/// Expected measurements `h(x)`, and H with zeros in the rows of what is absent.
pub fn expected(x: &AugmentedState, step: &StepInputs<f64>) -> (MeasurementVector, MeasurementMatrix) {
    let (expected, mut h) = observe(x);
    for m in 0..MEASUREMENTS {
        h.row_mut(m).scale_mut(step.present[m / 3][m % 3]);
    }
    (expected, h)
}

/// Measured less expected, angles within half a turn, zero for what is absent.
pub fn residual(step: &StepInputs<f64>, expected: &MeasurementVector) -> MeasurementVector {
    difference(&MeasurementVector::from_fn(|m, _| step.measured[m / 3][m % 3]), step, expected)
}

/// `z` less expected, angles within half a turn, zero for what `step` lacks.
pub fn difference(z: &MeasurementVector, step: &StepInputs<f64>, expected: &MeasurementVector) -> MeasurementVector {
    MeasurementVector::from_fn(|m, _| {
        let (triple, i) = (m / 3, m % 3);
        measurement::residual(triple, i, z[m], expected[m]) * step.present[triple][i]
    })
}

/// Diagonal of R, one for what is absent.
pub fn measurement_noise(step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> MeasurementVector {
    let variances = &parameters.noise.measurement;
    MeasurementVector::from_fn(|m, _| if step.present[m / 3][m % 3] > 0.0 { variances[m / 3][m % 3] } else { 1.0 })
}

/// What [`Update::weigh`] adds to the noise: of the innovation, its covariance S, and the limit, zero for none.
pub fn robust_noise(
    innovation: &MeasurementVector,
    s: &SMatrix<f64, MEASUREMENTS, MEASUREMENTS>,
    limit: f64,
) -> MeasurementVector {
    if limit == 0.0 {
        return MeasurementVector::zeros();
    }
    MeasurementVector::from_fn(|m, _| {
        let variance = s[(m, m)];
        variance * (innovation[m].abs() / (limit * variance.sqrt()) - 1.0).max(0.0)
    })
}

impl Update<f64> {
    /// Of the innovation, its covariance S, the Cholesky factor of S, the diagonal of R, and the part of S that [`robust_noise`] adds
    /// to it.
    pub fn new(
        innovation: &MeasurementVector,
        s: &SMatrix<f64, MEASUREMENTS, MEASUREMENTS>,
        factor: &Cholesky<f64, Const<MEASUREMENTS>>,
        noise: &MeasurementVector,
        added: &MeasurementVector,
    ) -> Self {
        let nis = innovation.dot(&factor.solve(innovation));
        let mut update = Self { nis, smallest_pivot: f64::INFINITY, ..Self::failed(&[[0.0; 3]; TRIPLES]) };
        for m in 0..MEASUREMENTS {
            update.innovation[m / 3][m % 3] = innovation[m];
            update.innovation_variance[m / 3][m % 3] = s[(m, m)] - added[m];
            update.noise[m / 3][m % 3] = noise[m] + added[m];
            update.det_ratio *= noise[m] / factor.l_dirty()[(m, m)].powi(2);
        }
        update
    }

    /// Of an innovation covariance without a factor.
    pub fn failed(variances: &[[f64; 3]; TRIPLES]) -> Self {
        Self {
            innovation: [[0.0; 3]; TRIPLES],
            innovation_variance: *variances,
            noise: *variances,
            nis: 0.0,
            det_ratio: 1.0,
            iterations: 1.0,
            smallest_pivot: -1.0,
        }
    }
}
