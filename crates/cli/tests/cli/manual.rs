//! The manual: its reference is made from the program itself, and everything a user can meet has a page.
//!
//! `DOUBLET_WRITE_MANUAL=1 cargo test --workspace --test cli manual` writes the pages of `docs/reference` anew.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Holds a page that is made from the program to what is in the repository, or writes it.
fn hold(name: &str, content: &str) {
    let path = format!("docs/reference/{name}.md");
    if std::env::var_os("DOUBLET_WRITE_MANUAL").is_some() {
        std::fs::write(root().join(&path), content).unwrap();
        return;
    }
    let there = text(&path);
    let differing = there.lines().zip(content.lines()).find(|(one, other)| one != other);
    assert!(
        there == content,
        "{path} is not what the program gives (first difference {differing:?}): \
         DOUBLET_WRITE_MANUAL=1 cargo test --workspace --test cli writes it"
    );
}

fn sources(folder: &str) -> Vec<(String, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    walk(&root().join(folder), &mut found);
    found.sort();
    let whole = |path: &PathBuf| std::fs::read_to_string(path).unwrap();
    // What tests make up is nothing a user meets.
    let code = |path: &PathBuf| whole(path).split("#[cfg(test)]").next().unwrap_or_default().to_owned();
    found.iter().map(|path| (path.display().to_string(), code(path))).collect()
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ").trim().to_owned()
}

// Commands ---------------------------------------------------------------------------------------------------------------------------

fn describe(command: &clap::Command, path: &str, page: &mut String) {
    for sub in command.get_subcommands() {
        let path = format!("{path} {}", sub.get_name());
        if sub.has_subcommands() {
            describe(sub, &path, page);
            continue;
        }
        let about = sub.get_long_about().or(sub.get_about()).map(ToString::to_string).unwrap_or_default();
        writeln!(page, "## `{path}`\n\n{about}\n").unwrap();
        let shown = sub.get_arguments().filter(|argument| argument.get_id() != "help" && !argument.is_hide_set());
        let rows: Vec<String> = shown.map(argument).collect();
        if !rows.is_empty() {
            writeln!(page, "| argument | meaning |\n|---|---|\n{}\n", rows.join("\n")).unwrap();
        }
    }
}

fn argument(argument: &clap::Arg) -> String {
    let values = argument.get_value_names().unwrap_or_default().join(" ");
    let takes = argument.get_action().takes_values();
    let name = match (argument.get_short(), argument.get_long()) {
        (Some(short), Some(long)) => format!("-{short}, --{long}"),
        (None, Some(long)) => format!("--{long}"),
        (Some(short), None) => format!("-{short}"),
        (None, None) => String::new(),
    };
    let value = if takes { values } else { String::new() };
    let name = [name, value].iter().filter(|part| !part.is_empty()).cloned().collect::<Vec<_>>().join(" ");
    let mut help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    let possible: Vec<String> =
        argument.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
    if takes && !possible.is_empty() {
        write!(help, " [one of: {}]", possible.join(", ")).unwrap();
    }
    let defaults: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    if takes && !defaults.is_empty() {
        write!(help, " [default: {}]", defaults.join(", ")).unwrap();
    }
    format!("| `{}` | {} |", cell(&name), cell(&help))
}

#[test]
fn every_command_has_its_entry() {
    let mut command = doublet_cli::command_line();
    command.build();
    let mut page = String::from(
        "# Commands\n\nAll commands with their arguments; `doublet help COMMAND` prints the same. Exit codes: 0 done, 1 refused in one \
         line, 2 wrong arguments, 3 a finding is bad.\n\n",
    );
    describe(&command, "doublet", &mut page);
    hold("commands", &page);
}

// Panels -----------------------------------------------------------------------------------------------------------------------------

/// The text of the comments that begin a file.
fn module_comment(source: &str) -> String {
    let lines = source.lines().take_while(|line| line.starts_with("//!"));
    lines.map(|line| line.trim_start_matches("//!").trim()).collect::<Vec<_>>().join(" ")
}

/// What stands between two marks of a line.
fn between<'a>(line: &'a str, before: &str, after: &str) -> Option<&'a str> {
    let rest = &line[line.find(before)? + before.len()..];
    Some(&rest[..rest.find(after)?])
}

#[test]
fn every_panel_has_its_entry() {
    let source = text("src/pane.rs");
    let rows: Vec<&str> = source.lines().filter(|line| line.contains(", page \"")).collect();
    assert!(rows.len() >= 20, "{rows:?}");
    let mut page = String::from(
        "# Panels\n\nAfter this page you can choose the panel for a task. Menu **Panels** brings each to the front; drag \
         their tabs to move them. F1 explains the panel or the term under the pointer, Ctrl+F1 lists all commands with their keys, \
         Ctrl+P finds one by its name.\n\n**File > Open second session beside** (Ctrl+Shift+O) shows another session in the right half, \
         read only: flight, path, innovations, fits, derivatives or summary, with the same zoom and one cursor over both. Manoeuvres of \
         other flights are aligned at their start.\n\nWithout the mouse: A and B set the markers in the middle of the plots, the arrow \
         keys move A by a sample (with Shift: B; with Ctrl: by a hundredth of what is shown), `[`, `]`, S and E then act at the \
         markers.\n\n",
    );
    for row in rows {
        let title = between(row, ": \"", "\"").unwrap();
        let path = row
            .rsplit(", ")
            .next()
            .unwrap()
            .split("::")
            .take_while(|part| part.starts_with(|c: char| c.is_lowercase()));
        let about = module_comment(&text(&format!("src/panels/{}.rs", path.collect::<Vec<_>>().join("/"))));
        assert!(about.len() > 20, "{title} says nothing of itself");
        writeln!(page, "## {title}\n\n{about}\n").unwrap();
    }
    hold("panels", &page);
}

// Keys of results --------------------------------------------------------------------------------------------------------------------

/// A key of a document: name, type in Rust, what it is.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: String,
    text: String,
    is_flat: bool,
    is_optional: bool,
}

/// Every struct that can be written, with its keys.
fn shapes(folder: &str) -> BTreeMap<String, Vec<Field>> {
    let (mut found, mut saved_as) = (BTreeMap::new(), Vec::new());
    for (_, source) in sources(folder) {
        let (mut comment, mut marks, mut open) = (Vec::new(), String::new(), None::<(String, Vec<Field>)>);
        for line in source.lines().map(str::trim) {
            if let Some(text) = line.strip_prefix("///") {
                comment.push(text.trim().to_owned());
            } else if line.starts_with("#[") {
                marks.push_str(line);
            } else if let Some((name, fields)) = &mut open {
                if line == "}" {
                    found.entry(std::mem::take(name)).or_insert(std::mem::take(fields));
                    open = None;
                } else if let Some((name, kind)) = line.trim_end_matches(',').split_once(": ") {
                    let name = between(&marks, "rename = \"", "\"").unwrap_or(name.rsplit(' ').next().unwrap());
                    if !marks.contains("serde(skip)") {
                        let (is_flat, is_optional) = (marks.contains("flatten"), marks.contains("skip_serializing_if"));
                        let text = if comment.is_empty() { name_in_words(name) } else { comment.join(" ") };
                        fields.push(Field { name: name.to_owned(), kind: kind.to_owned(), text, is_flat, is_optional });
                    }
                }
                (comment, marks) = if line.is_empty() { (comment, marks) } else { (Vec::new(), String::new()) };
            } else {
                if let Some(name) = between(line, "struct ", " {").filter(|_| marks.contains("erialize")) {
                    open = Some((name.to_owned(), Vec::new()));
                    // Its keys are those of the type that serde reads in its place.
                    saved_as
                        .extend(between(&marks, "from = \"", "\"").map(|table| (name.to_owned(), table.to_owned())));
                }
                (comment, marks) = (Vec::new(), String::new());
            }
        }
    }
    for (name, table) in saved_as {
        if let Some(fields) = found.get(&table).cloned() {
            found.insert(name, fields);
        }
    }
    found
}

/// A key as words, its unit behind them: `mass_kg`, "Mass, kg."
fn name_in_words(name: &str) -> String {
    let units = [
        ("_kg_m2", "kg m²"),
        ("_kg_m3", "kg/m³"),
        ("_rad_s", "rad/s"),
        ("_m_s2", "m/s²"),
        ("_m_s", "m/s"),
        ("_pa", "Pa"),
        ("_kg", "kg"),
        ("_rad", "rad"),
        ("_deg", "deg"),
        ("_m", "m"),
        ("_s", "s"),
        ("_n", "N"),
        ("_k", "K"),
        ("_w", "W"),
    ];
    let with_unit = units.iter().find_map(|(ending, unit)| Some((name.strip_suffix(ending)?, *unit)));
    let (words, unit) = with_unit.map_or((name, String::new()), |(words, unit)| (words, format!(", {unit}")));
    let (first, rest) = words.split_at(1);
    format!("{}{}{unit}.", first.to_uppercase(), rest.replace('_', " "))
}

/// Names of the structs in a type.
fn inside<'a>(kind: &'a str, shapes: &BTreeMap<String, Vec<Field>>) -> Option<&'a str> {
    kind.split(|letter: char| !letter.is_alphanumeric()).find(|word| shapes.contains_key(*word))
}

fn in_words(kind: &str) -> String {
    let known =
        [("f64", "number"), ("usize", "integer"), ("u32", "integer"), ("u64", "integer"), ("bool", "true or false")];
    let core = kind.replace("Option<", "").replace("Vec<", "").replace('>', "");
    let word = known.iter().find(|(name, _)| core == *name).map(|(_, word)| (*word).to_owned());
    let word = word.unwrap_or_else(|| match core.as_str() {
        "String" | "&'static str" | "Fix" | "Message" | "Place" => "text".to_owned(),
        "Level" => "good, caution or bad".to_owned(),
        "TimeRange" => "times `start_s`, `end_s`".to_owned(),
        other if other.starts_with('[') => "list of numbers".to_owned(),
        other if other.starts_with("BTreeMap") => "table by name".to_owned(),
        _ => String::new(),
    });
    if kind.starts_with("Vec<") && !word.is_empty() { format!("list of {word}") } else { word }
}

/// Keys below a path, flat ones among them.
fn keys(shape: &str, shapes: &BTreeMap<String, Vec<Field>>) -> Vec<Field> {
    let all = shapes.get(shape).cloned().unwrap_or_default();
    all.into_iter()
        .flat_map(|field| match inside(&field.kind, shapes) {
            Some(inner) if field.is_flat => keys(inner, shapes),
            _ => vec![field],
        })
        .collect()
}

#[test]
fn every_key_of_the_results_has_its_entry() {
    // What a run writes is in the room of results; other rooms have rows of the same names.
    let mut shapes = shapes("crates/core/src/airframe");
    for room in ["stage", "snapshot", "verdict", "session/finding", "report"] {
        shapes.extend(self::shapes(&format!("crates/engine/src/{room}")));
    }
    let mut page = format!(
        "# Keys of results.json, version {}\n\nAll keys by table; [Results](../results.md) explains the tables. A key with `?` \
         is optional. Numbers are SI and radians; a missing number is null.\n\n",
        doublet_engine::report::VERSION
    );
    let mut queue: VecDeque<(String, String)> = VecDeque::from([("results.json".to_owned(), "Results".to_owned())]);
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    let (mut words, mut by_name) = (BTreeSet::new(), BTreeSet::new());
    while let Some((path, shape)) = queue.pop_front() {
        if known.contains_key(&shape) {
            continue;
        }
        known.insert(shape.clone(), path.clone());
        writeln!(page, "## `{path}`\n\n| key | type | meaning |\n|---|---|---|").unwrap();
        for field in keys(&shape, &shapes) {
            let mark = if field.is_optional { "?" } else { "" };
            let inner = inside(&field.kind, &shapes);
            let several = if field.kind.contains("Vec<") {
                "[]"
            } else if field.kind.contains("Map<") {
                "{}"
            } else {
                ""
            };
            let below = if path == "results.json" { field.name.clone() } else { format!("{path}.{}", field.name) };
            let kind = match inner {
                Some(inner) => {
                    let place = format!("{below}{several}");
                    let place = known.get(inner).cloned().unwrap_or(place);
                    queue.push_back((place.clone(), inner.to_owned()));
                    format!("as `{place}`")
                }
                None => in_words(&field.kind),
            };
            words.insert(field.name.clone());
            if field.kind.contains("Map<") {
                by_name.insert(field.name.clone());
            }
            writeln!(page, "| `{}{mark}` | {kind} | {} |", field.name, cell(&field.text)).unwrap();
        }
        page.push('\n');
    }
    hold("result_keys", &page);
    for key in written_keys(&by_name) {
        assert!(words.contains(&key), "the key '{key}' of results.json has no entry");
    }
}

/// Keys of what a run writes, without the names in objects `by_name`. Names of tables and studies that were not asked for are keys too.
fn written_keys(by_name: &BTreeSet<String>) -> BTreeSet<String> {
    fn collect(value: &serde_json::Value, by_name: &BTreeSet<String>, found: &mut BTreeSet<String>) {
        match value {
            serde_json::Value::Object(all) => all.iter().for_each(|(key, value)| {
                found.insert(key.clone());
                match value.as_object().filter(|_| by_name.contains(key)) {
                    Some(named) => named.values().for_each(|value| collect(value, by_name, found)),
                    None => collect(value, by_name, found),
                }
            }),
            serde_json::Value::Array(all) => all.iter().for_each(|value| collect(value, by_name, found)),
            _ => {}
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let program = std::process::Command::new(env!("CARGO_BIN_EXE_doublet-cli"))
        .args(["run", "builtin:demo", "--json", "--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    let mut found = BTreeSet::new();
    collect(&serde_json::from_slice(&program.stdout).unwrap(), by_name, &mut found);
    assert!(found.len() > 150, "{}", found.len());
    found
}

// Keys of sessions, findings ---------------------------------------------------------------------------------------------------------

#[test]
fn every_key_of_a_session_has_its_entry() {
    let page = text("docs/session.md");
    let mut shapes = shapes("crates/core/src/airframe");
    shapes.extend(self::shapes("crates/engine/src/verdict"));
    shapes.extend(self::shapes("crates/engine/src/session"));
    let mut queue = VecDeque::from(["File".to_owned()]);
    let (mut seen, mut count) = (BTreeSet::new(), 0);
    while let Some(shape) = queue.pop_front() {
        if !seen.insert(shape.clone()) {
            continue;
        }
        for field in keys(&shape, &shapes) {
            count += 1;
            assert!(
                page.contains(&format!("`{}`", field.name)),
                "the key '{}' of {shape} has no entry in session.md",
                field.name
            );
            queue.extend(inside(&field.kind, &shapes).map(str::to_owned));
        }
    }
    assert!(count > 90, "{count} keys were found: does the search still see the tables of the session?");
}

/// Codes of the findings that the engine makes: what stands at the second place of `Finding::new`.
fn codes() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (path, source) in sources("crates/engine/src") {
        let literals = |text: &str| {
            let parts: Vec<String> = text.split('"').skip(1).step_by(2).map(str::to_owned).collect();
            parts
        };
        for (at, _) in source.match_indices("Finding::new(") {
            let arguments = &source[at + "Finding::new(".len()..];
            let Some((_, rest)) = arguments.split_once(',') else { continue };
            let code = rest.trim_start();
            if let Some(code) = code.strip_prefix('"') {
                found.insert(code.split('"').next().unwrap().to_owned());
                continue;
            }
            let name: String = code.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
            let stated = between(&source, &format!("const {name}: &str = \""), "\"").map(str::to_owned);
            let mark = format!("let {name} = ");
            let stated_here = source.split(mark.as_str()).skip(1);
            let chosen = stated_here.flat_map(|rest| literals(rest.split(';').next().unwrap()));
            let given = source.split("refused(").skip(1).flat_map(|rest| literals(rest).into_iter().take(1));
            let all: Vec<String> = stated.into_iter().chain(chosen).chain(given.filter(|_| name == "code")).collect();
            assert!(!all.is_empty() || name == "code", "{path}: what is the code {name}?");
            found.extend(all);
        }
    }
    found.retain(|code| !code.is_empty());
    found
}

#[test]
fn every_finding_says_what_to_do() {
    let page = text("docs/warnings.md");
    let codes = codes();
    assert!(codes.len() > 30, "{codes:?}");
    let missing: Vec<_> = codes.iter().filter(|code| !page.contains(&format!("\n## `{code}`\n"))).collect();
    assert!(missing.is_empty(), "warnings.md has no entry for {missing:?}");
}

// The pages themselves ---------------------------------------------------------------------------------------------------------------

#[test]
fn every_page_is_in_the_contents_and_every_link_and_picture_is_there() {
    let docs = root().join("docs");
    let summary = text("docs/SUMMARY.md");
    let mut count = 0;
    for folder in [docs.clone(), docs.join("reference")] {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(&docs).unwrap().display().to_string();
            if name.ends_with(".md") && name != "SUMMARY.md" {
                count += 1;
                assert!(summary.contains(&format!("({name})")), "{name} is not in SUMMARY.md");
                check_links(&path);
            }
        }
    }
    assert!(count > 30, "{count} pages");
    check_links(&docs.join("SUMMARY.md"));
    check_links(&root().join("README.md"));
}

/// Files that a page links to or draws, and the headings of pages that it links to. Nothing is included: pages are read as they are.
fn check_links(page: &Path) {
    let folder = page.parent().unwrap();
    let text = std::fs::read_to_string(page).unwrap();
    assert!(!text.contains("{{#"), "{}: a page includes nothing", page.display());
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    for link in links.filter(|link| !link.contains("://")) {
        let (file, heading) = link.split_once('#').unwrap_or((link, ""));
        let target = if file.is_empty() { page.to_path_buf() } else { folder.join(file) };
        assert!(target.exists(), "{}: {link} is not there", page.display());
        if !heading.is_empty() {
            let there = std::fs::read_to_string(&target).unwrap();
            let headings = there.lines().filter(|line| line.starts_with('#'));
            let found = headings.map(|line| slug(line.trim_start_matches('#').trim())).any(|slug| slug == heading);
            assert!(found, "{}: {link}: no such heading", page.display());
        }
    }
}

/// The name that a link has for a heading.
fn slug(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '-' | '_')).collect()
}

#[test]
fn formulas_are_readable_without_a_typesetter() {
    let pages = doublet_cli::manual::pages();
    assert!(pages.len() > 30, "{} pages", pages.len());
    for page in &pages {
        let tex: Vec<&str> = page.text.lines().filter(|line| line.contains(r"\\") || line.contains("$$")).collect();
        assert!(tex.is_empty(), "{}: {tex:#?}", page.path);
    }
    let path = pages.iter().find(|page| page.topic == "method_path").unwrap();
    assert!(path.text.contains("= a_x \u{2212} b_ax \u{2212} g sin θ"));
}

// Search -----------------------------------------------------------------------------------------------------------------------------

/// Page and heading of the best line of a search.
fn best(sought: &str) -> (&'static str, &'static str) {
    let found = doublet_cli::manual::find_lines(sought);
    let first = found.first().unwrap_or_else(|| panic!("'{sought}' is not found"));
    (first.topic, first.heading.unwrap_or_default())
}

#[test]
fn search_finds_other_forms_and_synonyms_best_page_first() {
    for (sought, page, heading) in [
        ("confidence interval", "glossary", "confidence interval"),
        ("error bars", "glossary", "confidence interval"),
        ("p-value", "glossary", "t"),
        ("multicollinearity", "glossary", "VIF"),
        ("autocorrelated", "glossary", "Corrected"),
        ("short period", "glossary", "short period"),
        ("handling qualities", "dynamics", ""),
        ("variance inflation", "glossary", "VIF"),
        ("what is NIS", "glossary", "NIS"),
        ("xylophone", "", ""),
    ] {
        if page.is_empty() {
            assert!(doublet_cli::manual::find_lines(sought).is_empty(), "{sought}");
        } else {
            assert_eq!(best(sought), (page, heading), "{sought}");
        }
    }
    // A single heading of the manual is found as it is written.
    assert_eq!(best("Coloured residuals").0, "method_estimation");
}

#[test]
fn terms_are_found_by_synonyms_and_forms() {
    for (sought, word) in [
        ("short period", "short period"),
        ("short-period", "short period"),
        ("Short Periods", "short period"),
        ("p-value", "t"),
        ("multicollinearity", "VIF"),
        ("autocorrelated", "Corrected"),
        ("confidence interval", "confidence interval"),
        ("NIS", "NIS"),
    ] {
        let found = doublet_cli::glossary::look_up(sought);
        assert_eq!(found.first().map(|entry| entry.word.as_str()), Some(word), "{sought}");
    }
    for unknown in ["no such word", "wind", ""] {
        assert!(doublet_cli::glossary::look_up(unknown).is_empty(), "{unknown}: a part of a word is not the word");
    }
}
