//! The verdict on a finished run: every window, fit and derivative, and the session as a whole.

use std::collections::BTreeMap;

use doublet_core::message;
use doublet_core::model::{Coefficient, is_constant_name};
use rayon::prelude::*;

use super::delay::ControlDelay;
use super::effect::{self, Consequences};
use super::late_force::LateForce;
use super::noise::MeasurementNoise;
use super::plausible::Plausible;
use super::{
    Finding, Level, Verdict, biased, delay, density, derivative, fit, flight, gust_bias, late_force, made_of, remedies,
    session, studies, vane, weigh, window,
};
use crate::session::{Manoeuvre, Place, Session};
use crate::snapshot::{Consequence, DerivativeVerdict, FitVerdict, Snapshot, Verdicts, WindowVerdict};
use crate::stage::CoefficientFit;

/// Part of the motion of a coefficient below which nothing found of a derivative speaks against the fit.
const LEAST_SHARE: f64 = 0.05;

/// Why a coefficient of the model has no fit.
pub(crate) const NO_WINDOW: &str = "no manoeuvre is used for this coefficient";

/// What is judged: a session and everything computed from it.
#[derive(Clone, Copy)]
pub(super) struct Evidence<'a> {
    pub(super) session: &'a Session,
    pub(super) snapshot: &'a Snapshot,
    pub(super) plausible: &'a Plausible,
    /// Controls that act at another time than that of their recording.
    pub(super) delays: &'a [ControlDelay],
    /// A force that follows its regressors late; none before the delays of the controls are known.
    pub(super) late_force: Option<LateForce>,
    /// What suspect causes change of the derivatives of the pooled fits.
    pub(super) consequences: &'a [Consequences],
    /// Verdicts on the windows, once they are formed.
    pub(super) judged_windows: Option<&'a BTreeMap<String, WindowVerdict>>,
    /// Median of the mean dynamic pressures of the windows, Pa; none before their coefficients are computed.
    pub(super) median_pressure_pa: Option<f64>,
    pub(super) noise: &'a MeasurementNoise<'a>,
}

impl<'a> Evidence<'a> {
    /// Windows not ignored, in the order of the session.
    pub(super) fn windows(self) -> impl Iterator<Item = &'a Manoeuvre> {
        self.session.active_windows()
    }

    /// What suspect causes change of a derivative of the pooled fit.
    pub(super) fn consequence(self, coefficient: Coefficient, name: &str) -> Option<&'a Consequence> {
        self.consequences.iter().find(|one| one.coefficient == coefficient)?.derivative(name)
    }
}

/// Judges everything a run computed from `session`. What is missing in `snapshot` is judged as not computed.
pub fn judge(session: &Session, snapshot: &Snapshot) -> Verdicts {
    let plausible = Plausible::new(session, snapshot);
    let noise = MeasurementNoise::new(session, snapshot);
    let evidence = Evidence {
        session,
        snapshot,
        plausible: &plausible,
        delays: &[],
        late_force: None,
        consequences: &[],
        judged_windows: None,
        median_pressure_pa: flight::median_pressure(session, snapshot),
        noise: &noise,
    };
    let study = studies::findings(evidence);
    let windows: Vec<&Manoeuvre> = evidence.windows().collect();
    let windows: BTreeMap<String, WindowVerdict> =
        windows.into_par_iter().map(|window| (window.name.clone(), window_verdict(evidence, window, &study))).collect();
    let delays = delay::delays(evidence, &windows);
    let evidence = Evidence { delays: &delays, ..evidence };
    let evidence = Evidence { late_force: late_force::find_late_force(evidence), ..evidence };
    let fits = snapshot.pooled.ready().map(|pooled| pooled.fits.as_slice()).unwrap_or_default();
    let suspects: Vec<&str> = windows
        .iter()
        .filter(|(_, judged)| weigh::is_suspect(&judged.verdict))
        .map(|(name, _)| name.as_str())
        .collect();
    let consequences = if fits.is_empty() { Vec::new() } else { effect::consequences(evidence, &suspects) };
    let evidence = Evidence { consequences: &consequences, judged_windows: Some(&windows), ..evidence };
    let mut pooled: Vec<FitVerdict> = fits.par_iter().map(|fit| fit_verdict(evidence, None, fit, &study)).collect();
    let single = windows.values().flat_map(|window| &window.fits);
    let used: Vec<&FitVerdict> = if pooled.is_empty() { single.collect() } else { pooled.iter().collect() };
    let of_fits: Vec<Finding> = used.iter().flat_map(|fit| fit.verdict.reasons.iter().cloned()).collect();
    // What they are made of is among the reasons of the session already.
    pooled.iter_mut().zip(fits).for_each(|(judged, fit)| judged.add(made_of::findings(evidence, fit)));
    let pooled = with_unused(evidence, pooled);
    let mut findings = session::findings(evidence);
    findings.extend(study.session.iter().cloned());
    findings.extend(windows.values().flat_map(|window| window.verdict.reasons.iter().cloned()));
    findings = by_effect(evidence, findings);
    findings.extend(by_effect(evidence, of_fits));
    findings.extend(pooled.iter().filter(|fit| fit.is_unused).flat_map(|fit| fit.verdict.reasons.iter().cloned()));
    if findings.iter().all(|finding| finding.level == Level::Good) {
        findings.extend(session::find_no_good_manoeuvre(&windows));
    }
    Verdicts { session: Verdict::from_findings(findings), windows, pooled }
}

/// Findings weighed by what they change of the derivatives, those that change most first; as they are where that is not known.
fn by_effect(evidence: Evidence<'_>, findings: Vec<Finding>) -> Vec<Finding> {
    let Some(pooled) = evidence.snapshot.pooled.ready().filter(|_| !evidence.consequences.is_empty()) else {
        return findings;
    };
    let mut weighed: Vec<(f64, Finding)> =
        findings.into_iter().map(|finding| weigh_finding(evidence, &pooled.fits, finding)).collect();
    weighed.sort_by(|a, b| b.0.total_cmp(&a.0));
    weighed.into_iter().map(|(_, finding)| finding).collect()
}

fn weigh_finding(evidence: Evidence<'_>, fits: &[CoefficientFit], finding: Finding) -> (f64, Finding) {
    let (level, part) = match (finding.code, finding.level) {
        // Why a derivative is not determined, or how much a model explains: the fit is marked by it, what else was asked is not.
        ("vif" | "condition" | "r2", Level::Caution) => (Level::Good, 0.0),
        // What a coefficient contains is said of it and of its derivatives.
        ("propulsion", Level::Caution) if finding.place.pooled().is_some() => (Level::Good, 0.0),
        _ => weigh::weighed(evidence, &finding, fits),
    };
    (part, Finding { level, ..finding })
}

/// The verdicts in the order of the structure, with one on each coefficient that the session models and no window is used for.
fn with_unused(evidence: Evidence<'_>, mut pooled: Vec<FitVerdict>) -> Vec<FitVerdict> {
    if evidence.session.aircraft.is_none() || evidence.snapshot.pooled.ready().is_none() {
        return pooled;
    }
    let coefficients = evidence.session.structure.models.iter().map(|(coefficient, _)| *coefficient);
    let mut one = |coefficient: Coefficient| {
        let known = pooled.iter().position(|fit| fit.coefficient == coefficient).map(|index| pooled.remove(index));
        known.unwrap_or_else(|| judge_unused(evidence.session, coefficient))
    };
    coefficients.map(&mut one).collect()
}

fn judge_unused(session: &Session, coefficient: Coefficient) -> FitVerdict {
    let finding = not_computed(Level::Caution, Place::derivative(coefficient.name(), None), NO_WINDOW);
    let fix_text = "Mark an identification manoeuvre that excites it, or remove the coefficient.";
    let finding = finding.with_fix_text(fix_text).with_setting("Manoeuvres", "manoeuvre.role");
    let finding = finding.with_fix(remedies::without_coefficient(session, coefficient));
    FitVerdict { coefficient, verdict: Verdict::from_findings([finding]), derivatives: Vec::new(), is_unused: true }
}

fn window_verdict(evidence: Evidence<'_>, manoeuvre: &Manoeuvre, study: &studies::StudyFindings) -> WindowVerdict {
    let fits = evidence.snapshot.windows.get(&manoeuvre.name).and_then(|results| results.fits.ready());
    let fits = fits.map(|fits| fits.fits.as_slice()).unwrap_or_default();
    let mut findings = window::findings(evidence, manoeuvre);
    findings.extend(study.of_window(&manoeuvre.name));
    WindowVerdict {
        verdict: Verdict::from_findings(findings),
        fits: fits.iter().map(|fit| fit_verdict(evidence, Some(&manoeuvre.name), fit, study)).collect(),
    }
}

fn fit_verdict(
    evidence: Evidence<'_>,
    window: Option<&str>,
    fit: &CoefficientFit,
    study: &studies::StudyFindings,
) -> FitVerdict {
    let mut findings = fit::findings(evidence, window, fit);
    if window.is_none() {
        findings
            .iter_mut()
            .for_each(|finding| finding.level = weigh::weighed(evidence, finding, std::slice::from_ref(fit)).0);
        findings.extend(biased::finding(evidence, fit));
        findings.extend(weigh::judge_outlying(evidence, fit));
    }
    let names = fit.fit.as_ref().map(|fit| fit.names.as_slice()).unwrap_or_default();
    let mut derivatives = Vec::with_capacity(names.len());
    let of_vanes: Vec<Finding> = findings.iter().filter(|finding| finding.code == vane::VANE).cloned().collect();
    let by_instruments = window.is_none().then(|| gust_bias::estimate(evidence, fit)).flatten();
    for (index, name) in names.iter().enumerate() {
        let mut found = derivative::findings(evidence, window, fit, index);
        found.extend(by_instruments.as_ref().and_then(|instrumental| instrumental.finding(fit, index)));
        found.extend(study.of_derivative(window, name));
        let matters = evidence.consequence(fit.coefficient, name).is_none_or(|found| found.share > LEAST_SHARE);
        findings.extend(found.iter().filter(|finding| matters && finding.code != derivative::DETERMINED).cloned());
        let consequence = evidence.consequence(fit.coefficient, name).filter(|_| window.is_none()).cloned();
        // The fit has this finding once, by what it is made of.
        found.extend(density::finding(evidence, name, window, fit));
        let place = Place::derivative(name, window);
        let of_vanes = of_vanes.iter().filter(|_| !is_constant_name(name));
        found.extend(of_vanes.map(|finding| Finding { place: place.clone(), ..finding.clone() }));
        derivatives.push(DerivativeVerdict { name: name.clone(), verdict: Verdict::from_findings(found), consequence });
    }
    FitVerdict {
        coefficient: fit.coefficient,
        verdict: Verdict::from_findings(findings),
        derivatives,
        is_unused: false,
    }
}

/// A finding of the level its figure has: none up to `caution`, caution up to `bad`, bad beyond.
pub(super) fn level_above(figure: f64, caution: f64, bad: f64) -> Option<(Level, f64)> {
    if figure > bad {
        Some((Level::Bad, bad))
    } else if figure > caution {
        Some((Level::Caution, caution))
    } else {
        None
    }
}

/// A finding about something that could not be computed.
pub(super) fn not_computed(level: Level, place: impl Into<Place>, error: &str) -> Finding {
    Finding::new(level, "failed", place, message!("Not computed: {}.", error))
}
