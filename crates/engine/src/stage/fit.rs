//! Step 2: derivatives by least squares, of one window and of all identification windows together.

use std::sync::{Arc, OnceLock};

use doublet_core::estimate::{
    Coloured, Constraint, Fit, FitQuality, Origin, PooledFit, PooledRegression, PooledWindow,
};
use doublet_core::model::{Coefficient, Structure, Term, Variable, regressors};
use doublet_core::reconstruct::Measurement;
use doublet_core::series::{LONG_WINDOW, Series};
use doublet_core::statistics::{median, squares_about_mean};
use rayon::prelude::*;

use super::aero::WindowAero;
use super::path_errors::PathErrors;
use super::prediction::{Parameters, Prediction, predict};
use crate::graph::{Context, Footprint, Keyed, Stage, StageResult};
use crate::session::{Estimation, Manoeuvre, PooledConstants, ResidualWeights, Surface, WindowRole};

/// A term the structure has but a fit leaves out, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct DroppedTerm {
    /// Derivative it would have given.
    pub derivative: String,
    /// Reason, one line.
    pub reason: String,
}

/// Condition number of the scaled regressors above which they are nearly collinear.
pub const CONDITION_LIMIT: f64 = 100.0;

#[derive(Clone, Debug)]
pub struct CoefficientFit {
    pub coefficient: Coefficient,
    /// Windows whose samples it used, in the order they were stacked, with their number of samples.
    pub windows: Vec<(String, usize)>,
    /// Estimates and statistics, or one line that says why there are none.
    pub fit: StageResult<Fit>,
    /// Standard errors corrected for the correlation of the residuals in time (Morelli and Klein 1997), one per estimate; empty
    /// where there is no fit.
    pub corrected_errors: Vec<f64>,
    /// Standard errors corrected for the correlation inside windows alone, without the scatter between windows and the errors of the path.
    pub noise_errors: Vec<f64>,
    /// Residual and fitted coefficient over the window; none where there is no fit, and for several windows together.
    pub series: Option<FittedSeries>,
    /// Terms left out.
    pub dropped: Vec<DroppedTerm>,
}

/// A coefficient over the window it was fitted in.
#[derive(Clone, Debug)]
pub struct FittedSeries {
    pub observed: Series,
    /// Observed less fitted.
    pub residual: Series,
    /// Time between samples, s.
    pub step_s: f64,
    fitted: OnceLock<Series>,
}

impl FittedSeries {
    fn new(aero: &WindowAero, coefficient: Coefficient, residuals: &Arc<[f64]>) -> Self {
        let observed = aero.series[coefficient as usize].clone();
        let residual = Series { time_s: Arc::clone(&observed.time_s), values: Arc::clone(residuals) };
        let step_s = aero.covered_s() / (residuals.len().max(2) - 1) as f64;
        Self { observed, residual, step_s, fitted: OnceLock::new() }
    }

    /// Fitted coefficient, formed when it is first asked for.
    pub fn fitted(&self) -> &Series {
        self.fitted.get_or_init(|| {
            let pairs = self.observed.values.iter().zip(self.residual.values.iter());
            Series { time_s: Arc::clone(&self.observed.time_s), values: pairs.map(|(z, v)| z - v).collect() }
        })
    }
}

/// Derivatives from one window.
#[derive(Clone, Debug, Default)]
pub struct WindowFits {
    /// One fit per coefficient that applies to the window.
    pub fits: Vec<CoefficientFit>,
}

/// Derivatives from all identification manoeuvres together.
#[derive(Clone, Debug, Default)]
pub struct PooledFits {
    /// One fit per coefficient of the structure.
    pub fits: Vec<CoefficientFit>,
    /// Prediction of every window that is not ignored, by the parameters the session predicts with.
    pub predictions: Vec<Prediction>,
    /// Scale errors of the recorded flow angles; none where gusts explain the measurements better, and before the errors of the path are
    /// formed.
    pub vane_scales: Vec<VaneScale>,
    /// What the errors of path and sensors are, once they were added to the corrected errors.
    pub path_errors: Option<Arc<PathErrors>>,
}

/// Scale error of a recorded flow angle over all manoeuvres: its scale is `1 + value` of the reconstructed path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VaneScale {
    /// Angle of attack or sideslip.
    pub measurement: Measurement,
    /// Scale error.
    pub value: f64,
    pub standard_error: f64,
}

impl Footprint for WindowFits {
    fn bytes(&self) -> usize {
        self.fits.iter().map(fit_bytes).sum::<usize>() + 64
    }
}

impl Footprint for PooledFits {
    fn bytes(&self) -> usize {
        let predicted: usize =
            self.predictions.iter().map(|prediction| prediction.own_constant.values.len() * 24).sum();
        self.fits.iter().map(fit_bytes).sum::<usize>() + predicted + 64
    }
}

impl Stage for WindowFits {
    type Params<'a> = (&'a Manoeuvre, &'a Structure, &'a Estimation);
    type Inputs<'a> = &'a Keyed<WindowAero>;
    type Output = Self;
    const NAME: &'static str = "fits of a manoeuvre";

    fn run(params: Self::Params<'_>, aero: &Keyed<WindowAero>, _: &Context<'_>) -> StageResult<Self> {
        let (manoeuvre, structure, estimation) = params;
        Ok(window_fits(manoeuvre, aero.shared(), structure, estimation))
    }
}

impl Stage for PooledFits {
    type Params<'a> = (&'a Structure, &'a Estimation);
    type Inputs<'a> = &'a [(&'a Manoeuvre, &'a Keyed<WindowAero>, &'a Keyed<WindowFits>)];
    type Output = Self;
    const NAME: &'static str = "pooled estimate";

    fn run((structure, estimation): Self::Params<'_>, inputs: Self::Inputs<'_>, _: &Context<'_>) -> StageResult<Self> {
        let windows: Vec<AeroWindow<'_>> =
            inputs.iter().map(|(manoeuvre, aero, _)| (*manoeuvre, Arc::clone(aero.shared()))).collect();
        let own = |manoeuvre: &Manoeuvre, coefficient: Coefficient| {
            let (.., fits) = inputs.iter().find(|(other, ..)| other.name == manoeuvre.name)?;
            fits.fits.iter().find(|fit| fit.coefficient == coefficient)
        };
        Ok(pooled_fits_by(&windows, structure, estimation, &own))
    }
}

fn fit_bytes(fit: &CoefficientFit) -> usize {
    fit.fit.as_ref().map_or(64, |fit| fit.residuals.len() * 32 + 4096)
}

/// Whether a manoeuvre of `surface` tells about `coefficient`: the elevator about the symmetric ones, aileron and rudder about
/// the asymmetric ones (thesis 3.2.3).
pub fn applies(coefficient: Coefficient, surface: Option<Surface>, estimation: &Estimation) -> bool {
    let asymmetric = matches!(coefficient, Coefficient::CY | Coefficient::Cl | Coefficient::Cn);
    match surface {
        Some(surface) if estimation.by_surface => asymmetric != (surface == Surface::Elevator),
        _ => true,
    }
}

/// Whether one of the surfaces a manoeuvre moves tells about `coefficient`.
pub(crate) fn identifies(manoeuvre: &Manoeuvre, coefficient: Coefficient, estimation: &Estimation) -> bool {
    let second = manoeuvre.also.is_some_and(|also| applies(coefficient, Some(also), estimation));
    second || applies(coefficient, manoeuvre.surface, estimation)
}

/// Standard deviation of a control over that of the one that moves most, up to which it rests: noise and the pilot's small corrections
/// lie below, a second input lies above.
const RESTS: f64 = 0.1;

/// Terms that one window determines, and those it does not: a control that rests in it gives no derivative (thesis 3.2.3), unless that is
/// known beforehand. Its recorded motion decides, whatever the window is called.
pub(crate) fn window_terms(
    coefficient: Coefficient,
    terms: &[Term],
    aero: &WindowAero,
    estimation: &Estimation,
) -> (Vec<Term>, Vec<DroppedTerm>) {
    let left = aero.left();
    let deviation = |values: &Arc<[f64]>| match &left {
        None => standard_deviation(values),
        Some(left) => standard_deviation(&left.iter().map(|&sample| values[sample]).collect::<Vec<_>>()),
    };
    let motion = Surface::ALL.map(|surface| {
        let deflection = aero.data.controls.get(&surface.role());
        (surface.variable(), deflection.map_or(f64::NAN, deviation))
    });
    let largest = motion.iter().map(|(_, deviation)| *deviation).fold(0.0, f64::max);
    let is_resting = |variable: Variable| {
        motion.iter().any(|(control, deviation)| *control == variable && *deviation <= RESTS * largest)
    };
    let rests = |term: &&Term| {
        let known = estimation.known(coefficient, term);
        estimation.by_surface
            && largest > 0.0
            && !matches!(known, Constraint::Fixed(_) | Constraint::Prior { .. })
            && term.factors().iter().any(|(variable, _)| is_resting(*variable))
    };
    let dropped = terms.iter().filter(rests).map(|term| DroppedTerm {
        derivative: term.derivative_name(coefficient),
        reason: "control does not move in this manoeuvre".to_owned(),
    });
    let dropped = dropped.collect();
    (terms.iter().filter(|term| !rests(term)).cloned().collect(), dropped)
}

fn standard_deviation(values: &[f64]) -> f64 {
    (squares_about_mean(values) / values.len().max(1) as f64).sqrt()
}

/// Terms whose regressor moves in some window of a fit, and those that nothing can be told of: zero in all of them, or constant where
/// the fit has constants that do the same. What is known beforehand stays.
///
/// Regressors that move but depend on each other are left to the fit, whose error names them.
fn moving_terms(
    coefficient: Coefficient,
    terms: &[Term],
    used: &[&AeroWindow<'_>],
    estimation: &Estimation,
) -> (Vec<Term>, Vec<DroppedTerm>) {
    let has_constant = terms.iter().any(Term::is_constant);
    let own_constants = has_constant && estimation.constants == PooledConstants::PerManoeuvre;
    let rests = |term: &&Term| {
        let known = estimation.known(coefficient, term);
        if term.is_constant() || matches!(known, Constraint::Fixed(_) | Constraint::Prior { .. }) {
            return false;
        }
        let mut ends: Vec<(f64, f64)> = Vec::with_capacity(used.len());
        for (_, aero) in used {
            // A window that lacks the variable says so in the fit.
            let Ok(column) = regressors(std::slice::from_ref(*term), &aero.variables) else { return false };
            ends.push(
                column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v))),
            );
        }
        let all = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |all, own| (all.0.min(own.0), all.1.max(own.1)));
        let is_zero = is_constant(all) && all.0.abs().max(all.1.abs()) <= SMALLEST_MOTION;
        is_zero || (has_constant && is_constant(all)) || (own_constants && ends.iter().all(|&own| is_constant(own)))
    };
    let reason = if used.len() == 1 { "constant in this manoeuvre" } else { "constant in every manoeuvre" };
    let dropped = terms
        .iter()
        .filter(rests)
        .map(|term| DroppedTerm { derivative: term.derivative_name(coefficient), reason: reason.to_owned() });
    let dropped: Vec<_> = dropped.collect();
    let stays = |term: &&Term| !dropped.iter().any(|dropped| dropped.derivative == term.derivative_name(coefficient));
    (terms.iter().filter(stays).cloned().collect(), dropped)
}

/// Largest part of a constant regressor that is rounding, and the variation below which any regressor rests.
const ROUNDING: f64 = 1e-12;
const SMALLEST_MOTION: f64 = 1e-12;

/// Whether a column between these values varies by no more than rounding.
fn is_constant((low, high): (f64, f64)) -> bool {
    high - low <= (ROUNDING * low.abs().max(high.abs())).max(SMALLEST_MOTION)
}

/// Fits every coefficient that applies to one window.
pub fn window_fits(
    manoeuvre: &Manoeuvre,
    aero: &Arc<WindowAero>,
    structure: &Structure,
    estimation: &Estimation,
) -> WindowFits {
    let models = structure.models.iter().filter(|(c, _)| identifies(manoeuvre, *c, estimation));
    let fits = models.map(|(coefficient, terms)| {
        let (terms, dropped) = window_terms(*coefficient, terms, aero, estimation);
        let window = (manoeuvre, Arc::clone(aero));
        coefficient_fit(*coefficient, &terms, &[&window], estimation, dropped)
    });
    WindowFits { fits: fits.collect() }
}

/// A window with its coefficients.
pub type AeroWindow<'a> = (&'a Manoeuvre, Arc<WindowAero>);

/// A coefficient, its terms and the windows they are estimated from.
type Model<'m, 's> = (Coefficient, &'m Vec<Term>, Vec<&'m AeroWindow<'s>>);

/// Fits every coefficient of the structure over all identification windows and predicts every window not ignored. With long windows one
/// coefficient after the other: the spectra of the residuals of one take a tenth of what the window takes.
pub fn pooled_fits(windows: &[AeroWindow<'_>], structure: &Structure, estimation: &Estimation) -> PooledFits {
    pooled_fits_by(windows, structure, estimation, &|_, _| None)
}

/// Finds the fit of a coefficient in one window by itself, where that is known.
type OwnFit<'f> = dyn Fn(&Manoeuvre, Coefficient) -> Option<&'f CoefficientFit> + Sync + 'f;

/// [`pooled_fits`] with the fits of single windows: that of the only window with all terms is the pooled one.
fn pooled_fits_by(
    windows: &[AeroWindow<'_>],
    structure: &Structure,
    estimation: &Estimation,
    own: &OwnFit<'_>,
) -> PooledFits {
    let models = structure
        .models
        .iter()
        .map(|(coefficient, terms)| (*coefficient, terms, identification(*coefficient, terms, windows, estimation)));
    let models: Vec<Model<'_, '_>> = models.filter(|(_, _, used)| !used.is_empty()).collect();
    let fit = |(coefficient, terms, used): &Model<'_, '_>| {
        let known = match used[..] {
            [(manoeuvre, aero)] if window_terms(*coefficient, terms, aero, estimation).1.is_empty() => {
                own(manoeuvre, *coefficient)
            }
            _ => None,
        };
        known.cloned().unwrap_or_else(|| coefficient_fit(*coefficient, terms, used, estimation, Vec::new()))
    };
    let longest = windows.iter().map(|(_, aero)| aero.coefficients.time_s.len()).max().unwrap_or(0);
    let together = if longest > LONG_WINDOW { models.len() } else { 1 };
    // The coefficients know nothing of each other; their order is that of the structure.
    let each = || models.par_iter().with_min_len(together);
    let fits: Vec<CoefficientFit> = each().map(fit).collect();
    let predictions = each().zip(&fits).map(|(model, fit)| predict_windows(model, fit, windows, estimation));
    let predictions: Vec<Vec<Prediction>> = predictions.collect();
    PooledFits {
        fits,
        predictions: predictions.into_iter().flatten().collect(),
        vane_scales: Vec::new(),
        path_errors: None,
    }
}

fn predict_windows(
    (coefficient, terms, used): &Model<'_, '_>,
    fit: &CoefficientFit,
    windows: &[AeroWindow<'_>],
    estimation: &Estimation,
) -> Vec<Prediction> {
    let Ok(fit) = &fit.fit else { return Vec::new() };
    let parameters = Parameters::choose(*coefficient, terms, fit, used, estimation);
    let applying = windows.iter().filter(|(window, _)| identifies(window, *coefficient, estimation));
    let predicted =
        |(window, aero): &AeroWindow<'_>| predict(*coefficient, terms, &parameters, (window, aero), estimation);
    applying.filter_map(predicted).collect()
}

/// Conventional and corrected standard error of an estimate; NaN where it is held, fixed or at a bound.
pub fn errors(fit: &Fit, corrected_errors: &[f64], at: usize) -> (f64, f64) {
    if !fit.origins[at].is_estimated() {
        return (f64::NAN, f64::NAN);
    }
    (fit.standard_errors[at], corrected_errors.get(at).copied().unwrap_or(f64::NAN))
}

/// What a reader should know of an estimate that does not rest on the samples alone: `fixed`, `at bound` or `prior`.
pub fn describe_origin(origin: Origin) -> Option<&'static str> {
    match origin {
        Origin::Data => None,
        Origin::DataAndPrior => Some("prior"),
        Origin::Bound => Some("at bound"),
        Origin::Fixed => Some("fixed"),
    }
}

/// Relative error, per cent, and t of an estimate, by its error corrected for correlated residuals where that is known; NaN where it
/// is held.
pub fn significance(fit: &Fit, corrected_errors: &[f64], at: usize) -> (f64, f64) {
    if !fit.origins[at].is_estimated() {
        return (f64::NAN, f64::NAN);
    }
    let error = corrected_errors.get(at).copied().unwrap_or(fit.standard_errors[at]);
    (100.0 * (error / fit.estimates[at]).abs(), fit.estimates[at] / error)
}

/// Name of the constant of one window in a pooled fit.
pub(crate) fn constant_name(constant: &str, window: &str) -> String {
    format!("{constant}[{window}]")
}

/// Least squares over the windows, with errors corrected for correlated residuals.
fn coefficient_fit(
    coefficient: Coefficient,
    terms: &[Term],
    used: &[&AeroWindow<'_>],
    estimation: &Estimation,
    mut dropped: Vec<DroppedTerm>,
) -> CoefficientFit {
    let (terms, resting) = moving_terms(coefficient, terms, used, estimation);
    dropped.extend(resting);
    if terms.is_empty() {
        let fit = Err("no term is excited in these manoeuvres: add an excited term or a constant".into());
        let windows = used.iter().map(|(window, aero)| (window.name.clone(), aero.coefficients.time_s.len())).collect();
        return CoefficientFit {
            coefficient,
            windows,
            series: None,
            corrected_errors: Vec::new(),
            noise_errors: Vec::new(),
            fit,
            dropped,
        };
    }
    let (fit, [corrected_errors, noise_errors]) = match stacked_fit(coefficient, &terms, used, estimation) {
        Ok((fit, errors)) => (Ok(fit), errors),
        Err(error) => (Err(error), [Vec::new(), Vec::new()]),
    };
    CoefficientFit {
        coefficient,
        windows: used.iter().map(|(window, aero)| (window.name.clone(), aero.coefficients.time_s.len())).collect(),
        series: match (&fit, used) {
            (Ok(fit), [(_, aero)]) => Some(FittedSeries::new(aero, coefficient, &fit.residuals)),
            _ => None,
        },
        corrected_errors,
        noise_errors,
        fit,
        dropped,
    }
}

fn stacked_fit(
    coefficient: Coefficient,
    terms: &[Term],
    used: &[&AeroWindow<'_>],
    estimation: &Estimation,
) -> StageResult<(Fit, [Vec<f64>; 2])> {
    let measured = Regression::measured(coefficient, terms, used, estimation)?.pooled;
    let weighted = weighted(&measured, estimation.weights)?;
    let regression = weighted.as_ref().unwrap_or(&measured);
    let pooled = regression.fit()?;
    let between = pooled.errors_between_windows(&regression.windows);
    let coloured = |windows| pooled.coloured_covariance_of(windows, &Coloured::default());
    let (coloured, fit) = match weighted {
        None => (coloured(measured.windows)?, pooled.fit),
        Some(weighted) => (coloured(weighted.windows)?, with_measured_residuals(pooled, &measured)),
    };
    let noise: Vec<f64> = coloured.diagonal().iter().map(|variance| variance.sqrt()).collect();
    let mut errors = noise.clone();
    // Noise that is stationary inside windows explains the first; a model that fits no manoeuvre exactly shows between them.
    if let Some(between) = between {
        errors.iter_mut().zip(between).for_each(|(error, between)| *error = error.max(between));
    }
    Ok((fit, [errors, noise]))
}

/// The fit of a weighted regression with the residuals and the quality of the coefficient as it was measured.
fn with_measured_residuals(pooled: PooledFit, measured: &PooledRegression) -> Fit {
    let fitted = pooled.fitted(&measured.windows);
    let z: Vec<f64> = measured.windows.iter().flat_map(|window| &window.z).copied().collect();
    let residuals = z.iter().zip(&fitted).map(|(z, y)| z - y).collect();
    Fit { quality: FitQuality::compare(&z, &fitted), residuals, ..pooled.fit }
}

/// The regression whose least squares has these weights of the residuals; none where all weigh the same.
fn weighted(measured: &PooledRegression, weights: ResidualWeights) -> StageResult<Option<PooledRegression>> {
    Ok(match weights {
        ResidualWeights::Equal => None,
        ResidualWeights::Huber => Some(measured.with_pseudo_values()?),
        ResidualWeights::Autoregression(order) => Some(measured.whitened(order)?),
    })
}

/// The regression of one coefficient over windows.
#[derive(Clone, Debug)]
pub struct Regression {
    pub coefficient: Coefficient,
    /// Derivatives, regressors and observations.
    pub pooled: PooledRegression,
}

impl Regression {
    /// The regression of `coefficient` by `terms` over the windows `used`, under what is known of its derivatives. With weights of the
    /// residuals its samples are pseudo-values or whitened, so that whatever fits it has the weights.
    pub fn new(
        coefficient: Coefficient,
        terms: &[Term],
        used: &[&AeroWindow<'_>],
        estimation: &Estimation,
    ) -> StageResult<Self> {
        let Self { pooled, .. } = Self::measured(coefficient, terms, used, estimation)?;
        let weighted = weighted(&pooled, estimation.weights)?;
        Ok(Self { coefficient, pooled: weighted.unwrap_or(pooled) })
    }

    /// The same as it was measured, without weights.
    fn measured(
        coefficient: Coefficient,
        terms: &[Term],
        used: &[&AeroWindow<'_>],
        estimation: &Estimation,
    ) -> StageResult<Self> {
        let own_constants = estimation.constants == PooledConstants::PerManoeuvre && used.len() > 1;
        let constraints: Vec<_> = terms.iter().map(|term| estimation.known(coefficient, term)).collect();
        let window = |(window, aero): &&AeroWindow<'_>| -> StageResult<PooledWindow> {
            let x =
                regressors(terms, &aero.variables).map_err(|error| format!("manoeuvre '{}': {error}", window.name))?;
            Ok(PooledWindow { label: window.name.clone(), x, z: aero.coefficients.get(coefficient).to_vec() })
        };
        let pooled = PooledRegression {
            names: terms.iter().map(|term| term.derivative_name(coefficient)).collect(),
            // A fixed constant is one number for all windows.
            per_window: terms
                .iter()
                .zip(&constraints)
                .map(|(term, known)| own_constants && term.is_constant() && !matches!(known, Constraint::Fixed(_)))
                .collect(),
            constraints,
            windows: used.iter().map(window).collect::<Result<_, _>>()?,
        };
        Ok(Self { coefficient, pooled })
    }
}

/// The pooled regression of every coefficient of the structure that some identification window tells about.
pub fn pooled_regressions(
    windows: &[AeroWindow<'_>],
    structure: &Structure,
    estimation: &Estimation,
) -> Vec<StageResult<Regression>> {
    let models = structure.models.iter();
    let one = |(coefficient, terms): &(Coefficient, Vec<Term>)| {
        let used = identification(*coefficient, terms, windows, estimation);
        let (terms, _) = moving_terms(*coefficient, terms, &used, estimation);
        let regression = || Regression::new(*coefficient, &terms, &used, estimation);
        (!used.is_empty()).then(|| regression().map_err(|error| error.at(coefficient.name())))
    };
    models.filter_map(one).collect()
}

/// Part of a surface's motion in the windows named after it that it must have in a window named after none to count there: below a third
/// of the deviation, a ninth of the information, what the surface does there is what the other axis makes the pilot or the control
/// system do, and the motion is what the model of its own axis does not have.
const LEAST_PART: f64 = 1.0 / 3.0;

/// Whether a surface of the axis of `coefficient` moves in a window named after none by a good part of what it moves in the windows
/// named after it. Always where a window is named, or where none is.
fn moves(
    coefficient: Coefficient,
    (window, aero): &AeroWindow<'_>,
    named: &[(Surface, f64)],
    estimation: &Estimation,
) -> bool {
    if window.surface.is_some() || !estimation.by_surface {
        return true;
    }
    let mut of_axis = named.iter().filter(|(surface, _)| applies(coefficient, Some(*surface), estimation)).peekable();
    of_axis.peek().is_none()
        || of_axis.any(|(surface, usual)| motion(*surface, aero).is_none_or(|own| own >= LEAST_PART * usual))
}

/// Median deviation of each surface in the identification windows named after it, of those that have any.
fn named_motion(windows: &[AeroWindow<'_>]) -> Vec<(Surface, f64)> {
    Surface::ALL.into_iter().filter_map(|surface| usual_motion(windows, surface)).collect()
}

fn usual_motion(windows: &[AeroWindow<'_>], surface: Surface) -> Option<(Surface, f64)> {
    let named = windows
        .iter()
        .filter(|(window, _)| window.role == WindowRole::Identification && window.surface == Some(surface));
    let mut own: Vec<f64> = named.filter_map(|(_, aero)| motion(surface, aero)).collect();
    Some((surface, median(&mut own)?))
}

/// Standard deviation of a surface over a window.
fn motion(surface: Surface, aero: &WindowAero) -> Option<f64> {
    aero.variables.get(surface.variable()).map(standard_deviation)
}

/// The identification windows that tell about `coefficient`. A window that lacks a variable of the model says so in its own fit
/// and does not take the others with it.
fn identification<'w, 's>(
    coefficient: Coefficient,
    terms: &[Term],
    windows: &'w [AeroWindow<'s>],
    estimation: &Estimation,
) -> Vec<&'w AeroWindow<'s>> {
    let named = named_motion(windows);
    let uses = |of: &&AeroWindow<'_>| {
        let (window, _) = of;
        identifies(window, coefficient, estimation)
            && window.role == WindowRole::Identification
            && moves(coefficient, of, &named, estimation)
    };
    let used: Vec<_> = windows.iter().filter(uses).collect();
    let variables: Vec<Variable> = terms.iter().flat_map(Term::factors).map(|&(variable, _)| variable).collect();
    let known = |(_, aero): &&&AeroWindow<'_>| variables.iter().all(|&variable| aero.variables.get(variable).is_some());
    let complete: Vec<_> = used.iter().filter(known).copied().collect();
    if complete.is_empty() { used } else { complete }
}
