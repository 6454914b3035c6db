//! From samples as they come to what is known of the flight.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use doublet_core::airframe::{SEA_LEVEL_KG_M3, calibrated_m_s};
use doublet_core::load::stream::RoleSample;
use doublet_core::model::Variable;
use doublet_core::prep::Differentiation;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{
    Deviations, FilterData, FilterSettings, FilteredSample, InputSeries, MEASUREMENTS, MeasurementSeries,
    Reconstruction, STATES, SequentialFilter, State, ValidSettings,
};
use doublet_core::series::{Recording, TimeRange, gap_threshold_s};

use super::airborne::{Airborne, Flown};
use super::estimates::LiveEstimates;
use super::limits::LOAD_FACTOR;
use super::order::OrderedSamples;
use super::settings::LiveSettings;
use super::update::{Counts, LiveUpdate};
use crate::stage::{WindowAero, aero, samples};

/// What the filter starts from, s.
const START_S: f64 = 1.0;
/// Samples kept before the one the filter stands at, s.
const KEPT_S: f64 = 3.0;
/// How long the inertial samples wait for other channels beyond the latency, s.
const LONGEST_WAIT_S: f64 = 0.5;
/// Age at which the last value of a channel says nothing any more, s.
const STALE_S: f64 = 2.0;
/// Time after which what cannot be computed is left behind, s.
const STUCK_S: f64 = 3.0;
/// Shortest step of the regression, s: faster samples are thinned out.
const LEAST_STEP_S: f64 = 0.01;

/// Samples in, updates out. Everything happens in the time of the samples; no clock is read.
pub struct LivePipeline {
    settings: LiveSettings,
    valid: ValidSettings,
    ordered: OrderedSamples,
    filter: Option<SequentialFilter>,
    /// Inertial sample at which the filter stands, s.
    passed_s: f64,
    /// First inertial sample since the last pause, s.
    segment_s: f64,
    path: VecDeque<FilteredSample>,
    grid: Option<Grid>,
    estimates: Option<LiveEstimates>,
    airborne: Airborne,
    /// Latest density, kg/m³; that at sea level until one is known.
    density_kg_m3: f64,
    /// Variables that the estimates began with.
    known: BTreeSet<Variable>,
    counts: Counts,
    nis: (f64, usize),
    extremes: BTreeMap<String, [f64; 2]>,
    finding: Option<String>,
    /// Pauses since the update before, a line each.
    gaps: Vec<String>,
    /// Times at which clocks began anew: the pause before each was put there.
    clock_restarts_s: Vec<f64>,
}

/// Even steps of the regression.
#[derive(Clone, Copy, Debug)]
struct Grid {
    start_s: f64,
    step_s: f64,
    /// Usual interval of the inertial samples, s.
    interval_s: f64,
    /// Samples that differentiation and smoothing reach to either side.
    reach: u64,
    /// Index of the next sample of the regression.
    next: u64,
}

impl Grid {
    /// Index of the sample nearest to a time.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of samples")]
    fn index(&self, time_s: f64) -> u64 {
        ((time_s - self.start_s) / self.step_s).round().max(0.0) as u64
    }

    fn time_s(&self, index: u64) -> f64 {
        self.start_s + self.step_s * index as f64
    }

    /// Samples missing between two that follow each other, by the usual interval.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative; more than fit are the most"
    )]
    fn missing_between(&self, before_s: f64, after_s: f64) -> u64 {
        ((after_s - before_s) / self.interval_s - 0.5).max(0.0) as u64
    }
}

impl LivePipeline {
    /// Before the first sample.
    pub fn new(settings: LiveSettings) -> Result<Self, String> {
        let delays_s = settings.filter.measurement_delay_s;
        let filter = FilterSettings { measurement_delay_s: [0.0; MEASUREMENTS], ..settings.filter.clone() };
        let in_one_line = |errors: Vec<_>| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        let valid = filter.check().map_err(in_one_line)?;
        if !(settings.update_s > 0.0 && settings.update_s.is_finite() && (0.0..=60.0).contains(&settings.latency_s)) {
            return Err("the interval of updates must be above 0 s, the latency 0 s to 60 s".to_owned());
        }
        let airborne = match &settings.aircraft {
            Some(aircraft) => Airborne::new(aircraft, settings.filter.gravity_m_s2),
            None => Airborne::without_aircraft(&settings.limits),
        };
        Ok(Self {
            settings,
            valid,
            ordered: OrderedSamples::new(&delays_s),
            filter: None,
            passed_s: f64::NEG_INFINITY,
            segment_s: f64::NEG_INFINITY,
            path: VecDeque::new(),
            grid: None,
            estimates: None,
            airborne,
            density_kg_m3: SEA_LEVEL_KG_M3,
            known: BTreeSet::new(),
            counts: Counts::default(),
            nis: (0.0, 0),
            extremes: BTreeMap::new(),
            finding: None,
            gaps: Vec::new(),
            clock_restarts_s: Vec::new(),
        })
    }

    /// Takes in samples and gives the updates that follow.
    pub fn push(&mut self, arrived: impl IntoIterator<Item = RoleSample>) -> Vec<LiveUpdate> {
        for sample in arrived {
            self.ordered.insert(sample, self.passed_s);
        }
        self.counts.late = self.ordered.late;
        let mut updates = Vec::new();
        while let Some(update) = self.advance(self.settings.latency_s, self.settings.update_s) {
            updates.push(update);
        }
        updates
    }

    /// A clock began anew: the pause before this time is not one of the flight.
    pub fn note_clock_restart(&mut self, time_s: f64) {
        self.clock_restarts_s.push(time_s);
    }

    /// Nothing comes any more: goes to the last sample.
    pub fn finish(&mut self) -> Vec<LiveUpdate> {
        let mut updates = Vec::new();
        while let Some(update) = self.advance(0.0, 0.0) {
            updates.push(update);
        }
        updates
    }

    /// One update further, where `update_s` of samples wait that are older than `latency_s`.
    fn advance(&mut self, latency_s: f64, update_s: f64) -> Option<LiveUpdate> {
        let times: Vec<f64> =
            self.ordered.base_times().into_iter().filter(|time_s| *time_s >= self.segment_s).collect();
        let (&first_s, &newest_s) = (times.first()?, times.last()?);
        if self.filter.is_none() && self.segment_s == f64::NEG_INFINITY {
            self.segment_s = first_s;
        }
        let wait_until_s = self.ordered.complete_until_s().max(newest_s - latency_s - LONGEST_WAIT_S);
        let horizon_s = if latency_s > 0.0 { (newest_s - latency_s).min(wait_until_s) } else { newest_s };
        let from_s = if self.filter.is_some() { self.passed_s } else { self.segment_s };
        let update_s = if self.filter.is_some() { update_s } else { update_s.max(START_S) };
        // A pause ends what can be computed in one go.
        let ahead: Vec<f64> = times.into_iter().filter(|time_s| *time_s >= from_s).collect();
        let longest_s = gap_threshold_s(&ahead);
        let pause = ahead.windows(2).find(|pair| pair[1] - pair[0] > longest_s);
        if let Some(&[before_s, after_s]) = pair_of(pause) {
            if horizon_s >= after_s && before_s <= from_s {
                self.begin_anew(after_s);
                return self.advance(latency_s, update_s);
            }
            if horizon_s >= after_s {
                return self.go_on(from_s, before_s, before_s, newest_s);
            }
        }
        let until_s = pause.map_or(newest_s, |pair| pair[0]);
        let target_s = if latency_s > 0.0 { horizon_s.min(from_s + update_s) } else { horizon_s };
        let end_s = ahead.iter().copied().rfind(|time_s| *time_s <= target_s.min(until_s) + 1e-9)?;
        if end_s <= from_s || (latency_s > 0.0 && horizon_s - from_s < update_s) {
            return None;
        }
        self.go_on(from_s, end_s, until_s, newest_s)
    }

    /// From one inertial sample to another; `until_s` is the last before a pause.
    fn go_on(&mut self, from_s: f64, end_s: f64, until_s: f64, newest_s: f64) -> Option<LiveUpdate> {
        let recording = self.ordered.recording(until_s, STALE_S);
        self.finding = None;
        let had_filter = self.filter.is_some();
        if let Err(line) = self.filter_to(&recording, (from_s, end_s, until_s)) {
            self.finding = Some(line);
            if self.filter.is_some() == had_filter && newest_s - from_s < STUCK_S {
                return None;
            }
            self.begin_anew(end_s);
        } else {
            self.passed_s = end_s;
            if let Err(line) = self.estimate_to(&recording, end_s) {
                self.finding = Some(line);
            }
        }
        self.ordered.forget_before(end_s - KEPT_S);
        while self.path.front().is_some_and(|sample| sample.time_s < end_s - KEPT_S) {
            self.path.pop_front();
        }
        Some(self.update(newest_s))
    }

    /// The filter starts again at `time_s`.
    fn begin_anew(&mut self, time_s: f64) {
        if self.filter.take().is_some() {
            self.counts.restarts += 1;
        }
        if self.passed_s.is_finite() {
            self.counts.skipped += self.ordered.base_samples_between(self.passed_s, time_s);
        }
        self.count_gap(time_s);
        self.path.clear();
        (self.segment_s, self.passed_s) = (time_s, self.passed_s.max(time_s - 1e-9));
        if let Some(grid) = &mut self.grid {
            grid.next = grid.index(time_s) + grid.reach;
            if let Some(estimates) = &mut self.estimates {
                estimates.skip_to(grid.next);
            }
        }
    }

    /// Filters from one inertial sample to another.
    fn filter_to(&mut self, recording: &Recording, (from_s, end_s, until_s): (f64, f64, f64)) -> Result<(), String> {
        let missing = self.ordered.missing_inputs();
        if !missing.is_empty() {
            return Err(format!("waiting for {}: no samples yet", missing.join(", ")));
        }
        let window = TimeRange { start_s: self.segment_s.max(from_s - KEPT_S), end_s: until_s };
        let aircraft = self.settings.aircraft.as_ref();
        let found = samples(recording, (window, &[]), aircraft, &self.settings.preparation)
            .map_err(|error| error.to_string())?;
        let data = part(&found.data, from_s, end_s);
        let mut filter = match self.filter.take() {
            Some(filter) => filter,
            None => {
                let filter = SequentialFilter::new(&found.data, &self.valid).map_err(|error| error.to_string())?;
                self.start_grid(&data.inputs.time_s);
                filter
            }
        };
        self.count(&data.inputs.time_s);
        let steps = filter.advance(&data).map_err(|error| {
            self.counts.restarts += 1;
            error.to_string()
        })?;
        self.decide_airborne(&steps, &data.inputs);
        for step in steps {
            self.nis = (self.nis.0 + step.nis, self.nis.1 + step.nis_degrees);
            self.note_extremes(&step);
            self.path.push_back(step);
        }
        for (k, _) in data.inputs.time_s.iter().enumerate().skip(1) {
            let load = -data.inputs.columns[2][k] / self.settings.filter.gravity_m_s2;
            note(&mut self.extremes, LOAD_FACTOR, load);
        }
        self.filter = Some(filter);
        Ok(())
    }

    /// Whether the aircraft flies, by every filtered sample and the inertial sample before it.
    fn decide_airborne(&mut self, steps: &[FilteredSample], inputs: &InputSeries) {
        let end_s = steps.last().map_or(f64::NEG_INFINITY, |step| step.time_s);
        let latest = self.ordered.latest(end_s);
        let is_on_wheels = latest.get(&Role::WeightOnWheels).is_some_and(|weight| *weight > 0.5);
        let altitude_m = latest.get(&Role::Altitude).copied();
        for step in steps {
            let [(_, airspeed_m_s), ..] = motion(step);
            let at = inputs.time_s.partition_point(|time_s| *time_s <= step.time_s).saturating_sub(1);
            let load_factor = -inputs.columns[2][at] / self.settings.filter.gravity_m_s2;
            let calibrated_m_s = calibrated_m_s(airspeed_m_s, self.density_kg_m3);
            self.airborne.take(Flown { time_s: step.time_s, calibrated_m_s, load_factor, altitude_m, is_on_wheels });
        }
    }

    /// The even steps of the regression, by the first inertial samples.
    fn start_grid(&mut self, times: &[f64]) {
        let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        intervals.sort_by(f64::total_cmp);
        let (Some(&interval_s), Some(&start_s)) = (intervals.get(intervals.len() / 2), times.first()) else { return };
        if let Some(grid) = &mut self.grid {
            grid.next = grid.index(start_s) + grid.reach;
            return;
        }
        let step_s = interval_s * (LEAST_STEP_S / interval_s - 1e-6).ceil().max(1.0);
        let half_width = match self.settings.preparation.differentiation_half_width_s {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
            Some(half_width_s) => (half_width_s / step_s).round().clamp(1.0, 1000.0) as u64,
            None => Differentiation::Central4.half_width() as u64,
        };
        let reach = half_width + 2;
        self.grid = Some(Grid { start_s, step_s, interval_s, reach, next: reach });
    }

    /// Counts the samples and those that never came.
    fn count(&mut self, times: &[f64]) {
        let Some(grid) = self.grid else { return };
        for pair in times.windows(2) {
            self.counts.samples += 1;
            self.counts.lost += grid.missing_between(pair[0], pair[1]);
        }
    }

    /// Counts the samples missing in the pause that ends at `time_s`.
    fn count_gap(&mut self, time_s: f64) {
        let (Some(grid), Some(before_s)) = (self.grid, self.ordered.base_before_s(time_s)) else { return };
        let is_restart = self.clock_restarts_s.iter().any(|at_s| *at_s > before_s && *at_s <= time_s);
        let missing = grid.missing_between(before_s, time_s);
        if !is_restart && missing > 0 {
            self.counts.lost += missing;
            let pause_s = time_s - before_s;
            self.gaps.push(format!(
                "{missing} inertial samples lost in {pause_s:.1} s after t={before_s:.2}s; the filter restarted"
            ));
        }
    }

    /// Coefficients and their regression, as far as the filter went.
    fn estimate_to(&mut self, recording: &Recording, end_s: f64) -> Result<(), String> {
        let (Some(aircraft), Some(mut grid)) = (&self.settings.aircraft, self.grid) else { return Ok(()) };
        let path_start_s = self.path.front().map_or(f64::INFINITY, |sample| sample.time_s);
        while grid.time_s(grid.next.saturating_sub(grid.reach)) < path_start_s - 1e-9 && grid.time_s(grid.next) < end_s
        {
            grid.next += 1;
        }
        // Rows up to this one, exclusive, have their neighbours.
        let last = grid.index(end_s - 0.5 * grid.step_s);
        let end = (last + 1).saturating_sub(grid.reach);
        if end <= grid.next {
            return Ok(());
        }
        let first = grid.next.saturating_sub(grid.reach);
        let times: Arc<[f64]> = (first..=last).map(|index| grid.time_s(index)).collect();
        let path = reconstruction(&self.path, &times);
        let inputs = InputSeries { time_s: times, columns: Default::default() };
        let data = FilterData { inputs, measurements: std::array::from_fn(|_| MeasurementSeries::default()) };
        grid.next = end;
        self.grid = Some(grid);
        let formed = aero(recording, (&data, &path), (aircraft, &[]), &self.settings.preparation)
            .map_err(|error| error.to_string())?;
        self.note_airspeeds(&formed);
        let known: BTreeSet<Variable> = formed.variables.known().collect();
        // A channel that begins later than the others begins the estimates anew: nothing could be told of it before.
        let estimates = match self.estimates.take().filter(|_| known.is_subset(&self.known)) {
            Some(estimates) => self.estimates.insert(estimates),
            None => {
                let new = LiveEstimates::new(&self.settings, &known, grid.step_s, first);
                self.known = known;
                self.estimates.insert(new.map_err(|error| error.to_string())?)
            }
        };
        let is_airborne = self.airborne.is_airborne();
        estimates.take(&formed, |time_s| grid.index(time_s), end, is_airborne)
    }

    /// Calibrated airspeeds, for the limits.
    fn note_airspeeds(&mut self, formed: &WindowAero) {
        for (airspeed, density) in formed.data.airspeed_m_s.iter().zip(formed.data.density_kg_m3.iter()) {
            self.density_kg_m3 = *density;
            if self.airborne.is_airborne() {
                note(&mut self.extremes, Role::CalibratedAirspeed.name(), calibrated_m_s(*airspeed, *density));
            }
        }
    }

    fn note_extremes(&mut self, step: &FilteredSample) {
        for (name, value) in motion(step) {
            note(&mut self.extremes, name, value);
        }
    }

    /// What is known now.
    fn update(&mut self, newest_s: f64) -> LiveUpdate {
        let mut state: BTreeMap<String, f64> = self
            .ordered
            .latest(self.passed_s)
            .into_iter()
            .map(|(role, value)| (role.name().to_owned(), value))
            .collect();
        for (name, value) in &state {
            note(&mut self.extremes, name, *value);
        }
        if let Some(az) = state.get(Role::SpecificForceZ.name()) {
            state.insert(LOAD_FACTOR.to_owned(), -az / self.settings.filter.gravity_m_s2);
        }
        if let Some(step) = self.path.back() {
            state.extend(motion(step).into_iter().map(|(name, value)| (name.to_owned(), value)));
        }
        let is_airborne = self.airborne.is_airborne();
        let estimates = self.estimates.as_ref();
        let derivatives = estimates.map(|estimates| estimates.derivatives(&self.settings)).unwrap_or_default();
        let extremes = std::mem::take(&mut self.extremes);
        let (nis, degrees) = std::mem::take(&mut self.nis);
        let own = std::mem::take(&mut self.gaps).into_iter().chain(self.finding.clone());
        let is_enough = !derivatives.is_empty()
            && derivatives.iter().all(|derivative| derivative.level == crate::session::Level::Good);
        LiveUpdate {
            time_s: self.passed_s,
            lag_s: newest_s - self.passed_s,
            counts: self.counts,
            state,
            nis_per_measurement: (degrees > 0).then(|| nis / degrees as f64),
            is_airborne,
            correlation: estimates.and_then(LiveEstimates::correlation),
            derivatives,
            limits: self
                .settings
                .limits
                .iter()
                .filter_map(|limit| Some(limit.read(&extremes)?.silence_on_ground(is_airborne)))
                .collect(),
            is_enough,
            findings: own.chain(estimates.into_iter().flat_map(|estimates| estimates.findings.clone())).collect(),
            alarms: Vec::new(),
        }
    }
}

/// A slice of two as an array.
fn pair_of(pair: Option<&[f64]>) -> Option<&[f64; 2]> {
    pair.and_then(|pair| pair.first_chunk())
}

/// Widens the range of a quantity.
fn note(extremes: &mut BTreeMap<String, [f64; 2]>, name: &str, value: f64) {
    match extremes.get_mut(name) {
        Some([low, high]) => (*low, *high) = (low.min(value), high.max(value)),
        None => {
            extremes.insert(name.to_owned(), [value; 2]);
        }
    }
}

/// Quantities of the motion at a filtered sample, by the names of their roles.
fn motion(step: &FilteredSample) -> [(&'static str, f64); 6] {
    let state = |state: State| step.states[state as usize];
    let [u, v, w] = [State::VelocityU, State::VelocityV, State::VelocityW].map(state);
    [
        (Role::TrueAirspeed.name(), u.hypot(v).hypot(w)),
        (Role::AngleOfAttack.name(), w.atan2(u)),
        (Role::Sideslip.name(), v.atan2(u.hypot(w))),
        (Role::BankAngle.name(), state(State::BankAngle)),
        (Role::PitchAngle.name(), state(State::PitchAngle)),
        (Role::HeadingAngle.name(), state(State::HeadingAngle)),
    ]
}

/// Inertial samples from one to another and the measurements after the first.
fn part(data: &FilterData, from_s: f64, end_s: f64) -> FilterData {
    let time_s = &data.inputs.time_s;
    let first = time_s.partition_point(|time| *time < from_s - 1e-9);
    let end = time_s.partition_point(|time| *time <= end_s + 1e-9).max(first);
    let cut = |column: &Arc<[f64]>| Arc::from(&column[first..end]);
    let inputs = InputSeries { time_s: time_s[first..end].into(), columns: data.inputs.columns.each_ref().map(cut) };
    let measurements = data.measurements.each_ref().map(|series| {
        let first = series.time_s.partition_point(|time| *time <= from_s);
        let end = series.time_s.partition_point(|time| *time <= end_s).max(first);
        MeasurementSeries { time_s: series.time_s[first..end].into(), values: series.values[first..end].into() }
    });
    FilterData { inputs, measurements }
}

/// The filtered path at the times of a grid, by straight lines.
fn reconstruction(path: &VecDeque<FilteredSample>, times: &Arc<[f64]>) -> Reconstruction {
    let mut states: [Vec<f64>; STATES] = std::array::from_fn(|_| Vec::with_capacity(times.len()));
    let mut after = 0;
    for &time_s in times.iter() {
        while path.get(after).is_some_and(|sample| sample.time_s < time_s) && after + 1 < path.len() {
            after += 1;
        }
        let (before, next) = (path.get(after.saturating_sub(1)), path.get(after));
        let (Some(before), Some(next)) = (before, next) else { continue };
        let length = next.time_s - before.time_s;
        let share = if length > 0.0 { ((time_s - before.time_s) / length).clamp(0.0, 1.0) } else { 1.0 };
        for (k, column) in states.iter_mut().enumerate() {
            column.push(before.states[k] + share * (next.states[k] - before.states[k]));
        }
    }
    let zeros = || vec![0.0; times.len()];
    Reconstruction {
        states,
        deviations: std::array::from_fn(|_| Deviations::constant(0.0, times.len())),
        update_time_s: Arc::clone(times),
        time_s: Arc::clone(times),
        innovations: std::array::from_fn(|_| Vec::new()),
        innovation_deviations: std::array::from_fn(|_| Vec::new().into()),
        nis: zeros(),
        nis_degrees: vec![0; times.len()],
        log_likelihood: f64::NAN,
        air_data: None,
        final_covariance: nalgebra::SMatrix::zeros(),
        smoothed: None,
        max_iterations_used: 0,
        outliers: Default::default(),
        warnings: Vec::new(),
    }
}
