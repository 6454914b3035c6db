//! Step 1: flight paths of windows.

use std::sync::Arc;

use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::{FilterSettings, Measurement, State};
use doublet_core::series::TimeRange;
use doublet_engine::graph::{Control, Key, KeyBuilder, Keyed, StageError};
use doublet_engine::session::{
    GravitySource, MOST_WINDOWS, Manoeuvre, PathSource, Preparation, Session, Surface, WindowRole,
};
use doublet_engine::stage::{
    AircraftData, Gravity, LoadedFlight, Samples, WindowPath, fit_in_memory, gravity, paths, samples,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::aircraft::Aircraft;
use crate::attend::{Show, attend, refuse};
use crate::columns::{owned, shared};
use crate::filter::FilterGiven;
use crate::judged::{self, session_json, session_of, session_of_arrays};
use crate::recording::{RecordedFlight, Recording};

/// A window as Python gives it: name, start and end (s), surface, kind of input, role.
pub type WindowGiven = (String, f64, f64, Option<String>, String, String);

/// A window with its path.
#[derive(Clone)]
pub struct PathWindow {
    pub manoeuvre: Manoeuvre,
    pub path: Keyed<WindowPath>,
}

/// Everything a path was made from, and the path of each window.
pub struct Reconstructed {
    pub flight: Arc<RecordedFlight>,
    pub aircraft: Option<Keyed<AircraftData>>,
    pub filter: FilterSettings,
    pub gravity: Gravity,
    pub gravity_source: GravitySource,
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

fn window((name, start_s, end_s, surface, kind, role): WindowGiven) -> PyResult<Manoeuvre> {
    let wrong = |what: &str, found: &str, known: &[&str]| {
        refuse(format!("manoeuvre '{name}': '{found}' is not a {what}: use one of {}", known.join(", ")))
    };
    let surface = surface
        .map(|text| {
            let known = Surface::ALL.map(Surface::name);
            let found = Surface::ALL.into_iter().find(|surface| surface.name() == text);
            found.ok_or_else(|| wrong("surface", &text, &known))
        })
        .transpose()?;
    let known = WindowRole::ALL.map(WindowRole::name);
    let found = WindowRole::ALL.into_iter().find(|one| one.name() == role);
    let role = found.ok_or_else(|| wrong("role", &role, &known))?;
    let window = TimeRange::new(start_s, end_s);
    Ok(Manoeuvre { surface, kind, role, ..Manoeuvre::new(name, FLIGHT.to_owned(), window) })
}

impl Path {
    fn window(&self, index: usize) -> PyResult<&PathWindow> {
        self.inner.windows.get(index).ok_or_else(|| refuse("manoeuvre not found"))
    }
}

#[pymethods]
impl Path {
    /// Reconstructs the flight path of each window.
    #[staticmethod]
    fn reconstruct(
        py: Python<'_>,
        recording: &Recording,
        aircraft: Option<&Aircraft>,
        windows: Vec<WindowGiven>,
        settings: FilterGiven,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (mut filter, gravity_source) = settings.settings()?;
        let windows = windows.into_iter().map(window).collect::<PyResult<Vec<_>>>()?;
        let path = if settings.smooth { PathSource::Smoothed } else { PathSource::Filtered };
        let preparation = Preparation { path, ..Preparation::default() };
        let (flight, aircraft) = (Arc::clone(&recording.flight), aircraft.map(|aircraft| aircraft.data.clone()));
        let work = move |control: &Control, show: Show<'_>| -> Result<Reconstructed, StageError> {
            let session = Session { filter: filter.clone(), gravity: gravity_source, ..session_of(windows.clone()) };
            let gravity = gravity(&session, |_| Some(&flight.loaded.recording));
            filter.gravity_m_s2 = gravity.m_s2;
            let windows = reconstructed(&flight.loaded, aircraft.as_deref(), &filter, &preparation, windows, control)?;
            show(1.0);
            Ok(Reconstructed { flight, aircraft, filter, gravity, gravity_source, preparation, windows })
        };
        Ok(Self { inner: Arc::new(attend(py, "reconstruct", progress, work)?) })
    }

    /// The session of the same manoeuvres and settings, without its recordings: JSON.
    fn session(&self) -> PyResult<String> {
        let manoeuvres = self.inner.windows.iter().map(|window| window.manoeuvre.clone()).collect();
        session_json(&session_of_arrays(manoeuvres, &self.inner, &self.inner.preparation, None))
    }

    /// Verdict of the paths as JSON: that of a session of the same windows.
    fn verdict(&self, py: Python<'_>) -> PyResult<String> {
        judged::of_path(py, &self.inner)
    }

    /// Gravity in use, m/s².
    #[getter]
    fn gravity(&self) -> f64 {
        self.inner.gravity.m_s2
    }

    /// Name, start and end (s), surface, kind and role of each window.
    #[allow(clippy::type_complexity, reason = "one row per manoeuvre")]
    fn windows(&self) -> Vec<(&str, f64, f64, Option<&'static str>, &str, &'static str)> {
        let windows = self.inner.windows.iter().map(|window| &window.manoeuvre);
        windows
            .map(|one| {
                let surface = one.surface.map(Surface::name);
                (&*one.name, one.window.start_s, one.window.end_s, surface, &*one.kind, one.role.name())
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
                let columns = [&path.innovations[at], &path.innovation_deviations[at]];
                all.set_item(measurement.name(), columns.map(|column| owned(py, column.clone())))?;
            }
        }
        Ok(all)
    }

    /// Normalised innovations squared of a window, and how many measurements each counts.
    fn nis<'py>(&self, py: Python<'py>, index: usize) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let path = &self.window(index)?.path;
        let degrees = path.reconstruction.nis_degrees.iter().map(|&degrees| f64::from(degrees)).collect();
        Ok([shared(py, &path.series().nis.values)?, owned(py, degrees)])
    }

    /// Logarithm of the likelihood of the measurements of a window.
    fn log_likelihood(&self, index: usize) -> PyResult<f64> {
        Ok(self.window(index)?.path.reconstruction.log_likelihood)
    }

    /// Findings of a window.
    fn warnings(&self, index: usize) -> PyResult<Vec<String>> {
        Ok(self.window(index)?.path.assessment().warnings.clone())
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

/// The path of each window; the first that has none ends the work.
fn reconstructed(
    flight: &Keyed<LoadedFlight>,
    aircraft: Option<&AircraftData>,
    filter: &FilterSettings,
    preparation: &Preparation,
    windows: Vec<Manoeuvre>,
    control: &Control,
) -> Result<Vec<PathWindow>, StageError> {
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
    let found = paths(&taken.iter().collect::<Vec<_>>(), (filter, preparation.path), control);
    let settings = (filter, preparation.path);
    windows
        .into_iter()
        .zip(found)
        .zip(&taken)
        .map(|((manoeuvre, path), samples)| {
            let path = path.map_err(|error| error.at(format!("manoeuvre '{}'", manoeuvre.name)))?;
            let key: Key = KeyBuilder::new("path").with(&samples.content).with(&settings).finish();
            Ok(PathWindow { manoeuvre, path: Keyed::new(Arc::new(path), key) })
        })
        .collect()
}
