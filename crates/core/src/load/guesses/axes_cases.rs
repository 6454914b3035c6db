//! Recordings in axes that are not forward, right and down, or not north, east and down, each as small as it can be.

use crate::load::guesses::awkward_cases::{DEGREE, Instant, guess_of, row_of};
use crate::load::guesses::guess::guess;
use crate::load::maps::by_hand::ManualChannelMap;
use crate::load::probe_of;
use crate::quantity::Role;

const FORCES: [Role; 3] = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
const RATES: [Role; 3] = [Role::RollRate, Role::PitchRate, Role::YawRate];

/// Specific forces of the flight, m/s², `V' + omega x V - g` with an angle of attack of 0.05 rad at 60 m/s.
fn forces(now: &Instant) -> [f64; 3] {
    const G: f64 = 9.806_65;
    let (u, w) = (60.0 * 0.05_f64.cos(), 60.0 * 0.05_f64.sin());
    let [p, q, r] = now.rates;
    let (theta, phi) = (now.pitch, now.bank);
    [q * w + G * theta.sin(), r * u - p * w - G * theta.cos() * phi.sin(), -q * u - G * theta.cos() * phi.cos()]
}

/// Sign of a role, and whether it is asked for.
fn sign_of(map: &ManualChannelMap, role: Role) -> Option<(f64, bool)> {
    row_of(map, role).map(|(_, sign, asks)| (sign, asks))
}

/// The flight with forces in g and rates in degrees per second, each times its sign.
fn signed(names: [&str; 3], forward: impl Fn(&Instant) -> f64, signs: [f64; 5]) -> ManualChannelMap {
    let head = "Roll rate [deg/s],Pitch rate [deg/s],Yaw rate [deg/s],Roll [deg],Pitch [deg],Heading [deg],\
                V north [m/s],V east [m/s],V down [m/s],Altitude [m],TAS [m/s]";
    guess_of(&format!("{},{head}", names.join(",")), |now| {
        let [_, y, z] = forces(now).map(|force| force / 9.806_65);
        let [p, q, r] = now.rates.map(|rate| rate / DEGREE);
        let [phi, theta, psi] = [now.bank, now.pitch, now.heading].map(|angle| angle / DEGREE);
        let of_body = [signs[0] * forward(now) / 9.806_65, signs[1] * y, signs[2] * z, p, signs[3] * q, signs[4] * r];
        [&of_body[..], &[phi, theta, psi], &now.speeds, &[now.height, 60.0]].concat()
    })
}

const ACCELEROMETER: [&str; 3] = ["Acc X (g)", "Acc Y (g)", "Acc Z (g)"];

#[test]
fn accelerometer_that_gives_the_reaction_to_gravity_is_turned_along_all_axes() {
    let reversed = [-1.0, -1.0, -1.0, 1.0, 1.0];
    let map = signed(ACCELEROMETER, |now| forces(now)[0], reversed);
    for role in FORCES {
        assert_eq!(sign_of(&map, role), Some((-1.0, false)), "{}", role.name());
    }
    for role in RATES {
        assert_eq!(sign_of(&map, role), Some((1.0, false)), "{}", role.name());
    }
    // A force along x that says nothing is turned with the others, and both are asked for.
    let map = signed(ACCELEROMETER, |now| 0.1 + 1e-3 * (7.3 * now.time_s).sin(), reversed);
    for (role, wanted) in FORCES.into_iter().zip([(-1.0, true), (-1.0, true), (-1.0, false)]) {
        assert_eq!(sign_of(&map, role), Some(wanted), "{}", role.name());
    }
}

#[test]
fn force_along_x_that_speed_and_pitch_make_is_not_turned_with_the_one_along_z() {
    let map = signed(ACCELEROMETER, |now| forces(now)[0], [1.0, 1.0, -1.0, 1.0, 1.0]);
    for (role, wanted) in FORCES.into_iter().zip([(1.0, false), (1.0, true), (-1.0, false)]) {
        assert_eq!(sign_of(&map, role), Some(wanted), "{}", role.name());
    }
}

#[test]
fn forces_of_two_sensors_are_asked_for_where_one_is_upwards() {
    let map = signed(["Acc X (g)", "Acc Y (g)", "IMU Acc Z (g)"], |now| forces(now)[0], [-1.0, -1.0, -1.0, 1.0, 1.0]);
    for (role, wanted) in FORCES.into_iter().zip([(1.0, true), (1.0, true), (-1.0, false)]) {
        assert_eq!(sign_of(&map, role), Some(wanted), "{}", role.name());
    }
}

#[test]
fn axes_forward_left_and_up_are_known_by_named_rates_that_the_attitude_turns() {
    let map = signed(ACCELEROMETER, |now| forces(now)[0], [1.0, -1.0, -1.0, -1.0, -1.0]);
    for (role, wanted) in FORCES.into_iter().zip([1.0, -1.0, -1.0]) {
        assert_eq!(sign_of(&map, role), Some((wanted, false)), "{}", role.name());
    }
    for (role, wanted) in RATES.into_iter().zip([1.0, -1.0, -1.0]) {
        assert_eq!(sign_of(&map, role), Some((wanted, false)), "{}", role.name());
    }
}

/// A flight to the north-east that hardly turns, whose receiver writes every tenth row, in axes of velocity given by `axes`.
fn straight(axes: impl Fn([f64; 3]) -> [f64; 3]) -> ManualChannelMap {
    let mut text =
        "time,Roll [deg],Pitch [deg],Heading [deg],Yaw rate [deg/s],Altitude [m],TAS [m/s],Latitude [deg],Longitude [deg],vx,vy,vz\n"
            .to_owned();
    let (mut north, mut east, mut height) = (0.0_f64, 0.0_f64, 1200.0_f64);
    for k in 0..4000_u32 {
        let t = 0.02 * f64::from(k);
        let heading = 40.0 + 4.0 * (0.6 * t).sin();
        let (bank, pitch) = (2.0 * (0.6 * t).cos(), 0.7 + (0.3 * t).sin());
        let climb = 58.0 * (DEGREE * (pitch - 0.7)).sin();
        let speeds = [58.0 * (DEGREE * heading).cos() + 1.0, 58.0 * (DEGREE * heading).sin() + 2.0, -climb];
        text += &format!(
            "{t:.2},{bank:.4},{pitch:.4},{heading:.4},{:.4},{:.1},58.0",
            2.4 * (0.6 * t).cos(),
            height + 0.3 * (31.0 * t).sin()
        );
        if k % 10 == 0 {
            let [x, y, z] = axes(speeds);
            let (latitude, longitude) = (47.0 + north / 111_194.9, 8.0 + east / 75_834.0);
            text += &format!(",{latitude:.7},{longitude:.7},{x:.2},{y:.2},{z:.2}\n");
        } else {
            text += ",,,,,\n";
        }
        (north, east, height) = (north + 0.02 * speeds[0], east + 0.02 * speeds[1], height - 0.02 * speeds[2]);
    }
    guess(&[probe_of(&text)])
}

#[test]
fn straight_flight_says_by_its_speeds_which_axis_is_north() {
    for (name, axes, wanted) in [
        ("east, north, up", [1, 0, 2], [("vy", 1.0), ("vx", 1.0), ("vz", -1.0)]),
        ("north, east, down", [0, 1, 2], [("vx", 1.0), ("vy", 1.0), ("vz", 1.0)]),
        ("north, west, up", [0, 1, 2], [("vx", 1.0), ("vy", -1.0), ("vz", -1.0)]),
    ] {
        let signs = wanted.map(|(_, sign)| sign);
        let map = straight(|speeds| {
            let signed = [speeds[0] * signs[0], speeds[1] * signs[1], speeds[2] * signs[2]];
            axes.map(|axis| signed[axis])
        });
        for (role, wanted) in [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown].into_iter().zip(wanted) {
            let row = map.row(role).map(|row| (row.from.channel.as_str(), if row.turned { -1.0 } else { 1.0 }));
            assert_eq!(row, Some(wanted), "{name}: {}", role.name());
        }
        for role in [Role::HeadingAngle, Role::YawRate] {
            assert_eq!(sign_of(&map, role), Some((1.0, false)), "{name}: {}", role.name());
        }
        assert_eq!(map.row(Role::HeadingAngle).map(|row| row.offset), Some(0.0), "{name}");
    }
}

#[test]
fn velocity_up_and_load_factor_less_one_are_turned() {
    let map = guess_of("Ve [m/s],Vn [m/s],Vu [m/s],Nz-1 [g]", |now| {
        let [north, east, down] = now.speeds;
        vec![east, north, -down, -forces(now)[2] / 9.806_65 - 1.0]
    });
    assert_eq!(row_of(&map, Role::VelocityDown), Some(("m/s", -1.0, false)));
    assert_eq!(map.row(Role::VelocityDown).map(|row| row.from.channel.as_str()), Some("Vu"));
    let down = map.row(Role::SpecificForceZ).map(|row| (row.turned, row.offset, row.unit.map(|unit| unit.symbol)));
    assert_eq!(down, Some((true, 1.0, Some("g"))));
    let alone = guess_of("Vu [m/s],Roll [deg]", |now| vec![-now.speeds[2], now.bank / DEGREE]);
    assert!(alone.row(Role::VelocityDown).is_none());
}

#[test]
fn breadth_and_length_in_german_degrees_are_latitude_and_longitude() {
    let row = |k: u32| format!("{:.1};{:.6};{:.6};{}\n", 0.1 * f64::from(k), 47.0 + 1e-5 * f64::from(k), 8.0, k % 9);
    let rows: String = (0..60).map(row).collect();
    for (head, wanted) in [
        ("Breite [Grad];Länge [Grad];Rollrate [Grad/s]", Some(("deg", 1.0, false))),
        ("Breite;Laenge;Rollrate [Grad/s]", Some(("deg", 1.0, false))),
        ("Breite [m];Länge [m];Rollrate [Grad/s]", None),
        ("Breite;Dicke;Rollrate [Grad/s]", None),
    ] {
        let map = guess(&[probe_of(&format!("Zeit [s];{head}\n{rows}"))]);
        assert_eq!(row_of(&map, Role::Latitude), wanted, "{head}");
        assert_eq!(row_of(&map, Role::Longitude).is_some(), wanted.is_some(), "{head}");
        assert_eq!(row_of(&map, Role::RollRate).map(|row| row.0), Some("deg/s"), "{head}");
    }
}
