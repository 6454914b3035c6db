//! Folders that doublet writes into: its own files are replaced in one step, the user's stay, kills leave no mixture and no litter.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use doublet_engine::keep::{Earlier, MANIFEST, Put, PutError, Staging, sweep};
use doublet_engine::session;
use rand::{RngExt, SeedableRng};

/// Kills of the test.
const KILLS: usize = 100;
/// Longest time a child writes before it is killed: many sets.
const LONGEST_MS: f64 = 40.0;
/// Set for the process that is killed: the folder it writes into.
const CHILD: &str = "DOUBLET_TEST_FOLDER";
/// Files of a set.
const FILES: [&str; 6] =
    ["results.json", "derivatives.csv", "fits.csv", "histories_csv/e1.csv", "histories_csv/e2.csv", "z.md"];

fn put(folder: &Path, set: &str, files: &[&str], content: &str) -> Result<Put, PutError> {
    let staging = Staging::new(folder)?;
    for file in files {
        let path = staging.path().join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    staging.put(set, Earlier::Removed, &|_| false)
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).unwrap()
}

/// Every file below a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(inner) = folders.pop() {
        for entry in std::fs::read_dir(inner).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    found.sort();
    found
}

/// What dead writers leave behind, in a folder and the one above it.
fn litter(folder: &Path) -> Vec<String> {
    let above = std::fs::read_dir(folder.parent().unwrap()).unwrap();
    let all = above.chain(std::fs::read_dir(folder).unwrap());
    let names = all.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.starts_with('.')).collect()
}

#[test]
fn only_files_of_doublet_are_replaced() {
    // With few files of the user the folder is exchanged whole, with many it is changed file by file.
    for many in [0, 2100] {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("results");
        put(&folder, "results", &["a.csv", "b.csv", "inner/old.csv"], "one").unwrap();
        put(&folder, "report x", &["x.html"], "report").unwrap();
        std::fs::write(folder.join("mine.txt"), "mine").unwrap();
        std::fs::create_dir_all(folder.join("plots/deep")).unwrap();
        std::fs::write(folder.join("plots/deep/a.png"), "picture").unwrap();
        std::fs::write(folder.join("inner/mine.csv"), "mine too").unwrap();
        (0..many).for_each(|number| std::fs::write(folder.join(format!("plots/{number}")), "").unwrap());
        let put = put(&folder, "results", &["a.csv", "c.csv", "inner/new.csv"], "two").unwrap();
        assert_eq!((read(&folder, "mine.txt"), read(&folder, "plots/deep/a.png")), ("mine".into(), "picture".into()));
        assert_eq!((read(&folder, "a.csv"), read(&folder, "inner/new.csv")), ("two".into(), "two".into()));
        let present: Vec<_> = names(&folder).into_iter().filter(|name| !name.starts_with("plots/")).collect();
        let expected = ["a.csv", "c.csv", MANIFEST, "inner/mine.csv", "inner/new.csv", "mine.txt", "x.html"];
        assert_eq!(present, expected, "{many} files");
        assert_eq!(std::fs::read_dir(folder.join("plots")).unwrap().count(), many + 1);
        assert_eq!((litter(&folder), put.kept.len(), put.files.len()), (Vec::<String>::new(), 0, 3));
    }
}

#[test]
fn a_file_the_user_changed_is_kept_aside_and_one_of_the_user_is_never_replaced() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("results");
    put(&folder, "results", &["a.csv", "b.csv"], "one").unwrap();
    for (content, kept) in [("edited", "a.csv.bak"), ("edited again", "a.csv.bak2")] {
        std::fs::write(folder.join("a.csv"), content).unwrap();
        let put = put(&folder, "results", &["a.csv", "b.csv"], "next").unwrap();
        assert_eq!((read(&folder, "a.csv"), read(&folder, kept)), ("next".into(), content.into()));
        let notes: Vec<_> = put.notes().collect();
        assert!(notes.len() == 1 && notes[0].contains("a.csv was changed") && notes[0].contains(kept), "{notes:?}");
    }
    // Changed, and not part of the new set: it is the user's now.
    std::fs::write(folder.join("b.csv"), "edited").unwrap();
    put(&folder, "results", &["a.csv"], "next").unwrap();
    assert_eq!(read(&folder, "b.csv"), "edited");
    let before = names(&folder);
    let refused = put(&folder, "results", &["a.csv", "b.csv"], "last").unwrap_err().to_string();
    assert!(refused.contains("b.csv") && refused.contains("another folder"), "{refused}");
    assert_eq!((read(&folder, "a.csv"), names(&folder), litter(&folder)), ("next".into(), before, Vec::new()));
}

#[cfg(unix)]
#[test]
fn a_link_to_a_folder_stays_a_link_and_permissions_stay() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().unwrap();
    let (real, link) = (root.path().join("real"), root.path().join("link"));
    std::os::unix::fs::symlink("real", &link).unwrap();
    put(&link, "results", &["a.csv"], "one").unwrap();
    assert!(link.is_symlink() && read(&real, "a.csv") == "one", "a link to what does not exist yet");
    std::fs::set_permissions(&real, std::fs::Permissions::from_mode(0o750)).unwrap();
    put(&link, "results", &["a.csv"], "two").unwrap();
    assert!(link.is_symlink() && read(&real, "a.csv") == "two");
    assert_eq!(real.metadata().unwrap().permissions().mode() & 0o777, 0o750);
    let new = root.path().join("new");
    std::fs::create_dir(&new).unwrap();
    let usual = new.metadata().unwrap().permissions().mode();
    put(&root.path().join("made"), "results", &["a.csv"], "one").unwrap();
    assert_eq!(root.path().join("made").metadata().unwrap().permissions().mode(), usual, "as any new folder");
}

#[test]
fn what_a_living_writer_holds_is_not_swept_and_what_a_dead_one_left_is() {
    let root = tempfile::tempdir().unwrap();
    let living = Staging::new(&root.path().join("results")).unwrap();
    let dead = root.path().join(".doublet-a1B2c3");
    std::fs::create_dir_all(dead.join("inner")).unwrap();
    std::fs::write(dead.join("inner/a.csv"), "half").unwrap();
    std::fs::write(root.path().join("..doublet-a1B2c3.lock"), "").unwrap();
    std::fs::create_dir(root.path().join(".doublet-notes")).unwrap();
    std::fs::create_dir(root.path().join(".doublet-photos")).unwrap();
    let (left, held) =
        (root.path().join(".s.toml.bak.a1b2c3.doublet-part"), root.path().join(".x.d4e5f6.doublet-part"));
    std::fs::write(&left, "half").unwrap();
    let writing = std::fs::File::create(&held).unwrap();
    writing.try_lock().unwrap();
    sweep(root.path());
    assert!(living.path().is_dir() && held.exists(), "their writers live");
    assert!(root.path().join(".doublet-notes").is_dir(), "not a name of ours");
    assert!(root.path().join(".doublet-photos").is_dir(), "no writer locked it");
    assert!(!dead.exists() && !left.exists());
    // Saving a session sweeps its folder too.
    std::fs::write(&left, "half").unwrap();
    let demo = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    session::save(&demo, &root.path().join("s.toml")).unwrap();
    assert!(!left.exists());
}

#[test]
fn a_file_that_came_in_while_folders_changed_places_is_not_swept() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("results");
    put(&folder, "results", &["a.csv"], "one").unwrap();
    std::fs::write(folder.join("mine.txt"), "only copy").unwrap();
    let left = root.path().join(".doublet-a1B2c3");
    std::fs::rename(&folder, &left).unwrap();
    std::fs::write(root.path().join("..doublet-a1B2c3.lock"), "").unwrap();
    sweep(root.path());
    assert_eq!(names(&left), [MANIFEST, "mine.txt"]);
}

/// The program that is killed: puts one set after another into the folder.
#[test]
#[ignore = "run by the test that kills it"]
fn child_that_writes_sets() {
    let Some(folder) = std::env::var_os(CHILD).map(PathBuf::from) else { return };
    for number in 0.. {
        put(&folder, "results", &FILES, &format!("set {}", number % 10).repeat(2000)).unwrap();
        if number == 0 {
            println!("STARTED");
        }
    }
}

#[test]
fn killed_writers_leave_one_whole_set_and_the_files_of_the_user() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("results");
    put(&folder, "results", &FILES, "set 0").unwrap();
    std::fs::write(folder.join("mine.txt"), "mine").unwrap();
    std::fs::create_dir(folder.join("plots")).unwrap();
    std::fs::write(folder.join("plots/a.png"), "picture").unwrap();
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(17);
    let mut left_behind = 0;
    for kill in 0..KILLS {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "folders::child_that_writes_sets", "--ignored", "--nocapture", "--test-threads=1"])
            .env(CHILD, &folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains("STARTED")));
        std::thread::sleep(Duration::from_secs_f64(1e-3 * random.random_range(0.0..LONGEST_MS)));
        child.kill().unwrap();
        child.wait().unwrap();
        left_behind += usize::from(!litter(&folder).is_empty());
        let contents: BTreeSet<_> = FILES.iter().map(|file| read(&folder, file)).collect();
        assert_eq!(contents.len(), 1, "kill {kill}: files of two sets");
        assert_eq!((read(&folder, "mine.txt"), read(&folder, "plots/a.png")), ("mine".into(), "picture".into()));
    }
    assert!(left_behind > 0, "no kill hit a writer at work");
    put(&folder, "results", &FILES, "set last").unwrap();
    assert_eq!(litter(&folder), Vec::<String>::new());
    assert_eq!(names(&folder).len(), FILES.len() + 3);
}
