//! The saved form of the preparation.

use std::collections::BTreeMap;

use doublet_core::model::{Axes, Gyroscopic, Lag, ThrustTreatment};
use serde::{Deserialize, Serialize};
use toml::Value;

use super::super::{AngularAcceleration, ControlLags, MomentReference, PathSource, Preparation, Surface};
use super::{SessionError, choose, unknown};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PreparationTable {
    path: PathSource,
    differentiation: String,
    differentiation_half_width_s: f64,
    matched_smoothing: bool,
    actuator_lag_s: f64,
    settle_s: f64,
    origin_altitude_m: f64,
    correct_accelerometer: bool,
    correct_vanes: bool,
    correct_antenna: bool,
    /// `true`, `false`, or `"force"` to leave the moment of the thrust in.
    remove_thrust: Value,
    #[serde(skip_serializing_if = "is_usual")]
    axes: Option<Axes>,
    /// `"aircraft"`, `"centre_of_gravity"` or a point in datum axes, m.
    #[serde(skip_serializing_if = "is_usual")]
    moment_reference: Option<Value>,
    #[serde(skip_serializing_if = "is_usual")]
    gyroscopic: Option<Gyroscopic>,
    #[serde(skip_serializing_if = "is_usual")]
    angular_acceleration: Option<AngularAcceleration>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    control_lag: BTreeMap<String, LagTable>,
}

/// Lag of one control.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct LagTable {
    lag_s: f64,
    delay_s: f64,
}

/// Settings that are as they were before they could be set are not written.
fn is_usual<T>(setting: &Option<T>) -> bool {
    setting.is_none()
}

const DIFFERENTIATIONS: [&str; 2] = ["local_quadratic", "central"];
/// Value of `remove_thrust` that leaves its moment in.
const FORCE: &str = "force";
/// Names of the moment references that are no point.
const REFERENCES: [(&str, MomentReference); 2] =
    [("aircraft", MomentReference::Aircraft), ("centre_of_gravity", MomentReference::CentreOfGravity)];

/// Half width of the local quadratic that a session turned to it from the central difference begins with, s.
const DEFAULT_HALF_WIDTH_S: f64 = 0.2;

impl Default for PreparationTable {
    fn default() -> Self {
        preparation_table(&Preparation::default())
    }
}

/// The preparation of a saved form.
pub(super) fn preparation_from(table: &PreparationTable) -> Result<Preparation, SessionError> {
    let half_width = match table.differentiation.as_str() {
        "central" => None,
        "local_quadratic" => Some(table.differentiation_half_width_s),
        other => return Err(unknown("preparation.differentiation", "choice", other, &DIFFERENTIATIONS)),
    };
    let thrust = match &table.remove_thrust {
        Value::Boolean(false) => ThrustTreatment::Included,
        Value::Boolean(true) => ThrustTreatment::Removed,
        Value::String(text) if text == FORCE => ThrustTreatment::ForceRemoved,
        other => return Err(unknown("preparation.remove_thrust", "choice", &shown(other), &["true", "false", FORCE])),
    };
    let mut control_lags = ControlLags::common(table.actuator_lag_s);
    for (name, lag) in &table.control_lag {
        let surfaces = Surface::ALL.map(|surface| (surface.name(), surface));
        let surface = choose(&surfaces, "preparation.control_lag", name)?;
        control_lags = control_lags.with(surface, Lag { time_constant_s: lag.lag_s, delay_s: lag.delay_s });
    }
    let usual = Preparation::default();
    Ok(Preparation {
        path: table.path,
        differentiation_half_width_s: half_width,
        matched_smoothing: table.matched_smoothing,
        control_lags,
        settle_s: table.settle_s,
        origin_altitude_m: table.origin_altitude_m,
        correct_accelerometer: table.correct_accelerometer,
        correct_vanes: table.correct_vanes,
        correct_antenna: table.correct_antenna,
        thrust,
        axes: table.axes.unwrap_or(usual.axes),
        moment_reference: table.moment_reference.as_ref().map_or(Ok(usual.moment_reference), moment_reference)?,
        gyroscopic: table.gyroscopic.unwrap_or(usual.gyroscopic),
        angular_acceleration: table.angular_acceleration.unwrap_or(usual.angular_acceleration),
        known_errors: usual.known_errors,
        accuracy: usual.accuracy,
    })
}

fn moment_reference(value: &Value) -> Result<MomentReference, SessionError> {
    let place = "preparation.moment_reference";
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match value {
        Value::String(name) => choose(&REFERENCES, place, name),
        Value::Array(values) => {
            let point: Option<Vec<f64>> = values.iter().map(number).collect();
            let point = point.and_then(|point| <[f64; 3]>::try_from(point).ok());
            point.map(MomentReference::Datum).ok_or_else(|| SessionError::Term {
                place: place.to_owned(),
                reason: "a point has three numbers: x aft, y right and z up from the datum, in m".to_owned(),
            })
        }
        other => Err(unknown(place, "choice", &shown(other), &["aircraft", "centre_of_gravity", "a point [x, y, z]"])),
    }
}

/// A value as the file has it.
fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The saved form of a preparation.
pub(super) fn preparation_table(preparation: &Preparation) -> PreparationTable {
    let half_width = preparation.differentiation_half_width_s;
    let usual = Preparation::default();
    let lags = &preparation.control_lags;
    let lag = |surface: Surface| {
        let Lag { time_constant_s, delay_s } = lags.get(surface);
        let table = LagTable { lag_s: time_constant_s, delay_s };
        (lags.get(surface) != Lag::default()).then(|| (surface.name().to_owned(), table))
    };
    PreparationTable {
        path: preparation.path,
        differentiation: DIFFERENTIATIONS[usize::from(half_width.is_none())].to_owned(),
        matched_smoothing: preparation.matched_smoothing,
        differentiation_half_width_s: half_width.unwrap_or(DEFAULT_HALF_WIDTH_S),
        actuator_lag_s: lags.shared_s().unwrap_or(0.0),
        control_lag: match lags.shared_s() {
            Some(_) => BTreeMap::new(),
            None => Surface::ALL.into_iter().filter_map(lag).collect(),
        },
        settle_s: preparation.settle_s,
        origin_altitude_m: preparation.origin_altitude_m,
        correct_accelerometer: preparation.correct_accelerometer,
        correct_vanes: preparation.correct_vanes,
        correct_antenna: preparation.correct_antenna,
        remove_thrust: match preparation.thrust {
            ThrustTreatment::Included => Value::Boolean(false),
            ThrustTreatment::Removed => Value::Boolean(true),
            ThrustTreatment::ForceRemoved => Value::String(FORCE.to_owned()),
        },
        axes: (preparation.axes != usual.axes).then_some(preparation.axes),
        moment_reference: match preparation.moment_reference {
            MomentReference::Aircraft => None,
            MomentReference::CentreOfGravity => Some(Value::String("centre_of_gravity".to_owned())),
            MomentReference::Datum(point) => Some(Value::Array(point.map(Value::Float).to_vec())),
        },
        gyroscopic: (preparation.gyroscopic != usual.gyroscopic).then_some(preparation.gyroscopic),
        angular_acceleration: (preparation.angular_acceleration != usual.angular_acceleration)
            .then_some(preparation.angular_acceleration),
    }
}
