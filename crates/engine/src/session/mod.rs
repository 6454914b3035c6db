//! The session: exactly what is saved and undoable, never a result.

mod aircraft;
mod aircraft_changes;
mod annotation;
mod check;
mod constraint;
mod edit;
mod excluded;
mod experiment;
mod expression;
mod file;
mod finding;
mod fix;
mod flags;
mod map_ref;
mod noise;
mod paths;
mod preparation;
mod refused;
mod report_figure;
mod schema;
mod sensor_errors;
mod signals;
mod window_edit;

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};

use doublet_core::airframe::Loading;
use doublet_core::hash_fields;
use doublet_core::model::{Coefficient, Structure, Variable};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::FilterSettings;
use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

use self::schema::{WindowTable, is_default};

pub use aircraft::AircraftEdit;
pub(crate) use aircraft_changes::ENVELOPE;
pub use aircraft_changes::{AircraftChanges, ChangedValue};
pub use annotation::{Annotation, AnnotationEdit};
pub(crate) use check::STEADY;
pub use check::{MOST_WINDOWS, check, fitting_name, stops_run};
pub use constraint::TermConstraint;
pub use edit::{Edit, EditError, EstimationEdit, FilterEdit, LoadingEdit, ModelEdit};
pub use experiment::{
    Configuration, Experiment, ExperimentEdit, MOST_EXPERIMENTS, ManoeuvreUse, cross_experiments, filter_experiments,
    manoeuvre_experiments, noise_experiments, structure_experiments,
};
pub use expression::{EXPRESSION_SOURCE, ExpressionEdit, ExpressionSetting};
pub use file::{Opened, content_hash, open, rebased, save, save_without_backup, shipped};
pub(crate) use finding::write_fix;
pub use finding::{Finding, Level, Place, PlausibleRange, Verdict};
pub use fix::Fix;
pub use flags::{WindowFlag, WindowFlags};
pub use map_ref::MapRef;
pub use noise::{NoiseChannel, NoiseEdit, NoiseEntry, SteadyWindow};
pub use paths::{check_output, leads_out, path_warning, paths, relative_to};
pub use preparation::{AngularAcceleration, ControlLags, MomentReference, Preparation};
pub use refused::{CandidateEdit, RefusedCandidate};
pub use report_figure::{ReportFigure, ReportFigureEdit};
pub use schema::{FORMAT, SessionError, VERSION, from_table, json_schema, parse, print, to_table};
pub use sensor_errors::{ErrorValues, InstrumentAccuracy, SensorErrorMethod, SensorErrors};
pub use signals::{HeldSampleUse, SignalEdit, SignalPreset, SignalRule, SignalSetting};
pub use window_edit::WindowEdit;

/// Everything an analysis is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    /// Title of the report.
    pub title: String,
    /// Aircraft file, relative to the session file, or `builtin:` and a name; without one only flight paths are computed.
    pub aircraft: Option<String>,
    /// What is otherwise than that file says.
    pub aircraft_changes: AircraftChanges,
    /// What is on board in flights without a loading of their own; `None` for the aircraft's standard loading. Without any fuel it
    /// states all but the fuel.
    pub loading: Option<Loading>,
    /// Flights with their recordings.
    pub flights: Vec<Flight>,
    /// Manoeuvre windows, in the order they are shown.
    pub windows: Vec<Manoeuvre>,
    /// Manoeuvres found in the recordings that were refused, in the order of time.
    pub refused: Vec<RefusedCandidate>,
    /// Steady parts whose scatter is noise, marked by hand.
    pub steady: Vec<SteadyWindow>,
    /// Why an entry of the noise is what it is, by the name of the input or measurement.
    pub noise_reasons: BTreeMap<String, String>,
    /// Settings of the flight path reconstruction. Its gravity counts where [`Session::gravity`] says so.
    pub filter: FilterSettings,
    /// Where the acceleration of gravity comes from.
    pub gravity: GravitySource,
    /// Where the random walk of the wind comes from.
    pub gusts: GustSource,
    /// Where the delays of the measurements come from.
    pub delays: DelaySource,
    /// How coefficients are formed from the reconstructed path.
    pub preparation: Preparation,
    /// Constant errors of the sensors asked for.
    pub sensor_errors: SensorErrors,
    /// How derivatives are estimated.
    pub estimation: Estimation,
    /// Terms of each coefficient.
    pub structure: Structure,
    /// Configurations kept by name, each with the manoeuvres of the session.
    pub experiments: Vec<Experiment>,
    /// Words at instants of the flights, in the order of time.
    pub annotations: Vec<Annotation>,
    /// What the flights were for: in the report.
    pub report_purpose: String,
    /// Derivatives that were asked for, by name: the report answers each.
    pub report_asked: Vec<String>,
    /// What the author has to say: in the report, before its figures.
    pub report_notes: String,
    /// Figures the author has chosen: in the report, behind the notes.
    pub report_figures: Vec<ReportFigure>,
    /// What derivatives of this aircraft may be, by name, in the form they have here; others are judged by the ranges of a
    /// conventional aeroplane.
    pub plausible: BTreeMap<String, PlausibleRange>,
}

/// Where the acceleration of gravity comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GravitySource {
    /// The filter's settings state it.
    Stated,
    /// Latitude and altitude of the flights, where they are recorded; otherwise it is the standard one.
    #[default]
    Position,
}

/// Where the random walk of the wind comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GustSource {
    /// The filter's settings state it.
    Stated,
    /// The likelihood of the measurements: gusts beside what the settings state, where they are significant.
    #[default]
    Estimated,
}

/// Where the delays of the measurements come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DelaySource {
    /// The filter's settings state them.
    Stated,
    /// The innovations of all windows: delays beside what the settings state, where they are significant.
    #[default]
    Estimated,
}

/// Recordings that share one time line.
#[derive(Clone, Debug, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flight {
    /// Name windows refer to.
    pub name: String,
    /// Day it was flown, where the recordings do not say it or say it wrong.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub date: String,
    /// Who flew it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub crew: String,
    /// Its recordings; roles of an earlier one take precedence.
    #[serde(default, rename = "recording")]
    pub recordings: Vec<RecordingRef>,
    /// Clocks of recorders that do not run on the flight's time line.
    #[serde(default, rename = "clock", skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<ClockSetting>,
    /// Instruments whose raw signals become roles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruments: Option<InstrumentSetting>,
    /// Smoothing and resampling of signals before they are used.
    #[serde(default, skip_serializing_if = "is_default")]
    pub signals: SignalSetting,
    /// Channels computed from others, in their order: one may name those before it.
    #[serde(default, rename = "expression", skip_serializing_if = "Vec::is_empty")]
    pub expressions: Vec<ExpressionSetting>,
    /// What was on board in this flight, in the place of the session's loading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loading: Option<Loading>,
}

impl Flight {
    /// A flight of these recordings, taken as they are.
    pub fn new(name: String, recordings: Vec<RecordingRef>) -> Self {
        let signals = SignalSetting::default();
        let (clocks, expressions, date, crew) = Default::default();
        Self { name, date, crew, recordings, clocks, instruments: None, signals, expressions, loading: None }
    }

    /// What its recordings are read by: the flight without loading, date and crew.
    #[must_use]
    pub fn as_read(&self) -> Self {
        Self { loading: None, date: String::new(), crew: String::new(), ..self.clone() }
    }
}

/// Instruments whose raw signals become deflections, flow angles and fuel mass.
#[derive(Clone, Debug, Default, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstrumentSetting {
    /// Instruments file, relative to the session file, or `builtin:` and a name.
    pub file: String,
    /// Sources of the control sensors, `*` standing for a sensor's name in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control_sensors: Option<String>,
    /// Whether turns are integrated rates and the column follows Eq. 4.5, as in the thesis, instead of attitudes and the triangle.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub thesis_controls: bool,
    /// Source of the air-data pod.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pod: Option<String>,
    /// Flight whose calibration the pod's number has.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub pod_calibration: String,
    /// Level flight from which the calibration is made anew by the lift curve, instead of one the file has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level_flight: Option<LevelFlight>,
    /// Channel (`source/name`) of each tank's fuel probe.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fuel: BTreeMap<String, String>,
}

/// Steady level flight at the pod's numbers 0, 85 and 100, which calibrates it by the instruments' lift curve (thesis section 4.3.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelFlight {
    pub mass_kg: f64,
    /// True airspeed at the numbers 0, 85 and 100, m/s.
    pub airspeed_m_s: [f64; 3],
    /// Pressure altitude, whose density in the standard atmosphere counts, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
    /// Air density, kg/m³, in the place of the altitude's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
}

hash_fields!(LevelFlight { ; mass_kg, airspeed_m_s, altitude_m, density_kg_m3 });

/// A recorder's clock: `t = offset + (1 + drift) t_own` (thesis Table 4.14).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClockSetting {
    /// Sources it stamps: a name, or the beginning of names followed by `*`.
    pub source: String,
    /// Flight time at its own time zero, s; with `fit`, where the search starts.
    #[serde(default)]
    pub offset_s: f64,
    /// Gain of the flight's time on it, s per s.
    #[serde(default)]
    pub drift: f64,
    /// Channels both it and the flight's time line record: the clock is fitted to them. Empty for the clock as set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fit: Vec<ClockPairSetting>,
    /// Seconds added to the clock, set or fitted, by hand.
    #[serde(default, skip_serializing_if = "is_default")]
    pub shift_s: f64,
}

hash_fields!(ClockSetting { source, fit; offset_s, drift, shift_s });

impl ClockSetting {
    /// The clock of a source that runs on the flight's time line.
    pub fn new(source: &str) -> Self {
        Self { source: source.to_owned(), offset_s: 0.0, drift: 0.0, fit: Vec::new(), shift_s: 0.0 }
    }
}

/// A quantity two recorders have.
#[derive(Clone, Debug, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClockPairSetting {
    /// Channel on the flight's time line, `source/name`.
    pub reference: String,
    /// Channel of the recorder, `source/name`.
    pub other: String,
    /// The two have opposite signs.
    #[serde(default)]
    pub inverted: bool,
}

/// A recording by path, content and meaning of its channels.
#[derive(Clone, Debug, PartialEq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingRef {
    /// File or folder, relative to the session file, or `builtin:` and a name.
    pub path: String,
    /// SHA-256 of the content when it was added; `None` if it was never read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// Which channel plays which role.
    pub channel_map: MapRef,
    /// The only roles to take from it; `None` for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub only: Option<Vec<Role>>,
}

/// What a window is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindowRole {
    /// Its data enter the estimate.
    Identification,
    /// Its data test the estimate.
    Validation,
    /// Kept, not used.
    Ignored,
}

/// The control surface a manoeuvre moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surface {
    /// Elevator: symmetric motion.
    Elevator,
    /// Aileron: asymmetric motion.
    Aileron,
    /// Rudder: asymmetric motion.
    Rudder,
}

/// A manoeuvre window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WindowTable", into = "WindowTable")]
pub struct Manoeuvre {
    /// Name, unique in the session.
    pub name: String,
    /// Name of the flight it lies in.
    pub flight: String,
    /// First and last instant on the flight's time line.
    pub window: TimeRange,
    /// Use.
    pub role: WindowRole,
    /// Surface moved; `None` when more than two or unknown.
    pub surface: Option<Surface>,
    /// Second surface moved.
    pub also: Option<Surface>,
    /// Kind of input in words, for example `3-2-1-1`.
    pub kind: String,
    /// What there is to say about it; no result follows from it.
    pub note: String,
    /// What else is so of it; no result follows from it.
    pub flags: WindowFlags,
    /// Parts left out, in the order of time and apart from each other: no measurement of them enters the filter, no sample a fit.
    pub excluded: Vec<TimeRange>,
}

/// The path the coefficients are formed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathSource {
    /// Filtered states, biases at their final estimates.
    Filtered,
    /// Smoothed states.
    Smoothed,
    /// Airspeed, flow angles and attitude as measured; no filter runs.
    Measured,
}

/// Constants of the pooled estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PooledConstants {
    /// Every manoeuvre has its own constant term.
    PerManoeuvre,
    /// One constant term for all manoeuvres.
    Common,
}

/// What manoeuvres are predicted with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictionParameters {
    /// The pooled estimate.
    #[default]
    Pooled,
    /// Means of the estimates of single identification manoeuvres, constants included (thesis 7.1).
    ManoeuvreMeans,
}

/// What the residuals of a regression weigh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ResidualWeights {
    /// All the same: ordinary least squares.
    #[default]
    Equal,
    /// Large ones less (Huber 1964).
    Huber,
    /// By their correlation in time, an autoregression of the given order: generalised least squares.
    Autoregression(usize),
}

impl ResidualWeights {
    /// Usual order of the autoregression.
    pub const USUAL_ORDER: usize = 2;
}

/// What of a session the estimates of its windows follow from.
#[derive(Clone, Copy, Debug, Hash)]
pub struct Settings<'a> {
    /// Settings of the flight path reconstruction.
    pub filter: &'a FilterSettings,
    /// How coefficients are formed.
    pub preparation: &'a Preparation,
    /// Terms of each coefficient.
    pub structure: &'a Structure,
    /// How derivatives are estimated.
    pub estimation: &'a Estimation,
}

/// How derivatives are estimated.
#[derive(Clone, Debug, PartialEq, Hash)]
pub struct Estimation {
    /// Symmetric coefficients from elevator windows, asymmetric ones from aileron and rudder windows.
    pub by_surface: bool,
    /// Constants of the pooled estimate.
    pub constants: PooledConstants,
    /// What windows are predicted with.
    pub predict_with: PredictionParameters,
    /// What the residuals weigh.
    pub weights: ResidualWeights,
    /// What is known of derivatives beforehand, by coefficient and term; others are free.
    pub constraints: Vec<TermConstraint>,
}

impl Default for Estimation {
    fn default() -> Self {
        Self {
            by_surface: true,
            constants: PooledConstants::PerManoeuvre,
            predict_with: PredictionParameters::Pooled,
            weights: ResidualWeights::Equal,
            constraints: Vec::new(),
        }
    }
}

impl WindowRole {
    doublet_core::named_variants! {
        /// Name in files and tables.
        pub name: Identification "identification", Validation "validation", Ignored "ignored"
    }
}

impl Manoeuvre {
    /// A window to identify with, of which nothing more is known.
    pub fn new(name: String, flight: String, window: TimeRange) -> Self {
        let (kind, note, flags) = (String::new(), String::new(), WindowFlags::default());
        Self {
            name,
            flight,
            window,
            role: WindowRole::Identification,
            surface: None,
            also: None,
            kind,
            note,
            flags,
            excluded: Vec::new(),
        }
    }

    /// Name of the surface or the two surfaces moved, in files and tables.
    pub fn surface_name(&self) -> Option<&'static str> {
        self.surface.map(|surface| self.also.map_or(surface.name(), |other| surface.name_with(other)))
    }

    /// Time half way through, s.
    pub fn middle_s(&self) -> f64 {
        0.5 * (self.window.start_s + self.window.end_s)
    }
}

/// By all that results follow from.
impl Hash for Manoeuvre {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { name, flight, window, role, surface, also, kind, note: _, flags: _, excluded } = self;
        (name, flight, window, role, surface, also, kind, excluded).hash(state);
    }
}

impl Surface {
    doublet_core::named_variants! {
        /// Name in files and tables.
        pub name: Elevator "elevator", Aileron "aileron", Rudder "rudder"
    }

    /// Names of two surfaces moved together, in the order of [`Self::ALL`].
    fn name_with(self, other: Self) -> &'static str {
        match (self, other) {
            (Self::Elevator, Self::Aileron) | (Self::Aileron, Self::Elevator) => "elevator and aileron",
            (Self::Elevator, Self::Rudder) | (Self::Rudder, Self::Elevator) => "elevator and rudder",
            (Self::Aileron, Self::Rudder) | (Self::Rudder, Self::Aileron) => "aileron and rudder",
            (one, _) => one.name(),
        }
    }

    /// Role of its deflection.
    pub fn role(self) -> Role {
        match self {
            Self::Elevator => Role::Elevator,
            Self::Aileron => Role::Aileron,
            Self::Rudder => Role::Rudder,
        }
    }

    /// Its deflection in terms.
    pub fn variable(self) -> Variable {
        match self {
            Self::Elevator => Variable::Elevator,
            Self::Aileron => Variable::Aileron,
            Self::Rudder => Variable::Rudder,
        }
    }

    /// Coefficient of the moment that it is there for.
    pub fn moment(self) -> Coefficient {
        match self {
            Self::Elevator => Coefficient::Cm,
            Self::Aileron => Coefficient::Cl,
            Self::Rudder => Coefficient::Cn,
        }
    }

    /// Role of the rate it answers for first.
    pub fn rate(self) -> Role {
        match self {
            Self::Elevator => Role::PitchRate,
            Self::Aileron => Role::RollRate,
            Self::Rudder => Role::YawRate,
        }
    }
}

impl Session {
    /// What the estimates of its windows follow from.
    pub fn settings(&self) -> Settings<'_> {
        let Self { filter, preparation, structure, estimation, .. } = self;
        Settings { filter, preparation, structure, estimation }
    }

    /// Windows that are not ignored, in order.
    pub fn active_windows(&self) -> impl Iterator<Item = &Manoeuvre> {
        self.windows.iter().filter(|window| window.role != WindowRole::Ignored)
    }

    /// The flight called `name`.
    pub fn flight(&self, name: &str) -> Option<&Flight> {
        self.flights.iter().find(|flight| flight.name == name)
    }

    /// What was on board in the flight called `name`: its own loading, or the session's; `None` for the standard one.
    pub fn loading_in(&self, name: &str) -> Option<&Loading> {
        self.flight(name).and_then(|flight| flight.loading.as_ref()).or(self.loading.as_ref())
    }

    /// The window called `name`.
    pub fn window(&self, name: &str) -> Option<&Manoeuvre> {
        self.windows.iter().find(|window| window.name == name)
    }
}
