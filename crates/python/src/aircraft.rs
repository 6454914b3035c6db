//! Aircraft: by name, from a file, or from their numbers.

use std::path::Path;
use std::sync::Arc;

use doublet_core::airframe::LoadingIssue;
use doublet_core::prep::did_you_mean;
use doublet_engine::begin::PlainAircraft;
use doublet_engine::builtin;
use doublet_engine::graph::{Context, Key, Keyed};
use doublet_engine::session::{AircraftChanges, Session};
use doublet_engine::stage::{AircraftData, LoadedAircraft, aircraft_data, aircraft_of, load_aircraft, parse_aircraft};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{pooled, refuse};

/// Where an aircraft comes from.
enum Source {
    /// What a session calls it.
    Reference(String),
    /// Text of the file of one that was described by its numbers.
    Text(String),
}

/// An aircraft with its standard loading.
#[pyclass(frozen, module = "doublet")]
pub struct Aircraft {
    source: Source,
    data: Keyed<AircraftData>,
}

impl Aircraft {
    fn from_loaded(loaded: &Arc<LoadedAircraft>, source: Source) -> Self {
        let data = aircraft_data(Arc::clone(loaded), None);
        Self { source, data: Keyed::new(Arc::new(data), Key::unique()) }
    }

    /// The aircraft with the changes and the loading of a session.
    pub fn in_session(&self, session: &Session) -> PyResult<Keyed<AircraftData>> {
        let Session { aircraft_changes: changes, loading, .. } = session;
        if changes.is_empty() && loading.is_none() {
            return Ok(self.data.clone());
        }
        let loaded = match &self.source {
            _ if changes.is_empty() => Arc::clone(&self.data.loaded),
            Source::Text(text) => {
                Arc::new(parse_aircraft(&self.data.loaded.aircraft.name, text, changes).map_err(refuse)?)
            }
            Source::Reference(reference) => {
                let folder = std::env::current_dir()?;
                let session = Session { aircraft: Some(reference.clone()), ..session.clone() };
                let loaded = pooled(|| aircraft_of(&Context::new(&folder), &session)).map_err(refuse)?;
                Arc::clone(loaded.shared())
            }
        };
        let data = aircraft_data(loaded, loading.as_ref());
        refuse_unusable(&data)?;
        Ok(Keyed::new(Arc::new(data), Key::unique()))
    }
}

/// Refuses a loading with a mass that is not one, or in a place that the aircraft does not have.
fn refuse_unusable(data: &AircraftData) -> PyResult<()> {
    let aircraft = &data.loaded.aircraft;
    for issue in data.loading.issues(aircraft, &data.mass) {
        match &issue {
            LoadingIssue::UnknownPlace { field } => {
                let name = field.split_once('.').map_or("", |(_, name)| name);
                let tanks = aircraft.tanks.iter().map(|tank| &*tank.name);
                let stations = aircraft.seats.iter().chain(&aircraft.luggage).map(|station| &*station.name);
                let known: Vec<&str> = tanks.chain(stations).collect();
                let otherwise = format!("use one of {}", known.join(", "));
                let hint = did_you_mean(name, known.iter().copied(), &otherwise);
                return Err(refuse(format!("loading.{field}: the aircraft has no such place: {hint}")));
            }
            LoadingIssue::NotAMass { field, mass_kg } => {
                return Err(refuse(format!("loading.{field} is {mass_kg} kg: give 0 or more")));
            }
            _ => {}
        }
    }
    Ok(())
}

#[pymethods]
impl Aircraft {
    /// One that comes with doublet, by its name, or that of a file.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Self> {
        let reference = match builtin::text("aircraft", name) {
            Some(_) => format!("{}{name}", builtin::PREFIX),
            None if Path::new(name).exists() => name.to_owned(),
            None => {
                let known = builtin::aircraft().join(", ");
                return Err(refuse(format!("no aircraft '{name}': give a file, or one of {known}")));
            }
        };
        let folder = std::env::current_dir()?;
        let loaded = pooled(|| load_aircraft(&Context::new(&folder), &reference)).map_err(refuse)?;
        Ok(Self::from_loaded(loaded.shared(), Source::Reference(reference)))
    }

    /// One described by its numbers, SI; moments of inertia `Ixx, Iyy, Izz`, product `Ixz`.
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "an aircraft in its fewest numbers")]
    fn plain(name: String, area: f64, span: f64, chord: f64, mass: f64, moments: [f64; 3], xz: f64) -> PyResult<Self> {
        let plain = PlainAircraft {
            name,
            area_m2: area,
            span_m: span,
            chord_m: chord,
            mass_kg: mass,
            moments_kg_m2: moments,
            xz_kg_m2: xz,
            note: None,
        };
        let text = plain.text().map_err(refuse)?;
        let loaded = parse_aircraft(&plain.name, &text, &AircraftChanges::default()).map_err(refuse)?;
        Ok(Self::from_loaded(&Arc::new(loaded), Source::Text(text)))
    }

    /// What a session calls it.
    #[getter]
    fn reference(&self) -> Option<&str> {
        if let Source::Reference(reference) = &self.source { Some(reference) } else { None }
    }

    /// Text of an aircraft file, where it was described by its numbers.
    #[getter]
    fn text(&self) -> Option<&str> {
        if let Source::Text(text) = &self.source { Some(text) } else { None }
    }

    /// Name, lengths, mass properties of the standard loading.
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let aircraft = &self.data.loaded.aircraft;
        let (reference, mass) = (&aircraft.reference, &self.data.mass);
        let all = PyDict::new(py);
        all.set_item("name", &aircraft.name)?;
        all.set_item("area", reference.area_m2)?;
        all.set_item("span", reference.span_m)?;
        all.set_item("chord", reference.chord_m)?;
        all.set_item("mass", mass.mass_kg)?;
        all.set_item("centre_of_gravity", mass.cg_from_datum_m)?;
        all.set_item("inertia", [mass.inertia.xx, mass.inertia.yy, mass.inertia.zz, mass.inertia.xz])?;
        Ok(all)
    }
}
