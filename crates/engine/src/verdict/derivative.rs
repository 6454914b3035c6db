//! Findings about one derivative: whether it is determined, plausible and the same in every window.

use doublet_core::message;
use doublet_core::message::{Message, quoted, written};
use doublet_core::model::{Term, is_constant_name};

use super::judge::Evidence;
use super::plausible::{Outside, Range};
use super::{Finding, Level, made_of, remedies, weigh};
use crate::notation::{decimals_of_error, significant};
use crate::session::{Fix, Place, Surface, WindowRole};
use crate::snapshot::Cause;
use crate::stage::{CoefficientFit, significance};

/// Code of a derivative that the samples do not tell: it lowers the derivative alone, not its fit.
pub(super) const DETERMINED: &str = "determined";

/// Corrected relative error, per cent.
const RELATIVE_ERROR: f64 = 50.0;
/// Distance beyond the plausible range, corrected errors.
const PLAUSIBLE_CAUTION: f64 = 3.0;
const PLAUSIBLE_BAD: f64 = 5.0;
/// Distance beyond the plausible range in its own widths: what an aircraft that is less usual may have where the session states none; bad
/// where it is significant; a caution whatever its error, and bad where it is beyond that.
const WIDTHS_UNUSUAL: f64 = 0.3;
const WIDTHS_BAD: f64 = 1.0;
const WIDTHS_ABSURD: f64 = 5.0;
/// Scatter of the single windows: weighted sum of squares over its degrees of freedom, and the relative error of the pooled estimate
/// once raised by its root, per cent. Both must be exceeded: corrected errors know nothing of what is common to a window, so that
/// very sharp estimates always scatter by more than they say.
const SCATTER_CAUTION: (f64, f64) = (3.0, 25.0);
const SCATTER_BAD: (f64, f64) = (10.0, 50.0);
/// Standard error without a manoeuvre over that with it, by the regressors alone, below which the others determine the derivative too.
pub(super) const SHARED: f64 = 2.0;

/// What speaks against the parameter `index` of a fit; `window` is none for the pooled one.
pub(super) fn findings(
    evidence: Evidence<'_>,
    window: Option<&str>,
    fit: &CoefficientFit,
    index: usize,
) -> Vec<Finding> {
    let Ok(estimate) = &fit.fit else { return Vec::new() };
    let name = &estimate.names[index];
    let at = Place::derivative(name, window);
    let mut findings = Vec::new();
    if !is_constant_name(name) {
        let open = determined(&at, fit, index);
        let fix = || remedies::without_least_determined(evidence.session, fit, index);
        findings.extend(open.map(|finding| finding.with_fix(window.is_none().then(fix).flatten())));
        if window.is_none() {
            findings.extend(reversed_control(evidence, &at, fit, name));
            findings.extend(scatter(evidence, &at, fit, index));
            findings.extend(weigh::findings(evidence, fit, index));
            // Where no fit with the corrected channel was formed, its effect is not known for any derivative.
            let of_channels = made_of::contradicted(&at, evidence, fit);
            findings.extend(of_channels.map(|finding| Finding { level: Level::Caution, ..finding }));
        }
    }
    if let Some(implausible) = Implausible::judge(evidence, fit, index) {
        let is_reversed = window.is_none() && implausible.outside.wrong_sign;
        let fix = is_reversed.then(|| remedies::reverse_control(evidence, fit, name)).flatten();
        findings.push(implausible.finding(&at, name).with_fix(fix));
    }
    findings
}

/// Whether the samples determine the parameter `index` of a fit: its corrected error is within half of its value.
pub(super) fn is_determined(fit: &CoefficientFit, index: usize) -> bool {
    let Ok(estimate) = &fit.fit else { return false };
    let (relative, _) = significance(estimate, &fit.corrected_errors, index);
    relative.is_nan() || relative <= RELATIVE_ERROR
}

fn determined(at: &Place, fit: &CoefficientFit, index: usize) -> Option<Finding> {
    if is_determined(fit, index) {
        return None;
    }
    let (relative, _) = significance(fit.fit.as_ref().ok()?, &fit.corrected_errors, index);
    let text =
        message!("Poorly determined: standard error {:.0} % of the value (limit {:.0} %).", relative, RELATIVE_ERROR);
    let finding = Finding::new(Level::Caution, DETERMINED, at, text).with_figure(relative, RELATIVE_ERROR);
    let fix_text = "Remove or fix the term, or fly a manoeuvre that excites it.";
    Some(finding.with_fix_text(fix_text).with_setting("Model", "estimation.constraint"))
}

/// A derivative outside its plausible range.
struct Implausible {
    value: f64,
    error: Option<f64>,
    range: Range,
    outside: Outside,
    level: Level,
}

impl Implausible {
    /// None of a value inside its range, or no farther outside than its error and an unusual aircraft explain.
    fn judge(evidence: Evidence<'_>, fit: &CoefficientFit, index: usize) -> Option<Self> {
        let estimate = fit.fit.as_ref().ok()?;
        let value = estimate.estimates[index];
        let range = evidence.plausible.range(&estimate.names[index], fit, evidence)?;
        let error = fit.corrected_errors.get(index).copied().filter(|_| estimate.origins[index].is_estimated());
        let outside = range.outside(value)?;
        let Outside { beyond, widths, wrong_sign } = outside;
        let t = error.map_or(f64::INFINITY, |error| beyond / error);
        let is_unusual = range.is_stated || widths > WIDTHS_UNUSUAL || wrong_sign;
        let is_far = widths > WIDTHS_BAD || wrong_sign;
        let is_absurd = widths > WIDTHS_ABSURD;
        let level = if t > PLAUSIBLE_BAD && is_far || t > PLAUSIBLE_CAUTION && is_absurd {
            Level::Bad
        } else if is_absurd || t > PLAUSIBLE_CAUTION && is_unusual {
            Level::Caution
        } else {
            return None;
        };
        Some(Self { value, error, range, outside, level })
    }

    fn finding(&self, at: &Place, name: &str) -> Finding {
        let Self { value, range, .. } = self;
        let problem = match self.outside.wrong_sign {
            true => "has the wrong sign: plausible range",
            false => "is outside its plausible range",
        };
        let error = self.error.map_or(Message::default(), |error| message!(" ± {:.2}", error));
        let estimate = message!("{:.4}{} {}", *value, error, problem);
        let text = message!("{} {:.3} to {:.3} ({}).", estimate, range.low, range.high, range.source);
        let limit = if *value > range.high { range.high } else { range.low };
        let finding = Finding::new(self.level, "plausible", at, text).with_figure(*value, limit);
        let fix_text = "Check signs, units, mass and inertia, or state a plausible range.";
        finding.with_fix_text(fix_text).with_setting("Derivatives", format!("verdict.plausible.{name}"))
    }
}

/// A derivative by a control whose own moment has the wrong sign: with the wrong sign or delay of that channel it is as wrong.
fn reversed_control(evidence: Evidence<'_>, at: &Place, fit: &CoefficientFit, name: &str) -> Option<Finding> {
    let by_name = |term: &&Term| term.derivative_name(fit.coefficient) == name;
    let term = evidence.session.structure.terms(fit.coefficient)?.iter().find(by_name)?;
    let surface = Surface::ALL.into_iter().find(|surface| term.factors() == [(surface.variable(), 1)])?;
    let moment = surface.moment();
    let own = evidence.snapshot.pooled.ready()?.fits.iter().find(|own| own.coefficient == moment)?;
    let own_name = term.derivative_name(moment);
    if moment == fit.coefficient {
        return None;
    }
    let estimate = own.fit.as_ref().ok()?;
    let index = estimate.names.iter().position(|name| *name == own_name)?;
    let found = Implausible::judge(evidence, own, index)?;
    if found.level != Level::Bad || !found.outside.wrong_sign {
        return None;
    }
    let text = message!("{} has the wrong sign, and this is a derivative of the same control.", &own_name);
    let finding = Finding::new(Level::Bad, "plausible", at, text);
    let fix = remedies::reverse_control(evidence, own, &own_name);
    let finding = finding.with_fix_text("Check the sign and the delay of this control.");
    Some(finding.with_setting("Derivatives", format!("verdict.plausible.{own_name}")).with_fix(fix))
}

/// An estimate of one window.
struct Single<'a> {
    window: &'a str,
    estimate: f64,
    error: f64,
}

/// Whether the estimates of single windows contradict each other: `Q = sum (x_i - x)^2 / s_i^2` about their weighted mean, over n - 1.
fn scatter(evidence: Evidence<'_>, at: &Place, fit: &CoefficientFit, index: usize) -> Option<Finding> {
    let estimate = fit.fit.as_ref().ok()?;
    let name = &estimate.names[index];
    // The corrected errors hold the scatter between windows already.
    let (relative, _) = significance(estimate, &fit.noise_errors, index);
    let singles: Vec<Single<'_>> =
        fit.windows.iter().filter_map(|(window, _)| single(evidence, window, fit, name)).collect();
    if singles.len() < 2 || relative.is_nan() {
        return None;
    }
    let weight: f64 = singles.iter().map(|single| single.error.powi(-2)).sum();
    let mean = singles.iter().map(|single| single.estimate * single.error.powi(-2)).sum::<f64>() / weight;
    let square = |single: &Single<'_>| ((single.estimate - mean) / single.error).powi(2);
    let q = singles.iter().map(square).sum::<f64>() / (singles.len() - 1) as f64;
    let raised = relative * q.sqrt();
    let (level, (limit, _)) = if q > SCATTER_BAD.0 && raised > SCATTER_BAD.1 {
        (Level::Bad, SCATTER_BAD)
    } else if q > SCATTER_CAUTION.0 && raised > SCATTER_CAUTION.1 {
        (Level::Caution, SCATTER_CAUTION)
    } else {
        return None;
    };
    let level = level.min(left_out(evidence, fit, index).unwrap_or(level));
    // The window furthest from the pooled estimate by its own error: what it says is what the pooled estimate hides.
    let pooled = estimate.estimates[index];
    let apart = |single: &Single<'_>| ((single.estimate - pooled) / single.error).abs();
    let worst = singles.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    let error = fit.corrected_errors.get(index).copied().unwrap_or(f64::NAN);
    // A poorly determined estimate is marked as such: a manoeuvre that is less certain than all together says nothing against it.
    let level = if is_determined(fit, index) || worst.error < error { level } else { Level::Good };
    let text = message!(
        "Manoeuvres disagree: {} gives {}, all together {}; scatter {:.1} times the standard errors (limit {:.0}).",
        quoted(worst.window),
        with_error(worst.estimate, worst.error),
        with_error(pooled, error),
        q,
        limit
    );
    let finding = Finding::new(level, "scatter", at, text).with_figure(q, limit);
    // The manoeuvre that determines the term best is not the one to leave out.
    let is_sharpest = singles.iter().all(|single| worst.error <= single.error);
    let fix_text = match is_sharpest {
        true => format!("Compare with '{}': use only manoeuvres that excite this term.", worst.window),
        false => format!("Check '{}', and use only manoeuvres that excite this term.", worst.window),
    };
    let fix = (singles.len() > 2 && !is_sharpest).then(|| Fix::ignore([worst.window]));
    Some(
        finding
            .with_fix_text(fix_text)
            .with_setting("Derivatives", format!("window.{}.role", worst.window))
            .with_fix(fix),
    )
}

/// An estimate and its error, to two digits of the error.
pub(super) fn with_error(estimate: f64, error: f64) -> Message {
    if !(error > 0.0 && error.is_finite()) {
        return message!("{}", written(estimate, significant(estimate, 4)));
    }
    let decimals = decimals_of_error(error).min(8);
    let shown = |value: f64| written(value, format!("{value:.decimals$}"));
    message!("{} ± {}", shown(estimate), shown(error))
}

/// The worst that leaving out one manoeuvre changes of a derivative; none where that was not formed, or where one is left out that alone
/// determines it.
fn left_out(evidence: Evidence<'_>, fit: &CoefficientFit, index: usize) -> Option<Level> {
    let estimate = fit.fit.as_ref().ok()?;
    let consequence = evidence.consequence(fit.coefficient, &estimate.names[index])?;
    let now = (estimate.estimates[index], *fit.corrected_errors.get(index)?);
    let effects = consequence.effects.iter().filter(|effect| effect.cause == Cause::LeftOut);
    let is_shared = effects.clone().all(|effect| effect.error_ratio < SHARED);
    effects.map(|effect| consequence.level(now, effect)).max().filter(|_| is_shared)
}

/// The estimate of `name` by an identification window alone.
fn single<'a>(evidence: Evidence<'a>, window: &'a str, fit: &CoefficientFit, name: &str) -> Option<Single<'a>> {
    evidence.session.window(window).filter(|window| window.role == WindowRole::Identification)?;
    let fits = evidence.snapshot.windows.get(window)?.fits.ready()?;
    let own = fits.fits.iter().find(|own| own.coefficient == fit.coefficient)?;
    let estimate = own.fit.as_ref().ok()?;
    let index = estimate.names.iter().position(|other| other == name)?;
    let error = *own.corrected_errors.get(index).filter(|error| **error > 0.0)?;
    Some(Single { window, estimate: estimate.estimates[index], error })
}
