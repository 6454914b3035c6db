//! From recorded samples to a reconstruction: manoeuvres side by side in lanes, block by block.

use std::ops::ControlFlow;

use nalgebra::SMatrix;

use super::blocks::Vec3;
use super::covariance::{ATT, Covariance, GROUPS};
use super::initial::initial_state;
use super::joseph::DenseEstimate;
use super::kernel::{Estimate, Step, Telling, Tuning};
#[cfg(target_arch = "x86_64")]
use super::lanes::{Eight, Four};
use super::lanes::{Lanes, MOST_LANES, Two, Width, widest};
use super::layout::{MEASUREMENTS, STATES, State};
use super::real::Real;
use super::schedule::{DRIVE, END, Event, MEASURED, NOISE_SCALE, PRESENT, START, Schedule, check};
use super::settings::{Linearisation, Method, ValidSettings};
use super::smoother::{Kept, smooth_step};
use super::transition::Inputs;
use super::{FilterData, ReconstructError, Reconstruction, Smoothed};

/// Steps between two looks at the watcher.
const BLOCK: usize = 32;
/// Numbers one step tells: states, their deviations, innovations, their deviations, NIS, health, iterations.
const RECORD: usize = 2 * STATES + 2 * MEASUREMENTS + 3;
const DEVIATIONS: usize = STATES;
const INNOVATIONS: usize = 2 * STATES;
const INNOVATION_DEVIATIONS: usize = INNOVATIONS + MEASUREMENTS;
const NIS: usize = INNOVATION_DEVIATIONS + MEASUREMENTS;
const HEALTH: usize = NIS + 1;
const ITERATIONS: usize = NIS + 2;

/// Pitch angle beyond which Euler angles are refused, rad.
const STEEPEST_PITCH_RAD: f64 = 89.0 * std::f64::consts::PI / 180.0;
/// Magnitude beyond which a state means divergence, SI: no aircraft is there.
const DIVERGED: f64 = 1e8;

/// Called between blocks with the part done, 0 to 1; `Break` cancels.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Reconstructs the flight path of one window.
///
/// Extended or iterated extended Kalman filter over the kinematic model of thesis Eq. 3.7 with the measurements of
/// Eq. 3.8, any subset of them, each at its own times. A measurement between two inertial samples splits the step
/// there. The first inertial sample starts the filter and measurements up to it are not updated with: they may have
/// given the initial state.
///
/// # Errors
/// Data that cannot be filtered, divergence, and cancellation by `watch`; never a result that is not finite.
pub fn reconstruct(
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let mut results = reconstruct_many(&[data], settings, watch);
    results.pop().unwrap_or(Err(ReconstructError::TooFewSamples { samples: 0 }))
}

/// Reconstructs several windows, as many side by side as the machine has lanes. Results come in the order of `data`,
/// and do not depend on which windows share a group. For several threads, give each the windows of some of the
/// [`lane_groups`].
pub fn reconstruct_many(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    reconstruct_with(widest(), data, settings, watch)
}

/// [`reconstruct_many`] with vectors of a given width, which the machine must have.
fn reconstruct_with(
    width: Width,
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let mut results: Vec<Option<Result<Reconstruction, ReconstructError>>> = data.iter().map(|_| None).collect();
    let groups = groups_of(width.lanes(), data);
    let total: usize = data.iter().map(|window| window.inputs.time_s.len()).sum();
    let mut done = 0;
    for group in groups {
        let windows: Vec<&FilterData> = group.iter().map(|&k| data[k]).collect();
        let samples: usize = windows.iter().map(|window| window.inputs.time_s.len()).sum();
        let mut part = |part: f64| watch((done as f64 + part * samples as f64) / total.max(1) as f64);
        let outcome = match width {
            Width::Two => run_group::<Two>(&windows, settings, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Four => run_group::<Four>(&windows, settings, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Eight => run_group::<Eight>(&windows, settings, &mut part),
            #[cfg(not(target_arch = "x86_64"))]
            Width::Four | Width::Eight => run_group::<Two>(&windows, settings, &mut part),
        };
        done += samples;
        for (&k, result) in group.iter().zip(outcome) {
            results[k] = Some(match result {
                Err(error) if error.is_numerical() => run_joseph(data[k], settings, &error, watch),
                result => result,
            });
        }
    }
    results.into_iter().map(|result| result.unwrap_or(Err(ReconstructError::Cancelled))).collect()
}

/// Number of windows the machine runs side by side.
pub fn lanes() -> usize {
    widest().lanes()
}

/// Groups of windows, by index, that run side by side: as many as there are lanes, of similar length.
pub fn lane_groups(data: &[&FilterData]) -> Vec<Vec<usize>> {
    groups_of(lanes(), data)
}

fn groups_of(lanes: usize, data: &[&FilterData]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by_key(|&k| data[k].inputs.time_s.len());
    order.chunks(lanes).map(<[usize]>::to_vec).collect()
}

/// A window on its way through the filter.
struct Window<'a> {
    schedule: Schedule<'a>,
    result: Reconstruction,
    /// Events of the block under way.
    events: Vec<Event>,
    /// First thing that went wrong.
    error: Option<ReconstructError>,
}

/// Reconstructs at most `T::LANES` windows.
fn run_group<T: Lanes>(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let mut windows: Vec<Result<Window<'_>, ReconstructError>> =
        data.iter().map(|data| Window::new(data, settings)).collect();
    let mut estimate = initial_estimate::<T>(&windows, settings);
    let tuning = tuning::<T>(settings);
    let mut drive = vec![0.0; BLOCK * DRIVE * T::LANES];
    let mut record = vec![0.0; BLOCK * RECORD * T::LANES];
    let samples = data.iter().map(|data| data.inputs.time_s.len()).max().unwrap_or(0);
    let mut checkpoints = Vec::new();
    loop {
        if settings.smooth {
            checkpoints.push(Checkpoint { estimate, schedules: schedules(&windows) });
        }
        let mut steps = 0;
        let mut done = samples;
        drive.fill(0.0);
        for (lane, window) in windows.iter_mut().enumerate() {
            if let Ok(window) = window {
                window.fill::<T>(lane, &mut drive);
                steps = steps.max(window.events.len());
                done = done.min(window.result.time_s.len().max(window.result.states[0].len()));
            }
        }
        if steps == 0 {
            break;
        }
        T::run(&mut estimate, &tuning, steps, &drive, &mut record);
        for (lane, window) in windows.iter_mut().enumerate() {
            if let Ok(window) = window {
                window.drain::<T>(lane, &record);
            }
        }
        if watch(done as f64 / samples as f64).is_break() {
            return data.iter().map(|_| Err(ReconstructError::Cancelled)).collect();
        }
    }
    if settings.smooth && smooth_group(&mut windows, estimate, &tuning, &checkpoints, watch).is_break() {
        return data.iter().map(|_| Err(ReconstructError::Cancelled)).collect();
    }
    let mut results = Vec::with_capacity(windows.len());
    for (lane, window) in windows.into_iter().enumerate() {
        results.push(window.and_then(|window| window.finish(lane, &estimate.p)));
    }
    results
}

/// Where a block began: enough to run it again.
struct Checkpoint<'a, T> {
    estimate: Estimate<T>,
    schedules: Vec<Option<Schedule<'a>>>,
}

fn schedules<'a>(windows: &[Result<Window<'a>, ReconstructError>]) -> Vec<Option<Schedule<'a>>> {
    windows.iter().map(|window| window.as_ref().ok().map(|window| window.schedule.clone())).collect()
}

/// Goes back through the blocks from the final estimate. Each is filtered again from its checkpoint, so that only one
/// block at a time is held whole.
fn smooth_group<'a, T: Lanes>(
    windows: &mut [Result<Window<'a>, ReconstructError>],
    last: Estimate<T>,
    tuning: &Tuning<T>,
    checkpoints: &[Checkpoint<'a, T>],
    watch: Watch<'_>,
) -> ControlFlow<()> {
    let mut smoothed = last;
    let mut drive = vec![0.0; BLOCK * DRIVE * T::LANES];
    let mut record = vec![0.0; BLOCK * RECORD * T::LANES];
    let mut kept = Vec::with_capacity(BLOCK);
    for window in windows.iter_mut().flatten() {
        window.begin_smoothing();
    }
    for checkpoint in checkpoints.iter().rev() {
        drive.fill(0.0);
        let mut steps = 0;
        for (lane, (window, schedule)) in windows.iter_mut().zip(&checkpoint.schedules).enumerate() {
            if let (Ok(window), Some(schedule)) = (window, schedule) {
                window.schedule = schedule.clone();
                window.fill::<T>(lane, &mut drive);
                steps = steps.max(window.events.len());
            }
        }
        T::smooth(&checkpoint.estimate, &mut smoothed, tuning, steps, &drive, &mut kept, &mut record);
        for (lane, window) in windows.iter_mut().enumerate() {
            if let Ok(window) = window {
                window.drain_smoothed::<T>(lane, &record);
            }
        }
        watch(1.0)?;
    }
    ControlFlow::Continue(())
}

/// The kernel over `steps` steps from `start`, kept, and back again: `smoothed` enters at the end of the block and leaves
/// at its start.
#[inline(always)]
pub fn smooth_block<T: Real>(
    start: &Estimate<T>,
    smoothed: &mut Estimate<T>,
    tuning: &Tuning<T>,
    steps: usize,
    drive: &[f64],
    kept: &mut Vec<Kept<T>>,
    record: &mut [f64],
) {
    kept.clear();
    let mut estimate = *start;
    for drive in drive.chunks_exact(DRIVE * T::LANES).take(steps) {
        let step = read_step::<T>(drive);
        let before = estimate;
        let (phi, trig) = estimate.predict(&step, tuning);
        kept.push(Kept { before, phi, predicted: estimate });
        estimate.update(&step, &trig, tuning);
    }
    for k in (0..steps).rev() {
        let step = read_step::<T>(&drive[k * DRIVE * T::LANES..]);
        smooth_step(smoothed, &kept[k], &step, tuning);
        let record = &mut record[k * RECORD * T::LANES..];
        for field in 0..STATES {
            let (g, i) = (field / 3, field % 3);
            smoothed.x[g][i].store(&mut record[field * T::LANES..]);
            smoothed.p.variances(g)[i].sqrt().store(&mut record[(DEVIATIONS + field) * T::LANES..]);
        }
    }
}

/// Reconstructs one window with the dense Joseph form, after `cause` stopped the packed one.
fn run_joseph(
    data: &FilterData,
    settings: &ValidSettings,
    cause: &ReconstructError,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let mut windows = [Window::new(data, settings)];
    let mut estimate = DenseEstimate::new(&initial_estimate::<f64>(&windows, settings));
    let [window] = &mut windows;
    let window = window.as_mut().map_err(|error| error.clone())?;
    let tuning = tuning::<f64>(settings);
    let mut drive = vec![0.0; BLOCK * DRIVE];
    let mut record = vec![0.0; BLOCK * RECORD];
    loop {
        drive.fill(0.0);
        window.fill::<f64>(0, &mut drive);
        if window.events.is_empty() {
            break;
        }
        let steps = drive.chunks_exact(DRIVE).zip(record.chunks_exact_mut(RECORD)).take(window.events.len());
        for (drive, record) in steps {
            let step = read_step::<f64>(drive);
            let telling = estimate.step(&step, &tuning);
            tell(&estimate.x, &estimate.variances(), &step, &telling, record);
        }
        window.drain::<f64>(0, &record);
        if watch(window.result.states[0].len() as f64 / window.result.time_s.len() as f64).is_break() {
            return Err(ReconstructError::Cancelled);
        }
    }
    if let Some(error) = window.error.take() {
        return Err(error);
    }
    window.result.final_covariance = estimate.p;
    window.result.warnings.push(format!("recomputed with a dense covariance in Joseph form, because {cause}"));
    if settings.smooth {
        window.result.warnings.push("not smoothed: the smoother needs the packed covariance".into());
    }
    Ok(window.result.clone())
}

/// The kernel over `steps` steps.
#[inline(always)]
pub fn run_block<T: Real>(
    estimate: &mut Estimate<T>,
    tuning: &Tuning<T>,
    steps: usize,
    drive: &[f64],
    record: &mut [f64],
) {
    for (drive, record) in
        drive.chunks_exact(DRIVE * T::LANES).zip(record.chunks_exact_mut(RECORD * T::LANES)).take(steps)
    {
        let step = read_step::<T>(drive);
        let (_, trig) = estimate.predict(&step, tuning);
        let telling = estimate.update(&step, &trig, tuning);
        let mut variances = estimate.x;
        for g in 0..GROUPS {
            variances[g] = estimate.p.variances(g);
        }
        tell(&estimate.x, &variances, &step, &telling, record);
    }
}

/// Writes down what one step leaves behind.
#[inline(always)]
fn tell<T: Real>(
    x: &[Vec3<T>; GROUPS],
    variances: &[Vec3<T>; GROUPS],
    step: &Step<T>,
    telling: &Telling<T>,
    record: &mut [f64],
) {
    let mut field = 0;
    let mut poison = T::zero(); // stays zero unless something is not finite
    for g in 0..GROUPS {
        for i in 0..3 {
            let deviation = variances[g][i].sqrt();
            x[g][i].store(&mut record[field * T::LANES..]);
            deviation.store(&mut record[(DEVIATIONS + field) * T::LANES..]);
            poison = (x[g][i] + deviation).mul_add(T::zero(), poison);
            field += 1;
        }
    }
    field = 0;
    let absent = T::splat(f64::NAN);
    for m in 0..4 {
        for i in 0..3 {
            let present = step.present[m][i];
            let innovation = present.select_above(T::zero(), telling.innovation[m][i], absent);
            let deviation = present.select_above(T::zero(), telling.variance[m][i].sqrt(), absent);
            innovation.store(&mut record[(INNOVATIONS + field) * T::LANES..]);
            deviation.store(&mut record[(INNOVATION_DEVIATIONS + field) * T::LANES..]);
            field += 1;
        }
    }
    let steep = x[ATT][1].abs().select_above(T::splat(STEEPEST_PITCH_RAD), T::splat(-1.0), telling.pivot);
    telling.nis.store(&mut record[NIS * T::LANES..]);
    (steep + poison).store(&mut record[HEALTH * T::LANES..]);
    telling.iterations.store(&mut record[ITERATIONS * T::LANES..]);
}

#[inline(always)]
fn read_step<T: Real>(drive: &[f64]) -> Step<T> {
    let zero = [T::zero(); 3];
    let mut start = [zero; 2];
    let mut end = [zero; 2];
    let mut z = [zero; 4];
    let mut present = [zero; 4];
    for g in 0..2 {
        read_triple(&mut start[g], START + 3 * g, drive);
        read_triple(&mut end[g], END + 3 * g, drive);
    }
    for m in 0..4 {
        read_triple(&mut z[m], MEASURED + 3 * m, drive);
        read_triple(&mut present[m], PRESENT + 3 * m, drive);
    }
    let (dt, noise_scale) = (T::load(drive), T::load(&drive[NOISE_SCALE * T::LANES..]));
    Step { dt, noise_scale, inputs: Inputs { start, end }, z, present }
}

#[inline(always)]
fn read_triple<T: Real>(triple: &mut Vec3<T>, field: usize, drive: &[f64]) {
    for i in 0..3 {
        triple[i] = T::load(&drive[(field + i) * T::LANES..]);
    }
}

impl<'a> Window<'a> {
    fn new(data: &'a FilterData, settings: &ValidSettings) -> Result<Self, ReconstructError> {
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
            final_covariance: SMatrix::zeros(),
            smoothed: None,
            max_iterations_used: 0,
            warnings,
        };
        let schedule = Schedule::new(data, settings.hold);
        Ok(Self { schedule, result, events: Vec::with_capacity(BLOCK), error: None })
    }

    /// Puts the events of the next block into `lane`. A lane at its end keeps zeros: a step of no length and no
    /// measurement changes nothing.
    fn fill<T: Real>(&mut self, lane: usize, drive: &mut [f64]) {
        self.events.clear();
        if self.error.is_some() {
            return;
        }
        for drive in drive.chunks_exact_mut(DRIVE * T::LANES) {
            match self.schedule.next(&mut drive[lane..], T::LANES) {
                Some(event) => self.events.push(event),
                None => return,
            }
        }
    }

    /// Takes what the block told of `lane`.
    fn drain<T: Real>(&mut self, lane: usize, record: &[f64]) {
        let (result, events) = (&mut self.result, self.events.as_slice());
        let told = |step: usize, field: usize| record[(step * RECORD + field) * T::LANES + lane];
        let Some(last) = events.len().checked_sub(1) else { return };
        for step in 0..=last {
            if told(step, HEALTH) <= 0.0 || told(step, HEALTH).is_nan() || step == last {
                self.error = verdict(events[step].time_s, &|field| told(step, field));
                if self.error.is_some() {
                    return;
                }
            }
        }
        let all = 0..events.len();
        for k in 0..STATES {
            let samples = all.clone().filter(|&step| events[step].is_sample);
            result.states[k].extend(samples.clone().map(|step| told(step, k)));
            result.deviations[k].extend(samples.map(|step| told(step, DEVIATIONS + k)));
        }
        for m in 0..MEASUREMENTS {
            result.innovations[m].extend(all.clone().map(|step| told(step, INNOVATIONS + m)));
            result.innovation_deviations[m].extend(all.clone().map(|step| told(step, INNOVATION_DEVIATIONS + m)));
        }
        for (step, event) in events.iter().enumerate() {
            result.update_time_s.push(event.time_s);
            result.nis.push(if event.degrees > 0 { told(step, NIS) } else { f64::NAN });
            result.nis_degrees.push(event.degrees);
            result.max_iterations_used = result.max_iterations_used.max(told(step, ITERATIONS) as usize);
        }
    }

    /// The smoothed path ends where the filtered one does.
    fn begin_smoothing(&mut self) {
        let result = &mut self.result;
        result.smoothed = Some(Smoothed { states: result.states.clone(), deviations: result.deviations.clone() });
    }

    /// Takes what the smoother told of the starts of the steps of a block.
    fn drain_smoothed<T: Real>(&mut self, lane: usize, record: &[f64]) {
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

    fn finish<T: Real>(mut self, lane: usize, p: &Covariance<T>) -> Result<Reconstruction, ReconstructError> {
        if let Some(error) = self.error.take().or_else(|| self.smoothing_error()) {
            return Err(error);
        }
        let mut lanes = [0.0; MOST_LANES];
        for i in 0..STATES {
            for j in 0..STATES {
                p.block(i / 3, j / 3)[i % 3][j % 3].store(&mut lanes);
                self.result.final_covariance[(i, j)] = lanes[lane];
            }
        }
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

/// Initial states and covariance, one window per lane; a lane without a window gets those of the first.
fn initial_estimate<T: Real>(
    windows: &[Result<Window<'_>, ReconstructError>],
    settings: &ValidSettings,
) -> Estimate<T> {
    let mut x = [[T::zero(); 3]; GROUPS];
    let mut variances = x;
    for k in 0..STATES {
        let first = windows.iter().flatten().map(|window| window.result.states[k][0]).next().unwrap_or(0.0);
        let mut lanes = [first; MOST_LANES];
        for (lane, window) in lanes.iter_mut().zip(windows) {
            if let Ok(window) = window {
                *lane = window.result.states[k][0];
            }
        }
        x[k / 3][k % 3] = T::load(&lanes);
        variances[k / 3][k % 3] = T::splat(settings.initial_deviation[k].powi(2));
    }
    Estimate { x, p: Covariance::diagonal(&variances) }
}

/// Settings as variances, the same in every lane.
fn tuning<T: Real>(settings: &ValidSettings) -> Tuning<T> {
    let square = |values: &[f64], g: usize| {
        let mut squares = [T::zero(); 3];
        for i in 0..3 {
            squares[i] = T::splat(values[3 * g + i].powi(2));
        }
        squares
    };
    let (max_iterations, tolerance) = match settings.method {
        Method::Ekf => (1, 1.0),
        Method::Iekf { max_iterations, tolerance } => (max_iterations, tolerance),
    };
    Tuning {
        gravity: T::splat(settings.gravity_m_s2),
        process: [0, 1].map(|g| square(&settings.process_noise, g)),
        measurement: [0, 1, 2, 3].map(|m| square(&settings.measurement_noise, m)),
        random_walk: [0, 1, 2, 3, 4, 5].map(|g| square(&settings.random_walk, g)),
        tolerance_squared: T::splat(tolerance.powi(2)),
        max_iterations,
        at_predicted: settings.linearisation == Linearisation::Predicted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::FilterSettings;

    /// A second of level flight, repeated: what drives the filter in the long run.
    fn level_flight(settings: &ValidSettings) -> (Estimate<f64>, Tuning<f64>, Vec<f64>) {
        let mut estimate = Estimate { x: [[0.0; 3]; GROUPS], p: Covariance::diagonal(&[[0.0; 3]; GROUPS]) };
        estimate.x[1] = [80.0, 0.0, 6.0];
        estimate.x[ATT][1] = (6.0_f64 / 80.0).atan();
        for k in 0..STATES {
            estimate.p.blocks[super::super::covariance::at(k / 3, k / 3)][k % 3][k % 3] =
                settings.initial_deviation[k].powi(2);
        }
        let pitch = estimate.x[ATT][1];
        let mut drive = vec![0.0; 100 * DRIVE];
        for drive in drive.chunks_exact_mut(DRIVE) {
            (drive[0], drive[NOISE_SCALE]) = (0.01, 1.0);
            for at in [START, END] {
                drive[at] = settings.gravity_m_s2 * pitch.sin();
                drive[at + 2] = -settings.gravity_m_s2 * pitch.cos();
            }
            for (m, value) in [(3, 6.0_f64.hypot(80.0)), (7, pitch), (9, 6.0_f64.hypot(80.0)), (10, pitch)] {
                drive[MEASURED + m] = value;
            }
            // position is left to the ground velocity: it would move away from a repeated measurement
            drive[PRESENT + 3..PRESENT + 12].fill(1.0);
        }
        (estimate, tuning(settings), drive)
    }

    #[test]
    fn covariance_stays_symmetric_and_positive_over_a_million_steps() {
        let settings = FilterSettings::default().check().unwrap();
        let (mut estimate, tuning, drive) = level_flight(&settings);
        let mut record = vec![0.0; 100 * RECORD];
        for _ in 0..10_000 {
            run_block(&mut estimate, &tuning, 100, &drive, &mut record);
            assert!(record.iter().skip(HEALTH).step_by(RECORD).all(|health| *health > 0.0));
        }
        let p = estimate.p.dense();
        assert_eq!(p, p.transpose());
        let deviations = p.diagonal().map(f64::sqrt);
        let correlation = SMatrix::<f64, STATES, STATES>::from_fn(|i, j| p[(i, j)] / (deviations[i] * deviations[j]));
        assert!(correlation.symmetric_eigenvalues().min() > 0.0);
    }
}
