//! Findings about inputs beyond the range of a chart or map, kept without allocation.

use crate::message;
use crate::message::{Message, written};
use std::fmt;

/// An input of the engine chart or of the propeller map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapVariable {
    /// Engine speed against the speed lines of the engine chart, rad/s.
    EngineSpeed,
    /// Manifold pressure against the engine chart, Pa.
    ManifoldPressure,
    /// Pressure altitude against the line from sea level to the full-throttle altitude, m.
    PressureAltitude,
    /// Advance ratio against the propeller map.
    AdvanceRatio,
    /// Power coefficient against the propeller map.
    PowerCoefficient,
    /// Engine speed against the propeller map, rad/s.
    PropellerSpeed,
    /// Pressure altitude against the flight levels of the propeller map, m.
    FlightLevel,
}

impl MapVariable {
    crate::named_variants! {
        /// Name in messages.
        pub name:
            EngineSpeed "engine speed", ManifoldPressure "manifold pressure", PressureAltitude "pressure altitude",
            AdvanceRatio "advance ratio", PowerCoefficient "power coefficient", PropellerSpeed "propeller speed",
            FlightLevel "pressure altitude over the propeller map",
    }

    /// SI unit of its values, empty for pure numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::EngineSpeed | Self::PropellerSpeed => "rad/s",
            Self::ManifoldPressure => "Pa",
            Self::PressureAltitude | Self::FlightLevel => "m",
            Self::AdvanceRatio | Self::PowerCoefficient => "",
        }
    }

    /// Unit its values are read in, and the factor to it: engines have tachometers.
    fn shown(self) -> (&'static str, f64) {
        match self {
            Self::EngineSpeed | Self::PropellerSpeed => ("rpm", 60.0 / std::f64::consts::TAU),
            Self::ManifoldPressure => ("hPa", 0.01),
            _ => (self.unit(), 1.0),
        }
    }
}

/// One input beyond the range its chart or map covers; the result is a linear extrapolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffRange {
    /// Which input.
    pub variable: MapVariable,
    /// Its value, in [`MapVariable::unit`].
    pub value: f64,
    /// Lowest value covered.
    pub low: f64,
    /// Highest value covered.
    pub high: f64,
}

impl OffRange {
    /// What was found, in one line.
    pub fn message(&self) -> Message {
        let (unit, factor) = self.variable.shown();
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        // Four significant digits over the six decades between a power coefficient and a pressure.
        let digits = if self.high.abs().max(self.low.abs()) < 10.0 { 4 } else { 1 };
        let excess = self.excess();
        let shown = |value: f64| written(factor * value, format!("{:.digits$}", factor * value));
        message!(
            "{} {}{} is {}{} {} the range {} to {}{}: extrapolated",
            self.variable.name(),
            shown(self.value),
            unit.as_str(),
            shown(excess.abs()),
            unit.as_str(),
            if excess < 0.0 { "below" } else { "above" },
            shown(self.low),
            shown(self.high),
            unit
        )
    }

    /// How far the value lies outside: negative below `low`, positive above `high`, in the unit of the variable.
    pub fn excess(&self) -> f64 {
        if self.value < self.low { self.value - self.low } else { (self.value - self.high).max(0.0) }
    }
}

impl fmt::Display for OffRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.message().fmt(f)
    }
}

/// At most one finding per input, the one furthest outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OffRanges([Option<OffRange>; MapVariable::ALL.len()]);

impl OffRanges {
    /// Notes `value` when it lies outside `low..=high`; a value that is not a number is no finding.
    pub fn check(&mut self, variable: MapVariable, value: f64, low: f64, high: f64) {
        if value < low || value > high {
            self.insert(OffRange { variable, value, low, high });
        }
    }

    /// Keeps the finding that lies further outside.
    fn insert(&mut self, finding: OffRange) {
        let slot = &mut self.0[finding.variable as usize];
        if slot.is_none_or(|kept| kept.excess().abs() < finding.excess().abs()) {
            *slot = Some(finding);
        }
    }

    /// Adds the findings of another result.
    pub fn merge(&mut self, other: &Self) {
        for finding in other.iter() {
            self.insert(*finding);
        }
    }

    /// The findings, in the order of [`MapVariable::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = &OffRange> {
        self.0.iter().flatten()
    }

    /// The finding about `variable`, if any.
    pub fn get(&self, variable: MapVariable) -> Option<&OffRange> {
        self.0[variable as usize].as_ref()
    }

    /// Whether every input was inside its range.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_names_the_variable_and_by_how_much() {
        let mut findings = OffRanges::default();
        findings.check(MapVariable::ManifoldPressure, 50_000.0, 34_000.0, 95_000.0);
        assert!(findings.is_empty());
        findings.check(MapVariable::ManifoldPressure, 30_000.0, 34_000.0, 95_000.0);
        findings.check(MapVariable::ManifoldPressure, 33_000.0, 34_000.0, 95_000.0);
        let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(lines, ["manifold pressure 300.0 hPa is 40.0 hPa below the range 340.0 to 950.0 hPa: extrapolated"]);
        findings.check(MapVariable::PowerCoefficient, 0.02, 0.03, 0.15);
        assert_eq!(
            findings.get(MapVariable::PowerCoefficient).map(ToString::to_string).unwrap(),
            "power coefficient 0.0200 is 0.0100 below the range 0.0300 to 0.1500: extrapolated"
        );
    }
}
