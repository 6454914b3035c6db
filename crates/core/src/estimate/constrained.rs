//! Least squares with fixed values, bounds and prior knowledge.

use nalgebra::{DMatrix, DVector};

use super::least_squares::check_values;
use super::triangle::{Solution, Triangle};
use super::{EstimateError, Fit};

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

/// A fit under constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstrainedFit {
    /// The fit; parameters that are fixed or at a bound have no standard error.
    pub fit: Fit,
    /// Whether each parameter is held by one of its bounds.
    pub at_bound: Vec<bool>,
}

/// Changes of the set of held parameters after which the search for it is given up, per parameter.
const SWAPS_PER_PARAMETER: usize = 20;
/// Rounds in which the residual variance, which weighs the priors, settles.
const PRIOR_ROUNDS: usize = 30;
/// Relative change of the residual variance that ends them.
const PRIOR_TOLERANCE: f64 = 1e-12;

/// Least squares under constraints: minimises `|z - X theta|^2 / s^2 + sum ((theta_j - mean_j) / deviation_j)^2` over the
/// parameters that are not fixed, inside the bounds. `s^2 = v'v / (n - p_free)` weighs the priors and is found with the
/// parameters. Bounds are met by holding parameters at them and releasing those whose gradient points inside (Lawson and
/// Hanson, "Solving Least Squares Problems", chapter 23).
///
/// # Errors
/// As for [`super::least_squares`], for the free parameters; bounds out of order, deviations that are not positive.
pub fn constrained_least_squares(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    constraints: &[Constraint],
) -> Result<ConstrainedFit, EstimateError> {
    check_values(names, x, z)?;
    check_constraints(names, constraints)?;
    let problem = Problem { names, constraints, triangle: Triangle::of(x, z), samples: z.len() };
    let mut variance = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    let mut outcome = problem.bounded(variance)?;
    for _ in 0..PRIOR_ROUNDS {
        let found = problem.variance(&outcome)?;
        let settled = (found - variance).abs() <= PRIOR_TOLERANCE * variance;
        variance = found;
        outcome = problem.bounded(variance)?;
        if settled {
            break;
        }
    }
    let fitted = (x * &outcome.solution.estimates).iter().copied().collect();
    let at_bound = outcome.held.iter().zip(constraints);
    let at_bound =
        at_bound.map(|(&held, constraint)| held && matches!(constraint, Constraint::Bounds { .. })).collect();
    Ok(ConstrainedFit { fit: Fit::with_variance(names, z, fitted, outcome.solution, variance), at_bound })
}

/// Checks number and ranges of the constraints.
fn check_constraints(names: &[String], constraints: &[Constraint]) -> Result<(), EstimateError> {
    if constraints.len() != names.len() {
        return Err(EstimateError::Size { quantity: "constraints", expected: names.len(), found: constraints.len() });
    }
    if constraints.iter().all(|constraint| matches!(constraint, Constraint::Fixed(_))) {
        return Err(EstimateError::NoParameters);
    }
    for (name, constraint) in names.iter().zip(constraints) {
        let fault = match *constraint {
            Constraint::Bounds { lower, upper } if lower.partial_cmp(&upper) != Some(std::cmp::Ordering::Less) => {
                Some((lower, "a lower bound below the upper one"))
            }
            Constraint::Prior { deviation, .. } if !(deviation > 0.0 && deviation.is_finite()) => {
                Some((deviation, "a positive standard deviation"))
            }
            Constraint::Prior { mean: value, .. } | Constraint::Fixed(value) if !value.is_finite() => {
                Some((value, "a finite value"))
            }
            _ => None,
        };
        if let Some((value, allowed)) = fault {
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
    /// Residual variance of a solution.
    fn variance(&self, outcome: &Outcome) -> Result<f64, EstimateError> {
        let free = outcome.held.iter().filter(|held| !**held).count();
        if self.samples <= free {
            return Err(EstimateError::TooFewSamples { samples: self.samples, parameters: free });
        }
        let residual = self.triangle.less(&outcome.solution.estimates);
        let square = residual.factor().column(self.names.len()).norm_squared();
        Ok(square / (self.samples - free) as f64)
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

    /// The free parameter furthest outside its bounds, relative to their distance, and the bound.
    fn worst_violation(&self, estimates: &DVector<f64>, held: &[bool]) -> Option<(usize, f64)> {
        let violation = |(index, constraint): (usize, &Constraint)| match *constraint {
            Constraint::Bounds { lower, upper } if !held[index] => {
                let bound = estimates[index].clamp(lower, upper);
                let outside = (estimates[index] - bound).abs() / (upper - lower);
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
        let inward = |(index, constraint): (usize, &Constraint)| match *constraint {
            Constraint::Bounds { lower, upper } if held[index] => {
                let scaled = pull[index] * (upper - lower);
                let inside = if estimates[index] <= lower { scaled } else { -scaled };
                (inside > 0.0).then_some((index, inside))
            }
            _ => None,
        };
        let strongest = self.constraints.iter().enumerate().filter_map(inward).max_by(|a, b| a.1.total_cmp(&b.1));
        strongest.map(|(index, _)| index)
    }
}
