//! Words beside a name that make another quantity of it: `gyro_roll` is no bank angle, `CN_delta_r` no rudder.

use crate::quantity::Role;

/// Words that make another quantity of any name.
const OF_ANY: [&str; 22] = [
    "engine", "equivalent", "prop", "propeller", "rotor", "servo", "gear", "trim", "tail", "nose", "fuel", "surface",
    "skin", "cabin", "density", "cl", "cd", "cm", "cn", "cx", "cy", "cz",
];
/// Words that make a rate of an angle of attitude.
const OF_ATTITUDE: [&str; 15] = [
    "gyro", "gyr", "rate", "rates", "omega", "vel", "velocity", "angvel", "angular", "dot", "speed", "acc", "accel",
    "acceleration", "derivative",
];
/// Words that make of roll, pitch and yaw what a controller puts in and out, or the attitude of something else.
const OF_AXIS: [&str; 28] = [
    "input", "inputs", "out", "output", "outputs", "pid", "ff", "torque", "tau", "set", "prev", "last", "init", "ctrl",
    "control", "actuator", "mixer", "stk", "pwm", "rx", "tx", "joy", "nozzle", "mount", "mnt", "antenna", "tracker",
    "sun",
];
/// The same in single letters, at the beginning: the parts of a controller, an error, a derivative.
const LETTERS_OF_AXIS: [&str; 4] = ["d", "e", "i", "p"];
/// Words that make a velocity or an acceleration of a position.
const OF_POSITION: [&str; 10] =
    ["vel", "velocity", "velned", "v", "speed", "rate", "acc", "accel", "acceleration", "dot"];
/// Words that make a force of a latitude or longitude: `AccelLat` is lateral.
const OF_PLACE: [&str; 8] = ["acc", "accel", "acceleration", "g", "lin", "vel", "velocity", "load"];
/// Words that make an extreme, a height above something else or of something else of an altitude.
const OF_ALTITUDE: [&str; 17] = [
    "peak", "apogee", "start", "initial", "init", "ground", "gnd", "takeoff", "base", "next", "fence", "cruise",
    "range", "rangefinder", "lidar", "sonar", "tof",
];
/// Words that make a constant of a filter or a rate of a flow angle.
const OF_FLOW: [&str; 12] =
    ["baro", "lpf", "filter", "ema", "kalman", "madgwick", "comp", "complementary", "rate", "iir", "fusion", "dot"];
/// Words that make another pressure of a static one.
const OF_PRESSURE: [&str; 12] = [
    "pitot", "diff", "differential", "total", "impact", "dynamic", "tire", "tyre", "brake", "hydraulic", "manifold",
    "water",
];
/// Words that make a count of satellites of a static air temperature.
const OF_TEMPERATURE: [&str; 8] = ["n", "num", "gps", "gnss", "used", "01", "02", "03"];
/// Words that make a part of the full one of a power.
const OF_POWER: [&str; 8] = ["percent", "pct", "tx", "rf", "signal", "radio", "rx", "level"];

/// Words that make another quantity of a name of `role`.
fn list_words_of(role: Role) -> &'static [&'static str] {
    match role {
        Role::BankAngle | Role::PitchAngle | Role::HeadingAngle => &OF_ATTITUDE,
        Role::PositionNorth | Role::PositionEast | Role::PositionDown => &OF_POSITION,
        Role::Latitude | Role::Longitude => &OF_PLACE,
        Role::Altitude | Role::GpsAltitude => &OF_ALTITUDE,
        Role::AngleOfAttack | Role::Sideslip => &OF_FLOW,
        Role::StaticPressure => &OF_PRESSURE,
        Role::AirTemperature => &OF_TEMPERATURE,
        Role::Power1 | Role::Power2 => &OF_POWER,
        _ => &[],
    }
}

/// Whether the tokens of a channel's name beside `name`, which is one of `role`, make another quantity of it.
pub(crate) fn is_other_quantity(role: Role, tokens: &[String], name: &str) -> bool {
    let from = (0..tokens.len()).rev().find(|from| tokens[*from..].concat().starts_with(name)).unwrap_or(0);
    let before = &tokens[..from];
    let has_own =
        |token: &str| name.contains(token) || ["rpm", "power", "thrust"].iter().any(|engine| name.contains(engine));
    let is_axis = matches!(role, Role::BankAngle | Role::PitchAngle | Role::HeadingAngle)
        && ["roll", "pitch", "yaw"].iter().any(|axis| name.contains(axis));
    // A directional gyro shows the heading.
    let is_compass = |token: &str| token == "gyro" && (name.contains("head") || name.contains("hdg"));
    let of_role = list_words_of(role);
    let is_of = |words: &[&str]| {
        tokens
            .iter()
            .any(|token| words.contains(&token.as_str()) && !name.contains(token.as_str()) && !is_compass(token))
    };
    before.iter().any(|token| OF_ANY.contains(&token.as_str()) && !has_own(token))
        || is_of(of_role)
        || (is_axis && is_of(&OF_AXIS))
        || (is_axis && before.first().is_some_and(|token| LETTERS_OF_AXIS.contains(&token.as_str())))
}

/// Whether words say that a controller puts it in or out.
pub(crate) fn is_of_controller(words: &[String]) -> bool {
    words.iter().any(|word| OF_AXIS.contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::names::tokens::tokens;

    #[test]
    fn a_word_beside_a_name_makes_another_quantity_of_it() {
        for (role, channel, name, is_other) in [
            (Role::BankAngle, "gyro_roll", "roll", true),
            (Role::BankAngle, "ahrs_roll", "roll", false),
            (Role::BankAngle, "d_roll", "roll", true),
            (Role::BankAngle, "out.phi", "phi", false),
            (Role::HeadingAngle, "gyro heading", "heading", false),
            (Role::HeadingAngle, "AngularRateYaw", "yaw", true),
            (Role::PositionNorth, "VelNedNorth", "north", true),
            (Role::PositionNorth, "local_north", "north", false),
            (Role::Latitude, "vnAccelLat", "lat", true),
            (Role::Latitude, "gps_lat", "lat", false),
            (Role::Altitude, "PeakAlt", "alt", true),
            (Role::AngleOfAttack, "baro_alpha", "alpha", true),
            (Role::AngleOfAttack, "vane_alpha", "alpha", false),
            (Role::Rudder, "CN_delta_r", "deltar", true),
            (Role::StaticPressure, "pitot_press", "press", true),
            (Role::Power1, "PercentPower", "power", true),
        ] {
            assert_eq!(is_other_quantity(role, &tokens(channel), name), is_other, "{channel}");
        }
    }
}
