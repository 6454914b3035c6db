//! Standard errors to expect of the derivatives from manoeuvres that are planned.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::MassHistory;
use doublet_core::estimate::{Constraint, ExpectedErrors, PooledRegression, PooledWindow, ResidualNoise};
use doublet_core::model::{
    AeroData, Coefficient, CoefficientSettings, Engine, Gyroscopic, Term, Variables, is_constant_name, regressors,
    variables,
};
use doublet_core::quantity::Role;
use nalgebra::DMatrix;

use super::fly::{FlownInput, Plant, Start};
use super::plan::PlannedManoeuvre;
use super::signal::CONTROLS;
use super::{DesignError, Limits};
use crate::linear::{Condition, UncertainModel};

/// A coefficient with its model, the noise its earlier fit left, and the windows of that fit.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct KnownCoefficient {
    pub coefficient: Coefficient,
    pub terms: Vec<Term>,
    /// Whether each term has a parameter of its own in every window.
    pub per_window: Vec<bool>,
    /// What is known of each term beforehand.
    pub constraints: Vec<Constraint>,
    /// Noise of the observations.
    pub noise: ResidualNoise,
    /// Windows flown so far, with their regressors.
    pub flown: Vec<PooledWindow>,
    /// Whether a manoeuvre of one control alone tells about it: aileron, elevator, rudder, throttle. One of several always does.
    pub tells: [bool; CONTROLS],
}

/// What a design starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// The identified model with the covariance of its derivatives.
    pub model: UncertainModel,
    /// The condition of the trim.
    pub condition: Condition,
    /// Coefficients.
    pub coefficients: Vec<KnownCoefficient>,
    /// How coefficients and regressors are formed.
    pub settings: CoefficientSettings,
    /// Interval between the samples of the fits, s.
    pub step_s: f64,
    /// Standard deviation of the gusts, m/s.
    pub gust_m_s: f64,
    /// How the windows flown began.
    pub starts: Vec<Start>,
    /// Limits of input and motion.
    pub limits: Limits,
}

/// A derivative and the errors to expect of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedDerivative {
    /// Name.
    pub name: String,
    /// Present estimate.
    pub estimate: f64,
    /// Its corrected error now.
    pub present: f64,
    /// Standard error for white residuals; none where the manoeuvres do not excite it.
    pub standard_error: Option<f64>,
    /// The same for residuals of the colour they have.
    pub corrected: Option<f64>,
    /// Mean square of the scatter between the manoeuvres over the variance, for white residuals; one where the scatter is not used.
    pub scatter_share: f64,
}

/// What manoeuvres say of the derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Derivatives in the order of the structure, constants left out.
    pub derivatives: Vec<ExpectedDerivative>,
    /// Of each coefficient the logarithm of the determinant of the covariance over the squares of the estimates.
    pub log_determinant: f64,
}

impl Prediction {
    /// Error of each derivative over its magnitude, or over twice its present error where it is not told from zero.
    pub fn relative_errors(&self) -> impl Iterator<Item = f64> + '_ {
        self.derivatives
            .iter()
            .map(|derivative| derivative.corrected.map_or(f64::INFINITY, |error| error / derivative.magnitude()))
    }
}

impl ExpectedDerivative {
    /// What its error is compared with.
    pub fn magnitude(&self) -> f64 {
        self.estimate.abs().max(2.0 * self.present)
    }
}

/// Variables of the model over a flight, smoothed as the session smooths them.
///
/// # Errors
/// [`DesignError::Model`] where the flight is too short for the smoothing.
pub fn window_variables(
    flown: &FlownInput,
    plant: &Plant,
    settings: &CoefficientSettings,
) -> Result<Variables, DesignError> {
    Ok(variables(&window_data(flown, plant), &designed_settings(settings))?)
}

/// Settings of a session for a flight as designed: its deflections are those in the air, lags between a recording and the air are not in them,
/// and its engines have no rotors.
pub fn designed_settings(settings: &CoefficientSettings) -> CoefficientSettings {
    CoefficientSettings {
        control_lags: BTreeMap::new(),
        excluded: Vec::new(),
        gyroscopic: Gyroscopic::Ignored,
        ..settings.clone()
    }
}

/// Columns of a flight for the coefficients, without errors of instruments.
pub fn window_data(flown: &FlownInput, plant: &Plant) -> AeroData {
    let condition = &plant.trim.condition;
    let column = |of: &dyn Fn(usize) -> f64| -> Arc<[f64]> { (0..flown.time_s.len()).map(of).collect() };
    let airspeed_m_s = column(&|k| flown.air[k][0]);
    let roles = [Role::Aileron, Role::Elevator, Role::Rudder];
    let controls: BTreeMap<Role, Arc<[f64]>> =
        roles.into_iter().enumerate().map(|(surface, role)| (role, column(&|k| flown.inputs[k][surface]))).collect();
    let engine = |line: &crate::linear::ThrustLine| Engine {
        thrust_n: column(&|k| line.share * flown.inputs[k][3]),
        position: line.position,
        direction_body: line.direction_body,
        rotor_inertia_kg_m2: 0.0,
        speed_rad_s: Arc::default(),
    };
    AeroData {
        alpha_rad: column(&|k| flown.air[k][1]),
        beta_rad: column(&|k| flown.air[k][2]),
        rates_rad_s: [3, 4, 5].map(|state| column(&|k| flown.states[k][state]).to_vec()),
        specific_force_m_s2: [0, 1, 2].map(|axis| column(&|k| flown.specific_force_m_s2[k][axis]).to_vec()),
        accelerometer: None,
        angular_acceleration_rad_s2: None,
        density_kg_m3: flown.density_kg_m3.as_slice().into(),
        controls,
        mass: MassHistory::Constant(condition.mass),
        engines: plant.model.engines.iter().map(engine).collect(),
        propeller_pressure: Some(column(&|k| {
            condition.pressure_rise_pa / (0.5 * flown.density_kg_m3[k] * flown.air[k][0].powi(2))
        })),
        altitude_m: Some(column(&|k| flown.states[k][11])),
        mach: Some(column(&|k| flown.air[k][0] / flown.speed_of_sound_m_s[k])),
        time_s: flown.time_s.as_slice().into(),
        airspeed_m_s,
    }
}

/// Variation of a regressor below which it counts as resting.
const RESTS: f64 = 1e-10;

impl Basis {
    /// The same with only those of the windows flown whose name passes.
    #[must_use]
    pub fn of_windows(&self, keep: impl Fn(&str) -> bool) -> Self {
        let mut part = self.clone();
        part.coefficients.iter_mut().for_each(|known| known.flown.retain(|window| keep(&window.label)));
        part
    }

    /// The manoeuvres as windows of one coefficient's regression: regressors of those that tell about it.
    fn windows(
        &self,
        known: &KnownCoefficient,
        manoeuvres: &[(&PlannedManoeuvre, &Variables)],
    ) -> Result<Vec<PooledWindow>, DesignError> {
        let tells = |manoeuvre: &PlannedManoeuvre| match manoeuvre.surfaces.as_slice() {
            [surface] => known.tells.get(*surface).copied().unwrap_or(true),
            _ => true,
        };
        let used = manoeuvres.iter().enumerate().filter(|(_, (manoeuvre, _))| tells(manoeuvre));
        used.map(|(index, (manoeuvre, variables))| {
            let x = regressors(&known.terms, variables)?;
            Ok(PooledWindow { label: format!("{} {}", index + 1, manoeuvre.name), z: vec![0.0; x.nrows()], x })
        })
        .collect()
    }

    /// What the manoeuvres will say, `with_flown` together with what the windows flown so far say.
    ///
    /// # Errors
    /// Regressors that cannot be formed.
    pub fn predict(
        &self,
        manoeuvres: &[(&PlannedManoeuvre, &Variables)],
        with_flown: bool,
    ) -> Result<Prediction, DesignError> {
        let mut prediction = Prediction::default();
        for known in &self.coefficients {
            let mut windows = self.windows(known, manoeuvres)?;
            if with_flown {
                windows.extend(known.flown.iter().cloned());
            }
            let (expected, kept) = expected_errors(known, windows)?;
            for term in known.terms.iter().filter(|term| !term.is_constant()) {
                let name = term.derivative_name(known.coefficient);
                let Some(index) = self.model.names.iter().position(|known| *known == name) else { continue };
                let found = expected.as_ref().and_then(|errors| {
                    let at = errors.names.iter().position(|known| *known == name)?;
                    Some((errors.standard_errors[at], errors.corrected_errors[at], errors.scatter_shares[at]))
                });
                prediction.derivatives.push(ExpectedDerivative {
                    estimate: self.model.values()[index],
                    present: self.model.standard_error(index),
                    standard_error: found.map(|found| found.0),
                    corrected: found.map(|found| found.1),
                    scatter_share: found.map_or(1.0, |found| found.2),
                    name,
                });
            }
            let count = known.terms.iter().filter(|term| !term.is_constant()).count();
            prediction.log_determinant += match &expected {
                Some(errors) if kept == count => self.scaled_log_determinant(errors),
                _ => f64::INFINITY,
            };
        }
        Ok(prediction)
    }

    /// Logarithm of the determinant of the covariance of the derivatives, each over its magnitude.
    fn scaled_log_determinant(&self, errors: &ExpectedErrors) -> f64 {
        let scale = |name: &String| {
            let index = self.model.names.iter().position(|known| known == name)?;
            Some(self.model.values()[index].abs().max(2.0 * self.model.standard_error(index)))
        };
        let places: Vec<(usize, f64)> = errors
            .names
            .iter()
            .enumerate()
            .filter(|(_, name)| !is_constant_name(name))
            .filter_map(|(index, name)| Some((index, scale(name)?)))
            .collect();
        let scaled = DMatrix::from_fn(places.len(), places.len(), |i, j| {
            errors.covariance[(places[i].0, places[j].0)] / (places[i].1 * places[j].1)
        });
        match scaled.cholesky() {
            Some(factor) => 2.0 * factor.l().diagonal().iter().map(|value| value.ln()).sum::<f64>(),
            None => f64::INFINITY,
        }
    }
}

/// Errors of one coefficient, its resting and fixed terms left out, and how many derivatives stayed; none without windows, and none where
/// what stayed cannot be told apart.
fn expected_errors(
    known: &KnownCoefficient,
    mut windows: Vec<PooledWindow>,
) -> Result<(Option<ExpectedErrors>, usize), DesignError> {
    if windows.is_empty() {
        return Ok((None, 0));
    }
    let moves = |column: usize| {
        windows.iter().any(|window| {
            let values = window.x.column(column);
            values.max() - values.min() > RESTS
        })
    };
    let stays = |index: usize| {
        let fixed = matches!(known.constraints.get(index), Some(Constraint::Fixed(_)));
        !fixed && (known.terms[index].is_constant() || moves(index))
    };
    let kept: Vec<usize> = (0..known.terms.len()).filter(|&index| stays(index)).collect();
    windows.iter_mut().for_each(|window| window.x = window.x.select_columns(&kept));
    let kept_values = |values: &[bool]| kept.iter().map(|&index| values[index]).collect::<Vec<bool>>();
    let regression = PooledRegression {
        names: kept.iter().map(|&index| known.terms[index].derivative_name(known.coefficient)).collect(),
        per_window: kept_values(&known.per_window),
        constraints: kept.iter().map(|&index| known.constraints[index]).collect(),
        windows,
    };
    let derivatives = kept.iter().filter(|&&index| !known.terms[index].is_constant()).count();
    match known.noise.expected(&regression) {
        Ok(errors) => Ok((Some(errors), derivatives)),
        Err(doublet_core::estimate::EstimateError::RankDeficient { .. }) => Ok((None, 0)),
        Err(source) => Err(DesignError::Estimate { coefficient: known.coefficient.name(), source }),
    }
}
