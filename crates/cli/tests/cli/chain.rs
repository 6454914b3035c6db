//! Recordings of many recorders changed at random and taken through the whole chain inside this process: inspected, guessed, made into a
//! session, checked, run, reported, exported and watched as if they were flown now.

#[path = "../../../../fuzz/src/guess_session.rs"]
mod guess_session;

use crate::common::chain;
use guess_session::guess_session;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use doublet_engine::begin;
use doublet_engine::check::check_file;
use doublet_engine::export::{self, Format, IdentifiedModel};
use doublet_engine::graph::Cache;
use doublet_engine::live::{Feed, LiveWatch, Opening, open};
use doublet_engine::report::document::SectionKind;
use doublet_engine::report::{self, HistoryFormat, Outputs, TableFormat};
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, PathSource, Session};
use doublet_report::{Order, ReportFormat};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Longest time of one step in a build without optimisation, with other load.
const PATIENCE: Duration = Duration::from_secs(120);
/// Largest recording that is taken, so that many are.
const LARGEST: u64 = 300_000;
/// Manoeuvres of a session and their length, s.
const MANOEUVRES: usize = 2;
const LENGTH_S: f64 = 8.0;

/// How far the recordings came, and what must not happen.
#[derive(Debug, Default)]
struct Reached {
    by_step: BTreeMap<&'static str, usize>,
    faults: Vec<String>,
}

/// One recording on its way.
struct Way<'a> {
    seed: u64,
    source: String,
    reached: &'a mut Reached,
}

impl Way<'_> {
    /// Takes a step: its result, none where it was refused. A panic, an error of the program itself and a step that takes too long are
    /// faults.
    fn step<T>(&mut self, name: &'static str, work: impl FnOnce() -> Result<T, String>) -> Option<T> {
        let begun = Instant::now();
        let done = catch_unwind(AssertUnwindSafe(work));
        let fault = match &done {
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                Some(text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default())
            }
            Ok(Err(line)) if line.contains("internal error") => Some(line.clone()),
            _ if begun.elapsed() > PATIENCE => Some(format!("took {:?}", begun.elapsed())),
            Ok(_) => None,
        };
        if let Some(fault) = fault {
            self.reached.faults.push(format!("seed {}, {}, {name}: {fault}", self.seed, self.source));
        }
        let result = done.ok()?.ok();
        *self.reached.by_step.entry(name).or_default() += usize::from(result.is_some());
        result
    }
}

/// `DOUBLET_CHAIN_RUNS` states how many recordings, `DOUBLET_CHAIN_SEED` the seed of the first.
#[test]
fn changed_recordings_go_through_the_whole_chain_without_a_panic() {
    let chain = chain::Chain::of_environment(24);
    let sources = sources();
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let part = |first: u64| {
        let mut reached = Reached::default();
        let seeds = (chain.seed + first..chain.seed + chain.runs).step_by(threads as usize);
        seeds.for_each(|seed| one(seed, &sources, &mut reached));
        reached
    };
    let parts: Vec<Reached> = std::thread::scope(|scope| {
        let parts: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
        parts.into_iter().map(|part| part.join().unwrap()).collect()
    });
    let mut all = Reached::default();
    for part in parts {
        part.by_step.into_iter().for_each(|(step, count)| *all.by_step.entry(step).or_default() += count);
        all.faults.extend(part.faults);
    }
    println!("{} recordings of {} sources, {:?}, {} faults", chain.runs, sources.len(), all.by_step, all.faults.len());
    assert!(all.faults.is_empty(), "{}", all.faults.join("\n"));
}

/// Seeds of the parsers, and recordings of other programs and flights where they are here.
fn sources() -> Vec<PathBuf> {
    let mut found = chain::seeds();
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for folder in ["formats", "strangers"] {
        collect(&shared.join(folder), &mut found);
    }
    found.sort();
    found
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.map(Result::unwrap) {
        let (path, about) = (entry.path(), entry.metadata().unwrap());
        if about.is_dir() {
            collect(&path, found);
        } else if about.len() < LARGEST
            && !["md", "py", "json"].iter().any(|end| path.extension().is_some_and(|own| own == *end))
        {
            found.push(path);
        }
    }
}

/// A changed recording in a folder, its name and what it was made of: half of them are the table of a flight, which comes further.
fn write_recording(random: &mut ChaCha8Rng, sources: &[PathBuf], folder: &Path) -> (PathBuf, String) {
    if random.random_bool(0.5) {
        let path = folder.join("flight.csv");
        std::fs::write(&path, chain::changed_table(random)).unwrap();
        return (path, "flight".to_owned());
    }
    let source = &sources[random.random_range(0..sources.len())];
    let mut bytes = std::fs::read(source).unwrap();
    let path = folder.join(source.file_name().unwrap());
    match String::from_utf8(bytes.clone()) {
        Ok(text) if random.random_bool(0.7) => bytes = changed_text(random, &text).into_bytes(),
        _ if random.random_bool(0.8) => chain::change_bytes(random, &mut bytes),
        _ => {}
    }
    std::fs::write(&path, bytes).unwrap();
    (path, source.file_name().unwrap().to_string_lossy().into_owned())
}

/// A text with its rows and columns changed, by the separator that is most frequent in it.
fn changed_text(random: &mut ChaCha8Rng, text: &str) -> String {
    let separator = [',', ';', '\t'].into_iter().max_by_key(|one| text.matches(*one).count()).unwrap();
    let split = |line: &str| line.split(separator).map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines();
    let mut header = split(lines.next().unwrap_or_default());
    let mut rows: Vec<Vec<String>> = lines.map(split).collect();
    chain::change_table(random, &mut header, &mut rows);
    let separator = separator.to_string();
    std::iter::once(&header).chain(&rows).map(|row| row.join(&separator) + "\n").collect()
}

/// One recording on its way through the chain; the first step that refuses it ends the way.
fn one(seed: u64, sources: &[PathBuf], reached: &mut Reached) {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let folder = tempfile::tempdir().unwrap();
    let (path, source) = write_recording(random, sources, folder.path());
    let way = &mut Way { seed, source, reached };
    let inspect = || {
        begin::inspect_for(
            std::slice::from_ref(&path),
            Some(&folder.path().join("a.toml")),
            &Control::default(),
            &|_| {},
        )
    };
    let Some(inspected) = way.step("inspect", inspect) else { return };
    if random.random_bool(0.3) {
        way.step("live", || watch(&path, &folder.path().join("recorded")));
    }
    let Some(mut session) = way.step("new", || guess_session(&inspected)) else { return };
    session.preparation.path =
        [PathSource::Smoothed, PathSource::Filtered, PathSource::Measured][random.random_range(0..3)];
    session.windows.truncate(MANOEUVRES);
    session.windows.iter_mut().for_each(|one| one.window.end_s = one.window.end_s.min(one.window.start_s + LENGTH_S));
    let place = folder.path().join("a.toml");
    let save = || session::save(&session, &place).map_err(|error| error.to_string());
    if way.step("save", save).is_none() {
        return;
    }
    way.step("check", || {
        let findings = check_file(&place, &|_| ()).findings;
        findings.iter().map(ToString::to_string).find(|line| line.contains("internal error")).map_or(Ok(()), Err)
    });
    let Some((session, snapshot)) = way.step("run", || computed(&place)) else { return };
    let histories = [HistoryFormat::Csv, HistoryFormat::Hdf5, HistoryFormat::Mat, HistoryFormat::Parquet]
        [random.random_range(0..4)];
    way.step("results", || {
        let outputs = Outputs { tables: TableFormat::ALL.to_vec(), histories: vec![histories], recordings: true };
        let control = Control::default();
        let written = report::write(&session, &snapshot, &folder.path().join("results"), &outputs, &control, &|_| {});
        written.map(drop).map_err(|error| error.to_string())
    });
    way.step("report", || {
        let (formats, sections) = (vec![ReportFormat::Html], SectionKind::ALL.to_vec());
        let order =
            Order { folder: folder.path().join("report"), name: "a".to_owned(), formats, sections, ..Order::default() };
        doublet_report::write(&session, &snapshot, &order, &Control::default(), &|_| {}).map(drop)
    });
    way.step("export", || {
        let model = IdentifiedModel::new(&session, &snapshot).map_err(|error| error.to_string())?;
        export::write(&model, &Format::ALL, &folder.path().join("models")).map(drop).map_err(|error| error.to_string())
    });
}

/// The session as opened, and what a run makes of it.
fn computed(place: &Path) -> Result<(Session, Snapshot), String> {
    let opened = session::open(place).map_err(|error| error.to_string())?;
    if let Some(finding) = session::check(&opened.session).iter().find(|finding| session::stops_run(finding)) {
        return Err(finding.to_string());
    }
    let (session, folder) = (opened.session, opened.folder);
    let scope = Scope { session: &session, folder: &folder, first: None, studies: &[], cause: "test", generation: 1 };
    let snapshot = run(&scope, &Snapshot::default(), &Cache::new(0), &Control::default(), &|_| {});
    let failures = snapshot.failures().into_iter().chain(snapshot.failed_fits());
    let mut lines = failures.map(|(place, error)| format!("{place}: {error}"));
    match lines.find(|line| line.contains("internal error")) {
        Some(line) => Err(line),
        None => Ok((session, snapshot)),
    }
}

/// Watches a recording as if it were flown now, and records it again.
fn watch(path: &Path, folder: &Path) -> Result<(), String> {
    let opening = Opening {
        feed: Some(Feed::File(path.display().to_string())),
        aircraft: Some("attas_vfw614".to_owned()),
        wait: Some(Duration::from_millis(1)),
        ..Opening::default()
    };
    let watched = open(&opening)?;
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, opening.wait)?;
    live.record(folder, None, watched.aircraft.as_deref())?;
    let start = Instant::now();
    loop {
        let step = live.step(Instant::now())?;
        let internal = step.updates.iter().flat_map(|update| &update.findings).find(|line| line.contains("internal"));
        if let Some(line) = internal {
            return Err(line.clone());
        }
        if step.is_finished || start.elapsed() > PATIENCE / 4 {
            break;
        }
        std::thread::sleep(step.rest.unwrap_or_default());
    }
    live.stop();
    live.finish().map(drop)
}
