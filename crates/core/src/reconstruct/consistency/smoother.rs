//! Consistency of filter and smoother: does the smoother move the path as far as the two covariances allow?

use crate::reconstruct::data::{Reconstruction, Smoothed};
use crate::reconstruct::model::layout::State;

/// Half width of the band of the difference, in its standard deviations.
const BAND: f64 = 3.0;
/// Part of the samples of a state that must lie inside the band.
const INSIDE: f64 = 0.99;
/// Part of the filtered deviation that a difference may have beyond the band: rounding, where the smoother has nothing to add.
const ROUNDING: f64 = 1e-3;

/// A state whose smoothed path lies further from the filtered one than it may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disagreement {
    /// State.
    pub state: State,
    /// Part of the samples inside the band.
    pub inside: f64,
    /// Largest difference in its standard deviations.
    pub largest: f64,
}

/// States for which `|x_f - x_s| <= 3 sqrt(P_f - P_s)` holds in less than 99 per cent of the samples: filter and smoother then
/// contradict each other, and the model or the process noise does not explain the data (McReynolds; Bierman, "Factorization Methods
/// for Discrete Sequential Estimation", the covariance of the difference being the difference of the covariances). Worst first; none
/// without a smoothed path.
///
/// Neighbouring samples say the same, so that a state may leave the band in a stretch by chance: one that does so by less than half
/// its width again is let through.
pub fn filter_smoother_disagreement(run: &Reconstruction) -> Vec<Disagreement> {
    let Some(smoothed) = &run.smoothed else { return Vec::new() };
    let mut found: Vec<Disagreement> =
        State::ALL.into_iter().map(|state| compare_state(run, smoothed, state)).collect();
    found.retain(|state| state.inside < INSIDE && state.largest > 1.5 * BAND);
    found.sort_by(|a, b| a.inside.total_cmp(&b.inside));
    found
}

fn compare_state(run: &Reconstruction, smoothed: &Smoothed, state: State) -> Disagreement {
    let k = state as usize;
    let paths = run.states[k].iter().zip(&smoothed.states[k]);
    let deviations = run.deviations[k].iter().zip(&smoothed.deviations[k]);
    let (mut inside, mut largest) = (0_usize, 0.0_f64);
    for ((filtered, smoothed), (before, after)) in paths.zip(deviations) {
        let square = (filtered - smoothed).powi(2);
        let allowed = (before * before - after * after).max(0.0) + (ROUNDING * before).powi(2);
        inside += usize::from(square <= BAND * BAND * allowed);
        if allowed > 0.0 {
            largest = largest.max(square / allowed);
        }
    }
    let inside = inside as f64 / run.time_s.len().max(1) as f64;
    Disagreement { state, inside, largest: largest.sqrt() }
}
