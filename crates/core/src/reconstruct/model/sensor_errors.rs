//! Errors of sensors that are estimated as states: what each does to the measurement it belongs to.

use crate::reconstruct::model::layout::{AirState, Measurement};

/// What a sensor error does to the true value h of a measurement.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// `z = (1 + error) h`.
    Scale,
    /// `z = h + error`, after every scale.
    Offset,
}

/// Measurement that an error belongs to, and what it does to it.
pub fn effect(state: AirState) -> (Measurement, Effect) {
    match state {
        AirState::AlphaOffset => (Measurement::AngleOfAttack, Effect::Offset),
        AirState::BetaOffset => (Measurement::Sideslip, Effect::Offset),
        AirState::Upwash => (Measurement::AngleOfAttack, Effect::Scale),
        AirState::AirspeedScale => (Measurement::Airspeed, Effect::Scale),
        AirState::Sidewash => (Measurement::Sideslip, Effect::Scale),
    }
}
