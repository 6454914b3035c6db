//! The identified model: values, errors and the conditions they hold for.

use std::collections::BTreeMap;

use doublet_core::airframe::{MassProperties, ReferenceGeometry};
use doublet_core::model::{Axes, Derivatives, Gyroscopic, ThrustTreatment, Variable};

use super::ExportError;
use crate::session::{ControlLags, Preparation, Session};
use crate::snapshot::Snapshot;
use crate::study::{IdentifiedCoefficient, identified};

/// Everything an export states.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedModel {
    /// Name of the files: the aircraft's, in letters, digits and underscores.
    pub name: String,
    pub aircraft: String,
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
    pub coefficients: Vec<IdentifiedCoefficient>,
    /// Least and greatest value of each variable in the windows identified.
    pub ranges: Ranges,
}

impl IdentifiedModel {
    /// The model of the pooled estimate.
    ///
    /// Where each window had its own constant the exported one is their mean weighted by samples, its error and correlation
    /// following linearly. Standard errors are the corrected ones, correlations those of the regressors.
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
            .map(|fit| {
                identified(fit, session.structure.terms(fit.coefficient).unwrap_or_default(), &reference)
                    .map_err(|error| refuse(error.to_string()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let on_board = snapshot.on_board(session).ok_or_else(|| refuse("the aircraft could not be read".into()))?;
        let mass = on_board.0.properties;
        let (ranges, mean_cg) = conditions(&coefficients, snapshot);
        let Preparation { thrust, gyroscopic, control_lags, axes, moment_reference, .. } = session.preparation;
        if axes != Axes::Body {
            return Err(refuse("moments are in stability axes, exports need body axes: choose body axes".into()));
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

/// Least and greatest value of variables.
pub type Ranges = BTreeMap<Variable, (f64, f64)>;

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
