//! Air data by each other in the standard atmosphere: static pressure and height, airspeed and Mach number, calibrated airspeed.

use super::air::{self, SPEEDS, taken};
use super::assignment::Assignment;
use super::fit::line;
use super::kinematics::Taken;
use crate::atmos::Atmosphere;
use crate::quantity::Role;

/// Units with how many of them make one of SI.
pub const LENGTHS: [(&str, f64); 2] = [("m", 1.0), ("ft", 3.280_84)];
pub const PRESSURES: [(&str, f64); 5] =
    [("Pa", 1.0), ("hPa", 0.01), ("kPa", 1e-3), ("inHg", 2.953e-4), ("psf", 0.020_885)];
/// Heights and static pressures that are flown at, m and Pa, and the least change of height that pressure shows, m.
pub const HEIGHTS_M: [f64; 2] = [-500.0, 20_000.0];
pub const PRESSURES_PA: [f64; 2] = [5000.0, 110_000.0];
pub const LEAST_CHANGE_M: f64 = 15.0;
/// Mach numbers of aeroplanes, and speeds of sound from the tropopause to a hot day at sea level, m/s.
const MACH: [f64; 2] = [0.03, 2.5];
const SOUND_M_S: [f64; 2] = [285.0, 350.0];
/// Largest ratio of levels and of slopes to those of the atmosphere, either way.
const LEVEL: f64 = 1.05;
const SLOPE: f64 = 1.05;
/// Largest ratio of a speed of sound to that of the standard atmosphere at its height, either way.
const SOUND: f64 = 1.035;
/// Least squared correlation of two quantities of one atmosphere, of airspeed with Mach number, of a calibrated airspeed.
const PRESSURE_R2: f64 = 0.99;
const MACH_R2: f64 = 0.95;
const CALIBRATED_R2: f64 = 0.9;
/// Largest calibrated airspeed as a part of the true one that is told from it.
const LARGEST_CALIBRATED: f64 = 0.97;

/// The same where noise hides part of a small change: least squared correlation, and largest ratios of level and slope.
const NEAR_R2: f64 = 0.6;
const NEAR_LEVEL: f64 = 1.015;
const NEAR_SLOPE: f64 = 1.35;

/// Mean of the finite values.
pub fn average(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Whether a ratio is one within a factor.
fn is_one(ratio: f64, factor: f64) -> bool {
    ratio > 0.0 && ratio.ln().abs() < factor.ln()
}

/// A channel that records `wanted`: level and change, or its level closely where noise hides part of a small change.
fn records(
    whole: &Assignment<'_>,
    i: usize,
    wanted: &[f64],
    units: &[(&'static str, f64)],
    least: f64,
) -> Option<Taken> {
    let column = whole.column(i);
    let level = average(&column.mean) / average(wanted);
    let (slope, r2) = line(&column.mean, wanted)?;
    let found = taken(i, level, units, LEVEL, r2)?;
    let is_exact = r2 > least && is_one(slope / level, SLOPE);
    let is_near =
        || r2 > NEAR_R2 && is_one(level * found.factor, NEAR_LEVEL) && is_one(slope / level / r2.sqrt(), NEAR_SLOPE);
    (level > 0.0 && (is_exact || is_near())).then_some(found)
}

/// Height and static pressure, then airspeed and Mach number.
pub fn complete(whole: &mut Assignment<'_>) {
    find_height(whole);
    find_mach(whole);
}

/// The pair of a height and a static pressure of the standard atmosphere.
fn find_height(whole: &mut Assignment<'_>) {
    let air = Atmosphere::STANDARD;
    let free = whole.free();
    let mut best: Option<(Taken, Taken)> = None;
    for &i in &free {
        for (unit, scale) in LENGTHS {
            let range = whole.column(i).range.map(|value| value / scale);
            if range[0] < HEIGHTS_M[0] || range[1] > HEIGHTS_M[1] || range[1] - range[0] < LEAST_CHANGE_M {
                continue;
            }
            let pressure = |height: &f64| air.pressure_pa(height / scale).unwrap_or(f64::NAN);
            let wanted: Vec<f64> = whole.column(i).mean.iter().map(pressure).collect();
            for &j in free.iter().filter(|j| **j != i) {
                let level = average(&whole.column(j).mean) / average(&wanted);
                if !PRESSURES.iter().any(|(_, scale)| is_one(level / scale, LEVEL)) {
                    continue;
                }
                let Some(found) = records(whole, j, &wanted, &PRESSURES, PRESSURE_R2) else { continue };
                let is_air = whole
                    .column(j)
                    .range
                    .iter()
                    .all(|value| (PRESSURES_PA[0]..PRESSURES_PA[1]).contains(&(found.factor * value)));
                if is_air && best.is_none_or(|(_, pressure)| found.r2 > pressure.r2) {
                    best = Some((Taken { column: i, unit, factor: 1.0 / scale, r2: found.r2 }, found));
                }
            }
        }
    }
    if let Some((height, pressure)) = best {
        whole.height = Some([whole.mean_of(height), whole.slope_of(height)]);
        whole.take(Role::Altitude, height, "the altitude of the static pressure");
        whole.take(Role::StaticPressure, pressure, "the pressure at its altitude");
    }
}

/// The pair of an airspeed and a Mach number: their ratio is the speed of sound.
fn find_mach(whole: &mut Assignment<'_>) {
    let free = whole.free();
    let sound = whole
        .height
        .as_ref()
        .map(|[height, _]| Atmosphere::STANDARD.speed_of_sound_m_s(average(height)).unwrap_or(f64::NAN));
    let mut best: Option<(Taken, Taken)> = None;
    let mut is_ambiguous = false;
    for &i in free.iter().filter(|i| air::can_be_speed(whole, **i)) {
        for &j in free.iter().filter(|j| **j != i) {
            let level = average(&whole.column(j).mean);
            if !(MACH[0]..MACH[1]).contains(&level) || whole.column(j).range[0] < -0.01 {
                continue;
            }
            let ratio = average(&whole.column(i).mean) / level;
            let fits = |scale: f64| match sound {
                Some(sound) => is_one(ratio / scale / sound, SOUND),
                None => (SOUND_M_S[0]..SOUND_M_S[1]).contains(&(ratio / scale)),
            };
            let mut units = SPEEDS.iter().filter(|(_, scale)| fits(*scale));
            let (Some((unit, scale)), another) = (units.next(), units.next().is_some()) else { continue };
            let Some((slope, r2)) = line(&whole.column(i).mean, &whole.column(j).mean) else { continue };
            let is_near = sound.is_some_and(|sound| is_one(ratio / scale / sound, NEAR_LEVEL))
                && r2 > NEAR_R2
                && is_one(slope / ratio / r2.sqrt(), NEAR_SLOPE);
            let is_exact = r2 > MACH_R2 && is_one(slope / ratio, SLOPE);
            if (is_exact || is_near) && best.is_none_or(|(speed, _)| r2 > speed.r2) {
                is_ambiguous = another;
                let speed = Taken { column: i, unit, factor: 1.0 / scale, r2 };
                best = Some((speed, Taken { column: j, unit: "-", factor: 1.0, r2 }));
            }
        }
    }
    if let Some((speed, mach)) = best.filter(|_| !is_ambiguous) {
        air::take_speed(whole, speed, "the Mach number times the speed of sound");
        whole.take(Role::Mach, mach, "airspeed over the speed of sound");
    }
}

/// Static pressure, Mach number and calibrated airspeed where height and airspeed are known.
pub fn complete_known(whole: &mut Assignment<'_>) {
    let Some([height, _]) = whole.height.clone() else { return };
    let air = Atmosphere::STANDARD;
    let has = |whole: &Assignment<'_>, role: Role| whole.found.iter().any(|found| found.role == role);
    let pressure: Vec<f64> = height.iter().map(|height| air.pressure_pa(*height).unwrap_or(f64::NAN)).collect();
    if !has(whole, Role::StaticPressure) {
        let fits = |whole: &Assignment<'_>, i: usize| records(whole, i, &pressure, &PRESSURES, PRESSURE_R2);
        whole.take_best(Role::StaticPressure, "the pressure at its altitude", fits);
    }
    let Some(speed) = whole.airspeed.clone() else { return };
    let mach = whole.each(|k| speed[k] / air.speed_of_sound_m_s(height[k]).unwrap_or(f64::NAN));
    if !has(whole, Role::Mach) {
        let fits = |whole: &Assignment<'_>, i: usize| records(whole, i, &mach, &[("-", 1.0)], MACH_R2);
        whole.take_best(Role::Mach, "airspeed over the speed of sound", fits);
    }
    // V_c = a_0 sqrt(5 ((q_c / p_0 + 1)^(2/7) - 1)) with q_c = p ((1 + M^2 / 5)^(7/2) - 1) (Anderson, Introduction to Flight, section 4.11).
    let (Ok(sea), Ok(sound)) = (air.pressure_pa(0.0), air.speed_of_sound_m_s(0.0)) else { return };
    let calibrated = whole.each(|k| {
        let impact = pressure[k] * ((1.0 + 0.2 * mach[k] * mach[k]).powf(3.5) - 1.0);
        sound * (5.0 * ((impact / sea + 1.0).powf(2.0 / 7.0) - 1.0)).sqrt()
    });
    // Near the ground both airspeeds are one.
    if average(&calibrated) > LARGEST_CALIBRATED * average(&speed) {
        return;
    }
    let fits = |whole: &Assignment<'_>, i: usize| records(whole, i, &calibrated, &SPEEDS, CALIBRATED_R2);
    whole.take_best(Role::CalibratedAirspeed, "airspeed at the density of its altitude", fits);
}
