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
