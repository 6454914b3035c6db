//! Findings by what they change: what a suspect manoeuvre, channel or place does to a derivative, and a finding about the flight path or
//! a channel by the worst it does.

use doublet_core::message;
use doublet_core::message::{Message, quoted, written};
use doublet_core::model::Coefficient;

use super::derivative::{SHARED, is_determined};
use super::effect::{CAUTION, LEAST_PART, OUTLYING_RATIO};
use super::judge::Evidence;
use super::{Finding, Level, Verdict, accelerometer, biased, propulsion, spoilt};
use crate::notation::significant;
use crate::session::{Edit, EstimationEdit, Fix, PathSource, Place};
use crate::snapshot::{Cause, Consequence, Effect};
use crate::stage::CoefficientFit;

/// Part of the samples of a fit in manoeuvres with an inconsistent flight path from which the path of all of them is suspect.
const INCONSISTENT_PART: f64 = 0.5;

/// Code of manoeuvres that the model does not describe.
const OUTLYING: &str = "outlying";
/// Change of an estimate without them in errors by the noise inside manoeuvres, from which they are named: the scatter between manoeuvres
/// holds what they do.
const SIGNIFICANT: f64 = 3.0;

/// Standard error without the spoilt samples over that with them, and over the estimate, from which these determine the derivative.
const LOST: (f64, f64) = (2.0, 0.5);

/// What suspect causes change of the parameter `index` of a pooled fit.
pub(super) fn findings(evidence: Evidence<'_>, fit: &CoefficientFit, index: usize) -> Vec<Finding> {
    let Some(judged) = Judged::new(evidence, fit, index) else { return Vec::new() };
    judged.effects().into_iter().filter_map(|(level, effect)| judged.finding(level, effect)).collect()
}

/// Whether the fit with a channel of a flight corrected was formed.
pub(super) fn is_known(evidence: Evidence<'_>, coefficient: Coefficient, flight: &str, channel: &str) -> bool {
    let all = evidence.consequences.iter().filter(|one| one.coefficient == coefficient);
    let mut effects = all.flat_map(|one| &one.derivatives).flat_map(|(_, consequence)| &consequence.effects);
    effects.any(|effect| effect.cause == Cause::Channel && effect.of[..] == [flight, channel])
}

/// The level of a finding of the session by what it changes: no worse than its effect on the derivatives, where that is
/// known, but a caution where it is bad by itself; and the part of a coefficient's motion that it moves.
pub(super) fn weighed(evidence: Evidence<'_>, finding: &Finding, fits: &[CoefficientFit]) -> (Level, f64) {
    let is_its_cause: Box<dyn Fn(&Effect) -> bool> = match finding.code {
        // A caution about the path counts by what the filter without the smoother gives; the path as measured holds the delays of its sensors.
        "nis" | "innovation" | "smoother" if finding.level == Level::Caution => {
            Box::new(|effect| matches!(effect.cause, Cause::PathFiltered | Cause::SuspectsLeftOut))
        }
        "nis" | "innovation" | "smoother" => {
            Box::new(|effect| matches!(effect.cause, Cause::PathMeasured | Cause::SuspectsLeftOut))
        }
        "saturated" | "stuck" if finding.level == Level::Caution || finding.place.pooled().is_some() => {
            Box::new(|effect| matches!(effect.cause, Cause::SpoiltLeftOut | Cause::SuspectsLeftOut))
        }
        "saturated" | "stuck" | "turn" | "dynamic-pressure" | "sampling" => {
            Box::new(|effect| effect.cause == Cause::SuspectsLeftOut)
        }
        "accelerometer" => Box::new(|effect| effect.cause == Cause::Accelerometer),
        "propulsion" if finding.level == Level::Caution => Box::new(|effect| effect.cause == Cause::Thrust),
        "physics" => Box::new(|effect| {
            let [flight, channel] = &effect.of[..] else { return false };
            effect.cause == Cause::Channel && finding.place == Place::in_flight(flight, channel)
        }),
        // A bias of az is in the constant of CZ alone; output error of one manoeuvre is a check of its own fit.
        "gravity" | "follows" => return (Level::Good, 0.0),
        _ => return (finding.level, own_part(finding, fits, evidence)),
    };
    let (mut worst, mut most) = (None, 0.0_f64);
    for fit in fits {
        let parameters = fit.fit.as_ref().map_or(0, |fit| fit.parameters());
        for judged in (0..parameters).filter_map(|index| Judged::new(evidence, fit, index)) {
            for (level, effect) in judged.all_effects().filter(|(_, effect)| is_its_cause(effect)) {
                worst = worst.max(Some(level));
                most = most.max(judged.consequence.motion_ratio * (effect.estimate - judged.estimate).abs());
            }
        }
    }
    // What is bad of a flight and changes nothing here may change what is asked of it next; so may a wrong place.
    let is_kept = finding.level == Level::Bad || finding.code == "accelerometer";
    let least = if is_kept { Level::Caution } else { Level::Good };
    (worst.map_or(finding.level, |worst| finding.level.min(worst.max(least))), most)
}

/// Part of its coefficient's motion that the derivative a finding is about makes; of a finding about something else all of it.
fn own_part(finding: &Finding, fits: &[CoefficientFit], evidence: Evidence<'_>) -> f64 {
    let Some(name) = finding.place.pooled() else { return 1.0 };
    let found = fits.iter().find_map(|fit| evidence.consequence(fit.coefficient, name));
    found.map_or(1.0, |consequence| consequence.share)
}

/// A derivative whose effects are judged.
struct Judged<'a> {
    evidence: Evidence<'a>,
    fit: &'a CoefficientFit,
    name: &'a str,
    estimate: f64,
    error: f64,
    consequence: &'a Consequence,
    /// Part of the samples in manoeuvres with an inconsistent flight path.
    inconsistent_part: f64,
    /// Whether the coefficient contains a thrust that is not known.
    thrust_unknown: bool,
    /// Manoeuvres of the fit with findings.
    suspects: Vec<&'a str>,
}

impl<'a> Judged<'a> {
    /// None of a derivative that the samples do not determine: that is its finding.
    fn new(evidence: Evidence<'a>, fit: &'a CoefficientFit, index: usize) -> Option<Self> {
        let estimate = fit.fit.as_ref().ok().filter(|_| is_determined(fit, index))?;
        let name = estimate.names.get(index)?;
        let consequence = evidence.consequence(fit.coefficient, name)?;
        let error = fit.corrected_errors.get(index).copied().filter(|_| estimate.origins[index].is_estimated())?;
        let verdict = |window: &str| evidence.judged_windows?.get(window).map(|judged| &judged.verdict);
        let all: usize = fit.windows.iter().map(|(_, samples)| samples).sum();
        let odd = fit.windows.iter().filter(|(window, _)| verdict(window).is_some_and(is_inconsistent));
        let odd: usize = odd.map(|(_, samples)| samples).sum();
        let suspects = fit.windows.iter().map(|(window, _)| window.as_str());
        Some(Self {
            evidence,
            fit,
            name,
            estimate: estimate.estimates[index],
            error,
            consequence,
            inconsistent_part: odd as f64 / all.max(1) as f64,
            thrust_unknown: propulsion::is_unknown(evidence, fit),
            suspects: suspects.filter(|window| verdict(window).is_some_and(is_suspect)).collect(),
        })
    }

    /// The effects of all causes, with their levels.
    fn all_effects(&self) -> impl Iterator<Item = (Level, &'a Effect)> {
        let level = |effect: &'a Effect| {
            let changed = self.consequence.level((self.estimate, self.error), effect);
            (if self.is_lost(effect) { changed.max(self.lost_level()) } else { changed }, effect)
        };
        self.consequence.effects.iter().map(level)
    }

    /// Whether the samples that are not spoilt leave the derivative undetermined.
    fn is_lost(&self, effect: &Effect) -> bool {
        let error = self.error * effect.error_ratio;
        effect.cause == Cause::SpoiltLeftOut
            && (effect.error_ratio > LOST.0 && error > LOST.1 * self.estimate.abs() || effect.error_ratio.is_nan())
    }

    /// Whether the coefficient is made of a saturated channel.
    fn is_of_saturated(&self) -> bool {
        !biased::saturated_of(self.evidence, self.fit).is_empty()
    }

    /// Bad where a saturated channel is what the coefficient is made of.
    fn lost_level(&self) -> Level {
        if self.is_of_saturated() { Level::Bad } else { Level::Caution }
    }

    /// Those of causes that something speaks for.
    fn effects(&self) -> Vec<(Level, &'a Effect)> {
        self.all_effects().filter(|(_, effect)| self.counts(effect.cause)).collect()
    }

    fn counts(&self, cause: Cause) -> bool {
        match cause {
            Cause::PathMeasured => self.inconsistent_part >= INCONSISTENT_PART,
            Cause::SuspectsLeftOut => !self.suspects.is_empty() && self.suspects.len() < self.fit.windows.len(),
            Cause::Channel | Cause::Accelerometer | Cause::SpoiltLeftOut | Cause::OutlyingLeftOut => true,
            Cause::Thrust => self.thrust_unknown,
            Cause::PathFiltered | Cause::LeftOut => false,
        }
    }

    fn finding(&self, level: Level, effect: &Effect) -> Option<Finding> {
        if level == Level::Good {
            return None;
        }
        let (code, cause, fix, panel, setting) = match effect.cause {
            Cause::PathMeasured => (
                "path",
                message!("with the path as measured"),
                "Check the noise and the delays of the measurements in turbulence.".to_owned(),
                "Noise and filter",
                "preparation.path".to_owned(),
            ),
            Cause::SuspectsLeftOut => (
                "windows",
                message!("without {}", quote_all(self.suspects.iter().copied())),
                "Fix the findings on these manoeuvres, or ignore them.".to_owned(),
                "Manoeuvres",
                "manoeuvre.role".to_owned(),
            ),
            Cause::OutlyingLeftOut => (
                OUTLYING,
                message!("without {}", quote_all(effect.of.iter().map(String::as_str))),
                "Check these manoeuvres, or ignore them.".to_owned(),
                "Manoeuvres",
                "manoeuvre.role".to_owned(),
            ),
            Cause::SpoiltLeftOut => (
                if self.is_of_saturated() { "saturated" } else { "stuck" },
                message!("without saturated and stalled samples"),
                "Exclude these samples, or fly again with smaller inputs or wider-range sensors.".to_owned(),
                "Manoeuvres",
                "manoeuvre.exclude".to_owned(),
            ),
            Cause::Channel => (
                "physics",
                message!("with {} corrected", effect.of.last()?),
                "Apply the fix of the channel.".to_owned(),
                "Channels",
                String::new(),
            ),
            Cause::Accelerometer => (
                "accelerometer",
                message!("with the accelerometers at their estimated position"),
                "State the position of the accelerometers.".to_owned(),
                "Airframe",
                "aircraft".to_owned(),
            ),
            Cause::Thrust => (
                "propulsion",
                message!("with a term of airspeed"),
                "Record the thrust, or add a term of airspeed.".to_owned(),
                "Propulsion",
                "preparation.remove_thrust".to_owned(),
            ),
            Cause::PathFiltered | Cause::LeftOut => return None,
        };
        let times = (effect.estimate - self.estimate).abs() / self.error;
        let estimate = message!("{:.4} ± {}", self.estimate, written(self.error, significant(self.error, 2)));
        let text = if self.is_lost(effect) {
            message!("{} is determined only by saturated or stalled samples.", estimate)
        } else {
            let changed = message!("{} becomes {:.4} {}", estimate, effect.estimate, cause);
            message!("{}: {:.1} standard errors (limit {}).", changed, times, CAUTION.0)
        };
        let place = Place::derivative(self.name, None);
        let finding = Finding::new(level, code, place, text).with_figure(times, CAUTION.0);
        let finding = finding.with_fix_text(fix).with_setting(panel, setting);
        let finding = finding.with_fix(self.fix(effect));
        Some(if effect.cause == Cause::PathMeasured { finding.with_value("\"measured\"") } else { finding })
    }

    /// The edits that remove the cause of an effect.
    fn fix(&self, effect: &Effect) -> Option<Fix> {
        let session = self.evidence.session;
        match effect.cause {
            Cause::PathMeasured => {
                let edit = Edit::Estimation(EstimationEdit::Path(PathSource::Measured));
                Some(Fix::new("use the path as measured", edit))
            }
            Cause::SuspectsLeftOut => Some(Fix::ignore(self.suspects.iter().copied())),
            Cause::OutlyingLeftOut => Some(Fix::ignore(effect.of.iter().map(String::as_str))),
            Cause::SpoiltLeftOut => {
                let windows = self.fit.windows.iter().filter_map(|(window, _)| session.window(window));
                let fixes: Vec<Fix> = windows.filter_map(|window| spoilt::fix(self.evidence, window)).collect();
                Fix::join(&fixes.iter().collect::<Vec<_>>())
            }
            Cause::Channel => {
                let [flight, channel] = &effect.of[..] else { return None };
                let physics = self.evidence.snapshot.physics.get(flight)?.ready()?;
                let row = physics.contradictions().find(|row| row.channel == *channel)?;
                physics.fix(session, flight, row)
            }
            Cause::Accelerometer => accelerometer::fix(session, self.evidence.snapshot, effect.of.first()?),
            Cause::Thrust => propulsion::airspeed_term(self.evidence, self.fit.coefficient),
            Cause::PathFiltered | Cause::LeftOut => None,
        }
    }
}

/// Names of manoeuvres in quotation marks.
fn quote_all<'a>(names: impl Iterator<Item = &'a str>) -> Message {
    Message::join(names.map(|name| message!("{}", quoted(name))), ", ")
}

/// That the model of a fit does not describe some of its manoeuvres, where leaving them out changes a derivative that the others
/// determine as well.
pub(super) fn judge_outlying(evidence: Evidence<'_>, fit: &CoefficientFit) -> Option<Finding> {
    let found = evidence.consequences.iter().find(|one| one.coefficient == fit.coefficient)?;
    let worst = found.outlying.first()?;
    let changes = |(name, consequence): &(String, Consequence)| {
        let estimate = fit.fit.as_ref().ok()?;
        let index = estimate.names.iter().position(|other| other == name)?;
        let (now, error) = (estimate.estimates[index], *fit.noise_errors.get(index)?);
        let effect = consequence.effects.iter().find(|effect| effect.cause == Cause::OutlyingLeftOut)?;
        let change = (effect.estimate - now).abs();
        let is_changed = change > (CAUTION.1 * now.abs()).max(SIGNIFICANT * error);
        Some(is_changed && consequence.motion_ratio * change > LEAST_PART && effect.error_ratio < SHARED)
    };
    if !found.derivatives.iter().filter_map(changes).any(|is_changed| is_changed) {
        return None;
    }
    let others = match found.outlying.len() - 1 {
        0 => Message::default(),
        others => message!(" and {} more", others),
    };
    let text = message!(
        "{}{}: residual {:.1} times that of most manoeuvres (limit {}).",
        quoted(&worst.name),
        others,
        worst.ratio,
        OUTLYING_RATIO
    );
    let place = Place::derivative(fit.coefficient.name(), None);
    let finding = Finding::new(Level::Caution, OUTLYING, place, text).with_figure(worst.ratio, OUTLYING_RATIO);
    let finding = finding.with_fix_text("Check configuration, contact with the ground and stall; or ignore them.");
    let fix = Fix::ignore(found.outlying.iter().map(|manoeuvre| manoeuvre.name.as_str()));
    Some(finding.with_setting("Manoeuvres", "manoeuvre.role").with_fix(Some(fix)))
}

/// Whether a manoeuvre is tried without: something of it is bad, or wrong besides its flight path.
pub(super) fn is_suspect(verdict: &Verdict) -> bool {
    verdict.reasons.iter().any(|reason| match reason.code {
        "follows" | "match" | "as-measured" => false,
        "nis" | "smoother" | "innovation" => reason.level == Level::Bad,
        _ => true,
    })
}

/// Whether the measurements of a manoeuvre do not fit one flight path; noise stated too large is no reason for that.
fn is_inconsistent(verdict: &Verdict) -> bool {
    let is_small = |reason: &Finding| reason.figure.is_some_and(|ratio| ratio < 1.0);
    verdict.reasons.iter().any(|reason| match reason.code {
        "nis" => !is_small(reason),
        "smoother" | "innovation" => reason.level == Level::Bad,
        _ => false,
    })
}
