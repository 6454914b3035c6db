//! The flight condition of a manoeuvre: one definition for tables, regressions, cards and trims.

use std::ops::Range;

use super::aero::WindowAero;
use super::steadiness::part_before_input;

/// The definition, for the notes of tables.
pub const CONDITION_NOTE: &str =
    "The condition is the mean before the input; of the whole manoeuvre where nothing steady precedes it.";

/// Flight condition of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightCondition {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Altitude, m; absent where none is known.
    pub altitude_m: Option<f64>,
    pub dynamic_pressure_pa: f64,
    /// Angle of attack, rad.
    pub alpha_rad: f64,
}

/// Samples whose mean is the condition: those before the input, all of a manoeuvre without a steady part before it.
pub fn condition_samples(aero: &WindowAero) -> Range<usize> {
    0..part_before_input(aero).map_or(aero.data.time_s.len(), |(_, samples)| samples)
}

/// The condition of a manoeuvre; none without finite samples.
pub fn measure_condition(aero: &WindowAero) -> Option<FlightCondition> {
    let (data, samples) = (&aero.data, condition_samples(aero));
    let column = |values: &[f64]| mean_of_finite(samples.clone().filter_map(|k| values.get(k).copied()));
    let pressures = samples.clone().map(|k| 0.5 * data.density_kg_m3[k] * data.airspeed_m_s[k] * data.airspeed_m_s[k]);
    Some(FlightCondition {
        airspeed_m_s: column(&data.airspeed_m_s)?,
        altitude_m: data.altitude_m.as_ref().and_then(|altitude_m| column(altitude_m)),
        dynamic_pressure_pa: mean_of_finite(pressures)?,
        alpha_rad: column(&data.alpha_rad)?,
    })
}

/// Mean of the finite values; none without any.
pub fn mean_of_finite(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) =
        values.filter(|value| value.is_finite()).fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    Some(sum / count).filter(|mean: &f64| mean.is_finite())
}
