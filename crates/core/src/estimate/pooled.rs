//! One set of parameters over several windows.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::DMatrix;

use super::constrained::solve_constrained;
use super::covariance::{Block, Coloured, Unit, coloured_covariances_of, only, with_transforms};
use super::least_squares::check_values;
use super::triangle::{Solution, Triangle};
use super::{Constraint, EstimateError, Fit};

/// One window of a pooled regression.
#[derive(Clone, Debug, PartialEq)]
pub struct PooledWindow {
    /// Name of the window, which its own parameters carry.
    pub label: String,
    /// Regressors, samples by terms.
    pub x: DMatrix<f64>,
    /// Measurement at each sample.
    pub z: Vec<f64>,
}

/// A regression over several windows, ready to be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct PooledRegression {
    /// Name of each term.
    pub names: Vec<String>,
    /// Whether each term has a parameter of its own in every window.
    pub per_window: Vec<bool>,
    /// What is known of each term beforehand, of each window's own parameter where it has one; empty where nothing is.
    pub constraints: Vec<Constraint>,
    /// Windows.
    pub windows: Vec<PooledWindow>,
}

impl PooledRegression {
    /// [`pooled`] over all its windows, under its constraints as [`super::constrained_least_squares`].
    pub fn fit(&self) -> Result<PooledFit, EstimateError> {
        if self.constraints.iter().all(|constraint| *constraint == Constraint::Free) {
            return pooled(&self.names, &self.per_window, &self.windows);
        }
        if self.constraints.len() != self.names.len() {
            let (expected, found) = (self.names.len(), self.constraints.len());
            return Err(EstimateError::Size { quantity: "constraints", expected, found });
        }
        let ((names, parameters), triangle) = triangles(&self.names, &self.per_window, &self.windows)?;
        let mut constraints = vec![Constraint::Free; names.len()];
        for columns in &parameters {
            for (&column, &constraint) in columns.iter().zip(&self.constraints) {
                constraints[column] = constraint;
            }
        }
        let measured = self.windows.iter().flat_map(|window| &window.z);
        let (samples, square) = measured.fold((0, 0.0), |(samples, square), z| (samples + 1, square + z * z));
        let found = solve_constrained(&names, triangle, (samples, square), &constraints)?;
        let (fitted, z, samples) = fitted(&self.windows, &parameters, &found.solution);
        let fit = Fit::with_variance(&names, &z, &fitted, found.solution, found.variance);
        let fit = Fit { origins: found.origins, ..fit };
        Ok(PooledFit { fit, samples, parameters, prior_information: found.prior_information })
    }

    /// The regression with the samples of each window replaced by the rows of the triangle `R` of `[X z] = Q R`, one more than there are
    /// terms at most: the same estimates and sums of squared residuals, not the same residual deviation.
    ///
    /// # Errors
    /// Sizes that differ and values that are not finite.
    pub fn reduce(&self) -> Result<Self, EstimateError> {
        let reduce = |window: &PooledWindow| {
            check_values(&self.names, &window.x, &window.z)?;
            let factor = Triangle::reduce(&window.x, &window.z).factor().clone();
            let (x, z) =
                (factor.columns(0, self.names.len()).into_owned(), factor.column(self.names.len()).as_slice().to_vec());
            Ok(PooledWindow { label: window.label.clone(), x, z })
        };
        Ok(Self { windows: self.windows.iter().map(reduce).collect::<Result<_, _>>()?, ..self.clone() })
    }

    /// Names of the parameters all windows share, in the order of the fit.
    pub fn shared(&self) -> impl Iterator<Item = &String> {
        self.names.iter().zip(&self.per_window).filter(|(_, own)| !**own).map(|(name, _)| name)
    }
}

/// One set of parameters over several windows, some of them one per window.
#[derive(Clone, Debug, PartialEq)]
pub struct PooledFit {
    /// The fit over all samples. Parameters shared by all windows come first, in the order of the terms, then those of each
    /// window, named `name[label]`. Residuals follow one another in the order of the windows.
    pub fit: Fit,
    /// Samples of each window in `fit.residuals`.
    pub samples: Vec<Range<usize>>,
    /// For each window, which parameter each term has.
    pub parameters: Vec<Vec<usize>>,
    /// Information of the prior of each parameter beside `X'X`, `s^2 / deviation^2`; zero without one.
    pub prior_information: Vec<f64>,
}

/// Least squares over all windows at once: terms flagged in `per_window` have a parameter of their own in each window (trim
/// differs from window to window), the others one for all. Rows of different windows share no parameter of the first
/// kind, so correlations that hold inside one manoeuvre are broken by the others.
///
/// `names` and `per_window` have one entry per term. Each window is triangularised by itself, so the cost is that of the
/// separate fits; the result does not depend on the order of the windows.
///
/// # Errors
/// As for [`super::least_squares`], with the sizes and values of each window; a window needs no minimum of its own.
pub fn pooled(names: &[String], per_window: &[bool], windows: &[PooledWindow]) -> Result<PooledFit, EstimateError> {
    let ((all_names, parameters), triangle) = triangles(names, per_window, windows)?;
    let total: usize = windows.iter().map(|window| window.z.len()).sum();
    if total <= all_names.len() {
        return Err(EstimateError::TooFewSamples { samples: total, parameters: all_names.len() });
    }
    let solution = triangle.solve(&all_names)?;
    let (fitted, z, samples) = fitted(windows, &parameters, &solution);
    let prior_information = vec![0.0; all_names.len()];
    Ok(PooledFit { fit: Fit::assemble(&all_names, &z, &fitted, solution), samples, parameters, prior_information })
}

/// Names of all parameters, the parameter of each term in each window, and the triangle of all windows.
fn triangles(
    names: &[String],
    per_window: &[bool],
    windows: &[PooledWindow],
) -> Result<(Layout, Triangle), EstimateError> {
    let (all_names, parameters) = layout(names, per_window, windows)?;
    for window in windows {
        check_values(names, &window.x, &window.z)?;
    }
    let triangles: Vec<Triangle> = windows.iter().map(|window| Triangle::reduce(&window.x, &window.z)).collect();
    let parts = triangles.iter().zip(parameters.iter().map(Vec::as_slice));
    let triangle = Triangle::stack(parts, all_names.len());
    Ok(((all_names, parameters), triangle))
}

/// Fitted values and measurements of all windows, and the samples of each in them.
fn fitted(
    windows: &[PooledWindow],
    parameters: &[Vec<usize>],
    solution: &Solution,
) -> (Vec<f64>, Vec<f64>, Vec<Range<usize>>) {
    let (mut fitted, mut z, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for (window, columns) in windows.iter().zip(parameters) {
        let start = fitted.len();
        fitted.extend((&window.x * solution.estimates.select_rows(columns)).iter());
        z.extend_from_slice(&window.z);
        samples.push(start..fitted.len());
    }
    (fitted, z, samples)
}

/// All windows in one regression.
#[derive(Clone, Debug, PartialEq)]
pub struct Stacked {
    /// Names of the parameters, as in [`PooledFit`].
    pub names: Vec<String>,
    /// Regressors, all samples by all parameters.
    pub x: DMatrix<f64>,
    /// Measurement at all samples.
    pub z: Vec<f64>,
}

/// Names, regressors and measurement of all windows in one matrix, as [`pooled`] sees them: for methods that choose terms
/// over all windows jointly.
///
/// # Errors
/// Sizes that differ and values that are not finite.
pub fn stacked(names: &[String], per_window: &[bool], windows: &[PooledWindow]) -> Result<Stacked, EstimateError> {
    let (all_names, parameters) = layout(names, per_window, windows)?;
    let total = windows.iter().map(|window| window.z.len()).sum();
    let mut x = DMatrix::zeros(total, all_names.len());
    let mut z = Vec::with_capacity(total);
    for (window, columns) in windows.iter().zip(&parameters) {
        check_values(names, &window.x, &window.z)?;
        for (term, &column) in columns.iter().enumerate() {
            x.view_mut((z.len(), column), (window.z.len(), 1)).copy_from(&window.x.column(term));
        }
        z.extend_from_slice(&window.z);
    }
    Ok(Stacked { names: all_names, x, z })
}

impl PooledFit {
    /// Covariance for correlated residuals, whose products are taken inside each window only; `windows` are those fitted.
    pub fn coloured_covariance(
        &self,
        windows: &[PooledWindow],
        settings: &Coloured,
    ) -> Result<DMatrix<f64>, EstimateError> {
        self.coloured(windows.iter().map(|window| Cow::Borrowed(&window.x)), settings)
    }

    /// [`Self::coloured_covariance`] of windows that are not needed any more: each goes as soon as it can, as it may be long.
    pub fn coloured_covariance_of(
        &self,
        windows: Vec<PooledWindow>,
        settings: &Coloured,
    ) -> Result<DMatrix<f64>, EstimateError> {
        self.coloured(windows.into_iter().map(|PooledWindow { x, .. }| Cow::Owned(x)), settings)
    }

    fn coloured<'x>(
        &self,
        windows: impl ExactSizeIterator<Item = Cow<'x, DMatrix<f64>>>,
        settings: &Coloured,
    ) -> Result<DMatrix<f64>, EstimateError> {
        if windows.len() != self.samples.len() {
            return Err(EstimateError::Size {
                quantity: "windows",
                expected: self.samples.len(),
                found: windows.len(),
            });
        }
        let blocks: Vec<_> = windows
            .zip(&self.parameters)
            .zip(&self.samples)
            .map(|((x, columns), samples)| Block { x, columns, residuals: vec![&self.fit.residuals[samples.clone()]] })
            .collect();
        let unit = Unit {
            covariance: &self.fit.unit_covariance,
            prior_information: &self.prior_information,
            variance: self.fit.residual_std.powi(2),
        };
        with_transforms(|transforms| coloured_covariances_of(&[unit], blocks, settings, transforms)).and_then(only)
    }
}

/// Names of all parameters, and for each window the parameter of each term.
pub(super) type Layout = (Vec<String>, Vec<Vec<usize>>);

/// The layout of the windows, once every term has its per-window flag.
pub(super) fn layout(names: &[String], per_window: &[bool], windows: &[PooledWindow]) -> Result<Layout, EstimateError> {
    if per_window.len() != names.len() {
        return Err(EstimateError::Size {
            quantity: "per-window flags",
            expected: names.len(),
            found: per_window.len(),
        });
    }
    let mut all: Vec<String> =
        names.iter().zip(per_window).filter(|(_, own)| !**own).map(|(name, _)| name.clone()).collect();
    let mut parameters = Vec::with_capacity(windows.len());
    for window in windows {
        let mut shared = 0;
        let columns = names.iter().zip(per_window).map(|(name, &own)| {
            if own {
                all.push(format!("{name}[{}]", window.label));
                all.len() - 1
            } else {
                shared += 1;
                shared - 1
            }
        });
        parameters.push(columns.collect());
    }
    Ok((all, parameters))
}
