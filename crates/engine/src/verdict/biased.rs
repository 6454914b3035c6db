//! Fits all of whose manoeuvres have sensors that are saturated or stuck: no other manoeuvre shows what that changes.

use doublet_core::message;
use doublet_core::model::{Coefficient, Term, Variable};
use doublet_core::quantity::Role;

use super::judge::Evidence;
use super::{Finding, Level, saturated, stuck};
use crate::session::{Manoeuvre, Place};
use crate::snapshot::Cause;
use crate::stage::CoefficientFit;

/// The channels of a manoeuvre that are saturated, and those that are stuck.
fn faults(evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> (Vec<Role>, Vec<Role>) {
    let saturated = saturated::rests(evidence.snapshot, manoeuvre).into_iter().map(|rest| rest.input.role()).collect();
    let stuck = stuck::standstills(evidence.snapshot, manoeuvre).into_iter().map(|still| still.role).collect();
    (saturated, stuck)
}

/// That every manoeuvre of a pooled fit has a saturated or a stuck channel: bad where a stuck one is what the coefficient is made of, or a
/// saturated one without whose samples there is no fit. With such a fit it is known what they change.
pub(super) fn finding(evidence: Evidence<'_>, fit: &CoefficientFit) -> Option<Finding> {
    let terms = evidence.session.structure.terms(fit.coefficient).unwrap_or_default();
    let mut names: Vec<&str> = Vec::new();
    let mut level = Level::Caution;
    for (window, _) in &fit.windows {
        let (saturated, stuck) = faults(evidence, evidence.session.window(window)?);
        if saturated.is_empty() && stuck.is_empty() {
            return None;
        }
        if stuck.iter().any(|role| enters(*role, fit.coefficient, terms)) {
            level = Level::Bad;
        }
        names.extend(saturated.iter().chain(&stuck).map(|role| role.name()));
    }
    names.sort_unstable();
    names.dedup();
    if names.is_empty() {
        return None;
    }
    if !evidence.consequences.is_empty() && !is_known(evidence, fit) && !saturated_of(evidence, fit).is_empty() {
        level = Level::Bad;
    }
    let text = message!("All its manoeuvres have saturated or stuck channels: {}.", names.join(", "));
    let finding = Finding::new(level, "windows", Place::derivative(fit.coefficient.name(), None), text);
    let fix_text = "Fly again with smaller inputs or wider-range sensors.";
    Some(finding.with_fix_text(fix_text).with_setting("Manoeuvres", "manoeuvre.role"))
}

/// Whether the fit without the spoilt samples was formed.
fn is_known(evidence: Evidence<'_>, fit: &CoefficientFit) -> bool {
    let all = evidence.consequences.iter().filter(|one| one.coefficient == fit.coefficient);
    let mut effects = all.flat_map(|one| &one.derivatives).flat_map(|(_, consequence)| &consequence.effects);
    effects.any(|effect| effect.cause == Cause::SpoiltLeftOut)
}

/// The saturated channels that a coefficient is made of, in the manoeuvres of its fit.
pub(super) fn saturated_of(evidence: Evidence<'_>, fit: &CoefficientFit) -> Vec<Role> {
    let terms = evidence.session.structure.terms(fit.coefficient).unwrap_or_default();
    let windows = fit.windows.iter().filter_map(|(window, _)| evidence.session.window(window));
    let roles = windows.flat_map(|window| saturated::rests(evidence.snapshot, window)).map(|rest| rest.input.role());
    let mut roles: Vec<Role> = roles.filter(|role| enters(*role, fit.coefficient, terms)).collect();
    roles.sort_unstable();
    roles.dedup();
    roles
}

/// Whether a coefficient is made of a channel: it is the force or the motion itself, or a variable of the model.
fn enters(role: Role, coefficient: Coefficient, terms: &[Term]) -> bool {
    use Coefficient::*;
    let (of, variables): (&[Coefficient], &[Variable]) = match role {
        Role::RollRate => (&[Cl], &[Variable::RollRate]),
        Role::PitchRate => (&[Cm], &[Variable::PitchRate, Variable::HalfPitchRate]),
        Role::YawRate => (&[Cn], &[Variable::YawRate]),
        Role::SpecificForceX => (&[CX, CD, CL], &[]),
        Role::SpecificForceY => (&[CY], &[]),
        Role::SpecificForceZ => (&[CZ, CL, CD], &[]),
        Role::AngleOfAttack => (&[], &[Variable::Alpha]),
        Role::Sideslip => (&[], &[Variable::Beta]),
        _ => (&[], &[]),
    };
    let contains = |term: &Term| term.factors().iter().any(|(variable, _)| variables.contains(variable));
    of.contains(&coefficient) || terms.iter().any(contains)
}
