//! JSON Schema of a type from what it asks for.

use std::collections::BTreeMap;

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
