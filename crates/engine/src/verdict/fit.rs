//! Findings about the fit of one coefficient: excitation, condition and what it predicts.

use doublet_core::estimate::Fit;
use doublet_core::message::{Message, quoted};
use doublet_core::model::{Coefficient, Term, Variable, is_constant_name, regressors};
use doublet_core::reconstruct::{Input, Measurement, State};
use doublet_core::series::TimeRange;
use doublet_core::{message, statistics};
use nalgebra::DMatrix;

use super::derivative::is_determined;
use super::judge::Evidence;
use super::{Finding, Level, delay, propulsion, remedies, vane};
use crate::session::{Fix, Manoeuvre, Place, Session, Surface, WindowRole};
use crate::snapshot::Snapshot;
use crate::stage::{CONDITION_LIMIT, CoefficientFit, Prediction, WindowAero};

/// How many times its noise a regressor must vary.
const EXCITATION: f64 = 3.0;
/// Variance inflation factor (Klein and Morelli 5.5).
const INFLATION: f64 = 10.0;
/// Coefficient of determination of a prediction.
const R2_CAUTION: f64 = 0.8;
const R2_BAD: f64 = 0.5;
/// Variation of a coefficient over the residual of the window's own fit, from which a failed prediction is bad: below, the manoeuvre
/// hardly tells of the coefficient.
const VARIES: f64 = 10.0;
/// Coefficient of determination of the fit itself.
const R2_FIT: f64 = 0.5;

/// A window of a fit with what it is made from.
pub(super) struct Used<'a> {
    pub(super) manoeuvre: &'a Manoeuvre,
    pub(super) aero: &'a WindowAero,
}

/// Variables of the model that a window of the fit does not have.
fn absent(evidence: Evidence<'_>, fit: &CoefficientFit) -> Vec<&'static str> {
    let formed: Vec<&WindowAero> = fit
        .windows
        .iter()
        .filter_map(|(name, _)| evidence.snapshot.windows.get(name)?.aero.ready().map(AsRef::as_ref))
        .collect();
    let terms = evidence.session.structure.terms(fit.coefficient).unwrap_or_default();
    let mut absent = Vec::new();
    for (variable, _) in terms.iter().flat_map(Term::factors) {
        if !absent.contains(&variable.name()) && formed.iter().any(|aero| aero.variables.get(*variable).is_none()) {
            absent.push(variable.name());
        }
    }
    absent
}

/// Leaves out the terms of a coefficient that contain variables; none where the model would have no other term.
fn without_terms(evidence: Evidence<'_>, coefficient: Coefficient, variables: &[&str]) -> Option<Fix> {
    let terms = evidence.session.structure.terms(coefficient)?;
    let contains = |term: &&Term| term.factors().iter().any(|(variable, _)| variables.contains(&variable.name()));
    let fixes: Vec<Fix> = terms.iter().filter(contains).map(|term| Fix::set_term(coefficient, term, false)).collect();
    let is_rest = terms.iter().any(|term| !term.is_constant() && !contains(&term));
    let label = format!("remove the terms of {} from {}", variables.join(", "), coefficient.name());
    is_rest.then(|| Fix { label, edits: fixes.into_iter().flat_map(|fix| fix.edits).collect() })
}

/// What speaks against a fit; `window` is none for the pooled one.
pub(super) fn findings(evidence: Evidence<'_>, window: Option<&str>, fit: &CoefficientFit) -> Vec<Finding> {
    let name = fit.coefficient.name();
    let at = Place::derivative(name, window);
    let without_all = || remedies::without_coefficient(evidence.session, fit.coefficient).filter(|_| window.is_none());
    let estimate = match &fit.fit {
        Ok(estimate) => estimate,
        Err(error) => {
            let absent = absent(evidence, fit);
            if !absent.is_empty() {
                let text =
                    message!("No estimate: the model has terms of {}, which the recording lacks.", absent.join(", "));
                let finding = Finding::new(Level::Bad, "failed", at, text);
                let fix_text = "Add a recording with that channel, or remove its terms.";
                let finding = finding.with_fix_text(fix_text).with_setting("Channels", format!("model.{name}"));
                return vec![finding.with_fix(without_terms(evidence, fit.coefficient, &absent))];
            }
            let finding = Finding::new(Level::Bad, "rank", at, message!("No estimate: {}.", error.to_string()));
            let fix_text = "Remove a term, or add manoeuvres that separate the regressors.";
            let finding = finding.with_fix_text(fix_text).with_setting("Model", format!("model.{name}"));
            let dependent = remedies::without_dependent(evidence.session, fit.coefficient, error);
            return vec![finding.with_fix(dependent.or_else(without_all))];
        }
    };
    let used = used_windows(evidence.session, evidence.snapshot, fit);
    let terms = moving_terms(evidence.session, fit);
    let mut findings = Vec::new();
    if terms.is_empty() {
        let text = "Not excited: only the constant can be estimated.";
        let finding = Finding::new(Level::Bad, "excitation", &at, text);
        let finding = finding.with_fix_text("Use a manoeuvre that excites the other terms.");
        findings.push(finding.with_setting("Flight", "manoeuvre").with_fix(without_all()));
    }
    let formed: Vec<&WindowAero> = used.iter().map(|used| used.aero).collect();
    let moved: Vec<(&Term, Motion)> =
        terms.iter().filter_map(|term| Some((term, Motion::measure(term, &used)?))).collect();
    findings.extend(propulsion::unknown(&at, evidence, fit, &formed));
    findings.extend(unmoved(evidence, (fit.coefficient, &at), &moved, &used));
    let inflation = most_inflated(fit, estimate, &moved);
    let most = inflation.as_ref();
    let fix = most.and_then(|(name, _)| remedies::without_term(evidence.session, fit.coefficient, name));
    let is_any_open = estimate.names.iter().any(|name| is_open(fit, estimate, name));
    let condition = condition(&at, name, estimate).filter(|_| is_any_open);
    let inflated = most.and_then(|most| inflated(&at, fit.coefficient, estimate, most));
    findings.extend(condition.into_iter().chain(inflated).map(|finding| finding.with_fix(fix.clone())));
    if window.is_none() {
        findings.extend(prediction(evidence, &at, fit));
        findings.extend(delay::findings(evidence, fit.coefficient, &terms, &used));
        findings.extend(delay::find_late_inertial(evidence, fit.coefficient));
        findings.extend(vane::findings(evidence, &at, &terms));
    }
    if estimate.quality.r_squared < R2_FIT {
        let r2 = estimate.quality.r_squared;
        let text = message!(
            "The fit explains {:.0} % of the variation of the coefficient (limit {:.0} %).",
            100.0 * r2,
            100.0 * R2_FIT
        );
        let finding = Finding::new(Level::Caution, "r2", &at, text).with_figure(r2, R2_FIT);
        let fix_text = "Check the residuals for a missing term or an outlying manoeuvre.";
        findings.push(finding.with_fix_text(fix_text).with_setting("Model", format!("model.{name}")));
    }
    findings
}

/// The windows of a fit that have coefficients.
pub(super) fn used_windows<'a>(session: &'a Session, snapshot: &'a Snapshot, fit: &CoefficientFit) -> Vec<Used<'a>> {
    let one = |(name, _): &(String, _)| {
        let aero = snapshot.windows.get(name)?.aero.ready()?;
        Some(Used { manoeuvre: session.window(name)?, aero })
    };
    fit.windows.iter().filter_map(one).collect()
}

/// The terms of a fit that have an estimate, without the constant.
pub(super) fn moving_terms(session: &Session, fit: &CoefficientFit) -> Vec<Term> {
    let names = fit.fit.as_ref().map(|estimate| estimate.names.as_slice()).unwrap_or_default();
    let terms = session.structure.terms(fit.coefficient).unwrap_or_default().iter();
    let has_estimate = |term: &&Term| !term.is_constant() && names.contains(&term.derivative_name(fit.coefficient));
    terms.filter(has_estimate).cloned().collect()
}

/// Motion of a regressor about its mean in each window.
struct Motion {
    /// Sum of squares over all samples.
    square: f64,
    samples: usize,
}

impl Motion {
    fn measure(term: &Term, used: &[Used<'_>]) -> Option<Self> {
        let (mut square, mut samples) = (0.0, 0);
        for Used { aero, .. } in used {
            let column: DMatrix<f64> = regressors(std::slice::from_ref(term), &aero.variables).ok()?;
            let mean = column.mean();
            column.iter().for_each(|value| square += (value - mean) * (value - mean));
            samples += column.len();
        }
        Some(Self { square, samples })
    }

    /// Root mean square over all samples.
    fn variation(&self) -> f64 {
        (self.square / self.samples.max(1) as f64).sqrt()
    }
}

/// Flow angles and what measures them.
const VANES: [(Variable, Measurement); 2] =
    [(Variable::Alpha, Measurement::AngleOfAttack), (Variable::Beta, Measurement::Sideslip)];

/// The flow angle that a term consists of, where no manoeuvre of the fit has a vane for it.
pub(super) fn without_vane(evidence: Evidence<'_>, term: &Term, used: &[Used<'_>]) -> bool {
    let [(variable, 1)] = *term.factors() else { return false };
    let Some((_, vane)) = VANES.into_iter().find(|(angle, _)| *angle == variable) else { return false };
    let path = |used: &Used<'_>| evidence.snapshot.windows.get(&used.manoeuvre.name)?.path.ready();
    used.iter().all(|used| path(used).is_some_and(|path| path.missing.contains(&vane)))
}

/// Regressors of a single variable that move no more than what is unknown of them.
fn unmoved(
    evidence: Evidence<'_>,
    (coefficient, at): (Coefficient, &Place),
    moved: &[(&Term, Motion)],
    used: &[Used<'_>],
) -> Option<Finding> {
    let excitation = |(term, motion): &(&Term, Motion)| {
        let [(variable, 1)] = *term.factors() else { return None };
        let noises: Vec<f64> = used.iter().filter_map(|window| noise(evidence, window, variable)).collect();
        let square = noises.iter().map(|noise| noise * noise).sum::<f64>() / noises.len() as f64;
        (square > 0.0).then(|| (term.to_string(), motion.variation() / square.sqrt()))
    };
    let weak: Vec<(String, f64)> =
        moved.iter().filter_map(excitation).filter(|(_, times)| *times < EXCITATION).collect();
    let least = weak.iter().map(|(_, times)| *times).reduce(f64::min)?;
    let names: Vec<&str> = weak.iter().map(|(name, _)| name.as_str()).collect();
    let of_name = |name: &str| moved.iter().map(|(term, _)| *term).find(|term| term.to_string() == name);
    if let Some((name, times)) =
        weak.iter().find(|(name, _)| of_name(name).is_some_and(|term| without_vane(evidence, term, used)))
    {
        return Some(vane::missing(at, name, (*times, EXCITATION)));
    }
    let text = message!(
        "{} {} barely excited: {:.1} times the noise (limit {}).",
        names.join(", "),
        if names.len() == 1 { "is" } else { "are" },
        least,
        EXCITATION
    );
    let finding = Finding::new(Level::Caution, "excitation", at, text).with_figure(least, EXCITATION);
    let fix = of_name(&weak[0].0).map(|term| Fix::set_term(coefficient, term, false));
    let finding = finding.with_fix_text("Remove the term, or use a manoeuvre that excites it.");
    Some(finding.with_setting("Model", "model").with_fix(fix))
}

/// What is unknown of a variable in a window, in its own unit: the noise of a recorded deflection, the deviation of a flow angle, the
/// noise the filter is told of a rate. None where nothing is known of it.
fn noise(evidence: Evidence<'_>, used: &Used<'_>, variable: Variable) -> Option<f64> {
    let aero = used.aero;
    let speed = aero.data.airspeed_m_s.iter().sum::<f64>() / aero.data.airspeed_m_s.len() as f64;
    let reference = &aero.settings.reference;
    let rate = |input: Input, factor: f64| Some(evidence.session.filter.process_noise[input as usize] * factor);
    let flow = |state: State| {
        let run = &evidence.snapshot.windows.get(&used.manoeuvre.name)?.path.ready()?.reconstruction;
        let deviations = run.smoothed.as_ref().map_or(&run.deviations, |smoothed| &smoothed.deviations);
        Some(deviations[state as usize].get(run.time_s.len() / 2)? / speed)
    };
    match variable {
        Variable::Alpha => flow(State::VelocityW),
        Variable::Beta => flow(State::VelocityV),
        Variable::RollRate => rate(Input::RollRate, reference.lateral_rate_length_m / speed),
        Variable::PitchRate => rate(Input::PitchRate, reference.pitch_rate_length_m / speed),
        Variable::HalfPitchRate => rate(Input::PitchRate, reference.chord_m / (2.0 * speed)),
        Variable::YawRate => rate(Input::YawRate, reference.lateral_rate_length_m / speed),
        Variable::Aileron | Variable::Elevator | Variable::Rudder => {
            let surface = Surface::ALL.into_iter().find(|surface| surface.variable() == variable)?;
            let flight = evidence.snapshot.flights.get(&used.manoeuvre.flight)?.ready()?;
            recorded_noise(&flight.recording.role(surface.role())?.series, used.manoeuvre.window)
        }
        _ => None,
    }
}

/// White noise of a recorded signal from its second differences, whose variance is six times the noise's where the signal is smooth
/// against its own rate; the median keeps the edges of a doublet out.
fn recorded_noise(series: &doublet_core::series::Series, window: TimeRange) -> Option<f64> {
    /// Median of the absolute value of a normal variable of unit deviation.
    const MEDIAN_OF_NORMAL: f64 = 0.674_489_75;
    let values = &series.values[window.indices(&series.time_s)];
    let mut differences: Vec<f64> = values.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).abs()).collect();
    differences.retain(|difference| difference.is_finite());
    let median = statistics::median(&mut differences)?;
    Some(median / MEDIAN_OF_NORMAL / 6.0_f64.sqrt())
}

fn condition(at: &Place, name: &str, estimate: &Fit) -> Option<Finding> {
    let found = estimate.condition_number;
    if found <= CONDITION_LIMIT {
        return None;
    }
    let text =
        message!("Regressors are nearly collinear: condition number {:.0} (limit {:.0}).", found, CONDITION_LIMIT);
    let finding = Finding::new(Level::Caution, "condition", at, text).with_figure(found, CONDITION_LIMIT);
    Some(
        finding
            .with_fix_text("Remove a term, or add manoeuvres that separate them.")
            .with_setting("Model", format!("model.{name}")),
    )
}

/// The derivative whose variance the other regressors inflate most, and its inflation: `(X'X)^-1_jj` times the sum of squares of its
/// regressor about the constants of the fit.
fn most_inflated(fit: &CoefficientFit, estimate: &Fit, moved: &[(&Term, Motion)]) -> Option<(String, f64)> {
    let factor = |(term, motion): &(&Term, Motion)| {
        let name = term.derivative_name(fit.coefficient);
        let index = estimate.names.iter().position(|other| *other == name)?;
        Some((name, estimate.unit_covariance[(index, index)] * motion.square))
    };
    // What its error holds and leaves determined is no fault.
    let open = moved.iter().filter_map(factor).filter(|(name, _)| is_open(fit, estimate, name));
    open.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// That a derivative is nearly collinear with another, by its variance inflation.
fn inflated(at: &Place, coefficient: Coefficient, estimate: &Fit, (name, factor): &(String, f64)) -> Option<Finding> {
    if *factor <= INFLATION {
        return None;
    }
    let partner = partner(estimate, name);
    let text = message!(
        "{} is nearly collinear with {}: variance inflation {:.0} (limit {:.0}).",
        name,
        partner,
        *factor,
        INFLATION
    );
    let finding = Finding::new(Level::Caution, "vif", at, text).with_figure(*factor, INFLATION);
    let fix_text = "Remove one of the two, or add manoeuvres that separate them.";
    Some(finding.with_fix_text(fix_text).with_setting("Correlation", format!("model.{}", coefficient.name())))
}

/// Whether `name` is a derivative that the samples leave undetermined.
fn is_open(fit: &CoefficientFit, estimate: &Fit, name: &str) -> bool {
    let index = estimate.names.iter().position(|other| other == name);
    !is_constant_name(name) && index.is_some_and(|index| !is_determined(fit, index))
}

/// The derivative most correlated with `name`.
fn partner(estimate: &Fit, name: &str) -> String {
    let Some(index) = estimate.names.iter().position(|other| other == name) else { return String::new() };
    let others =
        (0..estimate.parameters()).filter(|&other| other != index && !is_constant_name(&estimate.names[other]));
    let largest = others
        .max_by(|&a, &b| estimate.correlation[(index, a)].abs().total_cmp(&estimate.correlation[(index, b)].abs()));
    largest.map(|other| estimate.names[other].clone()).unwrap_or_default()
}

/// The validation window predicted worst.
fn prediction(evidence: Evidence<'_>, at: &Place, fit: &CoefficientFit) -> Option<Finding> {
    let pooled = evidence.snapshot.pooled.ready()?;
    let of_fit = |prediction: &&Prediction| {
        prediction.coefficient == fit.coefficient && prediction.role == WindowRole::Validation
    };
    let judged = pooled.predictions.iter().filter(of_fit).filter_map(|prediction| {
        let r2 = prediction.quality_identified.r_squared;
        let variation = variation_over_residual(evidence, prediction);
        let level = match r2 {
            _ if r2 >= R2_CAUTION => return None,
            _ if r2 < R2_BAD && variation > VARIES => Level::Bad,
            _ => Level::Caution,
        };
        Some((level, r2, variation, prediction))
    });
    let (level, r2, variation, prediction) = judged.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)))?;
    let limit = if level == Level::Bad { R2_BAD } else { R2_CAUTION };
    let name = fit.coefficient.name();
    let why = if variation > VARIES {
        Message::default()
    } else {
        message!("; its variation is only {:.1} times the residual", variation)
    };
    let text = message!(
        "Prediction of {}, constant not refitted: R2 {:.2} (limit {}){}.",
        quoted(&prediction.window),
        r2,
        limit,
        why
    );
    let finding = Finding::new(level, "r2", at, text).with_figure(r2, limit);
    let fix_text = "Check the predictions, or add manoeuvres that excite the coefficient more.";
    Some(finding.with_fix_text(fix_text).with_setting("Fits and residuals", format!("model.{name}")))
}

/// Standard deviation of a coefficient in a window over the residual deviation of the window's own fit.
fn variation_over_residual(evidence: Evidence<'_>, prediction: &Prediction) -> f64 {
    let results = evidence.snapshot.windows.get(&prediction.window);
    let own = results.and_then(|results| results.fits.ready()).and_then(|fits| {
        let fit = fits.fits.iter().find(|fit| fit.coefficient == prediction.coefficient)?;
        fit.fit.as_ref().ok().map(|fit| fit.residual_std)
    });
    let observed = &prediction.observed.values;
    let count = observed.len() as f64;
    let mean = observed.iter().sum::<f64>() / count;
    let deviation = (observed.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / count).sqrt();
    deviation / own.unwrap_or(prediction.quality_own_constant.rms)
}
