//! Flow angles that are off by a constant: an angle of attack against attitude and path, a sideslip without side force.

use super::line::{Figures, Line};
use super::motion::Motion;
use super::outcome::Outcome;
use super::traces::{Trace, most_telling};
use crate::quantity::Role::{self, *};
use crate::statistics::median;

/// Least offset that is named, rad: 5 deg. Upwash, position error and a mounting stay below.
const LEAST_RAD: f64 = 0.0873;
/// Bank up to which the wings count as level, rad.
const LEVEL_RAD: f64 = 0.26;
/// Half the time over which the slope of altitude is taken, s.
const HALF_CLIMB_S: f64 = 1.5;
/// The comparison scatters less than this part of an offset that is one.
const SCATTER: f64 = 0.5;
/// A sideslip and the side force belong together from this squared correlation on.
const SIDE_FORCE_R2: f64 = 0.5;
/// From this one on a slope is known well enough to tell a scale from an offset.
const SCALE_R2: f64 = 0.8;
/// Pairs are taken this far apart, s.
const EVERY_S: f64 = 0.2;

/// A flow angle and what it should be but for a constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    /// The channel.
    pub role: Role,
    /// With what it is compared, in words.
    pub with: &'static str,
    needs: &'static [Role],
    one_of: &'static [Role],
}

/// Both flow angles.
pub(super) const OFFSETS: &[Offset] = &[
    // alpha = theta - asin(climb / V), wings level
    Offset {
        role: AngleOfAttack,
        with: "theta less the flight-path angle in the mean",
        needs: &[AngleOfAttack, PitchAngle, TrueAirspeed],
        one_of: &[VelocityDown, Altitude],
    },
    // beta = ay / (ay per beta): no side force without sideslip
    Offset { role: Sideslip, with: "the sideslip without side force", needs: &[Sideslip], one_of: &[SpecificForceY] },
];

impl Offset {
    /// Whether every channel it needs is there.
    fn applies(&self, motion: &Motion) -> bool {
        self.needs.iter().all(|role| motion.has(*role)) && self.one_of.iter().any(|role| motion.has(*role))
    }

    /// Whether the channel of `role` enters.
    pub(super) fn involves(&self, role: Role) -> bool {
        self.needs.contains(&role) || self.one_of.contains(&role)
    }

    /// The angle as recorded less what it should be, rad, with its scatter and the segments that tell; `None` where none does.
    fn offset(&self, motion: &Motion) -> Option<(f64, f64, usize)> {
        if !self.applies(motion) {
            return None;
        }
        let mut differences = Vec::new();
        let mut pairs = Vec::new();
        let mut segments = 0;
        for segment in &motion.segments {
            let found = self.pairs(motion, segment);
            segments += usize::from(!found.is_empty());
            differences.extend(found.iter().map(|(_, should, is)| is - should));
            pairs.extend(found.into_iter().map(|(_, should, is)| (should, is)));
        }
        let offset = median(&mut differences.clone())?;
        differences.iter_mut().for_each(|value| *value = (*value - offset).abs());
        let scatter = median(&mut differences)?;
        // An angle scaled by its upwash is off in the mean, too, but not where it is small.
        let line = Line::through(&pairs, false).filter(|line| line.r2 > SCALE_R2);
        let intercept = line.map_or(offset, |line| line.intercept());
        let kept = if intercept * offset > 0.0 { offset.abs().min(intercept.abs()).copysign(offset) } else { 0.0 };
        Some((if kept.abs() > LEAST_RAD { offset } else { kept }, scatter, segments))
    }

    /// `(step, what it should be, what it is)` of one segment.
    fn pairs(&self, motion: &Motion, segment: &std::ops::Range<usize>) -> Vec<(usize, f64, f64)> {
        let (half, every) = (steps_of(HALF_CLIMB_S, motion), steps_of(EVERY_S, motion));
        if segment.len() < 4 * half {
            return Vec::new();
        }
        let inner = (segment.start + half..segment.end - half).step_by(every);
        let pairs = match self.role {
            Sideslip => self.without_side_force(motion, inner.collect()),
            _ => inner.map(|k| (k, theta_less_path(motion, k, half), motion.at(self.role, k))).collect(),
        };
        let finite = |(_, should, is): &(usize, f64, f64)| should.is_finite() && is.is_finite();
        pairs.into_iter().filter(finite).collect()
    }

    /// Sideslip as the side force says, by the slope of the segment itself; nothing where they do not belong together.
    fn without_side_force(&self, motion: &Motion, steps: Vec<usize>) -> Vec<(usize, f64, f64)> {
        let pairs: Vec<_> = steps.iter().map(|k| (motion.at(Sideslip, *k), motion.at(SpecificForceY, *k))).collect();
        let pairs: Vec<_> = pairs.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let Some(line) = Line::through(&pairs, false) else { return Vec::new() };
        if line.r2 < SIDE_FORCE_R2 || line.slope >= 0.0 {
            return Vec::new();
        }
        steps.iter().map(|k| (*k, motion.at(SpecificForceY, *k) / line.slope, motion.at(Sideslip, *k))).collect()
    }

    /// What the recording says.
    pub(super) fn judge(&self, motion: &Motion) -> Outcome {
        if !self.applies(motion) {
            return Outcome::Absent;
        }
        let Some((slope, scatter, segments)) = self.offset(motion) else { return Outcome::Undetermined };
        let figures = Figures { slope, r2: 1.0, disagreement: 4.0, segments, predicted: true };
        match slope.abs() > LEAST_RAD {
            true if scatter < SCATTER * slope.abs() => Outcome::Differs(figures),
            true => Outcome::Undetermined,
            false => Outcome::Fits(figures),
        }
    }

    /// The angle and what it should be, over the longest segment that tells.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        let segment = most_telling(motion, |segment| self.pairs(motion, segment).len() as f64)?;
        let pairs = self.pairs(motion, &segment).into_iter();
        Some(Trace::of(pairs.map(|(k, should, is)| (motion.time_s[k], is, should))))
    }
}

/// The offset of a flow angle that contradicts the others, rad.
pub(super) fn offset_of(role: Role, motion: &Motion) -> Option<f64> {
    let relation = OFFSETS.iter().find(|offset| offset.role == role)?;
    match relation.judge(motion) {
        Outcome::Differs(figures) => Some(figures.slope),
        _ => None,
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds over steps of more than 0.01 s")]
fn steps_of(seconds: f64, motion: &Motion) -> usize {
    ((seconds / motion.step_s).round() as usize).max(1)
}

/// `theta - asin(climb / V)` with wings level, rad; not a number in a bank.
fn theta_less_path(motion: &Motion, k: usize, half: usize) -> f64 {
    if motion.at(BankAngle, k).abs() > LEVEL_RAD {
        return f64::NAN;
    }
    let climb = if motion.has(VelocityDown) {
        -motion.at(VelocityDown, k)
    } else {
        let change = motion.at(Altitude, k + half) - motion.at(Altitude, k - half);
        change / (2.0 * half as f64 * motion.step_s)
    };
    motion.at(PitchAngle, k) - (climb / motion.at(TrueAirspeed, k)).asin()
}
