//! Batches: sweeps, failures as rows, resumption.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use doublet_engine::batch::{Store, Tally, compute, jobs, write};
use doublet_engine::graph::Cache;
use doublet_engine::run::{Control, Scope, Snapshot, run};
use doublet_engine::session::{self, Session};

/// A part of the shipped flight that takes little time: one window, two coefficients.
fn small() -> Session {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    let elevator = session.windows.iter().position(|w| w.surface == Some(session::Surface::Elevator)).unwrap();
    session.windows = vec![session.windows[elevator].clone()];
    session.windows[0].name = "e.1".to_owned();
    session.structure.models.retain(|(coefficient, _)| ["CZ", "Cm"].contains(&coefficient.name()));
    session
}

const SWEEP: &str = "format = \"doublet sweep\"\nversion = 1\nsession = \"base.toml\"\n\
    [[vary]]\nsetting = \"filter.measurement_noise.alpha\"\nvalues = [0.002, 0.004]\n\
    [[vary]]\nsetting = \"preparation.path\"\nvalues = [\"filtered\", \"smoothed\"]\n\
    [[vary]]\nsetting = \"window 'e.1'.role\"\nvalues = [\"identification\"]\n";

struct Campaign {
    folder: tempfile::TempDir,
    out: PathBuf,
}

impl Campaign {
    fn new(sweep: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("base")).unwrap();
        session::save(&small(), &folder.path().join("base/base.toml")).unwrap();
        std::fs::write(folder.path().join("sweep.toml"), sweep.replace("base.toml", "base/base.toml")).unwrap();
        let out = folder.path().join("table/results.csv");
        std::fs::create_dir(folder.path().join("table")).unwrap();
        Self { out, folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn run(&self, out: &Path) -> (Tally, Vec<csv::StringRecord>) {
        let jobs = jobs(self.path()).unwrap();
        let store = Store::beside(out).unwrap();
        let tally = compute(&jobs, &store, &|_, _| {}).unwrap();
        write(&jobs, &store, out).unwrap();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(out).unwrap();
        (tally, reader.records().map(Result::unwrap).collect())
    }
}

fn column<'r>(rows: &'r [csv::StringRecord], name: &str) -> Vec<&'r str> {
    let at = rows[0].iter().position(|cell| cell == name).unwrap_or_else(|| panic!("no column {name}"));
    rows[1..].iter().map(|row| &row[at]).collect()
}

#[test]
fn a_batch_sweeps_settings_keeps_failures_as_rows_and_resumes() {
    let campaign = Campaign::new(SWEEP);
    std::fs::write(campaign.path().join("broken.toml"), "format = \"doublet session\"\nversion = 1\nx = 1\n").unwrap();
    std::fs::write(campaign.path().join("notes.toml"), "format = \"something else\"\n").unwrap();
    let (tally, rows) = campaign.run(&campaign.out);
    assert_eq!(tally, Tally { computed: 5, found: 0, failed: 1 });
    let errors = column(&rows, "error");
    assert_eq!(errors.iter().filter(|error| !error.is_empty()).count(), 1);
    assert!(errors[0].contains("unknown field `x`"), "{}", errors[0]);
    assert_eq!(column(&rows, "session")[0], "broken.toml");
    let noise = column(&rows, "filter.measurement_noise.alpha");
    let path = column(&rows, "preparation.path");
    let estimate = column(&rows, "estimate");
    let cm_q = |wanted: (&str, &str)| {
        let rows = column(&rows, "derivative").into_iter().zip(noise.iter().zip(&path).zip(&estimate));
        let mut found = rows.filter(|(name, ((n, p), _))| *name == "Cm_q" && (**n, **p) == wanted);
        found.next().unwrap().1.1.parse::<f64>().unwrap()
    };
    // The same as the session alone, its settings changed by hand.
    let mut by_hand = small();
    by_hand.filter.measurement_noise[doublet_core::reconstruct::Measurement::AngleOfAttack as usize] = 0.004;
    by_hand.preparation.path = session::PathSource::Filtered;
    let alone = Campaign::new(SWEEP);
    std::fs::remove_file(alone.path().join("sweep.toml")).unwrap();
    session::save(&by_hand, &alone.path().join("by_hand.toml")).unwrap();
    let (_, single) = alone.run(&alone.out);
    let at = column(&single, "derivative").iter().position(|name| *name == "Cm_q").unwrap();
    assert_eq!(column(&single, "estimate")[at].parse::<f64>().unwrap(), cm_q(("0.004", "filtered")));
    let all = [("0.002", "filtered"), ("0.002", "smoothed"), ("0.004", "filtered"), ("0.004", "smoothed")].map(cm_q);
    assert!((0..4).all(|i| (i + 1..4).all(|j| all[i] != all[j])), "every combination differs: {all:?}");
    // Taken up again: only the failure is tried anew; a lost or half-written run is computed again.
    let (again, same) = campaign.run(&campaign.out);
    assert_eq!(again, Tally { computed: 1, found: 4, failed: 1 });
    assert_eq!(rows, same);
    let runs = campaign.path().join("table/results.csv.runs");
    let kept: Vec<_> = std::fs::read_dir(&runs).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(kept.len(), 5);
    let whole = kept.iter().find(|path| std::fs::read_to_string(path).unwrap().contains("Cm_q"));
    std::fs::write(whole.unwrap(), "{\"estimates\": [").unwrap();
    let (third, same) = campaign.run(&campaign.out);
    assert_eq!(third, Tally { computed: 2, found: 3, failed: 1 });
    assert_eq!(rows, same);
    // A changed session is another run.
    let mut changed = small();
    changed.preparation.settle_s = 0.5;
    session::save(&changed, &campaign.path().join("base/base.toml")).unwrap();
    assert_eq!(campaign.run(&campaign.out).0.found, 0);
}

#[test]
fn a_batch_split_into_tasks_is_gathered_without_computing() {
    let campaign = Campaign::new(SWEEP);
    let jobs = jobs(campaign.path()).unwrap();
    let store = Store::beside(&campaign.out).unwrap();
    let started = AtomicUsize::new(0);
    for part in 0..3 {
        let mine: Vec<_> = jobs.iter().skip(part).step_by(3).cloned().collect();
        if part == 2 {
            assert!(write(&jobs, &store, &campaign.out).unwrap_err().contains("not finished"));
        }
        let count = |_: usize, _: &str| {
            started.fetch_add(1, Ordering::Relaxed);
        };
        compute(&mine, &store, &count).unwrap();
    }
    assert_eq!(started.into_inner(), jobs.len());
    let (tally, rows) = campaign.run(&campaign.out);
    assert_eq!(tally, Tally { computed: 0, found: 4, failed: 0 });
    assert!(rows.len() > 4);
    // The Parquet table has the same cells.
    let parquet = campaign.path().join("table/results.parquet");
    std::fs::rename(campaign.path().join("table/results.csv.runs"), campaign.path().join("table/results.parquet.runs"))
        .unwrap();
    write(&jobs, &Store::beside(&parquet).unwrap(), &parquet).unwrap();
    let file = parquet::file::reader::SerializedFileReader::try_from(parquet.as_path()).unwrap();
    let mut read = vec![rows[0].clone()];
    for record in file {
        let record = record.unwrap();
        read.push(record.get_column_iter().map(|(_, field)| cell(field)).collect());
    }
    let names: Vec<String> = rows[0].iter().map(str::to_owned).collect();
    assert!(names.contains(&"corrected_standard_error".to_owned()));
    assert_eq!(read, rows);
}

/// The shipped aircraft with its charts in a folder, where they can be edited.
fn put_aircraft(folder: &Path) {
    for (kind, name) in [
        ("aircraft", "aircraft/c337f.toml"),
        ("propulsion", "propulsion/io360_chart.toml"),
        ("propulsion", "propulsion/mtv12_propeller.toml"),
    ] {
        let text = doublet_engine::builtin::text(kind, name).unwrap();
        std::fs::write(folder.join(Path::new(name).file_name().unwrap()), text).unwrap();
    }
}

/// The propeller of [`put_aircraft`] with another area: less thrust goes through it.
fn edit_propeller(folder: &Path) {
    let place = folder.join("mtv12_propeller.toml");
    let text = std::fs::read_to_string(&place).unwrap();
    let edited = text.replace("diameter_m = 1.92", "diameter_m = 1.72");
    assert_ne!(text, edited);
    std::fs::write(&place, edited).unwrap();
}

#[test]
fn a_propeller_map_changed_on_disk_is_read_again_by_the_window_and_by_a_batch() {
    let folder = tempfile::tempdir().unwrap();
    put_aircraft(folder.path());
    let mut session = small();
    session.aircraft = Some("c337f.toml".to_owned());
    session.structure.models.retain(|(coefficient, _)| coefficient.name() == "CZ");
    let file = folder.path().join("one.toml");
    session::save(&session, &file).unwrap();
    let cache = Cache::new(1 << 30);
    let thrust = |previous: &Snapshot| {
        let scope =
            Scope { session: &session, folder: folder.path(), first: None, studies: &[], cause: "test", generation: 1 };
        let snapshot = run(&scope, previous, &cache, &Control::default(), &|_| ());
        let aero = Arc::clone(snapshot.windows["e.1"].aero.ready().unwrap());
        (aero.data.engines[0].thrust_n[0], snapshot)
    };
    let out = folder.path().join("results.csv");
    let store = Store::beside(&out).unwrap();
    let of_batch = || compute(&jobs(&file).unwrap(), &store, &|_, _| {}).unwrap();
    let (before, snapshot) = thrust(&Snapshot::default());
    assert_eq!((of_batch().computed, of_batch().found), (1, 1));
    edit_propeller(folder.path());
    let (after, _) = thrust(&snapshot);
    assert!((after / before - 1.0).abs() > 0.01, "{before} N, {after} N");
    assert_eq!(of_batch(), Tally { computed: 1, found: 0, failed: 0 });
}

fn cell(field: &parquet::record::Field) -> String {
    use parquet::record::Field;
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::Double(value) => value.to_string(),
        Field::Long(value) => value.to_string(),
        other => panic!("{other} is no cell"),
    }
}

#[test]
fn sweeps_say_what_is_wrong_with_them() {
    let refused = |sweep: &str| jobs(Campaign::new(sweep).path()).unwrap_err();
    let typo = refused(&SWEEP.replace("values = [0.002", "vaules = [0.002"));
    assert!(typo.contains("vaules") && typo.contains("sweep.toml"), "{typo}");
    assert!(refused(&SWEEP.replace("[0.002, 0.004]", "[]")).contains("has no values"));
    assert!(refused(&SWEEP.replace("version = 1", "version = 9")).contains("newer"));
    assert!(refused(&SWEEP.replace("'e.1'.role", "'e.1.role")).contains("open quote"));
    assert!(refused(&SWEEP.replace("base.toml", "gone.toml")).contains("gone.toml"));
    let many: String =
        (0..7).map(|i| format!("[[vary]]\nsetting = \"a{i}\"\nvalues = [{}]\n", "1, ".repeat(10))).collect();
    assert!(refused(&format!("{SWEEP}{many}")).contains("combinations"));
    // A setting that the session cannot have with any value is refused before the first run.
    for (from, to, part) in [
        ("measurement_noise.alpha", "measurement_noise.alfa", "alfa"),
        ("'e.1'", "'e.2'", "no setting 'window 'e.2'.role'"),
        ("[0.002, 0.004]", "[\"much\"]", "much"),
    ] {
        let message = refused(&SWEEP.replace(from, to));
        assert!(message.contains(part) && message.contains("sweep.toml"), "{part}: {message}");
    }
    // A value it cannot have becomes the error of its runs.
    let campaign = Campaign::new(&SWEEP.replace("[0.002, 0.004]", "[0.002, \"much\"]"));
    let all = jobs(campaign.path()).unwrap();
    let failed = all.iter().filter(|job| job.session.as_ref().is_err_and(|error| error.contains("much")));
    assert_eq!((all.len(), failed.count()), (4, 2));
}
