//! Findings of what was computed beside the derivatives: twins by other methods, timing of the controls, proof of match.

use std::collections::BTreeMap;

use doublet_core::message;

use super::judge::{Evidence, level_above};
use super::{Finding, Level, delay};
use crate::session::{Fix, Place};
use crate::snapshot::Snapshot;
use crate::stage::{WindowFits, WindowReplay};
use crate::study::{CheckedDerivative, Estimator, FollowedFlight, LagKind, WindowChecks};

/// Difference to a twin in joint errors, and the part of the estimate it must be as well: two methods differ by what neither's error
/// knows of.
pub(crate) const TWIN_CAUTION: f64 = 3.0;
const TWIN_BAD: f64 = 8.0;
pub(crate) const TWIN_PART: f64 = 0.1;
/// Delay of a control: samples of the recording and t for a caution, s for bad.
const DELAY_SAMPLES: f64 = 1.5;
const DELAY_T: f64 = 4.0;
const DELAY_BAD_S: f64 = 0.3;

/// Findings of the studies, by what they are about.
#[derive(Default)]
pub(super) struct StudyFindings {
    /// About no window and no derivative.
    pub(super) session: Vec<Finding>,
    windows: BTreeMap<String, Vec<Finding>>,
    derivatives: BTreeMap<(String, String), Vec<Finding>>,
}

impl StudyFindings {
    /// Findings about a window.
    pub(super) fn of_window(&self, window: &str) -> Vec<Finding> {
        self.windows.get(window).cloned().unwrap_or_default()
    }

    /// Findings about a derivative of a window's own fit; the pooled one has no twin.
    pub(super) fn of_derivative(&self, window: Option<&str>, name: &str) -> Vec<Finding> {
        let key = window.map(|window| (window.to_owned(), name.to_owned()));
        key.and_then(|key| self.derivatives.get(&key)).cloned().unwrap_or_default()
    }
}

/// What the studies that were computed say.
pub(super) fn findings(evidence: Evidence<'_>) -> StudyFindings {
    let mut found = StudyFindings::default();
    twins(evidence, &mut found);
    timing(evidence, &mut found);
    proof(evidence, &mut found);
    found
}

fn twins(evidence: Evidence<'_>, found: &mut StudyFindings) {
    let Some(checks) = evidence.snapshot.studies.checks.ready() else { return };
    for window in &checks.windows {
        found.windows.entry(window.window.clone()).or_default().extend(window.findings());
    }
    for twin in compare_twins(evidence.snapshot) {
        if let Some(finding) = twin.finding() {
            let key = (twin.window.to_owned(), twin.name.to_owned());
            found.derivatives.entry(key).or_default().push(finding);
        }
    }
}

/// A derivative of a window's own fit and the same by another method, each with its standard error.
pub(crate) struct Twin<'s> {
    pub(crate) window: &'s str,
    pub(crate) method: &'static str,
    pub(crate) name: &'s str,
    own: [f64; 2],
    other: [f64; 2],
}

/// Every derivative of every window beside the same by other methods, as far as their flights follow the recording: a motion that does not
/// says nothing against the derivatives of another method.
pub(crate) fn compare_twins(snapshot: &Snapshot) -> Vec<Twin<'_>> {
    let checks = snapshot.studies.checks.ready();
    checks.into_iter().flat_map(|checks| &checks.windows).flat_map(|window| compare_window(snapshot, window)).collect()
}

fn compare_window<'s>(snapshot: &'s Snapshot, window: &'s WindowChecks) -> Vec<Twin<'s>> {
    let fits = snapshot.windows.get(&window.window).and_then(|results| results.fits.ready());
    let Some(fits) = fits else { return Vec::new() };
    let strays = |flight: &&FollowedFlight| flight.findings(&window.window).iter().any(|f| f.level == Level::Bad);
    let astray: Vec<_> = window.flights().filter(strays).map(|flight| flight.axis.name()).collect();
    let followed = window.estimates().filter(|(_, part, _)| !astray.contains(&part.axis()));
    let compare = |method: &'static Estimator, twin: &'s CheckedDerivative| {
        let own = own_estimate(fits, &twin.name)?;
        let other = [twin.estimate, twin.standard_error];
        Some(Twin { window: &window.window, method: method.name, name: &twin.name, own, other })
    };
    let all = followed.flat_map(|(method, _, found)| found.derivatives.iter().map(move |twin| (method, twin)));
    all.filter_map(|(method, twin)| compare(method, twin)).collect()
}

/// A derivative of a window's own fit with its corrected error.
fn own_estimate(fits: &WindowFits, name: &str) -> Option<[f64; 2]> {
    fits.fits.iter().find_map(|fit| {
        let estimate = fit.fit.as_ref().ok()?;
        let index = estimate.names.iter().position(|own| own == name)?;
        Some([estimate.estimates[index], *fit.corrected_errors.get(index)?])
    })
}

impl Twin<'_> {
    /// Their difference in joint standard errors; zero where it is a small part of the estimate.
    pub(crate) fn times(&self) -> f64 {
        let difference = (self.own[0] - self.other[0]).abs();
        if difference < TWIN_PART * self.own[0].abs() { 0.0 } else { difference / self.own[1].hypot(self.other[1]) }
    }

    fn finding(&self) -> Option<Finding> {
        let (times, [estimate, error], [other, other_error]) = (self.times(), self.own, self.other);
        let (level, limit) = level_above(times, TWIN_CAUTION, TWIN_BAD)?;
        let text = message!(
            "Equation error {:.4} ± {:.2}, {} {:.4} ± {:.2}: {:.1} joint standard errors apart (limit {}).",
            estimate,
            error,
            self.method,
            other,
            other_error,
            times,
            limit
        );
        let place = Place::derivative(self.name, Some(self.window));
        let finding = Finding::new(level, "twin", place, text).with_figure(times, limit);
        let fix_text = "Check the fit of output error, the delays and the frequency band.";
        Some(finding.with_fix_text(fix_text).with_setting("Derivatives", "model"))
    }
}

fn timing(evidence: Evidence<'_>, found: &mut StudyFindings) {
    let Some(lags) = evidence.snapshot.studies.lags.ready() else { return };
    for lag in lags.lags.iter().filter(|lag| lag.kind == LagKind::Delay) {
        let Ok((delay_s, error_s)) = lag.found_s() else { continue };
        let stated_s = evidence.session.preparation.control_lags.get(lag.surface).delay_s;
        let (left_s, step_s) = (delay_s - stated_s, sample_interval_s(evidence).unwrap_or(f64::NAN));
        let level = match left_s.abs() {
            left if left > DELAY_BAD_S => Level::Bad,
            left if left > DELAY_SAMPLES * step_s && left > DELAY_T * error_s => Level::Caution,
            _ => continue,
        };
        // What one comparison finds and the pooled fit of the moment does not need, or does not change by, is no delay.
        if delay::matters(evidence, lag.surface, left_s) == Some(false) {
            continue;
        }
        let limit_s = if level == Level::Bad { DELAY_BAD_S } else { DELAY_SAMPLES * step_s };
        let name = lag.surface.name();
        let text =
            message!("{} delay must change by {:+.3} ± {:.3} s (limit {:.3} s).", name, left_s, error_s, limit_s);
        let finding = Finding::new(level, "timing", name, text).with_figure(left_s, limit_s);
        let fix_text = format!("Correct the delay, or check the clock of the {name}.");
        let fix = Fix::control_delay(evidence.session, lag.surface, delay_s);
        let finding = finding.with_fix_text(fix_text).with_setting("Model", format!("preparation.control_lag.{name}"));
        found.session.push(finding.with_fix(fix));
    }
}

/// Interval of the inertial samples, s.
fn sample_interval_s(evidence: Evidence<'_>) -> Option<f64> {
    let path = evidence.windows().find_map(|window| evidence.snapshot.windows.get(&window.name)?.path.ready())?;
    let time_s = &path.reconstruction.time_s;
    Some((time_s.last()? - time_s.first()?) / (time_s.len().max(2) - 1) as f64)
}

fn proof(evidence: Evidence<'_>, found: &mut StudyFindings) {
    let Some(proof) = evidence.snapshot.proof.ready() else { return };
    for (window, replay) in &proof.windows {
        let Ok(replay) = replay else { continue };
        if let Some(finding) = missed(window, replay, &proof.tolerances) {
            found.windows.entry(window.clone()).or_default().push(finding);
        }
    }
}

/// The test a window fails by most.
fn missed(window: &str, replay: &WindowReplay, tolerances: &str) -> Option<Finding> {
    let failed = replay.tests.iter().filter(|test| !test.passed()).flat_map(|test| {
        let missed = test.requirements.iter().filter(|bands| !bands.iter().any(|band| band.passed()));
        // One band of a requirement is enough: the nearest is what is missed.
        missed
            .filter_map(move |bands| Some((test, bands.iter().min_by(|a, b| a.worst_ratio.total_cmp(&b.worst_ratio))?)))
    });
    let (test, band) = failed.max_by(|a, b| a.1.worst_ratio.total_cmp(&b.1.worst_ratio))?;
    let text = message!(
        "Simulated {} misses test {}: {:.2} times its tolerance ({}, limit 1).",
        band.tolerance.signal.name(),
        &test.id,
        band.worst_ratio,
        tolerances
    );
    let finding = Finding::new(Level::Caution, "match", Place::manoeuvre(window), text);
    let finding = finding.with_figure(band.worst_ratio, 1.0);
    Some(
        finding
            .with_fix_text("Check the proof of match and the derivatives behind this output.")
            .with_setting("Match", "model"),
    )
}
