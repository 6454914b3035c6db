//! Data compatibility on a motion whose every channel is known: each relation has the slope one, each mistake is named.

use std::collections::BTreeMap;

use doublet_core::compatibility::{Agreement, Compatibility, TellingVelocity, check};
use doublet_core::quantity::Role::{self, *};
use doublet_core::series::{Channel, Recording, Series};
use nalgebra::{Rotation3, Vector3};

mod aerobatics;
mod causes;
mod recorders;

/// Samples per second.
const RATE_HZ: f64 = 25.0;
/// Length, s.
const LENGTH_S: f64 = 80.0;
/// Gravity, m/s².
const GRAVITY_M_S2: f64 = 9.80665;
/// Steady wind, north, east and down, m/s.
const WIND_M_S: [f64; 3] = [6.0, -3.0, 0.0];

/// Bank, pitch and heading, rad; airspeed, m/s; angle of attack and sideslip, rad: sums of sines that nothing ties together.
fn shape(t: f64) -> ([f64; 3], [f64; 3]) {
    let wave =
        |amplitude: f64, period_s: f64, phase: f64| amplitude * (std::f64::consts::TAU * t / period_s + phase).sin();
    let attitude = [
        wave(0.4, 17.0, 0.0) + wave(0.08, 2.3, 1.0),
        0.05 + wave(0.08, 11.0, 0.5) + wave(0.02, 1.9, 0.0),
        1.0 + 0.05 * t + wave(0.3, 23.0, 0.3) + wave(0.03, 2.9, 2.0),
    ];
    let air = [70.0 + wave(5.0, 31.0, 0.0), 0.06 + wave(0.03, 2.1, 0.4), wave(0.05, 2.7, 1.3)];
    (attitude, air)
}

fn body_to_earth(t: f64) -> Rotation3<f64> {
    let ([phi, theta, psi], _) = shape(t);
    Rotation3::from_euler_angles(phi, theta, psi)
}

/// Velocity over the ground, north, east and down.
fn velocity(t: f64) -> Vector3<f64> {
    let (_, [speed, alpha, beta]) = shape(t);
    let air = speed * Vector3::new(alpha.cos() * beta.cos(), beta.sin(), alpha.sin() * beta.cos());
    body_to_earth(t) * air + Vector3::from(WIND_M_S)
}

/// Angular rate in body axes, from the rotation over a short time.
fn rates(t: f64) -> Vector3<f64> {
    let h = 1e-4;
    (body_to_earth(t - h).inverse() * body_to_earth(t + h)).scaled_axis() / (2.0 * h)
}

/// Samples of inertial sensors, attitude and path over the ground at one time.
fn sample_path(
    rate: Vector3<f64>,
    force: Vector3<f64>,
    attitude: [f64; 3],
    ground: Vector3<f64>,
    position: Vector3<f64>,
) -> [(Role, f64); 16] {
    [
        (RollRate, rate[0]),
        (PitchRate, rate[1]),
        (YawRate, rate[2]),
        (SpecificForceX, force[0]),
        (SpecificForceY, force[1]),
        (SpecificForceZ, force[2]),
        (BankAngle, attitude[0]),
        (PitchAngle, attitude[1]),
        (HeadingAngle, attitude[2].rem_euclid(std::f64::consts::TAU)),
        (VelocityNorth, ground[0]),
        (VelocityEast, ground[1]),
        (VelocityDown, ground[2]),
        (PositionNorth, position[0]),
        (PositionEast, position[1]),
        (PositionDown, position[2]),
        (Altitude, -position[2]),
    ]
}

/// Every channel at its samples; positions by a fine sum.
fn columns() -> BTreeMap<Role, Vec<f64>> {
    let mut columns: BTreeMap<Role, Vec<f64>> = BTreeMap::new();
    let mut position = Vector3::new(0.0, 0.0, -1500.0);
    let fine = 1.0 / (10.0 * RATE_HZ);
    for sample in 0..(RATE_HZ * LENGTH_S).round() as usize {
        let t = sample as f64 / RATE_HZ;
        let h = 1e-4;
        let acceleration = (velocity(t + h) - velocity(t - h)) / (2.0 * h);
        let force = body_to_earth(t).inverse() * (acceleration - Vector3::new(0.0, 0.0, GRAVITY_M_S2));
        let (rate, slope) = (rates(t), (rates(t + h) - rates(t - h)) / (2.0 * h));
        let (attitude, air) = shape(t);
        let ground = velocity(t);
        // Each surface answers for what the damping of its axis does not: w' = -2 w - 6 delta.
        let surfaces = (-slope - 2.0 * rate) / 6.0;
        let altitude_m = -position[2];
        let temperature_k = 288.15 - 0.0065 * altitude_m;
        let of_path = sample_path(rate, force, attitude, ground, position);
        let of_air = [
            (TrueAirspeed, air[0]),
            (AngleOfAttack, air[1]),
            (Sideslip, air[2]),
            (Aileron, surfaces[0]),
            (Elevator, surfaces[1]),
            (Rudder, surfaces[2]),
            (AirTemperature, temperature_k),
            (Mach, air[0] / (1.4 * 287.05287 * temperature_k).sqrt()),
        ];
        for (role, value) in of_path.into_iter().chain(of_air) {
            columns.entry(role).or_default().push(value);
        }
        for part in 0..10 {
            position += fine * velocity(t + fine * (f64::from(part) + 0.5));
        }
    }
    columns
}

fn recording(columns: &BTreeMap<Role, Vec<f64>>, time_factor: f64) -> Recording {
    let mut recording = Recording::default();
    for (role, values) in columns {
        let time_s = (0..values.len()).map(|sample| time_factor * sample as f64 / RATE_HZ).collect();
        let series = Series { time_s, values: values.clone().into() };
        recording.roles.insert(*role, recording.channels.len());
        let (name, unit) = (role.name().to_owned(), role.dimension().si_symbol().to_owned());
        recording.channels.push(Channel { source: "made".to_owned(), name, unit, series });
    }
    recording
}

/// What is found when the channels are changed so.
fn found(change: impl FnOnce(&mut BTreeMap<Role, Vec<f64>>)) -> Compatibility {
    let mut columns = columns();
    change(&mut columns);
    check(&recording(&columns, 1.0))
}

fn mistakes(found: &Compatibility) -> Vec<String> {
    found.contradictions().map(|row| format!("{}: {}", row.channel, row.hypothesis)).collect()
}

fn scaled(columns: &mut BTreeMap<Role, Vec<f64>>, role: Role, factor: f64) {
    let Some(values) = columns.get_mut(&role) else { panic!("no {}", role.name()) };
    values.iter_mut().for_each(|value| *value *= factor);
}

#[test]
fn every_relation_of_a_true_motion_has_the_slope_one() {
    let found = found(|_| ());
    assert_eq!(mistakes(&found), Vec::<String>::new());
    let told: Vec<_> = found.rows.iter().filter(|row| row.agreement == Agreement::Fits).collect();
    // All but those of channels that are not there; the side force follows no sideslip in a motion without aerodynamics.
    assert!(told.len() >= 24, "{} of {}: {:#?}", told.len(), found.rows.len(), found.rows);
    for row in told {
        let (Some(slope), Some(r2)) = (row.slope, row.r2) else { panic!("{row:?} has no figures") };
        if row.channel.starts_with("delta") {
            assert!((slope + 6.0).abs() < 0.5, "the effect of each surface is -6: {}", row.evidence);
        } else {
            // Flight-path relations take small angles, air data a standard day.
            let tolerance = if row.evidence.contains("flight-path") { 0.1 } else { 0.03 };
            assert!((slope - 1.0).abs() < tolerance && r2 > 0.95, "{}", row.evidence);
        }
    }
}

#[test]
fn a_turned_sign_of_each_channel_is_named() {
    let signed = [
        (RollRate, "p"),
        (PitchRate, "q"),
        (YawRate, "r"),
        (SpecificForceX, "ax"),
        (SpecificForceY, "ay"),
        (SpecificForceZ, "az"),
        (BankAngle, "phi"),
        (PitchAngle, "theta"),
        (HeadingAngle, "psi"),
        (VelocityNorth, "v_north"),
        (VelocityEast, "v_east"),
        (VelocityDown, "v_down"),
        (PositionNorth, "x"),
        (PositionEast, "y"),
        (PositionDown, "z"),
        (AngleOfAttack, "alpha"),
        (Sideslip, "beta"),
        (Aileron, "delta_a"),
        (Elevator, "delta_e"),
        (Rudder, "delta_r"),
    ];
    for (role, name) in signed {
        let found = found(|columns| scaled(columns, role, -1.0));
        assert_eq!(mistakes(&found), [format!("{name}: sign reversed")]);
    }
}

#[test]
fn a_wrong_unit_of_each_kind_is_named_with_its_factor() {
    let degree = 180.0 / std::f64::consts::PI;
    let cases = [
        (RollRate, degree, "p: degrees per second, not radians"),
        (RollRate, 1.0 / degree, "p: radians per second, not degrees"),
        (PitchAngle, degree, "theta: degrees, not radians"),
        (AngleOfAttack, degree, "alpha: degrees, not radians"),
        (Sideslip, 1.0 / degree, "beta: radians, not degrees"),
        (Aileron, degree, "delta_a: degrees, not radians"),
        (SpecificForceZ, 1.0 / 9.80665, "az: in g"),
        (SpecificForceX, 1.0 / 0.3048, "ax: feet per second squared"),
        (TrueAirspeed, 1.0 / 0.514_444, "airspeed: knots"),
        (TrueAirspeed, 3.6, "airspeed: kilometres per hour"),
        (TrueAirspeed, 0.514_444, "airspeed: metres per second, not knots"),
        (VelocityDown, 60.0 / 0.3048, "v_down: feet per minute"),
        (VelocityNorth, 1.0 / 0.3048, "v_north: feet per second"),
        (Altitude, 1.0 / 0.3048, "altitude: feet"),
        (PositionDown, 1.0 / 0.3048, "z: feet"),
    ];
    for (role, factor, expected) in cases {
        let found = found(|columns| scaled(columns, role, factor));
        assert_eq!(mistakes(&found), [expected]);
        let row = found.contradictions().next();
        let Some(back) = row.and_then(|row| row.factor) else { panic!("{expected} has no factor") };
        assert!((back * factor - 1.0).abs() < 0.01, "{expected}: {back} does not undo {factor}");
    }
}

#[test]
fn exchanged_channels_and_removed_gravity_are_named() {
    for (one, other, expected) in [
        (BankAngle, PitchAngle, "phi: swapped with theta"),
        (AngleOfAttack, Sideslip, "alpha: swapped with beta"),
        (RollRate, YawRate, "p: swapped with r"),
        (SpecificForceX, SpecificForceZ, "ax: swapped with az"),
        (VelocityNorth, VelocityEast, "v_north: swapped with v_east"),
        (Aileron, Elevator, "delta_a: swapped with delta_e"),
    ] {
        let found = found(|columns| {
            let (first, second) = (columns.remove(&one), columns.remove(&other));
            columns.extend(second.map(|values| (one, values)).into_iter().chain(first.map(|values| (other, values))));
        });
        assert_eq!(mistakes(&found), [expected]);
    }
    let removed = found(|columns| {
        columns.entry(SpecificForceZ).and_modify(|az| az.iter_mut().for_each(|value| *value += GRAVITY_M_S2));
    });
    assert_eq!(mistakes(&removed), ["az: gravity removed"]);
}

#[test]
fn units_of_one_box_and_ticks_are_decided_together() {
    let degree = 180.0 / std::f64::consts::PI;
    let all =
        found(|columns| [RollRate, PitchRate, YawRate].into_iter().for_each(|role| scaled(columns, role, degree)));
    let named = ["p", "q", "r"].map(|name| format!("{name}: degrees per second, not radians"));
    assert_eq!(mistakes(&all), named);
    for (factor, expected) in [
        (1e3, "time: milliseconds"),
        (1e6, "time: microseconds"),
        (1e9, "time: nanoseconds"),
        (1e-3, "time: seconds, not milliseconds"),
        (1.0 / 86_400.0, "time: days"),
    ] {
        assert_eq!(mistakes(&check(&recording(&columns(), factor))), [expected]);
    }
    let fast = check(&recording(&columns(), 1.02));
    let row = fast.contradictions().next();
    let Some(slope) = row.and_then(|row| row.slope) else { panic!("a clock 2 % fast is not told: {:#?}", fast.rows) };
    assert!((slope - 1.02).abs() < 0.003, "{slope}");
}

#[test]
fn a_slow_clock_that_nothing_tells_is_asked_about() {
    let mut columns = columns();
    columns.retain(|role, _| *role == PitchRate);
    let found = check(&recording(&columns, 1e3));
    let rows: Vec<_> = found.contradictions().collect();
    let [row] = rows[..] else { panic!("{rows:?}") };
    assert_eq!((row.agreement, row.channel.as_str()), (Agreement::Doubtful, "time"));
    assert!(row.evidence.contains("state the unit"), "{}", row.evidence);
}

#[test]
fn two_mistakes_at_once_are_both_named() {
    let found = found(|columns| {
        scaled(columns, SpecificForceZ, -1.0);
        scaled(columns, TrueAirspeed, 1.0 / 0.514_444);
    });
    let mut named = mistakes(&found);
    named.sort();
    assert_eq!(named, ["airspeed: knots", "az: sign reversed"]);
}

/// Accelerometers that ride on a point of the aircraft feel the second difference of its place, which no formula of the estimate knows.
#[test]
fn place_of_the_accelerometers_is_told_by_the_ground_velocity() {
    const CLOSE_M: f64 = 0.03;
    for place in [[0.0; 3], [3.1, -0.4, -1.2], [-0.5, 0.0, 0.3]] {
        let found = found(|columns| {
            let moved = |t: f64| body_to_earth(t) * Vector3::from(place);
            for sample in 0..columns[&SpecificForceX].len() {
                let (t, h) = (sample as f64 / RATE_HZ, 1e-3);
                let felt = (moved(t + h) - 2.0 * moved(t) + moved(t - h)) / (h * h);
                let felt = body_to_earth(t).inverse() * felt;
                for (axis, role) in [SpecificForceX, SpecificForceY, SpecificForceZ].into_iter().enumerate() {
                    if let Some(values) = columns.get_mut(&role) {
                        values[sample] += felt[axis];
                    }
                }
            }
        });
        let Some(told) = found.accelerometer else { panic!("no place of {place:?}") };
        println!("{place:?}: {told:?}");
        for axis in 0..3 {
            assert!((told.from_velocity_m[axis] - place[axis]).abs() < CLOSE_M, "{place:?} {told:?}");
            assert!(told.errors_m[axis] < CLOSE_M, "{told:?}");
        }
    }
    // A turned sign tells no place.
    assert_eq!(found(|columns| scaled(columns, SpecificForceY, -1.0)).accelerometer, None);
}

/// Five samples a second that are 0.12 s late: neither the delay nor straight lines between the samples move the place.
#[test]
fn place_of_the_accelerometers_is_told_by_a_slow_and_late_ground_velocity() {
    let mut late = recording(&columns(), 1.0);
    for role in [VelocityNorth, VelocityEast, VelocityDown] {
        let series = &mut late.channels[late.roles[&role]].series;
        let times = series.time_s.iter().step_by(5).map(|time_s| time_s + 0.12);
        *series = Series { time_s: times.collect(), values: series.values.iter().step_by(5).copied().collect() };
    }
    let Some(told) = check(&late).accelerometer else { panic!("no place") };
    println!("{told:?}");
    assert_eq!(told.by, TellingVelocity::Ground);
    assert!(told.from_velocity_m.iter().all(|place| place.abs() < 0.1), "{told:?}");
    let (delay_s, error_s) = told.delay_s;
    assert!((delay_s - 0.12).abs() < 0.01 && error_s < 0.01, "{told:?}");
}

#[test]
fn place_of_the_accelerometers_is_told_by_airspeed_and_vanes_without_a_ground_velocity() {
    let found = found(|columns| {
        columns.retain(|role, _| ![VelocityNorth, VelocityEast, VelocityDown].contains(role));
    });
    let Some(told) = found.accelerometer else { panic!("no place") };
    assert_eq!(told.by, TellingVelocity::Air);
    assert!(told.from_velocity_m.iter().all(|place| place.abs() < 0.1), "{told:?}");
}

#[test]
fn airspeed_that_is_off_by_a_factor_is_told_with_it() {
    let found = found(|columns| scaled(columns, TrueAirspeed, 1.12));
    assert_eq!(mistakes(&found), ["airspeed: 12 % too large"]);
    let factor = found.rows.iter().find_map(|row| row.factor).unwrap_or_default();
    assert!((factor * 1.12 - 1.0).abs() < 0.01, "{factor}");
}
