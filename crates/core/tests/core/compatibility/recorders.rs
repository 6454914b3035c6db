//! Several recorders whose clocks are shifted against each other, flow angles with an offset, deflections that are no angles.

use std::collections::BTreeMap;

use doublet_core::compatibility::{Agreement, ChannelFix, Compatibility, check};
use doublet_core::quantity::Role::{self, *};

use super::{columns, found, mistakes, recording, scaled};

/// The recorder a channel came from, where there are four.
fn one_of_four(role: Role) -> &'static str {
    match role {
        BankAngle | PitchAngle | HeadingAngle => "attitude",
        VelocityNorth | VelocityEast | VelocityDown | PositionNorth | PositionEast | PositionDown => "navigation",
        TrueAirspeed | AngleOfAttack | Sideslip | Altitude | AirTemperature | Mach => "air",
        _ => "inertial",
    }
}

/// Where flow angles and air data have a recorder of their own.
fn one_of_two(role: Role) -> &'static str {
    if one_of_four(role) == "air" { "pod" } else { "bus" }
}

/// The motion by recorders, those of one of them stamped late.
fn stamped(columns: &BTreeMap<Role, Vec<f64>>, of: fn(Role) -> &'static str, late: (&str, f64)) -> Compatibility {
    let mut recording = recording(columns, 1.0);
    for (role, index) in recording.roles.clone() {
        let channel = &mut recording.channels[index];
        channel.source = of(role).to_owned();
        if channel.source == late.0 {
            channel.series.time_s = channel.series.time_s.iter().map(|time| time + late.1).collect();
        }
    }
    check(&recording)
}

#[test]
fn stamps_of_one_recorder_that_are_late_or_early_are_named_with_the_shift() {
    let columns = columns();
    for of in [one_of_four, one_of_two] {
        assert_eq!(mistakes(&stamped(&columns, of, ("", 0.0))), Vec::<String>::new(), "clocks that agree");
    }
    let cases = [
        (one_of_four as fn(Role) -> &'static str, "attitude", 0.3),
        (one_of_four, "attitude", -1.0),
        (one_of_four, "navigation", 0.3),
        (one_of_four, "navigation", 1.0),
        (one_of_four, "air", -0.3),
        (one_of_four, "air", 1.0),
        (one_of_four, "inertial", 0.3),
        (one_of_four, "inertial", 1.0),
        (one_of_two, "pod", 0.3),
        (one_of_two, "pod", -1.0),
    ];
    for (of, source, late_s) in cases {
        let found = stamped(&columns, of, (source, late_s));
        let rows: Vec<_> = found.contradictions().collect();
        let [row] = rows[..] else { panic!("{source} {late_s}: {:?}", mistakes(&found)) };
        let Some(ChannelFix::Shift { source: named, late_s: by_s }) = &row.fix else { panic!("{source}: {row:?}") };
        println!("{source} {late_s} s late: {}; {}", row.headline(), row.evidence);
        assert_eq!((row.channel.as_str(), named.as_str()), ("time", source));
        assert!((by_s - late_s).abs() < 0.05, "{source}: {by_s} for {late_s}");
    }
}

#[test]
fn a_turned_sign_is_named_beside_a_late_recorder() {
    let mut columns = columns();
    scaled(&mut columns, PitchAngle, -1.0);
    let found = stamped(&columns, one_of_four, ("navigation", 0.5));
    let named = mistakes(&found);
    assert_eq!(named, ["time: source navigation is 0.50 s late", "theta: sign reversed"]);
}

#[test]
fn curves_of_a_mistake_come_together_by_its_cure() {
    let apart = |trace: &doublet_core::compatibility::Trace| {
        let square = |of: &dyn Fn(usize) -> f64| (0..trace.time_s.len()).map(|k| of(k).powi(2)).sum::<f64>();
        (square(&|k| trace.channel[k] - trace.others[k]) / square(&|k| trace.others[k])).sqrt()
    };
    let degree = 180.0 / std::f64::consts::PI;
    for (role, factor) in [(RollRate, -1.0), (PitchRate, degree), (TrueAirspeed, 1.0 / 0.514_444), (Elevator, -1.0)] {
        let found = found(|columns| scaled(columns, role, factor));
        let Some(curves) = found.contradictions().next().and_then(|row| row.curves.as_ref()) else {
            panic!("{} has no curves", role.name())
        };
        let (before, after) = (apart(&curves.before), apart(&curves.after));
        println!("{}: {before:.3} before, {after:.3} after, {} points", role.name(), curves.after.time_s.len());
        assert!(curves.after.time_s.len() >= 20 && curves.after.time_s.is_sorted());
        // The surfaces act beside the damping of their axes.
        let near = if role == Elevator { 0.8 } else { 0.1 };
        assert!(before > 0.4 && after < near && after < 0.5 * before, "{}: {before} {after}", role.name());
    }
}

#[test]
fn an_offset_of_a_flow_angle_is_named_in_degrees() {
    let shifted = |role: Role, degrees: f64| {
        found(|columns| {
            let add = |values: &mut Vec<f64>| values.iter_mut().for_each(|value| *value += degrees.to_radians());
            columns.entry(role).and_modify(add);
        })
    };
    for degrees in [6.1, -8.0] {
        let found = shifted(AngleOfAttack, degrees);
        let rows: Vec<_> = found.contradictions().collect();
        let [row] = rows[..] else { panic!("{degrees}: {:?}", mistakes(&found)) };
        let Some(ChannelFix::Scale { role: AngleOfAttack, factor: 1.0, offset, units: None }) = row.fix else {
            panic!("{row:?}")
        };
        println!("{}: {}", row.headline(), row.evidence);
        // The flight path is taken without sideslip and bank: some tenths of a degree.
        assert!((offset.to_degrees() + degrees).abs() < 0.4, "{}", offset.to_degrees());
        assert!(row.headline().to_string().starts_with(&format!("alpha: offset {:+.1} deg", -offset.to_degrees())));
    }
    // A small one is said with what else may be meant.
    let small = shifted(AngleOfAttack, -3.0);
    let rows: Vec<_> = small.contradictions().collect();
    let [row] = rows[..] else { panic!("{:?}", mistakes(&small)) };
    assert_eq!(row.agreement, Agreement::Doubtful);
    let offset_deg = row.slope.map(f64::to_degrees).unwrap_or_default();
    assert!((offset_deg + 3.0).abs() < 0.4 && row.fix.is_some(), "{}", row.evidence);
    assert_eq!(row.hypothesis, format!("offset {offset_deg:+.1} deg"));
    assert_eq!(mistakes(&shifted(AngleOfAttack, 1.2)), Vec::<String>::new(), "wind and position error do as much");
}

#[test]
fn an_offset_of_sideslip_is_told_by_the_side_force() {
    // The motion has no side force of its own: one is put in the place of it, -12 m/s2 per rad, with the accelerometer alone.
    let with = |degrees: f64| {
        let mut columns = columns();
        columns.retain(|role, _| matches!(role, Sideslip | RollRate | PitchRate));
        let beta = columns[&Sideslip].clone();
        columns.insert(SpecificForceY, beta.iter().map(|beta| -12.0 * beta).collect());
        columns.insert(Sideslip, beta.iter().map(|beta| beta + degrees.to_radians()).collect());
        check(&recording(&columns, 1.0))
    };
    assert_eq!(mistakes(&with(7.0)), ["beta: offset +7.0 deg"]);
    assert_eq!(mistakes(&with(4.0)), Vec::<String>::new());
}

/// A pitching motion of a light aircraft, `q' = -2 q - 15 delta_e`, with the elevator moved by up to `reach` rad and recorded `factor`
/// times as large.
fn pitched(reach: f64, factor: f64) -> Compatibility {
    pitched_late(reach, factor, 1.0, 0.0)
}

/// The same with the elevator moved `quicker` times as fast and recorded `delay_s` late.
fn pitched_late(reach: f64, factor: f64, quicker: f64, delay_s: f64) -> Compatibility {
    let (mut columns, step_s) = (BTreeMap::<Role, Vec<f64>>::new(), 1e-3);
    let mut q = 0.0;
    for k in 0..60_000 {
        let t = f64::from(k) * step_s;
        let at = |t: f64| reach * (0.6 * (1.3 * quicker * t).sin() + 0.4 * (3.1 * quicker * t).sin());
        let delta = at(t);
        if k % 40 == 0 {
            for (role, value) in [(PitchRate, q), (Elevator, factor * at(t - delay_s))] {
                columns.entry(role).or_default().push(value);
            }
        }
        q += step_s * (-2.0 * q - 15.0 * delta);
    }
    check(&recording(&columns, 1.0))
}

#[test]
fn sign_of_a_control_is_found_beside_its_delay() {
    // A quarter of the quicker period is 0.14 s.
    for delay_s in [-0.25, -0.1, 0.0, 0.1, 0.25] {
        assert_eq!(mistakes(&pitched_late(0.05, 1.0, 3.5, delay_s)), Vec::<String>::new(), "{delay_s} s");
    }
    for delay_s in [-0.1, 0.0, 0.1] {
        assert_eq!(mistakes(&pitched_late(0.05, -1.0, 3.5, delay_s)), ["delta_e: sign reversed"], "{delay_s} s");
    }
}

#[test]
fn a_deflection_that_is_a_part_of_full_travel_is_named() {
    let degree = std::f64::consts::PI / 180.0;
    let full = 25.0 * degree;
    for (factor, expected) in [
        (100.0 * degree / full, "delta_e: percent of full travel, not degrees"),
        (100.0 / full, "delta_e: percent of full travel, not radians"),
        (1.0 / full, "delta_e: normalised to full travel, not radians"),
        (degree / full, "delta_e: normalised to full travel, not degrees"),
    ] {
        let found = pitched(0.95 * full, factor);
        assert_eq!(mistakes(&found), [expected]);
        let Some(row) = found.contradictions().next() else { panic!("{expected}") };
        println!("{}: {}", row.headline(), row.evidence);
        assert!(row.evidence.contains("deg") && row.curves.is_some(), "{row:?}");
    }
    // Angles as they are, and those of a small manoeuvre in degrees read as radians.
    assert_eq!(mistakes(&pitched(full, 1.0)), Vec::<String>::new());
    assert_eq!(mistakes(&pitched(1.2 * degree, 1.0 / degree)), ["delta_e: degrees, not radians"]);
}

#[test]
fn altitude_of_few_bits_does_not_contradict_the_vertical_velocity() {
    let rounded = |step_m: f64| {
        found(|columns| {
            for role in [Altitude, PositionDown] {
                columns
                    .get_mut(&role)
                    .unwrap()
                    .iter_mut()
                    .for_each(|value| *value = (*value / step_m).round() * step_m);
            }
        })
    };
    for step_m in [5.0, 20.0, 40.0] {
        assert_eq!(mistakes(&rounded(step_m)), Vec::<String>::new(), "step of {step_m} m");
    }
}
