//! Many sessions, or one with its settings swept, over all cores; interrupted at any time and taken up again.
//!
//! Every run has a key of its content. What a run found is one file named by that key, written in one step: the folder of these
//! files says what is finished, to this program later and to others working on the same folder at the same time.

mod jobs;
#[cfg(feature = "parquet")]
mod parquet;
mod store;
mod sweep;
mod table;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

#[cfg(not(feature = "parquet"))]
mod parquet {
    /// Says that this build has no writer.
    pub(super) fn parquet(_: &[(String, super::table::Column)]) -> Result<Vec<u8>, &'static str> {
        Err(
            "this build of doublet cannot write Parquet: build it with the feature parquet, or give the table the ending .csv",
        )
    }
}

pub use jobs::{BatchJob, jobs};
pub use store::{Estimate, Finished, Store};
pub use sweep::Sweep;
pub use table::{check_table, write};

use crate::graph::{Cache, Control, guarded};
use crate::report;
use crate::run::{Scope, run as run_stages};
use crate::session::{self, Session};
use crate::snapshot::Snapshot;
use crate::verdict::list_failures;

/// Memory for what runs share, above all recordings.
const CACHE_BYTES: usize = 1 << 30;

/// How a batch went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Runs computed now.
    pub computed: usize,
    /// Runs found finished.
    pub found: usize,
    /// Runs computed now that failed.
    pub failed: usize,
}

/// Computes what is not finished yet. A run that fails is kept as its error and does not stop the others; it is tried again next
/// time. `progress` is told how many are done and which was last.
pub fn compute(jobs: &[BatchJob], store: &Store, progress: &(dyn Fn(usize, &str) + Sync)) -> Result<Tally, String> {
    let cache = Cache::new(CACHE_BYTES);
    let done = AtomicUsize::new(0);
    let one = |job: &BatchJob| -> Result<Tally, String> {
        let tally = find_or_compute(job, store, &cache)?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, &job.name);
        Ok(tally)
    };
    let add = |a: Tally, b: Tally| Tally {
        computed: a.computed + b.computed,
        found: a.found + b.found,
        failed: a.failed + b.failed,
    };
    jobs.par_iter().map(one).try_reduce(Tally::default, |a, b| Ok(add(a, b)))
}

fn find_or_compute(job: &BatchJob, store: &Store, cache: &Cache) -> Result<Tally, String> {
    if store.get(job).is_some_and(|finished| finished.error.is_none()) {
        return Ok(Tally { found: 1, ..Tally::default() });
    }
    let finished = finish(job, cache);
    store.put(job, &finished)?;
    Ok(Tally { computed: 1, failed: usize::from(finished.error.is_some()), found: 0 })
}

/// What one run finds, and what failed in it.
fn finish(job: &BatchJob, cache: &Cache) -> Finished {
    let finished = job
        .session
        .as_ref()
        .map_err(Clone::clone)
        .and_then(|session| guarded("run", || estimates(session, job, cache)));
    finished.unwrap_or_else(|error| Finished { error: Some(error), ..Finished::default() })
}

fn estimates(session: &Session, job: &BatchJob, cache: &Cache) -> Result<Finished, String> {
    let stopped: Vec<_> = session::check(session).into_iter().filter(session::stops_run).collect();
    if !stopped.is_empty() {
        return Err(stopped.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "));
    }
    let scope = Scope { session, folder: &job.folder, first: None, studies: &[], cause: "batch", generation: 1 };
    let snapshot = run_stages(&scope, &Snapshot::default(), cache, &Control::default(), &|_| {});
    let failed: Vec<_> = snapshot.failures().into_iter().chain(snapshot.failed_fits()).collect();
    let failed = list_failures(&failed);
    let results = report::build(session, &snapshot);
    let finite = |value: f64| value.is_finite().then_some(value);
    let rows = results.pooled.iter().flat_map(|fit| {
        fit.derivatives.iter().map(|row| Estimate {
            coefficient: fit.coefficient.to_owned(),
            derivative: row.name.clone(),
            estimate: finite(row.estimate),
            standard_error: finite(row.standard_error),
            corrected_standard_error: finite(row.corrected_standard_error),
            r_squared: finite(fit.r_squared),
            samples: fit.samples as u64,
        })
    });
    let error = (!failed.is_empty()).then(|| failed.join("; "));
    Ok(Finished { error, estimates: rows.collect(), files: BTreeMap::clone(&snapshot.files) })
}
