//! Noise settings that the data themselves propose: the ones that make the measurements most likely.
//!
//! The likelihood of the innovations, `L = -1/2 sum (ln |S| + nu' S^-1 nu + m ln 2 pi)` (Schweppe 1965), is raised over the
//! standard deviations of process and measurement noise, either by expectation-maximisation (Shumway & Stoffer 1982) or by a
//! quasi-Newton iteration on their logarithms. Both need the expected squares of the noises given all measurements, which
//! the smoother yields; by Fisher's identity they are also the gradient, `dL / d ln sigma = sum E[w^2] / sigma^2 - N`.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use crate::optimise::bfgs_update;
use crate::reconstruct::collect::NoiseMoments;
use crate::reconstruct::data::FilterData;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::model::layout::{INPUTS, Input, MEASUREMENTS, Measurement};
use crate::reconstruct::pass::Watch;
use crate::reconstruct::run::reconstruct_with_noise_moments;
use crate::reconstruct::settings::{FilterSettings, SettingError, ValidSettings};

/// How to raise the likelihood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseMethod {
    /// Expectation-maximisation: rises in every step, slowly.
    ExpectationMaximisation,
    /// Quasi-Newton (Broyden, Fletcher, Goldfarb & Shanno) on the logarithms of the standard deviations.
    QuasiNewton,
}

/// What to do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseProposalSettings {
    /// How to raise the likelihood.
    pub method: NoiseMethod,
    /// Steps at most.
    pub max_iterations: usize,
    /// Gain of the logarithm of the likelihood in a step below which the iteration ends.
    pub tolerance: f64,
}

impl Default for NoiseProposalSettings {
    fn default() -> Self {
        Self { method: NoiseMethod::QuasiNewton, max_iterations: 60, tolerance: 0.05 }
    }
}

/// Likelihood and moments of the noises at one choice of settings; of several groups of windows, their sum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Likelihood {
    /// Logarithm of the likelihood.
    pub log_likelihood: f64,
    /// Expected squares of the noises given all measurements.
    pub moments: NoiseMoments,
}

impl Likelihood {
    /// Adds that of other windows.
    pub fn add(&mut self, other: &Self) {
        self.log_likelihood += other.log_likelihood;
        let (moments, more) = (&mut self.moments, &other.moments);
        moments.steps += more.steps;
        for i in 0..INPUTS {
            moments.process[i] += more.process[i];
        }
        for m in 0..MEASUREMENTS {
            moments.measurement[m] += more.measurement[m];
            moments.samples[m] += more.samples[m];
        }
    }
}

/// A proposed standard deviation, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProposedDeviation {
    /// As it is set.
    pub present: f64,
    /// As the data have it.
    pub proposed: f64,
    /// Standard error of the logarithm of the proposed one; `None` where the data do not determine it: a smaller one fits as well.
    pub log_standard_error: Option<f64>,
    /// Whether the likelihood still rises [`FURTHEST`] times from the present one, where the search ends: it has no maximum, as for
    /// a measurement the path can follow exactly, and the proposal is none.
    pub at_bound: bool,
}

/// Proposed noise settings. Nothing is changed by it.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseProposal {
    /// Of each input; `None` for one that is set to have no noise.
    pub process: [Option<ProposedDeviation>; INPUTS],
    /// Of each measurement; `None` where there is none.
    pub measurement: [Option<ProposedDeviation>; MEASUREMENTS],
    /// Logarithm of the likelihood at the present settings and after each step.
    pub log_likelihood: Vec<f64>,
    /// Whether the iteration ended by its tolerance.
    pub converged: bool,
    /// Samples of each measurement that were left out as outliers.
    pub outliers: [usize; MEASUREMENTS],
}

/// Why there is no proposal.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what the variants are")]
pub enum NoiseProposalError {
    /// The filter failed at the present settings.
    #[error(transparent)]
    Filter(#[from] ReconstructError),
    #[error(
        "the filter needed a more robust form at the present noise settings; bring them closer to what is known first"
    )]
    NoMoments,
    /// Settings outside their range.
    #[error("{0}")]
    Setting(#[from] SettingError),
}

/// Likelihood of windows, and the moments of their noises.
///
/// # Errors
/// What stops the filter in any window.
pub fn likelihood(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Likelihood, NoiseProposalError> {
    let mut sum = Likelihood::default();
    for outcome in reconstruct_with_noise_moments(data, settings, watch) {
        let (result, moments) = outcome?;
        let moments = moments.ok_or(NoiseProposalError::NoMoments)?;
        sum.add(&Likelihood { log_likelihood: result.log_likelihood, moments });
    }
    Ok(sum)
}

/// Noises that are looked for: inputs first, then measurements.
struct Search<'a> {
    settings: FilterSettings,
    evaluate: &'a mut dyn FnMut(&ValidSettings) -> Result<Likelihood, NoiseProposalError>,
    entries: Vec<Entry>,
    /// Logarithms of the present deviations, [`FURTHEST`] times about which the search goes.
    start: DVector<f64>,
}

/// A noise.
#[derive(Clone, Copy)]
enum Entry {
    Process(Input),
    Measurement(Measurement),
}

/// Likelihood, its gradient by the logarithms of the deviations, and the number of samples behind each.
struct Point {
    log_sigma: DVector<f64>,
    log_likelihood: f64,
    gradient: DVector<f64>,
    samples: DVector<f64>,
}

impl Search<'_> {
    /// Whether an entry lies at an end of the range that is searched.
    fn at_bound(&self, log_sigma: &DVector<f64>, entry: usize) -> bool {
        (log_sigma[entry] - self.start[entry]).abs() >= FURTHEST.ln() * (1.0 - f64::EPSILON)
    }

    /// The point at these logarithms, brought back into the range that is searched; the gradient of an entry at its end has
    /// nothing that points out.
    fn at(&mut self, log_sigma: DVector<f64>) -> Result<Point, NoiseProposalError> {
        let reach = FURTHEST.ln();
        let log_sigma = log_sigma.zip_map(&self.start, |log, start| log.clamp(start - reach, start + reach));
        let mut settings = self.settings.clone();
        for (entry, log) in self.entries.iter().zip(log_sigma.iter()) {
            match *entry {
                Entry::Process(input) => settings.process_noise[input as usize] = log.exp(),
                Entry::Measurement(measurement) => settings.measurement_noise[measurement as usize] = log.exp(),
            }
        }
        let valid = settings.check().map_err(|mut errors| NoiseProposalError::Setting(errors.remove(0)))?;
        let Likelihood { log_likelihood, moments } = (self.evaluate)(&valid)?;
        let found = self.entries.iter().map(|entry| match *entry {
            Entry::Process(input) => (moments.process[input as usize], moments.steps),
            Entry::Measurement(measurement) => {
                (moments.measurement[measurement as usize], moments.samples[measurement as usize])
            }
        });
        let (squares, samples): (Vec<f64>, Vec<f64>) = found.map(|(square, count)| (square, count as f64)).unzip();
        let samples = DVector::from_vec(samples);
        let gradient = DVector::from_fn(squares.len(), |i, _| {
            let slope = squares[i] * (-2.0 * log_sigma[i]).exp() - samples[i];
            let points_out = slope * (log_sigma[i] - self.start[i]) > 0.0;
            if self.at_bound(&log_sigma, i) && points_out { 0.0 } else { slope }
        });
        Ok(Point { log_sigma, log_likelihood, gradient, samples })
    }

    /// Inverse curvature to begin with: twice the number of samples for a measurement, each of which bears on its noise; for an
    /// input, whose noise shows only through the path, that of [`INPUT_CURVATURE`].
    fn first_inverse(&self, at: &Point) -> DMatrix<f64> {
        let curvatures = self.entries.iter().zip(at.samples.iter()).map(|(entry, samples)| match entry {
            Entry::Process(_) => INPUT_CURVATURE,
            Entry::Measurement(_) => 2.0 * samples.max(1.0),
        });
        DMatrix::from_diagonal(&DVector::from_iterator(self.entries.len(), curvatures.map(f64::recip)))
    }

    /// Expectation-maximisation: every variance becomes the mean of the expected squares, `1 + g / N` times what it was.
    fn expectation_step(&mut self, from: &Point) -> Result<Point, NoiseProposalError> {
        let ratio = from.gradient.component_div(&from.samples).add_scalar(1.0);
        self.at(&from.log_sigma + ratio.map(|ratio| 0.5 * ratio.max(1e-12).ln()))
    }

    /// Along the direction of `inverse`, no logarithm further than [`LONGEST`], shortened until the likelihood rises enough.
    fn line_search(&mut self, from: &Point, inverse: &DMatrix<f64>) -> Result<Option<Point>, NoiseProposalError> {
        let clamped = |direction: DVector<f64>| direction.map(|step| step.clamp(-LONGEST, LONGEST));
        let mut direction = clamped(inverse * &from.gradient);
        let mut slope = from.gradient.dot(&direction);
        if slope <= 0.0 {
            direction = clamped(inverse.diagonal().component_mul(&from.gradient));
            slope = from.gradient.dot(&direction);
        }
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            match self.at(&from.log_sigma + &direction * length) {
                Ok(point) if point.log_likelihood >= from.log_likelihood + ENOUGH * length * slope => {
                    return Ok(Some(point));
                }
                Err(NoiseProposalError::Filter(ReconstructError::Cancelled)) => {
                    return Err(ReconstructError::Cancelled.into());
                }
                _ => length *= 0.5,
            }
        }
        Ok(None)
    }

    /// Standard errors of the logarithms: the curvature of the likelihood by differences of its gradient, over those that the
    /// data determine.
    fn standard_errors(&mut self, at: &Point) -> Result<Vec<Option<f64>>, NoiseProposalError> {
        let count = self.entries.len();
        let mut curvature = DMatrix::zeros(count, count);
        for i in 0..count {
            let mut log_sigma = at.log_sigma.clone();
            log_sigma[i] += CURVATURE_STEP;
            let ahead = self.at(log_sigma)?;
            curvature.set_column(i, &((&at.gradient - ahead.gradient) / CURVATURE_STEP));
        }
        let curvature = (&curvature + curvature.transpose()) * 0.5;
        let is_observed = |&i: &usize| curvature[(i, i)] > UNOBSERVED.powi(-2) && !self.at_bound(&at.log_sigma, i);
        let observed: Vec<usize> = (0..count).filter(is_observed).collect();
        let among_observed =
            DMatrix::from_fn(observed.len(), observed.len(), |i, j| curvature[(observed[i], observed[j])]);
        let mut errors = vec![None; count];
        if let Some(covariance) = among_observed.cholesky().map(|factor| factor.inverse()) {
            for (k, &i) in observed.iter().enumerate() {
                errors[i] = Some(covariance[(k, k)].sqrt()).filter(|error| *error < UNOBSERVED);
            }
        }
        Ok(errors)
    }
}

/// Curvature of the likelihood by the logarithm of an input's noise to begin with: a standard error of a tenth.
const INPUT_CURVATURE: f64 = 100.0;
/// Longest step of the logarithm of a deviation.
const LONGEST: f64 = 1.5;
/// Part of the gain foreseen that a step must bring (Armijo).
const ENOUGH: f64 = 1e-4;
/// Largest factor between a proposed deviation and the present one.
pub const FURTHEST: f64 = 100.0;
/// Times a step is halved at most.
const HALVINGS: usize = 12;
/// Step of the logarithm over which the gradient is differenced.
const CURVATURE_STEP: f64 = 0.05;
/// Standard error of a logarithm beyond which the data do not determine a deviation.
const UNOBSERVED: f64 = 2.0;

/// Where an iteration is, for a progress display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseProgress {
    /// Steps done.
    pub iteration: usize,
    /// Logarithm of the likelihood.
    pub log_likelihood: f64,
}

/// Proposes noise settings. `evaluate` is [`likelihood`] over all windows, on as many threads as the caller likes; `outliers`
/// are those left out of them. `progress` is called after every step; `Break` cancels.
///
/// # Errors
/// What stops the filter at the present settings, and cancellation.
pub fn propose_noise(
    settings: &FilterSettings,
    search: &NoiseProposalSettings,
    outliers: [usize; MEASUREMENTS],
    evaluate: &mut dyn FnMut(&ValidSettings) -> Result<Likelihood, NoiseProposalError>,
    progress: &mut dyn FnMut(NoiseProgress) -> ControlFlow<()>,
) -> Result<NoiseProposal, NoiseProposalError> {
    let settings = settings.simplified(true);
    let valid = settings.check().map_err(|mut errors| NoiseProposalError::Setting(errors.remove(0)))?;
    let samples = evaluate(&valid)?.moments.samples;
    let processes = Input::ALL.into_iter().filter(|input| settings.process_noise[*input as usize] > 0.0);
    let measurements = Measurement::ALL.into_iter().filter(|measurement| samples[*measurement as usize] > 0);
    let entries: Vec<Entry> = processes.map(Entry::Process).chain(measurements.map(Entry::Measurement)).collect();
    let present = |entry: &Entry| match *entry {
        Entry::Process(input) => settings.process_noise[input as usize],
        Entry::Measurement(measurement) => settings.measurement_noise[measurement as usize],
    };
    let start = DVector::from_iterator(entries.len(), entries.iter().map(|entry| present(entry).ln()));
    let presents: Vec<f64> = entries.iter().map(present).collect();
    let mut search_state = Search { settings: settings.clone(), evaluate, entries, start: start.clone() };
    let mut point = search_state.at(start)?;
    let mut rising = vec![point.log_likelihood];
    let mut inverse = search_state.first_inverse(&point);
    let mut converged = false;
    for iteration in 1..=search.max_iterations {
        let next = match search.method {
            NoiseMethod::ExpectationMaximisation => Some(search_state.expectation_step(&point)?),
            NoiseMethod::QuasiNewton => search_state.line_search(&point, &inverse)?,
        };
        let Some(next) = next else {
            converged = true;
            break;
        };
        bfgs_update(&mut inverse, &(&next.log_sigma - &point.log_sigma), &(&point.gradient - &next.gradient));
        let gain = next.log_likelihood - point.log_likelihood;
        point = next;
        rising.push(point.log_likelihood);
        if progress(NoiseProgress { iteration, log_likelihood: point.log_likelihood }).is_break() {
            return Err(ReconstructError::Cancelled.into());
        }
        if gain < search.tolerance {
            converged = true;
            break;
        }
    }
    let errors = search_state.standard_errors(&point)?;
    let mut proposal = NoiseProposal {
        process: [None; INPUTS],
        measurement: [None; MEASUREMENTS],
        log_likelihood: rising,
        converged,
        outliers,
    };
    for (i, entry) in search_state.entries.iter().enumerate() {
        let proposed = ProposedDeviation {
            present: presents[i],
            proposed: point.log_sigma[i].exp(),
            log_standard_error: errors[i],
            at_bound: search_state.at_bound(&point.log_sigma, i),
        };
        match *entry {
            Entry::Process(input) => proposal.process[input as usize] = Some(proposed),
            Entry::Measurement(measurement) => proposal.measurement[measurement as usize] = Some(proposed),
        }
    }
    Ok(proposal)
}
