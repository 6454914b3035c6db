//! True airspeed from a calibrated one, in a recording that has no true one.

use doublet_core::atmos::{Atmosphere, true_of_calibrated_m_s};
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, Series};

use super::samples::values_where_recorded;
use super::signals::SOURCE;

/// What gives the static pressure, the best first, and how it is called.
const PRESSURES: [(Role, &str); 3] = [
    (Role::StaticPressure, "static pressure"),
    (Role::Altitude, "the standard pressure at the altitude"),
    (Role::GpsAltitude, "the standard pressure at the GPS altitude"),
];

/// Whether a recording with these roles has a true airspeed, its own or one that follows from the calibrated one.
pub(crate) fn has_airspeed(has: impl Fn(Role) -> bool) -> bool {
    has(Role::TrueAirspeed) || has(Role::CalibratedAirspeed) && PRESSURES.iter().any(|(role, _)| has(*role))
}

/// Adds the true airspeed to a recording that has only a calibrated one, with static pressure or altitude, and says so.
pub(super) fn add_airspeed(recording: &mut Recording) {
    if recording.role(Role::TrueAirspeed).is_some() {
        return;
    }
    let Some((series, text)) = airspeed(recording) else { return };
    recording.warnings.push(text);
    recording.roles.insert(Role::TrueAirspeed, recording.channels.len());
    let (name, unit) = (Role::TrueAirspeed.name().to_owned(), "m/s".to_owned());
    recording.channels.push(Channel { source: SOURCE.to_owned(), name, unit, series });
}

/// True airspeed at the samples of the calibrated one, and from what it is.
fn airspeed(recording: &Recording) -> Option<(Series, String)> {
    let Series { time_s, values } = recording.role(Role::CalibratedAirspeed)?.series.finite();
    let at = |role: Role| values_where_recorded(recording, role, &time_s);
    let (mut pressure_pa, role, pressure_name) =
        PRESSURES.iter().find_map(|&(role, name)| Some((at(role)?, role, name)))?;
    let day = Atmosphere::STANDARD;
    if role != Role::StaticPressure {
        pressure_pa.iter_mut().for_each(|altitude_m| *altitude_m = day.pressure_pa(*altitude_m).unwrap_or(f64::NAN));
    }
    let standard_k =
        |pressure_pa: f64| day.altitude_m(pressure_pa).and_then(|altitude_m| day.temperature_k(altitude_m));
    let (temperature_k, temperature_name) = match at(Role::AirTemperature) {
        Some(recorded) => (recorded, "air temperature"),
        None => {
            let standard = pressure_pa.iter().map(|pressure_pa| standard_k(*pressure_pa).unwrap_or(f64::NAN));
            (standard.collect(), "standard temperature")
        }
    };
    let air = pressure_pa.iter().zip(&temperature_k);
    let airspeed = values.iter().zip(air).map(|(calibrated_m_s, (pressure_pa, temperature_k))| {
        true_of_calibrated_m_s(*calibrated_m_s, *pressure_pa, *temperature_k)
    });
    let values: Vec<f64> = airspeed.collect();
    let text = format!(
        "{} follows from {}, {pressure_name} and {temperature_name}: no true airspeed is recorded",
        Role::TrueAirspeed.name(),
        Role::CalibratedAirspeed.name()
    );
    values.iter().any(|value| value.is_finite()).then(|| (Series { time_s, values: values.into() }, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(channels: &[(Role, f64)]) -> Recording {
        let mut recording = Recording::default();
        for &(role, value) in channels {
            recording.roles.insert(role, recording.channels.len());
            // Every channel on a clock of its own.
            let step_s = 0.1 + 0.01 * recording.channels.len() as f64;
            let time_s: Vec<f64> = (0..100).map(|k| step_s * f64::from(k)).collect();
            let series = Series { values: vec![value; time_s.len()].into(), time_s: time_s.into() };
            recording.channels.push(Channel {
                source: String::new(),
                name: role.name().to_owned(),
                unit: String::new(),
                series,
            });
        }
        recording
    }

    fn derived(channels: &[(Role, f64)]) -> Option<f64> {
        let mut recording = recording(channels);
        add_airspeed(&mut recording);
        assert_eq!(
            recording.role(Role::TrueAirspeed).is_some(),
            has_airspeed(|role| recording.roles.contains_key(&role))
        );
        let series = &recording.role(Role::TrueAirspeed)?.series;
        assert_eq!(series.values.len(), 100);
        Some(series.values[50])
    }

    /// By Bernoulli's equation of incompressible flow with the next term of the Mach number on both sides, which leaves 1e-4 at this speed.
    #[test]
    fn true_airspeed_of_a_calibrated_one_is_that_of_the_impact_pressure() {
        let (calibrated_m_s, altitude_m, temperature_k) = (55.0, 1230.0, 281.0);
        // ICAO: p = p0 (1 - 6.5e-3 h / 288.15)^5.25588.
        let pressure_pa = 101_325.0 * (1.0 - 6.5e-3 * altitude_m / 288.15_f64).powf(5.255_88);
        let impact = |density: f64, sound: f64, speed: f64| {
            0.5 * density * speed * speed * (1.0 + (speed / sound).powi(2) / 4.0)
        };
        let wanted = impact(1.225, 340.294, calibrated_m_s);
        let (density, sound) = (pressure_pa / (287.053 * temperature_k), (1.4 * 287.053 * temperature_k).sqrt());
        let (mut low, mut high) = (0.0, 200.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if impact(density, sound, middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        let calibrated = (Role::CalibratedAirspeed, calibrated_m_s);
        let temperature = (Role::AirTemperature, temperature_k);
        for pressure in
            [(Role::StaticPressure, pressure_pa), (Role::Altitude, altitude_m), (Role::GpsAltitude, altitude_m)]
        {
            let found = derived(&[calibrated, pressure, temperature]).unwrap();
            assert!((found / low - 1.0).abs() < 2e-4, "{found} {low}");
        }
        // In the standard atmosphere: V = V_c (rho0 / rho)^(1/2), less what compressibility takes, 0.3 % here.
        let standard = derived(&[calibrated, (Role::Altitude, 2000.0)]).unwrap();
        assert!((standard / (calibrated_m_s * (1.225 / 1.006_49_f64).sqrt()) - 1.0).abs() < 3e-3, "{standard}");
    }

    #[test]
    fn true_airspeed_as_recorded_stays_and_none_follows_without_a_pressure() {
        let calibrated = (Role::CalibratedAirspeed, 55.0);
        let recorded = (Role::TrueAirspeed, 70.0);
        assert_eq!(derived(&[calibrated, recorded, (Role::Altitude, 2000.0)]), Some(70.0));
        assert_eq!(derived(&[calibrated]), None);
        assert_eq!(derived(&[(Role::Altitude, 2000.0)]), None);
    }
}
