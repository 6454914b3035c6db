//! The saved form of a session: readable TOML with a version header, unknown keys refused with their line.

mod constraint;
mod expression;
mod flight;
mod kept;
mod migrate;
mod noise;
mod preparation;
mod sensor_errors;
mod signals;

use std::collections::BTreeMap;

use doublet_core::airframe::Loading;
use doublet_core::atmos::STANDARD_GRAVITY_M_S2;
use doublet_core::model::{Coefficient, Structure, Term};
use doublet_core::reconstruct::{
    AirState, FilterSettings, INPUTS, Input, InputHold, Linearisation, MEASUREMENTS, Measurement, Method, STATES,
    State, USUAL_OUTLIER_LIMIT,
};
use doublet_core::schema::{Refused, schema_of};
use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use self::constraint::{ConstraintTable, constraint_from, constraint_table};
use self::flight::{FlightTable, flight_from, flight_table};
use self::kept::{KeptTable, kept_from, kept_table};
use self::noise::{NoiseTable, SteadyTable, steady_from, steady_table};
use self::preparation::{PreparationTable, preparation_from, preparation_table};
use self::sensor_errors::{SensorErrorTable, sensor_error_table, sensor_errors_from};
use super::edit::set_term;
use super::excluded::apart;
use super::{
    Annotation, DelaySource, Estimation, GravitySource, GustSource, Manoeuvre, PooledConstants, PredictionParameters,
    Preparation, ReportFigure, Session, Surface, WindowFlags, WindowRole,
};
use crate::aircraft::AircraftChanges;
use crate::verdict::PlausibleRange;

/// Value of the header's `format` key.
pub const FORMAT: &str = "doublet session";
pub use self::migrate::VERSION;

/// A session file that cannot be used.
#[derive(Debug, Error)]
pub enum SessionError {
    /// Not TOML, or keys that do not belong.
    #[error("{}", .0.to_string().trim_end().replace('\n', " "))]
    Syntax(#[from] Box<toml::de::Error>),
    /// Another kind of file.
    #[error("this is not a doublet session: its format is '{found}', expected '{FORMAT}'")]
    Format {
        /// Value of the `format` key, empty when there is none.
        found: String,
    },
    /// Written by a newer program.
    #[error("session version {found} is newer than this program understands ({VERSION}): update doublet to open it")]
    Newer {
        /// Version of the file.
        found: u32,
    },
    /// A name that is not known.
    #[error("{place}: unknown {what} '{name}': use one of {known}")]
    Name {
        /// Key of the file.
        place: String,
        /// Kind of name.
        what: &'static str,
        /// Name found.
        name: String,
        /// Names understood.
        known: String,
    },
    /// A term that cannot be read.
    #[error("{place}: {reason}")]
    Term {
        /// Key of the file.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// The file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// Path.
        path: String,
        /// Cause.
        source: std::io::Error,
    },
}

/// The header, read before anything else.
#[derive(Deserialize)]
struct Header {
    #[serde(default)]
    format: String,
    #[serde(default)]
    version: u32,
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
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    second_model: BTreeMap<String, Vec<String>>,
    #[serde(default, rename = "kept_model", skip_serializing_if = "Vec::is_empty")]
    kept_models: Vec<KeptTable>,
    #[serde(default, rename = "flight")]
    flights: Vec<FlightTable>,
    #[serde(default, skip_serializing_if = "NoiseTable::is_empty")]
    noise: NoiseTable,
    #[serde(default, rename = "steady", skip_serializing_if = "Vec::is_empty")]
    steady: Vec<SteadyTable>,
    #[serde(default, rename = "window")]
    windows: Vec<WindowTable>,
    #[serde(default, rename = "annotation", skip_serializing_if = "Vec::is_empty")]
    annotations: Vec<Annotation>,
    #[serde(default, rename = "report_figure", skip_serializing_if = "Vec::is_empty")]
    report_figures: Vec<ReportFigure>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WindowTable {
    name: String,
    flight: String,
    start_s: f64,
    end_s: f64,
    #[serde(default = "identification")]
    role: String,
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
    exclude: Vec<StretchTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StretchTable {
    start_s: f64,
    end_s: f64,
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

fn identification() -> String {
    WindowRole::Identification.name().to_owned()
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FilterTable {
    method: String,
    max_iterations: usize,
    tolerance: f64,
    hold: String,
    linearisation: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    gravity_m_s2: Option<f64>,
    #[serde(skip_serializing_if = "is_estimated")]
    gusts: String,
    #[serde(skip_serializing_if = "is_estimated")]
    delays: String,
    process_noise: BTreeMap<String, f64>,
    measurement_noise: BTreeMap<String, f64>,
    initial_deviation: BTreeMap<String, f64>,
    initial_state: BTreeMap<String, f64>,
    random_walk: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "is_usual_spread")]
    spread: f64,
    #[serde(skip_serializing_if = "is_one")]
    smoother_passes: usize,
    #[serde(skip_serializing_if = "is_usual_limit")]
    outlier_limit: f64,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    air_data_deviation: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    measurement_delay_s: BTreeMap<String, f64>,
}

/// The default, which a file leaves out.
const ESTIMATED: &str = "estimated";

fn is_estimated(source: &str) -> bool {
    source == ESTIMATED
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form serde asks for")]
fn is_usual_spread(spread: &f64) -> bool {
    *spread == Method::USUAL_SPREAD
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form serde asks for")]
fn is_usual_limit(limit: &f64) -> bool {
    *limit == USUAL_OUTLIER_LIMIT
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form serde asks for")]
fn is_one(passes: &usize) -> bool {
    *passes == 1
}

impl Default for FilterTable {
    fn default() -> Self {
        filter_table(&FilterSettings::default())
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct EstimationTable {
    by_surface: bool,
    constants: String,
    #[serde(skip_serializing_if = "is_pooled")]
    predict_with: String,
    #[serde(rename = "constraint", skip_serializing_if = "Vec::is_empty")]
    constraints: Vec<ConstraintTable>,
}

fn is_pooled(predict_with: &str) -> bool {
    predict_with == PREDICTIONS[0].0
}

impl Default for EstimationTable {
    fn default() -> Self {
        estimation_table(&Estimation::default())
    }
}

/// Names of the choices, in one place for both directions.
const METHODS: [&str; 3] = ["ekf", "iekf", "ukf"];
const GUSTS: [(&str, GustSource); 2] = [(ESTIMATED, GustSource::Estimated), ("stated", GustSource::Stated)];
const DELAYS: [(&str, DelaySource); 2] = [(ESTIMATED, DelaySource::Estimated), ("stated", DelaySource::Stated)];
const HOLDS: [(&str, InputHold); 2] = [("first_order", InputHold::FirstOrder), ("zero_order", InputHold::ZeroOrder)];
const LINEARISATIONS: [(&str, Linearisation); 2] =
    [("prior", Linearisation::Prior), ("predicted", Linearisation::Predicted)];
const CONSTANTS: [(&str, PooledConstants); 2] =
    [("per_window", PooledConstants::PerWindow), ("common", PooledConstants::Common)];
const PREDICTIONS: [(&str, PredictionParameters); 2] =
    [("pooled", PredictionParameters::Pooled), ("window_means", PredictionParameters::WindowMeans)];
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
///
/// # Errors
/// As [`schema_of`].
pub fn json_schema() -> Result<serde_json::Value, Refused> {
    schema_of::<File>(FORMAT)
}

/// Reads a session from its text.
///
/// # Errors
/// [`SessionError`] with the line of a syntax error or unknown key, or the key of an unknown name.
pub fn parse(text: &str) -> Result<Session, SessionError> {
    let header: Header = toml::from_str(text).map_err(Box::new)?;
    if header.format != FORMAT {
        return Err(SessionError::Format { found: header.format });
    }
    if header.version > VERSION {
        return Err(SessionError::Newer { found: header.version });
    }
    let file: File = if header.version == VERSION {
        toml::from_str(text).map_err(Box::new)?
    } else {
        let mut table: toml::Table = toml::from_str(text).map_err(Box::new)?;
        migrate::to_present(&mut table, header.version);
        table.try_into().map_err(Box::new)?
    };
    let (sensor_errors, known_errors) = sensor_errors_from(&file.sensor_errors)?;
    let flights = file.flights.into_iter().map(flight_from).collect::<Result<_, SessionError>>()?;
    Ok(Session {
        title: file.title,
        aircraft: file.aircraft,
        aircraft_changes: AircraftChanges::try_from(&file.aircraft_changes)
            .map_err(|reason| SessionError::Term { place: "session".to_owned(), reason })?,
        loading: file.loading,
        flights,
        windows: file.windows.into_iter().map(window_from).collect::<Result<_, _>>()?,
        steady: file.steady.into_iter().map(steady_from).collect::<Result<_, _>>()?,
        noise_reasons: file.noise.reasons()?,
        gravity: if file.filter.gravity_m_s2.is_some() { GravitySource::Stated } else { GravitySource::Position },
        gusts: choose(&GUSTS, "filter.gusts", &file.filter.gusts)?,
        delays: choose(&DELAYS, "filter.delays", &file.filter.delays)?,
        filter: filter_from(&file.filter)?,
        preparation: Preparation { known_errors, ..preparation_from(&file.preparation)? },
        sensor_errors,
        estimation: Estimation {
            by_surface: file.estimation.by_surface,
            constants: choose(&CONSTANTS, "estimation.constants", &file.estimation.constants)?,
            predict_with: choose(&PREDICTIONS, "estimation.predict_with", &file.estimation.predict_with)?,
            constraints: file.estimation.constraints.into_iter().map(constraint_from).collect::<Result<_, _>>()?,
        },
        structure: if file.model.is_empty() { Structure::thesis() } else { structure_from("model", &file.model)? },
        second_structure: match file.second_model.is_empty() {
            true => None,
            false => Some(structure_from("second_model", &file.second_model)?),
        },
        kept_structures: file.kept_models.into_iter().map(kept_from).collect::<Result<_, _>>()?,
        annotations: file.annotations,
        report_notes: file.report_notes,
        report_figures: file.report_figures.into_iter().map(readable).collect::<Result<_, _>>()?,
        plausible: file.verdict.plausible,
    })
}

fn readable(figure: ReportFigure) -> Result<ReportFigure, SessionError> {
    let place = || format!("report_figure '{}'", figure.caption);
    figure.figure().map_err(|reason| SessionError::Term { place: place(), reason })?;
    Ok(figure)
}

fn window_from(table: WindowTable) -> Result<Manoeuvre, SessionError> {
    let place = format!("manoeuvre '{}'", table.name);
    let roles = WindowRole::ALL.map(|role| (role.name(), role));
    let [surface, also] = surfaces_from(&place, table.surface.as_deref())?;
    Ok(Manoeuvre {
        role: choose(&roles, &place, &table.role)?,
        surface,
        also,
        name: table.name,
        flight: table.flight,
        window: TimeRange { start_s: table.start_s, end_s: table.end_s },
        kind: table.kind,
        note: table.note,
        flags: WindowFlags { locked: table.locked, confirmed: table.confirmed },
        excluded: apart(table.exclude.into_iter().map(stretch).collect()),
    })
}

fn stretch(StretchTable { start_s, end_s }: StretchTable) -> TimeRange {
    TimeRange { start_s, end_s }
}

fn stretch_table(&TimeRange { start_s, end_s }: &TimeRange) -> StretchTable {
    StretchTable { start_s, end_s }
}

/// The surface a window moves, or the two it moves, as in `aileron and rudder`.
fn surfaces_from(place: &str, names: Option<&str>) -> Result<[Option<Surface>; 2], SessionError> {
    let surfaces = Surface::ALL.map(|surface| (surface.name(), surface));
    let Some(names) = names else { return Ok([None; 2]) };
    let (first, second) = names.split_once(" and ").map_or((names, None), |(first, second)| (first, Some(second)));
    let surface = choose(&surfaces, place, first)?;
    let also = second.map(|second| choose(&surfaces, place, second)).transpose()?;
    Ok([Some(surface), also.filter(|also| *also != surface)])
}

fn filter_from(table: &FilterTable) -> Result<FilterSettings, SessionError> {
    let method = match table.method.as_str() {
        "ekf" => Method::Ekf,
        "iekf" => Method::Iekf { max_iterations: table.max_iterations, tolerance: table.tolerance },
        "ukf" => Method::Ukf { spread: table.spread },
        other => return Err(unknown("filter.method", "choice", other, &METHODS)),
    };
    let mut settings = FilterSettings {
        method,
        hold: choose(&HOLDS, "filter.hold", &table.hold)?,
        linearisation: choose(&LINEARISATIONS, "filter.linearisation", &table.linearisation)?,
        gravity_m_s2: table.gravity_m_s2.unwrap_or(STANDARD_GRAVITY_M_S2),
        smoother_passes: table.smoother_passes,
        outlier_limit: table.outlier_limit,
        ..FilterSettings::default()
    };
    let inputs = Input::ALL.map(Input::name);
    let measurements = Measurement::ALL.map(Measurement::name);
    let states = State::ALL.map(State::name);
    fill("filter.process_noise", &inputs, &table.process_noise, |i, v| settings.process_noise[i] = v)?;
    fill("filter.measurement_noise", &measurements, &table.measurement_noise, |i, v| {
        settings.measurement_noise[i] = v;
    })?;
    fill("filter.initial_deviation", &states, &table.initial_deviation, |i, v| settings.initial_deviation[i] = v)?;
    fill("filter.initial_state", &states, &table.initial_state, |i, v| settings.initial_state[i] = Some(v))?;
    fill("filter.random_walk", &states, &table.random_walk, |i, v| settings.random_walk[i] = v)?;
    fill("filter.air_data_deviation", &AirState::ALL.map(AirState::name), &table.air_data_deviation, |i, v| {
        settings.air_data_deviation[i] = v;
    })?;
    fill("filter.measurement_delay_s", &measurements, &table.measurement_delay_s, |i, v| {
        settings.measurement_delay_s[i] = v;
    })?;
    Ok(settings)
}

fn fill(
    place: &str,
    names: &[&str],
    table: &BTreeMap<String, f64>,
    mut set: impl FnMut(usize, f64),
) -> Result<(), SessionError> {
    for (name, &value) in table {
        let index = names.iter().position(|known| known == name);
        set(index.ok_or_else(|| unknown(place, "name", name, names))?, value);
    }
    Ok(())
}

fn structure_from(key: &str, table: &BTreeMap<String, Vec<String>>) -> Result<Structure, SessionError> {
    let known = Coefficient::ALL.map(Coefficient::name);
    let mut structure = Structure { models: Vec::new() };
    for coefficient in Coefficient::ALL {
        for text in table.get(coefficient.name()).into_iter().flatten() {
            let place = format!("{key}.{}", coefficient.name());
            let term = Term::parse(text).map_err(|error| SessionError::Term { place, reason: error.to_string() })?;
            set_term(&mut structure, coefficient, &term, true);
        }
    }
    match table.keys().find(|name| !known.contains(&name.as_str())) {
        Some(name) => Err(unknown(key, "coefficient", name, &known)),
        None => Ok(structure),
    }
}

/// Writes a session as text that [`parse`] reads back to an equal session.
///
/// # Errors
/// [`SessionError::Term`] should a value have no TOML form.
pub fn print(session: &Session) -> Result<String, SessionError> {
    let file = File {
        format: FORMAT.to_owned(),
        version: VERSION,
        app: crate::PROGRAM.to_owned(),
        title: session.title.clone(),
        report_notes: session.report_notes.clone(),
        aircraft: session.aircraft.clone(),
        aircraft_changes: session.aircraft_changes.to_table(),
        loading: session.loading.clone(),
        filter: FilterTable {
            gravity_m_s2: (session.gravity == GravitySource::Stated).then_some(session.filter.gravity_m_s2),
            gusts: name_of(&GUSTS, session.gusts),
            delays: name_of(&DELAYS, session.delays),
            ..filter_table(&session.filter)
        },
        preparation: preparation_table(&session.preparation),
        sensor_errors: sensor_error_table(&session.sensor_errors, &session.preparation.known_errors),
        estimation: estimation_table(&session.estimation),
        verdict: VerdictTable { plausible: session.plausible.clone() },
        model: model_table(&session.structure),
        second_model: session.second_structure.as_ref().map(model_table).unwrap_or_default(),
        kept_models: session.kept_structures.iter().map(kept_table).collect(),
        flights: session.flights.iter().map(flight_table).collect(),
        noise: NoiseTable::of(&session.noise_reasons),
        steady: session.steady.iter().map(steady_table).collect(),
        windows: session.windows.iter().map(window_table).collect(),
        annotations: session.annotations.clone(),
        report_figures: session.report_figures.clone(),
    };
    let body = toml::to_string_pretty(&file)
        .map_err(|error| SessionError::Term { place: "session".to_owned(), reason: error.to_string() })?;
    Ok(format!("# Noise is stated as standard deviations. Every number is in SI units and radians.\n{body}"))
}

fn model_table(structure: &Structure) -> BTreeMap<String, Vec<String>> {
    let row = |(coefficient, terms): &(Coefficient, Vec<Term>)| {
        (coefficient.name().to_owned(), terms.iter().map(ToString::to_string).collect())
    };
    structure.models.iter().map(row).collect()
}

fn window_table(window: &Manoeuvre) -> WindowTable {
    WindowTable {
        name: window.name.clone(),
        flight: window.flight.clone(),
        start_s: window.window.start_s,
        end_s: window.window.end_s,
        role: window.role.name().to_owned(),
        surface: window.surface_name().map(str::to_owned),
        kind: window.kind.clone(),
        note: window.note.clone(),
        locked: window.flags.locked,
        confirmed: window.flags.confirmed,
        exclude: window.excluded.iter().map(stretch_table).collect(),
    }
}

fn filter_table(settings: &FilterSettings) -> FilterTable {
    let usual = Method::USUAL_SPREAD;
    let (method, max_iterations, tolerance, spread) = match settings.method {
        Method::Ekf => ("ekf", 1, 1e-3, usual),
        Method::Iekf { max_iterations, tolerance } => ("iekf", max_iterations, tolerance, usual),
        Method::Ukf { spread } => ("ukf", 1, 1e-3, spread),
    };
    let inputs = |values: &[f64; INPUTS]| Input::ALL.map(|i| (i.name().to_owned(), values[i as usize])).into();
    let states = |values: &[f64; STATES]| State::ALL.map(|s| (s.name().to_owned(), values[s as usize])).into();
    let measurements =
        |values: &[f64; MEASUREMENTS]| Measurement::ALL.map(|m| (m.name().to_owned(), values[m as usize])).into();
    let moving = |(_, deviation): &(String, f64)| *deviation != 0.0;
    FilterTable {
        method: method.to_owned(),
        max_iterations,
        tolerance,
        hold: name_of(&HOLDS, settings.hold),
        linearisation: name_of(&LINEARISATIONS, settings.linearisation),
        gravity_m_s2: None,
        gusts: ESTIMATED.to_owned(),
        delays: ESTIMATED.to_owned(),
        process_noise: inputs(&settings.process_noise),
        measurement_noise: measurements(&settings.measurement_noise),
        initial_deviation: states(&settings.initial_deviation),
        initial_state: State::ALL
            .into_iter()
            .filter_map(|state| Some((state.name().to_owned(), settings.initial_state[state as usize]?)))
            .collect(),
        random_walk: BTreeMap::from_iter(
            State::ALL.map(|s| (s.name().to_owned(), settings.random_walk[s as usize])).into_iter().filter(moving),
        ),
        spread,
        smoother_passes: settings.smoother_passes,
        outlier_limit: settings.outlier_limit,
        air_data_deviation: AirState::ALL
            .map(|s| (s.name().to_owned(), settings.air_data_deviation[s as usize]))
            .into_iter()
            .filter(moving)
            .collect(),
        measurement_delay_s: Measurement::ALL
            .map(|m| (m.name().to_owned(), settings.measurement_delay_s[m as usize]))
            .into_iter()
            .filter(moving)
            .collect(),
    }
}

fn estimation_table(estimation: &Estimation) -> EstimationTable {
    EstimationTable {
        by_surface: estimation.by_surface,
        constants: name_of(&CONSTANTS, estimation.constants),
        predict_with: name_of(&PREDICTIONS, estimation.predict_with),
        constraints: estimation.constraints.iter().map(constraint_table).collect(),
    }
}
