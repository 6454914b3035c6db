//! The verdict on the shipped flight: good as it is, with the right cause where a setting is wrong.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests are not marked as tests")]

use std::path::Path;

use doublet_core::series::TimeRange;
use doublet_engine::aircraft::ChangedValue;
use doublet_engine::graph::Cache;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, AircraftEdit, Edit, Place, Session};
use doublet_engine::verdict::{Finding, Level, Verdicts, dependences, judge};

fn builtin(name: &str) -> Session {
    session::parse(doublet_engine::builtin::session(name).unwrap()).unwrap()
}

fn computed(session: &Session) -> Snapshot {
    let folder = Path::new(".");
    let scope = Scope { session, folder, first: None, studies: &[], cause: "test", generation: 1 };
    run(&scope, &Snapshot::default(), &Cache::new(1 << 30), &Control::default(), &|_| {})
}

fn show(verdicts: &Verdicts) {
    println!("{}", verdicts.headline());
    verdicts.session.reasons.iter().for_each(|reason| println!("{} {}: {reason}", reason.level.name(), reason.code));
}

fn reasons<'a>(verdicts: &'a Verdicts, code: &str) -> Vec<&'a Finding> {
    verdicts.session.reasons.iter().filter(|reason| reason.code == code).collect()
}

#[test]
fn the_shipped_flight_is_good_but_for_the_axial_force() {
    let session = builtin("demo");
    let snapshot = computed(&session);
    let verdicts = snapshot.verdicts.ready().unwrap();
    show(verdicts);
    for fit in &verdicts.pooled {
        let expected = if fit.coefficient.name() == "CX" { Level::Caution } else { Level::Good };
        assert_eq!(fit.verdict.level, expected, "{:?}", fit.verdict.reasons);
    }
    for (name, window) in &verdicts.windows {
        assert_eq!(window.verdict.level, Level::Good, "{name}: {:?}", window.verdict.reasons);
        assert!(window.fits.iter().all(|fit| fit.verdict.level < Level::Bad), "{name}");
    }
    // What marks CX is said of CX.
    assert_eq!(verdicts.session.level, Level::Good);
}

/// Every force derivative with what its dependence says of accelerometers stated further forward, and how it changes, per cent.
fn moved_forward(session: &Session, [before, after]: [&Snapshot; 2]) -> Vec<(String, f64, f64)> {
    let fits = [before, after].map(|snapshot| &snapshot.pooled.ready().unwrap().fits);
    let mut moved = Vec::new();
    for (fit, other) in fits[0].iter().zip(fits[1]) {
        let (own, other) = (fit.fit.as_ref().unwrap(), other.fit.as_ref().unwrap());
        for (at, name) in own.names.iter().enumerate() {
            let all = dependences(session, before, fit, name);
            let Some(said) = all.iter().find(|one| one.axis == Some("forward")) else { continue };
            let change = 100.0 * (other.estimates[at] / own.estimates[at] - 1.0);
            moved.push((name.clone(), said.change_percent, change));
        }
    }
    moved
}

#[test]
fn force_derivatives_change_with_the_stated_position_of_the_accelerometers_as_said() {
    let session = builtin("demo");
    // 0.1 m further forward: the datum's x points aft.
    let forward =
        AircraftEdit::set("position", "sensors.accelerometer_datum_m", ChangedValue::Triple([1.93, 0.20, 1.40]));
    let moved = Edit::Aircraft(forward).apply(&session).unwrap();
    let snapshots = [&session, &moved].map(computed);
    let rows = moved_forward(&session, [&snapshots[0], &snapshots[1]]);
    rows.iter().for_each(|(name, said, change)| println!("{name}: said {said:.2} %, {change:.2} %"));
    let large: Vec<_> = rows.iter().filter(|(_, said, _)| said.abs() > 2.0).collect();
    assert!(large.iter().any(|(name, ..)| name == "CZ_delta_e"), "{rows:?}");
    for (name, said, change) in large {
        assert!((change - said).abs() < 0.2 * said.abs(), "{name}: said {said:.2} %, {change:.2} %");
    }
}

#[test]
fn window_across_a_turn_of_the_shipped_flight_says_so() {
    let mut session = builtin("demo");
    // Between the test points the controls are not recorded: the path alone.
    session.aircraft = None;
    let straight = session.windows[0].clone();
    let mut across = straight.clone();
    (across.name, across.window) = ("across".to_owned(), TimeRange { start_s: 2400.0, end_s: 2520.0 });
    session.windows = vec![across, straight];
    let snapshot = computed(&session);
    let verdicts = snapshot.verdicts.ready().unwrap();
    let found = reasons(verdicts, "turn");
    assert!(
        found.len() == 1 && found[0].level == Level::Caution && found[0].place.manoeuvre_name() == Some("across"),
        "{found:?}"
    );
}

/// The inertial unit of the shipped flight is ahead of the centre of gravity: taken where it is, nothing is said; taken at the centre of
/// gravity, its place is.
#[test]
fn accelerometers_that_are_not_where_they_are_taken_are_named_with_their_place() {
    let mut session = builtin("demo");
    session.windows.truncate(1);
    let judge_position = |session: &Session| {
        let snapshot = computed(session);
        let verdicts = judge(session, &snapshot);
        let is_of_flight =
            |finding: &&Finding| finding.code == "accelerometer" && matches!(finding.place, Place::Flight { .. });
        let finding = verdicts.session.reasons.iter().find(is_of_flight).cloned();
        (snapshot, finding)
    };
    assert_eq!(judge_position(&session).1, None);
    session.preparation.correct_accelerometer = false;
    let (snapshot, finding) = judge_position(&session);
    let (text, fix_text) = finding.map(|finding| (finding.text.to_string(), finding.fix_text)).unwrap();
    println!("{text}: {fix_text}");
    let sensors = snapshot.aircraft.ready().unwrap().aircraft.sensors;
    let [x, ..] = sensors.accelerometer_from_datum_m.unwrap();
    let stated = fix_text.split(": ").nth(1).and_then(|list| list.split(',').next()).unwrap();
    let found: f64 = stated.parse().unwrap();
    assert!((found - x).abs() < 0.1, "{found} {x}");
}
