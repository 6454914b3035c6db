//! Choice of terms by orthogonal functions.

use nalgebra::DMatrix;

use super::diagnostics::contributions;
use super::least_squares::{check_values, least_squares};
use super::triangle::Triangle;
use super::{EstimateError, Fit};

/// When the search stops and which terms stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthogonalSettings {
    /// Largest plausible variance of the noise; `None` for the variance of the measurement.
    pub noise_variance_max: Option<f64>,
    /// Smallest contribution of an ordinary term, root mean square of the term over that of the measurement.
    pub min_contribution: f64,
}

impl Default for OrthogonalSettings {
    fn default() -> Self {
        Self { noise_variance_max: None, min_contribution: 0.005 }
    }
}

/// One orthogonal function of the search.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct OrthogonalRecord {
    /// The ordinary term it is the new part of.
    pub name: String,
    /// Its gain `(p'z)^2 / (p'p)` over the sum of squares of the measurement about its mean.
    pub gain: f64,
    pub r_squared: f64,
    pub predicted_squared_error: f64,
    /// False after the minimum of the predicted squared error, and for terms that contribute too little.
    pub kept: bool,
}

/// Chosen terms, their fit, and how they were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct OrthogonalSelection {
    /// Indices of the chosen candidates, in ascending order.
    pub selected: Vec<usize>,
    /// Fit by the chosen terms.
    pub fit: Fit,
    /// Orthogonal functions in the order of their gain, up to one past the minimum.
    pub log: Vec<OrthogonalRecord>,
}

/// Multivariate orthogonal-function modelling (Morelli, J. Aircraft 32(2), 1995; Klein and Morelli, 5.4.3).
///
/// Each candidate, less its projection on the terms already in the model, is an orthogonal function `p` with the gain
/// `(p'z)^2 / (p'p)`, independent of the others. The largest is added while the predicted squared error
/// `PSE = v'v / N + sigma2_max n / N` falls; ordinary terms that then contribute less than `min_contribution` are dropped.
/// `forced`: candidates always in the model, usually the constants.
///
/// # Errors
/// As for [`super::least_squares`]; candidates that depend on the model are passed over.
pub fn orthogonal(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    forced: &[usize],
    settings: &OrthogonalSettings,
) -> Result<OrthogonalSelection, EstimateError> {
    check_values(names, x, z)?;
    if let Some(&index) = forced.iter().find(|&&index| index >= names.len()) {
        return Err(EstimateError::Size { quantity: "forced term", expected: names.len(), found: index });
    }
    let triangle = Triangle::reduce(x, z);
    let samples = z.len() as f64;
    let mean = z.iter().sum::<f64>() / samples;
    let total: f64 = z.iter().map(|z| (z - mean).powi(2)).sum();
    let noise = settings.noise_variance_max.unwrap_or(total / samples);
    let error = |square: f64, terms: usize| square / samples + noise * terms as f64 / samples;

    let mut selected = forced.to_vec();
    let mut square = triangle.subset(&selected).residual_square();
    let mut log: Vec<OrthogonalRecord> = Vec::new();
    while let Some((index, after)) = largest_gain(&triangle, &selected, names) {
        let kept = error(after, selected.len() + 1) < error(square, selected.len());
        log.push(OrthogonalRecord {
            name: names[index].clone(),
            gain: (square - after) / total,
            r_squared: 1.0 - after / total,
            predicted_squared_error: error(after, selected.len() + 1),
            kept,
        });
        if !kept || selected.len() + 2 > z.len() {
            break;
        }
        selected.push(index);
        square = after;
    }
    selected.sort_unstable();
    let fit = drop_minor(names, x, z, forced, settings.min_contribution, &mut selected, &mut log)?;
    Ok(OrthogonalSelection { selected, fit, log })
}

/// The candidate whose orthogonal function has the largest gain, and the residual sum of squares with it.
fn largest_gain(triangle: &Triangle, selected: &[usize], names: &[String]) -> Option<(usize, f64)> {
    (0..names.len())
        .filter(|index| !selected.contains(index))
        .filter_map(|index| {
            let with: Vec<usize> = selected.iter().copied().chain(std::iter::once(index)).collect();
            let chosen: Vec<String> = with.iter().map(|&index| names[index].clone()).collect();
            let subset = triangle.subset(&with);
            subset.solve(&chosen).is_ok().then(|| (index, subset.residual_square()))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Drops ordinary terms that contribute too little, the least first, and fits the rest.
fn drop_minor(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    forced: &[usize],
    min_contribution: f64,
    selected: &mut Vec<usize>,
    log: &mut [OrthogonalRecord],
) -> Result<Fit, EstimateError> {
    loop {
        let chosen: Vec<String> = selected.iter().map(|&index| names[index].clone()).collect();
        let columns = x.select_columns(selected.iter());
        let fit = least_squares(&chosen, &columns, z)?;
        let least = selected
            .iter()
            .zip(contributions(&fit, &columns))
            .filter(|(index, contribution)| !forced.contains(index) && *contribution < min_contribution)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((&index, _)) = least else { return Ok(fit) };
        selected.retain(|&other| other != index);
        for record in log.iter_mut().filter(|record| record.name == names[index]) {
            record.kept = false;
        }
    }
}
