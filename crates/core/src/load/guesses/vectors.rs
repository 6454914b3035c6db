//! Vectors of three: channels of one source whose names differ by the axis alone, such as `ang_vel_x`, `pqr[0]` or `vz`.

use crate::load::guesses::candidates::{Candidate, row};
use crate::load::guesses::other_quantities::is_of_controller;
use crate::load::maps::by_hand::{By, ManualChannelMap};
use crate::load::names::stated_unit::is_count;
use crate::load::names::tokens::{end_on, essence};
use crate::quantity::{Dimension, Role};

/// Roles of a vector and the words its channels share.
type Vector = ([Role; 3], &'static [&'static str]);

const VECTORS: &[Vector] = &[
    (
        [Role::RollRate, Role::PitchRate, Role::YawRate],
        &[
            "angvel", "angularvel", "angularvelocity", "angularrate", "angrate", "bodyrate", "bodyrates", "gyro",
            "gyr", "gyros", "gyroscope", "omega", "pqr", "rate", "rates", "turnrate", "bodyangularrate",
            "angularratewrtei", "angularrates", "bodyangularvelocity", "avel", "uncompgyro", "compgyro", "rateofturn",
            "w", "wb",
        ],
    ),
    (
        [Role::RollAcceleration, Role::PitchAcceleration, Role::YawAcceleration],
        &["angacc", "angaccel", "angularacc", "angularaccel", "angularacceleration", "omegadot", "pqrdot"],
    ),
    (
        [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ],
        &[
            "acc", "accel", "accels", "acceleration", "linearacceleration", "linacc", "specificforce", "accelerometer",
            "a", "ab", "accelerations", "bodyacceleration", "bodyaccel", "imuacc", "uncompaccel", "compaccel",
            "linearaccel", "accpilot",
        ],
    ),
    (
        [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown],
        &[
            "v", "vel", "velocity", "ve", "vned", "velned", "velocityned", "nedvel", "vearth", "speed",
            "groundvelocity", "gpsvel", "gpsv", "gpsvelocity", "gpsvelned", "gpsvned", "velgps", "fevelocity",
            "linearvelocity", "linvel", "vg", "gnssvelned", "twistlinear",
        ],
    ),
    (
        [Role::PositionNorth, Role::PositionEast, Role::PositionDown],
        &[
            "p", "pos", "position", "posned", "nedpos", "pose", "localposition", "localpos", "local", "odom",
            "positionned", "poseposition",
        ],
    ),
    (
        [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle],
        &["euler", "eulerangle", "eulerangles", "rpy", "attitude", "phithetapsi", "eulerangledeg", "rollpitchyaw"],
    ),
    ([Role::HeadingAngle, Role::PitchAngle, Role::BankAngle], &["yawpitchroll", "ypr", "psithetaphi"]),
];
/// Ends of names by axis.
const AXES: [[&str; 3]; 7] = [
    ["x", "y", "z"],
    ["0", "1", "2"],
    ["1", "2", "3"],
    ["n", "e", "d"],
    ["north", "east", "down"],
    ["roll", "pitch", "yaw"],
    ["p", "q", "r"],
];
/// First axes of what turns.
const TURNS: [&str; 2] = ["roll", "p"];
/// Single letters that are a role only beside the others of their vector.
const LETTERS: [[&str; 3]; 12] = [
    ["p", "q", "r"],
    ["x", "y", "z"],
    ["xe", "ye", "ze"],
    ["u", "v", "w"],
    ["ax", "ay", "az"],
    ["pn", "pe", "pd"],
    ["gx", "gy", "gz"],
    ["rn", "re", "rd"],
    ["bx", "by", "bz"],
    ["an", "ax", "ay"],
    ["n", "e", "d"],
    ["xdot", "ydot", "zdot"],
];

/// The same of a velocity whose third axis is up.
const UPWARDS: [&str; 3] = ["vn", "ve", "vu"];

/// Axes along the ground that stand for a vector where its third part is a climb or a height of another name.
const LEVEL_AXES: [[&str; 2]; 3] = [["x", "y"], ["n", "e"], ["north", "east"]];
/// Tokens of axes that are fixed to the body.
const BODY_AXES: [&str; 6] = ["body", "b", "frd", "flu", "bf", "uvw"];
/// Letters of the shortest stem that may stand behind other words.
const LEAST_STEM: usize = 4;

/// Gives the roles of vectors that have no channel yet theirs.
pub(crate) fn add_vectors(map: &mut ManualChannelMap, candidates: &[Candidate<'_>]) {
    let of_earth: Vec<Candidate<'_>> = candidates
        .iter()
        .filter(|one| !one.tokens.iter().any(|token| BODY_AXES.contains(&token.as_str())))
        .cloned()
        .collect();
    let has_height = [Role::Altitude, Role::GpsAltitude].iter().any(|role| map.row(*role).is_some());
    for (roles, stems) in VECTORS {
        let is_open = roles.map(|role| map.row(role).is_none());
        let is_place = roles[0] == Role::PositionNorth;
        let is_of_earth = is_place || roles[0] == Role::VelocityNorth;
        let candidates = if is_of_earth { &of_earth } else { candidates };
        let turns = [Role::RollRate, Role::RollAcceleration, Role::BankAngle].contains(&roles[0]);
        let all = |stem: &&str| find_axes(stem, roles[0].dimension(), turns, candidates).map(|found| found.to_vec());
        let level = |stem: &&str| find_level_axes(stem, roles[0].dimension(), candidates).map(|found| found.to_vec());
        let found = match is_open {
            [true, true, true] => {
                stems.iter().find_map(all).or_else(|| stems.iter().filter(|_| is_place && has_height).find_map(level))
            }
            [true, true, false] => stems.iter().filter(|_| is_of_earth).find_map(level),
            _ => None,
        };
        for (role, index) in roles.iter().zip(found.into_iter().flatten()) {
            let mut row = row(&candidates[index], *role);
            row.by = By::Axes;
            map.set(*role, Some(row));
        }
    }
}

/// The three channels of one source and dimension called by `stem` and an axis, which of what `turns` may be roll, pitch and yaw.
pub(crate) fn find_axes(
    stem: &str,
    dimension: Dimension,
    turns: bool,
    candidates: &[Candidate<'_>],
) -> Option<[usize; 3]> {
    let axes = AXES.iter().filter(|axes| turns || !TURNS.contains(&axes[0]));
    axes.into_iter().find_map(|axes| find_parts(stem, dimension, *axes, candidates))
}

/// The two channels along the ground of one source and dimension called by `stem` and an axis.
fn find_level_axes(stem: &str, dimension: Dimension, candidates: &[Candidate<'_>]) -> Option<[usize; 2]> {
    LEVEL_AXES.into_iter().find_map(|axes| find_parts(stem, dimension, axes, candidates))
}

/// The channels of one source and dimension called by `stem` and each of `axes`.
fn find_parts<const N: usize>(
    stem: &str,
    dimension: Dimension,
    axes: [&str; N],
    candidates: &[Candidate<'_>],
) -> Option<[usize; N]> {
    let fits =
        |candidate: &Candidate<'_>| candidate.unit.is_none_or(|unit| unit.dimension == dimension || is_count(unit));
    let at = |axis: usize, source: Option<&str>| {
        candidates.iter().position(|candidate| {
            source.is_none_or(|source| candidate.from.source == source)
                && fits(candidate)
                && has_stem(candidate, axes[axis], stem)
        })
    };
    let first = at(0, None)?;
    let source = Some(candidates[first].from.source.as_str());
    let mut found = [first; N];
    for axis in 1..N {
        found[axis] = at(axis, source)?;
    }
    Some(found)
}

/// Whether the name of a channel is `stem` beside an axis, which ends or begins it; a long stem, but for a position, may stand behind other
/// words.
fn has_stem(candidate: &Candidate<'_>, axis: &str, stem: &str) -> bool {
    let Some(words) = words_beside(candidate, axis) else { return false };
    let is_letter = !axis.starts_with(|sign: char| sign.is_numeric());
    essence(&words) == stem
        || (is_letter
            && stem.len() >= LEAST_STEM
            && !stem.starts_with("pos")
            && end_on(&words, stem)
            && !is_of_controller(&words))
}

/// Tokens of the name of a channel without its axis, which ends or begins it.
fn words_beside(candidate: &Candidate<'_>, axis: &str) -> Option<Vec<String>> {
    let (last, before) = candidate.tokens.split_last()?;
    if last == axis {
        return (!before.is_empty()).then(|| before.to_vec());
    }
    if let Some(stem) =
        last.strip_suffix(axis).filter(|stem| !stem.is_empty() && !axis.starts_with(|sign: char| sign.is_numeric()))
    {
        return Some(before.iter().cloned().chain([stem.to_owned()]).collect());
    }
    let (first, rest) = candidate.tokens.split_first()?;
    (first == axis && !rest.is_empty()).then(|| rest.to_vec())
}

/// Whether a name of one letter stands beside the others of its vector, which other names need not.
pub(crate) fn has_brothers(name: &str, role: Role, candidate: &Candidate<'_>, candidates: &[Candidate<'_>]) -> bool {
    // Velocity up, beside those north and east alone.
    let letters = if name == "vu" { Some(&UPWARDS) } else { LETTERS.iter().find(|letters| letters.contains(&name)) };
    let Some(letters) = letters else { return true };
    let is_stated = candidate.unit.is_some_and(|unit| unit.dimension == role.dimension() && !is_count(unit));
    let renamed = |letter: &str| {
        let last = candidate.plain.strip_suffix(name).map(|before| format!("{before}{letter}"));
        [Some(candidate.plain.replace(name, letter)), last]
    };
    let is_there = |letter: &str| {
        let names = renamed(letter);
        candidates.iter().any(|other| {
            other.from.source == candidate.from.source && names.iter().flatten().any(|name| other.plain == *name)
        })
    };
    let beside = |letters: &[&str]| letters.iter().filter(|letter| **letter != name && is_there(letter)).count();
    let others = beside(letters);
    // Three of gravity, of gyros or of a magnetometer, unless they say that they are accelerations.
    if role.dimension() == Dimension::Acceleration && ["gx", "bx"].contains(&letters[0]) {
        return is_stated && others == 2;
    }
    match letters[0] {
        // Beside u and w it is a velocity of the body.
        "u" => others == 0,
        "p" | "pn" => is_stated || others > 0,
        // Body rates stand beside body forces.
        "ax" => is_stated || others + beside(&["p", "q", "r"]) > 0,
        // Beside accelerations; by themselves they are gravity.
        "gx" => others == 2 && (is_stated || beside(&["ax", "ay", "az"]) > 0 || beside(&["accx", "accy", "accz"]) > 0),
        // The altitude is the third.
        "x" => others == 2 || (others == 1 && name != "z" && beside(&["altitude", "alt", "height"]) > 0),
        "xdot" => others == 2 || is_there("hdot"),
        "xe" => others == 2 || (name == "ye" && is_there("xn")),
        _ => others == 2,
    }
}
