//! Aircraft: by name, from a file, or from their numbers.

use std::path::Path;
use std::sync::Arc;

use doublet_engine::begin::PlainAircraft;
use doublet_engine::builtin;
use doublet_engine::graph::{Context, Key, Keyed};
use doublet_engine::stage::{AircraftData, LoadedAircraft, aircraft_data, load_aircraft};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{pooled, refuse};

/// An aircraft with its standard loading.
#[pyclass(frozen, module = "doublet")]
pub struct Aircraft {
    /// What a session calls it; `None` where it was described by its numbers.
    reference: Option<String>,
    /// Text of its file, where it was described by its numbers.
    text: Option<String>,
    pub(crate) data: Keyed<AircraftData>,
}

impl Aircraft {
    fn from_loaded(loaded: &Arc<LoadedAircraft>, reference: Option<String>, text: Option<String>) -> Self {
        let data = aircraft_data(Arc::clone(loaded), None);
        Self { reference, text, data: Keyed::new(Arc::new(data), Key::unique()) }
    }
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
        Ok(Self::from_loaded(loaded.shared(), Some(reference), None))
    }

    /// One described by its numbers, SI; moments of inertia `Ixx, Iyy, Izz`, product `Ixz`.
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "an aircraft in its fewest numbers")]
    fn plain(
        name: String,
        area: f64,
        span: f64,
        chord: f64,
        mass: f64,
        moments: [f64; 3],
        xz: f64,
        folder: &str,
    ) -> PyResult<Self> {
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
        let path = Path::new(folder).join("aircraft.toml");
        std::fs::write(&path, &text)?;
        let loaded = load_aircraft(&Context::new(Path::new(folder)), &path.display().to_string()).map_err(refuse)?;
        Ok(Self::from_loaded(loaded.shared(), None, Some(text)))
    }

    /// What a session calls it.
    #[getter]
    fn reference(&self) -> Option<&str> {
        self.reference.as_deref()
    }

    /// Text of an aircraft file, where it was described by its numbers.
    #[getter]
    fn text(&self) -> Option<&str> {
        self.text.as_deref()
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
