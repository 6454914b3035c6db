//! Derivatives of flights without a vane, which gusts can bias, beside their estimates by instrumental variables.

use doublet_core::message;
use doublet_core::model::{Structure, is_constant_name};

use super::derivative::with_error;
use super::fit::{moving_terms, used_windows, without_vane};
use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Estimation, Place, ResidualWeights};
use crate::stage::{CoefficientFit, by_instruments, pooled_regressions, sample_step_s};

/// Code of the findings.
const GUST_BIAS: &str = "gust-bias";
/// Standard errors of the estimate by instruments, and of the fit, beyond which the two contradict each other: less than two of the
/// second is inside what the fit states.
const BY_INSTRUMENTS: f64 = 3.0;
const OF_FIT: f64 = 2.0;
/// Samples of the fit up to which it is compared: the comparison is part of every verdict.
const MOST_SAMPLES: usize = 100_000;

/// Estimates by instrumental variables.
pub(super) struct Instrumental {
    names: Vec<String>,
    estimates: Vec<f64>,
    errors: Vec<f64>,
}

/// The pooled fit by instrumental variables, where a flow angle of its terms has no vane in any manoeuvre.
pub(super) fn estimate(evidence: Evidence<'_>, fit: &CoefficientFit) -> Option<Instrumental> {
    let Evidence { session, snapshot, .. } = evidence;
    let used = used_windows(session, snapshot, fit);
    let samples: usize = fit.windows.iter().map(|(_, samples)| samples).sum();
    let is_without = moving_terms(session, fit).iter().any(|term| without_vane(evidence, term, &used));
    if fit.fit.is_err() || !is_without || samples > MOST_SAMPLES {
        return None;
    }
    let terms = session.structure.terms(fit.coefficient)?;
    let structure = Structure { models: vec![(fit.coefficient, terms.to_vec())] };
    let estimation = Estimation { weights: ResidualWeights::Equal, ..session.estimation.clone() };
    let windows = snapshot.aero(session);
    let regression = pooled_regressions(&windows, &structure, &estimation).pop()?.ok()?;
    let step_s = sample_step_s(&windows)?;
    let (found, covariance) = by_instruments(fit.coefficient, &regression.pooled, &structure, step_s).ok()?;
    let errors = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
    Some(Instrumental { names: found.names, estimates: found.estimates, errors })
}

impl Instrumental {
    /// That the derivative `index` of the pooled fit contradicts its estimate by instruments.
    pub(super) fn finding(&self, fit: &CoefficientFit, index: usize) -> Option<Finding> {
        let own = fit.fit.as_ref().ok()?;
        let name = own.names.get(index).filter(|name| !is_constant_name(name))?;
        let place = self.names.iter().position(|other| other == name)?;
        let (estimate, error) = (self.estimates[place], self.errors[place]);
        let (biased, own_error) = (own.estimates[index], *fit.corrected_errors.get(index)?);
        let apart = (estimate - biased).abs();
        if !(apart > BY_INSTRUMENTS * error && apart > OF_FIT * own_error) {
            return None;
        }
        let text = message!(
            "Least squares gives {}, instrumental variables {}: gusts, or a missing term.",
            with_error(biased, own_error),
            with_error(estimate, error)
        );
        let finding = Finding::new(Level::Caution, GUST_BIAS, Place::derivative(name, None), text);
        let finding = finding.with_figure(apart / error, BY_INSTRUMENTS);
        Some(
            finding
                .with_fix_text("Compare with a flight in still air, or with a recorded flow angle.")
                .with_setting("Derivatives", ""),
        )
    }
}
