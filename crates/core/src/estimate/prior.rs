//! An earlier estimate and that of a flight, combined, and whether they contradict each other.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// A value known before the flight, with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Value.
    pub mean: f64,
    /// Standard deviation, above zero.
    pub deviation: f64,
}

/// Prior and flight combined.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// Combined values.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Difference of flight and prior over its standard deviation, where there is a prior.
    pub conflicts: Vec<Option<f64>>,
    /// Probability of a difference as large as that where nothing contradicts, two-sided.
    pub probabilities: Vec<Option<f64>>,
    /// Squared distance of flight and prior together, and how many values it is over.
    pub distance: (f64, usize),
    /// Probability of one as large.
    pub probability: f64,
}

/// Combines `flight`, with its covariance C, and what was known of some of the values, independent of each other, with the variances P.
///
/// With H picking the values that have a prior: `S = H C H' + P`, `K = C H' S^-1`, `x = f + K (m - H f)`, `C+ = (1 - K H) C`; the
/// conflict of all is `(m - H f)' S^-1 (m - H f)`, chi-squared with as many degrees of freedom as there are priors, that of one its own
/// difference over the root of its variance in S.
///
/// `None` where the lengths differ or S has no inverse.
pub fn combine(flight: &[f64], covariance: &DMatrix<f64>, known: &[Option<Known>]) -> Option<Posterior> {
    let count = flight.len();
    if known.len() != count || covariance.shape() != (count, count) {
        return None;
    }
    let with: Vec<(usize, Known)> = known.iter().enumerate().filter_map(|(i, known)| Some((i, (*known)?))).collect();
    let rows = with.len();
    let difference = DVector::from_iterator(rows, with.iter().map(|(i, known)| known.mean - flight[*i]));
    let s = DMatrix::from_fn(rows, rows, |a, b| {
        let own = if a == b { with[a].1.deviation.powi(2) } else { 0.0 };
        covariance[(with[a].0, with[b].0)] + own
    });
    let cross = DMatrix::from_fn(count, rows, |i, a| covariance[(i, with[a].0)]);
    let factored = s.clone().cholesky()?;
    let gain = factored.solve(&cross.transpose()).transpose();
    let values = DVector::from_column_slice(flight) + &gain * &difference;
    let distance = difference.dot(&factored.solve(&difference));
    let (mut conflicts, mut probabilities) = (vec![None; count], vec![None; count]);
    for (row, (index, _)) in with.iter().enumerate() {
        let z = -difference[row] / s[(row, row)].sqrt();
        conflicts[*index] = Some(z);
        probabilities[*index] = Some(2.0 * Normal::standard().sf(z.abs()));
    }
    let probability = ChiSquared::new(rows.max(1) as f64).map_or(f64::NAN, |of| of.sf(distance));
    Some(Posterior {
        values: values.as_slice().to_vec(),
        covariance: covariance - &gain * cross.transpose(),
        conflicts,
        probabilities,
        distance: (distance, rows),
        probability: if rows == 0 { 1.0 } else { probability },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_is_the_mean_weighted_by_its_variances() {
        let known = [Some(Known { mean: 2.0, deviation: 0.5 })];
        let found = combine(&[1.0], &DMatrix::from_element(1, 1, 0.25), &known).unwrap();
        assert!((found.values[0] - 1.5).abs() < 1e-15 && (found.covariance[(0, 0)] - 0.125).abs() < 1e-15);
        // A difference of 1 with a variance of 0.5: 1.414 deviations, as large in 15.73 % of cases.
        assert!((found.conflicts[0].unwrap() + std::f64::consts::SQRT_2).abs() < 1e-12);
        assert!((found.probabilities[0].unwrap() - 0.157_299_207).abs() < 1e-8);
        assert!((found.distance.0 - 2.0).abs() < 1e-12 && (found.probability - 0.157_299_207).abs() < 1e-8);
    }

    #[test]
    fn what_is_known_of_one_value_moves_those_correlated_with_it_as_information_adds_up() {
        let covariance = DMatrix::from_row_slice(2, 2, &[0.04, 0.03, 0.03, 0.09]);
        let known = [None, Some(Known { mean: -0.2, deviation: 0.1 })];
        let found = combine(&[1.0, 0.4], &covariance, &known).unwrap();
        // Independently: information matrices and vectors added.
        let flight = covariance.clone().try_inverse().unwrap();
        let mut information = flight.clone();
        information[(1, 1)] += 100.0;
        let expected = information.clone().try_inverse().unwrap();
        let vector = flight * DVector::from_column_slice(&[1.0, 0.4]) + DVector::from_column_slice(&[0.0, -20.0]);
        let mean = &expected * vector;
        assert!((found.covariance - expected).amax() < 1e-15);
        assert!((DVector::from_vec(found.values) - mean).amax() < 1e-14);
        assert_eq!(found.conflicts[0], None);
    }
}
