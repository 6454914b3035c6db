//! The results as they leave the program: `results.json`, documented in `docs/results.md`.

use serde::Serialize;

use super::signals::{NoiseRow, ProposalRow, SignalRow};
use super::studies::StudyResults;

/// Value of the `format` key.
pub const FORMAT: &str = "doublet results";
/// Version of the layout; raised when a key changes its name or meaning.
pub const VERSION: u32 = 1;

/// Everything a run found, numbers only; time histories are in the HDF5 file beside it.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// [`FORMAT`].
    pub format: &'static str,
    /// [`VERSION`].
    pub version: u32,
    /// Program and its version.
    pub app: String,
    /// Title of the session.
    pub title: String,
    /// Name of the aircraft.
    pub aircraft: String,
    /// How roll, pitch and yaw rate are made dimensionless.
    pub rate_normalisation: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Kalman filter used.
    pub filter: &'static str,
    /// Gravity used by the filter, m/s².
    pub gravity_m_s2: f64,
    /// How body rates were differentiated.
    pub differentiation: String,
    /// Recordings read.
    pub recordings: Vec<RecordingRow>,
    /// Flights they belong to.
    pub flights: Vec<FlightRow>,
    /// One entry per flight and engine whose power could be modelled.
    pub engines: Vec<EngineRow>,
    /// One entry per window that is not ignored.
    pub windows: Vec<WindowRow>,
    /// Derivatives from all identification windows together.
    pub pooled: Vec<FitRow>,
    /// The same by the session's second structure, where it has one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pooled_second: Vec<FitRow>,
    /// Prediction of every window by the pooled derivatives.
    pub predictions: Vec<PredictionRow>,
    /// Studies that were asked for.
    pub studies: StudyResults,
    /// Validation windows flown again by the pooled model, against tolerances.
    pub proof_of_match: ProofRow,
}

/// Validation windows flown again.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ProofRow {
    /// Name of the tolerances.
    pub tolerances: String,
    /// One entry per validation window.
    pub windows: Vec<ReplayRow>,
}

/// One window flown again.
#[derive(Clone, Debug, Serialize)]
pub struct ReplayRow {
    /// Window.
    pub window: String,
    /// Why it could not be flown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Tests of the tolerances that apply.
    pub tests: Vec<TestRow>,
    /// Theil's coefficient of each signal.
    pub theil: Vec<TheilRow>,
}

/// One test.
#[derive(Clone, Debug, Serialize)]
pub struct TestRow {
    /// Number in the rule.
    pub id: String,
    /// Name.
    pub name: String,
    /// Whether every requirement is met by one of its bands.
    pub passed: bool,
    /// Bands.
    pub bands: Vec<BandRow>,
}

/// One band of a test.
#[derive(Clone, Debug, Serialize)]
pub struct BandRow {
    /// Requirement it belongs to, counted from 1: one band of each must hold.
    pub requirement: usize,
    /// Signal.
    pub signal: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Whether the simulation stays inside throughout.
    pub passed: bool,
    /// Largest difference over the half width there.
    pub worst_ratio: f64,
    /// Simulated less measured there, SI.
    pub worst_error: f64,
    /// Time of it, s.
    pub worst_time_s: f64,
    /// Share of the samples inside.
    pub share_inside: f64,
}

/// Theil's coefficient and the parts of the mean square error.
#[derive(Clone, Debug, Serialize)]
pub struct TheilRow {
    /// Signal.
    pub signal: &'static str,
    /// Coefficient: 0 perfect, 1 none.
    pub coefficient: f64,
    /// Share from a difference of means.
    pub bias: f64,
    /// Share from a difference of standard deviations.
    pub variance: f64,
    /// Share from imperfect correlation.
    pub covariance: f64,
}

/// A recording that was read.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingRow {
    /// Flight.
    pub flight: String,
    /// Path as in the session.
    pub path: String,
    /// SHA-256 of what was read.
    pub sha256: String,
}

/// A flight: what its recordings gave together.
#[derive(Clone, Debug, Serialize)]
pub struct FlightRow {
    /// Name.
    pub name: String,
    /// Roles the channel maps assigned.
    pub roles: Vec<String>,
    /// Clocks of its recorders.
    pub clocks: Vec<ClockRow>,
    /// Longest interval between samples that was interpolated over, s, where the session states one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_gap_s: Option<f64>,
    /// Signals that were smoothed or resampled; the others were used as recorded.
    pub signals: Vec<SignalRow>,
    /// Noise over steady windows beside what the filter used.
    pub noise: Vec<NoiseRow>,
    /// Manoeuvres found in the control deflections.
    pub proposals: Vec<ProposalRow>,
    /// Findings.
    pub warnings: Vec<String>,
}

/// A recorder's clock, `t = offset + (1 + drift) t_own`.
#[derive(Clone, Debug, Serialize)]
pub struct ClockRow {
    /// Sources it stamps.
    pub source: String,
    /// Flight time at its own time zero, s.
    pub offset_s: f64,
    /// Gain of the flight's time on it, s per s.
    pub drift: f64,
    /// Part of the offset that was added by hand, s.
    pub shift_s: f64,
    /// Standard error of a flight time where the clock is known best, s; where it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error_s: Option<f64>,
    /// Standard error of the drift, s per s; where it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift_standard_error: Option<f64>,
}

/// One engine over a whole flight.
#[derive(Clone, Debug, Serialize)]
pub struct EngineRow {
    /// Flight.
    pub flight: String,
    /// Name of the engine's station on the aircraft.
    pub engine: String,
    /// Samples at 2 Hz at which all inputs are known.
    pub samples: usize,
    /// Mean of the modelled power, W.
    pub mean_power_w: f64,
    /// Mean of the thrust, N.
    pub mean_thrust_n: f64,
    /// Agreement with the power its monitor reports, where recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<MonitorRow>,
    /// Findings about the engines of this flight.
    pub warnings: Vec<String>,
}

/// Modelled power beside that of the monitor.
#[derive(Clone, Debug, Serialize)]
pub struct MonitorRow {
    /// Over the whole flight.
    #[serde(flatten)]
    pub whole: AgreementRow,
    /// Correlation of the difference with each variable.
    pub correlations: Vec<CorrelationRow>,
    /// In the phases of the flight.
    pub phases: Vec<PhaseRow>,
}

/// How two powers agree.
#[derive(Clone, Debug, Serialize)]
pub struct AgreementRow {
    /// Samples at which both are known.
    pub samples: usize,
    /// Mean of the modelled power, W.
    pub mean_modelled_w: f64,
    /// Mean of the monitor's power, W.
    pub mean_monitor_w: f64,
    /// Square of their correlation coefficient.
    pub r_squared: f64,
    /// Root mean square of their difference, W.
    pub rms_w: f64,
}

/// Correlation of modelled less monitor power with one variable.
#[derive(Clone, Debug, Serialize)]
pub struct CorrelationRow {
    /// Variable.
    pub variable: String,
    /// Correlation coefficient.
    pub coefficient: f64,
}

/// Agreement in one phase of flight.
#[derive(Clone, Debug, Serialize)]
pub struct PhaseRow {
    /// `ground`, `climb`, `level` or `descent`.
    pub phase: String,
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
    /// Agreement.
    #[serde(flatten)]
    pub agreement: AgreementRow,
}

/// One window.
#[derive(Clone, Debug, Serialize)]
pub struct WindowRow {
    /// Name.
    pub name: String,
    /// Flight.
    pub flight: String,
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
    /// Use.
    pub role: &'static str,
    /// Surface moved.
    pub surface: Option<&'static str>,
    /// Inertial samples.
    pub samples: usize,
    /// Mean normalised innovation squared.
    pub mean_nis: f64,
    /// Its expectation: the mean number of measurements per update.
    pub expected_nis: f64,
    /// 95 % region of the mean NIS for white innovations.
    pub nis_band: [f64; 2],
    /// The same for as many independent samples as the autocorrelation of the NIS leaves.
    pub nis_band_correlated: [f64; 2],
    /// Measurements the recording lacks.
    pub missing_measurements: Vec<&'static str>,
    /// Final estimate of each state.
    pub states: Vec<StateRow>,
    /// Consistency of each measurement's innovations.
    pub innovations: Vec<InnovationRow>,
    /// Derivatives from this window alone.
    pub fits: Vec<FitRow>,
    /// Findings.
    pub warnings: Vec<String>,
}

/// One state at the end of a window.
#[derive(Clone, Debug, Serialize)]
pub struct StateRow {
    /// State.
    pub state: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Filtered estimate at the last sample.
    pub estimate: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Truth at the last sample, where the recording has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<f64>,
    /// Mean squared normalised error after the first second, where the recording has the truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_squared_normalised_error: Option<f64>,
}

/// Innovations of one measurement.
#[derive(Clone, Debug, Serialize)]
pub struct InnovationRow {
    /// Measurement.
    pub measurement: &'static str,
    /// Updates.
    pub samples: usize,
    /// Mean, in predicted deviations.
    pub mean: f64,
    /// Root mean square, in predicted deviations: one when consistent, above when the filter is over-confident.
    pub ratio: f64,
    /// Whether the autocorrelation stays inside its 95 % limit.
    pub is_white: bool,
    /// One sentence on what to change, if anything.
    pub advice: String,
}

/// One fit.
#[derive(Clone, Debug, Serialize)]
pub struct FitRow {
    /// Coefficient.
    pub coefficient: &'static str,
    /// Windows whose samples it used.
    pub windows: Vec<String>,
    /// Why there is no fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Samples.
    pub samples: usize,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual relative to the range of the observation, per cent.
    pub rms_relative_percent: f64,
    /// Standard deviation of the residual.
    pub residual_deviation: f64,
    /// Condition number of the scaled regressor matrix.
    pub condition_number: f64,
    /// Derivatives.
    pub derivatives: Vec<DerivativeRow>,
    /// Correlation of the estimates, row by row.
    pub parameter_correlation: Vec<Vec<f64>>,
    /// Terms left out.
    pub dropped: Vec<DroppedRow>,
}

/// One derivative.
#[derive(Clone, Debug, Serialize)]
pub struct DerivativeRow {
    /// Name, for example `Cm_q`.
    pub name: String,
    /// Estimate; per radian where the variable is an angle.
    pub estimate: f64,
    /// Standard error for white residuals.
    pub standard_error: f64,
    /// Standard error corrected for the correlation of the residuals in time.
    pub corrected_standard_error: f64,
    /// Standard error over estimate, per cent.
    pub relative_error_percent: f64,
    /// Estimate over standard error.
    pub t: f64,
}

/// A term left out of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct DroppedRow {
    /// Derivative.
    pub name: String,
    /// Reason.
    pub reason: String,
}

/// Prediction of one coefficient over one window.
#[derive(Clone, Debug, Serialize)]
pub struct PredictionRow {
    /// Window.
    pub window: String,
    /// Use of the window.
    pub role: &'static str,
    /// Coefficient.
    pub coefficient: &'static str,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual relative to the range of the observation, per cent.
    pub rms_relative_percent: f64,
}
