//! A window on its way through the filter: its schedule, what became of it so far, and the first thing that went wrong.

use super::dense::Dense;
use super::form::Form;
use super::initial::initial_state;
use super::layout::{AIR_STATES, INPUTS, MEASUREMENTS, State};
use super::march::{
    AIR_DATA, AIR_DATA_DEVIATIONS, BLOCK, DEVIATIONS, FULL_RECORD, HEALTH, INNOVATION_DEVIATIONS, INNOVATIONS,
    ITERATIONS, NIS, NOISE_SHARE, RECORD, SEEN_MEASUREMENT_NOISE, SEEN_PROCESS_NOISE, STEEPEST_PITCH_RAD,
};
use super::real::Real;
use super::schedule::{DRIVE, Event, Schedule, check};
use super::settings::ValidSettings;
use super::{AirData, FilterData, ReconstructError, Reconstruction, Smoothed};

/// Magnitude beyond which a state means divergence, SI: no aircraft is there.
const DIVERGED: f64 = 1e8;

/// Product of noise shares below which its logarithm is taken: far from where numbers end.
const LEAST_SHARE: f64 = 1e-100;

/// A window on its way through the filter.
pub struct Window<'a> {
    /// Steps still to come.
    pub schedule: Schedule<'a>,
    /// What the steps told so far.
    pub result: Reconstruction,
    /// Events of the block under way.
    pub events: Vec<Event>,
    /// `ln (2 pi R)` of each measurement.
    log_noise: [f64; MEASUREMENTS],
    /// Their sum.
    log_noise_of_all: f64,
    /// Whether all events of the block under way are inertial samples.
    only_samples: bool,
    /// Noises the smoother saw.
    pub seen: NoiseSeen,
    /// First thing that went wrong.
    error: Option<ReconstructError>,
}

/// Sums of expected squares of the noises, given all measurements, and how many there were.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseSeen {
    /// Of the inputs; one per step.
    pub process: [f64; INPUTS],
    /// Number of steps.
    pub steps: usize,
    /// Of the measurements.
    pub measurement: [f64; MEASUREMENTS],
    /// Number of samples of each.
    pub samples: [usize; MEASUREMENTS],
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
            final_covariance: Dense::zeros(),
            smoothed: None,
            max_iterations_used: 0,
            warnings,
        };
        let schedule = Schedule::new(data, settings.hold);
        let log_noise = settings.measurement_noise.map(|deviation| (std::f64::consts::TAU * deviation.powi(2)).ln());
        let events = Vec::with_capacity(BLOCK);
        let log_noise_of_all = log_noise.iter().sum();
        let seen = NoiseSeen::default();
        Ok(Self { schedule, result, events, log_noise, log_noise_of_all, only_samples: false, seen, error: None })
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

    /// Looks for what went wrong in the block, and says whether there is anything to take.
    fn judge<F: Form>(&mut self, lane: usize, record: &[f64]) {
        let lanes = F::Number::LANES;
        let told = |step: usize, field: usize| record[(step * F::ROW + field) * lanes + lane];
        let Some(last) = self.events.len().checked_sub(1) else { return };
        for step in 0..=last {
            if told(step, HEALTH) <= 0.0 || told(step, HEALTH).is_nan() || step == last {
                self.error = verdict(self.events[step].time_s, &|field| told(step, field));
                if self.error.is_some() {
                    return self.events.clear();
                }
            }
        }
        self.only_samples = self.events.iter().all(|event| event.is_sample);
    }

    /// Takes one field of the steps of the block: states and what goes with them at the samples, innovations at every event.
    fn take_field<F: Form>(&mut self, field: usize, lane: usize, record: &[f64]) {
        let result = &mut self.result;
        let lanes = F::Number::LANES;
        let told = record[field * lanes + lane..].iter().step_by(F::ROW * lanes).zip(&self.events);
        let column = match (field, &mut result.air_data) {
            (0..DEVIATIONS, _) => &mut result.states[field],
            (DEVIATIONS..INNOVATIONS, _) => &mut result.deviations[field - DEVIATIONS],
            (INNOVATIONS..INNOVATION_DEVIATIONS, _) => &mut result.innovations[field - INNOVATIONS],
            (INNOVATION_DEVIATIONS..NIS, _) => &mut result.innovation_deviations[field - INNOVATION_DEVIATIONS],
            (AIR_DATA..AIR_DATA_DEVIATIONS, Some(air_data)) => &mut air_data.states[field - AIR_DATA],
            (AIR_DATA_DEVIATIONS..FULL_RECORD, Some(air_data)) => &mut air_data.deviations[field - AIR_DATA_DEVIATIONS],
            _ => return,
        };
        if self.only_samples || (INNOVATIONS..NIS).contains(&field) {
            let filled = column.len();
            column.resize(filled + self.events.len(), 0.0);
            for (value, (told, _)) in column[filled..].iter_mut().zip(told) {
                *value = *told;
            }
        } else {
            column.extend(told.filter(|(_, event)| event.is_sample).map(|(told, _)| *told));
        }
    }

    /// Takes what the block told of its times and its likelihood.
    fn take_likelihood<F: Form>(&mut self, lane: usize, record: &[f64]) {
        let result = &mut self.result;
        let lanes = F::Number::LANES;
        let told = |step: usize, field: usize| record[(step * F::ROW + field) * lanes + lane];
        // One logarithm for many steps.
        let (mut share, mut minus_two_log) = (1.0, 0.0);
        for (step, event) in self.events.iter().enumerate() {
            let nis = if event.degrees > 0 { told(step, NIS) } else { f64::NAN };
            result.update_time_s.push(event.time_s);
            result.nis.push(nis);
            result.nis_degrees.push(event.degrees);
            if event.degrees > 0 {
                let measured = |m: &usize| !told(step, INNOVATIONS + m).is_nan();
                let noise = if usize::from(event.degrees) == MEASUREMENTS {
                    self.log_noise_of_all
                } else {
                    (0..MEASUREMENTS).filter(measured).map(|m| self.log_noise[m]).sum()
                };
                minus_two_log += noise + nis;
                share *= told(step, NOISE_SHARE);
                if share < LEAST_SHARE {
                    minus_two_log -= share.ln();
                    share = 1.0;
                }
            }
            result.max_iterations_used = result.max_iterations_used.max(told(step, ITERATIONS) as usize);
        }
        result.log_likelihood -= 0.5 * (minus_two_log - share.ln());
    }

    /// The smoothed path ends where the filtered one does.
    pub fn begin_smoothing(&mut self) {
        let result = &mut self.result;
        result.smoothed = Some(Smoothed {
            states: result.states.clone(),
            deviations: result.deviations.clone(),
            air_data: result.air_data.clone(),
            costs: Vec::new(),
        });
    }

    /// Takes one field of what the smoother told of the starts of the steps of a block.
    fn take_smoothed_field<F: Form>(&mut self, field: usize, lane: usize, record: &[f64]) {
        let Some(smoothed) = &mut self.result.smoothed else { return };
        let column = match (field, &mut smoothed.air_data) {
            (0..DEVIATIONS, _) => &mut smoothed.states[field],
            (DEVIATIONS..INNOVATIONS, _) => &mut smoothed.deviations[field - DEVIATIONS],
            (AIR_DATA..AIR_DATA_DEVIATIONS, Some(air_data)) => &mut air_data.states[field - AIR_DATA],
            (AIR_DATA_DEVIATIONS..FULL_RECORD, Some(air_data)) => &mut air_data.deviations[field - AIR_DATA_DEVIATIONS],
            _ => return,
        };
        let lanes = F::Number::LANES;
        let told = record[field * lanes + lane..].iter().step_by(F::ROW * lanes);
        for (told, event) in told.zip(&self.events) {
            if let Some(row) = event.start_sample {
                column[row] = *told;
            }
        }
    }

    /// Takes the noises the smoother saw in the block.
    fn take_noise<F: Form>(&mut self, lane: usize, record: &[f64]) {
        let lanes = F::Number::LANES;
        for step in 0..self.events.len() {
            let told = |field: usize| record[(step * F::ROW + field) * lanes + lane];
            for i in 0..INPUTS {
                self.seen.process[i] += told(SEEN_PROCESS_NOISE + i);
            }
            self.seen.steps += 1;
            for m in 0..MEASUREMENTS {
                let square = told(SEEN_MEASUREMENT_NOISE + m);
                if square.is_finite() {
                    self.seen.measurement[m] += square;
                    self.seen.samples[m] += 1;
                }
            }
        }
    }

    /// A state known exactly, or nearly so, at the start has next to no smoothed variance there, of which rounding may leave a
    /// negative number: the filter's own deviation, no smaller than the smoothed one, then stands for it.
    fn mend_known_starts(&mut self) {
        /// Samples within which rounding may be larger than the variance.
        const FIRST: usize = 10;
        /// First deviation of a state, as a part of its largest, that counts as known: its square is then lost in the others.
        const KNOWN: f64 = 1e-4;
        let Some(smoothed) = &mut self.result.smoothed else { return };
        for (filtered, smoothed) in self.result.deviations.iter().zip(&mut smoothed.deviations) {
            let lost = smoothed.iter().take(FIRST).take_while(|deviation| deviation.is_nan()).count();
            if lost > 0 && filtered[0] < KNOWN * filtered.iter().copied().fold(0.0, f64::max) {
                smoothed[..lost].copy_from_slice(&filtered[..lost]);
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

    /// The result, with the covariance of the final state, and the noises the smoother saw.
    pub fn finish(mut self, covariance: Dense) -> Result<(Reconstruction, NoiseSeen), ReconstructError> {
        self.mend_known_starts();
        if let Some(error) = self.error.take().or_else(|| self.smoothing_error()) {
            return Err(error);
        }
        self.result.final_covariance = covariance;
        Ok((self.result, self.seen))
    }
}

/// Windows side by side; one that could not be prepared keeps its lane.
pub type Windows<'a> = [Result<Window<'a>, ReconstructError>];

/// Takes what a block told of every window. Field by field, because the lanes of a field lie side by side.
pub fn drain<F: Form>(windows: &mut Windows<'_>, record: &[f64]) {
    each(windows, |lane, window| window.judge::<F>(lane, record));
    for field in (0..NIS).chain(RECORD..F::ROW) {
        each(windows, |lane, window| window.take_field::<F>(field, lane, record));
    }
    each(windows, |lane, window| window.take_likelihood::<F>(lane, record));
}

/// Takes what the smoother told of a block; `see_noise` for the noises as well.
pub fn drain_smoothed<F: Form>(windows: &mut Windows<'_>, see_noise: bool, record: &[f64]) {
    for field in (0..INNOVATIONS).chain(RECORD..F::ROW) {
        each(windows, |lane, window| window.take_smoothed_field::<F>(field, lane, record));
    }
    if see_noise {
        each(windows, |lane, window| window.take_noise::<F>(lane, record));
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
