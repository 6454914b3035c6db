//! Manoeuvres that a model does not describe while it describes the others: another configuration, contact with the ground, a stall.

use doublet_core::estimate::{Constraint, PooledFit, PooledRegression, PooledWindow};
use doublet_core::statistics::{median, squares_about_mean};

/// Root mean square residual of a manoeuvre over the median of all, from which the model does not describe it.
pub(in crate::verdict) const OUTLYING_RATIO: f64 = 4.0;
/// Root mean square residual of a manoeuvre over the standard deviation of its coefficient, from which the model does not describe it: large
/// inputs leave larger residuals than small ones, of the same part.
pub(in crate::verdict) const UNDESCRIBED: f64 = 0.3;
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

/// Manoeuvres whose residual is many times that of most and a large part of their motion, the largest first. Each manoeuvre is weighted by its own residual, `min sum_w n_w
/// ln(s_w)` with its root mean square `s_w`: the maximum likelihood for noise that differs from one to the other, by repeated weights
/// `1 / s_w`. They start from the estimate of a single manoeuvre, or of all, that leaves the least median residual. Priors are left out.
/// `reduced` is the regression with the manoeuvres reduced to their triangles.
pub(super) fn find_outlying(
    pooled: &PooledRegression,
    mut reduced: PooledRegression,
    fit: &PooledFit,
) -> Vec<Outlying> {
    if pooled.windows.len() < FEWEST {
        return Vec::new();
    }
    let counts = pooled.windows.iter().map(|window| window.z.len().max(1) as f64).collect();
    reduced
        .constraints
        .iter_mut()
        .filter(|one| matches!(one, Constraint::Prior { .. }))
        .for_each(|one| *one = Constraint::Free);
    let search = Search { reduced, counts };
    let sizes = search.weigh(&measure_residuals(fit, &search.counts)).unwrap_or_default();
    let ratios = ratios(&sizes).unwrap_or_default();
    let is_undescribed = |size: f64, window: &PooledWindow| {
        size > UNDESCRIBED * (squares_about_mean(&window.z) / window.z.len() as f64).sqrt()
    };
    let found = sizes.iter().zip(ratios).zip(&pooled.windows);
    let found = found.filter(|((size, ratio), window)| *ratio > OUTLYING_RATIO && is_undescribed(**size, window));
    let mut found: Vec<Outlying> =
        found.map(|((_, ratio), window)| Outlying { name: window.label.clone(), ratio }).collect();
    found.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    found
}

/// A regression whose manoeuvres are reduced to their triangles, which have their sums of squared residuals, and their numbers of samples.
struct Search {
    reduced: PooledRegression,
    counts: Vec<f64>,
}

impl Search {
    /// Residuals of the weighted fit; none where the ordinary fit, with the residuals `ordinary`, is even or no fit succeeds.
    fn weigh(&self, ordinary: &[f64]) -> Option<Vec<f64>> {
        if self.is_even(ordinary) {
            return None;
        }
        let middle = |sizes: &Vec<f64>| median(&mut sizes.clone()).unwrap_or(f64::INFINITY);
        let alone = (0..self.counts.len()).step_by(self.counts.len().div_ceil(STARTS));
        let starts = alone.filter_map(|index| self.measure_by_estimate_of(index)).chain([ordinary.to_vec()]);
        let mut sizes = starts.min_by(|a, b| middle(a).total_cmp(&middle(b)))?;
        for _ in 0..PASSES {
            let scales: Vec<f64> = ratios(&sizes)?.iter().map(|ratio| ratio.max(LEAST)).collect();
            let weighted = divide(&self.reduced, &scales).fit().ok()?;
            sizes = measure_residuals(&weighted, &self.counts);
            sizes.iter_mut().zip(scales).for_each(|(size, scale)| *size *= scale);
        }
        Some(sizes)
    }

    /// Whether the ordinary fit describes every manoeuvre about as well as most, and as well as its own fit does.
    fn is_even(&self, ordinary: &[f64]) -> bool {
        let is_near_own = |(index, size): (usize, &f64)| {
            let own = self.fit_alone(index).map(|own| measure_residuals(&own, &self.counts[index..=index])[0]);
            own.is_none_or(|own| *size < UNEVEN * own)
        };
        ratios(ordinary).is_none_or(|ratios| ratios.iter().all(|ratio| *ratio < UNEVEN))
            && ordinary.iter().enumerate().all(is_near_own)
    }

    /// The fit of one manoeuvre; none where that does not determine the derivatives.
    fn fit_alone(&self, index: usize) -> Option<PooledFit> {
        let PooledRegression { names, per_window, constraints, windows } = &self.reduced;
        let (names, per_window, constraints) = (names.clone(), per_window.clone(), constraints.clone());
        PooledRegression { names, per_window, constraints, windows: vec![windows[index].clone()] }.fit().ok()
    }

    /// Residuals of all manoeuvres, each with its own parameters fitted, by the estimates that one of them gives alone.
    fn measure_by_estimate_of(&self, index: usize) -> Option<Vec<f64>> {
        let own = self.fit_alone(index)?;
        let constraint = |(term, per_window): (usize, &bool)| match per_window {
            true => Constraint::Free,
            false => Constraint::Fixed(own.fit.estimates[own.parameters[0][term]]),
        };
        let constraints = self.reduced.per_window.iter().enumerate().map(constraint).collect();
        let fit = PooledRegression { constraints, ..self.reduced.clone() }.fit().ok()?;
        Some(measure_residuals(&fit, &self.counts))
    }
}

/// Root mean square residual of every manoeuvre, by their numbers of samples.
fn measure_residuals(fit: &PooledFit, counts: &[f64]) -> Vec<f64> {
    let size = |(samples, count): (&std::ops::Range<usize>, &f64)| {
        let squares: f64 = fit.fit.residuals[samples.clone()].iter().map(|residual| residual * residual).sum();
        (squares / count).sqrt()
    };
    fit.samples.iter().zip(counts).map(size).collect()
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

    /// Manoeuvres of the same regressor with an amplitude of one, each with a slope of its own, and noise of one per cent.
    fn regression(slopes: &[f64]) -> PooledRegression {
        regression_of(&slopes.iter().map(|slope| (*slope, 1.0)).collect::<Vec<_>>())
    }

    /// Manoeuvres of the same regressor, each with a slope and an amplitude, and noise of one per cent.
    fn regression_of(manoeuvres: &[(f64, f64)]) -> PooledRegression {
        let windows = manoeuvres.iter().enumerate().map(|(index, (slope, amplitude))| {
            let input = |k: usize| amplitude * (0.1 * k as f64).sin();
            let x = DMatrix::from_fn(200, 2, |k, column| if column == 0 { 1.0 } else { input(k) });
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
        find_outlying(&pooled, pooled.reduce().unwrap(), &pooled.fit().unwrap())
            .into_iter()
            .map(|found| found.name)
            .collect()
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
    #[test]
    fn a_large_input_whose_residual_is_a_small_part_of_its_motion_is_described() {
        let small = (1.0, 0.2);
        let found = |slope| {
            let pooled = regression_of(&[small, small, small, (slope, 2.0), small]);
            find_outlying(&pooled, pooled.reduce().unwrap(), &pooled.fit().unwrap()).len()
        };
        assert_eq!([found(1.1), found(2.0)], [0, 1], "residuals of a tenth and of half the motion");
    }

    #[test]
    fn reduced_manoeuvres_leave_the_residuals_of_all_samples() {
        let pooled = regression(&[1.0, 1.2, 0.9, 1.1]);
        let (whole, reduced) = (pooled.fit().unwrap(), pooled.reduce().unwrap().fit().unwrap());
        let counts = vec![200.0; 4];
        for (index, estimate) in whole.fit.estimates.iter().enumerate() {
            assert!((estimate - reduced.fit.estimates[index]).abs() < 1e-12);
        }
        for (a, b) in measure_residuals(&whole, &counts).iter().zip(measure_residuals(&reduced, &counts)) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    /// Manoeuvres timed, their samples and terms, and repetitions.
    const TIMED: [usize; 3] = [22, 671, 6];
    const ROUNDS: usize = 200;

    /// Manoeuvres of several regressors, every seventh with other slopes where `is_uneven`.
    fn large(is_uneven: bool) -> PooledRegression {
        let [count, samples, terms] = TIMED;
        let windows = (0..count).map(|index| {
            let wave = |k: usize, term: usize| (0.01 * ((1 + 3 * term) * k + 17 * index) as f64).sin();
            let x = DMatrix::from_fn(samples, terms, |k, term| if term == 0 { 1.0 } else { wave(k, term) });
            let slope = if is_uneven && index % 7 == 3 { 3.0 } else { 1.0 };
            let noise = |k: usize| 0.01 * (12.9898 * (k + 211 * index) as f64).sin();
            let z = (0..samples).map(|k| slope * x.row(k).sum() + noise(k)).collect();
            PooledWindow { label: format!("{index}"), x, z }
        });
        PooledRegression {
            names: (0..terms).map(|term| format!("term {term}")).collect(),
            per_window: (0..terms).map(|term| term == 0).collect(),
            constraints: Vec::new(),
            windows: windows.collect(),
        }
    }

    #[test]
    #[ignore = "measures time: run alone"]
    fn time_of_the_search_for_outlying_manoeuvres() {
        for is_uneven in [false, true] {
            let pooled = large(is_uneven);
            let fit = pooled.fit().unwrap();
            let least_ms = |work: &dyn Fn()| {
                let time = |_| {
                    let start = std::time::Instant::now();
                    work();
                    1e3 * start.elapsed().as_secs_f64()
                };
                (0..ROUNDS).map(time).fold(f64::INFINITY, f64::min)
            };
            let reduced = pooled.reduce().unwrap();
            let reduce = least_ms(&|| drop(std::hint::black_box(pooled.reduce())));
            let search = least_ms(&|| drop(std::hint::black_box(find_outlying(&pooled, reduced.clone(), &fit))));
            println!("uneven {is_uneven}: {reduce:.3} ms to triangles, {search:.3} ms to search, one coefficient");
            assert_eq!(find_outlying(&pooled, reduced, &fit).len(), if is_uneven { 3 } else { 0 });
        }
    }
}
