//! The conclusions: what is wrong or contradictory first, then what may be used, then what to do.

use super::{Block, Contents, cover, responses};
use crate::notation::significant;
use crate::report::ValidationRow;
use crate::report::results::FitRow;
use crate::session::Level;
use crate::verdict::{self, Folded};

/// Findings of one level there is room for.
const FINDINGS: usize = 8;
/// Kinds of findings on results that contradict each other.
const CONTRADICTIONS: [&str; 2] = ["scatter", "physics"];

/// Conclusions by the findings and the verdicts.
pub fn conclusions(contents: &Contents<'_>) -> Vec<Block> {
    let found = verdict::folded(contents.session, contents.snapshot);
    let mut blocks = Vec::new();
    let contradictory = |line: &&Folded| CONTRADICTIONS.contains(&line.code) && line.level > Level::Good;
    let sentence = |line: &Folded| cover::with_symbols(contents, &line.to_string());
    let contradictions = found.iter().filter(contradictory).map(sentence);
    list_lines("Contradictions", contradictions.chain(responses::contradictions(contents)).collect(), &mut blocks);
    let lines_of_level = |level: Level| {
        let lines = found.iter().filter(|line| line.level == level && !contradictory(line));
        lines.map(sentence).collect()
    };
    list_lines("Results that must not be used", lines_of_level(Level::Bad), &mut blocks);
    blocks.extend(usable(contents));
    list_lines("Cautions", lines_of_level(Level::Caution), &mut blocks);
    let next = cover::next_steps(contents);
    if !next.is_empty() {
        blocks.extend([Block::Heading("Recommendations".to_owned()), Block::List(next)]);
    }
    blocks
}

fn list_lines(heading: &str, lines: Vec<String>, blocks: &mut Vec<Block>) {
    if lines.is_empty() {
        return;
    }
    let more = lines.len().saturating_sub(FINDINGS);
    let mut text: Vec<String> = lines.into_iter().take(FINDINGS).collect();
    text.extend((more > 0).then(|| format!("{more} more, less important.")));
    blocks.extend([Block::Heading(heading.to_owned()), Block::List(text)]);
}

/// How well manoeuvres that were not fitted are predicted; none without an estimate.
fn validated(contents: &Contents<'_>) -> Option<String> {
    if cover::is_not_validated(contents) {
        return Some("Validation and proof of match: none, as no manoeuvre is kept for them.".to_owned());
    }
    let rows = &contents.results.validation;
    let windows = rows.iter().map(|row| row.windows).max()?;
    let of_row = |row: &ValidationRow| {
        format!("{} {}", row.coefficient, significant(row.agreement.r_squared_identified_constants, 3))
    };
    let each: Vec<String> = rows.iter().map(of_row).collect();
    let manoeuvres = if windows == 1 { "manoeuvre" } else { "manoeuvres" };
    Some(format!("Validation: mean R² of predictions over up to {windows} {manoeuvres}: {}.", each.join(", ")))
}

/// What the flight determined, coefficient by coefficient.
fn usable(contents: &Contents<'_>) -> Vec<Block> {
    let results = contents.results;
    let level = |fit: &FitRow| fit.verdict.as_ref().map(|verdict| verdict.level);
    let named = |wanted: Level| -> Vec<&str> {
        let fits = results.pooled.iter().filter(|fit| fit.error.is_none() && level(fit) == Some(wanted));
        fits.map(|fit| fit.coefficient).collect()
    };
    let mut lines = Vec::new();
    for (wanted, words) in [
        (Level::Good, "derivatives can be used as stated"),
        (Level::Caution, "derivatives can be used with the cautions below"),
        (Level::Bad, "derivatives must not be used without the fixes above"),
    ] {
        let names = named(wanted);
        if !names.is_empty() {
            lines.push(format!("{}: {words}.", names.join(", ")));
        }
    }
    if let Some(dynamics) = &results.dynamics {
        let level = cover::overall(contents).unwrap_or_default();
        lines.push(format!("Flying qualities by {}: {level}.", dynamics.qualities.standard));
    }
    lines.extend(validated(contents));
    lines.extend(
        (!results.proof_of_match.windows.is_empty()).then(|| format!("Proof of match: {}.", cover::proof(contents))),
    );
    if lines.is_empty() { Vec::new() } else { vec![Block::Heading("Results".to_owned()), Block::List(lines)] }
}
