//! What is wrong with a session before anything is computed.

use std::collections::BTreeSet;

use doublet_core::message::Message;
use doublet_core::quantity::in_words;
use doublet_core::series::TimeRange;

use super::{Edit, Fix, Session, WindowEdit, constraint, expression, preparation, sensor_errors};
use crate::notation;
use crate::session::{Finding, Level, Place};

/// Code of what makes the session contradict itself: nothing can be computed from it.
const CONTRADICTION: &str = "session";
/// Code of what is wrong with one flight.
const FLIGHT: &str = "flight";
/// Code of what is wrong with one window.
const WINDOW: &str = "window";
/// Place of findings about the steady windows.
pub(crate) const STEADY: &str = "steady";
/// Longest name, in characters: names are parts of paths in the files of results.
const LONGEST_NAME: usize = 200;

/// Most windows of one session: more are a slip of a script, and their results would fill the memory.
pub const MOST_WINDOWS: usize = 10_000;

/// A finding that stops the whole run.
pub(super) fn contradiction(place: String, text: impl Into<Message>, fix_text: &str) -> Finding {
    Finding::new(Level::Bad, CONTRADICTION, place, text).with_fix_text(fix_text)
}

/// Whether a finding of [`check`] leaves nothing to compute; the others cost the run the window or flight they name.
pub fn stops_run(finding: &Finding) -> bool {
    finding.code == CONTRADICTION
}

/// Everything wrong in the session that can be found without reading a recording.
pub fn check(session: &Session) -> Vec<Finding> {
    let mut found = Vec::new();
    if session.flights.is_empty() {
        let fix_text = "add a flight with a recording";
        found.push(contradiction("flight".to_owned(), "the session has no recording", fix_text));
    }
    if session.windows.len() > MOST_WINDOWS {
        let text = format!("the session has {} manoeuvres (limit {MOST_WINDOWS})", session.windows.len());
        found.push(contradiction("window".to_owned(), text, "split it into several sessions and run them as a batch"));
        return found;
    }
    names("flight", session.flights.iter().map(|flight| flight.name.as_str()), &mut found);
    names("manoeuvre", session.windows.iter().map(|window| window.name.as_str()), &mut found);
    found.extend(unfit("title", &session.title));
    let logs = session.flights.iter().flat_map(|flight| [("date", &flight.date), ("crew", &flight.crew)]);
    found.extend(logs.filter_map(|(kind, text)| unfit(kind, text)));
    flights(session, &mut found);
    windows(session, &mut found);
    for (name, range) in &session.plausible {
        if range.low.is_nan() || range.high.is_nan() || range.low >= range.high {
            let text = format!("lower limit {} is not below upper limit {}", range.low, range.high);
            found.push(contradiction(format!("verdict.plausible.{name}"), text, "set low below high"));
        }
    }
    for error in session.filter.check().err().into_iter().flatten() {
        let field = format!("filter.{}", error.field);
        let text = format!("{} is outside {}", in_words(error.value), error.allowed);
        found.push(
            contradiction(field.clone(), text, "enter a value inside the range")
                .with_setting("Noise and filter", field),
        );
    }
    found.extend(preparation::findings(&session.preparation));
    found.extend(constraint::findings(session));
    found.extend(sensor_errors::findings(session));
    found
}

/// Names that are empty, too long or used twice.
fn names<'a>(kind: &str, all: impl Iterator<Item = &'a str>, found: &mut Vec<Finding>) {
    let mut seen = BTreeSet::new();
    for name in all {
        let place = format!("{kind} '{name}'");
        if name.trim().is_empty() {
            found.push(contradiction(place, "the name is empty", "enter a name"));
        } else if let Some(finding) = unfit(kind, name) {
            found.push(finding);
        } else if !seen.insert(name) {
            found.push(contradiction(place, "the name is used twice", "rename one"));
        }
    }
}

/// Whether a name suits the files of results.
pub(super) fn name_fits(kind: &str, name: &str) -> Result<(), String> {
    unfit(kind, name).map_or(Ok(()), |finding| Err(finding.to_string()))
}

/// Whether no name may hold a character.
fn is_unfit(letter: char) -> bool {
    letter.is_control() || notation::is_direction_mark(letter)
}

/// A name without what no name may hold, and as long as one may be.
pub fn fitting_name(name: &str) -> String {
    name.chars().filter(|letter| !is_unfit(*letter)).take(LONGEST_NAME).collect()
}

/// Why a name does not suit the files of results: too long for a path, or with a character that no document holds or that changes the
/// direction of the text behind it.
fn unfit(kind: &str, name: &str) -> Option<Finding> {
    if let Some((place, letter)) = name.chars().enumerate().find(|(_, letter)| is_unfit(*letter)) {
        let text =
            format!("character {} (U+{:04X}) is not allowed in reports and exports", place + 1, u32::from(letter));
        return Some(contradiction(kind.to_owned(), text, "remove it"));
    }
    let characters = name.chars().count();
    (characters > LONGEST_NAME).then(|| {
        let beginning: String = name.chars().take(40).collect();
        let text = format!("'{beginning}...' has {characters} characters");
        contradiction(kind.to_owned(), text, &format!("use at most {LONGEST_NAME}"))
    })
}

fn flights(session: &Session, found: &mut Vec<Finding>) {
    for flight in &session.flights {
        let name = &flight.name;
        let mut report = |place: Place, text: &str| found.push(Finding::new(Level::Bad, FLIGHT, place, text));
        if flight.recordings.is_empty() {
            report(Place::flight(name), "no recording: add one");
        }
        for problem in flight.signals.problems() {
            report(format!("signals of flight '{name}'").into(), &problem);
        }
        for (expression, problem) in expression::problems(&flight.expressions) {
            report(format!("expression '{expression}' of flight '{name}'").into(), &problem);
        }
        for clock in flight.clocks.iter().filter(|clock| !clock.shift_s.is_finite()) {
            let text = format!("clock offset is {}: enter a number", clock.shift_s);
            report(format!("clock of '{}'", clock.source).into(), &text);
        }
    }
}

/// Whether a range has a length.
fn is_usable(TimeRange { start_s, end_s }: &TimeRange) -> bool {
    start_s.is_finite() && end_s.is_finite() && end_s > start_s
}

fn windows(session: &Session, found: &mut Vec<Finding>) {
    let steady = session.steady.iter().map(|steady| (Place::from(STEADY), &steady.flight, steady.window, None));
    let windows = session
        .windows
        .iter()
        .map(|window| (Place::manoeuvre(&window.name), &window.flight, window.window, Some(&window.name)));
    for (place, flight, TimeRange { start_s, end_s }, name) in steady.chain(windows) {
        if session.flight(flight).is_none() {
            let text = format!("flight '{flight}' not found in the session");
            let fix_text = "choose a flight of the session";
            found.push(Finding::new(Level::Bad, WINDOW, place.clone(), text).with_fix_text(fix_text));
        }
        if !is_usable(&TimeRange { start_s, end_s }) {
            let text = format!("end {end_s} s is not after start {start_s} s");
            let finding = Finding::new(Level::Bad, WINDOW, place, text).with_fix_text("set its end after its start");
            let fix = name.filter(|_| end_s < start_s && (end_s - start_s).is_finite()).map(|name| {
                let (name, window) = (name.clone(), TimeRange { start_s: end_s, end_s: start_s });
                let label = format!("exchange start and end of '{name}'");
                Fix::new(label, Edit::Window(WindowEdit::Place { name, window }))
            });
            found.push(finding.with_setting("Manoeuvres", "").with_fix(fix));
        }
    }
    for window in &session.windows {
        for part @ TimeRange { start_s, end_s } in &window.excluded {
            if !is_usable(part) {
                let place = Place::manoeuvre(&window.name);
                let text = format!("excluded part: end {end_s} s is not after start {start_s} s");
                let finding =
                    Finding::new(Level::Bad, WINDOW, place, text).with_fix_text("set its end after its start");
                let excluded = window.excluded.iter().filter(|part| is_usable(part)).copied().collect();
                let edit = Edit::Window(WindowEdit::Exclude { name: window.name.clone(), excluded });
                let fix = Fix::new(format!("remove the empty excluded parts of '{}'", window.name), edit);
                found.push(finding.with_setting("Manoeuvres", "").with_fix(fix));
            }
        }
    }
}
