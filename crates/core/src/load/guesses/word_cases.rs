//! Words beside a name, vectors with a part of another name, and units that one channel gives another.

use crate::load::guesses::awkward_cases::guess_of;
use crate::load::maps::by_hand::ManualChannelMap;
use crate::quantity::Role;

const DEG: f64 = 180.0 / std::f64::consts::PI;

/// Channel and unit of a role.
fn read(map: &ManualChannelMap, role: Role) -> Option<(&str, &str)> {
    let row = map.row(role)?;
    Some((&row.from.channel, row.unit.map_or("", |unit| unit.symbol)))
}

#[test]
fn rates_named_by_axis_are_no_angles() {
    let map = guess_of("gyro_roll,gyro_pitch,gyro_yaw,input_roll,phi [deg]", |now| {
        let [p, q, r] = now.rates.map(|rate| rate * DEG);
        vec![p, q, r, now.bank, now.bank * DEG]
    });
    assert_eq!(read(&map, Role::RollRate), Some(("gyro_roll", "deg/s")));
    assert_eq!(read(&map, Role::YawRate), Some(("gyro_yaw", "deg/s")));
    assert_eq!(read(&map, Role::BankAngle), Some(("phi", "deg")));
    assert!(map.row(Role::PitchAngle).is_none() && map.row(Role::HeadingAngle).is_none());
    let stated = guess_of("roll [deg/s],pitch [deg/s],yaw [deg/s]", |now| now.rates.map(|rate| rate * DEG).to_vec());
    assert_eq!(read(&stated, Role::PitchRate), Some(("pitch", "deg/s")));
}

#[test]
fn velocities_and_accelerations_are_no_places() {
    let map = guess_of("vnVelNedNorth,vnVelNedEast,vnVelNedDown,vnAccelLat [m/s^2]", |now| {
        let [north, east, down] = now.speeds;
        vec![north, east, down, 0.1 * now.bank]
    });
    assert_eq!(read(&map, Role::VelocityEast).map(|row| row.0), Some("vnVelNedEast"));
    assert_eq!(read(&map, Role::SpecificForceY).map(|row| row.0), Some("vnAccelLat"));
    assert!(map.row(Role::PositionNorth).is_none() && map.row(Role::Latitude).is_none());
}

#[test]
fn a_climb_is_the_third_part_of_a_velocity_and_an_altitude_that_of_a_place() {
    let map = guess_of("vx [m/s],vy [m/s],climb [m/s],x [m],y [m],altitude [m]", |now| {
        let [north, east, down] = now.speeds;
        vec![north, east, -down, north * now.time_s, east * now.time_s, now.height]
    });
    let found = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown, Role::PositionNorth, Role::PositionEast]
        .map(|role| read(&map, role).map_or("", |row| row.0));
    assert_eq!(found, ["vx", "vy", "climb", "x", "y"]);
    let body = guess_of("body_velocity_x [m/s],body_velocity_y [m/s],body_velocity_z [m/s]", |_| vec![40.0, 0.5, 2.0]);
    assert!(body.row(Role::VelocityNorth).is_none(), "{:?}", body.rows);
}

#[test]
fn uncertainties_beside_their_quantities_are_no_velocities() {
    let map = guess_of("ROLL,PITCH,YAW,VX,VY,VZ,ROLL_U,PITCH_U,YAW_U,VEL_U", |now| {
        let ([north, east, down], angles) = (now.speeds, [now.bank, now.pitch, now.heading].map(|angle| angle * DEG));
        [angles.to_vec(), vec![north, east, down], vec![0.1, 0.1, 0.2, 1.2]].concat()
    });
    assert_eq!(read(&map, Role::VelocityDown), Some(("VZ", "m/s")));
    assert_eq!(read(&map, Role::BankAngle), Some(("ROLL", "deg")));
}

#[test]
fn a_rate_of_change_beside_those_of_other_rates_is_no_rudder() {
    let of = |head| guess_of(head, |now| vec![0.2 * now.bank, 0.1 * now.pitch, 0.1 * now.bank]);
    assert!(of("dp,dq,dr").row(Role::Rudder).is_none());
    assert_eq!(read(&of("da,de,dr"), Role::Rudder).map(|row| row.0), Some("dr"));
}

#[test]
fn a_compass_in_degrees_says_nothing_of_attitude_in_radians() {
    let compass =
        guess_of("roll,pitch,heading", |now| vec![now.bank, now.pitch, (now.heading * DEG).rem_euclid(360.0)]);
    let row = compass.row(Role::BankAngle).unwrap();
    assert!(!row.is_unit_known, "asked: {row:?}");
    let whole = guess_of("roll,pitch,yaw", |now| [now.bank, now.pitch, now.heading].map(|angle| angle * DEG).to_vec());
    assert_eq!(read(&whole, Role::BankAngle), Some(("roll", "deg")));
}

#[test]
fn of_two_load_factors_the_one_near_one_is_normal() {
    let map = guess_of("Nx,Ny,Nz,phi [deg]", |now| vec![0.1, now.pitch.cos() / now.bank.cos(), 0.02, now.bank * DEG]);
    assert_eq!(read(&map, Role::SpecificForceZ), Some(("Ny", "g")));
    assert!(map.row(Role::SpecificForceZ).unwrap().turned, "up is positive");
    assert_eq!(read(&map, Role::SpecificForceY).map(|row| row.0), Some("Nz"));
}

#[test]
fn a_mach_number_gives_the_unit_of_the_airspeed_beside_it() {
    let map = guess_of("TAS,IAS,Mach", |now| {
        let mach = 0.55 + 0.02 * now.pitch;
        vec![631.0 * mach, 500.0 * mach, mach]
    });
    let [air, calibrated] = [Role::TrueAirspeed, Role::CalibratedAirspeed].map(|role| map.row(role).unwrap());
    assert_eq!((air.unit.map(|unit| unit.symbol), air.is_unit_known), (Some("kt"), true));
    assert_eq!((calibrated.unit.map(|unit| unit.symbol), calibrated.is_unit_known), (Some("kt"), false));
}

#[test]
fn a_climb_of_another_name_keeps_its_unit_beside_speeds_in_centimetres() {
    let map = guess_of("lat [deg],lon [deg],vx,vy,ClimbSpeed,Altitude [m]", |now| {
        let [north, east, down] = now.speeds;
        let (x, y) = (north * now.time_s / 111_195.0, east * now.time_s / 111_195.0);
        vec![1.0 + x, 1.0 + y, 100.0 * north, 100.0 * east, -down, now.height]
    });
    let scale = |role: Role| map.row(role).map(|row| row.scale);
    assert_eq!(scale(Role::VelocityDown), Some(1.0));
}

#[test]
fn forces_are_taken_elsewhere_where_those_named_first_hold_no_gravity() {
    let map = guess_of("ax [m/s^2],ay [m/s^2],az [m/s^2],imu_accel_x,imu_accel_y,imu_accel_z", |now| {
        let (up, along) = (9.806_65 * now.pitch.cos() / now.bank.cos(), 9.806_65 * now.pitch.sin());
        vec![0.1 * now.pitch, 0.1 * now.bank, 0.01, along, 0.02, -up]
    });
    let found = [Role::SpecificForceX, Role::SpecificForceZ].map(|role| read(&map, role).map_or("", |row| row.0));
    assert_eq!(found, ["imu_accel_x", "imu_accel_z"]);
}

#[test]
fn what_only_ends_on_a_name_or_is_a_part_of_the_full_one_plays_no_role() {
    let head = "PeakAlt [m],CN_delta_r,baro_alpha,pitot_press [Pa],thrust,phi [deg]";
    let map = guess_of(head, |now| vec![now.height, -0.1, 0.02, 900.0, 0.5 + 0.2 * now.pitch, now.bank * DEG]);
    for role in [Role::Altitude, Role::Rudder, Role::AngleOfAttack, Role::StaticPressure, Role::Thrust1] {
        assert!(map.row(role).is_none(), "{}: {:?}", role.name(), map.row(role));
    }
}

#[test]
fn ele_is_the_elevator_beside_the_other_controls_and_a_height_beside_fixes() {
    let wave = |time_s: f64| 0.1 * (1.3 * time_s).sin();
    let controls = guess_of("ail [deg],ele [deg],rud [deg]", |now| vec![wave(now.time_s); 3]);
    assert_eq!(read(&controls, Role::Elevator).map(|row| row.0), Some("ele"));
    let fixes = guess_of("lat [deg],lon [deg],ele [m]", |now| vec![52.0 + 1e-5 * now.time_s, 4.0, now.height]);
    assert_eq!(read(&fixes, Role::GpsAltitude), Some(("ele", "m")));
}
