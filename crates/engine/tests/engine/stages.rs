//! What a stage follows from: its parameters, its inputs and the files it reads through its context.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use doublet_engine::begin;
use doublet_engine::graph::{Cache, Context, Control, Footprint, Stage, StageError, StageResult};
use doublet_engine::live::{Feed, Opening};
use doublet_engine::run::{DetailRequest, Details, Engine, InquiryRequest, LiveOrder, LiveThread, Request};
use doublet_engine::session;
use doublet_engine::stage::NO_PATH_MEASUREMENT;
use doublet_engine::verdict::list_failures;

use crate::live;

struct Number(u64);

impl Footprint for Number {
    fn bytes(&self) -> usize {
        8
    }
}

static RUNS: AtomicUsize = AtomicUsize::new(0);

/// The sum of the numbers in the files that a file lists.
struct Sum;

impl Stage for Sum {
    type Params<'a> = &'a str;
    type Inputs<'a> = ();
    type Output = Number;
    const NAME: &'static str = "sum";

    fn run(list: &str, (): (), context: &Context<'_>) -> StageResult<Number> {
        RUNS.fetch_add(1, Ordering::Relaxed);
        let numbers = context.text(list, "")?;
        let number = |file: &str| Ok(context.text(file, "")?.trim().parse().unwrap_or(0));
        Ok(Number(numbers.split_whitespace().map(number).sum::<StageResult<u64>>()?))
    }
}

/// Twice that, by another stage.
struct Double;

impl Stage for Double {
    type Params<'a> = &'a str;
    type Inputs<'a> = ();
    type Output = Number;
    const NAME: &'static str = "double";

    fn run(list: &str, (): (), context: &Context<'_>) -> StageResult<Number> {
        Ok(Number(2 * context.get::<Sum>(list, ())?.0))
    }
}

#[test]
fn a_stage_runs_again_when_a_file_that_it_or_its_inputs_read_changes_and_only_then() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let cache = Cache::new(1 << 20);
    let expect = |value: u64, runs: usize, files: usize| {
        let context = Context::new(folder.path()).with_cache(&cache);
        assert_eq!(context.get::<Double>("list", ()).unwrap().0, value);
        assert_eq!((RUNS.load(Ordering::Relaxed), context.files().len()), (runs, files));
    };
    write("list", "a b");
    write("a", "1");
    write("b", "2");
    expect(6, 1, 3);
    expect(6, 1, 3);
    write("b", "20");
    expect(42, 2, 3);
    write("list", "a");
    expect(2, 3, 2);
    write("b", "200");
    expect(2, 3, 2);
    std::fs::remove_file(folder.path().join("a")).unwrap();
    let context = Context::new(folder.path()).with_cache(&cache);
    let error = context.get::<Double>("list", ()).err().unwrap();
    assert!(error.to_string().ends_with("file or folder not found"), "{error}");
}

#[test]
fn a_stage_that_was_stopped_says_so_and_keeps_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, control) = (Cache::new(1 << 20), Control::default());
    let context = Context::new(folder.path()).with_cache(&cache).with_control(&control, &|_| ());
    control.cancel();
    assert_eq!(context.get::<Patient>((), ()).err(), Some(StageError::Cancelled));
    assert_eq!(Context::new(folder.path()).with_cache(&cache).get::<Patient>((), ()).unwrap().0, 1);
}

/// Looks whether it is to go on.
struct Patient;

impl Stage for Patient {
    type Params<'a> = ();
    type Inputs<'a> = ();
    type Output = Number;
    const NAME: &'static str = "patient";

    fn run((): (), (): (), context: &Context<'_>) -> StageResult<Number> {
        context.checkpoint()?;
        Ok(Number(1))
    }
}

/// The closer look that `request` asks for, once it is there.
fn look(engine: &Engine, request: &DetailRequest) -> Arc<Details> {
    engine.request_details(request);
    let begun = Instant::now();
    while engine.is_busy() || engine.has_details_due() {
        assert!(begun.elapsed() < Duration::from_secs(300), "it ends");
        std::thread::sleep(Duration::from_millis(2));
    }
    Arc::clone(engine.snapshot().details.ready().unwrap())
}

#[test]
fn a_closer_look_follows_the_newest_request_and_comes_back_from_the_cache() {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    session.windows.truncate(1);
    let name = session.windows[0].name.clone();
    let engine = Engine::start(Arc::new(Cache::new(1 << 20)), || ()).unwrap();
    engine.request(Request {
        session: Arc::new(session),
        folder: PathBuf::from("."),
        first: None,
        studies: Vec::new(),
        cause: "test".to_owned(),
        fresh: true,
    });
    let filters = DetailRequest { window: Some(name.clone()), filters: true, ..DetailRequest::default() };
    let plain = DetailRequest { filters: false, ..filters.clone() };
    let first = look(&engine, &filters);
    let window = first.window.as_ref().unwrap();
    let [linear, iterated] = window.filters.as_ref().unwrap().as_ref().unwrap();
    assert_eq!(window.name, name);
    assert!(!window.residuals.is_empty() && !window.contributions.is_empty());
    assert_ne!(linear.reconstruction.states, iterated.reconstruction.states);
    // The newer request counts, whatever became of the older one.
    engine.request_details(&DetailRequest::default());
    assert!(look(&engine, &plain).window.as_ref().unwrap().filters.is_none());
    assert!(Arc::ptr_eq(&first, &look(&engine, &filters)), "it is not computed again");
}

/// A panic in the coordinator's own thread, here of what it calls after a snapshot: one of a run, then one of a closer look.
#[test]
fn a_panic_of_a_job_reaches_the_snapshot_as_one_line_and_the_next_job_runs() {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    // Fails at once, as the recording is absent: what counts is that jobs end and what is said of them.
    session.flights[0].recordings[0].path = "absent.csv".to_owned();
    let name = session.windows[0].name.clone();
    let due = Arc::new(AtomicUsize::new(1));
    let calls = Arc::clone(&due);
    let engine = Engine::start(Arc::new(Cache::new(64 << 20)), move || {
        // The second panic would be of the report of the first.
        let is_due = calls.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)) == Ok(1);
        assert!(!is_due, "a job that panics");
    })
    .unwrap();
    let ask = || {
        let session = Arc::new(session.clone());
        let (folder, cause) = (PathBuf::from("."), "test".to_owned());
        engine.request(Request { session, folder, first: None, studies: Vec::new(), cause, fresh: true });
    };
    let wait = || {
        let begun = Instant::now();
        while engine.is_busy() || engine.has_details_due() {
            assert!(begun.elapsed() < Duration::from_secs(300), "it ends");
            std::thread::sleep(Duration::from_millis(2));
        }
        engine.snapshot()
    };
    let is_line = |line: &str| {
        line.contains("internal error of doublet at") && line.contains("a job that panics") && !line.contains('\n')
    };
    ask();
    let failures = wait().failures();
    assert!(!failures.is_empty() && failures.iter().any(|(_, line)| is_line(line)), "{failures:?}");
    assert!(!wait().busy);
    ask();
    let failures = wait().failures();
    assert!(failures.iter().any(|(_, line)| line.contains("absent.csv")), "{failures:?}");
    assert!(!failures.iter().any(|(_, line)| is_line(line)), "{failures:?}");
    due.store(1, Ordering::Relaxed);
    engine.request_details(&DetailRequest { window: Some(name), ..DetailRequest::default() });
    let shown = wait();
    assert!(shown.details.error().is_some_and(is_line), "{:?}", shown.details.error());
    assert!(look(&engine, &DetailRequest::default()).window.is_none());
}

/// Panics once in the thread of a name.
fn panics_in(thread: &'static str) -> impl Fn() + Send + Sync {
    let due = AtomicUsize::new(1);
    move || {
        let is_there = std::thread::current().name() == Some(thread);
        let is_due = is_there && due.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_ok();
        assert!(!is_due, "a worker that panics");
    }
}

/// Whether a line says where the program is at fault and what happened.
fn is_fault(line: &str) -> bool {
    line.contains("internal error of doublet at") && line.contains("a worker that panics") && !line.contains('\n')
}

#[test]
fn a_panic_of_the_experiments_is_said_in_their_rows_and_they_are_computed_again() {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    session.flights[0].recordings[0].path = "absent.csv".to_owned();
    let engine = Engine::start(Arc::new(Cache::new(1 << 20)), panics_in("doublet-experiments")).unwrap();
    let (folder, cause) = (PathBuf::from("."), "test".to_owned());
    let session = Arc::new(session);
    engine.request(Request { session, folder, first: None, studies: Vec::new(), cause, fresh: true });
    let errors = || {
        let begun = Instant::now();
        while engine.is_busy() || engine.has_details_due() {
            assert!(begun.elapsed() < Duration::from_secs(300), "it ends");
            std::thread::sleep(Duration::from_millis(2));
        }
        let rows = engine.snapshot().inquiries.experiments.0.clone();
        rows.iter().filter_map(|(_, slot)| slot.error().map(str::to_owned)).collect::<Vec<_>>()
    };
    let ask = |experiments| {
        let inquiry = InquiryRequest { experiments, ..InquiryRequest::default() };
        engine.request_details(&DetailRequest { inquiry, ..DetailRequest::default() });
    };
    assert!(errors().is_empty());
    ask(true);
    let found = errors();
    assert!(found.iter().any(|line| is_fault(line)), "{found:?}");
    ask(false);
    ask(true);
    let found = errors();
    assert!(!found.is_empty() && found.iter().all(|line| line.contains("absent.csv")), "{found:?}");
}

/// The worker of the window on a recording of rates and forces alone: the run ends and each manoeuvre says what is missing.
#[test]
fn a_recording_of_rates_and_forces_alone_ends_with_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "time [s],ax [m/s^2],ay [m/s^2],az [m/s^2],p [rad/s],q [rad/s],r [rad/s]\n".to_owned();
    for k in 0..1000 {
        let (t, turn) = (0.02 * f64::from(k), 0.1 * f64::from(k).sin());
        text += &format!("{t:.2},{turn:.4},{turn:.4},-9.8,{turn:.4},{turn:.4},{turn:.4}\n");
    }
    std::fs::write(folder.path().join("inertial.csv"), text).unwrap();
    let inspected = begin::inspect(&[folder.path().join("inertial.csv")], &Control::default(), &|_| {}).unwrap();
    let map = inspected.guess.text().unwrap();
    std::fs::write(folder.path().join("map.toml"), map).unwrap();
    let session = "format = \"doublet session\"\nversion = 3\n[[flight]]\nname = \"f\"\n[[flight.recording]]\n\
                   path = \"inertial.csv\"\nchannel_map = \"map.toml\"\n"
        .to_owned();
    let window = |name: &str, start: u32| {
        format!("[[window]]\nname = \"{name}\"\nflight = \"f\"\nstart_s = {start}.0\nend_s = {}.0\n", start + 5)
    };
    let session = session::parse(&(session + &window("first", 1) + &window("second", 10))).unwrap();
    let engine = Engine::start(Arc::new(Cache::new(64 << 20)), || ()).unwrap();
    engine.request(Request {
        session: Arc::new(session),
        folder: folder.path().to_owned(),
        first: None,
        studies: Vec::new(),
        cause: "test".to_owned(),
        fresh: true,
    });
    let begun = Instant::now();
    while engine.is_busy() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it ends");
        std::thread::sleep(Duration::from_millis(2));
    }
    let lines = list_failures(&engine.snapshot().failures());
    let [line] = &lines[..] else { panic!("{lines:?}") };
    assert!(line.starts_with("manoeuvres 'first', 'second': ") && line.contains(NO_PATH_MEASUREMENT), "{line}");
}

#[test]
fn a_panic_while_a_flight_is_watched_ends_it_with_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("growing.csv");
    std::fs::write(&path, live::text()[..200].join("\n") + "\n").unwrap();
    let opening = Opening {
        feed: Some(Feed::File(path.display().to_string())),
        map: Some(live::map_in(folder.path()).display().to_string()),
        aircraft: Some("c337f".to_owned()),
        ..Opening::default()
    };
    let order = LiveOrder { opening, ..LiveOrder::default() };
    let watched = LiveThread::start(order, panics_in("doublet-live")).unwrap();
    let begun = Instant::now();
    while !watched.view().is_finished {
        assert!(begun.elapsed() < Duration::from_secs(60), "it ends");
        std::thread::sleep(Duration::from_millis(2));
    }
    let error = watched.view().error.clone().unwrap_or_default();
    assert!(error.starts_with("live: ") && is_fault(&error), "{error}");
}
