//! Units of the pages: those of the regulation.

use doublet_core::quantity::Dimension;
use doublet_core::validate::Tolerance;

use crate::notation::{self, significant};
use crate::stage::{Judgement, Quantity, ValueTolerance};

/// Length of a foot, m.
pub(super) const FOOT_M: f64 = 0.3048;
pub(super) const FOOT_PER_MINUTE_M_S: f64 = FOOT_M / 60.0;

/// Unit a dimension has on the pages and its factor from SI: knots, feet, g, degrees.
pub fn unit(dimension: Dimension) -> (&'static str, f64) {
    const KNOT_M_S: f64 = 1852.0 / 3600.0;
    const STANDARD_GRAVITY_M_S2: f64 = 9.80665;
    match dimension {
        Dimension::Speed => ("kt", 1.0 / KNOT_M_S),
        Dimension::Length => ("ft", 1.0 / FOOT_M),
        Dimension::Acceleration => ("g", 1.0 / STANDARD_GRAVITY_M_S2),
        other => notation::unit(other),
    }
}

/// The same of a quantity: a rate of climb is in ft/min.
fn unit_of(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::ClimbRate => ("ft/min", 1.0 / FOOT_PER_MINUTE_M_S),
        other => unit(other.dimension()),
    }
}

/// A quantity in words and its symbol.
pub fn name(quantity: Quantity) -> String {
    match quantity {
        Quantity::Signal(signal) => {
            let words = signal.description().split(',').next().unwrap_or_default();
            // The symbol says the rest.
            let rest = [" above the local origin", " along body x", " along body y"];
            let words = rest.into_iter().find_map(|rest| words.strip_suffix(rest)).unwrap_or(words);
            format!("{words} {}", notation::signal(signal))
        }
        other => other.name().to_owned(),
    }
}

/// The same of the name a row has.
pub fn named(parameter: &str) -> String {
    Quantity::from_name(parameter).map_or_else(|| parameter.to_owned(), name)
}

/// Dimension of the row of a name.
pub(crate) fn dimension_of(parameter: &str) -> Dimension {
    Quantity::from_name(parameter).map_or(Dimension::Dimensionless, Quantity::dimension)
}

/// Tolerances of a test in one line: `pitch angle θ ±1.5 deg or pitch rate q ±2 deg/s; and normal acceleration n ±0.1 g`.
pub fn requirements(judgement: &Judgement) -> String {
    let words = match judgement {
        Judgement::History(test) => any_of(&test.requirements, |tolerance| {
            format!("{} {}", name(Quantity::Signal(tolerance.signal)), band(tolerance))
        }),
        Judgement::Snapshot(requirements)
        | Judgement::TrimChange(requirements)
        | Judgement::Value { requirements, .. }
        | Judgement::FreeResponse { requirements, .. } => {
            any_of(requirements, |tolerance| format!("{} {}", name(tolerance.quantity), value(tolerance)))
        }
    };
    match judgement {
        Judgement::History(_) => format!("{words}; over the whole record"),
        Judgement::Value { at_s, trend, .. } => {
            let trend = if *trend { ", and the trend of the flight" } else { "" };
            format!("{words}; {at_s:.0} s after the controls came to rest{trend}")
        }
        Judgement::TrimChange(_) => format!("change from the trim: {words}"),
        Judgement::Snapshot(_) | Judgement::FreeResponse { .. } => words,
    }
}

fn any_of<T>(requirements: &[Vec<T>], words: impl Fn(&T) -> String) -> String {
    let one = |any: &Vec<T>| any.iter().map(&words).collect::<Vec<_>>().join(", or ");
    requirements.iter().map(one).collect::<Vec<_>>().join("; and ")
}

/// A number of the pages with its unit, to as many decimals as tell something of a quantity of its kind.
pub fn shown(value: f64, dimension: Dimension) -> String {
    let (unit, factor) = unit(dimension);
    format!("{} {unit}", to_decimals(value * factor, decimals(dimension))).trim_end().to_owned()
}

/// The number of a row in its unit.
pub(super) fn shown_as(value: f64, parameter: &str) -> String {
    match Quantity::from_name(parameter) {
        Some(quantity @ Quantity::ClimbRate) => {
            let (unit, factor) = unit_of(quantity);
            format!("{} {unit}", to_decimals(value * factor, 0))
        }
        _ => shown(value, dimension_of(parameter)),
    }
}

/// A number with its standard error, both to one decimal more.
pub fn with_error(value: f64, error: f64, dimension: Dimension) -> String {
    let (unit, factor) = unit(dimension);
    let decimals = decimals(dimension) + 1;
    format!("{} ± {} {unit}", to_decimals(value * factor, decimals), to_decimals(error * factor, decimals))
        .trim_end()
        .to_owned()
}

fn decimals(dimension: Dimension) -> usize {
    match dimension {
        Dimension::Length | Dimension::Force => 0,
        Dimension::Speed => 1,
        Dimension::Dimensionless | Dimension::Acceleration => 3,
        _ => 2,
    }
}

fn to_decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if is_zero { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// A band as a page states it: `±2 deg/s or 10 % of the largest`.
pub fn band(tolerance: &Tolerance) -> String {
    let (unit, factor) = unit(tolerance.signal.dimension());
    stated(
        tolerance.absolute * factor,
        unit,
        &[(tolerance.of_value, "of the sample"), (tolerance.of_peak, "of the largest")],
    )
}

/// The tolerance of one number as a page states it.
pub fn value(tolerance: &ValueTolerance) -> String {
    let (unit, factor) = unit_of(tolerance.quantity);
    stated(tolerance.absolute * factor, unit, &[(tolerance.of_value, "of the flight")])
}

fn stated(absolute: f64, unit: &str, parts: &[(f64, &str)]) -> String {
    let fixed = (absolute > 0.0).then(|| format!("±{} {unit}", number(absolute)).trim_end().to_owned());
    let parts = parts.iter().filter(|(part, _)| *part > 0.0);
    let parts = parts.map(|(part, of)| format!("±{} % {of}", number(100.0 * part)));
    fixed.into_iter().chain(parts).collect::<Vec<_>>().join(" or ")
}

/// A number as short as it is exact to four digits.
fn number(value: f64) -> String {
    let text = significant(value, 4);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use doublet_core::validate::Signal;

    use super::*;
    use crate::stage::Tolerances;

    #[test]
    fn tolerances_are_stated_as_the_regulation_prints_them() {
        let tolerance = |signal, absolute, of_peak| Tolerance { signal, absolute, of_value: 0.0, of_peak };
        let rate = tolerance(Signal::RollRate, 2.0_f64.to_radians(), 0.1);
        assert_eq!(band(&rate), "±2 deg/s or ±10 % of the largest");
        assert_eq!(band(&tolerance(Signal::Airspeed, 3.0 * 1852.0 / 3600.0, 0.0)), "±3 kt");
        assert_eq!(band(&tolerance(Signal::Altitude, 30.48, 0.0)), "±100 ft");
        assert_eq!(band(&tolerance(Signal::NormalAcceleration, 0.980_665, 0.0)), "±0.1 g");
        let damping = ValueTolerance { quantity: Quantity::DampingRatio, absolute: 0.02, of_value: 0.0 };
        assert_eq!(value(&damping), "±0.02");
        let period = ValueTolerance { quantity: Quantity::Period, absolute: 0.5, of_value: 0.1 };
        assert_eq!(value(&period), "±0.5 s or ±10 % of the flight");
        let rule = Tolerances::builtin().unwrap();
        assert_eq!(
            requirements(&rule.test("2.c.10").unwrap().judgement),
            "pitch angle θ ±1.5 deg, or pitch rate q ±2 deg/s; and normal acceleration n ±0.1 g; over the whole record"
        );
        let spiral = requirements(&rule.test("2.d.4").unwrap().judgement);
        assert_eq!(
            spiral,
            "bank angle φ ±2 deg or ±10 % of the flight; 20 s after the controls came to rest, and the trend of the flight"
        );
    }

    #[test]
    fn numbers_have_the_decimals_of_their_kind() {
        assert_eq!(shown(-0.001_234, Dimension::Angle), "\u{2212}0.07 deg");
        assert_eq!(shown(-1e-6, Dimension::Angle), "0.00 deg");
        assert_eq!(shown(46.3, Dimension::Speed), "90.0 kt");
        assert_eq!(shown(1219.2, Dimension::Length), "4000 ft");
        assert_eq!(shown(0.14509, Dimension::Dimensionless), "0.145");
        assert_eq!(with_error(0.14509, 5.9e-4, Dimension::Dimensionless), "0.1451 ± 0.0006");
        assert_eq!(with_error(4.4547, 0.0028, Dimension::Time), "4.455 ± 0.003 s");
    }
}
