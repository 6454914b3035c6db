//! Functions of the derivatives with their intervals, by the delta method and by sampling.

use doublet_core::statistics::{NORMAL_95, quantile};
use nalgebra::{DMatrix, DVector};

/// A 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Standard error.
    pub standard_error: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// The interval of an estimate that is normally distributed; none where its error is not a number.
    pub fn normal(value: f64, standard_error: f64) -> Option<Self> {
        let half = NORMAL_95 * standard_error;
        (value.is_finite() && standard_error.is_finite()).then_some(Self {
            standard_error,
            low: value - half,
            high: value + half,
        })
    }

    /// Standard deviation and the quantiles of 2.5 and 97.5 % of samples; none of fewer than two, or where one is not finite.
    pub fn of_samples(mut samples: Vec<f64>) -> Option<Self> {
        samples.sort_by(f64::total_cmp);
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let square: f64 = samples.iter().map(|value| (value - mean).powi(2)).sum();
        let standard_error = (square / (count - 1.0)).sqrt();
        let [low, high] = [0.025, 0.975].map(|share| quantile(&samples, share));
        (samples.len() > 1 && standard_error.is_finite()).then_some(Self { standard_error, low, high })
    }
}

/// A function of the derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Propagated {
    /// Value at the estimates.
    pub value: f64,
    /// Interval by its slopes.
    pub delta: Option<Interval>,
    /// Interval by samples.
    pub sampled: Option<Interval>,
    /// Share of each derivative in the variance by its own error alone, correlations left out; by index, the largest first.
    pub shares: Vec<(usize, f64)>,
}

/// Value and intervals of `function` at `values` with this covariance; slopes by central differences over a thousandth of each error.
pub fn propagate(
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
    samples: &[DVector<f64>],
    function: impl Fn(&DVector<f64>) -> f64,
) -> Propagated {
    let value = function(values);
    let slopes = DVector::from_fn(values.len(), |index, _| slope(values, covariance, index, &function));
    let variance = (slopes.transpose() * covariance * &slopes)[0];
    let mut shares: Vec<(usize, f64)> =
        (0..values.len()).map(|index| (index, slopes[index].powi(2) * covariance[(index, index)])).collect();
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    shares.retain(|(_, share)| *share > 0.0);
    shares.iter_mut().for_each(|(_, share)| *share /= sum);
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    Propagated {
        value,
        delta: Interval::normal(value, variance.max(0.0).sqrt()),
        sampled: Interval::of_samples(samples.iter().map(&function).collect()),
        shares,
    }
}

fn slope(
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
    index: usize,
    function: &impl Fn(&DVector<f64>) -> f64,
) -> f64 {
    /// Step as a fraction of the error.
    const FRACTION: f64 = 1e-3;
    let error = covariance[(index, index)].max(0.0).sqrt();
    if error == 0.0 {
        return 0.0;
    }
    let side = |step: f64| {
        let mut moved = values.clone();
        moved[index] += step;
        function(&moved)
    };
    let step = FRACTION * error;
    (side(step) - side(-step)) / (2.0 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_has_the_error_of_its_formula() {
        // a / b: (a/b)^2 (va/a^2 + vb/b^2 - 2 c/(a b)).
        let values = DVector::from_vec(vec![-0.7, -4.9, 3.0]);
        let covariance = DMatrix::from_row_slice(3, 3, &[4e-4, 1e-4, 0.0, 1e-4, 9e-4, 0.0, 0.0, 0.0, 1.0]);
        let found = propagate(&values, &covariance, &[], |v| -v[0] / v[1]);
        let ratio = values[0] / values[1];
        let variance = ratio * ratio * (4e-4 / 0.49 + 9e-4 / 24.01 - 2e-4 / (0.7 * 4.9));
        assert!((found.value + ratio).abs() < 1e-15);
        assert!((found.delta.unwrap().standard_error / variance.sqrt() - 1.0).abs() < 1e-6);
        assert_eq!(found.sampled, None);
        assert_eq!(found.shares.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 1]);
    }
}
