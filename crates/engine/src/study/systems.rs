//! Verdicts on equivalent systems and on equations of motion fitted to a table.

use doublet_core::estimate::{EquationFault, EquationFit, FilterErrorFit, FitQuality};
use doublet_dynamics::frequency::{EquivalentSystem, FittedParameter, FrequencyError, Mismatch};

use crate::notation::{significant, system_parameter};
use crate::session::{Finding, Level, Verdict};

/// Cost of the mismatch (Tischler and Remple, chapter 11): up to the first the form is hardly told from the response, beyond the second it
/// does not fit.
const COST: [f64; 2] = [50.0, 100.0];
/// A richer form fits better where it leaves no more than this part of the cost.
const RICHER_LEFT: f64 = 0.5;
/// Difference of one quantity by two forms or methods, in joint standard errors, and part of it that it must be as well.
const APART: [f64; 2] = [2.0, 5.0];
const APART_PART: f64 = 0.1;
/// Coefficient of determination of an output.
const R2: [f64; 2] = [0.7, 0.0];

/// What a form is compared with.
pub(crate) struct Alternative<'a> {
    /// The fit by a form with two orders more.
    pub(crate) fit: &'a EquivalentSystem,
    pub(crate) mismatch: Mismatch,
    /// What follows from it.
    pub(crate) derived: &'a [FittedParameter],
}

/// Verdict on an equivalent system: its mismatch, what a richer form makes of the same quantities, and the other method.
pub(crate) fn judge_system(
    (fit, mismatch, derived): (&EquivalentSystem, &Mismatch, &[FittedParameter]),
    richer: Option<&Alternative<'_>>,
    other: Option<&Result<EquivalentSystem, FrequencyError>>,
) -> Verdict {
    let place = format!("form {}", fit.form);
    let mut findings = Vec::new();
    let level = match mismatch.cost {
        cost if cost <= COST[0] => Level::Good,
        cost if cost <= COST[1] => Level::Caution,
        _ => Level::Bad,
    };
    let text = format!("Form does not fit the response: cost {:.0} (limit {:.0}).", mismatch.cost, COST[0]);
    findings.push(
        finding(level, "form", &place, text, "Choose a form of higher order.").with_figure(mismatch.cost, COST[0]),
    );
    if let Some(richer) = richer.filter(|richer| richer.mismatch.cost < RICHER_LEFT * mismatch.cost) {
        for own in fit.parameters.iter().chain(derived) {
            let named = |one: &&FittedParameter| one.name == own.name;
            let with = richer.derived.iter().find(named);
            let Some((level, times)) = with.and_then(|with| apart(own, with)) else { continue };
            let text = format!(
                "{} is {:.4} by form {}, {:.4} by form {}: {times:.1} standard errors (limit {:.0}).",
                system_parameter(&own.name).0,
                own.value,
                fit.form,
                with.map_or(f64::NAN, |with| with.value),
                richer.fit.form,
                APART[0]
            );
            let fix = format!("Use form {}.", richer.fit.form);
            findings.push(finding(level, "form", &place, text, &fix).with_figure(times, APART[0]));
        }
    }
    // The response says nothing of a resonance that its windows do not resolve.
    let other = other.and_then(|other| other.as_ref().ok()).filter(|_| mismatch.unresolved == 0);
    for own in other.into_iter().flat_map(|other| &other.parameters) {
        let Some(first) = fit.parameter(&own.name) else { continue };
        let Some((level, times)) = apart(first, own) else { continue };
        let text = format!(
            "Methods disagree on {}: {:.4} and {:.4}, {times:.1} standard errors apart (limit {:.0}).",
            system_parameter(&own.name).0,
            first.value,
            own.value,
            APART[0]
        );
        let level = level.min(Level::Caution);
        findings
            .push(finding(level, "twin", &place, text, "Check the band and the form.").with_figure(times, APART[0]));
    }
    let undetermined = fit.parameters.iter().chain(derived).filter(|own| !own.is_determined());
    for own in undetermined {
        let (value, error) = (significant(own.value, 3), significant(own.standard_error, 3));
        let name = system_parameter(&own.name).0;
        let text = format!("Not determined: {name} {value} with standard error {error} (limit 100 %).");
        let fix = "Choose a form of lower order or a wider band.";
        let relative = own.standard_error / own.value;
        findings.push(finding(Level::Caution, "determined", &place, text, fix).with_figure(relative, 1.0));
    }
    if fit.is_delay_at_zero {
        let text = "Delay hit its lower bound 0: the data lead the model.".to_owned();
        findings.push(finding(Level::Caution, "delay-bound", &place, text, "Choose a form of higher order."));
    }
    Verdict::from_findings(findings)
}

/// Level and joint standard errors of the difference of one quantity by two fits; none where they agree.
fn apart(one: &FittedParameter, other: &FittedParameter) -> Option<(Level, f64)> {
    let difference = (one.value - other.value).abs();
    let times = difference / one.standard_error.hypot(other.standard_error);
    let level = match times {
        times if times > APART[1] => Level::Bad,
        times if times > APART[0] => Level::Caution,
        _ => return None,
    };
    (difference > APART_PART * one.value.abs()).then_some((level, times))
}

/// Gain in log-likelihood from which process noise counts as shown: the chance of it without any is below one in a million for four states.
const SHOWN: f64 = 20.0;

/// Whether noise drives the states more than output error allows for, so that the parameters of filter error are the ones to take.
pub(crate) fn is_driven_by_noise(
    output_error: &Result<EquationFit, EquationFault>,
    filter_error: &Result<FilterErrorFit, EquationFault>,
) -> bool {
    let Ok(filter) = filter_error else { return false };
    let cost = |found: &EquationFit| found.fit.cost.last().copied().unwrap_or(f64::INFINITY);
    let samples = filter.estimate.time_s.len() as f64;
    let gain =
        output_error.as_ref().map_or(f64::INFINITY, |output| 0.5 * samples * (cost(output) - cost(&filter.estimate)));
    gain > SHOWN && filter.process_noise.iter().any(|noise| !noise.is_none)
}

/// Verdict on parameters of equations of motion: what each method explains, and whether equation error agrees with the method that allows for
/// the noise there is.
pub(crate) fn judge_equations(
    equation_error: &Result<EquationFit, EquationFault>,
    output_error: &Result<EquationFit, EquationFault>,
    filter_error: &Result<FilterErrorFit, EquationFault>,
) -> Verdict {
    let mut findings = Vec::new();
    let driven = filter_error.as_ref().ok().filter(|_| is_driven_by_noise(output_error, filter_error));
    let (name, second) = match driven {
        Some(filter) => ("filter error", Ok(&filter.estimate)),
        None => ("output error", output_error.as_ref()),
    };
    if let Err(error) = second {
        let text = format!("Output error has no result: {error}");
        let fix = "Do not use equation error alone; check columns, signs and units.";
        findings.push(finding(Level::Bad, "failed", "output error", text, fix));
    }
    if let Err(error) = equation_error {
        let text = format!("Equation error has no result: {error}");
        findings.push(finding(Level::Caution, "failed", "equation error", text, "Check columns, signs and units."));
    }
    // The slopes that equation error explains hold the noise that drives the states.
    let explained =
        [("equation error", equation_error.as_ref().ok().filter(|_| driven.is_none())), (name, second.ok())];
    for (name, found) in explained.into_iter().filter_map(|(name, found)| Some((name, found?))) {
        findings.extend(judge_explained(name, found));
    }
    if let (Ok(first), Ok(second)) = (equation_error, second) {
        findings.extend(compare_methods(first, (name, second)));
    }
    Verdict::from_findings(findings)
}

/// Outputs of which a method explains too little.
fn judge_explained(name: &str, found: &EquationFit) -> Vec<Finding> {
    let outputs = found.compared.iter().zip(&found.fit.quality);
    outputs.filter_map(|(output, quality)| judge_output(name, output, quality)).collect()
}

fn judge_output(name: &str, output: &str, quality: &FitQuality) -> Option<Finding> {
    let level = match quality.r_squared {
        r2 if r2 >= R2[0] => return None,
        r2 if r2 >= R2[1] => Level::Caution,
        _ => Level::Bad,
    };
    let place = format!("{name}, {output}");
    let text = format!("R2 of {output} is {:.2} (limit {}).", quality.r_squared, R2[0]);
    let fix = "Check columns, signs and units, or add a term.";
    Some(finding(level, "r2", &place, text, fix).with_figure(quality.r_squared, R2[0]))
}

/// Parameters that differ between equation error and another method.
fn compare_methods(first: &EquationFit, (name, second): (&str, &EquationFit)) -> Vec<Finding> {
    let both = first.parameters.min(second.parameters);
    (0..both).filter_map(|index| compare_parameter(first, (name, second), index)).collect()
}

fn compare_parameter(first: &EquationFit, (name, second): (&str, &EquationFit), index: usize) -> Option<Finding> {
    let (first, second) = (parameter(first, index), parameter(second, index));
    let (level, times) = apart(&first, &second)?;
    let text = format!(
        "{} is {:.4} by equation error, {:.4} by {name}: {times:.1} standard errors (limit {:.0}).",
        first.name, first.value, second.value, APART[0]
    );
    let fix = "Check delays, noise of the states and the band.";
    Some(finding(level, "twin", &first.name, text, fix).with_figure(times, APART[0]))
}

fn parameter(found: &EquationFit, index: usize) -> FittedParameter {
    FittedParameter {
        name: found.fit.names[index].clone(),
        value: found.fit.estimates[index],
        standard_error: found.corrected_errors[index],
        low: f64::NAN,
        high: f64::NAN,
    }
}

fn finding(level: Level, code: &'static str, place: &str, text: String, fix: &str) -> Finding {
    Finding::new(level, code, place, text).with_fix_text(fix)
}
