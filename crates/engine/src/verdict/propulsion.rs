//! Findings about the thrust that coefficients are freed of: extrapolated, or not known.

use doublet_core::message;
use doublet_core::message::{Message, quoted};
use doublet_core::model::{Coefficient, Term, ThrustTreatment, Variable};

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Fix, Manoeuvre, Place};
use crate::stage::{CoefficientFit, WindowAero};

/// Coefficients that the thrust enters as it is.
pub(super) const ALONG_THRUST: [Coefficient; 2] = [Coefficient::CX, Coefficient::CD];

/// Whether what a map extrapolates changes the axial force of a window by more than its fit leaves over.
pub(super) fn extrapolated(
    place: &Place,
    evidence: Evidence<'_>,
    manoeuvre: &Manoeuvre,
    aero: &WindowAero,
) -> Option<Finding> {
    if aero.settings.thrust == ThrustTreatment::Included {
        return None;
    }
    let fits = evidence.snapshot.windows.get(&manoeuvre.name)?.fits.ready()?;
    let residual = fits.fits.iter().find_map(|fit| {
        let fit = fit.fit.as_ref().ok().filter(|_| ALONG_THRUST.contains(&fit.coefficient))?;
        Some(fit.residual_std)
    })?;
    let furthest = aero.extrapolated_thrust.iter().find_map(|thrust| Some((thrust, thrust.off_range.first()?)))?;
    let change = change_of_axial_force(aero);
    if change <= residual {
        return None;
    }
    let (thrust, (off_range, _)) = furthest;
    let text = message!(
        "Thrust of engine {} is extrapolated: CX changes by {:.4}, residual {:.4} ({}).",
        quoted(&thrust.engine),
        change,
        residual,
        off_range.message()
    );
    let finding = Finding::new(Level::Caution, "propulsion", place, text).with_figure(change, residual);
    let fix_text = "Extend the engine chart and propeller map, or record the thrust.";
    Some(finding.with_fix_text(fix_text).with_setting("Propulsion", "aircraft"))
}

/// Root mean square over the window of what the extrapolation of all engines adds to the thrust, over dynamic pressure and area.
fn change_of_axial_force(aero: &WindowAero) -> f64 {
    let data = &aero.data;
    let square = |k: usize| {
        let added_n: f64 = aero.extrapolated_thrust.iter().map(|thrust| thrust.added_n[k]).sum();
        let pressure = 0.5 * data.density_kg_m3[k] * data.airspeed_m_s[k].powi(2);
        (added_n / (pressure * aero.settings.reference.area_m2)).powi(2)
    };
    let samples = data.time_s.len();
    ((0..samples).map(square).sum::<f64>() / samples.max(1) as f64).sqrt()
}

/// Whether a coefficient along the thrust contains one that is not known.
pub(super) fn is_unknown(evidence: Evidence<'_>, fit: &CoefficientFit) -> bool {
    let aero = |(window, _): &(String, usize)| evidence.snapshot.windows.get(window)?.aero.ready();
    ALONG_THRUST.contains(&fit.coefficient)
        && fit
            .windows
            .iter()
            .filter_map(aero)
            .all(|aero| aero.settings.thrust == ThrustTreatment::Included && aero.data.engines.is_empty())
}

/// Adds a term of airspeed to a coefficient that contains an unknown thrust; none where it has one.
pub(super) fn airspeed_term(evidence: Evidence<'_>, coefficient: Coefficient) -> Option<Fix> {
    let airspeed = Term::product([(Variable::Airspeed, 1)]);
    let terms = evidence.session.structure.terms(coefficient)?;
    (!terms.contains(&airspeed)).then(|| Fix::set_term(coefficient, &airspeed, true))
}

/// Whether the thrust is not known in a window of a fit along it.
pub(super) fn unknown(
    at: &Place,
    evidence: Evidence<'_>,
    fit: &CoefficientFit,
    used: &[&WindowAero],
) -> Option<Finding> {
    if !ALONG_THRUST.contains(&fit.coefficient) {
        return None;
    }
    let name = fit.coefficient.name();
    let fix_text = "Record the thrust, or engine speed and manifold pressure.";
    let finding = |level: Level, text: Message| {
        Some(
            Finding::new(level, "propulsion", at, text)
                .with_fix_text(fix_text)
                .with_setting("Propulsion", "preparation.remove_thrust"),
        )
    };
    let taken_out = |aero: &&&WindowAero| aero.settings.thrust != ThrustTreatment::Included;
    let partly = used.iter().filter(taken_out).find_map(|aero| aero.unknown_thrust.first());
    if let Some(engine) = partly {
        return finding(
            Level::Bad,
            message!("Thrust of engine {} is neither recorded nor modelled; {} contains it.", quoted(engine), name),
        );
    }
    let with_thrust = used.iter().all(|aero| aero.settings.thrust == ThrustTreatment::Included);
    let none_known = !used.is_empty() && used.iter().all(|aero| aero.data.engines.is_empty());
    if !(with_thrust && none_known) {
        return None;
    }
    let text = message!("Thrust is unknown: {} contains it and its change with airspeed.", name);
    Some(finding(Level::Caution, text)?.with_fix(airspeed_term(evidence, fit.coefficient)))
}
