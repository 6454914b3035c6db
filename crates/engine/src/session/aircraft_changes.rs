//! Changes that a session makes to the aircraft file it names.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, TableLike};

/// What stands for a part that the session leaves out.
const REMOVED: &str = "removed";
/// Lists of an aircraft file whose entries have names.
const LISTS: [&str; 7] = ["tank", "seat", "luggage", "fixed_item", "engine", "wing_panel", "group"];
/// Lists of places with where the standard loading has their masses.
const LOADED: [(&str, &str); 3] = [("tank", "fuel_kg"), ("seat", "seats_kg"), ("luggage", "luggage_kg")];
/// Key of the limits of the centre of gravity over mass, changed as a whole.
pub(crate) const ENVELOPE: &str = "envelope";
/// Keys of a row of the envelope.
const ENVELOPE_KEYS: [&str; 3] = ["mass_kg", "forward_x_m", "aft_x_m"];

/// A value in the place of the file's, in the units of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum ChangedValue {
    Number(f64),
    /// A point in datum axes, or three moments of inertia.
    Triple([f64; 3]),
    /// Mass, forward and aft limit of each row of the envelope.
    Rows(Vec<[f64; 3]>),
    /// The part is left out.
    Removed,
}

/// Changes by the key of the aircraft file they go to: `mass.mass_kg`, `tank.main.cg_datum_m`, `inertia.group.wing.mass_kg`. A part
/// that the file does not have is made; `seat.NAME = "removed"` leaves one out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AircraftChanges(BTreeMap<String, ChangedValue>);

impl ChangedValue {
    fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(value) => vec![*value],
            Self::Triple(values) => values.to_vec(),
            Self::Rows(rows) => rows.concat(),
            Self::Removed => Vec::new(),
        }
    }

    fn to_item(&self) -> Item {
        let list = |values: &[f64]| values.iter().copied().collect::<Array>();
        match self {
            Self::Number(value) => toml_edit::value(*value),
            Self::Triple(values) => toml_edit::value(list(values)),
            Self::Rows(rows) => {
                let mut tables = ArrayOfTables::new();
                for row in rows {
                    let mut table = Table::new();
                    for (key, value) in ENVELOPE_KEYS.into_iter().zip(row) {
                        table.insert(key, toml_edit::value(*value));
                    }
                    tables.push(table);
                }
                Item::ArrayOfTables(tables)
            }
            Self::Removed => Item::None,
        }
    }
}

impl Hash for ChangedValue {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        self.numbers().iter().for_each(|value| value.to_bits().hash(state));
    }
}

impl Hash for AircraftChanges {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.hash(state);
    }
}

impl AircraftChanges {
    /// Whether the aircraft is as its file says.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn get(&self, key: &str) -> Option<&ChangedValue> {
        self.0.get(key)
    }

    /// Every change with its key.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &ChangedValue)> {
        self.0.iter().map(|(key, value)| (key.as_str(), value))
    }

    /// Sets a key; what is set of a part that is left out counts no more, and a part of which something is set is not left out.
    pub fn set(&mut self, key: &str, value: ChangedValue) {
        match value {
            ChangedValue::Removed => self.restore(key),
            _ => self.0.retain(|other, own| {
                *own != ChangedValue::Removed
                    || key.strip_prefix(other.as_str()).is_none_or(|rest| !rest.starts_with('.'))
            }),
        }
        self.0.insert(key.to_owned(), value);
    }

    /// Goes back to the file in a key and all below it.
    pub fn restore(&mut self, key: &str) {
        self.0
            .retain(|other, _| other.strip_prefix(key).is_none_or(|rest| !(rest.is_empty() || rest.starts_with('.'))));
    }

    /// The saved form.
    pub fn to_table(&self) -> BTreeMap<String, toml::Value> {
        self.0.iter().map(|(key, value)| (key.clone(), to_toml(value))).collect()
    }

    /// A key with a number that is none, where there is one.
    pub fn unusable(&self) -> Option<(&str, f64)> {
        self.iter()
            .find_map(|(key, value)| Some((key, value.numbers().into_iter().find(|number| !number.is_finite())?)))
    }

    /// The text of an aircraft file with the changes, its comments and order kept.
    pub fn apply(&self, text: &str) -> Result<String, String> {
        let mut document: DocumentMut =
            text.parse().map_err(|error: toml_edit::TomlError| error.to_string().trim_end().replace('\n', " "))?;
        for (key, value) in &self.0 {
            let set = set(document.as_table_mut(), key, value);
            set.ok_or_else(|| format!("aircraft_changes '{key}': the aircraft file has no such place"))?;
        }
        let removed = self.0.iter().filter(|(_, value)| **value == ChangedValue::Removed);
        for (key, _) in removed {
            let Some((list, name)) = key.split_once('.') else { continue };
            let Some((_, masses)) = LOADED.iter().find(|(own, _)| *own == list) else { continue };
            let of_loading = document.get_mut("loading").and_then(Item::as_table_like_mut);
            let masses = of_loading.and_then(|loading| loading.get_mut(masses)?.as_table_like_mut());
            masses.map(|masses| masses.remove(name));
        }
        Ok(document.to_string())
    }
}

/// Sets the item that `key` leads to; `None` where it leads through what is no table.
fn set(table: &mut dyn TableLike, key: &str, value: &ChangedValue) -> Option<()> {
    let Some((head, rest)) = key.split_once('.') else {
        set_value(table, key, value);
        return Some(());
    };
    if LISTS.contains(&head) {
        return set_in_list(table, head, rest, value);
    }
    if table.get(head).is_none() {
        if *value == ChangedValue::Removed {
            return Some(());
        }
        table.insert(head, Item::Table(Table::new()));
    }
    set(table.get_mut(head)?.as_table_like_mut()?, rest, value)
}

/// Sets what `rest` leads to in the entry of a list whose name it begins with; the entry is made where there is none.
fn set_in_list(table: &mut dyn TableLike, list: &str, rest: &str, value: &ChangedValue) -> Option<()> {
    let entries = table.entry(list).or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    if entries.is_array() {
        let tables = std::mem::take(entries).into_array_of_tables().ok()?;
        *entries = Item::ArrayOfTables(tables);
    }
    let entries = entries.as_array_of_tables_mut()?;
    let name = |entry: &Table| entry.get("name").and_then(Item::as_str).map(str::to_owned);
    if *value == ChangedValue::Removed && entries.iter().any(|entry| name(entry).as_deref() == Some(rest)) {
        entries.retain(|entry| name(entry).as_deref() != Some(rest));
        return Some(());
    }
    let begins =
        |entry: &Table| name(entry).is_some_and(|name| rest.strip_prefix(&name).is_some_and(|r| r.starts_with('.')));
    let found = entries.iter().position(begins);
    let at = match found {
        Some(at) => at,
        None if *value == ChangedValue::Removed => return Some(()),
        None => {
            let mut entry = Table::new();
            entry.insert("name", toml_edit::value(rest.split_once('.')?.0));
            entries.push(entry);
            entries.len() - 1
        }
    };
    let entry = entries.get_mut(at)?;
    let key = rest.get(name(entry)?.len() + 1..)?.to_owned();
    set(entry, &key, value)
}

/// Puts a value under a key, with the comment that stands there.
fn set_value(table: &mut dyn TableLike, key: &str, value: &ChangedValue) {
    let mut item = value.to_item();
    if item.is_none() {
        table.remove(key);
        return;
    }
    if let (Some(old), Some(new)) = (table.get(key).and_then(Item::as_value), item.as_value_mut()) {
        *new.decor_mut() = old.decor().clone();
    }
    match table.get_mut(key) {
        Some(present) => *present = item,
        None => drop(table.insert(key, item)),
    }
}

/// The value as a session file has it.
fn to_toml(value: &ChangedValue) -> toml::Value {
    let list = |values: &[f64; 3]| toml::Value::Array(values.iter().copied().map(toml::Value::Float).collect());
    match value {
        ChangedValue::Number(value) => toml::Value::Float(*value),
        ChangedValue::Triple(values) => list(values),
        ChangedValue::Rows(rows) => toml::Value::Array(rows.iter().map(list).collect()),
        ChangedValue::Removed => toml::Value::String(REMOVED.to_owned()),
    }
}

/// The value that a session file states, where it is one.
fn from_toml(value: &toml::Value) -> Option<ChangedValue> {
    let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    let triple = |value: &toml::Value| -> Option<[f64; 3]> {
        let values: Vec<f64> = value.as_array()?.iter().map(number).collect::<Option<_>>()?;
        values.try_into().ok()
    };
    match value {
        toml::Value::String(word) => (word == REMOVED).then_some(ChangedValue::Removed),
        toml::Value::Array(rows) if rows.iter().all(toml::Value::is_array) => {
            rows.iter().map(triple).collect::<Option<_>>().map(ChangedValue::Rows)
        }
        toml::Value::Array(_) => triple(value).map(ChangedValue::Triple),
        other => number(other).map(ChangedValue::Number),
    }
}

impl TryFrom<&BTreeMap<String, toml::Value>> for AircraftChanges {
    type Error = String;

    /// From the saved form: a number, three numbers, rows of three, or the word for what is left out.
    fn try_from(table: &BTreeMap<String, toml::Value>) -> Result<Self, String> {
        let one = |(key, value): (&String, &toml::Value)| {
            let refused = || {
                format!("aircraft_changes '{key}': expected a number, three numbers, rows of three, or \"{REMOVED}\"")
            };
            Ok((key.clone(), from_toml(value).ok_or_else(refused)?))
        };
        table.iter().map(one).collect::<Result<_, String>>().map(Self)
    }
}

/// A value as the workbench and the log write it.
impl std::fmt::Display for ChangedValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Removed => f.write_str(REMOVED),
            Self::Number(value) => write!(f, "{value}"),
            other => {
                let text: Vec<_> = other.numbers().iter().map(ToString::to_string).collect();
                write!(f, "{}", text.join(", "))
            }
        }
    }
}
