//! Channels against each other: nothing is raised on the right maps of the reference recordings, wrong maps are named.

use crate::shared;
use std::path::{Path, PathBuf};

use doublet_core::compatibility::ChannelFix;
use doublet_core::load::{self, ChannelMap, ManualChannel, ManualChannelMap, ManualTime, plan_all};
use doublet_core::quantity::{Role, Unit};
use doublet_engine::begin;
use doublet_engine::builtin;
use doublet_engine::graph::{Context, Keyed};
use doublet_engine::session::{self, Flight, MapRef, RecordingRef};
use doublet_engine::stage::{self, FlightPhysics, LoadedFlight};
use doublet_engine::verdict::Level;

/// A mistake made in a channel map, or in the unit of the ticks of a recorder.
enum Wrong {
    Sign(&'static str),
    Unit(&'static str, &'static str),
    Swap(&'static str, &'static str),
    Ticks(f64),
    /// The stamps of a source are late by seconds.
    Late(&'static str, f64),
    None,
}
use Wrong::{Late, None as Right, Sign, Swap, Ticks, Unit as WrongUnit};

/// Files of the shared folder and the shipped map they are read by.
fn files(recording: &str) -> (Vec<String>, &'static str) {
    let citation = |name: &str| format!("data/citation_simulated/{name}.mat");
    match recording {
        "attas" => (["Elv1", "Ail1", "Rud1"].map(|name| format!("data/attas/fAttas{name}.mat")).to_vec(), "attas"),
        "attas elevator" => (vec!["data/attas/fAttasElv1.mat".to_owned()], "attas"),
        "attas aileron" => (vec!["data/attas/fAttasAil1.mat".to_owned()], "attas"),
        "attas rudder" => (vec!["data/attas/fAttasRud1.mat".to_owned()], "attas"),
        "citation aileron" => (vec![citation("da3211_1")], "citation_simulated_clean"),
        "citation elevator" => (vec![citation("de3211_1")], "citation_simulated_clean"),
        "citation rudder" => (vec![citation("dr3211_1")], "citation_simulated_clean"),
        "citation doublet" => (vec![citation("dedoublet_1")], "citation_simulated_clean"),
        "citation noisy" => {
            (vec![citation("da3211_1_noisy_with_truth"), citation("da3211_1")], "citation_simulated_truth")
        }
        "phlab" => (vec!["data/phlab_citation".to_owned()], "phlab_citation"),
        "uav" => (vec!["data/uav_oat/ProcessedData_2022_05_07_11_13_57.mat".to_owned()], "uav_oat"),
        other => panic!("no recording {other}"),
    }
}

/// The text of a shipped channel map with a mistake in it.
fn map_text(map: &str, wrong: &Wrong) -> String {
    let mut text: toml::Table = toml::from_str(builtin::text("channel_maps", map).unwrap()).unwrap();
    let roles = text["roles"].as_table_mut().unwrap();
    match wrong {
        Sign(role) => {
            let entry = roles[*role].as_table_mut().unwrap();
            let sign = entry.get("sign").map_or(1.0, |sign| sign.as_float().unwrap_or(-1.0));
            entry.insert("sign".to_owned(), (-sign).into());
        }
        WrongUnit(role, unit) => {
            roles[*role].as_table_mut().unwrap().insert("unit".to_owned(), (*unit).into());
        }
        Swap(one, other) => {
            let (first, second) = (roles[*one].clone(), roles[*other].clone());
            roles.insert((*one).to_owned(), second);
            roles.insert((*other).to_owned(), first);
        }
        Ticks(_) | Late(..) | Right => {}
    }
    toml::to_string(&text).unwrap()
}

/// What is found in a recording read by its map with a mistake; `None` where it is not here.
fn physics(recording: &str, wrong: &Wrong) -> Option<FlightPhysics> {
    let (flight, loaded) = read(recording, wrong)?;
    let context = Context::new(Path::new("."));
    let found = context.get::<FlightPhysics>(&flight.recordings, &Keyed::from(loaded)).unwrap();
    Some(FlightPhysics::clone(&found))
}

/// A recording read by its map with a mistake, on the time line of its flight.
fn read(recording: &str, wrong: &Wrong) -> Option<(Flight, LoadedFlight)> {
    let (folder, flight) = if recording == "demo" {
        let opened = session::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml")).unwrap();
        let mut flight = opened.session.flights[0].clone();
        for entry in flight.recordings.iter_mut().filter(|entry| entry.channel_map.name().ends_with("demo_flight")) {
            entry.channel_map = MapRef::Own(map_text("demo_flight", wrong).into());
        }
        (opened.folder, flight)
    } else {
        let (files, map) = files(recording);
        let paths: Option<Vec<PathBuf>> = files.iter().map(|file| shared::shared(file)).collect();
        let own = MapRef::Own(map_text(map, wrong).into());
        let reference = |path: PathBuf| RecordingRef {
            path: path.display().to_string(),
            sha256: None,
            channel_map: own.clone(),
            only: None,
        };
        (PathBuf::from("."), Flight::new("one".to_owned(), paths?.into_iter().map(reference).collect()))
    };
    let loaded = Context::new(&folder).get::<LoadedFlight>(&flight, ()).unwrap();
    let mut loaded = LoadedFlight::clone(&loaded);
    if let Ticks(per_second) = wrong {
        for channel in &mut loaded.recording.channels {
            channel.series.time_s = channel.series.time_s.iter().map(|time| time * per_second).collect();
        }
    }
    if let Late(source, by_s) = wrong {
        for channel in loaded.recording.channels.iter_mut().filter(|channel| channel.source == *source) {
            channel.series.time_s = channel.series.time_s.iter().map(|time| time + by_s).collect();
        }
    }
    Some((flight, loaded))
}

/// Every reference recording with a shipped map.
const RECORDINGS: [&str; 12] = [
    "attas", "attas elevator", "attas aileron", "attas rudder", "citation aileron", "citation elevator",
    "citation rudder", "citation doublet", "citation noisy", "phlab", "uav", "demo",
];

#[test]
fn right_maps_of_all_reference_recordings_raise_nothing() {
    for recording in RECORDINGS {
        let Some(found) = physics(recording, &Right) else { continue };
        let raised: Vec<_> = found.contradictions().map(|row| format!("{}: {}", row.headline, row.evidence)).collect();
        assert!(raised.is_empty(), "{recording}: {raised:?}");
        let told = found.rows.iter().filter(|row| row.segments > 0).count();
        println!("{recording}: nothing raised by {told} relations that tell, of {}", found.rows.len());
        assert!(told >= 6, "{recording}: {told} relations tell");
    }
}

/// A recording, its mistake, and the channel and hypothesis it is to be named by.
type Case = (&'static str, Wrong, &'static str, &'static str);

/// Signs, units, ticks and exchanged channels.
const WRONG_MAPS: [Case; 32] = [
    ("attas elevator", Sign("az"), "az", "sign reversed"),
    ("phlab", Sign("az"), "az", "sign reversed"),
    ("attas rudder", Sign("ay"), "ay", "sign reversed"),
    ("uav", Sign("v_down"), "v_down", "sign reversed"),
    ("demo", Sign("v_down"), "v_down", "sign reversed"),
    ("citation rudder", Sign("beta"), "beta", "sign reversed"),
    ("attas rudder", Sign("beta"), "beta", "sign reversed"),
    ("phlab", Sign("p"), "p", "sign reversed"),
    ("citation aileron", Sign("p"), "p", "sign reversed"),
    ("attas elevator", Sign("delta_e"), "delta_e", "sign reversed"),
    ("phlab", Sign("delta_e"), "delta_e", "sign reversed"),
    ("uav", Sign("delta_e"), "delta_e", "sign reversed"),
    ("attas aileron", WrongUnit("p", "rad/s"), "p", "degrees per second, not radians"),
    ("uav", WrongUnit("q", "deg/s"), "q", "radians per second, not degrees"),
    ("attas elevator", WrongUnit("alpha", "rad"), "alpha", "degrees, not radians"),
    ("citation elevator", WrongUnit("theta", "deg"), "theta", "radians, not degrees"),
    ("demo", WrongUnit("airspeed", "m/s"), "airspeed", "knots"),
    ("phlab", WrongUnit("airspeed", "m/s"), "airspeed", "knots"),
    ("uav", WrongUnit("airspeed", "kt"), "airspeed", "metres per second, not knots"),
    ("demo", WrongUnit("altitude", "m"), "altitude", "feet"),
    ("phlab", WrongUnit("altitude", "m"), "altitude", "feet"),
    ("demo", WrongUnit("az", "m/s^2"), "az", "in g"),
    ("phlab", WrongUnit("az", "m/s^2"), "az", "in g"),
    ("attas", WrongUnit("az", "ft/s^2"), "az", "metres per second squared, not feet per second squared"),
    ("attas", Ticks(1e3), "time", "milliseconds"),
    ("phlab", Ticks(1e3), "time", "milliseconds"),
    ("uav", Ticks(1e6), "time", "microseconds"),
    ("citation noisy", Ticks(1e9), "time", "nanoseconds"),
    ("uav", Swap("phi", "theta"), "phi", "swapped with theta"),
    ("phlab", Swap("phi", "theta"), "phi", "swapped with theta"),
    ("attas rudder", Swap("alpha", "beta"), "alpha", "swapped with beta"),
    ("citation elevator", Swap("alpha", "beta"), "alpha", "swapped with beta"),
];

#[test]
fn wrong_maps_are_named_by_channel_and_hypothesis() {
    let (mut tried, mut named, mut missed) = (0, 0, Vec::new());
    for (recording, wrong, channel, hypothesis) in &WRONG_MAPS {
        let Some(found) = physics(recording, wrong) else { continue };
        tried += 1;
        let raised: Vec<_> = found.contradictions().collect();
        let is_named = matches!(&raised[..], [row] if row.channel == *channel && row.hypothesis == *hypothesis
            && row.level == Level::Bad && !row.fix_text.is_empty());
        let headlines: Vec<_> = raised.iter().map(|row| row.headline.to_string()).collect();
        println!("{recording:18} {channel:9} {hypothesis:45} {}", headlines.join("; "));
        if is_named { named += 1 } else { missed.push(format!("{recording}, {channel}: {headlines:?}")) }
    }
    println!("{named} of {tried} wrong maps named, and by nothing else");
    // The limit of the requirement is 22 of 24.
    assert!(named * 24 >= tried * 22, "{missed:#?}");
}

#[test]
fn sign_of_ay_is_told_by_lines_of_other_channels_where_its_own_tells_nothing() {
    let own = |found: &FlightPhysics| {
        let mut rows =
            found.rows.iter().filter(|row| row.channel == "ay" && row.evidence.contains("centripetal acceleration"));
        rows.all(|row| row.slope.is_none())
    };
    let right = physics("demo", &Right).unwrap();
    assert!(own(&right) && right.contradictions().next().is_none());
    let found = physics("demo", &Sign("ay")).unwrap();
    let raised: Vec<_> = found.contradictions().collect();
    assert!(matches!(raised[..], [row] if row.channel == "ay" && row.hypothesis == "sign reversed"), "{raised:?}");
    let lines = ["v_east against specific force", "beta against ay", "r against bank"];
    let told = lines.iter().filter(|line| raised[0].evidence.contains(**line)).count();
    assert!(told >= 2, "{}", raised[0].evidence);
}

/// Recordings with a source that is late by seconds.
const LATE: [(&str, &str, f64); 6] = [
    ("demo", "", 0.0),
    ("demo", "adahrs/heading_altitude", 0.3),
    ("demo", "adahrs/inertial", -1.0),
    ("demo", "navigation", 1.0),
    ("demo", "pod", 0.3),
    ("demo", "pod", -1.0),
];

#[test]
fn stamps_of_a_recorder_that_are_late_are_named_with_the_shift() {
    let mut faults = Vec::new();
    for (recording, source, by_s) in LATE {
        let Some(found) = physics(recording, &Late(source, by_s)) else { continue };
        let raised: Vec<_> = found.contradictions().collect();
        let headlines: Vec<_> = raised.iter().map(|row| format!("{}: {}", row.headline, row.evidence)).collect();
        println!("{recording}, {source} by {by_s} s: {headlines:#?}");
        let is_named = match raised[..] {
            [] => source.is_empty(),
            [row] => {
                let says = row.hypothesis.contains(source) && row.fix_text.contains("clock offset of source");
                !source.is_empty() && says && row.shift_s.is_some_and(|shift_s| (shift_s + by_s).abs() < 0.05)
            }
            _ => false,
        };
        if !is_named {
            faults.push(format!("{recording}, {source} by {by_s} s: {headlines:?}"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// A map made by hand for a recording, one row per role of the shipped map whose raw value is one channel.
fn by_hand(path: &Path, map: &str) -> (ManualChannelMap, Vec<load::Probe>) {
    let probes = vec![load::inspect(path).unwrap()];
    let map = ChannelMap::parse(builtin::text("channel_maps", map).unwrap()).unwrap();
    let plan = plan_all(&probes, &map);
    let mut made = ManualChannelMap { name: "made".to_owned(), ..ManualChannelMap::default() };
    for (role, entry) in
        map.roles.iter().filter(|(role, entry)| plan.roles.contains_key(role) && entry.terms.len() == 1)
    {
        let names = &entry.terms[0].names;
        let mut sources = probes[0].sources.iter();
        let Some((source, channel)) = sources.find_map(|source| {
            let channel = source.channels.iter().find(|channel| names.contains(&channel.name))?;
            Some((source.name.clone(), channel.name.clone()))
        }) else {
            continue;
        };
        let mut row = ManualChannel::new(load::ChannelName { source, channel }, entry.unit);
        (row.turned, row.scale, row.offset) = (entry.factor < 0.0, entry.factor.abs(), entry.offset);
        made.set(*role, Some(row));
    }
    (made, probes)
}

#[test]
fn a_cure_applied_to_a_map_made_by_hand_undoes_the_mistake() {
    let Some(path) = shared::shared("data/citation_simulated/de3211_1.mat") else { return };
    let (right, probes) = by_hand(&path, "citation_simulated_clean");
    let check = |map: &ManualChannelMap| {
        let plan = plan_all(&probes, &ChannelMap::parse(&map.text().unwrap()).unwrap());
        stage::physics_of(&load::read(&plan).unwrap(), "made")
    };
    assert_eq!(check(&right).contradictions().count(), 0);
    let changed = |role: Role, change: &dyn Fn(&mut ManualChannel)| {
        let mut map = right.clone();
        let mut row = right.row(role).unwrap().clone();
        change(&mut row);
        map.set(role, Some(row));
        map
    };
    let mut swapped = right.clone();
    swapped.set(Role::AngleOfAttack, right.row(Role::Sideslip).cloned());
    swapped.set(Role::Sideslip, right.row(Role::AngleOfAttack).cloned());
    let mut ticks = right.clone();
    let clock = &probes[0].sources[0].clocks[0];
    let milliseconds = Unit::parse("ms").unwrap();
    ticks.time = vec![(probes[0].sources[0].name.clone(), ManualTime::Channel(clock.channel.clone(), milliseconds))];
    let wrong = [
        changed(Role::SpecificForceZ, &|row| row.turned = true),
        changed(Role::TrueAirspeed, &|row| row.unit = Unit::parse("kt").ok()),
        changed(Role::TrueAirspeed, &|row| row.scale = 1.0 / 0.514_444_444),
        changed(Role::PitchRate, &|row| (row.unit, row.turned) = (Unit::parse("deg/s").ok(), true)),
        changed(Role::SpecificForceZ, &|row| row.offset = 9.806_65),
        swapped,
        ticks,
    ];
    for map in wrong {
        let found = check(&map);
        let rows: Vec<_> = found.contradictions().collect();
        let [row] = rows[..] else { panic!("{:?}", rows.iter().map(|row| &row.headline).collect::<Vec<_>>()) };
        let fix: &ChannelFix = row.change.as_ref().unwrap();
        let back = begin::apply_fix(&map, fix, &probes);
        assert_eq!(check(&back).contradictions().count(), 0, "{} is not undone by {}", row.headline, row.fix_text);
    }
}
