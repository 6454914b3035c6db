//! Mounting of the inertial unit and scale factors of its gyros, from angular rates and attitude.
//!
//! The kinematic relation between body rates `w = (p, q, r)` and Euler angles is `a' = E(phi, theta) w`. With recorded rates the true ones are
//! `w = M w_shown + b`. Over a lag `T`, for each angle `i` with a delay `d_i` behind the rates (Klein and Morelli, Aircraft System
//! Identification, chapter 10: data compatibility),
//! `a_i(t + T) - a_i(t) = int E_i (M w_shown + b) dt - d_i [E_i w_shown]_t^(t + T)`.
//! Unknowns are the nine elements of `M`, three biases `b` (rad/s) and three delays (s). The antisymmetric part of `M` is the mounting,
//! its diagonal the inverse of the scale factors.

mod segment;

use nalgebra::{SMatrix, SVector};

use self::segment::Segment;
use super::motion::Motion;
use crate::quantity::Role;
use crate::series::Recording;
use crate::statistics::student_widening;

/// Delays at which the search starts, largest delay, s; steps of the search, and the change below which it has converged, s.
const TRIED_DELAYS_S: [f64; 6] = [0.0, -0.1, 0.1, 0.2, 0.35, 0.5];
const LARGEST_DELAY_S: f64 = 1.0;
const DELAY_STEPS: usize = 8;
const CONVERGED_S: f64 = 0.002;
/// Delay beyond which the attitude is filtered rather than late, s: a filter reduces fast motion and looks like a scale factor.
const FILTERED_S: f64 = 0.2;
/// Largest mounting angle, rad, and scale-factor error: beyond, a channel is wrong in another way.
const LARGEST_MOUNTING_RAD: f64 = 0.35;
const LARGEST_SCALE: f64 = 0.25;
/// Rows per lag: few for the delays, many for the errors, since the noise of the attitude is averaged over its samples.
const FEW: f64 = 4.0;
const MANY: f64 = 30.0;
/// Least number of blocks of rows that share their errors.
const LEAST_BLOCKS: usize = 8;
/// Unknowns but the delays, and all of them.
const TERMS: usize = 12;
const UNKNOWNS: usize = TERMS + 3;

const RATES: [Role; 3] = [Role::RollRate, Role::PitchRate, Role::YawRate];
const ANGLES: [Role; 3] = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];

/// Errors of the rates against the attitude, with standard errors (jackknife over blocks of 10 s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateErrors {
    /// Small angles `e` about the body axes by which the inertial unit is rotated against the attitude, rad: `true = sensed + e x sensed`.
    pub mounting_rad: [f64; 3],
    /// Their standard errors, rad.
    pub mounting_errors_rad: [f64; 3],
    /// Scale-factor errors of p, q and r: `sensed = (1 + scale) true`.
    pub scale: [f64; 3],
    /// Their standard errors.
    pub scale_errors: [f64; 3],
    /// Delay of bank, pitch and heading behind the rates, s; at most 0.2 s.
    pub delay_s: [f64; 3],
}

/// Compares rates with attitude in the flight of `motion`. `None` without all six channels, without enough motion, where nothing
/// converges, where the attitude is later than 0.2 s, and beyond 20 deg or 25 %.
pub(super) fn estimate_rate_errors(recording: &Recording, motion: &Motion) -> Option<RateErrors> {
    let segments = Segment::of_motion(recording, motion)?;
    let mut best: Option<([f64; 3], Fitted)> = None;
    for tried_s in TRIED_DELAYS_S {
        let Some(found) = Fitted::at(&segments, [tried_s; 3], FEW) else { continue };
        if best.as_ref().is_none_or(|(_, best)| found.misfit < best.misfit) {
            best = Some(([tried_s; 3], found));
        }
    }
    let (mut delay_s, mut found) = best?;
    let step = |found: &Fitted| -> [f64; 3] { std::array::from_fn(|angle| found.values[TERMS + angle]) };
    for _ in 0..DELAY_STEPS {
        if step(&found).iter().all(|step_s| step_s.abs() < CONVERGED_S) {
            break;
        }
        let next = |angle: usize| (delay_s[angle] + step(&found)[angle]).clamp(-LARGEST_DELAY_S, LARGEST_DELAY_S);
        delay_s = std::array::from_fn(next);
        found = Fitted::at(&segments, delay_s, FEW)?;
    }
    found = Fitted::at(&segments, delay_s, MANY)?;
    let is_converged = step(&found).iter().all(|step_s| step_s.abs() < 5.0 * CONVERGED_S);
    if !is_converged || delay_s.iter().any(|delay_s| delay_s.abs() > FILTERED_S) {
        return None;
    }
    let element = |row: usize, column: usize| 3 * row + column;
    // Row and column whose difference is each angle.
    let pairs = [(2, 1), (0, 2), (1, 0)].map(|(row, column)| [element(row, column), element(column, row)]);
    let scale = |axis: usize| 1.0 / found.values[element(axis, axis)];
    let errors = RateErrors {
        mounting_rad: pairs.map(|[one, other]| 0.5 * (found.values[one] - found.values[other])),
        mounting_errors_rad: pairs.map(|[one, other]| 0.5 * found.errors[one].hypot(found.errors[other])),
        scale: std::array::from_fn(|axis| scale(axis) - 1.0),
        scale_errors: std::array::from_fn(|axis| found.errors[element(axis, axis)] * scale(axis).powi(2)),
        delay_s,
    };
    let is_plausible = errors.mounting_rad.iter().all(|angle| angle.abs() < LARGEST_MOUNTING_RAD)
        && errors.scale.iter().all(|scale| scale.abs() < LARGEST_SCALE)
        && errors.mounting_errors_rad.iter().chain(&errors.scale_errors).all(|error| error.is_finite());
    is_plausible.then_some(errors)
}

/// Whether a channel of this name enters the comparison: a rate, an angle of the attitude, or the clock.
pub(super) fn is_part(channel: &str) -> bool {
    channel == "time" || RATES.iter().chain(&ANGLES).any(|role| role.name() == channel)
}

/// One row of the regression: the change of an angle over a lag.
struct Row {
    angle: usize,
    block: usize,
    change: f64,
    terms: SVector<f64, UNKNOWNS>,
    /// Variance of the noise of integrated rates, rad², over the square of the lag.
    noise: [f64; 3],
}

/// Least squares with attitudes taken earlier by given delays, s.
struct Fitted {
    values: SVector<f64, UNKNOWNS>,
    errors: SVector<f64, UNKNOWNS>,
    /// Sum of the logarithms of the residual variances of the angles.
    misfit: f64,
}

/// Normal equations of a block, angle by angle.
type Normal = [(SMatrix<f64, UNKNOWNS, UNKNOWNS>, SVector<f64, UNKNOWNS>); 3];

impl Fitted {
    fn at(segments: &[Segment], delay_s: [f64; 3], overlap: f64) -> Option<Self> {
        let mut rows: Vec<Row> = Vec::new();
        let mut first_block = 0;
        for segment in segments {
            segment.add_rows(delay_s, (first_block, overlap), &mut rows);
            first_block = rows.iter().map(|row| row.block + 1).max().unwrap_or(0);
        }
        let mut blocks: Vec<Normal> = vec![Default::default(); first_block];
        for row in &rows {
            let (square, product) = &mut blocks[row.block][row.angle];
            *square += row.terms * row.terms.transpose();
            *product += row.terms * row.change;
            // Noise of the rates would reduce the elements of M.
            for (one, other, rate) in (0..27).map(|k| (k / 9, k / 3 % 3, k % 3)) {
                square[(3 * one + rate, 3 * other + rate)] -=
                    row.noise[rate] * row.terms[9 + one] * row.terms[9 + other];
            }
        }
        blocks.retain(|block| block.iter().any(|(square, _)| square.norm() > 0.0));
        if blocks.len() < LEAST_BLOCKS || rows.len() < 10 * UNKNOWNS {
            return None;
        }
        let mut weights = [1.0; 3];
        let mut variances = [1.0; 3];
        for _ in 0..2 {
            let values = solve(&blocks, None, weights)?;
            for angle in 0..3 {
                let own = rows.iter().filter(|row| row.angle == angle);
                let (sum, count) = own.fold((0.0, 0_usize), |(sum, count), row| {
                    (sum + (row.change - row.terms.dot(&values)).powi(2), count + 1)
                });
                variances[angle] = (sum / count.max(1) as f64).max(1e-12);
            }
            weights = variances.map(|variance| 1.0 / variance);
        }
        let values = solve(&blocks, None, weights)?;
        let mut squares = SVector::<f64, UNKNOWNS>::zeros();
        for left_out in 0..blocks.len() {
            squares += (solve(&blocks, Some(left_out), weights)? - values).map(|apart| apart * apart);
        }
        let share = (blocks.len() - 1) as f64 / blocks.len() as f64;
        let widening = student_widening(blocks.len())?;
        let errors = squares.map(|square: f64| widening * (share * square).sqrt());
        Some(Self { values, errors, misfit: variances.iter().map(|variance| variance.ln()).sum() })
    }
}

/// The estimate of all blocks but one.
fn solve(blocks: &[Normal], left_out: Option<usize>, weights: [f64; 3]) -> Option<SVector<f64, UNKNOWNS>> {
    let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut right = SVector::<f64, UNKNOWNS>::zeros();
    for (_, block) in blocks.iter().enumerate().filter(|(index, _)| Some(*index) != left_out) {
        for ((square, product), weight) in block.iter().zip(weights) {
            normal += square * weight;
            right += product * weight;
        }
    }
    Some(normal.cholesky()?.solve(&right))
}

#[cfg(test)]
mod tests;
