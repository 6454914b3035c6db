//! How quantities are written on screen: what every front end writes, and what needs a font.

use doublet_core::model::{Term, Variable};
use doublet_core::quantity::{Dimension, Role};
use doublet_engine::notation::{decimals_of_error, role_unit, unit};
pub use doublet_engine::notation::{
    derivative, derivative_parts, measurement, plural, raise_powers, role, signal, state, term,
};
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{self, Align, Color32, FontId};
use serde::{Deserialize, Serialize};

/// Decimals of a number stated within its error at most; one that needs more has an exponent.
const MOST_DECIMALS: usize = 6;

/// Letters of flying qualities and statistics by the names that text files give them.
const WORDS: [(&str, &str); 4] = [("omega", "ω"), ("zeta", "ζ"), ("tau", "τ"), ("R2", "R²")];

/// Units of the variables of terms that have one, behind the comma of their descriptions.
const TERM_UNITS: [&str; 3] = ["rad", "m/s", "m"];

/// Unit of the derivative by a term, for example `per rad²`; empty where its variables have no dimension.
pub fn derivative_unit(term: &Term) -> String {
    let unit = |(variable, power): &(Variable, i32)| {
        let (_, unit) = variable.description().rsplit_once(", ").filter(|(_, unit)| TERM_UNITS.contains(unit))?;
        Some((unit, *power))
    };
    let mut units: Vec<(&str, i32)> = Vec::new();
    for (unit, power) in term.factors().iter().filter_map(unit) {
        match units.iter_mut().find(|(known, _)| *known == unit) {
            Some((_, powers)) => *powers += power,
            None => units.push((unit, power)),
        }
    }
    units.iter().map(write_power).collect::<Vec<_>>().join(" ")
}

fn write_power((unit, power): &(&str, i32)) -> String {
    match power {
        1 => format!("per {unit}"),
        2 => format!("per {unit}²"),
        power => format!("per {unit}^{power}"),
    }
}

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
    pub fn for_dimension(self, dimension: Dimension) -> (&'static str, f64) {
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
            _ => self.for_dimension(role.dimension()),
        }
    }
}

/// How long something took: milliseconds below one second, seconds above.
pub fn duration(took: std::time::Duration) -> String {
    let seconds = took.as_secs_f64();
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
}

/// Size of a subscript over that of its letter.
const SUBSCRIPT: f32 = 0.77;
/// Axes a coefficient is called by.
const AXES: &str = "XYZlmnDL";
/// What the subscript of a derivative begins with after its axis, and what it has else.
const FIRST: &str = "αβδΔpqr0M";
const OTHER: &str = "aefgrtVₜ²³·0123456789\u{307}\u{302}";
/// Quantities whose names in files are words for a letter.
const LETTERS: [Role; 12] = [
    Role::AngleOfAttack,
    Role::Sideslip,
    Role::BankAngle,
    Role::PitchAngle,
    Role::HeadingAngle,
    Role::VelocityNorth,
    Role::VelocityEast,
    Role::VelocityDown,
    Role::Aileron,
    Role::Elevator,
    Role::Rudder,
    Role::ElevatorTrim,
];

/// How long ago, in words.
pub fn ago(age: std::time::Duration) -> String {
    let minutes = age.as_secs() / 60;
    match minutes {
        0 => "less than a minute ago".to_owned(),
        1..120 => format!("{minutes} min ago"),
        120..2880 => format!("{} hours ago", minutes / 60),
        2880..1_051_200 => format!("{} days ago", minutes / 1440),
        _ => format!("{} years ago", minutes / 525_600),
    }
}

/// A derivative with its subscript set small and low.
pub fn derivative_job(ui: &egui::Ui, name: &str) -> LayoutJob {
    let (letter, subscript, suffix) = derivative_parts(name);
    let mut job = LayoutJob::default();
    append(&mut job, (&letter, &subscript), 13.0, Color32::PLACEHOLDER);
    if !suffix.is_empty() {
        append(&mut job, (&suffix, ""), 11.0, ui.visuals().weak_text_color());
    }
    job
}

/// `text` of that size as it is printed: coefficients and derivatives with their subscript small and low, Greek letters for the names of
/// files. What stands between single quotes is left as it is. Its colour is that of the widget it is drawn by.
pub fn typeset(text: &str, size: f32) -> LayoutJob {
    typeset_in(text, size, Color32::PLACEHOLDER)
}

/// The same in a colour of its own.
pub fn typeset_in(text: &str, size: f32, color: Color32) -> LayoutJob {
    let mut job = LayoutJob::default();
    for (letter, subscript) in symbols(text) {
        append(&mut job, (&letter, &subscript), size, color);
    }
    job
}

fn append(job: &mut LayoutJob, (letter, subscript): (&str, &str), size: f32, color: Color32) {
    let format = |size, valign| TextFormat { font_id: FontId::proportional(size), color, valign, ..Default::default() };
    job.append(letter, 0.0, format(size, Align::Center));
    if !subscript.is_empty() {
        job.append(subscript, 0.5, format(SUBSCRIPT * size, Align::BOTTOM));
    }
}

/// Parts of a text, each with the subscript that follows it.
fn symbols(text: &str) -> Vec<(String, String)> {
    let mut found = vec![(String::new(), String::new())];
    let mut quoted = false;
    let is_of_word = |letter: char| letter.is_alphanumeric() || "_·²³ₜ\u{307}\u{302}".contains(letter);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = match is_of_word(first) {
            true => rest.find(|letter| !is_of_word(letter)).unwrap_or(rest.len()),
            false => first.len_utf8(),
        };
        let (word, after) = rest.split_at(end);
        rest = after;
        // An apostrophe within a word quotes nothing.
        let before = found.last().and_then(|(text, _)| text.chars().last());
        if first == '\'' && (quoted || !before.is_some_and(char::is_alphanumeric)) {
            quoted = !quoted;
        }
        let symbol = match first {
            _ if quoted => None,
            '-' if !before.is_some_and(char::is_alphanumeric)
                && (rest.starts_with(|next: char| next.is_ascii_digit())
                    || found.last().is_some_and(|(text, _)| text.ends_with("= "))) =>
            {
                Some(("\u{2212}".to_owned(), String::new()))
            }
            _ => symbol(word),
        };
        let (letter, subscript) = symbol.unwrap_or_else(|| (word.to_owned(), String::new()));
        match found.last_mut() {
            Some((text, own)) if own.is_empty() => (text.push_str(&letter), *own = subscript).1,
            _ => found.push((letter, subscript)),
        }
    }
    found
}

/// Letter and subscript of a word that is a coefficient, a derivative or the name of a quantity.
fn symbol(word: &str) -> Option<(String, String)> {
    let (base, power) = word.find(['²', '³']).map_or((word, ""), |at| word.split_at(at));
    if let Some(of) = Role::from_name(base).filter(|role| LETTERS.contains(role)) {
        return Some((format!("{}{power}", role(of)), String::new()));
    }
    if let Some((_, letter)) = WORDS.iter().find(|(name, _)| *name == base) {
        return Some((format!("{letter}{power}"), String::new()));
    }
    if let Some(of) = word.strip_prefix("omega_") {
        return Some(("ω".to_owned(), of.to_owned()));
    }
    let (change, symbol) = word.strip_prefix('Δ').map_or(("", word), |symbol| ("Δ", symbol));
    let variables = symbol.strip_prefix('C')?.strip_prefix(|axis| AXES.contains(axis))?;
    let begins = |with: &str| variables.chars().next().is_some_and(|first| with.contains(first));
    let is_symbol = variables.chars().all(|letter| FIRST.contains(letter) || OTHER.contains(letter));
    if !(variables.is_empty() || begins("_") || (begins(FIRST) && is_symbol)) {
        return None;
    }
    let (letter, subscript, _) = derivative_parts(symbol);
    Some((format!("{change}{letter}"), subscript))
}

/// A number for a table: four significant digits, a true minus sign.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    concise(rounded(value, 4)).replace('-', "\u{2212}")
}

/// `value` to `digits` significant digits.
pub fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let text = format!("{value:.*e}", (digits - 1).max(0) as usize);
    text.parse().unwrap_or(value)
}

/// `value` with five significant digits at most and no zeros after them.
pub fn concise(value: f64) -> String {
    let text = five_digits(value);
    let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{digits}{exponent}")
}

/// `value` with five significant digits, as it can be typed again, without a needless exponent.
fn five_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (4 - size.log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.decimals$}")
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

/// [`fixed`] with four digits of what is smaller than a thousand and at least `least` decimals: masses and inertias of a model and of an
/// airliner.
pub fn four_digits(value: f64, least: usize) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few digits, clamped")]
    let decimals = if value == 0.0 { 0 } else { (3.0 - value.abs().log10().floor()).clamp(0.0, 7.0) as usize };
    fixed(value, decimals.max(least))
}

/// A correlation: two decimals, three where two would round it towards one.
pub fn correlation(value: f64) -> String {
    fixed(value, if value.abs() >= 0.99 { 3 } else { 2 })
}

/// A probability in per cent, with a space that does not break.
pub fn probability(value: f64) -> String {
    if value < 0.001 { "below 0.1\u{a0}%".to_owned() } else { format!("{}\u{a0}%", fixed(100.0 * value, 1)) }
}

/// `value` to the last digit that `error` lets it have, its error taken to two digits.
pub fn within(value: f64, error: f64) -> String {
    if !error.is_normal() {
        return number(value);
    }
    let decimals = decimals_of_error(error);
    if decimals > MOST_DECIMALS { number(value) } else { fixed(value, decimals) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_aviation_are_knots_and_feet() {
        let (unit, per_m_s) = Units::Aviation.for_dimension(Dimension::Speed);
        assert_eq!((unit, (46.3 * per_m_s).round()), ("kt", 90.0));
        let (unit, per_m) = Units::Aviation.for_dimension(Dimension::Length);
        assert_eq!((unit, (1219.2 * per_m).round()), ("ft", 4000.0));
        assert_eq!(Units::Si.for_dimension(Dimension::Angle), ("rad", 1.0));
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
    fn symbols_of_a_text_have_subscripts_and_greek_letters() {
        let set = |text: &str| -> Vec<String> {
            symbols(text).iter().map(|(text, under)| format!("{text}|{under}")).collect()
        };
        assert_eq!(set("CX_alpha2 (pooled)"), ["C|Xα²", " (pooled)|"]);
        assert_eq!(set("CXα and ΔCY"), ["C|Xα", " and ΔC|Y"]);
        assert_eq!(set("Cmα̇ [1]"), ["C|mα̇", " [1]|"]);
        assert_eq!(set("1, alpha², qc/V"), ["1, α², qc/V|"]);
        assert_eq!(set("omega_sp² with zeta omega, R2 0.9"), ["ω|sp²", " with ζ ω, R² 0.9|"]);
        assert_eq!(set("most of psi, v_east"), ["most of ψ, Ve|"]);
        for same in ["Clear of Clouds, CG, C, CXYZ, Cmd", "nothing gives 'delta_e'", "the manoeuvre's CSV"] {
            assert_eq!(set(same), [format!("{same}|")]);
        }
        assert_eq!(set("use beta = -beta"), ["use β = \u{2212}β|"]);
        assert_eq!(set("alone says -0.18, 3-2-1-1 (-4)"), ["alone says \u{2212}0.18, 3-2-1-1 (\u{2212}4)|"]);
        assert_eq!(set("'phi' is phi's name"), ["'phi' is φ's name|"]);
        assert_eq!(typeset("Cm_delta_e", 10.0).text, "Cmδe");
    }

    #[test]
    fn derivatives_have_the_unit_of_their_term() {
        let unit = |text: &str| derivative_unit(&Term::parse(text).unwrap());
        let units = ["alpha", "alpha^2", "qc/V", "V", "alpha*delta_e"].map(unit);
        assert_eq!(units, ["per rad", "per rad²", "", "per m/s", "per rad²"]);
    }

    #[test]
    fn decimals_follow_the_error_and_the_nearness_to_one() {
        assert_eq!(within(-14.3721, 1.23), "\u{2212}14.4");
        assert_eq!(within(0.123_456, 0.001_23), "0.1235");
        assert_eq!(within(1234.4, 560.0), "1234");
        assert_eq!(within(0.123_456, 0.0), number(0.123_456));
        assert_eq!(within(0.123_456, f64::NAN), number(0.123_456));
        assert_eq!([probability(0.0004), probability(0.25)], ["below 0.1\u{a0}%", "25.0\u{a0}%"]);
        assert_eq!([correlation(-0.996), correlation(0.5)], ["\u{2212}0.996", "0.50"]);
    }
}
