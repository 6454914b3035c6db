//! What the regressors of a fit allow to tell: which seconds tell which derivative, and how alike the regressors are.

use doublet_core::estimate::diagnostics::{information_shares, regressor_correlation};
use doublet_core::model::{Coefficient, Structure, Term, regressors};
use nalgebra::DMatrix;

use super::aero::WindowAero;
use super::fit::{AeroWindow, CoefficientFit, WindowFits, identifies};
use super::misfit::own_regressors;
use crate::session::{Estimation, PooledConstants, WindowRole};

/// Most parts a window is divided into, and the shortest, s.
const MOST: f64 = 120.0;
const SHORTEST_S: f64 = 0.1;

/// Which seconds of one window tell which derivative of one coefficient.
#[derive(Clone, Debug)]
pub struct Information {
    pub coefficient: Coefficient,
    /// Edges of the parts the window is divided into, s.
    pub edges_s: Vec<f64>,
    /// Derivatives, each with the part of what the window tells of it that each part has: they add up to one.
    pub shares: Vec<(String, Vec<f64>)>,
}

/// Correlation of the regressors of one coefficient (thesis 4.4.3).
#[derive(Clone, Debug)]
pub struct RegressorCorrelation {
    pub coefficient: Coefficient,
    /// Derivatives whose regressors they are.
    pub derivatives: Vec<String>,
    /// Their correlation, one on the diagonal.
    pub correlation: DMatrix<f64>,
}

/// Which seconds of a window tell which derivative of its own fits.
pub fn information(
    aero: &WindowAero,
    fits: &WindowFits,
    structure: &Structure,
    estimation: &Estimation,
) -> Vec<Information> {
    fits.fits.iter().filter_map(|found| share_information(found, aero, structure, estimation)).collect()
}

fn share_information(
    found: &CoefficientFit,
    aero: &WindowAero,
    structure: &Structure,
    estimation: &Estimation,
) -> Option<Information> {
    let fit = found.fit.as_ref().ok()?;
    let x = own_regressors(found, aero, structure, estimation)?;
    let time_s = &aero.series[found.coefficient as usize].time_s;
    let (first, last) = (*time_s.first()?, *time_s.last()?);
    if x.nrows() != time_s.len() {
        return None;
    }
    let step_s = ((last - first) / MOST).max(SHORTEST_S);
    let count = (((last - first) / step_s).ceil() as usize).max(1);
    let bin = |time: f64| (((time - first) / step_s) as usize).min(count - 1);
    let shares = information_shares(fit, &x);
    let of_derivative = |(column, name): (usize, &String)| {
        let mut binned = vec![0.0; count];
        time_s.iter().zip(shares.column(column).iter()).for_each(|(time, share)| binned[bin(*time)] += share);
        (name.clone(), binned)
    };
    Some(Information {
        coefficient: found.coefficient,
        edges_s: (0..=count).map(|at| (first + at as f64 * step_s).min(last)).collect(),
        shares: fit.names.iter().enumerate().map(of_derivative).collect(),
    })
}

/// Correlation of the regressors of every coefficient: of `window` alone, or over all identification windows, about the mean of each
/// window where each has its own constant.
pub fn regressor_correlations(
    windows: &[AeroWindow<'_>],
    window: Option<&str>,
    structure: &Structure,
    estimation: &Estimation,
) -> Vec<RegressorCorrelation> {
    structure.models.iter().filter_map(|model| correlate_regressors(model, windows, window, estimation)).collect()
}

fn correlate_regressors(
    (coefficient, terms): &(Coefficient, Vec<Term>),
    windows: &[AeroWindow<'_>],
    window: Option<&str>,
    estimation: &Estimation,
) -> Option<RegressorCorrelation> {
    let terms: Vec<Term> = terms.iter().filter(|term| !term.is_constant()).cloned().collect();
    let used = windows.iter().filter(|(manoeuvre, _)| match window {
        Some(name) => manoeuvre.name == name,
        None => manoeuvre.role == WindowRole::Identification,
    });
    let used = used.filter(|(manoeuvre, _)| identifies(manoeuvre, *coefficient, estimation));
    let mut parts = Vec::new();
    for (_, aero) in used {
        let mut x = regressors(&terms, &aero.variables).ok()?;
        if estimation.constants == PooledConstants::PerManoeuvre {
            for mut column in x.column_iter_mut() {
                let mean = column.mean();
                column.add_scalar_mut(-mean);
            }
        }
        parts.push(x);
    }
    let rows: usize = parts.iter().map(DMatrix::nrows).sum();
    if rows <= terms.len() || terms.is_empty() {
        return None;
    }
    let mut stacked = DMatrix::zeros(rows, terms.len());
    let mut at = 0;
    for part in &parts {
        stacked.rows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    let derivatives = terms.iter().map(|term| term.derivative_name(*coefficient)).collect();
    Some(RegressorCorrelation { coefficient: *coefficient, derivatives, correlation: regressor_correlation(&stacked) })
}
