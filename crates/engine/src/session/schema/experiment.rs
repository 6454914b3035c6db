//! Experiments as they are saved: what differs from the settings of the session, key by key.

use std::collections::BTreeMap;

use doublet_core::model::Structure;
use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::estimation::{EstimationTable, estimation_from, estimation_table};
use super::filter::{FilterParts, FilterTable, filter_from, filter_table};
use super::preparation::{PreparationTable, preparation_from, preparation_table};
use super::sensor_errors::{SensorErrorTable, sensor_error_table, sensor_errors_from};
use super::{SessionError, model_table, no_form, structure_from};
use crate::session::excluded::apart;
use crate::session::experiment::uses_of;
use crate::session::{Configuration, Experiment, ManoeuvreUse, Session, WindowRole};

/// An experiment: the keys of its settings that differ from those of the session, and the keys of the session that it does not have.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExperimentTable {
    name: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unset: Vec<String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    filter: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    preparation: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    sensor_errors: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    estimation: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    model: BTreeMap<String, Value>,
    #[serde(default, rename = "manoeuvre", skip_serializing_if = "Vec::is_empty")]
    windows: Vec<UseTable>,
}

/// A manoeuvre in an experiment.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UseTable {
    name: String,
    start_s: f64,
    end_s: f64,
    role: WindowRole,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    exclude: Vec<TimeRange>,
}

impl From<UseTable> for ManoeuvreUse {
    fn from(UseTable { name, start_s, end_s, role, exclude }: UseTable) -> Self {
        Self { name, window: TimeRange { start_s, end_s }, role, excluded: apart(exclude) }
    }
}

impl From<ManoeuvreUse> for UseTable {
    fn from(ManoeuvreUse { name, window, role, excluded }: ManoeuvreUse) -> Self {
        Self { name, start_s: window.start_s, end_s: window.end_s, role, exclude: excluded }
    }
}

/// The settings of a configuration in the tables of the session file.
#[derive(Serialize, Deserialize)]
pub(super) struct SettingTables {
    #[serde(default)]
    pub(super) filter: FilterTable,
    #[serde(default)]
    pub(super) preparation: PreparationTable,
    #[serde(default)]
    pub(super) sensor_errors: SensorErrorTable,
    #[serde(default)]
    pub(super) estimation: EstimationTable,
    #[serde(default)]
    pub(super) model: BTreeMap<String, Vec<String>>,
}

/// The configuration of a saved form; `manoeuvres` are its uses.
pub(super) fn configuration_from(
    tables: SettingTables,
    manoeuvres: Vec<ManoeuvreUse>,
) -> Result<Configuration, SessionError> {
    let mut preparation = preparation_from(&tables.preparation)?;
    let sensor_errors = sensor_errors_from(&tables.sensor_errors, &mut preparation)?;
    let FilterParts { settings, gravity, gusts, delays } = filter_from(&tables.filter)?;
    Ok(Configuration {
        filter: settings,
        gravity,
        gusts,
        delays,
        preparation,
        sensor_errors,
        estimation: estimation_from(tables.estimation)?,
        structure: match tables.model.is_empty() {
            true => Structure::thesis(),
            false => structure_from(&tables.model)?,
        },
        manoeuvres,
    })
}

/// The saved form of the settings of a configuration.
pub(super) fn setting_tables(configuration: &Configuration) -> SettingTables {
    let Configuration { filter, gravity, gusts, delays, .. } = configuration;
    let parts = FilterParts { settings: filter.clone(), gravity: *gravity, gusts: *gusts, delays: *delays };
    SettingTables {
        filter: filter_table(&parts),
        preparation: preparation_table(&configuration.preparation),
        sensor_errors: sensor_error_table(&configuration.sensor_errors, &configuration.preparation),
        estimation: estimation_table(&configuration.estimation),
        model: model_table(&configuration.structure),
    }
}

/// The settings as `[section] -> key -> value`.
fn sections(configuration: &Configuration) -> Result<Table, SessionError> {
    Table::try_from(setting_tables(configuration)).map_err(|error| no_form(&error))
}

/// The saved form of the experiments of a session.
pub(super) fn experiment_tables(session: &Session) -> Result<Vec<ExperimentTable>, SessionError> {
    if session.experiments.is_empty() {
        return Ok(Vec::new());
    }
    let present = Configuration::from_session(session);
    let base = sections(&present)?;
    session.experiments.iter().map(|experiment| experiment_table(experiment, &present, &base)).collect()
}

fn experiment_table(
    Experiment { name, configuration }: &Experiment,
    present: &Configuration,
    base: &Table,
) -> Result<ExperimentTable, SessionError> {
    let own = sections(configuration)?;
    let section = |tables: &Table, name: &str| tables.get(name).and_then(Value::as_table).cloned().unwrap_or_default();
    let mut unset = Vec::new();
    let mut changed = |name: &str| -> BTreeMap<String, Value> {
        let (own, base) = (section(&own, name), section(base, name));
        unset.extend(base.keys().filter(|key| !own.contains_key(*key)).map(|key| format!("{name}.{key}")));
        own.into_iter().filter(|(key, value)| base.get(key) != Some(value)).collect()
    };
    let [filter, preparation, sensor_errors, estimation, model] =
        ["filter", "preparation", "sensor_errors", "estimation", "model"].map(&mut changed);
    let windows = configuration.manoeuvres.iter().filter(|used| !present.manoeuvres.contains(used));
    Ok(ExperimentTable {
        name: name.clone(),
        unset,
        filter,
        preparation,
        sensor_errors,
        estimation,
        model,
        windows: windows.cloned().map(UseTable::from).collect(),
    })
}

/// The experiments of a saved form, each over the settings of `session`.
pub(super) fn experiments_from(
    tables: Vec<ExperimentTable>,
    session: &Session,
) -> Result<Vec<Experiment>, SessionError> {
    if tables.is_empty() {
        return Ok(Vec::new());
    }
    let present = Configuration::from_session(session);
    let base = sections(&present)?;
    tables.into_iter().map(|table| experiment_from(table, &present, base.clone())).collect()
}

fn experiment_from(
    table: ExperimentTable,
    present: &Configuration,
    mut own: Table,
) -> Result<Experiment, SessionError> {
    let place = format!("experiment '{}'", table.name);
    let inside = |error: SessionError| SessionError::Term { place: place.clone(), reason: error.to_string() };
    for key in &table.unset {
        let (section, key) = key.split_once('.').unwrap_or((key, ""));
        if let Some(Value::Table(section)) = own.get_mut(section) {
            section.remove(key);
        }
    }
    let changed = [
        ("filter", table.filter),
        ("preparation", table.preparation),
        ("sensor_errors", table.sensor_errors),
        ("estimation", table.estimation),
        ("model", table.model),
    ];
    for (name, keys) in changed {
        if let Value::Table(section) = own.entry(name).or_insert_with(|| Table::new().into()) {
            section.extend(keys);
        }
    }
    let settings: SettingTables = own.try_into().map_err(|error| inside(SessionError::in_text("", &error)))?;
    let uses: Vec<ManoeuvreUse> = table.windows.into_iter().map(ManoeuvreUse::from).collect();
    let manoeuvres = uses_of(&present.manoeuvres, &uses);
    Ok(Experiment { configuration: configuration_from(settings, manoeuvres).map_err(inside)?.into(), name: table.name })
}
