//! One parameter over several fits, as the thesis reports manoeuvres.

use super::Fit;

/// A parameter over the fits that have it (thesis Tables 6.4 to 6.9).
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSummary {
    /// Name of the parameter.
    pub name: String,
    /// Number of fits that have it.
    pub fits: usize,
    /// Mean, smallest and largest estimate.
    pub estimate: [f64; 3],
    /// Mean, smallest and largest variance.
    pub variance: [f64; 3],
    /// Standard deviation of the estimates over the fits; NaN for one fit alone.
    pub scatter: f64,
}

/// Summary of every parameter, in the order of first appearance.
pub fn summarise(fits: &[&Fit]) -> Vec<ParameterSummary> {
    let mut names: Vec<&String> = Vec::new();
    for name in fits.iter().flat_map(|fit| &fit.names) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.into_iter().map(|name| summarise_parameter(fits, name)).collect()
}

fn summarise_parameter(fits: &[&Fit], name: &str) -> ParameterSummary {
    let found: Vec<(f64, f64)> = fits.iter().filter_map(|fit| fit.parameter(name)).collect();
    let estimates: Vec<f64> = found.iter().map(|(estimate, _)| *estimate).collect();
    let variances: Vec<f64> = found.iter().map(|(_, error)| error * error).collect();
    let estimate = mean_and_range(&estimates);
    let square: f64 = estimates.iter().map(|value| (value - estimate[0]).powi(2)).sum();
    let scatter = if found.len() > 1 { (square / (found.len() - 1) as f64).sqrt() } else { f64::NAN };
    ParameterSummary {
        name: name.to_owned(),
        fits: found.len(),
        estimate,
        variance: mean_and_range(&variances),
        scatter,
    }
}

/// Mean, smallest and largest of some values.
fn mean_and_range(values: &[f64]) -> [f64; 3] {
    [
        values.iter().sum::<f64>() / values.len() as f64,
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}
