//! Derivatives of two runs with the significance of their difference.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::report::{FORMAT, Results, VERSION};
use crate::snapshot::Interval;

/// What two runs are compared by: the pooled estimates of one.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Estimates {
    format: String,
    version: u32,
    #[serde(default)]
    pub title: String,
    #[serde(default)]
    pooled: Vec<Fit>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Fit {
    coefficient: String,
    #[serde(default)]
    derivatives: Vec<Estimate>,
}

/// A number that does not exist is `null`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Estimate {
    name: String,
    estimate: Option<f64>,
    corrected_standard_error: Option<f64>,
}

/// One derivative in two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DerivativeDifference {
    pub coefficient: String,
    /// Derivative.
    pub name: String,
    /// In the first run; `None` where it has none.
    pub first: Option<Interval>,
    /// In the second run; `None` where it has none.
    pub second: Option<Interval>,
    /// Second less first over the root of the sum of the squared standard errors. It takes the two as independent: of runs that
    /// share data the difference has a smaller error than that, so a `z` beyond a limit is beyond it all the more, and one
    /// within it proves nothing.
    pub z: Option<f64>,
    /// Probability of a `z` at least as far from zero without a difference, for normal errors.
    pub p: Option<f64>,
}

/// The estimates of results just computed.
pub fn estimates_of(results: &Results) -> Result<Estimates, String> {
    let value = serde_json::to_value(results).map_err(|error| error.to_string())?;
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// The estimates of a run: `results.json`, or the folder it is in.
pub fn read_estimates(path: &Path) -> Result<Estimates, String> {
    let path = if path.is_dir() { path.join("results.json") } else { path.to_path_buf() };
    let place = path.display();
    let text = doublet_core::load::read_text(&path).map_err(|error| format!("{place}: {error}"))?;
    let found: Estimates = serde_json::from_str(&text).map_err(|error| format!("{place}: {error}"))?;
    if found.format != FORMAT || found.version > VERSION {
        return Err(format!("{place}: '{}' version {} is not understood", found.format, found.version));
    }
    Ok(found)
}

impl Estimates {
    /// Every derivative of the pooled estimate, in its order: `(coefficient, name, interval)`. Constants of single windows are
    /// trim and left out.
    pub fn derivatives(&self) -> impl Iterator<Item = (&str, &str, Interval)> {
        self.pooled.iter().flat_map(|fit| {
            let shared = fit.derivatives.iter().filter(|row| !row.name.ends_with(']'));
            shared.filter_map(|row| {
                let (estimate, standard_error) = (row.estimate?, row.corrected_standard_error.unwrap_or(f64::NAN));
                let interval = Interval::new(estimate, standard_error);
                Some((fit.coefficient.as_str(), row.name.as_str(), interval))
            })
        })
    }
}

/// Every derivative either run has: those of the first in its order, then those only the second has.
pub fn differences(first: &Estimates, second: &Estimates) -> Vec<DerivativeDifference> {
    let find = |run: &Estimates, coefficient: &str, name: &str| {
        run.derivatives().find(|(c, n, _)| (*c, *n) == (coefficient, name)).map(|(_, _, interval)| interval)
    };
    let mut rows: Vec<_> = first
        .derivatives()
        .map(|(c, name, interval)| difference(c, name, Some(interval), find(second, c, name)))
        .collect();
    let only_second = second.derivatives().filter(|(c, name, _)| find(first, c, name).is_none());
    rows.extend(only_second.map(|(c, name, interval)| difference(c, name, None, Some(interval))));
    rows
}

fn difference(
    coefficient: &str,
    name: &str,
    first: Option<Interval>,
    second: Option<Interval>,
) -> DerivativeDifference {
    let z = first.zip(second).map(|(a, b)| (b.estimate - a.estimate) / a.standard_error.hypot(b.standard_error));
    let z = z.filter(|z| z.is_finite());
    let p = z.map(|z| libm::erfc(z.abs() / std::f64::consts::SQRT_2));
    DerivativeDifference { coefficient: coefficient.to_owned(), name: name.to_owned(), first, second, z, p }
}
