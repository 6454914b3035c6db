//! What a constant added to a channel does: where the model has a state for it, that state moves and nothing else.
//!
//! | channel | state that takes a constant `c` | why |
//! |---|---|---|
//! | ax ay az p q r | the bias of the channel, by `c` | the motion sees the sample less its bias |
//! | x y z | the position, by `c` | nothing else depends on where the aircraft is |
//! | v_north v_east v_down | the wind, by `c`, and with it the position, by `c t` | ground velocity is air velocity and wind; the position is its integral, so a position that is measured must drift as well |
//! | alpha, beta | their offsets, by `c`, where these are estimated | the vane shows the angle and its offset |
//!
//! It is not true of bank and pitch (no state: gravity tells them, and the accelerometer biases take a part), of heading (no state: it
//! turns the air velocity against the ground), of airspeed (its state is a factor, not a constant), and of alpha and beta whose
//! offsets are not estimated.

use std::sync::Arc;

use doublet_core::reconstruct::{
    AirState, Deviations, FilterData, FilterSettings, Input, Measurement, Method, Reconstruction, State,
};

use super::behaviour::window;
use super::citation;
use super::reference::run;

const SAMPLES: usize = 1_000;
/// Rounding over a thousand steps, in standard deviations.
const ROUNDING_SIGMA: f64 = 1e-6;

/// Settings that begin where `plain` began, whatever the measurements say.
fn begun(settings: FilterSettings, plain: &Reconstruction) -> FilterSettings {
    FilterSettings { initial_state: std::array::from_fn(|k| Some(plain.states[k][0])), ..settings }
}

fn shifted(data: &FilterData, measurement: Measurement, shift: impl Fn(f64) -> f64) -> FilterData {
    let mut data = data.clone();
    let start_s = data.inputs.time_s[0];
    let series = &mut data.measurements[measurement as usize];
    let values = Arc::make_mut(&mut series.values);
    values.iter_mut().zip(series.time_s.iter()).for_each(|(value, time)| *value += shift(time - start_s));
    data
}

/// Largest difference of `moved` from `plain` with the stated moves, over all states and samples, in standard deviations; of the
/// filtered states and of the smoothed ones where there are such.
fn apart(plain: &Reconstruction, moved: &Reconstruction, moves: &dyn Fn(State, f64) -> f64) -> f64 {
    let mut largest: f64 = 0.0;
    let mut compare =
        |(plain, deviations): (&[Vec<f64>; 18], &[Deviations; 18]), found: &[Vec<f64>; 18], time_s: &[f64]| {
            for state in State::ALL {
                let k = state as usize;
                for (row, time) in time_s.iter().enumerate() {
                    let expected = plain[k][row] + moves(state, time - time_s[0]);
                    largest = largest.max((found[k][row] - expected).abs() / deviations[k].at(row));
                }
            }
        };
    compare((&plain.states, &plain.deviations), &moved.states, &plain.time_s);
    if let (Some(before), Some(after)) = (&plain.smoothed, &moved.smoothed) {
        compare((&before.states, &before.deviations), &after.states, &plain.time_s);
    }
    largest
}

fn methods(settings: &FilterSettings) -> [FilterSettings; 3] {
    let of = |method| FilterSettings { method, smooth: !matches!(method, Method::Ukf { .. }), ..settings.clone() };
    [of(Method::Ekf), of(settings.method), of(Method::Ukf { spread: 1.0 })]
}

#[test]
fn a_constant_on_an_inertial_channel_moves_its_bias_and_nothing_else() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, SAMPLES);
    let biases = [State::BiasAx, State::BiasAy, State::BiasAz, State::BiasP, State::BiasQ, State::BiasR];
    for settings in methods(&citation::settings()) {
        let plain = run(&data, &settings);
        for (input, bias) in Input::ALL.into_iter().zip(biases) {
            let shift = if bias as usize <= State::BiasAz as usize { 0.7 } else { 0.02 };
            let mut other = data.clone();
            let column = Arc::make_mut(&mut other.inputs.columns[input as usize]);
            column.iter_mut().for_each(|value| *value += shift);
            let mut settings = begun(settings.clone(), &plain);
            settings.initial_state[bias as usize] = Some(plain.states[bias as usize][0] + shift);
            let moved = run(&other, &settings);
            let found = apart(&plain, &moved, &|state, _| if state == bias { shift } else { 0.0 });
            assert!(found < ROUNDING_SIGMA, "{:?}, {input:?}: {found}", settings.method);
        }
    }
}

#[test]
fn a_constant_on_the_position_moves_the_position_and_one_on_the_ground_velocity_the_wind() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, SAMPLES);
    let axes = [
        (Measurement::PositionNorth, Measurement::VelocityNorth, State::PositionNorth, State::WindNorth),
        (Measurement::PositionEast, Measurement::VelocityEast, State::PositionEast, State::WindEast),
        (Measurement::PositionDown, Measurement::VelocityDown, State::PositionDown, State::WindDown),
    ];
    for settings in methods(&citation::settings()) {
        let plain = run(&data, &settings);
        for (place, speed, position, wind) in axes {
            let start = |state: State, shift: f64| {
                let mut settings = begun(settings.clone(), &plain);
                settings.initial_state[state as usize] = Some(plain.states[state as usize][0] + shift);
                settings
            };
            let far = run(&shifted(&data, place, |_| 250.0), &start(position, 250.0));
            let found = apart(&plain, &far, &|state, _| if state == position { 250.0 } else { 0.0 });
            assert!(found < ROUNDING_SIGMA, "{:?}, {place:?}: {found}", settings.method);

            let windy = shifted(&shifted(&data, speed, |_| 3.0), place, |time| 3.0 * time);
            let windy = run(&windy, &start(wind, 3.0));
            let moves = |state: State, time: f64| match state {
                _ if state == wind => 3.0,
                _ if state == position => 3.0 * time,
                _ => 0.0,
            };
            let found = apart(&plain, &windy, &moves);
            assert!(found < ROUNDING_SIGMA, "{:?}, {speed:?}: {found}", settings.method);
        }
    }
}

#[test]
fn a_constant_on_a_flow_angle_moves_its_offset_where_that_is_estimated() {
    /// The offset always begins at zero: the first vane sample divides the constant between it, known beforehand to 1 rad, and the
    /// velocity, known to 5 of 90 m/s, by the squares of these. In deviations.
    const PRIOR_SIGMA: f64 = 1e-2;
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, SAMPLES);
    let last = SAMPLES - 1;
    for (measurement, offset) in
        [(Measurement::AngleOfAttack, AirState::AlphaOffset), (Measurement::Sideslip, AirState::BetaOffset)]
    {
        let mut settings = citation::settings();
        settings.air_data_deviation[offset as usize] = 1.0;
        let plain = run(&data, &settings);
        let moved = run(&shifted(&data, measurement, |_| 0.02), &begun(settings, &plain));
        let of = |run: &Reconstruction| run.air_data.as_ref().unwrap().states[offset as usize][last];
        let deviation = plain.air_data.as_ref().unwrap().deviations[offset as usize][last];
        let moved_by = of(&moved) - of(&plain);
        assert!((moved_by - 0.02).abs() < PRIOR_SIGMA * deviation, "{measurement:?}: {moved_by} of {deviation}");
        for state in State::ALL {
            let k = state as usize;
            let change = (moved.states[k][last] - plain.states[k][last]).abs() / plain.deviations[k].at(last);
            assert!(change < PRIOR_SIGMA, "{measurement:?}: {state:?} by {change}");
        }
    }
}

#[test]
fn a_constant_without_a_state_of_its_own_moves_others() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, SAMPLES);
    let plain = run(&data, &citation::settings());
    let last = SAMPLES - 1;
    for (measurement, shift) in [
        (Measurement::BankAngle, 0.01),
        (Measurement::PitchAngle, 0.01),
        (Measurement::HeadingAngle, 0.05),
        (Measurement::Airspeed, 1.0),
        (Measurement::AngleOfAttack, 0.02),
        (Measurement::Sideslip, 0.02),
    ] {
        let moved = run(&shifted(&data, measurement, |_| shift), &begun(citation::settings(), &plain));
        let by = |state: State| {
            let k = state as usize;
            (moved.states[k][last] - plain.states[k][last]).abs() / plain.deviations[k].at(last)
        };
        let pushed = State::ALL.into_iter().filter(|state| by(*state) > 1.0).count();
        assert!(pushed > 1, "{measurement:?} moves {pushed} states by more than a deviation");
    }
}
