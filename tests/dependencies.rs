//! What doublet is built from, against `deny.toml`: licences, and crates that are there in more than one version.

#![allow(clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use spdx::{Expression, ParseMode};

/// Name, version and licence of every crate from elsewhere that the Linux program is built from.
fn crates() -> Vec<(String, String, String)> {
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(metadata.status.success(), "{}", String::from_utf8_lossy(&metadata.stderr));
    let metadata: Value = serde_json::from_slice(&metadata.stdout).unwrap();
    let built: BTreeSet<&str> =
        metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|node| node["id"].as_str().unwrap()).collect();
    let packages = metadata["packages"].as_array().unwrap().iter();
    let text = |package: &Value, field: &str| package[field].as_str().unwrap_or_default().to_owned();
    packages
        .filter(|package| !package["source"].is_null() && built.contains(package["id"].as_str().unwrap()))
        .map(|package| (text(package, "name"), text(package, "version"), text(package, "license")))
        .collect()
}

/// Entries of a list of `deny.toml`.
fn listed(table: &str, list: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("deny.toml")).unwrap();
    let all: toml::Table = text.parse().unwrap();
    all[table][list].as_array().unwrap().iter().map(|entry| entry.as_str().unwrap().to_owned()).collect()
}

#[test]
fn every_licence_is_one_of_those_allowed() {
    let allowed = listed("licenses", "allow");
    let refused: Vec<_> = crates()
        .into_iter()
        .filter(|(_, _, licence)| {
            let expression = Expression::parse_mode(licence, ParseMode::LAX);
            !expression.is_ok_and(|expression| expression.evaluate(|asked| allowed.contains(&asked.to_string())))
        })
        .collect();
    assert!(refused.is_empty(), "licences that deny.toml does not allow: {refused:?}");
}

#[test]
fn no_crate_is_there_twice_but_those_listed() {
    let skipped = listed("bans", "skip");
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (name, version, _) in crates() {
        let version = version.split('+').next().unwrap_or_default().to_owned();
        versions.entry(name).or_default().insert(version);
    }
    let wanted = |name: &str, version: &str| !skipped.contains(&format!("{name}@{version}"));
    let twice: Vec<_> = versions
        .iter()
        .filter(|(name, versions)| versions.iter().filter(|version| wanted(name, version)).count() > 1)
        .collect();
    assert!(twice.is_empty(), "in more than one version: {twice:?}");
    let gone: Vec<_> = skipped
        .iter()
        .filter(|entry| {
            let (name, version) = entry.split_once('@').unwrap();
            !versions.get(name).is_some_and(|versions| versions.len() > 1 && versions.contains(version))
        })
        .collect();
    assert!(gone.is_empty(), "deny.toml lists what is there once or not at all: {gone:?}");
}
