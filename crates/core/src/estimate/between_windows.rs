//! Errors of a pooled estimate from the scatter between its windows.

use nalgebra::{DMatrix, DVector};

use super::{EstimateError, PooledFit, PooledWindow};
use crate::statistics::NORMAL_95;

/// Fewest windows whose scatter is used: with two the quantile of Student's distribution is 6.5 times that of the normal one.
const FEWEST_WINDOWS: usize = 3;

impl PooledFit {
    /// Standard errors by the scatter between windows, one per parameter; `None` with fewer than three windows. Zero for what is held
    /// and for the windows' own parameters.
    ///
    /// With `X~` the shared regressors of window `w` less what its own regressors explain of them, and `v` its residuals,
    /// `V = G / (G - 1) A^-1 (sum_w s_w s_w') A^-1`, `A = sum_w X~_w' X~_w + W`, `s_w = X~_w' v_w`, with `W` the information of priors
    /// (cluster-robust covariance: Liang and Zeger, Biometrika 73(1), 1986; Cameron and Miller, J. Human Resources 50(2), 2015, 2 and
    /// 6). It holds whatever a window has in common with itself, as a model that fits no manoeuvre exactly, which the autocorrelation
    /// of the residuals inside windows does not show. With few windows such a deviation follows Student's distribution with `G - 1`
    /// degrees of freedom: it is multiplied by the ratio of its 95 % quantile to the normal one, so that 1.96 of it are that interval.
    ///
    /// `windows` are those fitted.
    pub fn errors_between_windows(&self, windows: &[PooledWindow]) -> Option<Vec<f64>> {
        let count = windows.len();
        if count < FEWEST_WINDOWS || count != self.samples.len() {
            return None;
        }
        let times_used = |parameter: usize| self.parameters.iter().filter(|own| own.contains(&parameter)).count();
        let all = self.fit.names.len();
        let shared: Vec<usize> =
            (0..all).filter(|&index| self.fit.origins[index].is_estimated() && times_used(index) > 1).collect();
        let size = shared.len();
        let mut information = DMatrix::zeros(size, size);
        for (place, &parameter) in shared.iter().enumerate() {
            information[(place, place)] += self.prior_information.get(parameter).copied().unwrap_or(0.0);
        }
        let mut scores = Vec::with_capacity(count);
        for ((window, columns), samples) in windows.iter().zip(&self.parameters).zip(&self.samples) {
            let residuals = DVector::from_column_slice(&self.fit.residuals[samples.clone()]);
            let (score, own) =
                score_of(window, columns, &shared, &residuals, |at| self.fit.origins[at].is_estimated())?;
            information += own;
            scores.push(score);
        }
        let factor = information.cholesky()?;
        let variance = scores.iter().fold(DVector::zeros(size), |sum, score| {
            let moved = factor.solve(score);
            sum + moved.component_mul(&moved)
        });
        let windows = count as f64;
        let scale = (windows / (windows - 1.0)).sqrt() * student_quantile(windows - 1.0) / NORMAL_95;
        let mut errors = vec![0.0; all];
        for (&parameter, variance) in shared.iter().zip(variance.iter()) {
            errors[parameter] = scale * variance.sqrt();
        }
        Some(errors)
    }
}

/// Mean square of the scatter between windows over the variance of the estimates where the noise is white, one per parameter; one where it is
/// not used: with fewer than three windows, and for the windows' own parameters.
///
/// The estimate leaves the scores `s_w = z_w - A_w A^-1 sum_v z_v` of noise with `cov z_w = A_w`, and `A = sum_w A_w + W` with the `prior`
/// information `W`, so `cov s_w = A_w - 2 A_w A^-1 A_w + A_w A^-1 (A - W) A^-1 A_w`. Where all windows have the same information the share is
/// one; where one window has most of it, that window's score is nearly zero and the scatter is too small (Bell and McCaffrey 2002).
pub(super) fn expected_between_windows(
    windows: &[PooledWindow],
    parameters: &[Vec<usize>],
    prior: &[f64],
) -> Result<Vec<f64>, EstimateError> {
    let mut shares = vec![1.0; prior.len()];
    let count = windows.len();
    if count < FEWEST_WINDOWS {
        return Ok(shares);
    }
    let times_used = |parameter: usize| parameters.iter().filter(|own| own.contains(&parameter)).count();
    let shared: Vec<usize> = (0..prior.len()).filter(|&index| times_used(index) > 1).collect();
    let refused = || EstimateError::Setting {
        setting: "constants of a manoeuvre".to_owned(),
        value: f64::NAN,
        allowed: "linearly independent",
    };
    let one = |(window, columns): (&PooledWindow, &Vec<usize>)| {
        let own = score_of(window, columns, &shared, &DVector::zeros(window.x.nrows()), |_| true);
        own.map(|(_, information)| information).ok_or_else(refused)
    };
    let own: Vec<DMatrix<f64>> = windows.iter().zip(parameters).map(one).collect::<Result<_, _>>()?;
    let measured = own.iter().fold(DMatrix::zeros(shared.len(), shared.len()), |sum, own| sum + own);
    let prior = DMatrix::from_diagonal(&DVector::from_iterator(shared.len(), shared.iter().map(|&index| prior[index])));
    let covariance = (&measured + prior).cholesky().ok_or_else(refused)?.inverse();
    let spread = &covariance * measured * &covariance;
    let left = own.iter().fold(DMatrix::zeros(shared.len(), shared.len()), |sum, own| {
        sum + own - own * &covariance * own * 2.0 + own * &spread * own
    });
    let scatter = &covariance * left * &covariance;
    let groups = count as f64 / (count as f64 - 1.0);
    for (place, &parameter) in shared.iter().enumerate() {
        shares[parameter] = (groups * scatter[(place, place)] / covariance[(place, place)]).max(0.0);
    }
    Ok(shares)
}

/// `X~' v` and `X~' X~` of one window over the parameters `shared`; `None` where its own regressors depend on each other.
fn score_of(
    window: &PooledWindow,
    columns: &[usize],
    shared: &[usize],
    residuals: &DVector<f64>,
    is_estimated: impl Fn(usize) -> bool,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let place = |parameter: &usize| shared.iter().position(|other| other == parameter);
    let columns_where =
        |keep: &dyn Fn(&usize) -> bool| -> Vec<usize> { (0..columns.len()).filter(|c| keep(&columns[*c])).collect() };
    let common = columns_where(&|parameter| place(parameter).is_some());
    let own = columns_where(&|parameter| place(parameter).is_none() && is_estimated(*parameter));
    let mut x = window.x.select_columns(&common);
    if !own.is_empty() {
        let own = window.x.select_columns(&own);
        let explained = own.tr_mul(&own).cholesky()?.solve(&own.tr_mul(&x));
        x -= own * explained;
    }
    let mut score = DVector::zeros(shared.len());
    let mut information = DMatrix::zeros(shared.len(), shared.len());
    let (own_score, own_information) = (x.tr_mul(residuals), x.tr_mul(&x));
    let places: Vec<usize> = common.iter().filter_map(|&column| place(&columns[column])).collect();
    for (i, &row) in places.iter().enumerate() {
        score[row] = own_score[i];
        for (j, &column) in places.iter().enumerate() {
            information[(row, column)] = own_information[(i, j)];
        }
    }
    Some((score, information))
}

/// Two-sided 95 % quantile of Student's distribution by its expansion in `1 / freedom` (Abramowitz and Stegun 26.7.5): 3 % short with two
/// degrees of freedom, 0.7 % with three.
fn student_quantile(freedom: f64) -> f64 {
    let z = NORMAL_95;
    let square = z * z;
    let first = z * (square + 1.0) / 4.0;
    let second = z * ((5.0 * square + 16.0) * square + 3.0) / 96.0;
    let third = z * (((3.0 * square + 19.0) * square + 17.0) * square - 15.0) / 384.0;
    z + (first + (second + third / freedom) / freedom) / freedom
}

#[cfg(test)]
mod tests {
    use super::super::pooled;
    use super::*;

    #[test]
    fn student_quantile_matches_its_table() {
        // Abramowitz and Stegun, table 26.10, 0.95.
        for (freedom, expected, relative) in
            [(2.0, 4.303, 0.035), (3.0, 3.182, 0.01), (5.0, 2.571, 2e-3), (30.0, 2.042, 1e-3)]
        {
            approx::assert_relative_eq!(student_quantile(freedom), expected, max_relative = relative);
        }
    }

    #[test]
    fn errors_between_windows_are_the_scatter_of_slopes_that_differ() {
        // Windows of the same regressor, each with a slope of its own: the pooled slope is their mean, its error their scatter.
        let slopes = [0.9, 1.2, 1.1, 0.7, 1.3, 0.8];
        let count = slopes.len() as f64;
        let windows: Vec<PooledWindow> =
            slopes.iter().enumerate().map(|(index, slope)| window(index, *slope)).collect();
        let names = ["constant".to_owned(), "slope".to_owned()];
        let fit = pooled(&names, &[true, false], &windows).unwrap();
        let errors = fit.errors_between_windows(&windows).unwrap();
        let mean = slopes.iter().sum::<f64>() / count;
        let variance = slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() / (count - 1.0) / count;
        let expected = variance.sqrt() * student_quantile(count - 1.0) / NORMAL_95;
        approx::assert_relative_eq!(errors[0], expected, max_relative = 1e-9);
        assert_eq!(&errors[1..], &[0.0; 6]);
        assert!(fit.errors_between_windows(&windows[..2]).is_none());
    }

    #[test]
    fn scatter_to_expect_is_that_of_many_draws_also_where_one_window_has_most() {
        use rand::{RngExt, SeedableRng};
        use rand_distr::StandardNormal;
        const DRAWS: usize = 4000;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let names = ["constant".to_owned(), "slope".to_owned()];
        for amplitudes in [[1.0, 1.0, 1.0, 1.0], [1.0, 0.3, 0.3, 0.2]] {
            let mut windows: Vec<PooledWindow> = (0..4).map(|index| window(index, 0.0)).collect();
            for (window, amplitude) in windows.iter_mut().zip(amplitudes) {
                window.x.column_mut(1).scale_mut(amplitude);
            }
            let fit = pooled(&names, &[true, false], &windows).unwrap();
            let share = expected_between_windows(&windows, &fit.parameters, &[0.0; 5]).unwrap()[0];
            let (mut scatter, variance) = (0.0, fit.fit.unit_covariance[(0, 0)]);
            for _ in 0..DRAWS {
                windows.iter_mut().flat_map(|window| &mut window.z).for_each(|z| *z = rng.sample(StandardNormal));
                let fit = pooled(&names, &[true, false], &windows).unwrap();
                scatter += fit.errors_between_windows(&windows).unwrap()[0].powi(2) / DRAWS as f64;
            }
            let drawn = scatter / variance / (student_quantile(3.0) / NORMAL_95).powi(2);
            approx::assert_relative_eq!(share, drawn, max_relative = 0.06);
            assert!((share < 0.5) == (amplitudes[1] < 1.0), "{share}");
        }
    }

    fn window(index: usize, slope: f64) -> PooledWindow {
        let x = DMatrix::from_fn(50, 2, |k, column| if column == 0 { 1.0 } else { (0.2 * k as f64).sin() });
        let z = x.column(1).iter().map(|x| 3.0 + slope * x).collect();
        PooledWindow { label: format!("{index}"), x, z }
    }
}
