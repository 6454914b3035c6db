//! Tokens of channel names: a role is found by whole tokens, never by a part of one, and some tokens forbid every role.

use crate::load::names::words::plain_letters;

/// Tokens of what is not a measurement of the aircraft: demands, states of estimators, flags, statistics, the operator's hands.
const FORBIDDEN: &[&str] = &[
    "setpoint", "setpoints", "setting", "settings", "sp", "ref", "reference", "target", "targets", "tgt", "desired",
    "des", "demand", "demanded", "dem", "cmd", "cmds", "command", "commanded", "commands", "consigne", "cible", "goal",
    "want", "wanted", "request", "requested", "selected", "sel", "preselect", "fms", "mcp", "bug", "bias", "biases",
    "variance", "var", "covariance", "covariances", "cov", "innov", "innovation", "innovations", "residual",
    "residuals", "ratio", "flag", "flags", "status", "fault", "faults", "fail", "failed", "failure", "reset", "resets",
    "count", "counter", "timeout", "valid", "validity", "validated", "invalid", "error", "err", "errors", "saturation",
    "saturated", "std", "stddev", "stdev", "sigma", "rms", "sd", "integ", "integrator", "gain", "gains", "uncertainty",
    "accuracy", "quality", "health", "healthy", "enabled", "enable", "mode", "state", "stick", "sticks", "pedal",
    "pedals", "yoke", "joystick", "rc", "pilot", "home", "waypoint", "wp", "gimbal", "camera", "cam", "max", "min",
    "hover", "maximum", "minimum", "limit", "limits", "wind", "gust", "turbulence", "controller", "integral",
    "permanent", "battery", "bat", "voltage", "delta", "diff", "hedef", "increment", "jacobian", "predicted",
    "prediction", "pred", "origin", "offset", "rssi", "sats", "satellites", "checksum", "crc", "seq", "sequence", "id",
    "index", "idx", "inertial", "ecef", "apu", "external", "electric", "generator", "pump", "force", "forces",
    "moment", "moments", "lift", "drag", "energy", "terrain", "elevation", "radar", "radio", "agl", "ftagl", "runway",
    "shield", "box", "cpu", "board", "egt", "cht", "oil", "tit", "itt", "heater", "coolant", "glideslope", "localizer",
    "ils", "vor", "ndb", "adf", "dme", "crosstrack", "xtrack", "magvar", "declination",
];
/// Tokens that name no quantity of their own.
const FILLERS: &[&str] = &[
    "measured", "meas", "sensor", "sensors", "body", "b", "imu", "ahrs", "ins", "adc", "est", "estimated", "estimate",
    "filtered", "filt", "smoothed", "smooth", "value", "val", "data", "field", "actual", "act", "sim", "aircraft",
    "ac", "uav", "plane", "vehicle", "flight", "nav", "of", "is", "recorded", "corr", "corrected", "derived", "calc",
    "calculated", "signal", "channel", "ch", "compass", "fdr", "qar", "dadc", "irs", "iru", "adiru", "efis", "state",
    "states", "pitot", "vane", "boom", "srf", "egi", "surf",
];
/// Tokens that forbid unless they are part of one of these names.
const ALLOWED: &[(&str, &[&str])] = &[
    ("delta", &["deltaa", "deltae", "deltar", "deltate", "deltaf", "deltal", "deltam", "deltan"]),
    ("std", &["altitudestd", "altistd", "altstd", "stdaltitude"]),
    ("force", &["specificforce", "gforce"]),
    ("diff", &["diffpress", "pressdiff", "pressurediff"]),
    ("pilot", &["pilotx", "piloty", "pilotz"]),
    ("runway", &["onrunway"]),
    ("inertial", &["inertialvert", "inertialroll", "inertialpitch", "inertialyaw"]),
];

/// Forbidden tokens that name an instrument where they stand in the name of a source: inertial axes and the inertial unit.
pub(crate) const OF_SOURCES: [&str; 1] = ["inertial"];

/// A name cut into tokens, in small letters without accents.
pub(crate) fn tokens(name: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let letters: Vec<char> = name.chars().collect();
    let mut word = String::new();
    for (at, &letter) in letters.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| letters[before]);
        let after = letters.get(at + 1);
        let is_break = before.is_some_and(|before| {
            !letter.is_alphanumeric()
                || (before.is_lowercase() && letter.is_uppercase())
                || (before.is_numeric() != letter.is_numeric())
                || (before.is_uppercase() && letter.is_uppercase() && after.is_some_and(|after| after.is_lowercase()))
        });
        if is_break {
            push(&mut all, &mut word);
        }
        word.push(letter);
    }
    push(&mut all, &mut word);
    all
}

fn push(all: &mut Vec<String>, word: &mut String) {
    let plain = plain_letters(word);
    word.clear();
    if !plain.is_empty() {
        all.push(plain);
    }
}

/// The token of a name that forbids it every role.
pub(crate) fn forbidden(name: &str) -> Option<&'static str> {
    let all = tokens(name);
    let joined = all.concat();
    // A state vector's name stands before its parts.
    let is_before = |token: &str| {
        token == "state"
            && all.last().is_some_and(|last| last != "state" && last.bytes().any(|b| b.is_ascii_alphabetic()))
    };
    let is_allowed = |token: &str| {
        is_before(token)
            || ALLOWED.iter().any(|(known, names)| *known == token && names.iter().any(|name| joined.contains(name)))
    };
    FORBIDDEN.iter().find(|token| all.iter().any(|other| other == *token) && !is_allowed(token)).copied()
}

/// Tokens without those that name no quantity, joined; nothing where no other is there.
pub(crate) fn essence(all: &[String]) -> String {
    all.iter().filter(|token| !FILLERS.contains(&token.as_str())).map(String::as_str).collect()
}

/// Whether `all`, joined, end on `name` where a token begins.
pub(crate) fn end_on(all: &[String], name: &str) -> bool {
    (0..all.len()).any(|from| all[from..].concat() == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cut_where_signs_capitals_and_digits_part_them() {
        for (name, wanted) in [
            ("pre_flt_fail", &["pre", "flt", "fail"][..]),
            ("bLongAcc", &["b", "long", "acc"]),
            ("GPSAlt", &["gps", "alt"]),
            ("column[11]", &["column", "11"]),
            ("V_{Total}", &["v", "total"]),
            ("measuredRollRate", &["measured", "roll", "rate"]),
            ("Höhe_MSL", &["hohe", "msl"]),
        ] {
            assert_eq!(tokens(name), wanted, "{name}");
        }
    }

    #[test]
    fn tokens_of_demands_flags_and_statistics_forbid() {
        for name in
            ["target_alt", "gyro_bias[0]", "pre_flt_fail", "beta_innov", "rollCommand", "rc_aileron", "max_altitude"]
        {
            assert!(forbidden(name).is_some(), "{name}");
        }
        for name in ["delta_e", "Altitude STD", "status_free_roll_x", "IAS", "flaps", "specific_x"] {
            assert_eq!(forbidden(name).is_some(), name.starts_with("status"), "{name}");
        }
    }

    #[test]
    fn a_name_ends_on_whole_tokens_only() {
        assert!(end_on(&tokens("imu_accel_x"), "accelx") && end_on(&tokens("gps_alt"), "alt"));
        assert!(!end_on(&tokens("bias"), "ias") && !end_on(&tokens("column[11]"), "n11"));
        assert_eq!(essence(&tokens("measuredRollRate")), "rollrate");
    }
}
