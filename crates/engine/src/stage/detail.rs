//! What is worked out for a closer look, from results there already are: pure functions, cheap enough for one window at a time.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::estimate::{Constraint, Fit, ParameterSummary, PooledWindow, TermStudy, summarise, term_study};
use doublet_core::model::{Coefficient, Structure, Term, regressors};
use doublet_core::prep::{Spectrum, cumulative_trapezoid, spectrum};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::State;
use doublet_core::series::{Recording, Series};
use doublet_core::validate::{Histogram, Whiteness, histogram, whiteness};

use super::aero::WindowAero;
use super::fit::{AeroWindow, CoefficientFit, WindowFits, identifies, window_terms};
use super::path::WindowPath;
use crate::graph::StageResult;
use crate::session::{Estimation, Manoeuvre, PooledConstants, WindowRole};

/// Longest lag of a residual's autocorrelation, as a part of its samples and in samples.
const LAG_PART: usize = 4;
const MOST_LAGS: usize = 200;
/// Bins of a residual's histogram.
const BINS: usize = 25;
/// Part at the end of a window over which biases and wind are averaged, s (thesis Tables 6.1 and 6.2: 100 samples at 100 Hz).
const AVERAGED_S: f64 = 1.0;

/// The residual of one coefficient over one window.
#[derive(Clone, Debug)]
pub struct ResidualStudy {
    pub coefficient: Coefficient,
    /// Time from one lag to the next, s.
    pub step_s: f64,
    /// Autocorrelation with the 95 % band of white noise.
    pub whiteness: Whiteness,
    /// How often each size occurs, beside a normal distribution.
    pub histogram: Histogram,
    /// Power spectral density; none for too few samples.
    pub spectrum: Option<Spectrum>,
}

/// What each term adds to a coefficient over one window.
#[derive(Clone, Debug)]
pub struct Contributions {
    pub coefficient: Coefficient,
    /// Derivative and its term's part, `derivative * term`.
    pub terms: Vec<(String, Series)>,
}

/// The terms of one coefficient and candidates beside them.
#[derive(Clone, Debug)]
pub struct CoefficientStudy {
    pub coefficient: Coefficient,
    /// What each tells, or one line why that is not known.
    pub study: StageResult<TermStudy>,
    /// The terms studied, in the order of its entries; those left out need a variable that is not recorded.
    pub terms: Vec<Term>,
}

/// Wind and sensor biases at the end of the windows (thesis Tables 6.1 and 6.2): mean over the last second.
#[derive(Clone, Debug, Default)]
pub struct BiasTable {
    /// Window and its values in the order of [`BIAS_STATES`], SI.
    pub rows: Vec<(String, [f64; 9])>,
    /// Mean, standard deviation, smallest and largest over the windows.
    pub summary: [[f64; 9]; 4],
}

/// States of a [`BiasTable`].
pub const BIAS_STATES: [State; 9] = [
    State::WindNorth,
    State::WindEast,
    State::WindDown,
    State::BiasAx,
    State::BiasAy,
    State::BiasAz,
    State::BiasP,
    State::BiasQ,
    State::BiasR,
];

/// Derivatives from single windows, over windows of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct KindSummary {
    /// Kind of input; empty for all windows together.
    pub kind: String,
    /// Every derivative.
    pub parameters: Vec<ParameterSummary>,
}

/// Residuals of the fits of one window.
pub fn residual_studies(fits: &WindowFits) -> Vec<ResidualStudy> {
    fits.fits.iter().filter_map(study_residual).collect()
}

fn study_residual(fit: &CoefficientFit) -> Option<ResidualStudy> {
    let series = fit.series.as_ref()?;
    let residual = &series.residual;
    let samples = residual.values.len();
    let lags = (samples / LAG_PART).min(MOST_LAGS);
    (lags > 0).then(|| ResidualStudy {
        coefficient: fit.coefficient,
        step_s: series.step_s,
        whiteness: whiteness(&residual.values, lags),
        histogram: histogram(&residual.values, BINS),
        spectrum: spectrum(residual),
    })
}

/// Parts of the fitted coefficients of one window (thesis Fig. 6.13).
pub fn contributions(
    aero: &WindowAero,
    fits: &WindowFits,
    structure: &Structure,
    estimation: &Estimation,
) -> Vec<Contributions> {
    fits.fits.iter().filter_map(|fit| split_fit(fit, aero, structure, estimation)).collect()
}

fn split_fit(
    fit: &CoefficientFit,
    aero: &WindowAero,
    structure: &Structure,
    estimation: &Estimation,
) -> Option<Contributions> {
    let estimate = fit.fit.as_ref().ok()?;
    let terms = structure.terms(fit.coefficient)?;
    let (terms, _) = window_terms(fit.coefficient, terms, aero, estimation);
    let part = |term: &Term| {
        let name = term.derivative_name(fit.coefficient);
        let (derivative, _) = estimate.parameter(&name)?;
        let column = regressors(std::slice::from_ref(term), &aero.variables).ok()?;
        let time_s = aero.series[fit.coefficient as usize].time_s.clone();
        Some((name, Series { time_s, values: column.iter().map(|value| derivative * value).collect() }))
    };
    Some(Contributions { coefficient: fit.coefficient, terms: terms.iter().filter_map(part).collect() })
}

/// North and east position from the ground velocity of a recording without positions, m from where it begins; by the trapezoidal
/// rule over the samples both velocities have. `None` without ground velocity.
pub fn track_from_velocity(recording: &Recording) -> Option<[Series; 2]> {
    let velocity = |role| recording.role(role).map(|channel| &channel.series);
    let (north, east) = (velocity(Role::VelocityNorth)?, velocity(Role::VelocityEast)?);
    if north.time_s != east.time_s {
        return None;
    }
    let known: Vec<usize> =
        (0..north.time_s.len()).filter(|&at| (north.values[at] + east.values[at]).is_finite()).collect();
    let time_s: Arc<[f64]> = known.iter().map(|&at| north.time_s[at]).collect();
    let position = |velocity: &Series| {
        let values: Vec<f64> = known.iter().map(|&at| velocity.values[at]).collect();
        let values = cumulative_trapezoid(&time_s, &values).ok()?;
        Some(Series { time_s: Arc::clone(&time_s), values: values.into() })
    };
    Some([position(north)?, position(east)?])
}

/// What each term of the structure tells over all identification windows, and what each candidate would. A fixed derivative is
/// taken out of the measurement and stands among the candidates: what freeing it would bring. Bounds and priors do not count here.
pub fn model_study(
    windows: &[AeroWindow<'_>],
    structure: &Structure,
    candidates: &[Term],
    estimation: &Estimation,
) -> Vec<CoefficientStudy> {
    structure.models.iter().map(|model| study_coefficient(model, windows, candidates, estimation)).collect()
}

fn study_coefficient(
    (coefficient, own): &(Coefficient, Vec<Term>),
    windows: &[AeroWindow<'_>],
    candidates: &[Term],
    estimation: &Estimation,
) -> CoefficientStudy {
    let used = windows.iter().filter(|(window, _)| {
        window.role == WindowRole::Identification && identifies(window, *coefficient, estimation)
    });
    let known = |term: &Term, aero: &WindowAero| regressors(std::slice::from_ref(term), &aero.variables).is_ok();
    let used: Vec<_> = used.filter(|(_, aero)| own.iter().all(|term| known(term, aero))).collect();
    let beside = candidates.iter().filter(|term| !own.contains(term));
    let beside = beside.filter(|term| !used.is_empty() && used.iter().all(|(_, aero)| known(term, aero)));
    let terms: Vec<Term> = own.iter().chain(beside).cloned().collect();
    let study = study_terms(*coefficient, (&terms, own.len()), &used, estimation);
    let terms = terms.into_iter().filter(|term| !term.is_constant()).collect();
    CoefficientStudy { coefficient: *coefficient, study, terms }
}

fn study_terms(
    coefficient: Coefficient,
    (terms, own): (&[Term], usize),
    used: &[&AeroWindow<'_>],
    estimation: &Estimation,
) -> StageResult<TermStudy> {
    if used.is_empty() {
        return Err("no manoeuvre is used for this coefficient".into());
    }
    let fixed: Vec<Option<f64>> = terms.iter().map(|term| fixed_value(estimation.known(coefficient, term))).collect();
    let windows = used.iter().map(|used| form_window(coefficient, terms, &fixed, used));
    let windows = windows.collect::<StageResult<Vec<_>>>()?;
    let names: Vec<_> = terms.iter().map(|term| term.derivative_name(coefficient)).collect();
    let in_model: Vec<_> = (0..terms.len()).map(|at| at < own && fixed[at].is_none()).collect();
    let is_constant: Vec<_> = terms.iter().map(Term::is_constant).collect();
    let own_constants = estimation.constants == PooledConstants::PerManoeuvre && windows.len() > 1;
    Ok(term_study(&names, &in_model, &is_constant, own_constants, &windows)?)
}

fn form_window(
    coefficient: Coefficient,
    terms: &[Term],
    fixed: &[Option<f64>],
    (window, aero): &AeroWindow<'_>,
) -> StageResult<PooledWindow> {
    let x = regressors(terms, &aero.variables).map_err(|error| format!("manoeuvre '{}': {error}", window.name))?;
    let mut z = aero.coefficients.get(coefficient).to_vec();
    for (column, value) in fixed.iter().enumerate().filter_map(|(column, value)| Some((column, (*value)?))) {
        z.iter_mut().zip(x.column(column).iter()).for_each(|(z, x)| *z -= value * x);
    }
    Ok(PooledWindow { label: window.name.clone(), x, z })
}

fn fixed_value(known: Constraint) -> Option<f64> {
    if let Constraint::Fixed(value) = known { Some(value) } else { None }
}

/// Biases and wind of the windows by name.
pub fn bias_table<'a>(paths: impl Iterator<Item = (&'a str, &'a WindowPath)>) -> BiasTable {
    let rows: Vec<(String, [f64; 9])> = paths.map(|(name, path)| (name.to_owned(), mean_biases(path))).collect();
    let over = |value: fn(&[f64]) -> f64| {
        std::array::from_fn(|at| value(&rows.iter().map(|(_, values)| values[at]).collect::<Vec<_>>()))
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let deviation = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
    };
    let smallest = |values: &[f64]| values.iter().copied().fold(f64::NAN, f64::min);
    let largest = |values: &[f64]| values.iter().copied().fold(f64::NAN, f64::max);
    let summary =
        if rows.is_empty() { [[f64::NAN; 9]; 4] } else { [over(mean), over(deviation), over(smallest), over(largest)] };
    BiasTable { rows, summary }
}

fn mean_biases(path: &WindowPath) -> [f64; 9] {
    let time_s = &path.reconstruction.time_s;
    let from = time_s.partition_point(|&t| t <= time_s.last().copied().unwrap_or(0.0) - AVERAGED_S);
    BIAS_STATES.map(|state| {
        let last = &path.reconstruction.states[state as usize][from..];
        last.iter().sum::<f64>() / last.len() as f64
    })
}

/// Derivatives over all identification windows, then over those of each kind of input.
pub fn kind_summaries<'a>(windows: impl Iterator<Item = (&'a Manoeuvre, &'a WindowFits)>) -> Vec<KindSummary> {
    let mut kinds: BTreeMap<String, Vec<&Fit>> = BTreeMap::new();
    for (window, fits) in windows.filter(|(window, _)| window.role == WindowRole::Identification) {
        let fits: Vec<&Fit> = fits.fits.iter().filter_map(|fit| fit.fit.as_ref().ok()).collect();
        kinds.entry(String::new()).or_default().extend(&fits);
        if !window.kind.is_empty() {
            kinds.entry(window.kind.clone()).or_default().extend(&fits);
        }
    }
    kinds.into_iter().map(|(kind, fits)| KindSummary { kind, parameters: summarise(&fits) }).collect()
}
