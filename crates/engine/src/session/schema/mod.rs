//! The saved form of a session: readable TOML with a version header, unknown keys refused with their line.

mod constraint;
mod estimation;
mod experiment;
mod filter;
mod migrate;
mod noise;
mod preparation;
mod sensor_errors;
mod signals;

use std::collections::BTreeMap;

use doublet_core::airframe::Loading;
use doublet_core::load::FileHeader;
use doublet_core::model::{Coefficient, Structure, Term};
use doublet_core::schema::{Refused, schema_of};
use doublet_core::series::TimeRange;
use doublet_core::toml_error;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use self::estimation::EstimationTable;
use self::experiment::{
    ExperimentTable, SettingTables, configuration_from, experiment_tables, experiments_from, setting_tables,
};
use self::filter::FilterTable;
use self::noise::NoiseTable;
pub(super) use self::noise::SteadyTable;
use self::preparation::PreparationTable;
use self::sensor_errors::SensorErrorTable;
pub(super) use self::signals::SignalsTable;
use super::edit::set_term;
use super::excluded::apart;
use super::{
    Annotation, Configuration, Flight, Manoeuvre, RefusedCandidate, ReportFigure, Session, SteadyWindow, Surface,
    WindowFlags, WindowRole,
};
use crate::session::{AircraftChanges, PlausibleRange};

/// Value of the header's `format` key.
pub const FORMAT: &str = "doublet session";
pub use self::migrate::VERSION;

/// A session file that cannot be used.
#[derive(Debug, Error)]
pub enum SessionError {
    #[error("{}{message}", .line.map(|line| format!("line {line}: ")).unwrap_or_default())]
    Syntax { line: Option<usize>, message: String },
    #[error("this is not a doublet session: its format is '{found}', expected '{FORMAT}'")]
    Format { found: String },
    #[error("session version {found} is newer than this program understands ({VERSION}): update doublet to open it")]
    Newer { found: u32 },
    /// A name that is not known.
    #[error("{place}: unknown {what} '{name}': use one of {known}")]
    Name { place: String, what: &'static str, name: String, known: String },
    /// A term that cannot be read.
    #[error("{place}: {reason}")]
    Term { place: String, reason: String },
    /// The file cannot be read or written.
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    #[serde(default)]
    app: String,
    #[serde(default)]
    title: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    report_purpose: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    report_asked: Vec<String>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    report_notes: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    aircraft: Option<String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    aircraft_changes: BTreeMap<String, toml::Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    loading: Option<Loading>,
    #[serde(default)]
    filter: FilterTable,
    #[serde(default)]
    preparation: PreparationTable,
    #[serde(default, skip_serializing_if = "SensorErrorTable::is_empty")]
    sensor_errors: SensorErrorTable,
    #[serde(default)]
    estimation: EstimationTable,
    #[serde(default, skip_serializing_if = "VerdictTable::is_empty")]
    verdict: VerdictTable,
    #[serde(default)]
    model: BTreeMap<String, Vec<String>>,
    #[serde(default, rename = "experiment", skip_serializing_if = "Vec::is_empty")]
    experiments: Vec<ExperimentTable>,
    #[serde(default, rename = "flight")]
    flights: Vec<Flight>,
    #[serde(default, skip_serializing_if = "NoiseTable::is_empty")]
    noise: NoiseTable,
    #[serde(default, rename = "steady", skip_serializing_if = "Vec::is_empty")]
    steady: Vec<SteadyWindow>,
    #[serde(default, rename = "manoeuvre")]
    windows: Vec<Manoeuvre>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    refused: Vec<RefusedCandidate>,
    #[serde(default, rename = "annotation", skip_serializing_if = "Vec::is_empty")]
    annotations: Vec<Annotation>,
    #[serde(default, rename = "report_figure", skip_serializing_if = "Vec::is_empty")]
    report_figures: Vec<ReportFigure>,
}

/// A manoeuvre.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WindowTable {
    name: String,
    flight: String,
    start_s: f64,
    end_s: f64,
    #[serde(default = "identification")]
    role: WindowRole,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    surface: Option<String>,
    #[serde(default)]
    kind: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    note: String,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    locked: bool,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    confirmed: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    exclude: Vec<TimeRange>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct VerdictTable {
    plausible: BTreeMap<String, PlausibleRange>,
}

impl VerdictTable {
    fn is_empty(&self) -> bool {
        self.plausible.is_empty()
    }
}

/// Whether a value is its default, which a file leaves out.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn identification() -> WindowRole {
    WindowRole::Identification
}

fn name_of<T: PartialEq + Copy>(choices: &[(&'static str, T)], value: T) -> String {
    choices.iter().find(|(_, choice)| *choice == value).map_or(String::new(), |(name, _)| (*name).to_owned())
}

fn unknown(place: &str, what: &'static str, name: &str, known: &[&str]) -> SessionError {
    SessionError::Name { place: place.to_owned(), what, name: name.to_owned(), known: known.join(", ") }
}

fn choose<T: Copy>(choices: &[(&'static str, T)], place: &str, name: &str) -> Result<T, SessionError> {
    choices
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, value)| *value)
        .ok_or_else(|| unknown(place, "choice", name, &choices.iter().map(|(known, _)| *known).collect::<Vec<_>>()))
}

/// JSON Schema of session files.
pub fn json_schema() -> Result<serde_json::Value, Refused> {
    schema_of::<File>(FORMAT)
}

impl SessionError {
    /// The error of a text, or of values where the text is empty.
    fn in_text(text: &str, error: &toml::de::Error) -> Self {
        let line = toml_error::line(text, error).filter(|_| !text.is_empty());
        let message = if line.is_some() { toml_error::message(error) } else { toml_error::one_line("", error) };
        Self::Syntax { line, message }
    }
}

fn read<T: DeserializeOwned>(text: &str) -> Result<T, SessionError> {
    toml::from_str(text).map_err(|error| SessionError::in_text(text, &error))
}

/// Reads a session from its text.
pub fn parse(text: &str) -> Result<Session, SessionError> {
    let header: FileHeader = read(text)?;
    if header.format != FORMAT {
        return Err(SessionError::Format { found: header.format });
    }
    if header.version > VERSION {
        return Err(SessionError::Newer { found: header.version });
    }
    let file: File = if header.version == VERSION {
        read(text)?
    } else {
        let mut table: toml::Table = read(text)?;
        migrate::to_present(&mut table, header.version);
        file_from(table)?
    };
    session_from(file)
}

fn file_from(table: toml::Table) -> Result<File, SessionError> {
    table.try_into().map_err(|error| SessionError::in_text("", &error))
}

/// Reads a session from the tables of its present saved form.
pub fn from_table(table: toml::Table) -> Result<Session, SessionError> {
    session_from(file_from(table)?)
}

fn session_from(file: File) -> Result<Session, SessionError> {
    let tables = SettingTables {
        filter: file.filter,
        preparation: file.preparation,
        sensor_errors: file.sensor_errors,
        estimation: file.estimation,
        model: file.model,
    };
    let configuration = configuration_from(tables, Vec::new())?;
    let mut session = Session {
        title: file.title,
        aircraft: file.aircraft,
        aircraft_changes: AircraftChanges::try_from(&file.aircraft_changes)
            .map_err(|reason| SessionError::Term { place: "session".to_owned(), reason })?,
        loading: file.loading,
        flights: file.flights,
        windows: file.windows,
        refused: file.refused,
        steady: file.steady,
        noise_reasons: file.noise.reasons()?,
        gravity: configuration.gravity,
        gusts: configuration.gusts,
        delays: configuration.delays,
        filter: configuration.filter,
        preparation: configuration.preparation,
        sensor_errors: configuration.sensor_errors,
        estimation: configuration.estimation,
        structure: configuration.structure,
        experiments: Vec::new(),
        annotations: file.annotations,
        report_purpose: file.report_purpose,
        report_asked: file.report_asked,
        report_notes: file.report_notes,
        report_figures: file.report_figures.into_iter().map(readable).collect::<Result<_, _>>()?,
        plausible: file.verdict.plausible,
    };
    session.experiments = experiments_from(file.experiments, &session)?;
    Ok(session)
}

fn readable(figure: ReportFigure) -> Result<ReportFigure, SessionError> {
    let place = || format!("report_figure '{}'", figure.caption);
    figure.figure().map_err(|reason| SessionError::Term { place: place(), reason })?;
    Ok(figure)
}

impl TryFrom<WindowTable> for Manoeuvre {
    type Error = SessionError;

    fn try_from(table: WindowTable) -> Result<Self, SessionError> {
        let place = format!("manoeuvre '{}'", table.name);
        let [surface, also] = surfaces_from(&place, table.surface.as_deref().filter(|names| !names.is_empty()))?;
        Ok(Self {
            role: table.role,
            surface,
            also,
            name: table.name,
            flight: table.flight,
            window: TimeRange { start_s: table.start_s, end_s: table.end_s },
            kind: table.kind,
            note: table.note,
            flags: WindowFlags { locked: table.locked, confirmed: table.confirmed },
            excluded: apart(table.exclude),
        })
    }
}

impl From<Manoeuvre> for WindowTable {
    fn from(manoeuvre: Manoeuvre) -> Self {
        Self {
            surface: manoeuvre.surface_name().map(str::to_owned),
            name: manoeuvre.name,
            flight: manoeuvre.flight,
            start_s: manoeuvre.window.start_s,
            end_s: manoeuvre.window.end_s,
            role: manoeuvre.role,
            kind: manoeuvre.kind,
            note: manoeuvre.note,
            locked: manoeuvre.flags.locked,
            confirmed: manoeuvre.flags.confirmed,
            exclude: manoeuvre.excluded,
        }
    }
}

/// The surface a manoeuvre moves, or the two it moves, as in `aileron and rudder`.
fn surfaces_from(place: &str, names: Option<&str>) -> Result<[Option<Surface>; 2], SessionError> {
    let surfaces = Surface::ALL.map(|surface| (surface.name(), surface));
    let Some(names) = names else { return Ok([None; 2]) };
    let (first, second) = names.split_once(" and ").map_or((names, None), |(first, second)| (first, Some(second)));
    let surface = choose(&surfaces, place, first)?;
    let also = second.map(|second| choose(&surfaces, place, second)).transpose()?;
    Ok([Some(surface), also.filter(|also| *also != surface)])
}

fn structure_from(table: &BTreeMap<String, Vec<String>>) -> Result<Structure, SessionError> {
    let known = Coefficient::ALL.map(Coefficient::name);
    let mut structure = Structure { models: Vec::new() };
    for coefficient in Coefficient::ALL {
        for text in table.get(coefficient.name()).into_iter().flatten() {
            let place = format!("model.{}", coefficient.name());
            let term = Term::parse(text).map_err(|error| SessionError::Term { place, reason: error.to_string() })?;
            set_term(&mut structure, coefficient, &term, true);
        }
    }
    match table.keys().find(|name| !known.contains(&name.as_str())) {
        Some(name) => Err(unknown("model", "coefficient", name, &known)),
        None => Ok(structure),
    }
}

/// Writes a session as text that [`parse`] reads back to an equal session.
pub fn print(session: &Session) -> Result<String, SessionError> {
    let body = toml::to_string_pretty(&file_of(session)?).map_err(|error| no_form(&error))?;
    Ok(format!("# Noise is stated as standard deviations. Every number is in SI units and radians.\n{body}"))
}

/// The tables of the saved form of a session.
pub fn to_table(session: &Session) -> Result<toml::Table, SessionError> {
    toml::Table::try_from(file_of(session)?).map_err(|error| no_form(&error))
}

fn no_form(error: &impl ToString) -> SessionError {
    SessionError::Term { place: "session".to_owned(), reason: error.to_string() }
}

fn file_of(session: &Session) -> Result<File, SessionError> {
    let settings = setting_tables(&Configuration::from_session(session));
    Ok(File {
        format: FORMAT.to_owned(),
        version: VERSION,
        app: crate::PROGRAM.to_owned(),
        title: session.title.clone(),
        report_purpose: session.report_purpose.clone(),
        report_asked: session.report_asked.clone(),
        report_notes: session.report_notes.clone(),
        aircraft: session.aircraft.clone(),
        aircraft_changes: session.aircraft_changes.to_table(),
        loading: session.loading.clone(),
        filter: settings.filter,
        preparation: settings.preparation,
        sensor_errors: settings.sensor_errors,
        estimation: settings.estimation,
        verdict: VerdictTable { plausible: session.plausible.clone() },
        model: settings.model,
        experiments: experiment_tables(session)?,
        flights: session.flights.clone(),
        noise: NoiseTable::from_reasons(&session.noise_reasons),
        steady: session.steady.clone(),
        windows: session.windows.clone(),
        refused: session.refused.clone(),
        annotations: session.annotations.clone(),
        report_figures: session.report_figures.clone(),
    })
}

fn model_table(structure: &Structure) -> BTreeMap<String, Vec<String>> {
    let row = |(coefficient, terms): &(Coefficient, Vec<Term>)| {
        (coefficient.name().to_owned(), terms.iter().map(ToString::to_string).collect())
    };
    structure.models.iter().map(row).collect()
}
