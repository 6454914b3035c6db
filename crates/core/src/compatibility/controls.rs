//! Deflections against the angular acceleration that follows, and sideslip against the side force: signs.

use nalgebra::{DMatrix, DVector};

use super::motion::Motion;
use super::traces::{Trace, most_telling};
use crate::quantity::Role::{self, *};

/// Half the interval over which a rate is differentiated, s.
const HALF_INTERVAL_S: f64 = 0.1;
/// A surface has moved in a segment when its standard deviation is above this, rad.
const MOVED_RAD: f64 = 0.004;
/// Sideslip has, rad.
const SLIPPED_RAD: f64 = 0.006;
/// Part of the variance the rates leave that a deflection must explain to tell anything.
const TELLS: f64 = 0.2;
/// The same to contradict.
const CONTRADICTS: f64 = 0.4;
/// A state rests below this deviation, rad or rad/s.
const RESTS: f64 = 1e-5;
/// Delays of a deflection that are tried, s: one that is recorded late or early shows the reverse of its sign as it stands.
const DELAYS_S: [f64; 12] = [0.05, -0.05, 0.1, -0.1, 0.15, -0.15, 0.2, -0.2, 0.25, -0.25, 0.3, -0.3];
/// Part of the variance that it must explain with a delay beyond what it explains as recorded.
const OF_DELAY: f64 = 0.1;
/// A surface is that of another axis when it explains this part there, and this much more than on its own.
const OF_ANOTHER: (f64, f64) = (0.6, 0.25);

/// A response whose sign is certain, conventions of `docs/conventions.md`: negative for all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// The channel whose sign is tested.
    pub cause: Role,
    /// What follows from it.
    pub effect: Role,
    /// With what, in words.
    pub with: &'static str,
    /// What the effect depends on, too, where it is recorded.
    states: &'static [Role],
    /// Whether the effect is differentiated.
    is_rate: bool,
    /// Rates of the other axes.
    others: &'static [Role],
}

/// What an angular acceleration depends on beside the deflection.
const STATES: &[Role] = &[RollRate, PitchRate, YawRate, AngleOfAttack, Sideslip];

/// Every such response.
pub(super) const RESPONSES: &[Response] = &[
    Response {
        cause: Aileron,
        effect: RollRate,
        with: "the resulting roll acceleration",
        states: STATES,
        is_rate: true,
        others: &[PitchRate, YawRate],
    },
    Response {
        cause: Elevator,
        effect: PitchRate,
        with: "the resulting pitch acceleration",
        states: STATES,
        is_rate: true,
        others: &[RollRate, YawRate],
    },
    Response {
        cause: Rudder,
        effect: YawRate,
        with: "the resulting yaw acceleration",
        states: STATES,
        is_rate: true,
        others: &[RollRate, PitchRate],
    },
    Response {
        cause: Sideslip,
        effect: SpecificForceY,
        with: "the side force",
        states: &[Rudder],
        is_rate: false,
        others: &[],
    },
];

/// What the segments say of a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sign {
    /// Median effect of the cause, unit of the effect per unit of the cause.
    pub gain: f64,
    /// Median part of the variance that it explains, zero to one.
    pub share: f64,
    /// Segments that tell.
    pub segments: usize,
    /// Part of them whose sign is that of the conventions.
    pub agreeing: f64,
    /// Whether the cause acts on another axis and hardly on this one.
    pub is_of_another: bool,
}

impl Sign {
    /// Whether it is as the conventions want it; `None` where the segments do not tell.
    pub(super) fn agrees(&self) -> Option<bool> {
        if self.is_of_another {
            return Some(false);
        }
        let clear = self.share > CONTRADICTS && self.agreeing < 0.3;
        if self.gain < 0.0 { Some(true) } else { clear.then_some(false) }
    }
}

impl Response {
    /// Whether both channels are there.
    pub(super) fn applies(&self, motion: &Motion) -> bool {
        motion.has(self.cause) && motion.has(self.effect)
    }

    /// Whether the channel of `role` decides.
    pub(super) fn involves(&self, role: Role) -> bool {
        self.cause == role || self.effect == role
    }

    /// Signs over all segments in which the cause moves; `None` where no segment shows one. A deflection that seems reversed and explains
    /// clearly more with a delay, by the sign of the conventions, is late and not reversed.
    pub(super) fn compare(&self, motion: &Motion) -> Option<Sign> {
        let recorded = self.compare_at(motion, 0.0)?;
        if !self.is_rate || recorded.is_of_another || recorded.agrees() != Some(false) {
            return Some(recorded);
        }
        let delayed = DELAYS_S.iter().filter_map(|&delay_s| self.compare_at(motion, delay_s));
        let delayed = delayed.max_by(|one, other| one.share.total_cmp(&other.share));
        Some(delayed.filter(|one| one.gain < 0.0 && one.share > recorded.share + OF_DELAY).unwrap_or(recorded))
    }

    /// The same with the cause `delay_s` earlier than it was recorded.
    fn compare_at(&self, motion: &Motion, delay_s: f64) -> Option<Sign> {
        let own = |segment: &std::ops::Range<usize>| self.in_segment(motion, segment.clone(), delay_s);
        let found: Vec<(f64, f64, bool)> = motion.segments.iter().filter_map(own).collect();
        let median =
            |of: fn(&(f64, f64, bool)) -> f64| crate::statistics::median(&mut found.iter().map(of).collect::<Vec<_>>());
        let gain = median(|one| one.0)?;
        let count = |holds: &dyn Fn(&(f64, f64, bool)) -> bool| found.iter().filter(|one| holds(one)).count() as f64;
        let all = found.len() as f64;
        Some(Sign {
            gain,
            share: median(|one| one.1)?,
            segments: found.len(),
            agreeing: count(&|one| one.0 < 0.0) / all,
            is_of_another: count(&|one| one.2) > 0.5 * all,
        })
    }

    /// The effect, and what of it the cause has by the sign of the conventions, over the segment in which the cause moves most.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        let half = self.half(motion);
        let gain = -self.compare(motion)?.gain.abs();
        let segment = most_telling(motion, |segment| deviation(motion, self.cause, segment).unwrap_or(f64::NAN))?;
        if segment.len() < 4 * half {
            return None;
        }
        let steps = segment.start + half..segment.end - half;
        let point = |k: usize| {
            (motion.time_s[k], self.effect_at(motion, self.effect, k, half), gain * motion.at(self.cause, k))
        };
        Some(Trace::new(steps.map(point)).without_means())
    }

    /// Steps of half the interval over which a rate is differentiated.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a tenth of a second over steps")]
    fn half(&self, motion: &Motion) -> usize {
        ((HALF_INTERVAL_S / motion.step_s).round() as usize).max(1)
    }

    /// A rate differentiated, or the effect itself.
    fn effect_at(&self, motion: &Motion, of: Role, k: usize, half: usize) -> f64 {
        if self.is_rate {
            (motion.at(of, k + half) - motion.at(of, k - half)) / (2.0 * motion.step_s * half as f64)
        } else {
            motion.at(of, k)
        }
    }

    /// Gain, share and whether another surface is the one that acts, with the cause `delay_s` earlier than it was recorded.
    #[expect(clippy::cast_possible_truncation, reason = "some tenths of a second over steps")]
    fn in_segment(&self, motion: &Motion, segment: std::ops::Range<usize>, delay_s: f64) -> Option<(f64, f64, bool)> {
        let half = self.half(motion);
        let delay = (delay_s / motion.step_s).round() as isize;
        let margin = half + delay.unsigned_abs();
        if segment.len() < 18 * half + 2 * margin {
            return None;
        }
        let steps = segment.start + margin..segment.end - margin;
        let effect = |of: Role, k: usize| self.effect_at(motion, of, k, half);
        let least = if self.cause == Sideslip { SLIPPED_RAD } else { MOVED_RAD };
        if deviation(motion, self.cause, &steps)? < least {
            return None;
        }
        let on = |other: Role| {
            if deviation(motion, other, &steps)? < RESTS {
                return Some((0.0, 0.0));
            }
            let moving = |role: &&Role| deviation(motion, **role, &steps).is_some_and(|size| size > RESTS);
            let state: Vec<Role> = self.states.iter().filter(moving).copied().collect();
            let row = |k: usize| -> Vec<f64> {
                let states = state.iter().map(|role| motion.at(*role, k));
                states.chain([motion.at(self.cause, k.saturating_add_signed(delay)), 1.0, effect(other, k)]).collect()
            };
            let rows: Vec<Vec<f64>> = steps.clone().map(row).filter(|row| row.iter().all(|v| v.is_finite())).collect();
            if rows.len() < 20 * half { None } else { share(&rows) }
        };
        let (gain, own) = on(self.effect)?;
        let others = self.others.iter().filter(|rate| motion.has(**rate));
        let best = others.filter_map(|rate| on(*rate)).map(|(_, share)| share).fold(0.0, f64::max);
        let is_of_another = best > OF_ANOTHER.0 && best > own + OF_ANOTHER.1;
        // What acts more on another axis tells the sign of neither.
        ((own > TELLS && own >= best) || is_of_another).then_some((gain, own, is_of_another))
    }
}

fn deviation(motion: &Motion, role: Role, steps: &std::ops::Range<usize>) -> Option<f64> {
    let column = &motion.column(role)?[steps.clone()];
    let values: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    Some((values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// Coefficient of the last regressor but the constant, and the part of the variance the others leave that it explains. Rows are
/// states, cause, one, effect.
fn share(rows: &[Vec<f64>]) -> Option<(f64, f64)> {
    let width = rows[0].len() - 1;
    let effect = DVector::from_iterator(rows.len(), rows.iter().map(|row| row[width]));
    let all: Vec<usize> = (0..width).collect();
    let without: Vec<usize> = (0..width).filter(|column| *column != width - 2).collect();
    let ((solved, left), (_, before)) = (fit_columns(rows, &effect, &all)?, fit_columns(rows, &effect, &without)?);
    Some((solved[width - 2], 1.0 - left / before))
}

/// Coefficients of these columns against the effect, and the sum of squares they leave.
fn fit_columns(rows: &[Vec<f64>], effect: &DVector<f64>, columns: &[usize]) -> Option<(DVector<f64>, f64)> {
    let matrix = DMatrix::from_fn(rows.len(), columns.len(), |row, column| rows[row][columns[column]]);
    let normal = matrix.tr_mul(&matrix);
    let scale = DVector::from_fn(columns.len(), |k, _| 1.0 / normal[(k, k)].sqrt().max(f64::MIN_POSITIVE));
    let scaled = DMatrix::from_fn(columns.len(), columns.len(), |a, b| normal[(a, b)] * scale[a] * scale[b]);
    let right = matrix.tr_mul(effect).component_mul(&scale);
    let solved = scaled.cholesky()?.solve(&right).component_mul(&scale);
    let sum = (effect - &matrix * &solved).norm_squared();
    Some((solved, sum))
}
