//! Vanes that are missing, and vanes that show more or less than the flow angle of the path: upwash, or a wrong calibration.

use doublet_core::estimate::{Sensor, SensorError};
use doublet_core::message;
use doublet_core::model::{Term, Variable};
use doublet_core::reconstruct::Measurement;

use super::judge::Evidence;
use super::mounting::with_known_errors;
use super::{Finding, Level};
use crate::session::{Place, Session};
use crate::stage::VaneScale;

/// Code of findings on vanes. Every derivative of the fit has them: wrong regressors change all estimates of a fit.
pub(super) const VANE: &str = "vane";

/// A scale error is a finding beyond this part, and beyond this many standard errors.
const SCALE: f64 = 0.08;
const SIGNIFICANT: f64 = 5.0;

/// That no vane is recorded for the angle `name` of a fit at the place `at`, which moves so many times its uncertainty.
pub(super) fn missing(at: &Place, name: &str, (times, limit): (f64, f64)) -> Finding {
    let text =
        message!("No vane recorded for {}: it moves {:.1} times its uncertainty (limit {}).", name, times, limit);
    let finding = Finding::new(Level::Caution, VANE, at, text).with_figure(times, limit);
    let fix_text = "Record a flow-angle vane; without one, compare with another flight.";
    finding.with_fix_text(fix_text).with_setting("Channels", "")
}

/// The scale errors of the flow angles that a fit at the place `at` regresses on: a derivative to the angle is too small by the same part.
pub(super) fn findings(evidence: Evidence<'_>, at: &Place, terms: &[Term]) -> Vec<Finding> {
    let Some(pooled) = evidence.snapshot.pooled.ready() else { return Vec::new() };
    let is_used = |scale: &&VaneScale| {
        let variable = match scale.measurement {
            Measurement::AngleOfAttack => Variable::Alpha,
            _ => Variable::Beta,
        };
        terms.iter().flat_map(|term| term.factors()).any(|(one, _)| *one == variable)
    };
    pooled.vane_scales.iter().filter(is_used).filter_map(|scale| finding(evidence.session, at, scale)).collect()
}

fn finding(session: &Session, at: &Place, scale: &VaneScale) -> Option<Finding> {
    let VaneScale { measurement, value, standard_error } = *scale;
    let least = SCALE.max(SIGNIFICANT * standard_error);
    if value.abs() <= least {
        return None;
    }
    let (shown, limit) = (1.0 + value, 1.0 + least.copysign(value));
    let name = measurement.name();
    let text = message!(
        "{} vane scale is {:.3} ± {:.3} of the reconstructed path (limit {:.2}).",
        name,
        shown,
        standard_error,
        limit
    );
    let finding = Finding::new(Level::Caution, VANE, at, text).with_figure(shown, limit);
    let finding =
        finding.with_fix_text(format!("Check the calibration of {name} and its upwash, or correct its scale."));
    let error = SensorError::Scale(Sensor::Measurement(measurement));
    let known = session.preparation.known_errors.0.get(&error).copied().unwrap_or(0.0);
    let all = (1.0 + known) * (1.0 + value) - 1.0;
    Some(with_known_errors(finding, session, &format!("correct the scale of {name}"), &[(error, all)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::begin::empty_session;

    #[test]
    fn a_scale_beyond_its_limit_is_a_caution_with_the_error_to_correct() {
        let session = empty_session("", None);
        let scale = |value, standard_error| VaneScale { measurement: Measurement::Sideslip, value, standard_error };
        let found = finding(&session, &"Cn".into(), &scale(0.2, 0.01)).unwrap();
        assert_eq!((found.level, found.code), (Level::Caution, VANE));
        assert_eq!(found.text.to_string(), "beta vane scale is 1.200 ± 0.010 of the reconstructed path (limit 1.08).");
        assert_eq!(found.value.as_deref(), Some("{ scale_beta = 0.2 }"));
        for small in [scale(0.07, 0.001), scale(-0.2, 0.05)] {
            assert_eq!(finding(&session, &"Cn".into(), &small), None);
        }
    }
}
