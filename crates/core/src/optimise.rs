//! Searches for the least of a function: of one variable over a range, and the quasi-Newton step of many.

use nalgebra::{DMatrix, DVector};

/// Values tried before the best is refined, so that a second valley is not missed.
const COARSE: usize = 21;
/// Fraction of the range at which the refinement stops.
const RESOLUTION: f64 = 1e-6;
/// Ratio of the golden section, `(sqrt(5) - 1) / 2`.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Value of the smallest cost in `lower..=upper`, and the costs of the coarse scan: `COARSE` values, then golden section about the
/// best of them. The range must be finite and in order.
///
/// # Errors
/// The first error of `cost`.
pub fn minimise<E>(
    lower: f64,
    upper: f64,
    cost: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, Vec<(f64, f64)>), E> {
    let range = upper - lower;
    let step = range / (COARSE - 1) as f64;
    let mut scan = Vec::with_capacity(COARSE);
    for index in 0..COARSE {
        let value = lower + step * index as f64;
        scan.push((value, cost(value)?));
    }
    let best =
        scan.iter().copied().fold((lower, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
    let (mut left, mut right) = ((best.0 - step).max(lower), (best.0 + step).min(upper));
    let (mut low, mut high) = (right - GOLDEN * (right - left), left + GOLDEN * (right - left));
    let (mut cost_low, mut cost_high) = (cost(low)?, cost(high)?);
    while right - left > RESOLUTION * range {
        if cost_low <= cost_high {
            (right, high, cost_high) = (high, low, cost_low);
            low = right - GOLDEN * (right - left);
            cost_low = cost(low)?;
        } else {
            (left, low, cost_low) = (low, high, cost_high);
            high = left + GOLDEN * (right - left);
            cost_high = cost(high)?;
        }
    }
    // An end of the range is not approached by bisection: take it where it is better.
    let mut value = 0.5 * (left + right);
    for end in [lower, upper] {
        if cost(end)? < cost(value)? {
            value = end;
        }
    }
    Ok((value, scan))
}

/// Update of Broyden, Fletcher, Goldfarb & Shanno of the inverse curvature, for a step and the fall of the gradient over it.
pub(crate) fn bfgs_update(inverse: &mut DMatrix<f64>, step: &DVector<f64>, fall: &DVector<f64>) {
    let along = step.dot(fall);
    if along <= 1e-12 * step.norm() * fall.norm() {
        return;
    }
    let moved = &*inverse * fall;
    let factor = (along + fall.dot(&moved)) / (along * along);
    *inverse += step * step.transpose() * factor - (&moved * step.transpose() + step * moved.transpose()) / along;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deeper_of_two_valleys_is_found() {
        let cost = |x: f64| Ok::<_, ()>((x * x - 1.0).powi(2) + 0.2 * x);
        let (value, scan) = minimise(-2.0, 2.0, &mut { cost }).unwrap();
        // 4 x^3 - 4 x + 0.2 = 0 on the left.
        assert!((4.0 * value.powi(3) - 4.0 * value + 0.2).abs() < 1e-4 && value < -1.0, "{value}");
        assert_eq!(scan.len(), 21);
        assert_eq!(minimise(1.0, 3.0, &mut |x| Ok::<_, ()>(x)).unwrap().0, 1.0);
    }

    #[test]
    fn updates_along_independent_directions_find_the_inverse_curvature() {
        let curvature = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 3.0]);
        let mut inverse = DMatrix::identity(2, 2);
        // Conjugate directions: the quadratic is then known after two of them.
        let first = DVector::from_vec(vec![1.0, 0.0]);
        let second = DVector::from_vec(vec![-1.0, 4.0]);
        for step in [first, second] {
            bfgs_update(&mut inverse, &step, &(&curvature * &step));
        }
        assert!((inverse * curvature - DMatrix::identity(2, 2)).amax() < 1e-12);
    }
}
