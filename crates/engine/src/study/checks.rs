//! Independent checks of every window: the same derivatives by other methods.

use doublet_core::estimate::{Fit, FrequencySettings, FrequencyWindow, frequency_equation_error};
use doublet_core::model::{Coefficient, Term, regressors};
use doublet_core::replay::MotionAxis;
use rayon::prelude::*;

use super::StudyInput;
use super::followed::{FollowedFlight, follow};
use crate::graph::{Context, Footprint, Stage, StageResult};
use crate::session::Surface;
use crate::stage::StudyWindow;
use crate::verdict::{Finding, Level};

/// A derivative by one method.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedDerivative {
    /// Derivative.
    pub name: String,
    /// Estimate.
    pub estimate: f64,
    /// Standard error: of independent frequencies, or corrected for correlated residuals.
    pub standard_error: f64,
}

/// What is checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct CheckRequest {
    /// Motion that output error follows; none: that of each window's surface.
    pub axis: Option<MotionAxis>,
    /// Whether each window is estimated by filter error, too: several times the work of output error.
    pub filter_error: bool,
}

/// Checks of one window.
#[derive(Clone, Debug)]
pub struct WindowChecks {
    /// Window.
    pub window: String,
    /// Equation error in the frequency domain, coefficient by coefficient, or one line why there is none.
    pub frequency: Vec<(Coefficient, StageResult<Vec<CheckedDerivative>>)>,
    /// Output error in the time domain, or one line why there is none; one per axis the window tells about.
    pub output_error: Vec<(MotionAxis, StageResult<FollowedFlight>)>,
}

/// Checks of all windows.
#[derive(Clone, Debug, Default)]
pub struct CheckStudy {
    /// What was asked for.
    pub request: CheckRequest,
    /// One entry per window not ignored.
    pub windows: Vec<WindowChecks>,
}

impl CheckStudy {
    /// Output errors that do not follow their recordings, window by window.
    pub fn findings(&self) -> Vec<Finding> {
        self.windows.iter().flat_map(WindowChecks::findings).collect()
    }
}

impl WindowChecks {
    /// Output errors of this window that do not follow its recording (`follows`), or that there is none.
    pub fn findings(&self) -> Vec<Finding> {
        let of_axis = |(axis, found): &(MotionAxis, StageResult<FollowedFlight>)| match found {
            Ok(flight) => flight.findings(&self.window),
            Err(error) => {
                let place = format!("manoeuvre '{}', output error ({})", self.window, axis.name());
                vec![Finding::new(Level::Caution, "follows", place, format!("Output error failed: {error}."))]
            }
        };
        self.output_error.iter().flat_map(of_axis).collect()
    }
}

impl Footprint for CheckStudy {
    fn bytes(&self) -> usize {
        let flights = self.windows.iter().flat_map(|window| &window.output_error);
        let samples = |flight: &FollowedFlight| flight.outputs.iter().map(|o| o.flown.values.len() * 24).sum::<usize>();
        flights.filter_map(|(_, flight)| flight.as_ref().ok()).map(samples).sum::<usize>() + 4096 * self.windows.len()
    }
}

/// Estimates every window again in the frequency domain and by output error with the equations of motion, of the axis asked for or the
/// motion its surface moves, and where asked by filter error.
impl Stage for CheckStudy {
    type Params<'a> = CheckRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "independent checks";

    fn run(request: CheckRequest, input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let context = context.parts(input.windows.len());
        let one = |window: &StudyWindow<'_>| {
            context.checkpoint()?;
            let own = window.fits.fits.iter().filter_map(|fit| Some((fit.coefficient, fit.fit.as_ref().ok()?)));
            let frequency = own.map(|(coefficient, fit)| (coefficient, in_frequency(input, window, coefficient, fit)));
            let frequency = frequency.collect();
            let follow = |&axis: &MotionAxis| (axis, follow(input, window, (axis, request.filter_error), &context));
            let motions = request.axis.as_ref().map_or_else(|| axes(window.manoeuvre.surface), std::slice::from_ref);
            let output_error = motions.iter().map(follow).collect();
            context.checkpoint()?;
            context.step();
            Ok(WindowChecks { window: window.manoeuvre.name.clone(), frequency, output_error })
        };
        Ok(CheckStudy { request, windows: input.windows.par_iter().map(one).collect::<StageResult<_>>()? })
    }
}

/// Motion a manoeuvre of `surface` tells about.
fn axes(surface: Option<Surface>) -> &'static [MotionAxis] {
    match surface {
        Some(Surface::Elevator) => &[MotionAxis::Longitudinal],
        Some(Surface::Aileron | Surface::Rudder) => &[MotionAxis::Lateral],
        None => &[MotionAxis::Longitudinal, MotionAxis::Lateral],
    }
}

/// Terms of the structure that the window's own fit has.
fn fitted_terms(input: &StudyInput<'_>, coefficient: Coefficient, fit: &Fit) -> Vec<Term> {
    let terms = input.settings.structure.terms(coefficient).unwrap_or_default();
    terms.iter().filter(|term| fit.names.contains(&term.derivative_name(coefficient))).cloned().collect()
}

/// Equation error in the frequency domain from twice the lowest frequency the window resolves, at the frequencies it resolves:
/// each adds information of its own, so that the standard errors need no correction. Of a window with excluded stretches the longest
/// part without one counts.
fn in_frequency(
    input: &StudyInput<'_>,
    window: &StudyWindow<'_>,
    coefficient: Coefficient,
    fit: &Fit,
) -> StageResult<Vec<CheckedDerivative>> {
    let aero = &window.aero;
    let terms: Vec<Term> =
        fitted_terms(input, coefficient, fit).into_iter().filter(|term| !term.is_constant()).collect();
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
    Ok(rows
        .map(|((name, &estimate), &standard_error)| CheckedDerivative { name: name.clone(), estimate, standard_error })
        .collect())
}
