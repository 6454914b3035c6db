//! The filter of constant gain behind filter error, and its measurement noise in closed form.

use nalgebra::{DMatrix, DVector};

use super::{EstimateError, OutputErrorFit, OutputParameter};
use crate::prep::white_noise_deviation;
use crate::series::Series;

/// Prediction error at the start of the search, as a part of the variance of the measurement noise.
const FIRST_PART: f64 = 0.1;
/// Logarithm of the range of the process noise below and above its start.
const RANGE: (f64, f64) = (5.0, 9.0);

/// Rounds of measurement noise and parameters at most.
const ROUNDS: usize = 12;
/// Change of a standard deviation below which the measurement noise counts as settled.
const SETTLED: f64 = 0.01;

/// Standard deviation of the white noise of a measurement; a small part of its motion where none shows, `scale` the smallest motion
/// that matters.
pub(super) fn first_deviation(time_s: &[f64], values: &[f64], scale: f64) -> f64 {
    /// Part of the motion.
    const PART: f64 = 1e-3;
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (least, most) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), value| (l.min(value), m.max(value)));
    let motion = PART * (most - least).max(scale);
    let series = Series { time_s: time_s.into(), values: values.into() };
    white_noise_deviation(&series, false).unwrap_or(0.0).max(motion)
}

/// Estimates with the measurement noise that belongs to them: `R <- R S / (C P C' + R)` in rounds until it is settled (Jategaonkar,
/// chapter 5). `estimate` gives the fit with a measurement noise and the deviations of the innovations that its filter expects;
/// every round begins at the estimates of the one before. No deviation falls below `least`.
pub(super) fn settle_noise<E: From<EstimateError>>(
    parameters: &mut [OutputParameter],
    (mut noise, least): (Vec<f64>, &[f64]),
    mut estimate: impl FnMut(&[OutputParameter], &[f64]) -> Result<(OutputErrorFit, Vec<f64>), E>,
) -> Result<(OutputErrorFit, Vec<f64>), E> {
    for _ in 0..ROUNDS {
        let (fit, expected) = estimate(parameters, &noise)?;
        let found = noise
            .iter()
            .zip(&fit.noise)
            .zip(&expected)
            .map(|((noise, innovation), expected)| noise * innovation / expected);
        let next: Vec<f64> = found.zip(least).map(|(found, least)| found.max(*least)).collect();
        let is_settled = next.iter().zip(&noise).all(|(next, noise)| (next / noise - 1.0).abs() < SETTLED);
        if is_settled {
            return Ok((fit, next));
        }
        parameters.iter_mut().zip(&fit.estimates).for_each(|(parameter, value)| parameter.start = *value);
        noise = next;
    }
    Err(EstimateError::NotConverged { method: "filter error", iterations: ROUNDS }.into())
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

impl ProcessNoise {
    /// The logarithm of the noise of `state` as a parameter. It begins where the prediction of the state is a tenth of its measurement
    /// noise, `measured`.
    pub(super) fn parameter(state: &str, measured: f64, step_s: f64) -> OutputParameter {
        let start = (FIRST_PART * measured / step_s.sqrt()).ln();
        let bounds = (start - RANGE.0, start + RANGE.1);
        OutputParameter { name: format!("ln process noise of {state}"), start, scale: 1.0, bounds }
    }

    /// The noise of each state, whose logarithms are the last parameters of a fit.
    pub(super) fn list<S: AsRef<str>>(states: &[S], parameters: &[OutputParameter], fit: &OutputErrorFit) -> Vec<Self> {
        let first = fit.estimates.len() - states.len();
        let of_state = |(index, (state, parameter)): (usize, (&S, &OutputParameter))| Self {
            state: state.as_ref().to_owned(),
            intensity: fit.estimates[first + index].exp(),
            log_error: fit.standard_errors[first + index],
            is_none: fit.at_bound[first + index] && fit.estimates[first + index] <= parameter.bounds.0,
        };
        states.iter().zip(parameters).enumerate().map(of_state).collect()
    }
}

pub(super) struct Steady {
    /// Gain, states by outputs.
    pub(super) gain: DMatrix<f64>,
    /// Covariance of the innovations.
    pub(super) innovation: DMatrix<f64>,
}

impl Steady {
    /// The filter of `x' = A x + F w`, `z = C x + v` at samples a step apart, with the logarithms of the diagonal of `F` and the
    /// deviations of `v`.
    ///
    /// # Errors
    /// A Riccati equation that does not settle.
    pub(super) fn new(
        a: &DMatrix<f64>,
        c: &DMatrix<f64>,
        (logs, noise): (&[f64], &[f64]),
        step_s: f64,
    ) -> Result<Self, EstimateError> {
        let squares = |values: Vec<f64>| DMatrix::from_diagonal(&DVector::from_vec(values));
        let intensity = squares(logs.iter().map(|log| (2.0 * log).exp()).collect());
        let measurement = squares(noise.iter().map(|deviation| deviation * deviation).collect());
        let (transition, process) = discretise(a, &intensity, step_s);
        steady_filter(&transition, &process, c, &measurement)
            .ok_or(EstimateError::NotConverged { method: "the Riccati equation", iterations: DOUBLINGS })
    }

    /// Deviations of the innovations.
    pub(super) fn deviations(&self) -> Vec<f64> {
        self.innovation.diagonal().iter().map(|variance| variance.sqrt()).collect()
    }
}

/// Transition over a step, and covariance of what the noise adds in it (Van Loan 1978).
pub(super) fn discretise(a: &DMatrix<f64>, intensity: &DMatrix<f64>, step_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
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
pub(super) fn steady_filter(
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
