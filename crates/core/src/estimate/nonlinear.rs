//! A parameter that changes the regressors of several coefficients at once, such as the delay of a control.

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::search::minimise;
use super::{Coloured, Constraint, EstimateError, PooledFit, PooledRegression, PooledWindow};

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct NonlinearSearch {
    /// Value that fits all regressions best.
    pub value: f64,
    /// Standard error, corrected for correlated residuals, with all other parameters free; infinite at an end of the range, where
    /// the best value may lie beyond.
    pub standard_error: f64,
    /// Value each regression alone would move to from there, and its corrected standard error: they agree when the parameter
    /// is what it is taken for.
    pub by_regression: Vec<(f64, f64)>,
    /// Cost over the range, `sum N ln(v'v / N)` less its smallest value: twice the loss of log-likelihood for white residuals.
    pub profile: Vec<(f64, f64)>,
    /// Fits at the value.
    pub fits: Vec<PooledFit>,
}

impl NonlinearSearch {
    /// Probability of values of the regressions as far apart as these, or further, where they all have the same: of the sum of
    /// squares of their distances from their weighted mean, in standard errors (chi-squared, one degree of freedom fewer than
    /// regressions); one for a single regression.
    pub fn agreement(&self) -> f64 {
        let weight = |error: f64| error.powi(-2);
        let sum = |part: &dyn Fn(f64, f64) -> f64| -> f64 {
            self.by_regression.iter().map(|&(value, error)| part(value, weight(error))).sum()
        };
        let mean = sum(&|value, weight| weight * value) / sum(&|_, weight| weight);
        let squares = sum(&|value, weight| weight * (value - mean).powi(2));
        let degrees = self.by_regression.len().saturating_sub(1) as f64;
        ChiSquared::new(degrees).map_or(1.0, |chi| chi.sf(squares))
    }
}

/// Fraction of the range over which regressors are differentiated.
const STEP: f64 = 1e-3;

/// Minimises `sum N ln(v'v / N)` over the regressions that `regressions_at(value)` gives, `lower..=upper`; all other
/// parameters are linear and solved for inside (variable projection, profile likelihood).
///
/// The error comes from one more regressor, `sum_j theta_j dx_j / d value`: its parameter is the step the regression wants, its
/// coloured variance that of the value.
///
/// # Errors
/// A range out of order, no regression, and the first error of a fit or of `regressions_at`.
pub fn search_nonlinear<E: From<EstimateError>>(
    lower: f64,
    upper: f64,
    mut regressions_at: impl FnMut(f64) -> Result<Vec<PooledRegression>, E>,
) -> Result<NonlinearSearch, E> {
    let mut cost = |value: f64| -> Result<f64, E> { Ok(sum_costs(&regressions_at(value)?)?) };
    let (value, mut profile) = minimise(lower, upper, &mut cost)?;
    let smallest = cost(value)?;
    profile.iter_mut().for_each(|(_, cost)| *cost -= smallest);

    let step = STEP * (upper - lower);
    let inside = value - step > lower && value + step < upper;
    let (here, reach) = (regressions_at(value)?, [(value - step).max(lower), (value + step).min(upper)]);
    let (below, above) = (regressions_at(reach[0])?, regressions_at(reach[1])?);
    let (mut by_regression, mut fits, mut information) = (Vec::new(), Vec::new(), 0.0);
    for ((regression, below), above) in here.iter().zip(&below).zip(&above) {
        let fit = regression.fit()?;
        let (change, error) = wanted_change(regression, &fit, [below, above], reach[1] - reach[0])?;
        information += error.powi(-2);
        by_regression.push((value + change, error));
        fits.push(fit);
    }
    let standard_error = if inside { information.sqrt().recip() } else { f64::INFINITY };
    Ok(NonlinearSearch { value, standard_error, by_regression, profile, fits })
}

fn sum_costs(regressions: &[PooledRegression]) -> Result<f64, EstimateError> {
    if regressions.is_empty() {
        return Err(EstimateError::NoParameters);
    }
    let mut sum = 0.0;
    for regression in regressions {
        let fit = regression.fit()?.fit;
        sum += 2.0 * fit.samples() as f64 * fit.quality.rms.ln();
    }
    Ok(sum)
}

/// Change of the value that one regression wants, and its corrected standard error.
fn wanted_change(
    regression: &PooledRegression,
    fit: &PooledFit,
    [below, above]: [&PooledRegression; 2],
    width: f64,
) -> Result<(f64, f64), EstimateError> {
    /// Name of the added regressor.
    const CHANGE: &str = "change of the value";
    let window = |(index, window): (usize, &PooledWindow)| {
        let estimates: Vec<f64> = fit.parameters[index].iter().map(|&column| fit.fit.estimates[column]).collect();
        let slope = (&above.windows[index].x - &below.windows[index].x) * DVector::from_vec(estimates) / width;
        let mut x = window.x.clone().insert_column(window.x.ncols(), 0.0);
        x.set_column(window.x.ncols(), &slope);
        PooledWindow { label: window.label.clone(), x, z: window.z.clone() }
    };
    let mut augmented = PooledRegression {
        names: regression.names.clone(),
        per_window: regression.per_window.clone(),
        constraints: regression.constraints.clone(),
        windows: regression.windows.iter().enumerate().map(window).collect(),
    };
    augmented.names.push(CHANGE.to_owned());
    augmented.per_window.push(false);
    if !augmented.constraints.is_empty() {
        augmented.constraints.push(Constraint::Free);
    }
    let fit = augmented.fit()?;
    let covariance = fit.coloured_covariance(&augmented.windows, &Coloured::default())?;
    let place = augmented.shared().position(|name| name == CHANGE).ok_or(EstimateError::NoParameters)?;
    Ok((fit.fit.estimates[place], covariance[(place, place)].sqrt()))
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Two coefficients of one input that acts `delay` late, with white noise, and the regressions at any delay.
    fn regressions(seed: u64, delay: f64) -> impl FnMut(f64) -> Result<Vec<PooledRegression>, EstimateError> {
        let input = |t: f64| (1.3 * t).sin() + 0.5 * (3.1 * t).cos();
        let time: Vec<f64> = (0..400).map(|k| 0.02 * f64::from(k)).collect();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || -> f64 { 0.05 * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
        let z: Vec<Vec<f64>> = [(2.0, 0.3), (-1.0, 0.1)]
            .map(|(slope, constant)| time.iter().map(|t| constant + slope * input(t - delay) + noise()).collect())
            .into();
        move |value| {
            let x =
                DMatrix::from_fn(time.len(), 2, |row, column| if column == 0 { 1.0 } else { input(time[row] - value) });
            let regression = |z: &Vec<f64>| PooledRegression {
                names: vec!["constant".to_owned(), "slope".to_owned()],
                per_window: vec![true, false],
                constraints: Vec::new(),
                windows: vec![PooledWindow { label: "w".to_owned(), x: x.clone(), z: z.clone() }],
            };
            Ok(z.iter().map(regression).collect())
        }
    }

    #[test]
    fn delay_common_to_two_coefficients_is_found_within_its_error() {
        let (mut squares, mut single) = (0.0, 0.0);
        for seed in 0..60 {
            let found = search_nonlinear(0.0, 0.2, regressions(seed, 0.08)).unwrap();
            squares += ((found.value - 0.08) / found.standard_error).powi(2);
            for (value, error) in &found.by_regression {
                single += ((value - 0.08) / error).powi(2);
            }
            assert!(found.standard_error < 0.003, "{}", found.standard_error);
            assert!(found.profile.iter().all(|(_, cost)| *cost >= 0.0) && found.fits.len() == 2);
        }
        // Means of 60 and of 120 squared normalised errors: 1 +- 0.55 and 1 +- 0.39 (three standard deviations), larger by the
        // few per cent a coloured error is too small for white residuals.
        assert!((0.45..1.65).contains(&(squares / 60.0)), "{}", squares / 60.0);
        assert!((0.6..1.5).contains(&(single / 120.0)), "{}", single / 120.0);
    }

    #[test]
    fn regressions_agree_when_one_delay_is_theirs_and_disagree_when_it_is_not() {
        let mut refused = 0;
        for seed in 0..300 {
            let found = search_nonlinear(0.0, 0.2, regressions(seed, 0.08)).unwrap();
            refused += usize::from(found.agreement() < 0.05);
        }
        // 300 at 5 %: 15 +- 11 (three standard deviations), more by the few per cent a coloured error is too small.
        assert!((4..32).contains(&refused), "{refused} of 300");
        // The second regression's input acts 60 ms later than the first's.
        let (mut first, mut second) = (regressions(1, 0.05), regressions(1, 0.11));
        let apart = |value| Ok::<_, EstimateError>(vec![first(value)?.remove(0), second(value)?.remove(1)]);
        let found = search_nonlinear(0.0, 0.2, apart).unwrap();
        assert!(found.agreement() < 1e-6, "{:?}", found.by_regression);
    }

    #[test]
    fn value_at_the_end_of_the_range_has_no_error() {
        let found = search_nonlinear(0.0, 0.05, regressions(1, 0.12)).unwrap();
        assert_eq!((found.value, found.standard_error), (0.05, f64::INFINITY));
        assert!(found.by_regression.iter().all(|(value, _)| *value > 0.05), "both want more");
        assert!(search_nonlinear(0.1, 0.0, regressions(1, 0.1)).is_err());
    }
}
