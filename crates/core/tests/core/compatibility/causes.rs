//! Mistakes that hide each other, and what looks like a mistake and is none.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use doublet_core::compatibility::{Agreement, ChannelFix, Compatibility, check};
use doublet_core::quantity::Role::{self, *};

use super::{GRAVITY_M_S2, columns, found, mistakes, recording, scaled};

/// Channels sampled at 25 Hz over `length_s`.
fn sampled(length_s: f64, of: impl Fn(f64) -> Vec<(Role, f64)>) -> BTreeMap<Role, Vec<f64>> {
    let mut columns = BTreeMap::<Role, Vec<f64>>::new();
    let mut t = 0.0;
    while t < length_s {
        of(t).into_iter().for_each(|(role, value)| columns.entry(role).or_default().push(value));
        t += 1.0 / super::RATE_HZ;
    }
    columns
}

/// White noise of a deviation of one, the same in every run.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut even = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| even()).sum::<f64>() - 6.0
}

#[test]
fn signs_that_hide_each_other_are_turned_together() {
    for roles in [vec![SpecificForceZ, VelocityDown], vec![SpecificForceZ, VelocityDown, PositionDown]] {
        let found = found(|columns| roles.iter().for_each(|role| scaled(columns, *role, -1.0)));
        let mut named = mistakes(&found);
        named.sort();
        let mut expected: Vec<String> = roles.iter().map(|role| format!("{}: sign reversed", role.name())).collect();
        expected.sort();
        assert_eq!(named, expected);
    }
}

#[test]
fn a_box_a_quarter_turn_about_exchanges_rates_and_accelerations() {
    let swapped = |pairs: &[(Role, Role)]| {
        found(|columns| {
            for (one, other) in pairs {
                let (first, second) = (columns.remove(one), columns.remove(other));
                columns.extend(second.map(|values| (*one, values)));
                columns.extend(first.map(|values| (*other, values)));
            }
        })
    };
    let whole = swapped(&[(RollRate, PitchRate), (SpecificForceX, SpecificForceY)]);
    let mut named = mistakes(&whole);
    named.sort();
    assert_eq!(named, ["ax: swapped with ay", "p: swapped with q"]);
    assert_eq!(mistakes(&swapped(&[(RollRate, PitchRate)])), ["p: swapped with q"]);
}

#[test]
fn gravity_that_is_removed_by_the_attitude_is_told_from_a_constant_one() {
    let found = found(|columns| {
        for sample in 0..columns[&BankAngle].len() {
            let [(sin_phi, cos_phi), (sin_theta, cos_theta)] =
                [BankAngle, PitchAngle].map(|role| columns[&role][sample].sin_cos());
            let gravity = [-sin_theta, cos_theta * sin_phi, cos_theta * cos_phi].map(|part| GRAVITY_M_S2 * part);
            for (role, part) in [SpecificForceX, SpecificForceY, SpecificForceZ].into_iter().zip(gravity) {
                columns.entry(role).and_modify(|values| values[sample] += part);
            }
        }
    });
    let rows: Vec<_> = found.contradictions().collect();
    let [row] = rows[..] else { panic!("{:?}", mistakes(&found)) };
    assert_eq!((row.channel.as_str(), row.hypothesis.as_str()), ("az", "gravity removed by the attitude"));
    assert!(row.fix.is_none() && row.factor.is_none() && row.evidence.contains("add g sin(theta) to ax"), "{row:?}");
}

/// The motion with the heading off by `degrees`, of the channels `kept` alone.
fn turned(degrees: f64, kept: impl Fn(Role) -> bool) -> Compatibility {
    let mut columns = columns();
    columns.retain(|role, _| kept(*role));
    let turn = |psi: &mut f64| *psi = (*psi + degrees.to_radians()).rem_euclid(TAU);
    columns.entry(HeadingAngle).and_modify(|values| values.iter_mut().for_each(turn));
    check(&recording(&columns, 1.0))
}

#[test]
fn a_magnetic_heading_is_named_with_its_variation() {
    let without_accelerometers =
        |role: Role| !matches!(role, SpecificForceX | SpecificForceY | SpecificForceZ | PositionNorth | PositionEast);
    let without_airspeed = |role: Role| role != TrueAirspeed;
    let kept: [(&str, &dyn Fn(Role) -> bool); 3] =
        [("all", &|_| true), ("no accelerometers", &without_accelerometers), ("no airspeed", &without_airspeed)];
    for (which, kept) in kept {
        for degrees in [12.0, -20.0] {
            let found = turned(degrees, kept);
            let rows: Vec<_> = found.contradictions().collect();
            let [row] = rows[..] else { panic!("{which}, {degrees}: {:?}", mistakes(&found)) };
            let Some(ChannelFix::Scale { role: HeadingAngle, factor: 1.0, offset, units: None }) = row.fix else {
                panic!("{row:?}")
            };
            println!("{which}: {}; {}", row.headline(), row.evidence);
            assert!((offset.to_degrees() + degrees).abs() < 0.3, "{which}: {} for {degrees}", offset.to_degrees());
            let side = if degrees > 0.0 { "west" } else { "east" };
            let variation = format!("variation is {:.1} deg {side}", offset.abs().to_degrees());
            assert!(row.agreement == Agreement::Contradicts && row.evidence.contains(&variation), "{}", row.evidence);
            assert!(row.headline().to_string().ends_with(" deg"), "{}", row.headline());
        }
        assert_eq!(mistakes(&turned(2.0, kept)), Vec::<String>::new(), "{which}: as much as a mounting");
    }
    // So large an angle is no variation.
    let far = turned(80.0, |_| true);
    assert!(far.contradictions().all(|row| !row.evidence.contains("magnetic")), "{:?}", mistakes(&far));
}

#[test]
fn noise_of_an_altitude_is_not_taken_for_its_slope() {
    let climbing = |amplitude_m_s: f64, sign: f64| {
        let omega = TAU / 35.0;
        let mut columns = sampled(120.0, |t| {
            let climb = amplitude_m_s * (omega * t).sin();
            let altitude = 500.0 + amplitude_m_s * (1.0 - (omega * t).cos()) / omega;
            vec![(VelocityDown, -sign * climb), (Altitude, altitude)]
        });
        let mut noise = noise(7);
        columns.entry(Altitude).and_modify(|values| values.iter_mut().for_each(|value| *value += 1.5 * noise()));
        let found = check(&recording(&columns, 1.0));
        let row = found.rows.iter().find(|row| row.evidence.contains("the rate of change of altitude")).cloned();
        let Some(row) = row else { panic!("{:?}", found.rows) };
        (row.agreement, row.hypothesis.clone())
    };
    for amplitude_m_s in [0.0, 0.3, 0.6, 1.0] {
        assert_eq!(climbing(amplitude_m_s, 1.0).0, Agreement::Undetermined, "{amplitude_m_s}");
    }
    assert_eq!(climbing(4.0, 1.0).0, Agreement::Fits);
    assert_eq!(climbing(4.0, -1.0), (Agreement::Contradicts, "sign reversed".to_owned()));
}

#[test]
fn a_unit_is_not_named_where_the_channel_at_rest_holds_as_well() {
    // Pitching at a constant angle of attack, of which a bad vane records something else: any factor that makes it small mends that.
    let columns = sampled(80.0, |t| {
        let q = 0.15 * (TAU * t / 5.0).sin() + 0.05 * (TAU * t / 2.3).sin();
        let alpha = 0.05 + 0.08 * (TAU * t / 3.1).sin();
        vec![(PitchRate, q), (TrueAirspeed, 100.0), (SpecificForceZ, -GRAVITY_M_S2 - 100.0 * q), (AngleOfAttack, alpha)]
    });
    let found = check(&recording(&columns, 1.0));
    assert!(found.contradictions().all(|row| row.agreement != Agreement::Contradicts), "{:?}", mistakes(&found));
}

#[test]
fn a_clear_line_of_another_slope_is_no_matter_of_gusts() {
    for (role, factor) in [(Sideslip, 0.7), (AngleOfAttack, 0.6)] {
        let found = found(|columns| scaled(columns, role, factor));
        let rows: Vec<_> = found.contradictions().collect();
        assert!(rows.iter().all(|row| row.agreement == Agreement::Doubtful), "{:?}", mistakes(&found));
        let own = rows.iter().find(|row| row.channel == role.name());
        let (Some(slope), Some(r2)) = own.map_or((None, None), |row| (row.slope, row.r2)) else {
            panic!("{}: {:?}", role.name(), mistakes(&found))
        };
        println!("{}: slope {slope:.3}, R2 {r2:.3}", role.name());
        assert!((slope - factor).abs() < 0.1 && r2 > 0.98, "{slope} {r2}");
    }
}

/// Motion by inertial sensors, attitude and ground velocity alone, which is noisy.
fn inertial(columns: &mut BTreeMap<Role, Vec<f64>>) {
    let kept = [
        RollRate, PitchRate, YawRate, SpecificForceX, SpecificForceY, SpecificForceZ, BankAngle, PitchAngle,
        HeadingAngle, VelocityNorth, VelocityEast, VelocityDown,
    ];
    columns.retain(|role, _| kept.contains(role));
    for (index, role) in [VelocityNorth, VelocityEast, VelocityDown].into_iter().enumerate() {
        let noise = |sample: usize| 0.6 * ((1.7 + sample as f64) * (12.9898 + index as f64)).sin() * 43758.547;
        let values = columns.get_mut(&role).into_iter().flatten().enumerate();
        values.for_each(|(sample, value)| *value += noise(sample).rem_euclid(1.2) - 0.6);
    }
}

#[test]
fn a_side_force_reversed_is_named_by_a_noisy_ground_velocity() {
    let clean = found(inertial);
    assert_eq!(mistakes(&clean), Vec::<String>::new());
    let reversed = found(|columns| {
        inertial(columns);
        scaled(columns, SpecificForceY, -1.0);
    });
    assert_eq!(mistakes(&reversed), ["ay: sign reversed"]);
    assert!(reversed.contradictions().all(|row| row.factor == Some(-1.0)));
}
