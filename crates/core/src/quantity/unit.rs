//! Units by name, converted to SI on the way in.

use thiserror::Error;

/// Physical dimension of a quantity; only units of one dimension convert into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Pure number, ratio or per cent.
    Dimensionless,
    /// Plane angle, rad.
    Angle,
    /// Angular rate, rad/s.
    AngularRate,
    /// Angular acceleration, rad/s².
    AngularAcceleration,
    /// Length, m.
    Length,
    /// Speed, m/s.
    Speed,
    /// Acceleration, m/s².
    Acceleration,
    /// Time, s.
    Time,
    /// Mass, kg.
    Mass,
    /// Mass flow, kg/s.
    MassFlow,
    /// Force, N.
    Force,
    /// Pressure, Pa.
    Pressure,
    /// Absolute temperature, K.
    Temperature,
    /// Density, kg/m³.
    Density,
    /// Power, W.
    Power,
}

impl Dimension {
    /// Symbol of the SI unit of this dimension, as written in tables and files.
    pub fn si_symbol(self) -> &'static str {
        match self {
            Self::Dimensionless => "-",
            Self::Angle => "rad",
            Self::AngularRate => "rad/s",
            Self::AngularAcceleration => "rad/s^2",
            Self::Length => "m",
            Self::Speed => "m/s",
            Self::Acceleration => "m/s^2",
            Self::Time => "s",
            Self::Mass => "kg",
            Self::MassFlow => "kg/s",
            Self::Force => "N",
            Self::Pressure => "Pa",
            Self::Temperature => "K",
            Self::Density => "kg/m^3",
            Self::Power => "W",
        }
    }
}

/// A unit of measurement: `si = value * scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Canonical symbol, for example `kt`.
    pub symbol: &'static str,
    /// Dimension this unit measures.
    pub dimension: Dimension,
    /// Factor to SI.
    pub scale: f64,
    /// Offset to SI, not zero for temperatures only.
    pub offset: f64,
}

/// The unit name is not known.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("unknown unit '{name}': use one of {}", known.join(", "))]
pub struct UnknownUnit {
    /// Name as given.
    pub name: String,
    /// Symbols that would have been understood.
    pub known: Vec<&'static str>,
}

impl Unit {
    /// Value in SI of `value` in this unit.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.scale + self.offset
    }

    /// Value in this unit of `si`.
    pub fn from_si(&self, si: f64) -> f64 {
        (si - self.offset) / self.scale
    }
}
