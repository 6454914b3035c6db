//! Excursions of a signal from its resting place.

use std::ops::Range;

/// A run of samples beyond the threshold on one side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Excursion {
    pub samples: Range<usize>,
    /// First and end sample of the stretch without gaps it lies in.
    pub stretch: (usize, usize),
    /// Mean of the samples beyond half the greatest, with its sign.
    pub amplitude: f64,
}

/// Runs of at least three samples beyond `threshold`, which end below 0.6 of it or on the other side.
pub(super) fn excursions(deviation: &[f64], stretch: Range<usize>, threshold: f64) -> Vec<Excursion> {
    /// Share of the threshold below which a run ends: noise on the edge does not cut it in two.
    const RELEASE: f64 = 0.6;
    /// Shorter runs are spikes.
    const LEAST: usize = 3;
    let mut found = Vec::new();
    let mut k = stretch.start;
    while k < stretch.end {
        if deviation[k].abs() < threshold {
            k += 1;
            continue;
        }
        let side = deviation[k].signum();
        let from = k;
        while k < stretch.end && side * deviation[k] >= RELEASE * threshold {
            k += 1;
        }
        if k - from >= LEAST {
            let amplitude = side * upper_half_mean(&deviation[from..k], side);
            found.push(Excursion { samples: from..k, stretch: (stretch.start, stretch.end), amplitude });
        }
        k = k.max(from + 1);
    }
    found
}

/// Mean of what exceeds half the greatest.
fn upper_half_mean(values: &[f64], side: f64) -> f64 {
    let greatest = values.iter().map(|value| side * value).fold(0.0, f64::max);
    let upper = values.iter().map(|value| side * value).filter(|&value| value >= 0.5 * greatest);
    let (sum, count) = upper.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Time at which an excursion passes half its amplitude, upwards at its start or downwards at its end.
pub(super) fn half_crossing(time: &[f64], deviation: &[f64], excursion: &Excursion, at_start: bool) -> f64 {
    let side = excursion.amplitude.signum();
    let half = 0.5 * excursion.amplitude.abs();
    let above = |k: &usize| side * deviation[*k] >= half;
    let mut samples = excursion.samples.clone();
    let inside = if at_start { samples.find(above) } else { samples.rev().find(above) };
    let Some(inside) = inside else { return time[excursion.samples.start] };
    let outside = if at_start { inside.checked_sub(1) } else { Some(inside + 1) };
    let in_stretch = |k: &usize| (excursion.stretch.0..excursion.stretch.1).contains(k);
    let Some(outside) = outside.filter(in_stretch) else { return time[inside] };
    let (high, low) = (side * deviation[inside], side * deviation[outside]);
    let fraction = if high > low { ((high - half) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
    time[inside] + fraction * (time[outside] - time[inside])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excursions_end_where_the_side_changes_and_cross_half_way() {
        let deviation = [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -0.2, 0.0, 0.9, 0.0];
        let time: Vec<f64> = (0..deviation.len()).map(|k| 0.1 * k as f64).collect();
        let found = excursions(&deviation, 0..deviation.len(), 0.4);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].samples.clone(), found[1].samples.clone()), (2..6, 6..9));
        assert_eq!(found[1].amplitude, -1.0);
        // Half of the mean of the upper half, (0.5 + 3)/4/2, between 0 at 0.1 s and 0.5 at 0.2 s.
        approx::assert_relative_eq!(half_crossing(&time, &deviation, &found[0], true), 0.1875, epsilon = 1e-12);
        approx::assert_relative_eq!(half_crossing(&time, &deviation, &found[1], false), 0.8625, epsilon = 1e-12);
    }
}
