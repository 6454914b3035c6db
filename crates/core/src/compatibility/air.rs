//! Air data against each other: algebra, sample by sample, through the origin.

use super::line::{Figures, Line};
use super::motion::Motion;
use super::traces::{Trace, most_telling};
use crate::atmos::{
    Atmosphere, GAS_CONSTANT_AIR_J_KG_K, HEAT_CAPACITY_RATIO_AIR, STANDARD_GRAVITY_M_S2, density_kg_m3,
    true_of_calibrated_m_s,
};
use crate::quantity::Role::{self, *};

/// Samples are taken this far apart, s.
const EVERY_S: f64 = 1.0;
/// Tropopause of the standard, m.
const TROPOPAUSE_M: f64 = 11_000.0;

/// A relation between air data.
#[derive(Clone, Copy, Debug)]
pub(super) struct AirRelation {
    /// The channel that is compared.
    pub compared: Role,
    /// With what, in words.
    pub with: &'static str,
    /// Roles without which there is no relation.
    pub needs: &'static [Role],
    /// One of these is needed, too.
    pub one_of: &'static [Role],
    /// Roles that enter where they are recorded.
    pub uses: &'static [Role],
    /// Ratio may differ from one by this much: instruments, position error, weather.
    pub tolerance: f64,
    prediction: fn(&Motion, usize) -> f64,
}

/// Static pressure at a step, Pa: recorded, or standard at the altitude.
fn pressure_pa(m: &Motion, k: usize) -> f64 {
    if m.has(StaticPressure) { m.at(StaticPressure, k) } else { standard_pressure_pa(m, k) }
}

/// Standard pressure at the altitude of a step, Pa; above the tropopause at its temperature of 216.65 K throughout, because feet
/// taken for metres lead there.
fn standard_pressure_pa(m: &Motion, k: usize) -> f64 {
    let (altitude_m, day) = (m.at(Altitude, k), Atmosphere::STANDARD);
    let pressure_pa = day.pressure_pa(altitude_m.min(TROPOPAUSE_M)).unwrap_or(f64::NAN);
    let scale_m = GAS_CONSTANT_AIR_J_KG_K * 216.65 / STANDARD_GRAVITY_M_S2;
    pressure_pa * ((TROPOPAUSE_M - altitude_m).min(0.0) / scale_m).exp()
}

/// Standard temperature at the altitude of a step, K.
fn standard_temperature_k(m: &Motion, k: usize) -> f64 {
    Atmosphere::STANDARD.temperature_k(m.at(Altitude, k).min(TROPOPAUSE_M)).unwrap_or(f64::NAN)
}

/// Static temperature at a step, K: recorded, or standard at the altitude.
fn temperature_k(m: &Motion, k: usize) -> f64 {
    if m.has(AirTemperature) {
        return m.at(AirTemperature, k);
    }
    if m.has(Altitude) {
        return standard_temperature_k(m, k);
    }
    let day = Atmosphere::STANDARD;
    day.altitude_m(m.at(StaticPressure, k)).and_then(|altitude_m| day.temperature_k(altitude_m)).unwrap_or(f64::NAN)
}

/// Speed of sound, m/s; not a number where the temperature is none.
fn sound_m_s(m: &Motion, k: usize) -> f64 {
    (HEAT_CAPACITY_RATIO_AIR * GAS_CONSTANT_AIR_J_KG_K * temperature_k(m, k)).sqrt()
}

/// True airspeed of a calibrated one at a step, m/s.
pub(super) fn true_of_calibrated(m: &Motion, k: usize, calibrated_m_s: f64) -> f64 {
    true_of_calibrated_m_s(calibrated_m_s, pressure_pa(m, k), temperature_k(m, k))
}

/// Every relation of air data.
pub(super) const AIR_RELATIONS: &[AirRelation] = &[
    AirRelation {
        compared: TrueAirspeed,
        with: "Mach number and temperature",
        needs: &[TrueAirspeed, Mach],
        one_of: &[AirTemperature, Altitude],
        uses: &[],
        tolerance: 0.08,
        prediction: |m, k| m.at(Mach, k) * sound_m_s(m, k),
    },
    AirRelation {
        compared: TrueAirspeed,
        with: "calibrated airspeed, pressure and temperature",
        needs: &[TrueAirspeed, CalibratedAirspeed],
        one_of: &[StaticPressure, Altitude],
        uses: &[AirTemperature, Altitude],
        tolerance: 0.12,
        prediction: |m, k| true_of_calibrated(m, k, m.at(CalibratedAirspeed, k)),
    },
    AirRelation {
        compared: AirDensity,
        with: "pressure and temperature",
        needs: &[AirDensity],
        one_of: &[StaticPressure, Altitude],
        uses: &[AirTemperature, Altitude],
        tolerance: 0.12,
        prediction: |m, k| density_kg_m3(pressure_pa(m, k), temperature_k(m, k)).unwrap_or(f64::NAN),
    },
    AirRelation {
        compared: StaticPressure,
        with: "the standard pressure at the altitude",
        needs: &[StaticPressure, Altitude],
        one_of: &[Altitude],
        uses: &[],
        tolerance: 0.08,
        prediction: standard_pressure_pa,
    },
    AirRelation {
        compared: AirTemperature,
        with: "the standard temperature at the altitude",
        needs: &[AirTemperature, Altitude],
        one_of: &[Altitude],
        uses: &[],
        // 30 K from the standard at sea level: beyond, it is another unit or another temperature.
        tolerance: 0.105,
        prediction: standard_temperature_k,
    },
];

impl AirRelation {
    /// Whether every channel it needs is there.
    pub(super) fn applies(&self, motion: &Motion) -> bool {
        self.needs.iter().all(|role| motion.has(*role)) && self.one_of.iter().any(|role| motion.has(*role))
    }

    /// Whether the channel of `role` enters.
    pub(super) fn involves(&self, role: Role) -> bool {
        self.needs.contains(&role) || self.one_of.contains(&role) || self.uses.contains(&role)
    }

    /// The channel and what the others say it is, over the longest segment.
    pub(super) fn trace(&self, motion: &Motion) -> Option<Trace> {
        let column = motion.column(self.compared)?;
        let segment = most_telling(motion, |segment| segment.len() as f64)?;
        Some(Trace::new(segment.map(|k| (motion.time_s[k], column[k], (self.prediction)(motion, k)))))
    }

    /// Compares over all segments together; `None` where no sample can be compared.
    pub(super) fn compare(&self, motion: &Motion) -> Option<Figures> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a second over steps of more than 0.01 s"
        )]
        let every = ((EVERY_S / motion.step_s).round() as usize).max(1);
        let column = motion.column(self.compared)?;
        let steps = motion.segments.iter().flat_map(|segment| segment.clone().step_by(every));
        let pairs = steps.map(|k| ((self.prediction)(motion, k), column[k]));
        let pairs: Vec<_> = pairs.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let line = Line::through(&pairs, true)?;
        Some(Figures {
            slope: line.slope,
            r2: line.r2,
            disagreement: line.disagreement,
            segments: motion.segments.len(),
            predicted: true,
        })
    }
}
