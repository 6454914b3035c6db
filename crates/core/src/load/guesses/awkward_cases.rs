//! Recordings that a guess once took wrongly, each as small as it can be.

use crate::load::guesses::guess::guess;
use crate::load::maps::by_hand::{By, ManualChannelMap};
use crate::load::probe_of;
use crate::quantity::Role;

/// Rows of a flight at 60 m/s in which the bank turns the heading, the pitch makes the climb, the attitude the rates.
pub(super) struct Instant {
    pub(super) time_s: f64,
    pub(super) bank: f64,
    pub(super) pitch: f64,
    pub(super) heading: f64,
    pub(super) rates: [f64; 3],
    north: f64,
    east: f64,
    pub(super) speeds: [f64; 3],
    pub(super) height: f64,
}

fn flight() -> Vec<Instant> {
    const STEP_S: f64 = 0.05;
    const SPEED: f64 = 60.0;
    let (mut heading, mut north, mut east, mut height): (f64, f64, f64, f64) = (0.8, 0.0, 0.0, 1200.0);
    let instant = |k: u32| {
        let t = STEP_S * f64::from(k);
        let (bank, pitch) = (0.5 * (0.31 * t).sin(), 0.05 + 0.06 * (0.83 * t).sin());
        let (rolling, pitching) = (0.155 * (0.31 * t).cos(), 0.0498 * (0.83 * t).cos());
        let turning = 9.806_65 / SPEED * f64::tan(bank);
        let rates = [
            rolling - pitch.sin() * turning,
            bank.cos() * pitching + bank.sin() * pitch.cos() * turning,
            bank.cos() * pitch.cos() * turning - bank.sin() * pitching,
        ];
        let climb = SPEED * (pitch - 0.05).sin();
        let level = (SPEED * SPEED - climb * climb).sqrt();
        let speeds = [level * heading.cos(), level * heading.sin(), -climb];
        let now = Instant { time_s: t, bank, pitch, heading, rates, north, east, speeds, height };
        heading += STEP_S * turning;
        (north, east, height) = (north + STEP_S * speeds[0], east + STEP_S * speeds[1], height + STEP_S * climb);
        now
    };
    (0..1200).map(instant).collect()
}

/// The guess of a table of the flight.
pub(super) fn guess_of(head: &str, row: impl Fn(&Instant) -> Vec<f64>) -> ManualChannelMap {
    guess(&[probe_of(&table(head, row))])
}

/// A table of the flight.
fn table(head: &str, row: impl Fn(&Instant) -> Vec<f64>) -> String {
    let line = |now: &Instant| {
        let cells: Vec<String> = row(now).iter().map(|cell| format!("{cell:.7}")).collect();
        format!("{:.2},{}\n", now.time_s, cells.join(","))
    };
    format!("time,{head}\n{}", flight().iter().map(line).collect::<String>())
}

/// Unit and sign of a role, and whether they are asked for.
pub(super) fn row_of(map: &ManualChannelMap, role: Role) -> Option<(&'static str, f64, bool)> {
    let row = map.row(role)?;
    Some((row.unit?.symbol, if row.turned { -1.0 } else { 1.0 }, row.asks_sign))
}

pub(super) const DEGREE: f64 = std::f64::consts::PI / 180.0;

#[test]
fn parts_of_names_are_no_roles() {
    let map = guess_of("bias,pre_flt_fail,fault_roll,column[11],accel_bias[0],accel_bias[1],accel_bias[2]", |now| {
        vec![now.pitch, 0.0, 1.0, 7.0, 0.1, 0.2, now.bank]
    });
    assert_eq!(map.rows, []);
}

#[test]
fn units_in_names_and_brackets_are_read() {
    let map = guess_of("Az [ft/s2],TAS [kt],alt_ft,ps [inHg],theta [rad],IAS (knots)", |now| {
        vec![-32.2, 117.0, now.height / 0.3048, 26.0, now.pitch, 110.0]
    });
    for (role, unit) in [
        (Role::SpecificForceZ, "ft/s^2"),
        (Role::TrueAirspeed, "kt"),
        (Role::Altitude, "ft"),
        (Role::StaticPressure, "inHg"),
        (Role::PitchAngle, "rad"),
        (Role::CalibratedAirspeed, "kt"),
    ] {
        assert_eq!(row_of(&map, role).map(|row| row.0), Some(unit), "{}", role.name());
    }
}

#[test]
fn names_of_quick_access_recorders_and_units_within_names_are_known() {
    let map = guess_of("PTCHRATE,HDGT,LATG,LONG,VRTG,KTAS,FL,QC_HPA", |now| {
        vec![now.rates[1], now.heading / DEGREE, 0.01, 0.05, 1.0, 117.0, now.height / 30.48, 36.0]
    });
    for (role, unit) in [
        (Role::PitchRate, "rad/s"),
        (Role::HeadingAngle, "deg"),
        (Role::SpecificForceX, "g"),
        (Role::SpecificForceY, "g"),
        (Role::SpecificForceZ, "g"),
        (Role::TrueAirspeed, "kt"),
        (Role::Altitude, "FL"),
    ] {
        assert_eq!(row_of(&map, role).map(|row| row.0), Some(unit), "{}", role.name());
    }
    // Beside an airspeed it plays no role.
    assert!(map.row(Role::ImpactPressure).is_none());
    let map = guess_of("LONG,QC_HPA,alt_m", |now| vec![2.35, 36.0, now.height]);
    assert_eq!(row_of(&map, Role::ImpactPressure).map(|row| row.0), Some("hPa"));
    assert!(map.row(Role::SpecificForceX).is_none());
}

#[test]
fn heights_in_kilometres_are_found_by_the_climb() {
    let map = guess_of("vd [m/s],altitude", |now| vec![now.speeds[2], now.height / 1000.0]);
    assert_eq!(row_of(&map, Role::Altitude).map(|row| row.0), Some("km"));
}

#[test]
fn longitude_of_western_europe_is_in_the_unit_of_its_latitude() {
    let map = guess_of("lat,lon", |now| vec![48.7 + now.north / 111_000.0, 2.35 + now.east / 73_000.0]);
    assert_eq!([Role::Latitude, Role::Longitude].map(|role| row_of(&map, role).map(|row| row.0)), [Some("deg"); 2]);
}

#[test]
fn rates_take_their_unit_and_sign_from_the_attitude() {
    let map = guess_of("roll_deg,pitch_deg,yaw_deg,gyro_x,gyro_y,gyro_z,alt_m,TAS [m/s]", |now| {
        let [p, q, r] = now.rates.map(|rate| rate / DEGREE);
        vec![now.bank / DEGREE, now.pitch / DEGREE, now.heading / DEGREE, p, -q, -r, now.height, 60.0]
    });
    for (role, sign) in [(Role::RollRate, 1.0), (Role::PitchRate, -1.0), (Role::YawRate, -1.0)] {
        assert_eq!(row_of(&map, role), Some(("deg/s", sign, false)), "{}", role.name());
        assert!(map.row(role).is_some_and(|row| row.is_unit_known));
    }
}

#[test]
fn bank_to_the_left_is_turned_by_the_track_where_the_heading_swings_with_the_sideslip() {
    let map = guess_of("p [deg/s],Roll [deg],Pitch [deg],Heading [deg],TAS [m/s],vN [m/s],vE [m/s]", |now| {
        let [north, east, _] = now.speeds;
        let swing = 0.15 * (5.0 * now.time_s).sin();
        let [p, bank, pitch, heading] =
            [now.rates[0], -now.bank, now.pitch, now.heading + swing].map(|angle| angle / DEGREE);
        vec![p, bank, pitch, heading, 60.0, north, east]
    });
    for (role, unit, sign) in [(Role::BankAngle, "deg", -1.0), (Role::RollRate, "deg/s", 1.0)] {
        assert_eq!(row_of(&map, role), Some((unit, sign, false)), "{}", role.name());
    }
}

#[test]
fn one_side_of_a_surface_is_read_behind_the_name_of_its_recorder() {
    let head = "pos.elev_left_deg,pos.elev_right_deg,pos.ail_left_deg,pos.ail_right_deg,pos.rudder_deg";
    let map =
        guess_of(head, |now| [now.pitch, now.pitch, now.bank, -now.bank, 0.1 * now.bank].map(|x| 30.0 * x).into());
    for (role, name) in
        [(Role::Elevator, "pos.elev_left_deg"), (Role::Aileron, "pos.ail_right_deg"), (Role::Rudder, "pos.rudder_deg")]
    {
        assert_eq!(map.row(role).map(|row| row.from.channel.as_str()), Some(name), "{}", role.name());
        assert_eq!(row_of(&map, role).map(|row| row.1), Some(1.0), "{}", role.name());
    }
}

#[test]
fn pitch_and_bank_of_a_simulator_that_turns_them_are_turned_by_climb_and_heading() {
    let map = guess_of("Pitch [deg],Bank [deg],Heading [deg],Altitude [ft],TAS [kt],vN [m/s],vE [m/s]", |now| {
        let [north, east, _] = now.speeds;
        let angles = [-now.pitch, -now.bank, now.heading].map(|angle| angle / DEGREE);
        [&angles[..], &[now.height / 0.3048, 116.6, north, east]].concat()
    });
    for (role, sign) in [(Role::PitchAngle, -1.0), (Role::BankAngle, -1.0), (Role::HeadingAngle, 1.0)] {
        assert_eq!(row_of(&map, role), Some(("deg", sign, false)), "{}", role.name());
    }
}

#[test]
fn heights_and_climbs_without_a_unit_are_in_feet_and_feet_per_minute_by_their_ratio() {
    let map =
        guess_of("alt,vs,roll", |now| vec![now.height / 0.3048, -now.speeds[2] / 0.3048 * 60.0, now.bank / DEGREE]);
    assert_eq!(row_of(&map, Role::Altitude), Some(("ft", 1.0, false)));
    assert_eq!(row_of(&map, Role::VelocityDown), Some(("ft/min", -1.0, false)));
}

#[test]
fn velocities_by_axes_are_north_and_east_as_latitude_and_longitude_say() {
    let map = guess_of("lat,lon,alt,vel_x,vel_y,vel_z", |now| {
        let [north, east, down] = now.speeds;
        vec![48.7 + now.north / 111_194.9, 2.35 + now.east / 73_388.0, now.height, east, north, -down]
    });
    for (role, name, sign) in
        [(Role::VelocityNorth, "vel_y", 1.0), (Role::VelocityEast, "vel_x", 1.0), (Role::VelocityDown, "vel_z", -1.0)]
    {
        let row = map.row(role).map(|row| (row.from.channel.as_str(), if row.turned { -1.0 } else { 1.0 }));
        assert_eq!(row, Some((name, sign)), "{}", role.name());
    }
}

#[test]
fn heading_of_a_receiver_is_its_track() {
    let map = guess_of("lat,lon,velN,velE,velD,heading", |now| {
        let [north, east, down] = now.speeds;
        vec![48.7, 2.35, north, east, down, (east.atan2(north) / DEGREE).rem_euclid(360.0)]
    });
    assert!(map.row(Role::HeadingAngle).is_none());
    assert!(map.left_out.iter().any(|(from, why)| from.channel == "heading" && why.contains("velocity")));
}

#[test]
fn forces_and_accelerations_without_gravity_are_no_specific_forces() {
    for size in [1.0, 5000.0] {
        let map =
            guess_of("fx,fy,fz,mx,my,mz", |now| vec![size * now.pitch, size * now.bank, 5.0 * size, 0.0, 1.0, 2.0]);
        assert!(map.row(Role::SpecificForceZ).is_none(), "{size}");
    }
}

#[test]
fn sensor_with_its_axes_up_is_turned_and_asked_for_where_no_attitude_says_it() {
    let map = guess_of("acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", |now| {
        let [p, q, r] = now.rates;
        vec![0.3, 0.1 * now.bank, 9.81, p, -q, -r]
    });
    for role in [Role::SpecificForceY, Role::PitchRate, Role::YawRate] {
        assert_eq!(row_of(&map, role).map(|row| (row.1, row.2)), Some((-1.0, true)), "{}", role.name());
    }
    assert_eq!(row_of(&map, Role::SpecificForceZ).map(|row| (row.1, row.2)), Some((-1.0, false)));
    assert!(map.rows.iter().all(|(_, row)| row.by != By::Recorder));
}

#[test]
fn side_of_a_sensor_with_its_axes_up_is_asked_for_where_the_rates_have_names_of_their_own() {
    for head in
        ["X_Accel,Y_Accel,Z_Accel,RollRate,PitchRate,YawRate", "acc_x,acc_y,acc_z,p,q,r", "accX,accY,accZ,p,q,r"]
    {
        let map = guess_of(head, |now| {
            let [p, q, r] = now.rates;
            vec![0.3, -0.1 * now.bank, 9.81, p, q, r]
        });
        assert_eq!(row_of(&map, Role::SpecificForceY).map(|row| row.2), Some(true), "{head}");
        assert_eq!(row_of(&map, Role::SpecificForceZ).map(|row| (row.1, row.2)), Some((-1.0, false)), "{head}");
    }
}

#[test]
fn sensor_with_its_axes_up_whose_attitude_goes_with_it_is_asked_for() {
    let map = guess_of("acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,roll,pitch,yaw", |now| {
        let [p, q, r] = now.rates;
        vec![0.3, 0.1 * now.bank, 9.81, p, -q, -r, now.bank / DEGREE, -now.pitch / DEGREE, -now.heading / DEGREE]
    });
    for role in [Role::SpecificForceY, Role::PitchRate, Role::YawRate, Role::PitchAngle, Role::HeadingAngle] {
        assert_eq!(row_of(&map, role).map(|row| row.2), Some(true), "{}", role.name());
    }
    assert_eq!(row_of(&map, Role::BankAngle).map(|row| row.2), Some(false));
}

#[test]
fn names_of_flight_recorders_are_the_quantities_that_they_mean() {
    let head = "PB [deg/s],QB [deg/s],RB [deg/s],roll [deg],pitch [deg],Engine RPM,GPS Heading [deg],Total Air Temp [degC],\
                Baro Setting [inHg],LateralAcc [g],VerticalAcc [g],GPS LatAcc [g],AltP [ft],AltInd [ft]";
    let map = guess_of(head, |now| {
        let [p, q, r] = now.rates.map(|rate| rate / DEGREE);
        let feet = now.height / 0.3048;
        let (bank, pitch) = (now.bank / DEGREE, now.pitch / DEGREE);
        vec![
            p,
            q,
            r,
            bank,
            pitch,
            2400.0 + p,
            10.0 * now.time_s,
            8.0,
            29.92,
            0.01 * p,
            1.0,
            0.02 * p,
            feet,
            feet + 90.0,
        ]
    });
    let channel = |role| map.row(role).map(|row| row.from.channel.as_str());
    for (role, wanted) in [
        (Role::RollRate, Some("PB")),
        (Role::PitchRate, Some("QB")),
        (Role::YawRate, Some("RB")),
        (Role::EngineSpeed1, Some("Engine RPM")),
        (Role::HeadingAngle, None),
        (Role::TotalTemperature, Some("Total Air Temp")),
        (Role::AirTemperature, None),
        (Role::StaticPressure, None),
        (Role::SpecificForceY, Some("LateralAcc")),
        (Role::Altitude, Some("AltP")),
    ] {
        assert_eq!(channel(role), wanted, "{}", role.name());
    }
}

#[test]
fn engine_speed_of_a_hundred_at_most_is_per_cent() {
    let map = guess_of("engine_rpm,roll [deg]", |now| vec![85.0 + now.pitch, now.bank / DEGREE]);
    assert!(map.row(Role::EngineSpeed1).is_none());
    assert!(map.left_out.iter().any(|(from, why)| from.channel == "engine_rpm" && why.contains("per cent")));
}

#[test]
fn what_hovers_and_what_climbs_like_a_rocket_is_no_aeroplane() {
    let hover = guess_of("pos_n,pos_e,pos_d,v_n,v_e,v_d", |now| {
        vec![now.pitch, now.bank, -20.0 * (0.1 * now.time_s).min(1.0), 0.3, 0.4 * now.bank, 0.0]
    });
    assert!(hover.kind.is_some_and(|kind| kind.contains("hovers")));
    let rocket = guess_of("altitude [m],pressure [hPa]", |now| {
        let height = 1000.0 * (1.0 - (now.time_s / 12.0 - 1.0).powi(2)).max(0.0);
        vec![height, 1013.0 * (1.0 - height / 44_330.0).powf(5.255)]
    });
    assert_eq!(rocket.kind.as_deref(), Some("rocket"));
    let aeroplane = guess_of("pos_n,pos_e,pos_d,v_n,v_e,v_d", |now| {
        vec![now.north, now.east, -now.height, now.speeds[0], now.speeds[1], now.speeds[2]]
    });
    assert_eq!(aeroplane.kind, None);
}

#[test]
fn seconds_since_1970_may_be_called_unix_time() {
    let row = |k: u32| format!("{:.3},{}\n", 1_795_860_930.0 + 0.1 * f64::from(k), 120 + k);
    let rows: String = (0..40).map(row).collect();
    let probe = probe_of(&format!("timestamp,altitude\nunix time,m\n{rows}"));
    assert_eq!(probe.sources[0].clocks.first().map(|clock| clock.rate_hz.round()), Some(10.0));
}

/// Roles of a table of three channels, the first of this name, by the channels that play them.
fn roles_of(name: &str, values: [f64; 3]) -> Vec<(Role, bool)> {
    let [a, b, c] = values;
    let map = guess(&[probe_of(&format!("time,{name},note\n0.0,{a},1\n0.1,{b},1\n0.2,{c},1\n"))]);
    map.rows.iter().map(|(role, row)| (*role, row.turned)).collect()
}

#[test]
fn names_of_other_languages_and_short_ones_have_their_roles() {
    for (name, wanted) in [
        ("Aceleración longitudinal [m/s2]", Role::SpecificForceX),
        ("Aceleración lateral [m/s2]", Role::SpecificForceY),
        ("velocidad norte [m/s]", Role::VelocityNorth),
        ("velocidad este [m/s]", Role::VelocityEast),
        ("velocidad abajo [m/s]", Role::VelocityDown),
        ("Ángulo de resbalamiento [deg]", Role::Sideslip),
        ("Resbalamiento [deg]", Role::Sideslip),
        ("Temperatura exterior [degC]", Role::AirTemperature),
        ("Température [degC]", Role::AirTemperature),
        ("Température extérieure [degC]", Role::AirTemperature),
        ("ALF [deg]", Role::AngleOfAttack),
        ("BET [deg]", Role::Sideslip),
        ("AOSS [deg]", Role::Sideslip),
        ("DELE [deg]", Role::Elevator),
        ("DELA [deg]", Role::Aileron),
        ("DELR [deg]", Role::Rudder),
        ("Elevator TE down [deg]", Role::Elevator),
    ] {
        assert_eq!(roles_of(name, [1.0, 2.0, 1.5]), [(wanted, false)], "{name}");
    }
    for name in
        ["Temperature [degC]", "Température moteur [degC]", "Velocidad viento norte [m/s]", "beta bet", "alf bet"]
    {
        assert_eq!(roles_of(name, [1.0, 2.0, 1.5]), [], "{name}");
    }
    let baro = |name: &str| roles_of(name, [900.0, 901.0, 902.0]).into_iter().map(|(role, _)| role).collect::<Vec<_>>();
    for name in ["Baro ft", "Baro [ft]"] {
        assert!(baro(name).contains(&Role::Altitude), "{name}");
    }
    assert_eq!(baro("Baro [hPa]"), [Role::StaticPressure]);
}

#[test]
fn a_load_factor_less_one_and_an_elevator_up_are_turned() {
    let map = guess_of("Delta nz [g]", |now| vec![0.1 * now.pitch]);
    let row = map.row(Role::SpecificForceZ).unwrap();
    assert_eq!((row.turned, row.offset, row.unit.unwrap().symbol), (true, 1.0, "g"));
    for name in
        ["Elevator TE up [deg]", "elevator_teu_deg", "Elevator TEU [deg]", "Elevator [deg TEU]", "Elevator (deg TEU)"]
    {
        assert_eq!(roles_of(name, [1.0, 2.0, 1.5]), [(Role::Elevator, true)], "{name}");
    }
}

#[test]
fn a_height_beside_scaled_fixes_is_in_millimetres_only_where_its_numbers_are_whole() {
    let unit = |per_metre: f64| {
        let row = |now: &Instant| vec![470_000_000.0, 80_000_000.0, (100.0 * now.height).round() / 100.0 * per_metre];
        let map = guess_of("lat,lon,baro_alt", row);
        map.row(Role::Altitude).and_then(|row| row.unit).map(|unit| unit.symbol)
    };
    assert_eq!((unit(1.0), unit(1000.0)), (Some("m"), Some("mm")));
}

#[test]
fn velocity_of_a_receiver_by_index_and_accelerations_in_full_words_have_their_roles() {
    let head = "/gps/vel_ned[0],/gps/vel_ned[1],/gps/vel_ned[2],IRS1 Longitudinal Acc [g],IRS1 Lateral Acc [g],IRS1 Normal Acc [g]";
    let map = guess_of(head, |now| [now.speeds.to_vec(), vec![0.02, 0.01, 1.0]].concat());
    let channel = |role: Role| map.row(role).map(|row| row.from.channel.clone());
    for (role, name) in [
        (Role::VelocityNorth, "/gps/vel_ned[0]"),
        (Role::VelocityEast, "/gps/vel_ned[1]"),
        (Role::VelocityDown, "/gps/vel_ned[2]"),
        (Role::SpecificForceX, "IRS1 Longitudinal Acc"),
        (Role::SpecificForceY, "IRS1 Lateral Acc"),
        (Role::SpecificForceZ, "IRS1 Normal Acc"),
    ] {
        assert_eq!(channel(role).as_deref(), Some(name));
    }
    assert!(map.row(Role::SpecificForceZ).is_some_and(|row| row.turned), "load factors are positive upwards");
}

/// A table of two recorders: one with forces and rates, one with two of the rates.
#[test]
fn rates_are_of_the_recorder_that_has_all_three() {
    let folder = tempfile::tempdir().unwrap();
    let probe = |name: &str, head: &str, row: &dyn Fn(&Instant) -> Vec<f64>| {
        let path = folder.path().join(name);
        std::fs::write(&path, table(head, row)).unwrap();
        crate::load::inspect(&path).unwrap()
    };
    let air = probe("air.csv", "roll_rate_dps,pitch_rate_dps,tas_ms", &|now| {
        vec![now.rates[0].to_degrees(), now.rates[1].to_degrees(), 60.0]
    });
    let imu = probe("imu.csv", "accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z", &|now| {
        [vec![0.3, 0.1, -9.8], now.rates.to_vec()].concat()
    });
    let map = guess(&[air, imu]);
    for (role, name) in [(Role::RollRate, "gyro_x"), (Role::PitchRate, "gyro_y"), (Role::YawRate, "gyro_z")] {
        let from = map.row(role).map(|row| (row.from.source.as_str(), row.from.channel.as_str()));
        assert_eq!(from, Some(("imu", name)));
    }
}
