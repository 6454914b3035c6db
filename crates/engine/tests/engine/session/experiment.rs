//! Experiments of a session: kept, saved as what differs, made current.

use super::*;

#[test]
fn experiments_are_kept_saved_as_what_differs_and_taken_up_in_one_step() {
    let keep = |name: &str| Edit::Experiment(ExperimentEdit::Keep(name.to_owned()));
    let apply = |session: &Session, edits: &[Edit]| {
        edits.iter().fold(session.clone(), |session, edit| edit.apply(&session).unwrap())
    };
    // Kept with a delay of a measurement, a term and a manoeuvre that the session then has no more.
    let delay = |seconds| Edit::Filter(FilterEdit::MeasurementDelay(Measurement::AngleOfAttack, seconds));
    let term = |on| {
        let term = Term::parse("alpha*delta_e").unwrap();
        Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::Cm, term, on })
    };
    let role = |role| Edit::Window(WindowEdit::Role { name: "e2".to_owned(), role });
    let kept = [delay(0.1), term(true), keep("first")];
    let changed = [delay(0.0), term(false), role(WindowRole::Ignored), Edit::Filter(FilterEdit::Method(Method::Ekf))];
    let session = apply(&example(), &[kept.as_slice(), &changed, &[keep("second")]].concat());
    let text = session::print(&session).unwrap();
    assert_eq!(session::parse(&text).unwrap(), session);
    let experiments: Vec<&str> = text.split("[[experiment]]").skip(1).collect();
    assert!(experiments[0].contains("measurement_delay_s") && !experiments[0].contains("process_noise"), "{text}");
    assert_eq!(experiments[1].split("[[").next().unwrap().trim(), "name = \"second\"", "nothing differs");
    let before = apply(&example(), &kept);
    let after = apply(&session, &[Edit::Experiment(ExperimentEdit::Apply("first".to_owned()))]);
    assert_eq!(Session { experiments: Vec::new(), ..after }, Session { experiments: Vec::new(), ..before });
    // The manoeuvre goes by its new name, one marked later is used as it is marked.
    let later = Manoeuvre { name: "e9".to_owned(), ..session.windows[0].clone() };
    let rename = WindowEdit::Rename { from: "e2".to_owned(), to: "gust".to_owned() };
    let renamed = apply(&session, &[Edit::Window(rename), Edit::Window(WindowEdit::Add(later))]);
    let first = &renamed.experiment("first").unwrap().configuration;
    let uses: Vec<_> = first.manoeuvres.iter().map(|used| (used.name.as_str(), used.role)).collect();
    let identification = WindowRole::Identification;
    assert_eq!(uses, ["e1", "gust", "e9"].map(|name| (name, identification)));
    let text = session::print(&renamed).unwrap();
    assert_eq!(session::parse(&text).unwrap(), renamed);
    for refused in [
        ExperimentEdit::Keep(" ".to_owned()),
        ExperimentEdit::Apply("third".to_owned()),
        ExperimentEdit::Rename { from: "first".to_owned(), to: "second".to_owned() },
    ] {
        assert!(Edit::Experiment(refused.clone()).apply(&session).is_err(), "{refused:?}");
    }
}

#[test]
fn a_kept_experiment_stays_through_undo_and_redo_of_older_edits() {
    let mut history = History::new(example());
    let names = |history: &History| -> Vec<String> {
        history.present().experiments.iter().map(|experiment| experiment.name.clone()).collect()
    };
    let method = |method| Edit::Filter(FilterEdit::Method(method));
    history.apply(&method(Method::Ekf)).unwrap();
    let later = Manoeuvre { name: "e9".to_owned(), ..example().windows[0].clone() };
    history.apply(&Edit::Window(WindowEdit::Add(later))).unwrap();
    assert!(history.undo());
    history.apply(&Edit::Experiment(ExperimentEdit::Keep("kept".to_owned()))).unwrap();
    let (steps, done) = history.steps();
    assert_eq!((steps.len(), done), (2, 1), "no step of its own");
    for (done, windows) in [(0, 2), (2, 3), (1, 2)] {
        history.go_to(done);
        assert_eq!(names(&history), ["kept"], "after {done} steps");
        let kept = &history.present().experiments[0].configuration;
        assert_eq!((kept.filter.method, kept.manoeuvres.len()), (Method::Ekf, windows), "after {done} steps");
    }
    let removed = Edit::Experiment(ExperimentEdit::Drop("kept".to_owned()));
    history.apply(&removed).unwrap();
    assert_eq!(names(&history), [""; 0]);
    assert!(history.undo());
    assert_eq!(names(&history), ["kept"], "its removal is a step");
}
