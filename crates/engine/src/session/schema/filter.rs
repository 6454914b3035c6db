//! The saved form of the filter's settings.

use std::collections::BTreeMap;

use doublet_core::atmos::STANDARD_GRAVITY_M_S2;
use doublet_core::reconstruct::{
    AirState, FilterSettings, Input, InputHold, Linearisation, Measurement, Method, State, USUAL_OUTLIER_LIMIT,
};
use serde::{Deserialize, Serialize};

use super::super::{DelaySource, GravitySource, GustSource};
use super::{SessionError, is_default, unknown};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FilterTable {
    method: String,
    max_iterations: usize,
    tolerance: f64,
    hold: InputHold,
    linearisation: Linearisation,
    #[serde(skip_serializing_if = "Option::is_none")]
    gravity_m_s2: Option<f64>,
    #[serde(skip_serializing_if = "is_default")]
    gusts: GustSource,
    #[serde(skip_serializing_if = "is_default")]
    delays: DelaySource,
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
    #[serde(skip_serializing_if = "is_default")]
    robust_limit: f64,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    air_data_deviation: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    measurement_delay_s: BTreeMap<String, f64>,
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
        settings_table(&FilterSettings::default())
    }
}

const METHODS: [&str; 3] = ["ekf", "iekf", "ukf"];

/// The filter's settings and where gravity, gusts and delays come from.
pub(super) struct FilterParts {
    pub(super) settings: FilterSettings,
    pub(super) gravity: GravitySource,
    pub(super) gusts: GustSource,
    pub(super) delays: DelaySource,
}

/// The settings of a saved form.
pub(super) fn filter_from(table: &FilterTable) -> Result<FilterParts, SessionError> {
    Ok(FilterParts {
        gravity: if table.gravity_m_s2.is_some() { GravitySource::Stated } else { GravitySource::Position },
        gusts: table.gusts,
        delays: table.delays,
        settings: settings_from(table)?,
    })
}

/// The saved form.
pub(super) fn filter_table(parts: &FilterParts) -> FilterTable {
    FilterTable {
        gravity_m_s2: (parts.gravity == GravitySource::Stated).then_some(parts.settings.gravity_m_s2),
        gusts: parts.gusts,
        delays: parts.delays,
        ..settings_table(&parts.settings)
    }
}

fn settings_from(table: &FilterTable) -> Result<FilterSettings, SessionError> {
    let method = match table.method.as_str() {
        "ekf" => Method::Ekf,
        "iekf" => Method::Iekf { max_iterations: table.max_iterations, tolerance: table.tolerance },
        "ukf" => Method::Ukf { spread: table.spread },
        other => return Err(unknown("filter.method", "choice", other, &METHODS)),
    };
    let mut settings = FilterSettings {
        method,
        hold: table.hold,
        linearisation: table.linearisation,
        gravity_m_s2: table.gravity_m_s2.unwrap_or(STANDARD_GRAVITY_M_S2),
        smoother_passes: table.smoother_passes,
        outlier_limit: table.outlier_limit,
        robust_limit: table.robust_limit,
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

/// Values with the names of their places.
fn by_name<const N: usize>(names: [&'static str; N], values: &[f64; N]) -> impl Iterator<Item = (String, f64)> {
    names.into_iter().zip(values).map(|(name, &value)| (name.to_owned(), value))
}

fn settings_table(settings: &FilterSettings) -> FilterTable {
    let usual = Method::USUAL_SPREAD;
    let (method, max_iterations, tolerance, spread) = match settings.method {
        Method::Ekf => ("ekf", 1, 1e-3, usual),
        Method::Iekf { max_iterations, tolerance } => ("iekf", max_iterations, tolerance, usual),
        Method::Ukf { spread } => ("ukf", 1, 1e-3, spread),
    };
    let (inputs, states) = (Input::ALL.map(Input::name), State::ALL.map(State::name));
    let measurements = Measurement::ALL.map(Measurement::name);
    let moving = |(_, deviation): &(String, f64)| *deviation != 0.0;
    FilterTable {
        method: method.to_owned(),
        max_iterations,
        tolerance,
        hold: settings.hold,
        linearisation: settings.linearisation,
        gravity_m_s2: None,
        gusts: GustSource::default(),
        delays: DelaySource::default(),
        process_noise: by_name(inputs, &settings.process_noise).collect(),
        measurement_noise: by_name(measurements, &settings.measurement_noise).collect(),
        initial_deviation: by_name(states, &settings.initial_deviation).collect(),
        initial_state: State::ALL
            .into_iter()
            .filter_map(|state| Some((state.name().to_owned(), settings.initial_state[state as usize]?)))
            .collect(),
        random_walk: by_name(states, &settings.random_walk).filter(moving).collect(),
        spread,
        smoother_passes: settings.smoother_passes,
        outlier_limit: settings.outlier_limit,
        robust_limit: settings.robust_limit,
        air_data_deviation: by_name(AirState::ALL.map(AirState::name), &settings.air_data_deviation)
            .filter(moving)
            .collect(),
        measurement_delay_s: by_name(measurements, &settings.measurement_delay_s).filter(moving).collect(),
    }
}
