//! Limits of flight.

use serde::{Deserialize, Serialize};

/// Density of the standard atmosphere at sea level, kg/m³.
pub const SEA_LEVEL_KG_M3: f64 = 1.225;

/// Limits of flight as an aircraft file states them; airspeeds are calibrated. What is not stated limits nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FlightEnvelope {
    /// Stall without flaps and power at a load factor of one, m/s.
    pub stall_m_s: Option<f64>,
    /// Mass the stall is stated for, kg.
    pub stall_mass_kg: Option<f64>,
    /// Airspeed at which buffet begins over that of the stall, -.
    pub buffet_over_stall: Option<f64>,
    /// Design manoeuvring airspeed VA, m/s.
    pub manoeuvring_m_s: Option<f64>,
    /// Airspeed in level flight at maximum continuous power VH, m/s.
    pub max_level_m_s: Option<f64>,
    /// Airspeed never to be exceeded VNE, m/s.
    pub never_exceed_m_s: Option<f64>,
    /// Airspeed with flaps extended VFE, m/s.
    pub flaps_extended_m_s: Option<f64>,
    /// Least load factor.
    pub load_factor_low: Option<f64>,
    /// Greatest load factor.
    pub load_factor_high: Option<f64>,
    /// Service ceiling, m.
    pub ceiling_m: Option<f64>,
    /// Power of each engine, W.
    pub engine_power_w: Option<f64>,
    /// Engine speed, rad/s.
    pub engine_speed_rad_s: Option<f64>,
}

/// A limit and how far a condition is from it; negative beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightMargin {
    /// What limits, with its symbol.
    pub limit: &'static str,
    /// Its value: calibrated airspeed (m/s), altitude (m) or load factor.
    pub value: f64,
    /// Distance from it.
    pub margin: f64,
}

/// Calibrated airspeed of a true one, m/s: `V sqrt(rho / rho_0)`, compressibility left out.
pub fn calibrated_m_s(true_airspeed_m_s: f64, density_kg_m3: f64) -> f64 {
    true_airspeed_m_s * (density_kg_m3 / SEA_LEVEL_KG_M3).sqrt()
}

impl FlightEnvelope {
    /// Calibrated airspeed of the stall at a load factor and a mass (kg), `V_s sqrt(n m / m_s)`, m/s.
    pub fn stall_at(&self, load_factor: f64, mass_kg: f64) -> Option<f64> {
        let stated_kg = self.stall_mass_kg.unwrap_or(mass_kg);
        self.stall_m_s.map(|stall| stall * (load_factor.max(0.0) * mass_kg / stated_kg).sqrt())
    }

    /// Greatest load factor at a calibrated airspeed (m/s) and a mass (kg): where the wing stalls, or the structure's.
    pub fn load_factor_at(&self, calibrated_m_s: f64, mass_kg: f64) -> Option<f64> {
        let stalled = self.stall_at(1.0, mass_kg).map(|stall| (calibrated_m_s / stall).powi(2));
        match (stalled, self.load_factor_high) {
            (Some(stalled), Some(high)) => Some(stalled.min(high)),
            (one, other) => one.or(other),
        }
    }

    /// How far a condition is from every limit that is stated: a calibrated airspeed (m/s), an altitude (m), a load factor and a mass (kg).
    pub fn margins(&self, calibrated_m_s: f64, altitude_m: f64, load_factor: f64, mass_kg: f64) -> Vec<FlightMargin> {
        let stall = self.stall_at(load_factor, mass_kg);
        let below =
            |limit, value: Option<f64>, own: f64| value.map(|value| FlightMargin { limit, value, margin: value - own });
        let above =
            |limit, value: Option<f64>, own: f64| value.map(|value| FlightMargin { limit, value, margin: own - value });
        [
            above("stall", stall, calibrated_m_s),
            above("buffet", stall.zip(self.buffet_over_stall).map(|(stall, over)| stall * over), calibrated_m_s),
            below("VNE", self.never_exceed_m_s, calibrated_m_s),
            below("ceiling", self.ceiling_m, altitude_m),
            above("least load factor", self.load_factor_low, load_factor),
            below("greatest load factor", self.load_factor_high, load_factor),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Every number with its name in a file and the range it must be in.
    pub(super) fn numbers(&self) -> [(&'static str, Option<f64>, std::ops::RangeInclusive<f64>, &'static str); 12] {
        const SPEED: (std::ops::RangeInclusive<f64>, &str) = (1.0..=1000.0, "1 to 1000 m/s");
        let speed = |name, value| (name, value, SPEED.0, SPEED.1);
        [
            speed("flight_envelope.stall_m_s", self.stall_m_s),
            ("flight_envelope.stall_mass_kg", self.stall_mass_kg, 1e-3..=1e6, "0.001 to 1000000 kg"),
            ("flight_envelope.buffet_over_stall", self.buffet_over_stall, 1.0..=2.0, "1 to 2"),
            speed("flight_envelope.manoeuvring_m_s", self.manoeuvring_m_s),
            speed("flight_envelope.max_level_m_s", self.max_level_m_s),
            speed("flight_envelope.never_exceed_m_s", self.never_exceed_m_s),
            speed("flight_envelope.flaps_extended_m_s", self.flaps_extended_m_s),
            ("flight_envelope.load_factor_low", self.load_factor_low, -20.0..=1.0, "-20 to 1"),
            ("flight_envelope.load_factor_high", self.load_factor_high, 1.0..=20.0, "1 to 20"),
            ("flight_envelope.ceiling_m", self.ceiling_m, 0.0..=30_000.0, "0 to 30000 m"),
            ("flight_envelope.engine_power_w", self.engine_power_w, 1.0..=1e9, "1 to 1e9 W"),
            ("flight_envelope.engine_speed_rad_s", self.engine_speed_rad_s, 1.0..=1e5, "1 to 100000 rad/s"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stall_grows_with_the_root_of_load_factor_and_mass() {
        // Thesis Table F.2: 36 m/s at the maximum take-off mass of 2100 kg; VA = 69 m/s gives 3.67 before the wing stalls.
        let envelope = FlightEnvelope {
            stall_m_s: Some(36.0),
            stall_mass_kg: Some(2100.0),
            load_factor_high: Some(3.8),
            ceiling_m: Some(5900.0),
            ..FlightEnvelope::default()
        };
        approx::assert_relative_eq!(envelope.stall_at(4.0, 2100.0).unwrap(), 72.0, max_relative = 1e-12);
        approx::assert_relative_eq!(envelope.load_factor_at(69.0, 2100.0).unwrap(), 3.673_611, max_relative = 1e-6);
        assert_eq!(envelope.load_factor_at(80.0, 2100.0), Some(3.8));
        let margins = envelope.margins(40.0, 6000.0, 1.0, 2100.0);
        let margin_to = |limit: &str| margins.iter().find(|own| own.limit == limit).map(|own| own.margin);
        assert_eq!((margin_to("stall"), margin_to("ceiling"), margin_to("VNE")), (Some(4.0), Some(-100.0), None));
        // Half the density of sea level: the true airspeed is the root of two above the calibrated one.
        approx::assert_relative_eq!(calibrated_m_s(2f64.sqrt(), 0.6125), 1.0, max_relative = 1e-12);
    }
}
