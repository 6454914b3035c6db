//! Recordings whose channels are renamed to `ch1`, `ch2` ...: what values alone show of their roles, and that all of it is asked for.

use std::path::{Path, PathBuf};

use doublet_core::load::{By, Probe, guess, inspect};
use doublet_core::quantity::{Role, Unit};
use serde_json::Value;

use crate::common::{doublet, root};
use crate::shared;

/// Share of the roles that relations can show which is found right, at least; measured 0.802.
const LEAST_SHARE: f64 = 0.80;
/// The same of attitude and rates alone; measured 0.88.
const LEAST_MOTION: f64 = 0.80;
/// Rows that are wrong, all of them asked for, at most, as a part of all rows; measured 0.04.
const MOST_WRONG: f64 = 0.08;

/// Roles that relations between channels can show.
const KNOWABLE: [&str; 30] = [
    "ax", "ay", "az", "p", "q", "r", "p_dot", "q_dot", "r_dot", "x", "y", "z", "v_north", "v_east", "v_down", "phi",
    "theta", "psi", "airspeed", "calibrated_airspeed", "alpha", "beta", "delta_a", "delta_e", "delta_r",
    "static_pressure", "mach", "altitude", "latitude", "longitude",
];
const MOTION: [&str; 6] = ["p", "q", "r", "phi", "theta", "psi"];

/// What is known of a channel.
#[derive(Clone, Debug)]
struct Known {
    source: Option<String>,
    channel: String,
    roles: Vec<String>,
    unit: Option<String>,
    sign: f64,
}

/// A recording with what its channels are.
struct Case {
    path: PathBuf,
    known: Vec<Known>,
}

/// Aeroplanes with attitude and rates of the open part of the recordings of strangers.
fn strangers(folder: &Path) -> Vec<Case> {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap().replace("NaN", "null");
    let all: Vec<Value> = serde_json::from_str(&text).unwrap();
    let is_open = |entry: &&Value| {
        entry["split"] == "open"
            && !["refuse", "not an aeroplane"].contains(&entry["expected"].as_str().unwrap_or_default())
    };
    let mut cases = Vec::new();
    for entry in all.iter().filter(is_open) {
        let channels = entry["channels"].as_object().unwrap();
        let known: Vec<Known> = channels.iter().filter_map(|(name, channel)| known_of(name, channel)).collect();
        let has = |role: &str| known.iter().any(|known| known.roles.iter().any(|other| other == role));
        if ["p", "q", "phi", "theta"].into_iter().all(has) {
            cases.push(Case { path: folder.join(entry["file"].as_str().unwrap()), known });
        }
    }
    cases
}

fn known_of(name: &str, channel: &Value) -> Option<Known> {
    let texts = |value: &Value| match value {
        Value::String(text) => vec![text.clone()],
        Value::Array(all) => all.iter().filter_map(|text| text.as_str().map(str::to_owned)).collect(),
        _ => Vec::new(),
    };
    let roles = [texts(&channel["role"]), texts(&channel["also"])].concat();
    let side = if channel["part"] == "left" { -1.0 } else { 1.0 };
    let (unit, sign) = (channel["unit"].as_str().map(str::to_owned), side * channel["sign"].as_f64().unwrap_or(0.0));
    let (source, channel) = name.rsplit_once("::").map_or((None, name), |(source, channel)| (Some(source), channel));
    let (source, channel) = (source.map(str::to_owned), channel.to_owned());
    (!roles.is_empty()).then_some(Known { source, channel, roles, unit, sign })
}

/// Recordings that a shipped map reads.
fn mapped(folder: &Path, files: &[&str], map: &str) -> Vec<Case> {
    let text = std::fs::read_to_string(root().join("assets/channel_maps").join(map)).unwrap();
    let table: toml::Table = toml::from_str(&text).unwrap();
    let columns: Vec<String> = table
        .get("columns")
        .and_then(|columns| columns["*"].as_array())
        .into_iter()
        .flatten()
        .filter_map(|name| name.as_str().map(str::to_owned))
        .collect();
    let name = |channel: &str| {
        let plain = channel.trim_start_matches("*.");
        let column = columns.iter().position(|column| column == plain);
        column.map_or_else(|| plain.to_owned(), |column| format!("[{column}]"))
    };
    let mut known = Vec::new();
    for (role, entry) in table["roles"].as_table().unwrap() {
        let text = |key: &str| entry.get(key).and_then(|value| value.as_str()).map(str::to_owned);
        let number = |value: &toml::Value, key: &str| {
            let value = value.get(key)?;
            value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
        };
        let sign = number(entry, "sign").unwrap_or(1.0);
        let parts = entry.get("sum").and_then(toml::Value::as_array).cloned().unwrap_or_else(|| vec![entry.clone()]);
        for part in parts {
            let channel = name(part["channel"].as_str().unwrap());
            let sign = sign * number(&part, "weight").unwrap_or(1.0).signum();
            known.push(Known { source: None, channel, roles: vec![role.clone()], unit: text("unit"), sign });
        }
    }
    files.iter().map(|file| Case { path: folder.join(file), known: known.clone() }).collect()
}

fn cases() -> Option<Vec<Case>> {
    let data = shared::shared("data")?;
    let mut cases = strangers(&data.join("strangers/manned"));
    cases.extend(strangers(&data.join("strangers/uav")));
    let attas = ["attas/fAttasElv1.mat", "attas/fAttasAil1.mat", "attas/fAttasRud1.mat"];
    cases.extend(mapped(&data, &attas, "attas.toml"));
    let simulated =
        ["da3211_1", "de3211_1", "dr3211_1", "dedoublet_1"].map(|name| format!("citation_simulated/{name}.mat"));
    cases.extend(mapped(&data, &simulated.each_ref().map(String::as_str), "citation_simulated_clean.toml"));
    let mut phlab = mapped(&data, &["phlab_citation"], "phlab_citation.toml");
    // What its recorder writes and its map does not use: the vertical speed, and the height above the pressure that is set.
    let unused = [("Dadc1_altRate", "v_down", "ft/min", -1.0), ("Dadc1_bcAlt", "altitude", "ft", 1.0)];
    for (channel, role, unit, sign) in unused {
        let roles = vec![role.to_owned()];
        let known = Known { source: None, channel: channel.to_owned(), roles, unit: Some(unit.to_owned()), sign };
        phlab.iter_mut().for_each(|case| case.known.push(known.clone()));
    }
    cases.extend(phlab);
    Some(cases)
}

/// Source, name and values of a channel.
struct Named {
    source: String,
    name: String,
    values: Vec<f64>,
}

/// A recording with `ch1`, `ch2` ... in the place of its names, without units, and its channels in that order.
fn rename(mut probe: Probe) -> (Probe, Vec<Named>) {
    let mut names: Vec<Named> = Vec::new();
    for source in &mut probe.sources {
        for channel in &mut source.channels {
            let name = std::mem::replace(&mut channel.name, format!("ch{}", names.len() + 1));
            channel.unit = None;
            names.push(Named { source: source.name.clone(), name, values: channel.values().to_vec() });
        }
    }
    probe.sources.iter_mut().enumerate().for_each(|(index, source)| source.name = format!("part {}", index + 1));
    (probe, names)
}

/// Whether two units are one.
fn is_same(read: Option<&str>, known: Option<&str>) -> bool {
    let (Some(read), Some(known)) = (read, known) else { return true };
    match (Unit::parse(read), Unit::parse(known)) {
        (Ok(read), Ok(known)) => read.dimension == known.dimension && (read.scale / known.scale - 1.0).abs() < 5e-3,
        // An unknown unit of the truth is not compared.
        _ => true,
    }
}

#[derive(Default)]
struct Score {
    known: [usize; 2],
    right: [usize; 2],
    rows: usize,
    wrong: Vec<String>,
    silent: Vec<String>,
    missed: Vec<String>,
    still: Vec<String>,
}

/// Whether a channel is the one that is known.
fn is_of(channel: &Named, known: &Known) -> bool {
    let name = channel.name.as_str();
    let plain = name.split([' ', '[', '(']).next().unwrap_or(name);
    let is_source = known.source.as_ref().is_none_or(|source| channel.source.ends_with(source.as_str()));
    is_source
        && (name == known.channel
            || name.rsplit('/').next() == Some(&known.channel)
            || (known.channel.starts_with('[') && name.ends_with(&known.channel))
            || known.channel.split(" (").next() == Some(name)
            || known.channel.split('[').next() == Some(plain)
                && name.rsplit('[').next() == known.channel.rsplit('[').next()
            || known.channel == format!("{}/{name}", channel.source)
            || known
                .channel
                .strip_suffix(']')
                .and_then(|text| text.rsplit_once('['))
                .is_some_and(|(stem, unit)| stem == name && !unit.bytes().all(|byte| byte.is_ascii_digit())))
}

/// Values in SI with their sign.
fn in_si(values: &[f64], unit: Option<&str>, sign: f64) -> Vec<f64> {
    let unit = unit.and_then(|unit| Unit::parse(unit).ok());
    let sign = if sign < 0.0 { -1.0 } else { 1.0 };
    values.iter().map(|value| sign * unit.map_or(*value, |unit| unit.to_si(*value))).collect()
}

/// Standard deviation of the finite values.
fn deviation(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    (finite.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / finite.len() as f64).sqrt()
}

/// Whether a channel changes at all: one that stays within 1e-4 rad, m/s or m/s^2 has no change that a relation can compare.
fn moves(channel: &Named, known: &Known) -> bool {
    let is_place = known.roles.iter().any(|role| ["latitude", "longitude"].contains(&role.as_str()));
    let limit = if is_place { 1e-9 } else { 1e-4 };
    deviation(&in_si(&channel.values, known.unit.as_deref(), 1.0)) > limit
}

/// Whether the values of a row are those of a channel that has its role, within 1 % of their deviation: two records of one quantity.
fn is_twin(values: &[f64], unit: Option<&str>, sign: f64, (channel, known): (&Named, &Known)) -> bool {
    if values.len() != channel.values.len() || known.sign == 0.0 {
        return false;
    }
    let (own, other) = (in_si(values, unit, sign), in_si(&channel.values, known.unit.as_deref(), known.sign));
    let apart: Vec<f64> = own.iter().zip(&other).map(|(own, other)| own - other).filter(|a| a.is_finite()).collect();
    let square = apart.iter().map(|apart| apart * apart).sum::<f64>() / apart.len() as f64;
    square.sqrt() < 0.01 * deviation(&other)
}

/// Compares what is guessed of a recording without names with what is known.
fn score(case: &Case) -> Score {
    let mut score = Score::default();
    let Ok(probe) = inspect(&case.path) else { return score };
    let (probe, names) = rename(probe);
    let map = guess(std::slice::from_ref(&probe));
    let has_role = |known: &Known, role: &str| known.roles.iter().any(|other| other == role);
    let records = |role: &str| {
        let known = case.known.iter().filter(|known| has_role(known, role));
        known
            .flat_map(|known| names.iter().filter(|channel| is_of(channel, known)).map(move |channel| (channel, known)))
            .collect::<Vec<(&Named, &Known)>>()
    };
    let is_known = |role: &&str| case.known.iter().any(|known| has_role(known, role));
    let is_still = |role: &str| {
        let all = records(role);
        !all.is_empty() && all.iter().all(|(channel, known)| !moves(channel, known))
    };
    let (still, all): (Vec<&str>, Vec<&str>) = KNOWABLE.into_iter().filter(is_known).partition(|role| is_still(role));
    score.still = still.into_iter().map(str::to_owned).collect();
    let mut right: Vec<&str> = Vec::new();
    for (role, row) in &map.rows {
        // Position down of an altitude is that altitude turned.
        if *role == Role::PositionDown && map.row(Role::Altitude).is_some_and(|height| height.from == row.from) {
            continue;
        }
        score.rows += 1;
        let index: usize = row.from.channel.trim_start_matches("ch").parse().unwrap();
        let channel = &names[index - 1];
        let known = case.known.iter().find(|known| is_of(channel, known));
        let sign = if row.turned { -1.0 } else { 1.0 };
        let has = |wanted: &str| known.is_some_and(|known| known.roles.iter().any(|role| role == wanted));
        let is_height = *role == Role::Altitude && (has("z") || has("gps_altitude"));
        let is_right = is_height
            || (has(role.name())
                && known.is_some_and(|known| {
                    is_same(row.unit.map(|unit| unit.symbol), known.unit.as_deref())
                        && (known.sign == 0.0 || known.sign == sign)
                }))
            || records(role.name())
                .into_iter()
                .any(|record| is_twin(&channel.values, row.unit.map(|unit| unit.symbol), sign, record));
        if is_right {
            right.push(if is_height && has("z") { "z" } else { role.name() });
        } else {
            let text = format!("{} <- {}", role.name(), channel.name);
            if row.by != By::Physics {
                score.silent.push(text.clone());
            }
            score.wrong.push(text);
        }
    }
    for role in all {
        let found = right.contains(&role) || (role == "altitude" && right.contains(&"z"));
        score.known[0] += 1;
        score.right[0] += usize::from(found);
        if !found {
            score.missed.push(role.to_owned());
        }
        if MOTION.contains(&role) {
            score.known[1] += 1;
            score.right[1] += usize::from(found);
        }
    }
    score
}

#[test]
fn roles_of_recordings_without_names_are_found_by_their_values_and_asked_for() {
    let Some(cases) = cases() else { return };
    let mut total = Score::default();
    for case in &cases {
        let score = score(case);
        let name = case.path.file_name().unwrap().to_string_lossy();
        let [all, motion] = [0, 1].map(|k| format!("{} of {}", score.right[k], score.known[k]));
        println!("{name}: {all}, attitude and rates {motion}, {} rows, wrong {:?}", score.rows, score.wrong);
        println!("    missed {:?}, without a change {:?}", score.missed, score.still);
        for k in 0..2 {
            total.known[k] += score.known[k];
            total.right[k] += score.right[k];
        }
        total.rows += score.rows;
        total.wrong.extend(score.wrong);
        total.silent.extend(score.silent);
    }
    let share = |k: usize| total.right[k] as f64 / total.known[k] as f64;
    println!(
        "{} recordings: {:.3} of all roles, {:.3} of attitude and rates, {} of {} rows wrong and asked for",
        cases.len(),
        share(0),
        share(1),
        total.wrong.len(),
        total.rows
    );
    assert_eq!(total.silent, Vec::<String>::new());
    assert!(total.wrong.len() as f64 <= MOST_WRONG * total.rows as f64, "{:?}", total.wrong);
    assert!(share(0) >= LEAST_SHARE && share(1) >= LEAST_MOTION);
}

#[test]
fn role_found_by_values_alone_is_asked_with_its_evidence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let mut text = "time,ch1,ch2,ch3,ch4,ch5,ch6\n".to_owned();
    for k in 0..2000_u32 {
        let t = 0.02 * f64::from(k);
        let (phi, theta, psi) = (0.5 * (0.9 * t).sin(), 0.1 + 0.2 * (0.6 * t).sin(), 0.3 * t + 0.2 * (0.35 * t).sin());
        let (roll, pitch, yaw) = (0.45 * (0.9 * t).cos(), 0.12 * (0.6 * t).cos(), 0.3 + 0.07 * (0.35 * t).cos());
        let p = roll - yaw * theta.sin();
        let q = pitch * phi.cos() + yaw * phi.sin() * theta.cos();
        let r = yaw * phi.cos() * theta.cos() - pitch * phi.sin();
        text += &format!("{t:.2},{p:.6},{q:.6},{r:.6},{phi:.6},{theta:.6},{:.6}\n", psi.sin().atan2(psi.cos()));
    }
    std::fs::write(&path, text).unwrap();
    let output = doublet(&root(), &["map", path.to_str().unwrap()]);
    let printed = String::from_utf8(output.stdout).unwrap();
    let asked = printed.lines().find(|line| line.starts_with("# Question") && line.contains("'ch1' can be p")).unwrap();
    assert!(asked.contains("R2 "), "{asked}");
}
