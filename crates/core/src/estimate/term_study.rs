//! What each term of a model tells, and what a term beside it would.

use nalgebra::DMatrix;

use super::EstimateError;
use super::least_squares::check_values;
use super::pooled::PooledWindow;
use super::triangle::Triangle;

/// Remaining norm of a regressor, as a fraction of its own, below which it tells nothing of its own. As for the fits.
const INFORMATION_TOLERANCE: f64 = 1e-10;

/// What one term tells.
#[derive(Clone, Debug, PartialEq)]
pub struct TermEffect {
    /// Name of its parameter.
    pub name: String,
    /// Whether the model has it.
    pub in_model: bool,
    /// Variance inflation factor among the terms of the model, this one included: `1 / (1 - R2_j)` with `R2_j` of this
    /// regressor fitted by the constants and the others. Infinite for a term that tells nothing.
    pub variance_inflation: f64,
    /// Partial F, `(SSE without - SSE with) / s^2`, with `s^2` of the model that has the term.
    pub partial_f: f64,
    /// Change of R2 when the tick is changed: removed from the model, or added to it.
    pub r_squared_change: f64,
    /// Change of the predicted squared error when the tick is changed, as a fraction of that of the model.
    pub predicted_error_change: f64,
    /// Whether the regressor varies beside the constants and the other terms; without, no estimate of its parameter exists.
    pub informative: bool,
}

/// A model with what each of its terms and of some candidates tells.
#[derive(Clone, Debug, PartialEq)]
pub struct TermStudy {
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Predicted squared error `SSE / N + sigma2_max p / N`, with `sigma2_max` the variance of the measurement (Klein and Morelli,
    /// "Aircraft System Identification", 5.4).
    pub predicted_squared_error: f64,
    /// Terms in the order given, constants left out.
    pub terms: Vec<TermEffect>,
}

/// Studies terms over windows: `names`, `in_model` and `is_constant` have one entry per column of the windows' regressors. A
/// constant flagged in `in_model` has a parameter of its own in each window where `own_constants`.
///
/// All windows are triangularised once; constants are taken out of the other columns (Frisch and Waugh), then every model with one
/// term more or less follows from a small triangle.
///
/// # Errors
/// Sizes that differ, values that are not finite, too few samples.
pub fn term_study(
    names: &[String],
    in_model: &[bool],
    is_constant: &[bool],
    own_constants: bool,
    windows: &[PooledWindow],
) -> Result<TermStudy, EstimateError> {
    let samples: usize = windows.iter().map(|window| window.z.len()).sum();
    let with_constant = (0..names.len()).any(|at| is_constant[at] && in_model[at]);
    let constants = match (with_constant, own_constants) {
        (false, _) => 0,
        (true, true) => windows.len(),
        (true, false) => 1,
    };
    let free: Vec<usize> = (0..names.len()).filter(|&at| !is_constant[at]).collect();
    let used: Vec<usize> = (0..free.len()).filter(|&at| in_model[free[at]]).collect();
    let parameters = constants + used.len();
    if samples <= parameters + 1 {
        return Err(EstimateError::TooFewSamples { samples, parameters });
    }
    let (factor, norms) = without_constants(names, &free, (constants, own_constants), windows)?;
    let study = Study { factor, norms, samples: samples as f64, total: total_square(windows) };
    let sse = study.remainder(&used, free.len());
    let predicted = |sse: f64, p: usize| (sse + study.total * p as f64 / study.samples) / study.samples;
    let predicted_squared_error = predicted(sse, parameters);
    let effect = |at: usize| {
        let others: Vec<usize> = used.iter().copied().filter(|&other| other != at).collect();
        let all: Vec<usize> = others.iter().copied().chain([at]).collect();
        let own = study.remainder(&[], at);
        let alone = study.remainder(&others, at);
        let informative = alone > (INFORMATION_TOLERANCE * study.norms[at]).powi(2);
        let in_model = used.contains(&at);
        let [without, with] = [(&others, in_model), (&all, !in_model)]
            .map(|(terms, other)| if other { study.remainder(terms, free.len()) } else { sse });
        let with_count = constants + all.len();
        let variance = with / (study.samples - with_count as f64);
        let (changed, count) = if in_model { (without, with_count - 1) } else { (with, with_count) };
        TermEffect {
            name: names[free[at]].clone(),
            in_model,
            variance_inflation: if informative { own / alone } else { f64::INFINITY },
            partial_f: if informative { (without - with) / variance } else { 0.0 },
            r_squared_change: (sse - changed) / study.total,
            predicted_error_change: predicted(changed, count) / predicted_squared_error - 1.0,
            informative,
        }
    };
    Ok(TermStudy {
        r_squared: 1.0 - sse / study.total,
        predicted_squared_error,
        terms: (0..free.len()).map(effect).collect(),
    })
}

/// Triangle of the free regressors and the measurement with the constants taken out, and the norms the regressors had.
fn without_constants(
    names: &[String],
    free: &[usize],
    (constants, own_constants): (usize, bool),
    windows: &[PooledWindow],
) -> Result<(DMatrix<f64>, Vec<f64>), EstimateError> {
    let mut squares = vec![0.0; free.len()];
    let mut parts = Vec::with_capacity(windows.len());
    for (index, window) in windows.iter().enumerate() {
        check_values(names, &window.x, &window.z)?;
        let mut x = DMatrix::zeros(window.z.len(), constants + free.len());
        if constants > 0 {
            x.column_mut(if own_constants { index } else { 0 }).fill(1.0);
        }
        for (at, &column) in free.iter().enumerate() {
            x.set_column(constants + at, &window.x.column(column));
            squares[at] += window.x.column(column).norm_squared();
        }
        parts.push(Triangle::reduce(&x, &window.z));
    }
    let columns: Vec<usize> = (0..constants + free.len()).collect();
    let stacked = Triangle::stack(parts.iter().map(|part| (part, columns.as_slice())), columns.len());
    let size = free.len() + 1;
    let rest = stacked.factor().columns(constants, size).into_owned();
    let taken = constants.min(rest.nrows());
    Ok((rest.remove_rows(0, taken), squares.into_iter().map(f64::sqrt).collect()))
}

/// Sum of squares of the measurement about its mean over all windows.
fn total_square(windows: &[PooledWindow]) -> f64 {
    let all = || windows.iter().flat_map(|window| &window.z);
    let mean = all().sum::<f64>() / all().count() as f64;
    all().map(|z| (z - mean).powi(2)).sum()
}

/// What all models are made from.
struct Study {
    factor: DMatrix<f64>,
    norms: Vec<f64>,
    samples: f64,
    total: f64,
}

impl Study {
    /// Sum of squares left of the column `target` fitted by `columns`.
    fn remainder(&self, columns: &[usize], target: usize) -> f64 {
        let chosen: Vec<usize> = columns.iter().copied().chain([target]).collect();
        let triangle = self.factor.select_columns(&chosen).qr().r();
        let last = chosen.len() - 1;
        if triangle.nrows() > last { triangle[(last, last)].powi(2) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{diagnostics, least_squares, pooled, stacked};
    use super::*;

    /// Rounding of sums over a few hundred samples.
    const ROUNDING: f64 = 1e-9;
    const IS_CONSTANT: [bool; 5] = [true, false, false, false, false];

    fn names() -> Vec<String> {
        ["1", "a", "b", "c", "still"].map(str::to_owned).to_vec()
    }

    /// Two windows; the last column stands still inside each.
    fn windows() -> Vec<PooledWindow> {
        vec![window(0, 120), window(1, 150)]
    }

    fn window(index: usize, count: usize) -> PooledWindow {
        let wave = |row: usize, rate: f64| (row as f64 * rate + index as f64).sin();
        let x = DMatrix::from_fn(count, 5, |row, column| match column {
            0 => 1.0,
            1 => wave(row, 0.3),
            2 => 0.7 * wave(row, 0.3) + 0.4 * wave(row, 1.1),
            3 => wave(row, 2.3) + 1.0,
            _ => 2.0 + index as f64,
        });
        let z = (0..count)
            .map(|row| index as f64 + 2.0 * x[(row, 1)] - x[(row, 2)] + 0.2 * x[(row, 3)] + 0.1 * wave(row, 5.7));
        PooledWindow { label: format!("w{index}"), z: z.collect(), x: x.clone() }
    }

    /// The fit of the terms `kept` over the windows, as the estimate makes it, with its regressors.
    fn fit(kept: &[usize], own: bool) -> (super::super::Fit, DMatrix<f64>) {
        let names: Vec<String> = kept.iter().map(|&at| names()[at].clone()).collect();
        let per_window: Vec<bool> = kept.iter().map(|&at| own && at == 0).collect();
        let windows: Vec<PooledWindow> =
            windows().into_iter().map(|w| PooledWindow { x: w.x.select_columns(kept), ..w }).collect();
        let x = stacked(&names, &per_window, &windows).unwrap().x;
        (pooled(&names, &per_window, &windows).unwrap().fit, x)
    }

    #[test]
    fn every_number_matches_the_fits_with_and_without_the_term() {
        for own in [false, true] {
            let study = term_study(&names(), &[true, true, true, false, false], &IS_CONSTANT, own, &windows()).unwrap();
            let (full, x) = fit(&[0, 1, 2], own);
            let pse = |fit: &super::super::Fit| diagnostics::predicted_squared_error(fit, None);
            approx::assert_relative_eq!(study.r_squared, full.quality.r_squared, epsilon = ROUNDING);
            approx::assert_relative_eq!(study.predicted_squared_error, pse(&full), max_relative = ROUNDING);
            let [a, _, c, _] = &study.terms[..] else { panic!("four terms") };
            let at = full.names.iter().position(|name| name == "a").unwrap();
            approx::assert_relative_eq!(a.partial_f, diagnostics::partial_f(&full)[at], max_relative = ROUNDING);
            let (less, _) = fit(&[0, 2], own);
            approx::assert_relative_eq!(
                a.r_squared_change,
                less.quality.r_squared - full.quality.r_squared,
                epsilon = ROUNDING
            );
            approx::assert_relative_eq!(a.predicted_error_change, pse(&less) / pse(&full) - 1.0, epsilon = ROUNDING);
            let (more, _) = fit(&[0, 1, 2, 3], own);
            let at = more.names.iter().position(|name| name == "c").unwrap();
            approx::assert_relative_eq!(c.partial_f, diagnostics::partial_f(&more)[at], max_relative = ROUNDING);
            approx::assert_relative_eq!(c.predicted_error_change, pse(&more) / pse(&full) - 1.0, epsilon = ROUNDING);
            assert!(a.in_model && !c.in_model);
            if !own {
                let names = ["1", "a", "b"].map(str::to_owned);
                let inflation = diagnostics::variance_inflation(&names, &x).unwrap();
                approx::assert_relative_eq!(a.variance_inflation, inflation[1], max_relative = ROUNDING);
            }
        }
    }

    #[test]
    fn a_regressor_that_stands_still_in_every_window_tells_nothing_beside_their_constants() {
        let in_model = [true, true, false, false, false];
        let own = term_study(&names(), &in_model, &IS_CONSTANT, true, &windows()).unwrap();
        assert!(!own.terms[3].informative && own.terms[3].variance_inflation.is_infinite());
        assert!(own.terms[..3].iter().all(|term| term.informative));
        let common = term_study(&names(), &in_model, &IS_CONSTANT, false, &windows()).unwrap();
        assert!(common.terms[3].informative, "it differs from manoeuvre to manoeuvre");
        let few = PooledWindow { label: "few".to_owned(), x: DMatrix::from_element(2, 5, 1.0), z: vec![1.0, 2.0] };
        assert!(term_study(&names(), &in_model, &IS_CONSTANT, false, &[few]).is_err());
        assert!(least_squares(&names(), &windows()[0].x, &windows()[0].z).is_err(), "the fit refuses it too");
    }
}
