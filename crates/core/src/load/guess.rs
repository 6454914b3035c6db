//! Guesses of a channel map: from the names of channels, their units and the size of their values.
//!
//! A guess is where a user starts, never an answer: nothing is read by it before it was looked at.

use super::by_hand::{ChannelName, ManualChannel, ManualChannelMap};
use super::text_layout::split_unit;
use super::{ChannelInfo, Probe, guess_frames};
use crate::quantity::{Dimension, Role, Unit};

/// Names a role goes by, in small letters without separators, best first.
const NAMES: &[(Role, &[&str])] = &[
    (
        Role::SpecificForceX,
        &["ax", "accx", "accelx", "xacc", "xaccel", "longacc", "blongacc", "imuax", "nx", "fx", "linearaccelerationx"],
    ),
    (
        Role::SpecificForceY,
        &["ay", "accy", "accely", "yacc", "yaccel", "latacc", "blatacc", "imuay", "ny", "fy", "linearaccelerationy"],
    ),
    (
        Role::SpecificForceZ,
        &["az", "accz", "accelz", "zacc", "zaccel", "normacc", "bnormacc", "imuaz", "nz", "fz", "linearaccelerationz"],
    ),
    (
        Role::RollRate,
        &["p", "rollrate", "brollrate", "gyrox", "gyrx", "omegax", "wx", "pbody", "xrate", "angularvelocityx"],
    ),
    (
        Role::PitchRate,
        &["q", "pitchrate", "bpitchrate", "gyroy", "gyry", "omegay", "wy", "qbody", "yrate", "angularvelocityy"],
    ),
    (
        Role::YawRate,
        &["r", "yawrate", "byawrate", "gyroz", "gyrz", "omegaz", "wz", "rbody", "zrate", "angularvelocityz"],
    ),
    (Role::RollAcceleration, &["pdot"]),
    (Role::PitchAcceleration, &["qdot"]),
    (Role::YawAcceleration, &["rdot"]),
    (Role::PositionNorth, &["x", "posn", "posnorth", "north", "xe", "xn"]),
    (Role::PositionEast, &["y", "pose", "poseast", "east", "ye"]),
    (Role::PositionDown, &["z", "posd", "posdown", "down", "ze"]),
    (Role::VelocityNorth, &["vnorth", "vn", "veln", "velnorth", "velocitynorth", "gpsvn"]),
    (Role::VelocityEast, &["veast", "ve", "vele", "veleast", "velocityeast", "gpsve"]),
    (
        Role::VelocityDown,
        &[
            "vdown",
            "vd",
            "veld",
            "veldown",
            "velocitydown",
            "gpsvd",
            "climbrate",
            "verticalspeed",
            "vspd",
            "rateofclimb",
        ],
    ),
    (Role::BankAngle, &["phi", "roll", "bank", "rollangle", "bankangle"]),
    (Role::PitchAngle, &["theta", "pitch", "tht", "pitchangle", "the"]),
    (Role::HeadingAngle, &["psi", "yaw", "heading", "hdg", "trueheading", "headingangle", "yawangle"]),
    (Role::TrueAirspeed, &["airspeed", "tas", "vtas", "trueairspeed", "va", "vt", "v"]),
    (Role::AngleOfAttack, &["alpha", "aoa", "angleofattack", "alfa", "alphavane", "vaneaoa"]),
    (Role::Sideslip, &["beta", "aos", "sideslip", "angleofsideslip", "betavane", "vaneaos", "ssa"]),
    (Role::Aileron, &["deltaa", "da", "aileron", "dail", "ail", "aileronpos", "ailerondeflection"]),
    (Role::Elevator, &["deltae", "de", "elevator", "delev", "elev", "elv", "elevatorpos", "elevatordeflection"]),
    (Role::Rudder, &["deltar", "dr", "rudder", "drud", "rud", "rudderpos", "rudderdeflection"]),
    (Role::ElevatorTrim, &["deltate", "dte", "elevatortrim", "elevtrim", "elevatordte", "trimtab"]),
    (Role::Stabiliser, &["stabiliser", "stabilizer", "stab", "ih"]),
    (Role::Flap, &["flap", "flaps", "df", "deltaf", "flappos"]),
    (Role::StaticPressure, &["staticpressure", "ps", "pstat", "pstatic", "baro"]),
    (Role::AirTemperature, &["airtemperature", "sat", "oat", "staticairtemperature", "ts"]),
    (Role::TotalTemperature, &["totaltemperature", "tat", "tt"]),
    (Role::AirDensity, &["rho", "airdensity", "density"]),
    (Role::Mach, &["mach", "ma", "machnumber"]),
    (Role::CalibratedAirspeed, &["cas", "calibratedairspeed", "ias", "vcas", "vias", "kias", "kcas"]),
    (Role::Altitude, &["altitude", "alt", "pressurealtitude", "hp", "palt", "h", "baroalt"]),
    (Role::Latitude, &["latitude", "lat", "gpslat"]),
    (Role::Longitude, &["longitude", "lon", "long", "lng", "gpslon", "gpslong"]),
    (Role::GpsAltitude, &["gpsaltitude", "gpsalt", "altgps", "hgps", "gpsheight", "altitudemsl", "altmsl"]),
    (Role::FuelMass, &["fuelmass", "fuelonboard", "fuel"]),
    (Role::FuelFlow, &["fuelflow", "ff"]),
    (Role::Thrust1, &["thrust1", "thrustleft", "thrustfront", "thrust"]),
    (Role::Thrust2, &["thrust2", "thrustright", "thrustrear"]),
    (Role::EngineSpeed1, &["enginespeed1", "rpm1", "n11", "rpm", "rpmleft"]),
    (Role::EngineSpeed2, &["enginespeed2", "rpm2", "rpmright"]),
    (Role::ManifoldPressure1, &["manifoldpressure1", "map1", "mp1"]),
    (Role::ManifoldPressure2, &["manifoldpressure2", "map2", "mp2"]),
    (Role::Power1, &["power1", "power"]),
    (Role::Power2, &["power2"]),
    (Role::WeightOnWheels, &["weightonwheels", "wow", "squatswitch", "onground"]),
];

/// Ends of names that tell a unit, in small letters, longest first.
const UNIT_ENDINGS: &[(&str, &str)] = &[
    ("_rad_s2", "rad/s^2"),
    ("_deg_s2", "deg/s^2"),
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_radps", "rad/s"),
    ("_degps", "deg/s"),
    ("_dps", "deg/s"),
    ("_m_s2", "m/s^2"),
    ("_mps2", "m/s^2"),
    ("_ft_s2", "ft/s^2"),
    ("_m_s", "m/s"),
    ("_mps", "m/s"),
    ("_ft_s", "ft/s"),
    ("_fps", "ft/s"),
    ("_fpm", "ft/min"),
    ("_degc", "degC"),
    ("_inhg", "inHg"),
    ("_mbar", "mbar"),
    ("_hpa", "hPa"),
    ("_kpa", "kPa"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_kts", "kt"),
    ("_kt", "kt"),
    ("_pa", "Pa"),
    ("_psi", "psi"),
    ("_rpm", "rpm"),
    ("_ft", "ft"),
    ("_kg", "kg"),
    ("_lb", "lb"),
    ("_k", "K"),
    ("_g", "g"),
    ("_m", "m"),
    ("_n", "N"),
    ("_w", "W"),
];

/// An angle larger than this in radians is taken for degrees: angles of flow and controls, and of attitude.
const LARGEST_FLOW_RAD: f64 = 1.6;
const LARGEST_ATTITUDE_RAD: f64 = 6.4;
/// A rate larger than this in rad/s is taken for degrees per second.
const LARGEST_RATE_RAD_S: f64 = 3.5;
/// Mean specific force along z that is taken for g, as magnitude; larger ones for m/s².
const LARGEST_MEAN_G: f64 = 4.0;

/// Ends of `source channel` of recorders that say in the name of the source what a channel is, tried before all others: topics of PX4.
const NAMES_WITH_SOURCE: &[(Role, &[&str])] = &[
    (Role::SpecificForceX, &["vehicleaccelerationxyz0", "sensorcombinedaccelerometerms20"]),
    (Role::SpecificForceY, &["vehicleaccelerationxyz1", "sensorcombinedaccelerometerms21"]),
    (Role::SpecificForceZ, &["vehicleaccelerationxyz2", "sensorcombinedaccelerometerms22"]),
    (Role::RollRate, &["vehicleangularvelocityxyz0", "sensorcombinedgyrorad0"]),
    (Role::PitchRate, &["vehicleangularvelocityxyz1", "sensorcombinedgyrorad1"]),
    (Role::YawRate, &["vehicleangularvelocityxyz2", "sensorcombinedgyrorad2"]),
    (Role::PositionNorth, &["vehiclelocalpositionx"]),
    (Role::PositionEast, &["vehiclelocalpositiony"]),
    (Role::PositionDown, &["vehiclelocalpositionz"]),
    (Role::VelocityNorth, &["vehiclelocalpositionvx"]),
    (Role::VelocityEast, &["vehiclelocalpositionvy"]),
    (Role::VelocityDown, &["vehiclelocalpositionvz"]),
    (Role::TrueAirspeed, &["airspeedvalidatedtrueairspeedms", "airspeedtrueairspeedms"]),
];
/// Sources that hold no measurement of the aircraft, and sources and channels whose names mislead: accelerations in axes of the Earth.
const NOT_MEASURED: &[&str] = &["setpoint", "localpositionax", "localpositionay", "localpositionaz"];

/// A channel that may play a role.
pub(super) struct Candidate<'p> {
    pub from: ChannelName,
    pub plain: String,
    /// Name of the source without its number, then that of the channel.
    full: String,
    unit: Option<Unit>,
    pub channel: &'p ChannelInfo,
}

/// What the channels of `probes` look like: roles by name, units as recorded, as the name ends or as large as the values are, signs
/// where the values tell them (specific force along z is about -g in level flight). A channel without time of its own, or one that
/// time itself is, plays no role.
pub fn guess(probes: &[Probe]) -> ManualChannelMap {
    let candidates = candidates(probes);
    let mut map = ManualChannelMap {
        name: probes.first().map(|probe| super::recognise::stem(&probe.path)).unwrap_or_default(),
        ..ManualChannelMap::default()
    };
    let mut taken: Vec<usize> = Vec::new();
    let ends = |candidate: &Candidate<'_>, name: &str| candidate.full.ends_with(name);
    let is = |candidate: &Candidate<'_>, name: &str| candidate.plain == name;
    let ends_alone = |candidate: &Candidate<'_>, name: &str| name.len() > 2 && candidate.plain.ends_with(name);
    // Names that are a role's own first: `z` of one recorder does not take the `az` of another.
    for (list, fits) in [(NAMES_WITH_SOURCE, &ends as Fits), (NAMES, &is), (NAMES, &ends_alone)] {
        for &(role, names) in list {
            if map.row(role).is_some() {
                continue;
            }
            let found = best(&candidates, &taken, role, names, fits);
            if let Some(index) = found {
                taken.push(index);
                map.set(role, Some(row(&candidates[index], role)));
            }
        }
    }
    agree_on_degrees(&mut map, probes);
    refine_forces(&mut map, probes);
    guess_frames::turn_axes_up(&mut map);
    guess_frames::add_attitude(&mut map, &candidates);
    guess_frames::add_velocity(&mut map, &candidates);
    add_position(&mut map);
    map
}

/// What a row for `role` of the channel `from` starts as: the unit it was recorded in, its name ends in or its values look like.
pub fn guess_row(probes: &[Probe], role: Role, from: &ChannelName) -> ManualChannel {
    let candidate = candidates(probes).into_iter().find(|candidate| candidate.from == *from);
    candidate.map_or_else(|| ManualChannel::new(from.clone(), None), |candidate| row(&candidate, role))
}

fn candidates(probes: &[Probe]) -> Vec<Candidate<'_>> {
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let channels = sources.flat_map(|source| source.channels.iter().map(move |channel| (source, channel)));
    let usable = channels.filter(|(source, channel)| {
        !channel.is_time && channel.samples > 1 && (channel.clock.is_some() || source.clocks.is_empty())
    });
    usable
        .map(|(source, channel)| {
            let (name, _) = split_unit(&channel.name);
            let (stem, _) = stem_and_unit(&name);
            let plain = letters(stem);
            let full = letters(source.name.trim_end_matches(|last: char| !last.is_alphabetic())) + &letters(&name);
            let from = ChannelName { source: source.name.clone(), channel: channel.name.clone() };
            Candidate { from, plain, full, unit: stated_unit(channel), channel }
        })
        .filter(|candidate| !NOT_MEASURED.iter().any(|name| candidate.full.contains(name)))
        .collect()
}

/// Letters and digits of a name, small.
fn letters(name: &str) -> String {
    name.to_lowercase().chars().filter(|letter| letter.is_alphanumeric()).collect()
}

/// A name without the unit it ends on, and that unit: `alpha` and degrees of `alpha_deg`.
pub fn stem_and_unit(name: &str) -> (&str, Option<Unit>) {
    let lower = name.to_ascii_lowercase();
    let ending = UNIT_ENDINGS.iter().find(|(ending, _)| lower.len() > ending.len() && lower.ends_with(ending));
    ending.map_or((name, None), |(ending, unit)| (&name[..name.len() - ending.len()], Unit::parse(unit).ok()))
}

/// Unit of a channel as recorded, or else as its name ends; `None` where neither tells one that is known.
pub fn stated_unit(channel: &ChannelInfo) -> Option<Unit> {
    let recorded = channel.unit.as_deref().filter(|unit| !unit.is_empty());
    recorded.and_then(|unit| Unit::parse(unit).ok()).or_else(|| stem_and_unit(&channel.name).1)
}

/// Whether a channel goes by a name.
pub(super) type Fits<'f> = &'f dyn Fn(&Candidate<'_>, &str) -> bool;

/// The free channel that goes by one of `names`, the best first.
pub(super) fn best(
    candidates: &[Candidate<'_>],
    taken: &[usize],
    role: Role,
    names: &[&str],
    goes_by: Fits<'_>,
) -> Option<usize> {
    let free = |index: &usize| {
        let fits = candidates[*index].unit.is_none_or(|unit| unit.dimension == role.dimension() || is_count(unit));
        fits && !taken.contains(index)
    };
    names.iter().find_map(|name| (0..candidates.len()).filter(free).find(|&index| goes_by(&candidates[index], name)))
}

/// Whether a recorded unit says no more than that there is none.
fn is_count(unit: Unit) -> bool {
    unit.dimension == Dimension::Dimensionless && unit.scale == 1.0
}

pub(super) fn row(candidate: &Candidate<'_>, role: Role) -> ManualChannel {
    let known = candidate.unit.filter(|unit| unit.dimension == role.dimension());
    let mut row = ManualChannel::new(
        candidate.from.clone(),
        Some(known.unwrap_or_else(|| unit_by_size(candidate.channel, role))),
    );
    // Altitude and climb are up, position and velocity down.
    row.turned = match role {
        Role::PositionDown => ["alt", "h"].iter().any(|up| candidate.plain.contains(up)),
        Role::VelocityDown => ["climb", "vertical", "vspd"].iter().any(|up| candidate.plain.contains(up)),
        _ => false,
    };
    row
}

/// The unit values of this size have: degrees where radians would be more than a turn, otherwise SI.
fn unit_by_size(channel: &ChannelInfo, role: Role) -> Unit {
    let largest = channel.values().iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, v| most.max(v.abs()));
    let attitude = matches!(role, Role::BankAngle | Role::HeadingAngle | Role::Latitude | Role::Longitude);
    let name = match role.dimension() {
        Dimension::Angle if attitude && largest > LARGEST_ATTITUDE_RAD => "deg",
        Dimension::Angle if !attitude && largest > LARGEST_FLOW_RAD => "deg",
        Dimension::AngularRate if largest > LARGEST_RATE_RAD_S && !is_engine(role) => "deg/s",
        Dimension::AngularRate if is_engine(role) => "rpm",
        dimension => dimension.si_symbol(),
    };
    Unit::parse(name).unwrap_or(Unit::si(role.dimension()))
}

fn is_engine(role: Role) -> bool {
    matches!(role, Role::EngineSpeed1 | Role::EngineSpeed2)
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
    let candidates = candidates(probes);
    let is_open = |row: &ManualChannel| {
        let of = candidates.iter().find(|candidate| candidate.from == row.from);
        of.is_some_and(|candidate| candidate.unit.is_none_or(is_count))
    };
    for group in GROUPS {
        let in_degrees = |row: &ManualChannel| row.unit.filter(|unit| unit.symbol.starts_with("deg"));
        let open = group.iter().filter_map(|role| map.row(*role)).filter(|row| is_open(row));
        let Some(degrees) = open.filter_map(in_degrees).next() else { continue };
        for (role, row) in &mut map.rows {
            if group.contains(role) && is_open(row) {
                row.unit = Some(degrees);
            }
        }
    }
}

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
    let in_g = if channel.unit.is_none() { mean.abs() < LARGEST_MEAN_G } else { row.unit == Some(g) };
    for (role, row) in &mut map.rows {
        let unknown = row.from.find(probes).is_some_and(|channel| channel.unit.is_none());
        let is_default = row.unit == Some(Unit::si(Dimension::Acceleration));
        if axes.contains(role) && unknown && is_default && in_g && !row.from.channel.to_lowercase().ends_with("_m_s2") {
            row.unit = Some(g);
        }
        if *role == Role::SpecificForceZ {
            let taken_off = in_g && mean.abs() < 0.4;
            let upwards = row.from.channel.to_lowercase().contains("norm");
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

/// Position down of an altitude where nothing else gives it; of fixes where there are latitude and longitude and no position.
fn add_position(map: &mut ManualChannelMap) {
    let has = |role: Role| map.row(role).is_some();
    let fixes = has(Role::Latitude) && has(Role::Longitude);
    if fixes && !has(Role::PositionNorth) && !has(Role::PositionEast) && !has(Role::PositionDown) {
        map.position_from_fixes = true;
        return;
    }
    let altitude = map.row(Role::GpsAltitude).or_else(|| map.row(Role::Altitude)).cloned();
    if let Some(row) = altitude.filter(|_| !has(Role::PositionDown)) {
        map.set(Role::PositionDown, Some(ManualChannel { turned: !row.turned, ..row }));
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ChannelMap, ManualTime, inspect, plan, read};
    use super::*;

    /// Level flight at 60 m/s in the units of a hobbyist's recorder.
    const TEXT: &str = "time,imu_ax_g,ay,nz,gyro_x,q_deg_s,YawRate_rad_s,Roll [deg],theta,hdg,IAS_kt,TAS,AoA,elevator,Lat,Lon,alt_ft\n\
        0.00,0.02,0.0,1.0,10.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.00,4.0,1000\n\
        0.02,0.02,0.0,1.1,-9.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.01,4.0,1000\n\
        0.04,0.02,0.0,0.9,10.0,1.0,0.1,2.0,3.0,181.0,110,60,2.5,-4.0,52.02,4.0,1000\n";

    fn probe_of(text: &str) -> Probe {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.csv");
        std::fs::write(&path, text).unwrap();
        inspect(&path).unwrap()
    }

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
}
