//! Independent checks of every window: the same derivatives by other methods.

use std::sync::Arc;

use doublet_core::estimate::{
    Fit, FlightFitError, FlightFreedom, FlightOutput, FlightOutputFit, FlightWindow, FrequencySettings,
    FrequencyWindow, MotionAxis, OutputErrorSettings, flight_output_error, frequency_equation_error,
};
use doublet_core::model::{Coefficient, Derivatives, Term, Variable, VariableValues, regressors, specific_force_at_cg};
use doublet_core::reconstruct::{Reconstruction, State};
use doublet_core::replay::{Replay, Start};
use doublet_core::series::Series;
use rayon::prelude::*;

use super::{StudyError, StudyWindow, Subject, Watch};
use crate::graph::Footprint;
use crate::session::{PathSource, Surface};

/// A derivative by one method.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedDerivative {
    /// Derivative.
    pub name: String,
    /// Estimate.
    pub estimate: f64,
    /// Standard error: of independent frequencies, or corrected for coloured residuals.
    pub standard_error: f64,
}

/// One output of the followed flight.
#[derive(Clone, Debug)]
pub struct FollowedOutput {
    /// Output.
    pub output: FlightOutput,
    /// As reconstructed.
    pub measured: Series,
    /// As flown by the estimated derivatives, recorded bias included.
    pub flown: Series,
    /// Coefficient of determination.
    pub r_squared: f64,
}

/// Output error over one window.
#[derive(Clone, Debug)]
pub struct FollowedFlight {
    /// Motion that was followed.
    pub axis: MotionAxis,
    /// Derivatives that were free.
    pub derivatives: Vec<CheckedDerivative>,
    /// Initial states and biases.
    pub others: Vec<CheckedDerivative>,
    /// Outputs.
    pub outputs: Vec<FollowedOutput>,
    /// Steps it took.
    pub iterations: usize,
}

/// Checks of one window.
#[derive(Clone, Debug)]
pub struct WindowChecks {
    /// Window.
    pub window: String,
    /// Equation error in the frequency domain, coefficient by coefficient, or one line why there is none.
    pub frequency: Vec<(Coefficient, Result<Vec<CheckedDerivative>, String>)>,
    /// Output error in the time domain, or one line why there is none; one per axis the window tells about.
    pub output_error: Vec<(MotionAxis, Result<FollowedFlight, String>)>,
}

/// Checks of all windows.
#[derive(Clone, Debug, Default)]
pub struct CheckStudy {
    /// One entry per window not ignored.
    pub windows: Vec<WindowChecks>,
}

impl Footprint for CheckStudy {
    fn bytes(&self) -> usize {
        let flights = self.windows.iter().flat_map(|window| &window.output_error);
        let samples = |flight: &FollowedFlight| flight.outputs.iter().map(|o| o.flown.values.len() * 24).sum::<usize>();
        flights.filter_map(|(_, flight)| flight.as_ref().ok()).map(samples).sum::<usize>() + 4096 * self.windows.len()
    }
}

/// Estimates every window again in the frequency domain and by output error with the equations of motion.
///
/// # Errors
/// That it was stopped.
pub fn checks(subject: &Subject<'_>, watch: &Watch<'_>) -> Result<CheckStudy, StudyError> {
    let watch = watch.parts(subject.windows.len());
    let one = |window: &StudyWindow<'_>| {
        watch.checkpoint()?;
        let own = window.fits.fits.iter().filter_map(|fit| Some((fit.coefficient, fit.fit.as_ref().ok()?)));
        let frequency = own.map(|(coefficient, fit)| (coefficient, in_frequency(subject, window, coefficient, fit)));
        let frequency = frequency.collect();
        let follow = |&axis: &MotionAxis| (axis, followed(subject, window, axis, &watch));
        let output_error = axes(window.manoeuvre.surface).iter().map(follow).collect();
        watch.checkpoint()?;
        watch.step();
        Ok(WindowChecks { window: window.manoeuvre.name.clone(), frequency, output_error })
    };
    Ok(CheckStudy { windows: subject.windows.par_iter().map(one).collect::<Result<_, StudyError>>()? })
}

/// Motion a manoeuvre of `surface` tells about.
fn axes(surface: Option<Surface>) -> &'static [MotionAxis] {
    match surface {
        Some(Surface::Elevator) => &[MotionAxis::Longitudinal],
        Some(Surface::Aileron | Surface::Rudder) => &[MotionAxis::Lateral],
        None => &[MotionAxis::Longitudinal, MotionAxis::Lateral],
    }
}

/// Coefficients that move one axis.
fn of_axis(axis: MotionAxis) -> &'static [Coefficient] {
    match axis {
        MotionAxis::Longitudinal => {
            &[Coefficient::CX, Coefficient::CZ, Coefficient::Cm, Coefficient::CD, Coefficient::CL]
        }
        MotionAxis::Lateral => &[Coefficient::CY, Coefficient::Cl, Coefficient::Cn],
    }
}

/// Terms of the structure that the window's own fit has.
fn fitted_terms(subject: &Subject<'_>, coefficient: Coefficient, fit: &Fit) -> Vec<Term> {
    let terms = subject.session.structure.terms(coefficient).unwrap_or_default();
    terms.iter().filter(|term| fit.names.contains(&term.derivative_name(coefficient))).cloned().collect()
}

/// Equation error in the frequency domain from twice the lowest frequency the window resolves, at the frequencies it resolves:
/// each adds information of its own, so that the standard errors need no correction.
fn in_frequency(
    subject: &Subject<'_>,
    window: &StudyWindow<'_>,
    coefficient: Coefficient,
    fit: &Fit,
) -> Result<Vec<CheckedDerivative>, String> {
    let aero = &window.aero;
    let terms: Vec<Term> =
        fitted_terms(subject, coefficient, fit).into_iter().filter(|term| !term.is_constant()).collect();
    let names: Vec<String> = terms.iter().map(|term| term.derivative_name(coefficient)).collect();
    let x = regressors(&terms, &aero.variables).map_err(|error| error.to_string())?;
    let time_s = &aero.coefficients.time_s;
    let duration_s = time_s[time_s.len() - 1] - time_s[0];
    let step_s = duration_s / (time_s.len() - 1) as f64;
    let defaults = FrequencySettings::default();
    let settings = FrequencySettings {
        lowest_hz: (2.0 / duration_s).max(defaults.lowest_hz),
        step_hz: 1.0 / duration_s,
        ..defaults
    };
    let window = FrequencyWindow { step_s, x, z: aero.coefficients.get(coefficient).to_vec() };
    let found = frequency_equation_error(&names, &[window], &settings).map_err(|error| error.to_string())?;
    let rows = found.names.iter().zip(&found.estimates).zip(&found.standard_errors);
    Ok(rows
        .map(|((name, &estimate), &standard_error)| CheckedDerivative { name: name.clone(), estimate, standard_error })
        .collect())
}

/// Output error over one window: derivatives its own fit has are free, those it cannot tell about stay as pooled.
fn followed(
    subject: &Subject<'_>,
    window: &StudyWindow<'_>,
    axis: MotionAxis,
    watch: &Watch<'_>,
) -> Result<FollowedFlight, String> {
    let session = subject.session;
    let (aero, path) = (&window.aero, &window.path.reconstruction);
    let states = match (session.preparation.path, &path.smoothed) {
        (PathSource::Smoothed, Some(smoothed)) => &smoothed.states,
        _ => &path.states,
    };
    // Coefficients begin where the filter has settled.
    let first = path.time_s.partition_point(|&time| time < aero.data.time_s[0]);
    let state = |state: State| &states[state as usize][first..];
    let wind = [State::WindNorth, State::WindEast, State::WindDown].map(|wind| state(wind).to_vec());
    let gravity = session.filter.gravity_m_s2;
    let replay = Replay::new(&aero.data, &aero.settings, &wind, gravity).map_err(|error| error.to_string())?;
    let at_start = |of: [State; 3]| of.map(|of| state(of)[0]);
    let start = Start {
        position_ned_m: at_start([State::PositionNorth, State::PositionEast, State::PositionDown]),
        air_velocity_body_m_s: at_start([State::VelocityU, State::VelocityV, State::VelocityW]),
        euler_rad: at_start([State::BankAngle, State::PitchAngle, State::HeadingAngle]),
        rates_rad_s: aero.data.rates_rad_s.each_ref().map(|rate| rate[0]),
    };
    let (model, shared) = model(subject, window, axis);
    if shared.is_empty() {
        return Err("the window has no fit of this axis to start from".to_owned());
    }
    let biases = match axis {
        MotionAxis::Longitudinal => vec![FlightOutput::SpecificForceX, FlightOutput::SpecificForceZ],
        MotionAxis::Lateral => vec![FlightOutput::SpecificForceY],
    };
    let measured = measured(axis, aero, path, first, states)?;
    let windows = [FlightWindow { label: window.manoeuvre.name.clone(), replay: &replay, start, model, measured }];
    let freedom = FlightFreedom { shared, own: Vec::new(), biases };
    let go_on = || !watch.control().is_cancelled();
    let found = flight_output_error(axis, &windows, &freedom, &OutputErrorSettings::default(), &go_on);
    found.map(|found| flight(axis, aero, &windows[0].measured, &freedom, &found)).map_err(|error| match error {
        FlightFitError::Stopped => "stopped".to_owned(),
        error => error.to_string(),
    })
}

/// Recorded outputs of an axis, a column each.
fn measured(
    axis: MotionAxis,
    aero: &crate::stage::WindowAero,
    path: &Reconstruction,
    first: usize,
    states: &[Vec<f64>],
) -> Result<Vec<Vec<f64>>, String> {
    let data = &aero.data;
    let forces = specific_force_at_cg(data, &aero.settings).map_err(|error| error.to_string())?;
    let state = |state: State| &states[state as usize][first..path.time_s.len()];
    let column = |output: &FlightOutput| -> &[f64] {
        match output {
            FlightOutput::Airspeed => &data.airspeed_m_s,
            FlightOutput::Alpha => &data.alpha_rad,
            FlightOutput::Beta => &data.beta_rad,
            FlightOutput::RollRate => &data.rates_rad_s[0],
            FlightOutput::PitchRate => &data.rates_rad_s[1],
            FlightOutput::YawRate => &data.rates_rad_s[2],
            FlightOutput::BankAngle => state(State::BankAngle),
            FlightOutput::PitchAngle => state(State::PitchAngle),
            FlightOutput::SpecificForceX => &forces[0],
            FlightOutput::SpecificForceY => &forces[1],
            FlightOutput::SpecificForceZ => &forces[2],
        }
    };
    Ok(axis.outputs().iter().map(|output| column(output).to_vec()).collect())
}

/// The pooled model with constants of this window, and the entries of `axis` that the window's own fit has.
fn model(subject: &Subject<'_>, window: &StudyWindow<'_>, axis: MotionAxis) -> (Derivatives, Vec<usize>) {
    let mut entries: Vec<(Coefficient, Term, f64)> = Vec::new();
    let mut free = Vec::new();
    for (coefficient, terms) in &subject.session.structure.models {
        let own = window.fits.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let own = own.and_then(|fit| fit.fit.as_ref().ok());
        let pooled = subject.pooled.fits.iter().find(|fit| fit.coefficient == *coefficient);
        let pooled = pooled.and_then(|fit| fit.fit.as_ref().ok());
        for term in terms.iter().filter(|term| !term.is_constant()) {
            let name = term.derivative_name(*coefficient);
            let value =
                pooled.and_then(|fit| fit.parameter(&name)).or_else(|| own.and_then(|fit| fit.parameter(&name)));
            let is_fitted = own.is_some_and(|fit| fit.parameter(&name).is_some());
            if is_fitted && of_axis(axis).contains(coefficient) {
                free.push(entries.len());
            }
            entries.push((*coefficient, term.clone(), value.map_or(0.0, |(value, _)| value)));
        }
        // The constant that goes with the pooled derivatives here: without it the flight would not be in trim.
        if terms.iter().any(Term::is_constant) {
            if own.is_some() && of_axis(axis).contains(coefficient) {
                free.push(entries.len());
            }
            entries.push((*coefficient, Term::constant(), 0.0));
            let value = mean_offset(window, *coefficient, &entries);
            if let Some(entry) = entries.last_mut() {
                entry.2 = value;
            }
        }
    }
    (entries.into_iter().collect(), free)
}

/// Mean of the observed coefficient less what the entries of it give.
fn mean_offset(window: &StudyWindow<'_>, coefficient: Coefficient, entries: &[(Coefficient, Term, f64)]) -> f64 {
    let model: Derivatives = entries.iter().filter(|(other, ..)| *other == coefficient).cloned().collect();
    let aero = &window.aero;
    let observed = aero.coefficients.get(coefficient);
    let known: Vec<_> = aero.variables.known().filter_map(|v| Some((v, aero.variables.get(v)?))).collect();
    let mut sum = 0.0;
    for (k, value) in observed.iter().enumerate() {
        let mut values: VariableValues = [0.0; Variable::ALL.len()];
        for (variable, column) in &known {
            values[*variable as usize] = column[k];
        }
        sum += value - model.sums(&values)[coefficient as usize];
    }
    sum / observed.len() as f64
}

fn flight(
    axis: MotionAxis,
    aero: &crate::stage::WindowAero,
    measured: &[Vec<f64>],
    freedom: &FlightFreedom,
    found: &FlightOutputFit,
) -> FollowedFlight {
    let fit = &found.fit;
    let rows = fit.names.iter().zip(&fit.estimates).zip(&found.corrected_errors);
    let mut derivatives: Vec<_> = rows
        .map(|((name, &estimate), &standard_error)| CheckedDerivative { name: name.clone(), estimate, standard_error })
        .collect();
    let others = derivatives.split_off(freedom.shared.len());
    let time_s: Arc<[f64]> = aero.data.time_s.as_slice().into();
    let series = |values: Arc<[f64]>| Series { time_s: Arc::clone(&time_s), values };
    let outputs = axis.outputs().iter().enumerate().map(|(index, &output)| FollowedOutput {
        output,
        measured: series(measured[index].as_slice().into()),
        flown: series(fit.outputs.column(index).iter().copied().collect()),
        r_squared: fit.quality[index].r_squared,
    });
    FollowedFlight { axis, derivatives, others, outputs: outputs.collect(), iterations: fit.cost.len() - 1 }
}
