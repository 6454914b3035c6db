//! The pooled estimate of a coefficient as part of a model: every derivative once, with its error and its correlations.

use doublet_core::airframe::ReferenceGeometry;
use doublet_core::model::{Coefficient, Term, Variable};
use nalgebra::DMatrix;

use crate::graph::{StageError, StageResult};
use crate::stage::CoefficientFit;

/// A derivative of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, for example `Cm_alpha`.
    pub name: String,
    /// Term it multiplies.
    pub term: Term,
    /// Estimate.
    pub value: f64,
    /// Standard error, corrected for correlated residuals.
    pub standard_error: f64,
}

/// One coefficient of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedCoefficient {
    pub coefficient: Coefficient,
    /// Its derivatives.
    pub parameters: Vec<Parameter>,
    /// Correlation of the derivatives.
    pub correlation: DMatrix<f64>,
    /// Derivatives as sums of the estimated parameters of the fit: derivatives by parameters.
    pub shares: DMatrix<f64>,
    pub windows: Vec<String>,
    /// Whether its constant is the mean of one constant per window.
    pub mean_constant: bool,
}

/// An exported parameter as a sum of estimated ones: a constant of one window enters by its share of the samples, a derivative by
/// `q c/2V` by what it is by the pitch rate of the exports.
struct Row {
    name: String,
    term: Term,
    /// Index of an estimated parameter and its factor.
    shares: Vec<(usize, f64)>,
}

/// One fit as part of a model.
pub(crate) fn identified(
    fit: &CoefficientFit,
    terms: &[Term],
    reference: &ReferenceGeometry,
) -> StageResult<IdentifiedCoefficient> {
    let name = fit.coefficient.name();
    let refuse = |error: &StageError| StageError::Failed(format!("{name} has no estimate: {error}"));
    let estimate = fit.fit.as_ref().map_err(refuse)?;
    let total: usize = fit.windows.iter().map(|(_, samples)| samples).sum();
    let constant = Term::constant().derivative_name(fit.coefficient);
    let mut rows: Vec<Row> = Vec::new();
    let mut add = |name: String, term: Term, share: (usize, f64)| match rows.iter_mut().find(|row| row.name == name) {
        Some(row) => row.shares.push(share),
        None => rows.push(Row { name, term, shares: vec![share] }),
    };
    for (column, estimated) in estimate.names.iter().enumerate() {
        let of_window = estimated.strip_prefix(&constant).and_then(|rest| rest.strip_prefix('[')?.strip_suffix(']'));
        let Some(window) = of_window else {
            let term = terms.iter().find(|term| term.derivative_name(fit.coefficient) == *estimated).cloned();
            let term = term.ok_or_else(|| format!("{name}: '{estimated}' has no term"))?;
            let (term, factor) = with_one_pitch_rate(&term, reference);
            add(term.derivative_name(fit.coefficient), term, (column, factor));
            continue;
        };
        let samples = fit.windows.iter().find(|(name, _)| name == window).map_or(0, |(_, samples)| *samples);
        let share = (column, samples as f64 / total.max(1) as f64);
        add(constant.clone(), Term::constant(), share);
    }
    let transform = DMatrix::from_fn(rows.len(), estimate.parameters(), |row, column| {
        rows[row].shares.iter().filter(|(index, _)| *index == column).map(|(_, share)| share).sum()
    });
    let errors = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(&fit.corrected_errors));
    let covariance = &transform * &errors * &estimate.correlation * &errors * transform.transpose();
    let sigma: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect();
    let correlation = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
        let held = sigma[i] * sigma[j] == 0.0;
        if i == j {
            1.0
        } else if held {
            0.0
        } else {
            (covariance[(i, j)] / (sigma[i] * sigma[j])).clamp(-1.0, 1.0)
        }
    });
    let mean_constant = rows.iter().any(|row| row.term.is_constant() && row.shares.len() > 1);
    let parameters = rows.into_iter().zip(&sigma).map(|(Row { name, term, shares }, &standard_error)| Parameter {
        name,
        term,
        value: shares.iter().map(|&(column, share)| share * estimate.estimates[column]).sum(),
        standard_error,
    });
    Ok(IdentifiedCoefficient {
        coefficient: fit.coefficient,
        parameters: parameters.collect(),
        correlation,
        shares: transform,
        windows: fit.windows.iter().map(|(name, _)| name.clone()).collect(),
        mean_constant,
    })
}

/// A term with `q c/2V` as one of the pitch rate of the other terms, and the factor from its derivative to that of the new term.
fn with_one_pitch_rate(term: &Term, reference: &ReferenceGeometry) -> (Term, f64) {
    let power = term.factors().iter().find(|(variable, _)| *variable == Variable::HalfPitchRate).map_or(0, |&(_, p)| p);
    let others = term.factors().iter().copied().filter(|(variable, _)| *variable != Variable::HalfPitchRate);
    let factor = 0.5 * reference.chord_m / reference.pitch_rate_length_m;
    (Term::product(others.chain([(Variable::PitchRate, power)])), factor.powi(power))
}

#[cfg(test)]
mod tests {
    use doublet_core::estimate::least_squares;

    use super::*;

    #[test]
    fn derivative_by_half_the_pitch_rate_is_exported_by_the_pitch_rate_of_the_others() {
        let terms = ["1", "qc/2V", "alpha*qc/2V^2"].map(|text| Term::parse(text).unwrap());
        let names: Vec<String> = terms.iter().map(|term| term.derivative_name(Coefficient::Cm)).collect();
        assert_eq!(names[1..], ["Cm_qhat", "Cm_alpha_qhat2"]);
        let x = DMatrix::from_fn(40, 3, |row, column| (row as f64 * 0.3 * column as f64).cos());
        let z: Vec<f64> = (0..40).map(|row| f64::from(row % 7)).collect();
        let fit = least_squares(&names, &x, &z).unwrap();
        let corrected_errors = vec![0.1, 0.2, 0.3];
        let values = fit.estimates.clone();
        let fit = CoefficientFit {
            coefficient: Coefficient::Cm,
            windows: vec![("w".to_owned(), 40)],
            fit: Ok(fit),
            noise_errors: corrected_errors.clone(),
            corrected_errors,
            series: None,
            dropped: Vec::new(),
        };
        let mut reference = ReferenceGeometry::conventional(18.0, 11.0, 1.6);
        let found = identified(&fit, &terms, &reference).unwrap().parameters;
        assert_eq!(found.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["Cm_0", "Cm_q", "Cm_alpha_q2"]);
        assert_eq!([found[1].value, found[2].value], [0.5 * values[1], 0.25 * values[2]]);
        assert!((found[1].standard_error - 0.1).abs() < 1e-15 && (found[2].standard_error - 0.075).abs() < 1e-15);
        reference.pitch_rate_length_m = 0.4;
        let found = identified(&fit, &terms, &reference).unwrap().parameters;
        assert!((found[1].value - values[1] * 2.0).abs() < 1e-15 && (found[2].value - values[2] * 4.0).abs() < 1e-15);
    }
}
