//! `doublet variants`: the pooled derivatives by other forms of least squares beside the ordinary one; nothing is changed.

use std::path::PathBuf;

use clap::Args;
use doublet_core::estimate::{
    Coloured, Constraint, EstimateError, Fit, PooledFit, PooledRegression, Stacked, errors_in_variables,
    generalised_least_squares, stacked, total_least_squares, weighted_coloured_covariance, weighted_least_squares,
};
use doublet_engine::stage::{Regression, pooled_regressions};
use nalgebra::{DMatrix, DVector};

use crate::run::{self, computed};
use crate::text;

/// Arguments of `variants`.
#[derive(Debug, Args)]
pub struct VariantArguments {
    /// Session file.
    pub session: PathBuf,
    /// Known value, range or prior: Cm_q=-5, Cm_q=-8..-4, Cl_p=-0.45~0.05.
    #[arg(long, value_name = "NAME=KNOWN", value_parser = knowledge, allow_hyphen_values = true)]
    pub know: Vec<(String, Constraint)>,
    /// Noise of a regressor, standard deviation: Cm_alpha=5e-4.
    #[arg(long, value_name = "NAME=STD", value_parser = deviation)]
    pub noise: Vec<(String, f64)>,
    /// Autoregression order of the residuals in the generalised fit.
    #[arg(long, default_value_t = 2)]
    pub order: usize,
}

fn value(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("'{text}' is not a number"))
}

fn knowledge(text: &str) -> Result<(String, Constraint), String> {
    let (name, known) = text.split_once('=').ok_or("write it as NAME=VALUE, NAME=LOWER..UPPER or NAME=MEAN~STD")?;
    let constraint = match (known.split_once(".."), known.split_once('~')) {
        (Some((lower, upper)), _) => Constraint::Bounds { lower: value(lower)?, upper: value(upper)? },
        (None, Some((mean, deviation))) => Constraint::Prior { mean: value(mean)?, deviation: value(deviation)? },
        (None, None) => Constraint::Fixed(value(known)?),
    };
    Ok((name.trim().to_owned(), constraint))
}

fn deviation(text: &str) -> Result<(String, f64), String> {
    let (name, deviation) = text.split_once('=').ok_or("write it as NAME=STD, for example Cm_alpha=5e-4")?;
    Ok((name.trim().to_owned(), value(deviation)?))
}

/// Prints every derivative by every form.
///
/// # Errors
/// One line: what is wrong with the session, its windows or what is known.
pub fn variants(arguments: &VariantArguments) -> Result<(), String> {
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let windows = snapshot.aero(&session);
    let named = arguments.know.iter().map(|(name, _)| name).chain(arguments.noise.iter().map(|(name, _)| name));
    let mut unknown: Vec<&String> = named.collect();
    let mut done = 0;
    for regression in pooled_regressions(&windows, &session.structure, &session.estimation) {
        let Ok(Regression { coefficient, mut pooled }) =
            regression.inspect_err(|error| run::print_error(&error.to_string()))
        else {
            continue;
        };
        let known = std::mem::take(&mut pooled.constraints);
        let fitted = pooled.fit().inspect_err(|error| run::print_error(&format!("{}: {error}", coefficient.name())));
        let Ok(ordinary) = fitted else { continue };
        done += 1;
        let all = stacked(&pooled.names, &pooled.per_window, &pooled.windows).map_err(|error| error.to_string())?;
        let shared = pooled.shared().count();
        unknown.retain(|name| !all.names[..shared].contains(name));
        let mut weights = vec![1.0; all.z.len()];
        for range in &ordinary.samples {
            let residuals = &ordinary.fit.residuals[range.clone()];
            let variance = residuals.iter().map(|v| v * v).sum::<f64>() / residuals.len() as f64;
            weights[range.clone()].fill(variance.recip());
        }
        let mut fits = vec![Form::new("ordinary", corrected(&pooled, Ok(ordinary.clone())))];
        fits.push(Form::new("weighted", weighted(&all, &weights, &ordinary)));
        fits.push(Form::new("generalised", whitened(&all, arguments.order, &ordinary)));
        pooled.constraints = known;
        pooled.constraints.resize(pooled.names.len(), Constraint::Free);
        for (name, known) in &arguments.know {
            let place = pooled.names.iter().position(|other| other == name);
            place.into_iter().for_each(|place| pooled.constraints[place] = *known);
        }
        if pooled.constraints.iter().any(|constraint| *constraint != Constraint::Free) {
            fits.push(Form::new("constrained", corrected(&pooled, pooled.fit())));
        }
        fits.extend(with_noise(&all, &arguments.noise, ordinary.fit.residual_std));
        print(&all.names[..shared], &fits);
    }
    match unknown.first() {
        Some(name) => Err(format!("pooled derivative '{name}' not found")),
        None => run::some_done(done),
    }
}

/// A form of least squares: its fit with the corrected standard errors of its parameters, none where there is no such correction.
struct Form {
    name: &'static str,
    found: Result<(Fit, Vec<f64>), String>,
}

impl Form {
    fn new(name: &'static str, found: Result<(Fit, DMatrix<f64>), EstimateError>) -> Self {
        let errors = |covariance: &DMatrix<f64>| covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        let found = found.map(|(fit, covariance)| (fit, errors(&covariance))).map_err(|error| error.to_string());
        Self { name, found }
    }
}

/// A pooled fit with its covariance for correlated residuals.
fn corrected(
    pooled: &PooledRegression,
    fit: Result<PooledFit, EstimateError>,
) -> Result<(Fit, DMatrix<f64>), EstimateError> {
    let fit = fit?;
    let covariance = fit.coloured_covariance(&pooled.windows, &Coloured::default())?;
    Ok((fit.fit, covariance))
}

fn weighted(all: &Stacked, weights: &[f64], ordinary: &PooledFit) -> Result<(Fit, DMatrix<f64>), EstimateError> {
    let fit = weighted_least_squares(&all.names, &all.x, &all.z, weights)?;
    let covariance = weighted_coloured_covariance(&fit, &all.x, weights, &ordinary.samples, &Coloured::default())?;
    Ok((fit, covariance))
}

fn whitened(all: &Stacked, order: usize, ordinary: &PooledFit) -> Result<(Fit, DMatrix<f64>), EstimateError> {
    let found = generalised_least_squares(&all.names, &all.x, &all.z, &ordinary.samples, order)?;
    let covariance = found.coloured_covariance(&all.x, &ordinary.samples, &Coloured::default())?;
    Ok((found.fit, covariance))
}

/// Corrected for the noise of the regressors, and total least squares, where any noise is stated; their errors have no correction
/// for correlated residuals.
fn with_noise(all: &Stacked, noise: &[(String, f64)], measurement: f64) -> Vec<Form> {
    let noise_deviation =
        |name: &String| noise.iter().find(|(other, _)| other == name).map_or(0.0, |(_, deviation)| *deviation);
    let deviations: Vec<f64> = all.names.iter().map(noise_deviation).collect();
    if deviations.iter().all(|deviation| *deviation == 0.0) {
        return Vec::new();
    }
    let variances: Vec<f64> = deviations.iter().map(|deviation| deviation * deviation).collect();
    let covariance = DMatrix::from_diagonal(&DVector::from_vec(variances));
    let corrected = errors_in_variables(&all.names, &all.x, &all.z, &covariance);
    let total = total_least_squares(&all.names, &all.x, &all.z, &deviations, measurement);
    let form = |name, fit: Result<Fit, EstimateError>| Form {
        name,
        found: fit.map(|fit| (fit, Vec::new())).map_err(|error| error.to_string()),
    };
    vec![form("noise taken out", corrected), form("total", total)]
}

fn print(names: &[String], fits: &[Form]) {
    for (form, error) in fits.iter().filter_map(|form| Some((form.name, form.found.as_ref().err()?))) {
        text::line(&format!("{form}: {error}"));
    }
    let found: Vec<_> = fits.iter().filter_map(|form| Some((form.name, form.found.as_ref().ok()?))).collect();
    let header: Vec<&str> = std::iter::once("derivative").chain(found.iter().map(|(form, _)| *form)).collect();
    let cell = |(fit, corrected): &(Fit, Vec<f64>), name: &String| {
        let (estimate, error) = fit.parameter(name).unwrap_or((f64::NAN, f64::NAN));
        let place = fit.names.iter().position(|other| other == name);
        let corrected = place.and_then(|place| corrected.get(place)).copied().unwrap_or(f64::NAN);
        format!("{} ({}; {})", text::number(estimate, 5), text::number(error, 2), text::number(corrected, 2))
    };
    let row = |name: &String| {
        std::iter::once(name.clone()).chain(found.iter().map(|(_, fit)| cell(fit, name))).collect::<Vec<_>>()
    };
    text::table(&header, &names.iter().map(row).collect::<Vec<_>>());
    text::line("(conventional standard error; corrected for correlated residuals)");
    text::line("");
}
