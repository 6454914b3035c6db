//! Text tables of recorders that write marks for no value, minutes, German names and values without units.

use std::fmt::Write as _;

use doublet_core::load::{Probe, guess, inspect};
use doublet_core::quantity::Role;

use super::written;

fn probe_of(text: &str) -> Probe {
    let (_folder, path) = written("mine.csv", text);
    inspect(&path).unwrap()
}

fn values(probe: &Probe, name: &str) -> Vec<f64> {
    let channel = probe.sources[0].channels.iter().find(|channel| channel.name == name).unwrap();
    channel.values().to_vec()
}

#[test]
fn marks_of_no_value_are_none_and_values_as_large_stay() {
    let probe = probe_of("time,alpha,alt,mode\n0.0,2.5,8000,1\n0.1,-999,9999,999\n0.2,2.7,8100,1\n0.3,-999,8200,999\n");
    let alpha = values(&probe, "alpha");
    assert_eq!((alpha[0], alpha[2]), (2.5, 2.7));
    assert!(alpha[1].is_nan() && alpha[3].is_nan(), "{alpha:?}");
    assert_eq!(values(&probe, "alt"), [8000.0, 9999.0, 8100.0, 8200.0]);
    let count = probe.warnings.iter().filter(|line| line.to_string().contains("count as missing")).count();
    assert_eq!(count, 2, "{:?}", probe.warnings);
}

#[test]
fn stamps_that_can_be_minutes_are_asked_for_and_decimals_of_a_second_are_not() {
    let asked = |scale: f64| {
        let mut text = "time,p,q\n".to_owned();
        (0..3000).for_each(|k| writeln!(text, "{:.8},{},1", f64::from(k) * 0.02 * scale, k % 7).unwrap());
        let clock = probe_of(&text).sources[0].clocks[0].clone();
        (clock.is_unit_ambiguous, clock.question.unwrap_or_default())
    };
    let (ambiguous, question) = asked(1.0 / 60.0);
    assert!(ambiguous && question.contains("in minutes 50 Hz over 60 s"), "{question}");
    assert_eq!(asked(1.0), (false, String::new()));
    let (ambiguous, question) = asked(1.0 / 3600.0);
    assert!(!ambiguous && question.contains("read in hours of the day, 50 Hz over 60 s"), "{question}");
}

#[test]
fn german_names_vertical_speed_and_indicated_airspeed_are_guessed() {
    let probe = probe_of(
        "Zeit [s];Nickrate [°/s];Gierrate [°/s];Anstellwinkel [°];Höhenruder [°];Querruder [°];Höhe [m];VS;indicated airspeed [m/s]\n\
         0,00;1,5;0,1;3,0;-1,5;0,5;500,0;0,5;40,0\n0,02;1,4;0,1;3,1;-1,4;0,5;500,1;0,6;40,1\n0,04;1,3;0,1;3,2;-1,3;0,5;500,2;0,7;40,2\n",
    );
    assert!((probe.sources[0].clocks[0].rate_hz - 50.0).abs() < 1e-6);
    let map = guess(std::slice::from_ref(&probe));
    let first = |role: Role| map.row(role).map(|row| row.values(std::slice::from_ref(&probe)).unwrap().first);
    for (role, value) in [
        (Role::PitchRate, 1.5),
        (Role::YawRate, 0.1),
        (Role::AngleOfAttack, 3.0),
        (Role::Elevator, -1.5),
        (Role::Aileron, 0.5),
        (Role::Altitude, 500.0),
        (Role::VelocityDown, -0.5),
        (Role::CalibratedAirspeed, 40.0),
    ] {
        assert_eq!(first(role), Some(value), "{}", role.name());
    }
    assert!(map.row(Role::TrueAirspeed).is_none());
}

#[test]
fn portuguese_italian_and_dutch_names_are_guessed() {
    let roles = [
        Role::SpecificForceX,
        Role::SpecificForceZ,
        Role::RollRate,
        Role::PitchRate,
        Role::PitchAngle,
        Role::TrueAirspeed,
        Role::AngleOfAttack,
        Role::Elevator,
        Role::Rudder,
    ];
    let units = ["m/s2", "m/s2", "deg/s", "deg/s", "deg", "m/s", "deg", "deg", "deg"];
    let languages = [
        "Tempo,Aceleração longitudinal,Aceleração vertical,Razão de rolamento,Razão de arfagem,Arfagem,Velocidade verdadeira,Ângulo de ataque,\
         Profundor,Leme",
        "Tempo,Accelerazione X,Accelerazione Z,Velocità di rollio,Velocità di beccheggio,Beccheggio,Velocità vera,Angolo di attacco,\
         Equilibratore,Timone",
        "Tijd,Versnelling langs,Versnelling verticaal,Rolsnelheid,Stampsnelheid,Langshelling,Ware luchtsnelheid,Invalshoek,Hoogteroer,\
         Richtingsroer",
    ];
    for names in languages {
        let mut names = names.split(',');
        let time = names.next().unwrap();
        let columns: Vec<String> = names.zip(units).map(|(name, unit)| format!("{name} [{unit}]")).collect();
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            format!("{t:.2},0.3,-9.8,{},{},2.0,55.0,3.0,{},0.5\n", t.sin(), t.cos(), (2.0 * t).sin())
        };
        let rows: String = (0..200).map(row).collect();
        let map = guess(&[probe_of(&format!("{time} [s],{}\n{rows}", columns.join(",")))]);
        for (role, column) in roles.into_iter().zip(&columns) {
            let name = column.split(" [").next().unwrap();
            let found = map.row(role).map(|row| row.from.channel.as_str());
            assert!(found.is_some_and(|found| found.starts_with(name)), "{role:?} of {column}: {found:?}");
        }
    }
}

/// A quaternion without letters whose scalar is last, and a vane whose recorder writes zero.
#[test]
fn order_of_a_quaternion_and_a_resting_vane_follow_from_the_motion() {
    let mut text = "time [s],quat[0],quat[1],quat[2],quat[3],q [deg/s],r [deg/s],TAS [m/s],beta [deg]\n".to_owned();
    for k in 0..3000 {
        let t = 0.02 * f64::from(k);
        // Turns to either side, with a pitch of 0.1 +- 0.05 rad and no bank.
        let (theta, psi) = (0.1 + 0.05 * (0.5 * t).sin(), 1.5 * (0.1 * t).sin());
        let ((sin_theta, cos_theta), (sin_psi, cos_psi)) = ((0.5 * theta).sin_cos(), (0.5 * psi).sin_cos());
        let (x, y, z, w) = (-sin_theta * sin_psi, sin_theta * cos_psi, cos_theta * sin_psi, cos_theta * cos_psi);
        let (q, r) = (0.025 * (0.5 * t).cos(), 0.15 * (0.1 * t).cos() * theta.cos());
        writeln!(text, "{t:.2},{x:.7},{y:.7},{z:.7},{w:.7},{:.5},{:.5},60.0,0.0", q.to_degrees(), r.to_degrees())
            .unwrap();
    }
    let map = guess(&[probe_of(&text)]);
    assert_eq!(map.attitude.as_ref().unwrap().parts, ["quat[3]", "quat[0]", "quat[1]", "quat[2]"]);
    assert!(map.row(Role::Sideslip).is_none());
    assert!(map.left_out.iter().any(|(from, why)| from.channel.starts_with("beta") && why.contains("never changes")));
}
