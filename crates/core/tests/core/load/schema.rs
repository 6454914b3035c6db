//! JSON Schema of a type from what it asks for.

use std::collections::{BTreeMap, BTreeSet};

use doublet_core::load::ChannelMap;
use doublet_core::quantity::Role;
use doublet_core::schema::schema_of;
use serde::Deserialize;
use serde_json::json;

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(dead_code, reason = "only its form is looked at")]
enum Kind {
    First,
    Second,
    Rod { length_m: f64 },
    Scaled(f64),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only its form is looked at")]
struct Inner {
    place: [f64; 3],
    #[serde(default)]
    note: String,
}

#[derive(Deserialize)]
#[expect(dead_code, reason = "only its form is looked at")]
struct Outer {
    name: toml::Spanned<String>,
    kind: Option<Kind>,
    #[serde(default, rename = "part")]
    parts: Vec<Inner>,
    #[serde(default)]
    masses: BTreeMap<toml::Spanned<String>, f64>,
    anything: Option<toml::Value>,
    count: usize,
}

#[test]
fn schema_has_keys_types_and_what_cannot_be_left_out() {
    let schema = schema_of::<Outer>("outer").unwrap();
    let inner = json!({
        "type": "object",
        "properties": {
            "place": {
                "type": "array",
                "prefixItems": [{ "type": "number" }, { "type": "number" }, { "type": "number" }],
                "minItems": 3,
                "maxItems": 3,
            },
            "note": { "type": "string" },
        },
        "required": ["place"],
        "additionalProperties": false,
    });
    let expected = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "outer",
        "type": "object",
        "properties": {
            "name": { "type": "string" },
            "kind": { "oneOf": [
                { "enum": ["first", "second"] },
                { "type": "object", "required": ["rod"], "properties": { "rod": {
                    "type": "object", "properties": { "length_m": { "type": "number" } },
                } } },
                { "type": "object", "required": ["scaled"], "properties": { "scaled": { "type": "number" } } },
            ] },
            "part": { "type": "array", "items": inner },
            "masses": { "type": "object", "additionalProperties": { "type": "number" } },
            "anything": {},
            "count": { "type": "integer" },
        },
        "required": ["name", "count"],
    });
    assert_eq!(schema, expected);
}

/// Keys of all tables of a schema, and of the tables within them.
fn keys_of(schema: &serde_json::Value, found: &mut BTreeSet<String>) {
    match schema {
        serde_json::Value::Object(all) => {
            let properties = all.get("properties").and_then(serde_json::Value::as_object);
            found.extend(properties.into_iter().flat_map(|keys| keys.keys().cloned()));
            all.values().for_each(|value| keys_of(value, found));
        }
        serde_json::Value::Array(all) => all.iter().for_each(|value| keys_of(value, found)),
        _ => {}
    }
}

#[test]
fn every_key_and_role_of_a_channel_map_has_its_entry_in_the_manual() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/channel_map.md");
    let page = std::fs::read_to_string(path).unwrap();
    let mut keys = BTreeSet::new();
    keys_of(&ChannelMap::schema().unwrap(), &mut keys);
    assert!(keys.len() > 35 && keys.contains("sample_rate"), "{keys:?}");
    let not_listed = ["other_2", "other_3"];
    let roles = Role::ALL.iter().map(|role| role.name().to_owned()).filter(|role| !not_listed.contains(&role.as_str()));
    let missing: Vec<_> = keys.into_iter().chain(roles).filter(|key| !page.contains(&format!("`{key}`"))).collect();
    assert!(missing.is_empty(), "channel_map.md has no entry for {missing:?}");
}
