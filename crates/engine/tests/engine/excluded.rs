//! Stretches of manoeuvres that are left out: no measurement of them enters the filter, no sample a fit.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use doublet_core::quantity::Role;
use doublet_core::series::{Recording, TimeRange};
use doublet_engine::graph::Control;
use doublet_engine::report::{self, Results};
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, Edit, Manoeuvre, Session, WindowEdit, WindowRole};
use doublet_engine::stage;
use doublet_engine::undo::History;

use crate::compute;

/// The shipped flight with three elevator manoeuvres.
fn demo() -> Session {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    let mut at = 0;
    session.windows.retain(|_| {
        at += 1;
        matches!(at, 3 | 4 | 19)
    });
    session.windows.iter_mut().for_each(|window| window.role = WindowRole::Identification);
    session
}

fn computed(session: &Session) -> (Snapshot, Results) {
    let snapshot = compute(session, Path::new("."));
    let results = report::build(session, &snapshot);
    (snapshot, results)
}

/// A second and a half of the response of a manoeuvre.
fn stretch(window: &Manoeuvre) -> TimeRange {
    TimeRange { start_s: window.window.start_s + 7.0, end_s: window.window.start_s + 8.5 }
}

/// The session with that stretch of every manoeuvre left out.
fn excluding(session: &Session) -> Session {
    let mut session = session.clone();
    session.windows.iter_mut().for_each(|window| window.excluded = vec![stretch(window)]);
    session
}

/// The recording with a gust and a failing sensor in that stretch of every manoeuvre.
fn spoilt(recording: &Recording, windows: &[Manoeuvre]) -> Recording {
    let mut recording = recording.clone();
    for (role, by) in [
        (Role::AngleOfAttack, 0.15),
        (Role::TrueAirspeed, 8.0),
        (Role::PitchAngle, 0.2),
        (Role::VelocityDown, 5.0),
        (Role::Elevator, -0.2),
    ] {
        let series = &mut recording.channels[recording.roles[&role]].series;
        let inside = |time_s: f64| windows.iter().any(|window| stretch(window).contains(time_s));
        let samples = series.time_s.iter().zip(series.values.iter());
        series.values = samples.map(|(time_s, value)| if inside(*time_s) { value + by } else { *value }).collect();
    }
    recording
}

/// Pooled derivatives of a recording, with their corrected standard errors, and the time of the filter's updates.
fn derivatives(
    session: &Session,
    snapshot: &Snapshot,
    recording: &Recording,
) -> (BTreeMap<String, (f64, f64)>, Vec<f64>) {
    let loaded = Arc::clone(snapshot.aircraft.ready().unwrap());
    let aircraft = stage::aircraft_data(loaded, session.loading.as_ref());
    let samples: Vec<_> = session
        .windows
        .iter()
        .map(|window| stage::samples(recording, window.samples(), Some(&aircraft), &session.preparation).unwrap())
        .collect();
    let by = (&session.filter, session.preparation.path);
    let paths = stage::paths(&samples.iter().collect::<Vec<_>>(), by, &Control::default());
    let paths: Vec<_> = paths.into_iter().map(|path| path.unwrap()).collect();
    let formed = session.windows.iter().zip(&samples).zip(&paths).map(|((window, samples), path)| {
        let found = (&*samples.data, &path.reconstruction);
        let aero = stage::aero(recording, found, (&aircraft, &window.excluded), &session.preparation).unwrap();
        (window, Arc::new(aero))
    });
    let formed: Vec<_> = formed.collect();
    let pooled = stage::pooled_fits(&formed, &session.structure, &session.estimation);
    let mut found = BTreeMap::new();
    for fit in &pooled.fits {
        let estimate = fit.fit.as_ref().unwrap();
        let rows = estimate.names.iter().zip(&estimate.estimates).zip(&fit.corrected_errors);
        found.extend(rows.map(|((name, value), error)| (name.clone(), (*value, *error))));
    }
    let updates = paths.iter().flat_map(|path| {
        let found = &path.reconstruction;
        found.update_time_s.iter().zip(&found.nis).filter(|(_, nis)| nis.is_finite()).map(|(time_s, _)| *time_s)
    });
    (found, updates.collect())
}

/// The largest change of a derivative, in standard errors of the first, constants of single windows left out.
fn largest_change(of: &BTreeMap<String, (f64, f64)>, other: &BTreeMap<String, (f64, f64)>) -> (f64, String) {
    let change = |(name, (value, error)): (&String, &(f64, f64))| ((value - other[name].0).abs() / error, name.clone());
    let shared = of.iter().filter(|(name, _)| !name.contains('['));
    shared.map(change).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

#[test]
fn a_gust_in_an_excluded_stretch_changes_no_derivative_and_the_stretch_costs_no_more_than_its_samples() {
    /// Change of a derivative by leaving an eighth of the samples out, standard errors.
    const FEWER_SAMPLES: f64 = 1.5;
    /// What the gust and the failing sensor do to some derivative unless they are left out, standard errors.
    const SPOILT: f64 = 5.0;
    let session = demo();
    let (snapshot, _) = computed(&session);
    let clean = &snapshot.flights["FT1"].ready().unwrap().recording;
    let spoilt = spoilt(clean, &session.windows);
    let short = excluding(&session);
    let (whole, _) = derivatives(&session, &snapshot, clean);
    let (excluded, updates) = derivatives(&short, &snapshot, clean);
    let (repaired, _) = derivatives(&short, &snapshot, &spoilt);
    let (wrong, _) = derivatives(&session, &snapshot, &spoilt);
    println!("excluded {:?}, spoilt {:?}", largest_change(&whole, &excluded), largest_change(&whole, &wrong));
    assert_eq!(excluded, repaired, "nothing of the stretch reaches a derivative");
    assert!(largest_change(&whole, &excluded).0 < FEWER_SAMPLES);
    assert!(largest_change(&whole, &wrong).0 > SPOILT);
    assert!(!updates.iter().any(|time_s| session.windows.iter().any(|window| stretch(window).contains(*time_s))));
    assert!(updates.len() > 1000, "{}", updates.len());
}

#[test]
fn results_of_a_run_leave_the_stretch_out_and_name_it() {
    let session = demo();
    let (snapshot, whole) = computed(&session);
    let (shorter, results) = computed(&excluding(&session));
    assert!(whole.windows.iter().all(|window| window.excluded.is_empty()));
    for window in &session.windows {
        let rows = |snapshot: &Snapshot| {
            let aero = snapshot.windows[&window.name].aero.ready().unwrap();
            let fit = snapshot.windows[&window.name].fits.ready().unwrap().fits[0].fit.as_ref().unwrap().samples();
            (aero.coefficients.time_s.to_vec(), fit)
        };
        let ((all, _), (left, fitted)) = (rows(&snapshot), rows(&shorter));
        assert!(left.len() < all.len() && fitted == left.len());
        assert!(left.iter().all(|time_s| !stretch(window).contains(*time_s)));
        let row = results.windows.iter().find(|row| row.name == window.name).unwrap();
        assert_eq!(row.excluded, [stretch(window)]);
        assert_eq!(row.error, None);
    }
    let row = serde_json::to_value(&results).unwrap()["windows"][0]["excluded"][0].clone();
    assert_eq!(row["start_s"], stretch(&session.windows[0]).start_s);
}

#[test]
fn a_manoeuvre_that_is_left_out_as_a_whole_says_so_and_the_others_stay() {
    let mut session = demo();
    session.windows[1].excluded = vec![session.windows[1].window];
    let (_, results) = computed(&session);
    let error = results.windows[1].error.clone().unwrap();
    assert!(error.contains("left after exclusions"), "{error}");
    assert!(results.windows[0].error.is_none() && results.windows[2].error.is_none());
}

#[test]
fn excluded_stretches_are_saved_undone_and_refused_where_they_are_empty() {
    let mut history = History::new(demo());
    let name = history.present().windows[0].name.clone();
    let stretch = stretch(&history.present().windows[0]);
    let edit = |excluded: Vec<TimeRange>| Edit::Window(WindowEdit::Exclude { name: name.clone(), excluded });
    history.apply(&edit(vec![stretch])).unwrap();
    let saved = session::print(history.present()).unwrap();
    assert!(saved.contains("exclude"), "{saved}");
    assert_eq!(&session::parse(&saved).unwrap(), &**history.present());
    let inline = "exclude = [{ start_s = 3.0, end_s = 4.0 }, { start_s = 1.0, end_s = 2.0 }]\nkind = ";
    let read = session::parse(&session::print(&demo()).unwrap().replacen("kind = ", inline, 1)).unwrap();
    let [first, second] = read.windows[0].excluded[..] else { panic!("{:?}", read.windows[0].excluded) };
    assert_eq!((first.start_s, second.end_s), (1.0, 4.0), "in the order of time");
    assert!(history.undo());
    assert!(history.present().windows[0].excluded.is_empty());
    assert!(!session::print(history.present()).unwrap().contains("exclude"));
    let empty = TimeRange { start_s: 5.0, end_s: f64::NAN };
    let error = history.apply(&edit(vec![empty])).unwrap_err().to_string();
    assert!(error.contains("excluded part"), "{error}");
    let mut wrong = demo();
    wrong.windows[0].excluded = vec![empty];
    assert!(session::check(&wrong).iter().any(|finding| finding.to_string().contains("excluded part")));
}

#[test]
fn a_manoeuvre_is_split_in_one_step_each_part_with_its_own_excluded_stretches() {
    let mut history = History::new(demo());
    let whole = history.present().windows[0].clone();
    let at_s = whole.window.start_s + 6.0;
    history
        .apply(&Edit::Window(WindowEdit::Exclude { name: whole.name.clone(), excluded: vec![stretch(&whole)] }))
        .unwrap();
    let split = |second: &str, end_s: f64| {
        let (name, second) = (whole.name.clone(), second.to_owned());
        Edit::Window(WindowEdit::Split { name, end_s, start_s: at_s + 0.02, second })
    };
    assert!(history.apply(&split(&whole.name, at_s)).is_err(), "the name is taken");
    assert!(history.apply(&split("second", whole.window.start_s - 1.0)).is_err(), "the first part would be empty");
    history.apply(&split("second", at_s)).unwrap();
    let windows = &history.present().windows;
    let [first, second] = [&windows[0], &windows[1]];
    assert_eq!((first.window.start_s, first.window.end_s), (whole.window.start_s, at_s));
    assert_eq!((second.window.start_s, second.window.end_s), (at_s + 0.02, whole.window.end_s));
    assert_eq!((second.name.as_str(), second.surface, second.role), ("second", whole.surface, whole.role));
    assert_eq!((first.excluded.as_slice(), second.excluded.as_slice()), (&[][..], &[stretch(&whole)][..]));
    assert!(history.undo());
    assert_eq!(history.present().windows.len(), demo().windows.len());
}
