//! Stepwise choice of terms.

use nalgebra::DMatrix;

use super::diagnostics::{predicted_squared_error, press};
use super::least_squares::{check_values, least_squares};
use super::triangle::Triangle;
use super::{EstimateError, Fit};

/// When terms come and go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepwiseSettings {
    /// Partial F a term must exceed to be added; 4 is significant at 95 %, 20 the practice in aircraft identification.
    pub f_in: f64,
    /// Partial F below which a term is removed again, at most `f_in`.
    pub f_out: f64,
    /// Smallest gain of R2 worth a term.
    pub min_gain: f64,
}

impl Default for StepwiseSettings {
    fn default() -> Self {
        Self { f_in: 20.0, f_out: 20.0, min_gain: 0.005 }
    }
}

/// What a step did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepAction {
    /// The term was added.
    Added,
    /// The term had lost its significance and was removed.
    Removed,
    /// The term was the best candidate, but its partial F is too small: the search ends.
    RefusedByF,
    /// The term was the best candidate, but it hardly raises R2: the search ends.
    RefusedByGain,
}

/// One step of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct StepRecord {
    /// What was done.
    pub action: StepAction,
    /// Name of the term.
    pub name: String,
    /// Correlation of the term with the measurement, both less what the terms in the model explain.
    pub partial_correlation: f64,
    /// Partial F of the term, in the model that has it.
    pub partial_f: f64,
    /// R2 of the model after the step.
    pub r_squared: f64,
    /// Predicted residual sum of squares of the model after the step.
    pub press: f64,
    /// Predicted squared error of the model after the step.
    pub predicted_squared_error: f64,
}

/// Chosen terms, their fit, and how they were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Indices of the chosen candidates, in ascending order.
    pub selected: Vec<usize>,
    /// Fit by the chosen terms.
    pub fit: Fit,
    /// Every step.
    pub log: Vec<StepRecord>,
}

/// Stepwise regression (Klein and Morelli, "Aircraft System Identification", 5.4.2): from the `forced` terms on, the
/// candidate with the largest partial correlation is added while its partial `F = theta^2 / s^2(theta)` exceeds `f_in` and it
/// raises R2 by `min_gain`; after each addition terms with `F < f_out` are removed.
///
/// `x`: samples by candidates. `forced`: indices of candidates that are always in the model, usually the constants. The
/// samples are reduced to one triangle first, so that each trial costs nothing that grows with their number.
///
/// # Errors
/// As for [`super::least_squares`]; candidates that depend on the model are passed over.
pub fn stepwise(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    forced: &[usize],
    settings: &StepwiseSettings,
) -> Result<Selection, EstimateError> {
    check_values(names, x, z)?;
    if !(settings.f_out <= settings.f_in && settings.f_out >= 0.0) {
        return Err(EstimateError::Setting {
            setting: "f_out".to_owned(),
            value: settings.f_out,
            allowed: "0 to f_in",
        });
    }
    if let Some(&index) = forced.iter().find(|&&index| index >= names.len()) {
        return Err(EstimateError::Size { quantity: "forced term", expected: names.len(), found: index });
    }
    let search = Search { names, x, z, triangle: Triangle::reduce(x, z) };
    let mut selected = forced.to_vec();
    let mut log = Vec::new();
    while let Some(trial) = search.best(&selected) {
        let gain = trial.gain / search.total();
        let refused = if trial.partial_f <= settings.f_in {
            Some(StepAction::RefusedByF)
        } else if gain < settings.min_gain {
            Some(StepAction::RefusedByGain)
        } else {
            None
        };
        if refused.is_none() {
            selected.push(trial.index);
        }
        log.push(search.record(refused.unwrap_or(StepAction::Added), &trial, &selected)?);
        if refused.is_some()
            || !search.remove_insignificant(&mut selected, forced, settings.f_out, trial.index, &mut log)?
        {
            break;
        }
    }
    selected.sort_unstable();
    let fit = search.fit(&selected)?;
    Ok(Selection { selected, fit, log })
}

/// A candidate on trial.
struct Trial {
    index: usize,
    partial_correlation: f64,
    partial_f: f64,
    /// Drop of the residual sum of squares.
    gain: f64,
}

/// What the steps share.
struct Search<'a> {
    names: &'a [String],
    x: &'a DMatrix<f64>,
    z: &'a [f64],
    triangle: Triangle,
}

impl Search<'_> {
    /// Sum of squares of the measurement about its mean.
    fn total(&self) -> f64 {
        let mean = self.z.iter().sum::<f64>() / self.z.len() as f64;
        self.z.iter().map(|z| (z - mean).powi(2)).sum()
    }

    /// The candidate outside `selected` that lowers the residual sum of squares most.
    fn best(&self, selected: &[usize]) -> Option<Trial> {
        let before = self.triangle.subset(selected).residual_square();
        (0..self.names.len())
            .filter(|index| !selected.contains(index))
            .filter_map(|index| {
                let with: Vec<usize> = selected.iter().copied().chain(std::iter::once(index)).collect();
                let subset = self.triangle.subset(&with);
                let names: Vec<String> = with.iter().map(|&index| self.names[index].clone()).collect();
                let solution = subset.solve(&names).ok()?;
                let degrees = self.z.len().checked_sub(with.len()).filter(|&degrees| degrees > 0)?;
                let gain = before - subset.residual_square();
                let sign = solution.estimates[selected.len()].signum();
                Some(Trial {
                    index,
                    partial_correlation: sign * (gain / before).clamp(0.0, 1.0).sqrt(),
                    partial_f: gain / (subset.residual_square() / degrees as f64),
                    gain,
                })
            })
            .max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Fit by the chosen terms.
    fn fit(&self, selected: &[usize]) -> Result<Fit, EstimateError> {
        let names: Vec<String> = selected.iter().map(|&index| self.names[index].clone()).collect();
        least_squares(&names, &self.x.select_columns(selected), self.z)
    }

    /// Record of a step that left the model with `selected`.
    fn record(&self, action: StepAction, trial: &Trial, selected: &[usize]) -> Result<StepRecord, EstimateError> {
        let (r_squared, press, error) = if selected.is_empty() {
            (0.0, f64::NAN, f64::NAN)
        } else {
            let fit = self.fit(selected)?;
            let press = press(&fit, &self.x.select_columns(selected));
            (fit.quality.r_squared, press, predicted_squared_error(&fit, None))
        };
        Ok(StepRecord {
            action,
            name: self.names[trial.index].clone(),
            partial_correlation: trial.partial_correlation,
            partial_f: trial.partial_f,
            r_squared,
            press,
            predicted_squared_error: error,
        })
    }

    /// Removes terms that have lost their significance, the weakest first; false when the term just added is among them, so
    /// that the search would go round in circles.
    fn remove_insignificant(
        &self,
        selected: &mut Vec<usize>,
        forced: &[usize],
        f_out: f64,
        added: usize,
        log: &mut Vec<StepRecord>,
    ) -> Result<bool, EstimateError> {
        loop {
            let fit = self.fit(selected)?;
            let weakest = selected
                .iter()
                .zip(&fit.t_values)
                .map(|(&index, t)| (index, t * t))
                .filter(|&(index, partial_f)| !forced.contains(&index) && partial_f < f_out)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((index, partial_f)) = weakest else { return Ok(true) };
            selected.retain(|&other| other != index);
            let degrees = fit.samples() as f64 - fit.parameters() as f64;
            let correlation = (partial_f / (partial_f + degrees)).sqrt();
            let trial = Trial { index, partial_correlation: correlation, partial_f, gain: 0.0 };
            log.push(self.record(StepAction::Removed, &trial, selected)?);
            if index == added {
                return Ok(false);
            }
        }
    }
}
