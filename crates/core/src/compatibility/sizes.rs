//! Sizes no aircraft and no air have: numbers in another unit than they were taken for.

use super::line::Figures;
use super::motion::Motion;
use super::outcome::Outcome;
use super::traces::{Trace, most_telling};
use crate::quantity::Role::{self, *};

/// Part of the samples that may lie beyond the limits: spikes.
const BEYOND: f64 = 0.1;

/// Limits of a quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub role: Role,
    /// Lowest and highest value, SI.
    range: (f64, f64),
    /// The same in words.
    pub limits: &'static str,
}

/// A quarter turn, rad.
const QUARTER: f64 = 1.571;

/// Limits of every quantity that has some.
pub(super) const SIZES: &[Size] = &[
    Size { role: PitchAngle, range: (-QUARTER, QUARTER), limits: "the range of a pitch angle, +-90 deg" },
    Size { role: BankAngle, range: (-6.3, 6.3), limits: "the range of a bank angle, +-180 deg" },
    Size { role: AngleOfAttack, range: (-QUARTER, QUARTER), limits: "the range of an angle of attack, +-90 deg" },
    Size { role: Sideslip, range: (-QUARTER, QUARTER), limits: "the range of a sideslip, +-90 deg" },
    Size { role: Aileron, range: (-QUARTER, QUARTER), limits: "the range of a deflection, +-90 deg" },
    Size { role: Elevator, range: (-QUARTER, QUARTER), limits: "the range of a deflection, +-90 deg" },
    Size { role: Rudder, range: (-QUARTER, QUARTER), limits: "the range of a deflection, +-90 deg" },
    Size { role: AirTemperature, range: (170.0, 340.0), limits: "temperatures of the air, 170 to 340 K" },
    Size { role: StaticPressure, range: (1e3, 1.15e5), limits: "pressures of the air, 10 to 1150 hPa" },
    Size { role: AirDensity, range: (0.02, 1.7), limits: "densities of the air, 0.02 to 1.7 kg/m3" },
];

impl Size {
    /// The channel, and the nearest value it can have.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        let column = motion.column(self.role)?;
        let segment = most_telling(motion, |segment| segment.len() as f64)?;
        let point = |k: usize| (motion.time_s[k], column[k], column[k].clamp(self.range.0, self.range.1));
        Some(Trace::new(segment.map(point)))
    }

    /// Whether the samples of all segments lie inside.
    pub(super) fn judge(&self, motion: &Motion) -> Outcome {
        let Some(column) = motion.column(self.role) else { return Outcome::Absent };
        let mut values: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
        if values.is_empty() {
            return Outcome::Undetermined;
        }
        let is_inside = |value: f64| (self.range.0..=self.range.1).contains(&value);
        let outside = match motion.turn(self.role) {
            Some(turn) if is_inside(turn) => 0,
            _ => values.iter().filter(|value| !is_inside(**value)).count(),
        };
        let last = values.len() - 1;
        values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let largest = values[last - last / 100];
        let figures =
            Figures { slope: largest, r2: 1.0, disagreement: 4.0, segments: motion.segments.len(), predicted: true };
        if outside as f64 > BEYOND * values.len() as f64 { Outcome::Differs(figures) } else { Outcome::Fits(figures) }
    }
}
