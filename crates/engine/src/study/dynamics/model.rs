//! The identified model of a session as an aircraft to trim.

use doublet_core::model::{Coefficient, Derivatives, Engine, Structure};
use doublet_dynamics::linear::{FlightModel, ThrustLine, UncertainModel};
use nalgebra::DMatrix;

use super::{StudyInput, covariance};
use crate::graph::{Context, Footprint, Stage, StageResult};
use crate::session::{Estimation, WindowRole};
use crate::stage::{AeroWindow, CoefficientFit, PooledFits, WindowAero};
use crate::study::{IdentifiedCoefficient, identified};

/// The pooled estimate of a study with the covariance of its derivatives, the same about every trim.
#[derive(Clone, Debug)]
pub struct ModelToTrim {
    pub model: UncertainModel,
    /// What of it is left out, one line each.
    pub notes: Vec<String>,
}

impl Footprint for ModelToTrim {
    fn bytes(&self) -> usize {
        1024 + 8 * self.model.covariance.len()
    }
}

impl Stage for ModelToTrim {
    type Params<'a> = ();
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "model to trim";

    fn run((): (), input: &StudyInput<'_>, _: &Context<'_>) -> StageResult<Self> {
        let mut notes = Vec::new();
        let settings = (input.settings.structure, input.settings.estimation);
        Ok(Self { model: pooled_model(input.pooled, settings, &input.aero(), &mut notes)?, notes })
    }
}

/// The pooled estimate as an aircraft with the geometry and engines of its first window, and the covariance of its derivatives: corrected
/// errors, and correlations within and across coefficients from the residuals as they are. What of it is left out is noted.
pub fn pooled_model(
    pooled: &PooledFits,
    (structure, estimation): (&Structure, &Estimation),
    windows: &[AeroWindow<'_>],
    notes: &mut Vec<String>,
) -> StageResult<UncertainModel> {
    let first = windows.iter().find(|(manoeuvre, _)| manoeuvre.role == WindowRole::Identification);
    let (_, aero) = first.ok_or("no model: no identification manoeuvre has coefficients")?;
    let settings = &aero.settings;
    let mut found = Vec::new();
    for fit in &pooled.fits {
        let terms = structure.terms(fit.coefficient).unwrap_or_default();
        match identified(fit, terms, &settings.reference) {
            Ok(coefficient) => found.push((fit, coefficient)),
            Err(error) => notes.push(error.to_string()),
        }
    }
    if found.is_empty() {
        let line = "no model: no pooled estimate; mark at least one manoeuvre as identification";
        return Err(line.into());
    }
    let pairs: Vec<_> = found.iter().map(|(fit, coefficient)| (*fit, coefficient)).collect();
    let correlation = covariance::correlation(&pairs, windows, (structure, estimation)).unwrap_or_else(|| {
        notes.push("coefficients are treated as independent: their regressors could not be recomputed".to_owned());
        within(&pairs)
    });
    let parameters: Vec<_> = found.iter().flat_map(|(_, coefficient)| &coefficient.parameters).collect();
    let covariance = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        correlation[(i, j)] * parameters[i].standard_error * parameters[j].standard_error
    });
    let names = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let entries = found.iter().flat_map(|(fit, coefficient)| {
        coefficient.parameters.iter().map(|parameter| (fit.coefficient, parameter.term.clone(), parameter.value))
    });
    let derivatives: Derivatives = entries.collect();
    both_forces(&derivatives, notes);
    let model = FlightModel {
        derivatives,
        reference: settings.reference,
        axes: settings.axes,
        moment_reference: settings.moment_reference,
        thrust: settings.thrust,
        engines: thrust_lines(aero),
    };
    Ok(UncertainModel { model, names, covariance })
}

/// Correlations of the regressors within each coefficient, none across.
fn within(fits: &[(&CoefficientFit, &IdentifiedCoefficient)]) -> DMatrix<f64> {
    let size = fits.iter().map(|(_, coefficient)| coefficient.parameters.len()).sum();
    let mut correlation = DMatrix::zeros(size, size);
    let mut start = 0;
    for (_, coefficient) in fits {
        let block = &coefficient.correlation;
        correlation.view_mut((start, start), block.shape()).copy_from(block);
        start += block.nrows();
    }
    correlation
}

/// Says where lift and drag stand beside the forces along body axes, which then fly alone.
fn both_forces(derivatives: &Derivatives, notes: &mut Vec<String>) {
    let has = |coefficient| derivatives.has(coefficient);
    let body = has(Coefficient::CX) || has(Coefficient::CZ);
    if body && (has(Coefficient::CL) || has(Coefficient::CD)) {
        notes.push("CL and CD do not enter: the model has CX or CZ too".to_owned());
    }
}

/// Lines of action of the engines, with the share each has of the mean thrust of a window.
fn thrust_lines(aero: &WindowAero) -> Vec<ThrustLine> {
    let engines = &aero.data.engines;
    let sum = |engine: &Engine| engine.thrust_n.iter().sum::<f64>();
    let total: f64 = engines.iter().map(sum).sum();
    let even = 1.0 / engines.len().max(1) as f64;
    let line = |engine: &Engine| ThrustLine {
        position: engine.position,
        direction_body: engine.direction_body,
        share: if total > 0.0 { sum(engine) / total } else { even },
    };
    engines.iter().map(line).collect()
}
