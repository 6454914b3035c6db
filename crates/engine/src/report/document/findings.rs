//! Everything found on the way: what differs only in numbers and names is one line.

use super::{Block, Contents, Parts, paragraph};
use crate::session::Level;
use crate::verdict::{self};

/// The section: reasons of the verdict by their level, then notes.
pub fn warnings(contents: &Contents<'_>) -> Parts {
    let found = verdict::folded(contents.session, contents.snapshot);
    if found.is_empty() {
        return Parts::default();
    }
    let mut blocks = vec![paragraph(
        "Findings that differ only in numbers, names or manoeuvre are combined in one line with their range.",
    )];
    for (level, heading) in [(Level::Bad, "Bad"), (Level::Caution, "Caution"), (Level::Good, "Notes")] {
        let lines: Vec<String> = found.iter().filter(|line| line.level == level).map(ToString::to_string).collect();
        if !lines.is_empty() {
            blocks.extend([Block::Heading(heading.to_owned()), Block::List(lines)]);
        }
    }
    Parts { body: Vec::new(), appendix: blocks }
}

/// How many lines there are, by level.
pub fn counted(contents: &Contents<'_>) -> String {
    let found = verdict::folded(contents.session, contents.snapshot);
    let count = |level: Level| found.iter().filter(|line| line.level == level).count();
    format!("{} bad, {} caution, {} notes", count(Level::Bad), count(Level::Caution), count(Level::Good))
}
