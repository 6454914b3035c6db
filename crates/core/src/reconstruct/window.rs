//! A window on its way through the filter: its schedule, what became of it so far, and the first thing that went wrong.

use super::dense::Dense;
use super::initial::initial_state;
use super::layout::{MEASUREMENTS, STATES, State};
use super::march::{
    BLOCK, DEVIATIONS, HEALTH, INNOVATION_DEVIATIONS, INNOVATIONS, ITERATIONS, NIS, RECORD, STEEPEST_PITCH_RAD,
};
use super::real::Real;
use super::schedule::{DRIVE, Event, Schedule, check};
use super::settings::ValidSettings;
use super::{FilterData, ReconstructError, Reconstruction, Smoothed};

/// Magnitude beyond which a state means divergence, SI: no aircraft is there.
const DIVERGED: f64 = 1e8;

/// A window on its way through the filter.
pub struct Window<'a> {
    /// Steps still to come.
    pub schedule: Schedule<'a>,
    /// What the steps told so far.
    pub result: Reconstruction,
    /// Events of the block under way.
    pub events: Vec<Event>,
    /// First thing that went wrong.
    error: Option<ReconstructError>,
}

impl<'a> Window<'a> {
    /// A window before its first step.
    pub fn new(data: &'a FilterData, settings: &ValidSettings) -> Result<Self, ReconstructError> {
        check(data)?;
        let mut warnings = Vec::new();
        let x = initial_state(data, settings, &mut warnings);
        let samples = data.inputs.time_s.len();
        let column = |first: f64| {
            let mut column = Vec::with_capacity(samples);
            column.push(first);
            column
        };
        let result = Reconstruction {
            time_s: data.inputs.time_s.clone(),
            states: x.map(column),
            deviations: settings.initial_deviation.map(column),
            update_time_s: column(data.inputs.time_s[0]),
            innovations: [f64::NAN; MEASUREMENTS].map(column),
            innovation_deviations: [f64::NAN; MEASUREMENTS].map(column),
            nis: column(f64::NAN),
            nis_degrees: vec![0],
            final_covariance: Dense::zeros(),
            smoothed: None,
            max_iterations_used: 0,
            warnings,
        };
        let schedule = Schedule::new(data, settings.hold);
        Ok(Self { schedule, result, events: Vec::with_capacity(BLOCK), error: None })
    }

    /// Puts the steps of the next block into `lane`. A lane at its end gets zeros: a step of no length and no measurement
    /// changes nothing.
    pub fn fill<T: Real>(&mut self, lane: usize, drive: &mut [f64]) {
        self.events.clear();
        if self.error.is_none() {
            self.schedule.fill(&mut drive[lane..], T::LANES, &mut self.events);
        }
        for row in drive.chunks_exact_mut(DRIVE * T::LANES).skip(self.events.len()) {
            row.iter_mut().skip(lane).step_by(T::LANES).for_each(|value| *value = 0.0);
        }
    }

    /// Part of the window that was filtered, 0 to 1.
    pub fn part_done(&self) -> f64 {
        if self.error.is_some() { 1.0 } else { self.result.states[0].len() as f64 / self.result.time_s.len() as f64 }
    }

    /// Takes what the block told of `lane`.
    pub fn drain<T: Real>(&mut self, lane: usize, record: &[f64]) {
        let (result, events) = (&mut self.result, self.events.as_slice());
        let rows = &record[..events.len() * RECORD * T::LANES];
        let told = |step: usize, field: usize| rows[(step * RECORD + field) * T::LANES + lane];
        let Some(last) = events.len().checked_sub(1) else { return };
        for step in 0..=last {
            if told(step, HEALTH) <= 0.0 || told(step, HEALTH).is_nan() || step == last {
                self.error = verdict(events[step].time_s, &|field| told(step, field));
                if self.error.is_some() {
                    return;
                }
            }
        }
        let every_event = |into: &mut Vec<f64>, field: usize| {
            let filled = into.len();
            into.resize(filled + events.len(), 0.0);
            for (value, row) in into[filled..].iter_mut().zip(rows.chunks_exact(RECORD * T::LANES)) {
                *value = row[field * T::LANES + lane];
            }
        };
        if events.iter().all(|event| event.is_sample) {
            for k in 0..STATES {
                every_event(&mut result.states[k], k);
                every_event(&mut result.deviations[k], DEVIATIONS + k);
            }
        } else {
            let samples = (0..events.len()).filter(|&step| events[step].is_sample);
            for k in 0..STATES {
                result.states[k].extend(samples.clone().map(|step| told(step, k)));
                result.deviations[k].extend(samples.clone().map(|step| told(step, DEVIATIONS + k)));
            }
        }
        for m in 0..MEASUREMENTS {
            every_event(&mut result.innovations[m], INNOVATIONS + m);
            every_event(&mut result.innovation_deviations[m], INNOVATION_DEVIATIONS + m);
        }
        for (step, event) in events.iter().enumerate() {
            result.update_time_s.push(event.time_s);
            result.nis.push(if event.degrees > 0 { told(step, NIS) } else { f64::NAN });
            result.nis_degrees.push(event.degrees);
            result.max_iterations_used = result.max_iterations_used.max(told(step, ITERATIONS) as usize);
        }
    }

    /// The smoothed path ends where the filtered one does.
    pub fn begin_smoothing(&mut self) {
        let result = &mut self.result;
        result.smoothed = Some(Smoothed { states: result.states.clone(), deviations: result.deviations.clone() });
    }

    /// Takes what the smoother told of the starts of the steps of a block.
    pub fn drain_smoothed<T: Real>(&mut self, lane: usize, record: &[f64]) {
        let Some(smoothed) = &mut self.result.smoothed else { return };
        let told = |step: usize, field: usize| record[(step * RECORD + field) * T::LANES + lane];
        for k in 0..STATES {
            for (step, event) in self.events.iter().enumerate() {
                let Some(row) = event.start_sample else { continue };
                smoothed.states[k][row] = told(step, k);
                smoothed.deviations[k][row] = told(step, DEVIATIONS + k);
            }
        }
    }

    /// First smoothed value that is not a number.
    fn smoothing_error(&self) -> Option<ReconstructError> {
        let smoothed = self.result.smoothed.as_ref()?;
        for state in State::ALL {
            let deviations = &smoothed.deviations[state as usize];
            let rows = deviations.iter().zip(&smoothed.states[state as usize]).zip(&self.result.time_s);
            for ((deviation, value), &time_s) in rows {
                if !(deviation.is_finite() && value.is_finite()) {
                    let variance = deviation * deviation;
                    return Some(ReconstructError::NotPositiveDefinite { state: state.name(), time_s, variance });
                }
            }
        }
        None
    }

    /// The result, with the covariance of the final state.
    pub fn finish(mut self, covariance: Dense) -> Result<Reconstruction, ReconstructError> {
        if let Some(error) = self.error.take().or_else(|| self.smoothing_error()) {
            return Err(error);
        }
        self.result.final_covariance = covariance;
        Ok(self.result)
    }
}

/// What is wrong with a step, if anything.
fn verdict(time_s: f64, told: &dyn Fn(usize) -> f64) -> Option<ReconstructError> {
    for state in State::ALL {
        let (value, deviation) = (told(state as usize), told(DEVIATIONS + state as usize));
        if value.abs() > DIVERGED || value.is_nan() {
            return Some(ReconstructError::Diverged { state: state.name(), time_s, value });
        }
        if deviation.is_nan() {
            return Some(ReconstructError::NotPositiveDefinite { state: state.name(), time_s, variance: deviation });
        }
    }
    let theta = told(State::PitchAngle as usize);
    if theta.abs() > STEEPEST_PITCH_RAD {
        return Some(ReconstructError::NearVertical { time_s, theta_deg: theta.to_degrees() });
    }
    (told(HEALTH) <= 0.0).then_some(ReconstructError::SingularInnovation { time_s })
}
