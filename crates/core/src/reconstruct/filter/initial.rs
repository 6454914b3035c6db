//! Initial state from the first measurements.

use crate::message;
use crate::message::Message;
use crate::quantity::Dimension;
use crate::reconstruct::data::{FilterData, MeasurementSeries};
use crate::reconstruct::model::layout::{Measurement, STATES, State};
use crate::reconstruct::settings::FilterSettings;

/// Initial state: what the settings give, the rest from the first value of each measurement. Attitude that was not
/// measured is level and along the ground track; flow angles that were not measured are zero; airspeed that was not
/// measured is ground speed. Biases and wind start at zero. One line for the states that were neither given nor measured, except the
/// horizontal position, on which nothing depends.
pub fn initial_state(data: &FilterData, settings: &FilterSettings, warnings: &mut Vec<Message>) -> [f64; STATES] {
    let first = |measurement: Measurement| first_value(&data.measurements[measurement as usize]);
    let mut assumed: Vec<State> = Vec::new();
    let mut or_assume = |value: Option<f64>, otherwise: f64, state: State| {
        let matters = !matches!(state, State::PositionNorth | State::PositionEast);
        if matters && value.is_none() && settings.initial_state[state as usize].is_none() {
            assumed.push(state);
        }
        value.unwrap_or(otherwise)
    };
    let mut x = [0.0; STATES];
    for (state, measurement) in [
        (State::PositionNorth, Measurement::PositionNorth),
        (State::PositionEast, Measurement::PositionEast),
        (State::PositionDown, Measurement::PositionDown),
        (State::BankAngle, Measurement::BankAngle),
        (State::PitchAngle, Measurement::PitchAngle),
    ] {
        x[state as usize] = or_assume(first(measurement), 0.0, state);
    }
    let track = [Measurement::VelocityNorth, Measurement::VelocityEast].map(|m| first(m).unwrap_or(0.0));
    x[State::HeadingAngle as usize] =
        or_assume(first(Measurement::HeadingAngle), track[1].atan2(track[0]), State::HeadingAngle);

    let ground_speed = track[0].hypot(track[1]);
    let speed = or_assume(first(Measurement::Airspeed), ground_speed, State::VelocityU);
    let beta = or_assume(first(Measurement::Sideslip), 0.0, State::VelocityV);
    let alpha = or_assume(first(Measurement::AngleOfAttack), 0.0, State::VelocityW);
    x[State::VelocityU as usize] = speed * alpha.cos() * beta.cos();
    x[State::VelocityV as usize] = speed * beta.sin();
    x[State::VelocityW as usize] = speed * alpha.sin() * beta.cos();

    for (value, given) in x.iter_mut().zip(settings.initial_state) {
        *value = given.unwrap_or(*value);
    }
    if !assumed.is_empty() {
        let one = |state: &State| match state.dimension() {
            Dimension::Angle => message!("{} {:.1} deg", state.name(), x[*state as usize].to_degrees()),
            dimension => message!("{} {:.1} {}", state.name(), x[*state as usize], dimension.si_symbol()),
        };
        let all = Message::join(assumed.iter().map(one), ", ");
        warnings.push(message!("initial {} assumed: neither given nor measured", all));
    }
    x
}

fn first_value(series: &MeasurementSeries) -> Option<f64> {
    series.values.iter().copied().find(|value| value.is_finite())
}
