//! Calibrations of the sensors of an installation, fitted to what was read on the ground (thesis sections 4.1 to 4.3).
//!
//! Everything here is in the units of an instruments file, in which the readings are taken: degrees, centimetres, pounds.

mod file;
mod fit;

use doublet_core::load::instruments;

pub use file::{calibrations, read, save, with_calibration};
pub use fit::{CalibrationFit, fit, points};

/// A sensor that is calibrated.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SensorKind {
    /// The drum of the pulleys: displacement of the string against the turn of the sensor, whose slope is the radius.
    Drum,
    /// The yoke: deflection of the downgoing aileron against its turn (Fig. 4.4).
    Aileron,
    /// The column: deflection of the elevator against its travel (Fig. 4.6).
    Elevator,
    /// A pedal, by its sensor: deflection of the rudder against the displacement of the string (Fig. 4.8).
    Pedal(String),
    /// The pod in one flight: angle of attack against its number (Fig. 4.13).
    Pod(String),
    /// The fuel probe of a tank: what it shows against what is in the tank (Fig. 4.9 to 4.11).
    Probe(String),
}

/// What leads from a reading to a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// `y = sum_k a_k x^k`, lowest power first.
    Polynomial(Vec<f64>),
    /// `y = exp(sum_k a_k x^k)`, lowest power first.
    Exponential(Vec<f64>),
    /// Straight lines between points.
    Table(Vec<[f64; 2]>),
}

/// A calibration as an instruments file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorCalibration {
    pub kind: SensorKind,
    pub curve: Curve,
    /// Readings between which it is used, where the file or the curve says so.
    pub range: Option<[f64; 2]>,
}

impl SensorKind {
    /// Its name.
    pub fn title(&self) -> String {
        match self {
            Self::Drum => "drum of the pulleys".to_owned(),
            Self::Aileron => "yoke, aileron".to_owned(),
            Self::Elevator => "column, elevator".to_owned(),
            Self::Pedal(sensor) => format!("{}, rudder", sensor.replace('_', " ")),
            Self::Pod(flight) => format!("pod, {flight}"),
            Self::Probe(tank) => format!("fuel probe, {tank}"),
        }
    }

    /// What is read, and what it tells, with units.
    pub fn labels(&self) -> [&'static str; 2] {
        match self {
            Self::Drum => ["turn of the sensor [deg]", "string [mm]"],
            Self::Aileron => ["turn of the yoke [deg]", "aileron [deg]"],
            Self::Elevator => ["travel of the column [cm]", "elevator [deg]"],
            Self::Pedal(_) => ["string [m]", "rudder [deg]"],
            Self::Pod(_) => ["number of the pod", "angle of attack [deg]"],
            Self::Probe(_) => ["fuel in the tank [lb]", "fuel shown [lb]"],
        }
    }

    /// Degree of its polynomial: the least, the usual and the greatest; `None` where it is a table or its form is fixed.
    pub fn degrees(&self) -> Option<[usize; 3]> {
        match self {
            Self::Pedal(_) => Some([1, 5, 5]),
            Self::Pod(_) => Some([1, 2, 6]),
            _ => None,
        }
    }
}

impl Curve {
    /// Value at a reading; beyond a table that of its end.
    pub fn at(&self, x: f64) -> f64 {
        let polynomial = |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, a| sum * x + a);
        match self {
            Self::Polynomial(coefficients) => polynomial(coefficients),
            Self::Exponential(coefficients) => polynomial(coefficients).exp(),
            Self::Table(points) => match points.partition_point(|point| point[0] < x) {
                0 => points.first().map_or(f64::NAN, |point| point[1]),
                after if after == points.len() => points[after - 1][1],
                after => {
                    let ([x0, y0], [x1, y1]) = (points[after - 1], points[after]);
                    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
                }
            },
        }
    }

    /// Points to draw it with between two readings.
    pub fn points(&self, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
        /// Steps a smooth curve is drawn in.
        const STEPS: usize = 160;
        match self {
            Self::Table(points) => points.clone(),
            _ => (0..=STEPS).map(|k| from + (to - from) * k as f64 / STEPS as f64).map(|x| [x, self.at(x)]).collect(),
        }
    }

    /// Its numbers in words: `a0 ... an`, or how many points it has.
    pub fn summary(&self) -> String {
        match self {
            Self::Polynomial(all) | Self::Exponential(all) => {
                all.iter().enumerate().map(|(k, value)| format!("a{k} {value:.4e}")).collect::<Vec<_>>().join(", ")
            }
            Self::Table(points) => format!("{} points, straight between them", points.len()),
        }
    }
}

impl SensorCalibration {
    /// Radius of the drum, mm, where it is one: a turn of one radian draws as much string.
    pub fn drum_radius_mm(&self) -> Option<f64> {
        drum_radius_mm(&self.kind, &self.curve)
    }
}

/// Radius of the drum, mm, that a line of string over degrees has.
fn drum_radius_mm(kind: &SensorKind, curve: &Curve) -> Option<f64> {
    match (kind, curve) {
        (SensorKind::Drum, Curve::Polynomial(line)) => line.get(1).map(|slope| slope.to_degrees()),
        _ => None,
    }
}

/// Checks the text of an instruments file, as the analysis does.
fn check(text: &str) -> Result<(), String> {
    instruments::parse(text).map(drop).map_err(|error| error.to_string().replace('\n', " "))
}
