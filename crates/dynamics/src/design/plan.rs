//! Manoeuvres that fill a time budget.

use doublet_core::simulate::{InputKind, InputSignal};

use super::DesignError;
use super::multisine::orthogonal_multisines;
use super::shape::{BaseTimes, Nodes, named, pulses, sampled};
use super::signal::{CONTROLS, Input, THROTTLE};

/// Names of the controls, in their order.
pub const SURFACE_NAMES: [&str; CONTROLS] = ["aileron", "elevator", "rudder", "throttle"];

/// Steady flight ahead of an input, and the free response behind pulses, multisines and sweeps, s.
const RUN_IN_S: f64 = 2.0;
const FREE_S: f64 = 4.0;
/// The same behind pulses of the throttle, which the speed follows slowly, s.
const FREE_THROTTLE_S: f64 = 15.0;
const SETTLE_S: f64 = 1.0;
/// Longest multisine, flown hands off but for its input, s.
const LONGEST_S: f64 = 60.0;
/// Shortest sweep worth its name, s.
const SHORTEST_SWEEP_S: f64 = 10.0;
/// Band of a multisine: its lowest frequency over the lowest of the modes its surfaces excite, and its highest over the highest.
const BAND: [f64; 2] = [0.25, 3.0];

/// Free response behind pulses of a control, s.
fn free_s(control: usize) -> f64 {
    if control == THROTTLE { FREE_THROTTLE_S } else { FREE_S }
}

/// Kind of a designed input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DesignKind {
    /// One surface at a time, a step that is held for eight base times.
    Step,
    /// One surface at a time, a doublet.
    Doublet,
    /// A 3-2-1-1.
    ThreeTwoOneOne,
    /// Sum of weighted sines, DUT.
    Dut,
    /// Sum of weighted sines after Mehra.
    Mehra,
    /// Sum of weighted sines after Schulz.
    Schulz,
    /// Orthogonal multisines on all surfaces at once.
    Multisine,
    /// 3-2-1-1 whose times and levels are all free.
    Optimised,
    /// Sweep whose frequency rises by differences.
    LinearSweep,
    /// Sweep whose frequency rises by factors.
    LogarithmicSweep,
}

impl DesignKind {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Step,
        Self::Doublet,
        Self::ThreeTwoOneOne,
        Self::Dut,
        Self::Mehra,
        Self::Schulz,
        Self::Multisine,
        Self::Optimised,
        Self::LinearSweep,
        Self::LogarithmicSweep,
    ];

    /// Name.
    pub fn name(self) -> &'static str {
        self.input().map_or("optimised 3-2-1-1", InputKind::name)
    }

    /// The kind called `name`, spaces as hyphens where it is typed.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name || kind.name().replace(' ', "-") == name)
    }

    /// The shape of the simulator; none of its own for the optimised one.
    fn input(self) -> Option<InputKind> {
        Some(match self {
            Self::Step => InputKind::Step,
            Self::Doublet => InputKind::Doublet,
            Self::ThreeTwoOneOne => InputKind::ThreeTwoOneOne,
            Self::Dut => InputKind::Dut,
            Self::Mehra => InputKind::Mehra,
            Self::Schulz => InputKind::Schulz,
            Self::Multisine => InputKind::Multisine,
            Self::LinearSweep => InputKind::LinearSweep,
            Self::LogarithmicSweep => InputKind::LogarithmicSweep,
            Self::Optimised => return None,
        })
    }

    /// Whether its manoeuvres move all surfaces at once.
    pub(crate) fn is_simultaneous(self) -> bool {
        self == Self::Multisine
    }

    /// Free parameters of each surface.
    pub fn parameters(self) -> usize {
        match self {
            Self::LinearSweep | Self::LogarithmicSweep => 0,
            Self::Multisine => 2,
            Self::Optimised => 8,
            _ => 1,
        }
    }
}

/// A manoeuvre to fly: one window.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct PlannedManoeuvre {
    pub name: String,
    pub kind: DesignKind,
    /// Surfaces it moves.
    pub surfaces: Vec<usize>,
    /// Deflections about the trim from the start of the window on.
    pub input: Input,
    /// Length of the window, s.
    pub duration_s: f64,
}

/// How manoeuvres are made.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Kind.
    pub kind: DesignKind,
    /// Surfaces to move.
    pub surfaces: Vec<usize>,
    /// Time of all windows together, s.
    pub time_s: f64,
    /// Frequencies of the motion to excite.
    pub base: BaseTimes,
    /// Fastest input of each control, rad/s or N/s.
    pub rates: [f64; CONTROLS],
    /// Interval of the nodes of curved inputs, s.
    pub step_s: f64,
    /// [`DesignKind::parameters`] of each surface, one surface after the other: zero for the shape as published. Of pulses and sums of
    /// sines the logarithm of the base time over its own; of multisines the logarithm of the amplitude over the largest and the exponent of
    /// the power over frequency; of optimised pulses the logarithms of four times and four levels.
    pub parameters: Vec<f64>,
}

impl Recipe {
    /// Lowest and highest frequency of a multisine on its surfaces, Hz.
    pub fn band_hz(&self) -> [f64; 2] {
        let frequencies = self.surfaces.iter().map(|&surface| self.base.frequencies_rad_s[surface]);
        let lowest = frequencies.clone().fold(f64::INFINITY, f64::min);
        let highest = frequencies.fold(0.0, f64::max);
        [BAND[0] * lowest / std::f64::consts::TAU, BAND[1] * highest / std::f64::consts::TAU]
    }

    /// Free parameters of the surface at `place` of its list.
    fn own(&self, place: usize) -> &[f64] {
        let count = self.kind.parameters();
        self.parameters.get(place * count..(place + 1) * count).unwrap_or(&[])
    }

    /// Surfaces that move together: amplitudes of each group are found by themselves.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        if self.kind.is_simultaneous() {
            vec![self.surfaces.clone()]
        } else {
            self.surfaces.iter().map(|&surface| vec![surface]).collect()
        }
    }

    /// The manoeuvres, with the amplitudes of the surfaces.
    ///
    /// # Errors
    /// [`DesignError::TooShort`] and [`DesignError::NoSurface`].
    pub fn manoeuvres(&self, amplitudes: [f64; CONTROLS]) -> Result<Vec<PlannedManoeuvre>, DesignError> {
        match self.kind {
            _ if self.surfaces.is_empty() => Err(DesignError::NoSurface),
            DesignKind::Multisine => self.multisines(amplitudes),
            DesignKind::LinearSweep | DesignKind::LogarithmicSweep => self.sweeps(amplitudes),
            _ => self.one_by_one(amplitudes),
        }
    }

    fn too_short(&self, needed_s: f64) -> DesignError {
        let names: Vec<_> = self.surfaces.iter().filter_map(|&surface| SURFACE_NAMES.get(surface).copied()).collect();
        DesignError::TooShort { kind: self.kind.name(), surfaces: names.join(", "), needed_s, given_s: self.time_s }
    }

    /// Windows of one surface each, in turn, the sign turning with every round.
    fn one_by_one(&self, amplitudes: [f64; CONTROLS]) -> Result<Vec<PlannedManoeuvre>, DesignError> {
        let signal = |place: usize, sign: f64| self.pulse(place, sign * amplitudes[self.surfaces[place]]);
        let lengths: Vec<f64> = (0..self.surfaces.len())
            .map(|place| signal(place, 1.0).last().map_or(0.0, |node| node.0) + free_s(self.surfaces[place]))
            .collect();
        let round_s: f64 = lengths.iter().sum();
        if round_s > self.time_s {
            return Err(self.too_short(round_s));
        }
        let mut order = Vec::new();
        let mut left_s = self.time_s;
        'rounds: for round in 0.. {
            for (place, length_s) in lengths.iter().enumerate() {
                if *length_s > left_s {
                    break 'rounds;
                }
                left_s -= length_s;
                order.push((place, if round % 2 == 0 { 1.0 } else { -1.0 }));
            }
        }
        let spare_s = left_s / order.len() as f64;
        let window = |(place, sign)| self.move_one(self.surfaces[place], signal(place, sign), lengths[place] + spare_s);
        Ok(order.into_iter().map(window).collect())
    }

    fn move_one(&self, surface: usize, signal: Nodes, duration_s: f64) -> PlannedManoeuvre {
        PlannedManoeuvre {
            name: format!("{} {}", SURFACE_NAMES[surface], self.kind.name()),
            kind: self.kind,
            surfaces: vec![surface],
            input: Input::of_surfaces(&[(surface, signal)]),
            duration_s,
        }
    }

    /// Pulses or sums of sines of the surface at `place`.
    fn pulse(&self, place: usize, amplitude_rad: f64) -> Nodes {
        let surface = self.surfaces[place];
        let rate = self.rates[surface];
        let own = self.own(place);
        let Some(kind) = self.kind.input() else {
            /// Times of the pulses in base times, as a 3-2-1-1 has them.
            const TIMES: [f64; 4] = [3.0, 2.0, 1.0, 1.0];
            let base_s = self.base.base_s(surface, InputKind::ThreeTwoOneOne);
            let factor = |index: usize| own.get(index).copied().unwrap_or(0.0).exp();
            let largest = (4..8).map(factor).fold(0.0, f64::max);
            let form = (0..4).map(|index| {
                let level = factor(4 + index) / largest * if index % 2 == 0 { 1.0 } else { -1.0 };
                (TIMES[index] * base_s * factor(index), level * amplitude_rad)
            });
            return pulses(RUN_IN_S, form, rate);
        };
        let base_s = self.base.base_s(surface, kind) * own.first().copied().unwrap_or(0.0).exp();
        named(kind, RUN_IN_S, base_s, (amplitude_rad, rate), self.step_s)
    }

    /// Windows of multisines on all surfaces.
    fn multisines(&self, amplitudes: [f64; CONTROLS]) -> Result<Vec<PlannedManoeuvre>, DesignError> {
        let count = (self.time_s / LONGEST_S).ceil().max(1.0);
        let duration_s = self.time_s / count;
        let period_s = duration_s - RUN_IN_S - SETTLE_S;
        let [lowest_hz, highest_hz] = self.band_hz();
        let first = (lowest_hz * period_s).ceil().max(2.0);
        let last = (highest_hz * period_s).floor();
        // Four lines a surface at least.
        let lines = 4.0 * self.surfaces.len() as f64;
        if period_s <= 0.0 || last - first + 1.0 < lines {
            return Err(self.too_short((lines + 1.0) / (highest_hz - lowest_hz) + RUN_IN_S + SETTLE_S));
        }
        let tilts: Vec<f64> =
            (0..self.surfaces.len()).map(|place| self.own(place).get(1).copied().unwrap_or(0.0)).collect();
        let share = |place: usize| self.own(place).first().copied().unwrap_or(0.0).exp();
        let largest = (0..self.surfaces.len()).map(share).fold(0.0, f64::max);
        let set = orthogonal_multisines(period_s, first as usize, last as usize, &tilts);
        let signals: Vec<(usize, Nodes)> = set
            .iter()
            .enumerate()
            .map(|(place, signal)| {
                let surface = self.surfaces[place];
                let amplitude = amplitudes[surface] * share(place) / largest;
                let rate = self.rates[surface];
                (surface, sampled(RUN_IN_S, period_s, self.step_s, amplitude, rate, |time_s| signal.at(time_s)))
            })
            .collect();
        let names: Vec<_> = self.surfaces.iter().map(|&surface| SURFACE_NAMES[surface]).collect();
        let window = PlannedManoeuvre {
            name: format!("{} {}", names.join(" and "), self.kind.name()),
            kind: self.kind,
            surfaces: self.surfaces.clone(),
            input: Input::of_surfaces(&signals),
            duration_s,
        };
        Ok(vec![window; count as usize])
    }

    /// One sweep of each surface.
    fn sweeps(&self, amplitudes: [f64; CONTROLS]) -> Result<Vec<PlannedManoeuvre>, DesignError> {
        let duration_s = self.time_s / self.surfaces.len() as f64;
        let length_s = duration_s - RUN_IN_S - SETTLE_S;
        if length_s < SHORTEST_SWEEP_S {
            let needed_s = (SHORTEST_SWEEP_S + RUN_IN_S + SETTLE_S) * self.surfaces.len() as f64;
            return Err(self.too_short(needed_s));
        }
        let base_s = length_s / InputSignal::sweep_length_s(1.0);
        let kind = self.kind.input().unwrap_or(InputKind::LogarithmicSweep);
        let sweep = |&surface: &usize| {
            let range = (amplitudes[surface], self.rates[surface]);
            self.move_one(surface, named(kind, RUN_IN_S, base_s, range, self.step_s), duration_s)
        };
        Ok(self.surfaces.iter().map(sweep).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(kind: DesignKind, surfaces: Vec<usize>, time_s: f64) -> Recipe {
        let base = BaseTimes { frequencies_rad_s: [2.6, 2.5, 1.4, 0.25] };
        Recipe { kind, surfaces, time_s, base, rates: [1.0, 1.0, 1.0, 500.0], step_s: 0.02, parameters: Vec::new() }
    }

    #[test]
    fn every_kind_fills_the_time_within_peak_and_rate() {
        for kind in DesignKind::ALL {
            let manoeuvres = recipe(kind, vec![0, 1], 60.0).manoeuvres([0.05, 0.03, 0.0, 0.0]).unwrap();
            let all: f64 = manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s).sum();
            approx::assert_relative_eq!(all, 60.0, max_relative = 1e-12);
            for manoeuvre in &manoeuvres {
                let (peaks, rates) = (manoeuvre.input.peaks(), manoeuvre.input.rates());
                assert!(manoeuvre.input.end_s() <= manoeuvre.duration_s, "{}", kind.name());
                for (surface, limit) in [0.05, 0.03, 0.0, 0.0].into_iter().enumerate() {
                    assert!(peaks[surface] <= limit * (1.0 + 1e-9), "{}: {peaks:?}", kind.name());
                    assert!(rates[surface] <= 1.0 + 1e-6, "{}: {rates:?}", kind.name());
                }
                for &surface in &manoeuvre.surfaces {
                    // As large as its peak or, where it is fast, its rate allows.
                    let is_large = peaks[surface] > 0.9 * [0.05, 0.03][surface] || rates[surface] > 0.99;
                    assert!(is_large, "{}: {peaks:?} {rates:?}", kind.name());
                }
            }
            assert_eq!(DesignKind::from_name(kind.name()), Some(kind));
        }
    }

    #[test]
    fn throttle_is_a_control_with_newtons_and_the_period_of_the_phugoid() {
        let manoeuvres = recipe(DesignKind::Doublet, vec![THROTTLE], 60.0).manoeuvres([0.0, 0.0, 0.0, 400.0]).unwrap();
        let [manoeuvre] = manoeuvres.as_slice() else { panic!("{} manoeuvres", manoeuvres.len()) };
        assert_eq!((manoeuvre.name.as_str(), manoeuvre.input.peaks()), ("throttle doublet", [0.0, 0.0, 0.0, 400.0]));
        // Two pulses of 2.3 / 0.25 s and the ramp back of 0.8 s behind 2 s of steady flight.
        approx::assert_relative_eq!(manoeuvre.input.end_s(), 2.0 + 2.0 * 9.2 + 0.8, max_relative = 1e-9);
        let step = recipe(DesignKind::Step, vec![THROTTLE], 120.0).manoeuvres([0.0, 0.0, 0.0, 400.0]).unwrap();
        assert_eq!(step[0].input.at(20.0), [0.0, 0.0, 0.0, 400.0]);
    }

    #[test]
    fn too_little_time_says_how_much_is_needed() {
        let error = recipe(DesignKind::Doublet, vec![0, 1, 2], 10.0).manoeuvres([0.05; CONTROLS]).unwrap_err();
        let DesignError::TooShort { needed_s, .. } = error else { panic!("{error}") };
        assert!(recipe(DesignKind::Doublet, vec![0, 1, 2], needed_s + 1e-9).manoeuvres([0.05; CONTROLS]).is_ok());
        assert!(recipe(DesignKind::Doublet, Vec::new(), 60.0).manoeuvres([0.05; CONTROLS]).is_err());
    }
}
