//! One pass of a filter over windows side by side, block by block, and of its smoother back.

use std::ops::ControlFlow;

use crate::reconstruct::collect::{Windows, collect, collect_smoothed, fill};
use crate::reconstruct::events::Schedule;
use crate::reconstruct::filter::backend::{Backend, Lanes};
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{BLOCK, SmoothedOutputs, StepInputs, StepOutputs};

/// Called between blocks with the part done, 0 to 1; `Break` cancels.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Part of the time that filtering takes when the path is smoothed as well.
const FILTER_SHARE: f64 = 0.3;

/// Filters the windows from `filter`, and smooths them where asked; returns the filter at the end and the smoother at the start.
pub(crate) fn run_pass<'a, B: Backend>(
    windows: &mut Windows<'a>,
    mut filter: B,
    parameters: &FilterParameters<B::Number>,
    smooth: bool,
    watch: Watch<'_>,
) -> ControlFlow<(), (B, Option<B::Smoother>)> {
    let mut inputs = vec![StepInputs::uniform(Lanes::<B>::default()); BLOCK];
    let mut outputs = vec![StepOutputs::default(); BLOCK];
    let longest = windows.iter().flatten().map(|window| window.result.time_s.len()).max().unwrap_or(0);
    let mut checkpoints = Checkpoints::new(if smooth { longest / BLOCK + 2 } else { 0 }, windows.len());
    let share = if smooth { FILTER_SHARE } else { 1.0 };
    loop {
        if smooth {
            checkpoints.push(&filter, windows);
        }
        let steps = fill(windows, &mut inputs);
        if steps == 0 {
            break;
        }
        filter.filter(parameters, &inputs[..steps], &mut outputs);
        collect(windows, &outputs);
        let done = windows.iter().flatten().map(|window| window.part_done()).fold(1.0, f64::min);
        watch(done * share)?;
    }
    if !smooth {
        return ControlFlow::Continue((filter, None));
    }
    let smoother = smooth_back(windows, filter.smoother(), parameters, &checkpoints, watch)?;
    ControlFlow::Continue((filter, Some(smoother)))
}

/// Where the blocks began: enough to run them again.
struct Checkpoints<'a, B> {
    filters: Vec<B>,
    /// As many as there are windows for each of them.
    schedules: Vec<Option<Schedule<'a>>>,
}

impl<'a, B: Backend> Checkpoints<'a, B> {
    fn new(blocks: usize, windows: usize) -> Self {
        Self { filters: Vec::with_capacity(blocks), schedules: Vec::with_capacity(blocks * windows) }
    }

    fn push(&mut self, filter: &B, windows: &Windows<'a>) {
        self.filters.push(filter.clone());
        self.schedules.extend(windows.iter().map(|window| window.as_ref().ok().map(|window| window.schedule.clone())));
    }
}

/// Goes back through the blocks. Each is filtered again from its checkpoint, so that only one block at a time is held whole.
fn smooth_back<'a, B: Backend>(
    windows: &mut Windows<'a>,
    mut smoother: B::Smoother,
    parameters: &FilterParameters<B::Number>,
    checkpoints: &Checkpoints<'a, B>,
    watch: Watch<'_>,
) -> ControlFlow<(), B::Smoother> {
    let mut inputs = vec![StepInputs::uniform(Lanes::<B>::default()); BLOCK];
    let mut outputs = vec![SmoothedOutputs::default(); BLOCK];
    for window in windows.iter_mut().flatten() {
        window.begin_smoothing();
    }
    let blocks = checkpoints.filters.len();
    for (left, filter) in checkpoints.filters.iter().enumerate().rev() {
        let schedules = &checkpoints.schedules[left * windows.len()..];
        for (window, schedule) in windows.iter_mut().zip(schedules) {
            if let (Ok(window), Some(schedule)) = (window, schedule) {
                window.schedule = schedule.clone();
            }
        }
        let steps = fill(windows, &mut inputs);
        filter.smooth(&mut smoother, parameters, &inputs[..steps], &mut outputs);
        collect_smoothed(windows, parameters.noise_moments, &outputs);
        watch(1.0 - (1.0 - FILTER_SHARE) * left as f64 / blocks as f64)?;
    }
    ControlFlow::Continue(smoother)
}
