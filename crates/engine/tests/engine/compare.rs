//! Two sessions or runs side by side.

use doublet_core::model::Coefficient;
use doublet_core::reconstruct::{Input, Measurement, State};
use doublet_core::series::TimeRange;
use doublet_engine::compare::{Estimates, PRESENT, differences, read_estimates, settings};
use doublet_engine::graph::{Cache, Context};
use doublet_engine::run::{ExperimentRows, experiment_rows};
use doublet_engine::session::{
    self, Edit, ExperimentEdit, FilterEdit, NoiseChannel, Session, WindowEdit, WindowRole, cross_experiments,
    manoeuvre_experiments, noise_experiments, structure_experiments,
};
use doublet_engine::verdict::VerdictCounts;

use crate::compute;

/// Rounding of a difference of doubles.
const ROUNDING: f64 = 1e-12;
/// Digits of the published table of the normal distribution.
const TABLE: f64 = 5e-5;

fn demo() -> Session {
    session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap()
}

#[test]
fn settings_that_differ_are_named_with_their_units() {
    let first = demo();
    let name = first.windows[2].name.clone();
    let window = TimeRange { start_s: 1.5, end_s: 2.5 };
    let edits = [
        Edit::noise(NoiseChannel::Input(Input::RollRate), 0.25),
        Edit::noise(NoiseChannel::Measurement(Measurement::Airspeed), 0.5),
        Edit::Filter(FilterEdit::RandomWalk(State::BiasQ, 0.125)),
        Edit::Window(WindowEdit::Place { name: name.clone(), window }),
        Edit::Window(WindowEdit::Remove(first.windows[0].name.clone())),
        Edit::Title("other".to_owned()),
    ];
    let second = edits.iter().fold(first.clone(), |session, edit| edit.apply(&session).unwrap());
    assert_eq!(settings(&first, &first).unwrap(), []);
    let found = settings(&first, &second).unwrap();
    let row = |setting: &str| {
        let row = found.iter().find(|row| row.setting == setting).unwrap_or_else(|| panic!("no {setting}: {found:?}"));
        (row.unit.as_str(), row.first.as_deref(), row.second.as_deref())
    };
    let was = first.filter.process_noise[Input::RollRate as usize].to_string();
    assert_eq!(row("filter.process_noise.p"), ("rad/s", Some(was.as_str()), Some("0.25")));
    assert_eq!(row("filter.measurement_noise.airspeed").0, "m/s");
    assert_eq!(row("filter.random_walk.bias_q"), ("rad/s/√s", None, Some("0.125")));
    let start = first.windows[2].window.start_s.to_string();
    assert_eq!(row(&format!("manoeuvre '{name}'.start_s")), ("s", Some(start.as_str()), Some("1.5")));
    assert_eq!(row("title").2, Some("other"));
    let removed = format!("manoeuvre '{}'.", first.windows[0].name);
    let gone: Vec<_> = found.iter().filter(|row| row.setting.starts_with(&removed)).collect();
    assert!(gone.len() >= 4 && gone.iter().all(|row| row.second.is_none()), "{gone:?}");
    assert_eq!(found.len() - gone.len(), 6, "{found:?}");
    let back = settings(&second, &first).unwrap();
    assert!(found.iter().zip(&back).all(|(a, b)| a.setting == b.setting && a.first == b.second && a.second == b.first));
}

#[test]
fn order_of_the_terms_of_a_model_is_no_difference() {
    let first = demo();
    let mut second = first.clone();
    second.structure.models[0].1.reverse();
    assert_ne!(first.structure, second.structure);
    assert_eq!(settings(&first, &second).unwrap(), []);
    second.structure.models[0].1.pop();
    let found = settings(&first, &second).unwrap();
    assert_eq!(found.iter().map(|row| row.setting.as_str()).collect::<Vec<_>>(), ["model.CX"]);
}

fn run(derivatives: &str) -> Estimates {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        r#"{{"format": "doublet results", "version": 1, "title": "t", "later": [],
            "pooled": [{{"coefficient": "Cm", "derivatives": [{derivatives}]}}]}}"#
    );
    std::fs::write(folder.path().join("results.json"), text).unwrap();
    read_estimates(folder.path()).unwrap()
}

#[test]
fn derivatives_differ_by_z_of_their_corrected_errors() {
    let first = run(r#"{"name": "Cm_0[e1]", "estimate": 9.0, "corrected_standard_error": 1.0},
        {"name": "Cm_alpha", "estimate": -1.0, "standard_error": 0.001, "corrected_standard_error": 0.03},
        {"name": "Cm_q", "estimate": -20.0, "corrected_standard_error": null},
        {"name": "Cm_beta", "estimate": 0.1, "corrected_standard_error": 0.1}"#);
    let second = run(r#"{"name": "Cm_alpha", "estimate": -0.902, "corrected_standard_error": 0.04},
        {"name": "Cm_q", "estimate": -21.0, "corrected_standard_error": 1.0},
        {"name": "Cm_delta_e", "estimate": -1.5, "corrected_standard_error": 0.1}"#);
    let rows = differences(&first, &second);
    let names: Vec<_> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["Cm_alpha", "Cm_q", "Cm_beta", "Cm_delta_e"], "constants of single windows are trim");
    // 0.098 over the hypotenuse of 0.03 and 0.04; the normal table gives 5 % for 1.96.
    assert!((rows[0].z.unwrap() - 1.96).abs() < ROUNDING && (rows[0].p.unwrap() - 0.05).abs() < TABLE, "{:?}", rows[0]);
    let interval = rows[0].first.unwrap();
    assert!((interval.high - interval.low - 2.0 * 1.96 * 0.03).abs() < TABLE && interval.estimate == -1.0);
    assert_eq!((rows[1].z, rows[1].p), (None, None), "an error that does not exist decides nothing");
    assert_eq!((rows[2].second, rows[3].first), (None, None));
    assert!(differences(&first, &first).iter().filter_map(|row| row.z).all(|z| z == 0.0));
}

#[test]
fn folders_without_results_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(read_estimates(folder.path()).unwrap_err().contains("results.json"));
    std::fs::write(folder.path().join("results.json"), r#"{"format": "x", "version": 1}"#).unwrap();
    assert!(read_estimates(folder.path()).unwrap_err().contains("'x' version 1 is not understood"));
}

#[test]
fn experiment_gives_what_the_session_with_its_configuration_gives() {
    let session = demo();
    let added = [structure_experiments(&session, Coefficient::Cm), noise_experiments(&session)].concat();
    let added: Vec<_> =
        added.into_iter().filter(|one| one.name.contains("Cm_q") || one.name.starts_with("2 x")).collect();
    let [damping, noise] = [0, 1].map(|at| added[at].name.clone());
    let session = Edit::Experiment(ExperimentEdit::Add(added)).apply(&session).unwrap();
    let cache = Cache::new(1 << 30);
    let folder = std::path::Path::new("");
    let rows_of = |session: &Session| {
        let mut rows = ExperimentRows::default();
        experiment_rows(session, &mut rows, &Context::new(folder).with_cache(&cache), &|_| ()).unwrap();
        rows
    };
    let rows = rows_of(&session);
    let row = |name: &str| rows.row(name).unwrap().ready().unwrap_or_else(|| panic!("{name}: {rows:?}"));
    // Number for number what a run of that session gives.
    let applied = Edit::Experiment(ExperimentEdit::Apply(damping.clone())).apply(&session).unwrap();
    let snapshot = compute(&applied, folder);
    let found = &row(&damping).outcome;
    assert_eq!(found.verdict, VerdictCounts::count(snapshot.verdicts.ready().unwrap()));
    for fit in &snapshot.pooled.ready().unwrap().fits {
        let own = found.coefficient(fit.coefficient.name()).unwrap();
        let estimates = &fit.fit.as_ref().unwrap().estimates;
        assert!(own.derivatives.iter().all(|one| estimates.contains(&one.interval.estimate)), "{}", own.coefficient);
        assert!(!own.derivatives.is_empty());
    }
    // Without pitch damping Cm is worse by far, and no other coefficient moves.
    let delta = |name: &str, coefficient: &str| {
        row(name).outcome.coefficient(coefficient).and_then(|one| one.fit.as_ref()?.delta_akaike)
    };
    assert!(delta(&damping, "Cm").unwrap() > 100.0, "{:?}", delta(&damping, "Cm"));
    assert_eq!((delta(&damping, "CZ"), delta(PRESENT, "Cm")), (Some(0.0), Some(0.0)));
    let honest = |name: &str| row(name).outcome.coefficient("Cm").unwrap().fit.as_ref().unwrap().honest_r_squared;
    assert!(honest(PRESENT).unwrap() > honest(&damping).unwrap() + 0.01);
    assert!(row(PRESENT).outcome.validation_error < row(&damping).outcome.validation_error);
    // Twice the noise: smaller NIS, other samples, so that no criterion is compared.
    assert_eq!((delta(&noise, "Cm"), row(&noise).delta_akaike), (None, None));
    let [before, after] = [PRESENT, noise.as_str()].map(|name| row(name).outcome.nis.unwrap());
    assert!(after < 0.6 * before && after > 0.2 * before, "{before} {after}");
    assert!(row(&noise).differences.iter().all(|one| one.setting.starts_with("filter.measurement_noise.")));
    // Taken up, it is the session's own; rows that are known are found again.
    let rows = rows_of(&applied);
    assert!(rows.row(&damping).unwrap().ready().unwrap().is_current);
    assert!(!rows.row(&noise).unwrap().ready().unwrap().is_current);
}

#[test]
fn structures_are_crossed_with_sets_of_manoeuvres() {
    let session = demo();
    let sets = manoeuvre_experiments(&session);
    let used = |role| {
        let manoeuvres =
            sets.iter().map(|set| set.configuration.manoeuvres.iter().filter(|used| used.role == role).count());
        manoeuvres.collect::<Vec<_>>()
    };
    let active = session.active_windows().count();
    assert_eq!(used(WindowRole::Identification), [active.div_ceil(2), active / 2]);
    assert_eq!(used(WindowRole::Validation), [active / 2, active.div_ceil(2)]);
    let structures = structure_experiments(&session, Coefficient::Cm);
    let crossed = cross_experiments(&structures, &sets);
    assert_eq!(crossed.len(), 2 * structures.len());
    assert_eq!(crossed[1].name, format!("{}, {}", structures[0].name, sets[1].name));
    assert_eq!(crossed[1].configuration.structure, structures[0].configuration.structure);
    assert_eq!(crossed[1].configuration.manoeuvres, sets[1].configuration.manoeuvres);
}
