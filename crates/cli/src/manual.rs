//! The manual inside the program: pages by topic, words found in them, and help on a command.

use std::sync::LazyLock;

use clap::Args;

use crate::pages::{PAGES, source};
use crate::search::{Prepared, Query, Rank};
use crate::{command_line, glossary, text};

/// Lines that a search prints at most.
const MOST_LINES: usize = 60;

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
    /// Its text, Markdown.
    pub text: &'static str,
}

impl Page {
    fn all() -> impl Iterator<Item = Self> {
        PAGES.iter().map(|&(path, text)| {
            let name = path.rsplit('/').next().unwrap_or(path);
            Self { topic: name.trim_end_matches(".md"), path, text }
        })
    }

    /// Its heading.
    pub fn title(&self) -> &'static str {
        self.text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or_default()
    }
}

/// All pages by topic.
pub fn pages() -> Vec<Page> {
    let mut pages: Vec<Page> = Page::all().filter(|page| page.topic != "SUMMARY").collect();
    pages.sort_by_key(|page| page.topic);
    pages
}

/// The list of pages in the order of a book.
pub fn contents() -> &'static str {
    source("SUMMARY.md")
}

/// A line of the manual.
pub struct Line {
    /// The page it stands on.
    pub topic: &'static str,
    /// Path below `docs/`.
    pub path: &'static str,
    /// Heading above it, where there is one.
    pub heading: Option<&'static str>,
    /// Its number, from one.
    pub number: usize,
    pub text: &'static str,
    prepared: Prepared,
    is_heading: bool,
}

/// All lines of all pages, made ready once: the window searches while its user types.
static LINES: LazyLock<Vec<Line>> = LazyLock::new(|| {
    let mut lines = Vec::new();
    for Page { topic, path, text } in pages() {
        let mut heading = None;
        for (at, line) in text.lines().enumerate() {
            heading = line.strip_prefix("## ").or(heading);
            let is_heading = line.starts_with('#') || line.starts_with("Also: ");
            let (text, prepared) = (line.trim(), Prepared::new(line));
            lines.push(Line { topic, path, heading, number: at + 1, text, prepared, is_heading });
        }
    }
    lines
});

/// Lines about `sought`, best match first: headings, then words as typed, other forms, synonyms and parts of words.
pub fn find_lines(sought: &str) -> Vec<&'static Line> {
    let query = Query::new(sought);
    let rank = |line: &Line| {
        let rank = query.rank(&line.prepared)?;
        Some((rank >= Rank::Part, !line.is_heading, rank))
    };
    let mut found: Vec<_> = LINES.iter().filter_map(|line| Some((rank(line)?, line))).collect();
    // Lines of one rank stay in the order of the pages.
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, line)| line).collect()
}

/// Prints the help of a command, a page of the manual, the lines that hold a text, or what there is.
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
    let mut command = command_line();
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
    text::document(page.text.trim_end());
    Ok(())
}

fn list() {
    text::line("commands (`doublet help COMMAND`)");
    let command = command_line();
    let row = |name: &str, about: String| vec![format!("  {name}"), about];
    let rows: Vec<_> = command
        .get_subcommands()
        .map(|sub| row(sub.get_name(), sub.get_about().map(ToString::to_string).unwrap_or_default()))
        .collect();
    text::list(&rows);
    text::line("");
    text::line("pages of the manual (`doublet help PAGE`, `doublet help --search TEXT`)");
    text::list(&pages().iter().map(|page| row(page.topic, page.title().to_owned())).collect::<Vec<_>>());
}

fn search(sought: &str) -> Result<(), String> {
    let found = find_lines(sought);
    for Line { path, number, text, .. } in found.iter().take(MOST_LINES) {
        text::line(&format!("{path}:{number}: {text}"));
    }
    match found.len() {
        0 => Err(format!("'{}': no match: search for a single word", sought.to_lowercase())),
        found if found > MOST_LINES => {
            text::line(&format!("{} more: search for a longer text", found - MOST_LINES));
            Ok(())
        }
        _ => Ok(()),
    }
}

fn explain(word: &str) -> Result<(), String> {
    let found = glossary::look_up(word);
    if found.is_empty() {
        return Err(format!("'{word}' is not in the glossary: `doublet help --search '{word}'` searches the manual"));
    }
    let entries: Vec<String> = found.iter().map(|entry| entry.to_string().trim_end().to_owned()).collect();
    text::document(&entries.join("\n\n"));
    Ok(())
}
