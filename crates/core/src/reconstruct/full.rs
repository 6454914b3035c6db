//! The model over the whole state vector, air-data states included: plain matrices for the forms that are not the fast one.

use nalgebra::{SMatrix, SVector};

use super::ReconstructError;
use super::blocks::Vec3;
use super::covariance::{ATT, GROUPS, POS, VEL, WIND};
use super::dense::Dense;
use super::form::initial_estimate;
use super::kernel::{AIR, ATTITUDE, GROUND, POSITION, Step, Telling, Tuning, difference_of};
use super::kinematics::{Observation, Trig};
use super::layout::{AIR_STATES, AirState, MEASUREMENTS, Measurement, STATES};
use super::march::{DEVIATIONS, FULL_RECORD, RECORD, tell};
use super::settings::ValidSettings;
use super::window::Window;

/// Number of states with the air-data states, which come last.
pub const FULL: usize = STATES + AIR_STATES;
/// State vector.
pub type X = SVector<f64, FULL>;
/// Square matrix over it.
pub type Full = SMatrix<f64, FULL, FULL>;
/// Measurement matrix H.
pub type Sensitivity = SMatrix<f64, MEASUREMENTS, FULL>;
/// Measurement vector.
pub type Z = SVector<f64, MEASUREMENTS>;

/// Place of an air-data state.
pub const fn place(state: AirState) -> usize {
    STATES + state as usize
}

/// State and covariance before the first step.
pub fn start(windows: &[Result<Window<'_>, ReconstructError>], settings: &ValidSettings) -> (X, Full) {
    let packed = initial_estimate::<f64>(windows, settings);
    let mut x = X::zeros();
    let mut p = Full::zeros();
    for k in 0..STATES {
        x[k] = packed.x[k / 3][k % 3];
        p[(k, k)] = settings.initial_deviation[k].powi(2);
    }
    for k in 0..AIR_STATES {
        p[(STATES + k, STATES + k)] = settings.air_data_deviation[k].powi(2);
    }
    (x, p)
}

/// The eighteen states group by group.
pub fn groups(x: &X) -> [Vec3<f64>; GROUPS] {
    let mut groups = [[0.0; 3]; GROUPS];
    for k in 0..STATES {
        groups[k / 3][k % 3] = x[k];
    }
    groups
}

/// `small`, one on the diagonal of the air-data states.
pub fn widened(small: &Dense) -> Full {
    let mut full = Full::identity();
    full.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(small);
    full
}

/// Navigation model h (thesis Eq. 3.8) with the errors of the air data, and its Jacobian H.
pub fn observe(x: &X) -> (Z, Sensitivity) {
    let groups = groups(x);
    let model = Observation::new(&groups[VEL], &Trig::new(&groups[ATT]), &groups[WIND]);
    let mut h = Sensitivity::zeros();
    h.fixed_columns_mut::<STATES>(0).copy_from(&model.dense());
    let mut z = Z::zeros();
    for i in 0..3 {
        z[3 * POSITION + i] = groups[POS][i];
        z[3 * GROUND + i] = model.ground[i];
        z[3 * ATTITUDE + i] = groups[ATT][i];
        z[3 * AIR + i] = model.air[i];
    }
    let [speed, alpha, beta] =
        [Measurement::Airspeed, Measurement::AngleOfAttack, Measurement::Sideslip].map(|m| m as usize);
    for (row, factor, offset) in [
        (speed, Some(AirState::AirspeedScale), None),
        (alpha, Some(AirState::Upwash), Some(AirState::AlphaOffset)),
        (beta, None, Some(AirState::BetaOffset)),
    ] {
        let true_value = z[row];
        if let Some(factor) = factor {
            h.row_mut(row).scale_mut(1.0 + x[place(factor)]);
            h[(row, place(factor))] = true_value;
            z[row] *= 1.0 + x[place(factor)];
        }
        if let Some(offset) = offset {
            h[(row, place(offset))] = 1.0;
            z[row] += x[place(offset)];
        }
    }
    (z, h)
}

/// Measured less expected, angles within half a turn, zero for what is absent.
pub fn residual(step: &Step<f64>, expected: &Z) -> Z {
    Z::from_fn(|m, _| {
        let (triple, i) = (m / 3, m % 3);
        difference_of(triple, i, step.z[triple][i], expected[m]) * step.present[triple][i]
    })
}

/// Presence of each measurement, 0 or 1.
pub fn presence(step: &Step<f64>) -> Z {
    Z::from_fn(|m, _| step.present[m / 3][m % 3])
}

/// Variances of the measurements, one for what is absent.
pub fn noise(step: &Step<f64>, tuning: &Tuning<f64>) -> Z {
    Z::from_fn(|m, _| if step.present[m / 3][m % 3] > 0.0 { tuning.measurement[m / 3][m % 3] } else { 1.0 })
}

/// Variance rate of the random walk of each state; the air-data states have none.
pub fn random_walk(tuning: &Tuning<f64>) -> X {
    X::from_fn(|k, _| if k < STATES { tuning.random_walk[k / 3][k % 3] } else { 0.0 })
}

/// What an update tells: innovation, its covariance `S` and Cholesky factor of `S`.
pub fn telling(
    innovation: &Z,
    s: &SMatrix<f64, MEASUREMENTS, MEASUREMENTS>,
    factor: &nalgebra::Cholesky<f64, nalgebra::Const<MEASUREMENTS>>,
    noise: &Z,
) -> Telling<f64> {
    let mut telling = Telling {
        innovation: [[0.0; 3]; 4],
        variance: [[0.0; 3]; 4],
        nis: innovation.dot(&factor.solve(innovation)),
        pivot: f64::INFINITY,
        iterations: 1.0,
        noise_share: 1.0,
    };
    for m in 0..MEASUREMENTS {
        telling.innovation[m / 3][m % 3] = innovation[m];
        telling.variance[m / 3][m % 3] = s[(m, m)];
        telling.noise_share *= noise[m] / factor.l_dirty()[(m, m)].powi(2);
    }
    telling
}

/// What an update tells whose innovation covariance has no factor.
pub fn telling_nothing(tuning: &Tuning<f64>) -> Telling<f64> {
    Telling {
        innovation: [[0.0; 3]; 4],
        variance: tuning.measurement,
        nis: 0.0,
        pivot: -1.0,
        iterations: 1.0,
        noise_share: 1.0,
    }
}

/// Writes down what one step leaves behind, air-data states included.
pub fn tell_full(x: &X, p: &Full, step: &Step<f64>, telling: &Telling<f64>, record: &mut [f64]) {
    tell(&groups(x), &groups(&p.diagonal()), step, telling, record);
    tell_air_data(x, p, record);
}

/// Writes down the smoothed estimate at the start of a step.
pub fn tell_full_smoothed(x: &X, p: &Full, record: &mut [f64]) {
    for k in 0..STATES {
        (record[k], record[DEVIATIONS + k]) = (x[k], p[(k, k)].sqrt());
    }
    tell_air_data(x, p, record);
}

fn tell_air_data(x: &X, p: &Full, record: &mut [f64]) {
    let air_data = &mut record[RECORD..FULL_RECORD];
    for k in 0..AIR_STATES {
        (air_data[k], air_data[AIR_STATES + k]) = (x[STATES + k], p[(STATES + k, STATES + k)].sqrt());
    }
}

#[cfg(test)]
mod tests {
    use num_dual::DualNum;

    use super::*;

    /// Rounding of an analytic against a dual-number derivative, relative to the largest entry of its row.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn air_data_rows_of_the_measurement_matrix_match_dual_numbers() {
        let mut x = X::zeros();
        (x[3], x[4], x[5]) = (78.0, -3.0, 6.0);
        x.fixed_rows_mut::<AIR_STATES>(STATES).copy_from_slice(&[0.02, -0.01, 0.15, 0.03]);
        let (z, h) = observe(&x);
        let (value, exact) = num_dual::jacobian(
            |x: SVector<_, FULL>| {
                let (u, v, w) = (x[3], x[4], x[5]);
                SVector::from([
                    (u * u + v * v + w * w).sqrt() * (x[21] + 1.0),
                    w.atan2(u) * (x[20] + 1.0) + x[18],
                    v.atan2((u * u + w * w).sqrt()) + x[19],
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
