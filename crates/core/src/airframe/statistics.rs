//! Statistical mass and inertia of comparable aircraft, beside which an aircraft's own are held.

use serde::Deserialize;

use super::tensor::InertiaTensor;

/// Mass of a component group as a fraction of maximum take-off mass (thesis Tables 5.10-5.11).
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentFraction {
    /// Component group.
    pub name: String,
    /// Mean over comparable aircraft.
    pub mean: f64,
    /// Standard deviation over comparable aircraft.
    pub deviation: f64,
    /// Fraction by each class II method that applies: name and value.
    pub methods: Vec<(String, f64)>,
    /// Mass given to the group in this aircraft, kg.
    pub attributed_kg: f64,
}

/// Radii of gyration without dimension, with the lengths they belong to (thesis Eq. 5.11, Table 5.13).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GyrationRadii {
    /// `2 R_x / b`.
    pub x: f64,
    /// `2 R_y / l`.
    pub y: f64,
    /// `2 R_z / e`, `e = (b + l) / 2`.
    pub z: f64,
    /// Length of the aircraft l, m.
    pub length_m: f64,
}

/// Kinds of aircraft whose masses are spread alike.
///
/// Radii of gyration without dimension, means over aircraft of the kind (UNICADO, weight and balance, after Raymer).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AircraftClass {
    /// One propeller.
    SinglePropeller,
    /// Two propellers.
    TwinPropeller,
    /// Jets at the fuselage.
    FuselageJets,
    /// Two jets under the wing.
    TwoWingJets,
    /// Four jets under the wing.
    FourWingJets,
}

impl AircraftClass {
    crate::named_variants! {
        /// Name on the command line.
        pub name:
            SinglePropeller "single-propeller", TwinPropeller "twin-propeller", FuselageJets "fuselage-jets",
            TwoWingJets "two-wing-jets", FourWingJets "four-wing-jets",
    }

    /// Radii of gyration of an aircraft of this kind, `length_m` long.
    pub fn radii(self, length_m: f64) -> GyrationRadii {
        let [x, y, z] = match self {
            Self::SinglePropeller => [0.25, 0.38, 0.39],
            Self::TwinPropeller => [0.30, 0.40, 0.44],
            Self::FuselageJets => [0.24, 0.34, 0.42],
            Self::TwoWingJets => [0.23, 0.33, 0.45],
            Self::FourWingJets => [0.24, 0.36, 0.44],
        };
        GyrationRadii { x, y, z, length_m }
    }
}

impl ComponentFraction {
    /// Fraction of the maximum take-off mass (kg) that the attributed mass is, less the statistical mean, in standard deviations
    /// of the statistics; `None` where these have no spread.
    pub fn standard_score(&self, max_takeoff_kg: f64) -> Option<f64> {
        (self.deviation > 0.0).then(|| (self.attributed_kg / max_takeoff_kg - self.mean) / self.deviation)
    }
}

impl GyrationRadii {
    /// Class I estimate of the moments of inertia about the centre of gravity for a mass (kg) and a span (m).
    ///
    /// `Ixx = (r_x b/2)^2 m`, `Iyy = (r_y l/2)^2 m`, `Izz = (r_z (b + l)/4)^2 m`; no products. Source: Roskam, Airplane
    /// Design V; thesis Eq. 5.11.
    pub fn inertia(&self, mass_kg: f64, span_m: f64) -> InertiaTensor {
        let moment = |radius: f64, length_m: f64| mass_kg * (radius * length_m / 2.0).powi(2);
        InertiaTensor::diagonal(
            moment(self.x, span_m),
            moment(self.y, self.length_m),
            moment(self.z, (span_m + self.length_m) / 2.0),
        )
    }
}
