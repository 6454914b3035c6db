//! Sessions and their results: the same as the window and the command line have.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::{ChannelMap, Plan, plan_all, read_text};
use doublet_engine::begin;
use doublet_engine::check::check_session;
use doublet_engine::export::{Format, IdentifiedModel, write as write_model};
use doublet_engine::graph::{Cache, Control, StageError};
use doublet_engine::report::{self, HistoryFormat, Outputs, TableFormat};
use doublet_engine::run::{Scope, Snapshot, WindowResults, run as run_stages};
use doublet_engine::session::{self, Manoeuvre, MapRef, Session as Settings};
use doublet_engine::stage::{AeroWindow, ReplayWindow, WindowPath};
use doublet_engine::study::{MonteCarloRequest, Study};
use doublet_engine::verdict::list_failures;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{Notices, Show, attend, attend_with, detached, pooled, refuse};
use crate::columns::{matrix, shared};
use crate::judged::session_json;
use crate::predicted;
use crate::recording::Recording;

/// Memory for intermediate results of one run with studies, bytes.
const CACHE_BYTES: usize = 2 << 30;

/// A session: recordings, windows, settings, structure. It never changes; `replaced` gives another.
#[pyclass(frozen, module = "doublet")]
pub struct Session {
    settings: Arc<Settings>,
    /// Folder its relative paths start from.
    folder: PathBuf,
    path: Option<PathBuf>,
}

/// Sets the value at a dotted key of a table, making tables on the way; parts that are numbers are places in lists.
fn set(table: &mut toml::Value, key: &str, value: toml::Value) -> Result<(), String> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    let place = match table {
        toml::Value::Array(list) => {
            let count = list.len();
            let index: Option<usize> = first.parse().ok();
            index
                .and_then(|index| list.get_mut(index))
                .ok_or_else(|| format!("'{first}' is outside the list of {count}"))?
        }
        toml::Value::Table(table) => table.entry(first).or_insert_with(|| toml::Value::Table(toml::Table::new())),
        _ => return Err(format!("'{first}' lies below a value that has no keys")),
    };
    match rest {
        Some(rest) => set(place, rest, value),
        None => {
            *place = value;
            Ok(())
        }
    }
}

#[pymethods]
impl Session {
    /// Opens a session file, or `builtin:` and the name of one that comes with doublet.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let opened = pooled(|| session::open(&path)).map_err(|error| refuse(format!("{}: {error}", path.display())))?;
        let is_file = session::shipped(&path).is_none();
        Ok(Self { settings: Arc::new(opened.session), folder: opened.folder, path: is_file.then_some(opened.path) })
    }

    /// A session from its text; relative paths start from `folder`.
    #[staticmethod]
    fn parse(text: &str, folder: PathBuf) -> PyResult<Self> {
        Ok(Self { settings: Arc::new(session::parse(text).map_err(refuse)?), folder, path: None })
    }

    /// A session from its text and its place.
    #[staticmethod]
    fn restore(text: &str, folder: PathBuf, path: Option<PathBuf>) -> PyResult<Self> {
        Ok(Self { path, ..Self::parse(text, folder)? })
    }

    /// A session for recordings of one flight: the channel map that fits best or else a guess, the manoeuvres found as windows.
    #[staticmethod]
    fn begin(
        py: Python<'_>,
        paths: Vec<PathBuf>,
        name: String,
        channel_map: Option<String>,
        aircraft: Option<String>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let work = move |control: &Control, show: Show<'_>| -> Result<Settings, String> {
            let inspected = match &channel_map {
                Some(_) => begin::inspect_for_map(&paths, control, show)?,
                None => begin::inspect(&paths, control, show)?,
            };
            let (map, plan, own) = choose_map(channel_map.as_deref(), &inspected)?;
            let order = begin::Order { name, aircraft: aircraft.or(own), map };
            begin::begin(&order, &inspected, &plan, control, show)
        };
        let settings = attend(py, "begin", progress, work)?;
        Ok(Self { settings: Arc::new(settings), folder: PathBuf::new(), path: None })
    }

    /// The session as it is saved: TOML.
    #[getter]
    fn text(&self) -> PyResult<String> {
        session::print(&self.settings).map_err(refuse)
    }

    /// Its file.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.path.clone()
    }

    /// Folder its relative paths start from.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.clone()
    }

    /// The same as JSON, key by key as in the file.
    fn json(&self) -> PyResult<String> {
        session_json(&self.settings)
    }

    /// The session with other values: dotted keys of its file, each with a value as JSON.
    fn replaced(&self, changes: Vec<(String, String)>) -> PyResult<Self> {
        let mut table: toml::Value = toml::from_str(&self.text()?).map_err(refuse)?;
        for (key, json) in changes {
            let value: toml::Value = serde_json::from_str(&json).map_err(|error| refuse(format!("{key}: {error}")))?;
            set(&mut table, &key, value).map_err(|error| refuse(format!("{key}: {error}")))?;
        }
        let text = toml::to_string(&table).map_err(refuse)?;
        let settings = session::parse(&text).map_err(refuse)?;
        Ok(Self { settings: Arc::new(settings), folder: self.folder.clone(), path: self.path.clone() })
    }

    /// Saves it in one step; the previous file stays as `*.bak`.
    fn save(&self, path: PathBuf) -> PyResult<Self> {
        let absolute =
            |folder: &Path| std::path::absolute(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let rebased = session::rebased(&self.settings, &absolute(&self.folder)?, &absolute(&folder)?);
        session::save(&rebased, &path).map_err(refuse)?;
        Ok(Self { settings: Arc::new(rebased), folder, path: Some(path) })
    }

    /// What `doublet check --json` prints.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        let checked =
            detached(py, "check", || Ok::<_, StageError>(check_session(&self.settings, &self.folder, &|_| ())))?;
        serde_json::to_string(&checked).map_err(refuse)
    }

    /// Computes everything it asks for, and studies.
    fn run(
        &self,
        py: Python<'_>,
        studies: Vec<String>,
        realisations: usize,
        seed: u64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Results> {
        let studies = studies.iter().map(|name| study(name, realisations, seed)).collect::<PyResult<Vec<_>>>()?;
        let stopped: Vec<_> = session::check(&self.settings).into_iter().filter(session::stops_run).collect();
        if !stopped.is_empty() {
            return Err(refuse(stopped.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")));
        }
        let (settings, folder) = (Arc::clone(&self.settings), self.folder.clone());
        let notices = Notices::default();
        let notice = notices.clone();
        let work = move |control: &Control, show: Show<'_>| {
            let publish = |snapshot: Snapshot| {
                snapshot.memory.into_iter().for_each(|finding| notice.add(&finding));
                show(snapshot.progress);
            };
            computed(&settings, &folder, &studies, control, &publish)
        };
        let snapshot = attend_with(py, "run", (progress, &notices), work)?;
        Ok(Results { settings: Arc::clone(&self.settings), snapshot })
    }
}

/// The map that is named, else the one that fits best, else the guess; with its plan and the aircraft it states.
fn choose_map(name: Option<&str>, inspected: &begin::Inspected) -> Result<(MapRef, Plan, Option<String>), String> {
    let Some(name) = name else {
        if let Some(fitting) = inspected.fitting.first() {
            return Ok((fitting.reference(), fitting.plan.clone(), fitting.aircraft.clone()));
        }
        let text = inspected.guess.text().map_err(|error| error.to_string())?;
        return Ok((MapRef::Own(text.into()), begin::plan_by_hand(&inspected.probes, &inspected.guess)?, None));
    };
    let fault = |error: &dyn std::fmt::Display| format!("{name}: {error}");
    let text = match doublet_engine::builtin::text("channel_maps", name) {
        Some(text) => text.to_owned(),
        None => read_text(Path::new(name)).map_err(|error| fault(&error))?,
    };
    let plan = plan_all(&inspected.probes, &ChannelMap::parse(&text).map_err(|error| fault(&error))?);
    Ok((MapRef::Own(text.into()), plan, None))
}

fn computed(
    settings: &Settings,
    folder: &Path,
    studies: &[Study],
    control: &Control,
    publish: &(dyn Fn(Snapshot) + Sync),
) -> Result<Snapshot, String> {
    let scope = Scope { session: settings, folder, first: None, studies, cause: "run", generation: 1 };
    let cache = Cache::new(if studies.is_empty() { 0 } else { CACHE_BYTES });
    let snapshot = run_stages(&scope, &Snapshot::default(), &cache, control, publish);
    control.checkpoint().map_err(|_| "cancelled".to_owned())?;
    let failures = snapshot.failures();
    let any = snapshot.windows.values().any(|window| window.path.ready().is_some());
    if any || failures.is_empty() {
        return Ok(snapshot);
    }
    Err(list_failures(&failures).join("\n"))
}

/// A study by its name on the command line.
fn study(name: &str, realisations: usize, seed: u64) -> PyResult<Study> {
    match Study::from_key(name) {
        Some(Study::MonteCarlo(_)) => Ok(Study::MonteCarlo(MonteCarloRequest { realisations, seed })),
        Some(study) => Ok(study),
        None => {
            let known: Vec<_> = Study::keys().map(|(key, _)| key).collect();
            Err(refuse(format!("'{name}' is not a study: use {}", known.join(", "))))
        }
    }
}

impl Results {
    fn window(&self, manoeuvre: &Manoeuvre) -> Option<&WindowResults> {
        self.snapshot.windows.get(&manoeuvre.name)
    }

    fn path(&self, window: &str) -> PyResult<&WindowPath> {
        let found = self.snapshot.windows.get(window).and_then(|window| window.path.ready()).map(|path| &**path);
        found.ok_or_else(|| refuse(format!("no manoeuvre in use is called '{window}', or it has no path")))
    }
}

/// What a session came to.
#[pyclass(frozen, module = "doublet")]
pub struct Results {
    pub(crate) settings: Arc<Settings>,
    pub(crate) snapshot: Snapshot,
}

#[pymethods]
impl Results {
    /// The content of results.json.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, "results", || serde_json::to_string(&report::build(&self.settings, &self.snapshot)))
    }

    /// Writes what `doublet run --out` writes; returns the folder.
    fn write(&self, py: Python<'_>, folder: PathBuf, tables: Vec<String>, histories: Vec<String>) -> PyResult<PathBuf> {
        let outputs = Outputs {
            tables: TableFormat::ALL
                .into_iter()
                .filter(|format| tables.iter().any(|name| name == format.name()))
                .collect(),
            histories: HistoryFormat::ALL
                .into_iter()
                .filter(|format| histories.iter().any(|name| name == format.name()))
                .collect(),
            recordings: false,
        };
        let put = detached(py, "results", || {
            report::check_target(&folder)?;
            report::write(&self.settings, &self.snapshot, &folder, &outputs, &Control::default(), &|_| {})
        })?;
        Ok(put.folder)
    }

    /// Writes the identified model for other simulators; returns the files.
    fn export(&self, py: Python<'_>, formats: Vec<String>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        let known = || Format::ALL.map(Format::name).join(", ");
        let format = |name: &String| {
            Format::from_name(name).ok_or_else(|| refuse(format!("'{name}' is not a format: choose among {}", known())))
        };
        let formats = formats.iter().map(format).collect::<PyResult<Vec<_>>>()?;
        let put = detached(py, "export", || {
            let model = IdentifiedModel::new(&self.settings, &self.snapshot)?;
            write_model(&model, &formats, &folder)
        })?;
        Ok(put.files)
    }

    /// A flight as the run read it, the first unless it is named: on one time line, instruments and signals treated.
    fn recording(&self, flight: Option<&str>) -> PyResult<Recording> {
        let all = &self.snapshot.flights;
        let names = || all.keys().cloned().collect::<Vec<_>>().join(", ");
        let first = self.settings.flights.first().map(|flight| flight.name.as_str());
        let slot = flight.or(first).and_then(|name| all.get(name));
        let found = slot.and_then(|slot| slot.keyed());
        let found = found.ok_or_else(|| refuse(format!("flight not found or not readable: use one of {}", names())))?;
        Ok(Recording::of_flight(found.clone()))
    }

    /// Covariance of all estimates by corrected errors, in order.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Settings { structure, estimation, windows, .. } = &*self.settings;
        let aero = |manoeuvre| Some((manoeuvre, Arc::clone(self.window(manoeuvre)?.aero.keyed()?.shared())));
        let windows: Vec<AeroWindow<'_>> = windows.iter().filter_map(aero).collect();
        let found = detached(py, "covariance", || {
            let pooled = self.snapshot.pooled.ready().ok_or("no pooled estimate")?;
            Ok::<_, StageError>(predicted::covariance(pooled, &windows, (structure, estimation)))
        })?;
        Ok(matrix(py, &found))
    }

    /// Measurements of a window by name, each with predictions and reconstructed values.
    fn measurements<'py>(&self, py: Python<'py>, window: &str) -> PyResult<Bound<'py, PyDict>> {
        let filter = self.snapshot.delays_and_gusts.added_to(&self.settings.filter);
        predicted::measurements(py, self.path(window)?, &filter.measurement_delay_s)
    }

    /// A manoeuvre flown by the model: by signal time (s), reconstructed and simulated values.
    fn simulated<'py>(&self, py: Python<'py>, window: &str) -> PyResult<Bound<'py, PyDict>> {
        let path = self.path(window)?;
        let manoeuvre = self.settings.window(window);
        let aero = manoeuvre.and_then(|manoeuvre| self.window(manoeuvre)).and_then(|found| found.aero.ready());
        let (Some(manoeuvre), Some(aero)) = (manoeuvre, aero) else {
            return Err(refuse(format!("manoeuvre '{window}' has no coefficients")));
        };
        let pooled = self.snapshot.pooled.ready().ok_or_else(|| refuse("no pooled estimate"))?;
        let gravity = self.snapshot.gravity.as_ref().map_or(self.settings.filter.gravity_m_s2, |gravity| gravity.m_s2);
        let window = ReplayWindow { manoeuvre, path, aero };
        let Settings { structure, preparation, .. } = &*self.settings;
        predicted::simulated(py, &window, (pooled, structure), (preparation, gravity))
    }

    /// What failed: place and reason.
    fn failures(&self) -> Vec<(String, String)> {
        let failed = self.snapshot.failures().into_iter().chain(self.snapshot.failed_fits());
        failed.map(|(place, error)| (place.to_string(), error)).collect()
    }

    /// Time, s, and smoothed or filtered states of a window by name.
    fn states<'py>(&self, py: Python<'py>, window: &str) -> PyResult<Bound<'py, PyDict>> {
        let series = self.path(window)?.series();
        let states = series.smoothed.as_ref().map_or(&series.states, |smoothed| &smoothed.states);
        let all = PyDict::new(py);
        all.set_item("time", shared(py, &states[0].time_s)?)?;
        for state in doublet_core::reconstruct::State::ALL {
            all.set_item(state.name(), shared(py, &states[state as usize].values)?)?;
        }
        Ok(all)
    }
}
