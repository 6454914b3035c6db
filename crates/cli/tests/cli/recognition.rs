//! Recordings of strangers, each with what its channels are: `map --json` names no role wrongly without asking, and asks little.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use doublet_core::quantity::Unit;
use serde_json::Value;

use crate::common::{doublet, root};
use crate::shared;

/// Roles right over all files, at least.
const LEAST_RIGHT: usize = 540;
/// Questions of a file, at most in the median.
const MOST_QUESTIONS: usize = 2;

/// What is said of one file, or of all.
#[derive(Clone, Debug, Default)]
struct Score {
    right: usize,
    wrong: usize,
    silent: Vec<String>,
    questions: usize,
    rows: Vec<Weighed>,
}

/// A role with the confidence that is stated, whether it is right and whether it is asked for.
#[derive(Clone, Copy, Debug)]
struct Weighed {
    confidence: f64,
    is_right: bool,
    is_asked: bool,
}

/// A name without the unit in brackets at its end.
fn stem(name: &str) -> &str {
    let name = name.trim().trim_start_matches(['#', '%']).trim();
    let bracket = name.strip_suffix([')', ']']).and_then(|name| name.rfind(['(', '[']));
    match bracket {
        Some(at) if at > 0 && !name[at + 1..name.len() - 1].bytes().all(|byte| byte.is_ascii_digit()) => {
            name[..at].trim()
        }
        _ => name,
    }
}

/// What is known of a channel.
fn find<'t>(truth: &'t Value, source: &str, channel: &str) -> Option<&'t Value> {
    let channels = truth["channels"].as_object()?;
    let last = source.rsplit('.').next().unwrap_or(source);
    let full = [
        channel.to_owned(),
        format!("{source}/{channel}"),
        format!("{source}.{channel}"),
        format!("{last}/{channel}"),
        format!("{source}::{channel}"),
    ];
    let exact = full.iter().find_map(|name| channels.get(name));
    let alike = |(name, _): &(&String, &Value)| match name.split_once("::") {
        Some((of, name)) => source.ends_with(of) && stem(name) == stem(channel),
        None => stem(name) == stem(channel),
    };
    exact.or_else(|| {
        let mut all: Vec<(&String, &Value)> = channels.iter().filter(alike).collect();
        all.sort_by_key(|(_, channel)| channel["role"].is_null());
        all.first().map(|(_, channel)| *channel)
    })
}

/// Roles that a channel of the truth can play.
fn roles_of(channel: &Value) -> Vec<&str> {
    let of = |value: &'_ Value| match value {
        Value::String(_) => vec![value.clone()],
        Value::Array(all) => all.clone(),
        _ => Vec::new(),
    };
    let all = [of(&channel["role"]), of(&channel["also"])].concat();
    let names: Vec<String> = all.iter().filter_map(|name| name.as_str().map(str::to_owned)).collect();
    ROLE_NAMES.iter().copied().filter(|name| names.iter().any(|other| other == name)).collect()
}

/// Names of roles as they are written in maps.
static ROLE_NAMES: std::sync::LazyLock<Vec<&'static str>> =
    std::sync::LazyLock::new(|| doublet_core::quantity::Role::ALL.iter().map(|role| role.name()).collect());

/// Factor and offset of a unit to SI.
fn to_si(unit: &str, value: f64) -> Option<f64> {
    if let Some(degrees) = unit.strip_prefix("1e-7 ") {
        return Some(1e-7 * Unit::parse(degrees).ok()?.to_si(value));
    }
    Unit::parse(unit).ok().map(|unit| unit.to_si(value))
}

/// Whether a row reads the unit that is true; true where neither is known.
fn is_unit_right(row: &Value, truth: &Value) -> bool {
    let (Some(read), Some(known)) = (row["unit"].as_str(), truth["unit"].as_str()) else { return true };
    if known == "norm" {
        return false;
    }
    let scale = row["scale"].as_f64().unwrap_or(1.0);
    let pairs = [0.0, 100.0].map(|value| Some((scale * to_si(read, value)?, to_si(known, value)?)));
    pairs.iter().flatten().all(|(read, known)| (read - known).abs() <= 0.005 * known.abs() + 1e-9)
}

/// Compares what is said of a file with what is known.
fn score(truth: &Value, recognised: &Value) -> Score {
    let texts = |key: &str| -> Vec<String> {
        recognised[key].as_array().into_iter().flatten().filter_map(|text| text.as_str().map(str::to_owned)).collect()
    };
    let (questions, contradictions) = (texts("questions"), texts("contradictions"));
    let mut score = Score { questions: questions.len(), ..Score::default() };
    for row in recognised["roles"].as_array().into_iter().flatten() {
        let text = |key: &str| row[key].as_str().unwrap_or_default();
        let (role, source, channel) = (text("role"), text("source"), text("channel"));
        let known = find(truth, source, channel);
        let is_unknown = known.is_some_and(|known| {
            known["unknown"].as_bool() == Some(true)
                || known["role"].is_null() && known["note"].as_str().is_some_and(|note| note.starts_with("unknown"))
        });
        if is_unknown {
            continue;
        }
        let roles = known.map(roles_of).unwrap_or_default();
        let sign = row["sign"].as_f64().unwrap_or(1.0);
        let is_height = role == "z" && roles.iter().any(|role| role.ends_with("altitude"));
        let is_asked = questions.iter().any(|question| question.contains(&format!("'{channel}'")))
            || contradictions
                .iter()
                .any(|text| text.starts_with(&format!("{role}:")) || text.contains(&format!("'{channel}'")));
        let wrong = score.wrong;
        let mut complain = |what: &str| {
            score.wrong += 1;
            if !is_asked {
                score.silent.push(format!("{what} of {role} <- {source}/{channel}"));
            }
        };
        if is_height {
            if sign > 0.0 {
                complain("sign");
            }
        } else if !roles.contains(&role) {
            complain("role");
        } else {
            let known = known.unwrap_or(&Value::Null);
            let is_left = role == "delta_a" && known["part"].as_str() == Some("left");
            let wanted = known["sign"].as_f64().unwrap_or(0.0) * if is_left { -1.0 } else { 1.0 };
            if wanted != 0.0 && wanted != sign {
                complain("sign");
            } else if !is_unit_right(row, known) {
                complain("unit");
            }
            score.right += 1;
        }
        let is_right = score.wrong == wrong;
        score.rows.push(Weighed { confidence: row["confidence"].as_f64().unwrap_or(f64::NAN), is_right, is_asked });
    }
    score
}

/// The score of every open file of a corpus.
fn scores(folder: &Path) -> Vec<(String, Score)> {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap().replace("NaN", "null");
    let truth: Value = serde_json::from_str(&text).unwrap();
    let open: Vec<&Value> =
        truth.as_array().unwrap().iter().filter(|entry| entry["split"].as_str() == Some("open")).collect();
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(entry) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = entry["file"].as_str().unwrap();
            let output = doublet(&root(), &["map", folder.join(name).to_str().unwrap(), "--json"]);
            // What cannot be read takes no role.
            let recognised: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
            found.lock().unwrap().push((name.to_owned(), score(entry, &recognised)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    found.into_inner().unwrap()
}

/// Bounds of confidence, below 0.8 to above 0.98, between which rows must be right and unasked more and more often.
const CONFIDENCES: [f64; 5] = [0.0, 0.8, 0.95, 0.98, 1.0];
/// Difference of stated confidence and share right, at most, of 20 rows or more.
const MOST_MISCALIBRATED: f64 = 0.08;

/// Rows of more confidence are more often right and less often asked for, and the confidence is the share that is right.
fn check_confidence(rows: &[Weighed]) {
    let mut last = (0.0, 0.0);
    for bounds in CONFIDENCES.windows(2) {
        let is_last = bounds[1] == 1.0;
        let is_in = |row: &&Weighed| row.confidence >= bounds[0] && (row.confidence < bounds[1] || is_last);
        let inside: Vec<&Weighed> = rows.iter().filter(is_in).collect();
        let share = |count: usize| count as f64 / inside.len() as f64;
        let right = share(inside.iter().filter(|row| row.is_right).count());
        let unasked = share(inside.iter().filter(|row| !row.is_asked).count());
        let stated = inside.iter().map(|row| row.confidence).sum::<f64>() / inside.len() as f64;
        println!(
            "confidence {bounds:?}: {} rows, {right:.3} right, {unasked:.3} unasked, {stated:.3} stated",
            inside.len()
        );
        assert!(right >= last.0 && unasked >= last.1, "{bounds:?}");
        assert!(inside.len() < 20 || (right - stated).abs() < MOST_MISCALIBRATED, "{bounds:?}");
        last = (right, unasked);
    }
    assert!(rows.iter().all(|row| (0.0..=1.0).contains(&row.confidence)));
}

#[test]
fn strangers_recordings_are_recognised_or_asked_about() {
    let Some(folder) = shared::shared("data/strangers") else { return };
    let mut all = scores(&folder.join("manned"));
    all.extend(scores(&folder.join("uav")));
    let right: usize = all.iter().map(|(_, score)| score.right).sum();
    let wrong: usize = all.iter().map(|(_, score)| score.wrong).sum();
    let mut questions: Vec<usize> = all.iter().map(|(_, score)| score.questions).collect();
    questions.sort_unstable();
    let median = questions[questions.len() / 2];
    println!(
        "{} files: {right} roles right, {wrong} wrong and asked about, {median} questions in the median",
        all.len()
    );
    let silent: Vec<String> =
        all.iter().flat_map(|(file, score)| score.silent.iter().map(move |text| format!("{file}: {text}"))).collect();
    assert_eq!(silent, Vec::<String>::new());
    check_confidence(&all.iter().flat_map(|(_, score)| score.rows.clone()).collect::<Vec<_>>());
    assert!(right >= LEAST_RIGHT, "{right} roles right");
    assert!(median <= MOST_QUESTIONS, "{median} questions in the median of {questions:?}");
}
