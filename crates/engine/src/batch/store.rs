//! What finished runs found: one file each, so that many programs may work on one batch.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::BatchJob;
use crate::graph::FileStamp;
use crate::keep::{replace, sweep};

/// What a run found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// What failed in it, or why it found nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Pooled estimates.
    pub estimates: Vec<Estimate>,
    /// Every file and folder it read, as they were then.
    pub files: BTreeMap<PathBuf, FileStamp>,
}

/// One derivative of a run; numbers that do not exist are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub coefficient: String,
    pub derivative: String,
    /// Estimate; per radian where the variable is an angle.
    pub estimate: Option<f64>,
    /// Standard error for white residuals.
    pub standard_error: Option<f64>,
    /// Standard error corrected for correlated residuals.
    pub corrected_standard_error: Option<f64>,
    /// Coefficient of determination of its fit.
    pub r_squared: Option<f64>,
    /// Samples of its fit.
    pub samples: u64,
}

/// The folder of finished runs beside a table.
#[derive(Clone, Debug)]
pub struct Store(PathBuf);

impl Store {
    /// The store that belongs to the table `out`: `NAME.runs` beside it, made where it is missing. Leftovers of batches that died are removed.
    pub fn beside(out: &Path) -> Result<Self, String> {
        let name = out.file_name().ok_or_else(|| format!("{} is not a file name", out.display()))?;
        let folder = out.with_file_name(format!("{}.runs", name.to_string_lossy()));
        std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        sweep(&folder);
        Ok(Self(folder))
    }

    fn result_path(&self, job: &BatchJob) -> PathBuf {
        self.0.join(format!("{}.json", job.key))
    }

    /// What a run found earlier; `None` where it is not finished, its file cannot be read, or one it read has changed since.
    pub fn get(&self, job: &BatchJob) -> Option<Finished> {
        let finished: Finished = serde_json::from_str(&std::fs::read_to_string(self.result_path(job)).ok()?).ok()?;
        let is_unchanged = finished.files.iter().all(|(place, stamp)| FileStamp::read(place) == *stamp);
        is_unchanged.then_some(finished)
    }

    /// Keeps what a run found; it lasts once this returns.
    pub fn put(&self, job: &BatchJob, finished: &Finished) -> Result<(), String> {
        let place = self.result_path(job);
        let text = serde_json::to_string(finished).map_err(|error| error.to_string())?;
        replace(&place, text.as_bytes()).map_err(|error| format!("{}: {error}", place.display()))
    }
}
