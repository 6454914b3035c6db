//! Units that channels state, beside their name or at the end of it.

use std::cmp::Reverse;
use std::sync::LazyLock;

use crate::load::contents::ChannelInfo;
use crate::load::names::role_names::{self, NAMES};
use crate::load::names::tokens::tokens;
use crate::load::names::words::plain_letters;
use crate::quantity::{Dimension, Role, Unit};

/// Ends of names that tell a unit, in small letters, longest first: behind a line, and right behind the name of a role.
static UNIT_ENDINGS: LazyLock<[Vec<(&str, &str)>; 2]> = LazyLock::new(|| {
    let units = role_names::read_words(include_str!("../../../../../assets/channel_names/unit_endings.txt"));
    let mut all: Vec<_> =
        units.into_iter().flat_map(|(unit, ends)| ends.into_iter().map(move |end| (end, unit))).collect();
    all.sort_by_key(|(end, _)| Reverse(end.len()));
    let (apart, glued) = all.into_iter().partition(|(end, _)| end.starts_with('_'));
    [apart, glued]
});

/// Ends of names that look like a unit and are a direction or an angle.
const NO_UNITS: &[&str] = &[
    "v_n", "vel_n", "velocity_n", "pos_n", "position_n", "angle_psi", "heading_psi", "yaw_psi", "euler_psi",
    "attitude_psi", "ahrs_psi", "ins_psi", "nav_psi",
];

/// A name without the unit it ends on, and that unit: `alpha` and degrees of `alpha_deg` or `alpha-deg`.
pub fn stem_and_unit(name: &str) -> (&str, Option<Unit>) {
    let lower = name.to_ascii_lowercase().replace('-', "_");
    let is_unit = !NO_UNITS.iter().any(|name| lower.ends_with(name));
    let known = |(ending, _): &&(&str, &str)| lower.len() > ending.len() && lower.ends_with(ending);
    let ending = UNIT_ENDINGS[0].iter().find(known).filter(|(ending, _)| is_unit && is_meant(ending, &lower));
    ending.map_or((name, None), |(ending, unit)| {
        (&name[..name.len() - ending.len()], Unit::parse(unit).ok().map(|unit| as_force(&lower, unit)))
    })
}

/// A direction, unless it is a force; a side, unless it is a temperature.
fn is_meant(ending: &str, lower: &str) -> bool {
    match ending {
        "_n" => is_force(lower),
        "_r" => {
            lower.contains("temp") || lower.split(['_', ' ']).any(|word| ["atmosphere", "oat", "tat"].contains(&word))
        }
        _ => true,
    }
}

/// Whether a name in small letters is one of a force.
fn is_force(lower: &str) -> bool {
    ["thrust", "thrst", "force", "drag", "lift", "schub"].iter().any(|force| lower.contains(force))
}

/// The unit of a force where the name says that it is one and the unit is the pound.
fn as_force(name: &str, unit: Unit) -> Unit {
    let pound = || Unit::parse("lbf").unwrap_or(unit);
    if unit.symbol == "lb" && is_force(&name.to_lowercase()) { pound() } else { unit }
}

/// Unit of a channel as recorded, or else as its name states it; `None` where neither states one that is known.
pub fn stated_unit(channel: &ChannelInfo) -> Option<Unit> {
    let recorded = channel.unit.as_deref().filter(|unit| !unit.is_empty());
    let stated = recorded.and_then(parse_loosely).or_else(|| name_and_unit(channel.label()).1)?;
    let stated = as_force(channel.label(), stated);
    // What is no time and in d is in degrees, as d/s is degrees per second.
    if stated.symbol == "d" && !channel.is_time { Unit::parse("deg").ok() } else { Some(stated) }
}

/// Words that follow the unit of a name and say which of several quantities or sensors it is: `heading_deg_true`, `altitude_ft_msl`.
const QUALIFIERS: [&str; 20] = [
    "true", "mag", "magnetic", "msl", "baro", "barometric", "gps", "std", "standard", "left", "right", "l", "r", "1",
    "2", "3", "4", "indicated", "sl", "wgs84",
];
/// Words before a last letter G that is the unit g.
const BEFORE_G: [&str; 8] = ["lateral", "vertical", "forward", "normal", "longitudinal", "axial", "side", "vert"];

/// A name without the unit in front of it, and that unit: `degrees/LAT`, `ft Baro/Alt`. A name that is a unit stays.
pub(crate) fn head_and_name(name: &str) -> (&str, Option<Unit>) {
    let whole = || (name, None);
    let Some((head, rest)) = name.split_once('/').map(|(head, rest)| (head.trim(), rest.trim())) else {
        return whole();
    };
    let is_path = rest.contains('/') || rest.is_empty() || head.len() < 2;
    if is_path || Unit::parse(name).is_ok() || parse_loosely(name).is_some() {
        return whole();
    }
    let first = head.split(' ').next().unwrap_or(head);
    let is_qualified = first != head && is_qualifier(head[first.len()..].trim());
    let unit = parse_loosely(if is_qualified { first } else { head }).filter(|unit| !is_count(*unit));
    unit.map_or_else(whole, |unit| (rest, Some(unit)))
}

fn is_qualifier(word: &str) -> bool {
    QUALIFIERS.contains(&word.to_lowercase().as_str())
}

/// A name whose unit stands before its qualifiers, without it, and that unit. One letter is a unit of an altitude alone.
fn split_qualified(name: &str) -> Option<(String, Unit)> {
    let mut end = name.len();
    while let Some(at) = name[..end].rfind(['_', ' ', '-']).filter(|at| is_qualifier(&name[at + 1..end])) {
        end = at;
    }
    let (before, qualifiers) = name.split_at(end);
    let is_letter = before.len() >= 2 && matches!(before.as_bytes()[before.len() - 2], b'_' | b' ' | b'-');
    if qualifiers.is_empty() || (is_letter && !before.to_lowercase().contains("alt")) {
        return None;
    }
    let unit_at = before.rfind(['_', ' ', '-'])?;
    let (stem, unit) = match stem_and_unit(before) {
        (stem, Some(unit)) => (stem, unit),
        _ => (&before[..unit_at], unit_word(&before[unit_at + 1..])?),
    };
    // A speed in rpm is named by its unit: `Eng_RPM_1`.
    (!stem.is_empty() && unit.symbol != "rpm").then(|| (format!("{stem}{qualifiers}"), unit))
}

/// Whether a name ends on the unit g behind a direction: `LateralG`.
fn ends_on_g(name: &str) -> bool {
    let all = tokens(name);
    matches!(&all[..], [.., before, last] if last == "g" && BEFORE_G.contains(&before.as_str()))
}

/// A name without the unit that it states in brackets, in front, at its end or before its axis, and that unit.
pub(crate) fn name_and_unit(name: &str) -> (String, Option<Unit>) {
    let (rest, head) = head_and_name(name.trim());
    if head.is_some() {
        return (rest.to_owned(), head);
    }
    let (name, recorded) = split_unit(name.trim());
    if let Some(unit) = recorded.as_deref().and_then(parse_loosely) {
        return (name.trim_end_matches(['_', ' ', '-']).to_owned(), Some(unit));
    }
    // The k of these is the unit.
    if ["ktas", "kcas", "kias", "keas"].contains(&plain_letters(&name).as_str()) {
        return (name, Unit::parse("kt").ok());
    }
    if ends_on_g(&name) {
        return (name, Unit::parse("g").ok());
    }
    if let Some((_, ending)) = name.rsplit_once(['_', ' ', '-'])
        && let Some(unit) = unit_word(ending)
        && role_names::is_known(&plain_letters(&name))
    {
        // `engine rpm`: the unit is a part of the name of its role.
        return (name, Some(unit));
    }
    let (stem, axis) = split_axis(&name);
    if let (stem, Some(unit)) = stem_and_unit(stem) {
        return (format!("{stem}{axis}"), Some(unit));
    }
    match stem.rsplit_once(['_', ' ', '-']).filter(|(before, _)| !before.trim().is_empty()) {
        Some((before, ending)) => match unit_word(ending) {
            Some(unit) => (format!("{}{axis}", before.trim_end()), Some(as_force(before, unit))),
            None => split_qualified(&name).map_or_else(|| split_glued(&name), |(stem, unit)| (stem, Some(unit))),
        },
        None => split_glued(&name),
    }
}

/// A name that is the one of a role and, right behind it, a unit that the role can have.
fn split_glued(name: &str) -> (String, Option<Unit>) {
    let plain = plain_letters(name);
    let split = |(ending, unit): &(&str, &str)| {
        let stem = plain.strip_suffix(ending).filter(|stem| !stem.is_empty())?;
        let unit = Unit::parse(unit).ok()?;
        let has = |(role, names): &(Role, &'static [&'static str])| {
            role.dimension() == unit.dimension && names.contains(&stem)
        };
        (!role_names::is_known(&plain) && NAMES.iter().any(has)).then(|| (stem.to_owned(), Some(unit)))
    };
    UNIT_ENDINGS[1].iter().find_map(split).unwrap_or_else(|| (name.to_owned(), None))
}

/// A name and the axis at its end: `[0]`, `_x`.
fn split_axis(name: &str) -> (&str, &str) {
    let index = name.strip_suffix(']').and_then(|name| name.rfind('['));
    let axis = || {
        name.len()
            .checked_sub(2)
            .filter(|at| ["_x", "_y", "_z", ".x", ".y", ".z"].iter().any(|axis| ends_alike(name, *at, axis)))
    };
    let word = || {
        let words = ["_north", "_east", "_down", "_up", "_roll", "_pitch", "_yaw"];
        words
            .iter()
            .filter_map(|word| name.len().checked_sub(word.len()).filter(|at| ends_alike(name, *at, word)))
            .next()
    };
    match index.or_else(axis).or_else(word) {
        Some(at) => name.split_at(at),
        None => (name, ""),
    }
}

/// Whether `name` is `end` from `at` on, in whatever letters.
fn ends_alike(name: &str, at: usize, end: &str) -> bool {
    name.get(at..).is_some_and(|rest| rest.eq_ignore_ascii_case(end))
}

/// The unit that the last word of a name is, where it can be nothing else.
fn unit_word(word: &str) -> Option<Unit> {
    /// Words that are units of no role, or words of their own.
    const WORDS: [&str; 10] = ["in", "nm", "mi", "mm", "gal", "min", "ratio", "none", "kp", "grad"];
    let unit = (word.len() > 1 && !WORDS.contains(&word.to_lowercase().as_str())).then(|| parse_loosely(word))??;
    (unit.dimension != Dimension::Time && !is_count(unit)).then_some(unit)
}

/// The unit of a text as recorders write them: `DEGpSEC`, `degpers`, `rad s^-1`, `meters/second`, `ft-lbs/sec`.
pub(crate) fn parse_loosely(text: &str) -> Option<Unit> {
    /// Words for parts of a unit.
    const PARTS: [(&str, &str); 20] = [
        ("degrees", "deg"),
        ("degree", "deg"),
        ("radians", "rad"),
        ("radian", "rad"),
        ("metres", "m"),
        ("meters", "m"),
        ("metre", "m"),
        ("meter", "m"),
        ("feet", "ft"),
        ("foot", "ft"),
        ("knots", "kt"),
        ("seconds", "s"),
        ("second", "s"),
        ("secs", "s"),
        ("sec", "s"),
        ("minute", "min"),
        ("fts", "ft/s"),
        (" per ", "/"),
        ("squared", "^2"),
        ("kilometers", "km"),
    ];
    let text = text.trim();
    if let Ok(unit) = Unit::parse(text) {
        return Some(unit);
    }
    // `deg TEU`: the direction is no part of the unit.
    if has_direction(text) {
        return split_direction(text).and_then(|(before, _)| Unit::parse(before).ok());
    }
    let mut plain = text.to_lowercase();
    for (word, unit) in PARTS {
        plain = plain.replace(word, unit);
    }
    let plain = plain.replace(" s^-2", "/s^2").replace(" s^-1", "/s").replace(" s-2", "/s^2").replace(" s-1", "/s");
    let plain = plain.replace("s/s", "s^2").replace("perspers", "/s^2").replace("pers^2", "/s^2").replace(' ', "");
    let per = ["degpers", "radpers", "degps", "radps", "mpers", "ftpers", "mps", "ftps"]
        .iter()
        .find(|word| plain.starts_with(*word));
    let plain = match per {
        Some(word) => {
            let stem = word.trim_end_matches('s').trim_end_matches("per").trim_end_matches('p');
            format!(
                "{stem}/s{}",
                plain[word.len()..].replacen(|sign: char| sign.is_ascii_digit(), "^2", 1).replace("^^", "^")
            )
        }
        None => plain,
    };
    Unit::parse(&plain).ok()
}

/// Whether a unit says which way is positive, or from which north it counts: `deg TEU`, `deg T`.
fn has_direction(text: &str) -> bool {
    const EDGES: [&str; 4] = ["teu", "ted", "te up", "te down"];
    const NORTHS: [&str; 5] = ["t", "m", "true", "mag", "magnetic"];
    let Some((unit, direction)) = split_direction(text) else { return false };
    let direction = direction.to_lowercase();
    Unit::parse(unit).is_ok_and(|unit| {
        EDGES.contains(&direction.as_str())
            || (unit.dimension == Dimension::Angle && NORTHS.contains(&direction.as_str()))
    })
}

/// Whether a deflection in this unit is still to be calibrated: volts, counts.
pub(crate) fn is_signal_unit(unit: &str) -> bool {
    const SIGNALS: [&str; 14] =
        ["v", "mv", "volt", "volts", "ma", "counts", "count", "cnt", "ticks", "lsb", "bits", "raw", "pwm", "digits"];
    SIGNALS.contains(&unit.trim().to_lowercase().as_str())
}

/// The first word of a unit and what follows it.
fn split_direction(text: &str) -> Option<(&str, &str)> {
    let (unit, direction) = text.split_once([' ', ','])?;
    Some((unit, direction.trim()))
}

/// Whether a recorded unit says no more than that there is none.
pub(crate) fn is_count(unit: Unit) -> bool {
    unit.dimension == Dimension::Dimensionless && unit.scale == 1.0
}

/// A unit without the brackets about it.
pub(crate) fn bare(unit: &str) -> String {
    unit.trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim().to_owned()
}

/// Name and unit of a header cell `alpha [deg]`, `alpha (deg)`, `elevator (deg TEU)`, `alpha, deg` or `alpha`. What is no unit stays in the name.
pub(crate) fn split_unit(cell: &str) -> (String, Option<String>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        let Some((name, unit)) = cell.strip_suffix(close).and_then(|cell| cell.rsplit_once(open)) else { continue };
        let is_index = unit.bytes().all(|byte| byte.is_ascii_digit());
        let is_unit = || open == '[' || Unit::parse(unit).is_ok() || has_direction(unit) || is_signal_unit(unit);
        if !name.is_empty() && !is_index && is_unit() {
            return (name.trim().to_owned(), Some(unit.trim().to_owned()));
        }
    }
    if let Some((name, unit)) = cell.rsplit_once(',').map(|(name, unit)| (name.trim(), unit.trim()))
        && !name.is_empty()
        && Unit::parse(unit).is_ok_and(|unit| unit.symbol != "-")
    {
        return (name.to_owned(), Some(unit.to_owned()));
    }
    (cell.to_owned(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_as_recorders_write_them() {
        for (text, wanted) in [
            ("DEGpSEC", Some("deg/s")),
            ("degpers", Some("deg/s")),
            ("rad s^-1", Some("rad/s")),
            ("m s^-2", Some("m/s^2")),
            ("fts^2", Some("ft/s^2")),
            ("meters/second", Some("m/s")),
            ("feet per minute", Some("ft/min")),
            ("Deg C", Some("degC")),
            ("deg TEU", Some("deg")),
            ("deg, TE up", Some("deg")),
            ("deg T", Some("deg")),
            ("degrees Magnetic", Some("deg")),
            ("m T", None),
            ("flags", None),
        ] {
            assert_eq!(parse_loosely(text).map(|unit| unit.symbol), wanted, "{text}");
        }
    }

    #[test]
    fn units_are_found_in_brackets_at_the_end_and_before_the_axis() {
        for (name, stem, wanted) in [
            ("V_cas[kts]", "V_cas", Some("kt")),
            ("pitch_angle_[deg]", "pitch_angle", Some("deg")),
            ("alt_ftmsl", "alt", Some("ft")),
            ("gyro_radps_x", "gyro_x", Some("rad/s")),
            ("accelerometer_m_s2[0]", "accelerometer[0]", Some("m/s^2")),
            ("rollrate-DEGpSEC", "rollrate", Some("deg/s")),
            ("roll_in", "roll_in", None),
            ("alphadeg", "alpha", Some("deg")),
            ("KTAS", "KTAS", Some("kt")),
            ("pdegs", "p", Some("deg/s")),
            ("left", "left", None),
            ("vel_n_ms", "vel_n", Some("m/s")),
            ("feVelocity_ft_s_X", "feVelocity_X", Some("ft/s")),
            ("airDensity_slug_ft3", "airDensity", Some("slug/ft^3")),
            ("p-rad_sec", "p", Some("rad/s")),
            ("column[11]", "column[11]", None),
            ("heading_deg_true", "heading_true", Some("deg")),
            ("Course_Degrees_Magnetic", "Course_Magnetic", Some("deg")),
            ("altitude_ft_msl", "altitude_msl", Some("ft")),
            ("height_ft_agl", "height_ft_agl", None),
            ("rudder_deg_left_2", "rudder_left_2", Some("deg")),
            ("pos_n_gps", "pos_n_gps", None),
            ("Eng_RPM_1", "Eng_RPM_1", None),
            ("degrees/LAT", "LAT", Some("deg")),
            ("ft Baro/AltB", "AltB", Some("ft")),
            ("rad/s", "rad/s", None),
            ("velocities/p", "velocities/p", None),
            ("Q_dot_dps2", "Q_dot", Some("deg/s^2")),
            ("density_kgpm3", "density", Some("kg/m^3")),
            ("Acceleration_X_mperspers", "Acceleration_X", Some("m/s^2")),
            ("Gyro_X_degreespers", "Gyro_X", Some("deg/s")),
            ("AirTemperature_r", "AirTemperature", Some("degR")),
            ("delta_r", "delta_r", None),
            ("Flap_%", "Flap", Some("%")),
            ("thrust_lb", "thrust", Some("lbf")),
            ("fuel_lbs", "fuel", Some("lb")),
            ("LateralG", "LateralG", Some("g")),
        ] {
            let (found, unit) = name_and_unit(name);
            assert_eq!((found.as_str(), unit.map(|unit| unit.symbol)), (stem, wanted), "{name}");
        }
    }

    #[test]
    fn a_direction_at_the_end_of_a_name_is_no_unit() {
        for name in ["v_n", "gps_vel_n", "pos_N", "heading_psi"] {
            assert_eq!(stem_and_unit(name), (name, None));
        }
        let (stem, unit) = stem_and_unit("thrust_n");
        assert_eq!((stem, unit.map(|unit| unit.dimension)), ("thrust", Some(Dimension::Force)));
    }
}
