//! Nothing is ever lost: kills at any instant, recovery, one owner per session file, moved and changed recordings.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use doublet_engine::autosave::{AutosaveFile, abandoned_autosaves};
use doublet_engine::document::Document;
use doublet_engine::keep::{self, Lock, LockResult};
use doublet_engine::session::{self, Edit, Session};
use rand::{RngExt, SeedableRng};

use crate::compute;

/// Kills of the test.
const KILLS: usize = 200;
/// Longest time a child edits and saves before it is killed: some ten saves and autosaves.
const LONGEST_MS: f64 = 60.0;
/// Most a journalled edit may take to last: the interval between two writes (0.2 s), and room for a busy disk.
const DURABLE_WITHIN: Duration = Duration::from_secs(2);
/// Set for the process that is killed: the folder it works in.
const CHILD: &str = "DOUBLET_TEST_CHILD";

fn demo() -> Session {
    session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap()
}

fn titled(title: impl ToString) -> Edit {
    Edit::Title(title.to_string())
}

fn number(session: &Session) -> u64 {
    session.title.parse().unwrap()
}

struct Desk {
    _folder: tempfile::TempDir,
    session: PathBuf,
    autosaves: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let (session, autosaves) = (root.join("flight.toml"), root.join("state/autosave"));
        session::save(&titled(0).apply(&demo()).unwrap(), &session).unwrap();
        Self { _folder: folder, session, autosaves }
    }

    fn open(&self) -> Document {
        let mut document = Document::open(&self.session).unwrap();
        document.keep_in(&self.autosaves).unwrap();
        document
    }

    fn edited(&self, title: &str) -> Document {
        let mut document = self.open();
        document.history.apply(&titled(title)).unwrap();
        document.autosave_now().unwrap();
        document
    }

    /// Ends a program without its leave: what it kept stays, its locks go.
    fn crash(document: Document) {
        drop(document);
    }

    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.session.parent().unwrap()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).filter(|n| n != "state").collect();
        names.sort();
        names
    }
}

/// The program that is killed: takes up what was left, edits, autosaves and saves, and says what lasts.
#[test]
#[ignore = "run by the test that kills it"]
fn child_that_edits_and_saves() {
    let Some(root) = std::env::var_os(CHILD).map(PathBuf::from) else { return };
    let (path, autosaves) = (root.join("flight.toml"), root.join("state/autosave"));
    let (mut left, unreadable) = abandoned_autosaves(&autosaves);
    assert_eq!(unreadable, [""; 0]);
    let mut document = match left.first() {
        Some(abandoned) => Document::recover(&abandoned.autosave),
        None => Document::open(&path).unwrap(),
    };
    document.keep_in(&autosaves).unwrap();
    assert_eq!(document.held_by(), None);
    for abandoned in left.drain(..) {
        document.adopt(abandoned).unwrap();
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(number(document.session()));
    println!("LASTS {}", number(document.session()));
    loop {
        let next = number(document.session()) + 1;
        document.history.apply(&titled(next)).unwrap();
        match random.random_range(0..10) {
            0..4 => document.autosave(),
            4..8 => {
                document.autosave_now().unwrap();
                println!("LASTS {next}");
            }
            _ => {
                document.save(&path).unwrap();
                println!("LASTS {next}");
            }
        }
    }
}

/// Starts the child, kills it `after` its first sign of life, and gives the newest edit it said would last.
fn kill_child(root: &Path, after: Duration) -> u64 {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "never_lost::child_that_edits_and_saves", "--ignored", "--nocapture", "--test-threads=1"])
        .env(CHILD, root)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let lasts = |line: String| line.rsplit("LASTS ").next().and_then(|text| text.parse::<u64>().ok());
    let first = lines.by_ref().map(Result::unwrap).find_map(lasts);
    let last = std::thread::scope(|scope| {
        let reader = scope.spawn(move || lines.map_while(Result::ok).filter_map(lasts).last());
        std::thread::sleep(after);
        child.kill().unwrap();
        child.wait().unwrap();
        reader.join().unwrap()
    });
    last.or(first).expect("the child begins to work")
}

#[test]
fn never_lost_by_kills_at_random_moments() {
    let desk = Desk::new();
    let root = desk.session.parent().unwrap();
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let (mut recovered_later, mut newest) = (0, 0);
    for kill in 0..KILLS {
        let after = Duration::from_secs_f64(1e-3 * random.random_range(0.0..LONGEST_MS));
        let promised = kill_child(root, after);
        let file = session::open(&desk.session).unwrap_or_else(|error| panic!("kill {kill}: {error}"));
        let in_file = number(&file.session);
        let (left, unreadable) = abandoned_autosaves(&desk.autosaves);
        assert_eq!(unreadable, [""; 0], "kill {kill}");
        let in_autosaves = left.iter().map(|abandoned| number(&abandoned.autosave.session)).max().unwrap_or(0);
        assert!(left.iter().all(|abandoned| abandoned.autosave.of.as_ref() == Some(&desk.session)));
        newest = in_file.max(in_autosaves);
        assert!(newest >= promised, "kill {kill}: edit {promised} was kept, {newest} was found");
        recovered_later += usize::from(in_autosaves > in_file);
        let previous = desk.session.with_file_name("flight.toml.bak");
        assert!(!previous.exists() || session::open(&previous).is_ok(), "kill {kill}");
    }
    assert!(newest > KILLS as u64, "{newest} edits in {KILLS} lives");
    // Both roads of recovery were taken: work newer than the file, and a file with all of it.
    assert!(recovered_later > KILLS / 10 && recovered_later < KILLS, "{recovered_later} of {KILLS}");
    let mut document = desk.open();
    document.save(&desk.session).unwrap();
    Desk::crash(document);
    assert_eq!(desk.files(), ["flight.toml", "flight.toml.bak"], "no litter");
}

#[test]
fn an_edit_lasts_within_the_stated_time() {
    let desk = Desk::new();
    let mut document = desk.open();
    for name in ["first", "second", "third"] {
        document.history.apply(&titled(name)).unwrap();
        document.autosave();
        let begun = Instant::now();
        let file = desk.autosaves.join("flight-1.toml");
        while !std::fs::read_to_string(&file).is_ok_and(|text| text.contains(name)) {
            assert!(begun.elapsed() < DURABLE_WITHIN, "{name}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

#[test]
fn unsaved_work_comes_back_one_undo_from_the_file() {
    let desk = Desk::new();
    Desk::crash(desk.edited("afternoon of marking"));
    let (mut left, _) = abandoned_autosaves(&desk.autosaves);
    let abandoned = left.pop().unwrap();
    let mut document = Document::recover(&abandoned.autosave);
    document.keep_in(&desk.autosaves).unwrap();
    document.adopt(abandoned).unwrap();
    assert_eq!(document.session().title, "afternoon of marking");
    assert!(document.history.is_modified());
    assert_eq!(document.history.undo_label(), Some("recover unsaved work"));
    assert_eq!(abandoned_autosaves(&desk.autosaves).0.len(), 0, "a living program owns it");
    Desk::crash(document);
    let (left, _) = abandoned_autosaves(&desk.autosaves);
    assert_eq!(left[0].autosave.session.title, "afternoon of marking", "a second crash loses nothing either");
    drop(left);
    let mut document = desk.open();
    abandoned_autosaves(&desk.autosaves).0.into_iter().for_each(|abandoned| abandoned.discard().unwrap());
    document.history.apply(&titled("another")).unwrap();
    document.autosave_now().unwrap();
    assert!(document.history.undo());
    document.autosave_now().unwrap();
    Desk::crash(document);
    assert_eq!(abandoned_autosaves(&desk.autosaves).0.len(), 0, "work undone is no work");
}

#[test]
fn unsaved_work_outlives_its_file() {
    let desk = Desk::new();
    Desk::crash(desk.edited("homeless"));
    std::fs::remove_file(&desk.session).unwrap();
    let (left, _) = abandoned_autosaves(&desk.autosaves);
    let document = Document::recover(&left[0].autosave);
    assert_eq!((document.session().title.as_str(), &document.path), ("homeless", &None));
    assert!(document.history.is_modified(), "no file has it");
    assert_eq!(document.folder, desk.session.parent().unwrap(), "its paths mean what they meant");
}

#[test]
fn work_given_up_or_saved_is_not_offered() {
    let desk = Desk::new();
    let mut document = desk.edited("given up");
    document.give_up();
    drop(document);
    assert_eq!(abandoned_autosaves(&desk.autosaves).0.len(), 0);
    let mut document = desk.edited("saved");
    document.save(&desk.session).unwrap();
    drop(document);
    assert_eq!(abandoned_autosaves(&desk.autosaves).0.len(), 0);
    // A kill between the save and the end of the autosave leaves both with one content.
    let slot = AutosaveFile::new(&desk.autosaves, Some(&desk.session)).unwrap();
    let session = Arc::new(session::open(&desk.session).unwrap().session);
    let folder = desk.session.parent().unwrap().to_path_buf();
    slot.write(&doublet_engine::autosave::Autosave { of: Some(desk.session.clone()), folder, session }).unwrap();
    drop(slot);
    assert_eq!(abandoned_autosaves(&desk.autosaves).0.len(), 0);
    assert_eq!(std::fs::read_dir(&desk.autosaves).unwrap().count(), 0);
}

#[test]
fn a_session_open_elsewhere_is_noticed_and_can_be_saved_under_another_name() {
    let desk = Desk::new();
    let first = desk.open();
    let mut second = desk.open();
    assert_eq!(first.held_by(), None);
    let owner = second.held_by().unwrap().to_owned();
    assert!(owner.contains(&std::process::id().to_string()), "{owner}");
    second.history.apply(&titled("second")).unwrap();
    let refused = second.save(&desk.session).unwrap_err();
    assert!(refused.contains("another name") && refused.contains(&owner), "{refused}");
    assert_eq!(number(&session::open(&desk.session).unwrap().session), 0);
    second.save(&desk.session.with_file_name("copy.toml")).unwrap();
    assert_eq!(second.held_by(), None);
    drop(first);
    second.save(&desk.session).unwrap();
    assert_eq!(session::open(&desk.session).unwrap().session.title, "second");
}

#[test]
fn a_lock_a_dead_program_left_is_taken_over() {
    let desk = Desk::new();
    let left = desk.session.with_file_name(".flight.toml.lock");
    std::fs::write(&left, "pid = 1\nhost = \"elsewhere\"\nsince_ns = 0\n").unwrap();
    let LockResult::Acquired(lock) = Lock::try_lock(&desk.session).unwrap() else { panic!("nobody holds it") };
    let LockResult::Held(Some(owner)) = Lock::try_lock(&desk.session).unwrap() else { panic!("we hold it") };
    assert_eq!(owner.pid, std::process::id());
    assert!(owner.since().elapsed().unwrap() < Duration::from_secs(3600));
    drop(lock);
    assert!(!left.exists());
}

#[test]
fn an_unreadable_autosave_is_said_and_left() {
    let desk = Desk::new();
    std::fs::create_dir_all(&desk.autosaves).unwrap();
    let newer = "format = \"doublet autosave\"\nversion = 99\nfolder = \"/\"\nsession = \"\"\n";
    std::fs::write(desk.autosaves.join("a.toml"), newer).unwrap();
    std::fs::write(desk.autosaves.join("b.toml"), [0xff, 0x00]).unwrap();
    let (found, unreadable) = abandoned_autosaves(&desk.autosaves);
    assert_eq!((found.len(), unreadable.len()), (0, 2));
    assert!(unreadable.iter().any(|line| line.contains("version 99") && line.contains("a.toml")), "{unreadable:?}");
    assert!(desk.autosaves.join("a.toml").exists());
}

#[test]
fn a_session_that_cannot_be_read_names_the_version_before_it() {
    let desk = Desk::new();
    session::save(&titled(1).apply(&demo()).unwrap(), &desk.session).unwrap();
    std::fs::write(&desk.session, "format = \"doublet session\"\nversion = 1\nnonsense = 1\n").unwrap();
    let message = Document::open(&desk.session).err().unwrap();
    assert!(message.contains("nonsense") && message.contains("flight.toml.bak"), "{message}");
}

/// `/dev/null` and `/dev/stdout` are such files too: as root, a rename would put a file in their place.
#[cfg(unix)]
#[test]
fn a_pipe_is_written_to_and_stays_a_pipe() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = Command::new("cat").arg(&pipe).stdout(Stdio::piped()).spawn().unwrap();
    keep::replace_keeping_previous(&pipe, b"text").unwrap();
    assert_eq!(reader.wait_with_output().unwrap().stdout, b"text");
    assert!(pipe.metadata().unwrap().file_type().is_fifo());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn a_saved_file_keeps_its_permissions_and_its_links() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    std::fs::set_permissions(&desk.session, std::fs::Permissions::from_mode(0o664)).unwrap();
    let link = desk.session.with_file_name("link.toml");
    std::os::unix::fs::symlink(&desk.session, &link).unwrap();
    session::save(&titled(7).apply(&demo()).unwrap(), &link).unwrap();
    assert!(link.is_symlink());
    assert_eq!(number(&session::open(&desk.session).unwrap().session), 7);
    assert_eq!(desk.session.metadata().unwrap().permissions().mode() & 0o777, 0o664);
}

#[test]
fn a_changed_or_missing_recording_is_named_with_its_hashes_and_the_rest_goes_on() {
    let desk = Desk::new();
    let root = desk.session.parent().unwrap();
    let log = root.join("log.csv");
    std::fs::write(&log, "t,q\n0,1\n1,2\n2,3\n3,4\n").unwrap();
    let map = "format = \"doublet channel map\"\nversion = 1\nname = \"x\"\n[roles]\nq = { channel = \"q\", unit = \"deg/s\" }\n";
    std::fs::write(root.join("map.toml"), map).unwrap();
    let was = session::content_hash(&log).unwrap();
    let mut session = demo();
    session.windows.clear();
    let flight = &mut session.flights[0];
    flight.recordings.truncate(1);
    flight.recordings[0].path = "log.csv".to_owned();
    flight.recordings[0].channel_map = "map.toml".into();
    flight.recordings[0].sha256 = Some(was.clone());
    flight.clocks.clear();
    flight.instruments = None;
    let mut lost = flight.clone();
    lost.name = "lost".to_owned();
    lost.recordings[0].path = "lost.csv".to_owned();
    session.flights.push(lost);
    session::save(&session, &desk.session).unwrap();
    std::fs::write(&log, "t,q\n0,1\n1,2\n2,5\n3,4\n").unwrap();
    let now = session::content_hash(&log).unwrap();
    let opened = session::open(&desk.session).unwrap();
    let snapshot = compute(&opened.session, &opened.folder);
    let warnings = |name: &str| {
        snapshot.flights[name]
            .latest()
            .unwrap()
            .recording
            .warnings
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("\n")
    };
    let message = warnings(&session.flights[0].name);
    assert!(message.contains("log.csv") && message.contains(&was) && message.contains(&now), "{message}");
    let error = snapshot.flights["lost"].error().unwrap();
    assert!(error.contains("lost.csv") && error.contains(&was), "{error}");
}

#[test]
fn a_session_changed_on_disk_is_not_overwritten_and_both_versions_stay() {
    let desk = Desk::new();
    let other = |title: &str| {
        let text = std::fs::read_to_string(&desk.session).unwrap();
        let line = text.lines().find(|line| line.starts_with("title")).unwrap().to_owned();
        std::fs::write(
            &desk.session,
            format!("# by an editor\n{}", text.replace(&line, &format!("title = \"{title}\""))),
        )
        .unwrap();
    };
    let held = || {
        [&desk.session, &desk.session.with_file_name("flight.toml.bak")]
            .map(|path| session::open(path).unwrap().session.title)
    };
    let mut document = desk.open();
    assert!(document.changed_on_disk().is_none());
    other("theirs");
    document.history.apply(&titled("mine")).unwrap();
    let refused = document.save(&desk.session).unwrap_err();
    assert!(refused.contains("flight.toml was changed on disk") && refused.contains("another name"), "{refused}");
    let changed = document.changed_on_disk().unwrap();
    assert_eq!(changed.differences, ["title: mine here, theirs on disk"]);
    // Mine under another name: theirs stays as it is.
    document.save(&desk.session.with_file_name("mine.toml")).unwrap();
    assert_eq!(session::open(&desk.session).unwrap().session.title, "theirs");
    drop(document);
    // Theirs taken, undone and saved many times: theirs stays beside it.
    let mut document = desk.open();
    document.history.apply(&titled("mine again")).unwrap();
    other("theirs again");
    document.take_theirs(document.changed_on_disk().unwrap());
    assert_eq!((document.session().title.as_str(), document.history.is_modified()), ("theirs again", false));
    assert!(document.history.undo());
    for title in ["one", "two", "three"] {
        document.history.apply(&titled(title)).unwrap();
        document.save(&desk.session).unwrap();
        assert_eq!(held(), [title, "theirs again"]);
    }
    // What differs in nothing that counts is said to be that, and what is no session cannot be taken.
    let text = std::fs::read_to_string(&desk.session).unwrap();
    std::fs::write(&desk.session, format!("# a remark\n{text}")).unwrap();
    assert!(document.changed_on_disk().unwrap().differences[0].contains("comments"));
    std::fs::write(&desk.session, "half").unwrap();
    assert!(!document.changed_on_disk().unwrap().can_be_taken());
    // The same content with another time is no change.
    std::fs::write(&desk.session, text).unwrap();
    assert!(document.changed_on_disk().is_none());
}

#[test]
fn a_file_saved_over_stays_beside_however_often_this_is_saved() {
    let desk = Desk::new();
    let theirs = desk.session.with_file_name("theirs.toml");
    session::save(&titled("theirs").apply(&demo()).unwrap(), &theirs).unwrap();
    let mut document = desk.open();
    for title in ["one", "two", "three"] {
        document.history.apply(&titled(title)).unwrap();
        document.save(&theirs).unwrap();
    }
    assert_eq!(session::open(&theirs.with_file_name("theirs.toml.bak")).unwrap().session.title, "theirs");
}

#[test]
fn a_state_folder_that_cannot_be_written_is_said_until_it_can() {
    let desk = Desk::new();
    let state = desk.autosaves.parent().unwrap();
    std::fs::write(state, "in the way").unwrap();
    let mut document = Document::open(&desk.session).unwrap();
    assert!(document.keep_in(&desk.autosaves).is_err());
    for title in ["a", "b"] {
        document.history.apply(&titled(title)).unwrap();
        document.autosave();
        let message = document.autosave_error().unwrap();
        assert!(message.contains("autosave"), "{message}");
    }
    assert_eq!(document.held_by(), None, "the file is held all the same");
    assert!(matches!(Lock::try_lock(&desk.session).unwrap(), LockResult::Held(_)));
    std::fs::remove_file(state).unwrap();
    let begun = Instant::now();
    while document.autosave_error().is_some() {
        assert!(begun.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(50));
        document.autosave();
    }
    document.autosave_now().unwrap();
    Desk::crash(document);
    assert_eq!(abandoned_autosaves(&desk.autosaves).0[0].autosave.session.title, "b");
}

#[test]
fn a_name_that_results_cannot_have_is_refused_where_it_is_typed() {
    use doublet_engine::session::WindowEdit;
    let session = demo();
    let from = session.windows[0].name.clone();
    let renamed = |to: &str| Edit::Window(WindowEdit::Rename { from: from.clone(), to: to.to_owned() }).apply(&session);
    assert!(renamed(" ").unwrap_err().to_string().contains("empty"));
    let long = renamed(&"long ".repeat(50)).unwrap_err().to_string();
    assert!(long.contains("250 characters") && long.contains("long long"), "{long}");
    assert!(renamed("short").is_ok());
    assert!(titled("t".repeat(300)).apply(&session).unwrap_err().to_string().contains("300 characters"));
}
