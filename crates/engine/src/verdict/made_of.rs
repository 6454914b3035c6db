//! What speaks against a pooled fit because of what it is made of: channels that contradict others, an impossible aircraft, air
//! whose density is only assumed.

use doublet_core::message;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;

use super::judge::Evidence;
use super::{Finding, Level, shape, weigh};
use crate::session::{Fix, Place, Surface};
use crate::stage::CoefficientFit;

/// Findings about what a pooled fit is made of; each is said of the window, the flight or the aircraft as well.
pub(super) fn findings(evidence: Evidence<'_>, fit: &CoefficientFit) -> Vec<Finding> {
    let at = Place::derivative(fit.coefficient.name(), None);
    let aircraft = shape::findings_of(evidence.snapshot, fit.coefficient);
    let aircraft = aircraft.into_iter().map(|found| Finding { place: at.clone(), ..found });
    let formed = fit.windows.iter().filter_map(|(window, _)| evidence.snapshot.windows.get(window)?.aero.ready());
    let air = formed
        .filter_map(|aero| aero.air_density.finding())
        .take(1)
        .map(|found| Finding { place: at.clone(), ..found });
    let windows_of_fit = fit.windows.iter().map(|(window, _)| window.as_str());
    let unmeasured = airspeed(evidence, windows_of_fit).map(|found| Finding { place: at.clone(), ..found });
    let own = contradicted(&at, evidence, fit);
    own.into_iter().chain(aircraft).chain(air).chain(unmeasured).collect()
}

/// That no airspeed is measured in some of the windows: it is the ground velocity less a wind which nothing tells.
pub(super) fn airspeed<'w>(evidence: Evidence<'_>, mut windows: impl Iterator<Item = &'w str>) -> Option<Finding> {
    let path = |window: &str| evidence.snapshot.windows.get(window)?.path.ready();
    windows.find(|window| path(window).is_some_and(|path| path.missing.contains(&Measurement::Airspeed)))?;
    let text = "Airspeed not recorded: dynamic pressure, flow angles and derivatives depend on an assumed wind.";
    let finding = Finding::new(Level::Caution, "assumed", "airspeed", text);
    let fix_text = "Map a true airspeed, or a calibrated one with pressure or altitude.";
    Some(finding.with_fix_text(fix_text).with_setting("Channels", "airspeed"))
}

/// That channels it is made of contradict others beyond doubt and that the fit with them corrected could not be formed; a control speaks
/// against the coefficients with a term of it alone.
pub(super) fn contradicted(at: &Place, evidence: Evidence<'_>, fit: &CoefficientFit) -> Option<Finding> {
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
    let of_flight = |(flight, slot): (&'_ String, &'_ crate::snapshot::Slot<crate::stage::FlightPhysics>)| {
        let rows = slot.ready().into_iter().flat_map(|physics| physics.contradictions().map(move |row| (physics, row)));
        let bad = rows.filter(|(_, row)| row.level == Level::Bad && Role::from_name(&row.channel).is_none_or(enters));
        let open = bad.filter(|(_, row)| !weigh::is_known(evidence, fit.coefficient, flight, &row.channel));
        let named = open.map(|(physics, row)| (row.channel.clone(), physics.fix(evidence.session, flight, row)));
        named.collect::<Vec<_>>()
    };
    let (mut names, fixes): (Vec<String>, Vec<Option<Fix>>) = physics.flat_map(of_flight).unzip();
    names.dedup();
    if names.is_empty() {
        return None;
    }
    let text = message!("Computed from inconsistent channels: {}.", names.join(", "));
    let finding = Finding::new(Level::Bad, "physics", at, text);
    let finding = finding.with_fix_text("Correct these channels in the channel map.");
    let fix = Fix::join(&fixes.iter().flatten().collect::<Vec<_>>());
    Some(finding.with_setting("Channels", "").with_fix(fix))
}
