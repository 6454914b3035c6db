//! The glossary inside the program: every word of tables and plots with what it is, its unit, its formula and when to worry.

use std::fmt::{self, Display};
use std::sync::LazyLock;

use crate::pages::source;
use crate::search::{Prepared, Query, Rank};

/// Entries that a word without an entry of its own leads to, at most.
const MOST_ENTRIES: usize = 4;

/// One word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    pub word: String,
    /// Other forms of it, as tables head their columns.
    pub also: Vec<String>,
    pub what: String,
    /// Unit of its numbers.
    pub unit: Option<String>,
    /// How it is computed.
    pub formula: Option<String>,
    /// When to worry.
    pub worry: Option<String>,
}

static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let mut entries: Vec<Entry> = source("glossary.md").split("\n## ").skip(1).map(entry).collect();
    for (forms, what) in parse_word_table(source("conventions.md")) {
        let mut new = forms.into_iter().filter(|form| !entries.iter().any(|entry| entry.is_called(form)));
        if let Some(word) = new.next() {
            let also = new.collect();
            entries.push(Entry { word, also, what, unit: None, formula: None, worry: None });
        }
    }
    entries
});

impl Entry {
    /// Whether `word` is one of its forms, whatever the case.
    fn is_called(&self, word: &str) -> bool {
        self.forms().any(|form| form.to_lowercase() == word.to_lowercase())
    }

    /// The word and its other forms.
    pub fn forms(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.word.as_str()).chain(self.also.iter().map(String::as_str))
    }

    /// What it says beside what it is, with a name each.
    pub fn facts(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let all = [("Unit", &self.unit), ("Formula", &self.formula), ("Worry", &self.worry)];
        all.into_iter().filter_map(|(name, text)| Some((name, text.as_deref()?)))
    }
}

impl Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.word, self.what)?;
        self.facts().try_for_each(|(name, text)| writeln!(f, "  {name}: {text}"))
    }
}

/// Every word, those of the glossary first, then those of the conventions it leaves out.
pub fn entries() -> &'static [Entry] {
    &ENTRIES
}

/// The entry of `word`: as it is written, in another case, or without the unit in brackets behind it.
pub fn find(word: &str) -> Option<&'static Entry> {
    let word = word.trim();
    let written = |entry: &&Entry| entry.forms().any(|form| form == word);
    let found = ENTRIES.iter().find(written).or_else(|| ENTRIES.iter().find(|entry| entry.is_called(word)));
    found.or_else(|| word.rsplit_once(" [").and_then(|(bare, _)| find(bare)))
}

/// Entries of `word`: the one called so, else those with another form of it or a synonym in their name, the nearest first.
pub fn look_up(word: &str) -> Vec<&'static Entry> {
    if let Some(entry) = find(word) {
        return vec![entry];
    }
    let query = Query::new(word);
    let rank = |entry: &Entry| {
        entry.forms().filter_map(|form| query.rank(&Prepared::new(form))).filter(|rank| *rank < Rank::Part).min()
    };
    let mut found: Vec<_> = ENTRIES.iter().filter_map(|entry| Some((rank(entry)?, entry))).collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, entry)| entry).take(MOST_ENTRIES).collect()
}

/// An entry as it is written in the glossary.
fn entry(text: &str) -> Entry {
    let (word, rest) = text.split_once('\n').unwrap_or((text, ""));
    let mut entry = Entry {
        word: word.trim().to_owned(),
        also: Vec::new(),
        what: String::new(),
        unit: None,
        formula: None,
        worry: None,
    };
    for line in rest.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let fact = |name: &str| line.strip_prefix("- ")?.strip_prefix(name)?.strip_prefix(": ").map(plain);
        if let Some(forms) = line.strip_prefix("Also: ") {
            entry.also = forms.trim_end_matches('.').split(", ").map(str::to_owned).collect();
        } else if let Some(unit) = fact("Unit") {
            entry.unit = Some(unit);
        } else if let Some(formula) = fact("Formula") {
            entry.formula = Some(formula);
        } else if let Some(worry) = fact("Worry") {
            entry.worry = Some(worry);
        } else {
            let space = if entry.what.is_empty() { "" } else { " " };
            entry.what.push_str(&format!("{space}{}", plain(line)));
        }
    }
    entry
}

/// Forms and meaning of the words of the conventions: `| word, other form | meaning | where |`.
fn parse_word_table(conventions: &str) -> Vec<(Vec<String>, String)> {
    let table = conventions.split("\n## ").find(|part| part.starts_with("Words\n")).unwrap_or_default();
    let rows = table.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| word"));
    rows.filter_map(parse_row).collect()
}

fn parse_row(line: &str) -> Option<(Vec<String>, String)> {
    let mut cells = line.trim_matches('|').split(" | ").map(|cell| plain(cell.trim()));
    let forms = cells.next()?.split(", ").map(str::to_owned).collect();
    Some((forms, cells.next()?))
}

/// Text without the marks of code, emphasis and links.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('[') {
        out.push_str(before);
        let link = behind.split_once("](").and_then(|(name, to)| Some((name, to.split_once(')')?.1)));
        let link = link.filter(|(name, _)| !name.contains(']'));
        out.push_str(link.map_or("[", |(name, _)| name));
        rest = link.map_or(behind, |(_, after)| after);
    }
    out.push_str(rest);
    out.replace("**", "").replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_by_every_form_and_each_form_is_of_one_word() {
        let nis = find("normalised innovation squared").unwrap();
        assert_eq!((nis.word.as_str(), nis.unit.as_deref()), ("NIS", Some("none")));
        assert_eq!(nis.formula.as_deref(), Some("nu' S^-1 nu"));
        assert!(nis.worry.as_deref().unwrap().starts_with("its mean over a manoeuvre"));
        assert_eq!(find("Mass [kg]").unwrap().word, "Mass [kg]");
        assert_eq!(find("x aft [ft]").unwrap().word, "x aft");
        assert_eq!(find("CAP").map(|entry| entry.what.contains("elevator")), Some(true), "a word of the conventions");
        assert!(find("no such word").is_none());
        let mut forms: Vec<&str> = entries().iter().flat_map(Entry::forms).collect();
        let all = forms.len();
        forms.sort_unstable();
        forms.dedup();
        assert_eq!(forms.len(), all, "each form stands once");
        for entry in entries() {
            assert!(entry.what.len() > 10 && !entry.what.contains(['`', '*']), "{entry}");
        }
    }
}
