//! The zero of the sideslip vane, by the constants of the lateral coefficients.

use doublet_core::message;
use doublet_core::model::{Coefficient, Term, Variable};
use doublet_core::quantity::Role;
use doublet_core::statistics::median;

use super::{Finding, Level, remedies};
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::stage::CoefficientFit;

/// Least offset that is noted, rad.
const LEAST_RAD: f64 = 1.0_f64.to_radians();
/// Difference from the mean offset up to which coefficients agree, as a part of it.
const AGREEMENT: f64 = 0.15;

/// An offset of the sideslip that the constants of CY and Cn show alike, with Cl where it agrees.
///
/// A symmetric aircraft has `C = C_beta (beta - beta_0) + ...`: the constant `C_0` of each lateral coefficient gives
/// `beta_0 = -C_0 / C_beta`. A trim tab, a propeller or asymmetric thrust changes the constants in other proportions, so that the
/// offsets differ. The derivatives do not depend on the offset; the level is good.
pub(super) fn offset(session: &Session, snapshot: &Snapshot) -> Option<Finding> {
    let fits = &snapshot.pooled.ready()?.fits;
    let by = |coefficient| fits.iter().find(|fit| fit.coefficient == coefficient).and_then(offset_rad);
    let (side, yaw) = (by(Coefficient::CY)?, by(Coefficient::Cn)?);
    let offset = 0.5 * (side + yaw);
    let agrees = |other: &f64| (other - offset).abs() < AGREEMENT * offset.abs();
    if offset.abs() < LEAST_RAD || !agrees(&side) {
        return None;
    }
    let coefficients = match by(Coefficient::Cl).filter(agrees) {
        Some(_) => "CY, Cl and Cn",
        None => "CY and Cn",
    };
    let offset_deg = offset.to_degrees();
    let text =
        message!("Constants of {} show a sideslip offset of {:+.1} deg (limit 1 deg).", coefficients, offset_deg);
    let fix_text = format!("Check the zero of the sideslip vane, or set its offset to {:+.1} deg.", -offset_deg);
    let finding = Finding::new(Level::Good, "sideslip-offset", "session", text).with_figure(offset, LEAST_RAD);
    let finding = finding.with_fix_text(fix_text).with_setting("Channels", "");
    Some(finding.with_fix(remedies::add_offset(session, snapshot, Role::Sideslip, -offset)))
}

/// `-C_0 / C_beta` of a pooled fit, rad, with the median of the constants of its manoeuvres; none where either is missing.
fn offset_rad(fit: &CoefficientFit) -> Option<f64> {
    let found = fit.fit.as_ref().ok()?;
    let (slope, _) = found.parameter(&Term::product([(Variable::Beta, 1)]).derivative_name(fit.coefficient))?;
    let constant = Term::product([]).derivative_name(fit.coefficient);
    let of_manoeuvre = format!("{constant}[");
    let named = found.names.iter().zip(&found.estimates);
    let constants = named.filter(|(name, _)| **name == constant || name.starts_with(&of_manoeuvre));
    let constant = median(&mut constants.map(|(_, estimate)| *estimate).collect::<Vec<_>>())?;
    Some(-constant / slope).filter(|offset| offset.is_finite())
}
