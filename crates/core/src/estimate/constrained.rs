//! Least squares with fixed values, bounds and prior knowledge.

use std::hash::{Hash, Hasher};

use nalgebra::{DMatrix, DVector};

use super::least_squares::check_values;
use super::triangle::{Solution, Triangle};
use super::{EstimateError, Fit, Origin};
use crate::quantity::HashBits;

/// What is known of a parameter before the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraint {
    /// Nothing.
    Free,
    /// Its value.
    Fixed(f64),
    /// A range, ends included.
    Bounds {
        /// Smallest value.
        lower: f64,
        /// Largest value.
        upper: f64,
    },
    /// A value with a standard deviation, as from a wind tunnel or a handbook.
    Prior {
        /// Expected value.
        mean: f64,
        /// Standard deviation of the expectation.
        deviation: f64,
    },
}

/// Changes of the set of held parameters after which the search for it is given up, per parameter.
const SWAPS_PER_PARAMETER: usize = 20;
/// Pull inside a bound, as a fraction of the residual, below which it is rounding.
const RELEASE_TOLERANCE: f64 = 1e-13;
/// Rounds in which the residual variance, which weighs the priors, settles.
const PRIOR_ROUNDS: usize = 30;
/// Relative change of the residual variance that ends them.
const PRIOR_TOLERANCE: f64 = 1e-12;

impl Hash for Constraint {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match *self {
            Self::Free => {}
            Self::Fixed(value) => value.hash_bits(state),
            Self::Bounds { lower, upper } => [lower, upper].hash_bits(state),
            Self::Prior { mean, deviation } => [mean, deviation].hash_bits(state),
        }
    }
}

impl Constraint {
    /// What is wrong with it: a number of it and what is allowed there.
    pub fn fault(self) -> Option<(f64, &'static str)> {
        match self {
            Self::Bounds { lower, upper } if lower.partial_cmp(&upper) != Some(std::cmp::Ordering::Less) => {
                Some((lower, "a lower bound below the upper one"))
            }
            Self::Prior { deviation, .. } if !(deviation > 0.0 && deviation.is_finite()) => {
                Some((deviation, "a positive standard deviation"))
            }
            Self::Prior { mean: value, .. } | Self::Fixed(value) if !value.is_finite() => {
                Some((value, "a finite value"))
            }
            _ => None,
        }
    }
}

/// Least squares under constraints: minimises `|z - X theta|^2 / s^2 + sum ((theta_j - mean_j) / deviation_j)^2` over the
/// parameters that are not fixed, inside the bounds. `s^2 = v'v / (n - p_free + sum_j s^2 D_jj / deviation_j^2)`, with
/// `D = (X'X + s^2 diag(deviation^-2))^-1`, weighs the priors and is found with the parameters: a prior costs as much of a degree
/// of freedom as the samples still say of its parameter, none where the prior says all. Bounds are met by holding parameters at
/// them and releasing those whose gradient points inside (Lawson and Hanson, "Solving Least Squares Problems", chapter 23); either
/// bound may be infinite.
///
/// The covariance is `s^2 D` over the parameters that are not held; those that are, fixed or at a bound, have none
/// ([`Fit::origins`] says which).
///
/// # Errors
/// As for [`super::least_squares`], for the free parameters; bounds out of order, deviations that are not positive.
pub fn constrained_least_squares(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    constraints: &[Constraint],
) -> Result<Fit, EstimateError> {
    check_values(names, x, z)?;
    let square = z.iter().map(|z| z * z).sum();
    let found = solve_constrained(names, Triangle::reduce(x, z), (z.len(), square), constraints)?;
    let fitted = x * &found.solution.estimates;
    let fit = Fit::with_variance(names, z, fitted.as_slice(), found.solution, found.variance);
    Ok(Fit { origins: found.origins, ..fit })
}

/// Solution under constraints.
pub(super) struct ConstrainedSolution {
    /// Estimates and `D`, zero where a parameter is held.
    pub solution: Solution,
    /// Variance of the residual.
    pub variance: f64,
    /// What each parameter rests on.
    pub origins: Vec<Origin>,
    /// `s^2 / deviation^2` of each parameter with a prior, zero of the others: its information beside `X'X`.
    pub prior_information: Vec<f64>,
}

/// [`constrained_least_squares`] of a triangle of `samples` rows whose measurements have the sum of squares `square`.
pub(super) fn solve_constrained(
    names: &[String],
    triangle: Triangle,
    (samples, square): (usize, f64),
    constraints: &[Constraint],
) -> Result<ConstrainedSolution, EstimateError> {
    check_constraints(names, constraints)?;
    let problem = Problem { names, constraints, triangle, samples };
    let mut variance = square / samples.max(1) as f64;
    let mut outcome = problem.bounded(variance)?;
    for _ in 0..PRIOR_ROUNDS {
        let found = problem.variance(&outcome, variance)?;
        let settled = (found - variance).abs() <= PRIOR_TOLERANCE * variance;
        variance = found;
        outcome = problem.bounded(variance)?;
        if settled {
            break;
        }
    }
    Ok(ConstrainedSolution {
        origins: outcome.held.iter().zip(constraints).map(|(&held, constraint)| origin(held, constraint)).collect(),
        prior_information: constraints.iter().map(|constraint| information(constraint, variance)).collect(),
        solution: outcome.solution,
        variance,
    })
}

fn origin(held: bool, constraint: &Constraint) -> Origin {
    match constraint {
        Constraint::Fixed(_) => Origin::Fixed,
        Constraint::Prior { .. } => Origin::DataAndPrior,
        Constraint::Bounds { .. } if held => Origin::Bound,
        _ => Origin::Data,
    }
}

/// Information of a prior beside that of samples of a residual variance.
fn information(constraint: &Constraint, variance: f64) -> f64 {
    if let Constraint::Prior { deviation, .. } = constraint { variance / (deviation * deviation) } else { 0.0 }
}

/// Checks number and ranges of the constraints.
fn check_constraints(names: &[String], constraints: &[Constraint]) -> Result<(), EstimateError> {
    if constraints.len() != names.len() {
        return Err(EstimateError::Size { quantity: "constraints", expected: names.len(), found: constraints.len() });
    }
    for (name, constraint) in names.iter().zip(constraints) {
        if let Some((value, allowed)) = constraint.fault() {
            return Err(EstimateError::Setting { setting: format!("constraint of {name}"), value, allowed });
        }
    }
    Ok(())
}

/// Solution with the set of parameters that were held.
struct Outcome {
    solution: Solution,
    held: Vec<bool>,
}

/// What the rounds share.
struct Problem<'a> {
    names: &'a [String],
    constraints: &'a [Constraint],
    triangle: Triangle,
    samples: usize,
}

impl Problem<'_> {
    /// Residual variance of a solution whose priors were weighed with `variance`.
    fn variance(&self, outcome: &Outcome, variance: f64) -> Result<f64, EstimateError> {
        let free = outcome.held.iter().filter(|held| !**held).count();
        if self.samples <= free {
            return Err(EstimateError::TooFewSamples { samples: self.samples, parameters: free });
        }
        let from_prior = |(index, constraint): (usize, &Constraint)| {
            outcome.solution.unit_covariance[(index, index)] * information(constraint, variance)
        };
        let from_prior: f64 = self.constraints.iter().enumerate().map(from_prior).sum();
        let residual = self.triangle.less(&outcome.solution.estimates);
        let square = residual.factor().column(self.names.len()).norm_squared();
        Ok(square / ((self.samples - free) as f64 + from_prior))
    }

    /// Solution inside the bounds for a given residual variance.
    fn bounded(&self, variance: f64) -> Result<Outcome, EstimateError> {
        let rows: Vec<(f64, usize, f64)> = self
            .constraints
            .iter()
            .enumerate()
            .filter_map(|(index, constraint)| match *constraint {
                Constraint::Prior { mean, deviation } => Some((variance.sqrt() / deviation, index, mean)),
                _ => None,
            })
            .collect();
        let triangle = self.triangle.with_rows(&rows);
        let mut values = DVector::from_iterator(
            self.names.len(),
            self.constraints
                .iter()
                .map(|constraint| if let Constraint::Fixed(value) = constraint { *value } else { 0.0 }),
        );
        let mut held: Vec<bool> = self.constraints.iter().map(|c| matches!(c, Constraint::Fixed(_))).collect();
        for _ in 0..SWAPS_PER_PARAMETER * self.names.len() {
            let solution = self.solve(&triangle, &values, &held)?;
            if let Some((index, bound)) = self.worst_violation(&solution.estimates, &held) {
                held[index] = true;
                values[index] = bound;
            } else if let Some(index) = self.released(&triangle, &solution.estimates, &held) {
                held[index] = false;
                values[index] = 0.0;
            } else {
                return Ok(Outcome { solution, held });
            }
        }
        Err(EstimateError::NotConverged { method: "the search for active bounds", iterations: SWAPS_PER_PARAMETER })
    }

    /// Least squares over the parameters that are not held.
    fn solve(&self, triangle: &Triangle, values: &DVector<f64>, held: &[bool]) -> Result<Solution, EstimateError> {
        let free: Vec<usize> = (0..held.len()).filter(|&index| !held[index]).collect();
        let mut estimates = values.clone();
        let mut unit_covariance = DMatrix::zeros(held.len(), held.len());
        let mut condition_number = 1.0;
        if !free.is_empty() {
            let chosen: Vec<String> = free.iter().map(|&index| self.names[index].clone()).collect();
            let part = triangle.less(values).subset(&free).solve(&chosen)?;
            for (i, &row) in free.iter().enumerate() {
                estimates[row] = part.estimates[i];
                for (j, &column) in free.iter().enumerate() {
                    unit_covariance[(row, column)] = part.unit_covariance[(i, j)];
                }
            }
            condition_number = part.condition_number;
        }
        Ok(Solution { estimates, unit_covariance, condition_number })
    }

    /// The free parameter furthest outside its bounds, by what that makes of the measurement, and the bound.
    fn worst_violation(&self, estimates: &DVector<f64>, held: &[bool]) -> Option<(usize, f64)> {
        let violation = |(index, constraint): (usize, &Constraint)| match *constraint {
            Constraint::Bounds { lower, upper } if !held[index] => {
                let bound = estimates[index].clamp(lower, upper);
                let outside = (estimates[index] - bound).abs() * self.triangle.factor().column(index).norm();
                (outside > 0.0).then_some((index, bound, outside))
            }
            _ => None,
        };
        let worst = self.constraints.iter().enumerate().filter_map(violation).max_by(|a, b| a.2.total_cmp(&b.2));
        worst.map(|(index, bound, _)| (index, bound))
    }

    /// The parameter at a bound that the cost pulls inside most.
    fn released(&self, triangle: &Triangle, estimates: &DVector<f64>, held: &[bool]) -> Option<usize> {
        let p = self.names.len();
        let residual = triangle.less(estimates);
        let pull = triangle.factor().columns(0, p).tr_mul(&residual.factor().column(p));
        let least = RELEASE_TOLERANCE * residual.factor().column(p).norm();
        let inward = |(index, constraint): (usize, &Constraint)| match *constraint {
            Constraint::Bounds { lower, .. } if held[index] => {
                let inside = if estimates[index] <= lower { pull[index] } else { -pull[index] };
                let inside = inside / self.triangle.factor().column(index).norm();
                (inside > least).then_some((index, inside))
            }
            _ => None,
        };
        let strongest = self.constraints.iter().enumerate().filter_map(inward).max_by(|a, b| a.1.total_cmp(&b.1));
        strongest.map(|(index, _)| index)
    }
}
