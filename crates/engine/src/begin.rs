//! A session for recordings: what they hold, which channel maps fit, and what follows from the one chosen.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use doublet_core::airframe::{AircraftClass, GyrationRadii};
use doublet_core::compatibility::ChannelFix;
use doublet_core::load::{
    self, ChannelMap, ManualChannel, ManualChannelMap, ManualTime, Plan, Probe, UserNames, plan_all, stated_unit,
};
use doublet_core::model::Structure;
use doublet_core::prep::signal_band_hz;
use doublet_core::quantity::{Dimension, Role, Unit};
use doublet_core::reconstruct::{FilterSettings, Input, MEASUREMENTS, Measurement};
use doublet_core::series::{Recording, Series};
use doublet_core::statistics::median_step;

use crate::builtin;
use crate::graph::Control;
use crate::session::{
    DelaySource, Edit, Estimation, Flight, GravitySource, GustSource, Level, Manoeuvre, MapRef, NoiseEdit, Preparation,
    RecordingRef, ResidualWeights, Session, content_hash, fitting_name,
};
use crate::stage::{
    FlightPhysics, FlightProposals, LoadedFlight, NO_PATH_MEASUREMENT, NoiseFlight, has_airspeed, measured_by, noise,
    open_entries, open_windows, physics_of, proposals,
};

use clocks::is_one_flight;
pub use clocks::{align_recorders, are_of_one_flight, read_and_compare};
use settle::{OF_GROUND_SPEED, settle_by_motion, take_other_sensors};
use spans::recorded_span;
pub use spans::{Apart, find_apart, whole_window};

mod clocks;
mod settle;
mod spans;

/// A channel map that comes with the program and what it makes of some recordings.
#[derive(Clone, Debug)]
pub struct FittingMap {
    /// Its file's name without extension.
    pub name: &'static str,
    /// One line on the recordings it is for.
    pub description: String,
    /// Aircraft its recordings are of, as a session refers to it, where the map says.
    pub aircraft: Option<String>,
    /// What reading by it will do.
    pub plan: Plan,
}

impl FittingMap {
    /// How a session refers to it.
    pub fn reference(&self) -> MapRef {
        MapRef::File(format!("{}{}", builtin::PREFIX, self.name))
    }
}

/// Recordings looked at before they are read.
#[derive(Clone, Debug, Default)]
pub struct Inspected {
    /// Files or folders, all of one flight.
    pub paths: Vec<PathBuf>,
    /// What each holds.
    pub probes: Vec<Probe>,
    /// Shipped maps that give roles without an error and whose ranges the values keep to, the one with most roles first.
    pub fitting: Vec<FittingMap>,
    /// Shipped maps whose names fit and whose ranges the values do not keep to, with what speaks against each.
    pub refused: Vec<(&'static str, Vec<String>)>,
    /// A map guessed from names, units and values.
    pub guess: ManualChannelMap,
    /// Files of names that a user put beside recording or session.
    pub names: Vec<PathBuf>,
    /// Whether several recordings are of recorders of one flight, as [`are_of_one_flight`] has it.
    pub is_one_flight: bool,
    /// Sources whose clock is taken as it was recorded, whatever other recorders show.
    pub trusted_clocks: BTreeSet<String>,
}

/// A session to be made.
#[derive(Clone, Debug)]
pub struct Order {
    /// Title of the session and name of its flight.
    pub name: String,
    /// Aircraft: a file, or `builtin:` and a name; without one only flight paths are computed.
    pub aircraft: Option<String>,
    /// Channel map.
    pub map: MapRef,
}

/// Roles a recording lacks and what that means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    pub roles: Vec<Role>,
    /// What follows, before the names of the roles.
    pub means: &'static str,
    /// Bad where nothing can be reconstructed, good where the filter does without.
    pub level: Level,
}

/// What is missing of the roles that `has` does not have, worst first.
pub fn missing(has: impl Fn(Role) -> bool) -> Vec<Missing> {
    let absent = |roles: Vec<Role>| roles.into_iter().filter(|role| !has(*role)).collect::<Vec<_>>();
    let inputs = absent(Input::ALL.into_iter().map(Input::role).collect());
    let controls = absent(vec![Role::Elevator, Role::Aileron, Role::Rudder]);
    let recorded = |role| is_given(role, &has).then_some(());
    let unmeasured = Measurement::ALL.into_iter().filter(|measurement| measured_by(*measurement, recorded).is_none());
    let unmeasured: Vec<Role> = unmeasured.map(Measurement::role).collect();
    let (means, level) = if unmeasured.len() == MEASUREMENTS {
        (NO_PATH_MEASUREMENT, Level::Bad)
    } else {
        ("Not measured (optional):", Level::Good)
    };
    let all = [
        Missing { roles: inputs, means: "missing, needed for the flight path:", level: Level::Bad },
        Missing { roles: controls, means: "missing, needed for control derivatives:", level: Level::Caution },
        Missing { roles: unmeasured, means, level },
    ];
    all.into_iter().filter(|missing| !missing.roles.is_empty()).collect()
}

/// The channel maps that come with the program, by name.
static SHIPPED_MAPS: std::sync::LazyLock<Vec<(&'static str, ChannelMap)>> = std::sync::LazyLock::new(|| {
    let parsed = |name| Some((name, ChannelMap::parse(builtin::text("channel_maps", name)?).ok()?));
    builtin::names("channel_maps").into_iter().filter_map(parsed).collect()
});

/// Shipped maps that give these recordings roles without an error, most roles first; and those whose ranges the values breach, with why.
pub(crate) fn fitting_maps(probes: &[Probe]) -> (Vec<FittingMap>, Vec<(&'static str, Vec<String>)>) {
    let (mut fitting, mut refused) = (Vec::new(), Vec::new());
    for &(name, ref map) in SHIPPED_MAPS.iter() {
        let plan = plan_all(probes, map);
        if plan.has_errors() || plan.roles.is_empty() {
            continue;
        }
        let against = load::mismatches(&plan, map);
        if against.is_empty() {
            let aircraft = map.aircraft.as_ref().map(|aircraft| format!("{}{aircraft}", builtin::PREFIX));
            fitting.push(FittingMap { name, description: map.description.clone(), aircraft, plan });
        } else {
            refused.push((name, against));
        }
    }
    fitting.sort_by_key(|map| std::cmp::Reverse(map.plan.roles.len()));
    (fitting, refused)
}

/// Name a recording gives to its flight: that of the file without its extension and without what no name may hold.
pub fn name_of(path: &Path) -> String {
    let name = path.file_stem().map(|stem| fitting_name(&stem.to_string_lossy()));
    name.filter(|name| !name.trim().is_empty()).unwrap_or_else(|| "flight".to_owned())
}

/// Looks at recordings of one flight: everything they hold, the maps that fit and a guess.
pub fn inspect(paths: &[PathBuf], control: &Control, progress: &dyn Fn(f32)) -> Result<Inspected, String> {
    inspect_for(paths, None, control, progress)
}

/// The same for a session, in whose folder a file of names is looked for too.
pub fn inspect_for(
    paths: &[PathBuf],
    session: Option<&Path>,
    control: &Control,
    progress: &dyn Fn(f32),
) -> Result<Inspected, String> {
    let folder = session.and_then(Path::parent).map(Path::to_owned);
    let folders: Vec<PathBuf> = folder.into_iter().chain(UserNames::folders(paths)).collect();
    let names = UserNames::read(&folders).map_err(|error| error.to_string())?;
    let probes = probe_all(paths, control, progress)?;
    let (fitting, refused) = fitting_maps(&probes);
    let guess = take_other_sensors(&probes, load::guess_with(&probes, &names));
    let guess = settle_by_motion(&probes, guess);
    go_on(control)?;
    Ok(Inspected {
        paths: paths.to_vec(),
        is_one_flight: probes.len() > 1 && is_one_flight(&probes),
        probes,
        fitting,
        refused,
        guess,
        names: names.files,
        trusted_clocks: BTreeSet::new(),
    })
}

/// What recordings of one flight hold, without a search for the maps that fit: for a map that is known.
pub fn inspect_for_map(paths: &[PathBuf], control: &Control, progress: &dyn Fn(f32)) -> Result<Inspected, String> {
    Ok(Inspected { paths: paths.to_vec(), probes: probe_all(paths, control, progress)?, ..Inspected::default() })
}

fn probe_all(paths: &[PathBuf], control: &Control, progress: &dyn Fn(f32)) -> Result<Vec<Probe>, String> {
    let mut probes = Vec::with_capacity(paths.len());
    for (index, path) in paths.iter().enumerate() {
        go_on(control)?;
        probes.push(load::inspect(path).map_err(|error| error.to_string())?);
        progress(0.8 * (index + 1) as f32 / paths.len() as f32);
    }
    Ok(probes)
}

/// Why a guessed row has its unit.
pub fn unit_reason(row: &ManualChannel, probes: &[Probe]) -> &'static str {
    let channel = row.from.find(probes);
    let recorded = channel.and_then(|channel| Unit::parse(channel.unit.as_deref()?).ok());
    match (recorded, channel.and_then(stated_unit)) {
        (Some(recorded), _) if row.unit.is_some_and(|unit| unit != recorded) => "instead of the recorded unit",
        (Some(_), _) => "as recorded",
        (None, Some(_)) => "from the end of its name",
        (None, None) if row.is_unit_known => "from its recorder or its values",
        (None, None) => "guessed from its values",
    }
}

/// What reading by a map made by hand will do.
pub fn plan_by_hand(probes: &[Probe], map: &ManualChannelMap) -> Result<Plan, String> {
    let text = map.text().map_err(|error| error.to_string())?;
    Ok(plan_all(probes, &ChannelMap::parse(&text).map_err(|error| error.to_string())?))
}

/// The channels that `plan` reads, against each other.
pub fn compare(plan: &Plan) -> Result<FlightPhysics, String> {
    let recording = load::read(plan).map_err(|error| error.to_string())?;
    Ok(physics_of(&recording, "the map"))
}

/// A map made by hand after the fix of a contradiction; `probes` tell where time comes from that the map does not name.
pub fn apply_fix(map: &ManualChannelMap, fix: &ChannelFix, probes: &[Probe]) -> ManualChannelMap {
    let mut map = map.clone();
    match fix {
        ChannelFix::Scale { role, factor, offset, units } => {
            let Some(mut row) = map.row(*role).cloned() else {
                set_ground_speed_unit(&mut map, *role, *units);
                return map;
            };
            let found = units.and_then(|(is, was)| {
                let taken = row.unit.is_none_or(|unit| unit.symbol == was || unit == Unit::si(role.dimension()));
                Unit::parse(is).ok().filter(|_| taken)
            });
            let was = row.unit;
            row.turned ^= *factor < 0.0;
            match found {
                Some(unit) => row.unit = Some(unit),
                None => row.scale *= factor.abs(),
            }
            let unit = row.unit.unwrap_or(Unit::si(role.dimension()));
            let sign = if row.turned { -1.0 } else { 1.0 };
            row.offset += offset / (sign * row.scale * unit.scale);
            // A recorder without units writes both speeds in one.
            if let Some([speed, _]) = map.velocity.as_mut().filter(|_| *role == Role::TrueAirspeed)
                && speed.unit == was
                && speed.is_unit_open(probes)
            {
                speed.unit = row.unit;
            }
            // Position down of an altitude is of the same numbers.
            let down = map.row(Role::PositionDown).filter(|down| *role == Role::Altitude && down.from == row.from);
            if let Some(down) = down.cloned() {
                map.set(Role::PositionDown, Some(ManualChannel { unit: row.unit, scale: row.scale, ..down }));
            }
            map.set(*role, Some(row));
        }
        ChannelFix::Swap { one, other } => {
            let (first, second) = (map.row(*one).cloned(), map.row(*other).cloned());
            map.set(*one, second);
            map.set(*other, first);
        }
        ChannelFix::Reassign { from, to } => {
            let row = map.row(*from).cloned();
            map.set(*from, None);
            map.set(*to, row);
        }
        ChannelFix::Clock { factor, .. } => fix_clocks(&mut map, *factor, probes),
        ChannelFix::Shift { .. } | ChannelFix::Travel { .. } => {}
    }
    map
}

/// Gives the ground speed, of which velocity north and east are derived, the unit that a fix of one of them names.
fn set_ground_speed_unit(map: &mut ManualChannelMap, role: Role, units: Option<(&str, &str)>) {
    let unit = units.and_then(|(is, _)| Unit::parse(is).ok());
    if let (Some([speed, _]), Some(unit), true) = (map.velocity.as_mut(), unit, OF_GROUND_SPEED.contains(&role)) {
        speed.unit = Some(unit);
    }
}

/// Gives the clocks of a map the unit that is `factor` times theirs, where there is one.
fn fix_clocks(map: &mut ManualChannelMap, factor: f64, probes: &[Probe]) {
    for source in probes.iter().flat_map(|probe| &probe.sources) {
        let stated = map.time.iter().find(|(name, _)| *name == source.name).map(|(_, time)| time.clone());
        let (channel, unit) = match (stated, source.clocks.first()) {
            (Some(ManualTime::Channel(channel, unit)), _) => (channel, unit),
            (None, Some(clock)) => (clock.channel.clone(), clock.unit),
            _ => continue,
        };
        let near = |other: &Unit| (other.scale / (unit.scale * factor) - 1.0).abs() < 1e-6;
        let Some(other) = Unit::all().filter(|unit| unit.dimension == Dimension::Time).find(near) else { continue };
        map.time.retain(|(name, _)| *name != source.name);
        map.time.push((source.name.clone(), ManualTime::Channel(channel, other)));
    }
}

/// The session for `inspected` recordings read by `plan`: one flight, the manoeuvres its controls show as windows, or all of it as one
/// window.
pub fn begin(
    order: &Order,
    inspected: &Inspected,
    plan: &Plan,
    control: &Control,
    progress: &dyn Fn(f32),
) -> Result<Session, String> {
    let mut session = empty_session(&order.name, order.aircraft.as_deref());
    add_flight(&mut session, (&order.name, &order.map), inspected, plan, control, progress)?;
    Ok(session)
}

/// Adds a flight of `inspected` recordings, read by `plan`, to a session, with the manoeuvres its controls show as windows, or all of
/// it as one window, and the noise of its steady parts where it is the first; returns what the search for manoeuvres found.
pub fn add_flight(
    session: &mut Session,
    (name, map): (&str, &MapRef),
    inspected: &Inspected,
    plan: &Plan,
    control: &Control,
    progress: &dyn Fn(f32),
) -> Result<FlightProposals, String> {
    let references = inspected.paths.iter().map(|path| {
        go_on(control)?;
        reference(path, map.clone())
    });
    let recordings = references.collect::<Result<Vec<_>, _>>()?;
    progress(0.3);
    let recording = load::read(plan).map_err(|error| error.to_string())?;
    progress(0.6);
    go_on(control)?;
    let (recording, clocks) = align_recorders(inspected, recording)?;
    let loaded = LoadedFlight { recording, ..LoadedFlight::default() };
    let mut found = proposals(name, &loaded);
    found.findings.extend(find_apart(&loaded.recording).map(|apart| apart.to_string()));
    session.flights.push(Flight { clocks, ..Flight::new(name.to_owned(), recordings) });
    let windows = open_windows(session, &found);
    if windows.is_empty() {
        let whole =
            recorded_span(&loaded.recording).map(|window| Manoeuvre::new(name.to_owned(), name.to_owned(), window));
        session.windows.extend(whole.or_else(|| whole_window(name, &inspected.probes)));
    }
    session.windows.extend(windows);
    if session.flights.len() == 1 {
        take_half_width(session, &loaded.recording);
        take_weights(session, &loaded.recording);
        take_noise(session, NoiseFlight { name, loaded: &loaded, proposals: &found })?;
    }
    progress(1.0);
    Ok(found)
}

/// Half width of the differentiation of a new session whose rates show no band, s: 20 aircraft with known truth were identified with it
/// and with others (docs/fidelity.md).
const HALF_WIDTH_S: f64 = 0.1;
/// Half width times frequency at which the slope by a local parabola has half the amplitude of the derivative: with x = w h it is
/// `3 (sin x - x cos x) / x^3`, one half at x = 2.498.
const HALF_AMPLITUDE: f64 = 2.498 / std::f64::consts::TAU;

/// Takes the half width of the differentiation by the spectra of the rates: half of the amplitude is left at the frequency at which motion and
/// noise have equal power ([`signal_band_hz`]), of the rate that moves fastest. It is two samples at least, and at most that of
/// [`Preparation::default`]. A session that states another keeps it.
fn take_half_width(session: &mut Session, recording: &Recording) {
    let rates = [Role::PitchRate, Role::RollRate, Role::YawRate];
    let rates: Vec<&Series> = rates.iter().filter_map(|role| Some(&recording.role(*role)?.series)).collect();
    let step_s = rates.first().and_then(|rate| median_step(&rate.time_s));
    let band_hz = rates.iter().filter_map(|rate| signal_band_hz(rate)).reduce(f64::max);
    let by_band_s = band_hz.map_or(HALF_WIDTH_S, |band_hz| HALF_AMPLITUDE / band_hz);
    let built_in = Preparation::default().differentiation_half_width_s;
    let half_width_s = &mut session.preparation.differentiation_half_width_s;
    if let (Some(step_s), Some(longest_s)) = (step_s, built_in.filter(|_| *half_width_s == built_in)) {
        *half_width_s = Some(by_band_s.max(2.0 * step_s).min(longest_s));
    }
}

/// Has the residuals of a new session without flow vanes whitened: gusts that nothing recorded shows are slow against the controls and
/// correlate the residuals, and ordinary least squares takes them for a part of the derivatives (docs/fidelity.md).
fn take_weights(session: &mut Session, recording: &Recording) {
    let is_missing = [Role::AngleOfAttack, Role::Sideslip].iter().all(|role| recording.role(*role).is_none());
    let weights = &mut session.estimation.weights;
    if is_missing && *weights == ResidualWeights::default() {
        *weights = ResidualWeights::Autoregression(ResidualWeights::USUAL_ORDER);
    }
}

/// Marks the steady parts found in the first flight of a session whose noise is the built-in one, that of one aircraft's sensors, and takes
/// the noise they show for Q and R. What no steady part shows is taken from the differences of the whole recording.
fn take_noise(session: &mut Session, flight: NoiseFlight<'_>) -> Result<(), String> {
    let windows = flight.proposals.steady.clone();
    let (filter, built_in) = (&session.filter, FilterSettings::default());
    let is_built_in =
        filter.process_noise == built_in.process_noise && filter.measurement_noise == built_in.measurement_noise;
    if !is_built_in {
        return Ok(());
    }
    let marked = Edit::Noise(NoiseEdit::Steady { flight: flight.name.to_owned(), windows });
    let found = noise(&[flight], &[]);
    let entries = found.first().map(|noise| open_entries(session, noise)).unwrap_or_default();
    for edit in [marked, Edit::Noise(NoiseEdit::Set { entries, reason: String::new() })] {
        *session = edit.apply(session).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// A session with nothing flown, every setting as it is by default.
pub fn empty_session(title: &str, aircraft: Option<&str>) -> Session {
    Session {
        title: title.to_owned(),
        aircraft: aircraft.map(str::to_owned),
        aircraft_changes: Default::default(),
        loading: None,
        flights: Vec::new(),
        windows: Vec::new(),
        refused: Vec::new(),
        steady: Vec::new(),
        noise_reasons: BTreeMap::new(),
        filter: FilterSettings::default(),
        gravity: GravitySource::Position,
        gusts: GustSource::Estimated,
        delays: DelaySource::Estimated,
        preparation: Preparation::default(),
        sensor_errors: Default::default(),
        estimation: Estimation::default(),
        structure: Structure::thesis(),
        experiments: Vec::new(),
        annotations: Vec::new(),
        report_purpose: String::new(),
        report_asked: Vec::new(),
        report_notes: String::new(),
        report_figures: Vec::new(),
        plausible: Default::default(),
    }
}

/// How a session refers to the recording at `path`.
pub fn reference(path: &Path, channel_map: MapRef) -> Result<RecordingRef, String> {
    let full = path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(RecordingRef {
        path: full.display().to_string(),
        sha256: Some(content_hash(path).map_err(|error| error.to_string())?),
        channel_map,
        only: None,
    })
}

/// Whether a recording gives a role, itself or by what it has.
fn is_given(role: Role, has: impl Fn(Role) -> bool) -> bool {
    if role == Role::TrueAirspeed { has_airspeed(has) } else { has(role) }
}

/// The measurements of the filter that none of `roles` feeds.
pub fn missing_measurements(roles: &BTreeSet<Role>) -> Vec<Measurement> {
    let recorded = |role| is_given(role, |role| roles.contains(&role)).then_some(());
    Measurement::ALL.into_iter().filter(|measurement| measured_by(*measurement, recorded).is_none()).collect()
}

/// An aircraft in the numbers that derivatives need, with its mass constant and everything about the centre of gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainAircraft {
    pub name: String,
    /// Reference area, m².
    pub area_m2: f64,
    pub span_m: f64,
    /// Mean chord, m.
    pub chord_m: f64,
    pub mass_kg: f64,
    /// Moments of inertia `Ixx, Iyy, Izz`, kg m².
    pub moments_kg_m2: [f64; 3],
    /// Product of inertia `Ixz`, kg m², with its positive sign.
    pub xz_kg_m2: f64,
    /// Where the inertia comes from; nothing where it was given.
    pub note: Option<String>,
}

impl PlainAircraft {
    /// Takes the moments of inertia from the radii of gyration of its class; the product of inertia is none.
    pub fn set_inertia(&mut self, class: AircraftClass, length_m: f64) {
        let radii = class.radii(length_m);
        let GyrationRadii { x, y, z, .. } = radii;
        let tensor = radii.inertia(self.mass_kg, self.span_m).matrix();
        self.moments_kg_m2 = [tensor[(0, 0)], tensor[(1, 1)], tensor[(2, 2)]];
        self.xz_kg_m2 = 0.0;
        self.note = Some(format!(
            "Inertia estimated from the radii of gyration {x}, {y}, {z} of the class {} and a length of {length_m} m (UNICADO, after Raymer). \
             Known aircraft have 0.7 to 2.4 times this inertia in roll and 0.95 to 1.45 times in pitch and yaw; moment derivatives are \
             proportional to it. Enter the measured inertia.",
            class.name()
        ));
    }

    /// The aircraft as the text of an aircraft file.
    pub fn text(&self) -> Result<String, String> {
        let [xx, yy, zz] = self.moments_kg_m2;
        let name = toml::Value::from(self.name.as_str());
        let notes = self.note.as_ref().map(|note| format!("notes = [{}]\n", toml::Value::from(note.as_str())));
        let notes = notes.unwrap_or_default();
        let text = format!(
            "format = \"doublet aircraft\"\nversion = 1\nname = {name}\n{notes}\n[datum]\norigin = \"centre of gravity\"\n\n\
             [reference]\narea_m2 = {:?}\nspan_m = {:?}\nchord_m = {:?}\n\n[mass]\nmass_kg = {:?}\ncg_datum_m = [0.0, 0.0, \
             0.0]\n\n[inertia]\nmoments_kg_m2 = [{xx:?}, {yy:?}, {zz:?}]\nproducts_kg_m2 = {{ xz = {:?} }}\n",
            self.area_m2, self.span_m, self.chord_m, self.mass_kg, self.xz_kg_m2
        );
        let aircraft = load::aircraft::parse(&text).map_err(|error| error.to_string())?;
        match aircraft.check() {
            Ok(_) => Ok(text),
            Err(errors) => Err(errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")),
        }
    }
}

fn go_on(control: &Control) -> Result<(), String> {
    control.checkpoint().map_err(|_| "stopped".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_of_a_session_without_vanes_are_whitened() {
        let weights = |stated: ResidualWeights, roles: &[Role]| {
            let mut session = empty_session("s", None);
            session.estimation.weights = stated;
            let channels: Vec<_> = roles.iter().map(|role| (*role, "", 0, 9)).collect();
            take_weights(&mut session, &spans::tests::recording(&channels));
            session.estimation.weights
        };
        let whitened = ResidualWeights::Autoregression(ResidualWeights::USUAL_ORDER);
        assert_eq!(weights(ResidualWeights::Equal, &[Role::PitchRate]), whitened);
        assert_eq!(weights(ResidualWeights::Equal, &[Role::Sideslip]), ResidualWeights::Equal);
        assert_eq!(weights(ResidualWeights::Huber, &[Role::PitchRate]), ResidualWeights::Huber);
    }

    #[test]
    fn rates_and_forces_alone_are_not_enough() {
        let only = |role| Input::ALL.iter().any(|input| input.role() == role);
        let bad = |has: &dyn Fn(Role) -> bool| {
            let worst = missing(has).into_iter().find(|lack| lack.level == Level::Bad);
            worst.map(|lack| lack.roles.len())
        };
        assert_eq!(bad(&only), Some(MEASUREMENTS));
        assert_eq!(bad(&|role| only(role) || role == Role::TrueAirspeed), None);
    }

    #[test]
    fn height_is_measured_where_an_altitude_tells_it() {
        let lacks_height = |has: &[Role]| {
            let roles = has.iter().copied().collect();
            let filter = missing(|role| has.contains(&role)).into_iter().find(|lack| lack.level == Level::Good);
            let told = filter.is_some_and(|lack| lack.roles.contains(&Role::PositionDown));
            assert_eq!(told, missing_measurements(&roles).contains(&Measurement::PositionDown), "{has:?}");
            told
        };
        assert!(lacks_height(&[Role::AngleOfAttack]));
        assert!(![Role::PositionDown, Role::GpsAltitude, Role::Altitude].iter().any(|role| lacks_height(&[*role])));
    }
}
