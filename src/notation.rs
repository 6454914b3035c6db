//! How quantities are written on screen: what every front end writes, and what needs a font.

use doublet_core::quantity::{Dimension, Role};
pub use doublet_engine::notation::{derivative, derivative_parts, measurement, role, signal, state, term};
use doublet_engine::notation::{role_unit, unit};
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{self, Align, FontId};
use serde::{Deserialize, Serialize};

use crate::widgets::quantity_edit::concise;

/// Decimals of a number stated within its error at most; one that needs more has an exponent.
const MOST_DECIMALS: usize = 6;

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
        match (dimension, self) {
            (Dimension::Angle, Self::Si) => ("rad", 1.0),
            (Dimension::AngularRate, Self::Si) => ("rad/s", 1.0),
            (Dimension::AngularAcceleration, Self::Si) => ("rad/s²", 1.0),
            (Dimension::Pressure, Self::Si) => ("Pa", 1.0),
            (Dimension::Power, Self::Si) => ("W", 1.0),
            (Dimension::Length, Self::Aviation) => ("ft", 1.0 / 0.3048),
            (Dimension::Speed, Self::Aviation) => ("kt", 3600.0 / 1852.0),
            _ => unit(dimension),
        }
    }

    /// Unit a role is shown in: engine speeds in revolutions per minute, the rest by dimension.
    pub fn of_role(self, role: Role) -> (&'static str, f64) {
        match role {
            Role::EngineSpeed1 | Role::EngineSpeed2 if self != Self::Si => role_unit(role),
            _ => self.of(role.dimension()),
        }
    }
}

/// How long something took: milliseconds below one second, seconds above.
pub fn duration(took: std::time::Duration) -> String {
    let seconds = took.as_secs_f64();
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
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
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        // What is rounded to zero has no sign.
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// A correlation: two decimals, three where two would round it towards one.
pub fn correlation(value: f64) -> String {
    fixed(value, if value.abs() >= 0.99 { 3 } else { 2 })
}

/// `value` to the last digit that `error` lets it have, its error taken to two digits.
pub fn within(value: f64, error: f64) -> String {
    if !error.is_normal() {
        return number(value);
    }
    let decimals = (1.0 - error.abs().log10().floor()).max(0.0) as usize;
    if decimals > MOST_DECIMALS { number(value) } else { fixed(value, decimals) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(fixed(-0.004, 2), "0.00");
        assert_eq!(fixed(-1e-9, 0), "0");
    }

    #[test]
    fn decimals_follow_the_error_and_the_nearness_to_one() {
        assert_eq!(within(-14.3721, 1.23), "\u{2212}14.4");
        assert_eq!(within(0.123_456, 0.001_23), "0.1235");
        assert_eq!(within(1234.4, 560.0), "1234");
        assert_eq!(within(0.123_456, 0.0), number(0.123_456));
        assert_eq!(within(0.123_456, f64::NAN), number(0.123_456));
        assert_eq!([correlation(-0.996), correlation(0.5)], ["\u{2212}0.996", "0.50"]);
    }
}
