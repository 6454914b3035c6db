//! Guesses of a channel map: from the names of channels, their units and the size of their values.
//!
//! A guess is where a user starts, never an answer: nothing is read by it before it was looked at.

use super::by_hand::{ChannelName, ManualChannel, ManualChannelMap};
use super::candidates::{Candidate, Fits, best, candidates, row};
use super::{Probe, guess_frames};
use crate::quantity::{Dimension, Role, Unit};

/// Names a role goes by, in small letters without separators, best first.
const NAMES: &[(Role, &[&str])] = &[
    (
        Role::SpecificForceX,
        &[
            "ax",
            "accx",
            "accelx",
            "xacc",
            "xaccel",
            "longacc",
            "blongacc",
            "imuax",
            "nx",
            "fx",
            "linearaccelerationx",
            "longitudinalacceleration",
            "longaccel",
            "beschlx",
            "beschleunigungx",
        ],
    ),
    (
        Role::SpecificForceY,
        &[
            "ay",
            "accy",
            "accely",
            "yacc",
            "yaccel",
            "latacc",
            "blatacc",
            "imuay",
            "ny",
            "fy",
            "linearaccelerationy",
            "lateralacceleration",
            "lataccel",
            "beschly",
            "beschleunigungy",
        ],
    ),
    (
        Role::SpecificForceZ,
        &[
            "az",
            "accz",
            "accelz",
            "zacc",
            "zaccel",
            "normacc",
            "bnormacc",
            "imuaz",
            "nz",
            "fz",
            "linearaccelerationz",
            "normalacceleration",
            "normaccel",
            "beschlz",
            "beschleunigungz",
        ],
    ),
    (
        Role::RollRate,
        &["p", "rollrate", "brollrate", "gyrox", "gyrx", "omegax", "wx", "pbody", "xrate", "angularvelocityx"],
    ),
    (
        Role::PitchRate,
        &[
            "q",
            "pitchrate",
            "bpitchrate",
            "gyroy",
            "gyry",
            "omegay",
            "wy",
            "qbody",
            "yrate",
            "angularvelocityy",
            "nickrate",
        ],
    ),
    (
        Role::YawRate,
        &[
            "r",
            "yawrate",
            "byawrate",
            "gyroz",
            "gyrz",
            "omegaz",
            "wz",
            "rbody",
            "zrate",
            "angularvelocityz",
            "gierrate",
        ],
    ),
    (Role::RollAcceleration, &["pdot"]),
    (Role::PitchAcceleration, &["qdot"]),
    (Role::YawAcceleration, &["rdot"]),
    (Role::PositionNorth, &["x", "posn", "posnorth", "north", "xe", "xn"]),
    (Role::PositionEast, &["y", "pose", "poseast", "east", "ye"]),
    (Role::PositionDown, &["z", "posd", "posdown", "down", "ze"]),
    (Role::VelocityNorth, &["vnorth", "vn", "veln", "velnorth", "velocitynorth", "speednorth", "gpsvn"]),
    (Role::VelocityEast, &["veast", "ve", "vele", "veleast", "velocityeast", "speedeast", "gpsve"]),
    (
        Role::VelocityDown,
        &[
            "vdown",
            "vd",
            "veld",
            "veldown",
            "velocitydown",
            "speeddown",
            "gpsvd",
            "climbrate",
            "verticalspeed",
            "vspd",
            "rateofclimb",
            "vs",
            "vvi",
            "ivv",
            "roc",
            "hdot",
            "altituderate",
            "altrate",
            "steigrate",
        ],
    ),
    (Role::BankAngle, &["phi", "roll", "bank", "rollangle", "bankangle", "rollwinkel", "hängewinkel", "querlage"]),
    (Role::PitchAngle, &["theta", "pitch", "tht", "pitchangle", "the", "nickwinkel", "längsneigung"]),
    (
        Role::HeadingAngle,
        &[
            "psi",
            "yaw",
            "heading",
            "hdg",
            "trueheading",
            "headingtrue",
            "hdingtrue",
            "headingangle",
            "yawangle",
            "gierwinkel",
            "steuerkurs",
            "kurs",
        ],
    ),
    (Role::TrueAirspeed, &["airspeed", "tas", "vtas", "trueairspeed", "vtrue", "vtotal", "va", "vt", "v"]),
    (Role::AngleOfAttack, &["alpha", "aoa", "angleofattack", "alfa", "alphavane", "vaneaoa", "anstellwinkel"]),
    (Role::Sideslip, &["beta", "aos", "sideslip", "angleofsideslip", "betavane", "vaneaos", "ssa", "schiebewinkel"]),
    (Role::Aileron, AILERON),
    (
        Role::Elevator,
        &[
            "deltae",
            "de",
            "elevator",
            "delev",
            "elev",
            "elv",
            "elevatorpos",
            "elevatordeflection",
            "elevatorposition",
            "elevpos",
            "höhenruder",
            "hoehenruder",
        ],
    ),
    (
        Role::Rudder,
        &[
            "deltar",
            "dr",
            "rudder",
            "drud",
            "rud",
            "rudderpos",
            "rudderdeflection",
            "rudderposition",
            "rudpos",
            "seitenruder",
        ],
    ),
    (Role::ElevatorTrim, &["deltate", "dte", "elevatortrim", "elevtrim", "elevatordte", "trimtab"]),
    (Role::Stabiliser, &["stabiliser", "stabilizer", "stab", "ih"]),
    (Role::Flap, &["flap", "flaps", "df", "deltaf", "flappos", "klappen", "landeklappen"]),
    (Role::StaticPressure, &["staticpressure", "ps", "pstat", "pstatic", "baro"]),
    (Role::AirTemperature, &["airtemperature", "sat", "oat", "staticairtemperature", "ts"]),
    (Role::TotalTemperature, &["totaltemperature", "tat", "tt"]),
    (Role::AirDensity, &["rho", "airdensity", "density"]),
    (Role::Mach, &["mach", "ma", "machnumber"]),
    (
        Role::CalibratedAirspeed,
        &["cas", "calibratedairspeed", "ias", "vcas", "vias", "kias", "kcas", "indicatedairspeed", "airspeedindicated"],
    ),
    (
        Role::Altitude,
        &["altitude", "alt", "pressurealtitude", "hp", "palt", "h", "baroalt", "altitudeasl", "höhe", "hoehe"],
    ),
    (Role::Latitude, &["latitudegeodetic", "latitude", "lat", "gpslat"]),
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

/// Names of ailerons: their common deflection first, then the right one, whose trailing edge down is positive, then the left one, turned.
const AILERON: &[&str] = &[
    "deltaa",
    "da",
    "aileron",
    "dail",
    "ail",
    "ailerondeflection",
    "rightaileron",
    "aileronright",
    "rightaileronpos",
    "ailr",
    "leftaileron",
    "aileronleft",
    "leftaileronpos",
    "aill",
    "aileronpos",
    "aileronposition",
    "ailpos",
    "querruder",
];

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
/// What the channels of `probes` look like: roles by name, units as recorded, as the name ends or as large as the values are, signs
/// where the values tell them (specific force along z is about -g in level flight). A channel without time of its own, or one that
/// time itself is, plays no role.
pub fn guess(probes: &[Probe]) -> ManualChannelMap {
    let candidates = candidates(probes);
    let mut map = ManualChannelMap {
        name: probes.first().map(|probe| super::finish::stem(&probe.path)).unwrap_or_default(),
        ..ManualChannelMap::default()
    };
    let mut taken: Vec<usize> = Vec::new();
    let ends = |candidate: &Candidate<'_>, name: &str| candidate.full.ends_with(name);
    let is = |candidate: &Candidate<'_>, name: &str| candidate.plain == name;
    let ends_alone = |candidate: &Candidate<'_>, name: &str| {
        name.len() > 2 && candidate.plain.ends_with(name) && !is_other_side(&candidate.plain, name)
    };
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
    settle_airspeed(&mut map, &candidates, &taken);
    agree_on_degrees(&mut map, probes);
    refine_forces(&mut map, probes);
    guess_frames::turn_axes_up(&mut map);
    guess_frames::exchange_local_axes(&mut map);
    guess_frames::scale_fixes(&mut map, probes);
    guess_frames::add_attitude(&mut map, &candidates);
    guess_frames::add_velocity(&mut map, &candidates);
    add_position(&mut map);
    map
}

/// Sources whose airspeed is calibrated: `ARSP` of ArduPilot (Log Messages) and `VFR_HUD` of MAVLink (Common Message Set).
const CALIBRATED_SOURCES: [&str; 2] = ["arsp", "vfrhud"];

/// An airspeed that does not say its kind is calibrated where an autopilot's sensor gives it, or in knots, as instruments show it.
fn settle_airspeed(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], taken: &[usize]) {
    let Some(given) = map.row(Role::TrueAirspeed) else { return };
    let Some(candidate) = candidates.iter().find(|candidate| candidate.from == given.from) else { return };
    let says_no_kind = candidate.plain.ends_with("airspeed") && !candidate.plain.contains("true");
    let of_autopilot = CALIBRATED_SOURCES.iter().any(|source| candidate.full.starts_with(source));
    let in_knots = candidate.unit.is_some_and(|unit| unit.symbol == "kt");
    if !says_no_kind || !(of_autopilot || in_knots) || map.row(Role::CalibratedAirspeed).is_some() {
        return;
    }
    map.set(Role::CalibratedAirspeed, Some(row(candidate, Role::CalibratedAirspeed)));
    let names = NAMES.iter().find(|(role, _)| *role == Role::TrueAirspeed).map_or(&[][..], |(_, names)| names);
    let another = best(candidates, taken, Role::TrueAirspeed, names, &|candidate, name| candidate.plain == name);
    map.set(Role::TrueAirspeed, another.map(|index| row(&candidates[index], Role::TrueAirspeed)));
}

/// Whether a channel's name says a side and `name`, of ailerons, which it ends on, does not: one of a pair is not their common deflection.
fn is_other_side(plain: &str, name: &str) -> bool {
    AILERON.contains(&name) && ["left", "right"].iter().any(|side| plain.contains(side) && !name.contains(side))
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
}
