//! Version 1 left out settings that were as usual. What was usual then is written in, so that such a session gives the same
//! results when something else becomes usual.

use toml::{Table, Value};

/// What version 1 meant by a setting that was left out.
const USUAL: &str = include_str!("v1_defaults.toml");

/// Writes in what was left out.
pub(crate) fn to_v2(session: &mut Table) {
    // The text is part of the program, and a test reads it.
    let mut usual: Table = toml::from_str(USUAL).unwrap_or_default();
    if session.get("model").and_then(Value::as_table).is_some_and(|model| !model.is_empty()) {
        // A model was given as a whole, or not at all.
        usual.remove("model");
    }
    fill(session, usual);
}

/// Adds what `table` lacks.
fn fill(table: &mut Table, usual: Table) {
    for (key, value) in usual {
        match (table.get_mut(&key), value) {
            (None, value) => drop(table.insert(key, value)),
            (Some(Value::Table(present)), Value::Table(usual)) => fill(present, usual),
            (Some(_), _) => {}
        }
    }
}
