//! The sensors of one installation and their calibrations, in SI.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::quantity::Role;

/// The instruments of one installation, in SI.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Instruments {
    pub name: String,
    /// Where the numbers come from, and their limits.
    pub notes: Vec<String>,
    /// Control sensors.
    pub control: ControlLinkage,
    /// Air-data pod.
    pub air_data: AirDataCalibration,
    pub fuel_probes: Vec<FuelProbe>,
    /// Noise that signals of this installation are known to have.
    pub noise: BTreeMap<Role, StatedNoise>,
}

/// A standard deviation that a signal is known to have.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedNoise {
    /// Standard deviation of one sample, SI of the role.
    pub std: f64,
    /// Where it is from.
    pub source: String,
    /// It counts whatever steady parts show; otherwise only where they show nothing.
    pub always: bool,
}

/// From the attitudes of sensors on yoke and pulleys to deflections (thesis section 4.1).
#[derive(Clone, Debug, PartialEq)]
pub struct ControlLinkage {
    /// Sensor fixed to the aircraft, which the others are compared with.
    pub reference_sensor: String,
    /// Age of an attitude when it is stamped, s.
    pub latency_s: f64,
    /// Standard deviations of bank, pitch and heading of a sensor, rad.
    pub attitude_noise_rad: [f64; 3],
    /// Radius of the drum the string winds on, m.
    pub drum_radius_m: f64,
    /// Deflection of the downgoing aileron per angle of the yoke, rad/rad.
    pub aileron_slope: f64,
    /// Aileron deflection at zero yoke, rad.
    pub aileron_intercept_rad: f64,
    /// Elevator deflection per travel of the column, rad/m.
    pub elevator_slope_rad_m: f64,
    /// Elevator deflection of the fit at zero travel, rad; the thesis leaves it out.
    pub elevator_intercept_rad: f64,
    /// Length of the column's string with the elevator neutral, m.
    pub string_m: f64,
    /// Distance of the pulley from the column's line, m.
    pub offset_m: f64,
    /// Ratio of the greatest inboard to the greatest outboard deflection of a rudder.
    pub outboard_ratio: f64,
    /// Curves of the pedals.
    pub pedals: Vec<PedalCurve>,
    /// Orientations of the sensors.
    pub mounts: Vec<SensorMount>,
}

impl ControlLinkage {
    /// The mount of a sensor.
    pub fn mount(&self, sensor: &str) -> Option<&SensorMount> {
        self.mounts.iter().find(|mount| mount.sensor == sensor)
    }

    /// The curve of a pedal's sensor.
    pub fn pedal(&self, sensor: &str) -> Option<&PedalCurve> {
        self.pedals.iter().find(|pedal| pedal.sensor == sensor)
    }
}

/// Rudder deflection against the displacement of a pedal's string (thesis Table 4.4).
#[derive(Clone, Debug, PartialEq)]
pub struct PedalCurve {
    /// Sensor.
    pub sensor: String,
    /// Polynomial, lowest power first: rad per m to that power.
    pub coefficients: [f64; 6],
    /// Displacements between which it only rises or only falls, m.
    pub range_m: [f64; 2],
}

/// Orientation of a control sensor.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorMount {
    /// Sensor.
    pub sensor: String,
    /// Rows: the sensor's axes in axes of the reference sensor, with the control at neutral, before the rest angle.
    pub sensor_from_reference: [[f64; 3]; 3],
    /// Angle about its z axis at neutral, rad.
    #[serde(default)]
    pub rest_rad: f64,
}

/// Calibrations of the air-data pod (thesis section 4.3).
#[derive(Clone, Debug, PartialEq)]
pub struct AirDataCalibration {
    /// Excess of the measured sideslip, rad.
    pub sideslip_offset_rad: f64,
    /// Lift curve behind the calibration.
    pub lift_curve: LiftCurve,
    /// Calibrations by flight.
    pub pods: Vec<PodCalibration>,
}

/// `CL = CL0 + CL_alpha alpha`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftCurve {
    /// Slope, per rad.
    pub slope_per_rad: f64,
    /// Lift coefficient at zero angle of attack.
    pub at_zero_alpha: f64,
    /// Area it refers to, m², where the file states it.
    pub area_m2: Option<f64>,
}

/// Angle of attack against the pod's number: `alpha = exp(sum_k a_k number^k)` in rad (thesis Table 4.11).
#[derive(Clone, Debug, PartialEq)]
pub struct PodCalibration {
    /// Flight it was made for.
    pub flight: String,
    /// Coefficients of the exponent, lowest power first.
    pub exponent: Vec<f64>,
}

/// What a probe shows for what is in the tank (thesis Tables 4.9-4.10).
#[derive(Clone, Debug, PartialEq)]
pub struct FuelProbe {
    /// Tank.
    pub tank: String,
    /// Fuel in the tank, increasing, kg.
    pub actual_kg: Vec<f64>,
    /// Fuel shown, never decreasing, kg.
    pub displayed_kg: Vec<f64>,
}
