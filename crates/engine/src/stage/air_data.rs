//! Air data that follow from others: calibrated airspeed from the impact pressure, true airspeed from a calibrated or an
//! equivalent one or a Mach number, static temperature from a total one.

use std::sync::Arc;

use doublet_core::atmos::{
    Atmosphere, calibrated_of_impact_m_s, mach_of_calibrated, mach_of_equivalent, static_at_airspeed_k,
    static_of_total_temperature_k, true_of_mach_m_s,
};
use doublet_core::message;
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

/// Whether a recording with these roles has a true airspeed, its own or one that follows from a Mach number, the calibrated or equivalent one
/// or the impact pressure.
pub(crate) fn has_airspeed(has: impl Fn(Role) -> bool) -> bool {
    let has_pressure = PRESSURES.iter().any(|(role, _)| has(*role));
    has(Role::TrueAirspeed)
        || [Role::CalibratedAirspeed, Role::EquivalentAirspeed, Role::ImpactPressure].into_iter().any(&has)
            && has_pressure
        || has(Role::Mach) && (has_pressure || has(Role::AirTemperature) || has(Role::TotalTemperature))
}

/// Derives a signal from others: the signal, and from what it follows.
type Derive = fn(&Recording) -> Option<(Series, String)>;

/// Adds what follows from the air data of a recording and is not recorded itself, and says so: calibrated and true airspeed, and
/// the static temperature from the total one.
pub(super) fn add_air_data(recording: &mut Recording) {
    let rules: [(Role, &str, Derive); 3] = [
        (Role::CalibratedAirspeed, "m/s", calibrated_airspeed),
        (Role::TrueAirspeed, "m/s", airspeed),
        (Role::AirTemperature, "K", static_temperature),
    ];
    for (role, unit, derive) in rules {
        if recording.role(role).is_some() {
            continue;
        }
        let Some((series, sources)) = derive(recording) else { continue };
        recording.warnings.push(message!("{} is not recorded: computed from {}", role.name(), sources));
        recording.roles.insert(role, recording.channels.len());
        let (source, name, unit) = (SOURCE.to_owned(), role.name().to_owned(), unit.to_owned());
        recording.channels.push(Channel { source, name, unit, series });
    }
}

/// Calibrated airspeed at the samples of the impact pressure.
fn calibrated_airspeed(recording: &Recording) -> Option<(Series, String)> {
    let Series { time_s, values } = recording.role(Role::ImpactPressure)?.series.finite();
    let values: Vec<f64> = values.iter().map(|impact| calibrated_of_impact_m_s(*impact)).collect();
    let text = Role::ImpactPressure.name().to_owned();
    values.iter().any(|value| value.is_finite()).then(|| (Series { time_s, values: values.into() }, text))
}

/// True airspeed at the samples of the calibrated or equivalent one or of the Mach number, and from what it is.
fn airspeed(recording: &Recording) -> Option<(Series, String)> {
    let at = |role: Role, time_s: &[f64]| values_where_recorded(recording, role, time_s);
    let (time_s, mach, pressure, role) = [Role::CalibratedAirspeed, Role::EquivalentAirspeed, Role::Mach]
        .into_iter()
        .find_map(|role| find_mach(recording, role))?;
    let (temperature_k, temperature_name) = if let Some(recorded) = at(Role::AirTemperature, &time_s) {
        (recorded, "air temperature".to_owned())
    } else if let Some(total) = at(Role::TotalTemperature, &time_s) {
        let pairs = total.iter().zip(&mach);
        let of_total = pairs.map(|(total, mach)| static_of_total_temperature_k(*total, *mach));
        (of_total.collect(), "total temperature".to_owned())
    } else {
        let day = Atmosphere::STANDARD;
        let standard = |pressure: &f64| day.altitude_m(*pressure).and_then(|altitude| day.temperature_k(altitude));
        let (pressure_pa, name) = pressure.as_ref()?;
        let standard = pressure_pa.iter().map(|pressure| standard(pressure).unwrap_or(f64::NAN));
        let from = if role == Role::Mach { format!(" at {name}") } else { String::new() };
        (standard.collect(), format!("standard temperature{from}"))
    };
    let pairs = mach.iter().zip(&temperature_k);
    let values: Vec<f64> = pairs.map(|(mach, temperature)| true_of_mach_m_s(*mach, *temperature)).collect();
    let sources = match pressure {
        Some((_, name)) if role != Role::Mach => format!("{}, {name}", role.name()),
        _ => role.name().to_owned(),
    };
    let text = format!("{sources} and {temperature_name}");
    values.iter().any(|value| value.is_finite()).then(|| (Series { time_s, values: values.into() }, text))
}

/// Static pressure at samples, Pa, and from what it is.
fn find_pressure(recording: &Recording, time_s: &[f64]) -> Option<(Vec<f64>, &'static str)> {
    let (mut pressure_pa, role, name) = PRESSURES
        .iter()
        .find_map(|&(role, name)| Some((values_where_recorded(recording, role, time_s)?, role, name)))?;
    if role != Role::StaticPressure {
        let standard = |altitude_m: f64| Atmosphere::STANDARD.pressure_pa(altitude_m).unwrap_or(f64::NAN);
        pressure_pa.iter_mut().for_each(|value| *value = standard(*value));
    }
    Some((pressure_pa, name))
}

/// Times, Mach numbers at them, static pressure with what it is from, and the role that gave them.
type MachNumbers = (Arc<[f64]>, Vec<f64>, Option<(Vec<f64>, &'static str)>, Role);

/// Mach number at the samples of a role that gives it.
fn find_mach(recording: &Recording, role: Role) -> Option<MachNumbers> {
    let Series { time_s, values } = recording.role(role)?.series.finite();
    let pressure = find_pressure(recording, &time_s);
    if role == Role::Mach {
        return Some((time_s, values.to_vec(), pressure, role));
    }
    let mach_of = if role == Role::CalibratedAirspeed { mach_of_calibrated } else { mach_of_equivalent };
    let pairs = values.iter().zip(&pressure.as_ref()?.0);
    let mach = pairs.map(|(speed, pressure)| mach_of(*speed, *pressure)).collect();
    Some((time_s, mach, pressure, role))
}

/// Static temperature at the samples of the total one, by the true airspeed, and from what it is.
fn static_temperature(recording: &Recording) -> Option<(Series, String)> {
    let Series { time_s, values } = recording.role(Role::TotalTemperature)?.series.finite();
    let airspeed_m_s = values_where_recorded(recording, Role::TrueAirspeed, &time_s)?;
    let pairs = values.iter().zip(&airspeed_m_s);
    let values: Vec<f64> = pairs.map(|(total, airspeed)| static_at_airspeed_k(*total, *airspeed)).collect();
    let text = format!("{} and {}", Role::TotalTemperature.name(), Role::TrueAirspeed.name());
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
        add_air_data(&mut recording);
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

    /// By the isentropic relation between the two pressures and the Mach number (NACA 1135): `qc / p = (1 + M^2 / 5)^3.5 - 1`.
    #[test]
    fn true_airspeed_of_an_impact_pressure_is_that_of_its_mach_number() {
        let (mach, pressure_pa, temperature_k) = (0.52_f64, 61_640.0, 262.2);
        let impact_pa = pressure_pa * ((1.0 + mach * mach / 5.0).powf(3.5) - 1.0);
        let channels = [(Role::ImpactPressure, impact_pa), (Role::StaticPressure, pressure_pa)];
        let found = derived(&[channels[0], channels[1], (Role::AirTemperature, temperature_k)]).unwrap();
        let wanted = mach * (1.4 * 287.053 * temperature_k).sqrt();
        assert!((found / wanted - 1.0).abs() < 1e-5, "{found} {wanted}");
        assert_eq!(derived(&[channels[0]]), None);
    }

    #[test]
    fn true_airspeed_as_recorded_stays_and_none_follows_without_a_pressure() {
        let calibrated = (Role::CalibratedAirspeed, 55.0);
        let recorded = (Role::TrueAirspeed, 70.0);
        assert_eq!(derived(&[calibrated, recorded, (Role::Altitude, 2000.0)]), Some(70.0));
        assert_eq!(derived(&[calibrated]), None);
        assert_eq!(derived(&[(Role::Altitude, 2000.0)]), None);
    }

    /// By the definition of the equivalent airspeed: `rho V^2 = rho0 V_e^2`.
    #[test]
    fn true_airspeed_of_an_equivalent_one_has_the_same_dynamic_pressure() {
        let (equivalent_m_s, pressure_pa, temperature_k) = (130.0_f64, 41_060.0, 251.4);
        let density = pressure_pa / (287.053 * temperature_k);
        let channels = [
            (Role::EquivalentAirspeed, equivalent_m_s),
            (Role::StaticPressure, pressure_pa),
            (Role::AirTemperature, temperature_k),
        ];
        let found = derived(&channels).unwrap();
        assert!((found / (equivalent_m_s * (1.225 / density).sqrt()) - 1.0).abs() < 1e-5, "{found}");
        assert_eq!(derived(&channels[..1]), None);
    }

    /// Isentropic flow tables (NACA 1135): at Mach 0.78 T / T_t = 0.8915.
    #[test]
    fn true_airspeed_of_a_mach_number_takes_the_temperature_that_is_recorded() {
        let mach = (Role::Mach, 0.78);
        let (static_k, sound_m_s) = (223.15_f64, 299.46);
        let by_static = derived(&[mach, (Role::AirTemperature, static_k)]).unwrap();
        let by_total = derived(&[mach, (Role::TotalTemperature, static_k / 0.8915)]).unwrap();
        // 223.15 K is the standard temperature at 10,000 m.
        let by_altitude = derived(&[mach, (Role::Altitude, 10_000.0)]).unwrap();
        for found in [by_static, by_total, by_altitude] {
            assert!((found / (0.78 * sound_m_s) - 1.0).abs() < 2e-4, "{found}");
        }
        assert_eq!(derived(&[mach]), None);
    }

    #[test]
    fn static_temperature_follows_from_the_total_one_where_it_is_not_recorded() {
        let mut with_total = recording(&[(Role::TrueAirspeed, 230.0), (Role::TotalTemperature, 250.0)]);
        add_air_data(&mut with_total);
        // c_p = 1004.7 J/(kg K).
        let found = with_total.role(Role::AirTemperature).unwrap().series.values[50];
        assert!((found - (250.0 - 230.0_f64.powi(2) / (2.0 * 1004.7))).abs() < 1e-2, "{found}");
        let mut with_static = recording(&[(Role::TrueAirspeed, 230.0), (Role::AirTemperature, 220.0)]);
        add_air_data(&mut with_static);
        assert_eq!(with_static.channels.len(), 2);
    }
}
