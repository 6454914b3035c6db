//! The results as they leave the program: `results.json`, documented in `docs/results.md`.

use doublet_core::airframe::ReferenceGeometry;
use doublet_core::series::TimeRange;
use serde::Serialize;

use super::dynamics::DynamicsRow;
use super::gusts::{DelayRow, GustRow};
use super::manoeuvre_map::MapRow;
use super::mass::{FlownMassRow, MassRow};
use super::prediction::{PredictionRow, ValidationRow};
use super::proof::ProofRow;
use super::sensor_errors::SensorErrorsRow;
use super::setup::FileRow;
use super::signals::{NoiseRow, ProposalRow, SignalRow};
use super::studies::StudyResults;
use crate::session::Verdict;
use crate::snapshot::Consequence;
use crate::stage::{PhysicsRow, Steadiness};
use crate::verdict::{Dependence, StatedQuantity};

/// Value of the `format` key.
pub const FORMAT: &str = "doublet results";
/// Version of the layout; raised when a key changes its name or meaning.
pub const VERSION: u32 = 3;

/// Everything a run found, numbers only; time histories are in the HDF5 file beside it.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    pub format: &'static str,
    pub version: u32,
    /// Program and its version.
    pub app: String,
    /// Title of the session.
    pub title: String,
    /// SHA-256 of the session in its saved form.
    pub session_sha256: String,
    /// Name of the aircraft.
    pub aircraft: String,
    /// How roll, pitch and yaw rate are made dimensionless.
    pub rate_normalisation: String,
    /// Mass at the start, kg: that of `mass_properties`.
    pub mass_kg: f64,
    /// Kalman filter used.
    pub filter: &'static str,
    /// Mass properties as flown at the start of the first flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_properties: Option<MassRow>,
    /// Reference geometry of the coefficients.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceRow>,
    /// Gravity used by the filter, m/s².
    pub gravity_m_s2: f64,
    /// Origin of the value.
    pub gravity_origin: String,
    /// Delays of the measurements; empty if the session states them or too few manoeuvres determine them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensor_delays: Vec<DelayRow>,
    /// Gusts over the manoeuvres; absent if the session states the random walk of the wind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gusts: Option<GustRow>,
    /// How body rates were differentiated.
    pub differentiation: String,
    /// Which results can be trusted, and why not; absent if the run was stopped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Findings about the session itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Recordings read.
    pub recordings: Vec<RecordingRow>,
    /// Files beside the recordings that the derivatives rest on.
    pub files: Vec<FileRow>,
    /// Flights of the recordings.
    pub flights: Vec<FlightRow>,
    /// One entry per flight and engine with a power model.
    pub engines: Vec<EngineRow>,
    /// One entry per manoeuvre that is not ignored.
    pub windows: Vec<WindowRow>,
    /// Every manoeuvre and candidate with its flight condition, its input and its results.
    pub manoeuvre_map: Vec<MapRow>,
    /// Derivatives from all identification manoeuvres together.
    pub pooled: Vec<FitRow>,
    /// Correlation of the regressors of each coefficient over the identification manoeuvres (thesis 4.4.3).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regressor_correlation: Vec<RegressorRow>,
    /// Prediction of every manoeuvre by the pooled derivatives.
    pub predictions: Vec<PredictionRow>,
    /// Constant sensor errors, if the session estimates them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_errors: Option<SensorErrorsRow>,
    /// Studies on request.
    pub studies: StudyResults,
    /// Linear model, modes and flying qualities about a trim, on request.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamics: Option<DynamicsRow>,
    /// Validation manoeuvres simulated by the pooled model, with tolerances.
    pub proof_of_match: ProofRow,
    /// Wind and biases over the manoeuvres (thesis Tables 6.1 and 6.2).
    pub wind_and_bias: Vec<SpreadRow>,
    /// Innovations of each measurement over the manoeuvres.
    pub innovation_summary: Vec<InnovationSummaryRow>,
    /// Residuals of the fits of single manoeuvres (thesis Table 6.3).
    pub residual_summary: Vec<ResidualSummaryRow>,
    /// Each derivative over the identification manoeuvres (thesis Tables 6.4 to 6.9).
    pub derivative_summary: Vec<DerivativeSummaryRow>,
    /// Prediction of the validation manoeuvres (thesis Table 7.1).
    pub validation: Vec<ValidationRow>,
}

/// Lengths and area the coefficients refer to.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceRow {
    /// Lengths and area.
    #[serde(flatten)]
    pub geometry: ReferenceGeometry,
    /// Reference point of the moment coefficients, from the datum, m; the centre of gravity if not stated.
    pub moment_reference_from_datum_m: Option<[f64; 3]>,
}

/// A quantity over several windows.
#[derive(Clone, Debug, Serialize)]
pub struct SpreadRow {
    /// State.
    pub quantity: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Number of manoeuvres.
    pub windows: usize,
    /// Mean over the manoeuvres.
    pub mean: f64,
    /// Standard deviation over the manoeuvres.
    pub standard_deviation: f64,
    /// Smallest value.
    pub minimum: f64,
    /// Largest value.
    pub maximum: f64,
}

/// Innovations of one measurement over the windows.
#[derive(Clone, Debug, Serialize)]
pub struct InnovationSummaryRow {
    pub measurement: &'static str,
    /// Manoeuvres with this measurement.
    pub windows: usize,
    /// Mean over the manoeuvres of the root mean square in predicted standard deviations.
    pub mean_ratio: f64,
    /// Smallest.
    pub minimum_ratio: f64,
    /// Largest.
    pub maximum_ratio: f64,
    /// Manoeuvres with white innovations.
    pub white_windows: usize,
}

/// Relative residual of the fits of single identification windows.
#[derive(Clone, Debug, Serialize)]
pub struct ResidualSummaryRow {
    pub coefficient: &'static str,
    /// Number of manoeuvres.
    pub windows: usize,
    /// Mean of the relative root mean square, per cent.
    pub mean_percent: f64,
    /// Smallest, per cent.
    pub minimum_percent: f64,
    /// Largest, per cent.
    pub maximum_percent: f64,
}

/// One derivative, pooled and over the identification windows.
#[derive(Clone, Debug, Serialize)]
pub struct DerivativeSummaryRow {
    pub coefficient: &'static str,
    /// Derivative.
    pub name: String,
    /// Estimate from all identification manoeuvres together.
    pub pooled: Option<f64>,
    /// Constraint in use: `fixed`, `at bound`, `prior`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<&'static str>,
    /// Its standard error for white residuals; null if it is fixed or at a bound.
    pub standard_error: Option<f64>,
    /// Its standard error corrected for the correlation of the residuals in time.
    pub corrected_standard_error: Option<f64>,
    /// Standard deviation of the estimates of single manoeuvres: the error of a repetition.
    pub scatter: f64,
    /// Single manoeuvres with an estimate.
    pub windows: usize,
    /// Mean of their estimates.
    pub mean: f64,
    /// Smallest.
    pub minimum: f64,
    /// Largest.
    pub maximum: f64,
    /// Mean of their variances for white residuals (thesis Eq. 3.18).
    pub mean_variance: f64,
    /// Smallest variance.
    pub minimum_variance: f64,
    /// Largest variance.
    pub maximum_variance: f64,
}

/// A recording that was read.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingRow {
    pub flight: String,
    /// Path as in the session.
    pub path: String,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// A flight: what its recordings gave together.
#[derive(Clone, Debug, Serialize)]
pub struct FlightRow {
    pub name: String,
    /// Day it was flown, as the session states it; otherwise that of its first sample in UTC, if recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Who flew it, if the session states it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub crew: String,
    /// Roles the channel maps assigned.
    pub roles: Vec<String>,
    /// Channels of the roles.
    pub channels: Vec<ChannelRow>,
    /// Clocks of its recorders.
    pub clocks: Vec<ClockRow>,
    /// Mass properties at its start and its end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_properties: Option<FlownMassRow>,
    /// Longest gap that was interpolated, s, if the session states one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_gap_s: Option<f64>,
    /// Signals that were smoothed or resampled; the others were used as recorded.
    pub signals: Vec<SignalRow>,
    /// Channels by expression.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expressions: Vec<ExpressionRow>,
    /// Noise over steady parts and the values of the filter.
    pub noise: Vec<NoiseRow>,
    /// Manoeuvres found in the control deflections.
    pub proposals: Vec<ProposalRow>,
    /// Consistency of the channels.
    pub physics: Vec<PhysicsRow>,
    /// Findings.
    pub warnings: Vec<String>,
}

/// A channel by expression.
#[derive(Clone, Debug, Serialize)]
pub struct ExpressionRow {
    pub name: String,
    /// Unit of the values below: SI with a role, otherwise as stated in the session.
    pub unit: String,
    pub expression: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<&'static str>,
    pub samples: usize,
    /// Samples with a value.
    pub values: usize,
    /// Smallest value, mean and largest value; absent without values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_mean_max: Option<[f64; 3]>,
}

/// A channel that plays a role.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelRow {
    pub role: &'static str,
    /// Recorder or file group.
    pub source: String,
    /// Name as recorded.
    pub name: String,
    /// SI unit.
    pub unit: String,
    pub samples: usize,
    /// Samples per second between the first and the last.
    pub rate_hz: f64,
    /// Smallest value recorded, SI; absent like the next without a finite value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum: Option<f64>,
    /// Largest value recorded, SI.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum: Option<f64>,
    /// Standard deviation of one sample that the instruments file states for the role, SI.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Where that is from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_source: Option<String>,
}

/// A recorder's clock, `t = offset + (1 + drift) t_own`.
#[derive(Clone, Debug, Serialize)]
pub struct ClockRow {
    /// Sources with this clock.
    pub source: String,
    /// Flight time at its own time zero, s.
    pub offset_s: f64,
    /// Drift of the flight's time relative to it, s per s.
    pub drift: f64,
    /// Part of the offset added by hand, s.
    pub shift_s: f64,
    /// Standard error of a flight time at the best-known time, s; of a fitted clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error_s: Option<f64>,
    /// Standard error of the drift, s per s; of a fitted clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift_standard_error: Option<f64>,
}

/// One engine over a whole flight.
#[derive(Clone, Debug, Serialize)]
pub struct EngineRow {
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
    #[serde(flatten)]
    pub agreement: AgreementRow,
}

/// One window.
#[derive(Clone, Debug, Serialize)]
pub struct WindowRow {
    pub name: String,
    pub flight: String,
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
    /// Use.
    pub role: &'static str,
    /// Surface moved.
    pub surface: Option<&'static str>,
    /// Kind of input in words.
    pub kind: String,
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Parts excluded from filter updates, fits and scores; absent if empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub excluded: Vec<TimeRange>,
    /// Verdict on its samples, its flight path and its loading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Why its flight path or its coefficients could not be computed; computed results are in the other keys.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Mass properties in its middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_properties: Option<MassRow>,
    /// Inertial samples.
    pub samples: usize,
    /// Source of the air density; absent without coefficients.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub air_density: Option<&'static str>,
    /// How steady it is before its input; absent if it begins with the input.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before_input: Option<Steadiness>,
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
    /// Derivatives from this manoeuvre alone.
    pub fits: Vec<FitRow>,
    /// Findings.
    pub warnings: Vec<String>,
}

/// One state at the end of a window.
#[derive(Clone, Debug, Serialize)]
pub struct StateRow {
    pub state: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Filtered estimate at the last sample.
    pub estimate: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Mean of the filtered estimates over the last second (thesis 6.1).
    pub last_second_mean: f64,
    /// Truth at the last sample, if recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<f64>,
    /// Mean squared normalised error after the first second, if the truth is recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_squared_normalised_error: Option<f64>,
}

/// Innovations of one measurement.
#[derive(Clone, Debug, Serialize)]
pub struct InnovationRow {
    pub measurement: &'static str,
    /// Updates.
    pub samples: usize,
    /// Samples left out as outliers.
    pub outliers: usize,
    /// Mean, in predicted standard deviations.
    pub mean: f64,
    /// Root mean square, in predicted standard deviations: one if consistent, above one if the filter is over-confident.
    pub ratio: f64,
    /// Whether they count as white: Ljung and Box at 5 %.
    pub is_white: bool,
    /// One sentence on what to change, if anything.
    pub advice: String,
}

/// One fit.
#[derive(Clone, Debug, Serialize)]
pub struct FitRow {
    pub coefficient: &'static str,
    /// Manoeuvres of its samples.
    pub windows: Vec<String>,
    /// Verdict on the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Why the fit failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    pub samples: usize,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual relative to the range of the observation, per cent.
    pub rms_relative_percent: f64,
    /// Standard deviation of the residual.
    pub residual_deviation: f64,
    /// Condition number of the scaled regressor matrix.
    pub condition_number: f64,
    /// Stated value to which all its derivatives are proportional.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub follows: Option<StatedQuantity>,
    pub derivatives: Vec<DerivativeRow>,
    /// Correlation of the estimates, row by row.
    pub parameter_correlation: Vec<Vec<f64>>,
    /// Terms left out.
    pub dropped: Vec<DroppedRow>,
}

impl FitRow {
    /// Finds the significant derivative that the stated position of the accelerometers changes most, and by how much.
    pub fn find_most_moved(&self) -> Option<(&DerivativeRow, &Dependence)> {
        /// Largest relative error of a significant derivative, per cent.
        const SIGNIFICANT_PERCENT: f64 = 20.0;
        let significant = self.derivatives.iter().filter(|row| row.relative_error_percent.abs() < SIGNIFICANT_PERCENT);
        let moved = significant.filter_map(|row| {
            let dependence = row.depends_on.iter().find(|dependence| dependence.axis.is_some())?;
            Some((row, dependence))
        });
        moved.max_by(|(_, a), (_, b)| a.change_percent.abs().total_cmp(&b.change_percent.abs()))
    }
}

/// One derivative.
#[derive(Clone, Debug, Serialize)]
pub struct DerivativeRow {
    /// Name, for example `Cm_q`.
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Its part of the coefficient's motion, and its estimate without suspect causes; of pooled fits only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consequence: Option<Consequence>,
    /// Stated values that change it and that no flight shows wrong; of pooled fits only.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub depends_on: Vec<Dependence>,
    /// Estimate; per radian where the variable is an angle.
    pub estimate: f64,
    /// Constraint in use: `fixed`, `at bound`, `prior`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<&'static str>,
    /// Standard error for white residuals; null if the derivative is fixed or at a bound.
    pub standard_error: f64,
    /// Standard error corrected for the correlation of the residuals in time; null likewise.
    pub corrected_standard_error: f64,
    /// 95 % interval by the corrected standard error; absent if the derivative is fixed or at a bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_95: Option<[f64; 2]>,
    /// Standard error over estimate, per cent.
    pub relative_error_percent: f64,
    /// Estimate over standard error.
    pub t: f64,
}

/// Correlation of the regressors of one coefficient.
#[derive(Clone, Debug, Serialize)]
pub struct RegressorRow {
    pub coefficient: &'static str,
    /// Derivatives of the regressors.
    pub derivatives: Vec<String>,
    /// Correlation, row by row.
    pub correlation: Vec<Vec<f64>>,
}

/// A term left out of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct DroppedRow {
    /// Derivative.
    pub name: String,
    pub reason: String,
}
