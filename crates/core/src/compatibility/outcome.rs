//! What every relation says of some motion.

use super::air::{AIR_RELATIONS, AirRelation};
use super::controls::{RESPONSES, Response};
use super::line::Figures;
use super::motion::Motion;
use super::offsets::{OFFSETS, Offset};
use super::relations::{ClockEffect, Kinematic, RELATIONS};
use super::sizes::{SIZES, Size};
use super::traces::{Curves, Trace};
use super::travels::{self, TRAVELS, Travel};
use crate::quantity::Role;

/// Slopes of channels that fit.
const FITTING_SLOPE: std::ops::RangeInclusive<f64> = 0.8..=1.25;
/// Least squared correlation of channels that fit.
const FITTING_R2: f64 = 0.8;
/// Least squared correlation of a hypothesis.
const HYPOTHESIS_R2: f64 = 0.9;
/// Most disagreement after a hypothesis, relative to that before.
const HYPOTHESIS_GAIN: f64 = 0.25;

/// A relation of any kind.
#[derive(Clone, Copy, Debug)]
pub(super) enum Relation {
    Kinematic(&'static Kinematic),
    Air(&'static AirRelation),
    /// By the sign of a response.
    Response(&'static Response),
    /// By the size a quantity can have.
    Size(&'static Size),
    /// By the mean of a flow angle.
    Offset(&'static Offset),
    /// By the deflection a surface can have.
    Travel(&'static Travel),
}

/// What a relation says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outcome {
    /// The recording lacks a channel.
    Absent,
    /// Nothing varies enough, or no segment tells.
    Undetermined,
    /// The channels fit.
    Fits(Figures),
    /// They do not.
    Differs(Figures),
}

/// All relations, in the order rows show them.
pub(super) fn relations() -> Vec<Relation> {
    let kinematic = RELATIONS.iter().map(Relation::Kinematic);
    let air = AIR_RELATIONS.iter().map(Relation::Air);
    let responses = RESPONSES.iter().map(Relation::Response);
    let others = OFFSETS.iter().map(Relation::Offset).chain(TRAVELS.iter().map(Relation::Travel));
    kinematic.chain(air).chain(responses).chain(SIZES.iter().map(Relation::Size)).chain(others).collect()
}

impl Relation {
    pub(super) fn compared(&self) -> Role {
        match self {
            Self::Kinematic(one) => one.compared,
            Self::Air(one) => one.compared,
            Self::Response(one) => one.cause,
            Self::Size(one) => one.role,
            Self::Offset(one) => one.role,
            Self::Travel(one) => one.role,
        }
    }

    /// With what it is compared, in words.
    pub(super) fn with(&self) -> &'static str {
        match self {
            Self::Kinematic(one) => one.with,
            Self::Air(one) => one.with,
            Self::Response(one) => one.with,
            Self::Size(one) => one.limits,
            Self::Offset(one) => one.with,
            Self::Travel(_) => travels::WITH,
        }
    }

    /// Whether the channel of `role` enters.
    pub(super) fn involves(&self, role: Role) -> bool {
        match self {
            Self::Kinematic(one) => one.involves(role),
            Self::Air(one) => one.involves(role),
            Self::Response(one) => one.involves(role),
            Self::Size(one) => one.role == role,
            Self::Offset(one) => one.involves(role),
            Self::Travel(one) => one.role == role,
        }
    }

    /// Whether there is no relation without the channel of `role`.
    pub(super) fn needs(&self, role: Role) -> bool {
        let needs: &[Role] = match self {
            Self::Kinematic(one) => one.needs,
            Self::Air(one) => one.needs,
            Self::Response(_) | Self::Size(_) | Self::Offset(_) | Self::Travel(_) => return self.involves(role),
        };
        needs.contains(&role)
    }

    /// Whether nothing but a wrong channel makes it differ.
    pub(super) fn is_exact(&self) -> bool {
        match self {
            Self::Kinematic(one) => one.exact,
            Self::Air(_) | Self::Response(_) | Self::Offset(_) | Self::Travel(_) => false,
            Self::Size(_) => true,
        }
    }

    /// Whether it judges the values of one channel alone or their mean: nothing is said of it where it holds.
    pub(super) fn is_of_values(&self) -> bool {
        matches!(self, Self::Size(_) | Self::Offset(_) | Self::Travel(_))
    }

    /// Whether it is a line through pairs: its slope and squared correlation say how well it holds.
    pub(super) fn is_of_lines(&self) -> bool {
        matches!(self, Self::Kinematic(_) | Self::Air(_))
    }

    /// What a wrong clock does to it.
    pub(super) fn clock(&self) -> ClockEffect {
        if let Self::Kinematic(one) = self { one.clock } else { ClockEffect::None }
    }

    /// What `motion` says.
    pub(super) fn judge(&self, motion: &Motion) -> Outcome {
        match self {
            Self::Kinematic(one) => judge_kinematic(one, motion),
            Self::Air(one) => judge_air(one, motion),
            Self::Response(one) => judge_response(one, motion),
            Self::Size(one) => one.judge(motion),
            Self::Offset(one) => one.judge(motion),
            Self::Travel(one) => one.judge(motion),
        }
    }

    /// The channel and what the others say it is, as curves.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        match self {
            Self::Kinematic(one) => one.trace(motion),
            Self::Air(one) => one.trace(motion),
            Self::Response(one) => one.trace(motion),
            Self::Size(one) => one.trace(motion),
            Self::Offset(one) => one.trace(motion),
            Self::Travel(one) => one.trace(motion),
        }
    }

    /// The curves before and after a fix.
    pub(super) fn curves(&self, before: &Motion, after: &Motion) -> Option<Curves> {
        Some(Curves { before: self.trace(before)?, after: self.trace(after)? })
    }

    /// Whether it differed before a hypothesis and holds well after it.
    pub(super) fn is_repaired(&self, before: &Outcome, after: &Outcome) -> bool {
        let (Outcome::Differs(before), Outcome::Fits(after)) = (before, after) else { return false };
        match self {
            Self::Response(_) | Self::Size(_) | Self::Offset(_) | Self::Travel(_) => true,
            Self::Kinematic(_) | Self::Air(_) => {
                after.r2 > HYPOTHESIS_R2 && after.disagreement <= HYPOTHESIS_GAIN * before.disagreement
            }
        }
    }
}

fn judge_kinematic(one: &Kinematic, motion: &Motion) -> Outcome {
    if !one.applies(motion) {
        return Outcome::Absent;
    }
    let Some(figures) = one.compare(motion) else { return Outcome::Undetermined };
    if FITTING_SLOPE.contains(&figures.slope) && figures.r2 > FITTING_R2 {
        Outcome::Fits(figures)
    } else {
        Outcome::Differs(figures)
    }
}

fn judge_air(one: &AirRelation, motion: &Motion) -> Outcome {
    if !one.applies(motion) {
        return Outcome::Absent;
    }
    let Some(figures) = one.compare(motion) else { return Outcome::Undetermined };
    let fits = figures.slope > 0.0 && figures.slope.ln().abs() <= one.tolerance.ln_1p();
    if fits { Outcome::Fits(figures) } else { Outcome::Differs(figures) }
}

fn judge_response(one: &Response, motion: &Motion) -> Outcome {
    if !one.applies(motion) {
        return Outcome::Absent;
    }
    let Some(sign) = one.compare(motion) else { return Outcome::Undetermined };
    let figures =
        Figures { slope: sign.gain, r2: sign.share, disagreement: 4.0, segments: sign.segments, predicted: true };
    match sign.agrees() {
        Some(true) => Outcome::Fits(figures),
        Some(false) => Outcome::Differs(figures),
        None => Outcome::Undetermined,
    }
}
