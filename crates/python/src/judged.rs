//! Verdicts on paths, coefficients and fits of arrays, by the judge of sessions: what was given is a session of one or more flights.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use doublet_core::model::Structure;
use doublet_engine::begin::empty_session;
use doublet_engine::graph::{Context, Control, Key, Keyed, Stage, StageError};
use doublet_engine::run::{Slot, Snapshot, WindowResults};
use doublet_engine::session::{Estimation, Flight, Manoeuvre, Preparation, Session, print};
use doublet_engine::stage::{FlownMass, PooledFits, WindowAero, WindowFits, WindowPath};
use doublet_engine::verdict::{Verdicts, fold, judge};
use pyo3::prelude::*;

use crate::attend::{detached, refuse};
use crate::path::{Reconstructed, Stated};

/// A window with its path and with what followed from it.
pub struct JudgedWindow<'a> {
    pub manoeuvre: &'a Manoeuvre,
    pub source: &'a Arc<Reconstructed>,
    pub path: &'a Keyed<WindowPath>,
    pub aero: Option<&'a Keyed<WindowAero>>,
    pub fits: Option<WindowFits>,
}

/// How derivatives were fitted, and what came of it.
pub type JudgedFit<'a> = (&'a Structure, &'a Estimation, &'a Keyed<PooledFits>);

/// A session of these windows, every setting as it is by default.
pub fn session_of(windows: Vec<Manoeuvre>) -> Session {
    let mut names: Vec<&str> = Vec::new();
    for window in &windows {
        if !names.contains(&window.flight.as_str()) {
            names.push(&window.flight);
        }
    }
    let flights = names.into_iter().map(|name| Flight::new(name.to_owned(), Vec::new())).collect();
    // A path does not need an aircraft, and what needs one has it.
    Session { flights, windows, ..empty_session("arrays", Some("given")) }
}

/// Verdict on paths, as JSON.
pub fn of_path(py: Python<'_>, path: &Arc<Reconstructed>) -> PyResult<String> {
    let found = detached(py, "verdict", || {
        let windows = path.windows.iter().map(|window| JudgedWindow {
            manoeuvre: &window.manoeuvre,
            source: path,
            path: &window.path,
            aero: None,
            fits: None,
        });
        Ok::<_, StageError>(verdicts(windows.collect(), &path.preparation, None))
    })?;
    json(&found)
}

/// The session of arrays: manoeuvres, each with the path it is of, settings, and structure and estimation of a fit where there is one.
pub fn session_of_arrays(
    windows: &[(&Manoeuvre, &Reconstructed)],
    preparation: &Preparation,
    fit: Option<(&Structure, &Estimation)>,
) -> Session {
    let plain = session_of(windows.iter().map(|(manoeuvre, _)| (*manoeuvre).clone()).collect());
    let Some(Stated { filter, gravity, gusts, delays, aircraft_changes, loading, sensor_errors }) =
        windows.first().map(|(_, source)| &source.stated)
    else {
        return plain;
    };
    let mut session = Session {
        filter: filter.clone(),
        gravity: *gravity,
        gusts: *gusts,
        delays: *delays,
        aircraft_changes: aircraft_changes.clone(),
        loading: loading.clone(),
        sensor_errors: sensor_errors.clone(),
        preparation: preparation.clone(),
        structure: Structure { models: Vec::new() },
        ..plain
    };
    if windows.iter().any(|(_, source)| source.stated.loading != *loading) {
        session.loading = None;
        for flight in &mut session.flights {
            let source = windows.iter().find(|(manoeuvre, _)| manoeuvre.flight == flight.name);
            flight.loading = source.and_then(|(_, source)| source.stated.loading.clone());
        }
    }
    if let Some((structure, estimation)) = fit {
        session.structure = structure.clone();
        session.estimation = estimation.clone();
    }
    session
}

/// A session as JSON, key by key as in its file.
pub fn session_json(session: &Session) -> PyResult<String> {
    let table: toml::Table = toml::from_str(&print(session).map_err(refuse)?).map_err(refuse)?;
    serde_json::to_string(&table).map_err(refuse)
}

/// Verdicts on windows, and on the fit over them where there is one.
pub fn verdicts(windows: Vec<JudgedWindow<'_>>, preparation: &Preparation, fit: Option<JudgedFit<'_>>) -> Verdicts {
    let Some(first) = windows.first().map(|window| window.source) else { return Verdicts::default() };
    let pairs: Vec<_> = windows.iter().map(|window| (window.manoeuvre, &**window.source)).collect();
    let model = fit.map(|(structure, estimation, _)| (structure, estimation));
    let session = session_of_arrays(&pairs, preparation, model);
    let mut snapshot =
        Snapshot { gravity: Some(first.gravity.clone()), delays_and_gusts: first.found.clone(), ..Snapshot::default() };
    if let Some(aircraft) = &first.aircraft {
        snapshot.aircraft = Slot::Ready(Keyed::new(Arc::clone(&aircraft.loaded), Key::unique()));
    }
    add_flights(&mut snapshot, &windows);
    for window in windows {
        let aero = window.aero.map_or(Slot::NotRequested, |aero| Slot::Ready(aero.clone()));
        let fits = window.fits.map_or(Slot::NotRequested, Slot::from);
        let results = WindowResults { path: Slot::Ready(window.path.clone()), aero, fits };
        snapshot.windows.insert(window.manoeuvre.name.clone(), results);
    }
    if let Some((_, _, pooled)) = fit {
        snapshot.pooled = Slot::Ready(pooled.clone());
    }
    judge(&session, &snapshot)
}

/// The flights of the windows: recording, comparison of its channels, mass.
fn add_flights(snapshot: &mut Snapshot, windows: &[JudgedWindow<'_>]) {
    let mut flights: BTreeMap<&str, (&Arc<Reconstructed>, Vec<&Manoeuvre>)> = BTreeMap::new();
    for window in windows {
        let flight = flights.entry(&window.manoeuvre.flight).or_insert_with(|| (window.source, Vec::new()));
        flight.1.push(window.manoeuvre);
    }
    for (name, (source, manoeuvres)) in flights {
        let flight = &source.flight;
        snapshot.flights.insert(name.to_owned(), Slot::Ready(flight.loaded.clone()));
        snapshot.physics.insert(name.to_owned(), Slot::Ready(flight.physics().clone()));
        let control = Control::default();
        let context = Context::new(Path::new("")).with_control(&control, &|_| {});
        let flown = |aircraft| FlownMass::run(&manoeuvres, (aircraft, &flight.loaded), &context).ok();
        if let Some(flown) = source.aircraft.as_ref().and_then(flown) {
            snapshot.flown.insert(name.to_owned(), flown.into());
        }
    }
}

/// Level, findings in order of weight, and the level of every window, coefficient and derivative.
pub fn json(verdicts: &Verdicts) -> PyResult<String> {
    let windows: BTreeMap<_, _> = verdicts.windows.iter().map(|(name, window)| (name, window.verdict.level)).collect();
    let pooled = verdicts.pooled.iter();
    let coefficients: BTreeMap<_, _> = pooled.clone().map(|fit| (fit.coefficient.name(), fit.verdict.level)).collect();
    let derivatives = pooled.flat_map(|fit| &fit.derivatives);
    let derivatives: BTreeMap<_, _> = derivatives.map(|one| (&one.name, one.verdict.level)).collect();
    let lines: Vec<String> = fold(&verdicts.session.reasons, &[]).iter().map(ToString::to_string).collect();
    let all = serde_json::json!({
        "level": verdicts.session.level,
        "lines": lines,
        "reasons": verdicts.session.reasons,
        "windows": windows,
        "coefficients": coefficients,
        "derivatives": derivatives,
    });
    serde_json::to_string(&all).map_err(refuse)
}
