//! `doublet batch`: many sessions, or one with its settings swept.

use doublet_engine::batch::{Store, compute, jobs, write};

use crate::arguments::BatchArguments;
use crate::progress::Progress;
use crate::text;

/// Computes what is not finished and writes the table.
///
/// # Errors
/// One line when there is nothing to run, the results cannot be written, or every run failed. Runs that fail are rows of the table.
pub fn batch(arguments: &BatchArguments) -> Result<(), String> {
    let all = jobs(&arguments.sessions)?;
    let store = Store::beside(&arguments.out)?;
    let count = all.len();
    let (part, parts) = arguments.task.unwrap_or((1, 1));
    let mine: Vec<_> = all.iter().skip(part - 1).step_by(parts).cloned().collect();
    let progress = Progress::new();
    let tally = compute(&mine, &store, &|done, name| {
        progress.update(done as f32 / mine.len() as f32, &format!("{done} of {}: {name}", mine.len()));
    })?;
    progress.finish();
    text::line(&format!(
        "{} of {count} runs: {} computed, {} finished before, {} failed",
        mine.len(),
        tally.computed,
        tally.found,
        tally.failed
    ));
    if arguments.task.is_none() {
        let rows = write(&all, &store, &arguments.out)?;
        text::line(&format!("{rows} rows in {}", arguments.out.display()));
    }
    if !mine.is_empty() && tally.failed == mine.len() {
        let first = mine.first().and_then(|job| store.get(job)).and_then(|finished| finished.error).unwrap_or_default();
        return Err(format!("every run failed, the first with: {first}"));
    }
    Ok(())
}
