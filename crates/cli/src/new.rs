//! `doublet new`: a session for recordings.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use doublet_core::load::{ChannelMap, Plan, plan_all, read};
use doublet_core::model::Structure;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::Measurement;
use doublet_core::series::Recording;
use doublet_engine::begin::{self, Inspected, add_flight, empty_session, name_of, whole_window};
use doublet_engine::builtin;
use doublet_engine::run::Control;
use doublet_engine::session::{self, Flight, MapRef, Session};
use doublet_engine::stage::{self, NO_AIRCRAFT, NO_PATH_MEASUREMENT};
use doublet_engine::verdict::Level;

use crate::aircraft::PlainArguments;
use crate::map::{ask, explain_row};
use crate::outcome::Outcome;
use crate::output_path::output_path;
use crate::role_option::set_roles;
use crate::text;
use crate::time_option::set_times;

#[derive(Debug, Args)]
pub struct NewArguments {
    /// Recordings: one flight each, unless merged.
    #[arg(required = true)]
    pub recordings: Vec<PathBuf>,
    /// Session file to write.
    #[arg(short, long, value_parser = output_path())]
    pub output: PathBuf,
    /// Channel map (file or name) [default: the best-fitting shipped map].
    #[arg(long)]
    pub map: Option<String>,
    /// Use the guessed channel map; the session stores it.
    #[arg(long, conflicts_with = "map")]
    pub guess: bool,
    /// Override a role's channel: SI value = scale x (value + offset). Repeatable.
    #[arg(long, value_name = crate::role_option::FORM, requires = "guess")]
    pub role: Vec<String>,
    /// Time channel of a source and its unit. Repeatable.
    #[arg(long, value_name = crate::time_option::FORM, requires = "guess")]
    pub time: Vec<String>,
    /// Aircraft (file or name) [default: the one the channel map names].
    #[arg(long)]
    pub aircraft: Option<String>,
    /// Aircraft described by numbers; its file is written beside the session.
    #[command(flatten)]
    pub plain: PlainArguments,
    /// Merge all recordings into one flight on one time line.
    #[arg(long)]
    pub merge: bool,
    /// Initial terms of the coefficients.
    #[arg(long, value_enum, default_value_t = StructureName::Thesis)]
    pub structure: StructureName,
}

/// Initial model structure.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StructureName {
    /// Thesis Eq. 3.21-3.22: constant, flow angle, rates and deflections.
    Thesis,
    /// Thesis Eq. B.1-B.2: adds the rates of the flow angles.
    Alternative,
    /// Adds alpha squared in CX, CZ and Cm.
    Quadratic,
    /// Adds the propeller total-pressure rise in CX, CZ and Cm.
    WithPower,
}

/// A channel map by file or by the name of one that comes with the program, with how a session refers to it.
pub fn channel_map(name: &str) -> Result<(String, ChannelMap), String> {
    let plain = name.strip_prefix(builtin::PREFIX).unwrap_or(name);
    if let Some(text) = builtin::text("channel_maps", plain) {
        let map = ChannelMap::parse(text).map_err(|error| error.to_string())?;
        return Ok((format!("{}{plain}", builtin::PREFIX), map));
    }
    let path = Path::new(name);
    if !path.exists() {
        let known = builtin::names("channel_maps").join(", ");
        return Err(format!("channel map '{name}' not found: give a file, or one of {known}"));
    }
    let map = ChannelMap::read(path).map_err(|error| error.to_string())?;
    Ok((absolute(path)?, map))
}

fn absolute(path: &Path) -> Result<String, String> {
    let full = path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(full.display().to_string())
}

/// Writes a session for the recordings: one flight each, or one for all, with the manoeuvres found in it, or one window over the whole
/// of it where none is.
pub fn new(arguments: &NewArguments) -> Result<Outcome, String> {
    if arguments.output.exists() {
        return Err(format!("{} exists: choose another name", arguments.output.display()));
    }
    let is_one_flight = !arguments.merge
        && arguments.guess
        && arguments.map.is_none()
        && begin::are_of_one_flight(&arguments.recordings)?;
    if is_one_flight {
        text::line("recordings merged into one flight: no two of them have all rates and specific forces");
    }
    let groups: Vec<(String, Vec<PathBuf>)> = if arguments.merge || is_one_flight {
        vec![("flight".to_owned(), arguments.recordings.clone())]
    } else {
        arguments.recordings.iter().map(|path| (name_of(path), vec![path.clone()])).collect()
    };
    let mut session = empty_session(&name_of(&arguments.output), None);
    session.structure = match arguments.structure {
        StructureName::Thesis => Structure::thesis(),
        StructureName::Alternative => Structure::alternative(),
        StructureName::Quadratic => Structure::quadratic(),
        StructureName::WithPower => Structure::with_power(),
    };
    let mut measured = BTreeSet::new();
    let (mut of_maps, mut problem) = (None, None);
    for (name, paths) in groups {
        let mut inspected = begin::inspect_for(&paths, Some(&arguments.output), &Control::default(), &|_| {})?;
        set_roles(&mut inspected, &arguments.role)?;
        set_times(&mut inspected, &arguments.time)?;
        let (reference, map) = match &arguments.map {
            Some(name) => channel_map(name).map(as_file)?,
            None if arguments.guess => match take_guess(&inspected, &arguments.role)? {
                Some(guess) => guess,
                None => return Ok(Outcome::Bad),
            },
            None => best_map(&inspected).map(as_file)?,
        };
        let (roles, found) = flight(&mut session, &name, &inspected, (&reference, &map))?;
        measured.extend(roles);
        problem = problem.or(found);
        if let MapRef::File(file) = &reference {
            of_maps = of_maps.or(aircraft_of_map(file, &map)?);
        }
    }
    session.aircraft = aircraft(arguments)?.or(of_maps);
    let folder = arguments.output.parent().unwrap_or(Path::new(""));
    let session = session::relative_to(&session, folder);
    session::save(&session, &arguments.output).map_err(|error| error.to_string())?;
    let missing: Vec<_> = begin::missing_measurements(&measured).into_iter().map(Measurement::name).collect();
    if missing.len() == Measurement::ALL.len() {
        text::line(&format!("{NO_PATH_MEASUREMENT} {}", missing.join(", ")));
    } else if !missing.is_empty() {
        text::line(&format!("not measured: {}", missing.join(", ")));
    }
    if stage::ANGULAR_ACCELERATIONS.iter().all(|(acceleration, _)| measured.contains(acceleration)) {
        text::line("p_dot, q_dot and r_dot recorded: preparation.angular_acceleration = \"recorded\" uses them");
    }
    text::line(&match &session.aircraft {
        Some(aircraft) => format!("aircraft: {aircraft}"),
        None => format!(
            "{NO_AIRCRAFT}, or give --aircraft, or --area --span --chord --mass with --inertia or --class --length"
        ),
    });
    let output = arguments.output.display();
    if let Some(problem) = problem {
        text::line(&format!("{output}: {problem}"));
        return Ok(Outcome::Bad);
    }
    text::line(&format!("{output}: set manoeuvres, noise and terms, then `doublet run`"));
    Ok(Outcome::Done)
}

fn as_file((reference, map): (String, ChannelMap)) -> (MapRef, ChannelMap) {
    (MapRef::File(reference), map)
}

/// The guess, said row by row; none where time or a deflection can be read in two ways, or time not at all, which is said.
fn take_guess(inspected: &Inspected, options: &[String]) -> Result<Option<(MapRef, ChannelMap)>, String> {
    let asked = ask(inspected, options);
    let open: Vec<_> = asked.iter().filter(|question| question.must_be_answered).collect();
    if !open.is_empty() {
        open.iter().for_each(|question| text::line(&format!("question: {}", question.line())));
        text::line(
            "nothing written: answer with --role or --time, or edit the map of `doublet map --write FILE` and use --map FILE",
        );
        return Ok(None);
    }
    for (role, row) in &inspected.guess.rows {
        text::line(&format!("  {}", explain_row(*role, row, &inspected.probes)));
    }
    inspected.guess.derivations().iter().for_each(|line| text::line(&format!("  {line}")));
    for (from, why) in &inspected.guess.left_out {
        text::line(&format!("  no role: '{}' of {}: {why}", from.channel, from.source));
    }
    let of_signs = asked.iter().filter(|question| question.is_of_sign());
    of_signs.for_each(|question| text::line(&format!("  question: {}", question.line())));
    if let Some(kind) = inspected.guess.kind.as_deref().filter(|kind| *kind != "aeroplane") {
        text::line(&format!("not an aeroplane: {kind}; only its flight path can be reconstructed"));
    }
    let written = inspected.guess.text().map_err(|error| error.to_string())?;
    let map = ChannelMap::parse(&written).map_err(|error| error.to_string())?;
    Ok(Some((MapRef::Own(written.into()), map)))
}

/// What to do about a flight that cannot be computed as it is.
const MAP_REFUSED: &str = "the channel map cannot be used: correct it, then `doublet check`";
const UNREADABLE: &str = "the recording cannot be used: correct it or its channel map, then `doublet check`";
const APART: &str = "recorders do not overlap in time: state the clock offset, then `doublet run`";

/// Adds one flight, says what was made of it, and returns the roles it has and what to do where it cannot be computed.
fn flight(
    session: &mut Session,
    name: &str,
    inspected: &Inspected,
    (reference, map): (&MapRef, &ChannelMap),
) -> Result<(Vec<Role>, Option<&'static str>), String> {
    let plan = plan_all(&inspected.probes, map);
    let roles = plan.all_roles();
    if roles.is_empty() {
        return Err(without_role(name, inspected, &plan, reference));
    }
    text::line(&format!("{name}: channel map {}, {} roles", reference.name(), plan.roles.len()));
    let against = doublet_core::load::mismatches(&plan, map);
    plan.problems.iter().map(|problem| &problem.text).chain(&against).for_each(|line| text::line(&format!("  {line}")));
    print_missing(&roles);
    // What cannot be read is said by what needs it.
    let aligned = read(&plan).ok().and_then(|recording| begin::align_recorders(inspected, recording).ok());
    let (recording, clocks) = aligned.map_or((None, Vec::new()), |(recording, clocks)| (Some(recording), clocks));
    for clock in &clocks {
        let fitted: Vec<&str> = clock.fit.iter().map(|pair| pair.other.as_str()).collect();
        let (source, offset_s) = (&clock.source, clock.offset_s);
        text::line(&format!("  clock of {source}: offset {offset_s:.1} s, fitted to {}", fitted.join(", ")));
    }
    let mut problem = plan.has_errors().then_some(MAP_REFUSED);
    let apart = recording.as_ref().and_then(begin::find_apart).map(|apart| apart.to_string());
    match (&recording, &apart) {
        (_, Some(apart)) => text::line(&format!("  {apart}")),
        (Some(recording), None) => print_contradictions(recording, reference.name()),
        (None, None) => {}
    }
    let map = reference.clone();
    let before = session.windows.len();
    match add_flight(session, (name, &map), inspected, &plan, &Control::default(), &|_| {}) {
        Ok(found) => {
            if found.windows.is_empty() {
                let findings = found.findings.iter().filter(|line| Some(*line) != apart.as_ref());
                findings.for_each(|line| text::line(&format!("  {line}")));
                text::line("  no manoeuvre found: the whole recording is used as one");
            } else {
                text::line(&format!("  manoeuvres found: {}", session.windows.len() - before));
            }
            match (session.flights.len(), found.steady.len()) {
                (1, 0) => text::line("  no steady part found: noise from second differences, or default"),
                (1, steady) => text::line(&format!("  noise from steady parts: {steady}")),
                _ => {}
            }
        }
        // The session says what is wrong with it in `doublet check`, and can be mended.
        Err(error) => {
            // What the plan refuses was said above.
            if !plan.has_errors() {
                text::line(&format!("  {error}"));
            }
            problem = problem.or(Some(UNREADABLE));
            let recordings = inspected.paths.iter().map(|path| begin::reference(path, map.clone()));
            session.flights.push(Flight::new(name.to_owned(), recordings.collect::<Result<_, _>>()?));
            session.windows.extend(whole_window(name, &inspected.probes));
        }
    }
    Ok((roles.into_iter().collect(), problem.or(apart.map(|_| APART))))
}

/// Why no session is made of recordings of which no channel plays a role, and what to do, in one line.
fn without_role(name: &str, inspected: &Inspected, plan: &Plan, reference: &MapRef) -> String {
    let nothing = format!("{name}: nothing written, no channel has a role");
    let mut errors = plan.problems.iter().filter(|problem| problem.is_error);
    if let Some(first) = errors.next() {
        let more = match errors.count() {
            0 => String::new(),
            count => format!(" (and {count} more)"),
        };
        return format!("{nothing}: {}{more}", first.text);
    }
    let channels = inspected.probes.iter().flat_map(|probe| &probe.sources).flat_map(|source| &source.channels);
    let count = channels.filter(|channel| !channel.is_time).count();
    if count == 0 {
        return format!("{nothing}: there is only a time channel; record at least ax, ay, az, p, q and r");
    }
    let file = inspected.paths.first().map_or_else(|| "FILE".to_owned(), |path| path.display().to_string());
    let (known, fix_text) = match reference {
        MapRef::Own(_) => (
            format!("none of its {count} channel names is recognised"),
            format!(
                "use --role ROLE=CHANNEL, or complete the map of `doublet map {file} --write MAP` and use --map MAP"
            ),
        ),
        MapRef::File(map) => (
            format!("the channel map {map} names none of its {count} channels"),
            "correct the map, or use --guess".to_owned(),
        ),
    };
    format!("{nothing}: {known}; `doublet inspect {file}` lists them: {fix_text}")
}

/// Says which roles are missing that the filter is driven by or that derivatives of controls need.
fn print_missing(roles: &BTreeSet<Role>) {
    for lack in begin::missing(|role| roles.contains(&role)).iter().filter(|lack| lack.level != Level::Good) {
        let names: Vec<&str> = lack.roles.iter().map(|role| role.name()).collect();
        let names = names.join(", ");
        let fix_text = "name them in the channel map, or use --guess with --role ROLE=CHANNEL";
        text::line(&format!("  {} {names}; {fix_text}", lack.means));
    }
}

/// Says which channels of a recording contradict each other, and what to change in the map called `map`.
fn print_contradictions(recording: &Recording, map: &str) {
    for row in stage::physics_of(recording, map).contradictions() {
        text::line(&format!("  {}: {}: {}", row.level.name(), row.headline, row.evidence));
        if !row.fix_text.is_empty() {
            text::line(&format!("    {}", row.fix_text));
        }
    }
}

/// The aircraft the arguments name, or the one they describe, written beside the session.
fn aircraft(arguments: &NewArguments) -> Result<Option<String>, String> {
    if let Some(name) = &arguments.aircraft {
        return aircraft_reference(name).map(Some);
    }
    let name = name_of(&arguments.output);
    let Some(plain) = arguments.plain.describe(&name)? else { return Ok(None) };
    let path = arguments.output.with_file_name(format!("{name}_aircraft.toml"));
    crate::aircraft::write(&plain, &path)?;
    absolute(&path).map(Some)
}

/// The aircraft a channel map names: one that comes with the program, or a file beside the map.
fn aircraft_of_map(reference: &str, map: &ChannelMap) -> Result<Option<String>, String> {
    let Some(name) = &map.aircraft else { return Ok(None) };
    if builtin::text("aircraft", name).is_some() {
        return Ok(Some(format!("{}{name}", builtin::PREFIX)));
    }
    absolute(&Path::new(reference).with_file_name(name)).map(Some)
}

/// How a session refers to an aircraft given by file or by the name of one that comes with the program.
pub fn aircraft_reference(name: &str) -> Result<String, String> {
    let plain = name.strip_prefix(builtin::PREFIX).unwrap_or(name);
    if builtin::text("aircraft", plain).is_some() {
        return Ok(format!("{}{plain}", builtin::PREFIX));
    }
    if Path::new(name).exists() {
        return absolute(Path::new(name));
    }
    Err(format!("aircraft '{name}' not found: give a file, or one of {}", builtin::aircraft().join(", ")))
}

/// The shipped map that gives these recordings the most roles without an error.
fn best_map(inspected: &Inspected) -> Result<(String, ChannelMap), String> {
    if let Some(best) = inspected.fitting.first() {
        return channel_map(best.name);
    }
    let against: Vec<String> = inspected
        .refused
        .iter()
        .filter_map(|(name, against)| Some(format!("{name} has the names, but {}", against.first()?)))
        .collect();
    let against = if against.is_empty() { String::new() } else { format!(" ({})", against.join("; ")) };
    Err(format!(
        "no shipped channel map fits these channels{against}: use --guess, write a map and use --map (see `doublet map`), or map \
         them by hand in the window"
    ))
}
