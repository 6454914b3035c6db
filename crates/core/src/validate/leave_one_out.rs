//! Leave one manoeuvre out: how much each manoeuvre carries, and how well the others predict it.

use nalgebra::DVector;

use super::validate;
use crate::estimate::{EstimateError, FitQuality, Origin, PooledFit, PooledRegression};

/// The pooled estimate without one window.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Window left out.
    pub label: String,
    /// Estimates of the parameters all windows share, in the order of the full fit.
    pub estimates: Vec<f64>,
    /// Change of each against the full fit, in standard errors of the full fit; zero for one that is fixed.
    pub shift_in_errors: Vec<f64>,
    /// Prediction of the window by the others; a constant that each has to itself counts with its mean over them.
    pub quality_identified: FitQuality,
    /// Likewise, but a constant of its own is set so that the mean residual is zero.
    pub quality_own_constant: FitQuality,
}

/// Fits all windows but one, for each in turn, and predicts that one (thesis 7.1 with every manoeuvre as validation once).
/// `full` is the fit of all windows.
///
/// # Errors
/// The first error of a fit without one window, as for [`crate::estimate::pooled`]; fewer than two windows.
pub fn leave_one_out(regression: &PooledRegression, full: &PooledFit) -> Result<Vec<LeftOut>, EstimateError> {
    let PooledRegression { names, per_window, windows, .. } = regression;
    if windows.len() < 2 {
        return Err(EstimateError::Size { quantity: "windows", expected: 2, found: windows.len() });
    }
    let shared: Vec<usize> = (0..names.len()).filter(|&term| !per_window[term]).collect();
    let mut rest = regression.clone();
    let mut results = Vec::with_capacity(windows.len());
    for index in 0..windows.len() {
        let left = rest.windows.remove(index);
        let PooledFit { fit, parameters, .. } = rest.fit()?;
        let estimates: Vec<f64> = fit.estimates[..shared.len()].to_vec();
        let columns: Vec<usize> = (0..shared.len()).collect();
        let prediction = validate(&fit, Some(&columns), &left.x.select_columns(&shared), &left.z)?;
        let mean = |term: usize| {
            let values = parameters.iter().map(|columns| fit.estimates[columns[term]]);
            values.sum::<f64>() / parameters.len() as f64
        };
        let values = DVector::from_fn(names.len(), |term, _| mean(term));
        let identified: Vec<f64> = (&left.x * values).iter().copied().collect();
        let has_own = shared.len() < names.len();
        let shifts = estimates.iter().enumerate().map(|(at, estimate)| shift_in_errors(full, at, *estimate));
        results.push(LeftOut {
            label: left.label.clone(),
            shift_in_errors: shifts.collect(),
            quality_identified: FitQuality::compare(&left.z, &identified),
            quality_own_constant: if has_own { prediction.quality_without_offset } else { prediction.quality },
            estimates,
        });
        rest.windows.insert(index, left);
    }
    Ok(results)
}

fn shift_in_errors(full: &PooledFit, parameter: usize, estimate: f64) -> f64 {
    let change = estimate - full.fit.estimates[parameter];
    if full.fit.origins[parameter] == Origin::Fixed { 0.0 } else { change / full.fit.standard_errors[parameter] }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::estimate::PooledWindow;

    /// Rounding of a fit of a hundred samples.
    const ROUNDING: f64 = 1e-10;

    #[test]
    fn a_manoeuvre_that_differs_is_the_one_the_others_do_not_predict() {
        let mut regression = PooledRegression {
            names: vec!["c".to_owned(), "s".to_owned()],
            per_window: vec![true, false],
            constraints: Vec::new(),
            windows: vec![window("a", 1.0, 2.0), window("b", -3.0, 2.0), window("odd", 0.0, 5.0)],
        };
        let full = regression.fit().unwrap();
        let found = leave_one_out(&regression, &full).unwrap();
        let labels: Vec<&str> = found.iter().map(|left| left.label.as_str()).collect();
        assert_eq!(labels, ["a", "b", "odd"]);
        // Equal excitation: the full slope is the mean of 2, 2, 5; without the odd one it is 2, with one of the others 3.5.
        approx::assert_relative_eq!(full.fit.estimates[0], 3.0, epsilon = ROUNDING);
        for (left, expected) in found.iter().zip([3.5, 3.5, 2.0]) {
            approx::assert_relative_eq!(left.estimates[0], expected, epsilon = ROUNDING);
            let shift = (expected - 3.0) / full.fit.standard_errors[0];
            approx::assert_relative_eq!(left.shift_in_errors[0], shift, epsilon = 1e-6);
        }
        // Predicting slope 5 by 2 leaves 3/5 of the signal: R2 = 1 - 0.36; constants of their own do not count.
        approx::assert_relative_eq!(found[2].quality_own_constant.r_squared, 1.0 - 0.36, epsilon = ROUNDING);
        // With the mean of the constants 1 and -3 the prediction is off by one more than that.
        let mean = |of: &dyn Fn(f64) -> f64| (0..100).map(|row| of((f64::from(row) * 0.1).sin())).sum::<f64>() / 100.0;
        let (first, second) = (mean(&|sine| sine), mean(&|sine| sine * sine));
        let expected = 1.0 - mean(&|sine| (3.0 * sine + 1.0).powi(2)) / (25.0 * (second - first * first));
        approx::assert_relative_eq!(found[2].quality_identified.r_squared, expected, epsilon = ROUNDING);
        regression.windows.truncate(1);
        assert!(leave_one_out(&regression, &full).is_err());
    }

    fn window(label: &str, constant: f64, slope: f64) -> PooledWindow {
        let x = DMatrix::from_fn(100, 2, |row, column| if column == 0 { 1.0 } else { (row as f64 * 0.1).sin() });
        let z = x.row_iter().map(|row| constant + slope * row[1]).collect();
        PooledWindow { label: label.to_owned(), x, z }
    }
}
