//! Settings that differ between two sessions.

use std::collections::BTreeMap;

use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::{Input, Measurement, State};
use toml::{Table, Value};

use crate::session::{Session, SessionError, to_table};
use crate::snapshot::SettingDifference;

/// Keys of the header, which are no settings.
const HEADER: [&str; 3] = ["format", "version", "app"];
/// Start of the settings that are the terms of a coefficient.
const MODEL: &str = "model.";
/// What tells the entries of a list apart, the first an entry has.
const NAMES: [&str; 4] = ["name", "path", "source", "reference"];
/// Units by the ending of a key, longer endings first.
const ENDINGS: [(&str, &str); 5] = [("_m_s2", "m/s²"), ("_kg", "kg"), ("_rad", "rad"), ("_m", "m"), ("_s", "s")];

/// Every setting that differs between two sessions, in the order of their names.
pub fn settings(first: &Session, second: &Session) -> Result<Vec<SettingDifference>, SessionError> {
    let (first, mut second) = (flat(first)?, flat(second)?);
    let mut all: BTreeMap<_, _> = first.into_iter().map(|(name, value)| (name, (Some(value), None))).collect();
    for (name, entry) in &mut all {
        entry.1 = second.remove(name);
    }
    all.extend(second.into_iter().map(|(name, value)| (name, (None, Some(value)))));
    let differing = all.into_iter().filter(|(_, (first, second))| first != second);
    Ok(differing
        .filter(|(setting, (first, second))| !setting.starts_with(MODEL) || terms(first) != terms(second))
        .map(|(setting, (first, second))| SettingDifference { unit: unit(&setting), setting, first, second })
        .collect())
}

/// Terms of a coefficient in alphabetical order: estimates do not depend on the order in which a model lists them.
fn terms(value: &Option<String>) -> Option<Vec<&str>> {
    let mut terms: Vec<&str> = value.as_deref()?.split(", ").collect();
    terms.sort_unstable();
    Some(terms)
}

/// Every value of the session's saved form by its full name.
fn flat(session: &Session) -> Result<BTreeMap<String, String>, SessionError> {
    let mut table = to_table(session)?;
    HEADER.iter().for_each(|key| drop(table.remove(*key)));
    let mut values = BTreeMap::new();
    walk_table("", &table, &mut values);
    Ok(values)
}

fn walk_table(place: &str, table: &Table, values: &mut BTreeMap<String, String>) {
    for (key, value) in table {
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        match value {
            Value::Table(table) => walk_table(&place, table, values),
            Value::Array(entries) if entries.iter().any(Value::is_table) => walk_list(&place, entries, values),
            other => drop(values.insert(place, text(other))),
        }
    }
}

fn walk_list(place: &str, entries: &[Value], values: &mut BTreeMap<String, String>) {
    for (index, entry) in entries.iter().filter_map(Value::as_table).enumerate() {
        let name = entry_name(entry);
        let place = format!("{place} '{}'", name.map_or_else(|| (index + 1).to_string(), str::to_owned));
        walk_table(&place, entry, values);
    }
}

/// What an entry of a list goes by.
pub(crate) fn entry_name(entry: &Table) -> Option<&str> {
    NAMES.iter().find_map(|key| entry.get(*key)?.as_str())
}

fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(entries) => entries.iter().map(text).collect::<Vec<_>>().join(", "),
        Value::Float(number) => number.to_string(),
        other => other.to_string(),
    }
}

/// Unit of a setting: that of its quantity, or what the ending of its key or of the key above it says.
fn unit(setting: &str) -> String {
    let keys: Vec<&str> = setting.split('.').collect();
    let last = keys.last().copied().unwrap_or_default();
    let state = || State::from_name(last).map(State::dimension);
    let quantity: Option<(Option<Dimension>, &str)> = match keys.as_slice() {
        ["filter", "process_noise", name] => Some((Input::from_name(name).map(Input::dimension), "")),
        ["filter", "measurement_noise", name] => Some((Measurement::from_name(name).map(Measurement::dimension), "")),
        ["filter", "initial_deviation" | "initial_state", _] => Some((state(), "")),
        ["filter", "random_walk", _] => Some((state(), "/√s")),
        _ => None,
    };
    if let Some((dimension, per)) = quantity {
        return dimension.map_or(String::new(), |dimension| format!("{}{per}", dimension.si_symbol()));
    }
    let by_ending = |key: &&str| ENDINGS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit);
    keys.iter().rev().take(2).find_map(by_ending).unwrap_or_default().to_owned()
}
