//! How quantities are written on screen: Greek symbols, subscripts, and the units engineers read.

use doublet_core::quantity::{Dimension, Role};
use doublet_core::reconstruct::{Measurement, State};
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{self, Align, FontId};
use serde::{Deserialize, Serialize};

use crate::widgets::quantity_edit::concise;

/// Units quantities are shown and typed in; files and the engine keep SI and radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Units {
    /// Metres, metres per second, degrees.
    #[default]
    Metric,
    /// Knots, feet, degrees.
    Aviation,
    /// SI and radians throughout.
    Si,
}

impl Units {
    /// Unit a dimension is shown in, and its factor from SI.
    pub fn of(self, dimension: Dimension) -> (&'static str, f64) {
        let degrees = 180.0 / std::f64::consts::PI;
        match (dimension, self) {
            (Dimension::Dimensionless, _) => ("", 1.0),
            (Dimension::Angle, Self::Si) => ("rad", 1.0),
            (Dimension::AngularRate, Self::Si) => ("rad/s", 1.0),
            (Dimension::AngularAcceleration, Self::Si) => ("rad/s²", 1.0),
            (Dimension::Pressure, Self::Si) => ("Pa", 1.0),
            (Dimension::Power, Self::Si) => ("W", 1.0),
            (Dimension::Angle, _) => ("deg", degrees),
            (Dimension::AngularRate, _) => ("deg/s", degrees),
            (Dimension::AngularAcceleration, _) => ("deg/s²", degrees),
            (Dimension::Pressure, _) => ("hPa", 1e-2),
            (Dimension::Power, _) => ("kW", 1e-3),
            (Dimension::Length, Self::Aviation) => ("ft", 1.0 / 0.3048),
            (Dimension::Speed, Self::Aviation) => ("kt", 3600.0 / 1852.0),
            (Dimension::Acceleration, _) => ("m/s²", 1.0),
            (Dimension::Density, _) => ("kg/m³", 1.0),
            (Dimension::Volume, _) => ("m³", 1.0),
            (Dimension::VolumeFlow, _) => ("m³/s", 1.0),
            (
                Dimension::Length
                | Dimension::Speed
                | Dimension::Time
                | Dimension::Mass
                | Dimension::MassFlow
                | Dimension::Force
                | Dimension::Temperature,
                _,
            ) => (dimension.si_symbol(), 1.0),
        }
    }

    /// Unit a role is shown in: engine speeds in revolutions per minute, the rest by dimension.
    pub fn of_role(self, role: Role) -> (&'static str, f64) {
        match role {
            Role::EngineSpeed1 | Role::EngineSpeed2 if self != Self::Si => ("rpm", 60.0 / std::f64::consts::TAU),
            _ => self.of(role.dimension()),
        }
    }
}

/// How long something took: milliseconds below one second, seconds above.
pub fn duration(took: std::time::Duration) -> String {
    let seconds = took.as_secs_f64();
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
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

/// A term such as `qc/V` or `alpha^2*delta_e` as it is printed: `qc/V`, `α²·δe`.
pub fn term(name: &str) -> String {
    greek(&name.replace("^2", "²").replace("^3", "³").replace('*', "·"))
}

/// A derivative such as `Cm_delta_e` split into its letter, its subscript and what follows: `C`, `mδe`, ``.
pub fn derivative_parts(name: &str) -> (String, String, String) {
    let (symbol, suffix) = name.split_once('[').map_or((name, String::new()), |(a, b)| (a.trim(), format!(" [{b}")));
    let (coefficient, variables) = symbol.split_once('_').unwrap_or((symbol, ""));
    let (letter, axis) = coefficient.split_at(coefficient.len().min(1));
    let variables = greek(variables).replace('_', "").replace('2', "²").replace('3', "³");
    (letter.to_owned(), format!("{axis}{variables}"), suffix)
}

/// A derivative as plain text: `Cmδe`.
pub fn derivative(name: &str) -> String {
    let (letter, subscript, suffix) = derivative_parts(name);
    format!("{letter}{subscript}{suffix}")
}

/// A derivative with its subscript set small and low.
pub fn derivative_job(ui: &egui::Ui, name: &str) -> LayoutJob {
    let (letter, subscript, suffix) = derivative_parts(name);
    let color = ui.visuals().text_color();
    let format = |size, valign| TextFormat { font_id: FontId::proportional(size), color, valign, ..Default::default() };
    let mut job = LayoutJob::default();
    job.append(&letter, 0.0, format(13.0, Align::Center));
    job.append(&subscript, 0.5, format(10.0, Align::BOTTOM));
    if !suffix.is_empty() {
        job.append(&suffix, 0.0, TextFormat { color: ui.visuals().weak_text_color(), ..format(11.0, Align::Center) });
    }
    job
}

/// A number for a table: four significant digits, a true minus sign.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let rounded = crate::widgets::quantity_edit::rounded(value, 4);
    concise(rounded).replace('-', "\u{2212}")
}

/// `value` with `decimals`, a true minus sign, a dash where there is none.
pub fn fixed(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}").replace('-', "\u{2212}") } else { "–".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_and_terms_are_written_in_greek() {
        assert_eq!(derivative_parts("Cm_delta_e"), ("C".into(), "mδe".into(), String::new()));
        assert_eq!(derivative("CX_alpha2"), "CXα²");
        assert_eq!(derivative("CZ_0 [e1]"), "CZ0 [e1]");
        assert_eq!(derivative("CZ_0[03 delta_e]"), "CZ0 [03 delta_e]");
        assert_eq!(derivative("Cm_alpha_dot"), "Cmα̇");
        assert_eq!(term("alpha^2*delta_e"), "α²·δe");
        assert_eq!(term("pb/2V"), "pb/2V");
    }

    #[test]
    fn units_of_aviation_are_knots_and_feet() {
        let (unit, per_m_s) = Units::Aviation.of(Dimension::Speed);
        assert_eq!((unit, (46.3 * per_m_s).round()), ("kt", 90.0));
        let (unit, per_m) = Units::Aviation.of(Dimension::Length);
        assert_eq!((unit, (1219.2 * per_m).round()), ("ft", 4000.0));
        assert_eq!(Units::Si.of(Dimension::Angle), ("rad", 1.0));
        assert_eq!(Units::Metric.of_role(Role::EngineSpeed1).0, "rpm");
    }

    #[test]
    fn numbers_carry_four_digits_and_a_true_minus() {
        assert_eq!(number(-0.012_345_6), "\u{2212}0.01235");
        assert_eq!(number(f64::NAN), "–");
        assert_eq!(fixed(-1.25, 1), "\u{2212}1.2");
    }
}
