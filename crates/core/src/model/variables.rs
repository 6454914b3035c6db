//! Variables of the model over one window, and the regressor matrix of a list of terms.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVectorViewMut};

use super::coefficients::matched_smoothing;
use super::data::{AeroData, Axes, CoefficientSettings, Lag};
use super::{ModelError, RECORDED, Term, Variable};
use crate::prep::{Differentiation, MatchedSmoothing, delay, differentiate, first_order_lag, has_even_steps};
use crate::quantity::Role;
use crate::series::LONG_WINDOW;

/// Columns of the variables that one window offers, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variables {
    samples: usize,
    columns: BTreeMap<Variable, Column>,
    smoothing: Option<MatchedSmoothing>,
    /// Samples that have a row, where stretches are excluded.
    left: Option<Vec<usize>>,
}

/// Values of one variable and, once a term asked for them, the same smoothed: coefficients and fits share them.
#[derive(Clone, Debug)]
struct Column {
    values: Arc<[f64]>,
    smoothed: OnceLock<Vec<f64>>,
    /// Values of the samples that have a row, where some have none.
    left: Option<Arc<[f64]>>,
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        self.values == other.values
    }
}

impl Variables {
    /// Samples of the window that smoothing leaves.
    fn smoothed_rows(&self) -> Range<usize> {
        let reach = self.smoothing.as_ref().map_or(0, MatchedSmoothing::reach);
        reach..self.samples - reach
    }

    /// Number of samples that coefficients and regressors have rows for.
    pub fn rows(&self) -> usize {
        self.left.as_ref().map_or(self.smoothed_rows().len(), Vec::len)
    }

    /// `column`, which has a value for every sample of the window, at the samples that have a row.
    pub fn at_rows<'c>(&self, column: &'c [f64]) -> Cow<'c, [f64]> {
        match &self.left {
            None => Cow::Borrowed(&column[self.smoothed_rows()]),
            Some(left) => Cow::Owned(left.iter().map(|&row| column[row]).collect()),
        }
    }

    /// The variables there are.
    pub fn known(&self) -> impl Iterator<Item = Variable> + '_ {
        self.columns.keys().copied()
    }

    /// The column of a factor of `term`.
    fn column(&self, term: &Term, variable: Variable) -> Result<&Column, ModelError> {
        self.columns
            .get(&variable)
            .ok_or_else(|| ModelError::MissingVariable { term: term.to_string(), variable: variable.name() })
    }

    /// Column of `variable` at those rows, not smoothed, if the window has it.
    pub fn get(&self, variable: Variable) -> Option<&[f64]> {
        self.columns.get(&variable).map(|column| match &column.left {
            Some(left) => &**left,
            None => &column.values[self.smoothed_rows()],
        })
    }
}

/// Forms every variable the data allow: flow angles and their rates, rates without dimension, controls (after the lag
/// the settings give them), propeller pressure, thrust coefficient `Tc = T / (q_dyn S)`, airspeed, altitude, Mach
/// number. Normalisations are those of the reference geometry.
///
/// # Errors
/// As for the coefficients, and a signal that cannot be differentiated or delayed.
pub fn variables(data: &AeroData, settings: &CoefficientSettings) -> Result<Variables, ModelError> {
    data.check()?;
    let reference = &settings.reference;
    let airspeed = &data.airspeed_m_s;
    let mut columns = BTreeMap::new();
    let scaled = |rate: &[f64], length_m: f64| -> Arc<[f64]> {
        rate.iter().zip(airspeed.iter()).map(|(rate, &speed)| rate * (length_m / speed)).collect()
    };
    let smoothing = matched_smoothing(data, settings)?;
    // What is smoothed later need not be smoothed by its differentiation; a formula for even steps takes no rounded stamps.
    let differentiation = match smoothing {
        Some(_) if has_even_steps(&data.time_s) => Differentiation::Central4,
        Some(_) => Differentiation::LocalPolynomial { degree: 2, half_width: 2 },
        None => settings.differentiation,
    };
    let derived = |values: &[f64], column: &str| {
        differentiate(&data.time_s, values, differentiation)
            .map_err(|source| ModelError::Signal { column: column.to_owned(), source })
    };

    columns.insert(Variable::Alpha, Arc::clone(&data.alpha_rad));
    columns.insert(Variable::Beta, Arc::clone(&data.beta_rad));
    let alpha_dot = derived(&data.alpha_rad, "alpha")?;
    columns.insert(Variable::AlphaDot, scaled(&alpha_dot, reference.pitch_rate_length_m));
    let beta_dot = derived(&data.beta_rad, "beta")?;
    columns.insert(Variable::BetaDot, scaled(&beta_dot, reference.lateral_rate_length_m));
    let (roll, yaw) = roll_and_yaw(data, settings.axes);
    columns.insert(Variable::RollRate, scaled(&roll, reference.lateral_rate_length_m));
    columns.insert(Variable::PitchRate, scaled(&data.rates_rad_s[1], reference.pitch_rate_length_m));
    columns.insert(Variable::HalfPitchRate, scaled(&data.rates_rad_s[1], reference.chord_m / 2.0));
    columns.insert(Variable::YawRate, scaled(&yaw, reference.lateral_rate_length_m));
    for (variable, role) in
        [(Variable::Aileron, Role::Aileron), (Variable::Elevator, Role::Elevator), (Variable::Rudder, Role::Rudder)]
    {
        if let Some(deflection) = data.controls.get(&role) {
            columns.insert(variable, lagged(data, settings, role, deflection)?);
        }
    }
    for (variable, role) in RECORDED {
        columns.extend(data.controls.get(&role).map(|values| (variable, Arc::clone(values))));
    }
    columns.insert(Variable::Airspeed, Arc::clone(airspeed));
    for (variable, column) in [
        (Variable::PropellerPressure, &data.propeller_pressure),
        (Variable::Altitude, &data.altitude_m),
        (Variable::Mach, &data.mach),
    ] {
        if let Some(column) = column {
            columns.insert(variable, Arc::clone(column));
        }
    }
    if !data.engines.is_empty() {
        columns.insert(Variable::ThrustCoefficient, thrust_coefficient(data, reference.area_m2).into());
    }
    let mut all = Variables { samples: data.time_s.len(), columns: BTreeMap::new(), smoothing, left: None };
    let reach = all.smoothing.as_ref().map_or(0, MatchedSmoothing::reach);
    all.left = settings.rows_left(&data.time_s, all.smoothed_rows(), reach);
    let column = |values: Arc<[f64]>| {
        let left = all.left.as_ref().map(|left| left.iter().map(|&row| values[row]).collect());
        Column { values, smoothed: OnceLock::new(), left }
    };
    let columns = columns.into_iter().map(|(variable, values)| (variable, column(values))).collect();
    Ok(Variables { columns, ..all })
}

/// Regressor matrix: one row per sample that has one, one column per term, in the order of `terms`; with matched
/// smoothing each term, a product of unsmoothed variables, is smoothed.
///
/// # Errors
/// [`ModelError::MissingVariable`] for a term that needs a variable the window does not have.
pub fn regressors(terms: &[Term], variables: &Variables) -> Result<DMatrix<f64>, ModelError> {
    let mut matrix = DMatrix::from_element(variables.rows(), terms.len(), 1.0);
    let first = variables.smoothed_rows().start;
    // From the values behind the smoothing, of which excluded stretches leave some.
    let fill = |mut regressor: DVectorViewMut<'_, f64>, values: &[f64]| match &variables.left {
        None => regressor.copy_from_slice(values),
        Some(left) => regressor.iter_mut().zip(left).for_each(|(value, row)| *value = values[row - first]),
    };
    for (term, regressor) in terms.iter().zip(matrix.column_iter_mut()) {
        if let [(variable, 1)] = *term.factors() {
            let column = variables.column(term, variable)?;
            match &variables.smoothing {
                Some(smoothing) if variables.samples > LONG_WINDOW => fill(regressor, &smoothing.apply(&column.values)),
                Some(smoothing) => {
                    fill(regressor, column.smoothed.get_or_init(|| smoothing.apply(&column.values)));
                }
                None => fill(regressor, &column.values),
            }
            continue;
        }
        let mut products = vec![1.0; variables.samples];
        for &(variable, power) in term.factors() {
            let values = &variables.column(term, variable)?.values;
            products.iter_mut().zip(values.iter()).for_each(|(product, value)| *product *= value.powi(power));
        }
        match &variables.smoothing {
            Some(_) if term.is_constant() => {}
            Some(smoothing) => fill(regressor, &smoothing.apply(&products)),
            None => fill(regressor, &products),
        }
    }
    Ok(matrix)
}

/// Roll and yaw rate in the axes of the moments, rad/s.
fn roll_and_yaw(data: &AeroData, axes: Axes) -> (Cow<'_, [f64]>, Cow<'_, [f64]>) {
    let [p, _, r] = &data.rates_rad_s;
    match axes {
        Axes::Body => (Cow::Borrowed(p), Cow::Borrowed(r)),
        Axes::Stability => {
            let (roll, yaw) = p
                .iter()
                .zip(r)
                .zip(data.alpha_rad.iter())
                .map(|((p, r), alpha)| (p * alpha.cos() + r * alpha.sin(), r * alpha.cos() - p * alpha.sin()))
                .unzip();
            (Cow::Owned(roll), Cow::Owned(yaw))
        }
    }
}

/// Deflection after the delay and lag of its control.
fn lagged(
    data: &AeroData,
    settings: &CoefficientSettings,
    role: Role,
    deflection: &Arc<[f64]>,
) -> Result<Arc<[f64]>, ModelError> {
    let lag = settings.control_lags.get(&role).copied().unwrap_or_default();
    if lag == Lag::default() {
        return Ok(Arc::clone(deflection));
    }
    delay(&data.time_s, deflection, lag.delay_s)
        .and_then(|delayed| first_order_lag(&data.time_s, &delayed, lag.time_constant_s))
        .map(Arc::from)
        .map_err(|source| ModelError::Signal { column: role.name().to_owned(), source })
}

/// Thrust of all engines over dynamic pressure and reference area.
fn thrust_coefficient(data: &AeroData, area_m2: f64) -> Vec<f64> {
    (0..data.time_s.len())
        .map(|k| {
            let thrust: f64 = data.engines.iter().map(|engine| engine.thrust_n[k]).sum();
            thrust / (0.5 * data.density_kg_m3[k] * data.airspeed_m_s[k].powi(2) * area_m2)
        })
        .collect()
}
