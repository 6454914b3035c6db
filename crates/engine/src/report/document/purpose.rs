//! Section on what the flights were for, and what came of what was asked for.

use super::{Block, Contents, paragraph};
use crate::report::results::{DerivativeRow, FitRow};
use crate::report::table::{Table, TableOf};
use crate::session::Level;

/// Purpose and derivatives asked for, as the session states them; nothing where it states neither.
pub fn purpose(contents: &Contents<'_>) -> Vec<Block> {
    let session = contents.session;
    let lines = session.report_purpose.lines().filter(|line| !line.trim().is_empty());
    let mut blocks: Vec<Block> = lines.map(paragraph).collect();
    if !session.report_asked.is_empty() {
        blocks.push(Block::Heading("Derivatives asked for".to_owned()));
        blocks.push(Block::Table(table(&asked(contents))));
    }
    blocks
}

/// The first line of the purpose that the session states.
pub(super) fn stated<'a>(contents: &Contents<'a>) -> Option<&'a str> {
    contents.session.report_purpose.lines().map(str::trim).find(|line| !line.is_empty())
}

/// How many of the derivatives asked for there are, in words; none where none was asked for.
pub(super) fn summary(contents: &Contents<'_>) -> Option<String> {
    let asked = asked(contents);
    let estimated = asked.iter().filter_map(|one| one.row).count();
    let good = asked.iter().filter(|one| one.level() == Some(Level::Good)).count();
    (!asked.is_empty()).then(|| format!("{} derivatives: {estimated} estimated, {good} of them good", asked.len()))
}

/// A derivative asked for.
struct Asked<'a> {
    name: &'a str,
    row: Option<&'a DerivativeRow>,
    answer: String,
}

impl Asked<'_> {
    fn level(&self) -> Option<Level> {
        self.row?.verdict.as_ref().map(|verdict| verdict.level)
    }
}

fn asked<'a>(contents: &Contents<'a>) -> Vec<Asked<'a>> {
    let pooled = &contents.results.pooled;
    let one = |name: &'a String| {
        let row = pooled.iter().flat_map(|fit| &fit.derivatives).find(|row| row.name == *name);
        Asked { name, row, answer: answer(pooled, name, row) }
    };
    contents.session.report_asked.iter().map(one).collect()
}

/// What became of a derivative.
fn answer(pooled: &[FitRow], name: &str, row: Option<&DerivativeRow>) -> String {
    if let Some(row) = row {
        let held = row.held.map(|held| format!("estimated, {held}"));
        return held.unwrap_or_else(|| "estimated".to_owned());
    }
    let coefficient = name.split('_').next().unwrap_or_default();
    let failed = pooled.iter().find(|fit| fit.coefficient == coefficient).and_then(|fit| fit.error.as_ref());
    failed.map_or_else(|| "not in the model".to_owned(), |error| format!("not estimated: {error}"))
}

fn table(asked: &[Asked<'_>]) -> Table {
    let ends = |one: &&Asked<'_>| one.row.and_then(|row| row.interval_95);
    let caption = "Derivatives asked for, per radian, pooled, with 95 % intervals corrected for correlated residuals.";
    TableOf::new("asked", caption, asked)
        .symbol("derivative", "Derivative", |one| one.name)
        .text("answer", "Answer", |one| &one.answer)
        .maybe("estimate", "Estimate", "", 4, |one| one.row.map(|row| row.estimate))
        .maybe("low", "95 % from", "", 4, |one| ends(one).map(|ends| ends[0]))
        .maybe("high", "to", "", 4, |one| ends(one).map(|ends| ends[1]))
        .optional("verdict", "Verdict", |one| one.level().map(Level::name))
        .done()
}
