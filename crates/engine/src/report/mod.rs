//! Results as they leave the program: `results.json`, tables and time histories in several forms, and the contents of a report.

mod anticipation;
mod build;
mod coverage_tables;
pub mod document;
mod dynamics;
mod dynamics_tables;
mod engines;
mod equivalent_levels;
mod formats;
mod gusts;
mod histories;
mod manoeuvre_map;
mod mass;
mod prediction;
mod proof;
mod proposal_tables;
mod reference;
mod report_figure;
mod responses;
mod results;
mod sensor_errors;
mod setup;
mod signals;
mod studies;
mod study_tables;
mod summary;
mod table;
pub mod tables;

use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use doublet_core::series::LONG_WINDOW;
use thiserror::Error;

pub use anticipation::{AnticipationChart, anticipation_chart};
pub use build::build;
pub use coverage_tables::{case_table, coverage_table, mode_coverage_table};
pub use dynamics::{
    DynamicsRow, FigureRow, IntervalRow, LevelMapRow, LinearRow, MeasuredRow, ModeRow, QualitiesRow, QualityRow,
    TrimRow, dynamics_row, mode_rows, qualities_row,
};
pub use dynamics_tables::{criterion_table, level_table, matrix_tables, measured_table, mode_table, shown_mode_table};
pub use equivalent_levels::{ResponseLevelsRow, equivalent_levels, response_level_table, response_levels_row};
pub use formats::{TableFormat, alignments, csv, latex, markdown};
pub use gusts::{DelayRow, GustRow, applied_delays};
pub(crate) use histories::mat_file;
pub use histories::{History, HistoryColumn, HistoryFormat};
pub use manoeuvre_map::{CANDIDATE, MapOf, MapQuantity, MapRow, manoeuvre_map};
pub use mass::{FlownMassRow, ItemRow, MassRow};
pub use prediction::{PredictionAgreement, PredictionRow, ValidationRow};
pub use proof::{BandRow, ProofRow, ReplayRow, TestRow, TheilRow, rows as proof_rows, shown_tables as proof_tables};
pub use proposal_tables::{manoeuvre_table, onset_table, steady_noise_table, tuned_noise_table};
pub use reference::{Reference, reference};
pub use responses::{ModeComparisonRow, ResponseRow, SystemRow, parameter_table, response_rows, response_table};
pub use results::{
    AgreementRow, ChannelRow, ClockRow, CorrelationRow, DerivativeRow, DerivativeSummaryRow, DroppedRow, EngineRow,
    ExpressionRow, FORMAT, FitRow, FlightRow, InnovationRow, InnovationSummaryRow, MonitorRow, PhaseRow, RecordingRow,
    ReferenceRow, RegressorRow, ResidualSummaryRow, Results, SpreadRow, StateRow, VERSION, WindowRow,
};
pub use sensor_errors::{
    InitialRow, SensorErrorRow, SensorErrorsRow, SensorOutputRow, SensorWindowRow, error_table,
    output_table as sensor_output_table, rows as sensor_error_rows,
};
pub use setup::FileRow;
pub(crate) use setup::session_sha256;
pub use signals::{NoiseRow, ProposalRow, SignalRow};
pub use studies::{
    CheckRow, ConditionRow, ContributionRow, KindRow, LagRow, LeftOutRow, MonteCarloRow, SensitivityRow, StudyResults,
    TornadoRow, TotalErrorRow, kind_rows, lag_rows, monte_carlo_rows,
};
pub use study_tables::{
    check_table, condition_table, followed_table, form_table, kind_table, lag_table, left_out_table, monte_carlo_table,
};
pub use table::{Cell, Column, Table, TableOf};

use crate::graph::Control;
use crate::keep::{Earlier, Put, PutError, Staging, has_manifest};
use crate::session::Session;
use crate::snapshot::{Snapshot, WindowResults};

/// What is written beside `results.json`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// Forms of the tables.
    pub tables: Vec<TableFormat>,
    /// Forms of the time histories.
    pub histories: Vec<HistoryFormat>,
    /// Whether the histories hold every recorded channel too.
    pub recordings: bool,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { tables: vec![TableFormat::Csv], histories: vec![HistoryFormat::Hdf5], recordings: false }
    }
}

/// Results that could not be written.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A file or folder could not be written.
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
    #[error("{0} is not empty and was not written by doublet: choose another folder for --out")]
    Occupied(String),
    /// The results could not be put in place.
    #[error(transparent)]
    Put(#[from] PutError),
    /// A table could not be formed.
    #[error("{what}: {reason}")]
    Form { what: &'static str, reason: String },
    #[error("cancelled: nothing was written")]
    Cancelled,
}

impl ReportError {
    /// The error with the place of the file once it is put, not the one where it is written before.
    fn in_target(self, staging: &Staging) -> Self {
        match self {
            Self::File { path, source } => Self::File { path: staging.target_of(&path), source },
            other => other,
        }
    }
}

/// Name of the file that marks a folder of results.
const RESULTS: &str = "results.json";
/// Name of the session beside its results.
const SESSION: &str = "session.toml";

fn file_error(path: &Path) -> impl FnOnce(std::io::Error) -> ReportError {
    let path = path.display().to_string();
    move |source| ReportError::File { path, source }
}

/// Writes all results of a run into `folder`, in one step. Results of an earlier run there are replaced; what else the folder holds
/// stays. `progress` is told the part that is written, 0 to 1, after every step.
///
/// # Errors
/// [`ReportError`]; nothing of the new results is left behind then.
pub fn write(
    session: &Session,
    snapshot: &Snapshot,
    folder: &Path,
    outputs: &Outputs,
    control: &Control,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Put, ReportError> {
    check_target(folder)?;
    let staging = Staging::new(folder)?;
    let (steps, done) = (1 + outputs.tables.len() + outputs.histories.len(), AtomicUsize::new(0));
    let step = || {
        progress(0.95 * (1 + done.fetch_add(1, Ordering::Relaxed)) as f32 / steps as f32);
        control.checkpoint().map_err(|_| ReportError::Cancelled)
    };
    // Before anything else: what it takes for a while is not beside the histories of long windows.
    let results = build(session, snapshot);
    let write_tables = || {
        write_results(session, &results, staging.path())?;
        step()?;
        let tables = tables::all(&results);
        outputs.tables.iter().try_for_each(|&format| {
            formats::write(&tables, format, staging.path())?;
            step()
        })
    };
    let write_histories = || {
        let mut collected = histories::collect(session, snapshot);
        if outputs.recordings {
            collected.extend(histories::recordings(session, snapshot));
        }
        outputs.histories.iter().try_for_each(|&format| {
            histories::write(&collected, &session.title, format, staging.path(), control)?;
            step()
        })
    };
    let samples = |window: &WindowResults| Some(window.path.ready()?.reconstruction.time_s.len());
    let written = if snapshot.windows.values().filter_map(samples).any(|samples| samples > LONG_WINDOW) {
        write_tables().and_then(|()| write_histories())
    } else {
        let (tables, histories) = rayon::join(write_tables, write_histories);
        tables.and(histories)
    };
    written.map_err(|error| error.in_target(&staging))?;
    // Results of a version that kept no list of its files are known by their own mark.
    let unlisted = !has_manifest(folder) && is_results(&folder.join(RESULTS));
    let put = staging.put("results", Earlier::Removed, &|_| unlisted)?;
    progress(1.0);
    Ok(put)
}

/// Results and session, as they were run.
fn write_results(session: &Session, results: &Results, folder: &Path) -> Result<(), ReportError> {
    let text = serde_json::to_string_pretty(results)
        .map_err(|error| ReportError::Form { what: RESULTS, reason: error.to_string() })?;
    let path = folder.join(RESULTS);
    std::fs::write(&path, text).map_err(file_error(&path))?;
    let path = folder.join(SESSION);
    let text = crate::session::print(session)
        .map_err(|error| ReportError::Form { what: SESSION, reason: error.to_string() })?;
    let note = "# The session as run. Relative paths start from its original folder.\n";
    std::fs::write(&path, format!("{note}{text}")).map_err(file_error(&path))
}

/// Whether a file is the `results.json` of a run.
fn is_results(path: &Path) -> bool {
    const MARK_WITHIN: u64 = 200;
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(MARK_WITHIN).read_to_end(&mut start));
    read.is_ok() && String::from_utf8_lossy(&start).contains(FORMAT)
}

/// Refuses a folder that holds files of which doublet wrote none.
pub fn check_target(folder: &Path) -> Result<(), ReportError> {
    let occupied = || ReportError::Occupied(folder.display().to_string());
    match std::fs::read_dir(folder) {
        Ok(mut entries) => {
            if entries.next().is_some() && !has_manifest(folder) && !is_results(&folder.join(RESULTS)) {
                return Err(occupied());
            }
            Ok(())
        }
        Err(_) if folder.exists() => Err(occupied()),
        Err(_) => Ok(()),
    }
}
