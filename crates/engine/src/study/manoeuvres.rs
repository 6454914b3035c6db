//! Manoeuvre against manoeuvre.

use std::sync::Arc;

use doublet_core::estimate::{ConditionFit, ConditionPoint, Fit, KindDifference, compare_kinds, condition_regression};
use doublet_core::model::{Coefficient, Term, Variable, regressors};
use doublet_core::series::Series;
use doublet_core::validate::{LeftOut, contributions, leave_one_out};

use super::StudyInput;
use crate::graph::{Context, Footprint, Stage, StageResult};
use crate::session::WindowRole;
use crate::stage::{self, CoefficientFit, StudyWindow};

/// The pooled estimate of one coefficient without each of its windows.
#[derive(Clone, Debug)]
pub struct CoefficientLeftOut {
    pub coefficient: Coefficient,
    /// Derivatives all windows share, in the order of the entries of each [`LeftOut`].
    pub derivatives: Vec<String>,
    /// One entry per window.
    pub windows: Vec<LeftOut>,
}

/// Derivatives from manoeuvres of two kinds of input (thesis Fig. 6.12).
#[derive(Clone, Debug)]
pub struct KindComparison {
    pub coefficient: Coefficient,
    /// Names of the two kinds.
    pub kinds: [String; 2],
    /// One entry per derivative both have.
    pub derivatives: Vec<KindDifference>,
}

/// What one term adds to a coefficient over a window.
#[derive(Clone, Debug)]
pub struct TermContribution {
    pub derivative: String,
    /// Root mean square about its mean over that of the observed coefficient.
    pub share: f64,
    /// Derivative times variable.
    pub series: Series,
}

/// What the terms add up to over one window (thesis Fig. 6.13).
#[derive(Clone, Debug)]
pub struct WindowContributions {
    pub window: String,
    pub coefficient: Coefficient,
    /// One entry per term, in the order of the structure.
    pub terms: Vec<TermContribution>,
}

/// A derivative as a linear function of the flight condition (thesis 2.3.4).
#[derive(Clone, Debug)]
pub struct ConditionRegression {
    pub derivative: String,
    /// Variables of the condition, `V` in m/s, `h` in m, `alpha` in rad.
    pub variables: Vec<&'static str>,
    /// Windows it was found over, with the derivative, its corrected error and the condition.
    pub points: Vec<(String, ConditionPoint)>,
    /// The regression, or one line why there is none.
    pub result: StageResult<ConditionFit>,
}

impl ConditionRegression {
    /// Ends of the line over the variable at `index`, between the smallest and the largest condition flown, the other variables at their
    /// means; none where there is no regression.
    pub fn line(&self, index: usize) -> Option<[[f64; 2]; 2]> {
        let found = self.result.as_ref().ok()?;
        let (mean, slope) = (found.mean.get(index)?, found.fit.estimates.get(index + 1)?);
        let value = found.fit.estimates.first()?;
        let flown = self.points.iter().filter_map(|(_, point)| point.condition.get(index).copied());
        let ends = flown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        Some(ends.map(|at| [at, value + slope * (at - mean)]))
    }
}

/// Manoeuvre against manoeuvre.
#[derive(Clone, Debug, Default)]
pub struct ManoeuvreStudy {
    /// Pooled estimates without each manoeuvre in turn.
    pub left_out: Vec<CoefficientLeftOut>,
    /// Kinds of input compared.
    pub kinds: Vec<KindComparison>,
    /// Contributions of terms by the pooled estimate.
    pub contributions: Vec<WindowContributions>,
    /// Derivatives over the flight condition.
    pub conditions: Vec<ConditionRegression>,
}

impl Footprint for ManoeuvreStudy {
    fn bytes(&self) -> usize {
        let samples = |window: &WindowContributions| -> usize {
            window.terms.iter().map(|term| 8 * term.series.values.len() + 128).sum()
        };
        self.contributions.iter().map(samples).sum::<usize>() + (1 << 16)
    }
}

/// Conditions derivatives are regressed on.
const CONDITIONS: [&[(&str, Variable)]; 2] = [
    &[("V", Variable::Airspeed), ("h", Variable::Altitude)],
    &[("V", Variable::Airspeed), ("h", Variable::Altitude), ("alpha", Variable::Alpha)],
];

/// Compares the manoeuvres of a session.
impl Stage for ManoeuvreStudy {
    type Params<'a> = ();
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "comparison of manoeuvres";

    fn run((): (), input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let context = context.parts(4);
        let done = || {
            context.step();
            context.checkpoint()
        };
        let left_out = leave_out(input, &context)?;
        done()?;
        let kinds = kinds(input);
        done()?;
        let contributions = term_contributions(input);
        done()?;
        let conditions = conditions(input);
        done()?;
        Ok(ManoeuvreStudy { left_out, kinds, contributions, conditions })
    }
}

fn leave_out(input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Vec<CoefficientLeftOut>> {
    let settings = input.settings;
    let mut found = Vec::new();
    for regression in stage::pooled_regressions(&input.aero(), settings.structure, settings.estimation) {
        context.checkpoint()?;
        let regression = regression?;
        let Ok(full) = regression.pooled.fit() else { continue };
        // Without one of its windows a derivative may have no estimate left: there is nothing to compare then.
        let Ok(windows) = leave_one_out(&regression.pooled, &full) else { continue };
        let derivatives = regression.pooled.shared().cloned().collect();
        found.push(CoefficientLeftOut { coefficient: regression.coefficient, derivatives, windows });
    }
    Ok(found)
}

/// The fit of one coefficient of a window alone.
fn own_fit<'s>(window: &'s StudyWindow<'_>, coefficient: Coefficient) -> Option<(&'s CoefficientFit, &'s Fit)> {
    let fit = window.fits.fits.iter().find(|fit| fit.coefficient == coefficient)?;
    Some((fit, fit.fit.as_ref().ok()?))
}

fn kinds(input: &StudyInput<'_>) -> Vec<KindComparison> {
    let mut names: Vec<&str> = Vec::new();
    for window in input.windows {
        let kind = window.manoeuvre.kind.as_str();
        if !kind.is_empty() && !names.contains(&kind) {
            names.push(kind);
        }
    }
    let mut found = Vec::new();
    for (coefficient, _) in &input.settings.structure.models {
        let of_kind = |kind: &str| -> Vec<&Fit> {
            let windows = input.windows.iter().filter(|window| window.manoeuvre.kind == kind);
            windows.filter_map(|window| Some(own_fit(window, *coefficient)?.1)).collect()
        };
        for (index, first) in names.iter().enumerate() {
            for second in &names[index + 1..] {
                let derivatives = compare_kinds(&of_kind(first), &of_kind(second));
                if !derivatives.is_empty() {
                    let kinds = [(*first).to_owned(), (*second).to_owned()];
                    found.push(KindComparison { coefficient: *coefficient, kinds, derivatives });
                }
            }
        }
    }
    found
}

fn term_contributions(input: &StudyInput<'_>) -> Vec<WindowContributions> {
    let mut found = Vec::new();
    for window in input.windows {
        for (coefficient, terms) in &input.settings.structure.models {
            if own_fit(window, *coefficient).is_some()
                && let Some(terms) = window_contributions(input, window, *coefficient, terms)
            {
                let window = window.manoeuvre.name.clone();
                found.push(WindowContributions { window, coefficient: *coefficient, terms });
            }
        }
    }
    found
}

/// Contributions of the terms of one coefficient by the pooled estimate; `None` without one.
fn window_contributions(
    input: &StudyInput<'_>,
    window: &StudyWindow<'_>,
    coefficient: Coefficient,
    terms: &[Term],
) -> Option<Vec<TermContribution>> {
    let pooled = input.pooled.fits.iter().find(|fit| fit.coefficient == coefficient)?.fit.as_ref().ok()?;
    let names: Vec<String> = terms.iter().map(|term| term.derivative_name(coefficient)).collect();
    let estimate = |name: &String| {
        let own = format!("{name}[{}]", window.manoeuvre.name);
        pooled.parameter(name).or_else(|| pooled.parameter(&own)).map_or(0.0, |(estimate, _)| estimate)
    };
    let estimates: Vec<f64> = names.iter().map(estimate).collect();
    let x = regressors(terms, &window.aero.variables).ok()?;
    let observed = &window.aero.series[coefficient as usize];
    let found = contributions(&estimates, &x, &observed.values);
    let term = |(derivative, contribution): (String, doublet_core::validate::Contribution)| TermContribution {
        derivative,
        share: contribution.share,
        series: Series { time_s: Arc::clone(&observed.time_s), values: contribution.values.into() },
    };
    Some(names.into_iter().zip(found).map(term).collect())
}

fn conditions(input: &StudyInput<'_>) -> Vec<ConditionRegression> {
    let mut found = Vec::new();
    for (coefficient, terms) in &input.settings.structure.models {
        for name in terms.iter().filter(|term| !term.is_constant()).map(|term| term.derivative_name(*coefficient)) {
            for variables in CONDITIONS {
                let points: Vec<_> = input
                    .windows
                    .iter()
                    .filter(|window| window.manoeuvre.role == WindowRole::Identification)
                    .filter_map(|window| condition_point(window, *coefficient, &name, variables))
                    .collect();
                if points.is_empty() {
                    continue;
                }
                let values: Vec<_> = points.iter().map(|(_, point)| point.clone()).collect();
                let labels: Vec<&'static str> = variables.iter().map(|(label, _)| *label).collect();
                found.push(ConditionRegression {
                    derivative: name.clone(),
                    result: condition_regression(&labels, &values).map_err(Into::into),
                    variables: labels,
                    points,
                });
            }
        }
    }
    found
}

/// A derivative from one window and its flight condition.
fn condition_point(
    window: &StudyWindow<'_>,
    coefficient: Coefficient,
    derivative: &str,
    variables: &[(&str, Variable)],
) -> Option<(String, ConditionPoint)> {
    let (fit, estimate) = own_fit(window, coefficient)?;
    let index = estimate.names.iter().position(|name| name == derivative)?;
    estimate.origins[index].is_estimated().then_some(())?;
    let samples = stage::condition_samples(&window.aero);
    let mean = |variable: Variable| {
        stage::mean_of_finite(window.aero.variables.get(variable)?.get(samples.clone())?.iter().copied())
    };
    let condition = variables.iter().map(|(_, variable)| mean(*variable)).collect::<Option<Vec<_>>>()?;
    let point = ConditionPoint {
        estimate: estimate.estimates[index],
        standard_error: *fit.corrected_errors.get(index)?,
        condition,
    };
    Some((window.manoeuvre.name.clone(), point))
}
