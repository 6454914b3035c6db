//! `doublet fix`: the fixes of a session's findings, the verdict with each, and applying some.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_engine::graph::Cache;
use doublet_engine::keep::Lock;
use doublet_engine::session::{self, Fix};
use doublet_engine::verdict::{Level, VerdictCounts, fixes, try_fix};

use crate::progress::Progress;
use crate::run::{CACHE_BYTES, compute_session, open_to_run};
use crate::text;

/// Arguments of `fix`.
#[derive(Debug, Args)]
pub struct FixArguments {
    /// Session file.
    pub session: PathBuf,
    /// Most fixes that are tried, in the order of what they change.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub most: usize,
    /// Apply fixes by their numbers, in this order, and write the session; the file before stays beside it as *.bak.
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub apply: Vec<usize>,
    /// Write the fixed session to another file.
    #[arg(long, short, value_name = "FILE", requires = "apply")]
    pub output: Option<PathBuf>,
}

/// Lists the fixes of a session with the verdict after each, the best first, or applies some.
///
/// # Errors
/// One line: what is wrong with the session, that a number is not one of a fix, or why the session cannot be written.
pub fn fix(arguments: &FixArguments) -> Result<(), String> {
    let target = arguments.output.as_deref().unwrap_or(&arguments.session);
    let _lock = if arguments.apply.is_empty() { None } else { Lock::lock_for_writing(target)? };
    let opened = open_to_run(&arguments.session)?;
    let progress = Progress::new();
    let snapshot = compute_session(&opened.session, &opened.folder, &[], &progress, 1.0);
    progress.finish();
    let snapshot = snapshot?;
    let verdicts = snapshot.verdicts.ready().ok_or("nothing was judged")?;
    let found = fixes(verdicts);
    let cache = Cache::new(CACHE_BYTES);
    if arguments.apply.is_empty() {
        text::line(&format!("now: {}", describe(VerdictCounts::of(verdicts))));
        let tried =
            found.iter().take(arguments.most).enumerate().map(|(index, (fix, place))| {
                (index, *fix, *place, try_fix(&opened.session, &opened.folder, fix, &cache))
            });
        let mut tried: Vec<_> = tried.collect();
        tried.sort_by_key(|(.., after)| {
            after.as_ref().map_or((Level::Bad, usize::MAX, 0), |to| (to.level, to.bad, to.caution))
        });
        let rows = tried.into_iter().map(|(index, fix, place, after)| {
            let [level, good, caution, bad] = match after {
                Ok(VerdictCounts { level, good, caution, bad }) => {
                    [level.name().to_owned(), good.to_string(), caution.to_string(), bad.to_string()]
                }
                Err(error) => [error, String::new(), String::new(), String::new()],
            };
            vec![(index + 1).to_string(), fix.label.clone(), level, good, caution, bad, place.to_owned()]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.is_empty() {
            text::line("no finding has a fix that can be applied");
        } else {
            text::table(&["#", "fix", "session", "good", "caution", "bad", "for"], &rows);
        }
        return Ok(());
    }
    let chosen: Result<Vec<&Fix>, String> = arguments.apply.iter().map(|number| pick(&found, *number)).collect();
    let fixed = chosen?.iter().try_fold(opened.session.clone(), |session, fix| fix.apply(&session));
    let fixed = fixed.map_err(|error| error.to_string())?;
    write(&fixed, &opened.folder, target)
}

/// The fix of a number.
fn pick<'a>(found: &[(&'a Fix, &str)], number: usize) -> Result<&'a Fix, String> {
    let fix = number.checked_sub(1).and_then(|index| found.get(index));
    fix.map(|(fix, _)| *fix).ok_or_else(|| format!("there is no fix {number}: the session has {}", found.len()))
}

fn describe(counts: VerdictCounts) -> String {
    let VerdictCounts { level, good, caution, bad } = counts;
    format!("{}; derivatives {good} good, {caution} caution, {bad} bad", level.name())
}

/// Writes a session whose relative paths start from `folder`.
fn write(session: &session::Session, folder: &Path, target: &Path) -> Result<(), String> {
    let absolute = |path: &Path| std::path::absolute(path).map_err(|error| format!("{}: {error}", path.display()));
    let (old, new) = (absolute(folder)?, absolute(target.parent().unwrap_or(Path::new("")))?);
    session::save(&session::rebased(session, &old, &new), target).map_err(|error| error.to_string())?;
    text::line(&format!("written to {}", target.display()));
    Ok(())
}
