//! What the steps of a window yield, collected into its reconstruction, and the first thing that went wrong.

use std::sync::Arc;

use crate::message::Message;
use crate::reconstruct::data::{AirData, FilterData, MeasurementSeries, Reconstruction, Smoothed};
use crate::reconstruct::deviations::Deviations;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::events::{Event, Schedule};
use crate::reconstruct::filter::step::{BLOCK, STEEPEST_PITCH_RAD, SmoothedOutputs, StepInputs, StepOutputs};
use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::layout::{AIR_STATES, INPUTS, MEASUREMENTS, STATES, State};
use crate::reconstruct::settings::ValidSettings;

/// Magnitude beyond which a state means divergence, SI: no aircraft is there.
const DIVERGED: f64 = 1e8;

/// Product of ratios of determinants below which its logarithm is taken: far from where numbers end.
const LEAST_RATIO: f64 = 1e-100;

/// A window on its way through the filter.
pub struct Window<'a> {
    /// Steps still to come.
    pub schedule: Schedule<'a>,
    /// What the steps yielded so far.
    pub result: Reconstruction,
    /// Events of the block under way.
    pub events: Vec<Event>,
    /// `ln (2 pi R)` of each measurement.
    log_noise: [f64; MEASUREMENTS],
    /// Their sum.
    log_noise_of_all: f64,
    /// Times of the steps so far, s.
    update_time_s: Vec<f64>,
    /// Whether all events of the block under way are inertial samples.
    only_samples: bool,
    /// Moments of the noises, from the smoother.
    moments: NoiseMoments,
    /// First thing that went wrong.
    error: Option<ReconstructError>,
}

/// Windows side by side; one that could not be prepared keeps its lane.
pub type Windows<'a> = [Result<Window<'a>, ReconstructError>];

/// Sums of expected squares of the noises, given all measurements, and how many there were.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseMoments {
    /// Of the inputs; one per step.
    pub process: [f64; INPUTS],
    pub steps: usize,
    pub measurement: [f64; MEASUREMENTS],
    pub samples: [usize; MEASUREMENTS],
}

impl<'a> Window<'a> {
    /// A window of checked data before its first step, at the initial state `x`.
    pub fn new(data: &'a FilterData, settings: &ValidSettings, x: [f64; STATES], warnings: Vec<Message>) -> Self {
        let samples = data.inputs.time_s.len();
        let column = |first: f64| {
            let mut column = Vec::with_capacity(samples);
            column.push(first);
            column
        };
        let deviations = |first: f64| {
            let mut column = Deviations::with_capacity(samples);
            column.extend(std::iter::once(first));
            column
        };
        let is_measured = |series: &MeasurementSeries| !series.time_s.is_empty();
        let series = data.measurements.each_ref();
        let result = Reconstruction {
            time_s: Arc::clone(&data.inputs.time_s),
            states: x.map(column),
            deviations: settings.initial_deviation.map(deviations),
            update_time_s: Arc::default(),
            innovations: series.map(|series| if is_measured(series) { column(f64::NAN) } else { Vec::new() }),
            innovation_deviations: series.map(|series| match is_measured(series) {
                true => deviations(f64::NAN),
                false => Deviations::from(Vec::new()),
            }),
            nis: column(f64::NAN),
            nis_degrees: {
                let mut degrees = Vec::with_capacity(samples);
                degrees.push(0);
                degrees
            },
            log_likelihood: 0.0,
            air_data: settings.air_data_deviation.iter().any(|deviation| *deviation > 0.0).then(|| AirData {
                states: [0.0; AIR_STATES].map(column),
                deviations: settings.air_data_deviation.map(column),
            }),
            final_covariance: StateMatrix::zeros(),
            smoothed: None,
            max_iterations_used: 0,
            outliers: Default::default(),
            warnings,
        };
        let log_noise = settings.measurement_noise.map(|deviation| (std::f64::consts::TAU * deviation.powi(2)).ln());
        Self {
            schedule: Schedule::new(data, settings.hold),
            result,
            events: Vec::with_capacity(BLOCK),
            update_time_s: column(data.inputs.time_s[0]),
            log_noise,
            log_noise_of_all: log_noise.iter().sum(),
            only_samples: false,
            moments: NoiseMoments::default(),
            error: None,
        }
    }

    /// Begins the next block in `lane`. A lane at its end gets zeros: a step of no length and no measurement changes nothing.
    pub fn begin_block<L: AsMut<[f64]>>(&mut self, lane: usize, inputs: &mut [StepInputs<L>]) {
        self.events.clear();
        if self.error.is_none() {
            self.schedule.begin_block(lane, inputs, &mut self.events);
        }
        inputs.iter_mut().skip(self.events.len()).for_each(|step| step.clear(lane));
    }

    /// Part of the window that was filtered, 0 to 1.
    pub(crate) fn part_done(&self) -> f64 {
        if self.error.is_some() { 1.0 } else { self.result.states[0].len() as f64 / self.result.time_s.len() as f64 }
    }

    /// Looks for what went wrong in the block; then there is nothing to collect.
    fn check<L: AsRef<[f64]>>(&mut self, lane: usize, outputs: &[StepOutputs<L>]) {
        let Some(last) = self.events.len().checked_sub(1) else { return };
        for (step, (event, outputs)) in self.events.iter().zip(outputs).enumerate() {
            let pivot = outputs.smallest_pivot.as_ref()[lane];
            if pivot <= 0.0 || pivot.is_nan() || step == last {
                self.error = step_error(event.time_s, lane, outputs);
                if self.error.is_some() {
                    return self.events.clear();
                }
            }
        }
        self.only_samples = self.events.iter().all(|event| event.is_sample);
    }

    /// Appends one field of the steps of the block to a column of states and what goes with them: at the samples.
    fn append_state<L: AsRef<[f64]>>(
        &mut self,
        lane: usize,
        outputs: &[StepOutputs<L>],
        column: impl Fn(&mut Reconstruction) -> Option<&mut Vec<f64>>,
        field: impl Fn(&StepOutputs<L>) -> &L,
    ) {
        let Some(column) = column(&mut self.result) else { return };
        let outputs = &outputs[..self.events.len()];
        if self.only_samples {
            column.extend(outputs.iter().map(|outputs| field(outputs).as_ref()[lane]));
        } else {
            let at_samples = outputs.iter().zip(&self.events).filter(|(_, event)| event.is_sample);
            column.extend(at_samples.map(|(outputs, _)| field(outputs).as_ref()[lane]));
        }
    }

    /// Appends the deviation of each step of the block to a column of states: at the samples.
    fn append_deviation<L: AsRef<[f64]>>(&mut self, k: usize, lane: usize, outputs: &[StepOutputs<L>]) {
        let at_samples = outputs.iter().zip(&self.events).filter(|(_, event)| event.is_sample);
        self.result.deviations[k].extend(at_samples.map(|(outputs, _)| outputs.deviation[k].as_ref()[lane]));
    }

    /// Appends innovations and their deviations: at every event, of what the window has samples of.
    fn append_innovation<L: AsRef<[f64]>>(&mut self, m: usize, lane: usize, outputs: &[StepOutputs<L>]) {
        let outputs = &outputs[..self.events.len()];
        let result = &mut self.result;
        if result.innovations[m].is_empty() {
            return;
        }
        result.innovations[m].extend(outputs.iter().map(|outputs| outputs.innovation[m].as_ref()[lane]));
        let deviations = outputs.iter().map(|outputs| outputs.innovation_deviation[m].as_ref()[lane]);
        result.innovation_deviations[m].extend(deviations);
    }

    /// Appends times and what the innovations of the block say together, and adds to the likelihood.
    fn append_likelihood<L: AsRef<[f64]>>(&mut self, lane: usize, outputs: &[StepOutputs<L>]) {
        let result = &mut self.result;
        // One logarithm for many steps.
        let (mut ratio, mut minus_two_log) = (1.0, 0.0);
        for (event, outputs) in self.events.iter().zip(outputs) {
            let nis = if event.degrees > 0 { outputs.nis.as_ref()[lane] } else { f64::NAN };
            self.update_time_s.push(event.time_s);
            result.nis.push(nis);
            result.nis_degrees.push(event.degrees);
            if event.degrees > 0 {
                let is_measured = |m: &usize| !outputs.innovation[*m].as_ref()[lane].is_nan();
                let noise = if usize::from(event.degrees) == MEASUREMENTS {
                    self.log_noise_of_all
                } else {
                    (0..MEASUREMENTS).filter(is_measured).map(|m| self.log_noise[m]).sum()
                };
                minus_two_log += noise + nis;
                ratio *= outputs.det_ratio.as_ref()[lane];
                if ratio < LEAST_RATIO {
                    minus_two_log -= ratio.ln();
                    ratio = 1.0;
                }
            }
            result.max_iterations_used = result.max_iterations_used.max(outputs.iterations.as_ref()[lane] as usize);
        }
        result.log_likelihood -= 0.5 * (minus_two_log - ratio.ln());
    }

    /// The smoothed path ends where the filtered one does.
    pub(crate) fn begin_smoothing(&mut self) {
        let result = &mut self.result;
        result.smoothed = Some(Smoothed {
            states: result.states.clone(),
            deviations: result.deviations.clone(),
            air_data: result.air_data.clone(),
            costs: Vec::new(),
        });
    }

    /// Takes one field of the smoothed estimates at the starts of the steps of the block.
    fn take_smoothed<L: AsRef<[f64]>>(
        &mut self,
        lane: usize,
        outputs: &[SmoothedOutputs<L>],
        column: impl Fn(&mut Smoothed) -> Option<&mut Vec<f64>>,
        field: impl Fn(&SmoothedOutputs<L>) -> &L,
    ) {
        let Some(column) = self.result.smoothed.as_mut().and_then(column) else { return };
        for (outputs, event) in outputs.iter().zip(&self.events) {
            if let Some(row) = event.start_sample {
                column[row] = field(outputs).as_ref()[lane];
            }
        }
    }

    /// Takes the deviation of a smoothed state at the starts of the steps of the block.
    fn take_smoothed_deviation<L: AsRef<[f64]>>(&mut self, k: usize, lane: usize, outputs: &[SmoothedOutputs<L>]) {
        let Some(smoothed) = &mut self.result.smoothed else { return };
        for (outputs, event) in outputs.iter().zip(&self.events) {
            if let Some(row) = event.start_sample {
                smoothed.deviations[k].set(row, outputs.deviation[k].as_ref()[lane]);
            }
        }
    }

    /// Adds the moments of the noises in the block.
    fn add_moments<L: AsRef<[f64]>>(&mut self, lane: usize, outputs: &[SmoothedOutputs<L>]) {
        let moments = &mut self.moments;
        for (outputs, _) in outputs.iter().zip(&self.events) {
            for i in 0..INPUTS {
                moments.process[i] += outputs.process_noise[i].as_ref()[lane];
            }
            moments.steps += 1;
            for m in 0..MEASUREMENTS {
                let square = outputs.measurement_noise[m].as_ref()[lane];
                if square.is_finite() {
                    moments.measurement[m] += square;
                    moments.samples[m] += 1;
                }
            }
        }
    }

    /// A state known exactly, or nearly so, at the start has next to no smoothed variance there, of which rounding may leave a
    /// negative number: the filter's own deviation, no smaller than the smoothed one, then stands for it.
    fn repair_initial_variances(&mut self) {
        /// Samples within which rounding may be larger than the variance.
        const FIRST: usize = 10;
        /// First deviation of a state, as a part of its largest, that counts as known: its square is then lost in the others.
        const KNOWN: f64 = 1e-4;
        let Some(smoothed) = &mut self.result.smoothed else { return };
        for (filtered, smoothed) in self.result.deviations.iter().zip(&mut smoothed.deviations) {
            let lost = smoothed.iter().take(FIRST).take_while(|deviation| deviation.is_nan()).count();
            if lost > 0 && filtered.at(0) < KNOWN * filtered.iter().fold(0.0, f64::max) {
                (0..lost).for_each(|index| smoothed.set(index, filtered.at(index)));
            }
        }
    }

    /// First smoothed value that is not a number.
    fn smoothing_error(&self) -> Option<ReconstructError> {
        let smoothed = self.result.smoothed.as_ref()?;
        for state in State::ALL {
            let deviations = &smoothed.deviations[state as usize];
            let rows = deviations.iter().zip(&smoothed.states[state as usize]).zip(&*self.result.time_s);
            for ((deviation, value), &time_s) in rows {
                if !(deviation.is_finite() && value.is_finite()) {
                    let variance = deviation * deviation;
                    return Some(ReconstructError::NotPositiveDefinite { state: state.name(), time_s, variance });
                }
            }
        }
        None
    }

    /// The result, with the covariance of the final state, and the moments of the noises.
    pub fn finish(mut self, covariance: StateMatrix) -> Result<(Reconstruction, NoiseMoments), ReconstructError> {
        self.repair_initial_variances();
        if let Some(error) = self.error.take().or_else(|| self.smoothing_error()) {
            return Err(error);
        }
        let time_s = &self.result.time_s;
        let is_same = **time_s == *self.update_time_s;
        self.result.update_time_s = if is_same { Arc::clone(time_s) } else { self.update_time_s.into() };
        self.result.final_covariance = covariance;
        Ok((self.result, self.moments))
    }
}

/// Puts the next block of every window into its lane, field by field as in [`collect`]; returns the number of steps of the longest.
pub fn fill<L: AsMut<[f64]>>(windows: &mut Windows<'_>, inputs: &mut [StepInputs<L>]) -> usize {
    let mut steps = 0;
    each(windows, |lane, window| {
        window.begin_block(lane, inputs);
        steps = steps.max(window.events.len());
    });
    for i in 0..INPUTS {
        each(windows, |lane, window| window.schedule.fill_input(i, lane, inputs, &window.events));
    }
    for m in 0..MEASUREMENTS {
        each(windows, |lane, window| window.schedule.fill_measurement(m, lane, inputs, &mut window.events));
    }
    steps
}

/// Collects what a block yielded of every window. Field by field, because the lanes of a field lie side by side.
pub fn collect<L: AsRef<[f64]>>(windows: &mut Windows<'_>, outputs: &[StepOutputs<L>]) {
    each(windows, |lane, window| window.check(lane, outputs));
    for k in 0..STATES {
        each(windows, |lane, window| window.append_state(lane, outputs, |r| Some(&mut r.states[k]), |o| &o.state[k]));
        each(windows, |lane, window| window.append_deviation(k, lane, outputs));
    }
    for m in 0..MEASUREMENTS {
        each(windows, |lane, window| window.append_innovation(m, lane, outputs));
    }
    for k in 0..AIR_STATES {
        each(windows, |lane, window| {
            window.append_state(lane, outputs, |r| Some(&mut r.air_data.as_mut()?.states[k]), |o| &o.air_data[k]);
        });
        each(windows, |lane, window| {
            window.append_state(
                lane,
                outputs,
                |r| Some(&mut r.air_data.as_mut()?.deviations[k]),
                |o| &o.air_data_deviation[k],
            );
        });
    }
    each(windows, |lane, window| window.append_likelihood(lane, outputs));
}

/// Collects what the smoother yielded of a block; `noise_moments` for those as well.
pub(crate) fn collect_smoothed<L: AsRef<[f64]>>(
    windows: &mut Windows<'_>,
    noise_moments: bool,
    outputs: &[SmoothedOutputs<L>],
) {
    for k in 0..STATES {
        each(windows, |lane, window| window.take_smoothed(lane, outputs, |s| Some(&mut s.states[k]), |o| &o.state[k]));
        each(windows, |lane, window| window.take_smoothed_deviation(k, lane, outputs));
    }
    for k in 0..AIR_STATES {
        each(windows, |lane, window| {
            window.take_smoothed(lane, outputs, |s| Some(&mut s.air_data.as_mut()?.states[k]), |o| &o.air_data[k]);
        });
        each(windows, |lane, window| {
            window.take_smoothed(
                lane,
                outputs,
                |s| Some(&mut s.air_data.as_mut()?.deviations[k]),
                |o| &o.air_data_deviation[k],
            );
        });
    }
    if noise_moments {
        each(windows, |lane, window| window.add_moments(lane, outputs));
    }
}

fn each<'a>(windows: &mut Windows<'a>, mut take: impl FnMut(usize, &mut Window<'a>)) {
    for (lane, window) in windows.iter_mut().enumerate() {
        if let Ok(window) = window {
            take(lane, window);
        }
    }
}

/// What is wrong with a step, if anything.
pub(crate) fn step_error<L: AsRef<[f64]>>(
    time_s: f64,
    lane: usize,
    outputs: &StepOutputs<L>,
) -> Option<ReconstructError> {
    for state in State::ALL {
        let [value, deviation] =
            [&outputs.state, &outputs.deviation].map(|columns| columns[state as usize].as_ref()[lane]);
        if value.abs() > DIVERGED || value.is_nan() {
            return Some(ReconstructError::Diverged { state: state.name(), time_s, value });
        }
        if deviation.is_nan() {
            return Some(ReconstructError::NotPositiveDefinite { state: state.name(), time_s, variance: deviation });
        }
    }
    let theta = outputs.state[State::PitchAngle as usize].as_ref()[lane];
    if theta.abs() > STEEPEST_PITCH_RAD {
        return Some(ReconstructError::NearVertical { time_s, theta_deg: theta.to_degrees() });
    }
    (outputs.smallest_pivot.as_ref()[lane] <= 0.0).then_some(ReconstructError::SingularInnovation { time_s })
}
