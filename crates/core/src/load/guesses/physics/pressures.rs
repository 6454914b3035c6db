//! Height by the logarithm of the static pressure, and airspeed by the dynamic pressure: relations that need no attitude.

use super::air::{self, SPEEDS};
use super::air_data::{HEIGHTS_M, LEAST_CHANGE_M, LENGTHS, PRESSURES, PRESSURES_PA, average};
use super::assignment::Assignment;
use super::fit::line;
use super::kinematics::Taken;
use crate::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2};
use crate::quantity::Role;

/// Gas constant of dry air, J/(kg K).
const GAS_CONSTANT_J_KG_K: f64 = 287.052_87;
/// Largest ratio of a temperature by the change of pressure to the standard one, either way.
const TEMPERATURE: f64 = 1.12;
/// Largest difference of a height above another datum from that of its pressure, m.
const DATUM_M: f64 = 1500.0;
/// Least squared correlations.
const HEIGHT_R2: f64 = 0.99;
const DYNAMIC_R2: f64 = 0.995;
/// Largest part of the variance that a line leaves and a square does, largest offset of a dynamic pressure as a part of it, and largest ratio of a density to that of the height, either way.
const OF_PLAIN: f64 = 0.6;
const OFFSET: f64 = 0.3;
const DENSITY: f64 = 1.05;
/// Ratio of densities from which true and calibrated airspeed are two.
const DENSITY_APART: f64 = 1.01;

/// Height and static pressure, then airspeed.
pub fn complete(whole: &mut Assignment<'_>) {
    if whole.height.is_none() {
        find_height(whole);
    }
    if whole.airspeed.is_none() {
        find_speed(whole);
    }
}

/// The unit of a static pressure whose height, m, is nearest to another.
fn unit_of_pressure(level: f64, height_m: f64) -> Option<(&'static str, f64)> {
    let apart = |scale: f64| {
        let pressure = level / scale;
        let inside = (PRESSURES_PA[0]..PRESSURES_PA[1]).contains(&pressure);
        let height = inside.then(|| Atmosphere::STANDARD.altitude_m(pressure).ok()).flatten()?;
        Some((height - height_m).abs()).filter(|apart| *apart < DATUM_M)
    };
    let all = PRESSURES.into_iter().filter_map(|(unit, scale)| Some(((unit, scale), apart(scale)?)));
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(unit, _)| unit)
}

/// The pair of a height above any datum and a static pressure: `d ln p = -g / (R T) dh` with the temperature of the standard atmosphere.
fn find_height(whole: &mut Assignment<'_>) {
    let free = whole.free();
    let mut best: Option<(Taken, Taken)> = None;
    for &j in &free {
        let column = whole.column(j);
        if column.range[0] <= 0.0 || column.range[1] > 1.2 * PRESSURES_PA[1] {
            continue;
        }
        let logarithm: Vec<f64> = column.mean.iter().map(|pressure| pressure.ln()).collect();
        for &i in free.iter().filter(|i| **i != j) {
            let Some((slope, r2)) = line(&logarithm, &whole.column(i).mean).filter(|(slope, _)| *slope < 0.0) else {
                continue;
            };
            if r2 < HEIGHT_R2 || best.is_some_and(|(height, _)| height.r2 >= r2) {
                continue;
            }
            for (unit, scale) in LENGTHS {
                let range = whole.column(i).range.map(|value| value / scale);
                let level = average(&whole.column(i).mean) / scale;
                let Ok(standard) = Atmosphere::STANDARD.temperature_k(level) else { continue };
                let temperature = -STANDARD_GRAVITY_M_S2 / (GAS_CONSTANT_J_KG_K * slope * scale);
                let is_air = (temperature / standard).ln().abs() < TEMPERATURE.ln();
                let is_flown =
                    range[0] > HEIGHTS_M[0] && range[1] < HEIGHTS_M[1] && range[1] - range[0] > LEAST_CHANGE_M;
                let Some((name, size)) = unit_of_pressure(average(&column.mean), level).filter(|_| is_air && is_flown)
                else {
                    continue;
                };
                let height = Taken { column: i, unit, factor: 1.0 / scale, r2 };
                best = Some((height, Taken { column: j, unit: name, factor: 1.0 / size, r2 }));
            }
        }
    }
    if let Some((height, pressure)) = best {
        whole.height = Some([whole.mean_of(height), whole.slope_of(height)]);
        whole.take(Role::Altitude, height, "the logarithm of the static pressure falls with it");
        whole.take(Role::StaticPressure, pressure, "its logarithm falls with the height");
    }
}

/// The pair of an airspeed and a dynamic pressure, `q = rho V^2 / 2`: with the density of the height of the true airspeed, with that at sea
/// level of the calibrated one.
fn find_speed(whole: &mut Assignment<'_>) {
    let air = Atmosphere::STANDARD;
    let Some([height, _]) = whole.height.as_ref() else { return };
    let densities: Vec<f64> = height.iter().map(|height| air.density_kg_m3(*height).unwrap_or(f64::NAN)).collect();
    let (here, Ok(sea)) = (average(&densities), air.density_kg_m3(0.0)) else { return };
    // Near the ground both airspeeds are one: what a pressure shows is the calibrated one.
    let is_apart = (sea / here).ln().abs() > DENSITY_APART.ln();
    let free = whole.free();
    let mut best: Option<(Taken, bool)> = None;
    for &i in free.iter().filter(|i| air::can_be_speed(whole, **i)) {
        for is_true in [false, true].into_iter().filter(|is_true| is_apart || !is_true) {
            let density = |k: usize| if is_true { densities[k] } else { sea };
            let square = whole.each(|k| 0.5 * density(k) * whole.column(i).mean[k].powi(2));
            for &j in free.iter().filter(|j| **j != i && air::is_positive(whole.column(**j))) {
                let found = dynamic(whole, i, j, &square);
                if let Some(speed) = found.filter(|speed| best.is_none_or(|(best, _)| best.r2 < speed.r2)) {
                    best = Some((speed, is_true));
                }
            }
        }
    }
    let Some((speed, is_true)) = best else { return };
    if is_true {
        air::take_speed(whole, speed, "the dynamic pressure is half the density times its square");
        return;
    }
    whole.take(
        Role::CalibratedAirspeed,
        speed,
        "the dynamic pressure is half the density at sea level times its square",
    );
    let wider = (sea / here).sqrt();
    whole.airspeed = Some(whole.mean_of(speed).into_iter().map(|value| wider * value).collect());
    whole.acceleration = Some(whole.slope_of(speed).into_iter().map(|value| wider * value).collect());
}

/// An airspeed whose square over two, times a density, is recorded as a pressure.
fn dynamic(whole: &Assignment<'_>, i: usize, j: usize, square: &[f64]) -> Option<Taken> {
    let pressure = &whole.column(j).mean;
    let (slope, r2) = line(pressure, square).filter(|(slope, r2)| *slope > 0.0 && *r2 > DYNAMIC_R2)?;
    // What switches between two levels fits a line as well as a square.
    let (_, plain) = line(pressure, &whole.column(i).mean)?;
    let level = slope * average(square);
    if 1.0 - r2 > OF_PLAIN * (1.0 - plain) || (average(pressure) - level).abs() > OFFSET * level {
        return None;
    }
    let apart = |scale: f64, size: f64| (slope / size * scale * scale).ln().abs();
    let nearest = |scale: f64| PRESSURES.into_iter().map(|(_, size)| apart(scale, size)).fold(f64::INFINITY, f64::min);
    let mut units = SPEEDS.map(|(unit, scale)| (nearest(scale), unit, scale));
    units.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (apart, unit, scale) = units[0];
    (apart < DENSITY.ln() && units[1].0 > 2.0 * apart).then_some(Taken { column: i, unit, factor: 1.0 / scale, r2 })
}
