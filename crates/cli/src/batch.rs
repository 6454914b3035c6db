//! `doublet batch`: many sessions, or one with its settings swept.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::batch::{Store, check_table, compute, jobs, write};

use crate::output_path::output_path;
use crate::progress::Progress;
use crate::text;

#[derive(Debug, Args)]
pub struct BatchArguments {
    /// Folder of sessions and sweeps, or one of them.
    pub sessions: PathBuf,
    /// Table to write, .parquet or .csv; completed runs are stored in NAME.runs.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
    /// Compute part I of N without a table, for scheduler jobs.
    #[arg(long, value_name = "I/N", value_parser = part)]
    pub task: Option<(usize, usize)>,
}

/// Computes what is not finished and writes the table.
///
/// # Errors
/// One line when there is nothing to run, the results cannot be written, or every run failed. Runs that fail are rows of the table.
pub fn batch(arguments: &BatchArguments) -> Result<(), String> {
    let all = jobs(&arguments.sessions)?;
    check_table(&all, &arguments.sessions, &arguments.out)?;
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

/// Reads `I/N`.
fn part(text: &str) -> Result<(usize, usize), String> {
    let wrong = || format!("'{text}' is not a part: write it as I/N with I from 1 to N, for example 3/8");
    let (part, parts) = text.split_once('/').ok_or_else(wrong)?;
    let (part, parts) = part.parse().ok().zip(parts.parse().ok()).ok_or_else(wrong)?;
    if (1..=parts).contains(&part) { Ok((part, parts)) } else { Err(wrong()) }
}
