//! The identified model of a session as an aircraft to trim.

use doublet_core::model::{Coefficient, Derivatives, Engine, Structure};
use doublet_dynamics::linear::{FlightModel, ThrustLine, UncertainModel};
use nalgebra::DMatrix;

use super::StudyInput;
use crate::export::identified;
use crate::graph::StageResult;
use crate::session::WindowRole;
use crate::stage::{PooledFits, StudyWindow, WindowAero};

/// The pooled estimate of a study with the covariance of its derivatives.
///
/// # Errors
/// One line: no pooled estimate, or none of any coefficient.
pub fn uncertain_model(input: &StudyInput<'_>, notes: &mut Vec<String>) -> StageResult<UncertainModel> {
    let aero = first_window(input).ok_or("there is no model: no identification window has coefficients")?;
    pooled_model(input.pooled, input.settings.structure, aero, notes)
}

/// The pooled estimate as an aircraft with the geometry and engines of a window, and the covariance of its derivatives: corrected errors
/// and the correlations of the regressors, coefficients independent of each other. What of it is left out is noted.
///
/// # Errors
/// One line where no coefficient has an estimate.
pub fn pooled_model(
    pooled: &PooledFits,
    structure: &Structure,
    aero: &WindowAero,
    notes: &mut Vec<String>,
) -> StageResult<UncertainModel> {
    let settings = &aero.settings;
    let mut entries = Vec::new();
    let (mut names, mut blocks) = (Vec::new(), Vec::new());
    for fit in &pooled.fits {
        let terms = structure.terms(fit.coefficient).unwrap_or_default();
        let coefficient = match identified(fit, terms, &settings.reference) {
            Ok(coefficient) => coefficient,
            Err(error) => {
                notes.push(error.to_string());
                continue;
            }
        };
        let errors = &coefficient.parameters;
        let block = DMatrix::from_fn(errors.len(), errors.len(), |i, j| {
            coefficient.correlation[(i, j)] * errors[i].standard_error * errors[j].standard_error
        });
        blocks.push(block);
        for parameter in coefficient.parameters {
            names.push(parameter.name);
            entries.push((fit.coefficient, parameter.term, parameter.value));
        }
    }
    if entries.is_empty() {
        let line =
            "there is no model: no coefficient has a pooled estimate; mark at least one window as identification";
        return Err(line.into());
    }
    let mut covariance = DMatrix::zeros(names.len(), names.len());
    let mut start = 0;
    for block in blocks {
        covariance.view_mut((start, start), block.shape()).copy_from(&block);
        start += block.nrows();
    }
    let derivatives: Derivatives = entries.into_iter().collect();
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

/// Says where lift and drag stand beside the forces along body axes, which then fly alone.
fn both_forces(derivatives: &Derivatives, notes: &mut Vec<String>) {
    let has = |coefficient| derivatives.has(coefficient);
    let body = has(Coefficient::CX) || has(Coefficient::CZ);
    if body && (has(Coefficient::CL) || has(Coefficient::CD)) {
        notes.push("CL and CD do not enter: the model has CX or CZ too".to_owned());
    }
}

/// Coefficients of the first identification window that has them.
fn first_window<'a>(input: &'a StudyInput<'_>) -> Option<&'a WindowAero> {
    let identification = |window: &&StudyWindow<'_>| window.manoeuvre.role == WindowRole::Identification;
    input.windows.iter().find(identification).map(|window| &*window.aero)
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
