//! The pooled derivatives by the forms of least squares, side by side. To add a form: its function here and a row in [`LEAST_SQUARES_FORMS`].

use doublet_core::estimate::{
    Coloured, Constraint, EstimateError, Fit, PooledFit, PooledRegression, Stacked, errors_in_variables,
    generalised_least_squares, stacked, total_least_squares, weighted_coloured_covariance, weighted_least_squares,
};
use doublet_core::model::{Coefficient, Structure};
use nalgebra::{DMatrix, DVector};

use crate::graph::{StageError, StageResult};
use crate::session::Session;
use crate::stage::{AeroWindow, Regression, by_instruments, pooled_regressions, sample_step_s};

/// What the forms know beside the data.
#[derive(Clone, Debug, Default)]
pub struct FormRequest {
    /// Known values, ranges or expectations of derivatives.
    pub known: Vec<(String, Constraint)>,
    /// Standard deviation of the noise of regressors.
    pub noise: Vec<(String, f64)>,
    /// Order of the autoregression of the residuals.
    pub order: usize,
}

#[derive(Clone, Debug)]
pub struct FormEstimates {
    pub form: &'static str,
    /// The fit, and its standard errors corrected for correlated residuals; none where there is no such correction.
    pub found: StageResult<(Fit, Vec<f64>)>,
}

/// One coefficient by every form that applies.
#[derive(Clone, Debug)]
pub struct CoefficientForms {
    pub coefficient: Coefficient,
    /// Derivatives that all windows share.
    pub derivatives: Vec<String>,
    /// Estimates, the ordinary ones first.
    pub forms: Vec<FormEstimates>,
}

/// A fit with its covariance for correlated residuals, where there is one.
type FormFit = Result<(Fit, Option<DMatrix<f64>>), EstimateError>;

/// One coefficient to fit.
struct Problem<'a> {
    request: &'a FormRequest,
    coefficient: Coefficient,
    structure: &'a Structure,
    /// Time between samples, s; none without samples.
    step_s: Option<f64>,
    /// The regression without constraints, and with those there are.
    free: &'a PooledRegression,
    constrained: &'a PooledRegression,
    all: &'a Stacked,
    ordinary: &'a PooledFit,
    /// Noise of each regressor.
    deviations: &'a [f64],
}

/// A form; none where it does not apply.
type Form = fn(&Problem<'_>) -> Option<FormFit>;

const LEAST_SQUARES_FORMS: [(&str, Form); 7] = [
    ("ordinary", |problem| Some(corrected(problem.free, Ok(problem.ordinary.clone())))),
    ("weighted", |problem| Some(weighted(problem))),
    ("generalised", |problem| Some(whitened(problem))),
    ("instrumental variables", instrumental),
    ("constrained", constrained),
    ("noise taken out", without_noise),
    ("total", total),
];

/// Every coefficient of the structure that some identification window excites, by every form that applies, or one line why not.
pub fn least_squares_forms(
    windows: &[AeroWindow<'_>],
    session: &Session,
    request: &FormRequest,
) -> StageResult<Vec<StageResult<CoefficientForms>>> {
    let Session { structure, estimation, .. } = session;
    let named = request.known.iter().map(|(name, _)| name).chain(request.noise.iter().map(|(name, _)| name));
    let mut unknown: Vec<&String> = named.collect();
    let mut coefficients = Vec::new();
    for regression in pooled_regressions(windows, structure, estimation) {
        let found = regression.and_then(|regression| {
            let coefficient = regression.coefficient;
            by_every_form(regression, request, (structure, sample_step_s(windows)))
                .map_err(|error| StageError::from(error).at(coefficient.name()))
        });
        if let Ok(found) = &found {
            unknown.retain(|name| !found.derivatives.contains(name));
        }
        coefficients.push(found);
    }
    match unknown.first() {
        Some(name) => Err(format!("pooled derivative '{name}' not found").into()),
        None => Ok(coefficients),
    }
}

fn by_every_form(
    regression: Regression,
    request: &FormRequest,
    (structure, step_s): (&Structure, Option<f64>),
) -> Result<CoefficientForms, EstimateError> {
    let Regression { coefficient, pooled: mut constrained } = regression;
    let free = PooledRegression { constraints: Vec::new(), ..constrained.clone() };
    let ordinary = free.fit()?;
    let all = stacked(&free.names, &free.per_window, &free.windows)?;
    constrained.constraints.resize(constrained.names.len(), Constraint::Free);
    for (name, known) in &request.known {
        if let Some(place) = constrained.names.iter().position(|other| other == name) {
            constrained.constraints[place] = *known;
        }
    }
    let noise = |name: &String| request.noise.iter().find(|(other, _)| other == name).map_or(0.0, |(_, noise)| *noise);
    let deviations: Vec<f64> = all.names.iter().map(noise).collect();
    let problem = Problem {
        request,
        coefficient,
        structure,
        step_s,
        free: &free,
        constrained: &constrained,
        all: &all,
        ordinary: &ordinary,
        deviations: &deviations,
    };
    let forms = LEAST_SQUARES_FORMS.iter().filter_map(|(form, fit)| {
        let found = fit(&problem)?.map(|(fit, covariance)| {
            let errors = covariance.map(|found| found.diagonal().iter().map(|variance| variance.sqrt()).collect());
            (fit, errors.unwrap_or_default())
        });
        Some(FormEstimates { form, found: found.map_err(StageError::from) })
    });
    let forms = forms.collect();
    let derivatives = all.names[..free.shared().count()].to_vec();
    Ok(CoefficientForms { coefficient, derivatives, forms })
}

/// A pooled fit with its covariance for correlated residuals.
fn corrected(pooled: &PooledRegression, fit: Result<PooledFit, EstimateError>) -> FormFit {
    let fit = fit?;
    let covariance = fit.coloured_covariance(&pooled.windows, &Coloured::default())?;
    Ok((fit.fit, Some(covariance)))
}

/// Each window by the variance of its residuals.
fn weighted(Problem { all, ordinary, .. }: &Problem<'_>) -> FormFit {
    let mut weights = vec![1.0; all.z.len()];
    for range in &ordinary.samples {
        let residuals = &ordinary.fit.residuals[range.clone()];
        let variance = residuals.iter().map(|v| v * v).sum::<f64>() / residuals.len() as f64;
        weights[range.clone()].fill(variance.recip());
    }
    let fit = weighted_least_squares(&all.names, &all.x, &all.z, &weights)?;
    let covariance = weighted_coloured_covariance(&fit, &all.x, &weights, &ordinary.samples, &Coloured::default())?;
    Ok((fit, Some(covariance)))
}

/// Whitened by an autoregression of the residuals.
fn whitened(Problem { all, ordinary, request, .. }: &Problem<'_>) -> FormFit {
    let found = generalised_least_squares(&all.names, &all.x, &all.z, &ordinary.samples, request.order)?;
    let covariance = found.coloured_covariance(&all.x, &ordinary.samples, &Coloured::default())?;
    Ok((found.fit, Some(covariance)))
}

/// By what the controls do alone.
fn instrumental(&Problem { coefficient, free, structure, step_s, .. }: &Problem<'_>) -> Option<FormFit> {
    let found = by_instruments(coefficient, free, structure, step_s?);
    Some(found.map(|(fit, covariance)| (fit, Some(covariance))))
}

/// Under what is known.
fn constrained(Problem { constrained, .. }: &Problem<'_>) -> Option<FormFit> {
    let is_known = constrained.constraints.iter().any(|constraint| *constraint != Constraint::Free);
    is_known.then(|| corrected(constrained, constrained.fit()))
}

/// Corrected for the noise of the regressors, where any is stated; its errors have no correction for correlated residuals.
fn without_noise(Problem { all, deviations, .. }: &Problem<'_>) -> Option<FormFit> {
    let variances: Vec<f64> = deviations.iter().map(|deviation| deviation * deviation).collect();
    let is_stated = variances.iter().any(|variance| *variance != 0.0);
    let covariance = DMatrix::from_diagonal(&DVector::from_vec(variances));
    is_stated.then(|| Ok((errors_in_variables(&all.names, &all.x, &all.z, &covariance)?, None)))
}

/// Total least squares, as above.
fn total(Problem { all, deviations, ordinary, .. }: &Problem<'_>) -> Option<FormFit> {
    let is_stated = deviations.iter().any(|deviation| *deviation != 0.0);
    let measurement = ordinary.fit.residual_std;
    is_stated.then(|| Ok((total_least_squares(&all.names, &all.x, &all.z, deviations, measurement)?, None)))
}
