//! `doublet new`: a session for recordings.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::load::{ChannelMap, Probe, inspect, plan_all};
use doublet_core::model::Structure;
use doublet_core::reconstruct::{FilterSettings, Measurement};
use doublet_core::series::Window;
use doublet_engine::builtin;
use doublet_engine::session::{
    self, Estimation, Flight, Manoeuvre, Preparation, RecordingRef, Session, SignalSetting, WindowRole,
};

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
    let mut flights = Vec::new();
    let mut windows = Vec::new();
    let mut measured = Vec::new();
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
            .map(|&index| recording(&arguments.recordings[index], &reference))
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(window) = whole(&probes) {
            windows.push(Manoeuvre {
                name: name.clone(),
                flight: name.clone(),
                window,
                role: WindowRole::Identification,
                surface: None,
                kind: String::new(),
            });
        }
        let signals = SignalSetting::default();
        flights.push(Flight { name, recordings, clocks: Vec::new(), instruments: None, signals });
    }
    let aircraft = aircraft_reference(&arguments.aircraft)?;
    let session = Session {
        title: name_of(&arguments.output),
        aircraft,
        loading: None,
        flights,
        windows,
        steady: Vec::new(),
        noise_reasons: BTreeMap::new(),
        filter: FilterSettings::default(),
        preparation: Preparation::default(),
        estimation: Estimation::default(),
        structure: match arguments.structure {
            StructureName::Thesis => Structure::thesis(),
            StructureName::Alternative => Structure::alternative(),
            StructureName::Quadratic => Structure::quadratic(),
            StructureName::WithPower => Structure::with_power(),
        },
        second_structure: None,
    };
    session::save(&session, &arguments.output).map_err(|error| error.to_string())?;
    let missing = Measurement::ALL.into_iter().filter(|m| !measured.contains(&m.role())).map(Measurement::name);
    let missing: Vec<_> = missing.collect();
    if !missing.is_empty() {
        text::line(&format!("not measured: {}", missing.join(", ")));
    }
    text::line(&format!("{}: set windows, noise and terms, then `doublet run`", arguments.output.display()));
    Ok(())
}

fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(|| "flight".to_owned(), |stem| stem.to_string_lossy().into_owned())
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
    Err(format!("no aircraft '{name}': give a file, or one of {}", builtin::names("aircraft").join(", ")))
}

fn recording(path: &Path, channel_map: &str) -> Result<RecordingRef, String> {
    Ok(RecordingRef {
        path: absolute(path)?,
        sha256: Some(session::content_hash(path).map_err(|error| error.to_string())?),
        channel_map: channel_map.to_owned(),
        only: None,
    })
}

/// The shipped map that gives these recordings the most roles without an error.
fn best_map(probes: &[Probe]) -> Result<(String, ChannelMap), String> {
    let maps = builtin::names("channel_maps").into_iter().filter_map(|name| channel_map(name).ok());
    let fitting = maps.filter_map(|(name, map)| {
        let plan = plan_all(probes, &map);
        (!plan.has_errors() && !plan.roles.is_empty()).then_some((plan.roles.len(), name, map))
    });
    fitting.max_by_key(|(roles, ..)| *roles).map(|(_, name, map)| (name, map)).ok_or_else(|| {
        "no shipped channel map fits these channels: write one and name it with --map (see `doublet inspect`)"
            .to_owned()
    })
}

/// The time all clocks of the recordings span together.
fn whole(probes: &[Probe]) -> Option<Window> {
    let clocks = probes.iter().flat_map(|probe| &probe.sources).flat_map(|source| &source.clocks);
    let (start_s, end_s) =
        clocks.filter(|clock| clock.samples > 1).fold((f64::INFINITY, f64::NEG_INFINITY), |(start, end), clock| {
            (start.min(clock.start_s), end.max(clock.end_s))
        });
    (start_s < end_s).then_some(Window { start_s, end_s })
}
