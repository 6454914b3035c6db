//! What is wrong with a session before anything is computed.

use doublet_core::series::Window;

use super::{Session, constraint, expression, preparation};

/// A finding, bound to the field it concerns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Dotted name of the field, for example `window 'e1'` or `filter.measurement_noise.alpha`.
    pub field: String,
    /// What is wrong and what to do, one line.
    pub message: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.field, self.message)
    }
}

/// Everything in the session that would stop a run, found without reading a recording.
pub fn check(session: &Session) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut report = |field: String, message: String| problems.push(Problem { field, message });
    if session.flights.is_empty() {
        report(
            "flight".to_owned(),
            "the session has no recording: add a [[flight]] with a [[flight.recording]]".into(),
        );
    }
    for (index, flight) in session.flights.iter().enumerate() {
        if session.flights[..index].iter().any(|other| other.name == flight.name) {
            report(format!("flight '{}'", flight.name), "the name is used twice: rename one".into());
        }
        if flight.recordings.is_empty() {
            report(format!("flight '{}'", flight.name), "it has no recording: add a [[flight.recording]]".into());
        }
    }
    for flight in &session.flights {
        for problem in flight.signals.problems() {
            report(format!("signals of flight '{}'", flight.name), problem);
        }
        for (name, problem) in expression::problems(&flight.expressions) {
            report(format!("expression '{name}' of flight '{}'", flight.name), problem);
        }
        for clock in flight.clocks.iter().filter(|clock| !clock.shift_s.is_finite()) {
            report(format!("clock of '{}'", clock.source), format!("shift_s is {}: give a number", clock.shift_s));
        }
    }
    for steady in &session.steady {
        let Window { start_s, end_s } = steady.window;
        if session.flight(&steady.flight).is_none() {
            let message = format!("it lies in flight '{}', which the session does not have", steady.flight);
            report("steady".to_owned(), message);
        }
        if !(start_s.is_finite() && end_s.is_finite() && end_s > start_s) {
            report(
                "steady".to_owned(),
                format!("from {start_s} s to {end_s} s it is empty: let it end after it starts"),
            );
        }
    }
    for (index, window) in session.windows.iter().enumerate() {
        let field = format!("window '{}'", window.name);
        if session.windows[..index].iter().any(|other| other.name == window.name) {
            report(field.clone(), "the name is used twice: rename one".into());
        }
        if session.flight(&window.flight).is_none() {
            report(field.clone(), format!("it lies in flight '{}', which the session does not have", window.flight));
        }
        let (start, end) = (window.window.start_s, window.window.end_s);
        if !(start.is_finite() && end.is_finite() && end > start) {
            report(field, format!("from {start} s to {end} s it is empty: let it end after it starts"));
        }
    }
    for (name, range) in &session.plausible {
        if range.low.is_nan() || range.high.is_nan() || range.low >= range.high {
            let message = format!("from {} to {} it is empty: let high be above low", range.low, range.high);
            report(format!("verdict.plausible.{name}"), message);
        }
    }
    if let Err(errors) = session.filter.check() {
        for error in errors {
            report(format!("filter.{}", error.field), format!("{} is outside {}", error.value, error.allowed));
        }
    }
    problems.extend(preparation::problems(&session.preparation));
    problems.extend(constraint::problems(session));
    problems
}
