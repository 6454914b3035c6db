//! The model over the augmented state, sensor errors included, in plain vectors and matrices; n = [`AUGMENTED_STATES`], m = 12.

use nalgebra::{SMatrix, SVector};

use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::kinematics::Trig;
use crate::reconstruct::model::layout::{
    ACC, AIR, ATT, ATTITUDE, AUGMENTED_STATES, AirState, GROUND, GROUPS, GYR, INPUTS, MEASUREMENTS, POS, POSITION,
    STATES, VEL, WIND,
};
use crate::reconstruct::model::measurement::MeasurementModel;
use crate::reconstruct::model::sensor_errors::{Effect, effect};
use crate::reconstruct::model::transition::{Constants, Inputs, Motion, Transition, integrate, predict_state};
use crate::reconstruct::numeric::vec3::Vec3;

/// State vector x, n.
pub(crate) type AugmentedState = SVector<f64, AUGMENTED_STATES>;
/// Square matrix over it, n x n.
pub(crate) type AugmentedMatrix = SMatrix<f64, AUGMENTED_STATES, AUGMENTED_STATES>;
/// Measurement matrix H, m x n.
pub(crate) type MeasurementMatrix = SMatrix<f64, MEASUREMENTS, AUGMENTED_STATES>;
/// Measurement vector z, m.
pub(crate) type MeasurementVector = SVector<f64, MEASUREMENTS>;

/// The eighteen states group by group.
pub fn groups(x: &AugmentedState) -> [Vec3<f64>; GROUPS] {
    let mut groups = [[0.0; 3]; GROUPS];
    for k in 0..STATES {
        groups[k / 3][k % 3] = x[k];
    }
    groups
}

/// `small`, one on the diagonal of the sensor errors.
pub fn augmented(small: &StateMatrix) -> AugmentedMatrix {
    let mut augmented = AugmentedMatrix::identity();
    augmented.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(small);
    augmented
}

/// The state f(x) after a step of length `dt`, s, and the transition, linearised as [`predict_state`] does.
pub fn advance(
    x: &AugmentedState,
    inputs: &Inputs<f64>,
    dt: f64,
    gravity: f64,
    at_prediction: bool,
) -> (AugmentedState, Transition<f64>) {
    let mut moved = groups(x);
    let (phi, _) = predict_state(&mut moved, inputs, dt, gravity, at_prediction);
    let ahead = AugmentedState::from_fn(|k, _| if k < STATES { moved[k / 3][k % 3] } else { x[k] });
    (ahead, phi)
}

/// The state f(x, w) after a step of length `dt`, s, with `noise` w in the inertial measurements.
pub(crate) fn advance_with_noise(
    x: &AugmentedState,
    noise: &[f64; INPUTS],
    inputs: &Inputs<f64>,
    dt: f64,
    gravity: f64,
) -> AugmentedState {
    let before = groups(x);
    let motion = Motion { pos: before[POS], vel: before[VEL], att: before[ATT] };
    let mut constants = Constants { bias_acc: before[ACC], bias_gyr: before[GYR], wind: before[WIND], gravity };
    for i in 0..3 {
        constants.bias_acc[i] += noise[i];
        constants.bias_gyr[i] += noise[3 + i];
    }
    let moved = integrate(&motion, &Trig::new(&motion.att), &constants, inputs, dt);
    let mut after = *x;
    for i in 0..3 {
        (after[3 * POS + i], after[3 * VEL + i], after[3 * ATT + i]) = (moved.pos[i], moved.vel[i], moved.att[i]);
    }
    after
}

/// Navigation model h (thesis Eq. 3.8) with the errors of the sensors, and its Jacobian H.
pub(crate) fn observe(x: &AugmentedState) -> (MeasurementVector, MeasurementMatrix) {
    let groups = groups(x);
    let model = MeasurementModel::new(&groups[VEL], &Trig::new(&groups[ATT]), &groups[WIND]);
    let mut h = MeasurementMatrix::zeros();
    h.fixed_columns_mut::<STATES>(0).copy_from(&model.dense());
    let mut z = MeasurementVector::zeros();
    for i in 0..3 {
        z[3 * POSITION + i] = groups[POS][i];
        z[3 * GROUND + i] = model.ground[i];
        z[3 * ATTITUDE + i] = groups[ATT][i];
        z[3 * AIR + i] = model.air[i];
    }
    for kind in [Effect::Scale, Effect::Offset] {
        for state in AirState::ALL.into_iter().filter(|state| effect(*state).1 == kind) {
            let (row, column) = (effect(state).0 as usize, STATES + state as usize);
            if kind == Effect::Scale {
                let scale = 1.0 + x[column];
                h.row_mut(row).scale_mut(scale);
                h[(row, column)] = z[row];
                z[row] *= scale;
            } else {
                h[(row, column)] = 1.0;
                z[row] += x[column];
            }
        }
    }
    (z, h)
}

#[cfg(test)]
mod tests {
    use num_dual::DualNum;

    use super::*;
    use crate::reconstruct::model::layout::AIR_STATES;

    /// Rounding of an analytic against a dual-number derivative, relative to the largest entry of its row.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn air_data_rows_of_the_measurement_matrix_match_dual_numbers() {
        let mut x = AugmentedState::zeros();
        (x[3], x[4], x[5]) = (78.0, -3.0, 6.0);
        x.fixed_rows_mut::<AIR_STATES>(STATES).copy_from_slice(&[0.02, -0.01, 0.15, 0.03, 0.08]);
        let (z, h) = observe(&x);
        let (value, exact) = num_dual::jacobian(
            |x: SVector<_, AUGMENTED_STATES>| {
                let (u, v, w) = (x[3], x[4], x[5]);
                SVector::from([
                    (u * u + v * v + w * w).sqrt() * (x[21] + 1.0),
                    w.atan2(u) * (x[20] + 1.0) + x[18],
                    v.atan2((u * u + w * w).sqrt()) * (x[22] + 1.0) + x[19],
                ])
            },
            &x,
        );
        for row in 0..3 {
            assert!((z[9 + row] - value[row]).abs() < ROUNDING * value.amax());
            assert!((h.row(9 + row) - exact.row(row)).amax() < ROUNDING * exact.row(row).amax(), "{row}");
        }
    }
}
