//! Linear models of an aircraft with terms of every kind: by the chain rule and by differences, and against the simulator's own.

use doublet_core::airframe::MassProperties;
use doublet_core::atmos::Atmosphere;
use doublet_core::model::{Axes, Coefficient, Derivatives, Position, Term, ThrustTreatment};
use doublet_core::simulate::{self, Scenario, TrimCondition, c337f, scenario, system_matrix};
use doublet_dynamics::linear::{
    Condition, FlightModel, LinearError, Method, Part, SteadyFlight, ThrustLine, linearise,
};
use doublet_dynamics::modes::modes;
use nalgebra::Vector3;

const ENGINE_SPEED_RAD_S: f64 = 2500.0 * std::f64::consts::TAU / 60.0;

/// The simulator's aircraft as an identified model at one of its trims, and that trim's system matrix.
fn own_aircraft(
    altitude_m: f64,
    airspeed_m_s: f64,
) -> (FlightModel, Condition, simulate::Trim, nalgebra::SMatrix<f64, 8, 8>) {
    let (vehicle, loading) = c337f().unwrap();
    let body = vehicle.body(&loading).unwrap();
    let atmosphere = Atmosphere::STANDARD;
    let asked = TrimCondition {
        airspeed_m_s,
        altitude_m,
        heading_rad: 0.0,
        engine_speed_rad_s: ENGINE_SPEED_RAD_S,
        wind_ned_m_s: Vector3::zeros(),
    };
    let trim = simulate::trim(&vehicle, &body, &atmosphere, &asked).unwrap();
    let matrix = system_matrix(&vehicle, &body, &trim);
    let (model, condition) = identified(&vehicle, &trim, body.properties, (altitude_m, airspeed_m_s));
    (model, condition, trim, matrix)
}

/// The simulator's aircraft as an identified model, and the condition of one of its trims.
fn identified(
    vehicle: &simulate::Vehicle,
    trim: &simulate::Trim,
    mass: MassProperties,
    (altitude_m, airspeed_m_s): (f64, f64),
) -> (FlightModel, Condition) {
    let derivatives = vehicle.aero.derivatives().iter().map(|d| (d.coefficient, d.term.clone(), d.value)).collect();
    let engines = vehicle.powerplant.engines.iter().map(|engine| ThrustLine {
        position: Position::Datum(engine.station.position_from_datum_m),
        direction_body: engine.thrust_direction_body().into(),
        share: 0.5,
    });
    let model = FlightModel {
        derivatives,
        reference: *vehicle.reference(),
        axes: Axes::Body,
        moment_reference: None,
        thrust: ThrustTreatment::Removed,
        engines: engines.collect(),
    };
    let environment = trim.environment;
    let condition = Condition {
        airspeed_m_s,
        altitude_m,
        density_kg_m3: environment.density_kg_m3,
        speed_of_sound_m_s: environment.speed_of_sound_m_s,
        gravity_m_s2: environment.gravity_m_s2,
        gamma_rad: Some(0.0),
        flight: SteadyFlight::Straight,
        mass,
        thrust_slope_n_s_m: environment.thrust.iter().map(|thrust| thrust.per_airspeed_n_s_m).sum(),
        pressure_rise_pa: 0.0,
        rotor_momentum_n_m_s: environment.rotor_momentum_n_m_s.x,
        recorded: Default::default(),
    };
    (model, condition)
}

/// Largest difference of a mode of the truth from that of the linear model of its derivatives: differences of the simulator's equations
/// against the chain rule, rad/s and damping.
const MODE_TOLERANCE: f64 = 1e-5;

/// Two designed inputs with a loading that is not that of the shipped flight, and little fuel.
const DESIGNED: &str = r#"
format = "doublet scenario"
version = 1
aircraft = "c337f"
airspeed_m_s = 49.0
altitude_m = 1500.0
rest_s = 5.0

[loading]
fuel_kg = { "main right" = 50.0, "main left" = 50.0 }
seats_kg = { captain = 80.0 }

[[manoeuvre]]
name = "doublet"
duration_s = 4.0
time_s = [0.0, 0.1, 1.0, 1.2, 2.0, 2.1]
elevator_rad = [0.0, 0.02, 0.02, -0.02, -0.02, 0.0]
"#;

#[test]
fn true_modes_are_those_of_the_true_derivatives_at_the_loading_flown() {
    let mut scenarios: Vec<Scenario> =
        ["test-point", "inputs", "multisine"].iter().map(|name| scenario::build(name).unwrap()).collect();
    scenarios.push(scenario::parse(DESIGNED).unwrap());
    for scenario in &mut scenarios {
        // A few seconds are enough: the loading flown is that of the start.
        scenario.manoeuvres.truncate(1);
        scenario.duration_s = 30.0;
        let flight = simulate::run(scenario, 1, &mut |_| true).unwrap();
        let found = simulate::true_modes(&flight).unwrap();
        assert_eq!(found.len(), 1, "{}", scenario.name);
        for own in &found {
            let start = scenario.loading.mass_properties(&scenario.vehicle.aircraft).mass_kg;
            let burnt_kg = start - own.mass.mass_kg;
            assert!((0.0..1.0).contains(&burnt_kg), "{}: {burnt_kg} kg", scenario.name);
            let place = (own.altitude_m, own.airspeed_m_s);
            let (model, condition) = identified(&scenario.vehicle, &own.trim, own.mass, place);
            let expected = modes(&linearise(&model, &condition, Method::Analytic).unwrap().motion());
            assert_eq!(own.modes.len(), expected.len());
            for (own, expected) in own.modes.iter().zip(&expected) {
                let apart = (own.real_1_s - expected.real_1_s).hypot(own.imaginary_rad_s - expected.imaginary_rad_s);
                println!("{} {}: {apart:.1e}", scenario.name, own.name);
                assert!(own.name == expected.name && apart < MODE_TOLERANCE, "{}: {apart:e}", own.name);
            }
        }
    }
    // The loading of the file is flown.
    assert!(scenarios[3].loading.mass_properties(&scenarios[3].vehicle.aircraft).mass_kg < 1700.0);
}

#[test]
fn system_matrix_is_that_of_the_simulator() {
    for (altitude_m, airspeed_m_s) in [(1219.2, 46.3), (1981.2, 60.2), (762.0, 52.0)] {
        let (model, condition, trim, expected) = own_aircraft(altitude_m, airspeed_m_s);
        let linear = linearise(&model, &condition, Method::Analytic).unwrap();
        assert!((linear.trim.alpha_rad - trim.alpha_rad).abs() < 1e-9);
        let thrust: f64 = trim.environment.thrust.iter().map(|thrust| thrust.force_n).sum();
        assert!((linear.trim.thrust_n - thrust).abs() < 1e-4, "{} {thrust}", linear.trim.thrust_n);
        let found = linear.part(Part::Motion).a;
        let worst = (0..64).map(|k| (found[(k / 8, k % 8)] - expected[(k / 8, k % 8)]).abs()).fold(0.0, f64::max);
        println!("{altitude_m} m {airspeed_m_s} m/s: largest difference {worst:.1e}");
        assert!(worst < 1e-6, "{worst:e}");
    }
}

#[test]
fn one_engine_out_is_held_by_the_deflections_the_derivatives_say_down_to_the_minimum_control_speed() {
    /// Engines to either side of the plane of symmetry, m.
    const ARM_M: f64 = 2.0;
    let (model, condition, ..) = own_aircraft(762.0, 52.0);
    let cg = condition.mass.cg_from_datum_m;
    let engine = |side: f64, share: f64| ThrustLine {
        position: Position::Datum([cg[0], cg[1] + side * ARM_M, cg[2]]),
        direction_body: [1.0, 0.0, 0.0],
        share,
    };
    let twin =
        |left: f64, right: f64| FlightModel { engines: vec![engine(-1.0, left), engine(1.0, right)], ..model.clone() };
    let vehicle = c337f().unwrap().0;
    let value = |name: &str| vehicle.aero.value(name).unwrap();
    let [cl_a, cl_r, cn_a, cn_r] = ["Cl_delta_a", "Cl_delta_r", "Cn_delta_a", "Cn_delta_r"].map(value);
    let both = linearise(&twin(0.5, 0.5), &condition, Method::Analytic).unwrap().trim;
    for airspeed_m_s in [40.0, 52.0, 60.0] {
        let condition = Condition { airspeed_m_s, ..condition };
        let trim = linearise(&twin(0.0, 1.0), &condition, Method::Analytic).unwrap().trim;
        // The right engine alone yaws to the left; what is out of the symmetry of the aircraft itself is that of both engines.
        let (reference, dynamic_pa) = (twin(0.0, 1.0).reference, 0.5 * condition.density_kg_m3 * airspeed_m_s.powi(2));
        let asked = trim.thrust_n * ARM_M / (dynamic_pa * reference.area_m2 * reference.lateral_moment_length_m);
        let rudder = asked / (cn_r - cn_a * cl_r / cl_a);
        let aileron = -cl_r * rudder / cl_a;
        let found = [trim.controls_rad[0] - both.controls_rad[0], trim.controls_rad[2] - both.controls_rad[2]];
        println!("{airspeed_m_s} m/s: {:.1} N, aileron and rudder {found:?} rad", trim.thrust_n);
        assert!((found[0] - aileron).abs() < 1e-8 && (found[1] - rudder).abs() < 1e-8, "{found:?} {aileron} {rudder}");
        // No sideslip: the side force of the rudder is that of a few degrees of bank.
        assert!(trim.euler_rad[0] != 0.0 && trim.euler_rad[0].abs() < 0.1, "{:?}", trim.euler_rad);
        // With this rudder as its travel this is the minimum control speed at this thrust.
        let effect = (cn_r - cn_a * cl_r / cl_a) * found[1];
        let per_dynamic = reference.area_m2 * reference.lateral_moment_length_m;
        let minimum_m_s = (2.0 * trim.thrust_n * ARM_M / (condition.density_kg_m3 * per_dynamic * effect)).sqrt();
        assert!((minimum_m_s / airspeed_m_s - 1.0).abs() < 1e-6, "{minimum_m_s}");
    }
}

/// Derivatives of a model with unsteady terms, products, powers, thrust and Mach number.
fn rich(model: &FlightModel) -> FlightModel {
    let extra = [
        (Coefficient::CZ, "alpha_dot", -1.1),
        (Coefficient::Cm, "alpha_dot", -3.0),
        (Coefficient::CY, "beta_dot", 0.03),
        (Coefficient::Cn, "beta_dot", -0.02),
        (Coefficient::Cm, "alpha^2", -0.4),
        (Coefficient::Cm, "alpha*delta_e", -0.3),
        (Coefficient::Cl, "alpha*beta", -0.2),
        (Coefficient::Cn, "alpha*pb/2V", -0.1),
        (Coefficient::CX, "Tc", 0.04),
        (Coefficient::Cm, "Tc", -0.03),
        (Coefficient::CX, "dpt/q", 0.02),
        (Coefficient::CZ, "mach", -0.2),
        (Coefficient::CZ, "qc/2V", -2.0),
        (Coefficient::Cm, "V^-1*delta_e", -2.0),
        (Coefficient::Cn, "h", 1e-7),
    ];
    let entries = model.derivatives.entries().iter().map(|d| (d.coefficient, d.term.clone(), d.value));
    let extra = extra.into_iter().map(|(coefficient, term, value)| (coefficient, Term::parse(term).unwrap(), value));
    let derivatives: Derivatives = entries.chain(extra).collect();
    FlightModel { derivatives, ..model.clone() }
}

#[test]
fn chain_rule_and_differences_agree_for_terms_of_every_kind() {
    let (model, condition, ..) = own_aircraft(1219.2, 50.0);
    let mut about_elsewhere = rich(&model);
    about_elsewhere.moment_reference = Some(Position::BodyFromCg([0.12, 0.02, -0.1]));
    let mut stability = about_elsewhere.clone();
    stability.axes = Axes::Stability;
    let mut moving = condition;
    moving.pressure_rise_pa = 60.0;
    moving.rotor_momentum_n_m_s = 40.0;
    for (name, model) in [("plain", &model), ("rich", &about_elsewhere), ("stability axes", &stability)] {
        for flight in [SteadyFlight::Straight, SteadyFlight::Turn(1.3), SteadyFlight::PullUp(1.2)] {
            for gamma in [0.0, 0.06] {
                let condition = Condition { flight, gamma_rad: Some(gamma), ..moving };
                let found = linearise(model, &condition, Method::Analytic).unwrap();
                let expected = linearise(model, &condition, Method::Differences).unwrap();
                for (found, expected) in [(&found.full.a, &expected.full.a), (&found.full.b, &expected.full.b)] {
                    let off = (found - expected).abs();
                    let worst =
                        off.iter().zip(expected).map(|(off, value)| off / value.abs().max(1.0)).fold(0.0, f64::max);
                    assert!(worst < 1e-6, "{name} {flight:?} {gamma}: {worst:e}");
                }
            }
        }
    }
}

#[test]
fn turn_and_pull_up_have_the_load_factor_asked_for() {
    let (model, condition, ..) = own_aircraft(1219.2, 55.0);
    let turn =
        linearise(&model, &Condition { flight: SteadyFlight::Turn(1.5), ..condition }, Method::Analytic).unwrap().trim;
    assert!((turn.load_factor() - 1.5).abs() < 1e-9);
    // A level coordinated turn: sideways acceleration g tan(phi) = V times the turn rate, nearly (the side force of the controls is left).
    let rate = turn.rates_rad_s.iter().map(|rate| rate * rate).sum::<f64>().sqrt();
    let expected = condition.gravity_m_s2 * turn.euler_rad[0].tan() / condition.airspeed_m_s;
    assert!((rate / expected - 1.0).abs() < 0.05, "{rate} {expected}");
    let level = linearise(&model, &condition, Method::Analytic).unwrap().trim;
    let pull = linearise(&model, &Condition { flight: SteadyFlight::PullUp(1.5), ..condition }, Method::Analytic)
        .unwrap()
        .trim;
    let expected = condition.gravity_m_s2 * 0.5 / condition.airspeed_m_s;
    assert!((pull.rates_rad_s[1] / expected - 1.0).abs() < 1e-3 && pull.alpha_rad > level.alpha_rad);
    let refused = linearise(&model, &Condition { flight: SteadyFlight::Turn(0.9), ..condition }, Method::Analytic);
    assert_eq!(refused.unwrap_err(), LinearError::LoadFactor { load_factor: 0.9 });
}

#[test]
fn airspeed_and_flow_angles_as_states_keep_the_eigenvalues() {
    let (model, condition, ..) = own_aircraft(1219.2, 50.0);
    let linear = linearise(&rich(&model), &condition, Method::Analytic).unwrap();
    for (body, air) in [(Part::Longitudinal, Part::LongitudinalAir), (Part::Lateral, Part::LateralAir)] {
        let (body, air) = (modes(&linear.part(body)), modes(&linear.part(air)));
        for (first, second) in body.iter().zip(&air) {
            assert_eq!(first.name, second.name);
            assert!((first.eigenvalue() - second.eigenvalue()).norm() < 1e-9);
        }
    }
    // A step of alpha in these states is one of w over V in the others.
    let air = linear.part(Part::LongitudinalAir);
    let names: Vec<&str> = air.states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["V", "alpha", "q", "theta"]);
    let gamma_dot = air.a[(1, 2)];
    assert!((gamma_dot - 1.0).abs() < 0.1, "alpha' by q is {gamma_dot}");
}

#[test]
fn model_without_what_a_trim_needs_says_so_in_one_line() {
    let (model, condition, ..) = own_aircraft(1219.2, 50.0);
    let only = |coefficients: &[Coefficient]| {
        let entries = model.derivatives.entries().iter().filter(|d| coefficients.contains(&d.coefficient));
        let derivatives = entries.map(|d| (d.coefficient, d.term.clone(), d.value)).collect();
        FlightModel { derivatives, ..model.clone() }
    };
    let lateral = linearise(&only(&[Coefficient::CY, Coefficient::Cl, Coefficient::Cn]), &condition, Method::Analytic);
    let message = lateral.unwrap_err().to_string();
    assert!(message.contains("CX, CZ, Cm") && !message.contains('\n'), "{message}");
    let longitudinal = only(&[Coefficient::CX, Coefficient::CZ, Coefficient::Cm]);
    let found = linearise(&longitudinal, &condition, Method::Analytic).unwrap();
    let names: Vec<String> = found.parts().map(|part| part.name).collect();
    assert_eq!(names, ["longitudinal", "longitudinal_air", "short_period"]);
    let mut powered = model.clone();
    powered.thrust = ThrustTreatment::Included;
    assert_eq!(linearise(&powered, &condition, Method::Analytic).unwrap_err(), LinearError::NoThrust);
    let gliding = linearise(&powered, &Condition { gamma_rad: None, ..condition }, Method::Analytic).unwrap();
    assert!(gliding.trim.gamma_rad < 0.0, "coefficients without thrust make it descend");
}
