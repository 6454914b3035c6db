//! Units by name, converted to SI on the way in.

use thiserror::Error;

use Dimension as D;

/// Physical dimension of a quantity; only units of one dimension convert into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Pure number, ratio or per cent.
    Dimensionless,
    /// Plane angle, rad.
    Angle,
    /// Angular rate, rad/s.
    AngularRate,
    /// Angular acceleration, rad/s².
    AngularAcceleration,
    /// Length, m.
    Length,
    /// Speed, m/s.
    Speed,
    /// Acceleration, m/s².
    Acceleration,
    /// Time, s.
    Time,
    /// Mass, kg.
    Mass,
    /// Mass flow, kg/s.
    MassFlow,
    /// Force, N.
    Force,
    /// Pressure, Pa.
    Pressure,
    /// Absolute temperature, K.
    Temperature,
    /// Density, kg/m³.
    Density,
    /// Power, W.
    Power,
    /// Volume, m³.
    Volume,
    /// Volume flow, m³/s.
    VolumeFlow,
}

impl Dimension {
    crate::variant_texts! {
        /// Symbol of the SI unit of this dimension, as written in tables and files.
        pub si_symbol:
            Dimensionless "-", Angle "rad", AngularRate "rad/s", AngularAcceleration "rad/s^2", Length "m", Speed "m/s",
            Acceleration "m/s^2", Time "s", Mass "kg", MassFlow "kg/s", Force "N", Pressure "Pa", Temperature "K",
            Density "kg/m^3", Power "W", Volume "m^3", VolumeFlow "m^3/s",
    }
}

/// A unit of measurement: `si = value * scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Canonical symbol, for example `kt`.
    pub symbol: &'static str,
    /// Dimension this unit measures.
    pub dimension: Dimension,
    /// Factor to SI.
    pub scale: f64,
    /// Offset to SI, not zero for temperatures only.
    pub offset: f64,
}

/// The unit name is not known.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("unknown unit '{name}': use one of {}", known.join(", "))]
pub struct UnknownUnit {
    /// Name as given.
    pub name: String,
    /// Symbols that would have been understood.
    pub known: Vec<&'static str>,
}

/// One row of the table of units: symbol, other spellings, dimension, factor and offset to SI.
struct Row(&'static str, &'static [&'static str], Dimension, f64, f64);

/// International foot, m (exact).
const FOOT_M: f64 = 0.3048;
/// International nautical mile, m (exact).
const NAUTICAL_MILE_M: f64 = 1852.0;
/// International avoirdupois pound, kg (exact).
const POUND_KG: f64 = 0.453_592_37;
/// Standard acceleration of free fall, m/s² (exact): the unit g, not the local gravity.
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;
/// Conventional inch of mercury, Pa.
const INCH_OF_MERCURY_PA: f64 = 3386.389;
/// United States gallon, m³ (exact).
const GALLON_M3: f64 = 3.785_411_784e-3;
/// One degree, rad.
const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

/// Units understood, one row each. Factors: BIPM SI brochure; NIST SP 811, appendix B.
const UNITS: &[Row] = &[
    Row("-", &["", "1", "none", "unitless", "dimensionless", "ratio"], D::Dimensionless, 1.0, 0.0),
    Row("%", &["percent", "pct", "per cent"], D::Dimensionless, 0.01, 0.0),
    Row("rad", &["radian", "radians"], D::Angle, 1.0, 0.0),
    Row(
        "deg",
        &["degree", "degrees", "°", "degheading", "deglatitude", "deglongitude", "Grad"],
        D::Angle,
        DEGREE_RAD,
        0.0,
    ),
    Row("mrad", &["milliradian"], D::Angle, 1e-3, 0.0),
    Row("rad/s", &["radians/s", "rad/sec", "rps"], D::AngularRate, 1.0, 0.0),
    Row("deg/s", &["degrees/s", "deg/sec", "dps", "d/s", "°/s", "Grad/s"], D::AngularRate, DEGREE_RAD, 0.0),
    Row("mrad/s", &["mrad/sec"], D::AngularRate, 1e-3, 0.0),
    Row("rpm", &["rev/min", "1/min"], D::AngularRate, std::f64::consts::TAU / 60.0, 0.0),
    Row("rev/s", &[], D::AngularRate, std::f64::consts::TAU, 0.0),
    Row("rad/s^2", &["rad/s2", "rad/s/s", "rad/sec^2", "rad/sec2"], D::AngularAcceleration, 1.0, 0.0),
    Row(
        "deg/s^2",
        &["deg/s2", "deg/s/s", "deg/sec^2", "deg/sec2", "°/s^2", "Grad/s^2"],
        D::AngularAcceleration,
        DEGREE_RAD,
        0.0,
    ),
    Row("m", &["meter", "meters", "metre", "metres"], D::Length, 1.0, 0.0),
    Row("mm", &["millimetre", "millimeter"], D::Length, 1e-3, 0.0),
    Row("cm", &["centimetre", "centimeter"], D::Length, 1e-2, 0.0),
    Row("km", &["kilometre", "kilometer"], D::Length, 1e3, 0.0),
    Row("ft", &["foot", "feet", "ft msl", "ft wgs", "ft baro", "ftmsl", "ftagl"], D::Length, FOOT_M, 0.0),
    Row("in", &["inch", "inches"], D::Length, FOOT_M / 12.0, 0.0),
    Row("FL", &["flight level"], D::Length, 100.0 * FOOT_M, 0.0),
    Row("nmi", &["nm", "NM", "nautical mile"], D::Length, NAUTICAL_MILE_M, 0.0),
    Row("mi", &["mile", "miles"], D::Length, 5280.0 * FOOT_M, 0.0),
    Row("m/s", &["m/sec", "mps", "meters/s", "metres/s"], D::Speed, 1.0, 0.0),
    Row(
        "kt",
        &["kts", "knot", "knots", "kn", "nmi/h", "KIAS", "KCAS", "KTAS", "ktgs", "keas"],
        D::Speed,
        NAUTICAL_MILE_M / 3600.0,
        0.0,
    ),
    Row("km/h", &["kmh", "kph", "km/hr"], D::Speed, 1.0 / 3.6, 0.0),
    Row("mph", &["mi/h"], D::Speed, 5280.0 * FOOT_M / 3600.0, 0.0),
    Row("ft/s", &["ft/sec", "fps", "feet/s"], D::Speed, FOOT_M, 0.0),
    Row("ft/min", &["fpm", "feet/min", "ft/minute"], D::Speed, FOOT_M / 60.0, 0.0),
    Row("m/s^2", &["m/s2", "m/s/s", "m/sec^2", "m/sec2"], D::Acceleration, 1.0, 0.0),
    Row("ft/s^2", &["ft/s2", "ft/s/s", "ft/sec^2", "ft/sec2", "fps2", "fps^2"], D::Acceleration, FOOT_M, 0.0),
    Row("g", &["g0", "gee", "g's"], D::Acceleration, STANDARD_GRAVITY_M_S2, 0.0),
    Row("mg", &["milli-g", "millig"], D::Acceleration, 1e-3 * STANDARD_GRAVITY_M_S2, 0.0),
    Row("s", &["sec", "secs", "second", "seconds"], D::Time, 1.0, 0.0),
    Row("ms", &["msec", "millisecond", "milliseconds"], D::Time, 1e-3, 0.0),
    Row("0.1 ms", &[], D::Time, 1e-4, 0.0),
    Row("us", &["usec", "microsecond", "microseconds", "µs", "μs"], D::Time, 1e-6, 0.0),
    Row("ns", &["nsec", "nanosecond", "nanoseconds"], D::Time, 1e-9, 0.0),
    Row("min", &["minute", "minutes"], D::Time, 60.0, 0.0),
    Row("h", &["hr", "hour", "hours"], D::Time, 3600.0, 0.0),
    Row("d", &["day", "days"], D::Time, 86_400.0, 0.0),
    Row("kg", &["kgs", "kilogram", "kilograms"], D::Mass, 1.0, 0.0),
    Row("t", &["tonne", "tonnes"], D::Mass, 1e3, 0.0),
    Row("lb", &["lbs", "lbm", "pound", "pounds"], D::Mass, POUND_KG, 0.0),
    Row("slug", &["slugs"], D::Mass, POUND_KG * STANDARD_GRAVITY_M_S2 / FOOT_M, 0.0),
    Row("kg/s", &["kg/sec"], D::MassFlow, 1.0, 0.0),
    Row("kg/min", &[], D::MassFlow, 1.0 / 60.0, 0.0),
    Row("kg/h", &["kg/hr", "kgph"], D::MassFlow, 1.0 / 3600.0, 0.0),
    Row("lb/s", &["lb/sec", "lbm/s", "lbs/s"], D::MassFlow, POUND_KG, 0.0),
    Row("lb/min", &["lbs/min"], D::MassFlow, POUND_KG / 60.0, 0.0),
    Row("lb/h", &["lb/hr", "lbs/h", "lbs/hr", "lbm/h", "pph"], D::MassFlow, POUND_KG / 3600.0, 0.0),
    Row("N", &["newton", "newtons"], D::Force, 1.0, 0.0),
    Row("daN", &["decanewton"], D::Force, 10.0, 0.0),
    Row("kN", &["kilonewton"], D::Force, 1e3, 0.0),
    Row("lbf", &["pound-force", "lbsf"], D::Force, POUND_KG * STANDARD_GRAVITY_M_S2, 0.0),
    Row("kgf", &["kp"], D::Force, STANDARD_GRAVITY_M_S2, 0.0),
    Row("Pa", &["pascal", "N/m^2", "N/m2"], D::Pressure, 1.0, 0.0),
    Row("hPa", &["hectopascal"], D::Pressure, 1e2, 0.0),
    Row("mbar", &["mb", "millibar", "millibars"], D::Pressure, 1e2, 0.0),
    Row("kPa", &["kilopascal"], D::Pressure, 1e3, 0.0),
    Row("bar", &["bars"], D::Pressure, 1e5, 0.0),
    Row("inHg", &["in Hg", "\"Hg", "inches Hg", "inches of mercury", "in.Hg"], D::Pressure, INCH_OF_MERCURY_PA, 0.0),
    Row("psi", &["lbf/in^2", "lbf/in2", "lb/in^2", "lb/in2", "psia"], D::Pressure, PSI_PA, 0.0),
    Row("psf", &["lbf/ft^2", "lbf/ft2", "lb/ft^2", "lb/ft2"], D::Pressure, PSI_PA / 144.0, 0.0),
    Row("K", &["kelvin", "degK", "deg K"], D::Temperature, 1.0, 0.0),
    Row("degC", &["°C", "C", "celsius", "deg C", "℃"], D::Temperature, 1.0, 273.15),
    Row("degF", &["°F", "F", "fahrenheit", "deg F"], D::Temperature, 5.0 / 9.0, 459.67 * 5.0 / 9.0),
    Row("degR", &["°R", "rankine", "deg R"], D::Temperature, 5.0 / 9.0, 0.0),
    Row("kg/m^3", &["kg/m3"], D::Density, 1.0, 0.0),
    Row("slug/ft^3", &["slug/ft3", "slugs/ft^3", "slugs/ft3"], D::Density, SLUG_FT3_KG_M3, 0.0),
    Row("W", &["watt", "watts"], D::Power, 1.0, 0.0),
    Row("kW", &["kilowatt"], D::Power, 1e3, 0.0),
    Row("hp", &["bhp", "shp", "horsepower"], D::Power, 550.0 * FOOT_M * POUND_KG * STANDARD_GRAVITY_M_S2, 0.0),
    Row("PS", &["metric hp"], D::Power, 75.0 * STANDARD_GRAVITY_M_S2, 0.0),
    Row("m^3", &["m3"], D::Volume, 1.0, 0.0),
    Row("l", &["L", "litre", "liter", "litres", "liters"], D::Volume, 1e-3, 0.0),
    Row("gal", &["gallon", "gallons", "USgal", "US gal"], D::Volume, GALLON_M3, 0.0),
    Row("l/h", &["L/h", "lph"], D::VolumeFlow, 1e-3 / 3600.0, 0.0),
    Row("gal/h", &["gph", "gal/hr", "GPH"], D::VolumeFlow, GALLON_M3 / 3600.0, 0.0),
    Row("m^3/s", &["m3/s"], D::VolumeFlow, 1.0, 0.0),
];

/// Pound-force per square inch, Pa.
const PSI_PA: f64 = POUND_KG * STANDARD_GRAVITY_M_S2 * 144.0 / (FOOT_M * FOOT_M);
/// Slug per cubic foot, kg/m³.
const SLUG_FT3_KG_M3: f64 = POUND_KG * STANDARD_GRAVITY_M_S2 / (FOOT_M * FOOT_M * FOOT_M * FOOT_M);

impl Row {
    fn unit(&self) -> Unit {
        Unit { symbol: self.0, dimension: self.2, scale: self.3, offset: self.4 }
    }

    fn spellings(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.0).chain(self.1.iter().copied())
    }
}

/// `name` with powers, spaces and brackets written one way: ` [m/s²] ` -> `m/s^2`.
fn plain(name: &str) -> String {
    let name = name.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim();
    let mut plain = name.replace('²', "^2").replace('³', "^3").replace("**", "^");
    while let Some(at) = plain.find(" /").or_else(|| plain.find("/ ")) {
        plain.replace_range(at..at + 2, "/");
    }
    plain
}

/// A quotient in words by its symbols: `feet per second squared` -> `ft/s^2`, `pounds per square foot` -> `lb/ft^2`; none of other names.
fn abbreviate(name: &str) -> Option<String> {
    let name = name.replace(" per second per second", " per second squared");
    let (above, below) = name.split_once(" per ")?;
    let powers = [("square ", "^2"), ("cubic ", "^3")];
    let (below, power) = match below.strip_suffix(" squared") {
        Some(base) => (base, "^2"),
        None => {
            powers.iter().find_map(|(word, power)| Some((below.strip_prefix(word)?, *power))).unwrap_or((below, ""))
        }
    };
    Some(format!("{}/{}{power}", symbol_of(above)?, symbol_of(below)?))
}

/// Symbol of a unit in words, of one or of many.
fn symbol_of(word: &str) -> Option<&'static str> {
    let word = word.trim();
    [word, word.trim_end_matches('s')].into_iter().find_map(|word| Unit::parse(word).ok()).map(|unit| unit.symbol)
}

impl Unit {
    /// The unit called `name`, by its symbol or a common spelling (`kts`, `lbs`, `°/s`, `m/s²`, `[ft]`).
    ///
    /// Spelled exactly it always means the same; in other capitals it is understood where only one unit can be meant
    /// (`KN` could be knots or kilonewtons and is refused).
    ///
    /// # Errors
    /// [`UnknownUnit`] with every symbol that would have been understood.
    pub fn parse(name: &str) -> Result<Self, UnknownUnit> {
        let wanted = plain(name);
        if let Some(row) = UNITS.iter().find(|row| row.spellings().any(|spelling| spelling == wanted)) {
            return Ok(row.unit());
        }
        if let Some(written) = abbreviate(&wanted) {
            return Self::parse(&written).map_err(|unknown| UnknownUnit { name: name.to_owned(), ..unknown });
        }
        let folded = wanted.to_lowercase();
        let mut similar = UNITS.iter().filter(|row| row.spellings().any(|spelling| spelling.to_lowercase() == folded));
        match (similar.next(), similar.next()) {
            (Some(row), None) => Ok(row.unit()),
            _ => Err(UnknownUnit { name: name.to_owned(), known: UNITS.iter().map(|row| row.0).collect() }),
        }
    }

    /// The SI unit of `dimension`: factor 1, offset 0.
    pub fn si(dimension: Dimension) -> Self {
        Self { symbol: dimension.si_symbol(), dimension, scale: 1.0, offset: 0.0 }
    }

    /// Every unit understood, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        UNITS.iter().map(Row::unit)
    }

    /// Value in SI of `value` in this unit.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.scale + self.offset
    }

    /// Value in this unit of `si`.
    pub fn from_si(&self, si: f64) -> f64 {
        (si - self.offset) / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative tolerance of a factor against its published value, which is rounded to seven digits or more.
    const FACTOR_TOLERANCE: f64 = 1e-7;

    #[test]
    fn factors_match_published_values() {
        let published = [
            ("kt", 0.514_444_444_4),
            ("ft/min", 5.08e-3),
            ("psi", 6_894.757_29),
            ("psf", 47.880_258_98),
            ("lbf", 4.448_221_615),
            ("hp", 745.699_871_6),
            ("slug", 14.593_902_94),
            ("slug/ft^3", 515.378_818_4),
            ("inHg", 3_386.389),
            ("rpm", 0.104_719_755_1),
            ("gal", 3.785_411_784e-3),
            ("lb/h", 1.259_978_806e-4),
        ];
        for (name, factor) in published {
            let unit = Unit::parse(name).unwrap();
            assert!((unit.scale / factor - 1.0).abs() < FACTOR_TOLERANCE, "{name}: {} is not {factor}", unit.scale);
        }
    }

    #[test]
    fn spellings_mean_one_unit() {
        for (spelling, symbol) in [
            ("knots", "kt"),
            ("KTS", "kt"),
            ("radians per second", "rad/s"),
            ("Feet per second squared", "ft/s^2"),
            ("degrees per second per second", "deg/s^2"),
            ("kilometers per hour", "km/h"),
            ("slugs per cubic foot", "slug/ft^3"),
            ("pounds per square foot", "psf"),
            ("kn", "kt"),
            ("kN", "kN"),
            ("[m/s²]", "m/s^2"),
            ("m / s^2", "m/s^2"),
            ("°/s", "deg/s"),
            ("deg C", "degC"),
            ("lbs", "lb"),
            ("INHG", "inHg"),
            ("", "-"),
        ] {
            assert_eq!(Unit::parse(spelling).unwrap().symbol, symbol, "{spelling}");
        }
        assert!(Unit::parse("KN").is_err(), "knots or kilonewtons");
    }

    #[test]
    fn every_spelling_is_found_once() {
        for row in UNITS {
            for spelling in row.spellings() {
                assert_eq!(Unit::parse(spelling).unwrap().symbol, row.0, "{spelling}");
            }
        }
    }

    #[test]
    fn temperatures_keep_their_offsets() {
        let celsius = Unit::parse("degC").unwrap();
        let fahrenheit = Unit::parse("degF").unwrap();
        assert!((celsius.to_si(15.0) - 288.15).abs() < 1e-9);
        assert!((fahrenheit.to_si(59.0) - 288.15).abs() < 1e-9);
        assert!((fahrenheit.from_si(celsius.to_si(-40.0)) + 40.0).abs() < 1e-9);
    }

    #[test]
    fn unknown_unit_lists_the_known_ones() {
        let text = Unit::parse("furlong").unwrap_err().to_string();
        assert!(text.contains("'furlong'") && text.contains("kt") && !text.contains('\n'), "{text}");
    }
}
