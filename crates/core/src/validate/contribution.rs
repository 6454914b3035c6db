//! What each term adds to a modelled coefficient.

use nalgebra::DMatrix;

/// Contribution of one term over one window (thesis Fig. 6.13).
#[derive(Clone, Debug, PartialEq)]
pub struct Contribution {
    /// Parameter times regressor at each sample.
    pub values: Vec<f64>,
    /// Root mean square of `values` about their mean over that of the measurement about its own: the share of the term in what
    /// varies. Shares do not sum to one where terms oppose each other; zero for a constant.
    pub share: f64,
}

/// Contribution of every term: columns of `x` times `estimates`, and their size beside that of the measurement `z`.
pub fn contributions(estimates: &[f64], x: &DMatrix<f64>, z: &[f64]) -> Vec<Contribution> {
    let whole = deviation(z);
    let contribution = |(column, estimate): (nalgebra::DVectorView<'_, f64>, &f64)| {
        let values: Vec<f64> = column.iter().map(|value| estimate * value).collect();
        Contribution { share: deviation(&values) / whole, values }
    };
    x.column_iter().zip(estimates).map(contribution).collect()
}

/// Root mean square about the mean.
fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_orthogonal_terms_are_the_sides_of_a_right_triangle() {
        let wave = |row: usize, turns: f64| (std::f64::consts::TAU * turns * row as f64 / 400.0).sin();
        let x = DMatrix::from_fn(400, 3, |row, column| [1.0, wave(row, 2.0), wave(row, 5.0)][column]);
        let estimates = [7.0, 3.0, -4.0];
        let z: Vec<f64> = x.row_iter().map(|row| row.iter().zip(estimates).map(|(a, b)| a * b).sum()).collect();
        let found = contributions(&estimates, &x, &z);
        for (contribution, share) in found.iter().zip([0.0, 0.6, 0.8]) {
            approx::assert_relative_eq!(contribution.share, share, epsilon = 1e-12);
        }
        for row in 0..400 {
            let sum: f64 = found.iter().map(|contribution| contribution.values[row]).sum();
            approx::assert_relative_eq!(sum, z[row], epsilon = 1e-12);
        }
    }
}
