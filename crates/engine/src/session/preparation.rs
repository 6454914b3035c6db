//! How coefficients are formed from the reconstructed path.

use std::hash::{Hash, Hasher};

use doublet_core::hash_fields;
use doublet_core::model::{Axes, Gyroscopic, Lag, ThrustTreatment};
use doublet_core::quantity::HashBits;
use serde::{Deserialize, Serialize};

use super::check::contradiction;
use super::{ErrorValues, InstrumentAccuracy, PathSource, Surface};
use crate::session::Finding;

/// How coefficients are formed from the reconstructed path.
#[derive(Clone, Debug, PartialEq)]
pub struct Preparation {
    /// States used.
    pub path: PathSource,
    /// Half width, s, of the local quadratic that differentiates the rates; `None` for the fourth-order central difference
    /// of thesis Eq. D.1.
    pub differentiation_half_width_s: Option<f64>,
    /// Smooths all else as the differentiation smooths the angular acceleration, so that both sides of the regression lose the
    /// same of the fastest motion.
    pub matched_smoothing: bool,
    /// What the deflections do between their recording and the air.
    pub control_lags: ControlLags,
    /// Seconds left out at the start of every window, where the filter has not settled.
    pub settle_s: f64,
    /// Altitude of the local origin above sea level, m, used where density comes from the standard atmosphere.
    pub origin_altitude_m: f64,
    /// Recorded accelerations are moved from the sensor's place to the centre of gravity.
    pub correct_accelerometer: bool,
    /// Recorded flow angles are corrected for the vane's place.
    pub correct_vanes: bool,
    /// Recorded position and ground velocity are moved from the antenna to the centre of gravity.
    pub correct_antenna: bool,
    /// What of the thrust is taken out of the coefficients (needs thrust, recorded or of the aircraft's engines).
    pub thrust: ThrustTreatment,
    /// Axes of the moment coefficients and of roll and yaw rate among the variables.
    pub axes: Axes,
    /// Point the moments are about.
    pub moment_reference: MomentReference,
    /// Gyroscopic moment of the propellers, where the speed of all of them is known.
    pub gyroscopic: Gyroscopic,
    /// Where the angular acceleration comes from.
    pub angular_acceleration: AngularAcceleration,
    /// Constant errors of the sensors that are known: the samples of step 1 are freed of them.
    pub known_errors: ErrorValues,
    /// How well constant errors of the instruments are known: for the errors of the derivatives.
    pub accuracy: InstrumentAccuracy,
}

hash_fields!(Preparation {
    path, matched_smoothing, control_lags, correct_accelerometer, correct_vanes, correct_antenna, thrust, axes, moment_reference,
    gyroscopic, angular_acceleration, known_errors, accuracy;
    differentiation_half_width_s, settle_s, origin_altitude_m
});

/// Where the angular acceleration comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AngularAcceleration {
    /// The rates are differentiated, and the rest smoothed alike where asked.
    Differentiated,
    /// It is a state of a smoother over each rate, whose bandwidth the likelihood chooses; nothing else is smoothed.
    Smoother,
    /// It is a channel of the recording (roles `p_dot`, `q_dot`, `r_dot`).
    Recorded,
}

/// Point the moments are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MomentReference {
    /// What the aircraft's file states, or the centre of gravity where it states none.
    Aircraft,
    /// The centre of gravity of each sample.
    CentreOfGravity,
    /// A point fixed to the aircraft, datum axes (x aft, y right, z up), m.
    Datum([f64; 3]),
}

impl Hash for MomentReference {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        if let Self::Datum(point) = self {
            point.hash_bits(state);
        }
    }
}

impl MomentReference {
    /// The point in datum axes, m, for an aircraft whose file states `stated`; `None` for the centre of gravity.
    pub fn from_datum_m(self, stated: Option<[f64; 3]>) -> Option<[f64; 3]> {
        match self {
            Self::Aircraft => stated,
            Self::CentreOfGravity => None,
            Self::Datum(point) => Some(point),
        }
    }
}

/// Lag and delay of each control, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Hash)]
pub struct ControlLags {
    pub elevator: Lag,
    pub aileron: Lag,
    pub rudder: Lag,
}

impl ControlLags {
    /// The same first-order lag for all.
    pub fn common(time_constant_s: f64) -> Self {
        let lag = Lag { time_constant_s, delay_s: 0.0 };
        Self { elevator: lag, aileron: lag, rudder: lag }
    }

    /// Time constant of the first-order lag all controls share; `None` where they differ or one has a delay.
    pub(crate) fn shared_s(&self) -> Option<f64> {
        (*self == Self::common(self.elevator.time_constant_s)).then_some(self.elevator.time_constant_s)
    }

    pub fn get(&self, surface: Surface) -> Lag {
        match surface {
            Surface::Elevator => self.elevator,
            Surface::Aileron => self.aileron,
            Surface::Rudder => self.rudder,
        }
    }

    /// With another lag of one control.
    #[must_use]
    pub fn with(mut self, surface: Surface, lag: Lag) -> Self {
        match surface {
            Surface::Elevator => self.elevator = lag,
            Surface::Aileron => self.aileron = lag,
            Surface::Rudder => self.rudder = lag,
        }
        self
    }

    /// In words: `none`, `lag 0.08 s`, `elevator lag 0.05 s and delay 0.01 s, rudder delay 0.02 s`.
    pub fn summary(&self) -> String {
        let part = |what: &str, value: f64| (value != 0.0).then(|| format!("{what} {value} s"));
        if let Some(lag_s) = self.shared_s() {
            return part("lag", lag_s).unwrap_or_else(|| "none".to_owned());
        }
        let one = |surface: Surface| {
            let lag = self.get(surface);
            let parts: Vec<String> =
                [part("lag", lag.time_constant_s), part("delay", lag.delay_s)].into_iter().flatten().collect();
            (!parts.is_empty()).then(|| format!("{} {}", surface.name(), parts.join(" and ")))
        };
        Surface::ALL.into_iter().filter_map(one).collect::<Vec<_>>().join(", ")
    }
}

impl Default for Preparation {
    fn default() -> Self {
        Self {
            path: PathSource::Smoothed,
            differentiation_half_width_s: Some(0.2),
            matched_smoothing: true,
            control_lags: ControlLags::default(),
            settle_s: 0.0,
            origin_altitude_m: 0.0,
            correct_accelerometer: true,
            correct_vanes: true,
            correct_antenna: true,
            thrust: ThrustTreatment::Included,
            axes: Axes::Body,
            moment_reference: MomentReference::Aircraft,
            gyroscopic: Gyroscopic::Signed,
            angular_acceleration: AngularAcceleration::Differentiated,
            known_errors: ErrorValues::default(),
            accuracy: InstrumentAccuracy::default(),
        }
    }
}

/// What is wrong with a preparation.
pub(super) fn findings(preparation: &Preparation) -> Vec<Finding> {
    /// Longest delay of a control that makes sense, s.
    const LONGEST_S: f64 = 10.0;
    let mut found = Vec::new();
    let lags = &preparation.control_lags;
    match lags.shared_s() {
        Some(lag_s) => check_range(&mut found, "actuator_lag_s".to_owned(), lag_s, [0.0, f64::INFINITY]),
        None => {
            for surface in Surface::ALL {
                let (name, lag) = (surface.name(), lags.get(surface));
                check_range(&mut found, format!("control_lag.{name}.lag_s"), lag.time_constant_s, [0.0, f64::INFINITY]);
                check_range(&mut found, format!("control_lag.{name}.delay_s"), lag.delay_s, [-LONGEST_S, LONGEST_S]);
            }
        }
    }
    check_range(&mut found, "settle_s".to_owned(), preparation.settle_s, [0.0, f64::INFINITY]);
    check_range(&mut found, "origin_altitude_m".to_owned(), preparation.origin_altitude_m, [-1000.0, f64::INFINITY]);
    let half_width_s = preparation.differentiation_half_width_s.unwrap_or(1.0);
    check_range(&mut found, "differentiation_half_width_s".to_owned(), half_width_s, [1e-6, f64::INFINITY]);
    if let MomentReference::Datum(point) = preparation.moment_reference {
        point
            .iter()
            .for_each(|&value| check_range(&mut found, "moment_reference".to_owned(), value, [f64::MIN, f64::MAX]));
    }
    found
}

fn check_range(found: &mut Vec<Finding>, field: String, value: f64, [lowest, highest]: [f64; 2]) {
    if !(value.is_finite() && (lowest..=highest).contains(&value)) {
        let upper = if highest.is_finite() { format!("to {highest}") } else { "up".to_owned() };
        let field = format!("preparation.{field}");
        let fix_text = format!("enter a number from {lowest} {upper}");
        let finding = contradiction(field.clone(), format!("{value} is out of range"), &fix_text);
        found.push(finding.with_setting("Noise and filter", field));
    }
}
