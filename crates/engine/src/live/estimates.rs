//! Equation error by recursion, in the frequency domain and in time, of all coefficients of a structure.

use std::collections::BTreeSet;

use doublet_core::estimate::{EstimateError, Fit, RecursiveEstimate, RecursiveFourier, RecursiveLeastSquares, Taper};
use doublet_core::model::{Coefficient, Term, Variable, regressors};

use super::settings::LiveSettings;
use super::update::{CorrelationLamp, LiveDerivative, TimeDomain};
use crate::session::{Level, Surface};
use crate::stage::{CONDITION_LIMIT, WindowAero};

/// Part of a coefficient's variation that a fit explains at least where it is good.
const LEAST_R2: f64 = 0.5;
/// Part of a derivative by a control that its error is at most where a manoeuvre has moved the control.
const CONTROL_ERROR: f64 = 0.5;
/// Periods of the lowest frequency that a good estimate is made of at least.
const PERIODS: f64 = 2.0;
/// Joint standard errors within which, or part of the estimate by which, frequency and time domain agree.
const AGREE: f64 = 3.0;
const AGREE_PART: f64 = 0.05;

/// Lags of the correlation of residuals in time, s, and their most samples.
const LAGS_S: f64 = 2.0;
const MOST_LAGS: usize = 128;
/// Largest magnitude of the coefficient of normal force that a wing in flight has: more says that wheels carry the aircraft.
const MOST_CZ: f64 = 2.5;
/// Correlation of two regressors above which their derivatives mix, and above which they are one.
const MIXED: f64 = 0.6;
const COLLINEAR: f64 = 0.9;

/// The recursions of one structure over samples on an even grid.
pub struct LiveEstimates {
    models: Vec<Model>,
    /// Regressors of all models but the constant, each once, behind the coefficients in the columns of the transforms.
    terms: Vec<Term>,
    fourier: RecursiveFourier,
    /// Index on the grid of the next sample.
    next: u64,
    /// Samples of flight taken in, and the time between two, s.
    taken: u64,
    step_s: f64,
    /// What the structure asks for that the stream does not have.
    pub findings: Vec<String>,
}

/// One coefficient.
struct Model {
    coefficient: Coefficient,
    /// Its terms in `terms`, without the constant.
    terms: Vec<usize>,
    /// Names of their derivatives.
    names: Vec<String>,
    /// Whether the stream gives all terms the structure asks for.
    is_complete: bool,
    time: RecursiveLeastSquares,
}

impl LiveEstimates {
    /// For the variables there are, on a grid of `step_s` whose first sample has the index `first`.
    ///
    /// # Errors
    /// Frequencies beyond half that of the samples, and a forgetting time that is none.
    pub fn new(
        settings: &LiveSettings,
        known: &BTreeSet<Variable>,
        step_s: f64,
        first: u64,
    ) -> Result<Self, EstimateError> {
        let forgetting = settings.forgetting_s.map(|time_s| time_s / step_s);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 128")]
        let lags = (LAGS_S / step_s).min(MOST_LAGS as f64) as usize;
        let (mut terms, mut models, mut findings) = (Vec::<Term>::new(), Vec::new(), Vec::new());
        for (coefficient, own) in &settings.structure.models {
            let has = |term: &&Term| term.factors().iter().all(|(variable, _)| known.contains(variable));
            let (usable, left_out): (Vec<&Term>, Vec<&Term>) = own.iter().partition(has);
            findings.extend(left_out.iter().map(|term| {
                format!("{} is not estimated: no channel gives '{term}'", term.derivative_name(*coefficient))
            }));
            let usable: Vec<&Term> = usable.into_iter().filter(|term| !term.is_constant()).collect();
            if usable.is_empty() {
                continue;
            }
            let mut place = |term: &Term| {
                let known = terms.iter().position(|other| other == term);
                known.unwrap_or_else(|| {
                    terms.push(term.clone());
                    terms.len() - 1
                })
            };
            let names: Vec<String> = usable.iter().map(|term| term.derivative_name(*coefficient)).collect();
            let with_constant: Vec<String> =
                std::iter::once(Term::constant().derivative_name(*coefficient)).chain(names.iter().cloned()).collect();
            models.push(Model {
                coefficient: *coefficient,
                terms: usable.into_iter().map(&mut place).collect(),
                names,
                is_complete: left_out.is_empty(),
                time: RecursiveLeastSquares::new(&with_constant, forgetting, lags, Taper::Parzen)?,
            });
        }
        let columns = models.len() + terms.len();
        let fourier = RecursiveFourier::new(columns, step_s, &settings.band, settings.forgetting_s)?;
        Ok(Self { models, terms, fourier, next: first, taken: 0, step_s, findings })
    }

    /// Takes in, where the aircraft flies, the samples of `aero` whose index on the grid, `index(time)`, is not passed yet, up to before `end`.
    pub fn take(
        &mut self,
        aero: &WindowAero,
        index: impl Fn(f64) -> u64,
        end: u64,
        is_airborne: bool,
    ) -> Result<(), String> {
        let x = regressors(&self.terms, &aero.variables).map_err(|error| error.to_string())?;
        let normal_force = aero.coefficients.get(Coefficient::CZ);
        for (row, time_s) in aero.coefficients.time_s.iter().enumerate() {
            let at = index(*time_s);
            if at < self.next || at >= end {
                continue;
            }
            self.skip_to(at);
            if !is_airborne || normal_force[row].abs() >= MOST_CZ {
                continue;
            }
            let measured: Vec<f64> =
                self.models.iter().map(|model| aero.coefficients.get(model.coefficient)[row]).collect();
            let values: Vec<f64> = measured.iter().copied().chain(x.row(row).iter().copied()).collect();
            self.fourier.push(&values);
            for (model, measured) in self.models.iter_mut().zip(&measured) {
                let own: Vec<f64> =
                    std::iter::once(1.0).chain(model.terms.iter().map(|term| x[(row, *term)])).collect();
                model.time.push(&own, *measured);
            }
            self.next = at + 1;
            self.taken += 1;
        }
        self.skip_to(end);
        Ok(())
    }

    /// Lets time go on to the sample `index` without the samples before it.
    pub(crate) fn skip_to(&mut self, index: u64) {
        if index > self.next {
            self.fourier.skip(index - self.next);
            self.models.iter_mut().for_each(|model| model.time.interrupt());
            self.next = index;
        }
    }

    /// Derivatives as estimated so far.
    pub fn derivatives(&self, settings: &LiveSettings) -> Vec<LiveDerivative> {
        let first = self.models.len();
        let of_terms = |terms: &[usize]| terms.iter().map(|term| first + term).collect::<Vec<_>>();
        let columns: Vec<Vec<usize>> = self.models.iter().map(|model| of_terms(&model.terms)).collect();
        let asked: Vec<_> =
            self.models.iter().zip(&columns).enumerate().map(|(z, (model, x))| (&model.names[..], z, &x[..])).collect();
        let factor = self.fourier.covariance_factor();
        let is_long_enough = self.taken as f64 * self.step_s >= PERIODS / settings.band.lowest_hz;
        let mut found = Vec::new();
        for (z, (model, fit)) in self.models.iter().zip(self.fourier.fits(&asked)).enumerate() {
            let is_reduced = fit.is_err();
            let fit = fit.or_else(|error| self.without_dependent(&error, model, z)).ok();
            let time = model.time.estimate().ok();
            let both: Vec<Both> =
                model.names.iter().map(|name| Both::new(name, fit.as_ref(), factor, time.as_ref())).collect();
            // What terms left out would change, and what either domain alone explains, no error says.
            let is_ill = |fit: &Fit| fit.condition_number > CONDITION_LIMIT || fit.quality.r_squared < LEAST_R2;
            let is_whole = model.is_complete && !is_reduced && is_long_enough && !fit.as_ref().is_none_or(is_ill);
            let is_told = is_flown(&self.terms, model, &both) && both.iter().all(Both::agree);
            let level_at_best = match is_whole && is_told {
                true => Level::Good,
                false => Level::Caution,
            };
            found.extend(model.names.iter().zip(both).map(|(name, both)| {
                let goal_percent = settings.goal.percent(name);
                let standard_error = both.standard_error();
                let relative = both.frequency.zip(standard_error);
                let relative = relative.map(|((estimate, _), error)| 100.0 * (error / estimate).abs());
                let level = match relative {
                    Some(percent) if percent <= goal_percent => Level::Good,
                    Some(percent) if percent <= 2.0 * goal_percent => Level::Caution,
                    _ => Level::Bad,
                };
                LiveDerivative {
                    name: name.clone(),
                    estimate: both.frequency.map(|(estimate, _)| estimate),
                    standard_error,
                    relative_error_percent: relative.filter(|percent| percent.is_finite()),
                    goal_percent,
                    level: level.max(level_at_best),
                    time_domain: both.time,
                }
            }));
        }
        found
    }

    /// The fit without the regressors that depend on others, as those of a surface that rests.
    fn without_dependent(&self, error: &EstimateError, model: &Model, z: usize) -> Result<Fit, EstimateError> {
        let EstimateError::RankDeficient { dependent, .. } = error else { return Err(error.clone()) };
        let is_free = |name: &str| dependent.iter().all(|dependence| dependence.name != name);
        let kept = model.names.iter().zip(&model.terms).filter(|(name, _)| is_free(name));
        let (names, x): (Vec<String>, Vec<usize>) =
            kept.map(|(name, term)| (name.clone(), self.models.len() + term)).unzip();
        self.fourier.fit(&names, z, &x)
    }

    /// The two regressors of one coefficient that are most alike, of those without a variable in common.
    pub fn correlation(&self) -> Option<CorrelationLamp> {
        let all: Vec<usize> = (0..self.terms.len()).map(|term| self.models.len() + term).collect();
        let correlation = self.fourier.correlation(&all);
        let mut worst: Option<(f64, &Model, usize, usize)> = None;
        for model in &self.models {
            for (k, &i) in model.terms.iter().enumerate() {
                for &j in model.terms[..k].iter().filter(|j| !share_a_variable(&self.terms[i], &self.terms[**j])) {
                    let value = correlation[(i, j)];
                    if value.is_finite() && worst.is_none_or(|(other, ..)| value.abs() > other.abs()) {
                        worst = Some((value, model, j, i));
                    }
                }
            }
        }
        let (correlation, model, first, second) = worst?;
        let level = match correlation.abs() {
            value if value > COLLINEAR => Level::Bad,
            value if value > MIXED => Level::Caution,
            _ => Level::Good,
        };
        let regressors = [first, second].map(|term| self.terms[term].to_string());
        Some(CorrelationLamp { coefficient: model.coefficient.name().to_owned(), regressors, correlation, level })
    }
}

/// Whether a derivative by a control of a coefficient is determined, where it has one: else no manoeuvre has moved it yet.
fn is_flown(terms: &[Term], model: &Model, both: &[Both]) -> bool {
    let is_control = |term: &Term| {
        let of_surface = |(variable, _): &(Variable, i32)| Surface::ALL.iter().any(|one| one.variable() == *variable);
        term.factors().iter().any(of_surface)
    };
    let mut controls = model.terms.iter().zip(both).filter(|(term, _)| is_control(&terms[**term])).peekable();
    let is_determined = |both: &Both| {
        let known = both.frequency.zip(both.standard_error());
        known.is_some_and(|((estimate, _), error)| error < CONTROL_ERROR * estimate.abs())
    };
    controls.peek().is_none() || controls.any(|(_, both)| is_determined(both))
}

/// A derivative by the regression in the frequency domain, estimate and standard error, and by that in time.
struct Both {
    frequency: Option<(f64, f64)>,
    time: Option<TimeDomain>,
}

impl Both {
    fn new(name: &str, frequency: Option<&Fit>, factor: f64, time: Option<&RecursiveEstimate>) -> Self {
        let known = frequency.and_then(|fit| fit.parameter(name));
        let of_time = |time: &RecursiveEstimate| {
            let at = time.names.iter().position(|other| other == name)?;
            Some(TimeDomain { estimate: time.estimates[at], standard_error: time.corrected_standard_errors[at] })
        };
        Self {
            frequency: known.map(|(estimate, error)| (estimate, error * factor.sqrt())),
            time: time.and_then(of_time),
        }
    }

    /// Standard error with that of the other domain and what the two differ by: drifts and gusts enter them differently, and neither's
    /// residual says so.
    fn standard_error(&self) -> Option<f64> {
        let (estimate, error) = self.frequency?;
        Some(self.time.map_or(error, |time| error.hypot(time.standard_error).hypot(estimate - time.estimate)))
    }

    /// Whether the two agree within their errors, or nearly; so do those of which one is not known.
    fn agree(&self) -> bool {
        let Some(((estimate, error), time)) = self.frequency.zip(self.time) else { return true };
        let apart = (estimate - time.estimate).abs();
        apart <= AGREE * error.hypot(time.standard_error) || apart <= AGREE_PART * estimate.abs()
    }
}

/// Whether two terms have a variable in common, as a variable and its square have.
fn share_a_variable(one: &Term, other: &Term) -> bool {
    one.factors().iter().any(|(variable, _)| other.factors().iter().any(|(also, _)| also == variable))
}
