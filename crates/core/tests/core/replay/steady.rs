//! The replay from a trim against the simulator's own trim and against the drag taken away.

use doublet_core::model::{Coefficient, Derivatives};
use doublet_core::replay::{Replay, ReplayError, SteadyCondition};

use super::{flown, settings, truth, wind};

/// Two trims by different unknowns and equations, rad and over the thrust.
const SAME: f64 = 1e-7;

#[test]
fn a_trimmed_start_is_the_simulators_trim_and_a_change_of_drag_changes_its_thrust() {
    let flown = flown(12.0);
    let replay = Replay::new(&flown.data, &settings(&flown.vehicle), &wind(flown.data.time_s.len()), 9.80665).unwrap();
    let model = truth(&flown.vehicle);
    let velocity = flown.start.air_velocity_body_m_s;
    let airspeed_m_s = velocity.iter().map(|part| part * part).sum::<f64>().sqrt();
    let condition =
        SteadyCondition { airspeed_m_s, path_rad: 0.0, turn_rate_rad_s: 0.0, flow_rad: [0.1, -0.02], bank_rad: 0.05 };
    // The first input begins after 2 s.
    let (trimmed, start, trim) = replay.from_trim(&model, 0..90, &condition, &flown.start).unwrap();
    let alpha = velocity[2].atan2(velocity[0]);
    assert!((trim.alpha_rad - alpha).abs() < SAME, "{} for {alpha}", trim.alpha_rad);
    for (found, flown) in start.euler_rad.iter().zip(flown.start.euler_rad) {
        assert!((found - flown).abs() < SAME, "{found} for {flown}");
    }
    for (found, recorded) in trim.controls_rad.iter().zip(trim.recorded_controls_rad) {
        assert!((found - recorded).abs() < SAME, "{found} for {recorded}");
    }
    assert!((trim.thrust_n / trim.recorded_thrust_n - 1.0).abs() < SAME, "{trim:?}");
    // It then flies as the aircraft did.
    let [own, as_recorded] = [(&trimmed, &start), (&replay, &flown.start)].map(|(replay, start)| {
        let response = replay.fly(&model, start).unwrap();
        response.euler_rad[1].last().copied().unwrap()
    });
    assert!((own - as_recorded).abs() < 1e-5, "{own} for {as_recorded}");
    // Drag of 0.01: the thrust of the trim grows by 0.01 q S along body x, but for the small change of the angle of attack.
    let draggy: Derivatives = model
        .entries()
        .iter()
        .map(|entry| {
            let more = entry.coefficient == Coefficient::CX && entry.term.is_constant();
            (entry.coefficient, entry.term.clone(), entry.value - if more { 0.01 } else { 0.0 })
        })
        .collect();
    let (_, _, dragged) = replay.from_trim(&draggy, 0..90, &condition, &flown.start).unwrap();
    let pressure = 0.5 * flown.data.density_kg_m3[0] * airspeed_m_s * airspeed_m_s;
    let expected_n = 0.01 * pressure * settings(&flown.vehicle).reference.area_m2;
    let added_n = dragged.thrust_n - trim.thrust_n;
    assert!((added_n / expected_n - 1.0).abs() < 0.02, "{added_n} N for {expected_n} N");
    // No steady sample, and a speed at which no wing holds the aircraft.
    let none = replay.from_trim(&model, 5..5, &condition, &flown.start).unwrap_err();
    assert!(matches!(none, ReplayError::TooShort { .. }), "{none}");
    let slow = SteadyCondition { airspeed_m_s: 1.0, ..condition };
    let none = replay.from_trim(&model, 0..90, &slow, &flown.start);
    assert!(none.is_err() || none.is_ok_and(|(_, _, trim)| trim.alpha_rad.abs() > 1.0));
}
