//! The iterated smoother: Gauss-Newton on the whole path (Bell 1994).

use std::rc::Rc;

use crate::message;
use crate::message::written;
use crate::reconstruct::data::{Reconstruction, Smoothed};
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::model::augmented::AugmentedState;
use crate::reconstruct::settings::SMOOTHER_TOLERANCE;

/// One pass of filter and smoother.
pub struct Pass {
    /// What it gives.
    pub result: Reconstruction,
    /// Smoothed state of every event.
    pub path: Vec<AugmentedState>,
    /// What that path costs.
    pub cost: f64,
}

/// Filters and smooths again and again, at most `passes` times: `pass` is given its number and the path to linearise about, which
/// is the smoothed one of the pass before. What the filter says, innovations included, is that of the first; only the smoothed
/// path is the last one's. `None` without any pass.
pub(crate) fn iterate(
    passes: usize,
    mut pass: impl FnMut(usize, Option<Rc<[AugmentedState]>>) -> Result<Pass, ReconstructError>,
) -> Result<Option<Reconstruction>, ReconstructError> {
    let mut result: Option<Reconstruction> = None;
    let mut about: Option<Rc<[AugmentedState]>> = None;
    let mut costs = Vec::new();
    for k in 0..passes {
        let found = pass(k, about.take())?;
        costs.push(found.cost);
        about = Some(found.path.into());
        let Some(result) = &mut result else {
            result = Some(found.result);
            continue;
        };
        let movement = match (&result.smoothed, &found.result.smoothed) {
            (Some(before), Some(now)) => movement(before, now),
            _ => 0.0,
        };
        result.smoothed = found.result.smoothed;
        if movement < SMOOTHER_TOLERANCE {
            break;
        }
        if k + 1 == passes {
            result.warnings.push(message!(
                "the iterated smoother still moves by {} standard deviations after {} passes: allow more",
                written(movement, format!("{movement:.1e}")),
                passes
            ));
        }
    }
    if let Some(smoothed) = result.as_mut().and_then(|result| result.smoothed.as_mut()) {
        smoothed.costs = costs;
    }
    Ok(result)
}

/// Largest difference of two smoothed paths, in standard deviations of the second.
fn movement(before: &Smoothed, now: &Smoothed) -> f64 {
    let mut largest: f64 = 0.0;
    for ((before, now), deviations) in before.states.iter().zip(&now.states).zip(&now.deviations) {
        for ((before, now), deviation) in before.iter().zip(now).zip(deviations) {
            if deviation > 0.0 {
                largest = largest.max((now - before).abs() / deviation);
            }
        }
    }
    largest
}
