//! Order of events: inertial samples and measurements merged by time, a step between each two.

use std::borrow::Cow;

use crate::reconstruct::data::{FilterData, InputSeries, MeasurementSeries};
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::filter::step::{BLOCK, StepInputs};
use crate::reconstruct::model::layout::{INPUTS, Input, MEASUREMENTS, Measurement};
use crate::reconstruct::settings::{InputHold, ValidSettings};

/// Part of the mean sampling interval within which a measurement counts as taken at an inertial sample.
const SAME_TIME: f64 = 1e-6;

/// End of a step.
#[derive(Clone, Copy)]
pub struct Event {
    /// Time, s.
    pub time_s: f64,
    /// Whether it is an inertial sample, not just a measurement in between.
    pub is_sample: bool,
    /// Number of measurements.
    pub degrees: u8,
    /// Index of the inertial sample at the start of the step, if there is one.
    pub start_sample: Option<usize>,
}

/// Walks through the events of a window. Measurements at or before the first inertial sample, and after the last, take
/// no part.
#[derive(Clone)]
pub struct Schedule<'a> {
    data: &'a FilterData,
    hold: InputHold,
    same_time_s: f64,
    /// Whether every measurement there is was taken at the inertial samples, all of them.
    is_synchronous: bool,
    /// Index of the next inertial sample.
    next_sample: usize,
    /// Index of the next sample of each measurement, and its time.
    next: [usize; MEASUREMENTS],
    next_time_s: [f64; MEASUREMENTS],
    time_s: f64,
    input: [f64; INPUTS],
}

impl<'a> Schedule<'a> {
    /// Schedule of checked data.
    pub fn new(data: &'a FilterData, hold: InputHold) -> Self {
        let time_s = &data.inputs.time_s;
        let start_s = time_s[0];
        let mut schedule = Self {
            data,
            hold,
            same_time_s: SAME_TIME * (time_s[time_s.len() - 1] - start_s) / (time_s.len() - 1) as f64,
            is_synchronous: false,
            next_sample: 1,
            next: [0; MEASUREMENTS],
            next_time_s: [f64::INFINITY; MEASUREMENTS],
            time_s: start_s,
            input: sample(&data.inputs, 0),
        };
        let within = schedule.same_time_s;
        let absent_or_same =
            |series: &MeasurementSeries| series.time_s.is_empty() || same_times(&series.time_s, time_s, within);
        schedule.is_synchronous = data.measurements.iter().all(absent_or_same);
        if schedule.is_synchronous {
            return schedule;
        }
        for m in 0..MEASUREMENTS {
            let times = &data.measurements[m].time_s;
            schedule.next[m] = times.partition_point(|t| *t <= start_s + schedule.same_time_s);
            schedule.find_value(m);
        }
        schedule
    }

    /// Moves measurement `m` on to its next finite value.
    fn find_value(&mut self, m: usize) {
        let series = &self.data.measurements[m];
        while self.next[m] < series.values.len() && !series.values[self.next[m]].is_finite() {
            self.next[m] += 1;
        }
        self.next_time_s[m] = series.time_s.get(self.next[m]).copied().unwrap_or(f64::INFINITY);
    }
}

impl Schedule<'_> {
    /// The steps of the next block, put into a lane of `steps`; fewer at the end of the window.
    pub fn fill<L: AsMut<[f64]>>(&mut self, lane: usize, steps: &mut [StepInputs<L>], events: &mut Vec<Event>) {
        self.begin_block(lane, steps, events);
        for i in 0..INPUTS {
            self.fill_input(i, lane, steps, events);
        }
        for m in 0..MEASUREMENTS {
            self.fill_measurement(m, lane, steps, events);
        }
    }

    /// [`Self::fill`] without what [`Self::fill_input`] and [`Self::fill_measurement`] add, so that several windows can be filled field
    /// by field. They add nothing where something is measured between inertial samples: then the steps are put in one by one here.
    pub fn begin_block<L: AsMut<[f64]>>(&mut self, lane: usize, steps: &mut [StepInputs<L>], events: &mut Vec<Event>) {
        if !self.is_synchronous {
            for step in steps {
                let Some(event) = self.next(lane, step) else { return };
                events.push(event);
            }
            return;
        }
        let times = &self.data.inputs.time_s;
        let first = self.next_sample;
        self.next_sample = times.len().min(first + BLOCK.min(steps.len()));
        for (step, k) in steps.iter_mut().zip(first..self.next_sample) {
            step.dt.as_mut()[lane] = times[k] - times[k - 1];
            step.noise_scale.as_mut()[lane] = 1.0;
            events.push(Event { time_s: times[k], is_sample: true, degrees: 0, start_sample: Some(k - 1) });
        }
    }

    /// Input `i` in a lane of the steps that [`Self::begin_block`] has begun.
    pub fn fill_input<L: AsMut<[f64]>>(&self, i: usize, lane: usize, steps: &mut [StepInputs<L>], events: &[Event]) {
        if !self.is_synchronous {
            return;
        }
        let (first, last) = (self.next_sample - events.len(), self.next_sample);
        let column = &self.data.inputs.columns[i];
        let before = &column[first - 1..last - 1];
        let after = if self.hold == InputHold::FirstOrder { &column[first..last] } else { before };
        for ((step, before), after) in steps.iter_mut().zip(before).zip(after) {
            step.inputs.start[i / 3][i % 3].as_mut()[lane] = *before;
            step.inputs.end[i / 3][i % 3].as_mut()[lane] = *after;
        }
    }

    /// Measurement `m` in a lane of the steps that [`Self::begin_block`] has begun.
    pub fn fill_measurement<L: AsMut<[f64]>>(
        &self,
        m: usize,
        lane: usize,
        steps: &mut [StepInputs<L>],
        events: &mut [Event],
    ) {
        if !self.is_synchronous {
            return;
        }
        let (first, last) = (self.next_sample - events.len(), self.next_sample);
        let values = self.data.measurements[m].values.get(first..last).unwrap_or(&[f64::NAN; BLOCK]);
        for ((step, value), event) in steps.iter_mut().zip(values).zip(events) {
            let is_present = value.is_finite();
            step.measured[m / 3][m % 3].as_mut()[lane] = if is_present { *value } else { 0.0 };
            step.present[m / 3][m % 3].as_mut()[lane] = f64::from(is_present);
            event.degrees += u8::from(is_present);
        }
    }

    /// The next step, put into a lane of `step`.
    fn next<L: AsMut<[f64]>>(&mut self, lane: usize, step: &mut StepInputs<L>) -> Option<Event> {
        let times = &self.data.inputs.time_s;
        let sample_time_s = *times.get(self.next_sample)?;
        let interval_s = sample_time_s - times[self.next_sample - 1];
        let mut time_s = sample_time_s;
        for m in 0..MEASUREMENTS {
            if self.next_time_s[m] < sample_time_s - self.same_time_s {
                time_s = time_s.min(self.next_time_s[m]);
            }
        }
        let is_sample = time_s == sample_time_s;
        let dt = time_s - self.time_s;
        let last_sample = self.next_sample - 1;
        let start_sample = (self.time_s == times[last_sample]).then_some(last_sample);
        step.dt.as_mut()[lane] = dt;
        step.noise_scale.as_mut()[lane] = interval_s / dt;
        let at_sample = sample(&self.data.inputs, self.next_sample);
        let part = if is_sample { 1.0 } else { dt / (sample_time_s - self.time_s) };
        for i in 0..INPUTS {
            step.inputs.start[i / 3][i % 3].as_mut()[lane] = self.input[i];
            if self.hold == InputHold::FirstOrder {
                self.input[i] += part * (at_sample[i] - self.input[i]);
            }
            step.inputs.end[i / 3][i % 3].as_mut()[lane] = self.input[i];
        }
        let mut degrees = 0;
        for m in 0..MEASUREMENTS {
            let (mut value, mut present) = (0.0, 0.0);
            if self.next_time_s[m] <= time_s + self.same_time_s {
                (value, present) = (self.data.measurements[m].values[self.next[m]], 1.0);
                degrees += 1;
                self.pass(m, time_s);
            }
            step.measured[m / 3][m % 3].as_mut()[lane] = value;
            step.present[m / 3][m % 3].as_mut()[lane] = present;
        }
        self.time_s = time_s;
        if is_sample {
            self.input = at_sample;
            self.next_sample += 1;
        }
        Some(Event { time_s, is_sample, degrees, start_sample })
    }

    /// Moves measurement `m` on to its next finite value after `time_s`.
    fn pass(&mut self, m: usize, time_s: f64) {
        while self.next_time_s[m] <= time_s + self.same_time_s {
            self.next[m] += 1;
            self.find_value(m);
        }
    }
}

/// Whether two columns of times agree within `within_s`. Compares all of them: that is faster than to stop early.
fn same_times(times: &[f64], others: &[f64], within_s: f64) -> bool {
    let pairs = times.iter().zip(others);
    times.len() == others.len() && pairs.fold(true, |same, (a, b)| same & ((a - b).abs() <= within_s))
}

fn sample(inputs: &InputSeries, k: usize) -> [f64; INPUTS] {
    let mut sample = [0.0; INPUTS];
    for i in 0..INPUTS {
        sample[i] = inputs.columns[i][k];
    }
    sample
}

/// The measurements at the times they were true: each sample's own less the delay of its measurement.
pub(crate) fn without_delay<'a>(data: &'a FilterData, settings: &ValidSettings) -> Cow<'a, FilterData> {
    if settings.measurement_delay_s.iter().all(|delay| *delay == 0.0) {
        return Cow::Borrowed(data);
    }
    let mut data = data.clone();
    for (series, delay) in data.measurements.iter_mut().zip(settings.measurement_delay_s) {
        if delay != 0.0 {
            series.time_s = series.time_s.iter().map(|time| time - delay).collect();
        }
    }
    Cow::Owned(data)
}

/// All steps of a window, inertial samples linear between two of them.
pub(crate) fn merged_steps(data: &FilterData) -> Vec<StepInputs<f64>> {
    let mut schedule = Schedule::new(data, InputHold::FirstOrder);
    let mut block = vec![StepInputs::uniform([0.0]); BLOCK];
    let (mut steps, mut events) = (Vec::with_capacity(data.inputs.time_s.len()), Vec::with_capacity(BLOCK));
    loop {
        events.clear();
        schedule.fill(0, &mut block, &mut events);
        if events.is_empty() {
            return steps;
        }
        steps.extend(block.iter().take(events.len()).map(StepInputs::load));
    }
}

/// Refuses data the filter cannot run on.
pub fn check(data: &FilterData) -> Result<(), ReconstructError> {
    let times = &data.inputs.time_s;
    if times.len() < 2 {
        return Err(ReconstructError::TooFewSamples { samples: times.len() });
    }
    check_times("inertial samples", times)?;
    for input in Input::ALL {
        let column = &data.inputs.columns[input as usize];
        check_lengths(input.name(), column.len(), times.len())?;
        if let Some(k) = column.iter().position(|value| !value.is_finite()) {
            return Err(ReconstructError::InputNotFinite { input: input.name(), time_s: times[k], value: column[k] });
        }
    }
    for measurement in Measurement::ALL {
        let series = &data.measurements[measurement as usize];
        check_lengths(measurement.name(), series.values.len(), series.time_s.len())?;
        check_times(measurement.name(), &series.time_s)?;
    }
    Ok(())
}

fn check_lengths(channel: &'static str, values: usize, times: usize) -> Result<(), ReconstructError> {
    if values == times { Ok(()) } else { Err(ReconstructError::UnequalLengths { channel, values, times }) }
}

fn check_times(channel: &'static str, times: &[f64]) -> Result<(), ReconstructError> {
    let ends_are_finite =
        times.first().is_none_or(|time| time.is_finite()) && times.last().is_none_or(|time| time.is_finite());
    if ends_are_finite && times.windows(2).fold(true, |increasing, pair| increasing & (pair[1] > pair[0])) {
        return Ok(());
    }
    let mut before = f64::NEG_INFINITY;
    for (sample, &time_s) in times.iter().enumerate() {
        if !(time_s > before && time_s.is_finite()) {
            return Err(ReconstructError::UnorderedTime { channel, time_s, sample });
        }
        before = time_s;
    }
    Ok(())
}
