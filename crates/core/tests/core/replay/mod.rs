//! The replay against the simulator, and against the coefficients of the motion it gives.
mod steady;

use std::collections::BTreeMap;

use doublet_core::airframe::{FixedItem, InertiaTensor, Loading, MassHistory, MassProperties};
use doublet_core::atmos::Atmosphere;
use doublet_core::model::{
    AeroData, Axes, Coefficient, CoefficientSettings, Derivatives, Engine, Gyroscopic, Position, Term, ThrustTreatment,
    Variable, coefficients, variables,
};
use doublet_core::motion::{Airflow, State, runge_kutta};
use doublet_core::quantity::Role;
use doublet_core::replay::{Motion, MotionAxis, Replay, ReplayError, Response, Start};
use doublet_core::simulate::{Body, Controls, Environment, Loads, Thrust, TrimCondition, Vehicle, c337f, trim};
use nalgebra::Vector3;

/// Step of the flights, s.
const STEP_S: f64 = 0.02;
/// Two implementations of one motion after 20 s in double precision, relative to a radian or a metre per second.
const ROUND_OFF: f64 = 1e-9;
/// Coefficients formed anew from the forces the replay applied: rounding of forces of 20 kN over q S of 20 kN.
const COEFFICIENT: f64 = 1e-12;
const WIND_M_S: [f64; 3] = [3.0, -4.0, 0.5];

/// Deflections at a time: three doublets, one after the other.
fn inputs(trim: Controls, time_s: f64) -> Controls {
    let doublet = |start: f64| match time_s - start {
        t if (0.0..1.0).contains(&t) => 0.04,
        t if (1.0..2.0).contains(&t) => -0.04,
        _ => 0.0,
    };
    Controls {
        aileron: trim.aileron + doublet(2.0),
        elevator: trim.elevator + doublet(7.0),
        rudder: trim.rudder + doublet(12.0),
    }
}

/// A flight of the simulator with its recording and where it starts.
struct Flown {
    vehicle: Vehicle,
    body: Body,
    data: AeroData,
    states: Vec<State>,
    /// Forces, moments and coefficients at each state.
    loads: Vec<Loads>,
    start: Start,
}

fn engine(vehicle: &Vehicle, index: usize, thrust_n: f64, samples: usize) -> Engine {
    let engine = &vehicle.powerplant.engines[index];
    Engine {
        thrust_n: vec![thrust_n; samples].into(),
        position: Position::Datum(engine.station.position_from_datum_m),
        direction_body: engine.thrust_direction_body().into(),
        rotor_inertia_kg_m2: engine.rotation.sign() * engine.rotor_inertia_kg_m2,
        speed_rad_s: vec![[246.0, 230.0][index]; samples].into(),
    }
}

/// [`flown_with`] the loading of the simulated flights.
fn flown(seconds: f64) -> Flown {
    flown_with(seconds, |_| {})
}

/// A loading with products of inertia in all three planes: fuel on the right, a load high on the left.
fn lopsided(loading: &mut Loading) {
    loading.fuel_kg.insert("main left".to_owned(), 40.0);
    loading.added_items.push(FixedItem { name: "load".to_owned(), mass_kg: 60.0, cg_from_datum_m: [2.4, -0.5, 2.1] });
}

/// Flies the C337F through its inputs in constant air with constant thrust; controls linear between samples.
fn flown_with(seconds: f64, load: impl Fn(&mut Loading)) -> Flown {
    let (vehicle, mut loading) = c337f().unwrap();
    load(&mut loading);
    let body = vehicle.body(&loading).unwrap();
    let condition = TrimCondition {
        airspeed_m_s: 50.0,
        altitude_m: 1500.0,
        heading_rad: 0.7,
        engine_speed_rad_s: 246.0,
        wind_ned_m_s: Vector3::from(WIND_M_S),
    };
    let trim = trim(&vehicle, &body, &Atmosphere::STANDARD, &condition).unwrap();
    let mut environment = trim.environment;
    for thrust in &mut environment.thrust {
        *thrust = Thrust { per_airspeed_n_s_m: 0.0, ..*thrust };
    }
    let steps = (seconds / STEP_S) as usize;
    let engines: Vec<_> =
        (0..2).map(|index| engine(&vehicle, index, environment.thrust[index].force_n, steps)).collect();
    let momentum: f64 = engines.iter().map(|engine| engine.rotor_inertia_kg_m2 * engine.speed_rad_s[0]).sum();
    environment.rotor_momentum_n_m_s = Vector3::new(momentum, 0.0, 0.0);
    let mut state = trim.state;
    let (mut states, mut loads) = (Vec::new(), Vec::new());
    let mut controls: [Vec<f64>; 3] = Default::default();
    for k in 0..steps {
        let (now, next) = (
            inputs(trim.environment.controls, k as f64 * STEP_S),
            inputs(trim.environment.controls, (k + 1) as f64 * STEP_S),
        );
        states.push(state);
        loads.push(vehicle.loads(&body, &state, &Environment { controls: now, ..environment }));
        controls[0].push(now.aileron);
        controls[1].push(now.elevator);
        controls[2].push(now.rudder);
        state = runge_kutta(&state, STEP_S, |fraction, state| {
            let between = |a: f64, b: f64| a + (b - a) * fraction;
            let mut environment: Environment = environment;
            environment.controls = Controls {
                aileron: between(now.aileron, next.aileron),
                elevator: between(now.elevator, next.elevator),
                rudder: between(now.rudder, next.rudder),
            };
            vehicle.loads(&body, state, &environment).rate(state)
        });
    }
    let flow = |state: &State| {
        let air = state.body_from_ned() * (state.velocity_ned_m_s - Vector3::from(WIND_M_S));
        Airflow::new(air, environment.density_kg_m3)
    };
    let first = &states[0];
    let start = Start {
        position_ned_m: first.position_ned_m.into(),
        air_velocity_body_m_s: flow(first).velocity_body_m_s.into(),
        euler_rad: first.euler_rad(),
        rates_rad_s: first.rates_rad_s.into(),
    };
    let column = |of: &dyn Fn(&State) -> f64| states.iter().map(of).collect::<Vec<_>>();
    let [aileron, elevator, rudder] = controls;
    let data = AeroData {
        time_s: (0..steps).map(|k| 100.0 + k as f64 * STEP_S).collect(),
        airspeed_m_s: column(&|state| flow(state).airspeed_m_s).into(),
        alpha_rad: column(&|state| flow(state).alpha_rad).into(),
        beta_rad: column(&|state| flow(state).beta_rad).into(),
        rates_rad_s: [0, 1, 2].map(|axis| column(&|state| state.rates_rad_s[axis])),
        specific_force_m_s2: [0, 1, 2].map(|_| vec![0.0; steps]),
        accelerometer: None,
        angular_acceleration_rad_s2: None,
        density_kg_m3: vec![environment.density_kg_m3; steps].into(),
        controls: BTreeMap::from([
            (Role::Aileron, aileron.into()),
            (Role::Elevator, elevator.into()),
            (Role::Rudder, rudder.into()),
        ]),
        mass: MassHistory::Constant(body.properties),
        engines,
        propeller_pressure: None,
        altitude_m: None,
        mach: None,
    };
    Flown { vehicle, body, data, states, loads, start }
}

fn settings(vehicle: &Vehicle) -> CoefficientSettings {
    let mut settings = CoefficientSettings::new(*vehicle.reference());
    settings.thrust = ThrustTreatment::Removed;
    settings.gyroscopic = Gyroscopic::Signed;
    settings
}

fn truth(vehicle: &Vehicle) -> Derivatives {
    vehicle.aero.derivatives().iter().map(|d| (d.coefficient, d.term.clone(), d.value)).collect()
}

fn wind(samples: usize) -> [Vec<f64>; 3] {
    WIND_M_S.map(|component| vec![component; samples])
}

/// Largest difference of airspeed components, attitude and rates from the flown ones.
fn largest_error(flown: &Flown, response: &Response) -> f64 {
    let mut largest = 0.0_f64;
    for (k, state) in flown.states.iter().enumerate() {
        let air = state.body_from_ned() * (state.velocity_ned_m_s - Vector3::from(WIND_M_S));
        for axis in 0..3 {
            largest = largest
                .max((response.air_velocity_body_m_s[axis][k] - air[axis]).abs())
                .max((response.rates_rad_s[axis][k] - state.rates_rad_s[axis]).abs())
                .max((response.euler_rad[axis][k] - state.euler_rad()[axis]).abs())
                .max((response.position_ned_m[axis][k] - state.position_ned_m[axis]).abs());
        }
    }
    largest
}

#[test]
fn lopsided_loading_gives_back_the_moments_it_was_flown_with() {
    let flown = flown_with(20.0, lopsided);
    let tensor = flown.body.properties.inertia;
    assert!(tensor.xy.abs() > 50.0 && tensor.yz.abs() > 20.0, "{tensor:?}");
    let of = |vector: &dyn Fn(&Loads) -> Vector3<f64>| {
        [0, 1, 2].map(|axis| flown.loads.iter().map(|loads| vector(loads)[axis]).collect::<Vec<_>>())
    };
    let data = AeroData {
        specific_force_m_s2: of(&|loads| loads.specific_force_m_s2),
        angular_acceleration_rad_s2: Some(of(&|loads| loads.angular_acceleration_rad_s2)),
        ..flown.data.clone()
    };
    let largest_error = |data: &AeroData| {
        let formed = coefficients(data, &settings(&flown.vehicle)).unwrap();
        [Coefficient::CX, Coefficient::CY, Coefficient::CZ, Coefficient::Cl, Coefficient::Cm, Coefficient::Cn].map(
            |c| {
                let pairs = formed.get(c).iter().zip(&flown.loads);
                pairs.map(|(formed, loads)| (formed - loads.coefficients[c as usize]).abs()).fold(0.0, f64::max)
            },
        )
    };
    let errors = largest_error(&data);
    println!("largest errors of CX CY CZ Cl Cm Cn: {errors:?}");
    assert!(errors.iter().all(|error| *error < ROUND_OFF), "{errors:?}");
    // Without its products Ixy and Iyz the same motion gives other moments.
    let symmetric = MassProperties { inertia: InertiaTensor { xy: 0.0, yz: 0.0, ..tensor }, ..flown.body.properties };
    let errors = largest_error(&AeroData { mass: MassHistory::Constant(symmetric), ..data });
    println!("without Ixy and Iyz: {errors:?}");
    assert!(errors[3..].iter().all(|error| *error > 1e-4), "{errors:?}");
}

#[test]
fn replay_of_a_lopsided_loading_follows_the_simulator() {
    let flown = flown_with(20.0, lopsided);
    let settings = settings(&flown.vehicle);
    let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
    let error = largest_error(&flown, &replay.fly(&truth(&flown.vehicle), &flown.start).unwrap());
    assert!(error < ROUND_OFF, "{error}");
}

#[test]
fn replay_of_the_truth_follows_the_simulator() {
    let flown = flown(20.0);
    let settings = settings(&flown.vehicle);
    let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
    let response = replay.fly(&truth(&flown.vehicle), &flown.start).unwrap();
    let moved = response.rates_rad_s.iter().flatten().fold(0.0_f64, |largest, rate| largest.max(rate.abs()));
    assert!(moved > 0.1, "the inputs must move the aircraft, largest rate {moved} rad/s");
    let error = largest_error(&flown, &response);
    assert!(error < ROUND_OFF, "{error}");
    // A wrong derivative must show.
    let changed = flown.vehicle.aero.with_derivative("Cm_alpha", 0.8 * flown.vehicle.aero.value("Cm_alpha").unwrap());
    let wrong = Vehicle { aero: changed.unwrap(), ..flown.vehicle.clone() };
    let error = largest_error(&flown, &replay.fly(&truth(&wrong), &flown.start).unwrap());
    assert!(error > 0.05, "{error}");
}

/// Largest difference of the flown states of two responses.
fn largest_difference(first: &Response, second: &Response) -> f64 {
    let columns = |response: &Response| -> Vec<Vec<f64>> {
        let groups = [&response.air_velocity_body_m_s, &response.euler_rad, &response.rates_rad_s];
        groups.into_iter().flatten().chain(&response.specific_force_m_s2).cloned().collect()
    };
    let pairs = columns(first).concat().into_iter().zip(columns(second).concat());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn one_axis_flies_as_all_six_degrees_of_freedom_do_when_the_other_moves_as_it_did() {
    /// What the recorded axis, linear between samples of 20 ms, costs: its curvature over a step.
    const LINEAR: f64 = 2e-3;
    let flown = flown(20.0);
    let [x, y, z] = flown.body.properties.cg_from_datum_m;
    for axes in [Axes::Body, Axes::Stability] {
        let mut settings = settings(&flown.vehicle);
        (settings.axes, settings.moment_reference) = (axes, Some(Position::Datum([x - 0.2, y + 0.1, z + 0.3])));
        let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
        let model = truth(&flown.vehicle);
        let whole = replay.fly(&model, &flown.start).unwrap();
        let motion = Motion::from(&whole);
        for axis in [MotionAxis::Longitudinal, MotionAxis::Lateral] {
            // The other axis' derivatives are not there at all.
            let own = model.entries().iter().filter(|entry| axis.has(entry.coefficient));
            let own: Derivatives = own.map(|entry| (entry.coefficient, entry.term.clone(), entry.value)).collect();
            let alone = replay.fly_axis(axis, &own, &flown.start, &motion).unwrap();
            let error = largest_difference(&whole, &alone);
            println!("{} {axes:?}: {error:.1e}", axis.name());
            assert!(error < LINEAR, "{} {axes:?}: {error}", axis.name());
            // It is flown: a wrong start shows.
            let mut start = flown.start;
            start.air_velocity_body_m_s = start.air_velocity_body_m_s.map(|component| component + 0.5);
            let error = largest_difference(&whole, &replay.fly_axis(axis, &own, &start, &motion).unwrap());
            assert!(error > 0.1, "{} {axes:?}: {error}", axis.name());
        }
        assert_eq!(replay.fly_axis(MotionAxis::Both, &model, &flown.start, &motion).unwrap(), whole);
        let short = Motion { rates_rad_s: [vec![0.0], vec![0.0], vec![0.0]], ..motion.clone() };
        let refused = replay.fly_axis(MotionAxis::Lateral, &model, &flown.start, &short).unwrap_err();
        assert!(matches!(refused, ReplayError::MotionLength { found: 1, .. }), "{refused}");
    }
}

/// The recording of a response: what `coefficients` gets of a flown window.
fn recorded(flown: &Flown, response: &Response) -> AeroData {
    AeroData {
        airspeed_m_s: response.airspeed_m_s.clone().into(),
        alpha_rad: response.alpha_rad.clone().into(),
        beta_rad: response.beta_rad.clone().into(),
        rates_rad_s: response.rates_rad_s.clone(),
        specific_force_m_s2: response.specific_force_m_s2.clone(),
        angular_acceleration_rad_s2: Some(response.angular_acceleration_rad_s2.clone()),
        ..flown.data.clone()
    }
}

#[test]
fn coefficients_of_the_replayed_motion_are_those_of_the_model() {
    let flown = flown(8.0);
    let [x, y, z] = flown.body.properties.cg_from_datum_m;
    let reference = Some(Position::Datum([x - 0.2, y + 0.1, z + 0.3]));
    for axes in [Axes::Body, Axes::Stability] {
        for thrust in [ThrustTreatment::Removed, ThrustTreatment::ForceRemoved, ThrustTreatment::Included] {
            for (gyroscopic, moment_reference) in
                [(Gyroscopic::Signed, None), (Gyroscopic::Summed, reference), (Gyroscopic::Ignored, reference)]
            {
                let mut settings = settings(&flown.vehicle);
                (settings.axes, settings.thrust) = (axes, thrust);
                (settings.gyroscopic, settings.moment_reference) = (gyroscopic, moment_reference);
                let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
                let response = replay.fly(&truth(&flown.vehicle), &flown.start).unwrap();
                let formed = coefficients(&recorded(&flown, &response), &settings).unwrap();
                for (coefficient, column) in Coefficient::ALL.into_iter().zip(&response.coefficients) {
                    for (formed, model) in formed.get(coefficient).iter().zip(column) {
                        let error = (formed - model).abs();
                        assert!(error < COEFFICIENT, "{coefficient:?} {axes:?} {thrust:?} {gyroscopic:?}: {error}");
                    }
                }
            }
        }
    }
}

#[test]
fn rates_of_the_flow_angles_are_solved_for() {
    /// Fourth-order differences of alpha and beta at 50 Hz against their rates, without dimension, away from the corners of
    /// the inputs: a corner is 0.5 % of the largest rate.
    const DIFFERENCE: f64 = 2e-5;
    let flown = flown(8.0);
    let settings = settings(&flown.vehicle);
    let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
    let unsteady: [(Coefficient, &str, f64); 4] = [
        (Coefficient::CZ, "alpha_dot", -2.0),
        (Coefficient::Cm, "alpha_dot", -4.0),
        (Coefficient::CY, "beta_dot", 0.4),
        (Coefficient::Cn, "beta_dot", 0.1),
    ];
    let steady = truth(&flown.vehicle);
    let terms = steady.entries().iter().map(|d| (d.coefficient, d.term.clone(), d.value));
    let added = unsteady.iter().map(|&(c, term, value)| (c, Term::parse(term).unwrap(), value));
    let response = replay.fly(&terms.chain(added).collect(), &flown.start).unwrap();
    // What the unsteady terms added, against the differentiated flow angles of the motion itself.
    let columns = variables(&recorded(&flown, &response), &settings).unwrap();
    let mut compared = 0;
    for k in 0..columns.rows() {
        let mut values = [0.0; Variable::ALL.len()];
        for variable in columns.known() {
            values[variable as usize] = columns.get(variable).map_or(0.0, |column| column[k]);
        }
        let base = steady.body_coefficients(&values);
        let time = k as f64 * STEP_S;
        let near_corner = [2.0, 3.0, 4.0, 7.0].iter().any(|corner| (time - corner).abs() < 0.1);
        if near_corner {
            continue;
        }
        for &(coefficient, name, value) in &unsteady {
            let added = response.coefficients[coefficient as usize][k] - base[coefficient as usize];
            let variable = Variable::from_name(name).unwrap();
            let error = (added / value - values[variable as usize]).abs();
            assert!(error < DIFFERENCE, "{name} at {time} s: {error}");
            compared += 1;
        }
    }
    assert!(compared > 1000);
}

#[test]
fn replay_refuses_what_it_cannot_fly() {
    let flown = flown(1.0);
    let settings = settings(&flown.vehicle);
    let replay = Replay::new(&flown.data, &settings, &wind(flown.data.time_s.len()), 9.80665).unwrap();
    let few: Derivatives = [(Coefficient::CX, Term::constant(), 0.1)].into_iter().collect();
    let message = replay.fly(&few, &flown.start).unwrap_err().to_string();
    assert!(message.contains("CY, CZ, Cl, Cm, Cn"), "{message}");
    let steady = truth(&flown.vehicle);
    let terms = steady.entries().iter().map(|d| (d.coefficient, d.term.clone(), d.value));
    let mach: Derivatives = terms.chain([(Coefficient::CX, Term::parse("mach").unwrap(), 0.1)]).collect();
    assert_eq!(
        replay.fly(&mach, &flown.start).unwrap_err(),
        ReplayError::MissingVariable { term: "mach".into(), variable: "mach" }
    );
    let unstable = flown.vehicle.aero.with_derivative("Cm_q", 4e3).unwrap();
    let unstable = truth(&Vehicle { aero: unstable, ..flown.vehicle.clone() });
    let ended = replay.fly(&unstable, &Start { rates_rad_s: [0.0, 0.01, 0.0], ..flown.start }).unwrap_err();
    assert!(matches!(ended, ReplayError::Ended { .. }), "{ended}");
    let short = [vec![0.0], vec![0.0], vec![0.0]];
    assert!(matches!(Replay::new(&flown.data, &settings, &short, 9.8), Err(ReplayError::WindLength { .. })));
}
