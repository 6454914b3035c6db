//! Limits of flying qualities as data: dated files with the source and certainty of every row.

use serde::Deserialize;
use thiserror::Error;

use super::Measure;

/// What a limits file begins with.
const FORMAT: &str = "doublet flying qualities";
/// Classes of aircraft; II by whether it is based on land or on a carrier.
const CLASSES: [&str; 5] = ["I", "II-L", "II-C", "III", "IV"];
/// Categories of flight phases.
const CATEGORIES: [&str; 3] = ["A", "B", "C"];

/// Why limits cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LimitsError {
    /// Not a limits file.
    #[error("not a file of flying-quality limits: {reason}")]
    File {
        /// What is wrong.
        reason: String,
    },
    /// A class or category that is not one.
    #[error("'{given}' is not a known {what}: use one of {}", known.join(", "))]
    Unknown {
        /// Class or category.
        what: &'static str,
        /// As given.
        given: String,
        /// Those there are.
        known: Vec<&'static str>,
    },
    /// Limits for other classes.
    #[error("{name} has limits for class {}, not {class}", classes.join(", "))]
    OtherClass {
        /// Name of the limits.
        name: String,
        /// Their classes.
        classes: Vec<String>,
        /// Class asked for.
        class: String,
    },
}

/// An aircraft and its flight phase, as limits tell them apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Airplane {
    /// `I` small and light, `II-L` and `II-C` of medium weight based on land or carrier, `III` large and heavy, `IV` highly
    /// manoeuvrable.
    pub class: &'static str,
    /// `A` rapid manoeuvring or precision, `B` gradual manoeuvres, `C` take-off, approach and landing.
    pub category: &'static str,
}

impl Airplane {
    /// By the names of class and category; `II` is `II-L`.
    ///
    /// # Errors
    /// [`LimitsError::Unknown`] with those there are.
    pub fn new(class: &str, category: &str) -> Result<Self, LimitsError> {
        let wanted = if class.eq_ignore_ascii_case("II") { "II-L" } else { class };
        let find = |what: &'static str, known: &'static [&'static str], given: &str| {
            let found = known.iter().find(|name| name.eq_ignore_ascii_case(given)).copied();
            found.ok_or_else(|| LimitsError::Unknown { what, given: given.to_owned(), known: known.to_vec() })
        };
        Ok(Self { class: find("class", &CLASSES, wanted)?, category: find("category", &CATEGORIES, category)? })
    }
}

/// One limit.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Criterion it belongs to.
    pub criterion: String,
    /// What is limited.
    pub measure: Measure,
    /// Classes it holds for; all where none is named.
    #[serde(default)]
    pub classes: Vec<String>,
    /// Categories it holds for; all where none is named.
    #[serde(default)]
    pub categories: Vec<String>,
    /// Level it is a limit of, 1 to 3.
    pub level: u8,
    /// Least value that meets it.
    pub minimum: Option<f64>,
    /// Greatest value that meets it.
    pub maximum: Option<f64>,
    /// Where the standard has it.
    pub source: String,
    /// `high`, `medium` or `unverified`.
    pub certainty: String,
    /// What other readings of the standard have.
    pub disputed: Option<String>,
}

impl Limit {
    /// Whether it counts in a judgement.
    pub fn counts(&self) -> bool {
        self.certainty != "unverified"
    }

    pub(super) fn applies(&self, airplane: &Airplane) -> bool {
        let names = |list: &[String], name: &str| list.is_empty() || list.iter().any(|known| known == name);
        names(&self.classes, airplane.class) && names(&self.categories, airplane.category)
    }
}

/// Growth of the limit of the Dutch roll's `zeta omega` with `omega^2 |phi/beta|`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Increase {
    /// Where it begins, (rad/s)².
    pub above: f64,
    /// Growth per excess at each level.
    pub factor: [f64; 3],
    /// Where the standard has it.
    pub source: String,
}

/// Damping of the Dutch roll that is enough whatever its `zeta omega`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Enough {
    /// Damping ratio.
    pub damping: f64,
    /// Classes it holds for.
    pub classes: Vec<String>,
    /// Where the standard has it.
    pub source: String,
}

/// A file of limits.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    #[serde(rename = "format")]
    format: String,
    version: u32,
    /// Short name.
    pub name: String,
    /// Title of the standard.
    pub title: String,
    /// Its date.
    pub date: toml::value::Datetime,
    /// Where the numbers were had from.
    pub source: String,
    /// What is to be known of the definitions.
    pub note: String,
    /// Classes the file has limits for; all where none is named.
    #[serde(default)]
    pub classes: Vec<String>,
    /// Limits.
    pub limit: Vec<Limit>,
    /// Growth of a limit of the Dutch roll.
    pub dutch_roll_increase: Option<Increase>,
    /// Damping of the Dutch roll that is always enough.
    pub dutch_roll_enough: Option<Enough>,
}

impl Limits {
    /// Reads a file of limits (TOML).
    ///
    /// # Errors
    /// [`LimitsError::File`] with the reason; a level beyond 3, a row without a limit, an unknown class or category.
    pub fn parse(text: &str) -> Result<Self, LimitsError> {
        let refuse = |reason: String| LimitsError::File { reason };
        let limits: Self = toml::from_str(text).map_err(|error| refuse(error.to_string().trim().replace('\n', " ")))?;
        if limits.format != FORMAT || limits.version != 1 {
            return Err(refuse(format!("format and version are not \"{FORMAT}\" and 1")));
        }
        for limit in &limits.limit {
            let row = format!("{} of level {}", limit.criterion, limit.level);
            if !(1..=3).contains(&limit.level) {
                return Err(refuse(format!("{row}: levels are 1, 2 and 3")));
            }
            if limit.minimum.is_none() && limit.maximum.is_none() {
                return Err(refuse(format!("{row} has neither minimum nor maximum")));
            }
            let known = |names: &[String], known: &[&str]| names.iter().all(|name| known.contains(&name.as_str()));
            if !known(&limit.classes, &CLASSES) || !known(&limit.categories, &CATEGORIES) {
                return Err(refuse(format!("{row} names a class or category that is none")));
            }
        }
        Ok(limits)
    }

    /// Limits of a measure for an aircraft: level, least and greatest value that meets it.
    pub fn bounds(&self, airplane: &Airplane, measure: Measure) -> Vec<(u8, Option<f64>, Option<f64>)> {
        let of =
            self.limit.iter().filter(|limit| limit.measure == measure && limit.counts() && limit.applies(airplane));
        of.map(|limit| (limit.level, limit.minimum, limit.maximum)).collect()
    }

    /// Refuses a class the file has no limits for.
    ///
    /// # Errors
    /// [`LimitsError::OtherClass`].
    pub fn check(&self, airplane: &Airplane) -> Result<(), LimitsError> {
        if self.classes.is_empty() || self.classes.iter().any(|class| class == airplane.class) {
            return Ok(());
        }
        Err(LimitsError::OtherClass {
            name: self.name.clone(),
            classes: self.classes.clone(),
            class: airplane.class.to_owned(),
        })
    }
}
