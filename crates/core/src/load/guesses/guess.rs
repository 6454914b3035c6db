//! Guesses of a channel map: from the names of channels, their units and the size of their values.
//!
//! A guess is where a user starts, never an answer: nothing is read by it before it was looked at.

use std::collections::BTreeSet;

use crate::load::contents::{Probe, Source};
use crate::load::file::stem;
use crate::load::guesses::by_words::{
    add_instead_of_airspeed, add_names, add_rates_in_their_unit, add_total_pressure, give_named, leave_out_signals,
    take_vectors_from_one_source,
};
use crate::load::guesses::candidates::{Candidate, best, candidates, row};
use crate::load::guesses::pairs::add_other_sides;
use crate::load::guesses::recorders::{self, Claims};
use crate::load::guesses::runner_up::add_runners_up;
use crate::load::guesses::user_names::UserNames;
use crate::load::guesses::{
    alike, by_physics, guess_frames, increments, kinds, motion, motion_signs, motion_units, ranges, slopes, vectors,
};
use crate::load::maps::by_hand::{By, ChannelName, ManualChannel, ManualChannelMap, ManualTime};
use crate::load::names::foreign_names::AIRSPEEDS_OF_NO_KIND;
use crate::load::names::role_names::{NAMES, names_of};
use crate::load::names::stated_unit::name_and_unit;
use crate::load::names::tokens::tokens;
use crate::load::names::words::plain_letters;
use crate::quantity::{Dimension, Role, Unit};

/// Mean specific force along z that is taken for g, as magnitude; larger ones for m/s².
const LARGEST_MEAN_G: f64 = 4.0;

/// What the channels of `probes` look like: roles by name, units as recorded, as the name ends or as large as the values are, signs
/// where the values tell them (specific force along z is about -g in level flight). A channel without time of its own, or one that
/// time itself is, plays no role.
pub fn guess(probes: &[Probe]) -> ManualChannelMap {
    guess_with(probes, &UserNames::default())
}

/// The same with the names that a user gives.
pub fn guess_with(probes: &[Probe], names: &UserNames) -> ManualChannelMap {
    let claims = recorders::claim(probes);
    let mut map = ManualChannelMap {
        name: probes.first().map(|probe| stem(&probe.path)).unwrap_or_default(),
        time: even_times(probes),
        ..ManualChannelMap::default()
    };
    let mut candidates = free_candidates(probes, &claims, names, &mut map);
    (map.rows, map.attitude, map.velocity) = (claims.rows, claims.attitude, claims.velocity);
    (map.recorders, map.kind) = (claims.names, claims.kind);
    names.add(&mut map, probes, true);
    candidates.retain(|candidate| map.rows.iter().all(|(_, row)| row.by != By::File || row.from != candidate.from));
    if map.recorders.is_empty()
        && by_physics::names_say_nothing(&candidates)
        && by_physics::add_roles(&mut map, &candidates, probes)
    {
        add_position(&mut map, probes);
        return map;
    }
    alike::keep_the_best(&mut map, &mut candidates);
    let mut taken: Vec<usize> = Vec::new();
    add_names(&mut map, &candidates, &mut taken);
    add_rates_in_their_unit(&mut map, &candidates, &mut taken);
    take_vectors_from_one_source(&mut map, &candidates, &mut taken);
    add_other_sides(&mut map, &candidates, &mut taken);
    add_instead_of_airspeed(&mut map, &candidates, &mut taken);
    add_total_pressure(&mut map, &candidates, &mut taken);
    leave_out_signals(&mut map, &candidates);
    names.add(&mut map, probes, false);
    settle_airspeed(&mut map, probes, &candidates, &taken);
    let mut free: Vec<Candidate<'_>> = untaken(candidates, &taken);
    free.retain(|candidate| map.rows.iter().all(|(_, row)| row.by != By::File || row.from != candidate.from));
    vectors::add_vectors(&mut map, &free);
    if let Some(mut found) = by_physics::find_unnamed(&map, &free, probes) {
        add_position(&mut found, probes);
        return found;
    }
    slopes::add_place(&mut map, &free);
    slopes::add_velocity(&mut map, &free, probes);
    slopes::settle_airspeed(&mut map, probes);
    agree_on_degrees(&mut map, probes);
    guess_frames::scale_fixes(&mut map, probes);
    ranges::settle(&mut map, probes);
    refine_forces(&mut map, probes);
    take_other_forces(&mut map, &free, probes);
    guess_frames::turn_axes_up(&mut map);
    guess_frames::exchange_local_axes(&mut map);
    increments::add_increments(&mut map, probes);
    motion::add_climb(&mut map, &free, probes);
    motion_units::settle(&mut map, probes);
    if !motion_signs::settle(&mut map, probes) {
        guess_frames::turn_heights(&mut map, probes);
    }
    slopes::turn_climb(&mut map, probes);
    guess_frames::add_attitude(&mut map, &free);
    guess_frames::add_velocity(&mut map, &free);
    names.restore(&mut map, probes);
    guess_frames::keep_mapped_or_derived(&mut map);
    add_position(&mut map, probes);
    add_runners_up(&mut map, &free);
    kinds::settle(&mut map, probes);
    map
}

/// Start and rate of sources whose stamps are coarser than the samples, each repeated equally often.
fn even_times(probes: &[Probe]) -> Vec<(String, ManualTime)> {
    let even = |source: &Source| {
        let [clock] = source.clocks.as_slice() else { return None };
        let coarse = clock.coarse.filter(|coarse| coarse.is_even)?;
        let (start_s, rate_hz) = (coarse.start_s(coarse.rate_hz), coarse.rate_hz);
        Some((source.name.clone(), ManualTime::Even { start_s, rate_hz }))
    };
    probes.iter().flat_map(|probe| &probe.sources).filter_map(even).collect()
}

/// Channels whose names no token forbids and that no known recorder gives another meaning.
pub(crate) fn nameable_candidates(probes: &[Probe]) -> Vec<Candidate<'_>> {
    free_candidates(probes, &recorders::claim(probes), &UserNames::default(), &mut ManualChannelMap::default())
}

/// Candidates that no recorder is known to have given another meaning and no token of whose names forbids it.
fn free_candidates<'p>(
    probes: &'p [Probe],
    claims: &Claims,
    names: &UserNames,
    map: &mut ManualChannelMap,
) -> Vec<Candidate<'p>> {
    let is_claimed = |from: &ChannelName| claims.closed.contains(&from.source) || claims.never.contains(from);
    // What every source is called says nothing of one of them.
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let parts: Vec<BTreeSet<String>> = sources.map(|source| tokens(&source.name).into_iter().collect()).collect();
    let mut free = Vec::new();
    for candidate in candidates(probes) {
        let is_row = claims.rows.iter().any(|(_, row)| row.from == candidate.from);
        if is_row {
            continue;
        }
        if is_claimed(&candidate.from) {
            let why = format!("{} gives it another meaning, or none", claims.names.join(", "));
            map.left_out_by_name.push((candidate.from, why));
            continue;
        }
        let (name, _) = name_and_unit(candidate.channel.label());
        let is_of_all = |token: &String| parts.iter().all(|parts| parts.contains(token));
        let of_source = || names.forbidden_source(&candidate.from.source).filter(|token| !is_of_all(token));
        match names.forbidden(&name).or_else(of_source) {
            Some(token) => map.left_out_by_name.push((candidate.from, format!("'{token}' in its name"))),
            None => free.push(candidate),
        }
    }
    free
}

fn untaken<'p>(candidates: Vec<Candidate<'p>>, taken: &[usize]) -> Vec<Candidate<'p>> {
    candidates
        .into_iter()
        .enumerate()
        .filter(|(index, _)| !taken.contains(index))
        .map(|(_, candidate)| candidate)
        .collect()
}

/// Sources whose airspeed is calibrated: `ARSP` of ArduPilot (Log Messages) and `VFR_HUD` of MAVLink (Common Message Set).
const CALIBRATED_SOURCES: [&str; 2] = ["arsp", "vfrhud"];

/// Words of what a vehicle records and no simulation of one does.
const VEHICLE_WORDS: [&str; 21] = [
    "utm", "nav", "ch", "wp", "groundspeed", "hdop", "sats", "satellites", "numsv", "armed", "rssi", "voltage", "volt",
    "volts", "current", "pwm", "servo", "rc", "out", "fix", "batt",
];

/// How many of these words the channels of a source hold.
fn count_vehicle_words(probes: &[Probe], source: &str) -> usize {
    let sources = probes.iter().flat_map(|probe| &probe.sources).filter(|other| other.name == source);
    let words: BTreeSet<String> =
        sources.flat_map(|source| &source.channels).flat_map(|one| tokens(&one.name)).collect();
    VEHICLE_WORDS.iter().filter(|word| words.contains(**word)).count()
}

/// An airspeed that does not say its kind is calibrated where an autopilot's sensor gives it, or in knots, as instruments show it.
fn settle_airspeed(map: &mut ManualChannelMap, probes: &[Probe], candidates: &[Candidate<'_>], taken: &[usize]) {
    let Some(given) = map.row(Role::TrueAirspeed) else { return };
    let Some(candidate) = candidates.iter().find(|candidate| candidate.from == given.from) else { return };
    let says_no_kind = (candidate.plain.ends_with("airspeed") && !candidate.plain.contains("true"))
        || AIRSPEEDS_OF_NO_KIND.contains(&candidate.words.as_str());
    let of_autopilot = CALIBRATED_SOURCES.iter().any(|source| candidate.full.starts_with(source));
    let is_of_vehicle = count_vehicle_words(probes, &candidate.from.source) >= 2;
    let in_knots = candidate.unit.is_some_and(|unit| unit.symbol == "kt");
    if !says_no_kind || !(of_autopilot || in_knots || is_of_vehicle) || map.row(Role::CalibratedAirspeed).is_some() {
        return;
    }
    let calibrated = ManualChannel { fit: given.fit, ..row(candidate, Role::CalibratedAirspeed) };
    map.set(Role::CalibratedAirspeed, Some(calibrated));
    let names = names_of(&NAMES, Role::TrueAirspeed);
    let another = best(candidates, taken, Role::TrueAirspeed, names, &|candidate, name| candidate.plain == name);
    map.set(Role::TrueAirspeed, another.map(|index| row(&candidates[index], Role::TrueAirspeed)));
}

/// What a row for `role` of the channel `from` starts as: the unit it was recorded in, its name ends in or its values look like.
pub fn guess_row(probes: &[Probe], role: Role, from: &ChannelName) -> ManualChannel {
    let candidate = candidates(probes).into_iter().find(|candidate| candidate.from == *from);
    candidate.map_or_else(|| ManualChannel::new(from.clone(), None), |candidate| row(&candidate, role))
}

/// Quantities a recorder gives in one unit: where one of them is too large for radians, those are degrees too that are not.
const GROUPS: [&[Role]; 4] = [
    &[Role::BankAngle, Role::PitchAngle, Role::HeadingAngle],
    &[Role::AngleOfAttack, Role::Sideslip],
    &[Role::Aileron, Role::Elevator, Role::Rudder],
    &[Role::RollRate, Role::PitchRate, Role::YawRate],
];

/// Gives the members of a group without a unit of their own the degrees that another member's size tells.
fn agree_on_degrees(map: &mut ManualChannelMap, probes: &[Probe]) {
    for group in GROUPS {
        let in_degrees = |row: &ManualChannel| row.unit.filter(|unit| unit.symbol.starts_with("deg"));
        let open = group.iter().filter_map(|role| map.row(*role)).filter(|row| row.is_unit_open(probes));
        let Some(degrees) = open.filter_map(in_degrees).next() else { continue };
        for (role, row) in &mut map.rows {
            if group.contains(role) && row.is_unit_open(probes) {
                row.unit = Some(degrees);
            }
        }
    }
}

/// Gives the rates of one vector without a unit the one that the motion or the size of another of them shows.
pub fn share_rate_unit(map: &mut ManualChannelMap, probes: &[Probe]) {
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate];
    let of_vector = |row: &ManualChannel| row.by == By::Axes && row.is_unit_open(probes);
    let in_degrees = |row: &&ManualChannel| row.unit.is_some_and(|unit| unit.symbol == "deg/s");
    let shown = rates.iter().filter_map(|role| map.row(*role)).filter(|row| of_vector(row)).find(in_degrees);
    let Some((source, unit)) = shown.map(|row| (row.from.source.clone(), row.unit)) else { return };
    for (role, row) in &mut map.rows {
        if rates.contains(role) && row.from.source == source && of_vector(row) {
            row.unit = unit;
        }
    }
}

/// Parts of names of specific forces that are positive upwards.
const UPWARDS: [&str; 5] = ["norm", "hoch", "vertikal", "verticale", "aceleracionvertical"];
/// Ends of names of load factors less one g, which are positive upwards: `Nz-1`, `Delta nz`.
const LESS_ONE: [&str; 3] = ["nz1", "nzminus1", "deltanz"];

/// Specific force along z is about -g on the mean: its size tells g from m/s² where no unit is known, its sign the axis, and a mean
/// near zero in g that 1 g was taken off.
fn refine_forces(map: &mut ManualChannelMap, probes: &[Probe]) {
    let axes = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    let Some(row) = map.row(Role::SpecificForceZ) else { return };
    let Some(channel) = row.from.find(probes) else { return };
    let finite = || channel.values().iter().filter(|value| value.is_finite());
    let count = finite().count();
    if count == 0 {
        return;
    }
    let mean = finite().sum::<f64>() / count as f64;
    let Ok(g) = Unit::parse("g") else { return };
    let is_stated = channel.unit.is_some() || !row.is_unit_open(probes);
    let size = row.unit.map_or(mean, |unit| unit.to_si(mean) / g.scale).abs();
    if is_stated && row.by != By::Recorder && row.unit != Some(g) && size < 0.35 {
        for role in axes {
            if let Some(row) = map.row(role).cloned() {
                map.left_out.push((row.from, "no gravity in it: not the specific force".to_owned()));
                map.set(role, None);
            }
        }
        return;
    }
    let in_g = if channel.unit.is_none() { mean.abs() < LARGEST_MEAN_G } else { row.unit == Some(g) };
    for (role, row) in &mut map.rows {
        let unknown = row.from.find(probes).is_some_and(|channel| channel.unit.is_none());
        let is_default = row.unit == Some(Unit::si(Dimension::Acceleration));
        if axes.contains(role) && unknown && is_default && in_g && !row.from.channel.to_lowercase().ends_with("_m_s2") {
            row.unit = Some(g);
        }
        if *role == Role::SpecificForceZ {
            let taken_off = in_g && mean.abs() < 0.4;
            let name = plain_letters(&name_and_unit(&row.from.channel).0);
            let upwards = UPWARDS.iter().any(|up| name.contains(up)) || LESS_ONE.iter().any(|one| name.ends_with(one));
            row.turned = mean > 0.4 || (taken_off && upwards);
            row.offset = if !taken_off {
                0.0
            } else if row.turned {
                1.0
            } else {
                -1.0
            };
        }
    }
}

/// Takes the specific force from other channels where those that were named first hold no gravity and are left out.
fn take_other_forces(map: &mut ManualChannelMap, free: &[Candidate<'_>], probes: &[Probe]) {
    let axes = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    if map.left_out.is_empty() || axes.iter().any(|role| map.row(*role).is_some()) {
        return;
    }
    let is_left_out = |one: &Candidate<'_>| map.left_out.iter().any(|(from, _)| *from == one.from);
    let others: Vec<Candidate<'_>> = free.iter().filter(|one| !is_left_out(one)).cloned().collect();
    let mut taken = Vec::new();
    for role in axes {
        give_named(role, map, &others, &mut taken);
    }
    vectors::add_vectors(map, &others);
    ranges::settle_forces(map, probes);
    refine_forces(map, probes);
}

/// Position down of an altitude where nothing else gives it; of fixes where there are latitude and longitude of one clock and no position. An
/// altitude of another clock is then position down by itself.
fn add_position(map: &mut ManualChannelMap, probes: &[Probe]) {
    let has = |role: Role| map.row(role).is_some();
    let clock = |role: Role| {
        let row = map.row(role)?;
        Some((row.from.source.as_str(), row.from.find(probes)?.clock))
    };
    let fixes = has(Role::Latitude) && has(Role::Longitude) && clock(Role::Latitude) == clock(Role::Longitude);
    let altitude = [Role::GpsAltitude, Role::Altitude].into_iter().find(|role| has(*role));
    if fixes && !has(Role::PositionNorth) && !has(Role::PositionEast) && !has(Role::PositionDown) {
        let is_of_fixes = altitude.is_none_or(|role| clock(role) == clock(Role::Latitude));
        map.position_from_fixes = true;
        if is_of_fixes {
            return;
        }
    }
    let altitude = altitude.and_then(|role| map.row(role)).cloned();
    if let Some(row) = altitude.filter(|_| map.row(Role::PositionDown).is_none()) {
        map.set(Role::PositionDown, Some(ManualChannel { turned: !row.turned, ..row }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::maps::map::ChannelMap;
    use crate::load::maps::plan::plan;
    use crate::load::maps::read::read;
    use crate::load::probe_of;

    /// Level flight at 60 m/s in the units of a hobbyist's recorder.
    const TEXT: &str = "time,imu_ax_g,ay,nz,gyro_x,q_deg_s,YawRate_rad_s,Roll [deg],theta,hdg,IAS_kt,TAS,AoA,elevator,Lat,Lon,alt_ft\n\
        0.00,0.02,0.0,1.0,10.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.00,4.0,1000\n\
        0.02,0.02,0.0,1.1,-9.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.01,4.0,1000\n\
        0.04,0.02,0.0,0.9,10.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.02,4.0,1000\n";

    #[test]
    fn guess_finds_roles_units_and_signs_and_reads_them_in_si() {
        let probe = probe_of(TEXT);
        let map = guess(std::slice::from_ref(&probe));
        assert_eq!(map.name, "mine");
        assert!(map.position_from_fixes);
        let parsed = ChannelMap::parse(&map.text().unwrap()).unwrap();
        let plan = plan(&probe, &parsed);
        assert_eq!(plan.problems, []);
        let recording = read(&plan).unwrap();
        let first = |role| recording.role(role).map(|channel| channel.series.values[0]);
        let degree = std::f64::consts::PI / 180.0;
        for (role, wanted) in [
            (Role::SpecificForceX, 0.02 * 9.806_65),
            (Role::SpecificForceZ, -9.806_65),
            (Role::RollRate, 10.0 * degree),
            (Role::PitchRate, degree),
            (Role::YawRate, 0.1),
            (Role::BankAngle, 2.0 * degree),
            (Role::PitchAngle, 3.0 * degree),
            (Role::HeadingAngle, 181.0 * degree),
            (Role::CalibratedAirspeed, 110.0 * 1852.0 / 3600.0),
            (Role::TrueAirspeed, 60.0),
            (Role::AngleOfAttack, 2.5 * degree),
            (Role::Elevator, -4.0 * degree),
            (Role::Altitude, 304.8),
            (Role::PositionDown, 0.0),
        ] {
            let value = first(role).unwrap_or(f64::NAN);
            assert!((value - wanted).abs() < 1e-9, "{}: {value}, not {wanted}", role.name());
            if let Some(row) = map.row(role) {
                let read = row.values(std::slice::from_ref(&probe)).unwrap();
                assert!((read.unit.to_si(read.first) - wanted).abs() < 1e-9);
            }
        }
        assert_eq!(recording.role(Role::RollRate).unwrap().series.time_s[..], [0.0, 0.02, 0.04]);
        assert!(map.row(Role::Sideslip).is_none());
    }

    #[test]
    fn attitude_without_units_is_in_degrees_where_one_angle_is() {
        let probe = probe_of("t,roll,pitch,yaw,beta_rad,alpha\n0,1,2,170,0.1,3\n1,1,2,171,0.1,3\n2,1,2,172,0.1,3\n");
        let map = guess(std::slice::from_ref(&probe));
        let symbol = |role| map.row(role).and_then(|row| row.unit).map(|unit| unit.symbol);
        for role in [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle, Role::AngleOfAttack] {
            assert_eq!(symbol(role), Some("deg"), "{}", role.name());
        }
        assert_eq!(symbol(Role::Sideslip), Some("rad"), "its name says so");
    }

    #[test]
    fn altitude_without_fixes_is_position_down_turned() {
        let probe = probe_of("t,alt,p\n0,100,0\n1,110,0\n2,120,0\n");
        let map = guess(std::slice::from_ref(&probe));
        let first = |role| map.row(role).unwrap().values(std::slice::from_ref(&probe)).unwrap().first;
        assert_eq!(first(Role::PositionDown), -100.0);
        assert_eq!(first(Role::Altitude), 100.0);
    }

    #[test]
    fn source_without_time_gets_the_rate_given() {
        let probe = probe_of("p,q\n5,1\n4,2\n6,3\n");
        let mut map = guess(std::slice::from_ref(&probe));
        map.time.push(("mine".to_owned(), ManualTime::Rate(50.0)));
        let parsed = ChannelMap::parse(&map.text().unwrap()).unwrap();
        let recording = read(&plan(&probe, &parsed)).unwrap();
        assert_eq!(recording.role(Role::PitchRate).unwrap().series.time_s[..], [0.0, 0.02, 0.04]);
    }

    #[test]
    fn stamps_in_whole_seconds_become_start_and_rate() {
        let rows: String = (0..80).map(|k| format!("{},{}\n", (k + 3) / 10, k % 7)).collect();
        let probe = probe_of(&format!("UTC [s],roll rate [deg/s]\n{rows}"));
        let map = guess(std::slice::from_ref(&probe));
        let [(_, ManualTime::Even { start_s, rate_hz })] = map.time[..] else { panic!("{:?}", map.time) };
        assert!((start_s - 0.3).abs() < 1e-9 && rate_hz == 10.0);
        let recording = read(&plan(&probe, &ChannelMap::parse(&map.text().unwrap()).unwrap())).unwrap();
        let time_s = &recording.role(Role::RollRate).unwrap().series.time_s;
        assert!((time_s[0] - 0.3).abs() < 1e-9 && (time_s[79] - 8.2).abs() < 1e-9);
    }

    #[test]
    fn airspeed_without_word_of_its_kind_is_calibrated_in_knots_and_true_in_metres_per_second() {
        let roles = |head: &str| {
            let map = guess(&[probe_of(&format!("time,{head}\n0.0,95,102\n0.1,96,103\n0.2,95,102\n"))]);
            [Role::CalibratedAirspeed, Role::TrueAirspeed].map(|role| map.row(role).map(|row| row.from.channel.clone()))
        };
        let named = |name: &str| Some(name.to_owned());
        assert_eq!(roles("Airspeed (kt),other"), [named("Airspeed"), None]);
        assert_eq!(roles("Airspeed (kt),TAS (kt)"), [named("Airspeed"), named("TAS")]);
        assert_eq!(roles("Airspeed (m/s),other"), [None, named("Airspeed")]);
        assert_eq!(roles("true airspeed (kt),other"), [None, named("true airspeed")]);
    }

    /// First values of the roles guessed of a text, in the units recorded.
    fn firsts(text: &str) -> Vec<(&'static str, f64)> {
        let probe = probe_of(text);
        let map = guess(std::slice::from_ref(&probe));
        let first =
            |row: &ManualChannel| row.values(std::slice::from_ref(&probe)).map_or(f64::NAN, |values| values.first);
        map.rows.iter().map(|(role, row)| (role.name(), first(row))).collect()
    }

    #[test]
    fn french_names_are_guessed() {
        let text = "Temps (s);Gîte (°);Assiette (°);Cap (°);Vitesse de roulis (°/s);Vitesse de tangage (°/s);Vitesse de lacet (°/s);\
            Facteur de charge nx (g);Facteur de charge ny (g);Facteur de charge nz (g);Vitesse indiquée (kt);Incidence (°);\
            Dérapage (°);Altitude pression (ft);Vz (ft/min);Gouverne de profondeur (°);Aileron droit (°);Gouverne de direction (°)\n\
            0,0000;0,1042;2,0368;34,7635;0,0363;0,0010;0,2519;0,0291;-0,0015;0,9947;217,2442;1,8169;0,0774;19683,8;2,6;0,4953;0,0603;-0,0387\n\
            0,0312;0,1180;1,8278;34,5917;0,0626;-0,0029;0,0524;0,0327;0,0014;0,9950;216,6304;2,0395;0,0047;19685,6;-11,0;0,5017;-0,0296;0,0381\n\
            0,0625;-0,2103;1,9529;34,3517;0,1966;-0,0507;0,0800;0,0226;-0,0047;0,9974;217,2751;1,9710;-0,0578;19685,7;2,9;0,4823;0,0219;0,0034\n";
        let wanted = [
            ("ax", 0.0291),
            ("ay", -0.0015),
            ("az", -0.9947),
            ("p", 0.0363),
            ("q", 0.001),
            ("r", 0.2519),
            ("z", -19_683.8),
            ("v_down", -2.6),
            ("phi", 0.1042),
            ("theta", 2.0368),
            ("psi", 34.7635),
            ("alpha", 1.8169),
            ("beta", 0.0774),
            ("delta_a", 0.0603),
            ("delta_e", 0.4953),
            ("delta_r", -0.0387),
            ("calibrated_airspeed", 217.2442),
            ("altitude", 19_683.8),
        ];
        assert_near(&firsts(text), &wanted);
    }

    #[test]
    fn german_names_are_guessed_with_and_without_umlauts() {
        let head = "Uhrzeit;Rollwinkel;Nickwinkel;Gierwinkel;Rollrate;Nickrate;Gierrate;Beschl_längs;Beschl_quer;Beschl_hoch;\
            Fluggeschw_wahr;Anstellwinkel;Schiebewinkel;Höhe_MSL;Vario;Querruder;Höhenruder;Seitenruder\n";
        let rows = "hh:mm:ss;°;°;°;°/s;°/s;°/s;g;g;g;km/h;°;°;m;m/s;°;°;°\n\
            10:23:11.000;-0,0804;1,7559;34,3110;0,0956;0,2046;-0,2021;0,02793;0,00378;1,00229;111,878;4,2428;0,1049;1199,88;-1,612;-0,0083;1,1714;-0,0126\n\
            10:23:11.020;-0,0484;1,6749;34,3067;0,3489;0,1556;-0,0592;0,03198;-0,00191;1,00573;111,158;4,0211;0,0250;1199,71;-1,578;-0,0294;1,1299;-0,0176\n";
        let wanted = [
            ("ax", 0.027_93),
            ("ay", 0.003_78),
            ("az", -1.002_29),
            ("p", 0.0956),
            ("q", 0.2046),
            ("r", -0.2021),
            ("z", -1199.88),
            ("v_down", 1.612),
            ("phi", -0.0804),
            ("theta", 1.7559),
            ("psi", 34.311),
            ("airspeed", 111.878),
            ("alpha", 4.2428),
            ("beta", 0.1049),
            ("delta_a", -0.0083),
            ("delta_e", 1.1714),
            ("delta_r", -0.0126),
            ("altitude", 1199.88),
        ];
        let plain = head.replace("längs", "laengs").replace("Höhe", "Hoehe");
        for head in [head, &plain, &plain.replace("Hoehe", "Hohe").replace("laengs", "langs")] {
            assert_near(&firsts(&format!("{head}{rows}")), &wanted);
        }
    }

    fn assert_near(found: &[(&'static str, f64)], wanted: &[(&'static str, f64)]) {
        let names = |all: &[(&'static str, f64)]| all.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        assert_eq!(names(found), names(wanted));
        for ((name, value), (_, wanted)) in found.iter().zip(wanted) {
            assert!((value - wanted).abs() < 1e-9, "{name}: {value}, not {wanted}");
        }
    }

    #[test]
    fn a_name_of_two_readings_is_taken_where_unit_or_another_channel_leaves_one() {
        for (head, wanted) in [
            ("Roulis,Tangage", &[][..]),
            ("Roulis (°),Tangage (°/s)", &["q", "phi"]),
            ("Vitesse de roulis,Roulis", &["p", "phi"]),
            ("Rollrate,Rollen", &["p", "phi"]),
            ("Direction,Altitude", &["z", "altitude"]),
            ("Direction,Profondeur", &["delta_e", "delta_r"]),
            ("XI,ETA,ZETA", &["delta_a", "delta_e", "delta_r"]),
            ("XI,ETA", &[]),
            ("VC (kt),VP (kt)", &["airspeed", "calibrated_airspeed"]),
            ("VV (m/s),Vz (m/s)", &[]),
            ("VV (kt),Vz (ft/min)", &["v_down", "airspeed"]),
            ("Soll-Kurs,Kurs", &["psi"]),
            ("Kraftstoff,Drehzahl", &["engine_speed_1"]),
            ("Querruder links,Effort profondeur", &["delta_a"]),
            ("IMU_Rollrate,AHRS Nickwinkel", &["p", "theta"]),
            ("Fluggeschwindigkeit (kt),Staudruck", &["calibrated_airspeed"]),
            ("Fluggeschwindigkeit (km/h),Staudruck", &["airspeed"]),
        ] {
            let third = if head.split(',').count() == 3 { ",4" } else { "" };
            let text = format!("time,{head}\n0.0,5,2{third}\n0.1,6,3{third}\n0.2,5,2{third}\n");
            let names: Vec<_> = firsts(&text).into_iter().map(|(name, _)| name).collect();
            assert_eq!(names, wanted, "{head}");
        }
        assert_eq!(
            firsts("time,Querruder links,Vario\n0.0,5,2\n0.1,6,3\n0.2,5,2\n"),
            [("v_down", -2.0), ("delta_a", -5.0)]
        );
    }
}
