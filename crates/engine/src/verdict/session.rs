//! Findings about the session as a whole: channels that contradict each other, what could not be computed, what is only assumed.

use std::collections::BTreeMap;

use super::judge::{Evidence, not_computed};
use super::{Finding, Level, WindowVerdict, accelerometer, gravity, loading, made_of, mounting, shape};
use crate::graph::Stage;
use crate::session::{Edit, Fix, Place, WindowEdit};
use crate::stage::{LoadedAircraft, PooledFits};

/// What speaks against the session besides its windows, fits and studies.
pub(super) fn findings(evidence: Evidence<'_>) -> Vec<Finding> {
    let snapshot = evidence.snapshot;
    let physics = snapshot.physics.iter().filter_map(|(name, slot)| Some((name, slot.ready()?)));
    let physics = physics.flat_map(|(name, physics)| physics.findings(evidence.session, name));
    let unnamed = evidence.session.aircraft.is_none().then(|| {
        let text = "No aircraft: coefficients and derivatives were not computed.";
        let fix_text = "Choose an aircraft.";
        Finding::new(Level::Caution, "aircraft", "session", text)
            .with_fix_text(fix_text)
            .with_setting("Loading", "aircraft")
    });
    let failures = snapshot.failures().into_iter();
    // Failures of windows are theirs.
    let others = failures.filter(|(place, _)| place.manoeuvre_name().is_none());
    let failed = others.map(|(place, error)| {
        let panel = panel_of(&place);
        not_computed(weight(&place), place, &error).with_setting(panel, "")
    });
    let densities = evidence.windows().filter_map(|window| snapshot.windows.get(&window.name)?.aero.ready());
    // Windows of one session share what it assumes.
    let assumed = densities.filter_map(|aero| aero.air_density.finding()).take(1);
    let used = snapshot.gravity_m_s2(evidence.session);
    let gravity = gravity::findings(evidence, used);
    let flights = snapshot.flights.values().filter_map(|slot| slot.ready());
    let signals = flights.flat_map(|loaded| loaded.findings.iter().cloned());
    let mass = loading::assumed(evidence);
    let has_coefficients =
        |window: &&str| snapshot.windows.get(*window).is_some_and(|results| results.aero.ready().is_some());
    let windows = evidence.windows().map(|window| window.name.as_str()).filter(has_coefficients);
    let airspeed = made_of::airspeed(evidence, windows);
    let place = accelerometer::findings(evidence.session, snapshot);
    let rates = mounting::findings(evidence.session, snapshot);
    physics
        .chain(place)
        .chain(rates)
        .chain(shape::geometry_findings(snapshot))
        .chain(signals)
        .chain(gravity)
        .chain(mass)
        .chain(unnamed)
        .chain(failed)
        .chain(assumed)
        .chain(airspeed)
        .collect()
}

/// That no manoeuvre is good, where there are some: what was estimated rests on doubtful ones alone.
pub(super) fn find_no_good_manoeuvre(windows: &BTreeMap<String, WindowVerdict>) -> Option<Finding> {
    let is_none = !windows.is_empty() && windows.values().all(|window| window.verdict.level > Level::Good);
    let fix_text = "Correct what the findings of the manoeuvres name, or use other manoeuvres.";
    is_none.then(|| {
        Finding::new(Level::Caution, "no-good-manoeuvre", "session", "No manoeuvre is good.")
            .with_fix_text(fix_text)
            .with_setting("Manoeuvres", "manoeuvre.role")
            .with_fix(join_fixes(windows))
    })
}

/// The fixes of the findings of all manoeuvres as one, without those that leave a manoeuvre out: then none would be left.
fn join_fixes(windows: &BTreeMap<String, WindowVerdict>) -> Option<Fix> {
    let leaves_out = |fix: &Fix| fix.edits.iter().any(|edit| matches!(edit, Edit::Window(WindowEdit::Role { .. })));
    let mut fixes: Vec<&Fix> = Vec::new();
    let reasons = windows.values().flat_map(|window| &window.verdict.reasons);
    for fix in reasons.filter(|reason| reason.level > Level::Good).filter_map(|reason| reason.fix.as_ref()) {
        if !leaves_out(fix) && fixes.iter().all(|known| known.edits != fix.edits) {
            fixes.push(fix);
        }
    }
    Fix::join(&fixes)
}

/// The panel in which a stage that failed is set.
fn panel_of(place: &Place) -> &'static str {
    match place {
        Place::Flight { .. } => "Channels",
        _ if place.is_named(LoadedAircraft::NAME) => "Loading",
        _ if place.is_named(PooledFits::NAME) => "Model",
        _ => "Studies",
    }
}

/// Whether derivatives hang on a stage.
fn weight(place: &Place) -> Level {
    let is_needed = [LoadedAircraft::NAME, PooledFits::NAME].iter().any(|name| place.is_named(name));
    if is_needed || matches!(place, Place::Flight { .. }) { Level::Bad } else { Level::Caution }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{NoiseChannel, Verdict, WindowRole};

    #[test]
    fn the_fix_where_no_manoeuvre_is_good_is_that_of_all_without_those_that_leave_one_out() {
        let noise = |std: f64| {
            let channel = NoiseChannel::Measurement(doublet_core::reconstruct::Measurement::AngleOfAttack);
            Fix::new(format!("set {std}"), Edit::noise(channel, std))
        };
        let finding = |name: &str, fix: Fix| {
            Finding::new(Level::Caution, "nis", Place::manoeuvre(name), "Mean NIS is high.").with_fix(Some(fix))
        };
        let window = |findings: Vec<Finding>| WindowVerdict { verdict: Verdict::from_findings(findings), fits: vec![] };
        let ignored = Edit::Window(WindowEdit::Role { name: "b".to_owned(), role: WindowRole::Ignored });
        let all = BTreeMap::from([
            ("a".to_owned(), window(vec![finding("a", noise(0.1))])),
            ("b".to_owned(), window(vec![finding("b", noise(0.1)), finding("b", Fix::new("ignore b", ignored))])),
            ("c".to_owned(), window(vec![finding("c", noise(0.2))])),
        ]);
        let fix = find_no_good_manoeuvre(&all).expect("none is good").fix.expect("there are fixes");
        assert_eq!(fix.edits, [noise(0.1).edits, noise(0.2).edits].concat());
        assert_eq!(fix.label, "set 0.1 and 1 more");
        let one_good = BTreeMap::from([("a".to_owned(), window(vec![])), ("c".to_owned(), all["c"].clone())]);
        assert!(find_no_good_manoeuvre(&one_good).is_none());
    }
}
