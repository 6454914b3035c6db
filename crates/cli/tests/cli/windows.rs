//! Long windows, many windows and windows whose samples are nothing to go by: what they take and what is said of them.

#![cfg(target_os = "linux")]
use crate::common::flight;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Most that a sample may take, bytes.
const BYTES_PER_SAMPLE: f64 = 1_300.0;

/// Largest resident memory of a run over a window of `samples`, bytes. All threads share one arena: in which of several the allocator puts
/// what moves the peak by a tenth from run to run, and says nothing of what is asked for.
fn peak_bytes(folder: &Path, samples: u32) -> u64 {
    flight::write(folder, samples, |_, _| {});
    let mut run = Command::new(env!("CARGO_BIN_EXE_doublet-cli"));
    run.args(["run", "session.toml", "--out", "results"])
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        .env("MALLOC_ARENA_MAX", "1");
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|number| number.parse().ok());
        peak = peak.max(1024 * kilobytes.unwrap_or(0_u64));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(folder.join("results/histories.h5").is_file(), "{samples} samples");
    peak
}

#[test]
fn a_sample_of_a_window_takes_no_more_than_is_said() {
    let folder = tempfile::tempdir().unwrap();
    // Both are long enough for what a long window does one after the other.
    let (few, many) = (80_000, 160_000);
    let [less, more] = [few, many].map(|samples| peak_bytes(folder.path(), samples) as f64);
    let each = (more - less) / f64::from(many - few);
    println!("{each:.0} bytes a sample: {:.0} MB of {few}, {:.0} MB of {many}", less / 1e6, more / 1e6);
    assert!(each > 100.0 && each < BYTES_PER_SAMPLE, "{each:.0} bytes a sample");
}

/// What a command says of the session in `folder`, both streams together.
fn run_doublet(folder: &Path, command: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_doublet-cli")).args(command).current_dir(folder).output().unwrap();
    [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat()
}

#[test]
fn a_channel_that_gives_nothing_to_go_by_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "session.toml", "--out", "results"];
    let p = flight::NAMES.iter().position(|name| *name == "p").unwrap();
    flight::write(folder.path(), 500, |_, row| row[p] = f64::NAN);
    let line = run_doublet(folder.path(), &run);
    assert!(line.contains("(500 samples of p are not finite)"), "{line}");
    flight::write(folder.path(), 500, |index, row| row[p] = if index == 100 { 1e200 } else { row[p] });
    let line = run_doublet(folder.path(), &run);
    assert!(line.contains("p is 1.74532") && line.contains("e198 at 1.000 s, which is impossible"), "{line}");
    assert!(!line.contains("ay is"), "{line}");
}

/// Replaces the only window of the session in `folder` by many of two seconds.
fn put_windows(folder: &Path, count: usize) {
    let text = std::fs::read_to_string(folder.join("session.toml")).unwrap();
    let mut text = text.split("[[window]]").next().unwrap().to_owned();
    for index in 0..count {
        let start_s = (index % 17) as f64;
        let end_s = start_s + 2.0;
        text += &format!(
            "[[window]]\nname = \"w{index}\"\nflight = \"flight\"\nstart_s = {start_s:?}\nend_s = {end_s:?}\n"
        );
    }
    std::fs::write(folder.join("session.toml"), text).unwrap();
}

#[test]
fn many_windows_are_checked_or_refused_in_a_time_that_grows_with_their_number() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 2_000, |_, _| {});
    let timed = |count: usize| {
        put_windows(folder.path(), count);
        let begun = Instant::now();
        let text = run_doublet(folder.path(), &["check", "session.toml"]);
        println!("{count} manoeuvres: {:.2} s", begun.elapsed().as_secs_f64());
        (text, begun.elapsed())
    };
    let (text, _) = timed(200);
    assert!(text.contains("200 manoeuvres") && !text.contains("samples were checked"), "{text}");
    let (_, quarter) = timed(2_500);
    let (text, many) = timed(10_000);
    assert!(
        text.contains("Only the first 200 manoeuvres were computed; of the other 9800, only samples were checked."),
        "{text}"
    );
    // Four times as many; sixteen times as long were quadratic.
    assert!(many < 8 * quarter + Duration::from_secs(2), "{many:?} of 10,000 manoeuvres, {quarter:?} of 2,500");
    let (text, refused) = timed(100_000);
    assert!(text.contains("the session has 100000 manoeuvres (limit 10000)"), "{text}");
    assert!(refused < 2 * many + Duration::from_secs(5), "{refused:?}");
}

#[test]
fn a_window_behind_those_that_are_computed_is_still_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    flight::write(folder.path(), 2_000, |_, _| {});
    put_windows(folder.path(), 250);
    let path = folder.path().join("session.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, after) = text.rsplit_once("[[window]]").unwrap();
    assert!(after.contains("w249"));
    let outside = "[[window]]\nname = \"outside\"\nflight = \"flight\"\nstart_s = 500.0\nend_s = 510.0\n";
    std::fs::write(&path, format!("{before}{outside}")).unwrap();
    let text = run_doublet(folder.path(), &["check", "session.toml"]);
    assert!(text.contains("bad: manoeuvre 'outside': 0 inertial samples between 500 s and 510 s"), "{text}");
}

#[test]
fn what_a_restarted_recorder_wrote_is_computed_behind_the_restart() {
    let folder = tempfile::tempdir().unwrap();
    // The clock begins again after ten seconds; six more follow.
    flight::write(folder.path(), 1_600, |index, row| row[0] -= if index < 1_000 { 0.0 } else { 10.0 });
    let path = folder.path().join("session.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let window = |name: &str, start_s: f64, end_s: f64| {
        format!("[[window]]\nname = \"{name}\"\nflight = \"flight\"\nstart_s = {start_s:?}\nend_s = {end_s:?}\n")
    };
    let windows = window("before", 1.0, 9.0) + &window("behind", 21.0, 25.0) + &window("between", 11.0, 19.0);
    std::fs::write(&path, text.split("[[window]]").next().unwrap().to_owned() + &windows).unwrap();
    let text = run_doublet(folder.path(), &["check", "session.toml", "--json"]);
    let checked: serde_json::Value = serde_json::from_str(&text).unwrap();
    let findings = checked["findings"].as_array().unwrap();
    let of_code = |code: &str| findings.iter().filter(|finding| finding["code"] == code).collect::<Vec<_>>();
    let [clock] = of_code("clock")[..] else { panic!("{text}") };
    assert_eq!((clock["level"].as_str(), clock["where"].as_str()), (Some("caution"), Some("flight 'flight'")));
    let line = clock["text"].as_str().unwrap();
    assert!(line.contains(" 9.990 s") && line.contains(" 19.990 s"), "{line}");
    // Nothing was recorded in the pause.
    let failed: Vec<_> = of_code("run").iter().filter_map(|finding| finding["where"].as_str()).collect();
    assert!(failed.contains(&"manoeuvre 'between'"), "{text}");
    assert!(!failed.contains(&"manoeuvre 'before'") && !failed.contains(&"manoeuvre 'behind'"), "{text}");
}
