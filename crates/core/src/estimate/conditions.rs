//! Derivatives over the flight condition.

use nalgebra::DMatrix;

use super::{EstimateError, Fit, weighted_least_squares};

/// A derivative from one manoeuvre and the condition it was flown at.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct ConditionPoint {
    pub estimate: f64,
    pub standard_error: f64,
    /// Condition: one value per variable of the regression, for example airspeed and altitude.
    pub condition: Vec<f64>,
}

/// A derivative as a linear function of the flight condition.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionFit {
    /// Mean condition, one value per variable; the first parameter holds there.
    pub mean: Vec<f64>,
    /// Value at the mean condition, then the slope over each variable, with standard errors that contain the scatter.
    pub fit: Fit,
    /// `sqrt(chi2 / (n - p))`: scatter of the manoeuvres about the line over their stated errors. Above one, something beside
    /// condition and noise makes them differ, and the errors of the fit have been raised by it.
    pub scatter_ratio: f64,
}

/// Regression `derivative = value + sum slope_j (condition_j - mean_j)` over manoeuvres (thesis 2.3.4), weighted by the errors of
/// the derivatives. Errors of the result are those of the weights, raised by the scatter about the line where that is larger.
///
/// # Errors
/// As for [`super::weighted_least_squares`]: fewer manoeuvres than parameters, and conditions that do not vary or vary together,
/// by the names of `variables`; errors that are not positive.
pub fn condition_regression(variables: &[&str], points: &[ConditionPoint]) -> Result<ConditionFit, EstimateError> {
    let count = points.len();
    if let Some(point) = points.iter().find(|point| point.condition.len() != variables.len()) {
        let found = point.condition.len();
        return Err(EstimateError::Size { quantity: "values of the condition", expected: variables.len(), found });
    }
    if let Some(point) = points.iter().find(|point| !(point.standard_error > 0.0 && point.standard_error.is_finite())) {
        return Err(EstimateError::Setting {
            setting: "standard error of a derivative".to_owned(),
            value: point.standard_error,
            allowed: "positive and finite",
        });
    }
    let mean: Vec<f64> = (0..variables.len())
        .map(|variable| points.iter().map(|point| point.condition[variable]).sum::<f64>() / count as f64)
        .collect();
    let x = DMatrix::from_fn(count, variables.len() + 1, |row, column| match column {
        0 => 1.0,
        _ => points[row].condition[column - 1] - mean[column - 1],
    });
    let names: Vec<String> = std::iter::once("value").chain(variables.iter().copied()).map(str::to_owned).collect();
    let z: Vec<f64> = points.iter().map(|point| point.estimate).collect();
    let weights: Vec<f64> = points.iter().map(|point| point.standard_error.powi(-2)).collect();
    let fit = weighted_least_squares(&names, &x, &z, &weights)?;
    let scatter_ratio = fit.residual_std;
    let covariance = &fit.unit_covariance * scatter_ratio.max(1.0).powi(2);
    Ok(ConditionFit { mean, scatter_ratio, fit: fit.with_covariance(covariance) })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// `Cm_alpha` of a flight through speeds and altitudes, with noise of `scale` times the stated errors.
    fn points(seed: u64, scale: f64) -> Vec<ConditionPoint> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let point = |k: u32| {
            let (v, h) = (45.0 + 2.0 * f64::from(k % 7), 900.0 + 150.0 * f64::from(k % 5));
            let error = 0.01 * (1.0 + f64::from(k % 3));
            let draw: f64 = StandardNormal.sample(&mut rng);
            let truth = -1.0 + 0.004 * (v - 50.0) - 2e-5 * (h - 1200.0);
            ConditionPoint { estimate: truth + scale * error * draw, standard_error: error, condition: vec![v, h] }
        };
        (0..24).map(point).collect()
    }

    #[test]
    fn slopes_over_airspeed_and_altitude_are_recovered_with_honest_errors() {
        let mut squares = 0.0;
        for seed in 0..200 {
            let found = condition_regression(&["V", "h"], &points(seed, 1.0)).unwrap();
            for (index, truth) in [(1, 0.004), (2, -2e-5)] {
                squares += ((found.fit.estimates[index] - truth) / found.fit.standard_errors[index]).powi(2);
            }
        }
        // 400 squared normalised errors of expectation one at most (errors are only ever raised): three standard deviations of
        // their mean are 0.21; raising by the scatter where it exceeds one lowers it by up to a quarter.
        assert!((0.6..1.21).contains(&(squares / 400.0)), "{}", squares / 400.0);
    }

    #[test]
    fn scatter_beyond_the_stated_errors_raises_them() {
        let quiet = condition_regression(&["V", "h"], &points(3, 0.0)).unwrap();
        approx::assert_relative_eq!(quiet.fit.estimates[1], 0.004, max_relative = 1e-9);
        let loud = condition_regression(&["V", "h"], &points(3, 5.0)).unwrap();
        // 21 degrees of freedom: the ratio scatters by 15 %.
        assert!((3.0..7.5).contains(&loud.scatter_ratio), "{}", loud.scatter_ratio);
        approx::assert_relative_eq!(
            loud.fit.standard_errors[1],
            loud.scatter_ratio * quiet.fit.standard_errors[1],
            max_relative = 1e-9
        );
    }

    #[test]
    fn condition_that_does_not_vary_is_named() {
        let mut same = points(1, 1.0);
        same.iter_mut().for_each(|point| point.condition[1] = 1200.0);
        let message = condition_regression(&["V", "h"], &same).unwrap_err().to_string();
        assert!(message.contains("'h'"), "{message}");
        assert!(condition_regression(&["V", "h"], &same[..2]).is_err());
    }
}
