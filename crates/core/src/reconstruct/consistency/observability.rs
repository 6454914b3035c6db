//! Observability: rank of the Lie-derivative matrix at a point (thesis Eq. 3.9-3.10), and states that a window left weak.

use nalgebra::{DMatrix, SMatrix, SymmetricEigen};

use crate::decompose;
use crate::reconstruct::data::Reconstruction;
use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::kinematics::{KinematicsJacobian, Rates, Trig, rates};
use crate::reconstruct::model::layout::{ACC, ATT, GROUPS, GYR, INPUTS, MEASUREMENTS, POS, STATES, State, VEL, WIND};
use crate::reconstruct::model::measurement::MeasurementModel;
use crate::reconstruct::numeric::vec3::Vec3;

/// Singular values below this part of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Share of a state in a direction that no measurement sees, above which the state is named.
const NAMED_SHARE: f64 = 0.1;
/// Relative step of the derivative along the flow.
const FLOW_STEP: f64 = 1e-4;

/// Local observability at one point of the path.
#[derive(Clone, Debug, PartialEq)]
pub struct Observability {
    /// Rank of the Jacobian of h alone.
    pub rank_of_measurements: usize,
    /// Rank with the first Lie derivative: 18 means locally observable at the first iteration.
    pub rank: usize,
    /// Singular values of the scaled matrix, largest first.
    pub singular_values: Vec<f64>,
    /// States that take part in what is not observable.
    pub unobservable: Vec<State>,
}

/// Observability at state `x` with inertial measurement `input`, from the measurements that are `measured`; `scale` is a
/// typical size of each state (its initial deviation) and makes the units comparable; `gravity` in m/s^2.
///
/// The rows are `dh/dx` and `d(L_f h)/dx` with `L_f h = (dh/dx) f`. As `d(L_f h)/dx = d/dt(dh/dx) + (dh/dx)(df/dx)`
/// along the flow x' = f, only the Jacobians of the filter itself are needed; the rate of `dh/dx` is its central difference.
pub fn observability(
    x: &[f64; STATES],
    input: &[f64; INPUTS],
    measured: &[bool; MEASUREMENTS],
    scale: &[f64; STATES],
    gravity: f64,
) -> Observability {
    let groups = grouped(x);
    let flow = derivative(&groups, input, gravity);
    let h = measurement_jacobian(&groups);
    let f = kinematics_jacobian(&groups, input, gravity);
    let (ahead, behind) = (moved(&groups, &flow, FLOW_STEP), moved(&groups, &flow, -FLOW_STEP));
    let change = (measurement_jacobian(&ahead) - measurement_jacobian(&behind)) / (2.0 * FLOW_STEP);
    let lie = change + h * f;

    let rows: Vec<usize> = (0..MEASUREMENTS).filter(|&m| measured[m]).collect();
    let stacked = DMatrix::from_fn(2 * rows.len(), STATES, |i, j| {
        let (order, row) = (i / rows.len(), rows[i % rows.len()]);
        scale[j] * if order == 0 { h[(row, j)] } else { lie[(row, j)] }
    });
    let normalised = rows_normalised(stacked);
    let first = normalised.rows(0, rows.len()).into_owned();
    let squares: StateMatrix = SMatrix::from_fn(|i, j| normalised.column(i).dot(&normalised.column(j)));
    let singular_values = singular_values(normalised);
    let rank = rank(&singular_values);
    let eigen = SymmetricEigen::new(squares);
    let largest = eigen.eigenvalues.max();
    let mut unobservable = Vec::new();
    for state in State::ALL {
        let unseen = (0..STATES).filter(|&k| eigen.eigenvalues[k] <= RANK_TOLERANCE.max(1e-12) * largest);
        let share: f64 = unseen.map(|k| eigen.eigenvectors[(state as usize, k)].powi(2)).sum();
        if rank < STATES && share > NAMED_SHARE {
            unobservable.push(state);
        }
    }
    let rank_of_measurements = self::rank(&self::singular_values(first));
    Observability { rank_of_measurements, rank, singular_values, unobservable }
}

/// Singular values, largest first; none where nothing is measured.
fn singular_values(matrix: DMatrix<f64>) -> Vec<f64> {
    decompose::singular(matrix, false, false).map_or(Vec::new(), |found| found.singular_values.as_slice().to_vec())
}

fn rank(singular_values: &[f64]) -> usize {
    let largest = singular_values.iter().copied().fold(0.0, f64::max);
    singular_values.iter().filter(|value| **value > RANK_TOLERANCE * largest).count()
}

fn rows_normalised(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    for mut row in matrix.row_iter_mut() {
        let norm = row.norm();
        if norm > 0.0 {
            row /= norm;
        }
    }
    matrix
}

fn grouped(x: &[f64; STATES]) -> [Vec3<f64>; GROUPS] {
    let mut groups = [[0.0; 3]; GROUPS];
    for k in 0..STATES {
        groups[k / 3][k % 3] = x[k];
    }
    groups
}

fn bias_free(x: &[Vec3<f64>; GROUPS], input: &[f64; INPUTS]) -> [Vec3<f64>; 2] {
    let mut free = [x[ACC], x[GYR]];
    for i in 0..INPUTS {
        free[i / 3][i % 3] = input[i] - free[i / 3][i % 3];
    }
    free
}

fn derivative(x: &[Vec3<f64>; GROUPS], input: &[f64; INPUTS], gravity: f64) -> Rates<f64> {
    let [force, rate] = bias_free(x, input);
    rates(&x[VEL], &Trig::new(&x[ATT]), &force, &rate, &x[WIND], gravity)
}

fn moved(x: &[Vec3<f64>; GROUPS], flow: &Rates<f64>, dt: f64) -> [Vec3<f64>; GROUPS] {
    let mut moved = *x;
    for i in 0..3 {
        moved[POS][i] += flow.pos[i] * dt;
        moved[VEL][i] += flow.vel[i] * dt;
        moved[ATT][i] += flow.att[i] * dt;
    }
    moved
}

fn measurement_jacobian(x: &[Vec3<f64>; GROUPS]) -> SMatrix<f64, MEASUREMENTS, STATES> {
    MeasurementModel::new(&x[VEL], &Trig::new(&x[ATT]), &x[WIND]).dense()
}

fn kinematics_jacobian(x: &[Vec3<f64>; GROUPS], input: &[f64; INPUTS], gravity: f64) -> StateMatrix {
    let [_, rate] = bias_free(x, input);
    KinematicsJacobian::new(&x[VEL], &Trig::new(&x[ATT]), &rate, gravity).dense()
}

/// A state about which the window holds little information.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakState {
    /// State.
    pub state: State,
    /// Final deviation as part of the initial one: 1 means nothing was learned.
    pub remaining: f64,
    /// State whose error goes most with this one's at the end.
    pub partner: State,
    /// Their correlation.
    pub correlation: f64,
}

/// States whose final deviation is more than `limit` of the initial one (0.5 is a usual limit), weakest first. States
/// that started without deviation are known, not weak.
pub fn weak_states(run: &Reconstruction, limit: f64) -> Vec<WeakState> {
    let p = &run.final_covariance;
    let mut weak = Vec::new();
    for state in State::ALL {
        let k = state as usize;
        let initial = run.deviations[k].get(0).unwrap_or(0.0);
        let remaining = p[(k, k)].sqrt() / initial;
        if initial > 0.0 && remaining > limit {
            let correlation = |other: &State| {
                let j = *other as usize;
                p[(k, j)] / (p[(k, k)] * p[(j, j)]).sqrt()
            };
            let others =
                State::ALL.into_iter().filter(|other| *other != state && p[(*other as usize, *other as usize)] > 0.0);
            let partner = others.max_by(|a, b| correlation(a).abs().total_cmp(&correlation(b).abs())).unwrap_or(state);
            weak.push(WeakState { state, remaining, partner, correlation: correlation(&partner) });
        }
    }
    weak.sort_by(|a, b| b.remaining.total_cmp(&a.remaining));
    weak
}
