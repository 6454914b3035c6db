//! Recordings: read from files or made of arrays.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use doublet_core::load::{ChannelMap, plan_all, read};
use doublet_core::message::Message;
use doublet_core::quantity::{Role, Unit};
use doublet_core::series::{Channel, Recording as Samples, Series};
use doublet_engine::confidence::{WeighedRole, weigh};
use doublet_engine::graph::{Control, Keyed, StageError};
use doublet_engine::stage::{FlightPhysics, LoadedFlight, physics_of, proposals};
use doublet_engine::{begin, builtin};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::attend::{Show, attend, detached, refuse};
use crate::columns::{shared, slice};

/// Roles a channel may play: name, SI unit, description.
#[pyfunction]
pub fn roles() -> Vec<(&'static str, &'static str, &'static str)> {
    Role::ALL.into_iter().map(|role| (role.name(), role.dimension().si_symbol(), role.description())).collect()
}

/// Symbols of the units that are understood, with the SI unit of their dimension.
#[pyfunction]
pub fn units() -> Vec<(&'static str, &'static str)> {
    Unit::all().map(|unit| (unit.symbol, unit.dimension.si_symbol())).collect()
}

/// Role, channel, unit, sign, confidence, evidence, runner-up and the reason against it.
type GuessedRole = (&'static str, String, Option<&'static str>, f64, f64, String, Option<String>, Option<String>);

/// What the channels of files of one flight look like, role by role.
#[pyfunction]
pub fn guess_roles(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Vec<GuessedRole>> {
    detached(py, "guess", || {
        let begin::Inspected { probes, guess, .. } = begin::inspect(&paths, &Control::default(), &|_| {})?;
        let compared = begin::plan_by_hand(&probes, &guess).and_then(|plan| begin::compare(&plan)).ok();
        let weighed = weigh(&probes, &guess, compared.as_ref());
        let row = |weighed: WeighedRole| {
            let row = guess.row(weighed.role)?;
            let (other, reason) = weighed.runner_up.map(|other| (other.from.channel, other.reason)).unzip();
            let (unit, sign) = (row.unit.map(|unit| unit.symbol), if row.turned { -1.0 } else { 1.0 });
            let channel = row.from.channel.clone();
            Some((weighed.role.name(), channel, unit, sign, weighed.confidence, weighed.evidence, other, reason))
        };
        Ok::<_, String>(weighed.into_iter().filter_map(row).collect())
    })
}

/// A flight and the comparison of its channels, formed at most once.
pub struct RecordedFlight {
    pub loaded: Keyed<LoadedFlight>,
    /// The channel map it was read by.
    map: Option<String>,
    physics: OnceLock<Keyed<FlightPhysics>>,
}

impl RecordedFlight {
    /// Channels against each other.
    pub fn physics(&self) -> &Keyed<FlightPhysics> {
        let map = self.map.as_deref().unwrap_or_default();
        self.physics.get_or_init(|| physics_of(&self.loaded.recording, map).into())
    }
}

/// What was recorded in one flight.
#[pyclass(frozen, module = "doublet")]
pub struct Recording {
    pub(crate) flight: Arc<RecordedFlight>,
}

impl Recording {
    fn from_samples(recording: Samples, map: Option<String>) -> Self {
        let flight = LoadedFlight { recording, ..LoadedFlight::default() };
        Self::new(flight.into(), map)
    }

    fn new(loaded: Keyed<LoadedFlight>, map: Option<String>) -> Self {
        Self { flight: Arc::new(RecordedFlight { loaded, map, physics: OnceLock::new() }) }
    }

    /// What a run read of a flight: clocks, instruments and signals treated as its session asks.
    pub(crate) fn of_flight(flight: Keyed<LoadedFlight>) -> Self {
        Self::new(flight, None)
    }

    fn samples(&self) -> &Samples {
        &self.flight.loaded.recording
    }
}

/// A channel as it is pickled: source, name, unit, role, time (s) and values.
type KeptChannel<'py> =
    (String, String, String, Option<String>, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// Reads files of one flight by a channel map: a file, one that comes with doublet, or that which fits best, or else a guess.
fn read_files(paths: &[PathBuf], map: Option<&str>) -> Result<(Samples, String), String> {
    let inspected = begin::inspect(paths, &Control::default(), &|_| {})?;
    let (name, plan) = match map {
        Some(name) => {
            let found = match builtin::text("channel_maps", name) {
                Some(text) => ChannelMap::parse(text),
                None => ChannelMap::read(&PathBuf::from(name)),
            };
            (name.to_owned(), plan_all(&inspected.probes, &found.map_err(|error| error.to_string())?))
        }
        None => match inspected.fitting.first() {
            Some(fitting) => (fitting.name.to_owned(), fitting.plan.clone()),
            None => ("guessed".to_owned(), begin::plan_by_hand(&inspected.probes, &inspected.guess)?),
        },
    };
    Ok((read(&plan).map_err(|error| error.to_string())?, name))
}

#[pymethods]
impl Recording {
    /// Reads files of one flight.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        paths: Vec<PathBuf>,
        channel_map: Option<String>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let work = move |_: &Control, _: Show<'_>| read_files(&paths, channel_map.as_deref());
        let (recording, map) = attend(py, "read", progress, work)?;
        Ok(Self::from_samples(recording, Some(map)))
    }

    /// A recording of channels: name, time (s), values, unit. A name of a role plays it and its values are converted to SI; others
    /// stay as they are.
    #[staticmethod]
    fn from_arrays<'py>(
        channels: Vec<(String, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, String)>,
        source: &str,
    ) -> PyResult<Self> {
        let mut recording = Samples::default();
        let mut last: Option<Arc<[f64]>> = None;
        let mut seen = BTreeSet::new();
        for (name, time, values, unit) in channels {
            if !seen.insert(name.clone()) {
                return Err(refuse(format!("there are two channels called '{name}': give each its own name")));
            }
            let time = slice("time", &time)?;
            let time_s = match &last {
                Some(known) if **known == *time => Arc::clone(known),
                _ => check_time(&name, time)?,
            };
            last = Some(Arc::clone(&time_s));
            let values = slice(&name, &values)?;
            if values.len() != time_s.len() {
                let (found, expected) = (values.len(), time_s.len());
                return Err(refuse(format!(
                    "'{name}' has {found} values and its time {expected}: they are not of one table"
                )));
            }
            let role = Role::from_name(&name);
            let (values, unit) = match role {
                Some(role) => (in_si(&name, role, values, &unit)?, role.dimension().si_symbol().to_owned()),
                None => (values.into(), unit),
            };
            if let Some(role) = role {
                recording.roles.insert(role, recording.channels.len());
            }
            let series = Series { time_s, values };
            recording.channels.push(Channel { source: source.to_owned(), name, unit, series });
        }
        Ok(Self::from_samples(recording, None))
    }

    /// A recording of channels as another one holds them: values in SI, roles as they were.
    #[staticmethod]
    fn restore(channels: Vec<KeptChannel<'_>>, warnings: Vec<String>, map: Option<String>) -> PyResult<Self> {
        let warnings = warnings.into_iter().map(Message::from).collect();
        let mut recording = Samples { warnings, ..Samples::default() };
        let mut last: Option<Arc<[f64]>> = None;
        for (source, name, unit, role, time, values) in channels {
            let time = slice("time", &time)?;
            let time_s = last.filter(|known| **known == *time).unwrap_or_else(|| time.into());
            last = Some(Arc::clone(&time_s));
            if let Some(role) = role {
                let role = Role::from_name(&role).ok_or_else(|| refuse(format!("'{role}' is not a role")))?;
                recording.roles.insert(role, recording.channels.len());
            }
            let series = Series { time_s, values: slice(&name, &values)?.into() };
            recording.channels.push(Channel { source, name, unit, series });
        }
        Ok(Self::from_samples(recording, map))
    }

    /// The channel map it was read by.
    #[getter]
    fn channel_map(&self) -> Option<&str> {
        self.flight.map.as_deref()
    }

    /// Source, name, unit, role and samples of each channel.
    fn channels(&self) -> Vec<(&str, &str, &str, Option<&'static str>, usize)> {
        let recording = self.samples();
        let role = |index: usize| recording.roles.iter().find(|(_, at)| **at == index).map(|(role, _)| role.name());
        let all = recording.channels.iter().enumerate();
        all.map(|(index, channel)| {
            (&*channel.source, &*channel.name, &*channel.unit, role(index), channel.series.values.len())
        })
        .collect()
    }

    /// Time, s, and values of the channel at `index`, looking at the recording's own memory.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn signal<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
        let channel = self.samples().channels.get(index).ok_or_else(|| refuse("channel not found"))?;
        Ok((shared(py, &channel.series.time_s)?, shared(py, &channel.series.values)?))
    }

    /// Findings about the quality of the data.
    fn warnings(&self) -> Vec<String> {
        self.samples().warnings.iter().map(ToString::to_string).collect()
    }

    /// Channels against each other: the rows of `physics` in `doublet check --json`, as JSON.
    fn physics(&self, py: Python<'_>) -> PyResult<String> {
        let found = detached(py, "channels against each other", || Ok::<_, StageError>(self.flight.physics().clone()))?;
        serde_json::to_string(&found.rows).map_err(refuse)
    }

    /// Manoeuvres of the controls: name, start and end (s), surface, kind, confidence; and why something was not found.
    #[allow(clippy::type_complexity, reason = "one row per manoeuvre")]
    fn manoeuvres(
        &self,
        py: Python<'_>,
    ) -> PyResult<(Vec<(String, f64, f64, Option<&'static str>, String, f64)>, Vec<String>)> {
        let found = detached(py, "manoeuvres", || Ok::<_, StageError>(proposals("flight", &self.flight.loaded)))?;
        let row = |proposal: &doublet_engine::stage::WindowProposal| {
            let window = &proposal.manoeuvre;
            let surface = window.surface.map(doublet_engine::session::Surface::name);
            let (start, end) = (window.window.start_s, window.window.end_s);
            (window.name.clone(), start, end, surface, window.kind.clone(), proposal.confidence)
        };
        Ok((found.windows.iter().map(row).collect(), found.findings))
    }
}

/// Time of a channel; it must increase.
fn check_time(name: &str, time: &[f64]) -> PyResult<Arc<[f64]>> {
    if time.len() < 2 {
        return Err(refuse(format!("'{name}' has {} samples: give at least two", time.len())));
    }
    // An instant that is not a number compares with nothing.
    match time.windows(2).position(|pair| pair[0].partial_cmp(&pair[1]) != Some(Ordering::Less)) {
        Some(at) => {
            let (first, second) = (time[at], time[at + 1]);
            Err(refuse(format!(
                "time of '{name}' does not increase at sample {}: {second} s follows {first} s",
                at + 1
            )))
        }
        None => Ok(time.into()),
    }
}

/// Values of a role in SI.
fn in_si(name: &str, role: Role, values: &[f64], unit: &str) -> PyResult<Arc<[f64]>> {
    let wanted = role.dimension();
    if unit.is_empty() {
        return Ok(values.into());
    }
    let unit = Unit::parse(unit).map_err(|error| refuse(format!("'{name}': {error}")))?;
    if unit.dimension != wanted {
        let (found, wanted) = (unit.symbol, wanted.si_symbol());
        return Err(refuse(format!(
            "'{name}' is in {found}, its role is one of {wanted}: give a unit that can become {wanted}"
        )));
    }
    if unit == Unit::si(wanted) {
        return Ok(values.into());
    }
    Ok(values.iter().map(|&value| unit.to_si(value)).collect())
}
