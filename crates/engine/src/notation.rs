//! How quantities are written for people: Greek symbols, subscripts, and the units engineers read.

use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::{Measurement, State};
use doublet_core::validate::Signal;

/// A number of things in words: `1 window`, `3 windows`.
pub fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// `value` with so many significant digits and a true minus sign; a dash where there is no number.
pub fn significant(value: f64, digits: usize) -> String {
    format_number(value, digits, -3..6).map_or_else(|| "–".to_owned(), |text| text.replace('-', "\u{2212}"))
}

/// `value` with so many significant digits, with a power of ten where that is not among `plain`; `None` where there is no number.
pub fn format_number(value: f64, digits: usize, plain: std::ops::Range<i32>) -> Option<String> {
    // The exponent of the rounded number: 9.9996 is 10.00 in four digits.
    let rounded = format!("{value:.*e}", digits.saturating_sub(1));
    let exponent: i32 = rounded.split_once('e')?.1.parse().ok()?;
    let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
    Some(match value {
        0.0 => "0".to_owned(),
        _ if plain.contains(&exponent) => format!("{value:.decimals$}"),
        _ => rounded,
    })
}

/// `value` to the second digit of its error; where that is beyond six decimals or not known to four significant digits.
pub fn format_by_error(value: f64, error: f64) -> String {
    const MOST_DECIMALS: usize = 6;
    let decimals = if error.is_finite() && error != 0.0 { decimals_of_error(error) } else { usize::MAX };
    match decimals {
        decimals if decimals <= MOST_DECIMALS && value.is_finite() => {
            format!("{value:.decimals$}").replace('-', "\u{2212}")
        }
        _ => significant(value, 4),
    }
}

/// Decimals of a number with this error: the error has two digits.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of decimals")]
pub fn decimals_of_error(error: f64) -> usize {
    (1.0 - error.abs().log10().floor()).max(0.0) as usize
}

/// Unit a dimension is shown in, and its factor from SI.
pub fn unit(dimension: Dimension) -> (&'static str, f64) {
    let degrees = 180.0 / std::f64::consts::PI;
    match dimension {
        Dimension::Dimensionless => ("", 1.0),
        Dimension::Angle => ("deg", degrees),
        Dimension::AngularRate => ("deg/s", degrees),
        Dimension::AngularAcceleration => ("deg/s²", degrees),
        Dimension::Acceleration => ("m/s²", 1.0),
        Dimension::Pressure => ("hPa", 1e-2),
        Dimension::Density => ("kg/m³", 1.0),
        Dimension::Power => ("kW", 1e-3),
        Dimension::Volume => ("m³", 1.0),
        Dimension::VolumeFlow => ("m³/s", 1.0),
        Dimension::Length
        | Dimension::Speed
        | Dimension::Time
        | Dimension::Mass
        | Dimension::MassFlow
        | Dimension::Force
        | Dimension::Temperature => (dimension.si_symbol(), 1.0),
    }
}

/// Unit in which a number of the SI unit `symbol` is shown, and its factor from SI, where people read it otherwise than it is kept:
/// angles in degrees, powers in kilowatts.
pub fn shown(symbol: &str) -> Option<(&'static str, f64)> {
    use Dimension::{Acceleration, Angle, AngularAcceleration, AngularRate, Power};
    let dimensions = [Angle, AngularRate, AngularAcceleration, Acceleration, Power];
    dimensions.into_iter().find(|dimension| dimension.si_symbol() == symbol).map(unit)
}

/// Unit a role is shown in: engine speeds in revolutions per minute, the rest by dimension.
pub fn role_unit(role: Role) -> (&'static str, f64) {
    match role {
        Role::EngineSpeed1 | Role::EngineSpeed2 => ("rpm", 60.0 / std::f64::consts::TAU),
        _ => unit(role.dimension()),
    }
}

/// Symbol of a role.
pub fn role(role: Role) -> &'static str {
    match role {
        Role::RollAcceleration => "ṗ",
        Role::PitchAcceleration => "q̇",
        Role::YawAcceleration => "ṙ",
        Role::VelocityNorth => "Vn",
        Role::VelocityEast => "Ve",
        Role::VelocityDown => "Vd",
        Role::BankAngle => "φ",
        Role::PitchAngle => "θ",
        Role::HeadingAngle => "ψ",
        Role::TrueAirspeed => "V",
        Role::AngleOfAttack => "α",
        Role::Sideslip => "β",
        Role::Aileron => "δa",
        Role::Elevator => "δe",
        Role::Rudder => "δr",
        Role::ElevatorTrim => "δte",
        Role::Altitude => "h",
        Role::AirDensity => "ρ",
        Role::StaticPressure => "static pressure",
        Role::AirTemperature => "air temperature",
        Role::TotalTemperature => "total temperature",
        Role::CalibratedAirspeed => "calibrated airspeed",
        Role::EquivalentAirspeed => "equivalent airspeed",
        Role::ImpactPressure => "impact pressure",
        Role::GpsAltitude => "GPS altitude",
        Role::FuelMass => "fuel mass",
        Role::FuelFlow => "fuel flow",
        Role::Thrust1 => "thrust 1",
        Role::Thrust2 => "thrust 2",
        Role::EngineSpeed1 => "engine speed 1",
        Role::EngineSpeed2 => "engine speed 2",
        Role::ManifoldPressure1 => "manifold pressure 1",
        Role::ManifoldPressure2 => "manifold pressure 2",
        Role::Power1 => "power 1",
        Role::Power2 => "power 2",
        other => other.name(),
    }
}

/// Symbol of the role called `name`; a name that no role has as it is.
pub fn role_symbol(name: &str) -> &str {
    match Role::from_name(name) {
        Some(found) => role(found),
        None => name,
    }
}

/// Symbol of a state.
pub fn state(state: State) -> &'static str {
    match state {
        State::PositionNorth => "x",
        State::PositionEast => "y",
        State::PositionDown => "z",
        State::VelocityU => "u",
        State::VelocityV => "v",
        State::VelocityW => "w",
        State::BankAngle => "φ",
        State::PitchAngle => "θ",
        State::HeadingAngle => "ψ",
        State::BiasAx => "bias ax",
        State::BiasAy => "bias ay",
        State::BiasAz => "bias az",
        State::BiasP => "bias p",
        State::BiasQ => "bias q",
        State::BiasR => "bias r",
        State::WindNorth => "wind north",
        State::WindEast => "wind east",
        State::WindDown => "wind down",
    }
}

/// Symbol of a history that is compared with a flight, for axes too short for its name.
pub fn signal(signal: Signal) -> &'static str {
    match signal {
        Signal::Airspeed => "V",
        Signal::Altitude => "h",
        Signal::AngleOfAttack => "α",
        Signal::Sideslip => "β",
        Signal::BankAngle => "φ",
        Signal::PitchAngle => "θ",
        Signal::HeadingAngle => "ψ",
        Signal::RollRate => "p",
        Signal::PitchRate => "q",
        Signal::YawRate => "r",
        Signal::SpecificForceX => "ax",
        Signal::SpecificForceY => "ay",
        Signal::NormalAcceleration => "n",
    }
}

/// Symbol of a measurement.
pub fn measurement(measurement: Measurement) -> &'static str {
    role(measurement.role())
}

/// `alpha_dot` as `α̇`, `delta_e` as `δe`: names of derivatives and terms with Greek letters.
fn greek(name: &str) -> String {
    let mut text = name.replace("alpha_dot", "α̇").replace("beta_dot", "β̇");
    for (word, letter) in [("alpha", "α"), ("beta", "β"), ("delta_", "δ"), ("mach", "M"), ("dpt", "Δpₜ")] {
        text = text.replace(word, letter);
    }
    text
}

/// Symbol and unit of a parameter of a low-order equivalent system, called as the results call it.
pub fn system_parameter(name: &str) -> (String, &'static str) {
    let fixed = match name {
        "inv_Ttheta2" => Some(("1/Tθ₂", "1/s")),
        "T_theta2" => Some(("Tθ₂", "s")),
        "omega_Ttheta2" => Some(("ω·Tθ₂", "")),
        "zeta_omega" => Some(("ζ·ω", "rad/s")),
        "T_R" => Some(("T_R", "s")),
        "tau" => Some(("τ", "s")),
        "phase_delay" => Some(("phase delay", "s")),
        "omega_180" => Some(("ω₁₈₀", "rad/s")),
        "bandwidth" => Some(("bandwidth", "rad/s")),
        _ => None,
    };
    let with = |letter: &str, prefix: &str| Some(format!("{letter}{}", name.strip_prefix(prefix)?));
    let of_kind = || {
        let kinds = [
            ("ω", "omega", "rad/s"),
            ("ζ", "zeta", ""),
            ("1/T", "inv_T", "1/s"),
            ("c₁", "c1", "1/s"),
            ("c₀", "c0", "1/s²"),
        ];
        kinds.into_iter().find_map(|(letter, prefix, unit)| Some((with(letter, prefix)?, unit)))
    };
    fixed.map(|(symbol, unit)| (symbol.to_owned(), unit)).or_else(of_kind).unwrap_or_else(|| (name.to_owned(), ""))
}

/// A quantity of the sensitivity study, called as the results call it, in words.
pub fn sensitivity_quantity(name: &str) -> &str {
    match name {
        "x_cg" => "CG aft",
        "y_cg" => "CG right",
        "z_cg" => "CG up",
        "delta_e" => "elevator scale",
        "delta_a" => "aileron scale",
        "delta_r" => "rudder scale",
        "alpha" => "α scale",
        "beta" => "β scale",
        other => other,
    }
}

/// A unit or a text with its powers as they are printed: `m/s²` for `m/s^2`.
pub fn raise_powers(text: &str) -> String {
    text.replace("^2", "²").replace("^3", "³")
}

/// A term such as `qc/V` or `alpha^2*delta_e` as it is printed: `qc/V`, `α²·δe`.
pub fn term(name: &str) -> String {
    greek(&raise_powers(name).replace('*', "·"))
}

/// A derivative such as `Cm_delta_e` split into its letter, its subscript and what follows: `C`, `mδe`, ``.
pub fn derivative_parts(name: &str) -> (String, String, String) {
    let (symbol, suffix) = name.split_once('[').map_or((name, String::new()), |(a, b)| (a.trim(), format!(" [{b}")));
    let (coefficient, variables) = symbol.split_once('_').unwrap_or((symbol, ""));
    let (letter, axis) = coefficient.split_at(coefficient.len().min(1));
    let variables = greek(variables).replace("qhat", "q̂").replace('_', "").replace('2', "²").replace('3', "³");
    (letter.to_owned(), format!("{axis}{variables}"), suffix)
}

/// A derivative as plain text: `Cmδe`.
pub fn derivative(name: &str) -> String {
    let (letter, subscript, suffix) = derivative_parts(name);
    format!("{letter}{subscript}{suffix}")
}

/// Whether a character changes the direction of the text behind it.
pub fn is_direction_mark(letter: char) -> bool {
    matches!(letter, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        for (value, digits, expected) in [
            (-0.012_345_6, 4, "\u{2212}0.01235"),
            (123_456.7, 4, "123457"),
            (1.234e-5, 3, "1.23e\u{2212}5"),
            (9.9996, 4, "10.00"),
            (0.0, 4, "0"),
            (f64::INFINITY, 4, "–"),
            (2.5e7, 2, "2.5e7"),
        ] {
            assert_eq!(significant(value, digits), expected);
        }
    }

    #[test]
    fn derivatives_and_terms_are_written_in_greek() {
        assert_eq!(derivative_parts("Cm_delta_e"), ("C".into(), "mδe".into(), String::new()));
        assert_eq!(derivative("CX_alpha2"), "CXα²");
        assert_eq!(derivative("CZ_0 [e1]"), "CZ0 [e1]");
        assert_eq!(derivative("CZ_0[03 delta_e]"), "CZ0 [03 delta_e]");
        assert_eq!(derivative("Cm_alpha_dot"), "Cmα̇");
        assert_eq!(derivative("Cm_qhat"), "Cmq̂");
        assert_eq!(term("alpha^2*delta_e"), "α²·δe");
        assert_eq!(term("pb/2V"), "pb/2V");
    }

    #[test]
    fn parameters_of_equivalent_systems_have_symbols_and_units() {
        for (name, symbol, unit) in [
            ("K", "K", ""),
            ("omega", "ω", "rad/s"),
            ("zeta_z1", "ζ_z1", ""),
            ("inv_TR", "1/TR", "1/s"),
            ("inv_Ttheta2", "1/Tθ₂", "1/s"),
            ("omega_Ttheta2", "ω·Tθ₂", ""),
            ("tau", "τ", "s"),
        ] {
            assert_eq!(system_parameter(name), (symbol.to_owned(), unit));
        }
    }
}
