//! Manoeuvres that a model does not describe while it describes the others: another configuration, contact with the ground, a stall.

use doublet_core::estimate::{Constraint, PooledFit, PooledRegression};
use doublet_core::statistics::median;

/// Root mean square residual of a manoeuvre over the median of all, from which the model does not describe it.
pub(in crate::verdict) const OUTLYING_RATIO: f64 = 4.0;
/// Root mean square residual of a manoeuvre in the ordinary fit, over the median or over that of its own fit, from which such manoeuvres are
/// looked for: one of them raises the residual of all.
const UNEVEN: f64 = 2.0;
/// Least deviation of a manoeuvre by which it is weighted, as a part of the median: one that fits by chance shall not decide alone.
const LEAST: f64 = 0.5;
/// Most manoeuvres whose own estimates the weights start from: most manoeuvres are sound.
const STARTS: usize = 8;
/// Passes of the weights.
const PASSES: usize = 8;
/// Fewest manoeuvres of which one can differ from most.
const FEWEST: usize = 4;

/// A manoeuvre that the model of a coefficient does not describe.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::verdict) struct Outlying {
    /// Its name.
    pub(in crate::verdict) name: String,
    /// Root mean square of its residual over the median of all manoeuvres.
    pub(in crate::verdict) ratio: f64,
}

/// Manoeuvres whose residual is many times that of most, the largest first. Each manoeuvre is weighted by its own residual, `min sum_w n_w
/// ln(s_w)` with its root mean square `s_w`: the maximum likelihood for noise that differs from one to the other, by repeated weights
/// `1 / s_w`. They start from the estimate of a single manoeuvre, or of all, that leaves the least median residual.
pub(super) fn find_outlying(pooled: &PooledRegression, fit: &PooledFit) -> Vec<Outlying> {
    let ordinary = measure_residuals(fit, &vec![1.0; pooled.windows.len()]);
    if ordinary.len() < FEWEST || is_even(pooled, &ordinary) {
        return Vec::new();
    }
    let middle = |sizes: &Vec<f64>| median(&mut sizes.clone()).unwrap_or(f64::INFINITY);
    let alone = (0..pooled.windows.len()).step_by(pooled.windows.len().div_ceil(STARTS));
    let starts = alone.filter_map(|index| measure_by_estimate_of(pooled, index)).chain([ordinary]);
    let Some(mut sizes) = starts.min_by(|a, b| middle(a).total_cmp(&middle(b))) else { return Vec::new() };
    for _ in 0..PASSES {
        let Some(ratios) = ratios(&sizes) else { return Vec::new() };
        let scales: Vec<f64> = ratios.iter().map(|ratio| ratio.max(LEAST)).collect();
        let Ok(weighted) = divide(pooled, &scales).fit() else { return Vec::new() };
        sizes = measure_residuals(&weighted, &scales);
    }
    let found = ratios(&sizes).into_iter().flatten().zip(&pooled.windows);
    let found = found.filter(|(ratio, _)| *ratio > OUTLYING_RATIO);
    let mut found: Vec<Outlying> =
        found.map(|(ratio, window)| Outlying { name: window.label.clone(), ratio }).collect();
    found.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    found
}

/// Whether the ordinary fit describes every manoeuvre about as well as most, and as well as its own fit does.
fn is_even(pooled: &PooledRegression, ordinary: &[f64]) -> bool {
    let is_near_own = |(index, size): (usize, &f64)| {
        fit_alone(pooled, index).is_none_or(|own| *size < UNEVEN * measure_residuals(&own, &[1.0])[0])
    };
    ratios(ordinary).is_none_or(|ratios| ratios.iter().all(|ratio| *ratio < UNEVEN))
        && ordinary.iter().enumerate().all(is_near_own)
}

/// The fit of one manoeuvre; none where that does not determine the derivatives.
fn fit_alone(pooled: &PooledRegression, index: usize) -> Option<PooledFit> {
    let windows = vec![pooled.windows[index].clone()];
    let (names, per_window) = (pooled.names.clone(), pooled.per_window.clone());
    PooledRegression { names, per_window, constraints: pooled.constraints.clone(), windows }.fit().ok()
}

/// Residuals of all manoeuvres, each with its own parameters fitted, by the estimates that one of them gives alone.
fn measure_by_estimate_of(pooled: &PooledRegression, index: usize) -> Option<Vec<f64>> {
    let own = fit_alone(pooled, index)?;
    let constraint = |(term, per_window): (usize, &bool)| match per_window {
        true => Constraint::Free,
        false => Constraint::Fixed(own.fit.estimates[own.parameters[0][term]]),
    };
    let constraints = pooled.per_window.iter().enumerate().map(constraint).collect();
    let fit = PooledRegression { constraints, ..pooled.clone() }.fit().ok()?;
    Some(measure_residuals(&fit, &vec![1.0; pooled.windows.len()]))
}

/// Root mean square residual of every manoeuvre of a fit whose samples were divided by `scales`.
fn measure_residuals(fit: &PooledFit, scales: &[f64]) -> Vec<f64> {
    let size = |samples: &std::ops::Range<usize>| {
        let squares: f64 = fit.fit.residuals[samples.clone()].iter().map(|residual| residual * residual).sum();
        (squares / samples.len().max(1) as f64).sqrt()
    };
    fit.samples.iter().zip(scales).map(|(samples, scale)| scale * size(samples)).collect()
}

/// Sizes over their median; none where that is nothing.
fn ratios(sizes: &[f64]) -> Option<Vec<f64>> {
    let middle = median(&mut sizes.to_vec()).filter(|middle| *middle > 0.0)?;
    Some(sizes.iter().map(|size| size / middle).collect())
}

/// The regression with the samples of every manoeuvre divided by its scale.
fn divide(pooled: &PooledRegression, scales: &[f64]) -> PooledRegression {
    let mut divided = pooled.clone();
    for (window, scale) in divided.windows.iter_mut().zip(scales) {
        window.x /= *scale;
        window.z.iter_mut().for_each(|value| *value /= scale);
    }
    divided
}

#[cfg(test)]
mod tests {
    use doublet_core::estimate::PooledWindow;
    use nalgebra::DMatrix;

    use super::*;

    /// Manoeuvres of the same regressor, each with a slope of its own, and noise of one per cent.
    fn regression(slopes: &[f64]) -> PooledRegression {
        let windows = slopes.iter().enumerate().map(|(index, slope)| {
            let x = DMatrix::from_fn(200, 2, |k, column| if column == 0 { 1.0 } else { (0.1 * k as f64).sin() });
            let noise = |k: usize| 0.01 * (12.9898 * (k + 211 * index) as f64).sin();
            let z = x.column(1).iter().enumerate().map(|(k, x)| slope * x + noise(k)).collect();
            PooledWindow { label: format!("{index}"), x, z }
        });
        PooledRegression {
            names: vec!["constant".to_owned(), "slope".to_owned()],
            per_window: vec![true, false],
            constraints: Vec::new(),
            windows: windows.collect(),
        }
    }

    fn find(slopes: &[f64]) -> Vec<String> {
        let pooled = regression(slopes);
        find_outlying(&pooled, &pooled.fit().unwrap()).into_iter().map(|found| found.name).collect()
    }

    #[test]
    fn manoeuvres_of_another_slope_are_found_even_where_they_pull_the_fit_of_all() {
        assert_eq!(find(&[1.0, 1.0, 2.0, 1.0, 1.0]), ["2"]);
        assert_eq!(find(&[1.0, 3.0, 2.0, 1.0, 1.0, 1.0, 1.0, 4.0]), ["7", "1", "2"]);
        assert_eq!(
            find(&[1.0, 2.0, 2.0, 1.0, 2.0, 1.0, 1.0]).len(),
            3,
            "which share the residual of the ordinary fit evenly"
        );
    }

    #[test]
    fn slopes_that_differ_by_their_noise_and_few_manoeuvres_show_none() {
        assert!(find(&[1.0, 1.01, 0.99, 1.005, 1.0]).is_empty());
        assert!(find(&[1.0, 2.0]).is_empty());
        assert!(find(&[1.0, 1.3, 1.6, 1.9, 2.2]).is_empty(), "slopes all over the place have no majority");
    }
}
