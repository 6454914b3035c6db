//! Order of events: inertial samples and measurements merged by time, a step between each two.

use super::layout::{INPUTS, Input, MEASUREMENTS, Measurement};
use super::march::BLOCK;
use super::{FilterData, InputHold, InputSeries, MeasurementSeries, ReconstructError};

/// Part of the mean sampling interval within which a measurement counts as taken at an inertial sample.
const SAME_TIME: f64 = 1e-6;

/// Numbers that drive one step, in this order: length, noise scale, inputs at both ends, measurements, their presence.
pub const DRIVE: usize = 2 + 2 * INPUTS + 2 * MEASUREMENTS;
/// Place of the ratio of the sampling interval to the length of the step.
pub const NOISE_SCALE: usize = 1;
/// Place of the inputs at the start.
pub const START: usize = 2;
/// Place of the inputs at the end.
pub const END: usize = START + INPUTS;
/// Place of the measurements.
pub const MEASURED: usize = END + INPUTS;
/// Place of their presence, 0 or 1.
pub const PRESENT: usize = MEASURED + MEASUREMENTS;

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
    /// The steps of the next block, put into every `stride`-th number of `drive`; fewer at the end of the window.
    pub fn fill(&mut self, drive: &mut [f64], stride: usize, events: &mut Vec<Event>) {
        if self.is_synchronous {
            return self.fill_synchronous(drive, stride, events);
        }
        while events.len() < BLOCK {
            let Some(event) = self.next(&mut drive[events.len() * DRIVE * stride..], stride) else { return };
            events.push(event);
        }
    }

    /// Column by column, where every step ends at an inertial sample and nothing is measured in between.
    fn fill_synchronous(&mut self, drive: &mut [f64], stride: usize, events: &mut Vec<Event>) {
        let FilterData { inputs, measurements } = self.data;
        let times = &inputs.time_s;
        let first = self.next_sample;
        let last = times.len().min(first + BLOCK);
        for k in first..last {
            let step = &mut drive[(k - first) * DRIVE * stride..];
            step[0] = times[k] - times[k - 1];
            step[NOISE_SCALE * stride] = 1.0;
            events.push(Event { time_s: times[k], is_sample: true, degrees: 0, start_sample: Some(k - 1) });
        }
        let row = DRIVE * stride;
        let mut put = |field: usize, values: &[f64]| {
            for (drive, value) in drive[field * stride..].iter_mut().step_by(row).zip(values) {
                *drive = *value;
            }
        };
        for (i, column) in inputs.columns.iter().enumerate() {
            let before = &column[first - 1..last - 1];
            put(START + i, before);
            put(END + i, if self.hold == InputHold::FirstOrder { &column[first..last] } else { before });
        }
        for (m, series) in measurements.iter().enumerate() {
            if series.values.is_empty() {
                put(MEASURED + m, &[0.0; BLOCK]);
                put(PRESENT + m, &[0.0; BLOCK]);
                continue;
            }
            let (mut values, mut present) = ([0.0; BLOCK], [0.0; BLOCK]);
            for (k, &value) in series.values[first..last].iter().enumerate() {
                let is_there = value.is_finite();
                values[k] = if is_there { value } else { 0.0 };
                present[k] = if is_there { 1.0 } else { 0.0 };
                events[k].degrees += u8::from(is_there);
            }
            put(MEASURED + m, &values);
            put(PRESENT + m, &present);
        }
        self.next_sample = last;
    }

    /// The next step, put into every `stride`-th number of `drive`.
    fn next(&mut self, drive: &mut [f64], stride: usize) -> Option<Event> {
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
        drive[0] = dt;
        drive[NOISE_SCALE * stride] = interval_s / dt;
        let at_sample = sample(&self.data.inputs, self.next_sample);
        let part = if is_sample { 1.0 } else { dt / (sample_time_s - self.time_s) };
        for i in 0..INPUTS {
            drive[(START + i) * stride] = self.input[i];
            if self.hold == InputHold::FirstOrder {
                self.input[i] += part * (at_sample[i] - self.input[i]);
            }
            drive[(END + i) * stride] = self.input[i];
        }
        let mut degrees = 0;
        for m in 0..MEASUREMENTS {
            let (mut value, mut present) = (0.0, 0.0);
            if self.next_time_s[m] <= time_s + self.same_time_s {
                (value, present) = (self.data.measurements[m].values[self.next[m]], 1.0);
                degrees += 1;
                self.pass(m, time_s);
            }
            drive[(MEASURED + m) * stride] = value;
            drive[(PRESENT + m) * stride] = present;
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
