//! Step 2: derivatives by least squares, of one window and of all identification windows together.

use std::sync::Arc;

use doublet_core::estimate::{Fit, FitQuality, least_squares};
use doublet_core::model::{Coefficient, Structure, Term, Variable, regressors};
use doublet_core::series::Series;
use nalgebra::DMatrix;

use super::aero::WindowAero;
use crate::graph::Footprint;
use crate::session::{Estimation, Manoeuvre, PooledConstants, Surface, WindowRole};

/// A term the structure has but a fit leaves out, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct DroppedTerm {
    /// Derivative it would have given.
    pub derivative: String,
    /// Reason, one line.
    pub reason: String,
}

/// Fit of one coefficient.
#[derive(Clone, Debug)]
pub struct CoefficientFit {
    /// Coefficient.
    pub coefficient: Coefficient,
    /// Windows whose samples it used, in the order they were stacked, with their number of samples.
    pub windows: Vec<(String, usize)>,
    /// Estimates and statistics, or one line that says why there are none.
    pub fit: Result<Fit, String>,
    /// Standard errors corrected for the correlation of the residuals in time, one per estimate; empty where there is no fit.
    pub corrected_errors: Vec<f64>,
    /// Fitted coefficient and residual of each window, in the order of `windows`; empty where there is no fit.
    pub series: Vec<(Series, Series)>,
    /// Terms left out.
    pub dropped: Vec<DroppedTerm>,
}

/// Derivatives from one window.
#[derive(Clone, Debug, Default)]
pub struct WindowFits {
    /// One fit per coefficient that applies to the window.
    pub fits: Vec<CoefficientFit>,
}

/// How well the pooled derivatives predict one coefficient over one window.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Window.
    pub window: String,
    /// Use of the window.
    pub role: WindowRole,
    /// Coefficient.
    pub coefficient: Coefficient,
    /// Agreement with the observation.
    pub quality: FitQuality,
    /// Predicted coefficient.
    pub predicted: Series,
    /// Observation less prediction.
    pub residual: Series,
}

/// Derivatives from all identification windows together.
#[derive(Clone, Debug, Default)]
pub struct PooledFits {
    /// One fit per coefficient of the structure.
    pub fits: Vec<CoefficientFit>,
    /// Prediction of every window that is not ignored.
    pub predictions: Vec<Prediction>,
}

impl Footprint for WindowFits {
    fn bytes(&self) -> usize {
        self.fits.iter().map(fit_bytes).sum::<usize>() + 64
    }
}

impl Footprint for PooledFits {
    fn bytes(&self) -> usize {
        let predicted: usize = self.predictions.iter().map(|prediction| prediction.predicted.values.len() * 16).sum();
        self.fits.iter().map(fit_bytes).sum::<usize>() + predicted + 64
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

/// Terms one window can tell about, and those it cannot: a surface that rests gives no control derivative (thesis 3.2.3).
pub fn window_terms(
    coefficient: Coefficient,
    terms: &[Term],
    surface: Option<Surface>,
    estimation: &Estimation,
) -> (Vec<Term>, Vec<DroppedTerm>) {
    let moving = match surface {
        Some(Surface::Elevator) => Variable::Elevator,
        Some(Surface::Aileron) => Variable::Aileron,
        Some(Surface::Rudder) => Variable::Rudder,
        None => return (terms.to_vec(), Vec::new()),
    };
    let controls = [Variable::Elevator, Variable::Aileron, Variable::Rudder];
    let rests = |term: &&Term| {
        estimation.by_surface
            && term.factors().iter().any(|(variable, _)| controls.contains(variable) && *variable != moving)
    };
    let dropped = terms.iter().filter(rests).map(|term| DroppedTerm {
        derivative: term.derivative_name(coefficient),
        reason: format!("its surface rests in a manoeuvre of the {}", moving.name()),
    });
    let dropped = dropped.collect();
    (terms.iter().filter(|term| !rests(term)).cloned().collect(), dropped)
}

/// Fits every coefficient that applies to one window.
pub fn window_fits(
    manoeuvre: &Manoeuvre,
    aero: &WindowAero,
    structure: &Structure,
    estimation: &Estimation,
) -> WindowFits {
    let models = structure.models.iter().filter(|(c, _)| applies(*c, manoeuvre.surface, estimation));
    let fits = models.map(|(coefficient, terms)| {
        let (terms, dropped) = window_terms(*coefficient, terms, manoeuvre.surface, estimation);
        let names: Vec<_> = terms.iter().map(|term| term.derivative_name(*coefficient)).collect();
        let fit = regressors(&terms, &aero.variables)
            .map_err(|error| error.to_string())
            .and_then(|x| least_squares(&names, &x, aero.coefficients.get(*coefficient)).map_err(|e| e.to_string()));
        CoefficientFit {
            coefficient: *coefficient,
            windows: vec![(manoeuvre.name.clone(), aero.data.time_s.len())],
            corrected_errors: Vec::new(),
            series: fit_series(fit.as_ref().ok(), &[aero]),
            fit,
            dropped,
        }
    });
    WindowFits { fits: fits.collect() }
}

/// A window with its coefficients.
pub type AeroWindow<'a> = (&'a Manoeuvre, Arc<WindowAero>);

/// Fits every coefficient of the structure over all identification windows and predicts every window not ignored.
pub fn pooled_fits(windows: &[AeroWindow<'_>], structure: &Structure, estimation: &Estimation) -> PooledFits {
    let mut pooled = PooledFits::default();
    for (coefficient, terms) in &structure.models {
        let applying: Vec<_> =
            windows.iter().filter(|(window, _)| applies(*coefficient, window.surface, estimation)).collect();
        let used: Vec<_> =
            applying.iter().copied().filter(|(window, _)| window.role == WindowRole::Identification).collect();
        if used.is_empty() {
            continue;
        }
        let fit = stacked_fit(*coefficient, terms, &used, estimation.constants);
        if let Ok(fit) = &fit {
            let predictions =
                applying.iter().filter_map(|(window, aero)| predict(*coefficient, terms, fit, window, aero));
            pooled.predictions.extend(predictions);
        }
        pooled.fits.push(CoefficientFit {
            coefficient: *coefficient,
            windows: used.iter().map(|(window, aero)| (window.name.clone(), aero.data.time_s.len())).collect(),
            corrected_errors: Vec::new(),
            series: fit_series(fit.as_ref().ok(), &used.iter().map(|(_, aero)| aero.as_ref()).collect::<Vec<_>>()),
            fit,
            dropped: Vec::new(),
        });
    }
    pooled
}

/// Fitted coefficient and residual, cut at the windows they were stacked from.
fn fit_series(fit: Option<&Fit>, windows: &[&WindowAero]) -> Vec<(Series, Series)> {
    let Some(fit) = fit else { return Vec::new() };
    let mut start = 0;
    let cut = windows.iter().map(|aero| {
        let time_s = &aero.series[0].time_s;
        let range = start..start + time_s.len();
        start = range.end;
        let share = |column: &[f64]| Series { time_s: Arc::clone(time_s), values: column[range.clone()].into() };
        (share(&fit.fitted), share(&fit.residuals))
    });
    cut.collect()
}

/// Name of the constant of one window in a pooled fit.
fn constant_name(constant: &str, window: &str) -> String {
    format!("{constant} [{window}]")
}

fn stacked_fit(
    coefficient: Coefficient,
    terms: &[Term],
    used: &[&AeroWindow<'_>],
    constants: PooledConstants,
) -> Result<Fit, String> {
    let own_constants =
        constants == PooledConstants::PerWindow && terms.iter().any(Term::is_constant) && used.len() > 1;
    let common: Vec<_> = terms.iter().filter(|term| !(own_constants && term.is_constant())).cloned().collect();
    let mut names: Vec<_> = common.iter().map(|term| term.derivative_name(coefficient)).collect();
    if own_constants {
        let constant = Term::constant().derivative_name(coefficient);
        names.extend(used.iter().map(|(window, _)| constant_name(&constant, &window.name)));
    }
    let samples: usize = used.iter().map(|(_, aero)| aero.data.time_s.len()).sum();
    let mut x = DMatrix::zeros(samples, names.len());
    let mut z = Vec::with_capacity(samples);
    for (index, (window, aero)) in used.iter().enumerate() {
        let block =
            regressors(&common, &aero.variables).map_err(|error| format!("window '{}': {error}", window.name))?;
        let (first, rows) = (z.len(), block.nrows());
        x.view_mut((first, 0), (rows, common.len())).copy_from(&block);
        if own_constants {
            x.view_mut((first, common.len() + index), (rows, 1)).fill(1.0);
        }
        z.extend_from_slice(aero.coefficients.get(coefficient));
    }
    least_squares(&names, &x, &z).map_err(|error| error.to_string())
}

/// Predicts a window; where the fit gave each window its own constant, one that it did not see takes the constant that fits best,
/// so that the prediction tests derivatives, not trim.
fn predict(
    coefficient: Coefficient,
    terms: &[Term],
    fit: &Fit,
    window: &Manoeuvre,
    aero: &WindowAero,
) -> Option<Prediction> {
    let observed = aero.coefficients.get(coefficient);
    let mut predicted = vec![0.0; observed.len()];
    let mut has_constant = false;
    for term in terms {
        let name = term.derivative_name(coefficient);
        let own = term.is_constant().then(|| constant_name(&name, &window.name));
        let Some((estimate, _)) = fit.parameter(&name).or_else(|| fit.parameter(own.as_deref()?)) else { continue };
        has_constant |= term.is_constant();
        let column = regressors(std::slice::from_ref(term), &aero.variables).ok()?;
        predicted.iter_mut().zip(column.iter()).for_each(|(sum, value)| *sum += estimate * value);
    }
    if !has_constant && terms.iter().any(Term::is_constant) {
        let offset = observed.iter().zip(&predicted).map(|(z, y)| z - y).sum::<f64>() / observed.len() as f64;
        predicted.iter_mut().for_each(|value| *value += offset);
    }
    let time_s = &aero.series[coefficient as usize].time_s;
    let share = |values: Arc<[f64]>| Series { time_s: Arc::clone(time_s), values };
    Some(Prediction {
        window: window.name.clone(),
        role: window.role,
        coefficient,
        quality: FitQuality::of(observed, &predicted),
        residual: share(observed.iter().zip(&predicted).map(|(z, y)| z - y).collect()),
        predicted: share(predicted.into()),
    })
}
