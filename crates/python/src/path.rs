//! Step 1: flight paths of windows.

use std::sync::Arc;

use doublet_core::airframe::Loading;
use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::{FilterSettings, Measurement, STATES, State};
use doublet_core::series::TimeRange;
use doublet_engine::graph::{Control, Key, KeyBuilder, Keyed, StageError};
use doublet_engine::session::{
    AircraftChanges, DelaySource, GravitySource, GustSource, MOST_WINDOWS, Manoeuvre, Preparation, SensorErrors,
    Session, Surface, WindowRole,
};
use doublet_engine::stage::{
    AircraftData, DelaysAndGusts, Gravity, LoadedFlight, Samples, WindowPath, estimate_delays_and_gusts, fit_in_memory,
    gravity, memory_finding, paths, samples,
};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::aircraft::Aircraft;
use crate::attend::{Show, attend, refuse, warn};
use crate::columns::{matrix, owned, shared};
use crate::judged::{self, session_json, session_of, session_of_arrays};
use crate::predicted::measurements;
use crate::recording::{RecordedFlight, Recording};
use crate::settings::session_with;

/// A window as Python gives it: name, start and end (s), surface, kind of input, role, excluded parts (s).
pub type WindowGiven = (String, f64, f64, Option<String>, String, String, Vec<(f64, f64)>);

#[derive(Clone)]
pub struct PathWindow {
    pub manoeuvre: Manoeuvre,
    pub path: Keyed<WindowPath>,
}

/// Settings as a session states them: of the filter, the aircraft and the sensors.
pub struct Stated {
    pub filter: FilterSettings,
    pub gravity: GravitySource,
    pub gusts: GustSource,
    pub delays: DelaySource,
    pub aircraft_changes: AircraftChanges,
    pub loading: Option<Loading>,
    pub sensor_errors: SensorErrors,
}

/// Everything a path was made from, and the path of each window.
pub struct Reconstructed {
    pub flight: Arc<RecordedFlight>,
    pub aircraft: Option<Keyed<AircraftData>>,
    pub stated: Stated,
    /// What the innovations estimated in addition.
    pub found: DelaysAndGusts,
    /// The settings in use: those stated with what was found.
    pub filter: FilterSettings,
    pub gravity: Gravity,
    pub preparation: Preparation,
    pub windows: Vec<PathWindow>,
}

/// Flight paths of the windows of one recording.
#[pyclass(frozen, module = "doublet")]
pub struct Path {
    pub(crate) inner: Arc<Reconstructed>,
}

/// Name of the flight that arrays and files make.
pub const FLIGHT: &str = "flight";

fn window((name, start_s, end_s, surface, kind, role, excluded): WindowGiven) -> PyResult<Manoeuvre> {
    let wrong = |what: &str, found: &str, known: &[&str]| {
        refuse(format!("manoeuvre '{name}': '{found}' is not a {what}: use one of {}", known.join(", ")))
    };
    let surface = surface
        .map(|text| {
            let known = Surface::ALL.map(Surface::name);
            let found = Surface::from_name(&text);
            found.ok_or_else(|| wrong("surface", &text, &known))
        })
        .transpose()?;
    let known = WindowRole::ALL.map(WindowRole::name);
    let found = WindowRole::from_name(&role);
    let role = found.ok_or_else(|| wrong("role", &role, &known))?;
    let window = TimeRange::new(start_s, end_s);
    let mut manoeuvre = Manoeuvre { surface, kind, role, ..Manoeuvre::new(name, FLIGHT.to_owned(), window) };
    for (start_s, end_s) in excluded {
        if let Some(parts) = manoeuvre.excluded_with(TimeRange::new(start_s, end_s)) {
            manoeuvre.excluded = parts;
        }
    }
    Ok(manoeuvre)
}

impl Path {
    fn window(&self, index: usize) -> PyResult<&PathWindow> {
        self.inner.windows.get(index).ok_or_else(|| refuse("manoeuvre not found"))
    }
}

#[pymethods]
impl Path {
    /// Reconstructs the flight path of each window; `settings` are the tables `filter`, `preparation`, `aircraft_changes`, `loading` and
    /// `sensor_errors` of a session as JSON.
    #[staticmethod]
    fn reconstruct(
        py: Python<'_>,
        recording: &Recording,
        aircraft: Option<&Aircraft>,
        windows: Vec<WindowGiven>,
        settings: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut session = session_with(settings)?;
        let windows = windows.into_iter().map(window).collect::<PyResult<Vec<_>>>()?;
        let aircraft = aircraft.map(|aircraft| aircraft.in_session(&session)).transpose()?;
        let flight = Arc::clone(&recording.flight);
        warn_of_memory(py, &flight.loaded, &windows)?;
        let work = move |control: &Control, show: Show<'_>| -> Result<Reconstructed, StageError> {
            let Session { flights, .. } = session_of(windows.clone());
            session = Session { flights, windows: windows.clone(), ..session };
            let gravity = gravity(&session, |_| Some(&flight.loaded.recording));
            session.filter.gravity_m_s2 = gravity.m_s2;
            let (found, windows) = reconstructed(&flight.loaded, aircraft.as_deref(), &session, windows, control)?;
            show(1.0);
            let filter = found.added_to(&session.filter);
            let Session { filter: settings, gravity: source, gusts, delays, aircraft_changes, .. } = session;
            let Session { preparation, loading, sensor_errors, .. } = session;
            let stated =
                Stated { filter: settings, gravity: source, gusts, delays, aircraft_changes, loading, sensor_errors };
            Ok(Reconstructed { flight, aircraft, stated, found, filter, gravity, preparation, windows })
        };
        Ok(Self { inner: Arc::new(attend(py, "reconstruct", progress, work)?) })
    }

    /// The session of the same manoeuvres and settings, without its recordings: JSON.
    fn session(&self) -> PyResult<String> {
        let windows = self.inner.windows.iter().map(|window| (&window.manoeuvre, &*self.inner));
        session_json(&session_of_arrays(&windows.collect::<Vec<_>>(), &self.inner.preparation, None))
    }

    /// Verdict of the paths as JSON: that of a session of the same windows.
    fn verdict(&self, py: Python<'_>) -> PyResult<String> {
        judged::of_path(py, &self.inner)
    }

    /// What the innovations estimated: kind, measurements or states, value, standard error of a delay, whether the filter uses it.
    #[expect(clippy::type_complexity, reason = "one row per estimate")]
    fn estimated(&self) -> Vec<(&'static str, Vec<&'static str>, f64, Option<f64>, bool)> {
        let DelaysAndGusts { delays, gusts } = &self.inner.found;
        let delays = delays.iter().flat_map(|found| &found.0).map(|found| {
            let names = found.kind.measurements().iter().map(|measurement| measurement.name()).collect();
            ("delay", names, found.delay_s, Some(found.standard_error_s), found.is_significant())
        });
        let walks = gusts.iter().flat_map(|found| {
            let names = [vec![State::WindNorth.name(), State::WindEast.name()], vec![State::WindDown.name()]];
            names
                .into_iter()
                .zip(found.walk)
                .map(|(names, walk)| ("random walk", names, walk, None, found.is_significant()))
        });
        delays.chain(walks).collect()
    }

    /// Gravity in use, m/s².
    #[getter]
    fn gravity(&self) -> f64 {
        self.inner.gravity.m_s2
    }

    /// Name, start and end (s), surface, kind, role and excluded parts (s) of each window.
    #[allow(clippy::type_complexity, reason = "one row per manoeuvre")]
    fn windows(&self) -> Vec<(&str, f64, f64, Option<&'static str>, &str, &'static str, Vec<(f64, f64)>)> {
        let windows = self.inner.windows.iter().map(|window| &window.manoeuvre);
        windows
            .map(|one| {
                let surface = one.surface.map(Surface::name);
                let excluded = one.excluded.iter().map(|part| (part.start_s, part.end_s)).collect();
                (&*one.name, one.window.start_s, one.window.end_s, surface, &*one.kind, one.role.name(), excluded)
            })
            .collect()
    }

    /// Times, s, of the states of a window and of its innovations.
    fn times<'py>(&self, py: Python<'py>, index: usize) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let series = self.window(index)?.path.series();
        Ok([shared(py, &series.states[0].time_s)?, shared(py, &series.nis.time_s)?])
    }

    /// States of a window: `filtered` or `smoothed`, each by name with its standard deviation.
    fn states<'py>(&self, py: Python<'py>, index: usize, which: &str) -> PyResult<Bound<'py, PyDict>> {
        let series = self.window(index)?.path.series();
        let (states, deviations) = match (which, &series.smoothed) {
            ("filtered", _) => (&series.states, &series.deviations),
            ("smoothed", Some(smoothed)) => (&smoothed.states, &smoothed.deviations),
            _ => return Err(refuse("the path was not smoothed: reconstruct with smooth=True")),
        };
        let all = PyDict::new(py);
        for state in State::ALL {
            let at = state as usize;
            let pair = (shared(py, &states[at].values)?, shared(py, &deviations[at])?);
            all.set_item(state.name(), pair)?;
        }
        Ok(all)
    }

    /// Innovations of a window by measurement, each with its predicted standard deviation; not a number where nothing was measured.
    fn innovations<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let path = &self.window(index)?.path.reconstruction;
        let all = PyDict::new(py);
        for measurement in Measurement::ALL {
            let at = measurement as usize;
            if path.innovations[at].iter().any(|value| value.is_finite()) {
                let columns = [path.innovations[at].clone(), path.innovation_deviations[at].to_vec()];
                all.set_item(measurement.name(), columns.map(|column| owned(py, column)))?;
            }
        }
        Ok(all)
    }

    /// Measurements of a window by name, each with predictions and reconstructed values.
    fn measurements<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        measurements(py, &self.window(index)?.path, &self.inner.filter.measurement_delay_s)
    }

    /// Normalised innovations squared of a window, and how many measurements each counts.
    fn nis<'py>(&self, py: Python<'py>, index: usize) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let path = &self.window(index)?.path;
        let degrees = path.reconstruction.nis_degrees.iter().map(|&degrees| f64::from(degrees)).collect();
        Ok([shared(py, &path.series().nis.values)?, owned(py, degrees)])
    }

    /// Covariance of the last filtered states of a window.
    fn final_covariance<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let covariance = &self.window(index)?.path.reconstruction.final_covariance;
        Ok(matrix(py, &DMatrix::from_fn(STATES, STATES, |i, j| covariance[(i, j)])))
    }

    /// Logarithm of the likelihood of the measurements of a window.
    fn log_likelihood(&self, index: usize) -> PyResult<f64> {
        Ok(self.window(index)?.path.reconstruction.log_likelihood)
    }

    /// Findings of a window.
    fn warnings(&self, index: usize) -> PyResult<Vec<String>> {
        Ok(self.window(index)?.path.assessment().warnings.iter().map(ToString::to_string).collect())
    }

    /// SI units of the states by name.
    #[staticmethod]
    fn units<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let unit = |dimension: Dimension| dimension.si_symbol();
        State::ALL.into_iter().try_for_each(|state| all.set_item(state.name(), unit(state.dimension())))?;
        Ok(all)
    }
}

/// Warns of windows that need more memory than is available, before it is taken.
fn warn_of_memory(py: Python<'_>, flight: &LoadedFlight, windows: &[Manoeuvre]) -> PyResult<()> {
    let Some(inertial) = flight.recording.role(Role::SpecificForceZ) else { return Ok(()) };
    let samples = windows.iter().map(|one| (&*one.name, one.window.indices(&inertial.series.time_s).len()));
    memory_finding(samples).map_or(Ok(()), |finding| warn(py, &finding))
}

/// What the innovations of the windows estimate where `session` asks for it, and the path of each window; the first that has none ends
/// the work.
fn reconstructed(
    flight: &Keyed<LoadedFlight>,
    aircraft: Option<&AircraftData>,
    session: &Session,
    windows: Vec<Manoeuvre>,
    control: &Control,
) -> Result<(DelaysAndGusts, Vec<PathWindow>), StageError> {
    let preparation = &session.preparation;
    if windows.len() > MOST_WINDOWS {
        return Err(format!("{} manoeuvres are too many: give at most {MOST_WINDOWS} at a time", windows.len()).into());
    }
    // What they take is known before they are taken: without memory Python itself would end.
    if let Some(inertial) = flight.recording.role(Role::SpecificForceZ) {
        fit_in_memory(windows.iter().map(|window| window.window.indices(&inertial.series.time_s).len()).sum())?;
    }
    let taken = windows.iter().map(|window| samples(&flight.recording, window.samples(), aircraft, preparation));
    let taken = taken
        .zip(&windows)
        .map(|(found, window)| found.map_err(|error| error.at(format!("manoeuvre '{}'", window.name))));
    let taken: Vec<Samples> = taken.collect::<Result<_, _>>()?;
    let data: Vec<_> = taken.iter().map(|samples| &*samples.data).collect();
    let estimated = estimate_delays_and_gusts(session, &data, control)?;
    let filter = estimated.added_to(&session.filter);
    let settings = (&filter, preparation.path);
    let found = paths(&taken.iter().collect::<Vec<_>>(), settings, control);
    let windows = windows
        .into_iter()
        .zip(found)
        .zip(&taken)
        .map(|((manoeuvre, path), samples)| {
            let path = path.map_err(|error| error.at(format!("manoeuvre '{}'", manoeuvre.name)))?;
            let key: Key = KeyBuilder::new("path").with(&samples.content).with(&settings).finish();
            Ok(PathWindow { manoeuvre, path: Keyed::new(Arc::new(path), key) })
        })
        .collect::<Result<_, StageError>>()?;
    Ok((estimated, windows))
}
