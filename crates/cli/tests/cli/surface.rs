//! What every command has: help, `--json`, man page and completions; the manual inside the program; sessions that come with it.

use crate::common::at_root::{document, doublet, json_file, printed};

#[test]
fn version_says_program_commit_and_instructions() {
    let version = printed(&["--version"]);
    let expected = concat!("doublet ", env!("CARGO_PKG_VERSION"), " (commit ");
    assert!(version.starts_with(expected), "{version}");
    let (commit, instructions) = version[expected.len()..].trim_end().trim_end_matches(')').split_once(", ").unwrap();
    assert!(commit == "unknown" || commit.chars().all(|c| c.is_ascii_hexdigit()) && commit.len() >= 7, "{commit}");
    assert!(["AVX-512", "AVX2", "SSE2", "two lanes"].contains(&instructions), "{instructions}");
}

#[test]
fn every_command_takes_json_and_has_help_and_a_man_page() {
    fn leaves(command: &clap::Command, path: &str, found: &mut Vec<(String, bool)>) {
        for sub in command.get_subcommands() {
            let path = format!("{path} {}", sub.get_name());
            if sub.has_subcommands() {
                leaves(sub, &path, found);
            } else {
                found.push((path.trim().to_owned(), sub.get_arguments().any(|argument| argument.get_id() == "json")));
            }
        }
    }
    let mut found = Vec::new();
    leaves(&doublet_cli::command_line(), "", &mut found);
    assert!(found.len() > 40, "{}", found.len());
    let without: Vec<_> = found.iter().filter(|(_, json)| !json).map(|(path, _)| path.as_str()).collect();
    assert_eq!(without, ["completions"]);
    let folder = tempfile::tempdir().unwrap();
    printed(&["man", "--out", folder.path().to_str().unwrap()]);
    for (path, _) in &found {
        let page = folder.path().join(format!("doublet-{}.1", path.replace(' ', "-")));
        assert!(std::fs::read_to_string(&page).is_ok_and(|page| page.contains(".TH")), "{}", page.display());
    }
    assert!(printed(&["help", "run"]).contains("--tables"));
    assert!(printed(&["completions", "bash"]).contains("monte-carlo"));
}

#[test]
fn manual_is_found_by_topic_and_by_text() {
    assert!(printed(&["help"]).contains("conventions"));
    assert!(printed(&["help", "conventions"]).contains("Control deflections"));
    assert!(printed(&["help", "--search", "trailing edge down"]).contains("conventions.md:"));
    let wrong = doublet(&["help", "nothing"]);
    assert!(!wrong.status.success());
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("command or page 'nothing' not found"));
}

#[test]
fn what_commands_say_becomes_one_document() {
    let list = document(&["simulate", "--list", "--json"]);
    assert_eq!(list["version"], 1);
    assert!(list["lines"].as_array().unwrap().iter().any(|line| line == "scenarios"), "{list}");
    let coverage = document(&["coverage", "--realisations", "2", "--json"]);
    let table = &coverage["tables"][0];
    let rows = table["rows"].as_array().unwrap();
    assert!(!rows.is_empty());
    assert_eq!(table["columns"].as_array().unwrap().len(), rows[0].as_array().unwrap().len());
    assert!(rows[0].as_array().unwrap().iter().any(serde_json::Value::is_number), "{table}");
}

#[test]
fn session_that_comes_with_the_program_runs_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    let shown = document(&["run", "builtin:demo", "--out", out.to_str().unwrap(), "--json"]);
    assert_eq!(shown, json_file(&out.join("results.json")));
    let unknown = doublet(&["run", "builtin:nothing", "--out", out.to_str().unwrap()]);
    let error = String::from_utf8_lossy(&unknown.stderr).into_owned();
    assert!(error.contains("shipped session not found: use one of demo"), "{error}");
}
