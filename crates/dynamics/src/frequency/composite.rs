//! How estimates by windows of several lengths become one.

/// What one window length says at one frequency.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindowQuality {
    /// Estimated (multiple) coherence.
    pub coherence: f64,
    /// Effective number of averages.
    pub averages: f64,
}

/// Coherence below which the error is bounded.
const LEAST: f64 = 1e-3;

/// Weights that sum to one, from the mean square relative error of each window's response, `w = error^-2`.
///
/// The random part is `(1 - g) / (2 n g)` (Bendat and Piersol) with the windows' averages `n` and the best coherence `g`. A window too short
/// for the frequency shows as lost coherence, which averaging does not mend: what its coherence falls short of the best by is added
/// whole, over its own. With few averages a coherence is high by chance, hence both are compared at one standard deviation to the
/// other's side, `z = artanh(gamma) - 1/(2 (n - 1))` with variance `1/(2 (n - 1))`. Estimates by windows of the same record are far from
/// independent, so that the weights are the square of those for independent ones: the better window prevails.
pub(super) fn composite_weights(windows: &[Option<WindowQuality>]) -> Vec<f64> {
    let best = windows.iter().flatten().map(|window| move_coherence(window, -1.0)).fold(LEAST, f64::max);
    let weights: Vec<f64> =
        windows.iter().map(|window| window.as_ref().map_or(0.0, |window| weigh(window, best))).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| if sum > 0.0 { weight / sum } else { 0.0 }).collect()
}

fn weigh(window: &WindowQuality, best: f64) -> f64 {
    let random = (1.0 - best) / (2.0 * window.averages * best);
    let coherence = move_coherence(window, 1.0);
    let lost = (best - coherence).max(0.0) / coherence;
    (random + lost).powi(-2)
}

/// The coherence so many standard deviations above the one estimated.
fn move_coherence(window: &WindowQuality, deviations: f64) -> f64 {
    let free = (window.averages - 1.0).max(1e-3);
    let z = window.coherence.clamp(0.0, 1.0 - 1e-12).sqrt().atanh() - 0.5 / free + deviations * (0.5 / free).sqrt();
    z.max(0.0).tanh().powi(2).clamp(LEAST, 1.0 - 1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_of_smaller_error_prevails() {
        let quality = |coherence, averages| Some(WindowQuality { coherence, averages });
        // As coherent: more averages count by their square.
        let weights = composite_weights(&[quality(0.9, 1000.0), quality(0.9, 2000.0), None]);
        assert!((weights[1] / weights[0] - 4.0).abs() < 0.02 && weights[2] == 0.0, "{weights:?}");
        // The short window has more averages, but loses the resonance.
        let weights = composite_weights(&[quality(0.95, 20.0), quality(0.6, 160.0)]);
        assert!(weights[0] > 0.99, "{weights:?}");
        // One average says nothing.
        let weights = composite_weights(&[quality(1.0, 1.0), quality(0.8, 20.0)]);
        assert!(weights[1] > 0.99, "{weights:?}");
        // Nor are three that happen to be coherent.
        let weights = composite_weights(&[quality(0.8, 3.0), quality(0.3, 70.0)]);
        assert!(weights[1] > 0.6, "{weights:?}");
    }
}
