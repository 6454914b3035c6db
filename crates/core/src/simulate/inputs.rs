//! Control inputs of flight test: shapes, hand-flown imperfections.

use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::multisine::Multisine;

/// Shape of a control input, normalised to an amplitude of one and a base time of one `dt`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InputKind {
    /// One pulse of one `dt`.
    Pulse,
    /// Held from the start to the end of the record: a pulse of eight `dt`.
    Step,
    /// One `dt` to each side.
    Doublet,
    /// 3-2-1-1: alternating pulses of three, two, one and one `dt`.
    ThreeTwoOneOne,
    /// Sum of weighted sines of the Delft University of Technology.
    Dut,
    /// Sum of weighted sines after Mehra, energy up to the middle of the band.
    Mehra,
    /// Sum of weighted sines after Schulz, energy mostly in the lowest harmonics.
    Schulz,
    /// Orthogonal multisines on all three controls at once, see [`Multisine`].
    Multisine,
    /// Sine whose frequency rises by the same amount every second, from 0.05 to 2 over `dt`, in 60 `dt`.
    LinearSweep,
    /// Sine whose frequency rises by the same factor every second, over the same range and time.
    LogarithmicSweep,
    /// Given node by node, see [`super::DesignedInput`].
    Designed,
}

impl InputKind {
    /// Every shape that its kind alone says.
    pub const ALL: [Self; 10] = [
        Self::Pulse,
        Self::Step,
        Self::Doublet,
        Self::ThreeTwoOneOne,
        Self::Dut,
        Self::Mehra,
        Self::Schulz,
        Self::Multisine,
        Self::LinearSweep,
        Self::LogarithmicSweep,
    ];

    crate::variant_texts! {
        /// Name in scenario lists and files.
        pub name:
            Pulse "pulse", Step "step", Doublet "doublet", ThreeTwoOneOne "3-2-1-1", Dut "DUT", Mehra "Mehra",
            Schulz "Schulz", Multisine "multisine", LinearSweep "linear sweep", LogarithmicSweep "logarithmic sweep",
            Designed "designed",
    }

    /// The shape called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// How the shape is made. Doublet, pulse and 3-2-1-1 are those of thesis section 2.5.1. The thesis describes DUT, Mehra
    /// and Schulz as sums of weighted sines without their weights; the weights here are doublet's own, on the first
    /// harmonics of an interval of eight `dt`, alternating in sign so that the signal starts and ends gently.
    pub fn form(self) -> Form {
        match self {
            Self::Pulse => Form::Pulses(&[(1.0, 1.0)]),
            Self::Step => Form::Pulses(&[(8.0, 1.0)]),
            Self::Doublet => Form::Pulses(&[(1.0, 1.0), (1.0, -1.0)]),
            Self::ThreeTwoOneOne => Form::Pulses(&[(3.0, 1.0), (2.0, -1.0), (1.0, 1.0), (1.0, -1.0)]),
            Self::Dut => Form::Sines(&[0.4, -1.0, 0.8, -0.6, 0.4]),
            Self::Mehra => Form::Sines(&[0.6, -0.9, 1.0, -0.7, 0.5, -0.3]),
            Self::Schulz => Form::Sines(&[1.0, -0.8, 0.4]),
            Self::Multisine => Form::Multisine,
            Self::LinearSweep => Form::Sweep { is_logarithmic: false },
            Self::LogarithmicSweep => Form::Sweep { is_logarithmic: true },
            Self::Designed => Form::Pulses(&[]),
        }
    }

    /// Whether the frequency rises along the input.
    pub fn is_sweep(self) -> bool {
        matches!(self.form(), Form::Sweep { .. })
    }
}

/// How an input of unit amplitude is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Consecutive pulses: duration in `dt` and amplitude.
    Pulses(&'static [(f64, f64)]),
    /// Weights of the sines `sin(2 pi k t / T)`, k = 1, 2, .., over `T` = 8 `dt`, scaled to a peak of one.
    Sines(&'static [f64]),
    /// A multisine of its own for each control, over 24 `dt`.
    Multisine,
    /// A sine of rising frequency that fades in and out along half cosines.
    Sweep {
        /// By factors, not by differences.
        is_logarithmic: bool,
    },
}

/// Length of a multisine in base times, -.
const MULTISINE_LENGTH: f64 = 24.0;
/// Most harmonics of one control's multisine.
const MAX_HARMONICS: usize = 8;

/// Length of a sum of sines in base times, -.
const SINES_LENGTH: f64 = 8.0;

/// Length of a sweep in base times, -.
const SWEEP_LENGTH: f64 = 60.0;
/// First and last frequency of a sweep over the inverse of the base time, -.
const SWEEP_RANGE: [f64; 2] = [0.05, 2.0];
/// Base times in which a sweep fades in, and out, -.
const SWEEP_FADES: [f64; 2] = [2.0, 4.0];

/// How far from the ideal shape a hand flies it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Standard deviation of each pulse's duration relative to itself, -.
    pub time_spread: f64,
    /// Standard deviation of each pulse's amplitude relative to itself, -.
    pub amplitude_spread: f64,
    /// Time from one level to the next along a half cosine, s; zero for square corners.
    pub transition_s: f64,
}

impl Hand {
    /// The ideal shape.
    pub const PERFECT: Self = Self { time_spread: 0.0, amplitude_spread: 0.0, transition_s: 0.0 };
    /// A pilot's hand: 8 % in time, 10 % in amplitude, a quarter of a second from level to level.
    pub const PILOT: Self = Self { time_spread: 0.08, amplitude_spread: 0.10, transition_s: 0.25 };
}

/// Number of levels a signal can hold.
const MAX_LEVELS: usize = 8;

/// A control input as a deflection against time: levels joined by half cosines, a sum of sines, or straight lines.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSignal {
    curve: Curve,
    duration_s: f64,
    peak_rad: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Curve {
    /// Start of each level and its deflection, s and rad, the last one zero; time from level to level, s.
    Levels { levels: [(f64, f64); MAX_LEVELS], count: usize, transition_s: f64 },
    /// Weights and the amplitude that gives the wanted peak, rad.
    Sines { weights: &'static [f64], amplitude_rad: f64 },
    /// Harmonic numbers and phases, and the amplitude of each sine, rad.
    Harmonics { numbers: [f64; MAX_HARMONICS], phases_rad: [f64; MAX_HARMONICS], count: usize, amplitude_rad: f64 },
    /// Rising frequency over the duration, and its amplitude, rad.
    Sweep { is_logarithmic: bool, amplitude_rad: f64 },
    /// Straight lines between nodes, s and rad.
    Nodes(Arc<[(f64, f64)]>),
}

impl InputSignal {
    /// No input.
    pub const NONE: Self =
        Self { curve: Curve::Sines { weights: &[], amplitude_rad: 0.0 }, duration_s: 0.0, peak_rad: 0.0 };

    /// Multisines of base time `dt_s` and peak `amplitude_rad` for three controls at once; no hand can fly these.
    pub fn multisines(dt_s: f64, amplitude_rad: f64) -> [Self; 3] {
        const FIRST: u32 = 2;
        const LAST: u32 = FIRST + 3 * MAX_HARMONICS as u32 - 1;
        let period_s = MULTISINE_LENGTH * dt_s;
        let Ok(set) = Multisine::orthogonal_set(period_s, 1.0, FIRST, LAST, 3) else { return [Self::NONE; 3] };
        let mut signals = [Self::NONE; 3];
        for (signal, multisine) in signals.iter_mut().zip(&set) {
            let peak = (0..400).map(|i| multisine.at(period_s * f64::from(i) / 400.0).abs()).fold(0.0, f64::max);
            let count = multisine.harmonics.len().min(MAX_HARMONICS);
            let (mut numbers, mut phases_rad) = ([0.0; MAX_HARMONICS], [0.0; MAX_HARMONICS]);
            for index in 0..count {
                numbers[index] = f64::from(multisine.harmonics[index]);
                phases_rad[index] = multisine.phases_rad[index];
            }
            let amplitude_rad = amplitude_rad / peak / (count as f64).sqrt();
            let curve = Curve::Harmonics { numbers, phases_rad, count, amplitude_rad };
            *signal = Self { curve, duration_s: period_s, peak_rad: peak * amplitude_rad * (count as f64).sqrt() };
        }
        signals
    }

    /// Signal of a shape with base time `dt_s` and amplitude `amplitude_rad`, flown by `hand`. The same generator state
    /// gives the same signal. Of a multisine it is the first control's.
    pub fn new(kind: InputKind, dt_s: f64, amplitude_rad: f64, hand: Hand, rng: &mut ChaCha8Rng) -> Self {
        match kind.form() {
            Form::Multisine => {
                let [first, ..] = Self::multisines(dt_s, amplitude_rad);
                first
            }
            Form::Pulses(pulses) => Self::from_pulses(pulses, dt_s, amplitude_rad, hand, rng),
            Form::Sweep { is_logarithmic } => {
                let amplitude_rad = amplitude_rad * (1.0 + hand.amplitude_spread * limited_normal(rng));
                let duration_s = SWEEP_LENGTH * dt_s * (1.0 + hand.time_spread * limited_normal(rng));
                let curve = Curve::Sweep { is_logarithmic, amplitude_rad };
                Self { curve, duration_s, peak_rad: amplitude_rad.abs() }
            }
            Form::Sines(weights) => {
                let amplitude_rad = amplitude_rad * (1.0 + hand.amplitude_spread * limited_normal(rng));
                let duration_s = SINES_LENGTH * dt_s * (1.0 + hand.time_spread * limited_normal(rng));
                let peak = (0..=200).map(|i| sines(weights, f64::from(i) / 200.0).abs()).fold(0.0, f64::max);
                let curve = Curve::Sines { weights, amplitude_rad: amplitude_rad / peak };
                Self { curve, duration_s, peak_rad: amplitude_rad.abs() }
            }
        }
    }

    /// Straight lines between nodes (s after the onset, rad) in order of time; two nodes at one time are a step.
    pub(crate) fn from_nodes(nodes: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let nodes: Arc<[(f64, f64)]> = nodes.into_iter().collect();
        let peak_rad = nodes.iter().map(|node| node.1.abs()).fold(0.0, f64::max);
        let duration_s = nodes.last().map_or(0.0, |node| node.0);
        Self { curve: Curve::Nodes(nodes), duration_s, peak_rad }
    }

    /// Consecutive pulses, each with its own error of the hand.
    fn from_pulses(pulses: &[(f64, f64)], dt_s: f64, amplitude_rad: f64, hand: Hand, rng: &mut ChaCha8Rng) -> Self {
        let mut levels = [(0.0, 0.0); MAX_LEVELS];
        let (mut time, mut peak_rad) = (0.0, 0.0f64);
        for (level, &(duration, amplitude)) in levels.iter_mut().zip(pulses) {
            let deflection = amplitude * amplitude_rad * (1.0 + hand.amplitude_spread * limited_normal(rng));
            *level = (time, deflection);
            peak_rad = peak_rad.max(deflection.abs());
            time += duration * dt_s * (1.0 + hand.time_spread * limited_normal(rng));
        }
        levels[pulses.len()] = (time, 0.0);
        let curve = Curve::Levels { levels, count: pulses.len() + 1, transition_s: hand.transition_s };
        Self { curve, duration_s: time + hand.transition_s, peak_rad }
    }

    /// Length of a perfect sweep of base time `dt_s`, s.
    pub fn sweep_length_s(dt_s: f64) -> f64 {
        SWEEP_LENGTH * dt_s
    }

    /// Deflection at `time_s` after the onset, rad.
    pub fn at(&self, time_s: f64) -> f64 {
        match &self.curve {
            Curve::Levels { levels, count, transition_s } => at_levels(&levels[..*count], *transition_s, time_s),
            Curve::Sines { weights, amplitude_rad } if (0.0..=self.duration_s).contains(&time_s) => {
                amplitude_rad * sines(weights, time_s / self.duration_s)
            }
            Curve::Harmonics { numbers, phases_rad, count, amplitude_rad }
                if (0.0..=self.duration_s).contains(&time_s) =>
            {
                let angle = std::f64::consts::TAU * time_s / self.duration_s;
                let waves = numbers[..*count].iter().zip(phases_rad);
                amplitude_rad * waves.map(|(k, phase)| libm::sin(k * angle + phase)).sum::<f64>()
            }
            Curve::Sweep { is_logarithmic, amplitude_rad } if (0.0..=self.duration_s).contains(&time_s) => {
                amplitude_rad * sweep(*is_logarithmic, SWEEP_LENGTH * time_s / self.duration_s)
            }
            Curve::Nodes(nodes) => {
                let next = nodes.partition_point(|node| node.0 <= time_s);
                let (Some(&(start, from)), Some(&(end, to))) =
                    (next.checked_sub(1).and_then(|index| nodes.get(index)), nodes.get(next))
                else {
                    return 0.0;
                };
                from + (to - from) * (time_s - start) / (end - start)
            }
            Curve::Sines { .. } | Curve::Harmonics { .. } | Curve::Sweep { .. } => 0.0,
        }
    }

    /// Time of the return to zero, s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Largest deflection to either side, rad.
    pub fn peak_rad(&self) -> f64 {
        self.peak_rad
    }
}

/// Value of levels joined by half cosines.
fn at_levels(levels: &[(f64, f64)], transition_s: f64, time_s: f64) -> f64 {
    let current = levels.partition_point(|&(start, _)| start <= time_s);
    if current == 0 {
        return 0.0;
    }
    let (start, target) = levels[current - 1];
    let from = if current == 1 { 0.0 } else { levels[current - 2].1 };
    let elapsed = time_s - start;
    if elapsed >= transition_s {
        return target;
    }
    from + (target - from) * half_cosine(elapsed / transition_s)
}

/// Part of the way after `part` of the time, both 0 to 1, along a half cosine.
pub(super) fn half_cosine(part: f64) -> f64 {
    0.5 * (1.0 - libm::cos(std::f64::consts::PI * part))
}

/// `sum_k w_k sin(2 pi k x)`.
fn sines(weights: &[f64], x: f64) -> f64 {
    weights.iter().enumerate().map(|(k, w)| w * libm::sin(std::f64::consts::TAU * (k + 1) as f64 * x)).sum()
}

/// Sweep of unit amplitude at `x` base times.
fn sweep(is_logarithmic: bool, x: f64) -> f64 {
    let [low, high] = SWEEP_RANGE;
    let turns = if is_logarithmic {
        let rate = libm::log(high / low) / SWEEP_LENGTH;
        low * libm::expm1(rate * x) / rate
    } else {
        (low + 0.5 * (high - low) * x / SWEEP_LENGTH) * x
    };
    let [rise, fall] = SWEEP_FADES;
    let size = half_cosine((x / rise).min(1.0)) * half_cosine(((SWEEP_LENGTH - x) / fall).clamp(0.0, 1.0));
    size * libm::sin(std::f64::consts::TAU * turns)
}

/// Standard normal deviate kept within two sigma, so that no input is unrecognisable.
fn limited_normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample::<f64, _>(rand_distr::StandardNormal).clamp(-2.0, 2.0)
}

/// First-order lag of an actuator or a stretching cable, `dy/dt = (u - y) / tau`, advanced exactly for a held input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderLag {
    keep: f64,
    value: f64,
}

impl FirstOrderLag {
    /// Lag with time constant `tau_s` (zero passes the input through) advanced every `step_s`, starting at `value`.
    pub fn new(tau_s: f64, step_s: f64, value: f64) -> Self {
        let keep = if tau_s > 0.0 { libm::exp(-step_s / tau_s) } else { 0.0 };
        Self { keep, value }
    }

    /// Output one step later.
    pub fn step(&mut self, input: f64) -> f64 {
        self.value = input + (self.value - input) * self.keep;
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn ideal_3211_switches_after_three_five_six_and_seven_intervals() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let signal = InputSignal::new(InputKind::ThreeTwoOneOne, 0.5, 0.04, Hand::PERFECT, &mut rng);
        for (time, expected) in
            [(-0.1, 0.0), (0.1, 0.04), (1.4, 0.04), (1.6, -0.04), (2.6, 0.04), (3.1, -0.04), (3.6, 0.0)]
        {
            assert_eq!(signal.at(time), expected, "at {time} s");
        }
        assert_eq!(signal.duration_s(), 3.5);
    }

    #[test]
    fn pilots_hand_is_seeded_and_stays_recognisable() {
        let make = |seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            InputSignal::new(InputKind::Doublet, 1.0, 0.05, Hand::PILOT, &mut rng)
        };
        assert_eq!(make(7), make(7));
        assert_ne!(make(7), make(8));
        for seed in 0..50 {
            let signal = make(seed);
            // Two sigma of 10 % amplitude and 8 % time each way.
            assert!((0.04..=0.06).contains(&signal.peak_rad()));
            assert!(signal.at(0.6) > 0.0 && signal.at(1.6) < 0.0);
        }
    }

    #[test]
    fn sweeps_pass_through_the_frequencies_of_their_law() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let dt_s = 1.5;
        for (kind, law) in [
            (InputKind::LinearSweep, &(|part: f64| 0.05 + 1.95 * part) as &dyn Fn(f64) -> f64),
            (InputKind::LogarithmicSweep, &|part: f64| 0.05 * 40f64.powf(part)),
        ] {
            let signal = InputSignal::new(kind, dt_s, 0.03, Hand::PERFECT, &mut rng);
            assert_eq!((signal.duration_s(), signal.at(0.0)), (90.0, 0.0));
            // Time between two rising zeros is one turn of the frequency half way between them.
            let step = 1e-3;
            let is_rise = |k: &u32| {
                let time = step * f64::from(*k);
                signal.at(time) <= 0.0 && signal.at(time + step) > 0.0
            };
            let rises: Vec<f64> = (5000..84_000).filter(is_rise).map(|k| step * f64::from(k)).collect();
            assert!(rises.len() > 20, "{}", rises.len());
            for pair in rises.windows(2) {
                let frequency = law(0.5 * (pair[0] + pair[1]) / 90.0) / dt_s;
                let turns = frequency * (pair[1] - pair[0]);
                // Over a turn that is a large part of the sweep the law is not straight.
                assert!(
                    (turns - 1.0).abs() < 0.02 + 2.0 * (pair[1] - pair[0]).powi(2) / 8100.0,
                    "{}: {turns}",
                    kind.name()
                );
            }
        }
    }

    #[test]
    fn every_shape_is_found_by_name_and_returns_to_zero() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for kind in InputKind::ALL {
            assert_eq!(InputKind::from_name(kind.name()), Some(kind));
            let signal = InputSignal::new(kind, 1.0, 1.0, Hand::PERFECT, &mut rng);
            assert_eq!(signal.at(signal.duration_s() + 1e-6), 0.0);
            assert!((0.5..=1.0 + 1e-9).contains(&signal.peak_rad()), "{}: {}", kind.name(), signal.peak_rad());
        }
    }
}
