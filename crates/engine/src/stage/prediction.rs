//! Prediction of windows by what the identification windows gave, with their constants and with the window's own.

use std::sync::Arc;

use doublet_core::estimate::{Constraint, Fit, FitQuality};
use doublet_core::model::{Coefficient, Term, regressors};
use doublet_core::series::Series;

use super::aero::WindowAero;
use super::fit::{AeroWindow, Regression, constant_name, window_terms};
use crate::session::{Estimation, Manoeuvre, PredictionParameters, WindowRole};

/// How well the identification predicts one coefficient over one window.
#[derive(Clone, Debug)]
pub struct Prediction {
    pub window: String,
    /// Use of the manoeuvre.
    pub role: WindowRole,
    pub coefficient: Coefficient,
    /// Agreement of the observation with the prediction by derivatives and constant of the identification: nothing of this window
    /// enters unless it is one of the identification windows. A constant that each of these has to itself counts with its mean over
    /// them.
    pub quality_identified: FitQuality,
    /// Agreement with the derivatives of the identification and the window's own constant: that of the fit for a window the fit saw,
    /// for any other the one that makes the mean residual zero. It tests derivatives, not trim. A constant stated beforehand is no
    /// window's own: then both agree.
    pub quality_own_constant: FitQuality,
    /// Prediction with the constant of the identification.
    pub identified: Series,
    /// Prediction with the window's own constant.
    pub own_constant: Series,
    /// Observation, shared with the window.
    pub observed: Series,
}

impl Prediction {
    /// Observation less [`Self::own_constant`].
    pub fn residual(&self) -> Series {
        let pairs = self.observed.values.iter().zip(self.own_constant.values.iter());
        Series { time_s: Arc::clone(&self.observed.time_s), values: pairs.map(|(z, y)| z - y).collect() }
    }
}

/// What one coefficient is predicted with, term by term; none for a term nothing was found of.
pub(super) struct Parameters {
    values: Vec<Option<f64>>,
    /// Constant of each identification window that has one to itself.
    own: Vec<(String, f64)>,
}

impl Parameters {
    /// Of a fit over all identification windows.
    pub(super) fn pooled(coefficient: Coefficient, terms: &[Term], fit: &Fit, used: &[&AeroWindow<'_>]) -> Self {
        let estimate = |name: &str| fit.parameter(name).map(|(estimate, _)| estimate);
        let mut own = Vec::new();
        let value = |term: &Term| {
            let name = term.derivative_name(coefficient);
            if !term.is_constant() {
                return estimate(&name);
            }
            let alone = used.len() == 1;
            let constants = used.iter().filter_map(|(window, _)| {
                let own = estimate(&constant_name(&name, &window.name));
                Some((window.name.clone(), own.or_else(|| estimate(&name).filter(|_| alone))?))
            });
            own = constants.collect();
            estimate(&name).or_else(|| mean(own.iter().map(|(_, constant)| *constant)))
        };
        let values = terms.iter().map(value).collect();
        Self { values, own }
    }

    /// Means over the fits of the identification windows by themselves, constants included (thesis 7.1). A derivative counts where
    /// a window tells it; a window without a fit counts nowhere.
    fn window_means(
        coefficient: Coefficient,
        terms: &[Term],
        used: &[&AeroWindow<'_>],
        estimation: &Estimation,
    ) -> Self {
        let fits = used.iter().filter_map(|window| {
            let (terms, _) = window_terms(coefficient, terms, &window.1, estimation);
            Regression::new(coefficient, &terms, &[*window], estimation).ok()?.pooled.fit().ok()
        });
        let fits: Vec<_> = fits.collect();
        let value = |term: &Term| {
            let name = term.derivative_name(coefficient);
            mean(fits.iter().filter_map(|found| found.fit.parameter(&name)).map(|(estimate, _)| estimate))
        };
        Self { values: terms.iter().map(value).collect(), own: Vec::new() }
    }

    /// Those the session predicts with.
    pub(super) fn choose(
        coefficient: Coefficient,
        terms: &[Term],
        fit: &Fit,
        used: &[&AeroWindow<'_>],
        estimation: &Estimation,
    ) -> Self {
        match estimation.predict_with {
            PredictionParameters::Pooled => Self::pooled(coefficient, terms, fit, used),
            PredictionParameters::ManoeuvreMeans => Self::window_means(coefficient, terms, used, estimation),
        }
    }
}

/// Mean; none of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Predicts one window with both constants; none where it lacks a variable of a term that was found.
pub(super) fn predict(
    coefficient: Coefficient,
    terms: &[Term],
    parameters: &Parameters,
    (window, aero): (&Manoeuvre, &WindowAero),
    estimation: &Estimation,
) -> Option<Prediction> {
    let observed = aero.coefficients.get(coefficient);
    let columns = terms.iter().map(|term| regressors(std::slice::from_ref(term), &aero.variables).ok());
    let columns: Vec<_> = columns.collect();
    let sum = |values: &[Option<f64>]| -> Option<Vec<f64>> {
        let mut predicted = vec![0.0; observed.len()];
        for (value, column) in values.iter().zip(&columns) {
            let Some(value) = value else { continue };
            predicted.iter_mut().zip(column.as_ref()?.iter()).for_each(|(sum, x)| *sum += value * x);
        }
        Some(predicted)
    };
    let identified = sum(&parameters.values)?;
    let constant = terms.iter().position(Term::is_constant);
    let free = constant.filter(|&at| !matches!(estimation.known(coefficient, &terms[at]), Constraint::Fixed(_)));
    let own = match free {
        None => identified.clone(),
        Some(at) => {
            let fitted = parameters.own.iter().find(|(name, _)| *name == window.name).map(|(_, constant)| *constant);
            let mut values = parameters.values.clone();
            values[at] = fitted;
            let mut predicted = sum(&values)?;
            if fitted.is_none() {
                let offset = observed.iter().zip(&predicted).map(|(z, y)| z - y).sum::<f64>() / observed.len() as f64;
                predicted.iter_mut().for_each(|value| *value += offset);
            }
            predicted
        }
    };
    let series = &aero.series[coefficient as usize];
    let share = |values: Arc<[f64]>| Series { time_s: Arc::clone(&series.time_s), values };
    let (identified, own): (Arc<[f64]>, Arc<[f64]>) = (identified.into(), own.into());
    // The constant of the identification often is the window's own.
    let is_same = own.iter().map(|y| y.to_bits()).eq(identified.iter().map(|y| y.to_bits()));
    let own = if is_same { Arc::clone(&identified) } else { own };
    Some(Prediction {
        window: window.name.clone(),
        role: window.role,
        coefficient,
        quality_identified: FitQuality::compare(observed, &identified),
        quality_own_constant: FitQuality::compare(observed, &own),
        identified: share(identified),
        own_constant: share(own),
        observed: series.clone(),
    })
}
