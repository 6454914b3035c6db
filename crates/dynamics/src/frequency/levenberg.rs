//! Least squares of complex residuals after Levenberg and Marquardt.

use nalgebra::{Complex, DMatrix, DVector};

/// Residuals `measured - model`, weighted, and derivatives of the weighted model.
pub(super) struct Evaluation {
    pub residuals: DVector<Complex<f64>>,
    /// Residuals by parameters.
    pub slopes: DMatrix<Complex<f64>>,
}

impl Evaluation {
    /// Sum of squared magnitudes.
    pub fn cost(&self) -> f64 {
        self.residuals.iter().map(Complex::norm_sqr).sum()
    }

    /// `Re(J* J)`.
    pub fn information(&self) -> DMatrix<f64> {
        (self.slopes.adjoint() * &self.slopes).map(|value| value.re)
    }
}

/// Most steps.
const STEPS: usize = 200;
/// Relative fall of the cost that ends the search.
const SETTLED: f64 = 1e-13;

/// Parameters of the least cost from `start`, none below its `lower` bound nor, where not `free`, moved.
pub(super) fn minimise(
    start: &[f64],
    lower: &[f64],
    free: &[bool],
    evaluate: impl Fn(&[f64]) -> Evaluation,
) -> (Vec<f64>, Evaluation) {
    let mut parameters = start.to_vec();
    let mut here = evaluate(&parameters);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let gradient = (here.slopes.adjoint() * &here.residuals).map(|value| value.re);
        let information = here.information();
        // A parameter at its bound that the gradient presses against it stays there.
        let moves = |i: usize| free[i] && (parameters[i] > lower[i] || gradient[i] > 0.0);
        let damped =
            DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| match (moves(i) && moves(j), i == j) {
                (true, true) => information[(i, i)] * (1.0 + damping) + f64::MIN_POSITIVE,
                (true, false) => information[(i, j)],
                (false, is_diagonal) => f64::from(u8::from(is_diagonal)),
            });
        let right = DVector::from_fn(parameters.len(), |i, _| if moves(i) { gradient[i] } else { 0.0 });
        let Some(step) = damped.cholesky().map(|factor| factor.solve(&right)) else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
            continue;
        };
        let moved: Vec<f64> = parameters
            .iter()
            .zip(step.iter())
            .zip(lower)
            .map(|((value, step), lower)| (value + step).max(*lower))
            .collect();
        let there = evaluate(&moved);
        let fall = here.cost() - there.cost();
        if fall >= 0.0 {
            let is_settled = fall <= SETTLED * here.cost();
            (parameters, here) = (moved, there);
            damping = (0.2 * damping).max(1e-12);
            if is_settled {
                break;
            }
        } else {
            damping *= 5.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    (parameters, here)
}
