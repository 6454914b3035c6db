//! Conservation, order of the integration, trim, modes and refusals.

use doublet_core::airframe::InertiaTensor;
use doublet_core::atmos::Atmosphere;
use doublet_core::simulate::{
    AeroModel, Body, Controls, Environment, FactoredInertia, Mode, SimulateError, State, Trim, TrimCondition, Vehicle,
    c337f, modes, runge_kutta, trim,
};
use nalgebra::Vector3;

/// Step of all shipped flights, s.
const STEP_S: f64 = 0.01;
/// Conservation demanded over a minute, relative.
const CONSERVATION: f64 = 1e-9;
const FT: f64 = 0.3048;
const KT: f64 = 1852.0 / 3600.0;
const RPM: f64 = std::f64::consts::TAU / 60.0;

fn atmosphere() -> Atmosphere {
    Atmosphere::new(101_325.0, 296.65).unwrap()
}

fn condition(altitude_ft: f64, airspeed_kt: f64) -> TrimCondition {
    TrimCondition {
        airspeed_m_s: airspeed_kt * KT,
        altitude_m: altitude_ft * FT,
        heading_rad: 0.7,
        engine_speed_rad_s: 2350.0 * RPM,
        wind_ned_m_s: Vector3::new(3.0, -4.0, 0.0),
    }
}

fn trimmed(altitude_ft: f64, airspeed_kt: f64) -> (Vehicle, Body, Trim) {
    let (vehicle, loading) = c337f().unwrap();
    let body = vehicle.body(&loading).unwrap();
    let trim = trim(&vehicle, &body, &atmosphere(), &condition(altitude_ft, airspeed_kt)).unwrap();
    (vehicle, body, trim)
}

/// Flies hands off with constant air from a state.
fn fly(
    vehicle: &Vehicle,
    body: &Body,
    environment: &Environment,
    mut state: State,
    step_s: f64,
    steps: usize,
) -> State {
    for _ in 0..steps {
        state = runge_kutta(&state, step_s, |_, state| vehicle.loads(body, state, environment).rate(state));
    }
    state
}

#[test]
fn free_flight_without_air_keeps_energy() {
    let (mut vehicle, loading) = c337f().unwrap();
    vehicle.aero = AeroModel::none();
    let body = vehicle.body(&loading).unwrap();
    let mut environment = Environment::still(&vehicle, &atmosphere(), 9000.0).unwrap();
    environment.ground_m = f64::NEG_INFINITY;
    let mut state = State::new(Vector3::new(0.0, 0.0, -9000.0), Vector3::new(60.0, 20.0, -150.0), [0.3, 0.2, 0.1]);
    state.rates_rad_s = Vector3::new(0.5, -0.3, 0.4);
    let tensor = *body.inertia.tensor();
    let mass = body.properties.mass_kg;
    let energy = |s: &State| {
        let spin = s.rates_rad_s.dot(&(tensor * s.rates_rad_s)) / mass;
        0.5 * (s.velocity_ned_m_s.norm_squared() + spin) - environment.gravity_m_s2 * s.position_ned_m.z
    };
    let before = energy(&state);
    let after = energy(&fly(&vehicle, &body, &environment, state, STEP_S, 6000));
    println!("energy: {:.1e} relative", after / before - 1.0);
    assert!((after / before - 1.0).abs() < CONSERVATION, "{:e}", after / before - 1.0);
}

#[test]
fn torque_free_rotation_keeps_angular_momentum() {
    // Thesis section 7.2.1, kg m².
    let inertia = InertiaTensor { xz: 311.0, ..InertiaTensor::diagonal(5493.0, 5411.0, 9689.0) };
    let inertia = FactoredInertia::new(&inertia).unwrap();
    let mut state = State::new(Vector3::zeros(), Vector3::zeros(), [0.3, 0.2, 0.1]);
    state.rates_rad_s = Vector3::new(0.5, -0.3, 0.4);
    let rotor = Vector3::new(1900.0, 0.0, 0.0);
    let momentum = |s: &State| s.body_from_ned().tr_mul(&(inertia.tensor() * s.rates_rad_s + rotor));
    let before = momentum(&state);
    for _ in 0..6000 {
        state = runge_kutta(&state, STEP_S, |_, s| {
            s.rate(Vector3::zeros(), inertia.angular_acceleration(Vector3::zeros(), s.rates_rad_s, rotor))
        });
    }
    let change = (momentum(&state) - before).norm() / before.norm();
    println!("angular momentum: {change:.1e} relative");
    assert!(change < CONSERVATION, "{change:e}");
}

#[test]
fn halving_the_step_changes_the_trajectory_as_fourth_order_does() {
    let (vehicle, body, trim) = trimmed(4000.0, 90.0);
    let mut environment = trim.environment;
    // A disturbed flight of four seconds: every part of the equations moves.
    environment.controls = Controls { aileron: 0.02, elevator: environment.controls.elevator - 0.02, rudder: 0.01 };
    let end = |halvings: u32| {
        let steps = 100 << halvings;
        fly(&vehicle, &body, &environment, trim.state, 4.0 / f64::from(steps), steps as usize)
    };
    let difference = |a: &State, b: &State| {
        (a.velocity_ned_m_s - b.velocity_ned_m_s).norm() + (a.rates_rad_s - b.rates_rad_s).norm()
    };
    let states: Vec<State> = (0..4).map(end).collect();
    let ratios: Vec<f64> = states.windows(3).map(|s| difference(&s[0], &s[1]) / difference(&s[1], &s[2])).collect();
    println!("error ratios on halving the step: {ratios:.2?}");
    // 2^4 in the limit of small steps.
    assert!(ratios.iter().all(|ratio| (14.0..18.0).contains(ratio)), "{ratios:?}");
}

#[test]
fn trimmed_aircraft_stays_in_trim_hands_off() {
    for (altitude_ft, airspeed_kt) in [(4000.0, 90.0), (6500.0, 117.0), (2500.0, 101.0)] {
        let (vehicle, body, trim) = trimmed(altitude_ft, airspeed_kt);
        let end = fly(&vehicle, &body, &trim.environment, trim.state, STEP_S, 1000);
        let before = trim.state.euler_rad();
        let turned = end.euler_rad().into_iter().zip(before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let climbed = (end.position_ned_m.z - trim.state.position_ned_m.z).abs();
        let sped = (end.velocity_ned_m_s - trim.state.velocity_ned_m_s).norm();
        println!("{altitude_ft} ft {airspeed_kt} kt hands off 10 s: {turned:.1e} rad, {climbed:.1e} m, {sped:.1e} m/s");
        // What ten seconds of a slightly unstable spiral make of residuals of 1e-11.
        assert!(turned < 1e-8 && climbed < 1e-6 && sped < 1e-6, "{turned:e} rad, {climbed:e} m, {sped:e} m/s");
    }
}

#[test]
fn short_period_and_dutch_roll_are_stable_and_of_usual_size() {
    for (altitude_ft, airspeed_kt) in [(4000.0, 90.0), (6500.0, 117.0), (2500.0, 101.0)] {
        let (vehicle, body, trim) = trimmed(altitude_ft, airspeed_kt);
        let modes = modes(&vehicle, &body, &trim);
        for mode in &modes {
            println!(
                "{altitude_ft} ft {airspeed_kt} kt: {:<16} {:7.3} rad/s damping {:6.3} time constant {:8.2} s",
                mode.name,
                mode.frequency_rad_s(),
                mode.damping(),
                mode.time_constant_s()
            );
        }
        let get = |name: &str| -> &Mode { modes.iter().find(|mode| mode.name == name).unwrap() };
        let (short, dutch, roll) = (get("short period"), get("Dutch roll"), get("roll subsidence"));
        assert!(short.is_stable() && (1.5..6.0).contains(&short.frequency_rad_s()) && short.damping() > 0.3);
        assert!(dutch.is_stable() && (0.8..3.0).contains(&dutch.frequency_rad_s()) && dutch.damping() > 0.02);
        assert!(roll.is_stable() && roll.time_constant_s() < 1.0);
        assert!(get("phugoid").frequency_rad_s() < 0.5 && get("spiral").time_constant_s().abs() > 10.0);
    }
}

#[test]
fn trim_says_what_is_missing_and_by_how_much() {
    let (vehicle, loading) = c337f().unwrap();
    let body = vehicle.body(&loading).unwrap();
    let fail = |altitude_ft: f64, airspeed_kt: f64| {
        trim(&vehicle, &body, &atmosphere(), &condition(altitude_ft, airspeed_kt)).unwrap_err()
    };
    let slow = fail(4000.0, 60.0);
    assert!(
        matches!(slow, SimulateError::TrimPastAlpha { needed_deg, high_deg, .. } if needed_deg > high_deg),
        "{slow}"
    );
    let high = fail(15_000.0, 95.0);
    assert!(
        matches!(high, SimulateError::TrimPastThrust { needed_n, available_n, missing_n, .. }
            if missing_n > 0.0 && needed_n == available_n + missing_n),
        "{high}"
    );
    let mut weak = vehicle.clone();
    weak.stops.elevator = (-0.01, 0.01);
    let stopped = trim(&weak, &body, &atmosphere(), &condition(4000.0, 110.0)).unwrap_err();
    assert!(
        matches!(stopped, SimulateError::PastStop { surface: "elevator", past_deg, .. } if past_deg > 0.0),
        "{stopped}"
    );
}

#[test]
fn counter_rotating_propellers_leave_no_gyroscopic_coupling() {
    let (_, _, trim) = trimmed(4000.0, 90.0);
    assert!(trim.environment.rotor_momentum_n_m_s.norm() < 1e-9);
}
