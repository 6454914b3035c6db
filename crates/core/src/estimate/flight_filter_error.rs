//! Filter error with the equations of motion: derivatives of a flight that gusts move.

use std::ops::Range;

use nalgebra::DMatrix;

use super::flight_output_error::{Flown, Prepared, Problem};
use super::steady_filter::{ProcessNoise, Steady, first_deviation, settle_noise};
use super::{
    EstimateError, FlightFitError, FlightFreedom, FlightOutput, FlightOutputFit, FlightWindow, OutputErrorSettings,
    OutputParameter, output_error,
};
use crate::replay::{MotionAxis, Response};
use crate::statistics::{median, median_step};

/// Result of filter error of flights.
#[derive(Clone, Debug)]
pub struct FlightFilterFit {
    /// Estimates as those of output error, then the logarithms of the process noise. Its outputs are predictions, its residuals
    /// innovations.
    pub estimate: FlightOutputFit,
    /// Process noise of `u w q theta` or `v p r phi`.
    pub process_noise: Vec<ProcessNoise>,
    /// Standard deviation of the measurement noise of each output.
    pub measurement_noise: Vec<f64>,
}

/// Filter error in the time domain (Jategaonkar, Flight Vehicle System Identification, 2nd edition, chapter 5): noise `F dw`, `F`
/// diagonal and the same in all windows, drives the states of `axis`, and the outputs are predicted from the recorded ones before them
/// by a filter of constant gain `K = P C' (C P C' + R)^-1`. `P` is the steady covariance of the predicted states at the start of the
/// window (discrete Riccati equation; `A` and `C` by central differences there, the median step). Derivatives, starts and biases are
/// those of [`super::flight_output_error`], and so is the Gauss-Newton search, which minimises `ln |S|` with `S` the diagonal
/// covariance of the innovations; `R` follows in rounds from `R <- R S / (C P C' + R)`, no
/// deviation below `least`: recorded columns that were smoothed show no noise of their own. Outputs of an excluded sample correct nothing.
///
/// What gusts add to the motion is in `F` instead of the derivatives, which output error cannot tell apart. `start` are estimates of
/// output error with the same freedom. `go_on` is asked before every flight.
///
/// # Errors
/// As for [`super::flight_output_error`]; a filter or a noise that does not settle; [`MotionAxis::Both`].
pub fn flight_filter_error(
    axis: MotionAxis,
    (windows, freedom): (&[FlightWindow<'_>], &FlightFreedom),
    (start, least): (&[f64], &[f64]),
    settings: &OutputErrorSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<FlightFilterFit, FlightFitError> {
    let states = states_of(axis)?;
    let problem = Problem { axis, windows, freedom };
    let Prepared { mut parameters, samples, measured } = problem.prepare()?;
    if start.len() != parameters.len() {
        let (expected, found) = (parameters.len(), start.len());
        return Err(EstimateError::Size { quantity: "estimates to start from", expected, found }.into());
    }
    parameters.iter_mut().zip(start).for_each(|(parameter, value)| parameter.start = *value);
    let first_log = parameters.len();
    let noise =
        first_noise(&problem).into_iter().zip(least).map(|(noise, least)| noise.max(*least)).collect::<Vec<_>>();
    let mut steps: Vec<f64> = windows.iter().filter_map(|window| median_step(window.replay.time_s())).collect();
    let step_s = median(&mut steps).unwrap_or(f64::NAN);
    parameters.extend(noise_parameters((axis, states), windows, &noise, step_s));
    let mut flown: Vec<Option<(Vec<f64>, DMatrix<f64>)>> = windows.iter().map(|_| None).collect();
    let (fit, measurement_noise) = settle_noise(&mut parameters, (noise, least), |parameters, noise| {
        flown.iter_mut().for_each(|flown| *flown = None);
        let predictor = Predictor { problem: &problem, noise, step_s };
        let fit = output_error(parameters, &measured, settings, |theta| {
            predictor.predict((theta, first_log), &samples, &mut flown, go_on)
        })?;
        let first = problem.of_window(0, &fit.estimates[..first_log]);
        let steady = predictor.steady(0, &problem.with_parameters(0, &first), &fit.estimates[first_log..])?;
        Ok::<_, FlightFitError>((fit, steady.deviations()))
    })?;
    if !go_on() {
        return Err(FlightFitError::Stopped);
    }
    let process_noise = ProcessNoise::list(&states, &parameters[first_log..], &fit);
    let estimate = FlightOutputFit::new(fit, &measured, samples)?;
    Ok(FlightFilterFit { estimate, process_noise, measurement_noise })
}

/// Names of the states that noise drives.
fn states_of(axis: MotionAxis) -> Result<[&'static str; 4], FlightFitError> {
    match axis {
        MotionAxis::Longitudinal => Ok(["u", "w", "q", "theta"]),
        MotionAxis::Lateral => Ok(["v", "p", "r", "phi"]),
        MotionAxis::Both => Err(FlightFitError::OneAxis),
    }
}

/// Standard deviation of the white noise of each output, the largest of the windows.
fn first_noise(problem: &Problem<'_>) -> Vec<f64> {
    let outputs = problem.axis.outputs().iter().enumerate();
    outputs.map(|(index, output)| largest_deviation(problem, index, *output)).collect()
}

fn largest_deviation(problem: &Problem<'_>, index: usize, output: FlightOutput) -> f64 {
    let deviations = problem
        .windows
        .iter()
        .map(|window| first_deviation(window.replay.time_s(), &window.measured[index], output.scale()));
    deviations.fold(0.0, f64::max)
}

/// Logarithms of the process noise as parameters.
fn noise_parameters(
    (axis, states): (MotionAxis, [&str; 4]),
    windows: &[FlightWindow<'_>],
    noise: &[f64],
    step_s: f64,
) -> Vec<OutputParameter> {
    let airspeed = windows.first().map_or(1.0, |window| window.start.air_velocity_body_m_s[0]);
    // Outputs begin with V alpha q theta, or beta p r phi.
    let measured = match axis {
        MotionAxis::Lateral => [airspeed * noise[0], noise[1], noise[2], noise[3]],
        _ => [noise[0], airspeed * noise[1], noise[2], noise[3]],
    };
    states.iter().zip(measured).map(|(state, measured)| ProcessNoise::parameter(state, measured, step_s)).collect()
}

/// Flights predicted with one measurement noise.
struct Predictor<'a> {
    problem: &'a Problem<'a>,
    noise: &'a [f64],
    step_s: f64,
}

impl Predictor<'_> {
    /// Predicted outputs of all windows, one below the other; what was flown with the same parameters is taken from `flown`.
    fn predict(
        &self,
        (theta, first_log): (&[f64], usize),
        samples: &[Range<usize>],
        flown: &mut [Option<(Vec<f64>, DMatrix<f64>)>],
        go_on: &dyn Fn() -> bool,
    ) -> Result<DMatrix<f64>, FlightFitError> {
        let (theta, logs) = theta.split_at(first_log);
        let total = samples.last().map_or(0, |range| range.end);
        let mut all = DMatrix::zeros(total, self.noise.len());
        for (index, (range, flown)) in samples.iter().zip(flown).enumerate() {
            let own = [&self.problem.of_window(index, theta), logs].concat();
            if !flown.as_ref().is_some_and(|(known, _)| *known == own) {
                if !go_on() {
                    return Err(FlightFitError::Stopped);
                }
                let outputs = self.predict_window(index, &own[..own.len() - logs.len()], logs)?;
                *flown = Some((own, outputs));
            }
            if let Some((_, outputs)) = flown {
                all.rows_mut(range.start, range.len()).copy_from(outputs);
            }
        }
        Ok(all)
    }

    fn predict_window(&self, index: usize, own: &[f64], logs: &[f64]) -> Result<DMatrix<f64>, FlightFitError> {
        let flown = self.problem.with_parameters(index, own);
        let Steady { gain, .. } = self.steady(index, &flown, logs)?;
        let (window, outputs) = (&self.problem.windows[index], self.problem.axis.outputs());
        let mut correct = |sample: usize, response: &Response| {
            let force = self.problem.force_at(index, response, sample, sample);
            let mut change = [0.0; 4];
            for (place, output) in outputs.iter().enumerate() {
                let innovation =
                    window.measured[place][sample] - output.at(response, sample, force) - flown.biases[place];
                if innovation.is_finite() {
                    change.iter_mut().enumerate().for_each(|(state, sum)| *sum += gain[(state, place)] * innovation);
                }
            }
            change
        };
        let response =
            window.replay.predict_axis(self.problem.axis, &flown.model, &flown.start, window.motion, &mut correct)?;
        Ok(self.problem.outputs_of(index, &response, &flown.biases))
    }

    /// The filter at the start of a window.
    fn steady(&self, index: usize, flown: &Flown, logs: &[f64]) -> Result<Steady, FlightFitError> {
        let (window, outputs) = (&self.problem.windows[index], self.problem.axis.outputs());
        let show = |response: &Response| {
            let force = self.problem.force_at(index, response, 0, 0);
            outputs.iter().map(|output| output.at(response, 0, force)).collect()
        };
        let (a, c) =
            window.replay.linearise_axis(self.problem.axis, &flown.model, &flown.start, window.motion, &show)?;
        Ok(Steady::new(&a, &c, (logs, self.noise), self.step_s)?)
    }
}
