//! Constant errors of the instruments of a simulated flight, drawn from the accuracies its scenario states.

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::instruments::Quantity;
use crate::quantity::InstrumentError;

/// Values by error, SI: standard deviations of a scenario, or what one flight has of them.
pub type InstrumentErrors = BTreeMap<InstrumentError, f64>;

/// What a stream reads of a quantity in place of its value `x(t)`: `(1 + scale) x(t - delay) + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuantityError {
    pub(super) quantity: Quantity,
    pub(super) offset: f64,
    pub(super) scale: f64,
    pub(super) delay_s: f64,
}

/// The recorders of the flight-test installation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recorder {
    Bus,
    Monitor,
    Pod,
    ControlSensors,
}

/// Independent normal errors of these standard deviations.
pub(super) fn draw(accuracies: &InstrumentErrors, rng: &mut ChaCha8Rng) -> InstrumentErrors {
    accuracies.iter().map(|(error, deviation)| (*error, deviation * rng.sample::<f64, _>(StandardNormal))).collect()
}

/// What the streams of a recorder read in error.
pub(super) fn quantity_errors(recorder: Recorder, errors: &InstrumentErrors) -> Vec<QuantityError> {
    use InstrumentError as E;
    use Quantity as Q;
    /// A quantity with its offset, its scale and its delay.
    type Row = (Quantity, [Option<InstrumentError>; 3]);
    let delayed = |quantity, error| (quantity, [None, None, Some(error)]);
    let rows: Vec<Row> = match recorder {
        Recorder::Bus => vec![
            delayed(Q::Bank, E::AttitudeDelay),
            delayed(Q::Pitch, E::AttitudeDelay),
            delayed(Q::HeadingUnwrapped, E::AttitudeDelay),
            delayed(Q::TrueAirspeed, E::AirspeedDelay),
            delayed(Q::CalibratedAirspeed, E::AirspeedDelay),
            delayed(Q::VelocityNorth, E::GroundDelay),
            delayed(Q::VelocityEast, E::GroundDelay),
            delayed(Q::VelocityUp, E::GroundDelay),
            delayed(Q::GpsAltitude, E::AltitudeDelay),
        ],
        Recorder::Monitor => Vec::new(),
        Recorder::Pod => vec![
            (Q::Alpha, [Some(E::AlphaOffset), Some(E::AlphaScale), Some(E::FlowDelay)]),
            (Q::Beta, [Some(E::BetaOffset), Some(E::BetaScale), Some(E::FlowDelay)]),
        ],
        Recorder::ControlSensors => vec![
            delayed(Q::Yoke, E::AileronDelay),
            delayed(Q::ColumnDrum, E::ElevatorDelay),
            delayed(Q::RightPedalDrum, E::RudderDelay),
            delayed(Q::LeftPedalDrum, E::RudderDelay),
        ],
    };
    let value = |error: Option<InstrumentError>| error.and_then(|error| errors.get(&error)).copied().unwrap_or(0.0);
    rows.into_iter()
        .map(|(quantity, own)| {
            let [offset, scale, delay_s] = own.map(value);
            QuantityError { quantity, offset, scale, delay_s }
        })
        .filter(|error| [error.offset, error.scale, error.delay_s] != [0.0; 3])
        .collect()
}

/// Offset, scale and delay of a column of the truth as the recorders give it.
pub(super) fn column_errors(column: &str, errors: &InstrumentErrors) -> [f64; 3] {
    use InstrumentError as E;
    let own = match column {
        "alpha" => [Some(E::AlphaOffset), Some(E::AlphaScale), Some(E::FlowDelay)],
        "beta" => [Some(E::BetaOffset), Some(E::BetaScale), Some(E::FlowDelay)],
        "airspeed" => [None, None, Some(E::AirspeedDelay)],
        "phi" | "theta" | "psi" => [None, None, Some(E::AttitudeDelay)],
        "x" | "y" | "v_north" | "v_east" | "v_down" => [None, None, Some(E::GroundDelay)],
        "z" => [None, None, Some(E::AltitudeDelay)],
        "delta_a" => [None, None, Some(E::AileronDelay)],
        "delta_e" => [None, None, Some(E::ElevatorDelay)],
        "delta_r" => [None, None, Some(E::RudderDelay)],
        _ => [None; 3],
    };
    own.map(|error| error.and_then(|error| errors.get(&error)).copied().unwrap_or(0.0))
}
