//! Deflections recorded as a part of the full travel, percent or normalised to one, instead of an angle.

use super::controls::RESPONSES;
use super::line::Figures;
use super::motion::Motion;
use super::outcome::Outcome;
use super::traces::{Trace, most_telling};
use crate::quantity::Role::{self, *};

/// No surface in flight is deflected farther, rad: 45 deg.
const FARTHEST_RAD: f64 = 0.786;
/// Full travel as such numbers have it, with its rounding, in percent and as a part of one.
const HUNDRED: f64 = 100.5;
const ONE: f64 = 1.005;
/// What full travel is taken for to see whether the rest then fits, rad: 25 deg.
const FULL_TRAVEL_RAD: f64 = 0.436;
/// No surface of an aircraft turns it more sharply, angular acceleration per deflection, 1/s2.
const SHARPEST: f64 = 300.0;
/// No surface turns an aircraft less sharply: a gain below is that of degrees taken for radians, 1/s2.
const DULLEST: f64 = 0.4;
/// Part of a response the deflection must explain for its gain to count.
const EXPLAINED: f64 = 0.4;
/// Part of the samples, the farthest ones, that are left out as spikes.
const SPIKES: f64 = 1e-3;
/// Numbers that lie on one side about the middle of 0 to 100 percent, or 0 to 1.
const MIDDLE: std::ops::RangeInclusive<f64> = 0.4..=0.6;

/// A surface whose deflection is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travel {
    /// The channel.
    pub role: Role,
}

/// All three.
pub(super) const TRAVELS: &[Travel] = &[Travel { role: Aileron }, Travel { role: Elevator }, Travel { role: Rudder }];

/// In words what a deflection is compared with.
pub(super) const WITH: &str = "the deflections a surface can have, +-45 deg";

/// How the numbers of a deflection are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TravelForm {
    /// Percent of full travel, taken for degrees or for radians.
    Percent {
        /// What they were taken for: `degrees` or `radians`.
        taken: &'static str,
    },
    /// A part of one, taken for degrees or for radians.
    Normalised {
        /// The same.
        taken: &'static str,
    },
}

impl TravelForm {
    /// The mistake in words.
    pub(super) fn hypothesis(self) -> String {
        match self {
            Self::Percent { taken } => format!("percent of full travel, not {taken}"),
            Self::Normalised { taken } => format!("normalised to full travel, not {taken}"),
        }
    }

    /// Numbers at full travel.
    pub fn full(self) -> f64 {
        if matches!(self, Self::Percent { .. }) { 100.0 } else { 1.0 }
    }
}

impl Travel {
    /// Farthest deflection, rad, spikes left out, and the least and the middle one.
    fn reach(self, motion: &Motion) -> Option<(f64, f64, f64)> {
        let column = motion.column(self.role)?;
        let mut values: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
        if values.is_empty() {
            return None;
        }
        values.sort_by(f64::total_cmp);
        let middle = values[values.len() / 2];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a count")]
        let left_out = (SPIKES * values.len() as f64).floor() as usize;
        let least = values[left_out.min(values.len() - 1)];
        let greatest = values[values.len() - 1 - left_out.min(values.len() - 1)];
        Some((least.abs().max(greatest.abs()), least, middle))
    }

    /// How its numbers are written where they are a part of full travel; `None` where they are angles, or angles in another unit.
    fn form(self, motion: &Motion) -> Option<TravelForm> {
        let (reach, least, middle) = self.reach(motion)?;
        let degree = 1.0_f64.to_radians();
        let one_sided = |full: f64| least >= 0.0 && MIDDLE.contains(&(middle / full));
        let gain = || {
            let response = RESPONSES.iter().find(|response| response.cause == self.role);
            let sign = response.filter(|response| response.applies(motion)).and_then(|one| one.compare(motion));
            sign.filter(|sign| sign.share > EXPLAINED).map(|sign| sign.gain.abs())
        };
        let found = if reach <= ONE && (reach > FARTHEST_RAD || one_sided(1.0)) {
            TravelForm::Normalised { taken: "radians" }
        } else if reach > FARTHEST_RAD && reach <= HUNDRED * degree {
            TravelForm::Percent { taken: "degrees" }
        } else if reach > 45.0 && reach <= HUNDRED {
            return Some(TravelForm::Percent { taken: "radians" });
        } else {
            let is_sharp = reach <= ONE * degree && gain().is_some_and(|gain| gain > SHARPEST);
            return is_sharp.then_some(TravelForm::Normalised { taken: "degrees" });
        };
        gain().is_none_or(|gain| gain > DULLEST).then_some(found)
    }

    /// What the recording says.
    pub(super) fn judge(self, motion: &Motion) -> Outcome {
        if !motion.has(self.role) {
            return Outcome::Absent;
        }
        let Some((reach, ..)) = self.reach(motion) else { return Outcome::Undetermined };
        let segments = motion.segments.len();
        let figures = Figures { slope: reach, r2: 1.0, disagreement: 4.0, segments, predicted: true };
        if reach > FARTHEST_RAD || self.form(motion).is_some() {
            Outcome::Differs(figures)
        } else {
            Outcome::Fits(figures)
        }
    }

    /// The deflection, and the nearest one a surface can have.
    pub(super) fn trace(self, motion: &Motion) -> Option<Trace> {
        let column = motion.column(self.role)?;
        let segment = most_telling(motion, |segment| {
            column[segment.clone()].iter().copied().filter(|value| value.is_finite()).map(f64::abs).fold(0.0, f64::max)
        })?;
        let point = |k: usize| (motion.time_s[k], column[k], column[k].clamp(-FARTHEST_RAD, FARTHEST_RAD));
        Some(Trace::new(segment.map(point)))
    }
}

/// How the numbers of a role are written where they are a part of full travel, and the factor that makes angles of about the right size.
pub(super) fn travel_form(role: Role, motion: &Motion) -> Option<(TravelForm, f64)> {
    let travel = TRAVELS.iter().find(|travel| travel.role == role)?;
    let (form, (reach, ..)) = (travel.form(motion)?, travel.reach(motion)?);
    Some((form, FULL_TRAVEL_RAD / reach))
}
