//! Moments of inertia from the periods of an aircraft swung as a compound or a bifilar pendulum.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use doublet_core::atmos::STANDARD_GRAVITY_M_S2;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{interval_95, within};
use crate::toml_file;

/// Value of the `format` key.
const FORMAT: &str = "doublet swing";
/// Version of the form.
const VERSION: u32 = 1;

/// Swings of an aircraft as their file states them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwingFile {
    format: String,
    version: u32,
    /// Mass of what is measured, kg.
    mass_kg: f64,
    /// Its standard error, kg.
    #[serde(default)]
    mass_error_kg: f64,
    #[serde(default = "gravity")]
    gravity_m_s2: f64,
    #[serde(rename = "swing")]
    swings: Vec<Swing>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Swing {
    name: String,
    axis: Axis,
    /// Tilt of the axis in the plane of symmetry, nose up, deg; of an axis x only.
    #[serde(default)]
    tilt_deg: f64,
    method: Method,
    /// Oscillations that were timed.
    oscillations: u32,
    /// Time of so many oscillations, each measurement, s.
    times_s: Vec<f64>,
    /// Standard error of one time, s.
    #[serde(default)]
    time_error_s: f64,
    /// Mean amplitude over the oscillations, deg.
    #[serde(default)]
    amplitude_deg: f64,
    /// Distance from the axis of rotation to the centre of gravity, m.
    pivot_to_cg_m: Option<f64>,
    #[serde(default)]
    pivot_error_m: f64,
    wire_length_m: Option<f64>,
    #[serde(default)]
    wire_length_error_m: f64,
    /// Distance between the wires, m.
    wire_spacing_m: Option<f64>,
    #[serde(default)]
    wire_spacing_error_m: f64,
    /// Mass of the rig that swings with the aircraft, kg.
    #[serde(default)]
    rig_mass_kg: f64,
    /// Distance from the axis of rotation to the centre of gravity of the rig, m.
    #[serde(default)]
    rig_pivot_to_cg_m: f64,
    /// Moment of inertia of the rig about the axis of rotation, kg m².
    #[serde(default)]
    rig_inertia_kg_m2: f64,
    #[serde(default)]
    rig_inertia_error_kg_m2: f64,
    /// Air inside the aircraft and carried along, kg, in its centre of gravity.
    #[serde(default)]
    air_mass_kg: f64,
    /// Moment of inertia of the air carried along about the centre of gravity, kg m².
    #[serde(default)]
    air_inertia_kg_m2: f64,
    #[serde(default)]
    air_inertia_error_kg_m2: f64,
}

/// Body axis about which the aircraft turns, through its centre of gravity or parallel to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Axis {
    X,
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Method {
    Compound,
    Bifilar,
}

fn gravity() -> f64 {
    STANDARD_GRAVITY_M_S2
}

/// One swing evaluated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SwungRow {
    pub name: String,
    /// Axis in body axes.
    pub axis: [f64; 3],
    /// Period of a small oscillation, s.
    pub period_s: f64,
    /// Its standard error, s.
    pub period_error_s: f64,
    /// Moment of inertia about the axis through the centre of gravity, kg m².
    pub inertia_kg_m2: f64,
    pub standard_error_kg_m2: f64,
    /// What one standard error of each measurement changes, kg m².
    pub contributions_kg_m2: BTreeMap<&'static str, f64>,
}

/// An element of the inertia tensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InertiaRow {
    pub name: &'static str,
    pub value_kg_m2: f64,
    pub standard_error_kg_m2: f64,
    /// 95 % interval, kg m².
    pub interval_kg_m2: [f64; 2],
}

/// What the swings give.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Swung {
    pub swings: Vec<SwungRow>,
    /// Elements that the swings determine: by least squares over all of them.
    pub tensor: Vec<InertiaRow>,
    /// Square sum of the residuals over their covariance, and degrees of freedom; none where no swing is left over.
    pub chi_squared: Option<f64>,
    /// Swings less elements.
    pub degrees_of_freedom: usize,
}

/// Measured numbers of a swing with their standard errors, in the order of [`NAMES`].
type Measured = [(f64, f64); 7];

/// Names of the measured numbers.
const NAMES: [&str; 7] =
    ["period", "mass", "pivot to centre of gravity", "wire length", "wire spacing", "rig inertia", "air inertia"];
/// Place of the mass, which all swings share.
const MASS: usize = 1;

impl SwingFile {
    /// Reads a file.
    pub fn open(path: &Path) -> Result<Self, String> {
        toml_file::open(path, Self::parse)
    }

    /// Reads the text of a file.
    pub fn parse(text: &str) -> Result<Self, String> {
        let file: Self = toml_file::parse(text, (FORMAT, VERSION), |file: &Self| (&file.format, file.version))?;
        if file.swings.is_empty() {
            return Err("it has no [[swing]]: add one".to_owned());
        }
        Ok(file)
    }

    /// Moment of inertia of every swing, and the tensor by all of them.
    pub fn evaluate(&self) -> Result<Swung, String> {
        within("mass_kg", self.mass_kg, (1e-3, 1e6), "kg")?;
        within("mass_error_kg", self.mass_error_kg, (0.0, self.mass_kg), "kg")?;
        within("gravity_m_s2", self.gravity_m_s2, (9.0, 10.0), "m/s²")?;
        let mut rows = Vec::with_capacity(self.swings.len());
        let mut by_mass = Vec::with_capacity(self.swings.len());
        for swing in &self.swings {
            let named = |error| format!("swing '{}': {error}", swing.name);
            let (row, slope) = self.swing(swing).map_err(named)?;
            rows.push(row);
            by_mass.push(slope);
        }
        let (tensor, chi_squared) = tensor(&rows, &by_mass);
        let degrees_of_freedom = if tensor.is_empty() { 0 } else { rows.len() - tensor.len() };
        Ok(Swung {
            chi_squared: chi_squared.filter(|_| degrees_of_freedom > 0),
            degrees_of_freedom,
            tensor,
            swings: rows,
        })
    }

    /// One swing, and the change of its inertia by one standard error of the mass.
    fn swing(&self, swing: &Swing) -> Result<(SwungRow, f64), String> {
        swing.check()?;
        let (period_s, period_error_s) = swing.period()?;
        let about = |value: Option<f64>, error: f64| (value.unwrap_or(0.0), error);
        let measured: Measured = [
            (period_s, period_error_s),
            (self.mass_kg, self.mass_error_kg),
            about(swing.pivot_to_cg_m, swing.pivot_error_m),
            about(swing.wire_length_m, swing.wire_length_error_m),
            about(swing.wire_spacing_m, swing.wire_spacing_error_m),
            (swing.rig_inertia_kg_m2, swing.rig_inertia_error_kg_m2),
            (swing.air_inertia_kg_m2, swing.air_inertia_error_kg_m2),
        ];
        let values = measured.map(|(value, _)| value);
        let inertia_kg_m2 = swing.inertia(values, self.gravity_m_s2);
        if !(inertia_kg_m2.is_finite() && inertia_kg_m2 > 0.0) {
            return Err(format!("its moment of inertia would be {inertia_kg_m2:.4} kg m²: check lengths and times"));
        }
        // Half the change from one standard error below to one above: exact to the second order.
        let changes = std::array::from_fn::<f64, 7, _>(|place| {
            let at = |sign: f64| {
                let mut moved = values;
                moved[place] += sign * measured[place].1;
                swing.inertia(moved, self.gravity_m_s2)
            };
            if measured[place].1 > 0.0 { 0.5 * (at(1.0) - at(-1.0)) } else { 0.0 }
        });
        let contributions = NAMES.into_iter().zip(changes).filter(|(_, change)| *change != 0.0);
        let row = SwungRow {
            name: swing.name.clone(),
            axis: swing.axis_body(),
            period_s,
            period_error_s,
            inertia_kg_m2,
            standard_error_kg_m2: changes.iter().map(|change| change * change).sum::<f64>().sqrt(),
            contributions_kg_m2: contributions.map(|(name, change)| (name, change.abs())).collect(),
        };
        Ok((row, changes[MASS]))
    }
}

impl Swing {
    fn check(&self) -> Result<(), String> {
        within("oscillations", f64::from(self.oscillations), (1.0, 1e4), "")?;
        within("amplitude_deg", self.amplitude_deg, (0.0, 45.0), "deg")?;
        within("tilt_deg", self.tilt_deg, (-90.0, 90.0), "deg")?;
        if self.tilt_deg != 0.0 && self.axis != Axis::X {
            return Err("tilt_deg is of an axis x only".to_owned());
        }
        if self.times_s.is_empty() {
            return Err("times_s has no time".to_owned());
        }
        for time_s in &self.times_s {
            within("times_s", *time_s, (1e-2, 1e5), "s")?;
        }
        let needed: &[(&str, Option<f64>)] = match self.method {
            Method::Compound => &[("pivot_to_cg_m", self.pivot_to_cg_m)],
            Method::Bifilar => &[("wire_length_m", self.wire_length_m), ("wire_spacing_m", self.wire_spacing_m)],
        };
        for (key, value) in needed {
            within(key, value.ok_or_else(|| format!("{key} is missing"))?, (1e-3, 1e3), "m")?;
        }
        let errors = [
            ("time_error_s", self.time_error_s),
            ("pivot_error_m", self.pivot_error_m),
            ("wire_length_error_m", self.wire_length_error_m),
            ("wire_spacing_error_m", self.wire_spacing_error_m),
            ("rig_mass_kg", self.rig_mass_kg),
            ("rig_inertia_kg_m2", self.rig_inertia_kg_m2),
            ("rig_inertia_error_kg_m2", self.rig_inertia_error_kg_m2),
            ("air_mass_kg", self.air_mass_kg),
            ("air_inertia_kg_m2", self.air_inertia_kg_m2),
            ("air_inertia_error_kg_m2", self.air_inertia_error_kg_m2),
        ];
        errors.iter().try_for_each(|(key, value)| within(key, *value, (0.0, 1e7), "").map(|_| ()))?;
        within("rig_pivot_to_cg_m", self.rig_pivot_to_cg_m, (-1e3, 1e3), "m").map(|_| ())
    }

    /// Period of a small oscillation and its standard error. The error of the mean time is the larger of that of the scatter and of
    /// `time_error_s`.
    fn period(&self) -> Result<(f64, f64), String> {
        let count = self.times_s.len() as f64;
        let mean_s = self.times_s.iter().sum::<f64>() / count;
        let square = self.times_s.iter().map(|time_s| (time_s - mean_s).powi(2)).sum::<f64>();
        let scatter_s = if count > 1.0 { (square / (count - 1.0) / count).sqrt() } else { 0.0 };
        let error_s = scatter_s.max(self.time_error_s / count.sqrt());
        if error_s == 0.0 {
            return Err("its period has no error: state time_error_s, or time it more than once".to_owned());
        }
        // Period of a pendulum at an amplitude over that of a small one, up to the fourth power.
        let square = self.amplitude_deg.to_radians().powi(2);
        let longer = 1.0 + square / 16.0 + 11.0 * square * square / 3072.0;
        let oscillations = f64::from(self.oscillations) * longer;
        Ok((mean_s / oscillations, error_s / oscillations))
    }

    /// Moment of inertia about the axis through the centre of gravity.
    fn inertia(&self, [period, mass, pivot, length, spacing, rig, air]: [f64; 7], gravity: f64) -> f64 {
        let turned = period * period / (4.0 * PI * PI);
        match self.method {
            Method::Compound => {
                let moment = gravity * (mass * pivot + self.rig_mass_kg * self.rig_pivot_to_cg_m);
                moment * turned - (mass + self.air_mass_kg) * pivot * pivot - rig - air
            }
            Method::Bifilar => {
                let stiffness = gravity * (mass + self.rig_mass_kg) * spacing * spacing / (4.0 * length);
                stiffness * turned - rig - air
            }
        }
    }

    /// Unit vector of the axis.
    fn axis_body(&self) -> [f64; 3] {
        let tilt = self.tilt_deg.to_radians();
        match self.axis {
            Axis::X => [tilt.cos(), 0.0, -tilt.sin()],
            Axis::Y => [0.0, 1.0, 0.0],
            Axis::Z => [0.0, 0.0, 1.0],
        }
    }
}

/// `Ixx, Iyy, Izz, Ixz` by generalised least squares over `I = u' J u` with `J` the tensor, `-Ixz` off its diagonal; the mass is common to
/// all swings, so their errors are correlated. Elements that no swing contains are left out; none where those left are not determined.
fn tensor(rows: &[SwungRow], by_mass: &[f64]) -> (Vec<InertiaRow>, Option<f64>) {
    const ELEMENTS: [&str; 4] = ["Ixx", "Iyy", "Izz", "Ixz"];
    /// Part of an element that counts as contained.
    const CONTAINED: f64 = 1e-9;
    let of_axis = |[x, y, z]: [f64; 3]| [x * x, y * y, z * z, -2.0 * x * z];
    let parts: Vec<[f64; 4]> = rows.iter().map(|row| of_axis(row.axis)).collect();
    let contained = |element: &usize| parts.iter().any(|part| part[*element].abs() > CONTAINED);
    let elements: Vec<usize> = (0..ELEMENTS.len()).filter(contained).collect();
    let x = DMatrix::from_fn(rows.len(), elements.len(), |row, column| parts[row][elements[column]]);
    let z = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.inertia_kg_m2));
    let covariance = DMatrix::from_fn(rows.len(), rows.len(), |row, column| {
        let own = if row == column { rows[row].standard_error_kg_m2.powi(2) - by_mass[row].powi(2) } else { 0.0 };
        own + by_mass[row] * by_mass[column]
    });
    let Some(weight) = covariance.cholesky().map(|found| found.inverse()) else { return (Vec::new(), None) };
    let weighted = x.transpose() * &weight;
    let information = &weighted * &x;
    let scale = DVector::from_iterator(elements.len(), information.diagonal().iter().map(|own| own.sqrt()));
    let scaled = DMatrix::from_fn(elements.len(), elements.len(), |row, column| {
        information[(row, column)] / (scale[row] * scale[column])
    });
    // Two swings cannot give three elements: the least eigenvalue of the scaled information is then rounding.
    if scaled.clone().symmetric_eigenvalues().min() < CONTAINED {
        return (Vec::new(), None);
    }
    let Some(inverse) = information.cholesky().map(|found| found.inverse()) else { return (Vec::new(), None) };
    let found = &inverse * (weighted * &z);
    let residual = z - x * &found;
    let chi_squared = (residual.transpose() * weight * &residual)[(0, 0)];
    let elements = elements.iter().enumerate();
    let row = |(place, element): (usize, &usize)| {
        inertia_row(ELEMENTS[*element], found[place], inverse[(place, place)].sqrt())
    };
    (elements.map(row).collect(), Some(chi_squared))
}

fn inertia_row(name: &'static str, value: f64, error: f64) -> InertiaRow {
    InertiaRow { name, value_kg_m2: value, standard_error_kg_m2: error, interval_kg_m2: interval_95(value, error) }
}

#[cfg(test)]
mod tests;
