//! `doublet schema`: what it prints is in `docs/files`, and every file that ships follows it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::at_root::printed;
use crate::common::root;

/// Kinds of files, and where those that ship are, by their `format`.
const KINDS: [(&str, &str, &[&str]); 6] = [
    ("session", "doublet session", &["sessions", "sessions/reference"]),
    ("channel-map", "doublet channel map", &["assets/channel_maps"]),
    ("aircraft", "doublet aircraft", &["assets/aircraft"]),
    ("instruments", "doublet instruments", &["assets/aircraft"]),
    ("sweep", "doublet sweep", &[]),
    ("equations", "doublet equations", &["assets/equations"]),
];

/// Writes the schemas of `docs/files` anew where it is set.
const BLESS: &str = "DOUBLET_WRITE_SCHEMAS";

/// What of `value` does not follow `schema`, with its place: the parts of JSON Schema that `doublet schema` prints.
fn faults(schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    if let Some(choices) = schema["oneOf"].as_array() {
        let fits = |choice: &Value| {
            let mut own = Vec::new();
            faults(choice, value, place, &mut own);
            own.is_empty()
        };
        if !choices.iter().any(fits) {
            found.push(format!("{place}: {value} is none of the choices"));
        }
    }
    if let Some(names) = schema["enum"].as_array()
        && !names.contains(value)
    {
        found.push(format!("{place}: {value} is not one of {names:?}"));
    }
    let is_kind = match schema["type"].as_str() {
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        Some("string") => value.is_string(),
        Some("array") => value.is_array(),
        Some("object") => value.is_object(),
        _ => true,
    };
    if !is_kind {
        found.push(format!("{place}: {value} is no {}", schema["type"]));
    }
    for (index, entry) in value.as_array().into_iter().flatten().enumerate() {
        let part = schema["prefixItems"].get(index).unwrap_or(&schema["items"]);
        faults(part, entry, &format!("{place}[{index}]"), found);
    }
    let Some(fields) = value.as_object() else { return };
    for (key, entry) in fields {
        match (&schema["properties"][key], &schema["additionalProperties"]) {
            (Value::Null, Value::Bool(false)) => found.push(format!("{place}.{key} is not known")),
            (Value::Null, other) => faults(other, entry, &format!("{place}.{key}"), found),
            (property, _) => faults(property, entry, &format!("{place}.{key}"), found),
        }
    }
    for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if !fields.contains_key(key) {
            found.push(format!("{place} has no {key}"));
        }
    }
}

fn as_json(path: &Path) -> Value {
    let table: toml::Table = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::to_value(table).unwrap()
}

/// Files of a kind that ship, and the commented example.
fn files(kind: &str, format: &str, folders: &[&str]) -> Vec<PathBuf> {
    let listed = folders.iter().flat_map(|folder| std::fs::read_dir(root().join(folder)).unwrap());
    let mut paths: Vec<PathBuf> = listed.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.retain(|path| as_json(path)["format"] == format);
    paths.push(root().join(format!("docs/files/{kind}.toml")));
    paths
}

#[test]
fn schemas_of_the_documents_are_those_of_the_types_and_every_file_follows_them() {
    let mut checked = 0;
    for (kind, format, folders) in KINDS {
        let text = printed(&["schema", kind]);
        let schema: Value = serde_json::from_str(&text).unwrap();
        let place = root().join(format!("docs/files/{kind}.schema.json"));
        if std::env::var_os(BLESS).is_some() {
            std::fs::write(&place, &text).unwrap();
        }
        assert_eq!(std::fs::read_to_string(&place).unwrap(), text, "{kind}: run with {BLESS}=1 to write it anew");
        for path in files(kind, format, folders) {
            let value = as_json(&path);
            let mut found = Vec::new();
            faults(&schema, &value, kind, &mut found);
            assert!(found.is_empty(), "{}: {found:?}", path.display());
            // A key nobody knows does not follow it.
            let mut wrong = value.clone();
            wrong["no_such_key"] = Value::from(1);
            let mut found = Vec::new();
            faults(&schema, &wrong, kind, &mut found);
            assert_eq!(found.len(), 1, "{}: {found:?}", path.display());
            checked += 1;
        }
    }
    assert!(checked > 25, "{checked} files");
}

#[test]
fn commented_examples_are_read_by_the_program() {
    let example = |kind: &str| root().join(format!("docs/files/{kind}.toml"));
    let text = |kind: &str| std::fs::read_to_string(example(kind)).unwrap();
    let session = doublet_engine::session::parse(&text("session")).unwrap();
    assert!(doublet_engine::session::check(&session).is_empty(), "{:?}", doublet_engine::session::check(&session));
    doublet_core::load::ChannelMap::parse(&text("channel-map")).unwrap();
    doublet_core::load::aircraft::parse(&text("aircraft")).unwrap();
    doublet_core::load::instruments::parse(&text("instruments")).unwrap();
    doublet_engine::batch::Sweep::parse(&text("sweep")).unwrap();
    let equations = doublet_engine::study::equation_text(&text("equations"), &Default::default()).unwrap();
    doublet_core::estimate::EquationModel::new(&equations).unwrap();
}
