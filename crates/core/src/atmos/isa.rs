//! International Standard Atmosphere of the troposphere and the lower stratosphere.

use thiserror::Error;

use super::STANDARD_GRAVITY_M_S2;

/// Specific gas constant of dry air, J/(kg K) (ISO 2533).
pub(crate) const GAS_CONSTANT_AIR_J_KG_K: f64 = 287.052_87;
/// Ratio of the specific heats of air (ISO 2533).
pub(crate) const HEAT_CAPACITY_RATIO_AIR: f64 = 1.4;

/// Sea-level pressure of the standard, Pa.
const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;
/// Sea-level temperature of the standard, K.
const SEA_LEVEL_TEMPERATURE_K: f64 = 288.15;
/// Fall of temperature with altitude, K/m.
const LAPSE_RATE_K_M: f64 = 0.006_5;
/// Exponent of the pressure law, g / (R L) = 5.2559.
const PRESSURE_EXPONENT: f64 = STANDARD_GRAVITY_M_S2 / (GAS_CONSTANT_AIR_J_KG_K * LAPSE_RATE_K_M);
/// Lowest altitude of the standard, m.
const LOWEST_M: f64 = -5_000.0;
/// Tropopause, m.
const TROPOPAUSE_M: f64 = 11_000.0;
/// End of the layer of constant temperature above it, m.
const ISOTHERMAL_TOP_M: f64 = 20_000.0;
/// Rise of temperature above that layer, K/m.
const INVERSION_RATE_K_M: f64 = 0.001;
/// Exponent of the pressure law there, g / (R 0.001) = 34.163.
const INVERSION_EXPONENT: f64 = STANDARD_GRAVITY_M_S2 / (GAS_CONSTANT_AIR_J_KG_K * INVERSION_RATE_K_M);
/// Highest altitude of the model, m.
const HIGHEST_M: f64 = 32_000.0;
/// Sea-level temperatures accepted, K: beyond every temperature recorded on Earth.
const TEMPERATURE_RANGE_K: (f64, f64) = (180.0, 340.0);
/// Sea-level pressures accepted, Pa: beyond every pressure recorded on Earth.
const PRESSURE_RANGE_PA: (f64, f64) = (80_000.0, 115_000.0);

/// A value outside the range of the atmosphere model.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{quantity} is {value} {unit}, allowed is {lowest} to {highest} {unit}")]
pub struct AtmosphereError {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// Value given.
    pub value: f64,
    /// Unit of the value.
    pub unit: &'static str,
    /// Lowest value allowed.
    pub lowest: f64,
    /// Highest value allowed.
    pub highest: f64,
}

/// Refuses `value` outside `lowest..=highest`, and what is not a number.
fn within(
    quantity: &'static str,
    value: f64,
    unit: &'static str,
    (lowest, highest): (f64, f64),
) -> Result<f64, AtmosphereError> {
    if (lowest..=highest).contains(&value) {
        Ok(value)
    } else {
        Err(AtmosphereError { quantity, value, unit, lowest, highest })
    }
}

/// A standard atmosphere with the day's pressure and temperature at sea level.
///
/// `T = T0 - L h`, `p = p0 (1 - L h / T0)^(g / (R L))`, `rho = p / (R T)` with L = 6.5 K/km, from -5 to 11 km of
/// geopotential altitude; from there to 20 km `T = T11`, `p = p11 exp(-g (h - h11) / (R T11))`; to 32 km T rises by 1 K/km. The day's
/// temperature enters the pressure law too, as in thesis section 3.2.4. Source: ISO 2533.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    sea_level_pressure_pa: f64,
    sea_level_temperature_k: f64,
}

impl Default for Atmosphere {
    fn default() -> Self {
        Self::STANDARD
    }
}

impl Atmosphere {
    /// The standard day: 101325 Pa and 288.15 K at sea level.
    pub const STANDARD: Self =
        Self { sea_level_pressure_pa: SEA_LEVEL_PRESSURE_PA, sea_level_temperature_k: SEA_LEVEL_TEMPERATURE_K };

    /// An atmosphere with this pressure (Pa) and temperature (K) at sea level.
    ///
    /// # Errors
    /// [`AtmosphereError`] for a pressure outside 80 to 115 kPa or a temperature outside 180 to 340 K.
    pub fn new(sea_level_pressure_pa: f64, sea_level_temperature_k: f64) -> Result<Self, AtmosphereError> {
        Ok(Self {
            sea_level_pressure_pa: within("sea-level pressure", sea_level_pressure_pa, "Pa", PRESSURE_RANGE_PA)?,
            sea_level_temperature_k: within(
                "sea-level temperature", sea_level_temperature_k, "K", TEMPERATURE_RANGE_K,
            )?,
        })
    }

    /// Pressure at sea level, Pa.
    pub(crate) fn sea_level_pressure_pa(&self) -> f64 {
        self.sea_level_pressure_pa
    }

    /// Temperature at sea level, K.
    pub fn sea_level_temperature_k(&self) -> f64 {
        self.sea_level_temperature_k
    }

    /// Temperature at `altitude_m`, K: `T = T0 - L h` up to the tropopause.
    ///
    /// # Errors
    /// [`AtmosphereError`] outside -5000 to 32000 m.
    pub fn temperature_k(&self, altitude_m: f64) -> Result<f64, AtmosphereError> {
        let h = within("altitude", altitude_m, "m", (LOWEST_M, HIGHEST_M))?;
        let lowest_k = self.sea_level_temperature_k - LAPSE_RATE_K_M * h.min(TROPOPAUSE_M);
        Ok(if h > ISOTHERMAL_TOP_M { lowest_k + INVERSION_RATE_K_M * (h - ISOTHERMAL_TOP_M) } else { lowest_k })
    }

    /// Static pressure at `altitude_m`, Pa: `p = p0 (T / T0)^(g / (R L))` up to the tropopause.
    ///
    /// # Errors
    /// [`AtmosphereError`] outside -5000 to 32000 m.
    pub fn pressure_pa(&self, altitude_m: f64) -> Result<f64, AtmosphereError> {
        let temperature_k = self.temperature_k(altitude_m)?;
        let lowest_k = self.temperature_k(altitude_m.min(TROPOPAUSE_M))?;
        let troposphere = libm::pow(lowest_k / self.sea_level_temperature_k, PRESSURE_EXPONENT);
        let pressure_pa = self.sea_level_pressure_pa * troposphere;
        if altitude_m <= TROPOPAUSE_M {
            return Ok(pressure_pa);
        }
        let depth_m = altitude_m.min(ISOTHERMAL_TOP_M) - TROPOPAUSE_M;
        let isothermal = libm::exp(-STANDARD_GRAVITY_M_S2 * depth_m / (GAS_CONSTANT_AIR_J_KG_K * lowest_k));
        Ok(pressure_pa * isothermal * libm::pow(lowest_k / temperature_k, INVERSION_EXPONENT))
    }

    /// Density at `altitude_m`, kg/m³: `rho = p / (R T)`.
    ///
    /// # Errors
    /// [`AtmosphereError`] outside -5000 to 32000 m.
    pub fn density_kg_m3(&self, altitude_m: f64) -> Result<f64, AtmosphereError> {
        density_kg_m3(self.pressure_pa(altitude_m)?, self.temperature_k(altitude_m)?)
    }

    /// Speed of sound at `altitude_m`, m/s: `a = sqrt(gamma R T)`.
    ///
    /// # Errors
    /// [`AtmosphereError`] outside -5000 to 32000 m.
    pub fn speed_of_sound_m_s(&self, altitude_m: f64) -> Result<f64, AtmosphereError> {
        Ok((HEAT_CAPACITY_RATIO_AIR * GAS_CONSTANT_AIR_J_KG_K * self.temperature_k(altitude_m)?).sqrt())
    }

    /// Altitude at which this atmosphere has the static pressure `pressure_pa`, m: the inverse of
    /// [`Self::pressure_pa`]; with [`Self::STANDARD`] the pressure altitude.
    ///
    /// # Errors
    /// [`AtmosphereError`] where that altitude lies outside -5000 to 32000 m.
    pub fn altitude_m(&self, pressure_pa: f64) -> Result<f64, AtmosphereError> {
        let range = (self.pressure_pa(HIGHEST_M)?, self.pressure_pa(LOWEST_M)?);
        let pressure_pa = within("static pressure", pressure_pa, "Pa", range)?;
        let (tropopause_pa, top_pa) = (self.pressure_pa(TROPOPAUSE_M)?, self.pressure_pa(ISOTHERMAL_TOP_M)?);
        let lowest_k = self.temperature_k(TROPOPAUSE_M)?;
        if pressure_pa < top_pa {
            let warmer_k = lowest_k * (libm::pow(top_pa / pressure_pa, 1.0 / INVERSION_EXPONENT) - 1.0);
            return Ok((ISOTHERMAL_TOP_M + warmer_k / INVERSION_RATE_K_M).min(HIGHEST_M));
        }
        if pressure_pa < tropopause_pa {
            let scale_m = GAS_CONSTANT_AIR_J_KG_K * lowest_k / STANDARD_GRAVITY_M_S2;
            return Ok(TROPOPAUSE_M + scale_m * libm::log(tropopause_pa / pressure_pa));
        }
        let ratio = pressure_pa / self.sea_level_pressure_pa;
        let scale_m = self.sea_level_temperature_k / LAPSE_RATE_K_M;
        Ok((scale_m * (1.0 - libm::pow(ratio, 1.0 / PRESSURE_EXPONENT))).clamp(LOWEST_M, TROPOPAUSE_M))
    }
}

/// Density of dry air from measured static pressure (Pa) and static temperature (K), kg/m³: `rho = p / (R T)`.
///
/// Preferred over the standard atmosphere where both are recorded. Humidity lowers the true value by up to 1.5 % on a hot,
/// saturated day; it is not taken into account. Source: ISO 2533.
///
/// # Errors
/// [`AtmosphereError`] for a pressure outside 1 Pa to 200 kPa or a temperature outside 100 to 400 K.
pub fn density_kg_m3(static_pressure_pa: f64, static_temperature_k: f64) -> Result<f64, AtmosphereError> {
    let p = within("static pressure", static_pressure_pa, "Pa", (1.0, 200_000.0))?;
    let t = within("static temperature", static_temperature_k, "K", (100.0, 400.0))?;
    Ok(p / (GAS_CONSTANT_AIR_J_KG_K * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Relative half unit of the last digit of the printed tables.
    const PRINTED: f64 = 6e-6;
    /// Relative round-off of a power and its inverse.
    const ROUND_OFF: f64 = 1e-12;

    /// Altitude m, temperature K, pressure Pa, density kg/m³, speed of sound m/s: ISO 2533 table 1 (geopotential).
    const ISO_2533: [[f64; 5]; 6] = [
        [0.0, 288.15, 101_325.0, 1.225, 340.294],
        [1_000.0, 281.65, 89_874.6, 1.111_64, 336.434],
        [5_000.0, 255.65, 54_019.9, 0.736_116, 320.529],
        [11_000.0, 216.65, 22_632.1, 0.363_918, 295.069],
        [15_000.0, 216.65, 12_044.6, 0.193_674, 295.069],
        [20_000.0, 216.65, 5_474.89, 0.088_034_9, 295.069],
    ];

    #[test]
    fn standard_day_matches_iso_2533() {
        let day = Atmosphere::STANDARD;
        for [h, t, p, rho, a] in ISO_2533 {
            assert_relative_eq!(day.temperature_k(h).unwrap(), t, max_relative = PRINTED);
            assert_relative_eq!(day.pressure_pa(h).unwrap(), p, max_relative = PRINTED);
            assert_relative_eq!(day.density_kg_m3(h).unwrap(), rho, max_relative = PRINTED);
            assert_relative_eq!(day.speed_of_sound_m_s(h).unwrap(), a, max_relative = PRINTED);
        }
    }

    #[test]
    fn altitude_of_pressure_roundtrips_on_a_hot_day() {
        let day = Atmosphere::new(100_800.0, 303.15).unwrap();
        for h in [-5_000.0, -10.0, 0.0, 1_219.0, 11_000.0, 11_001.0, 18_300.0, 20_000.0, 31_999.0] {
            let back = day.altitude_m(day.pressure_pa(h).unwrap()).unwrap();
            assert!((back - h).abs() <= ROUND_OFF * 1e7, "{back} is not {h}");
        }
    }

    #[test]
    fn hot_day_is_thinner_by_the_temperature_ratio_at_sea_level() {
        let hot = Atmosphere::new(101_325.0, 296.65).unwrap();
        let ratio = hot.density_kg_m3(0.0).unwrap() / Atmosphere::STANDARD.density_kg_m3(0.0).unwrap();
        assert_relative_eq!(ratio, 288.15 / 296.65, max_relative = ROUND_OFF);
    }

    #[test]
    fn atmosphere_rejects_what_it_does_not_cover() {
        let day = Atmosphere::STANDARD;
        assert!(day.pressure_pa(32_001.0).is_err());
        assert!(day.density_kg_m3(f64::NAN).is_err());
        assert!(day.altitude_m(200_000.0).is_err());
        assert!(Atmosphere::new(1013.25, 288.15).is_err(), "hPa must not pass for Pa");
        assert!(Atmosphere::new(101_325.0, 15.0).is_err(), "deg C must not pass for K");
        assert!(density_kg_m3(90_000.0, 10.0).is_err());
    }
}
