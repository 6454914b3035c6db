//! Time histories of every window and of the engines over every flight as HDF5, every data set with its unit.

use std::path::Path;

use doublet_core::model::{Coefficient, Variable};
use doublet_core::reconstruct::{INPUTS, Input, Measurement, State};
use doublet_core::validate::Signal;
use hdf5_writer::{AttributeBuilder, DatasetBuilder, Hdf5Builder, Hdf5Writer, WriteOptions};

use super::{ReportError, file_error};
use crate::run::{Snapshot, WindowResults};
use crate::session::Session;
use crate::stage::{FlightEngines, WindowAero, WindowPath, WindowReplay};

/// Collects data sets and keeps the first thing that goes wrong.
struct Writer {
    builder: Hdf5Builder,
    failure: Option<String>,
}

impl Writer {
    fn put(&mut self, path: String, unit: &str, description: &str, values: &[f64]) {
        let data_set = DatasetBuilder::typed_data(path.clone(), vec![values.len() as u64], values);
        match data_set {
            Ok(data_set) => {
                let data_set = data_set.attribute(AttributeBuilder::fixed_string("units", unit));
                let data_set = data_set.attribute(AttributeBuilder::fixed_string("description", description));
                self.builder = std::mem::take(&mut self.builder).dataset(data_set);
            }
            Err(error) => {
                self.failure.get_or_insert_with(|| format!("{path}: {error}"));
            }
        }
    }
}

/// Writes the histories of all windows that have any.
pub fn write(session: &Session, snapshot: &Snapshot, path: &Path) -> Result<(), ReportError> {
    let mut writer = Writer { builder: Hdf5Builder::new(), failure: None };
    writer.builder = std::mem::take(&mut writer.builder)
        .attribute(AttributeBuilder::fixed_string("title", if session.title.is_empty() { "-" } else { &session.title }))
        .attribute(AttributeBuilder::fixed_string("app", concat!("doublet ", env!("CARGO_PKG_VERSION"))));
    for window in &session.windows {
        if let Some(results) = snapshot.windows.get(&window.name) {
            put_window(&mut writer, &window.name.replace('/', "_"), results);
        }
    }
    if let Some(study) = snapshot.studies.manoeuvres.ready() {
        for window in &study.contributions {
            for term in &window.terms {
                let path = format!("{}/contributions/{}", window.window.replace('/', "_"), term.derivative);
                writer.put(path, "-", "derivative times variable, by the pooled estimate", &term.series.values);
            }
        }
    }
    for (window, replay) in snapshot.proof.ready().iter().flat_map(|proof| &proof.windows) {
        if let Ok(replay) = replay {
            put_replay(&mut writer, &window.replace('/', "_"), replay);
        }
    }
    if let Some(study) = snapshot.studies.checks.ready() {
        for window in &study.windows {
            for flight in window.output_error.iter().filter_map(|(_, flight)| flight.as_ref().ok()) {
                for output in &flight.outputs {
                    let group = window.window.replace('/', "_");
                    let path = format!("{group}/output_error/{}", output.output.name());
                    writer.put(path, "SI", "flown by the output-error estimate", &output.flown.values);
                }
            }
        }
    }
    for flight in &session.flights {
        if let Some(engines) = snapshot.engines.get(&flight.name).and_then(|slot| slot.ready()) {
            put_engines(&mut writer, &format!("flights/{}/engines", flight.name.replace('/', "_")), engines);
        }
    }
    if let Some(reason) = writer.failure {
        return Err(ReportError::Form { what: "histories.h5", reason });
    }
    let formed = |error: hdf5_writer::Error| ReportError::Form { what: "histories.h5", reason: error.to_string() };
    let plan = writer.builder.into_plan().map_err(formed)?;
    let file = std::fs::File::create(path).map_err(file_error(path))?;
    Hdf5Writer::new(std::io::BufWriter::new(file), WriteOptions::default()).finish(plan).map_err(formed)?;
    Ok(())
}

fn put_window(writer: &mut Writer, group: &str, results: &WindowResults) {
    if let Some(path) = results.path.ready() {
        put_path(writer, group, path);
    }
    if let Some(aero) = results.aero.ready() {
        put_aero(writer, group, aero);
        for fit in results.fits.ready().iter().flat_map(|fits| &fits.fits) {
            if let Ok(estimate) = &fit.fit {
                let name = fit.coefficient.name();
                writer.put(format!("{group}/fits/{name}"), "-", "fit of this window alone", &estimate.fitted);
            }
        }
    }
}

fn put_path(writer: &mut Writer, group: &str, path: &WindowPath) {
    let reconstruction = &path.reconstruction;
    let at = |folder: &str, name: &str| format!("{group}/path/{folder}{name}");
    writer.put(at("", "time"), "s", "time of the inertial samples", &reconstruction.time_s);
    for index in 0..INPUTS {
        let input = Input::ALL[index];
        let unit = input.dimension().si_symbol();
        writer.put(at("inputs/", input.name()), unit, input.description(), &path.data.inputs.columns[index]);
    }
    for state in State::ALL {
        let (index, unit) = (state as usize, state.dimension().si_symbol());
        writer.put(at("states/", state.name()), unit, state.description(), &reconstruction.states[index]);
        let deviations = &reconstruction.deviations[index];
        writer.put(at("deviations/", state.name()), unit, "standard deviation of the state", deviations);
        if let Some(smoothed) = &reconstruction.smoothed {
            writer.put(at("smoothed/", state.name()), unit, "smoothed state", &smoothed.states[index]);
        }
    }
    for measurement in Measurement::ALL {
        let (index, unit) = (measurement as usize, measurement.dimension().si_symbol());
        let series = &path.data.measurements[index];
        if series.time_s.is_empty() {
            continue;
        }
        let name = measurement.name();
        writer.put(at("measured/", &format!("{name}/time")), "s", "time of the measurement", &series.time_s);
        writer.put(at("measured/", &format!("{name}/value")), unit, measurement.description(), &series.values);
        let innovations = &reconstruction.innovations[index];
        writer.put(at("innovations/", name), unit, "measurement minus prediction", innovations);
        let deviations = &reconstruction.innovation_deviations[index];
        writer.put(at("innovation_deviations/", name), unit, "predicted standard deviation", deviations);
    }
    writer.put(at("", "update_time"), "s", "time of innovations and NIS", &reconstruction.update_time_s);
    writer.put(at("", "nis"), "-", "normalised innovation squared", &reconstruction.nis);
}

fn put_aero(writer: &mut Writer, group: &str, aero: &WindowAero) {
    let at = |folder: &str, name: &str| format!("{group}/aero/{folder}{name}");
    writer.put(at("", "time"), "s", "time of the coefficients", &aero.coefficients.time_s);
    for coefficient in Coefficient::ALL {
        let name = coefficient.name();
        writer.put(at("coefficients/", name), "-", "observed coefficient", aero.coefficients.get(coefficient));
    }
    for &variable in Variable::ALL {
        if let Some(column) = aero.variables.get(variable) {
            let name = variable.name().replace('/', "_over_");
            writer.put(at("variables/", &name), "SI", variable.description(), column);
        }
    }
    writer.put(at("", "air_density"), "kg/m^3", "air density", &aero.data.density_kg_m3[aero.variables.rows()]);
}

fn put_replay(writer: &mut Writer, group: &str, replay: &WindowReplay) {
    let at = |name: &str| format!("{group}/match/{name}");
    writer.put(at("time"), "s", "time of the replay", &replay.measured.time_s);
    let bands = crate::stage::bands(&replay.tests);
    for signal in Signal::ALL {
        let (name, unit) = (signal.name(), signal.dimension().si_symbol());
        writer.put(at(&format!("measured/{name}")), unit, signal.description(), replay.measured.get(signal));
        writer.put(at(&format!("simulated/{name}")), unit, signal.description(), replay.simulated.get(signal));
        if let Some(band) = bands.get(&signal) {
            writer.put(at(&format!("tolerance/{name}")), unit, "half width of the tolerance band", band);
        }
    }
}

fn put_engines(writer: &mut Writer, group: &str, found: &FlightEngines) {
    for engine in &found.engines {
        let at = |name: &str| format!("{group}/{}/{name}", engine.name.replace('/', "_"));
        writer.put(at("time"), "s", "time, every 0.5 s", &engine.power_w.time_s);
        let monitor = engine.monitor_power_w.as_ref();
        let columns = [
            ("speed", "rad/s", "speed of the crankshaft", Some(&engine.speed_rad_s)),
            ("manifold_pressure", "Pa", "manifold pressure", Some(&engine.manifold_pressure_pa)),
            ("power", "W", "power of the engine chart", Some(&engine.power_w)),
            ("monitor_power", "W", "power its monitor reports", monitor),
            ("thrust", "N", "thrust of the propeller map", Some(&engine.thrust_n)),
            ("efficiency", "-", "efficiency of the propeller", Some(&engine.efficiency)),
            (
                "total_pressure_rise",
                "-",
                "total-pressure rise over dynamic pressure; not a number below 40 kt",
                Some(&engine.total_pressure_rise),
            ),
        ];
        for (name, unit, description, series) in columns {
            if let Some(series) = series {
                writer.put(at(name), unit, description, &series.values);
            }
        }
    }
}
