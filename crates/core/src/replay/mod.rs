//! Flight of a model from recorded controls: six degrees of freedom in the air, engines, wind and loading of one window.
//!
//! A [`Replay`] holds what does not depend on the model; [`Replay::fly`] integrates the motion that a set of derivatives gives
//! from a start, [`Replay::fly_axis`] that of one axis with the other as recorded. It is the simulation of output error and of
//! the proof of match.

mod axis;
mod error;
mod fly;
mod forces;
mod sample;
mod steady;

pub use axis::{Correction, Motion, MotionAxis};
pub use error::ReplayError;
pub use fly::Response;
pub use forces::{Forces, Instant, Loads};
pub use sample::Sample;
pub use steady::{SteadyCondition, SteadyTrim};

use std::sync::Arc;

use crate::airframe::ReferenceGeometry;
use crate::model::{AeroData, Axes, Coefficient, CoefficientSettings, Derivatives, Variable, Variables, variables};
use crate::motion::State;
use nalgebra::Vector3;

/// Where a replay starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Position in local Earth axes, m.
    pub position_ned_m: [f64; 3],
    /// Velocity relative to the air in body axes, m/s.
    pub air_velocity_body_m_s: [f64; 3],
    /// Bank, pitch and heading angle, rad.
    pub euler_rad: [f64; 3],
    /// Roll, pitch and yaw rate, rad/s.
    pub rates_rad_s: [f64; 3],
}

/// One window made ready to be flown: controls, air, engines and loading over time.
#[derive(Clone, Debug)]
pub struct Replay {
    time_s: Arc<[f64]>,
    samples: Vec<Sample>,
    reference: ReferenceGeometry,
    axes: Axes,
    gravity_m_s2: f64,
    altitude_at_start_m: f64,
    available: Vec<Variable>,
}

impl Replay {
    /// Prepares a window. `data` and `settings` are those its coefficients were formed with, so that reference lengths, moment
    /// reference, axes, thrust, rotors and lags of the controls enter the motion as they entered the coefficients; its motion
    /// columns are not used. `wind_ned_m_s` is the velocity of the air over the ground at each sample, m/s.
    ///
    /// Thrust, total-pressure rise (not over dynamic pressure) and air density follow the recording, not the simulated
    /// airspeed and altitude.
    ///
    /// # Errors
    /// What the model refuses about the data, a wind of another length, fewer than two samples, an inertia tensor that is not
    /// positive definite.
    pub fn new(
        data: &AeroData,
        settings: &CoefficientSettings,
        wind_ned_m_s: &[Vec<f64>; 3],
        gravity_m_s2: f64,
    ) -> Result<Self, ReplayError> {
        // A simulation has every sample as it is: nothing is smoothed, nothing left out.
        let every = CoefficientSettings { matched: false, excluded: Vec::new(), ..settings.clone() };
        let variables = variables(data, &every)?;
        if data.time_s.len() < 2 {
            return Err(ReplayError::TooShort { samples: data.time_s.len() });
        }
        for column in wind_ned_m_s {
            if column.len() != data.time_s.len() {
                return Err(ReplayError::WindLength { expected: data.time_s.len(), found: column.len() });
            }
        }
        let samples = (0..data.time_s.len())
            .map(|k| Sample::new(data, settings, &variables, wind_ned_m_s, k))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            time_s: Arc::clone(&data.time_s),
            samples,
            reference: settings.reference,
            axes: settings.axes,
            gravity_m_s2,
            altitude_at_start_m: data.altitude_m.as_ref().map_or(0.0, |altitude| altitude[0]),
            available: available(&variables),
        })
    }

    /// Adds `values`, one per sample, to what every model gives for `coefficient`, one of `CX CY CZ Cl Cm Cn`; replaces what was
    /// added before. Values that are left out are zero.
    pub fn disturb(&mut self, coefficient: Coefficient, values: impl Iterator<Item = f64>) {
        let index = coefficient as usize;
        let values = values.chain(std::iter::repeat(0.0));
        self.samples.iter_mut().zip(values).for_each(|(sample, value)| {
            sample.disturbance.get_mut(index).into_iter().for_each(|entry| *entry = value);
        });
    }

    /// Time of each sample, s.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Refuses a model that cannot fly here: a coefficient of body axes without derivatives, a variable the window lacks.
    ///
    /// # Errors
    /// [`ReplayError::NoCoefficient`] and [`ReplayError::MissingVariable`] with names.
    pub fn check(&self, model: &Derivatives) -> Result<(), ReplayError> {
        self.check_axis(MotionAxis::Both, model)
    }

    /// [`Replay::check`] for a model that flies one axis.
    fn check_axis(&self, axis: MotionAxis, model: &Derivatives) -> Result<(), ReplayError> {
        let missing = model.missing().into_iter().filter(|&coefficient| axis.has(coefficient));
        let missing: Vec<_> = missing.map(|coefficient| coefficient.name()).collect();
        if !missing.is_empty() {
            return Err(ReplayError::NoCoefficient { missing, needed: axis.needs() });
        }
        let lacking = Variable::ALL.iter().filter(|variable| !self.available.contains(variable));
        for &variable in lacking {
            if let Some(term) = model.term_of(variable) {
                return Err(ReplayError::MissingVariable { term: term.to_string(), variable: variable.name() });
            }
        }
        Ok(())
    }

    /// State over the ground that `start` is, in the wind of the first sample.
    fn state(&self, start: &Start) -> State {
        let mut state = State::new(Vector3::from(start.position_ned_m), Vector3::zeros(), start.euler_rad);
        let air_ned = state.body_from_ned().tr_mul(&Vector3::from(start.air_velocity_body_m_s));
        state.velocity_ned_m_s = air_ned + self.samples[0].wind_ned_m_s;
        state.rates_rad_s = Vector3::from(start.rates_rad_s);
        state
    }
}

/// Variables a simulation of the window can give.
fn available(variables: &Variables) -> Vec<Variable> {
    variables.known().collect()
}
