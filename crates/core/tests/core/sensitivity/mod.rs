//! Sensitivities against the thesis's printed partial derivatives and against closed forms.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::airframe::{Aircraft, InertiaTensor, MassHistory, MassProperties, ReferenceGeometry};
use doublet_core::estimate::least_squares;
use doublet_core::load::aircraft;
use doublet_core::model::{
    AeroData, Coefficient, CoefficientSettings, Coefficients, Structure, coefficients, regressors, variables,
};
use doublet_core::quantity::Role;
use doublet_core::sensitivity::{Quantity, SensitivityTable, Step, central, quantities};

/// Five per cent, as in the thesis.
const FRACTION: f64 = 0.05;

fn c337f() -> Aircraft {
    aircraft::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/aircraft/c337f.toml")).unwrap()
}

/// Pitching in level flight: elevator motion, its response and the angular acceleration that goes with `TRUTH`.
fn pitching(mass: MassProperties) -> AeroData {
    let time_s: Vec<f64> = (0..600).map(|k| 0.02 * f64::from(k)).collect();
    let column = |f: &dyn Fn(f64) -> f64| time_s.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    let still = || vec![0.0; time_s.len()];
    let alpha = column(&|t| 0.08 + 0.03 * (1.3 * t).sin());
    let q = column(&|t| 0.06 * (1.3 * t + 0.8).cos() + 0.02 * (2.9 * t).sin());
    let elevator = column(&|t| -0.02 + 0.04 * (0.9 * t).sin() + 0.03 * (2.1 * t).cos());
    let (airspeed, density) = (46.0, 1.09);
    let scale = 0.5 * density * airspeed * airspeed * GEOMETRY.area_m2 * GEOMETRY.chord_m;
    let moment = |k: usize| {
        TRUTH[0] + TRUTH[1] * alpha[k] + TRUTH[2] * q[k] * GEOMETRY.chord_m / airspeed + TRUTH[3] * elevator[k]
    };
    let q_dot: Vec<f64> = (0..time_s.len()).map(|k| moment(k) * scale / mass.inertia.yy).collect();
    AeroData {
        airspeed_m_s: vec![airspeed; time_s.len()].into(),
        beta_rad: still().into(),
        rates_rad_s: [still(), q, still()],
        specific_force_m_s2: [still(), still(), alpha.iter().map(|alpha| -60.0 * alpha - 5.0).collect()],
        accelerometer: None,
        angular_acceleration_rad_s2: Some([still(), q_dot, still()]),
        density_kg_m3: vec![density; time_s.len()].into(),
        controls: BTreeMap::from([
            (Role::Elevator, elevator.into()),
            (Role::Aileron, still().into()),
            (Role::Rudder, still().into()),
        ]),
        mass: MassHistory::Constant(mass),
        engines: Vec::new(),
        propeller_pressure: None,
        altitude_m: None,
        mach: None,
        alpha_rad: alpha.into(),
        time_s: time_s.into(),
    }
}

/// Pitching moment of the thesis (Table 6.8): constant, alpha, q c/V, elevator. The published partials reproduce its digits.
const TRUTH: [f64; 4] = [0.08, -0.8429, -0.95, -0.4239];
/// Wing area and mean chord of the Cessna 337F.
const GEOMETRY: ReferenceGeometry = ReferenceGeometry::conventional(18.7, 11.68, 1.68);
/// Mass and inertia of thesis section 7.2.1.
const NOMINAL: MassProperties = MassProperties {
    mass_kg: 2010.0,
    inertia: InertiaTensor { xx: 5493.0, yy: 5411.0, zz: 9689.0, xz: 311.0, xy: 0.0, yz: 0.0 },
    cg_from_datum_m: [3.53, 0.0, 1.68],
};

/// Derivatives of one coefficient: name, estimate, standard error.
fn estimates(data: &AeroData, coefficient: Coefficient) -> Vec<(String, f64, f64)> {
    let settings = CoefficientSettings::new(GEOMETRY);
    let formed: Coefficients = coefficients(data, &settings).unwrap();
    let structure = Structure::thesis();
    let terms = structure.terms(coefficient).unwrap();
    let x = regressors(terms, &variables(data, &settings).unwrap()).unwrap();
    let fit = least_squares(&structure.derivative_names(coefficient), &x, formed.get(coefficient)).unwrap();
    (0..fit.parameters()).map(|k| (fit.names[k].clone(), fit.estimates[k], fit.standard_errors[k])).collect()
}

fn table(quantity: Quantity, nominal: f64, change: impl Fn(&Quantity, f64) -> AeroData) -> SensitivityTable {
    let step = Step { half_width: FRACTION * nominal, nominal, quantity };
    let at = |change_by: f64| estimates(&change(&step.quantity, change_by), Coefficient::Cm);
    let (low, middle, high) = (at(-step.half_width), at(0.0), at(step.half_width));
    central(step, &middle, &low, &high)
}

fn partial(table: &SensitivityTable, derivative: &str) -> f64 {
    table.partials.iter().find(|partial| partial.derivative == derivative).unwrap().partial
}

/// Half a unit of the last printed digit of thesis Tables 7.5 and 7.6, relative.
const PRINTED: f64 = 0.002;
/// Rounding of a fit whose truth is exact.
const EXACT: f64 = 1e-9;

#[test]
fn scaled_signals_match_thesis_tables_7_5_and_7_6() {
    let data = pitching(NOMINAL);
    let scaled = |quantity: &Quantity, change: f64| quantity.scaled(&data, change);
    let elevator = table(Quantity::ElevatorScale, 100.0, scaled);
    approx::assert_relative_eq!(partial(&elevator, "Cm_delta_e"), 4.25e-3, max_relative = PRINTED);
    // (1/1.05 - 1/0.95) / 10 per cent, whatever the model.
    let slope = (1.0 / 1.05 - 1.0 / 0.95) / 10.0;
    approx::assert_relative_eq!(partial(&elevator, "Cm_delta_e"), slope * TRUTH[3], max_relative = EXACT);
    assert!(partial(&elevator, "Cm_alpha").abs() < EXACT, "no other derivative moves");
    let alpha = table(Quantity::AlphaScale, 100.0, scaled);
    approx::assert_relative_eq!(partial(&alpha, "Cm_alpha"), 8.45e-3, max_relative = PRINTED);
    assert!(partial(&alpha, "Cm_delta_e").abs() < EXACT);
}

#[test]
fn pitching_moment_is_proportional_to_its_inertia() {
    let data = pitching(NOMINAL);
    let aircraft = c337f();
    let changed = |quantity: &Quantity, change: f64| {
        let by = quantity.mass_change(&aircraft, &aircraft.standard_loading, change).unwrap();
        AeroData { mass: MassHistory::Constant(NOMINAL.plus(&by)), ..data.clone() }
    };
    let iyy = table(Quantity::Iyy, NOMINAL.inertia.yy, changed);
    for (name, truth) in [("Cm_alpha", TRUTH[1]), ("Cm_q", TRUTH[2]), ("Cm_delta_e", TRUTH[3])] {
        approx::assert_relative_eq!(partial(&iyy, name), truth / NOMINAL.inertia.yy, max_relative = EXACT);
    }
    // Table 7.3 averages over manoeuvres whose inertia falls by 6 of 5411 kg m2 and whose mean estimate is rounded.
    approx::assert_relative_eq!(partial(&iyy, "Cm_alpha"), -1.54e-4, max_relative = 0.02);
    let ixx = table(Quantity::Ixx, NOMINAL.inertia.xx, |quantity, change| changed(quantity, change));
    assert!(partial(&ixx, "Cm_alpha").abs() < EXACT, "roll inertia does not enter pure pitching");
}

#[test]
fn centre_of_gravity_moves_the_inertia_as_thesis_table_7_3_says() {
    let aircraft = c337f();
    // In Table 7.3 the centre of gravity acts on Cm through Iyy alone: the ratio of two columns is the change of Iyy per % MAC.
    // The printed partials have three digits; the aircraft was lighter than this loading by burnt fuel.
    for (quantity, printed, tolerance) in
        [(Quantity::CgX, 6.23e-4 / -1.54e-4, 0.15), (Quantity::CgZ, -2.33e-3 / -1.54e-4, 0.05)]
    {
        let change = |by: f64| quantity.mass_change(&aircraft, &aircraft.standard_loading, by).unwrap();
        let found = (change(5.0).inertia.yy - change(-5.0).inertia.yy) / 10.0;
        println!("{}: {found:.3} kg m2 per % MAC, printed {printed:.3}", quantity.name());
        approx::assert_relative_eq!(found, printed, max_relative = tolerance);
        // Moving the point by s both ways adds 2 m s^2 together, wherever the parts are (parallel-axis theorem).
        let s = 0.05 * aircraft.reference.chord_m;
        let mass = aircraft.standard_loading.mass_properties(&aircraft).mass_kg;
        // The component groups of the empty aircraft weigh more than the aircraft by their printed rounding.
        let sum = change(5.0).inertia.yy + change(-5.0).inertia.yy;
        approx::assert_relative_eq!(sum, 2.0 * mass * s * s, max_relative = 0.01);
    }
}

#[test]
fn fuel_changes_mass_and_moves_the_centre_of_gravity_towards_its_tanks() {
    let aircraft = c337f();
    let loading = &aircraft.standard_loading;
    let steps = quantities(&aircraft, loading, FRACTION);
    let names: Vec<String> = steps.iter().map(|step| step.quantity.name()).collect();
    assert!(names.ends_with(&["fuel auxiliary".to_owned(), "fuel main".to_owned()]), "{names:?}");
    let before = loading.mass_properties(&aircraft);
    for step in steps.iter().rev().take(2) {
        let change = step.quantity.mass_change(&aircraft, loading, step.half_width).unwrap();
        approx::assert_relative_eq!(change.mass_kg, step.half_width, max_relative = EXACT);
        let tanks = step.quantity.name().replace("fuel ", "");
        let tank = aircraft.tanks.iter().find(|tank| tank.name.starts_with(&tanks)).unwrap();
        // The new centre of gravity divides the distance to the tanks as the masses do.
        let share = change.mass_kg / (before.mass_kg + change.mass_kg);
        let towards = share * (tank.cg_from_datum_m[0] - before.cg_from_datum_m[0]);
        approx::assert_relative_eq!(change.cg_from_datum_m[0], towards, max_relative = EXACT);
    }
}
