//! `doublet new`: a session for recordings.

use std::collections::BTreeSet;
use std::path::Path;

use doublet_core::load::{ChannelMap, Probe, inspect, plan_all};
use doublet_core::model::Structure;
use doublet_core::reconstruct::Measurement;
use doublet_engine::begin::{self, empty_session, fitting_maps, name_of, whole_window};
use doublet_engine::builtin;
use doublet_engine::session::{self, Flight, MapRef};

use crate::arguments::{NewArguments, StructureName};
use crate::text;

/// A channel map by file or by the name of one that comes with the program, with how a session refers to it.
///
/// # Errors
/// One line when there is none or it cannot be read.
pub fn channel_map(name: &str) -> Result<(String, ChannelMap), String> {
    if let Some(text) = builtin::text("channel_maps", name) {
        let map = ChannelMap::parse(text).map_err(|error| error.to_string())?;
        return Ok((format!("{}{name}", builtin::PREFIX), map));
    }
    let path = Path::new(name);
    if !path.exists() {
        let known = builtin::names("channel_maps").join(", ");
        return Err(format!("no channel map '{name}': give a file, or one of {known}"));
    }
    let map = ChannelMap::read(path).map_err(|error| error.to_string())?;
    Ok((absolute(path)?, map))
}

fn absolute(path: &Path) -> Result<String, String> {
    let full = path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(full.display().to_string())
}

/// Writes a session for the recordings: one flight each, or one for all, and one window over the whole of each.
///
/// # Errors
/// One line when a recording cannot be read or no channel map fits.
pub fn new(arguments: &NewArguments) -> Result<(), String> {
    if arguments.output.exists() {
        return Err(format!(
            "{} exists: choose another name, a session is never overwritten",
            arguments.output.display()
        ));
    }
    let probes = arguments
        .recordings
        .iter()
        .map(|path| inspect(path).map_err(|error| error.to_string()))
        .collect::<Result<Vec<_>, _>>()?;
    let groups: Vec<(String, Vec<usize>)> = if arguments.merge {
        vec![("flight".to_owned(), (0..probes.len()).collect())]
    } else {
        (0..probes.len()).map(|index| (name_of(&arguments.recordings[index]), vec![index])).collect()
    };
    let mut session = empty_session(&name_of(&arguments.output), &aircraft_reference(&arguments.aircraft)?);
    session.structure = match arguments.structure {
        StructureName::Thesis => Structure::thesis(),
        StructureName::Alternative => Structure::alternative(),
        StructureName::Quadratic => Structure::quadratic(),
        StructureName::WithPower => Structure::with_power(),
    };
    let mut measured = BTreeSet::new();
    for (name, members) in groups {
        let probes: Vec<Probe> = members.iter().map(|&index| probes[index].clone()).collect();
        let (reference, map) = match &arguments.map {
            Some(name) => channel_map(name)?,
            None => best_map(&probes)?,
        };
        let plan = plan_all(&probes, &map);
        measured.extend(plan.roles.keys().copied());
        text::line(&format!("{name}: channel map {reference}, {} roles", plan.roles.len()));
        for problem in &plan.problems {
            text::line(&format!("  {}", problem.text));
        }
        let recordings = members
            .iter()
            .map(|&index| begin::reference(&arguments.recordings[index], MapRef::File(reference.clone())))
            .collect::<Result<Vec<_>, _>>()?;
        session.windows.extend(whole_window(&name, &probes));
        session.flights.push(Flight::new(name, recordings));
    }
    session::save(&session, &arguments.output).map_err(|error| error.to_string())?;
    let missing: Vec<_> = begin::unmeasured(&measured).into_iter().map(Measurement::name).collect();
    if !missing.is_empty() {
        text::line(&format!("not measured: {}", missing.join(", ")));
    }
    text::line(&format!("{}: set windows, noise and terms, then `doublet run`", arguments.output.display()));
    Ok(())
}

/// How a session refers to an aircraft given by file or by the name of one that comes with the program.
///
/// # Errors
/// One line when there is none.
pub fn aircraft_reference(name: &str) -> Result<String, String> {
    if builtin::text("aircraft", name).is_some() {
        return Ok(format!("{}{name}", builtin::PREFIX));
    }
    if Path::new(name).exists() {
        return absolute(Path::new(name));
    }
    Err(format!("no aircraft '{name}': give a file, or one of {}", builtin::aircraft().join(", ")))
}

/// The shipped map that gives these recordings the most roles without an error.
fn best_map(probes: &[Probe]) -> Result<(String, ChannelMap), String> {
    let best = fitting_maps(probes).into_iter().next().ok_or_else(|| {
        "no shipped channel map fits these channels: write one and name it with --map (see `doublet inspect`), or map \
         them by hand in the window"
            .to_owned()
    })?;
    channel_map(best.name)
}
