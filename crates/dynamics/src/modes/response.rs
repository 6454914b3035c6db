//! Phasors of the modes of a linear model.

use nalgebra::Complex;

use super::Mode;

/// Amplitude and phase of each state of a mode relative to `reference`, whose phasor is one; the entries of the eigenvector as they are
/// where that state does not move.
pub fn phasors(mode: &Mode, reference: usize) -> Vec<Complex<f64>> {
    let unit = mode.shape.get(reference).copied().filter(|entry| entry.norm() > 0.0);
    mode.shape.iter().map(|entry| unit.map_or(*entry, |unit| entry / unit)).collect()
}
