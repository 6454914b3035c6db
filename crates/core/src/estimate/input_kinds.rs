//! One kind of input against another.

use super::summary::ParameterSummary;
use super::{Fit, summarise};

/// A parameter from manoeuvres of two kinds of input.
#[derive(Clone, Debug, PartialEq)]
pub struct KindDifference {
    /// The parameter over the manoeuvres of the first kind.
    pub first: ParameterSummary,
    /// The same over those of the second kind.
    pub second: ParameterSummary,
    /// `(mean_2 - mean_1) / sqrt(s_1^2 / n_1 + s_2^2 / n_2)` (Welch): beyond two in magnitude the kinds hardly agree. NaN with a
    /// single manoeuvre of a kind.
    pub difference_in_errors: f64,
}

/// Means and scatter of every parameter from manoeuvres of two kinds of input, for example doublets and 3-2-1-1 (thesis
/// Fig. 6.12). Parameters that only one kind has are left out.
pub fn compare_kinds(first: &[&Fit], second: &[&Fit]) -> Vec<KindDifference> {
    let others = summarise(second);
    summarise(first).into_iter().filter_map(|first| compare(first, &others)).collect()
}

fn compare(first: ParameterSummary, others: &[ParameterSummary]) -> Option<KindDifference> {
    let second = others.iter().find(|other| other.name == first.name)?.clone();
    let variance = |summary: &ParameterSummary| summary.scatter.powi(2) / summary.fits as f64;
    let error = (variance(&first) + variance(&second)).sqrt();
    Some(KindDifference { difference_in_errors: (second.estimate[0] - first.estimate[0]) / error, first, second })
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::super::least_squares;
    use super::*;

    #[test]
    fn difference_of_kinds_matches_hand_calculation() {
        let fit = |value: f64| {
            let x = DMatrix::from_element(3, 1, 1.0);
            least_squares(&["Cm_q".to_owned()], &x, &[value - 0.1, value, value + 0.1]).unwrap()
        };
        let (doublets, multisteps) = ([fit(1.0), fit(2.0), fit(3.0)], [fit(5.0), fit(7.0)]);
        let found = compare_kinds(&doublets.iter().collect::<Vec<_>>(), &multisteps.iter().collect::<Vec<_>>());
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].first.fits, found[0].second.fits), (3, 2));
        // Means 2 and 6, variances 1 and 2: 4 / sqrt(1/3 + 2/2).
        approx::assert_relative_eq!(found[0].difference_in_errors, 4.0 / (4.0_f64 / 3.0).sqrt(), epsilon = 1e-12);
        let alone = compare_kinds(&[&doublets[0]], &[&multisteps[0]]);
        assert!(alone[0].difference_in_errors.is_nan());
    }
}
