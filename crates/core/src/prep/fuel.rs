//! Fuel mass from probes that see only part of it, and from fuel flow (thesis section 4.2).

use super::{PrepError, check, cumulative_trapezoid};
use crate::airframe::instruments::FuelProbe;
use crate::series::TimeRange;

/// How indications are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuelSettings {
    /// Step of the indication, kg.
    pub resolution_kg: f64,
    /// A zone is blind where one step of the indication spans more than this many steps of fuel.
    pub max_span: f64,
    /// A zone stays blind this long before and after its readings, s: noise at its edge looks like sight.
    pub settle_s: f64,
    /// Lets no tank fill up: the histories are the least-squares fit that never rises.
    pub never_rises: bool,
}

impl Default for FuelSettings {
    /// One pound, three steps, 30 s, never rising.
    fn default() -> Self {
        Self { resolution_kg: 0.453_592_37, max_span: 3.0, settle_s: 30.0, never_rises: true }
    }
}

/// What an indication means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuelReading {
    /// Fuel, kg: the middle of what the indication allows.
    pub mass_kg: f64,
    /// Least fuel that shows as this within half a step, kg.
    pub least_kg: f64,
    /// Most fuel that shows as this within half a step, kg.
    pub most_kg: f64,
    /// The probe tells little here: empty or full, or a step of its curve.
    pub blind: bool,
}

/// Fuel for an indication: the calibration read backwards with straight lines between its points (thesis Tables 4.9-4.10).
/// An indication above the calibration's counts as its highest, and is blind where it is more than a step above.
pub fn fuel_reading(probe: &FuelProbe, displayed_kg: f64, settings: &FuelSettings) -> FuelReading {
    let half = 0.5 * settings.resolution_kg;
    let highest = probe.displayed_kg.last().copied().unwrap_or(0.0);
    let above = displayed_kg - highest > settings.resolution_kg;
    let displayed_kg = displayed_kg.min(highest);
    let (least_kg, most_kg) = (least(probe, displayed_kg - half), most(probe, displayed_kg + half));
    FuelReading {
        mass_kg: 0.5 * (least(probe, displayed_kg) + most(probe, displayed_kg)),
        least_kg,
        most_kg,
        blind: above || most_kg - least_kg > settings.max_span * settings.resolution_kg,
    }
}

/// Least fuel for which the probe shows `displayed` or more; the most of the calibration beyond its end.
fn least(probe: &FuelProbe, displayed: f64) -> f64 {
    let (shown, actual) = (&probe.displayed_kg, &probe.actual_kg);
    match shown.partition_point(|&value| value < displayed) {
        0 => actual[0],
        k if k == shown.len() => actual[k - 1],
        k => actual[k - 1] + (displayed - shown[k - 1]) / (shown[k] - shown[k - 1]) * (actual[k] - actual[k - 1]),
    }
}

/// Most fuel for which the probe shows `displayed` or less; the least of the calibration before its start.
fn most(probe: &FuelProbe, displayed: f64) -> f64 {
    let (shown, actual) = (&probe.displayed_kg, &probe.actual_kg);
    match shown.partition_point(|&value| value <= displayed) {
        0 => actual[0],
        k if k == shown.len() => actual[k - 1],
        k => actual[k - 1] + (displayed - shown[k - 1]) / (shown[k] - shown[k - 1]) * (actual[k] - actual[k - 1]),
    }
}

/// Time during which a probe told little.
#[derive(Clone, Debug, PartialEq)]
pub struct BlindZone {
    /// Tank.
    pub tank: String,
    /// When.
    pub window: TimeRange,
    /// Least fuel it may have been, kg.
    pub least_kg: f64,
    /// Most fuel it may have been, kg.
    pub most_kg: f64,
}

/// Fuel against time.
#[derive(Clone, Debug, PartialEq)]
pub struct FuelHistory {
    /// Fuel of each tank, in the order given, kg.
    pub tank_kg: Vec<Vec<f64>>,
    /// Fuel of all tanks, kg.
    pub total_kg: Vec<f64>,
    /// When which probe told little.
    pub blind: Vec<BlindZone>,
}

/// Weight of a blind reading beside one of a probe that sees.
const BLIND_WEIGHT: f64 = 1e-3;

/// Fuel of each tank and in all, against the common stamps of their probes' indications (kg).
///
/// An indication that is not finite counts as the one before it.
///
/// # Errors
/// Lengths that differ, time that does not increase, no samples, a resolution that is not above zero.
pub fn fuel_history(
    time_s: &[f64],
    tanks: &[(&FuelProbe, &[f64])],
    settings: &FuelSettings,
) -> Result<FuelHistory, PrepError> {
    if !(settings.resolution_kg > 0.0 && settings.resolution_kg.is_finite()) {
        let value = settings.resolution_kg;
        return Err(PrepError::Setting { setting: "resolution_kg", value, allowed: "finite and above zero" });
    }
    let mut history = FuelHistory { tank_kg: Vec::new(), total_kg: vec![0.0; time_s.len()], blind: Vec::new() };
    for (probe, displayed) in tanks {
        check(time_s, displayed, "a fuel history", 1)?;
        let mut last = displayed.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
        let mut readings = Vec::with_capacity(displayed.len());
        for &value in *displayed {
            last = if value.is_finite() { value } else { last };
            readings.push(fuel_reading(probe, last, settings));
        }
        widen(time_s, &mut readings, settings.settle_s);
        history.blind.extend(blind_zones(&probe.tank, time_s, &readings));
        let masses = if settings.never_rises {
            never_rising(&readings)
        } else {
            readings.iter().map(|reading| reading.mass_kg).collect()
        };
        history.total_kg.iter_mut().zip(&masses).for_each(|(total, mass)| *total += mass);
        history.tank_kg.push(masses);
    }
    Ok(history)
}

/// Marks readings blind that lie within a time of a blind one.
fn widen(time_s: &[f64], readings: &mut [FuelReading], settle_s: f64) {
    let blind: Vec<bool> = readings.iter().map(|reading| reading.blind).collect();
    let mut mark = |order: &mut dyn Iterator<Item = usize>| {
        let mut last = f64::INFINITY;
        for k in order {
            last = if blind[k] { time_s[k] } else { last };
            readings[k].blind |= (time_s[k] - last).abs() <= settle_s;
        }
    };
    mark(&mut (0..time_s.len()));
    mark(&mut (0..time_s.len()).rev());
}

/// Stretches of blind readings.
fn blind_zones(tank: &str, time_s: &[f64], readings: &[FuelReading]) -> Vec<BlindZone> {
    let mut zones: Vec<BlindZone> = Vec::new();
    let mut open = false;
    for (&time, reading) in time_s.iter().zip(readings) {
        match zones.last_mut() {
            Some(zone) if open && reading.blind => {
                zone.window.end_s = time;
                zone.least_kg = zone.least_kg.min(reading.least_kg);
                zone.most_kg = zone.most_kg.max(reading.most_kg);
            }
            _ if reading.blind => zones.push(BlindZone {
                tank: tank.to_owned(),
                window: TimeRange { start_s: time, end_s: time },
                least_kg: reading.least_kg,
                most_kg: reading.most_kg,
            }),
            _ => {}
        }
        open = reading.blind;
    }
    zones
}

/// Weighted least-squares fit that never rises, by pooling neighbours that do (Barlow et al., "Statistical Inference under
/// Order Restrictions", section 1.2).
fn never_rising(readings: &[FuelReading]) -> Vec<f64> {
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for reading in readings {
        let weight = if reading.blind { BLIND_WEIGHT } else { 1.0 };
        let mut pool = (reading.mass_kg, weight, 1);
        while let Some(&(mean, before, count)) = pools.last() {
            if mean >= pool.0 {
                break;
            }
            let total = before + pool.1;
            pool = ((mean * before + pool.0 * pool.1) / total, total, count + pool.2);
            pools.pop();
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(mean, _, count)| std::iter::repeat_n(mean, count)).collect()
}

/// Fuel left, kg, from the fuel at the first stamp and the flow (kg/s): `m = m0 - integral of the flow` by trapezoids.
///
/// # Errors
/// Lengths that differ, time that does not increase, no samples.
pub fn fuel_from_flow(time_s: &[f64], flow_kg_s: &[f64], initial_kg: f64) -> Result<Vec<f64>, PrepError> {
    let burnt = cumulative_trapezoid(time_s, flow_kg_s)?;
    Ok(burnt.into_iter().map(|burnt| initial_kg - burnt).collect())
}
