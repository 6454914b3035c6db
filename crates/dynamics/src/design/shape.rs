//! Shapes of inputs on one surface, as nodes of straight lines, within a peak and a rate.

use doublet_core::simulate::{Form, Hand, InputKind, InputSignal};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::signal::CONTROLS;
use crate::modes::Mode;

/// Base time of each surface's pulses, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseTimes {
    /// Frequency of the motion that each control is to excite, rad/s: aileron, elevator, rudder, throttle.
    pub frequencies_rad_s: [f64; CONTROLS],
}

impl BaseTimes {
    /// From the natural modes: the aileron rolls, the elevator excites the short period, the rudder the Dutch roll, the throttle
    /// the phugoid. Where a mode is missing the fastest of the others takes its place.
    pub fn from_modes(modes: &[Mode]) -> Self {
        let fastest = modes.iter().map(Mode::frequency_rad_s).fold(0.0, f64::max);
        let fastest = if fastest > 0.0 { fastest } else { 1.0 };
        let find = |name: &str| {
            let mode = modes.iter().find(|mode| mode.name.contains(name));
            mode.map(Mode::frequency_rad_s).filter(|frequency| *frequency > 0.0).unwrap_or(fastest)
        };
        Self { frequencies_rad_s: ["roll subsidence", "short period", "Dutch roll", "phugoid"].map(find) }
    }

    /// Base time of a shape on a surface: a doublet has most of its power at `2.3 / dt` rad/s, a 3-2-1-1 and the sums of sines about
    /// `1.6 / dt`.
    pub(crate) fn base_s(&self, surface: usize, kind: InputKind) -> f64 {
        let frequency = self.frequencies_rad_s.get(surface).copied().unwrap_or(1.0);
        if kind == InputKind::Doublet { 2.3 / frequency } else { 1.6 / frequency }
    }
}

/// Nodes of one surface: time (s) and deflection (rad).
pub(super) type Nodes = Vec<(f64, f64)>;

/// Pulses one after the other from `onset_s`, each a duration (s) and a level (rad), joined at no more than `rate_rad_s`. A pulse shorter
/// than its ramp does not reach its level.
pub(super) fn pulses(onset_s: f64, pulses: impl IntoIterator<Item = (f64, f64)>, rate_rad_s: f64) -> Nodes {
    let (mut time, mut value) = (onset_s, 0.0);
    let mut nodes = vec![(time, value)];
    for (duration_s, level) in pulses {
        let reach_s = (level - value).abs() / rate_rad_s;
        if reach_s < duration_s {
            nodes.push((time + reach_s, level));
            value = level;
        } else {
            value += (level - value).signum() * rate_rad_s * duration_s;
        }
        time += duration_s;
        nodes.push((time, value));
    }
    let back_s = nodes.last().map_or(0.0, |node| node.1.abs()) / rate_rad_s;
    if back_s > 0.0 {
        let end = nodes.last().map_or(onset_s, |node| node.0);
        nodes.push((end + back_s, 0.0));
    }
    nodes
}

/// A curve of unit peak as nodes every `step_s`, scaled to the amplitude, and further down where its slope would pass the rate.
pub(super) fn sampled(
    onset_s: f64,
    duration_s: f64,
    step_s: f64,
    amplitude_rad: f64,
    rate_rad_s: f64,
    curve: impl Fn(f64) -> f64,
) -> Nodes {
    let count = (duration_s / step_s).ceil().max(1.0) as usize;
    let step_s = duration_s / count as f64;
    let values: Vec<f64> = (0..=count).map(|index| curve(step_s * index as f64)).collect();
    let peak = values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let slope = values.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step_s).fold(0.0, f64::max);
    if peak == 0.0 {
        return vec![(onset_s, 0.0), (onset_s + duration_s, 0.0)];
    }
    let scale = (amplitude_rad.abs() / peak).min(rate_rad_s / slope) * amplitude_rad.signum();
    values.into_iter().enumerate().map(|(index, value)| (onset_s + step_s * index as f64, scale * value)).collect()
}

/// A shape of one surface of base time `base_s`, as the simulator's scenarios fly it.
pub(super) fn named(
    kind: InputKind,
    onset_s: f64,
    base_s: f64,
    (amplitude_rad, rate_rad_s): (f64, f64),
    step_s: f64,
) -> Nodes {
    match kind.form() {
        Form::Pulses(form) => {
            let scaled = form.iter().map(|&(duration, level)| (duration * base_s, level * amplitude_rad));
            pulses(onset_s, scaled, rate_rad_s)
        }
        Form::Sines(_) | Form::Sweep { .. } | Form::Multisine => {
            // The ideal shape asks nothing of the generator.
            let mut unused = ChaCha8Rng::seed_from_u64(0);
            let signal = InputSignal::new(kind, base_s, 1.0, Hand::PERFECT, &mut unused);
            sampled(onset_s, signal.duration_s(), step_s, amplitude_rad, rate_rad_s, |time_s| signal.at(time_s))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doublet_keeps_peak_and_rate_and_returns_to_zero() {
        let nodes = named(InputKind::Doublet, 2.0, 0.8, (0.05, 0.5), 0.02);
        // 0.1 s to the first level, 0.2 s to the other, 0.1 s back.
        let expected = [(2.0, 0.0), (2.1, 0.05), (2.8, 0.05), (3.0, -0.05), (3.6, -0.05), (3.7, 0.0)];
        assert_eq!(nodes.len(), expected.len());
        for (node, expected) in nodes.iter().zip(expected) {
            assert!((node.0 - expected.0).abs() < 1e-12 && (node.1 - expected.1).abs() < 1e-12, "{node:?}");
        }
    }

    #[test]
    fn pulse_shorter_than_its_ramp_does_not_reach_its_level() {
        let nodes = pulses(0.0, [(0.1, 0.2)], 1.0);
        assert_eq!(nodes, [(0.0, 0.0), (0.1, 0.1), (0.2, 0.0)]);
    }

    #[test]
    fn sines_and_sweeps_have_the_stated_peak_and_stay_below_the_rate() {
        for kind in [InputKind::Dut, InputKind::Mehra, InputKind::Schulz, InputKind::LogarithmicSweep] {
            for rate in [10.0, 0.1] {
                let nodes = named(kind, 1.0, 0.7, (0.04, rate), 0.02);
                let peak = nodes.iter().map(|node| node.1.abs()).fold(0.0, f64::max);
                let steepest =
                    nodes.windows(2).map(|n| (n[1].1 - n[0].1).abs() / (n[1].0 - n[0].0)).fold(0.0, f64::max);
                assert!(steepest <= rate * (1.0 + 1e-9), "{steepest}");
                assert!(peak <= 0.04 * (1.0 + 1e-12));
                if rate > 1.0 {
                    approx::assert_relative_eq!(peak, 0.04, max_relative = 1e-9);
                }
            }
        }
    }
}
