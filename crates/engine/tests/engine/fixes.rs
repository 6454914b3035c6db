//! Fixes of findings: applied, they give back what a session without the mistake says.

use std::path::Path;

use doublet_core::model::Lag;
use doublet_engine::builtin;
use doublet_engine::graph::{Cache, Context};
use doublet_engine::run::{Control, Scope, Snapshot, TriedFixes, run, try_fixes};
use doublet_engine::session::{self, Edit, EstimationEdit, Fix, MapRef, Opened, Session, Surface, WindowRole};
use doublet_engine::verdict::{Level, VerdictCounts, fixes};

fn demo() -> Opened {
    session::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml")).unwrap()
}

fn computed(session: &Session, folder: &Path) -> Snapshot {
    let scope = Scope { session, folder, first: None, studies: &[], cause: "test", generation: 1 };
    run(&scope, &Snapshot::default(), &Cache::new(0), &Control::default(), &|_| {})
}

/// Pooled estimates by the name of the derivative.
fn estimates(snapshot: &Snapshot) -> Vec<(String, f64)> {
    let pooled = snapshot.pooled.ready().unwrap();
    let fits = pooled.fits.iter().filter_map(|fit| fit.fit.as_ref().ok());
    fits.flat_map(|fit| fit.names.iter().cloned().zip(fit.estimates.iter().copied())).collect()
}

fn counts(snapshot: &Snapshot) -> VerdictCounts {
    VerdictCounts::count(snapshot.verdicts.ready().unwrap())
}

#[test]
fn fix_of_a_turned_channel_gives_the_derivatives_of_the_right_map() {
    let Opened { session, folder, .. } = demo();
    let mut wrong = session.clone();
    let mut map: toml::Table = toml::from_str(builtin::text("channel_maps", "demo_flight").unwrap()).unwrap();
    let entry = map["roles"]["v_down"].as_table_mut().unwrap();
    let sign = entry.get("sign").map_or(1.0, |sign| sign.as_float().unwrap_or(-1.0));
    entry.insert("sign".to_owned(), (-sign).into());
    let text = toml::to_string(&map).unwrap();
    for recording in &mut wrong.flights[0].recordings {
        if recording.channel_map.name().ends_with("demo_flight") {
            recording.channel_map = MapRef::Own(text.clone().into());
        }
    }
    let before = computed(&wrong, &folder);
    let verdicts = before.verdicts.ready().unwrap();
    let found = fixes(verdicts);
    let (fix, _) = found.iter().find(|(fix, _)| fix.label == "use v_down = -v_down").unwrap();
    let after = computed(&fix.apply(&wrong).unwrap(), &folder);
    let right = computed(&session, &folder);
    assert_eq!(counts(&after), counts(&right));
    assert!(counts(&before).level > counts(&right).level, "{:?}", counts(&before));
    for ((name, found), (_, expected)) in estimates(&after).iter().zip(estimates(&right)) {
        assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-3), "{name}: {found}, {expected}");
    }
}

#[test]
fn fix_of_a_late_control_states_the_delay_that_was_taken_from_it() {
    let Opened { session, folder, .. } = demo();
    let stated_s = session.preparation.control_lags.get(Surface::Elevator).delay_s;
    let lag = Lag { delay_s: stated_s + 0.1, ..session.preparation.control_lags.get(Surface::Elevator) };
    let wrong = Edit::Estimation(EstimationEdit::ControlLag(Surface::Elevator, lag)).apply(&session).unwrap();
    let before = computed(&wrong, &folder);
    assert_eq!(counts(&before).level, Level::Bad);
    let verdicts = before.verdicts.ready().unwrap();
    let found = fixes(verdicts);
    let (fix, place) = found.iter().find(|(fix, _)| fix.label.contains("for the elevator")).unwrap();
    assert!(place.is_named("elevator"), "{place}");
    let fixed = fix.apply(&wrong).unwrap();
    let delay_s = fixed.preparation.control_lags.get(Surface::Elevator).delay_s;
    assert!((delay_s - stated_s).abs() < 0.005, "{delay_s}");
    let mut tried = TriedFixes::default();
    try_fixes(&wrong, std::slice::from_ref(fix), &mut tried, &Context::new(&folder), &|_| {}).unwrap();
    let tried = tried.row(fix).unwrap().ready().unwrap().verdict;
    assert_eq!(tried.level, counts(&computed(&session, &folder)).level);
    assert!(tried.bad < counts(&before).bad);
    let kept = fix.to_experiment(&wrong).unwrap();
    assert!(fix.is_of_configuration());
    assert_eq!(kept.configuration.applied_to(&wrong), fixed);
}

#[test]
fn fixes_of_findings_alike_are_one() {
    let Opened { session, .. } = demo();
    let names: Vec<&str> = session.windows.iter().take(3).map(|window| window.name.as_str()).collect();
    let one_each: Vec<Fix> = names.iter().map(|name| Fix::ignore([*name])).collect();
    let all = Fix::join(&one_each.iter().collect::<Vec<_>>()).unwrap();
    assert_eq!(all, Fix::ignore(names.iter().copied()));
    let ignored = all.apply(&session).unwrap();
    assert!(ignored.windows[..3].iter().all(|window| window.role == WindowRole::Ignored));
    assert_eq!(ignored.windows[3..], session.windows[3..]);
    let delays = [0.02, 0.03].map(|delay_s| Fix::control_delay(&session, Surface::Elevator, delay_s));
    let both = Fix::join(&[&delays[0], &delays[1]]).unwrap();
    assert_eq!(both.edits.len(), 2);
    assert_eq!(Fix::join(&[&delays[0]]).unwrap(), delays[0]);
    assert_eq!(Fix::join(&[]), None);
}
