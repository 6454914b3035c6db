//! Low-order equivalent systems of measured responses, with what flying qualities are judged by.

use doublet_dynamics::frequency::{
    BodeCurve, Delay, EquivalentSystem, FitSettings, FittedParameter, Form, FrequencyError, Margins, Mismatch,
    OutputErrorBand, Section, TransferFunction, fit_records, fit_response, logarithmic_grid,
};

use super::response::{ResponseError, ResponseStudy};
use super::systems::{Alternative, judge_system};
use crate::session::{Level, Verdict};

/// What a form is fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitMethod {
    /// Transforms of the records, by maximum likelihood: of a single input.
    OutputError,
    /// The response, weighted by coherence.
    Coherence,
}

impl FitMethod {
    doublet_core::named_variants! {
        /// Name on the command line and in results.
        pub name: OutputError "output-error", Coherence "coherence"
    }
}

/// A fitted model and what follows from it.
#[derive(Clone, Debug)]
pub struct EquivalentStudy {
    /// Number of the input.
    pub input: usize,
    /// What it was fitted to.
    pub method: FitMethod,
    pub fit: EquivalentSystem,
    /// Its distance from the response.
    pub mismatch: Mismatch,
    /// The same form by the other method, or why that failed; none of several inputs.
    pub other: Option<(FitMethod, Result<EquivalentSystem, FrequencyError>)>,
    /// `T_theta2`, `omega_Ttheta2`, `zeta_omega`, `T_R` as far as the form has them; `bandwidth`, `phase_delay` and `omega_180` of the
    /// attitude, where the output is a rate or an attitude; s, rad/s.
    pub derived: Vec<FittedParameter>,
    /// Margins of the loop over the response of the output itself.
    pub margins: Margins,
    /// Whether the form fits, and whether a richer one and the other method say the same.
    pub verdict: Verdict,
}

impl EquivalentStudy {
    /// Whether its parameters must not be used.
    pub fn is_rejected(&self) -> bool {
        self.verdict.level == Level::Bad
    }
}

/// Outputs whose integral is an attitude.
const RATES: [&str; 3] = ["p", "q", "r"];
const ATTITUDES: [&str; 3] = ["phi", "theta", "psi"];

/// How an attitude follows from an output.
#[derive(Clone, Copy, PartialEq)]
enum Attitude {
    Itself,
    Integral,
}

/// Fits a form to a study that was made for it: without a method by output error where there is a single input, which short windows bias
/// least, and by coherence of several.
pub fn equivalent_study(
    study: &ResponseStudy,
    input: usize,
    (form, delay): (Form, Delay),
    method: Option<FitMethod>,
) -> Result<EquivalentStudy, ResponseError> {
    let settings = FitSettings { form, delay };
    let response = study.responses.get(input).ok_or(FrequencyError::NoRecord)?;
    let is_single = study.inputs.len() == 1;
    let method = method.unwrap_or(if is_single { FitMethod::OutputError } else { FitMethod::Coherence });
    let [low_rad_s, high_rad_s] = study.band_rad_s;
    let with = |method: FitMethod, settings: &FitSettings| match method {
        FitMethod::OutputError => {
            fit_records(&study.samples, &OutputErrorBand { low_rad_s, high_rad_s, step_rad_s: None }, settings)
        }
        FitMethod::Coherence => fit_response(response, settings),
    };
    let by = |method: FitMethod| with(method, &settings);
    let fit = by(method)?;
    let beside = FitMethod::ALL.into_iter().find(|other| *other != method && is_single);
    let other = beside.map(|other| (other, by(other)));
    let mismatch = Mismatch::compare(&fit.model, response).unwrap_or_default();
    let is_rate = !matches!(form, Form::Orders { .. }) || RATES.contains(&study.output.as_str());
    let is_attitude = ATTITUDES.contains(&study.output.as_str());
    let attitude = match (is_rate, is_attitude) {
        (_, true) => Some(Attitude::Itself),
        (true, false) => Some(Attitude::Integral),
        (false, false) => None,
    };
    let in_band = |row: &FittedParameter| match row.name.as_str() {
        "bandwidth" | "omega_180" => (low_rad_s..=high_rad_s).contains(&row.value),
        _ => true,
    };
    let inside = |rows: Vec<FittedParameter>| rows.into_iter().filter(in_band).collect::<Vec<_>>();
    let derived = inside(derive(&fit, attitude));
    let richer = richer(form).and_then(|form| with(method, &FitSettings { form, delay }).ok());
    let of_richer = richer.as_ref().map(|fit| inside(derive(fit, attitude)));
    let alternative = richer.as_ref().zip(of_richer.as_ref()).map(|(fit, derived)| Alternative {
        mismatch: Mismatch::compare(&fit.model, response).unwrap_or_default(),
        fit,
        derived,
    });
    let verdict =
        judge_system((&fit, &mismatch, &derived), alternative.as_ref(), other.as_ref().map(|(_, other)| other));
    let margins = BodeCurve::of_model(&fit.model, &model_grid(&fit.model)).margins();
    Ok(EquivalentStudy { input, method, fit, mismatch, other, derived, margins, verdict })
}

/// The form with one more oscillation; none of an order that is not fitted.
fn richer(form: Form) -> Option<Form> {
    const MOST: usize = 6;
    let (numerator, denominator) = form.orders();
    (denominator + 2 <= MOST).then_some(Form::Orders { numerator: numerator + 2, denominator: denominator + 2 })
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
    let is_pitch = fit.form == Form::ShortPeriod;
    let mut derived = Vec::new();
    if is_pitch {
        derived.push(fit.propagate("T_theta2", |model| real_zero(model).map(f64::recip)));
        derived.push(fit.propagate("omega_Ttheta2", |model| Some(oscillation(model)?.1.sqrt() / real_zero(model)?)));
    }
    derived.push(fit.propagate("zeta_omega", |model| oscillation(model).map(|(c1, _)| 0.5 * c1)));
    derived.push(fit.propagate("T_R", real_pole));
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

fn real_zero(model: &TransferFunction) -> Option<f64> {
    match model.numerator[..] {
        [Section::First(rate)] if rate > 0.0 => Some(rate),
        _ => None,
    }
}

fn oscillation(model: &TransferFunction) -> Option<(f64, f64)> {
    match model.denominator[..] {
        [Section::Second { c1, c0 }] if c0 > 0.0 => Some((c1, c0)),
        _ => None,
    }
}

/// Time constant of the only real pole, of a form that holds an oscillation as well.
fn real_pole(model: &TransferFunction) -> Option<f64> {
    let rates = model.denominator.iter().filter_map(|section| match section {
        Section::First(rate) => Some(*rate),
        Section::Second { .. } => None,
    });
    match rates.collect::<Vec<f64>>()[..] {
        [rate] if rate > 0.0 => Some(rate.recip()),
        _ => None,
    }
}
