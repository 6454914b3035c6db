//! Faults of a stream that is watched and recorded: clocks that restart, gaps, bad stamps, sources with odd names, files written anew.

#![allow(clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use doublet_core::load::stream::{StreamChannel, StreamRow};
use doublet_engine::live::{
    Feed, LineFormat, LiveSettings, LiveUpdate, LiveWatch, Opening, Recorded, Source, Watched, open,
};
use doublet_engine::session;
use doublet_engine::verdict::Level;

use crate::live::{map_in, text};

/// Rows of one source.
fn rows(source: &str, names: &str, values: impl IntoIterator<Item = Vec<f64>>) -> Vec<StreamRow> {
    let channel = |name: &str| StreamChannel { name: name.to_owned(), unit: None };
    let channels: Arc<[StreamChannel]> = names.split(',').map(channel).collect();
    let row = |values| StreamRow { source: source.into(), channels: Arc::clone(&channels), values };
    values.into_iter().map(row).collect()
}

/// The flight of [`text`] as rows of the source `imu` with times from zero on, for so many seconds.
fn flight(seconds: f64) -> Vec<StreamRow> {
    let lines = text();
    let cells = |line: &String| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
    let start_s = cells(&lines[1])[0];
    let from_zero = lines[1..].iter().map(cells).map(|mut values| {
        values[0] -= start_s;
        values
    });
    rows("imu", &lines[0], from_zero.take_while(|values| values[0] < seconds))
}

/// The same with other values: those of another flight.
fn other_values(mut rows: Vec<StreamRow>) -> Vec<StreamRow> {
    rows.iter_mut().for_each(|row| row.values[1..].iter_mut().for_each(|value| *value *= 1.001));
    rows
}

/// The map by role names, and the settings it is watched with.
fn watched(aircraft: Option<&str>) -> Watched {
    let feed = Some(Feed::Lines("127.0.0.1:0".to_owned(), LineFormat::Json));
    open(&Opening { feed, aircraft: aircraft.map(str::to_owned), ..Opening::default() }).unwrap()
}

fn watch_rows(rows: Vec<StreamRow>, settings: LiveSettings) -> LiveWatch {
    let pieces: VecDeque<Vec<StreamRow>> = rows.chunks(25).map(<[StreamRow]>::to_vec).collect();
    LiveWatch::new(Source::Given(pieces), watched(None).map, settings, None, None).unwrap()
}

/// All updates, each as in real time; the last one has the findings of all.
fn follow(live: &mut LiveWatch) -> Vec<LiveUpdate> {
    let (start, mut updates) = (Instant::now(), Vec::new());
    for tick in 0..100_000 {
        let step = live.step(start + Duration::from_millis(20) * tick).unwrap();
        updates.extend(step.updates);
        if step.is_finished {
            break;
        }
    }
    let findings = updates.iter().flat_map(|update| update.findings.clone()).collect();
    updates.last_mut().unwrap().findings = findings;
    updates
}

fn watch(rows: Vec<StreamRow>) -> LiveUpdate {
    follow(&mut watch_rows(rows, watched(Some("c337f")).settings)).pop().unwrap()
}

/// Watches and records: the last update and what was recorded.
fn record(rows: Vec<StreamRow>, folder: &Path) -> (LiveUpdate, Recorded) {
    let mut live = watch_rows(rows, watched(Some("c337f")).settings);
    live.record(folder, None, Some("builtin:c337f")).unwrap();
    let last = follow(&mut live).pop().unwrap();
    (last, live.finish().unwrap().unwrap())
}

/// Lines of a recorded file, which all have as many cells.
fn lines(path: &Path) -> Vec<String> {
    let lines: Vec<String> = std::fs::read_to_string(path).unwrap().lines().map(str::to_owned).collect();
    let cells = |line: &str| line.split(',').count();
    assert!(lines.iter().all(|line| cells(line) == cells(&lines[0])), "{}", path.display());
    lines
}

#[test]
fn a_clock_that_restarts_in_its_first_seconds_begins_another_flight() {
    let folder = tempfile::tempdir().unwrap();
    let day = folder.path().join("day");
    let (first, second) = (flight(8.0), other_values(flight(8.0)));
    let count = first.len();
    let (last, recorded) = record([first, second].concat(), &day);
    let counts = last.counts;
    assert_eq!((counts.clock_restarts, counts.reordered, counts.late, counts.doubled), (1, 0, 0, 0), "{counts:?}");
    // The pause that is put between the flights is not one of lost samples.
    assert_eq!((counts.lost, counts.stray), (0, 0), "{counts:?}");
    // Eight seconds, a pause of one second, eight seconds.
    assert!((last.time_s - 17.0).abs() < 0.1, "{}", last.time_s);
    assert_eq!(
        (lines(&day.join("imu.csv")).len(), lines(&day.join("restart_1/imu.csv")).len()),
        (count + 1, count + 1)
    );
    assert_eq!(session::open(&recorded.session).unwrap().session.flights.len(), 2);
}

#[test]
fn missing_samples_are_counted_and_stated() {
    let all = flight(12.0);
    let is_missing = |row: &StreamRow| (2.955..8.955).contains(&row.values[0]);
    let missing = all.iter().filter(|row| is_missing(row)).count();
    let last = watch(all.into_iter().filter(|row| !is_missing(row)).collect());
    assert!(missing > 250, "{missing}");
    assert_eq!((last.counts.lost, last.counts.restarts), (missing as u64, 1), "{:?}", last.counts);
    let stated = format!("{missing} inertial samples lost in 6.0 s after t=2.9");
    assert!(last.findings.iter().any(|finding| finding.starts_with(&stated)), "{:?}", last.findings);
}

#[test]
fn a_bad_first_stamp_is_left_out() {
    let rows = flight(6.0);
    let clean = watch(rows.clone());
    for bad_s in [1e9, -5.0e8] {
        let mut first = rows[0].clone();
        first.values[0] = bad_s;
        let last = watch([vec![first], rows.clone()].concat());
        assert_eq!((last.counts.stray, last.counts.clock_restarts), (1, 0), "{bad_s}: {:?}", last.counts);
        assert_eq!((last.time_s, last.counts.samples), (clean.time_s, clean.counts.samples), "{bad_s}");
    }
}

#[test]
fn sources_of_like_names_have_files_of_their_own_and_a_long_name_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let day = folder.path().join("day");
    let long = "x".repeat(300);
    let mut all = flight(4.0);
    for (number, source) in ["gps/1", "gps_1", "GPS_1", &long].into_iter().enumerate() {
        let values = (0..40).map(|k| vec![0.1 * f64::from(k), number as f64]);
        all.extend(rows(source, "time,satellites", values));
    }
    all.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
    let (last, recorded) = record(all, &day);
    assert_eq!(last.alarms, Vec::<String>::new());
    for (number, name) in ["gps_1", "gps_1_2", "GPS_1_3", &"x".repeat(100)].into_iter().enumerate() {
        let found = lines(&day.join(format!("{name}.csv")));
        assert_eq!(found.len(), 41, "{name}");
        assert!(found[1..].iter().all(|line| line.ends_with(&format!(",{number}"))), "{name}: {found:?}");
    }
    assert!(recorded.notes.contains(&"rows of source 'gps_1' are in gps_1_2.csv".to_owned()), "{:?}", recorded.notes);
    assert!(session::open(&recorded.session).is_ok());
}

#[test]
fn a_file_that_cannot_be_made_leaves_out_its_source_alone() {
    let folder = tempfile::tempdir().unwrap();
    let day = folder.path().join("day");
    let gps = rows("gps", "time,satellites", (0..40).map(|k| vec![0.1 * f64::from(k), 7.0]));
    let mut all = [flight(4.0), gps].concat();
    all.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
    let count = flight(4.0).len();
    let mut live = watch_rows(all, watched(Some("c337f")).settings);
    live.record(&day, None, Some("builtin:c337f")).unwrap();
    std::fs::create_dir(day.join("gps.csv")).unwrap();
    let last = follow(&mut live).pop().unwrap();
    let errors = live.recording_errors();
    assert_eq!(last.alarms, errors);
    assert!(errors.len() == 1 && errors[0].starts_with("source 'gps' is not recorded: "), "{errors:?}");
    assert!(!errors[0].contains("disk space"), "{errors:?}");
    live.finish().unwrap().unwrap();
    assert_eq!(lines(&day.join("imu.csv")).len(), count + 1);
}

#[test]
fn without_an_aircraft_limits_alarm_in_flight_alone() {
    let bad_of = |scale: f64| {
        let mut rows = flight(10.0);
        rows.iter_mut().for_each(|row| row.values[7] *= scale);
        let mut settings = watched(None).settings;
        settings.limit(&["alpha=:-60deg".parse().unwrap()]);
        let updates = follow(&mut watch_rows(rows, settings));
        let is_bad = |update: &&LiveUpdate| update.limits.iter().any(|limit| limit.level == Level::Bad);
        (updates.iter().filter(is_bad).count(), updates.len())
    };
    let ((taxiing, _), (flying, of)) = (bad_of(0.1), bad_of(1.0));
    assert!(taxiing == 0 && flying > of / 2, "{taxiing} {flying} of {of}");
}

/// A growing file that is watched and recorded.
fn growing(folder: &Path, head: &[String], wait: Option<Duration>) -> LiveWatch {
    let path = folder.join("log.csv");
    std::fs::write(&path, head.join("\n") + "\n").unwrap();
    let map = Some(map_in(folder).display().to_string());
    let (feed, aircraft) = (Some(Feed::File(path.display().to_string())), Some("c337f".to_owned()));
    let watched = open(&Opening { feed, map, aircraft, wait, ..Opening::default() }).unwrap();
    let mut live = LiveWatch::new(watched.source, watched.map, watched.settings, None, wait).unwrap();
    live.record(&folder.join("day"), None, Some("builtin:c337f")).unwrap();
    live
}

fn step(live: &mut LiveWatch) -> Option<LiveUpdate> {
    (0..10).fold(None, |latest, _| live.step(Instant::now()).unwrap().updates.pop().or(latest))
}

#[test]
fn a_file_cut_and_written_anew_within_ten_seconds_is_another_flight() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let all = text();
    let mut live = growing(folder.path(), &all[..400], None);
    step(&mut live).unwrap();
    let changed = |line: &String| format!("{},0.125", line.rsplit_once(',').unwrap().0);
    let changed: Vec<String> = all[1..].iter().map(changed).collect();
    std::fs::write(&path, [&all[..1], &changed[..30]].concat().join("\n") + "\n").unwrap();
    step(&mut live);
    std::fs::write(&path, [&all[..1], &changed[..]].concat().join("\n") + "\n").unwrap();
    let counts = step(&mut live).unwrap().counts;
    assert_eq!((counts.clock_restarts, counts.reordered, counts.late), (1, 0, 0), "{counts:?}");
    live.stop();
    live.step(Instant::now()).unwrap();
    live.finish().unwrap().unwrap();
    assert_eq!(lines(&folder.path().join("day/restart_1/log.csv")).len(), all.len());
}

/// A file that takes the place of another cannot be opened at first, and has its columns in another order.
#[cfg(unix)]
#[test]
fn a_rotated_file_is_tried_until_it_opens_and_its_columns_are_known_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let all = text();
    let mut live = growing(folder.path(), &all[..200], None);
    step(&mut live).unwrap();
    std::fs::remove_file(&path).unwrap();
    // A socket has a name and cannot be opened as a file.
    let socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
    step(&mut live);
    drop(socket);
    std::fs::remove_file(&path).unwrap();
    let reversed = |line: &String| line.split(',').rev().collect::<Vec<_>>().join(",");
    let rest = std::iter::once(&all[0]).chain(&all[200..]).map(reversed).collect::<Vec<_>>();
    std::fs::write(&path, rest.join("\n") + "\n").unwrap();
    let last = step(&mut live).unwrap();
    let end_s: f64 = all.last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(end_s - last.time_s < 1.0, "{} {end_s}", last.time_s);
    live.stop();
    live.step(Instant::now()).unwrap();
    live.finish().unwrap().unwrap();
    let numbers = |line: &String| line.split(',').map(|cell| cell.parse::<f64>().unwrap_or(-1.0)).collect::<Vec<_>>();
    let found: Vec<Vec<f64>> = lines(&folder.path().join("day/log.csv")).iter().map(numbers).collect();
    assert!(found == all.iter().map(numbers).collect::<Vec<_>>(), "{} {}", found.len(), all.len());
}

#[test]
fn a_file_whose_time_lies_in_the_future_ends_after_the_wait() {
    let folder = tempfile::tempdir().unwrap();
    let mut live = growing(folder.path(), &text()[..200], Some(Duration::from_millis(300)));
    let file = std::fs::File::options().write(true).open(folder.path().join("log.csv")).unwrap();
    file.set_modified(SystemTime::now() + Duration::from_secs(3600)).unwrap();
    let start = Instant::now();
    while !live.step(Instant::now()).unwrap().is_finished {
        assert!(start.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(start.elapsed() >= Duration::from_millis(300), "{:?}", start.elapsed());
}
