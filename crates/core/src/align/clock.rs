//! A recorder's clock against the reference clock.

use super::AlignError;
use crate::series::Series;

/// A recorder's clock: `t_ref = offset + (1 + drift) t` for its own stamp `t` (thesis section 4.4.3, Table 4.14).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockModel {
    /// Reference time at its own time zero (thesis p0), s.
    pub offset_s: f64,
    /// Gain of the reference on it (thesis p1), seconds per second.
    pub drift: f64,
}

/// Largest drift taken for a clock, s per s: a quartz is a thousand times better.
const MAX_DRIFT: f64 = 0.1;

impl ClockModel {
    /// The reference clock itself.
    pub const REFERENCE: Self = Self { offset_s: 0.0, drift: 0.0 };

    /// A clock of offset `offset_s` (s) and drift `drift` (s per s).
    ///
    /// # Errors
    /// [`AlignError::Setting`] for an offset that is not finite or a drift beyond 0.1 either way.
    pub fn new(offset_s: f64, drift: f64) -> Result<Self, AlignError> {
        if !offset_s.is_finite() {
            return Err(AlignError::Setting { setting: "clock offset", value: offset_s, allowed: "finite, s" });
        }
        if drift.abs() <= MAX_DRIFT {
            return Ok(Self { offset_s, drift });
        }
        Err(AlignError::Setting { setting: "clock drift", value: drift, allowed: "-0.1 to 0.1" })
    }

    /// Reference time of its own stamp, s.
    pub fn reference_s(&self, own_s: f64) -> f64 {
        // Kept as a sum of the stamp and small terms: no digits are lost to the factor.
        own_s + (self.offset_s + self.drift * own_s)
    }

    /// Its own stamp at a reference time, s; the inverse of [`Self::reference_s`].
    pub fn own_s(&self, reference_s: f64) -> f64 {
        (reference_s - self.offset_s) / (1.0 + self.drift)
    }

    /// This clock set forward by `by_s` of reference time: the manual correction, or a channel's known age with its sign
    /// reversed, since a sample stamped `latency` after it was true belongs earlier.
    pub fn shifted(&self, by_s: f64) -> Self {
        Self { offset_s: self.offset_s + by_s, ..*self }
    }

    /// The same samples against the reference clock.
    pub fn align(&self, series: &Series) -> Series {
        let time_s = series.time_s.iter().map(|&own| self.reference_s(own)).collect();
        Series { time_s, values: series.values.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Air-data pod of flight FT1.0, thesis Table 4.14.
    const POD: ClockModel = ClockModel { offset_s: -258.810, drift: -1.43e-4 };

    /// Rounding of times of some thousand seconds, s.
    const ROUNDING_S: f64 = 1e-11;

    #[test]
    fn clock_of_table_4_14_there_and_back_roundtrips() {
        // t_arinc = -258.810 + (1 - 1.43e-4) 3000
        approx::assert_relative_eq!(POD.reference_s(3000.0), 2740.761, epsilon = ROUNDING_S);
        for own in [0.0, 258.8, 5400.0] {
            approx::assert_relative_eq!(POD.own_s(POD.reference_s(own)), own, epsilon = ROUNDING_S);
        }
    }

    #[test]
    fn aligning_moves_stamps_and_leaves_the_samples() {
        let series = Series { time_s: [0.0, 1000.0].into(), values: [4.0, 5.0].into() };
        let aligned = POD.shifted(0.01).align(&series);
        assert!(std::sync::Arc::ptr_eq(&aligned.values, &series.values));
        approx::assert_relative_eq!(aligned.time_s[1], 1000.0 - 258.80 - 0.143, epsilon = ROUNDING_S);
        assert!(matches!(ClockModel::new(0.0, 0.2), Err(AlignError::Setting { setting: "clock drift", .. })));
        assert!(ClockModel::new(f64::NAN, 0.0).is_err());
    }
}
