//! Filter error: parameters of equations of motion that noise drives, such as gusts.

use nalgebra::DMatrix;

use super::fit::{EquationFit, EquationSettings, check, finish};
use super::shooting::{SCALE, Shooting, fly_pieces, lanes};
use super::{EquationFault, EquationModel, EquationPoints, EquationRecord};
use crate::estimate::output_error::output_error_in_lanes;
use crate::estimate::steady_filter::{ProcessNoise, Steady, first_deviation, settle_noise};
use crate::estimate::{EstimateError, OutputParameter};
use crate::statistics::{median, median_step};

/// Estimates of filter error.
#[derive(Clone, Debug)]
pub struct FilterErrorFit {
    /// Parameters, then initial states, then the logarithms of the process noise. Its residuals are the innovations.
    pub estimate: EquationFit,
    /// Process noise of each state.
    pub process_noise: Vec<ProcessNoise>,
    /// Standard deviation of the measurement noise of each output.
    pub measurement_noise: Vec<f64>,
}

/// Filter error (Jategaonkar, Flight Vehicle System Identification, 2nd edition, chapter 5; Maine and Iliff, NASA RP-1168): noise `F dw`, `F`
/// diagonal, drives the states, and the outputs are predicted from the measurements before them by a filter of constant gain
/// `K = P C' (C P C' + R)^-1`. `P` is the steady covariance of the predicted states (discrete Riccati equation) at the mean measured state and
/// the median step of the middle record, `A` and `C` by central differences there. Gauss-Newton as in [`super::output_error_of`] minimises
/// `ln |S|` over the parameters, the initial states and `ln F`, with `S` the diagonal covariance of the innovations in closed form. `R`,
/// diagonal, follows in rounds from `R <- R S / (C P C' + R)` until it is settled.
///
/// A record is predicted from its beginning: the filter holds an unstable motion, and no pieces are needed.
///
/// `start` are values to begin with, for example of [`super::equation_error_of`]; none for those of the model.
///
/// # Errors
/// [`EquationFault`]: a record that does not fit, parameters the data cannot tell apart, an iteration that does not settle.
pub fn filter_error_of(
    model: &EquationModel,
    records: &[EquationRecord],
    settings: &EquationSettings,
    start: Option<&[f64]>,
) -> Result<FilterErrorFit, EquationFault> {
    check(model, records)?;
    let Shooting { pieces, mut parameters, measured, time_s, rows } = Shooting::new(model, records, None, start);
    let first_log = parameters.len();
    let (linearisation, lanes) = (Linearisation::new(model, records), lanes(model, &measured));
    let (noise, least) = (first_noise(model, records), vec![0.0; model.outputs.len()]);
    parameters.extend(noise_parameters(model, &noise, linearisation.step_s));
    let (fit, measurement_noise) = settle_noise(&mut parameters, (noise, &least), |parameters, noise| {
        let find_steady = |theta: &[f64]| linearisation.find_steady(model, theta, (&theta[first_log..], noise));
        let fit = output_error_in_lanes(parameters, &measured, &settings.search, lanes, |several| {
            let steady: Vec<_> = several.iter().map(|theta| find_steady(theta)).collect();
            let mut ready: Vec<(&[f64], Option<&DMatrix<f64>>)> = Vec::with_capacity(several.len());
            for (theta, steady) in several.iter().zip(&steady) {
                ready.extend(steady.as_ref().ok().map(|steady| (theta.as_slice(), Some(&steady.gain))));
            }
            let mut flown = fly_pieces(model, records, &pieces, &ready).into_iter();
            steady.into_iter().map(|steady| steady.map(|_| flown.next().unwrap_or_default())).collect()
        })?;
        let deviations = find_steady(&fit.estimates)?.deviations();
        Ok::<_, EstimateError>((fit, deviations))
    })?;
    let process_noise = ProcessNoise::list(&model.states, &parameters[first_log..], &fit);
    let estimate = finish(model, fit, &measured, model.outputs.clone(), (time_s, rows))?;
    Ok(FilterErrorFit { estimate, process_noise, measurement_noise })
}

/// Standard deviation of the white noise of each output, the largest of the records.
fn first_noise(model: &EquationModel, records: &[EquationRecord]) -> Vec<f64> {
    let of_output = |output: usize| {
        let deviations = records.iter().map(|record| first_deviation(&record.time_s, &record.outputs[output], SCALE));
        deviations.fold(0.0, f64::max)
    };
    (0..model.outputs.len()).map(of_output).collect()
}

/// Logarithms of the process noise as parameters; a state without an output begins as one whose noise is the smallest change that
/// matters.
fn noise_parameters(model: &EquationModel, noise: &[f64], step_s: f64) -> Vec<OutputParameter> {
    let measured = |output: &Option<usize>| output.map_or(SCALE, |output| noise[output]);
    let states = model.states.iter().zip(model.output_of_state.iter().map(measured));
    states.map(|(name, measured)| ProcessNoise::parameter(name, measured, step_s)).collect()
}

/// Where the equations are linearised for the gain.
struct Linearisation {
    /// Mean of the measured states; none for a state that no output is.
    state: Vec<Option<f64>>,
    /// Mean of the inputs.
    input: Vec<f64>,
    /// Median step of the middle record, s.
    step_s: f64,
}

impl Linearisation {
    fn new(model: &EquationModel, records: &[EquationRecord]) -> Self {
        let mean = |column: &dyn Fn(&EquationRecord) -> &Vec<f64>| {
            let values = records.iter().flat_map(column).filter(|value| value.is_finite());
            let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
            sum / count.max(1) as f64
        };
        let state = |output: &Option<usize>| output.map(|output| mean(&|record| &record.outputs[output]));
        let mut steps: Vec<f64> = records.iter().filter_map(|record| median_step(&record.time_s)).collect();
        Self {
            state: model.output_of_state.iter().map(state).collect(),
            input: (0..model.inputs.len()).map(|input| mean(&|record| &record.inputs[input])).collect(),
            step_s: median(&mut steps).unwrap_or(f64::NAN),
        }
    }

    /// Gain and covariance of the innovations with the logarithms of the process noise and the measurement noise.
    fn find_steady(
        &self,
        model: &EquationModel,
        theta: &[f64],
        (logs, noise): (&[f64], &[f64]),
    ) -> Result<Steady, EstimateError> {
        let (count, states) = (model.parameters.len(), model.states.len());
        let initial = &theta[count..count + states];
        let x: Vec<f64> = self.state.iter().zip(initial).map(|(mean, initial)| mean.unwrap_or(*initial)).collect();
        let (a, c) = self.slopes(model, &x, &theta[..count]);
        Steady::new(&a, &c, (logs, noise), self.step_s)
    }

    /// Slopes of rates and outputs with the states.
    fn slopes(&self, model: &EquationModel, x: &[f64], theta: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        /// Step of the differences, as a part of the value.
        const STEP: f64 = 1e-4;
        let (states, outputs) = (x.len(), model.outputs.len());
        let (mut a, mut c) = (DMatrix::zeros(states, states), DMatrix::zeros(outputs, states));
        let step = |state: usize| STEP * x[state].abs().max(SCALE);
        // Each state above its value, then below.
        let column = |state: usize| -> Vec<f64> {
            let moved = |at: usize| match at {
                at if at == 2 * state => x[state] + step(state),
                at if at == 2 * state + 1 => x[state] - step(state),
                _ => x[state],
            };
            (0..2 * states).map(moved).collect()
        };
        let columns: Vec<Vec<f64>> = (0..states).map(column).collect();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let inputs: Vec<Vec<f64>> = self.input.iter().map(|value| vec![*value; 2 * states]).collect();
        let inputs: Vec<&[f64]> = inputs.iter().map(Vec::as_slice).collect();
        let parameters: Vec<&[f64]> = theta.iter().map(std::slice::from_ref).collect();
        let points = EquationPoints { count: 2 * states, states: &columns, inputs: &inputs, parameters: &parameters };
        for (slopes, found) in [(&mut a, model.rates(points)), (&mut c, model.shown(points))] {
            for (row, values) in found.iter().enumerate() {
                for state in 0..states {
                    slopes[(row, state)] = (values[2 * state] - values[2 * state + 1]) / (2.0 * step(state));
                }
            }
        }
        (a, c)
    }
}
