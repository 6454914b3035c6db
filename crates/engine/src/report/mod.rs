//! Results as they leave the program: `results.json`, tables as CSV, time histories as HDF5.

mod build;
mod engines;
mod histories;
mod proof;
mod reference;
mod results;
mod signals;
mod studies;
mod tables;

use std::path::{Path, PathBuf};

use thiserror::Error;

pub use build::build;
pub use proof::rows as proof_rows;
pub use reference::{Reference, reference};
pub use results::{
    AgreementRow, BandRow, ClockRow, CorrelationRow, DerivativeRow, DroppedRow, EngineRow, FORMAT, FitRow, FlightRow,
    InnovationRow, MonitorRow, PhaseRow, PredictionRow, ProofRow, RecordingRow, ReplayRow, Results, StateRow, TestRow,
    TheilRow, VERSION, WindowRow,
};
pub use signals::{NoiseRow, ProposalRow, SignalRow};
pub use studies::{
    CheckRow, ConditionRow, ContributionRow, KindRow, LagRow, LeftOutRow, MonteCarloRow, SensitivityRow, StudyResults,
    TornadoRow,
};

use crate::run::Snapshot;
use crate::session::Session;

/// Results that could not be written.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A file or folder could not be written.
    #[error("{path}: {source}")]
    File {
        /// Path.
        path: String,
        /// Cause.
        source: std::io::Error,
    },
    /// The folder holds something else.
    #[error("{0} is not empty and was not written by doublet: choose another folder for --out")]
    Occupied(String),
    /// A table could not be formed.
    #[error("{what}: {reason}")]
    Form {
        /// File.
        what: &'static str,
        /// Cause.
        reason: String,
    },
}

/// Name of the file that marks a folder of results.
const RESULTS: &str = "results.json";
/// Name of the session beside its results.
const SESSION: &str = "session.toml";

fn file_error(path: &Path) -> impl FnOnce(std::io::Error) -> ReportError {
    let path = path.display().to_string();
    move |source| ReportError::File { path, source }
}

/// Writes all results of a run into `folder`, which appears complete or not at all. A folder of earlier results is replaced.
///
/// # Errors
/// [`ReportError`]; nothing of the new results is left behind then.
pub fn write(session: &Session, snapshot: &Snapshot, folder: &Path) -> Result<PathBuf, ReportError> {
    write_with_progress(session, snapshot, folder, &|_| {})
}

/// Like [`write()`]; `progress` is told the part that is written, 0 to 1, after every step.
///
/// # Errors
/// Those of [`write()`].
pub fn write_with_progress(
    session: &Session,
    snapshot: &Snapshot,
    folder: &Path,
    progress: &dyn Fn(f32),
) -> Result<PathBuf, ReportError> {
    check_target(folder)?;
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent).map_err(file_error(parent))?;
    let staging = tempfile::Builder::new().prefix(".doublet-").tempdir_in(parent).map_err(file_error(parent))?;
    let results = build(session, snapshot);
    let text = serde_json::to_string_pretty(&results)
        .map_err(|error| ReportError::Form { what: RESULTS, reason: error.to_string() })?;
    let path = staging.path().join(RESULTS);
    std::fs::write(&path, text).map_err(file_error(&path))?;
    let path = staging.path().join(SESSION);
    let text = crate::session::print(session)
        .map_err(|error| ReportError::Form { what: SESSION, reason: error.to_string() })?;
    let note = "# The session as it was run. Relative paths start from where it lay.\n";
    std::fs::write(&path, format!("{note}{text}")).map_err(file_error(&path))?;
    progress(0.2);
    tables::write(&results, staging.path())?;
    studies::write(&results.studies, staging.path())?;
    proof::write(&results.proof_of_match, staging.path())?;
    progress(0.4);
    histories::write(session, snapshot, &staging.path().join("histories.h5"))?;
    progress(0.9);
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(file_error(folder))?;
    }
    let staged = staging.keep();
    std::fs::rename(&staged, folder).map_err(|error| {
        // The finished results cannot be put in place: leave nothing half done behind.
        let _ = std::fs::remove_dir_all(&staged);
        file_error(folder)(error)
    })?;
    progress(1.0);
    Ok(folder.to_path_buf())
}

/// Refuses a folder that holds anything but earlier results.
///
/// # Errors
/// [`ReportError::Occupied`].
pub fn check_target(folder: &Path) -> Result<(), ReportError> {
    let occupied = || ReportError::Occupied(folder.display().to_string());
    match std::fs::read_dir(folder) {
        Ok(mut entries) => {
            if entries.next().is_some() && !folder.join(RESULTS).is_file() {
                return Err(occupied());
            }
            Ok(())
        }
        Err(_) if folder.exists() => Err(occupied()),
        Err(_) => Ok(()),
    }
}
