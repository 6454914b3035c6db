//! The manual inside the program: pages by topic, words found in them, and help on a command.

use clap::{Args, CommandFactory};

use crate::arguments::Arguments;
use crate::{formula, glossary, text};

/// Path below `docs/` and text of every page.
static PAGES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/pages.rs"));

/// Lines that a search prints at most.
const MOST_LINES: usize = 60;

/// Arguments of `help`.
#[derive(Debug, Args)]
pub struct HelpArguments {
    /// A command or a page, such as run or conventions [default: list].
    pub topic: Vec<String>,
    /// Search the manual for this text.
    #[arg(long, value_name = "TEXT", conflicts_with = "topic")]
    pub search: Option<String>,
    /// Explain a term of tables and plots: `doublet help --term NIS`.
    #[arg(long, value_name = "WORD", conflicts_with_all = ["topic", "search"])]
    pub term: Option<String>,
}

/// A page of the manual.
pub struct Page {
    /// What it is asked for by: the name of its file.
    pub topic: &'static str,
    /// Path below `docs/`.
    pub path: &'static str,
    text: &'static str,
}

impl Page {
    fn all() -> impl Iterator<Item = Self> {
        PAGES.iter().map(|&(path, text)| {
            let name = path.rsplit('/').next().unwrap_or(path);
            Self { topic: name.trim_end_matches(".md"), path, text }
        })
    }

    /// Its heading.
    pub fn title(&self) -> String {
        let heading = self.whole().lines().find(|line| line.starts_with("# ")).map(|line| line[2..].to_owned());
        heading.unwrap_or_default()
    }

    /// Its text with what it includes, formulas in one line of letters.
    pub fn whole(&self) -> String {
        let mut whole = String::new();
        for line in self.text.lines() {
            let included = line.trim().strip_prefix("{{#include ").and_then(|rest| rest.strip_suffix("}}"));
            let found = included.and_then(|path| {
                let name = path.rsplit('/').next()?;
                PAGES.iter().find(|(path, _)| *path == name).map(|(_, text)| *text)
            });
            whole.push_str(found.unwrap_or(line));
            whole.push('\n');
        }
        formula::readable_page(&whole)
    }
}

/// Pages that a reader asks for: of two with one topic the one of the book, which includes the other.
pub fn pages() -> Vec<Page> {
    let mut pages: Vec<Page> = Vec::new();
    for page in Page::all().filter(|page| page.topic != "SUMMARY") {
        pages.retain(|other| other.topic != page.topic);
        pages.push(page);
    }
    pages.sort_by_key(|page| page.topic);
    pages
}

/// The file at a path below `docs/`, empty where there is none.
pub fn source(path: &str) -> &'static str {
    PAGES.iter().find(|(name, _)| *name == path).map_or("", |(_, text)| text)
}

/// The list of pages in the order of a book.
pub fn contents() -> &'static str {
    source("book/src/SUMMARY.md")
}

/// A line of the manual that holds what was sought.
pub struct FoundLine {
    /// The page it stands on.
    pub topic: &'static str,
    /// Path below `docs/`.
    pub path: &'static str,
    /// Heading above it, where there is one.
    pub heading: Option<&'static str>,
    /// Its number, from one.
    pub number: usize,
    /// The line.
    pub text: &'static str,
}

/// Every line that holds `sought`, whatever the case. What the book includes stands in its own file.
pub fn find_lines(sought: &str) -> Vec<FoundLine> {
    let sought = sought.to_lowercase();
    let mut found = Vec::new();
    for Page { topic, path, text } in Page::all() {
        let mut heading = None;
        for (at, line) in text.lines().enumerate() {
            heading = line.strip_prefix("## ").or(heading);
            if line.to_lowercase().contains(&sought) {
                found.push(FoundLine { topic, path, heading, number: at + 1, text: line.trim() });
            }
        }
    }
    found
}

/// Prints the help of a command, a page of the manual, the lines that hold a text, or what there is.
///
/// # Errors
/// One line where nothing is called so or no line holds the text.
pub fn help(arguments: &HelpArguments) -> Result<(), String> {
    if let Some(sought) = &arguments.search {
        return search(sought);
    }
    if let Some(word) = &arguments.term {
        return explain(word);
    }
    let Some(first) = arguments.topic.first() else {
        list();
        return Ok(());
    };
    let mut command = Arguments::command();
    command.build();
    if let Some(mut found) = arguments
        .topic
        .iter()
        .try_fold(command, |command, name| command.get_subcommands().find(|sub| sub.get_name() == name).cloned())
    {
        text::line(&found.render_long_help().to_string());
        return Ok(());
    }
    let page = pages().into_iter().find(|page| page.topic.eq_ignore_ascii_case(first));
    let page = page.ok_or_else(|| format!("command or page '{first}' not found: `doublet help` lists them"))?;
    text::document(page.whole().trim_end());
    Ok(())
}

fn list() {
    text::line("commands (`doublet help COMMAND`)");
    let command = Arguments::command();
    let row = |name: &str, about: String| vec![format!("  {name}"), about];
    let rows: Vec<_> = command
        .get_subcommands()
        .map(|sub| row(sub.get_name(), sub.get_about().map(ToString::to_string).unwrap_or_default()))
        .collect();
    text::list(&rows);
    text::line("");
    text::line("pages of the manual (`doublet help PAGE`, `doublet help --search TEXT`)");
    text::list(&pages().iter().map(|page| row(page.topic, page.title())).collect::<Vec<_>>());
}

fn search(sought: &str) -> Result<(), String> {
    let found = find_lines(sought);
    for FoundLine { path, number, text, .. } in found.iter().take(MOST_LINES) {
        text::line(&format!("{path}:{number}: {}", formula::readable_page(text)));
    }
    match found.len() {
        0 => Err(format!("'{}' not found: try one word of it", sought.to_lowercase())),
        found if found > MOST_LINES => {
            text::line(&format!("{} more: search for a longer text", found - MOST_LINES));
            Ok(())
        }
        _ => Ok(()),
    }
}

fn explain(word: &str) -> Result<(), String> {
    let entry = glossary::find(word);
    let entry = entry.ok_or_else(|| format!("'{word}' is not in the glossary: `doublet help glossary` prints all"))?;
    text::document(entry.to_string().trim_end());
    Ok(())
}
