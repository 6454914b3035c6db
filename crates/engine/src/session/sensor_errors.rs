//! Errors of sensors that are constant over windows: those known, which the samples are freed of, and those asked for.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use doublet_core::estimate::{
    ErrorTerm, Freedom, NoiseModel, OutputErrorSettings, Sensor, SensorError, SensorErrorSettings,
};
use doublet_core::quantity::InstrumentError;
use doublet_core::reconstruct::{FilterData, FilterSettings, Input, Measurement};
use serde::{Deserialize, Serialize};

use super::Session;
use super::check::contradiction;
use crate::session::Finding;

/// Values by error, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorValues(pub BTreeMap<SensorError, f64>);

impl Hash for ErrorValues {
    fn hash<H: Hasher>(&self, state: &mut H) {
        for (error, value) in &self.0 {
            (error, value.to_bits()).hash(state);
        }
    }
}

/// Standard deviations of constant errors of the instruments, SI; what is usual for those left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstrumentAccuracy(pub BTreeMap<InstrumentError, f64>);

impl Hash for InstrumentAccuracy {
    fn hash<H: Hasher>(&self, state: &mut H) {
        for (error, deviation) in &self.0 {
            (error, deviation.to_bits()).hash(state);
        }
    }
}

/// How errors of sensors are estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SensorErrorMethod {
    /// The measurements have noise, by as much as their residuals say.
    #[default]
    OutputError,
    /// Inertial samples and measurements have the noise the filter's settings state.
    FilterError,
}

/// Errors of sensors asked for.
#[derive(Clone, Debug, Default, PartialEq, Hash)]
pub struct SensorErrors {
    /// How they are estimated.
    pub method: SensorErrorMethod,
    /// One value for all windows.
    pub free: Vec<SensorError>,
    /// A value for each window.
    pub per_window: Vec<SensorError>,
    /// Deviation of a random walk on some of them, SI per square root of a second.
    pub random_walk: ErrorValues,
    /// Measurements compared; empty for attitude, air data and height, with a wind all there are.
    pub outputs: Vec<Measurement>,
    /// Whether each window has a wind of its own.
    pub wind: bool,
}

impl SensorErrors {
    /// Whether anything is asked for.
    pub fn is_empty(&self) -> bool {
        self.free.is_empty() && self.per_window.is_empty()
    }

    pub fn compared(&self) -> Vec<Measurement> {
        use Measurement::{PositionEast, PositionNorth, VelocityDown, VelocityEast, VelocityNorth};
        let needs_wind = [PositionNorth, PositionEast, VelocityNorth, VelocityEast, VelocityDown];
        match self.outputs.is_empty() {
            true => Measurement::ALL.into_iter().filter(|m| self.wind || !needs_wind.contains(m)).collect(),
            false => self.outputs.clone(),
        }
    }

    /// The problem they are.
    pub fn settings(&self, filter: &FilterSettings) -> SensorErrorSettings {
        let term = |error: SensorError, freedom| {
            let random_walk = self.random_walk.0.get(&error).copied().unwrap_or(0.0);
            ErrorTerm { error, freedom, value: 0.0, random_walk }
        };
        let common = self.free.iter().map(|&error| term(error, Freedom::Common));
        let own = self.per_window.iter().map(|&error| term(error, Freedom::PerWindow));
        let FilterSettings { process_noise: process, measurement_noise: measurement, random_walk: path, .. } = *filter;
        SensorErrorSettings {
            errors: common.chain(own).collect(),
            outputs: self.compared(),
            wind: self.wind,
            gravity_m_s2: filter.gravity_m_s2,
            noise: match self.method {
                SensorErrorMethod::OutputError => NoiseModel::Residuals,
                SensorErrorMethod::FilterError => NoiseModel::Stated { process, measurement, path },
            },
            search: OutputErrorSettings { relative_step: 1e-3, tolerance: 1e-5, ..OutputErrorSettings::default() },
        }
    }
}

impl ErrorValues {
    fn value(&self, error: SensorError) -> f64 {
        self.0.get(&error).copied().unwrap_or(0.0)
    }

    /// Takes the errors off the samples: `(shown - bias) / (1 + scale)`, of the inertial unit turned by its misalignment.
    pub fn correct(&self, data: &mut FilterData) {
        if self.0.is_empty() {
            return;
        }
        let free = |sensor: Sensor, value: f64| {
            (value - self.value(SensorError::Bias(sensor))) / (1.0 + self.value(SensorError::Scale(sensor)))
        };
        for input in Input::ALL {
            for value in Arc::make_mut(&mut data.inputs.columns[input as usize]) {
                *value = free(Sensor::Input(input), *value);
            }
        }
        for measurement in Measurement::ALL {
            for value in Arc::make_mut(&mut data.measurements[measurement as usize].values) {
                *value = free(Sensor::Measurement(measurement), *value);
            }
        }
        let [ex, ey, ez] = [0, 1, 2].map(|axis| self.value(SensorError::Misalignment(axis)));
        let (forces, rates) = data.inputs.columns.split_at_mut(3);
        for group in [forces, rates] {
            let [along, across, down] = group else { continue };
            let [along, across, down] = [along, across, down].map(Arc::make_mut);
            for ((x, y), z) in along.iter_mut().zip(across).zip(down) {
                (*x, *y, *z) = (*x + ey * *z - ez * *y, *y + ez * *x - ex * *z, *z + ex * *y - ey * *x);
            }
        }
    }
}

/// What is wrong with the stated errors.
pub(super) fn findings(session: &Session) -> Vec<Finding> {
    let errors = &session.sensor_errors;
    let mut found = Vec::new();
    let mut say = |key: &str, error: SensorError, text: String, fix_text: &str| {
        found.push(contradiction(format!("sensor_errors.{key} of {error}"), text, fix_text));
    };
    let asked: Vec<SensorError> = errors.free.iter().chain(&errors.per_window).copied().collect();
    for (index, error) in asked.iter().enumerate() {
        if asked[..index].contains(error) {
            say("free", *error, "listed twice".to_owned(), "remove one");
        }
        if session.preparation.known_errors.0.contains_key(error) {
            say("known", *error, "listed as known and as free".to_owned(), "remove one");
        }
    }
    for (error, walk) in &errors.random_walk.0 {
        if !asked.contains(error) {
            say("random_walk", *error, "not listed as free".to_owned(), "add it to the free errors");
        }
        if !(*walk >= 0.0 && *walk < 1e3) {
            say("random_walk", *error, format!("random walk {walk} must be 0 to 1e3"), "enter a value in this range");
        }
    }
    for (error, value) in &session.preparation.known_errors.0 {
        let is_usable = value.is_finite() && (!matches!(error, SensorError::Scale(_)) || *value > -1.0);
        if !is_usable {
            let text = format!("known error {value} must be finite, a scale error above -1");
            say("known", *error, text, "enter such a value");
        }
    }
    for (error, deviation) in &session.preparation.accuracy.0 {
        if let Err(text) = error.check_deviation(*deviation) {
            let place = format!("sensor_errors.accuracy of {}", error.name());
            found.push(contradiction(place, text, "enter a value in this range"));
        }
    }
    found
}
