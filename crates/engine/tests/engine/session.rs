//! Sessions: saved form, edits, undo.

mod experiment;
mod expression;
mod older;

use doublet_core::airframe::Loading;
use doublet_core::estimate::{Constraint, SensorError};
use doublet_core::load::{ChannelName, ManualChannel};
use doublet_core::model::{Coefficient, Structure, Term, Variable};
use doublet_core::quantity::{Role, Unit};
use doublet_core::reconstruct::{
    AirState, FilterData, FilterSettings, Input, InputSeries, Measurement, MeasurementSeries, Method,
};
use doublet_core::series::TimeRange;
use doublet_engine::graph::Context;
use doublet_engine::run::Control;
use doublet_engine::session::{
    self, Annotation, ClockPairSetting, ClockSetting, Configuration, Edit, EditError, ErrorValues, Estimation,
    ExperimentEdit, ExpressionEdit, ExpressionSetting, FilterEdit, Flight, GravitySource, GustSource, HeldSampleUse,
    InstrumentSetting, LevelFlight, Manoeuvre, MapRef, ModelEdit, NoiseChannel, Preparation, RecordingRef,
    RefusedCandidate, SensorErrorMethod, SensorErrors, Session, SignalPreset, SignalSetting, SteadyWindow, Surface,
    WindowEdit, WindowFlag, WindowRole,
};
use doublet_engine::undo::History;
use doublet_engine::verdict::{Level, PlausibleRange};
use doublet_engine::{begin, stage};
use proptest::prelude::*;

fn expression(name: &str, unit: &str, expression: &str) -> ExpressionSetting {
    ExpressionSetting { name: name.into(), unit: unit.into(), expression: expression.into(), role: None }
}

fn instruments() -> InstrumentSetting {
    InstrumentSetting {
        file: "builtin:c337f_instruments".to_owned(),
        control_sensors: Some("sensor_*".to_owned()),
        thesis_controls: true,
        pod: None,
        pod_calibration: String::new(),
        level_flight: Some(LevelFlight {
            mass_kg: 1778.0,
            airspeed_m_s: [49.4, 43.3, 37.7],
            altitude_m: Some(914.4),
            density_kg_m3: None,
        }),
        fuel: [("main left".to_owned(), "engine_monitor/m_f_ML".to_owned())].into(),
    }
}

fn example() -> Session {
    let window = |name: &str, start_s: f64| {
        let range = TimeRange { start_s, end_s: start_s + 20.0 };
        let named = Manoeuvre::new(name.to_owned(), "one".to_owned(), range);
        Manoeuvre { surface: Some(Surface::Elevator), kind: "doublet".to_owned(), ..named }
    };
    Session {
        title: "example".to_owned(),
        aircraft: Some("builtin:c337f".to_owned()),
        aircraft_changes: Default::default(),
        loading: None,
        flights: vec![Flight {
            name: "one".to_owned(),
            date: "2026-05-04".into(),
            crew: "A. Pilot".into(),
            recordings: vec![RecordingRef {
                path: "flight.h5".to_owned(),
                sha256: Some("ab".to_owned()),
                channel_map: "builtin:demo".into(),
                only: None,
            }],
            clocks: vec![ClockSetting {
                source: "pod".to_owned(),
                offset_s: -258.0,
                drift: 1e-4,
                shift_s: 0.012,
                fit: vec![ClockPairSetting {
                    reference: "adahrs/inertial/phi".to_owned(),
                    other: "pod/phi".to_owned(),
                    inverted: false,
                }],
            }],
            instruments: Some(instruments()),
            signals: SignalSetting {
                held_samples: HeldSampleUse::Every,
                max_gap_s: Some(0.5),
                rules: SignalPreset::Thesis.rules()[..2].to_vec(),
                position_from_velocity: true,
            },
            loading: Some(Loading { seats_kg: [("captain".to_owned(), 81.0)].into(), ..Loading::default() }),
            expressions: vec![
                expression("ground speed", "m/s", "sqrt(v_north^2 + v_east^2)"),
                ExpressionSetting {
                    role: Some(Role::AngleOfAttack),
                    ..expression("corrected", "deg", "1.05 * {pod/alpha} - \"expression/ground speed\" / 100")
                },
            ],
        }],
        windows: vec![window("e1", 10.0), window("e2", 50.0)],
        steady: vec![SteadyWindow {
            flight: "one".into(),
            window: TimeRange::new(1.0, 11.0),
            roles: vec![Role::PitchRate],
        }],
        refused: vec![RefusedCandidate { flight: "one".into(), name: "found 3".into(), start_s: 20.0, end_s: 30.5 }],
        noise_reasons: [("alpha".to_owned(), "the pod is slow".to_owned())].into(),
        gravity: GravitySource::Stated,
        gusts: GustSource::Stated,
        delays: session::DelaySource::Stated,
        filter: FilterSettings::default(),
        preparation: Preparation::default(),
        sensor_errors: Default::default(),
        estimation: Estimation::default(),
        structure: Structure::thesis(),
        experiments: Vec::new(),
        annotations: vec![Annotation { flight: "one".to_owned(), time_s: 12.5, text: "gust, \"left\"".to_owned() }],
        report_purpose: "Identify the \"new\" elevator.".to_owned(),
        report_asked: vec!["Cm_alpha".to_owned(), "Cm_delta_e".to_owned()],
        report_notes: "Flown at noon.\nAir calm below 4000 ft.".to_owned(),
        report_figures: Vec::new(),
        plausible: [("Cm_q".to_owned(), PlausibleRange { low: -60.0, high: -1.0, sign_certain: true })].into(),
    }
}

#[test]
fn session_roundtrips() {
    let mut session = example();
    session.filter.initial_state[2] = Some(-1219.0);
    session.filter.random_walk[15] = 0.05;
    session.windows[1].surface = None;
    session.windows[1].note = "gust at 62 s, \"kept\"".to_owned();
    session.windows[0].flags.locked = true;
    session.preparation.differentiation_half_width_s = None;
    let error = |name: &str| SensorError::from_name(name).unwrap();
    session.sensor_errors = SensorErrors {
        method: SensorErrorMethod::FilterError,
        free: vec![error("scale_alpha"), error("bias_q")],
        per_window: vec![error("misalignment_y")],
        random_walk: ErrorValues([(error("bias_q"), 1e-5)].into()),
        outputs: vec![Measurement::AngleOfAttack, Measurement::PitchAngle],
        wind: true,
    };
    session.preparation.known_errors.0.insert(error("bias_beta"), 0.01);
    let text = session::print(&session).unwrap();
    assert_eq!(session::parse(&text).unwrap(), session);
    assert!(session::check(&session).is_empty());
    session.sensor_errors.free.push(error("bias_beta"));
    session.sensor_errors.random_walk.0.insert(error("scale_theta"), -1.0);
    let texts: Vec<String> = session::check(&session).iter().map(ToString::to_string).collect();
    for part in ["known of bias_beta", "listed as known and as free", "not listed as free", "random walk -1 must be"] {
        assert!(texts.iter().any(|line| line.contains(part)), "'{part}' is not in {texts:?}");
    }
}

#[test]
fn known_errors_of_sensors_are_taken_off_the_samples() {
    let error = |name: &str| SensorError::from_name(name).unwrap();
    let known = ErrorValues(
        [
            (error("bias_ax"), 0.5),
            (error("scale_ax"), 0.25),
            (error("misalignment_z"), 0.01),
            (error("scale_alpha"), 1.0),
        ]
        .into(),
    );
    let columns = [1.75, 2.0, 3.0, 0.0, 0.0, 0.0].map(|value| [value].into());
    let inputs = InputSeries { time_s: [0.0].into(), columns };
    let mut data = FilterData { inputs, measurements: Default::default() };
    let alpha = Measurement::AngleOfAttack as usize;
    data.measurements[alpha] = MeasurementSeries { time_s: [0.0].into(), values: [0.2].into() };
    known.correct(&mut data);
    // ax: (1.75 - 0.5) / 1.25 = 1; then s + e x s with e = (0, 0, 0.01).
    let [x, y, z] = [0, 1, 2].map(|axis| data.inputs.columns[axis][0]);
    assert!((x - 0.98).abs() < 1e-12 && (y - 2.01).abs() < 1e-12 && z == 3.0, "{x} {y} {z}");
    assert_eq!(data.measurements[alpha].values[..], [0.1]);
}

#[test]
fn every_shipped_session_opens() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions");
    let files = |folder: &std::path::Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut opened = 0;
    for path in files(&folder)
        .chain(files(&folder.join("reference")))
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
    {
        let session = session::open(&path).unwrap().session;
        assert!(session::check(&session).is_empty(), "{}", session.title);
        assert_eq!(session::parse(&session::print(&session).unwrap()).unwrap(), session);
        opened += 1;
    }
    assert_eq!(opened, 7);
}

#[test]
fn opens_session_v1_as_it_was_meant() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/sessions/v1");
    let open = |name: &str| session::open(&folder.join(name)).unwrap().session;
    for (name, flights, windows) in [
        ("demo", 1, 35),
        ("demo_thesis", 1, 35),
        ("attas", 1, 3),
        ("citation_aileron", 1, 1),
        ("phlab_short_period", 1, 1),
    ] {
        let session = open(&format!("{name}.toml"));
        assert!(session::check(&session).is_empty(), "{name}");
        assert_eq!((session.flights.len(), session.windows.len()), (flights, windows), "{name}");
        assert!(session::print(&session).unwrap().contains(&format!("version = {}", session::VERSION)));
    }
    // Version 2 meant the standard gravity where it named none; one of today asks the flight's place.
    let text = "format = \"doublet session\"\nversion = 2\ntitle = \"t\"\naircraft = \"a\"\n";
    let second = session::parse(text).unwrap();
    assert_eq!((second.gravity, second.filter.gravity_m_s2), (GravitySource::Stated, 9.806_65));
    let present = session::parse(&text.replace("version = 2", &format!("version = {}", session::VERSION))).unwrap();
    assert_eq!(present.gravity, GravitySource::Position);
    assert_eq!(session::parse(&session::print(&present).unwrap()).unwrap(), present);
    // Version 5 kept structures beside the experiments: each becomes one, with every other setting of the session.
    let kept = "[[estimation.constraint]]\ncoefficient = \"CZ\"\nterm = \"alpha\"\nfixed = -4.0\n[model]\nCm = [\"1\", \"alpha\"]\n[second_model]\nCZ = [\"1\", \"alpha\"]\n[[experiment]]\nname = \"short\"\n\
        [[kept_model]]\nname = \"short\"\n[kept_model.model]\nCm = [\"1\", \"qc/V\"]\n";
    let fifth = session::parse(&format!("{}{kept}", text.replace("version = 2", "version = 5"))).unwrap();
    let names: Vec<&str> = fifth.experiments.iter().map(|experiment| experiment.name.as_str()).collect();
    assert_eq!(names, ["short", "Structure B", "short 2"]);
    let models = |at: usize| fifth.experiments[at].configuration.structure.models.clone();
    let pitch = |factor: Variable| vec![(Coefficient::Cm, vec![Term::constant(), factor.into()])];
    assert_eq!(models(0), pitch(Variable::Alpha));
    assert_eq!(models(1), [(Coefficient::CZ, vec![Term::constant(), Variable::Alpha.into()])]);
    assert_eq!(models(2), pitch(Variable::PitchRate));
    let known = |at: usize| fifth.experiments[at].configuration.estimation.constraints.len();
    assert_eq!((fifth.estimation.constraints.len(), known(1), known(2)), (0, 1, 0), "what is known goes with its term");
    let present = Configuration::from_session(&fifth);
    let third = Configuration { structure: present.structure.clone(), ..(*fifth.experiments[2].configuration).clone() };
    assert_eq!(third, present, "all else is that of the session");
    assert_eq!(session::parse(&session::print(&fifth).unwrap()).unwrap(), fifth);
    // Nothing but a flight: every setting is what was usual when version 1 was.
    let bare = open("bare.toml");
    assert_eq!(bare.preparation.differentiation_half_width_s, Some(0.1));
    assert_eq!(bare.preparation.path, session::PathSource::Smoothed);
    assert!(!bare.preparation.correct_antenna, "version 1 did not");
    assert_eq!(bare.filter.measurement_noise[Measurement::Airspeed as usize], 0.2);
    assert_eq!(bare.filter.process_noise[Input::RollRate as usize], 0.005_f64.to_radians());
    assert_eq!(bare.filter.method, Method::Iekf { max_iterations: 10, tolerance: 1e-3 });
    assert_eq!(bare.structure, Structure::thesis());
    let sparse = open("sparse.toml"); // what it states stays
    assert_eq!(sparse.filter.measurement_noise[Measurement::Airspeed as usize], 0.7);
    assert_eq!(sparse.filter.measurement_noise[Measurement::Sideslip as usize], 0.1_f64.to_radians());
    assert_eq!(sparse.preparation.differentiation_half_width_s, None);
    assert_eq!(sparse.structure.models, [(Coefficient::CZ, vec![Term::constant(), Variable::Alpha.into()])]);
}

#[test]
fn session_rejects_what_it_does_not_know() {
    let text = session::print(&example()).unwrap();
    let message = |text: &str| session::parse(text).unwrap_err().to_string();
    let misspelt = message(&text.replace("gravity_m_s2", "gravty_m_s2"));
    assert!(misspelt.contains("gravty_m_s2") && misspelt.contains("line"), "{misspelt}");
    let newer = message(&text.replace(&format!("version = {}", session::VERSION), "version = 99"));
    assert!(newer.contains("99") && newer.contains("newer"), "{newer}");
    let other = message("format = \"something\"\nversion = 1\n");
    assert!(other.contains("something"), "{other}");
    let term = message(&text.replace("\"alpha\"", "\"alfa\""));
    assert!(term.contains("alfa"), "{term}");
    let state = message(&text.replace("bias_ax =", "bias_xx ="));
    assert!(state.contains("bias_xx") && state.contains("wind_down"), "{state}");
    let surface = message(&text.replace("\"elevator\"", "\"elevtor\""));
    assert!(surface.contains("elevtor") && surface.contains("rudder"), "{surface}");
}

#[test]
fn saving_keeps_the_previous_file_and_leaves_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let first = example();
    session::save(&first, &path).unwrap();
    let second = Edit::Title("second".to_owned()).apply(&first).unwrap();
    session::save(&second, &path).unwrap();
    assert_eq!(session::open(&path).unwrap().session, second);
    assert_eq!(session::open(&folder.path().join("s.toml.bak")).unwrap().session, first);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn check_names_the_field_of_every_problem() {
    let mut session = example();
    assert!(session::check(&session).is_empty());
    session.windows[1].name = "e1".to_owned();
    session.windows[0].flight = "two".to_owned();
    session.filter.measurement_noise[Measurement::AngleOfAttack as usize] = -1.0;
    session.preparation.settle_s = f64::NAN;
    let fields: Vec<_> = session::check(&session).into_iter().map(|finding| finding.place.to_string()).collect();
    assert_eq!(fields, ["manoeuvre 'e1'", "manoeuvre 'e1'", "filter.measurement_noise.alpha", "preparation.settle_s"]);
}

#[test]
fn edits_refuse_what_cannot_be() {
    let session = example();
    let refuse = |edit: Edit| edit.apply(&session).unwrap_err();
    assert_eq!(refuse(Edit::Window(WindowEdit::Remove("x".into()))), EditError::NoWindow("x".into()));
    let noise = Edit::noise(NoiseChannel::Input(Input::RollRate), f64::NAN);
    assert!(matches!(refuse(noise), EditError::Value { .. }));
    let empty = WindowEdit::Place { name: "e1".into(), window: TimeRange { start_s: 5.0, end_s: 5.0 } };
    assert!(matches!(refuse(Edit::Window(empty)), EditError::EmptyWindow { .. }));
    let taken = WindowEdit::Rename { from: "e1".into(), to: "e2".into() };
    assert_eq!(refuse(Edit::Window(taken)), EditError::WindowExists("e2".into()));
}

#[test]
fn a_drag_is_one_step_and_an_empty_one_is_none() {
    let mut history = History::new(example());
    let place =
        |start_s| Edit::Window(WindowEdit::Place { name: "e1".into(), window: TimeRange { start_s, end_s: 40.0 } });
    history.begin("move manoeuvre e1");
    (11..20).for_each(|start| history.apply(&place(f64::from(start))).unwrap());
    history.commit();
    assert_eq!(history.undo_label(), Some("move manoeuvre e1"));
    assert!(history.undo());
    assert_eq!(**history.present(), example());
    assert!(!history.is_modified());
    assert_eq!(history.undo_label(), None);
    assert_eq!(history.redo_label(), Some("move manoeuvre e1"));
    history.begin("nothing");
    history.commit();
    assert_eq!(history.redo_label(), Some("move manoeuvre e1"));
    assert!(history.redo());
    assert_eq!(history.present().window("e1").unwrap().window.start_s, 19.0);
}

fn any_edit() -> impl Strategy<Value = Edit> {
    let name = prop::sample::select(vec!["e1", "e2", "e3"]);
    let terms = [Variable::Alpha, Variable::PitchRate, Variable::Elevator].map(Term::from);
    let term = prop::sample::select([terms.as_slice(), &[Term::constant()]].concat());
    prop_oneof![
        ".{0,8}".prop_map(Edit::Title),
        (0..6_usize, -1.0..1.0_f64).prop_map(|(i, v)| Edit::noise(NoiseChannel::Input(Input::ALL[i]), v)),
        Just(Edit::Filter(FilterEdit::Method(Method::Ekf))),
        (0.1..3.0_f64).prop_map(|spread| Edit::Filter(FilterEdit::Method(Method::Ukf { spread }))),
        (0..5_usize, -0.1..1.0_f64).prop_map(|(i, v)| Edit::Filter(FilterEdit::AirDataDeviation(AirState::ALL[i], v))),
        (0..12_usize, -1.0..1.0).prop_map(|(i, v)| Edit::Filter(FilterEdit::MeasurementDelay(Measurement::ALL[i], v))),
        (0..9_usize).prop_map(|passes| Edit::Filter(FilterEdit::SmootherPasses(passes))),
        (3.0..9.0).prop_map(|limit| Edit::Filter(FilterEdit::OutlierLimit(limit))),
        (1.0..9.0).prop_map(|limit| Edit::Filter(FilterEdit::RobustLimit(limit))),
        (name.clone(), -10.0..50.0_f64).prop_map(|(name, start_s)| {
            Edit::Window(WindowEdit::Place { name: name.into(), window: TimeRange { start_s, end_s: 40.0 } })
        }),
        (name.clone(), name)
            .prop_map(|(from, to)| { Edit::Window(WindowEdit::Rename { from: from.into(), to: to.into() }) }),
        (term, any::<bool>(), 0..8_usize).prop_map(|(term, on, c)| {
            Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::ALL[c], term, on })
        }),
    ]
}

#[test]
fn constraints_are_stated_saved_checked_and_go_with_their_term() {
    use doublet_engine::session::{EstimationEdit, TermConstraint};
    let pitch = |known| TermConstraint { coefficient: Coefficient::Cm, term: Variable::PitchRate.into(), known };
    let stated = |known| Edit::Estimation(EstimationEdit::Constrain(pitch(known)));
    let bounds = |lower, upper| Constraint::Bounds { lower, upper };
    for (known, text) in [
        (Constraint::Fixed(-12.0), "fixed = -12.0"),
        (bounds(-20.0, f64::INFINITY), "lower = -20.0"),
        (bounds(-20.0, -4.0), "upper = -4.0"),
        (Constraint::Prior { mean: -12.0, deviation: 0.5 }, "deviation = 0.5"),
    ] {
        let plain = example();
        let session = stated(known).apply(&plain).unwrap();
        assert_eq!(session.estimation.constraints, [pitch(known)]);
        let saved = session::print(&session).unwrap();
        assert!(saved.contains("[[estimation.constraint]]\ncoefficient = \"Cm\"\nterm = \"qc/V\"\n"), "{saved}");
        assert!(saved.contains(text), "{saved}");
        assert_eq!(session::parse(&saved).unwrap(), session);
        assert_eq!(session::check(&session), session::check(&example()));
        assert_eq!(stated(Constraint::Free).apply(&session).unwrap(), plain);
        let term = Variable::PitchRate.into();
        let gone = Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::Cm, term, on: false });
        assert!(gone.apply(&session).unwrap().estimation.constraints.is_empty());
    }
    let refused = stated(bounds(-4.0, -20.0)).apply(&example()).unwrap_err();
    assert_eq!(refused.to_string(), "constraint of Cm_q cannot be -4: a lower bound below the upper one");
    assert!(stated(Constraint::Prior { mean: 1.0, deviation: 0.0 }).apply(&example()).is_err());
}

#[test]
fn constraints_that_cannot_be_are_named_in_one_line() {
    let saved = session::print(&example()).unwrap();
    let with = |constraint: &str| session::parse(&(saved.clone() + "\n[[estimation.constraint]]\n" + constraint));
    let error = |constraint: &str| with(constraint).unwrap_err().to_string();
    let unknown = error("coefficient = \"CM\"\nterm = \"alpha\"\nfixed = 1.0\n");
    assert!(unknown.contains("unknown coefficient 'CM'") && unknown.contains("Cm"), "{unknown}");
    let term = error("coefficient = \"Cm\"\nterm = \"gamma\"\nfixed = 1.0\n");
    assert!(term.starts_with("estimation.constraint of Cm 'gamma': ") && term.contains("alpha"), "{term}");
    let two = error("coefficient = \"Cm\"\nterm = \"alpha\"\nfixed = 1.0\nlower = 2.0\n");
    assert!(two.contains("state either `fixed`"), "{two}");
    let problem = |constraint: &str| session::check(&with(constraint).unwrap()).last().unwrap().to_string();
    assert_eq!(
        problem("coefficient = \"Cm\"\nterm = \"alpha\"\nlower = 2.0\nupper = 1.0\n"),
        "estimation.constraint of Cm_alpha: 2 is not allowed, expected a lower bound below the upper one: change it"
    );
    assert_eq!(
        problem("coefficient = \"Cm\"\nterm = \"alpha^2\"\nfixed = 1.0\n"),
        "estimation.constraint of Cm_alpha2: Cm has no term 'alpha^2': add the term or remove the constraint"
    );
}

#[test]
fn expressions_are_added_changed_and_removed_in_steps_that_can_be_undone() {
    let step = |from: Option<&str>, to: Option<ExpressionSetting>| {
        Edit::Expression(ExpressionEdit { flight: "one".to_owned(), from: from.map(str::to_owned), to })
    };
    let mut history = History::new(example());
    let names = |history: &History| {
        history.present().flights[0].expressions.iter().map(|made| made.name.clone()).collect::<Vec<_>>()
    };
    history.apply(&step(None, Some(expression("load factor", "-", "-az / g0")))).unwrap();
    assert_eq!(names(&history), ["ground speed", "corrected", "load factor"]);
    history.apply(&step(Some("load factor"), Some(expression("n_z", "-", "-az / g0")))).unwrap();
    assert_eq!(names(&history), ["ground speed", "corrected", "n_z"]);
    let refused = |edit: &Edit| edit.apply(history.present()).unwrap_err().to_string();
    assert_eq!(
        refused(&step(Some("ground speed"), None)),
        "expression 'corrected': at character 22: expression 'ground speed' not found above it: only earlier ones can be used"
    );
    assert_eq!(refused(&step(Some("n"), None)), "no expression is called 'n'");
    assert!(refused(&step(None, Some(expression("n_z", "-", "q")))).ends_with("the name is used twice: rename one"));
    history.apply(&step(Some("n_z"), None)).unwrap();
    assert_eq!(names(&history), ["ground speed", "corrected"]);
    assert!(history.undo() && history.undo() && history.undo());
    assert_eq!(**history.present(), example());
}

proptest! {
    #[test]
    fn edit_then_undo_restores_equality(edits in prop::collection::vec(any_edit(), 1..30)) {
        let mut history = History::new(example());
        let mut states = vec![example()];
        for edit in &edits {
            if history.apply(edit).is_ok() && **history.present() != *states.last().unwrap() {
                states.push((**history.present()).clone());
            }
        }
        let last = states.len() - 1;
        for state in states[..last].iter().rev() {
            prop_assert!(history.undo());
            prop_assert_eq!(&**history.present(), state);
        }
        prop_assert!(!history.undo());
        for state in &states[1..] {
            prop_assert!(history.redo());
            prop_assert_eq!(&**history.present(), state);
        }
        let text = session::print(history.present()).unwrap();
        prop_assert_eq!(&session::parse(&text).unwrap(), &**history.present());
    }
}

#[test]
fn map_made_by_hand_is_kept_in_the_session_and_reads_the_recording_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, "time,rate,nz\n0.0,10,1.0\n0.1,20,1.1\n0.2,30,0.9\n").unwrap();
    let quiet = |_: f32| {};
    let mut inspected = begin::inspect(&[path], &Control::default(), &quiet).unwrap();
    assert!(inspected.fitting.is_empty() && inspected.guess.row(Role::PitchRate).is_none());
    let from = ChannelName { source: "mine".to_owned(), channel: "rate".to_owned() };
    inspected.guess.set(Role::PitchRate, Some(ManualChannel::new(from, Unit::parse("deg/s").ok())));
    let plan = begin::plan_by_hand(&inspected.probes, &inspected.guess).unwrap();
    let map = MapRef::Own(inspected.guess.text().unwrap().into());
    let order = begin::Order { name: "mine".to_owned(), aircraft: Some("builtin:c337f".to_owned()), map };
    let made = begin::begin(&order, &inspected, &plan, &Control::default(), &quiet).unwrap();
    assert_eq!((made.windows.len(), made.windows[0].window), (1, TimeRange { start_s: 0.0, end_s: 0.2 }));
    let file = folder.path().join("s.toml");
    session::save(&made, &file).unwrap();
    let opened = session::open(&file).unwrap();
    assert_eq!(opened.session, session::relative_to(&made, folder.path()));
    assert_eq!(opened.session.flights[0].recordings[0].path, "mine.csv");
    let loaded = stage::read_flight(&Context::new(&opened.folder), &opened.session.flights[0].recordings).unwrap();
    let values = &loaded.recording.role(Role::PitchRate).unwrap().series.values;
    assert!((values[2] - 30.0_f64.to_radians()).abs() < 1e-15);
    let force = &loaded.recording.role(Role::SpecificForceZ).unwrap().series.values;
    assert!((force[1] + 1.1 * 9.806_65).abs() < 1e-12, "nz is upwards: its sign is turned");
    let missing = begin::missing(|role| loaded.recording.role(role).is_some());
    assert!(missing[0].level == Level::Bad && missing[0].roles.len() == 4, "ax, ay, p and r: {missing:?}");
    let bad = made.flights[0].recordings[0].clone();
    let bad = session::RecordingRef { channel_map: MapRef::Own("format = 1".into()), ..bad };
    let line = stage::read_flight(&Context::new(&opened.folder), &[bad]).unwrap_err().to_string();
    assert!(line.contains("channel map of the session"), "{line}");
}

#[test]
fn aircraft_that_come_with_the_program_all_load() {
    let names = doublet_engine::builtin::aircraft();
    assert!(names.contains(&"c337f") && !names.contains(&"c337f_truth") && !names.contains(&"c337f_instruments"));
    for name in names {
        stage::load_aircraft(&Context::new(std::path::Path::new(".")), &format!("builtin:{name}")).unwrap();
    }
}

#[test]
fn plain_aircraft_is_an_aircraft_file_and_one_that_cannot_be_is_refused() {
    let plain = begin::PlainAircraft {
        name: "my \"glider\"".to_owned(),
        area_m2: 10.5,
        span_m: 15.0,
        chord_m: 0.7,
        mass_kg: 450.0,
        moments_kg_m2: [900.0, 700.0, 1550.0],
        xz_kg_m2: 40.0,
        note: None,
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), plain.text().unwrap()).unwrap();
    let loaded = stage::load_aircraft(&Context::new(folder.path()), "a.toml").unwrap();
    assert_eq!(loaded.aircraft.name, plain.name);
    assert_eq!((loaded.aircraft.reference.area_m2, loaded.aircraft.reference.span_m), (10.5, 15.0));
    let refused = |change: fn(&mut begin::PlainAircraft)| {
        let mut wrong = plain.clone();
        change(&mut wrong);
        wrong.text().unwrap_err()
    };
    assert!(refused(|a| a.mass_kg = 0.0).contains("mass"));
    assert!(refused(|a| a.moments_kg_m2[2] = 5000.0).to_lowercase().contains("inertia"));
}

#[test]
fn inertia_of_a_class_is_near_that_of_aircraft_of_the_class() {
    use doublet_core::airframe::AircraftClass;
    // Length of the aircraft, m, whose file gives their inertia: Boeing 747, Lockheed JetStar, Navion.
    for (name, class, length_m) in [
        ("boeing_747", AircraftClass::FourWingJets, 70.5),
        ("lockheed_jetstar", AircraftClass::FuselageJets, 18.4),
        ("navion", AircraftClass::SinglePropeller, 8.4),
    ] {
        let loaded =
            stage::load_aircraft(&Context::new(std::path::Path::new(".")), &format!("builtin:{name}")).unwrap();
        let aircraft = &loaded.aircraft;
        let mass = aircraft.standard_loading.mass_properties(aircraft);
        let known = mass.inertia.matrix();
        let estimated = class.radii(length_m).inertia(mass.mass_kg, aircraft.reference.span_m).matrix();
        for axis in 0..3 {
            let ratio = known[(axis, axis)] / estimated[(axis, axis)];
            // What the note in the file says of the estimate.
            let range = if axis == 0 { 0.7..2.45 } else { 0.95..1.45 };
            assert!(range.contains(&ratio), "{name} axis {axis}: {ratio}");
        }
    }
}

#[test]
fn note_on_a_window_is_one_step_of_undo_and_left_out_of_the_file_where_there_is_none() {
    let mut history = History::new(Session { report_notes: String::new(), ..example() });
    let before = session::print(history.present()).unwrap();
    assert!(!before.contains("note"), "a session without notes reads as it always did");
    let note = Edit::Window(WindowEdit::Note { name: "e2".to_owned(), note: "rough air".to_owned() });
    history.apply(&note).unwrap();
    assert_eq!(history.undo_label(), Some("change note on manoeuvre e2"));
    assert_eq!(history.present().windows[1].note, "rough air");
    assert_eq!(history.present().windows[0].note, "");
    let text = session::print(history.present()).unwrap();
    assert!(text.contains("note = \"rough air\"\n"), "{text}");
    history.undo();
    assert_eq!(session::print(history.present()).unwrap(), before);
    let nowhere = Edit::Window(WindowEdit::Note { name: "e9".to_owned(), note: String::new() });
    assert_eq!(nowhere.apply(&example()), Err(EditError::NoWindow("e9".to_owned())));
}

#[test]
fn lock_of_a_window_is_saved_only_where_there_is_one_and_does_not_refuse_a_typed_edge() {
    let mut history = History::new(example());
    let before = session::print(history.present()).unwrap();
    assert!(!before.contains("locked"), "a session without locks reads as it always did");
    let lock = |on| Edit::Window(WindowEdit::Flag { name: "e1".to_owned(), flag: WindowFlag::Locked, on });
    history.apply(&lock(true)).unwrap();
    assert_eq!(history.undo_label(), Some("lock manoeuvre e1"));
    let text = session::print(history.present()).unwrap();
    assert_eq!(text.matches("locked = true\n").count(), 1, "{text}");
    assert_eq!(session::parse(&text).unwrap(), **history.present());
    let misspelt = session::parse(&text.replace("locked = true", "lokced = true")).unwrap_err().to_string();
    assert!(misspelt.contains("lokced"), "{misspelt}");
    let window = TimeRange { start_s: 11.0, end_s: 29.0 };
    history.apply(&Edit::Window(WindowEdit::Place { name: "e1".to_owned(), window })).unwrap();
    assert_eq!(history.present().windows[0].window, window);
    history.undo();
    history.apply(&lock(false)).unwrap();
    assert_eq!(history.undo_label(), Some("unlock manoeuvre e1"));
    assert_eq!(session::print(history.present()).unwrap(), before);
}
