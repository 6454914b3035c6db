//! Limits of flying qualities as data: dated files with the source and certainty of every row.

use doublet_core::toml_error;
use serde::Deserialize;
use thiserror::Error;

use super::{Measure, PilotTask};

/// What a limits file begins with.
const FORMAT: &str = "doublet flying qualities";
/// Classes of aircraft; II by whether it is based on land or on a carrier.
const CLASSES: [&str; 5] = ["I", "II-L", "II-C", "III", "IV"];
/// Categories of flight phases.
const CATEGORIES: [&str; 3] = ["A", "B", "C"];

/// Why limits cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum LimitsError {
    #[error("not a file of flying-quality limits: {reason}")]
    File { reason: String },
    #[error("'{given}' is not a known {what}: use one of {}", known.join(", "))]
    Unknown { what: &'static str, given: String, known: Vec<&'static str> },
    #[error("{name} has limits for class {}, not {class}", classes.join(", "))]
    OtherClass { name: String, classes: Vec<String>, class: String },
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
    /// Bounds that depend on another measure.
    pub along: Option<Along>,
    /// Standard the limit is from.
    #[serde(skip)]
    pub standard: String,
    /// Whether it is guidance for design, which does not count.
    #[serde(skip)]
    pub is_guidance: bool,
}

/// A boundary in the plane of two measures: bounds of one as straight lines over the other.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Along {
    /// The other measure.
    pub measure: Measure,
    /// Its values, rising, with the least value of the limited measure there.
    #[serde(default)]
    pub minimum: Vec<[f64; 2]>,
    /// The same with the greatest value.
    #[serde(default)]
    pub maximum: Vec<[f64; 2]>,
    /// Whether the figure ends at the first and the last point: beyond them nothing is judged.
    #[serde(default)]
    pub is_figure: bool,
}

impl Along {
    /// Least and greatest value where the other measure is `at`: constant before the first point; nothing meets the limit beyond the last.
    pub fn bounds(&self, at: f64) -> (Option<f64>, Option<f64>) {
        (Self::bound(&self.minimum, at, f64::INFINITY), Self::bound(&self.maximum, at, f64::NEG_INFINITY))
    }

    fn bound(points: &[[f64; 2]], at: f64, beyond: f64) -> Option<f64> {
        let (first, last) = points.first().zip(points.last())?;
        if at <= first[0] {
            return Some(first[1]);
        }
        let pair = points.windows(2).find(|pair| at <= pair[1][0]);
        let Some([[left, low], [right, high]]) = pair.map(|pair| [pair[0], pair[1]]) else {
            return Some(if at <= last[0] { last[1] } else { beyond });
        };
        Some(low + (high - low) * (at - left) / (right - left))
    }

    /// First and last value of the other measure in the figure where `at` lies outside it; none inside, and of a boundary without ends.
    pub fn figure_missed_by(&self, at: f64) -> Option<[f64; 2]> {
        let points = || self.minimum.iter().chain(&self.maximum).map(|point| point[0]);
        let ends = [points().fold(f64::INFINITY, f64::min), points().fold(f64::NEG_INFINITY, f64::max)];
        (self.is_figure && !(ends[0]..=ends[1]).contains(&at)).then_some(ends)
    }

    fn is_rising(&self) -> bool {
        [&self.minimum, &self.maximum].into_iter().all(|points| points.windows(2).all(|pair| pair[0][0] < pair[1][0]))
            && !(self.minimum.is_empty() && self.maximum.is_empty())
    }
}

/// A criterion that is not judged at all.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotJudged {
    /// Criterion.
    pub criterion: String,
    /// Where the standard has it.
    pub source: String,
    /// What is needed to judge it.
    pub needed: String,
    /// Categories it is not judged in; all where none is named.
    #[serde(default)]
    pub categories: Vec<String>,
    /// Measures that are shown all the same.
    #[serde(default)]
    pub measures: Vec<Measure>,
    /// Standard it is from.
    #[serde(skip)]
    pub standard: String,
}

/// Tasks of the pilot in the loop of pitch attitude, by category.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PilotTasks {
    /// Bandwidth of each category, rad/s.
    pub bandwidth_rad_s: std::collections::BTreeMap<String, f64>,
    /// Delay of the pilot, s.
    pub delay_s: f64,
    /// Least gain of the closed loop below the bandwidth, dB.
    pub droop_db: f64,
    /// Where the numbers are from.
    pub source: String,
}

impl Limit {
    /// Whether it counts in a judgement.
    pub fn counts(&self) -> bool {
        self.certainty != "unverified" && !self.is_guidance
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
    /// Whether the limits are guidance for design, which does not count.
    #[serde(default)]
    pub guidance: bool,
    /// Criteria of the standard that are not judged.
    #[serde(default)]
    pub not_judged: Vec<NotJudged>,
    /// Tasks of the pilot in the loop.
    pub pilot: Option<PilotTasks>,
}

impl Limits {
    /// Reads a file of limits (TOML).
    ///
    /// # Errors
    /// [`LimitsError::File`] with the reason; a level beyond 3, a row without a limit, an unknown class or category.
    pub fn parse(text: &str) -> Result<Self, LimitsError> {
        let refuse = |reason: String| LimitsError::File { reason };
        let mut limits: Self = toml::from_str(text).map_err(|error| refuse(toml_error::one_line(text, &error)))?;
        if limits.format != FORMAT || limits.version != 1 {
            return Err(refuse(format!("format and version are not \"{FORMAT}\" and 1")));
        }
        for limit in &limits.limit {
            let row = format!("{} of level {}", limit.criterion, limit.level);
            if !(1..=3).contains(&limit.level) {
                return Err(refuse(format!("{row}: levels are 1, 2 and 3")));
            }
            if limit.minimum.is_none() && limit.maximum.is_none() && limit.along.is_none() {
                return Err(refuse(format!("{row} has neither minimum nor maximum")));
            }
            if limit.along.as_ref().is_some_and(|along| !along.is_rising()) {
                return Err(refuse(format!("{row}: points of its boundary do not rise")));
            }
            let known = |names: &[String], known: &[&str]| names.iter().all(|name| known.contains(&name.as_str()));
            if !known(&limit.classes, &CLASSES) || !known(&limit.categories, &CATEGORIES) {
                return Err(refuse(format!("{row} names a class or category that is none")));
            }
        }
        let (edition, guidance) = (limits.edition(), limits.guidance);
        for limit in &mut limits.limit {
            (limit.standard, limit.is_guidance) = (edition.clone(), guidance);
        }
        limits.not_judged.iter_mut().for_each(|row| row.standard.clone_from(&edition));
        Ok(limits)
    }

    /// Name and date of the standard.
    pub fn edition(&self) -> String {
        format!("{} ({})", self.name, self.date)
    }

    /// The same with the criteria of another file behind its own; a criterion that both have is judged by this one. What a file says once for
    /// all, such as the task of the pilot, is taken from the other where it is open here.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        let names = self.limit.iter().map(|limit| &limit.criterion);
        let known: Vec<String> = names.chain(self.not_judged.iter().map(|row| &row.criterion)).cloned().collect();
        self.limit.extend(other.limit.into_iter().filter(|limit| !known.contains(&limit.criterion)));
        self.not_judged.extend(other.not_judged.into_iter().filter(|row| !known.contains(&row.criterion)));
        self.pilot = self.pilot.or(other.pilot);
        self
    }

    /// Task of the pilot in the loop in a category of flight phases.
    pub fn pilot_task(&self, airplane: &Airplane) -> Option<PilotTask> {
        let PilotTasks { bandwidth_rad_s, delay_s, droop_db, .. } = self.pilot.as_ref()?;
        let bandwidth_rad_s = *bandwidth_rad_s.get(airplane.category)?;
        Some(PilotTask { bandwidth_rad_s, delay_s: *delay_s, droop_db: *droop_db })
    }

    /// Limits of a measure for an aircraft: level, least and greatest value that meets it.
    pub fn bounds(&self, airplane: &Airplane, measure: Measure) -> Vec<(u8, Option<f64>, Option<f64>)> {
        let applicable =
            self.limit.iter().filter(|limit| limit.measure == measure && limit.counts() && limit.applies(airplane));
        let applicable = applicable.filter(|limit| limit.along.is_none());
        applicable.map(|limit| (limit.level, limit.minimum, limit.maximum)).collect()
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
