//! Low-order equivalent systems of measured responses, with what flying qualities are judged by.

use doublet_dynamics::frequency::{
    BodeCurve, Delay, EquivalentSystem, FitSettings, FittedParameter, Form, FrequencyError, Margins, Mismatch,
    OutputErrorBand, Section, TransferFunction, fit_records, fit_response, logarithmic_grid,
};

use super::response::{ResponseError, ResponseStudy};

/// A fitted model and what follows from it.
#[derive(Clone, Debug)]
pub struct EquivalentStudy {
    /// Number of the input.
    pub input: usize,
    /// Weighted by coherence.
    pub fit: EquivalentSystem,
    /// Its distance from the response.
    pub mismatch: Mismatch,
    /// The same form fitted to the records by output error, of a single input, or why that failed.
    pub by_output_error: Option<Result<EquivalentSystem, FrequencyError>>,
    /// `T_theta2`, `omega_Ttheta2`, `zeta_omega`, `T_R` as far as the form has them; `bandwidth`, `phase_delay` and `omega_180` of the
    /// attitude, where the output is a rate or an attitude; s, rad/s.
    pub derived: Vec<FittedParameter>,
    /// Margins of the loop over the response of the output itself.
    pub margins: Margins,
}

/// Outputs whose integral is an attitude.
const RATES: [&str; 3] = ["p", "q", "r"];
/// Attitudes.
const ATTITUDES: [&str; 3] = ["phi", "theta", "psi"];

/// How an attitude follows from an output.
#[derive(Clone, Copy, PartialEq)]
enum Attitude {
    Itself,
    Integral,
}

/// Fits a form to the response of a study.
///
/// # Errors
/// As [`fit_response`].
pub fn equivalent_study(
    study: &ResponseStudy,
    input: usize,
    form: Form,
    delay: Delay,
) -> Result<EquivalentStudy, ResponseError> {
    let settings = FitSettings { form, delay };
    let response = study.responses.get(input).ok_or(FrequencyError::NoRecord)?;
    let fit = fit_response(response, &settings)?;
    let mismatch = Mismatch::of(&fit.model, response).unwrap_or_default();
    let points = &response.points;
    let by_output_error = (study.inputs.len() == 1).then(|| {
        let [low_rad_s, high_rad_s] =
            [points.first(), points.last()].map(|point| point.map_or(f64::NAN, |point| point.omega_rad_s));
        fit_records(&study.samples, &OutputErrorBand { low_rad_s, high_rad_s, step_rad_s: None }, &settings)
    });
    let is_rate = !matches!(form, Form::Orders { .. }) || RATES.contains(&study.output.as_str());
    let is_attitude = ATTITUDES.contains(&study.output.as_str());
    let attitude = match (is_rate, is_attitude) {
        (_, true) => Some(Attitude::Itself),
        (true, false) => Some(Attitude::Integral),
        (false, false) => None,
    };
    let derived = derive(&fit, attitude);
    let margins = BodeCurve::of_model(&fit.model, &model_grid(&fit.model)).margins();
    Ok(EquivalentStudy { input, fit, mismatch, by_output_error, derived, margins })
}

/// Frequencies two decades to either side of the poles of a model.
fn model_grid(model: &TransferFunction) -> Vec<f64> {
    const POINTS: usize = 4000;
    let poles = model.poles();
    let sizes: Vec<f64> = poles.iter().map(|pole| pole.norm()).filter(|size| *size > 0.0).collect();
    let middle = (sizes.iter().map(|size| size.ln()).sum::<f64>() / sizes.len().max(1) as f64).exp();
    logarithmic_grid(0.01 * middle, 100.0 * middle, POINTS)
}

fn derive(fit: &EquivalentSystem, attitude: Option<Attitude>) -> Vec<FittedParameter> {
    let zero = |model: &TransferFunction| match model.numerator[..] {
        [Section::First(rate)] if rate > 0.0 => Some(rate),
        _ => None,
    };
    let pair = |model: &TransferFunction| match model.denominator[..] {
        [Section::Second { c1, c0 }] if c0 > 0.0 => Some((c1, c0)),
        _ => None,
    };
    let pole = |model: &TransferFunction| match model.denominator[..] {
        [Section::First(rate)] if rate > 0.0 => Some(rate.recip()),
        _ => None,
    };
    let is_pitch = fit.form == Form::ShortPeriod;
    let mut derived = Vec::new();
    if is_pitch {
        derived.push(fit.propagate("T_theta2", |model| zero(model).map(f64::recip)));
        derived.push(fit.propagate("omega_Ttheta2", |model| Some(pair(model)?.1.sqrt() / zero(model)?)));
    }
    derived.push(fit.propagate("zeta_omega", |model| pair(model).map(|(c1, _)| 0.5 * c1)));
    derived.push(fit.propagate("T_R", pole));
    if let Some(attitude) = attitude {
        let grid = model_grid(&fit.model);
        let bandwidth = |model: &TransferFunction| {
            let curve = BodeCurve::of_model(model, &grid);
            if attitude == Attitude::Integral { curve.integrated().bandwidth() } else { curve.bandwidth() }
        };
        derived.push(fit.propagate("bandwidth", |model| bandwidth(model)?.bandwidth_rad_s()));
        derived.push(fit.propagate("phase_delay", |model| bandwidth(model)?.phase_delay_s));
        derived.push(fit.propagate("omega_180", |model| Some(bandwidth(model)?.omega_180_rad_s)));
    }
    derived.into_iter().flatten().collect()
}
