//! The identified model: values, errors and the conditions they hold for.

use std::collections::BTreeMap;

use doublet_core::airframe::{MassProperties, ReferenceGeometry};
use doublet_core::model::{Axes, Coefficient, Derivatives, Gyroscopic, Term, ThrustTreatment, Variable};
use nalgebra::DMatrix;

use super::ExportError;
use crate::graph::StageError;
use crate::run::Snapshot;
use crate::session::{ControlLags, Preparation, Session};
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
    /// Coefficient.
    pub coefficient: Coefficient,
    /// Its derivatives.
    pub parameters: Vec<Parameter>,
    /// Correlation of the derivatives.
    pub correlation: DMatrix<f64>,
    /// Derivatives as sums of the estimated parameters of the fit: derivatives by parameters.
    pub shares: DMatrix<f64>,
    /// Windows it was identified from.
    pub windows: Vec<String>,
    /// Whether its constant is the mean of one constant per window.
    pub mean_constant: bool,
}

/// Everything an export states.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedModel {
    /// Name of the files: the aircraft's, in letters, digits and underscores.
    pub name: String,
    /// Aircraft.
    pub aircraft: String,
    /// Title of the session.
    pub title: String,
    /// Reference area and lengths, and how rates are made dimensionless.
    pub reference: ReferenceGeometry,
    /// Point the moments are about, in datum axes (x aft, y right, z up), m.
    pub moment_reference_datum_m: [f64; 3],
    /// Whether that point is the mean centre of gravity of the windows, the file naming none.
    pub about_centre_of_gravity: bool,
    /// Where the datum axes begin, in words.
    pub datum: String,
    /// Mass properties as flown at the start of the first flight.
    pub mass: MassProperties,
    /// What of the thrust is inside the coefficients.
    pub thrust: ThrustTreatment,
    /// Gyroscopic moment of the propellers the coefficients were formed with.
    pub gyroscopic: Gyroscopic,
    /// What deflections do between their recording and the air.
    pub control_lags: ControlLags,
    /// Coefficients.
    pub coefficients: Vec<IdentifiedCoefficient>,
    /// Least and greatest value of each variable in the windows identified.
    pub ranges: Ranges,
}

impl IdentifiedModel {
    /// The model of the pooled estimate.
    ///
    /// Where each window had its own constant the exported one is their mean weighted by samples, its error and correlation
    /// following linearly. Standard errors are the corrected ones, correlations those of the regressors.
    ///
    /// # Errors
    /// [`ExportError::NoModel`] with what is missing or failed.
    pub fn new(session: &Session, snapshot: &Snapshot) -> Result<Self, ExportError> {
        let refuse = |reason: String| ExportError::NoModel(reason);
        if session.aircraft.is_none() {
            return Err(refuse(crate::stage::NO_AIRCRAFT.to_owned()));
        }
        let pooled = snapshot.pooled.ready().filter(|pooled| !pooled.fits.is_empty());
        let pooled = pooled.ok_or_else(|| {
            refuse("no pooled estimate to export: mark at least one manoeuvre as identification".into())
        })?;
        let loaded = snapshot.aircraft.ready().ok_or_else(|| refuse("the aircraft could not be read".into()))?;
        let reference = loaded.aircraft.reference;
        let coefficients = pooled
            .fits
            .iter()
            .map(|fit| identified(fit, session.structure.terms(fit.coefficient).unwrap_or_default(), &reference))
            .collect::<Result<Vec<_>, _>>()?;
        let on_board = snapshot.on_board(session).ok_or_else(|| refuse("the aircraft could not be read".into()))?;
        let mass = on_board.0.properties;
        let (ranges, mean_cg) = conditions(&coefficients, snapshot);
        let Preparation { thrust, gyroscopic, control_lags, axes, moment_reference, .. } = session.preparation;
        if axes != Axes::Body {
            return Err(refuse(
                "its moments are in stability axes, exports are in body axes: set preparation.axes to \"body\"".into(),
            ));
        }
        let stated = moment_reference.from_datum_m(loaded.aircraft.moment_reference_from_datum_m);
        Ok(Self {
            name: file_name(&loaded.aircraft.name),
            aircraft: loaded.aircraft.name.clone(),
            title: session.title.clone(),
            reference,
            moment_reference_datum_m: stated.or(mean_cg).unwrap_or(mass.cg_from_datum_m),
            about_centre_of_gravity: stated.is_none(),
            datum: loaded.aircraft.datum.clone(),
            mass,
            thrust,
            gyroscopic,
            control_lags,
            coefficients,
            ranges,
        })
    }

    /// The derivatives, to evaluate.
    pub fn derivatives(&self) -> Derivatives {
        let each = |c: &IdentifiedCoefficient| {
            let coefficient = c.coefficient;
            c.parameters.iter().map(move |p| (coefficient, p.term.clone(), p.value)).collect::<Vec<_>>()
        };
        self.coefficients.iter().flat_map(each).collect()
    }

    /// Variables the model depends on, in their order.
    pub fn variables(&self) -> Vec<Variable> {
        let derivatives = self.derivatives();
        Variable::ALL.iter().copied().filter(|&variable| derivatives.term_of(variable).is_some()).collect()
    }
}

/// An exported parameter as a sum of estimated ones: a constant of one window enters by its share of the samples, a derivative by
/// `q c/2V` by what it is by the pitch rate of the exports.
struct Row {
    name: String,
    term: Term,
    /// Index of an estimated parameter and its factor.
    shares: Vec<(usize, f64)>,
}

/// Least and greatest value of variables.
pub type Ranges = BTreeMap<Variable, (f64, f64)>;

/// One fit as part of a model.
pub(crate) fn identified(
    fit: &CoefficientFit,
    terms: &[Term],
    reference: &ReferenceGeometry,
) -> Result<IdentifiedCoefficient, ExportError> {
    let name = fit.coefficient.name();
    let refuse = |error: &StageError| ExportError::NoModel(format!("{name} has no estimate: {error}"));
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
            let term = term.ok_or_else(|| ExportError::NoModel(format!("{name}: '{estimated}' has no term")))?;
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

/// Ranges of the variables over the windows each coefficient was identified from, and the mean centre of gravity there.
fn conditions(coefficients: &[IdentifiedCoefficient], snapshot: &Snapshot) -> (Ranges, Option<[f64; 3]>) {
    let mut ranges = Ranges::new();
    let mut seen: BTreeMap<&str, ([f64; 3], usize)> = BTreeMap::new();
    for coefficient in coefficients {
        for window in &coefficient.windows {
            let Some(aero) = snapshot.windows.get(window).and_then(|results| results.aero.ready()) else { continue };
            let used = |variable: &Variable| {
                *variable == Variable::Airspeed
                    || coefficient.parameters.iter().any(|p| p.term.factors().iter().any(|(v, _)| v == variable))
            };
            for variable in aero.variables.known().filter(used) {
                let range = ranges.entry(variable).or_insert((f64::INFINITY, f64::NEG_INFINITY));
                for value in aero.variables.get(variable).unwrap_or_default() {
                    *range = (range.0.min(*value), range.1.max(*value));
                }
            }
            let samples = aero.data.time_s.len();
            let (sum, count) = (0..samples).fold(([0.0; 3], 0), |(sum, count), k| {
                let cg = aero.data.mass.at(k).cg_from_datum_m;
                (std::array::from_fn(|i| sum[i] + cg[i]), count + 1)
            });
            seen.insert(window, (sum, count));
        }
    }
    let count: usize = seen.values().map(|(_, count)| count).sum();
    let sum = |axis: usize| seen.values().map(|(sum, _)| sum[axis]).sum::<f64>();
    let mean = (count > 0).then(|| std::array::from_fn(|axis| sum(axis) / count as f64));
    (ranges, mean)
}

/// Letters, digits and underscores of a name.
fn file_name(name: &str) -> String {
    let mut result = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() {
            result.push(c);
        } else if !result.ends_with('_') && !result.is_empty() {
            result.push('_');
        }
    }
    let trimmed = result.trim_end_matches('_');
    if trimmed.is_empty() { "model".to_owned() } else { trimmed.to_owned() }
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
