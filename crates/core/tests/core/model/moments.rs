//! Forces and moments put together by independent vector algebra come back from the coefficients.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::{InertiaTensor, MassHistory, MassProperties, ReferenceGeometry};
use doublet_core::model::{
    AeroData, Axes, Coefficient, CoefficientSettings, Engine, Gyroscopic, ModelError, Position, ThrustTreatment,
    coefficients,
};
use nalgebra::{Matrix3, Vector3};

/// Rounding of a few products of order one.
const ROUNDING: f64 = 1e-12;
const RATES: Vector3<f64> = Vector3::new(0.3, -0.2, 0.15);
const ANGULAR: Vector3<f64> = Vector3::new(-0.8, 0.6, 0.4);
const FORCE: Vector3<f64> = Vector3::new(1.1, -0.7, -9.4);
const ALPHA: f64 = 0.12;
const SPEED: f64 = 60.0;
const DENSITY: f64 = 1.1;
const CG_DATUM: [f64; 3] = [3.5, 0.02, 1.7];
const THRUST: [f64; 2] = [1200.0, 900.0];
const SPIN: [f64; 2] = [250.0, -240.0];
const ROTOR: f64 = 2.3;

/// One sample of every kind of column, five times over.
fn data() -> AeroData {
    let constant = |value: f64| vec![value; 5];
    let engine = |index: usize, position| Engine {
        thrust_n: constant(THRUST[index]).into(),
        position,
        direction_body: [1.0, 0.0, 0.0],
        rotor_inertia_kg_m2: ROTOR,
        speed_rad_s: constant(SPIN[index]).into(),
    };
    AeroData {
        time_s: (0..5).map(f64::from).collect(),
        airspeed_m_s: constant(SPEED).into(),
        alpha_rad: constant(ALPHA).into(),
        beta_rad: constant(0.0).into(),
        rates_rad_s: [0, 1, 2].map(|axis| constant(RATES[axis])),
        specific_force_m_s2: [0, 1, 2].map(|axis| constant(FORCE[axis])),
        accelerometer: None,
        angular_acceleration_rad_s2: Some([0, 1, 2].map(|axis| constant(ANGULAR[axis]))),
        density_kg_m3: constant(DENSITY).into(),
        controls: BTreeMap::new(),
        mass: MassHistory::Constant(MassProperties { mass_kg: 2000.0, inertia: TENSOR, cg_from_datum_m: CG_DATUM }),
        engines: vec![
            engine(0, Position::Datum([0.6, 0.1, 1.9])),
            engine(1, Position::BodyFromCg([-2.1, -0.05, -0.3])),
        ],
        propeller_pressure: None,
        altitude_m: None,
        mach: None,
    }
}

/// Inertia of a lopsided loading, kg m².
const TENSOR: InertiaTensor = InertiaTensor { xx: 3500.0, yy: 3200.0, zz: 6100.0, xz: 296.0, xy: 41.0, yz: -23.0 };

/// Reference geometry of the example.
fn settings() -> CoefficientSettings {
    CoefficientSettings::new(ReferenceGeometry::conventional(18.7, 11.68, 1.68))
}

/// Body-axes force and moment the motion requires, N and N m, from the tensor.
fn required() -> (Vector3<f64>, Vector3<f64>) {
    let tensor = Matrix3::new(3500.0, -41.0, -296.0, -41.0, 3200.0, 23.0, -296.0, 23.0, 6100.0);
    (FORCE * 2000.0, tensor * ANGULAR + RATES.cross(&(tensor * RATES)))
}

/// Asserts the six body-axes coefficients and the two of stability axes.
fn assert_coefficients(settings: &CoefficientSettings, force: Vector3<f64>, moment: Vector3<f64>) {
    let found = coefficients(&data(), settings).unwrap();
    let scale = 0.5 * DENSITY * SPEED * SPEED * 18.7;
    let (sin, cos) = ALPHA.sin_cos();
    let expected = [
        force.x / scale,
        force.y / scale,
        force.z / scale,
        moment.x / (scale * 11.68),
        moment.y / (scale * 1.68),
        moment.z / (scale * 11.68),
        -(force.x * cos + force.z * sin) / scale,
        (force.x * sin - force.z * cos) / scale,
    ];
    for (coefficient, expected) in Coefficient::ALL.into_iter().zip(expected) {
        for &value in found.get(coefficient) {
            approx::assert_relative_eq!(value, expected, epsilon = ROUNDING, max_relative = ROUNDING);
        }
    }
}

#[test]
fn coefficients_match_euler_equations() {
    let (force, moment) = required();
    assert_coefficients(&settings(), force, moment);
}

#[test]
fn thrust_leaves_force_and_moment_where_asked() {
    let (force, moment) = required();
    let thrust = Vector3::new(THRUST[0] + THRUST[1], 0.0, 0.0);
    // Datum (x aft, z up) to body: (3.5 - 0.6, 0.1 - 0.02, 1.7 - 1.9).
    let arms = [Vector3::new(2.9, 0.08, -0.2), Vector3::new(-2.1, -0.05, -0.3)];
    let thrust_moment: Vector3<f64> =
        arms.iter().zip(THRUST).map(|(arm, thrust)| arm.cross(&Vector3::new(thrust, 0.0, 0.0))).sum();
    let treated = |thrust| CoefficientSettings { thrust, ..settings() };
    assert_coefficients(&treated(ThrustTreatment::ForceRemoved), force - thrust, moment);
    assert_coefficients(&treated(ThrustTreatment::Removed), force - thrust, moment - thrust_moment);
}

#[test]
fn moments_move_to_the_reference_point() {
    let (force, moment) = required();
    let arm = Vector3::new(0.4, 0.02, -0.1);
    let datum = Position::Datum([3.1, 0.04, 1.8]);
    for point in [Position::BodyFromCg(arm.into()), datum] {
        let moved = CoefficientSettings { moment_reference: Some(point), ..settings() };
        assert_coefficients(&moved, force, moment - arm.cross(&force));
    }
}

#[test]
fn stability_axes_turn_roll_and_yaw() {
    let (force, moment) = required();
    let turned = CoefficientSettings { axes: Axes::Stability, ..settings() };
    let (sin, cos) = ALPHA.sin_cos();
    let expected = Vector3::new(moment.x * cos + moment.z * sin, moment.y, moment.z * cos - moment.x * sin);
    assert_coefficients(&turned, force, expected);
}

#[test]
fn gyroscopic_moment_is_that_of_the_propellers_momentum() {
    let (force, moment) = required();
    let with = |gyroscopic| CoefficientSettings { gyroscopic, ..settings() };
    let momentum = |sum: f64| Vector3::new(ROTOR * sum, 0.0, 0.0);
    assert_coefficients(&with(Gyroscopic::Signed), force, moment + RATES.cross(&momentum(10.0)));
    assert_coefficients(&with(Gyroscopic::Summed), force, moment + RATES.cross(&momentum(490.0)));
}

#[test]
fn bad_columns_are_rejected_with_name_and_time() {
    let mut short = data();
    short.beta_rad = short.beta_rad[1..].into();
    assert_eq!(coefficients(&short, &settings()).unwrap_err().to_string(), "column beta has 4 samples, time has 5");
    let mut broken = data();
    broken.rates_rad_s[1][3] = f64::NAN;
    assert!(matches!(
        coefficients(&broken, &settings()),
        Err(ModelError::NotFinite { time_s: 3.0, ref column }) if column == "q"
    ));
    let mut stopped = data();
    Arc::make_mut(&mut stopped.airspeed_m_s)[2] = 0.0;
    assert!(matches!(
        coefficients(&stopped, &settings()),
        Err(ModelError::NotPositive { quantity: "airspeed", time_s: 2.0, .. })
    ));
    let mut gliding = data();
    gliding.engines.clear();
    let removed = CoefficientSettings { thrust: ThrustTreatment::Removed, ..settings() };
    assert!(matches!(coefficients(&gliding, &removed), Err(ModelError::NoEngine { .. })));
}
