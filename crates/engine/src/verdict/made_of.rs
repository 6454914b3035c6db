//! What speaks against a pooled fit because of what it is made of: bad windows, channels that contradict others, an impossible aircraft, air
//! whose density is only assumed.

use std::collections::BTreeMap;

use doublet_core::model::Coefficient;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;

use super::judge::{Evidence, WindowVerdict, place};
use super::{Finding, Level, Verdict, accelerometer, shape};
use crate::session::Surface;
use crate::stage::CoefficientFit;

/// Part of a fit's samples in windows that are bad, or do not fit together, from which the fit is as they are.
const BAD_PART: f64 = 0.5;

/// Findings about what a pooled fit is made of; each is said of the window, the flight or the aircraft as well.
pub(super) fn findings(
    evidence: Evidence<'_>,
    fit: &CoefficientFit,
    windows: &BTreeMap<String, WindowVerdict>,
) -> Vec<Finding> {
    let at = place(fit.coefficient.name(), None);
    let aircraft = shape::of_session(evidence.snapshot).into_iter().map(|found| Finding { place: at.clone(), ..found });
    let formed = fit.windows.iter().filter_map(|(window, _)| evidence.snapshot.windows.get(window)?.aero.ready());
    let air = formed
        .filter_map(|aero| aero.air_density.finding())
        .take(1)
        .map(|found| Finding { place: at.clone(), ..found });
    let windows_of_fit = fit.windows.iter().map(|(window, _)| window.as_str());
    let unmeasured = airspeed(evidence, windows_of_fit).map(|found| Finding { place: at.clone(), ..found });
    let is_moment = matches!(fit.coefficient, Coefficient::Cl | Coefficient::Cm | Coefficient::Cn);
    let places = accelerometer::findings(evidence.session, evidence.snapshot).into_iter().filter(|_| !is_moment);
    let places = places.map(|found| Finding { place: at.clone(), ..found });
    let own = unusable(&at, fit, windows).into_iter().chain(contradicted(&at, evidence, fit));
    own.chain(aircraft).chain(air).chain(unmeasured).chain(places).collect()
}

/// That no airspeed is measured in some of the windows: it is the ground velocity less a wind which nothing tells.
pub(super) fn airspeed<'w>(evidence: Evidence<'_>, mut windows: impl Iterator<Item = &'w str>) -> Option<Finding> {
    let path = |window: &str| evidence.snapshot.windows.get(window)?.path.ready();
    windows.find(|window| path(window).is_some_and(|path| path.missing.contains(&Measurement::Airspeed)))?;
    let text = "no airspeed is measured: that of the path is the ground velocity less a wind that nothing tells, and with it dynamic \
                pressure, flow angles and every derivative";
    let finding = Finding::new(Level::Caution, "assumed", "airspeed", text.to_owned());
    let cure = "map an airspeed, true or calibrated";
    Some(finding.with_cure(cure).with_setting("Channels", "airspeed"))
}

/// That it is made of windows whose samples or flight path are bad, or do not fit together: bad where windows that are bad hold at least
/// half of its samples.
fn unusable(at: &str, fit: &CoefficientFit, windows: &BTreeMap<String, WindowVerdict>) -> Option<Finding> {
    let all: usize = fit.windows.iter().map(|(_, samples)| samples).sum();
    let judged = |window: &str, is: fn(&Verdict) -> bool| windows.get(window).is_some_and(|judged| is(&judged.verdict));
    let found = |is: fn(&Verdict) -> bool| {
        let windows = fit.windows.iter().filter(|(window, _)| judged(window, is));
        let (names, samples): (Vec<String>, Vec<usize>) =
            windows.map(|(window, samples)| (format!("'{window}'"), *samples)).unzip();
        (names, samples.iter().sum::<usize>() as f64 / all.max(1) as f64)
    };
    let (bad, part) = found(|verdict| verdict.level == Level::Bad);
    let (odd, odd_part) = found(does_not_follow);
    let (level, names, part, what) = if part >= BAD_PART {
        (Level::Bad, bad, part, "are bad")
    } else if odd_part >= BAD_PART {
        (Level::Caution, odd, odd_part, "do not fit together")
    } else if !bad.is_empty() {
        (Level::Caution, bad, part, "are bad")
    } else {
        return None;
    };
    let text = format!(
        "{:.0} % of its samples are of windows whose samples or flight path {what}: {}",
        100.0 * part,
        names.join(", ")
    );
    let finding = Finding::new(level, "windows", at, text).with_figure(part, BAD_PART);
    let cure = "mend what is said of these windows, or take them out of the identification";
    Some(finding.with_cure(cure).with_setting("Manoeuvres", "window.role"))
}

/// Whether the measurements of a window do not fit one flight path; noise stated too large is no reason for that.
fn does_not_follow(verdict: &Verdict) -> bool {
    let is_small = |reason: &Finding| reason.figure.is_some_and(|ratio| ratio < 1.0);
    verdict.reasons.iter().any(|reason| match reason.code {
        "nis" => !is_small(reason),
        "smoother" | "innovation" | "saturated" => true,
        _ => false,
    })
}

/// That channels it is made of contradict others beyond doubt; a control speaks against the coefficients with a term of it alone.
fn contradicted(at: &str, evidence: Evidence<'_>, fit: &CoefficientFit) -> Option<Finding> {
    let terms = evidence.session.structure.terms(fit.coefficient).unwrap_or_default();
    let enters = |role: Role| match Surface::ALL.into_iter().find(|surface| surface.role() == role) {
        Some(surface) => {
            let of_surface = |(variable, _): &(_, i32)| *variable == surface.variable();
            terms.iter().any(|term| term.factors().iter().any(of_surface))
        }
        None => true,
    };
    let flights: Vec<&str> = evidence
        .windows()
        .filter(|window| fit.windows.iter().any(|(name, _)| *name == window.name))
        .map(|window| window.flight.as_str())
        .collect();
    let physics = evidence.snapshot.physics.iter().filter(|(flight, _)| flights.contains(&flight.as_str()));
    let rows = physics.filter_map(|(_, slot)| slot.ready()).flat_map(|physics| physics.contradictions());
    let bad = rows.filter(|row| row.level == Level::Bad && Role::from_name(&row.channel).is_none_or(enters));
    let mut names: Vec<&str> = bad.map(|row| row.channel.as_str()).collect();
    names.dedup();
    if names.is_empty() {
        return None;
    }
    let text = format!("it is made of channels that others contradict: {}", names.join(", "));
    let finding = Finding::new(Level::Bad, "physics", at, text);
    let finding = finding.with_cure("change in the channel map what is said of them");
    Some(finding.with_setting("Channels", ""))
}
