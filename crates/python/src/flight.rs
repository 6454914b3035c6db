//! Simulated flights whose every answer is known.

use std::path::{Path, PathBuf};

use doublet_core::simulate::{self as simulation, Scenario, scenario};
use doublet_engine::graph::Control;
use doublet_engine::keep::Staging;
use pyo3::prelude::*;

use crate::attend::{Show, attend, refuse};

/// Flies a scenario and writes what its recorders hold into a new folder; returns the files.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    name: &str,
    folder: PathBuf,
    seed: u64,
    derivatives: Vec<(String, f64)>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<PathBuf>> {
    if folder.exists() {
        return Err(refuse(format!("{} exists: choose another folder", folder.display())));
    }
    let mut scenario = scenario::build(name).map_err(refuse)?;
    for (name, value) in derivatives {
        scenario.vehicle.aero = scenario.vehicle.aero.with_derivative(&name, value).map_err(refuse)?;
    }
    attend(py, "simulate", progress, move |control: &Control, show: Show<'_>| {
        fly_into(&folder, &scenario, seed, control, show)
    })
}

fn fly_into(
    folder: &Path,
    scenario: &Scenario,
    seed: u64,
    control: &Control,
    show: Show<'_>,
) -> Result<Vec<PathBuf>, String> {
    let flown = simulation::run(scenario, seed, &mut |part| {
        #[expect(clippy::cast_possible_truncation, reason = "a part of one")]
        show(part as f32);
        !control.is_cancelled()
    });
    let files = flown.and_then(|flight| flight.files()).map_err(|error| error.to_string())?;
    let staging = Staging::new(folder).map_err(|error| error.to_string())?;
    for file in &files {
        let place = staging.path().join(&file.path);
        let put = place.parent().map_or(Ok(()), std::fs::create_dir_all);
        put.and_then(|()| std::fs::write(&place, &file.bytes))
            .map_err(|error| format!("{}: {error}", place.display()))?;
    }
    staging.put_new().map_err(|error| error.to_string())?;
    Ok(files.iter().map(|file| folder.join(&file.path)).collect())
}
