//! Names, units and axes of layouts that a guess once took wrongly or not at all.

use crate::load::guesses::awkward_cases::{Instant, guess_of};
use crate::load::maps::by_hand::ManualChannelMap;
use crate::quantity::Role;

/// Channel, unit and sign of a role.
fn read(map: &ManualChannelMap, role: Role) -> Option<(&str, &str, bool)> {
    let row = map.row(role)?;
    Some((&row.from.channel, row.unit.map_or("", |unit| unit.symbol), row.turned))
}

/// Checks channel, unit and sign of roles.
fn check_rows(map: &ManualChannelMap, wanted: &[(Role, &str, &str, bool)]) {
    for &(role, channel, unit, turned) in wanted {
        assert_eq!(read(map, role), Some((channel, unit, turned)), "{}", role.name());
    }
}

/// Specific force in m/s², as an instant makes it.
fn force(now: &Instant) -> [f64; 3] {
    [9.806_65 * now.pitch.sin(), 0.02 * now.bank, -9.806_65 * now.pitch.cos() / now.bank.cos()]
}

const DEG: f64 = 180.0 / std::f64::consts::PI;

#[test]
fn french_test_names_with_d_for_degrees_are_read() {
    let head =
        "GX (g),GY (g),GZ (g),P (d/s),Q (d/s),R (d/s),PHI (d),TETA (d),PSI (d),VV (kt),ZP (ft),DM (d),DL (d),DN (d)";
    let map = guess_of(head, |now| {
        let [x, y, z] = force(now).map(|force| force / 9.806_65);
        let [p, q, r] = now.rates.map(|rate| rate * DEG);
        let angles = [now.bank * DEG, now.pitch * DEG, (now.heading * DEG).rem_euclid(360.0)];
        let t = now.time_s;
        let rest = [116.6, now.height / 0.3048, 2.0 * t.sin(), 3.0 * (1.3 * t).sin(), (0.7 * t).cos()];
        [x, y, -z, p, q, r].into_iter().chain(angles).chain(rest).collect()
    });
    check_rows(
        &map,
        &[
            (Role::SpecificForceX, "GX", "g", false),
            (Role::SpecificForceZ, "GZ", "g", true),
            (Role::RollRate, "P", "deg/s", false),
            (Role::PitchAngle, "TETA", "deg", false),
            (Role::TrueAirspeed, "VV", "kt", false),
            (Role::Aileron, "DL", "deg", false),
            (Role::Elevator, "DM", "deg", false),
            (Role::Rudder, "DN", "deg", false),
        ],
    );
}

#[test]
fn letters_of_gravity_and_of_magnetometers_are_no_forces() {
    let map = guess_of("gx,gy,gz,Bx,By,Bz,p (deg/s),phi (deg)", |now| {
        let [x, y, z] = force(now);
        vec![-x, -y, -z, 20.0, 5.0, 40.0, now.rates[0] * DEG, now.bank * DEG]
    });
    assert!(map.row(Role::SpecificForceX).is_none() && map.row(Role::SpecificForceZ).is_none(), "{:?}", map.rows);
}

#[test]
fn normal_acceleration_of_a_research_aircraft_is_up() {
    let map = guess_of("AX,AY,AN,P,Q,R,PHI,THETA,PSI,HP,PAMB (psf)", |now| {
        let [x, y, z] = force(now).map(|force| force / 9.806_65);
        let [p, q, r] = now.rates.map(|rate| rate * DEG);
        let pressure = 2116.2 * (1.0 - 2.255_77e-5 * now.height).powf(5.255_9);
        let angles = [now.bank * DEG, now.pitch * DEG, (now.heading * DEG).rem_euclid(360.0)];
        [x, y, -z, p, q, r].into_iter().chain(angles).chain([now.height / 0.3048, pressure]).collect()
    });
    assert_eq!(read(&map, Role::SpecificForceZ), Some(("AN", "g", true)));
    assert_eq!(read(&map, Role::SpecificForceX), Some(("AX", "g", false)));
    assert_eq!(read(&map, Role::Altitude), Some(("HP", "ft", false)), "the static pressure says feet");
}

#[test]
fn names_in_spanish_italian_and_german_are_read() {
    for (head, names) in [
        (
            "Factor de carga vertical (g),Rumbo verdadero (°),Altitud de presión (ft),Timón de dirección (°)",
            ["Factor de carga vertical", "Rumbo verdadero", "Altitud de presión", "Timón de dirección"],
        ),
        (
            "Fattore di carico normale [g],Angolo di prua [deg],Quota barometrica [ft],Timone [deg]",
            ["Fattore di carico normale", "Angolo di prua", "Quota barometrica", "Timone"],
        ),
        (
            "Normalbeschleunigung [g],Azimut [deg],Druckhöhe [ft],Seitenruder zeta [deg]",
            ["Normalbeschleunigung", "Azimut", "Druckhöhe", "Seitenruder zeta"],
        ),
    ] {
        let map = guess_of(head, |now| {
            let load = -force(now)[2] / 9.806_65;
            vec![load, (now.heading * DEG).rem_euclid(360.0), now.height / 0.3048, 2.0 * now.time_s.sin()]
        });
        let roles = [Role::SpecificForceZ, Role::HeadingAngle, Role::Altitude, Role::Rudder];
        let found = roles.map(|role| read(&map, role).map_or("", |(name, ..)| name));
        assert_eq!(found, names);
    }
}

#[test]
fn velocities_of_an_inertial_unit_behind_labels_are_read() {
    let head = "310_LAT_DEG,312_GROUND_SPEED_KT,313_TRUE_TRACK_DEG,365_INERTIAL_VERT_SPEED_FT_MIN,203_PRESS_ALT_FT";
    let map = guess_of(head, |now| {
        let [north, east, down] = now.speeds;
        let track = east.atan2(north) * DEG;
        vec![47.0, north.hypot(east) / 0.514_444, track, -down / 0.005_08, now.height / 0.3048]
    });
    assert_eq!(read(&map, Role::VelocityDown), Some(("365_INERTIAL_VERT_SPEED_FT_MIN", "ft/min", true)));
    let [speed, track] = map.velocity.unwrap();
    assert_eq!((&*speed.from.channel, &*track.from.channel), ("312_GROUND_SPEED_KT", "313_TRUE_TRACK_DEG"));
    let up = guess_of("GPS_VEL_E [m/s],GPS_VEL_N [m/s],GPS_VEL_U [m/s],Altitude [m]", |now| {
        let [north, east, down] = now.speeds;
        vec![east, north, -down, now.height]
    });
    assert_eq!(read(&up, Role::VelocityDown), Some(("GPS_VEL_U", "m/s", true)));
    // The vertical speed alone is found by the height.
    let alone = guess_of("INS_VZ [m/s],Altitude [m]", |now| vec![-now.speeds[2], now.height]);
    assert_eq!(read(&alone, Role::VelocityDown), Some(("INS_VZ", "m/s", true)));
}

#[test]
fn total_less_static_pressure_is_the_impact_pressure() {
    let map = guess_of("PS [inHg],PT [inHg],phi [deg]", |now| vec![25.0, 25.0 + 0.6, now.bank * DEG]);
    let row = map.row(Role::ImpactPressure).unwrap();
    let other = row.other_side.as_ref().unwrap();
    assert_eq!((&*row.from.channel, &*other.channel, other.sign, row.scale), ("PT", "PS", -1.0, 2.0));
    let beside = guess_of("PS [inHg],PT [inHg],TAS [kt]", |_| vec![25.0, 25.6, 116.0]);
    assert!(beside.row(Role::ImpactPressure).is_none(), "an airspeed is recorded");
}

#[test]
fn an_equivalent_airspeed_is_no_true_one_and_a_vane_in_volts_no_angle() {
    let map = guess_of("Equivalent airspeed [m/s],AOA vane [V],AOS vane (V),Flank angle [deg]", |now| {
        vec![50.0 + now.pitch, 2.5 + now.pitch, 2.5, now.bank]
    });
    assert!(map.row(Role::TrueAirspeed).is_none() && map.row(Role::AngleOfAttack).is_none());
    assert_eq!(read(&map, Role::EquivalentAirspeed), Some(("Equivalent airspeed", "m/s", false)));
    let beside = guess_of("KEAS,KCAS,phi [deg]", |now| vec![116.0, 117.0, now.bank * DEG]);
    assert!(beside.row(Role::EquivalentAirspeed).is_none(), "a calibrated airspeed is recorded");
    let alone = guess_of("KEAS,phi [deg]", |now| vec![116.0, now.bank * DEG]);
    assert_eq!(read(&alone, Role::EquivalentAirspeed), Some(("KEAS", "kt", false)));
    assert_eq!(read(&map, Role::Sideslip), Some(("Flank angle", "deg", false)));
    assert!(map.left_out.iter().any(|(from, why)| from.channel == "AOA vane" && why.starts_with("in V")));
}

#[test]
fn a_surface_position_beside_the_columns_is_the_deflection() {
    let map =
        guess_of("DE_COL [deg],DA_WHL [deg],DE_SRF [deg],DA_SRF [deg],Rudder Upper [deg],Rudder Lower [deg]", |now| {
            let wave = (1.3 * now.time_s).sin();
            vec![wave, 5.0 * wave, 2.0 * wave, 3.0 * wave, wave, wave]
        });
    let roles = [Role::Elevator, Role::Aileron, Role::Rudder];
    let found = roles.map(|role| read(&map, role).map_or("", |(name, ..)| name));
    assert_eq!(found, ["DE_SRF", "DA_SRF", "Rudder Upper"]);
}

#[test]
fn a_device_behind_a_signal_is_no_part_of_its_name_and_a_letter_of_tex_is() {
    let map = guess_of(r"FTI.Roll_rate\XCP:1 [deg/s],$\theta$ [deg],$\alpha$ [deg]", |now| {
        vec![now.rates[0] * DEG, now.pitch * DEG, now.pitch * DEG]
    });
    let roles = [Role::RollRate, Role::PitchAngle, Role::AngleOfAttack];
    let found = roles.map(|role| read(&map, role).map_or("", |(name, ..)| name));
    assert_eq!(found, [r"FTI.Roll_rate\XCP:1", r"$\theta$", r"$\alpha$"]);
}

#[test]
fn angles_in_the_order_yaw_pitch_roll_are_taken_in_that_order() {
    let head = "YawPitchRoll.X (deg),YawPitchRoll.Y (deg),YawPitchRoll.Z (deg)";
    let map = guess_of(head, |now| vec![now.heading * DEG, now.pitch * DEG, now.bank * DEG]);
    let found = [Role::HeadingAngle, Role::PitchAngle, Role::BankAngle].map(|role| read(&map, role));
    let named = ["YawPitchRoll.X", "YawPitchRoll.Y", "YawPitchRoll.Z"].map(|name| Some((name, "deg", false)));
    assert_eq!(found, named);
}

#[test]
fn psi_behind_euler_is_an_angle_and_north_behind_a_unit_belongs_to_it() {
    let map = guess_of("Euler_phi [deg],Euler_theta [deg],Euler_psi [deg],GS (kts),Track (deg T)", |now| {
        let [north, east, _] = now.speeds;
        let angles = [now.bank * DEG, now.pitch * DEG, (now.heading * DEG).rem_euclid(360.0)];
        let ground = [north.hypot(east) / 0.514_444, (east.atan2(north) * DEG).rem_euclid(360.0)];
        angles.into_iter().chain(ground).collect()
    });
    assert_eq!(read(&map, Role::HeadingAngle), Some(("Euler_psi", "deg", false)));
    let [speed, track] = map.velocity.unwrap();
    assert_eq!((&*speed.from.channel, &*track.from.channel), ("GS", "Track"));
}

#[test]
fn azimuth_and_yaw_rate_of_realflight_are_positive_to_the_left() {
    let head = "m-airspeed-MPS,m-altitudeASL-MTR,m-rollRate-DEGpSEC,m-yawRate-DEGpSEC,m-azimuth-DEG,m-inclination-DEG,m-roll-DEG,\
                m-aircraftPositionX-MTR,m-aircraftPositionY-MTR,m-velocityWorldU-MPS,m-velocityWorldV-MPS,m-velocityWorldW-MPS";
    let map = guess_of(head, |now| {
        let [north, east, down] = now.speeds;
        let air = [60.0, now.height, now.rates[0] * DEG, -now.rates[2] * DEG];
        let angles = [-now.heading * DEG, now.pitch * DEG, now.bank * DEG];
        let place = [east * now.time_s, north * now.time_s];
        air.into_iter().chain(angles).chain(place).chain([north, east, down]).collect()
    });
    check_rows(
        &map,
        &[
            (Role::TrueAirspeed, "m-airspeed-MPS", "m/s", false),
            (Role::YawRate, "m-yawRate-DEGpSEC", "deg/s", true),
            (Role::HeadingAngle, "m-azimuth-DEG", "deg", true),
            (Role::PositionNorth, "m-aircraftPositionY-MTR", "m", false),
            (Role::PositionDown, "m-altitudeASL-MTR", "m", true),
            (Role::VelocityEast, "m-velocityWorldV-MPS", "m/s", false),
        ],
    );
}

#[test]
fn units_of_a_recorder_go_before_ends_of_names() {
    let map = guess_of("LAT_GIN,LON_GIN,ROLL_GIN,PTCH_GIN,HDG_GIN,TAT_DI_R", |now| {
        let angles = [now.bank * DEG, now.pitch * DEG, (now.heading * DEG).rem_euclid(360.0)];
        [51.0 + 1e-5 * now.time_s, -1.0].into_iter().chain(angles).chain([281.0 + 0.01 * now.time_s]).collect()
    });
    assert_eq!(read(&map, Role::TotalTemperature), Some(("TAT_DI_R", "K", false)));
    assert_eq!(read(&map, Role::BankAngle), Some(("ROLL_GIN", "deg", false)));
}
