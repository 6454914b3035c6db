//! Tests of an aircraft on the ground: inertia from swinging, static thrust.

mod static_thrust;
mod swing;

pub use static_thrust::{Pulled, PulledReading, StaticThrustFile};
pub use swing::{InertiaRow, SwingFile, Swung, SwungRow};

use doublet_core::statistics::NORMAL_95;

/// A number that must lie in a range, with the words of the refusal.
fn within(key: &str, value: f64, (low, high): (f64, f64), unit: &str) -> Result<f64, String> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{key} is {value}, allowed is {low} to {high} {unit}"))
    }
}

/// The 95 % interval of an estimate.
fn interval_95(value: f64, error: f64) -> [f64; 2] {
    [value - NORMAL_95 * error, value + NORMAL_95 * error]
}
