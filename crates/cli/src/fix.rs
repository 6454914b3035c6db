//! `doublet fix`: the fixes of a session's findings, the verdict with each, and applying some.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::compare::ExperimentOutcome;
use doublet_engine::graph::{Cache, Context};
use doublet_engine::keep::Lock;
use doublet_engine::run::{Slot, TriedFixes, try_fixes};
use doublet_engine::session::{self, Fix, Opened, Place, Session};
use doublet_engine::verdict::{Level, VerdictCounts, fixes};

use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{CACHE_BYTES, compute_session, open_to_run, rebase};
use crate::text;

/// Part of the progress bar for the session as it is.
const COMPUTED: f32 = 0.3;

#[derive(Debug, Args)]
pub struct FixArguments {
    /// Session file.
    pub session: PathBuf,
    /// Number of fixes to try, largest effect first.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub most: usize,
    /// Apply fixes by number and save; the old file becomes *.bak.
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub apply: Vec<usize>,
    /// Write the fixed session to this file instead.
    #[arg(long, short, value_name = "FILE", requires = "apply", value_parser = output_path())]
    pub output: Option<PathBuf>,
}

/// Lists the fixes of a session with the verdict after each, the best first, or applies some.
pub fn fix(arguments: &FixArguments) -> Result<(), String> {
    let target = arguments.output.as_deref().unwrap_or(&arguments.session);
    let _lock = if arguments.apply.is_empty() { None } else { Lock::lock_for_writing(target)? };
    let opened = open_to_run(&arguments.session)?;
    session::check_output(&opened.session, &opened.folder, target)?;
    let progress = Progress::new();
    let snapshot = compute_session(&opened.session, &opened.folder, &[], &progress, COMPUTED);
    let listed = snapshot.and_then(|snapshot| {
        let verdicts = snapshot.verdicts.ready().ok_or("nothing was judged")?;
        let found = fixes(verdicts);
        if !arguments.apply.is_empty() {
            return apply(&arguments.apply, &found, &opened.session).map(Some);
        }
        list(&opened, VerdictCounts::count(verdicts), &found[..found.len().min(arguments.most)], &progress)?;
        Ok(None)
    });
    progress.finish();
    listed?.map_or(Ok(()), |fixed| write(&fixed, &opened.folder, target))
}

/// Prints the verdict now and after each fix, the best first.
fn list(opened: &Opened, now: VerdictCounts, found: &[(Fix, &Place)], progress: &Progress) -> Result<(), String> {
    let cache = Cache::new(CACHE_BYTES);
    let context = Context::new(&opened.folder).with_cache(&cache);
    let wanted: Vec<Fix> = found.iter().map(|(fix, _)| fix.clone()).collect();
    let show = |tried: &TriedFixes| {
        let done = tried.0.iter().filter(|(_, slot)| slot.ready().is_some() || slot.error().is_some()).count();
        progress.update(COMPUTED + (1.0 - COMPUTED) * done as f32 / wanted.len() as f32, "trying fixes");
    };
    let mut outcomes = TriedFixes::default();
    try_fixes(&opened.session, &wanted, &mut outcomes, &context, &show).map_err(|error| error.to_string())?;
    let after = |slot: &Slot<ExperimentOutcome>| match slot.ready() {
        Some(outcome) => Ok(outcome.verdict),
        None => Err(slot.error().unwrap_or("no verdict was formed").to_owned()),
    };
    let rows = found.iter().zip(&outcomes.0).enumerate();
    let mut tried: Vec<_> = rows.map(|(index, ((fix, place), (_, slot)))| (index, fix, *place, after(slot))).collect();
    tried.sort_by_key(|(.., after)| {
        after.as_ref().map_or((Level::Bad, usize::MAX, 0), |to| (to.level, to.bad, to.caution))
    });
    progress.finish();
    text::line(&format!("now: verdict {}", describe(now)));
    let tried = tried.into_iter();
    let rows: Vec<_> = tried.map(|(index, fix, place, after)| describe_tried(index, fix, place, after)).collect();
    match rows.is_empty() {
        true => text::line("no fix to apply"),
        false => text::table(&["#", "fix", "verdict", "good", "caution", "bad", "finding"], &rows),
    }
    Ok(())
}

fn describe_tried(index: usize, fix: &Fix, place: &Place, after: Result<VerdictCounts, String>) -> Vec<String> {
    let [level, good, caution, bad] = match after {
        Ok(VerdictCounts { level, good, caution, bad }) => {
            [level.name().to_owned(), good.to_string(), caution.to_string(), bad.to_string()]
        }
        Err(error) => [error, String::new(), String::new(), String::new()],
    };
    vec![(index + 1).to_string(), fix.label.clone(), level, good, caution, bad, place.to_string()]
}

/// The session after fixes by their numbers, in this order.
fn apply(numbers: &[usize], found: &[(Fix, &Place)], session: &Session) -> Result<Session, String> {
    let chosen: Result<Vec<&Fix>, String> = numbers.iter().map(|number| pick(found, *number)).collect();
    let fixed = chosen?.iter().try_fold(session.clone(), |session, fix| fix.apply(&session));
    fixed.map_err(|error| error.to_string())
}

fn pick<'a>(found: &'a [(Fix, &Place)], number: usize) -> Result<&'a Fix, String> {
    let fix = number.checked_sub(1).and_then(|index| found.get(index));
    fix.map(|(fix, _)| fix).ok_or_else(|| format!("fix {number} not found: the session has {}", found.len()))
}

fn describe(counts: VerdictCounts) -> String {
    let VerdictCounts { level, good, caution, bad } = counts;
    format!("{}; derivatives {good} good, {caution} caution, {bad} bad", level.name())
}

/// Writes a session whose relative paths start from `folder`.
fn write(session: &Session, folder: &Path, target: &Path) -> Result<(), String> {
    let session = rebase(session, folder, target.parent().unwrap_or(Path::new("")))?;
    session::save(&session, target).map_err(|error| error.to_string())?;
    text::line(&format!("written to {}", target.display()));
    Ok(())
}
