//! The unit against the flight that the replay integrates by quaternions, with the same steps.

#![expect(clippy::unwrap_used, reason = "a test helper that fails is a failed test")]

#[expect(dead_code, reason = "of what other tests share, one window is needed")]
#[path = "../../core/tests/common/flight.rs"]
mod flight;

use doublet_core::airframe::MassHistory;
use doublet_core::model::{Axes, Position, ThrustTreatment};
use doublet_core::quantity::Role;
use doublet_core::replay::Replay;
use doublet_dynamics::linear::{Condition, FlightModel, Simulation, SteadyFlight, ThrustLine};
use doublet_fmu::{Instance, Unit, Variable, VariableKind, variables};

/// Step, s, and steps of the comparison.
const STEP_S: f64 = 0.005;
const STEPS: usize = 4000;
/// Aileron, elevator, rudder that are held, rad.
const CONTROLS: [f64; 3] = [0.004, -0.03, -0.01];

/// The window with constant controls on a finer clock, and the simulation of the same flight. The density of the air is constant above
/// the atmosphere of the model, so the flight is put there.
fn both() -> (Replay, doublet_core::replay::Start, Simulation) {
    let (mut data, settings, mut start) = flight::window(STEPS + 1);
    data.time_s = (0..=STEPS).map(|k| STEP_S * k as f64).collect();
    for (role, value) in [Role::Aileron, Role::Elevator, Role::Rudder].into_iter().zip(CONTROLS) {
        data.controls.insert(role, vec![value; STEPS + 1].into());
    }
    start.position_ned_m = [0.0; 3];
    let MassHistory::Constant(mass) = data.mass else { unreachable!("the window has one loading") };
    let [u, v, w] = start.air_velocity_body_m_s;
    let ([p, q, r], [phi, theta, psi]) = (start.rates_rad_s, start.euler_rad);
    let altitude_m = 40_000.0;
    let simulation = Simulation {
        model: FlightModel {
            derivatives: flight::truth(),
            reference: settings.reference,
            axes: Axes::Body,
            moment_reference: None,
            thrust: ThrustTreatment::Removed,
            engines: Vec::new(),
        },
        condition: Condition {
            airspeed_m_s: 46.0,
            altitude_m,
            density_kg_m3: data.density_kg_m3[0],
            speed_of_sound_m_s: 300.0,
            gravity_m_s2: flight::GRAVITY_M_S2,
            gamma_rad: None,
            flight: SteadyFlight::Straight,
            mass,
            thrust_slope_n_s_m: 0.0,
            pressure_rise_pa: 0.0,
            rotor_momentum_n_m_s: 0.0,
            recorded: Default::default(),
        },
        state: [u, v, w, p, q, r, phi, theta, psi, 0.0, 0.0, altitude_m],
        input: [CONTROLS[0], CONTROLS[1], CONTROLS[2], 0.0],
    };
    let still = std::array::from_fn(|_| vec![0.0; STEPS + 1]);
    (Replay::new(&data, &settings, &still, flight::GRAVITY_M_S2).unwrap(), start, simulation)
}

#[test]
fn the_unit_flies_what_the_replay_flies() {
    let (replay, start, simulation) = both();
    let expected = replay.fly(&flight::truth(), &start).unwrap();
    let mut unit = Instance::new(&simulation.to_json().unwrap()).unwrap();
    let mut worst = 0.0_f64;
    for k in 0..STEPS {
        unit.step(STEP_S * k as f64, STEP_S).unwrap();
        let state = unit.state();
        let [air, rates, euler] = [&expected.air_velocity_body_m_s, &expected.rates_rad_s, &expected.euler_rad];
        let known = [air, rates, euler, &expected.position_ned_m];
        for (index, value) in state.iter().enumerate().take(11) {
            let expected = known[index / 3][index % 3][k + 1];
            worst = worst.max((value - expected).abs() / expected.abs().max(1.0));
        }
    }
    let climbed = expected.position_ned_m[2].last().unwrap();
    let bank = expected.euler_rad[0].iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
    assert!(bank > 0.2 && climbed.abs() > 5.0, "a flight that does nothing compares nothing: {bank} rad, {climbed} m");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn variables_are_set_and_read_by_their_value_references() {
    let (_, _, simulation) = both();
    let text = simulation.to_json().unwrap();
    assert_eq!(Simulation::from_json(&text).unwrap(), simulation);
    let names: Vec<String> =
        (0..simulation.model.derivatives.entries().len()).map(|index| format!("d{index}")).collect();
    let mut unit = Instance::new(&text).unwrap();
    let all = variables(&simulation, &names);
    for Variable { reference, name, kind, start, description, .. } in &all {
        assert!(description.len() > 4, "{name}");
        let mut value = [f64::NAN];
        unit.get(&[*reference], &mut value).unwrap();
        let [value] = value;
        match kind {
            VariableKind::Rate(of) => assert!(all.iter().any(|other| other.reference == *of), "{name}"),
            VariableKind::Output => assert!(value.is_finite(), "{name}"),
            _ => assert_eq!(value, *start, "{name}"),
        }
        let can_be_set = !matches!(kind, VariableKind::Rate(_) | VariableKind::Output);
        assert_eq!(unit.set(*reference, 0.5).is_some(), can_be_set, "{name}");
    }
    assert_eq!((unit.get(&[99], &mut [0.0]), unit.set(0, 1.0)), (None, None));
    unit.reset();
    assert_eq!(*unit.state(), simulation.state);
}

/// Value of a variable by name.
fn value(unit: &Instance, all: &[Variable], name: &str) -> f64 {
    let mut values = [f64::NAN];
    unit.get(&[all.iter().find(|variable| variable.name == name).unwrap().reference], &mut values).unwrap();
    values[0]
}

/// An engine along body x through the centre of gravity accelerates the aircraft by T/m; T follows from setting, slope and airspeed.
#[test]
fn thrust_acting_is_an_output_and_its_slope_a_parameter() {
    const SETTING_N: f64 = 2500.0;
    const SLOPE_N_S_M: f64 = -40.5;
    let (_, _, mut simulation) = both();
    simulation.model.engines =
        vec![ThrustLine { position: Position::BodyFromCg([0.0; 3]), direction_body: [1.0, 0.0, 0.0], share: 1.0 }];
    let all = variables(&simulation, &[]);
    let reference = |name: &str| all.iter().find(|variable| variable.name == name).unwrap().reference;
    let mut unit = Instance::new(&simulation.to_json().unwrap()).unwrap();
    let drag = value(&unit, &all, "ax");
    let airspeed = value(&unit, &all, "airspeed");
    let mass_kg = simulation.condition.mass.mass_kg;
    for (slope, at) in [(SLOPE_N_S_M, 46.0), (SLOPE_N_S_M, 30.0), (0.0, 30.0)] {
        unit.set(reference("thrust_reference"), SETTING_N).unwrap();
        unit.set(reference("thrust_slope"), slope).unwrap();
        unit.set(reference("thrust_reference_airspeed"), at).unwrap();
        let thrust = value(&unit, &all, "thrust");
        assert!((thrust - (SETTING_N + slope * (airspeed - at))).abs() < 1e-9, "{thrust}");
        assert!((value(&unit, &all, "ax") - drag - thrust / mass_kg).abs() < 1e-12);
    }
    unit.reset();
    assert_eq!(value(&unit, &all, "thrust_reference"), 0.0);
    assert_eq!(value(&unit, &all, "thrust_slope"), 0.0);
}

#[test]
fn every_variable_has_its_unit() {
    let (_, _, simulation) = both();
    let entries = simulation.model.derivatives.entries();
    let names: Vec<String> = entries.iter().map(|entry| entry.term.derivative_name(entry.coefficient)).collect();
    let all = variables(&simulation, &names);
    let unit = |name: &str| {
        let variable = all.iter().find(|variable| variable.name == name).unwrap();
        variable.unit.unwrap().name()
    };
    let units = [("u", "m/s"), ("der(u)", "m/s2"), ("q", "rad/s"), ("der(q)", "rad/s2"), ("der(h)", "m/s")];
    let outputs = [("alpha", "rad"), ("ax", "m/s2"), ("thrust", "N"), ("thrust_slope", "N.s/m"), ("Cm_q", "1/rad")];
    for (name, expected) in units.into_iter().chain(outputs).chain([("CX_0", "1"), ("thrust_reference", "N")]) {
        assert_eq!(unit(name), expected, "{name}");
    }
    assert_eq!(Unit { kg: 0, m: -1, s: 1, rad: -2 }.name(), "s/(m.rad2)");
}

#[test]
fn models_that_are_none_are_refused_by_name() {
    let (_, _, simulation) = both();
    let text = simulation.to_json().unwrap();
    for (from, to, expected) in [
        ("doublet flight model", "another", "format"),
        ("\"CX\"", "\"C9\"", "unknown coefficient 'C9'"),
        ("\"removed\"", "\"gone\"", "`gone`"),
        ("\"mass_kg\": 2010.0", "\"mass_kg\": 0.0", "mass"),
    ] {
        assert!(text.contains(from), "{from} is not in {text}");
        let error = Instance::new(&text.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}
