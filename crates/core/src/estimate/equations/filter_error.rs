//! Filter error: parameters of equations of motion that noise drives, such as gusts.

use nalgebra::DMatrix;

use super::fit::{EquationFit, EquationSettings, check, finish};
use super::shooting::{SCALE, Shooting, integrate};
use super::{EquationFault, EquationModel, EquationRecord};
use crate::estimate::{EstimateError, OutputErrorFit, OutputParameter, output_error};
use crate::prep::white_noise_deviation;
use crate::series::Series;
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

/// Noise that drives a state: `dx = f dt + intensity dw`.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessNoise {
    /// State.
    pub state: String,
    /// Unit of the state per root second.
    pub intensity: f64,
    /// Standard error of its logarithm.
    pub log_error: f64,
    /// Whether it lies at the lower end of its range: the data show none.
    pub is_none: bool,
}

/// Rounds of measurement noise and parameters at most.
const ROUNDS: usize = 12;
/// Change of a standard deviation below which the measurement noise counts as settled.
const SETTLED: f64 = 0.01;
/// Prediction error at the start of the search, as a part of the variance of the measurement noise.
const FIRST_PART: f64 = 0.1;
/// Logarithm of the range of the process noise below and above its start.
const RANGE: (f64, f64) = (5.0, 9.0);

/// Filter error (Jategaonkar, Flight Vehicle System Identification, 2nd edition, chapter 5; Maine and Iliff, NASA RP-1168): noise `F dw`, `F`
/// diagonal, drives the states, and the outputs are predicted from the measurements before them by a filter of constant gain
/// `K = P C' (C P C' + R)^-1`. `P` is the steady covariance of the predicted states (discrete Riccati equation) at the mean measured state and
/// the median step of the middle record, `A` and `C` by central differences there. Gauss-Newton as in [`output_error`] minimises `ln |S|` over the parameters, the
/// initial states and `ln F`, with `S` the diagonal covariance of the innovations in closed form. `R`, diagonal, follows in rounds from
/// `R <- R S / (C P C' + R)` until it is settled.
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
    let (count, states) = (model.parameters.len(), model.states.len());
    let first_log = parameters.len();
    let linearisation = Linearisation::new(model, records);
    let mut noise = first_noise(model, records);
    parameters.extend(noise_parameters(model, &noise, linearisation.step_s));
    let mut rounds = 0;
    let (fit, measurement_noise) = loop {
        let fit = output_error(&parameters, &measured, &settings.search, |theta| {
            let steady = linearisation.find_steady(model, theta, (&theta[first_log..], &noise))?;
            let mut all = DMatrix::zeros(measured.nrows(), model.outputs.len());
            for (index, piece) in pieces.iter().enumerate() {
                let initial = &theta[count + index * states..count + (index + 1) * states];
                let own = (&theta[..count], initial);
                let flown = integrate(model, &records[piece.record], &piece.samples, own, Some(&steady.gain));
                all.rows_mut(piece.first_row, flown.nrows()).copy_from(&flown);
            }
            Ok::<_, EstimateError>(all)
        })?;
        let steady = linearisation.find_steady(model, &fit.estimates, (&fit.estimates[first_log..], &noise))?;
        let next: Vec<f64> = (0..noise.len())
            .map(|output| noise[output] * fit.noise[output] / steady.innovation[(output, output)].sqrt())
            .collect();
        let is_settled = next.iter().zip(&noise).all(|(next, noise)| (next / noise - 1.0).abs() < SETTLED);
        rounds += 1;
        if is_settled {
            break (fit, next);
        }
        if rounds == ROUNDS {
            return Err(EstimateError::NotConverged { method: "filter error", iterations: ROUNDS }.into());
        }
        parameters.iter_mut().zip(&fit.estimates).for_each(|(parameter, value)| parameter.start = *value);
        noise = next;
    };
    let process_noise = list_process_noise(model, &parameters, &fit, first_log);
    let estimate = finish(model, fit, &measured, model.outputs.clone(), (time_s, rows))?;
    Ok(FilterErrorFit { estimate, process_noise, measurement_noise })
}

/// The process noise of each state from the logarithms at `first` and behind.
fn list_process_noise(
    model: &EquationModel,
    parameters: &[OutputParameter],
    fit: &OutputErrorFit,
    first: usize,
) -> Vec<ProcessNoise> {
    let of_state = |(state, name): (usize, &String)| ProcessNoise {
        state: name.clone(),
        intensity: fit.estimates[first + state].exp(),
        log_error: fit.standard_errors[first + state],
        is_none: fit.at_bound[first + state] && fit.estimates[first + state] <= parameters[first + state].bounds.0,
    };
    model.states.iter().enumerate().map(of_state).collect()
}

/// Standard deviation of the white noise of each output, the largest of the records; a small part of its motion where none shows.
fn first_noise(model: &EquationModel, records: &[EquationRecord]) -> Vec<f64> {
    /// Part of the motion.
    const PART: f64 = 1e-3;
    let of_record = |record: &EquationRecord, output: usize| {
        let values = &record.outputs[output];
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let range = finite.fold(None, |range: Option<(f64, f64)>, value| {
            Some(range.map_or((value, value), |(least, most)| (least.min(value), most.max(value))))
        });
        let motion = range.map_or(0.0, |(least, most)| PART * (most - least)).max(PART * SCALE);
        let series = Series { time_s: record.time_s.as_slice().into(), values: values.as_slice().into() };
        white_noise_deviation(&series, false).unwrap_or(0.0).max(motion)
    };
    (0..model.outputs.len())
        .map(|output| records.iter().map(|record| of_record(record, output)).fold(0.0, f64::max))
        .collect()
}

/// Logarithms of the process noise as parameters. They begin where the prediction of a measured state is a tenth of its measurement noise.
fn noise_parameters(model: &EquationModel, noise: &[f64], step_s: f64) -> Vec<OutputParameter> {
    let of_state = |(state, name): (usize, &String)| {
        // A state without an output begins as one whose noise is the smallest change that matters.
        let measured = model.output_of_state[state].map_or(SCALE, |output| noise[output]);
        let start = (FIRST_PART * measured / step_s.sqrt()).ln();
        let bounds = (start - RANGE.0, start + RANGE.1);
        OutputParameter { name: format!("ln process noise of {name}"), start, scale: 1.0, bounds }
    };
    model.states.iter().enumerate().map(of_state).collect()
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

/// The filter in its steady state.
struct Steady {
    /// Gain, states by outputs.
    gain: DMatrix<f64>,
    /// Covariance of the innovations.
    innovation: DMatrix<f64>,
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
        let intensity =
            DMatrix::from_fn(states, states, |row, column| if row == column { (2.0 * logs[row]).exp() } else { 0.0 });
        let (transition, process) = discretise(&a, &intensity, self.step_s);
        let measurement =
            DMatrix::from_fn(
                noise.len(),
                noise.len(),
                |row, column| {
                    if row == column { noise[row].powi(2) } else { 0.0 }
                },
            );
        steady_filter(&transition, &process, &c, &measurement)
            .ok_or(EstimateError::NotConverged { method: "the Riccati equation", iterations: DOUBLINGS })
    }

    /// Slopes of rates and outputs with the states.
    fn slopes(&self, model: &EquationModel, x: &[f64], theta: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        /// Step of the differences, as a part of the value.
        const STEP: f64 = 1e-4;
        let (states, outputs) = (x.len(), model.outputs.len());
        let (mut a, mut c) = (DMatrix::zeros(states, states), DMatrix::zeros(outputs, states));
        let mut stack = Vec::new();
        let mut sides = |x: &[f64]| {
            let (mut rates, mut shown) = (vec![0.0; states], vec![0.0; outputs]);
            model.rates((x, &self.input, theta), &mut stack, &mut rates);
            model.shown((x, &self.input, theta), &mut stack, &mut shown);
            (rates, shown)
        };
        for state in 0..states {
            let step = STEP * x[state].abs().max(SCALE);
            let mut moved = x.to_vec();
            moved[state] = x[state] + step;
            let above = sides(&moved);
            moved[state] = x[state] - step;
            let below = sides(&moved);
            for row in 0..states {
                a[(row, state)] = (above.0[row] - below.0[row]) / (2.0 * step);
            }
            for row in 0..outputs {
                c[(row, state)] = (above.1[row] - below.1[row]) / (2.0 * step);
            }
        }
        (a, c)
    }
}

/// Transition over a step, and covariance of what the noise adds in it (Van Loan 1978).
fn discretise(a: &DMatrix<f64>, intensity: &DMatrix<f64>, step_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let states = a.nrows();
    let mut block = DMatrix::zeros(2 * states, 2 * states);
    block.view_mut((0, 0), (states, states)).copy_from(&(-a * step_s));
    block.view_mut((0, states), (states, states)).copy_from(&(intensity * step_s));
    block.view_mut((states, states), (states, states)).copy_from(&(a.transpose() * step_s));
    let exponential = block.exp();
    let transition = exponential.view((states, states), (states, states)).transpose();
    let process = &transition * exponential.view((0, states), (states, states));
    (transition, process)
}

/// Doublings of the Riccati equation at most: a horizon of 2^40 steps.
const DOUBLINGS: usize = 40;

/// The filter of `x' = Phi x + w`, `z = C x + v` in its steady state, by the doubling algorithm of the discrete Riccati equation (Anderson 1978);
/// none where it does not settle.
fn steady_filter(
    transition: &DMatrix<f64>,
    process: &DMatrix<f64>,
    c: &DMatrix<f64>,
    measurement: &DMatrix<f64>,
) -> Option<Steady> {
    /// Change of the covariance, as a part of it, below which it counts as steady.
    const STEADY: f64 = 1e-12;
    let states = transition.nrows();
    let identity = DMatrix::identity(states, states);
    let mut step = transition.transpose();
    let mut information = c.transpose() * measurement.clone().try_inverse()? * c;
    let mut covariance = process.clone();
    for _ in 0..DOUBLINGS {
        let middle = (&identity + &information * &covariance).try_inverse()?;
        let right = &step * &middle;
        let next_information = &information + &right * &information * step.transpose();
        let added = step.transpose() * &covariance * &middle * &step;
        step = &right * &step;
        information = next_information;
        covariance += &added;
        covariance = 0.5 * (&covariance + covariance.transpose());
        if added.norm() <= STEADY * covariance.norm() {
            let innovation = c * &covariance * c.transpose() + measurement;
            let gain = &covariance * c.transpose() * innovation.clone().try_inverse()?;
            return gain.iter().all(|value| value.is_finite()).then_some(Steady { gain, innovation });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    #[test]
    fn random_walk_seen_through_noise_has_the_gain_of_the_closed_form() {
        // P^2 - q P - q r = 0 for x' = x + w, z = x + v.
        let (q, r) = (0.3_f64, 2.0);
        let steady = steady_filter(&dmatrix![1.0], &dmatrix![q], &dmatrix![1.0], &dmatrix![r]).unwrap();
        let covariance = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        assert!((steady.gain[(0, 0)] - covariance / (covariance + r)).abs() < 1e-12);
    }

    #[test]
    fn steady_covariance_solves_the_riccati_equation() {
        let transition = dmatrix![1.05, 0.1; -0.2, 0.8];
        let process = dmatrix![0.02, 0.0; 0.0, 0.05];
        let (c, measurement) = (dmatrix![1.0, 0.5], dmatrix![0.3]);
        let steady = steady_filter(&transition, &process, &c, &measurement).unwrap();
        // The recursion from any start ends in the same gain.
        let mut covariance = DMatrix::identity(2, 2);
        let mut gain = DMatrix::zeros(2, 1);
        for _ in 0..2000 {
            let innovation = &c * &covariance * c.transpose() + &measurement;
            gain = &covariance * c.transpose() / innovation[(0, 0)];
            let updated = &covariance - &gain * &c * &covariance;
            covariance = &transition * updated * transition.transpose() + &process;
        }
        assert!((steady.gain - gain).norm() < 1e-9);
    }

    #[test]
    fn noise_over_a_step_is_that_of_the_integral() {
        // x' = -a x: covariance (1 - exp(-2 a h)) / 2a.
        let (a, h) = (3.0_f64, 0.2);
        let (transition, process) = discretise(&dmatrix![-a], &dmatrix![1.0], h);
        assert!((transition[(0, 0)] - (-a * h).exp()).abs() < 1e-12);
        assert!((process[(0, 0)] - (1.0 - (-2.0 * a * h).exp()) / (2.0 * a)).abs() < 1e-12);
    }
}
