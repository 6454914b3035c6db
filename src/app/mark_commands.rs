//! Carries out the commands that mark manoeuvres: at the time a menu was opened on, else under the pointer, else at marker A.

use doublet_core::quantity::Role;
use doublet_core::series::TimeRange;
use doublet_engine::session::{CandidateEdit, Edit, Manoeuvre, Surface, WindowEdit, WindowFlag};
use doublet_engine::stage::open_windows;

use super::Workbench;
use crate::command::MarkCommand;
use crate::panels;
use crate::widgets::span_editor::snapped;

/// Carries out one command; `menu_s`: the time its menu was opened on, s.
pub fn mark(app: &mut Workbench, command: MarkCommand, menu_s: Option<f64>) {
    let at_s = menu_s.or(app.state.time.cursor_s).or(app.state.time.markers_s[0]);
    match command {
        MarkCommand::NewShown => new_shown(app),
        MarkCommand::Accept => accept(app),
        MarkCommand::Refuse => refuse(app),
        MarkCommand::NextCandidate => next(app),
        MarkCommand::ShowRefused => offer_refused(app),
        command => match chosen(app) {
            Some(window) => apply_to_chosen(app, command, &window, at_s),
            None => app.complain("Choose a manoeuvre first."),
        },
    }
}

fn chosen(app: &Workbench) -> Option<Manoeuvre> {
    app.document.session().window(app.state.selection.window.as_deref()?).cloned()
}

/// What is done to the chosen manoeuvre.
fn apply_to_chosen(app: &mut Workbench, command: MarkCommand, window: &Manoeuvre, at_s: Option<f64>) {
    match command {
        MarkCommand::Exclude => exclude(app, window),
        MarkCommand::Include => include(app, window, at_s),
        MarkCommand::Surface(surface) => surfaces(app, surface),
        MarkCommand::Note => app.state.noting = Some((window.name.clone(), window.note.clone())),
        MarkCommand::Lock => {
            let (name, on) = (window.name.clone(), !window.flags.locked);
            app.apply(&Edit::Window(WindowEdit::Flag { name, flag: WindowFlag::Locked, on }));
        }
        _ => match at_s {
            Some(at_s) => at_time(app, command, window, at_s),
            None => app.complain("Point at a plot, or set marker A (key A) first."),
        },
    }
}

/// What needs a time: moves an edge there, or splits.
fn at_time(app: &mut Workbench, command: MarkCommand, window: &Manoeuvre, at_s: f64) {
    if window.flags.locked {
        return app.complain(format!("The edges of {} are locked: unlock them first.", window.name));
    }
    let samples_s = samples(app, &window.flight);
    let at_s = snapped(&samples_s, at_s);
    let (name, TimeRange { start_s, end_s }) = (window.name.clone(), window.window);
    let edit = match command {
        MarkCommand::StartHere if at_s < end_s => {
            WindowEdit::Place { name, window: TimeRange { start_s: at_s, end_s } }
        }
        MarkCommand::EndHere if at_s > start_s => {
            WindowEdit::Place { name, window: TimeRange { start_s, end_s: at_s } }
        }
        MarkCommand::Split if at_s > start_s && at_s < end_s => {
            let next = samples_s.get(samples_s.partition_point(|&time_s| time_s <= at_s)).copied();
            let second = free_name(app, &name);
            WindowEdit::Split { name, end_s: at_s, start_s: next.unwrap_or(at_s).min(end_s), second }
        }
        MarkCommand::StartHere => {
            return app.complain(format!("The start must be before the end of {name}, {end_s:.2} s."));
        }
        MarkCommand::EndHere => {
            return app.complain(format!("The end must be after the start of {name}, {start_s:.2} s."));
        }
        _ => return app.complain(format!("{name} can only be split inside: {start_s:.2} s to {end_s:.2} s.")),
    };
    app.apply(&Edit::Window(edit));
}

/// Times of the inertial samples of a flight, s.
fn samples(app: &Workbench, flight: &str) -> std::sync::Arc<[f64]> {
    let loaded = app.snapshot().flights.get(flight).and_then(|slot| slot.latest());
    let rate = loaded.and_then(|loaded| loaded.recording.role(Role::RollRate));
    rate.map_or_else(Default::default, |channel| channel.series.time_s.clone())
}

/// A name like `name` that no manoeuvre has.
fn free_name(app: &Workbench, name: &str) -> String {
    let session = app.document.session();
    let names = (2..).map(|number| format!("{name} ({number})"));
    names.into_iter().find(|name| session.window(name).is_none()).unwrap_or_default()
}

/// Leaves out what lies between the markers.
fn exclude(app: &mut Workbench, window: &Manoeuvre) {
    let between = [&app.state.window_time, &app.state.time].into_iter().find_map(|view| match view.markers_s {
        [Some(a), Some(b)] => window.excluded_with(TimeRange::new(a, b)),
        _ => None,
    });
    match between {
        Some(excluded) => app.apply(&Edit::Window(WindowEdit::Exclude { name: window.name.clone(), excluded })),
        None => app.complain(format!(
            "Set markers A and B inside {} first (keys A and B), then press E. Or drag there with Alt.",
            window.name
        )),
    }
}

/// Takes the excluded part at a time in again; all of them where there is none.
fn include(app: &mut Workbench, window: &Manoeuvre, at_s: Option<f64>) {
    if window.excluded.is_empty() {
        return app.complain(format!("{} has no excluded parts.", window.name));
    }
    let here = at_s.and_then(|at_s| window.excluded_at(at_s));
    let excluded = here.map_or_else(Vec::new, |here| window.excluded_without(here));
    app.apply(&Edit::Window(WindowEdit::Exclude { name: window.name.clone(), excluded }));
}

/// States the surface of every selected manoeuvre in one step of undo.
fn surfaces(app: &mut Workbench, surface: Option<Surface>) {
    super::dispatch::each_selected(app, "set surface of", |name| WindowEdit::Surface { name, surface });
}

/// A manoeuvre of all that is on screen.
fn new_shown(app: &mut Workbench) {
    let Some(flight) = app.state.selection.flight.clone() else { return };
    let TimeRange { start_s, end_s } = app.state.time.range();
    let samples_s = samples(app, &flight);
    let shown = TimeRange::new(snapped(&samples_s, start_s), snapped(&samples_s, end_s));
    add(app, panels::new_window(app.document.session(), flight, shown));
}

/// Adds a manoeuvre and chooses it.
fn add(app: &mut Workbench, window: Manoeuvre) {
    let name = window.name.clone();
    app.apply(&Edit::Window(WindowEdit::Add(window)));
    let session = app.document.session().clone();
    panels::choose(&mut app.state, &session, &name);
}

/// The candidates of the flight on screen that were neither accepted nor refused, in the order of time.
fn candidates(app: &Workbench) -> Vec<Manoeuvre> {
    let flight = app.state.selection.flight.clone().unwrap_or_default();
    let found = app.snapshot().proposals.get(&flight).and_then(|slot| slot.latest());
    let mut open = found.map(|found| open_windows(app.document.session(), found)).unwrap_or_default();
    open.sort_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s));
    open
}

/// The candidate that is asked about, where it is on screen; the next one is brought there otherwise.
fn find_or_reveal_candidate(app: &mut Workbench) -> Option<Manoeuvre> {
    let open = candidates(app);
    let range = app.state.time.range();
    let shown = open.iter().filter(|one| overlaps(one.window, range));
    if let Some(shown) = app.state.candidate_of(shown) {
        return Some(shown.clone());
    }
    next(app);
    None
}

fn overlaps(one: TimeRange, other: TimeRange) -> bool {
    one.start_s < other.end_s && one.end_s > other.start_s
}

/// Brings the next candidate on screen; the first behind the last.
fn next(app: &mut Workbench) {
    let open = candidates(app);
    let range = app.state.time.range();
    let seen = app.state.candidate_of(open.iter().filter(|one| overlaps(one.window, range)));
    let from_s = seen.map_or(app.state.candidate_s.unwrap_or(range.start_s), |seen| seen.window.start_s);
    let behind = open.iter().find(|one| one.window.start_s > from_s).or(open.first());
    match behind.map(|one| one.window) {
        Some(window) => {
            app.state.candidate_s = Some(window.start_s);
            app.state.time.reveal(window);
        }
        None => app.complain("No candidates left: all found manoeuvres are accepted or refused."),
    }
}

fn accept(app: &mut Workbench) {
    let Some(candidate) = find_or_reveal_candidate(app) else { return };
    let at_s = candidate.window.start_s;
    add(app, candidate);
    follow(app, at_s);
}

fn refuse(app: &mut Workbench) {
    let Some(candidate) = find_or_reveal_candidate(app) else { return };
    let at_s = candidate.window.start_s;
    app.apply(&Edit::Candidate(CandidateEdit::Refuse(vec![candidate])));
    follow(app, at_s);
}

fn offer_refused(app: &mut Workbench) {
    if app.document.session().refused.is_empty() {
        return app.complain("No candidate is refused.");
    }
    app.apply(&Edit::Candidate(CandidateEdit::Offer(None)));
}

/// Goes on to the candidate behind a time, where one is left.
fn follow(app: &mut Workbench, at_s: f64) {
    app.state.candidate_s = Some(at_s);
    let open = candidates(app);
    let behind = open.iter().find(|one| one.window.start_s > at_s).or(open.first());
    if let Some(window) = behind.map(|one| one.window) {
        app.state.candidate_s = Some(window.start_s);
        app.state.time.reveal(window);
    }
}
