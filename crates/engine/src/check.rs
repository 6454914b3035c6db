//! What stands against a session before its results are judged: what a run would refuse, and channels that contradict each other.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Once;

use doublet_core::airframe::summary;
use doublet_core::load::aircraft::{self as aircraft_file, AircraftFileError};
use serde::Serialize;

use crate::begin::{Apart, find_apart};
use crate::graph::{Cache, Context, Control};
use crate::notation::plural;
use crate::run::{Scope, run};
use crate::session::{self, Edit, Finding, Fix, Level, Manoeuvre, Place, Session, WindowEdit};
use crate::snapshot::Snapshot;
use crate::stage::{self, PhysicsRow};
use crate::verdict::{accelerometer, mounting, shape};

/// Memory for intermediate results of a check.
const CACHE_BYTES: usize = 1 << 30;
/// Most windows that a check computes. Of the others it looks at the samples alone.
const MOST_COMPUTED: usize = 200;

/// What a check of a session or an aircraft file found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Checked {
    /// What was checked, for a reader: the content of a session in one line, of an aircraft in a table.
    #[serde(skip)]
    pub subject: String,
    /// Everything found, worst first.
    pub findings: Vec<Finding>,
    /// Channels against what the others say they should be.
    pub physics: Vec<PhysicsRow>,
}

impl Checked {
    /// The worst of everything found.
    pub fn level(&self) -> Level {
        let findings = self.findings.iter().map(|finding| finding.level);
        findings.chain(self.physics.iter().map(|row| row.level)).max().unwrap_or_default()
    }

    /// A check that ended with one thing.
    fn refused(finding: Finding) -> Self {
        Self { findings: vec![finding], ..Self::default() }
    }

    fn sorted(mut self) -> Self {
        self.findings.sort_by_key(|finding| std::cmp::Reverse(finding.level));
        self
    }
}

/// Checks a session or an aircraft file. A file that cannot be used is a finding as well. `warn` is told of a lack of memory before the
/// manoeuvres are computed.
pub fn check_file(path: &Path, warn: &(dyn Fn(&Finding) + Sync)) -> Checked {
    let refused = |code, text: String, fix_text: &str| {
        Checked::refused(Finding::new(Level::Bad, code, path.display().to_string(), text).with_fix_text(fix_text))
    };
    if session::shipped(path).is_some() {
        return match session::open(path) {
            Ok(opened) => check_session(&opened.session, &opened.folder, warn),
            Err(error) => refused("file", error.to_string(), "choose one of these, or a file"),
        };
    }
    let text = match doublet_core::load::read_bytes(path).map(String::from_utf8) {
        Err(error) => return refused("file", error.to_string(), "give a session or an aircraft file"),
        Ok(Err(_)) => {
            return refused(
                "file",
                "this is a binary file, not a session or an aircraft file".to_owned(),
                "make a session from a recording with `doublet new`",
            );
        }
        Ok(Ok(text)) => text,
    };
    let text = text.trim_start_matches('\u{feff}');
    if text.trim().is_empty() {
        let fix_text = "open another file, or its .bak beside it";
        return refused("file", "the file is empty: not a session or an aircraft file".to_owned(), fix_text);
    }
    if has_format(text, aircraft_file::FORMAT) {
        return check_aircraft(path, text);
    }
    match session::parse(text) {
        Ok(session) => {
            let folder = path.parent().unwrap_or(Path::new(""));
            check_session(&session::relative_to(&session, folder), folder, warn)
        }
        Err(error) => refused("file", error.to_string(), "correct it"),
    }
}

fn has_format(text: &str, format: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with("format") && line.contains(format))
}

/// Everything found in a session whose relative paths start from `folder`: what [`session::check`] says, what its recordings say,
/// and, because nothing less finds all that a run would refuse, what fails in a run of it. `warn`: as for [`check_file`].
pub fn check_session(session: &Session, folder: &Path, warn: &(dyn Fn(&Finding) + Sync)) -> Checked {
    let mut findings = session::check(session);
    if let Some(text) = session::path_warning(session) {
        findings.push(Finding::new(Level::Caution, "outside-folder", "session", text));
    }
    if session.aircraft.is_none() {
        findings.push(Finding::new(Level::Caution, "no-aircraft", "session", stage::NO_AIRCRAFT));
    }
    let mut physics = Vec::new();
    if !findings.iter().any(session::stops_run) {
        let (computed, others) = part(session);
        let scope = Scope { session: &computed, folder, first: None, studies: &[], cause: "check", generation: 1 };
        let cache = Cache::new(CACHE_BYTES);
        let snapshot = run(&scope, &Snapshot::default(), &cache, &Control::default(), &warn_once(warn));
        findings.extend(snapshot.memory.clone());
        findings.extend(check_recordings(session, &snapshot));
        findings.extend(check_samples(session, &others, &snapshot));
        findings.extend(accelerometer::findings(&computed, &snapshot));
        findings.extend(mounting::findings(&computed, &snapshot));
        findings.extend(shape::geometry_findings(&snapshot));
        let compared = snapshot.physics.values().filter_map(|slot| slot.ready());
        physics.extend(compared.flat_map(|compared| compared.rows.iter().cloned()));
        // What the session itself says of a window or a flight is why it fails.
        let bad = findings.iter().filter(|finding| finding.level == Level::Bad);
        let known: BTreeSet<Place> = bad.map(|finding| finding.place.clone()).collect();
        let failed = failures(&snapshot, others.is_empty()).into_iter();
        findings.extend(failed.filter(|failure| !known.contains(&failure.place)));
    }
    Checked { subject: in_one_line(session), findings, physics }.sorted()
}

/// What a run publishes to: `warn` is told once that memory may not suffice.
pub fn warn_once(warn: impl Fn(&Finding) + Sync) -> impl Fn(Snapshot) + Sync {
    let warned = Once::new();
    move |snapshot| {
        if let Some(finding) = &snapshot.memory {
            warned.call_once(|| warn(finding));
        }
    }
}

/// The session with as many of its windows as are computed, and the others.
fn part(session: &Session) -> (Cow<'_, Session>, Vec<&Manoeuvre>) {
    let active = || session.active_windows();
    let others: Vec<_> = active().skip(MOST_COMPUTED).collect();
    if others.is_empty() {
        return (Cow::Borrowed(session), others);
    }
    let windows = active().take(MOST_COMPUTED).cloned().collect();
    (Cow::Owned(Session { windows, ..session.clone() }), others)
}

/// What a run would refuse of the samples of the windows that were not computed, and that they were not.
fn check_samples(session: &Session, others: &[&Manoeuvre], snapshot: &Snapshot) -> Vec<Finding> {
    if others.is_empty() {
        return Vec::new();
    }
    let text = format!(
        "Only the first {MOST_COMPUTED} manoeuvres were computed; of the other {}, only samples were checked.",
        others.len()
    );
    let mut findings =
        vec![Finding::new(Level::Good, "window", "windows", text).with_fix_text("Compute all with `doublet run`.")];
    for window in others {
        let Some(loaded) = snapshot.flights.get(&window.flight).and_then(|slot| slot.ready()) else { continue };
        let samples = stage::samples(&loaded.recording, window.samples(), None, &session.preparation);
        let place = || Place::manoeuvre(&window.name);
        findings.extend(samples.err().map(|text| Finding::new(Level::Bad, "run", place(), text.to_string())));
    }
    findings
}

/// What was found when the recordings were read.
fn check_recordings(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    let mut findings = Vec::new();
    for flight in &session.flights {
        let Some(loaded) = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        let place = Place::flight(&flight.name);
        let apart = find_apart(&loaded.recording);
        findings.extend(apart.map(|Apart { text, fix_text }| {
            Finding::new(Level::Bad, "clock", place.clone(), text).with_fix_text(fix_text)
        }));
        findings.extend(stage::restart_findings(&loaded.recording, &flight.name));
        let changed: Vec<_> = flight
            .recordings
            .iter()
            .zip(&loaded.hashes)
            .filter_map(|(entry, hash)| stage::describe_change(entry, hash))
            .collect();
        for text in &loaded.recording.warnings {
            let level = if changed.contains(text) { Level::Caution } else { Level::Good };
            let code = if changed.contains(text) { "changed" } else { "recording" };
            findings.push(Finding::new(level, code, place.clone(), text.clone()));
        }
    }
    for window in session.active_windows() {
        let loaded = snapshot.flights.get(&window.flight).and_then(|slot| slot.ready());
        let outside = loaded.and_then(|loaded| stage::partly_outside(&loaded.recording, window.window));
        let place = Place::manoeuvre(&window.name);
        findings.extend(outside.map(|(text, inside)| {
            let label = format!("shorten '{}' to the inertial samples", window.name);
            let edit = Edit::Window(WindowEdit::Place { name: window.name.clone(), window: inside });
            Finding::new(Level::Caution, "window", place, text)
                .with_fix_text("move its start or end")
                .with_setting("Manoeuvres", "")
                .with_fix(Fix::new(label, edit))
        }));
    }
    findings
}

/// What failed in a run; fits that failed say something where all windows were there.
fn failures(snapshot: &Snapshot, is_whole: bool) -> Vec<Finding> {
    let stages = snapshot.failures().into_iter().map(|(place, text)| Finding::new(Level::Bad, "run", place, text));
    let fits = if is_whole { snapshot.failed_fits() } else { Vec::new() };
    stages.chain(fits.into_iter().map(|(place, text)| Finding::new(Level::Bad, "fit", place, text))).collect()
}

fn in_one_line(session: &Session) -> String {
    format!(
        "{}: {}, {}, {}",
        if session.title.is_empty() { "session" } else { &session.title },
        plural(session.flights.len(), "flight"),
        plural(session.windows.len(), "manoeuvre"),
        plural(session.structure.models.len(), "coefficient")
    )
}

fn check_aircraft(path: &Path, text: &str) -> Checked {
    let place = Place::from(path.display().to_string());
    let bad = |text: String| Finding::new(Level::Bad, "aircraft", place.clone(), text).with_fix_text("correct it");
    match aircraft_file::parse(text) {
        Err(AircraftFileError::Impossible { errors }) => {
            Checked { findings: errors.iter().map(|error| bad(error.to_string())).collect(), ..Checked::default() }
        }
        Err(error) => Checked::refused(bad(error.to_string())),
        Ok(aircraft) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let context = Context::new(path.parent().unwrap_or(Path::new("")));
            let engines = stage::load_aircraft(&context, &name).err();
            let fix_text = "copy the engine files into its folder";
            let engines = engines
                .map(|e| Finding::new(Level::Caution, "engines", place.clone(), e.to_string()).with_fix_text(fix_text));
            let mass = aircraft.standard_loading.mass_properties(&aircraft);
            let shape = shape::findings(&place, &aircraft.reference, Some(&mass));
            Checked {
                subject: summary(&aircraft).to_string().trim_end().to_owned(),
                findings: engines.into_iter().chain(shape).collect(),
                physics: Vec::new(),
            }
        }
    }
}
