//! Equation error in the frequency domain, coefficient by coefficient.

use doublet_core::estimate::{Fit, FrequencySettings, FrequencyWindow, frequency_equation_error};
use doublet_core::model::{Coefficient, Term, regressors};

use super::{CheckedDerivative, MethodEstimates, ModelPart, PartEstimates, WindowEstimation};
use crate::graph::StageResult;

/// Every coefficient that the window's own fit has.
pub(super) fn estimate(estimation: &WindowEstimation<'_>) -> Vec<PartEstimates> {
    let fits = &estimation.window.fits.fits;
    let own = fits.iter().filter_map(|fit| Some((fit.coefficient, fit.fit.as_ref().ok()?)));
    let one = |(coefficient, fit)| {
        let result = in_frequency(estimation, coefficient, fit);
        PartEstimates { part: ModelPart::Coefficient(coefficient), result }
    };
    own.map(one).collect()
}

/// Terms of the structure that the window's own fit has.
fn fitted_terms(estimation: &WindowEstimation<'_>, coefficient: Coefficient, fit: &Fit) -> Vec<Term> {
    let terms = estimation.input.settings.structure.terms(coefficient).unwrap_or_default();
    terms.iter().filter(|term| fit.names.contains(&term.derivative_name(coefficient))).cloned().collect()
}

/// Equation error in the frequency domain from twice the lowest frequency the window resolves, at the frequencies it resolves:
/// each adds information of its own, so that the standard errors need no correction. Of a window with excluded stretches the longest
/// part without one counts.
fn in_frequency(
    estimation: &WindowEstimation<'_>,
    coefficient: Coefficient,
    fit: &Fit,
) -> StageResult<MethodEstimates> {
    let aero = &estimation.window.aero;
    let terms: Vec<Term> =
        fitted_terms(estimation, coefficient, fit).into_iter().filter(|term| !term.is_constant()).collect();
    let names: Vec<String> = terms.iter().map(|term| term.derivative_name(coefficient)).collect();
    let rows = aero.longest_rows();
    let x = regressors(&terms, &aero.variables)?.rows(rows.start, rows.len()).into_owned();
    let time_s = &aero.coefficients.time_s[rows.clone()];
    if time_s.len() < 2 {
        return Err("excluded parts leave too few samples".into());
    }
    let duration_s = time_s[time_s.len() - 1] - time_s[0];
    let step_s = duration_s / (time_s.len() - 1) as f64;
    let defaults = FrequencySettings::default();
    let settings = FrequencySettings {
        lowest_hz: (2.0 / duration_s).max(defaults.lowest_hz),
        step_hz: 1.0 / duration_s,
        ..defaults
    };
    let window = FrequencyWindow { step_s, x, z: aero.coefficients.get(coefficient)[rows].to_vec() };
    let found = frequency_equation_error(&names, &[window], &settings)?;
    let rows = found.names.iter().zip(&found.estimates).zip(&found.standard_errors);
    let derivatives = rows
        .map(|((name, &estimate), &standard_error)| CheckedDerivative { name: name.clone(), estimate, standard_error })
        .collect();
    Ok(MethodEstimates { derivatives, covariance: found.covariance, ..MethodEstimates::default() })
}
