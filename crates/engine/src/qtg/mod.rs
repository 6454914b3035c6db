//! Qualification tests: objective tests of a rule on the windows of a session, each judged and laid out as a page of a qualification
//! test guide.
//!
//! [`TestFile`] says which windows serve which tests, [`prepare`] gives the session they need, [`evaluate`] judges them once that session
//! was run, [`document`] lays them out.

mod cards;
mod conditions;
mod data;
mod document;
mod evaluate;
mod file;
mod free_response;
mod index;
mod judge;
mod pages;
mod profile;
mod snapshot;
mod trimmed;
mod units;

use serde::Serialize;

use crate::report::document::Figure;
use crate::verdict::Level;

pub use document::document;
pub use evaluate::{Judged, evaluate, judge, prepare};
pub use file::{Constants, DEVICE, ENGINEERING_DATA, Revision, TestEntry, TestFile};
pub use index::{IndexRow, IndexStatus};

/// Value of the `format` key of the results.
pub const FORMAT: &str = "doublet qualification";
/// Name of the guide and of its results, without ending.
pub const NAME: &str = "qtg";
/// Version of their layout.
pub const VERSION: u32 = 3;
/// Name of the campaign of the missing tests.
pub const CARDS: &str = "qtg_cards.toml";

/// What tests came to.
#[derive(Clone, Debug, Serialize)]
pub struct Qualification {
    pub format: &'static str,
    pub version: u32,
    /// Program and its version.
    pub app: String,
    /// Day, `YYYY-MM-DD`.
    pub date: String,
    /// Title of the guide.
    pub title: String,
    /// Aircraft of the session.
    pub aircraft: String,
    /// SHA-256 of the session in its saved form.
    pub session_sha256: String,
    pub rule: String,
    /// Date of its edition.
    pub edition: String,
    /// How sure the numbers of the rule are, in words.
    pub certainty: String,
    /// Constants and start of the flown model.
    pub constants: &'static str,
    /// What percentages of bands are of, in words.
    pub percent: &'static str,
    /// Whether 40 % of every tolerance applies.
    pub engineering_data: bool,
    /// Tests that passed.
    pub passed: usize,
    /// Tests that failed.
    pub failed: usize,
    /// Tests that could not be judged.
    pub not_judged: usize,
    /// Tests in their order.
    pub tests: Vec<QualificationTest>,
    /// Every test of the rule with what the guide has of it.
    pub index: Vec<IndexRow>,
}

impl Qualification {
    /// How many pass, fail and are not judged, in words.
    pub fn tally(&self) -> String {
        let Self { passed, failed, not_judged, tests, .. } = self;
        let in_part = tests.iter().filter(|test| test.outcome == Outcome::PassedInPart).count();
        let in_part = if in_part > 0 { format!(" ({in_part} in part)") } else { String::new() };
        let meant = tests.iter().filter(|test| test.model_changed && test.passed == Some(false)).count();
        let meant = if meant > 0 { format!(" ({meant} on purpose)") } else { String::new() };
        format!("{passed} of {} tests pass{in_part}, {failed} fail{meant}, {not_judged} are not judged", tests.len())
    }
}

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Every requirement is met.
    Passed,
    /// Every requirement of which the record has data is met, and another has none.
    PassedInPart,
    /// One is not, or the model cannot fly the record.
    Failed,
    /// The session has no window for it.
    NoRecording,
    /// The record is shorter than the rule asks for.
    RecordTooShort,
    /// The window could not be computed.
    NotComputed,
}

impl Outcome {
    doublet_core::variant_texts! {
        /// What the page says.
        pub label:
            Passed "PASS", PassedInPart "PASS IN PART", Failed "FAIL", NoRecording "NO RECORDING",
            RecordTooShort "RECORD TOO SHORT", NotComputed "NOT COMPUTED",
    }

    /// Whether it passed; none where it was not judged.
    pub fn passed(self) -> Option<bool> {
        match self {
            Self::Passed | Self::PassedInPart => Some(true),
            Self::Failed => Some(false),
            Self::NoRecording | Self::RecordTooShort | Self::NotComputed => None,
        }
    }

    /// How good that is.
    pub fn level(self) -> Level {
        match self {
            Self::Passed => Level::Good,
            Self::Failed => Level::Bad,
            Self::PassedInPart | Self::NoRecording | Self::RecordTooShort | Self::NotComputed => Level::Caution,
        }
    }
}

impl QualificationTest {
    /// Name of its section in the guide.
    pub fn section(&self) -> String {
        format!("test-{}", self.id)
    }

    /// Adds to its reason that the trim differs from the flight.
    fn add_reservation(&mut self, difference: Option<String>) {
        let Some(difference) = difference else { return };
        self.reason = format!("{}; {difference}", self.reason);
        self.page.is_reserved = true;
    }

    /// How good its outcome is: at most a caution where the trim of the model differs from the flight.
    pub fn level(&self) -> Level {
        let reserved = if self.page.is_reserved { Level::Caution } else { Level::Good };
        self.outcome.level().max(reserved)
    }
}

/// One test on one window.
#[derive(Clone, Debug, Serialize)]
pub struct QualificationTest {
    /// Number in the rule, with a running number behind it where several windows serve it.
    pub id: String,
    /// Number in the rule.
    pub rule_id: String,
    pub title: String,
    /// How sure its tolerance is.
    pub certainty: &'static str,
    /// Kind of test.
    pub kind: &'static str,
    /// Flight condition the test file states of its record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// Whether the model was changed on purpose, so that the test has to fail.
    pub model_changed: bool,
    /// What the record lacks of the rule though it is judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure: Option<String>,
    /// Manoeuvre.
    pub window: Option<String>,
    /// Whether it passed; none where it was not judged.
    pub passed: Option<bool>,
    /// How it ended.
    pub outcome: Outcome,
    /// Why, one line.
    pub reason: String,
    /// Bands over the record.
    pub channels: Vec<ChannelRow>,
    /// Single numbers.
    pub values: Vec<ValueRow>,
    /// Period and damping of the free response of flight and model, where they can be read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub oscillation: Vec<ValueRow>,
    /// Copy of the validation data: name of the file and its SHA-256.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<DataCopy>,
    /// What else stands on its page.
    #[serde(skip)]
    pub page: Page,
}

/// One band of a test over its record.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelRow {
    /// Requirement it belongs to, counted from 1: one band of each must hold.
    pub requirement: usize,
    pub parameter: &'static str,
    /// Tolerance in the units of the page.
    pub tolerance: String,
    /// SI unit of `worst`.
    pub unit: &'static str,
    /// Model less flight where the band is used most, SI.
    pub worst: f64,
    /// That over the half width there: up to 1 is inside.
    pub worst_ratio: f64,
    /// Time of it, s.
    pub worst_time_s: f64,
    /// Share of the samples inside.
    pub share_inside: f64,
    /// Whether the model stays inside throughout.
    pub passed: bool,
}

/// One number of a test.
#[derive(Clone, Debug, Serialize)]
pub struct ValueRow {
    /// Requirement it belongs to, counted from 1; 0 for a number that is not judged.
    pub requirement: usize,
    pub parameter: String,
    /// Tolerance in the units of the page; empty for a number that is not judged.
    pub tolerance: String,
    /// SI unit.
    pub unit: &'static str,
    /// Of the flight, SI; none where it is not given.
    pub flight: Option<f64>,
    /// Standard error of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flight_error: Option<f64>,
    /// Of the model, SI.
    pub model: Option<f64>,
    /// Standard error of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model_error: Option<f64>,
    /// Whether it is inside; none where one of the two is not given or nothing is asked.
    pub passed: Option<bool>,
}

/// A copy of the validation data of a test.
#[derive(Clone, Debug, Serialize)]
pub struct DataCopy {
    /// Name of the file beside the guide.
    pub name: String,
    /// SHA-256 of it.
    pub sha256: String,
    /// Contents.
    #[serde(skip)]
    pub text: String,
}

/// What stands on the page of a test beside its numbers.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Whether the trim of the model differs from the flight.
    pub is_reserved: bool,
    /// Facts above the result: objective, condition, procedures, evaluation.
    pub facts: Vec<(String, String)>,
    /// Initial conditions.
    pub initial: Vec<(String, String)>,
    /// Flight and model over each other.
    pub figure: Option<Figure>,
}
